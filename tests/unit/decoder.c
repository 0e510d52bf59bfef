/* The decoder: input in pieces, budgets, every truncation, damage, memory, sticky results, reports. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "header.h"
#include "sample.h"
#include "test.h"

/* -- Helpers ------------------------------------------------------------------------------------------------------- */

/* A number that stands for the mesh and the values of this moment, real and virtual. */
static uint64_t fingerprint(const cq_decoder *d)
{
    const cq_mesh *m = &d->mesh;
    uint64_t hash = 0xcbf29ce484222325u;
    uint32_t k, j, faces[2], first[2];
    first[0] = 0, faces[0] = m->num_faces;
    first[1] = m->first_virtual_face, faces[1] = m->num_virtual_faces;
    hash = (hash ^ m->num_vertices) * 0x100000001b3u;
    for (k = 0; k < 2; ++k) {
        for (j = 3 * first[k]; j < 3 * (first[k] + faces[k]); ++j) {
            hash = (hash ^ m->origin[j]) * 0x100000001b3u;
            hash = (hash ^ m->twin[j]) * 0x100000001b3u;
        }
    }
    for (k = 0; k < d->shape.num_channels; ++k)
        for (j = 0; j < num_shown(d, k); ++j)
            hash = (hash ^ (uint64_t)d->channel[k][j]) * 0x100000001b3u;
    return hash;
}

static int values_in_range(const cq_decoder *d)
{
    uint32_t k, j;
    for (k = 0; k < d->shape.num_channels; ++k)
        for (j = 0; j < num_shown(d, k); ++j)
            if (!value_is_in_range(&d->shape.channel[k], d->channel[k][j])) return 0;
    return 1;
}

/* The fingerprints of all meshes that a full decoding goes through, by number of vertices. */
typedef struct history {
    uint64_t *mesh;        /* uint64_t[num_steps]: after each step */
    uint32_t num_steps;
    uint32_t num_vertices;
} history;

static history history_take(const uint8_t *bytes, size_t size)
{
    history h;
    decoding d;
    cq_bytes in;
    cq_result result;
    h.mesh = NULL;
    h.num_vertices = h.num_steps = 0;
    decoding_begin(&d, bytes, size);
    in.data = bytes;
    in.size = size;
    do {
        result = cq_decode(d.decoder, &in, 1);
        h.num_vertices = d.decoder->shape.num_vertices;
        if (h.num_steps % 256 == 0) h.mesh = (uint64_t *)realloc(h.mesh, (h.num_steps + 256) * sizeof *h.mesh);
        CHECK(d.decoder->mesh.num_vertices <= h.num_vertices);
        h.mesh[h.num_steps++] = fingerprint(d.decoder);
    } while (result == CQ_MORE);
    CHECK_EQ(result, CQ_DONE);
    decoding_free(&d);
    return h;
}

static int history_has(const history *h, const cq_decoder *d)
{
    const uint64_t wanted = fingerprint(d);
    uint32_t k;
    for (k = h->num_steps; k-- && h->mesh[k] != wanted;) {}
    return k != UINT32_MAX;
}

