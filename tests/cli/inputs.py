#!/usr/bin/env python3
"""Files as people publish them, and commands as they are typed: what cqm reads, refuses and says. inputs.py CQM FOLDER

Each input is written here and encoded; what is decoded is compared with the mesh that the input means. The last line is
`N passed, N failed`.   SPDX-License-Identifier: MIT"""

import itertools
import json
import math
import os
import pathlib
import struct
import subprocess
import sys

from checks import CQM, check, run, run_tests

FOLDER = pathlib.Path(sys.argv[2])

# A tetrahedron. Each coordinate is 0 or 1, so that all formats hold it.
POSITIONS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
CUT = "changed: faces with more than three corners (1) are cut into triangles"


def cqm(*arguments, status=0):
    """What is said on standard error; the exit status must be as told."""
    return run(*arguments, status=status)[0]


def write(name, content):
    path = FOLDER / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def read_off(path):
    lines = path.read_text().splitlines()
    count = int(lines[1].split()[0])
    rows = [tuple(map(float, line.split())) for line in lines[2:2 + count]]
    return rows, [tuple(map(int, line.split()[1:])) for line in lines[2 + count:]]


def floats(point):
    return struct.unpack("3f", struct.pack("3f", *point))


def corners(positions, faces):
    """The mesh as a set of triangles of positions: STL has its own order of vertices."""
    return sorted(min(points[k:] + points[:k] for k in range(len(points)))
                  for points in ([positions[v] for v in face] for face in faces))


def reads(name, content, positions=None, faces=None, says=(), tells=(), options=()):
    """The input means this mesh, and only so many things are said of it; those that it tells are no losses."""
    source, stream, out = write(name, content), FOLDER / "a.cqm", FOLDER / "a.off"
    messages = cqm("encode", "--bits", "32", "--keep-order", *options, source, stream)
    check(f"{name}: said {messages!r}, not {says} {tells}",
          messages.count("\n") == len(says) + len(tells) and all(word in messages for word in (*says, *tells)))
    cqm("encode", "--strict", "--quiet", "--bits", "32", *options, source, FOLDER / "s.cqm", status=1 if says else 0)
    cqm("decode", "--quiet", stream, out)
    found = read_off(out)
    found = list(map(floats, found[0])), found[1]
    positions = list(map(floats, POSITIONS if positions is None else positions))
    faces = FACES if faces is None else faces
    check(f"{name}: the same triangles", corners(*found) == corners(positions, faces))
    if not name.endswith(".stl"):
        check(f"{name}: the same order", positions == found[0])
    check(f"{name}: {len(found[0])} vertices", len(found[0]) == len(positions))


def refuses(name, content, *says):
    source, stream = write(name, content), FOLDER / "refused.cqm"
    stream.unlink(missing_ok=True)
    messages = cqm("encode", source, stream, status=1)
    check(f"{name}: {messages!r} has {says}", all(word in messages for word in says) and messages.count("\n") == 1)
    check(f"{name}: no stream", not stream.exists())


# -- STL ---------------------------------------------------------------------------------------------------------------

def binary_stl(comment=b"exported", count=4, attribute=b"\0\0", behind=b""):
    data = comment.ljust(80) + struct.pack("<I", count)
    for face in FACES:
        data += struct.pack("<12f", 0, 0, 0, *(x for v in face for x in POSITIONS[v])) + attribute
    return data + behind


def text_stl(name="part", faces=None, end="endsolid part\n", normal="0 0 1"):
    text = f"solid {name}\n"
    for face in FACES if faces is None else faces:
        text += f"facet normal {normal}\nouter loop\n"
        text += "".join("vertex %g %g %g\n" % POSITIONS[v] for v in face) + "endloop\nendfacet\n"
    return text + end


def test_binary_stl():
    reads("plain.stl", binary_stl())
    reads("begins_with_solid.stl", binary_stl(b"solid part1"))
    reads("solid_facet.stl", binary_stl(b"solid part1 facet normal endsolid\n"))
    reads("behind.stl", binary_stl(behind=b"made by hand"), says=["dropped: 12 bytes behind the last triangle"])
    reads("solid_behind.stl", binary_stl(b"solid x", behind=b"\0" * 50), says=["dropped: 50 bytes behind"])
    reads("count_zero.stl", binary_stl(count=0), says=["changed: the file says that it has 0 triangles; read the 4"])
    reads("solid_count_zero.stl", binary_stl(b"solid part", 0), says=["changed: the file says that it has 0"])
    reads("color.stl", binary_stl(b"COLOR=\1\2\3\4", attribute=b"\x12\x80"),
          says=["dropped: attributes of 4 faces, which may be colors"])
    reads("payload.stl", binary_stl(attribute=b"\4\0abcd"), says=["dropped: attributes of 4 faces"])
    reads("solid_payload.stl", binary_stl(b"solid", attribute=b"\1\0x"), says=["dropped: attributes of 4 faces"])
    reads("color_of_all.stl", binary_stl(b"COLOR=\xff\0\0\xff"), says=["dropped: the color that the comment tells"])
    messages = cqm("encode", "--channels", "positions", FOLDER / "count_zero.stl", FOLDER / "a.cqm")
    check(f"told also of positions alone: {messages}", "changed: " in messages)
    reads("one_behind.stl", binary_stl(behind=b"x"), says=["dropped: 1 byte behind the last triangle"])
    reads("empty.stl", b"nothing".ljust(80) + struct.pack("<I", 0), [], [])
    refuses("too_many.stl", binary_stl(count=5), "the file says that it has 5 triangles, and ends before")
    refuses("solid_too_many.stl", binary_stl(b"solid", count=1000), "1000 triangles, and ends before")
    refuses("zero_and_more.stl", binary_stl(count=0, behind=b"x"), "0 triangles, and does not end there")
    refuses("short.stl", binary_stl()[:83], "not an STL file")


