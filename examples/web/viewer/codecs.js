/* codecs.js - the mesh by other codecs, in a browser or in node. SPDX-License-Identifier: MIT
 *
 * A mesh is { index: Uint32Array, positions: Float32Array, bits }, its positions on a grid of so many bits. It may have
 * normals, texcoords and weights, Float32Array, and joints, Uint8Array, too; decoders give back index and positions. */
import { MeshoptDecoder } from "meshoptimizer/decoder";
import { MeshoptEncoder } from "meshoptimizer/encoder";

/** Draco's modules: `modules` are its two functions. */
export async function openDraco({ createEncoderModule, createDecoderModule }, options = {}) {
    const encoder = await createEncoderModule({ ...options }),
        decoder = await createDecoderModule({ ...options });
    return {
        encode: (mesh, level = 7) => dracoEncode(encoder, mesh, level),
        decode: bytes => dracoDecode(decoder, bytes),
    };
}

/** Attributes beside positions: numbers for each, and bits, as conquest.js has them. */
const OTHERS = {
    normals: [3, 10, "NORMAL"],
    texcoords: [2, 12, "TEX_COORD"],
    weights: [4, 12, "GENERIC"],
    joints: [4, 8, "GENERIC"],
};

/** Draco's compression level 0 .. 10 is 10 - speed. */
function dracoEncode(module, { index, positions, bits, ...others }, level) {
    const encoder = new module.Encoder(),
        builder = new module.MeshBuilder(),
        mesh = new module.Mesh(),
        out = new module.DracoInt8Array();
    builder.AddFacesToMesh(mesh, index.length / 3, index);
    builder.AddFloatAttributeToMesh(mesh, module.POSITION, positions.length / 3, 3, positions);
    for (const [name, [width, quantised, kind]] of Object.entries(OTHERS).filter(([name]) => others[name])) {
        const add = name === "joints" ? "AddUInt8Attribute" : "AddFloatAttribute";
        builder[add](mesh, module[kind], positions.length / 3, width, others[name]);
        encoder.SetAttributeQuantization(module[kind], quantised);
    }
    encoder.SetSpeedOptions(10 - level, 10 - level);
    encoder.SetAttributeQuantization(module.POSITION, bits);
    encoder.SetEncodingMethod(module.MESH_EDGEBREAKER_ENCODING);
    const size = encoder.EncodeMeshToDracoBuffer(mesh, out);
    const bytes = Uint8Array.from({ length: size }, (_, k) => out.GetValue(k));
    [out, mesh, builder, encoder].forEach(object => module.destroy(object));
    if (!size) throw new Error("Draco cannot encode this mesh");
    return bytes;
}

function dracoDecode(module, bytes) {
    const decoder = new module.Decoder(),
        buffer = new module.DecoderBuffer(),
        mesh = new module.Mesh();
    buffer.Init(bytes, bytes.length);
    const status = decoder.DecodeBufferToMesh(buffer, mesh);
    if (!status.ok()) throw new Error(`Draco: ${status.error_msg()}`);
    const read = (Type, count, get) => {
        const at = module._malloc(4 * count);
        get(4 * count, at);
        const array = new Type(module.HEAPU8.buffer, at, count).slice();
        module._free(at);
        return array;
    };
    const attribute = decoder.GetAttribute(mesh, decoder.GetAttributeId(mesh, module.POSITION));
    const index = read(Uint32Array, 3 * mesh.num_faces(), (size, at) =>
        decoder.GetTrianglesUInt32Array(mesh, size, at),
    );
    const positions = read(Float32Array, 3 * mesh.num_points(), (size, at) =>
        decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, module.DT_FLOAT32, size, at),
    );
    [mesh, buffer, decoder].forEach(object => module.destroy(object));
    return { index, positions };
}

const HEADER = 4;

/**
 * Vertices in an order for the cache, positions in 16 bits: what gltfpack writes, without a container; not yet
 * compressed.
 */