#define FOR_EACH_SAMPLE(s, c) \
    sample s; coded c; int which_##s; \
    for (which_##s = 0; which_##s < SAMPLES; ++which_##s, uncode(&c), sample_free(&s)) \
        if (sample_code(&s, &c, which_##s) != CQ_OK) test_fail(__FILE__, __LINE__, "the sample encodes"); else

/* -- Whole streams ------------------------------------------------------------------------------------------------- */

/* Faces through the map, each turned to start at its smallest vertex, sorted: a set that can be compared. */
static int compare_faces(const void *a, const void *b)
{
    return memcmp(a, b, 3 * sizeof(uint32_t));
}

static uint32_t *face_set(const cq_index *indices, uint32_t num_faces, const cq_index *map)
{
    uint32_t *set = (uint32_t *)malloc((3 * (size_t)num_faces + 1) * sizeof *set), f, k;
    for (f = 0; f < num_faces; ++f) {
        uint32_t v[3], least;
        for (k = 0; k < 3; ++k) v[k] = map != NULL ? map[indices[3 * f + k]] : indices[3 * f + k];
        least = v[0] < v[1] ? (v[0] < v[2] ? 0 : 2) : (v[1] < v[2] ? 1 : 2);
        for (k = 0; k < 3; ++k) set[3 * f + k] = v[(least + k) % 3];
    }
    qsort(set, num_faces, 3 * sizeof *set, compare_faces);
    return set;
}

static int same_mesh(const sample *s, const coded *c, const cq_decoder *d)
{
    uint32_t n = s->mesh.num_faces, k, v, j;
    uint32_t *a, *b;
    int same;
    if (d->mesh.num_vertices != s->mesh.num_vertices || d->mesh.num_faces != n) return 0;
    a = face_set(s->mesh.indices, n, c->map);
    b = face_set(d->mesh.origin, n, NULL);
    same = memcmp(a, b, 3 * (size_t)n * sizeof *a) == 0;
    free(a);
    free(b);
    for (k = 0; k < d->shape.num_channels; ++k) {
        const cq_channel *channel = &d->shape.channel[k];
        const cq_index *map = is_per_face(channel) ? c->face_map : c->map;
        uint32_t components = channel->components;
        for (v = 0; v < num_owners(channel, s->mesh.num_vertices, n); ++v)
            for (j = 0; j < components; ++j)
                if (d->channel[k][map[v] * components + j] != s->values[k][v * components + j]) same = 0;
    }
    return same;
}

/* Encodes the sample, decodes it in pieces of `chunk` bytes and single steps, and compares. */
static void check_round_trip(sample *s, size_t chunk)
{
    coded c;
    decoding d;
    code(&c, &s->input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, chunk, 1), CQ_DONE);
    CHECK(same_mesh(s, &c, d.decoder));
    decoding_free(&d);
    uncode(&c);
}

TEST(a_stream_gives_back_the_mesh_and_the_values)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_feed(&d, c.bytes, c.size, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(d.used, c.size);
        CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
        CHECK(same_mesh(&s, &c, d.decoder));
        decoding_free(&d);
    }
}

#if CQ_INDEX_BITS == 32

/* Without channels, with a first channel of faces, of which there are fewer than vertices, and with positions. */
static void check_large_mesh(triangles mesh, int channels)
{
    sample s;
    sample_begin(&s, mesh);
    if (channels == 2) sample_merged(&s, CQ_GROUP, CQ_PER_FACE, 1, 5);
    if (channels > 0) sample_channel(&s, CQ_POSITION, 3, 12);
    check_round_trip(&s, 1000);
    sample_free(&s);
}

TEST(large_meshes_come_back)
{
    triangles t = triangles_sheet(30, 30), singles;
    cq_index k;
    singles.num_faces = 10800;
    singles.num_vertices = 3 * singles.num_faces;
    singles.indices = (cq_index *)exact_alloc(singles.num_vertices * sizeof(cq_index));
    for (k = 0; k < singles.num_vertices; ++k) singles.indices[k] = k;
    triangles_append(&t, singles);
    check_large_mesh(t, 2);
    check_large_mesh(triangles_torus(182, 182), 0);
    check_large_mesh(triangles_sheet(182, 182), 1);
}

#endif

/* One channel on a torus of 240 vertices and 480 faces: bits that it takes, for a vertex or face. */
static double cost_of_channel(cq_kind kind, cq_merge merge, int components, int bits, cq_value (*value)(uint32_t))
{
    sample s;
    coded c;
    decoding d;
    uint32_t j, n;
    double cost;
    sample_begin(&s, triangles_torus(16, 15));
    sample_merged(&s, kind, merge, components, bits);
    n = num_owners(&s.input.shape.channel[0], s.mesh.num_vertices, s.mesh.num_faces);
    for (j = 0; j < n * (uint32_t)components; ++j) s.values[0][j] = value(j);
    code(&c, &s.input);
    CHECK_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
    CHECK(same_mesh(&s, &c, d.decoder));
    cost = (double)(c.report->channels + c.report->positions) / 65536 / n;
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
    return cost;
}

static cq_value always_the_same(uint32_t j) { return j < CQ_NO_LIMIT ? 77 : 0; }
static cq_value one_of_two(uint32_t j) { return (cq_value)(j < 200); }
static cq_value one_of_four(uint32_t j) { return (cq_value)(j / 64 % 4 * 50); }

TEST(what_is_alike_costs_little)
{
    CHECK(cost_of_channel(CQ_GROUP, CQ_PER_FACE, 1, 15, always_the_same) < 0.12);
    CHECK(cost_of_channel(CQ_GROUP, CQ_PER_FACE, 1, 8, one_of_two) < 0.6);
    CHECK(cost_of_channel(CQ_JOINTS, CQ_COPY, 4, 8, always_the_same) < 0.9);
    CHECK(cost_of_channel(CQ_GENERIC, CQ_COPY, 1, 8, one_of_four) < 6);
}

#if CQ_INDEX_BITS == 32

/* Exact positions say nothing about connectivity, which costs what it costs alone. */
TEST(exact_positions_leave_connectivity_as_it_is_without)
{
    sample bare, exact;
    coded a, b;
    sample_begin(&bare, triangles_torus(16, 15));
    sample_begin(&exact, triangles_torus(16, 15));
    sample_channel(&bare, CQ_GENERIC, 1, 1); /* so that neither has regular levels */
    sample_merged(&exact, CQ_POSITION, CQ_AVERAGE, 3, SAMPLE_EXACT_BITS);
    sample_channel(&exact, CQ_GENERIC, 1, 1);
    code(&a, &bare.input);
    code(&b, &exact.input);
    REQUIRE(a.result == CQ_OK && b.result == CQ_OK);
    CHECK(a.report->indices / 65536 == b.report->indices / 65536);
    CHECK(b.report->positions > 0);
    uncode(&a);
    uncode(&b);
    sample_free(&bare);
    sample_free(&exact);
}

/* Every pair of odd patterns on neighbours: differences are as large as they can be. */
TEST(exact_values_are_any_patterns)
{
    static const uint32_t odd[] = {0, 1, 0x7fffffffu, 0x80000000u, 0x80000001u, 0xffffffffu, 0x7f800000u, 0xff800000u,
                                   0x7fc00000u, 0x7f800001u, 0xffc0dead, 0x3f800000u, 0xbf800000u, 0x00800000u};
    uint64_t random = 5;
    int round;
    for (round = 0; round < 50; ++round) {
        sample s;
        uint32_t k, j;
        sample_begin(&s, round % 2 ? triangles_torus(6, 7) : triangles_disc(40));
        sample_merged(&s, CQ_GENERIC, CQ_AVERAGE, 4, CQ_EXACT_BITS);
        sample_merged(&s, CQ_GENERIC, CQ_COPY, 4, CQ_EXACT_BITS);
        sample_merged(&s, CQ_GENERIC, CQ_PER_FACE, 1, CQ_EXACT_BITS);
        for (k = 0; k < 2; ++k)
            for (j = 0; j < 4 * s.mesh.num_vertices; ++j) s.values[k][j] = (cq_value)odd[next_random(&random) % 14];
        for (j = 0; j < s.mesh.num_faces; ++j) s.values[2][j] = (cq_value)odd[next_random(&random) % 14];
        check_round_trip(&s, 1);
        sample_free(&s);
    }
}
#endif

/* Around vertices of 100 neighbours, and of two, sums of them are as large as they can be. */
TEST(values_at_their_limits_come_back)
{
    uint64_t random = 7;
    int round;
    for (round = 0; round < 60; ++round) {
        sample s;
        uint32_t k, j;
        const cq_value top = (cq_value)(((int32_t)1 << CQ_MAX_BITS) - 1);
        sample_begin(&s, round % 3 == 0 ? triangles_torus(6, 7) : round % 3 == 1 ? triangles_bipyramid(100)
                                                                                 : triangles_sheet(9, 9));
        sample_channel(&s, CQ_POSITION, 3, CQ_MAX_BITS);
        sample_channel(&s, CQ_GENERIC, 4, CQ_MAX_BITS);
        sample_merged(&s, CQ_GENERIC, CQ_COPY, 2, CQ_MAX_BITS);
        sample_channel(&s, CQ_NUMBER, 1, 12);
        for (k = 0; k < s.mesh.num_vertices; ++k) s.values[3][k] = (cq_value)k; /* so that no two are in one place */
        for (k = 0; k < 3; ++k) {
            const uint32_t n = s.mesh.num_vertices * s.input.shape.channel[k].components;
            for (j = 0; j < n; ++j) s.values[k][j] = (cq_value)(next_random(&random) % 2 ? top : 0);
        }
        s.input.goal = (cq_goal)(round / 3 % 2);
        check_round_trip(&s, 1);
        sample_free(&s);
    }
}

TEST(odd_numbers_of_everything_fit_the_memory_exactly)
{
    /* 5, 7 and 9 vertices with up to eight channels of 1, 3, 1, 3 ... components: parts of the memory end anywhere. */
    int parts, channels, k;
    for (parts = 3; parts < 6; ++parts) {
        for (channels = 0; channels <= CQ_MAX_CHANNELS; ++channels) {
            sample s;
            triangles t = triangles_bipyramid((uint32_t)parts);
            if (parts == 4) triangles_append(&t, triangles_single());
            sample_begin(&s, t);
            for (k = 0; k < channels; ++k) sample_channel(&s, k == 1 ? CQ_POSITION : CQ_GENERIC, k % 2 == 0 ? 1 : 3, 7);
            check_round_trip(&s, 3);
            sample_free(&s);
        }
    }
}

TEST(a_decoder_has_no_gaps_in_vertices_and_faces)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        do {
            const cq_mesh *m = &d.decoder->mesh;
            uint32_t x;
            result = cq_decode(d.decoder, &in, 7);
            for (x = 0; x < m->num_vertices; ++x) CHECK(m->out[x] != CQ_NONE);
            for (x = 0; x < m->num_faces; ++x) CHECK(m->origin[3 * x] != CQ_NONE);
            for (x = 0; x < 3 * (uint32_t)m->num_faces; ++x) CHECK(m->origin[x] < m->num_vertices);
        } while (result == CQ_MORE);
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(any_size_of_pieces_gives_the_same_mesh)
{
    static const size_t chunks[] = {1, 2, 3, 7, 16, 61, 255, 256, 257, 4096};
    FOR_EACH_SAMPLE(s, c) {
        history h = history_take(c.bytes, c.size);
        size_t k;
        for (k = 0; k < sizeof chunks / sizeof chunks[0]; ++k) {
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, chunks[k], CQ_NO_LIMIT), CQ_DONE);
            CHECK_EQ(d.used, c.size);
            CHECK_EQ(fingerprint(d.decoder), h.mesh[h.num_steps - 1]);
            decoding_free(&d);
        }
        free(h.mesh);
    }
}

