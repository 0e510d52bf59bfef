"""Mesh files read without any of the code under test: as a multiset of triangles with all that their corners and faces have.
SPDX-License-Identifier: MIT"""

import collections
import math
import struct

# Of a corner; what it has not is None. Of a face: names, or None.
Corner = collections.namedtuple("Corner", "position normal texcoord color")
Face = collections.namedtuple("Face", "corners material group object")


def rounded(numbers, digits=3):
    return None if numbers is None else tuple(round(x, digits) + 0.0 for x in numbers)


def key(face):
    """The same for faces that begin at another corner; numbers to three digits."""
    corners = [tuple(rounded(part) or () for part in corner) for corner in face.corners]
    return (min(corners[k:] + corners[:k] for k in range(len(corners))), *(name or "" for name in face[1:]))


def triangles(faces):
    return collections.Counter(map(repr, map(key, faces)))


class Mesh:
    def __init__(self):
        self.faces, self.positions, self.libraries, self.textures = [], [], [], []


def read_obj(path):
    mesh = Mesh()
    lists = {"v": [], "vt": [], "vn": []}
    label = {"usemtl": None, "g": None, "o": None}
    for line in path.read_text().splitlines():
        word, _, rest = line.partition(" ")
        if word in lists:
            lists[word].append(tuple(map(float, rest.split())))
        elif word in label:
            label[word] = rest.strip() or None
        elif word == "mtllib":
            mesh.libraries.append(rest)
        elif word in ("f", "l", "p"):
            corners = []
            for corner in rest.split():
                v, vt, vn = (corner.split("/") + ["", ""])[:3]
                vertex = lists["v"][int(v) - 1]
                corners.append(Corner(vertex[:3], lists["vn"][int(vn) - 1] if vn else None,
                                      lists["vt"][int(vt) - 1][:2] if vt else None, vertex[3:] or None))
            mesh.faces.append(Face(corners, label["usemtl"], label["g"], label["o"]))
    mesh.positions = [v[:3] for v in lists["v"]]
    return mesh


TYPES = {"uchar": "B", "uint": "I", "int": "i", "float": "f", "double": "d"}


def read_row(data, at, properties):
    row = {}
    for name, kind, count_kind in properties:
        count = 1
        if count_kind:
            count = struct.unpack_from("<" + count_kind, data, at)[0]
            at += struct.calcsize(count_kind)
        values = struct.unpack_from(f"<{count}{kind}", data, at)
        at += struct.calcsize(f"<{count}{kind}")
        row[name] = values if count_kind else values[0]
    return row, at


def read_ply(path):
    """As cqm writes it."""
    mesh = Mesh()
    head, data = path.read_bytes().split(b"end_header\n", 1)
    elements = []
    for line in head.decode().splitlines():
        words = line.split()
        if line.startswith("comment TextureFile "):
            mesh.textures.append(line[len("comment TextureFile "):].strip())
        elif words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            is_list = words[1] == "list"
            elements[-1][2].append((words[-1], TYPES[words[-2]], TYPES[words[2]] if is_list else None))
    at, rows = 0, {}
    for name, count, properties in elements:
        rows[name] = []
        for _ in range(count):
            row, at = read_row(data, at, properties)
            rows[name].append(row)

    def part(row, *names, unit=1):
        return tuple(row[name] / unit for name in names) if names[0] in row else None

    corner = [Corner(part(v, "x", "y", "z"), part(v, "nx", "ny", "nz"), part(v, "s", "t"),
                     part(v, "red", "green", "blue", unit=255)) for v in rows["vertex"]]
    mesh.positions = [c.position for c in corner]
    for face in rows["face"]:
        corners = [corner[v] for v in face["vertex_indices"]]
        texcoords = face.get("texcoord", ())
        if texcoords:
            corners = [c._replace(texcoord=texcoords[2 * k:2 * k + 2]) for k, c in enumerate(corners)]
        elif "texcoord" in face:
            corners = [c._replace(texcoord=None) for c in corners]
        texture = face.get("texnumber", -1)
        mesh.faces.append(Face(corners, mesh.textures[texture] if texture >= 0 else None, None, None))
    return mesh


def area(face):
    a, b, c = (corner.position for corner in face.corners)
    u, v = ([x - y for x, y in zip(p, a)] for p in (b, c))
    return math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2
