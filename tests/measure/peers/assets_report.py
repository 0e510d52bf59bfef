"""Sums up what assets.cpp printed: assets_report.py RESULTS.tsv

Of meshes with seams, that is with more rows than vertices. "Pooled" is the ratio of all bytes together, so that large
meshes count most; "median" that of the meshes' ratios. Something is drawn early if 10 % of the bytes are enough.
"""
import statistics
import sys
from typing import NamedTuple

MANY_VERTICES = 500     # from which on it counts how early something is drawn
EARLY = 10              # per cent of the bytes
WORST = 10
PARTS = ["header", "base faces", "base positions", "base values", "flags", "indices", "positions", "values", "aside"]


class Asset(NamedTuple):
    name: str
    rows_in: int
    faces: int
    vertices: int
    rows: int
    base: int
    ours: int
    draco: int
    drawn: int
    parts: list

    def ratio(self):
        return self.ours / self.draco

    def is_drawn_early(self):
        return 100 * self.drawn <= EARLY * self.ours


def read(path):
    with open(path, encoding="utf-8") as lines:
        rows = [line.rstrip("\n").split("\t") for line in lines]
    return [Asset(row[0], *map(int, row[1:9]), list(map(float, row[9:]))) for row in rows]


def worst_row(a):
    parts = " | ".join(f"{100 * part / a.ours:.0f} %" for part in a.parts)
    return f"| {a.name} | {a.vertices} | {a.rows} | {a.base} | {a.ratio():.2f} | {parts} |"


def report(assets):
    large = [a for a in assets if a.vertices > MANY_VERTICES]
    yield f"{len(assets)} meshes with seams and all their attributes, our bytes to Draco's:"
    yield f"median {statistics.median(map(Asset.ratio, assets)):.3f}, " \
          f"pooled {sum(a.ours for a in assets) / sum(a.draco for a in assets):.3f}"
    yield f"vertices in the base, median: {100 * statistics.median(a.base / a.vertices for a in assets):.1f} %"
    early = sum(map(Asset.is_drawn_early, large))
    yield f"drawn with {EARLY} % of the bytes: {early} of {len(large)} meshes with more than {MANY_VERTICES} vertices"
    yield ""
    yield "| worst | vertices | rows | base | ratio | " + " | ".join(PARTS) + " |"
    yield "| --- " + "| ---: " * (4 + len(PARTS)) + "|"
    yield from map(worst_row, sorted(assets, key=Asset.ratio, reverse=True)[:WORST])


def main():
    assets = [a for a in read(sys.argv[1]) if a.rows > a.vertices]
    if not any(a.vertices > MANY_VERTICES for a in assets):
        sys.exit("nothing to compare")
    print("\n".join(report(assets)))


if __name__ == "__main__":
    main()
