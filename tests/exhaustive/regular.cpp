// Every regular level of small meshes: for each triangulation of some families as a base, all sets of marks, all
// patterns of the faces and all dissolved edges with the flips around them, as the first level of a stream.
//
// This file is compiled with a copy of the header in which the functions that decode have other names, see
// fuzz/asked.sh. The base is decoded from a stream; then the decoder is asked to go on and each question that it asks
// about the level has both answers, one after the other. After each step the mesh is valid. Beside it, the manual's
// level is made on a plain table of triangles that shares no code with the library: it uses up the same answers, and
//
//   - the decoder's mesh is the same in the end;
//   - or a flip is not possible there: then the decoder ends with CQ_ERROR_CORRUPT, for good, and its mesh is the table
//     as it was before that flip; or marks are too few or too many, then with the base.
//
// Of levels without dissolved edges there are as many as the faces have patterns: 1, 1, 2 and 4 for 0, 1, 2 and 3
// marks; all make other meshes, and none is an error. The shape has room for all new vertices, or for half of them.
//
// What was run is counted. With the argument `all`: more marks, for `make verify`.
#define CQ_TESTS_MOST_VERTICES 32
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include <set>

#include "../support/codec.h"
#include "../support/report.hpp"
#include "families.hpp"

// -- What the decoder asks -------------------------------------------------------------------------------------------

namespace {

enum Question { MARK, DISSOLVE, OTHER };

struct {
    const cq_decoder *decoder = nullptr;   // null: the stream answers
    std::vector<uint8_t> answers;          // of one step; to those beyond its end the answer is 0
    std::vector<Question> questions;
} asked;

int answer(int index)
{
    if (index == CQI_OTHER_LEVEL) return 1;
    if (index < CQI_MARK || index >= CQI_NEW_ALONG) return 0;
    asked.questions.push_back(index < CQI_DISSOLVED ? MARK : index < CQI_SECOND_FLIP ? DISSOLVE : OTHER);
    if (asked.questions.size() > asked.answers.size()) asked.answers.push_back(0);
    return asked.answers[asked.questions.size() - 1];
}

// The next answers of a step in their order; false if these were the last.
bool advance(std::vector<uint8_t> &answers)
{
    while (!answers.empty() && answers.back() == 1) answers.pop_back();
    if (answers.empty()) return false;
    answers.back() = 1;
    return true;
}

}  // namespace

static int cqi_decode_adaptive(cq_range_decoder *d, cq_bit_model *model, int rate)
{
    if (!asked.decoder) return original_decode_adaptive(d, model, rate);
    return answer(static_cast<int>(model - asked.decoder->model.bit));
}
static int cqi_decode_part(cq_range_decoder *d, uint32_t p) { return asked.decoder ? 0 : original_decode_part(d, p); }
uint32_t cq_decode_slot(cq_range_decoder *d, uint32_t total)
{
    return asked.decoder ? 0 : original_decode_slot(d, total);
}
void cq_decode_freq(cq_range_decoder *d, uint32_t start, uint32_t freq, uint32_t total)
{
    if (!asked.decoder) original_decode_freq(d, start, freq, total);
}
uint32_t cq_decode_raw(cq_range_decoder *d, int bits) { return asked.decoder ? 0 : original_decode_raw(d, bits); }

