/* three-gltf.js - CONQUEST_mesh_progressive for the GLTFLoader of three.js. SPDX-License-Identifier: MIT
 *
 *     const gltf = await loadProgressive("a.glb", new GLTFLoader());      // scene and textures are there, meshes begin
 *     scene.add(gltf.scene);
 *     await gltf.userData.loaded;                                         // all meshes are exact
 *
 * Any GLTFLoader reads such files when they are whole: loader.register(parser => new ConquestGLTFPlugin(parser)). */
import { decode } from "./conquest.js";

export const NAME = "CONQUEST_mesh_progressive";
const GLB = 0x46546c67,
    JSON_CHUNK = 0x4e4f534a,
    HEADER = 12,
    CHUNK = 8;

/** @typedef {import("./conquest.js").State} State */
/** @typedef {import("./conquest.js").Range} Range */
/** @typedef {import("three").BufferGeometry} BufferGeometry */
/** @typedef {import("three").BufferAttribute} BufferAttribute */

/** @param {string} key  an attribute of glTF */
function nameAttribute(key) {
    const [, base, number = "0"] = /** @type {RegExpExecArray} */ (/^(.*?)(?:_(\d+))?$/.exec(key)),
        n = Number(number);
    const names = /** @type {Record<string, string>} */ ({
        POSITION: "position",
        NORMAL: "normal",
        TANGENT: "tangent",
        JOINTS: "skinIndex",
        WEIGHTS: "skinWeight",
        TEXCOORD: n ? `uv${n}` : "uv",
        COLOR: n ? `color_${n}` : "color",
    });
    return names[base] ?? key.toLowerCase();
}

/** @param {BufferAttribute} attribute @param {ArrayLike<number>} from @param {Range[]} ranges */
function update(attribute, from, ranges) {
    const isFloat = attribute.array instanceof Float32Array;
    for (const { start, count } of ranges) {
        for (let i = start; i < start + count; i++) attribute.array[i] = isFloat ? from[i] : Math.round(from[i]);
        attribute.addUpdateRange(start, count);
    }
    if (ranges.length) attribute.needsUpdate = true;
}

/** Fills a geometry, whose attributes are there and empty, from a stream. @param {BufferGeometry} geometry
 *  @param {Record<string, number>} attributes @param {State} state */
function fill(geometry, attributes, state) {
    const channels = Object.values(state.attributes);
    for (const [key, channel] of Object.entries(attributes)) {
        const [name, target] = key.split(":"),
            { array, ranges } = channels[channel];
        const morphs = /** @type {Record<string, BufferAttribute[]>} */ (geometry.morphAttributes);
        const at =
            target === undefined
                ? geometry.getAttribute(nameAttribute(name))
                : morphs[nameAttribute(name)][Number(target)];
        update(/** @type {BufferAttribute} */ (at), array, ranges);
    }
    update(/** @type {BufferAttribute} */ (geometry.index), state.index, state.ranges);
    geometry.setDrawRange(0, 3 * state.numFaces);
    if (state.complete && Object.keys(geometry.morphAttributes).length) geometry.dispose(); // it is made once
}

/** A plugin for GLTFLoader. */
export class ConquestGLTFPlugin {
    name = NAME;

    /** @param {any} parser @param {(view: number) => any} [source]  where the bytes of a buffer view come from; not
     * given: the file
     *  @param {(geometry: BufferGeometry, state: State) => void} [onRefine] */
    constructor(parser, source = view => parser.getDependency("bufferView", view), onRefine = () => {}) {
        this.parser = parser;
        this.source = source;
        this.onRefine = onRefine;
    }

    /** @param {any} gltf */
    async afterRoot(gltf) {
        const { json, associations } = this.parser,
            geometries = new Map();
        for (const [object, { meshes = -1, primitives = 0 } = {}] of associations)
            if (object.isMesh && meshes >= 0)
                geometries.set(json.meshes[meshes].primitives[primitives], object.geometry);
        const jobs = [...geometries]
            .filter(([primitive]) => primitive.extensions?.[NAME])
            .sort((a, b) => a[0].extensions[NAME].bufferView - b[0].extensions[NAME].bufferView)
            .map(([primitive, geometry]) => ({ geometry, ...primitive.extensions[NAME] }));
        jobs.forEach(({ geometry }) => geometry.setDrawRange(0, 0));
        const run = async () => {
            for (const job of jobs) await this.#refine(job);
        };
        const loaded = run();
        loaded.catch(() => {});
        gltf.userData = { ...gltf.userData, loaded };
    }

