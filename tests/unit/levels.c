/* Levels: what the base comes down to, errors against measured distances, hubs, normals. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "sample.h"
#include "test.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

/* -- Surfaces of revolution ---------------------------------------------------------------------------------------- */

/* Rings of `sides` vertices each, from below; `caps`: bit 0, a vertex in the middle closes the first, bit 1, the last. */
static triangles lathe(uint32_t sides, uint32_t rings, int caps)
{
    triangles t = triangles_grid(sides, rings, 1, 0, 0), closed;
    const uint32_t middle[2] = {t.num_vertices, t.num_vertices + (caps & 1)};
    uint32_t end, k;
    closed.num_vertices = t.num_vertices + (uint32_t)(caps & 1) + (uint32_t)(caps >> 1);
    closed.num_faces = t.num_faces + sides * ((uint32_t)(caps & 1) + (uint32_t)(caps >> 1));
    closed.indices = (cq_index *)exact_alloc(3 * (size_t)closed.num_faces * sizeof(cq_index));
    memcpy(closed.indices, t.indices, 3 * (size_t)t.num_faces * sizeof(cq_index));
    closed.num_faces = t.num_faces;
    for (end = 0; end < 2; ++end) {
        const uint32_t first = end ? (rings - 1) * sides : 0;
        for (k = 0; k < sides && caps >> end & 1; ++k) {
            cq_index *f = closed.indices + 3 * closed.num_faces++;
            f[0] = (cq_index)middle[end];
            f[1 + end] = (cq_index)(first + (k + 1) % sides);
            f[2 - end] = (cq_index)(first + k);
        }
    }
    triangles_free(&t);
    return closed;
}

/* Places vertex v at a point with coordinates from -1 to 1. */
static void place(sample *s, uint32_t v, double x, double y, double z)
{
    const double scale = (double)(((int32_t)1 << s->input.shape.channel[0].bits) - 1) / 2;
    cq_value *at = s->values[0] + 3 * v;
    at[0] = (cq_value)floor((x + 1) * scale + 0.5);
    at[1] = (cq_value)floor((y + 1) * scale + 0.5);
    at[2] = (cq_value)floor((z + 1) * scale + 0.5);
}

/* A sphere with a pole at each end; `flat` of 1: a cylinder with caps, cones between. */
static void lathe_sample(sample *s, uint32_t sides, uint32_t rings, int caps, double flat, int bits)
{
    uint32_t v;
    sample_begin(s, lathe(sides, rings, caps));
    sample_channel(s, CQ_POSITION, 3, bits);
    for (v = 0; v < s->mesh.num_vertices; ++v) {
        const uint32_t ring = v / sides;
        const double up = PI * (ring + 1) / (rings + 1) - PI / 2, turn = 2 * PI * (v % sides) / sides;
        const double radius = flat + (1 - flat) * cos(up);
        if (ring < rings) place(s, v, radius * cos(turn), radius * sin(turn), sin(up));
        else place(s, v, 0, 0, v == s->mesh.num_vertices - 1 && (caps & 2) ? 1 : -1);
    }
}

/* -- What levels come down to -------------------------------------------------------------------------------------- */

#define SIDES 64

/* The shapes whose hub the first gate may find, with positions. */
static void hub_sample(sample *s, int which)
{
    uint32_t v;
    if (which == 0) {
        lathe_sample(s, SIDES, 2, 3, 1, 12);
        return;
    }
    sample_begin(s, which == 1 ? triangles_disc(SIDES) : which == 2 ? triangles_annulus(SIDES) : triangles_bipyramid(SIDES));
    sample_channel(s, CQ_POSITION, 3, 12);
    for (v = 0; v < s->mesh.num_vertices; ++v) {
        const double turn = 2 * PI * v / SIDES;
        if (which == 1 && v == 0) place(s, v, 0, 0, 0);
        else if (which == 2) place(s, v, cos(turn), sin(turn), v < SIDES ? -1 : 1);
        else if (v < SIDES + (which == 1)) place(s, v, cos(turn), sin(turn), 0);
        else place(s, v, 0, 0, v == SIDES ? 1 : -1);
    }
}

