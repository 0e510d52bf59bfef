#!/usr/bin/env python3
"""Published files through cqm, compared with how another library reads them: assets.py CQM FOLDER SET=FOLDER...

A set is a folder. Each OBJ, PLY, STL and OFF file in it that trimesh reads as triangles is encoded,
decoded to OBJ, and both files are read by trimesh: the triangles must be the same, as often, with the same texture coordinates
and normals where the file has them. Where faces have more than three corners, which are not all cut the same way, their area
and what borders them must be. `cqm verify` must succeed. The last line is `N passed, N failed`.
SPDX-License-Identifier: MIT"""

import collections
import pathlib
import subprocess
import sys

import numpy
import trimesh

KINDS = {".obj", ".ply", ".stl", ".off"}
BITS = "normals=20,texcoords=24,32"       # positions are floats as they are
REFUSED = {"number_formats.obj": b"number expected, found '3.1+e2'"}
NEAR = 1e-4                               # of normals, and of texture coordinates that go from 0 to 1


def load(path):
    """Of a file: vertices, faces, texture coordinates and normals of vertices, or None. No vertex is merged."""
    loaded = trimesh.load(path, process=False, skip_materials=True, split_object=False, group_material=False)
    parts = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    parts = [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    return [triangles(part) for part in parts]


def triangles(mesh):
    """Corners of triangles as rows of numbers: positions, texture coordinates, normals."""
    texcoords = getattr(mesh.visual, "uv", None)
    normals = mesh._cache.cache.get("vertex_normals") if hasattr(mesh, "_cache") else None
    corners = {"positions": numpy.asarray(mesh.vertices, dtype=numpy.float32)}
    if texcoords is not None and len(texcoords) == len(mesh.vertices):
        corners["texcoords"] = numpy.asarray(texcoords)
    if normals is not None and len(normals) == len(mesh.vertices):
        corners["normals"] = numpy.asarray(normals)
    return {name: values[mesh.faces] for name, values in corners.items()}


def joined(parts, name):
    return numpy.concatenate([part[name] for part in parts]) if all(name in part for part in parts) else None


def turned(positions, others):
    """Each triangle from its smallest corner on."""
    first = [min(range(3), key=lambda k, row=row: tuple(map(tuple, numpy.roll(row, -k, axis=0)))) for row in positions.tolist()]
    index = (numpy.asarray(first)[:, None] + numpy.arange(3)) % 3
    rows = numpy.arange(len(positions))[:, None]
    return positions[rows, index], [None if other is None else other[rows, index] for other in others]


def by_position(parts):
    """What the corners have beside positions, of the triangles with the same positions."""
    positions, others = turned(joined(parts, "positions") + numpy.float32(0), (joined(parts, "texcoords"), joined(parts, "normals")))
    found = collections.defaultdict(list)
    for k, key in enumerate(map(bytes, positions)):
        found[key].append([None if other is None else other[k] for other in others])
    return found


def is_near(a, b, tolerance):
    return a is None or b is None or bool(numpy.all(numpy.abs(a - b) <= tolerance))


def normalized(n):
    with numpy.errstate(invalid="ignore", divide="ignore"):
        return None if n is None else n / numpy.linalg.norm(n, axis=-1, keepdims=True)


def is_same_corner_data(a, b, tolerance):
    n, m = normalized(a[1]), normalized(b[1])
    has_length = n is not None and m is not None and numpy.isfinite(n).all() and numpy.isfinite(m).all()
    return is_near(a[0], b[0], tolerance) and (not has_length or is_near(n, m, NEAR))


def match(wanted, found, tolerance):
    """Can each of the ones be matched with one of the others?"""
    found = list(found)
    for a in wanted:
        k = next((k for k, b in enumerate(found) if is_same_corner_data(a, b, tolerance)), None)
        if k is None:
            return False
        found.pop(k)
    return not found


def compare_triangles(source, decoded):
    wanted, found = by_position(source), by_position(decoded)
    if {k: len(v) for k, v in wanted.items()} != {k: len(v) for k, v in found.items()}:
        return "other triangles"
    texcoords = joined(source, "texcoords")
    tolerance = NEAR * max(1, float(numpy.ptp(texcoords)) if texcoords is not None else 0)
    return None if all(match(wanted[key], found[key], tolerance) for key in wanted) else "other attributes"


def border(positions):
    """Directed edges without one in the other direction."""
    points = [list(map(bytes, row)) for row in positions]
    edges = collections.Counter()
    for a, b, c in points:
        for edge in (a, b), (b, c), (c, a):
            if edges[edge[::-1]] > 0:
                edges[edge[::-1]] -= 1
            else:
                edges[edge] += 1
    return +edges


def vector_area(positions):
    p = positions.astype(float)
    return numpy.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]).sum(axis=0)


