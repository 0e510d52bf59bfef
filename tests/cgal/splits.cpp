// The decoder's mesh after every single split, and after every step of a regular level that flips edges, against CGAL,
// in two ways that share nothing with the library:
//
//   - a Surface_mesh built from the triangles alone: they can be joined, the surface is closed, each vertex has one fan
//     of triangles, as many as the decoder's valence, Euler's characteristic and the numbers of components and of
//     boundary loops stay;
//   - a Surface_mesh that began as the base mesh and gets the same splits and flips by CGAL's own Euler operators: the
//     same faces.
//
// Small meshes are compared as a whole after each split. Large ones after each split in its neighbourhood, which is all
// triangles at the two vertices and at their neighbours, and as a whole at the end of each level. A split is known by
// what it adds to the triangles: a vertex B, and two faces that B shares with A. CGAL decides what else becomes B's.
// Flips are known by the triangles that have changed: up to three edges between them, one after the other. In the end
// the mesh is the one that was encoded.
//
//     splits SMALL FILE ...
//
// SMALL is the number of vertices up to which all is compared. Files are real meshes, which CGAL reads; random ones, of
// any topology, also with seams of texture coordinates over them, are made here: then the mesh of vertices is compared,
// and each row must lie at the vertices of its corners. The base must be a mesh with each component that arrives.
// A program that was given no file, or split nothing, fails.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <CGAL/boost/graph/helpers.h>

#include <map>
#include <utility>

#include "../support/codec.h"
#include "../support/manifold.hpp"
#include "../support/report.hpp"

namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Vertex = Mesh::Vertex_index;
using Halfedge = Mesh::Halfedge_index;
namespace PMP = CGAL::Polygon_mesh_processing;

// -- A Surface_mesh whose vertices have the decoder's numbers --------------------------------------------------------

class Numbered {
public:
    Mesh mesh;

    Numbered() { number = mesh.add_property_map<Vertex, uint32_t>("v:number", 0).first; }
    Numbered(const Numbered &) = delete;
    Numbered &operator=(const Numbered &) = delete;

    // False if CGAL can't join the face to the others.
    bool add(const Face &f) {
        Vertex v[3];
        for (size_t k = 0; k < 3; ++k) v[k] = find_or_add(f[k]);
        return mesh.add_face(v[0], v[1], v[2]) != Mesh::null_face();
    }
    bool add(const std::vector<Face> &faces) {
        for (const Face &f : faces)
            if (!add(f)) return false;
        return true;
    }

    bool has(uint32_t v) const { return vertices.count(v) != 0; }
    size_t degree(uint32_t v) const { return mesh.degree(vertices.at(v)); }

    // Neighbours of v clockwise from the one with the lowest number.
    std::vector<uint32_t> star(uint32_t v) const {
        std::vector<uint32_t> s;
        for (Vertex w : vertices_around_target(mesh.halfedge(vertices.at(v)), mesh)) s.push_back(number[w]);
        std::rotate(s.begin(), std::min_element(s.begin(), s.end()), s.end());
        return s;
    }

    // The vertex b takes the neighbours of a strictly clockwise between p and q.
    bool split(uint32_t a, uint32_t b, uint32_t p, uint32_t q) {
        Halfedge from_p = mesh.halfedge(vertices.at(p), vertices.at(a));
        Halfedge from_q = mesh.halfedge(vertices.at(q), vertices.at(a));
        if (from_p == Mesh::null_halfedge() || from_q == Mesh::null_halfedge() || has(b)) return false;
        Halfedge before_q = prev(opposite(from_q));   // one spoke counter-clockwise
        if (before_q == from_p) return name(b, mesh.target(CGAL::Euler::add_center_vertex(opposite(from_q), mesh)));
        Halfedge b_to_a = CGAL::Euler::split_vertex(from_p, before_q, mesh), a_to_b = opposite(b_to_a);
        CGAL::Euler::split_face(a_to_b, prev(prev(a_to_b)), mesh);
        CGAL::Euler::split_face(prev(b_to_a), mesh.next(b_to_a), mesh);
        return name(b, mesh.source(b_to_a));
    }

    // The edge between a and b becomes one between the vertices opposite to it.
    bool flip(uint32_t a, uint32_t b) {
        Halfedge h = mesh.halfedge(vertices.at(a), vertices.at(b));
        if (h == Mesh::null_halfedge()) return false;
        Vertex x = mesh.target(mesh.next(h)), y = mesh.target(mesh.next(opposite(h)));
        if (x == y || mesh.halfedge(x, y) != Mesh::null_halfedge()) return false;
        CGAL::Euler::flip_edge(h, mesh);
        return true;
    }

