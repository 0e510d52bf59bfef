/* Channels of all forms: every kind with any number of components and bits, merged in any way, in any order, over closed and
 * open meshes, with and without seams, materials, locked vertices and what is aside. They come back; and of damaged streams no
 * value leaves its range. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "codec.h"
#include "records.h"
#include "test.h"
#include "triangles.h"

/* -- Inputs -------------------------------------------------------------------------------------------------------- */

enum { MOST_ROWS = 2000, MOST_FACES = 1500 };

static struct scene {
    cq_index index[3 * MOST_FACES], material[MOST_FACES];
    cq_value values[CQ_MAX_CHANNELS][CQ_MAX_COMPONENTS * MOST_ROWS];
    uint8_t locked[MOST_ROWS];
    cq_input input;
} scene;

static uint64_t state;

static uint32_t draw(uint32_t n) { return (uint32_t)(next_random(&state) % n); }

static triangles draw_mesh(void)
{
    triangles t;
    switch (draw(9)) {
    case 0: return triangles_pillow();
    case 1: return triangles_torus(8, 7);
    case 2: return triangles_sheet(9, 8);
    case 3: return triangles_torus(16, 12);
    case 4: return triangles_bipyramid(40);
    case 5: return triangles_disc(70);
    case 6: t = triangles_annulus(9); triangles_append(&t, triangles_icosahedron()); return t;
    case 7: t = triangles_single(); triangles_append(&t, triangles_sheet(17, 9)); return t;
    default: return triangles_grid(12, 6, 1, 0, 0);
    }
}

static const uint8_t least_components[] = { 3, 1, 2, 2, 3, 1, 1, 1, 1, 1, 2 };
static const uint8_t most_components[] = { 3, 4, 3, 2, 4, 4, 4, 1, 1, 1, 4 };

static uint8_t draw_bits(void)
{
    static const uint8_t bits[] = { 1, 2, 5, 8, 10, 12, 14, 15, 15, 22, 24, CQ_EXACT_BITS, CQ_EXACT_BITS };
    return bits[draw(CQ_INDEX_BITS == 16 ? 9 : sizeof bits)];
}

/* A value of row or face i: near that of the one before, one of a few, or any. */
static cq_value draw_value(const cq_channel *c, uint32_t manner, uint32_t i)
{
    static const uint32_t odd[] = { 0x80000000u, 0, 0x7fc00001u, 0xff800000u, 0x3f800000u };
    const uint32_t top = c->bits == CQ_EXACT_BITS ? 0xffffffffu : ((uint32_t)1 << c->bits) - 1;
    uint32_t x = manner == 0 ? 0 : manner == 1 ? i * (top / 300 + 1) + draw(top / 40 + 1) : manner == 2 ? draw(3) * (top / 2) : (uint32_t)next_random(&state);
    if (c->bits == CQ_EXACT_BITS && draw(5) == 0) x = odd[draw(5)];
    return (cq_value)(x & top);
}

static void add_channel(uint32_t kind, uint32_t components, uint32_t bits, uint32_t merge)
{
    cq_shape *s = &scene.input.shape;
    cq_channel *c = &s->channel[s->num_channels];
    cq_value *to = scene.values[s->num_channels];
    const uint32_t n = merge == CQ_PER_FACE ? s->num_faces : s->num_vertices, manner = draw(4);
    uint32_t i;
    c->kind = (uint8_t)kind;
    c->components = (uint8_t)components;
    c->bits = (uint8_t)bits;
    c->merge = (uint8_t)merge;
    for (i = 0; i < n * components; i++) to[i] = draw_value(c, manner, i / components);
    scene.input.values[s->num_channels++] = to;
}

/* Moves each vertex to the mean of the corners of its faces, time and again: smooth surfaces have regular levels. */
static void smooth(cq_value *at)
{
    static int32_t sum[4 * MOST_ROWS];
    const cq_shape *const s = &scene.input.shape;
    uint32_t pass, h, k, c;
    for (pass = 0; pass < 9; pass++) {
        memset(sum, 0, sizeof sum);
        for (h = 0; h < 3 * s->num_faces; h++)
            for (k = 0; k < 3; k++) {
                int32_t *const to = sum + 4 * scene.index[h];
                for (c = 0; c < 3; c++) to[c] += at[3 * scene.index[h / 3 * 3 + k] + c];
                to[3]++;
            }
        for (h = 0; h < s->num_vertices; h++)
            for (c = 0; c < 3 && sum[4 * h + 3]; c++) at[3 * h + c] = (cq_value)(sum[4 * h + c] / sum[4 * h + 3]);
    }
}

