#!/usr/bin/env python3
"""What cqm keeps of mesh files beside positions, and what it says of the rest: channels.py CQM MESHGEN FOLDER

Meshes with normals, texture coordinates and colors go through encode and decode as PLY and OBJ. The last line is `N
passed, N failed`.   SPDX-License-Identifier: MIT"""

import json
import math
import pathlib
import struct
import subprocess
import sys

from checks import check, finish, run as cqm

MESHGEN, FOLDER = sys.argv[2], pathlib.Path(sys.argv[3])


# -- Meshes: dictionaries of lists -------------------------------------------------------------------------------------

def floats(*numbers):
    return struct.unpack(f"{len(numbers)}f", struct.pack(f"{len(numbers)}f", *numbers))


def make():
    """A torus with attributes that follow its positions, and colors of 8 bits."""
    lines = subprocess.run([MESHGEN, "torus", "14", "9"], capture_output=True, check=True).stdout.decode().split("\n")
    count = int(lines[1].split()[0])
    mesh = {"positions": [floats(*map(float, line.split())) for line in lines[2:2 + count]],
            "faces": [tuple(map(int, line.split()[1:])) for line in lines[2 + count:] if line]}
    mesh["positions"][5] = floats(-0.0, 1e-40, mesh["positions"][5][2])
    mesh["normals"] = [floats(*(x / math.hypot(*p, 1e-3) for x in p[:2]), 0.5) for p in mesh["positions"]]
    mesh["texcoords"] = [floats(v / count, (v * 7 % count) / count * 2 - 0.5) for v in range(count)]
    mesh["colors"] = [tuple((v * k % 256) / 255 for k in (1, 3, 5)) for v in range(count)]
    return mesh


def write_ply(path, mesh, alpha=False, extra=False):
    head = ["ply", "format binary_big_endian 1.0", f"element vertex {len(mesh['positions'])}"]
    head += [f"property float {x}" for x in ("x", "y", "z", "nx", "ny", "nz")]
    head += ["property uchar confidence"] if extra else []
    head += [f"property uchar {x}" for x in ("red", "green", "blue") + (("alpha",) if alpha else ())]
    head += ["property double u", "property double v"]
    head += [f"element face {len(mesh['faces'])}", "property list uchar int vertex_indices", "end_header"]
    data = b""
    for p, n, c, t in zip(mesh["positions"], mesh["normals"], mesh["colors"], mesh["texcoords"]):
        data += struct.pack(">6f", *p, *n) + (b"\7" if extra else b"")
        data += bytes(round(255 * x) for x in c) + (b"\x80" if alpha else b"") + struct.pack(">2d", *t)
    data += b"".join(struct.pack(">B3i", 3, *f) for f in mesh["faces"])
    path.write_bytes("\n".join(head).encode() + b"\n" + data)


def write_obj(path, mesh, texcoords=None, corner="{0}/{0}/{0}"):
    """texcoords: lines instead of those of the mesh. corner: of a face, given the number of a vertex."""
    lines = ["# by hand"]
    lines += ["v %.9g %.9g %.9g %.9g %.9g %.9g" % (*p, *c) for p, c in zip(mesh["positions"], mesh["colors"])]
    lines += ["vt %.9g %.9g 0" % t for t in mesh["texcoords"]] if texcoords is None else texcoords
    lines += ["vn %.9g %.9g %.9g" % n for n in mesh["normals"]]
    lines += ["f " + " ".join(corner.format(v + 1) for v in f) for f in mesh["faces"]]
    path.write_text("\n".join(lines) + "\n")


def read_ply(path):
    """As cqm writes it."""
    head, data = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    properties = [(words[2], "f" if words[1] == "float" else "B") for words in lines
                  if words[0] == "property" and words[1] != "list"]
    counts = [int(words[2]) for words in lines if words[0] == "element"]
    row = struct.Struct("<" + "".join(kind for _, kind in properties))
    mesh = {"faces": []}
    rows = [dict(zip((name for name, _ in properties), row.unpack_from(data, k * row.size))) for k in range(counts[0])]
    for name, parts in (("positions", "xyz"), ("normals", ("nx", "ny", "nz")), ("texcoords", "st"),
                        ("colors", ("red", "green", "blue")), ("alpha", ("alpha",))):
        if rows and all(part in rows[0] for part in parts):
            unit = 255 if name in ("colors", "alpha") else 1
            mesh[name] = [tuple(r[part] / unit for part in parts) for r in rows]
    for k in range(counts[1]):
        mesh["faces"].append(struct.unpack_from("<B3I", data, counts[0] * row.size + 13 * k)[1:])
    return mesh


