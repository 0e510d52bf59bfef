/* Regular levels: that they are taken and lose nothing; each insertion and each flip leaves a valid mesh; what has arrived
 * is final; changed faces are told; streams that are cut or damaged. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "sample.h"
#include "test.h"

#include <math.h>

/* -- Meshes that were subdivided ----------------------------------------------------------------------------------- */

/* The vertex in the middle of an edge, for its two faces: they are looked for in a list. */
typedef struct middles {
    cq_index *a, *b;
    uint32_t count, first;
} middles;

static cq_index middle_of(middles *m, cq_index a, cq_index b)
{
    uint32_t k;
    for (k = 0; k < m->count; ++k)
        if ((m->a[k] == a && m->b[k] == b) || (m->a[k] == b && m->b[k] == a)) return (cq_index)(m->first + k);
    m->a[k] = a;
    m->b[k] = b;
    m->count++;
    return (cq_index)(m->first + k);
}

/* Each face becomes four; frees t. With `skip`, one face in so many stays as it is, and those beside it become two or
 * three. */
static triangles subdivided(triangles t, uint32_t skip)
{
    triangles fine;
    middles m;
    uint32_t f, k, n = 0;
    m.a = (cq_index *)exact_alloc(3 * (size_t)t.num_faces * sizeof(cq_index));
    m.b = (cq_index *)exact_alloc(3 * (size_t)t.num_faces * sizeof(cq_index));
    m.count = 0;
    m.first = t.num_vertices;
    fine.indices = (cq_index *)exact_alloc(12 * (size_t)t.num_faces * sizeof(cq_index));
    for (f = 0; f < t.num_faces; ++f)
        for (k = 0; k < 3 && !(skip && f % skip == 0); ++k)
            middle_of(&m, t.indices[3 * f + k], t.indices[3 * f + (k + 1) % 3]);
    if (skip) { /* edges of faces that are left have no middle */
        middles kept = m;
        kept.a = (cq_index *)exact_alloc(3 * (size_t)t.num_faces * sizeof(cq_index));
        kept.b = (cq_index *)exact_alloc(3 * (size_t)t.num_faces * sizeof(cq_index));
        kept.count = 0;
        for (n = 0; n < m.count; ++n) {
            int left = 0;
            for (f = 0; f < t.num_faces; f += skip)
                for (k = 0; k < 3; ++k) {
                    const cq_index a = t.indices[3 * f + k], b = t.indices[3 * f + (k + 1) % 3];
                    left |= (m.a[n] == a && m.b[n] == b) || (m.a[n] == b && m.b[n] == a);
                }
            if (!left) middle_of(&kept, m.a[n], m.b[n]);
        }
        exact_free(m.a);
        exact_free(m.b);
        m = kept;
    }
    n = 0;
    for (f = 0; f < t.num_faces; ++f) {
        const cq_index *c = t.indices + 3 * f;
        cq_index side[3], around[6];
        uint32_t size = 0, at = 0, known = m.count;
        for (k = 0; k < 3; ++k) {
            side[k] = middle_of(&m, c[k], c[(k + 1) % 3]);
            if (m.count > known) m.count = known, side[k] = CQ_NONE;
        }
        if (side[0] != CQ_NONE && side[1] != CQ_NONE && side[2] != CQ_NONE) {
            for (k = 0; k < 3; ++k) {
                cq_index *to = fine.indices + 3 * n++;
                to[0] = c[k], to[1] = side[k], to[2] = side[(k + 2) % 3];
            }
            fine.indices[3 * n] = side[0], fine.indices[3 * n + 1] = side[1], fine.indices[3 * n + 2] = side[2];
            n++;
            continue;
        }
        for (k = 0; k < 3; ++k) { /* a fan from the first middle, or the face itself */
            around[size++] = c[k];
            if (side[k] == CQ_NONE) continue;
            at = size;
            around[size++] = side[k];
        }
        for (k = 1; k + 1 < size; ++k) {
            cq_index *to = fine.indices + 3 * n++;
            to[0] = around[at], to[1] = around[(at + k) % size], to[2] = around[(at + k + 1) % size];
        }
    }
    fine.num_vertices = t.num_vertices + m.count;
    fine.num_faces = n;
    exact_free(m.a);
    exact_free(m.b);
    triangles_free(&t);
    return fine;
}

/* A height field of w x h, cut along one diagonal, along both in turn, or along any. */
static triangles field(uint32_t w, uint32_t h, int diagonals, uint64_t *random)
{
    triangles t = triangles_sheet(w, h);
    uint32_t q;
    for (q = 0; q < t.num_faces / 2; ++q) {
        cq_index *f = t.indices + 6 * q, a = f[0], b = f[1], c = f[2], d = f[5];
        const uint32_t x = q % (w - 1), y = q / (w - 1);
        const int other = diagonals == 1 ? (int)(x + y) & 1 : diagonals == 2 ? (int)(next_random(random) & 1) : 0;
        if (other) f[0] = a, f[1] = b, f[2] = d, f[3] = b, f[4] = c, f[5] = d;
    }
    return t;
}

/* Random places, each then moved to the mean of the triangles around it, time and again; and some noise. */
static void smooth(sample *s, uint64_t *random)
{
    const uint32_t n = s->mesh.num_vertices;
    double *at = (double *)exact_alloc(3 * n * sizeof(double)), *sum = (double *)exact_alloc(4 * n * sizeof(double));
    double low = 1e30, high = -1e30;
    uint32_t v, f, k, c, pass;
    for (v = 0; v < 3 * n; ++v) at[v] = (double)(next_random(random) % 10000);
    for (pass = 0; pass < 40; ++pass) {
        memset(sum, 0, 4 * n * sizeof(double));
        for (f = 0; f < 3 * s->mesh.num_faces; ++f)
            for (k = 0; k < 3; ++k) {
                double *to = sum + 4 * s->mesh.indices[f];
                for (c = 0; c < 3; ++c) to[c] += at[3 * s->mesh.indices[f / 3 * 3 + k] + c];
                to[3] += 1;
            }
        for (v = 0; v < n; ++v)
            for (c = 0; c < 3; ++c) at[3 * v + c] = sum[4 * v + c] / sum[4 * v + 3];
    }
    for (v = 0; v < 3 * n; ++v) low = fmin(low, at[v]), high = fmax(high, at[v]);
    for (v = 0; v < 3 * n; ++v)
        s->values[0][v] = (cq_value)(4080 * (at[v] - low) / (high - low) + (double)(next_random(random) % 9));
    exact_free(at);
    exact_free(sum);
}

