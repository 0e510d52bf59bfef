#!/usr/bin/env python3
"""Meshes as programs make them: seams, materials, names, polygons, smoothing groups, dirt. seams.py CQM FOLDER

All triangles come back, with what each corner and each face has, from OBJ and PLY to OBJ and PLY. Numbers are chosen so that
all grids hold them. The last line is `N passed, N failed`.   SPDX-License-Identifier: MIT"""

import json
import math
import pathlib
import random
import sys

from checks import check, run, run_tests
from meshes import Corner, Face, area, read_obj, read_ply, triangles

FOLDER = pathlib.Path(sys.argv[2])
BITS = "texcoords=24,32"


def cqm(*arguments, status=0):
    return run(*arguments, status=status)[0]


# -- Writing -----------------------------------------------------------------------------------------------------------

def number(items, item):
    """Of an item in a list, from 1; it goes there if it is new."""
    if item not in items:
        items.append(item)
    return items.index(item) + 1


def obj_text(faces, from_the_end=False, positions=(), head=""):
    """A vertex for each position and color; those in `positions` first."""
    v, vt, vn, lines, now = list(positions), [], [], [], Face(None, None, None, None)
    for face in faces:
        for word, name, before in zip(("usemtl", "g", "o"), face[1:], now[1:]):
            lines += [f"{word} {name}" if name else word] if name != before else []
        now = face
        numbers = []
        for c in face.corners:
            at = number(v, c.position + (c.color or ())), c.texcoord and number(vt, c.texcoord), c.normal and number(vn, c.normal)
            numbers.append("/".join(str(n or "") for n in at).rstrip("/"))
        lines.append("?plf"[min(len(numbers), 3)] + " " + " ".join(numbers))
    rows = [*("v " + " ".join(map(str, p)) for p in v), *("vt %r %r" % t for t in vt), *("vn %r %r %r" % n for n in vn)]
    if from_the_end:
        lines = [" ".join("/".join(str(int(n) - len(items) - 1) if n else "" for n, items in zip(word.split("/"), (v, vt, vn)))
                          if word[0].isdigit() else word for word in line.split(" ")) if line.startswith("f ") else line
                 for line in lines]
    return head + "\n".join(rows + lines) + "\n"


def fan(faces):
    """Polygons as triangles around their first corner."""
    return [face._replace(corners=[face.corners[0], *face.corners[k:k + 2]])
            for face in faces for k in range(1, len(face.corners) - 1)]


# -- Round trips -------------------------------------------------------------------------------------------------------

def without(faces, *parts):
    names = {part: None for part in parts if part in Face._fields}
    attributes = {part: None for part in parts if part in Corner._fields}
    return [Face([c._replace(**attributes) for c in face.corners], *face[1:])._replace(**names) for face in faces]


def same(name, found, expected):
    missing, extra = expected - found, found - expected
    check(f"{name}: {sum(missing.values())} triangles of {sum(expected.values())} are missing, {sum(extra.values())} are "
          f"not of it: {list(missing)[:2]} {list(extra)[:2]}", found == expected and sum(expected.values()) > 0)


def round_trip(name, content, faces, options=(), quiet=False):
    """Through OBJ and PLY, and once more from what came back. PLY has no names but those of materials."""
    source, stream = FOLDER / name, FOLDER / "a.cqm"
    source.write_text(content) if isinstance(content, str) else source.write_bytes(content)
    messages = cqm("encode", "--bits", BITS, *options, source, stream)
    check(f"{name}: nothing is dropped: {messages}", quiet or ("dropped" not in messages and "changed" not in messages))
    cqm("verify", "--quiet", "--bits", BITS, *options, source)
    cqm("verify", "--quiet", *options, "--keep-order", source)
    for kind, read, expected in ("obj", read_obj, faces), ("ply", read_ply, without(faces, "group", "object")):
        out = FOLDER / f"b.{kind}"
        told = cqm("decode", stream, out)
        check(f"{name} to {kind}: {told}", "dropped" not in told or kind == "ply")
        found = read(out)
        same(f"{name} to {kind}", triangles(found.faces), triangles(expected))
        cqm("encode", "--quiet", "--bits", BITS, out, FOLDER / "c.cqm")
        cqm("decode", "--quiet", FOLDER / "c.cqm", FOLDER / "d.obj")
        same(f"{name} to {kind} to obj", triangles(read_obj(FOLDER / "d.obj").faces), triangles(expected))
    return messages


