// Every triangulation of the sphere of up to 10 vertices, of the torus of up to 9 and of the disc of up to 8, with each
// of its halfedges as the first gate, and mirrored: 2 streams of each, without and with positions, that
//
//   - begin with the gate: its ends are the first two vertices of the stream;
//   - decode, split by split, through closed triangulations of the same Euler characteristic;
//   - end in the same triangulation, vertex by vertex through the encoder's map, with each position in its place.
//
// What was run is counted: the known numbers of combinatorial types, each found in two ways where there are two, and
// twice two streams for each of their halfedges. With the argument `all`: further sizes, for `make verify`.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "../support/codec.h"
#include "../support/report.hpp"
#include "../support/triangles.h"
#include "families.hpp"

namespace {

struct Tally {
    size_t gates = 0, streams = 0, splits = 0, levels = 0;
};

// A closed triangulation; its vertices from num_real on are cones over boundaries. u -> v has a real face on the left.
struct Case {
    const Triangulation &t;
    int num_real, euler;
    int u, v;
    bool located;
};

std::string name(const Case &c, const char *what) {
    std::string text = std::string(what) + ": gate " + std::to_string(c.u) + " " + std::to_string(c.v)
                     + (c.located ? ", with positions, faces" : ", faces");
    for (Triangle f : c.t.triangles())
        text += " " + std::to_string(f[0]) + "-" + std::to_string(f[1]) + "-" + std::to_string(f[2]);
    return text;
}

// No two vertices have the same: the low bits of z are the number.
std::vector<cq_value> positions(int num_vertices, uint64_t seed) {
    std::vector<cq_value> values;
    for (int v = 0; v < num_vertices; ++v) {
        values.push_back(static_cast<cq_value>(next_random(&seed) % 1024));
        values.push_back(static_cast<cq_value>(next_random(&seed) % 1024));
        values.push_back(static_cast<cq_value>(next_random(&seed) % 64 * 16 + static_cast<uint64_t>(v)));
    }
    return values;
}

// After each split a closed triangulation, one vertex larger.
bool decodes_through_surfaces(decoding &d, const coded &coded, const Case &c, Tally &tally) {
    cq_bytes in = {coded.bytes, coded.size};
    int before = 0;
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        const cq_mesh &m = d.decoder->mesh;
        int now = static_cast<int>(m.num_vertices + m.num_virtual);
        if (m.num_vertices == 0 || now == before) continue;
        if (before > 0 && now != before + 1) return false;
        tally.splits += before > 0;
        before = now;
        Triangulation t = triangulation_of(m, identity(now));
        if (t.n != now || !t.is_closed_surface() || t.euler() != c.euler) return false;
    } while (d.result == CQ_OK);
    return d.result == CQ_DONE && in.size == 0;
}

bool is_permutation(const coded &coded) {
    std::vector<bool> seen(coded.num_vertices);
    for (uint32_t v = 0; v < coded.num_vertices; ++v) {
        if (coded.map[v] >= coded.num_vertices || seen[coded.map[v]]) return false;
        seen[coded.map[v]] = true;
    }
    return true;
}

// Isomorphic through the map; cones have no number of their own, but there is only one.
bool is_same(const Case &c, const coded &coded, const decoding &d, const std::vector<cq_value> &values) {
    std::vector<int> number = identity(c.t.n);
    for (int v = 0; v < c.num_real; ++v) number[coded.map[v]] = v;
    if (!(triangulation_of(d.decoder->mesh, number) == c.t)) return false;
    for (int v = 0; c.located && v < c.num_real; ++v)
        if (std::memcmp(d.decoder->channel[0] + 3 * coded.map[v], &values[3 * size_t(v)], 3 * sizeof(cq_value)) != 0)
            return false;
    return true;
}

