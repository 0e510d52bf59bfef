/* A glTF document that the tests make. SPDX-License-Identifier: MIT */
import { Document } from "@gltf-transform/core";
import { makeDressed, makeSphere } from "./meshes.js";

const PIXEL = Uint8Array.from(
    Buffer.from(
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP43+AAAARBAcAM0e2RAAAAAElFTkSuQmCC",
        "base64",
    ),
);

/** A skinned, textured sphere with a morph target; a soup of two materials, without an index; lines; two nodes. */
export function makeDocument() {
    const document = new Document(),
        buffer = document.createBuffer(),
        scene = document.createScene(),
        sphere = makeDressed(24, 12);
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
    const soup = makeSphere(12, 6),
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
