/* Texture coordinates by similarities: those that are one of the positions cost almost nothing, mirrored or not; what
 * has none comes back, too. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "codec.h"
#include "records.h"
#include "test.h"
#include <math.h>

enum { SIDE = 32, COLUMNS = SIDE + 1, VERTICES = COLUMNS * COLUMNS, ROWS = 2 * VERTICES, FACES = 2 * SIDE * SIDE };
enum { FLAT, ROUND, LINE, POINT };

static struct grid {
    double along[2 * VERTICES]; /* places on the surface */
    cq_value position[3 * ROWS], uv[2 * ROWS];
    cq_index index[3 * FACES];
    cq_input input;
} grid;

static uint32_t seed;

static double draw(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / (1 << 24);
}

static void set_channel(uint32_t k, cq_kind kind, uint32_t components, uint32_t bits, cq_merge merge,
                        const cq_value *values)
{
    cq_channel *c = &grid.input.shape.channel[k];
    c->kind = (uint8_t)kind;
    c->components = (uint8_t)components;
    c->bits = (uint8_t)bits;
    c->merge = (uint8_t)merge;
    grid.input.values[k] = values;
}

/* A grid whose vertices are not quite at its corners: a plane that leans, part of a tube, all on a line or at
 * a point. */
static void make_grid(int form)
{
    cq_input *in = &grid.input;
    int k, x, y;
    memset(in, 0, sizeof *in);
    seed = 1;
    for (k = 0; k < VERTICES; k++) {
        const double u = 400 * (k % COLUMNS + 0.6 * draw()), v = 400 * (k / COLUMNS + 0.6 * draw()), turn = u / 4000;
        cq_value *const to = grid.position + 3 * k;
        grid.along[2 * k] = u;
        grid.along[2 * k + 1] = v;
        to[0] = (cq_value)(form == FLAT ? 0.8 * u : form == ROUND ? 4000 - 4000 * cos(turn) : form == LINE ? u : 9000);
        to[1] = (cq_value)(form == FLAT || form == ROUND ? v : form == LINE ? 2 * u : 9000);
        to[2] = (cq_value)(form == FLAT ? 0.6 * u : form == ROUND ? 4000 + 4000 * sin(turn)
                                                  : form == LINE ? u : 9000);
    }
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            const int a = y * COLUMNS + x, d = a + COLUMNS, corner[6] = { a, a + 1, d + 1, a, d + 1, d };
            for (k = 0; k < 6; k++) grid.index[6 * (y * SIDE + x) + k] = (cq_index)corner[k];
        }
    in->indices = grid.index;
    in->conquest_only = 1;
    in->shape.num_vertices = VERTICES;
    in->shape.num_faces = FACES;
    in->shape.num_channels = 2;
    set_channel(0, CQ_POSITION, 3, 15, CQ_AVERAGE, grid.position);
    set_channel(1, CQ_TEXCOORD, 2, 14, CQ_AVERAGE, grid.uv);
}

/* The surface, turned and scaled, or mirrored before; for row k. */
static void set_uv(int k, double angle, double scale, int mirrored)
{
    const double x = grid.along[2 * k] - 6400, y = (mirrored ? -1 : 1) * (grid.along[2 * k + 1] - 6400);
    grid.uv[2 * k] = (cq_value)(8000 + scale * (cos(angle) * x - sin(angle) * y));
    grid.uv[2 * k + 1] = (cq_value)(8000 + scale * (sin(angle) * x + cos(angle) * y));
}

static void set_all(double angle, double scale, int mirrored)
{
    int k;
    for (k = 0; k < VERTICES; k++) set_uv(k, angle, scale, mirrored);
}

/* Bits for each vertex of all other channels than positions; all of it comes back. */
static double cost(void)
{
    coded c;
    decoding d;
    double bits = -1;
    code(&c, &grid.input);
    CHECK_EQ(c.result, CQ_OK);
    if (c.result == CQ_OK) {
        bits = (double)c.report->channels / 65536 / (double)VERTICES;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 100, 1000), CQ_DONE);
        CHECK(d.result == CQ_DONE && same_triangles(&grid.input, d.decoder));
        decoding_free(&d);
    }
    uncode(&c);
    return bits;
}

