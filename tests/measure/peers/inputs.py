"""Writes small files as published ones are, with what makes trouble: inputs.py FOLDER

Hard edges, seams of texture coordinates, creases, fans that share a vertex, edges of three and four faces, a Moebius
strip, faces turned over, double-sided cards, faces that are no surface, two materials, a limb, flat facets without
indices.
SPDX-License-Identifier: MIT"""

import math
import pathlib
import random
import sys
from math import cos, pi, sin


class Obj:
    """Corners name a position, and perhaps texture coordinates and a normal, as in the file, but from 0 on."""

    def __init__(self, positions=(), faces=()):
        self.positions, self.texcoords, self.normals = list(positions), [], []
        self.faces = [[(v, None, None) for v in face] for face in faces]
        self.material = {}                     # by the number of the face from which on it is used

    def vertex(self, position, texcoord=None, normal=None):
        self.positions.append(position)
        if texcoord is not None:
            self.texcoords.append(texcoord)
        if normal is not None:
            self.normals.append(normal)
        n = len(self.positions) - 1
        return n, None if texcoord is None else n, None if normal is None else n

    def text(self):
        for word, lines in ("v", self.positions), ("vt", self.texcoords), ("vn", self.normals):
            yield from (f"{word} " + " ".join(f"{x:.9g}" for x in line) for line in lines)
        for k, face in enumerate(self.faces):
            if k in self.material:
                yield f"usemtl {self.material[k]}"
            words = ("/".join("" if n is None else str(n + 1) for n in corner).rstrip("/") for corner in face)
            yield "f " + " ".join(words)


def quad(a, b, c, d):
    return [(a, b, c), (a, c, d)]


def grid(n, m, at):
    positions = [at(i / n, j / m) for j in range(m + 1) for i in range(n + 1)]
    faces = []
    for j in range(m):
        for i in range(n):
            a = j * (n + 1) + i
            faces += quad(a, a + 1, a + n + 2, a + n + 1)
    return positions, faces


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.hypot(*a)
    return [x / length for x in a]


def cube_with_hard_edges():
    out = Obj()
    for axis in range(3):
        for side in (-1, 1):
            normal = [side * (k == axis) for k in range(3)]
            u = [int(k == (axis + 1) % 3) for k in range(3)]
            w = cross(normal, u)
            corners = []
            for x, y in (-1, -1), (1, -1), (1, 1), (-1, 1):
                position = [n + x * a + y * b for n, a, b in zip(normal, u, w)]
                corners.append(out.vertex(position, ((x + 1) / 2, (y + 1) / 2), normal))
            out.faces += quad(*corners)
    return out


SECTORS, RINGS = 32, 20


def sphere():
    """Positions, and faces as lists of (sector, ring). Sectors go up to SECTORS at the seam, and in halves at poles."""
    def place(i, j):
        a, b = 2 * pi * i / SECTORS, pi * j / RINGS
        x, y, z = sin(b) * cos(a), sin(b) * sin(a), cos(b)
        size = 1 + 0.15 * sin(5 * x) * cos(4 * z)
        return size * x, size * y, size * z
    positions = [place(0, 0)] + [place(i, j) for j in range(1, RINGS) for i in range(SECTORS)] + [place(0, RINGS)]
    faces = []
    for i in range(SECTORS):
        faces.append([(i + 0.5, 0), (i, 1), (i + 1, 1)])
        for j in range(1, RINGS - 1):
            faces += map(list, quad((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)))
        faces.append([(i, RINGS - 1), (i + 0.5, RINGS), (i + 1, RINGS - 1)])
    return positions, faces


def of_sphere(corner):
    i, j = corner
    return 0 if j == 0 else len(sphere()[0]) - 1 if j == RINGS else 1 + (j - 1) * SECTORS + i % SECTORS


def sphere_with_seam():
    positions, faces = sphere()
    out = Obj(positions)
    texcoord = {corner: k for k, corner in enumerate(sorted({c for face in faces for c in face}))}
    out.texcoords = [(i / SECTORS, j / RINGS) for i, j in texcoord]
    out.faces = [[(of_sphere(c), texcoord[c], None) for c in face] for face in faces]
    return out


def cylinder_with_creases(n=40, m=12):
    out = Obj()
    around = [(cos(2 * pi * i / n), sin(2 * pi * i / n)) for i in range(n)]
    out.positions = [(x, y, 2 * k / m - 1) for k in range(m + 1) for x, y in around] + [(0, 0, -1), (0, 0, 1)]
    out.normals = [(x, y, 0) for x, y in around] + [(0, 0, -1), (0, 0, 1)]
    out.texcoords = [(i / n, 0.5 * k / m) for k in range(m + 1) for i in range(n + 1)]
    caps = len(out.texcoords)
    for centre in (0.25, 0.75):
        out.texcoords += [(centre + 0.2 * x, 0.75 + 0.2 * y) for x, y in around] + [(centre, 0.75)]

    def side(i, k):
        return k * n + i % n, k * (n + 1) + i, i % n

    def cap(i, upper):
        return upper * m * n + i % n, caps + upper * (n + 1) + i % n, n + upper

    for i in range(n):
        for k in range(m):
            out.faces += quad(side(i, k), side(i + 1, k), side(i + 1, k + 1), side(i, k + 1))
        out.faces.append((cap(i + 1, 0), cap(i, 0), ((m + 1) * n, caps + n, n)))
        out.faces.append((cap(i, 1), cap(i + 1, 1), ((m + 1) * n + 1, caps + 2 * n + 1, n + 1)))
    return out


