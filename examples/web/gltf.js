/* gltf.js - what all readers of CONQUEST_mesh_progressive ask of a file. SPDX-License-Identifier: MIT */
export const NAME = "CONQUEST_mesh_progressive";

/**
 * Throws if a stream does not have what a primitive wants of it.
 * @param {import("./conquest.js").State} state
 * @param {{ attributes: Record<string, number>, group?: number }} primitive  its extension
 */
export function checkPrimitive({ attributes, numMaterials }, { attributes: wanted, group = 0 }) {
    const channels = Object.keys(attributes),
        groups = Math.max(numMaterials, 1);
    for (const [key, channel] of Object.entries(wanted))
        if (!channels[channel])
            throw new Error(`${NAME}: ${key} is channel ${channel}, of a stream that has ${channels.length}`);
    if (!(group < groups)) throw new Error(`${NAME}: a primitive is group ${group}, of a stream that has ${groups}`);
}

/** What an attribute fills. @template T @param {T | null | undefined} target @param {string} key @returns {T} */
export function need(target, key) {
    if (target === undefined || target === null) throw new Error(`${NAME}: ${key} is no attribute of the primitive`);
    return target;
}