static double cost_of(int form, double angle, double scale, int mirrored)
{
    make_grid(form);
    set_all(angle, scale, mirrored);
    return cost();
}

TEST(a_similarity_of_positions_costs_almost_nothing)
{
    int form, turn;
    for (form = FLAT; form <= ROUND; form++)
        for (turn = 0; turn < 3; turn++) {
            const double bits = cost_of(form, 2.6 * turn, 0.1, 0), mirrored = cost_of(form, 2.6 * turn, 0.1, 1);
            CHECK(bits > 0 && bits < 2.2);
            CHECK(mirrored > 0 && mirrored < 2.2);
        }
    CHECK(cost_of(ROUND, 1.3, 0.01, 0) < 1.8);
    CHECK(cost_of(ROUND, 1.3, 0.8, 1) < 5.2);
}

TEST(texture_coordinates_without_anything_in_common_come_back)
{
    int form, k;
    for (form = FLAT; form <= POINT; form++) {
        make_grid(form);
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = (cq_value)(16384 * draw());
        CHECK(cost() > 20);
    }
}

/* Faces without an area, and places that are one. */
TEST(degenerate_faces_have_texture_coordinates)
{
    int form, k;
    for (form = LINE; form <= POINT; form++) {
        CHECK(cost_of(form, 1.3, 0.1, 0) > 0);
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = (cq_value)(1234 + k % 2);
        CHECK(cost() < 0.5);
    }
}

TEST(equal_texture_coordinates_cost_nothing)
{
    int form, k;
    for (form = FLAT; form <= ROUND; form++) {
        make_grid(form);
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = 16383;
        CHECK(cost() < 0.5);
    }
}

#if CQ_MAX_BITS >= 24
static cq_value exact(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (cq_value)bits;
}

/* Floats of any sign: of the 32 bits of each the last 10 or so look like noise. */
TEST(exact_texture_coordinates_come_back)
{
    int form, k;
    double bits;
    for (form = FLAT; form <= POINT; form++) {
        make_grid(form);
        set_channel(1, CQ_TEXCOORD, 2, CQ_EXACT_BITS, CQ_AVERAGE, grid.uv);
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = exact((float)(1.25 + grid.along[k] / 20000));
        bits = cost();
        CHECK(bits > 0 && (form > ROUND || bits < 40));
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = exact((float)((draw() - 0.5) * (k % 7 ? 1e-3 : 1e30)));
        CHECK(cost() > 40);
    }
}

#endif

/* Those of a bit, and the largest ones. */
TEST(texture_coordinates_may_have_one_bit_or_most)
{
    int bits, k;
    make_grid(ROUND);
    for (bits = 1; bits <= CQ_MAX_BITS; bits += CQ_MAX_BITS - 1) {
        set_channel(1, CQ_TEXCOORD, 2, (uint32_t)bits, CQ_AVERAGE, grid.uv);
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = (cq_value)(draw() < 0.5 ? 0 : (1 << bits) - 1);
        CHECK(cost() > 0);
        for (k = 0; k < 2 * VERTICES; k++) grid.uv[k] = (cq_value)(grid.along[k] > 6400 ? (1 << bits) - 1 : 0);
        CHECK(cost() < bits);
    }
}

/* Of a few values in patches: no similarity, if they are to be copied. */
TEST(copies_of_texture_coordinates_are_no_similarities)
{
    int k, c;
    make_grid(ROUND);
    set_channel(1, CQ_TEXCOORD, 2, 14, CQ_COPY, grid.uv);
    for (k = 0; k < VERTICES; k++)
        for (c = 0; c < 2; c++)
            grid.uv[2 * k + c] = (cq_value)((5003 * (k % COLUMNS / 9 + k / COLUMNS / 11) + 7919 * c) & 0x3fff);
    CHECK(cost() < 3);
}

