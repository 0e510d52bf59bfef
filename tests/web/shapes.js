/* Small meshes as modellers make them, that are no plain surface. SPDX-License-Identifier: MIT */
import { makeSphere } from "./meshes.js";

/** A grid of quads, two triangles each: `place` gives the rows of a corner. */
function makeGrid(columns, rows, place, names = ["positions"]) {
    const mesh = { index: [], ...Object.fromEntries(names.map(name => [name, []])) };
    for (let r = 0; r <= rows; r++)
        for (let c = 0; c <= columns; c++) place(c / columns, r / rows).forEach((x, k) => mesh[names[k]].push(...x));
    const at = (c, r) => r * (columns + 1) + c;
    for (let r = 0; r < rows; r++)
        for (let c = 0; c < columns; c++)
            mesh.index.push(at(c, r), at(c + 1, r), at(c + 1, r + 1), at(c, r), at(c + 1, r + 1), at(c, r + 1));
    return mesh;
}

/** Meshes with the same attributes as one; vertices are not shared. */
function join(...meshes) {
    const all = Object.fromEntries(Object.keys(meshes[0]).map(name => [name, []]));
    for (const { index, ...others } of meshes) {
        const first = all.positions.length / 3;
        all.index.push(...Array.from(index, v => first + v));
        for (const [name, values] of Object.entries(others)) all[name].push(...values);
    }
    return all;
}

/** Vertices at one place become one. */
function weld({ index, positions }) {
    const found = new Map(),
        all = [];
    const to = Array.from({ length: positions.length / 3 }, (_, v) => {
        const at = Array.from(positions.slice(3 * v, 3 * v + 3)),
            key = at.map(x => Math.fround(x) + 0).join();
        if (!found.has(key)) found.set(key, all.push(...at) / 3 - 1);
        return found.get(key);
    });
    return { index: Array.from(index, v => to[v]), positions: all };
}

const move = ({ positions, ...rest }, offset) => ({ ...rest, positions: positions.map((x, i) => x + offset[i % 3]) });
const turn = ({ index, ...rest }, isTurned) => ({
    ...rest,
    index: index.map((v, i) => (isTurned(Math.floor(i / 3)) && i % 3 ? index[i % 3 === 1 ? i + 1 : i - 1] : v)),
});

/** A side of a cube, with its own normals and texture coordinates. */
const makeSide = (axis, sign) =>
    makeGrid(
        1,
        1,
        (u, v) => {
            const at = [2 * u - 1, sign * (2 * v - 1), sign];
            return [at.map((_, k) => at[(k + axis) % 3]), [0, 1, 2].map(k => ((k + axis) % 3 === 2 ? sign : 0)), [u, v]];
        },
        ["positions", "normals", "texcoords"],
    );

const makeCube = () => join(...[0, 1, 2].flatMap(axis => [makeSide(axis, 1), makeSide(axis, -1)]));
const makeSheet = (z = (x, y) => 0.1 * Math.sin(7 * x) * Math.cos(5 * y), columns = 8) =>
    makeGrid(columns, columns, (x, y) => [[x, y, z(x, y)]]);

/** A strip that is twisted by half a turn and closed. */
const makeMoebius = () =>
    weld(
        makeGrid(36, 2, (u, v) => {
            const angle = 2 * Math.PI * u,
                out = (v - 0.5) * Math.cos(angle / 2);
            const at = [(1 + out) * Math.cos(angle), (1 + out) * Math.sin(angle), (v - 0.5) * Math.sin(angle / 2)];
            return [at.map(x => Math.round(x * 4096) / 4096)];
        }),
    );

/** A card whose back has its own normals, on the same places. */
function makeCard(angle) {
    const side = sign =>
        makeGrid(
            6,
            4,
            (u, v) => [
                [(u - 0.5) * Math.cos(angle), v, (u - 0.5) * Math.sin(angle)],
                [sign * Math.sin(angle), 0, -sign * Math.cos(angle)],
                [u, v],
            ],
            ["positions", "normals", "texcoords"],
        );
    return join(
        side(1),
        turn(side(-1), () => true),
    );
}

/** Lines instead of faces, faces that repeat, also turned, a vertex that no face uses and two at one place. */
function makeDirt() {
    const { index, positions } = makeSheet(),
        dirt = [0, 0, 1, 5, 6, 5, ...index.slice(30, 33), index[61], index[62], index[60], ...index.slice(90, 93).reverse()];
    return { index: [...index, ...dirt], positions: [...positions, 9, 9, 9, ...positions.slice(60, 63)] };
}

const makeRound = () => makeSphere(24, 12);
const wrap = ({ index, positions }) => ({
    index,
    positions,
    texcoords: Array.from({ length: (2 * positions.length) / 3 }, (_, k) => positions[3 * (k >> 1) + (k % 2)]),
});

/** All by name. */
export const SHAPES = {
    "hard edges": makeCube,
    "a seam of texture coordinates": () =>
        makeGrid(
            32,
            16,
            (u, v) => {
                const [a, b] = [2 * Math.PI * u, Math.PI * v];
                const at = [Math.sin(b) * Math.cos(a % (2 * Math.PI)), Math.sin(b) * Math.sin(a % (2 * Math.PI)), Math.cos(b)];
                return [at, [u, v]];
            },
            ["positions", "texcoords"],
        ),
    "sheets that meet at a vertex": () => weld(join(makeSheet(), move(makeSheet(), [1, 1, 0.1 * Math.sin(7) * Math.cos(5)]))),
    "three faces at an edge": () =>
        weld(join(makeSheet(() => 0), makeGrid(8, 3, (x, z) => [[x, 0.5, z]]))),
    "a Moebius strip": makeMoebius,
    "faces turned over": () => turn(makeRound(), f => f % 16 === 0 || (f > 100 && f < 140)),
    "cards with backs": () => join(...[0, 1, 2].map(k => makeCard((Math.PI * k) / 3))),
    dirt: makeDirt,
    "boxes that touch": () =>
        weld(join(...[[0, 0, 0], [2, 2, 0], [4, 4, 2]].map(at => move({ index: makeCube().index, positions: makeCube().positions }, at)))),
    "a soup of triangles": () => {
        const { index, positions } = makeRound();
        return {
            index: Array.from(index, (_, i) => i),
            positions: Array.from(index).flatMap(v => Array.from(positions.subarray(3 * v, 3 * v + 3))),
        };
    },
    "one triangle": () => ({ index: [0, 1, 2], positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] }),
    "texture coordinates on a closed surface": () => wrap(makeRound()),
};