static void draw_channel(void)
{
    const uint32_t kind = draw(11);
    uint32_t merge = draw(4) ? CQ_AVERAGE : draw(3);
    uint32_t components = least_components[kind] + draw(most_components[kind] - least_components[kind] + 1u);
    if (kind == CQ_TURNED) return; /* the encoder's own */
    if (merge == CQ_PER_FACE && (components > 1 && least_components[kind] > 1)) merge = CQ_COPY;
    if (merge == CQ_PER_FACE) components = 1;
    add_channel(kind, components, draw_bits(), merge);
}

/* Corners of a few faces in a row get rows of their own, at the same places; other channels have other values there. */
static void draw_seam(void)
{
    cq_shape *s = &scene.input.shape;
    static cq_index own[MOST_ROWS];
    const uint32_t from = draw(s->num_faces), to = from + 1 + draw(s->num_faces / 3 + 1);
    uint32_t h, k, c;
    memset(own, 0xff, sizeof own);
    for (h = 3 * from; h < 3 * to && h < 3 * s->num_faces && s->num_vertices < MOST_ROWS; h++) {
        const cq_index v = scene.index[h];
        if (own[v] == CQ_NONE) {
            own[v] = (cq_index)s->num_vertices++;
            for (k = 0; k < s->num_channels; k++) {
                const cq_channel *const channel = &s->channel[k];
                cq_value *const values = scene.values[k];
                const int stays = channel->kind == CQ_POSITION || draw(3) == 0;
                for (c = 0; c < channel->components && channel->merge != CQ_PER_FACE; c++)
                    values[own[v] * channel->components + c] =
                        stays ? values[v * channel->components + c] : draw_value(channel, 1 + draw(3), own[v]);
            }
        }
        scene.index[h] = own[v];
    }
}

static void draw_scene(uint32_t number)
{
    cq_shape *const s = &scene.input.shape;
    triangles t;
    uint32_t k, n;
    state = number;
    t = draw_mesh();
    memset(&scene.input, 0, sizeof scene.input);
    scene.input.indices = scene.index;
    memcpy(scene.index, t.indices, 3 * t.num_faces * sizeof(cq_index));
    s->num_vertices = t.num_vertices + (draw(4) ? 0 : draw(4)); /* rows of no face */
    s->num_faces = t.num_faces;
    triangles_free(&t);
    for (n = draw(3); n; n--) draw_channel();
    if (draw(5)) {
        const uint32_t bits = draw(4) ? 12 : draw_bits();
        add_channel(CQ_POSITION, 3, bits, draw(6) ? CQ_AVERAGE : CQ_COPY);
    }
    for (n = draw(7); n; n--) draw_channel();
    for (k = 0; k < s->num_channels; k++)
        if (s->channel[k].kind == CQ_POSITION && s->channel[k].bits <= 15 && draw(3)) smooth(scene.values[k]);
    for (n = draw(3) ? draw(4) : 0; n; n--) draw_seam();
    for (n = draw(3) ? 0 : draw(9); n; n--) { /* a face twice, or with a corner twice */
        const cq_index *const from = scene.index + 3 * draw(s->num_faces);
        memcpy(scene.index + 3 * s->num_faces, from, 3 * sizeof *from);
        if (draw(2)) scene.index[3 * s->num_faces] = from[1];
        for (k = 0; k < s->num_channels; k++)
            if (s->channel[k].merge == CQ_PER_FACE) scene.values[k][s->num_faces] = draw_value(&s->channel[k], 3, 0);
        s->num_faces++;
    }
    if (draw(4) == 0) {
        s->num_materials = 1 + draw(5);
        for (k = 0; k < s->num_faces; k++) scene.material[k] = (cq_index)(draw(9) ? k / 7 % s->num_materials : draw(s->num_materials));
        scene.input.materials = scene.material;
    }
    if (draw(4) == 0) {
        for (k = 0; k < s->num_vertices; k++) scene.locked[k] = draw(20) == 0;
        scene.input.locked = scene.locked;
    }
    if (draw(6) == 0) {
        scene.input.metadata = (const uint8_t *)"names, and what else there is to say";
        s->metadata_bytes = draw(36);
    }
    scene.input.goal = draw(2) ? CQ_BALANCED : CQ_LEAST_CONNECTIVITY;
    scene.input.conquest_only = draw(3) == 0;
    scene.input.clean = draw(4) == 0;
}

/* -- What comes back ----------------------------------------------------------------------------------------------- */

static uint32_t with_rows, with_aside, with_regular;

static void check_scene(const coded *c)
{
    decoding d;
    uint32_t k;
    decoding_begin(&d, c->bytes, c->size);
    decoding_report(&d);
    REQUIRE_EQ(decoding_run(&d, c->bytes, c->size, 1 + c->size % 200, 1 + draw(50)), CQ_DONE);
    CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
    CHECK(rows_are_valid(d.decoder));
    CHECK(same_triangles(&scene.input, d.decoder));
    CHECK(same_unused_rows(&scene.input, d.decoder));
    CHECK(maps_are_right(&scene.input, d.decoder, c->map, c->face_map));
    d.report->prepared = c->report->prepared; /* of the encoder alone */
    CHECK_EQ(memcmp(d.report, c->report, sizeof *d.report), 0);
    with_rows += d.decoder->shape.num_rows > 0;
    with_aside += d.decoder->shape.num_aside_rows + d.decoder->shape.num_aside_faces > 0;
    for (k = 0; k < c->report->num_levels; k++)
        if (c->report->level[k].regular) break;
    with_regular += k < c->report->num_levels;
    decoding_free(&d);
}

