#!/usr/bin/env python3
"""Bytes against distance from the exact mesh, for each goal and for other libraries.   SPDX-License-Identifier: MIT

    quality.py CQM PEERS LODS OUT MESH...

writes OUT/results.csv, OUT/targets.txt, OUT/table.md, OUT/lods.md (levels of detail) and for each mesh OUT/NAME.png
(curves) and OUT/NAME-sheet.png.
Distances are in per cent of the diagonal of the bounding box. The exit status does not depend on the targets.
"""
import csv
import math
import pathlib
import subprocess
import sys

import pictures
import surface

GOALS = ["balanced", "least-connectivity"]
PERCENTS = [1, 2, 5, 10, 25, 50, 100]
DRACO_BITS = range(3, 13)
LEVELS = [32, 16, 8, 4, 2]      # parts of the vertices
COLUMNS = ["mesh", "codec", "setting", "bytes", "vertices", "rms", "hausdorff", "flipped"]


class Measured:
    """A mesh file, with all that was made of it."""

    def __init__(self, cqm, peers, lods, out, path):
        self.cqm, self.peers, self.lods = cqm, peers, lods
        self.name = pathlib.Path(path).stem
        self.work = out / "work"
        self.work.mkdir(parents=True, exist_ok=True)
        self.input = self.work / "input.ply"
        self.run(peers, "copy", path, self.input)
        self.exact = surface.read(self.input)
        self.size = {}     # of a goal's stream
        self.rows = []

    @staticmethod
    def run(*words):
        return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout

    def add(self, codec, setting, size, path):
        mesh = surface.read(path)
        scale = 100 / surface.diagonal(self.exact[0])
        rms, hausdorff = surface.distances(mesh, self.exact)
        row = dict(zip(COLUMNS, [self.name, codec, setting, size, len(mesh[0]), rms * scale, hausdorff * scale,
                                 surface.flipped(mesh, self.exact)]))
        self.rows.append(row)
        return row, mesh

    def encode(self, goal):
        stream = self.work / f"{goal}.cqm"
        self.run(self.cqm, "encode", "--quiet", "--goal", goal, self.input, stream)
        self.size[goal] = stream.stat().st_size

    def decode(self, goal, setting, size):
        """The row and the mesh of a prefix; None if it does not hold a mesh."""
        path = self.work / "decoded.ply"
        try:
            self.run(self.cqm, "decode", "--bytes", size, self.work / f"{goal}.cqm", path)
        except subprocess.CalledProcessError:
            return None
        return self.add(goal, setting, size, path)

    def draco(self, bits):
        path = self.work / "draco.ply"
        return self.add("draco", f"{bits} bits", int(self.run(self.peers, "draco", bits, self.input, path)), path)[0]

    def simplify(self, vertices):
        path = self.work / "simplified.ply"
        self.run(self.peers, "simplify", vertices, self.input, path)
        self.add("meshoptimizer", f"{vertices} vertices", None, path)

    def levels(self):
        """For each level of detail, the coarsest first, its triangles and the rows of ours and of meshoptimizer's."""
        counts = [str(len(self.exact[0]) // part) for part in LEVELS]
        told = self.run(self.lods, self.work / "balanced.cqm", self.work / "level", *counts).split("\n")
        for k, line in enumerate(filter(None, told)):
            triangles = int(line.split()[1])
            ours = self.add("level of detail", f"{triangles} triangles", None, self.work / f"level-{k}.ply")[0]
            path = self.work / "reduced.ply"
            self.run(self.peers, "reduce", triangles, self.input, path)
            yield triangles, ours, self.add("meshoptimizer", f"{triangles} triangles", None, path)[0]


def measure(mesh):
    """Fills mesh.rows; returns the lines of the contact sheet."""
    lines = []
    for goal in GOALS:
        mesh.encode(goal)
        cells = []
        for percent in PERCENTS:
            decoded = mesh.decode(goal, f"{percent} %", mesh.size[goal] * percent // 100)
            caption = f"{percent} %, " + (f"{decoded[0]['vertices']} vertices" if decoded else "no mesh yet")
            cells.append((caption, decoded[1] if decoded else None))
        lines.append((goal, cells))
    for row in [row for row in mesh.rows if row["codec"] == "balanced"]:
        mesh.simplify(row["vertices"])
    for bits in DRACO_BITS:
        row = mesh.draco(bits)
        for goal in GOALS:
            if row["bytes"] <= 0.8 * mesh.size[goal]:
                mesh.decode(goal, f"as draco, {bits} bits", row["bytes"])
    return lines


# -- Targets ---------------------------------------------------------------------------------------------------------


def find(rows, codec, setting):
    return next((row for row in rows if row["codec"] == codec and row["setting"] == setting), None)


def against_draco(rows, goal):
    """Number of Draco's files of at most 80 % of ours that are worse than as many of our bytes, number of them all, and
    the bytes of the smallest one that is not."""
    better, total, first = 0, 0, None
    for bits in DRACO_BITS:
        ours, draco = find(rows, goal, f"as draco, {bits} bits"), find(rows, "draco", f"{bits} bits")
        if draco["bytes"] > 0.8 * find(rows, goal, "100 %")["bytes"]:
            continue
        total += 1
        if ours and ours["rms"] < draco["rms"]:
            better += 1
        else:
            first = first or draco["bytes"]
    return better, total, first


def judge(text, is_met, numbers):
    return f"{'met   ' if is_met else 'MISSED'}  {text}: {numbers}"


def targets(mesh):
    lines = []
    for goal in GOALS:
        name = f"{mesh.name}, {goal}"
        better, total, first = against_draco(mesh.rows, goal)
        numbers = f"{better} of {total}" + (f", not at {first} of {mesh.size[goal]} bytes" if first else "")
        lines.append(judge(f"{name}: lower RMS than Draco files of the same size", better == total, numbers))
        row = find(mesh.rows, goal, "2 %")
        if len(mesh.exact[0]) > 10000:
            numbers = f"{row['rms']:.2f} %" if row else "no mesh yet"
            lines.append(judge(f"{name}: RMS below 2 % with 2 % of the bytes", row and row["rms"] < 2, numbers))
        row = find(mesh.rows, goal, "5 %")
        if mesh.name == "fandisk":
            numbers = f"{row['flipped']} with {row['vertices']} vertices"
            lines.append(judge(f"{name}: no face turned over with 5 % of the bytes", not row["flipped"], numbers))
    return lines


def table(mesh):
    """RMS distances as a table for people."""
    for goal in GOALS:
        found = [find(mesh.rows, goal, f"{percent} %") for percent in PERCENTS]
        cells = [mesh.name, goal, str(mesh.size[goal])] + [f"{row['rms']:.3f}" if row else "-" for row in found]
        better, total, _ = against_draco(mesh.rows, goal)
        yield "| " + " | ".join(cells + [f"{better} of {total}"]) + " |"


def table_head():
    names = ["mesh", "goal", "bytes"] + [f"{percent} %" for percent in PERCENTS] + ["better than Draco"]
    return ["| " + " | ".join(names) + " |", "| --- | --- |" + " ---: |" * (len(names) - 2)]


# -- Levels of detail ------------------------------------------------------------------------------------------------


LOD_HEAD = ["| mesh | triangles | RMS: ours, simplifier | Hausdorff: ours, simplifier |", "| --- | ---: | ---: | ---: |"]
CHAIN_HEAD = ["", "| mesh, and five levels | one vertex buffer | simplifier, a vertex buffer each | coarsest alone: ours | "
              "simplifier, one vertex buffer |", "| --- | ---: | ---: | ---: | ---: |"]
VERTEX, TRIANGLE = 12, 12       # bytes of positions and of indices


def lod_tables(mesh):
    """Rows of both tables, and the logarithms of our distances over those of the simplifier."""
    levels = list(mesh.levels())
    rows, ratios = [], []
    for triangles, ours, theirs in levels:
        rows.append(f"| {mesh.name} | {triangles} | {ours['rms']:.4f}, {theirs['rms']:.4f} | "
                    f"{ours['hausdorff']:.3f}, {theirs['hausdorff']:.3f} |")
        ratios.append([math.log(ours[what] / theirs[what]) for what in ("rms", "hausdorff")])
    everything = VERTEX * len(mesh.exact[0]) + TRIANGLE * len(mesh.exact[1])
    chain = TRIANGLE * sum(triangles for triangles, _, _ in levels)
    each = chain + VERTEX * sum(theirs["vertices"] for _, _, theirs in levels)
    first = TRIANGLE * levels[0][0]
    sizes = [everything + chain, everything + each, first + VERTEX * levels[0][1]["vertices"],
             first + VERTEX * len(mesh.exact[0])]
    return rows, f"| {mesh.name} | " + " | ".join(f"{size / 1e3:.0f} KB" for size in sizes) + " |", ratios


def lod_summary(ratios):
    rms, hausdorff = (math.exp(sum(pair[k] for pair in ratios) / len(ratios)) for k in (0, 1))
    return (f"levels of detail: {rms:.2f} times the RMS, {hausdorff:.2f} times the Hausdorff distance of the simplifier's "
            f"with as many triangles (geometric mean of {len(ratios)})")


def write(out, rows, lines, tables):
    with open(out / "results.csv", "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    (out / "targets.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (out / "table.md").write_text("\n".join(tables) + "\n", encoding="utf-8")


def main():
    cqm, peers, lods, out, *paths = sys.argv[1:]
    out = pathlib.Path(out)
    rows, lines, tables = [], [], table_head()
    levels, chains, ratios = LOD_HEAD, CHAIN_HEAD, []
    for path in paths:
        mesh = Measured(cqm, peers, lods, out, path)
        cells = measure(mesh)
        pictures.curves(mesh.rows, out / f"{mesh.name}.png")
        pictures.sheet(cells, surface.is_closed(mesh.exact), out / f"{mesh.name}-sheet.png")
        judged = targets(mesh)
        more_levels, chain, more_ratios = lod_tables(mesh)
        levels, chains, ratios = levels + more_levels, chains + [chain], ratios + more_ratios
        print("\n".join(judged), flush=True)
        rows += mesh.rows
        lines += judged
        tables += table(mesh)
        write(out, rows, lines, tables)      # what is there if the rest is not waited for
        (out / "lods.md").write_text("\n".join(levels + chains + ["", lod_summary(ratios)]) + "\n", encoding="utf-8")
    print(lod_summary(ratios))


if __name__ == "__main__":
    main()
