/* Planes that compete for the height of a new vertex: their heights, which of them count, and how they are asked about. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "test.h"

enum { LIMIT = 1 << CQI_RING_BITS };   /* offsets in the ring are below it, those beyond the ring below twice that */

static uint64_t random_state = 1;

static uint32_t random_below(uint32_t n)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 33) % n;
}

static int32_t any(int32_t low, int32_t high) { return low + (int32_t)random_below((uint32_t)(high - low) + 1); }

static cqi_vector vector(int32_t x, int32_t y, int32_t z)
{
    const cqi_vector a = { x, y, z };
    return a;
}

static cqi_vector anywhere(int32_t low, int32_t high)
{
    cqi_vector a;
    a.x = any(low, high);
    a.y = any(low, high);
    a.z = any(low, high);
    return a;
}

/* The height at a place, or LIMIT if the plane does not count. */
static int32_t height(cqi_vector place, cqi_vector a, cqi_vector b, cqi_vector c)
{
    cqi_fan f;
    f.num_rivals = 0;
    cqi_add_plane(&f, place, a, b, c);
    CHECK(f.num_rivals <= 1);
    if (f.num_rivals == 0) return LIMIT;
    CHECK_EQ(f.rival[0].y, 0);
    CHECK(f.rival[0].x > -LIMIT && f.rival[0].x < LIMIT);
    return f.rival[0].x;
}

static int64_t up(int64_t a, int64_t b) { return a / b + (a % b > 0); }

/* -- Heights ------------------------------------------------------------------------------------------------------- */

/* The triangle has sides along x and y; both parts of the height are rounded up. */
TEST(heights_are_exact_where_slopes_are_multiples_of_2_to_the_minus_14)
{
    int k, counted = 0;
    for (k = 0; k < 20000; ++k) {
        const int32_t dx = 4 << random_below(12), dy = 4 << random_below(12);
        const int32_t hx = 4 * any(1 - dx, dx - 1), hy = 4 * any(1 - dy, dy - 1); /* together not steep */
        const cqi_vector a = anywhere(-9999, 9999);
        const cqi_vector b = vector(a.x + dx, a.y, a.z + hx), c = vector(a.x, a.y + dy, a.z + hy);
        const cqi_vector place = cqi_plus(a, anywhere(-999, 999));
        const int64_t z = a.z + up((int64_t)hx * (place.x - a.x), dx) + up((int64_t)hy * (place.y - a.y), dy);
        if (z <= -LIMIT || z >= LIMIT) continue;
        CHECK_EQ(height(place, a, b, c), z);
        CHECK_EQ(height(place, a, c, b), z);
        ++counted;
    }
    CHECK(counted > 10000);
}

/* |height of the plane through a at a place - expected| is at most 18 / 2^14 of the distance, and two roundings: see
 * cqi_add_plane. A plane that does not count is steep or the height is beyond the ring. */
static int is_near(cqi_vector place, cqi_vector a, cqi_vector b, cqi_vector c, int *counted)
{
    const double bx = (b.x - a.x) >> 2, by = (b.y - a.y) >> 2, bz = (b.z - a.z) >> 2;
    const double cx = (c.x - a.x) >> 2, cy = (c.y - a.y) >> 2, cz = (c.z - a.z) >> 2;
    const double nx = by * cz - bz * cy, ny = bz * cx - bx * cz, nz = bx * cy - by * cx;
    const double sum = (nx < 0 ? -nx : nx) + (ny < 0 ? -ny : ny), depth = nz < 0 ? -nz : nz;
    const double far = (double)cqi_abs(place.x - a.x) + cqi_abs(place.y - a.y), most = 2 + far * 18 / 16384;
    const double limit = LIMIT;
    const int32_t z = height(place, a, b, c);
    double exact;
    if (8 * depth <= sum) return z == LIMIT;
    if (8 * depth < sum + 8) return 1;
    exact = a.z - (nx * (place.x - a.x) + ny * (place.y - a.y)) / nz;
    *counted += z != LIMIT;
    if (z == LIMIT) return exact <= most - limit || exact >= limit - most;
    return z >= exact - most && z <= exact + most;
}

