/* glTF files with CONQUEST_mesh_progressive: there and back, valid, all else untouched. SPDX-License-Identifier: MIT */
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { test } from "node:test";
import { NodeIO, getBounds } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
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

test("the command makes a file progressive, and plain again", async () => {
    const command = join("node_modules", ".bin", "conquest-gltf"), before = makeDocument();
    const triangles = d => d.getRoot().listMeshes().flatMap(m => m.listPrimitives().map(p => listTriangles(p)));
    await io.write("plain.glb", before);
    execFileSync(command, ["plain.glb", "progressive.glb", "32"]);
    execFileSync(command, ["progressive.glb", "again.glb", "--plain"]);
    assert.deepEqual(triangles(await io.read("again.glb")), triangles(before));
    const uses = async name => (await io.readAsJSON(name)).json.extensionsUsed?.includes(NAME) ?? false;
    assert.deepEqual([await uses("progressive.glb"), await uses("again.glb")], [true, false]);
    assert.throws(() => execFileSync(command, ["plain.glb"], { stdio: "pipe" }), { status: 2 });
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
