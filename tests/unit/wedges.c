/* Any triangles in, exactly back: rows of GPU vertices over meshes with seams, cuts, junctions, copies and all that is no
 * surface. After every split: rows with one vertex, the mesh valid, edges of the input closed. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "codec.h"
#include "records.h"
#include "test.h"

/* -- Inputs -- */

enum { MOST_ROWS = 20000, MOST_FACES = 12000 };

static struct scene {
    cq_index index[3 * MOST_FACES];
    cq_value position[3 * MOST_ROWS], normal[2 * MOST_ROWS], uv[2 * MOST_ROWS], joint[MOST_ROWS], group[MOST_FACES];
    cq_index material[MOST_FACES];
    uint8_t locked[MOST_ROWS];
    cq_input input;
} scene;

static uint32_t seed = 1;

static uint32_t draw(uint32_t n)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return n ? seed % n : 0;
}

static void add_channel(uint8_t kind, uint8_t components, uint8_t bits, uint8_t merge, const cq_value *values)
{
    cq_shape *s = &scene.input.shape;
    cq_channel *c = &s->channel[s->num_channels];
    c->kind = kind;
    c->components = components;
    c->bits = bits;
    c->merge = merge;
    scene.input.values[s->num_channels++] = values;
}

static void begin(int channels)
{
    memset(&scene.input, 0, sizeof scene.input);
    scene.input.indices = scene.index;
    add_channel(CQ_POSITION, 3, 14, CQ_AVERAGE, scene.position);
    if (channels & 1) add_channel(CQ_NORMAL, 2, 10, CQ_AVERAGE, scene.normal);
    if (channels & 2) add_channel(CQ_TEXCOORD, 2, 12, CQ_AVERAGE, scene.uv);
    if (channels & 4) add_channel(CQ_JOINTS, 1, 6, CQ_COPY, scene.joint);
    if (channels & 8) add_channel(CQ_GROUP, 1, 4, CQ_PER_FACE, scene.group);
    if (channels & 16) scene.input.shape.channel[1].merge = CQ_COPY;
    if (channels & 32) scene.input.shape.num_materials = 7;
    scene.input.materials = scene.material;
}

static cq_index add_row(int32_t x, int32_t y, int32_t z)
{
    const uint32_t v = scene.input.shape.num_vertices++;
    scene.position[3 * v] = (cq_value)(x & 0x3fff);
    scene.position[3 * v + 1] = (cq_value)(y & 0x3fff);
    scene.position[3 * v + 2] = (cq_value)(z & 0x3fff);
    scene.normal[2 * v] = scene.normal[2 * v + 1] = 500;
    scene.uv[2 * v] = (cq_value)(x & 0xfff);
    scene.uv[2 * v + 1] = (cq_value)(y & 0xfff);
    scene.joint[v] = (cq_value)(x >> 10 & 63);
    return (cq_index)v;
}

static void add_face(cq_index a, cq_index b, cq_index c)
{
    const uint32_t f = scene.input.shape.num_faces++;
    scene.index[3 * f] = a;
    scene.index[3 * f + 1] = b;
    scene.index[3 * f + 2] = c;
    scene.group[f] = (cq_value)(f / 64 % 5);
    scene.material[f] = (cq_index)(f / 50 % 4 + f / 17 % 2);
}

static cq_index copy_row(cq_index from)
{
    const uint32_t v = scene.input.shape.num_vertices++;
    memcpy(scene.position + 3 * v, scene.position + 3 * from, 3 * sizeof(cq_value));
    memcpy(scene.normal + 2 * v, scene.normal + 2 * from, 2 * sizeof(cq_value));
    memcpy(scene.uv + 2 * v, scene.uv + 2 * from, 2 * sizeof(cq_value));
    scene.joint[v] = scene.joint[from];
    return (cq_index)v;
}

static void add_metadata(const char *text, uint32_t size)
{
    scene.input.metadata = (const uint8_t *)text;
    scene.input.shape.metadata_bytes = size;
}

/* A sheet of w by h quads, closed in one direction or both, or closed with a twist. */
static void add_sheet(int w, int h, int closed, int twisted)
{
    const cq_index first = (cq_index)scene.input.shape.num_vertices;
    const int columns = closed & 1 ? w : w + 1, rows = closed & 2 ? h : h + 1;
    int x, y;
    for (y = 0; y < rows; y++)
        for (x = 0; x < columns; x++)
            add_row(4000 + x * 300 + (int32_t)draw(60), 3000 + y * 280 + (int32_t)draw(60), 5000 + (x * x + 3 * y * x) % 700 + (int32_t)draw(40));
    for (y = 0; y < h; y++)
        for (x = 0; x < w; x++) {
            const int turn = twisted && x == w - 1;
            const cq_index a = (cq_index)(first + (cq_index)(y % rows * columns + x));
            const cq_index d = (cq_index)(first + (cq_index)((y + 1) % rows * columns + x));
            const cq_index b = (cq_index)(first + (cq_index)((turn ? h - y : y) % rows * columns + (x + 1) % columns));
            const cq_index c = (cq_index)(first + (cq_index)((turn ? h - y - 1 : y + 1) % rows * columns + (x + 1) % columns));
            add_face(a, b, c);
            add_face(a, c, d);
        }
}

