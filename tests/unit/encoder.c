/* The encoder: arguments, memory, output of every size, the map, determinism, limits. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "sample.h"
#include "test.h"

#include <math.h>

#define FOR_EACH_SAMPLE(s, c) \
    sample s; coded c; int which_##s; \
    for (which_##s = 0; which_##s < SAMPLES; ++which_##s, uncode(&c), sample_free(&s)) \
        if (sample_code(&s, &c, which_##s) != CQ_OK) test_fail(__FILE__, __LINE__, "the sample encodes"); else

static uint8_t encoded_once[65536];

/* One call with plenty of memory and room; the result, and the place if it is an error. */
static cq_result encode_once(const cq_input *input, cq_place *place)
{
    cq_input in = *input;
    cq_shape shape = input->shape;
    size_t size, stream_size;
    void *memory;
    cq_result result;
    if (shape.num_channels > CQ_MAX_CHANNELS) shape.num_channels = CQ_MAX_CHANNELS;
    shape.num_boundary_loops = 64;
    shape.num_boundary_edges = 256;
    size = cq_encoder_bytes(&shape);
    if (size == 0) size = 100000;
    memory = exact_alloc(size);
    result = cq_encode(&in, memory, size, encoded_once, sizeof encoded_once, &stream_size, place, NULL);
    exact_free(memory);
    if (result != CQ_ERROR_MEMORY || cq_encoder_bytes(&in.shape) <= size) return result;
    size = cq_encoder_bytes(&in.shape); /* of what it has found: seams */
    memory = exact_alloc(size);
    result = cq_encode(&in, memory, size, encoded_once, sizeof encoded_once, &stream_size, place, NULL);
    exact_free(memory);
    return result;
}

/* -- The map ------------------------------------------------------------------------------------------------------- */

TEST(the_map_is_a_permutation)
{
    FOR_EACH_SAMPLE(s, c) {
        uint32_t n = s.mesh.num_vertices, v;
        uint8_t *seen = (uint8_t *)calloc(n, 1);
        for (v = 0; v < n; ++v) {
            REQUIRE(c.map[v] < n);
            CHECK(!seen[c.map[v]]);
            seen[c.map[v]] = 1;
        }
        free(seen);
    }
}

TEST(the_face_map_leads_to_the_same_corners)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        uint32_t n = s.mesh.num_faces, f, turn, k;
        uint8_t *seen = (uint8_t *)calloc(n, 1);
        decoding_begin(&d, c.bytes, c.size);
        REQUIRE_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        for (f = 0; f < n; ++f) {
            int equal = 0;
            REQUIRE(c.face_map[f] < n);
            CHECK(!seen[c.face_map[f]]);
            seen[c.face_map[f]] = 1;
            for (turn = 0; turn < 3; ++turn) {
                uint32_t same = 0;
                for (k = 0; k < 3; ++k)
                    same += d.decoder->mesh.origin[3 * c.face_map[f] + k] ==
                            c.map[s.mesh.indices[3 * f + (k + turn) % 3]];
                equal += same == 3;
            }
            CHECK_EQ(equal, 1);
        }
        free(seen);
        decoding_free(&d);
    }
}

TEST(the_stream_is_the_same_if_nobody_asks_for_maps)
{
    sample s;
    coded c;
    cq_place place;
    sample_begin(&s, triangles_icosahedron());
    sample_merged(&s, CQ_GROUP, CQ_PER_FACE, 1, 5);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    REQUIRE_EQ(encode_once(&s.input, &place), CQ_OK);
    CHECK(memcmp(encoded_once, c.bytes, c.size) == 0);
    uncode(&c);
    sample_free(&s);
}

TEST(the_map_leads_to_the_values_of_each_vertex)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        uint32_t k, v, j;
        decoding_begin(&d, c.bytes, c.size);
        REQUIRE_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        for (k = 0; k < s.input.shape.num_channels; ++k) {
            const cq_channel *channel = &s.input.shape.channel[k];
            const cq_index *map = is_per_face(channel) ? c.face_map : c.map;
            uint32_t n = channel->components;
            for (v = 0; v < num_owners(channel, s.mesh.num_vertices, s.mesh.num_faces); ++v)
                for (j = 0; j < n; ++j) CHECK_EQ(d.decoder->channel[k][map[v] * n + j], s.values[k][v * n + j]);
        }
        decoding_free(&d);
    }
}

static int has_positions(const cq_shape *shape)
{
    uint32_t k;
    for (k = 0; k < shape->num_channels; ++k)
        if (shape->channel[k].kind == CQ_POSITION && shape->channel[k].merge == CQ_AVERAGE &&
            shape->channel[k].bits <= CQ_MAX_BITS)
            return 1;
    return 0;
}

/* At least so many samples are encoded otherwise than for the goal balanced. */
static void check_goal(cq_goal goal, int least)
{
    int changed = 0;
    FOR_EACH_SAMPLE(s, c) {
        coded other;
        decoding d;
        uint32_t v;
        int same;
        s.input.goal = goal;
        code(&other, &s.input);
        REQUIRE_EQ(other.result, CQ_OK);
        same = other.size == c.size && memcmp(other.bytes, c.bytes, c.size) == 0;
        CHECK(same || has_positions(&s.input.shape));
        changed += !same;
        decoding_begin(&d, other.bytes, other.size);
        CHECK_EQ(decoding_run(&d, other.bytes, other.size, other.size, CQ_NO_LIMIT), CQ_DONE);
        for (v = 0; v < s.mesh.num_vertices && s.input.shape.num_channels; ++v)
            CHECK_EQ(d.decoder->channel[0][other.map[v] * s.input.shape.channel[0].components],
                     s.values[0][v * s.input.shape.channel[0].components]);
        CHECK_EQ(d.decoder->mesh.num_faces, s.mesh.num_faces);
        decoding_free(&d);
        uncode(&other);
    }
    CHECK(changed >= least);
}

TEST(the_goal_changes_what_is_collapsed_and_not_what_comes_back)
{
    check_goal(CQ_LEAST_CONNECTIVITY, 2);
}

/* A roof over a square, rising from two eaves by `slope` a step to a ridge. */
enum { ROOF = 33, ROOF_SPACING = 64 };

static int32_t roof_height(int32_t x, int32_t slope)
{
    const int32_t ridge = ROOF / 2 * ROOF_SPACING;
    return slope * (ridge - (x < ridge ? ridge - x : x - ridge));
}

static void roof_make(sample *s, int32_t slope)
{
    uint32_t v;
    sample_begin(s, triangles_sheet(ROOF, ROOF));
    sample_channel(s, CQ_POSITION, 3, 15);
    for (v = 0; v < s->mesh.num_vertices; ++v) {
        cq_value *at = s->values[0] + 3 * v;
        at[0] = (cq_value)(v % ROOF * ROOF_SPACING);
        at[1] = (cq_value)(v / ROOF * ROOF_SPACING);
        at[2] = (cq_value)roof_height(at[0], slope);
    }
}

/* Of a roof: with its positions as numbers that mean something else; with its positions. Regular levels have no
 * indices. */
TEST(connectivity_costs_less_with_positions)
{
    uint64_t cost[2];
    int k;
    for (k = 0; k < 2; ++k) {
        sample s;
        coded c;
        roof_make(&s, 1);
        s.input.conquest_only = 1;
        s.input.goal = CQ_LEAST_CONNECTIVITY;
        if (k == 0) s.input.shape.channel[0].kind = CQ_GENERIC;
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        cost[k] = c.report->indices;
        uncode(&c);
        sample_free(&s);
    }
    CHECK(cost[1] < cost[0] - cost[0] / 8);
}

