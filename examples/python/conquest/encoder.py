"""Arrays to a stream. SPDX-License-Identifier: MIT"""

from __future__ import annotations

from typing import Any, Callable, Literal, Mapping, Sequence, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import channels, names
from ._conquest import ffi, lib
from .errors import Error, raise_mesh_error

Progress = Callable[[int, int], object]
Goal = Literal["balanced", "least-connectivity"]
GOALS = {"balanced": lib.CQ_BALANCED, "least-connectivity": lib.CQ_LEAST_CONNECTIVITY}


class _Watch:
    """Hands progress on; what a callback raises is kept until the encoder has returned."""

    def __init__(self, call: Progress) -> None:
        self.call = call
        self.raised: BaseException | None = None

    def __call__(self, done: int, total: int) -> None:
        if self.raised is None:
            try:
                self.call(done, total)
            except BaseException as error:  # pylint: disable=broad-except
                self.raised = error


@ffi.def_extern()  # type: ignore[untyped-decorator]
def python_progress(user: Any, done: int, total: int) -> None:
    ffi.from_handle(user)(done, total)


class _Input:
    """A cq_input and the arrays that it points to."""

    def __init__(self, num_vertices: int, faces: NDArray[np.uint32], goal: str) -> None:
        self.input = ffi.new("cq_input *")
        self.faces = faces
        self.kept: list[Any] = []
        self.input.shape.num_vertices = num_vertices
        self.input.shape.num_faces = len(faces)
        self.input.indices = self.pointer("uint32_t[]", faces)
        self.input.goal = GOALS[goal]
        self.map = np.zeros(num_vertices, np.uint32)
        self.face_map = np.zeros(len(faces), np.uint32)
        self.input.map = self.pointer("uint32_t[]", self.map)
        self.input.face_map = self.pointer("uint32_t[]", self.face_map)

    def pointer(self, kind: str, array: channels.Array | bytes) -> Any:
        pointer = ffi.from_buffer(kind, array)
        self.kept.append(pointer)
        return pointer

    def add(self, name: str, kind: channels.Kind, array: ArrayLike, bits: int | None) -> None:
        shape = self.input.shape
        if shape.num_channels == lib.CQ_MAX_CHANNELS:
            raise ValueError(f"{name}: a stream has at most {lib.CQ_MAX_CHANNELS} attributes, positions included")
        count = shape.num_faces if kind.merge == lib.CQ_PER_FACE else shape.num_vertices
        rows = channels.as_rows(name, array, count, kind.components)
        channel = ffi.addressof(shape.channel, shape.num_channels)
        values = np.ascontiguousarray(channels.take(name, kind, channel, rows, bits))
        self.input.values[shape.num_channels] = self.pointer("int32_t[]", values)
        shape.num_channels += 1

    def add_materials(self, array: ArrayLike) -> bool:
        """As ranges of faces, if there are not too many: so many that all zeros come back, too."""
        rows = channels.as_rows("materials", array, self.input.shape.num_faces, (1,))
        if rows.dtype.kind not in "iu" or (rows.size and not 0 <= rows.min() <= rows.max() < lib.CQ_MAX_MATERIALS):
            return False
        self.input.shape.num_materials = max(2, int(rows.max()) + 1) if rows.size else 2
        self.input.materials = self.pointer("uint32_t[]", np.ascontiguousarray(rows, np.uint32))
        return True

    def add_metadata(self, metadata: bytes) -> None:
        if len(metadata) > lib.CQ_MAX_METADATA:
            raise ValueError(f"metadata: {len(metadata)} bytes, of at most {lib.CQ_MAX_METADATA}")
        self.input.shape.metadata_bytes = len(metadata)
        self.input.metadata = self.pointer("uint8_t[]", metadata)

    def watch(self, progress: Progress) -> _Watch:
        watch = _Watch(progress)
        handle = ffi.new_handle(watch)
        self.kept.append(handle)
        self.input.progress, self.input.user = lib.python_progress, handle
        return watch

    def encode(self) -> bytes:
        """Boundaries and rows are known after the first tries, the size of the stream after one that did not fit."""
        place, size = ffi.new("cq_place *"), ffi.new("size_t *")
        capacity = 4096 + 16 * self.input.shape.num_vertices + self.input.shape.metadata_bytes
        for _ in range(6):
            needed = lib.cq_encoder_bytes(ffi.addressof(self.input, "shape"))
            if needed == 0:
                raise Error(lib.CQ_ERROR_TOO_LARGE)
            memory, out = np.empty(needed // 8 * 9 // 8 + 1, np.uint64), np.empty(capacity, np.uint8)
            result = lib.python_encode(self.input, ffi.from_buffer(memory), memory.nbytes,
                                       ffi.from_buffer("uint8_t[]", out), capacity, size, place)
            if result == lib.CQ_ERROR_OUTPUT:
                capacity = size[0]
            elif result != lib.CQ_ERROR_MEMORY:
                break
        if result != lib.CQ_OK:
            raise_mesh_error(result, place)
        return out[:size[0]].tobytes()


def _bits_of(bits: int | Mapping[str, int], name: str) -> int | None:
    if isinstance(bits, Mapping):
        return bits.get(name)
    return bits if name == "positions" else None


def _as_faces(faces: ArrayLike) -> NDArray[np.uint32]:
    array = np.asarray(faces)
    if array.size == 0:
        array = np.zeros((0, 3), np.uint32)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise ValueError(f"faces: {array.dtype} of shape {array.shape}, expected integers (F, 3)")
    if array.size and (array.min() < 0 or array.max() >= 2 ** 32 - 1):
        raise ValueError("faces: a number that no vertex can have")
    return np.ascontiguousarray(array, np.uint32)


@overload
def encode(vertices: ArrayLike, faces: ArrayLike, *, bits: int | Mapping[str, int] = ..., goal: Goal = ...,
           clean: bool = ..., locked: ArrayLike | None = ..., progress: bool | Progress = ...,
           return_maps: Literal[False] = ..., metadata: bytes = ..., material_names: Sequence[str] = ...,
           **attributes: ArrayLike) -> bytes: ...


@overload
def encode(vertices: ArrayLike, faces: ArrayLike, *, bits: int | Mapping[str, int] = ..., goal: Goal = ...,
           clean: bool = ..., locked: ArrayLike | None = ..., progress: bool | Progress = ...,
           return_maps: Literal[True], metadata: bytes = ..., material_names: Sequence[str] = ...,
           **attributes: ArrayLike) -> tuple[bytes, NDArray[np.uint32], NDArray[np.uint32]]: ...


def encode(vertices: ArrayLike, faces: ArrayLike, *, bits: int | Mapping[str, int] = 12, goal: Goal = "balanced",
           clean: bool = True, locked: ArrayLike | None = None, progress: bool | Progress = False,
           return_maps: bool = False, metadata: bytes = b"", material_names: Sequence[str] = (),
           **attributes: ArrayLike) -> Any:
    """Encodes triangles, whatever they are.

    vertices     float (V, 3), finite, in any unit. Where a seam of normals, texture coordinates or colors runs, a place
                 has several of them, as in the vertex buffers of a GPU.
    faces        int (F, 3), 0 .. V - 1, counter-clockwise. What is no surface, as a face that names a vertex twice,
                 comes back, too.
    bits         of a coordinate: 1 .. 24, positions are rounded to a grid with 2^bits points along the longest side of
                 their box; 32, they come back as 32-bit floats. Or of several: {"positions": 14, "normals": 12}.
    goal         "balanced": features of the surface go last; "least-connectivity": collapses by valences alone.
    clean        True: a vertex never moves after it was decoded, at the cost of a larger base where there are seams.
    locked       bool (V,): vertices that are in all levels, as those on the border of a tile.
    progress     True: a bar, if it takes more than two seconds; or a function that is called with done and total.
    return_maps  also return the decoded number of each vertex, uint32 (V,), and of each face, uint32 (F,).
    metadata     bytes that come with the last bytes of the stream, at most 2^20.
    material_names  of number 0, 1, ... of materials; they go into the metadata, in place of others.
    attributes   normals, texcoords, colors, weights, joints, numbers, groups, materials, generic: conquest.channels.

    Returns the stream. Raises MeshError, with the place, if a face names no vertex or a number is not finite;
    ValueError and TypeError for arrays of other shapes and types. Warns of what is lost beyond rounding to `bits`
    (LossWarning): a grid that is coarser far from 0, or coarse for all because a few are far away; doubles with 32 bits.
    """
    if goal not in GOALS:
        raise ValueError(f"goal: {goal!r}, expected one of {', '.join(GOALS)}")
    rows = np.asarray(vertices)
    if rows.size == 0:
        rows = np.zeros((0, 3), np.float32)
    source = _Input(len(rows), _as_faces(faces), goal)
    source.add("positions", channels.POSITIONS, rows, _bits_of(bits, "positions"))
    for name, array in attributes.items():
        if name == "materials" and source.add_materials(array):
            continue
        source.add(name, channels.find_kind(name), array, _bits_of(bits, name))
    source.input.clean = clean
    if locked is not None:
        flags = channels.as_rows("locked", locked, len(rows), (1,)).astype(bool).astype(np.uint8)
        source.input.locked = source.pointer("uint8_t[]", flags)
    if metadata and material_names:
        raise ValueError("metadata or material_names, not both")
    source.add_metadata(metadata or names.write(material_names))
    stream = _watched(source, progress)
    return (stream, source.map, source.face_map) if return_maps else stream


def _watched(source: _Input, progress: bool | Progress) -> bytes:
    if callable(progress):
        watch = source.watch(progress)
        stream = source.encode()
        if watch.raised is not None:
            raise watch.raised
        return stream
    if not progress:
        return source.encode()
    from tqdm import tqdm  # type: ignore[import-untyped]

    with tqdm(desc="encoding", delay=2, unit=" steps") as bar:
        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        return _watched(source, show)