/* Gives the corners of random patches of faces rows of their own; `differ`: with other values. */
static void add_seams(int patches, int differ)
{
    const uint32_t faces = scene.input.shape.num_faces;
    static cq_index row[MOST_ROWS];
    int k;
    for (k = 0; k < patches; k++) {
        const uint32_t from = draw(faces), count = 1 + draw(faces / 4 + 1);
        uint32_t h;
        memset(row, 0xff, sizeof row);
        for (h = 3 * from; h < 3 * (from + count) && h < 3 * faces; h++) {
            const cq_index v = scene.index[h];
            if (v >= MOST_ROWS || scene.input.shape.num_vertices + 1 >= MOST_ROWS) continue;
            if (row[v] == CQ_NONE) {
                row[v] = copy_row(v);
                if (differ & 1) scene.normal[2 * row[v]] = (cq_value)(100 + 37 * k % 800);
                if (differ & 2) scene.uv[2 * row[v]] = (cq_value)((scene.uv[2 * row[v]] + 1000 + 111 * k) & 0xfff);
            }
            scene.index[h] = row[v];
        }
    }
}

/* Random damage: faces gone, doubled, turned, degenerate, at other rows; rows of no face. */
static void damage(int amount, int which)
{
    int k;
    for (k = 0; k < amount && scene.input.shape.num_faces && scene.input.shape.num_faces + 2 < MOST_FACES; k++) {
        const uint32_t faces = scene.input.shape.num_faces, f = draw(faces), kind = draw(8), rows = scene.input.shape.num_vertices;
        cq_index *const i = scene.index + 3 * f;
        const cq_index a = i[0];
        if (!(which >> kind & 1)) continue;
        switch (kind) {
        case 0: memcpy(i, scene.index + 3 * (faces - 1), 3 * sizeof *i); scene.input.shape.num_faces--; break;
        case 1: add_face(i[1], i[2], i[0]); break;
        case 2: add_face(i[0], i[2], i[1]); break;
        case 3: i[0] = i[1]; i[1] = a; break;
        case 4: add_face(i[0], i[1], i[draw(2)]); break;
        case 5: add_face(i[0], i[1], (cq_index)draw(rows)); break;
        case 6: i[draw(3)] = (cq_index)draw(rows); break;
        default: if (rows + 1 < MOST_ROWS) copy_row((cq_index)draw(rows)); break;
        }
    }
}

/* -- What comes back -- */

/* Decodes in steps and checks each mesh that there is; and cq_moved_rows against what moved, and that nothing else did. */
static void check_steps(const coded *c, int clean)
{
    static uint8_t moved[MOST_ROWS];
    static cq_index before[MOST_ROWS];
    decoding d;
    cq_index vertices = 0, rows = 0, r;
    cq_bytes in;
    decoding_begin(&d, c->bytes, c->size);
    in.data = c->bytes;
    in.size = c->size;
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        if (d.decoder->mesh.num_vertices == vertices || d.result < 0) continue;
        CHECK(rows_are_valid(d.decoder));
        CHECK(materials_are_valid(d.decoder));
        if (vertices % 37 == 0) CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
        memset(moved, 0, sizeof moved);
        if (vertices) cq_moved_rows(d.decoder, vertices, rows, 0, moved);
        for (r = 0; d.decoder->vertex && r < rows; r++) CHECK_EQ(moved[r], before[r] != d.decoder->vertex[r] && !(clean && !moved[r]));
        if (clean) for (r = 0; r < rows; r++) CHECK(!moved[r]);
        vertices = d.decoder->mesh.num_vertices;
        rows = d.decoder->num_rows;
        if (d.decoder->vertex) memcpy(before, d.decoder->vertex, rows * sizeof(cq_index));
    } while (d.result == CQ_MORE);
    CHECK_EQ(d.result, CQ_DONE);
    decoding_free(&d);
}