# -- Shapes ------------------------------------------------------------------------------------------------------------

def cube(texcoords=True, normals=True, colors=False):
    """Six squares, each with the whole texture and a normal of its own."""
    faces = []
    for axis in range(3):
        for side in 0, 1:
            corners = []
            for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = [0, 0, 0]
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, s, t
                normal = tuple(float(2 * side - 1) if k == axis else 0.0 for k in range(3))
                corners.append(Corner(tuple(map(float, p)), normal if normals else None,
                                      (float(s), float(t)) if texcoords else None,
                                      tuple(float(x) for x in p) if colors else None))
            faces.append(Face(corners if side else corners[::-1], None, None, None))
    return faces


def sphere(rings=6, sectors=8):
    """With a seam of the texture from pole to pole; at the poles each triangle has its own texture coordinates."""
    def corner(i, j):
        latitude, longitude = math.pi * i / rings, 2 * math.pi * (j % sectors) / sectors
        p = (math.sin(latitude) * math.cos(longitude), math.sin(latitude) * math.sin(longitude), math.cos(latitude))
        p = (0.0, 0.0, math.cos(latitude)) if i in (0, rings) else p
        return Corner(tuple(round(x * 64) / 64 for x in p), None, (float(j), float(i)), None)

    faces = []
    for i in range(rings):
        for j in range(sectors):
            quad = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
            faces += [Face(quad[:3], None, None, None)] if i < rings - 1 else []
            faces += [Face([quad[0], quad[2], quad[3]], None, None, None)] if i > 0 else []
    return faces


def test_seams():
    for colors in False, True:
        faces = cube(colors=colors)
        messages = round_trip("cube.obj", obj_text(faces), fan(faces), quiet=True)
        check(f"only polygons are told: {messages}", messages.count("changed: faces with more than three corners (6)") == 1
              and messages.count("\n") == 1)
    for parts in ("normal",), ("texcoord",), ("normal", "texcoord"):
        faces = fan(without(cube(), *parts))
        round_trip("cube.obj", obj_text(faces), faces)
        round_trip("cube.obj", obj_text(faces, from_the_end=True), faces)
    faces = sphere()
    round_trip("sphere.obj", obj_text(faces), faces)
    cqm("encode", FOLDER / "sphere.obj", FOLDER / "s.cqm")
    report = json.loads(run("info", "--json", FOLDER / "s.cqm")[1])
    positions = len(read_obj(FOLDER / "sphere.obj").positions)
    check(f"the surface is one, whatever its texture: {report['components']}", report["components"] == 1)
    check(f"{report['vertices']} vertices, {positions} positions", report["vertices"] == positions)
    round_trip("sphere.obj", obj_text(faces), faces, options=["--clean"])
    cqm("encode", "--clean", FOLDER / "sphere.obj", FOLDER / "s.cqm")
    clean = json.loads(run("info", "--json", FOLDER / "s.cqm")[1])
    check(f"clean, {clean['base_vertices']} vertices of the base, {report['base_vertices']} without",
          clean["base_vertices"] > report["base_vertices"])


