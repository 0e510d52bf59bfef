/* Regular levels: labelling, undoing, and redoing in the orders that a decoder may use. */
#define CQI_REGULAR_LEVELS
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "test.h"
#include "triangles.h"
#include "redo.h"

/* -- Meshes -------------------------------------------------------------------------------------------------------- */

typedef enum diagonals { ALIKE, ALTERNATING, RANDOM } diagonals;

static void add_face(triangles *t, uint32_t a, uint32_t b, uint32_t c)
{
    cq_index *v = t->indices + 3 * (size_t)t->num_faces++;
    v[0] = (cq_index)a;
    v[1] = (cq_index)b;
    v[2] = (cq_index)c;
}

static triangles room_for(uint32_t num_vertices, uint32_t num_faces)
{
    triangles t;
    t.num_vertices = num_vertices;
    t.num_faces = 0;
    t.indices = (cq_index *)exact_alloc(3 * (size_t)num_faces * sizeof(cq_index));
    return t;
}

static void add_quad(triangles *t, uint32_t a, uint32_t b, uint32_t c, uint32_t d, int first)
{
    if (first) {
        add_face(t, a, b, c);
        add_face(t, a, c, d);
    } else {
        add_face(t, a, b, d);
        add_face(t, b, c, d);
    }
}

/* w x h quads; closed around in x, in y, or not. */
static triangles quads(uint32_t w, uint32_t h, int around_x, int around_y, diagonals diagonal, uint64_t seed)
{
    const uint32_t columns = w + !around_x, rows = h + !around_y;
    triangles t = room_for(columns * rows, 2 * w * h);
    uint32_t x, y;
    for (y = 0; y < h; ++y)
        for (x = 0; x < w; ++x) {
            const uint32_t x1 = (x + 1) % columns, y1 = (y + 1) % rows;
            const int first = diagonal == ALIKE ? 1 : diagonal == ALTERNATING ? (int)((x + y) & 1) : (int)(next_random(&seed) & 1);
            add_quad(&t, y * columns + x, y * columns + x1, y1 * columns + x1, y1 * columns + x, first);
        }
    return t;
}

/* A cylinder of h rows with fans as caps. */
static triangles cylinder(uint32_t n, uint32_t h)
{
    const triangles side = quads(n, h, 1, 0, ALIKE, 1);
    triangles t = room_for(side.num_vertices + 2, side.num_faces + 2 * n);
    uint32_t k;
    for (k = 0; k < 3 * side.num_faces; ++k) t.indices[k] = side.indices[k];
    t.num_faces = side.num_faces;
    for (k = 0; k < n; ++k) {
        add_face(&t, side.num_vertices, (k + 1) % n, k);
        add_face(&t, side.num_vertices + 1, h * n + k, h * n + (k + 1) % n);
    }
    exact_free(side.indices);
    return t;
}

/* Each face becomes four. */
static triangles subdivide(triangles from)
{
    built b;
    triangles t;
    cq_index *middle;
    uint32_t h, n = 3 * from.num_faces, count = from.num_vertices;
    CHECK_EQ(build(&b, &from), CQ_OK);
    middle = (cq_index *)exact_alloc(n * sizeof *middle);
    for (h = 0; h < n; ++h) {
        const cq_index twin = b.mesh.twin[h];
        middle[h] = twin < h ? middle[twin] : (cq_index)count++;
    }
    t = room_for(count, 4 * from.num_faces);
    for (h = 0; h < n; h += 3) {
        add_face(&t, middle[h], middle[h + 1], middle[h + 2]);
        add_face(&t, from.indices[h], middle[h], middle[h + 2]);
        add_face(&t, from.indices[h + 1], middle[h + 1], middle[h]);
        add_face(&t, from.indices[h + 2], middle[h + 2], middle[h + 1]);
    }
    exact_free(middle);
    unbuild(&b);
    triangles_free(&from);
    return t;
}

/* Turns so many random edges. */
static void disturb(cq_mesh *m, uint32_t edges, uint64_t seed)
{
    while (edges--) {
        const cq_index h = (cq_index)(next_random(&seed) % (3 * (uint32_t)m->num_faces));
        if (m->origin[h - h % 3] != CQ_NONE && cqi_can_flip(m, h)) cqi_flip(m, h);
    }
}

/* -- Tests --------------------------------------------------------------------------------------------------------- */

static long seen_seconds, seen_dissolves, seen_patterns;

