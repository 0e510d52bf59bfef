#!/usr/bin/env python3
"""A second decoder, slow and plain, written from SPEC.md alone.   SPDX-License-Identifier: MIT

    decoder.py [--vertices N] [--trace] FILE     prints the mesh as tests/reference/dump.c does

--vertices stops as soon as the mesh has N vertices. --trace prints every symbol instead of the mesh. Comments name the
sections of SPEC.md. The model's start values are read from its appendix.

The mesh is not the one of conquest.h: a dictionary tells for each directed edge the triangle on its left, and rings are
found from it. Virtual vertices have the numbers V, V + 1, ..."""

import argparse
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
        parts = re.split(r"^### A\.[1-5] .*$", text[text.index("## Appendix A."):], flags=re.M)[1:]
        lists = [[int(n) for n in re.findall(r"-?\d+", re.search(r"```\n(.*?)```", part, re.S).group(1))]
                 for part in parts]
        self.bits, self.plain, self.located, self.fast, self.shares = lists
        rows = re.findall(r"^\| ([A-Z_]+) \| (\d+) \| (\d+) \| ", parts[0], re.M)
        self.first = {name: int(first) for name, first, _ in rows}
        sizes = {name: int(size) for name, _, size in rows}
        # A.1: PLAIN begins like ALONG
        self.bits += self.bits[self.first["ALONG"]:self.first["ACROSS"]] + sizes["FACE"] * [240]


TABLES = Tables()

# 8.2
SIZE_B, SIZE_A, STATE, VALENCE, EDGE, RULE, EDGES, OUTER, BETWEEN = 0, 48, 96, 264, 348, 380, 416, 480, 544

OCTAVE = 1 << 22


def quotient(a, b):
    """a / b of 1.2: rounded toward zero."""
    return a // b if a >= 0 else -(-a // b)


def clamp(a, low, high):
    return min(max(a, low), high)


# -- 2. Header and channels --------------------------------------------------------------------------------------------

class Channel:
    """2.4. `first`: the place of its first number among those of a vertex."""

    COMPONENTS = [(3,), (1, 2, 3, 4), (2, 3), (2,), (3, 4), (1, 2, 3, 4), (1, 2, 3, 4), (1,), (1,)]
    MIDPOINT, KEEP, PER_FACE = 0, 1, 2

    def __init__(self, kind_and_merge, components, bits):
        self.kind, self.merge = kind_and_merge % 16, kind_and_merge // 16
        self.components, self.bits = components, bits
        self.per_face = self.merge == Channel.PER_FACE
        self.exact = bits == 32
        self.most_bits = 32 if self.exact else 26

    def is_valid(self):
        return self.kind < len(Channel.COMPONENTS) and self.components in Channel.COMPONENTS[self.kind] and \
            self.merge <= Channel.PER_FACE and not (self.per_face and self.components != 1) and \
            (1 <= self.bits <= 24 or (self.exact and self.merge != Channel.MIDPOINT))

    # 6.1
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

    def has_euler(self, euler):  # 5.7
        return euler == 2 * self.vertices - self.faces - self.edges

    def read_channels(self):  # 2.4
        count = self.uint(1)
        self.fast, count = count > 127, count % 128
        if count > 8:
            raise End("unsupported")
        self.channels = []
        for _ in range(count):
            channel = Channel(self.uint(1), self.uint(1), self.uint(1))
            self.uint(4)
            for _ in range(min(channel.components, 4)):
                self.uint(4)
            if not channel.is_valid():
                raise End("unsupported")
            self.add_channel(channel)

    def add_channel(self, channel):
        channel.first = sum(c.components for c in self.channels if not c.per_face)
        self.channels.append(channel)

    @property
    def position(self):
        """The position channel, or None."""
        return next((c for c in self.channels if c.kind == 0 and c.merge == 0), None)

    @property
    def has_positions(self):
        return self.position is not None and not self.fast

    def numbers(self):
        """The channel of each number of a vertex."""
        return [c for c in self.channels if not c.per_face for _ in range(c.components)]

    def face_channels(self):
        return [c for c in self.channels if c.per_face]


# -- 3. Range decoder --------------------------------------------------------------------------------------------------