/* What comes of the first bytes is a mesh, too. */
static void check_cuts(const coded *c)
{
    int k;
    for (k = 0; k < 6; k++) {
        decoding d;
        decoding_begin(&d, c->bytes, c->size);
        decoding_run(&d, c->bytes, draw((uint32_t)c->size), 50, 1000);
        CHECK(d.result == CQ_TRUNCATED || d.result == CQ_NEED_INPUT);
        if (d.decoder->mesh.origin) {
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(rows_are_valid(d.decoder));
            CHECK(!d.decoder->mesh.num_faces || materials_are_valid(d.decoder));
        }
        decoding_free(&d);
    }
}

static cq_report last;
static uint32_t edges_shared; /* of the last input; 0: one of them is open */

static void check_round_trip(void)
{
    coded c;
    decoding d;
    code(&c, &scene.input);
    CHECK_EQ(c.result, CQ_OK);
    if (c.result == CQ_OK) {
        last = *c.report;
        decoding_begin(&d, c.bytes, c.size);
        decoding_report(&d);
        CHECK_EQ(decoding_run(&d, c.bytes, c.size, 7, 100), CQ_DONE);
        if (d.result == CQ_DONE) {
            CHECK_EQ(cq_mesh_check(&d.decoder->mesh, NULL), CQ_OK);
            CHECK(rows_are_valid(d.decoder));
            CHECK(same_triangles(&scene.input, d.decoder));
            CHECK(same_unused_rows(&scene.input, d.decoder));
            CHECK(maps_are_right(&scene.input, d.decoder, c.map, c.face_map));
            edges_shared = shared_edges(&scene.input, d.decoder, c.face_map);
            CHECK_EQ(d.decoder->shape.metadata_bytes, scene.input.shape.metadata_bytes);
            if (scene.input.shape.metadata_bytes)
                CHECK(!memcmp(d.decoder->metadata, scene.input.metadata, scene.input.shape.metadata_bytes));
            CHECK_EQ(d.report->header, c.report->header);
            CHECK_EQ(d.report->aside, c.report->aside);
            CHECK_EQ(d.report->channels, c.report->channels);
        }
        decoding_free(&d);
        check_steps(&c, scene.input.clean);
        check_cuts(&c);
    }
    uncode(&c);
}

/* -- Tests -- */

/* A fin stands on a sheet: edges of three faces. All of its foot is in the base. */
TEST(a_junction_is_in_the_base)
{
    coded c;
    decoding d;
    cq_bytes in;
    uint32_t k, foot = 0;
    begin(0);
    add_sheet(14, 14, 0, 0);
    for (k = 0; k < 8; k++) copy_row((cq_index)(7 * 15 + 3 + k));
    for (k = 0; k < 8; k++) scene.position[3 * (225 + k) + 2] = (cq_value)(9000 + 10 * k * k);
    for (k = 0; k < 7; k++) {
        add_face((cq_index)(7 * 15 + 3 + k), (cq_index)(7 * 15 + 4 + k), (cq_index)(225 + k));
        add_face((cq_index)(7 * 15 + 4 + k), (cq_index)(226 + k), (cq_index)(225 + k));
    }
    code(&c, &scene.input);
    REQUIRE_EQ(c.result, CQ_OK);
    CHECK_EQ(c.report->prepared.cut_edges, 7);
    CHECK_EQ(c.report->prepared.copied_rows, 8);
    CHECK_EQ(c.report->prepared.locked_vertices, 16);
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    while (d.decoder->level == 0 && d.result >= 0) d.result = cq_decode(d.decoder, &in, 1);
    CHECK(d.decoder->mesh.num_vertices < 50);
    for (k = 0; k < d.decoder->mesh.num_vertices; k++) {
        uint32_t j;
        for (j = 0; j < 8; j++)
            foot += !memcmp(d.decoder->channel[0] + 3 * k, scene.position + 3 * (7 * 15 + 3 + j), 3 * sizeof(cq_value));
    }
    CHECK_EQ(foot, 16);
    decoding_free(&d);
    uncode(&c);
}

TEST(the_macros_and_the_function_for_decoder_memory_agree)
{
    cq_shape s;
    uint32_t n;
    begin(15);
    s = scene.input.shape; /* 3 + 1 numbers of vertices, 4 of rows, 1 of faces */
    for (n = 3; n < 60; n++) {
        size_t bytes = (size_t)CQ_DECODER_BYTES(n + 2, 2 * n + 7, 4) + (size_t)CQ_FACE_BYTES(2 * n);
        s.num_vertices = n;
        s.num_faces = 2 * n;
        s.num_boundary_loops = 2;
        s.num_boundary_edges = 7;
        s.num_rows = n + 1;
        s.num_aside_rows = n % 5;
        s.num_aside_faces = n % 7;
        s.metadata_bytes = n % 9;
        s.num_materials = n % 4;
        bytes += (size_t)CQ_MATERIAL_BYTES(n % 4, n % 7);
        bytes += (size_t)CQ_WEDGE_BYTES(2 * n, n + 1, 4) + (size_t)CQ_METADATA_BYTES(n % 9);
        CHECK_EQ(cq_decoder_bytes(&s), bytes + (size_t)CQ_ASIDE_BYTES(n % 7, n % 5, 8, 1));
    }
}

