// All vertex splits and all edge collapses of every triangulation of the sphere of up to 10 vertices, of the torus of
// up to 9 and of the disc of up to 8, against a plain table of triangles that shares no code with the library:
//
//   - a split at each vertex, for all pairs of neighbours p != q, cones over boundaries included: same triangles, a new
//     vertex with the next number, a valid mesh; the collapse of the new edge gives the triangulation back, and the
//     spokes that it returns split it again in the same way;
//   - no split of a cone, and none without room: CQ_NONE, and the same mesh;
//   - cq_mesh_can_collapse for each halfedge: true if and only if the triangles after the collapse are a closed
//     surface; the collapse gives these triangles.
//
// What was run is counted: D (D - 1) splits at each vertex of valence D, and all halfedges. With the argument `all`:
// further sizes, for `make verify`.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "../support/report.hpp"
#include "../support/surface.hpp"
#include "../support/triangles.h"
#include "families.hpp"

namespace {

// A triangulation as a mesh with room for one more vertex, two real faces and one virtual face. Vertices of the
// triangulation from num_real on are the cones; in the mesh they are behind the room.
class RoomyMesh {
public:
    cq_mesh mesh;

    RoomyMesh(const Triangulation &t, int num_real) {
        std::vector<cq_index> indices = index_buffer(t, num_real);
        triangles faces = {static_cast<uint32_t>(num_real), static_cast<uint32_t>(indices.size() / 3), indices.data()};
        built from;
        result = build(&from, &faces);
        if (result == CQ_OK) copy_with_room(from.mesh);
        unbuild(&from);
    }
    RoomyMesh(const RoomyMesh &m)
        : mesh(m.mesh), result(m.result), origin(m.origin), twin(m.twin), out(m.out), valence(m.valence), mark(m.mark) {
        point();
    }
    RoomyMesh &operator=(const RoomyMesh &) = delete;

    bool is_built() const { return result == CQ_OK; }

    // The mesh's number of a vertex of the triangulation before the split.
    cq_index vertex(int v) const {
        uint32_t k = static_cast<uint32_t>(v);
        return cq_index(k < first_cone ? k : k - first_cone + mesh.first_virtual);
    }

private:
    enum { NEW_VERTICES = 1, NEW_FACES = 2, NEW_VIRTUAL_FACES = 1 };
    cq_result result;
    uint32_t first_cone = 0;
    std::vector<cq_index> origin, twin, out, valence;
    std::vector<uint8_t> mark;

    void point() {
        first_cone = mesh.first_virtual - NEW_VERTICES;
        mesh.origin = origin.data();
        mesh.twin = twin.data();
        mesh.out = out.data();
        mesh.valence = valence.data();
        mesh.mark = mark.data();
    }

