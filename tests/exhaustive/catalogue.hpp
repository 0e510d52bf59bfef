// Every combinatorial type of small triangulated spheres, tori and discs; mirror images are one type.
//
// Spheres     every sphere is a tetrahedron after vertex splits (E. Steinitz and H. Rademacher, 1934). A second list is
//             searched: triangle by triangle around the first edge that lacks one
// Tori        searched alike. Splits of smaller tori do not reach all of them: 1, 4 and 15 tori of 7, 8 and 9 vertices
//             have no edge that may be collapsed (S. Lawrencenko, "The irreducible triangulations of the torus", 1987)
// Discs       a disc with a cone over its boundary is a sphere, so the discs of n vertices are spheres of n + 1 with
//             a marked vertex. A second list grows them triangle by triangle: every disc can be shelled
#ifndef CQ_TESTS_CATALOGUE_HPP
#define CQ_TESTS_CATALOGUE_HPP

#include <map>

#include "triangulation.hpp"

// Of each type one triangulation. Of discs the last vertex is the cone.
using Catalogue = std::map<Code, Triangulation>;

// Numbers of types for 0, 1, 2, ... vertices. Spheres: OEIS A000109. Tori: F. Lutz, "Enumeration and random realization
// of triangulated surfaces", 2008. Discs: as found here in two ways, vertices of the boundary and of the inside
// together.
constexpr size_t NUM_SPHERES[] = {0, 0, 0, 0, 1, 1, 2, 5, 14, 50, 233, 1249, 7595};
constexpr size_t NUM_TORI[] = {0, 0, 0, 0, 0, 0, 0, 1, 7, 112, 2109};
constexpr size_t NUM_IRREDUCIBLE_TORI[] = {0, 0, 0, 0, 0, 0, 0, 1, 4, 15, 1};
constexpr size_t NUM_DISCS[] = {0, 0, 0, 1, 2, 4, 16, 63, 328, 1933, 12633};

inline Triangulation tetrahedron()
{
    Triangulation t(4);
    t.put(0, 1, 2), t.put(0, 2, 3), t.put(0, 3, 1), t.put(1, 3, 2);
    return t;
}

// All (p, q), p != q, around a.
template <typename Visit>
void for_each_split(const Triangulation &t, int a, Visit visit)
{
    std::vector<int> ring = t.ring(a);
    for (int p : ring)
        for (int q : ring)
            if (p != q) visit(p, q);
}

// What all splits of all triangulations lead to.
inline Catalogue split_all(const Catalogue &from)
{
    Catalogue to;
    for (const auto &[code, t] : from)
        for (int a = 0; a < t.n; ++a)
            for_each_split(t, a, [&, &t = t](int p, int q) {
                Triangulation s = t;
                s.split(a, p, q);
                to.emplace(code_of(s), s);
            });
    return to;
}

inline Catalogue spheres(int vertices)
{
    Catalogue all = {{code_of(tetrahedron()), tetrahedron()}};
    for (int n = 4; n < vertices; ++n) all = split_all(all);
    return all;
}

// -- Search for all closed oriented surfaces of an Euler characteristic ---------------------------------------------

class Search {
public:
    Catalogue found;

    // Vertex 0 has the largest degree d, and the ring 1 .. d, clockwise.
    Search(int vertices, int euler) : n(vertices), num_faces(2 * (vertices - euler)), t(vertices) {
        for (degree = 3; degree < n; ++degree) {
            t = Triangulation(n);
            for (int k = 1; k <= degree; ++k) t.put(0, k % degree + 1, k);
            used = degree + 1;
            extend(degree);
        }
    }

private:
    int n, num_faces, degree = 0, used = 0;
    Triangulation t;

    bool find_open(int &u, int &v) const {
        for (u = 0; u < used; ++u)
            for (v = 0; v < used; ++v)
                if (t.apex(u, v) == NO_VERTEX && t.apex(v, u) != NO_VERTEX) return true;
        return false;
    }

    // Triangles at v that make a closed fan must be all there are.
    bool is_fan(int v) const {
        int start = 0, edges = t.degree(v), steps = 1;
        if (edges > degree) return false;
        while (start < used && t.apex(start, v) == NO_VERTEX) start++;
        for (int w = t.clockwise(v, start); w != start; w = t.clockwise(v, w), ++steps)
            if (w == NO_VERTEX) return true;
        return steps == edges;
    }

