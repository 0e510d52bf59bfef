// The halfedge mesh against models that know only triangles.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "property.hpp"
#include "triangles.h"

namespace {

// -- A mesh built from faces ------------------------------------------------------------------------------------------

class Mesh {
public:
    cq_mesh m;
    cq_shape shape;
    cq_result result;

    explicit Mesh(const Sculptor &s) {
        triangles t{s.num_vertices, static_cast<uint32_t>(s.faces.size()), nullptr};
        t.indices = static_cast<cq_index *>(exact_alloc(3 * s.faces.size() * sizeof(cq_index)));
        for (size_t k = 0; k < 3 * s.faces.size(); ++k) t.indices[k] = static_cast<cq_index>(s.faces[k / 3][k % 3]);
        result = build(&b, &t);
        triangles_free(&t);
        m = b.mesh;
        shape = b.shape;
    }
    ~Mesh() { unbuild(&b); }
    Mesh(const Mesh &) = delete;
    Mesh &operator=(const Mesh &) = delete;

    uint32_t num_halfedges() const { return 3 * (uint32_t(m.first_virtual_face) + m.max_virtual_faces); }
    uint32_t num_vertex_slots() const { return uint32_t(m.first_virtual) + m.max_virtual; }
    bool is_used(uint32_t h) const { return slot_is_used(m, h / 3); }

    // All of the memory, for "changes nothing".
    std::vector<uint8_t> bytes() const {
        auto *p = static_cast<const uint8_t *>(b.memory);
        return std::vector<uint8_t>(p, p + b.size);
    }

private:
    built b;
};

Face turned(Face f)
{
    std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    return f;
}

// The mesh slot by slot: faces (turned to start at their smallest vertex), valences, heads of the free lists. As no two
// edges join the same vertices this determines the twins, which examine() compares.
struct Slots {
    std::map<uint32_t, Face> faces;
    std::vector<uint32_t> valence;
    std::vector<uint32_t> heads;

