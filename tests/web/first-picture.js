/* Time to picture: when bytes of a network of some rate have become a picture, by several codecs. Writes a table,
 * results.tsv and plots: node first-picture.js MESHES FOLDER TEXTURED SKINNED, the last two models of any format that assimp
 * reads. SPDX-License-Identifier: MIT
 *
 * Bytes arrive at the rate, in packets, without latency. Decoders run in this program, on one thread, and are compiled
 * before; the time of the processor that they take is measured, until all that vertices have is there. Ours does what a
 * page does: it takes the packets that have arrived meanwhile, decodes for a few milliseconds, gives a state, and goes
 * on. Positions have 14 bits, the rest what conquest.js gives it. */
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { MeshoptSimplifier } from "meshoptimizer/simplifier";
import { Decoder, encode, openCodec } from "conquest-mesh";
import { parseOff } from "./off.js";
import { meshoptDecode, meshoptEncode, openDraco } from "./codecs.js";

const [meshes, folder, textured, skinned] = process.argv.slice(2),
    BITS = 14,
    PACKET = 1400,
    BUDGET = 4;
const RATES = { "1 Mbit/s": 125, "10 Mbit/s": 1250, "100 Mbit/s": 12500, "local file": Infinity }; // bytes per ms
const draco = await openDraco(createRequire(import.meta.url)("draco3d"));
await MeshoptSimplifier.ready;
await openCodec(); // the full decoder is there, as Draco's is
mkdirSync(folder, { recursive: true });

// -- Meshes --

const readOff = name => parseOff(readFileSync(join(meshes, `${name}.off`), "utf8"));

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

/** A model's parts as one mesh, with all that its vertices have; `steps` of assimp. */
function readModel(file, ...steps) {
    const path = join(folder, "model.json"),
        influences = [],
        index = [];
    execFileSync("assimp", ["export", file, path, "-fassjson", "-tri", "-jiv", ...steps], { stdio: "ignore" });
    const { meshes: parts } = JSON.parse(readFileSync(path, "utf8"));
    const gather = array => Float32Array.from(parts.flatMap(array)),
        names = [...new Set(parts.flatMap(part => (part.bones ?? []).map(bone => bone.name)))];
    for (const { vertices, faces, bones = [] } of parts) {
        const first = influences.length;
        faces.flat().forEach(v => index.push(first + v));
        for (let v = 0; v < vertices.length; v += 3) influences.push([]);
        for (const { name, weights = [] } of bones)
            weights.forEach(([v, weight]) => influences[first + v].push({ joint: names.indexOf(name), weight }));
    }
    const four = key => influences.flatMap(list => [0, 1, 2, 3].map(k => list[k]?.[key] ?? 0));
    return {
        index: Uint32Array.from(index),
        positions: gather(part => part.vertices),
        normals: gather(part => part.normals),
        texcoords: gather(part => part.texturecoords[0]),
        ...(names.length && { joints: Uint8Array.from(four("joint")), weights: Float32Array.from(four("weight")) }),
    };
}

/** Meshes side by side, each of size 1. Not several of one: files have such once, as instances. */
function assemble(parts) {
    const index = [],
        positions = [],
        columns = Math.ceil(Math.sqrt(parts.length));
    parts.forEach((part, k) => {
        const size = part.positions.reduce((a, x) => Math.max(a, x)) - part.positions.reduce((a, x) => Math.min(a, x)),
            first = positions.length / 3,
            place = [k % columns, Math.floor(k / columns), 0];
        part.index.forEach(v => index.push(first + v));
        part.positions.forEach((x, i) => positions.push(x / size + place[i % 3]));
    });
    return { index: Uint32Array.from(index), positions: Float32Array.from(positions) };
}

const PARTS =
    "anchor couplingdown cross cube-meshed dragknob handle itemb joint part pinion_small pipe rotor rotor_small spool tripod u";

const MESHES = {
    "scan: bunny00": () => readOff("bunny00"),
    "CAD: fandisk": () => readOff("fandisk"),
    terrain: () => makeTerrain(200),
    "textured: HTC Vive controller": () => readModel(textured, "-ptv"), // parts where they stand
    "skin: BCN_Epileptic": () => readModel(skinned, "-lbw"), // four bones for a vertex
    "16 parts": () => assemble(PARTS.split(" ").map(readOff)),
};

// -- Codecs: each gives its bytes, and its moments at a rate: [milliseconds, error, shown], errors of the diagonal --

const ROUNDS = 15; // the fastest counts: of compiled code, least disturbed

/** Milliseconds of the processor: others that run on this machine do not count. */
function processorTime() {
    const { user, system } = process.cpuUsage();
    return (user + system) / 1000;
}

const time = async work => {
    let least = Infinity;
    for (let k = 0; k < ROUNDS; k++) {
        const start = processorTime();
        await work();
        least = Math.min(least, processorTime() - start);
    }
    return least;
};

/** Ours at some rate: a clock that runs while it decodes, and leaps to the next packet when it has nothing to do. */
async function decodeAt(data, rate, diagonal) {
    const decoder = await Decoder.create(),
        moments = [];
    for (let clock = 0, fed = 0; !decoder.complete;) {
        const arrived = clock * rate < data.length ? Math.floor((clock * rate) / PACKET) * PACKET : data.length,
            start = processorTime();
        if (arrived > fed) await decoder.feed(data.subarray(fed, arrived));
        fed = arrived;
        const more = await decoder.decode(BUDGET),
            state = decoder.state();
        clock += processorTime() - start;
        moments.push({ clock, error: state ? state.error / diagonal : NaN, shown: Boolean(state) });
        if (!more) clock = Math.max(clock, Math.min(fed + PACKET, data.length) / rate);
    }
    return moments;
}

