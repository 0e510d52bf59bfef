// conquest.hpp - levels of patches found through gates, and simplification. SPDX-License-Identifier: MIT
//
// As in the paper: a level begins at the first gate and takes gates from a queue; the front vertex of a gate, if no
// patch of this level contains it, becomes the centre of the next patch. Three things differ:
//
//   - The vertices of the first gate of each component are never removed, nor are virtual vertices.
//   - If all vertices of a gate's triangle are conquered but none is a centre, the triangle's other two edges become
//     gates, as in valence-driven conquest (Alliez and Desbrun 2001). Without this, some vertices are not reached.
//   - Levels alternate between the two sides of the first gate. Simplification ends after two levels without a merge.
#ifndef FACE_COLLAPSE_CONQUEST_HPP
#define FACE_COLLAPSE_CONQUEST_HPP

#include <cmath>
#include <deque>
#include <set>

#include "mesh.hpp"

using Gate = std::pair<Vertex, Vertex>;

enum State : char { AVAILABLE, CONQUERED, CENTRE };

// Conquers the mesh once. For each patch, visit(centre, its ring clockwise from L to R, states) may merge or split, and
// returns the ring that the patch has in the coarser mesh: the encoder and the decoder meet the same gates.
template <class Visit>
void conquer(Mesh &mesh, const std::vector<Gate> &first, bool other_side, Visit visit)
{
    std::vector<State> state(mesh.rings.size(), AVAILABLE);
    std::deque<Gate> queue;
    std::set<Gate> crossed;
    for (Vertex v = 0; v < state.size(); ++v)
        if (mesh.is_virtual[v]) state[v] = CONQUERED;
    for (Gate g : first) {
        state[g.first] = state[g.second] = CONQUERED;
        queue.push_back(other_side ? Gate(g.second, g.first) : g);
    }
    for (; !queue.empty(); queue.pop_front()) {
        Gate gate = queue.front();
        Vertex a = mesh.front(gate.first, gate.second);
        if (state[a] == CENTRE) continue;
        if (state[a] == CONQUERED) {
            if (!crossed.insert(gate).second) continue;
            queue.emplace_back(gate.first, a);
            queue.emplace_back(a, gate.second);
            continue;
        }
        Ring ring = visit(a, mesh.ring_from(a, gate.first), state);
        state.resize(mesh.rings.size(), CENTRE);          // what a split has added
        state[a] = CENTRE;
        for (Vertex v : ring) state[v] = CONQUERED;
        for (size_t k = 0; k + 1 < ring.size(); ++k) queue.emplace_back(ring[k], ring[k + 1]);
    }
}

// -- Encoder: simplification ------------------------------------------------------------------------------------------

// What a patch loses: one vertex; two; two if possible, otherwise one.
enum class Kind { EDGE, FACE, MIXED };

// Which of the allowed runs is merged: that with the smallest or the largest valence of A afterwards (the first of
// equal ones, clockwise from L), or that with the shortest edge or perimeter. DISTINCT: as SMALLEST, but the ends are
// distinct, that is, no vertex of valence 3 is removed with its triangle.
enum class Choice { SMALLEST, LARGEST, SHORTEST, DISTINCT };

// Where A lies afterwards: at the mean of the merged vertices, or where it was.
enum class Place { MEAN, KEPT };

struct Strategy {
    Kind kind;
    Choice choice;
    Place place;
};

using Position = std::array<double, 3>;

struct Patch {
    Run run;                          // ends in the ring from L on
    Ring removed;
    size_t ring_size = 0;             // of the coarse mesh
    bool is_blocked = false;          // isolated: there are runs of available neighbours, but none is allowed
};

using Level = std::vector<Patch>;

class Simplifier {
public:
    Mesh mesh;
    std::vector<Position> positions;
    std::vector<Gate> first;
    std::vector<Level> levels;

    Simplifier(const Mesh &m, const std::vector<Position> &p, Strategy s) : mesh(m), positions(p), strategy(s) {
        positions.resize(mesh.rings.size());
        find_first_gates();
    }

    void simplify() {
        while (add_level()) {}
        while (!levels.empty() && is_empty(levels.back())) levels.pop_back();
    }