    explicit Slots(const Mesh &mesh) {
        const cq_mesh &m = mesh.m;
        for (uint32_t f : used_slots(m, true, true)) faces[f] = turned(slot(m, f));
        for (uint32_t v = 0; v < mesh.num_vertex_slots(); ++v)
            valence.push_back(m.out[v] == CQ_NONE ? CQ_NONE : m.valence[v]);
        heads = {m.free_vertex, m.free_face, m.free_virtual_face, m.num_vertices, m.num_faces,
                 m.num_virtual, m.num_virtual_faces};
    }
    bool operator==(const Slots &s) const { return faces == s.faces && valence == s.valence && heads == s.heads; }
};

// -- Collapse as relabelling ------------------------------------------------------------------------------------------

// The faces after a collapse of B into A: B's name is A, and the faces that had both are gone.
std::map<uint32_t, Face> collapsed(std::map<uint32_t, Face> faces, uint32_t a, uint32_t b)
{
    for (auto it = faces.begin(); it != faces.end();) {
        Face &f = it->second;
        bool has_a = std::count(f.begin(), f.end(), a) != 0;
        for (uint32_t &v : f)
            if (v == b) v = a;
        it = has_a && std::count(f.begin(), f.end(), a) == 2 ? faces.erase(it) : std::next(it);
    }
    for (auto &entry : faces) entry.second = turned(entry.second);
    return faces;
}

std::set<uint32_t> neighbours(const std::map<uint32_t, Face> &faces, uint32_t v)
{
    std::set<uint32_t> n;
    for (const auto &[k, f] : faces)
        if (std::count(f.begin(), f.end(), v)) n.insert(f.begin(), f.end());
    n.erase(v);
    return n;
}

// May B be collapsed into A? Simply does it and looks at what comes out: the closed mesh must still be one, of the
// same topology, without two faces back to back, boundaries apart, and no vertex above the valence.
bool may_collapse(const cq_mesh &m, uint32_t a, uint32_t b, uint32_t max_valence)
{
    if (!is_real_vertex(m, a) || !is_real_vertex(m, b)) return false;
    std::map<uint32_t, Face> faces;
    for (uint32_t f : used_slots(m, true, true)) faces[f] = slot(m, f);
    std::vector<Face> before, after;
    for (const auto &entry : faces) before.push_back(entry.second);
    std::map<uint32_t, Face> result = collapsed(faces, a, b);
    for (const auto &entry : result) after.push_back(entry.second);
    if (before.size() != after.size() + 2) return false;
    if (!examine(after).same_topology(examine(before))) return false;
    std::set<uint32_t> changed = neighbours(result, a);
    if (changed.size() > max_valence) return false;
    changed.insert(a);
    for (uint32_t v : changed) {
        std::set<uint32_t> n = neighbours(result, v);
        auto virtuals = std::count_if(n.begin(), n.end(), [&](uint32_t w) { return is_virtual_vertex(m, w); });
        if (n.size() < 3 || virtuals > (is_virtual_vertex(m, v) ? 0 : 1)) return false;
    }
    return true;
}

// -- Random operations ------------------------------------------------------------------------------------------------

uint32_t random_used_halfedge(const Mesh &mesh, Random &random)
{
    std::vector<uint32_t> slots = used_slots(mesh.m, true, true);
    return 3 * slots[random.below(slots.size())] + random.below(3);
}

// The end of a random halfedge that can be collapsed, of the first 30 tried; CQ_NONE if there was none.
cq_index random_collapsible(const Mesh &mesh, Random &random)
{
    for (int tries = 0; tries < 30; ++tries) {
        auto h = static_cast<cq_index>(random_used_halfedge(mesh, random));
        if (cq_mesh_can_collapse(&mesh.m, h, CQ_MAX_VALENCE)) return h;
    }
    return CQ_NONE;
}

bool random_collapse(Mesh &mesh, Random &random)
{
    cq_index h = random_collapsible(mesh, random), first, last;
    if (h != CQ_NONE) cq_mesh_collapse(&mesh.m, h, &first, &last);
    return h != CQ_NONE;
}

// Two different spokes of a random vertex.
void random_spokes(const Mesh &mesh, Random &random, cq_index &first, cq_index &last)
{
    first = last = static_cast<cq_index>(random_used_halfedge(mesh, random));
    uint32_t steps = 1 + random.below(mesh.m.valence[mesh.m.origin[first]] - 1u);
    for (; steps > 0; --steps) last = cq_clockwise(&mesh.m, last);
}

// -- Properties -------------------------------------------------------------------------------------------------------

void generated_meshes_are_manifolds()
{
    Recipe recipe = *any_recipe(3.0);
    Sculptor s(recipe);
    Surface surface = examine(s.faces);
    RC_TAG(surface.loops > 0 ? "with boundaries" : "closed");
    RC_ASSERT(surface.error == "");
    RC_ASSERT(surface.vertices == s.num_vertices);
}

void building_counts_what_an_independent_count_finds()
{
    Recipe recipe = *any_recipe(3.0);
    Sculptor s(recipe);
    Mesh mesh(s);
    Surface surface = examine(s.faces);
    RC_ASSERT(mesh.result == CQ_OK);
    RC_ASSERT(mesh.shape.num_boundary_loops == surface.loops);
    RC_ASSERT(mesh.shape.num_boundary_edges == surface.boundary_edges);
    RC_ASSERT(mesh.m.num_virtual == surface.loops);
    RC_ASSERT(faces_of(mesh.m) == s.faces);
    RC_ASSERT(examine(mesh.m) == "");
    RC_ASSERT(cq_mesh_check(&mesh.m, nullptr) == CQ_OK);
    std::vector<cq_index> out(3 * s.faces.size());
    RC_ASSERT(cq_mesh_triangles(&mesh.m, out.data()) == s.faces.size());
    for (size_t k = 0; k < out.size(); ++k) RC_ASSERT(out[k] == s.faces[k / 3][k % 3]);
}

// Any damage to the faces is found exactly when the independent check finds one.
void building_fails_exactly_when_the_faces_are_no_manifold()
{
    Recipe recipe = *any_recipe(0.4);
    auto damage = *any_numbers(0.06);
    Sculptor s(recipe);
    for (uint32_t number : damage) {
        Random random{number};
        Face &f = s.faces[random.below(s.faces.size())];
        switch (random.below(4)) {
        case 0: f[random.below(3)] = random.below(s.num_vertices); break;
        case 1: std::swap(f[0], f[1]); break;
        case 2: s.faces.push_back(f); break;
        default:
            if (s.faces.size() > 1) s.faces.erase(s.faces.begin() + random.below(s.faces.size()));
            break;
        }
    }
    Surface surface = examine(s.faces);
    Mesh mesh(s);
    bool good = surface.error == "" && surface.vertices == s.num_vertices;
    RC_TAG(good ? "still good" : "damaged");
    RC_ASSERT((mesh.result == CQ_OK) == good);
    if (good) RC_ASSERT(examine(mesh.m) == "");
    if (!good) RC_ASSERT(mesh.result <= CQ_ERROR_INDEX && mesh.result >= CQ_ERROR_UNUSED);
}

void an_edge_can_be_collapsed_exactly_when_the_result_is_good()
{
    Recipe recipe = *any_recipe(0.3);
    auto collapses = *rc::gen::inRange(0, 20);
    auto max_valence = *rc::gen::inRange<uint32_t>(3, 40);
    Sculptor s(recipe);
    Mesh mesh(s);
    RC_ASSERT(mesh.result == CQ_OK);
    Random random{recipe.seed};
    for (int k = 0; k < collapses; ++k) random_collapse(mesh, random);
    std::vector<uint32_t> slots = used_slots(mesh.m, true, true);
    for (int k = 0; k < 40; ++k) {
        uint32_t h = 3 * slots[random.below(slots.size())] + random.below(3);
        uint32_t a = mesh.m.origin[h], b = mesh.m.origin[cq_next(static_cast<cq_index>(h))];
        bool can = cq_mesh_can_collapse(&mesh.m, static_cast<cq_index>(h), static_cast<cq_index>(max_valence)) != 0;
        // Ends that are above the limit themselves may be refused even if the merged vertex is not.
        bool above = mesh.m.valence[a] > max_valence || mesh.m.valence[b] > max_valence;
        bool may = may_collapse(mesh.m, a, b, max_valence);
        if (may && !above) RC_ASSERT(can);
        if (can) RC_ASSERT(may);
    }
    RC_ASSERT(examine(mesh.m) == "");
}

void a_collapse_relabels_b_and_takes_two_faces_away()
{
    Recipe recipe = *any_recipe(1.0);
    Sculptor s(recipe);
    Mesh mesh(s);
    Random random{recipe.seed};
    for (int k = 0; k < 10; ++k) {
        cq_index h = random_collapsible(mesh, random), first, last;
        if (h == CQ_NONE) break;
        uint32_t a = mesh.m.origin[h], b = cq_target(&mesh.m, h);
        uint32_t p = mesh.m.origin[cq_prev(h)], q = mesh.m.origin[cq_prev(mesh.m.twin[h])];
        Slots before(mesh);
        cq_mesh_collapse(&mesh.m, h, &first, &last);
        Slots after(mesh);
        RC_ASSERT(after.faces == collapsed(before.faces, a, b));
        RC_ASSERT(mesh.m.out[b] == CQ_NONE);
        RC_ASSERT(mesh.m.origin[first] == a && cq_target(&mesh.m, first) == p);
        RC_ASSERT(mesh.m.origin[last] == a && cq_target(&mesh.m, last) == q);
        RC_ASSERT(mesh.m.valence[a] == before.valence[a] + before.valence[b] - 4);
        RC_ASSERT(examine(mesh.m) == "");
    }
}

void collapses_and_then_splits_in_reverse_restore_every_slot()
{
    Recipe recipe = *any_recipe(2.0);
    Sculptor s(recipe);
    Mesh mesh(s);
    Random random{recipe.seed};
    struct Done {
        uint32_t a, b, p, q;
    };
    std::vector<Done> done;
    std::vector<Slots> states;
    for (int k = 0; k < 40; ++k) {
        cq_index h = random_collapsible(mesh, random), first, last;
        if (h == CQ_NONE) break;
        states.emplace_back(mesh);
        Done d{mesh.m.origin[h], cq_target(&mesh.m, h), mesh.m.origin[cq_prev(h)],
               mesh.m.origin[cq_prev(mesh.m.twin[h])]};
        done.push_back(d);
        cq_mesh_collapse(&mesh.m, h, &first, &last);
    }
    RC_TAG(done.size() > 10 ? "more than 10" : "10 or fewer");
    while (!done.empty()) {
        Done d = done.back();
        cq_index first = find_halfedge(&mesh.m, d.a, d.p), last = find_halfedge(&mesh.m, d.a, d.q);
        RC_ASSERT(cq_mesh_split(&mesh.m, first, last) == d.b);
        RC_ASSERT(Slots(mesh) == states.back());
        RC_ASSERT(cq_mesh_check(&mesh.m, nullptr) == CQ_OK);
        done.pop_back();
        states.pop_back();
    }
    RC_ASSERT(examine(mesh.m) == "");
}

void a_split_and_then_a_collapse_restore_every_slot()
{
    Recipe recipe = *any_recipe(1.0);
    Sculptor s(recipe);
    Mesh mesh(s);
    Random random{recipe.seed};
    int tried = 0;
    for (int k = 0; k < 5; ++k) random_collapse(mesh, random);   // makes room
    for (int k = 0; k < 20; ++k) {
        cq_index first, last;
        random_spokes(mesh, random, first, last);
        uint32_t a = mesh.m.origin[first], p = cq_target(&mesh.m, first), q = cq_target(&mesh.m, last);
        if (mesh.m.valence[p] < 3 || mesh.m.valence[q] < 3) continue;   // of two faces back to back: no way back
        Slots before(mesh);
        std::vector<uint8_t> bytes = mesh.bytes();
        cq_index b = cq_mesh_split(&mesh.m, first, last);
        if (b == CQ_NONE) {
            RC_ASSERT(mesh.bytes() == bytes);
            continue;
        }
        RC_ASSERT(examine(mesh.m) == "");
        cq_index h = find_halfedge(&mesh.m, a, b);
        RC_ASSERT(h != CQ_NONE);
        RC_ASSERT(mesh.m.origin[cq_prev(h)] == p);
        RC_ASSERT(mesh.m.origin[cq_prev(mesh.m.twin[h])] == q);
        RC_ASSERT(cq_mesh_can_collapse(&mesh.m, h, static_cast<cq_index>(1000)));
        cq_mesh_collapse(&mesh.m, h, &first, &last);
        RC_ASSERT(Slots(mesh) == before);
        RC_ASSERT(cq_target(&mesh.m, first) == p && cq_target(&mesh.m, last) == q);
        tried++;
    }
    RC_TAG(tried > 0 ? "split" : "no room");
}

void any_sequence_of_operations_keeps_every_invariant_and_the_topology()
{
    Recipe recipe = *any_recipe(1.0);
    auto operations = *any_numbers(0.6);
    Sculptor s(recipe);
    Mesh mesh(s);
    Surface start = examine(s.faces);
    for (uint32_t number : operations) {
        Random random{number};
        if (random.below(5) < 3) {
            random_collapse(mesh, random);
        } else {
            cq_index first, last;
            random_spokes(mesh, random, first, last);
            cq_mesh_split(&mesh.m, first, last);
        }
        RC_ASSERT(cq_mesh_check(&mesh.m, nullptr) == CQ_OK);
        RC_ASSERT(examine(mesh.m) == "");
        RC_ASSERT(examine(faces_of(mesh.m)).same_topology(start));
    }
}

// One wrong number anywhere: the check finds it exactly when the exhaustive one does.
void the_check_finds_any_single_wrong_number()
{
    Recipe recipe = *any_recipe(0.3);
    Sculptor s(recipe);
    Mesh mesh(s);
    Random random{recipe.seed};
    for (int k = 0; k < 4; ++k) random_collapse(mesh, random);
    for (int k = 0; k < 100; ++k) {
        uint32_t field = random.below(4), x;
        cq_index *array;
        if (field < 2) {
            x = random_used_halfedge(mesh, random);
            array = field == 0 ? mesh.m.origin : mesh.m.twin;
        } else {
            do x = random.below(mesh.num_vertex_slots()); while (mesh.m.out[x] == CQ_NONE);
            array = field == 2 ? mesh.m.out : mesh.m.valence;
        }
        cq_index good = array[x];
        uint32_t limit = field == 0 ? mesh.num_vertex_slots() : field == 3 ? 12 : mesh.num_halfedges();
        uint32_t kind = random.below(8);
        array[x] = static_cast<cq_index>(kind == 0 ? uint32_t(CQ_NONE) : kind == 1 ? good + 1u : random.below(limit));
        bool found = cq_mesh_check(&mesh.m, nullptr) < 0;
        bool wrong = examine(mesh.m) != "";
        array[x] = good;
        RC_ASSERT(found == wrong);
    }
    RC_ASSERT(cq_mesh_check(&mesh.m, nullptr) == CQ_OK);
}

}  // namespace

int main(int argc, char **argv)
{
    Properties property(argc, argv);
    property("generated meshes are manifolds", generated_meshes_are_manifolds);
    property("building counts what an independent count finds", building_counts_what_an_independent_count_finds);
    property("building fails exactly when the faces are no manifold",
             building_fails_exactly_when_the_faces_are_no_manifold);
    property("an edge can be collapsed exactly when the result is good",
             an_edge_can_be_collapsed_exactly_when_the_result_is_good);
    property("a collapse relabels b and takes two faces away", a_collapse_relabels_b_and_takes_two_faces_away);
    property("collapses and then splits in reverse restore every slot",
             collapses_and_then_splits_in_reverse_restore_every_slot);
    property("a split and then a collapse restore every slot", a_split_and_then_a_collapse_restore_every_slot);
    property("any sequence of operations keeps every invariant and the topology",
             any_sequence_of_operations_keeps_every_invariant_and_the_topology);
    property("the check finds any single wrong number", the_check_finds_any_single_wrong_number);
    return property.end();
}
