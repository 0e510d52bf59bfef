// assets.cpp - bytes of mesh files with all their attributes, ours and Draco's. SPDX-License-Identifier: MIT
//
//     assets MESH_FILE...
//
// Both code positions of 14 bits, octahedral normals of 10, texture coordinates of 12 and colors of 8 bits, as far
// as the file has them, on the same grids: we with the defaults of cq_input, libdraco at compression level 10 by
// EncodeMesh. Ours must give all triangles back with all attributes, Draco the positions of its triangles (it drops
// degenerate ones).
//
// Prints a line for each mesh, with tabs: name, rows that went in, faces, vertices and rows of the mesh, vertices of
// the base; our bytes, Draco's, and of how many of ours something is drawn; then ours by part: header, connectivity
// of the base, its positions, its other values, flags, indices and rows of splits, their positions, their other
// values, and what is aside. A mesh that cannot be compared is named on standard error, with the reason.
#define CONQUEST_IMPLEMENTATION
#include "files.hpp"
#include "conquest.h"

extern "C" {
#include "mesh_file.h"
}

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using Bytes = std::vector<uint8_t>;

struct Attribute {
    cq_channel channel{};
    std::vector<cq_value> values;
};

struct Asset {
    std::string name;
    std::vector<cq_index> indices;
    std::vector<Attribute> attributes;     // positions first
    size_t rows = 0;
};

// -- Files

Bytes read_file(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::invalid_argument(path + ": cannot read");
    return Bytes(std::istreambuf_iterator<char>(file), {});
}

[[noreturn]] void refuse(const std::string &path, const char *why) { throw std::invalid_argument(path + ": " + why); }

Attribute make_attribute(uint8_t kind, int components, int bits)
{
    Attribute a;
    a.channel.kind = kind;
    a.channel.components = static_cast<uint8_t>(components);
    a.channel.bits = static_cast<uint8_t>(bits);
    return a;
}

Attribute on_grid(const std::string &path, uint8_t kind, int components, int bits, const std::vector<float> &from)
{
    Attribute a = make_attribute(kind, components, bits);
    const size_t count = from.size() / static_cast<size_t>(components);
    a.values.resize(from.size());
    if (cq_fit_grid(&a.channel, from.data(), count, nullptr) != CQ_OK ||
        cq_quantise(&a.channel, from.data(), count, a.values.data(), nullptr) != CQ_OK)
        refuse(path, "no grid holds it");
    return a;
}

Attribute normals(const std::string &path, std::vector<float> from)
{
    Attribute a = make_attribute(CQ_NORMAL, 2, 10);
    a.values.resize(from.size() / 3 * 2);
    for (size_t k = 0; k < from.size(); k += 3)
        if (from[k] == 0 && from[k + 1] == 0 && from[k + 2] == 0) from[k + 2] = 1;
    if (cq_quantise_normals(10, from.data(), from.size() / 3, a.values.data(), nullptr) != CQ_OK)
        refuse(path, "no normals");
    return a;
}

Attribute colors(const std::vector<float> &from, int components)
{
    Attribute a = make_attribute(CQ_COLOR, components, 8);
    for (float x : from) a.values.push_back(static_cast<cq_value>(std::min(std::max(x, 0.0f), 1.0f) * 255 + 0.5f));
    return a;
}

struct File : mesh_file {
    explicit File(const std::string &path)
    {
        char error[MESH_ERROR_BYTES];
        const Bytes bytes = read_file(path);
        if (!mesh_read(this, bytes.data(), bytes.size(), mesh_format_of_path(path.c_str()), error)) refuse(path, error);
    }
    File(const File &) = delete;
    File &operator=(const File &) = delete;
    ~File() { mesh_free(this); }

    std::vector<float> floats(mesh_attribute which) const
    {
        const mesh_values &from = attribute[which];
        return { from.values, from.values + static_cast<size_t>(from.components) * from.count };
    }
};

std::string name_of(const std::string &path) { return path.substr(path.find_last_of('/') + 1); }

