/* three-gltf.js - CONQUEST_mesh_progressive for the GLTFLoader of three.js. SPDX-License-Identifier: MIT
 *
 *     const gltf = await loadProgressive("a.glb", new GLTFLoader());      // scene and textures are there, meshes begin
 *     scene.add(gltf.scene);
 *     await gltf.userData.loaded;                                         // all meshes are exact
 *
 * From a server that knows HTTP ranges, loadProgressive(url, loader, { ranges: true }) gets some bytes of each mesh first.
 * Any GLTFLoader reads such files when they are whole: loader.register(parser => new ConquestGLTFPlugin(parser)). */
import { BufferAttribute } from "three";
import { decode, startWorker } from "./conquest.js";
import { NAME, checkPrimitive, need } from "./gltf.js";

export { NAME };
const GLB = 0x46546c67,
    JSON_CHUNK = 0x4e4f534a,
    HEADER = 12,
    CHUNK = 8,
    HEAD_RANGE = 16384,
    FIRST_RANGE = 1024, // of a stream; each further one is four times as long
    SIDE_BY_SIDE = 32; // decoders, as a browser has room for some hundred memories

/** @typedef {import("./conquest.js").State} State */
/** @typedef {import("./conquest.js").Range} Range */
/** @typedef {import("three").BufferGeometry} BufferGeometry */
/** @typedef {import("three/addons/loaders/GLTFLoader.js").GLTFLoader} GLTFLoader */
/** @typedef {import("three/addons/loaders/GLTFLoader.js").GLTFParser} GLTFParser */
/** @typedef {import("three/addons/loaders/GLTFLoader.js").GLTF} GLTF */
/** @typedef {GLTF & { userData: { loaded: Promise<void> } }} ProgressiveGLTF  `loaded`: all meshes are exact */

/**
 * Called after each refinement; what returns false ends it, and no more bytes of that mesh are asked for.
 * @typedef {(geometry: BufferGeometry, state: State) => boolean | void} OnRefine
 */

/**
 * Bytes of a file: the scene, as a .glb whose streams are left out, and each stream.
 * @typedef {object} File
 * @property {ArrayBuffer} scene
 * @property {(view: number) => AsyncIterable<Uint8Array>} stream  of a buffer view
 * @property {boolean} anyOrder  streams may be read side by side; else in the order of the file
 */

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

/** Copies ranges, to where they are less `shift`. @param {BufferAttribute} attribute @param {ArrayLike<number>} from
 *  @param {Range[]} ranges @param {number} [shift] */
function update(attribute, from, ranges, shift = 0) {
    const isFloat = attribute.array instanceof Float32Array;
    for (const { start, count } of ranges) {
        for (let i = start; i < start + count; i++) attribute.array[i - shift] = isFloat ? from[i] : Math.round(from[i]);
        attribute.addUpdateRange(start - shift, count);
    }
    if (ranges.length) attribute.needsUpdate = true;
}

/**
 * A primitive that a stream fills.
 * @typedef {{ geometry: BufferGeometry, bufferView: number, attributes: Record<string, number>, group?: number }} Part
 */

/** Fills a geometry, whose attributes are there and empty. @param {Part} part @param {State} state
 *  @param {Set<BufferAttribute>} done  attributes that have all of this state: primitives share them */
function fill({ geometry, attributes, group = 0 }, state, done) {
    const channels = Object.values(state.attributes),
        morphs = /** @type {Record<string, BufferAttribute[]>} */ (geometry.morphAttributes);
    checkPrimitive(state, { attributes, group });
    for (const [key, channel] of Object.entries(attributes)) {
        const [name, target] = key.split(":"),
            { array, ranges } = channels[channel];
        const at = /** @type {BufferAttribute} */ (
            target === undefined
                ? geometry.getAttribute(nameAttribute(name))
                : morphs[nameAttribute(name)]?.[Number(target)]
        );
        if (!done.has(at)) update(need(at, key), array, ranges);
        done.add(at);
    }
    let end = 0;
    for (const { start, count, material } of state.groups) {
        if (material !== group) continue;
        const inside = state.ranges
            .map(r => [Math.max(r.start, start), Math.min(r.start + r.count, start + count)])
            .flatMap(([from, to]) => (to > from ? [{ start: from, count: to - from }] : []));
        update(/** @type {BufferAttribute} */ (geometry.index), state.index, inside, start - end);
        end += count;
    }
    geometry.setDrawRange(0, end);
    if (state.complete && Object.keys(morphs).length) geometry.dispose(); // it is made once
}

/** Attributes that lie interleaved, as those of a fallback may, become arrays of their own. Primitives that share one share
 *  what it becomes, too. @param {BufferGeometry} geometry @param {Map<any, BufferAttribute>} owned */
