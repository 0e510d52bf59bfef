// ours.cpp - conquest, in the bench. SPDX-License-Identifier: MIT
#define CONQUEST_IMPLEMENTATION
#include "ours.hpp"

#include "conquest.h"

#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace {

struct Free {
    void operator()(void *p) const { std::free(p); }
};
using Block = std::unique_ptr<void, Free>;

class Ours final : public Codec {
public:
    std::string name() const override { return "conquest"; }
    Bytes encode(const Mesh &) override;
    void decode(const Bytes &bytes) override { begin(bytes), refine(CQ_NO_LIMIT); }
    Decoded inspect() const override;
    void release() override { decoder_.reset(), memory_.reset(); }

    void begin(const Bytes &);
    cq_result refine(uint32_t budget);
    size_t vertices() const { return decoder_->mesh.num_vertices; }
    size_t bytes_used() const { return static_cast<size_t>(in_.data - start_); }

private:
    std::unique_ptr<cq_decoder> decoder_;
    Block memory_;
    cq_bytes in_{};
    const uint8_t *start_ = nullptr;
};

cq_input input_of(const Mesh &mesh)
{
    cq_input in{};
    in.shape.num_vertices = static_cast<uint32_t>(mesh.vertices());
    in.shape.num_faces = static_cast<uint32_t>(mesh.faces());
    in.shape.num_channels = 1;
    in.shape.channel[0].components = 3;
    in.shape.channel[0].bits = kBits;
    in.indices = mesh.indices.data();
    in.values[0] = mesh.positions.data();
    return in;
}

cq_result try_encode(cq_input &in, Bytes &out, size_t &size)
{
    size_t memory_size = cq_encoder_bytes(&in.shape) / 8 * 9; // boundaries need little more
    Block memory(std::malloc(memory_size));
    return cq_encode(&in, memory.get(), memory_size, out.data(), out.size(), &size, nullptr, nullptr);
}

Bytes Ours::encode(const Mesh &mesh)
{
    cq_input in = input_of(mesh);
    Bytes out(4096 + 8 * mesh.vertices());
    size_t size = 0;
    cq_result result = try_encode(in, out, size);
    if (result == CQ_ERROR_MEMORY) result = try_encode(in, out, size); // the boundaries are known now
    if (result != CQ_OK) throw std::runtime_error(cq_result_string(result));
    return Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size));
}

void Ours::begin(const Bytes &bytes)
{
    cq_shape shape;
    cq_peek(bytes.data(), bytes.size(), &shape, nullptr, nullptr);
    size_t size = cq_decoder_bytes(&shape);
    decoder_.reset(new cq_decoder);
    memory_.reset(std::malloc(size));
    cq_decoder_init(decoder_.get(), memory_.get(), size);
    start_ = bytes.data();
    in_ = { start_, bytes.size() };
}

cq_result Ours::refine(uint32_t budget)
{
    cq_result result = cq_decode(decoder_.get(), &in_, budget);
    if (result < CQ_OK) throw std::runtime_error(cq_result_string(result));
    return result;
}

Decoded Ours::inspect() const
{
    const cq_mesh &m = decoder_->mesh;
    const cq_value *p = decoder_->channel[0];
    auto position = [&](size_t v) {
        return position_key(static_cast<uint64_t>(p[3 * v]), static_cast<uint64_t>(p[3 * v + 1]),
                            static_cast<uint64_t>(p[3 * v + 2]));
    };
    Decoded out{ m.num_vertices, m.num_faces, 0 };
    for (size_t h = 0; h < 3 * out.faces; h += 3)
        out.sum += face_sum(position, m.origin[h], m.origin[h + 1], m.origin[h + 2]);
    return out;
}

} // namespace

std::unique_ptr<Codec> make_ours() { return std::make_unique<Ours>(); }

FirstView first_view(const Bytes &bytes, size_t vertices, double (*seconds)())
{
    Ours ours;
    FirstView view;
    double begin = seconds();
    ours.begin(bytes);
    while (ours.vertices() < vertices && ours.refine(64) == CQ_MORE) {}
    view.seconds = seconds() - begin;
    view.bytes = ours.bytes_used();
    return view;
}

size_t encoder_bytes(const Mesh &mesh)
{
    cq_input in = input_of(mesh);
    Bytes none;
    size_t size = 0;
    in.shape.num_channels = 0;
    try_encode(in, none, size); // finds the boundaries; the output is too small, or else the memory
    in.shape.num_channels = 1;
    return cq_encoder_bytes(&in.shape) - sizeof(cqi_encoder);
}

size_t decoder_bytes(const Bytes &bytes)
{
    cq_shape shape;
    cq_peek(bytes.data(), bytes.size(), &shape, nullptr, nullptr);
    return cq_decoder_bytes(&shape);
}