/* Twice the area of a face, seen from above. */
static int64_t roof_face_area(const cq_decoder *d, size_t f)
{
    const cq_value *a = d->channel[0] + 3 * (size_t)d->mesh.origin[3 * f];
    const cq_value *b = d->channel[0] + 3 * (size_t)d->mesh.origin[3 * f + 1];
    const cq_value *c = d->channel[0] + 3 * (size_t)d->mesh.origin[3 * f + 2];
    return (int64_t)(b[0] - a[0]) * (c[1] - a[1]) - (int64_t)(b[1] - a[1]) * (c[0] - a[0]);
}

/* How far above or below a face the roof's point x, y is; -1 if the face is not below or above it. */
static double roof_distance(const cq_decoder *d, size_t f, int32_t x, int32_t y, int32_t height)
{
    const cq_value *at[3];
    double share[3], area = (double)roof_face_area(d, f), z = 0;
    int k;
    for (k = 0; k < 3; ++k) at[k] = d->channel[0] + 3 * (size_t)d->mesh.origin[3 * f + (size_t)k];
    for (k = 0; k < 3; ++k) {
        const cq_value *a = at[(k + 1) % 3], *b = at[(k + 2) % 3];
        share[k] = (double)(b[0] - a[0]) * (y - a[1]) - (double)(b[1] - a[1]) * (x - a[0]);
        if (area <= 0 || share[k] < 0) return -1;
        z += share[k] / area * at[k][2];
    }
    return fabs(z - height);
}

/* The same of the nearest face; without one, as far as the roof is wide. */
static double roof_distance_of(const cq_decoder *d, int32_t x, int32_t y, int32_t height)
{
    double least = ROOF * ROOF_SPACING;
    size_t f;
    for (f = 0; f < d->mesh.num_faces; ++f) {
        const double distance = roof_distance(d, f, x, y, height);
        if (distance >= 0 && distance < least) least = distance;
    }
    return least;
}

/* How far a roof's points inside its square are off the mesh of at most so many vertices, and that square's area. */
static void roof_measure(const coded *c, int32_t slope, uint32_t vertices, double *off, int64_t *area, int *turned)
{
    cq_bytes in;
    decoding d;
    size_t i;
    in.data = c->bytes;
    in.size = c->size;
    decoding_begin(&d, c->bytes, c->size);
    while (d.decoder->mesh.num_vertices < vertices && cq_decode(d.decoder, &in, 1) == CQ_MORE) {}
    *off = *turned = 0;
    *area = 0;
    for (i = 0; i < ROOF * ROOF; ++i) {
        const int32_t x = (int32_t)(i % ROOF) * ROOF_SPACING, y = (int32_t)(i / ROOF) * ROOF_SPACING;
        *off = fmax(*off, roof_distance_of(d.decoder, x, y, roof_height(x, slope)));
    }
    for (i = 0; i < d.decoder->mesh.num_faces; ++i) {
        *area += roof_face_area(d.decoder, i);
        *turned += roof_face_area(d.decoder, i) <= 0;
    }
    decoding_free(&d);
}

TEST(the_goal_balanced_keeps_planes_creases_and_boundaries)
{
    const int64_t all = 2 * (int64_t)((ROOF - 1) * ROOF_SPACING) * ((ROOF - 1) * ROOF_SPACING);
    int32_t slope;
    for (slope = 0; slope < 8; ++slope) {
        sample s;
        coded c;
        double off;
        int64_t area;
        int turned;
        roof_make(&s, slope);
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        roof_measure(&c, slope, ROOF * ROOF / 8, &off, &area, &turned);
        CHECK(off <= 0.001);
        CHECK_EQ(area, all);
        CHECK_EQ(turned, 0);
        uncode(&c);
        s.input.conquest_only = 1;
        s.input.goal = CQ_LEAST_CONNECTIVITY;
        code(&c, &s.input);
        roof_measure(&c, slope, ROOF * ROOF / 8, &off, &area, &turned);
        CHECK(off > 20 * slope || slope == 0);
        CHECK(area < all - all / 50);
        uncode(&c);
        sample_free(&s);
    }
}

/* They grow with the error, whatever the shift, by one octave where it doubles. */
TEST(quadric_errors_are_compared_by_their_logarithms)
{
    const uint64_t largest = (uint64_t)1 << 62;
    uint64_t x;
    int shift;
    CHECK_EQ(cqi_log_quadric(0, 0), 0);
    CHECK_EQ(cqi_log_quadric(0, 12), 0);
    CHECK_EQ(cqi_log_quadric(1, 0), CQI_OCTAVE);
    CHECK_EQ(cqi_log_quadric(3, 0), 2 * CQI_OCTAVE + CQI_OCTAVE / 2);
    CHECK_EQ(cqi_log_quadric(largest, 12), (63 + 48) * CQI_OCTAVE);
    for (x = 1; x < largest / 3; x += x / 3 + 1) {
        CHECK(cqi_log_quadric(x, 0) <= cqi_log_quadric(x + x / 200 + 1, 0));
        CHECK(cqi_log_quadric(x, 0) < cqi_log_quadric(x + x / 100 + 1, 0));
        CHECK_EQ(cqi_log_quadric(2 * x, 0), cqi_log_quadric(x, 0) + CQI_OCTAVE);
        for (shift = 0; shift < 12 && x >> 50 == 0; ++shift) CHECK_EQ(cqi_log_quadric(16 * x, shift), cqi_log_quadric(x, shift + 1));
    }
}

/* -- Losses, against the same in floating point -- */

typedef struct quadric_model {
    double sum;              /* of areas times squared distances, and of squared lengths times squared distances */
    double least;            /* of the shares of its area that a triangle keeps */
} quadric_model;

