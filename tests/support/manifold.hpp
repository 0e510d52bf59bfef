// Random oriented manifolds from a recipe of numbers, so that RapidCheck can shrink them: any genus, any number of
// components and of boundary loops. Closed meshes grow by vertex splits, edge flips and tubes; then faces and stars are
// cut out as long as each vertex keeps one fan. Everything works on a plain list of faces.
#ifndef CQ_TESTS_MANIFOLD_HPP
#define CQ_TESTS_MANIFOLD_HPP

#include <algorithm>
#include <ostream>

#include "surface.hpp"

struct Recipe {
    std::vector<uint32_t> parts;   // what to start with; at least one is made
    std::vector<uint32_t> growth;  // splits, flips, tubes
    std::vector<uint32_t> cuts;    // holes
    uint32_t seed;                 // numbering, values
};

inline std::ostream &operator<<(std::ostream &out, const Recipe &r)
{
    auto list = [&](const char *what, const std::vector<uint32_t> &numbers) {
        out << what << " {";
        for (uint32_t n : numbers) out << n << "u, ";
        out << "} ";
    };
    list("parts", r.parts);
    list("growth", r.growth);
    list("cuts", r.cuts);
    return out << "seed " << r.seed;
}

// splitmix64
struct Random {
    uint64_t state;
    uint64_t operator()() {
        uint64_t z = (state += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    uint32_t below(size_t n) { return static_cast<uint32_t>((*this)() % n); }
};

class Sculptor {
public:
    std::vector<Face> faces;
    uint32_t num_vertices = 0;

    explicit Sculptor(const Recipe &recipe) {
        add_part(recipe.parts.empty() ? 0 : recipe.parts[0]);
        for (size_t k = 1; k < recipe.parts.size(); ++k) add_part(recipe.parts[k]);
        for (uint32_t number : recipe.growth) grow(number);
        for (uint32_t number : recipe.cuts) cut(number);
        shuffle(recipe.seed);
    }

private:
    std::map<Edge, size_t> face_at;   // while growing: the face on the left of an edge

    void put(Face f) {
        for (size_t k = 0; k < 3; ++k) face_at[{f[k], f[(k + 1) % 3]}] = faces.size();
        faces.push_back(f);
    }
    void replace(size_t at, Face f) {
        faces[at] = f;
        for (size_t k = 0; k < 3; ++k) face_at[{f[k], f[(k + 1) % 3]}] = at;
    }
    uint32_t opposite(uint32_t a, uint32_t b) const {
        const Face &f = faces[face_at.at({a, b})];
        for (size_t k = 0; k < 3; ++k)
            if (f[k] == a) return f[(k + 2) % 3];
        return a;
    }
    bool has_edge(uint32_t a, uint32_t b) const { return face_at.count({a, b}) != 0; }

    // Neighbours of v, counter-clockwise.
    std::vector<uint32_t> ring(uint32_t v) const {
        std::vector<uint32_t> r;
        uint32_t start = face_at.lower_bound({v, 0})->first.second, at = start;
        do {
            r.push_back(at);
            at = opposite(v, at);
        } while (at != start);
        return r;
    }

    void add_part(uint32_t number) {
        uint32_t base = num_vertices;
        auto add = [&](uint32_t vertices, const std::vector<Face> &part) {
            for (Face f : part) put({f[0] + base, f[1] + base, f[2] + base});
            num_vertices += vertices;
        };
        switch (number % 8) {
        case 1: case 2: {   // torus
            uint32_t w = 3 + number / 8 % 3, h = 3 + number / 32 % 3;
            std::vector<Face> part;
            for (uint32_t y = 0; y < h; ++y)
                for (uint32_t x = 0; x < w; ++x) {
                    uint32_t a = y * w + x, b = y * w + (x + 1) % w;
                    uint32_t d = (y + 1) % h * w + x, c = (y + 1) % h * w + (x + 1) % w;
                    part.push_back({a, b, c});
                    part.push_back({a, c, d});
                }
            add(w * h, part);
            break;
        }
        case 3:
            add(6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}});
            break;
        case 4: {           // bipyramid: two vertices of large valence
            uint32_t n = 3 + number / 8 % 40;
            std::vector<Face> part;
            for (uint32_t k = 0; k < n; ++k) {
                part.push_back({k, (k + 1) % n, n});
                part.push_back({(k + 1) % n, k, n + 1});
            }
            add(n + 2, part);
            break;
        }
        case 5:             // two faces back to back
            add(3, {{0, 1, 2}, {2, 1, 0}});
            break;
        default: add(4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}); break;
        }
    }

    // v keeps the neighbours from ring[j] to ring[i], a new vertex takes those from ring[i] to ring[j].
    void split(uint32_t v, size_t from, size_t length) {
        std::vector<uint32_t> r = ring(v);
        size_t n = r.size(), i = from % n, inner = 1 + length % (n - 1);
        uint32_t w = num_vertices++, p = r[i], q = r[(i + inner) % n];
        for (size_t k = 0; k < inner; ++k) {
            uint32_t a = r[(i + k) % n], b = r[(i + k + 1) % n];
            size_t at = face_at.at({v, a});
            face_at.erase({v, a});
            face_at.erase({b, v});
            replace(at, {w, a, b});
        }
        put({v, p, w});
        put({v, w, q});
    }

    void flip(uint32_t a, uint32_t b) {
        uint32_t c = opposite(a, b), d = opposite(b, a);
        if (c == d || has_edge(c, d) || ring(a).size() < 4 || ring(b).size() < 4) return;
        size_t left = face_at.at({a, b}), right = face_at.at({b, a});
        face_at.erase({a, b});
        face_at.erase({b, a});
        replace(left, {c, d, b});
        replace(right, {d, c, a});
    }

    // Removes two faces without common vertices or edges between them and joins the holes: a handle, or one component
    // less.
    void tube(size_t f, size_t g) {
        Face a = faces[f], b = faces[g];
        for (uint32_t v : a)
            for (uint32_t w : b)
                if (v == w || has_edge(v, w)) return;
        for (size_t k = 0; k < 3; ++k) {
            face_at.erase({a[k], a[(k + 1) % 3]});
            face_at.erase({b[k], b[(k + 1) % 3]});
        }
        std::swap(b[1], b[2]);   // b now runs along the hole's border as a does along its own hole
        std::vector<Face> prism;
        for (size_t k = 0; k < 3; ++k) {
            uint32_t a0 = a[k], a1 = a[(k + 1) % 3], b0 = b[k], b1 = b[(k + 1) % 3];
            prism.push_back({a0, a1, b1});
            prism.push_back({a0, b1, b0});
        }
        replace(f, prism[0]);
        replace(g, prism[1]);
        for (size_t k = 2; k < prism.size(); ++k) put(prism[k]);
    }

    void grow(uint32_t number) {
        Random random{number};
        uint32_t kind = random.below(16);
        const Face f = faces[random.below(faces.size())];
        if (kind < 11) {
            uint32_t v = f[random.below(3)];
            split(v, random.below(1000), random.below(1000));
        } else if (kind < 15) {
            flip(f[0], f[1]);
        } else {
            tube(random.below(faces.size()), random.below(faces.size()));
        }
    }

    bool fans_are_good(const std::set<uint32_t> &vertices) const {
        for (uint32_t v : vertices) {
            std::map<uint32_t, uint32_t> link;
            for (const Face &f : faces)
                for (size_t k = 0; k < 3; ++k)
                    if (f[k] == v) link[f[(k + 1) % 3]] = f[(k + 2) % 3];
            if (link.empty() || !is_one_fan(link)) return false;
        }
        return true;
    }

    // Takes a face, a star of a vertex or a patch of both out, unless a vertex would lose its one fan.
    void cut(uint32_t number) {
        Random random{number};
        std::vector<Face> before = faces;
        Face f = faces[random.below(faces.size())];
        bool star = random.below(2) == 0;
        uint32_t v = f[random.below(3)];
        std::set<uint32_t> touched;
        auto gone = [&](const Face &g) {
            bool hit = star ? std::count(g.begin(), g.end(), v) != 0 : g == f;
            if (hit) touched.insert(g.begin(), g.end());
            return hit;
        };
        std::vector<Face> rest;
        for (const Face &g : faces)
            if (!gone(g)) rest.push_back(g);
        faces = rest;
        if (star) touched.erase(v);
        if (faces.empty() || !fans_are_good(touched)) {
            faces = before;
        } else if (star) {   // the last vertex takes the free number
            num_vertices--;
            for (Face &g : faces)
                for (uint32_t &w : g)
                    if (w == num_vertices) w = v;
        }
    }

    void shuffle(uint32_t seed) {
        Random random{seed};
        std::vector<uint32_t> number(num_vertices);
        std::iota(number.begin(), number.end(), 0u);
        for (size_t k = number.size(); k > 1; --k) std::swap(number[k - 1], number[random.below(k)]);
        for (size_t k = faces.size(); k > 1; --k) std::swap(faces[k - 1], faces[random.below(k)]);
        for (Face &f : faces) {
            for (uint32_t &v : f) v = number[v];
            std::rotate(f.begin(), f.begin() + random.below(3), f.end());
        }
    }
};

#endif
