// mesh.cpp - the meshes of the bench, from files. SPDX-License-Identifier: MIT
#include "bench.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

extern "C" {
#include "mesh_file.h"
}

namespace {

// The grid that cqm has: from the box's minimum, 2^kBits points along its longest side.
void quantize(const mesh_file &in, Mesh &out)
{
    double low[3] = { 1e300, 1e300, 1e300 }, longest = 0;
    const size_t n = 3 * static_cast<size_t>(in.num_vertices);
    const std::vector<float> at(in.positions, in.positions + n);
    for (size_t i = 0; i < n; ++i) low[i % 3] = std::min<double>(low[i % 3], at[i]);
    for (size_t i = 0; i < n; ++i) longest = std::max(longest, at[i] - low[i % 3]);
    const double scale = longest > 0 ? ((1 << kBits) - 1) / longest : 0;
    out.positions.resize(n);
    for (size_t i = 0; i < n; ++i)
        out.positions[i] = static_cast<int32_t>(std::floor((at[i] - low[i % 3]) * scale + 0.5));
}

Bytes read_file(const std::string &path)
{
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    Bytes bytes(file ? static_cast<size_t>(file.tellg()) : 0);
    file.seekg(0);
    file.read(reinterpret_cast<char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file) throw std::invalid_argument(path + ": cannot read");
    return bytes;
}

} // namespace

Mesh load(const std::string &name, const std::string &path, std::vector<double> *exact)
{
    Mesh out;
    mesh_file mesh;
    char error[MESH_ERROR_BYTES];
    const Bytes bytes = read_file(path);
    if (!mesh_read(&mesh, bytes.data(), bytes.size(), mesh_format_of_path(path.c_str()), error))
        throw std::invalid_argument(path + ": " + error);
    out.name = name;
    out.indices.assign(mesh.indices, mesh.indices + 3 * static_cast<size_t>(mesh.num_faces));
    quantize(mesh, out);
    if (exact) exact->assign(mesh.positions, mesh.positions + 3 * static_cast<size_t>(mesh.num_vertices));
    mesh_free(&mesh);
    return out;
}

Decoded inspect(const Mesh &mesh)
{
    const int32_t *p = mesh.positions.data();
    auto position = [&](size_t v) {
        return position_key(static_cast<uint64_t>(p[3 * v]), static_cast<uint64_t>(p[3 * v + 1]),
                            static_cast<uint64_t>(p[3 * v + 2]));
    };
    Decoded out{ mesh.vertices(), mesh.faces(), 0 };
    for (size_t h = 0; h < mesh.indices.size(); h += 3)
        out.sum += face_sum(position, mesh.indices[h], mesh.indices[h + 1], mesh.indices[h + 2]);
    return out;
}