static void model_cross(const double *a, const double *b, double *n)
{
    int i;
    for (i = 0; i < 3; ++i) n[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double model_dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* What the triangle v, y, z loses where v goes to x. */
static void model_triangle(quadric_model *l, const double *v, const double *y, const double *z, const double *x,
                           int stays)
{
    double e[3], f[3], before[3], after[3], move[3], size;
    int i;
    for (i = 0; i < 3; ++i) e[i] = y[i] - v[i], f[i] = z[i] - v[i], move[i] = x[i] - v[i];
    model_cross(e, f, before);
    for (i = 0; i < 3; ++i) e[i] = y[i] - x[i], f[i] = z[i] - x[i];
    model_cross(e, f, after);
    size = model_dot(before, before);
    if (size == 0) return;
    l->sum += model_dot(before, move) * model_dot(before, move) / sqrt(size);
    if (stays && model_dot(before, after) / size < l->least) l->least = model_dot(before, after) / size;
}

static void model_edge(quadric_model *l, const double *v, const double *w, const double *x)
{
    double along[3], move[3], area[3];
    int i;
    for (i = 0; i < 3; ++i) along[i] = w[i] - v[i], move[i] = x[i] - v[i];
    model_cross(along, move, area);
    l->sum += model_dot(area, area);
}

/* The second end of h goes to the first. */
static quadric_model model_quadric(const cq_mesh *m, const cq_value *positions, cq_index h)
{
    const cq_index to = m->origin[h], from = cq_target(m, h);
    quadric_model l = {0, 1e9};
    double at[64][3];
    cq_index g;
    int i;
    for (g = 0; g < m->first_virtual; ++g)
        for (i = 0; i < 3; ++i) at[g][i] = (double)positions[3 * g + (cq_index)i];
    g = m->out[from];
    do {
        cq_index y = cq_target(m, g), z = m->origin[cq_prev(g)];
        if (cq_is_virtual(m, y)) model_edge(&l, at[from], at[z], at[to]);
        else if (cq_is_virtual(m, z)) model_edge(&l, at[from], at[y], at[to]);
        else model_triangle(&l, at[from], at[y], at[z], at[to], y != to && z != to);
        g = cq_clockwise(m, g);
    } while (g != m->out[from]);
    return l;
}

/* A grid of points with noise, in units of 1 << shift. */
static void quadric_positions(cq_value *positions, uint32_t side, int32_t noise, int shift, uint64_t seed)
{
    uint32_t v, i;
    for (v = 0; v < side * side; ++v)
        for (i = 0; i < 3; ++i) {
            int32_t grid = i == 0 ? (int32_t)(v % side) * 400 : i == 1 ? (int32_t)(v / side) * 400 : 800;
            grid += (int32_t)(next_random(&seed) % (uint32_t)(2 * noise + 1));
            positions[3 * v + i] = (cq_value)((int32_t)grid * ((int32_t)1 << shift));
        }
}

static uint32_t quadric_of(const cqi_plan *p, cq_index h)
{
    cqi_fan_of_input fan;
    cqi_list_fan(p, &fan, p->mesh.twin[h]);
    return cqi_quadric_of(p, &fan);
}

/* Compares all edges; returns how many triangles were turned. */
static int check_quadrics(const triangles *t, int32_t noise, int shift)
{
    cq_value positions[3 * 64];
    built b;
    cqi_plan p;
    cq_index h;
    int turned = 0;
    CHECK(build(&b, t) == CQ_OK);
    memset(&p, 0, sizeof p);
    p.mesh = b.mesh;
    p.positions = positions;
    p.most_quadric = CQI_ANY_QUADRIC - 1;
    quadric_positions(positions, 6, noise, shift, (uint64_t)noise + (uint64_t)shift);
    for (h = 0; h < 3 * t->num_faces; ++h) {
        quadric_model expected = model_quadric(&b.mesh, positions, h);
        uint32_t quadric = quadric_of(&p, h);
        if (expected.least > 0.127) CHECK(quadric != CQI_ANY_QUADRIC);
        if (expected.least < 0.123) CHECK_EQ(quadric, CQI_ANY_QUADRIC);
        turned += quadric == CQI_ANY_QUADRIC;
        if (quadric != CQI_ANY_QUADRIC && expected.sum > 1e6 * exp2(4 * shift))
            CHECK(fabs((double)quadric / CQI_OCTAVE - 1 - log2(expected.sum)) < 0.35);
        p.most_quadric = quadric;                             /* with a limit it tells on which side of that it is */
        CHECK_EQ(quadric_of(&p, h), quadric);
        p.most_quadric = quadric < CQI_OCTAVE ? 0 : quadric - 1;
        CHECK(quadric == 0 || quadric_of(&p, h) > p.most_quadric);
        p.most_quadric = CQI_ANY_QUADRIC - 1;
    }
    unbuild(&b);
    return turned;
}

/* The code of an error stands for no less, and the code before it for no more. */
TEST(errors_have_the_nearest_code_that_is_not_less)
{
    uint32_t error, step;
    for (error = 0, step = 1; error < 0x10000000u; error += step, step = 1 + error / 500) {
        const uint32_t code = cqi_error_code(error);
        CHECK(cqi_error_of_code(code) >= error);
        CHECK(!code || cqi_error_of_code(code - 1) <= error);
        CHECK(error || !code);
    }
}

TEST(a_collapse_loses_areas_times_squared_distances_or_if_it_turns_a_triangle_anything)
{
    triangles closed = triangles_torus(6, 6), open = triangles_sheet(6, 6);
    int32_t noise;
    int shift, turned = 0;
    for (noise = 0; noise < 400; noise += 19)
        for (shift = 0; shift < (CQ_INDEX_BITS == 16 ? 3 : 12); ++shift)
            turned += check_quadrics(&open, noise, shift) + check_quadrics(&closed, noise, shift);
    CHECK(turned > 100);
    triangles_free(&closed);
    triangles_free(&open);
}

/* Compares all edges; returns how many may be collapsed. */
static int check_fans(const triangles *t)
{
    static const cq_value positions[3 * 64];
    built b;
    cqi_plan p;
    cq_index h;
    int count = 0;
    CHECK(build(&b, t) == CQ_OK);
    memset(&p, 0, sizeof p);
    p.mesh = b.mesh;
    p.positions = positions;
    for (h = 0; h < 3 * t->num_faces; ++h) {
        const cq_index a = b.mesh.origin[h];
        const int boundary = cqi_on_boundary(&b.mesh, a);
        cqi_fan_of_input fan;
        cqi_mark_ring(&b.mesh, a, 1);
        cqi_list_fan(&p, &fan, b.mesh.twin[h]);
        if (cqi_keeps_valences(&b.mesh, h, CQ_MAX_VALENCE)) {
            const int may = cqi_collapsible(&b.mesh, h, CQ_MAX_VALENCE, boundary);
            CHECK_EQ(cqi_fan_is_collapsible(&b.mesh, &fan, boundary), may);
            count += may;
        }
        cqi_mark_ring(&b.mesh, a, 0);
    }
    unbuild(&b);
    return count;
}

TEST(a_fan_says_the_same_as_the_mesh_of_what_may_be_collapsed)
{
    triangles closed = triangles_torus(6, 6), narrow = triangles_torus(3, 6), open = triangles_sheet(6, 6);
    const int all = 3 * 72;
    CHECK_EQ(check_fans(&closed), all);
    CHECK(check_fans(&narrow) < 3 * 36);
    CHECK(check_fans(&open) > 0 && check_fans(&open) < (int)(3 * open.num_faces));
    triangles_free(&closed);
    triangles_free(&narrow);
    triangles_free(&open);
}

TEST(reports_take_logarithms_within_a_6000th_that_never_fall)
{
    uint32_t x, before = 0;
    for (x = 0xffffff; x < 0xff000000u; x += 1 + x / 5000) {
        const uint32_t bits = cqi_log2(x);
        CHECK(fabs((double)bits / 65536 - log2((double)x)) < 1.0 / 6000);
        CHECK(bits >= before);
        before = bits;
    }
    for (x = 0; x < 32; ++x) CHECK_EQ(cqi_log2((uint32_t)1 << x), x * 65536);
}

TEST(the_smallest_valence_is_best_then_if_that_is_the_goal_the_nearest_vertex)
{
    static const cq_value positions[] = {100, 100, 100, 104, 100, 100, 100, 97, 100, 100, 100, 101};
    static cq_index valence[] = {5, 5, 5, 6};
    static cq_index origin[] = {0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0}; /* halfedge 3 k leads from 0 to k */
    cqi_candidates c = {4, 0, {0}, {0, 1, 2, 3}, {0, 3, 6, 9}, {UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX}};
    cqi_plan p;
    memset(&p, 0, sizeof p);
    p.mesh.valence = valence;
    p.mesh.origin = origin;
    CHECK(cqi_is_better(&p, &c, 1, 3) && !cqi_is_better(&p, &c, 3, 1));
    CHECK(!cqi_is_better(&p, &c, 2, 1) && !cqi_is_better(&p, &c, 1, 2));
    p.positions = positions;
    CHECK(cqi_is_better(&p, &c, 1, 3) && !cqi_is_better(&p, &c, 3, 1));
    CHECK(cqi_is_better(&p, &c, 2, 1) && !cqi_is_better(&p, &c, 1, 2));
    CHECK(!cqi_is_better(&p, &c, 1, 1));
    c.size = 3;
    c.vertex[0] = 3;
    c.spoke[0] = 9;
    CHECK_EQ(cqi_take_candidate(&p, &c), 6);
    CHECK_EQ(cqi_take_candidate(&p, &c), 3);
    CHECK_EQ(cqi_take_candidate(&p, &c), 9);
    CHECK_EQ(c.size, 0);
    CHECK_EQ(cqi_square_distance(positions, 1, 2), 16 + 9);
}

TEST(the_map_may_be_null)
{
    FOR_EACH_SAMPLE(s, c) {
        cq_place place;
        s.input.map = NULL;
        CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
    }
}

/* -- Memory and output --------------------------------------------------------------------------------------------- */

TEST(encoder_memory_that_is_short_is_an_error_and_the_shape_tells_the_need)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t size = cq_encoder_bytes(&c.shape), less, stream_size = 0;
        uint8_t *out = (uint8_t *)exact_alloc(c.size);
        for (less = 1; less <= size; less = less * 3 + 1) {
            void *memory = exact_alloc(size - less);
            cq_input in = s.input;
            in.shape = c.shape;
            CHECK_EQ(cq_encode(&in, memory, size - less, out, c.size, &stream_size, NULL, NULL), CQ_ERROR_MEMORY);
            exact_free(memory);
        }
        {
            void *memory = exact_alloc(size);
            cq_input in = s.input;
            CHECK_EQ(cq_encode(&in, memory, size, out, c.size, &stream_size, NULL, NULL), CQ_OK);
            CHECK_EQ(stream_size, c.size);
            CHECK(memcmp(out, c.bytes, c.size) == 0);
            exact_free(memory);
        }
        exact_free(out);
    }
}