/* Vertices on a grid of so many columns, with a little height. */
static cq_value *places(uint32_t n, uint32_t columns)
{
    cq_value *x = (cq_value *)exact_alloc(3 * (size_t)n * sizeof *x);
    uint64_t seed = n;
    uint32_t v;
    for (v = 0; v < n; ++v) {
        x[3 * v] = (cq_value)(32 * (v % columns));
        x[3 * v + 1] = (cq_value)(32 * (v / columns));
        x[3 * v + 2] = (cq_value)(next_random(&seed) % 8);
    }
    return x;
}

/* Strips from a seed that the number of vertices decides. */
static cq_index find_strips(cqi_labels *l)
{
    const cq_mesh *m = l->mesh;
    if (cqi_face_slots(m) < cqi_vertex_slots(m)) return 0;
    l->alike = m->num_faces & 1;
    cqi_label_strips(l, cqi_find_seed(m, (uint32_t)m->num_faces, 0));
    l->spare = CQ_NONE;
    cqi_wait_all(l);
    cqi_repair(l);
    if (m->num_faces % 3 == 0) cqi_fill_all(l);
    return cqi_settle(l) ? cqi_count_odd(l) : 0;
}

/* Waves find no more odd vertices than the bound, and count them. */
static void check_bound(cqi_labels *l)
{
    cq_index bound[2];
    int k;
    cqi_bound_odd(l->mesh, bound);
    for (k = 0; k < 4; ++k) {
        cqi_try_waves(l, k);
        CHECK_EQ(l->clock, cqi_count_odd(l));
        CHECK(l->clock <= bound[k == CQI_ANY_VALENCE]);
    }
}

/* Takes the mesh apart and puts it together again in each order; columns: of the positions, 0: without. Returns the share of
 * odd vertices of the first level, in percent; levels: how many there were. */
static int take_apart(triangles t, uint32_t columns, cq_index (*find)(cqi_labels *), int least, uint32_t disturbed, int *levels)
{
    const size_t bytes = 3 * (size_t)t.num_faces * sizeof(cq_index);
    cq_value *positions = columns ? places(t.num_vertices, columns) : NULL;
    int order, share = 0;
    for (order = 0; order < 3; ++order) {
        redo r;
        triangles copy = t;
        uint64_t hash;
        copy.indices = (cq_index *)exact_copy(t.indices, bytes);
        CHECK_EQ(redo_init(&r, copy, positions), CQ_OK);
        r.check = 1;
        r.labels.least = least;
        disturb(&r.full.mesh, disturbed, 7);
        CHECK_EQ(cq_mesh_check(&r.full.mesh, NULL), CQ_OK);
        check_bound(&r.labels);
        hash = redo_hash(&r.full.mesh);
        *levels = redo_undo(&r, 1, find);
        if (*levels) share = (int)(100 * (uint64_t)r.first[1] / r.full.mesh.num_vertices);
        redo_all(&r, order);
        CHECK_EQ(r.bad, 0);
        CHECK_EQ(r.levels, 0);
        CHECK(redo_hash(&r.full.mesh) == hash);
        seen_seconds += r.seconds;
        seen_dissolves += r.dissolves;
        seen_patterns += r.pattern_flips;
        redo_free(&r);
    }
    triangles_free(&t);
    exact_free(positions);
    return share;
}

static int apart_and_together(triangles t, uint32_t disturbed, int *levels)
{
    return take_apart(t, 0, cqi_find_labels, 0, disturbed, levels);
}

/* -- Polygons by themselves ----------------------------------------------------------------------------------------- */

/* Edges of a polygon: bit j of joined[i]. */
typedef struct edges {
    int size;
    uint8_t joined[8];
} edges;

static void toggle(edges *e, int i, int j)
{
    e->joined[i] ^= (uint8_t)(1 << j);
    e->joined[j] ^= (uint8_t)(1 << i);
}

/* Flips an edge, as a decoder would: it must be there, and make one that is not. */
static int flip_edge(edges *e, int i, int j)
{
    int both = e->joined[i] & e->joined[j], low, high;
    if (!(e->joined[i] >> j & 1)) return 0;
    for (low = 0; low < 8 && !(both >> low & 1);) ++low;
    for (high = 7; high > low && !(both >> high & 1);) --high;
    if (high <= low || (e->joined[low] >> high & 1)) return 0;
    toggle(e, i, j);
    toggle(e, low, high);
    return 1;
}