/* Left and right half have their own rows where they meet: the right one's texture is mirrored. */
TEST(charts_that_meet_at_a_seam_are_similarities_too)
{
    cq_index right[VERTICES];
    uint32_t h, next;
    int form, k;
    for (form = FLAT; form <= ROUND; form++) {
        double bits;
        make_grid(form);
        set_all(0.5, 0.1, 0);
        for (k = 0; k < VERTICES; k++) right[k] = CQ_NONE;
        for (next = VERTICES, h = 0; h < 3 * FACES; h++) {
            const cq_index v = grid.index[h];
            if ((int)(h / 6 % SIDE) < SIDE / 2 + (int)(h / 6 / SIDE) % 3) continue;
            if (right[v] == CQ_NONE) {
                const double x = 0.1 * grid.along[2 * v], y = 0.1 * grid.along[2 * v + 1];
                right[v] = (cq_index)next++;
                memcpy(grid.position + 3 * right[v], grid.position + 3 * v, 3 * sizeof *grid.position);
                grid.uv[2 * right[v]] = (cq_value)(12000 - x);
                grid.uv[2 * right[v] + 1] = (cq_value)(3000 + y);
            }
            grid.index[h] = right[v];
        }
        grid.input.shape.num_vertices = next;
        bits = cost();
        CHECK(bits > 0 && bits < 6);
    }
}

/* -- One fan -- */

static cqi_fan fan;

/* Texture coordinates 30 + 12 i times the place, and more; of a place that is mirrored before. */
static void make_fan(int n, int mirrored)
{
    static const int16_t place[5][2] = { { 900, 20 }, { 300, 800 }, { -700, 400 }, { -500, -600 }, { 250, -900 } };
    int k;
    memset(&fan, 0, sizeof fan);
    fan.size = n;
    for (k = 0; k < n; k++) {
        const int32_t x = place[k][0], y = place[k][1], turned = mirrored ? -y : y;
        fan.outer[k].x = x;
        fan.outer[k].y = y;
        fan.scratch[0][k] = 30 * x - 12 * turned + 500;
        fan.scratch[1][k] = 12 * x + 30 * turned - 700;
    }
}

TEST(a_fan_tells_whether_its_texture_is_mirrored)
{
    int n, mirrored, before;
    for (n = 2; n <= 5; n++)
        for (mirrored = 0; mirrored < 2; mirrored++)
            for (before = -1; before <= 1; before += 2) {
                const int found = n > 2 ? 1 - 2 * mirrored : before;
                int32_t mirror = before, to[2];
                cqi_similarity s;
                make_fan(n, mirrored);
                cqi_fit_similarity(&fan, n, &mirror, &s);
                CHECK_EQ(mirror, found);
                CHECK_EQ(s.mirror, found);
                if (found != 1 - 2 * mirrored) continue;
                cqi_map_place(&s, 0, 0, 1 << 20, to);
                CHECK(abs(to[0] + s.u - 500) <= 40 && abs(to[1] + s.v + 700) <= 40);
                CHECK(n < 3 || cqi_misses(&fan, n, &s) <= (uint32_t)(80 * n));
            }
}

/* Their mean is rounded, so that they may seem to turn. */
TEST(two_neighbours_leave_it_as_it_was_before)
{
    int i, k;
    seed = 1;
    for (i = 0; i < 200; i++) {
        int32_t mirror = 1 - 2 * (i % 2);
        cqi_similarity s;
        make_fan(2, 0);
        for (k = 0; k < 2; k++) {
            fan.outer[k].x = (int32_t)(2000 * draw()) - 1000;
            fan.outer[k].y = (int32_t)(2000 * draw()) - 1000;
            fan.scratch[0][k] = (int32_t)(200 * draw());
            fan.scratch[1][k] = (int32_t)(200 * draw());
        }
        cqi_fit_similarity(&fan, 2, &mirror, &s);
        CHECK_EQ(mirror, 1 - 2 * (i % 2));
    }
}

