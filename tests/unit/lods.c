/* Levels of detail that are kept while decoding. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "sample.h"
#include "test.h"

enum { TORUS = -1, SEAMS = -2, CONNECTIVITY = 4 };   /* samples: 144 vertices on a grid of 12 bits, with seams; 240
                                                        without positions */

/* A stream that is decoded with budgets of `budget`; levels are kept into memory of exactly `capacity`. */
typedef struct chain {
    sample s;
    coded c;
    decoding d;
    cq_lod lod[4];
    size_t count, capacity, kept;
    cq_index *indices;
} chain;

/* A torus whose first 12 vertices have two rows each. */
static void seams_begin(sample *s)
{
    triangles t = triangles_torus(12, 12);
    uint32_t h;
    for (h = 0; h < 3 * t.num_faces; ++h)
        if (h / 3 % 2 && t.indices[h] < 12) t.indices[h] = (cq_index)(t.indices[h] + 144);
    t.num_vertices += 12;
    sample_begin(s, t);
    sample_channel(s, CQ_POSITION, 3, 12);
    sample_channel(s, CQ_TEXCOORD, 2, 12);
    memcpy(s->values[0] + 3 * 144, s->values[0], 3 * 12 * sizeof(cq_value));
}

static void chain_begin(chain *t, int which, size_t count, size_t capacity)
{
    size_t k;
    memset(t, 0, sizeof *t);
    if (which < 0) {
        if (which == SEAMS) {
            seams_begin(&t->s);
        } else {
            sample_begin(&t->s, triangles_torus(12, 12));
            sample_channel(&t->s, CQ_POSITION, 3, 12);
            t->s.input.conquest_only = 1; /* more levels, each with a smaller error */
        }
        code(&t->c, &t->s.input);
    } else {
        sample_code(&t->s, &t->c, which);
    }
    decoding_begin(&t->d, t->c.bytes, t->c.size);
    t->count = count;
    t->capacity = capacity;
    t->indices = (cq_index *)exact_alloc(capacity * sizeof(cq_index));
    for (k = 0; k < count; ++k) t->lod[k].max_error = CQ_NO_LIMIT;
}

static void chain_free(chain *t)
{
    exact_free(t->indices);
    decoding_free(&t->d);
    uncode(&t->c);
    sample_free(&t->s);
}

/* Indices of the decoder are those of level k. */
static int is_level(const chain *t, size_t k)
{
    const cq_decoder *d = t->d.decoder;
    const cq_lod *lod = &t->lod[k];
    return lod->num_vertices == d->num_rows && lod->num_faces == d->mesh.num_faces &&
           !memcmp(t->indices + lod->first, d->index, 3 * (size_t)d->mesh.num_faces * sizeof(cq_index));
}

/* Decodes all; each level is that of the moment when it is kept, and stays so. Returns the steps of the last call. */
static void chain_run(chain *t, uint32_t budget)
{
    cq_bytes in;
    cq_index *copy = (cq_index *)exact_alloc(t->capacity * sizeof(cq_index));
    size_t k, done = 0;
    in.data = t->c.bytes;
    in.size = t->c.size;
    do {
        t->d.result = cq_decode(t->d.decoder, &in, budget);
        t->kept = cq_keep_lods(t->d.decoder, t->lod, t->count, t->indices, t->capacity);
        CHECK(!memcmp(copy, t->indices, done * sizeof(cq_index)));
        for (k = 0; k < t->count; ++k) CHECK((t->lod[k].num_vertices != 0) == (k < t->kept));
        for (k = 0; k < t->kept; ++k)
            if (t->lod[k].first + 3 * (size_t)t->lod[k].num_faces > done) {
                CHECK(is_level(t, k));
                done = t->lod[k].first + 3 * (size_t)t->lod[k].num_faces;
            }
        memcpy(copy, t->indices, done * sizeof(cq_index));
    } while (t->d.result == CQ_MORE);
    CHECK_EQ(t->d.result, CQ_DONE);
    exact_free(copy);
}

static size_t all_corners(const chain *t) { return 3 * (size_t)t->s.mesh.num_faces; }

TEST(levels_by_vertices_have_as_many_if_steps_are_single_and_a_few_more_if_not)
{
    uint32_t budget;
    for (budget = 1; budget < 40; budget += 7) {
        chain t;
        size_t k;
        chain_begin(&t, TORUS, 4, 3 * 4 * 288);
        for (k = 0; k < 4; ++k) t.lod[k].min_vertices = (cq_index)(40 + 34 * k);
        chain_run(&t, budget);
        CHECK_EQ(t.kept, 4);
        for (k = 0; k < t.kept; ++k) {
            CHECK(t.lod[k].num_vertices >= t.lod[k].min_vertices);
            CHECK(t.lod[k].num_vertices < t.lod[k].min_vertices + budget);
            CHECK_EQ(t.lod[k].num_faces, 2 * t.lod[k].num_vertices);
        }
        chain_free(&t);
    }
}