/* The first ones, and some that were found to have what is rare: pairs that say nothing, hubs in regular levels, weights of
 * faces, channels before positions. */
enum { FIRST_SCENES = 200, SCENES = FIRST_SCENES + 7 };

static uint32_t number_of(uint32_t scene)
{
    static const uint32_t rare[SCENES - FIRST_SCENES] = { 290, 591, 617, 749, 798, 860, 908 };
    return scene < FIRST_SCENES ? scene : rare[scene - FIRST_SCENES];
}

TEST(channels_of_all_forms_come_back)
{
    uint32_t number;
    with_rows = with_aside = with_regular = 0;
    for (number = 0; number < SCENES && !test_state.failures; number++) {
        coded c;
        draw_scene(number_of(number));
        code(&c, &scene.input);
        CHECK_EQ(c.result, CQ_OK);
        if (c.result == CQ_OK) check_scene(&c);
        if (test_state.failures) printf("  scene %d\n", (int)number_of(number));
        uncode(&c);
    }
    printf("  %d with rows, %d with something aside, %d with regular levels\n", (int)with_rows, (int)with_aside, (int)with_regular);
    CHECK(with_rows > SCENES / 10 && with_aside > SCENES / 6 && with_regular > SCENES / 40);
}

/* With seams, its values are of rows. */
static int channel_of_corner(const cq_channel *c)
{
    return c->kind == CQ_NORMAL || c->kind == CQ_TEXCOORD || c->kind == CQ_TANGENT || c->kind == CQ_COLOR;
}

/* How many values that are there are not in their ranges. */
static uint32_t strays(const cq_decoder *d)
{
    uint32_t k, i, n = 0;
    for (k = 0; k < d->shape.num_channels; k++) {
        const cq_channel *const c = &d->shape.channel[k];
        const int of_corner = d->vertex && c->merge != CQ_PER_FACE;
        uint32_t count = of_corner ? 0 : num_shown(d, k);
        if (of_corner) count = channel_of_corner(c) ? 0 : (uint32_t)d->mesh.num_vertices * c->components;
        if (c->merge == CQ_PER_FACE && d->shape.num_materials) continue; /* there are gaps */
        for (i = 0; i < count; i++) n += !value_is_in_range(c, d->channel[k][i]);
    }
    return n;
}

TEST(damage_leaves_values_in_their_ranges_and_meshes_valid)
{
    uint32_t number, tries, corrupt = 0, others = 0;
    for (number = 0; number < SCENES && !test_state.failures; number++) {
        coded c;
        draw_scene(number_of(number));
        code(&c, &scene.input);
        for (tries = 0; tries < 12 && c.result == CQ_OK; tries++) {
            uint8_t *bytes = (uint8_t *)exact_copy(c.bytes, c.size);
            size_t header_bytes = 0, at, k;
            cq_shape shape;
            decoding d;
            CHECK_EQ(cq_peek(bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
            at = header_bytes + draw((uint32_t)(c.size - header_bytes));
            if (tries % 3 == 0) bytes[at] = (uint8_t)(bytes[at] ^ 1 << draw(8));
            else if (tries % 3 == 1) for (k = at; k < c.size; k++) bytes[k] = (uint8_t)draw(256);
            else memset(bytes + at, (int)draw(2) - 1, c.size - at);
            decoding_begin(&d, bytes, c.size);
            decoding_run(&d, bytes, c.size, c.size, 1 + draw(100));
            CHECK(d.result == CQ_ERROR_CORRUPT || d.result == CQ_ERROR_CHECKSUM || d.result == CQ_TRUNCATED || d.result == CQ_DONE);
            corrupt += d.result == CQ_ERROR_CORRUPT;
            others += d.result != CQ_ERROR_CORRUPT;
            if (d.decoder->mesh.origin) {
                CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
                CHECK_EQ(strays(d.decoder), 0);
            }
            decoding_free(&d);
            exact_free(bytes);
        }
        if (test_state.failures) printf("  scene %d\n", (int)number_of(number));
        uncode(&c);
    }
    printf("  %d corrupt, %d others\n", (int)corrupt, (int)others);
    CHECK(corrupt > SCENES && others > SCENES / 8);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(channels_of_all_forms_come_back);
    RUN(damage_leaves_values_in_their_ranges_and_meshes_valid);
    return TEST_END();
}
