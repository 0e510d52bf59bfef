"""One file, as a worker encodes it. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import uuid
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import conquest

from . import picture, read

PROGRAM = Path(conquest.__file__).parent / ("cqm.exe" if os.name == "nt" else "cqm")


@dataclass(frozen=True)
class Options:
    """What changes the bytes of a stream: a file is encoded again if one of these is another one."""

    bits: int = 12
    goal: conquest.encoder.Goal = "balanced"
    version: str = conquest.__version__


@dataclass(frozen=True)
class Task:
    source: str                       # the file
    target: str                       # the stream, without ".cqm"
    name: str                         # of the file, below the directory that was asked for
    options: Options
    run: str                          # marks temporary files


@dataclass(frozen=True)
class Row:
    """A line of the table. Without an error all is known; with one at most the first three are."""

    file: str
    sha256: str = ""
    file_bytes: int | None = None
    vertices: int | None = None
    faces: int | None = None
    bytes: int | None = None
    ratio: float | None = None        # bytes of the file for a byte of the stream
    set_aside: int | None = None      # faces that are no part of a surface; they come with the last bytes
    told: str = ""                    # what was dropped or changed
    error: str = ""


def encode_file(task: Task) -> Row:
    """Encodes a file, unless that was done; whatever is wrong with it is in the row."""
    row = Row(task.name)
    try:
        source = Path(task.source)
        data = source.read_bytes()
        digest = hashlib.sha256(data)
        for other in read.companions(source):
            digest.update(other.read_bytes())
        row = Row(task.name, digest.hexdigest(), len(data))
        return _find_done(task, row) or _encode(task, row)
    except Exception as error:  # pylint: disable=broad-except
        for suffix in (".json", ".cqm", ".png"):
            Path(task.target + suffix).unlink(missing_ok=True)
        message = " ".join(str(error).split())
        return Row(task.name, row.sha256, row.file_bytes, error=message or type(error).__name__)


# -- Output: the record is written last, and tells what the others are --


def write(path: Path, data: bytes, run: str) -> None:
    """Writes a file that is complete or absent."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{run}.{uuid.uuid4().hex}.part")
    try:
        part.write_bytes(data)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def _find_done(task: Task, row: Row) -> Row | None:
    """The row of an earlier run, if the file and the options are the same and the stream is still there."""
    try:
        record = json.loads(Path(task.target + ".json").read_bytes())
        stream = hashlib.sha256(Path(task.target + ".cqm").read_bytes()).hexdigest()
        known = Row(**{"told": None, **record["row"]})
        same = (known.sha256, record["options"], record["stream"]) == (row.sha256, asdict(task.options), stream)
        return known if same and known.file == row.file and known.told is not None else None
    except (OSError, ValueError, TypeError, LookupError):
        return None


def _encode(task: Task, row: Row) -> Row:
    stream, told = _make_stream(Path(task.source), task.options)
    seen = picture.look(stream)
    done = Row(task.name, row.sha256, row.file_bytes, seen.vertices, seen.faces, len(stream),
               round((row.file_bytes or 0) / len(stream), 3), seen.set_aside, told)
    write(Path(task.target + ".cqm"), stream, task.run)
    write(Path(task.target + ".png"), seen.png, task.run)
    record = {"row": asdict(done), "options": asdict(task.options), "stream": hashlib.sha256(stream).hexdigest()}
    write(Path(task.target + ".json"), json.dumps(record, indent=1).encode(), task.run)
    return done


def _make_stream(source: Path, options: Options) -> tuple[bytes, str]:
    """And what was dropped or changed."""
    if source.suffix.lower() not in read.CQM:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", conquest.LossWarning)
            arguments: Any = read.read(source)
            stream: bytes = conquest.encode(**arguments, bits=options.bits, goal=options.goal)
        return stream, "; ".join(str(warning.message) for warning in said
                                 if issubclass(warning.category, conquest.LossWarning))
    command = [str(PROGRAM), "encode", "--clean", "--bits", str(options.bits), "--goal", options.goal,
               "--format", source.suffix.lower()[1:], "--", str(source), "-"]
    done = subprocess.run(command, capture_output=True, check=False)
    lines = done.stderr.decode(errors="replace").replace(f"cqm: {source}: ", "").splitlines()
    if done.returncode:
        raise ValueError(lines[-1] if lines else f"cqm: status {done.returncode}")
    return done.stdout, "; ".join(line for line in lines if line.startswith(("dropped: ", "changed: ")))
