/* gltf-transform.js - CONQUEST_mesh_progressive for @gltf-transform/core. SPDX-License-Identifier: MIT
 *
 *     const io = new NodeIO().registerExtensions([ConquestMeshProgressive]).registerDependencies({ conquest: await
 * openCodec() });
 *     const document = await io.read("a.glb");
 *     await document.transform(progressive({ bits: 14 }));
 *     await io.write("b.glb", document);                              // and io.read("b.glb") */
import { BufferUtils, Extension, GLB_BUFFER, PropertyType } from "@gltf-transform/core";

export const NAME = "CONQUEST_mesh_progressive";
const TRIANGLES = 4,
    MAX_CHANNELS = 8,
    EXACT = 32;

/** What an attribute of glTF is in a stream. Tangents are four numbers that belong to a corner, as colors are. */
const KINDS = /** @type {Record<string, string>} */ ({
    POSITION: "positions",
    NORMAL: "normals",
    TANGENT: "colors",
    TEXCOORD: "texcoords",
    COLOR: "colors",
    JOINTS: "joints",
    WEIGHTS: "weights",
});

/** @typedef {import("./conquest.js").State} State */
/** @typedef {import("./conquest.js").Encoded} Encoded */
/** @typedef {Awaited<ReturnType<typeof import("./conquest.js").openCodec>>} Codec */
/** @typedef {import("@gltf-transform/core").Primitive} Primitive */
/** @typedef {import("@gltf-transform/core").Accessor} Accessor */
/** @typedef {{ key: string, accessor: Accessor, name: string, bits: number | undefined }} Channel */

/** Accessors of a primitive: attributes, then those of morph targets with the number of the target, "POSITION:0".
 *  @param {Primitive} primitive @returns {[string, Accessor][]} */
function listAccessors(primitive) {
    const all = primitive.listSemantics().map(key => [key, primitive.getAttribute(key)]);
    primitive
        .listTargets()
        .forEach((target, t) =>
            target.listSemantics().forEach(key => all.push([`${key}:${t}`, target.getAttribute(key)])),
        );
    return /** @type {[string, Accessor][]} */ (all);
}

/** @param {Primitive} primitive @param {number} bits @returns {Channel[]} */
function listChannels(primitive, bits) {
    const counts = /** @type {Record<string, number>} */ ({}),
        few = { positions: bits, generic: bits };
    return listAccessors(primitive).map(([key, accessor]) => {
        const kind = key.includes(":") ? "generic" : (KINDS[key.replace(/_\d+$/, "")] ?? "generic");
        const number = (counts[kind] = (counts[kind] ?? -1) + 1);
        const isExact = bits === EXACT || key === "TANGENT" || !(accessor.getArray() instanceof Float32Array);
        return {
            key,
            accessor,
            name: number ? `${kind}_${number}` : kind,
            bits: isExact ? EXACT : /** @type {any} */ (few)[kind],
        };
    });
}

/** Can a stream hold this primitive? @param {Primitive} primitive */
function isFit(primitive) {
    const accessors = listAccessors(primitive);
    return (
        primitive.getMode() === TRIANGLES &&
        primitive.getAttribute("POSITION") !== null &&
        accessors.length <= MAX_CHANNELS &&
        accessors.every(
            ([key, a]) =>
                a.getElementSize() <= 4 &&
                (!KINDS[key] || a.getElementSize() === { NORMAL: 3, TANGENT: 4, POSITION: 3 }[key]),
        )
    );
}

/**
 * A transform for document.transform(): triangles become progressive when the document is written. Primitives that a
 * stream cannot hold stay as they are.
 * @param {{ bits?: number }} [options]  of positions; 32: all floats bit for bit
 */
export function progressive({ bits = 14 } = {}) {
    return async (/** @type {import("@gltf-transform/core").Document} */ document) => {
        const extension = /** @type {ConquestMeshProgressive} */ (
            document.createExtension(ConquestMeshProgressive).setRequired(true)
        );
        extension.bits = bits;
        const used = new Set();
        const own = (/** @type {Accessor} */ accessor) => {
            // a stream fills accessors of one primitive
            const mine = used.has(accessor) ? accessor.clone() : accessor;
            used.add(mine);
            return mine;
        };
        for (const primitive of document
            .getRoot()
            .listMeshes()
            .flatMap(mesh => mesh.listPrimitives())
            .filter(isFit)) {
            const count = /** @type {Accessor} */ (primitive.getAttribute("POSITION")).getCount(),
                index = primitive.getIndices();
            primitive.setIndices(
                index
                    ? own(index)
                    : document
                          .createAccessor()
                          .setType("SCALAR")
                          .setBuffer(document.getRoot().listBuffers()[0])
                          .setArray(Uint32Array.from({ length: count }, (_, k) => k)),
            );
            for (const holder of [primitive, ...primitive.listTargets()])
                for (const key of holder.listSemantics())
                    holder.setAttribute(key, own(/** @type {Accessor} */ (holder.getAttribute(key))));
        }
    };
}

/** Numbers of an accessor's own type. @param {ArrayLike<number>} from @param {any} Type */
const convert = (from, Type) => (from instanceof Type ? /** @type {any} */ (from) : Type.from(from, Math.round));

