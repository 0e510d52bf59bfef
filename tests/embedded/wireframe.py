#!/usr/bin/env python3
"""Compares the picture of examples/microcontroller/display.c with one in floating point.   SPDX-License-Identifier: MIT

    wireframe.py PRINTED MESH.off       what the program has printed, and the mesh that it has decoded

Each lit pixel is beside an edge of a face that faces the viewer, and each such edge is lit.
"""
import math
import sys

WIDTH, TURN, NEAR = 128, 64, 1.5


def read_lit(lines):
    """Pixels (x, y), from lines with a character for two of them."""
    bits = {" ": (), "'": (0,), ".": (1,), ":": (0, 1)}
    rows = [line for line in lines if len(line) == WIDTH and set(line) <= set(bits)]
    return {(x, 2 * k + bit) for k, row in enumerate(rows) for x, mark in enumerate(row) for bit in bits[mark]}


def read_mesh(path):
    with open(path, encoding="utf-8") as file:
        numbers = file.read().split()[1:]
    vertices, faces = int(numbers[0]), int(numbers[1])
    at = [[float(x) for x in numbers[k:k + 3]] for k in range(3, 3 + 3 * vertices, 3)]
    first = 3 + 3 * vertices
    return at, [[int(x) for x in numbers[k + 1:k + 4]] for k in range(first, first + 4 * faces, 4)]


def turn(at, part):
    """Right and up, seen from 30 degrees above."""
    angle, (x, y, z) = 2 * math.pi * part / TURN, at
    behind = math.sin(angle) * x + math.cos(angle) * y
    return math.cos(angle) * x - math.sin(angle) * y, math.cos(math.pi / 6) * z + math.sin(math.pi / 6) * behind


def visible_edges(points, faces):
    for a, b, c in faces:
        (ax, ay), (bx, by), (cx, cy) = points[a], points[b], points[c]
        if (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0:
            yield from ((a, b), (b, c), (c, a))


def fit(points, lit):
    """On the screen: as wide as what is lit, about the same centre."""
    (left, right), (low, high) = ((min(numbers), max(numbers)) for numbers in zip(*points))
    (x0, x1), (y0, y1) = ((min(numbers), max(numbers)) for numbers in zip(*lit))
    scale = (x1 - x0) / (right - left)
    return [((x0 + x1) / 2 + scale * (x - (left + right) / 2), (y0 + y1) / 2 - scale * (y - (low + high) / 2))
            for x, y in points]


def samples(points, edges):
    for a, b in edges:
        (ax, ay), (bx, by) = points[a], points[b]
        count = int(math.dist(points[a], points[b])) + 1
        yield from ((ax + (bx - ax) * k / count, ay + (by - ay) * k / count) for k in range(count + 1))


def far(points, others):
    """How many of the points are beside none of the others."""
    cells = {}
    for point in others:
        cells.setdefault((round(point[0]), round(point[1])), []).append(point)
    around = [(i, j) for i in (-2, -1, 0, 1, 2) for j in (-2, -1, 0, 1, 2)]
    return sum(not any(math.dist(point, other) <= NEAR for i, j in around
                       for other in cells.get((round(point[0]) + i, round(point[1]) + j), ())) for point in points)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        lines = file.read().split("\n")
    lit = read_lit(lines)
    at, faces = read_mesh(sys.argv[2])
    part = max(int(line.split()[1]) for line in lines if line.startswith("frame "))
    turned = [turn(vertex, part) for vertex in at]
    edges = list(visible_edges(turned, faces))
    drawn = list(samples(fit(turned, lit), edges))
    dark, stray = far(drawn, lit), far(lit, drawn)
    print(f"{len(edges)} edges, {len(lit)} pixels: {dark} of {len(drawn)} places of edges dark, {stray} pixels astray")
    # A face on its side may be seen in one picture and not in the other.
    return not (len(lit) > 100 and dark <= len(drawn) / 50 and stray <= len(lit) / 50)


if __name__ == "__main__":
    sys.exit(main())
