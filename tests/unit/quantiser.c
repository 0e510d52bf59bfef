/* The quantiser: floats to values and back, on grids and on the octahedron. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "exact.h"
#include "test.h"
#include <math.h>

#define INFINITE 0x7f800000u
#define NOT_A_NUMBER 0x7fc00000u
#define LARGEST 0x7f7fffffu

static float float_of(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static uint32_t bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static cq_channel channel_of(cq_kind kind, int components, int bits)
{
    cq_channel c;
    memset(&c, 0, sizeof c);
    c.kind = (uint8_t)kind;
    c.components = (uint8_t)components;
    c.bits = (uint8_t)bits;
    return c;
}

/* -- The grid of a box --------------------------------------------------------------------------------------------- */

TEST(step_and_origin_come_as_the_floats_that_they_are)
{
    cq_channel c;
    int k;
    memset(&c, 0, sizeof c);
    c.step = bits_of(0.25f);
    for (k = 0; k < CQ_MAX_COMPONENTS; ++k) c.origin[k] = bits_of((float)k - 1.5f);
    CHECK(cq_channel_step(&c) == 0.25f);
    for (k = 0; k < CQ_MAX_COMPONENTS; ++k) CHECK(cq_channel_origin(&c, k) == (float)k - 1.5f);
    c.step = NOT_A_NUMBER;
    c.origin[3] = INFINITE;
    CHECK(cq_channel_step(&c) != cq_channel_step(&c));
    CHECK_EQ(bits_of(cq_channel_origin(&c, 3)), INFINITE);
}

TEST(a_grid_begins_at_the_minimum_and_ends_with_the_longest_side)
{
    const float box[] = { -1, 2, 5, 2, 3, 6, 0, 2.4f, 5.6f };
    const cq_value expected[] = { 0, 0, 0, 3, 1, 1, 1, 0, 1 };
    cq_channel c = channel_of(CQ_POSITION, 3, 2);
    cq_value values[9];
    cq_place place;
    float back[9];
    REQUIRE_EQ(cq_fit_grid(&c, box, 3, &place), CQ_OK);
    CHECK_EQ(place.vertex, CQ_NONE);
    CHECK_EQ(c.step, bits_of(1));
    CHECK_EQ(c.origin[0], bits_of(-1));
    CHECK_EQ(c.origin[1], bits_of(2));
    CHECK_EQ(c.origin[2], bits_of(5));
    REQUIRE_EQ(cq_quantise(&c, box, 3, values, &place), CQ_OK);
    CHECK(memcmp(values, expected, sizeof expected) == 0);
    cq_reconstruct(&c, values, 3, back);
    CHECK(back[0] == -1 && back[3] == 2 && back[4] == 3 && back[6] == 0 && back[7] == 2 && back[8] == 6);
}

TEST(a_point_or_nothing_has_a_grid_without_a_step)
{
    const float point[] = { -3.25f, 1e-30f, 7e30f, -3.25f, 1e-30f, 7e30f };
    cq_value values[6];
    float back[6];
    cq_channel c = channel_of(CQ_POSITION, 3, 12);
    REQUIRE_EQ(cq_fit_grid(&c, point, 2, NULL), CQ_OK);
    CHECK_EQ(c.step, 0);
    REQUIRE_EQ(cq_quantise(&c, point, 2, values, NULL), CQ_OK);
    cq_reconstruct(&c, values, 2, back);
    CHECK(memcmp(back, point, sizeof point) == 0);
    CHECK_EQ(cq_fit_grid(&c, NULL, 0, NULL), CQ_OK);
    CHECK_EQ(c.step, 0);
    CHECK_EQ(c.origin[2], 0);
    CHECK_EQ(cq_quantise(&c, NULL, 0, NULL, NULL), CQ_OK);
}

