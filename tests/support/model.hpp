// A random mesh with random values and any goal, its stream, and decodings of it: the C helpers with
// owners. Include conquest.h first.
#ifndef CQ_TESTS_MODEL_HPP
#define CQ_TESTS_MODEL_HPP

#include <memory>

#include "codec.h"
#include "property.hpp"

// What the numbers of a channel look like.
enum class Texture { smooth, noise, constant, extreme };

class Model {
public:
    Sculptor mesh;
    cq_input input{};

    explicit Model(const Recipe &recipe, bool with_values = true) : mesh(recipe), random{recipe.seed ^ 0x5eedu} {
        for (const Face &f : mesh.faces)
            for (uint32_t v : f) indices.push_back(static_cast<cq_index>(v));
        input.shape.num_vertices = mesh.num_vertices;
        input.shape.num_faces = static_cast<uint32_t>(mesh.faces.size());
        input.goal = static_cast<cq_goal>(recipe.seed % 2);
        if (with_values)
            for (uint32_t n = random.below(4); n > 0; --n) add_channel();
        own();
    }
    Model(const Model &) = delete;
    Model &operator=(const Model &) = delete;
    ~Model() {
        exact_free(owned);
        for (void *block : owned_values) exact_free(block);
    }

    const std::vector<cq_value> &channel(size_t k) const { return values[k]; }

    // Is a vertex of the boundary where another one is? Then the encoder may close the boundary there.
    bool borders_may_meet() const {
        const std::set<uint32_t> boundary = boundary_vertices();
        for (size_t k = 0; k < values.size(); ++k) {
            const cq_channel &c = input.shape.channel[k];
            if (c.kind != CQ_POSITION || is_per_face(&c)) continue;
            std::map<std::vector<cq_value>, int> vertices_at;
            auto place = [&](uint32_t v) {
                auto at = values[k].begin() + static_cast<ptrdiff_t>(v) * c.components;
                return std::vector<cq_value>(at, at + c.components);
            };
            for (uint32_t v = 0; v < mesh.num_vertices; ++v) vertices_at[place(v)]++;
            for (uint32_t v : boundary)
                if (vertices_at[place(v)] > 1) return true;
        }
        return false;
    }

private:
    Random random;
    std::vector<cq_index> indices;
    std::vector<std::vector<cq_value>> values;
    void *owned = nullptr;              // what input points to: blocks of exactly the sizes
    std::vector<void *> owned_values;

    std::set<uint32_t> boundary_vertices() const {
        std::set<Edge> edges;
        for (const Face &f : mesh.faces)
            for (size_t k = 0; k < 3; ++k) edges.insert({f[k], f[(k + 1) % 3]});
        std::set<uint32_t> vertices;
        for (auto [a, b] : edges)
            if (edges.count({b, a}) == 0) vertices.insert({a, b});
        return vertices;
    }

    void add_channel() {
        cq_channel &c = input.shape.channel[input.shape.num_channels++];
        c.kind = static_cast<uint8_t>(random.below(2) == 0 ? uint32_t(CQ_POSITION) : random.below(CQ_GROUP + 1));
        c.merge = static_cast<uint8_t>(random.below(2) == 0 ? uint32_t(CQ_AVERAGE) : random.below(CQ_PER_FACE + 1));
        c.components = components_of(static_cast<cq_kind>(c.kind));
        if (is_per_face(&c) && c.components != 1) c.kind = CQ_GENERIC, c.components = 1;
        c.bits = static_cast<uint8_t>(1 + random.below(15));
        if (CQ_MAX_BITS > 15 && random.below(4) == 0) c.bits = static_cast<uint8_t>(1 + random.below(CQ_MAX_BITS));
        if (CQ_MAX_BITS > 15 && random.below(4) == 0) c.bits = CQ_EXACT_BITS;
        c.step = static_cast<uint32_t>(random());
        for (uint32_t k = 0; k < c.components; ++k) c.origin[k] = static_cast<uint32_t>(random());
        values.push_back(fill(c, static_cast<Texture>(random.below(4))));
    }