/* Face f comes first, and all faces begin at another corner. */
static void turn_faces(triangles *t, const triangles *from, uint32_t f, uint32_t turn)
{
    uint32_t k, j;
    for (k = 0; k < t->num_faces; ++k)
        for (j = 0; j < 3; ++j)
            t->indices[3 * k + j] = from->indices[3 * ((k + f) % t->num_faces) + (j + turn) % 3];
}

TEST(a_disc_a_cylinder_and_a_double_cone_come_down_whatever_the_first_gate)
{
    int which, goal, located;
    for (which = 0; which < 4; ++which) {
        sample s, turned;
        uint32_t f, turn, most = 0;
        hub_sample(&s, which);
        hub_sample(&turned, which);
        for (f = 0; f < s.mesh.num_faces; ++f)
            for (turn = 0; turn < 3; ++turn)
                for (goal = 0; goal < 2; ++goal)
                    for (located = 0; located < 2; ++located) {
                        coded c;
                        turn_faces(&turned.mesh, &s.mesh, f, turn);
                        turned.input.goal = (cq_goal)goal;
                        turned.input.shape.num_channels = (uint32_t)located;
                        code(&c, &turned.input);
                        CHECK_EQ(c.result, CQ_OK);
                        if (c.report->base_vertices > most) most = c.report->base_vertices;
                        uncode(&c);
                    }
        CHECK(most <= 8);
        if (most > 8) printf("  shape %d: base of %d vertices\n", which, (int)most);
        turned.input.shape.num_channels = 1;
        sample_free(&turned);
        sample_free(&s);
    }
}

/* The stream gives back all values, in pieces of a byte, and its base has at most so many vertices. */
static void check_base(sample *s, uint32_t most)
{
    coded c;
    decoding d;
    uint32_t v;
    code(&c, &s->input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK(c.report->base_vertices <= most);
    if (c.report->base_vertices > most) printf("  base of %d vertices\n", (int)c.report->base_vertices);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, 1), CQ_DONE);
    for (v = 0; s->input.shape.num_channels && v < 3 * s->mesh.num_vertices; ++v)
        CHECK_EQ(d.decoder->channel[0][3 * c.map[v / 3] + v % 3], s->values[0][v]);
    decoding_free(&d);
    uncode(&c);
}

/* Vertices of too many neighbours to be split have the encoder pass them over, until they have fewer. */
TEST(spheres_with_poles_of_any_valence_come_down)
{
    uint32_t sides;
    for (sides = 10; sides < 120; sides += sides < 60 ? 1 : 7) {
        sample s;
        lathe_sample(&s, sides, 5, 3, 0, 12);
        check_base(&s, 8);
        sample_free(&s);
    }
}

/* Puts a fan of `more` vertices into each of the faces 0, step, 2 step ... a, b, c: all of them neighbours of a and b, so
 * that these become hubs. The first face is then that of the first a, b and the last vertex of its fan. Frees t. */
