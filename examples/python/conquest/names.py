"""Names of materials as metadata, in the words of OBJ files, as cqm writes them. SPDX-License-Identifier: MIT"""

from __future__ import annotations

from typing import Sequence

WORD = b"usemtl"


def write(names: Sequence[str]) -> bytes:
    """A line for each name; ValueError for one that would be two lines."""
    for name in names:
        if "\n" in name:
            raise ValueError(f"material_names: {name!r} has more than one line")
    return b"".join(WORD + (b" " + name.encode() if name else b"") + b"\n" for name in names)


def read(metadata: bytes) -> list[str]:
    """The names, whatever else the metadata has."""
    lines = (line.split(b" ", 1) for line in metadata.split(b"\n"))
    return [words[1].decode(errors="replace") if len(words) > 1 else "" for words in lines if words[0] == WORD]
