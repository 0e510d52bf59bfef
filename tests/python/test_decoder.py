"""Decoder: bytes as they arrive. SPDX-License-Identifier: MIT"""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from meshes import attributes, meshes, torus, triangles

import conquest


@given(st.data(), meshes(), st.integers(1, 60), st.one_of(st.none(), st.integers(1, 40)))
def test_pieces_and_steps_give_the_same_mesh_and_what_came_stays(data, mesh, size, steps):
    extra = data.draw(attributes(len(mesh[0]), len(mesh[1])))
    stream = conquest.encode(*mesh, **extra)
    decoder = conquest.Decoder()
    before = conquest.Mesh(np.empty((0, 3)), np.empty((0, 3), np.uint32))
    for k in range(0, len(stream), size):
        more = decoder.feed(stream[k:k + size], steps)
        while more:
            now = decoder.mesh()
            stays(before, now)
            before = now
            more = decoder.feed(steps=steps)
    decoder.finish()
    assert decoder.complete and decoder.bytes_used == len(stream)
    stays(before, decoder.mesh())
    whole = conquest.decode(stream)
    assert np.array_equal(decoder.vertices, whole.vertices) and np.array_equal(decoder.faces, whole.faces)
    for name, array in whole.attributes.items():
        assert np.array_equal(decoder.attributes[name], array)


@given(triangles(), st.integers(1, 20), st.booleans())
def test_seams_arrive_in_steps(soup, steps, clean):
    vertices, faces, texcoords, materials = soup
    stream = conquest.encode(vertices, faces, texcoords=texcoords, materials=materials, clean=clean)
    decoder, whole = conquest.Decoder(), conquest.decode(stream)
    before = conquest.Mesh(np.empty((0, 3)), np.empty((0, 3), np.uint32))
    more = decoder.feed(stream, steps)
    while more:
        now = decoder.mesh()
        assert len(now.faces) == 0 or now.faces.max() < len(now.vertices)
        if clean:
            stays(before, now)
        before = now
        more = decoder.feed(steps=steps)
    decoder.finish()
    for array, other in ((decoder.vertices, whole.vertices), (decoder.faces, whole.faces),
                         (decoder.attributes["texcoords"], whole.attributes["texcoords"]),
                         (decoder.attributes["materials"], whole.attributes["materials"])):
        assert np.array_equal(array, other)


def stays(before, now):
    """Every array of vertices only grows at its end."""
    for old, new in [(before.vertices, now.vertices)] + [(before.attributes[k], now.attributes[k])
                                                         for k in before.attributes if k != "materials"]:
        assert np.array_equal(old, new[:len(old)])


@given(meshes(), st.integers(1, 30), st.integers(0, 8))
def test_a_gpu_that_gets_changed_blocks_has_the_mesh(mesh, steps, shift):
    stream = conquest.encode(*mesh)
    decoder, gpu, since = conquest.Decoder(), np.zeros((len(mesh[1]), 3), np.uint32), 0
    more = decoder.feed(stream, steps)
    while True:
        faces = decoder.faces
        changed = np.repeat(decoder.changed_blocks(since, shift), 1 << shift)[:len(faces)]
        gpu[:len(faces)][changed] = faces[changed]
        assert np.array_equal(gpu[:len(faces)], faces)
        since = decoder.surface_vertices
        if not more:
            break
        more = decoder.feed(steps=steps)
    assert decoder.complete and len(faces) == len(mesh[1])


def test_arrays_are_views_that_outlive_the_decoder_and_cannot_be_written():
    decoder = conquest.Decoder()
    decoder.feed(conquest.encode(*torus(20, 20)))
    faces, values = decoder.faces, decoder.values("positions")
    assert np.shares_memory(decoder.faces, faces) and values.shape == (400, 3)
    copy = faces.copy()
    del decoder
    np.empty(10 ** 6).fill(1)
    assert np.array_equal(faces, copy)
    for array in (faces, values):
        with pytest.raises(ValueError):
            array[0] = 0


def test_what_is_known_when():
    stream = conquest.encode(*torus(20, 20))
    decoder = conquest.Decoder()
    assert decoder.total_vertices is None and decoder.error is None and len(decoder.faces) == 0
    assert not decoder.feed(stream[:10])
    decoder.feed(stream[10:200])
    assert (decoder.total_vertices, decoder.total_faces) == (400, 800)
    errors = []
    for k in range(200, len(stream), 10):
        decoder.feed(memoryview(stream)[k:k + 10])
        errors.append(decoder.error)
    assert errors[0] > 0.1 and errors == sorted(errors, reverse=True) and errors[-1] == 0


def test_an_error_is_permanent_and_leaves_the_mesh():
    stream = bytearray(conquest.encode(*torus(20, 20)))
    stream[-3] ^= 1
    decoder = conquest.Decoder()
    with pytest.raises(conquest.StreamError):
        decoder.feed(stream)
    assert len(decoder.vertices) > 100 and decoder.faces.max() < len(decoder.vertices)
    for call in (decoder.feed, decoder.finish):
        with pytest.raises(conquest.StreamError):
            call()


def test_a_header_may_not_ask_for_more_than_is_allowed():
    with pytest.raises(MemoryError):
        conquest.decode(conquest.encode(*torus(20, 20)), max_memory=10_000)


def test_each_material_is_one_range_of_faces_at_any_moment():
    vertices, faces = torus(24, 16)
    materials = np.arange(len(faces)) * 5 // len(faces)
    stream, _, face_to = conquest.encode(vertices, faces, materials=materials, return_maps=True)
    decoder, counts = conquest.Decoder(), []
    for k in range(0, len(stream), 40):
        decoder.feed(stream[k:k + 40])
        ranges = decoder.material_ranges
        assert len(decoder.faces) == sum(count for _, count in ranges) == len(decoder.attributes["materials"])
        assert decoder.faces.size == 0 or decoder.faces.max() < len(decoder.vertices)
        counts.append([count for _, count in ranges])
    decoder.finish()
    assert len(counts) > 3 and (np.diff(counts, axis=0) >= 0).all() and counts[0] != counts[-1]
    assert decoder.material_ranges == [(int(first), int(count)) for first, count in
                                       zip(np.searchsorted(materials, range(5)), np.bincount(materials))]
    assert np.array_equal(decoder.attributes["materials"][face_to], materials)
