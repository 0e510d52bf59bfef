// peers.cpp - bytes of mesh files, ours and Draco's. SPDX-License-Identifier: MIT
//
//     peers MESH_FILE...
//
// Both code the same 12-bit whole numbers: we with the defaults of cq_input, libdraco at compression level 10. Both must
// give all triangles back. Prints a line for each mesh, with tabs: name, vertices, faces; percentages of vertices of
// valence 6, of edges that are flat (less than 1 degree between their faces), and sharp (over 30); then for each codec the bits
// in all and those of positions. Draco's positions are what its file is longer than that of the mesh with all positions
// 0. A mesh that cannot be compared is named on standard error, with the reason.
#define CONQUEST_IMPLEMENTATION
#include "files.hpp"
#include "../bench/ours.hpp"

#include "conquest.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <stdexcept>
#include <tuple>

namespace {

struct Bits {
    double all, positions;
};

// -- Conquest

Decoded decode_ours(const Bytes &bytes)
{
    Mesh out;
    cq_shape shape;
    cq_bytes in = { bytes.data(), bytes.size() };
    if (cq_peek(bytes.data(), bytes.size(), &shape, nullptr, nullptr) != CQ_OK) throw std::runtime_error("no header");
    std::vector<uint64_t> memory(cq_decoder_bytes(&shape) / 8 + 1);
    auto d = std::make_unique<cq_decoder>();
    cq_decoder_init(d.get(), memory.data(), 8 * memory.size());
    cq_result result = cq_decode(d.get(), &in, CQ_NO_LIMIT);
    if (result != CQ_DONE) throw std::runtime_error(std::string("decoding: ") + cq_result_string(result));
    out.indices.resize(3 * size_t{ d->mesh.num_faces });
    cq_read_triangles(d.get(), 0, d->mesh.num_faces, out.indices.data());
    out.indices.insert(out.indices.end(), d->aside.index, d->aside.index + 3 * size_t{ d->aside.num_faces });
    out.positions.assign(d->channel[0], d->channel[0] + 3 * size_t{ d->mesh.num_vertices });
    const cq_value *aside = d->aside.channel[0];
    if (d->aside.num_rows) out.positions.insert(out.positions.end(), aside, aside + 3 * size_t{ d->aside.num_rows });
    return inspect(out);
}

cq_input input_of(const Mesh &mesh)
{
    cq_input in{};
    in.shape.num_vertices = static_cast<uint32_t>(mesh.vertices());
    in.shape.num_faces = static_cast<uint32_t>(mesh.faces());
    in.shape.num_channels = 1;
    in.shape.channel[0].kind = CQ_POSITION;
    in.shape.channel[0].components = 3;
    in.shape.channel[0].bits = kBits;
    in.indices = mesh.indices.data();
    in.values[0] = mesh.positions.data();
    return in;
}

Bytes encode_ours(const Mesh &mesh, cq_report &report)
{
    cq_input in = input_of(mesh);
    Bytes out(4096 + 64 * mesh.vertices());
    size_t size = 0;
    cq_result result = CQ_ERROR_MEMORY;
    for (int tries = 0; result == CQ_ERROR_MEMORY && tries < 2; ++tries) { // the second time boundaries are known
        std::vector<uint64_t> memory(cq_encoder_bytes(&in.shape) / 8 + 1);
        result = cq_encode(&in, memory.data(), 8 * memory.size(), out.data(), out.size(), &size, nullptr, &report);
    }
    if (result != CQ_OK) throw std::invalid_argument(mesh.name + ": " + cq_result_string(result));
    out.resize(size);
    return out;
}

Bits measure_ours(const Mesh &mesh)
{
    auto report = std::make_unique<cq_report>();
    const Bytes bytes = encode_ours(mesh, *report);
    const Decoded in = inspect(mesh), out = decode_ours(bytes);
    if (std::tie(in.faces, in.sum) != std::tie(out.faces, out.sum)) // vertices may have been joined or copied
        throw std::runtime_error("other triangles came back");
    return { 8.0 * static_cast<double>(bytes.size()), static_cast<double>(report->positions) / 65536 };
}

// -- Draco

Bits measure_draco(Mesh mesh)
{
    auto draco = make_draco(10);
    const Bytes bytes = draco->encode(mesh);
    draco->decode(bytes);
    const Decoded in = inspect(mesh), out = draco->inspect();
    if (std::tie(in.faces, in.sum) != std::tie(out.faces, out.sum))
        throw std::runtime_error("another mesh came back from Draco");
    std::fill(mesh.positions.begin(), mesh.positions.end(), 0);
    const size_t connectivity = draco->encode(mesh).size();
    return { 8.0 * static_cast<double>(bytes.size()),
             8.0 * (static_cast<double>(bytes.size()) - static_cast<double>(connectivity)) };
}

// -- What kind of mesh it is, in per cent

double share_of_valence_6(const Mesh &mesh)
{
    std::vector<int> faces(mesh.vertices());
    for (uint32_t v : mesh.indices) ++faces[v];
    return 100.0 * static_cast<double>(std::count(faces.begin(), faces.end(), 6)) / static_cast<double>(faces.size());
}

struct Vector {
    double x, y, z;
};

double dot(const Vector &a, const Vector &b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross(const Vector &a, const Vector &b)
{
    return { a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

Vector normal(const uint32_t *face, const std::vector<double> &at)
{
    auto side = [&](int k) -> Vector {
        const double *a = &at[3 * size_t{ face[0] }], *b = &at[3 * size_t{ face[k] }];
        return { b[0] - a[0], b[1] - a[1], b[2] - a[2] };
    };
    return cross(side(1), side(2));
}

struct Angles {
    double flat, sharp;
};

// Between the faces of each edge; a face without area has no angle.
Angles angles(const Mesh &mesh, const std::vector<double> &at)
{
    std::vector<std::tuple<uint32_t, uint32_t, size_t>> edges;
    for (size_t h = 0; h < mesh.indices.size(); ++h) {
        const uint32_t a = mesh.indices[h], b = mesh.indices[h % 3 == 2 ? h - 2 : h + 1];
        edges.emplace_back(std::min(a, b), std::max(a, b), h / 3);
    }
    std::sort(edges.begin(), edges.end());
    size_t all = 0, flat = 0, sharp = 0;
    for (size_t k = 1; k < edges.size(); ++k) {
        const auto &[a, b, f] = edges[k - 1];
        const auto &[c, d, g] = edges[k];
        if (a != c || b != d) continue;
        const Vector m = normal(&mesh.indices[3 * f], at), n = normal(&mesh.indices[3 * g], at);
        const double size = std::sqrt(dot(m, m) * dot(n, n)), sine = std::sqrt(dot(cross(m, n), cross(m, n)));
        if (!(size > 0)) continue;
        const double degrees = std::atan2(sine, dot(m, n)) * 180 / std::acos(-1.0);
        ++all;
        flat += degrees < 1;
        sharp += degrees > 30;
    }
    const double scale = all ? 100 / static_cast<double>(all) : 0;
    return { scale * static_cast<double>(flat), scale * static_cast<double>(sharp) };
}

std::string name_of(const std::string &path) { return path.substr(path.find_last_of('/') + 1); }

// A mesh that several files hold counts once.
bool is_new(const Mesh &mesh)
{
    static std::set<std::tuple<size_t, size_t, uint64_t>> seen;
    const Decoded d = inspect(mesh);
    return seen.emplace(d.vertices, d.faces, d.sum).second;
}

void compare(const std::string &path)
{
    std::vector<double> exact;
    const Mesh mesh = load(name_of(path), path, &exact);
    if (mesh.faces() == 0) throw std::invalid_argument(path + ": no faces");
    if (!is_new(mesh)) throw std::invalid_argument(path + ": the same mesh as in another file");
    const Bits ours = measure_ours(mesh), draco = measure_draco(mesh);
    const Angles a = angles(mesh, exact);
    std::printf("%s\t%zu\t%zu\t%.2f\t%.2f\t%.2f\t%.0f\t%.0f\t%.0f\t%.0f\n", mesh.name.c_str(), mesh.vertices(),
                mesh.faces(), share_of_valence_6(mesh), a.flat, a.sharp, ours.all, ours.positions, draco.all,
                draco.positions);
}

} // namespace

// The exit status is 1 if a mesh did not come back; a file that is no mesh, or no manifold, is only named.
int main(int argc, char **argv) { return compare_files(argc, argv, compare); }