function separate(geometry, owned) {
    const own = (/** @type {any} */ attribute) => {
        if (!attribute.isInterleavedBufferAttribute) return attribute;
        const { array, count, itemSize, normalized } = attribute;
        if (!owned.has(attribute))
            owned.set(attribute, new BufferAttribute(new array.constructor(count * itemSize), itemSize, normalized));
        return owned.get(attribute);
    };
    for (const [name, attribute] of Object.entries(geometry.attributes)) geometry.setAttribute(name, own(attribute));
    for (const all of Object.values(geometry.morphAttributes)) all?.forEach((attribute, k) => (all[k] = own(attribute)));
}

/** A plugin for GLTFLoader. */
export class ConquestGLTFPlugin {
    name = NAME;

    /** @param {GLTFParser} parser
     *  @param {{ source?: (view: number) => any, anyOrder?: boolean, onRefine?: OnRefine }} [options]  `source`: where the
     *  bytes of a buffer view come from; not given: the file */
    constructor(parser, { source, anyOrder = false, onRefine = () => {} } = {}) {
        this.parser = parser;
        this.source = source ?? (view => parser.getDependency("bufferView", view));
        this.anyOrder = anyOrder;
        this.onRefine = onRefine;
    }

    /** @param {GLTF} gltf */
    async afterRoot(gltf) {
        const { json, associations } = /** @type {any} */ (this.parser),
            geometries = new Map(),
            owned = new Map();
        for (const [object, { meshes = -1, primitives = 0 } = {}] of associations)
            if (object.isMesh && meshes >= 0)
                geometries.set(json.meshes[meshes].primitives[primitives], object.geometry);
        const parts = /** @type {Map<number, Part[]>} */ (new Map());
        for (const [{ extensions }, geometry] of geometries) {
            const found = extensions?.[NAME];
            if (!found) continue;
            parts.set(found.bufferView, [...(parts.get(found.bufferView) ?? []), { geometry, ...found }]);
            separate(geometry, owned);
            geometry.setDrawRange(0, 0);
        }
        const loaded = this.#refineAll([...parts].sort((a, b) => a[0] - b[0]).map(([, all]) => all));
        loaded.catch(() => {});
        gltf.userData = { ...gltf.userData, loaded };
    }

    /** @param {Part[][]} streams */
    async #refineAll(streams) {
        const worker = streams.length && typeof Worker !== "undefined" ? startWorker() : undefined;
        try {
            const queue = streams.values(),
                lane = async () => {
                    for (const parts of queue) await this.#refine(parts, worker);
                };
            await Promise.all(Array.from({ length: this.anyOrder ? SIDE_BY_SIDE : 1 }, lane));
        } finally {
            worker?.terminate();
        }
    }

    /** @param {Part[]} parts @param {Worker} [worker] */
    async #refine(parts, worker) {
        for await (const state of decode(this.source(parts[0].bufferView), { worker, budget: 16 })) {
            const done = new Set();
            parts.forEach(part => fill(part, state, done));
            const wanted = parts.filter(({ geometry }) => this.onRefine(geometry, state) !== false);
            if (!wanted.length) return;
        }
    }
}

/** Pieces of a response. @param {Response} response */
async function* readResponse(response) {
    if (!response.ok || !response.body)
        throw new Error(`${response.url}: ${response.status} ${response.statusText}`);
    const reader = response.body.getReader();
    try {
        for (let r = await reader.read(); !r.done; r = await reader.read()) yield r.value;
    } finally {
        await reader.cancel().catch(() => {});
    }
}

/** Bytes on demand. */
class Reader {
    #pieces;
    #held = new Uint8Array(0);

    /** @param {AsyncIterator<Uint8Array>} pieces */
    constructor(pieces) {
        this.#pieces = pieces;
    }

