/* codecs.js - the mesh by other codecs, in a browser or in node. SPDX-License-Identifier: MIT
 *
 * A mesh is { index: Uint32Array, positions: Float32Array, bits }, its positions on a grid of so many bits. */
import { MeshoptDecoder } from "meshoptimizer/decoder";
import { MeshoptEncoder } from "meshoptimizer/encoder";

/** Draco's modules: `modules` are its two functions. */
export async function openDraco({ createEncoderModule, createDecoderModule }, options = {}) {
    const encoder = await createEncoderModule({ ...options }), decoder = await createDecoderModule({ ...options });
    return {
        encode: (mesh, level = 7) => dracoEncode(encoder, mesh, level),
        decode: bytes => dracoDecode(decoder, bytes),
    };
}

/** Draco's compression level 0 .. 10 is 10 - speed. */
function dracoEncode(module, { index, positions, bits }, level) {
    const encoder = new module.Encoder(), builder = new module.MeshBuilder(), mesh = new module.Mesh(), out = new module.DracoInt8Array();
    builder.AddFacesToMesh(mesh, index.length / 3, index);
    builder.AddFloatAttributeToMesh(mesh, module.POSITION, positions.length / 3, 3, positions);
    encoder.SetSpeedOptions(10 - level, 10 - level);
    encoder.SetAttributeQuantization(module.POSITION, bits);
    encoder.SetEncodingMethod(module.MESH_EDGEBREAKER_ENCODING);
    const size = encoder.EncodeMeshToDracoBuffer(mesh, out);
    const bytes = Uint8Array.from({ length: size }, (_, k) => out.GetValue(k));
    [out, mesh, builder, encoder].forEach(object => module.destroy(object));
    if (!size)
        throw new Error("Draco cannot encode this mesh");
    return bytes;
}

function dracoDecode(module, bytes) {
    const decoder = new module.Decoder(), buffer = new module.DecoderBuffer(), mesh = new module.Mesh();
    buffer.Init(bytes, bytes.length);
    const status = decoder.DecodeBufferToMesh(buffer, mesh);
    if (!status.ok())
        throw new Error(`Draco: ${status.error_msg()}`);
    const read = (Type, count, get) => {
        const at = module._malloc(4 * count);
        get(4 * count, at);
        const array = new Type(module.HEAPU8.buffer, at, count).slice();
        module._free(at);
        return array;
    };
    const attribute = decoder.GetAttribute(mesh, decoder.GetAttributeId(mesh, module.POSITION));
    const index = read(Uint32Array, 3 * mesh.num_faces(), (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at));
    const positions = read(Float32Array, 3 * mesh.num_points(), (size, at) =>
        decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, module.DT_FLOAT32, size, at));
    [mesh, buffer, decoder].forEach(object => module.destroy(object));
    return { index, positions };
}

const HEADER = 6;

/** Vertices in an order for the cache, positions in 16 bits: what gltfpack writes, without a container; not yet compressed. */
export async function meshoptEncode({ index, positions, bits }) {
    await MeshoptEncoder.ready;
    const order = index.slice(), [remap, count] = MeshoptEncoder.reorderMesh(order, true, true);
    const low = [0, 1, 2].map(k => positions.reduce((a, x, i) => i % 3 === k ? Math.min(a, x) : a, Infinity));
    const extent = positions.reduce((a, x, i) => Math.max(a, x - low[i % 3]), 0), step = extent / (2 ** Math.min(bits, 16) - 1) || 1;
    const values = new Uint16Array(4 * count);
    remap.forEach((to, v) => { for (let k = 0; to < count && k < 3; k++) values[4 * to + k] = Math.round((positions[3 * v + k] - low[k]) / step); });
    const vertices = MeshoptEncoder.encodeVertexBuffer(new Uint8Array(values.buffer), count, 8);
    const triangles = MeshoptEncoder.encodeIndexBuffer(new Uint8Array(order.buffer), order.length, 4);
    const bytes = new Uint8Array(4 * HEADER + vertices.length + triangles.length), head = new DataView(bytes.buffer);
    [count, index.length, vertices.length].forEach((n, k) => head.setUint32(4 * k, n, true));
    low.forEach((x, k) => head.setFloat32(12 + 4 * k, x, true));
    bytes.set(vertices, 4 * HEADER);
    bytes.set(triangles, 4 * HEADER + vertices.length);
    return { bytes, step };
}

export async function meshoptDecode({ bytes, step }) {
    await MeshoptDecoder.ready;
    const head = new DataView(bytes.buffer, bytes.byteOffset), [count, corners, size] = [0, 1, 2].map(k => head.getUint32(4 * k, true));
    const low = [0, 1, 2].map(k => head.getFloat32(12 + 4 * k, true));
    const values = new Uint16Array(4 * count), index = new Uint32Array(corners), positions = new Float32Array(3 * count);
    MeshoptDecoder.decodeVertexBuffer(new Uint8Array(values.buffer), count, 8, bytes.subarray(4 * HEADER, 4 * HEADER + size));
    MeshoptDecoder.decodeIndexBuffer(new Uint8Array(index.buffer), corners, 4, bytes.subarray(4 * HEADER + size));
    for (let v = 0; v < count; v++)
        for (let k = 0; k < 3; k++)
            positions[3 * v + k] = low[k] + step * values[4 * v + k];
    return { index, positions };
}

const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
export const gzip = bytes => through(bytes, new CompressionStream("gzip"));
export const gunzip = bytes => through(bytes, new DecompressionStream("gzip"));