/* A channel whose numbers follow the positions, with some noise; with `steps`, in that many. */
static void follow_positions(sample *s, cq_kind kind, cq_merge merge, int components, int bits, int steps)
{
    const uint32_t k = s->input.shape.num_channels;
    uint64_t random = 300 + k;
    uint32_t v, c, n;
    sample_merged(s, kind, merge, components, bits);
    n = merge == CQ_PER_FACE ? s->mesh.num_faces : s->mesh.num_vertices;
    for (v = 0; v < n; ++v)
        for (c = 0; c < (uint32_t)components; ++c) {
            const cq_value *at = s->values[0] + 3 * (merge == CQ_PER_FACE ? s->mesh.indices[3 * v] : v);
            const float x = (float)at[c % 3] + 0.25f;
            cq_value *to = &s->values[k][v * (uint32_t)components + c];
            if (bits == CQ_EXACT_BITS) memcpy(to, &x, sizeof x);
            else if (steps) *to = (cq_value)(at[c % 3] * steps / 4096);
            else *to = (cq_value)((uint32_t)at[c % 3] << bits >> 12 ^ (uint32_t)(next_random(&random) % 2));
        }
}

/* A material for each half of the box. */
static void add_materials(sample *s, cq_index *materials)
{
    uint32_t f;
    for (f = 0; f < s->mesh.num_faces; ++f) materials[f] = (cq_index)(s->values[0][3 * s->mesh.indices[3 * f]] / 2048);
    s->input.materials = materials;
    s->input.shape.num_materials = 2;
}

/* What a mesh has. */
enum { NOTHING, POSITIONS, ATTRIBUTES, SKIN, FACES, WAYS };

static void add_channels(sample *s, int way, cq_index *materials)
{
    switch (way) {
    case ATTRIBUTES:
        follow_positions(s, CQ_NORMAL, CQ_AVERAGE, 2, 9, 0);
        follow_positions(s, CQ_TEXCOORD, CQ_AVERAGE, 2, 11, 0);
        follow_positions(s, CQ_TANGENT, CQ_AVERAGE, 3, 7, 0);
        follow_positions(s, CQ_COLOR, CQ_AVERAGE, 4, 8, 0);
        break;
    case SKIN:
        follow_positions(s, CQ_GENERIC, CQ_AVERAGE, 3, SAMPLE_EXACT_BITS, 0);
        follow_positions(s, CQ_JOINTS, CQ_COPY, 4, 8, 5);
        follow_positions(s, CQ_WEIGHTS, CQ_AVERAGE, 4, 8, 0);
        follow_positions(s, CQ_GROUP, CQ_COPY, 1, 5, 3);
        break;
    case FACES:
        follow_positions(s, CQ_GROUP, CQ_PER_FACE, 1, 5, 2);
        follow_positions(s, CQ_GENERIC, CQ_AVERAGE, 1, 12, 0);
        add_materials(s, materials);
        break;
    default: break;
    }
}

enum { SHAPES = 11 };

static cq_index materials_of_sample[20000];

static void shape_sample(sample *s, int which, int way)
{
    uint64_t random = 11;
    triangles t;
    switch (which) {
    case 0: t = subdivided(subdivided(subdivided(triangles_icosahedron(), 0), 0), 0); break;
    case 1: t = triangles_torus(16, 20); break;
    case 2: t = field(17, 17, 0, &random); break;
    case 3: t = field(18, 16, 0, &random); break;       /* a row and a column too many */
    case 4: t = field(17, 17, 1, &random); break;
    case 5: t = subdivided(subdivided(triangles_annulus(9), 0), 0); break;
    case 6: t = subdivided(subdivided(triangles_torus(5, 4), 0), 11); break;
    case 7: t = subdivided(subdivided(triangles_disc(12), 0), 5); break;
    case 8: t = field(17, 17, 2, &random); break;
    case 9: t = subdivided(triangles_bipyramid(40), 3); break;
    default:
        t = subdivided(subdivided(triangles_torus(4, 4), 0), 0);
        triangles_append(&t, field(9, 9, 0, &random));
        triangles_append(&t, triangles_icosahedron());
        triangles_append(&t, subdivided(subdivided(triangles_icosahedron(), 0), 0));
    }
    sample_begin(s, t);
    if (way == NOTHING) return;
    sample_channel(s, CQ_POSITION, 3, 12);
    smooth(s, &random);
    REQUIRE(s->mesh.num_faces <= sizeof materials_of_sample / sizeof *materials_of_sample);
    add_channels(s, way, materials_of_sample);
}

static cq_result shape_code(sample *s, coded *c, int which, int way)
{
    shape_sample(s, which, way);
    code(c, &s->input);
    return c->result;
}

static uint32_t regular_levels(const cq_report *r)
{
    uint32_t k, n = 0;
    for (k = 0; k < r->num_levels; ++k) n += r->level[k].regular;
    return n;
}

/* -- Round trips --------------------------------------------------------------------------------------------------- */

static void check_result(const sample *s, const coded *c, const cq_decoder *d)
{
    uint32_t f, v, k, j;
    CHECK_EQ(d->mesh.num_vertices, s->mesh.num_vertices);
    CHECK_EQ(d->mesh.num_faces, s->mesh.num_faces);
    for (k = 0; k < s->input.shape.num_channels; ++k) {
        const cq_channel *channel = &s->input.shape.channel[k];
        const int per_face = channel->merge == CQ_PER_FACE;
        const cq_index *map = per_face ? c->face_map : c->map;
        for (v = 0; v < (per_face ? s->mesh.num_faces : s->mesh.num_vertices); ++v)
            for (j = 0; j < channel->components; ++j)
                CHECK_EQ(d->channel[k][channel->components * map[v] + j], s->values[k][channel->components * v + j]);
    }
    for (f = 0; s->input.materials && f < s->mesh.num_faces; ++f) {
        cq_index first, count;
        cq_material(d, s->input.materials[f], &first, &count);
        CHECK(c->face_map[f] >= first && c->face_map[f] < first + count);
    }
    for (f = 0; f < s->mesh.num_faces; ++f) {
        const cq_index *to = d->mesh.origin + 3 * c->face_map[f], *from = s->mesh.indices + 3 * f;
        for (k = 0; k < 3 && to[k] != c->map[from[0]]; ++k) {}
        CHECK(k < 3 && to[(k + 1) % 3] == c->map[from[1]] && to[(k + 2) % 3] == c->map[from[2]]);
    }
}

