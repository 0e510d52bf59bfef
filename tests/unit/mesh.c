/* The halfedge mesh: build and its errors, circulators, link condition, collapse, split, check, triangles. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "test.h"
#include "triangles.h"

/* -- Helpers ------------------------------------------------------------------------------------------------------- */

static int in_use(const cq_mesh *m, uint32_t v)
{
    return m->out[v] != CQ_NONE;
}

/* One past the last face slot, used or free, virtual ones included. */
static uint32_t face_slots(const cq_mesh *m)
{
    return (uint32_t)m->first_virtual_face + m->max_virtual_faces;
}

static uint32_t vertex_slots(const cq_mesh *m)
{
    return (uint32_t)m->first_virtual + m->max_virtual;
}

/* Everything a mesh consists of, to see whether an operation changed or restored it. */
typedef struct snapshot {
    cq_mesh mesh;
    uint8_t *memory;
    size_t size;
} snapshot;

static snapshot snapshot_take(const built *b)
{
    snapshot s;
    s.mesh = b->mesh;
    s.memory = (uint8_t *)exact_copy(b->memory, b->size);
    s.size = b->size;
    return s;
}

static int snapshot_equal(const snapshot *s, const built *b)
{
    const cq_mesh *m = &s->mesh, *n = &b->mesh;
    return memcmp(s->memory, b->memory, s->size) == 0 && m->num_vertices == n->num_vertices
        && m->num_faces == n->num_faces && m->num_virtual == n->num_virtual
        && m->num_virtual_faces == n->num_virtual_faces && m->free_vertex == n->free_vertex
        && m->free_face == n->free_face && m->free_virtual_face == n->free_virtual_face;
}

/* Vertex slots in use on both sides, with the same valence. */
static int same_vertices(const cq_mesh *m, const cq_mesh *n)
{
    uint32_t v;
    for (v = 0; v < vertex_slots(m); ++v)
        if (in_use(m, v) != in_use(n, v) || (in_use(m, v) && m->valence[v] != n->valence[v])) return 0;
    return 1;
}

/* Face slots in use on both sides, with the same vertices in the same cyclic order, and the same neighbours. */
static int same_faces(const cq_mesh *m, const cq_mesh *n)
{
    uint32_t f, k, r;
    for (f = 0; f < face_slots(m); ++f) {
        const cq_index *a = m->origin + 3 * f, *b = n->origin + 3 * f;
        if ((a[0] == CQ_NONE) != (b[0] == CQ_NONE)) return 0;
        if (a[0] == CQ_NONE) continue;
        for (r = 0; r < 2 && b[r] != a[0]; ++r) {}
        for (k = 0; k < 3; ++k)
            if (a[k] != b[(k + r) % 3] || m->twin[3 * f + k] / 3 != n->twin[3 * f + (k + r) % 3] / 3) return 0;
    }
    return 1;
}

/* The mesh is again what it was, slot by slot. Faces may have turned and vertices may point to another halfedge. */
static int snapshot_restored(const snapshot *s, const built *b)
{
    cq_mesh before = s->mesh;
    const uint8_t *old = (const uint8_t *)b->memory;
    before.origin = (cq_index *)(void *)(s->memory + ((uint8_t *)before.origin - old));
    before.twin = (cq_index *)(void *)(s->memory + ((uint8_t *)before.twin - old));
    before.out = (cq_index *)(void *)(s->memory + ((uint8_t *)before.out - old));
    before.valence = (cq_index *)(void *)(s->memory + ((uint8_t *)before.valence - old));
    return before.num_vertices == b->mesh.num_vertices && before.num_faces == b->mesh.num_faces
        && before.free_vertex == b->mesh.free_vertex && before.free_face == b->mesh.free_face
        && before.free_virtual_face == b->mesh.free_virtual_face && same_vertices(&before, &b->mesh)
        && same_faces(&before, &b->mesh) && cq_mesh_check(&b->mesh, NULL) == CQ_OK;
}

static void snapshot_free(snapshot *s)
{
    exact_free(s->memory);
}

/* Builds, checks and frees the triangles; the caller unbuilds. */
static int build_and_check(built *b, triangles t)
{
    cq_result result = build(b, &t);
    cq_place place;
    triangles_free(&t);
    CHECK_EQ(result, CQ_OK);
    if (result != CQ_OK) return 0;
    CHECK_EQ(cq_mesh_check(&b->mesh, &place), CQ_OK);
    return 1;
}

/* The error of a build that must fail, and where. */
static cq_result build_error(triangles t, cq_place *place)
{
    built b;
    cq_result result = build(&b, &t);
    *place = b.place;
    unbuild(&b);
    triangles_free(&t);
    return result;
}

/* Vertices and faces in use, virtual ones included. */
static uint32_t count_vertices(const cq_mesh *m)
{
    uint32_t v, n = 0;
    for (v = 0; v < vertex_slots(m); ++v) n += in_use(m, v) != 0;
    return n;
}

static uint32_t count_faces(const cq_mesh *m)
{
    uint32_t f, n = 0;
    for (f = 0; f < face_slots(m); ++f) n += m->origin[3 * f] != CQ_NONE;
    return n;
}

static int has_face(const cq_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    cq_index h = find_halfedge(m, a, b);
    return h != CQ_NONE && m->origin[cq_prev(h)] == c;
}

static int count_collapsible(const cq_mesh *m, cq_index max_valence)
{
    uint32_t h;
    int count = 0;
    for (h = 0; h < 3 * face_slots(m); ++h)
        if (m->origin[h - h % 3] != CQ_NONE) count += cq_mesh_can_collapse(m, (cq_index)h, max_valence) != 0;
    return count;
}

static int has_edge(const cq_place *p, uint32_t a, uint32_t b)
{
    return (p->vertex == a && p->other == b) || (p->vertex == b && p->other == a);
}

/* -- Build --------------------------------------------------------------------------------------------------------- */

TEST(a_tetrahedron_builds_in_one_try)
{
    built b;
    int v;
    REQUIRE(build_and_check(&b, triangles_tetrahedron()));
    CHECK_EQ(b.tries, 1);
    CHECK_EQ(b.mesh.num_vertices, 4);
    CHECK_EQ(b.mesh.num_faces, 4);
    CHECK_EQ(b.mesh.num_virtual, 0);
    CHECK_EQ(b.mesh.num_virtual_faces, 0);
    CHECK_EQ(b.shape.num_boundary_loops, 0);
    CHECK_EQ(b.shape.num_boundary_edges, 0);
    for (v = 0; v < 4; ++v) CHECK_EQ(b.mesh.valence[v], 3);
    unbuild(&b);
}

TEST(an_octahedron_has_valence_four_everywhere)
{
    built b;
    int v;
    REQUIRE(build_and_check(&b, triangles_octahedron()));
    for (v = 0; v < 6; ++v) CHECK_EQ(b.mesh.valence[v], 4);
    unbuild(&b);
}

TEST(an_icosahedron_has_valence_five_everywhere)
{
    built b;
    int v;
    REQUIRE(build_and_check(&b, triangles_icosahedron()));
    for (v = 0; v < 12; ++v) CHECK_EQ(b.mesh.valence[v], 5);
    unbuild(&b);
}

TEST(a_torus_has_no_boundary_and_valence_six)
{
    built b;
    int v;
    REQUIRE(build_and_check(&b, triangles_torus(4, 5)));
    CHECK_EQ(b.tries, 1);
    CHECK_EQ(b.mesh.num_faces, 40);
    for (v = 0; v < 20; ++v) CHECK_EQ(b.mesh.valence[v], 6);
    unbuild(&b);
}

TEST(two_faces_back_to_back_are_a_closed_mesh)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_pillow()));
    CHECK_EQ(b.shape.num_boundary_loops, 0);
    CHECK_EQ(b.mesh.valence[0], 2);
    CHECK_EQ(count_collapsible(&b.mesh, 100), 0);
    unbuild(&b);
}

TEST(a_single_triangle_is_closed_to_a_tetrahedron)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_single()));
    CHECK_EQ(b.tries, 2);
    CHECK_EQ(b.shape.num_boundary_loops, 1);
    CHECK_EQ(b.shape.num_boundary_edges, 3);
    CHECK_EQ(b.mesh.num_vertices, 3);
    CHECK_EQ(b.mesh.num_faces, 1);
    CHECK_EQ(b.mesh.first_virtual, 3);
    CHECK_EQ(b.mesh.first_virtual_face, 1);
    CHECK_EQ(b.mesh.num_virtual, 1);
    CHECK_EQ(b.mesh.num_virtual_faces, 3);
    CHECK_EQ(b.mesh.valence[0], 3);
    CHECK_EQ(b.mesh.valence[3], 3);
    CHECK(cq_is_virtual(&b.mesh, 3));
    CHECK(!cq_is_virtual(&b.mesh, 2));
    unbuild(&b);
}

TEST(a_disc_has_one_loop_and_one_virtual_vertex)
{
    built b;
    int v;
    REQUIRE(build_and_check(&b, triangles_disc(7)));
    CHECK_EQ(b.shape.num_boundary_loops, 1);
    CHECK_EQ(b.shape.num_boundary_edges, 7);
    CHECK_EQ(b.mesh.valence[0], 7);
    CHECK_EQ(b.mesh.valence[8], 7);
    for (v = 1; v <= 7; ++v) CHECK_EQ(b.mesh.valence[v], 4);
    unbuild(&b);
}

TEST(an_annulus_has_two_loops)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_annulus(5)));
    CHECK_EQ(b.shape.num_boundary_loops, 2);
    CHECK_EQ(b.shape.num_boundary_edges, 10);
    CHECK_EQ(b.mesh.num_virtual, 2);
    CHECK_EQ(b.mesh.num_virtual_faces, 10);
    CHECK_EQ(b.mesh.valence[10], 5);
    CHECK_EQ(b.mesh.valence[11], 5);
    unbuild(&b);
}