TEST(places_at_one_point_give_the_mean_of_their_texture_coordinates)
{
    int32_t mirror = -1, to[2];
    cqi_similarity s;
    int k;
    make_fan(5, 0);
    for (k = 0; k < 5; k++) {
        fan.outer[k].x = fan.outer[k].y = 70;
        fan.scratch[0][k] = 100 * k;
        fan.scratch[1][k] = -10 * k;
    }
    memset(&s, 0x7f, sizeof s); /* whatever was there */
    cqi_fit_similarity(&fan, 5, &mirror, &s);
    CHECK_EQ(s.most, 200);
    cqi_map_place(&s, 0, 0, 1 << 20, to);
    CHECK_EQ(mirror, -1);
    CHECK_EQ(to[0] + s.u, 200);
    CHECK_EQ(to[1] + s.v, -20);
}

/* Three neighbours of any form have a plane; on a line or at a point it does not matter which. */
TEST(a_fan_without_an_area_has_a_plane)
{
    static const int32_t apart[4] = { 0, 1, 5000, (1 << 24) - 1 };
    int i, k, axis;
    for (i = 0; i < 4; i++)
        for (axis = 0; axis < 3; axis++) {
            memset(&fan, 0, sizeof fan);
            fan.size = 3;
            fan.faces = 7;
            for (k = 0; k < 3; k++) {
                const int32_t x = apart[i] / 3 * k;
                fan.at[k].x = axis == 0 || axis == 2 ? x : 0;
                fan.at[k].y = axis ? -x : 0;
            }
            cqi_flatten_fan(&fan);
            for (k = 0; k < 3; k++) CHECK(abs(fan.outer[k].x) <= 1024 && abs(fan.outer[k].y) <= 1024);
            CHECK_EQ(fan.outer[0].x | fan.outer[0].y, 0);
        }
}

/* A fan in any plane keeps its form, seen from the side where its faces turn as in the mesh. */
TEST(a_flat_fan_keeps_its_angles)
{
    static const int32_t side[4][2] = { { 5000, 0 }, { 0, 4000 }, { -5000, 0 }, { 0, -4000 } };
    int plane, k;
    for (plane = 0; plane < 3; plane++) {
        memset(&fan, 0, sizeof fan);
        fan.size = 4;
        fan.faces = 15;
        for (k = 0; k < 4; k++) {
            const int32_t x = side[k][0], y = side[k][1];
            fan.at[k].x = plane == 0 ? x : plane == 1 ? y : 0;
            fan.at[k].y = plane == 0 ? y : plane == 2 ? x : 0;
            fan.at[k].z = plane == 1 ? x : plane == 2 ? y : 0;
        }
        cqi_flatten_fan(&fan);
        for (k = 0; k < 4; k++) {
            const cqi_vector a = fan.outer[k], b = fan.outer[(k + 1) % 4];
            const double dot = (double)a.x * b.x + (double)a.y * b.y, cross = (double)a.x * b.y - (double)a.y * b.x;
            CHECK(fabs(dot) < 0.02 * fabs(cross) && cross != 0);
        }
    }
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_similarity_of_positions_costs_almost_nothing);
    RUN(texture_coordinates_without_anything_in_common_come_back);
    RUN(degenerate_faces_have_texture_coordinates);
    RUN(equal_texture_coordinates_cost_nothing);
#if CQ_MAX_BITS >= 24
    RUN(exact_texture_coordinates_come_back);
#endif
    RUN(texture_coordinates_may_have_one_bit_or_most);
    RUN(copies_of_texture_coordinates_are_no_similarities);
    RUN(charts_that_meet_at_a_seam_are_similarities_too);
    RUN(a_fan_tells_whether_its_texture_is_mirrored);
    RUN(two_neighbours_leave_it_as_it_was_before);
    RUN(places_at_one_point_give_the_mean_of_their_texture_coordinates);
    RUN(a_fan_without_an_area_has_a_plane);
    RUN(a_flat_fan_keeps_its_angles);
    return TEST_END();
}
