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
        appendix = text[text.index("## Appendix A."):]
        lists = [[int(n) for n in re.findall(r"-?\d+", block)] for block in re.findall(r"```\n(.*?)```", appendix, re.S)]
        self.bits, self.bare, self.located, linear, self.yes, self.gain, self.logistic, self.reciprocal, self.inverse, \
            self.inverse_root = lists
        rows = re.findall(r"^\| ([A-Z_2]+) \| (\d+) \| (\d+) \| ", appendix, re.M)
        self.first = {name: int(first) for name, first, _ in rows}
        sizes = {name: int(size) for name, _, size in rows}
        # A.1: PLAIN begins like FIRST
        self.bits += self.bits[self.first["FIRST"]:self.first["SECOND"]] + sizes["COPY"] * [240]
        # A.4: along and above, by class
        rows = [linear[k:k + 4] for k in range(0, 64, 4)]
        self.linear = rows[:8], rows[8:]


TABLES = Tables()

# 8.2
END_LENGTH, END_KIND, INNER_LENGTH, INNER_KIND, JOINT, GAP, GAP_3, END_OPPOSITE, INNER_OPPOSITE, RULE = \
    0, 32, 96, 112, 144, 384, 640, 672, 688, 704


# -- 1.2 Numbers -------------------------------------------------------------------------------------------------------

def quotient(a, b):
    """a / b: rounded toward zero."""
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def half(a):
    return (a * a).bit_length() if a < 1 << 15 else 2 * a.bit_length()


def log8(a):
    n = a.bit_length() - 1
    return 8 * n + (a << 3 >> n) % 8


def div(a, b):
    n = b.bit_length() - 1
    return a * TABLES.inverse[(b << 6 >> n) % 64] >> 14 + n


def sign(a):
    return (a > 0) - (a < 0)


def scaled(x, h):
    return x << h if h >= 0 else x >> -h


def clamp(a, low, high):
    return min(max(a, low), high)


# -- 2. Header and channels --------------------------------------------------------------------------------------------

class Channel:
    """2.4. `first`: the place of its first number among those of a vertex."""

    COMPONENTS = [(3,), (1, 2, 3, 4), (2, 3), (2,), (3, 4), (1, 2, 3, 4), (1, 2, 3, 4), (1,), (1,)]
    AVERAGE, COPY, PER_FACE = 0, 1, 2

    def __init__(self, kind_and_merge, components, bits):
        self.kind, self.merge = kind_and_merge % 16, kind_and_merge // 16
        self.components, self.bits = components, bits
        self.per_face = self.merge == Channel.PER_FACE
        self.exact = bits == 32
        self.most_bits = 32 if self.exact else 26

    def is_valid(self):
        return self.kind < len(Channel.COMPONENTS) and self.components in Channel.COMPONENTS[self.kind] and \
            self.merge <= Channel.PER_FACE and not (self.per_face and self.components != 1) and \
            (1 <= self.bits <= 24 or self.exact)

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
        return next((c for c in self.channels if c.kind == 0 and c.merge == Channel.AVERAGE and not c.exact), None)

    def numbers(self):
        """The channel of each number of a vertex."""
        return [c for c in self.channels if not c.per_face for _ in range(c.components)]

    def face_channels(self):
        return [c for c in self.channels if c.per_face]


# -- 3. Range decoder --------------------------------------------------------------------------------------------------

def adapted(m, bit, rate):
    return m + (65535 - m >> rate) if bit else m - (m >> rate)


class RangeDecoder:
    def __init__(self, payload, trace):
        self.payload, self.used = payload, 0
        self.range, self.code = 0xffffffff, 0
        self.rate = 4
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


def mean(x, n):  # 9.2
    return x * TABLES.reciprocal[n] >> 16


def mean_of(vector, n):
    return [mean(x, n) for x in vector]


# -- 8. The pair -------------------------------------------------------------------------------------------------------

