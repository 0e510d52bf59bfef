/* The package as npm packs and installs it, in node. SPDX-License-Identifier: MIT */
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { Worker } from "node:worker_threads";
import { brotliCompressSync } from "node:zlib";
import { Decoder, MeshError, StreamError, TruncatedError, decode, decodeAll, encode, openCodec } from "conquest-mesh";
import { cut, describe, makeDressed, makeSphere } from "./meshes.js";

const here = dirname(fileURLToPath(import.meta.url));
const root = join(here, "..", "..", "..");
const mesh = makeDressed(),
    HEAP = 3 * 65536;
const vertices = mesh.positions.length / 3,
    faces = mesh.index.length / 3;
const { data, map, faceMap } = await encode(mesh, { bits: { positions: 14 } });

/** Does the decoded mesh have what the encoded one had, at the vertices and faces where the encoder says? */
function compare(state, original, { map, faceMap }, tolerance) {
    assert.equal(state.complete, true);
    assert.deepEqual([state.numVertices, state.numFaces], [map.length, faceMap.length]);
    const name = v => String(v);
    assert.deepEqual(
        describe(state.index, state.numFaces, name),
        describe(original.index, faceMap.length, v => name(map[v])),
    );
    if (original.materials) {
        const found = new Uint16Array(state.numFaces);
        for (const { start, count, material } of state.groups)
            found.fill(material, start / 3, (start + count) / 3);
        original.materials.forEach((m, f) => assert.equal(found[faceMap[f]], m));
    }
    for (const [key, from] of Object.entries(original).filter(([key]) => !["index", "materials"].includes(key))) {
        const { array, itemSize, perFace } = state.attributes[key];
        const to = perFace ? faceMap : map,
            scale = from instanceof Uint8Array && key === "colors" ? 255 : 1;
        assert.equal(from.length, to.length * itemSize);
        for (let i = 0; i < from.length; i++) {
            const got = array[to[Math.floor(i / itemSize)] * itemSize + (i % itemSize)];
            assert.ok(
                Math.abs(got - from[i] / scale) <= tolerance[key],
                `${key} ${i}: ${got}, expected ${from[i] / scale}`,
            );
        }
    }
}

const tolerances = {
    positions: 1e-4,
    normals: 5e-3,
    tangents: 2e-3,
    texcoords: 2e-4,
    colors: 1e-6,
    joints: 0,
    weights: 2e-4,
};

test("all attributes come back", async () => compare(await decodeAll(data), mesh, { map, faceMap }, tolerances));

test("floats come back bit for bit", async () => {
    const plain = makeSphere(),
        encoded = await encode(plain, { bits: 32 });
    compare(await decodeAll(encoded.data), plain, encoded, { positions: 0 });
});

test("seams, faces turned over, a line, a vertex that no face uses and metadata come back", async () => {
    const round = makeSphere(24, 12),
        index = Array.from(round.index),
        positions = [],
        texcoords = [],
        normals = [];
    const seamed = {
        index: index.map((v, i) => {
            // a row for each corner
            const at = round.positions.subarray(3 * v, 3 * v + 3),
                face = Math.floor(i / 3);
            positions.push(...at);
            texcoords.push(face < index.length / 6 ? at[0] : at[0] + 1, at[1]);
            normals.push(...at);
            return i;
        }),
    };
    for (const f of [7, 30, 31])
        // turned over
        [seamed.index[3 * f], seamed.index[3 * f + 1]] = [seamed.index[3 * f + 1], seamed.index[3 * f]];
    positions.push(9, 9, 9); // of no face
    texcoords.push(0, 0);
    normals.push(0, 0, 1);
    seamed.index.push(0, 5, 5); // a line
    Object.assign(seamed, {
        positions: Float32Array.from(positions),
        texcoords: Float32Array.from(texcoords),
        normals: Float32Array.from(normals),
    });
    const encoded = await encode(seamed, { bits: 14, metadata: new TextEncoder().encode("gold") });
    const copies = {};
    let state;
    for await (state of decode(cut(encoded.data, 100)))
        for (const [name, { array, ranges }] of Object.entries(state.attributes)) {
            copies[name] ??= new Float32Array(array.length);
            for (const { start, count } of ranges) copies[name].set(array.subarray(start, start + count), start);
            assert.deepEqual(
                copies[name].subarray(0, 2 * state.numVertices),
                array.subarray(0, 2 * state.numVertices),
            );
        }
    assert.equal(new TextDecoder().decode(state.metadata), "gold");
    assert.equal(state.numFaces, seamed.index.length / 3);
    const arrays = [state.index, ...Object.values(state.attributes).map(a => a.array)];
    assert.ok(arrays.every(array => array.byteOffset >= HEAP), "arrays lie behind the decoder's own memory");
    assert.ok(state.numVertices < positions.length / 6, `${state.numVertices} rows`);
    assert.deepEqual(
        describe(state.index, state.numFaces, String),
        describe(seamed.index, state.numFaces, v => String(encoded.map[v])),
    );
    for (const [key, itemSize] of Object.entries({ positions: 3, texcoords: 2, normals: 3 }))
        seamed[key].forEach((x, i) => {
            const got = state.attributes[key].array[itemSize * encoded.map[Math.floor(i / itemSize)] + (i % itemSize)];
            const expected =
                key === "normals" ? x / Math.hypot(...seamed[key].subarray(i - (i % 3), i - (i % 3) + 3)) : x;
            assert.ok(Math.abs(got - expected) < 5e-3, `${key} ${i}: ${got}, expected ${expected}`);
        });
});

