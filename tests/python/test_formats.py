"""trimesh and meshio. SPDX-License-Identifier: MIT"""

import meshio
import numpy as np
import pytest
import trimesh
from meshes import torus

import conquest

assert conquest.register() == conquest.register() == ["trimesh", "meshio"]


def nearest(vertices, others):
    """For each vertex the number of the other one that is nearest, and how far away."""
    distance = np.linalg.norm(vertices[:, None] - others[None], axis=2)
    return distance.argmin(axis=1), distance.min(axis=1).max()


def test_trimesh_writes_and_reads(tmp_path):
    vertices, faces = torus(12, 16)
    colors = np.random.default_rng(1).integers(0, 256, (len(vertices), 4), np.uint8)
    normals = vertices / np.linalg.norm(vertices, axis=1)[:, None]
    mesh = trimesh.Trimesh(vertices, faces, vertex_colors=colors, vertex_normals=normals, process=False)
    mesh.export(tmp_path / "a.cqm", bits=16)
    for back in (trimesh.load_mesh(tmp_path / "a.cqm"), trimesh.load(tmp_path / "a.cqm").geometry["a.cqm"]):
        assert len(back.vertices) == len(vertices) and back.is_watertight and abs(back.volume - mesh.volume) < 0.01
        at, distance = nearest(vertices, back.vertices)
        assert distance < 0.001 and np.array_equal(back.visual.vertex_colors[at], colors)
    assert np.abs(back.vertex_normals[at] - normals).max() < 0.01    # load_mesh computes normals, whatever the format


def test_trimesh_keeps_texture_coordinates_and_more(tmp_path):
    vertices, faces = torus(12, 16)
    mesh = trimesh.Trimesh(vertices, faces, process=False, visual=trimesh.visual.TextureVisuals(uv=vertices[:, :2]),
                           face_attributes={"materials": np.arange(len(faces)) % 7},
                           vertex_attributes={"joints": np.arange(len(vertices))})
    mesh.export(tmp_path / "a.cqm")
    back = trimesh.load_mesh(tmp_path / "a.cqm")
    at, _ = nearest(vertices, back.vertices)
    assert np.abs(back.visual.uv[at] - vertices[:, :2]).max() < 0.01
    assert np.array_equal(back.vertex_attributes["joints"][at], np.arange(len(vertices)))
    assert np.array_equal(np.bincount(back.face_attributes["materials"]), np.bincount(np.arange(len(faces)) % 7))


def test_trimesh_reads_a_part(tmp_path):
    stream = conquest.encode(*torus(40, 40))
    (tmp_path / "a.cqm").write_bytes(stream[:len(stream) // 2])
    assert 0 < len(trimesh.load_mesh(tmp_path / "a.cqm", partial=True).vertices) < 1600
    with pytest.raises(conquest.TruncatedError):
        trimesh.load_mesh(tmp_path / "a.cqm")


def test_meshio_writes_and_reads(tmp_path):
    vertices, faces = torus(12, 16)
    mesh = meshio.Mesh(vertices, [("triangle", faces[:100]), ("triangle", faces[100:])],
                       point_data={"normals": vertices, "temperature": vertices[:, 0]},
                       cell_data={"materials": [np.zeros(100, int), np.ones(len(faces) - 100, int)]})
    with pytest.warns(conquest.LossWarning, match="^dropped: temperature, which"):
        mesh.write(tmp_path / "a.cqm")
    back = meshio.read(tmp_path / "a.cqm")
    _, distance = nearest(vertices, back.points)
    assert distance < 0.01 and list(back.point_data) == ["normals"]
    assert back.cells_dict["triangle"].shape == faces.shape
    assert np.bincount(back.cell_data["materials"][0]).tolist() == [100, len(faces) - 100]


def test_meshio_says_what_cannot_be_written(tmp_path):
    with pytest.raises(meshio.WriteError):
        meshio.Mesh(np.zeros((4, 3)), [("quad", [[0, 1, 2, 3]])]).write(tmp_path / "a.cqm")
    assert not (tmp_path / "a.cqm").exists()


def test_what_is_dropped_is_told(tmp_path):
    vertices, faces = torus(12, 16)
    path = tmp_path / "a.cqm"
    mesh = meshio.Mesh(vertices, [("triangle", faces)], point_data={"joints": faces[:len(vertices), 0], "joints_1": np.arange(len(vertices))},
                       cell_data={"materials": [np.arange(len(faces)) % 3], "area": [np.ones(len(faces))]},
                       field_data={"Steel": np.array([0, 2]), "air": np.array([1, 3])},
                       point_sets={"rim": np.arange(5)}, cell_sets={"top": [np.arange(5)]})
    with pytest.warns(conquest.LossWarning, match="^dropped: area, rim, top, air, which"):
        mesh.write(path)
    assert list(meshio.read(path).point_data) == ["joints", "joints_1"]
    image = trimesh.visual.texture.SimpleMaterial(image=np.zeros((4, 4, 3), np.uint8))
    for visual, words in ((trimesh.visual.ColorVisuals(face_colors=np.zeros((len(faces), 4), np.uint8)), "colors of faces"),
                          (trimesh.visual.TextureVisuals(uv=vertices[:, :2], material=image), "the image of the texture")):
        other = trimesh.Trimesh(vertices, faces, process=False, visual=visual, vertex_attributes={"heat": vertices[:, 0]},
                                face_attributes={"area": np.ones(len(faces))})
        with pytest.warns(conquest.LossWarning, match=f"^dropped: heat, area, {words}, which"):
            other.export(path)


def test_names_of_materials_travel(tmp_path):
    vertices, faces = torus(12, 16)
    numbers, names = np.arange(len(faces)) % 2, ["Steel", "glass of a bottle"]
    mesh = trimesh.Trimesh(vertices, faces, process=False, face_attributes={"materials": numbers},
                           metadata={"materials": names})
    mesh.export(tmp_path / "a.cqm")
    assert trimesh.load_mesh(tmp_path / "a.cqm").metadata["materials"] == names
    again = meshio.read(tmp_path / "a.cqm")
    assert {name: number[0] for name, number in again.field_data.items()} == {"Steel": 0, "glass of a bottle": 1}
    again.write(tmp_path / "b.cqm")
    assert conquest.decode((tmp_path / "b.cqm").read_bytes()).material_names == names