    // All faces, each from its lowest number.
    std::vector<Face> faces() const {
        std::vector<Face> list;
        for (Mesh::Face_index f : mesh.faces()) {
            Face face = {};
            size_t k = 0;
            for (Vertex v : vertices_around_face(mesh.halfedge(f), mesh))
                if (k < 3) face[k++] = number[v];
            list.push_back(face);
        }
        return list;
    }

private:
    Mesh::Property_map<Vertex, uint32_t> number;
    std::map<uint32_t, Vertex> vertices;

    Halfedge opposite(Halfedge h) const { return mesh.opposite(h); }
    Halfedge prev(Halfedge h) const { return mesh.prev(h); }
    bool name(uint32_t n, Vertex v) {
        number[v] = n;
        return vertices.emplace(n, v).second;
    }
    Vertex find_or_add(uint32_t n) {
        auto found = vertices.find(n);
        if (found != vertices.end()) return found->second;
        Vertex v = mesh.add_vertex(Point(0, 0, 0));
        name(n, v);
        return v;
    }
};

std::vector<Face> sorted(std::vector<Face> faces)
{
    for (Face &f : faces) std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    std::sort(faces.begin(), faces.end());
    return faces;
}

// -- The whole mesh --------------------------------------------------------------------------------------------------

// What refinement keeps.
struct Topology {
    long euler = 0;
    size_t components = 0, loops = 0;
    bool operator==(const Topology &t) const {
        return euler == t.euler && components == t.components && loops == t.loops;
    }
};

bool stars_are_fans(const Mesh &mesh)
{
    std::vector<size_t> spokes(mesh.number_of_vertices());
    for (Halfedge h : mesh.halfedges()) spokes[mesh.target(h)]++;
    for (Vertex v : mesh.vertices())
        if (spokes[v] == 0 || mesh.degree(v) != spokes[v]) return false;
    return true;
}

size_t num_components(const Mesh &mesh)
{
    std::vector<size_t> component(mesh.number_of_faces());
    return PMP::connected_components(mesh, CGAL::make_property_map(component));
}

// Real and virtual faces: closed. Real faces alone: as many boundary loops as there are virtual vertices.
const char *examine_whole(const cq_mesh &m, Topology &found)
{
    Numbered closed, open;
    std::vector<Halfedge> loops;
    if (!closed.add(faces_of(m, true, true))) return "CGAL can't join the triangles";
    if (!open.add(faces_of(m))) return "CGAL can't join the real triangles";
    if (!CGAL::is_valid_polygon_mesh(closed.mesh) || !CGAL::is_valid_polygon_mesh(open.mesh)) return "not valid";
    if (!CGAL::is_closed(closed.mesh) || !CGAL::is_triangle_mesh(closed.mesh)) return "not closed";
    if (!stars_are_fans(closed.mesh) || !stars_are_fans(open.mesh)) return "a vertex has more than one fan";
    if (closed.mesh.number_of_vertices() != size_t(m.num_vertices) + m.num_virtual) return "a vertex has no triangle";
    for (uint32_t v = 0; v < m.num_vertices; ++v)
        if (!closed.has(v) || closed.degree(v) != m.valence[v]) return "another valence";
    for (uint32_t v = m.first_virtual; v < uint32_t(m.first_virtual) + m.num_virtual; ++v)
        if (!closed.has(v) || closed.degree(v) != m.valence[v]) return "another valence of a virtual vertex";
    found.euler = long(closed.mesh.number_of_vertices()) - long(closed.mesh.number_of_edges())
                + long(closed.mesh.number_of_faces());
    found.components = num_components(open.mesh);
    PMP::extract_boundary_cycles(open.mesh, std::back_inserter(loops));
    found.loops = loops.size();
    return nullptr;
}

// -- One stream ------------------------------------------------------------------------------------------------------

struct Tally {
    size_t meshes = 0, splits = 0, whole = 0, local = 0, insertions = 0, flips = 0, components = 0, rows = 0;
    uint32_t small = 0;
};

// One split, read from the triangles that it has added.
struct Split {
    uint32_t a = 0, b = 0, p = 0, q = 0;
};

