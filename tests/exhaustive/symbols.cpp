// Every split (i, j) as symbols of a stream: at each vertex of every triangulation of the sphere of up to 10 vertices,
// of the torus of up to 9 and of the disc of up to 8, entered from each of its neighbours. The encoder chooses by a
// rule and writes few of them. Here it is told which edge to collapse: the stream is a base, and one level with this
// split in its first patch, which is reached in all three ways that a first gate allows:
//
//   0  the centre is in front of the gate      1  it is L, and R the last of the ring      2  it is R, and L the first
//
// The stream decodes to the triangulation after the split, vertex by vertex and each position in its place. What was
// run is counted: for each vertex of valence D, D (D - 1) / 2 pairs from D neighbours in each of the three ways, without
// and with positions. With the argument `all`: further sizes, for `make verify`.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "../support/report.hpp"
#include "comparison.hpp"

namespace {

// A split of the vertex a of `before`, whose first gate is L -> R.
struct Symbol {
    int a, p, q;
    int l, r;
};

// -- An encoder that collapses one edge, b into a, and nothing else --------------------------------------------------

// Its first and only patch.
void note_collapse(cqi_plan *plan, const Symbol &s, int b)
{
    cq_mesh *mesh = &plan->mesh;
    cqi_seed *seed = &plan->seed[plan->num_seeds++];
    seed->l = static_cast<cq_index>(s.l);
    seed->r = static_cast<cq_index>(s.r);
    plan->note[plan->num_notes++].level = 0;
    plan->level = plan->num_levels = 1;
    cqi_take_virtual(mesh);
    cq_index gate = cqi_find_spoke(mesh, seed->l, seed->r);
    int side = s.a == s.l ? 1 : s.a == s.r ? 2 : 0;
    cq_index collapsed = find_halfedge(mesh, uint32_t(s.a), uint32_t(b));
    cqi_conquer_patch(plan, cqi_first_spoke(mesh, gate, side), collapsed, 1 + side);
    plan->note[plan->num_notes].level = 0;
    seed->notes = plan->num_notes;
}

// The inside of cq_encode with another simplification.
cq_result encode_collapse(cq_input &in, const Symbol &s, int b, void *memory, size_t size, uint8_t *out,
                          size_t out_size, size_t *stream_size, cq_report *report)
{
    cqi_encoder *e = static_cast<cqi_encoder *>(memory);
    cqi_arena arena = {static_cast<uint8_t *>(memory) + CQI_ENCODER_BYTES, size - CQI_ENCODER_BYTES};
    uint8_t header[CQ_MAX_HEADER_BYTES];
    memset(static_cast<void *>(e), 0, sizeof *e);
    cq_result result = cq_mesh_build(&e->plan.mesh, &in.shape, in.indices, arena.next, arena.left, nullptr);
    if (result != CQ_OK) return result;
    arena.next += cq_mesh_bytes(&in.shape);
    arena.left -= cq_mesh_bytes(&in.shape);
    cqi_encoder_carve(e, &in, &arena);
    size_t gap = cqi_write_header(header, &in.shape, 0, 0);
    cq_range_encoder_init(&e->plan.range, out + gap, out_size - gap);
    memset(report, 0, sizeof *report);
    e->replay.report = report;
    note_collapse(&e->plan, s, b);
    memset(e->plan.decoded, 0xff, cqi_all_vertices(&in.shape) * sizeof(cq_index));
    cqi_replay(e, &in);
    size_t payload_size = cq_range_encoder_finish(&e->plan.range);
    for (cq_index v = 0; v < in.shape.num_vertices; v++) in.map[v] = e->plan.decoded[v];
    return cqi_wrap(&in.shape, out, out_size, gap, payload_size, stream_size);
}

void code_collapse(coded *c, const cq_input &input, const Symbol &s, int b, int num_cones, int cone_degree)
{
    enum { MOST_BYTES = 1000 };
    cq_input in = input;
    memset(c, 0, sizeof *c);
    in.shape.num_boundary_loops = static_cast<uint32_t>(num_cones);
    in.shape.num_boundary_edges = static_cast<uint32_t>(cone_degree);
    c->num_vertices = in.shape.num_vertices;
    in.map = c->map = static_cast<cq_index *>(exact_alloc(in.shape.num_vertices * sizeof(cq_index)));
    c->report = static_cast<cq_report *>(exact_alloc(sizeof(cq_report)));
    c->bytes = static_cast<uint8_t *>(exact_alloc(MOST_BYTES));
    size_t size = cq_encoder_bytes(&in.shape);
    void *memory = exact_alloc(size);
    c->result = encode_collapse(in, s, b, memory, size, c->bytes, MOST_BYTES, &c->size, c->report);
    exact_free(memory);
}

// -- All symbols -----------------------------------------------------------------------------------------------------

// The new vertex comes behind the real ones, before the cones.
Triangulation after_split(const Triangulation &before, int num_real, const Symbol &s)
{
    Triangulation t = before;
    t.split(s.a, s.p, s.q);
    std::vector<int> number = identity(t.n);
    for (int v = num_real; v < before.n; ++v) number[size_t(v)] = v + 1;
    number[size_t(before.n)] = num_real;
    return t.renumbered(number);
}

class Symbols {
public:
    size_t expected = 0;
    Tally tally;