TEST(a_mesh_with_boundaries_needs_two_tries_and_tells_its_loops_on_the_first)
{
    sample s;
    cq_input in;
    void *memory;
    size_t size, stream_size;
    sample_begin(&s, triangles_annulus(300));
    in = s.input;
    size = cq_encoder_bytes(&in.shape);
    memory = exact_alloc(size);
    CHECK_EQ(cq_encode(&in, memory, size, NULL, 0, &stream_size, NULL, NULL), CQ_ERROR_MEMORY);
    CHECK_EQ(in.shape.num_boundary_loops, 2);
    CHECK_EQ(in.shape.num_boundary_edges, 600);
    exact_free(memory);
    size = cq_encoder_bytes(&in.shape);
    memory = exact_alloc(size);
    CHECK_EQ(cq_encode(&in, memory, size, NULL, 0, &stream_size, NULL, NULL), CQ_ERROR_OUTPUT);
    exact_free(memory);
    sample_free(&s);
}

/* Encodes in exactly the memory that is enough for any triangles; the share of it that these needed. */
static double share_of_most(const cq_input *input)
{
    cq_input in = *input;
    const size_t most = cq_encoder_bytes_at_most(&in.shape);
    void *memory = exact_alloc(most);
    size_t size;
    CHECK_EQ(cq_encode(&in, memory, most, NULL, 0, &size, NULL, NULL), CQ_ERROR_OUTPUT);
    CHECK(cq_encoder_bytes(&in.shape) <= most);
    exact_free(memory);
    return (double)cq_encoder_bytes(&in.shape) / (double)most;
}

/* Triangles between places of a grid, some rows of no face, some rows at one place; values of rows and of faces. */
static void random_triangles(cq_input *in, cq_index *index, cq_value *value, uint64_t *random)
{
    const uint32_t places = 2 + (uint32_t)(next_random(random) % 40), texcoords = 1 + (uint32_t)(next_random(random) % 4);
    uint32_t k;
    cq_channel *c = in->shape.channel;
    memset(in, 0, sizeof *in);
    in->shape.num_vertices = 3 + (uint32_t)(next_random(random) % 120);
    in->shape.num_faces = (uint32_t)(next_random(random) % 200);
    in->shape.num_channels = (uint32_t)(next_random(random) % 4);
    in->shape.num_materials = (uint32_t)(next_random(random) % 3);
    c[0].kind = CQ_POSITION;
    c[0].components = 3;
    c[1].kind = CQ_TEXCOORD;
    c[1].components = 2;
    c[2].kind = CQ_GROUP;
    c[2].components = 1;
    c[2].merge = CQ_PER_FACE;
    c[0].bits = c[1].bits = c[2].bits = 12;
    for (k = 0; k < 3 * in->shape.num_faces; ++k) index[k] = (cq_index)(next_random(random) % in->shape.num_vertices);
    for (k = 0; k < 3 * in->shape.num_vertices; ++k) {
        const uint32_t x = (uint32_t)(next_random(random) % places);
        value[k - k % 3] = (cq_value)x;
        value[k] = (cq_value)(x * x % 7);
        value[1000 + k] = (cq_value)(next_random(random) % texcoords);
    }
    for (k = 0; k < in->shape.num_faces; ++k)
        index[1000 + k] = (cq_index)(k % (in->shape.num_materials + !in->shape.num_materials));
    in->indices = index;
    in->materials = index + 1000;
    in->values[0] = value;
    in->values[1] = in->values[2] = value + 1000;
}

/* Rows are copied where triangles do not share them, so it is not enough to count those of the input. */
TEST(noise_takes_less_room_than_4_bytes_per_number_with_a_row_for_each_corner)
{
    static cq_index index[1300];
    static cq_value value[1400], noise[16 * 120];
    uint64_t random = 8;
    double largest = 0;
    int k;
    for (k = 0; k < 300; ++k) {
        cq_input in;
        coded c;
        uint32_t j;
        double room;
        random_triangles(&in, index, value, &random);
        in.shape.num_channels = 3;
        in.shape.channel[2].kind = CQ_GENERIC;
        in.shape.channel[2].components = 4;
        in.shape.channel[2].merge = CQ_AVERAGE;
        for (j = 0; j < 3; ++j) in.shape.channel[j].bits = CQ_MAX_BITS;
        if (k % 2 && CQ_INDEX_BITS == 32) in.shape.channel[0].bits = in.shape.channel[2].bits = CQ_EXACT_BITS;
        for (j = 0; j < 16 * 120; ++j) noise[j] = (cq_value)(next_random(&random) & (((uint32_t)1 << CQ_MAX_BITS) - 1));
        if (k % 2 && CQ_INDEX_BITS == 32)
            for (j = 0; j < 16 * 120; ++j) noise[j] = (cq_value)(next_random(&random) >> 11);
        in.values[0] = noise;
        in.values[1] = in.shape.channel[1].bits == CQ_EXACT_BITS ? noise : value;
        in.values[2] = noise + 4;
        code(&c, &in);
        CHECK_EQ(c.result, CQ_OK);
        room = 1024 + 4.0 * (3 * in.shape.num_faces + 9 * (3 * in.shape.num_faces + in.shape.num_vertices));
        CHECK((double)c.size < room);
        largest = fmax(largest, (double)c.size / room);
        uncode(&c);
    }
    printf("  noise takes up to %.2f of that room\n", largest);
}

TEST(memory_at_most_is_enough_for_any_triangles)
{
    static cq_index index[1300];
    static cq_value value[1400];
    uint64_t random = 5;
    int k, more = 0;
    for (k = 0; k < 400; ++k) {
        cq_input in;
        double share;
        random_triangles(&in, index, value, &random);
        share = share_of_most(&in);
        more += share * (double)cq_encoder_bytes_at_most(&in.shape) > (double)cq_encoder_bytes(&in.shape);
    }
    CHECK(more > 300);
}