def test_parts_that_faces_do_not_have():
    """v, v/vt, v//vn, v/vt/vn side by side."""
    faces = fan(cube())
    for k, parts in enumerate((("normal", "texcoord"), ("normal",), ("texcoord",), ())):
        faces[3 * k:3 * k + 3] = without(faces[3 * k:3 * k + 3], *parts)
    source, stream, out = FOLDER / "parts.obj", FOLDER / "p.cqm", FOLDER / "p.obj"
    source.write_text(obj_text(faces))
    messages = cqm("encode", "--bits", "32", source, stream)
    check(f"nothing is told: {messages}", messages == "")
    cqm("verify", source)
    cqm("decode", stream, out)
    same("parts", triangles(read_obj(out).faces), triangles(faces))
    told = cqm("decode", stream, FOLDER / "p.ply")
    check(f"PLY cannot do that: {told}", "changed: faces without normals or texture coordinates get some" in told)
    mixed = obj_text(fan(cube())).replace("/1/1 ", " ", 1)
    source.write_text(mixed)
    messages = cqm("encode", source, stream)
    check(f"mixed: {messages}", messages.count("where only some corners of a face have one, the others get 0") == 2)
    cqm("verify", "--quiet", source)
    source.write_text(mixed.replace("vn 0", "vn nan", 1))
    messages = cqm("encode", source, stream)
    check(f"no number: {messages}", "dropped: normals of" in messages and "no finite numbers" in messages)
    source.write_text(obj_text(fan(cube())).replace("/1/1 ", "/1/99 "))
    messages = cqm("encode", source, stream)
    check(f"no such normal: {messages}", "dropped: normals of" in messages and "which do not exist" in messages)


NAMES = ["red", "dark  green", "usemtl", "#5", "na\\", "größe", "material_1", "a b c"]


def test_names():
    faces = fan(cube())
    for k, face in enumerate(faces):
        faces[k] = face._replace(material=NAMES[k % 8], group=NAMES[(k + 3) % 5], object="one" if k < 6 else "two")
    messages = round_trip("names.obj", obj_text(faces, head="mtllib a b.mtl\nmtllib c.mtl\n").replace("na\\\n", "na\\ \n"), faces)
    check(f"nothing to tell: {messages}", messages == "")
    cqm("encode", FOLDER / "names.obj", FOLDER / "n.cqm")
    cqm("decode", FOLDER / "n.cqm", FOLDER / "n.obj")
    found = read_obj(FOLDER / "n.obj")
    check("libraries", found.libraries == ["a b.mtl", "c.mtl"])
    check("few lines name materials", (FOLDER / "n.obj").read_text().count("\nusemtl ") == 8)
    cqm("decode", FOLDER / "n.cqm", FOLDER / "n.ply")
    told = cqm("decode", FOLDER / "n.cqm", FOLDER / "n.off")
    check(f"OFF has no names: {told}", all(f"dropped: {x}" in told for x in ("materials", "groups", "objects", "names of material")))
    cqm("decode", "--strict", FOLDER / "n.cqm", FOLDER / "strict.ply", status=1)
    cqm("decode", "--strict", FOLDER / "n.cqm", FOLDER / "strict.obj")
    check("PLY has them as textures", sorted(read_ply(FOLDER / "n.ply").textures) == sorted(NAMES))
    text = obj_text([face._replace(group="g\u00fc\U0001f4a9") for face in faces])
    (FOLDER / "wide.obj").write_bytes(text.encode("utf-16"))
    cqm("encode", FOLDER / "wide.obj", FOLDER / "w.cqm")
    cqm("decode", FOLDER / "w.cqm", FOLDER / "w.obj")
    check("names of UTF-16", {face.group for face in read_obj(FOLDER / "w.obj").faces} == {"g\u00fc\U0001f4a9"})
    one = [face._replace(group="g", object="o", material="m") for face in faces]
    round_trip("one.obj", obj_text(one), one)
    some = [face._replace(group=None if k % 3 else "g", object=None, material=None if k % 2 else "m") for k, face in enumerate(faces)]
    round_trip("some.obj", obj_text(some), some)
    source, stream = FOLDER / "names.obj", FOLDER / "n.cqm"
    cqm("encode", "--channels", "positions,normals", source, stream)
    cqm("decode", stream, FOLDER / "n.obj")
    same("no names are wanted", triangles(read_obj(FOLDER / "n.obj").faces),
         triangles(without(faces, "material", "group", "object", "texcoord")))
    text = obj_text(faces) + "usemtl unused\ng\n"
    round_trip("unused_name.obj", text.replace("na\\\n", "na\\ \n"), faces)
    long = [face._replace(group=f"{k} " + "x" * 100000) for k, face in enumerate(faces)]
    long[5] = without(long[5:6], "normal")[0]
    source.write_text(obj_text(long).replace("na\\\n", "na\\ \n"))
    messages = cqm("encode", source, stream)
    check(f"too long: {messages[:200]}", "dropped: names of materials, groups and objects, which have 1" in messages)
    cqm("decode", stream, FOLDER / "n.obj")
    found = {face.material for face in read_obj(FOLDER / "n.obj").faces}
    check(f"materials by number: {found}", found == {f"material_{k + 1}" for k in range(8)})
    check("a face without normals", sum(face.corners[0].normal is None for face in read_obj(FOLDER / "n.obj").faces) == 1)


