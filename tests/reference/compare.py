#!/usr/bin/env python3
"""Compares decoder.py with the C decoder: compare.py [--all] [--seed N] CQM DUMP CHANNELS   SPDX-License-Identifier: MIT

CQM and CHANNELS (channels.c) encode, DUMP (dump.c) is the C decoder. Both decoders must print the same:
the kind of result, and the mesh with the order of vertices, triangles and corners. They get

    meshes     of ref_data, with positions (also of 24 bits), without, with odd channels, textures: whole, stopped at some
               numbers of vertices, and cut at some places; those of build/meshes with up to 1000 vertices (--all:
               20 000)
    corrupt    400 streams (--all: 14 000) with bits flipped, counts changed, payloads made up, with and without
               matching check values
    valid      half as many that no encoder writes but that are valid (random_stream.py)
    traces     some streams that together have all events, whole, cut and with bits flipped: what both have read, line
               by line

A difference is printed with the name of a file that has the stream, and the first line where the traces differ. The last line is `N passed, N failed`."""

import argparse
import collections
import itertools
import multiprocessing
import os
import pathlib
import random
import re
import subprocess
import sys
import zlib

sys.dont_write_bytecode = True
import appendix
import decoder
import random_stream

ROOT = pathlib.Path(__file__).resolve().parents[2]
FAILED = ROOT / "build" / "reference"
LIMIT = 100000         # vertices, triangles or edges of a made-up header
WAYS = ("positions", "connectivity")
WIDE = "bits 24"         # rings that 8.3 scales down
TEXTURES = "0,0,3,14", "3,0,2,12", "3,0,2,32"  # 9.16
OF_FACES = "0,0,3,14", "3,0,2,12", "7,2,1,4"

options = None


def run(command, data=b""):
    return subprocess.run(command, input=data, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)


def trace_difference(data, events=None):
    """The first line where the traces of a stream differ, or None. `events`: a list that gets Python's."""
    events = [] if events is None else events
    if decoder.Decoder(data, events=events, limit=LIMIT).kind == "limit":
        return None
    found = run([options.cqm, "trace", "-"], data).stdout.decode().splitlines()
    lines = itertools.zip_longest(decoder.trace(events), found, fillvalue="nothing")
    return next((f"line {n} of the traces: Python: {here}; C: {there}"
                 for n, (here, there) in enumerate(lines, 1) if here != there), None)


class Tally:
    def __init__(self):
        self.passed, self.failures = 0, []

    def check(self, name, data, stop=None):
        """One stream through both decoders."""
        reference = decoder.Decoder(data, stop, limit=LIMIT)
        if reference.kind == "limit":
            return reference
        found = run([options.dump] + ([str(stop)] if stop else []), data)
        text = found.stdout.decode()
        if found.returncode == 0 and text == decoder.dump(reference):
            self.passed += 1
            return reference
        FAILED.mkdir(parents=True, exist_ok=True)
        path = FAILED / (re.sub(r"[^\w.-]+", "_", name) + ".cqm")
        path.write_bytes(data)
        why = (found.stderr.decode().strip().splitlines() or [f"exit status {found.returncode}"])[:2]
        here, there = " ".join(decoder.dump(reference).splitlines()[:2]), " ".join(text.splitlines()[:2] or why)
        name += f" at {stop} vertices" if stop else ""
        self.failures.append(f"FAIL  {name}: Python: {here}; C: {there}; {path.relative_to(ROOT)}; "
                             f"{trace_difference(data) or 'the traces are equal'}")
        return reference

    def require(self, name, condition):
        if condition:
            self.passed += 1
        else:
            self.failures.append("FAIL  " + name)


# -- Meshes ------------------------------------------------------------------------------------------------------------

