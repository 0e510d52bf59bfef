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

#include "../support/report.hpp"
#include "comparison.hpp"

namespace {

void round_trip(const Case &c, Tally &tally, Report &report)
{
    CaseInput input(c, tally.streams);
    coded coded;
    Report::watch();
    code(&coded, &input.in);
    if (const char *error = compare(c, coded, input.located(), tally)) report.fail(name(c, error));
    uncode(&coded);
}

// Each halfedge with a real face on its left.
void all_gates(const Triangulation &t, int num_real, int euler, Tally &tally, Report &report)
{
    for (int u = 0; u < num_real; ++u)
        for (int v = 0; v < num_real; ++v) {
            if (t.apex(u, v) == NO_VERTEX || t.apex(u, v) >= num_real) continue;
            tally.gates++;
            for (bool located : {false, true}) round_trip({t, num_real, euler, u, v, located}, tally, report);
        }
}

size_t num_real_halfedges(const Triangulation &t, int num_real) { return index_buffer(t, num_real).size(); }

// Returns the number of streams.
size_t run_family(const Family &family, Report &report)
{
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
    return tally.streams;
}

void run_families(const std::vector<Family> &families, Report &report)
{
    size_t streams = 0;
    for (const Family &family : families) streams += run_family(family, report);
    report.end(std::to_string(streams) + " streams in all");
}

// -- Counts in a second way -----------------------------------------------------------------------------------------

void search_spheres(int vertices, Report &report)
{
    Catalogue a = spheres(vertices), b = closed_surfaces(vertices, 2);
    report.expect(a.size() == b.size(), std::to_string(b.size()) + " found");
    for (const auto &[code, t] : a) report.expect(b.count(code) == 1, "one is missing");
    report.end("splits and the search give the same spheres of " + std::to_string(vertices) + " vertices");
}

// Splits of the smaller tori and the irreducible ones are all of them.
void split_tori(int vertices, Report &report)
{
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

void shell_discs(int vertices, Report &report)
{
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

void run_small(Report &report)
{
    for (int n = 4; n <= 9; ++n) search_spheres(n, report);
    for (int n = 7; n <= 9; ++n) split_tori(n, report);
    shell_discs(8, report);
    run_families(small_families(), report);
}

void run_large(Report &report)
{
    std::vector<Family> families = larger_families();
    search_spheres(10, report);
    search_spheres(11, report);
    split_tori(10, report);
    shell_discs(10, report);
    add_families(families, Topology::sphere, 12, 12);
    run_families(families, report);
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    if (argc > 1 && std::string(argv[1]) == "all") run_large(report);
    else run_small(report);
    return report.summary();
}