def test_text_stl():
    plain = text_stl()
    reads("text.stl", plain)
    for name, end in ("crlf", "\r\n"), ("cr", "\r"), ("one_line", " "), ("tabs", "\t"), ("blank_lines", "\n\n \r\n"):
        reads(f"{name}.stl", plain.replace("\n", end))
    reads("upper_case.stl", plain.upper())
    reads("mark.stl", b"\xef\xbb\xbf" + plain.encode())
    for name in ("", "vertex shell", "facet", "outer loop", "solid endloop", "a facet of vertex 1 2 3", "#5", "\xe9t\xe9", "a\0b"):
        reads("name.stl", text_stl(name))
        reads("name_in_one_line.stl", text_stl(name).replace("\n", " "))
    for end in ("endsolid", "endsolid vertex facet 7", "endsolid\n\n", "end solid", "endsolid solid part"):
        reads("end.stl", text_stl(end=end))
    cut = ["dropped: the end of the file, which may have had more faces: there is no 'endsolid'"]
    for end in "endloop\nendfacet\n", "endfacet\n", "":
        reads("no_end.stl", text_stl(end="")[:-len(end) or None], says=cut)
    for end in "facet", "facet normal 0 0 1", "facet normal 0 0 1\nouter loop\n":
        refuses("cut_facet.stl", text_stl(end=end), "the file ends inside face 4")
    reads("zeros_behind.stl", plain + "\0\0", says=["dropped: words outside of solids and facets, the first in line 31"])
    reads("words_behind.stl", plain + "hello\n", says=["dropped: words outside of solids and facets, the first in line 31"])
    reads("words_before.stl", plain.replace("\n", "\ncolor 1 0 0\n", 1), says=["dropped: words outside of solids and facets, the first in line 2"])
    reads("facets_behind.stl", text_stl("a", FACES[:2], "endsolid a\n") + text_stl("b", FACES[2:]).split("\n", 1)[1],
          says=["dropped: which of 2 solids"])
    refuses("no_solid.stl", plain.split("\n", 1)[1], "text without 'solid' at the start")
    reads("end_loop.stl", plain.replace("endloop", "end loop").replace("endfacet", "end facet"))
    for normal in ("nan nan nan", "-nan(ind) 0 0", "1e999 0 0"):
        reads("normal.stl", text_stl(normal=normal))
    reads("no_normal.stl", plain.replace(" normal 0 0 1", ""))
    reads("two.stl", text_stl("a", FACES[:2], "endsolid a\n") + text_stl("b", FACES[2:]), says=["dropped: which of 2 solids"])
    refuses("cut.stl", text_stl(end="")[:-len("vertex 0 1 0\nendloop\nendfacet\n")], "the file ends inside face 3")
    refuses("cut_number.stl", text_stl(end="")[:-len("1 0\nendloop\nendfacet\n")], "number expected")
    refuses("nothing.stl", "solid x\nendsolid x\n", "the file has no triangles")
    refuses("only_solid.stl", "solid", "the file has no triangles")
    refuses("word.stl", plain.replace("outer", "inner"), "unknown STL word 'inner'")
    refuses("prose.stl", "solid state physics " * 20, "no triangles")
    square = "solid\nfacet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} 0\n" for x, y in SQUARE) + "endloop\nendfacet\nendsolid"
    reads("quad.stl", square, [(x, y, 0) for x, y in SQUARE], [(0, 1, 2), (0, 2, 3)], says=[CUT])
    reads("utf16.stl", plain.encode("utf-16"))


# -- OBJ ---------------------------------------------------------------------------------------------------------------

def obj(number=str, end="\n", extra=""):
    return "".join("v %s %s %s%s%s" % (*map(number, p), extra, end) for p in POSITIONS) + "".join(
        "f %d %d %d%s" % (*(v + 1 for v in face), end) for face in FACES)


def test_obj():
    plain = obj()
    reads("plain.obj", plain)
    reads("mark.obj", b"\xef\xbb\xbf" + plain.encode())
    for encoding in "utf-16", "utf-16-le", "utf-16-be":
        reads(f"{encoding}.obj", ("# na\u00efve \u20ac \U0001f4a9\n" + plain).encode(encoding))
        reads("half.obj", plain.encode(encoding) + b"\n")
    refuses("utf-32.obj", plain.encode("utf-32"), "UTF-32")
    for name, end in ("crlf", "\r\n"), ("cr", "\r"), ("blank", " \t\n"), ("page", "\f\n"):
        reads(f"{name}.obj", obj(end=end))
    reads("mixed.obj", plain.replace("\n", "\r", 2).replace("\n", "\r\n", 3))
    reads("no_last_end.obj", plain[:-1])
    reads("end_of_dos.obj", plain + "\x1a")
    for end in "\n", "\r\n", "\r":
        reads("continued.obj", plain.replace("f 1 3 2", f"f 1 \\{end} 3\\{end}2").replace("v 1 0 0", f"v 1 0 \\{end}0"))
    reads("backslash_in_comment.obj", "# C:\\meshes\\\n" + plain)
    reads("backslash_at_the_end.obj", plain[:-1] + "\\")
    zeros = "0" * 300
    for name, number in (("long", lambda x: f"{zeros}{x}.{zeros}"), ("exponent", lambda x: f"{x}e-0"),
                         ("large_exponent", lambda x: f"{x}{zeros}E-300"), ("plus", lambda x: f"+{x}."),
                         ("minus", lambda x: "1" if x else "-0.0"), ("point", lambda x: "1" if x else ".0"),
                         ("small", lambda x: f"0.{zeros}{x}e301")):
        reads(f"{name}.obj", obj(number))
    reads("digits.obj", obj(lambda x: f"{x}.{'3' * 300}"), [tuple(x + 1 / 3 for x in p) for p in POSITIONS],
          says=["changed: positions: exact means the nearest 32-bit floats"])
    for bad in "nan", "inf", "0x1p0", "1,5", "1.0.0", "1e", "1e+", "--1", "", "1f", "1e99":
        refuses("number.obj", plain.replace("v 1 0 0", f"v {bad} 0 0").replace("v  0 0", "v 0 0"), "line 2")
    reads("from_the_end.obj", "".join("v %d %d %d\n" % p for p in POSITIONS) +
          "".join("f %d %d %d\n" % tuple(v - 4 for v in face) for face in FACES))
    reads("degenerate.obj", plain + "f 1 1 2\n", faces=FACES + [(0, 0, 1)], tells=["set aside: 1 face without area"])
    reads("repeated.obj", plain + "f 2 1 3\n", faces=FACES + [(1, 0, 2)], tells=["set aside: 1 repeated face"])
    reads("unused.obj", plain + "v 0 0 7\nv 0 0 8\n", POSITIONS + [(0, 0, 7), (0, 0, 8)],
          tells=["set aside: 2 unused vertices"])
    reads("three_faces.obj", plain + "v 0 0 2\nf 1 2 5\n", POSITIONS + [(0, 0, 2)], FACES + [(0, 1, 4)], tells=["cut"])
    bow_tie = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    reads("bow_tie.obj", "".join("v %d %d %d\n" % p for p in bow_tie) + "f 1 2 3\nf 1 4 5\n", bow_tie,
          [(0, 1, 2), (0, 3, 4)], tells=["1 vertex copied"])
    square = [(x, y, 0) for x, y in SQUARE]
    reads("quad.obj", "".join("v %d %d %d\n" % p for p in square) + "f 1 2 3 4\n", square, [(0, 1, 2), (0, 2, 3)],
          says=[CUT])
    lines = [(0, 1), (1, 2), (2, 3), (3,), (3, 0)]
    reads("lines.obj", plain + "l 1 2 3 4\np 4\nf 4 1\n", faces=FACES + lines, tells=["set aside: 5 faces without area"])
    reads("only_lines.obj", plain.replace("f ", "l "), faces=[(0, 2), (2, 1), (0, 1), (1, 3), (1, 2), (2, 3), (0, 3), (3, 2)],
          tells=["set aside: 8 faces without area"])
    continued = "dropped: lines behind names that end in a backslash (1)"
    for word in "usemtl", "g", "o", "mtllib":
        reads("name.obj", plain.replace("f", f"{word} C:\\\nf", 1), faces=FACES[1:], says=[continued])
        reads("name.obj", plain.replace("f", f"{word} C:\\\n\nf", 1))
        reads("name.obj", plain + f"{word} C:\\")
    refuses("no_corner.obj", plain.replace("f ", "f # "), "no face has a corner")
    refuses("short_line.obj", plain + "l 1\n", "a line with 1 corner (line 9)")
    mark = b"\xef\xbb\xbf"
    reads("two_marks.obj", mark + mark + plain.encode())
    reads("marks.obj", mark + plain.encode().replace(b"v 1", mark + b"v 1").replace(b"f 1 3", b"f" + mark + b"1 3"))
    for glued in "v1 0 0", "v-1 0 0", "v.5 0 0":
        refuses("glued.obj", plain.replace("v 1 0 0", glued) + "v 9 9 9\n", f"'{glued.split()[0]}' lacks a blank", "(line 2)")
    refuses("glued_face.obj", plain + "f1 2 3\n", "'f1' lacks a blank", "(line 9)")
    refuses("glued_item.obj", plain + "vt0 2\n", "'vt0' lacks a blank", "(line 9)")