    Symbols(const Triangulation &t, int reals, int e, Report &r) : before(t), num_real(reals), euler(e), report(r) {}

    // All splits of the vertex a.
    void all(int a) {
        std::vector<int> ring = before.ring(a);
        for (size_t k = 0; k < ring.size(); ++k) {
            int l = ring[k], r = ring[(k + ring.size() - 1) % ring.size()];   // the ring from L clockwise ends with R
            if (l < num_real && r < num_real) all_pairs(a, l, l, r);
            if (l < num_real) at_the_gate(a, l);
        }
    }

private:
    const Triangulation &before;
    int num_real, euler;
    Report &report;

    // All pairs of the ring of a from `first` clockwise.
    void all_pairs(int a, int first, int l, int r) {
        std::vector<int> ring = before.ring(a);
        std::rotate(ring.begin(), std::find(ring.begin(), ring.end(), first), ring.end());
        expected += ring.size() * (ring.size() - 1);
        for (size_t p = 0; p < ring.size(); ++p)
            for (size_t q = p + 1; q < ring.size(); ++q) try_both({a, ring[p], ring[q], l, r});
    }

    // The gates a -> w and w -> a.
    void at_the_gate(int a, int w) {
        std::vector<int> ring = before.ring(a);
        size_t next = size_t(std::find(ring.begin(), ring.end(), w) - ring.begin() + 1) % ring.size();
        all_pairs(a, ring[next], a, w);
        all_pairs(a, w, w, a);
    }

    void try_both(const Symbol &s) {
        Triangulation after = after_split(before, num_real, s);
        for (bool located : {false, true}) try_symbol({after, num_real + 1, euler, s.l, s.r, located}, s);
    }

    void try_symbol(const Case &c, const Symbol &s) {
        int num_cones = c.t.n - c.num_real;
        CaseInput input(c, tally.streams);
        coded coded;
        Report::watch();
        code_collapse(&coded, input.in, s, num_real, num_cones, num_cones > 0 ? c.t.degree(c.t.n - 1) : 0);
        const char *error = compare(c, coded, input.located(), tally);
        if (!error && coded.report->level[0].num_splits != 1) error = "not one split";
        if (error)
            report.fail(name(c, error) + " split " + std::to_string(s.a) + " " + std::to_string(s.p) + " "
                        + std::to_string(s.q));
        uncode(&coded);
    }
};

// Returns the number of streams.
size_t run_family(const Family &family, Report &report)
{
    Catalogue all = family.all();
    size_t streams = 0, expected = 0, splits = 0;
    report.expect(all.size() == family.known_count(), std::to_string(all.size()) + " found");
    for (const auto &[code, t] : all) {
        int num_real = t.n - family.is_open();
        Symbols symbols(t, num_real, family.euler(), report);
        for (int a = 0; a < num_real; ++a) symbols.all(a);
        streams += symbols.tally.streams;
        splits += symbols.tally.splits;
        expected += symbols.expected;
    }
    report.expect(expected > 0 && streams == expected && splits == expected, "not all symbols were tried");
    report.end(std::to_string(all.size()) + " " + family.name() + ": " + std::to_string(streams)
               + " streams of one split");
    return streams;
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    bool large = argc > 1 && std::string(argv[1]) == "all";
    size_t streams = 0;
    for (const Family &family : large ? larger_families() : small_families()) streams += run_family(family, report);
    report.end(std::to_string(streams) + " streams of one split in all");
    return report.summary();
}
