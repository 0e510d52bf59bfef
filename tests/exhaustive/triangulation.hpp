// Small closed oriented triangulations as a plain table, independent of the library: apex[u][v] is the third corner of
// the triangle on the left of u -> v. A disc is a sphere with one vertex marked, the cone over its boundary.
#ifndef CQ_TESTS_TRIANGULATION_HPP
#define CQ_TESTS_TRIANGULATION_HPP

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#ifndef CQ_TESTS_MOST_VERTICES
#define CQ_TESTS_MOST_VERTICES 16
#endif
enum { MOST_VERTICES = CQ_TESTS_MOST_VERTICES };
constexpr uint8_t NO_VERTEX = 0xff;

using Triangle = std::array<int, 3>;

class Triangulation {
public:
    int n = 0;

    explicit Triangulation(int vertices = 0) : n(vertices) { std::memset(table, NO_VERTEX, sizeof table); }

    // What is on the left of u -> v, or NO_VERTEX.
    uint8_t apex(int u, int v) const { return table[u][v]; }
    bool has_edge(int u, int v) const { return apex(u, v) != NO_VERTEX || apex(v, u) != NO_VERTEX; }

    // Neighbours of v one after another: if v, x, y is a triangle, x follows y clockwise.
    int clockwise(int v, int y) const { return apex(y, v); }

    void put(int a, int b, int c) {
        table[a][b] = static_cast<uint8_t>(c);
        table[b][c] = static_cast<uint8_t>(a);
        table[c][a] = static_cast<uint8_t>(b);
    }
    void remove(int a, int b, int c) { table[a][b] = table[b][c] = table[c][a] = NO_VERTEX; }

    // A new vertex n takes the neighbours of a strictly clockwise between p and q; both keep p and q. It is the inverse
    // of the collapse of the edge from a to the new vertex.
    void split(int a, int p, int q) {
        std::vector<int> fan = {p};
        while (fan.back() != q) fan.push_back(clockwise(a, fan.back()));
        for (size_t k = 0; k + 1 < fan.size(); ++k) remove(a, fan[k + 1], fan[k]);
        for (size_t k = 0; k + 1 < fan.size(); ++k) put(n, fan[k + 1], fan[k]);
        put(p, a, n);
        put(a, q, n);
        n++;
    }

    // All triangles at b go to a, but for those two that have both; b is then in no triangle. What comes out need not
    // be a surface.
    Triangulation collapsed(int a, int b) const {
        Triangulation t(n);
        for (Triangle f : triangles()) {
            std::replace(f.begin(), f.end(), b, a);
            if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) t.put(f[0], f[1], f[2]);
        }
        return t;
    }

    // Neighbours of v clockwise; empty if the triangles at v are not one closed fan.
    std::vector<int> ring(int v) const {
        int first = 0, edges = 0;
        for (int w = 0; w < n; ++w)
            if (has_edge(v, w)) first = w, edges++;
        std::vector<int> r;
        for (int w = first; edges > 0; w = clockwise(v, w)) {
            r.push_back(w);
            int behind = clockwise(v, w);
            if (behind == NO_VERTEX || r.size() > static_cast<size_t>(edges)) return {};
            if (behind == first) break;
        }
        return r.size() == static_cast<size_t>(edges) ? r : std::vector<int>();
    }

    int degree(int v) const {
        int edges = 0;
        for (int w = 0; w < n; ++w) edges += has_edge(v, w);
        return edges;
    }

    int num_edges() const {
        int degrees = 0;
        for (int v = 0; v < n; ++v) degrees += degree(v);
        return degrees / 2;
    }

    // Closed, and the triangles of each vertex but `unused` are one fan.
    bool is_closed_surface(int unused = -1) const {
        for (int v = 0; v < n; ++v)
            if (v != unused && ring(v).size() < 3) return false;
        return true;
    }

    int euler() const { return n - num_edges() + static_cast<int>(triangles().size()); }

    // Each triangle once, from its smallest corner.
    std::vector<Triangle> triangles() const {
        std::vector<Triangle> list;
        for (int a = 0; a < n; ++a)
            for (int b = a + 1; b < n; ++b)
                if (int c = apex(a, b); c != NO_VERTEX && c > a) list.push_back({a, b, c});
        return list;
    }

    Triangulation mirrored() const {
        Triangulation m(n);
        for (int a = 0; a < n; ++a)
            for (int b = 0; b < n; ++b) m.table[a][b] = table[b][a];
        return m;
    }

    // Vertex v becomes number[v].
    Triangulation renumbered(const std::vector<int> &number) const {
        Triangulation t(n);
        auto vertex = [&](int v) { return number[static_cast<size_t>(v)]; };
        for (Triangle f : triangles()) t.put(vertex(f[0]), vertex(f[1]), vertex(f[2]));
        return t;
    }

    bool operator==(const Triangulation &t) const { return n == t.n && std::memcmp(table, t.table, sizeof table) == 0; }

private:
    uint8_t table[MOST_VERTICES][MOST_VERTICES];
};

// -- Combinatorial types --------------------------------------------------------------------------------------------
//
// A flag (a directed edge and a sense of rotation) numbers all vertices: the edge's ends are 0 and 1, and each vertex
// in this order gives the next numbers to its neighbours, around from the one that it got its own number from. The
// rotations written down in these numbers are a code of the triangulation; the smallest code of all flags is the same
// for two triangulations if and only if they are isomorphic, mirror images included.

using Code = std::string;

class Coder {
public:
    // root: only flags that start there count, for triangulations with a marked vertex; or -1
    explicit Coder(const Triangulation &triangulation, int root = -1) : t(triangulation), mirror(t.mirrored()) {
        for (int u = 0; u < t.n; ++u) degree[u] = t.degree(u);
        for (int u = 0; u < t.n; ++u)
            for (int v = 0; (root < 0 || u == root) && v < t.n; ++v)
                if (t.has_edge(u, v)) try_flag(t, u, v), try_flag(mirror, u, v);
    }

    const Code &code() const { return best; }

private:
    const Triangulation &t;
    Triangulation mirror;
    int degree[MOST_VERTICES];
    Code best;

    void try_flag(const Triangulation &rotation, int u, int v) {
        int number[MOST_VERTICES], vertex[MOST_VERTICES], from[MOST_VERTICES], known = 2;
        bool smaller = best.empty();
        Code code;
        std::fill_n(number, t.n, -1);
        number[u] = 0, vertex[0] = u, from[0] = v;
        number[v] = 1, vertex[1] = v, from[1] = u;
        auto write = [&](int symbol) {
            code.push_back(static_cast<char>(symbol));
            if (!smaller && code.back() != best[code.size() - 1]) {
                smaller = code.back() < best[code.size() - 1];
                return smaller;
            }
            return true;
        };
        for (int k = 0; k < known; ++k) {
            int x = vertex[k], w = from[k];
            if (!write(degree[x])) return;
            for (int d = 0; d < degree[x]; ++d, w = rotation.clockwise(x, w)) {
                if (number[w] < 0) number[w] = known, vertex[known] = w, from[known++] = x;
                if (!write(number[w])) return;
            }
        }
        if (smaller) best = code;
    }
};

inline Code code_of(const Triangulation &t, int root = -1) { return Coder(t, root).code(); }

#endif