def encode(path, how):
    """The stream of a mesh: `positions`, options of cqm without the first `--`, or the seed of channels, or a tuple of
    that and channels."""
    if isinstance(how, (int, tuple)):
        arguments = how if isinstance(how, tuple) else (how,)
        done = run([options.channels, *map(str, arguments)], path.read_bytes())
        return done.stdout if done.returncode == 0 else None
    out = FAILED / f"{os.getpid()}.tmp"
    FAILED.mkdir(parents=True, exist_ok=True)
    done = run([options.cqm, "encode", "--quiet"] + ([] if how == "positions" else ("--" + how).split()) + [path, out])
    data = out.read_bytes() if done.returncode == 0 else None
    out.unlink(missing_ok=True)
    return data


def compare_mesh(path, how, places):
    """The whole stream; stopped and cut at `places` places each."""
    tally = Tally()
    name = f"{path.name} {how}"
    data = encode(path, how)
    if data is None:
        tally.failures.append("FAIL  " + name + ": not encoded")
        return tally
    whole = tally.check(name, data)
    tally.require(name + ": complete", whole.kind == "done" and whole.vertices == whole.header.vertices)
    draw = random.Random(name)
    for _ in range(places):
        if whole.vertices > whole.base_vertices:
            tally.check(name, data, stop=draw.randint(whole.base_vertices + 1, whole.vertices))
        cut = draw.randrange(len(data))
        tally.check(f"{name} cut to {cut} bytes", data[:cut])
    return tally


