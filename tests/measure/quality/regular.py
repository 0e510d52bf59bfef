#!/usr/bin/env python3
"""Distance from the exact mesh with and without regular levels, at the same bytes.   SPDX-License-Identifier: MIT

    regular.py CQM OUT MESH...

prints a table of the meshes that the goal balanced uses regular levels for, and writes it to OUT/regular.md: the RMS distance
over that of conquest levels alone, at parts of the bytes of the smaller stream.
"""
import json
import math
import pathlib
import subprocess
import sys

import surface

PERCENTS = [5, 10, 25, 50, 75, 90]
LEAST_VERTICES = 300


def run(*words):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout


class Pair:
    """Two streams of a mesh: with regular levels, if it uses any, and without."""

    def __init__(self, cqm, work, path):
        self.cqm, self.work, self.path = cqm, work, path
        self.streams = [work / "regular.cqm", work / "conquest.cqm"]
        run(cqm, "encode", "--quiet", path, self.streams[0])
        levels = json.loads(run(cqm, "info", "--json", self.streams[0]))["per_level"]
        self.vertices = levels[-1]["vertices"] if levels else 0
        self.is_regular = any(level["type"] == "regular" for level in levels)

    def compare(self):
        """Bytes of both, and the ratios; None where a prefix is no mesh yet, or exact."""
        run(self.cqm, "encode", "--quiet", "--conquest-only", self.path, self.streams[1])
        exact = self.work / "exact.ply"
        run(self.cqm, "decode", self.streams[1], exact)
        sizes = [stream.stat().st_size for stream in self.streams]
        reference = surface.read(exact)
        return sizes, [self.ratio(min(sizes) * percent // 100, reference) for percent in PERCENTS]

    def ratio(self, size, reference):
        both = [self.distance(stream, size, reference) for stream in self.streams]
        return both[0] / both[1] if all(both) else None

    def distance(self, stream, size, reference):
        path = self.work / "decoded.ply"
        try:
            run(self.cqm, "decode", "--bytes", size, stream, path)
        except subprocess.CalledProcessError:
            return None
        return surface.distances(surface.read(path), reference)[0]


def mean(ratios):
    known = [math.log(ratio) for ratio in ratios if ratio]
    return math.exp(sum(known) / len(known)) if known else math.nan


def row(cells):
    return "| " + " | ".join(cells) + " |"


def main():
    cqm, out, *paths = sys.argv[1:]
    out = pathlib.Path(out)
    work = out / "work"
    work.mkdir(parents=True, exist_ok=True)
    lines = [row(["mesh", "bytes", "of conquest levels"] + [f"{percent} %" for percent in PERCENTS] + ["mean"]),
             row(["---"] + ["---:"] * (len(PERCENTS) + 3))]
    means = []
    print("\n".join(lines), flush=True)
    for path in paths:
        pair = Pair(cqm, work, path)
        if not pair.is_regular or pair.vertices < LEAST_VERTICES:
            continue
        sizes, ratios = pair.compare()
        means.append(mean(ratios))
        lines.append(row([pathlib.Path(path).stem] + [str(size) for size in sizes] +
                         [f"{ratio:.2f}" if ratio else "-" for ratio in ratios] + [f"{means[-1]:.2f}"]))
        print(lines[-1], flush=True)
    if not means:
        sys.exit("no mesh uses regular levels")
    lines.append(f"\nregular levels: {mean(means):.2f} times the RMS distance of conquest levels alone at the same bytes "
                 f"(geometric mean of {len(means)} meshes, {sum(x > 1 for x in means)} of them further)")
    print(lines[-1])
    (out / "regular.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