export async function meshoptEncode({ index, positions, bits, ...others }) {
    await MeshoptEncoder.ready;
    const order = index.slice(),
        [remap, count] = MeshoptEncoder.reorderMesh(order, true, true);
    const low = [0, 1, 2].map(k => positions.reduce((a, x, i) => (i % 3 === k ? Math.min(a, x) : a), Infinity));
    const extent = positions.reduce((a, x, i) => Math.max(a, x - low[i % 3]), 0),
        step = extent / (2 ** Math.min(bits, 16) - 1) || 1;
    const values = new Uint16Array(4 * count);
    remap.forEach((to, v) => {
        for (let k = 0; to < count && k < 3; k++)
            values[4 * to + k] = Math.round((positions[3 * v + k] - low[k]) / step);
    });
    const vertices = MeshoptEncoder.encodeVertexBuffer(new Uint8Array(values.buffer), count, 8);
    const triangles = MeshoptEncoder.encodeIndexBuffer(new Uint8Array(order.buffer), order.length, 4);
    const more = Object.entries(OTHERS)
        .filter(([name]) => others[name])
        .map(([name, [width]]) => meshoptAttribute(name, others[name], width, remap, count));
    const rest = more.reduce((sum, part) => sum + part.length, 0);
    const bytes = new Uint8Array(4 * HEADER + vertices.length + triangles.length + rest),
        head = new DataView(bytes.buffer);
    [count, index.length, vertices.length, triangles.length].forEach((n, k) => head.setUint32(4 * k, n, true));
    bytes.set(vertices, 4 * HEADER);
    bytes.set(triangles, 4 * HEADER + vertices.length);
    let at = 4 * HEADER + vertices.length + triangles.length;
    for (const part of more) {
        bytes.set(part, at);
        at += part.length;
    }
    return { bytes, step, low };
}

/** Normals in 4 bytes, texture coordinates in 16 bits, weights and joints in 8. */
function meshoptAttribute(name, array, width, remap, count) {
    const moved = new Float32Array(4 * count),
        least = array.reduce((a, x) => Math.min(a, x), Infinity);
    const range = name === "texcoords" ? array.reduce((a, x) => Math.max(a, x - least), 0) || 1 : 1;
    remap.forEach((to, v) => {
        for (let k = 0; to < count && k < width; k++)
            moved[4 * to + k] = name === "texcoords" ? (array[width * v + k] - least) / range : array[width * v + k];
    });
    if (name === "normals")
        return MeshoptEncoder.encodeVertexBuffer(MeshoptEncoder.encodeFilterOct(moved, count, 4, 8), count, 4);
    if (name === "texcoords") {
        const pairs = Uint16Array.from({ length: 2 * count }, (_, k) =>
            Math.round(moved[4 * (k >> 1) + (k % 2)] * 4095),
        );
        return MeshoptEncoder.encodeVertexBuffer(new Uint8Array(pairs.buffer), count, 4);
    }
    return MeshoptEncoder.encodeVertexBuffer(
        Uint8Array.from(moved, x => (name === "joints" ? x : Math.round(x * 255))),
        count,
        4,
    );
}

export async function meshoptDecode({ bytes, step, low }) {
    await MeshoptDecoder.ready;
    const head = new DataView(bytes.buffer, bytes.byteOffset),
        [count, corners, size, more] = [0, 1, 2, 3].map(k => head.getUint32(4 * k, true));
    const values = new Uint16Array(4 * count),
        index = new Uint32Array(corners),
        positions = new Float32Array(3 * count);
    MeshoptDecoder.decodeVertexBuffer(
        new Uint8Array(values.buffer),
        count,
        8,
        bytes.subarray(4 * HEADER, 4 * HEADER + size),
    );
    MeshoptDecoder.decodeIndexBuffer(
        new Uint8Array(index.buffer),
        corners,
        4,
        bytes.subarray(4 * HEADER + size, 4 * HEADER + size + more),
    );
    for (let v = 0; v < count; v++)
        for (let k = 0; k < 3; k++) positions[3 * v + k] = low[k] + step * values[4 * v + k];
    return { index, positions };
}

const through = async (bytes, stream) =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
export const gzip = bytes => through(bytes, new CompressionStream("gzip"));
export const gunzip = bytes => through(bytes, new DecompressionStream("gzip"));