/* Redoes one of the two coarse faces, whose corners begin at number k: without its dissolved edge. */
static int redo_half(const cqi_polygon *p, edges *e, int k, int *one, int *opposite)
{
    const int first = cqi_is_marked(p, k), second = cqi_is_marked(p, (k + 1) % 4);
    const int a = cqi_next_place(p, p->corner[k]), b = cqi_next_place(p, p->corner[(k + 1) % 4]);
    const int from = p->corner[k], to = p->corner[(k + 2) % 4];
    const int side_a = first ? cqi_side_of(p, k) : 0, side_b = second ? cqi_side_of(p, (k + 1) % 4) : 0;
    if (first && !(side_a & CQI_SIDE_PREVIOUS)) return 0;
    if (second && !(side_b & CQI_SIDE_NEXT)) return 0;
    *one = -1;
    if (first && second) {
        if (((side_a ^ side_b) & CQI_SIDE_HUB) == 0) return 0;
        toggle(e, a, b);
        toggle(e, side_a & CQI_SIDE_HUB ? a : b, side_a & CQI_SIDE_HUB ? to : from);
    } else if (first || second) {
        const int odd = first ? a : b, corner = first ? to : from;
        toggle(e, odd, corner);
        if ((side_a | side_b) & CQI_SIDE_HUB) {
            *one = odd;
            *opposite = corner;
        }
    }
    return 1;
}

/* Is what cqi_find_faces says of a polygon what leads back to it? */
static int leads_back(const cqi_polygon *p, const edges *target)
{
    edges e;
    int k, one[2], opposite[2];
    e.size = p->size;
    memset(e.joined, 0, sizeof e.joined);
    for (k = 0; k < e.size; ++k) toggle(&e, k, (k + 1) % e.size);
    toggle(&e, p->corner[p->diagonal], p->corner[p->diagonal + 2]);
    if (!redo_half(p, &e, p->diagonal, &one[0], &opposite[0])) return 0;
    if (!redo_half(p, &e, p->diagonal + 2, &one[1], &opposite[1])) return 0;
    if (!flip_edge(&e, p->corner[p->diagonal], p->corner[p->diagonal + 2])) return 0;
    for (k = 0; k < 2; ++k)
        if (one[k] >= 0 && !flip_edge(&e, one[k], opposite[k])) return 0;
    return memcmp(e.joined, target->joined, sizeof e.joined) == 0;
}

static long polygons_seen, polygons_found, polygons_second, polygons_alike;

/* One triangulation of a polygon with these corners, whose edges are in some order. */
static void check_order(int size, int even, int edge[][2])
{
    cqi_polygon p;
    edges target;
    int k, wanted, found[3];
    for (wanted = -1; wanted < 2; ++wanted) {
        memset(&p, 0, sizeof p);
        target.size = p.size = size;
        p.inner = size - 3;
        p.even = (uint8_t)even;
        memset(target.joined, 0, sizeof target.joined);
        for (k = 0; k < size; ++k) {
            if (even >> k & 1) p.corner[p.corners++] = k;
            toggle(&target, k, (k + 1) % size);
        }
        for (k = 0; k < p.inner; ++k) {
            p.edge[k][0] = edge[k][0];
            p.edge[k][1] = edge[k][1];
            toggle(&target, edge[k][0], edge[k][1]);
        }
        memcpy(p.joined, target.joined, sizeof p.joined);
        if (wanted < 0) polygons_seen++;
        found[1 + wanted] = cqi_find_faces(&p, wanted);
        if (!found[1 + wanted]) {
            CHECK(memcmp(p.joined, target.joined, sizeof p.joined) == 0);
            CHECK_EQ(p.undone, 0);
            continue;
        }
        CHECK(wanted < 0 || p.diagonal == wanted);
        CHECK(leads_back(&p, &target));
        if (wanted < 0) polygons_found++;
        polygons_second += p.second != 0;
        polygons_alike += wanted >= 0 && wanted == cqi_alike(&p);
    }
    CHECK(cqi_alike(&p) < 0 || found[1 + cqi_alike(&p)]);
}

