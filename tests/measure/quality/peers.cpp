// peers.cpp - what other libraries make of a mesh, for the curves. SPDX-License-Identifier: MIT
//
//     peers copy IN OUT                    the same mesh in another format
//     peers draco BITS IN OUT              encodes with libdraco, positions at so many bits; prints the bytes, decodes
//     peers simplify VERTICES IN OUT       simplifies with libmeshoptimizer
//     peers reduce TRIANGLES IN OUT        the same, as triangles are what it counts
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" {
#include "mesh_file.h"
}

namespace {

constexpr int kDracoLevel = 10;

struct Mesh {
    std::vector<float> positions;
    std::vector<uint32_t> indices;
    size_t vertices() const { return positions.size() / 3; }
};

Mesh load(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    std::string data((std::istreambuf_iterator<char>(file)), {});
    mesh_file in;
    char error[MESH_ERROR_BYTES];
    if (!mesh_read(&in, reinterpret_cast<const uint8_t *>(data.data()), data.size(), mesh_format_of_path(path.c_str()),
                   error))
        throw std::runtime_error(path + ": " + error);
    Mesh mesh{ { in.positions, in.positions + 3 * size_t{ in.num_vertices } },
               { in.indices, in.indices + 3 * size_t{ in.num_faces } } };
    mesh_free(&in);
    return mesh;
}

void save(Mesh &mesh, const std::string &path)
{
    std::vector<double> positions(mesh.positions.begin(), mesh.positions.end());
    mesh_file out{};
    out.positions = positions.data();
    out.indices = mesh.indices.data();
    out.num_vertices = static_cast<uint32_t>(mesh.vertices());
    out.num_faces = static_cast<uint32_t>(mesh.indices.size() / 3);
    std::FILE *file = std::fopen(path.c_str(), "wb");
    if (!file) throw std::runtime_error(path + ": cannot write");
    bool ok = mesh_write(&out, file, mesh_format_of_path(path.c_str()));
    if (std::fclose(file) != 0 || !ok) throw std::runtime_error(path + ": cannot write");
}

draco::PointIndex point(size_t i) { return draco::PointIndex(static_cast<uint32_t>(i)); }

std::unique_ptr<draco::Mesh> draco_mesh(const Mesh &in)
{
    auto mesh = std::make_unique<draco::Mesh>();
    draco::GeometryAttribute attribute;
    attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 3 * sizeof(float), 0);
    mesh->set_num_points(static_cast<uint32_t>(in.vertices()));
    int id = mesh->AddAttribute(attribute, true, static_cast<uint32_t>(in.vertices()));
    for (uint32_t v = 0; v < in.vertices(); ++v)
        mesh->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &in.positions[3 * size_t{ v }]);
    mesh->SetNumFaces(in.indices.size() / 3);
    for (size_t h = 0; h < in.indices.size(); h += 3)
        mesh->SetFace(draco::FaceIndex(static_cast<uint32_t>(h / 3)),
                      { point(in.indices[h]), point(in.indices[h + 1]), point(in.indices[h + 2]) });
    return mesh;
}

Mesh mesh_of_draco(const draco::Mesh &in)
{
    Mesh out;
    const draco::PointAttribute *attribute = in.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    out.positions.resize(3 * size_t{ in.num_points() });
    for (size_t v = 0; v < out.vertices(); ++v) attribute->GetMappedValue(point(v), &out.positions[3 * v]);
    for (uint32_t f = 0; f < in.num_faces(); ++f)
        for (auto corner : in.face(draco::FaceIndex(f))) out.indices.push_back(corner.value());
    return out;
}

Mesh through_draco(const Mesh &in, int bits)
{
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    encoder.SetSpeedOptions(10 - kDracoLevel, 10 - kDracoLevel);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
    if (!encoder.EncodeMeshToBuffer(*draco_mesh(in), &buffer).ok()) throw std::runtime_error("draco cannot encode");
    std::printf("%zu\n", buffer.size());
    draco::DecoderBuffer bytes;
    draco::Decoder decoder;
    bytes.Init(buffer.data(), buffer.size());
    auto result = decoder.DecodeMeshFromBuffer(&bytes);
    if (!result.ok()) throw std::runtime_error("draco cannot decode");
    return mesh_of_draco(*result.value());
}

// As close to the number of triangles as the simplifier gets.
Mesh reduced(const Mesh &in, size_t triangles)
{
    Mesh out;
    size_t target = 3 * triangles;
    out.indices.resize(in.indices.size());
    out.indices.resize(meshopt_simplify(out.indices.data(), in.indices.data(), in.indices.size(), in.positions.data(),
                                        in.vertices(), 3 * sizeof(float), target, 1.0f, 0, nullptr));
    out.positions.resize(in.positions.size());
    out.positions.resize(3 * meshopt_optimizeVertexFetch(out.positions.data(), out.indices.data(), out.indices.size(),
                                                         in.positions.data(), in.vertices(), 3 * sizeof(float)));
    return out;
}

Mesh simplified(const Mesh &in, size_t vertices)
{
    return reduced(in, in.indices.size() * vertices / in.vertices() / 3);
}

Mesh make(const std::string &what, const std::vector<std::string> &words)
{
    if (what == "copy" && words.size() == 2) return load(words[0]);
    if (what == "draco" && words.size() == 3) return through_draco(load(words[1]), std::stoi(words[0]));
    if (what == "simplify" && words.size() == 3) return simplified(load(words[1]), std::stoul(words[0]));
    if (what == "reduce" && words.size() == 3) return reduced(load(words[1]), std::stoul(words[0]));
    throw std::runtime_error("usage: peers copy IN OUT | draco BITS IN OUT | simplify VERTICES IN OUT | "
                             "reduce TRIANGLES IN OUT");
}

} // namespace

int main(int argc, char **argv)
{
    try {
        std::vector<std::string> words(argv + 1, argv + argc);
        if (words.empty()) words.push_back("");
        std::string what = words[0];
        words.erase(words.begin());
        Mesh mesh = make(what, words);
        save(mesh, words.back());
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "peers: %s\n", error.what());
        return 1;
    }
}