TEST(two_components_keep_apart)
{
    built b;
    triangles t = triangles_tetrahedron();
    triangles_append(&t, triangles_disc(3));
    REQUIRE(build_and_check(&b, t));
    CHECK_EQ(b.mesh.num_vertices, 8);
    CHECK_EQ(b.shape.num_boundary_loops, 1);
    CHECK_EQ(b.shape.num_boundary_edges, 3);
    CHECK(find_halfedge(&b.mesh, 0, 4) == CQ_NONE);
    unbuild(&b);
}

TEST(many_components_with_boundaries_count_all_their_loops)
{
    built b;
    triangles t = triangles_annulus(3);
    int k;
    for (k = 0; k < 40; ++k) triangles_append(&t, k % 2 == 0 ? triangles_disc(3) : triangles_annulus(4));
    REQUIRE(build_and_check(&b, t));
    CHECK_EQ(b.shape.num_boundary_loops, 2 + 20 + 40);
    CHECK_EQ(b.shape.num_boundary_edges, 6 + 60 + 160);
    unbuild(&b);
}

TEST(the_halfedges_of_a_built_mesh_start_where_the_indices_say)
{
    built b;
    triangles t = triangles_torus(3, 4), copy = triangles_torus(3, 4);
    uint32_t h;
    REQUIRE(build_and_check(&b, t));
    for (h = 0; h < 3 * copy.num_faces; ++h) CHECK_EQ(b.mesh.origin[h], copy.indices[h]);
    triangles_free(&copy);
    unbuild(&b);
}

TEST(the_triangles_of_a_built_mesh_are_the_indices)
{
    built b;
    triangles t = triangles_sheet(4, 3), copy = triangles_sheet(4, 3);
    cq_index *out = (cq_index *)exact_alloc(3 * copy.num_faces * sizeof(cq_index));
    REQUIRE(build_and_check(&b, t));
    REQUIRE_EQ(cq_mesh_triangles(&b.mesh, out), copy.num_faces);
    CHECK(memcmp(out, copy.indices, 3 * copy.num_faces * sizeof(cq_index)) == 0);
    exact_free(out);
    triangles_free(&copy);
    unbuild(&b);
}

TEST(a_mesh_without_faces_is_refused_or_empty)
{
    built b;
    cq_place place;
    triangles t = triangles_none();
    cq_result result = build(&b, &t);
    CHECK(result == CQ_OK || result == CQ_ERROR_ARGUMENT);
    if (result == CQ_OK) {
        CHECK_EQ(b.mesh.num_vertices, 0);
        CHECK_EQ(b.mesh.num_faces, 0);
        CHECK_EQ(cq_mesh_check(&b.mesh, &place), CQ_OK);
    }
    triangles_free(&t);
    unbuild(&b);
}

TEST(the_place_may_be_null)
{
    static const int faces[] = {0, 1, 7};
    cq_mesh mesh;
    cq_shape shape;
    triangles t = triangles_of(3, 1, faces);
    void *memory = exact_alloc(1000);
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 3;
    shape.num_faces = 1;
    CHECK_EQ(cq_mesh_build(&mesh, &shape, t.indices, memory, 1000, NULL), CQ_ERROR_INDEX);
    t.indices[2] = 2;
    CHECK_EQ(cq_mesh_build(&mesh, &shape, t.indices, memory, 1000, NULL), CQ_OK);
    CHECK_EQ(cq_mesh_check(&mesh, NULL), CQ_OK);
    mesh.valence[0]++;
    CHECK(cq_mesh_check(&mesh, NULL) < 0);
    exact_free(memory);
    triangles_free(&t);
}

/* -- Errors of build ----------------------------------------------------------------------------------------------- */

TEST(an_index_out_of_range_names_the_face_and_the_vertex)
{
    static const int faces[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 1, 3, 2};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(4, 4, faces), &p), CQ_ERROR_INDEX);
    CHECK_EQ(p.face, 2);
    CHECK_EQ(p.vertex, 4);
    CHECK_EQ(p.other, CQ_NONE);
}

TEST(the_largest_index_is_out_of_range_too)
{
    triangles t = triangles_tetrahedron();
    cq_place p;
    t.indices[11] = CQ_NONE;
    CHECK_EQ(build_error(t, &p), CQ_ERROR_INDEX);
    CHECK_EQ(p.face, 3);
}

TEST(every_corner_of_a_face_is_checked_against_the_range)
{
    uint32_t corner;
    for (corner = 0; corner < 12; ++corner) {
        triangles t = triangles_tetrahedron();
        cq_place p;
        t.indices[corner] = 4;
        CHECK_EQ(build_error(t, &p), CQ_ERROR_INDEX);
        CHECK_EQ(p.face, corner / 3);
        CHECK_EQ(p.vertex, 4);
    }
}

TEST(a_face_that_names_a_vertex_twice_is_degenerate)
{
    static const int faces[3][12] = {
        {0, 1, 2, 0, 2, 3, 3, 3, 1, 1, 3, 2},
        {0, 1, 2, 0, 2, 3, 3, 1, 3, 1, 3, 2},
        {0, 1, 2, 0, 2, 3, 1, 3, 3, 1, 3, 2}};
    int k;
    for (k = 0; k < 3; ++k) {
        cq_place p;
        CHECK_EQ(build_error(triangles_of(4, 4, faces[k]), &p), CQ_ERROR_FACE);
        CHECK_EQ(p.face, 2);
        CHECK_EQ(p.vertex, 3);
    }
}

TEST(a_face_of_one_vertex_is_degenerate)
{
    static const int faces[] = {0, 1, 2, 1, 1, 1};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(3, 2, faces), &p), CQ_ERROR_FACE);
    CHECK_EQ(p.face, 1);
    CHECK_EQ(p.vertex, 1);
}

TEST(three_faces_on_an_edge_are_an_error_at_that_edge)
{
    static const int fins[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    int shift, k;
    for (shift = 0; shift < 5; ++shift) {   /* the edge is the first one, the last one, and others */
        int faces[9], a = shift, b = (shift + 1) % 5;
        cq_place p;
        for (k = 0; k < 9; ++k) faces[k] = (fins[k] + shift) % 5;
        CHECK_EQ(build_error(triangles_of(5, 3, faces), &p), CQ_ERROR_EDGE);
        CHECK(p.face < 3);
        CHECK(has_edge(&p, (uint32_t)a, (uint32_t)b));
    }
}

TEST(three_faces_on_an_edge_are_found_in_any_order_and_direction)
{
    /* Every choice of direction for three faces on the edge 2-5 and every place of a fourth face that is innocent. */
    int directions, place_of_fourth;
    for (directions = 0; directions < 8; ++directions) {
        for (place_of_fourth = 0; place_of_fourth < 4; ++place_of_fourth) {
            int faces[12], k, n = 0;
            cq_place p;
            static const int third[] = {0, 1, 3};
            for (k = 0; k < 4; ++k) {
                int *f = faces + 3 * k;
                if (k == place_of_fourth) {
                    f[0] = 4, f[1] = 6, f[2] = 7;
                } else {
                    int forward = directions >> n & 1;
                    f[0] = forward ? 2 : 5, f[1] = forward ? 5 : 2, f[2] = third[n];
                    n++;
                }
            }
            CHECK_EQ(build_error(triangles_of(8, 4, faces), &p), CQ_ERROR_EDGE);
            CHECK((int)p.face < 4 && (int)p.face != place_of_fourth);
            CHECK(has_edge(&p, 2, 5));
        }
    }
}

TEST(four_faces_on_an_edge_are_an_error_even_in_two_good_pairs)
{
    static const int faces[] = {0, 1, 2, 1, 0, 3, 0, 1, 4, 1, 0, 5};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(6, 4, faces), &p), CQ_ERROR_EDGE);
    CHECK(has_edge(&p, 0, 1));
}

TEST(two_faces_that_run_along_an_edge_the_same_way_are_an_error)
{
    static const int faces[] = {0, 1, 2, 0, 1, 3};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(4, 2, faces), &p), CQ_ERROR_ORIENTATION);
    CHECK(p.face < 2);
    CHECK(has_edge(&p, 0, 1));
}

TEST(one_flipped_face_of_a_closed_mesh_is_an_error_of_orientation)
{
    uint32_t flipped;
    for (flipped = 0; flipped < 8; ++flipped) {
        triangles t = triangles_octahedron();
        cq_index *f = t.indices + 3 * flipped, corner = f[1];
        cq_index a = f[0], b = f[1], c = f[2];
        cq_place p;
        f[1] = f[2];
        f[2] = corner;
        CHECK_EQ(build_error(t, &p), CQ_ERROR_ORIENTATION);
        CHECK(p.face < 8);
        CHECK(has_edge(&p, a, b) || has_edge(&p, b, c) || has_edge(&p, c, a));
    }
}

TEST(the_same_face_twice_is_an_error_of_orientation)
{
    static const int faces[] = {0, 1, 2, 1, 2, 0};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(3, 2, faces), &p), CQ_ERROR_ORIENTATION);
}

TEST(a_moebius_strip_is_not_oriented)
{
    uint32_t w;
    for (w = 4; w < 9; ++w) {
        cq_place p;
        CHECK_EQ(build_error(triangles_moebius(w), &p), CQ_ERROR_ORIENTATION);
        CHECK(p.face < 2 * w);
        CHECK(p.vertex < 2 * w && p.other < 2 * w && p.vertex != p.other);
    }
}

TEST(a_klein_bottle_is_not_oriented)
{
    cq_place p;
    CHECK_EQ(build_error(triangles_grid(5, 5, 1, 1, 1), &p), CQ_ERROR_ORIENTATION);
}

TEST(a_bow_tie_vertex_is_an_error_at_that_vertex)
{
    static const int faces[] = {0, 1, 2, 2, 3, 4};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(5, 2, faces), &p), CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 2);
    CHECK_EQ(p.other, CQ_NONE);
}

TEST(two_closed_fans_at_a_vertex_are_an_error_at_that_vertex)
{
    triangles t = triangles_tetrahedron();
    cq_place p;
    uint32_t k;
    triangles_append(&t, triangles_tetrahedron());
    for (k = 12; k < 24; ++k) t.indices[k] = (cq_index)(t.indices[k] == 4 ? 1 : t.indices[k] - 1);  /* vertex 4 is 1 */
    t.num_vertices = 7;
    CHECK_EQ(build_error(t, &p), CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 1);
}