/* The same in all orders of its edges, each of them in either direction. */
static void check_polygon(int size, int even, int edge[][2], int ordered)
{
    int k, j, turned, both[8][2];
    for (turned = 0; ordered == size - 3 && turned < 1 << ordered; ++turned) {
        for (k = 0; k < 2 * ordered; ++k) both[k / 2][k % 2] = edge[k / 2][(k ^ turned >> k / 2) & 1];
        check_order(size, even, both);
    }
    for (k = ordered; k < size - 3; ++k) {
        memcpy(both, edge, (size_t)(size - 3) * sizeof *both);
        for (j = 0; j < 2; ++j) both[ordered][j] = edge[k][j], both[k][j] = edge[ordered][j];
        check_polygon(size, even, both, ordered + 1);
    }
}

/* All triangulations: the chain of places `todo` stands for a list of polygons first .. last that are still to be cut. */
static void triangulate(int size, int even, int todo[][2], int n, int edge[][2], int edges_made)
{
    int first, last, k;
    if (n == 0) {
        check_polygon(size, even, edge, 0);
        return;
    }
    first = todo[n - 1][0];
    last = todo[n - 1][1];
    for (k = first + 1; k < last; ++k) {
        int next[16][2], m = n - 1, made = edges_made, j, bad = 0;
        memcpy(next, todo, sizeof next);
        for (j = 0; j < 2; ++j) {
            const int a = j ? k : first, b = j ? last : k;
            if (b - a < 2) continue;
            bad |= (even >> a & even >> b & 1) != 0;
            edge[made][0] = a;
            edge[made++][1] = b;
            next[m][0] = a;
            next[m++][1] = b;
        }
        if (!bad) triangulate(size, even, next, m, edge, made);
    }
}

TEST(polygons_of_four_corners_lead_back_to_themselves)
{
    int marks, k, todo[16][2], edge[8][2];
    for (marks = 1; marks < 16; ++marks) {
        int size = 0, even = 0;
        for (k = 0; k < 4; ++k) {
            even |= 1 << size++;
            size += marks >> k & 1;
        }
        todo[0][0] = 0;
        todo[0][1] = size - 1;
        triangulate(size, even, todo, 1, edge, 0);
    }
    printf("  %ld polygons, %ld can be coded\n", polygons_seen, polygons_found);
    CHECK(polygons_seen > 80);
    CHECK(polygons_found > 50);
    CHECK(polygons_second > 10);
    CHECK(polygons_alike > 10);
}

/* -- Meshes -------------------------------------------------------------------------------------------------------- */

TEST(subdivided_meshes_are_undone_step_by_step)
{
    int levels;
    CHECK(apart_and_together(subdivide(subdivide(subdivide(triangles_tetrahedron()))), 0, &levels) >= 73);
    CHECK(levels >= 3);
    CHECK(apart_and_together(subdivide(subdivide(quads(5, 4, 0, 0, RANDOM, 3))), 0, &levels) >= 70);
    CHECK(levels >= 2);
    CHECK(apart_and_together(subdivide(subdivide(quads(5, 4, 1, 1, RANDOM, 4))), 0, &levels) >= 74);
    CHECK(levels >= 2);
}

TEST(grids_with_boundary_and_tori_are_undone)
{
    int levels;
    CHECK(apart_and_together(quads(16, 16, 0, 0, ALIKE, 1), 0, &levels) >= 70);
    CHECK(levels >= 3);
    CHECK(apart_and_together(quads(15, 17, 0, 0, ALTERNATING, 1), 0, &levels) >= 60);
    CHECK(apart_and_together(quads(16, 12, 1, 1, ALIKE, 1), 0, &levels) >= 74);
    CHECK(apart_and_together(quads(12, 20, 1, 0, ALTERNATING, 1), 0, &levels) >= 60);
}

TEST(odd_rows_are_part_of_a_level)
{
    int levels;
    CHECK(apart_and_together(quads(17, 13, 1, 1, ALIKE, 1), 0, &levels) >= 60);
    CHECK(apart_and_together(cylinder(25, 15), 0, &levels) >= 60);
    CHECK(apart_and_together(cylinder(24, 5), 0, &levels) >= 40);
}