def read_obj(path):
    mesh = {"positions": [], "colors": [], "texcoords": [], "normals": [], "faces": [], "materials": []}
    material = None
    for words in map(str.split, path.read_text().splitlines()):
        numbers = tuple(map(float, words[1:])) if words[0] not in ("f", "usemtl") else ()
        if words[0] == "usemtl":
            material = " ".join(words[1:])
        elif words[0] == "v":
            mesh["positions"].append(numbers[:3])
            mesh["colors"] += [numbers[3:]] if len(numbers) > 3 else []
        elif words[0] == "f":
            corners = [corner.split("/") for corner in words[1:]]
            check("a vertex without seams has one number in OBJ", all(x in ("", c[0]) for c in corners for x in c))
            mesh["faces"].append(tuple(int(c[0]) - 1 for c in corners))
            mesh["materials"].append(material)
        else:
            mesh[{"vt": "texcoords", "vn": "normals"}[words[0]]].append(numbers)
    return {name: values for name, values in mesh.items() if values}


# -- Comparing ---------------------------------------------------------------------------------------------------------

def turned(face):
    first = face.index(min(face))
    return face[first:] + face[:first]


def bits(rows):
    return [struct.pack(f"{len(row)}f", *row) for row in rows]


def far(rows, others):
    """The largest distance between numbers, or infinity."""
    if len(rows) != len(others):
        return math.inf
    return max(abs(a - b) for x, y in zip(rows, others) for a, b in zip(x, y))


def angle(n, m):
    return math.acos(min(1, sum(a * b for a, b in zip(n, m)) / math.hypot(*n) / math.hypot(*m)))


def check_mesh(name, mesh, found):
    """In the order of the file, positions bit for bit."""
    check(name + ": positions", bits(found["positions"]) == bits(mesh["positions"]))
    check(name + ": faces", sorted(map(turned, found["faces"])) == sorted(map(turned, mesh["faces"])))
    check(name + ": normals", max(map(angle, mesh["normals"], found["normals"])) < 2.122 / 511 + 1e-6)
    check(name + ": texture coordinates", far(mesh["texcoords"], found["texcoords"]) <= 0.501 * 2 / 4095)
    check(name + ": colors", far(mesh["colors"], found["colors"]) < 1e-7)


# -- The tests ---------------------------------------------------------------------------------------------------------

def test_all_channels(mesh):
    for kind, write in ("ply", write_ply), ("obj", write_obj):
        for out_kind, read in ("ply", read_ply), ("obj", read_obj):
            source, stream, out = FOLDER / f"a.{kind}", FOLDER / "a.cqm", FOLDER / f"b.{out_kind}"
            write(source, mesh)
            messages, _ = cqm("encode", "--bits", 32, "--keep-order", source, stream)
            check(f"{kind}: nothing dropped: {messages}", not messages)
            messages, _ = cqm("decode", stream, out)
            check(f"{kind} to {out_kind}: nothing dropped: {messages}", not messages)
            check_mesh(f"{kind} to {out_kind}", mesh, read(out))
            cqm("verify", "--keep-order", "--goal", "least-connectivity", source)


def test_alpha(mesh):
    source, stream = FOLDER / "alpha.ply", FOLDER / "alpha.cqm"
    write_ply(source, mesh, alpha=True)
    cqm("encode", "--keep-order", source, stream)
    cqm("decode", stream, FOLDER / "alpha2.ply")
    check("alpha", read_ply(FOLDER / "alpha2.ply")["alpha"] == [(128 / 255,)] * len(mesh["positions"]))
    messages, _ = cqm("decode", stream, FOLDER / "alpha.obj")
    check("alpha is not for OBJ", "color" in messages and "alpha" in messages)
    check("colors without alpha", far(mesh["colors"], read_obj(FOLDER / "alpha.obj")["colors"]) < 1e-7)