TEST(pieces_of_no_bytes_only_ask_for_more)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes none;
        size_t k;
        cq_result result = CQ_NEED_INPUT;
        none.data = NULL;
        none.size = 0;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(cq_decode(d.decoder, &none, CQ_NO_LIMIT), CQ_NEED_INPUT);
        for (k = 0; k < c.size; ++k) {
            CHECK_EQ(result, CQ_NEED_INPUT);
            result = decoding_feed(&d, c.bytes + k, 1, CQ_NO_LIMIT);
            CHECK_EQ(cq_decode(d.decoder, &none, CQ_NO_LIMIT), k + 1 == c.size ? CQ_DONE : CQ_NEED_INPUT);
            CHECK_EQ(d.decoder->num_rows, d.decoder->mesh.num_vertices);
        }
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(any_budget_gives_the_same_mesh)
{
    static const uint32_t budgets[] = {1, 2, 5, 64, 1000000};
    FOR_EACH_SAMPLE(s, c) {
        history h = history_take(c.bytes, c.size);
        size_t k;
        for (k = 0; k < sizeof budgets / sizeof budgets[0]; ++k) {
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, 13, budgets[k]), CQ_DONE);
            CHECK_EQ(fingerprint(d.decoder), h.mesh[h.num_steps - 1]);
            decoding_free(&d);
        }
        free(h.mesh);
    }
}

TEST(a_budget_of_one_makes_at_most_one_split_and_leaves_a_valid_mesh)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result;
        uint32_t before = 0, level = 0, calls = 0;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        do {
            uint32_t now;
            result = cq_decode(d.decoder, &in, 1);
            now = d.decoder->mesh.num_vertices;
            CHECK(result == CQ_MORE || result == CQ_DONE);
            CHECK(level == 0 || now == before || now == before + 1);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(values_in_range(d.decoder));
            before = now;
            level = d.decoder->level;
            calls++;
        } while (result == CQ_MORE && calls < 100000);
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(a_budget_of_n_does_the_work_of_n_budgets_of_one)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding one, many;
        cq_bytes in_one, in_many;
        cq_result a, b = CQ_MORE;
        int k;
        decoding_begin(&one, c.bytes, c.size);
        decoding_begin(&many, c.bytes, c.size);
        in_one.data = in_many.data = c.bytes;
        in_one.size = in_many.size = c.size;
        do {
            a = cq_decode(many.decoder, &in_many, 10);
            for (k = 0; k < 10 && b == CQ_MORE; ++k) b = cq_decode(one.decoder, &in_one, 1);
            CHECK_EQ(many.decoder->mesh.num_vertices, one.decoder->mesh.num_vertices);
            CHECK_EQ(fingerprint(many.decoder), fingerprint(one.decoder));
        } while (a == CQ_MORE && b == CQ_MORE);
        CHECK(a == CQ_DONE);
        while (b == CQ_MORE) b = cq_decode(one.decoder, &in_one, 1);
        CHECK(b == CQ_DONE);
        decoding_free(&one);
        decoding_free(&many);
    }
}

/* So that a frame or an interrupt bounds a base of many components too. */
TEST(a_budget_counts_the_faces_and_vertices_of_the_base)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result = CQ_MORE;
        uint32_t calls = 0;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        for (; result == CQ_MORE && d.decoder->level == 0; calls++) result = cq_decode(d.decoder, &in, 1);
        CHECK(calls > c.report->base_vertices + c.report->base_faces);
        decoding_free(&d);
    }
}

TEST(a_budget_of_none_changes_nothing_once_the_mesh_is_there)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        do {
            uint64_t before;
            result = cq_decode(d.decoder, &in, 3);
            if (result != CQ_MORE) break;
            before = fingerprint(d.decoder);
            CHECK_EQ(cq_decode(d.decoder, &in, 0), CQ_MORE);
            CHECK_EQ(fingerprint(d.decoder), before);
        } while (1);
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(bytes_behind_the_end_of_a_stream_are_not_used)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t extra;
        for (extra = 1; extra < 2000; extra = extra * 5 + 1) {
            uint8_t *longer = (uint8_t *)exact_alloc(c.size + extra);
            decoding d;
            cq_bytes in;
            memcpy(longer, c.bytes, c.size);
            decoding_begin(&d, longer, c.size + extra);
            in.data = longer;
            in.size = c.size + extra;
            CHECK_EQ(cq_decode(d.decoder, &in, CQ_NO_LIMIT), CQ_DONE);
            CHECK_EQ(in.size, extra);
            CHECK(in.data == longer + c.size);
            CHECK_EQ(cq_decode(d.decoder, &in, CQ_NO_LIMIT), CQ_DONE);
            CHECK_EQ(in.size, extra);
            exact_free(longer);
            decoding_free(&d);
        }
    }
}

/* -- Truncation ---------------------------------------------------------------------------------------------------- */

TEST(every_truncation_is_a_mesh_on_the_way_to_the_full_one)
{
    FOR_EACH_SAMPLE(s, c) {
        history h = history_take(c.bytes, c.size);
        size_t size;
        uint32_t before = 0;
        for (size = 0; size < c.size; ++size) {
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            CHECK_EQ(decoding_run(&d, c.bytes, size, size > 0 ? size : 1, CQ_NO_LIMIT), CQ_TRUNCATED);
            CHECK_EQ(d.used, size);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(d.decoder->mesh.num_vertices >= before);
            CHECK(d.decoder->mesh.num_vertices == 0 || history_has(&h, d.decoder));
            before = d.decoder->mesh.num_vertices;
            decoding_free(&d);
        }
        CHECK(2 * before > h.num_vertices || before == 0 || c.report->level[c.report->num_levels - 1].regular);
        free(h.mesh);
    }
}

TEST(a_truncation_gives_the_same_mesh_whatever_the_pieces_and_budgets)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t size;
        for (size = 0; size < c.size; size += 1 + c.size / 40) {
            decoding a, b;
            decoding_begin(&a, c.bytes, c.size);
            decoding_begin(&b, c.bytes, c.size);
            CHECK_EQ(decoding_run(&a, c.bytes, size, 1000000, CQ_NO_LIMIT), CQ_TRUNCATED);
            CHECK_EQ(decoding_run(&b, c.bytes, size, 1, 1), CQ_TRUNCATED);
            CHECK_EQ(a.decoder->mesh.num_vertices, b.decoder->mesh.num_vertices);
            if (a.decoder->mesh.num_vertices > 0) CHECK_EQ(fingerprint(a.decoder), fingerprint(b.decoder));
            decoding_free(&a);
            decoding_free(&b);
        }
    }
}

