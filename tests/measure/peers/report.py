"""Sums up what peers.cpp printed: report.py RESULTS.tsv

Ratios are our bytes to Draco's. "Pooled" is that of all bytes of a class together, so that large meshes count most;
"median" is that of the meshes' ratios, so that all count the same. Meshes of fewer than 300 vertices are left out. The
classes are those of the share of vertices of valence 6; a mesh is also CAD-like if it has both flat and sharp edges.
"""
import math
import statistics
import sys
from typing import NamedTuple

LEAST_VERTICES = 300
REGULAR = 75            # per cent of valence 6, from which on the geometric mean is given
FLAT, SHARP = 30, 3     # per cent of edges that a CAD-like mesh has at least
WORST = 10


class Mesh(NamedTuple):
    name: str
    vertices: int
    faces: int
    valence_6: float
    flat: float
    sharp: float
    ours: float
    our_positions: float
    draco: float
    draco_positions: float

    def ratio(self):
        return self.ours / self.draco

    def is_cad_like(self):
        return self.flat >= FLAT and self.sharp >= SHARP


CLASSES = [
    ("valence 6: below 50 %", lambda m: m.valence_6 < 50),
    ("50 to 75 %", lambda m: 50 <= m.valence_6 < 75),
    ("75 to 90 %", lambda m: 75 <= m.valence_6 < 90),
    ("90 % and more", lambda m: m.valence_6 >= 90),
    ("all", lambda m: True),
    ("CAD-like", Mesh.is_cad_like),
    ("not CAD-like", lambda m: not m.is_cad_like()),
]


def read(path):
    with open(path, encoding="utf-8") as lines:
        rows = [line.rstrip("\n").split("\t") for line in lines]
    return [Mesh(row[0], *(kind(cell) for kind, cell in zip(list(Mesh.__annotations__.values())[1:], row[1:])))
            for row in rows]


# Bits of both codecs, for one mesh: in all, of connectivity, of positions.
PARTS = [
    lambda m: (m.ours, m.draco),
    lambda m: (m.ours - m.our_positions, m.draco - m.draco_positions),
    lambda m: (m.our_positions, m.draco_positions),
]


def pooled(meshes, part):
    ours, draco = (sum(bits) for bits in zip(*map(part, meshes)))
    return ours / draco


def median(meshes, part):
    pairs = [part(m) for m in meshes]
    return statistics.median(ours / draco if draco > 0 else math.inf for ours, draco in pairs)


def row(name, meshes):
    if not meshes:
        return f"| {name} | 0 | | | | | | | |"
    smaller = 100 * sum(m.ours < m.draco for m in meshes) / len(meshes)
    cells = [f"{of(meshes, part):.2f}" for of in (pooled, median) for part in PARTS]
    return f"| {name} | {len(meshes)} | {smaller:.0f} % | " + " | ".join(cells) + " |"


def mean_line(meshes):
    regular = [m for m in meshes if m.valence_6 >= REGULAR]
    mean = math.exp(statistics.fmean(math.log(m.ratio()) for m in regular)) if regular else math.nan
    return f"Geometric mean of the {len(regular)} meshes with at least {REGULAR} % of valence 6: {mean:.2f}."


def worst_row(m):
    parts = [f"{bits / m.vertices:.2f}" for part in PARTS[1:] for bits in part(m)]
    return f"| {m.name} | {m.vertices} | {m.valence_6:.0f} % | {m.ratio():.2f} | " + " | ".join(parts) + " |"


def report(meshes):
    large = [m for m in meshes if m.vertices >= LEAST_VERTICES]
    yield f"{len(large)} meshes of {LEAST_VERTICES} vertices and more, {len(meshes) - len(large)} smaller ones left out"
    yield ""
    yield "| our bytes to Draco's | meshes | ours smaller | pooled | connectivity | positions " \
          "| median | connectivity | positions |"
    yield "| --- " + "| ---: " * 8 + "|"
    for name, belongs in CLASSES:
        yield row(name, [m for m in large if belongs(m)])
    yield ""
    yield mean_line(large)
    yield ""
    yield "| worst, bits per vertex | vertices | valence 6 | ratio | connectivity | Draco's | positions | Draco's |"
    yield "| --- " + "| ---: " * 7 + "|"
    yield from map(worst_row, sorted(large, key=Mesh.ratio, reverse=True)[:WORST])


def main():
    meshes = read(sys.argv[1])
    if not any(m.vertices >= LEAST_VERTICES for m in meshes):
        sys.exit("nothing to compare")
    print("\n".join(report(meshes)))


if __name__ == "__main__":
    main()