TEST(points_of_a_grid_are_never_closer_than_floats)
{
    const float far[] = { 16777216.0f, 16777218.0f };
    cq_channel c = channel_of(CQ_GENERIC, 1, 12);
    cq_value values[2];
    float back[2];
    REQUIRE_EQ(cq_fit_grid(&c, far, 2, NULL), CQ_OK);
    CHECK(c.step > bits_of(2));
    REQUIRE_EQ(cq_quantise(&c, far, 2, values, NULL), CQ_OK);
    CHECK_EQ(values[1], 1);
    cq_reconstruct(&c, values, 2, back);
    CHECK(back[0] == far[0] && back[1] == far[1]);
}

TEST(the_last_point_of_a_fine_grid_is_not_one_too_far)
{
    const float box[] = { -3, 4 };
    cq_channel c = channel_of(CQ_GENERIC, 1, CQ_MAX_BITS);
    cq_value values[2];
    REQUIRE_EQ(cq_fit_grid(&c, box, 2, NULL), CQ_OK);
    REQUIRE_EQ(cq_quantise(&c, box, 2, values, NULL), CQ_OK);
    CHECK_EQ(values[1], ((int64_t)1 << CQ_MAX_BITS) - 1);
}

/* The side goes float by float, each of which is rounded to a step in another way; a step that is rounded up may leave
 * the last point unused. */
TEST(no_side_reaches_behind_the_last_point_of_a_fine_grid)
{
    cq_channel c = channel_of(CQ_GENERIC, 1, CQ_MAX_BITS);
    int k;
    for (k = 0; k < 32; ++k) {
        const float low = k < 16 ? -0.5f : -3.5f;
        const float box[] = { float_of(bits_of(low) + (uint32_t)k), 3.75f };
        cq_value values[2];
        REQUIRE_EQ(cq_fit_grid(&c, box, 2, NULL), CQ_OK);
        REQUIRE_EQ(cq_quantise(&c, box, 2, values, NULL), CQ_OK);
        CHECK(values[1] >= ((int64_t)1 << CQ_MAX_BITS) - (k < 16 ? 2 : 1));
    }
}

TEST(a_box_that_needs_a_step_beyond_all_floats_is_refused)
{
    const float box[] = { -float_of(LARGEST), float_of(LARGEST) };
    cq_channel c = channel_of(CQ_GENERIC, 1, 2);
    cq_value values[2];
    cq_place place;
    REQUIRE_EQ(cq_fit_grid(&c, box, 2, NULL), CQ_OK);
    CHECK_EQ(cq_quantise(&c, box, 2, values, NULL), CQ_OK);
    CHECK_EQ(values[1], 3);
    c.bits = 1;
    CHECK_EQ(cq_fit_grid(&c, box, 2, &place), CQ_ERROR_VALUE);
    CHECK_EQ(place.vertex, CQ_NONE);
}

/* -- The grid of a step -------------------------------------------------------------------------------------------- */

TEST(an_aligned_grid_has_the_step_and_as_many_bits_as_the_box_needs)
{
    const float box[] = { -0.75f, 0.5f, 0, 1, 0.5f, 3.5f };
    cq_channel c = channel_of(CQ_POSITION, 3, 0);
    REQUIRE_EQ(cq_align_grid(&c, 0.5f, box, 2, NULL), CQ_OK);
    CHECK_EQ(c.step, bits_of(0.5f));
    CHECK_EQ(c.origin[0], bits_of(-1));
    CHECK_EQ(c.origin[1], bits_of(0.5f));
    CHECK_EQ(c.origin[2], bits_of(0));
    CHECK_EQ(c.bits, 3);
    REQUIRE_EQ(cq_align_grid(&c, 4, box, 2, NULL), CQ_OK);
    CHECK_EQ(c.bits, 1);
    CHECK_EQ(c.origin[0], bits_of(-4));
}

TEST(an_aligned_grid_may_be_far_from_zero_and_finer_than_floats)
{
    const float far[] = { 1e20f, 1e20f };
    cq_channel c = channel_of(CQ_GENERIC, 1, 0);
    cq_value values[2];
    float back[2];
    REQUIRE_EQ(cq_align_grid(&c, float_of(1), far, 2, NULL), CQ_OK);
    CHECK_EQ(c.origin[0], bits_of(1e20f));
    REQUIRE_EQ(cq_quantise(&c, far, 2, values, NULL), CQ_OK);
    cq_reconstruct(&c, values, 2, back);
    CHECK(back[0] == far[0]);
}

