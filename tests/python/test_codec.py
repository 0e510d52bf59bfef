"""encode and decode. SPDX-License-Identifier: MIT"""

import os
import subprocess
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, strategies as st
from meshes import attributes, meshes, same_faces, step_of, torus, triangles

import conquest

CQM = os.environ["CQM"]


@given(st.data(), meshes(), st.integers(8, 16), st.sampled_from(["balanced", "least-connectivity"]))
def test_a_mesh_comes_back_where_the_maps_say(data, mesh, bits, goal):
    vertices, faces = mesh
    extra = data.draw(attributes(len(vertices), len(faces)))
    stream, to, face_to = conquest.encode(vertices, faces, bits=bits, goal=goal, return_maps=True, **extra)
    back = conquest.decode(stream)
    assert back.complete and back.error == 0
    assert same_faces(to[faces], back.faces[face_to])
    assert np.abs(back.vertices[to] - vertices).max() <= 0.51 * step_of(vertices, bits) + 1e-6 * np.abs(vertices).max()
    assert set(back.attributes) == set(extra)
    for name, array in extra.items():
        check_attribute(name, array, back.attributes[name][face_to if name == "materials" else to])


def check_attribute(name, array, back):
    if array.dtype.kind in "iu":
        assert np.array_equal(back, array) and (name != "colors" or back.dtype == np.uint8)
    elif name == "normals":
        cosine = np.sum(array / np.linalg.norm(array, axis=1)[:, None] * back, axis=1)
        assert cosine.min() > np.cos(0.006)
    elif name == "weights":
        assert np.abs(back - array).max() <= 0.51 / 4095
    else:
        assert np.abs(back - array).max() <= 0.51 * step_of(array, 12)


@given(meshes())
def test_floats_come_back_bit_for_bit(mesh):
    vertices, faces = mesh
    normals = np.roll(vertices, 1, 0)
    stream, to, _ = conquest.encode(vertices, faces, bits={"positions": 32, "normals": 32}, normals=normals,
                                    return_maps=True)
    back = conquest.decode(stream)
    assert np.array_equal(back.vertices[to], vertices.astype(np.float32))
    assert np.array_equal(back.attributes["normals"][to], normals.astype(np.float32))


def corners(faces, *arrays):
    """What the corners of each face have, from the least corner on: float (F, 3, n)."""
    rows = np.concatenate([np.asarray(array, float).reshape(len(array), -1) for array in arrays], 1)[faces]
    for face in rows:
        first = min(range(3), key=lambda k: tuple(face[k]))
        face[:] = np.roll(face, -first, 0)
    return rows


@given(triangles(), st.booleans())
def test_any_triangles_come_back_where_the_maps_say(soup, clean):
    vertices, faces, texcoords, materials = soup
    stream, to, face_to = conquest.encode(vertices, faces, bits={"positions": 32, "texcoords": 32}, clean=clean,
                                          texcoords=texcoords, materials=materials, return_maps=True)
    back = conquest.decode(stream)
    assert back.complete and len(back.faces) == len(faces)
    assert np.array_equal(corners(faces, vertices, texcoords),
                          corners(back.faces, back.vertices, back.attributes["texcoords"])[face_to])
    assert np.array_equal(back.vertices[to], vertices) and np.array_equal(back.attributes["texcoords"][to], texcoords)
    assert np.array_equal(back.attributes["materials"][face_to], materials)


@given(meshes(), st.data())
def test_any_part_is_a_mesh(mesh, data):
    stream = conquest.encode(*mesh)
    part = stream[:data.draw(st.integers(0, len(stream) - 1))]
    back = conquest.decode(part, partial=True)
    assert not back.complete and len(back.vertices) <= len(mesh[0])
    assert len(back.faces) == 0 or back.faces.max() < len(back.vertices)
    with pytest.raises(conquest.TruncatedError) as error:
        conquest.decode(part)
    assert error.value.offset <= len(part) and error.value.code == "CQ_TRUNCATED"


@given(meshes(), st.data())
def test_damage_is_found(mesh, data):
    stream = bytearray(conquest.encode(*mesh))
    stream[data.draw(st.integers(0, len(stream) - 1))] ^= data.draw(st.integers(1, 255))
    with pytest.raises((conquest.StreamError, MemoryError)):
        conquest.decode(stream)


@given(st.binary(max_size=300))
def test_any_bytes_are_refused(data):
    with pytest.raises((conquest.StreamError, MemoryError)):
        conquest.decode(data)