TEST(a_closed_and_an_open_fan_at_a_vertex_are_an_error)
{
    static const int open_last[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2, 3, 4, 5};
    static const int open_first[] = {3, 4, 5, 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    cq_place p;
    CHECK_EQ(build_error(triangles_of(6, 5, open_last), &p), CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 3);
    CHECK_EQ(build_error(triangles_of(6, 5, open_first), &p), CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 3);
}

TEST(a_vertex_without_a_face_is_an_error_at_that_vertex)
{
    uint32_t v;
    for (v = 0; v <= 4; ++v) {
        triangles t = triangles_tetrahedron();
        cq_place p;
        uint32_t k;
        for (k = 0; k < 12; ++k) t.indices[k] = (cq_index)(t.indices[k] + (t.indices[k] >= v));
        t.num_vertices = 5;
        CHECK_EQ(build_error(t, &p), CQ_ERROR_UNUSED);
        CHECK_EQ(p.vertex, v);
        CHECK_EQ(p.other, CQ_NONE);
    }
}

/* -- Memory and arguments of build --------------------------------------------------------------------------------- */

TEST(one_byte_less_memory_is_an_error_and_the_shape_tells_the_need)
{
    triangles t = triangles_annulus(6);
    cq_shape shape;
    cq_mesh mesh;
    cq_place place;
    size_t size, given;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = t.num_vertices;
    shape.num_faces = t.num_faces;
    shape.num_boundary_loops = 2;
    shape.num_boundary_edges = 12;
    size = cq_mesh_bytes(&shape);
    for (given = 0; given < size; ++given) {
        void *memory = exact_alloc(given);
        cq_shape found = shape;
        found.num_boundary_loops = found.num_boundary_edges = 0;
        CHECK_EQ(cq_mesh_build(&mesh, &found, t.indices, memory, given, &place), CQ_ERROR_MEMORY);
        /* Loops can only be counted where the real mesh fits; then the need is told exactly. */
        if (given >= CQ_MESH_BYTES(t.num_vertices, t.num_faces)) {
            CHECK_EQ(found.num_boundary_loops, 2);
            CHECK_EQ(found.num_boundary_edges, 12);
        }
        exact_free(memory);
    }
    triangles_free(&t);
}

TEST(a_second_try_with_the_memory_that_the_shape_asks_for_succeeds)
{
    built b;
    triangles t = triangles_annulus(9);
    triangles_append(&t, triangles_disc(5));
    REQUIRE(build_and_check(&b, t));
    CHECK_EQ(b.tries, 2);
    CHECK_EQ(b.size, CQ_MESH_BYTES(18 + 6 + 3, 18 + 5 + 18 + 5));
    unbuild(&b);
}

/* With 16-bit indices the triangles can be numbered, but not the vertices that close their loops. */
TEST(a_boundary_that_cannot_be_numbered_is_too_large)
{
    enum { LOOSE = 6000 };
    triangles t = triangles_none();
    cq_shape shape;
    cq_mesh mesh;
    size_t size;
    void *memory;
    uint32_t k;
    exact_free(t.indices);
    t.indices = (cq_index *)exact_alloc(3 * LOOSE * sizeof(cq_index));
    for (k = 0; k < 3 * LOOSE; ++k) t.indices[k] = (cq_index)k;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 3 * LOOSE;
    shape.num_faces = LOOSE;
    size = cq_mesh_bytes(&shape);
    CHECK(size > 0);
    memory = exact_alloc(size);
    CHECK_EQ(cq_mesh_build(&mesh, &shape, t.indices, memory, size, NULL),
             CQ_INDEX_BITS == 16 ? CQ_ERROR_TOO_LARGE : CQ_ERROR_MEMORY);
    CHECK_EQ(shape.num_boundary_loops, LOOSE);
    CHECK_EQ(cq_mesh_bytes(&shape) == 0, CQ_INDEX_BITS == 16);
    exact_free(memory);
    triangles_free(&t);
}

TEST(more_memory_than_needed_does_no_harm)
{
    triangles t = triangles_disc(5);
    cq_shape shape;
    cq_mesh mesh;
    cq_place place;
    void *memory = exact_alloc(100000);
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = t.num_vertices;
    shape.num_faces = t.num_faces;
    CHECK_EQ(cq_mesh_build(&mesh, &shape, t.indices, memory, 100000, &place), CQ_OK);
    CHECK_EQ(cq_mesh_check(&mesh, &place), CQ_OK);
    CHECK_EQ(shape.num_boundary_loops, 1);
    CHECK_EQ(shape.num_boundary_edges, 5);
    exact_free(memory);
    triangles_free(&t);
}

TEST(misaligned_memory_is_an_error)
{
    triangles t = triangles_tetrahedron();
    int shift;
    for (shift = 1; shift < 4; ++shift) {
        uint8_t *memory = (uint8_t *)exact_alloc(1000);
        cq_shape shape;
        cq_mesh mesh;
        memset(&shape, 0, sizeof shape);
        shape.num_vertices = 4;
        shape.num_faces = 4;
        CHECK_EQ(cq_mesh_build(&mesh, &shape, t.indices, memory + shift, 1000 - 4, NULL), CQ_ERROR_MEMORY);
        exact_free(memory);
    }
    triangles_free(&t);
}

TEST(null_arguments_of_build_are_an_error)
{
    triangles t = triangles_tetrahedron();
    void *memory = exact_alloc(1000);
    cq_shape shape;
    cq_mesh mesh;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 4;
    shape.num_faces = 4;
    CHECK_EQ(cq_mesh_build(NULL, &shape, t.indices, memory, 1000, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_mesh_build(&mesh, NULL, t.indices, memory, 1000, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_mesh_build(&mesh, &shape, NULL, memory, 1000, NULL), CQ_ERROR_ARGUMENT);
    CHECK(cq_mesh_build(&mesh, &shape, t.indices, NULL, 0, NULL) < 0);
    CHECK(cq_mesh_build(&mesh, &shape, t.indices, NULL, 1000, NULL) < 0);
    exact_free(memory);
    triangles_free(&t);
}

TEST(the_macro_and_the_function_for_mesh_memory_agree)
{
    uint32_t v, f, l, e;
    for (v = 0; v < 40; v += 3) {
        for (f = 0; f < 40; f += 7) {
            for (l = 0; l < 4; ++l) {
                cq_shape shape;
                e = 3 * l;
                memset(&shape, 0, sizeof shape);
                shape.num_vertices = v;
                shape.num_faces = f;
                shape.num_boundary_loops = l;
                shape.num_boundary_edges = e;
                CHECK_EQ(cq_mesh_bytes(&shape) % 4, 0);
                if (v > 0 && f > 0) CHECK_EQ(cq_mesh_bytes(&shape), CQ_MESH_BYTES(v + l, f + e));
            }
        }
    }
}

TEST(counts_that_an_index_cannot_number_are_too_large)
{
    static const struct { uint32_t v, f, l, e; } large[] = {
        {4, 0xffffffffu, 0, 0}, {4, 0x55555556u, 0, 0}, {4, 4, 0xffffffffu, 0},
        {4, 4, 0, 0xffffffffu}, {0x80000000u, 4, 0x80000000u, 0}, {4, 0x40000000u, 0, 0x40000000u},
        {0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu}};
    size_t k;
    for (k = 0; k < sizeof large / sizeof large[0]; ++k) {
        static const cq_index faces[] = {0, 1, 2};
        cq_shape shape;
        cq_mesh mesh;
        void *memory = exact_alloc(64);
        memset(&shape, 0, sizeof shape);
        shape.num_vertices = large[k].v;
        shape.num_faces = large[k].f;
        shape.num_boundary_loops = large[k].l;
        shape.num_boundary_edges = large[k].e;
        CHECK_EQ(cq_mesh_bytes(&shape), 0);
        if (large[k].l == 0 && large[k].e == 0)
            CHECK_EQ(cq_mesh_build(&mesh, &shape, faces, memory, 64, NULL), CQ_ERROR_TOO_LARGE);
        exact_free(memory);
    }
}

#if CQ_INDEX_BITS == 16
TEST(sixteen_bit_meshes_end_at_the_last_halfedge_that_can_be_numbered)
{
    cq_shape shape;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 100;
    shape.num_faces = 21845;   /* 65 535 halfedges, 0 .. 65 534: CQ_NONE is none of them */
    CHECK(cq_mesh_bytes(&shape) > 0);
    shape.num_faces = 21846;
    CHECK_EQ(cq_mesh_bytes(&shape), 0);
    shape.num_faces = 100;
    shape.num_vertices = 65536;
    CHECK_EQ(cq_mesh_bytes(&shape), 0);
}
#endif

/* -- Circulators --------------------------------------------------------------------------------------------------- */

TEST(next_and_previous_stay_in_the_face)
{
    CHECK_EQ(cq_next(0), 1);
    CHECK_EQ(cq_next(1), 2);
    CHECK_EQ(cq_next(2), 0);
    CHECK_EQ(cq_prev(0), 2);
    CHECK_EQ(cq_prev(5), 4);
    CHECK_EQ(cq_next(5), 3);
    CHECK_EQ(cq_prev(cq_next(301)), 301);
}

TEST(counter_clockwise_around_the_pole_of_a_disc_goes_through_its_faces)
{
    built b;
    cq_index h;
    int k;
    REQUIRE(build_and_check(&b, triangles_disc(6)));
    h = find_halfedge(&b.mesh, 0, 1);
    REQUIRE(h != CQ_NONE);
    for (k = 0; k < 6; ++k) {  /* faces (0, 1, 2), (0, 2, 3) ... are counter-clockwise */
        CHECK_EQ(b.mesh.origin[h], 0);
        CHECK_EQ(cq_target(&b.mesh, h), 1 + k);
        CHECK_EQ(cq_clockwise(&b.mesh, cq_counterclockwise(&b.mesh, h)), h);
        h = cq_counterclockwise(&b.mesh, h);
    }
    CHECK_EQ(h, find_halfedge(&b.mesh, 0, 1));
    for (k = 6; k > 0; --k) {
        h = cq_clockwise(&b.mesh, h);
        CHECK_EQ(cq_target(&b.mesh, h), k);
    }
    unbuild(&b);
}

TEST(both_circulators_visit_valence_neighbours_and_come_back)
{
    built b;
    uint32_t v;
    triangles t = triangles_torus(4, 4);
    triangles_append(&t, triangles_annulus(5));
    REQUIRE(build_and_check(&b, t));
    for (v = 0; v < vertex_slots(&b.mesh); ++v) {
        cq_index h = b.mesh.out[v];
        uint32_t n = 0, m = 0;
        CHECK_EQ(b.mesh.origin[h], v);
        do h = cq_clockwise(&b.mesh, h), n++; while (h != b.mesh.out[v] && n < 100);
        do h = cq_counterclockwise(&b.mesh, h), m++; while (h != b.mesh.out[v] && m < 100);
        CHECK_EQ(n, b.mesh.valence[v]);
        CHECK_EQ(m, b.mesh.valence[v]);
    }
    unbuild(&b);
}

/* -- Link condition ------------------------------------------------------------------------------------------------ */

TEST(a_tetrahedron_has_no_edge_to_collapse)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_tetrahedron()));
    CHECK_EQ(count_collapsible(&b.mesh, 100), 0);
    unbuild(&b);
}