def test_choice(mesh):
    source, stream, out = FOLDER / "c.ply", FOLDER / "c.cqm", FOLDER / "d.ply"
    write_ply(source, mesh)
    for names in ("positions", "normals", "texcoords,colors", "colors,positions,normals"):
        messages, _ = cqm("encode", "--channels", names, source, stream)
        cqm("decode", "--quiet", stream, out)
        wanted = set(names.split(",")) | {"faces", "positions"}
        told = "dropped: positions, which --channels does not list" in messages
        check(f"{names}: {messages}", told == ("positions" not in names) and messages.count("\n") == told)
        check(f"{names}: only these", set(read_ply(out)) == wanted)
    cqm("encode", "--connectivity", source, stream)
    check("connectivity", cqm("info", stream)[1].count("channel ") == 0)
    for names in ("", "normal", "positions,", ",positions", "positions normals"):
        cqm("encode", "--channels", names, source, stream, status=2)
    cqm("encode", "--bits", 25, source, stream, status=2)
    cqm("encode", "--bits", 31, source, stream, status=2)


def distance(point, triangle):
    """Of a point from a triangle."""
    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))

    def less(a, b):
        return tuple(x - y for x, y in zip(a, b))

    def from_segment(a, b):
        along, to = less(b, a), less(point, a)
        t = min(1, max(0, dot(to, along) / dot(along, along))) if dot(along, along) else 0
        return math.dist(to, tuple(t * x for x in along))

    a, b, c = triangle
    u, v, w = less(b, a), less(c, a), less(point, a)
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)
    area = uu * vv - uv * uv
    if area > 1e-12 * uu * vv:
        s, t = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
        if s >= 0 and t >= 0 and s + t <= 1:
            return math.dist(w, tuple(s * x + t * y for x, y in zip(u, v)))
    return min(from_segment(a, b), from_segment(b, c), from_segment(c, a))


def farthest(points, mesh):
    """Distance of the farthest of the points from a mesh."""
    triangles = [[mesh["positions"][v] for v in face] for face in mesh["faces"]]
    return max(min(distance(p, t) for t in triangles) for p in points)


def test_error(mesh):
    """Decoding stops where a level's error is small enough, and no exact vertex is further away than that."""
    source, stream, out = FOLDER / "e.ply", FOLDER / "e.cqm", FOLDER / "e2.ply"
    write_ply(source, mesh)
    cqm("encode", "--conquest-only", "--channels", "positions", source, stream)
    cqm("decode", stream, out)
    exact = read_ply(out)["positions"]
    report = json.loads(cqm("info", "--json", stream)[1])
    step = report["channels"][0]["step"]
    levels = report["per_level"]
    errors = [level["error_before"] for level in levels]
    check(f"errors never grow: {errors}", errors == sorted(errors, reverse=True) and len(set(errors)) > 3)
    vertices = [report["base_vertices"]] + [level["vertices"] for level in levels]
    for error in sorted(set(errors)):
        for wanted in error * step * (1 + 1e-6), error * step * (1 - 1e-6):
            cqm("decode", "--error", wanted, stream, out)
            found = read_ply(out)
            level = next((k for k, e in enumerate(errors) if e * step <= wanted), len(levels))
            check(f"--error {wanted}: level {level}", len(found["positions"]) == vertices[level])
            check(f"--error {wanted}: {farthest(exact, found)}", farthest(exact, found) <= wanted + 1e-6)
    cqm("decode", "--error", 0, stream, out)
    check("no error", len(read_ply(out)["positions"]) == len(exact))
    cqm("decode", "--error", 1e9, "--vertices", 1, stream, out)
    check("any error", len(read_ply(out)["positions"]) == vertices[0])
    check("the table has the errors", f"{errors[0]:.2f}" in cqm("info", stream)[1])
    for wrong in ("-1", "nan", "inf", "", "1x"):
        cqm("decode", "--error", wrong, stream, out, status=2)
    for options in (["--connectivity"], ["--bits", 32]):
        cqm("encode", *options, source, stream)
        out.unlink(missing_ok=True)
        messages, _ = cqm("decode", "--error", 1, stream, out, status=1)
        check(f"no errors: {messages}", "does not tell how far" in messages and not out.exists())
        check("no errors in JSON", json.loads(cqm("info", "--json", stream)[1])["per_level"][0]["error_before"] is None)