def test_bytes_behind_the_end_are_refused():
    stream = conquest.encode(*torus(5, 5))
    with pytest.raises(conquest.StreamError) as error:
        conquest.decode(stream + b"x")
    assert error.value.offset == len(stream)


def test_a_vertex_that_does_not_exist_has_a_place():
    with pytest.raises(conquest.MeshError) as error:
        conquest.encode(np.eye(4, 3), [[0, 1, 2], [0, 2, 9]])
    assert error.value.code == "CQ_ERROR_INDEX"
    assert (error.value.face, error.value.vertex, error.value.other) == (1, 9, None)


def test_a_number_that_is_not_finite_has_a_place():
    vertices, faces = torus(5, 5)
    texcoords = np.ones((25, 2))
    texcoords[7, 1] = np.nan
    with pytest.raises(conquest.MeshError, match="texcoords") as error:
        conquest.encode(vertices, faces, texcoords=texcoords)
    assert error.value.vertex == 7


@pytest.mark.parametrize("error, change", [
    (ValueError, {"vertices": np.zeros((25, 2))}),
    (ValueError, {"faces": np.zeros((7, 4), int)}),
    (ValueError, {"faces": np.zeros((7, 3))}),
    (ValueError, {"faces": np.full((7, 3), -1)}),
    (ValueError, {"normals": np.zeros((24, 3))}),
    (ValueError, {"materials": np.zeros(25, int)}),
    (ValueError, {"joints": np.full((25, 1), -1)}),
    (ValueError, {"bits": 25}),
    (ValueError, {"goal": "smallest"}),
    (TypeError, {"joints": np.zeros((25, 4))}),
    (TypeError, {"uvs": np.zeros((25, 2))}),
    (ValueError, {f"generic_{k}": np.zeros(25) for k in range(1, 17)}),
])
def test_wrong_arguments_are_refused(error, change):
    vertices, faces = torus(5, 5)
    with pytest.raises(error):
        conquest.encode(**{"vertices": vertices, "faces": faces, **change})


def test_several_attributes_of_a_kind():
    vertices, faces = torus(8, 8)
    stream, to, _ = conquest.encode(vertices, faces, texcoords=vertices[:, :2], texcoords_1=vertices[:, 1:],
                                    return_maps=True)
    back = conquest.decode(stream).attributes
    assert list(back) == ["texcoords", "texcoords_1"]
    assert np.abs(back["texcoords_1"][to] - vertices[:, 1:]).max() < 0.001


def test_coordinates_of_a_survey_keep_their_precision():
    vertices, faces = torus(20, 20)
    vertices = vertices * 100 + [4_500_000.0, 5_300_000.0, 400.0]
    stream, to, _ = conquest.encode(vertices, faces, bits=20, return_maps=True)
    back = conquest.decode(stream)
    assert back.vertices.dtype == np.float64
    assert np.abs(back.vertices[to] - vertices).max() < 0.0006