def test_smoothing():
    """A group of all faces: corners of a cube point outwards. Two groups: their border is sharp."""
    faces = without(cube(), "normal", "texcoord")
    plain = obj_text(faces)
    third = 1 / math.sqrt(3)

    def normals(text):
        source, stream, out = FOLDER / "smooth.obj", FOLDER / "smooth.cqm", FOLDER / "smooth2.obj"
        source.write_text(text)
        messages = cqm("encode", "--bits", "normals=16,32", source, stream)
        cqm("decode", stream, out)
        return messages, [(c.position, c.normal) for face in read_obj(out).faces for c in face.corners]

    messages, found = normals(plain.replace("f ", "s 1\nf ", 1))
    check(f"told: {messages}", "dropped: smoothing groups, which became normals" in messages)
    check("outwards", len(found) == 36 and all(math.dist(n, [third if x else -third for x in p]) < 1e-4 for p, n in found))
    check("off", normals(plain.replace("f ", "s off\nf ", 1))[1][0][1] is None)
    check("behind", normals(plain + "s 1\n")[1][0][1] is None)
    lines = plain.splitlines()
    where = [k for k, line in enumerate(lines) if line.startswith("f ")]
    lines[where[4]] = "s 2\n" + lines[where[4]]
    lines[where[0]] = "s 1\n" + lines[where[0]]
    messages, found = normals("\n".join(lines) + "\n")
    half = math.sqrt(0.5)
    expected = [[half if x else -half for x in p[:2]] + [0] for p, _ in found]
    smooth = sum(math.dist(n, e) < 1e-4 for (_, n), e in zip(found, expected))
    check(f"four smooth sides, {smooth} corners", smooth == 24)
    check("flat top and bottom", sum(abs(abs(n[2]) - 1) < 1e-4 for _, n in found) == 12)
    messages, found = normals(plain.replace("f ", "s 1\nf ", 1).replace("\nf ", "\nvn 0 0 1\nf ", 1))
    check(f"there are normals: {messages}", "dropped: normals, which no face has" in messages)


def ply_text(faces, textures=(), quad=True):
    """Texture coordinates of corners, and texture numbers."""
    vertices = []
    rows = [[number(vertices, c.position) - 1 for c in face.corners] for face in faces]
    head = ["ply", "format ascii 1.0", *(f"comment TextureFile {t}" for t in textures), f"element vertex {len(vertices)}",
            "property double x", "property float y", "property float z", f"element face {len(faces)}",
            "property list uchar int vertex_indices", "property list uchar float texcoord", "property int texnumber", "end_header"]
    lines = [" ".join(map(str, p)) for p in vertices]
    for face, row in zip(faces, rows):
        texcoords = [x for c in face.corners if c.texcoord for x in c.texcoord]
        lines.append(" ".join(map(str, [len(row), *row, len(texcoords), *texcoords,
                                        textures.index(face.material) if face.material else -1])))
    return "\n".join(head + lines) + "\n"