/* Of the first level whose error is at most this, as the report tells. */
static cq_index vertices_at(const cq_report *r, uint32_t error)
{
    uint32_t k = 0;
    while (k < r->num_levels && r->level[k].error > error) ++k;
    return (cq_index)(k == 0 ? r->base_vertices : r->level[k - 1].num_vertices);
}

TEST(levels_by_error_are_the_first_that_tell_it)
{
    chain t;
    size_t k;
    chain_begin(&t, TORUS, 3, 3 * 3 * 288);
    REQUIRE(t.c.report->num_levels >= 6);
    for (k = 0; k < 3; ++k) t.lod[k].max_error = t.c.report->level[t.c.report->num_levels - 5 + 2 * k].error;
    chain_run(&t, 1);
    CHECK_EQ(t.kept, 3);
    for (k = 0; k < t.kept; ++k) {
        CHECK_EQ(t.lod[k].num_vertices, vertices_at(t.c.report, t.lod[k].max_error));
        CHECK(t.lod[k].error <= t.lod[k].max_error);
    }
    CHECK(t.lod[0].error > t.lod[2].error);
    chain_free(&t);
}

TEST(no_error_is_not_told_before_the_first_level)
{
    chain t;
    chain_begin(&t, TORUS, 1, 3 * 288);
    REQUIRE(t.c.report->level[t.c.report->num_levels - 1].error > 0);
    t.lod[0].max_error = 0;
    chain_run(&t, 1);
    CHECK_EQ(t.kept, 1);
    CHECK_EQ(t.lod[0].num_vertices, 144);
    CHECK_EQ(t.lod[0].error, 0);
    chain_free(&t);
}

TEST(without_errors_levels_come_by_vertices_or_when_all_is_there)
{
    chain t;
    chain_begin(&t, CONNECTIVITY, 3, 6 * 480);
    t.lod[0].min_vertices = 30;
    t.lod[1].min_vertices = 60;
    t.lod[2].max_error = 1000;
    chain_run(&t, 1);
    CHECK_EQ(t.kept, 3);
    CHECK_EQ(t.lod[0].num_vertices, 30);
    CHECK_EQ(t.lod[0].error, CQ_NO_LIMIT);
    CHECK_EQ(t.lod[2].num_vertices, 240);
    CHECK_EQ(t.lod[2].error, 0);
    chain_free(&t);
}

TEST(both_conditions_hold_and_levels_that_are_due_at_once_share_indices)
{
    chain t;
    chain_begin(&t, TORUS, 4, 3 * (200 + 288));
    t.lod[0].min_vertices = 100;
    t.lod[0].max_error = t.c.report->level[1].error;
    t.lod[1].min_vertices = 50;
    t.lod[2].min_vertices = 100;
    t.lod[3].max_error = 0;
    REQUIRE(vertices_at(t.c.report, t.lod[0].max_error) < 100);
    chain_run(&t, 1);
    CHECK_EQ(t.kept, 4);
    CHECK_EQ(t.lod[0].num_vertices, 100);
    CHECK_EQ(t.lod[1].first, 0);
    CHECK_EQ(t.lod[2].first, 0);
    CHECK_EQ(t.lod[2].num_vertices, 100);
    CHECK_EQ(t.lod[3].first, 3 * 200);
    chain_free(&t);
}

TEST(a_level_without_room_is_not_kept_nor_are_those_behind_it)
{
    static const size_t room[3] = {6 * 40 - 1, 6 * (40 + 80), 6 * (40 + 80 + 120) - 1};
    int k;
    for (k = 0; k < 3; ++k) {
        chain t;
        chain_begin(&t, TORUS, 3, room[k]);
        t.lod[0].min_vertices = 40;
        t.lod[1].min_vertices = 80;
        t.lod[2].min_vertices = 120;
        chain_run(&t, 1);
        CHECK_EQ(t.kept, k ? 2 : 0);
        chain_free(&t);
    }
}

TEST(levels_with_seams_have_indices_of_rows)
{
    chain t;
    size_t k, h;
    cq_index largest = 0;
    chain_begin(&t, SEAMS, 3, 3 * 3 * 288);
    REQUIRE_EQ(t.c.result, CQ_OK);
    for (k = 0; k < 3; ++k) t.lod[k].min_vertices = (cq_index)(50 + 53 * k);
    chain_run(&t, 1);
    CHECK_EQ(t.kept, 3);
    CHECK_EQ(t.d.decoder->mesh.num_vertices, 144);
    CHECK_EQ(t.lod[2].num_vertices, 156);
    for (k = 0; k < 3; ++k) {
        for (h = 0; h < 3 * (size_t)t.lod[k].num_faces; ++h)
            if (t.indices[t.lod[k].first + h] > largest) largest = t.indices[t.lod[k].first + h];
        CHECK_EQ(largest, t.lod[k].num_vertices - 1);
    }
    chain_free(&t);
}

