/* conquest.js - progressive meshes in a browser or in node: decodes while bytes arrive, and encodes. No dependencies.
 * SPDX-License-Identifier: MIT
 *
 *     import { decode } from "conquest-mesh";
 *     for await (const mesh of decode(await fetch("bunny.cqm"), { budget: 4 }))
 *         draw(mesh.attributes.positions.array, mesh.index, 3 * mesh.numFaces);
 *
 * Arrays are views of the decoder's memory, with room for the whole mesh: they are allocated once and grow at their
 * end.
 * Of vertices those that are there never change; `ranges` tells what is new for a GPU. */
import decoderCode from "./decoder.wasm.js";

/** @typedef {{ start: number, count: number }} Range  Elements of a typed array, so that a GPU gets only these. */
/** @typedef {Float32Array | Int32Array | Uint32Array} Numbers */
/** @typedef {ArrayBuffer | ArrayBufferView | Blob | Response | ReadableStream<Uint8Array> | AsyncIterable<Uint8Array>
 * | Iterable<Uint8Array> | string | URL} Source
 *  A stream, all of its bytes, or where it is. */

/** @typedef {{ start: number, count: number, material: number }} Group  Elements of the index for one draw call. */

/**
 * One attribute of a mesh.
 * @typedef {object} Attribute
 * @property {Numbers} array      numbers for each vertex, or face, with room for all of the mesh
 * @property {number} itemSize    numbers for each
 * @property {boolean} perFace    of faces, in the order of the index; else of vertices
 * @property {number[]} offset    to be added: not zero where floats are too coarse for the sum, as for a survey grid
 * @property {number} bits        of the numbers in the stream
 * @property {Range[]} ranges     elements of `array` that are new since the last state
 */

/**
 * A mesh of some moment.
 * @typedef {object} State
 * @property {number} numVertices       vertices that are there, as a GPU counts them: several where a seam runs
 * @property {number} numFaces
 * @property {number} totalVertices     of the whole mesh
 * @property {number} totalFaces
 * @property {Uint32Array} index        three vertices for each face, with room for all faces
 * @property {Group[]} groups           which elements of `index` are to be drawn; without materials the first 3 * numFaces
 * @property {number} numMaterials      0: there are none
 * @property {Range[]} ranges           elements of `index` that are new since the last state
 * @property {Record<string, Attribute>} attributes  positions, normals, tangents, texcoords, colors, joints, weights,
 *                                      numbers, groups, facegroups, generic; a second one is called normals_1
 * @property {number} level             levels begun
 * @property {number} error             no vertex of the whole mesh is further away, in the unit of the positions; NaN:
 *                                      not known
 * @property {number} bytes             of the stream that were decoded
 * @property {number} totalBytes        of the whole stream
 * @property {boolean} complete         is it the mesh that was encoded?
 * @property {Uint8Array} metadata      bytes that travel with the mesh, when it is complete
 */

/**
 * A Worker of node:worker_threads.
 * @typedef {object} NodeWorker
 * @property {(message: any, transfer?: any[]) => void} postMessage
 * @property {(event: string, listener: (value: any) => void) => unknown} on
 * @property {(event: string, listener: (value: any) => void) => unknown} off
 * @property {() => unknown} terminate
 */

/**
 * @typedef {object} Options
 * @property {number} [budget]          milliseconds that a step may take; not given: all that has arrived at once
 * @property {WebAssembly.Memory} [memory]  to decode in; it grows to what the mesh needs. Not together with a worker
 * @property {number} [maxMemory]       bytes that a stream may ask for; 1 GiB
 * @property {boolean} [partial]        a stream that ends early is no error
 * @property {boolean | Worker | NodeWorker} [worker]  decode in a worker: one of its own, or one of worker.js that serves
 *                                      several
 * @property {AbortSignal} [signal]     stops
 */

/** Results of conquest.h. */
export const OK = 0,
    NEED_INPUT = 1,
    DONE = 2,
    TRUNCATED = 3,
    MORE = 4,
    ERROR_MEMORY = -2,
    ERROR_UNSUPPORTED = -14;

const COPY = 1,
    PER_FACE = 2,
    EXACT_BITS = 32,
    MAX_BITS = 24,
    MAX_HEADER_BYTES = 512,
    MAX_CHANNELS = 16;
const PAGE = 65536,
    OWN_PAGES = 3,
    INPUT_BYTES = 65536,
    BLOCK = 64,
    NONE = 0xffffffff,
    NO_LIMIT = 0xffffffff;

/** Steps between two looks at the clock: some tenths of a millisecond. */
const STEPS = 128;

/** Longer streams are worth the full decoder, and up to so many bytes of them are decoded again for it: some
 * milliseconds. */
const WORTH_FULL = 16384;

/** What attributes there are: their numbers in a stream, how they are predicted, bits unless the caller says others. */
const KINDS = [
    { name: "positions", kind: 0, merge: 0, components: [3], bits: 12 },
    { name: "generic", kind: 1, merge: 0, components: [1, 2, 3, 4], bits: 12 },
    { name: "normals", kind: 2, merge: 0, components: [3], bits: 10 },
    { name: "tangents", kind: 10, merge: 0, components: [4], bits: 12 },
    { name: "texcoords", kind: 3, merge: 0, components: [2], bits: 12 },
    { name: "colors", kind: 4, merge: 0, components: [3, 4], bits: 8, unit: true },
    { name: "joints", kind: 5, merge: COPY, components: [1, 2, 3, 4], bits: 0 },
    { name: "weights", kind: 6, merge: 0, components: [1, 2, 3, 4], bits: 12, unit: true },
    { name: "numbers", kind: 7, merge: COPY, components: [1], bits: 0 },
    { name: "groups", kind: 8, merge: COPY, components: [1], bits: 0 },
    { name: "facegroups", kind: 8, merge: PER_FACE, components: [1], bits: 0 },
    { name: "turned", kind: 9, merge: PER_FACE, components: [], bits: 0 },
];