def test_order_of_coarse_meshes(mesh):
    """Each vertex of a coarse mesh is one of the file, in its order."""
    source, stream, out = FOLDER / "o.ply", FOLDER / "o.cqm", FOLDER / "o2.ply"
    write_ply(source, mesh)
    cqm("encode", "--bits", 32, "--keep-order", source, stream)
    place = {packed: v for v, packed in enumerate(bits(mesh["positions"]))}
    for n in (20, 50, 80, 110):
        cqm("decode", "--vertices", n, stream, out)
        numbers = [place.get(packed, -1) for packed in bits(read_ply(out)["positions"])]
        check(f"{n} vertices of the file", len(numbers) == n and numbers[0] >= 0 and numbers == sorted(set(numbers)))


def write_materials(path, mesh, names):
    """names: of the material of each face, None for none, which only the first ones can have."""
    write_obj(path, mesh)
    lines, named, k = [], None, 0
    for line in path.read_text().splitlines():
        if line.startswith("f "):
            lines += [f"usemtl {names[k]}"] if names[k] != named else []
            named = names[k]
            k += 1
        lines.append(line)
    path.write_text("\n".join(lines) + "\n")


def materials(mesh):
    return sorted((turned(face), str(name)) for face, name in zip(mesh["faces"], mesh["materials"]))


