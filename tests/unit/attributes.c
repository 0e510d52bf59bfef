/* What engines have at vertices beside positions: tangents, joints and their weights, on a torus with seams of texture
 * coordinates or without. Each must cost less than as numbers that mean nothing. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "codec.h"
#include "records.h"
#include "test.h"
#include <math.h>

enum { ACROSS = 36, ALONG = 24, ROWS = (ACROSS + 1) * (ALONG + 1), FACES = 2 * ACROSS * ALONG };

static struct torus {
    cq_value position[3 * ROWS], normal[2 * ROWS], uv[2 * ROWS], tangent[3 * ROWS], joint[4 * ROWS], weight[4 * ROWS];
    cq_index index[3 * FACES];
} torus;

static void set_pair(double x, double y, double z, cq_value *to)
{
    float direction[3];
    direction[0] = (float)x;
    direction[1] = (float)y;
    direction[2] = (float)z;
    CHECK_EQ(cq_quantise_normals(10, direction, 1, to, NULL), CQ_OK);
}

/* Three joints around each place, the one with most weight first; those without weight are 0. */
static void set_skin(int row, double turns)
{
    const double place = 8 * turns, part = place - floor(place);
    int joint[3], weight[3], k, j;
    for (k = 0; k < 3; k++) joint[k] = 1 + ((int)floor(place) + (k < 2 ? k : 7)) % 8;
    weight[1] = (int)(200 * part);
    weight[2] = part < 0.5 ? (int)(50 * (1 - 2 * part)) : 0;
    weight[0] = 255 - weight[1] - weight[2];
    for (k = 0; k < 2; k++)
        for (j = 0; j < 2; j++) {
            const int w = weight[j], i = joint[j];
            if (w >= weight[j + 1]) continue;
            weight[j] = weight[j + 1];
            joint[j] = joint[j + 1];
            weight[j + 1] = w;
            joint[j + 1] = i;
        }
    for (k = 0; k < 4; k++) {
        torus.weight[4 * row + k] = (cq_value)(k < 3 ? weight[k] : 0);
        torus.joint[4 * row + k] = (cq_value)(k < 3 && weight[k] ? joint[k] : 0);
    }
}

/* With bumps along it, so that tangents are no circles. */
static void make_torus(void)
{
    const double full = 6.283185307179586, across = ACROSS, along = ALONG;
    int u, v, k;
    for (v = 0; v <= ALONG; v++)
        for (u = 0; u <= ACROSS; u++) {
            const int row = v * (ACROSS + 1) + u;
            const double a = full * (u % ACROSS) / across, b = full * (v % ALONG) / along;
            const double r = 0.4 + 0.04 * sin(3 * a), grows = 0.12 * cos(3 * a);
            const double at[3] = { (1 + r * cos(b)) * cos(a), (1 + r * cos(b)) * sin(a), r * sin(b) };
            const double t[3] = { grows * cos(b) * cos(a) - at[1], grows * cos(b) * sin(a) + at[0], grows * sin(b) };
            const double s[3] = { -r * sin(b) * cos(a), -r * sin(b) * sin(a), r * cos(b) };
            for (k = 0; k < 3; k++) torus.position[3 * row + k] = (cq_value)((at[k] + 1.6) * 5000);
            set_pair(t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2], t[0] * s[1] - t[1] * s[0], torus.normal + 2 * row);
            set_pair(t[0], t[1], t[2], torus.tangent + 3 * row);
            torus.tangent[3 * row + 2] = 1;
            torus.uv[2 * row] = (cq_value)(u * 110);
            torus.uv[2 * row + 1] = (cq_value)(v * 160);
            set_skin(row, (u % ACROSS) / (double)ACROSS);
        }
    for (v = 0; v < ALONG; v++)
        for (u = 0; u < ACROSS; u++) {
            const int a = v * (ACROSS + 1) + u, d = a + ACROSS + 1, corner[6] = { a, a + 1, d + 1, a, d + 1, d };
            for (k = 0; k < 6; k++) torus.index[6 * (v * ACROSS + u) + k] = (cq_index)corner[k];
        }
}

