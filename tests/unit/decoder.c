/* The decoder: input in pieces, budgets, every truncation, damage, memory, sticky results, reports. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "sample.h"
#include "test.h"

/* -- Helpers ------------------------------------------------------------------------------------------------------- */

/* A number that stands for the mesh and the values of this moment, real and virtual. */
static uint64_t fingerprint(const cq_decoder *d) {
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

static int values_in_range(const cq_decoder *d) {
    uint32_t k, j;
    for (k = 0; k < d->shape.num_channels; ++k)
        for (j = 0; j < num_shown(d, k); ++j)
            if (!value_is_in_range(&d->shape.channel[k], d->channel[k][j])) return 0;
    return 1;
}

/* The fingerprints of all meshes that a full decoding goes through, by number of vertices. */
typedef struct history {
    uint64_t *mesh;        /* uint64_t[num_vertices + 1], 0 where there was none */
    uint32_t num_vertices;
} history;

static history history_take(const uint8_t *bytes, size_t size) {
    history h;
    decoding d;
    cq_bytes in;
    cq_result result;
    h.mesh = NULL;
    h.num_vertices = 0;
    decoding_begin(&d, bytes, size);
    in.data = bytes;
    in.size = size;
    do {
        result = cq_decode(d.decoder, &in, 1);
        if (h.mesh == NULL) {
            h.num_vertices = d.decoder->shape.num_vertices;
            h.mesh = (uint64_t *)calloc(h.num_vertices + 1, sizeof *h.mesh);
        }
        CHECK(d.decoder->mesh.num_vertices <= h.num_vertices);
        h.mesh[d.decoder->mesh.num_vertices] = fingerprint(d.decoder);
    } while (result == CQ_OK);
    CHECK_EQ(result, CQ_DONE);
    decoding_free(&d);
    return h;
}

static int history_has(const history *h, const cq_decoder *d) {
    return d->mesh.num_vertices <= h->num_vertices && h->mesh[d->mesh.num_vertices] == fingerprint(d);
}

#define FOR_EACH_SAMPLE(s, c) \
    sample s; coded c; int which_##s; \
    for (which_##s = 0; which_##s < SAMPLES; ++which_##s, uncode(&c), sample_free(&s)) \
        if (sample_code(&s, &c, which_##s) != CQ_OK) test_fail(__FILE__, __LINE__, "the sample encodes"); else

/* -- Whole streams ------------------------------------------------------------------------------------------------- */

/* Faces through the map, each turned to start at its smallest vertex, sorted: a set that can be compared. */
static int compare_faces(const void *a, const void *b) {
    return memcmp(a, b, 3 * sizeof(uint32_t));
}

static uint32_t *face_set(const cq_index *indices, uint32_t num_faces, const cq_index *map) {
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

static int same_mesh(const sample *s, const coded *c, const cq_decoder *d) {
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
static void check_round_trip(sample *s, size_t chunk) {
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

TEST(a_stream_gives_back_the_mesh_and_the_values) {
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

TEST(a_fast_stream_gives_back_the_mesh_and_the_values) {
    int which;
    for (which = 0; which < SAMPLES; ++which) {
        sample s;
        sample_make(&s, which);
        s.input.shape.fast = 1;
        check_round_trip(&s, 50);
        sample_free(&s);
    }
}

#if CQ_INDEX_BITS == 32

/* Every halfedge that is fetched ahead of its turn is one of the mesh. */
static void check_ahead(const cq_decoder *d) {
    int k;
    for (k = 0; d->mesh.num_faces > 0 && k < CQI_AHEAD; ++k) {
        const cq_index f = (cq_index)(d->ahead[k] / 3);
        CHECK(f < d->mesh.num_faces ||
              (f >= d->mesh.first_virtual_face && f - d->mesh.first_virtual_face < d->mesh.num_virtual_faces));
    }
}

/* Meshes that are large enough to be fetched ahead: without channels, with a first channel of faces, of which there are
 * fewer than vertices, and fast ones. */
static void check_large_mesh(triangles mesh, int channels, uint32_t fast) {
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    sample_begin(&s, mesh);
    CHECK(s.mesh.num_vertices >= CQI_LARGE_MESH);
    s.input.shape.fast = fast;
    if (channels == 2) sample_merged(&s, CQ_GROUP, CQ_PER_FACE, 1, 5);
    if (channels > 0) sample_channel(&s, CQ_POSITION, 3, 12);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    while ((d.result = cq_decode(d.decoder, &in, 7)) == CQ_OK) check_ahead(d.decoder);
    CHECK_EQ(d.result, CQ_DONE);
    CHECK(same_mesh(&s, &c, d.decoder));
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

TEST(large_meshes_come_back_and_what_is_fetched_ahead_is_theirs) {
    triangles t = triangles_sheet(30, 30), singles;
    cq_index k;
    singles.num_faces = 10800;
    singles.num_vertices = 3 * singles.num_faces;
    singles.indices = (cq_index *)exact_alloc(singles.num_vertices * sizeof(cq_index));
    for (k = 0; k < singles.num_vertices; ++k) singles.indices[k] = k;
    triangles_append(&t, singles);
    check_large_mesh(t, 2, 0);
    check_large_mesh(triangles_torus(182, 182), 0, 0);
    check_large_mesh(triangles_sheet(182, 182), 1, 1);
}

#endif

/* A mesh of 50 real faces and virtual ones behind them: halfedges 0 .. 149, and more. */
TEST(halfedges_of_the_mesh_are_asked_for_six_lines_before_and_behind) {
    static cq_mesh m;
    m.first_virtual_face = 50;
    CHECK_EQ(cqi_before(0), 0);
    CHECK_EQ(cqi_before(95), 0);
    CHECK_EQ(cqi_before(97), 1);
    CHECK_EQ(cqi_before(149), 53);
    CHECK_EQ(cqi_behind(&m, 0), 96);
    CHECK_EQ(cqi_behind(&m, 53), 149);
    CHECK_EQ(cqi_behind(&m, 54), 54);
    CHECK_EQ(cqi_behind(&m, 200), 200);
}

TEST(vertices_have_first_values_unless_these_are_of_faces) {
    static cq_shape s;
    CHECK(!cqi_has_first_values(&s));
    s.num_channels = 1;
    CHECK(cqi_has_first_values(&s));
    s.channel[0].merge = CQ_PER_FACE;
    CHECK(!cqi_has_first_values(&s));
}

#if CQI_FETCHES

/* A list of 17 patches on a torus, from its end: one spoke of the patch that is eight away from its turn comes in, and
 * each of the eight goes on clockwise. */
TEST(spokes_are_fetched_eight_patches_ahead_and_one_at_a_time) {
    enum { PATCHES = 17 };
    static cq_decoder d;
    static cq_index patch[PATCHES];
    triangles t = triangles_torus(6, 6);
    built b;
    cq_index expected[CQI_AHEAD];
    int k;
    REQUIRE_EQ(build(&b, &t), CQ_OK);
    d.mesh = b.mesh;
    d.patch = patch;
    for (k = 0; k < PATCHES; ++k) patch[k] = b.mesh.out[2 * k];
    memset(expected, 0, sizeof expected);
    d.shape.num_vertices = CQI_LARGE_MESH - 1;
    for (d.walk.tail = PATCHES; d.walk.tail--;) cqi_look_ahead(&d);
    CHECK(memcmp(d.ahead, expected, sizeof expected) == 0);
    d.shape.num_vertices = CQI_LARGE_MESH;
    for (d.walk.tail = PATCHES; d.walk.tail--;) {
        cqi_look_ahead(&d);
        if (d.walk.tail > CQI_AHEAD) expected[d.walk.tail % CQI_AHEAD] = cq_prev(patch[d.walk.tail - CQI_AHEAD]);
        for (k = 0; k < CQI_AHEAD; ++k) expected[k] = b.mesh.twin[cq_next(expected[k])];
        CHECK(memcmp(d.ahead, expected, sizeof expected) == 0);
    }
    unbuild(&b);
    triangles_free(&t);
}

#endif

/* One channel on a torus of 240 vertices and 480 faces: bits that it takes, for a vertex or face. */
static double cost_of_channel(cq_kind kind, cq_merge merge, int components, int bits, cq_value (*value)(uint32_t)) {
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

TEST(what_is_alike_costs_little) {
    CHECK(cost_of_channel(CQ_GROUP, CQ_PER_FACE, 1, 15, always_the_same) < 0.12);
    CHECK(cost_of_channel(CQ_GROUP, CQ_PER_FACE, 1, 8, one_of_two) < 0.6);
    CHECK(cost_of_channel(CQ_JOINTS, CQ_KEEP, 4, 8, always_the_same) < 0.9);
    CHECK(cost_of_channel(CQ_GENERIC, CQ_KEEP, 1, 8, one_of_four) < 6);
}

/* Values of this channel, a row of `n`, are those of some vertex of the input. */
static int is_in_the_input(const sample *s, uint32_t k, const cq_value *row, uint32_t n) {
    uint32_t v;
    for (v = 0; v < s->mesh.num_vertices; ++v)
        if (memcmp(s->values[k] + n * v, row, n * sizeof *row) == 0) return 1;
    return 0;
}

TEST(what_is_kept_is_never_averaged) {
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    uint32_t k, v, n, rows = 0;
    REQUIRE_EQ(sample_code(&s, &c, SAMPLES - 1), CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    while (cq_decode(d.decoder, &in, 5) == CQ_OK) {
        for (k = 0; k < s.input.shape.num_channels; ++k) {
            if (s.input.shape.channel[k].merge != CQ_KEEP) continue;
            n = s.input.shape.channel[k].components;
            for (v = 0; v < d.decoder->mesh.num_vertices; ++v, ++rows)
                CHECK(is_in_the_input(&s, k, d.decoder->channel[k] + n * v, n));
        }
    }
    CHECK(rows > 1000);
    CHECK_EQ(d.decoder->mesh.num_vertices, s.mesh.num_vertices);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

/* Positions that do not move say nothing about where edges were collapsed: connectivity costs what it costs alone. */
TEST(exact_positions_leave_connectivity_as_it_is_without) {
    sample bare, exact;
    coded a, b;
    sample_begin(&bare, triangles_torus(16, 15));
    sample_begin(&exact, triangles_torus(16, 15));
    sample_merged(&exact, CQ_POSITION, CQ_KEEP, 3, SAMPLE_EXACT_BITS);
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

#if CQ_INDEX_BITS == 32
/* Every pair of odd patterns on neighbours: differences are as large as they can be. */
TEST(exact_values_are_any_patterns) {
    static const uint32_t odd[] = {0, 1, 0x7fffffffu, 0x80000000u, 0x80000001u, 0xffffffffu, 0x7f800000u, 0xff800000u,
                                   0x7fc00000u, 0x7f800001u, 0xffc0dead, 0x3f800000u, 0xbf800000u, 0x00800000u};
    uint64_t random = 5;
    int round;
    for (round = 0; round < 50; ++round) {
        sample s;
        uint32_t j;
        sample_begin(&s, round % 2 ? triangles_torus(6, 7) : triangles_disc(40));
        sample_merged(&s, CQ_GENERIC, CQ_KEEP, 4, CQ_EXACT_BITS);
        sample_merged(&s, CQ_GENERIC, CQ_PER_FACE, 1, CQ_EXACT_BITS);
        for (j = 0; j < 4 * s.mesh.num_vertices; ++j) s.values[0][j] = (cq_value)odd[next_random(&random) % 14];
        for (j = 0; j < s.mesh.num_faces; ++j) s.values[1][j] = (cq_value)odd[next_random(&random) % 14];
        check_round_trip(&s, 1);
        sample_free(&s);
    }
}
#endif

TEST(odd_numbers_of_everything_fit_the_memory_exactly) {
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

TEST(a_decoder_has_no_gaps_in_vertices_and_faces) {
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
        } while (result == CQ_OK);
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(any_size_of_pieces_gives_the_same_mesh) {
    static const size_t chunks[] = {1, 2, 3, 7, 16, 61, 255, 256, 257, 4096};
    FOR_EACH_SAMPLE(s, c) {
        history h = history_take(c.bytes, c.size);
        size_t k;
        for (k = 0; k < sizeof chunks / sizeof chunks[0]; ++k) {
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, chunks[k], CQ_NO_LIMIT), CQ_DONE);
            CHECK_EQ(d.used, c.size);
            CHECK_EQ(fingerprint(d.decoder), h.mesh[h.num_vertices]);
            decoding_free(&d);
        }
        free(h.mesh);
    }
}

TEST(pieces_of_no_bytes_only_ask_for_more) {
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
        }
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(any_budget_gives_the_same_mesh) {
    static const uint32_t budgets[] = {1, 2, 5, 64, 1000000};
    FOR_EACH_SAMPLE(s, c) {
        history h = history_take(c.bytes, c.size);
        size_t k;
        for (k = 0; k < sizeof budgets / sizeof budgets[0]; ++k) {
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, 13, budgets[k]), CQ_DONE);
            CHECK_EQ(fingerprint(d.decoder), h.mesh[h.num_vertices]);
            decoding_free(&d);
        }
        free(h.mesh);
    }
}

TEST(a_budget_of_one_makes_at_most_one_split_and_leaves_a_valid_mesh) {
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result;
        uint32_t before = 0, calls = 0;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        do {
            uint32_t now;
            result = cq_decode(d.decoder, &in, 1);
            now = d.decoder->mesh.num_vertices;
            CHECK(result == CQ_OK || result == CQ_DONE);
            CHECK(before == 0 || now == before || now == before + 1);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(values_in_range(d.decoder));
            before = now;
            calls++;
        } while (result == CQ_OK && calls < 100000);
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(a_budget_of_n_does_the_work_of_n_budgets_of_one) {
    FOR_EACH_SAMPLE(s, c) {
        decoding one, many;
        cq_bytes in_one, in_many;
        cq_result a, b = CQ_OK;
        int k;
        decoding_begin(&one, c.bytes, c.size);
        decoding_begin(&many, c.bytes, c.size);
        in_one.data = in_many.data = c.bytes;
        in_one.size = in_many.size = c.size;
        do {
            a = cq_decode(many.decoder, &in_many, 10);
            for (k = 0; k < 10 && b == CQ_OK; ++k) b = cq_decode(one.decoder, &in_one, 1);
            CHECK_EQ(many.decoder->mesh.num_vertices, one.decoder->mesh.num_vertices);
            CHECK_EQ(fingerprint(many.decoder), fingerprint(one.decoder));
        } while (a == CQ_OK && b == CQ_OK);
        CHECK(a == CQ_DONE);
        while (b == CQ_OK) b = cq_decode(one.decoder, &in_one, 1);
        CHECK(b == CQ_DONE);
        decoding_free(&one);
        decoding_free(&many);
    }
}

/* So that a frame or an interrupt bounds a base of many components too. */
TEST(a_budget_counts_the_faces_and_vertices_of_the_base) {
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result = CQ_OK;
        uint32_t calls = 0;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        for (; result == CQ_OK && d.decoder->mesh.num_vertices == 0; calls++) result = cq_decode(d.decoder, &in, 1);
        CHECK(calls > c.report->base_vertices + c.report->base_faces);
        decoding_free(&d);
    }
}

TEST(a_budget_of_none_changes_nothing_once_the_mesh_is_there) {
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
            if (result != CQ_OK) break;
            before = fingerprint(d.decoder);
            CHECK_EQ(cq_decode(d.decoder, &in, 0), CQ_OK);
            CHECK_EQ(fingerprint(d.decoder), before);
        } while (1);
        CHECK_EQ(result, CQ_DONE);
        decoding_free(&d);
    }
}

TEST(bytes_behind_the_end_of_a_stream_are_not_used) {
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

TEST(the_vertices_and_faces_that_there_are_keep_their_numbers) {
    /* Of the faces only their corners may change, and a vertex's values only when it is split. */
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in;
        cq_result result;
        uint32_t vertices = 0, faces = 0;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        do {
            result = cq_decode(d.decoder, &in, 1);
            CHECK(d.decoder->mesh.num_vertices >= vertices);
            CHECK(d.decoder->mesh.num_faces >= faces);
            vertices = d.decoder->mesh.num_vertices;
            faces = d.decoder->mesh.num_faces;
        } while (result == CQ_OK);
        CHECK_EQ(vertices, s.mesh.num_vertices);
        CHECK_EQ(faces, s.mesh.num_faces);
        decoding_free(&d);
    }
}

/* -- Truncation ---------------------------------------------------------------------------------------------------- */

TEST(every_truncation_is_a_mesh_on_the_way_to_the_full_one) {
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
        CHECK(2 * before > h.num_vertices || before == 0);
        free(h.mesh);
    }
}

TEST(a_truncation_gives_the_same_mesh_whatever_the_pieces_and_budgets) {
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

TEST(before_the_base_is_complete_there_are_no_vertices) {
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        size_t k;
        uint32_t base = 0;
        decoding_begin(&d, c.bytes, c.size);
        decoding_report(&d);
        CHECK_EQ(d.decoder->mesh.num_vertices, 0);
        for (k = 0; k < c.size; ++k) {
            decoding_feed(&d, c.bytes + k, 1, 1);
            if (base == 0) base = d.decoder->mesh.num_vertices;
        }
        CHECK_EQ(d.result, CQ_DONE);
        CHECK(base >= d.report->base_vertices);
        decoding_free(&d);
    }
}

TEST(truncated_is_final) {
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

TEST(the_end_of_the_input_after_all_of_the_stream_is_no_truncation) {
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_feed(&d, c.bytes, c.size, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(decoding_end(&d, CQ_NO_LIMIT), CQ_DONE);
        decoding_free(&d);
    }
}

TEST(no_input_at_all_is_truncated) {
    decoding d;
    decoding_begin_with(&d, 100);
    CHECK_EQ(decoding_end(&d, CQ_NO_LIMIT), CQ_TRUNCATED);
    CHECK_EQ(d.decoder->mesh.num_vertices, 0);
    decoding_free(&d);
}

/* -- Damage -------------------------------------------------------------------------------------------------------- */

TEST(no_flipped_bit_gives_a_complete_mesh) {
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

TEST(a_missing_byte_in_the_middle_is_found) {
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

TEST(an_error_is_final_and_uses_no_more_input) {
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

TEST(a_wrong_magic_a_wrong_version_and_a_wrong_check_value_are_told_apart) {
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

TEST(a_wrong_check_value_of_the_payload_is_found_at_the_end) {
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

static int32_t random_within(uint64_t *random, int32_t limit) {
    return (int32_t)(next_random(random) % (2u * (uint32_t)limit + 1)) - limit;
}

TEST(a_level_that_begins_behind_the_last_byte_is_truncated) {
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_bytes in = {c.bytes, c.size};
        decoding_begin(&d, c.bytes, c.size);
        while (d.decoder->phase != CQI_LEVEL && cq_decode(d.decoder, &in, 1) == CQ_OK) {}
        if (d.decoder->mesh.num_vertices < d.decoder->shape.num_vertices) {
            d.decoder->payload_left = 1;
            d.decoder->range.size = d.decoder->range.count - 1;
            CHECK_EQ(cqi_step_level(d.decoder), CQ_TRUNCATED);
        }
        decoding_free(&d);
    }
}

/* A table's entry for 0 steps is no candidate's: nothing but the limit moves it. */
TEST(weights_are_limited_after_every_1024_splits) {
    const int unused[2] = { CQI_SIZE_B, CQI_SIZE_B + 16 };
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    sample_begin(&s, triangles_torus(36, 36));
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    while (d.decoder->mesh.num_vertices < 100) REQUIRE_EQ(cq_decode(d.decoder, &in, 1), CQ_OK);
    d.decoder->model.weight[unused[0]] = CQI_MOST + 5;
    d.decoder->model.weight[unused[1]] = -CQI_MOST - 7;
    while (d.decoder->mesh.num_vertices < CQI_LIMIT_EVERY) REQUIRE_EQ(cq_decode(d.decoder, &in, 1), CQ_OK);
    CHECK_EQ(d.decoder->model.weight[unused[0]], CQI_MOST + 5);
    CHECK_EQ(d.decoder->model.weight[unused[1]], -CQI_MOST - 7);
    while (d.decoder->mesh.num_vertices == CQI_LIMIT_EVERY) REQUIRE_EQ(cq_decode(d.decoder, &in, 1), CQ_OK);
    CHECK_EQ(d.decoder->model.weight[unused[0]], CQI_MOST);
    CHECK_EQ(d.decoder->model.weight[unused[1]], -CQI_MOST);
    CHECK_EQ(cq_decode(d.decoder, &in, CQ_NO_LIMIT), CQ_DONE);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

/* The mesh of this moment has n vertices; the splits of a fast stream teach nothing unless 8 divides n. */
static void check_learning(uint32_t fast) {
    static cqi_model before;
    sample s;
    coded c;
    decoding d;
    cq_bytes in;
    sample_begin(&s, triangles_torus(16, 15));
    s.input.shape.fast = fast;
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    do {
        uint32_t n = d.decoder->mesh.num_vertices;
        before = d.decoder->model;
        d.result = cq_decode(d.decoder, &in, 1);
        if (n > 0 && d.decoder->mesh.num_vertices == n + 1) {
            int same = memcmp(before.weight, d.decoder->model.weight, sizeof before.weight) == 0;
            CHECK_EQ(!same, !fast || n % 8 == 0);
        }
    } while (d.result == CQ_OK);
    CHECK_EQ(d.result, CQ_DONE);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

TEST(weights_learn_from_every_split_or_from_every_eighth_of_a_fast_stream) {
    check_learning(0);
    check_learning(1);
}

/* The sum of a candidate's weights, and the difference of two sums, at the end of 1024 splits of the same kind. */
TEST(scores_do_not_overflow_before_weights_are_limited) {
    const int64_t most = CQI_MOST + (int64_t)CQI_LIMIT_EVERY * CQI_STEP;
    const int weights = 2 * 3 + 2 + 1 + 3; /* of ring vertices, of the steps, the rule, of positions */
    CHECK(weights * most <= INT32_MAX);
    CHECK(2 * weights * most <= (int64_t)UINT32_MAX);
}

/* Before any of its splits is made. */
TEST(a_level_with_more_splits_than_the_header_has_vertices_is_corrupt) {
    FOR_EACH_SAMPLE(s, c) {
        int less;
        uint32_t end = 0;
        for (less = 0; less < 2; ++less) {
            decoding d;
            cq_bytes in = {c.bytes, c.size};
            cq_result result = CQ_OK;
            decoding_begin(&d, c.bytes, c.size);
            while (d.decoder->phase != CQI_WALK && result == CQ_OK) result = cq_decode(d.decoder, &in, 1);
            if (result == CQ_OK) {
                uint32_t before = d.decoder->mesh.num_vertices;
                if (less) d.decoder->shape.num_vertices = end - 1;
                while (d.decoder->phase == CQI_WALK && result == CQ_OK) result = cq_decode(d.decoder, &in, 1);
                CHECK_EQ(result, less ? CQ_ERROR_CORRUPT : CQ_OK);
                CHECK_EQ(d.decoder->mesh.num_vertices, before);
                end = d.decoder->level_end;
            }
            decoding_free(&d);
        }
    }
}

TEST(shifts_of_negative_numbers_round_as_they_say) {
    int32_t x;
    for (x = -1000; x <= 1000; ++x) {
        CHECK_EQ(cqi_floor_shift(x, 3), (x + 8000) / 8 - 1000);
        CHECK_EQ(cqi_floor_half(x), (x + 8000) / 2 - 4000);
        CHECK_EQ(cqi_abs(x), x < 0 ? -x : x);
    }
}

TEST(half_bits_are_the_logarithm_in_halves) {
    CHECK_EQ(cqi_half_bits(0), 0);
    CHECK_EQ(cqi_half_bits(1), 1);
    CHECK_EQ(cqi_half_bits(2), 3);
    CHECK_EQ(cqi_half_bits(3), 4);
    CHECK_EQ(cqi_half_bits(0x7fff), 30);
    CHECK_EQ(cqi_half_bits(0x8000), 32);
    CHECK_EQ(cqi_half_bits(0xffffffffu), 64);
}

/* The 64th neighbour, in the order in which the decoder asks them, counts; the 65th does not. */
TEST(a_base_value_is_predicted_from_at_most_64_neighbours) {
    static cq_decoder d;
    static cq_value values[82];
    static const cq_channel channel = {CQ_GENERIC, 1, 15, CQ_MIDPOINT, 0, {0, 0, 0, 0}};
    triangles t = triangles_bipyramid(80);
    built b;
    cq_index h;
    int k;
    REQUIRE_EQ(build(&b, &t), CQ_OK);
    d.draft = b.mesh;
    for (k = 0, h = b.mesh.out[81]; k < 80; ++k, h = cq_clockwise(&b.mesh, h))
        values[cq_target(&b.mesh, h)] = (cq_value)(k < 63 ? 2 : k == 63 ? 66 : 30000);
    CHECK_EQ(cqi_predict_base(&d, &channel, values, 81), 3);
    CHECK_EQ(cqi_predict_base(&d, &channel, values, 0), 1 << 14);
    unbuild(&b);
    triangles_free(&t);
}

/* L and R of a component are 2 and 3. */
TEST(a_patch_of_a_first_gate_begins_or_ends_at_the_other_end_of_the_gate) {
    static uint8_t mark[6] = {0, 0, CQI_SEED, 0, 0, 0};
    static cq_decoder d;
    d.mesh.mark = mark;
    d.base_vertices = 5;
    CHECK_EQ(cqi_side_of_patch(&d, 2, 3), 2);
    CHECK_EQ(cqi_side_of_patch(&d, 2, 4), 1);
    CHECK_EQ(cqi_side_of_patch(&d, 3, 2), 2);
    CHECK_EQ(cqi_side_of_patch(&d, 3, 4), 1);
    CHECK_EQ(cqi_side_of_patch(&d, 0, 2), 0);
    CHECK_EQ(cqi_side_of_patch(&d, 1, 2), 0);
    CHECK_EQ(cqi_side_of_patch(&d, 4, 3), 0);
    d.base_vertices = 3;
    CHECK_EQ(cqi_side_of_patch(&d, 3, 2), 0);
}

/* Around a patch that is a point nothing turns. */
TEST(residuals_beyond_any_difference_of_values_are_refused_on_each_axis) {
    static const int32_t predicted[3] = {0, 0, 0};
    static cq_decoder d;
    static cqi_plan plan;
    const int32_t limit = (int32_t)1 << (CQI_TURNED_BITS + 2);
    int axis, sign;
    cq_range_encoder_init(&plan.range, NULL, 0);
    cqi_model_init(&d.model, &d.shape);
    d.plan = &plan;
    d.rate = 5;
    d.ring.size = 3;
    for (axis = 0; axis < 3; ++axis) {
        for (sign = -1; sign < 2; sign += 2) {
            int32_t residual[3] = {0, 0, 0};
            residual[axis] = sign * limit;
            CHECK(cqi_code_turned(&d, predicted, residual));
            CHECK_EQ(residual[axis], sign * limit);
            residual[axis] += sign;
            CHECK(!cqi_code_turned(&d, predicted, residual));
        }
    }
}

/* Magnitudes of every number of bits, the smallest and largest one and one between; the 32nd bit is that of -2^31. */
static int32_t plain_residual(int k) {
    const int bits = 1 + k / 6;
    const uint32_t high = (uint32_t)1 << (bits - 1), low = high - 1;
    const uint32_t magnitude = bits == 32 ? high : high | (k % 3 == 0 ? 0 : k % 3 == 1 ? low : low & 0x2d5b6a97u);
    return (int32_t)(k % 6 < 3 ? magnitude : 0 - magnitude);
}

static int32_t code_residual(cq_decoder *d, int k, int32_t residual) {
    return d->shape.fast ? cqi_code_fast(d, k % CQI_SPREADS, residual)
                         : cqi_code_expected(d, CQI_PLAIN, k % 64, 32, residual);
}

static void check_residuals(uint32_t fast) {
    enum { RESIDUALS = 6 * 32 };
    static cq_decoder encoder, decoder;
    static cqi_plan plan;
    static uint8_t bytes[8 * RESIDUALS];
    int k;
    cq_range_encoder_init(&plan.range, bytes, sizeof bytes);
    encoder.shape.fast = decoder.shape.fast = fast;
    cqi_model_init(&encoder.model, &encoder.shape);
    for (k = 0; k < CQI_SPREADS; ++k) encoder.model.mean_bits[k] = (uint16_t)(128 * k);
    decoder.model = encoder.model;
    encoder.plan = &plan;
    encoder.rate = decoder.rate = 5;
    for (k = 0; k < RESIDUALS; ++k) CHECK_EQ(code_residual(&encoder, k, plain_residual(k)), plain_residual(k));
    cq_range_decoder_init(&decoder.range, bytes, cq_range_encoder_finish(&plan.range));
    for (k = 0; k < RESIDUALS; ++k) CHECK_EQ(code_residual(&decoder, k, 0), plain_residual(k));
    CHECK(memcmp(&encoder.model, &decoder.model, sizeof encoder.model) == 0);
}

TEST(plain_residuals_of_any_number_of_bits_come_back) {
    check_residuals(0);
}

/* Also where 34 bits are expected, as of exact values at first: no more than 32 are raw. */
TEST(fast_residuals_of_any_number_of_bits_come_back) {
    check_residuals(1);
}

/* 3 is coded as 6, which has 3 bits: as many as the mean, and one more may have. -4 is coded as 7, and 4 as 8. */
TEST(low_bits_of_fast_residuals_are_raw_up_to_the_mean_and_one) {
    static const struct { int32_t residual; uint32_t raw; int count, bits; } cases[] = {
        {3, 6, 3, 3}, {-4, 7, 3, 3}, {0, 0, 3, 0}, {4, 0, 3, 4}, {-8, 7, 3, 4}, {8, 0, 4, 5}
    };
    size_t k;
    for (k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        static cq_decoder encoder;
        static cqi_plan plan;
        cq_range_decoder d;
        cq_bit_model half = CQ_BIT_MODEL_INIT;
        uint8_t bytes[8] = {0};
        const int more = cases[k].bits > 3 ? cases[k].bits - 3 : 0;
        int n;
        for (n = 0; n < 32; ++n) encoder.model.bit[CQI_FAST + n] = CQ_BIT_MODEL_INIT;
        encoder.model.mean_bits[7] = 2 * 256 + 255;
        encoder.plan = &plan;
        encoder.rate = 5;
        cq_range_encoder_init(&plan.range, bytes, sizeof bytes);
        CHECK_EQ(cqi_code_fast(&encoder, 7, cases[k].residual), cases[k].residual);
        CHECK_EQ(encoder.model.mean_bits[7], 2 * 256 + 255 - 11 + 4 * cases[k].bits);
        cq_range_decoder_init(&d, bytes, cq_range_encoder_finish(&plan.range));
        for (n = 0; n < more; ++n, half = CQ_BIT_MODEL_INIT) CHECK_EQ(cq_decode_bit(&d, &half, 5), 1);
        CHECK_EQ(cq_decode_bit(&d, &half, 5), 0);
        CHECK_EQ(cq_decode_raw(&d, cases[k].count), cases[k].raw);
        for (n = 0; n < 32; ++n) /* of the models those for the last quarter below 3 bits were asked */
            CHECK_EQ(encoder.model.bit[CQI_FAST + n] != CQ_BIT_MODEL_INIT, n >= 24 && n <= 24 + more);
    }
}

/* Rings of all sizes, with any ends, in the order that the scores and the learning of both directions share. */
static void check_pairs(int side) {
    static cq_decoder encoder, decoder;
    static cqi_plan plan;
    static uint8_t bytes[1 << 15];
    uint64_t random = 3;
    int round, size, p, q, coded;
    cq_range_encoder_init(&plan.range, bytes, sizeof bytes);
    encoder.shape.fast = 1;
    cqi_model_init(&encoder.model, &encoder.shape);
    encoder.rate = 5;
    encoder.plan = NULL;
    decoder = encoder;
    encoder.plan = &plan;
    for (round = 0; round < 2; ++round) {
        cq_decoder *d = round ? &decoder : &encoder;
        random = 3;
        coded = 0;
        if (round) cq_range_decoder_init(&decoder.range, bytes, cq_range_encoder_finish(&plan.range));
        for (size = 3; size <= CQ_MAX_VALENCE; ++size) {
            for (q = 1; q < size; ++q) {
                for (p = 0; p < q; ++p) {
                    int k, got_p = round ? 0 : p, got_q = round ? 0 : q;
                    if ((side == 1 && q < size - 1) || (side == 2 && p > 0)) continue;
                    d->ring.size = size;
                    d->ring.side = side;
                    d->ring.level_class = size % 3;
                    d->mesh.num_vertices = (cq_index)coded++;
                    for (k = 0; k < size; ++k) {
                        d->ring.valence[k] = (uint8_t)(3 + next_random(&random) % 20);
                        d->ring.state[k] = (uint8_t)(next_random(&random) % CQI_STATES);
                    }
                    cqi_code_pair(d, &got_p, &got_q);
                    CHECK_EQ(got_p, p);
                    CHECK_EQ(got_q, q);
                }
            }
        }
    }
    CHECK(memcmp(&encoder.model, &decoder.model, sizeof encoder.model) == 0);
    CHECK(decoder.range.count <= decoder.range.size + 4);
}

TEST(pairs_of_fast_streams_come_back_and_teach_both_sides_the_same) {
    int side;
    for (side = 0; side < 3; ++side) check_pairs(side);
}

/* Each split that is learned from moves as much weight up as down. */
TEST(what_one_pair_gains_the_others_lose) {
    static cq_decoder d;
    static cqi_plan plan;
    int32_t sum = 0;
    int k, p = 1, q = 3, changed = 0;
    cq_range_encoder_init(&plan.range, NULL, 0);
    d.plan = &plan;
    d.rate = 5;
    d.shape.fast = 1;
    d.ring.size = 7;
    for (k = 0; k < 7; ++k) d.ring.valence[k] = (uint8_t)(4 + k % 3);
    cqi_code_pair(&d, &p, &q);
    for (k = 0; k < CQI_WEIGHTS; ++k) {
        sum += d.model.weight[k];
        changed += d.model.weight[k] != 0;
        if (k >= CQI_END_EDGE) CHECK_EQ(d.model.weight[k], 0); /* all spokes are alike */
    }
    CHECK_EQ(sum, 0);
    CHECK(changed > 6);
    CHECK(d.model.weight[CQI_SIZE_B + 2] > 0);
}

/* Quarters of the mean of the two shortest, 3 of them are class 0; virtual ones are a class of their own. */
TEST(spokes_have_classes_by_their_length_to_the_shortest_two) {
    static const int32_t scale[] = {1, 37, 5000, 1 << 20};
    size_t k;
    for (k = 0; k < sizeof scale / sizeof scale[0]; ++k) {
        static cqi_ring r;
        const int32_t x = scale[k];
        const int32_t length[] = {8 * x, 12 * x, 10 * x, 15 * x, 20 * x, 35 * x, 37 * x, CQI_WILD};
        static const uint8_t classes[] = {0, 2, 1, 3, 5, 12, 14, 15};
        int n;
        r.size = 8;
        memcpy(r.of_p, length, sizeof length);
        cqi_classify_edges(&r);
        for (n = 0; n < 8; ++n) CHECK_EQ(r.edge[n], classes[n]);
    }
}

/* -0 comes right before 0, as all floats come in their order. */
TEST(patterns_of_floats_stand_for_numbers_in_their_order) {
    const cq_channel exact = {CQ_POSITION, 3, CQ_EXACT_BITS, CQ_KEEP, 0, {0, 0, 0, 0}};
    if (CQ_MAX_BITS < 24) return;
    CHECK_EQ(cqi_number(&exact, 0), 0);
    CHECK_EQ(cqi_number(&exact, INT32_MIN), -1);
    CHECK_EQ(cqi_number(&exact, INT32_MIN + 1), -2);
    CHECK_EQ(cqi_number(&exact, -1), INT32_MIN);
    CHECK_EQ(cqi_number(&exact, INT32_MAX), INT32_MAX);
}

/* A ring of five, the third of which is virtual, split at 1 and 3: B gets 1, 2, 3, and A gets 3, 4, 0, 1. */
TEST(a_split_is_predicted_from_its_fans) {
    enum { CENTRE = 5 };
    static cq_value values[] = {0, 107, 0, 80, 0, 9999, 0, 140, 0, 400, 0, 100};  /* behind others */
    static cq_index origin[] = {CENTRE};
    static cq_decoder d;
    cq_channel channel = {CQ_GENERIC, 2, 12, CQ_MIDPOINT, 0, {0, 0, 0, 0}};
    cqi_ring *r = &d.ring;
    cqi_fans fans;
    int k;
    d.shape.channel[3] = channel;
    d.channel[3] = values;
    r->size = 5;
    for (k = 0; k < 5; ++k) {
        r->seen[k] = (cq_index)(k == 2 ? CENTRE : k);
        r->real[k + 1] = (uint8_t)(r->real[k] + (k != 2));
    }
    cqi_count_fans(r, 1, 3, &fans);
    d.mesh.origin = origin;
    cqi_read_offsets(&d, 3);
    CHECK_EQ(r->offset_channel, 3);
    cqi_sum_fans(r, 1, 2, 1, 3, &fans);
    CHECK_EQ(fans.n_b, 2 + 1);
    CHECK_EQ(fans.n_a, 4 + 1);
    CHECK_EQ(fans.sum_b, -20 + 40);
    CHECK_EQ(fans.sum_a, 40 + 300 + 7 - 20);
    CHECK_EQ(r->spread[1], 7 + 20 + 40 + 300);
    channel.bits = 12;
    CHECK_EQ(cqi_predict_delta(&fans, &channel), 2 * (5 * 20 - 3 * 327) / (2 * 5 * 3 + 5 + 3));
    channel.bits = 20;
    CHECK_EQ(cqi_predict_delta(&fans, &channel), 2 * (5 * 5 - 3 * 81) / (2 * 5 * 3 + 5 + 3) * 4);
}

/* Of the largest residuals that a stream may hold; the sanitizers look for overflow. */
TEST(turns_are_taken_back_exactly) {
    uint64_t random = 5;
    int round, k;
    for (round = 0; round < 20000; ++round) {
        const int32_t limit = (int32_t)1 << (CQI_TURNED_BITS + 2);
        int32_t before[3], after[3];
        cqi_turn turn[3];
        for (k = 0; k < 3; ++k) {
            int32_t x = random_within(&random, 0x3fff), y = random_within(&random, round % 2 ? 0x3fff : 3);
            turn[k] = cqi_find_turn(&x, y);
            before[k] = after[k] = round % 3 ? random_within(&random, limit) : round & 4 << k ? limit : -limit;
        }
        cqi_turn_back(&turn[2], &after[0], &after[1]);
        cqi_turn_back(&turn[1], &after[2], &after[0]);
        cqi_turn_back(&turn[0], &after[0], &after[1]);
        cqi_turn_forth(&turn[0], &after[0], &after[1]);
        cqi_turn_forth(&turn[1], &after[2], &after[0]);
        cqi_turn_forth(&turn[2], &after[0], &after[1]);
        for (k = 0; k < 3; ++k) CHECK_EQ(after[k], before[k]);
    }
}

TEST(noise_behind_a_good_header_gives_an_error_or_a_valid_mesh) {
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

TEST(memory_that_is_one_byte_short_is_an_error_before_any_work) {
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

TEST(misaligned_memory_is_an_error_of_the_decoder) {
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

TEST(more_memory_than_needed_gives_the_same_mesh) {
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

TEST(the_contents_of_the_memory_do_not_matter) {
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

TEST(null_arguments_of_the_decoder_are_an_error) {
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

TEST(a_decoder_can_be_used_again_after_another_init) {
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

static uint64_t report_sum(const cq_report *r) {
    return r->header + r->base + r->flags + r->indices + r->positions + r->channels;
}

static void check_same_report(const cq_report *a, const cq_report *b) {
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
        CHECK_EQ(x->flags, y->flags);
        CHECK_EQ(x->indices, y->indices);
        CHECK_EQ(x->values, y->values);
    }
}

TEST(the_parts_of_a_report_add_up_to_the_stream) {
    FOR_EACH_SAMPLE(s, c) {
        CHECK_EQ(c.report->bytes, c.size);
        CHECK_EQ(report_sum(c.report), (uint64_t)65536 * 8 * c.size);
        if (s.input.shape.num_channels == 0) CHECK_EQ(c.report->positions + c.report->channels, 0);
    }
}

TEST(decoder_and_encoder_fill_the_same_report) {
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

TEST(the_levels_of_a_report_lead_from_the_base_to_the_mesh) {
    FOR_EACH_SAMPLE(s, c) {
        const cq_report *r = c.report;
        uint32_t vertices = r->base_vertices, k;
        uint64_t flags = 0, indices = 0, values = 0;
        for (k = 0; k < r->num_levels; ++k) {
            CHECK(r->level[k].num_splits <= r->level[k].num_patches);
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

TEST(a_report_counts_the_components) {
    static const uint32_t components[SAMPLES] = {1, 1, 1, 1, 1, 7, 61, 1, 2};
    FOR_EACH_SAMPLE(s, c) {
        CHECK_EQ(c.report->num_components, components[which_s]);
    }
}

TEST(the_report_does_not_change_the_decoding) {
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

TEST(levels_are_counted_as_they_begin) {
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
    } while (result == CQ_OK);
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

static buffers buffers_make(const cq_decoder *d) {
    buffers b;
    uint32_t k;
    memset(&b, 0, sizeof b);
    b.indices = (cq_index *)calloc(3 * (size_t)d->shape.num_faces + 1, sizeof *b.indices);
    for (k = 0; k < d->shape.num_channels; ++k)
        b.values[k] = (cq_value *)calloc((size_t)(d->shape.num_vertices + d->shape.num_faces) * CQ_MAX_COMPONENTS + 1,
                                         sizeof(cq_value));
    return b;
}

static void buffers_free(buffers *b) {
    uint32_t k;
    free(b->indices);
    for (k = 0; k < CQ_MAX_CHANNELS; ++k) free(b->values[k]);
}

/* In a channel of faces (per_face) or of vertices. */
static int values_differ(const buffers *b, const cq_decoder *d, uint32_t v, int per_face) {
    uint32_t k;
    for (k = 0; k < d->shape.num_channels; ++k) {
        const size_t n = d->shape.channel[k].components;
        if (is_per_face(&d->shape.channel[k]) != per_face) continue;
        if (memcmp(b->values[k] + n * v, d->channel[k] + n * v, n * sizeof(cq_value)) != 0) return 1;
    }
    return 0;
}

static int face_differs(const buffers *b, const cq_decoder *d, uint32_t f) {
    return f >= b->num_faces || memcmp(b->indices + 3 * f, d->mesh.origin + 3 * f, 3 * sizeof(cq_index)) != 0 ||
           values_differ(b, d, f, 1);
}

static int vertex_differs(const buffers *b, const cq_decoder *d, uint32_t v) {
    return v >= b->num_vertices || values_differ(b, d, v, 0);
}

static int is_next_to_a_new_vertex(const cq_mesh *m, uint32_t v, uint32_t since) {
    cq_index h = m->out[v];
    do {
        if (!cq_is_virtual(m, cq_target(m, h)) && cq_target(m, h) >= since) return 1;
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    return v >= since;
}

static void buffers_update(buffers *b, const cq_decoder *d) {
    uint32_t k;
    b->num_vertices = d->mesh.num_vertices;
    b->num_faces = d->mesh.num_faces;
    memcpy(b->indices, d->mesh.origin, 3 * b->num_faces * sizeof(cq_index));
    for (k = 0; k < d->shape.num_channels; ++k)
        memcpy(b->values[k], d->channel[k], num_shown(d, k) * sizeof(cq_value));
}

/* Blocks of one element: exactly the faces that differ; the vertices that differ and nothing far from a new one. */
static void check_changes(const buffers *b, const cq_decoder *d) {
    const uint32_t n = d->mesh.num_vertices, f = d->mesh.num_faces;
    uint8_t *faces = (uint8_t *)exact_alloc(f), *vertices = (uint8_t *)exact_alloc(n);
    uint32_t k;
    memset(faces, 0, f);
    memset(vertices, 0, n);
    cq_mesh_changes(&d->mesh, (cq_index)b->num_vertices, 0, faces, vertices);
    for (k = 0; k < f; ++k) CHECK_EQ(faces[k], face_differs(b, d, k));
    for (k = 0; k < n; ++k) {
        if (vertex_differs(b, d, k)) CHECK_EQ(vertices[k], 1);
        if (vertices[k]) CHECK(is_next_to_a_new_vertex(&d->mesh, k, b->num_vertices));
    }
    exact_free(faces);
    exact_free(vertices);
}

static void check_changes_with_budget(const coded *c, uint32_t budget) {
    decoding d;
    buffers b;
    cq_bytes in;
    cq_result result;
    decoding_begin(&d, c->bytes, c->size);
    in.data = c->bytes;
    in.size = c->size;
    result = cq_decode(d.decoder, &in, 1);
    b = buffers_make(d.decoder);
    while (result == CQ_OK) {
        result = cq_decode(d.decoder, &in, budget);
        check_changes(&b, d.decoder);
        buffers_update(&b, d.decoder);
    }
    CHECK_EQ(result, CQ_DONE);
    buffers_free(&b);
    decoding_free(&d);
}

TEST(the_changes_are_those_of_the_buffers) {
    FOR_EACH_SAMPLE(s, c) {
        check_changes_with_budget(&c, 1);
        check_changes_with_budget(&c, 7);
        check_changes_with_budget(&c, 100);      /* across levels */
        check_changes_with_budget(&c, CQ_NO_LIMIT);
    }
}

TEST(changes_in_blocks_are_those_of_their_elements) {
    FOR_EACH_SAMPLE(s, c) {
        decoding d;
        cq_index since;
        int shift;
        uint32_t k;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        since = (cq_index)(d.decoder->mesh.num_vertices / 2);
        for (shift = 0; shift < 16; ++shift) {
            const uint32_t n = d.decoder->mesh.num_vertices, f = d.decoder->mesh.num_faces;
            const uint32_t vertex_blocks = ((n - 1) >> shift) + 1, face_blocks = ((f - 1) >> shift) + 1;
            uint8_t *fine = (uint8_t *)exact_alloc(n + f), *faces = (uint8_t *)exact_alloc(face_blocks);
            uint8_t *vertices = (uint8_t *)exact_alloc(vertex_blocks);
            memset(fine, 0, n + f);
            memset(faces, 2, face_blocks);
            memset(vertices, 2, vertex_blocks);
            cq_mesh_changes(&d.decoder->mesh, since, 0, fine + n, fine);
            cq_mesh_changes(&d.decoder->mesh, since, shift, faces, NULL);
            cq_mesh_changes(&d.decoder->mesh, since, shift, NULL, vertices);
            for (k = 0; k < n; ++k) if (fine[k]) CHECK_EQ(vertices[k >> shift], 1);
            for (k = 0; k < f; ++k) if (fine[n + k]) CHECK_EQ(faces[k >> shift], 1);
            for (k = 0; k < n; ++k) if (shift == 0 && !fine[k]) CHECK_EQ(vertices[k], 2);
            exact_free(fine);
            exact_free(faces);
            exact_free(vertices);
        }
        decoding_free(&d);
    }
}

int main(int argc, char **argv) {
    TEST_BEGIN(argc, argv);
    RUN(a_stream_gives_back_the_mesh_and_the_values);
    RUN(a_fast_stream_gives_back_the_mesh_and_the_values);
#if CQ_INDEX_BITS == 32
    RUN(large_meshes_come_back_and_what_is_fetched_ahead_is_theirs);
#endif
    RUN(halfedges_of_the_mesh_are_asked_for_six_lines_before_and_behind);
    RUN(vertices_have_first_values_unless_these_are_of_faces);
#if CQI_FETCHES
    RUN(spokes_are_fetched_eight_patches_ahead_and_one_at_a_time);
#endif
    RUN(what_is_alike_costs_little);
    RUN(what_is_kept_is_never_averaged);
    RUN(exact_positions_leave_connectivity_as_it_is_without);
#if CQ_INDEX_BITS == 32
    RUN(exact_values_are_any_patterns);
#endif
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
    RUN(the_vertices_and_faces_that_there_are_keep_their_numbers);
    RUN(every_truncation_is_a_mesh_on_the_way_to_the_full_one);
    RUN(a_truncation_gives_the_same_mesh_whatever_the_pieces_and_budgets);
    RUN(before_the_base_is_complete_there_are_no_vertices);
    RUN(truncated_is_final);
    RUN(the_end_of_the_input_after_all_of_the_stream_is_no_truncation);
    RUN(no_input_at_all_is_truncated);
    RUN(no_flipped_bit_gives_a_complete_mesh);
    RUN(a_missing_byte_in_the_middle_is_found);
    RUN(an_error_is_final_and_uses_no_more_input);
    RUN(a_wrong_magic_a_wrong_version_and_a_wrong_check_value_are_told_apart);
    RUN(a_wrong_check_value_of_the_payload_is_found_at_the_end);
    RUN(a_level_that_begins_behind_the_last_byte_is_truncated);
    RUN(weights_are_limited_after_every_1024_splits);
    RUN(weights_learn_from_every_split_or_from_every_eighth_of_a_fast_stream);
    RUN(scores_do_not_overflow_before_weights_are_limited);
    RUN(a_level_with_more_splits_than_the_header_has_vertices_is_corrupt);
    RUN(shifts_of_negative_numbers_round_as_they_say);
    RUN(half_bits_are_the_logarithm_in_halves);
    RUN(a_base_value_is_predicted_from_at_most_64_neighbours);
    RUN(a_patch_of_a_first_gate_begins_or_ends_at_the_other_end_of_the_gate);
    RUN(residuals_beyond_any_difference_of_values_are_refused_on_each_axis);
    RUN(plain_residuals_of_any_number_of_bits_come_back);
    RUN(fast_residuals_of_any_number_of_bits_come_back);
    RUN(low_bits_of_fast_residuals_are_raw_up_to_the_mean_and_one);
    RUN(pairs_of_fast_streams_come_back_and_teach_both_sides_the_same);
    RUN(what_one_pair_gains_the_others_lose);
    RUN(spokes_have_classes_by_their_length_to_the_shortest_two);
    RUN(patterns_of_floats_stand_for_numbers_in_their_order);
    RUN(a_split_is_predicted_from_its_fans);
    RUN(turns_are_taken_back_exactly);
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
    RUN(the_changes_are_those_of_the_buffers);
    RUN(changes_in_blocks_are_those_of_their_elements);
    return TEST_END();
}
