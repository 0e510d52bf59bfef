/* three.js - a loader for three.js whose geometries are drawn while they arrive. SPDX-License-Identifier: MIT
 *
 *     const geometry = await new CQMLoader().loadAsync("bunny.cqm");      // its first kilobyte is there
 *     scene.add(new Mesh(geometry, new MeshStandardMaterial()));          // it refines by itself
 *     await geometry.loaded;                                              // the exact mesh, if you need to know
 *
 * Attributes are allocated once at full size; only what is new goes to the GPU. */
import { Box3, BufferAttribute, BufferGeometry, Loader, LoaderUtils, Sphere, Vector3 } from "three";
import { decode, startWorker } from "./conquest.js";

/** @typedef {import("./conquest.js").State} State */
/** @typedef {import("./conquest.js").Range} Range */
/** @typedef {import("./conquest.js").Attribute} Attribute */
/** @typedef {import("./conquest.js").Source} Source */
/** @typedef {import("three").PerspectiveCamera | import("three").OrthographicCamera} Camera */

/**
 * When a mesh is fine enough: so many vertices, an error in its own unit, or in pixels on a screen of that height. An
 * error
 * in pixels makes it wait, and go on when the camera comes nearer; the others end it.
 * @typedef {object} Goal
 * @property {number} [vertices]
 * @property {number} [error]
 * @property {number} [pixels]
 * @property {Camera} [camera]
 * @property {number} [height]     of the picture, in pixels
 * @property {import("three").Object3D} [object]  where the geometry is drawn; not given: as it is
 */

const NAMES = /** @type {Record<string, string>} */ ({
    positions: "position",
    normals: "normal",
    tangents: "tangent",
    texcoords: "uv",
    colors: "color",
    joints: "skinIndex",
    weights: "skinWeight",
});
const BUDGET = 4,
    WORKER_BUDGET = 16,
    MANY_RANGES = 256;

/** @param {string} name  texcoords_1 is uv1 */
function nameAttribute(name) {
    const [base, number = ""] = name.split("_");
    return NAMES[base] ? NAMES[base] + number : name;
}

/** Resolves when the next frame is drawn, or soon if none is. */
const nextFrame = () =>
    new Promise(resolve => {
        const timer = setTimeout(resolve, 100);
        requestAnimationFrame(() => {
            clearTimeout(timer);
            resolve(undefined);
        });
    });

/** What an error in the unit of a geometry is on the screen, in pixels. @param {number} error
 *  @param {BufferGeometry} geometry @param {Goal} view */
export function errorInPixels(error, geometry, { camera, height = 1, object }) {
    if (!camera || !geometry.boundingSphere) return NaN;
    const sphere = geometry.boundingSphere.clone();
    if (object) sphere.applyMatrix4(object.matrixWorld);
    const scaled = error * (object ? object.matrixWorld.getMaxScaleOnAxis() : 1);
    if ("isOrthographicCamera" in camera) return (scaled * height * camera.zoom) / (camera.top - camera.bottom);
    const at = new Vector3().setFromMatrixPosition(camera.matrixWorld);
    const distance = Math.max(camera.near, at.distanceTo(sphere.center) - sphere.radius);
    return (scaled * height * camera.zoom) / (2 * Math.tan((camera.fov * Math.PI) / 360) * distance);
}

/** A geometry that grows. */
export class ProgressiveGeometry extends BufferGeometry {
    type = "ProgressiveGeometry";
    /** @type {State | null} */
    state = null;
    /** @type {Promise<this>} resolves with the last refinement, and when it is stopped; rejects if the stream breaks, and
     *  with an AbortError if the loader is disposed before */
    loaded = new Promise(() => {});
    #stopped = new AbortController();

    /** Ends refining; what is there stays. */
    stop() {
        this.#stopped.abort();
    }

    /** Aborts when it is stopped. */
    get signal() {
        return this.#stopped.signal;
    }

    /** Takes what is new in a state. @param {State} state */
    grow(state) {
        for (const [name, from] of Object.entries(state.attributes).filter(([, a]) => !a.perFace)) {
            const key = nameAttribute(name);
            if (!this.hasAttribute(key)) this.setAttribute(key, new BufferAttribute(makeArray(from), from.itemSize));
            update(/** @type {BufferAttribute} */ (this.getAttribute(key)), from.array, from.ranges);
        }
        if (!this.index) this.setIndex(new BufferAttribute(state.index, 1));
        update(/** @type {BufferAttribute} */ (this.index), state.index, state.ranges);
        this.setDrawRange(0, state.numMaterials ? Infinity : 3 * state.numFaces);
        this.clearGroups();
        if (state.numMaterials) for (const g of state.groups) this.addGroup(g.start, g.count, g.material);
        this.#bound(state.attributes.positions);
        this.state = state;
    }

    /** @param {Attribute | undefined} positions */
    #bound(positions) {
        if (!positions) return;
        const box = (this.boundingBox ??= new Box3()),
            point = new Vector3();
        for (const { start, count } of positions.ranges)
            for (let i = start; i < start + count; i += 3) box.expandByPoint(point.fromArray(positions.array, i));
        this.boundingSphere = box.getBoundingSphere(new Sphere());
        this.userData.offset = positions.offset;
    }
}

/** An array that three.js draws: it takes 32-bit integers for shaders that have integers. @param {Attribute} a */
function makeArray({ array, bits }) {
    return array instanceof Float32Array ? array : new (bits <= 16 ? Uint16Array : Float32Array)(array.length);
}

