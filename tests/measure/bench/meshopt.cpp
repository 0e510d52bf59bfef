// meshopt.cpp - libmeshoptimizer and libzstd, in the bench. SPDX-License-Identifier: MIT
//
// As its manual advises: triangles and vertices are put into the order of the vertex cache first, which is part of the
// time to encode; then both codecs, then zstd.
#include "ours.hpp"

#include <meshoptimizer.h>
#include <zstd.h>

#include <cstring>
#include <stdexcept>

namespace {

constexpr int kZstdLevel = 9;

struct Vertex {
    uint16_t x, y, z, zero; // the codec wants a multiple of four bytes
};

struct Counts {
    uint64_t vertices, indices, index_bytes, vertex_bytes;
};

class Meshopt final : public Codec {
public:
    std::string name() const override { return "meshopt+zstd"; }
    Bytes encode(const Mesh &) override;
    void decode(const Bytes &) override;
    Decoded inspect() const override;
    void release() override { vertices_ = {}, indices_ = {}; }

private:
    std::vector<Vertex> vertices_;
    std::vector<uint32_t> indices_;
};

std::vector<Vertex> pack(const Mesh &mesh)
{
    std::vector<Vertex> out;
    for (size_t i = 0; i < mesh.positions.size(); i += 3)
        out.push_back({ static_cast<uint16_t>(mesh.positions[i]), static_cast<uint16_t>(mesh.positions[i + 1]),
                        static_cast<uint16_t>(mesh.positions[i + 2]), 0 });
    return out;
}

Bytes encode_indices(const std::vector<uint32_t> &indices, size_t vertices)
{
    Bytes out(meshopt_encodeIndexBufferBound(indices.size(), vertices));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
    return out;
}

Bytes encode_vertices(const std::vector<Vertex> &vertices)
{
    Bytes out(meshopt_encodeVertexBufferBound(vertices.size(), sizeof(Vertex)));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), vertices.data(), vertices.size(), sizeof(Vertex)));
    return out;
}

Bytes Meshopt::encode(const Mesh &mesh)
{
    std::vector<uint32_t> indices(mesh.indices.size());
    std::vector<Vertex> vertices = pack(mesh);
    meshopt_optimizeVertexCacheStrip(indices.data(), mesh.indices.data(), indices.size(), vertices.size());
    meshopt_optimizeVertexFetch(vertices.data(), indices.data(), indices.size(), vertices.data(), vertices.size(),
                                sizeof(Vertex));
    Bytes index_part = encode_indices(indices, vertices.size()), vertex_part = encode_vertices(vertices);
    Counts counts{ vertices.size(), indices.size(), index_part.size(), vertex_part.size() };
    index_part.insert(index_part.end(), vertex_part.begin(), vertex_part.end());
    Bytes out(sizeof counts + ZSTD_compressBound(index_part.size()));
    std::memcpy(out.data(), &counts, sizeof counts);
    size_t size = ZSTD_compress(&out[sizeof counts], out.size() - sizeof counts, index_part.data(), index_part.size(),
                                kZstdLevel);
    if (ZSTD_isError(size)) throw std::runtime_error("zstd cannot compress");
    out.resize(sizeof counts + size);
    return out;
}

void Meshopt::decode(const Bytes &bytes)
{
    Counts counts;
    std::memcpy(&counts, bytes.data(), sizeof counts);
    Bytes parts(counts.index_bytes + counts.vertex_bytes);
    size_t size = ZSTD_decompress(parts.data(), parts.size(), &bytes[sizeof counts], bytes.size() - sizeof counts);
    indices_.resize(counts.indices);
    vertices_.resize(counts.vertices);
    if (size != parts.size() ||
        meshopt_decodeIndexBuffer(indices_.data(), indices_.size(), parts.data(), counts.index_bytes) ||
        meshopt_decodeVertexBuffer(vertices_.data(), vertices_.size(), sizeof(Vertex), &parts[counts.index_bytes],
                                   counts.vertex_bytes))
        throw std::runtime_error("meshoptimizer cannot decode");
}

Decoded Meshopt::inspect() const
{
    auto position = [&](size_t v) { return position_key(vertices_[v].x, vertices_[v].y, vertices_[v].z); };
    Decoded out{ vertices_.size(), indices_.size() / 3, 0 };
    for (size_t h = 0; h < indices_.size(); h += 3)
        out.sum += face_sum(position, indices_[h], indices_[h + 1], indices_[h + 2]);
    return out;
}

} // namespace

std::unique_ptr<Codec> make_meshopt() { return std::make_unique<Meshopt>(); }