    uint8_t components_of(cq_kind kind) {
        switch (kind) {
        case CQ_POSITION: return 3;
        case CQ_NORMAL: return static_cast<uint8_t>(2 + random.below(2));
        case CQ_TEXCOORD: return 2;
        case CQ_COLOR: return static_cast<uint8_t>(3 + random.below(2));
        case CQ_NUMBER: case CQ_GROUP: return 1;
        default: return static_cast<uint8_t>(1 + random.below(CQ_MAX_COMPONENTS));
        }
    }

    // A float, often near 1, sometimes one of those that arithmetic would not give back.
    uint32_t any_float() {
        static const uint32_t odd[] = {0x80000000u, 0, 0x7fc00000u, 0xffc12345u, 0x7f800001u, 0xff800000u, 0x80000001u};
        return random.below(3) == 0 ? odd[random.below(7)] : 0x3f800000u + (static_cast<uint32_t>(random()) >> 8);
    }

    std::vector<cq_value> fill(const cq_channel &c, Texture texture) {
        uint32_t top = c.bits == CQ_EXACT_BITS ? 0xffffffffu : (uint32_t(1) << c.bits) - 1;
        size_t n = num_owners(&c, mesh.num_vertices, static_cast<uint32_t>(mesh.faces.size()));
        std::vector<int64_t> v(n * c.components);
        for (auto &x : v) {
            x = random() & top;
            if (texture == Texture::constant) x = top / 3;
            if (texture == Texture::extreme) x = random.below(2) == 0 ? 0 : top;
            if (c.bits == CQ_EXACT_BITS && texture == Texture::noise) x = any_float();
        }
        if (is_per_face(&c) && texture == Texture::smooth)      // regions
            for (size_t f = 0; f < n; ++f) v[f] = mesh.faces[f][0] / 7u & top;
        for (int pass = 0; texture == Texture::smooth && !is_per_face(&c) && pass < 8; ++pass)
            for (const Face &f : mesh.faces)
                for (uint32_t k = 0; k < c.components; ++k) {
                    auto at = [&](size_t corner) -> int64_t & { return v[size_t(f[corner]) * c.components + k]; };
                    at(0) = (2 * at(0) + at(1) + at(2)) / 4;
                }
        std::vector<cq_value> result;
        for (int64_t x : v) result.push_back(static_cast<cq_value>(x));
        return result;
    }

    void own() {
        owned = exact_copy(indices.data(), indices.size() * sizeof(cq_index));
        input.indices = static_cast<cq_index *>(owned);
        for (size_t k = 0; k < values.size(); ++k) {
            owned_values.push_back(exact_copy(values[k].data(), values[k].size() * sizeof(cq_value)));
            input.values[k] = static_cast<cq_value *>(owned_values[k]);
        }
    }
};

class Stream {
public:
    coded c;
    explicit Stream(const cq_input &input) { code(&c, &input); }
    // Another mesh than the model's is coded only where its borders meet; properties of the model are not about those.
    explicit Stream(const Model &model) : Stream(model.input, model) {}
    // The same of the model's mesh in another order.
    Stream(const cq_input &input, const Model &model) : Stream(input) {
        cq_shape shape{};
        cq_peek(c.bytes, c.size, &shape, nullptr, nullptr);
        bool other = shape.num_faces != model.input.shape.num_faces || shape.num_vertices != model.input.shape.num_vertices;
        other |= shape.num_rows != 0 || shape.num_aside_rows != 0 || shape.num_aside_faces != 0;
        RC_ASSERT(!other || model.borders_may_meet());
        RC_PRE(!other);
    }
    ~Stream() { uncode(&c); }
    Stream(const Stream &) = delete;
    Stream &operator=(const Stream &) = delete;
    size_t header_size() const {
        cq_shape shape;
        size_t size = 0;
        cq_peek(c.bytes, c.size, &shape, &size, nullptr);
        return size;
    }
};