const char *compare(const Case &c, const coded &coded, const std::vector<cq_value> &values, Tally &tally) {
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

void round_trip(const Case &c, Tally &tally, Report &report) {
    std::vector<cq_index> indices = index_buffer(c.t, c.num_real, {c.u, c.v, c.t.apex(c.u, c.v)});
    std::vector<cq_value> values = positions(c.num_real, tally.streams);
    cq_input in = {};
    in.shape.num_vertices = static_cast<uint32_t>(c.num_real);
    in.shape.num_faces = static_cast<uint32_t>(indices.size() / 3);
    in.indices = indices.data();
    in.shape.num_channels = c.located;
    in.shape.channel[0].kind = CQ_POSITION;
    in.shape.channel[0].components = 3;
    in.shape.channel[0].bits = 10;
    in.values[0] = values.data();
    coded coded;
    code(&coded, &in);
    if (const char *error = compare(c, coded, values, tally)) report.fail(name(c, error));
    uncode(&coded);
}

// Each halfedge with a real face on its left.
void all_gates(const Triangulation &t, int num_real, int euler, Tally &tally, Report &report) {
    for (int u = 0; u < num_real; ++u)
        for (int v = 0; v < num_real; ++v) {
            if (t.apex(u, v) == NO_VERTEX || t.apex(u, v) >= num_real) continue;
            tally.gates++;
            for (bool located : {false, true}) round_trip({t, num_real, euler, u, v, located}, tally, report);
        }
}

size_t num_real_halfedges(const Triangulation &t, int num_real) { return index_buffer(t, num_real).size(); }

void run_family(const Family &family, Report &report) {
    Catalogue all = family.all();
    Tally tally;
    size_t gates = 0;
    report.expect(all.size() == family.known_count(), std::to_string(all.size()) + " found");
    report.end(std::to_string(family.known_count()) + " " + family.name());
    for (const auto &[code, t] : all) {
        int num_real = t.n - family.is_open();
        gates += 2 * num_real_halfedges(t, num_real);
        all_gates(t, num_real, family.euler(), tally, report);
        all_gates(t.mirrored(), num_real, family.euler(), tally, report);
    }
    report.expect(gates > 0 && tally.gates == gates && tally.streams == 2 * gates, "not all gates were tried");
    report.expect(family.vertices < 6 || family.topology == Topology::torus || tally.splits > 0, "nothing was split");
    report.end(family.name() + ": " + std::to_string(tally.gates) + " gates, " + std::to_string(tally.streams)
               + " streams, " + std::to_string(tally.levels) + " levels, " + std::to_string(tally.splits) + " splits");
}

// -- Counts in a second way -----------------------------------------------------------------------------------------

void search_spheres(int vertices, Report &report) {
    Catalogue a = spheres(vertices), b = closed_surfaces(vertices, 2);
    report.expect(a.size() == b.size(), std::to_string(b.size()) + " found");
    for (const auto &[code, t] : a) report.expect(b.count(code) == 1, "one is missing");
    report.end("splits and the search give the same spheres of " + std::to_string(vertices) + " vertices");
}

// Splits of the smaller tori and the irreducible ones are all of them.
void split_tori(int vertices, Report &report) {
    Catalogue all = tori(vertices), split = split_all(tori(vertices - 1));
    size_t irreducible = 0;
    for (const auto &[code, t] : all) {
        irreducible += is_irreducible(t);
        report.expect(is_irreducible(t) != (split.count(code) == 1), "a torus is irreducible and split, or neither");
    }
    for (const auto &[code, t] : split) report.expect(all.count(code) == 1, "a split torus is missing");
    report.expect(irreducible == NUM_IRREDUCIBLE_TORI[vertices], std::to_string(irreducible) + " are irreducible");
    report.end(std::to_string(NUM_IRREDUCIBLE_TORI[vertices]) + " tori of " + std::to_string(vertices)
               + " vertices are irreducible, the others are splits of smaller ones");
}

void shell_discs(int vertices, Report &report) {
    Shelling shelling(vertices);
    for (int n = 3; n <= vertices; ++n) {
        Catalogue marked = discs(n);
        const Catalogue &shelled = shelling.found[static_cast<size_t>(n)];
        report.expect(marked.size() == shelled.size(), std::to_string(shelled.size()) + " discs shelled");
        for (const auto &[code, t] : marked) report.expect(shelled.count(code) == 1, "one is missing");
    }
    report.end("spheres with a mark and shelling give the same discs of up to " + std::to_string(vertices)
               + " vertices");
}

void run_small(Report &report) {
    std::vector<Family> families;
    for (int n = 4; n <= 9; ++n) search_spheres(n, report);
    for (int n = 7; n <= 9; ++n) split_tori(n, report);
    shell_discs(8, report);
    add_families(families, Topology::sphere, 4, 10);
    add_families(families, Topology::torus, 7, 9);
    add_families(families, Topology::disc, 3, 8);
    for (const Family &family : families) run_family(family, report);
}

void run_large(Report &report) {
    std::vector<Family> families;
    search_spheres(10, report);
    search_spheres(11, report);
    split_tori(10, report);
    shell_discs(10, report);
    add_families(families, Topology::disc, 9, 9);
    add_families(families, Topology::torus, 10, 10);
    add_families(families, Topology::sphere, 11, 12);
    for (const Family &family : families) run_family(family, report);
}

}  // namespace

int main(int argc, char **argv) {
    Report report;
    if (argc > 1 && std::string(argv[1]) == "all") run_large(report);
    else run_small(report);
    return report.summary();
}
