// draco.cpp - libdraco, in the bench: edgebreaker, positions as whole numbers. SPDX-License-Identifier: MIT
#include "ours.hpp"

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <stdexcept>

namespace {

class Draco final : public Codec {
public:
    explicit Draco(int level) : level_(level) {}
    std::string name() const override { return "draco-" + std::to_string(level_); }
    Bytes encode(const Mesh &) override;
    void decode(const Bytes &) override;
    Decoded inspect() const override;
    void release() override { mesh_.reset(); }

private:
    int level_;
    std::unique_ptr<draco::Mesh> mesh_;
};

draco::PointIndex point(size_t i) { return draco::PointIndex(static_cast<uint32_t>(i)); }

std::unique_ptr<draco::Mesh> draco_mesh(const Mesh &in)
{
    auto mesh = std::make_unique<draco::Mesh>();
    draco::GeometryAttribute attribute;
    attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false, 3 * sizeof(int32_t), 0);
    mesh->set_num_points(static_cast<uint32_t>(in.vertices()));
    int id = mesh->AddAttribute(attribute, true, static_cast<uint32_t>(in.vertices()));
    for (uint32_t v = 0; v < in.vertices(); ++v)
        mesh->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &in.positions[3 * size_t{ v }]);
    mesh->SetNumFaces(in.faces());
    for (size_t f = 0; f < in.faces(); ++f) {
        const uint32_t *v = &in.indices[3 * f];
        mesh->SetFace(draco::FaceIndex(static_cast<uint32_t>(f)), { point(v[0]), point(v[1]), point(v[2]) });
    }
    return mesh;
}

Bytes Draco::encode(const Mesh &in)
{
    auto mesh = draco_mesh(in);
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    encoder.SetSpeedOptions(10 - level_, 10 - level_);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    if (!encoder.EncodeMeshToBuffer(*mesh, &buffer).ok()) throw std::runtime_error("draco cannot encode");
    return Bytes(buffer.data(), buffer.data() + buffer.size());
}

void Draco::decode(const Bytes &bytes)
{
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;
    buffer.Init(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok()) throw std::runtime_error("draco cannot decode");
    mesh_ = std::move(result).value();
}

Decoded Draco::inspect() const
{
    const draco::PointAttribute *attribute = mesh_->GetNamedAttribute(draco::GeometryAttribute::POSITION);
    auto position = [&](size_t i) {
        int32_t p[3];
        attribute->GetMappedValue(point(i), p);
        return position_key(static_cast<uint64_t>(p[0]), static_cast<uint64_t>(p[1]), static_cast<uint64_t>(p[2]));
    };
    Decoded out{ mesh_->num_points(), mesh_->num_faces(), 0 };
    for (uint32_t f = 0; f < out.faces; ++f) {
        const draco::Mesh::Face &face = mesh_->face(draco::FaceIndex(f));
        out.sum += face_sum(position, face[0].value(), face[1].value(), face[2].value());
    }
    return out;
}

} // namespace

std::unique_ptr<Codec> make_draco(int level) { return std::make_unique<Draco>(level); }