static void add_channel(cq_input *in, cq_kind kind, uint32_t components, uint32_t bits, cq_merge merge, const cq_value *values)
{
    cq_channel *c = &in->shape.channel[in->shape.num_channels];
    c->kind = (uint8_t)kind;
    c->components = (uint8_t)components;
    c->bits = (uint8_t)bits;
    c->merge = (uint8_t)merge;
    in->values[in->shape.num_channels++] = values;
}

static void begin(cq_input *in)
{
    memset(in, 0, sizeof *in);
    in->conquest_only = 1;          /* the torus has regular levels, which predict attributes from less */
    if (!torus.position[0]) make_torus();
    in->indices = torus.index;
    in->conquest_only = 1;
    in->shape.num_vertices = ROWS;
    in->shape.num_faces = FACES;
    add_channel(in, CQ_POSITION, 3, 14, CQ_AVERAGE, torus.position);
    add_channel(in, CQ_NORMAL, 2, 10, CQ_AVERAGE, torus.normal);
    add_channel(in, CQ_TEXCOORD, 2, 12, CQ_AVERAGE, torus.uv);
}

/* Bits for each row of all other channels than positions; all of it comes back. */
static double cost_with_rows(const cq_input *in, int rows)
{
    coded c;
    decoding d;
    double bits = 0;
    code(&c, in);
    CHECK_EQ(c.result, CQ_OK);
    if (c.result == CQ_OK) {
        bits = (double)c.report->channels / 65536 / (double)ROWS;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 100, 1000), CQ_DONE);
        CHECK_EQ(d.decoder->shape.num_rows != 0, rows);
        CHECK(same_triangles(in, d.decoder));
        decoding_free(&d);
    }
    uncode(&c);
    return bits;
}

static double cost(const cq_input *in) { return cost_with_rows(in, in->indices == torus.index); }

/* What one more channel costs, of one kind or another. */
static double cost_of(cq_kind kind, uint32_t components, uint32_t bits, cq_merge merge, const cq_value *values, int after_joints)
{
    cq_input in;
    double before;
    begin(&in);
    if (after_joints) add_channel(&in, CQ_JOINTS, 4, 4, CQ_COPY, torus.joint);
    before = cost(&in);
    add_channel(&in, kind, components, bits, merge, values);
    return cost(&in) - before;
}

TEST(a_tangent_is_an_angle_around_the_normal)
{
    const double tangent = cost_of(CQ_TANGENT, 3, 10, CQ_AVERAGE, torus.tangent, 0);
    const double color = cost_of(CQ_COLOR, 3, 10, CQ_AVERAGE, torus.tangent, 0);
    CHECK(tangent > 0 && tangent < 0.9 * color);
}

TEST(tangents_follow_the_texture_coordinates_before_them)
{
    cq_input before, after;
    begin(&before);
    add_channel(&before, CQ_TANGENT, 3, 10, CQ_AVERAGE, torus.tangent);
    begin(&after);
    after.shape.num_channels = 2;
    add_channel(&after, CQ_TANGENT, 3, 10, CQ_AVERAGE, torus.tangent);
    add_channel(&after, CQ_TEXCOORD, 2, 12, CQ_AVERAGE, torus.uv);
    CHECK(cost(&before) < cost(&after) - 0.3);
}

TEST(texture_coordinates_of_tangents_are_numbers_that_change_slowly)
{
    cq_shape s;
    int k;
    memset(&s, 0, sizeof s);
    for (k = 0; k < 4; k++) {
        s.channel[k].kind = CQ_TEXCOORD;
        s.channel[k].components = 2;
        s.channel[k].bits = (uint8_t)(k == 1 ? CQ_EXACT_BITS : 12);
        s.channel[k].merge = (uint8_t)(k == 2 ? CQ_COPY : CQ_AVERAGE);
    }
    s.channel[0].kind = CQ_GENERIC;
    CHECK_EQ(cqi_texcoords_before(&s, 3), -1);
    CHECK_EQ(cqi_texcoords_before(&s, 4), 3);
}

/* Tangents along the normal, which say nothing of the direction in which others may be: only faces do. */
TEST(tangents_that_are_normals_give_no_axes)
{
    static cq_value normal[2 * ROWS], tangent[3 * ROWS];
    cq_input in;
    int k;
    begin(&in);
    for (k = 0; k < ROWS; k++) {
        set_pair(0, 0, 1, normal + 2 * k);
        set_pair(k % 7 ? 0 : k % 5 + 1, k % 7 ? 0 : k % 3, k % 7 ? 1 : 0, tangent + 3 * k);
        tangent[3 * k + 2] = 1;
    }
    in.values[1] = normal;
    add_channel(&in, CQ_TANGENT, 3, 10, CQ_AVERAGE, tangent);
    CHECK(cost(&in) > 0);
}

