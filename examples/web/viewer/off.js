/* off.js - reads OFF: vertices, and polygons that become fans of triangles. SPDX-License-Identifier: MIT */

/** @param {string} text @returns {{ index: Uint32Array, positions: Float32Array }} throws an Error with words for the user */
export function parseOff(text) {
    const words = text.replace(/#.*/g, "").split(/\s+/).filter(Boolean);
    if (words[0] !== "OFF") throw new Error("the file is no OFF");
    const [vertices, faces] = words.slice(1, 3).map(Number),
        index = [];
    for (let f = 0, at = 4 + 3 * vertices; f < faces; f++) {
        const corners = words.slice(at + 1, at + 1 + Number(words[at])).map(Number);
        for (let k = 2; k < corners.length; k++) index.push(corners[0], corners[k - 1], corners[k]);
        at += 1 + corners.length;
        if (at > words.length) throw new Error("the file ends too early");
    }
    return { index: Uint32Array.from(index), positions: Float32Array.from(words.slice(4, 4 + 3 * vertices)) };
}
