"""Random valid streams, of the kind that no encoder writes.   SPDX-License-Identifier: MIT

decoder.py runs with a coder that makes symbols up and writes them (a range encoder for section 3 of SPEC.md). So
every choice that the format allows is taken at times: bases of any shape, joins that could have been turns, numbers of
bits far from what is expected, improbable pairs."""

import copy
import itertools
import random

import decoder
from decoder import End


class Writer(decoder.RangeDecoder):
    """Chooses symbols instead of reading them. The interval is [low, low + range) of a number of `used` bytes."""

    def __init__(self, draw):
        super().__init__(b"", None)
        self.draw, self.low = draw, 0
        self.bits = {}             # the next bit of a table, if it is known
        self.next_raw = None       # the next raw number, if it is known; then the uniform ones that it consists of
        self.digits = []
        self.number = None         # the next count, if it is known
        self.flags = 0             # patches that may still be split at this level
        self.stubborn = draw.choice((0, 0.5, 1))  # how often pairs that are asked about are mostly refused
        self.sizes = 0, 0, 0, 1, 1, 2, 3  # numbers of bits of residuals

    def choose_size(self, kind, expected):
        """The number of bits of a residual, said in one of the ways there are."""
        n = self.draw.choice(self.sizes)
        self.number = n - expected if n >= expected else expected - 1 - n
        if n < expected and self.draw.random() < 0.1:
            n = 0
            self.number = self.draw.randrange(expected - 1, 39)
        if expected:
            self.bits[kind] = int(n >= expected)

    def take(self, offset, width):
        self.low += offset
        self.range = width
        while self.range < 1 << 24:
            self.range <<= 8
            self.low <<= 8
            self.used += 1

    def payload_bytes(self):
        for zeros in range(8 * self.used, -1, -1):
            value = (self.low + (1 << zeros) - 1) >> zeros << zeros
            if value < self.low + self.range:
                return value.to_bytes(self.used, "big").rstrip(b"\0")
        raise AssertionError

    def bit(self, table, index=0):
        self.code = 0 if self.choose_bit(table) else self.range - 1
        return super().bit(table, index)

    def choose_bit(self, table):
        if table in self.bits:
            return self.bits.pop(table)
        if table == "FLAG":
            split = self.flags > 0 and self.draw.random() < 0.6
            self.flags -= split
            return split
        return self.draw.random() < {"OTHER_LEVEL": 0, "COMPONENT": 0.3, "LOOP": 0.4, "PASSED": 0.3,
                                     "BEGINS": 0.8}.get(table, 0.5)

    def fixed(self, name, m):
        yes = self.draw.random() < (0.15 if name.startswith("try") and self.draw.random() < self.stubborn else 0.5)
        self.code = 0 if yes else self.range - 1
        return super().fixed(name, m)

    def uniform(self, n):
        self.code = self.range // n * (self.digits.pop(0) if self.digits else self.draw.randrange(n))
        return super().uniform(n)

    def raw(self, n):
        if self.next_raw is not None:
            ends = range(n - 8, 8, -8)  # of the bytes, and 0 of what is left of them
            self.digits = [self.next_raw >> end & 255 for end in ends]
            self.digits += [self.next_raw % (1 << n - 8 * len(ends))] if n > 0 else []
            self.next_raw = None
        return super().raw(n)

    def count(self, table, first):
        if self.number is None:
            return super().count(table, first)
        value, self.number = self.number, None
        for k in range(min(value + 1, 7)):
            self.bits[table] = int(value > k)
            self.bit(table, first + k)
        if value >= 7:
            self.next_raw = value - 7
            self.raw(5)
        return value


class Header(decoder.Header):
    """Counts that are not known yet do not limit anything."""

    size, payload = 0, b""
    faces = edges = 1 << 20
    rows = aside_rows = aside_faces = metadata = materials = regular = 0

    def __init__(self, draw):
        self.loops = draw.choice((0, 0, 1, 1, 2, 3))
        self.base_vertices = draw.randint(3, 14)
        self.vertices = self.base_vertices + draw.choice((0, 1, 5, 30))
        self.channels, self.raw_channels = [], b""
        for _ in range(draw.choice((0, 0, 1, 1, 2, 4))):
            while True:
                kind, merge = draw.choice((0, 0, 3, draw.randrange(9))), draw.choice((0, draw.randrange(3)))
                bits = 32 if draw.random() < 0.3 else draw.randint(5, 24)
                channel = decoder.Channel(kind + 16 * merge, draw.randint(1, 4), bits)
                if channel.is_valid():
                    break
            self.put_channel(channel, draw)

    def put_channel(self, channel, draw):
        self.add_channel(channel)
        has_grid = draw.random() < 0.7
        form = channel.kind + 16 * channel.merge + 64 * (not has_grid)
        self.raw_channels += bytes((form, channel.components, channel.bits))
        self.raw_channels += draw.randbytes(has_grid * (4 + 4 * channel.components))

    def all_faces(self):  # known when the base is there
        return 2 * (self.vertices + self.loops) - 4 * self.chi

    def has_euler(self, euler):
        self.chi = (euler + 2 * self.loops) // 4
        return True