    /** @param {{ geometry: BufferGeometry, bufferView: number, attributes: Record<string, number> }} job */
    async #refine({ geometry, bufferView, attributes }) {
        for await (const state of decode(this.source(bufferView), {
            worker: typeof Worker !== "undefined",
            budget: 16,
        })) {
            fill(geometry, attributes, state);
            this.onRefine(geometry, state);
        }
    }
}

/** Bytes of a stream on demand. */
class Reader {
    #pieces;
    #held = new Uint8Array(0);

    /** @param {ReadableStream<Uint8Array>} stream */
    constructor(stream) {
        this.#pieces = stream.getReader();
    }

    /** Up to `most` bytes, at least one; none at the end. @param {number} most */
    async some(most) {
        if (!this.#held.length)
            this.#held = /** @type {any} */ ((await this.#pieces.read()).value ?? new Uint8Array(0));
        const part = this.#held.subarray(0, most);
        this.#held = this.#held.subarray(part.length);
        return part;
    }

    /** @param {number} count */
    async all(count) {
        const bytes = new Uint8Array(count);
        for (let at = 0; at < count;) {
            const part = await this.some(count - at);
            if (!part.length) throw new Error("the file ends early");
            bytes.set(part, at);
            at += part.length;
        }
        return bytes;
    }
}

/** @param {Reader} reader @param {number} size */
async function* take(reader, size) {
    for (let left = size; left > 0;) {
        const part = await reader.some(left);
        if (!part.length) return;
        left -= part.length;
        yield part;
    }
}

/**
 * Loads a .glb whose streams are at its end: resolves when all before them is there, and refines while they arrive.
 * @param {string} url
 * @param {any} loader  a GLTFLoader
 * @param {(geometry: BufferGeometry, state: State) => void} [onRefine]
 */
export async function loadProgressive(url, loader, onRefine) {
    const response = await fetch(url);
    if (!response.ok || !response.body) throw new Error(`${url}: ${response.status} ${response.statusText}`);
    const reader = new Reader(response.body),
        start = await reader.all(HEADER + CHUNK),
        words = new DataView(start.buffer);
    if (words.getUint32(0, true) !== GLB || words.getUint32(16, true) !== JSON_CHUNK)
        throw new Error(`${url} is no .glb`);
    const text = await reader.all(words.getUint32(12, true)),
        json = JSON.parse(new TextDecoder().decode(text));
    const streams = /** @type {number[]} */ (
        [
            ...new Set(
                (json.meshes ?? [])
                    .flatMap((/** @type {any} */ m) => m.primitives)
                    .map((/** @type {any} */ p) => p.extensions?.[NAME]?.bufferView)
                    .filter((/** @type {any} */ v) => v !== undefined),
            ),
        ].sort((a, b) => a - b)
    );
    const offset = (/** @type {number} */ view) => json.bufferViews[view].byteOffset ?? 0;
    const chunk = await reader.all(CHUNK),
        size = new DataView(chunk.buffer).getUint32(0, true);
    const before = streams.length ? Math.min(size, offset(streams[0])) : size,
        binary = await reader.all(before);
    new DataView(chunk.buffer).setUint32(0, before, true);
    words.setUint32(8, HEADER + 2 * CHUNK + text.length + before, true);
    const whole = await new Blob([start, text, chunk, binary]).arrayBuffer();
    let at = before;
    const source = async function* (/** @type {number} */ view) {
        await reader.all(offset(view) - at);
        at = offset(view) + json.bufferViews[view].byteLength;
        yield* take(reader, json.bufferViews[view].byteLength);
    };
    loader.register((/** @type {any} */ parser) => new ConquestGLTFPlugin(parser, source, onRefine));
    return loader.parseAsync(whole, url.replace(/[^/]*$/, ""));
}