class Ring:
    """The ring of a centre, and 8.3."""

    def __init__(self, centre, ring, valences, states, position=None):
        """position: gives that of a vertex, None of a virtual one; None without a position channel."""
        self.centre, self.x, self.states = centre, ring, states
        self.size = len(ring)
        self.val = [min(v, 31) for v in valences]
        self.kind = [4 * (0 if v < 4 else v - 3 if v < 10 else 7) + state for v, state in zip(self.val, states)]
        self.length = self.opposite = [0] * self.size
        if position:
            self.locate(position)
            self.find_lengths()
            self.find_angles()

    def locate(self, position):
        origin = position(self.centre)
        self.real = [position(x) is not None for x in self.x]
        offsets = [minus(position(x), origin) if real else [0, 0, 0] for x, real in zip(self.x, self.real)]
        self.h = min(14 - max(abs(c) for o in offsets for c in o).bit_length(), 4)
        self.s = [[scaled(c, self.h) for c in o] for o in offsets]
        self.sq = [dot(s, s) for s in self.s]

    def find_lengths(self):
        logarithms = [log8(sq + 1) for sq in self.sq]
        a, b = sorted(x for x, real in zip(logarithms, self.real) if real)[:2]
        base = (a + b) // 2 - 8
        self.length = [clamp(3 * (x - base) >> 3, 0, 14) if real else 15
                       for x, real in zip(logarithms, self.real)]

    def find_angles(self):
        here, there = [0] * self.size, [0] * self.size
        for k in range(self.size):
            following = (k + 1) % self.size
            a, b, ab = self.sq[k], self.sq[following], dot(self.s[k], self.s[following])
            square = a * b - ab * ab | 1 << 12
            n = square.bit_length() - 1 & ~1
            root = TABLES.inverse_root[(square >> n - 5) - 32]
            here[k] = (b - ab) * root >> n // 2 + 12
            there[following] = (a - ab) * root >> n // 2 + 12
        self.opposite = [clamp(a + b + 26 >> 2, 0, 15) for a, b in zip(here, there)]

    def alternatives(self, order):  # 8.4
        best, result = 31, [0] * self.size
        for k in order:
            result[k] = best
            if self.states[k] == 0:
                result[k] = min(best, self.val[k] + 1)
                best = min(best, self.val[k])
        return result

    def features(self, ruled):  # 8.2
        """Pairs (p, q) in their order, and the numbers of the weights of each."""
        low, high = self.alternatives(range(self.size)), self.alternatives(range(self.size - 1, -1, -1))

        def end(k, which):
            return [END_LENGTH + 16 * which + self.length[k], END_KIND + 32 * which + self.kind[k],
                    END_OPPOSITE + self.opposite[k]]

        pairs = [(p, q) for q in range(1, self.size) for p in range(q)]
        result = []
        for p, q in pairs:
            numbers = end(p, 0) + end(q, 1)
            for k in range(p + 1, q):
                numbers += [INNER_LENGTH + self.length[k], INNER_KIND + self.kind[k], INNER_OPPOSITE + self.opposite[k]]
            numbers.append(JOINT + 24 * clamp(self.size - 3, 0, 9) + q - p)
            if ruled:
                numbers += [RULE + low[p] + 24 - (q - p), RULE + 56 + high[q] + 24 - (q - p)]
            result.append(numbers)
        return pairs, result


