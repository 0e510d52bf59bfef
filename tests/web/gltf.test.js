/* glTF files with CONQUEST_mesh_progressive: there and back, valid, all else untouched. SPDX-License-Identifier: MIT */
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readdirSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { test } from "node:test";
import draco from "draco3d";
import { MeshoptEncoder } from "meshoptimizer";
import { Logger, NodeIO, getBounds } from "@gltf-transform/core";
import { ALL_EXTENSIONS, EXTMeshoptCompression, KHRDracoMeshCompression } from "@gltf-transform/extensions";
import validator from "gltf-validator";
import { openCodec } from "conquest-mesh";
import { ConquestMeshProgressive, NAME, progressive } from "conquest-mesh/gltf-transform";
import { makeDocument, makeParts, makeShapes } from "./documents.js";
import { SHAPES } from "./shapes.js";

const io = new NodeIO()
    .registerExtensions([...ALL_EXTENSIONS, ConquestMeshProgressive])
    .registerDependencies({ conquest: await openCodec() });

/** Triangles of a primitive as triples of complete rows, sorted; of other modes the rows. */
function listTriangles(primitive, digits) {
    const accessors = [
        ...primitive
            .listSemantics()
            .sort()
            .map(key => primitive.getAttribute(key)),
        ...primitive.listTargets().flatMap(t =>
            t
                .listSemantics()
                .sort()
                .map(key => t.getAttribute(key)),
        ),
    ];
    const row = v =>
        accessors
            .map(a =>
                Array.from(a.getArray().subarray(v * a.getElementSize(), (v + 1) * a.getElementSize()), x =>
                    digits === undefined ? String(x + 0) : x.toFixed(digits),
                ).join(","),
            )
            .join(";");
    const index = primitive.getIndices()?.getArray() ?? Array.from({ length: accessors[0].getCount() }, (_, k) => k);
    if (primitive.getMode() !== 4) return Array.from(index, row);
    return Array.from({ length: index.length / 3 }, (_, f) => {
        const corners = [0, 1, 2].map(k => row(index[3 * f + k])),
            first = corners.indexOf([...corners].sort()[0]);
        return [0, 1, 2].map(k => corners[(first + k) % 3]).join(" | ");
    }).sort();
}

/** All but the geometry. */
const describeRest = document => {
    const root = document.getRoot();
    return {
        nodes: root.listNodes().map(n => [n.getName(), n.getMatrix(), n.getMesh()?.getName(), n.getSkin()?.getName()]),
        materials: root
            .listMaterials()
            .map(m => [m.getName(), m.getBaseColorFactor(), m.getBaseColorTexture()?.getName()]),
        textures: root.listTextures().map(t => [t.getName(), t.getImage()]),
        skins: root
            .listSkins()
            .map(s => [s.listJoints().map(j => j.getName()), s.getInverseBindMatrices()?.getArray()]),
        meshes: root
            .listMeshes()
            .map(m => [
                m.getName(),
                m.getWeights(),
                m
                    .listPrimitives()
                    .map(p => [
                        p.getMode(),
                        p.getMaterial()?.getName(),
                        p.listSemantics().sort(),
                        p.listTargets().map(t => t.getName()),
                    ]),
            ]),
        animations: root.listAnimations().map(a => a.getName()),
    };
};

/** What comes back, and what came back without streams: writing alone rounds matrices of nodes. */
async function goThereAndBack(original, bits) {
    const document = await io.readBinary(await io.writeBinary(original));
    const before = {
        rest: describeRest(document),
        triangles: document
            .getRoot()
            .listMeshes()
            .flatMap(m => m.listPrimitives().map(p => listTriangles(p))),
        bounds: document.getRoot().listScenes().map(getBounds),
    };
    await document.transform(progressive({ bits }));
    const glb = await io.writeBinary(document),
        back = await io.readBinary(glb);
    return { before, glb, back, json: (await io.binaryToJSON(glb)).json };
}

async function check(document) {
    const { before, glb, back, json } = await goThereAndBack(document, 32);
    assert.deepEqual(describeRest(back), before.rest);
    assert.deepEqual(
        back
            .getRoot()
            .listMeshes()
            .flatMap(m => m.listPrimitives().map(p => listTriangles(p))),
        before.triangles,
    );
    assert.deepEqual(back.getRoot().listScenes().map(getBounds), before.bounds);
    const report = await validator.validateBytes(new Uint8Array(glb));
    const errors = report.issues.messages.filter(m => m.severity === 0 && m.code !== "UNSUPPORTED_EXTENSION");
    assert.deepEqual(errors, []);
    return { glb, json };
}

