"""Errors of the codec, with their place. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import os
import sys
import warnings
from typing import Any, NoReturn

from ._conquest import ffi, lib

NAMES = {getattr(lib, name): name for name in dir(lib) if name.startswith("CQ_ERROR_") or name == "CQ_TRUNCATED"}
MESH_ERRORS = {lib.CQ_ERROR_INDEX, lib.CQ_ERROR_FACE, lib.CQ_ERROR_EDGE, lib.CQ_ERROR_ORIENTATION,
               lib.CQ_ERROR_VERTEX, lib.CQ_ERROR_UNUSED}


class Error(Exception):
    """Base of all errors of the codec.

    code: name of the result in conquest.h, as "CQ_ERROR_EDGE".
    """

    def __init__(self, result: int, message: str = "") -> None:
        self.code = NAMES.get(result, str(result))
        super().__init__(message or describe(result))


class MeshError(Error, ValueError):
    """The mesh cannot be encoded. face, vertex, other: numbers of the input where that is, or None; an edge runs from
    vertex to other."""

    def __init__(self, result: int, face: int | None, vertex: int | None, other: int | None, name: str = "") -> None:
        self.face, self.vertex, self.other = face, vertex, other
        words = [f"{word} {number}" for word, number in (("face", face), ("vertex", vertex), ("to vertex", other))
                 if number is not None]
        super().__init__(result, ": ".join(part for part in (name, describe(result), ", ".join(words)) if part))


class StreamError(Error, ValueError):
    """The bytes are no good stream. offset: how many had been used when that was found."""

    def __init__(self, result: int, offset: int) -> None:
        self.offset = offset
        super().__init__(result, f"{describe(result)} (byte {offset})")


class TruncatedError(StreamError):
    """The stream ended early: what it holds is a coarser mesh."""


class LossWarning(UserWarning):
    """Part of what was handed in is dropped, or changed by more than rounding to `bits`. warnings.simplefilter("error",
    LossWarning) makes it an error."""


def warn_of_loss(message: str) -> None:
    """As if the caller of this package had said it."""
    package = os.path.dirname(__file__)
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == package:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, LossWarning, stacklevel=level)


def describe(result: int) -> str:
    return str(ffi.string(lib.cq_result_string(result)).decode())


def raise_mesh_error(result: int, place: Any, name: str = "") -> NoReturn:
    """Raises what cq_encode or a function of the quantiser has returned."""
    if result == lib.CQ_ERROR_MEMORY:
        raise MemoryError(describe(result))
    face, vertex, other = (None if number == lib.CQ_NONE else number
                           for number in (place.face, place.vertex, place.other))
    if result in MESH_ERRORS or result == lib.CQ_ERROR_VALUE:
        raise MeshError(result, face, vertex, other, name)
    raise Error(result)


def raise_stream_error(result: int, offset: int) -> NoReturn:
    """Raises what cq_peek or cq_decode has returned."""
    if result == lib.CQ_TRUNCATED:
        raise TruncatedError(result, offset)
    raise StreamError(result, offset)