class RangeDecoder:
    def __init__(self, payload, trace):
        self.payload, self.used = payload, 0
        self.range, self.code = 0xffffffff, 0
        self.rate = 5
        self.trace = trace
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

    def bit(self, table, index=0):  # 3.3
        k = TABLES.first[table] + index
        m = self.models[k]
        one = (self.range >> 16) * m
        if self.code < one:
            bit = 1
            self.take(0, one)
            self.models[k] = m + ((65504 - m) >> self.rate)
        else:
            bit = 0
            self.take(one, self.range - one)
            self.models[k] = m - ((m - 32) >> self.rate)
        self.log(f"bit {table}[{index}]", bit, m, 65536)
        return bit

    def symbol(self, freqs, name="symbol"):  # 3.4
        total = sum(freqs)
        slot = self.range // total
        s = min(self.code // slot, total - 1)
        start = k = 0
        while s >= start + freqs[k]:
            start += freqs[k]
            k += 1
        self.take_slots(slot, start, freqs[k], total)
        self.log(name, k, freqs[k], total)
        return k

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
        if self.trace is not None:
            self.trace.append((name, value, freq, total, self.range, self.code, self.used))


# -- 5. The base mesh --------------------------------------------------------------------------------------------------

class Base:
    """Halfedge 3 t + k of real triangle t has that number, one of virtual triangle t the number 3 (F + t) + k."""

    def __init__(self, decoder):
        self.decoder, self.coder, self.header = decoder, decoder.coder, decoder.header
        self.real, self.virtual = [], []          # triangles, lists of corners
        self.vertices, self.loops = 0, 0          # vertices so far
        self.corners = {}                         # number of triangle corners at a vertex
        self.last = {}                            # the triangle added last at a vertex
        self.after = {}
        self.first_gates = []
        self.scan, self.virtual_scan = 0, 3 * self.header.faces
        while True:
            self.start_component()
            decoder.end_step()
            while self.find_gate():
                self.grow()
                decoder.end_step()
            more = self.coder.bit("COMPONENT")
            if not more:
                self.decoder.end_step()
                self.check()
                return

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
        if len(triangles) == limit:
            self.decoder.reject("corrupt")
        triangle = list(corners)
        triangles.append(triangle)
        for v in corners:
            self.corners[v] = self.corners.get(v, 0) + 1
            self.last[v] = triangle
        return 3 * (len(triangles) - 1 + (self.header.faces if virtual else 0))

    def corner(self, h, step):
        """The vertex at the start of halfedge h (step 0) or at its end (step 1)."""
        t, k = divmod(h, 3)
        faces = self.header.faces
        triangle = self.real[t] if t < faces else self.virtual[t - faces]
        return triangle[(k + step) % 3]

    def is_open(self, h):
        return self.after[self.after[h]] != h

    def start_component(self):  # 5.2
        left, right = self.new_vertex(False), self.new_vertex(False)
        h = self.add_triangle(left, right, self.new_vertex(True))
        self.after.update({h: h + 1, h + 1: h + 2, h + 2: h})
        self.gate, self.before, self.before2 = h, h + 2, h + 1
        self.first_gates.append((left, right))

    def find_gate(self):  # 5.6
        if self.is_open(self.gate):
            return True
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
        reals = 3 * len(self.real)
        count = reals + 3 * len(self.virtual)
        n = self.coder.raw((count - 1).bit_length())
        if n >= count:
            self.decoder.reject("corrupt")
        border = n if n < reals else n - reals + 3 * self.header.faces
        if not self.is_open(border):
            self.decoder.reject("corrupt")
        return border

    def check(self):  # 5.7
        header = self.header
        euler = 2 * self.vertices - len(self.real) - len(self.virtual)
        if self.loops != header.loops or not header.has_euler(euler):
            raise End("corrupt")
        mesh = Mesh(header.vertices, self.real, self.virtual)
        if mesh.edges_twice:
            raise End("corrupt")
        for v, corners in self.corners.items():
            ring = mesh.ring(v, self.next_corner(v))
            neighbours = sum(map(self.is_virtual, ring))
            if len(ring) != corners or len(ring) < (3 if self.is_virtual(v) else 2) or \
               neighbours > (0 if self.is_virtual(v) else 1):
                raise End("corrupt")
            mesh.valence[v] = len(ring)
        self.mesh = mesh

    def next_corner(self, v):  # w0 of 6.2
        triangle = self.last[v]
        return triangle[(triangle.index(v) + 1) % 3]


# -- 4. The mesh -------------------------------------------------------------------------------------------------------

class Mesh:
    def __init__(self, first_virtual, real, virtual):
        self.first_virtual = first_virtual
        self.real, self.virtual = real, virtual
        self.left = {}     # (u, w) -> the triangle on the left of u -> w
        self.front = {}    # (u, w) -> its third vertex
        self.valence = {}
        self.edges_twice = False
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

    def split(self, a, b, ring, p, q):  # 8.9
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

    def add(self, *corners):
        triangle = list(corners)
        (self.virtual if any(map(self.is_virtual, corners)) else self.real).append(triangle)
        self.enter(triangle)


# -- 7. and 8. ---------------------------------------------------------------------------------------------------------

class Patch:
    def __init__(self, centre, ring, case):
        self.centre, self.ring, self.case = centre, ring, case
        self.split = 0


def valence_class(valence):  # 8.3
    return 0 if valence < 3 else valence - 3 if valence < 16 else 13


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1]