TEST(meshes_that_were_subdivided_have_regular_levels_and_come_back)
{
    int which, way, counted[WAYS];
    memset(counted, 0, sizeof counted);
    for (which = 0; which < SHAPES; ++which)
        for (way = 0; way < WAYS; ++way) {
            sample s;
            coded c;
            decoding d;
            REQUIRE_EQ(shape_code(&s, &c, which, way), CQ_OK);
            counted[way] += regular_levels(c.report) > 0;
            decoding_begin(&d, c.bytes, c.size);
            decoding_report(&d);
            CHECK_EQ(decoding_run(&d, c.bytes, c.size, 1, 1), CQ_DONE);
            CHECK_EQ(memcmp(d.report, c.report, sizeof *c.report), 0);
            check_result(&s, &c, d.decoder);
            decoding_free(&d);
            uncode(&c);
            sample_free(&s);
        }
    for (way = 0; way < WAYS; ++way) CHECK(counted[way] >= (way == FACES ? 4 : SHAPES / 2));
}

/* The second try of a stream lies behind the first one, if there is room for it. */
TEST(room_for_two_streams_does_not_change_the_one_that_is_taken)
{
    int which, with_report;
    for (which = 3; which < 10; ++which)
        for (with_report = 0; with_report < 2; ++with_report) {
            sample s;
            coded c;
            size_t memory_size, size;
            cq_report *report = (cq_report *)exact_alloc(sizeof *report);
            uint8_t *memory, *bytes;
            cq_input in;
            shape_sample(&s, which, which < 7 ? SKIN : POSITIONS);
            code(&c, &s.input);
            CHECK_EQ(c.result, CQ_OK);
            in = s.input;
            in.shape = c.shape;
            memory_size = cq_encoder_bytes(&in.shape);
            memory = (uint8_t *)exact_alloc(memory_size);
            bytes = (uint8_t *)exact_alloc(3 * c.size);
            CHECK_EQ(cq_encode(&in, memory, memory_size, bytes, 3 * c.size, &size, NULL, with_report ? report : NULL), CQ_OK);
            CHECK_EQ(size, c.size);
            CHECK_EQ(memcmp(bytes, c.bytes, c.size), 0);
            if (with_report) CHECK_EQ(memcmp(report, c.report, sizeof *report), 0);
            exact_free(bytes);
            exact_free(memory);
            exact_free(report);
            uncode(&c);
            sample_free(&s);
        }
}

/* -- Where it is in question whether they pay ----------------------------------------------------------------------- */

/* Vertices of a sheet of so many columns, so far apart, with some noise. */
static void place_on_grid(sample *s, uint32_t columns, uint32_t apart, uint32_t noise)
{
    uint64_t random = 5;
    uint32_t v, c;
    sample_channel(s, CQ_POSITION, 3, 12);
    for (v = 0; v < s->mesh.num_vertices; ++v)
        for (c = 0; c < 3; ++c)
            s->values[0][3 * v + c] = (cq_value)((c == 0 ? v % columns * apart : c == 1 ? v / columns * apart : 2000) +
                                                 next_random(&random) % noise);
}

/* Regular levels of the stream, which is not larger than one without any. */
static uint32_t regular_levels_that_pay(sample *s)
{
    coded with, without;
    uint32_t n;
    code(&with, &s->input);
    s->input.conquest_only = 1;
    code(&without, &s->input);
    s->input.conquest_only = 0;
    CHECK_EQ(with.result, CQ_OK);
    CHECK_EQ(without.result, CQ_OK);
    CHECK(with.size <= without.size);
    n = regular_levels(with.report);
    uncode(&with);
    uncode(&without);
    return n;
}

/* Quads with diagonals without order: their regular levels are near the surface, and pay if it is smooth or not at all. */
TEST(levels_of_half_regular_meshes_are_taken_if_they_pay)
{
    static const uint32_t noise[] = {1, 5, 14, 40};
    uint32_t with, k, q, taken = 0, left = 0;
    for (with = 2; with <= 10; ++with)
        for (k = 0; k < sizeof noise / sizeof *noise; ++k) {
            uint64_t random = with;
            triangles t = field(30, 30, 0, &random);
            sample s;
            for (q = 0; q < t.num_faces / 2; ++q) { /* as many columns of ten have these diagonals */
                cq_index *f = t.indices + 6 * q, a = f[0], b = f[1], c = f[2], d = f[5];
                if (q % 29 * 10 / 29 >= with || next_random(&random) % 2) continue;
                f[0] = a, f[1] = b, f[2] = d, f[3] = b, f[4] = c, f[5] = d;
            }
            sample_begin(&s, t);
            place_on_grid(&s, 30, 130, noise[k]);
            if (regular_levels_that_pay(&s)) taken++;
            else left++;
            sample_free(&s);
        }
    CHECK(taken > 20 && left > 0);
}

/* A box of n x n x n small ones: as triangles, and with its places. */
static triangles box(uint32_t n, cq_value *places)
{
    enum { MOST = 16 };
    static int number[MOST][MOST][MOST];
    triangles t;
    uint32_t side, x, y, k;
    memset(number, 0xff, sizeof number);
    CHECK(n < MOST);
    t.num_vertices = t.num_faces = 0;
    t.indices = (cq_index *)exact_alloc(36 * (size_t)n * n * sizeof(cq_index));
    for (side = 0; side < 6; ++side)
        for (x = 0; x < n; ++x)
            for (y = 0; y < n; ++y) {
                static const uint32_t across[4] = {0, 1, 1, 0}, along[4] = {0, 0, 1, 1};
                cq_index q[4], *to = t.indices + 3 * t.num_faces;
                for (k = 0; k < 4; ++k) {
                    uint32_t at[3];
                    int *v;
                    at[side % 3] = side < 3 ? 0 : n;
                    at[(side + 1) % 3] = side < 3 ? y + along[k] : x + across[k];
                    at[(side + 2) % 3] = side < 3 ? x + across[k] : y + along[k];
                    v = &number[at[0]][at[1]][at[2]];
                    if (*v < 0) {
                        *v = (int)t.num_vertices++;
                        places[3 * *v] = (cq_value)at[0], places[3 * *v + 1] = (cq_value)at[1], places[3 * *v + 2] = (cq_value)at[2];
                    }
                    q[k] = (cq_index)*v;
                }
                to[0] = q[0], to[1] = q[1], to[2] = q[2], to[3] = q[0], to[4] = q[2], to[5] = q[3];
                t.num_faces += 2;
            }
    return t;
}