def test_ply():
    faces = [face._replace(material=f"image {k % 2}.png") for k, face in enumerate(without(cube(), "normal"))]
    textures = ["image 0.png", "image 1.png"]
    messages = round_trip("textured.ply", ply_text(fan(faces), textures), fan(faces))
    check(f"nothing to tell: {messages}", messages == "")
    round_trip("quads.ply", ply_text(faces, textures), fan(faces), quiet=True)
    some = [face._replace(material=None) if k == 3 else face for k, face in enumerate(fan(faces))]
    some[5] = without(some[5:6], "texcoord")[0]
    round_trip("some.ply", ply_text(some, textures), some)
    source = FOLDER / "unnamed.ply"
    source.write_text("\n".join(line for line in ply_text(faces, textures).splitlines() if "comment" not in line) + "\n")
    cqm("encode", "--quiet", source, FOLDER / "u.cqm")
    cqm("decode", FOLDER / "u.cqm", FOLDER / "u.obj")
    found = {face.material for face in read_obj(FOLDER / "u.obj").faces}
    check(f"textures without names: {found}", found == {"material_0", "material_1"})


def test_concave():
    """The letter C in a plane: the triangles have its area and no other border."""
    outline = [(0, 0), (4, 0), (4, 1), (2, 1), (1, 1), (1, 3), (4, 3), (4, 4), (0, 4)]
    corners = [Corner((float(x), float(y), 2.0 * x - y), None, (float(x), float(y)), None) for x, y in outline]
    (FOLDER / "c.obj").write_text(obj_text([Face(corners, None, None, None)]))
    cqm("encode", "--bits", "32", FOLDER / "c.obj", FOLDER / "c.cqm")
    cqm("decode", FOLDER / "c.cqm", FOLDER / "c2.obj")
    found = read_obj(FOLDER / "c2.obj").faces
    flat = sum(abs(area(face)) < 1e-9 for face in found)
    total, whole = sum(map(area, found)), 10 * math.sqrt(6)
    check(f"{len(found)} triangles, {flat} flat, area {total} of {whole}", len(found) == 7 and flat == 0 and abs(total - whole) < 1e-9)


# -- Any triangles -----------------------------------------------------------------------------------------------------

def grid(n, height=lambda x, y: 0.0, at=(0, 0)):
    """Triangles of n * n squares with texture coordinates that follow the positions."""
    def corner(i, j):
        x, y = at[0] + i, at[1] + j
        return Corner((float(x), float(y), height(x, y)), None, (float(x), float(y)), None)

    squares = [[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)] for i in range(n) for j in range(n)]
    return [Face(c, None, None, None) for q in squares for c in ([q[0], q[1], q[2]], [q[0], q[2], q[3]])]


def moved(faces, change):
    return [face._replace(corners=[c._replace(position=change(*c.position)) for c in face.corners]) for face in faces]


def moebius(n=12):
    """A strip that meets itself upside down."""
    def corner(k, s):
        k, s = (k, s) if k < n else (0, 1 - s)
        a = 2 * math.pi * k / n
        r = 4 + (s - 0.5) * math.cos(a / 2)
        p = (r * math.cos(a), r * math.sin(a), (s - 0.5) * math.sin(a / 2))
        return Corner(tuple(round(64 * x) / 64 for x in p), None, None, None)

    return [Face(c, None, None, None) for k in range(n)
            for c in ([corner(k, 0), corner(k + 1, 0), corner(k + 1, 1)], [corner(k, 0), corner(k + 1, 1), corner(k, 1)])]