    void copy_with_room(const cq_mesh &from) {
        mesh = from;
        mesh.first_virtual = static_cast<cq_index>(from.first_virtual + NEW_VERTICES);
        mesh.first_virtual_face = static_cast<cq_index>(from.first_virtual_face + NEW_FACES);
        mesh.max_virtual_faces = static_cast<cq_index>(from.max_virtual_faces + NEW_VIRTUAL_FACES);
        size_t vertices = size_t(mesh.first_virtual) + mesh.max_virtual;
        size_t halfedges = 3 * (size_t(mesh.first_virtual_face) + mesh.max_virtual_faces);
        origin.assign(halfedges, 0), twin.assign(halfedges, 0);
        out.assign(vertices, 0), valence.assign(vertices, 0), mark.assign(vertices, 0);
        auto vertex_of = [&](size_t v) { return v < from.first_virtual ? v : v + NEW_VERTICES; };
        auto halfedge_of = [&](size_t h) { return h < 3u * from.first_virtual_face ? h : h + 3 * NEW_FACES; };
        for (size_t h = 0; h < 3u * (size_t(from.first_virtual_face) + from.max_virtual_faces); ++h) {
            origin[halfedge_of(h)] = static_cast<cq_index>(vertex_of(from.origin[h]));
            twin[halfedge_of(h)] = static_cast<cq_index>(halfedge_of(from.twin[h]));
        }
        for (size_t v = 0; v < size_t(from.first_virtual) + from.max_virtual; ++v) {
            out[vertex_of(v)] = static_cast<cq_index>(halfedge_of(from.out[v]));
            valence[vertex_of(v)] = from.valence[v];
        }
        point();
    }
};

struct Tally {
    size_t splits = 0, collapses = 0, refused = 0, cones = 0;
};

std::string name(const Triangulation &t, const char *what, int a, int p, int q)
{
    std::string text = std::string(what) + ": " + std::to_string(a) + ", " + std::to_string(p) + ", "
                     + std::to_string(q) + " of";
    for (Triangle f : t.triangles())
        text += " " + std::to_string(f[0]) + "-" + std::to_string(f[1]) + "-" + std::to_string(f[2]);
    return text;
}

// Numbers of the mesh's vertices in the triangulation: those of before; behind the cones those of splits.
std::vector<int> numbers(const RoomyMesh &m, int num_real, int num_before)
{
    std::vector<int> number;
    for (int v = 0; v < int(m.mesh.num_vertices); ++v) number.push_back(v < num_real ? v : v - num_real + num_before);
    for (int v = num_real; v < num_before; ++v) number.push_back(v);
    return number;
}

// Same triangles, and all arrays as the manual says.
bool shows(const RoomyMesh &m, int num_real, int num_before, const Triangulation &t)
{
    return triangulation_of(m.mesh, numbers(m, num_real, num_before)) == t && cq_mesh_check(&m.mesh, nullptr) == CQ_OK
        && examine(m.mesh).empty();
}

// The mesh before the split, with the slots of the new vertex and faces free.
bool shows_again(const RoomyMesh &m, int num_real, const Triangulation &before)
{
    Triangulation with_slot = before;
    with_slot.n++;
    return shows(m, num_real, before.n, with_slot);
}

// The split of a between its neighbours p and q can't be made: a is virtual, or there is no room.
bool refuses(RoomyMesh &m, cq_index a, cq_index p, cq_index q)
{
    return cq_mesh_split(&m.mesh, find_halfedge(&m.mesh, a, p), find_halfedge(&m.mesh, a, q)) == CQ_NONE;
}

const char *try_split(const RoomyMesh &from, const Triangulation &t, int num_real, int a, int p, int q)
{
    RoomyMesh m = from;
    Triangulation after = t;
    after.split(a, p, q);
    uint32_t va = m.vertex(a), vp = m.vertex(p), vq = m.vertex(q);
    cq_index b = cq_mesh_split(&m.mesh, find_halfedge(&m.mesh, va, vp), find_halfedge(&m.mesh, va, vq)), first, last;
    if (b != cq_index(num_real)) return "the new vertex has another number";
    if (!shows(m, num_real, t.n, after)) return "another mesh after the split";
    if (!refuses(m, va, vp, b)) return "a full mesh is split";
    cq_index h = find_halfedge(&m.mesh, va, b), merged = cq_index(t.degree(a));
    if (!cq_mesh_can_collapse(&m.mesh, h, CQ_MAX_VALENCE)) return "the new edge can't be collapsed";
    if (cq_mesh_can_collapse(&m.mesh, h, cq_index(merged - 1))) return "the limit of the valence is not kept";
    cq_mesh_collapse(&m.mesh, h, &first, &last);
    if (!shows_again(m, num_real, t)) return "the collapse does not undo the split";
    if (m.mesh.origin[first] != va || cq_target(&m.mesh, first) != vp) return "the first spoke is another one";
    if (m.mesh.origin[last] != va || cq_target(&m.mesh, last) != vq) return "the last spoke is another one";
    if (cq_mesh_split(&m.mesh, first, last) != b || !shows(m, num_real, t.n, after)) return "the second split differs";
    return nullptr;
}

// Cones are not split, and the mesh stays.
void no_split_of_cones(const RoomyMesh &from, const Triangulation &t, int num_real, Tally &tally, Report &report)
{
    RoomyMesh m = from;
    for (int a = num_real; a < t.n; ++a)
        for_each_split(t, a, [&](int p, int q) {
            report.expect(refuses(m, m.vertex(a), m.vertex(p), m.vertex(q)), name(t, "a cone is split", a, p, q));
            tally.cones++;
        });
    report.expect(shows(m, num_real, t.n, t), name(t, "a refused split changes the mesh", num_real, 0, 0));
}

size_t all_splits(const RoomyMesh &m, const Triangulation &t, int num_real, Tally &tally, Report &report)
{
    size_t expected = 0;
    Report::watch();
    for (int a = 0; a < num_real; ++a) {
        expected += size_t(t.degree(a)) * (size_t(t.degree(a)) - 1);
        for_each_split(t, a, [&](int p, int q) {
            if (const char *error = try_split(m, t, num_real, a, p, q)) report.fail(name(t, error, a, p, q));
            tally.splits++;
        });
    }
    return expected;
}

// Is there a surface behind the collapse? a stays, hence must be real, and so must b.
bool is_collapsible(const Triangulation &t, int num_real, int a, int b)
{
    if (a >= num_real || b >= num_real) return false;
    Triangulation after = t.collapsed(a, b);
    return after.is_closed_surface(b) && after.triangles().size() + 2 == t.triangles().size();
}

const char *try_collapse(const RoomyMesh &from, const Triangulation &t, int num_real, int a, int b, Tally &tally)
{
    RoomyMesh m = from;
    cq_index h = find_halfedge(&m.mesh, m.vertex(a), m.vertex(b)), first, last;
    int can = cq_mesh_can_collapse(&m.mesh, h, CQ_MAX_VALENCE);
    if ((can != 0) != is_collapsible(t, num_real, a, b)) return "can be collapsed or not?";
    if (!shows(m, num_real, t.n, t)) return "asking changed the mesh";
    ++(can ? tally.collapses : tally.refused);
    if (!can) return nullptr;
    cq_mesh_collapse(&m.mesh, h, &first, &last);
    return shows(m, num_real, t.n, t.collapsed(a, b)) ? nullptr : "another mesh after the collapse";
}

void all_collapses(const RoomyMesh &m, const Triangulation &t, int num_real, Tally &tally, Report &report)
{
    for (int a = 0; a < t.n; ++a)
        for (int b = 0; b < t.n; ++b) {
            if (!t.has_edge(a, b)) continue;
            if (const char *error = try_collapse(m, t, num_real, a, b, tally)) report.fail(name(t, error, a, b, b));
        }
}

void run_family(const Family &family, Report &report)
{
    Catalogue all = family.all();
    Tally tally;
    size_t splits = 0, halfedges = 0;
    report.expect(all.size() == family.known_count(), std::to_string(all.size()) + " found");
    for (const auto &[code, t] : all) {
        int num_real = t.n - family.is_open();
        RoomyMesh m(t, num_real);
        if (!report.expect(m.is_built() && shows(m, num_real, t.n, t), "not built")) continue;
        splits += all_splits(m, t, num_real, tally, report);
        no_split_of_cones(m, t, num_real, tally, report);
        all_collapses(m, t, num_real, tally, report);
        halfedges += 2 * size_t(t.num_edges());
    }
    report.expect(splits > 0 && tally.splits == splits, "not all splits were tried");
    report.expect(!family.is_open() || tally.cones > 0, "no cones were tried");
    report.expect(halfedges > 0 && tally.collapses + tally.refused == halfedges, "not all halfedges were tried");
    report.end(std::to_string(all.size()) + " " + family.name() + ": " + std::to_string(tally.splits) + " splits, "
               + std::to_string(tally.collapses) + " collapses, " + std::to_string(tally.refused) + " refused");
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    bool large = argc > 1 && std::string(argv[1]) == "all";
    for (const Family &family : large ? larger_families() : small_families()) run_family(family, report);
    return report.summary();
}