// -- Errors --

/** The bytes are no stream, or corrupt, or need more memory than they may have. */
export class StreamError extends Error {
    /** @param {string} message @param {number} result of conquest.h @param {number} byte bytes decoded before */
    constructor(message, result, byte) {
        super(`${message} (byte ${byte})`);
        this.name = "StreamError";
        this.result = result;
        this.byte = byte;
    }
}

/** The stream ended early: the mesh is a coarser one, and valid. */
export class TruncatedError extends StreamError {
    /** @param {string} message @param {number} byte */
    constructor(message, byte) {
        super(message, TRUNCATED, byte);
        this.name = "TruncatedError";
    }
}

/**
 * The mesh cannot be encoded; `face`, `vertex` and `other`, the second vertex of an edge, are undefined or say where.
 */
export class MeshError extends Error {
    /** @param {string} message @param {number} result @param {(number | undefined)[]} place */
    constructor(message, result, [face, vertex, other] = []) {
        const where = Object.entries({ face, vertex, other }).filter(([, n]) => n !== undefined);
        super(message + (where.length ? ` (${where.map(([name, n]) => `${name} ${n}`).join(", ")})` : ""));
        this.name = "MeshError";
        this.result = result;
        this.face = face;
        this.vertex = vertex;
        this.other = other;
    }
}

// -- WebAssembly --

/** @param {string} base64 */
function compile(base64) {
    const text = atob(base64),
        bytes = new Uint8Array(text.length);
    for (let k = 0; k < bytes.length; k++) bytes[k] = text.charCodeAt(k);
    return WebAssembly.compile(bytes);
}

/** @type {Promise<WebAssembly.Module> | undefined} the small decoder */
let decoderModule;

/** The full decoder, for all streams and compiled for speed; undefined until it is there.
 * @type {WebAssembly.Module | undefined} */
let fullModule;

/** @type {Promise<WebAssembly.Module> | undefined} */
let fullOpening;

function openFull() {
    fullOpening ??= import("./full.wasm.js").then(m => compile(m.default)).then(module => (fullModule = module));
    fullOpening.catch(() => (fullOpening = undefined)); // the next one tries again
    return fullOpening;
}

/** @param {WebAssembly.Memory} memory @param {number} at  of a string that ends in zero */
function readString(memory, at) {
    const bytes = new Uint8Array(memory.buffer, at);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
}

// -- Decoder --

/** Names of channels: the second one of a kind has a number. @param {{ kind: number, merge: number }[]} channels */
function nameChannels(channels) {
    /** @type {Map<string, number>} */
    const seen = new Map();
    return channels.map(c => {
        const perFace = c.merge === PER_FACE;
        const known = KINDS.find(k => k.kind === c.kind && (k.name !== "groups" || !perFace)) ?? KINDS[1];
        const count = seen.get(known.name) ?? 0;
        seen.set(known.name, count + 1);
        return count ? `${known.name}_${count}` : known.name;
    });
}

/** Words of web_state and web_channel in decoder.c, in their order. */
const [
    ,
    USED,
    ROWS,
    FACES,
    TOTAL_ROWS,
    TOTAL_FACES,
    LEVEL,
    ERROR,
    ,
    STREAM,
    CHANNELS,
    MEMORY,
    READY,
    ,
    SLOTS,
    MATERIALS,
    GROUPS,
    GROUP,
    INDEX,
    FACE_BLOCKS,
    ROW_BLOCKS,
    METADATA,
    METADATA_BYTES,
    STATE_WORDS,
] = Array(24).keys();
const [KIND, , BITS, MERGE, STEP, ORIGIN, , , , ARRAY, WIDTH, IS_INTEGER, IS_RELATIVE, MOVES, CHANNEL_WORDS] =
    Array(15).keys();

/**
 * Decodes one stream: feed() pieces, decode(), look at state().
 *
 * The small decoder begins. Long streams go on with the full one as soon as that is there, others when they come to what
 * only it knows. It has the same memory, with all arrays where they are, and decodes again what has been decoded.
 */
export class Decoder {
    #memory;
    /** @type {any} */
    #wasm;
    #isFull = false;
    #isSeen = false;
    #result = NEED_INPUT;
    /** @type {Uint8Array[]} to be decoded */
    #pieces = [];
    /** @type {Uint8Array[]} all that came, for the full decoder */
    #kept = [];
    #headerBytes = 0;
    #open = false;
    #rows = 0;
    #faces = 0;
    /** @type {(Attribute & { name: string })[]} */
    #attributes = [];
    /** @type {Uint32Array<ArrayBufferLike>} */
    #words = new Uint32Array(0);

    /** @param {WebAssembly.Memory} memory */
    constructor(memory) {
        this.#memory = memory;
    }