TEST(small_meshes_have_levels_or_none)
{
    uint32_t w, h;
    int levels, any = 0;
    apart_and_together(triangles_single(), 0, &levels);
    CHECK_EQ(levels, 0);
    apart_and_together(triangles_pillow(), 0, &levels);
    CHECK_EQ(levels, 0);
    apart_and_together(triangles_tetrahedron(), 0, &levels);
    CHECK_EQ(levels, 0);
    for (w = 1; w < 7; ++w)
        for (h = 1; h < 7; ++h) {
            apart_and_together(quads(w, h, 0, 0, ALIKE, 1), 0, &levels);
            any += levels;
            apart_and_together(quads(w, h, 0, 0, ALTERNATING, 1), 0, &levels);
            if (w < 3 || h < 3) continue;
            apart_and_together(quads(w, h, 1, 1, ALIKE, 1), 0, &levels);
            apart_and_together(quads(w, h, 1, 0, RANDOM, w * h), 0, &levels);
            any += levels;
        }
    CHECK(any > 10);
}

TEST(irregular_places_are_repaired)
{
    uint64_t seed;
    int levels, any = 0;
    for (seed = 1; seed <= 12; ++seed) {
        triangles t = quads(9, 8, (int)(seed & 1), (int)(seed >> 1 & 1), RANDOM, seed);
        triangles_append(&t, cylinder((uint32_t)(7 + seed), 4));
        triangles_append(&t, subdivide(triangles_tetrahedron()));
        apart_and_together(t, (uint32_t)(seed * seed * 4), &levels);
        any += levels;
        apart_and_together(subdivide(quads(6, 5, 1, (int)(seed & 1), ALIKE, 1)), (uint32_t)(8 * seed), &levels);
        any += levels;
    }
    CHECK(any > 20);
}

/* Two odd vertices that must become even, the second of which has become so when the first one was. */
TEST(a_conflict_may_be_over_before_its_turn)
{
    redo r;
    cqi_labels *const l = &r.labels;
    cq_index odd, spare;
    REQUIRE_EQ(redo_init(&r, quads(8, 4, 1, 1, RANDOM, 1983), NULL), CQ_OK);
    cqi_try_waves(l, cqi_choose_labelling(l));
    CHECK(cqi_finish_waves(l));
    cqi_fill_all(l);
    odd = cqi_count_odd(l);
    spare = l->spare;
    CHECK(cqi_settle(l));
    CHECK(cqi_count_odd(l) < odd);
    CHECK_EQ(spare - l->spare, odd - cqi_count_odd(l));
    redo_free(&r);
}

/* Whether a mesh is one of quads is told by a part of it. */
TEST(a_sample_of_strips_tells_quads)
{
    redo r;
    cqi_labels *const l = &r.labels;
    triangles t = quads(64, 60, 0, 0, RANDOM, 3);
    cq_value *x = places(t.num_vertices, 65);
    cq_index v, reached = 0;
    REQUIRE_EQ(redo_init(&r, t, x), CQ_OK);
    CHECK(cqi_are_quads(l, 0));
    for (v = 0; v < l->mesh->num_vertices; ++v) reached = (cq_index)(reached + (cqi_label(l, v) != CQI_UNLABELLED));
    CHECK(reached > 1700 && reached < 2600);
    redo_free(&r);
    exact_free(x);
}

TEST(quads_with_random_diagonals_are_undone_in_strips)
{
    uint64_t seed;
    int levels, any = 0;
    CHECK(take_apart(quads(21, 16, 0, 0, RANDOM, 1), 22, cqi_find_labels, 300, 0, &levels) >= 40);
    CHECK(levels >= 2);
    CHECK(take_apart(quads(21, 16, 0, 0, RANDOM, 2), 22, find_strips, 0, 0, &levels) >= 40);
    for (seed = 1; seed <= 12; ++seed) {
        triangles t = quads(9, 8, (int)(seed & 1), (int)(seed >> 1 & 1), RANDOM, seed);
        triangles_append(&t, cylinder((uint32_t)(7 + seed), 4));
        take_apart(t, 9, find_strips, 0, (uint32_t)(seed * seed * 4), &levels);
        any += levels;
    }
    CHECK(any > 20);
}

TEST(a_limit_keeps_vertices_even)
{
    static const int32_t limits[] = {0, 1, 2, 4};
    size_t k;
    int share[sizeof limits / sizeof *limits];
    for (k = 0; k < sizeof limits / sizeof *limits; ++k) {
        triangles t = quads(16, 16, 0, 0, ALIKE, 1);
        redo r;
        cq_value *x = places(t.num_vertices, 17);
        uint32_t v, far = 0;
        CHECK_EQ(redo_init(&r, t, x), CQ_OK);
        r.labels.ready = CQI_NO_LABELS;
        share[k] = (int)cqi_label_with(&r.labels, 0, limits[k]);
        for (v = 0; v < r.full.mesh.num_vertices; ++v)
            far += cqi_is_odd(&r.labels, (cq_index)v) && cqi_is_too_far(&r.labels, (cq_index)v, r.labels.parent[0][v], r.labels.parent[1][v]);
        CHECK_EQ(far, 0);
        redo_free(&r);
        exact_free(x);
    }
    CHECK(share[0] > share[3] && share[3] > share[2] && share[2] > share[1]);
}