TEST(every_edge_of_an_octahedron_can_be_collapsed)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_octahedron()));
    CHECK_EQ(count_collapsible(&b.mesh, 100), 24);
    unbuild(&b);
}

TEST(an_edge_beside_a_vertex_of_valence_three_cannot_be_collapsed)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_bipyramid(3)));   /* poles 3 and 4 of valence 3, equator of valence 4 */
    CHECK(!cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 0, 1), 100));
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 0, 3), 100));
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 3, 0), 100));
    CHECK_EQ(count_collapsible(&b.mesh, 100), 12);
    unbuild(&b);
}

TEST(an_edge_of_a_triangle_that_is_no_face_cannot_be_collapsed)
{
    /* Two octahedra glued along the triangle 0 1 2, which separates them. */
    static const int faces[] = {0, 2, 3, 0, 3, 4, 0, 4, 1, 5, 2, 1, 5, 3, 2, 5, 4, 3, 5, 1, 4,
                                2, 0, 6, 1, 2, 7, 0, 1, 8, 2, 6, 7, 1, 7, 8, 0, 8, 6, 6, 8, 7};
    built b;
    uint32_t k;
    REQUIRE(build_and_check(&b, triangles_of(9, 14, faces)));
    for (k = 0; k < 3; ++k) {
        cq_index h = find_halfedge(&b.mesh, k, (k + 1) % 3);
        REQUIRE(h != CQ_NONE);
        CHECK(!cq_mesh_can_collapse(&b.mesh, h, 100));
        CHECK(!cq_mesh_can_collapse(&b.mesh, b.mesh.twin[h], 100));
    }
    CHECK_EQ(count_collapsible(&b.mesh, 100), 3 * 14 - 6);
    unbuild(&b);
}

TEST(a_three_by_three_torus_has_only_separating_triangles)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_torus(3, 3)));
    CHECK_EQ(count_collapsible(&b.mesh, 100), 0);   /* every edge lies on a ring of length three */
    unbuild(&b);
}

TEST(the_merged_valence_may_reach_the_limit_but_not_pass_it)
{
    built b;
    cq_index h;
    REQUIRE(build_and_check(&b, triangles_torus(5, 5)));   /* 6 + 6 - 4 = 8 */
    h = find_halfedge(&b.mesh, 0, 1);
    CHECK(!cq_mesh_can_collapse(&b.mesh, h, 7));
    CHECK(cq_mesh_can_collapse(&b.mesh, h, 8));
    CHECK(cq_mesh_can_collapse(&b.mesh, h, CQ_MAX_VALENCE));
    CHECK_EQ(count_collapsible(&b.mesh, 7), 0);
    CHECK_EQ(count_collapsible(&b.mesh, 8), 150);
    unbuild(&b);
}

TEST(halfedges_from_or_to_a_virtual_vertex_cannot_be_collapsed)
{
    built b;
    uint32_t h, found = 0;
    REQUIRE(build_and_check(&b, triangles_sheet(5, 5)));
    for (h = 0; h < 3 * face_slots(&b.mesh); ++h) {
        uint32_t from = b.mesh.origin[h], to = cq_target(&b.mesh, (cq_index)h);
        if (!cq_is_virtual(&b.mesh, (cq_index)from) && !cq_is_virtual(&b.mesh, (cq_index)to)) continue;
        CHECK(!cq_mesh_can_collapse(&b.mesh, (cq_index)h, 100));
        found++;
    }
    CHECK_EQ(found, 2 * 16);
    unbuild(&b);
}

TEST(an_inner_edge_between_two_boundary_vertices_cannot_be_collapsed)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_sheet(3, 2)));   /* 0 1 2 below 3 4 5; 1-4 crosses the sheet */
    CHECK(!cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 1, 4), 100));
    CHECK(!cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 4, 1), 100));
    unbuild(&b);
}

TEST(a_boundary_edge_can_be_collapsed_while_the_loop_is_longer_than_three)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_disc(4)));
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 1, 2), 100));
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 2, 1), 100));
    unbuild(&b);
    REQUIRE(build_and_check(&b, triangles_disc(3)));
    CHECK(!cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 1, 2), 100));
    CHECK(!cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 2, 1), 100));
    unbuild(&b);
}

TEST(the_inner_vertex_of_a_disc_can_be_collapsed_into_its_boundary)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_disc(5)));
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 0, 3), 100));
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 3, 0), 100));
    unbuild(&b);
}

TEST(an_edge_that_joins_two_boundaries_cannot_be_collapsed)
{
    built b;
    uint32_t k;
    REQUIRE(build_and_check(&b, triangles_annulus(6)));   /* 0 .. 5 and 6 .. 11 */
    for (k = 0; k < 6; ++k) {
        cq_index h = find_halfedge(&b.mesh, k, 6 + k);
        REQUIRE(h != CQ_NONE);
        CHECK(!cq_mesh_can_collapse(&b.mesh, h, 100));
        CHECK(!cq_mesh_can_collapse(&b.mesh, b.mesh.twin[h], 100));
    }
    CHECK(cq_mesh_can_collapse(&b.mesh, find_halfedge(&b.mesh, 0, 1), 100));
    unbuild(&b);
}

TEST(asking_whether_an_edge_can_be_collapsed_changes_nothing)
{
    built b;
    snapshot s;
    triangles t = triangles_torus(4, 4);
    triangles_append(&t, triangles_annulus(4));
    REQUIRE(build_and_check(&b, t));
    s = snapshot_take(&b);
    (void)count_collapsible(&b.mesh, 100);
    (void)count_collapsible(&b.mesh, 5);
    CHECK(snapshot_equal(&s, &b));
    snapshot_free(&s);
    unbuild(&b);
}

/* -- Collapse and split -------------------------------------------------------------------------------------------- */

TEST(a_collapse_of_an_octahedron_gives_a_bipyramid_over_a_triangle)
{
    built b;
    cq_index h, first, last;
    REQUIRE(build_and_check(&b, triangles_octahedron()));
    h = find_halfedge(&b.mesh, 0, 1);
    /* 0 has 1 2 3 4, 1 has 0 4 5 2; the faces at 0-1 are 0 1 2 and 0 4 1, so 2 lies to the left of 0 -> 1. */
    REQUIRE_EQ(b.mesh.origin[cq_prev(h)], 2);
    cq_mesh_collapse(&b.mesh, h, &first, &last);
    CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    CHECK_EQ(count_vertices(&b.mesh), 5);
    CHECK_EQ(count_faces(&b.mesh), 6);
    CHECK(!in_use(&b.mesh, 1));
    CHECK_EQ(b.mesh.valence[0], 4);
    CHECK_EQ(b.mesh.valence[2], 3);
    CHECK_EQ(b.mesh.valence[4], 3);
    CHECK_EQ(b.mesh.valence[3], 4);
    CHECK_EQ(b.mesh.valence[5], 4);
    CHECK_EQ(b.mesh.origin[first], 0);
    CHECK_EQ(b.mesh.origin[last], 0);
    CHECK_EQ(cq_target(&b.mesh, first), 2);
    CHECK_EQ(cq_target(&b.mesh, last), 4);
    CHECK(has_face(&b.mesh, 0, 2, 3));
    CHECK(has_face(&b.mesh, 0, 3, 4));
    CHECK(has_face(&b.mesh, 5, 2, 0));
    CHECK(has_face(&b.mesh, 5, 0, 4));
    unbuild(&b);
}

TEST(the_ring_after_a_collapse_is_p_then_neighbours_of_b_then_q_clockwise)
{
    built b;
    cq_index h, first, last, k, ring[8], n = 0;
    /* On the 5 x 5 torus the neighbours of v are v+1, v+6, v+5, v-1, v-6, v-5 counter-clockwise, with wrap-around. */
    static const cq_index expected[] = {18, 19, 14, 8, 7, 6, 11, 17};
    REQUIRE(build_and_check(&b, triangles_torus(5, 5)));
    h = find_halfedge(&b.mesh, 12, 13);
    CHECK_EQ(b.mesh.origin[cq_prev(h)], 18);
    cq_mesh_collapse(&b.mesh, h, &first, &last);
    CHECK_EQ(b.mesh.valence[12], 8);
    CHECK_EQ(cq_target(&b.mesh, first), 18);
    CHECK_EQ(cq_target(&b.mesh, last), 7);
    k = first;
    do {
        ring[n++] = cq_target(&b.mesh, k);
        k = cq_clockwise(&b.mesh, k);
    } while (k != first && n < 8);
    CHECK(k == first);
    REQUIRE_EQ(n, 8);
    for (k = 0; k < 8; ++k) CHECK_EQ(ring[k], expected[k]);
    CHECK_EQ(b.mesh.valence[18], 5);
    CHECK_EQ(b.mesh.valence[7], 5);
    CHECK_EQ(b.mesh.valence[19], 6);
    CHECK_EQ(b.mesh.valence[6], 6);
    unbuild(&b);
}