static triangles hubs_of(triangles t, uint32_t step, uint32_t more)
{
    triangles hubs, turned;
    uint32_t f, k, n = 0;
    hubs.num_vertices = t.num_vertices + (t.num_faces + step - 1) / step * more;
    hubs.num_faces = t.num_faces + 2 * (hubs.num_vertices - t.num_vertices);
    hubs.indices = (cq_index *)exact_alloc(3 * (size_t)hubs.num_faces * sizeof(cq_index));
    turned = hubs;
    turned.indices = (cq_index *)exact_alloc(3 * (size_t)hubs.num_faces * sizeof(cq_index));
    hubs.num_vertices = t.num_vertices;
    for (f = 0; f < t.num_faces; ++f) {
        const cq_index a = t.indices[3 * f], b = t.indices[3 * f + 1];
        cq_index c = t.indices[3 * f + 2], *to;
        for (k = 0; f % step == 0 && k < more; ++k) {
            const cq_index v = (cq_index)hubs.num_vertices++;
            to = hubs.indices + 3 * n;
            to[0] = b, to[1] = c, to[2] = v;
            to[3] = c, to[4] = a, to[5] = v;
            n += 2;
            c = v;
        }
        to = hubs.indices + 3 * n++;
        to[0] = a, to[1] = b, to[2] = c;
    }
    turn_faces(&turned, &hubs, 2 * more, 0);
    triangles_free(&hubs);
    triangles_free(&t);
    return turned;
}

static void check_hubs(triangles hubs, uint32_t most)
{
    uint64_t random = 1;
    sample s;
    uint32_t k, v;
    for (k = 0; k < 2; ++k) {           /* alone, and with positions that mean nothing */
        if (k == 0) sample_begin(&s, hubs);
        else sample_channel(&s, CQ_POSITION, 3, 12);
        for (v = 0; k && v < 3 * s.mesh.num_vertices; ++v) s.values[0][v] = (cq_value)(next_random(&random) % 4096);
        check_base(&s, most);
    }
    sample_free(&s);
}

TEST(hubs_next_to_each_other_come_down)
{
    check_hubs(hubs_of(triangles_torus(12, 12), 1, 10), 40);
}

/* The pole that the first patch finds is passed over, then all of the equator, with more neighbours than the queue holds:
 * it has room for a third of the faces. What it does not hold stays as it is. */
TEST(a_mesh_with_more_neighbours_of_hubs_than_the_queue_holds_comes_back)
{
    check_hubs(hubs_of(triangles_bipyramid(100), 2, 30), CQ_NO_LIMIT);
}

/* -- Errors -------------------------------------------------------------------------------------------------------- */

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Square of the distance of the origin from the segment a, b. */
static double segment_square(const double *a, const double *b)
{
    double along[3], at[3], t, length;
    int k;
    for (k = 0; k < 3; ++k) along[k] = b[k] - a[k];
    length = dot(along, along);
    t = length > 0 ? fmin(1, fmax(0, -dot(a, along) / length)) : 0;
    for (k = 0; k < 3; ++k) at[k] = a[k] + t * along[k];
    return dot(at, at);
}

/* The same from a triangle: the foot on its plane, if that is inside; else from its edges. */
static double triangle_square(const double *a, const double *b, const double *c)
{
    double u[3], v[3], uu, uv, vv, au, av, det, s, t, at[3];
    int k;
    for (k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = c[k] - a[k];
    uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), au = -dot(a, u), av = -dot(a, v);
    det = uu * vv - uv * uv;
    if (det > 1e-9) {
        s = (vv * au - uv * av) / det, t = (uu * av - uv * au) / det;
        for (k = 0; k < 3; ++k) at[k] = a[k] + s * u[k] + t * v[k];
        if (s >= 0 && t >= 0 && s + t <= 1) return dot(at, at);
    }
    return fmin(segment_square(a, b), fmin(segment_square(b, c), segment_square(c, a)));
}

/* Of a vertex of the sample from the decoder's mesh, in steps. */
static double distance_from_mesh(const sample *s, uint32_t v, const cq_decoder *d)
{
    double least = 1e30;
    size_t f, k, j;
    for (f = 0; f < d->mesh.num_faces; ++f) {
        double corner[3][3];
        for (k = 0; k < 3; ++k)
            for (j = 0; j < 3; ++j)
                corner[k][j] = (double)d->channel[0][3 * (size_t)d->mesh.origin[3 * f + k] + j] - s->values[0][3 * v + j];
        least = fmin(least, triangle_square(corner[0], corner[1], corner[2]));
    }
    return sqrt(least);
}