class Decoding {
public:
    decoding d;
    Decoding(const uint8_t *bytes, size_t size) { decoding_begin(&d, bytes, size); }
    explicit Decoding(const Stream &s) : Decoding(s.c.bytes, s.c.size) {}
    ~Decoding() { decoding_free(&d); }
    Decoding(const Decoding &) = delete;
    Decoding &operator=(const Decoding &) = delete;
    const cq_mesh &mesh() const { return d.decoder->mesh; }
    uint32_t num_vertices() const { return d.decoder->mesh.num_vertices; }
};

// All that a decoder shows, to compare bit for bit.
struct Picture {
    std::vector<uint32_t> numbers;

    explicit Picture(const cq_decoder &d) {
        const cq_mesh &m = d.mesh;
        auto put = [&](const cq_index *from, uint32_t first, uint32_t count) {
            for (uint32_t k = first; k < first + count; ++k) numbers.push_back(from[k]);
        };
        numbers = {m.num_vertices, m.num_faces, m.num_virtual, m.num_virtual_faces};
        if (m.num_vertices == 0) return;
        for (const cq_index *array : {m.origin, m.twin}) {
            put(array, 0, 3u * m.num_faces);
            put(array, 3u * m.first_virtual_face, 3u * m.num_virtual_faces);
        }
        put(m.valence, 0, m.num_vertices);   // out[] may be any of a vertex's halfedges
        put(m.valence, m.first_virtual, m.num_virtual);
        for (uint32_t k = 0; k < d.shape.num_channels; ++k)
            for (uint32_t j = 0; j < num_shown(&d, k); ++j) numbers.push_back(static_cast<uint32_t>(d.channel[k][j]));
    }
    bool operator==(const Picture &p) const { return numbers == p.numbers; }
    bool operator!=(const Picture &p) const { return numbers != p.numbers; }
};

inline bool values_in_range(const cq_decoder &d)
{
    for (uint32_t k = 0; k < d.shape.num_channels; ++k)
        for (uint32_t j = 0; j < num_shown(&d, k); ++j)
            if (!value_is_in_range(&d.shape.channel[k], d.channel[k][j])) return false;
    return true;
}

// A mesh that may be shown: valid, without gaps, its values in range.
inline bool is_presentable(const cq_decoder &d)
{
    const cq_mesh &m = d.mesh;
    if (cq_mesh_check(&m, nullptr) != CQ_OK || (m.num_vertices > 0 && examine(m) != "")) return false;
    for (uint32_t v = 0; v < m.num_vertices; ++v)
        if (m.out[v] == CQ_NONE) return false;
    for (uint32_t f = 0; f < m.num_faces; ++f)
        if (!slot_is_used(m, f)) return false;
    return values_in_range(d);
}

// Faces as a set: each starts at its smallest vertex.
inline std::vector<Face> face_set(std::vector<Face> faces)
{
    for (Face &f : faces) std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    std::sort(faces.begin(), faces.end());
    return faces;
}

// Is the decoded mesh the model, vertex v of it being map[v] and face f face_map[f]?
inline bool same_mesh(const Model &model, const cq_index *map, const cq_index *face_map, const cq_decoder &d)
{
    std::vector<Face> mapped = model.mesh.faces, decoded = faces_of(d.mesh);
    for (Face &f : mapped)
        for (uint32_t &v : f) v = map[v];
    if (d.mesh.num_vertices != model.mesh.num_vertices || face_set(mapped) != face_set(decoded)) return false;
    for (size_t f = 0; f < mapped.size(); ++f)
        if (face_set({mapped[f]}) != face_set({decoded[face_map[f]]})) return false;
    for (uint32_t k = 0; k < d.shape.num_channels; ++k) {
        const cq_channel &channel = d.shape.channel[k];
        const cq_index *to = is_per_face(&channel) ? face_map : map;
        for (uint32_t v = 0; v < num_owners(&channel, d.mesh.num_vertices, d.mesh.num_faces); ++v)
            for (uint32_t n = channel.components, j = 0; j < n; ++j)
                if (d.channel[k][to[v] * n + j] != model.channel(k)[v * n + j]) return false;
    }
    return true;
}

inline bool same_mesh(const Model &model, const coded &c, const cq_decoder &d)
{
    return same_mesh(model, c.map, c.face_map, d);
}

#endif