TEST(metadata_travel_with_a_mesh_that_has_nothing_else)
{
    begin(0);
    add_sheet(8, 8, 3, 0);
    add_metadata("stone", 5);
    check_round_trip();
    CHECK_EQ(last.shape.num_rows, 0);
    add_metadata("", 0);
    check_round_trip();
}

/* Two tiles with a common border, which both keep: at each of their levels it has all its vertices. */
static void keep_border(int right, cq_value (*border)[3], size_t *count, uint32_t *base)
{
    coded c;
    decoding d;
    uint32_t k, n = 0;
    cq_bytes in;
    begin(1);
    seed = right ? 5 : 9;
    add_sheet(20, 20, 0, 0);
    for (k = 0; k < scene.input.shape.num_vertices; k++) {
        const uint32_t x = k % 21, y = k / 21, at_border = x == (right ? 0u : 20u);
        scene.position[3 * k] = (cq_value)(8000 + ((int)x - (right ? 0 : 20)) * 200);
        if (at_border) scene.position[3 * k + 1] = (cq_value)(1000 + 300 * y), scene.position[3 * k + 2] = (cq_value)(y * y * 20);
        scene.locked[k] = (uint8_t)at_border;
    }
    scene.input.locked = scene.locked;
    code(&c, &scene.input);
    CHECK_EQ(c.result, CQ_OK);
    *base = c.report->base_vertices;
    decoding_begin(&d, c.bytes, c.size);
    in.data = c.bytes;
    in.size = c.size;
    while (d.decoder->level == 0 && d.result >= 0) d.result = cq_decode(d.decoder, &in, 1);
    for (k = 0; k < d.decoder->mesh.num_vertices; k++) {
        const cq_value *v = d.decoder->channel[0] + 3 * k;
        if (v[0] == 8000) memcpy(border[n++], v, sizeof *border);
    }
    *count = n;
    decoding_free(&d);
    uncode(&c);
}

static int compare_places(const void *a, const void *b) { return memcmp(a, b, 3 * sizeof(cq_value)); }

TEST(the_locked_borders_of_two_tiles_meet_from_the_base_on)
{
    static cq_value left[500][3], right[500][3];
    size_t in_left, in_right;
    uint32_t base_left, base_right;
    keep_border(0, left, &in_left, &base_left);
    keep_border(1, right, &in_right, &base_right);
    CHECK_EQ(in_left, 21);
    CHECK_EQ(in_right, 21);
    CHECK(base_left < 60 && base_right < 60);
    qsort(left, in_left, sizeof *left, compare_places);
    qsort(right, in_right, sizeof *right, compare_places);
    CHECK(!memcmp(left, right, 21 * sizeof *left));
}

TEST(a_seam_of_texture_coordinates_is_refined)
{
    begin(3);
    add_sheet(20, 16, 3, 0);
    add_seams(3, 2);
    check_round_trip();
    CHECK_EQ(edges_shared, 960);
    CHECK(last.shape.num_rows > last.shape.num_vertices);
    CHECK_EQ(last.shape.num_vertices, 320);
    CHECK(last.base_vertices < 40);
}

/* Rows `first` .. of a channel in 16 bits, and in 8 where these are enough, against those of cq_value. */
static void check_narrow_rows(const cq_decoder *d, uint32_t k, cq_index first, size_t stride)
{
    const size_t n = d->shape.channel[k].components, count = (size_t)(d->num_rows - first);
    const size_t all = count ? (count - 1) * stride + n : 0;
    cq_value *const values = (cq_value *)exact_alloc((count * n + 1) * sizeof(cq_value));
    uint16_t *const words = (uint16_t *)exact_alloc(all * sizeof *words);
    uint8_t *const bytes = (uint8_t *)exact_alloc(all);
    const int narrow = d->shape.channel[k].bits <= 8;
    size_t i;
    memset(words, 0xa5, all * sizeof *words);
    memset(bytes, 0xa5, all);
    cq_read_rows(d, k, first, (cq_index)count, values);
    cq_read_rows_uint16(d, k, first, (cq_index)count, words, stride);
    if (narrow) cq_read_rows_uint8(d, k, first, (cq_index)count, bytes, stride);
    for (i = 0; i < all; i++) {
        const int between = i % stride >= n;
        const cq_value value = values[between ? 0 : i / stride * n + i % stride];
        CHECK_EQ(words[i], between ? 0xa5a5 : value);
        CHECK_EQ(bytes[i], between || !narrow ? 0xa5 : value);
    }
    exact_free(values);
    exact_free(words);
    exact_free(bytes);
}