const ARRAYS = /** @type {Record<number, any>} */ ({
    5120: Int8Array,
    5121: Uint8Array,
    5122: Int16Array,
    5123: Uint16Array,
    5125: Uint32Array,
    5126: Float32Array,
});

/** The extension: reads and writes streams. Needs the dependency `conquest`, which openCodec() gives. */
export class ConquestMeshProgressive extends Extension {
    extensionName = NAME;
    static EXTENSION_NAME = NAME;
    prereadTypes = [PropertyType.PRIMITIVE];
    prewriteTypes = [PropertyType.ACCESSOR];
    readDependencies = ["conquest"];
    writeDependencies = ["conquest"];
    bits = 14;
    /** @type {Codec | undefined} */
    #codec;

    /** @param {string} _key @param {any} codec */
    install(_key, codec) {
        this.#codec = codec;
        return this;
    }

    /** @param {import("@gltf-transform/core").ReaderContext} context */
    preread(context) {
        const { json, resources } = context.jsonDoc;
        for (const primitive of (json.meshes ?? []).flatMap(mesh => mesh.primitives)) {
            const found = /** @type {any} */ (primitive.extensions?.[NAME]);
            if (!found) continue;
            const view = /** @type {any} */ (json.bufferViews)[found.bufferView],
                buffer = /** @type {any} */ (json.buffers)[view.buffer];
            const bytes = BufferUtils.toView(
                resources[buffer.uri ?? GLB_BUFFER],
                view.byteOffset ?? 0,
                view.byteLength,
            );
            const state = /** @type {Codec} */ (this.#codec).decode(bytes),
                channels = Object.values(state.attributes);
            const fill = (/** @type {number} */ accessor, /** @type {ArrayLike<number>} */ array) =>
                context.accessors[accessor].setArray(
                    convert(array, ARRAYS[/** @type {any} */ (json.accessors)[accessor].componentType]).slice(),
                );
            for (const [key, channel] of Object.entries(found.attributes)) {
                const [name, target] = key.split(":");
                const of =
                    target === undefined ? primitive.attributes : /** @type {any} */ (primitive.targets)[target];
                fill(of[name], channels[/** @type {number} */ (channel)].array);
            }
            fill(/** @type {number} */ (primitive.indices), state.index);
        }
        return this;
    }

    read() {
        return this;
    }

    /** @param {import("@gltf-transform/core").WriterContext} context */
    prewrite(context) {
        const streams = (context.extensionData[NAME] = new Map());
        const accessorDefs = /** @type {any[]} */ (context.jsonDoc.json.accessors);
        const define = (/** @type {Accessor} */ accessor, /** @type {number} */ count) => {
            const definition = context.createAccessorDef(accessor);
            definition.count = count;
            context.accessorIndexMap.set(accessor, accessorDefs.push(definition) - 1);
            return definition;
        };
        for (const primitive of this.document
            .getRoot()
            .listMeshes()
            .flatMap(mesh => mesh.listPrimitives())
            .filter(isFit)) {
            const channels = listChannels(primitive, this.bits),
                index = /** @type {Accessor} */ (primitive.getIndices());
            const { data, order, count } = this.#encode(channels, /** @type {any} */ (index.getArray()));
            const definition = define(index, /** @type {any} */ (index.getArray()).length);
            definition.componentType = count > 65535 ? 5125 : 5123;
            channels.forEach(({ accessor }) => define(accessor, count));
            const buffer = /** @type {any} */ (
                channels[0].accessor.getBuffer() ?? this.document.getRoot().listBuffers()[0]
            );
            context.otherBufferViews.set(buffer, [...(context.otherBufferViews.get(buffer) ?? []), data]);
            streams.set(primitive, {
                data,
                attributes: Object.fromEntries(channels.map(c => [c.key, order.indexOf(c.name)])),
            });
        }
        return this;
    }

    /** @param {Channel[]} channels @param {ArrayLike<number>} index */
    #encode(channels, index) {
        const codec = /** @type {Codec} */ (this.#codec),
            bits = /** @type {Record<string, number>} */ ({});
        const mesh = /** @type {any} */ ({ index });
        for (const c of channels) {
            const array = /** @type {any} */ (c.accessor.getArray());
            mesh[c.name] =
                c.name.startsWith("joints") || array instanceof Float32Array ? array : Float32Array.from(array);
            if (c.bits) bits[c.name] = c.bits;
        }
        const { data } = codec.encode(mesh, { bits }),
            state = codec.decode(data);
        return { data, order: Object.keys(state.attributes), count: state.totalVertices };
    }

    /** @param {import("@gltf-transform/core").WriterContext} context */
    write(context) {
        for (const mesh of this.document.getRoot().listMeshes()) {
            const definition = /** @type {any} */ (context.jsonDoc.json.meshes)[
                /** @type {number} */ (context.meshIndexMap.get(mesh))
            ];
            mesh.listPrimitives().forEach((primitive, k) => {
                const stream = /** @type {Map<Primitive, any>} */ (context.extensionData[NAME]).get(primitive);
                if (stream)
                    (definition.primitives[k].extensions ??= {})[NAME] = {
                        bufferView: context.otherBufferViewsIndexMap.get(stream.data),
                        attributes: stream.attributes,
                    };
            });
        }
        return this;
    }
}