TEST(levels_of_all_samples_are_kept)
{
    int which;
    for (which = 0; which < SAMPLES; ++which) {
        chain t;
        chain_begin(&t, which, 2, 0);
        exact_free(t.indices);
        t.capacity = 2 * all_corners(&t);
        t.indices = (cq_index *)exact_alloc(t.capacity * sizeof(cq_index));
        t.lod[1].max_error = 0;
        chain_run(&t, 1);
        CHECK_EQ(t.kept, 2);
        CHECK(t.lod[0].num_vertices > 0);
        CHECK_EQ(t.lod[0].num_vertices, t.c.report->base_vertices);
        CHECK_EQ(cq_keep_lods(t.d.decoder, NULL, 0, NULL, 0), 0);
        chain_free(&t);
    }
}

/* A sheet with three materials: each level has the faces of one material behind those of the other. In a plane, errors are
 * 0 at once. */
TEST(levels_have_their_faces_by_material)
{
    chain t;
    cq_index materials[2 * 11 * 9], of_material[2][3], m, first, count, sum;
    uint32_t f, v, k;
    size_t before = 0;
    cq_bytes in;
    memset(&t, 0, sizeof t);
    sample_begin(&t.s, triangles_sheet(12, 10));
    sample_channel(&t.s, CQ_POSITION, 3, 12);
    for (v = 0; v < 120; ++v) {
        t.s.values[0][3 * v] = (cq_value)(v % 12 * 300);
        t.s.values[0][3 * v + 1] = (cq_value)(v / 12 * 300);
        t.s.values[0][3 * v + 2] = 5;
    }
    for (f = 0; f < 2 * 11 * 9; ++f) materials[f] = (cq_index)(f % 22 / 8);
    t.s.input.shape.num_materials = 3;
    t.s.input.materials = materials;
    code(&t.c, &t.s.input);
    REQUIRE_EQ(t.c.result, CQ_OK);
    decoding_begin(&t.d, t.c.bytes, t.c.size);
    t.indices = (cq_index *)exact_alloc(2 * 3 * 198 * sizeof(cq_index));
    t.lod[0].min_vertices = 60;
    t.lod[1].min_vertices = 120;
    t.lod[0].max_error = t.lod[1].max_error = 0;
    t.lod[0].of_material = of_material[0];
    t.lod[1].of_material = of_material[1];
    in.data = t.c.bytes;
    in.size = t.c.size;
    do {
        t.d.result = cq_decode(t.d.decoder, &in, 1);
        t.kept = cq_keep_lods(t.d.decoder, t.lod, 2, t.indices, 2 * 3 * 198);
        if (t.kept == 1 && before == 0)
            for (m = sum = 0; m < 3; ++m) {
                cq_material(t.d.decoder, m, &first, &count);
                CHECK_EQ(of_material[0][m], count);
                CHECK(!memcmp(t.indices + 3 * sum, t.d.decoder->index + 3 * first, 3 * count * sizeof(cq_index)));
                sum = (cq_index)(sum + count);
            }
        before = t.kept;
    } while (t.d.result == CQ_MORE);
    CHECK_EQ(t.kept, 2);
    CHECK(t.lod[0].num_vertices >= 60 && t.lod[0].num_vertices < 120);
    for (k = 0; k < 2; ++k) CHECK_EQ(of_material[k][0] + of_material[k][1] + of_material[k][2], t.lod[k].num_faces);
    CHECK_EQ(of_material[1][0], 72);
    CHECK_EQ(of_material[1][1], 72);
    CHECK_EQ(of_material[1][2], 54);
    chain_free(&t);
}

TEST(nothing_is_a_level_of_nothing)
{
    cq_decoder d;
    cq_lod lod;
    cq_index index[3];
    uint32_t memory[1024];
    memset(&lod, 0, sizeof lod);
    lod.max_error = CQ_NO_LIMIT;
    CHECK_EQ(cq_decoder_init(&d, memory, sizeof memory), CQ_OK);
    CHECK_EQ(cq_keep_lods(&d, &lod, 1, index, 3), 0);
    CHECK_EQ(lod.num_vertices, 0);
}

TEST(a_mesh_without_vertices_has_no_level)
{
    sample s;
    coded c;
    decoding d;
    cq_lod lod;
    cq_index index[3];
    memset(&lod, 0, sizeof lod);
    lod.max_error = CQ_NO_LIMIT;
    sample_begin(&s, triangles_none());
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, 1), CQ_DONE);
    CHECK_EQ(cq_keep_lods(d.decoder, &lod, 1, index, 3), 0);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(levels_by_vertices_have_as_many_if_steps_are_single_and_a_few_more_if_not);
    RUN(levels_by_error_are_the_first_that_tell_it);
    RUN(no_error_is_not_told_before_the_first_level);
    RUN(without_errors_levels_come_by_vertices_or_when_all_is_there);
    RUN(both_conditions_hold_and_levels_that_are_due_at_once_share_indices);
    RUN(a_level_without_room_is_not_kept_nor_are_those_behind_it);
    RUN(levels_with_seams_have_indices_of_rows);
    RUN(levels_of_all_samples_are_kept);
    RUN(levels_have_their_faces_by_material);
    RUN(nothing_is_a_level_of_nothing);
    RUN(a_mesh_without_vertices_has_no_level);
    return TEST_END();
}