namespace {

// -- A stream that ends with its base --------------------------------------------------------------------------------

// The payload of a mesh whose base is all of it. The inside of cq_encode without a simplification.
std::vector<uint8_t> code_base(const Triangulation &t, int num_real, cq_shape &shape)
{
    enum { MOST_BYTES = 1000 };
    std::vector<cq_index> indices = index_buffer(t, num_real), map(static_cast<size_t>(num_real));
    std::vector<uint8_t> payload(MOST_BYTES);
    cq_input in = {};
    in.shape = shape;
    in.indices = indices.data();
    in.map = map.data();
    size_t size = cq_encoder_bytes(&shape);
    void *memory = exact_alloc(size);
    cqi_encoder *e = static_cast<cqi_encoder *>(memory);
    cqi_arena arena = {static_cast<uint8_t *>(memory) + CQI_ENCODER_BYTES, size - CQI_ENCODER_BYTES};
    memset(memory, 0, sizeof *e);
    if (cq_mesh_build(&e->plan.mesh, &in.shape, in.indices, arena.next, arena.left, nullptr) != CQ_OK) abort();
    arena.next += cq_mesh_bytes(&in.shape);
    arena.left -= cq_mesh_bytes(&in.shape);
    cqi_encoder_carve(e, &in, &arena);
    cq_range_encoder_init(&e->plan.range, payload.data(), payload.size());
    cqi_seed *seed = &e->plan.seed[e->plan.num_seeds++];
    seed->l = indices[0];
    seed->r = indices[1];
    cqi_take_virtual(&e->plan.mesh);
    memset(e->plan.decoded, 0xff, cqi_all_vertices(&in.shape) * sizeof(cq_index));
    cqi_replay(e, &in);
    payload.resize(cq_range_encoder_finish(&e->plan.range));
    exact_free(memory);
    return payload;
}

std::vector<uint8_t> wrapped(const std::vector<uint8_t> &payload, const cq_shape &shape)
{
    std::vector<uint8_t> stream(CQ_MAX_HEADER_BYTES);
    stream.resize(cqi_write_header(stream.data(), &shape, payload.size(), cqi_crc32(0, payload.data(), payload.size())));
    stream.insert(stream.end(), payload.begin(), payload.end());
    return stream;
}

// -- The manual's level on a table -----------------------------------------------------------------------------------

using Edge = std::array<int, 2>;

// The coarse mesh: its triangles in the order of their numbers, as they are stored.
struct Coarse {
    int num_real = 0, num_cones = 0;
    std::vector<Triangle> faces;
    Triangulation table;

    // The place of the face with the directed edge; -1: none.
    int face_of(int a, int b) const {
        for (size_t f = 0; f < faces.size(); ++f)
            for (size_t k = 0; k < 3; ++k)
                if (faces[f][k] == a && faces[f][(k + 1) % 3] == b) return int(f);
        return -1;
    }
};

// What is to be answered, in order.
struct Answers {
    std::vector<uint8_t> marks, dissolves, flips;
    size_t of_marks = 0, of_dissolves = 0, of_flips = 0;   // used up
    bool missing = false;

    int mark() { return take(marks, of_marks); }
    int dissolve() { return take(dissolves, of_dissolves); }
    int flip() { return take(flips, of_flips); }
    bool are_used_up() const {
        return !missing && of_marks == marks.size() && of_dissolves == dissolves.size() && of_flips == flips.size();
    }

private:
    int take(const std::vector<uint8_t> &from, size_t &at) {
        missing = missing || at == from.size();
        return missing ? 0 : from[at++];
    }
};

class ManualLevel {
public:
    Triangulation table;
    bool failed = false;      // a flip is not possible
    Answers answers;

    // Cones get the numbers behind the last new vertex.
    ManualLevel(const Coarse &c, const Answers &a, int count) : answers(a), coarse(c), old(c.num_real) {
        std::vector<int> number = identity(c.table.n);
        for (int v = old; v < c.table.n; ++v) number[size_t(v)] = v + count;
        reals = old + count;
        table = Triangulation(c.table.n + count);
        for (Triangle f : c.table.triangles())
            table.put(number[size_t(f[0])], number[size_t(f[1])], number[size_t(f[2])]);
        read_marks();
        for (size_t f = 0; f < c.faces.size(); ++f) {
            read_pattern(f);
            read_dissolves(f);
        }
        for (size_t f = 0; f < c.faces.size() && !failed; ++f) sweep(f);
    }

private:
    const Coarse &coarse;
    int old, reals;
    std::map<Edge, int> on;                          // new vertices, by both directed edges
    std::map<size_t, std::vector<Edge>> inserted;    // by the face that inserts
    std::map<size_t, int> flipped;                   // of a face with two marks: the diagonal
    std::map<size_t, size_t> fan;                    // of one with three, if it has a fan: the side of its hub
    std::set<size_t> used;                           // faces that have a dissolved edge
    std::map<size_t, Edge> dissolved;                // by the later of the two faces

    template <typename Visit>
    void for_each_edge(size_t f, Visit visit) {
        for (size_t k = 0; k < 3; ++k) {
            int a = coarse.faces[f][k], b = coarse.faces[f][(k + 1) % 3], other = coarse.face_of(b, a);
            if (other < 0 || size_t(other) > f) visit(other, a, b);
        }
    }