async function ours({ index, positions, normals, texcoords, joints, weights }, diagonal) {
    const { data } = await encode({ index, positions, normals, texcoords, joints, weights }, { bits: BITS });
    const rounds = async rate => {
        const all = [];
        for (let round = 0; round < ROUNDS; round++) all.push(await decodeAt(data, rate, diagonal));
        return all;
    };
    return { bytes: data.length, rounds };
}

/** Files that are decoded when they are there: when each has come, and the time of its decoder. */
const files = (bytes, levels) => ({
    bytes,
    rounds: async rate => {
        let clock = 0;
        return [
            levels.map(({ arrived, work, error }) => {
                clock = Math.max(clock, arrived / rate) + work;
                return { clock, error, shown: true };
            }),
        ];
    },
});

/** A file of all that a mesh has, and its decoder. */
async function single(mesh, bytes, decode) {
    const decoded = await decode(),
        lost = Object.keys(mesh).filter(key => !decoded[key]?.length);
    if (lost.length) throw new Error(`a decoder gives no ${lost.join(", ")}`);
    return files(bytes, [{ arrived: bytes, work: await time(decode), error: 0 }]);
}

async function byDraco(mesh, level) {
    const bytes = draco.encode({ ...mesh, bits: BITS }, level);
    return single(mesh, bytes.length, () => draco.decode(bytes));
}

/** The time of zstd's own decoder is not counted. */
async function byMeshopt(mesh) {
    const encoded = await meshoptEncode({ ...mesh, bits: BITS });
    const packed = execFileSync("zstd", ["-19", "-q", "-c"], { input: encoded.bytes, maxBuffer: 1 << 28 });
    return single(mesh, packed.length, () => meshoptDecode(encoded));
}

/** A quarter, a half and all of the triangles as files of their own, the coarsest first. */
async function byLevels(mesh, diagonal) {
    const levels = [],
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
        levels.push({ arrived: bytes, work: await time(() => draco.decode(level)), error: (error * scale) / diagonal });
    }
    return files(bytes, levels);
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

/** When is the error at most so much? The earliest of all rounds. */
const when = (rounds, isThere) =>
    rounds
        .map(moments => moments.find(m => m.shown && isThere(m))?.clock ?? NaN)
        .reduce((a, b) => (b > a ? a : b), NaN);

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
    for (const [codec, { bytes, rounds }] of Object.entries(codecs))
        for (const [rate, value] of Object.entries(RATES)) {
            const all = await rounds(value);
            rows.push({
                name,
                triangles: mesh.index.length / 3,
                codec,
                bytes,
                rate,
                ...Object.fromEntries(Object.entries(GOALS).map(([goal, is]) => [goal, when(all, is)])),
            });
        }
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
// -- Goals at 10 Mbit/s: the first picture 10 times earlier than by a single-rate codec, the exact mesh not after Draco's --

console.log("");
for (const rate of Object.keys(RATES)) {
    const at = rows.filter(r => r.rate === rate),
        ofOurs = at.filter(r => r.codec === "conquest"),
        best = (o, codec, goal) => Math.min(...at.filter(r => r.name === o.name && codec.test(r.codec)).map(r => r[goal]));
    const ratios = ofOurs.map(o => best(o, /Draco|meshopt/, "first") / o.first),
        times = ofOurs.map(o => o.exact / best(o, /Draco/, "exact")),
        late = ofOurs.filter((_, k) => times[k] > 1).map(o => o.name);
    console.log(
        `${rate}: first picture ${show(Math.min(...ratios))} to ${show(Math.max(...ratios))} times earlier than of any ` +
            `single-rate codec; exact mesh after ${Math.min(...times).toFixed(2)} to ${Math.max(...times).toFixed(2)} of ` +
            `Draco's time, later for ${late.length} of ${ofOurs.length} meshes${late.length ? `: ${late.join(", ")}` : ""}`,
    );
    if (rate === "10 Mbit/s" && (Math.min(...ratios) < 10 || late.length)) {
        console.log("      which misses the goals of 10 times earlier, and of none later");
        process.exitCode = 1;
    }
}

// -- Plots, one for each rate: a line for each mesh and codec, from the first picture to the exact mesh, logarithmic --

const COLOURS = {
    conquest: "#0a6c74",
    "Draco 7": "#b4552d",
    "Draco 10": "#d98a5f",
    "meshopt + zstd": "#7a5ea8",
    "three files": "#8a8f98",
};

function plot(rate) {
    const at = rows.filter(r => r.rate === rate),
        [least, most] = [Math.min(...at.map(r => r.first)) / 1.5, Math.max(...at.map(r => r.exact)) * 1.3],
        left = 260,
        width = 620,
        line = 14,
        height = at.length * line + Object.keys(MESHES).length * 14 + 66,
        x = t => left + (width * Math.log(t / least)) / Math.log(most / least),
        parts = [];
    let y = 40;
    for (const t of [0.1, 1, 10, 100, 1000, 10000].filter(t => t > least && t < most))
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
    return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${left + width + 30} ${height}" font-family="sans-serif" font-size="11" fill="#222">
<rect width="100%" height="100%" fill="#fff"/><text x="8" y="20" font-size="13">${rate}, milliseconds. Dots: first picture; open: within 1 % and 0.1 % of the diagonal; large: exact mesh</text>
${parts.join("\n")}\n</svg>\n`;
}

for (const rate of Object.keys(RATES))
    writeFileSync(join(folder, `${rate.replace(/\W/g, "-")}.svg`), plot(rate));