test("all kinds of sources give the same mesh", async () => {
    const stream = () => new Blob([data]).stream();
    const buffer = data.buffer.slice(data.byteOffset, data.byteOffset + data.length);
    for (const source of [
        buffer,
        data,
        new Blob([data]),
        stream(),
        new Response(stream()),
        Promise.resolve(new Response(data)),
        cut(data, 7),
        (async function* () {
            yield* cut(data, 100);
        })(),
    ])
        compare(await decodeAll(source), mesh, { map, faceMap }, tolerances);
});

/** The triangles of a state, in an index that has them. */
const listDrawn = (index, { groups }) =>
    groups.flatMap(({ start, count }) => Array.from(index.subarray(start, start + count)));

test("each state has what the ranges of those before it say", async () => {
    const index = new Uint32Array(3 * faces),
        positions = new Float32Array(3 * vertices);
    let states = 0,
        last = 0,
        error = Infinity;
    for await (const state of decode(cut(data, 64))) {
        const place = state.attributes.positions;
        for (const { start, count } of state.ranges) index.set(state.index.subarray(start, start + count), start);
        const drawn = listDrawn(index, state);
        for (const { start, count } of place.ranges) positions.set(place.array.subarray(start, start + count), start);
        assert.deepEqual(drawn, listDrawn(state.index, state));
        assert.deepEqual(positions.subarray(0, 3 * state.numVertices), place.array.subarray(0, 3 * state.numVertices));
        assert.ok(drawn.length === 3 * state.numFaces && drawn.every(v => v < state.numVertices));
        assert.ok(state.numVertices >= last && !(state.error > error) && state.totalBytes === data.length);
        [last, error, states] = [state.numVertices, state.error, states + 1];
    }
    assert.ok(states > data.length / 64 / 2, `${states} states`);
    assert.deepEqual([last, error], [vertices, 0]);
});

test("views stay where they are, in memory that is handed in", async () => {
    const memory = new WebAssembly.Memory({ initial: 1, maximum: 1000 });
    let first;
    for await (const state of decode(cut(data, 500), { memory })) {
        first ??= state;
        assert.equal(state.index.buffer, memory.buffer);
        assert.equal(state.attributes.positions.array.buffer, first.index.buffer);
    }
    const size = memory.buffer.byteLength;
    compare(await decodeAll(data, { memory }), mesh, { map, faceMap }, tolerances);
    assert.equal(memory.buffer.byteLength, size);
});

/** Decodes as a page that has not loaded the full decoder yet; how many instances that took, and the last state. What the
 *  ranges say is checked on the way, and that arrays stay where they are. */