/* i, i + 1, i + 4 and i, i + 2, i + 7 share no edge: each corner is a vertex of the mesh, each edge a boundary. */
TEST(memory_at_most_is_little_more_than_triangles_without_common_edges_need)
{
    enum { ROWS = CQ_INDEX_BITS == 16 ? 2500 : 3000 };
    static cq_index index[6 * ROWS];
    static cq_value value[3 * ROWS];
    cq_input in;
    int k;
    memset(&in, 0, sizeof in);
    for (k = 0; k < ROWS; ++k) {
        const int corner[6] = { 0, 1, 4, 0, 2, 7 };
        int j;
        for (j = 0; j < 6; ++j) index[6 * k + j] = (cq_index)((k + corner[j]) % ROWS);
        value[3 * k] = (cq_value)k;
    }
    in.indices = index;
    in.values[0] = value;
    in.shape.num_vertices = ROWS;
    in.shape.num_faces = 2 * ROWS;
    in.shape.num_channels = 1;
    in.shape.channel[0].kind = CQ_POSITION;
    in.shape.channel[0].components = 3;
    in.shape.channel[0].bits = 12;
    CHECK(share_of_most(&in) > (CQ_INDEX_BITS == 16 ? 0.8 : 0.9));
}

/* Which is what it needs, but for blocks that end in the middle of a word; or what the preparation had, where that takes
 * more. */
TEST(the_decoder_that_replays_gets_the_rest_of_the_memory)
{
    int samples = 0, exact = 0;
    FOR_EACH_SAMPLE(s, c) {
        const size_t size = cq_encoder_bytes(&c.shape);
        void *memory = exact_alloc(size);
        const cqi_encoder *e = (const cqi_encoder *)memory;
        size_t stream_size;
        cq_input in = s.input;
        CHECK_EQ(cq_encode(&in, memory, size, NULL, 0, &stream_size, NULL, NULL), CQ_ERROR_OUTPUT);
        CHECK(e->replay.memory + e->replay.memory_size == (const uint8_t *)memory + size);
        if (size != CQI_ENCODER_BYTES + cqi_preparing_bytes(&c.shape)) {
            CHECK(e->replay.memory_size - cq_decoder_bytes(&c.shape) <= 40);
            exact++;
        }
        samples++;
        exact_free(memory);
    }
    CHECK(exact > 0 && exact + 1 >= samples);
}

/* Where there are many faces of few vertices: here one face time and again, all but one of which go aside. Memory that is
 * enough to find that is not yet enough to code it. */
TEST(the_preparation_may_take_more_than_the_coding_of_what_comes_in)
{
    enum { FACES = 5000 };
    static cq_index indices[3 * FACES];
    cq_input in;
    size_t size, stream_size, f;
    void *memory;
    coded c;
    decoding d;
    memset(&in, 0, sizeof in);
    in.shape.num_vertices = 3;
    in.shape.num_faces = FACES;
    in.indices = indices;
    for (f = 0; f < FACES; ++f) indices[3 * f + 1] = 1, indices[3 * f + 2] = 2;
    code(&c, &in);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
    CHECK_EQ(d.decoder->mesh.num_faces, 1);
    CHECK_EQ(d.decoder->shape.num_aside_faces, FACES - 1);
    decoding_free(&d);
    uncode(&c);
    size = cq_encoder_bytes(&in.shape);
    CHECK_EQ(size, CQI_ENCODER_BYTES + cqi_preparing_bytes(&in.shape));
    memory = exact_alloc(size);
    CHECK_EQ(cq_encode(&in, memory, size, NULL, 0, &stream_size, NULL, NULL), CQ_ERROR_MEMORY);
    CHECK_EQ(in.shape.num_aside_faces, FACES - 1);
    CHECK(cq_encoder_bytes(&in.shape) > size);
    exact_free(memory);
}

TEST(misaligned_encoder_memory_is_an_error)
{
    sample s;
    size_t size, stream_size, shift;
    sample_make(&s, 1);
    size = cq_encoder_bytes(&s.input.shape);
    for (shift = 1; shift < 8; ++shift) {
        uint8_t *memory = (uint8_t *)exact_alloc(size + 8);
        cq_input in = s.input;
        CHECK_EQ(cq_encode(&in, memory + shift, size, NULL, 0, &stream_size, NULL, NULL), CQ_ERROR_MEMORY);
        exact_free(memory);
    }
    sample_free(&s);
}

TEST(every_output_that_is_too_small_is_full_and_the_size_is_told)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t memory_size = cq_encoder_bytes(&c.shape), size, step = 1 + c.size / 150;
        void *memory = exact_alloc(memory_size);
        for (size = 0; size < c.size; size += step) {
            uint8_t *out = (uint8_t *)exact_alloc(size);
            cq_input in = s.input;
            size_t stream_size = 0;
            CHECK_EQ(cq_encode(&in, memory, memory_size, out, size, &stream_size, NULL, NULL), CQ_ERROR_OUTPUT);
            CHECK_EQ(stream_size, c.size);
            exact_free(out);
        }
        {
            uint8_t *out = (uint8_t *)exact_alloc(c.size - 1);
            cq_input in = s.input;
            size_t stream_size = 0;
            CHECK_EQ(cq_encode(&in, memory, memory_size, out, c.size - 1, &stream_size, NULL, NULL), CQ_ERROR_OUTPUT);
            CHECK_EQ(stream_size, c.size);
            exact_free(out);
        }
        exact_free(memory);
    }
}

TEST(an_output_that_is_larger_than_needed_gets_the_same_bytes)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t memory_size = cq_encoder_bytes(&c.shape), extra;
        void *memory = exact_alloc(memory_size);
        for (extra = 1; extra < 1000; extra = extra * 4 + 1) {
            uint8_t *out = (uint8_t *)exact_alloc(c.size + extra);
            cq_input in = s.input;
            size_t stream_size = 0;
            cq_report *report = extra < 2 ? NULL : (cq_report *)exact_alloc(sizeof *report);
            CHECK_EQ(cq_encode(&in, memory, memory_size, out, c.size + extra, &stream_size, NULL, report), CQ_OK);
            CHECK_EQ(stream_size, c.size);
            CHECK(memcmp(out, c.bytes, c.size) == 0);
            if (report) CHECK(memcmp(report, c.report, sizeof *report) == 0);
            if (report) exact_free(report);
            exact_free(out);
        }
        exact_free(memory);
    }
}

TEST(the_same_input_gives_the_same_bytes_whatever_is_in_the_memory)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t memory_size = cq_encoder_bytes(&c.shape);
        int fill;
        for (fill = 0; fill < 256; fill += 51) {
            void *memory = exact_alloc(memory_size);
            uint8_t *out = (uint8_t *)exact_alloc(c.size);
            cq_index *map = (cq_index *)exact_alloc(s.mesh.num_vertices * sizeof(cq_index));
            cq_input in = s.input;
            size_t stream_size;
            memset(memory, fill, memory_size);
            in.map = map;
            CHECK_EQ(cq_encode(&in, memory, memory_size, out, c.size, &stream_size, NULL, NULL), CQ_OK);
            CHECK_EQ(stream_size, c.size);
            CHECK(memcmp(out, c.bytes, c.size) == 0);
            CHECK(memcmp(map, c.map, s.mesh.num_vertices * sizeof(cq_index)) == 0);
            exact_free(map);
            exact_free(memory);
            exact_free(out);
        }
    }
}