/* Each corner has a row of its own: the first one of a face has nothing to be predicted from. */
TEST(tangents_of_separate_faces_come_back)
{
    enum { SIDE = 12, CORNERS = 6 * SIDE * SIDE };
    static cq_value position[3 * CORNERS], normal[2 * CORNERS], tangent[3 * CORNERS];
    static cq_index index[CORNERS];
    cq_input in;
    int k;
    begin(&in);
    for (k = 0; k < CORNERS; k++) {
        static const int corner[6] = { 0, 1, ACROSS + 2, 0, ACROSS + 2, ACROSS + 1 };
        const int face = k / 3, row = k / 6 / SIDE * (ACROSS + 1) + k / 6 % SIDE + corner[k % 6];
        memcpy(position + 3 * k, torus.position + 3 * row, 3 * sizeof *position);
        normal[2 * k] = (cq_value)(face * 37 % 1000);
        normal[2 * k + 1] = (cq_value)(face * 11 % 1000);
        tangent[3 * k] = (cq_value)(face * 53 % 1000);
        tangent[3 * k + 1] = (cq_value)(face * 29 % 1000 + k % 2);
        tangent[3 * k + 2] = (cq_value)(face % 2);
        index[k] = (cq_index)k;
    }
    in.indices = index;
    in.shape.num_vertices = CORNERS;
    in.shape.num_faces = CORNERS / 3;
    in.shape.num_channels = 2;
    in.values[0] = position;
    in.values[1] = normal;
    add_channel(&in, CQ_TANGENT, 3, 10, CQ_AVERAGE, tangent);
    CHECK(cost_with_rows(&in, 1) > 0);
}

/* The torus with one row for each vertex, whose texture coordinates are left out. */
static double cost_without_seams(cq_kind kind, uint32_t components, const cq_value *values)
{
    static cq_index index[3 * FACES];
    cq_input in;
    int k;
    begin(&in);
    for (k = 0; k < 3 * FACES; k++) {
        const int u = (int)torus.index[k] % (ACROSS + 1), v = (int)torus.index[k] / (ACROSS + 1);
        index[k] = (cq_index)(v % ALONG * (ACROSS + 1) + u % ACROSS);
    }
    in.indices = index;
    in.shape.num_channels = 1;
    in.conquest_only = 1;
    add_channel(&in, kind, components, 10, CQ_AVERAGE, values);
    return cost(&in);
}

TEST(normals_without_seams_follow_the_faces)
{
    const double normal = cost_without_seams(CQ_NORMAL, 2, torus.normal);
    CHECK(normal > 0 && normal < 0.92 * cost_without_seams(CQ_GENERIC, 2, torus.normal));
}

TEST(a_tangent_without_a_normal_before_it_comes_back)
{
    cq_input in;
    memset(&in, 0, sizeof in);
    begin(&in);
    in.shape.channel[1] = in.shape.channel[2];
    in.values[1] = in.values[2];
    in.shape.num_channels = 2;
    add_channel(&in, CQ_TANGENT, 3, 10, CQ_AVERAGE, torus.tangent);
    add_channel(&in, CQ_NORMAL, 2, 10, CQ_AVERAGE, torus.normal);
    CHECK(cost(&in) > 0);
}

TEST(a_sign_may_be_any_number_of_the_channel)
{
    cq_input in;
    int k;
    begin(&in);
    for (k = 0; k < 30; k++) torus.tangent[3 * (k * 7) + 2] = (cq_value)(k * 30);
    add_channel(&in, CQ_TANGENT, 3, 10, CQ_AVERAGE, torus.tangent);
    CHECK(cost(&in) > 0);
    make_torus();
}

TEST(joints_are_those_of_neighbours_in_any_order)
{
    const double joints = cost_of(CQ_JOINTS, 4, 8, CQ_COPY, torus.joint, 0);
    const double numbers = cost_of(CQ_GENERIC, 4, 8, CQ_COPY, torus.joint, 0);
    CHECK(joints > 0 && joints < 0.9 * numbers);
}