/** @param {BufferAttribute} attribute @param {ArrayLike<number>} from @param {Range[]} ranges */
function update(attribute, from, ranges) {
    for (const { start, count } of ranges) {
        if (attribute.array !== from)
            attribute.array.set(/** @type {any} */ (from).subarray(start, start + count), start);
        attribute.addUpdateRange(start, count);
    }
    if (attribute.updateRanges.length > MANY_RANGES) {
        const start = Math.min(...attribute.updateRanges.map(r => r.start));
        const end = Math.max(...attribute.updateRanges.map(r => r.start + r.count));
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(start, end - start);
    }
    if (ranges.length) attribute.needsUpdate = true;
}

/** Loads conquest streams. @extends {Loader<ProgressiveGeometry, string>} */
export class CQMLoader extends Loader {
    /** @type {{ worker: Worker, users: number }[]} */
    #workers = [];
    #workerLimit = 1;
    /** @type {Goal} */
    #goal = {};
    #disposed = new AbortController();

    /** Called after each refinement; set it. @type {(geometry: ProgressiveGeometry, state: State) => void} */
    onRefine = () => {};

    /** Workers that decode; 0: none, a frame decodes for some milliseconds. @param {number} count */
    setWorkerLimit(count) {
        this.#workerLimit = count;
        return this;
    }

    /** @param {Goal} goal  with one of vertices, error and pixels; pixels need a camera */
    stopAt(goal) {
        const { vertices, error, pixels, camera } = goal ?? {};
        if (![vertices, error, pixels].some(Number.isFinite) || (pixels !== undefined && !camera))
            throw new TypeError("stopAt needs { vertices }, { error } or { pixels, camera, height }");
        this.#goal = goal;
        return this;
    }

    /**
     * Loads a file; `onLoad` gets the geometry when it can be drawn the first time.
     * @param {string} url
     * @param {(geometry: ProgressiveGeometry) => void} onLoad
     * @param {(event: ProgressEvent) => void} [onProgress]
     * @param {(error: unknown) => void} [onError]
     */
    load(url, onLoad, onProgress, onError) {
        const full = this.manager.resolveURL(LoaderUtils.resolveURL(url, this.path));
        const credentials = this.withCredentials ? "include" : "same-origin";
        this.manager.itemStart(full);
        const failed = (/** @type {unknown} */ error) => {
            (onError ?? console.error)(error);
            this.manager.itemError(full);
        };
        const { signal } = this.#disposed;
        const geometry = this.refine(fetch(full, { headers: this.requestHeader, credentials, signal }), onLoad, onProgress);
        geometry.loaded.catch(failed).finally(() => this.manager.itemEnd(full));
    }

    /**
     * Decodes bytes; `onLoad` gets the exact mesh.
     * @param {ArrayBuffer} buffer
     * @param {(geometry: ProgressiveGeometry) => void} onLoad
     * @param {(error: unknown) => void} [onError]
     */
    parse(buffer, onLoad, onError = console.error) {
        this.refine(buffer, () => {}).loaded.then(onLoad, onError);
    }

    /**
     * Makes a geometry that grows with its source; `onFirst` gets it when it can be drawn.
     * @param {Source | Promise<Source>} source
     * @param {(geometry: ProgressiveGeometry) => void} onFirst
     * @param {(event: ProgressEvent) => void} [onProgress]
     */
    refine(source, onFirst, onProgress) {
        const geometry = new ProgressiveGeometry();
        geometry.loaded = this.#run(geometry, source, onFirst, onProgress);
        geometry.loaded.catch(() => {});
        return geometry;
    }

    /** @param {ProgressiveGeometry} geometry @param {Source | Promise<Source>} source
     *  @param {(geometry: ProgressiveGeometry) => void} onFirst @param {(event: ProgressEvent) => void} [onProgress] */
    async #run(geometry, source, onFirst, onProgress) {
        const slot = this.#takeWorker(),
            goal = this.#goal,
            signal = AbortSignal.any([geometry.signal, this.#disposed.signal]);
        try {
            for await (const state of decode(source, {
                worker: slot?.worker,
                budget: slot ? WORKER_BUDGET : BUDGET,
                signal,
            })) {
                const isFirst = !geometry.state;
                geometry.grow(state);
                onProgress?.(
                    new ProgressEvent("progress", {
                        lengthComputable: true,
                        loaded: state.bytes,
                        total: state.totalBytes,
                    }),
                );
                if (isFirst) onFirst(geometry);
                this.onRefine(geometry, state);
                if (
                    state.numVertices >= (goal.vertices ?? Infinity) ||
                    state.error <= (goal.error ?? -1)
                )
                    break;
                if (!slot && !state.complete) await nextFrame();
                while (
                    !signal.aborted &&
                    !state.complete &&
                    errorInPixels(state.error, geometry, goal) <= (goal.pixels ?? -1)
                )
                    await nextFrame();
            }
        } catch (error) {
            if (!geometry.signal.aborted) throw error;
        } finally {
            if (slot) slot.users--;
        }
        return geometry;
    }

    #takeWorker() {
        if (this.#workers.length < this.#workerLimit && this.#workers.every(w => w.users > 0))
            this.#workers.push({ worker: startWorker(), users: 0 });
        const slot = this.#workerLimit > 0 ? this.#workers.reduce((a, b) => (b.users < a.users ? b : a)) : undefined;
        if (slot) slot.users++;
        return slot;
    }

    /** Ends the workers, and with an AbortError what still loads. */
    dispose() {
        this.#disposed.abort(new DOMException("the loader was disposed", "AbortError"));
        this.#disposed = new AbortController();
        this.#workers.forEach(w => w.worker.terminate());
        this.#workers = [];
        return this;
    }
}
