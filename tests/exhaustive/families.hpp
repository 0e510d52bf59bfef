// The triangulations of the tests in this folder: families of combinatorial types, and a decoder's or a mesh's faces as
// a triangulation. Include conquest.h first.
#ifndef CQ_TESTS_FAMILIES_HPP
#define CQ_TESTS_FAMILIES_HPP

#include "catalogue.hpp"

enum class Topology { sphere, torus, disc };

struct Family {
    Topology topology;
    int vertices;   // real ones

    size_t known_count() const {
        size_t n = static_cast<size_t>(vertices);
        if (topology == Topology::sphere) return NUM_SPHERES[n];
        return topology == Topology::torus ? NUM_TORI[n] : NUM_DISCS[n];
    }
    Catalogue all() const {
        if (topology == Topology::sphere) return spheres(vertices);
        return topology == Topology::torus ? tori(vertices) : discs(vertices);
    }
    bool is_open() const { return topology == Topology::disc; }
    int euler() const { return topology == Topology::torus ? 0 : 2; }   // with the cone
    std::string name() const {
        const char *names[] = {"spheres", "tori", "discs"};
        return std::string(names[static_cast<int>(topology)]) + " of " + std::to_string(vertices) + " vertices";
    }
};

// All families of a topology, from one number of vertices to another.
inline void add_families(std::vector<Family> &to, Topology topology, int first, int last)
{
    for (int n = first; n <= last; ++n) to.push_back({topology, n});
}

// What `make test` runs, and one vertex more of each for `make verify`.
inline std::vector<Family> small_families()
{
    std::vector<Family> families;
    add_families(families, Topology::sphere, 4, 10);
    add_families(families, Topology::torus, 7, 9);
    add_families(families, Topology::disc, 3, 8);
    return families;
}

inline std::vector<Family> larger_families()
{
    std::vector<Family> families;
    add_families(families, Topology::sphere, 11, 11);
    add_families(families, Topology::torus, 10, 10);
    add_families(families, Topology::disc, 9, 9);
    return families;
}

// The triangles without the cone, `first` in front; vertices below num_real.
inline std::vector<cq_index> index_buffer(const Triangulation &t, int num_real, Triangle first = {-1, -1, -1})
{
    std::vector<cq_index> indices;
    auto add = [&](Triangle f) {
        for (int v : f) indices.push_back(static_cast<cq_index>(v));
    };
    auto same = [](Triangle f, Triangle g) {
        return f == g || f == Triangle{g[1], g[2], g[0]} || f == Triangle{g[2], g[0], g[1]};
    };
    if (first[0] >= 0) add(first);
    for (Triangle f : t.triangles())
        if (std::max({f[0], f[1], f[2]}) < num_real && !same(f, first)) add(f);
    return indices;
}

// All faces of a mesh, vertex v as number[v]; real vertices first, then the virtual ones. An empty triangulation if two
// faces claim one directed edge, or a vertex is out of range.
inline Triangulation triangulation_of(const cq_mesh &m, const std::vector<int> &number)
{
    Triangulation t(static_cast<int>(number.size()));
    size_t faces = 0;
    bool in_range = true;
    auto vertex = [&](cq_index v) {
        size_t k = v < m.num_vertices ? v : size_t(v) - m.first_virtual + m.num_vertices;
        in_range = in_range && k < number.size() && (v < m.num_vertices || v >= m.first_virtual);
        return in_range ? number[k] : 0;
    };
    auto add = [&](uint32_t first, uint32_t count) {
        for (uint32_t f = first; f < first + count; ++f) {
            if (m.origin[3 * f] == CQ_NONE) continue;
            int a = vertex(m.origin[3 * f]), b = vertex(m.origin[3 * f + 1]), c = vertex(m.origin[3 * f + 2]);
            if (in_range && a != b && b != c && c != a) t.put(a, b, c);
            faces++;
        }
    };
    add(0, m.num_faces);
    add(m.first_virtual_face, m.num_virtual_faces);
    return in_range && t.triangles().size() == faces ? t : Triangulation();
}

inline std::vector<int> identity(int n)
{
    std::vector<int> number;
    for (int k = 0; k < n; ++k) number.push_back(k);
    return number;
}

#endif
