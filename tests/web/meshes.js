/* Meshes and streams that the tests make. SPDX-License-Identifier: MIT */

/** A sphere, dented so that no two places look alike: its latitudes and longitudes are closed without a seam. */
export function makeSphere(columns = 48, rows = 24) {
    const positions = [0, 0, 1],
        index = [],
        at = (r, c) => 1 + (r - 1) * columns + (c % columns);
    for (let r = 1; r < rows; r++) {
        for (let c = 0; c < columns; c++) {
            const [theta, phi] = [(Math.PI * r) / rows, (2 * Math.PI * c) / columns];
            const radius = 1 + 0.1 * Math.sin(3 * phi) * Math.sin(theta) ** 2 + 0.05 * Math.cos(5 * theta);
            positions.push(
                radius * Math.sin(theta) * Math.cos(phi),
                radius * Math.sin(theta) * Math.sin(phi),
                radius * Math.cos(theta),
            );
        }
    }
    const last = positions.push(0, 0, -1) / 3 - 1;
    for (let c = 0; c < columns; c++) {
        index.push(0, at(1, c), at(1, c + 1), last, at(rows - 1, c + 1), at(rows - 1, c));
        for (let r = 1; r < rows - 1; r++)
            index.push(at(r, c), at(r + 1, c), at(r + 1, c + 1), at(r, c), at(r + 1, c + 1), at(r, c + 1));
    }
    return { positions: Float32Array.from(positions), index: Uint32Array.from(index) };
}

/** The sphere with all attributes. */
export function makeDressed(columns, rows) {
    const { positions, index } = makeSphere(columns, rows);
    const vertices = positions.length / 3,
        faces = index.length / 3;
    const unit = new Float32Array(3 * vertices),
        each = (n, f) => Array.from({ length: n }, (_, k) => f(k));
    for (let v = 0; v < vertices; v++) {
        const length = Math.hypot(...positions.slice(3 * v, 3 * v + 3));
        for (let k = 0; k < 3; k++) unit[3 * v + k] = positions[3 * v + k] / length;
    }
    return {
        positions,
        index,
        normals: unit,
        tangents: Float32Array.from(each(vertices, v => unit.subarray(3 * v, 3 * v + 3))
            .flatMap(([x, y, z], v) => (Math.hypot(x, y) > 0.01 ? [-y / Math.hypot(x, y), x / Math.hypot(x, y), 0] : [1, 0, 0 * z]).concat(v % 5 ? 1 : -1))),
        texcoords: Float32Array.from(each(2 * vertices, k => positions[3 * (k >> 1) + (k % 2)] * 0.5)),
        colors: Uint8Array.from(each(3 * vertices, k => Math.round(127 + 127 * unit[k]))),
        joints: Uint8Array.from(each(4 * vertices, k => ((k >> 2) % 4) + (k % 4))),
        weights: Float32Array.from(each(4 * vertices, k => [0.5, 0.25, 0.25, 0][k % 4])),
        materials: Uint16Array.from(each(faces, f => f % 3)),
    };
}

/** Triangles as sorted strings of what `name` gives for each vertex: equal for equal meshes. */
export function describe(index, faces, name) {
    return Array.from({ length: faces }, (_, f) => {
        const corners = [0, 1, 2].map(k => name(index[3 * f + k]));
        const first = corners.indexOf([...corners].sort()[0]);
        return [0, 1, 2].map(k => corners[(first + k) % 3]).join(" ");
    }).sort();
}

/** Bytes in pieces of a size. */
export function* cut(data, size) {
    for (let at = 0; at < data.length; at += size) yield data.subarray(at, at + size);
}