TEST(a_split_undoes_a_collapse_slot_by_slot_at_every_edge)
{
    built b;
    uint32_t h, tried = 0;
    triangles t = triangles_torus(4, 5);
    triangles_append(&t, triangles_sheet(4, 4));
    triangles_append(&t, triangles_octahedron());
    triangles_append(&t, triangles_icosahedron());
    triangles_append(&t, triangles_disc(6));
    REQUIRE(build_and_check(&b, t));
    for (h = 0; h < 3 * face_slots(&b.mesh); ++h) {
        snapshot s;
        cq_index first, last, end;
        if (!cq_mesh_can_collapse(&b.mesh, (cq_index)h, 100)) continue;
        end = cq_target(&b.mesh, (cq_index)h);
        s = snapshot_take(&b);
        cq_mesh_collapse(&b.mesh, (cq_index)h, &first, &last);
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        CHECK_EQ(cq_mesh_split(&b.mesh, first, last), end);
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        CHECK(snapshot_restored(&s, &b));
        snapshot_free(&s);
        tried++;
    }
    CHECK(tried > 150);
    unbuild(&b);
}

TEST(a_collapse_of_a_boundary_edge_shortens_the_loop_by_one)
{
    built b;
    cq_index h, first, last;
    snapshot s;
    int way;
    for (way = 0; way < 2; ++way) {
        REQUIRE(build_and_check(&b, triangles_disc(5)));
        h = way == 0 ? find_halfedge(&b.mesh, 2, 3) : find_halfedge(&b.mesh, 3, 2);
        s = snapshot_take(&b);
        cq_mesh_collapse(&b.mesh, h, &first, &last);
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        CHECK_EQ(count_vertices(&b.mesh), 5 + 1);
        CHECK_EQ(count_faces(&b.mesh), 4 + 4);
        CHECK_EQ(b.mesh.num_virtual, 1);
        CHECK_EQ(b.mesh.valence[6], 4);
        CHECK_EQ(b.mesh.valence[0], 4);
        CHECK_EQ(cq_target(&b.mesh, first), way == 0 ? 0 : 6);
        CHECK_EQ(cq_target(&b.mesh, last), way == 0 ? 6 : 0);
        CHECK_EQ(cq_mesh_split(&b.mesh, first, last), way == 0 ? 3 : 2);
        CHECK(snapshot_restored(&s, &b));
        snapshot_free(&s);
        unbuild(&b);
    }
}

TEST(a_split_of_neighbouring_spokes_makes_a_vertex_of_valence_three)
{
    built b;
    cq_index h, first, last, v;
    REQUIRE(build_and_check(&b, triangles_torus(5, 5)));
    h = find_halfedge(&b.mesh, 0, 1);
    cq_mesh_collapse(&b.mesh, h, &first, &last);
    first = find_halfedge(&b.mesh, 12, 13);
    last = cq_clockwise(&b.mesh, first);
    v = cq_mesh_split(&b.mesh, first, last);
    CHECK_EQ(v, 1);
    CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    CHECK_EQ(b.mesh.valence[1], 3);
    CHECK_EQ(b.mesh.valence[12], 7);
    CHECK_EQ(count_vertices(&b.mesh), 25);
    CHECK_EQ(count_faces(&b.mesh), 50);
    unbuild(&b);
}

TEST(a_split_gives_b_the_spokes_strictly_clockwise_from_first_to_last)
{
    /* For each pair of spokes of a vertex of valence 6: whom do A and B know afterwards? */
    int from, steps;
    for (from = 0; from < 6; ++from) {
        for (steps = 1; steps < 6; ++steps) {
            built b;
            cq_index h, first, last, ring[6], v;
            int k, strictly = steps - 1;
            REQUIRE(build_and_check(&b, triangles_torus(5, 5)));
            cq_mesh_collapse(&b.mesh, find_halfedge(&b.mesh, 0, 1), &first, &last);
            h = find_halfedge(&b.mesh, 18, 19);
            for (k = 0; k < from; ++k) h = cq_clockwise(&b.mesh, h);
            first = last = h;
            for (k = 0; k < 6; ++k) {
                ring[k] = cq_target(&b.mesh, h);
                if (k == steps) last = h;
                h = cq_clockwise(&b.mesh, h);
            }
            v = cq_mesh_split(&b.mesh, first, last);
            REQUIRE_EQ(v, 1);
            REQUIRE_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
            CHECK_EQ(b.mesh.valence[v], strictly + 3);
            CHECK_EQ(b.mesh.valence[18], 6 - strictly + 1);
            for (k = 0; k < 6; ++k) {
                int with_b = k <= steps, with_a = k == 0 || k >= steps;
                CHECK_EQ(find_halfedge(&b.mesh, v, ring[k]) != CQ_NONE, with_b);
                CHECK_EQ(find_halfedge(&b.mesh, 18, ring[k]) != CQ_NONE, with_a);
            }
            CHECK(has_face(&b.mesh, 18, v, ring[0]));       /* p to the left of A -> B */
            CHECK(has_face(&b.mesh, v, 18, ring[steps]));   /* q to the right */
            unbuild(&b);
        }
    }
}

TEST(a_split_of_a_full_mesh_is_refused_and_changes_nothing)
{
    built b;
    snapshot s;
    cq_index first, last;
    REQUIRE(build_and_check(&b, triangles_icosahedron()));
    s = snapshot_take(&b);
    first = b.mesh.out[3];
    last = cq_clockwise(&b.mesh, cq_clockwise(&b.mesh, first));
    CHECK_EQ(cq_mesh_split(&b.mesh, first, last), CQ_NONE);
    CHECK(snapshot_equal(&s, &b));
    snapshot_free(&s);
    unbuild(&b);
}

TEST(a_full_mesh_has_no_new_vertex_and_no_new_face)
{
    built b;
    REQUIRE(build_and_check(&b, triangles_disc(6)));
    CHECK_EQ(cqi_new_vertex(&b.mesh), CQ_NONE);
    CHECK_EQ(cqi_new_virtual(&b.mesh), CQ_NONE);
    CHECK_EQ(cqi_new_face(&b.mesh, 0), CQ_NONE);
    CHECK_EQ(cqi_new_face(&b.mesh, 1), CQ_NONE);
    CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    unbuild(&b);
}

TEST(a_split_of_a_virtual_vertex_is_refused_and_changes_nothing)
{
    built b;
    snapshot s;
    cq_index first, last;
    REQUIRE(build_and_check(&b, triangles_sheet(4, 4)));
    cq_mesh_collapse(&b.mesh, find_halfedge(&b.mesh, 5, 6), &first, &last);
    s = snapshot_take(&b);
    first = b.mesh.out[b.mesh.first_virtual];
    last = cq_clockwise(&b.mesh, cq_clockwise(&b.mesh, first));
    CHECK_EQ(cq_mesh_split(&b.mesh, first, last), CQ_NONE);
    CHECK(snapshot_equal(&s, &b));
    snapshot_free(&s);
    unbuild(&b);
}

TEST(a_split_that_needs_a_virtual_face_is_refused_when_there_is_none)
{
    built b;
    snapshot s;
    cq_index first, last, v;
    REQUIRE(build_and_check(&b, triangles_sheet(4, 4)));
    cq_mesh_collapse(&b.mesh, find_halfedge(&b.mesh, 5, 6), &first, &last);   /* frees two real faces */
    s = snapshot_take(&b);
    v = 0;                                                   /* a corner: one spoke leads to the virtual vertex */
    first = find_halfedge(&b.mesh, v, b.mesh.first_virtual);
    REQUIRE(first != CQ_NONE);
    last = cq_clockwise(&b.mesh, first);
    CHECK_EQ(cq_mesh_split(&b.mesh, first, last), CQ_NONE);
    CHECK(snapshot_equal(&s, &b));
    CHECK_EQ(cq_mesh_split(&b.mesh, last, first), CQ_NONE);
    CHECK(snapshot_equal(&s, &b));
    snapshot_free(&s);
    unbuild(&b);
}

TEST(a_split_that_needs_two_real_faces_is_refused_when_there_is_one)
{
    built b;
    snapshot s;
    cq_index first, last, v;
    REQUIRE(build_and_check(&b, triangles_sheet(4, 4)));
    /* Collapsing a boundary edge frees one real and one virtual face. */
    cq_mesh_collapse(&b.mesh, find_halfedge(&b.mesh, 1, 2), &first, &last);
    REQUIRE_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    s = snapshot_take(&b);
    v = 10;
    first = b.mesh.out[v];
    last = cq_clockwise(&b.mesh, cq_clockwise(&b.mesh, first));
    CHECK_EQ(cq_mesh_split(&b.mesh, first, last), CQ_NONE);
    CHECK(snapshot_equal(&s, &b));
    snapshot_free(&s);
    unbuild(&b);
}

TEST(free_slots_are_marked_and_reused_last_in_first_out)
{
    built b;
    cq_index first[3], last[3], gone[3], faces[3][2];
    snapshot s[3];
    int k;
    REQUIRE(build_and_check(&b, triangles_torus(7, 7)));
    for (k = 0; k < 3; ++k) {
        cq_index h = find_halfedge(&b.mesh, (uint32_t)(2 + 14 * k), (uint32_t)(3 + 14 * k));
        REQUIRE(cq_mesh_can_collapse(&b.mesh, h, CQ_MAX_VALENCE));
        s[k] = snapshot_take(&b);
        gone[k] = cq_target(&b.mesh, h);
        faces[k][0] = (cq_index)(h / 3);
        faces[k][1] = (cq_index)(b.mesh.twin[h] / 3);
        cq_mesh_collapse(&b.mesh, h, &first[k], &last[k]);
        CHECK_EQ(b.mesh.out[gone[k]], CQ_NONE);
        CHECK_EQ(b.mesh.origin[3 * faces[k][0]], CQ_NONE);
        CHECK_EQ(b.mesh.origin[3 * faces[k][1]], CQ_NONE);
        CHECK_EQ(count_vertices(&b.mesh), 49 - 1 - k);
        CHECK_EQ(count_faces(&b.mesh), 98 - 2 - 2 * k);
    }
    for (k = 2; k >= 0; --k) {
        CHECK_EQ(cq_mesh_split(&b.mesh, first[k], last[k]), gone[k]);
        CHECK(b.mesh.origin[3 * faces[k][0]] != CQ_NONE);
        CHECK(b.mesh.origin[3 * faces[k][1]] != CQ_NONE);
        CHECK(snapshot_restored(&s[k], &b));
        snapshot_free(&s[k]);
    }
    unbuild(&b);
}