TEST(the_input_is_not_changed)
{
    FOR_EACH_SAMPLE(s, c) {
        sample again;
        uint32_t k;
        sample_make(&again, which_s);
        CHECK(memcmp(again.mesh.indices, s.mesh.indices, 3 * (size_t)s.mesh.num_faces * sizeof(cq_index)) == 0);
        for (k = 0; k < s.input.shape.num_channels; ++k)
            CHECK(memcmp(again.values[k], s.values[k], s.input.shape.channel[k].components * sizeof(cq_value)
                         * num_owners(&s.input.shape.channel[k], s.mesh.num_vertices, s.mesh.num_faces)) == 0);
        sample_free(&again);
    }
}

/* -- Arguments and values ------------------------------------------------------------------------------------------ */

TEST(null_arguments_of_encode_are_an_error)
{
    sample s;
    size_t size, stream_size;
    void *memory;
    uint8_t out[4096];
    cq_input in;
    sample_make(&s, 1);
    size = cq_encoder_bytes(&s.input.shape);
    memory = exact_alloc(size);
    in = s.input;
    CHECK_EQ(cq_encode(NULL, memory, size, out, sizeof out, &stream_size, NULL, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_encode(&in, memory, size, out, sizeof out, NULL, NULL, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_encode(&in, memory, size, NULL, 10, &stream_size, NULL, NULL), CQ_ERROR_ARGUMENT);
    CHECK(cq_encode(&in, NULL, size, out, sizeof out, &stream_size, NULL, NULL) < 0);
    in.indices = NULL;
    CHECK_EQ(cq_encode(&in, memory, size, out, sizeof out, &stream_size, NULL, NULL), CQ_ERROR_ARGUMENT);
    in = s.input;
    in.values[0] = NULL;
    CHECK_EQ(cq_encode(&in, memory, size, out, sizeof out, &stream_size, NULL, NULL), CQ_ERROR_ARGUMENT);
    exact_free(memory);
    sample_free(&s);
}

TEST(materials_and_metadata_that_are_announced_are_there)
{
    cq_index materials[20];
    uint8_t byte = 7;
    sample s;
    memset(materials, 0, sizeof materials);
    sample_begin(&s, triangles_icosahedron());
    s.input.shape.num_materials = CQ_MAX_MATERIALS;
    s.input.materials = materials;
    CHECK_EQ(encode_once(&s.input, NULL), CQ_OK);
    s.input.shape.num_materials = CQ_MAX_MATERIALS + 1;
    CHECK_EQ(encode_once(&s.input, NULL), CQ_ERROR_ARGUMENT);
    s.input.shape.num_materials = 2;
    s.input.materials = NULL;
    CHECK_EQ(encode_once(&s.input, NULL), CQ_ERROR_ARGUMENT);
    s.input.shape.num_materials = 1; /* one is none */
    CHECK_EQ(encode_once(&s.input, NULL), CQ_OK);
    s.input.shape.metadata_bytes = 1;
    CHECK_EQ(encode_once(&s.input, NULL), CQ_ERROR_ARGUMENT);
    s.input.metadata = &byte;
    CHECK_EQ(encode_once(&s.input, NULL), CQ_OK);
    sample_free(&s);
}

/* Where faces went is found out for materials, even if nobody asks for it. */
TEST(materials_make_the_same_stream_without_a_face_map)
{
    cq_index materials[288];
    sample s;
    coded c;
    uint32_t f;
    sample_begin(&s, triangles_torus(12, 12));
    sample_channel(&s, CQ_POSITION, 3, 12);
    for (f = 0; f < 288; ++f) materials[f] = (cq_index)(f / 50 % 3);
    s.input.shape.num_materials = 3;
    s.input.materials = materials;
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK_EQ(encode_once(&s.input, NULL), CQ_OK);
    CHECK(memcmp(encoded_once, c.bytes, c.size) == 0);
    uncode(&c);
    sample_free(&s);
}

TEST(a_bad_value_is_found_in_any_channel)
{
    uint32_t k;
    for (k = 0; k < 3; ++k) {
        sample s;
        cq_place place;
        sample_begin(&s, triangles_icosahedron());
        sample_channel(&s, CQ_GENERIC, 1, 3);
        sample_channel(&s, CQ_GENERIC, 1, 3);
        sample_channel(&s, CQ_GENERIC, 1, 3);
        s.values[k][7] = 8;
        CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 7);
        sample_free(&s);
    }
}

TEST(channels_outside_their_ranges_are_an_argument_error)
{
    static const struct { int kind, components, bits, merge; } bad[] = {
        {CQ_GENERIC, 0, 8, 0}, {CQ_GENERIC, 5, 8, 0}, {CQ_GENERIC, 255, 8, 0}, {CQ_GENERIC, 3, 0, 0},
        {CQ_GENERIC, 3, 25, 0}, {CQ_GENERIC, 3, 255, 0}, {CQ_TURNED, 1, 8, 0}, {CQ_TURNED, 1, 1, CQ_PER_FACE}, {CQ_TANGENT, 1, 8, 0}, {CQ_TANGENT + 1, 1, 8, 0}, {255, 3, 8, 0},
        {CQ_POSITION, 2, 8, 0}, {CQ_POSITION, 1, 8, 0}, {CQ_POSITION, 4, 8, 0}, {CQ_GENERIC, 3, 8, CQ_PER_FACE},
        {CQ_GENERIC, 1, 8, CQ_PER_FACE + 1}, {CQ_GENERIC, 1, 8, 255}, {CQ_NUMBER, 2, 8, 0}, {CQ_GROUP, 2, 8, 0},
        {CQ_NORMAL, 1, 8, 0}, {CQ_NORMAL, 4, 8, 0}, {CQ_TEXCOORD, 3, 8, 0}, {CQ_COLOR, 2, 8, 0},
        {CQ_GENERIC, 1, 31, 0}, {CQ_GENERIC, 1, 33, 0}};
    size_t k;
    for (k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
        sample s;
        cq_place place;
        sample_begin(&s, triangles_icosahedron());
        sample_channel(&s, CQ_GENERIC, 4, 1);
        s.input.shape.channel[0].kind = (uint8_t)bad[k].kind;
        s.input.shape.channel[0].components = (uint8_t)bad[k].components;
        s.input.shape.channel[0].bits = (uint8_t)bad[k].bits;
        s.input.shape.channel[0].merge = (uint8_t)bad[k].merge;
        CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_ARGUMENT);
        sample_free(&s);
    }
}

TEST(values_wider_than_a_build_has_are_not_supported)
{
    static const struct { int bits, merge; } wide[] = {{16, CQ_AVERAGE}, {24, CQ_COPY}, {CQ_EXACT_BITS, CQ_AVERAGE},
                                                       {CQ_EXACT_BITS, CQ_COPY}, {CQ_EXACT_BITS, CQ_PER_FACE}};
    size_t k;
    for (k = 0; k < sizeof wide / sizeof wide[0]; ++k) {
        sample s;
        cq_place place;
        sample_begin(&s, triangles_icosahedron());
        sample_merged(&s, CQ_GENERIC, (cq_merge)wide[k].merge, 1, 1);
        s.input.shape.channel[0].bits = (uint8_t)wide[k].bits;
        CHECK_EQ(encode_once(&s.input, &place), CQ_INDEX_BITS == 16 ? CQ_ERROR_UNSUPPORTED : CQ_OK);
        sample_free(&s);
    }
}