TEST(the_base_arrives_component_by_component)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result = CQ_MORE;
        uint32_t vertices = 0, faces = 0, components = 0;
        cq_index *seen = (cq_index *)exact_alloc(3 * (size_t)s.mesh.num_faces * sizeof(cq_index));
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        while (result == CQ_MORE && d.decoder->level == 0) {
            const cq_mesh *m = &d.decoder->mesh;
            result = cq_decode(d.decoder, &in, 1);
            if (vertices) CHECK(!memcmp(seen, m->origin, 3 * (size_t)faces * sizeof(cq_index)));
            if (m->num_vertices == vertices) continue;
            CHECK(m->num_vertices >= vertices + 3 && m->num_faces > faces);
            CHECK_EQ(cq_mesh_check(m, NULL), CQ_OK);
            vertices = m->num_vertices;
            faces = m->num_faces;
            memcpy(seen, m->origin, 3 * (size_t)faces * sizeof(cq_index));
            components++;
            CHECK_EQ(d.decoder->num_components, components);
        }
        CHECK_EQ(vertices, c.report->base_vertices);
        CHECK_EQ(components, c.report->num_components);
        exact_free(seen);
        decoding_free(&d);
    }
}

/* Leaves of a tree: each with its own size, its own normals and the same texture. */
enum { LEAVES = 200 };

static void leaves(sample *s, triangles *t, cq_value *position)
{
    static const int quad[6] = {0, 1, 2, 0, 2, 3}, x[4] = {0, 1, 1, 0}, y[4] = {0, 0, 1, 1};
    uint32_t n, k;
    *t = triangles_none();
    for (n = 0; n < LEAVES; n++) {
        const int32_t size = 20 + (int32_t)(n * 37 % LEAVES);
        triangles_append(t, triangles_of(4, 2, quad));
        for (k = 0; k < 4; k++) {
            cq_value *p = position + 3 * (4 * n + k);
            p[0] = (cq_value)(n * 911 % 16000 + (uint32_t)(size * x[k]));
            p[1] = (cq_value)(n * 577 % 16000 + (uint32_t)(size * y[k]));
            p[2] = (cq_value)(n * 193 % 16000 + (uint32_t)(size * (x[k] + y[k]) / 3));
        }
    }
    memset(s, 0, sizeof *s);
    s->input.shape.num_vertices = t->num_vertices;
    s->input.shape.num_faces = t->num_faces;
    s->input.shape.num_channels = 1;
    s->input.shape.channel[0].components = 3;
    s->input.shape.channel[0].bits = 14;
    s->input.indices = t->indices;
    s->input.values[0] = position;
}

/* The first three vertices of a leaf are there; of its corners any three are as wide as all. */
static int32_t width_of(const cq_value *p)
{
    const int32_t a = abs(p[0] - p[3]), b = abs(p[0] - p[6]);
    return a > b ? a : b;
}

TEST(leaves_are_drawn_one_by_one_the_largest_first)
{
    static cq_value position[3 * 4 * LEAVES];
    sample s;
    triangles t;
    coded c;
    decoding d;
    cq_bytes in;
    cq_result result = CQ_MORE;
    int32_t before = INT32_MAX;
    uint32_t drawn = 0;
    leaves(&s, &t, position);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    while (result == CQ_MORE && d.decoder->level == 0) {
        const cq_mesh *m = &d.decoder->mesh;
        int32_t width;
        result = cq_decode(d.decoder, &in, 1);
        if (m->num_vertices == drawn) continue;
        REQUIRE_EQ(m->num_vertices, drawn + 3);
        width = width_of(d.decoder->channel[0] + 3 * drawn);
        CHECK(width <= before);
        before = width;
        drawn = m->num_vertices;
    }
    CHECK_EQ(drawn, 3 * LEAVES);
    decoding_free(&d);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, 100, 100, CQ_NO_LIMIT), CQ_TRUNCATED);
    CHECK(d.decoder->mesh.num_faces > 0);
    CHECK(c.size > 24 * 100); /* of which these were a small part */
    decoding_free(&d);
    uncode(&c);
    triangles_free(&t);
}

TEST(truncated_is_final)
{
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    uint64_t before;
    REQUIRE_EQ(sample_code(&s, &c, 2), CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size / 2, c.size, CQ_NO_LIMIT), CQ_TRUNCATED);
    CHECK(d.decoder->mesh.num_vertices > 0);
    before = fingerprint(d.decoder);
    in.data = c.bytes + c.size / 2;
    in.size = c.size - c.size / 2;
    CHECK_EQ(cq_decode(d.decoder, &in, CQ_NO_LIMIT), CQ_TRUNCATED);
    CHECK_EQ(in.size, c.size - c.size / 2);
    CHECK_EQ(cq_decode(d.decoder, NULL, CQ_NO_LIMIT), CQ_TRUNCATED);
    CHECK_EQ(fingerprint(d.decoder), before);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

TEST(the_end_of_the_input_after_all_of_the_stream_is_no_truncation)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_feed(&d, c.bytes, c.size, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(decoding_end(&d, CQ_NO_LIMIT), CQ_DONE);
        decoding_free(&d);
    }
}

TEST(no_input_at_all_is_truncated)
{
    decoding d;
    decoding_begin_with(&d, 100);
    CHECK_EQ(decoding_end(&d, CQ_NO_LIMIT), CQ_TRUNCATED);
    CHECK_EQ(d.decoder->mesh.num_vertices, 0);
    decoding_free(&d);
}

/* -- Damage -------------------------------------------------------------------------------------------------------- */

TEST(no_flipped_bit_gives_a_complete_mesh)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t bit, step = c.size > 300 ? 7 : 1;
        for (bit = 0; bit < 8 * c.size; bit += step) {
            decoding d;
            cq_result result;
            c.bytes[bit / 8] = (uint8_t)(c.bytes[bit / 8] ^ 1 << bit % 8);
            decoding_begin(&d, c.bytes, c.size);
            result = decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT);
            CHECK(result < 0 || result == CQ_TRUNCATED);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(values_in_range(d.decoder));
            decoding_free(&d);
            c.bytes[bit / 8] = (uint8_t)(c.bytes[bit / 8] ^ 1 << bit % 8);
        }
    }
}

TEST(a_missing_byte_in_the_middle_is_found)
{
    FOR_EACH_SAMPLE(s, c) {
        size_t gone;
        for (gone = 0; gone < c.size; gone += 1 + c.size / 100) {
            uint8_t *bytes = (uint8_t *)exact_copy(c.bytes, c.size - 1);
            decoding d;
            cq_result result;
            memcpy(bytes + gone, c.bytes + gone + 1, c.size - 1 - gone);
            decoding_begin(&d, bytes, c.size - 1);
            result = decoding_run(&d, bytes, c.size - 1, c.size, CQ_NO_LIMIT);
            CHECK(result < 0 || result == CQ_TRUNCATED);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            exact_free(bytes);
            decoding_free(&d);
        }
    }
}