test("skins, morph targets, textures, nodes and lines come back, floats bit for bit", async () => {
    const { json } = await check(makeDocument());
    const found = json.meshes.flatMap(m => m.primitives).filter(p => p.extensions?.[NAME]);
    assert.equal(found.length, 3);
    assert.ok(json.extensionsRequired.includes(NAME));
    assert.deepEqual(
        json.meshes.map(m => m.primitives.map(p => p.extensions?.[NAME]?.group ?? 0)),
        [[0], [0, 1, 0]],
    );
    const views = new Set(found.map(p => p.extensions[NAME].bufferView)),
        first = Math.min(...[...views].map(v => json.bufferViews[v].byteOffset));
    assert.equal(views.size, 2, "primitives of a mesh share a stream");
    json.bufferViews.forEach((view, k) =>
        assert.ok(views.has(k) || (view.byteOffset ?? 0) < first, "streams are at the end"),
    );
});

test("primitives of a mesh share a stream and their vertices; meshes share nothing", async () => {
    const document = makeParts(),
        used = new Set(document.getRoot().listAccessors().slice(2, 4).flatMap(a => Array.from(a.getArray())));
    const { json } = await check(document);
    const [parts, [other]] = json.meshes.map(m => m.primitives),
        accessors = parts.map(p => p.attributes.POSITION);
    assert.equal(new Set(accessors).size, 1);
    const all = 2 + 24 * 11; // and those of the first two that only the third has faces at, again
    assert.equal(json.accessors[accessors[0]].count, all + (all - used.size));
    assert.ok(other.attributes.POSITION !== accessors[0] && other.indices !== parts[0].indices);
    assert.notEqual(other.extensions[NAME].bufferView, parts[0].extensions[NAME].bufferView);
});

for (const name of Object.keys(SHAPES))
    test(`there and back: ${name}`, async () => {
        const { json } = await check(makeShapes({ [name]: SHAPES[name] }));
        assert.ok(json.meshes[0].primitives[0].extensions[NAME]);
    });

test("with 14 bits it is smaller and as close as the grid", async () => {
    const exact = await goThereAndBack(makeDocument(), 32),
        small = await goThereAndBack(makeDocument(), 14);
    assert.ok(small.glb.length < exact.glb.length, `${small.glb.length}, ${exact.glb.length}`);
    const [a, b] = [exact, small].map(x => x.back.getRoot().listScenes().map(getBounds)[0]);
    for (const end of ["min", "max"])
        a[end].forEach((x, k) => assert.ok(Math.abs(x - b[end][k]) < 1e-3, `${end} ${x}, ${b[end][k]}`));
    assert.deepEqual(describeRest(small.back), describeRest(exact.back));
});

const command = join("node_modules", ".bin", "conquest-gltf");

test("the command makes a file progressive, and plain again", async () => {
    const before = makeDocument();
    const triangles = d => d.getRoot().listMeshes().flatMap(m => m.listPrimitives().map(p => listTriangles(p)));
    await io.write("plain.glb", before);
    execFileSync(command, ["plain.glb", "progressive.glb", "32"]);
    execFileSync(command, ["progressive.glb", "again.glb", "--plain"]);
    assert.deepEqual(triangles(await io.read("again.glb")), triangles(before));
    const uses = async name => (await io.readAsJSON(name)).json.extensionsUsed?.includes(NAME) ?? false;
    assert.deepEqual([await uses("progressive.glb"), await uses("again.glb")], [true, false]);
    assert.throws(() => execFileSync(command, ["plain.glb"], { stdio: "pipe" }), { status: 2 });
});

/** A file that is compressed by others. */
async function writeCompressed(name, extension) {
    const document = makeDocument().setLogger(new Logger(Logger.Verbosity.ERROR));
    document.createExtension(extension).setRequired(true);
    await new NodeIO()
        .registerExtensions(ALL_EXTENSIONS)
        .registerDependencies({
            "draco3d.encoder": await draco.createEncoderModule(),
            "meshopt.encoder": await MeshoptEncoder.ready.then(() => MeshoptEncoder),
        })
        .write(name, document);
}