TEST(counts_that_an_index_cannot_number_are_too_large_to_encode)
{
    static const uint32_t counts[][2] = {{4, 0xffffffffu}, {4, 0x55555556u}, {0xffffffffu, 4}};
    size_t k;
    for (k = 0; k < 3; ++k) {
        sample s;
        cq_place place;
        sample_begin(&s, triangles_tetrahedron());
        s.input.shape.num_vertices = counts[k][0];
        s.input.shape.num_faces = counts[k][1];
        CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_TOO_LARGE);
        sample_free(&s);
    }
}

#if CQ_INDEX_BITS == 16
/* Closed, the faces can be numbered; with a face beyond each of their edges, or with rows of their own, no more. */
TEST(meshes_that_only_grow_too_large_are_told)
{
    static cq_index index[3 * 6000];
    cq_input in;
    coded c;
    uint32_t f, book;
    for (book = 0; book < 2; ++book) {
        memset(&in, 0, sizeof in);
        in.indices = index;
        in.shape.num_faces = 6000;
        in.shape.num_vertices = book ? 6002 : 18000;
        for (f = 0; f < 6000; ++f) {
            index[3 * f] = (cq_index)(book ? 0 : 3 * f);
            index[3 * f + 1] = (cq_index)(book ? 1 : 3 * f + 1);
            index[3 * f + 2] = (cq_index)(book ? 2 + f : 3 * f + 2);
        }
        CHECK(cq_encoder_bytes(&in.shape) > 0);
        code(&c, &in);
        CHECK_EQ(c.result, CQ_ERROR_TOO_LARGE);
        uncode(&c);
    }
}
#endif

TEST(more_than_eight_channels_are_an_argument_error)
{
    sample s;
    cq_place place;
    sample_begin(&s, triangles_icosahedron());
    s.input.shape.num_channels = CQ_MAX_CHANNELS + 1;
    CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_ARGUMENT);
    s.input.shape.num_channels = 0xffffffffu;
    CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_ARGUMENT);
    sample_free(&s);
}

TEST(a_value_outside_its_bits_is_an_error_at_its_vertex)
{
    static const int bits[] = {1, 7, 12, CQ_MAX_BITS};
    static const uint32_t vertices[] = {0, 5, 11, 5};
    int b, way;
    for (b = 0; b < 4; ++b) {
        for (way = 0; way < 4; ++way) {
            uint32_t v = vertices[(b + way) % 4], at = 3 * v + (uint32_t)(b % 3);
            sample s;
            cq_place place;
            cq_value top = (cq_value)(((int32_t)1 << bits[b]) - 1), bad;
            sample_begin(&s, triangles_icosahedron());
            sample_channel(&s, CQ_GENERIC, 1, 3);
            sample_channel(&s, CQ_GENERIC, 3, bits[b]);
            s.values[1][at] = top;
            CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
            s.values[1][at] = 0;
            CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
            bad = way == 0 ? (cq_value)-1 : (cq_value)(way == 1 ? -32768 : way == 2 ? top + 1 : 32767);
            if (bad < 0 || bad > top) {
                s.values[1][at] = bad;
                CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_VALUE);
                CHECK_EQ(place.vertex, v);
                CHECK_EQ(place.face, CQ_NONE);
                CHECK_EQ(place.other, CQ_NONE);
            }
            sample_free(&s);
        }
    }
}

TEST(a_value_of_a_face_outside_its_bits_is_an_error_at_its_face)
{
    sample s;
    cq_place place;
    sample_begin(&s, triangles_icosahedron());
    sample_merged(&s, CQ_GROUP, CQ_PER_FACE, 1, 5);
    s.values[0][19] = 31;
    CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
    s.values[0][19] = 32;
    CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_VALUE);
    CHECK_EQ(place.face, 19);
    CHECK_EQ(place.vertex, CQ_NONE);
    sample_free(&s);
}

TEST(a_mesh_that_is_no_manifold_is_taken_but_for_a_vertex_that_does_not_exist)
{
    static const int bow_tie[] = {0, 1, 2, 2, 3, 4};
    static const int fins[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    sample s;
    cq_place place;
    sample_begin(&s, triangles_of(5, 2, bow_tie));
    CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
    CHECK_EQ(place.vertex, CQ_NONE);
    sample_free(&s);
    sample_begin(&s, triangles_of(5, 3, fins));
    CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
    sample_free(&s);
    sample_begin(&s, triangles_moebius(6));
    CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
    sample_free(&s);
    sample_begin(&s, triangles_tetrahedron());
    s.mesh.indices[7] = 9;
    CHECK_EQ(encode_once(&s.input, &place), CQ_ERROR_INDEX);
    CHECK_EQ(place.face, 2);
    CHECK_EQ(place.vertex, 9);
    sample_free(&s);
    sample_begin(&s, triangles_tetrahedron());
    s.input.shape.num_vertices = 5;
    CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
    sample_free(&s);
}

TEST(a_mesh_without_vertices_round_trips_or_is_refused)
{
    sample s;
    coded c;
    sample_begin(&s, triangles_none());
    code(&c, &s.input);
    CHECK(c.result == CQ_OK || c.result == CQ_ERROR_ARGUMENT);
    if (c.result == CQ_OK) {
        decoding d;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, 1), CQ_DONE);
        CHECK_EQ(d.decoder->mesh.num_vertices, 0);
        decoding_free(&d);
    }
    uncode(&c);
    sample_free(&s);
}

/* -- Progress ------------------------------------------------------------------------------------------------------ */

typedef struct progress {
    uint32_t calls, last, bad;
} progress;

static void note_progress(void *user, uint32_t done, uint32_t total)
{
    progress *p = (progress *)user;
    if (done > total || (p->calls > 0 && done < p->last)) p->bad++;
    p->last = done;
    p->calls++;
}

TEST(progress_goes_forward_and_never_beyond_its_total)
{
    FOR_EACH_SAMPLE(s, c) {
        progress p;
        cq_place place;
        p.calls = p.last = p.bad = 0;
        s.input.progress = note_progress;
        s.input.user = &p;
        CHECK_EQ(encode_once(&s.input, &place), CQ_OK);
        CHECK_EQ(p.bad, 0);
        if (which_s == 4) CHECK(p.calls > 0);
        CHECK(p.calls <= c.report->num_components + 1);   /* not at every step */
    }
}

/* -- What the streams are worth ------------------------------------------------------------------------------------ */

TEST(streams_refine_a_coarse_base)
{
    /* A torus of 240 vertices must come down far: 7 vertices are the least a torus has. */
    sample s;
    coded c;
    REQUIRE_EQ(sample_code(&s, &c, 4), CQ_OK);
    CHECK(c.report->num_levels >= 4);
    CHECK(c.report->base_vertices < 30);
    /* The bound of the paper's section 3 is 4.85 bits per vertex; a regular mesh stays far below it. */
    CHECK((c.report->base + c.report->flags + c.report->indices) / 65536 < 320 * s.mesh.num_vertices / 100);
    uncode(&c);
    sample_free(&s);
}