TEST(an_error_is_final_and_uses_no_more_input)
{
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    cq_result error;
    REQUIRE_EQ(sample_code(&s, &c, 3), CQ_OK);
    c.bytes[c.size - 1] ^= 1;
    decoding_begin(&d, c.bytes, c.size);
    error = decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT);
    CHECK(error < 0);
    c.bytes[c.size - 1] ^= 1;
    in.data = c.bytes;
    in.size = c.size;
    CHECK_EQ(cq_decode(d.decoder, &in, CQ_NO_LIMIT), error);
    CHECK_EQ(cq_decode(d.decoder, &in, 1), error);
    CHECK_EQ(cq_decode(d.decoder, NULL, 1), error);
    CHECK_EQ(in.size, c.size);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

TEST(a_wrong_magic_a_wrong_version_and_a_wrong_check_value_are_told_apart)
{
    sample s;
    coded c;
    cq_shape shape;
    size_t header_bytes = 0, k;
    static const cq_result expected[] = {CQ_ERROR_FORMAT, CQ_ERROR_FORMAT, CQ_ERROR_VERSION, CQ_ERROR_CHECKSUM};
    REQUIRE_EQ(sample_code(&s, &c, 1), CQ_OK);
    REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
    for (k = 0; k < 4; ++k) {
        size_t at = k < 3 ? k : header_bytes - 1;
        decoding d;
        c.bytes[at] ^= 0x40;
        decoding_begin_with(&d, 100000);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, CQ_NO_LIMIT), expected[k]);
        CHECK_EQ(d.decoder->mesh.num_vertices, 0);
        CHECK(d.used <= header_bytes);
        decoding_free(&d);
        c.bytes[at] ^= 0x40;
    }
    uncode(&c);
    sample_free(&s);
}

TEST(a_wrong_check_value_of_the_payload_is_found_at_the_end)
{
    FOR_EACH_SAMPLE(s, c) {
        cq_shape shape;
        size_t header_bytes = 0;
        decoding d;
        CHECK_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
        if (c.size == header_bytes) continue;
        c.bytes[c.size - 1] ^= 0x80;
        decoding_begin(&d, c.bytes, c.size);
        CHECK(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT) < 0);
        decoding_free(&d);
        c.bytes[c.size - 1] ^= 0x80;
    }
}

/* The header of a stream with other numbers of vertices and faces, whose payload is the same. */
static void rewrite_header(header *h, const coded *c, size_t header_bytes, const cq_shape *old, const cq_shape *shape)
{
    const int32_t all_faces = (int32_t)(shape->num_faces + shape->num_boundary_edges);
    const int32_t euler = (2 * (int32_t)(shape->num_vertices + shape->num_boundary_loops) - all_faces) / 4;
    size_t start;
    put_start(h, old->num_vertices, old->num_boundary_loops, old->num_boundary_edges, euler);
    start = h->size;
    put_start(h, shape->num_vertices, shape->num_boundary_loops, shape->num_boundary_edges, euler);
    memcpy(h->bytes + h->size, c->bytes + start, header_bytes - 2 - start);
    h->size += header_bytes - 2 - start;
    put(h, crc32(h->bytes, h->size), 2);
}

/* The same bytes behind the header of a mesh that has fewer vertices, and faces. */
TEST(a_stream_with_more_splits_than_its_header_has_vertices_for_is_an_error)
{
    int tried = 0;
    FOR_EACH_SAMPLE(s, c) {
        cq_shape shape;
        size_t header_bytes = 0, size;
        uint32_t less;
        REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
        for (less = 1; c.report->base_vertices + less <= s.mesh.num_vertices; less = less * 2 + 1) {
            uint8_t *bytes = (uint8_t *)exact_alloc(CQ_MAX_HEADER_BYTES + c.size);
            const size_t payload = c.size - header_bytes;
            size_t cut;
            cq_shape smaller = shape;
            header h;
            decoding d;
            smaller.num_vertices -= less;
            smaller.num_faces -= 2 * less;
            rewrite_header(&h, &c, header_bytes, &shape, &smaller);
            size = h.size;
            memcpy(bytes, h.bytes, size);
            memcpy(bytes + size, c.bytes + header_bytes, payload);
            decoding_begin(&d, bytes, size + payload);
            CHECK(decoding_run(&d, bytes, size + payload, size + payload, CQ_NO_LIMIT) < 0);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(d.decoder->mesh.num_vertices <= smaller.num_vertices);
            CHECK(values_in_range(d.decoder));
            decoding_free(&d);
            for (cut = 1; cut < payload; cut += 1 + payload / 60) {
                decoding_begin(&d, bytes, size + payload);
                CHECK(decoding_run(&d, bytes, size + payload - cut, size + payload, CQ_NO_LIMIT) != CQ_DONE);
                CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                decoding_free(&d);
            }
            exact_free(bytes);
            tried++;
        }
    }
    CHECK(tried > 20);
}

TEST(noise_behind_a_good_header_gives_an_error_or_a_valid_mesh)
{
    uint64_t random = 11;
    FOR_EACH_SAMPLE(s, c) {
        cq_shape shape;
        size_t header_bytes = 0, k;
        int round;
        CHECK_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
        for (round = 0; round < 30; ++round) {
            decoding d;
            for (k = header_bytes; k < c.size; ++k)
                c.bytes[k] = round < 2 ? (uint8_t)(-round) : (uint8_t)next_random(&random);
            decoding_begin(&d, c.bytes, c.size);
            CHECK(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT) != CQ_DONE);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(values_in_range(d.decoder));
            decoding_free(&d);
        }
    }
}

/* -- Memory and arguments ------------------------------------------------------------------------------------------ */

TEST(memory_that_is_one_byte_short_is_an_error_before_any_work)
{
    FOR_EACH_SAMPLE(s, c) {
        cq_shape shape;
        size_t size, less;
        REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, NULL, NULL), CQ_OK);
        size = cq_decoder_bytes(&shape);
        for (less = 1; less <= size; less = less * 2 + 1) {
            decoding d;
            decoding_begin_with(&d, size - less);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_ERROR_MEMORY);
            CHECK_EQ(d.decoder->mesh.num_vertices, 0);
            CHECK_EQ(d.decoder->shape.num_vertices, s.mesh.num_vertices);   /* tells what is needed */
            CHECK_EQ(cq_decoder_bytes(&d.decoder->shape), size);
            decoding_free(&d);
        }
    }
}