def test_what_obj_has_and_a_stream_has_not():
    plain = obj()
    reads("w_is_1.obj", obj(extra=" 1.0"))
    reads("w.obj", obj(extra=" 2"), says=["dropped: w, the fourth coordinate"])
    reads("alpha.obj", obj(extra=" 1 0 0 0.5"), says=["dropped: alpha of colors"])
    other = "dropped: words that mean nothing behind 'v', 'vt' or 'vn' ({})"
    for extra in " 0.5 0.5", " a", " 1 a", " a b c", " 1 0 0 a", " 1 0 0 # no color\n#", " 1 0 0 1 7":
        says = [other.format(4)] if "#" not in extra else []
        reads("others.obj", obj(extra=extra), says=[*says, *(["dropped: alpha"] if extra.endswith("7") else [])])
    messages = cqm("encode", "--channels", "positions", FOLDER / "others.obj", FOLDER / "a.cqm")
    check(f"told also of positions alone: {messages}", messages.count("\n") == 1 and other.format(4) in messages)
    textures = "".join(f"vt {k} 0 {{}}\n" for k in range(4))
    faces = "".join("f %d/%d %d/%d %d/%d\n" % tuple(v + 1 for v in face for _ in range(2)) for face in FACES)
    vertices = "".join("v %d %d %d\n" % p for p in POSITIONS)
    reads("third_is_0.obj", vertices + textures.format(0, 0, 0, 0) + faces)
    reads("third.obj", vertices + textures.format(0, 0, 3, 0) + faces, says=["dropped: the third texture coordinate"])
    reads("third_is_none.obj", vertices + textures.format(0, 0, "x", "1 2") + faces,
          says=["dropped: the third texture coordinate", other.format(2)])
    reads("first_only.obj", vertices + textures.replace(" 0 {}", "").format() + faces)
    check("the second is 0", [(row["s"], row["t"]) for row in attributes("first_only.obj")] == [(k, 0) for k in range(4)])
    reads("no_texture.obj", vertices + textures.replace("vt 1 0 {}", "vt").format(0, 0, 0) + faces,
          says=["dropped: texture coordinates of 3 corners, which are no", "changed: texture coordinates: where only some"])
    reads("fourth_of_normals.obj", vertices + "vn 0 0 1 1\n" + faces.replace("/", "//").replace("//2", "//1")
          .replace("//3", "//1").replace("//4", "//1"), says=[other.format(1)])
    reads("groups.obj", "o x\nmtllib a.mtl\ng a\n" + plain + "g b\ns 1\nvp 1 2\n", says=["dropped: lines that are not read: 1 'vp'"])
    for word in "fo", "surf", "call", "F", "?f":
        reads("surface.obj", plain + f"{word} 1 2 3\n", says=[f"dropped: lines that are not read: 1 '{word}'"])
        messages = cqm("encode", "--channels", "positions", FOLDER / "surface.obj", FOLDER / "a.cqm")
        check(f"told also of positions alone: {messages}", messages.count("\n") == 1)
    reads("many_words.obj", "".join(f"w{k} 0\n" for k in range(100)) + plain, says=["dropped: lines that are not read: 1 'w0', 1 'w1', "])
    reads("rounded_color.obj", obj(extra=" 1.0000001 -0.0000001 1"))
    check("colors are kept", b"property uchar red" in decoded_ply("rounded_color.obj"))


def decoded_ply(name):
    cqm("encode", "--quiet", "--keep-order", FOLDER / name, FOLDER / "p.cqm")
    cqm("decode", FOLDER / "p.cqm", FOLDER / "p.ply")
    return (FOLDER / "p.ply").read_bytes()


def test_no_mesh():
    """Nothing of these is an empty mesh."""
    png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\1\0\0\0\1\0\x08\x06\0\0\0" + bytes(range(256)) * 8
    off = "OFF\n4 4 6\n" + "".join("%d %d %d\n" % p for p in POSITIONS) + "".join("3 %d %d %d\n" % f for f in FACES)
    prose = "five or six vertices\nof no face\nPlain text. Or not?\n" * 30
    for kind in "off", "obj", "ply", "stl":
        for name, content in (("png", png), ("prose", prose), ("nothing", b""), ("blank", "\n"), ("zeros", bytes(999)),
                              ("off", off), ("obj", obj()), ("ply", ply()), ("stl", binary_stl()), ("solid", text_stl())):
            if name not in (kind, {"stl": "solid"}.get(kind)):
                refuses(f"renamed_{name}.{kind}", content)
    refuses("points.obj", "v 0 0 0\nv 1 0 0\n", "without faces")
    refuses("points.ply", ply().replace(b"element face", b"element edge"), "no element 'face' or 'tristrips'")
    refuses("faces.ply", ply().replace(b"element face", b"element faces"), "no element 'face' or 'tristrips'")
    refuses("vertices.ply", ply().replace(b"element vertex", b"element vertices"), "no element 'vertex'")
    reads("no_faces.ply", ply(faces=[]), faces=[], tells=["set aside: 4 unused vertices"])
    for kind in "ascii", "binary_little_endian":
        for positions in None, []:
            refuses("zero.ply", ply(positions, [], kind) + ply(kind=kind).split(b"end_header\n")[1],
                    "the file says that it has no faces, and does not end there")
    refuses("zero.off", off.replace("4 4 6", "4 0 6"), "the file says that it has 0 faces, and does not end there")
    refuses("all_zero.off", off.replace("4 4 6", "0 0 0"), "the file says that it has 0 faces, and does not end there")
    reads("points.off", "OFF\n2 0 0\n0 0 0\n1 0 0\n", [(0, 0, 0), (1, 0, 0)], [], tells=["set aside: 2 unused vertices"])
    reads("empty.off", "OFF\n0 0 0\n", [], [])
    reads("empty.ply", ply([], []), [], [])
    for kind in "off", "obj", "ply", "stl":
        cqm("encode", FOLDER / "empty.off", FOLDER / "empty.cqm")
        cqm("decode", FOLDER / "empty.cqm", FOLDER / f"empty2.{kind}")
        cqm("info", FOLDER / "empty.cqm")


