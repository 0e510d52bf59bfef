// A stream of a triangulation and what it decodes to. Include conquest.h first.
#ifndef CQ_TESTS_COMPARISON_HPP
#define CQ_TESTS_COMPARISON_HPP

#include "../support/codec.h"
#include "../support/triangles.h"
#include "families.hpp"

struct Tally {
    size_t gates = 0, streams = 0, splits = 0, levels = 0;
};

// A closed triangulation; its vertices from num_real on are cones over boundaries. The first gate is u -> v.
struct Case {
    const Triangulation &t;
    int num_real, euler;
    int u, v;
    bool located;
};

inline std::string name(const Case &c, const char *what)
{
    std::string text = std::string(what) + ": gate " + std::to_string(c.u) + " " + std::to_string(c.v)
                     + (c.located ? ", with positions, faces" : ", faces");
    for (Triangle f : c.t.triangles())
        text += " " + std::to_string(f[0]) + "-" + std::to_string(f[1]) + "-" + std::to_string(f[2]);
    return text;
}

// No two vertices have the same: the low bits of z are the number.
inline std::vector<cq_value> positions(int num_vertices, uint64_t seed)
{
    std::vector<cq_value> values;
    for (int v = 0; v < num_vertices; ++v) {
        values.push_back(static_cast<cq_value>(next_random(&seed) % 1024));
        values.push_back(static_cast<cq_value>(next_random(&seed) % 1024));
        values.push_back(static_cast<cq_value>(next_random(&seed) % 64 * 16 + static_cast<uint64_t>(v)));
    }
    return values;
}

// After each split, from the complete base on, a closed triangulation, one vertex larger.
inline bool decodes_through_surfaces(decoding &d, const coded &coded, const Case &c, Tally &tally)
{
    cq_bytes in = {coded.bytes, coded.size};
    int before = 0;
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        const cq_mesh &m = d.decoder->mesh;
        int now = static_cast<int>(m.num_vertices + m.num_virtual);
        if ((d.decoder->level == 0 && d.result == CQ_MORE) || now == before) continue;
        if (before > 0 && now != before + 1) return false;
        tally.splits += before > 0;
        before = now;
        Triangulation t = triangulation_of(m, identity(now));
        if (t.n != now || !t.is_closed_surface() || t.euler() != c.euler) return false;
    } while (d.result == CQ_MORE);
    return d.result == CQ_DONE && in.size == 0;
}

inline bool is_permutation(const coded &coded)
{
    std::vector<bool> seen(coded.num_vertices);
    for (uint32_t v = 0; v < coded.num_vertices; ++v) {
        if (coded.map[v] >= coded.num_vertices || seen[coded.map[v]]) return false;
        seen[coded.map[v]] = true;
    }
    return true;
}

// Isomorphic through the map; cones have no number of their own, but there is only one.
inline bool is_same(const Case &c, const coded &coded, const decoding &d, const std::vector<cq_value> &values)
{
    std::vector<int> number = identity(c.t.n);
    for (int v = 0; v < c.num_real; ++v) number[coded.map[v]] = v;
    if (!(triangulation_of(d.decoder->mesh, number) == c.t)) return false;
    for (int v = 0; c.located && v < c.num_real; ++v)
        if (std::memcmp(d.decoder->channel[0] + 3 * coded.map[v], &values[3 * size_t(v)], 3 * sizeof(cq_value)) != 0)
            return false;
    return true;
}

inline const char *compare(const Case &c, const coded &coded, const std::vector<cq_value> &values, Tally &tally)
{
    if (coded.result != CQ_OK) return "not encoded";
    if (!is_permutation(coded)) return "the map is no permutation";
    if (coded.map[c.u] != 0 || coded.map[c.v] != 1) return "another first gate";
    decoding d;
    decoding_begin(&d, coded.bytes, coded.size);
    const char *error = nullptr;
    if (!decodes_through_surfaces(d, coded, c, tally)) error = "not decoded through surfaces";
    else if (cq_mesh_check(&d.decoder->mesh, nullptr) != CQ_OK) error = "not valid";
    else if (!is_same(c, coded, d, values)) error = "not the same";
    decoding_free(&d);
    tally.streams++;
    tally.levels += coded.report->num_levels;
    return error;
}

// The input of a case. Its first face is the one on the left of the gate, which the encoder takes for the first one.
class CaseInput {
public:
    cq_input in = {};

    explicit CaseInput(const Case &c, uint64_t seed)
        : indices(index_buffer(c.t, c.num_real, left_face(c))), values(positions(c.num_real, seed)) {
        in.shape.num_vertices = static_cast<uint32_t>(c.num_real);
        in.shape.num_faces = static_cast<uint32_t>(indices.size() / 3);
        in.indices = indices.data();
        in.shape.num_channels = c.located;
        in.shape.channel[0].kind = CQ_POSITION;
        in.shape.channel[0].components = 3;
        in.shape.channel[0].bits = 10;
        in.values[0] = values.data();
    }
    CaseInput(const CaseInput &) = delete;
    CaseInput &operator=(const CaseInput &) = delete;

    const std::vector<cq_value> &located() const { return values; }

private:
    std::vector<cq_index> indices;
    std::vector<cq_value> values;

    static Triangle left_face(const Case &c) {
        int apex = c.t.apex(c.u, c.v);
        return apex < c.num_real ? Triangle{c.u, c.v, apex} : Triangle{-1, -1, -1};
    }
};

#endif
