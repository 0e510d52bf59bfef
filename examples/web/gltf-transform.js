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
    MAX_CHANNELS = 16,
    MAX_MATERIALS = 1024,
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

/** Primitives that may share a stream have the same attributes, of the same types. @param {Primitive} primitive */
const describeForm = primitive =>
    listAccessors(primitive)
        .map(([key, a]) => [key, a.getType(), a.getComponentType(), a.getNormalized()].join(" "))
        .join();

/** Of primitives of a mesh, groups that may share a stream. @param {Primitive[]} primitives */
function group(primitives) {
    const groups = /** @type {Map<string, Primitive[]>} */ (new Map());
    for (const primitive of primitives) {
        const form = describeForm(primitive),
            open = groups.get(form) ?? [];
        groups.set(open.length < MAX_MATERIALS ? form : `${form} ${groups.size}`, [...open, primitive]);
    }
    return [...groups.values()];
}

/** Gives primitives common accessors, which have the vertices of all, one after the other; their indices differ.
 *  @param {Primitive[]} primitives */
function join(primitives) {
    const lists = primitives.map(listAccessors),
        first = lists[0];
    const joined = first.map(([, accessor], k) => {
        const arrays = lists.map(list => /** @type {any} */ (list[k][1].getArray())),
            all = new arrays[0].constructor(arrays.reduce((n, a) => n + a.length, 0));
        arrays.reduce((at, a) => (all.set(a, at), at + a.length), 0);
        return accessor.clone().setArray(all);
    });
    let before = 0;
    for (const primitive of primitives) {
        const count = /** @type {Accessor} */ (primitive.getAttribute("POSITION")).getCount(),
            index = /** @type {Accessor} */ (primitive.getIndices());
        index.setArray(Uint32Array.from(/** @type {any} */ (index.getArray()), v => v + before));
        before += count;
        let k = 0;
        for (const key of primitive.listSemantics()) primitive.setAttribute(key, joined[k++]);
        for (const target of primitive.listTargets())
            for (const key of target.listSemantics()) target.setAttribute(key, joined[k++]);
    }
    for (const [, accessor] of lists.flat())
        if (accessor.listParents().every(parent => parent.propertyType === PropertyType.ROOT)) accessor.dispose();
}

/** Of primitives of a mesh, groups that have all accessors in common. @param {Primitive[]} primitives */
function groupShared(primitives) {
    const groups = /** @type {Map<Accessor | null, Primitive[]>} */ (new Map());
    for (const primitive of primitives) {
        const position = primitive.getAttribute("POSITION");
        groups.set(position, [...(groups.get(position) ?? []), primitive]);
    }
    return [...groups.values()];
}

/**
 * A transform for document.transform(): triangles become progressive when the document is written. Primitives of a mesh
 * that have the same attributes become one stream, and a material of it each. Those that a stream cannot hold stay as they
 * are.
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
        for (const mesh of document.getRoot().listMeshes())
            group(mesh.listPrimitives().filter(isFit))
                .filter(all => all.length > 1)
                .forEach(join);
    };
}

/** Indices of a material of a complete mesh, or of all. @param {State} state @param {number} [material] */
function indexOf(state, material) {
    if (material === undefined) return state.index;
    const { start, count } = state.materials[material],
        aside = state.index.length - 3 * state.asideMaterials.length;
    const faces = Array.from(state.asideMaterials.keys()).filter(f => state.asideMaterials[f] === material);
    return [
        ...state.index.subarray(start, start + count),
        ...faces.flatMap(f => Array.from(state.index.subarray(aside + 3 * f, aside + 3 * f + 3))),
    ];
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
        const { json, resources } = context.jsonDoc,
            states = /** @type {Map<number, State>} */ (new Map());
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
            const state = states.get(found.bufferView) ?? /** @type {Codec} */ (this.#codec).decode(bytes),
                channels = Object.values(state.attributes);
            states.set(found.bufferView, state);
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
            fill(/** @type {number} */ (primitive.indices), indexOf(state, found.material));
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
        for (const primitives of this.document
            .getRoot()
            .listMeshes()
            .flatMap(mesh => groupShared(mesh.listPrimitives().filter(isFit)))) {
            const channels = listChannels(primitives[0], this.bits),
                indices = primitives.map(p => /** @type {any} */ (/** @type {Accessor} */ (p.getIndices()).getArray()));
            const { data, order, count } = this.#encode(channels, indices);
            primitives.forEach((primitive, k) => {
                const definition = define(/** @type {Accessor} */ (primitive.getIndices()), indices[k].length);
                definition.componentType = count > 65535 ? 5125 : 5123;
            });
            channels.forEach(({ accessor }) => define(accessor, count));
            const buffer = /** @type {any} */ (
                channels[0].accessor.getBuffer() ?? this.document.getRoot().listBuffers()[0]
            );
            context.otherBufferViews.set(buffer, [...(context.otherBufferViews.get(buffer) ?? []), data]);
            primitives.forEach((primitive, material) =>
                streams.set(primitive, {
                    data,
                    attributes: Object.fromEntries(channels.map(c => [c.key, order.indexOf(c.name)])),
                    ...(primitives.length > 1 && { material }),
                }),
            );
        }
        return this;
    }

    /** @param {Channel[]} channels @param {ArrayLike<number>[]} indices  of each material */
    #encode(channels, indices) {
        const codec = /** @type {Codec} */ (this.#codec),
            bits = /** @type {Record<string, number>} */ ({});
        const index = new Uint32Array(indices.reduce((n, part) => n + part.length, 0)),
            materials = new Uint32Array(index.length / 3);
        indices.reduce((at, part, m) => {
            index.set(part, at);
            materials.fill(m, at / 3, (at + part.length) / 3);
            return at + part.length;
        }, 0);
        const mesh = /** @type {any} */ ({ index });
        for (const c of channels) {
            const array = /** @type {any} */ (c.accessor.getArray());
            mesh[c.name] =
                c.name.startsWith("joints") || array instanceof Float32Array ? array : Float32Array.from(array);
            if (c.bits) bits[c.name] = c.bits;
        }
        const { data } = codec.encode(mesh, indices.length > 1 ? { bits, materials } : { bits }),
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
                        ...(stream.material !== undefined && { material: stream.material }),
                    };
            });
        }
        return this;
    }
}