static double farthest(const sample *s, const cq_decoder *d)
{
    double most = 0;
    uint32_t v;
    for (v = 0; v < s->mesh.num_vertices; ++v) most = fmax(most, distance_from_mesh(s, v, d));
    return most;
}

enum { SURFACES = 12, FINEST_GRID = CQ_INDEX_BITS == 16 ? 15 : 22 };

/* Two components of different sizes, one above the other. */
static void two_saddles(sample *s)
{
    triangles t = triangles_sheet(12, 11);
    uint32_t v;
    triangles_append(&t, triangles_sheet(7, 5));
    sample_begin(s, t);
    sample_channel(s, CQ_POSITION, 3, 13);
    for (v = 0; v < t.num_vertices; ++v) {
        const uint32_t width = v < 132 ? 12 : 7, k = v < 132 ? v : v - 132;
        const double x = 2.0 * (k % width) / (width - 1) - 1, y = 2.0 * (k / width) / (width == 12 ? 10 : 4) - 1;
        place(s, v, x, y, 0.4 * x * y + (v < 132 ? 0.5 : -0.5));
    }
}

static void surface_sample(sample *s, int which)
{
    uint64_t random = 3;
    uint32_t v;
    switch (which) {
    case 0: lathe_sample(s, 16, 15, 3, 0, 12); break;              /* a sphere */
    case 1: lathe_sample(s, 24, 9, 3, 0.8, 15); break;             /* nearly a cylinder */
    case 2: lathe_sample(s, 12, 20, 0, 0.3, 8); break;             /* a barrel without ends, on a coarse grid */
    case 3: hub_sample(s, 3); break;
    case 4:                                                        /* noise */
        sample_begin(s, triangles_torus(14, 13));
        sample_channel(s, CQ_POSITION, 3, 12);
        for (v = 0; v < 3 * s->mesh.num_vertices; ++v) s->values[0][v] = (cq_value)(next_random(&random) % 4096);
        break;
    case 8: lathe_sample(s, 20, 11, 3, 0.2, FINEST_GRID); break;
    case 9:                                                        /* a strip: boundary all over */
        sample_begin(s, triangles_sheet(90, 2));
        sample_channel(s, CQ_POSITION, 3, 11);
        for (v = 0; v < s->mesh.num_vertices; ++v) {
            const double turn = v % 90 / 8.0, radius = v < 90 ? 0.7 : 0.9;
            place(s, v, radius * cos(turn), radius * sin(turn), ((double)(next_random(&random) % 5) + v % 90) / 50 - 1);
        }
        break;
    case 10: two_saddles(s); break;
    case 11:                                                       /* a plane with noise of few steps of a fine grid */
        sample_begin(s, triangles_sheet(20, 17));
        sample_channel(s, CQ_POSITION, 3, FINEST_GRID);
        for (v = 0; v < s->mesh.num_vertices; ++v) {
            place(s, v, v % 20 / 9.5 - 1, v / 20 / 8.0 - 1, v % 20 / 40.0);
            s->values[0][3 * v + 2] = (cq_value)(s->values[0][3 * v + 2] + (cq_value)(next_random(&random) % 64));
        }
        break;
    default:                                                       /* hills, with noise, in a plane */
        sample_begin(s, triangles_sheet(20, 17));
        sample_channel(s, CQ_POSITION, 3, 12);
        for (v = 0; v < s->mesh.num_vertices; ++v) {
            const double x = v % 20 / 9.5 - 1, y = v / 20 / 8.0 - 1;
            const double noise = which == 6 ? (double)(next_random(&random) % 100) / 2000 : 0;
            place(s, v, x, y, which == 7 ? 0 : 0.4 * sin(5 * x) * cos(4 * y + x) + noise);
        }
    }
}