    // False if neither this level nor the one before has removed a vertex.
    bool add_level() {
        Level level;
        conquer(mesh, first, levels.size() % 2 != 0, [&](Vertex a, const Ring &ring, const std::vector<State> &state) {
            Candidate best = find(a, ring, state);
            level.push_back(best.patch);
            if (best.patch.run.size == 0) return ring;
            merge(a, best);
            return best.merged;
        });
        levels.push_back(level);
        return levels.size() < 2 || !is_empty(level) || !is_empty(levels[levels.size() - 2]);
    }

private:
    struct Candidate {
        Patch patch;
        Ring merged;
        double cost = 0;
    };

    Strategy strategy;

    static bool is_empty(const Level &level) {
        return std::all_of(level.begin(), level.end(), [](const Patch &p) { return p.run.size == 0; });
    }

    void find_first_gates() {
        std::vector<char> seen(mesh.rings.size(), 0);
        for (Vertex v = 0; v < seen.size(); ++v) {
            if (seen[v]) continue;
            first.emplace_back(v, *std::find_if(mesh.rings[v].begin(), mesh.rings[v].end(),
                                                [&](Vertex w) { return !mesh.is_virtual[w]; }));
            std::vector<Vertex> todo = {v};
            seen[v] = 1;
            while (!todo.empty()) {
                Vertex a = todo.back();
                todo.pop_back();
                for (Vertex w : mesh.rings[a])
                    if (!seen[w]) seen[w] = 1, todo.push_back(w);
            }
        }
    }

    Candidate find(Vertex a, const Ring &ring, const std::vector<State> &state) const {
        Candidate best;
        best.patch.ring_size = ring.size();
        if (strategy.kind != Kind::EDGE) search(best, 2, a, ring, state);
        if (best.patch.run.size == 0 && strategy.kind != Kind::FACE) search(best, 1, a, ring, state);
        return best;
    }

    // ring.front() and ring.back(), L and R, are conquered.
    void search(Candidate &best, size_t size, Vertex a, const Ring &ring, const std::vector<State> &state) const {
        auto is_available = [&](Vertex v) { return state[v] == AVAILABLE; };
        for (auto begin = ring.begin() + 1; begin + static_cast<std::ptrdiff_t>(size) < ring.end(); ++begin) {
            Candidate c;
            c.patch.removed.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
            if (!std::all_of(c.patch.removed.begin(), c.patch.removed.end(), is_available)) continue;
            c.patch.run.size = size;
            c.merged = mesh.merged_ring(a, ring, static_cast<size_t>(begin - ring.begin()), c.patch.run);
            c.patch.ring_size = c.merged.size();
            c.cost = cost(a, c);
            if (!is_allowed(c)) best.patch.is_blocked = best.patch.run.size == 0;
            else if (best.patch.run.size == 0 || c.cost < best.cost) best = c;
        }
    }

    bool is_allowed(const Candidate &c) const {
        auto ends = c.patch.run.ends.begin(), last = ends + static_cast<std::ptrdiff_t>(c.patch.run.size);
        if (strategy.choice == Choice::DISTINCT && std::adjacent_find(ends, last + 1) != last + 1) return false;
        return mesh.is_allowed(c.merged);
    }

    double cost(Vertex a, const Candidate &c) const {
        double valence = static_cast<double>(c.merged.size()), sum = 0;
        if (strategy.choice == Choice::LARGEST) return -valence;
        if (strategy.choice != Choice::SHORTEST) return valence;
        Vertex from = a;
        for (Vertex v : c.patch.removed) {
            sum += distance(from, v);
            from = v;
        }
        return sum + distance(from, a);
    }

    double distance(Vertex v, Vertex w) const {
        double sum = 0;
        for (size_t k = 0; k < 3; ++k) sum += (positions[v][k] - positions[w][k]) * (positions[v][k] - positions[w][k]);
        return std::sqrt(sum);
    }

    void merge(Vertex a, const Candidate &c) {
        if (strategy.place == Place::MEAN) move_to_mean(a, c.patch.removed);
        mesh.merge(a, c.patch.removed, c.merged);
    }

    void move_to_mean(Vertex a, const Ring &removed) {
        for (size_t k = 0; k < 3; ++k) {
            for (Vertex v : removed) positions[a][k] += positions[v][k];
            positions[a][k] /= static_cast<double>(removed.size() + 1);
        }
    }
};

#endif