async function decodeFresh(data) {
    const { decode } = await import(`${import.meta.resolve("conquest-mesh")}?${(fresh += 1)}`),
        { Instance } = WebAssembly,
        copy = {},
        places = new Set();
    let instances = 0,
        state;
    WebAssembly.Instance = function (...all) {
        instances++;
        return new Instance(...all);
    };
    try {
        for await (state of decode(slowly(data))) {
            const arrays = { index: state, positions: state.attributes.positions };
            for (const [name, { ranges }] of Object.entries(arrays)) {
                const from = state.index === arrays[name].index ? state.index : arrays[name].array;
                copy[name] ??= from.slice();
                for (const { start, count } of ranges) copy[name].set(from.subarray(start, start + count), start);
                const there = array =>
                    name === "index" ? listDrawn(array, state) : Array.from(array.subarray(0, 3 * state.numVertices));
                assert.deepEqual(there(copy[name]), there(from));
                places.add(`${name} ${from.byteOffset}`);
            }
        }
    } finally {
        WebAssembly.Instance = Instance;
    }
    assert.equal(places.size, 2);
    return { instances, state };
}
let fresh = 0;

/** Pieces, with time for a module to be loaded between them. */
async function* slowly(data) {
    for (const piece of cut(data, 1000)) {
        yield piece;
        await new Promise(resolve => setTimeout(resolve, 5));
    }
}

/** Positions alone, with a vertex more in each face, a tenth above it: no regular levels. */
function withThorns({ positions, index }) {
    const all = Array.from(positions),
        faces = [];
    for (let k = 0; k < index.length; k += 3) {
        const [a, b, c] = index.slice(k, k + 3),
            at = [0, 1, 2].map(i => (positions[3 * a + i] + positions[3 * b + i] + positions[3 * c + i]) / 3),
            tip = all.length / 3;
        all.push(...at.map(x => 1.1 * x));
        faces.push(a, b, tip, b, c, tip, c, a, tip);
    }
    return { positions: new Float32Array(all), index: new Uint32Array(faces) };
}

test("the small decoder hands over to the full one: never if a stream is short, when it is long, at a regular level, with attributes", async () => {
    const without = ({ materials, tangents, joints, ...rest }) => rest,
        results = [];
    for (const [original, bits] of [
        [withThorns(makeSphere(12, 6)), 12],
        [withThorns(makeSphere(90, 45)), 12],
        [makeSphere(64, 32), 12],
        [without(mesh), { positions: 14 }],
    ]) {
        const encoded = await encode(original, { bits }),
            { instances, state } = await decodeFresh(encoded.data);
        compare(state, original, encoded, { ...tolerances, positions: 5e-4, normals: 1e-2 });
        results.push([instances, encoded.data.length > 16384]);
    }
    assert.deepEqual(results, [
        [1, false],
        [2, true],
        [2, false],
        [2, false],
    ]);
});

test("a budget that ends inside the decoder's own buffer loses nothing", async () => {
    const index = new Uint32Array(3 * faces);
    for await (const state of decode(data, { budget: 0 })) {
        for (const { start, count } of state.ranges) index.set(state.index.subarray(start, start + count), start);
        assert.deepEqual(listDrawn(index, state), listDrawn(state.index, state));
    }
});

/** Decodes with a budget; the steps that each call of decode() asked the decoder for, in turn. */
async function listSteps(data, budget) {
    const { Instance } = WebAssembly,
        calls = [];
    WebAssembly.Instance = function (...all) {
        const { exports } = new Instance(...all);
        return { exports: { ...exports, decode: steps => (calls.at(-1)?.push(steps), exports.decode(steps)) } };
    };
    try {
        const decoder = await Decoder.create();
        await decoder.feed(data);
        for (let more = true; more;) {
            calls.push([]);
            more = await decoder.decode(budget);
        }
        assert.equal(decoder.complete, true);
    } finally {
        WebAssembly.Instance = Instance;
    }
    return calls;
}