/* Two boxes of which the second touches the first with a corner; or it does not. */
static uint32_t levels_of_boxes(uint32_t n, int touch)
{
    static cq_value places[6 * 1500];
    sample s;
    coded c;
    triangles t = box(n, places);
    const uint32_t count = t.num_vertices;
    uint32_t v, h, levels;
    triangles_append(&t, box(n, places + 3 * count));
    sample_begin(&s, t);
    sample_channel(&s, CQ_POSITION, 3, 12);
    for (v = 0; v < 6 * count; ++v) {
        const uint32_t moved = v < 3 * count ? 0 : n + !touch;
        s.values[0][v] = (places[v] + (cq_value)moved) * (cq_value)(4000 / (2 * n + 1));
    }
    for (h = 0; touch && h < 3 * s.mesh.num_faces; ++h)
        if (!memcmp(places + 3 * s.mesh.indices[h], places, 3 * sizeof *places) && s.mesh.indices[h] >= count)
            for (v = 0; v < count; ++v)
                if (places[3 * v] == (cq_value)n && places[3 * v + 1] == (cq_value)n && places[3 * v + 2] == (cq_value)n) s.mesh.indices[h] = (cq_index)v;
    code(&c, &s.input);
    CHECK_EQ(c.result, CQ_OK);
    CHECK_EQ(c.report->prepared.copied_rows, touch);
    levels = regular_levels(c.report);
    uncode(&c);
    sample_free(&s);
    return levels;
}

/* A mesh with copied rows is not encoded twice: it has regular levels if they surely pay, which sharp edges beside the rows
 * of a level leave open. */
TEST(copied_rows_and_sharp_edges_are_not_compared)
{
    CHECK(levels_of_boxes(12, 0) > 0);
    CHECK(levels_of_boxes(12, 1) > 0);
    CHECK(levels_of_boxes(13, 0) > 0);
    CHECK_EQ(levels_of_boxes(13, 1), 0);
}

/* Vertices of a strip that lie at its other end: where the surface is near them is not looked for so far away. */
TEST(a_search_for_the_nearest_face_has_an_end)
{
    sample s;
    coded c;
    uint32_t k;
    sample_begin(&s, triangles_sheet(401, 9));
    place_on_grid(&s, 401, 10, 1);
    for (k = 0; k < 4; ++k) s.values[0][3 * (401 * (2 + 3 * (k & 1)) + 5 + 7 * (k >> 1))] = 3920; /* all parities */
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK(c.report->num_levels > 0 && c.report->level[c.report->num_levels - 1].regular);
    CHECK(c.report->level[c.report->num_levels - 1].error >= 32);
    uncode(&c);
    sample_free(&s);
}

/* Labels take more than the memory of so many components of two faces has: they are then not looked for. */
TEST(components_too_small_for_labels_have_none)
{
    triangles t = triangles_pillow();
    sample s;
    coded c;
    decoding d;
    uint32_t k;
    for (k = 1; k < 60; ++k) triangles_append(&t, triangles_pillow());
    sample_begin(&s, t);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK_EQ(regular_levels(c.report), 0);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 9, CQ_NO_LIMIT), CQ_DONE);
    check_result(&s, &c, d.decoder);
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

/* -- Rows and copies ----------------------------------------------------------------------------------------------- */

/* Each face of the input has the same rows, in the same order around, and its rows the same values. */
static void check_triangles(const sample *s, const coded *c, const cq_decoder *d, const cq_index *indices,
                            uint32_t num_faces)
{
    uint32_t f, k, v;
    for (f = 0; f < num_faces; ++f) {
        const cq_index face = c->face_map[f], *from = indices + 3 * f;
        cq_index to[3];
        if (face < d->mesh.num_faces) cq_read_triangles(d, face, 1, to);
        else memcpy(to, d->aside.index + 3 * (face - d->mesh.num_faces), sizeof to);
        for (k = 0; k < 3 && to[k] != c->map[from[0]]; ++k) {}
        CHECK(k < 3 && to[(k + 1) % 3] == c->map[from[1]] && to[(k + 2) % 3] == c->map[from[2]]);
    }
    for (k = 0; k < s->input.shape.num_channels; ++k)
        for (v = 0; v < s->mesh.num_vertices; ++v) {
            const uint32_t n = s->input.shape.channel[k].components;
            cq_value values[CQ_MAX_COMPONENTS];
            if (c->map[v] >= d->num_rows) continue; /* of no face */
            cq_read_rows(d, k, c->map[v], 1, values);
            CHECK_EQ(memcmp(values, s->values[k] + n * v, n * sizeof *values), 0);
        }
}

/* A face is there twice, and another one is turned over: that makes no difference to the rest. */
TEST(meshes_that_are_prepared_have_regular_levels_too)
{
    int which, counted = 0;
    for (which = 0; which < SHAPES; ++which) {
        sample s;
        coded c;
        decoding d;
        cq_index *indices, swap;
        shape_sample(&s, which, which % 2 ? POSITIONS : ATTRIBUTES);
        indices = (cq_index *)exact_alloc(3 * ((size_t)s.mesh.num_faces + 1) * sizeof(cq_index));
        memcpy(indices, s.mesh.indices, 3 * (size_t)s.mesh.num_faces * sizeof(cq_index));
        memcpy(indices + 3 * s.mesh.num_faces, indices + 30, 3 * sizeof(cq_index));
        swap = indices[60], indices[60] = indices[61], indices[61] = swap;
        s.input.indices = indices;
        s.input.shape.num_faces++;
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        CHECK_EQ(c.report->prepared.repeated_faces, 1);
        CHECK_EQ(c.report->prepared.turned_faces, 1);
        counted += regular_levels(c.report) > 0;
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 9, CQ_NO_LIMIT), CQ_DONE);
        check_triangles(&s, &c, d.decoder, indices, s.input.shape.num_faces);
        decoding_free(&d);
        uncode(&c);
        exact_free(indices);
        sample_free(&s);
    }
    CHECK(counted >= SHAPES / 2);
}

/* Each corner's row is one of its vertex. */
static void check_rows(const cq_decoder *d)
{
    uint32_t h, wrong = 0;
    for (h = 0; h < 3 * d->mesh.num_faces && d->vertex; ++h) {
        if (d->mesh.origin[h / 3 * 3] == CQ_NONE) continue;
        wrong += d->index[h] >= d->num_rows || d->vertex[d->index[h]] != d->mesh.origin[h];
    }
    CHECK_EQ(wrong, 0);
}

