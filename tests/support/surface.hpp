// An exhaustive check of triangle meshes that shares no code and no idea with the library: faces are looked up by their
// edges in a map, fans are put together from link edges, everything is counted again from the triangles alone.
#ifndef CQ_TESTS_SURFACE_HPP
#define CQ_TESTS_SURFACE_HPP

#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

using Face = std::array<uint32_t, 3>;
using Edge = std::pair<uint32_t, uint32_t>;

// What the faces are, or why they are not an oriented manifold. Only vertices that have faces count.
struct Surface {
    std::string error;
    size_t vertices = 0, faces = 0, components = 0, loops = 0, boundary_edges = 0;
    long euler = 0;

    bool operator==(const Surface &s) const {
        return error == s.error && vertices == s.vertices && faces == s.faces && components == s.components
            && loops == s.loops && boundary_edges == s.boundary_edges && euler == s.euler;
    }
    // The same up to refinement.
    bool same_topology(const Surface &s) const {
        return error == s.error && components == s.components && loops == s.loops && euler == s.euler;
    }
};

inline std::string name(const char *what, uint32_t a, uint32_t b)
{
    return std::string(what) + " " + std::to_string(a) + " " + std::to_string(b);
}

// The faces around v as link edges a -> b of its faces v, a, b must be one path or one cycle.
inline bool is_one_fan(const std::map<uint32_t, uint32_t> &link)
{
    std::set<uint32_t> ends;
    for (auto [a, b] : link)
        if (!ends.insert(b).second) return false;
    uint32_t start = link.begin()->first;
    size_t starts = 0;
    for (auto [a, b] : link)
        if (ends.count(a) == 0) start = a, starts++;
    if (starts > 1) return false;
    size_t steps = 0;
    for (auto at = link.find(start); at != link.end() && steps <= link.size(); at = link.find(at->second)) {
        steps++;
        if (at->second == start) break;
    }
    return steps == link.size();
}

inline Surface examine(const std::vector<Face> &faces)
{
    Surface s;
    std::set<Edge> directed;
    std::map<uint32_t, std::map<uint32_t, uint32_t>> links;
    std::map<uint32_t, uint32_t> parent;
    auto root = [&](uint32_t v) {
        while (parent[v] != v) v = parent[v];
        return v;
    };
    for (const Face &f : faces) {
        for (size_t k = 0; k < 3; ++k) {
            uint32_t a = f[k], b = f[(k + 1) % 3], c = f[(k + 2) % 3];
            if (a == b) s.error = name("a face has a vertex twice:", a, b);
            else if (!directed.insert({a, b}).second) s.error = name("two faces run along", a, b);
            else links[a][b] = c;
            parent.emplace(a, a);
        }
        for (size_t k = 0; k < 3; ++k) parent[root(f[k])] = root(f[0]);
    }
    std::map<uint32_t, uint32_t> border;
    for (auto [a, b] : directed) {
        if (directed.count({b, a})) continue;
        s.boundary_edges++;
        if (!border.emplace(a, b).second) s.error = name("two boundary edges leave", a, b);
    }
    for (const auto &[v, link] : links)
        if (!is_one_fan(link)) s.error = name("not one fan:", v, v);
    if (s.error.empty()) {
        std::set<uint32_t> seen;
        for (auto [a, b] : border) {
            if (seen.count(a)) continue;
            s.loops++;
            for (uint32_t v = a; seen.insert(v).second;) v = border[v];
        }
    }
    for (auto [v, p] : parent) s.components += v == p;
    s.vertices = parent.size();
    s.faces = faces.size();
    size_t edges = (directed.size() + s.boundary_edges) / 2;
    s.euler = static_cast<long>(s.vertices) - static_cast<long>(edges) + static_cast<long>(s.faces);
    return s;
}

// -- A halfedge mesh as faces, and all of its arrays against them ---------------------------------------------------

#ifdef CQ_CONQUEST_H

inline bool slot_is_used(const cq_mesh &m, uint32_t f) { return m.origin[3 * f] != CQ_NONE; }