def loss(*arguments, **options):
    """What encode says that it loses, and the vertices that come back, in the order of the input."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        data, of_vertices, _ = conquest.encode(*arguments, return_maps=True, **options)
    assert all(warning.category is conquest.LossWarning and warning.filename == __file__ for warning in said)
    return [str(warning.message) for warning in said], conquest.decode(data).vertices[of_vertices]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("bits", [12, 16, 24])
def test_floats_that_are_too_coarse_for_the_grid(dtype, bits):
    """x and y are integers which floats hold, while there is none near them; z is small and has digits."""
    vertices, faces = torus(20, 30)
    vertices = np.column_stack([np.rint(20 * vertices[:, :2]) + [-1e7, 1e7], vertices[:, 2]]).astype(dtype)
    step = np.ptp(vertices.astype(float), axis=0).max() / (2 ** bits - 1)
    said, back = loss(vertices, faces, bits=bits)
    assert not said and np.abs(back - vertices.astype(float)).max() <= 0.53 * step


def test_what_is_lost_is_told():
    vertices, faces = torus(20, 30)
    texcoords = vertices[:, :2].astype(np.float32)
    assert loss(vertices, faces, texcoords=texcoords)[0] == []
    said, _ = loss(vertices, faces, texcoords=texcoords + np.float32([1e6, 0]))
    assert len(said) == 1 and said[0].startswith("texcoords: the step of the grid is 0.0625 instead of 0.00")
    texcoords[0] = -1e5
    said, _ = loss(vertices, faces, texcoords=texcoords)
    assert len(said) == 1 and said[0].startswith("texcoords: a few are far from all others") and "24.4 (12 bits)" in said[0]
    said, back = loss(vertices / 3, faces, bits=32)
    off = np.abs(back - vertices / 3).max()
    assert said == [f"positions: exact means the nearest 32-bit floats, up to {off:.3g} away"] and 0 < off < 1e-6
    assert loss(vertices.astype(np.float32), faces, bits=32)[0] == []
    said, _ = loss(vertices + [1e15, 0, 0], faces)
    assert len(said) == 1 and said[0].startswith("positions: the step of the grid is 0.775")


def test_streams_of_any_size():
    vertices, faces = torus(30, 30)
    noise = {name: np.random.default_rng(k).normal(size=(900, 4)) for k, name in
             enumerate(["generic", "generic_1", "generic_2", "generic_3"])}
    stream, to, _ = conquest.encode(vertices, faces, bits={name: 32 for name in noise}, return_maps=True, **noise)
    assert len(stream) > 40 * 900
    for name, array in conquest.decode(stream).attributes.items():
        assert np.array_equal(array[to], noise[name].astype(np.float32))


def test_no_mesh_at_all():
    back = conquest.decode(conquest.encode([], []))
    assert back.complete and len(back.vertices) == len(back.faces) == 0


def test_progress_is_told_and_what_it_raises_comes_out():
    told = []
    conquest.encode(*torus(60, 60), progress=lambda done, total: told.append((done, total)))
    assert len(told) > 1 and all(done <= total for done, total in told) and told == sorted(told)

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        conquest.encode(*torus(60, 60), progress=stop)
    assert conquest.encode(*torus(30, 30), progress=True) == conquest.encode(*torus(30, 30))


def test_threads_do_not_disturb_each_other():
    sources = [torus(20 + k, 30) for k in range(8)]
    alone = [conquest.encode(*source) for source in sources]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda source: conquest.encode(*source), sources)) == alone


@pytest.mark.parametrize("bits", [12, 32])
def test_the_command_line_reads_and_writes_the_same(tmp_path, bits):
    vertices, faces = torus(15, 20)
    vertices = vertices.astype(np.float32)
    lines = [f"OFF\n{len(vertices)} {len(faces)} 0"] + [" ".join(f"{x:.9g}" for x in v) for v in vertices]
    (tmp_path / "a.off").write_text("\n".join(lines + [f"3 {a} {b} {c}" for a, b, c in faces]) + "\n")
    subprocess.run([CQM, "encode", "--bits", str(bits), tmp_path / "a.off", tmp_path / "a.cqm"], check=True)
    stream = (tmp_path / "a.cqm").read_bytes()
    assert stream == conquest.encode(vertices, faces, bits=bits)
    subprocess.run([CQM, "decode", tmp_path / "a.cqm", tmp_path / "b.off"], check=True)
    text = (tmp_path / "b.off").read_text().split()
    back = conquest.decode(stream)
    assert np.array_equal(np.float32(text[4:4 + 3 * len(vertices)]).reshape(-1, 3), back.vertices)
    assert np.array_equal(np.int64(text[4 + 3 * len(vertices):]).reshape(-1, 4)[:, 1:], back.faces)


def test_metadata_comes_back():
    vertices, faces = torus(8, 9)
    for metadata in (b"", b"\0\xff\n", bytes(range(256)) * 16):
        stream = conquest.encode(vertices, faces, metadata=metadata)
        assert conquest.decode(stream).metadata == metadata
        assert conquest.decode(stream[:-1], partial=True).metadata == b""


def test_names_of_materials_come_back_and_cqm_knows_them(tmp_path):
    vertices, faces = torus(8, 9)
    names = ["steel", "", "clear glass"]
    stream = conquest.encode(vertices, faces, materials=np.arange(len(faces)) % 3, material_names=names)
    assert conquest.decode(stream).material_names == names
    (tmp_path / "a.cqm").write_bytes(stream)
    subprocess.run([CQM, "decode", tmp_path / "a.cqm", tmp_path / "a.obj"], check=True)
    lines = (tmp_path / "a.obj").read_text(encoding="utf-8").splitlines()
    assert {line.strip() for line in lines if line.startswith("usemtl")} == {"usemtl steel", "usemtl", "usemtl clear glass"}
    with pytest.raises(ValueError, match="line"):
        conquest.encode(vertices, faces, material_names=["a\nb"])
    with pytest.raises(ValueError, match="both"):
        conquest.encode(vertices, faces, material_names=["a"], metadata=b"a")
    with pytest.raises(ValueError, match="metadata"):
        conquest.encode(vertices, faces, metadata=bytes(2 ** 20 + 1))