/* Faces in one half of the box have rows of their own, with other normals and texture coordinates. */
static void add_seam(sample *s)
{
    const uint32_t n = s->mesh.num_vertices;
    cq_index *copy = (cq_index *)exact_alloc(n * sizeof(cq_index));
    cq_value *values[3];
    uint32_t f, v, k, c, rows = n;
    follow_positions(s, CQ_NORMAL, CQ_AVERAGE, 2, 9, 0);
    follow_positions(s, CQ_TEXCOORD, CQ_AVERAGE, 2, 11, 0);
    for (v = 0; v < n; ++v) copy[v] = CQ_NONE;
    for (f = 0; f < s->mesh.num_faces; ++f)
        for (k = 0; k < 3 && s->values[0][3 * s->mesh.indices[3 * f] + 1] > 2000; ++k) {
            v = s->mesh.indices[3 * f + k];
            if (copy[v] == CQ_NONE) copy[v] = (cq_index)rows++;
        }
    for (k = 0; k < 3; ++k) {
        const uint32_t size = s->input.shape.channel[k].components;
        values[k] = (cq_value *)exact_alloc((size_t)rows * size * sizeof(cq_value));
        memcpy(values[k], s->values[k], (size_t)n * size * sizeof(cq_value));
        for (v = 0; v < n; ++v)
            for (c = 0; c < size && copy[v] != CQ_NONE; ++c)
                values[k][size * copy[v] + c] = k ? s->values[k][size * v + c] / 2 : s->values[k][size * v + c];
        exact_free(s->values[k]);
        s->input.values[k] = s->values[k] = values[k];
    }
    for (f = 0; f < s->mesh.num_faces; ++f)
        if (s->values[0][3 * s->mesh.indices[3 * f] + 1] > 2000)
            for (k = 0; k < 3; ++k) s->mesh.indices[3 * f + k] = copy[s->mesh.indices[3 * f + k]];
    s->mesh.num_vertices = s->input.shape.num_vertices = rows;
    exact_free(copy);
}

TEST(meshes_with_seams_have_regular_levels_too)
{
    uint64_t random = 8;
    int which, counted = 0, wrong = 0, tries;
    for (which = 0; which < SHAPES; ++which) {
        sample s;
        coded c;
        decoding d;
        cq_bytes in;
        shape_sample(&s, which, POSITIONS);
        add_seam(&s);
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        counted += regular_levels(c.report) > 0 && c.report->shape.num_rows;
        decoding_begin(&d, c.bytes, c.size);
        in.data = c.bytes;
        in.size = c.size;
        while (cq_decode(d.decoder, &in, 1) == CQ_MORE) {
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            check_rows(d.decoder);
        }
        CHECK_EQ(d.decoder->status, CQ_DONE);
        check_triangles(&s, &c, d.decoder, s.mesh.indices, s.mesh.num_faces);
        decoding_free(&d);
        for (tries = 0; tries < 60; ++tries) {
            uint8_t *bytes = (uint8_t *)exact_copy(c.bytes, c.size);
            const size_t at = c.size / 2 + (size_t)(next_random(&random) % (c.size - c.size / 2));
            bytes[at] = (uint8_t)(bytes[at] ^ (1 + next_random(&random) % 255));
            decoding_begin(&d, bytes, c.size);
            wrong += decoding_run(&d, bytes, c.size, c.size, 50) == CQ_ERROR_CORRUPT;
            CHECK(d.decoder->status != CQ_DONE);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            check_rows(d.decoder);
            decoding_free(&d);
            exact_free(bytes);
        }
        uncode(&c);
        sample_free(&s);
    }
    CHECK(counted >= SHAPES / 2 && wrong > 50);
}

/* Two rows with all their values must not be more than a step codes. */
TEST(rows_with_too_many_numbers_have_no_regular_levels)
{
    uint32_t channels;
    for (channels = 6; channels < 8; ++channels) {
        sample s;
        coded c;
        decoding d;
        uint32_t k;
        shape_sample(&s, 1, POSITIONS);
        add_seam(&s);
        for (k = 0; k < channels; ++k) follow_positions(&s, CQ_COLOR, CQ_AVERAGE, 4, 8, 0);
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        CHECK(c.report->shape.num_rows > 0);
        CHECK_EQ(regular_levels(c.report) > 0, 3 + 2 * (4 + 4 * channels) <= CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS);
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 9, CQ_NO_LIMIT), CQ_DONE);
        check_triangles(&s, &c, d.decoder, s.mesh.indices, s.mesh.num_faces);
        decoding_free(&d);
        uncode(&c);
        sample_free(&s);
    }
}

/* Two surfaces that share a vertex: two vertices are made of its row. */
TEST(meshes_with_copied_rows_have_regular_levels_too)
{
    triangles t = subdivided(subdivided(subdivided(triangles_icosahedron(), 0), 0), 0);
    const uint32_t n = t.num_vertices;
    uint64_t random = 11;
    uint32_t f, k, i, h;
    sample s;
    coded c;
    decoding d;
    triangles_append(&t, subdivided(subdivided(subdivided(triangles_icosahedron(), 0), 0), 0));
    sample_begin(&s, t);
    sample_channel(&s, CQ_POSITION, 3, 12);
    smooth(&s, &random);
    for (h = 0; h < 3 * s.mesh.num_faces; ++h)
        if (s.mesh.indices[h] == n) s.mesh.indices[h] = 0;
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK_EQ(c.report->prepared.copied_rows, 1);
    CHECK(regular_levels(c.report) > 0);
    decoding_begin(&d, c.bytes, c.size);
    CHECK_EQ(decoding_run(&d, c.bytes, c.size, 9, CQ_NO_LIMIT), CQ_DONE);
    for (f = 0; f < s.mesh.num_faces; ++f) {
        const cq_index *to = d.decoder->mesh.origin + 3 * c.face_map[f], *from = s.mesh.indices + 3 * f;
        for (k = 0; k < 3; ++k) {
            for (i = 0; i < 9; ++i)
                if (d.decoder->channel[0][3 * to[(k + i / 3) % 3] + i % 3] != s.values[0][3 * from[i / 3] + i % 3]) break;
            if (i == 9) break;
        }
        CHECK(k < 3);
    }
    decoding_free(&d);
    uncode(&c);
    sample_free(&s);
}

TEST(locked_vertices_are_in_the_base)
{
    int which, counted = 0;
    for (which = 0; which < SHAPES; ++which) {
        sample s;
        coded c;
        decoding d;
        uint8_t *locked;
        uint32_t v;
        shape_sample(&s, which, POSITIONS);
        locked = (uint8_t *)exact_alloc(s.mesh.num_vertices);
        for (v = 0; v < s.mesh.num_vertices; ++v) locked[v] = v % 50 == 3;
        s.input.locked = locked;
        code(&c, &s.input);
        REQUIRE_EQ(c.result, CQ_OK);
        counted += regular_levels(c.report) > 0;
        for (v = 3; v < s.mesh.num_vertices; v += 50) CHECK(c.map[v] < c.report->base_vertices);
        decoding_begin(&d, c.bytes, c.size);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 9, CQ_NO_LIMIT), CQ_DONE);
        check_result(&s, &c, d.decoder);
        decoding_free(&d);
        uncode(&c);
        exact_free(locked);
        sample_free(&s);
    }
    CHECK(counted >= SHAPES / 2);
}

