#!/usr/bin/env python3
"""A second decoder, slow and plain, written from SPEC.md alone.   SPDX-License-Identifier: MIT

    decoder.py [--vertices N] [--trace] [--symbols] FILE     prints the mesh as tests/reference/dump.c does

--vertices stops as soon as the mesh has N vertices. --trace prints events instead of the mesh, as `cqm trace` does, and
--symbols every symbol. Comments name the sections of SPEC.md. The model's start values are read from its appendix.

The mesh is not the one of conquest.h: a dictionary tells for each directed edge the triangle on its left, and rings are
found from it. Virtual vertices have the numbers V, V + 1, ..."""

import argparse
import functools
import math
import pathlib
import re
import sys
import zlib

SPEC = pathlib.Path(__file__).resolve().parents[2] / "SPEC.md"


class End(Exception):
    """Decoding is over; args[0] is the kind of section 11, or "stopped"."""


class Tables:
    """Appendix A."""

    def __init__(self):
        text = SPEC.read_text(encoding="utf-8")
        appendix = text[text.index("## Appendix A."):]
        lists = [[int(n) for n in re.findall(r"-?\d+", block)] for block in re.findall(r"```\n(.*?)```", appendix, re.S)]
        self.bits, self.bare, self.located, linear, self.yes, self.gain, self.logistic = lists
        rows = re.findall(r"^\| ([A-Z_2]+) \| (\d+) \| (\d+) \| ", appendix, re.M)
        self.first = {name: int(first) for name, first, _ in rows}
        sizes = {name: int(size) for name, _, size in rows}
        # A.1: PLAIN begins like FIRST
        self.bits += self.bits[self.first["FIRST"]:self.first["SECOND"]]
        self.bits += (sum(sizes.values()) - len(self.bits)) * [240]
        # A.4: along and above, by class
        rows = [linear[k:k + 3] for k in range(0, 48, 3)]
        self.linear = rows[:8], rows[8:]


TABLES = Tables()

# 8.2
END, BETWEEN, STEPS, GAP, RULE = 0, 48, 80, 320, 576


# -- 1.2 Numbers -------------------------------------------------------------------------------------------------------

def quotient(a, b):
    """a / b: rounded toward zero."""
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def half(a):
    return (a * a).bit_length() if a < 1 << 15 else 2 * a.bit_length()


def log8(a):
    n = a.bit_length() - 1
    return 8 * n + (a << 3 >> n) % 8


def mag(a):
    return a if a >= 0 else -1 - a


def norm(v):
    return 11 * max(map(abs, v)) + 5 * sum(map(abs, v)) >> 4


def sign(a):
    return (a > 0) - (a < 0)


def scaled(x, h):
    return x << h if h >= 0 else x >> -h


def clamp(a, low, high):
    return min(max(a, low), high)


# -- 2. Header and channels --------------------------------------------------------------------------------------------

class Channel:
    """2.4. `first`: the place of its first number among those of a vertex."""

    COMPONENTS = [(3,), (1, 2, 3, 4), (2, 3), (2,), (3, 4), (1, 2, 3, 4), (1, 2, 3, 4), (1,), (1,), (1,),
                  (2, 3, 4)]
    AVERAGE, COPY, PER_FACE = 0, 1, 2

    def __init__(self, kind_and_merge, components, bits):
        self.kind, self.merge = kind_and_merge % 16, kind_and_merge // 16
        self.components, self.bits = components, bits
        self.per_face = self.merge == Channel.PER_FACE
        self.of_row = False
        self.exact = bits == 32
        self.most_bits = 32 if self.exact else 26

    def is_valid(self):
        return self.kind < len(Channel.COMPONENTS) and self.components in Channel.COMPONENTS[self.kind] and \
            self.merge <= Channel.PER_FACE and not (self.per_face and self.components != 1) and \
            (1 <= self.bits <= 24 or self.exact) and not (self.kind == 9 and not (self.per_face and self.bits == 1))

    # 9.11
    def number(self, value):
        if not self.exact:
            return value
        return value if value < 1 << 31 else -1 - (value - (1 << 31))

    def value(self, number):
        """Back; None if no value has that number."""
        if self.exact:
            number = (number + (1 << 31)) % (1 << 32) - (1 << 31)
            return number if number >= 0 else (1 << 31) - 1 - number
        return number if 0 <= number < 1 << self.bits else None

    def rough(self, value):
        return self.number(value) >> 8 if self.exact else value

    def unit(self):
        return 256 if self.exact else 1


class Header:
    def __init__(self, data):
        self.data, self.at = data, 0
        for byte in b"CQ":
            if self.uint(1) != byte:
                raise End("format")
        if self.uint(1) != 0:
            raise End("version")
        self.read_counts()
        self.read_channels()
        self.size = self.varint()
        self.payload_check = self.uint(4)
        check = zlib.crc32(data[:self.at]) & 0xffff
        if self.uint(2) != check:
            raise End("checksum")
        self.payload = data[self.at:self.at + self.size]

    def uint(self, count):
        if self.at + count > len(self.data):
            raise End("truncated")
        value = int.from_bytes(self.data[self.at:self.at + count], "little")
        self.at += count
        return value

    def varint(self):  # 2.2
        value = 0
        for k in range(5):
            byte = self.uint(1)
            if (k == 4 and byte > 15) or (k > 0 and byte == 0):
                raise End("corrupt")
            value += (byte & 127) << 7 * k
            if byte < 128:
                return value
        raise AssertionError

    def read_counts(self):  # 2.3
        self.vertices = self.varint()
        self.loops = self.varint()
        self.edges = self.varint() if self.loops else 0
        z = self.varint()
        chi = -(z + 1) // 2 if z % 2 else z // 2
        self.faces = 2 * (self.vertices + self.loops) - 4 * chi - self.edges
        if not 0 <= self.faces < 1 << 32 or self.edges < 3 * self.loops:
            raise End("corrupt")
        if self.vertices == 0 and (self.loops or self.faces):
            raise End("corrupt")

    def all_faces(self):
        return self.faces + self.edges

    def has_euler(self, euler):  # 5.7
        return euler == 2 * self.vertices - self.faces - self.edges

    def read_channels(self):  # 2.4
        count = self.uint(1)
        extended, self.regular, count = count // 128, count // 64 % 2, count % 64
        if count > 16:
            raise End("unsupported")
        self.channels = []
        for _ in range(count):
            form = self.uint(1)
            channel = Channel(form & ~64, self.uint(1), self.uint(1))
            for _ in range(0 if form & 64 else 1 + min(channel.components, 4)):
                self.uint(4)
            if not channel.is_valid():
                raise End("unsupported")
            self.add_channel(channel)
        self.rows = self.aside_rows = self.aside_faces = self.metadata = self.materials = 0
        if extended:
            self.read_extension()
        of_row = sum(c.components for c in self.channels if c.of_row)
        if self.regular and self.rows and len(self.numbers()) + 2 * of_row > 64:
            raise End("unsupported")

    def add_channel(self, channel):
        channel.first = sum(c.components for c in self.channels if not c.per_face)
        self.channels.append(channel)

    def read_extension(self):  # 2.6
        counts = [self.varint() for _ in range(5)]
        self.rows, self.aside_rows, self.aside_faces, self.metadata, self.materials = counts
        if not any(counts) or self.metadata > 1 << 20 or self.materials == 1 or self.materials > 1024 or \
           (self.rows and not self.vertices < self.rows <= 3 * self.faces):
            raise End("corrupt")
        channels, self.channels = self.channels, []
        for channel in channels:  # 15.1
            channel.of_row = self.rows > 0 and not channel.per_face and channel.kind in (2, 3, 4, 10)
            if channel.of_row:
                channel.first = sum(c.components for c in self.channels if c.of_row)
            else:
                channel.first = sum(c.components for c in self.channels if not c.per_face and not c.of_row)
            self.channels.append(channel)

    @property
    def position(self):
        """The position channel, or None."""
        return next((c for c in self.channels if c.kind == 0 and c.merge == Channel.AVERAGE and not c.exact), None)

    def numbers(self):
        """The channel of each number of a vertex."""
        return [c for c in self.channels if not c.per_face and not c.of_row for _ in range(c.components)]

    def row_channels(self):
        return [(k, c) for k, c in enumerate(self.channels) if c.of_row]

    def face_channels(self):
        return [c for c in self.channels if c.per_face]


# -- 3. Range decoder --------------------------------------------------------------------------------------------------

def adapted(m, bit, rate):
    return m + (65535 - m >> rate) if bit else m - (m >> rate)


