// ours.hpp - what the bench asks of conquest beyond a codec. SPDX-License-Identifier: MIT
#pragma once

#include "bench.hpp"

#include <memory>

std::unique_ptr<Codec> make_ours();
std::unique_ptr<Codec> make_draco(int level);    // compression level 0 .. 10, 10 is the smallest
std::unique_ptr<Codec> make_meshopt();
std::unique_ptr<Codec> make_openctm();

// Until the mesh has so many vertices.
struct FirstView {
    double seconds;
    size_t bytes;
};
FirstView first_view(const Bytes &, size_t vertices, double (*seconds)());

// The published formulas: what grows with the mesh, without cq_decoder itself, 10 KB.
size_t encoder_bytes(const Mesh &);
size_t decoder_bytes(const Bytes &);