test("with a budget of 0 each decode() makes one batch of steps; without one, a single decode() all of them", async () => {
    const round = makeSphere(90, 45),
        { data } = await encode(round, { bits: 12 }),
        vertices = round.positions.length / 3;
    await openCodec(); // the full decoder is there from the start
    const [all] = await listSteps(data),
        calls = await listSteps(data, 0),
        [[steps]] = calls;
    assert.deepEqual(all, [0xffffffff, 0xffffffff], "no limit: for the bytes that came with the header, for the others");
    assert.ok(steps > 0 && steps <= 1024, `${steps} steps`);
    assert.ok(calls.every(made => made.length === 1 && made[0] === steps));
    assert.ok(calls.length >= vertices / steps, `${calls.length} calls for ${vertices} vertices`);
    let states = 0,
        last = 0;
    for await (const { numVertices } of decode(data, { budget: 0 })) {
        assert.ok(numVertices <= last + steps, `${last}, then ${numVertices} vertices`); // a step makes one, at most
        [last, states] = [numVertices, states + 1];
    }
    assert.ok(last === vertices && states >= vertices / steps && states <= calls.length, `${states} states`);
    console.log(`${vertices} vertices: ${calls.length} times ${steps} steps, ${states} states`);
});

test("a stream that ends early is a coarser mesh and an error", async () => {
    for (const size of [0, 3, 20, 400, data.length - 1]) {
        let last;
        const all = async options => {
            for await (const state of decode(data.subarray(0, size), options)) last = state;
        };
        await assert.rejects(
            all({}),
            e => e instanceof TruncatedError && e.byte <= size && /ends early/.test(e.message),
        );
        assert.ok(size < 400 || (last.numVertices > 3 && !last.complete));
        await all({ partial: true });
    }
});

test("errors have the codec's words and the byte", async () => {
    await assert.rejects(
        decodeAll(new TextEncoder().encode("solid of no mesh")),
        e => e instanceof StreamError && e.message === "not a conquest stream (byte 16)",
    );
    const damaged = data.slice();
    damaged[Math.floor(data.length / 2)] ^= 64;
    await assert.rejects(
        decodeAll(damaged),
        e => e instanceof StreamError && e.byte >= data.length / 2 && e.result <= -15,
    );
    await assert.rejects(
        decodeAll(data, { maxMemory: 1000 }),
        e => e instanceof StreamError && /memory too small.*asks for \d+ bytes/.test(e.message),
    );
    await assert.rejects(decodeAll(new Response("", { status: 404 })), /404/);
});

test("a broken connection is an error after the last state", async () => {
    let last;
    const broken = async function* () {
        yield data.subarray(0, 900);
        throw new TypeError("network error");
    };
    await assert.rejects(async () => {
        for await (const state of decode(broken())) last = state;
    }, /network error/);
    assert.ok(last.numVertices > 3 && !last.complete && last.bytes <= 900);
});

test("a loop that is left cancels the stream; so does a signal", async () => {
    let cancelled = 0;
    const source = () =>
        new ReadableStream({
            pull(c) {
                c.enqueue(data.slice(0, 2000));
            },
            cancel() {
                cancelled++;
            },
        });
    for await (const state of decode(source())) if (state.numVertices) break;
    const abort = new AbortController();
    await assert.rejects(
        async () => {
            for await (const _ of decode(source(), { signal: abort.signal })) abort.abort();
        },
        { name: "AbortError" },
    );
    assert.equal(cancelled, 2);
});

test("a signal ends a wait for bytes that do not come", async () => {
    const abort = new AbortController(), silent = new ReadableStream({});
    setTimeout(() => abort.abort(), 20);
    await assert.rejects(decodeAll(silent, { signal: abort.signal }), { name: "AbortError" });
});

test("a worker decodes the same: one of its own, and one that serves several", async () => {
    const alone = await decodeAll(cut(data, 300), { worker: true, budget: 1 });
    compare(alone, mesh, { map, faceMap }, tolerances);
    const worker = new Worker(new URL(import.meta.resolve("conquest-mesh/worker.js"))),
        both = [1, 2].map(() => decodeAll(cut(data, 300), { worker, budget: 1 }));
    for (const state of await Promise.all(both)) compare(state, mesh, { map, faceMap }, tolerances);
    const damaged = data.slice();
    damaged[300] ^= 1;
    await assert.rejects(decodeAll(damaged, { worker }), e => e instanceof StreamError && e.byte > 300);
    await assert.rejects(decodeAll(data.subarray(0, 300), { worker }), TruncatedError);
    await worker.terminate();
});