/* Encodes a sample; its stream, to be fed to the decoder. */
static cq_bytes code_and_begin(coded *c, decoding *d, sample *s)
{
    cq_bytes in;
    code(c, &s->input);
    decoding_begin(d, c->bytes, c->size);
    in.data = c->bytes;
    in.size = c->size;
    return in;
}

/* Of told to measured errors, where the measured one is a 4096th of the grid or more. */
typedef struct ratios {
    uint32_t levels, measured;
    double sum, largest;           /* of the measured ones: logarithms, ratio */
} ratios;

static void compare(ratios *r, uint32_t level, double told, double measured, double grid)
{
    r->levels++;
    CHECK(measured <= told + 1e-6);
    if (measured > told + 1e-6) printf("  level %d: %.4f steps, and not %.4f\n", (int)level, measured, told);
    if (4096 * measured < grid) return;
    r->measured++;
    r->sum += log(told / measured);
    r->largest = fmax(r->largest, told / measured);
}

/* At the beginning of each level no vertex of the exact mesh is further from the mesh than the decoder says. */
static void check_errors(sample *s, ratios *r)
{
    coded c;
    decoding d;
    cq_bytes in;
    uint32_t level = 0, before = CQ_NO_LIMIT;
    const double grid = (double)((int32_t)1 << s->input.shape.channel[0].bits);
    in = code_and_begin(&c, &d, s);
    REQUIRE_EQ(c.result, CQ_OK);
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        if (d.decoder->level == level) continue;
        level = d.decoder->level;
        CHECK_EQ(d.decoder->error, c.report->level[level - 1].error);
        CHECK(d.decoder->error <= before);
        before = d.decoder->error;
        compare(r, level, d.decoder->error / 16.0, farthest(s, d.decoder), grid);
    } while (d.result == CQ_MORE);
    CHECK_EQ(d.result, CQ_DONE);
    CHECK_EQ(d.decoder->error, 0);
    decoding_free(&d);
    uncode(&c);
}

TEST(no_exact_vertex_is_further_away_than_the_error_of_a_level)
{
    ratios r = {0, 0, 0, 0};
    int which, goal;
    for (which = 0; which < SURFACES; ++which)
        for (goal = 0; goal < 2; ++goal) {
            sample s;
            surface_sample(&s, which);
            s.input.goal = (cq_goal)goal;
            check_errors(&s, &r);
            sample_free(&s);
        }
    printf("  %d levels, told / measured: mean %.3f, largest %.2f\n", (int)r.levels, exp(r.sum / r.measured), r.largest);
    CHECK(r.levels > 300 && r.measured > 250);
    CHECK(exp(r.sum / r.measured) < 1.2 && r.largest < 8);
}

/* Until its outline loses a corner: levels of a fifth of the vertices or more. */
TEST(what_lies_in_a_plane_has_no_error)
{
    sample s;
    coded c;
    uint32_t k, levels = 0;
    surface_sample(&s, 7);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    for (k = 1; k < c.report->num_levels; ++k) {
        if (5 * c.report->level[k - 1].num_vertices < s.mesh.num_vertices) continue;
        CHECK_EQ(c.report->level[k].error, 0);
        levels++;
    }
    CHECK(levels > 5);
    uncode(&c);
    sample_free(&s);
}

/* Of a stream that is cut, the error is that of a level that has begun. */
TEST(a_cut_stream_tells_the_error_of_a_level_of_the_whole)
{
    sample s;
    coded c;
    size_t size;
    surface_sample(&s, 5);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    for (size = 0; size < c.size; ++size) {
        decoding d;
        uint32_t level;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, size, c.size, CQ_NO_LIMIT), CQ_TRUNCATED);
        level = d.decoder->level;
        if (level < 2) CHECK(d.decoder->error == 0 || d.decoder->error == c.report->level[0].error);
        else CHECK(d.decoder->error == c.report->level[level - 1].error || d.decoder->error == c.report->level[level - 2].error);
        decoding_free(&d);
    }
    uncode(&c);
    sample_free(&s);
}