/* Both faces of the pillow begin at one vertex. */
TEST(components_whose_faces_are_mixed_come_back)
{
    static const int faces[] = {0, 1, 2, 4, 5, 6, 0, 3, 1, 4, 6, 5, 0, 2, 3, 1, 3, 2};
    sample s;
    coded c;
    decoding d;
    sample_begin(&s, triangles_of(7, 6, faces));
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
    CHECK_EQ(d.decoder->num_components, 2);
    CHECK_EQ(d.decoder->mesh.num_vertices, 7);
    CHECK_EQ(d.decoder->mesh.num_faces, 6);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

TEST(thousands_of_components_cost_bits_each_not_bytes)
{
    enum { COUNT = 1500 };
    static int faces[12 * COUNT];
    static const int tetrahedron[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    sample s;
    coded c;
    decoding d;
    int k, j;
    for (k = 0; k < COUNT; ++k)
        for (j = 0; j < 12; ++j) faces[12 * k + j] = 4 * k + tetrahedron[j];
    sample_begin(&s, triangles_of(4 * COUNT, 4 * COUNT, faces));
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK_EQ(c.report->num_components, COUNT);
    CHECK(8 * c.size < 2 * COUNT);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 100, CQ_NO_LIMIT), CQ_DONE);
    CHECK_EQ(d.decoder->mesh.num_faces, 4 * COUNT);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

#if CQ_INDEX_BITS == 32
/* Bit models adapt more slowly from 1024 and from 8192 vertices on. */
TEST(ten_thousand_vertices_come_back)
{
    sample s;
    coded c;
    decoding d;
    uint32_t v;
    sample_begin(&s, triangles_torus(100, 100));
    sample_channel(&s, CQ_GENERIC, 1, 8);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1000, 1000), CQ_DONE);
    for (v = 0; v < s.mesh.num_vertices; ++v) CHECK_EQ(d.decoder->channel[0][c.map[v]], s.values[0][v]);
    CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}
#endif

TEST(equal_values_cost_next_to_nothing)
{
    sample s;
    coded c;
    uint32_t v;
    sample_begin(&s, triangles_torus(16, 16));
    sample_channel(&s, CQ_GENERIC, 4, 12);
    for (v = 0; v < 4 * 256; ++v) s.values[0][v] = 2048;
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK(c.report->channels + c.report->positions < (uint64_t)65536 * 256);
    uncode(&c);
    sample_free(&s);
}

TEST(a_vertex_of_large_valence_is_left_alone)
{
    /* The poles have far more neighbours than a centre that may be split. */
    sample s;
    coded c;
    decoding d;
    sample_begin(&s, triangles_bipyramid(200));
    sample_channel(&s, CQ_POSITION, 3, 10);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, 1), CQ_DONE);
    CHECK_EQ(d.decoder->mesh.valence[c.map[200]], 200);
    CHECK_EQ(d.decoder->mesh.valence[c.map[201]], 200);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

/* Bits of the base of a bipyramid that is all in it, if so many vertices of its equator, from `from` on, have another value
 * than the others, and one of its poles, which comes last, has `value`. */
static uint64_t base_of_bipyramid(uint32_t n, uint32_t from, uint32_t count, cq_value value)
{
    sample s;
    coded c;
    uint64_t bits = 0;
    uint8_t *locked;
    uint32_t k;
    sample_begin(&s, triangles_bipyramid(n));
    s.mesh.indices[0] = (cq_index)n, s.mesh.indices[1] = 0, s.mesh.indices[2] = 1; /* around the other pole first */
    sample_channel(&s, CQ_GENERIC, 1, 12);
    for (k = 0; k < n; ++k) s.values[0][k] = (cq_value)((k + n - from) % n < count ? 3000 : 100);
    s.values[0][n] = 100;
    s.values[0][n + 1] = value;
    locked = (uint8_t *)exact_alloc(n + 2);
    memset(locked, 1, n + 2);
    s.input.locked = locked;
    code(&c, &s.input);
    CHECK_EQ(c.result, CQ_OK);
    if (c.result == CQ_OK) {
        CHECK_EQ(c.map[n + 1], n + 1);
        bits = c.report->base + c.report->channels;
    }
    exact_free(locked);
    uncode(&c);
    sample_free(&s);
    return bits;
}

/* Of 100 neighbours that are known, 64 have one value: that is expected if most of the others are not asked. */
TEST(a_base_value_is_predicted_by_64_neighbours)
{
    uint32_t from, by_first = 0, by_all = 0;
    for (from = 0; from < 100; ++from) {
        const uint64_t first = base_of_bipyramid(100, from, 36, 100), all = base_of_bipyramid(100, from, 36, 1144);
        by_first += first < all;
        by_all += first > all;
    }
    CHECK(by_first > 20);
    CHECK(by_all > 20);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(the_map_is_a_permutation);
    RUN(the_face_map_leads_to_the_same_corners);
    RUN(the_stream_is_the_same_if_nobody_asks_for_maps);
    RUN(the_map_leads_to_the_values_of_each_vertex);
    RUN(the_goal_changes_what_is_collapsed_and_not_what_comes_back);
    RUN(connectivity_costs_less_with_positions);
    RUN(the_goal_balanced_keeps_planes_creases_and_boundaries);
    RUN(quadric_errors_are_compared_by_their_logarithms);
    RUN(errors_have_the_nearest_code_that_is_not_less);
    RUN(a_collapse_loses_areas_times_squared_distances_or_if_it_turns_a_triangle_anything);
    RUN(a_fan_says_the_same_as_the_mesh_of_what_may_be_collapsed);
    RUN(reports_take_logarithms_within_a_6000th_that_never_fall);
    RUN(the_smallest_valence_is_best_then_if_that_is_the_goal_the_nearest_vertex);
    RUN(the_map_may_be_null);
    RUN(encoder_memory_that_is_short_is_an_error_and_the_shape_tells_the_need);
    RUN(a_mesh_with_boundaries_needs_two_tries_and_tells_its_loops_on_the_first);
    RUN(noise_takes_less_room_than_4_bytes_per_number_with_a_row_for_each_corner);
    RUN(memory_at_most_is_enough_for_any_triangles);
    RUN(memory_at_most_is_little_more_than_triangles_without_common_edges_need);
    RUN(the_decoder_that_replays_gets_the_rest_of_the_memory);
    RUN(the_preparation_may_take_more_than_the_coding_of_what_comes_in);
    RUN(misaligned_encoder_memory_is_an_error);
    RUN(every_output_that_is_too_small_is_full_and_the_size_is_told);
    RUN(an_output_that_is_larger_than_needed_gets_the_same_bytes);
    RUN(the_same_input_gives_the_same_bytes_whatever_is_in_the_memory);
    RUN(the_input_is_not_changed);
    RUN(null_arguments_of_encode_are_an_error);
    RUN(materials_and_metadata_that_are_announced_are_there);
    RUN(materials_make_the_same_stream_without_a_face_map);
    RUN(a_bad_value_is_found_in_any_channel);
    RUN(channels_outside_their_ranges_are_an_argument_error);
    RUN(values_wider_than_a_build_has_are_not_supported);
    RUN(counts_that_an_index_cannot_number_are_too_large_to_encode);
#if CQ_INDEX_BITS == 16
    RUN(meshes_that_only_grow_too_large_are_told);
#endif
    RUN(more_than_eight_channels_are_an_argument_error);
    RUN(a_value_outside_its_bits_is_an_error_at_its_vertex);
    RUN(a_value_of_a_face_outside_its_bits_is_an_error_at_its_face);
    RUN(a_mesh_that_is_no_manifold_is_taken_but_for_a_vertex_that_does_not_exist);
    RUN(a_mesh_without_vertices_round_trips_or_is_refused);
    RUN(progress_goes_forward_and_never_beyond_its_total);
    RUN(streams_refine_a_coarse_base);
    RUN(components_whose_faces_are_mixed_come_back);
    RUN(thousands_of_components_cost_bits_each_not_bytes);
#if CQ_INDEX_BITS == 32
    RUN(ten_thousand_vertices_come_back);
#endif
    RUN(equal_values_cost_next_to_nothing);
    RUN(a_vertex_of_large_valence_is_left_alone);
    RUN(a_base_value_is_predicted_by_64_neighbours);
    return TEST_END();
}
