#!/usr/bin/env python3
"""Writes the tables of figures into README.   SPDX-License-Identifier: MIT

    readme.py README.md figures.tsv budgets.tsv [results.csv]

Replaces the text between the lines `<!-- figures begin -->` and `<!-- figures end -->`; with the results of the bench
also that between `<!-- bench begin -->` and `<!-- bench end -->`.
"""
import csv
import sys

DEVICES = [("cortex-m3", "Cortex-M3"), ("cortex-m0", "Cortex-M0"), ("rv32", "RV32IMC")]
CODECS = "conquest", "draco-10", "meshopt+zstd"
WIDTHS = [("32-bit", "32-bit indices"), ("16-bit", "16-bit indices")]
CODE_DEVICES = DEVICES + [("avr", "AVR")]
CODE_ROWS = [
    ("code-all", "code, bytes: all that streams may have"),
    ("code", "code, bytes: positions alone, no regular levels, no seams"),
    ("tables-all", "constant tables, bytes: all that streams may have"),
    ("tables", "constant tables, bytes: positions alone, no regular levels, no seams"),
]
DEVICE_ROWS = [
    ("writable", "decoder, .data and .bss, bytes"),
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
    ("most", "encoder of any triangles, two per row, at most, bytes per row"),
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


def tables(figures, budgets):
    lines = table("", WIDTHS, WIDTH_ROWS, figures, budgets) + [""]
    lines += table("decoder", CODE_DEVICES, CODE_ROWS, figures, budgets) + [""]
    return lines + table("without regular levels and seams", DEVICES, DEVICE_ROWS, figures, budgets)


def bench_table(path):
    """A line for each mesh, a number for each of CODECS."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = {(row["mesh"], row["codec"]): row for row in csv.DictReader(file)}
    columns = [("bits_per_vertex", "bits per vertex", 1), ("decode_mvertices_per_second", "decode, Mvertices/s", 2),
               ("decode_bytes_per_vertex", "decoding, bytes per vertex", 0),
               ("encode_mvertices_per_second", "encode, Mvertices/s", 2)]
    lines = ["| mesh | vertices | " + " | ".join(title for _, title, _ in columns) + " | first 1 % after |",
             "| --- | ---: |" + " ---: |" * (len(columns) + 1)]
    for mesh in dict.fromkeys(mesh for mesh, _ in rows):
        ours = rows[mesh, CODECS[0]]
        cells = [" / ".join(f"{float(rows[mesh, codec][key]):.{digits}f}" for codec in CODECS)
                 for key, _, digits in columns]
        first = 100 * float(ours["first_percent_seconds"]) / float(ours["decode_seconds"])
        lines.append(f"| {mesh} | {ours['vertices']} | " + " | ".join(cells) + f" | {first:.1f} % |")
    return lines


def replace(text, name, lines):
    begin, end = f"<!-- {name} begin -->\n", f"<!-- {name} end -->"
    before, rest = text.split(begin)
    after = rest.split(end)[1]
    return before + begin + "\n".join(lines) + "\n" + end + after


def main():
    readme, figures, budgets = sys.argv[1], read(sys.argv[2]), read(sys.argv[3])
    with open(readme, encoding="utf-8") as file:
        text = replace(file.read(), "figures", tables(figures, budgets))
    if len(sys.argv) > 4:
        text = replace(text, "bench", bench_table(sys.argv[4]))
    with open(readme, "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    main()