def five_fans_at_a_vertex():
    positions, faces = grid(6, 6, lambda x, y: (x, y, 0.1 * sin(6 * x)))
    out, centre = Obj(positions, faces), positions[24]
    for s in range(4):
        tip = [c + 0.3 * d for c, d in zip(centre, (cos(s), sin(s), 1.5))]
        out.faces.append([(24, None, None), out.vertex(tip), out.vertex([tip[0] + 0.1, *tip[1:]])])
    return out


def edges_of_three_faces():
    positions, faces = grid(16, 12, lambda x, y: (2 * x - 1, 2 * y - 1, 0.15 * cos(3 * x + 2 * y)))
    before = [6 * 17 + i for i in range(3, 17)]
    spine = [positions[v] for v in before]
    for h in range(1, 5):
        row = [len(positions) + k for k in range(len(spine))]
        positions += [(x, y + 0.0125 * h * h, z + 0.2 * h) for x, y, z in spine]
        for k in range(len(spine) - 1):
            faces += quad(before[k], before[k + 1], row[k + 1], row[k])
        before = row
    return Obj(positions, faces)


def moebius_strip(n=36):
    def place(i, s):
        a = 2 * pi * i / n
        return (1 + s * cos(a / 2)) * cos(a), (1 + s * cos(a / 2)) * sin(a), s * sin(a / 2)
    faces = []
    for i in range(n):
        for k in range(2):
            a, b = 3 * i + k, 3 * i + k + 1
            c, d = (a + 3, b + 3) if i < n - 1 else (2 - k, 1 - k)
            faces += [(a, c, b), (b, c, d)]
    return Obj([place(i, s) for i in range(n) for s in (-0.3, 0, 0.3)], faces)


def faces_turned_over():
    positions, faces = sphere()
    dice = random.Random(1)
    faces = [[of_sphere(c) for c in face] for face in faces]
    first = [positions[face[0]] for face in faces]
    return Obj(positions, [face[::-1] if (z > 0.3 and x > 0) or dice.random() < 0.01 else face
                           for face, (x, _, z) in zip(faces, first)])


def double_sided_cards():
    out = Obj()
    for k in range(3):
        a = pi * k / 3
        for side in (1, -1):
            positions, faces = grid(4, 6, lambda x, y: ((x - 0.5) * cos(a) + 0.05 * sin(3 * y) * sin(a),
                                                        (x - 0.5) * sin(a) - 0.05 * sin(3 * y) * cos(a), y))
            normal = side * sin(a), -side * cos(a), 0
            corners = [out.vertex(p, (v % 5 / 4, v // 5 / 6), normal) for v, p in enumerate(positions)]
            out.faces += [[corners[v] for v in face[::side]] for face in faces]
    return out


def dirt():
    positions, faces = grid(8, 8, lambda x, y: (x, y, 0.2 * x * y))
    positions += [(9, 9, 9), (8, 8, 8), (0.5, 0.5, 0.5), positions[40]]
    a, b, c = faces[20]
    faces += [(0, 0, 1), (5, 6, 5), faces[10], (b, c, a), faces[30][::-1], (40, len(positions) - 1, 41)]
    return Obj(positions, faces)


def two_materials():
    positions, faces = grid(20, 20, lambda x, y: (2 * x - 1, 2 * y - 1, 0.4 * sin(3 * x) * cos(2 * y)))
    out = Obj(positions)
    out.texcoords = [((x + 1) / 2, (y + 1) / 2) for x, y, _ in positions]

    def is_left(face):
        x, y = (sum(positions[v][k] for v in face) / 3 for k in range(2))
        return x < 0.3 * sin(4 * y)

    faces.sort(key=is_left)
    out.faces = [[(v, v, None) for v in face] for face in faces]
    out.material = {0: "right", sum(not is_left(face) for face in faces): "left"}
    return out


def limb(n=16, m=24):
    out = Obj()
    for k in range(m + 1):
        for i in range(n + 1):
            a = 2 * pi * (i % n) / n
            out.vertex((0.3 * cos(a), 0.3 * sin(a), 4 * k / m), (i / n, k / m))
    _, faces = grid(n, m, lambda x, y: (x, y, 0))
    out.faces = [[(v, v, None) for v in face] for face in faces]
    return out


def flat_facets():
    positions, faces = sphere()
    out = Obj()
    for face in faces:
        a, b, c = (positions[of_sphere(corner)] for corner in face)
        normal = unit(cross(minus(b, a), minus(c, a)))
        out.faces.append([out.vertex(p, None, normal) for p in (a, b, c)])
    for k in range(32):
        a, b = out.vertex(positions[k]), out.vertex(positions[k + 1])
        out.faces.append([a[:1] + (None, None), b[:1] + (None, None)])
    return out


def touching_boxes():
    out = Obj()
    for x, y, z in (0, 0, 0), (1, 1, 0), (2, 2, 1):
        box = [(x + i, y + j, z + k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
        for side in (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5):
            for triangle in quad(*(box[v] for v in side)):
                out.faces.append([out.vertex(p) for p in triangle])
    return out


INPUTS = [cube_with_hard_edges, sphere_with_seam, cylinder_with_creases, five_fans_at_a_vertex, edges_of_three_faces,
          moebius_strip, faces_turned_over, double_sided_cards, dirt, two_materials, limb, flat_facets, touching_boxes]


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for number, make in enumerate(INPUTS, 1):
        obj = make()
        lines = ["l" + line[1:] if line.startswith("f ") and line.count(" ") == 2 else line for line in obj.text()]
        (folder / f"{number:02d}_{make.__name__}.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