/* -- Each step ------------------------------------------------------------------------------------------------------ */

/* What somebody has seen: the index buffer, and positions. */
typedef struct seen {
    cq_index *origin;
    uint8_t *there;                             /* of each face */
    cq_value *values[CQ_MAX_CHANNELS];
    cq_index num_vertices, num_faces;
    uint8_t *watched;                           /* of all faces; NULL: not watched */
    uint32_t num_marked, num_changed;           /* in all */
} seen;

static void begin_to_look(seen *s, const sample *of)
{
    uint32_t k;
    memset(s, 0, sizeof *s);
    s->origin = (cq_index *)exact_alloc(3 * (size_t)of->mesh.num_faces * sizeof(cq_index));
    s->there = (uint8_t *)exact_alloc(of->mesh.num_faces);
    memset(s->there, 0, of->mesh.num_faces);
    for (k = 0; k < of->input.shape.num_channels; ++k)
        if (of->input.shape.channel[k].merge != CQ_PER_FACE)
            s->values[k] = (cq_value *)exact_alloc((size_t)of->mesh.num_vertices *
                                                   of->input.shape.channel[k].components * sizeof(cq_value));
}

static void end_looking(seen *s)
{
    uint32_t k;
    exact_free(s->origin);
    exact_free(s->there);
    exact_free(s->watched);
    for (k = 0; k < CQ_MAX_CHANNELS; ++k) exact_free(s->values[k]);
}

/* Are the faces there that the mesh has? */
static int is_face_there(const cq_decoder *d, cq_index f)
{
    uint32_t m;
    for (m = 0; m < (d->shape.num_materials ? d->shape.num_materials : 1); ++m) {
        cq_index first, count;
        cq_material(d, m, &first, &count);
        if (f >= first && f < first + count) return 1;
    }
    return 0;
}

/* A watched face that is marked has changed, though it may be as it was before: flipped there and back. */
static void look(seen *s, cq_decoder *d)
{
    const cq_mesh *m = &d->mesh;
    uint8_t *changed = s->watched ? s->watched : (uint8_t *)exact_alloc(m->num_faces + 1);
    cq_index f, v;
    uint32_t k;
    if (!s->watched) memset(changed, 0, m->num_faces + 1);
    cq_mesh_changes(m, s->num_vertices, 0, changed);
    for (f = 0; f < m->num_faces; ++f) {
        const int same = s->there[f] && memcmp(s->origin + 3 * f, m->origin + 3 * f, 3 * sizeof(cq_index)) == 0;
        if (!is_face_there(d, f)) continue;
        CHECK(same || changed[f]);
        s->there[f] = 1;
        s->num_marked += changed[f] != 0;
        s->num_changed += !same;
    }
    if (s->watched) memset(changed, 0, m->num_faces);
    for (k = 0; k < d->shape.num_channels; ++k)
        for (v = 0; v < d->shape.channel[k].components * s->num_vertices && s->values[k]; ++v)
            CHECK_EQ(s->values[k][v], d->channel[k][v]);
    memcpy(s->origin, m->origin, 3 * (size_t)m->num_faces * sizeof(cq_index));
    for (k = 0; k < d->shape.num_channels; ++k)
        if (s->values[k])
            memcpy(s->values[k], d->channel[k],
                   d->shape.channel[k].components * (size_t)m->num_vertices * sizeof(cq_value));
    s->num_vertices = m->num_vertices;
    s->num_faces = m->num_faces;
    if (!s->watched) exact_free(changed);
}

TEST(each_step_leaves_a_valid_mesh_and_all_that_has_arrived)
{
    uint64_t random = 5;
    int which, way;
    for (which = 0; which < SHAPES; ++which)
        for (way = which % 2; way < WAYS; way += 2) {
            sample s;
            coded c;
            decoding d;
            seen often, seldom;
            cq_bytes in;
            REQUIRE_EQ(shape_code(&s, &c, which, way), CQ_OK);
            decoding_begin(&d, c.bytes, c.size);
            begin_to_look(&often, &s);
            begin_to_look(&seldom, &s);
            often.watched = (uint8_t *)exact_alloc(s.mesh.num_faces);
            memset(often.watched, 0, s.mesh.num_faces);
            cq_watch_faces(d.decoder, 0, often.watched);
            in.data = c.bytes;
            in.size = c.size;
            while (cq_decode(d.decoder, &in, 1) == CQ_MORE) {
                const cq_index before = often.num_vertices;
                CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                if (d.decoder->level > 0) CHECK(d.decoder->mesh.num_vertices <= before + 1);
                look(&often, d.decoder);
                if (next_random(&random) % 50 == 0) look(&seldom, d.decoder);
                if (test_state.failures) break;
            }
            CHECK_EQ(d.decoder->status, CQ_DONE);
            look(&seldom, d.decoder);
            look(&often, d.decoder);
            CHECK_EQ(often.num_marked, often.num_changed);
            end_looking(&often);
            end_looking(&seldom);
            decoding_free(&d);
            uncode(&c);
            sample_free(&s);
            if (test_state.failures) return;
        }
}

/* -- Streams that are not whole, or wrong ----------------------------------------------------------------------------- */