/* Streams depend on each of them, so their sum is what it was when this was written. */
TEST(heights_of_any_planes_are_near_and_what_they_were)
{
    int64_t sum = 0;
    int k, counted = 0;
    random_state = 1;
    for (k = 0; k < 100000; ++k) {
        const int32_t r = LIMIT >> random_below(11), far = 4 << random_below(15);
        const cqi_vector a = anywhere(-r, r), b = anywhere(-r, r), c = anywhere(-2 * r, 2 * r - 1);
        const cqi_vector place = anywhere(-far, far);
        CHECK(is_near(place, a, b, c, &counted));
        sum += (k % 1000 + 1) * (int64_t)height(place, a, b, c);
    }
    CHECK(counted > 30000);
    CHECK_EQ(sum, 219384831370);
}

/* All corners of what a, b, c and the place may be; sanitizers see numbers that overflow. */
TEST(heights_are_near_at_the_limits_of_offsets)
{
    static const int32_t inside[] = { 1 - LIMIT, 0, LIMIT - 1 }, outside[] = { -2 * LIMIT, 1, 2 * LIMIT - 1 };
    static const int32_t far[] = { -CQI_FAR, 0, CQI_FAR };
    int i, j, k, at, counted = 0;
    for (i = 0; i < 27; ++i)
        for (j = 0; j < 27; ++j)
            for (k = 0; k < 27; ++k)
                for (at = 0; at < 9; ++at) {
                    const cqi_vector a = vector(inside[i % 3], inside[i / 3 % 3], inside[i / 9]);
                    const cqi_vector b = vector(inside[j % 3], inside[j / 3 % 3], inside[j / 9]);
                    const cqi_vector c = vector(outside[k % 3], outside[k / 3 % 3], outside[k / 9]);
                    const cqi_vector place = vector(far[at % 3], far[at / 3], 0);
                    CHECK(is_near(place, a, b, c, &counted));
                    CHECK(is_near(place, a, c, b, &counted));
                }
    CHECK(counted > 10000);
}

/* -- Planes that do not count -------------------------------------------------------------------------------------- */

TEST(steep_planes_and_lines_do_not_count)
{
    const cqi_vector a = vector(40, 80, 12);
    int k;
    for (k = 0; k < 4; ++k) {
        const int32_t sx = k & 1 ? 1 : -1, sy = k & 2 ? 1 : -1;
        const cqi_vector up = vector(40 + 4, 80, 12), right = vector(40, 80 + 4, 12);
        CHECK_EQ(height(a, a, vector(44, 80, 12 + sx * 28), right), 12);
        CHECK_EQ(height(a, a, vector(44, 80, 12 + sx * 32), right), LIMIT);
        CHECK_EQ(height(a, a, up, vector(40, 84, 12 + sy * 28)), 12);
        CHECK_EQ(height(a, a, up, vector(40, 84, 12 + sy * 32)), LIMIT);
        CHECK_EQ(height(a, a, vector(44, 80, 12 + sx * 16), vector(40, 84, 12 + sy * 12)), 12);
        CHECK_EQ(height(a, a, vector(44, 80, 12 + sx * 16), vector(40, 84, 12 + sy * 16)), LIMIT);
    }
    CHECK_EQ(height(a, a, a, a), LIMIT);
    CHECK_EQ(height(a, a, vector(80, 160, 24), vector(120, 240, 36)), LIMIT);
}

TEST(heights_beyond_the_ring_do_not_count_nor_those_after_sixteen)
{
    const cqi_vector a = vector(0, 0, 0), b = vector(64, 0, 64), c = vector(0, 64, 0);
    cqi_fan f;
    int k;
    CHECK_EQ(height(vector(LIMIT - 1, 0, 0), a, b, c), LIMIT - 1);
    CHECK_EQ(height(vector(LIMIT, 0, 0), a, b, c), LIMIT);
    CHECK_EQ(height(vector(1 - LIMIT, 0, 0), a, b, c), 1 - LIMIT);
    CHECK_EQ(height(vector(-LIMIT, 0, 0), a, b, c), LIMIT);
    f.num_rivals = 0;
    for (k = 0; k < CQI_RIVALS + 3; ++k) cqi_add_plane(&f, vector(k, 0, 0), a, b, c);
    CHECK_EQ(f.num_rivals, CQI_RIVALS);
    for (k = 0; k < CQI_RIVALS; ++k) CHECK_EQ(f.rival[k].x, k);
}

