/* A glTF document that the tests make. SPDX-License-Identifier: MIT */
import { Document } from "@gltf-transform/core";
import { makeDressed, makeSphere } from "./meshes.js";

const PIXEL = Uint8Array.from(
    Buffer.from(
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP43+AAAARBAcAM0e2RAAAAAElFTkSuQmCC",
        "base64",
    ),
);

/** A skinned, textured sphere with a morph target; a soup of two materials, without an index; lines; two nodes. `fine`
 *  times as many columns and rows. */
export function makeDocument(fine = 1) {
    const document = new Document(),
        buffer = document.createBuffer(),
        scene = document.createScene(),
        sphere = makeDressed(24 * fine, 12 * fine);
    const accessor = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
    const texture = document.createTexture("dots").setMimeType("image/png").setImage(PIXEL);
    const gold = document.createMaterial("gold").setBaseColorTexture(texture),
        blue = document.createMaterial("blue").setBaseColorFactor([0, 0, 1, 1]);
    const red = document.createMaterial("red").setBaseColorFactor([1, 0, 0, 1]);
    const positions = accessor("VEC3", sphere.positions);
    const skinned = document
        .createPrimitive()
        .setMaterial(gold)
        .setIndices(accessor("SCALAR", Uint16Array.from(sphere.index)))
        .setAttribute("POSITION", positions)
        .setAttribute("NORMAL", accessor("VEC3", sphere.normals))
        .setAttribute("TEXCOORD_0", accessor("VEC2", sphere.texcoords))
        .setAttribute(
            "JOINTS_0",
            accessor(
                "VEC4",
                sphere.joints.map(j => j % 2),
            ),
        )
        .setAttribute("WEIGHTS_0", accessor("VEC4", sphere.weights))
        .addTarget(
            document.createPrimitiveTarget("bend").setAttribute(
                "POSITION",
                accessor(
                    "VEC3",
                    sphere.positions.map(x => x * x),
                ),
            ),
        );
    const soup = makeSphere(12 * fine, 6 * fine),
        corners = Float32Array.from(
            Array.from(soup.index).flatMap(v => Array.from(soup.positions.subarray(3 * v, 3 * v + 3))),
        );
    const half = 9 * Math.floor(corners.length / 18),
        part = (array, material) =>
            document.createPrimitive().setMaterial(material).setAttribute("POSITION", accessor("VEC3", array));
    const lines = document
        .createPrimitive()
        .setMode(1)
        .setAttribute("POSITION", accessor("VEC3", corners.slice(0, 12)));
    const body = document.createMesh("body").addPrimitive(skinned).setWeights([0.5]);
    const parts = document
        .createMesh("parts")
        .addPrimitive(part(corners.slice(0, half), red))
        .addPrimitive(part(corners.slice(half), blue))
        .addPrimitive(lines);
    const joints = [0, 1].map(k => document.createNode(`joint${k}`).setTranslation([k, 0, 0]));
    const skin = document.createSkin("bones").setInverseBindMatrices(
        accessor(
            "MAT4",
            new Float32Array(32).map((_, k) => (k % 5 === 0 && k !== 20 ? 1 : (k % 16) % 5 === 0 ? 1 : 0)),
        ),
    );
    joints.forEach(joint => skin.addJoint(joint));
    scene.addChild(joints[0].addChild(joints[1]));
    scene.addChild(document.createNode("body").setMesh(body).setSkin(skin));
    for (const x of [-3, 3])
        scene.addChild(
            document
                .createNode(`parts${x}`)
                .setMesh(parts)
                .setTranslation([x, 0, 0])
                .setScale([Math.sign(x), 1, 1]),
        );
    return document;
}

/** A mesh of three primitives, two with the same vertices and one with its own at the same places; another mesh that shares with both. */
export function makeParts() {
    const document = new Document(),
        buffer = document.createBuffer(),
        mesh = document.createMesh("ball"),
        { index, positions } = makeSphere(24, 12);
    const accessor = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
    const third = 3 * Math.floor(index.length / 9),
        corners = Float32Array.from(
            Array.from(index.subarray(2 * third)).flatMap(v => Array.from(positions.subarray(3 * v, 3 * v + 3))),
        );
    const shared = accessor("VEC3", positions),
        own = accessor("VEC3", corners);
    const indices = [index.slice(0, third), index.slice(third, 2 * third), corners.slice(0, corners.length / 3).map((_, k) => k)].map(
        numbers => accessor("SCALAR", Uint16Array.from(numbers)),
    );
    for (const [k, at] of [shared, shared, own].entries())
        mesh.addPrimitive(
            document
                .createPrimitive()
                .setMaterial(document.createMaterial(`part ${k}`))
                .setIndices(indices[k])
                .setAttribute("POSITION", at),
        );
    document.createScene().addChild(document.createNode("ball").setMesh(mesh));
    const other = document.createPrimitive().setIndices(indices[0]).setAttribute("POSITION", shared);
    document.getRoot().listScenes()[0].addChild(document.createNode("again").setMesh(document.createMesh("again").addPrimitive(other)));
    return document;
}

