"""What a channel of a stream is as an array, in both directions. SPDX-License-Identifier: MIT

An attribute is known by its name, which tells what its numbers mean:

    name       array                           in the stream                              default bits
    normals    float (V, 3), any length        octahedral pairs                           10
    texcoords  float (V, 2)                    a grid over their box                      12
    colors     uint8 or float 0..1 (V, 3|4)    multiples of 1 / (2^bits - 1)              8
    weights    float 0..1 (V, 1..4)            multiples of 1 / (2^bits - 1)              12
    joints     int (V, 1..4)                   as they are                                as many as they need
    numbers    int (V,)                        as they are                                as many as they need
    groups     int (V,)                        as they are                                as many as they need
    materials  int (F,), of faces              ranges of faces, if below 1024; else as they are
    generic    float or int (V, 1..4)          a grid over their box; ints as they are    12

A second one of a kind has the name of the first and "_1", a third "_2". With 32 bits floats come back bit for bit.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._conquest import ffi, lib
from .errors import raise_mesh_error, warn_of_loss

Array = NDArray[Any]
Values = NDArray[np.int32]


@dataclass(frozen=True)
class Kind:
    name: str
    kind: int
    merge: int
    components: tuple[int, ...]
    bits: int                     # of floats
    integers: bool = False        # numbers as they are
    unit: bool = False            # floats 0..1


ANY = (1, 2, 3, 4)
POSITIONS = Kind("positions", lib.CQ_POSITION, lib.CQ_AVERAGE, (3,), 12)
KINDS = {kind.name: kind for kind in (
    Kind("normals", lib.CQ_NORMAL, lib.CQ_AVERAGE, (3,), 10),
    Kind("texcoords", lib.CQ_TEXCOORD, lib.CQ_AVERAGE, (2,), 12),
    Kind("colors", lib.CQ_COLOR, lib.CQ_AVERAGE, (3, 4), 8, unit=True),
    Kind("weights", lib.CQ_WEIGHTS, lib.CQ_AVERAGE, ANY, 12, unit=True),
    Kind("joints", lib.CQ_JOINTS, lib.CQ_COPY, ANY, 0, integers=True),
    Kind("numbers", lib.CQ_NUMBER, lib.CQ_COPY, (1,), 0, integers=True),
    Kind("groups", lib.CQ_GROUP, lib.CQ_COPY, (1,), 0, integers=True),
    Kind("materials", lib.CQ_GROUP, lib.CQ_PER_FACE, (1,), 0, integers=True),
    Kind("generic", lib.CQ_GENERIC, lib.CQ_AVERAGE, ANY, 12),
)}
EXACT = int(lib.CQ_EXACT_BITS)


def first_of_kind(name: str) -> str:
    """"joints" for "joints_1"."""
    return re.sub(r"_[1-9]\d*$", "", name)


def find_kind(name: str) -> Kind:
    """The kind of an attribute; TypeError if there is none of that name."""
    kind = KINDS.get(first_of_kind(name))
    if kind is None:
        raise TypeError(f"no attribute {name!r}; there are {', '.join(KINDS)}")
    return kind


def float_bits(number: float) -> int:
    return int(np.float32(number).view(np.uint32))


def bits_float(bits: int) -> float:
    return float(np.uint32(bits).view(np.float32))


def floats(array: Array) -> Any:
    return ffi.from_buffer("float[]", array)


# -- To the stream --


def as_rows(name: str, array: ArrayLike, count: int, components: tuple[int, ...]) -> Array:
    """An array (count, components); ValueError if it has another shape."""
    rows = np.asarray(array)
    if rows.ndim == 1 and 1 in components:
        rows = rows[:, None]
    if rows.ndim != 2 or rows.shape[0] != count or rows.shape[1] not in components:
        raise ValueError(f"{name}: shape {np.shape(array)}, expected ({count}, {' or '.join(map(str, components))})")
    return rows


def quantise(name: str, channel: Any, rows: Array) -> Values:
    """Floats on the grid of the channel, or copied if it is exact."""
    single = np.ascontiguousarray(rows, np.float32)
    values = np.empty(single.shape, np.int32)
    place = ffi.new("cq_place *")
    result = lib.cq_quantise(channel, floats(single), len(single), ffi.from_buffer("int32_t[]", values), place)
    if result != lib.CQ_OK:
        raise_mesh_error(result, place, name)
    return values


def fit_grid(name: str, channel: Any, rows: Array) -> None:
    single = np.ascontiguousarray(rows, np.float32)
    place = ffi.new("cq_place *")
    result = lib.cq_fit_grid(channel, floats(single), len(single), place)
    if result != lib.CQ_OK:
        raise_mesh_error(result, place, name)


def take_doubles(channel: Any, rows: Array) -> Values | None:
    """Positions for which floats are too coarse, on a grid that is computed in doubles, with more bits for what its origin,
    a float, is below them; None if floats do."""
    if not len(rows) or not np.isfinite(rows).all():
        return None
    low = rows.min(axis=0)
    step = np.float32((rows.max(axis=0) - low).max() / (2 ** channel.bits - 1))
    if np.spacing(np.float32(np.abs(rows).max())) <= step or step == 0:
        return None
    origin = low.astype(np.float32)
    origin = np.where(origin > low, np.nextafter(origin, np.float32(-np.inf)), origin)
    reach = (rows.max(axis=0) - origin).max()
    step = np.nextafter(np.float32(max(float(step), reach / (2 ** lib.CQ_MAX_BITS - 1))), np.float32(np.inf))
    channel.step = float_bits(float(step))
    channel.bits = max(int(reach / np.float64(step) + 0.5).bit_length(), 1)
    for k, number in enumerate(origin):
        channel.origin[k] = float_bits(number)
    values: Values = np.rint((rows - origin) / np.float64(step)).astype(np.int32)
    return values


def grid_points(channel: Any, values: Values) -> Array:
    """What the values mean, in doubles."""
    origin = [bits_float(channel.origin[k]) for k in range(values.shape[1])]
    return np.float64(bits_float(channel.step)) * values + origin


def wanted_step(rows: Array, bits: int) -> float:
    return float(np.ptp(rows.astype(np.float64), axis=0).max()) / (2 ** bits - 1) if len(rows) else 0.0


def is_coarse(channel: Any, wanted: float, rows: Array, values: Values) -> bool:
    """Is the step of the grid so much longer than wanted that a number is further off?"""
    if bits_float(channel.step) <= 1.5 * wanted or not len(rows):
        return False
    return bool(np.abs(rows.astype(np.float64) - grid_points(channel, values)).max() > 0.53 * wanted)


def are_blurred(values: Values) -> bool:
    """A few far away make the step too long for all others: nine tenths are within a 32nd of the longest side."""
    if len(values) < 16:
        return False
    longest = values[:, np.ptp(values, axis=0).argmax()].astype(np.int64)
    side = int(np.ptp(longest))
    parts = np.bincount((longest - longest.min()) * 64 // (side + 1), minlength=65)
    return bool(side >= 256 and (parts[:-1] + parts[1:]).max() * 10 >= 9 * len(values))


def tell_grid(name: str, channel: Any, wanted: float, rows: Array, values: Values) -> None:
    """What rounding to `bits` does not let one expect."""
    step = bits_float(channel.step)
    if is_coarse(channel, wanted, rows, values):
        warn_of_loss(f"{name}: the step of the grid is {step:.3g} instead of {wanted:.3g}, as they are so far from 0")
    if are_blurred(values):
        warn_of_loss(f"{name}: a few are far from all others, so that all are rounded to multiples of {step:.3g} "
                     f"({channel.bits} bits)")


def tell_exact(name: str, rows: Array) -> None:
    """Exact means the nearest floats."""
    with np.errstate(all="ignore"):
        off = float(np.abs(rows - rows.astype(np.float32)).max()) if rows.size and rows.dtype == np.float64 else 0.0
    if off > 0:
        warn_of_loss(f"{name}: exact means the nearest 32-bit floats, up to {off:.3g} away")


def take_integers(name: str, channel: Any, rows: Array) -> Values:
    if rows.size and (rows.min() < 0 or rows.max() > 2 ** 32 - 1):
        raise ValueError(f"{name}: a number that is not 0 .. 2^32 - 1")
    needed = max(int(rows.max()).bit_length(), 1) if rows.size else 1
    channel.bits = needed if needed <= lib.CQ_MAX_BITS else EXACT
    channel.step = float_bits(1)
    return np.ascontiguousarray(rows.astype(np.uint32)).view(np.int32)


def take_normals(name: str, channel: Any, rows: Array) -> Values:
    single = np.ascontiguousarray(rows, np.float32)
    values = np.empty((len(single), 2), np.int32)
    place = ffi.new("cq_place *")
    channel.components = 2
    result = lib.cq_quantise_normals(channel.bits, floats(single), len(single),
                                     ffi.from_buffer("int32_t[]", values), place)
    if result != lib.CQ_OK:
        raise_mesh_error(result, place, name)
    return values


def take(name: str, kind: Kind, channel: Any, rows: Array, bits: int | None) -> Values:
    """Describes an array in a cq_channel; its values, int32 (count, components)."""
    is_integer = rows.dtype.kind in "iub"
    channel.kind, channel.merge, channel.components = kind.kind, kind.merge, rows.shape[1]
    channel.bits = kind.bits if bits is None else bits
    if kind.integers and not is_integer:
        raise TypeError(f"{name}: numbers have to be integers")
    if kind.integers or (is_integer and kind.kind == lib.CQ_GENERIC):
        channel.merge = lib.CQ_COPY if kind.merge == lib.CQ_AVERAGE else kind.merge
        return take_integers(name, channel, rows)
    if kind.unit and is_integer:
        rows = rows / np.float32(np.iinfo(rows.dtype).max)
    if channel.bits == EXACT:
        tell_exact(name, rows)
        return quantise(name, channel, rows)
    if not 1 <= channel.bits <= lib.CQ_MAX_BITS:
        raise ValueError(f"{name}: bits have to be 1 .. {lib.CQ_MAX_BITS} or {EXACT}")
    if kind.kind == lib.CQ_NORMAL:
        return take_normals(name, channel, rows)
    if kind.unit:
        channel.step = float_bits(1 / (2 ** channel.bits - 1))
        return quantise(name, channel, rows)
    return take_floats(name, kind, channel, rows, channel.bits)


def take_floats(name: str, kind: Kind, channel: Any, rows: Array, bits: int) -> Values:
    """On a grid over their box. Positions may be on one that is computed in doubles; floats only if they need it."""
    are_positions = kind.kind == lib.CQ_POSITION
    values = take_doubles(channel, rows) if are_positions and rows.dtype == np.float64 else None
    if values is None:
        fit_grid(name, channel, rows)
        values = quantise(name, channel, rows)
        if are_positions and is_coarse(channel, wanted_step(rows, bits), rows, values):
            in_doubles = take_doubles(channel, rows.astype(np.float64))
            values = values if in_doubles is None else in_doubles
    tell_grid(name, channel, wanted_step(rows, bits), rows, values)
    return values


# -- From the stream --


def name_channels(shape: Any) -> list[str]:
    """The names of all channels: the first of positions is "positions"."""
    names: list[str] = []
    for channel in shape.channel[0:shape.num_channels]:
        of_faces = channel.merge == lib.CQ_PER_FACE
        name = "positions" if channel.kind == lib.CQ_POSITION else "turned" if channel.kind == lib.CQ_TURNED else next(
            (k.name for k in KINDS.values() if k.kind == channel.kind
             and (k.kind != lib.CQ_GROUP or (k.merge == lib.CQ_PER_FACE) == of_faces)), "generic")
        earlier = sum(re.fullmatch(rf"{name}(_\d+)?", other) is not None for other in names)
        names.append(f"{name}_{earlier}" if earlier else name)
    return names


def are_doubles(channel: Any) -> bool:
    """Are floats too coarse for this grid?"""
    if channel.kind != lib.CQ_POSITION or channel.bits == EXACT:
        return False
    step = bits_float(channel.step)
    ends = [abs(bits_float(channel.origin[k])) + step * 2 ** channel.bits for k in range(channel.components)]
    return bool(np.isfinite(step) and np.isfinite(ends).all() and max(ends) < float(np.finfo(np.float32).max)
                and np.spacing(np.float32(max(ends))) > 2 * step > 0)


def are_integers(channel: Any) -> bool:
    """Are the values themselves what a reader wants?"""
    whole = channel.step == float_bits(1) and not any(channel.origin)
    return bool(channel.kind in (lib.CQ_JOINTS, lib.CQ_NUMBER, lib.CQ_GROUP)
                or (channel.kind == lib.CQ_GENERIC and channel.merge != lib.CQ_AVERAGE and whole))


def is_bytes(channel: Any) -> bool:
    return bool(channel.kind == lib.CQ_COLOR and channel.bits == 8 and channel.step == float_bits(1 / 255)
                and not any(channel.origin))


def make_array(channel: Any, count: int) -> Array:
    """An array of the type and shape that give_rows fills."""
    dtype: Any = (np.uint32 if are_integers(channel) else np.uint8 if is_bytes(channel)
                  else np.float64 if are_doubles(channel) else np.float32)
    components = 3 if channel.kind == lib.CQ_NORMAL else channel.components
    return np.empty((count, components) if components > 1 else (count,), dtype)


def give_rows(channel: Any, values: Values, to: Array) -> None:
    """Writes what the values, int32 (count, components), mean to an array of make_array."""
    if are_integers(channel):
        to[...] = values.view(np.uint32).reshape(to.shape)
    elif is_bytes(channel):
        to[...] = values
    elif are_doubles(channel):
        to[...] = [bits_float(channel.origin[k]) for k in range(3)] + np.float64(bits_float(channel.step)) * values
    elif channel.kind == lib.CQ_NORMAL and channel.components == 2:
        lib.cq_reconstruct_normals(channel.bits, ffi.from_buffer("int32_t[]", values), len(values), floats(to))
    else:
        lib.cq_reconstruct(ffi.addressof(channel), ffi.from_buffer("int32_t[]", values), len(values), floats(to))
