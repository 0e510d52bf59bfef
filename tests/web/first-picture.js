/* Time to picture: when bytes of a network of some rate have become a picture, by several codecs. Writes a table,
 * results.tsv
 * and a plot: node first-picture.js MESHES FOLDER. SPDX-License-Identifier: MIT
 *
 * Bytes arrive at the rate, without latency. Decoders run in this program, on one thread; their times are measured, and
 * added to when their bytes were there. Of ours that is done piece by piece, as a page would. Positions have 14 bits.
 * */
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { MeshoptSimplifier } from "meshoptimizer/simplifier";
import { Decoder, encode } from "conquest-mesh";
import { meshoptDecode, meshoptEncode, openDraco } from "./codecs.js";

const [meshes, folder] = process.argv.slice(2),
    BITS = 14,
    PIECE = 1400;
const RATES = { "1 Mbit/s": 125, "10 Mbit/s": 1250, "100 Mbit/s": 12500, "local file": Infinity }; // bytes per ms
const draco = await openDraco(createRequire(import.meta.url)("draco3d"));
await MeshoptSimplifier.ready;
mkdirSync(folder, { recursive: true });

// -- Meshes --

function readOff(name) {
    const words = readFileSync(join(meshes, `${name}.off`), "utf8")
        .replace(/#.*/g, "")
        .split(/\s+/)
        .filter(Boolean);
    const [vertices, faces] = words.slice(1, 3).map(Number),
        index = [];
    for (let f = 0, at = 4 + 3 * vertices; f < faces; f++) {
        const corners = words.slice(at + 1, at + 1 + Number(words[at])).map(Number);
        for (let k = 2; k < corners.length; k++) index.push(corners[0], corners[k - 1], corners[k]);
        at += 1 + corners.length;
    }
    return { index: Uint32Array.from(index), positions: Float32Array.from(words.slice(4, 4 + 3 * vertices)) };
}

/** Hills: sums of waves, each half as high and twice as fast as the one before. */
function makeTerrain(size) {
    const positions = [],
        index = [];
    const height = (x, y) =>
        [1, 2, 4, 8, 16, 32].reduce(
            (z, f) => z + (Math.sin(7.1 * f * x + 1.3 * f) * Math.sin(6.3 * f * y + 0.7 * f * f)) / (6 * f),
            0,
        );
    for (let y = 0; y < size; y++)
        for (let x = 0; x < size; x++) {
            positions.push(x / size, y / size, height(x / size, y / size));
            if (x && y) {
                const v = y * size + x;
                index.push(v - size - 1, v - size, v, v - size - 1, v, v - 1);
            }
        }
    return { index: Uint32Array.from(index), positions: Float32Array.from(positions) };
}

function addNormals({ index, positions, ...rest }) {
    const normals = new Float32Array(positions.length),
        at = v => positions.subarray(3 * v, 3 * v + 3);
    for (let f = 0; f < index.length; f += 3) {
        const [a, b, c] = [0, 1, 2].map(k => at(index[f + k])),
            u = b.map((x, k) => x - a[k]),
            w = c.map((x, k) => x - a[k]);
        const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
        for (let k = 0; k < 3; k++)
            n.forEach((x, i) => {
                normals[3 * index[f + k] + i] += x;
            });
    }
    for (let v = 0; v < normals.length; v += 3) {
        const length = Math.hypot(...normals.subarray(v, v + 3));
        normals.set(length ? normals.subarray(v, v + 3).map(x => x / length) : [0, 0, 1], v);
    }
    return { index, positions, normals, ...rest };
}

/** Texture coordinates around the longest axis, with a seam behind: vertices there have two rows. */
function wrap(mesh) {
    const { index, positions, normals } = addNormals(mesh),
        centre = [0, 1, 2].map(
            k => positions.filter((_, i) => i % 3 === k).reduce((a, x) => a + x, 0) / (positions.length / 3),
        );
    const rows = { index: [], positions: [], normals: [], texcoords: [] },
        seen = new Map();
    const around = v =>
        Math.atan2(positions[3 * v] - centre[0], positions[3 * v + 2] - centre[2]) / (2 * Math.PI) + 0.5;
    for (let f = 0; f < index.length; f += 3) {
        const corners = [0, 1, 2].map(k => index[f + k]),
            u = corners.map(around),
            crosses = Math.max(...u) - Math.min(...u) > 0.5;
        corners.forEach((v, k) => {
            const over = crosses && u[k] < 0.5,
                key = `${v} ${over}`;
            if (!seen.has(key)) {
                seen.set(key, rows.positions.length / 3);
                rows.positions.push(...positions.subarray(3 * v, 3 * v + 3));
                rows.normals.push(...normals.subarray(3 * v, 3 * v + 3));
                rows.texcoords.push(u[k] + (over ? 1 : 0), positions[3 * v + 1]);
            }
            rows.index.push(seen.get(key));
        });
    }
    return {
        index: Uint32Array.from(rows.index),
        positions: Float32Array.from(rows.positions),
        normals: Float32Array.from(rows.normals),
        texcoords: Float32Array.from(rows.texcoords),
    };
}

/** Bones along the y axis, each vertex between two of them. */
function addSkin(mesh) {
    const y = mesh.positions.filter((_, i) => i % 3 === 1),
        low = y.reduce((a, b) => Math.min(a, b)),
        extent = y.reduce((a, b) => Math.max(a, b)) - low;
    const joints = new Uint8Array(4 * y.length),
        weights = new Float32Array(4 * y.length);
    y.forEach((value, v) => {
        const at = ((value - low) / extent) * 19,
            bone = Math.min(Math.floor(at), 18);
        joints.set([bone, bone + 1], 4 * v);
        weights.set([1 - (at - bone), at - bone], 4 * v);
    });
    return { ...mesh, joints, weights };
}

function repeat({ index, positions }, count) {
    const extent =
            positions.reduce((a, x) => Math.max(a, x), -Infinity) -
            positions.reduce((a, x) => Math.min(a, x), Infinity),
        n = positions.length / 3;
    const all = {
        index: new Uint32Array(index.length * count ** 2),
        positions: new Float32Array(positions.length * count ** 2),
    };
    for (let k = 0; k < count ** 2; k++) {
        all.index.set(
            index.map(v => v + k * n),
            k * index.length,
        );
        all.positions.set(
            positions.map((x, i) => x + extent * 1.1 * [k % count, Math.floor(k / count), 0][i % 3]),
            k * positions.length,
        );
    }
    return all;
}

const MESHES = {
    "scan: bunny00": () => readOff("bunny00"),
    "CAD: fandisk": () => readOff("fandisk"),
    terrain: () => makeTerrain(200),
    "textured: ChineseDragon": () => wrap(readOff("ChineseDragon-10kv")),
    "skin: armadillo": () => addSkin(addNormals(readOff("armadillo"))),
    "parts: 36 x pinion": () => repeat(readOff("pinion_small"), 6),
};

// -- Codecs: each gives its moments [bytes, milliseconds of decoding before, error], errors of the diagonal --

const ROUNDS = 5; // the fastest counts, of each piece: of compiled code, least disturbed

const time = async work => {
    let least = Infinity;
    for (let k = 0; k < ROUNDS; k++) {
        const start = performance.now();
        await work();
        least = Math.min(least, performance.now() - start);
    }
    return least;
};

/** Ours, piece by piece: what each piece took, and the error of the mesh then. */
async function ours(mesh, diagonal) {
    const { index, positions, normals, texcoords, joints, weights } = mesh;
    const { data } = await encode({ index, positions, normals, texcoords, joints, weights }, { bits: BITS });
    let best = null;
    for (let round = 0; round < ROUNDS; round++) {
        const decoder = await Decoder.create(),
            moments = [];
        for (let at = 0; at < data.length; at += PIECE) {
            const piece = data.subarray(at, at + PIECE),
                start = performance.now();
            await decoder.feed(piece);
            decoder.decode();
            const state = decoder.state();
            moments.push({
                bytes: at + piece.length,
                work: performance.now() - start,
                error: state ? state.error / diagonal : NaN,
                shown: Boolean(state),
            });
        }
        best = best ? moments.map((m, k) => ({ ...m, work: Math.min(m.work, best[k].work) })) : moments;
    }
    return { bytes: data.length, moments: best };
}

const single = async (bytes, work) => ({ bytes, moments: [{ bytes, work: await time(work), error: 0, shown: true }] });

async function byDraco(mesh, level) {
    const bytes = draco.encode({ ...mesh, bits: BITS }, level);
    return single(bytes.length, () => draco.decode(bytes));
}

/** The time of zstd's own decoder is not counted. */
async function byMeshopt(mesh) {
    const encoded = await meshoptEncode({ ...mesh, bits: BITS });
    const packed = execFileSync("zstd", ["-19", "-q", "-c"], { input: encoded.bytes, maxBuffer: 1 << 28 });
    return single(packed.length, () => meshoptDecode(encoded));
}

/** A quarter, a half and all of the triangles as files of their own, the coarsest first. */
async function byLevels(mesh, diagonal) {
    const moments = [],
        scale = MeshoptSimplifier.getScale(mesh.positions, 3);
    let bytes = 0;
    for (const share of [0.25, 0.5, 1]) {
        const [index, error] =
            share === 1
                ? [mesh.index, 0]
                : MeshoptSimplifier.simplify(
                      mesh.index,
                      mesh.positions,
                      3,
                      3 * Math.floor((share * mesh.index.length) / 3),
                      1,
                  );
        const level = draco.encode({ ...compact(mesh, index), bits: BITS }, 7);
        bytes += level.length;
        moments.push({
            bytes,
            work: await time(() => draco.decode(level)),
            error: (error * scale) / diagonal,
            shown: true,
        });
    }
    return { bytes, moments };
}

/** A mesh of the vertices that an index names. */
function compact(mesh, index) {
    const numbers = new Map();
    index.forEach(v => {
        if (!numbers.has(v)) numbers.set(v, numbers.size);
    });
    const pick = (array, width) =>
        array.constructor.from(
            Array.from(numbers.keys()).flatMap(v => Array.from(array.subarray(width * v, width * (v + 1)))),
        );
    const widths = { positions: 3, normals: 3, texcoords: 2, joints: 4, weights: 4 };
    return {
        index: Uint32Array.from(index, v => numbers.get(v)),
        ...Object.fromEntries(
            Object.entries(widths)
                .filter(([name]) => mesh[name])
                .map(([name, width]) => [name, pick(mesh[name], width)]),
        ),
    };
}

/** When is the error at most so much? A piece is decoded when it is there and the one before is done. */
function when(moments, rate, isThere) {
    let clock = 0;
    for (const moment of moments) {
        clock = Math.max(clock, moment.bytes / rate) + moment.work;
        if (moment.shown && isThere(moment)) return clock;
    }
    return NaN;
}

// -- Results --

const GOALS = {
    first: () => true,
    "1 %": m => m.error <= 0.01,
    "0.1 %": m => m.error <= 0.001,
    exact: m => m.error === 0,
};
const rows = [];
for (const [name, make] of Object.entries(MESHES)) {
    const mesh = make(),
        box = [0, 1, 2]
            .map(k => mesh.positions.filter((_, i) => i % 3 === k))
            .map(a => a.reduce((x, y) => Math.max(x, y)) - a.reduce((x, y) => Math.min(x, y)));
    const diagonal = Math.hypot(...box);
    const codecs = {
        conquest: await ours(mesh, diagonal),
        "Draco 7": await byDraco(mesh, 7),
        "Draco 10": await byDraco(mesh, 10),
        "meshopt + zstd": await byMeshopt(mesh),
        "three files": await byLevels(mesh, diagonal),
    };
    for (const [codec, { bytes, moments }] of Object.entries(codecs))
        for (const [rate, value] of Object.entries(RATES))
            rows.push({
                name,
                triangles: mesh.index.length / 3,
                codec,
                bytes,
                rate,
                ...Object.fromEntries(Object.entries(GOALS).map(([goal, is]) => [goal, when(moments, value, is)])),
            });
}
writeFileSync(
    join(folder, "results.tsv"),
    [Object.keys(rows[0]), ...rows.map(Object.values)].map(r => r.join("\t")).join("\n") + "\n",
);

const show = x => (Number.isNaN(x) ? "-" : x < 10 ? x.toFixed(1) : x.toFixed(0));
for (const rate of Object.keys(RATES)) {
    console.log(
        `\n${rate}, milliseconds\n\n| mesh | codec | bytes | first picture | within 1 % | within 0.1 % | exact |\n| --- | --- | ---: | ---: | ---: | ---: | ---: |`,
    );
    for (const r of rows.filter(r => r.rate === rate))
        console.log(
            `| ${r.name}, ${r.triangles} triangles | ${r.codec} | ${r.bytes} | ${Object.keys(GOALS)
                .map(goal => show(r[goal]))
                .join(" | ")} |`,
        );
}
const at = rows.filter(r => r.rate === "10 Mbit/s"),
    ofOurs = at.filter(r => r.codec === "conquest");
const ratios = ofOurs.map(
    o => Math.min(...at.filter(r => r.name === o.name && /Draco|meshopt/.test(r.codec)).map(r => r.first)) / o.first,
);
const late = ofOurs.filter(
    o => o.exact > Math.min(...at.filter(r => r.name === o.name && /Draco/.test(r.codec)).map(r => r.exact)),
);
console.log(
    `\nAt 10 Mbit/s the first picture comes ${show(Math.min(...ratios))} to ${show(Math.max(...ratios))} times earlier than of any single-rate codec; ` +
        `the exact mesh later than Draco's of ${late.length} of ${ofOurs.length} meshes${late.length ? `: ${late.map(o => o.name).join(", ")}` : ""}.`,
);

// -- Plot: a line for each mesh and codec at 10 Mbit/s, from the first picture to the exact mesh, logarithmic --

const COLOURS = {
    conquest: "#0a6c74",
    "Draco 7": "#b4552d",
    "Draco 10": "#d98a5f",
    "meshopt + zstd": "#7a5ea8",
    "three files": "#8a8f98",
};
const [least, most] = [0.5, Math.max(...at.map(r => r.exact)) * 1.3],
    left = 260,
    width = 620,
    line = 14;
const x = t => left + (width * Math.log(Math.max(t, least) / least)) / Math.log(most / least);
const height = at.length * line + Object.keys(MESHES).length * 14 + 66,
    parts = [];
let y = 40;
for (const t of [1, 10, 100, 1000].filter(t => t < most))
    parts.push(
        `<path d="M${x(t)} 30V${height - 28}" stroke="#8884"/><text x="${x(t)}" y="${height - 12}" text-anchor="middle">${t} ms</text>`,
    );
for (const name of Object.keys(MESHES)) {
    parts.push(`<text x="8" y="${y + 10}" font-weight="600">${name}</text>`);
    for (const r of at.filter(r => r.name === name)) {
        const c = COLOURS[r.codec];
        parts.push(
            `<text x="${left - 10}" y="${y + 10}" text-anchor="end">${r.codec}</text><path d="M${x(r.first)} ${y + 6}H${x(r.exact)}" stroke="${c}" stroke-width="4"/>`,
            ...Object.keys(GOALS).map((goal, k) =>
                Number.isNaN(r[goal])
                    ? ""
                    : `<circle cx="${x(r[goal])}" cy="${y + 6}" r="${[4, 3, 3, 5][k]}" fill="${k % 3 ? "#fff" : c}" stroke="${c}" stroke-width="1.5"/>`,
            ),
        );
        y += line;
    }
    y += 14;
}
writeFileSync(
    join(folder, "first-picture.svg"),
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${left + width + 30} ${height}" font-family="sans-serif" font-size="11" fill="#222">
<rect width="100%" height="100%" fill="#fff"/><text x="8" y="20" font-size="13">10 Mbit/s, milliseconds. Dots: first picture; open: within 1 % and 0.1 % of the diagonal; large: exact mesh</text>
${parts.join("\n")}\n</svg>\n`,
);