enum { MAX_COLLAPSES = 200 };

/* What a collapse leaves, to undo it. By vertices: a face that is freed and comes back may start at another corner. */
typedef struct collapsed {
    cq_index a, b, p, q;
} collapsed;

/* Collapses whatever can be collapsed, lowest halfedge first. */
static uint32_t collapse_all(cq_mesh *m, collapsed *done)
{
    uint32_t count = 0, h = 0;
    while (h < 3 * face_slots(m) && count < MAX_COLLAPSES) {
        collapsed *c = &done[count];
        cq_index first, last;
        if (m->origin[h - h % 3] == CQ_NONE || !cq_mesh_can_collapse(m, (cq_index)h, CQ_MAX_VALENCE)) {
            h++;
            continue;
        }
        c->a = m->origin[h];
        c->b = cq_target(m, (cq_index)h);
        cq_mesh_collapse(m, (cq_index)h, &first, &last);
        CHECK_EQ(cq_mesh_check(m, NULL), CQ_OK);
        c->p = cq_target(m, first);
        c->q = cq_target(m, last);
        count++;
        h = 0;
    }
    return count;
}

static int build_three_parts(built *b)
{
    triangles t = triangles_torus(6, 6);
    triangles_append(&t, triangles_sheet(6, 6));
    triangles_append(&t, triangles_icosahedron());
    return build_and_check(b, t);
}

TEST(a_mesh_collapses_to_the_end_and_splits_all_the_way_back)
{
    static collapsed done[MAX_COLLAPSES];
    built b;
    snapshot s;
    uint32_t count;
    REQUIRE(build_three_parts(&b));
    s = snapshot_take(&b);
    count = collapse_all(&b.mesh, done);
    /* What must be left: a torus of at least 7 vertices, a triangle with one loop, a tetrahedron. */
    CHECK(count >= 36 + 36 + 12 - 14 - 8 - 6);
    CHECK_EQ(count_collapsible(&b.mesh, CQ_MAX_VALENCE), 0);
    while (count-- > 0) {
        collapsed *c = &done[count];
        cq_index first = find_halfedge(&b.mesh, c->a, c->p), last = find_halfedge(&b.mesh, c->a, c->q);
        REQUIRE(first != CQ_NONE && last != CQ_NONE);
        CHECK_EQ(cq_mesh_split(&b.mesh, first, last), c->b);
        REQUIRE_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    }
    CHECK(snapshot_restored(&s, &b));
    snapshot_free(&s);
    unbuild(&b);
}

TEST(triangles_come_out_in_slot_order_without_the_gaps)
{
    built b;
    cq_index first, last, *out, gone[2], h;
    uint32_t f, n = 0;
    REQUIRE(build_and_check(&b, triangles_sheet(4, 4)));
    h = find_halfedge(&b.mesh, 5, 6);
    gone[0] = (cq_index)(h / 3);
    gone[1] = (cq_index)(b.mesh.twin[h] / 3);
    cq_mesh_collapse(&b.mesh, h, &first, &last);
    out = (cq_index *)exact_alloc(3 * 16 * sizeof(cq_index));
    REQUIRE_EQ(cq_mesh_triangles(&b.mesh, out), 16);
    for (f = 0; f < 18; ++f) {
        if (f == gone[0] || f == gone[1]) continue;
        CHECK_EQ(out[3 * n], b.mesh.origin[3 * f]);
        CHECK_EQ(out[3 * n + 1], b.mesh.origin[3 * f + 1]);
        CHECK_EQ(out[3 * n + 2], b.mesh.origin[3 * f + 2]);
        n++;
    }
    for (f = 0; f < 48; ++f) CHECK(out[f] < 16 && out[f] != 6);
    exact_free(out);
    unbuild(&b);
}

/* -- The check catches damage -------------------------------------------------------------------------------------- */

enum { DAMAGE_MESHES = 4 };

/* A closed mesh, one with boundaries, and both after collapses, so that there are free slots. */
static int damage_mesh(built *b, int which)
{
    triangles t = which % 2 == 0 ? triangles_octahedron() : triangles_annulus(5);
    cq_index first, last;
    if (!build_and_check(b, t)) return 0;
    if (which >= 2) cq_mesh_collapse(&b->mesh, find_halfedge(&b->mesh, 0, 1), &first, &last);
    return cq_mesh_check(&b->mesh, NULL) == CQ_OK;
}

static int used_face(const cq_mesh *m, uint32_t f)
{
    return m->origin[3 * f] != CQ_NONE;
}

TEST(the_check_catches_any_wrong_origin)
{
    int which;
    for (which = 0; which < DAMAGE_MESHES; ++which) {
        built b;
        uint32_t h, v;
        REQUIRE(damage_mesh(&b, which));
        for (h = 0; h < 3 * face_slots(&b.mesh); ++h) {
            cq_index right = b.mesh.origin[h];
            if (!used_face(&b.mesh, h / 3)) continue;
            for (v = 0; v < vertex_slots(&b.mesh) + 2; ++v) {
                if (v == right) continue;
                b.mesh.origin[h] = (cq_index)v;
                CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            }
            b.mesh.origin[h] = CQ_NONE;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.origin[h] = right;
        }
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        unbuild(&b);
    }
}

TEST(the_check_catches_any_wrong_twin)
{
    int which;
    for (which = 0; which < DAMAGE_MESHES; ++which) {
        built b;
        uint32_t h, wrong;
        REQUIRE(damage_mesh(&b, which));
        for (h = 0; h < 3 * face_slots(&b.mesh); ++h) {
            cq_index right = b.mesh.twin[h];
            if (!used_face(&b.mesh, h / 3)) continue;
            for (wrong = 0; wrong < 3 * face_slots(&b.mesh) + 3; ++wrong) {
                if (wrong == right) continue;
                b.mesh.twin[h] = (cq_index)wrong;
                CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            }
            b.mesh.twin[h] = CQ_NONE;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.twin[h] = right;
        }
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        unbuild(&b);
    }
}

TEST(the_check_catches_two_swapped_twins)
{
    built b;
    uint32_t g, h;
    REQUIRE(damage_mesh(&b, 1));
    for (g = 0; g < 3 * face_slots(&b.mesh); ++g) {
        for (h = g + 1; h < 3 * face_slots(&b.mesh); ++h) {
            cq_index a = b.mesh.twin[g], c = b.mesh.twin[h];
            if (a == h) continue;
            b.mesh.twin[g] = c, b.mesh.twin[c] = (cq_index)g;
            b.mesh.twin[h] = a, b.mesh.twin[a] = (cq_index)h;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.twin[g] = a, b.mesh.twin[a] = (cq_index)g;
            b.mesh.twin[h] = c, b.mesh.twin[c] = (cq_index)h;
        }
    }
    CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    unbuild(&b);
}

TEST(the_check_catches_any_wrong_outgoing_halfedge)
{
    int which;
    for (which = 0; which < DAMAGE_MESHES; ++which) {
        built b;
        uint32_t v, h;
        REQUIRE(damage_mesh(&b, which));
        for (v = 0; v < vertex_slots(&b.mesh); ++v) {
            cq_index right = b.mesh.out[v];
            for (h = 0; h < 3 * face_slots(&b.mesh) + 3; ++h) {
                int inside = h < 3 * face_slots(&b.mesh);
                b.mesh.out[v] = (cq_index)h;
                if (inside && used_face(&b.mesh, h / 3) && b.mesh.origin[h] == v)
                    CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);   /* any of its halfedges will do */
                else
                    CHECK(h == right || cq_mesh_check(&b.mesh, NULL) < 0);
            }
            b.mesh.out[v] = CQ_NONE;
            CHECK(right == CQ_NONE || cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.out[v] = right;
        }
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        unbuild(&b);
    }
}

TEST(the_check_catches_any_wrong_valence)
{
    int which;
    for (which = 0; which < DAMAGE_MESHES; ++which) {
        built b;
        uint32_t v, wrong;
        REQUIRE(damage_mesh(&b, which));
        for (v = 0; v < vertex_slots(&b.mesh); ++v) {
            cq_index right = b.mesh.valence[v];
            if (!in_use(&b.mesh, v)) continue;
            for (wrong = 0; wrong < 12; ++wrong) {
                b.mesh.valence[v] = (cq_index)wrong;
                CHECK(wrong == right || cq_mesh_check(&b.mesh, NULL) < 0);
            }
            b.mesh.valence[v] = CQ_NONE;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.valence[v] = right;
        }
        unbuild(&b);
    }
}

TEST(the_check_names_the_vertex_with_a_wrong_valence)
{
    built b;
    cq_place p;
    REQUIRE(damage_mesh(&b, 0));
    b.mesh.valence[4]++;
    CHECK_EQ(cq_mesh_check(&b.mesh, &p), CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 4);
    b.mesh.valence[4] = (cq_index)(b.mesh.valence[4] - 2);
    CHECK_EQ(cq_mesh_check(&b.mesh, &p), CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 4);
    unbuild(&b);
}

TEST(the_check_catches_a_mark_that_was_left)
{
    built b;
    uint32_t v;
    REQUIRE(damage_mesh(&b, 1));
    for (v = 0; v < vertex_slots(&b.mesh); ++v) {
        b.mesh.mark[v] = 0xff;
        CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
        b.mesh.mark[v] = 0;
    }
    unbuild(&b);
}