    void read_marks() {
        int next = old;
        for (size_t f = 0; f < coarse.faces.size(); ++f)
            for_each_edge(f, [&](int, int a, int b) {
                if (!answers.mark()) return;
                on[{a, b}] = on[{b, a}] = next++;
                inserted[f].push_back({a, b});
            });
    }

    std::vector<int> marked_of(size_t f) const {
        std::vector<int> list;
        for (size_t k = 0; k < 3; ++k)
            if (auto v = on.find({coarse.faces[f][k], coarse.faces[f][(k + 1) % 3]}); v != on.end())
                list.push_back(v->second);
        return list;
    }

    // Without positions, a fan is asked for around the sides in their order.
    void read_pattern(size_t f) {
        const size_t marks = marked_of(f).size();
        if (marks == 2) flipped[f] = answers.flip();
        if (marks < 3 || answers.flip()) return;
        fan[f] = answers.flip() ? 0 : answers.flip() ? 1 : 2;
    }

    void read_dissolves(size_t f) {
        for_each_edge(f, [&](int other, int a, int b) {
            if (other < 0 || on.count({a, b}) || used.count(f) || used.count(size_t(other))) return;
            if (marked_of(f).empty() && marked_of(size_t(other)).empty()) return;
            if (!answers.dissolve()) return;
            dissolved[size_t(other)] = {a, b};
            used.insert(size_t(other));
            if (!marked_of(f).empty()) used.insert(f);
        });
    }

    void insert(int a, int b, int v) {
        int p = table.apex(a, b), q = table.apex(b, a);
        table.remove(a, b, p), table.remove(b, a, q);
        table.put(a, v, p), table.put(v, b, p), table.put(v, a, q), table.put(b, v, q);
    }

    bool can_flip(int a, int b) const {
        int x = table.apex(a, b), y = table.apex(b, a);
        return std::max({a, b, x, y}) < reals && x != y && !table.has_edge(x, y)
            && table.degree(a) >= 4 && table.degree(b) >= 4;
    }

    void flip(int a, int b) {
        if (failed || !can_flip(a, b)) {
            failed = true;
            return;
        }
        int x = table.apex(a, b), y = table.apex(b, a);
        table.remove(a, b, x), table.remove(b, a, y);
        table.put(y, x, a), table.put(x, y, b);
    }

    void sweep(size_t f) {
        for (Edge e : inserted[f]) insert(e[0], e[1], on[e]);
        std::vector<int> marked = marked_of(f);
        if (marked.size() >= 2) patterns(f, *std::min_element(marked.begin(), marked.end()), marked.size());
        if (!failed && dissolved.count(f)) dissolve(f, dissolved[f]);
    }

    void patterns(size_t f, int hub, size_t marks) {
        int o = -1;
        for (size_t k = 0; k < 3; ++k)
            if (on_side(f, k) == hub) o = coarse.faces[f][(k + 2) % 3];
        if (marks == 2) {
            if (flipped[f]) flip(hub, o);
            return;
        }
        int m1 = table.apex(o, hub), m2 = table.apex(hub, o);
        if (!fan.count(f)) return flip(hub, o);
        int wanted = on_side(f, fan[f]);
        if (wanted == hub) return;
        flip(hub, o);
        flip(hub, wanted == m1 ? m2 : m1);
    }

    // The new vertex on a side, or -1.
    int on_side(size_t f, size_t k) const {
        auto side = on.find({coarse.faces[f][k], coarse.faces[f][(k + 1) % 3]});
        return side == on.end() ? -1 : side->second;
    }

    // In a face with one mark: from its new vertex to the opposite corner; else none.
    std::vector<Edge> inner_of(size_t f) const {
        std::vector<Edge> list;
        for (size_t k = 0; k < 3 && marked_of(f).size() == 1; ++k)
            if (auto v = on.find({coarse.faces[f][k], coarse.faces[f][(k + 1) % 3]}); v != on.end())
                list.push_back({v->second, coarse.faces[f][(k + 2) % 3]});
        return list;
    }

