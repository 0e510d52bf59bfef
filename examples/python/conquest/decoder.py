"""A stream, or the start of one, to arrays. SPDX-License-Identifier: MIT"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from . import channels, names
from ._conquest import ffi, lib
from .errors import StreamError, TruncatedError, raise_stream_error

Buffer = Union[bytes, bytearray, memoryview]
MAX_MEMORY = 1 << 32


def _address(pointer: Any) -> int:
    return int(ffi.cast("uintptr_t", pointer))


@dataclass
class Mesh:
    """A decoded mesh.

    vertices    float32 (V, 3); float64 where floats are too coarse for the grid.
    faces       uint32 (F, 3), counter-clockwise.
    attributes  by name, arrays (V, ...) or, for materials, (F,): conquest.channels says which.
    complete    is it all of what was encoded?
    error       how far the vertices of the exact mesh are from this one at most, in the unit of the vertices; 0 if
                complete, None if the stream does not tell.
    metadata    bytes that came with the mesh; b"" if there are none or it is not complete.
    """

    vertices: NDArray[Any]
    faces: NDArray[np.uint32]
    attributes: dict[str, NDArray[Any]] = field(default_factory=dict)
    complete: bool = True
    error: float | None = 0.0
    metadata: bytes = b""

    @property
    def material_names(self) -> list[str]:
        """Of number 0, 1, ... of materials, as far as the metadata has them."""
        return names.read(self.metadata)


class Decoder:
    """Decodes bytes as they arrive.

        decoder = Decoder()
        for piece in pieces:
            decoder.feed(piece)
            draw(decoder.vertices, decoder.faces)
        decoder.finish()

    Vertices never change once they are there (with encode's clean=False, those at seams may move), so their arrays
    only grow at the end: what was decoded is computed once, and an array that was taken before stays right. Faces do
    change: `faces` is a view of the decoder's own memory, to be copied if it has to stay as it is. All arrays are
    read-only.

    max_memory  bytes that a header may ask for; more is a MemoryError.
    """

    def __init__(self, max_memory: int = MAX_MEMORY) -> None:
        self._decoder = ffi.new("cq_decoder *")
        self._max_memory = max_memory
        self._waiting = b""                    # bytes that are not decoded yet: a header in parts, or steps were spent
        self._memory: NDArray[np.uint32] | None = None
        self._names: list[str] = []
        self._arrays: list[NDArray[Any]] = []  # of the channels, as readers want them, with room for the full mesh
        self._filled: list[tuple[int, int]] = []   # how much of them is there, and mesh vertices when that came
        self._result = int(lib.CQ_NEED_INPUT)
        self._used = 0

    # -- Input --

    def feed(self, piece: Buffer = b"", steps: int | None = None) -> bool:
        """Decodes the next piece of the stream.

        steps  at most so many; a step is a split or something as small, some microseconds. None: all that can be done.

        Returns True if more can be decoded without another piece: steps were spent, feed(steps=...) goes on. Bytes
        behind the end of the stream are not used. Raises StreamError, then and at each later call; the mesh that was
        there before stays.
        """
        self._raise_again()
        data: Buffer = piece
        if self._waiting or self._memory is None:
            data, self._waiting = self._waiting + bytes(memoryview(piece).cast("B")), b""
        if self._memory is None and not self._begin(data):
            self._waiting = bytes(data)
            return False
        rest = self._decode(data, lib.CQ_NO_LIMIT if steps is None else steps)
        if self._result == lib.CQ_MORE:
            self._waiting = rest
        return self._result == int(lib.CQ_MORE)

    def finish(self) -> None:
        """Says that no more input will come. Raises TruncatedError if the stream has not ended: the mesh is a coarser
        one, with all that its bytes tell."""
        self.feed()
        if self._memory is None:
            self._result, self._used = int(lib.CQ_TRUNCATED), len(self._waiting)
        elif not self.complete:
            self._result = int(lib.cq_decode(self._decoder, ffi.NULL, lib.CQ_NO_LIMIT))
        self._raise_again()

    def _raise_again(self) -> None:
        if self._result < 0 or self._result == lib.CQ_TRUNCATED:
            raise_stream_error(self._result, self._used)

    def _begin(self, data: Buffer) -> bool:
        """Reads the header and gets memory, once there are enough bytes for that."""
        shape = ffi.new("cq_shape *")
        self._result = int(lib.cq_peek(ffi.from_buffer("uint8_t[]", data), len(data), shape, ffi.NULL, ffi.NULL))
        self._raise_again()
        if self._result == lib.CQ_NEED_INPUT:
            return False
        size = lib.cq_decoder_bytes(shape)
        if size == 0 or size > self._max_memory:
            raise MemoryError(f"the stream asks for {size or 'too many'} bytes, of {self._max_memory} that it may have")
        self._memory = np.empty(size // 4 + 1, np.uint32)
        lib.cq_decoder_init(self._decoder, ffi.from_buffer(self._memory), self._memory.nbytes)
        self._names = channels.name_channels(shape)
        if shape.num_materials:                # the ranges have this name
            self._names = [name.replace("materials", "materials_of_faces") for name in self._names]
        self._arrays = [channels.make_array(channel, self._room(shape, channel)) for channel in self._channels(shape)]
        self._filled = [(0, 0)] * len(self._names)
        return True

    def _decode(self, data: Buffer, steps: int) -> bytes:
        """Decodes; returns the bytes that are left. Afterwards the shape in the decoder is known."""
        pointer = ffi.from_buffer("uint8_t[]", data)
        piece = ffi.new("cq_bytes *", (pointer, len(pointer)))
        self._result = int(lib.cq_decode(self._decoder, piece, steps))
        self._used += len(pointer) - piece.size
        self._raise_again()
        return bytes(ffi.buffer(piece.data, piece.size)) if piece.size else b""

    # -- The mesh of this moment --

    @staticmethod
    def _channels(shape: Any) -> list[Any]:
        return [shape.channel[k] for k in range(shape.num_channels)]

    @staticmethod
    def _room(shape: Any, channel: Any) -> int:
        """Rows or faces of the full mesh, with those aside."""
        if channel.merge == lib.CQ_PER_FACE:
            return int(shape.num_faces + shape.num_aside_faces)
        return int((shape.num_rows or shape.num_vertices) + shape.num_aside_rows)

    def _view(self, pointer: Any, count: int, components: int) -> NDArray[np.uint32]:
        """Part of the decoder's memory, which it keeps alive."""
        if self._memory is None or count == 0:
            view = np.empty((0, components), np.uint32)
        else:
            begin = (_address(pointer) - _address(ffi.from_buffer(self._memory))) // 4
            view = self._memory[begin:begin + count * components].reshape(count, components)
        view.flags.writeable = False
        return view

    def _array(self, k: int) -> NDArray[Any]:
        """Channel k: what has come since the last call is computed."""
        d = self._decoder
        channel = d.shape.channel[k]
        of_faces = channel.merge == lib.CQ_PER_FACE
        count = self._num_faces if of_faces else self._num_rows
        (done, vertices), array = self._filled[k], self._arrays[k]
        numbers = self._face_numbers
        if of_faces and numbers is not None:
            values = self._view(d.channel[k], int(d.mesh.num_faces), channel.components).view(np.int32)
            channels.give_rows(channel, values[numbers], array[:count])
            done = count
        if not of_faces and d.vertex != ffi.NULL and done:
            for row in self._moved_rows(vertices, done):
                self._give(k, array, row, row + 1)
        self._give(k, array, min(done, count), count)
        self._filled[k] = max(done, count), int(d.mesh.num_vertices)
        if self.complete:
            count = self._add_aside(k, array, count)
        view = array[:count]
        view.flags.writeable = False
        return view

    @property
    def material_ranges(self) -> list[tuple[int, int]]:
        """Of each material, number of its first face in the full mesh, and how many are there: one range at any moment.
        [] if the stream has no materials."""
        ranges, number = [], ffi.new("uint32_t[2]")
        for m in range(self._decoder.shape.num_materials if self._memory is not None else 0):
            lib.cq_material(self._decoder, m, number, number + 1)
            ranges.append((int(number[0]), int(number[1])))
        return ranges

    @property
    def _face_numbers(self) -> NDArray[np.int64] | None:
        """Of the faces that are there, if these are not all from 0 on."""
        if not self._decoder.shape.num_materials or self.complete:
            return None
        return np.concatenate([np.arange(first, first + count) for first, count in self.material_ranges])

    @property
    def _num_faces(self) -> int:
        ranges = self.material_ranges
        return sum(count for _, count in ranges) if ranges else int(self._decoder.mesh.num_faces)

    def _materials(self) -> NDArray[np.int32]:
        counts = [count for _, count in self.material_ranges]
        result = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        aside = self._decoder.aside
        if self.complete and aside.num_faces:
            more = self._view(aside.material, int(aside.num_faces), 1).view(np.int32)[:, 0]
            result = np.concatenate([result, more])
        result.flags.writeable = False
        return result

    @property
    def _num_rows(self) -> int:
        d = self._decoder
        return int(d.num_rows if d.vertex != ffi.NULL else d.mesh.num_vertices)

    def _moved_rows(self, vertices: int, rows: int) -> list[int]:
        """Rows that have moved since there were so many mesh vertices and rows."""
        marks = np.zeros(self._num_rows, np.uint8)
        lib.cq_moved_rows(self._decoder, vertices, rows, 0, ffi.from_buffer("uint8_t[]", marks))
        return [int(row) for row in np.flatnonzero(marks)]

    def _give(self, k: int, array: NDArray[Any], begin: int, end: int) -> None:
        """Computes part of an array."""
        d = self._decoder
        channel = d.shape.channel[k]
        if begin == end:
            return
        if channel.merge == lib.CQ_PER_FACE or d.vertex == ffi.NULL:
            values = self._view(d.channel[k], end, channel.components).view(np.int32)[begin:]
        else:
            values = np.empty((end - begin, channel.components), np.int32)
            lib.cq_read_rows(d, k, begin, end - begin, ffi.from_buffer("int32_t[]", values))
        channels.give_rows(channel, values, array[begin:end])

    def _add_aside(self, k: int, array: NDArray[Any], count: int) -> int:
        aside, channel = self._decoder.aside, self._decoder.shape.channel[k]
        more = int(aside.num_faces if channel.merge == lib.CQ_PER_FACE else aside.num_rows)
        if more and channel.kind != lib.CQ_TURNED:
            values = self._view(aside.channel[k], more, channel.components).view(np.int32)
            channels.give_rows(channel, values, array[count:count + more])
        return count + more

    @property
    def complete(self) -> bool:
        """Is the mesh the one that was encoded?"""
        return self._result == int(lib.CQ_DONE)

    @property
    def bytes_used(self) -> int:
        """Bytes of the stream that were decoded."""
        return self._used

    @property
    def total_vertices(self) -> int | None:
        """Vertices of the full mesh, as vertex buffers have them; None until the header has come."""
        shape = self._decoder.shape
        return int(shape.num_rows or shape.num_vertices) if self._memory is not None else None

    @property
    def total_faces(self) -> int | None:
        """Faces of the full mesh; None until the header has come."""
        return int(self._decoder.shape.num_faces) if self._memory is not None else None

    @property
    def faces_aside(self) -> int:
        """Faces that are no part of a surface: those of a complete mesh behind total_faces; 0 until the header has come."""
        return int(self._decoder.shape.num_aside_faces)

    @property
    def level(self) -> int:
        """Levels begun."""
        return int(self._decoder.level)

    @property
    def error(self) -> float | None:
        """How far vertices of the exact mesh are from this one at most, in the unit of the vertices; 0 if complete,
        None if the stream does not tell."""
        if self.complete:
            return 0.0
        for channel in self._channels(self._decoder.shape):
            if (channel.kind, channel.merge) == (lib.CQ_POSITION, lib.CQ_AVERAGE) and channel.bits != channels.EXACT:
                steps = int(self._decoder.error) / 16
                return steps * channels.bits_float(channel.step) if self.level else None
        return None

    @property
    def vertices(self) -> NDArray[Any]:
        """float32 (V, 3), or float64 where floats are too coarse for the grid; (V, 0) if the stream has none."""
        if "positions" in self._names:
            return self._array(self._names.index("positions"))
        aside = int(self._decoder.aside.num_rows) if self.complete else 0
        return np.empty((self._num_rows + aside, 0), np.float32)

    @property
    def faces(self) -> NDArray[np.uint32]:
        """uint32 (F, 3), a view of the decoder's memory: it changes while decoding goes on. A copy, if faces are turned
        over or, in a complete mesh, aside; and of the faces that are there of each material, until all are."""
        d, numbers = self._decoder, self._face_numbers
        if numbers is not None:
            every = np.empty((int(d.mesh.num_faces), 3), np.uint32)
            lib.cq_read_triangles(d, 0, len(every), ffi.from_buffer("uint32_t[]", every))
            return every[numbers]
        count, aside = int(d.mesh.num_faces), int(d.aside.num_faces) if self.complete else 0
        if not aside and "turned" not in self._names:
            return self._view(d.index, count, 3)
        faces = np.empty((count + aside, 3), np.uint32)
        lib.cq_read_triangles(d, 0, count, ffi.from_buffer("uint32_t[]", faces))
        if aside:
            faces[count:] = self._view(d.aside.index, aside, 3)
        return faces

    @property
    def attributes(self) -> dict[str, NDArray[Any]]:
        """By name, as conquest.channels lists them: arrays (V, ...), of materials (F,)."""
        result = {name: self._array(k) for k, name in enumerate(self._names) if name not in ("positions", "turned")}
        if self.material_ranges:
            result["materials"] = self._materials()
        return result

    def values(self, name: str) -> NDArray[np.int32]:
        """The integers of an attribute or of "positions" as they are in the stream, int32 (n, components), a view: of
        the vertices of the surface, or where there are seams and it may differ at them, of the vertices of a GPU."""
        k = self._names.index(name)
        d, channel = self._decoder, self._decoder.shape.channel[k]
        of_rows = channel.kind in (lib.CQ_NORMAL, lib.CQ_TEXCOORD, lib.CQ_COLOR, lib.CQ_TANGENT)
        count = int(d.mesh.num_faces if channel.merge == lib.CQ_PER_FACE else
                    self._num_rows if of_rows else d.mesh.num_vertices)
        return self._view(self._decoder.channel[k], count, channel.components).view(np.int32)

    @property
    def metadata(self) -> bytes:
        """Bytes that came with the mesh; b"" if there are none or it is not complete."""
        size = int(self._decoder.shape.metadata_bytes) if self.complete else 0
        return bytes(ffi.buffer(self._decoder.metadata, size)) if size else b""

    @property
    def surface_vertices(self) -> int:
        """Vertices of the surface: fewer than those of a GPU where there are seams."""
        return int(self._decoder.mesh.num_vertices)

    def changed_blocks(self, since: int, shift: int = 6) -> NDArray[np.bool_]:
        """Which blocks of 2^shift faces have changed since there were `since` surface_vertices: bool (blocks,). With
        materials, blocks of the full mesh's faces, see material_ranges.
        Vertices that were there then are as they were, if the stream was encoded with clean."""
        blocks = np.zeros((int(self._decoder.mesh.num_faces) + (1 << shift) - 1) >> shift, np.uint8)
        if blocks.size:
            lib.cq_mesh_changes(ffi.addressof(self._decoder, "mesh"), since, shift,
                                ffi.from_buffer("uint8_t[]", blocks))
        return blocks.view(np.bool_)

    def mesh(self) -> Mesh:
        """The mesh of this moment, in arrays that stay as they are. Those that are full are not copied."""
        attributes = {name: self._keep(array) for name, array in self.attributes.items()}
        return Mesh(self._keep(self.vertices), self.faces.copy(), attributes, self.complete, self.error,
                    self.metadata)

    @staticmethod
    def _keep(view: NDArray[Any]) -> NDArray[Any]:
        whole = view.base
        return whole if isinstance(whole, np.ndarray) and whole.shape == view.shape else view.copy()


def decode(data: Buffer, *, partial: bool = False, max_memory: int = MAX_MEMORY) -> Mesh:
    """Decodes a stream.

    partial     a stream that ends early gives the coarser mesh that it holds; else it is a TruncatedError.
    max_memory  bytes that the header may ask for; more is a MemoryError.

    Raises StreamError for bytes that are no stream, are corrupt or follow its end.
    """
    decoder = Decoder(max_memory)
    try:
        decoder.feed(data)
        decoder.finish()
    except TruncatedError:
        if not partial:
            raise
    if decoder.complete and decoder.bytes_used < len(memoryview(data).cast("B")):
        raise StreamError(int(lib.CQ_ERROR_CORRUPT), decoder.bytes_used)
    return decoder.mesh()
