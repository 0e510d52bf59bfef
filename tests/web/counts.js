/* Bytes of the pictures in README. SPDX-License-Identifier: MIT */
import { decodeAll } from "conquest-mesh";

/** 1, 5, 20 and 100 % of a stream's bytes; for the first the nearest that end a level: no part is finer than others. */
export async function countBytes(data) {
    const level = async count => (await decodeAll(data.subarray(0, count), { partial: true })).level;
    const [first, ...more] = [1, 5, 20, 100].map(percent => Math.ceil((data.length * percent) / 100));
    for (let away = 0; away < first / 10; away++)
        for (const count of [first - away, first + away])
            if ((await level(count)) > (await level(count - 1))) return [count, ...more];
    return [first, ...more];
}