class Pairs:
    """The weights of 8.2."""

    TRIES, LISTED, NAT = 16, 48, 4096

    def __init__(self, located):
        self.located = located
        self.weight = [256 * n for n in (TABLES.located if located else TABLES.bare)]

    def decode(self, coder, ring):  # 8.6
        pairs, features = ring.features(self.ruled)
        scores = [sum(self.weight[w] for w in numbers) for numbers in features]
        everything = range(len(pairs))
        near = 12288 if self.ruled else 3072
        low = max(scores) - near
        listed = [k for k in everything if scores[k] >= low][:self.LISTED]
        rank = 0
        while rank < self.TRIES:
            while not listed and rank < self.TRIES:
                listed = [k for k in everything if low - near <= scores[k] < low][:self.LISTED]
                low -= near
                rank += 1
            if not listed:
                break
            best = max(range(len(listed)), key=lambda at: scores[listed[at]])
            listed[best], listed[-1] = listed[-1], listed[best]
            k = listed.pop()
            rest = sorted((scores[other] for other in listed), reverse=True)[:2] + [None, None]
            if self.is_it(coder, pairs[k], rank, scores[k], rest, features[k]):
                return pairs[k]
            rank += 1
        return pairs[coder.uniform(len(pairs))]

    def is_it(self, coder, pair, rank, best, rest, features):
        def gap(x):
            return 31 if x is None else min(best - x >> 10, 31)

        r = min(rank, 7)
        extra = [GAP + 32 * r + gap(rest[0])] + [GAP_3 + gap(rest[1])] * (r == 0)
        bit, error = self.decision(coder, pair, best + sum(self.weight[w] for w in extra))
        for w in extra + features if error else []:  # 8.7
            if -8 * self.NAT < self.weight[w] + error < 8 * self.NAT:
                self.weight[w] += error
        return bit

    def decision(self, coder, pair, score):  # 8.5
        chance = TABLES.logistic[clamp((score >> 9) + 40, 0, 79)]
        bit = coder.fixed("try %d, %d" % pair, chance)
        shift = 11 if self.located else 12
        return bit, 65536 * bit - chance + (1 << shift - 1) >> shift


# -- 9. Values of a split ----------------------------------------------------------------------------------------------

class Questions:
    """9.6. `worth` is that of HIT and that of SAME."""

    HIT, SAME = 0, 64

    def __init__(self):
        self.yes = [256 * n + 128 for n in TABLES.yes]
        self.gain = [16 * n for n in TABLES.gain]
        self.worth = {Questions.HIT: 4096, Questions.SAME: 4096}

    def is_used(self, which, vertices):
        return vertices % 16 == 0 or self.worth[which] > 24

    def ask(self, coder, i):
        if self.gain[i] < 0:
            return 0
        name = f"ask HIT[{i}]" if i < Questions.SAME else f"ask SAME[{i - Questions.SAME}]"
        return coder.fixed(name, self.yes[i])

    def learn(self, i, answer, saved):
        """Returns the gain."""
        result = clamp(saved, -1024, 1024) - self.cost(self.yes[i]) if answer else -self.cost(65536 - self.yes[i])
        gain = result if self.gain[i] >= 0 else 0
        self.gain[i] += 16 * result - self.gain[i] >> 7
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
        self.known = [k for k in range(self.size) if self.w[k] is not None]
        self.group = 0 if self.at_boundary else min(self.size, 9) - 2


def follow(weights, k, product):
    """9.8 and 9.9."""
    weights[k] = clamp(weights[k] + 200 * sign(product), -(1 << 18), 1 << 18)