# -- OFF ---------------------------------------------------------------------------------------------------------------

def off(word="OFF", extras=("", "", "", ""), separator=" ", end="\n", face_extra=""):
    text = f"{word}{end}4{separator}4{separator}6{end}"
    for p, extra in zip(POSITIONS, extras):
        text += separator.join(map(str, p)) + extra + end
    return text + "".join(separator.join(map(str, (3, *face))) + face_extra + end for face in FACES)


def attributes(name):
    """Of the vertices, in the order of the file, as cqm writes them to PLY."""
    head, data = decoded_ply(name).split(b"end_header\n", 1)
    names = [line.split()[2].decode() for line in head.splitlines() if line.startswith((b"property float", b"property uchar"))]
    row = struct.Struct("<" + "".join("B" if n in ("red", "green", "blue", "alpha") else "f" for n in names))
    return [dict(zip(names, row.unpack_from(data, k * row.size))) for k in range(4)]


def test_off():
    reads("plain.off", off())
    reads("mark.off", b"\xef\xbb\xbf" + off().encode())
    reads("commas.off", off(separator=","))
    reads("commas_and_blanks.off", off(separator=", "))
    for end in "\r\n", "\r", " # comment\n", "\n\n":
        reads("end.off", off(end=end))
    reads("one_line.off", off(end=" "))
    reads("split.off", off().replace(" ", "\n"))
    reads("glued.off", off().replace("OFF\n", "OFF"))
    reads("four.off", off("4OFF", (" 1", " 1.0", " 2", " 1")).replace("0 1 0 2", "0 2 0 2"))
    reads("face_colors.off", off(face_extra=" 255 0 0"), says=["dropped: colors of faces"])
    reads("extras.off", off(extras=(" 255 0 0",) * 4), says=["dropped: numbers behind the positions"])
    reads("more.off", off() + "2 0 1\n", says=["dropped: what follows the last face (line 11)"])
    for count in 2, 3:
        reads("fewer.off", off().replace("4 4 6", f"4 {count} 6"), faces=FACES[:count],
              says=["dropped: what follows the last face"])
        messages = cqm("encode", "--channels", "positions", FOLDER / "fewer.off", FOLDER / "a.cqm")
        check(f"told also of positions alone: {messages}", "dropped: what follows the last face" in messages)
    refuses("more_vertices.off", off().replace("4 4 6", "5 4 6"), "more numbers than the counts of vertices and faces tell")
    refuses("vertex_for_face.off", off().replace("4 4 6", "5 3 6"), "vertex 4 has 1 number more than its keyword announces")
    refuses("one_extra.off", off(extras=("", "", " 7", "")), "vertex 2 has 1 number more", "and vertex 0 has 0 (line 5)")
    refuses("decimal_commas.off", off().replace("1 0 0", "1,0 0,0 0,0", 1), "decimal points")
    refuses("binary.off", b"OFF BINARY\n" + struct.pack(">3i", 4, 4, 6), "OFF BINARY")
    refuses("n.off", off("nOFF"), "nOFF")
    refuses("cut.off", off()[:-8], "the file ends before face 3")
    refuses("w_is_0.off", off("4OFF", (" 1", " 0", " 1", " 1")), "not a finite")
    reads("utf16.off", off().encode("utf-16"))


def test_attributes_of_off():
    colors = [(255, 0, 0), (0, 128, 0), (1, 2, 3), (0, 0, 64)]
    normals = [(0, 0, 1), (1, 0, 0), (0, -1, 0), (0, 1, 0)]
    textures = [(0, 0), (1, 0), (0, 1), (1, 1)]

    def words(*rows):
        return tuple("".join(f" {x}" for row in parts for x in row) for parts in zip(*rows))

    def agree(name, color=False, alpha=None, normal=False, texture=False):
        for k, row in enumerate(attributes(name)):
            if color:
                check(f"{name}: color", tuple(row.get(c) for c in ("red", "green", "blue")) == colors[k])
            check(f"{name}: alpha", row.get("alpha") == alpha)
            if normal:
                check(f"{name}: normal", tuple(row.get(c) for c in ("nx", "ny", "nz")) == normals[k])
            if texture:
                check(f"{name}: texture", tuple(row.get(c) for c in "st") == textures[k])

    alpha = [(51,)] * 4
    fractions = [tuple(f"{x / 255:.6f}" for x in c) for c in colors]
    for name, word, rows, expected in (
            ("c", "COFF", (colors,), {"color": True}), ("ca", "COFF", (colors, alpha), {"color": True, "alpha": 51}),
            ("cf", "COFF", (fractions, [("0.2",)] * 4), {"color": True, "alpha": 51}),
            ("n", "NOFF", (normals,), {"normal": True}), ("st", "STOFF", (textures,), {"texture": True}),
            ("cn", "CNOFF", (normals, colors), {"color": True, "normal": True}),
            ("nc", "NCOFF", (colors, alpha, normals), {"color": True, "alpha": 51, "normal": True}),
            ("stcn", "STCNOFF", (normals, colors, textures), {"color": True, "normal": True, "texture": True})):
        reads(f"{name}.off", off(word, words(*rows)))
        agree(f"{name}.off", **expected)
    reads("part.off", off("COFF", words(colors)[:3] + ("",)), says=["dropped: colors: vertex 3 has none"])
    reads("one_line_c.off", off("COFF", words(colors, alpha), end=" "))
    agree("one_line_c.off", color=True, alpha=51)


# -- PLY ---------------------------------------------------------------------------------------------------------------