def compare_polygons(source, decoded):
    wanted, found = (joined(parts, "positions") + numpy.float32(0) for parts in (source, decoded))
    if len(wanted) != len(found):
        return f"{len(found)} triangles instead of {len(wanted)}"
    if border(wanted) != border(found):
        return "another border"
    scale = float(numpy.ptp(wanted, axis=0).max()) ** 2
    return None if numpy.abs(vector_area(wanted) - vector_area(found)).max() <= 1e-4 * scale else "another area"


class Assets:
    def __init__(self, cqm, folder):
        self.cqm, self.folder = cqm, folder
        self.passed = self.failed = 0

    def run(self, *arguments):
        return subprocess.run([self.cqm, *map(str, arguments)], capture_output=True, check=False)

    def fail(self, path, why):
        self.failed += 1
        print(f"FAIL  {path}: {why}")
        return "failed"

    def take(self, path):
        """What came of a file: "not for trimesh", "equal", "equal but for cuts", or "failed"."""
        try:
            source = load(path)
        except ImportError:                                # something is missing here, not in the file
            raise
        except Exception:                                  # whatever a reader says of a file that it does not like
            return self.refused_or_verified(path)
        if not source or not all(numpy.isfinite(part["positions"]).all() for part in source):
            return self.refused_or_verified(path)
        stream, out = self.folder / "a.cqm", self.folder / "a.obj"
        told = self.run("encode", "--bits", BITS, path, stream)
        if told.returncode == 1 and path.name in REFUSED and REFUSED[path.name] in told.stderr:
            self.passed += 1
            return "refused with reason"
        if told.returncode != 0:
            return self.fail(path, f"refused: {told.stderr.decode().strip()}")
        for done in self.run("decode", stream, out), self.run("verify", "--quiet", path):
            if done.returncode != 0:
                return self.fail(path, done.stderr.decode().strip())
        return self.compare(path, source, load(out), b"cut into triangles" in told.stderr)

    def compare(self, path, source, decoded, has_polygons):
        difference = compare_triangles(source, decoded)
        outcome = "equal"
        if difference is not None and has_polygons:
            difference, outcome = compare_polygons(source, decoded), "equal but for cuts"
        if difference is not None:
            return self.fail(path, difference)
        self.passed += 1
        return outcome

    def refused_or_verified(self, path):
        done = self.run("verify", "--quiet", path)
        if done.returncode not in (0, 1):
            return self.fail(path, f"status {done.returncode}")
        self.passed += 1
        return "not for trimesh, " + ("taken" if done.returncode == 0 else "refused")


def files_of(path):
    return sorted(p for p in pathlib.Path(path).rglob("*") if p.suffix.lower() in KINDS and p.is_file())


def main():
    assets = Assets(sys.argv[1], pathlib.Path(sys.argv[2]))
    assets.folder.mkdir(parents=True, exist_ok=True)
    for name, path in (argument.split("=", 1) for argument in sys.argv[3:]):
        outcomes = collections.Counter(assets.take(file) for file in files_of(path))
        print(f"{name}: {sum(outcomes.values())} files: " + ", ".join(f"{n} {what}" for what, n in sorted(outcomes.items())))
        if not outcomes:
            assets.fail(path, "no files")
    print(f"{assets.passed} passed, {assets.failed} failed")
    return 1 if assets.failed or not assets.passed else 0


if __name__ == "__main__":
    sys.exit(main())