class RangeDecoder:
    def __init__(self, payload, symbols):
        self.payload, self.used = payload, 0
        self.range, self.code = 0xffffffff, 0
        self.rate = 4
        self.symbols = symbols
        self.models = [256 * n + 128 for n in TABLES.bits]
        for _ in range(4):
            self.code = self.code << 8 | self.next_byte()
        self.code = min(self.code, 0xfffffffe)

    def next_byte(self):
        byte = self.payload[self.used] if self.used < len(self.payload) else 0
        self.used += 1
        return byte

    def take(self, offset, width):  # 3.2
        self.code -= offset
        self.range = width
        while self.range < 1 << 24:
            self.range <<= 8
            self.code = self.code << 8 | self.next_byte()

    def chance(self, m):  # 3.3
        """A bit that is 1 with a probability of m / 65536."""
        one = (self.range >> 16) * m
        if self.code < one:
            self.take(0, one)
            return 1
        self.take(one, self.range - one)
        return 0

    def bit(self, table, index=0):  # 3.3
        k = TABLES.first[table] + index
        m = self.models[k]
        bit = self.chance(m)
        self.models[k] = adapted(m, bit, self.rate)
        self.log(f"bit {table}[{index}]", bit, m, 65536)
        return bit

    def adaptive(self, name, models, k, rate=None):
        """A bit by a model of another table."""
        m = models[k]
        bit = self.chance(m)
        models[k] = adapted(m, bit, self.rate if rate is None else rate)
        self.log(f"bit {name}[{k}]", bit, m, 65536)
        return bit

    def fixed(self, name, m):
        bit = self.chance(m)
        self.log(name, bit, m, 65536)
        return bit

    def take_slots(self, slot, start, freq, total):
        last = start + freq == total
        self.take(slot * start, self.range - slot * start if last else slot * freq)

    def uniform(self, n):  # 3.5
        slot = self.range // n
        k = min(self.code // slot, n - 1)
        self.take_slots(slot, k, 1, n)
        self.log(f"uniform {n}", k, 1, n)
        return k

    def raw(self, n):
        value = 0
        while n > 16:
            value = value << 8 | self.uniform(256)
            n -= 8
        return value << n | self.uniform(1 << n) if n > 0 else value

    def count(self, table, first):  # 3.6
        for k in range(7):
            if not self.bit(table, first + k):
                return k
        return 7 + self.raw(5)

    def log(self, name, value, freq, total):
        if self.symbols is not None:
            self.symbols.append((name, value, freq, total, self.range, self.code, self.used))


# -- 5. The base mesh --------------------------------------------------------------------------------------------------

class Materials:  # 18
    def __init__(self, decoder):
        self.decoder, self.first = decoder, [0]
        for _ in range(decoder.header.materials - 1):
            left = decoder.header.faces - self.first[-1]
            faces = decoder.coder.raw(left.bit_length())
            if faces > left:
                decoder.reject("corrupt")
            decoder.end_step()
            self.first.append(self.first[-1] + faces)
            decoder.tell("material", len(self.first) - 1, self.first[-1])
        self.end = self.first[1:] + [decoder.header.faces]
        self.next = list(self.first)    # number of the next triangle of each
        self.of, self.number = {}, {}   # of triangles, by id

    def read(self, near, taken=()):
        """That of a new triangle, given those nearby; `taken` go to triangles that are not yet there."""
        m = self.decoder.copied((len(self.first) - 1).bit_length(), near)
        number = self.next[m] + list(taken).count(m) if m < len(self.first) else None
        if number is None or number == self.end[m]:
            self.decoder.reject("corrupt")
        self.decoder.tell("material", m, number)
        return m

    def enter(self, triangle, m):
        self.of[id(triangle)], self.number[id(triangle)] = m, self.next[m]
        self.next[m] += 1
        return self.next[m] - 1

    def numbers(self, materials):
        """Of triangles that are not there yet, one after another."""
        return [self.next[m] + materials[:k].count(m) for k, m in enumerate(materials)]

    def inherit(self, triangle, parent):  # 18
        self.enter(triangle, self.of[id(parent)])

    def near(self, mesh, a, b):
        """Of the triangle on the left of a -> b, if it is real."""
        return [self.of[id(mesh.left[a, b])]] if id(mesh.left[a, b]) in self.of else []

    def split(self, mesh, centre, ends):  # 18
        made = []
        for x in ends:
            if not mesh.is_virtual(x):
                made.append(self.read(made[:1] + self.near(mesh, centre, x) + self.near(mesh, x, centre), made))
        return made


class Base:
    """Halfedge 3 t + k of real triangle t has that number, one of virtual triangle t the number 3 (F + t) + k."""

    def __init__(self, decoder):
        self.decoder, self.coder, self.header = decoder, decoder.coder, decoder.header
        self.real, self.virtual = [], []          # triangles, lists of corners
        self.numbered = {}                        # real ones by their numbers
        self.gate = None
        self.vertices, self.loops = 0, 0          # vertices so far
        self.corners = {}                         # number of triangle corners at a vertex
        self.last = {}                            # the triangle added last at a vertex
        self.after = {}
        self.first_gates = []
        self.scan, self.virtual_scan = 0, 3 * self.header.faces
        self.mesh = Mesh(self.header.vertices, [], [])

    def components(self):
        """Reads one after another; each is in self.mesh from self.first on."""
        more = 1
        while more:
            self.first, self.first_real, self.first_virtual = self.vertices, len(self.real), len(self.virtual)
            self.first_loop = self.loops
            self.start_component()
            self.decoder.end_step()
            while self.find_gate():
                self.grow()
                self.decoder.end_step()
            more = self.coder.bit("COMPONENT")
            self.decoder.end_step()
            self.decoder.tell("component", self.vertices, len(self.real), more)
            self.check(more)
            yield

    def new_vertex(self, may_be_virtual):  # 5.3
        if may_be_virtual and self.loops < self.header.loops and self.coder.bit("LOOP"):
            self.loops += 1
            return self.header.vertices + self.loops - 1
        if self.vertices == self.header.vertices:
            self.decoder.reject("corrupt")
        self.vertices += 1
        return self.vertices - 1

    def is_virtual(self, v):
        return v >= self.header.vertices

    def add_triangle(self, *corners):
        """Returns its first halfedge."""
        virtual = any(map(self.is_virtual, corners))
        triangles, limit = (self.virtual, self.header.edges) if virtual else (self.real, self.header.faces)
        triangle, number, materials = list(corners), len(triangles), self.decoder.materials
        if len(triangles) == limit and (virtual or not materials):  # 18: else no material has a number left
            self.decoder.reject("corrupt")
        if materials and not virtual:
            behind = [] if self.gate is None or self.gate // 3 not in self.numbered else \
                [materials.of[id(self.numbered[self.gate // 3])]]
            number = materials.enter(triangle, materials.read(behind + [materials.of[id(self.real[-1])] if self.real else 0]))
        triangles.append(triangle)
        if not virtual:
            self.numbered[number] = triangle
        for v in corners:
            self.corners[v] = self.corners.get(v, 0) + 1
            self.last[v] = triangle
        self.decoder.tell("triangle", *corners)
        return 3 * (number + (self.header.faces if virtual else 0))

    def corner(self, h, step):
        """The vertex at the start of halfedge h (step 0) or at its end (step 1)."""
        t, k = divmod(h, 3)
        faces = self.header.faces
        triangle = self.numbered[t] if t < faces else self.virtual[t - faces]
        return triangle[(k + step) % 3]

    def is_open(self, h):
        return self.after[self.after[h]] != h

    def start_component(self):  # 5.2
        self.gate = None
        left, right = self.new_vertex(False), self.new_vertex(False)
        h = self.add_triangle(left, right, self.new_vertex(True))
        self.after.update({h: h + 1, h + 1: h + 2, h + 2: h})
        self.gate, self.before, self.before2 = h, h + 2, h + 1
        self.first_gates.append((left, right))

    def find_gate(self):  # 5.6
        if self.is_open(self.gate):
            return True
        if self.decoder.materials:
            return self.find_numbered_gate()
        # Halfedges never open again: all below the scans are closed.
        while self.scan < 3 * len(self.real) and not self.is_open(self.scan):
            self.scan += 1
        found = self.scan
        if self.scan == 3 * len(self.real):
            end = 3 * (self.header.faces + len(self.virtual))
            while self.virtual_scan < end and not self.is_open(self.virtual_scan):
                self.virtual_scan += 1
            if self.virtual_scan == end:
                return False
            found = self.virtual_scan
        self.before2 = found
        self.before = self.after[found]
        self.gate = self.after[self.before]
        return True

    def find_numbered_gate(self):
        numbers = sorted(self.numbered) + [self.header.faces + t for t in range(len(self.virtual))]
        found = next((h for t in numbers for h in range(3 * t, 3 * t + 3) if self.is_open(h)), None)
        if found is None:
            return False
        self.before2 = found
        self.before = self.after[found]
        self.gate = self.after[self.before]
        return True

    def grow(self):  # 5.4
        coder, after = self.coder, self.after
        u, w = self.corner(self.gate, 0), self.corner(self.gate, 1)
        cu, cw = min(self.corners[u], 7), min(self.corners[w], 7)
        border, turn = None, False
        if coder.bit("GROW", 8 * cu + cw):
            x = self.new_vertex(not self.is_virtual(u) and not self.is_virtual(w))
        elif coder.bit("TURN", cu):
            x, border, turn = self.corner(self.before, 0), self.before2, True
        elif coder.bit("CLOSE", cw):
            border = after[self.gate]
            x = self.corner(border, 1)
        else:
            border = self.join()
            x = self.corner(border, 1)
        if x in (u, w):
            self.decoder.reject("corrupt")
        k = self.add_triangle(w, u, x)  # 5.5
        following = after[self.gate]
        after[k + 1] = k + 2 if border is None else after[border]
        after[self.before] = k + 1
        if border is not None:
            after[border] = k + 2
        after[k + 2] = following
        after[self.gate], after[k] = k, self.gate
        if turn:  # 5.6
            self.before2, self.before = border, k + 2
            self.gate = after[self.before]
        else:
            self.gate = k + 1

    def join(self):
        reals = 3 * (self.header.faces if self.decoder.materials else len(self.real))
        count = reals + 3 * len(self.virtual)
        n = self.coder.raw((count - 1).bit_length())
        if n >= count:
            self.decoder.reject("corrupt")
        border = n if n < reals else n - reals + 3 * self.header.faces
        if border not in self.after or not self.is_open(border):
            self.decoder.reject("corrupt")
        return border

    def check(self, more):  # 5.7
        header, mesh = self.header, self.mesh
        mesh.add_triangles(self.real[self.first_real:], self.virtual[self.first_virtual:])
        if mesh.edges_twice:
            raise End("corrupt")
        loops = [header.vertices + k for k in range(self.first_loop, self.loops)]
        for v in [*range(self.first, self.vertices), *loops]:
            ring = mesh.ring(v, self.next_corner(v))
            neighbours = sum(map(self.is_virtual, ring))
            if len(ring) != self.corners[v] or len(ring) < (3 if self.is_virtual(v) else 2) or \
               neighbours > (0 if self.is_virtual(v) else 1):
                raise End("corrupt")
            mesh.valence[v] = len(ring)
        euler = 2 * self.vertices - len(self.real) - len(self.virtual)
        if not more and (self.loops != header.loops or not header.has_euler(euler)):
            raise End("corrupt")

    def next_corner(self, v):  # w0 of 6.2
        triangle = self.last[v]
        return triangle[(triangle.index(v) + 1) % 3]


# -- 4. The mesh -------------------------------------------------------------------------------------------------------

class Mesh:
    def __init__(self, first_virtual, real, virtual):
        self.first_virtual = first_virtual
        self.real, self.virtual = [], []
        self.left = {}     # (u, w) -> the triangle on the left of u -> w
        self.front = {}    # (u, w) -> its third vertex
        self.valence = {}
        self.edges_twice = False
        self.add_triangles(real, virtual)

    def add_triangles(self, real, virtual):
        self.real += real
        self.virtual += virtual
        for triangle in real + virtual:
            for k in range(3):
                self.edges_twice |= (triangle[k], triangle[(k + 1) % 3]) in self.left
            self.enter(triangle)

    def enter(self, triangle):
        for k in range(3):
            edge = triangle[k], triangle[(k + 1) % 3]
            self.left[edge] = triangle
            self.front[edge] = triangle[(k + 2) % 3]

    def ring(self, centre, first):
        """Neighbours clockwise (1.1): the one behind y is the front of y -> centre."""
        ring = [first]
        while True:
            following = self.front[ring[-1], centre]
            if following == first:
                return ring
            ring.append(following)

    def is_virtual(self, v):
        return v >= self.first_virtual

    def split(self, a, b, ring, p, q):  # 8.8
        for k in range(p, q):
            triangle = self.left.pop((a, ring[k + 1]))
            self.left.pop((ring[k], a))
            self.front.pop((a, ring[k + 1]))
            self.front.pop((ring[k], a))
            triangle[triangle.index(a)] = b
            self.enter(triangle)
        self.add(ring[p], a, b)
        self.add(a, ring[q], b)
        self.valence[b] = q - p + 2
        self.valence[a] += 2 - (q - p)
        self.valence[ring[p]] += 1
        self.valence[ring[q]] += 1

    def flip(self, a, b):  # 17.7
        triangles = self.left[a, b], self.left[b, a]
        x, y = self.front[a, b], self.front[b, a]
        places = triangles[0].index(a), triangles[1].index(b)
        del self.left[a, b], self.left[b, a], self.front[a, b], self.front[b, a]
        for triangle, k, corners in zip(triangles, places, ((y, x, a), (x, y, b))):
            for n, corner in enumerate(corners):
                triangle[(k + n) % 3] = corner
            self.enter(triangle)
        for v, change in (a, -1), (b, -1), (x, 1), (y, 1):
            self.valence[v] += change

    def add(self, *corners):
        triangle = list(corners)
        (self.virtual if any(map(self.is_virtual, corners)) else self.real).append(triangle)
        self.enter(triangle)


# -- Vectors -----------------------------------------------------------------------------------------------------------

def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def shifted(a, n):
    return [x >> n for x in a]


def total(vectors):
    return [sum(components) for components in zip([0, 0, 0], *vectors)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]


def part(vector, n):
    return [quotient(x, n) for x in vector]


def wrapped(weight):
    """8.7, 9.8."""
    return (weight + (1 << 15)) % (1 << 16) - (1 << 15)


# -- 8. The pair -------------------------------------------------------------------------------------------------------

class Ring:
    """The ring of a centre, and 8.3."""

    def __init__(self, centre, ring, valences, states, position=None):
        """position: gives that of a vertex, None of a virtual one; None without a position channel."""
        self.centre, self.x, self.states = centre, ring, states
        self.size = len(ring)
        self.val = [min(v, 9) for v in valences]
        self.kind = [4 * (v - 2) + state for v, state in zip(self.val, states)]
        self.length = self.opposite = [0] * self.size
        if position:
            self.locate(position)
            self.find_lengths()
            self.find_angles()

    def locate(self, position):
        origin = position(self.centre)
        self.real = [position(x) is not None for x in self.x]
        offsets = [minus(position(x), origin) if real else [0, 0, 0] for x, real in zip(self.x, self.real)]
        self.h = min(14 - max(mag(c) for o in offsets for c in o).bit_length(), 4)
        self.s = [[scaled(c, self.h) for c in o] for o in offsets]
        self.sq = [dot(s, s) for s in self.s]

    def find_lengths(self):
        logarithms = [log8(sq + 8) for sq in self.sq]
        a, b = sorted(x for x, real in zip(logarithms, self.real) if real)[:2]
        base = (a + b) // 2 - 8
        self.length = [clamp(3 * (x - base) >> 3, 0, 14) if real else 15
                       for x, real in zip(logarithms, self.real)]

    def find_angles(self):
        here, there = [0] * self.size, [0] * self.size
        for k in range(self.size):
            following = (k + 1) % self.size
            a, b, ab = self.sq[k], self.sq[following], dot(self.s[k], self.s[following])
            inverse = (1 << 16) // ((a + b - ab >> 14) + 1)
            here[k] = (b - ab >> 14) * inverse
            there[following] = (a - ab >> 14) * inverse
        self.opposite = [clamp((a + b >> 12) + 1, 0, 15) for a, b in zip(here, there)]

    def alternatives(self, order):  # 8.4
        best, result = 9, [0] * self.size
        for k in order:
            result[k] = best
            if self.states[k] == 0:
                result[k] = min(best, self.val[k] + 1)
                best = min(best, self.val[k])
        return result

    def features(self, ruled):  # 8.2
        """Pairs (p, q) in their order, and the numbers of the weights of each."""
        low, high = self.alternatives(range(self.size)), self.alternatives(range(self.size - 1, -1, -1))

        pairs = [(p, q) for q in range(1, self.size) for p in range(q)]
        result = []
        for p, q in pairs:
            numbers = []
            for k in p, q:
                numbers += [END + self.opposite[k], END + 16 + self.kind[k]]
            for k in range(p + 1, q):
                numbers += [BETWEEN + self.opposite[k], BETWEEN + 16 + self.length[k]]
            numbers.append(STEPS + 24 * clamp(self.size - 3, 0, 9) + q - p)
            if ruled:
                numbers += [RULE + low[p] + 24 - (q - p), RULE + 34 + high[q] + 24 - (q - p)]
            result.append(numbers)
        return pairs, result


class Pairs:
    """The weights of 8.2."""

    TRIES = 16

    def __init__(self, located):
        self.located = located
        self.weight = [256 * n for n in (TABLES.located if located else TABLES.bare)]

    def decode(self, coder, ring):  # 8.6
        pairs, features = ring.features(self.ruled)
        scores = [sum(self.weight[w] for w in numbers) for numbers in features]
        untried = set(range(len(pairs)))
        for rank in range(min(self.TRIES, len(pairs))):
            k = max(untried, key=lambda pair: (scores[pair], pairs[pair][1], -pair))
            untried.remove(k)
            following = max((scores[pair] for pair in untried), default=None)
            if self.is_it(coder, pairs[k], rank, scores[k], following, features[k]):
                return pairs[k]
        return pairs[coder.uniform(len(pairs))]

    def is_it(self, coder, pair, rank, score, following, features):
        gap = 31 if following is None else min(score - following >> 10, 31)
        of_gap = GAP + 32 * min(rank, 7) + gap
        bit, error = self.decision(coder, pair, score + self.weight[of_gap])
        for w in [of_gap] + features if error else []:  # 8.7
            self.weight[w] = wrapped(self.weight[w] + error)
        return bit

    def decision(self, coder, pair, score):  # 8.5
        chance = TABLES.logistic[clamp((score >> 9) + 40, 0, 79)]
        bit = coder.fixed("try %d, %d" % pair, chance)
        shift = 11 if self.located else 12
        return bit, 65536 * bit - chance + (1 << shift - 1) >> shift


# -- 9. Values of a split ----------------------------------------------------------------------------------------------

class Questions:
    """9.6. `worth` is that of HIT, SAME, LEFT, and FLAT."""

    HIT, SAME, LEFT, FLAT = 0, 64, 112, 208

    def __init__(self):
        self.yes = [256 * n + 128 for n in TABLES.yes]
        self.gain = [16 * n for n in TABLES.gain]
        self.worth = dict.fromkeys((Questions.HIT, Questions.SAME, Questions.LEFT, Questions.FLAT), 256)

    def is_used(self, which, vertices):
        return vertices % 32 == 0 or self.worth[which] > 24

    def ask(self, coder, i):
        if self.gain[i] < 0:
            return 0
        kind, first = max(("HIT", Questions.HIT), ("SAME", Questions.SAME), ("FLAT", Questions.FLAT),
                          key=lambda named: (named[1] <= i, named[1]))
        return coder.fixed(f"ask {kind}[{i - first}]", self.yes[i])

    def learn(self, i, answer, saved):
        """Returns the gain."""
        result = clamp(saved, -1024, 1024) - self.cost(self.yes[i]) if answer else -self.cost(65536 - self.yes[i])
        gain = result if self.gain[i] >= 0 else 0
        self.gain[i] += 16 * result - self.gain[i] >> 5
        self.yes[i] = adapted(self.yes[i], answer, 5)
        return gain

    def count(self, which, gain):
        self.worth[which] += 16 * gain - self.worth[which] >> 6

    @staticmethod
    def cost(chance):
        return 1024 - 8 * log8(chance)


class Fan:
    """9.2."""

    def __init__(self, mesh, ring, p, q):
        self.p, self.q = p, q
        x = ring.x
        part = x[p:q + 1]
        self.v = [ring.centre] + [y for y in part if not mesh.is_virtual(y)]
        self.size = len(self.v)
        self.at_boundary = any(map(mesh.is_virtual, part))
        beyond = [x[p - 1]] + [mesh.front[x[k], x[k + 1]] for k in range(p, q)] + [x[(q + 1) % len(x)]]
        if self.at_boundary:
            beyond = [None] * self.size
        self.w = [None if y is None or mesh.is_virtual(y) else y for y in beyond]
        self.known = self.all_known = [k for k in range(self.size) if self.w[k] is not None]
        self.faces = [k for k in range(self.size) if not self.at_boundary or k != ring.x.index(
            next(filter(mesh.is_virtual, part))) - p]
        self.group = 0 if self.at_boundary else min(self.size, 9) - 2


def follow(weights, k, product):
    """9.8 and 9.9."""
    weights[k] = wrapped(weights[k] + 25 * sign(product))


class Linear:
    """9.5."""

    def __init__(self):
        self.along, self.above = ([[128 * n for n in row] for row in rows] for rows in TABLES.linear)


class Place:
    """9.3 to 9.8: the position of one B."""

    def __init__(self, decoder, ring, fan, position):
        self.decoder, self.ring, self.fan, self.position = decoder, ring, fan, position
        self.h = ring.h
        self.find_axes()
        self.find_offsets()
        self.find_features()
        self.predict()

    def find_axes(self):  # 9.3
        ring, fan = self.ring, self.fan
        y = [shifted(ring.s[k], 4) for k in range(fan.p, fan.q + 1) if ring.real[k]]
        normal = total(cross(a, b) for a, b in zip(y, y[1:]))
        t = 1 + ((mag(normal[0]) | mag(normal[1]) | mag(normal[2])) >> 20).bit_length()
        n = shifted(normal, t)
        z = max(range(3), key=lambda k: abs(n[k]))
        self.axes = [(z + 1) % 3, (z + 2) % 3, z]
        self.slope = [-quotient(256 * n[k], n[z]) if n[z] else 0 for k in self.axes[:2]]

    def height(self, a):
        return a[2] - (self.slope[0] * a[0] + self.slope[1] * a[1] >> 8)

    def offset(self, v):
        difference = minus(self.position(v), self.position(self.fan.v[0]))
        return [scaled(difference[k], self.h) for k in self.axes]

    def find_offsets(self):
        fan = self.fan
        self.at = [self.offset(v) for v in fan.v]
        self.out = {k: self.offset(fan.w[k]) for k in fan.known}
        fan.known = [k for k in fan.known if all(-32768 <= c < 32768 for c in self.out[k])]
        self.mean = part(total(self.at), fan.size)

    def following(self, k):
        return self.at[(k + 1) % self.fan.size]

    def find_features(self):  # 9.4
        fan, size, at = self.fan, self.fan.size, self.at
        d = [minus(a, self.mean) for a in at]
        spread = part([sum(abs(x[c]) for x in d) for c in range(3)], size)
        self.extent = sum(spread)
        self.expected = [half(3 * spread[c]) - 2 * self.h - 4 for c in range(2)]
        self.expected.append(half(self.extent) - 2 * self.h - 5)
        f0 = minus(part(total(self.out[k] for k in fan.known), len(fan.known)), self.mean) if fan.known else [0, 0, 0]
        f1 = [-c for c in self.mean]
        f2 = [0, 0, 0] if fan.at_boundary else minus(shifted(plus(at[1], at[-1]), 1), self.mean)
        self.f = [f0, f1, f2]

    def predict(self):  # 9.5
        linear, group = self.decoder.linear, self.fan.group
        self.along, self.above = linear.along[group], linear.above[group]
        self.linear = [self.mean[c] + (sum(w * f[c] for w, f in zip(self.along, self.f)) >> 13) for c in range(2)]
        self.rise = sum(w * self.height(f) for w, f in zip(self.above, self.f)) >> 13

    # 9.6
    def rivals(self):
        at, size, fan = self.at, self.fan.size, self.fan
        result = [minus(plus(at[k], self.following(k)), self.out[k]) for k in fan.known]
        result += [minus(plus(at[k - 1], self.following(k)), at[k]) for k in range(size)]
        for k in range(size - 2):
            for j in range(k + 2, size):
                if (k, j) != (0, size - 1):
                    result.append(shifted(plus(at[k], at[j]), 1))
        return [r for r in result if abs(r[0]) < 1 << 14 and abs(r[1]) < 1 << 14][:16]

    @staticmethod
    def apart(a, b):
        return max(abs(a[0] - b[0]), abs(a[1] - b[1]))

    def planes(self, place):
        at, size, fan = self.at, self.fan.size, self.fan
        if fan.at_boundary or size < 3:
            return []
        triangles = [(at[k], self.following(k), self.out[k]) for k in fan.known]
        if size >= 4:
            triangles += [(at[k], at[k - 1], self.following(k)) for k in range(size)]
        heights = [self.height_of_plane(*triangle, [clamp(c, -65536, 65536) for c in place]) for triangle in triangles]
        return [(z, 0) for z in heights if z is not None and abs(z) < 1 << 14][:16]

    @staticmethod
    def height_of_plane(a, b, c, place):
        n = cross(shifted(minus(b, a), 2), shifted(minus(c, a), 2))
        if abs(n[2]) <= (abs(n[0]) + abs(n[1])) >> 3:
            return None
        n = shifted(n, max(abs(n[2]).bit_length() - 15, 0))
        i = quotient(1 << 29, n[2])
        return a[2] - sum((n[k] * i >> 15) * (place[k] - a[k]) >> 14 for k in range(2))

    def is_flat(self):
        heights = [abs(self.height(f)) for f in self.f]
        return heights[0] | heights[1] | heights[2] < 4 << max(self.h, 0)

    def decode(self):
        """B relative to A, in the order of the components."""
        questions, n = self.decoder.questions, self.decoder.vertices
        self.num_same = 0
        if questions.is_used(Questions.SAME, n):
            self.num_same = 3 if questions.is_used(Questions.LEFT, n) else 1
        self.same_gain = [0, 0]
        rivals = []
        if questions.is_used(Questions.HIT, n) and not self.fan.at_boundary and self.fan.size >= 4:
            rivals = self.rivals()
        self.hit = Contest(self, Questions.HIT, 14, rivals, self.linear)
        x, y, z = self.coordinates()
        self.learn()
        result = [0, 0, 0]
        for axis, value in zip(self.axes, (x, y, z)):
            result[axis] = value
        return result

    # 9.7
    def coordinate(self, kind, e, predicted):
        h = self.h
        predicted = clamp(predicted, -65536, 65536)
        r = predicted + (1 << h - 1) >> h if h > 0 else predicted << -h
        fraction = (predicted + (1 << h - 1) >> h - 2) % 4 if h >= 2 else None
        residual = self.decoder.difference(kind, e, 26, fraction)
        return r + residual, half(abs(residual))

    def common(self, numbers, predicted):
        """Those that are asked about, in their order, and how many have each."""
        many = max(map(numbers.count, numbers))
        last = [k for k, n in enumerate(numbers) if numbers.count(n) == many and n not in numbers[k + 1:]]
        first = min((numbers[k] for k in last), key=lambda n: abs(n - predicted))
        others = sorted((n for n in dict.fromkeys(numbers) if n != first), key=lambda n: abs(n - predicted))
        return [(n, numbers.count(n)) for n in [first] + others][:self.num_same]

    def component(self, c, kind, e, predicted):
        if not self.num_same or self.h < 0:
            return self.coordinate(kind, e, predicted)
        questions = self.decoder.questions
        asked = []
        for i, (common, many) in enumerate(self.common([a[c] for a in self.at], predicted)):
            more = half(abs(common - predicted)) - 2 * self.h - max(e, 0)
            far = sum(more >= least for least in (-2, 1, 4))
            asked.append((Questions.SAME + 48 * i + 16 * c + 4 * (min(many, 4) - 1) + far, common))
            if questions.ask(self.decoder.coder, asked[-1][0]):
                value, size = common >> self.h, max(e, 0)
                break
        else:
            value, size = self.coordinate(kind, e, predicted)
        for i, (question, common) in enumerate(asked):
            answer = int(value == common >> self.h)
            self.same_gain[i > 0] += questions.learn(question, answer, self.price(common - predicted) + 192)
            if answer:
                break
        return value, size

    def price(self, x):
        least = (3 << self.h) // 4 if self.h > 0 else 1
        return 32 * (half(abs(x) + least) - 2 * self.h)

    def coordinates(self):
        h, hit = self.h, self.hit
        if hit.answer:
            e = half(hit.radius) - 2 * h
            x, size_x = self.component(0, "AGREED", e, hit.agreed[0])
            y, size_y = self.component(1, "AGREED", quotient(e + size_x + 1, 2), hit.agreed[1])
        else:
            x, size_x = self.component(0, "FIRST", self.expected[0], self.linear[0])
            y, size_y = self.component(1, "SECOND", self.expected[1], self.linear[1])
        self.b = [scaled(x, h), scaled(y, h)]
        u, v = (clamp(b - m, -65536, 65536) for b, m in zip(self.b, self.mean))
        self.plane = self.mean[2] - self.height([u, v, 0])
        predicted = self.plane + (self.height(minus(hit.agreed, self.mean)) if hit.answer else self.rise)
        used = self.decoder.questions.is_used(Questions.FLAT, self.decoder.vertices) and not self.is_flat()
        self.flat = flat = Contest(self, Questions.FLAT, 2, self.planes(self.b) if used else [], (predicted, 0))
        e = quotient(self.expected[2] + max(size_x, size_y), 2)
        if flat.answer:
            predicted, e = flat.agreed[0], half(flat.radius) - 2 * h
        z, _ = self.component(2, "NORMAL", e, predicted)
        self.b.append(scaled(z, h))
        return x, y, z

    # 9.8
    def learn(self):
        questions = self.decoder.questions
        self.flat.learn((self.b[2], 0), 1)
        errors = minus(self.b[:2], self.linear)
        above = self.b[2] - self.plane - self.rise
        for k, f in enumerate(self.f):
            follow(self.along, k, dot(errors, f))
            follow(self.above, k, above * self.height(f))
        self.hit.learn(self.b, 2)
        if self.num_same:
            questions.count(Questions.SAME, self.same_gain[0])
        if self.num_same > 1:
            questions.count(Questions.LEFT, self.same_gain[1])


class Contest:
    """9.6: rivals, the question that they lead to, and its answer."""

    def __init__(self, place, kind, share, rivals, linear):
        self.place, self.kind, self.linear, self.question, self.answer = place, kind, linear, None, 0
        if not rivals:
            return
        apart, radius = place.apart, share * place.extent // 256 + ((3 << place.h) // 2 if place.h >= 0 else 1)

        def agree(a, b):
            x = apart(a, b)
            return 2 if x < radius // 2 else int(x < radius)

        votes = [sum(agree(a, b) for j, b in enumerate(rivals) if j != k) for k, a in enumerate(rivals)]
        best = votes.index(max(votes))
        near = [r for k, r in enumerate(rivals) if k == best or apart(r, rivals[best]) < radius]
        self.radius, self.agreed = radius, part(total(near), len(near))
        group = next((k for k, most in enumerate((0, 1, 2, 4, 7, 11, 17)) if votes[best] <= most), 7)
        x = apart(self.agreed, linear)
        self.question = kind + 8 * group + sum(x >= radius << i for i in range(5))
        self.answer = place.decoder.questions.ask(place.decoder.coder, self.question)

    def learn(self, b, numbers):
        if self.question is None:
            return
        place, questions = self.place, self.place.decoder.questions
        off = place.apart(b, self.agreed)
        saved = numbers * (place.price(place.apart(b, self.linear)) - place.price(off))
        questions.count(self.kind, questions.learn(self.question, int(off < 3 * self.radius // 2), saved))


# -- Other channels ----------------------------------------------------------------------------------------------------

class Neighbours:
    """9.9: those of a vertex or row whose values are decoded. `at`: their positions less its own. `faces`: those k for
    which there is a triangle with v[k + 1] and v[k]."""

    def __init__(self, v, w, at_boundary, at, faces):
        self.v, self.w, self.size, self.at_boundary = v, w, len(v), at_boundary
        self.at, self.faces = at, faces
        self.known = [k for k in range(self.size) if w[k] is not None]

    def triangles(self):
        """The two others of each triangle."""
        return [((k + 1) % self.size, k) for k in self.faces]

    # 9.13
    @functools.cached_property
    def places(self):
        at = self.fitting(self.at, 12)
        normal = total(cross(at[i], at[j]) for i, j in self.triangles())
        normal = self.fitting([normal], 14)[0]
        if not any(normal):
            normal = [0, 0, 1]
        smallest = min(range(3), key=lambda k: abs(normal[k]))
        a, b = (smallest + 1) % 3, (smallest + 2) % 3
        u = [0, 0, 0]
        u[a], u[b] = normal[b], -normal[a]
        v = part(cross(normal, u), math.isqrt(dot(normal, normal)))
        return self.fitting([[dot(x, u), dot(x, v)] for x in at], 10)

    @staticmethod
    def fitting(vectors, bits):
        """Shifted by what their components have beyond so many bits."""
        everything = 0
        for component in sum(vectors, []):
            everything |= abs(component)
        return [shifted(vector, (everything >> bits).bit_length()) for vector in vectors]

    def keep(self, kept):
        """The places of some are those that they have among all."""
        self.places = [self.places[k] for k in kept]
        self.v, self.size = [self.v[k] for k in kept], len(kept)


class Attributes:
    """9.9 to 9.16. Values are lists of all channels that a vertex has, or a row; `own` is that which is decoded."""

    SETS = PAIR, PAIR_AT_SEAM, FITTED, AT_SEAM, TURN, TURN_BY_FACES, TEXTURE, TEXTURE_AT_SEAM, ROUNDING = range(9)

    def __init__(self, decoder):
        self.decoder, self.coder, self.header = decoder, decoder.coder, decoder.header
        located = self.header.position is not None
        self.weights = [[8192] if located else decoder.linear.along[5][:] for _ in self.header.channels]
        self.skin = [0, 0]
        self.trust = [0, 0]
        self.mirror = 1
        self.lengths = [[[32768] * 16 for _ in range(20)] for _ in self.SETS]
        self.used = [[[0] * 16 for _ in range(20)] for _ in self.SETS]

    def decode(self, k, channel, fan, values, own):
        """Channel k, by its neighbours."""
        if self.is_pair(channel):
            self.pair(k, channel, fan, values, own, fan.v)
            return
        if self.is_texture(channel):
            self.texture(channel, fan, values, own, self.TEXTURE)
            return
        for c in range(channel.first, channel.first + channel.components):
            if channel.merge == Channel.AVERAGE:
                own[c] = self.number(k, channel, fan, c, values, own)
            elif channel.kind == 5:
                own[c] = self.joint(channel, fan, c, values, own)
            else:
                own[c] = self.copied_value(channel, fan, c, values)

    # 15.7
    def residual(self, which, e, most):
        if not self.decoder.rows:
            return self.decoder.difference("PLAIN", 0 if which == self.ROUNDING else e, most)
        models, used = self.lengths[which][min(e, 19)], self.used[which][min(e, 19)]
        n = 0
        while n < 16:
            rate = 1 + (min(used[n], 7) + 1) // 2
            used[n] += 1
            if not self.coder.adaptive(f"LENGTH {which} {min(e, 19)}", models, n, rate):
                break
            n += 1
        if n == 16:
            n += self.coder.raw(5)
        if n == 0:
            return 0
        if n > most:
            return 1 << 26
        r = self.coder.raw(n)
        magnitude = (1 << n - 1) + (r >> 1)
        return Decoder.signed(-magnitude if r % 2 else magnitude)

    def copied_value(self, channel, fan, c, values):  # 9.10
        order = ([0, 1, fan.size - 1] + list(range(2, fan.size - 1)))[:min(fan.size, 6)]
        return self.decoder.copy(channel, [values[fan.v[at]][c] for at in order])

    def joint(self, channel, fan, c, values, own):  # 9.10
        order = ([0, 1, fan.size - 1] + list(range(2, fan.size - 1)))[:min(fan.size, 6)]
        places = range(channel.first, channel.first + channel.components)
        near = [values[fan.v[at]][c] for at in order]
        near += [values[fan.v[at]][other] for at in (0, 1, fan.size - 1) for other in places if other != c]
        had = [value for value in own[channel.first:c] if value]
        asked = list(dict.fromkeys([value for value in near if value not in had] +
                                   [value for value in near if value in had]))
        for k, value in enumerate(asked[:9]):
            if self.coder.bit("JOINT", 4 * min(k, 5) + min(near.count(value), 4) - 1):
                return value
        return self.coder.raw(channel.bits)

    # 9.9
    def skinning(self, kind):
        return [c for c in self.header.channels if c.kind == kind and not c.per_face]

    def weight_joints(self, channel):
        if channel.kind != 6:
            return None
        nth = self.skinning(6).index(channel)
        joints = self.skinning(5)[nth:nth + 1]
        if not joints or joints[0].components != channel.components or \
           self.header.channels.index(joints[0]) > self.header.channels.index(channel):
            return None
        return joints[0]

    def rest(self, channel, c, a, own):
        """What B's weights before this one leave of the sum of A's; or None."""
        places = [(w, at) for w in self.skinning(6) for at in range(w.first, w.first + w.components)]
        here = places.index((channel, c))
        rest = Decoder.signed(sum(a[at] for _, at in places) - sum(own[at] for _, at in places[:here]))
        more = any(a[at] for _, at in places[here + 1:])
        usual = not rest or not more
        same = self.coder.bit("REST", 1 + more if rest else 0)
        return rest if same == usual else None

    def number(self, k, channel, fan, c, values, own):
        if channel.kind == 6 and not channel.exact:
            rest = self.rest(channel, c, values[fan.v[0]], own)
            if rest is not None:
                return self.decoder.value(channel, rest)
        joints = self.weight_joints(channel)

        def near(v, aligned=self.skin[1] <= self.skin[0]):
            if not joints or not aligned:
                return channel.rough(values[v][c])
            here = values[v][joints.first:joints.first + joints.components]
            wanted = own[joints.first + c - channel.first]
            return channel.rough(values[v][channel.first + here.index(wanted)] if wanted in here else 0)

        a = near(fan.v[0])
        t = [near(v) - a for v in fan.v]
        m = quotient(sum(t), fan.size)
        s = o = sum(abs(x - m) for x in t)
        if self.header.position:
            fit, o = self.fit(fan, t, m, s)
            g = [fit]
        else:
            outer = sum(2 * (near(fan.w[n]) - a) - t[n] - t[(n + 1) % fan.size] >> 2 for n in fan.known)
            g = [2 * quotient(outer, len(fan.known) or 1), -m,
                 0 if fan.at_boundary else (t[1] + t[-1] >> 1) - m]
        e = (half(s // fan.size) + half(o // fan.size)) // 2 + (16 if channel.exact else 0)
        weights = self.weights[k]
        prediction = (a + m + sum(x * w >> 13 for x, w in zip(g, weights))) * channel.unit()
        residual = self.residual(self.FITTED, e, channel.most_bits)
        for n, feature in enumerate(g):
            follow(weights, n, residual * feature)
        result = self.decoder.value(channel, prediction + residual)
        if joints:
            for i in range(2):
                off = abs(channel.rough(result) - quotient(sum(near(v, i == 1) for v in fan.v), fan.size))
                self.skin[i] += off - self.skin[i] // 16
        return result

    # 9.13
    def fit(self, fan, t, m, spread):
        """That of B less m, and how far it is from all of the fan."""
        mx, my = (quotient(sum(place[c] for place in fan.places), fan.size) for c in range(2))
        d = [(x - mx >> 2, y - my >> 2, u - m >> 2) for (x, y), u in zip(fan.places, t)]
        xx, yy, xy = sum(x * x for x, _, _ in d), sum(y * y for _, y, _ in d), sum(x * y for x, y, _ in d)
        ux, uy = sum(u * x for x, _, u in d), sum(u * y for _, y, u in d)
        r = (xx + yy) // 64 + 1
        hx, hy, det = self.gradient(xx + r, yy + r, xy, ux, uy)
        if not det:
            return 0, spread
        limit = max(abs(u) for _, _, u in d)
        off = sum(4 * abs(clamp(quotient(hx * x + hy * y, det) - u, -4 * limit, 4 * limit)) for x, y, u in d)
        return 4 * clamp(quotient(-(hx * (mx >> 2) + hy * (my >> 2)), det), -2 * limit, 2 * limit), off

    @staticmethod
    def gradient(xx, yy, xy, ux, uy):
        gx, gy = yy * ux - xy * uy, xx * uy - xy * ux
        n = ((mag(gx) | mag(gy)) >> 30).bit_length()
        return gx >> n, gy >> n, xx * yy - xy * xy >> n

    # 9.14
    def is_pair(self, channel):
        pair = (channel.kind, channel.components) in ((2, 2), (10, 2), (10, 3))
        return self.header.position is not None and pair and channel.merge == Channel.AVERAGE and \
            not channel.exact and channel.bits > 1

    @staticmethod
    def angle(u, v):
        """The angle of two vectors, and N and L."""
        u = shifted(u, ((abs(u[0]) | abs(u[1]) | abs(u[2])) >> 14).bit_length())
        v = shifted(v, ((abs(v[0]) | abs(v[1]) | abs(v[2])) >> 14).bit_length())
        n = cross(u, v)
        x, y = dot(u, v), math.isqrt(dot(n, n))
        low, high = min(abs(x), y), max(abs(x), y)
        t = 65536 * low // high if high else 0
        angle = t * (51472 + (17891 * (65536 - t) >> 16)) >> 16
        if abs(x) < y:
            angle = 102944 - angle
        return 205887 - angle if x < 0 else angle, n

    @staticmethod
    def weighted(vector, angle):
        """A direction with a weight."""
        length = math.isqrt(dot(vector, vector))
        weight = quotient(angle << 24, length) if length else 0
        return [c * weight for c in vector]

    @staticmethod
    def normal(u, v):
        angle, n = Attributes.angle(u, v)
        return Attributes.weighted(n, angle)

    @staticmethod
    def fold(pair, half1):
        x, y = pair
        u, v = half1 - abs(y), half1 - abs(x)
        return [-u if x < 0 else u, -v if y < 0 else v]

    @staticmethod
    def vector(pair, half1):
        z = half1 - sum(map(abs, pair))
        return (Attributes.fold(pair, half1) if z < 0 else list(pair)) + [z]

    @staticmethod
    def pair_of(n, half1):
        m, shift = sum(map(abs, n)), 0
        while m >> shift >= 1 << 38:
            shift += 1
        m >>= shift
        if not m:
            return None
        pair = [((abs(c) >> shift) * half1 + m // 2) // m * (-1 if c < 0 else 1) for c in n[:2]]
        return Attributes.fold(pair, half1) if n[2] < 0 else pair

    # 9.15
    @staticmethod
    def turn_of(a, axes, half1):
        t, side = axes
        along, x = quotient(dot(a, t), half1), dot(a, side)
        if along <= 0:
            return 4 * half1 if along or x else 0
        return clamp(quotient(x - along // 2 if x < 0 else x + along // 2, along), -4 * half1, 4 * half1)

    def axes(self, t, normal, half1):
        pair = self.pair_of(t, half1)
        pair = pair and self.pair_of(cross(normal, self.vector(pair, half1)), half1)
        pair = pair and self.pair_of(cross(self.vector(pair, half1), normal), half1)
        if pair is None:
            return None
        t, length = self.vector(pair, half1), math.isqrt(dot(normal, normal))
        return t, [quotient(c, length) for c in cross(normal, t)]

    def growth(self, k, fan, values, own):
        """The direction in which the first texture coordinate grows, and the sum of angles with signs."""
        texcoords = next((c for c in self.header.channels[:k]
                          if c.kind == 3 and not c.exact and c.merge == Channel.AVERAGE), None)
        result, side = [0, 0, 0], 0
        if texcoords is None:
            return result, side
        at = slice(texcoords.first, texcoords.first + 2)
        for i, j in fan.triangles():
            u, v = (minus(values[fan.v[n]][at], own[at]) for n in (i, j))
            a, b = fan.at[i], fan.at[j]
            det = u[0] * v[1] - u[1] * v[0]
            t = [x * v[1] - y * u[1] for x, y in zip(a, b)]
            everything = 0
            for x in t:
                everything |= mag(x)
            t = shifted(t, (everything >> 20).bit_length())
            if det == 0 or not any(t):
                continue
            angle = self.angle(a, b)[0] * sign(det)
            side += angle
            result = plus(result, self.weighted(t, angle))
        return result, side

    def turned(self, k, channel, direction, own, around, half1):
        normals = next((c for c in self.header.channels[:k] if c.kind == 2 and self.is_pair(c)), None)
        if normals is None:
            return None
        around = [self.vector(pair, half1) for pair in around]
        length = (1 << normals.bits - 1) - 1
        normal = self.vector([c - length for c in own[normals.first:normals.first + 2]], length)
        axes = [self.axes(direction, normal, half1), self.axes(total(around), normal, half1)]
        if axes == [None, None]:
            return None
        many = int(len(around) > 1)
        by_faces = axes[0] is not None and (axes[1] is None or self.trust[many] >= 0)
        t, side = axes[0 if by_faces else 1]
        spread = sum(abs(self.turn_of(a, (t, side), half1)) // len(around) for a in around)
        if not self.coder.bit("AHEAD", by_faces):
            if self.coder.bit("BACK", by_faces):
                t, side = [-c for c in t], [-c for c in side]
            elif self.coder.raw(1):
                t, side = [-c for c in side], t
            else:
                t, side = side, [-c for c in t]
        turn = self.residual(self.TURN_BY_FACES if by_faces else self.TURN, half(spread), 26)
        result = [x * half1 + y * turn for x, y in zip(t, side)]
        if None not in axes:
            a = [quotient(c, half1) for c in result]
            near = [abs(self.turn_of(a, x, half1)) for x in axes]
            self.trust[many] += near[1] - near[0] - quotient(self.trust[many], 16)
        return result

    # 9.14
    def common(self, channel, around):
        """The number of the one around that has the pair, or None."""
        pairs = [pair[:2] for pair in around]
        most = max(map(pairs.count, pairs), default=0)
        if most < 2 or not self.coder.bit("COMMON", min(len(pairs) - most, 3)):
            return None
        return next(pair for pair in pairs if pairs.count(pair) == most)

    def pair(self, k, channel, fan, values, own, around):
        around = [values[r][channel.first:channel.first + channel.components] for r in around]
        result = self.common(channel, around)
        direction, side = self.growth(k, fan, values, own) if channel.kind == 10 else ([0, 0, 0], 0)
        if result is None:
            result = self.new_pair(k, channel, fan, own, direction, [pair[:2] for pair in around])
        if channel.components == 3:
            nearby = int(bool(around) and around[0][2] != 0)
            if self.coder.bit("SIGN_BIT"):
                expected = int(side > 0) if side else nearby
                result = result + [expected ^ 1 ^ self.coder.bit("SAME_SIDE", int(side != 0))]
            else:
                result = result + [self.decoder.value(channel, self.coder.raw(channel.bits))]
        own[channel.first:channel.first + channel.components] = result

    def new_pair(self, k, channel, fan, own, direction, around):
        half1 = (1 << channel.bits - 1) - 1
        around = [[c - half1 for c in pair] for pair in around]
        turned = None
        if channel.kind == 10:
            turned = self.turned(k, channel, direction, own, around, half1)
            direction = turned or [0, 0, 0]
        else:
            direction = total([self.normal(fan.at[i], fan.at[j]) for i, j in fan.triangles()] + [[0, 0, 0]])
        return self.pair_near(channel, direction, around, turned is not None)

    def pair_near(self, channel, direction, around, turned=False):
        half1 = (1 << channel.bits - 1) - 1
        expected = self.pair_of(direction, half1) or (around[0] if around else [0, 0])
        out = sum(map(abs, expected)) > half1
        if out:
            expected = self.fold(expected, half1)
            around = [self.fold(pair, half1) for pair in around]
        spread = sum(sum(map(abs, minus(pair, expected))) // len(around) for pair in around) // 2
        folds = self.coder.bit("FOLDS_BACK") if out else 0
        which, e = (self.ROUNDING, 0) if turned else (self.PAIR if len(around) > 1 else self.PAIR_AT_SEAM, half(spread))
        pair = [c + self.residual(which, e, 26) for c in expected]
        if any(abs(c) >= 1 << 25 for c in pair):
            self.decoder.reject("corrupt")
        if folds:
            pair = self.fold(pair, half1)
        values = [channel.value(c + half1) for c in pair]
        if None in values:
            self.decoder.reject("corrupt")
        return values

    # 9.16
    def is_texture(self, channel):
        return self.header.position is not None and channel.kind == 3 and channel.merge == Channel.AVERAGE

    def texture(self, channel, fan, values, own, which):
        of_fan = [[channel.rough(values[v][channel.first + c]) for c in range(2)] for v in fan.v]
        t = [minus(x, of_fan[0]) for x in of_fan]
        everything = 0
        for u, v in t:
            everything |= abs(u) | abs(v)
        n = 20 - everything.bit_length()
        t = [[rescaled(c, n) for c in x] for x in t]
        similarity = Similarity(fan.places, t, self.mirror)
        self.mirror = similarity.mirror
        off = similarity.off() // (2 * fan.size)
        e = (half(off >> n) if n >= 0 else half(off) - 2 * n) + (16 if channel.exact else 0)
        moved = similarity.map((0, 0), 2 * similarity.most)
        for c in range(2):
            prediction = (of_fan[0][c] + rescaled(moved[c], -n)) * channel.unit()
            own[channel.first + c] = self.decoder.value(
                channel, prediction + self.residual(which, e, channel.most_bits))


def rescaled(c, n):
    return c << n if n >= 0 else c + (1 << -n - 1) >> -n


class Similarity:
    """9.16: takes places to texture coordinates t."""

    def __init__(self, places, t, mirror):
        self.places, self.t = places, t
        weights = [4096 // (1 + math.isqrt(dot(place, place))) for place in places]
        self.of_places, self.of_t = ([quotient(sum(w * x[c] for w, x in zip(weights, vectors)), sum(weights))
                                      for c in range(2)] for vectors in (places, t))
        d = [minus(place, self.of_places) for place in places]
        e = [minus(x, self.of_t) for x in t]
        self.most = max(abs(c) for x in e for c in x)
        (xu, xv), (yu, yv) = ([sum(w * x[i] * u[j] for w, x, u in zip(weights, d, e)) for j in range(2)]
                              for i in range(2))
        q = sum(w * dot(x, x) for w, x in zip(weights, d)) or 1
        shift = ((mag(xu) | mag(xv) | mag(yu) | mag(yv)) >> 30).bit_length()
        turn = (xu >> shift) * (yv >> shift) - (xv >> shift) * (yu >> shift)
        self.mirror = sign(turn) if len(places) > 2 and turn else mirror
        self.re, self.im = quotient(256 * (xu + self.mirror * yv), q), quotient(256 * (xv - self.mirror * yu), q)

    def map(self, place, limit):
        x, y = place[0] - self.of_places[0], self.mirror * (place[1] - self.of_places[1])
        result = quotient(self.re * x - self.im * y, 256), quotient(self.im * x + self.re * y, 256)
        return [clamp(c, -limit, limit) + m for c, m in zip(result, self.of_t)]

    def off(self):
        if len(self.t) == 2:
            return sum(map(abs, self.t[1]))
        return sum(abs(a - b) for place, x in zip(self.places, self.t) for a, b in zip(self.map(place, 1 << 22), x))


# -- 15. Rows ----------------------------------------------------------------------------------------------------------

class Rows:
    def __init__(self, decoder, mesh):
        self.decoder, self.coder, self.header = decoder, decoder.coder, decoder.header
        self.mesh = mesh
        self.of = {}          # rows of a real triangle's corners, by id
        self.vertex, self.values = [], []
        self.count, self.full = 0, False
        self.contexts = [{"ALL": [59000], "USUAL": [59000] * 24, "OTHER": [32768] * 6, "SAME_ROW": [32768] * 3,
                          "NEW_ROW": [32768] * 3} for _ in range(27)]
        self.equal = [[32768] * 12 for _ in self.header.channels]
        self.attributes = decoder.attributes
        self.sizes, self.first_sizes = ([[0] * 4 for _ in self.header.channels] for _ in range(2))

    def add(self, vertex):
        if self.count == self.header.rows:
            self.full = True
            return 0
        self.vertex.append(vertex)
        self.values.append([None] * sum(c.components for _, c in self.header.row_channels()))
        self.decoder.tell("row", self.count, vertex)
        self.count += 1
        return self.count - 1

    # 15.2
    def read_component(self, base):
        for v in range(base.first, base.vertices):
            ring = self.mesh.ring(v, base.next_corner(v))
            first, before = self.count, None
            around = []        # triangles, None for virtual ones
            for w in ring:
                triangle = self.mesh.left[v, w]
                around.append(None if any(map(self.mesh.is_virtual, triangle)) else triangle)
                if around[-1] is None:
                    before = None
                    continue
                rows = self.of.setdefault(id(triangle), [None] * 3)
                rows[triangle.index(v)] = before = self.base_corner(first, before, v)
                self.decoder.tell("corner", v, before)
                self.decoder.end_step()
            for row in range(first, self.count):
                triangles = self.triangles_of(row, v, around)
                for k, channel in self.header.row_channels():
                    self.base_row(k, channel, row, first, v, triangles)
                    self.decoder.tell("values", k, row, *self.values[row][self.part(channel)])
                    self.decoder.end_step()

    # 15.3
    def triangles_of(self, row, v, around):
        def has_row(k):
            triangle = around[k % len(around)]
            return triangle is not None and self.of[id(triangle)][triangle.index(v)] == row

        t = next(k for k in range(len(around)) if has_row(k))
        begin = t
        while t - begin < 15 and begin - 1 > t - len(around) and has_row(begin - 1):
            begin -= 1
        end = begin + 1
        while end - begin < min(16, len(around)) and has_row(end):
            end += 1
        return [around[k % len(around)] for k in range(begin, end)]

    def known_rows(self, v, triangles):
        known = []
        for triangle in triangles:
            at = triangle.index(v)
            for k in at + 1, at + 2:
                row = self.of[id(triangle)][k % 3]
                if triangle[k % 3] < v and row not in known:
                    known.append(row)
        return known

    def base_corner(self, first, before, v):
        known, models, coder = self.count - first, self.contexts[0], self.coder
        others = known - (before is not None)
        m = min(known, 3) - 1
        if before is not None and coder.adaptive("SAME_ROW", models["SAME_ROW"], m):
            return before
        if others == 0 or coder.adaptive("NEW_ROW", models["NEW_ROW"], m):
            row = self.add(v)
            if self.full:
                self.decoder.reject("corrupt")
            return row
        n = coder.raw((others - 1).bit_length())
        if n >= others:
            self.decoder.reject("corrupt")
        return [row for row in range(first, self.count) if row != before][n]

    def is_equal(self, k, channel, model, row, other):
        if not self.coder.adaptive(f"EQUAL {k}", self.equal[k], model):
            return False
        part = self.part(channel)
        self.values[row][part] = self.values[other][part]
        return True

    @staticmethod
    def part(channel):
        return slice(channel.first, channel.first + channel.components)

    def base_row(self, k, channel, row, first, v, triangles):
        known = self.known_rows(v, triangles)
        if known and self.is_equal(k, channel, 6, row, known[0]):
            return
        if row > first and self.is_equal(k, channel, 7, row, row - 1):
            return
        if channel.kind == 2 and self.attributes.is_pair(channel):
            others = [[self.offset(t[(t.index(v) + n) % 3], v) for n in (1, 2)] for t in triangles]
            direction = total(self.attributes.normal(*t) for t in others)
            half1 = (1 << channel.bits - 1) - 1
            around = [[c - half1 for c in self.values[r][self.part(channel)]] for r in known]
            self.values[row][self.part(channel)] = self.attributes.pair_near(channel, direction, around)
            return
        sizes = self.sizes[k] if known else self.first_sizes[k]
        for c in range(channel.components):
            at = channel.first + c
            near = [self.values[other][at] for other in known or [row - 1] * (row > 0)]
            if len(near) > 1:
                prediction = quotient(sum(map(channel.rough, near)), len(near)) * channel.unit()
            elif near:
                prediction = channel.number(near[0])
            else:
                prediction = 0 if channel.exact else 1 << channel.bits - 1
            self.values[row][at] = self.decoder.base_value(channel, prediction, sizes, c)

    # 15.4
    def row(self, u, v):
        """The row of u in the triangle on the left of u -> v."""
        triangle = self.mesh.left[u, v]
        return self.of[id(triangle)][triangle.index(u)] if id(triangle) in self.of else None

    def row_in(self, of, u, v):
        """The row of a vertex in the triangle on the left of u -> v."""
        triangle = self.mesh.left[u, v]
        return self.of[id(triangle)][triangle.index(of)] if id(triangle) in self.of else None

    def split(self, ring, p, q):
        a, x, size = ring.centre, ring.x, ring.size
        self.a, self.x, self.p, self.q, self.b = a, x, p, q, self.decoder.vertices
        at_centre = [self.row(a, y) for y in x]
        after = (q + 1) % size
        kept = {at_centre[k] for k in range(size) if not p < k <= q}
        self.made = []        # row, neighbour, corner (None: split)
        self.run = {}
        for k in range(p + 1, q + 1):
            row = at_centre[k]
            self.run[k] = self.split_row(row) if row is not None and row in kept else row
        different = len(set(at_centre) - {None})
        self.context = 3 * (3 * self.seam(at_centre[p], at_centre[p + 1]) + self.seam(at_centre[after], at_centre[q])) \
            + max(min(different, 3), 1) - 1
        there = [not self.mesh.is_virtual(x[p]), not self.mesh.is_virtual(x[q])]
        corners = self.read_corners(there, [
            (at_centre[p], None), (self.run[p + 1], None), (self.row_in(x[p], a, x[p]), self.row_in(x[p], x[p], a)),
            (at_centre[after], None), (self.run[q], None), (self.row_in(x[q], x[q], a), self.row_in(x[q], a, x[q]))])
        self.decoder.end_step()
        if self.full:
            self.decoder.reject("corrupt")
        self.corners = corners
        for k, channel in self.header.row_channels():
            for n, (row, neighbour, corner) in enumerate(self.made):
                if corner is None:
                    self.split_value(k, channel, n, row, neighbour)
                else:
                    self.seam_value(k, channel, row, neighbour, corner)
                self.decoder.tell("values", k, row, *self.values[row][self.part(channel)])
                self.decoder.end_step()
        return corners

    @staticmethod
    def seam(a, b):
        return 2 if a is None or b is None else int(a != b)

    def make(self, vertex, neighbour, corner):
        row = self.add(vertex)
        self.made.append((row, neighbour, corner))
        return row

    def split_row(self, row):
        for made, neighbour, _ in self.made:
            if neighbour == row:
                return made
        if len(self.made) == 2:
            self.full = True
            return row
        return self.make(self.b, row, None)

    def read_corners(self, there, choices):
        def choice(usual, other):
            if usual is None:
                return other, None
            return usual, None if other == usual else other

        choices = [choice(*c) for c in choices]
        models, coder = self.contexts[self.context], self.coder
        everything = all(choices[k][0] is not None for k in range(6) if there[k // 3])
        if everything and coder.adaptive("ALL", models["ALL"], 0):
            return [choices[k][0] if there[k // 3] else None for k in range(6)]
        rows = [None] * 6
        vertices = [self.a, self.b, self.x[self.p], self.a, self.b, self.x[self.q]]
        for k in range(6):
            if not there[k // 3]:
                continue
            if k in (3, 4) and there[0]:
                choices[k] = choice(choices[k][0], rows[k - 3])
            usual, other = choices[k]
            u = [rows[n] == choices[n][0] for n in range(6)]
            history = [0, u[0], 2 * (other is None) + (u[0] and u[1]), 2 * u[0] + u[1], 2 * u[1] + u[3],
                       2 * (other is None) + (u[3] and u[4])][k]
            if usual is not None and coder.adaptive("USUAL", models["USUAL"], 4 * k + history):
                rows[k] = usual
            elif other is not None and coder.adaptive("OTHER", models["OTHER"], k):
                rows[k] = other
            else:
                rows[k] = self.make(vertices[k], usual, k)
            self.decoder.tell("corner", vertices[k], rows[k])
        return rows

    def apply(self, ring, p, q, corners):
        """After the split of the mesh."""
        mesh, x = self.mesh, ring.x
        for k in range(p + 1, q + 1):
            triangle = mesh.left[self.b, x[k]]
            if self.run[k] is not None:
                self.of[id(triangle)][triangle.index(self.b)] = self.run[k]
                self.vertex[self.run[k]] = self.b
        if not mesh.is_virtual(x[p]):
            self.of[id(mesh.left[x[p], ring.centre])] = [corners[2], corners[0], corners[1]]
        if not mesh.is_virtual(x[q]):
            self.of[id(mesh.left[ring.centre, x[q]])] = [corners[3], corners[5], corners[4]]
        self.decoder.num_rows = self.count

    # 15.5
    def fan(self, row, neighbour):
        mesh, a, x, p, q = self.mesh, self.a, self.x, self.p, self.q
        v, faces = [neighbour], []
        for k in range(p, q + 1):
            before = k > p and self.run[k] == row
            if before:
                faces.append(len(v) - 1)
            if before or (k < q and self.run[k + 1] == row):
                v.append(self.row_in(x[k], a, x[k]) if before else self.row_in(x[k], x[k], a))
        if self.run[p + 1] == row and self.corners[1] == row:
            faces.append(0)
        if self.run[q] == row and self.corners[4] == row:
            faces.append(len(v) - 1)
        at = [self.offset(self.vertex[r], self.b) for r in v] if self.header.position else []
        return Neighbours(v, [None] * len(v), True, at, faces)

    def fan_of_corners(self, row):
        """Of a row that only new triangles have: 15.6."""
        v, at, faces = [], [], []
        vertices = [self.a, self.b, self.x[self.p], self.a, self.b, self.x[self.q]]
        for c, (i, j) in enumerate(((1, 2), (2, 0), (0, 1), (5, 4), (3, 5), (4, 3))):
            if self.corners[c] == row and self.header.position:
                faces.append(len(v))
                v += [self.corners[j], self.corners[i]]
                at += [self.offset(vertices[n], vertices[c]) for n in (j, i)]
        return Neighbours(v, [None] * len(v), True, at, faces)

    def same(self, channel, a, b):
        part = self.part(channel)
        return self.values[a][part] == self.values[b][part]

    def split_value(self, k, channel, n, row, neighbour):
        if n == 1 and self.is_equal(k, channel, int(self.same(channel, self.made[0][1], neighbour)), row, row - 1):
            return
        self.attributes.decode(k, channel, self.fan(row, neighbour), self.values, self.values[row])

    def position(self, v):
        at = self.header.position.first
        return self.decoder.values[v][at:at + 3]

    def offset(self, v, start):
        return minus(self.position(v), self.position(start))

    # 15.6
    def seam_value(self, k, channel, row, neighbour, corner):
        face = corner // 3 * 3
        companion = max((r for r in self.corners[face:face + 3] if r is not None and r < row), default=None)
        if companion is not None:
            as_neighbour = neighbour is not None and self.same(channel, companion, neighbour)
            if self.is_equal(k, channel, 2 + as_neighbour, row, companion):
                return
        if neighbour is not None and self.is_equal(k, channel, 4 + (companion is not None), row, neighbour):
            return
        asked = self.distinct(channel, [r for r in (companion, neighbour) if r is not None])
        nearby = self.distinct(channel, asked + self.rows_nearby(row, corner))[:6]
        for n, other in enumerate(nearby[len(asked):]):
            if self.is_equal(k, channel, 8 + min(n, 3), row, other):
                return
        if self.attributes.is_pair(channel):
            order = (companion, neighbour) if channel.kind == 10 else (neighbour, companion)
            around = [r for r in order if r is not None][:1]
            self.attributes.pair(k, channel, self.fan_of_corners(row), self.values, self.values[row], around)
            return
        if self.attributes.is_texture(channel):
            fan = self.fan_of_corners(row)
            fan.keep([n for n, r in enumerate(fan.v) if r < row and r not in fan.v[:n]])
            if fan.size > 1:
                self.attributes.texture(channel, fan, self.values, self.values[row], Attributes.TEXTURE_AT_SEAM)
                return
        near, far = neighbour, companion
        if near is None or (channel.kind == 2 and far is not None):
            near, far = far, near
        for at in range(channel.first, channel.first + channel.components):
            values = [self.values[r][at] for r in (near, far) if r is not None]
            self.values[row][at] = self.decoder.copy(channel, values) if channel.merge == Channel.COPY else \
                self.near_value(channel, at, near, far)

    def distinct(self, channel, rows):
        return [r for n, r in enumerate(rows) if not any(self.same(channel, r, before) for before in rows[:n])]

    def rows_nearby(self, row, corner):
        """Other rows of the vertex of a corner, before the split."""
        mesh, a, x, p, q = self.mesh, self.a, self.x, self.p, self.q
        if corner in (0, 3):
            rows = [self.row_in(a, a, x[n % len(x)]) for n in range(p + len(x), q, -1)]
        elif corner in (1, 4):
            rows = [self.run[k] for k in range(p + 1, q + 1) if self.run[k] is not None and self.run[k] < row]
        else:
            v = x[p if corner == 2 else q]
            ahead, back, rows = self.third(a, v), a, []
            for _ in range(4):
                rows += [self.row_in(v, v, ahead), self.row_in(v, v, back)]
                ahead, back = self.third(ahead, v), self.third(v, back)
        return [r for r in rows if r is not None]

    def third(self, i, j):
        """The third vertex of the triangle left of an edge."""
        triangle = self.mesh.left[i, j]
        return triangle[triangle.index(j) - 2]

    def near_value(self, channel, at, near, far):
        expected = 0 if near is None else channel.number(self.values[near][at])
        apart = 1 << channel.bits >> 2 if channel.bits < 24 else 1 << 22
        if near is not None and far is not None and near != far:
            apart = channel.rough(self.values[far][at]) - channel.rough(self.values[near][at])
        e = half(abs(apart)) + (16 if channel.exact else 0)
        residual = self.attributes.residual(Attributes.AT_SEAM, e, channel.most_bits)
        return self.decoder.value(channel, expected + residual)


def read_aside(decoder):  # 16
    header, coder = decoder.header, decoder.coder
    rows, faces = decoder.aside
    channels = [c for c in header.channels if not c.per_face]
    sizes = [[0] * 4 for _ in channels]
    for _ in range(header.aside_rows):
        values = []
        for k, channel in enumerate(channels):
            for c in range(channel.components):
                at = len(values)
                prediction = channel.number(rows[-1][at]) if rows else 0 if channel.exact else 1 << channel.bits - 1
                values.append(decoder.base_value(channel, prediction, sizes[k], c))
            decoder.end_step()
        rows.append(values)
    count = (header.rows or header.vertices) + header.aside_rows
    for _ in range(header.aside_faces):
        face = []
        for _ in range(3):
            face.append(coder.raw((count - 1).bit_length() if count else 0))
            if face[-1] >= count:
                decoder.reject("corrupt")
        if decoder.materials:
            face.append(decoder.copied((header.materials - 1).bit_length(), [faces[-1][3] if faces else 0]))
            if face[-1] >= header.materials:
                decoder.reject("corrupt")
        at = len(face)
        for k, channel in enumerate(header.face_channels()):
            face.append(decoder.copy(channel, [faces[-1][at + k] if faces else 0]))
        decoder.end_step()
        faces.append(face)
    letters = [32768] * 256
    for _ in range(header.metadata):
        node = 1
        for _ in range(8):
            node = 2 * node + coder.adaptive("LETTER", letters, node)
        decoder.end_step()
        decoder.metadata += bytes([node - 256])


# -- The decoder -------------------------------------------------------------------------------------------------------

FREE, HELD, HELD_OFTEN, TAKEN = range(4)  # 7.4


class Decoder:
    events = None

    def __init__(self, data, stop=None, events=None, symbols=None, limit=None):
        """Decodes at once. `stop`: at so many vertices. `limit`: refuse more vertices, triangles or edges, "limit".
        `events`, `symbols`: lists that get these."""
        self.kind = None
        self.vertices = 0      # of the result
        self.base_vertices = 0
        self.values = []       # per vertex, all channels of vertices in a row
        self.face_values = {}  # per real triangle, by id: of all channels of faces
        self.mesh = None
        self.complete = None   # while the base is read: the triangles of complete components
        self.rows = None       # 15
        self.materials = None  # 18
        self.num_rows = 0
        self.aside = [], []    # 16: rows; triangles with their values
        self.metadata = b""
        self.levels = self.error = 0
        self.stop, self.events = stop, events
        try:
            self.header = Header(data)
            h = self.header
            if limit is not None and max(h.vertices, h.faces, h.edges, h.rows, h.aside_rows, h.aside_faces) > limit:
                raise End("limit")
            self.coder = RangeDecoder(self.header.payload, symbols)
            self.decode()
        except End as end:
            self.kind = end.args[0]

    def triangles(self):
        """Those of the mesh; while the base is read, of its components that are complete."""
        if self.mesh is None:
            return []
        real = self.mesh.real if self.complete is None else self.complete
        return sorted(real, key=lambda triangle: self.materials.number[id(triangle)]) if self.materials else real

    # 10.2
    def is_starved(self):
        have = len(self.header.payload)
        return have < self.header.size and self.coder.used > have

    def end_step(self):
        if self.is_starved():
            raise End("truncated")

    def tell(self, *event):
        """An event, as `cqm trace` prints it, unless bytes are missing for it."""
        if self.events is not None and not self.is_starved():
            self.events.append(event)

    def tell_values(self, k, v, values):
        """Those of channel k of a vertex, out of its numbers."""
        channel = self.header.channels[k]
        self.tell("values", k, v, *values[channel.first:channel.first + channel.components])

    def reject(self, kind):
        """The step that is being read is at fault, if all of it is there."""
        self.end_step()
        raise End(kind)

    def decode(self):
        self.start_models()
        if self.header.materials:
            self.materials = Materials(self)
        if self.header.vertices:
            self.read_base(Base(self))
        self.stop_here()
        while self.vertices < self.header.vertices:
            self.level()
        if self.num_rows != self.header.rows:
            raise End("corrupt")
        read_aside(self)
        # 10.1
        if self.coder.used < self.header.size:
            raise End("corrupt")
        if zlib.crc32(self.header.payload) != self.header.payload_check:
            raise End("checksum")
        self.error = 0
        self.tell("end", self.levels, self.vertices, len(self.triangles()))
        raise End("done")

    def read_base(self, base):
        if self.header.rows:
            self.rows = Rows(self, base.mesh)
        self.base_sizes, self.first_sizes = ([0] * len(self.header.numbers()) for _ in range(2))
        before = None
        self.mesh, self.complete = base.mesh, []
        for _ in base.components():
            self.base_values(base)
            before = self.base_face_values(base, before)
            if self.rows:
                self.rows.read_component(base)
                self.num_rows = self.rows.count
            self.vertices, self.complete = base.vertices, list(base.mesh.real)
            self.stop_here()
        self.complete = None
        self.first_gates, self.base_vertices = base.first_gates, base.vertices

    def stop_here(self):
        if self.stop is not None and self.vertices >= self.stop:
            raise End("stopped")

    def start_models(self):
        self.pairs = Pairs(self.header.position is not None)
        self.questions, self.linear = Questions(), Linear()
        self.attributes = Attributes(self)
        self.code, self.active = 0, 0
        self.regular = False

    # -- 6. Base values

    def residual(self, kind, expected, c, most=26, fraction=None):  # 6.1
        coder = self.coder
        n = self.number_of_bits(kind, expected, 25 + c)
        if n == 0:
            return 0
        if n > most:
            return 1 << 26
        low = max(n - 2, 0)
        top = 1 if n == 1 else 2 + coder.bit(kind, min(n, 26) - 2)
        if fraction is not None and n <= 3:
            negative = coder.bit("SMALL", 4 * (n - 1) + fraction)
            rest = coder.raw(low)
        else:
            r = coder.raw(low + 1)
            negative, rest = r >> low, r % (1 << low)
        magnitude = top << low | rest
        return self.signed(-magnitude if negative else magnitude)

    @staticmethod
    def signed(number):  # 9.11
        return (number + (1 << 31)) % (1 << 32) - (1 << 31)

    def number_of_bits(self, kind, expected, index):
        if expected == 0 or self.coder.bit(kind, index):
            return expected + self.coder.count(kind, index + 1)
        return max(expected - 1 - self.coder.count(kind, index + 8), 0)

    def difference(self, kind, e, most=26, fraction=None):
        e = max(e, 0)
        return self.residual(kind, e // 2, 16 * (e if e < 10 else 10 + e % 2), most, fraction)

    def value(self, channel, number):
        value = channel.value(number)
        if value is None:
            self.reject("corrupt")
        return value

    def base_values(self, base):  # 6.2
        numbers = self.header.numbers()
        for v in range(base.first, base.vertices):
            sizes = self.first_sizes if v == base.first and v else self.base_sizes
            known = [w for w in base.mesh.ring(v, base.next_corner(v)) if w < v][:64]
            values = []
            self.values.append(values)
            for k, channel in enumerate(numbers):
                if known:
                    total_of_known = sum(channel.rough(self.values[w][k]) for w in known)
                    prediction = quotient(total_of_known, len(known)) * channel.unit()
                elif v:
                    prediction = channel.number(self.values[v - 1][k])
                else:
                    prediction = 0 if channel.exact else 1 << channel.bits - 1
                values.append(self.base_value(channel, prediction, sizes, k))
                if len(values) == channel.first + channel.components:
                    self.tell_values(self.header.channels.index(channel), v, values)
            self.end_step()

    def base_value(self, channel, prediction, sizes, k):
        residual = self.residual("BASE", sizes[k].bit_length(), 0, channel.most_bits)
        sizes[k] = (3 * sizes[k] + min(abs(residual), 1 << 28)) // 4
        return self.value(channel, prediction + residual)

    def copy(self, channel, near):
        return self.copied(channel.bits, near)

    def copied(self, bits, near):  # 6.3
        refused = []
        for value in near:
            if value in refused:
                continue
            if self.coder.bit("COPY", 4 * min(len(refused), 2) + min(near.count(value), 3)):
                return value
            refused.append(value)
        return self.coder.raw(bits)

    def base_face_values(self, base, before):  # 6.4
        channels = self.header.face_channels()
        new = list(enumerate(base.real))[base.first_real:]
        if self.materials:
            new = sorted((self.materials.number[id(triangle)], triangle) for _, triangle in new)
        for number, triangle in new if channels else ():
            given, before = before, []
            for k, channel in enumerate(channels):
                before.append(self.copy(channel, [given[k]] if given else [0]))
                self.tell("face", self.header.channels.index(channel), number, before[k])
            self.face_values[id(triangle)] = before
            self.end_step()
        return before

    # -- 7. Levels

    def level(self):
        self.levels += 1
        if self.levels > 255:
            raise End("corrupt")
        self.regular = self.regular or int(self.header.regular and self.coder.bit("OTHER_LEVEL"))
        self.end_step()
        self.read_error()
        self.tell("level", self.levels, self.regular, self.code)
        self.coder.rate = 4 if self.vertices < 512 else 5 if self.vertices < 4096 else 6  # 3.3
        if self.regular:
            RegularLevel(self).decode()
            return
        self.read_active()
        self.pairs.ruled = not self.header.position or self.coder.bit("RULED")
        self.end_step()
        before, self.splits = self.count_active(), 0
        self.conquest()
        if self.splits < before // 16 + 1:
            raise End("corrupt")

    def read_error(self):  # 7.2
        if not self.header.position:
            return
        code = self.coder.raw(8) if self.levels == 1 else max(self.code - self.coder.count("ERROR", 0), 0)
        self.end_step()
        self.code = code
        octave, part = divmod(code - 1, 8)
        self.error = 0 if code == 0 else (1 << 32) - 1 if octave > 27 else ((8 + part << octave) + 7) // 8

    def read_active(self):  # 7.3
        while self.active < len(self.first_gates):
            begins = self.coder.bit("BEGINS")
            self.end_step()
            if not begins:
                break
            self.active += 1

    def count_active(self):
        """Real vertices of the components that take part: of the base the first ones, and all others."""
        others = self.first_gates[self.active:]
        return self.vertices - (self.base_vertices - others[0][0] if others else 0)

    def conquest(self):  # 7.4
        self.states = {}
        self.queue, self.was_queued = [], set()
        self.room = self.header.all_faces() // 3 + 1
        for left, right in self.first_gates[:self.active]:
            first = self.first_patch(left, right)
            for v in left, right:
                self.states.setdefault(v, HELD)
            self.conquer(*first)
            while self.queue:
                v, entry = self.queue.pop(0)
                if self.state(v) == FREE:
                    self.conquer(v, entry)

    def state(self, v):
        return TAKEN if self.mesh.is_virtual(v) else self.states.get(v, FREE)

    def first_patch(self, left, right):  # 7.5
        """The centre, and the first vertex of its ring."""
        front = self.mesh.front
        if not self.coder.bit("SIDE", 0):
            if self.mesh.is_virtual(front[left, right]):
                return front[right, left], right
            return front[left, right], left
        if not self.coder.bit("SIDE", 1):
            return left, front[right, left]
        return right, left

    def conquer(self, centre, entry):
        self.states[centre] = TAKEN
        x = self.mesh.ring(centre, entry)
        states = list(map(self.state, x))
        flag, passed = 0, len(x) > 24
        if not passed:
            flag = self.coder.bit("FLAG", 12 * min(states.count(FREE), 3) + min(len(x), 11))
            passed = not flag and len(x) >= 13 and self.coder.bit("PASSED")
        self.end_step()
        self.tell("patch", centre, entry, 2 if passed else flag)
        if passed:
            for y in x:
                self.enqueue(y, centre)
            return
        for y in x:
            if self.state(y) in (FREE, HELD):
                self.states[y] = self.state(y) + 1
        for k in range(len(x) - 1, -1, -1):
            self.enqueue(self.mesh.front[x[k], x[(k + 1) % len(x)]], x[k])
        if flag:
            if self.vertices == self.header.vertices:
                raise End("corrupt")
            self.split(centre, x, states)
            self.stop_here()

    def enqueue(self, v, entry):
        if self.state(v) != FREE or v in self.was_queued:
            return
        if len(self.queue) == self.room:
            raise End("corrupt")
        self.queue.append((v, entry))
        self.was_queued.add(v)

    # -- 8. and 9. Splits

    def position(self, v):
        at = self.header.position.first
        return None if self.mesh.is_virtual(v) else self.values[v][at:at + 3]

    def split(self, centre, x, states):
        mesh = self.mesh
        ring = Ring(centre, x, [mesh.valence[y] for y in x], states, self.position if self.header.position else None)
        p, q = self.pairs.decode(self.coder, ring)
        self.tell("split", self.vertices, p, q)
        materials = self.materials.split(mesh, centre, (x[p], x[q])) if self.materials else []
        numbers = self.materials.numbers(materials) if self.materials else [len(mesh.real), len(mesh.real) + 1]
        values, of_faces = self.new_values(ring, Fan(mesh, ring, p, q), numbers)
        self.end_step()
        self.values.append(values)
        corners = self.rows.split(ring, p, q) if self.rows else None
        virtual = mesh.is_virtual(x[p]) + mesh.is_virtual(x[q])
        if len(mesh.real) + 2 - virtual > self.header.faces or len(mesh.virtual) + virtual > self.header.edges:
            raise End("corrupt")
        mesh.split(centre, self.vertices, x, p, q)
        self.states[self.vertices] = TAKEN
        self.vertices += 1
        if corners:
            self.rows.apply(ring, p, q, corners)
        new = mesh.real[virtual - 2:] if virtual < 2 else []
        for triangle, m in zip(new, materials):
            self.materials.enter(triangle, m)
        self.face_values.update((id(triangle), of_face) for triangle, of_face in zip(new, map(list, zip(*of_faces))))
        self.splits += 1

    def new_values(self, ring, fan, numbers):  # 9.1
        """Those of B, and those of the new triangles, which will have these numbers, for each channel of faces."""
        position, of_faces = self.header.position, []
        result = [None] * len(self.header.numbers())
        at = []
        if position:
            origin = self.position(ring.centre)
            place = Place(self, ring, fan, self.position)
            here = [self.value(position, number) for number in plus(origin, place.decode())]
            result[position.first:position.first + 3] = here
            self.tell_values(self.header.channels.index(position), self.vertices, result)
            at = [minus(self.position(v), here) for v in fan.v]
        neighbours = Neighbours(fan.v, [fan.w[k] if k in fan.all_known else None for k in range(fan.size)],
                                fan.at_boundary, at, fan.faces)
        for k, channel in enumerate(self.header.channels):
            if channel.per_face:
                of_faces.append(self.new_face_values(len(of_faces), k, ring, fan, numbers))
            elif not channel.of_row and channel is not position:
                self.attributes.decode(k, channel, neighbours, self.values, result)
                self.tell_values(k, self.vertices, result)
        return result, of_faces

    def new_face_values(self, k, number, ring, fan, numbers):  # 9.12
        """Of channel k among those of faces: the values of the new triangles at the real ones of two ends."""
        made, channel = [], self.header.channels[number]
        for x in ring.x[fan.p], ring.x[fan.q]:
            if self.mesh.is_virtual(x):
                continue
            beside = [self.face_values.get(id(self.mesh.left[edge])) for edge in ((ring.centre, x), (x, ring.centre))]
            made.append(self.copy(channel, made[:1] + [values[k] for values in beside if values]))
            self.tell("face", number, numbers[len(made) - 1], made[-1])
        return made


# -- 17. Regular levels ------------------------------------------------------------------------------------------------

def size_class(size):
    return min(half(size), 15)


def ratio_class(a, b, low, middle, high):
    x = log8(a + 1) - log8(b + 1)
    return 0 if x < low else 1 if x < middle else 2 if x < high else 3


def rounded(x):
    return x + 128 >> 8


class Tilt:
    """17.4"""

    def __init__(self, edge, normal, axes):
        nearest = 0
        if axes:
            k = axes - 1
        else:
            largest = 0
            for c in normal:
                largest |= abs(c)
            normal = shifted(normal, 1 + (largest >> 20).bit_length())
            k = 1 if abs(normal[1]) > abs(normal[0]) else 0
            if abs(normal[2]) > abs(normal[k]):
                k = 2
            nearest = normal[k]
        self.axis = [(k + 1) % 3, (k + 2) % 3, k]
        self.slope = [-quotient(normal[c] * 256, nearest) if nearest else 0 for c in self.axis[:2]]
        along = [edge[c] for c in self.axis[:2]]
        bits = (abs(along[0]) | abs(along[1])).bit_length()
        self.edge = [c >> bits - 12 if bits > 12 else c << 12 - bits for c in along]
        self.inverse = (1 << 31) // (sum(c * c for c in self.edge) >> 8) if bits else 0

    def tilted(self, vector):
        return [vector[c] for c in self.axis]

    def above(self, vector):
        x, y, z = self.tilted(vector)
        return [x, y, z - (self.slope[0] * x >> 8) - (self.slope[1] * y >> 8)]

    def weighted(self, features, weights):
        n = len(features)
        sums, part = [0, 0, 0], 0
        for k, feature in enumerate(map(self.above, features)):
            for c in range(3):
                sums[c] += weights[k + (n if c == 2 else 0)] * feature[c]
            part += weights[2 * n + k] * sum(e * x for e, x in zip(self.edge, feature))
        part = (part >> 12) * self.inverse >> 15
        return [sums[0] + (part * self.edge[0] >> 12), sums[1] + (part * self.edge[1] >> 12), sums[2]]


class RegularLevel:
    def __init__(self, decoder):
        self.decoder, self.coder, self.mesh = decoder, decoder.coder, decoder.mesh
        self.located = decoder.header.position is not None
        self.position, self.channels = decoder.header.position, decoder.header.channels
        self.expected_channels = [(k, c) for k, c in enumerate(self.channels) if self.is_expected(c)]
        self.view = None                # of positions, or a channel, the first of three components of it, and a flag
        self.weights_of, self.sizes = {}, {k: 0 for k, _ in self.expected_channels}
        self.expected = {}
        self.real = list(decoder.triangles())
        self.rows = decoder.rows
        self.corner_rows = [list(self.rows.of[id(t)]) for t in self.real] if self.rows else []
        self.rows_of = {}               # of new vertices: on the left and on the right of their edges, or one
        self.old, self.faces = decoder.vertices, [list(t) for t in self.real]
        self.of = {}
        for f, t in enumerate(self.faces):
            for k in range(3):
                self.of[t[k], t[(k + 1) % 3]] = 3 * f + k
        self.front, self.valence = dict(self.mesh.front), dict(self.mesh.valence)
        self.marked = set()             # halfedges
        self.on = {}                    # the new vertex of an edge, by both directions
        self.edges = []                 # halfedges of the new vertices
        self.pattern = {}               # of a face: the side of its hub, 3: none
        self.dissolved = {}             # of a face: 1 + side
        self.central = 2
        self.length = self.size = 0
        self.classes = {}               # of new vertices

    # halfedges of the coarse mesh
    def ends(self, h):
        t = self.faces[h // 3]
        return t[h % 3], t[(h + 1) % 3]

    def twin(self, h):
        """None: of a virtual triangle."""
        a, b = self.ends(h)
        return self.of.get((b, a))

    def following(self, h):
        return h // 3 * 3 + (h % 3 + 1) % 3

    def previous(self, h):
        return h // 3 * 3 + (h % 3 + 2) % 3

    def new_on(self, h):
        return self.on.get(self.ends(h))

    def is_expected(self, channel):  # 17.9
        return channel is not self.position and channel.merge == Channel.AVERAGE and channel.kind != 6

    @staticmethod
    def is_pair(channel):
        return (channel.kind, channel.components) in ((2, 2), (10, 2), (10, 3)) and 1 < channel.bits <= 24

    def numbers(self, v):
        if self.view and self.view[0].of_row:
            return self.rows.values[v]
        return self.numbers_of_vertex(v)

    def numbers_of_vertex(self, v):
        return self.expected[v] if v >= self.decoder.vertices else self.decoder.values[v]

    def at(self, v):
        numbers = self.numbers(v)
        if not self.view:
            return numbers[self.position.first:self.position.first + 3]
        channel, part, out = self.view
        first = channel.first + part
        vector = [channel.rough(x) for x in numbers[first:channel.first + min(part + 3, channel.components)]]
        vector += (3 - len(vector)) * [0]
        return self.folded(vector) if out else vector

    def folded(self, vector):
        half1 = (1 << self.view[0].bits - 1) - 1
        return [x + half1 for x in Attributes.fold([x - half1 for x in vector[:2]], half1)] + vector[2:]

    def look(self, channel, part, v):
        """At three components, and at pairs out of the fold, if what v has there is."""
        self.view = channel, part, False
        if self.is_pair(channel):
            half1 = (1 << channel.bits - 1) - 1
            self.view = channel, part, sum(abs(x - half1) for x in self.at(v)[:2]) > half1

    def unseen(self, vector):
        channel, _, out = self.view
        low, most = (-(1 << 23), (1 << 23) - 1) if channel.exact else (0, (1 << channel.bits) - 1)
        vector = [clamp(x, low, most) for x in vector]
        return self.folded(vector) if out else vector

    def offset(self, a, b):
        return minus(self.at(b), self.at(a))

    def distance(self, a, b):
        return norm(self.offset(a, b))

    def decode(self):
        self.read_marks()
        self.fixed = self.all_weights(3)
        if self.located or self.expected_channels:
            self.decoder.end_step()
            self.expect()
        self.read_dissolves()
        if self.located or self.expected_channels:
            self.take_room()
        self.fine = self.all_weights(8)
        self.decoder.end_step()
        self.sweep()

    def all_weights(self, n):
        of_position = self.weights(n) if self.located else None
        for k, channel in self.expected_channels:
            if n != 3 or not channel.of_row:
                self.weights_of[k] = [self.weight() for _ in range(n if n == 3 else self.num_fine(channel))]
        return of_position

    def has_normals(self, channel):
        return self.is_pair(channel) and channel.kind == 2 and self.located

    def num_fine(self, channel):
        return (4 if channel.of_row else 8) + self.has_normals(channel)

    def weights(self, n):
        self.axes = self.coder.raw(2)
        weights = [self.weight() for _ in range(2 * n)]
        return weights + ([self.weight() for _ in range(n)] if self.coder.raw(1) else n * [0])

    def weight(self):
        return (self.coder.raw(8) + 128) % 256 - 128

    # 17.2
    def read_marks(self):
        for f in range(len(self.faces)):
            for h in range(3 * f, 3 * f + 3):
                twin = self.twin(h)
                if twin is None or twin > h:
                    self.read_mark(h, twin)
            self.decoder.end_step()
        count = len(self.edges)
        if count < self.old // 16 + 1 or count <= len(self.faces) // 32:
            raise End("corrupt")

    def state(self, h, now):
        twin = self.twin(h)
        known = h < now or (twin is not None and twin < now)
        return int(h in self.marked) if known else 2

    def pair(self, h, now):
        if h is None:
            return 0
        states = sorted((self.state(self.following(h), now), self.state(self.previous(h), now)))
        return [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].index(tuple(states))

    def read_mark(self, h, twin):
        a, b = sorted((self.pair(h, h), self.pair(twin, h)))
        row = 0
        if self.located:
            length = 16 * self.distance(*self.ends(h))
            if self.edges:
                row = 1 + ratio_class(length, self.length, -10, -4, 4)
        if not self.coder.bit("MARK", 5 * (b * (b + 1) // 2 + a) + row):
            return
        v = self.old + len(self.edges)
        if v >= self.decoder.header.vertices:
            self.decoder.reject("corrupt")
        if self.located:
            self.length = self.length - (self.length >> 5) + (length >> 5) if self.edges else length
        self.edges.append(h)
        self.marked.add(h)
        if twin is not None:
            self.marked.add(twin)
        start, end = self.ends(h)
        self.on[start, end] = self.on[end, start] = v
        self.decoder.tell("mark", v, start, end)
        if self.rows:
            self.read_rows_of_mark(v, h, twin)

    # 17.10
    def row_at(self, h):
        """Of the start of a coarse halfedge."""
        return self.corner_rows[h // 3][h % 3]

    def ends_of_side(self, s, turned):
        """Rows of a and b on one side."""
        ends = [self.row_at(s), self.row_at(self.following(s))]
        return ends[::-1] if turned else ends

    def read_rows_of_mark(self, v, h, twin):
        two = 0
        if twin is not None:
            differ = sum(x != y for x, y in zip(self.ends_of_side(h, False), self.ends_of_side(twin, True)))
            two = (differ > 0) == self.coder.bit("TWO_ROWS", differ)
        self.rows_of[v] = [self.rows.add(v) for _ in range(1 + two)]
        if self.rows.full:
            self.decoder.reject("corrupt")

    def row_on(self, h):
        """Of the new vertex on the edge of a coarse halfedge, on the left of that."""
        v = self.new_on(h)
        return None if v is None else self.rows_of[v][0 if self.edges[v - self.old] == h else -1]

    def expect_rows(self, v, h):
        twin = self.twin(h)
        for i, row in enumerate(self.rows_of[v]):
            a, b = self.ends_of_side(twin, True) if i else self.ends_of_side(h, False)
            for _, channel in self.expected_channels:
                for c in range(channel.first, channel.first + channel.components) if channel.of_row else ():
                    both = channel.rough(self.rows.values[a][c]) + channel.rough(self.rows.values[b][c])
                    self.rows.values[row][c] = channel.value((both >> 1) * channel.unit())

    def sides_of_row(self, v, h, i):
        sides = [(h, False)] + ([] if self.twin(h) is None else [(self.twin(h), True)])
        return sides[i:i + 1] if len(self.rows_of[v]) == 2 else sides

    def row_features(self, v, row, sides):
        features = [[0, 0, 0] for _ in range(4)]

        def add(k, other, factor=1):
            if other is not None:
                features[k] = plus(features[k], [factor * x for x in self.offset(row, other)])

        for s, turned in sides:
            beside = [self.row_on(self.following(s)), self.row_on(self.previous(s))]
            for other in beside:
                add(0 if other is not None and other < self.rows_of[v][0] else 1, other)
            add(3 if None in beside else 2, self.row_at(self.previous(s)), 2)
            for other in self.ends_of_side(s, turned):
                add(3, other, 2)
        return features

    def row_values(self, v, h, k, channel):
        for i, row in enumerate(self.rows_of[v]):
            values = self.rows.values[row]
            sides = self.sides_of_row(v, h, i)
            numbers = range(channel.first, channel.first + channel.components)
            if channel.merge == Channel.COPY:
                fan = Neighbours(self.ends_of_side(*sides[0]), [None, None], True, [[0, 0, 0]] * 2, [])
                for c in numbers:
                    values[c] = self.decoder.attributes.copied_value(channel, fan, c, self.rows.values)
                self.decoder.tell("values", k, row, *values[self.rows.part(channel)])
                continue
            for part in range(0, channel.components, 3):
                self.look(channel, part, row)
                features = self.row_features(v, row, sides)
                if self.has_normals(channel):
                    features.append(self.normal(v, h, row, [int(turned) for _, turned in sides]))
                made = self.other_part(v, k, row, features)
                values[channel.first + part:channel.first + part + len(made)] = made
            self.decoder.tell("values", k, row, *values[self.rows.part(channel)])
        self.view = None

    # 17.3, 17.4
    def straight(self, a, b):
        """What goes straight on from a, seen from b: one vertex, two, or none."""
        n = self.valence[a]
        if n > 24:
            return []
        right, left = self.front[b, a], self.front[a, b]
        if self.mesh.is_virtual(right):
            return [self.front[right, a]]
        if self.mesh.is_virtual(left):
            return [self.front[a, left]]
        ring = [b]
        for _ in range(n):
            ring.append(self.front[ring[-1], a])
        if any(map(self.mesh.is_virtual, ring)):
            return []
        return ring[n // 2:(n + 1) // 2 + 1]

    def tilt(self, b, tips):
        largest, edge = 0, b
        for vector in [b] + [tip for tip in tips if tip]:
            for c in vector:
                largest |= abs(c)
        shift = (largest >> 13).bit_length()
        b = shifted(b, shift)
        normal = [0, 0, 0]
        if tips[0]:
            normal = cross(b, shifted(tips[0], shift))
        if tips[1]:
            normal = plus(normal, cross(shifted(tips[1], shift), b))
        return Tilt(edge, normal, self.axes)

    def fixed_features(self, h):
        a, b_vertex = self.ends(h)
        b = self.offset(a, b_vertex)
        tips, wings, ahead, found = [None, None], [], [0, 0, 0], 0
        for i, s in enumerate((h, self.twin(h))):
            start, end = (a, b_vertex) if i == 0 else (b_vertex, a)
            on = self.straight(start, end)
            if on:
                found += 1 + i
                ahead = plus(ahead, plus(self.offset(a, on[0]), self.offset(a, on[-1])))
            if s is None:
                continue
            tips[i] = self.offset(a, self.front[start, end])
            beyond = [self.twin(self.following(s)), self.twin(self.previous(s))]
            if None not in beyond:
                wings += [self.offset(a, self.ends(self.previous(g))[0]) for g in beyond]
        none = [0, 0, 0]
        both = tips[0] and tips[1]
        first = [2 * (x + y - z) for x, y, z in zip(*tips, b)] if both else none
        second = [x - 2 * y for x, y in zip(total(wings), b)] if len(wings) == 4 else first
        if found == 1:
            ahead = plus(ahead, [4 * x for x in b])
        third = [x - (4 * y if found == 2 else 2 * y) for x, y in zip(ahead, b)] if found else none
        return [first, second, third], None if self.view else self.tilt(b, tips), b

    def expect(self):
        for n, h in enumerate(self.edges):
            self.expected[self.old + n] = [0] * len(self.decoder.header.numbers())
            if self.located:
                self.expect_position(self.old + n, h)
            for k, channel in self.expected_channels:
                if not channel.of_row:
                    self.expect_other(self.old + n, h, k, channel)
            self.view = None
            if self.rows:
                self.expect_rows(self.old + n, h)

    def expect_other(self, v, h, k, channel):  # 17.9
        a, b = self.ends(h)
        for part in range(0, channel.components, 3):
            self.look(channel, part, a)
            features, _, _ = self.fixed_features(h)
            middle = [x + y >> 1 for x, y in zip(self.at(a), self.at(b))]
            vector = self.unseen(self.sums(middle, features, self.weights_of[k]))
            for c in range(part, min(part + 3, channel.components)):
                self.expected[v][channel.first + c] = channel.value(vector[c - part] * channel.unit())

    @staticmethod
    def sums(vector, features, weights):
        return [x + rounded(sum(w * f[c] for w, f in zip(weights, features))) for c, x in enumerate(vector)]

    def expect_position(self, v, h):
        most = (1 << self.position.bits) - 1
        features, tilt, b = self.fixed_features(h)
        sums = tilt.weighted(features, self.fixed)
        b = tilt.tilted(b)
        x, y = (rounded(sums[c] + 128 * b[c]) for c in range(2))
        z = rounded(sums[2] + tilt.slope[0] * (x - (b[0] >> 1)) + tilt.slope[1] * (y - (b[1] >> 1)) + 128 * b[2])
        place = list(self.at(self.ends(h)[0]))
        for c, offset in zip(tilt.axis, (x, y, z)):
            self.expected[v][self.position.first + c] = clamp(place[c] + offset, 0, most)

    # 17.5
    def marks_of(self, f):
        return [h in self.marked for h in range(3 * f, 3 * f + 3)]

    def expected_tip(self, h):
        v, w = self.new_on(self.following(h)), self.new_on(self.previous(h))
        return v if v is not None else w if w is not None else self.ends(self.previous(h))[0]

    def shape(self, a, b, x, y):
        return ratio_class(self.distance(x, y), self.distance(a, b), -4, 0, 4) if self.located else 4

    def read_dissolves(self):
        for f in range(len(self.faces)):
            if sum(self.marks_of(f)) > 1:
                self.pattern[f] = self.read_pattern(f)
                self.decoder.tell("pattern", self.number_of(f), self.pattern[f])
            for h in range(3 * f, 3 * f + 3):
                twin = self.twin(h)
                if twin is not None and twin > h:
                    self.read_dissolve(h, twin)
            self.decoder.end_step()

    def number_of(self, f):
        materials = self.decoder.materials
        return materials.number[id(self.real[f])] if materials else f

    def sides(self, f):
        """New vertices of a face, and the side of that which is inserted first."""
        on = [self.new_on(h) for h in range(3 * f, 3 * f + 3)]
        return on, on.index(min(v for v in on if v is not None))

    def opposite_corner(self, f, side):
        return self.faces[f][(side + 2) % 3]

    def read_pattern(self, f):
        """The side of the hub, or 3: none."""
        on, first = self.sides(f)
        if None in on:
            other = next(k for k in range(3) if on[k] is not None and k != first)
            shape = self.shape(on[first], self.opposite_corner(f, first), on[other], self.opposite_corner(f, other))
            return other if self.coder.bit("TWO", shape) else first
        self.central = self.coder.bit("CENTRAL", self.central)
        if self.central:
            return 3
        lengths = [self.distance(v, self.opposite_corner(f, k)) if self.located else 0 for k, v in enumerate(on)]
        order = sorted(range(3), key=lambda k: lengths[k])
        return order[0] if self.coder.bit("SHORTEST") else order[1] if self.coder.bit("SHORTER") else order[2]

    def hub_side(self, f):
        return self.pattern.get(f, self.sides(f)[1])

    def read_dissolve(self, h, g):
        f, e = h // 3, g // 3
        of_h, of_g = sum(self.marks_of(f)), sum(self.marks_of(e))
        if h in self.marked or of_h + of_g == 0 or f in self.dissolved or e in self.dissolved:
            return
        if of_h + of_g >= 3:
            around = of_h + of_g + 1
        elif of_h + of_g < 2:
            around = 0
        elif of_h != of_g:
            around = 1
        else:
            around = 2 + ((self.following(h) in self.marked) != (self.following(g) in self.marked))
        shape = self.shape(*self.ends(h), self.expected_tip(h), self.expected_tip(g)) if self.located else 4
        if not self.coder.bit("DISSOLVED", 5 * around + shape):
            return
        self.decoder.tell("dissolved", *self.ends(h))
        self.dissolved[e] = 1 + g % 3
        if of_h:
            self.dissolved[f] = 1 + self.marks_of(f).index(True)

    def take_room(self):
        taken = []                      # materials of the triangles to come
        materials = self.decoder.materials
        for h in self.edges:
            for s in filter(lambda s: s is not None, (h, self.twin(h))):
                m = materials.of[id(self.real[s // 3])] if materials else 0
                taken.append(m)
                if materials and materials.next[m] + taken.count(m) > materials.end[m]:
                    raise End("corrupt")
            if len(taken) > self.decoder.header.faces - len(self.faces):
                raise End("corrupt")

    # 17.6
    def is_dissolved(self, h):
        twin = self.twin(h)
        if twin is None:
            return False
        later = max(h, twin)
        return later not in self.marked and self.dissolved.get(later // 3) == 1 + later % 3

    def spokes(self, s):
        """What the start of s will be joined to, counter-clockwise from what is on s on; None at a boundary."""
        found, h = [], s
        while not found or h != s:
            if not self.is_dissolved(h):
                a, b = self.ends(h)
                found.append(self.on.get((a, b), b))
            opposite = self.following(h)
            marks = self.marks_of(h // 3)
            if opposite in self.marked and self.hub_side(h // 3) == opposite % 3:
                found.append(self.new_on(opposite))
            elif not any(marks) and self.is_dissolved(opposite):
                found.append(self.expected_tip(self.twin(opposite)))
            h = self.twin(self.previous(h))
            if h is None:
                return None
        return found

    def ahead(self, s):
        """What will be straight on from the start of s: one vertex, two, or none."""
        a, b = self.ends(s)
        if self.valence[a] > 24:
            return []
        found = self.spokes(s)
        if found is None:
            return [self.on.get((a, w), w) for w in self.straight(a, b)]
        return found[len(found) // 2:(len(found) + 1) // 2 + 1] if len(found) > 2 else []

    def around(self, h):
        """For each real side: new vertices next, previous; apex, is h's vertex the hub; straight on; beyond; which of
        these are joined."""
        v = self.new_on(h)
        for s in filter(lambda s: s is not None, (h, self.twin(h))):
            beyond, joined = [], []
            for side, turned in (self.following(s), self.following), (self.previous(s), self.previous):
                g = self.twin(side)
                joined.append(self.is_dissolved(side) and self.expected_tip(side) == v)
                beyond.append(None if g is None else self.expected_tip(g) if joined[-1] else self.new_on(turned(g)))
            beside = [self.new_on(self.following(s)), self.new_on(self.previous(s))]
            hub = self.hub_side(s // 3)
            for k, hub_between in enumerate((self.previous(s), self.following(s))):
                if hub == hub_between % 3 and beside[k] is not None:
                    beyond[k], beside[k] = beside[k], None
            ahead = self.ahead(s)
            if len(ahead) == 2 and ahead[0] != beyond[1]:
                ahead = ahead[1:]
            yield beside, (self.front[self.ends(s)], hub == s % 3), ahead, beyond, joined

    def fine_features(self, v, h):
        a, b = self.ends(h)
        features = [[0, 0, 0] for _ in range(8)]

        def add(k, w):
            if w is not None:
                features[k] = plus(features[k], self.offset(v, w))

        for beside, (tip, is_hub), ahead, beyond, joined in self.around(h):
            for w, u, is_joined in zip(beside, beyond, joined):
                add(0 if w is not None and w < v else 1, w)
                add(7 if is_joined else 3 if u is not None and u < v else 4, u)
            add(7 if is_hub else 2, tip)
            for w in ahead:
                for _ in range(3 - len(ahead)):
                    add(5, w)
        for w in a, b:
            add(6, w)
        for k in 2, 6, 7:
            features[k] = [2 * x for x in features[k]]
        return features

    def position_of(self, v, h):
        a, b = self.ends(h)
        sides = list(self.around(h))
        features = self.fine_features(v, h)
        total_size, weight = 0, 1
        for beside, _, _, beyond, _ in sides:
            for factor, w in (2, beside[0]), (2, beside[1]), (1, beyond[0]), (1, beyond[1]):
                if w is not None and self.old <= w < v:
                    total_size += factor * self.classes[w]
                    weight += factor
        expected = (64 * total_size + self.size) // (16 * weight)
        tips = [self.offset(a, tip) for _, (tip, _), _, _, _ in sides]
        tilt = self.tilt(self.offset(a, b), (tips + [None])[:2])
        sums = tilt.weighted(features, self.fine)
        x = self.coordinate("NEW_ALONG", expected, sums[0])
        of_x = abs(x - rounded(sums[0]))
        y = self.coordinate("NEW_ALONG", (3 * expected + 4 * size_class(3 * of_x)) // 4, sums[1])
        of_y = abs(y - rounded(sums[1]))
        sums[2] += tilt.slope[0] * x + tilt.slope[1] * y
        z = self.coordinate("NEW_ABOVE", (3 * expected + 4 * size_class((of_x + of_y) * 3 // 2)) // 4, sums[2])
        self.classes[v] = size_class(of_x + of_y + abs(z - rounded(sums[2])))
        self.size += 2 * self.classes[v] - (self.size >> 5)
        place = self.at(v)
        for c, offset in zip(tilt.axis, (x, y, z)):
            place[c] += offset
        return [self.decoder.value(self.position, x) for x in place]

    def coordinate(self, kind, size, predicted):
        row = (size + 2) // 4
        residual = self.decoder.residual(kind, 0 if row < 4 else (row - 3) // 2, 16 * min(row, 11), 26,
                                         (predicted + 128 >> 6) % 4)
        return rounded(predicted) + residual

    # 17.9
    def normal(self, v, h, number, sides):
        """The pair that the normals of the triangles around v say, less the one that is expected, times 4."""
        channel, _, out = self.view
        half1 = (1 << channel.bits - 1) - 1
        at = {}
        ends = self.ends(h)
        first = self.position.first
        sum_of_normals = [0, 0, 0]
        for i, ((beside, (tip, _), _, _, _), (start, end)) in enumerate(zip(self.around(h), (ends, ends[::-1]))):
            if i not in sides:
                continue
            ring = [w for w in beside if w is not None] or [tip]
            ring = [end] + ring + [start]
            for w in [v] + ring:
                at[w] = self.numbers_of_vertex(w)[first:first + 3]
            for w, u in zip(ring, ring[1:]):
                sum_of_normals = plus(sum_of_normals, Attributes.normal(minus(at[w], at[v]), minus(at[u], at[v])))
        pair = Attributes.pair_of(sum_of_normals, half1)
        if pair is None:
            return [0, 0, 0]
        vector = [x + half1 for x in pair] + [0]
        return [4 * (x - y) for x, y in zip(self.folded(vector) if out else vector, self.at(number))]

    def other_values(self, v, h, k, channel):
        made = []
        for part in range(0, channel.components, 3):
            self.look(channel, part, v)
            features = self.fine_features(v, h)
            if self.has_normals(channel):
                features.append(self.normal(v, h, v, (0, 1)))
            made += self.other_part(v, k, v, features)
        self.view = None
        return made

    def other_part(self, v, k, number, features):
        channel, part, _ = self.view
        size = self.sizes[k]
        if self.located and self.channels.index(self.position) < k:
            size = max(size + quotient(64 * self.classes[v] - self.size, 4), 0)
        made = []
        for predicted in self.unseen(self.sums(self.at(number), features, self.weights_of[k]))[:channel.components - part]:
            row = (size + 32) // 64
            residual = self.decoder.residual("PLAIN", 0 if row < 4 else row // 2, 16 * min(row, 11), channel.most_bits)
            made.append(self.decoder.value(channel, predicted * channel.unit() + residual))
            size = 64 * half(abs(residual))
            self.sizes[k] += quotient(size - self.sizes[k], 32)
            size = (size + self.sizes[k]) // 2
        return made

    def new_values(self, v, h):
        """Of all channels of vertices, in their order."""
        decoder, result = self.decoder, []
        fan = Neighbours(list(self.ends(h)), [None, None], True, [[0, 0, 0]] * 2, [])
        for k, channel in enumerate(self.channels):
            if channel is self.position:
                result += self.position_of(v, h)
                decoder.tell_values(k, v, result)
                self.expected[v][channel.first:channel.first + 3] = result[-3:]
            elif channel.of_row:
                self.row_values(v, h, k, channel)
            elif self.is_expected(channel):
                result += self.other_values(v, h, k, channel)
                decoder.tell_values(k, v, result)
            elif not channel.per_face:
                result += [None] * channel.components
                decoder.attributes.decode(k, channel, fan, decoder.values, result)
                decoder.tell_values(k, v, result)
        return result

    # 17.7
    def sweep(self):
        for f in range(len(self.faces)):
            while self.decoder.vertices < self.old + len(self.edges) and \
                    self.edges[self.decoder.vertices - self.old] // 3 == f:
                self.insert()
                self.decoder.stop_here()
            self.flip_face(f)

    def insert(self):
        decoder, mesh = self.decoder, self.mesh
        v = decoder.vertices
        h = self.edges[v - self.old]
        a, b = self.ends(h)
        if mesh.front[a, b] == mesh.front[b, a]:
            raise End("corrupt")
        p, q = mesh.front[a, b], mesh.front[b, a]
        virtual = mesh.is_virtual(p) + mesh.is_virtual(q)
        parents = [mesh.left[edge] for edge in ((a, b), (b, a)) if not mesh.is_virtual(mesh.front[edge])]
        materials = decoder.materials
        of = [materials.of[id(triangle)] for triangle in parents] if materials else []
        if len(mesh.real) + 2 - virtual > decoder.header.faces or \
                any(materials.next[m] + of.count(m) > materials.end[m] for m in of):
            raise End("corrupt")
        decoder.tell("insertion", v, a, b)
        values = self.new_values(v, h)
        decoder.end_step()
        if len(mesh.virtual) + virtual > decoder.header.edges:
            raise End("corrupt")
        corners = self.split_rows(v, a, b, p, q, parents) if self.rows else []
        mesh.split(a, v, [p, b, q], 0, 2)
        for triangle, parent, rows in zip(mesh.real[-len(parents):], parents, corners):
            self.rows.of[id(triangle)] = rows
        for triangle, parent in zip(mesh.real[-len(parents):], parents):
            if materials:
                materials.inherit(triangle, parent)
            if id(parent) in decoder.face_values:
                decoder.face_values[id(triangle)] = list(decoder.face_values[id(parent)])
        decoder.values.append(values)
        decoder.vertices += 1

    def split_rows(self, v, a, b, p, q, parents):
        """Rows of the new triangles; those that are there get v's."""
        rows, made = self.rows.of, []
        for i, (triangle, corners) in enumerate(zip(parents, ((p, a), (a, q)))):
            row = self.rows_of[v][i if len(self.rows_of[v]) == 2 else 0]
            made.append([rows[id(triangle)][triangle.index(corner)] for corner in corners] + [row])
            rows[id(triangle)][triangle.index(a)] = row
        self.decoder.num_rows = self.rows_of[v][-1] + 1
        return made

    def flip_rows(self, a, b):
        left, right = self.mesh.left[a, b], self.mesh.left[b, a]
        if not self.rows:
            return
        rows = [[self.rows.of[id(t)][(t.index(c) + n) % 3] for n in range(3)] for t, c in ((left, a), (right, b))]
        if rows[0][0] != rows[1][1] or rows[0][1] != rows[1][0]:
            raise End("corrupt")
        (of_a, of_b, of_x), of_y = rows[0], rows[1][2]
        for t, c, corners in (left, a, (of_y, of_x, of_a)), (right, b, (of_x, of_y, of_b)):
            for n, row in enumerate(corners):
                self.rows.of[id(t)][(t.index(c) + n) % 3] = row

    # 17.7, 17.8
    def is_flippable(self, a, b):
        mesh = self.mesh
        x, y = mesh.front[a, b], mesh.front[b, a]
        return not any(map(mesh.is_virtual, (a, b, x, y))) and x != y and (x, y) not in mesh.left and \
            mesh.valence[a] > 3 and mesh.valence[b] > 3

    def flip(self, a, b):
        self.decoder.end_step()
        if not self.is_flippable(a, b):
            raise End("corrupt")
        self.flip_rows(a, b)
        self.decoder.tell("flip", *sorted((a, b)))
        self.mesh.flip(a, b)

    def flip_face(self, f):
        marks, side = self.marks_of(f), self.dissolved.get(f, 0)
        if sum(marks) > 1:
            self.make_pattern(f)
        if side and not marks[side - 1]:
            self.decoder.end_step()
            self.dissolve(3 * f + side - 1)
        self.decoder.end_step()

    def make_pattern(self, f):
        """Out of the fan around the vertex that was inserted first."""
        front = self.mesh.front
        on, first = self.sides(f)
        hub, corner = on[first], self.opposite_corner(f, first)
        if self.pattern[f] == first:
            return
        right, left = front[corner, hub], front[hub, corner]
        self.flip(hub, corner)
        if None not in on and self.pattern[f] < 3:
            self.flip(hub, left if self.pattern[f] == (first + 1) % 3 else right)

    def second(self, h, beyond):
        """The edge inside of the face of h, which is dissolved, if that is flipped too."""
        marks = self.marks_of(h // 3)
        if sum(marks) != 1 or beyond < self.old:
            return None
        mark = h // 3 * 3 + marks.index(True)
        v, corner = self.new_on(mark), self.ends(self.previous(mark))[0]
        far = next(c for c in self.ends(mark) if c not in self.ends(h))
        shape = self.shape(v, corner, far, beyond)
        return (v, corner) if self.coder.bit("SECOND_FLIP", shape) else None

    def dissolve(self, h):
        b, a = self.ends(h)
        x, y = self.mesh.front[a, b], self.mesh.front[b, a]
        edges = [(a, b), self.second(self.twin(h), y), self.second(h, x)]
        for edge in filter(None, edges):
            self.flip(*edge)


def dump(decoder):
    """The text of tests/reference/dump.c."""
    triangles = decoder.triangles()
    lines = [decoder.kind, f"{decoder.vertices} vertices, {len(triangles)} triangles"]
    if decoder.kind == "done":
        lines.append(f"{decoder.levels} levels")
    if decoder.kind in ("done", "stopped", "truncated"):
        lines.append(f"error {decoder.error}")
    rows = decoder.rows if decoder.vertices else None
    lines += [" ".join(map(str, values)) for values in decoder.values[:decoder.vertices] if values]
    if rows:
        lines.append(f"{decoder.num_rows} rows")
        lines += [" ".join(map(str, [rows.vertex[r]] + rows.values[r])) for r in range(decoder.num_rows)]
    lines += [" ".join(map(str, triangle + decoder.face_values.get(id(triangle), []) +
                           (rows.of[id(triangle)] if rows else []))) for triangle in triangles]
    if triangles and decoder.materials:
        of = [decoder.materials.of[id(triangle)] for triangle in triangles]
        lines += [f"material {first} {of.count(m)}" for m, first in enumerate(decoder.materials.first)]
    if decoder.kind == "done":
        lines += [" ".join(map(str, ["aside"] + values)) for part in decoder.aside for values in part]
        lines += [f"metadata {decoder.metadata.hex()}"] if decoder.metadata else []
    return "\n".join(lines) + "\n"


def trace(events):
    """The lines of `cqm trace`."""
    return [" ".join(map(str, event)) for event in events]


def symbol_line(name, value, freq, total, width, code, used):
    """A symbol, the slots that it (of a bit: a 1) had of all, and the state after it."""
    return f"{name:18} {value:3}  {freq:9}/{total:<5}  {width:08x}   {code:08x}   {used}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--vertices", type=int, metavar="N", help="stop at N vertices")
    parser.add_argument("--trace", action="store_true", help="print all events instead of the mesh")
    parser.add_argument("--symbols", action="store_true", help="print all symbols instead of the mesh")
    parser.add_argument("file", type=pathlib.Path)
    options = parser.parse_args()
    events, symbols = [], []
    decoder = Decoder(options.file.read_bytes(), options.vertices, events, symbols)
    if options.trace or options.symbols:
        lines = trace(events) if options.trace else [symbol_line(*symbol) for symbol in symbols]
        print("".join(line + "\n" for line in lines), end="")
        print(decoder.kind, file=sys.stderr)
    else:
        print(dump(decoder), end="")
    return 0 if decoder.kind in ("done", "truncated", "stopped") else 1


if __name__ == "__main__":
    sys.exit(main())