    /** @param {Options} [options] */
    static async create({ memory, maxMemory = 2 ** 30 } = {}) {
        const maximum = Math.min(65536, Math.ceil(maxMemory / PAGE) + OWN_PAGES);
        const own = memory ?? new WebAssembly.Memory({ initial: OWN_PAGES, maximum });
        if (own.buffer.byteLength < OWN_PAGES * PAGE) own.grow(OWN_PAGES - own.buffer.byteLength / PAGE);
        const decoder = new Decoder(own);
        decoder.#load(fullModule ?? (await (decoderModule ??= compile(decoderCode))));
        return decoder;
    }

    /**
     * One more piece of the stream, of any size. It is kept: do not change it.
     * @param {Uint8Array} piece
     */
    async feed(piece) {
        if (!piece.length) return;
        this.#pieces.push(piece);
        if (!this.#isFull) this.#kept.push(piece);
        if (this.#open) return;
        this.#begin();
        if (this.#lacksFull) this.#goOn(await openFull());
        if (this.#words[STREAM] > WORTH_FULL && !this.#isFull) openFull().catch(() => {}); // the small one can do without
    }

    /**
     * Decodes what has arrived.
     * @param {number} [milliseconds]  that it may take; it also ends when there is something to be seen for the first
     *                                 time
     * @returns {Promise<boolean>} can more be decoded without another piece?
     */
    async decode(milliseconds = Infinity) {
        if (fullModule && !this.#isFull && this.#open && this.#words[USED] < WORTH_FULL) this.#goOn(fullModule);
        const more = this.#run(milliseconds);
        if (!this.#lacksFull) return more;
        this.#goOn(await openFull());
        return this.#run(milliseconds);
    }

    /** Says that no more will come. Throws a TruncatedError if the stream has not ended. */
    async finish() {
        await this.decode();
        this.#end();
    }

    #end() {
        if (this.#result === DONE) return;
        this.#check(this.#open ? this.#wasm.finish() : TRUNCATED);
    }

    /** @param {number} milliseconds */
    #run(milliseconds) {
        const end = performance.now() + milliseconds;
        while (this.#open && this.#result !== DONE && !this.#lacksFull) {
            if (this.#result === NEED_INPUT && !this.#refill()) return false;
            this.#check(this.#wasm.decode(milliseconds === Infinity ? NO_LIMIT : STEPS));
            const isHungry = this.#result === NEED_INPUT && this.#pieces.length > 0,
                isFirst = !this.#isSeen && this.#words[READY] > 0 && !isHungry;
            this.#isSeen ||= isFirst;
            if (milliseconds !== Infinity && (isFirst || performance.now() >= end))
                return isHungry || this.#result === MORE;
        }
        return false;
    }

    get #lacksFull() {
        return this.#result === ERROR_UNSUPPORTED && !this.#isFull;
    }

    /** Goes on with the full decoder. @param {WebAssembly.Module} module */
    #goOn(module) {
        const used = this.#words[USED];
        this.#load(module);
        this.#pieces = this.#kept;
        this.#kept = [];
        this.#headerBytes = 0;
        this.#open = false;
        this.#begin();
        while (this.#open && this.#words[USED] < used) {
            this.#check(this.#wasm.decode(NO_LIMIT));
            if (this.#words[USED] < used && !this.#refill(used - this.#words[USED])) break;
        }
    }

    /** Drops what has not been decoded. Memory goes when the last view of it goes. */
    free() {
        this.#pieces = this.#kept = [];
    }

    /** Decoded to the end? */
    get complete() {
        return this.#result === DONE;
    }

    /**
     * The mesh of this moment; null until there is one. What is new is new since the last call.
     * @returns {State | null}
     */
    state() {
        const s = this.#words;
        if (!this.#open || (s[READY] === 0 && !this.complete) || s[READY] < this.#rows) return null;
        this.#wasm.update();
        const [numVertices, numFaces] = [s[ROWS], s[FACES]];
        for (const [k, a] of this.#attributes.entries()) a.ranges = this.#news(a, this.#channel(k)[MOVES]);
        const ranges = this.#blocks(s[FACE_BLOCKS], s[SLOTS], 3);
        [this.#rows, this.#faces] = [numVertices, numFaces];
        return {
            numVertices,
            numFaces,
            totalVertices: s[TOTAL_ROWS],
            totalFaces: s[TOTAL_FACES],
            index: new Uint32Array(this.#memory.buffer, s[INDEX], 3 * s[TOTAL_FACES]),
            ranges,
            groups: this.#groups(),
            numMaterials: s[MATERIALS],
            attributes: Object.fromEntries(
                this.#attributes.filter(a => a.name !== "turned").map(({ name, ...a }) => [name, a]),
            ),
            level: s[LEVEL],
            error: this.#error(),
            bytes: s[USED],
            totalBytes: s[STREAM],
            complete: this.complete,
            metadata: this.complete
                ? new Uint8Array(this.#memory.buffer, s[METADATA], s[METADATA_BYTES]).slice()
                : new Uint8Array(0),
        };
    }

    /** @param {WebAssembly.Module} module */
    #load(module) {
        this.#isFull = module === fullModule;
        this.#wasm = new WebAssembly.Instance(module, { env: { memory: this.#memory } }).exports;
        this.#view();
    }

    #view() {
        this.#words = new Uint32Array(
            this.#memory.buffer,
            this.#wasm.state(),
            STATE_WORDS + MAX_CHANNELS * CHANNEL_WORDS,
        );
    }

    /** @param {number} result */
    #check(result) {
        this.#result = result;
        if (this.#lacksFull) return;
        if (result < 0 || result === TRUNCATED) {
            const byte = this.#open ? this.#words[USED] : this.#headerBytes;
            const message = readString(this.#memory, this.#wasm.message(result));
            if (result === TRUNCATED) throw new TruncatedError(message, byte);
            const asked = result === ERROR_MEMORY ? `: it asks for ${this.#words[MEMORY]} bytes` : "";
            throw new StreamError(message + asked, result, byte);
        }
    }

    /**
     * Moves up to `room` bytes of what has arrived to the input, behind `at`.
     * @param {number} at
     * @param {number} room
     */
    #take(at, room) {
        let taken = 0;
        while (this.#pieces.length && taken < room) {
            const part = this.#pieces[0].subarray(0, room - taken);
            new Uint8Array(this.#memory.buffer, this.#wasm.input() + at + taken, part.length).set(part);
            taken += part.length;
            if (part.length === this.#pieces[0].length) this.#pieces.shift();
            else this.#pieces[0] = this.#pieces[0].subarray(part.length);
        }
        return taken;
    }

    #refill(most = INPUT_BYTES) {
        const size = this.#take(0, Math.min(most, INPUT_BYTES));
        this.#wasm.give(size);
        return size > 0;
    }

    /**
     * Decodes all of a stream without waiting.
     * @param {WebAssembly.Module} module  the full decoder
     * @param {Uint8Array} data
     */
    static decodeNow(module, data) {
        const decoder = new Decoder(new WebAssembly.Memory({ initial: OWN_PAGES, maximum: 65536 }));
        decoder.#load(module);
        decoder.#pieces.push(data);
        decoder.#begin();
        decoder.#run(Infinity);
        decoder.#end();
        return /** @type {State} */ (decoder.state());
    }

    /** Reads the header, once there are enough bytes for that. */
    #begin() {
        this.#headerBytes += this.#take(this.#headerBytes, MAX_HEADER_BYTES - this.#headerBytes);
        this.#start(this.#wasm.begin(this.#headerBytes));
    }

    /** @param {number} result  of the header */
    #start(result) {
        this.#view();
        this.#check(result);
        if (result !== OK) return;
        this.#open = true;
        this.#wasm.give(this.#headerBytes);
        this.#result = OK;
        this.#describe();
    }

    /** @param {number} k */
    #channel(k) {
        return this.#words.subarray(STATE_WORDS + k * CHANNEL_WORDS, STATE_WORDS + (k + 1) * CHANNEL_WORDS);
    }

    #describe() {
        const s = this.#words,
            channels = Array.from({ length: s[CHANNELS] }, (_, k) => this.#channel(k));
        const names = nameChannels(channels.map(c => ({ kind: c[KIND], merge: c[MERGE] })));
        this.#attributes = channels.map((c, k) => {
            const origin = Array.from(new Float32Array(c.slice(ORIGIN, ORIGIN + 4).buffer)),
                perFace = c[MERGE] === PER_FACE;
            const array = new (c[IS_INTEGER] ? Uint32Array : Float32Array)(
                this.#memory.buffer,
                c[ARRAY],
                (perFace ? s[TOTAL_FACES] : s[TOTAL_ROWS]) * c[WIDTH],
            );
            const offset = origin.slice(0, c[WIDTH]).map(x => (c[IS_RELATIVE] ? x : 0));
            return { name: names[k], array, itemSize: c[WIDTH], perFace, offset, bits: c[BITS], ranges: [] };
        });
    }

    /** What is new of an attribute: vertices or faces at the end, and those that have moved. @param {Attribute} a
     *  @param {number} moves @returns {Range[]} */
    #news({ itemSize, perFace }, moves) {
        if (perFace && this.#words[MATERIALS]) return [{ start: 0, count: this.#words[SLOTS] * itemSize }];
        const [since, now] = perFace ? [this.#faces, this.#words[FACES]] : [this.#rows, this.#words[ROWS]];
        const moved = moves ? this.#blocks(this.#words[ROW_BLOCKS], since, itemSize) : [];
        return now > since ? [...moved, { start: since * itemSize, count: (now - since) * itemSize }] : moved;
    }

    #groups() {
        const words = new Uint32Array(this.#memory.buffer, this.#words[GROUP], 3 * this.#words[GROUPS]);
        /** @type {Group[]} */
        const groups = [];
        for (let k = 0; k < words.length; k += 3)
            if (words[k + 1]) groups.push({ start: 3 * words[k], count: 3 * words[k + 1], material: words[k + 2] });
        return groups;
    }

    /** Runs of blocks that are marked. @param {number} at @param {number} end @param {number} itemSize */
    #blocks(at, end, itemSize) {
        const count = Math.ceil(end / BLOCK),
            blocks = new Uint8Array(this.#memory.buffer, at, count);
        /** @type {Range[]} */
        const ranges = [];
        for (let first = blocks.indexOf(1); first >= 0;) {
            const after = blocks.indexOf(0, first),
                stop = after < 0 ? count : after;
            ranges.push({
                start: first * BLOCK * itemSize,
                count: (Math.min(stop * BLOCK, end) - first * BLOCK) * itemSize,
            });
            first = after < 0 ? -1 : blocks.indexOf(1, after);
        }
        return ranges;
    }

    #error() {
        const k = this.#attributes.findIndex(a => a.name === "positions");
        if (this.complete) return 0;
        if (k < 0 || this.#attributes[k].bits === EXACT_BITS || this.#words[LEVEL] === 0) return NaN;
        return (this.#words[ERROR] / 16) * new Float32Array(this.#channel(k).slice(STEP, STEP + 1).buffer)[0];
    }
}

// -- Where bytes come from --

/** A signal ends a read that waits. @param {ReadableStream<Uint8Array>} stream @param {AbortSignal} [signal] */
async function* readStream(stream, signal) {
    const reader = stream.getReader();
    signal?.addEventListener("abort", () => reader.cancel().catch(() => {}));
    try {
        for (let r = await reader.read(); !r.done; r = await reader.read()) yield r.value;
    } finally {
        await reader.cancel().catch(() => {});
    }
}

/**
 * Pieces of a source.
 * @param {Source | Promise<Source>} from
 * @param {AbortSignal} [signal]
 * @returns {AsyncGenerator<Uint8Array>}
 */
async function* pieces(from, signal) {
    const source = await from;
    if (typeof source === "string" || source instanceof URL) {
        yield* pieces(await fetch(source, { signal }));
    } else if (source instanceof Response) {
        if (!source.ok) throw new Error(`${source.url}: ${source.status} ${source.statusText}`);
        if (source.body) yield* readStream(source.body, signal);
    } else if (source instanceof Blob) {
        yield* readStream(source.stream(), signal);
    } else if (source instanceof ReadableStream) {
        yield* readStream(source, signal);
    } else if (source instanceof ArrayBuffer) {
        yield new Uint8Array(source);
    } else if (ArrayBuffer.isView(source)) {
        yield new Uint8Array(source.buffer, source.byteOffset, source.byteLength);
    } else {
        yield* source;
    }
}

/**
 * Decodes a stream: one state for each piece that arrives, and for each budget that is spent.
 *
 * Throws a StreamError, or a TruncatedError after the last state of a stream that ends early; an error of the
 * connection
 * comes after the last state, too.
 * @param {Source | Promise<Source>} source
 * @param {Options} [options]
 * @returns {AsyncGenerator<State, void, void>}
 */
export async function* decode(source, options = {}) {
    const decoder = options.worker ? await WorkerDecoder.create(options) : await Decoder.create(options);
    const input = pieces(source, options.signal);
    let bytes = -1;
    try {
        for (let ended = false; !decoder.complete && !ended;) {
            /** @type {unknown} */
            let failure;
            const piece = await input.next().catch(error => {
                failure = error;
                return { done: true, value: undefined };
            });
            options.signal?.throwIfAborted();
            ended = Boolean(piece.done);
            if (piece.value) await decoder.feed(piece.value);
            for (let more = true; more;) {
                options.signal?.throwIfAborted();
                more = await decoder.decode(options.budget);
                const state = decoder.state();
                if (state && (state.bytes !== bytes || state.ranges.length)) yield state;
                bytes = state?.bytes ?? -1;
            }
            if (ended && !decoder.complete) yield* finish(decoder, failure, options);
        }
    } finally {
        decoder.free();
        await input.return(undefined);
    }
}

/** The last bytes of a stream that has not ended: the error comes after what they show.
 * @param {Decoder | WorkerDecoder} decoder @param {unknown} failure @param {Options} options */
async function* finish(decoder, failure, options) {
    try {
        await decoder.finish();
    } catch (error) {
        if (!(error instanceof TruncatedError)) throw error;
        failure ??= options.partial ? undefined : error;
    }
    const state = decoder.state();
    if (state) yield state;
    if (failure) throw failure;
}

/**
 * Decodes all of a stream.
 * @param {Source | Promise<Source>} source
 * @param {Options} [options]
 * @returns {Promise<State>}
 */
export async function decodeAll(source, options = {}) {
    /** @type {State | undefined} */
    let last;
    for await (const state of decode(source, options)) last = state;
    if (!last) throw new TruncatedError("the input ends early", 0);
    return last;
}

// -- Worker --

/** @typedef {{ array: Numbers, ranges: Range[] }} Part  What is new of an array, its ranges one behind the other. */
/**
 * @typedef {Omit<State, "index" | "attributes" | "ranges"> & { parts: Part[], names: string[], attributes: Attribute[]
 * }} Message
 */

/** Copies the ranges of an array. @template {Numbers} T @param {T} array @param {Range[]} ranges @returns {T} */
function gather(array, ranges) {
    const length = ranges.reduce((sum, r) => sum + r.count, 0);
    const to = /** @type {T} */ (new /** @type {any} */ (array.constructor)(length));
    let at = 0;
    for (const { start, count } of ranges) {
        to.set(array.subarray(start, start + count), at);
        at += count;
    }
    return to;
}

/** @param {Numbers} to @param {Part} part */
function scatter(to, { array, ranges }) {
    let at = 0;
    for (const { start, count } of ranges) {
        to.set(array.subarray(at, at + count), start);
        at += count;
    }
}

/** @param {State} state @returns {Message} */
function pack({ index, attributes, ranges, ...counts }) {
    const names = Object.keys(attributes);
    const parts = [{ array: gather(index, ranges), ranges }];
    const described = names.map(name => {
        const a = attributes[name];
        parts.push(/** @type {any} */ ({ array: gather(a.array, a.ranges), ranges: a.ranges }));
        return { ...a, array: new /** @type {any} */ (a.array.constructor)(0) };
    });
    return { ...counts, names, parts, attributes: described };
}

/** What a page and its worker say to each other, on any port. */
/**
 * @typedef {{ postMessage(message: any, transfer: any[]): void, addEventListener(type: "message", listener: (event:
 * any) => void): void }} Port
 */

/** Serves decoders to a page: what worker.js runs. @param {Port} [port]  not given: that of the worker it runs in */
export function serve(port = findPort()) {
    /** @type {Map<number, Promise<Decoder>>} */
    const decoders = new Map();
    port.addEventListener("message", async ({ data: { id, call, value } }) => {
        if (call === "open") return decoders.set(id, Decoder.create(value));
        if (call === "free") return decoders.delete(id);
        const decoder = await decoders.get(id);
        if (!decoder) return undefined;
        let error,
            more = false;
        try {
            if (call === "feed") await decoder.feed(value);
            else if (call === "decode") more = await decoder.decode(value);
            else await decoder.finish();
        } catch (e) {
            error =
                e instanceof StreamError
                    ? { message: e.message, result: e.result, byte: e.byte }
                    : { message: String(e) };
        }
        const state = call === "feed" ? null : decoder.state();
        const message = state && pack(state);
        return port.postMessage(
            { id, error, more, complete: decoder.complete, message },
            message ? message.parts.map(p => p.array.buffer) : [],
        );
    });
}

/** @returns {Port} */
function findPort() {
    const all = /** @type {any} */ (globalThis);
    return all.postMessage ? all : all.process.getBuiltinModule("node:worker_threads").parentPort;
}

/** A Decoder that works elsewhere. Its arrays are here, and grow by what the worker hands over. */
export class WorkerDecoder {
    static #count = 0;
    #id = ++WorkerDecoder.#count;
    #port;
    #owned;
    #signal;
    /** @type {((reply: any) => void) | undefined} */
    #resolve;
    /** @type {((error: Error) => void) | undefined} */
    #reject;
    /** @type {State | null} */
    #state = null;
    complete = false;
    #listener = (/** @type {any} */ event) => {
        const reply = event.data ?? event; // node has no event around it
        if (reply.id === this.#id) this.#resolve?.(reply);
    };
    #failed = (/** @type {any} */ event) => this.#reject?.(new Error(event.message || "the worker cannot start"));
    #aborted = () => this.#reject?.(this.#signal?.reason);

    /** @param {Worker | NodeWorker} port @param {boolean} owned  to be terminated with the last piece
     *  @param {AbortSignal} [signal]  ends a wait for the worker */
    constructor(port, owned, signal) {
        const listen = "on" in port ? port.on : port.addEventListener;
        this.#port = port;
        this.#owned = owned;
        this.#signal = signal;
        listen.call(port, "message", this.#listener);
        listen.call(port, "error", this.#failed);
        signal?.addEventListener("abort", this.#aborted);
    }

    /** @param {Options} options */
    static async create({ worker, maxMemory, signal }) {
        const owned = worker === true || !worker;
        const decoder = new WorkerDecoder(owned ? startWorker() : worker, owned, signal);
        decoder.#send("open", { maxMemory });
        return decoder;
    }

    /** @param {Uint8Array} piece */
    async feed(piece) {
        const own = piece.slice();
        await this.#ask("feed", own, [own.buffer]);
    }

    /** @param {number} [milliseconds] @returns {Promise<boolean>} */
    async decode(milliseconds) {
        return (await this.#ask("decode", milliseconds)).more;
    }

    async finish() {
        await this.#ask("finish");
    }

    state() {
        return this.#state;
    }

    free() {
        const port = this.#port,
            leave = "on" in port ? port.off : port.removeEventListener;
        this.#send("free");
        leave.call(port, "message", this.#listener);
        leave.call(port, "error", this.#failed);
        this.#signal?.removeEventListener("abort", this.#aborted);
        if (this.#owned) this.#port.terminate();
    }

    /** @param {string} call @param {unknown} [value] @param {Transferable[]} [transfer] */
    #send(call, value, transfer = []) {
        this.#port.postMessage({ id: this.#id, call, value }, transfer);
    }

    /** @param {string} call @param {unknown} [value] @param {Transferable[]} [transfer] */
    async #ask(call, value, transfer) {
        this.#signal?.throwIfAborted();
        const reply = await new Promise((resolve, reject) => {
            [this.#resolve, this.#reject] = [resolve, reject];
            this.#send(call, value, transfer);
        });
        if (reply.message) this.#unpack(reply.message);
        this.complete = reply.complete;
        if (reply.error) throw rebuild(reply.error);
        return reply;
    }

    /** @param {Message} message */
    #unpack({ names, parts, attributes, ...counts }) {
        const before = this.#state;
        const index = before?.index ?? new Uint32Array(3 * counts.totalFaces);
        scatter(index, parts[0]);
        const all = attributes.map((a, k) => {
            const room = (a.perFace ? counts.totalFaces : counts.totalVertices) * a.itemSize;
            const array = before?.attributes[names[k]].array ?? new /** @type {any} */ (a.array.constructor)(room);
            scatter(array, parts[k + 1]);
            return [names[k], { ...a, array }];
        });
        this.#state = { ...counts, index, ranges: parts[0].ranges, attributes: Object.fromEntries(all) };
    }
}

/** A worker of this package, for the option `worker`. In node it has what NodeWorker says. @returns {Worker} */
export function startWorker() {
    if (typeof Worker === "undefined") return startInNode();
    return new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
}

/** Bundlers see neither an import of node's nor a file that a page would need. */
function startInNode() {
    const { Worker } = /** @type {any} */ (globalThis).process.getBuiltinModule("node:worker_threads");
    return new Worker(new URL(import.meta.url.replace(/[^/]*$/, "worker.js")));
}

/** An exception that has crossed to the page. @param {{ message: string, result?: number, byte?: number }} e */
function rebuild({ message, result, byte = 0 }) {
    if (result === undefined) return new Error(message);
    const words = message.replace(/ \(byte \d+\)$/, "");
    return result === TRUNCATED ? new TruncatedError(words, byte) : new StreamError(words, result, byte);
}

// -- Encoder --

/**
 * A mesh to encode: triangles over vertices, and attributes by name, as in a State. Floats are rounded to a grid, whole
 * numbers stay as they are. Colors and weights are floats of 0 .. 1, or bytes. Faces of one of the `materials`, whose
 * numbers begin at 0, come back as a group.
 * @typedef {{ index: ArrayLike<number>, positions?: ArrayLike<number>, materials?: ArrayLike<number> } & Record<string,
 * ArrayLike<number> | undefined>} Mesh
 */

/**
 * @typedef {object} EncodeOptions
 * @property {number | Record<string, number>} [bits]  of positions, or of attributes by name; 32: floats bit for bit
 * @property {"balanced" | "least-connectivity"} [goal]
 * @property {(done: number, total: number) => void} [progress]
 * @property {Uint8Array} [metadata]  bytes that travel with the mesh
 */

/** @typedef {{ data: Uint8Array, map: Uint32Array, faceMap: Uint32Array }} Encoded
 *  The stream, and where each vertex and face went. */

/** @type {Promise<WebAssembly.Module> | undefined} */
let encoderModule;
const openEncoder = () => (encoderModule ??= import("./encoder.wasm.js").then(m => compile(m.default)));

/** Both directions for those who cannot wait: each call blocks until it is done. */
export async function openCodec() {
    const [full, encoder] = await Promise.all([openFull(), openEncoder()]);
    const start = (/** @type {any} */ imports) => new WebAssembly.Instance(encoder, imports);
    return {
        decode: (/** @type {Uint8Array} */ data) => Decoder.decodeNow(full, data),
        encode: (/** @type {Mesh} */ mesh, /** @type {EncodeOptions} */ options = {}) => {
            const job = prepare(mesh, options);
            return job.run(start(job.imports));
        },
    };
}

/** @param {string} name */
function findKind(name) {
    const kind = KINDS.find(k => k.name === name.replace(/_[1-9]\d*$/, ""));
    if (!kind) throw new TypeError(`no attribute ${name}; there are ${KINDS.map(k => k.name).join(", ")}`);
    return kind;
}

/**
 * Encodes a mesh. Throws a MeshError that tells where the mesh is not what it has to be.
 * @param {Mesh} mesh
 * @param {EncodeOptions} [options]
 * @returns {Promise<Encoded>}
 */
export async function encode(mesh, options = {}) {
    const job = prepare(mesh, options);
    return job.run(await WebAssembly.instantiate(await openEncoder(), job.imports));
}

/** What the encoder's instance needs, and what it then does. @param {Mesh} mesh @param {EncodeOptions} options */
function prepare(mesh, options) {
    const memory = new WebAssembly.Memory({ initial: 4, maximum: 65536 });
    const imports = { env: { memory }, page: { progress: options.progress ?? (() => {}) } };
    return {
        imports,
        run: (/** @type {WebAssembly.Instance} */ { exports }) => encodeIn(memory, exports, mesh, options),
    };
}

/**
 * @param {WebAssembly.Memory} memory
 * @param {any} wasm
 * @param {Mesh} mesh
 * @param {EncodeOptions} options
 * @returns {Encoded}
 */
function encodeIn(memory, wasm, mesh, { bits = {}, goal = "balanced", metadata }) {
    const { index, materials, ...attributes } = mesh;
    const names = Object.keys(attributes)
        .filter(name => attributes[name])
        .sort(byKind);
    const faces = index.length / 3;
    const vertices = countVertices(mesh, names);
    if (names.length > MAX_CHANNELS) throw new RangeError(`${names.length} attributes, of at most ${MAX_CHANNELS}`);
    const copy = (/** @type {ArrayLike<number>} */ from, /** @type {any} */ Type) => {
        const at = wasm.take(4 * from.length) >>> 0;
        if (from.length && !at) throw new RangeError("the mesh needs more memory than WebAssembly has");
        new Type(memory.buffer, at, from.length).set(from);
        return at;
    };
    const check = (/** @type {number} */ result, name = "") => {
        if (result < 0) {
            const place = Array.from(new Uint32Array(memory.buffer, wasm.place(), 3), n =>
                n === NONE ? undefined : n,
            );
            throw new MeshError((name && `${name}: `) + readString(memory, wasm.message(result)), result, place);
        }
    };
    wasm.mesh(vertices, faces, copy(index, Uint32Array), goal === "balanced" ? 0 : 1);
    if (materials) {
        if (materials.length !== faces) throw new RangeError(`materials: ${materials.length}, of ${faces} faces`);
        wasm.materials(Array.from(materials).reduce((a, b) => Math.max(a, b), 0) + 1, copy(materials, Uint32Array));
    }
    if (metadata?.length) {
        const at = wasm.take(metadata.length);
        new Uint8Array(memory.buffer, at, metadata.length).set(metadata);
        wasm.metadata(at, metadata.length);
    }
    for (const name of names) {
        const array = /** @type {ArrayLike<number>} */ (attributes[name]);
        const wanted = typeof bits === "number" ? (name === "positions" ? bits : undefined) : bits[name];
        const perFace = findKind(name).merge === PER_FACE,
            count = perFace ? faces : vertices;
        if (!count) throw new RangeError(`${name}: the mesh has no ${perFace ? "faces" : "vertices"}`);
        check(addChannel(wasm, copy, name, array, array.length / count, wanted), name);
    }
    check(wasm.encode());
    const [stream, size, map, faceMap] = new Uint32Array(memory.buffer, wasm.output(), 4);
    return {
        data: new Uint8Array(memory.buffer, stream, size).slice(),
        map: new Uint32Array(memory.buffer, map, vertices).slice(),
        faceMap: new Uint32Array(memory.buffer, faceMap, faces).slice(),
    };
}

/** Positions first. @param {string} a @param {string} b */
function byKind(a, b) {
    return KINDS.indexOf(findKind(a)) - KINDS.indexOf(findKind(b)) || a.localeCompare(b, "en", { numeric: true });
}

/** @param {Mesh} mesh @param {string[]} names */
function countVertices(mesh, names) {
    if (mesh.index.length % 3) throw new RangeError(`index: ${mesh.index.length} numbers are no triangles`);
    if (mesh.positions) return mesh.positions.length / 3;
    const fixed = names.find(name => findKind(name).components.length === 1 && !findKind(name).merge);
    return fixed
        ? /** @type {any} */ (mesh[fixed]).length / findKind(fixed).components[0]
        : Array.from(mesh.index).reduce((most, v) => Math.max(most, v + 1), 0);
}

/** @param {any} wasm @param {(from: ArrayLike<number>, Type: any) => number} copy @param {string} name
 *  @param {ArrayLike<number>} array @param {number} components @param {number} [wanted]  bits */
function addChannel(wasm, copy, name, array, components, wanted) {
    const { kind, merge, components: allowed, bits: usual, unit } = findKind(name);
    if (!allowed.includes(components))
        throw new RangeError(`${name}: ${components} numbers for each, expected ${allowed.join(" or ")}`);
    const isFloat = array instanceof Float32Array || array instanceof Float64Array || Array.isArray(array);
    if (usual === 0 || (kind === 1 && !isFloat)) {
        const most = Array.from(array).reduce((a, b) => Math.max(a, b), 0);
        const needed = Math.max(32 - Math.clz32(most), 1);
        wasm.integers(
            kind,
            components,
            needed <= MAX_BITS ? needed : EXACT_BITS,
            merge || COPY,
            copy(array, Uint32Array),
        );
        return OK;
    }
    const scale = unit && !isFloat ? 2 ** (8 * /** @type {any} */ (array).BYTES_PER_ELEMENT) - 1 : 1;
    const floats = scale === 1 ? array : Float32Array.from(array, x => x / scale);
    const bits = wanted ?? usual;
    if (!(bits >= 1 && bits <= MAX_BITS) && bits !== EXACT_BITS)
        throw new RangeError(`${name}: bits have to be 1 .. ${MAX_BITS} or ${EXACT_BITS}`);
    const grid = kind === 0 && array instanceof Float64Array && bits <= MAX_BITS ? fitDoubles(array, bits) : null;
    if (grid) {
        wasm.grid(bits, grid.step, ...grid.origin, copy(grid.values, Int32Array));
        return OK;
    }
    return wasm.floats(
        kind,
        components,
        bits,
        merge,
        unit && bits !== EXACT_BITS ? 1 / (2 ** bits - 1) : 0,
        copy(floats, Float32Array),
    );
}

/** The next float above, or below if `sign` is negative. @param {number} x @param {number} sign */
function nextFloat(x, sign) {
    const float = Math.fround(x),
        away = Math.max(Math.abs(float) * 2 ** -23, 2 ** -140);
    return Math.sign(x - float) === -sign || x === float ? float : Math.fround(float + sign * away);
}

/** Positions on a grid that is computed in doubles; null if floats are fine enough. @param {Float64Array} array
 *  @param {number} bits */
function fitDoubles(array, bits) {
    const low = [Infinity, Infinity, Infinity],
        high = [-Infinity, -Infinity, -Infinity];
    array.forEach((x, i) => {
        low[i % 3] = Math.min(low[i % 3], x);
        high[i % 3] = Math.max(high[i % 3], x);
    });
    const far = Math.max(...low.map(Math.abs), ...high.map(Math.abs));
    if (
        !array.every(Number.isFinite) ||
        far * 2 ** -23 <= Math.max(...high.map((x, k) => x - low[k])) / (2 ** bits - 1)
    )
        return null;
    const origin = low.map(x => nextFloat(x, -1));
    const step = nextFloat(Math.max(...high.map((x, k) => x - origin[k])) / (2 ** bits - 1), 1);
    return { origin, step, values: Int32Array.from(array, (x, i) => Math.round((x - origin[i % 3]) / step)) };
}