Asset load(const std::string &path)
{
    File file(path);
    if (!mesh_expand(&file, 7)) refuse(path, "no memory");
    if (!file.num_faces) refuse(path, "no faces");
    Asset out;
    out.name = name_of(path);
    out.rows = file.num_vertices;
    out.indices.assign(file.indices, file.indices + 3 * size_t{ file.num_faces });
    const std::vector<float> positions(file.positions, file.positions + 3 * out.rows);
    out.attributes.push_back(on_grid(path, CQ_POSITION, 3, 14, positions));
    if (file.attribute[MESH_NORMALS].values) out.attributes.push_back(normals(path, file.floats(MESH_NORMALS)));
    if (file.attribute[MESH_TEXCOORDS].values)
        out.attributes.push_back(on_grid(path, CQ_TEXCOORD, 2, 12, file.floats(MESH_TEXCOORDS)));
    if (file.attribute[MESH_COLORS].values)
        out.attributes.push_back(colors(file.floats(MESH_COLORS), file.attribute[MESH_COLORS].components));
    return out;
}

// -- Triangles with all their values, whichever corner they start at

using Corner = std::vector<cq_value>;
using Triangle = std::array<Corner, 3>;

Triangle smallest_rotation(const Triangle &t)
{
    return std::min({ t, Triangle{ t[1], t[2], t[0] }, Triangle{ t[2], t[0], t[1] } });
}

template <class Row> std::vector<Triangle> triangles(const std::vector<cq_index> &indices, Row &&row)
{
    std::vector<Triangle> out;
    for (size_t h = 0; h < indices.size(); h += 3)
        out.push_back(smallest_rotation({ row(indices[h]), row(indices[h + 1]), row(indices[h + 2]) }));
    std::sort(out.begin(), out.end());
    return out;
}

std::vector<Triangle> triangles(const Asset &asset)
{
    return triangles(asset.indices, [&](size_t v) {
        Corner c;
        for (const Attribute &a : asset.attributes) {
            const cq_value *row = &a.values[a.channel.components * v];
            c.insert(c.end(), row, row + a.channel.components);
        }
        return c;
    });
}

// -- Conquest

cq_input input_of(const Asset &asset)
{
    cq_input in{};
    in.shape.num_vertices = static_cast<uint32_t>(asset.rows);
    in.shape.num_faces = static_cast<uint32_t>(asset.indices.size() / 3);
    in.indices = asset.indices.data();
    for (const Attribute &a : asset.attributes) {
        in.values[in.shape.num_channels] = a.values.data();
        in.shape.channel[in.shape.num_channels++] = a.channel;
    }
    return in;
}

Bytes encode(const Asset &asset)
{
    cq_input in = input_of(asset);
    Bytes out(4096 + 100 * asset.rows + 20 * asset.indices.size());
    size_t size = 0;
    cq_result result = CQ_ERROR_MEMORY;
    for (int tries = 0; result == CQ_ERROR_MEMORY && tries < 3; ++tries) { // then boundaries and rows are known
        std::vector<uint64_t> memory(cq_encoder_bytes(&in.shape) / 8 + 1);
        result = cq_encode(&in, memory.data(), 8 * memory.size(), out.data(), out.size(), &size, nullptr, nullptr);
    }
    if (result != CQ_OK) throw std::runtime_error(std::string("encoding: ") + cq_result_string(result));
    out.resize(size);
    return out;
}

class Decoder {
public:
    explicit Decoder(const Bytes &bytes) : in_{ bytes.data(), bytes.size() }
    {
        cq_shape shape;
        if (cq_peek(bytes.data(), bytes.size(), &shape, nullptr, nullptr) != CQ_OK)
            throw std::runtime_error("no header");
        memory_.resize(cq_decoder_bytes(&shape) / 8 + 1);
        cq_decoder_init(d.get(), memory_.data(), 8 * memory_.size());
        d->report = report.get();
    }
    cq_result run(uint32_t budget) { return cq_decode(d.get(), &in_, budget); }
    cq_result end() { return cq_decode(d.get(), nullptr, CQ_NO_LIMIT); }

    std::unique_ptr<cq_report> report = std::make_unique<cq_report>();
    std::unique_ptr<cq_decoder> d = std::make_unique<cq_decoder>();

private:
    cq_bytes in_;
    std::vector<uint64_t> memory_;
};