TEST(an_aligned_grid_needs_a_power_of_two_and_a_box_that_is_not_too_large)
{
    const float box[] = { 0, 1 };
    const float good[] = { 1, 0.25f, 1024 }, bad[] = { 0, -1, 3, 0.1f, -0.5f };
    const float lowest = -float_of(LARGEST);
    cq_channel c = channel_of(CQ_GENERIC, 1, 0);
    cq_place place;
    size_t k;
    for (k = 0; k < 3; ++k) CHECK_EQ(cq_align_grid(&c, good[k], box, 2, NULL), CQ_OK);
    for (k = 0; k < 5; ++k) CHECK_EQ(cq_align_grid(&c, bad[k], box, 2, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_align_grid(&c, float_of(INFINITE), box, 2, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_align_grid(&c, float_of(NOT_A_NUMBER), box, 2, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_align_grid(&c, float_of(3), box, 2, NULL), CQ_ERROR_ARGUMENT);       /* 3 * 2^-149 */
    CHECK_EQ(cq_align_grid(&c, float_of(2), box, 2, &place), CQ_ERROR_VALUE);        /* too fine for the box */
    CHECK_EQ(place.vertex, CQ_NONE);
    CHECK_EQ(cq_align_grid(&c, float_of(0x7f000000), &lowest, 1, &place), CQ_ERROR_VALUE);  /* below it: -2^128 */
    CHECK_EQ(cq_align_grid(&c, float_of((uint32_t)(127 - CQ_MAX_BITS) << 23), box, 2, NULL), CQ_ERROR_VALUE);
    CHECK_EQ(cq_align_grid(&c, float_of((uint32_t)(128 - CQ_MAX_BITS) << 23), box, 2, NULL), CQ_OK);
    CHECK_EQ(c.bits, CQ_MAX_BITS);
}

/* -- Errors -------------------------------------------------------------------------------------------------------- */

TEST(floats_that_are_none_are_an_error_with_a_place)
{
    const uint32_t bad[] = { INFINITE, 0x80000000u | INFINITE, NOT_A_NUMBER };
    size_t k;
    for (k = 0; k < 3; ++k) {
        float from[] = { 0, 1, 2, 3, 4, 5, 6, 7, 8 };
        cq_channel c = channel_of(CQ_POSITION, 3, 8);
        cq_value values[9];
        cq_place place;
        REQUIRE_EQ(cq_fit_grid(&c, from, 3, NULL), CQ_OK);
        from[5] = float_of(bad[k]);
        CHECK_EQ(cq_fit_grid(&c, from, 3, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 1);
        CHECK_EQ(cq_align_grid(&c, 1, from, 3, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 1);
        CHECK_EQ(cq_quantise(&c, from, 3, values, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 1);
        CHECK_EQ(place.face, CQ_NONE);
        CHECK_EQ(cq_quantise_normals(8, from, 3, values, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 1);
        from[3] = from[5];                 /* in the other coordinates, too */
        from[5] = 5;
        CHECK_EQ(cq_quantise_normals(8, from, 3, values, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 1);
        from[4] = from[3];
        from[3] = 3;
        CHECK_EQ(cq_quantise_normals(8, from, 3, values, &place), CQ_ERROR_VALUE);
        CHECK_EQ(place.vertex, 1);
    }
}

TEST(half_a_step_off_the_grid_is_an_error)
{
    const float inside[] = { -0.5f, 3.25f }, below[] = { 0, -0.625f }, above[] = { 3.5f, 0 };
    cq_channel c = channel_of(CQ_GENERIC, 1, 2);
    cq_value values[2];
    cq_place place;
    c.step = bits_of(1);
    REQUIRE_EQ(cq_quantise(&c, inside, 2, values, NULL), CQ_OK);
    CHECK_EQ(values[0], 0);
    CHECK_EQ(values[1], 3);
    CHECK_EQ(cq_quantise(&c, below, 2, values, &place), CQ_ERROR_VALUE);
    CHECK_EQ(place.vertex, 1);
    CHECK_EQ(cq_quantise(&c, above, 2, values, &place), CQ_ERROR_VALUE);
    CHECK_EQ(place.vertex, 0);
    c.step = 0;
    CHECK_EQ(cq_quantise(&c, above, 2, values, &place), CQ_ERROR_VALUE);
    CHECK_EQ(cq_quantise(&c, above + 1, 1, values, &place), CQ_OK);
}

TEST(bad_arguments_of_the_quantiser_are_refused)
{
    const float from[4] = { 0, 0, 0, 1 };
    cq_channel c = channel_of(CQ_POSITION, 3, 8);
    cq_value to[4];
    CHECK_EQ(cq_fit_grid(NULL, from, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_fit_grid(&c, NULL, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_align_grid(NULL, 1, from, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_align_grid(&c, 1, NULL, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise(NULL, from, 1, to, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise(&c, NULL, 1, to, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise(&c, from, 1, NULL, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise_normals(1, from + 1, 1, to, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise_normals(CQ_MAX_BITS + 1, from + 1, 1, to, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise_normals(8, NULL, 1, to, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise_normals(8, from + 1, 1, NULL, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise_normals(8, NULL, 0, NULL, NULL), CQ_OK);
    CHECK_EQ(cq_align_grid(&c, 1, NULL, 0, NULL), cq_fit_grid(&c, NULL, 0, NULL));
    c.components = 0;
    CHECK_EQ(cq_align_grid(&c, 1, from, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_fit_grid(&c, from, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise(&c, from, 1, to, NULL), CQ_ERROR_ARGUMENT);
    c.components = 3;
    c.bits = CQ_MAX_BITS + 1;
    CHECK_EQ(cq_fit_grid(&c, from, 1, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_quantise(&c, from, 1, to, NULL), CQ_ERROR_ARGUMENT);
}

/* -- What comes back ----------------------------------------------------------------------------------------------- */

TEST(what_comes_back_is_finite_whatever_the_channel_says)
{
    const uint32_t numbers[] = { 0, 1, 0x3f800000, LARGEST, INFINITE, NOT_A_NUMBER, 0x80000000u | LARGEST,
                                 0x80000000u | INFINITE };
    const cq_value values[] = { 0, 1, 0x7fff };
    size_t i, j, k;
    for (i = 0; i < 8; ++i) {
        for (j = 0; j < 8; ++j) {
            cq_channel c = channel_of(CQ_GENERIC, 1, 15);
            float back[3];
            c.step = numbers[i];
            c.origin[0] = numbers[j];
            cq_reconstruct(&c, values, 3, back);
            for (k = 0; k < 3; ++k) CHECK((bits_of(back[k]) & INFINITE) != INFINITE);
            if (numbers[i] == NOT_A_NUMBER || numbers[j] == NOT_A_NUMBER) CHECK_EQ(bits_of(back[1]), 0);
        }
    }
}

/* -- Normals ------------------------------------------------------------------------------------------------------- */

/* The header's lines for a shader, with a normalised attribute, in floats. */
static void shade(float x, float y, float largest, int bits, float *to)
{
    const float half = ldexpf(1, bits - 1) - 1;
    const float p = x * largest / half - 1, q = y * largest / half - 1, z = 1 - fabsf(p) - fabsf(q);
    const float a = z < 0 ? (1 - fabsf(q)) * (p < 0 ? -1.0f : 1.0f) : p;
    const float b = z < 0 ? (1 - fabsf(p)) * (q < 0 ? -1.0f : 1.0f) : q;
    const float length = sqrtf(a * a + b * b + z * z);
    to[0] = a / length;
    to[1] = b / length;
    to[2] = z / length;
}

TEST(a_shader_has_the_normals_of_the_library)
{
    int bits, x, y, k;
    for (bits = 3; bits <= 15; bits += bits == 15 ? 1 : 2) {
        const int last = (1 << bits) - 2, step = last / 14 > 1 ? last / 14 : 1;
        const float largest = bits <= 8 ? 255.0f : 65535.0f;
        for (x = 0; x <= last; x += step) {
            for (y = 0; y <= last; y += step) {
                const cq_value pair[2] = { (cq_value)x, (cq_value)y };
                float exact[3], seen[3];
                cq_reconstruct_normals(bits, pair, 1, exact);
                shade((float)x / largest, (float)y / largest, largest, bits, seen);
                for (k = 0; k < 3; ++k) CHECK(fabsf(seen[k] - exact[k]) < 1e-5f);
            }
        }
    }
}

TEST(a_shader_has_the_positions_of_the_library)
{
    const float box[] = { -3.5f, 100, 0.25f, 7, 122, 0.5f };
    cq_channel c = channel_of(CQ_POSITION, 3, 12);
    float back[6];
    cq_value values[6];
    int k;
    REQUIRE_EQ(cq_fit_grid(&c, box, 2, NULL), CQ_OK);
    REQUIRE_EQ(cq_quantise(&c, box, 2, values, NULL), CQ_OK);
    cq_reconstruct(&c, values, 2, back);
    for (k = 0; k < 6; ++k) {
        const float attribute = (float)values[k] / 65535;
        CHECK(fabsf(cq_channel_origin(&c, k % 3) + cq_channel_step(&c) * 65535 * attribute - back[k]) < 1e-4f);
    }
}

TEST(axes_come_back_exactly_and_length_does_not_matter)
{
    int bits, axis, sign;
    for (bits = 2; bits <= CQ_MAX_BITS; ++bits) {
        for (axis = 0; axis < 3; ++axis) {
            for (sign = -1; sign <= 1; sign += 2) {
                float normal[3] = { 0, 0, 0 }, back[3];
                cq_value pair[2];
                normal[axis] = (float)sign * 1e-20f;
                REQUIRE_EQ(cq_quantise_normals(bits, normal, 1, pair, NULL), CQ_OK);
                CHECK(pair[0] >= 0 && pair[0] >> bits == 0 && pair[1] >= 0 && pair[1] >> bits == 0);
                cq_reconstruct_normals(bits, pair, 1, back);
                normal[axis] = (float)sign;
                CHECK(back[0] == normal[0] && back[1] == normal[1] && back[2] == normal[2]);
            }
        }
    }
}

TEST(a_vector_without_a_direction_is_an_error)
{
    const float normals[] = { 0, 0, 1, 0, -0.0f, 0 };
    cq_value pairs[4];
    cq_place place;
    CHECK_EQ(cq_quantise_normals(8, normals, 2, pairs, &place), CQ_ERROR_VALUE);
    CHECK_EQ(place.vertex, 1);
    CHECK_EQ(cq_quantise_normals(8, normals, 1, pairs, &place), CQ_OK);
    CHECK_EQ(place.vertex, CQ_NONE);
}

TEST(any_pair_is_a_unit_vector)
{
    int bits;
    cq_value pair[2];
    for (bits = 2; bits <= 6; ++bits) {
        for (pair[0] = -1; pair[0] <= 1 << bits; ++pair[0]) {
            for (pair[1] = -1; pair[1] <= 1 << bits; ++pair[1]) {
                float n[3], length;
                cq_reconstruct_normals(bits, pair, 1, n);
                length = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
                CHECK(length > 0.999999f && length < 1.000001f);
            }
        }
    }
}

#if CQ_INDEX_BITS == 32
TEST(exact_channels_copy_floats_whatever_they_are)
{
    const uint32_t patterns[] = { 0x80000000u, NOT_A_NUMBER | 77, INFINITE, 1, LARGEST, 0xffffffffu };
    cq_channel c = channel_of(CQ_POSITION, 3, CQ_EXACT_BITS);
    float from[6], back[6];
    cq_value values[6];
    cq_place place;
    memcpy(from, patterns, sizeof from);
    CHECK_EQ(cq_fit_grid(&c, from, 2, &place), CQ_ERROR_ARGUMENT);
    REQUIRE_EQ(cq_quantise(&c, from, 2, values, &place), CQ_OK);
    CHECK_EQ(place.vertex, CQ_NONE);
    CHECK(memcmp(values, patterns, sizeof patterns) == 0);
    cq_reconstruct(&c, values, 2, back);
    CHECK(memcmp(back, patterns, sizeof patterns) == 0);
    CHECK_EQ(cq_quantise(&c, NULL, 0, NULL, NULL), CQ_OK);
    cq_reconstruct(&c, NULL, 0, NULL);
}

/* The sanitizer for types forgets that a local was declared once bytes have been copied into it. */
#if defined(__has_feature)
#if __has_feature(type_sanitizer)
#define TYPES_OF_LOCALS_GET_LOST
#endif
#endif

/* A compiler may assume that nothing reads an integer where a float was stored, and memory from malloc is of the type that
 * was stored last. -fsanitize=type sees what no compiler makes use of so far. */
TEST(exact_values_and_floats_have_the_types_that_they_are_read_as)
{
    enum { COUNT = 300 };
    cq_channel c = channel_of(CQ_GENERIC, 3, CQ_EXACT_BITS);
    float *from = (float *)exact_alloc(COUNT * sizeof *from), *back = (float *)exact_alloc(COUNT * sizeof *back);
    cq_value *values = (cq_value *)exact_alloc(COUNT * sizeof *values);
    int32_t bits;
    int k;
    c.merge = CQ_COPY;
    for (k = 0; k < COUNT; ++k) from[k] = (float)k / 7;
    CHECK_EQ(cq_quantise(&c, from, COUNT / 3, values, NULL), CQ_OK);
    for (k = 0; k < COUNT; ++k) {
        float x = (float)k / 7;
        memcpy(&bits, &x, sizeof bits);
        CHECK_EQ(values[k], bits);
    }
    cq_reconstruct(&c, values, COUNT / 3, back);
#ifndef TYPES_OF_LOCALS_GET_LOST
    for (k = 0; k < COUNT; ++k) CHECK(back[k] == from[k]);
#endif
    exact_free(from);
    exact_free(back);
    exact_free(values);
}
#endif

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_shader_has_the_normals_of_the_library);
    RUN(a_shader_has_the_positions_of_the_library);
    RUN(step_and_origin_come_as_the_floats_that_they_are);
    RUN(a_grid_begins_at_the_minimum_and_ends_with_the_longest_side);
    RUN(a_point_or_nothing_has_a_grid_without_a_step);
    RUN(points_of_a_grid_are_never_closer_than_floats);
    RUN(the_last_point_of_a_fine_grid_is_not_one_too_far);
    RUN(no_side_reaches_behind_the_last_point_of_a_fine_grid);
    RUN(a_box_that_needs_a_step_beyond_all_floats_is_refused);
    RUN(an_aligned_grid_has_the_step_and_as_many_bits_as_the_box_needs);
    RUN(an_aligned_grid_may_be_far_from_zero_and_finer_than_floats);
    RUN(an_aligned_grid_needs_a_power_of_two_and_a_box_that_is_not_too_large);
    RUN(floats_that_are_none_are_an_error_with_a_place);
    RUN(half_a_step_off_the_grid_is_an_error);
    RUN(bad_arguments_of_the_quantiser_are_refused);
    RUN(what_comes_back_is_finite_whatever_the_channel_says);
    RUN(axes_come_back_exactly_and_length_does_not_matter);
    RUN(a_vector_without_a_direction_is_an_error);
    RUN(any_pair_is_a_unit_vector);
#if CQ_INDEX_BITS == 32
    RUN(exact_channels_copy_floats_whatever_they_are);
    RUN(exact_values_and_floats_have_the_types_that_they_are_read_as);
#endif
    return TEST_END();
}