TEST(a_stream_that_is_cut_is_a_coarser_mesh_of_the_same_vertices)
{
    int which;
    for (which = 0; which < SHAPES; ++which) {
        sample s;
        coded c;
        decoding whole;
        size_t size;
        cq_index before = 0;
        REQUIRE_EQ(shape_code(&s, &c, which, 1 + which % (WAYS - 1)), CQ_OK);
        decoding_begin(&whole, c.bytes, c.size);
        REQUIRE_EQ(decoding_run(&whole, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        for (size = 40; size < c.size; size += which == 0 ? 1 : 23) {
            decoding d;
            uint32_t v, k;
            decoding_begin(&d, c.bytes, size);
            CHECK_EQ(decoding_run(&d, c.bytes, size, size, CQ_NO_LIMIT), CQ_TRUNCATED);
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(d.decoder->mesh.num_vertices >= before && d.decoder->mesh.num_vertices < s.mesh.num_vertices);
            before = d.decoder->mesh.num_vertices;
            for (k = 0; k < s.input.shape.num_channels; ++k)
                for (v = 0; v < (uint32_t)before * s.input.shape.channel[k].components &&
                            s.input.shape.channel[k].merge != CQ_PER_FACE; ++v)
                    CHECK_EQ(d.decoder->channel[k][v], whole.decoder->channel[k][v]);
            decoding_free(&d);
        }
        decoding_free(&whole);
        uncode(&c);
        sample_free(&s);
    }
}

/* Values of the mesh that are out of their range. */
static uint32_t num_stray_values(const cq_decoder *d)
{
    uint32_t k, v, n = 0;
    for (k = 0; k < d->shape.num_channels && d->mesh.num_vertices; ++k) {
        const cq_channel *channel = &d->shape.channel[k];
        if (channel->merge == CQ_PER_FACE || channel->bits == CQ_EXACT_BITS) continue;
        for (v = 0; v < channel->components * d->mesh.num_vertices; ++v) n += (uint32_t)d->channel[k][v] >> channel->bits != 0;
    }
    return n;
}

TEST(damaged_streams_leave_a_valid_mesh)
{
    uint64_t random = 77;
    int which, tries, wrong = 0;
    for (which = 0; which < SHAPES; ++which) {
        sample s;
        coded c;
        REQUIRE_EQ(shape_code(&s, &c, which, which % WAYS), CQ_OK);
        for (tries = 0; tries < 100; ++tries) {
            uint8_t *bytes = (uint8_t *)exact_copy(c.bytes, c.size);
            const size_t first = c.size > 60 ? 45 : 20;
            const size_t at = first + (size_t)(next_random(&random) % (c.size - first));
            decoding d;
            cq_result result;
            bytes[at] = (uint8_t)(bytes[at] ^ (1 + next_random(&random) % 255));
            decoding_begin(&d, bytes, c.size);
            result = decoding_run(&d, bytes, c.size, c.size, 1 + (uint32_t)(next_random(&random) % 100));
            CHECK(result == CQ_ERROR_CORRUPT || result == CQ_ERROR_CHECKSUM || result == CQ_ERROR_UNSUPPORTED ||
                  result == CQ_ERROR_FORMAT || result == CQ_ERROR_TOO_LARGE || result == CQ_ERROR_MEMORY ||
                  result == CQ_TRUNCATED || result == CQ_ERROR_VERSION);
            if (d.decoder->mesh.num_vertices) CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK_EQ(num_stray_values(d.decoder), 0);
            wrong += result == CQ_ERROR_CORRUPT;
            decoding_free(&d);
            exact_free(bytes);
        }
        uncode(&c);
        sample_free(&s);
    }
    CHECK(wrong > 50);
}

/* -- Decisions that no encoder makes ---------------------------------------------------------------------------------- */

static void set_models(cq_decoder *d, int from, int to, uint32_t probability)
{
    int k;
    for (k = from; k < to; ++k) d->model.bit[k] = (cq_bit_model)probability;
}

/* Probabilities of what a regular level asks: marks, dissolved edges, and patterns with their flips. */
static void set_regular_models(cq_decoder *d, uint32_t marks, uint32_t flips)
{
    set_models(d, CQI_MARK, CQI_DISSOLVED, marks);
    set_models(d, CQI_DISSOLVED, CQI_TWO, 35000);
    set_models(d, CQI_TWO, CQI_NEW_ALONG, flips);
}

/* A step with input of any bytes, so that bits are as likely as their models say. */
static cq_result any_step(cq_decoder *d, uint64_t *random)
{
    uint8_t bytes[64];
    cq_bytes in = { bytes, sizeof bytes };
    size_t k;
    for (k = 0; k < sizeof bytes; ++k) bytes[k] = (uint8_t)(next_random(random) >> 13);
    d->input.payload_left = 1 << 20;
    return cq_decode(d, &in, 1);
}

/* Decodes up to the first regular level; 0: there is none. */
static int reach_regular_level(cq_decoder *d, const coded *c)
{
    cq_bytes in = { c->bytes, c->size };
    while (d->phase != CQI_WIPE)
        if (cq_decode(d, &in, 1) != CQ_MORE) return 0;
    return 1;
}

TEST(any_marks_and_flips_leave_a_valid_mesh)
{
    uint64_t random = 3;
    int which, tries, reached = 0, done = 0;
    for (which = 0; which < SHAPES; ++which) {
        sample s;
        coded c;
        REQUIRE_EQ(shape_code(&s, &c, which, which % WAYS), CQ_OK);
        for (tries = 0; tries < 60; ++tries) {
            const uint32_t marks = 2000 + (uint32_t)(next_random(&random) % 60000);
            const uint32_t flips = 500 + (uint32_t)(next_random(&random) % 40000);
            decoding d;
            decoding_begin(&d, c.bytes, c.size);
            memset(d.memory, 0xa5, d.memory_size);
            if (reach_regular_level(d.decoder, &c)) {
                ++reached;
                do {
                    CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                    set_regular_models(d.decoder, marks, flips);
                } while (any_step(d.decoder, &random) == CQ_MORE && d.decoder->phase != CQI_LEVEL);
                done += d.decoder->phase == CQI_LEVEL;
                CHECK(d.decoder->status == CQ_OK || d.decoder->status == CQ_ERROR_CORRUPT);
                CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                CHECK_EQ(num_stray_values(d.decoder), 0);
            }
            decoding_free(&d);
        }
        uncode(&c);
        sample_free(&s);
    }
    CHECK(reached > 100 && done > 10);
}

/* Their third corner would be joined to a vertex on one of the edges twice. */
TEST(no_vertex_goes_into_two_faces_that_share_their_edges)
{
    uint64_t random = 9;
    cq_shape shape;
    decoding d;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 6;
    shape.num_faces = 8;
    shape.regular = 1;
    decoding_begin_with(&d, cq_decoder_bytes(&shape));
    d.decoder->shape = shape;
    cqi_start(d.decoder);
    do {
        set_models(d.decoder, CQI_COMPONENT, CQI_COMPONENT + 1, 1);
        set_models(d.decoder, CQI_OTHER_LEVEL, CQI_OTHER_LEVEL + 1, 65534);
        set_models(d.decoder, CQI_KIND_GROW, CQI_KIND_TURN, 1);
        set_models(d.decoder, CQI_KIND_TURN, CQI_KIND_CLOSE, 65534);
        set_models(d.decoder, CQI_MARK, CQI_DISSOLVED, 65534);
    } while (any_step(d.decoder, &random) == CQ_MORE);
    CHECK_EQ(d.decoder->status, CQ_ERROR_CORRUPT);
    CHECK_EQ(d.decoder->phase, CQI_SWEEP);
    CHECK_EQ(d.decoder->mesh.num_vertices, 3);
    CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
    decoding_free(&d);
}

/* A stream with seams, decoded up to its first regular level; *in is what follows. 0: it has none. */
static int begin_with_seams(sample *s, coded *c, decoding *d, cq_bytes *in, int which)
{
    shape_sample(s, which, POSITIONS);
    add_seam(s);
    code(c, &s->input);
    CHECK_EQ(c->result, CQ_OK);
    decoding_begin(d, c->bytes, c->size);
    if (!reach_regular_level(d->decoder, c)) return 0;
    in->size = d->decoder->input.payload_left;
    in->data = c->bytes + c->size - in->size;
    return d->decoder->seams != NULL;
}

static void end_with_seams(sample *s, coded *c, decoding *d)
{
    decoding_free(d);
    uncode(c);
    sample_free(s);
}

/* Marks make rows: more than the header has are found at once. */
TEST(no_more_rows_are_made_than_the_header_has)
{
    int which, tries, in_marks = 0;
    for (which = 0; which < SHAPES; ++which)
        for (tries = 0; tries < 4; ++tries) {
            sample s;
            coded c;
            decoding d;
            cq_bytes in;
            if (begin_with_seams(&s, &c, &d, &in, which)) {
                const cq_index most = (cq_index)(d.decoder->seams->num_rows + (cq_index)(5 * tries));
                d.decoder->shape.num_rows = most;
                while (cq_decode(d.decoder, &in, 1) == CQ_MORE) {}
                CHECK_EQ(d.decoder->status, CQ_ERROR_CORRUPT);
                CHECK_EQ(d.decoder->seams->num_rows, most);
                CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                in_marks += d.decoder->phase == CQI_MARKS;
            }
            end_with_seams(&s, &c, &d);
        }
    CHECK(in_marks > SHAPES);
}

/* A new vertex on a border needs another virtual face, and the header says how many there are. Where there is none left,
 * all corners keep their rows. */
TEST(no_border_is_longer_than_the_header_says)
{
    int which, more, counted = 0;
    for (which = 0; which < SHAPES; ++which)
        for (more = 0; more < 4; ++more) {
            sample s;
            coded c;
            decoding d;
            cq_bytes in;
            if (begin_with_seams(&s, &c, &d, &in, which)) {
                cq_mesh *m = &d.decoder->mesh;
                const cq_index most = (cq_index)(m->num_virtual_faces + (cq_index)more);
                if (most < m->max_virtual_faces) {
                    m->max_virtual_faces = most;
                    while (cq_decode(d.decoder, &in, 1) == CQ_MORE) {}
                    CHECK_EQ(d.decoder->status, CQ_ERROR_CORRUPT);
                    CHECK_EQ(d.decoder->phase, CQI_SWEEP);
                    CHECK_EQ(m->num_virtual_faces, most);
                    CHECK_EQ(cq_mesh_check(m, NULL), CQ_OK);
                    check_rows(d.decoder);
                    ++counted;
                }
            }
            end_with_seams(&s, &c, &d);
        }
    CHECK(counted >= 12);
}

TEST(any_marks_and_flips_leave_each_row_one_vertex)
{
    uint64_t random = 4;
    int which, tries, reached = 0, done = 0;
    for (which = 0; which < SHAPES; ++which)
        for (tries = 0; tries < 12; ++tries) {
            const uint32_t marks = 2000 + (uint32_t)(next_random(&random) % 30000);
            const uint32_t flips = 500 + (uint32_t)(next_random(&random) % 40000);
            sample s;
            coded c;
            decoding d;
            cq_bytes in;
            if (begin_with_seams(&s, &c, &d, &in, which)) {
                ++reached;
                do {
                    check_rows(d.decoder);
                    set_regular_models(d.decoder, marks, flips);
                } while (any_step(d.decoder, &random) == CQ_MORE && d.decoder->phase != CQI_LEVEL);
                done += d.decoder->phase == CQI_LEVEL;
                CHECK(d.decoder->status == CQ_OK || d.decoder->status == CQ_ERROR_CORRUPT);
                CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                check_rows(d.decoder);
            }
            end_with_seams(&s, &c, &d);
        }
    printf("  %d of %d levels are complete\n", done, reached);
    CHECK(reached > 50);
}

/* A flip turns the rows with the corners; an edge that is a seam on either side is left as it is. */
TEST(an_edge_that_is_a_seam_is_not_flipped)
{
    built b;
    triangles t = triangles_torus(5, 4);
    cq_index index[3 * 40], before[3 * 40], h, g, k;
    int way;
    REQUIRE_EQ(build(&b, &t), CQ_OK);
    for (way = 0; way < 4; ++way)
        for (h = 0; h < 3 * 40; ++h) {
            if (!cqi_can_flip(&b.mesh, h)) continue;
            memcpy(index, b.mesh.origin, sizeof index);
            g = b.mesh.twin[h];
            if (way & 1) index[h] = 50;
            if (way & 2) index[cq_next(h)] = 51;
            memcpy(before, index, sizeof index);
            CHECK_EQ(cqi_flip_index(&b.mesh, index, h), way == 0);
            if (way) CHECK(!memcmp(index, before, sizeof index));
            if (way) continue;
            cqi_flip(&b.mesh, h);
            for (k = 0; k < 3 * 40; ++k) CHECK_EQ(index[k], b.mesh.origin[k]);
            CHECK_EQ(b.mesh.twin[h], g);
        }
    unbuild(&b);
    triangles_free(&t);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(meshes_that_were_subdivided_have_regular_levels_and_come_back);
    RUN(room_for_two_streams_does_not_change_the_one_that_is_taken);
    RUN(levels_of_half_regular_meshes_are_taken_if_they_pay);
    RUN(copied_rows_and_sharp_edges_are_not_compared);
    RUN(a_search_for_the_nearest_face_has_an_end);
    RUN(components_too_small_for_labels_have_none);
    RUN(meshes_that_are_prepared_have_regular_levels_too);
    RUN(rows_with_too_many_numbers_have_no_regular_levels);
    RUN(meshes_with_seams_have_regular_levels_too);
    RUN(meshes_with_copied_rows_have_regular_levels_too);
    RUN(locked_vertices_are_in_the_base);
    RUN(each_step_leaves_a_valid_mesh_and_all_that_has_arrived);
    RUN(a_stream_that_is_cut_is_a_coarser_mesh_of_the_same_vertices);
    RUN(damaged_streams_leave_a_valid_mesh);
    RUN(any_marks_and_flips_leave_a_valid_mesh);
    RUN(no_vertex_goes_into_two_faces_that_share_their_edges);
    RUN(no_more_rows_are_made_than_the_header_has);
    RUN(no_border_is_longer_than_the_header_says);
    RUN(any_marks_and_flips_leave_each_row_one_vertex);
    RUN(an_edge_that_is_a_seam_is_not_flipped);
    return TEST_END();
}