TEST(rows_come_in_16_and_in_8_bits)
{
    int seams;
    for (seams = 0; seams < 2; seams++) {
        coded c;
        decoding d;
        uint32_t k;
        begin(7);
        add_sheet(20, 16, 3, 0);
        for (k = 0; k < scene.input.shape.num_vertices; k++) scene.joint[k] = (cq_value)(k % 64);
        if (seams) add_seams(3, 2);
        code(&c, &scene.input);
        REQUIRE_EQ(c.result, CQ_OK);
        decoding_begin(&d, c.bytes, c.size);
        REQUIRE_EQ(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT), CQ_DONE);
        CHECK_EQ(d.decoder->vertex != NULL, seams);
        for (k = 0; k < d.decoder->shape.num_channels; k++) {
            check_narrow_rows(d.decoder, k, 0, d.decoder->shape.channel[k].components);
            check_narrow_rows(d.decoder, k, 17, 4);
            check_narrow_rows(d.decoder, k, (cq_index)(d.decoder->num_rows - 1), 9);
            check_narrow_rows(d.decoder, k, d.decoder->num_rows, 4);
        }
        decoding_free(&d);
        uncode(&c);
    }
}

TEST(a_soup_becomes_one_surface)
{
    uint32_t h;
    begin(1);
    add_sheet(20, 16, 3, 0);
    for (h = 0; h < 3 * scene.input.shape.num_faces; h++) scene.index[h] = copy_row(scene.index[h]);
    check_round_trip();
    CHECK_EQ(edges_shared, 960);
    CHECK_EQ(last.shape.num_vertices, 320);
    CHECK_EQ(last.num_components, 1);
}

TEST(flat_faces_have_rows_of_their_own)
{
    uint32_t h;
    begin(3);
    add_sheet(16, 12, 3, 0);
    for (h = 0; h < 3 * scene.input.shape.num_faces; h++) {
        scene.index[h] = copy_row(scene.index[h]);
        scene.normal[2 * scene.index[h]] = (cq_value)(h / 3 * 7 % 1000);
    }
    check_round_trip();
    CHECK_EQ(edges_shared, 576);
    CHECK_EQ(last.shape.num_vertices, 192);
    CHECK_EQ(last.num_components, 1);
    CHECK(last.base_vertices < 30);
}

/* Cards are a sheet and its copy turned over; only that they share all positions tells that they belong together. */
TEST(double_sided_cards_are_closed_surfaces_or_two_sheets)
{
    int k, f, faces;
    begin(1);
    add_sheet(6, 6, 0, 0);
    faces = (int)scene.input.shape.num_faces;
    for (f = 0; f < faces; f++) {
        cq_index corner[3];
        for (k = 0; k < 3; k++) corner[k] = copy_row(scene.index[3 * f + k]);
        for (k = 0; k < 3; k++) scene.normal[2 * corner[k]] = 700;
        add_face(corner[0], corner[2], corner[1]);
    }
    check_round_trip();
    CHECK_EQ(last.shape.num_faces + last.shape.num_aside_faces, 144);
    CHECK_EQ(last.shape.num_aside_faces, 0);
}

/* A fan of 300 faces around one vertex, with seams, and one beside it whose hub is only near. */
TEST(hubs_with_seams_are_refined)
{
    int k;
    begin(3);
    add_row(8000, 8000, 8000);
    for (k = 0; k < 300; k++) add_row(8000 + (k % 75) * 40 - 1500, 8000 + (k / 75 % 2 ? 1500 : -1500) + k, 7000 + (k * 37) % 90);
    for (k = 0; k < 300; k++) add_face(0, (cq_index)(1 + k), (cq_index)(1 + (k + 1) % 300));
    add_seams(4, 3);
    check_round_trip();
    CHECK_EQ(edges_shared, 300);
}

/* Cut along random edges: the faces on one side get rows of their own, at places that differ by one step, so that nothing
 * joins them. */
TEST(random_cuts_stay_open)
{
    int k;
    for (k = 0; k < 6; k++) {
        uint32_t h, cut = 0;
        seed = 77u + (uint32_t)k;
        begin(3);
        add_sheet(12, 10, k & 3, 0);
        for (h = 0; h < 3 * scene.input.shape.num_faces; h++) {
            const cq_index v = scene.index[h];
            if (draw(40)) continue;
            scene.index[h] = copy_row(v);
            scene.position[3 * scene.index[h]]++;
            cut++;
        }
        check_round_trip();
        CHECK(cut > 0 && last.shape.num_boundary_loops > 0);
    }
}