def cross(a, b):
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]


def bits_of(*numbers):
    """Of the largest absolute value."""
    return max(map(abs, numbers)).bit_length()


def fit(*numbers):  # 6.4
    """Scaled by the power of two that gives the largest one 14 bits."""
    g = 14 - bits_of(*numbers)
    return [n << g if g >= 0 else n >> -g for n in numbers]


def half(x):  # 6.1
    return bits_of(x * x) if x < 1 << 15 else 2 * bits_of(x)


class Turn:
    """6.4: takes (x, y) to about (length, 0)."""

    def __init__(self, x, y):
        u, v = abs(x), abs(y)
        g = max(u, v) + 3 * min(u, v) // 8
        self.tangent = self.sine = self.length = 0
        if g > 0:
            self.length = ((u * u + v * v) // g + g) // 2
            self.tangent = quotient(-512 * y, self.length + u)
            self.sine = quotient(-512 * y, self.length)
        if x < 0:
            self.tangent, self.sine, self.length = -self.tangent, -self.sine, -self.length

    def forth(self, v, i, j):
        """Components i and j of v."""
        v[i] -= v[j] * self.tangent >> 9
        v[j] += v[i] * self.sine >> 9
        v[i] -= v[j] * self.tangent >> 9

    def back(self, v, i, j):
        v[i] += v[j] * self.tangent >> 9
        v[j] -= v[i] * self.sine >> 9
        v[i] += v[j] * self.tangent >> 9


class Spokes:
    """8.5 for one ring, as much of it as fast streams have: edge."""

    def __init__(self, centre, positions):
        """positions: None for a virtual vertex."""
        self.count = len(positions)
        self.s = self.scale([[x - c for x, c in zip(position or centre, centre)] for position in positions])
        self.lengths = [(11 * max(map(abs, v)) + 5 * sum(map(abs, v)) >> 4) + 1 for v in self.s]
        real = sorted(length for length, position in zip(self.lengths, positions) if position)
        shortest = real[0] + real[1]
        g = max(bits_of(shortest) - 14, 0)
        unit = (1 << 26) // (shortest >> g)
        self.edge = [15 if position is None else 14 if length > 2 * shortest else
                     clamp(((length >> g) * unit >> 23) - 3, 0, 14)
                     for length, position in zip(self.lengths, positions)]

    def scale(self, offsets):
        return offsets


class Geometry(Spokes):
    """All of 8.5."""

    def __init__(self, centre, positions):
        super().__init__(centre, positions)
        self.mean = sum(self.lengths) // self.count + 1
        normal = [0, 0, 0]
        for k in range(self.count):
            normal = [n + x for n, x in zip(normal, cross(self.s[k - 1], self.s[k]))]
        normal = fit(*normal)
        self.first = Turn(normal[0], normal[1])
        self.second = Turn(normal[2], self.first.length)
        turned = [self.turn_forth(v) for v in self.s]
        self.flat = [v[:2] for v in turned]
        self.dir = [[x * (65536 // length) >> 10 for x in v] for v, length in zip(self.flat, self.lengths)]
        self.height = sum(abs(v[2]) for v in turned)

    def scale(self, offsets):
        self.h = 8 - max(bits_of(*o) for o in offsets)
        return [[x << self.h if self.h >= 0 else x >> -self.h for x in o] for o in offsets]

    def turn_forth(self, vector):
        v = list(vector)
        self.first.forth(v, 0, 1)
        self.second.forth(v, 2, 0)
        return v

    def features(self, p, q):
        """The numbers of the weights in EDGES, OUTER, BETWEEN."""
        count, apart = self.count, q - p
        n_b, n_a = apart + 2, count - apart + 2
        r_b = [sum(self.flat[k][c] for k in range(p, q + 1)) for c in range(2)]
        r_a = [sum(self.flat[k][c] for k in range(count) if k <= p or k >= q) for c in range(2)]
        scale = (1 << 22) // ((2 * n_a * n_b + n_a + n_b) * self.mean)
        move = [(n_a * b - n_b * a) * scale >> 15 for a, b in zip(r_a, r_b)]

        def advance(k):
            return clamp((dot(self.dir[k % count], move) >> 9) + 4, 0, 7)

        rest = count - apart
        steps = min(apart, 4) if apart < rest else 4 + min(rest, 3)
        angle = clamp((dot(self.dir[p], self.dir[q]) >> 10) + 4, 0, 7)
        return (EDGES + 8 * (self.edge[p] // 2) + self.edge[q] // 2, OUTER + 8 * advance(p - 1) + advance(q + 1),
                BETWEEN + 8 * steps + angle)

    # 6.4
    def expect(self, x):
        return max(half(x) - 2 * (3 + self.h), 0)

    def axes(self, predicted):
        """Three turns, and the half bits to expect along the surface and along the normal."""
        third = Turn(*fit(*self.turn_forth(predicted)[:2]))
        return (self.first, self.second, third, self.expect(3 * self.mean),
                self.expect(8 * self.height // self.count))


class Model:
    """Weights, and one ring's features."""

    def __init__(self, header):
        self.fast, self.located = header.fast, header.has_positions
        priors = TABLES.fast if self.fast else TABLES.located if self.located else TABLES.plain
        self.weight = [n << 18 for n in priors]

    def score(self, features):
        return sum(self.weight[w] for w in features)

    def code_pair(self, coder, valences, states, case, level_class, geometry, before):
        """Decodes p, q of a ring, and learns. geometry: None without a position channel; before: number of vertices."""
        count = len(valences)
        val = [min(v, 31) for v in valences]
        ends = self.end_features(val, states, level_class, geometry)
        sizes = [[SIZE_B + 16 * level_class + min(k, 15), SIZE_A + 16 * level_class + min(count - k, 15)]
                 for k in range(count)]

        def simple(p, q):
            return ends[0][p] + ends[1][q] + sizes[q - p]

        if self.fast:
            pair = self.code_steps(coder, count, case, simple, before % 8 == 0)
        else:
            pair = self.code_candidate(coder, val, states, case, simple, geometry)
        if before % 1024 == 0:
            self.limit()  # 8.7
        return pair

    def code_candidate(self, coder, val, states, case, simple, geometry):  # 8.6
        count = len(val)
        low = self.alternatives(val, states, range(count))
        high = self.alternatives(val, states, range(count - 1, -1, -1))

        def rule(p, q):  # 8.4
            vb = q - p + 2
            return RULE + 6 * clamp(low[p] - vb + 2, 0, 5) + clamp(high[q] - vb + 2, 0, 5)

        # 8.1
        pairs = [(p, q) for q in range(1, count) for p in range(q)]
        allowed = [(case != 1 or q == count - 1) and (case != 2 or p == 0) for p, q in pairs]
        features = [simple(p, q) + [rule(p, q)] for p, q in pairs]
        scores = list(map(self.score, features))
        if self.located:
            least = max(scores) - 5 * OCTAVE
            for k in [k for k, score in enumerate(scores) if score >= least][:63]:
                located = geometry.features(*pairs[k])
                features[k] += located
                scores[k] += self.score(located)
        freqs = [freq * ok for freq, ok in zip(self.frequencies(scores), allowed)]
        chosen = coder.symbol(freqs, "pair")
        self.learn(self.gradients(features, freqs, chosen))
        return pairs[chosen]

    @staticmethod
    def frequencies(scores):
        highest = max(scores)
        return [TABLES.shares[min(highest - score >> 18, 223)] for score in scores]

    # 8.8
    def code_steps(self, coder, count, case, simple, learns):
        """`simple` gives the features of a pair."""
        best = [max(((p, p + steps) for p in range(count - steps)), key=lambda pair: self.score(simple(*pair)))
                for steps in range(1, count)]
        k, gradients = self.code_listed(coder, "steps", [simple(*pair) for pair in best])
        steps = k + 1
        p = 0 if case == 2 else count - 1 - steps
        if case == 0:
            p, more = self.code_listed(coder, "place", [simple(p, p + steps) for p in range(count - steps)])
            gradients += more
        if learns:
            self.learn(gradients)
        return p, p + steps

    def code_listed(self, coder, name, features):
        """One of some candidates, and what there is to learn."""
        freqs = self.frequencies(list(map(self.score, features)))
        chosen = coder.symbol(freqs, name)
        return chosen, self.gradients(features, freqs, chosen)

    @staticmethod
    def end_features(val, states, level_class, geometry):  # 8.3
        """Of all ring vertices as x[p], and as x[q]."""
        vc = [valence_class(v) for v in val]
        ends = [], []
        for k in range(len(val)):
            numbers = [STATE + 2 * (6 * vc[k] + states[k]), VALENCE + 2 * (14 * level_class + vc[k])]
            if geometry:
                numbers.append(EDGE + 2 * geometry.edge[k])
            for end in 0, 1:
                ends[end].append([n + end for n in numbers])
        return ends

    @staticmethod
    def alternatives(val, states, order):  # 8.4
        best, result = 99, [0] * len(val)
        for k in order:
            result[k] = best
            if states[k] <= 1:
                result[k] = min(best, val[k] + 1)
                best = min(best, val[k])
        return result

    # 8.7
    @staticmethod
    def gradients(features, freqs, chosen):
        """Pairs: weights of a candidate, and y."""
        unit = (110000 << 14) // sum(freqs)
        y = [-(freq * unit >> 14) for freq in freqs]
        y[chosen] -= sum(y)
        return list(zip(features, y))

    def learn(self, gradients):
        for numbers, y in gradients:
            for w in numbers:
                self.weight[w] += y

    def limit(self):
        self.weight = [clamp(weight, -8 * OCTAVE, 8 * OCTAVE) for weight in self.weight]


class Decoder:
    def __init__(self, data, stop=None, trace=None, limit=None):
        """Decodes at once. `stop`: at so many vertices. `limit`: refuse more vertices, triangles or edges, "limit"."""
        self.kind = None
        self.vertices = 0      # of the result
        self.base_vertices = 0
        self.values = []       # per vertex, all channels of vertices in a row
        self.face_values = {}  # per real triangle, by id: of all channels of faces
        self.mesh = None
        self.levels = 0
        self.stop = stop
        try:
            self.header = Header(data)
            if limit is not None and max(self.header.vertices, self.header.faces, self.header.edges) > limit:
                raise End("limit")
            self.coder = RangeDecoder(self.header.payload, trace)
            self.decode()
        except End as end:
            self.kind = end.args[0]

    def triangles(self):
        return self.mesh.real if self.mesh and self.vertices else []

    # 9.2
    def is_starved(self):
        have = len(self.header.payload)
        return have < self.header.size and self.coder.used > have

    def end_step(self):
        if self.is_starved():
            raise End("truncated")

    def reject(self, kind):
        """The step that is being read is at fault, if all of it is there."""
        self.end_step()
        raise End(kind)

    def decode(self):
        self.start_models()
        if self.header.vertices:
            base = Base(self)
            self.base_values(base)
            self.base_face_values(base.mesh)
            self.first_gates = base.first_gates
            self.mesh, self.vertices = base.mesh, base.vertices
        self.base_vertices = self.vertices
        self.stop_here()
        while self.vertices < self.header.vertices:
            self.level()
        # 9.1
        if self.coder.used < self.header.size:
            raise End("corrupt")
        if zlib.crc32(self.header.payload) != self.header.payload_check:
            raise End("checksum")
        raise End("done")

    def stop_here(self):
        if self.stop is not None and self.vertices >= self.stop:
            raise End("stopped")

    def start_models(self):
        self.model = Model(self.header)
        self.mean = [128 * i for i in range(69)]  # 6.7

    # 6.
    def residual(self, kind, expected, c, most=26):  # 6.1
        coder = self.coder
        n = self.number_of_bits(kind, expected, 28 + c)
        if n == 0:
            return 0
        if n > most:
            return 1 << 26
        magnitude = 1
        if n > 1:
            magnitude = 2 + coder.bit(kind, 1 + min(n, 26)) << n - 2
            magnitude |= coder.raw(n - 2)
        return self.signed(-magnitude if coder.bit(kind, 0) else magnitude)

    @staticmethod
    def signed(residual):
        return (residual + (1 << 31)) % (1 << 32) - (1 << 31)

    def number_of_bits(self, kind, expected, index):
        if expected == 0 or self.coder.bit(kind, index):
            return expected + self.coder.count(kind, index + 1)
        return max(expected - 1 - self.coder.count(kind, index + 8), 0)

    def difference(self, kind, e, most=26):
        return self.residual(kind, e // 2, 16 * (e if e < 14 else 14 + e % 2), most)

    # 6.7
    def fast_residual(self, channel, spread):
        i = half(spread // 16) + (16 if channel.exact else 0)
        low = min(self.mean[i] // 256 + 1, 32)
        more = self.more_bits(i, low)
        if low + more > 32:
            return 1 << 26
        if more:
            x = (1 << low + more - 1) + self.coder.raw(low + more - 1)
        else:
            x = self.coder.raw(low)
        self.mean[i] += 4 * bits_of(x) - self.mean[i] // 64
        return -(x + 1) // 2 if x % 2 else x // 2

    def more_bits(self, i, low):  # `low` is for random_stream.py
        return self.coder.count("FAST", 8 * (self.mean[i] // 64 % 4))

    def value(self, channel, number):
        value = channel.value(number)
        if value is None:
            self.reject("corrupt")
        return value

    def base_values(self, base):  # 6.2
        numbers = self.header.numbers()
        sizes = [0] * len(numbers)
        for v in range(base.vertices):
            known = [w for w in base.mesh.ring(v, base.next_corner(v)) if w < v][:64]
            values = []
            self.values.append(values)
            for k, channel in enumerate(numbers):
                if known:
                    total = sum(channel.rough(self.values[w][k]) for w in known)
                    prediction = quotient(total, len(known)) * channel.unit()
                elif v:
                    prediction = channel.number(self.values[v - 1][k])
                else:
                    prediction = 0 if channel.exact else 1 << channel.bits - 1
                residual = self.residual("BASE", sizes[k].bit_length(), 0, channel.most_bits)
                sizes[k] = (3 * sizes[k] + min(abs(residual), 1 << 28)) // 4
                values.append(self.value(channel, prediction + residual))
            self.end_step()

    def base_face_values(self, mesh):  # 6.5
        channels = self.header.face_channels()
        before = None
        for triangle in mesh.real if channels else ():
            before = [self.face_value(channel, [before[k]] if before else [0]) for k, channel in enumerate(channels)]
            self.face_values[id(triangle)] = before
            self.end_step()

    def face_value(self, channel, near):  # 6.5
        refused = []
        for value in near:
            if value in refused:
                continue
            if self.coder.bit("FACE", 4 * len(refused) + near.count(value)):
                return value
            refused.append(value)
        return self.coder.raw(channel.bits)

    def new_face_values(self, k, channel, centre, ends):  # 6.5
        """Of channel k among those of faces: the values of the new triangles at the real ones of two ends."""
        made = []
        for x in ends:
            if self.mesh.is_virtual(x):
                continue
            beside = [self.face_values.get(id(self.mesh.left[edge])) for edge in ((centre, x), (x, centre))]
            made.append(self.face_value(channel, made[:1] + [values[k] for values in beside if values]))
        return made

    def differences(self, centre, ring, p, q, geometry):  # 6.3
        """The new values of A and B, and those of the new triangles for each channel of faces."""
        result, of_faces = [], []
        for channel in self.header.channels:
            if channel.per_face:
                of_faces.append(self.new_face_values(len(of_faces), channel, centre, (ring[p], ring[q])))
                continue
            numbers = range(channel.first, channel.first + channel.components)
            predictions, spreads = zip(*(self.predict(centre, ring, p, q, c, channel) for c in numbers))
            if self.header.fast:
                residuals = [self.fast_residual(channel, spread) for spread in spreads]
            elif channel is self.header.position and channel.bits <= 18:
                residuals = self.turned(geometry, predictions)
            else:
                expected = [half(spread // len(ring)) + (16 if channel.exact else 0) for spread in spreads]
                residuals = [self.difference("PLAIN", e, channel.most_bits) for e in expected]
            for c, prediction, residual in zip(numbers, predictions, residuals):
                d = prediction + residual
                a = self.values[centre][c]
                if channel.merge == Channel.MIDPOINT:
                    a = self.value(channel, a - (d >> 1))
                result.append((a, self.value(channel, channel.number(a) + d)))
        return result, of_faces

    def predict(self, centre, ring, p, q, c, channel):
        """Number c of a vertex: its predicted difference, and its spread."""
        a = channel.rough(self.values[centre][c])
        r = {k: channel.rough(self.values[x][c]) - a for k, x in enumerate(ring) if not self.mesh.is_virtual(x)}
        spread = sum(map(abs, r.values()))
        in_b = [r[k] for k in r if p <= k <= q]
        in_a = [r[k] for k in r if k <= p or k >= q]
        n_b, n_a = len(in_b) + 1, len(in_a) + 1
        if channel.merge == Channel.KEEP:
            return quotient(sum(in_b), n_b) * channel.unit() if channel.exact else 0, spread
        w = max(channel.bits - 18, 0)
        difference = n_a * (sum(in_b) >> w) - n_b * (sum(in_a) >> w)
        return quotient(2 * difference, 2 * n_a * n_b + n_a + n_b) << w, spread

    def turned(self, geometry, predictions):  # 6.4
        first, second, third, along, normal = geometry.axes(predictions)
        r0 = self.difference("ALONG", along)
        r1 = self.difference("ACROSS", (3 * along + half(abs(r0))) // 4)
        r2 = self.difference("NORMAL", (3 * normal + half(abs(r0) + abs(r1))) // 4)
        v = [r0, r1, r2]
        if max(map(abs, v)) > 1 << 20:
            self.reject("corrupt")
        third.back(v, 0, 1)
        second.back(v, 2, 0)
        first.back(v, 0, 1)
        return v

    # 7.
    def level(self):
        before = self.vertices
        self.levels += 1
        if self.levels > 255:
            raise End("corrupt")
        if self.coder.bit("OTHER_LEVEL"):
            self.reject("unsupported")
        self.end_step()
        self.coder.rate = 5 if before < 1024 else 6 if before < 8192 else 7  # 3.3
        patches = self.conquest()
        splits = sum(patch.split for patch in patches)
        if splits < before // 16 + 1 or before + splits > self.header.vertices:
            raise End("corrupt")
        self.split_all(patches, before + splits)

    def conquest(self):  # 7.2
        self.conquered = set()
        patches = []
        for left, right in self.first_gates:
            if self.mesh.valence[left] == 2:
                continue  # a component of two triangles
            head = len(patches)
            patches.append(self.first_patch(left, right))
            while head < len(patches):
                ring = patches[head].ring
                for k in range(len(ring) - 1, -1, -1):
                    gate = ring[k], ring[(k + 1) % len(ring)]
                    front = self.mesh.front[gate]
                    if self.is_available(front):
                        patches.append(self.conquer(front, gate[0], 0))
                head += 1
        return patches

    def is_available(self, v):
        return not self.mesh.is_virtual(v) and v not in self.conquered

    def first_patch(self, left, right):  # 7.3
        front = self.mesh.front[left, right]
        if self.mesh.is_virtual(front):
            left, right = right, left
            front = self.mesh.front[left, right]
        if not self.coder.bit("SIDE", 0):
            return self.conquer(front, left, 0)
        if not self.coder.bit("SIDE", 1):
            return self.conquer(left, self.mesh.front[right, left], 1)
        return self.conquer(right, left, 2)

    def conquer(self, centre, first, case):  # 7.4
        patch = Patch(centre, self.mesh.ring(centre, first), case)
        if len(patch.ring) <= 24:
            available = sum(map(self.is_available, patch.ring))
            patch.split = self.coder.bit("FLAG", 12 * min(available, 3) + min(len(patch.ring), 11))
        self.conquered.add(centre)
        self.conquered.update(patch.ring)
        self.end_step()
        return patch

    def split_all(self, patches, level_end):  # 7.5
        holders = {}
        for patch in patches:
            for x in patch.ring:
                holders[x] = holders.get(x, 0) + 1
        many = {x for x, n in holders.items() if n >= 15}
        touched = set()
        limit = self.header.vertices
        level_class = 0 if level_end == limit else 1 if level_end >= limit - limit // 5 else 2
        for patch in reversed(patches):
            for x in patch.ring:
                if x not in many:
                    holders[x] -= 1
            states = [self.state(x, holders, touched) for x in patch.ring]
            touched.update(patch.ring)
            if patch.split:
                self.split(patch, states, level_class)
                self.stop_here()

    def state(self, x, holders, touched):  # 8.3
        if self.mesh.is_virtual(x):
            return 5
        n = holders.get(x, 0)
        return 4 if n > 1 else 2 * n + (x in touched)

    # 8.
    def split(self, patch, states, level_class):
        ring, centre, mesh = patch.ring, patch.centre, self.mesh
        geometry = None
        if self.header.position:
            at = self.header.position.first
            positions = [None if mesh.is_virtual(x) else self.values[x][at:at + 3] for x in ring]
            geometry = (Spokes if self.header.fast else Geometry)(self.values[centre][at:at + 3], positions)
        valences = [mesh.valence[x] for x in ring]
        p, q = self.model.code_pair(self.coder, valences, states, patch.case, level_class, geometry, self.vertices)
        values, of_faces = self.differences(centre, ring, p, q, geometry)
        self.end_step()
        virtual = mesh.is_virtual(ring[p]) + mesh.is_virtual(ring[q])
        if len(mesh.real) + 2 - virtual > self.header.faces or len(mesh.virtual) + virtual > self.header.edges:
            raise End("corrupt")
        mesh.split(centre, self.vertices, ring, p, q)
        self.vertices += 1
        self.values[centre] = [a for a, _ in values]
        self.values.append([b for _, b in values])
        new = mesh.real[virtual - 2:] if virtual < 2 else []
        self.face_values.update((id(triangle), of_face) for triangle, of_face in zip(new, map(list, zip(*of_faces))))


def dump(decoder):
    """The text of tests/reference/dump.c."""
    triangles = decoder.triangles()
    lines = [decoder.kind, f"{decoder.vertices} vertices, {len(triangles)} triangles"]
    if decoder.kind == "done":
        lines.append(f"{decoder.levels} levels")
    lines += [" ".join(map(str, values)) for values in decoder.values[:decoder.vertices] if values]
    lines += [" ".join(map(str, triangle + decoder.face_values.get(id(triangle), []))) for triangle in triangles]
    return "\n".join(lines) + "\n"


def trace_line(name, value, freq, total, width, code, used):
    """A symbol, the slots that it (of a bit: a 1) had of all, and the state after it."""
    return f"{name:18} {value:3}  {freq:9}/{total:<5}  {width:08x}   {code:08x}   {used}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--vertices", type=int, metavar="N", help="stop at N vertices")
    parser.add_argument("--trace", action="store_true", help="print all symbols instead of the mesh")
    parser.add_argument("file", type=pathlib.Path)
    options = parser.parse_args()
    trace = [] if options.trace else None
    decoder = Decoder(options.file.read_bytes(), options.vertices, trace)
    if trace is not None:
        for symbol in trace:
            print(trace_line(*symbol))
        return 0
    print(dump(decoder), end="")
    return 0 if decoder.kind in ("done", "truncated", "stopped") else 1


if __name__ == "__main__":
    sys.exit(main())
