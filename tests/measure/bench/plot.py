#!/usr/bin/env python3
"""Plots what the bench measured.   SPDX-License-Identifier: MIT

    plot.py results.csv results.png
"""
import csv
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

PANELS = [
    ("bits_per_vertex", "bits per vertex", "linear"),
    ("decode_mvertices_per_second", "decode, million vertices per second", "log"),
    ("decode_bytes_per_vertex", "memory while decoding, bytes per vertex", "linear"),
    ("encode_mvertices_per_second", "encode, million vertices per second", "log"),
]


def names(rows, column):
    return list(dict.fromkeys(row[column] for row in rows))


def draw(axes, rows, column, title, scale):
    meshes, codecs = names(rows, "mesh"), names(rows, "codec")
    values = {(row["mesh"], row["codec"]): float(row[column]) for row in rows}
    width = 0.85 / len(codecs)
    for k, codec in enumerate(codecs):
        at = [(i + (k - (len(codecs) - 1) / 2) * width, values[mesh, codec])
              for i, mesh in enumerate(meshes) if (mesh, codec) in values]
        axes.bar([x for x, _ in at], [y for _, y in at], width, label=codec)
    axes.set_title(title)
    axes.set_yscale(scale)
    axes.set_xticks(range(len(meshes)), meshes, rotation=20, ha="right")
    axes.grid(axis="y", alpha=0.4)
    axes.set_axisbelow(True)


def main():
    with open(sys.argv[1], encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    figure, axes = plt.subplots(2, 2, figsize=(15, 9))
    for panel, (column, title, scale) in zip(axes.flat, PANELS):
        draw(panel, rows, column, title, scale)
    axes.flat[0].legend()
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=100)


if __name__ == "__main__":
    main()