inline Face slot(const cq_mesh &m, uint32_t f)
{
    return {m.origin[3 * f], m.origin[3 * f + 1], m.origin[3 * f + 2]};
}

// The numbers of the face slots in use: real, virtual or both.
inline std::vector<uint32_t> used_slots(const cq_mesh &m, bool real, bool virtuals)
{
    std::vector<uint32_t> slots;
    for (uint32_t f = 0; real && f < m.num_faces; ++f)
        if (slot_is_used(m, f)) slots.push_back(f);
    for (uint32_t k = 0; virtuals && k < m.num_virtual_faces; ++k)
        if (slot_is_used(m, m.first_virtual_face + k)) slots.push_back(m.first_virtual_face + k);
    return slots;
}

inline std::vector<Face> faces_of(const cq_mesh &m, bool real = true, bool virtuals = false)
{
    std::vector<Face> faces;
    for (uint32_t f : used_slots(m, real, virtuals)) faces.push_back(slot(m, f));
    return faces;
}

inline bool is_real_vertex(const cq_mesh &m, uint32_t v) { return v < m.num_vertices; }

inline bool is_virtual_vertex(const cq_mesh &m, uint32_t v)
{
    return v >= m.first_virtual && v - m.first_virtual < m.num_virtual;
}

// Why the mesh breaks an invariant of the manual, or "".
inline std::string examine(const cq_mesh &m)
{
    if (m.num_vertices > m.first_virtual || m.num_faces > m.first_virtual_face || m.num_virtual > m.max_virtual
        || m.num_virtual_faces > m.max_virtual_faces)
        return "more slots in use than there are";
    std::map<Edge, uint32_t> halfedge;
    std::map<uint32_t, std::set<uint32_t>> neighbours;
    for (uint32_t f : used_slots(m, true, true)) {
        Face face = slot(m, f);
        int virtuals = 0;
        for (uint32_t v : face) {
            if (!is_real_vertex(m, v) && !is_virtual_vertex(m, v)) return name("no such vertex:", v, f);
            virtuals += is_virtual_vertex(m, v);
        }
        if (virtuals != (f >= m.first_virtual_face)) return name("wrong number of virtual corners:", f, f);
        for (uint32_t k = 0; k < 3; ++k) {
            uint32_t a = face[k], b = face[(k + 1) % 3];
            halfedge[{a, b}] = 3 * f + k;
            neighbours[a].insert(b);
            neighbours[b].insert(a);
        }
    }
    Surface closed = examine(faces_of(m, true, true));
    if (!closed.error.empty()) return closed.error;
    if (closed.boundary_edges != 0) return "not closed";
    for (auto [edge, h] : halfedge) {
        auto twin = halfedge.find({edge.second, edge.first});
        if (twin == halfedge.end() || m.twin[h] != twin->second) return name("wrong twin:", edge.first, edge.second);
    }
    uint32_t slots = uint32_t(m.first_virtual) + m.max_virtual;
    for (uint32_t v = 0; v < slots; ++v) {
        auto around = neighbours.find(v);
        bool counted = is_real_vertex(m, v) || is_virtual_vertex(m, v);
        if (!counted) continue;
        if ((m.out[v] != CQ_NONE) != (around != neighbours.end())) return name("in use or not:", v, v);
        if (around == neighbours.end()) continue;
        uint32_t h = m.out[v], all = 3 * (uint32_t(m.first_virtual_face) + m.max_virtual_faces);
        if (h >= all || !slot_is_used(m, h / 3) || m.origin[h] != v) return name("wrong halfedge out of", v, h);
        if (halfedge.count({v, m.origin[cq_next(m.out[v])]}) == 0) return name("stale halfedge out of", v, h);
        if (m.valence[v] != around->second.size()) return name("wrong valence:", v, m.valence[v]);
        size_t touching = 0;
        for (uint32_t w : around->second) touching += is_virtual_vertex(m, w);
        if (touching > (is_virtual_vertex(m, v) ? 0u : 1u)) return name("boundaries touch at", v, v);
    }
    return "";
}

#endif
#endif
