/* gltf-transform.js - CONQUEST_mesh_progressive for @gltf-transform/core. SPDX-License-Identifier: MIT
 *
 *     const io = new NodeIO().registerExtensions([ConquestMeshProgressive]).registerDependencies({ conquest: await
 * openCodec() });
 *     const document = await io.read("a.glb");
 *     await document.transform(progressive({ bits: 14 }));
 *     await io.write("b.glb", document);                              // and io.read("b.glb") */
import { BufferUtils, Extension, GLB_BUFFER, PropertyType } from "@gltf-transform/core";
import { NAME, checkPrimitive, need } from "./gltf.js";

export { NAME };
const TRIANGLES = 4,
    MAX_CHANNELS = 16,
    MAX_GROUPS = 1024,
    EXACT = 32;

/** What an attribute of glTF is in a stream. */
const KINDS = /** @type {Record<string, string>} */ ({
    POSITION: "positions",
    NORMAL: "normals",
    TANGENT: "tangents",
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

/** Accessors of a primitive: attributes, then those of morph targets with the number of the target, "POSITION:0";
 *  in one order.
 *  @param {Primitive} primitive @returns {[string, Accessor][]} */
function listAccessors(primitive) {
    const all = primitive.listSemantics().map(key => [key, primitive.getAttribute(key)]);
    primitive
        .listTargets()
        .forEach((target, t) =>
            target.listSemantics().forEach(key => all.push([`${key}:${t}`, target.getAttribute(key)])),
        );
    return /** @type {[string, Accessor][]} */ (all).sort(([a], [b]) => (a < b ? -1 : 1));
}

/** Is there a normal or tangent without length, or one that is no number? @param {string} key
 *  @param {Accessor} accessor */
function hasNoDirection(key, accessor) {
    const array = /** @type {any} */ (accessor.getArray()),
        size = accessor.getElementSize();
    if (key !== "NORMAL" && key !== "TANGENT") return false;
    for (let i = 0; i < array.length; i += size)
        if (!(Math.hypot(array[i], array[i + 1], array[i + 2]) > 0)) return true;
    return false;
}

/** @param {Primitive} primitive @param {number} bits @returns {Channel[]} */
function listChannels(primitive, bits) {
    const counts = /** @type {Record<string, number>} */ ({}),
        few = { positions: bits, generic: bits };
    return listAccessors(primitive).map(([key, accessor]) => {
        const kind = key.includes(":") ? "generic" : (KINDS[key.replace(/_\d+$/, "")] ?? "generic");
        const number = (counts[kind] = (counts[kind] ?? -1) + 1);
        const isExact = bits === EXACT || !(accessor.getArray() instanceof Float32Array) || hasNoDirection(key, accessor);
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
        accessors.length < MAX_CHANNELS && // one is for faces that are turned over
        (primitive.getIndices() ?? accessors[0][1]).getCount() >= 3 &&
        accessors.every(
            ([key, a]) =>
                a.getElementSize() <= 4 &&
                (!KINDS[key] || a.getElementSize() === { NORMAL: 3, TANGENT: 4, POSITION: 3 }[key]),
        )
    );
}

/** Primitives that share a stream: those of a mesh that have attributes of the same kinds.
 *  @param {import("@gltf-transform/core").Mesh} mesh @returns {Primitive[][]} */
function listStreams(mesh) {
    const streams = /** @type {Map<string, Primitive[]>} */ (new Map());
    for (const primitive of mesh.listPrimitives().filter(isFit)) {
        const kinds = listAccessors(primitive).map(([key, a]) => [key, a.getType(), a.getComponentType(), a.getNormalized()]),
            name = JSON.stringify(kinds);
        streams.set(name, [...(streams.get(name) ?? []), primitive]);
    }
    return [...streams.values()].flatMap(all =>
        Array.from({ length: Math.ceil(all.length / MAX_GROUPS) }, (_, k) =>
            all.slice(k * MAX_GROUPS, (k + 1) * MAX_GROUPS),
        ),
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
        for (const primitives of document.getRoot().listMeshes().flatMap(listStreams)) {
            const clones = new Map(), // a stream fills accessors of its own
                indices = new Set();
            const own = (/** @type {Accessor} */ accessor) => {
                if (!clones.has(accessor)) clones.set(accessor, used.has(accessor) ? accessor.clone() : accessor);
                return clones.get(accessor);
            };
            for (const primitive of primitives) {
                const index = primitive.getIndices() ?? countUp(document, primitive);
                primitive.setIndices(used.has(index) || indices.has(index) ? index.clone() : index);
                indices.add(primitive.getIndices());
                for (const holder of [primitive, ...primitive.listTargets()])
                    for (const key of holder.listSemantics())
                        holder.setAttribute(key, own(/** @type {Accessor} */ (holder.getAttribute(key))));
            }
            [...clones.values(), ...indices].forEach(accessor => used.add(accessor));
        }
    };
}

/** An index for a primitive that has none. @param {import("@gltf-transform/core").Document} document
 *  @param {Primitive} primitive */
function countUp(document, primitive) {
    const count = /** @type {Accessor} */ (primitive.getAttribute("POSITION")).getCount();
    return document
        .createAccessor()
        .setType("SCALAR")
        .setBuffer(document.getRoot().listBuffers()[0])
        .setArray(Uint32Array.from({ length: count }, (_, k) => k));
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

/** The triangles of a group. @param {State} state @param {number} group */
function takeGroup({ index, groups }, group) {
    return Uint32Array.from(
        groups.filter(g => g.material === group).flatMap(g => Array.from(index.subarray(g.start, g.start + g.count))),
    );
}

/** @typedef {Omit<Channel, "accessor"> & { accessors: Accessor[], array: any }} Joined  Of all primitives. */

/** Primitives as one mesh, each a material of it. Vertices that they share are there once.
 *  @param {Primitive[]} primitives @param {number} bits */
function joinPrimitives(primitives, bits) {
    const lists = primitives.map(p => listChannels(p, bits)),
        tables = /** @type {Channel[][]} */ ([]), // lists with different accessors
        index = /** @type {number[]} */ ([]),
        materials = /** @type {number[]} */ ([]);
    const isSame = (/** @type {Channel[]} */ a, /** @type {Channel[]} */ b) => a.every((c, k) => c.accessor === b[k].accessor);
    const count = (/** @type {Channel[]} */ list) => list[0].accessor.getCount();
    primitives.forEach((primitive, k) => {
        let table = tables.findIndex(t => isSame(t, lists[k]));
        if (table < 0) table = tables.push(lists[k]) - 1;
        const first = tables.slice(0, table).reduce((sum, t) => sum + count(t), 0);
        for (const v of /** @type {any} */ (primitive.getIndices()).getArray()) index.push(first + v);
        while (materials.length < index.length / 3) materials.push(k);
    });
    const channels = tables[0].map(({ accessor, ...rest }, k) => {
        const arrays = tables.map(t => /** @type {any} */ (t[k].accessor.getArray())),
            array = new arrays[0].constructor(arrays.reduce((sum, a) => sum + a.length, 0));
        arrays.reduce((at, a) => (array.set(a, at), at + a.length), 0);
        return { ...rest, array, accessors: tables.map(t => t[k].accessor) };
    });
    return { channels, index, materials };
}

/** What all of some accessors lie between. @param {Accessor[]} accessors */
function findBounds(accessors) {
    const low = accessors.map(a => a.getMin([])),
        high = accessors.map(a => a.getMax([]));
    return {
        min: low[0].map((_, k) => Math.min(...low.map(x => x[k]))),
        max: high[0].map((_, k) => Math.max(...high.map(x => x[k]))),
    };
}

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
        const { json, resources } = context.jsonDoc,
            states = /** @type {Map<number, State>} */ (new Map()),
            accessors = /** @type {any[]} */ (json.accessors),
            filled = new Set();
        const decode = (/** @type {number} */ k) => {
            const view = /** @type {any} */ (json.bufferViews)[k],
                uri = /** @type {any} */ (json.buffers)[view.buffer].uri ?? GLB_BUFFER;
            return /** @type {Codec} */ (this.#codec).decode(
                BufferUtils.toView(resources[uri], view.byteOffset ?? 0, view.byteLength),
            );
        };
        const fill = (/** @type {number} */ k, /** @type {ArrayLike<number>} */ array) => {
            if (!filled.has(k))
                context.accessors[k].setArray(convert(array, ARRAYS[accessors[k].componentType]).slice());
            filled.add(k);
        };
        for (const primitive of (json.meshes ?? []).flatMap(mesh => mesh.primitives)) {
            const found = /** @type {any} */ (primitive.extensions?.[NAME]);
            if (!found) continue;
            if (!states.has(found.bufferView)) states.set(found.bufferView, decode(found.bufferView));
            const state = /** @type {State} */ (states.get(found.bufferView)),
                channels = Object.values(state.attributes);
            checkPrimitive(state, found);
            for (const [key, channel] of Object.entries(found.attributes)) {
                const [name, target] = key.split(":");
                const of =
                    target === undefined ? primitive.attributes : /** @type {any} */ (primitive.targets)?.[target];
                fill(need(of?.[name], key), channels[/** @type {number} */ (channel)].array);
            }
            fill(/** @type {number} */ (primitive.indices), takeGroup(state, found.group ?? 0));
        }
        return this;
    }

    read() {
        return this;
    }

    /** @param {import("@gltf-transform/core").WriterContext} context */
    prewrite(context) {
        context.extensionData[NAME] = new Map();
        for (const primitives of this.document.getRoot().listMeshes().flatMap(listStreams))
            this.#writeStream(context, primitives);
        return this;
    }

    /** @param {import("@gltf-transform/core").WriterContext} context @param {Primitive[]} primitives */
    #writeStream(context, primitives) {
        const definitions = /** @type {any[]} */ (context.jsonDoc.json.accessors),
            streams = /** @type {Map<Primitive, any>} */ (context.extensionData[NAME]);
        const { channels, index, materials } = joinPrimitives(primitives, this.bits),
            { data, order, count } = this.#encode(channels, index, primitives.length > 1 ? materials : undefined);
        /** One accessor of the file for all of these. @param {Accessor[]} accessors @param {any} more */
        const define = ([first, ...others], more) => {
            const definition = { ...context.createAccessorDef(first), ...more },
                at = definitions.push(definition) - 1;
            if (others.length && definition.min) Object.assign(definition, findBounds([first, ...others]));
            for (const accessor of [first, ...others]) context.accessorIndexMap.set(accessor, at);
        };
        for (const primitive of primitives) {
            const indices = /** @type {Accessor} */ (primitive.getIndices());
            define([indices], { count: indices.getCount(), componentType: count > 65535 ? 5125 : 5123 });
        }
        for (const { accessors } of channels) define(accessors, { count });
        const buffer = /** @type {any} */ (
            channels[0].accessors[0].getBuffer() ?? this.document.getRoot().listBuffers()[0]
        );
        context.otherBufferViews.set(buffer, [...(context.otherBufferViews.get(buffer) ?? []), data]);
        const attributes = Object.fromEntries(channels.map(c => [c.key, order.indexOf(c.name)]));
        primitives.forEach((primitive, group) =>
            streams.set(primitive, { data, attributes, ...(group && { group }) }),
        );
    }

    /** @param {Joined[]} channels @param {number[]} index @param {number[]} [materials] */
    #encode(channels, index, materials) {
        const codec = /** @type {Codec} */ (this.#codec),
            bits = /** @type {Record<string, number>} */ ({});
        const mesh = /** @type {any} */ ({ index, materials });
        for (const c of channels) {
            mesh[c.name] =
                c.name.startsWith("joints") || c.array instanceof Float32Array ? c.array : Float32Array.from(c.array);
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
                if (!stream) return;
                const { data, ...rest } = stream;
                (definition.primitives[k].extensions ??= {})[NAME] = {
                    bufferView: context.otherBufferViewsIndexMap.get(data),
                    ...rest,
                };
            });
        }
        return this;
    }
}
