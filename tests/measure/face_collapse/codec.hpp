// codec.hpp - encoder and decoder of the connectivity. SPDX-License-Identifier: MIT
//
// The encoder simplifies first. Then it refines again by the routine of the decoder, with a coder that writes. The base
// mesh is handed over as it is.
#ifndef FACE_COLLAPSE_CODEC_HPP
#define FACE_COLLAPSE_CODEC_HPP

#include "coder.hpp"
#include "conquest.hpp"

// Contexts: for the flags, the valence of the centre. An end is found by asking vertices of the ring one by one: for
// each answer, the valence of the vertex that is asked and how many are left.
struct Model {
    enum { VALENCES = 16 };
    Context flag[2][VALENCES], end[MAX_RUN][MAX_ENDS][VALENCES][VALENCES];

    static size_t cap(size_t n) { return std::min<size_t>(n, VALENCES - 1); }
};

// Codes the flags and ends of one patch: those in `run` are written, or others are read into it. The ends are told by
// indices as in the paper: i clockwise from L to the first, j counter-clockwise from R to the last, k clockwise from
// the first to the middle one.
template <class Coder>
class PatchCoder {
public:
    PatchCoder(Coder &c, Model &m, const Mesh &fine, const Ring &r) : coder(c), model(m), mesh(fine), ring(r) {}

    void code(Vertex a, Kind kind, Run &run) {
        code_size(Model::cap(mesh.valence(a)), kind, run);
        if (run.size == 0) return;
        size_t last = ring.size() - 1, s = run.size;
        size_t i = steps(s, 0, run.ends[0], last - 1, [](size_t n) { return n; });
        size_t j = steps(s, 1, last - run.ends[s], last - 1 - i, [last](size_t n) { return last - n; });
        size_t k = 0;
        if (s == 2) k = steps(s, 2, run.ends[1] - i, last - j - i, [i](size_t n) { return i + n; });
        run.ends[0] = i;
        run.ends[1] = i + k;
        run.ends[s] = last - j;
    }

private:
    Coder &coder;
    Model &model;
    const Mesh &mesh;
    const Ring &ring;

    void code_size(size_t valence, Kind kind, Run &run) {
        bool is_split = coder.bit(run.size > 0, model.flag[0][valence]), is_face = kind == Kind::FACE;
        if (is_split && kind == Kind::MIXED) is_face = coder.bit(run.size == 2, model.flag[1][valence]);
        run.size = !is_split ? 0 : is_face ? 2 : 1;
    }

    template <class At>
    size_t steps(size_t size, size_t index, size_t wanted, size_t most, At at) {
        size_t n = 0;
        auto &contexts = model.end[size - 1][index];
        while (n < most) {
            Vertex v = ring[at(n)];
            if (coder.bit(n == wanted, contexts[Model::cap(mesh.valence(v))][Model::cap(most - n)])) break;
            ++n;
        }
        return n;
    }
};

// What the decoder is given.
struct Stream {
    Mesh base;
    std::vector<Gate> first;
    size_t num_levels = 0;
    Kind kind = Kind::FACE;
    std::vector<uint8_t> bytes;
};

// Refines by all levels. next_run(level) is asked for each patch: a reader ignores the answer. Calls done(level).
template <class Coder, class Next, class Done>
void refine(Mesh &mesh, const Stream &stream, Coder &coder, Next next_run, Done done)
{
    Model model;
    for (size_t level = stream.num_levels; level-- > 0;) {
        conquer(mesh, stream.first, level % 2 != 0, [&](Vertex a, const Ring &ring, const std::vector<State> &) {
            Run run = next_run(level);
            PatchCoder<Coder>(coder, model, mesh, ring).code(a, stream.kind, run);
            if (run.size > 0) mesh.split(a, ring, run);
            return ring;
        });
        done(level);
    }
}

// Calls done(mesh) after each level.
template <class Done>
Mesh decode(const Stream &stream, Done done)
{
    Mesh mesh = stream.base;
    Reader reader(stream.bytes);
    refine(mesh, stream, reader, [](size_t) { return Run(); }, [&](size_t) { done(mesh); });
    return mesh;
}

struct Encoding {
    Stream stream;
    std::vector<Vertex> input_vertex;     // of each decoded vertex
};

inline void take_base(Encoding &e, const Simplifier &s)
{
    std::vector<Vertex> number(s.mesh.rings.size());
    for (Vertex v = 0; v < number.size(); ++v) {
        if (s.mesh.rings[v].empty()) continue;
        number[v] = static_cast<Vertex>(e.input_vertex.size());
        e.input_vertex.push_back(v);
    }
    for (Vertex v : e.input_vertex) {
        Ring ring = s.mesh.rings[v];
        for (Vertex &w : ring) w = number[w];
        e.stream.base.rings.push_back(ring);
        e.stream.base.is_virtual.push_back(s.mesh.is_virtual[v]);
    }
    for (Gate g : s.first) e.stream.first.emplace_back(number[g.first], number[g.second]);
}

inline Encoding encode(const Simplifier &s, Kind kind)
{
    Encoding e;
    take_base(e, s);
    e.stream.kind = kind;
    e.stream.num_levels = s.levels.size();
    Mesh mesh = e.stream.base;
    Writer writer;
    size_t next = 0;
    auto next_run = [&](size_t level) {
        const Patch &patch = s.levels[level].at(next++);
        e.input_vertex.insert(e.input_vertex.end(), patch.removed.begin(), patch.removed.end());
        return patch.run;
    };
    refine(mesh, e.stream, writer, next_run, [&](size_t) { next = 0; });
    writer.finish();
    e.stream.bytes = writer.bytes;
    return e;
}

// Whether the decoded mesh is the input: the same oriented triangles around each vertex.
inline bool is_same(const Mesh &input, const Mesh &decoded, const std::vector<Vertex> &input_vertex)
{
    auto from_least = [](Ring ring) {
        std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
        return ring;
    };
    if (decoded.rings.size() != input.rings.size() || input_vertex.size() != input.rings.size()) return false;
    for (Vertex v = 0; v < decoded.rings.size(); ++v) {
        Ring ring = decoded.rings[v];
        for (Vertex &w : ring) w = input_vertex[w];
        if (from_least(ring) != from_least(input.rings[input_vertex[v]])) return false;
    }
    return true;
}

#endif
