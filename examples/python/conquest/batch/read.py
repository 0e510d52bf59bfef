"""Files of meshes that trimesh and meshio can read, as arguments of encode. SPDX-License-Identifier: MIT

OFF, OBJ, PLY and STL are left to cqm, which keeps seams, groups and names.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import meshio  # type: ignore[import-untyped, import-not-found, unused-ignore]
import numpy as np
import trimesh  # type: ignore[import-untyped, import-not-found, unused-ignore]

from ..channels import KINDS
from ..errors import warn_of_loss
from ..formats import more_of_trimesh, tell_dropped

CQM = frozenset({".off", ".obj", ".ply", ".stl"})
NO_MESHES = frozenset({".cqm", ".dat", ".json", ".svg", ".wkt", ".xml", ".xyz"})  # in trees of meshes mostly others
MESHIO = frozenset(meshio.extension_to_filetypes) - NO_MESHES - CQM
TRIMESH = frozenset("." + name for name in trimesh.exchange.load.mesh_loaders) - NO_MESHES - CQM - MESHIO
SUFFIXES = CQM | MESHIO | TRIMESH

Arguments = dict[str, Any]


def companions(path: Path) -> list[Path]:
    """Files that hold part of the mesh."""
    pattern = {".gltf": r'"uri"\s*:\s*"([^"]+)"', ".xdmf": r"([^\s<>:]+\.h5)\s*:"}.get(path.suffix.lower())
    names = re.findall(pattern, path.read_text(encoding="utf-8", errors="replace")) if pattern else []
    return [path.parent / name for name in sorted(set(names)) if (path.parent / name).is_file()]


def read(path: Path) -> Arguments:
    """Raises ValueError if the file has no surface, and what its reader raises."""
    arguments = _read_meshio(path) if path.suffix.lower() in MESHIO else _read_trimesh(path)
    if not len(arguments["faces"]):
        raise ValueError("no faces")
    return arguments


def _number(names: list[str]) -> tuple[list[str], list[int]]:
    """Different names in the order of their first place, and for each name its number there."""
    different = list(dict.fromkeys(names))
    return different, [different.index(name) for name in names]


# -- trimesh: all meshes of a scene, where they stand, with a material for each --


def _read_trimesh(path: Path) -> Arguments:
    scene = trimesh.load_scene(path, process=False)
    parts: list[Any] = []
    names: list[str] = []
    others: list[str] = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        part = scene.geometry[name]
        if isinstance(part, trimesh.Trimesh):
            parts.append(part.copy().apply_transform(matrix))
            names.append(str(getattr(getattr(part.visual, "material", None), "name", None) or name))
            others += [*more_of_trimesh(part), *part.vertex_attributes, *part.face_attributes]
        else:
            others.append(str(name))
    if not parts:
        raise ValueError("no mesh")
    tell_dropped(others, {})
    return _join(parts, names)


def _join(parts: list[Any], names: list[str]) -> Arguments:
    """One mesh. What only some parts have, the others get as white, as zeros, or computed from their faces."""
    first = np.cumsum([0] + [len(part.vertices) for part in parts])
    arguments: Arguments = {"vertices": np.concatenate([part.vertices for part in parts]),
                            "faces": np.concatenate([part.faces + begin for part, begin in zip(parts, first)])}
    if any("vertex_normals" in part._cache for part in parts):
        arguments["normals"] = np.concatenate([part.vertex_normals for part in parts])
    texcoords = [getattr(part.visual, "uv", None) for part in parts]
    for what, having in (("texture coordinates", [uv is not None for uv in texcoords]),
                         ("colors", [part.visual.kind == "vertex" for part in parts])):
        if any(having) and not all(having):
            warn_of_loss(f"changed: parts without {what} ({having.count(False)}) get some")
    if any(uv is not None for uv in texcoords):
        arguments["texcoords"] = np.concatenate([np.zeros((len(part.vertices), 2)) if uv is None else uv
                                                 for part, uv in zip(parts, texcoords)])
    if any(part.visual.kind == "vertex" for part in parts):
        arguments["colors"] = np.concatenate([
            part.visual.vertex_colors if part.visual.kind == "vertex" else np.full((len(part.vertices), 4), 255, np.uint8)
            for part in parts])
    different, numbers = _number(names)
    if len(different) > 1:
        arguments["materials"] = np.repeat(numbers, [len(part.faces) for part in parts])
        arguments["material_names"] = different
    return arguments


# -- meshio: cells of dimension 2 --


def _read_meshio(path: Path) -> Arguments:
    mesh = meshio.read(path)
    solids = sorted({block.type for block in mesh.cells if block.dim == 3})
    if solids:
        raise ValueError(f"solid cells ({', '.join(solids)}), not a surface")
    blocks = [(k, _corners(block)) for k, block in enumerate(mesh.cells) if block.dim == 2]
    fans = [_fan(corners) for _, corners in blocks]
    points = np.zeros((len(mesh.points), 3))
    points[:, :mesh.points.shape[1]] = mesh.points
    arguments: Arguments = {name: array for name, array in mesh.point_data.items()
                            if name in KINDS and name != "materials"}
    arguments["vertices"], arguments["faces"] = points, np.concatenate([np.zeros((0, 3), int), *fans])
    cut = sum(len(corners) for _, corners in blocks if corners.shape[1] > 3)
    if cut:
        warn_of_loss(f"changed: faces with more than three corners ({cut}) are cut into triangles")
    tell_dropped([*mesh.point_data, *(name for name in mesh.cell_data if name not in ("materials", "gmsh:physical")),
                  *(f"cells of type {block.type}" for block in mesh.cells if block.dim < 2)], arguments)
    for name in ("materials", "gmsh:physical"):
        if name in mesh.cell_data:
            numbers = [np.repeat(mesh.cell_data[name][k], corners.shape[1] - 2) for k, corners in blocks]
            return arguments | _materials(np.concatenate(numbers), mesh.field_data)
    return arguments


def _corners(block: Any) -> Any:
    """The corners of faces, without the nodes on edges that cells of higher order have: int (n, 3 or more)."""
    data = np.asarray(block.data)
    known = {"triangle": 3, "quad": 4}.get(re.sub(r"\d+$", "", block.type))
    return data[:, :known] if known else data


def _fan(corners: Any) -> Any:
    """Triangles of each face in a row."""
    count = corners.shape[1]
    fan = np.stack([np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], 1)
    return corners[:, fan].reshape(-1, 3)


def _materials(numbers: Any, field_data: Any) -> Arguments:
    """Any integers, as numbers from 0 on, and their names."""
    names = {int(number): name for name, (number, dimension) in field_data.items() if dimension == 2}
    different, materials = np.unique(numbers, return_inverse=True)
    return {"materials": materials.ravel(), "material_names": [names.get(int(k), str(k)) for k in different]}
