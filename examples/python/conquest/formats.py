"""Files .cqm in trimesh and meshio. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from .channels import KINDS, first_of_kind
from .decoder import decode
from .encoder import encode
from .errors import warn_of_loss


def register() -> list[str]:
    """Registers files .cqm with those of trimesh and meshio that are installed, and returns their names. Then
    trimesh.load_mesh("a.cqm"), mesh.export("a.cqm"), meshio.read("a.cqm") and mesh.write("a.cqm") work, with normals,
    texture coordinates and colors (trimesh) and arrays that have a name of conquest.channels (both). Names of materials
    are mesh.metadata["materials"] (trimesh) or mesh.field_data, as of gmsh's physical groups (meshio). Keywords are
    those of encode and decode; trimesh.load gives a scene, as of other formats. What a mesh has beside that is dropped,
    with a LossWarning."""
    done = []
    for name, function in (("trimesh", _register_trimesh), ("meshio", _register_meshio)):
        try:
            function()
        except ModuleNotFoundError:
            continue
        done.append(name)
    return done


# -- trimesh --


def _register_trimesh() -> None:
    importlib.import_module("trimesh.exchange.load").mesh_loaders["cqm"] = _load_trimesh
    importlib.import_module("trimesh.exchange.export")._mesh_exporters["cqm"] = _export_trimesh


def _load_trimesh(file_obj: BinaryIO, file_type: str = "cqm", partial: bool = False, process: bool = False,
                  **_: Any) -> dict[str, Any]:
    mesh = decode(file_obj.read(), partial=partial)
    result: dict[str, Any] = {"vertices": mesh.vertices, "faces": mesh.faces.astype(np.int64), "process": process}
    more = mesh.attributes
    if "normals" in more:
        result["vertex_normals"] = more.pop("normals")
    if "colors" in more and more["colors"].dtype == np.uint8:
        result["vertex_colors"] = more.pop("colors")
    elif "texcoords" in more:
        visual = importlib.import_module("trimesh.visual")
        result["visual"] = visual.TextureVisuals(uv=more.pop("texcoords").astype(np.float64))
    if "materials" in more:
        result["face_attributes"] = {"materials": more.pop("materials")}
    result["vertex_attributes"] = more
    if mesh.material_names:
        result["metadata"] = {"materials": mesh.material_names}
    return result


def _export_trimesh(mesh: Any, **options: Any) -> bytes:
    attributes = _known(mesh.vertex_attributes, mesh.face_attributes)
    if "vertex_normals" in mesh._cache:          # those that were given or asked for; others follow from the faces
        attributes["normals"] = mesh.vertex_normals
    if mesh.visual.kind == "vertex":
        attributes["colors"] = mesh.visual.vertex_colors
    elif mesh.visual.kind == "texture" and mesh.visual.uv is not None:
        attributes["texcoords"] = mesh.visual.uv
    tell_dropped([*mesh.vertex_attributes, *mesh.face_attributes, *more_of_trimesh(mesh)], attributes)
    options.setdefault("material_names", mesh.metadata.get("materials", ()))
    data: bytes = encode(mesh.vertices, mesh.faces, **attributes, **options)
    return data


def more_of_trimesh(mesh: Any) -> list[str]:
    """What a trimesh has that no stream holds."""
    found = ["colors of faces"] if mesh.visual.kind == "face" else []
    material = getattr(mesh.visual, "material", None)
    if any(getattr(material, name, None) is not None for name in ("image", "baseColorTexture")):
        found.append("the image of the texture")
    return found


# -- meshio --


def _register_meshio() -> None:
    meshio = importlib.import_module("meshio")
    if "cqm" not in importlib.import_module("meshio._helpers").reader_map:
        meshio.register_format("cqm", [".cqm"], _read_meshio, {"cqm": _write_meshio})


def _read_meshio(path: Any) -> Any:
    meshio = importlib.import_module("meshio")
    data = path.read() if hasattr(path, "read") else Path(path).read_bytes()
    mesh = decode(data)
    of_faces = {name: [mesh.attributes.pop(name)] for name in list(mesh.attributes) if name.startswith("materials")}
    names = {name: np.array([number, 2]) for number, name in enumerate(mesh.material_names)}
    return meshio.Mesh(mesh.vertices, [("triangle", mesh.faces.astype(np.int64))], point_data=mesh.attributes,
                       cell_data=of_faces, field_data=names)


def _write_meshio(path: Any, mesh: Any, **options: Any) -> None:
    meshio = importlib.import_module("meshio")
    if any(block.type != "triangle" for block in mesh.cells):
        raise meshio.WriteError("a .cqm file has triangles only")
    faces = np.concatenate([block.data for block in mesh.cells]) if mesh.cells else np.zeros((0, 3), np.uint32)
    of_faces = {name: np.concatenate(arrays) for name, arrays in mesh.cell_data.items()}
    options.setdefault("material_names", _names_of_faces(mesh.field_data))
    attributes = _known(mesh.point_data, of_faces)
    others = [name for name, (_, dimension) in mesh.field_data.items() if dimension != 2]
    tell_dropped([*mesh.point_data, *mesh.cell_data, *mesh.point_sets, *mesh.cell_sets, *others], attributes)
    data = encode(mesh.points, faces, **attributes, **options)
    if hasattr(path, "write"):
        path.write(data)
    else:
        Path(path).write_bytes(data)


def _names_of_faces(field_data: Any) -> list[str]:
    """Names of numbers, from 0 on, from meshio's {name: [number, dimension]}."""
    names = {int(number): name for name, (number, dimension) in field_data.items() if dimension == 2}
    return [names.get(number, "") for number in range(max(names, default=-1) + 1)]


def tell_dropped(names: list[str], kept: dict[str, Any]) -> None:
    """Warns of those that are not kept."""
    dropped = [name for name in dict.fromkeys(names) if name not in kept]
    if dropped:
        warn_of_loss(f"dropped: {', '.join(dropped)}, which a .cqm file does not have")


def _known(of_vertices: Any, of_faces: Any) -> dict[str, Any]:
    """Attributes with a name of conquest.channels: of what they belong to."""
    known = {name: array for name, array in of_vertices.items() if first_of_kind(name) in KINDS
             and first_of_kind(name) != "materials"}
    known.update({name: array for name, array in of_faces.items() if first_of_kind(name) == "materials"})
    return known
