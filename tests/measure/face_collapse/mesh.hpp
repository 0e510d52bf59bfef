// mesh.hpp - a closed triangle mesh as a rotation system. SPDX-License-Identifier: MIT
//
// Each vertex has the clockwise list of its neighbours, its ring; a triangle is two neighbours in a row. A boundary
// loop is closed by a virtual vertex, which is joined to all vertices of the loop and is neither removed nor moved.
//
// Both operations of the experiment are one. A vertex A and a run of s of its neighbours, V1 .. Vs, become A: s = 1
// collapses an edge, s = 2 a triangle. The ring of A afterwards is the rings of A, V1, .., Vs end to end, and each of
// the s + 1 vertices where two of them meet (the ends) was a neighbour of both. s and the ends undo it.
//
//          P               P
//         / \              |          s = 2, V1 = B, V2 = C; the ends are P, Q, R. The triangles A B C, A P B, B Q C
//        A - B             A - Q      and C R A are gone. The gate is on the left.
//       / \ / \           /
//      R - C - Q         R
#ifndef FACE_COLLAPSE_MESH_HPP
#define FACE_COLLAPSE_MESH_HPP

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

using Vertex = uint32_t;
using Ring = std::vector<Vertex>;
using Face = std::array<Vertex, 3>;   // counter-clockwise

enum { MAX_RUN = 2, MAX_ENDS = MAX_RUN + 1 };

struct Run {
    size_t size = 0;                  // s; 0: nothing is merged
    std::array<size_t, MAX_ENDS> ends = {};   // positions in the ring of A after the merge, ascending
};

class Mesh {
public:
    std::vector<Ring> rings;          // empty: removed
    std::vector<char> is_virtual;

    size_t valence(Vertex v) const { return rings[v].size(); }

    // The vertex A of the triangle L, R, A: what a gate leads to.
    Vertex front(Vertex l, Vertex r) const {
        const Ring &ring = rings[l];
        size_t k = find(ring, r);
        return ring[k == 0 ? ring.size() - 1 : k - 1];
    }

    Ring ring_from(Vertex v, Vertex first) const {
        Ring ring = rings[v];
        std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(find(ring, first)), ring.end());
        return ring;
    }

    // The ring of A when ring[k] .. ring[k + size - 1] have become A, from ring[0] on; and where the ends are in it.
    Ring merged_ring(Vertex a, const Ring &ring, size_t k, Run &run) const {
        auto at = [](size_t n) { return static_cast<std::ptrdiff_t>(n); };
        Ring merged(ring.begin(), ring.begin() + at(k));
        run.ends[0] = k - 1;
        for (size_t t = 0; t < run.size; ++t) {
            size_t inside = 1 + (t > 0) + (t + 1 < run.size);   // neighbours within the run, and A
            Ring rest = ring_from(ring[k + t], t > 0 ? ring[k + t - 1] : a);
            merged.insert(merged.end(), rest.begin() + 2, rest.begin() + at(1 + rest.size() - inside));
            run.ends[t + 1] = merged.size() - 1;
        }
        merged.insert(merged.end(), ring.begin() + at(k + run.size + 1), ring.end());
        return merged;
    }

    // The link condition: the mesh stays a simplicial surface if and only if A gets each neighbour once, and three or
    // more. Beside that no vertex may lie on two boundary loops.
    bool is_allowed(Ring ring) const {
        std::sort(ring.begin(), ring.end());
        if (ring.size() < 3 || std::adjacent_find(ring.begin(), ring.end()) != ring.end()) return false;
        return std::count_if(ring.begin(), ring.end(), [this](Vertex v) { return is_virtual[v]; }) <= 1;
    }

    void merge(Vertex a, const Ring &removed, const Ring &merged) {
        auto is_removed = [&](Vertex v) { return std::find(removed.begin(), removed.end(), v) != removed.end(); };
        for (Vertex w : merged) {
            Ring &ring = rings[w];
            if (std::find(ring.begin(), ring.end(), a) == ring.end())
                *std::find_if(ring.begin(), ring.end(), is_removed) = a;
            ring.erase(std::remove_if(ring.begin(), ring.end(), is_removed), ring.end());
        }
        for (Vertex v : removed) rings[v].clear();
        rings[a] = merged;
    }

    // Undoes a merge; the vertices that were removed get the next numbers. `ring` is that of A.
    void split(Vertex a, const Ring &ring, const Run &run) {
        Vertex first = static_cast<Vertex>(rings.size());
        auto owner = [&](size_t t) { return t == 0 || t > run.size ? a : first + static_cast<Vertex>(t - 1); };
        Ring own(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(run.ends[0] + 1));
        for (size_t t = 1; t <= run.size; ++t) {
            Ring part = {a};
            if (t > 1) part.push_back(owner(t - 1));
            for (size_t k = run.ends[t - 1]; k <= run.ends[t]; ++k) part.push_back(ring[k]);
            if (t < run.size) part.push_back(owner(t + 1));
            rings.push_back(part);
            is_virtual.push_back(0);
            own.push_back(owner(t));
        }
        own.insert(own.end(), ring.begin() + static_cast<std::ptrdiff_t>(run.ends[run.size]), ring.end());
        for (size_t k = run.ends[0]; k <= run.ends[run.size]; ++k) {
            Ring owners;                  // of ring[k], counter-clockwise, as it sees them
            for (size_t t = run.size + 2; t-- > 0;) {
                size_t begin = t == 0 ? 0 : run.ends[t - 1], end = t > run.size ? ring.size() - 1 : run.ends[t];
                if (begin <= k && k <= end) owners.push_back(owner(t));
            }
            Ring &outer = rings[ring[k]];
            auto here = outer.erase(outer.begin() + static_cast<std::ptrdiff_t>(find(outer, a)));
            outer.insert(here, owners.begin(), owners.end());
        }
        rings[a] = own;
    }

    // All triangles, each once; without those at virtual vertices if `real`.
    std::vector<Face> faces(bool real) const {
        std::vector<Face> list;
        for (Vertex a = 0; a < rings.size(); ++a)
            for (size_t k = 0; k < rings[a].size(); ++k) {
                Vertex c = rings[a][k], b = rings[a][k + 1 < rings[a].size() ? k + 1 : 0];
                if (a < b && a < c && !(real && (is_virtual[a] || is_virtual[b] || is_virtual[c])))
                    list.push_back({a, b, c});
            }
        return list;
    }

    size_t num_real() const {
        size_t n = 0;
        for (Vertex v = 0; v < rings.size(); ++v) n += !is_virtual[v] && !rings[v].empty();
        return n;
    }