/* -- Which planes there are ---------------------------------------------------------------------------------------- */

/* Vertices around a polygon, and beyond each of its edges one; all at any heights. */
static void make_fan(cqi_fan *f, int n)
{
    static const int32_t x[8] = { 800, 560, 0, -560, -800, -560, 0, 560 };
    int k;
    memset(f, 0, sizeof *f);
    f->size = n;
    for (k = 0; k < n; ++k) {
        const int at = 8 * k / n, next = (8 * k / n + 8 / n / 2 + 1) % 8;
        f->at[k] = vector(x[at], x[(at + 6) % 8], any(-200, 200));
        f->outer[k] = vector(2 * x[next], 2 * x[(next + 6) % 8], any(-200, 200));
    }
    f->known = ((uint32_t)1 << n) - 1;
}

TEST(planes_are_those_across_edges_and_those_of_two_edges)
{
    int n, trial;
    for (n = 1; n <= 8; ++n) {
        for (trial = 0; trial < 50; ++trial) {
            const cqi_vector place = anywhere(-99, 99);
            cqi_fan f, expected;
            int k;
            make_fan(&f, n);
            if (trial > 0) f.known = random_below(f.known + 1);
            expected = f;
            for (k = 0; k < n && n >= 3; ++k)
                if (f.known >> k & 1) cqi_add_plane(&expected, place, f.at[k], f.at[(k + 1) % n], f.outer[k]);
            for (k = 0; k < n && n > 3; ++k) cqi_add_plane(&expected, place, f.at[k], f.at[(k + n - 1) % n], f.at[(k + 1) % n]);
            cqi_list_planes(&f, place);
            CHECK_EQ(f.num_rivals, expected.num_rivals);
            CHECK(memcmp(f.rival, expected.rival, sizeof *f.rival * (size_t)f.num_rivals) == 0);
            if (trial == 0) CHECK(f.num_rivals >= (n < 3 ? 0 : n == 3 ? 2 : n + 2) && (n >= 3 || f.num_rivals == 0));
            f.num_rivals = 0;
            f.boundary = 1;
            cqi_list_planes(&f, place);
            CHECK_EQ(f.num_rivals, 0);
        }
    }
}

TEST(flat_is_less_than_four_steps_from_the_plane)
{
    int k, shift;
    for (shift = -8; shift <= 12; ++shift) {
        const int32_t limit = 4 << (shift < 0 ? 0 : shift);
        for (k = 0; k < CQI_FEATURES; ++k) {
            cqi_fan f;
            memset(&f, 0, sizeof f);
            f.height[(k + 1) % CQI_FEATURES] = limit - 1;
            f.height[(k + 2) % CQI_FEATURES] = 1 - limit;
            CHECK(cqi_is_flat(&f, shift));
            f.height[k] = 1 - limit;
            CHECK(cqi_is_flat(&f, shift));
            f.height[k] = limit;
            CHECK(!cqi_is_flat(&f, shift));
            memset(&f, 0, sizeof f);
            CHECK(cqi_is_flat(&f, shift));
            f.height[k] = -limit;
            CHECK(!cqi_is_flat(&f, shift));
        }
    }
}

/* -- Heights that are coded ---------------------------------------------------------------------------------------- */

enum { NUM_HEIGHTS = 3000, MAX_BYTES = 8 * NUM_HEIGHTS };

static int32_t roof_height(int32_t x, int32_t y, int32_t slope) { return y - (x < -600 ? 0 : slope * (x + 600)); }

/* A fan of two flat sides that meet in an edge; of the vertices beyond, some are anywhere or nowhere. Returns the height
 * of the roof at a place, which is beside the edge where most vertices are. */