    void dissolve(size_t f, Edge e) {
        const int x = table.apex(e[0], e[1]), y = table.apex(e[1], e[0]);
        std::vector<Edge> flips = {e};
        for (auto [face, beyond] : {std::pair(size_t(coarse.face_of(e[0], e[1])), y), std::pair(f, x)})
            for (Edge inner : inner_of(face))
                if (beyond >= old && answers.flip()) flips.push_back(inner);
        for (Edge g : flips) flip(g[0], g[1]);
    }
};

// -- All levels of one base ------------------------------------------------------------------------------------------

struct Tally {
    size_t bases = 0, marks = 0, levels = 0, plain = 0, room = 0, flips = 0, steps = 0;
    void add(const Tally &t) {
        bases += t.bases, marks += t.marks, levels += t.levels, plain += t.plain, room += t.room, flips += t.flips;
        steps += t.steps;
    }
};

// What a decoder is, but for its models, which do not learn here.
struct Snapshot {
    std::vector<uint8_t> before, behind, memory;
};

class Levels {
public:
    Tally tally;

    // Levels with more marks or dissolved edges are left out.
    Levels(const Triangulation &t, int reals, size_t marks, size_t dissolved, bool half, Report &r)
        : most_marks(marks), most_dissolved(dissolved), report(r) {
        coarse.num_real = reals;
        int num_cones = coarse.num_cones = t.n - reals;
        cq_shape shape = {};
        size_t rim = num_cones > 0 ? static_cast<size_t>(t.degree(t.n - 1)) : 0;
        shape.num_vertices = static_cast<uint32_t>(reals);
        shape.num_faces = static_cast<uint32_t>(t.triangles().size() - rim);
        shape.num_boundary_loops = static_cast<uint32_t>(num_cones);
        shape.num_boundary_edges = static_cast<uint32_t>(rim);
        shape.regular = 1;
        num_edges = (3 * shape.num_faces + rim) / 2;
        std::vector<uint8_t> payload = code_base(t, reals, shape);
        room = half ? (num_edges - rim) / 2 : num_edges;
        shape.num_vertices += static_cast<uint32_t>(room);
        shape.num_boundary_edges += static_cast<uint32_t>(half ? 0 : rim);
        shape.num_faces += static_cast<uint32_t>(half ? 2 * room : 2 * room - rim);
        stream = wrapped(payload, shape);
        decoding_begin(&d, stream.data(), stream.size());
    }
    Levels(const Levels &) = delete;
    Levels &operator=(const Levels &) = delete;
    ~Levels() {
        asked.decoder = nullptr;
        decoding_free(&d);
    }

    void all() {
        cq_bytes in = {stream.data(), stream.size()};
        const cq_decoder &decoder = *d.decoder;
        while (decoder.phase != CQI_LEVEL)
            if (cq_decode(d.decoder, &in, 1) != CQ_MORE) return report.fail("no base");
        read_coarse();
        asked.decoder = d.decoder;
        explore(0);
        tally.bases++;
        report.expect(tally.levels > 0, "no level");
    }

private:
    Coarse coarse;
    size_t most_marks, most_dissolved, num_edges = 0, room = 0;
    Report &report;
    std::vector<uint8_t> stream;
    decoding d = {};
    std::vector<Snapshot> snapshots;

    // The path that has been taken.
    Answers path;
    size_t count = 0;                           // of edges that are marked
    std::set<std::vector<Triangle>> finals;     // with these marks, no edge dissolved

    void read_coarse() {
        const cq_mesh &m = d.decoder->mesh;
        coarse.table = triangulation_of(m, identity(coarse.num_real + coarse.num_cones));
        for (uint32_t h = 0; h < 3u * m.num_faces; h += 3)
            coarse.faces.push_back({int(m.origin[h]), int(m.origin[h + 1]), int(m.origin[h + 2])});
    }

    void save(Snapshot &s) const {
        const uint8_t *from = reinterpret_cast<const uint8_t *>(d.decoder);
        const uint8_t *memory = static_cast<const uint8_t *>(d.memory);
        s.before.assign(from, from + offsetof(cq_decoder, model));
        s.memory.assign(memory, memory + d.memory_size);
    }
    void restore(const Snapshot &s) {
        memcpy(static_cast<void *>(d.decoder), s.before.data(), s.before.size());
        memcpy(d.memory, s.memory.data(), s.memory.size());
    }