private:
    static size_t find(const Ring &ring, Vertex v) {
        return static_cast<size_t>(std::find(ring.begin(), ring.end(), v) - ring.begin());
    }
};

// Closes the triangles of `faces` to a mesh: nullptr, or why they are no oriented manifold.
inline const char *close_mesh(Mesh &mesh, size_t num_vertices, const std::vector<Face> &faces)
{
    std::map<std::pair<Vertex, Vertex>, Vertex> third;   // of the triangle at the left of an edge
    for (const Face &f : faces)
        for (size_t k = 0; k < 3; ++k)
            if (f[k] == f[(k + 1) % 3] || !third.emplace(std::make_pair(f[k], f[(k + 1) % 3]), f[(k + 2) % 3]).second)
                return "an edge has two triangles on one side";
    std::map<Vertex, Vertex> border;                     // from each vertex of a loop to the next one
    for (const auto &entry : third)
        if (!third.count({entry.first.second, entry.first.first})
            && !border.emplace(entry.first.second, entry.first.first).second)
            return "a vertex lies twice on boundaries";
    mesh.is_virtual.assign(num_vertices, 0);
    while (!border.empty()) {
        Vertex centre = static_cast<Vertex>(mesh.is_virtual.size());
        mesh.is_virtual.push_back(1);
        for (auto edge = border.begin(); edge != border.end();) {
            Vertex v = edge->first, w = edge->second;
            third[{v, w}] = centre, third[{w, centre}] = v, third[{centre, v}] = w;
            border.erase(edge);
            edge = border.find(w);
        }
    }
    mesh.rings.assign(mesh.is_virtual.size(), Ring());
    for (const auto &entry : third) {
        Vertex v = entry.first.first, w = entry.first.second;
        if (!mesh.rings[v].empty()) continue;
        do {
            mesh.rings[v].push_back(w);
            w = third[{w, v}];
        } while (w != entry.first.second);
    }
    size_t corners = 0;
    for (const Ring &ring : mesh.rings) {
        if (ring.empty()) return "a vertex has no triangle";
        if (ring.size() < 3) return "two triangles have the same vertices";
        corners += ring.size();
    }
    return corners == third.size() ? nullptr : "a vertex has two fans of triangles";
}

#endif