class Linear:
    """9.5."""

    def __init__(self):
        self.along, self.above = ([[1024 * n for n in row] for row in rows] for rows in TABLES.linear)


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
        t = 1 + ((abs(normal[0]) | abs(normal[1]) | abs(normal[2])) >> 20).bit_length()
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
        self.mean = mean_of(total(self.at), fan.size)

    def following(self, k):
        return self.at[(k + 1) % self.fan.size]

    def find_features(self):  # 9.4
        fan, size, at = self.fan, self.fan.size, self.at
        d = [minus(a, self.mean) for a in at]
        spread = [sum(abs(x[c]) for x in d) for c in range(3)]
        self.extent = mean(sum(spread), size)
        rough = sum(abs(self.height(x)) for x in d)
        self.expected = [half(mean(3 * spread[c], size)) - 2 * self.h - 4 for c in range(2)]
        self.expected.append(half(rough) - 2 * self.h - 2)
        outer = total(minus(minus([2 * c for c in self.out[k]], at[k]), self.following(k)) for k in fan.known)
        n = len(fan.known)
        f0 = [c * TABLES.reciprocal[n] >> 17 for c in outer]
        f1 = [-c for c in self.mean]
        f2 = [0, 0, 0] if fan.at_boundary else minus(shifted(plus(at[1], at[-1]), 1), self.mean)
        weights = [div(64 * self.extent, sum(map(abs, x)) + 5 * self.extent // 16 + 1) for x in d]
        scale = div(1 << 24, sum(weights) + 1)
        f3 = [sum(w * x[c] for w, x in zip(weights, d)) * scale >> 24 for c in range(3)]
        self.f = [f0, f1, f2, f3]

    def predict(self):  # 9.5
        linear, group = self.decoder.linear, self.fan.group
        self.along, self.above = linear.along[group], linear.above[group]
        self.linear = [self.mean[c] + (sum(w * f[c] for w, f in zip(self.along, self.f)) >> 16) for c in range(2)]
        self.rise = sum(w * self.height(f) for w, f in zip(self.above, self.f)) >> 16

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

    def vote(self):
        """The number of the question, or None."""
        rivals = self.rivals()
        if not rivals:
            return None
        self.radius = 14 * self.extent // 256 + ((3 << self.h) // 2 if self.h >= 0 else 0)

        def agree(a, b):
            x = self.apart(a, b)
            return 2 if x < self.radius // 2 else int(x < self.radius)

        votes = [sum(agree(a, b) for j, b in enumerate(rivals) if j != k) for k, a in enumerate(rivals)]
        best = votes.index(max(votes))
        near = [r for k, r in enumerate(rivals) if k == best or self.apart(r, rivals[best]) < self.radius]
        self.agreed = mean_of(total(near), len(near))
        self.group = next((k for k, most in enumerate((0, 1, 2, 4, 7, 11, 17)) if votes[best] <= most), 7)
        x = self.apart(self.agreed, self.linear)
        far = sum(x >= self.radius << i for i in range(5))
        return Questions.HIT + 8 * self.group + far

    def decode(self):
        """B relative to A, in the order of the components."""
        questions, coder = self.decoder.questions, self.decoder.coder
        self.same = questions.is_used(Questions.SAME, self.decoder.vertices)
        self.same_gain = hit = 0
        question = None
        if questions.is_used(Questions.HIT, self.decoder.vertices) and not self.fan.at_boundary and self.fan.size >= 4:
            question = self.vote()
            hit = 0 if question is None else questions.ask(coder, question)
        x, y, z = self.coordinates(hit)
        self.learn(question)
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

    def component(self, place, c, kind, e, predicted):
        if not self.same or self.h < 0:
            return self.coordinate(kind, e, predicted)
        questions = self.decoder.questions
        numbers = [a[c] for a in self.at]
        many = max(map(numbers.count, numbers))
        last = [k for k, n in enumerate(numbers) if numbers.count(n) == many and n not in numbers[k + 1:]]
        common = min((numbers[k] for k in last), key=lambda n: abs(n - predicted))
        question = Questions.SAME + 8 * place + min(many, 7)
        if questions.ask(self.decoder.coder, question):
            value, size = common >> self.h, max(e, 0)
        else:
            value, size = self.coordinate(kind, e, predicted)
        answer = int(value == common >> self.h)
        self.same_gain += questions.learn(question, answer, self.price(common - predicted) + 192)
        return value, size

    def price(self, x):
        least = (3 << self.h) // 4 if self.h > 0 else 1
        return 32 * (half(abs(x) + least) - 2 * self.h)

    def require(self, *values):
        if not all(-(1 << 25) <= value < 1 << 25 for value in values):
            self.decoder.reject("corrupt")

    def coordinates(self, hit):
        h = self.h
        if hit:
            e = half(self.radius) - 2 * h
            kind = "AGREED_2" if self.group == 7 else "AGREED"
            x, size_x = self.coordinate(kind, e, self.agreed[0])
            y, size_y = self.coordinate(kind, quotient(e + size_x + 1, 2), self.agreed[1])
        else:
            x, size_x = self.component(0, 0, "FIRST", self.expected[0], self.linear[0])
            y, size_y = self.component(1, 1, "SECOND", quotient(3 * self.expected[1] + size_x, 4), self.linear[1])
        self.require(x, y)
        self.b = [scaled(x, h), scaled(y, h)]
        u, v = (clamp(b - m, -65536, 65536) for b, m in zip(self.b, self.mean))
        self.plane = self.mean[2] - self.height([u, v, 0])
        predicted = self.plane + (self.height(minus(self.agreed, self.mean)) if hit else self.rise)
        kind = "AGREED_NORMAL" if hit else "NORMAL"
        e = quotient(self.expected[2] + 3 * max(size_x, size_y), 4)
        z, _ = self.component(2 + hit, 2, kind, e, predicted)
        self.require(z)
        self.b.append(scaled(z, h))
        return x, y, z

    # 9.8
    def learn(self, question):
        questions = self.decoder.questions
        errors = minus(self.b[:2], self.linear)
        above = self.b[2] - self.plane - self.rise
        for k, f in enumerate(self.f):
            follow(self.along, k, dot(errors, f))
            follow(self.above, k, above * self.height(f))
        if question is not None:
            saved = sum(self.price(self.b[c] - self.linear[c]) - self.price(self.b[c] - self.agreed[c])
                        for c in range(2))
            answer = int(self.apart(self.b, self.agreed) < 3 * self.radius // 2)
            questions.count(Questions.HIT, questions.learn(question, answer, saved))
        if self.same:
            questions.count(Questions.SAME, self.same_gain)


# -- The decoder -------------------------------------------------------------------------------------------------------

FREE, HELD, HELD_OFTEN, TAKEN = range(4)  # 7.4


class Decoder:
    def __init__(self, data, stop=None, trace=None, limit=None):
        """Decodes at once. `stop`: at so many vertices. `limit`: refuse more vertices, triangles or edges, "limit"."""
        self.kind = None
        self.vertices = 0      # of the result
        self.base_vertices = 0
        self.values = []       # per vertex, all channels of vertices in a row
        self.face_values = {}  # per real triangle, by id: of all channels of faces
        self.mesh = None
        self.levels = self.error = 0
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

    # 10.2
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
            self.start_mesh(Base(self))
        self.stop_here()
        while self.vertices < self.header.vertices:
            self.level()
        # 10.1
        if self.coder.used < self.header.size:
            raise End("corrupt")
        if zlib.crc32(self.header.payload) != self.header.payload_check:
            raise End("checksum")
        self.error = 0
        raise End("done")

    def start_mesh(self, base):
        self.base_values(base)
        self.base_face_values(base.mesh)
        self.first_gates = base.first_gates
        self.mesh, self.vertices, self.base_vertices = base.mesh, base.vertices, base.vertices

    def stop_here(self):
        if self.stop is not None and self.vertices >= self.stop:
            raise End("stopped")

    def start_models(self):
        self.pairs = Pairs(self.header.position is not None)
        self.questions, self.linear = Questions(), Linear()
        self.plain = [self.linear.along[5][:3] for _ in self.header.channels]  # 9.9
        self.code, self.active = 0, 0

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
        sizes = [0] * len(numbers)
        for v in range(base.vertices):
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
                residual = self.residual("BASE", sizes[k].bit_length(), 0, channel.most_bits)
                sizes[k] = (3 * sizes[k] + min(abs(residual), 1 << 28)) // 4
                values.append(self.value(channel, prediction + residual))
            self.end_step()

    def copy(self, channel, near):  # 6.3
        refused = []
        for value in near:
            if value in refused:
                continue
            if self.coder.bit("COPY", 4 * min(len(refused), 2) + min(near.count(value), 3)):
                return value
            refused.append(value)
        return self.coder.raw(channel.bits)

    def base_face_values(self, mesh):  # 6.4
        channels = self.header.face_channels()
        before = None
        for triangle in mesh.real if channels else ():
            before = [self.copy(channel, [before[k]] if before else [0]) for k, channel in enumerate(channels)]
            self.face_values[id(triangle)] = before
            self.end_step()

    # -- 7. Levels

    def level(self):
        self.levels += 1
        if self.levels > 255:
            raise End("corrupt")
        if self.coder.bit("OTHER_LEVEL"):
            self.reject("unsupported")
        self.end_step()
        self.read_error()
        self.coder.rate = 4 if self.vertices < 512 else 5 if self.vertices < 4096 else 6  # 3.3
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
        first_of_others = self.first_gates[self.active][0] if self.active < len(self.first_gates) else self.base_vertices
        return self.vertices - (self.base_vertices - first_of_others)

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
        values, of_faces = self.new_values(ring, Fan(mesh, ring, p, q))
        self.end_step()
        virtual = mesh.is_virtual(x[p]) + mesh.is_virtual(x[q])
        if len(mesh.real) + 2 - virtual > self.header.faces or len(mesh.virtual) + virtual > self.header.edges:
            raise End("corrupt")
        mesh.split(centre, self.vertices, x, p, q)
        self.states[self.vertices] = TAKEN
        self.vertices += 1
        self.values.append(values)
        new = mesh.real[virtual - 2:] if virtual < 2 else []
        self.face_values.update((id(triangle), of_face) for triangle, of_face in zip(new, map(list, zip(*of_faces))))
        self.splits += 1

    def new_values(self, ring, fan):  # 9.1
        """Those of B, and those of the new triangles for each channel of faces."""
        result, of_faces = [], []
        for k, channel in enumerate(self.header.channels):
            numbers = range(channel.first, channel.first + channel.components)
            if channel.per_face:
                of_faces.append(self.new_face_values(len(of_faces), channel, ring, fan))
            elif channel is self.header.position:
                origin = self.position(ring.centre)
                offset = Place(self, ring, fan, self.position).decode()
                result += [self.value(channel, number) for number in plus(origin, offset)]
            elif channel.merge == Channel.AVERAGE:
                result += [self.plain_value(channel, fan, c, self.plain[k]) for c in numbers]
            else:
                order = ([0, 1, fan.size - 1] + list(range(2, fan.size - 1)))[:min(fan.size, 6)]
                result += [self.copy(channel, [self.values[fan.v[at]][c] for at in order]) for c in numbers]
        return result, of_faces

    def plain_value(self, channel, fan, c, weights):  # 9.9
        a = channel.rough(self.values[fan.v[0]][c])
        t = [channel.rough(self.values[v][c]) - a for v in fan.v]
        m = mean(sum(t), fan.size)
        outer = sum(2 * (channel.rough(self.values[fan.w[k]][c]) - a) - t[k] - t[(k + 1) % fan.size] >> 2
                    for k in fan.known)
        g = [outer * TABLES.reciprocal[len(fan.known)] >> 15, -m, 0 if fan.at_boundary else (t[1] + t[-1] >> 1) - m]
        prediction = (a + m + sum(x * w >> 16 for x, w in zip(g, weights))) * channel.unit()
        e = half(sum(abs(x - m) for x in t) // fan.size) + (16 if channel.exact else 0)
        residual = self.difference("PLAIN", e, channel.most_bits)
        for k in range(3):
            follow(weights, k, residual * g[k])
        return self.value(channel, prediction + residual)

    def new_face_values(self, k, channel, ring, fan):  # 9.12
        """Of channel k among those of faces: the values of the new triangles at the real ones of two ends."""
        made = []
        for x in ring.x[fan.p], ring.x[fan.q]:
            if self.mesh.is_virtual(x):
                continue
            beside = [self.face_values.get(id(self.mesh.left[edge])) for edge in ((ring.centre, x), (x, ring.centre))]
            made.append(self.copy(channel, made[:1] + [values[k] for values in beside if values]))
        return made


def dump(decoder):
    """The text of tests/reference/dump.c."""
    triangles = decoder.triangles()
    lines = [decoder.kind, f"{decoder.vertices} vertices, {len(triangles)} triangles"]
    if decoder.kind == "done":
        lines.append(f"{decoder.levels} levels")
    if decoder.kind in ("done", "stopped", "truncated"):
        lines.append(f"error {decoder.error}")
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