/** A document with one node for each shape. @param {Record<string, () => any>} shapes */
export function makeShapes(shapes) {
    const document = new Document(),
        buffer = document.createBuffer(),
        scene = document.createScene();
    const accessor = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
    for (const [name, make] of Object.entries(shapes)) {
        const { index, positions, normals, texcoords } = make(),
            primitive = document.createPrimitive().setIndices(accessor("SCALAR", Uint16Array.from(index)));
        primitive.setAttribute("POSITION", accessor("VEC3", Float32Array.from(positions)));
        if (normals) primitive.setAttribute("NORMAL", accessor("VEC3", Float32Array.from(normals)));
        if (texcoords) primitive.setAttribute("TEXCOORD_0", accessor("VEC2", Float32Array.from(texcoords)));
        scene.addChild(document.createNode(name).setMesh(document.createMesh(name).addPrimitive(primitive)));
    }
    return document;
}

/** The same .glb with some buffer views, the last ones, before all others. */
export function moveToFront(glb, views) {
    const words = new DataView(glb.buffer, glb.byteOffset),
        text = words.getUint32(12, true),
        json = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + text))),
        binary = glb.subarray(28 + text);
    const cut = Math.min(...views.map(v => json.bufferViews[v].byteOffset)),
        moved = binary.length - cut;
    json.bufferViews.forEach((view, v) => {
        view.byteOffset = (view.byteOffset ?? 0) + (views.includes(v) ? -cut : moved);
    });
    const longer = new TextEncoder().encode(JSON.stringify(json).padEnd(text + 400)),
        start = glb.slice(0, 20),
        header = new DataView(start.buffer);
    header.setUint32(8, glb.length + 400, true);
    header.setUint32(12, text + 400, true);
    return Buffer.concat([start, longer, glb.subarray(20 + text, 28 + text), binary.subarray(cut), binary.subarray(0, cut)]);
}

/** The same .glb with another text, and `more` bytes at its end. */
export function changeGlb(glb, change, more = new Uint8Array(0)) {
    const words = new DataView(glb.buffer, glb.byteOffset),
        text = words.getUint32(12, true),
        json = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + text))),
        binary = Buffer.concat([glb.subarray(28 + text), more]);
    json.buffers[0].byteLength = binary.length;
    change(json, binary.length - more.length);
    const changed = Buffer.from(JSON.stringify(json)),
        padded = Buffer.concat([changed, Buffer.alloc(-changed.length & 3, " ")]),
        head = Buffer.from(glb.subarray(0, 20)),
        chunk = Buffer.from(glb.subarray(20 + text, 28 + text));
    head.writeUInt32LE(28 + padded.length + binary.length, 8);
    head.writeUInt32LE(padded.length, 12);
    chunk.writeUInt32LE(binary.length, 0);
    return Buffer.concat([head, padded, chunk, binary]);
}

/** A plain .glb, and in it the streams of a progressive one with the same meshes: those who do not know them have it. */
export function addStreams(plain, { json, glb }, name) {
    const views = [...new Set(json.meshes.flatMap(m => m.primitives.flatMap(p => p.extensions?.[name]?.bufferView ?? [])))],
        binary = glb.subarray(28 + new DataView(glb.buffer, glb.byteOffset).getUint32(12, true)),
        streams = views.map(v => binary.subarray(json.bufferViews[v].byteOffset ?? 0).subarray(0, json.bufferViews[v].byteLength));
    const change = (to, size) => {
        const first = to.bufferViews.length;
        to.extensionsUsed = [...(to.extensionsUsed ?? []), name];
        for (const { byteLength } of streams) {
            to.bufferViews.push({ buffer: 0, byteOffset: size, byteLength });
            size += byteLength;
        }
        json.meshes.forEach(({ primitives }, m) =>
            primitives.forEach(({ extensions }, p) => {
                const found = extensions?.[name],
                    bufferView = first + views.indexOf(found?.bufferView);
                if (found) to.meshes[m].primitives[p].extensions = { [name]: { ...found, bufferView } };
            }),
        );
    };
    const all = Buffer.concat(streams);
    return changeGlb(plain, change, Buffer.concat([all, Buffer.alloc(-all.length & 3)]));
}