// Rotates a face so that v comes first.
bool begin_with(Face &f, uint32_t v)
{
    std::rotate(f.begin(), std::find(f.begin(), f.end(), v), f.end());
    return f[0] == v;
}

// -- Flips between two lists of faces --------------------------------------------------------------------------------

using Edges = std::vector<Edge>;

enum { MOST_FLIPS = 3 };   // in one step

// The two faces at the edge from corner k of faces[f] to the next one, flipped; false if no other face has it.
bool flip_in(std::vector<Face> &faces, size_t f, size_t k)
{
    uint32_t a = faces[f][k], b = faces[f][(k + 1) % 3], x = faces[f][(k + 2) % 3];
    for (Face &g : faces)
        for (size_t j = 0; j < 3; ++j)
            if (g[j] == b && g[(j + 1) % 3] == a) {
                uint32_t y = g[(j + 2) % 3];
                g = {x, y, b};
                faces[f] = {y, x, a};
                return true;
            }
    return false;
}

// Not more than `most` flips that make `to` of `from`.
bool find_flips(const std::vector<Face> &from, const std::vector<Face> &to, size_t most, Edges &found)
{
    if (sorted(from) == to) return true;
    for (size_t f = 0; most > 0 && f < from.size(); ++f)
        for (size_t k = 0; k < 3; ++k) {
            std::vector<Face> faces = from;
            if (!flip_in(faces, f, k)) continue;
            found.push_back({from[f][k], from[f][(k + 1) % 3]});
            if (find_flips(faces, to, most - 1, found)) return true;
            found.pop_back();
        }
    return false;
}

class Follower {
public:
    Follower(const decoding &d, Tally &t) : mesh(d.decoder->mesh), decoder(*d.decoder), tally(t) {}

    // Called after each step of the decoder: nullptr, or what is wrong.
    const char *step(bool done) {
        const char *error = nullptr;
        if (decoder.level == 0 && !done) return mesh.num_vertices == shown_vertices ? nullptr : show_base();
        if (mesh.num_vertices == 0) return "no mesh";
        if (!begun) error = begin();
        else if (mesh.num_vertices != num_vertices) error = follow();
        else if (decoder.regular.count > 0) error = follow_flips();
        if (!error && (done || decoder.level != level)) error = compare_whole();
        level = decoder.level;
        return error;
    }

    bool ends_as(const std::vector<Face> &faces) const { return sorted(follower_faces(true)) == sorted(faces); }

private:
    const cq_mesh &mesh;
    const cq_decoder &decoder;
    Tally &tally;
    Numbered follower;          // gets CGAL's splits
    Topology topology;          // of the base
    bool begun = false;
    uint32_t shown_vertices = 0;   // of the base
    uint32_t level = 0, num_vertices = 0, num_faces = 0, num_virtual_faces = 0;
    std::vector<cq_index> shown;   // corners of the real faces, in regular levels

    // Another component of the base has arrived.
    const char *show_base() {
        shown_vertices = mesh.num_vertices;
        tally.components++;
        Topology so_far;
        return examine_whole(mesh, so_far);
    }

    const char *begin() {
        begun = true;
        note();
        const char *error = examine_whole(mesh, topology);
        if (error) return error;
        if (topology.loops != mesh.num_virtual) return "other boundary loops than virtual vertices";
        return follower.add(faces_of(mesh, true, true)) ? nullptr : "CGAL can't join the base";
    }

    void note() {
        num_vertices = mesh.num_vertices;
        num_faces = mesh.num_faces;
        num_virtual_faces = mesh.num_virtual_faces;
    }

    const char *follow() {
        Split s;
        if (mesh.num_vertices != num_vertices + 1) return "more than one vertex in a step";
        if (!read_split(s)) return "no split has added these faces";
        if (!follower.split(s.a, s.b, s.p, s.q)) return "CGAL can't split";
        note();
        tally.splits++;
        tally.insertions += decoder.regular.count > 0;
        if (!shown.empty()) show_around({s.a, s.b});
        return mesh.num_vertices <= tally.small ? compare_whole() : compare_around({s.a, s.b});
    }

    // Takes the faces around vertices as they are now.
    void show_around(const std::set<uint32_t> &around) {
        std::set<uint32_t> slots;
        for (uint32_t v : around) collect_star(v, slots);
        shown.resize(3 * size_t(mesh.num_faces), CQ_NONE);
        for (uint32_t f : slots)
            if (f < mesh.num_faces) std::copy_n(mesh.origin + 3 * f, 3, &shown[3 * size_t(f)]);
    }