TEST(a_moebius_strip_is_cut_once)
{
    begin(0);
    add_sheet(24, 4, 1, 1);
    check_round_trip();
    CHECK_EQ(edges_shared, 0); /* the cut */
    CHECK_EQ(last.num_components, 1);
    CHECK_EQ(last.prepared.copied_rows, 5);
    CHECK(last.base_vertices < 40);
}

TEST(turned_faces_are_turned_back)
{
    int k;
    begin(1);
    add_sheet(20, 16, 3, 0);
    for (k = 0; k < 40; k++) damage(1, 8);
    check_round_trip();
    CHECK_EQ(edges_shared, 960);
    CHECK(last.prepared.turned_faces > 0);
    CHECK_EQ(last.num_components, 1);
    CHECK_EQ(last.prepared.cut_edges, 0);
}

/* That faces were turned takes a channel: if all are taken, they stay as they are, and edges beside them are open. */
TEST(without_a_channel_left_no_face_is_turned)
{
    int k;
    for (k = 0; k < 2; k++) {
        begin(1);
        seed = 5;
        add_sheet(20, 16, 3, 0);
        while (scene.input.shape.num_channels + !k < CQ_MAX_CHANNELS) add_channel(CQ_GENERIC, 2, 12, CQ_AVERAGE, scene.uv);
        damage(9, 8);
        damage(9, 8);
        damage(9, 8);
        check_round_trip();
        CHECK_EQ(last.prepared.turned_faces > 0, !k);
        CHECK_EQ(last.shape.num_boundary_edges > 0, k);
    }
}

TEST(what_is_no_surface_comes_back)
{
    begin(11);
    add_sheet(12, 12, 0, 0);
    damage(60, 0x96);
    check_round_trip();
    CHECK(last.prepared.repeated_faces > 0);
    CHECK(last.prepared.degenerate_faces > 0);
    CHECK(last.prepared.unused_rows > 0);
    CHECK_EQ(last.shape.num_faces, 288);
}

/* Triangles of any rows at four to seven places: edges of many faces, faces more than once, edges that would join a vertex
 * to itself, and pairs of edges that join the same two vertices. */
TEST(random_triangles_at_few_places_come_back)
{
    uint32_t k, n, detached = 0, glued = 0;
    for (k = 0; k < 400 && !test_state.failures; k++) {
        const uint32_t places = 4 + k % 4, rows = places + k / 4 % 9;
        seed = k * 2654435761u + 7;
        begin((int)(k % 64));
        for (n = 0; n < rows; n++) {
            const int32_t place = (int32_t)(n % places);
            add_row(500 * place, 300 * (place * place % 5), 700 * (place * 3 % 7));
        }
        for (n = 3 + draw(16); n; n--) {
            const cq_index a = (cq_index)draw(rows), b = (cq_index)draw(rows);
            add_face(a, b, (cq_index)draw(rows));
        }
        check_round_trip();
        detached += last.prepared.detached_faces > 0;
        glued += edges_shared > 0;
    }
    printf("  %d of 400 with faces that were cut off, %d without an open edge that two faces share\n", (int)detached, (int)glued);
    CHECK(detached > 10 && glued > 100);
}

/* A sheet and its other side, whose rows have other normals: no vertex of it is a junction, so few are in the base. */
TEST(a_sheet_with_two_sides_is_simplified)
{
    uint32_t f, v, num_vertices;
    seed = 11;
    begin(1);
    add_sheet(12, 9, 0, 0);
    num_vertices = scene.input.shape.num_vertices;
    for (v = 0; v < num_vertices; v++) scene.normal[2 * copy_row((cq_index)v)] = 100;
    for (f = scene.input.shape.num_faces; f-- > 0;)
        add_face((cq_index)(scene.index[3 * f] + num_vertices), (cq_index)(scene.index[3 * f + 2] + num_vertices),
                 (cq_index)(scene.index[3 * f + 1] + num_vertices));
    add_face(0, 0, 1); /* aside, so that the others are looked at, too */
    check_round_trip();
    CHECK_EQ(last.prepared.locked_vertices, 0);
    CHECK(last.base_vertices <= 20);
}