static int32_t make_roof(cqi_fan *f, cqi_vector place)
{
    static const int32_t x[6] = { 1024, 512, -512, -1024, -512, 512 }, y[6] = { 0, 1024, 1024, 0, -1024, -1024 };
    const int32_t slope = any(1, 3);
    int k;
    memset(f, 0, sizeof *f);
    f->size = 6;
    for (k = 0; k < 6; ++k) {
        f->at[k] = vector(x[k], y[k], roof_height(x[k], y[k], slope));
        f->outer[k] = vector(x[k] + x[(k + 1) % 6], y[k] + y[(k + 1) % 6], 0);
        f->outer[k].z = any(0, 3) ? roof_height(f->outer[k].x, f->outer[k].y, slope) : any(-900, 900);
    }
    f->known = random_below(64) | random_below(64);
    f->extent = 600;
    return roof_height(place.x, place.y, slope);
}

/* Heights of the roof, every eighth anything, in the scale 2^shift, as an encoder or, without a plan, a decoder codes
 * them; what is predicted without planes is the roof, or anything. Returns how many come out as they went in. */
static int code_heights(cq_decoder *d, int shift, int flat_sides, int predict_roof)
{
    cq_shape shape;
    int k, good = 0;
    memset(&shape, 0, sizeof shape);
    cqi_model_init(&d->model, &shape);
    d->rate = 5;
    d->ring.shift = shift;
    d->ring.factor = 1 << (shift > 0 ? shift : 0);
    d->ring.right = shift < 0 ? -shift : 0;
    random_state = 1;
    for (k = 0; k < NUM_HEIGHTS; ++k) {
        const cqi_vector a = anywhere(-120, 120);
        cqi_vector place = vector(4 * a.x, 4 * a.y, 0);
        const int32_t roof = make_roof(&d->now.fan, place);
        const int32_t z = cqi_unscaled(k % 8 == 0 ? any(-2000, 2000) : roof, shift);
        const int32_t predicted = predict_roof ? roof : any(-2000, 2000);
        int32_t value = CQI_ENCODING(d) ? z : -7777;
        d->now.fan.flat_sides = flat_sides;
        d->now.fan.num_rivals = 9;
        d->now.fan.over.linear.y = 5000;
        cqi_code_above(d, 12, predicted, &place, &value);
        CHECK_EQ(place.z, cqi_scaled(value, &d->ring));
        good += value == z;
    }
    return good;
}

/* Encodes and decodes; both sides learn the same. Returns the number of bytes; *worth: of asking, at the end. */
static int bytes_of_heights(int shift, int flat_sides, int predict_roof, int32_t *worth)
{
    static uint8_t bytes[MAX_BYTES];
    static cq_decoder encoder, decoder;
    static cqi_plan plan;
    size_t size;
    memset(&encoder, 0, sizeof encoder);
    memset(&decoder, 0, sizeof decoder);
    encoder.plan = &plan;
    cq_range_encoder_init(&plan.range, bytes, sizeof bytes);
    CHECK_EQ(code_heights(&encoder, shift, flat_sides, predict_roof), NUM_HEIGHTS);
    size = cq_range_encoder_finish(&plan.range);
    CHECK(size <= sizeof bytes);
    cq_range_decoder_init(&decoder.range, bytes, size);
    CHECK_EQ(code_heights(&decoder, shift, flat_sides, predict_roof), NUM_HEIGHTS);
    CHECK(memcmp(&encoder.model, &decoder.model, sizeof encoder.model) == 0);
    *worth = encoder.model.worth_flat;
    return (int)size;
}

TEST(heights_of_a_roof_come_back_and_planes_save_most_of_their_bits)
{
    int shift;
    for (shift = -2; shift <= 2; ++shift) {
        int32_t worth, usual, nothing;
        const int with = bytes_of_heights(shift, 1, 0, &worth), without = bytes_of_heights(shift, 0, 0, &usual);
        CHECK(4 * with < without);
        CHECK(worth > 3000);
        CHECK_EQ(usual, 256);
        bytes_of_heights(shift, 1, 1, &nothing);
        CHECK(nothing < 0);
    }
}

/* -- Numbers ------------------------------------------------------------------------------------------------------- */

