// bench.hpp - what the parts of the bench share. SPDX-License-Identifier: MIT
//
//     bench.cpp     timing, table, targets                draco.cpp    peer: libdraco
//     mesh.cpp      reads meshes and quantises them       meshopt.cpp  peer: libmeshoptimizer and libzstd
//     memory.cpp    counts what is allocated              openctm.cpp  peer: libopenctm
//     ours.cpp      conquest
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

using Bytes = std::vector<uint8_t>;

// Positions are whole numbers of kBits bits, the same for all codecs: nothing is lost but by quantisation before.
inline constexpr int kBits = 12;

struct Mesh {
    std::string name;
    std::vector<uint32_t> indices;     // three for each face
    std::vector<int32_t> positions;    // three for each vertex
    size_t vertices() const { return positions.size() / 3; }
    size_t faces() const { return indices.size() / 3; }
};

// What came out of a decoder. The sums do not depend on the order of vertices, faces and corners: they tell whether the
// mesh is the one that went in, up to chance.
struct Decoded {
    size_t vertices = 0, faces = 0;
    uint64_t sum = 0;
};

// -- mesh.cpp: throws what the reader says of a file that it cannot read

Mesh load(const std::string &name, const std::string &path, std::vector<double> *exact = nullptr); // coordinates, as read
Decoded inspect(const Mesh &);

class Codec {
public:
    virtual ~Codec() = default;
    virtual std::string name() const = 0;
    virtual bool handles(const Mesh &) const { return true; }
    virtual Bytes encode(const Mesh &) = 0;

    // decode() is what is timed: from bytes to the mesh as the library gives it, which stays until release().
    virtual void decode(const Bytes &) = 0;
    virtual Decoded inspect() const = 0;
    virtual void release() = 0;
};

// -- memory.cpp: bytes allocated now, and the most since the last reset, by any library of the process

size_t memory_now();
size_t memory_peak();
void memory_reset_peak();

// -- Order-independent sums

inline uint64_t mix(uint64_t x)
{
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

// Of a face by the positions of its corners, wherever it starts; the orientation counts.
template <class Position> uint64_t face_sum(Position &&position, size_t a, size_t b, size_t c)
{
    uint64_t p = position(a), q = position(b), r = position(c);
    return mix(mix(p) + 3 * mix(q + 1)) + mix(mix(q) + 3 * mix(r + 1)) + mix(mix(r) + 3 * mix(p + 1));
}

inline uint64_t position_key(uint64_t x, uint64_t y, uint64_t z) { return x << 42 | y << 21 | z; }