std::vector<Triangle> triangles(const cq_decoder &d)
{
    std::vector<cq_index> indices(3 * size_t{ d.mesh.num_faces });
    cq_read_triangles(&d, 0, d.mesh.num_faces, indices.data());
    indices.insert(indices.end(), d.aside.index, d.aside.index + 3 * size_t{ d.aside.num_faces });
    return triangles(indices, [&](cq_index row) {
        Corner c;
        for (uint32_t k = 0; k < d.shape.num_channels; ++k) {
            const size_t n = d.shape.channel[k].components;
            if (d.shape.channel[k].merge == CQ_PER_FACE) continue;
            const size_t end = c.size();
            c.resize(end + n);
            if (row < d.num_rows) cq_read_rows(&d, k, row, 1, &c[end]);
            else std::copy_n(d.aside.channel[k] + n * (row - d.num_rows), n, &c[end]);
        }
        return c;
    });
}

struct Ours {
    uint32_t vertices, rows, base;
    size_t bytes, drawn;
    double part[9];
};

// Of how many bytes something is drawn.
size_t drawn_from(const Bytes &bytes)
{
    size_t low = 0, high = bytes.size();
    while (low < high) {
        const size_t middle = (low + high) / 2;
        Bytes prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(middle));
        cq_shape shape;
        bool drawn = false;
        if (cq_peek(prefix.data(), prefix.size(), &shape, nullptr, nullptr) == CQ_OK) {
            Decoder decoder(prefix);
            decoder.run(CQ_NO_LIMIT);
            decoder.end();
            drawn = decoder.d->mesh.num_faces > 0;
        }
        if (drawn) high = middle;
        else low = middle + 1;
    }
    return low;
}

Ours measure_ours(const Asset &asset)
{
    const Bytes bytes = encode(asset);
    Decoder decoder(bytes);
    cq_result result = CQ_MORE;
    while (result == CQ_MORE && !decoder.d->level) result = decoder.run(1);
    const cq_report base = *decoder.report;
    if (result == CQ_MORE) result = decoder.run(CQ_NO_LIMIT);
    if (result != CQ_DONE) throw std::runtime_error(std::string("decoding: ") + cq_result_string(result));
    if (triangles(asset) != triangles(*decoder.d)) throw std::runtime_error("other triangles came back");
    const cq_report &all = *decoder.report;
    const uint32_t rows = std::max(all.shape.num_rows, all.shape.num_vertices);
    Ours out{ all.shape.num_vertices, rows, all.base_vertices, bytes.size(), drawn_from(bytes), {} };
    const uint64_t part[9] = { all.header, base.base, base.positions, base.channels, all.flags, all.indices,
                               all.positions - base.positions, all.channels - base.channels,
                               all.aside + all.base - base.base };
    std::transform(part, part + 9, out.part, [](uint64_t cost) { return static_cast<double>(cost) / (8 * 65536); });
    return out;
}

// -- Draco

std::vector<float> floats(const Attribute &a)
{
    const size_t n = a.channel.components, count = a.values.size() / n;
    std::vector<float> out(a.channel.kind == CQ_NORMAL ? 3 * count : n * count);
    if (a.channel.kind == CQ_NORMAL) cq_reconstruct_normals(a.channel.bits, a.values.data(), count, out.data());
    else cq_reconstruct(&a.channel, a.values.data(), count, out.data());
    return out;
}

draco::GeometryAttribute::Type draco_type(uint8_t kind)
{
    switch (kind) {
    case CQ_POSITION: return draco::GeometryAttribute::POSITION;
    case CQ_NORMAL: return draco::GeometryAttribute::NORMAL;
    case CQ_TEXCOORD: return draco::GeometryAttribute::TEX_COORD;
    default: return draco::GeometryAttribute::COLOR;
    }
}

template <class T>
void add_attribute(draco::Mesh &mesh, const Attribute &from, const std::vector<T> &values, draco::DataType type)
{
    const auto count = static_cast<uint32_t>(mesh.num_points());
    const size_t n = values.size() / count;
    draco::GeometryAttribute attribute;
    attribute.Init(draco_type(from.channel.kind), nullptr, static_cast<int8_t>(n), type, sizeof(T) == 1,
                   static_cast<int64_t>(n * sizeof(T)), 0);
    const int id = mesh.AddAttribute(attribute, true, count);
    for (uint32_t v = 0; v < count; ++v)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &values[n * v]);
}