def many_patches():
    """60 components of two triangles, which have no patch, and 17 of six: the patches must fit a third of the faces."""
    triangles = []
    for k in range(0, 180, 3):
        triangles += [(k, k + 1, k + 2), (k, k + 2, k + 1)]
    for k in range(180, 180 + 17 * 5, 5):
        for a, b in (0, 1), (1, 2), (2, 0):
            triangles += [(k + a, k + b, k + 3), (k + b, k + a, k + 4)]
    vertices = [(v % 5, v // 5 % 5, v % 7) for v in range(265)]
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0"]
    lines += ["%d %d %d" % v for v in vertices] + ["3 %d %d %d" % t for t in triangles]
    FAILED.mkdir(parents=True, exist_ok=True)
    path = FAILED / "many_patches.off"
    path.write_text("\n".join(lines) + "\n")
    return path


def compare_power_of_two():
    """A fit (9.13) with the numerator -2^30, which has one bit less than 2^30."""
    lines = ["v 10 2 7 0.749405906 1 0", "v 0 11 9 0.275960462 0 0", "v 10 5 9 1 0 0", "v 11 10 8 0 0 0",
             "v 0 7 3 0.240800395 0 0"]
    for a, b in (1, 2), (2, 3), (3, 1):
        lines += [f"f {a} {b} 4", f"f {b} {a} 5"]
    FAILED.mkdir(parents=True, exist_ok=True)
    path = FAILED / "power_of_two.obj"
    path.write_text("\n".join(lines) + "\n")
    data = encode(path, "grid 0,0,0,1 --bits colors=24")
    found, plain = [], decoder.Attributes.gradient
    decoder.Attributes.gradient = staticmethod(lambda *sums: found.append(plain(*sums)) or found[-1])
    tally = Tally()
    tally.check(path.name, data)
    decoder.Attributes.gradient = staticmethod(plain)
    tally.require(f"{path.name}: a numerator is -2^30", any(gx == -(1 << 30) for gx, _, _ in found))
    return tally


def compare_cuts(path, how):
    """Every prefix, and the stream with bytes behind it."""
    tally = Tally()
    data = encode(path, how)
    for cut in range(len(data)):
        tally.check(f"{path.name} {how} cut to {cut} bytes", data[:cut])
    tally.check(f"{path.name} {how} and more", data + b"\0CQ")
    return tally


# -- Corrupt streams ---------------------------------------------------------------------------------------------------

def varint(n):
    out = bytearray()
    while n > 127:
        out.append(n & 127 | 128)
        n >>= 7
    return bytes(out) + bytes([n])


def frame(vertices, loops, edges, chi, channels, payload, size=None):
    """A stream with check values that match. channels: with their number before them."""
    head = b"CQ\0" + varint(vertices) + varint(loops) + (varint(edges) if loops else b"")
    head += varint(2 * chi if chi >= 0 else -2 * chi - 1) + channels
    head += varint(len(payload) if size is None else size) + zlib.crc32(payload).to_bytes(4, "little")
    return head + (zlib.crc32(head) & 0xffff).to_bytes(2, "little") + payload


def parts(data):
    """The arguments of frame for a stream."""
    h = decoder.Header(data)
    chi = (2 * (h.vertices + h.loops) - h.faces - h.edges) // 4
    counts = varint(h.vertices) + varint(h.loops) + (varint(h.edges) if h.loops else b"")
    first = 3 + len(counts) + len(varint(2 * chi if chi >= 0 else -2 * chi - 1))
    extended = data[first] // 128
    at = first + 1
    for _ in h.channels:
        at += 3 if data[at] & 64 else 7 + 4 * data[at + 1]
    for _ in range(5 * extended):
        while data[at] > 127:
            at += 1
        at += 1
    return [h.vertices, h.loops, h.edges, chi, data[first:at], h.payload]


def flip(draw, data, first=0):
    data = bytearray(data)
    for _ in range(draw.choice((1, 1, 1, 2, 5))):
        if len(data) > first:
            data[draw.randrange(first, len(data))] ^= 1 << draw.randrange(8)
    return bytes(data)


def corrupt(draw, data):
    """A stream that is probably not valid, and what was done."""
    p = parts(data)
    how = draw.choice(("flip", "flip", "payload", "payload", "payload", "random", "counts", "counts", "channels",
                       "size", "cut", "magic", "ones"))
    if how == "flip":
        return how, flip(draw, data)
    if how == "payload":
        return how, frame(*p[:5], flip(draw, p[5]))
    if how == "random":
        return how, frame(*p[:5], draw.randbytes(draw.randrange(2 * len(p[5]) + 8)))
    if how == "counts":
        for _ in range(draw.choice((1, 1, 2, 3))):
            k = draw.randrange(4)
            p[k] += draw.choice((-3, -2, -1, 1, 1, 2, 3))
            p[k] = p[k] if k == 3 else max(p[k], 0)
        if draw.randrange(8) == 0:
            p[0] = 0
        return how, frame(*p)
    if how == "channels":
        channels = bytearray(p[4])
        channels[draw.randrange(min(len(channels), 4))] ^= 1 << draw.randrange(8)
        return how, frame(*p[:4], bytes(channels), p[5])
    if how == "size":
        payload = p[5] + draw.choice((b"\0", b"\0\0", b"\0\0\0\0\0", b"\1", b"\xff\xff\xff\xff\xff"))
        return how, frame(*p[:5], payload)
    if how == "cut":
        payload = flip(draw, p[5])
        return how, frame(*p[:5], payload, len(payload))[:-draw.randrange(1, len(payload) + 1) if payload else None]
    if how == "magic":
        return how, flip(draw, data[:24]) + data[24:]
    return how, frame(*p[:5], b"\xff\xff\xff\xff" + p[5][4:])


def compare_corrupt(streams, seed, count):
    tally = Tally()
    draw = random.Random(seed)
    for k in range(count):
        how, data = corrupt(draw, draw.choice(streams))
        tally.check(f"corrupt {seed}-{k} {how}", data)
    return tally


def compare_valid(seed, count):
    """Streams of random_stream.py: both decoders must accept them."""
    tally = Tally()
    for k in range(count):
        make = random_stream.make if k else random_stream.make_hubs
        result = tally.check(f"valid {seed}-{k}", frame(*make(f"{seed}-{k}")))
        tally.require(f"valid {seed}-{k}: {result.kind}", result.kind == "done")
    return tally


def compare_example():
    """The worked example of SPEC.md: its bytes, symbols and triangles, in the code blocks of section 13."""
    tally = Tally()
    spec = decoder.SPEC.read_text(encoding="utf-8")
    blocks = re.findall(r"```\n(.*?)```", spec[spec.index("\n## 13."):spec.index("\n## 14.")], re.S)
    data, events, symbols = bytes.fromhex(blocks[0]), [], []
    decoder.Decoder(data, events=events, symbols=symbols)
    tally.require("example: bytes", data == encode(ROOT / "ref_data" / "octahedron.off", "connectivity"))
    tally.require("example: symbols", blocks[1].splitlines()[1:] == [decoder.symbol_line(*symbol) for symbol in symbols])
    tally.require("example: events", blocks[2].splitlines() == decoder.trace(events) and trace_difference(data) is None)
    result = tally.check("example", data)
    tally.require("example: triangles", blocks[3].splitlines() == [" ".join(map(str, t)) for t in result.triangles()])
    return tally


TRACED = (("holes.off", "positions"), ("holes.off", "connectivity"), ("holes.off", 1000), ("holes.off", 1002),
          ("pyramid_80.off", "positions"), ("components_open.off", "positions"), ("annulus_16x3.off", "connectivity"),
          ("torus_12x8.off", "positions"), ("torus_12x8.off", (1004,) + OF_FACES), ("grid.off", (0,) + OF_FACES),
          ("grid.off", (1024,) + TEXTURES[:1]), ("cylinder.off", (1024,) + OF_FACES[:2]))


def compare_traces():
    """What both decoders read, event by event: wedges, materials, channels of faces, patches and regular levels."""
    tally, seen = Tally(), collections.Counter()
    draw = random.Random("traces")
    for name, how in TRACED:
        whole = encode(ROOT / "ref_data" / name, how)
        cut, damaged = draw.randrange(len(whole)), flip(draw, parts(whole)[5])
        for what, data in (("", whole), (f" cut to {cut} bytes", whole[:cut]),
                           (" with bits flipped", frame(*parts(whole)[:5], damaged))):
            events = []
            difference = trace_difference(data, events)
            tally.require(f"{name} {how}{what}: {difference}", difference is None)
            seen.update(event[0] for event in events)
    header = (ROOT / "include" / "conquest.h").read_text(encoding="utf-8")
    names = {name.lower() for name in re.findall(r"CQ_EVENT_([A-Z]+)", header)}
    tally.require(f"events: {sorted(seen)}, in the header {sorted(names)}", set(seen) == names)
    for event, count in seen.items():
        tally.require(f"only {count} of {event}", count >= 10)
    return tally


def compare_appendix():
    """SPEC.md has the tables and numbers of the header."""
    tally = Tally()
    for name, good in appendix.check():
        tally.require("SPEC.md and the header differ: " + name, good)
    return tally


def compare_edges_of_the_format():
    """Streams at the limits that no mutation finds."""
    tally = Tally()
    triangle = b"\0"
    for name, data, kind in (
            ("empty mesh", frame(0, 0, 0, 0, triangle, b""), "done"),
            ("empty mesh with faces", frame(0, 0, 0, -1, triangle, b""), "corrupt"),
            ("empty mesh with a loop", frame(0, 1, 3, -1, triangle, b""), "corrupt"),
            ("empty mesh, loop without faces", frame(0, 1, 6, -1, triangle, b""), "corrupt"),
            ("vertices without faces", frame(2, 0, 0, 1, triangle, b""), "corrupt"),
            ("nothing", b"", "truncated"),
            ("unused bytes", frame(0, 0, 0, 0, triangle, b"\0\0\0\0\0"), "corrupt"),
            ("long varint", b"CQ\0\x84\x00", "corrupt"),
            ("large varint", b"CQ\0\xff\xff\xff\xff\x10", "corrupt"),
            ("seventeen channels", b"CQ\0\0\0\0\x11", "unsupported"),
            ("many channels", b"CQ\0\0\0\0\x91", "unsupported"),
            ("an extension of nothing", b"CQ\0\0\0\0\x80\0\0\0\0\0", "corrupt"),
            ("rows without vertices", b"CQ\0\0\0\0\x80\1\0\0\0\0", "corrupt"),
            ("one material", b"CQ\0\0\0\0\x80\0\0\0\0\1", "corrupt"),
            ("1025 materials", b"CQ\0\0\0\0\x80\0\0\0\0\x81\x08", "corrupt"),
            ("regular levels of an empty mesh", frame(0, 0, 0, 0, b"\x40", b""), "done"),
            ("rows of too many components", b"CQ\0\4\0\2\xc9" + 9 * b"\x44\4\x08" + b"\5\0\0\0\0", "unsupported"),
            ("version 1", b"CQ\1", "version"),
            ("other magic", b"CR", "format")):
        tally.require(f"{name}: is {tally.check(name, data).kind}", decoder.Decoder(data).kind == kind)
    return tally


# -- All together ------------------------------------------------------------------------------------------------------

def call(job):
    function, *arguments = job
    return function(*arguments)


def package_meshes(limit):
    """Those that the round trip of all meshes accepts, by tests/meshes/expected.tsv."""
    meshes = []
    for line in (ROOT / "tests/meshes/expected.tsv").read_text().splitlines():
        path, outcome, counts = (line.split("\t") + ["", ""])[:3]
        if outcome == "ok" and path.startswith("build/meshes/") and int(counts.split()[0]) <= limit:
            meshes.append((int(counts.split()[0]), ROOT / path))
    return [path for _, path in sorted(meshes, reverse=True)]


def main():
    global options
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--all", action="store_true", help="larger meshes and more streams")
    parser.add_argument("--seed", type=int, default=0, help="of the corrupt and valid streams")
    parser.add_argument("cqm", type=pathlib.Path)
    parser.add_argument("dump", type=pathlib.Path)
    parser.add_argument("channels", type=pathlib.Path)
    options = parser.parse_args()
    small = sorted((ROOT / "ref_data").glob("*.off"))
    jobs = [(compare_appendix,), (compare_example,), (compare_edges_of_the_format,),
            (compare_power_of_two,), (compare_traces,)]
    for path in package_meshes(20000 if options.all else 1000):
        jobs += [(compare_mesh, path, how, 1 if options.all else 0) for how in WAYS]
    for path in small + [many_patches()]:
        channels = 2 * (zlib.crc32(path.name.encode()) % 997)
        seams = tuple(1000 + channels + k for k in range(8 if options.all else 4))
        textures = (channels,) + TEXTURES, (seams[0],) + TEXTURES
        jobs += [(compare_mesh, path, how, 3 if options.all else 2) for how in WAYS + (WIDE, channels, channels + 1) + seams + textures]
    for name, how in (("annulus_3x1.off", "connectivity"), ("icosahedron.off", "positions"), ("torus_3x3.off", 4),
                      ("torus_3x3.off", 5), ("torus_3x3.off", 1004), ("octahedron.off", WIDE)):
        jobs.append((compare_cuts, ROOT / "ref_data" / name, how))
    streams = [encode(path, how) for path in small if path.stat().st_size < 6500
               for how in WAYS + (2, 3, 1002, 1003, 1004, (1005,) + TEXTURES)]
    per_job = 25
    for k in range((14000 if options.all else 400) // per_job):
        jobs.append((compare_corrupt, streams, f"{options.seed}-{k}", per_job))
        jobs.append((compare_valid, f"{options.seed}-{k}", per_job // 2))
    passed = failed = 0
    with multiprocessing.Pool() as pool:
        for tally in pool.imap_unordered(call, jobs):
            passed += tally.passed
            failed += len(tally.failures)
            for line in tally.failures:
                print(line)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
