#!/usr/bin/env python3
"""Writes the tables of figures into README.   SPDX-License-Identifier: MIT

    readme.py README.md figures.tsv budgets.tsv

The text between the lines `<!-- figures begin -->` and `<!-- figures end -->` is replaced.
"""
import sys

DEVICES = [("cortex-m3", "Cortex-M3"), ("cortex-m0", "Cortex-M0"), ("rv32", "RV32IMC")]
WIDTHS = [("32-bit", "32-bit indices"), ("16-bit", "16-bit indices")]
DEVICE_ROWS = [
    ("code", "decoder, code and tables, bytes"),
    ("writable", "its .data and .bss, bytes"),
    ("stack", "its stack, bytes: bound from the call graph"),
    ("painted", "its stack, bytes: measured by painting"),
    ("sizeof", "`sizeof(cq_decoder)`"),
    ("ram", "RAM in all: static data and stack, bytes"),
    ("split", "instructions per split, all of decoding included"),
    ("longest", "instructions of the longest step"),
]
WIDTH_ROWS = [
    ("sizeof", "`sizeof(cq_decoder)`: models, one patch, input that waits"),
    ("decoder", "decoder, bytes per vertex, positions included"),
    ("connectivity", "decoder, bytes per vertex, connectivity alone"),
    ("encoder", "encoder, bytes per vertex"),
]


def read(path):
    with open(path, encoding="utf-8") as file:
        return dict(line.split() for line in file if line.strip() and not line.startswith("#"))


def table(heading, columns, rows, figures, budgets):
    names = [name for _, name in columns]
    lines = [f"| {heading} | " + " | ".join(names) + " | budget |", "| --- |" + " ---: |" * (len(columns) + 1)]
    for row, text in rows:
        cells = [figures[f"{row}.{key}"] for key, _ in columns]
        limits = [(budgets.get(f"{row}.{key}"), name) for key, name in columns]
        limits = [(limit, name) for limit, name in limits if limit is not None]
        same = len({limit for limit, _ in limits}) == 1 and len(limits) == len(columns)
        budget = limits[0][0] if same else ", ".join(f"{limit} ({name})" for limit, name in limits)
        lines.append(f"| {text} | " + " | ".join(cells) + f" | {budget} |")
    return lines


def main():
    readme, figures, budgets = sys.argv[1], read(sys.argv[2]), read(sys.argv[3])
    lines = table("", WIDTHS, WIDTH_ROWS, figures, budgets) + [""]
    lines += table("", DEVICES, DEVICE_ROWS, figures, budgets)
    with open(readme, encoding="utf-8") as file:
        text = file.read()
    begin, end = "<!-- figures begin -->\n", "<!-- figures end -->"
    before, rest = text.split(begin)
    after = rest.split(end)[1]
    with open(readme, "w", encoding="utf-8") as file:
        file.write(before + begin + "\n".join(lines) + "\n" + end + after)


if __name__ == "__main__":
    main()
