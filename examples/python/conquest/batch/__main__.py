"""python -m conquest.batch IN_DIR OUT_DIR. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tqdm import tqdm  # type: ignore[import-untyped]

from ..encoder import GOALS
from . import page
from .run import find_files, run
from .task import Options


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m conquest.batch", description="Encodes the mesh files of a tree. What is unchanged since the last "
        "run stays as it is. Exit status: 0 all files are encoded, 1 some are not, 2 bad usage or no mesh file.")
    parser.add_argument("source", metavar="IN_DIR", type=Path)
    parser.add_argument("target", metavar="OUT_DIR", type=Path)
    parser.add_argument("--bits", metavar="N", type=int, choices=[*range(1, 25), 32], default=12,
                        help="of a coordinate: 1 .. 24, or 32: as floats (%(default)s)")
    parser.add_argument("--goal", choices=GOALS, default="balanced", help="of collapses (%(default)s)")
    parser.add_argument("--table", choices=page.WRITERS, default="csv", help="format of the table (%(default)s)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--scheduler", metavar="ADDRESS", help="of dask, as tcp://10.0.0.1:8786: its workers encode")
    where.add_argument("--workers", metavar="N", type=int, help="processes on this machine (as many as it has cores)")
    return parser.parse_args()


def main() -> int:
    arguments = parse()
    files, others = find_files(arguments.source, arguments.target)
    if others:
        print("not read:", ", ".join(f"{count} {suffix}" for suffix, count in sorted(others.items())))
    if not files:
        print(f"{arguments.source}: no mesh files", file=sys.stderr)
        return 2
    rows = run(arguments.source, arguments.target, options=Options(arguments.bits, arguments.goal),
               table=arguments.table, scheduler=arguments.scheduler, workers=arguments.workers,
               progress=lambda rows, total: tqdm(rows, total=total, unit=" files", disable=None))
    failed = [row for row in rows if row.error]
    for row in failed:
        print(f"{row.file}: {row.error}", file=sys.stderr)
    print(f"{len(rows) - len(failed)} encoded, {len(failed)} not: {arguments.target / 'index.html'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
