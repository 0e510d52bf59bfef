"""All files of a tree, by dask's distributed scheduler: on this machine, or on a cluster. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import time
import uuid
from collections import Counter
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator

import dask  # type: ignore[import-untyped, import-not-found, unused-ignore]
import distributed as untyped  # type: ignore[import-untyped, import-not-found, unused-ignore]

from . import page, read
from .task import Options, Row, Task, encode_file, write

distributed: Any = untyped
DAY = 24 * 60 * 60


def find_files(directory: Path, without: Path) -> tuple[list[str], Counter[str]]:
    """Names of the files that a reader knows, and how many others there are, by suffix; hidden ones and those in another
    directory do not count."""
    names = [path.relative_to(directory) for path in sorted(directory.rglob("*"))
             if path.is_file() and (without == directory or without.resolve() not in path.resolve().parents)]
    shown = [name for name in names if not any(part.startswith(".") for part in name.parts)]
    others = Counter(name.suffix or name.name for name in shown if name.suffix.lower() not in read.SUFFIXES)
    return [name.as_posix() for name in shown if name.suffix.lower() in read.SUFFIXES], others


def connect(scheduler: str | None, workers: int | None) -> Any:
    """A client of a scheduler somewhere, or of one with processes on this machine, as many as it has cores."""
    if scheduler is not None:
        return distributed.Client(scheduler)
    dask.config.set({"distributed.scheduler.no-workers-timeout": "5 minutes"})     # all died while they started: an error
    return distributed.Client(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None)


def run(source: Path, target: Path, *, options: Options = Options(), table: str = "csv", scheduler: str | None = None,
        workers: int | None = None, progress: Callable[[Iterable[Row], int], Iterable[Row]] = lambda rows, _: rows,
        ) -> list[Row]:
    """Encodes what is below source to target, writes the table and the page, returns the rows.

    scheduler  address of a scheduler of dask; None: processes on this machine.
    workers    how many of these; None: as many as there are cores.
    progress   is handed the rows as they come, and how many there will be; returns them.
    """
    name, (files, _) = uuid.uuid4().hex, find_files(source, target)
    tasks = [Task(str(source.resolve() / file), str(target.resolve() / file), file, options, name) for file in files]
    with connect(scheduler, workers) as client:
        rows = sorted(progress(_encode_all(client, tasks), len(tasks)), key=lambda row: row.file)
    write(target / f"table.{table}", page.make_table(rows, table), name)
    write(target / "index.html", page.make_page(rows, source.resolve().name), name)
    _sweep(target, name)
    return rows


def _encode_all(client: Any, tasks: list[Task]) -> Iterator[Row]:
    """Rows in the order in which they get done. The scheduler gives what a worker had that died to the others. Of tasks
    that were there when several died, one may be the reason: each is tried again while no other runs."""
    suspects = []
    futures = {client.submit(encode_file, task, key=f"encode-{task.run}-{k}"): task for k, task in enumerate(tasks)}
    for future in distributed.as_completed(list(futures)):
        row, task = _row_of(future), futures.pop(future)      # which lets workers forget it
        if row is None:
            suspects.append(task)
        else:
            yield row
    for k, task in enumerate(suspects):
        row = _row_of(client.submit(encode_file, task, key=f"alone-{task.run}-{k}"))
        yield row or Row(task.name, error="the workers that encoded it died")


def _row_of(future: Any) -> Row | None:
    """None: the scheduler has given up, since workers died of it."""
    try:
        row: Row = future.result()
        return row
    except distributed.KilledWorker:
        return None


def _sweep(target: Path, name: str) -> None:
    """Removes what workers that died have left half-written in this run, or one that ended days ago."""
    for part in target.rglob(".*.part"):
        if f".{name}." in part.name or time.time() - part.stat().st_mtime > DAY:
            part.unlink(missing_ok=True)