TEST(all_kinds_of_flips_were_seen)
{
    CHECK(seen_patterns > 100);
    CHECK(seen_dissolves > 100);
    CHECK(seen_seconds > 0);
}

TEST(labels_take_exactly_the_memory_that_they_tell)
{
    built b;
    cqi_labels l;
    triangles t = triangles_torus(5, 4);
    void *memory;
    size_t size;
    REQUIRE_EQ(build(&b, &t), CQ_OK);
    size = CQI_LABEL_BYTES((size_t)b.mesh.first_virtual + b.mesh.max_virtual,
                           (size_t)b.mesh.first_virtual_face + b.mesh.max_virtual_faces);
    memory = exact_alloc(size);
    CHECK(!cqi_labels_carve(&l, &b.mesh, memory, size - 1));
    CHECK(cqi_labels_carve(&l, &b.mesh, memory, size));
    CHECK((uint8_t *)l.face + 3 * 0 >= (uint8_t *)memory && l.face + b.mesh.first_virtual_face <= (uint8_t *)memory + size);
    exact_free(memory);
    unbuild(&b);
    triangles_free(&t);
}

/* Two even vertices on each side of the parents can be corners, three can not. */
TEST(two_parents_have_at_most_two_corners_on_each_side)
{
    cqi_fill_ring ring;
    int even, i, j, k, yes = 0;
    memset(&ring, 0, sizeof ring);
    ring.size = 8;
    ring.virtual_one = -1;
    for (even = 0; even < 256; ++even)
        for (i = 0; i < 8; ++i)
            for (j = i + 2; j < 8; ++j) {
                int between = 0, others = 0;
                for (k = 0; k < 8; ++k) {
                    ring.even[k] = even >> k & 1;
                    if (k > i && k < j) between += ring.even[k];
                    if (k < i || k > j) others += ring.even[k];
                }
                CHECK_EQ(cqi_are_opposite(&ring, i, j), ring.even[i] && ring.even[j] && between <= 2 && others <= 2);
                yes += cqi_are_opposite(&ring, i, j);
            }
    CHECK(yes > 100);
}

/* Without even vertices but the two, all that is asked is that a virtual vertex is alone between them. */
TEST(a_virtual_vertex_is_alone_on_its_side_of_two_parents)
{
    cqi_fill_ring ring;
    int i, j, n, yes = 0;
    memset(&ring, 0, sizeof ring);
    for (ring.size = 3; ring.size <= 8; ++ring.size)
        for (i = 0; i < ring.size; ++i)
            for (j = i + 2; j < ring.size; ++j)
                for (n = 0; n < ring.size; ++n) {
                    const int between = n > i && n < j ? j - i - 1 : ring.size - (j - i) - 1;
                    if (n == i || n == j || j - i == ring.size - 1) continue;
                    memset(ring.even, 0, sizeof ring.even);
                    ring.even[i] = ring.even[j] = 1;
                    ring.virtual_one = n;
                    CHECK_EQ(cqi_are_opposite(&ring, i, j), between == 1);
                    yes += between == 1;
                }
    CHECK(yes > 20);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(polygons_of_four_corners_lead_back_to_themselves);
    RUN(subdivided_meshes_are_undone_step_by_step);
    RUN(grids_with_boundary_and_tori_are_undone);
    RUN(odd_rows_are_part_of_a_level);
    RUN(small_meshes_have_levels_or_none);
    RUN(irregular_places_are_repaired);
    RUN(a_conflict_may_be_over_before_its_turn);
    RUN(a_sample_of_strips_tells_quads);
    RUN(quads_with_random_diagonals_are_undone_in_strips);
    RUN(a_limit_keeps_vertices_even);
    RUN(all_kinds_of_flips_were_seen);
    RUN(two_parents_have_at_most_two_corners_on_each_side);
    RUN(a_virtual_vertex_is_alone_on_its_side_of_two_parents);
    RUN(labels_take_exactly_the_memory_that_they_tell);
    return TEST_END();
}