def ply(positions=None, faces=None, kind="ascii", real="float", corner="int", name="vertex_indices", end="\n", first=False):
    positions, faces = POSITIONS if positions is None else positions, FACES if faces is None else faces
    order = "<" if "little" in kind else ">"
    number = {"float": "f", "double": "d", "float64": "d", "int": "i", "uint8": "B"}
    vertex = [f"element vertex {len(positions)}"] + [f"property {real} {axis}" for axis in "xyz"]
    face = [f"element face {len(faces)}", f"property list uchar {corner} {name}"]
    head = end.join(["ply", f"format {kind} 1.0", *(face + vertex if first else vertex + face), "end_header", ""]).encode()
    if kind == "ascii":
        rows = ["%r %r %r" % tuple(map(float, p)) for p in positions], ["3 %d %d %d" % f for f in faces]
        rows = [("".join(row + end for row in part)).encode() for part in rows]
    else:
        rows = [b"".join(struct.pack(order + "3" + number[real], *p) for p in positions),
                b"".join(struct.pack(order + "B3" + number[corner], 3, *f) for f in faces)]
    return head + b"".join(rows[::-1] if first else rows)


def test_ply():
    for kind in "ascii", "binary_little_endian", "binary_big_endian":
        for end in "\n", "\r\n", "\r":
            for first in False, True:
                reads("kinds.ply", ply(kind=kind, end=end, first=first, real="double", name="vertex_index"))
        reads("small.ply", ply(kind=kind, corner="uint8"))
        reads("more.ply", ply(kind=kind) + b"1 2", says=["dropped: what follows the last row"])
    # Data that begins with the bytes of line ends.
    for x, end in ((b"\n\0\0\0", "\r"), (b"\n\0\0\0", "\n"), (b"\r\n\0\0", "\n"), (b"\n\0\0\0", "\r\n"), (b"\n\r\n\r", "\r")):
        small = struct.unpack("<f", x)[0]
        positions = [(small, 0, 0)] + POSITIONS[1:]
        reads("line_end.ply", ply(positions, kind="binary_little_endian", end=end), positions)
    head, data = ply().split(b"end_header\n")
    rows = data.split(b"\n")
    reads("one_line.ply", head + b"end_header\n" + data.replace(b"\n", b" "))
    reads("one_number_a_line.ply", head + b"end_header\n" + data.replace(b" ", b"\n"))
    reads("list_in_two_lines.ply", head + b"end_header\n" + data.replace(b"3 0 2 1", b"3 0\n2 1"))
    for name, wrong, says in (
            ("five_vertices", ply().replace(b"vertex 4", b"vertex 5"), "more numbers than the rows of the header have"),
            ("three_vertices", ply().replace(b"vertex 4", b"vertex 3"), "row 0 of element 'face' has more numbers"),
            ("long_row", ply().replace(rows[2], rows[2] + b" 9"), "row 2 of element 'vertex' has more numbers"),
            ("short_row", ply().replace(rows[2], rows[2][:-4]), "found the end of the line (line 12)"),
            ("short_rows", ply().replace(b" 0.0\n", b"\n"), "more numbers than the rows of the header have"),
            ("short_face", ply().replace(b"3 0 2 1", b"3 0 2"), "row 0 of element 'face' has more numbers")):
        refuses(f"{name}.ply", wrong, says)
    uneven = ply().replace(b"vertex_indices\n", b"vertex_indices\nproperty list uchar float texcoord\n")
    for k, numbers in enumerate(("6 0 0 1 0 1 1", "0", "5 0 0 1 0 1", "6 0 0 1 0 1 1")):
        uneven = uneven.replace(rows[4 + k] + b"\n", rows[4 + k] + f" {numbers}\n".encode())
    reads("uneven_textures.ply", uneven,
          says=["dropped: texture coordinates of faces that have not two for each corner (1)"])
    reads("noise.ply", ply().replace(b"element vertex", b"Made by a tool\nelement vertex"),
          says=["dropped: header lines that are not PLY (1), the first begins with 'Made'"])
    refuses("cut.ply", ply(kind="binary_little_endian")[:-1], "the file ends inside its data")
    head, data = ply().split(b"element face", 1)
    many = [f"f_rest_{k}" for k in range(60)]
    rows = data.split(b"\n")
    text = head + "".join(f"property float {n}\n" for n in many).encode() + b"element face" + b"\n".join(
        row + b" 0" * 60 if 3 <= k < 7 else row for k, row in enumerate(rows))
    reads("many.ply", text, says=["dropped: properties of element 'vertex': 'f_rest_0', 'f_rest_1', "])
    messages = cqm("encode", FOLDER / "many.ply", FOLDER / "a.cqm")
    check("every property is named", all(f"'{n}'" in messages for n in many))


def test_strips():
    """The tetrahedron as a strip; with a restart; with a corner twice, to turn; beside faces."""
    def strips(*lists, faces=()):
        head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        head += f"element tristrips {len(lists)}\nproperty list int int vertex_indices\n"
        head += f"element face {len(faces)}\nproperty list uchar int vertex_index\n" if faces else ""
        return head + "end_header\n" + "".join("%d %d %d\n" % p for p in POSITIONS) + "".join(
            f"{len(row)} {' '.join(map(str, row))}\n" for row in [*lists, *faces])

    reads("strip.ply", strips([0, 2, 1, 3, 0, 2]))
    reads("strip_and_faces.ply", strips([0, 2, 1, 3], faces=FACES[1:2] + FACES[3:]))
    reads("restart.ply", strips([0, 2, 1, -1, 0, 1, 3, -1, 1, 2, 3, -1, 0, 3, 2, -1]))
    reads("turn.ply", strips([0, 2, 1, 1, 1, 2, 3], [0, 1, 3], [0, 3, 2]))
    refuses("no_triangle.ply", strips([0, 1]), "no strip has a triangle")
    refuses("strip_of_5.ply", strips([0, 1, 5]), "names vertex 5")


# -- Precision ---------------------------------------------------------------------------------------------------------

def grid_mesh(side, origin, n=10):
    """A square with n * n cells."""
    positions = [(origin[0] + side * i / n, origin[1] + side * j / n, origin[2]) for i in range(n + 1) for j in range(n + 1)]
    cells = [(i * (n + 1) + j, (i + 1) * (n + 1) + j) for i in range(n) for j in range(n)]
    return positions, [f for a, b in cells for f in ((a, b, b + 1), (a, b + 1, a + 1))]


def distance(found, positions):
    return max(abs(a - b) for p, q in zip(found, positions) for a, b in zip(p, q))