def test_any_triangles():
    flat = grid(4)
    turned = [f._replace(corners=f.corners[::-1]) if k % 3 == 0 else f for k, f in enumerate(flat)]
    wing = moved(grid(4), lambda x, y, z: (2.0, y, x + 1.0))
    fin = moved(grid(4), lambda x, y, z: (x, 2.0, z + y))
    back = [f._replace(corners=f.corners[::-1]) for f in flat]
    cases = {
        "moebius": moebius(), "turned": turned, "three_at_an_edge": flat + wing + fin, "two_sides": flat + back,
        "twice": flat + flat[5:9], "touching": flat + grid(3, at=(4, 4)), "soup": [random.choice(flat) for _ in range(60)],
        "lines": flat + [Face(f.corners[:k % 2 + 1], *f[1:]) for k, f in enumerate(flat)],
        "only_lines": [Face(f.corners[:k % 2 + 1], *f[1:]) for k, f in enumerate(flat)],
        "degenerate": flat + [Face([f.corners[0], f.corners[1], f.corners[0]], *f[1:]) for f in flat[::4]],
    }
    for name, faces in cases.items():
        round_trip(f"{name}.obj", obj_text(faces), faces)
    random.seed(5)
    points = [Corner((float(x), float(y), float(z)), None, (float(x), float(z)), None) for x in range(3) for y in range(3) for z in range(3)]
    for k in range(20):
        faces = [Face([random.choice(points) for _ in range(3)], random.choice(["a", "b"]), None, None) for _ in range(3 * k + 1)]
        round_trip(f"random{k}.obj", obj_text(faces), faces)


def test_unused_vertices():
    faces = grid(3)
    text = obj_text(faces, positions=[(9.0, 9.0, 9.0), (9.0, 9.0, 8.0)]) + "v 7 7 7\n"
    messages = round_trip("unused.obj", text, faces)
    check(f"told in one line: {messages}", "set aside: 3 unused vertices" in messages and messages.count("\n") == 1)
    cqm("encode", "--bits", "32", "--keep-order", FOLDER / "unused.obj", FOLDER / "u.cqm")
    cqm("decode", FOLDER / "u.cqm", FOLDER / "u.obj")
    check("all vertices, in order", read_obj(FOLDER / "u.obj").positions == read_obj(FOLDER / "unused.obj").positions)


def test_order():
    """Vertices of a mesh with seams come back in the order of the file."""
    for faces in (sphere(), fan(cube()), moebius()):
        random.seed(1)
        positions = list(dict.fromkeys(c.position for face in faces for c in face.corners))
        random.shuffle(positions)
        (FOLDER / "o.obj").write_text(obj_text(faces, positions=positions))
        cqm("encode", "--bits", BITS, "--keep-order", FOLDER / "o.obj", FOLDER / "o.cqm")
        cqm("decode", FOLDER / "o.cqm", FOLDER / "o2.obj")
        check("in order", read_obj(FOLDER / "o2.obj").positions == positions)
        same("in order", triangles(read_obj(FOLDER / "o2.obj").faces), triangles(faces))


def test_locked_borders():
    """Two tiles with one border: at each level both have all of its vertices."""
    def height(x, y):
        return 0.25 * ((x * 7 + y * 5) % 8)

    border = {(8.0, float(y), height(8, y)) for y in range(9)}
    for at in (0, 0), (8, 0):
        source, stream, out = FOLDER / "tile.obj", FOLDER / "tile.cqm", FOLDER / "tile2.obj"
        source.write_text(obj_text(without(grid(8, height, at), "texcoord")))
        cqm("encode", "--lock-border", "--grid", "0,0,0,0.25", source, stream)
        cqm("verify", "--lock-border", "--grid", "0,0,0,0.25", source)
        for level in range(20):
            cqm("decode", "--level", level, stream, out)
            check(f"the border at level {level}", border <= set(read_obj(out).positions))
        vertices = json.loads(run("info", "--json", stream)[1])["base_vertices"]
        check(f"the base is coarse: {vertices}", 32 <= vertices < 60)


TESTS = (test_seams, test_parts_that_faces_do_not_have, test_names, test_smoothing, test_ply, test_concave, test_any_triangles,
         test_unused_vertices, test_order, test_locked_borders)


if __name__ == "__main__":
    sys.exit(run_tests(FOLDER, TESTS))