const COMPRESSED = { draco3d: KHRDracoMeshCompression, meshoptimizer: EXTMeshoptCompression };
for (const [name, extension] of Object.entries(COMPRESSED))
    test(`the command reads what ${name} has compressed`, async () => {
        const bounds = document => document.getRoot().listScenes().map(getBounds)[0].max.map(x => x.toFixed(2));
        await writeCompressed(`${name}.glb`, extension);
        execFileSync(command, [`${name}.glb`, "progressive.glb"]);
        const { json } = await io.readAsJSON("progressive.glb"),
            found = json.meshes.flatMap(m => m.primitives).filter(p => p.extensions?.[NAME]);
        assert.equal(found.length, 3);
        assert.ok(!json.extensionsUsed.includes(extension.EXTENSION_NAME), json.extensionsUsed.join(" "));
        const back = await io.read("progressive.glb");
        assert.deepEqual(describeRest(back).materials, describeRest(makeDocument()).materials);
        assert.deepEqual(bounds(back), bounds(makeDocument()));
    });

test("the command says in a line what is wrong", async () => {
    const folder = mkdtempSync(join(tmpdir(), "conquest-")), // packages of the tests are not found from there
        packages = resolve("..", "npm", "node_modules", "@gltf-transform");
    cpSync(resolve("node_modules", "conquest-mesh"), folder, { recursive: true });
    const fail = (file, words, pattern) => {
        const { status, stderr } = spawnSync("node", [file, ...words], { encoding: "utf8" });
        assert.match(stderr, /^conquest-gltf: .*\n$/);
        assert.match(stderr, pattern);
        assert.equal(status, 1);
    };
    await io.write("plain.glb", makeDocument());
    writeFileSync("none.glb", "solid of no mesh");
    writeFileSync("none.gltf", "solid of no mesh");
    fail(command, ["missing.glb", "a.glb"], /no such file.*missing\.glb/);
    fail(command, ["none.glb", "a.glb"], /none\.glb is no glTF 2\.0 file/);
    fail(command, ["none.gltf", "a.glb"], /none\.gltf is no glTF 2\.0 file/);
    fail(command, ["plain.glb", join("no", "a.glb")], /no such file/);
    for (const bits of ["25", "0", "14.5", "many"]) fail(command, ["plain.glb", "a.glb", bits], /BITS have to be/);
    const alone = join(folder, "gltf-command.js");
    fail(alone, ["plain.glb", "a.glb"], /npm install @gltf-transform\/core @gltf-transform\/extensions$/m);
    mkdirSync(join(folder, "node_modules"));
    symlinkSync(packages, join(folder, "node_modules", "@gltf-transform"));
    for (const [name, extension] of Object.entries(COMPRESSED)) {
        await writeCompressed(`${name}.glb`, extension);
        fail(alone, [`${name}.glb`, "a.glb"], new RegExp(`npm install ${name}$`, "m"));
    }
    rmSync(folder, { recursive: true });
});

test("a group or a channel that is not in the stream is an error, and an attribute that is not in the file", async () => {
    const document = makeParts();
    await document.transform(progressive());
    const source = await io.writeJSON(document, { format: "GLB" });
    const read = async change => {
        const json = structuredClone(source.json);
        change(json.meshes[0].primitives[1].extensions[NAME], json);
        return io.readJSON({ json, resources: source.resources });
    };
    await read(() => {});
    await assert.rejects(read(e => (e.group = 3)), /a primitive is group 3, of a stream that has 3/);
    await assert.rejects(read(e => (e.attributes.POSITION = 7)), /POSITION is channel 7, of a stream that has 1/);
    await assert.rejects(read(e => (e.attributes.NORMAL = 0)), /NORMAL is no attribute of the primitive/);
    await assert.rejects(read(e => (e.attributes["POSITION:0"] = 0)), /POSITION:0 is no attribute of the primitive/);
});

// Files of others: those of a folder, GLTF=DIR.
if (process.env.GLTF) {
    const folder = resolve("..", "..", "..", process.env.GLTF);
    const names = readdirSync(folder, { recursive: true }).filter(name => /[.]glb$/.test(name));
    test("there are files", () => assert.ok(names.length > 0));
    for (const name of names)
        test(`there and back: ${name}`, async () => {
            await check(await io.read(join(folder, name)));
            await goThereAndBack(await io.read(join(folder, name)), 14);
        });
}