TEST(without_positions_on_a_grid_no_error_is_told)
{
    int exact;
    for (exact = 0; exact < (CQ_INDEX_BITS == 32) + 1; ++exact) {
        sample s;
        coded c;
        uint32_t k;
        sample_begin(&s, triangles_torus(9, 9));
        if (exact) sample_merged(&s, CQ_POSITION, CQ_AVERAGE, 3, CQ_EXACT_BITS);
        else sample_channel(&s, CQ_GENERIC, 3, 12);
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        CHECK(c.report->num_levels > 0);
        for (k = 0; k < c.report->num_levels; ++k) CHECK_EQ(c.report->level[k].error, 0);
        uncode(&c);
        sample_free(&s);
    }
}

/* -- Normals ------------------------------------------------------------------------------------------------------- */

/* Cosine of the largest angle between a vertex of a sphere, seen from its centre, and its normal. */
static double least_cosine(const cq_decoder *d, float *normals)
{
    const double centre = (double)(((int32_t)1 << d->shape.channel[0].bits) - 1) / 2;
    double least = 1;
    uint32_t v, k;
    cq_reconstruct_normals(d->shape.channel[1].bits, d->channel[1], d->mesh.num_vertices, normals);
    for (v = 0; v < d->mesh.num_vertices; ++v) {
        double out[3], normal[3];
        for (k = 0; k < 3; ++k) {
            out[k] = (double)d->channel[0][3 * v + k] - centre;
            normal[k] = (double)normals[3 * v + k];
        }
        least = fmin(least, dot(out, normal) / sqrt(dot(out, out) * dot(normal, normal)));
    }
    return least;
}

TEST(each_vertex_of_a_sphere_has_its_own_normal_at_every_step)
{
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    float *from, *back;
    uint32_t v, k, steps = 0;
    lathe_sample(&s, 24, 17, 3, 0, 12);
    sample_channel(&s, CQ_NORMAL, 2, 10);
    from = (float *)exact_alloc(3 * (size_t)s.mesh.num_vertices * sizeof *from);
    back = (float *)exact_alloc(3 * (size_t)s.mesh.num_vertices * sizeof *back);
    for (v = 0; v < s.mesh.num_vertices; ++v)
        for (k = 0; k < 3; ++k) from[3 * v + k] = (float)s.values[0][3 * v + k] - 2047.5f;
    REQUIRE_EQ(cq_quantise_normals(10, from, s.mesh.num_vertices, s.values[1], NULL), CQ_OK);
    in = code_and_begin(&c, &d, &s);
    REQUIRE_EQ(c.result, CQ_OK);
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        if (d.decoder->mesh.num_vertices == 0) continue;
        CHECK(least_cosine(d.decoder, back) > cos(2.122 / 511 + 1e-6));
        steps++;
    } while (d.result == CQ_MORE);
    CHECK_EQ(d.result, CQ_DONE);
    CHECK(steps > s.mesh.num_vertices / 2);
    CHECK(c.report->base_vertices < 10);
    decoding_free(&d);
    exact_free(from);
    exact_free(back);
    uncode(&c);
    sample_free(&s);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_disc_a_cylinder_and_a_double_cone_come_down_whatever_the_first_gate);
    RUN(spheres_with_poles_of_any_valence_come_down);
    RUN(hubs_next_to_each_other_come_down);
    RUN(a_mesh_with_more_neighbours_of_hubs_than_the_queue_holds_comes_back);
    RUN(no_exact_vertex_is_further_away_than_the_error_of_a_level);
    RUN(what_lies_in_a_plane_has_no_error);
    RUN(a_cut_stream_tells_the_error_of_a_level_of_the_whole);
    RUN(without_positions_on_a_grid_no_error_is_told);
    RUN(each_vertex_of_a_sphere_has_its_own_normal_at_every_step);
    return TEST_END();
}