    // No new vertex: the triangles that have changed, if any, come out of flips.
    const char *follow_flips() {
        const size_t size = 3 * size_t(mesh.num_faces);
        if (shown.size() != size) {   // the level begins
            shown.assign(mesh.origin, mesh.origin + size);
            return nullptr;
        }
        if (std::memcmp(shown.data(), mesh.origin, size * sizeof(cq_index)) == 0) return nullptr;
        std::vector<Face> from, to;
        for (uint32_t f = 0; f < mesh.num_faces; ++f) {
            if (std::equal(&shown[3 * f], &shown[3 * f] + 3, mesh.origin + 3 * f)) continue;
            from.push_back({shown[3 * f], shown[3 * f + 1], shown[3 * f + 2]});
            to.push_back(slot(mesh, f));
            std::copy_n(mesh.origin + 3 * f, 3, &shown[3 * size_t(f)]);
        }
        Edges flips;
        if (!find_flips(from, sorted(to), MOST_FLIPS, flips)) return "no flips have changed these faces";
        for (Edge e : flips)
            if (!follower.flip(e.first, e.second)) return "CGAL can't flip";
        tally.flips += flips.size();
        std::set<uint32_t> corners;
        for (const Face &f : to) corners.insert(f.begin(), f.end());
        return mesh.num_vertices <= tally.small ? compare_whole() : compare_around(corners);
    }

    std::vector<Face> new_faces() const {
        std::vector<Face> added;
        for (uint32_t f = num_faces; f < mesh.num_faces; ++f) added.push_back(slot(mesh, f));
        for (uint32_t k = num_virtual_faces; k < mesh.num_virtual_faces; ++k)
            added.push_back(slot(mesh, mesh.first_virtual_face + k));
        return added;
    }

    // The new faces are A, B, p and B, A, q.
    bool read_split(Split &s) const {
        std::vector<Face> added = new_faces();
        s.b = num_vertices;
        if (added.size() != 2 || !begin_with(added[0], s.b) || !begin_with(added[1], s.b)) return false;
        if (added[0][1] == added[1][2]) std::swap(added[0], added[1]);
        s.a = added[0][2], s.p = added[0][1];
        s.q = added[1][2];
        return added[1][1] == s.a && s.p != s.q;
    }

    std::vector<Face> follower_faces(bool real_only) const {
        std::vector<Face> faces;
        for (const Face &f : follower.faces())
            if (!real_only || *std::max_element(f.begin(), f.end()) < mesh.first_virtual) faces.push_back(f);
        return faces;
    }

    const char *compare_whole() {
        Topology found;
        tally.whole++;
        if (const char *error = examine_whole(mesh, found)) return error;
        if (!(found == topology)) return "another topology";
        if (!rows_lie_at_their_vertices()) return "a row is at two vertices";
        return sorted(follower_faces(false)) == sorted(faces_of(mesh, true, true)) ? nullptr : "CGAL has other faces";
    }

    bool rows_lie_at_their_vertices() const {
        for (size_t h = 0; decoder.vertex && h < 3 * size_t(mesh.num_faces); ++h)
            if (decoder.vertex[decoder.index[h]] != mesh.origin[h]) return false;
        tally.rows += decoder.vertex != nullptr;
        return true;
    }

    // The stars of the vertices and of all their neighbours, from the decoder's triangles.
    const char *compare_around(const std::set<uint32_t> &around_these) {
        std::set<uint32_t> changed = around_these, slots;
        tally.local++;
        for (uint32_t v : around_these)
            for (uint32_t w : follower.star(v)) changed.insert(w);
        for (uint32_t v : changed)
            if (!collect_star(v, slots)) return "the halfedges around a vertex do not close";
        Numbered around;
        for (uint32_t f : slots)
            if (!around.add(slot(mesh, f))) return "CGAL can't join the triangles around the change";
        for (uint32_t v : changed) {
            if (!around.has(v) || around.degree(v) != mesh.valence[v]) return "another valence around the change";
            if (around.star(v) != follower.star(v)) return "CGAL has another star";
        }
        return nullptr;
    }

    bool collect_star(uint32_t v, std::set<uint32_t> &slots) const {
        cq_index h = mesh.out[v];
        for (uint32_t k = 0; k < mesh.valence[v]; ++k, h = cq_clockwise(&mesh, h)) slots.insert(h / 3);
        return h == mesh.out[v];
    }
};