TEST(the_check_catches_counts_beyond_the_capacity_and_counts_that_leave_a_slot_out)
{
    int which, k;
    for (which = 0; which < DAMAGE_MESHES; ++which) {
        built b;
        REQUIRE(damage_mesh(&b, which));
        for (k = 0; k < 4; ++k) {
            cq_mesh good = b.mesh;
            cq_index *count[4];
            const cq_index *last_slot[4];
            count[0] = &b.mesh.num_vertices;
            count[1] = &b.mesh.num_faces;
            count[2] = &b.mesh.num_virtual;
            count[3] = &b.mesh.num_virtual_faces;
            last_slot[0] = &b.mesh.out[good.num_vertices - 1];
            last_slot[1] = &b.mesh.origin[3 * (good.num_faces - 1)];
            last_slot[2] = &b.mesh.out[good.first_virtual + good.num_virtual - 1];
            last_slot[3] = &b.mesh.origin[3 * (good.first_virtual_face + good.num_virtual_faces - 1)];
            ++*count[k];
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh = good;
            if (*count[k] == 0 || *last_slot[k] == CQ_NONE) continue;
            --*count[k];
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh = good;
        }
        unbuild(&b);
    }
}

TEST(the_check_survives_numbers_far_out_of_range)
{
    static const uint32_t wild[] = {0x4000u, 0x8000u, 0xfffeu, 0x7fffffffu, 0xfffffffeu};
    size_t k;
    uint32_t x;
    built b;
    REQUIRE(damage_mesh(&b, 3));
    for (k = 0; k < sizeof wild / sizeof wild[0]; ++k) {
        cq_index bad = (cq_index)wild[k], good;
        for (x = 0; x < vertex_slots(&b.mesh); ++x) {
            if (!in_use(&b.mesh, x)) continue;
            good = b.mesh.out[x];
            b.mesh.out[x] = bad;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.out[x] = good;
            good = b.mesh.valence[x];
            b.mesh.valence[x] = bad;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.valence[x] = good;
        }
        for (x = 0; x < 3 * face_slots(&b.mesh); ++x) {
            if (!used_face(&b.mesh, x / 3)) continue;
            good = b.mesh.origin[x];
            b.mesh.origin[x] = bad;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.origin[x] = good;
            good = b.mesh.twin[x];
            b.mesh.twin[x] = bad;
            CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
            b.mesh.twin[x] = good;
        }
    }
    unbuild(&b);
}

/* A closed mesh by hand: `twin` pairs come from the edges, first come first paired, unless given. */
static void check_by_hand(uint32_t num_vertices, uint32_t num_faces, const int *faces, const int *twin,
                          uint32_t num_virtual, uint32_t num_virtual_faces, cq_result *result, cq_place *place)
{
    uint32_t all_faces = num_faces + num_virtual_faces, all = num_vertices + num_virtual, h, g;
    cq_mesh m;
    memset(&m, 0, sizeof m);
    m.origin = (cq_index *)exact_alloc(3 * all_faces * sizeof(cq_index));
    m.twin = (cq_index *)exact_alloc(3 * all_faces * sizeof(cq_index));
    m.out = (cq_index *)exact_alloc(all * sizeof(cq_index));
    m.valence = (cq_index *)exact_alloc(all * sizeof(cq_index));
    m.mark = (uint8_t *)exact_alloc(all);
    m.num_vertices = m.first_virtual = (cq_index)num_vertices;
    m.num_faces = m.first_virtual_face = (cq_index)num_faces;
    m.num_virtual = m.max_virtual = (cq_index)num_virtual;
    m.num_virtual_faces = m.max_virtual_faces = (cq_index)num_virtual_faces;
    m.free_vertex = m.free_face = m.free_virtual_face = CQ_NONE;
    memset(m.mark, 0, all);
    for (h = 0; h < all; ++h) m.valence[h] = 0;
    for (h = 0; h < 3 * all_faces; ++h) {
        m.origin[h] = (cq_index)faces[h];
        m.out[faces[h]] = (cq_index)h;
        m.valence[faces[h]]++;
        m.twin[h] = CQ_NONE;
    }
    for (h = 0; h < 3 * all_faces; ++h) {
        for (g = 0; g < 3 * all_faces && m.twin[h] == CQ_NONE; ++g) {
            int opposite = m.origin[g] == cq_target(&m, (cq_index)h) && m.origin[h] == cq_target(&m, (cq_index)g);
            if (opposite && m.twin[g] == CQ_NONE) m.twin[h] = (cq_index)g, m.twin[g] = (cq_index)h;
        }
    }
    for (h = 0; twin != NULL && h < 3 * all_faces; ++h)
        if (twin[h] >= 0) m.twin[h] = (cq_index)twin[h];
    *result = cq_mesh_check(&m, place);
    exact_free(m.origin);
    exact_free(m.twin);
    exact_free(m.out);
    exact_free(m.valence);
    exact_free(m.mark);
}