    /** Up to `most` bytes, at least one; none at the end. @param {number} most */
    async some(most) {
        if (!this.#held.length)
            this.#held = /** @type {any} */ ((await this.#pieces.next()).value ?? new Uint8Array(0));
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

/** Reads the start of a .glb, up to its first binary byte. @param {Reader} reader @param {string} url */
async function readStart(reader, url) {
    const start = await reader.all(HEADER + CHUNK),
        words = new DataView(start.buffer);
    if (words.getUint32(0, true) !== GLB || words.getUint32(16, true) !== JSON_CHUNK)
        throw new Error(`${url} is no .glb`);
    const text = await reader.all(words.getUint32(12, true)),
        chunk = await reader.all(CHUNK),
        json = JSON.parse(new TextDecoder().decode(text));
    const views = (json.meshes ?? [])
        .flatMap((/** @type {any} */ m) => m.primitives)
        .map((/** @type {any} */ p) => p.extensions?.[NAME]?.bufferView)
        .filter((/** @type {any} */ v) => v !== undefined);
    const streams = /** @type {number[]} */ ([...new Set(views)])
        .map(view => ({ view, offset: json.bufferViews[view].byteOffset ?? 0, size: json.bufferViews[view].byteLength }))
        .sort((a, b) => a.offset - b.offset);
    return { start, text, chunk, streams, size: new DataView(chunk.buffer).getUint32(0, true) };
}

/** A .glb with less in its binary chunk. @param {Awaited<ReturnType<typeof readStart>>} parts
 *  @param {Uint8Array<ArrayBuffer>} binary */
function assemble({ start, text, chunk }, binary) {
    new DataView(start.buffer).setUint32(8, HEADER + 2 * CHUNK + text.length + binary.length, true);
    new DataView(chunk.buffer).setUint32(0, binary.length, true);
    return new Blob([start, text, chunk, binary]).arrayBuffer();
}

/** A file as it arrives: what comes before the first stream, then the streams. @param {Response} response
 *  @param {string} url @returns {Promise<File>} */
async function openWhole(response, url) {
    const reader = new Reader(readResponse(response)),
        parts = await readStart(reader, url);
    const before = Math.min(parts.size, parts.streams[0]?.offset ?? parts.size),
        scene = await assemble(parts, await reader.all(before));
    let at = before;
    const stream = async function* (/** @type {number} */ view) {
        const { offset, size } = /** @type {any} */ (parts.streams.find(s => s.view === view));
        await reader.all(offset - at);
        for (at = offset; at < offset + size;) {
            const piece = await reader.some(offset + size - at);
            if (!piece.length) return;
            at += piece.length;
            yield piece;
        }
    };
    return { scene, stream, anyOrder: false };
}

/** Parts of a file, all of the same version of it. @param {string} url */
function makeRequests(url) {
    /** @type {string | null | undefined} */
    let version;
    return async (/** @type {number} */ from, /** @type {number} */ end) => {
        const response = await fetch(url, { headers: { Range: `bytes=${from}-${end - 1}` } }),
            tag = response.headers.get("etag");
        if (tag !== (version ??= tag)) throw new Error(`${url} has changed`);
        return response;
    };
}

/** A file in parts: scene and streams may lie anywhere in it. A server that does not know ranges sends it whole.
 *  @param {string} url @returns {Promise<File>} */
async function openRanges(url) {
    const request = makeRequests(url),
        response = await request(0, HEAD_RANGE);
    if (response.status !== 206) return openWhole(response, url);
    const total = Number(/[/](\d+)$/.exec(response.headers.get("content-range") ?? "")?.[1]),
        head = new Uint8Array(await response.arrayBuffer());
    const read = async function* (/** @type {number} */ from, /** @type {number} */ end, size = end - from) {
        let at = Math.min(end, Math.max(from, head.length));
        if (from < at) yield head.subarray(from, at);
        for (; at < end; size *= 4) {
            const part = await request(at, Math.min(end, at + size));
            if (part.status !== 206) throw new Error(`${url}: ${part.status} ${part.statusText}, not a part of it`);
            for await (const piece of readResponse(part)) {
                at += piece.length;
                yield piece;
            }
        }
    };
    const start = read(0, total, HEAD_RANGE),
        parts = await readStart(new Reader(start), url);
    await start.return(undefined);
    const first = HEADER + 2 * CHUNK + parts.text.length,
        binary = new Uint8Array(parts.size);
    let at = 0;
    const rest = [...parts.streams, { offset: parts.size, size: 0 }].flatMap(({ offset, size }) => {
        const gap = { from: at, size: offset - at };
        at = offset + size;
        return gap.size >= 4 ? [gap] : []; // less is padding
    });
    await Promise.all(
        rest.map(async ({ from, size }) =>
            binary.set(await new Reader(read(first + from, first + from + size)).all(size), from),
        ),
    );
    const stream = (/** @type {number} */ view) => {
        const { offset, size } = /** @type {any} */ (parts.streams.find(s => s.view === view));
        return read(first + offset, first + offset + size, FIRST_RANGE);
    };
    return { scene: await assemble(parts, binary), stream, anyOrder: true };
}

/**
 * Loads a .glb whose streams are at its end: resolves when all before them is there, and refines while they arrive.
 * @param {string} url
 * @param {GLTFLoader} loader
 * @param {{ onRefine?: OnRefine, ranges?: boolean }} [options]  `ranges`: get the streams side by side by HTTP range
 *  requests, wherever they are in the file
 * @returns {Promise<ProgressiveGLTF>}
 */
export async function loadProgressive(url, loader, { onRefine, ranges = false } = {}) {
    const file = ranges ? await openRanges(url) : await openWhole(await fetch(url), url);
    const plugin = (/** @type {GLTFParser} */ parser) =>
        new ConquestGLTFPlugin(parser, { source: file.stream, anyOrder: file.anyOrder, onRefine });
    loader.register(plugin);
    try {
        return /** @type {any} */ (await loader.parseAsync(file.scene, url.replace(/[^/]*$/, "")));
    } finally {
        loader.unregister(plugin);
    }
}