class Base(decoder.Base):
    """Chooses among the triangles that use no directed edge twice."""

    def new_vertex(self, may_be_virtual):
        room = self.vertices < self.header.base_vertices
        if not room:
            self.coder.bits["LOOP"] = 1
        v = super().new_vertex(may_be_virtual)
        self.coder.bits.pop("LOOP", None)
        if not room and not self.is_virtual(v):
            raise End("stuck")
        return v

    def start_component(self):
        self.edges = set() if self.vertices == 0 else self.edges
        super().start_component()
        self.use(*self.last[self.first_gates[-1][0]])

    def use(self, *triangle):
        for k in range(3):
            self.edges.add((triangle[k], triangle[(k + 1) % 3]))

    def grow(self):
        bits = self.coder.bits
        u, w = self.corner(self.gate, 0), self.corner(self.gate, 1)
        options = []
        following = self.after[self.gate]
        room = self.vertices < self.header.base_vertices or \
            (self.loops < self.header.loops and not self.is_virtual(u) and not self.is_virtual(w))
        if room:
            options += [("grow", None)] * 4
        opens = [h for h in self.after if self.is_open(h)]
        for kind, border in [("turn", self.before2), ("close", following)] * 2 + [("join", h) for h in opens]:
            x = self.corner(border, 1)
            edges = self.edges
            turn = x == self.corner(self.before, 0)
            close = x == self.corner(following, 1)
            if x in (u, w) or (u, x) in edges or (x, w) in edges or (not turn and (x, u) in edges) or \
               (not close and (w, x) in edges):
                continue
            options.append((kind, border))
        if not options:
            raise End("stuck")
        kind, border = self.choose(options, u, w)
        for name in ("grow", "turn", "close"):
            bits[name.upper()] = int(kind == name)
            if kind == name:
                break
        if kind == "join":
            reals = 3 * len(self.real)
            self.coder.next_raw = border if border < reals else border - 3 * self.header.faces + reals
        super().grow()
        self.use(*self.last[u])

    def choose(self, options, u, w):
        return self.coder.draw.choice(options)


class Hubs(Base):
    """A double pyramid: vertex 0 with all others but the last around it, and the last one likewise."""

    def choose(self, options, u, w):
        last = self.header.base_vertices - 1
        if self.vertices < last:
            return "grow", None
        if self.vertices == last:
            return ("turn", self.before2) if u == 0 else ("grow", None)
        return ("close", self.after[self.gate]) if u == last else ("turn", self.before2)


class Maker(decoder.Decoder):
    def residual(self, kind, expected, c, most=26, fraction=None):
        sizes = self.coder.sizes
        self.coder.sizes = sizes if most == 26 else range(39)   # any residual of an exact value is valid
        result = super().residual(kind, expected, c, most, fraction)
        self.coder.sizes = sizes
        return result

    def number_of_bits(self, kind, expected, index):
        self.coder.choose_size(kind, expected)
        return super().number_of_bits(kind, expected, index)

    def __init__(self, draw, header, base=Base):
        self.kind, self.vertices, self.values, self.mesh, self.stop = None, 0, [], None, None
        self.levels = self.error = 0
        self.rows, self.num_rows, self.materials = None, 0, None
        self.header = header
        self.coder = Writer(draw)
        self.face_values = {}
        self.start_models()
        if base == Hubs:
            self.coder.sizes = 0, 8, 9
            self.coder.bits["COMPONENT"] = 0
        self.read_base(base(self))
        if draw.random() < 0.3:
            self.header.vertices = self.vertices      # virtual vertices keep their numbers
        while self.vertices < self.header.vertices:
            self.level()

    def read_active(self):
        super().read_active()
        self.coder.flags = self.header.vertices - self.vertices


def make(seed):
    """The counts, channels and payload of a valid stream."""
    draw = random.Random(f"stream {seed}")
    header = None
    for attempt in itertools.count():
        if attempt % 300 == 0:
            header = Header(draw)
        try:
            return result(Maker(draw, copy.copy(header)))
        except End:
            continue


def make_hubs(seed):
    """The same, with two vertices of valence 80 in the base, and values that differ."""
    draw = random.Random(f"hubs {seed}")
    while True:
        header = Header(draw)
        header.loops, header.base_vertices, header.vertices = 0, 82, 82 + draw.choice((0, 7))
        header.channels, header.raw_channels = [], b""
        for channel in (1, 4, 20), (0, 3, 24):
            header.put_channel(decoder.Channel(*channel), draw)
        try:
            return result(Maker(draw, header, Hubs))
        except End:
            continue


def result(m):
    h = m.header
    return (h.vertices, h.loops, len(m.mesh.virtual), h.chi, bytes([len(h.channels)]) + h.raw_channels,
            m.coder.payload_bytes())