    // All that may follow.
    void explore(size_t depth) {
        const Answers before = path;
        const size_t count_before = count;
        std::vector<uint8_t> answers;
        if (snapshots.size() <= depth) snapshots.resize(depth + 1);
        save(snapshots[depth]);
        do {
            asked.answers = answers;
            asked.questions.clear();
            const int phase = d.decoder->phase;
            cq_bytes in = {nullptr, 0};
            cq_result result = cq_decode(d.decoder, &in, 1);
            tally.steps++;
            answers = asked.answers;
            note(answers);
            follow(depth, phase, result);
            restore(snapshots[depth]);
            path = before;
            count = count_before;
        } while (advance(answers));
    }

    void note(const std::vector<uint8_t> &answers) {
        for (size_t k = 0; k < asked.questions.size(); ++k) {
            const Question q = asked.questions[k];
            (q == MARK ? path.marks : q == DISSOLVE ? path.dissolves : path.flips).push_back(answers[k]);
            count += q == MARK && answers[k];
        }
    }

    void follow(size_t depth, int phase, cq_result result) {
        if ((count > most_marks || num_dissolved() > most_dissolved) && result == CQ_MORE) return;
        if (!report.expect(cq_mesh_check(&d.decoder->mesh, nullptr) == CQ_OK, "not valid")) return;
        if (result != CQ_MORE) return end_in_error(result);
        if (d.decoder->phase == CQI_LEVEL) return end_level();
        const bool all_marks = phase == CQI_MARKS && d.decoder->phase == CQI_TABLE;
        if (all_marks) finals.clear();
        explore(depth + 1);
        if (!all_marks) return;
        tally.marks++;
        report.expect(finals.size() == num_patterns(), "not all patterns of these marks");
    }

    // Half a shape has no room for marks of the boundary.
    bool fits() const {
        size_t k = 0;
        bool inner = true;
        for (size_t f = 0; f < coarse.faces.size(); ++f)
            for (size_t c = 0; c < 3; ++c) {
                int other = coarse.face_of(coarse.faces[f][(c + 1) % 3], coarse.faces[f][c]);
                if (other >= 0 && size_t(other) < f) continue;
                if (k < path.marks.size() && path.marks[k] && other < 0) inner = false;
                k++;
            }
        return count <= room && (inner || room == num_edges);
    }

    size_t num_patterns() const {
        if (!fits()) return 0;
        size_t n = 1, k = 0;
        std::vector<int> marks(coarse.faces.size());
        for (size_t f = 0; f < coarse.faces.size(); ++f)
            for (size_t c = 0; c < 3; ++c) {
                int other = coarse.face_of(coarse.faces[f][(c + 1) % 3], coarse.faces[f][c]);
                if ((other >= 0 && size_t(other) < f) || !path.marks[k++]) continue;
                marks[f]++;
                if (other >= 0) marks[size_t(other)]++;
            }
        for (int of_face : marks) n *= of_face == 3 ? 4 : of_face == 2 ? 2 : 1;
        return n;
    }

    size_t num_dissolved() const {
        return size_t(std::count(path.dissolves.begin(), path.dissolves.end(), 1));
    }
    bool is_plain() const { return num_dissolved() == 0; }

    // The decoder's triangles; cones behind all new vertices, also those that are not there yet.
    Triangulation decoded() const {
        const cq_mesh &m = d.decoder->mesh;
        std::vector<int> number = identity(int(m.num_vertices));
        for (int v = 0; v < coarse.num_cones; ++v) number.push_back(coarse.num_real + int(count) + v);
        number.resize(size_t(coarse.num_real + int(count) + coarse.num_cones));
        return triangulation_of(m, number);
    }

    bool is_closed() const {
        const cq_mesh &m = d.decoder->mesh;
        return triangulation_of(m, identity(int(m.num_vertices) + coarse.num_cones)).is_closed_surface();
    }