// -- Meshes ----------------------------------------------------------------------------------------------------------

struct Input {
    uint32_t num_vertices = 0;
    std::vector<Face> faces;
    std::vector<cq_value> positions;   // or empty
    std::vector<cq_value> texcoords;   // or empty; then vertices are rows
};

const char *follow(const Input &input, const coded &coded, Tally &tally)
{
    decoding d;
    decoding_begin(&d, coded.bytes, coded.size);
    Follower follower(d, tally);
    cq_bytes in = {coded.bytes, coded.size};
    const char *error = nullptr;
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        if (d.result < 0) error = "not decoded";
        else error = follower.step(d.result == CQ_DONE);
    } while (!error && d.result == CQ_MORE);
    if (!error && d.result != CQ_DONE) error = "not done";
    std::vector<Face> faces = input.faces;
    for (Face &f : faces)
        for (uint32_t &v : f) v = d.decoder->vertex ? d.decoder->vertex[coded.map[v]] : coded.map[v];
    if (!error && !follower.ends_as(faces)) error = "another mesh in the end";
    decoding_free(&d);
    return error;
}

void run(const std::string &what, const Input &input, Tally &tally, Report &report)
{
    std::vector<cq_index> indices;
    for (const Face &f : input.faces)
        for (uint32_t v : f) indices.push_back(static_cast<cq_index>(v));
    cq_input in = {};
    in.shape.num_vertices = input.num_vertices;
    in.shape.num_faces = static_cast<uint32_t>(input.faces.size());
    in.indices = indices.data();
    in.values[0] = input.positions.data();
    in.shape.num_channels = !input.positions.empty();
    in.shape.channel[0].kind = CQ_POSITION;
    in.shape.channel[0].components = 3;
    in.shape.channel[0].bits = 12;
    if (!input.texcoords.empty()) {
        cq_channel &c = in.shape.channel[in.shape.num_channels];
        c.kind = CQ_TEXCOORD;
        c.components = 2;
        c.bits = 12;
        in.values[in.shape.num_channels++] = input.texcoords.data();
    }
    coded coded;
    Report::watch();
    code(&coded, &in);
    const char *error = coded.result == CQ_OK ? follow(input, coded, tally) : cq_result_string(coded.result);
    if (error) report.fail(what + ": " + error);
    uncode(&coded);
    tally.meshes++;
}

// Positions with 12 bits in a cube around all points.
std::vector<cq_value> quantised(const std::vector<Point> &points)
{
    double low[3], size = 0;
    for (int k = 0; k < 3; ++k) {
        auto by = [k](const Point &p, const Point &q) { return p[k] < q[k]; };
        auto ends = std::minmax_element(points.begin(), points.end(), by);
        low[k] = (*ends.first)[k];
        size = std::max(size, (*ends.second)[k] - low[k]);
    }
    std::vector<cq_value> values;
    for (const Point &p : points)
        for (int k = 0; k < 3; ++k)
            values.push_back(static_cast<cq_value>(size > 0 ? (p[k] - low[k]) / size * 4095 : 0));
    return values;
}

std::string counts(const Tally &t)
{
    return std::to_string(t.splits) + " splits, " + std::to_string(t.whole) + " comparisons as a whole, "
         + std::to_string(t.local) + " around a change; in regular levels " + std::to_string(t.insertions)
         + " insertions, " + std::to_string(t.flips) + " flips";
}

void run_file(const std::string &path, uint32_t small, Tally &all, Report &report)
{
    std::vector<Point> points;
    std::vector<std::vector<size_t>> polygons;
    Input input;
    Tally tally;
    tally.small = small;
    report.expect(CGAL::IO::read_polygon_soup(path, points, polygons), "CGAL can't read it");
    for (const auto &polygon : polygons)
        if (report.expect(polygon.size() == 3, "not a triangle"))
            input.faces.push_back({uint32_t(polygon[0]), uint32_t(polygon[1]), uint32_t(polygon[2])});
    input.num_vertices = static_cast<uint32_t>(points.size());
    input.positions = quantised(points);
    run(path, input, tally, report);
    report.expect(tally.splits > 0 || input.num_vertices < 10, "nothing was split");
    all.splits += tally.splits;
    all.insertions += tally.insertions;
    all.flips += tally.flips;
    report.end(path + ": " + counts(tally));
}