TEST(the_check_accepts_a_mesh_made_by_hand)
{
    static const int tetrahedron[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    static const int triangle[] = {0, 1, 2, 1, 0, 3, 2, 1, 3, 0, 2, 3};   /* 3 is virtual */
    cq_result result;
    cq_place p;
    check_by_hand(4, 4, tetrahedron, NULL, 0, 0, &result, &p);
    CHECK_EQ(result, CQ_OK);
    check_by_hand(3, 1, triangle, NULL, 1, 3, &result, &p);
    CHECK_EQ(result, CQ_OK);
}

TEST(the_check_catches_two_fans_at_one_vertex)
{
    /* Two tetrahedra that share vertex 3. */
    static const int faces[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2, 4, 5, 6, 4, 6, 3, 4, 3, 5, 5, 3, 6};
    cq_result result;
    cq_place p;
    check_by_hand(7, 8, faces, NULL, 0, 0, &result, &p);
    CHECK_EQ(result, CQ_ERROR_VERTEX);
    CHECK_EQ(p.vertex, 3);
}

TEST(the_check_catches_a_second_fan_that_the_valence_does_not_count)
{
    built b;
    uint32_t h;
    triangles t = triangles_tetrahedron();
    triangles_append(&t, triangles_tetrahedron());
    REQUIRE(build_and_check(&b, t));
    for (h = 0; h < 24; ++h)
        if (b.mesh.origin[h] == 7) b.mesh.origin[h] = 3;
    b.mesh.out[7] = CQ_NONE;
    CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
    unbuild(&b);
}

TEST(the_check_catches_a_fan_in_a_wrong_order)
{
    /* Of the spokes h0 .. h5 of a vertex, h0, h2 and h4 get each other's twins. Still each twin ends where its halfedge
     * starts, and h0 h3 h4 h1 h2 h5 is one cycle of the right length. */
    built b;
    cq_index h[6], twin[6];
    int k;
    REQUIRE(build_and_check(&b, triangles_torus(5, 5)));
    h[0] = b.mesh.out[12];
    for (k = 1; k < 6; ++k) h[k] = cq_clockwise(&b.mesh, h[k - 1]);
    for (k = 0; k < 6; ++k) twin[k] = b.mesh.twin[h[k]];
    for (k = 0; k < 6; k += 2) b.mesh.twin[h[k]] = twin[(k + 2) % 6];
    CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
    for (k = 0; k < 6; k += 2) b.mesh.twin[h[k]] = twin[k];
    CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
    unbuild(&b);
}

TEST(the_check_catches_two_edges_between_the_same_vertices)
{
    /* Two tetrahedra slit open along 0-1 and sewn to each other: a sphere with two edges 0-1. */
    static const int faces[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2, 0, 1, 4, 0, 4, 5, 0, 5, 1, 1, 5, 4};
    static const int twin[] = {20, -1, -1, -1, -1, -1, -1, -1, 12, -1, -1, -1,
                               8, -1, -1, -1, -1, -1, -1, -1, 0, -1, -1, -1};
    cq_result result;
    cq_place p;
    check_by_hand(6, 8, faces, twin, 0, 0, &result, &p);
    CHECK_EQ(result, CQ_ERROR_EDGE);
    CHECK(has_edge(&p, 0, 1));
}

TEST(the_check_catches_a_vertex_on_two_boundaries)
{
    /* An octahedron of which two vertices, opposite or adjacent, count as virtual. */
    static const int opposite[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
    cq_result result;
    cq_place p;
    check_by_hand(4, 0, opposite, NULL, 2, 8, &result, &p);
    CHECK(result < 0);
}

TEST(the_check_catches_two_virtual_vertices_that_touch)
{
    /* A tetrahedron with two virtual vertices. */
    static const int faces[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    cq_result result;
    cq_place p;
    check_by_hand(2, 0, faces, NULL, 2, 4, &result, &p);
    CHECK(result < 0);
}

TEST(the_check_catches_a_virtual_vertex_in_a_real_face)
{
    /* The single triangle, but its real face and one of the virtual ones have changed places. */
    static const int faces[] = {1, 0, 3, 0, 1, 2, 2, 1, 3, 0, 2, 3};
    cq_result result;
    cq_place p;
    check_by_hand(3, 1, faces, NULL, 1, 3, &result, &p);
    CHECK(result < 0);
}

TEST(the_check_catches_a_halfedge_that_is_its_own_twin)
{
    built b;
    REQUIRE(damage_mesh(&b, 0));
    b.mesh.twin[5] = 5;
    CHECK(cq_mesh_check(&b.mesh, NULL) < 0);
    unbuild(&b);
}

TEST(the_check_of_a_good_mesh_changes_nothing)
{
    int which;
    for (which = 0; which < DAMAGE_MESHES; ++which) {
        built b;
        snapshot s;
        REQUIRE(damage_mesh(&b, which));
        s = snapshot_take(&b);
        CHECK_EQ(cq_mesh_check(&b.mesh, NULL), CQ_OK);
        CHECK(snapshot_equal(&s, &b));
        snapshot_free(&s);
        unbuild(&b);
    }
}

/* After the definition: all four vertices of the two faces are real, both ends keep three neighbours, and the other two
 * are two vertices without an edge. */
static int may_flip(const cq_mesh *m, cq_index h)
{
    const cq_index g = m->twin[h];
    const cq_index a = m->origin[h], b = m->origin[g], x = m->origin[cq_prev(h)], y = m->origin[cq_prev(g)];
    if (cq_is_virtual(m, a) || cq_is_virtual(m, b) || cq_is_virtual(m, x) || cq_is_virtual(m, y)) return 0;
    return m->valence[a] > 3 && m->valence[b] > 3 && x != y && find_halfedge(m, x, y) == CQ_NONE;
}

TEST(an_edge_can_be_flipped_exactly_if_it_is_inside_and_the_result_is_a_mesh)
{
    uint32_t which, h, can = 0, cannot = 0;
    for (which = 0; which < 6; ++which) {
        built b;
        REQUIRE(build_and_check(&b, which == 0   ? triangles_sheet(5, 4)
                                    : which == 1 ? triangles_pillow()
                                    : which == 2 ? triangles_annulus(6)
                                    : which == 3 ? triangles_bipyramid(3)
                                    : which == 4 ? triangles_disc(7)
                                                 : triangles_torus(4, 5)));
        for (h = 0; h < 3 * ((uint32_t)b.mesh.first_virtual_face + b.mesh.num_virtual_faces); ++h) {
            const int may = may_flip(&b.mesh, (cq_index)h);
            CHECK_EQ(cqi_can_flip(&b.mesh, (cq_index)h), may);
            can += may != 0;
            cannot += !may;
        }
        unbuild(&b);
    }
    CHECK(can > 50 && cannot > 50);
}

/* Collapsing a vertex of three neighbours leaves a hub one neighbour less: 13 + 3 - 4. The limit is that of the hub before,
 * too. */
TEST(an_end_of_too_many_neighbours_cannot_be_collapsed)
{
    triangles t = triangles_bipyramid(12);
    triangles more;
    built b;
    int turn;
    more.num_vertices = 15;
    more.num_faces = 26;
    more.indices = (cq_index *)exact_alloc(3 * 26 * sizeof(cq_index));
    memcpy(more.indices, t.indices, 3 * 24 * sizeof(cq_index));
    more.indices[0] = 14, more.indices[1] = 1, more.indices[2] = 12; /* 0 1 12 becomes three faces around 14 */
    more.indices[72] = 0, more.indices[73] = 14, more.indices[74] = 12;
    more.indices[75] = 0, more.indices[76] = 1, more.indices[77] = 14;
    triangles_free(&t);
    REQUIRE(build_and_check(&b, more));
    CHECK_EQ(b.mesh.valence[12], 13);
    for (turn = 0; turn < 2; ++turn) {
        const cq_index h = turn ? find_halfedge(&b.mesh, 12, 14) : find_halfedge(&b.mesh, 14, 12);
        CHECK_EQ(cq_mesh_can_collapse(&b.mesh, h, 13), 1);
        CHECK_EQ(cq_mesh_can_collapse(&b.mesh, h, 12), 0);
        cqi_mark_ring(&b.mesh, b.mesh.origin[h], 1);
        CHECK_EQ(cqi_collapsible(&b.mesh, h, 13, 0), 1);
        CHECK_EQ(cqi_collapsible(&b.mesh, h, 12, 0), 0);
        cqi_mark_ring(&b.mesh, b.mesh.origin[h], 0);
    }
    unbuild(&b);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_tetrahedron_builds_in_one_try);
    RUN(an_octahedron_has_valence_four_everywhere);
    RUN(an_icosahedron_has_valence_five_everywhere);
    RUN(a_torus_has_no_boundary_and_valence_six);
    RUN(two_faces_back_to_back_are_a_closed_mesh);
    RUN(a_single_triangle_is_closed_to_a_tetrahedron);
    RUN(a_disc_has_one_loop_and_one_virtual_vertex);
    RUN(an_annulus_has_two_loops);
    RUN(two_components_keep_apart);
    RUN(many_components_with_boundaries_count_all_their_loops);
    RUN(the_halfedges_of_a_built_mesh_start_where_the_indices_say);
    RUN(the_triangles_of_a_built_mesh_are_the_indices);
    RUN(a_mesh_without_faces_is_refused_or_empty);
    RUN(the_place_may_be_null);
    RUN(an_index_out_of_range_names_the_face_and_the_vertex);
    RUN(the_largest_index_is_out_of_range_too);
    RUN(every_corner_of_a_face_is_checked_against_the_range);
    RUN(a_face_that_names_a_vertex_twice_is_degenerate);
    RUN(a_face_of_one_vertex_is_degenerate);
    RUN(three_faces_on_an_edge_are_an_error_at_that_edge);
    RUN(three_faces_on_an_edge_are_found_in_any_order_and_direction);
    RUN(four_faces_on_an_edge_are_an_error_even_in_two_good_pairs);
    RUN(two_faces_that_run_along_an_edge_the_same_way_are_an_error);
    RUN(one_flipped_face_of_a_closed_mesh_is_an_error_of_orientation);
    RUN(the_same_face_twice_is_an_error_of_orientation);
    RUN(a_moebius_strip_is_not_oriented);
    RUN(a_klein_bottle_is_not_oriented);
    RUN(a_bow_tie_vertex_is_an_error_at_that_vertex);
    RUN(two_closed_fans_at_a_vertex_are_an_error_at_that_vertex);
    RUN(a_closed_and_an_open_fan_at_a_vertex_are_an_error);
    RUN(a_vertex_without_a_face_is_an_error_at_that_vertex);
    RUN(one_byte_less_memory_is_an_error_and_the_shape_tells_the_need);
    RUN(a_second_try_with_the_memory_that_the_shape_asks_for_succeeds);
    RUN(a_boundary_that_cannot_be_numbered_is_too_large);
    RUN(more_memory_than_needed_does_no_harm);
    RUN(misaligned_memory_is_an_error);
    RUN(null_arguments_of_build_are_an_error);
    RUN(the_macro_and_the_function_for_mesh_memory_agree);
    RUN(counts_that_an_index_cannot_number_are_too_large);
#if CQ_INDEX_BITS == 16
    RUN(sixteen_bit_meshes_end_at_the_last_halfedge_that_can_be_numbered);
#endif
    RUN(next_and_previous_stay_in_the_face);
    RUN(counter_clockwise_around_the_pole_of_a_disc_goes_through_its_faces);
    RUN(both_circulators_visit_valence_neighbours_and_come_back);
    RUN(a_tetrahedron_has_no_edge_to_collapse);
    RUN(every_edge_of_an_octahedron_can_be_collapsed);
    RUN(an_edge_beside_a_vertex_of_valence_three_cannot_be_collapsed);
    RUN(an_edge_of_a_triangle_that_is_no_face_cannot_be_collapsed);
    RUN(a_three_by_three_torus_has_only_separating_triangles);
    RUN(the_merged_valence_may_reach_the_limit_but_not_pass_it);
    RUN(halfedges_from_or_to_a_virtual_vertex_cannot_be_collapsed);
    RUN(an_inner_edge_between_two_boundary_vertices_cannot_be_collapsed);
    RUN(a_boundary_edge_can_be_collapsed_while_the_loop_is_longer_than_three);
    RUN(the_inner_vertex_of_a_disc_can_be_collapsed_into_its_boundary);
    RUN(an_edge_that_joins_two_boundaries_cannot_be_collapsed);
    RUN(asking_whether_an_edge_can_be_collapsed_changes_nothing);
    RUN(a_collapse_of_an_octahedron_gives_a_bipyramid_over_a_triangle);
    RUN(the_ring_after_a_collapse_is_p_then_neighbours_of_b_then_q_clockwise);
    RUN(a_split_undoes_a_collapse_slot_by_slot_at_every_edge);
    RUN(a_collapse_of_a_boundary_edge_shortens_the_loop_by_one);
    RUN(a_split_of_neighbouring_spokes_makes_a_vertex_of_valence_three);
    RUN(a_split_gives_b_the_spokes_strictly_clockwise_from_first_to_last);
    RUN(a_split_of_a_full_mesh_is_refused_and_changes_nothing);
    RUN(a_full_mesh_has_no_new_vertex_and_no_new_face);
    RUN(a_split_of_a_virtual_vertex_is_refused_and_changes_nothing);
    RUN(a_split_that_needs_a_virtual_face_is_refused_when_there_is_none);
    RUN(a_split_that_needs_two_real_faces_is_refused_when_there_is_one);
    RUN(free_slots_are_marked_and_reused_last_in_first_out);
    RUN(a_mesh_collapses_to_the_end_and_splits_all_the_way_back);
    RUN(triangles_come_out_in_slot_order_without_the_gaps);
    RUN(the_check_catches_any_wrong_origin);
    RUN(the_check_catches_any_wrong_twin);
    RUN(the_check_catches_two_swapped_twins);
    RUN(the_check_catches_any_wrong_outgoing_halfedge);
    RUN(the_check_catches_any_wrong_valence);
    RUN(the_check_names_the_vertex_with_a_wrong_valence);
    RUN(the_check_catches_a_mark_that_was_left);
    RUN(the_check_catches_counts_beyond_the_capacity_and_counts_that_leave_a_slot_out);
    RUN(the_check_survives_numbers_far_out_of_range);
    RUN(the_check_accepts_a_mesh_made_by_hand);
    RUN(the_check_catches_two_fans_at_one_vertex);
    RUN(the_check_catches_a_second_fan_that_the_valence_does_not_count);
    RUN(the_check_catches_a_fan_in_a_wrong_order);
    RUN(the_check_catches_two_edges_between_the_same_vertices);
    RUN(the_check_catches_a_vertex_on_two_boundaries);
    RUN(the_check_catches_two_virtual_vertices_that_touch);
    RUN(the_check_catches_a_virtual_vertex_in_a_real_face);
    RUN(the_check_catches_a_halfedge_that_is_its_own_twin);
    RUN(the_check_of_a_good_mesh_changes_nothing);
    RUN(an_edge_can_be_flipped_exactly_if_it_is_inside_and_the_result_is_a_mesh);
    RUN(an_end_of_too_many_neighbours_cannot_be_collapsed);
    return TEST_END();
}