    void extend(int faces) {
        int u, v;
        if (!find_open(u, v)) {
            if (faces == num_faces && used == n && t.is_closed_surface()) found.emplace(code_of(t), t);
            return;
        }
        if (faces == num_faces) return;
        for (int w = 0; w < n && w <= used; ++w) {
            if (w == u || w == v || t.apex(v, w) != NO_VERTEX || t.apex(w, u) != NO_VERTEX) continue;
            int used_before = used;
            t.put(u, v, w);
            used = std::max(used, w + 1);
            if (is_fan(u) && is_fan(v) && is_fan(w)) extend(faces + 1);
            used = used_before;
            t.remove(u, v, w);
        }
    }
};

inline Catalogue closed_surfaces(int vertices, int euler) { return Search(vertices, euler).found; }
inline Catalogue tori(int vertices) { return closed_surfaces(vertices, 0); }

// Those that no edge can be collapsed in: each edge lies in a cycle of three edges that is not a triangle.
inline bool is_irreducible(const Triangulation &t)
{
    for (int a = 0; a < t.n; ++a)
        for (int b = 0; b < t.n; ++b) {
            if (!t.has_edge(a, b)) continue;
            int common = 0;
            for (int c = 0; c < t.n; ++c) common += t.has_edge(a, c) && t.has_edge(b, c);
            if (common == 2) return false;
        }
    return true;
}

// -- Discs ----------------------------------------------------------------------------------------------------------

inline Triangulation with_last(const Triangulation &t, int v)
{
    std::vector<int> number(static_cast<size_t>(t.n));
    for (int k = 0; k < t.n; ++k) number[static_cast<size_t>(k)] = k == v ? t.n - 1 : k == t.n - 1 ? v : k;
    return t.renumbered(number);
}

// `vertices` without the cone.
inline Catalogue discs(int vertices)
{
    Catalogue all;
    for (const auto &[code, t] : spheres(vertices + 1))
        for (int v = 0; v < t.n; ++v) {
            Triangulation disc = with_last(t, v);
            all.emplace(code_of(disc, disc.n - 1), disc);
        }
    return all;
}

// The boundary of a disc, as the directed edges that have their triangle on the left.
inline std::vector<std::array<int, 2>> boundary_of(const Triangulation &open)
{
    std::vector<std::array<int, 2>> edges;
    for (int a = 0; a < open.n; ++a)
        for (int b = 0; b < open.n; ++b)
            if (open.apex(a, b) != NO_VERTEX && open.apex(b, a) == NO_VERTEX) edges.push_back({a, b});
    return edges;
}

inline Triangulation coned(const Triangulation &open)
{
    Triangulation t = open;
    int cone = t.n++;
    for (auto [a, b] : boundary_of(open)) t.put(b, a, cone);
    return t;
}

// All discs of up to `vertices` vertices that are a triangle after triangle has been put to the boundary: at one edge
// with a new vertex, or at two edges in a row.
class Shelling {
public:
    std::vector<Catalogue> found;   // by number of vertices, without the cone

    explicit Shelling(int vertices) : found(static_cast<size_t>(vertices) + 1) {
        Triangulation single(3);
        single.put(0, 1, 2);
        reach(single);
        while (!todo.empty()) {
            Triangulation t = todo.back();
            todo.pop_back();
            for (auto [a, b] : boundary_of(t)) {
                if (t.n < vertices) grow(t, a, b);
                for (auto [c, d] : boundary_of(t))
                    if (c == b && d != a && !t.has_edge(a, d)) glue(t, a, b, d);
            }
        }
    }

private:
    std::vector<Triangulation> todo;

    void grow(Triangulation t, int a, int b) {
        t.put(b, a, t.n);
        t.n++;
        reach(t);
    }
    void glue(Triangulation t, int a, int b, int d) {
        t.put(b, a, d);
        reach(t);
    }
    void reach(const Triangulation &t) {
        Triangulation closed = coned(t);
        if (found[static_cast<size_t>(t.n)].emplace(code_of(closed, t.n), closed).second) todo.push_back(t);
    }
};

#endif
