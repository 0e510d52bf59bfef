// surface.hpp - what CGAL does: reading files, checking meshes, measuring distances. SPDX-License-Identifier: MIT
#ifndef FACE_COLLAPSE_SURFACE_HPP
#define FACE_COLLAPSE_SURFACE_HPP

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/helpers.h>

#include <string>

#include "conquest.hpp"

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;

struct Model_file {
    Mesh mesh;
    std::vector<Position> positions;
};

// nullptr, or why the file is no oriented manifold of triangles.
inline const char *read_file(Model_file &model, const std::string &path)
{
    std::vector<Point> points;
    std::vector<std::vector<size_t>> polygons;
    std::vector<Face> faces;
    if (!CGAL::IO::read_polygon_soup(path, points, polygons)) return "CGAL can't read it";
    for (const auto &p : polygons) {
        if (p.size() != 3) return "not only triangles";
        faces.push_back({static_cast<Vertex>(p[0]), static_cast<Vertex>(p[1]), static_cast<Vertex>(p[2])});
    }
    for (const Point &p : points) model.positions.push_back({p.x(), p.y(), p.z()});
    return faces.empty() ? "no triangles" : close_mesh(model.mesh, points.size(), faces);
}

// Joins the triangles; vertices that have none are left out. False if CGAL can't join them.
inline bool build(Surface &surface, const Mesh &mesh, bool real, const std::vector<Position> &positions)
{
    std::vector<Surface::Vertex_index> vertex(mesh.rings.size());
    for (Vertex v = 0; v < vertex.size(); ++v) {
        if (mesh.rings[v].empty() || (real && mesh.is_virtual[v])) continue;
        Position p = positions.empty() ? Position() : positions[v];
        vertex[v] = surface.add_vertex(Point(p[0], p[1], p[2]));
    }
    for (const Face &f : mesh.faces(real))
        if (surface.add_face(vertex[f[0]], vertex[f[1]], vertex[f[2]]) == Surface::null_face()) return false;
    return true;
}

// What merging keeps.
struct Topology {
    long euler = 0;
    size_t components = 0, loops = 0;
    bool operator==(const Topology &t) const {
        return euler == t.euler && components == t.components && loops == t.loops;
    }
};

inline bool is_manifold(const Surface &s)
{
    std::vector<size_t> degree(s.number_of_vertices());
    for (Surface::Halfedge_index h : s.halfedges()) degree[s.target(h)]++;
    for (Surface::Vertex_index v : s.vertices())
        if (degree[v] == 0 || s.degree(v) != degree[v]) return false;     // one fan
    return CGAL::is_valid_polygon_mesh(s) && CGAL::is_triangle_mesh(s);
}

// nullptr, or what CGAL finds wrong with the closed mesh or with the mesh without its virtual vertices.
inline const char *examine(const Mesh &mesh, Topology &found)
{
    Surface closed, open;
    if (!build(closed, mesh, false, {}) || !build(open, mesh, true, {})) return "CGAL can't join the triangles";
    if (!is_manifold(closed) || !is_manifold(open)) return "no manifold";
    if (!CGAL::is_closed(closed)) return "not closed";
    std::vector<size_t> component(open.number_of_faces());
    found.components = CGAL::Polygon_mesh_processing::connected_components(open, CGAL::make_property_map(component));
    found.euler = static_cast<long>(open.number_of_vertices()) - static_cast<long>(open.number_of_edges())
                + static_cast<long>(open.number_of_faces());
    std::vector<Surface::Halfedge_index> loops;
    CGAL::Polygon_mesh_processing::extract_boundary_cycles(open, std::back_inserter(loops));
    found.loops = loops.size();
    bool is_filled = closed.number_of_vertices() == open.number_of_vertices() + found.loops;
    return is_filled ? nullptr : "other boundary loops than virtual vertices";
}

// -- Distance ---------------------------------------------------------------------------------------------------------

// Root mean square of the distances between two surfaces, from points of either to the other; the larger one.
class Distance {
public:
    explicit Distance(const Mesh &mesh, const std::vector<Position> &positions) : exact(mesh, positions) {}

    double to(const Mesh &mesh, const std::vector<Position> &positions) {
        Side coarse(mesh, positions);
        return std::max(rms(exact.samples, coarse.tree), rms(coarse.samples, exact.tree)) / diagonal();
    }

private:
    using Primitive = CGAL::AABB_face_graph_triangle_primitive<Surface>;
    using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
    enum { SAMPLES = 10000 };

    struct Side {
        Surface surface;
        Tree tree;
        std::vector<Point> samples;

        Side(const Mesh &mesh, const std::vector<Position> &positions) {
            build(surface, mesh, true, positions);
            tree.insert(faces(surface).first, faces(surface).second, surface);
            tree.accelerate_distance_queries();
            sample();
        }

        // Points at equal steps of area, spread in the triangles by a low-discrepancy sequence (Roberts 2018): the same
        // in each run.
        void sample() {
            double step = CGAL::Polygon_mesh_processing::area(surface) / SAMPLES, area = 0;
            for (Surface::Face_index f : surface.faces()) {
                area += CGAL::Polygon_mesh_processing::face_area(f, surface);
                for (; area > (double(samples.size()) + 0.5) * step; samples.push_back(point_in(f, samples.size()))) {}
            }
        }

        Point point_in(Surface::Face_index f, size_t n) const {
            double whole, s = std::modf(double(n) * 0.7548776662466927, &whole);
            double t = std::modf(double(n) * 0.5698402909980532, &whole);
            if (s + t > 1) s = 1 - s, t = 1 - t;
            auto h = surface.halfedge(f);
            const Point &a = surface.point(surface.source(h)), &b = surface.point(surface.target(h)),
                        &c = surface.point(surface.target(surface.next(h)));
            return a + s * (b - a) + t * (c - a);
        }
    };

    Side exact;

    double diagonal() const {
        CGAL::Bbox_3 box = exact.tree.bbox();
        return std::sqrt(CGAL::squared_distance(Point(box.xmin(), box.ymin(), box.zmin()),
                                                Point(box.xmax(), box.ymax(), box.zmax())));
    }

    static double rms(const std::vector<Point> &samples, const Tree &tree) {
        double sum = 0;
        for (const Point &p : samples) sum += tree.squared_distance(p);
        return std::sqrt(sum / static_cast<double>(samples.size()));
    }
};

#endif