def test_far_from_the_origin():
    out, stream = FOLDER / "far.off", FOLDER / "far.cqm"
    for side, origin in ((1, (448250.123, 5411932.678, 35.2)), (100, (-448250.123, 5411932.678, -35.2)),
                         (0.01, (6378137.001, 0.5, -6378137.002)), (1e-3, (1e6, 1e-6, 0))):
        positions, faces = grid_mesh(side, origin)
        for kind in "binary_little_endian", "ascii":
            source = write("far.ply", ply(positions, faces, kind, "double"))
            for bits in 8, 12, 16:
                step = side / (2 ** bits - 1)
                messages = cqm("encode", "--strict", "--keep-order", "--bits", bits, source, stream)
                check(f"nothing is lost: {messages}", not messages)
                cqm("decode", stream, out)
                off_by = distance(read_off(out)[0], positions)
                check(f"{side} at {origin}, {bits} bits: off by {off_by}, step {step}", off_by <= 0.51 * step)
                cqm("verify", "--bits", bits, source)
                cqm("decode", stream, FOLDER / "far2.ply")
                cqm("encode", "--keep-order", "--bits", bits, FOLDER / "far2.ply", stream)
                cqm("decode", stream, FOLDER / "far2.off")
                off_by = distance(read_off(FOLDER / "far2.off")[0], positions)
                check(f"PLY holds it: {off_by}", off_by <= 1.1 * step)
            messages = cqm("decode", stream, FOLDER / "far.stl")
            check(f"STL does not: {messages}", "STL has 32-bit floats, which move them by up to" in messages)
            cqm("decode", "--strict", stream, FOLDER / "strict.stl", status=1)
            check("no STL", not (FOLDER / "strict.stl").exists())


def test_floats_that_are_too_coarse():
    """Where x and y are integers that floats hold, but near another one there is none, z has digits all the same."""
    out, stream = FOLDER / "coarse.off", FOLDER / "coarse.cqm"
    flat, faces = grid_mesh(100, (-1e7, 1e7, 0))
    positions = [floats((x, y, 10 * math.sin(k))) for k, (x, y, _) in enumerate(flat)]
    for bits in 12, 16, 24:
        for kind, real in ("ascii", "double"), ("binary_little_endian", "float"):
            source = write("coarse.ply", ply(positions, faces, kind, real))
            messages = cqm("encode", "--strict", "--keep-order", "--bits", bits, source, stream)
            check(f"nothing is lost: {messages}", not messages)
            cqm("decode", stream, out)
            off_by, step = distance(read_off(out)[0], positions), 100 / (2 ** bits - 1)
            check(f"{kind}, {bits} bits: off by {off_by}, step {step}", off_by <= 0.51 * step)
            cqm("verify", "--bits", bits, source)
    text = "".join("v %r %r %r\n" % p for p in positions)
    text += "".join("vt %.9g %.9g\n" % (1e6 + x / 100, z) for (x, _, z) in positions)
    text += "".join("f %d/%d %d/%d %d/%d\n" % tuple(v + 1 for v in face for _ in range(2)) for face in faces)
    messages = cqm("encode", write("coarse.obj", text), stream)
    step = max(z for _, _, z in positions) - min(z for _, _, z in positions)
    check(f"texture coordinates are told: {messages}", messages.count("\n") == 1 and "changed: texture coordinates: the step of "
          f"the grid is 0.0625 instead of {step / 4095:.3g}, as they are so far from 0" in messages)
    cqm("encode", "--strict", FOLDER / "coarse.obj", FOLDER / "none3.cqm", status=1)
    tiny = [tuple(1e-300 * x for x in p) for p in POSITIONS]
    messages = cqm("encode", write("tiny.ply", ply(tiny, kind="binary_big_endian", real="double")), stream)
    check(f"too small: {messages}", "the step of the grid is 1.18e-38 instead of 2.44e-304, as no float is smaller" in messages)


def test_exact_means_floats():
    out, stream = FOLDER / "exact.off", FOLDER / "exact.cqm"
    positions, faces = grid_mesh(1, (448250.123, 5411932.678, 35.2))
    rounded = list(map(floats, positions))
    source = write("exact.ply", ply(positions, faces, "binary_big_endian", "double"))
    messages = cqm("encode", "--bits", 32, "--keep-order", source, stream)
    cqm("decode", stream, out)
    moved = distance(read_off(out)[0], positions)
    check(f"{messages} has {moved:.3g}", f"exact means the nearest 32-bit floats behind an origin, up to {moved:.3g} away" in messages)
    check(f"half a unit of floats that are up to 1: {moved}", 0 < moved <= 2 ** -25)
    cqm("verify", "--bits", 32, source)
    cqm("encode", "--bits", 32, "--strict", source, FOLDER / "none.cqm", status=1)
    check("--strict writes nothing", not (FOLDER / "none.cqm").exists())
    text = "OFF\n121 200 0\n" + "".join(" ".join(f"{x:.6f}" for x in p) + "\n" for p in positions)
    text += "".join("3 %d %d %d\n" % f for f in faces)
    check("floats hold six digits", cqm("encode", "--bits", 32, "--strict", write("digits6.off", text), stream) == "")
    for real, kind in ("float", "binary_big_endian"), ("double", "binary_big_endian"), ("double", "ascii"):
        source = write("floats.ply", ply(rounded, faces, kind, real))
        check("floats are exact", "exact means" not in cqm("encode", "--strict", "--bits", 32, source, stream))
    # A number with few digits is one that a float prints, or nine digits of a float.
    thirds = [tuple(x / 3 for x in p) for p in grid_mesh(1, (1, 2, 3))[0]]
    for digits, points, lost in (6, thirds, False), (9, list(map(floats, thirds)), False), (9, thirds, True), (17, thirds, True):
        text = "OFF\n121 200 0\n" + "".join(" ".join(f"{x:.{digits}g}" for x in p) + "\n" for p in points)
        text += "".join("3 %d %d %d\n" % f for f in faces)
        messages = cqm("encode", "--bits", 32, write("digits.off", text), stream)
        check(f"{digits} digits: {messages}", ("exact means" in messages) == lost)


def test_one_stray_point():
    stream, out = FOLDER / "stray.cqm", FOLDER / "stray.ply"
    positions, faces = grid_mesh(1, (0, 0, 0))

    def textured(textures):
        head, data = ply(positions, faces).split(b"element face", 1)
        rows = data.split(b"\n")
        return head + b"property float s\nproperty float t\nelement face" + b"\n".join(
            row + f" {textures[k - 3][0]!r} {textures[k - 3][1]!r}".encode()
            if 3 <= k < 124 else row for k, row in enumerate(rows))

    good = [(x, y) for x, y, _ in positions]
    check("none", cqm("encode", write("good.ply", textured(good)), stream) == "")
    source = write("stray.ply.in.ply", textured([(-1e5, -1e5)] + good[1:]))
    messages = cqm("encode", source, stream)
    check(f"one: {messages}", "texture coordinates: a few are far from all others" in messages
          and "multiples of 24.4 (12 bits); see --bits texcoords=N" in messages)
    cqm("encode", "--strict", source, FOLDER / "none2.cqm", status=1)
    messages = cqm("encode", "--keep-order", "--bits", "texcoords=24,normals=8,14", source, stream)
    check(f"24 bits: {messages}", "multiples of 0.00781 (24 bits)" in messages)
    channels = json.loads(subprocess.run([CQM, "info", "--json", stream], capture_output=True, check=True).stdout)["channels"]
    check("bits of each channel", [c["bits"] for c in channels] == [14, 24, 7])
    cqm("decode", stream, out)
    head, data = out.read_bytes().split(b"end_header\n", 1)
    found = [struct.unpack_from("<2f", data, 20 * k + 12) for k in range(121)]
    check("good to 24 bits", distance(found[1:], good[1:]) <= 0.004)
    stray = [(1e6, 0, 0)] + positions[1:]
    messages = cqm("encode", write("stray_position.ply", ply(stray, faces)), stream)
    check(f"a position: {messages}", "changed: positions: a few are far from all others" in messages)