TEST(misaligned_memory_is_an_error_of_the_decoder)
{
    sample s;
    coded c;
    cq_shape shape;
    size_t size, shift;
    REQUIRE_EQ(sample_code(&s, &c, 1), CQ_OK);
    REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, NULL, NULL), CQ_OK);
    size = cq_decoder_bytes(&shape);
    for (shift = 1; shift < 4; ++shift) {
        uint8_t *memory = (uint8_t *)exact_alloc(size + 4);
        cq_decoder *d = (cq_decoder *)exact_alloc(sizeof *d);
        cq_bytes in;
        cq_result result = cq_decoder_init(d, memory + shift, size);
        in.data = c.bytes;
        in.size = c.size;
        if (result == CQ_OK) result = cq_decode(d, &in, CQ_NO_LIMIT);
        CHECK(result == CQ_ERROR_MEMORY || result == CQ_ERROR_ARGUMENT);
        exact_free(memory);
        exact_free(d);
    }
    uncode(&c);
    sample_free(&s);
}

TEST(more_memory_than_needed_gives_the_same_mesh)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d, e;
        decoding_begin_with(&d, 200000);
        decoding_begin(&e, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(decoding_run(&e, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(fingerprint(d.decoder), fingerprint(e.decoder));
        decoding_free(&d);
        decoding_free(&e);
    }
}

TEST(the_contents_of_the_memory_do_not_matter)
{
    FOR_EACH_SAMPLE(s, c) {
        uint64_t expected = 0;
        int fill;
        for (fill = 0; fill < 256; fill += 85) {
            cq_shape shape;
            size_t size;
            void *memory;
            cq_decoder *d = (cq_decoder *)exact_alloc(sizeof *d);
            cq_bytes in;
            REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, NULL, NULL), CQ_OK);
            size = cq_decoder_bytes(&shape);
            memory = exact_alloc(size);
            memset(memory, fill, size);
            memset(d, fill, sizeof *d);
            in.data = c.bytes;
            in.size = c.size;
            CHECK_EQ(cq_decoder_init(d, memory, size), CQ_OK);
            CHECK_EQ(cq_decode(d, &in, CQ_NO_LIMIT), CQ_DONE);
            if (fill == 0) expected = fingerprint(d);
            CHECK_EQ(fingerprint(d), expected);
            exact_free(memory);
            exact_free(d);
        }
    }
}

TEST(null_arguments_of_the_decoder_are_an_error)
{
    cq_decoder *d = (cq_decoder *)exact_alloc(sizeof *d);
    uint32_t memory[16];
    cq_bytes in;
    CHECK_EQ(cq_decoder_init(NULL, memory, sizeof memory), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_decoder_init(d, NULL, 64), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_decoder_init(d, memory, sizeof memory), CQ_OK);
    in.data = NULL;
    in.size = 5;
    CHECK_EQ(cq_decode(NULL, &in, 1), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_decode(d, &in, 1), CQ_ERROR_ARGUMENT);
    exact_free(d);
}

TEST(a_decoder_can_be_used_again_after_another_init)
{
    sample s;
    coded c;
    decoding d;
    uint64_t first;
    REQUIRE_EQ(sample_code(&s, &c, 2), CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 100, CQ_NO_LIMIT), CQ_DONE);
    first = fingerprint(d.decoder);
    CHECK_EQ(cq_decoder_init(d.decoder, d.memory, d.memory_size), CQ_OK);
    CHECK_EQ(d.decoder->mesh.num_vertices, 0);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, 1), CQ_DONE);
    CHECK_EQ(fingerprint(d.decoder), first);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

/* -- Reports ------------------------------------------------------------------------------------------------------- */

static uint64_t report_sum(const cq_report *r)
{
    return r->header + r->base + r->flags + r->indices + r->positions + r->channels;
}

static void check_same_report(const cq_report *a, const cq_report *b)
{
    uint32_t k;
    CHECK_EQ(a->num_components, b->num_components);
    CHECK_EQ(a->num_levels, b->num_levels);
    CHECK_EQ(a->base_vertices, b->base_vertices);
    CHECK_EQ(a->base_faces, b->base_faces);
    CHECK_EQ(a->header, b->header);
    CHECK_EQ(a->base, b->base);
    CHECK_EQ(a->flags, b->flags);
    CHECK_EQ(a->indices, b->indices);
    CHECK_EQ(a->positions, b->positions);
    CHECK_EQ(a->channels, b->channels);
    CHECK_EQ(a->bytes, b->bytes);
    CHECK_EQ(a->shape.num_vertices, b->shape.num_vertices);
    CHECK_EQ(a->shape.num_faces, b->shape.num_faces);
    CHECK_EQ(a->shape.num_boundary_loops, b->shape.num_boundary_loops);
    CHECK_EQ(a->shape.num_boundary_edges, b->shape.num_boundary_edges);
    CHECK_EQ(a->shape.num_channels, b->shape.num_channels);
    for (k = 0; k < a->num_levels && k < CQ_MAX_LEVELS; ++k) {
        const cq_level *x = &a->level[k], *y = &b->level[k];
        CHECK_EQ(x->num_vertices, y->num_vertices);
        CHECK_EQ(x->num_patches, y->num_patches);
        CHECK_EQ(x->num_splits, y->num_splits);
        CHECK_EQ(x->sum_i, y->sum_i);
        CHECK_EQ(x->sum_j, y->sum_j);
        CHECK_EQ(x->error, y->error);
        CHECK_EQ(x->flags, y->flags);
        CHECK_EQ(x->indices, y->indices);
        CHECK_EQ(x->values, y->values);
    }
}

TEST(the_parts_of_a_report_add_up_to_the_stream)
{
    FOR_EACH_SAMPLE(s, c) {
        CHECK_EQ(c.report->bytes, c.size);
        CHECK_EQ(report_sum(c.report), (uint64_t)65536 * 8 * c.size);
        if (s.input.shape.num_channels == 0) CHECK_EQ(c.report->positions + c.report->channels, 0);
    }
}

TEST(decoder_and_encoder_fill_the_same_report)
{
    static const size_t chunks[] = {1, 50, 1000000};
    FOR_EACH_SAMPLE(s, c) {
        size_t k;
        for (k = 0; k < 3; ++k) {
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            decoding_report(&d);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, chunks[k], k == 0 ? 1 : CQ_NO_LIMIT), CQ_DONE);
            check_same_report(d.report, c.report);
            CHECK_EQ(report_sum(d.report), (uint64_t)65536 * 8 * c.size);
            CHECK_EQ(d.decoder->level, d.report->num_levels);
            CHECK_EQ(d.decoder->num_components, d.report->num_components);
            decoding_free(&d);
        }
    }
}

TEST(the_levels_of_a_report_lead_from_the_base_to_the_mesh)
{
    FOR_EACH_SAMPLE(s, c) {
        const cq_report *r = c.report;
        uint32_t vertices = r->base_vertices, k;
        uint64_t flags = 0, indices = 0, values = 0;
        for (k = 0; k < r->num_levels; ++k) {
            CHECK(r->level[k].num_splits <= r->level[k].num_patches || r->level[k].regular);
            CHECK(r->level[k].num_splits > 0);
            vertices += r->level[k].num_splits;
            CHECK_EQ(r->level[k].num_vertices, vertices);
            flags += r->level[k].flags;
            indices += r->level[k].indices;
            values += r->level[k].values;
        }
        CHECK_EQ(vertices, s.mesh.num_vertices);
        CHECK(flags <= r->flags);
        CHECK_EQ(indices, r->indices);
        CHECK(values <= r->positions + r->channels);
        CHECK(r->base_faces <= s.mesh.num_faces);
    }
}