test("a worker that cannot start is an error; a signal ends a wait for one that does not answer", async () => {
    const broken = new Worker("throw new Error('out of order')", { eval: true }),
        silent = new Worker("setInterval(() => {}, 1000)", { eval: true }),
        abort = new AbortController();
    await assert.rejects(decodeAll(data, { worker: broken }), /out of order/);
    setTimeout(() => abort.abort(), 20);
    await assert.rejects(decodeAll(data, { worker: silent, signal: abort.signal }), { name: "AbortError" });
    await silent.terminate();
});

test("a bad mesh is an error with its place", async () => {
    const { positions, index } = makeSphere(8, 4);
    const bad = index.slice();
    bad[5] = 1000;
    await assert.rejects(encode({ positions, index: bad }), e => e instanceof MeshError && e.face === 1);
    const nan = positions.slice();
    nan[30] = NaN;
    await assert.rejects(
        encode({ positions: nan, index }),
        e => e instanceof MeshError && e.vertex === 10 && /positions/.test(e.message),
    );
    await assert.rejects(encode({ positions, index, colours: positions }), TypeError);
    await assert.rejects(encode({ positions, index, texcoords: positions }), RangeError);
    const none = new Float32Array(0);
    await assert.rejects(encode({ positions: none, index: [] }), /^RangeError: positions: the mesh has no vertices$/);
    await assert.rejects(encode({ positions, index: [], facegroups: [] }), /^RangeError: facegroups: the mesh has no faces$/);
});

test("progress, goals, connectivity alone", async () => {
    const plain = makeSphere(),
        calls = [];
    await encode(plain, { progress: (done, total) => calls.push([done, total]) });
    assert.ok(calls.length > 0 && calls.every(([done, total]) => done <= total), JSON.stringify(calls));
    const least = await encode({ index: plain.index }, { goal: "least-connectivity" });
    assert.equal((await decodeAll(least.data)).numVertices, plain.positions.length / 3);
});

test("a survey grid is relative to its origin", async () => {
    const { positions, index } = makeSphere(),
        origin = [500000, 5400000, 100];
    const far = Float64Array.from(positions, (x, k) => x + origin[k % 3]);
    const encoded = await encode({ positions: far, index }, { bits: 14 });
    const { array, offset } = (await decodeAll(encoded.data)).attributes.positions;
    far.forEach((x, i) => {
        const got = offset[i % 3] + array[3 * encoded.map[Math.floor(i / 3)] + (i % 3)];
        assert.ok(Math.abs(got - x) < 2e-4, `${i}: ${got}, expected ${x}`);
    });
});

test("streams of the command line decode; its decoder takes ours", async () => {
    const cqm = join(root, "build", "cqm"),
        off = join(here, "sphere.off"),
        file = join(here, "sphere.cqm");
    const { positions, index } = makeSphere();
    const lines = [`OFF\n${positions.length / 3} ${index.length / 3} 0`];
    for (let k = 0; k < positions.length; k += 3) lines.push(positions.subarray(k, k + 3).join(" "));
    for (let k = 0; k < index.length; k += 3) lines.push(`3 ${index.subarray(k, k + 3).join(" ")}`);
    writeFileSync(off, lines.join("\n") + "\n");
    execFileSync(cqm, ["encode", off, file]);
    const theirs = readFileSync(file),
        ours = (await encode({ positions, index })).data;
    assert.deepEqual(Buffer.from(ours), theirs);
    assert.equal((await decodeAll(theirs)).numFaces, index.length / 3);
});

test("types: what a program may write compiles, what it may not does not", () => {
    const tsc = join(root, "build", "web", "npm", "node_modules", ".bin", "tsc");
    const options = "--noEmit --strict --skipLibCheck --target es2022 --module nodenext --lib es2023,dom,dom.asynciterable";
    execFileSync(tsc, [...options.split(" "), "--types", "", "consumer.ts"], { cwd: here, stdio: "pipe" });
});

test("the small decoder has at most 40 KB, 16 KB compressed", () => {
    const read = name => readFileSync(join(root, "build", "web", `${name}.wasm`)),
        decoder = read("decoder"),
        compressed = brotliCompressSync(decoder).length;
    console.log(`decoder: ${decoder.length} bytes, ${compressed} compressed`);
    for (const name of ["full", "encoder"]) console.log(`${name}: ${read(name).length} bytes`);
    assert.ok(decoder.length <= 40960 && compressed <= 16384);
});