    // What has failed, and for which answers.
    void expect(bool condition, const char *what) {
        if (condition) return;
        std::string text = std::string(what) + ": marks";
        auto add = [&](const std::vector<uint8_t> &list) {
            for (int k : list) text += " " + std::to_string(k);
        };
        add(path.marks), text += "; dissolved", add(path.dissolves), text += "; flips", add(path.flips);
        text += "; faces";
        for (Triangle f : coarse.faces)
            text += " " + std::to_string(f[0]) + "-" + std::to_string(f[1]) + "-" + std::to_string(f[2]);
        report.fail(text);
    }

    void end_in_error(cq_result result) {
        cq_bytes in = {nullptr, 0};
        expect(result == CQ_ERROR_CORRUPT, "another error");
        expect(cq_decode(d.decoder, &in, 1) == result, "not permanent");
        if (count == 0 || !fits()) {
            tally.room++;
            return expect(is_closed(), "not closed before an error");
        }
        ManualLevel level(coarse, path, int(count));
        tally.flips++;
        expect(level.failed && !is_plain(), "an error without a reason");
        expect(level.answers.are_used_up(), "other questions before an error");
        expect(decoded() == level.table, "another mesh than before the error");
    }

    void end_level() {
        ManualLevel level(coarse, path, int(count));
        tally.levels++;
        Triangulation t = decoded();
        expect(!level.failed && fits(), "no error");
        expect(level.answers.are_used_up(), "other questions");
        expect(t == level.table && int(d.decoder->mesh.num_vertices) == coarse.num_real + int(count),
                      "another mesh");
        if (!is_plain()) return;
        tally.plain++;
        expect(finals.insert(t.triangles()).second, "the same mesh again");
    }
};

// -- Families --------------------------------------------------------------------------------------------------------

constexpr size_t ALL = SIZE_MAX;

struct Bound {
    Family family;
    size_t most_marks, most_dissolved;   // of a level
};

void run_family(const Bound &bound, Report &report)
{
    const Family &family = bound.family;
    Catalogue bases = family.all();
    Tally tally;
    report.expect(bases.size() == family.known_count(), std::to_string(bases.size()) + " found");
    for (const auto &[code, t] : bases)
        for (bool half : {false, true}) {
            int num_real = t.n - family.is_open();
            if (half && num_real < 5 && family.is_open()) continue;   // no two edges inside
            Report::watch();
            Levels levels(t, num_real, bound.most_marks, bound.most_dissolved, half, report);
            levels.all();
            tally.add(levels.tally);
        }
    report.expect(tally.bases >= bases.size() && tally.plain > 0 && tally.room > 0, "something did not occur");
    auto bounded = [](size_t most, const char *what) {
        return most == ALL ? std::string() : ", at most " + std::to_string(most) + what;
    };
    report.end(std::to_string(bases.size()) + " " + family.name() + bounded(bound.most_marks, " marks")
               + bounded(bound.most_dissolved, " dissolved edges") + ": " + std::to_string(tally.marks)
               + " sets of marks, " + std::to_string(tally.levels) + " levels, "
               + std::to_string(tally.levels - tally.plain) + " of them with dissolved edges, "
               + std::to_string(tally.room) + " errors by marks, " + std::to_string(tally.flips) + " by flips, "
               + std::to_string(tally.steps) + " steps");
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    const bool large = argc > 1 && std::string(argv[1]) == "all";
    std::vector<Bound> bounds = {
        {{Topology::disc, 3}, ALL, ALL}, {{Topology::disc, 4}, ALL, ALL}, {{Topology::disc, 5}, 5, ALL},
        {{Topology::disc, 5}, ALL, 0},   {{Topology::disc, 6}, 2, ALL},   {{Topology::sphere, 4}, ALL, ALL},
        {{Topology::sphere, 5}, 4, ALL}, {{Topology::sphere, 5}, ALL, 0}, {{Topology::sphere, 6}, 3, ALL},
        {{Topology::sphere, 6}, 5, 0}, {{Topology::torus, 7}, 2, ALL},
    };
    if (large)
        bounds = {{{Topology::disc, 5}, ALL, ALL},
                  {{Topology::disc, 6}, 4, ALL},
                  {{Topology::sphere, 5}, 6, ALL},
                  {{Topology::sphere, 6}, 4, ALL},
                  {{Topology::torus, 7}, 3, ALL}};
    for (const Bound &bound : bounds) run_family(bound, report);
    return report.summary();
}
