/* files.js - meshes of files that are dropped on the page, for the encoder. SPDX-License-Identifier: MIT */
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { PLYLoader } from "three/addons/loaders/PLYLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { parseOff } from "./off.js";

const NAMES = { position: "positions", normal: "normals", uv: "texcoords", color: "colors" };

/** What the encoder takes of a geometry of three.js; corners with equal values become one. */
function takeGeometry(geometry) {
    const count = geometry.getAttribute("position").count;
    const mesh = {
        index: geometry.index
            ? Uint32Array.from(geometry.index.array)
            : Uint32Array.from({ length: count }, (_, k) => k),
    };
    for (const [name, key] of Object.entries(NAMES).filter(([name]) => geometry.hasAttribute(name)))
        mesh[key] = Float32Array.from(geometry.getAttribute(name).array);
    return mesh;
}

function readObj(text) {
    const geometries = [];
    new OBJLoader().parse(text).traverse(object => {
        if (object.isMesh) geometries.push(object.geometry);
    });
    const common = Object.keys(NAMES).filter(name => geometries.every(g => g.hasAttribute(name)));
    for (const g of geometries)
        Object.keys(g.attributes)
            .filter(name => !common.includes(name))
            .forEach(name => g.deleteAttribute(name));
    if (!geometries.length) throw new Error("the file has no faces");
    return takeGeometry(mergeGeometries(geometries));
}

function readStl(buffer) {
    const geometry = new STLLoader().parse(buffer);
    geometry.deleteAttribute("normal"); // of the triangles, which have them anyway
    return takeGeometry(geometry);
}

/** The mesh of a file, by the end of its name; throws an Error with words for the user. */
export function readMesh(name, bytes) {
    const text = () => new TextDecoder().decode(bytes),
        end = /[.](\w+)$/.exec(name.toLowerCase())?.[1];
    if (end === "obj") return readObj(text());
    if (end === "off") return parseOff(text());
    if (end === "ply") return takeGeometry(new PLYLoader().parse(bytes.buffer));
    if (end === "stl") return readStl(bytes.buffer);
    throw new Error(`${name}: the page reads .cqm, .obj, .off, .ply and .stl`);
}
