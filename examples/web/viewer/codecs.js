/* codecs.js - the mesh by other codecs, in a browser or in node. SPDX-License-Identifier: MIT
 *
 * A mesh is { index: Uint32Array, positions: Float32Array, bits }, its positions on a grid of so many bits. It may have
 * normals, texcoords and weights, Float32Array, and joints, Uint8Array, too. Decoders give back all of them: Draco's as
 * they were, meshoptimizer's, but for the positions, in the bytes that a GPU takes. */
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

/** Attributes beside positions: numbers for each, and bits of floats, as conquest.js has them. */
const OTHERS = {
    normals: [3, 10, "NORMAL"],
    texcoords: [2, 12, "TEX_COORD"],
    weights: [4, 12, "GENERIC"],
    joints: [4, 0, "GENERIC"],
};
const KINDS = [["positions", "POSITION"], ["normals", "NORMAL"], ["texcoords", "TEX_COORD"]];

/** Draco's compression level 0 .. 10 is 10 - speed. */
function dracoEncode(module, { index, positions, bits, ...others }, level) {
    const encoder = new module.Encoder(),
        builder = new module.MeshBuilder(),
        mesh = new module.Mesh(),
        out = new module.DracoInt8Array();
    builder.AddFacesToMesh(mesh, index.length / 3, index);
    builder.AddFloatAttributeToMesh(mesh, module.POSITION, positions.length / 3, 3, positions);
    for (const [name, [width, quantised, kind]] of Object.entries(OTHERS).filter(([name]) => others[name])) {
        const add = quantised ? "AddFloatAttribute" : "AddUInt8Attribute";
        builder[add](mesh, module[kind], positions.length / 3, width, others[name]);
        if (quantised) encoder.SetAttributeQuantization(module[kind], quantised);
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
        const bytes = count * Type.BYTES_PER_ELEMENT,
            at = module._malloc(bytes);
        get(bytes, at);
        const array = new Type(module.HEAPU8.buffer, at, count).slice();
        module._free(at);
        return array;
    };
    const result = {
        index: read(Uint32Array, 3 * mesh.num_faces(), (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at)),
    };
    for (let k = 0; k < mesh.num_attributes(); k++) {
        const attribute = decoder.GetAttribute(mesh, k),
            type = attribute.data_type(),
            isFloat = type === module.DT_FLOAT32,
            kind = KINDS.find(([, key]) => module[key] === attribute.attribute_type());
        result[kind?.[0] ?? (isFloat ? "weights" : "joints")] = read(
            isFloat ? Float32Array : Uint8Array,
            mesh.num_points() * attribute.num_components(),
            (size, at) => decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, type, size, at),
        );
    }
    [mesh, buffer, decoder].forEach(object => module.destroy(object));
    return result;
}

/** Bytes of each vertex in meshoptimizer's buffers. */
const STRIDES = { positions: 8, normals: 4, texcoords: 4, weights: 4, joints: 4 };

/**
 * Vertices in an order for the cache, positions in 16 bits: what gltfpack writes, without a container; not yet
 * compressed. What is beside the bytes a container would tell.
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
    const names = Object.keys(OTHERS).filter(name => others[name]);
    const parts = [
        MeshoptEncoder.encodeIndexBuffer(new Uint8Array(order.buffer), order.length, 4),
        MeshoptEncoder.encodeVertexBuffer(new Uint8Array(values.buffer), count, STRIDES.positions),
        ...names.map(name => meshoptAttribute(name, others[name], OTHERS[name][0], remap, count)),
    ];
    const head = Uint32Array.of(count, order.length, ...parts.map(part => part.length));
    return { bytes: new Uint8Array(await new Blob([head, ...parts]).arrayBuffer()), names, step, low };
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

export async function meshoptDecode({ bytes, names, step, low }) {
    await MeshoptDecoder.ready;
    const words = names.length + 4,
        head = new DataView(bytes.buffer, bytes.byteOffset),
        [count, corners, ...sizes] = Array.from({ length: words }, (_, k) => head.getUint32(4 * k, true));
    let at = 4 * words;
    const next = () => bytes.subarray(at, (at += sizes.shift()));
    const result = { index: new Uint32Array(corners) };
    MeshoptDecoder.decodeIndexBuffer(new Uint8Array(result.index.buffer), corners, 4, next());
    for (const name of ["positions", ...names]) {
        result[name] = new Uint8Array(STRIDES[name] * count);
        const filter = name === "normals" ? "OCTAHEDRAL" : undefined;
        MeshoptDecoder.decodeVertexBuffer(result[name], count, STRIDES[name], next(), filter);
    }
    const values = new Uint16Array(result.positions.buffer);
    result.positions = new Float32Array(3 * count);
    for (let v = 0; v < count; v++)
        for (let k = 0; k < 3; k++) result.positions[3 * v + k] = low[k] + step * values[4 * v + k];
    return result;
}

const through = async (bytes, stream) =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
export const gzip = bytes => through(bytes, new CompressionStream("gzip"));
export const gunzip = bytes => through(bytes, new DecompressionStream("gzip"));