def test_materials(mesh):
    source, stream, out = FOLDER / "m.obj", FOLDER / "m.cqm", FOLDER / "n.obj"
    kinds = ["red", "dark  green", "red light", "usemtl", "#5"]
    names = [None] * 7 + [kinds[(k // 5 + k % 2) % 5] for k in range(len(mesh["faces"]) - 7)]
    write_materials(source, mesh, names)
    messages, _ = cqm("encode", "--bits", 32, "--keep-order", source, stream)
    check(f"names are kept: {messages}", messages == "")
    counts = json.loads(cqm("info", "--json", stream)[1])
    check("ranges of faces: five, and one without", counts["materials"] == 6 and "group" not in {c["kind"] for c in counts["channels"]})
    messages, _ = cqm("decode", stream, out)
    check(f"materials are written: {messages}", not messages)
    check_mesh("with materials", mesh, read_obj(out))
    check("materials", materials(read_obj(out)) == materials(dict(mesh, materials=[name and " ".join(name.split()) for name in names])))
    check("few lines name them", out.read_text().count("usemtl ") == 5)
    check("double blanks stay", "usemtl dark  green\n" in out.read_text())
    cqm("encode", "--bits", 32, "--keep-order", out, FOLDER / "again.cqm")
    cqm("decode", FOLDER / "again.cqm", FOLDER / "again.obj")
    again = materials(read_obj(FOLDER / "again.obj"))
    check("materials again", again == materials(read_obj(out)))
    cqm("verify", source)
    cqm("decode", "--vertices", 40, stream, out)
    numbered = {f"material_{k + 1}" for k in range(6)}
    check(f"coarse, without names: {set(read_obj(out)['materials'])}", set(read_obj(out)["materials"]) <= numbered)
    messages, _ = cqm("decode", stream, FOLDER / "m.ply")
    check(f"PLY has them as textures: {messages}", messages == "" and b"comment TextureFile dark  green\n" in (FOLDER / "m.ply").read_bytes())
    messages, _ = cqm("decode", stream, FOLDER / "m.off")
    check(f"OFF has no materials: {messages}", "dropped: materials of the stream" in messages)
    cqm("encode", "--channels", "positions", source, stream)
    cqm("decode", stream, out)
    check("materials are not wanted", "usemtl" not in out.read_text())
    cqm("encode", "--channels", "materials", source, stream)
    counts = json.loads(cqm("info", "--json", stream)[1])
    check("materials alone", counts["materials"] == 6 and not counts["channels"])
    write_obj(source, mesh)
    source.write_text(source.read_text() + "usemtl red\n")
    messages, _ = cqm("encode", source, stream)
    check(f"no face has the material: {messages}", not messages and "materials" not in cqm("info", stream)[1])


def test_what_is_told(mesh):
    obj, ply, stream = FOLDER / "g.obj", FOLDER / "g.ply", FOLDER / "g.cqm"

    def told(source, *words):
        messages, _ = cqm("encode", source, stream)
        check(f"{source.name}: {messages} has {words}", all(word in messages for word in words))
        check("quiet", cqm("encode", "--quiet", source, stream)[0] == "")
        check("not wanted", cqm("encode", "--channels", "positions", source, stream)[0] == "")
        return json.loads(cqm("info", "--json", stream)[1])

    count = len(mesh["positions"])
    seam = ["vt %d 0" % k for k in range(count + 1)]
    write_obj(obj, mesh, seam)
    text = obj.read_text().replace("f 1/1/1 ", f"f 1/{count + 1}/1 ", 1)
    check("a seam", text != obj.read_text())
    obj.write_text(text)
    check("a seam is kept", cqm("encode", "--strict", obj, stream)[0] == "")
    check("it has a row", json.loads(cqm("info", "--json", stream)[1])["rows"] == count + 1)
    write_obj(obj, mesh, seam, corner="{0}//{0}")
    told(obj, "dropped: texture coordinates, which no face has")
    write_obj(obj, mesh, seam, corner="{0}/99999/{0}")
    told(obj, f"dropped: texture coordinates of {3 * len(mesh['faces'])} corners, which do not exist")
    write_obj(obj, mesh)
    obj.write_text(obj.read_text().replace("f ", "vp 1 2\nf ", 1))
    told(obj, "dropped: lines that are not read: 1 'vp'")
    write_obj(obj, dict(mesh, colors=[(2, 0, 0)] + mesh["colors"][1:]))
    told(obj, "dropped: colors: vertex 0 has one outside 0 .. 1")
    write_obj(obj, mesh)
    lines = obj.read_text().split("\n")
    lines[7] = " ".join(lines[7].split()[:4])
    obj.write_text("\n".join(lines))
    told(obj, "dropped: colors: vertex 6 has none")
    write_ply(ply, mesh, extra=True)
    told(ply, "dropped: properties of element 'vertex': 'confidence'")
    write_ply(ply, dict(mesh, normals=[(math.nan, 0, 0)] + mesh["normals"][1:]))
    told(ply, "dropped: normals: vertex 0 has none, or one that is not finite")
    write_ply(ply, dict(mesh, normals=[(1, 0, 0), (0, 0, 0)] + mesh["normals"][2:]))
    messages, _ = cqm("encode", ply, stream)
    check(f"a normal of no length: {messages}", "changed: normals without a length (1) became 0 0 1" in messages)
    write_ply(ply, mesh)
    told_channels = [(c["kind"], c["merge"], c["components"], c["bits"]) for c in told(ply)["channels"]]
    check("positions alone", told_channels == [("position", "average", 3, 12)])
    cqm("encode", "--keep-order", ply, stream)
    told_channels = [(c["kind"], c["merge"], c["components"], c["bits"])
                     for c in json.loads(cqm("info", "--json", stream)[1])["channels"]]
    check(f"all channels: {told_channels}", told_channels == [
        ("position", "average", 3, 12), ("normal", "average", 2, 10), ("texcoord", "average", 2, 12),
        ("color", "average", 3, 8), ("number", "copy", 1, 7)])
    messages, _ = cqm("decode", stream, FOLDER / "g.off")
    check(f"OFF holds no attributes: {messages}", messages.count("dropped: ") == 3)
    check("quiet decoding", cqm("decode", "--quiet", stream, FOLDER / "g.off")[0] == "")


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    mesh = make()
    for test in (test_all_channels, test_alpha, test_choice, test_error, test_order_of_coarse_meshes, test_materials,
                 test_what_is_told):
        test(mesh)
    return finish()


if __name__ == "__main__":
    sys.exit(main())