/* Two faces at four places, each with rows of its own: they meet in one edge, whatever else their rows say. */
TEST(faces_are_joined_by_places_whatever_the_order_of_their_rows)
{
    uint32_t k, v;
    for (k = 0; k < 64; k++) {
        cq_index a, b;
        seed = k * 2654435761u + 3;
        begin(2);
        a = add_row(500, 300, 700);
        b = add_row(600, 900, 400);
        add_face(a, b, add_row(100, 200, 300));
        a = copy_row(a);
        b = copy_row(b);
        add_face(b, a, add_row(900, 800, 700));
        for (v = 0; v < 12; v++) scene.uv[v] = (cq_value)draw(4096);
        check_round_trip();
        CHECK_EQ(last.shape.num_vertices, 4);
        CHECK_EQ(last.shape.num_boundary_edges, 4);
    }
}

/* The quad beyond the middle of a strip has rows of its own there. */
TEST(an_edge_between_rows_is_a_seam)
{
    cq_index row[2];
    int k;
    begin(15);
    add_sheet(4, 1, 0, 0);
    for (k = 0; k < 2; k++) {
        row[k] = copy_row((cq_index)(2 + 5 * k));
        scene.uv[2 * row[k]] ^= 64;
    }
    for (k = 12; k < 18; k++) {
        if (scene.index[k] == 2) scene.index[k] = row[0];
        if (scene.index[k] == 7) scene.index[k] = row[1];
    }
    check_round_trip();
    CHECK_EQ(last.prepared.seam_edges, 1);
    CHECK_EQ(last.prepared.cut_edges, 0);
}

/* As much as there may be, and one byte more. */
TEST(metadata_has_a_largest_size)
{
    static char text[CQ_MAX_METADATA + 1];
    coded c;
    begin(15);
    add_sheet(1, 1, 0, 0);
    add_metadata(text, CQ_MAX_METADATA);
    code(&c, &scene.input);
    CHECK_EQ(c.result, CQ_OK);
    uncode(&c);
    add_metadata(text, CQ_MAX_METADATA + 1);
    code(&c, &scene.input);
    CHECK_EQ(c.result, CQ_ERROR_ARGUMENT);
    uncode(&c);
}

TEST(nothing_but_what_is_aside)
{
    begin(3);
    add_row(1, 2, 3);
    add_row(4, 5, 6);
    add_row(7, 8, 9);
    check_round_trip();
    add_face(0, 0, 1);
    add_face(0, 1, 1);
    check_round_trip();
    CHECK_EQ(last.shape.num_vertices, 0);
    CHECK_EQ(last.shape.num_aside_faces, 2);
    add_face(2, 1, 0);
    add_face(2, 1, 0);
    check_round_trip();
}

TEST(each_material_is_one_range)
{
    int channels;
    for (channels = 32; channels < 64; channels += 3) {
        begin(channels);
        add_sheet(20, 16, channels & 3, 0);
        if (channels & 4) add_sheet(7, 5, 3, 0);
        if (channels & 8) add_seams(3, 3);
        if (channels & 16) damage(20, 0xff);
        check_round_trip();
        CHECK_EQ(last.shape.num_materials, 7);
    }
    scene.input.shape.num_materials = 4;
    scene.material[5] = 4;
    {
        coded c;
        code(&c, &scene.input);
        CHECK_EQ(c.result, CQ_ERROR_VALUE);
        CHECK_EQ(c.place.face, 5);
        uncode(&c);
    }
}

TEST(a_clean_mesh_never_moves_a_row)
{
    begin(3);
    add_sheet(20, 16, 3, 0);
    add_seams(3, 3);
    scene.input.clean = 1;
    check_round_trip();
}

#ifndef CASES
#define CASES 300
#endif

TEST(whatever_comes_in_comes_out)
{
    int k;
    for (k = 0; k < CASES; k++) {
        const uint32_t what = draw(8);
        seed = (uint32_t)k * 2654435761u + 1;
        begin((int)draw(64));
        add_sheet(3 + (int)draw(14), 3 + (int)draw(10), (int)draw(4), what == 1);
        if (draw(3) == 0) add_sheet(3 + (int)draw(4), 3 + (int)draw(4), (int)draw(4), 0);
        if (draw(2)) add_seams((int)draw(8), (int)draw(4));
        if (draw(2)) damage((int)draw(30), (int)draw(256));
        if (draw(8) == 0) damage(400, (int)draw(256));
        scene.input.clean = draw(3) == 0;
        if (draw(4) == 0) add_metadata("names of materials, and whatever else a file says", draw(50));
        scene.input.goal = draw(4) ? CQ_BALANCED : CQ_LEAST_CONNECTIVITY;
        check_round_trip();
        if (test_state.failures) {
            printf("  case %d\n", k);
            break;
        }
    }
}

/* A wheel of six spokes and its other side, all locked; around its hub so many rows take turns. A sheet with seams gives
 * the stream levels, with more vertices and rows. */
