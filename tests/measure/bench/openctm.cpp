// openctm.cpp - libopenctm, in the bench: method MG2. SPDX-License-Identifier: MIT
//
// It has no whole numbers. With a precision of 1 it puts them on a grid with another origin and they don't come back;
// with a precision of 1/2 they do.
#include "ours.hpp"

#include <openctm.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace {

constexpr size_t kMostVertices = 500000; // it takes minutes for more

class Openctm final : public Codec {
public:
    std::string name() const override { return "openctm"; }
    bool handles(const Mesh &mesh) const override { return mesh.vertices() <= kMostVertices; }
    Bytes encode(const Mesh &) override;
    void decode(const Bytes &) override;
    Decoded inspect() const override;
    void release() override { ctmFreeContext(context_), context_ = nullptr; }

private:
    CTMcontext context_ = nullptr;
};

CTMuint CTMCALL append(const void *data, CTMuint count, void *to)
{
    auto bytes = static_cast<const uint8_t *>(data);
    static_cast<Bytes *>(to)->insert(static_cast<Bytes *>(to)->end(), bytes, bytes + count);
    return count;
}

struct Reader {
    const Bytes *bytes;
    size_t at;
};

CTMuint CTMCALL take(void *to, CTMuint count, void *from)
{
    auto reader = static_cast<Reader *>(from);
    size_t left = reader->bytes->size() - reader->at, n = count < left ? count : left;
    std::memcpy(to, reader->bytes->data() + reader->at, n);
    reader->at += n;
    return static_cast<CTMuint>(n);
}

Bytes Openctm::encode(const Mesh &mesh)
{
    Bytes out;
    std::vector<float> positions(mesh.positions.begin(), mesh.positions.end());
    CTMcontext context = ctmNewContext(CTM_EXPORT);
    ctmDefineMesh(context, positions.data(), static_cast<CTMuint>(mesh.vertices()), mesh.indices.data(),
                  static_cast<CTMuint>(mesh.faces()), nullptr);
    ctmCompressionMethod(context, CTM_METHOD_MG2);
    ctmVertexPrecision(context, 0.5f);
    ctmSaveCustom(context, append, &out);
    CTMenum error = ctmGetError(context);
    ctmFreeContext(context);
    if (error != CTM_NONE) throw std::runtime_error(ctmErrorString(error));
    return out;
}

void Openctm::decode(const Bytes &bytes)
{
    Reader reader{ &bytes, 0 };
    context_ = ctmNewContext(CTM_IMPORT);
    ctmLoadCustom(context_, take, &reader);
    if (ctmGetError(context_) != CTM_NONE) throw std::runtime_error("openctm cannot decode");
}

Decoded Openctm::inspect() const
{
    const CTMuint *indices = ctmGetIntegerArray(context_, CTM_INDICES);
    const CTMfloat *p = ctmGetFloatArray(context_, CTM_VERTICES);
    auto whole = [&](size_t i) { return static_cast<uint64_t>(std::lround(p[i])); };
    auto position = [&](size_t v) { return position_key(whole(3 * v), whole(3 * v + 1), whole(3 * v + 2)); };
    Decoded out{ ctmGetInteger(context_, CTM_VERTEX_COUNT), ctmGetInteger(context_, CTM_TRIANGLE_COUNT), 0 };
    for (size_t h = 0; h < 3 * out.faces; h += 3)
        out.sum += face_sum(position, indices[h], indices[h + 1], indices[h + 2]);
    return out;
}

} // namespace

std::unique_ptr<Codec> make_openctm() { return std::make_unique<Openctm>(); }