# -- Words of the command line -----------------------------------------------------------------------------------------

def test_words():
    source, stream = write("words.off", off()), FOLDER / "words.cqm"
    cqm("encode", source, stream)
    whole = source.read_bytes()

    def bad(*arguments, says):
        messages = cqm(*arguments, status=2)
        check(f"{arguments}: {messages}", all(word in messages for word in says) and messages.count("\n") == 1)

    os.link(source, FOLDER / "linked.off") if not (FOLDER / "linked.off").exists() else None
    bad("encode", source, source, says=["are the same file"])
    bad("encode", source, FOLDER / "linked.off", says=["are the same file"])
    bad("encode", source, FOLDER / "." / "words.off", says=["are the same file"])
    bad("decode", "--format", "off", stream, stream, says=["are the same file"])
    check("the input is there", source.read_bytes() == whole)
    bad("encode", "--format", "ply", source, stream, says=["--format says ply, but the name ends in .off"])
    bad("verify", "--format", "ply", source, says=["--format says ply, but the name ends in .off"])
    bad("decode", "--format", "obj", stream, FOLDER / "words.ply", says=["--format says obj, but the name ends in .ply"])
    cqm("encode", "--format", "off", source, stream)
    plain = write("words.mesh", off())
    cqm("encode", "--format", "off", plain, stream)
    bad("encode", plain, stream, says=["unknown format"])
    for bits in "25", "0", "33", "31", "x", "", "texcoords=32", "normals=1", "positions=", "alpha=3", "12,", "=4":
        bad("encode", "--bits", bits, source, stream, says=["--bits", "1 to 24 or 32"])
    bad("encode", says=["encode: takes two files, IN and OUT.cqm, but got 0"])
    bad("encode", source, says=["but got 1"])
    bad("encode", source, stream, source, says=["but got 3"])
    bad("info", says=["takes one file, IN.cqm, but got 0"])
    bad("verify", says=["takes at least one file, IN, but got 0"])
    bad("encode", "--colour", source, stream, says=["unknown option '--colour'"])
    bad("encode", source, stream, "--bits", says=["--bits needs a value"])
    bad("encode", "--quiet=1", source, stream, says=["--quiet takes no value"])
    bad("remesh", source, says=["remesh: unknown command"])
    for grid in "0,0,0", "0,0,0,0", "0,0,0,-1", "0,0,0,1,", "a,0,0,1", "0,0,0,nan", "":
        bad("encode", "--grid", grid, source, stream, says=["X,Y,Z,STEP"])
    bad("encode", "--grid", "0,0,0,1", "--bits", "9", source, stream, says=["--grid decides how many bits"])


def test_strict_decoding():
    stream = FOLDER / "colored.cqm"
    cqm("encode", write("colored.off", off("COFF", (" 255 0 0",) * 4)), stream)
    cqm("decode", "--strict", stream, FOLDER / "colored.ply")
    cqm("decode", "--strict", stream, FOLDER / "colored2.off", status=1)
    cqm("decode", "--strict", "--quiet", stream, FOLDER / "colored2.off", status=1)
    check("nothing is written", not (FOLDER / "colored2.off").exists())
    cqm("decode", stream, FOLDER / "colored2.off")
    losses = FOLDER / "losses.cqm"

    def lost(kind, *says, options=()):
        """Only so many things are told, and there is no file if they may not be lost."""
        out = FOLDER / f"losses.{kind}"
        out.unlink(missing_ok=True)
        cqm("encode", "--quiet", *options, FOLDER / "source.obj", losses)
        cqm("decode", "--strict", "--quiet", losses, out, status=1 if says else 0)
        check(f"{kind}: nothing is written", out.exists() != bool(says))
        messages = cqm("decode", losses, out)
        check(f"{kind}: said {messages!r}, not {says}",
              messages.count("\n") == len(says) and all(word in messages for word in says))

    write("source.obj", obj() + "v 0 0 2\nl 1 2\np 3\n")
    lost("stl", "dropped: vertices of no face (1), which STL does not have", "changed: lines and points (2) become triangles")
    write("source.obj", obj() + "v 1 0 0\nv 0 0 1\nf 5 6 1\n")
    lost("stl", "changed: vertices at the place of others (2) become one with them",
         "dropped: number of the stream", options=("--keep-order",))
    write("source.obj", obj(extra=" 0.1 0.2 0.3"))
    lost("ply")
    for kind in "obj", "ply":
        lost(kind, *(["changed: colors: PLY gets 8 of their 12 bits"] if kind == "ply" else []), options=("--bits", "colors=12"))
    for kind in "off", "obj", "ply":
        write("source.obj", obj() + "v 0 0 2\nl 1 2\np 3\nf 2 2 4\n")
        lost(kind)


def test_info_of_a_part():
    positions, faces = grid_mesh(1, (0, 0, 0))
    stream = FOLDER / "part.cqm"
    cqm("encode", "--conquest-only", write("part.ply", ply(positions, faces)), stream)
    data = stream.read_bytes()
    seen = []
    for size in [*range(40, len(data) - 1, 11), len(data) - 1]:
        part = write("part2.cqm", data[:size])
        done = subprocess.run([CQM, "info", part], capture_output=True, check=False)
        text = done.stdout.decode()
        check(f"{size} bytes: status", done.returncode == 1 and f"truncated after {size} of" in done.stderr.decode())
        done = subprocess.run([CQM, "info", "--json", part], capture_output=True, check=False)
        so_far = json.loads(done.stdout)["so_far"]
        check(f"{size} bytes: {so_far}", f"{size} of {len(data)} bytes: {so_far['vertices']} vertices, "
              f"{so_far['faces']} faces" in text and so_far["bytes"] == size and done.returncode == 1)
        cqm("decode", "--bytes", size, stream, FOLDER / "part.off", status=0 if so_far["vertices"] else 1)
        if so_far["vertices"]:
            check("as decoded", len(read_off(FOLDER / "part.off")[0]) == so_far["vertices"])
        seen.append(so_far["vertices"])
    check(f"more and more: {seen}", seen == sorted(seen) and seen[-1] > 100)
    check("all: not so far", "so far" not in subprocess.run([CQM, "info", stream], capture_output=True, check=True).stdout.decode())