Recipe random_recipe(Random &random, size_t growth)
{
    Recipe recipe = {};
    auto add = [&](std::vector<uint32_t> &numbers, size_t n) {
        while (n-- > 0) numbers.push_back(static_cast<uint32_t>(random()));
    };
    add(recipe.parts, 1 + random.below(4));
    add(recipe.growth, random.below(growth));
    add(recipe.cuts, random.below(1 + growth / 8));
    recipe.seed = static_cast<uint32_t>(random());
    return recipe;
}

// A mesh with seams between the charts that its faces belong to: a row for each vertex and chart. Vertices that have no
// position of their own would be glued.
Input with_seams(const Input &mesh, Random &random)
{
    const uint32_t charts = 2 + random.below(3), width = 1 + random.below(9);
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> rows;
    Input out;
    for (Face f : mesh.faces) {
        const uint32_t chart = random.below(12) ? f[0] / width % charts : random.below(charts);
        for (uint32_t &v : f) {
            const auto found = rows.emplace(std::make_pair(v, chart), out.num_vertices);
            if (found.second) {
                out.num_vertices++;
                for (uint32_t x : {v * 31 % 4096, v * 17 % 64 + v / 4096 * 64, v * v % 4096})
                    out.positions.push_back(static_cast<cq_value>(x));
                for (uint32_t x : {chart * 1000 + v * 31 % 900, v * 17 % 4096})
                    out.texcoords.push_back(static_cast<cq_value>(x));
            }
            v = found.first->second;
        }
        out.faces.push_back(f);
    }
    return out;
}

// Of two faces with the same rows one is set aside.
bool has_repeated_faces(const std::vector<Face> &faces)
{
    std::set<std::set<uint32_t>> seen;
    for (const Face &f : faces)
        if (!seen.emplace(f.begin(), f.end()).second) return true;
    return false;
}

void run_seams(size_t meshes, size_t growth, uint32_t small, Tally &all, Report &report)
{
    Random random{growth + 1};
    Tally tally;
    tally.small = small;
    for (size_t k = 0; tally.meshes < meshes && k < 4 * meshes; ++k) {
        Sculptor sculptor(random_recipe(random, growth));
        Input mesh;
        mesh.faces = sculptor.faces;
        if (has_repeated_faces(mesh.faces)) continue;
        run("random mesh " + std::to_string(k) + " with seams", with_seams(mesh, random), tally, report);
    }
    report.expect(tally.meshes == meshes && tally.splits > meshes && tally.rows > meshes, "nothing was split");
    all.meshes += tally.meshes;
    all.splits += tally.splits;
    report.end(std::to_string(meshes) + " random meshes with seams: " + counts(tally));
}

void run_random(size_t meshes, size_t growth, uint32_t small, Tally &all, Report &report)
{
    Random random{growth};
    Tally tally;
    tally.small = small;
    for (size_t k = 0; k < meshes; ++k) {
        Sculptor sculptor(random_recipe(random, growth));
        Input input;
        input.num_vertices = sculptor.num_vertices;
        input.faces = sculptor.faces;
        for (uint32_t n = 0; k % 2 == 1 && n < 3 * input.num_vertices; ++n)
            input.positions.push_back(static_cast<cq_value>(random.below(4096)));
        run("random mesh " + std::to_string(k) + " of up to " + std::to_string(growth) + " operations", input, tally,
            report);
    }
    report.expect(tally.meshes == meshes && tally.splits > meshes, "nothing was split");
    all.meshes += tally.meshes;
    all.splits += tally.splits;
    report.end(std::to_string(meshes) + " random meshes: " + counts(tally));
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    uint32_t small = argc > 1 ? static_cast<uint32_t>(std::atoi(argv[1])) : 0;
    report.expect(small > 0 && argc > 2, "usage: splits SMALL FILE ...");
    report.end(std::to_string(argc - 2) + " files");
    Tally all;
    run_random(300, 100, small, all, report);
    run_random(20, 2000, small, all, report);
    run_seams(150, 100, small, all, report);
    run_seams(5, 2000, small, all, report);
    for (int k = 2; k < argc; ++k) run_file(argv[k], small, all, report);
    report.expect(all.insertions > 0 && all.flips > 0, "no regular level");
    report.end("regular levels: " + std::to_string(all.insertions) + " insertions, " + std::to_string(all.flips)
               + " flips");
    report.end(std::to_string(all.meshes) + " random meshes and " + std::to_string(argc - 2) + " others: "
               + std::to_string(all.splits) + " splits");
    return report.summary();
}