TEST(a_report_counts_the_components)
{
    static const uint32_t components[SAMPLES] = {1, 1, 1, 1, 1, 7, 61, 1, 2};
    FOR_EACH_SAMPLE(s, c) {
        CHECK_EQ(c.report->num_components, components[which_s]);
    }
}

TEST(the_report_does_not_change_the_decoding)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d, e;
        decoding_begin(&d, c.bytes, c.size);
        decoding_begin(&e, c.bytes, c.size);
        decoding_report(&d);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 17, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(decoding_run(&e, c.bytes, c.size, 17, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(fingerprint(d.decoder), fingerprint(e.decoder));
        decoding_free(&d);
        decoding_free(&e);
    }
}

TEST(levels_are_counted_as_they_begin)
{
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    uint32_t before = 0;
    cq_result result;
    REQUIRE_EQ(sample_code(&s, &c, 4), CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    do {
        uint32_t level, n;
        result = cq_decode(d.decoder, &in, 1);
        level = d.decoder->level;
        n = d.decoder->mesh.num_vertices;
        CHECK(level == before || level == before + 1);
        CHECK(level <= c.report->num_levels);
        if (level > 0) CHECK(n <= c.report->level[level - 1].num_vertices);
        if (level > 1) CHECK(n >= c.report->level[level - 2].num_vertices);
        before = level;
    } while (result == CQ_MORE);
    CHECK_EQ(result, CQ_DONE);
    CHECK(c.report->num_levels > 3);
    CHECK_EQ(before, c.report->num_levels);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

/* -- What changed -------------------------------------------------------------------------------------------------- */

/* Copies of the index buffer and of the vertex buffers, as a GPU would have them. */
typedef struct buffers {
    cq_index *indices;
    cq_value *values[CQ_MAX_CHANNELS];
    uint32_t num_vertices, num_faces;
} buffers;

static buffers buffers_make(const cq_decoder *d)
{
    buffers b;
    uint32_t k;
    memset(&b, 0, sizeof b);
    b.indices = (cq_index *)calloc(3 * (size_t)d->shape.num_faces + 1, sizeof *b.indices);
    for (k = 0; k < d->shape.num_channels; ++k)
        b.values[k] = (cq_value *)calloc((size_t)(d->shape.num_vertices + d->shape.num_faces) * CQ_MAX_COMPONENTS + 1,
                                         sizeof(cq_value));
    return b;
}

static void buffers_free(buffers *b)
{
    uint32_t k;
    free(b->indices);
    for (k = 0; k < CQ_MAX_CHANNELS; ++k) free(b->values[k]);
}

/* Row v of the channels of faces (per_face) or of vertices. */
static int values_differ(const buffers *b, const cq_decoder *d, uint32_t v, int per_face)
{
    uint32_t k;
    for (k = 0; k < d->shape.num_channels; ++k) {
        const size_t n = d->shape.channel[k].components;
        if (is_per_face(&d->shape.channel[k]) != per_face) continue;
        if (memcmp(b->values[k] + n * v, d->channel[k] + n * v, n * sizeof(cq_value)) != 0) return 1;
    }
    return 0;
}

static int face_differs(const buffers *b, const cq_decoder *d, uint32_t f)
{
    return f >= b->num_faces || memcmp(b->indices + 3 * f, d->mesh.origin + 3 * f, 3 * sizeof(cq_index)) != 0;
}

static void buffers_update(buffers *b, const cq_decoder *d)
{
    uint32_t k;
    b->num_vertices = d->mesh.num_vertices;
    b->num_faces = d->mesh.num_faces;
    memcpy(b->indices, d->mesh.origin, 3 * b->num_faces * sizeof(cq_index));
    for (k = 0; k < d->shape.num_channels; ++k)
        memcpy(b->values[k], d->channel[k], num_shown(d, k) * sizeof(cq_value));
}

/* Of vertices and faces that had arrived before, only corners of faces are others: in blocks of one element, those of
 * exactly the faces that are marked; or, with regular levels, more are. */
static void check_changes(const buffers *b, const cq_decoder *d)
{
    const uint32_t f = d->mesh.num_faces;
    uint8_t *faces = (uint8_t *)exact_alloc(f);
    uint32_t k;
    memset(faces, 0, f);
    cq_mesh_changes(&d->mesh, (cq_index)b->num_vertices, 0, faces);
    for (k = 0; k < f; ++k) CHECK(faces[k] == face_differs(b, d, k) || (faces[k] && d->mesh.flipped_to));
    CHECK(d->mesh.num_vertices >= b->num_vertices && f >= b->num_faces);
    for (k = 0; k < b->num_vertices; ++k) CHECK(!values_differ(b, d, k, 0));
    for (k = 0; k < b->num_faces; ++k) CHECK(!values_differ(b, d, k, 1));
    exact_free(faces);
}

static void check_changes_with_budget(const coded *c, uint32_t budget)
{
    decoding d;
    buffers b;
    cq_bytes in;
    cq_result result;
    decoding_begin(&d, c->bytes, c->size);
    in.data = c->bytes;
    in.size = c->size;
    result = cq_decode(d.decoder, &in, 1);
    b = buffers_make(d.decoder);
    while (result == CQ_MORE) {
        result = cq_decode(d.decoder, &in, budget);
        check_changes(&b, d.decoder);
        buffers_update(&b, d.decoder);
    }
    CHECK_EQ(result, CQ_DONE);
    buffers_free(&b);
    decoding_free(&d);
}

TEST(what_has_arrived_never_changes_but_for_corners_of_marked_faces)
{
    FOR_EACH_SAMPLE(s, c) {
        check_changes_with_budget(&c, 1);
        check_changes_with_budget(&c, 7);
        check_changes_with_budget(&c, 100);      /* across levels */
        check_changes_with_budget(&c, CQ_NO_LIMIT);
    }
}

TEST(changes_in_blocks_are_those_of_their_elements)
{
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_index since;
        int shift;
        uint32_t k;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        since = (cq_index)(d.decoder->mesh.num_vertices / 2);
        for (shift = 0; shift < 16; ++shift) {
            const uint32_t f = d.decoder->mesh.num_faces, blocks = ((f - 1) >> shift) + 1;
            uint8_t *fine = (uint8_t *)exact_alloc(f), *faces = (uint8_t *)exact_alloc(blocks);
            uint8_t *expected = (uint8_t *)exact_alloc(blocks);
            memset(fine, 0, f);
            memset(faces, 2, blocks);
            memset(expected, 2, blocks);
            cq_mesh_changes(&d.decoder->mesh, since, 0, fine);
            cq_mesh_changes(&d.decoder->mesh, since, shift, faces);
            for (k = 0; k < f; ++k) if (fine[k]) expected[k >> shift] = 1;
            CHECK(memcmp(faces, expected, blocks) == 0);
            exact_free(fine);
            exact_free(faces);
            exact_free(expected);
        }
        decoding_free(&d);
    }
}

/* Steps of all channels full of weights are the largest ones: they fit the buffer of the decoder, whatever the pieces. */
TEST(all_channels_full_of_weights_come_back_in_any_pieces)
{
    static const size_t pieces[] = { 1, 7, 1000, 100000 };
    uint64_t random = 5;
    uint32_t k, v;
    sample s;
    sample_begin(&s, triangles_torus(5, 5));
    for (k = 0; k < CQ_MAX_CHANNELS; ++k) {
        sample_channel(&s, CQ_WEIGHTS, 4, SAMPLE_EXACT_BITS);
        for (v = 0; v < 4 * s.mesh.num_vertices; ++v)
            s.values[k][v] = (cq_value)(next_random(&random) & (CQ_INDEX_BITS == 16 ? 0x3fff : 0xffffffff));
    }
    for (k = 0; k < sizeof pieces / sizeof *pieces; ++k) check_round_trip(&s, pieces[k]);
    sample_free(&s);
}

/* No stream needs more room in the queue than there is; if one did, that would be an error. */
TEST(a_queue_without_room_is_an_error)
{
    uint32_t capacity, errors = 0;
    for (capacity = 0; capacity < 12; ++capacity) {
        sample s;
        coded c;
        decoding d;
        cq_bytes in;
        REQUIRE_EQ(sample_code(&s, &c, 4), CQ_OK);
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        while (d.decoder->level == 0) REQUIRE_EQ(cq_decode(d.decoder, &in, 1), CQ_MORE);
        d.decoder->walk.capacity = (cq_index)capacity;
        while (cq_decode(d.decoder, &in, 1) == CQ_MORE) {}
        CHECK_EQ(d.decoder->status, d.decoder->walk.full ? CQ_ERROR_CORRUPT : CQ_DONE);
        errors += d.decoder->walk.full != 0;
        CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
        decoding_free(&d);
        uncode(&c);
        sample_free(&s);
    }
    CHECK(errors > 1);
}

/* Two components of 1600 vertices, of which at least three quarters are in the base. To find the component that is next,
 * each step looks at a part of them only, so that some steps do nothing else. */
TEST(a_base_of_thousands_of_vertices_is_prepared_in_steps)
{
    static uint8_t locked[3200];
    triangles t = triangles_torus(40, 40);
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    uint32_t v, f, level = 0, idle = 0;
    triangles_append(&t, triangles_torus(40, 40));
    sample_begin(&s, t);
    for (v = 0; v < 3200; ++v) locked[v] = v % 4 != 1;
    s.input.locked = locked;
    s.input.conquest_only = 1;
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK(c.report->base_vertices >= 2400 && c.report->num_levels > 0);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    do {
        const cq_index before = d.decoder->mesh.num_vertices, patches = d.decoder->walk.head;
        level = d.decoder->level;
        d.result = cq_decode(d.decoder, &in, 1);
        idle += level && d.decoder->level == level && d.decoder->mesh.num_vertices == before && d.decoder->walk.head == patches;
    } while (d.result == CQ_MORE);
    CHECK_EQ(d.result, CQ_DONE);
    CHECK(idle > 4 * c.report->num_levels);
    for (f = 0; f < s.mesh.num_faces; ++f) {
        const cq_index *to = d.decoder->mesh.origin + 3 * c.face_map[f], *from = s.mesh.indices + 3 * f;
        uint32_t k = 0;
        while (k < 3 && to[k] != c.map[from[0]]) ++k;
        CHECK(k < 3 && to[(k + 1) % 3] == c.map[from[1]] && to[(k + 2) % 3] == c.map[from[2]]);
    }
    printf("  %d idle steps of %d levels\n", (int)idle, (int)c.report->num_levels);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_stream_gives_back_the_mesh_and_the_values);
#if CQ_INDEX_BITS == 32
    RUN(large_meshes_come_back);
#endif
    RUN(what_is_alike_costs_little);
#if CQ_INDEX_BITS == 32
    RUN(exact_positions_leave_connectivity_as_it_is_without);
    RUN(exact_values_are_any_patterns);
#endif
    RUN(values_at_their_limits_come_back);
    RUN(odd_numbers_of_everything_fit_the_memory_exactly);
    RUN(a_decoder_has_no_gaps_in_vertices_and_faces);
    RUN(any_size_of_pieces_gives_the_same_mesh);
    RUN(pieces_of_no_bytes_only_ask_for_more);
    RUN(any_budget_gives_the_same_mesh);
    RUN(a_budget_of_one_makes_at_most_one_split_and_leaves_a_valid_mesh);
    RUN(a_budget_of_n_does_the_work_of_n_budgets_of_one);
    RUN(a_budget_counts_the_faces_and_vertices_of_the_base);
    RUN(a_budget_of_none_changes_nothing_once_the_mesh_is_there);
    RUN(bytes_behind_the_end_of_a_stream_are_not_used);
    RUN(every_truncation_is_a_mesh_on_the_way_to_the_full_one);
    RUN(a_truncation_gives_the_same_mesh_whatever_the_pieces_and_budgets);
    RUN(the_base_arrives_component_by_component);
    RUN(leaves_are_drawn_one_by_one_the_largest_first);
    RUN(truncated_is_final);
    RUN(the_end_of_the_input_after_all_of_the_stream_is_no_truncation);
    RUN(no_input_at_all_is_truncated);
    RUN(no_flipped_bit_gives_a_complete_mesh);
    RUN(a_missing_byte_in_the_middle_is_found);
    RUN(an_error_is_final_and_uses_no_more_input);
    RUN(a_wrong_magic_a_wrong_version_and_a_wrong_check_value_are_told_apart);
    RUN(a_wrong_check_value_of_the_payload_is_found_at_the_end);
    RUN(a_stream_with_more_splits_than_its_header_has_vertices_for_is_an_error);
    RUN(noise_behind_a_good_header_gives_an_error_or_a_valid_mesh);
    RUN(memory_that_is_one_byte_short_is_an_error_before_any_work);
    RUN(misaligned_memory_is_an_error_of_the_decoder);
    RUN(more_memory_than_needed_gives_the_same_mesh);
    RUN(the_contents_of_the_memory_do_not_matter);
    RUN(null_arguments_of_the_decoder_are_an_error);
    RUN(a_decoder_can_be_used_again_after_another_init);
    RUN(the_parts_of_a_report_add_up_to_the_stream);
    RUN(decoder_and_encoder_fill_the_same_report);
    RUN(the_levels_of_a_report_lead_from_the_base_to_the_mesh);
    RUN(a_report_counts_the_components);
    RUN(the_report_does_not_change_the_decoding);
    RUN(levels_are_counted_as_they_begin);
    RUN(what_has_arrived_never_changes_but_for_corners_of_marked_faces);
    RUN(changes_in_blocks_are_those_of_their_elements);
    RUN(all_channels_full_of_weights_come_back_in_any_pieces);
    RUN(a_queue_without_room_is_an_error);
    RUN(a_base_of_thousands_of_vertices_is_prepared_in_steps);
    return TEST_END();
}