TEST(lengths_of_numbers_are_those_of_their_halves)
{
    int bits;
    CHECK_EQ(cqi_bit_length_wide(0), 0);
    for (bits = 0; bits < 64; ++bits) {
        const uint64_t x = (uint64_t)1 << bits;
        CHECK_EQ(cqi_bit_length_wide(x), bits + 1);
        CHECK_EQ(cqi_bit_length_wide(x | (x - 1)), bits + 1);
        CHECK_EQ(cqi_bit_length_wide(x - 1), bits);
    }
}

/* An incomplete ring, which has fewer than three vertices or a boundary, has a class of its own. */
TEST(fans_are_classed_by_their_size_if_they_are_complete)
{
    cqi_fan f;
    int size;
    memset(&f, 0, sizeof f);
    for (size = 1; size < 20; ++size) {
        f.size = size;
        f.boundary = 0;
        CHECK_EQ(cqi_fan_class(&f), size < 3 ? 0 : (size < 9 ? size : 9) - 2);
        f.boundary = 1;
        CHECK_EQ(cqi_fan_class(&f), 0);
    }
}

/* Of one triangle, on either side; of two, the sum. */
TEST(the_normal_of_an_edge_is_the_sum_of_those_beside_it)
{
    const cqi_vector b = vector(100, 0, 0), c = vector(30, 50, 0), e = vector(20, -7, 40);
    const cqi_vector left = cqi_normal_of(b, &c, NULL), right = cqi_normal_of(b, NULL, &e), both = cqi_normal_of(b, &c, &e);
    CHECK(left.x == 0 && left.y == 0 && left.z == 5000);
    CHECK(right.x == 0 && right.y == 4000 && right.z == 700);
    CHECK(both.x == 0 && both.y == 4000 && both.z == 5700);
}

/* One for every 16 old ones, and for every 32 faces. */
TEST(a_regular_level_needs_new_vertices_for_its_vertices_and_faces)
{
    cqi_regular r;
    memset(&r, 0, sizeof r);
    r.vertices = 160;
    r.real_faces = 320;
    for (r.count = 0; r.count < 40; ++r.count) CHECK_EQ(cqi_is_worth_it(&r), r.count >= CQI_MIN_SPLITS(160) && r.count > 10);
    r.real_faces = 960;
    for (r.count = 0; r.count < 40; ++r.count) CHECK_EQ(cqi_is_worth_it(&r), r.count > 30);
}

/* Rows have values if they have channels: without, their number is not bounded by what is read for them. */
TEST(rows_have_the_values_of_channels_that_are_not_of_faces)
{
    cq_shape s;
    memset(&s, 0, sizeof s);
    CHECK(!cqi_has_rows(&s));
    s.num_channels = 1;
    s.channel[0].components = 1;
    s.channel[0].merge = CQ_PER_FACE;
    CHECK(!cqi_has_rows(&s));
    s.channel[0].merge = CQ_AVERAGE;
    s.channel[0].kind = CQ_TEXCOORD;
    s.channel[0].components = 2;
    CHECK(cqi_has_rows(&s));
    s.num_rows = 9; /* then they are of rows, and not of vertices */
    CHECK(cqi_has_rows(&s));
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(heights_are_exact_where_slopes_are_multiples_of_2_to_the_minus_14);
    RUN(heights_of_any_planes_are_near_and_what_they_were);
    RUN(heights_are_near_at_the_limits_of_offsets);
    RUN(steep_planes_and_lines_do_not_count);
    RUN(heights_beyond_the_ring_do_not_count_nor_those_after_sixteen);
    RUN(planes_are_those_across_edges_and_those_of_two_edges);
    RUN(flat_is_less_than_four_steps_from_the_plane);
    RUN(heights_of_a_roof_come_back_and_planes_save_most_of_their_bits);
    RUN(lengths_of_numbers_are_those_of_their_halves);
    RUN(fans_are_classed_by_their_size_if_they_are_complete);
    RUN(the_normal_of_an_edge_is_the_sum_of_those_beside_it);
    RUN(a_regular_level_needs_new_vertices_for_its_vertices_and_faces);
    RUN(rows_have_the_values_of_channels_that_are_not_of_faces);
    return TEST_END();
}