std::unique_ptr<draco::Mesh> draco_mesh(const Asset &asset)
{
    auto mesh = std::make_unique<draco::Mesh>();
    mesh->set_num_points(static_cast<uint32_t>(asset.rows));
    for (const Attribute &a : asset.attributes) {
        if (a.channel.kind == CQ_COLOR)
            add_attribute(*mesh, a, Bytes(a.values.begin(), a.values.end()), draco::DT_UINT8);
        else add_attribute(*mesh, a, floats(a), draco::DT_FLOAT32);
    }
    mesh->SetNumFaces(asset.indices.size() / 3);
    for (size_t h = 0; h < asset.indices.size(); h += 3) {
        draco::Mesh::Face face;
        for (size_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(asset.indices[h + k]);
        mesh->SetFace(draco::FaceIndex(static_cast<uint32_t>(h / 3)), face);
    }
    mesh->DeduplicateAttributeValues();
    mesh->DeduplicatePointIds();
    return mesh;
}

std::vector<Triangle> without_degenerate(std::vector<Triangle> all)
{
    const auto degenerate = [](const Triangle &t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; };
    all.erase(std::remove_if(all.begin(), all.end(), degenerate), all.end());
    return all;
}

// By their positions alone.
std::vector<Triangle> triangles(const draco::Mesh &mesh, const cq_channel &grid)
{
    const draco::PointAttribute *from = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    std::vector<cq_index> indices;
    for (uint32_t f = 0; f < mesh.num_faces(); ++f)
        for (const draco::PointIndex &p : mesh.face(draco::FaceIndex(f))) indices.push_back(p.value());
    return triangles(indices, [&](cq_index v) {
        float at[3];
        Corner c(3);
        from->GetMappedValue(draco::PointIndex(v), at);
        cq_quantise(&grid, at, 1, c.data(), nullptr);
        return c;
    });
}

size_t measure_draco(const Asset &asset)
{
    const auto mesh = draco_mesh(asset);
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    encoder.SetSpeedOptions(0, 0);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    for (const Attribute &a : asset.attributes)
        if (a.channel.kind != CQ_COLOR) encoder.SetAttributeQuantization(draco_type(a.channel.kind), a.channel.bits);
    if (!encoder.EncodeMeshToBuffer(*mesh, &buffer).ok()) refuse(asset.name, "Draco does not encode it");
    draco::DecoderBuffer in;
    draco::Decoder decoder;
    in.Init(buffer.data(), buffer.size());
    auto result = decoder.DecodeMeshFromBuffer(&in);
    if (!result.ok()) throw std::runtime_error("Draco does not decode what it encoded");
    Asset positions = asset;
    positions.attributes.resize(1);
    const std::vector<Triangle> back = triangles(*result.value(), asset.attributes[0].channel);
    if (without_degenerate(triangles(positions)) != without_degenerate(back))
        throw std::runtime_error("other positions came back from Draco");
    return buffer.size();
}

// A mesh that several files hold counts once.
bool is_new(const Asset &asset)
{
    static std::set<std::pair<std::vector<cq_index>, std::vector<cq_value>>> seen;
    std::vector<cq_value> values;
    for (const Attribute &a : asset.attributes) values.insert(values.end(), a.values.begin(), a.values.end());
    return seen.emplace(asset.indices, values).second;
}

void compare(const std::string &path)
{
    const Asset asset = load(path);
    if (!is_new(asset)) refuse(path, "the same mesh as in another file");
    const Ours ours = measure_ours(asset);
    const size_t draco = measure_draco(asset);
    std::printf("%s\t%zu\t%zu\t%u\t%u\t%u\t%zu\t%zu\t%zu", asset.name.c_str(), asset.rows, asset.indices.size() / 3,
                ours.vertices, ours.rows, ours.base, ours.bytes, draco, ours.drawn);
    for (double bytes : ours.part) std::printf("\t%.1f", bytes);
    std::printf("\n");
}

} // namespace

// The exit status is 1 if a mesh did not come back; a file that is no mesh is only named.
int main(int argc, char **argv) { return compare_files(argc, argv, compare); }