static void add_wheel_and_sheet(int rows)
{
    cq_index row[3];
    int k;
    for (k = 0; k < rows; k++) {
        row[k] = add_row(2000, 2000, 2300);
        scene.uv[2 * row[k]] = (cq_value)(1000 * (k + 1));
    }
    for (k = 0; k < 6; k++) add_row(k < 3 ? 1700 + 300 * k : 3200 - 300 * k, k < 3 ? 2200 : 1800, 2000);
    add_row(2000, 2000, 1700);
    for (k = 0; k < 6; k++) {
        const cq_index a = (cq_index)(rows + k), b = (cq_index)(rows + (k + 1) % 6);
        add_face(row[k % rows], a, b);
        add_face((cq_index)(rows + 6), b, a);
    }
    memset(scene.locked, 0, sizeof scene.locked);
    memset(scene.locked, 1, (size_t)rows + 7);
    scene.input.locked = scene.locked;
    add_sheet(14, 14, 0, 0);
    add_seams(3, 3);
}

/* If B gets three spokes that follow each other, both A and B have all rows of A. An encoder does not collapse to more
 * than two such rows: a stream that splits three is corrupt, and the mesh stays as it was. */
TEST(a_split_splits_two_rows_at_most)
{
    int rows, p;
    for (rows = 2; rows <= 3; rows++)
        for (p = 0; p < 3; p++) {
            coded c;
            decoding d;
            cq_decoder *to;
            cq_bytes in;
            cq_index hub, vertices, rows_before;
            begin(2);
            seed = 3;
            add_wheel_and_sheet(rows);
            code(&c, &scene.input);
            REQUIRE_EQ(c.result, CQ_OK);
            decoding_begin(&d, c.bytes, c.size);
            to = d.decoder;
            in.data = c.bytes;
            in.size = c.size;
            do d.result = cq_decode(to, &in, 1);
            while (to->phase != CQI_PATCHES && d.result == CQ_MORE);
            REQUIRE_EQ(d.result, CQ_MORE);
            hub = to->vertex[c.map[0]];
            vertices = to->mesh.num_vertices;
            rows_before = to->num_rows;
            cqi_read_ring(&to->mesh, &to->ring, to->mesh.out[hub]);
            REQUIRE_EQ(to->ring.size, 6);
            CHECK_EQ(cqi_begin_corners(to, p, p + 3), CQ_OK);
            CHECK_EQ(cq_decode(to, &in, 1), rows == 2 ? CQ_MORE : CQ_ERROR_CORRUPT);
            CHECK(to->shape.num_rows > to->seams->num_rows && to->shape.num_vertices > vertices);
            if (rows == 2) {
                REQUIRE_EQ(to->phase, CQI_READ_ROWS);
                CHECK_EQ(cqi_apply_rows(to), CQ_OK);
                CHECK(to->num_rows >= rows_before + 2);
                CHECK_EQ(to->mesh.valence[vertices], 5);
            }
            else CHECK_EQ(to->num_rows, rows_before);
            CHECK_EQ(to->mesh.num_vertices, vertices + (rows == 2));
            CHECK_EQ(cq_mesh_check(&to->mesh, NULL), CQ_OK);
            CHECK(rows_are_valid(to));
            decoding_free(&d);
            uncode(&c);
        }
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_seam_of_texture_coordinates_is_refined);
    RUN(rows_come_in_16_and_in_8_bits);
    RUN(a_soup_becomes_one_surface);
    RUN(flat_faces_have_rows_of_their_own);
    RUN(double_sided_cards_are_closed_surfaces_or_two_sheets);
    RUN(hubs_with_seams_are_refined);
    RUN(random_cuts_stay_open);
    RUN(a_moebius_strip_is_cut_once);
    RUN(turned_faces_are_turned_back);
    RUN(random_triangles_at_few_places_come_back);
    RUN(a_sheet_with_two_sides_is_simplified);
    RUN(faces_are_joined_by_places_whatever_the_order_of_their_rows);
    RUN(an_edge_between_rows_is_a_seam);
    RUN(metadata_has_a_largest_size);
    RUN(without_a_channel_left_no_face_is_turned);
    RUN(what_is_no_surface_comes_back);
    RUN(nothing_but_what_is_aside);
    RUN(each_material_is_one_range);
    RUN(a_clean_mesh_never_moves_a_row);
    RUN(a_junction_is_in_the_base);
    RUN(the_macros_and_the_function_for_decoder_memory_agree);
    RUN(metadata_travel_with_a_mesh_that_has_nothing_else);
    RUN(the_locked_borders_of_two_tiles_meet_from_the_base_on);
    RUN(a_split_splits_two_rows_at_most);
    RUN(whatever_comes_in_comes_out);
    return TEST_END();
}
