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
    const geometries = [],
        hasNormals = /^\s*f\s+\S*\/\S*\/[-\d]/m.test(text);
    new OBJLoader().parse(text).traverse(object => {
        if (object.isMesh) geometries.push(object.geometry);
    });
    if (!hasNormals) geometries.forEach(g => g.deleteAttribute("normal")); // three.js makes one for each face
    const common = Object.keys(NAMES).filter(name => geometries.every(g => g.hasAttribute(name)));
    for (const g of geometries)
        Object.keys(g.attributes)
            .filter(name => !common.includes(name))
            .forEach(name => g.deleteAttribute(name));
    return geometries.length ? takeGeometry(mergeGeometries(geometries)) : { index: [] };
}

/** Three.js drops whether there are faces. */
function readPly({ buffer }) {
    const head = new TextDecoder().decode(buffer.slice(0, 65536)).split("end_header")[0];
    return /element face 0*[1-9]/.test(head) ? takeGeometry(new PLYLoader().parse(buffer)) : { index: [] };
}

function readStl(buffer) {
    const geometry = new STLLoader().parse(buffer);
    geometry.deleteAttribute("normal"); // of the triangles, which have them anyway
    return takeGeometry(geometry);
}

const READERS = {
    obj: bytes => readObj(new TextDecoder().decode(bytes)),
    off: bytes => parseOff(new TextDecoder().decode(bytes)),
    ply: readPly,
    stl: bytes => readStl(bytes.buffer),
};

/** The mesh of a file, by the end of its name; throws an Error with words for the user. */
export function readMesh(name, bytes) {
    const read = READERS[/[.](\w+)$/.exec(name.toLowerCase())?.[1]];
    if (!read) throw new Error(`${name}: the page reads .cqm, .obj, .off, .ply and .stl`);
    const mesh = read(bytes);
    if (!mesh.index.length) throw new Error(`${name} has no faces`);
    return mesh;
}