def test_trace():
    """What it prints of a whole stream, of a part and of a damaged one."""
    positions, faces = grid_mesh(1, (0, 0, 0))
    stream = FOLDER / "trace.cqm"
    cqm("encode", write("trace.ply", ply(positions, faces)), stream)
    data = stream.read_bytes()
    counts = json.loads(run("info", "--json", stream)[1])
    said, text = run("trace", stream)
    lines = [line.split() for line in text.splitlines()]
    kinds = [line[0] for line in lines]
    end = [str(counts[name]) for name in ("levels", "vertices", "faces")]
    check(f"ends with {lines[-1]}", not said and lines[-1] == ["end"] + end)
    check("a line for each vertex", sorted(int(line[2]) for line in lines if line[0] == "values") == [*range(len(positions))])
    check("all are of channel 0 and have three numbers", all(len(line) == 6 and line[1] == "0" for line in lines if line[0] == "values"))
    base = [line for line in lines if line[0] == "triangle" and max(map(int, line[1:])) < len(positions)]
    check("triangles of the base", len(base) == counts["base_faces"] < kinds.count("triangle"))
    check("levels", [line[1:3] for line in lines if line[0] == "level"] ==
          [[str(k + 1), str(int(level["type"] == "regular"))] for k, level in enumerate(counts["per_level"])])
    for level in counts["per_level"]:
        begin = lines.index(next(line for line in lines if line[:2] == ["level", str(counts["per_level"].index(level) + 1)]))
        here = list(itertools.takewhile(lambda kind: kind not in ("level", "end"), kinds[begin + 1:]))
        made = here.count("insertion") if level["type"] == "regular" else here.count("split")
        check(f"patches and vertices of level at line {begin}", made == level["splits"]
              and here.count("patch") >= level["patches"] and here.count("mark") == here.count("insertion"))
    names = {line.split()[0] for line in run("trace", "--help")[1].splitlines() if line.startswith("  ") and line[2] not in " -"}
    check(f"the help has {sorted(set(kinds) - names)} not", set(kinds) <= names and len(names) == 16)
    before = ""
    for size in [*range(40, len(data) - 1, 13), len(data) - 1]:
        said, part = run("trace", write("part3.cqm", data[:size]), status=1)
        check(f"{size} bytes: {said}", f"truncated after {size} of {len(data)} bytes" in said and said.count("\n") == 1)
        check(f"{size} bytes: a beginning", text.startswith(part) and part.startswith(before))
        before = part
    check(f"most of it was seen: {len(before)} of {len(text)}", len(before) > len(text) / 3)
    damaged = data[:-20] + bytes(20)
    said, part = run("trace", write("damaged.cqm", damaged), status=1)
    check(f"damaged: as decode says {said}", said == cqm("decode", FOLDER / "damaged.cqm", FOLDER / "damaged.off", status=1)
          and f"(byte {len(data)})" in said)
    check("what comes before is told", 0 < len(os.path.commonprefix([part, text])) < len(text) and "end" not in part.split())
    check("of no stream nothing", run("trace", write("no.cqm", b"CR"), status=1)[1] == "")
    check("of a header nothing", run("trace", write("head.cqm", data[:20]), status=1)[1] == "")
    check("from standard input", subprocess.run([CQM, "trace", "-"], input=data, capture_output=True, check=True).stdout.decode() == text)
    check("one file", "takes one file, IN.cqm, but got 0" in cqm("trace", status=2))
    if os.path.exists("/dev/full"):
        with open("/dev/full", "wb") as full:
            done = subprocess.run([CQM, "trace", stream], stdout=full, stderr=subprocess.PIPE, check=False)
        check("a full disk", done.returncode == 1 and b"cannot write" in done.stderr)


def test_tiles():
    """Two squares side by side, whose heights at the border are equal."""
    def tile(x0, name):
        positions, faces = grid_mesh(1, (x0, 0, 0), 20)
        positions = [(x, y, 0.1 * math.sin(3 * x) * math.cos(7 * y)) for x, y, _ in positions]
        source, stream, out = FOLDER / f"{name}.ply", FOLDER / f"{name}.cqm", FOLDER / f"{name}.off"
        write(f"{name}.ply", ply(positions, faces, "binary_little_endian", "double"))
        cqm("encode", "--keep-order", "--grid", "0,-1,-0.5,0.001", source, stream)
        cqm("verify", "--grid=0,-1,-0.5,0.001", source)
        cqm("decode", stream, out)
        found = read_off(out)[0]
        check(f"{name}: within half a step", distance(found, positions) <= 0.000501)
        return found

    a, b = tile(0, "left"), tile(1, "right")
    check("the border is one", a[-21:] == b[:21])
    source = write("beyond.ply", ply())
    messages = cqm("encode", "--grid", "1,0,0,1", source, FOLDER / "beyond.cqm", status=1)
    check(f"beyond: {messages}", "vertex 0 at 0 0 0 is beyond --grid" in messages)
    messages = cqm("encode", "--grid", "-4,-4,-4,0.1", source, FOLDER / "near.cqm")
    check(f"a float is near enough: {messages}", not messages)
    source = write("far_grid.ply", ply([(x + 5411932, y, z) for x, y, z in POSITIONS], real="double"))
    messages = cqm("encode", "--grid", "5411931.678,-1,-1,0.01", source, FOLDER / "far_grid.cqm")
    check(f"not the grid that was asked for: {messages}", "the points of --grid are up to 0.178 from where they" in messages)
    cqm("encode", "--strict", "--grid", "5411931.678,-1,-1,0.01", source, FOLDER / "none4.cqm", status=1)
    cqm("encode", "--strict", "--grid", "5411931.5,-1,-1,0.01", source, FOLDER / "far_grid.cqm")
    source = FOLDER / "beyond.ply"
    messages = cqm("encode", "--grid", "0,0,0,5e-8", source, FOLDER / "beyond.cqm", status=1)
    check(f"too fine: {messages}", "vertex 1 at 1 0 0 is beyond --grid" in messages)


TESTS = (test_binary_stl, test_text_stl, test_obj, test_what_obj_has_and_a_stream_has_not, test_no_mesh, test_off,
         test_attributes_of_off, test_ply, test_strips, test_far_from_the_origin, test_floats_that_are_too_coarse,
         test_exact_means_floats,
         test_one_stray_point, test_words, test_strict_decoding, test_info_of_a_part, test_trace, test_tiles)


if __name__ == "__main__":
    sys.exit(run_tests(FOLDER, TESTS))