TEST(the_last_weight_is_what_is_left_and_the_others_follow_their_joints)
{
    const double weights = cost_of(CQ_WEIGHTS, 4, 8, CQ_AVERAGE, torus.weight, 1);
    const double numbers = cost_of(CQ_GENERIC, 4, 8, CQ_AVERAGE, torus.weight, 1);
    CHECK(weights > 0 && weights < 0.95 * numbers);
}

/* All that glTF knows: two textures, colors, eight joints, and positions and normals of two morph targets. */
TEST(all_standard_attributes_fit)
{
    cq_input in;
    begin(&in);
    add_channel(&in, CQ_TANGENT, 3, 10, CQ_AVERAGE, torus.tangent);
    add_channel(&in, CQ_TEXCOORD, 2, 12, CQ_AVERAGE, torus.uv);
    add_channel(&in, CQ_COLOR, 4, 8, CQ_AVERAGE, torus.weight);
    add_channel(&in, CQ_JOINTS, 4, 8, CQ_COPY, torus.joint);
    add_channel(&in, CQ_JOINTS, 4, 8, CQ_COPY, torus.joint);
    add_channel(&in, CQ_WEIGHTS, 4, 8, CQ_AVERAGE, torus.weight);
    add_channel(&in, CQ_WEIGHTS, 4, 8, CQ_AVERAGE, torus.weight);
    add_channel(&in, CQ_GENERIC, 3, 14, CQ_AVERAGE, torus.position);
    add_channel(&in, CQ_GENERIC, 3, 10, CQ_AVERAGE, torus.tangent);
    add_channel(&in, CQ_GENERIC, 3, 14, CQ_AVERAGE, torus.position);
    add_channel(&in, CQ_GENERIC, 3, 10, CQ_AVERAGE, torus.tangent);
    CHECK(in.shape.num_channels <= CQ_MAX_CHANNELS);
    CHECK(cost(&in) > 0);
    CHECK(CQ_INDEX_BITS == 16 || sizeof(cq_decoder) <= 12288);
}

/* A tangent that is turned by half a turn adapts the two models that were asked, and no other. */
TEST(by_faces_and_without_them_quarters_have_models_of_their_own)
{
    cq_decoder *d = (cq_decoder *)exact_alloc(sizeof *d);
    static const uint8_t data[8]; /* low codes: a bit is 1 where that is likely */
    int by_faces, k;
    for (by_faces = 0; by_faces < 2; ++by_faces) {
        memset(d, 0, sizeof *d);
        for (k = 0; k < 2; ++k) d->model.bit[CQI_AHEAD + k] = d->model.bit[CQI_BACK + k] = 0x8000;
        d->model.bit[CQI_AHEAD + by_faces] = 1;
        d->rate = 4;
        cq_range_decoder_init(&d->range, data, sizeof data);
        d->range.code = 0x100000; /* not in the part for a 1 of the first model */
        CHECK_EQ(cqi_code_quarters(d, by_faces, 0), 2);
        CHECK_EQ(d->model.bit[CQI_AHEAD + by_faces], 1);
        CHECK(d->model.bit[CQI_BACK + by_faces] > 0x8000);
        CHECK_EQ(d->model.bit[CQI_AHEAD + !by_faces], 0x8000);
        CHECK_EQ(d->model.bit[CQI_BACK + !by_faces], 0x8000);
    }
    exact_free(d);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_tangent_is_an_angle_around_the_normal);
    RUN(tangents_follow_the_texture_coordinates_before_them);
    RUN(texture_coordinates_of_tangents_are_numbers_that_change_slowly);
    RUN(tangents_that_are_normals_give_no_axes);
    RUN(tangents_of_separate_faces_come_back);
    RUN(normals_without_seams_follow_the_faces);
    RUN(a_tangent_without_a_normal_before_it_comes_back);
    RUN(by_faces_and_without_them_quarters_have_models_of_their_own);
    RUN(a_sign_may_be_any_number_of_the_channel);
    RUN(joints_are_those_of_neighbours_in_any_order);
    RUN(the_last_weight_is_what_is_left_and_the_others_follow_their_joints);
    RUN(all_standard_attributes_fit);
    return TEST_END();
}
