/* Headers: what cq_peek tells, every prefix, every damage; sizes of memory; result strings. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "header.h"
#include "sample.h"
#include "test.h"

static cq_result peek(const header *h, cq_shape *shape)
{
    uint8_t *bytes = (uint8_t *)exact_copy(h->bytes, h->size);
    cq_result result = cq_peek(bytes, h->size, shape, NULL, NULL);
    exact_free(bytes);
    return result;
}

/* What the decoder says to a stream that starts with the header, given plenty of small memory. */
static cq_result decode(const header *h)
{
    decoding d;
    cq_result result;
    decoding_begin_with(&d, 4096);
    result = decoding_run(&d, h->bytes, h->size, h->size, CQ_NO_LIMIT);
    decoding_free(&d);
    return result;
}

/* -- Tests --------------------------------------------------------------------------------------------------------- */

TEST(a_header_tells_the_shape_that_was_encoded)
{
    int which;
    for (which = 0; which < SAMPLES; ++which) {
        sample s;
        coded c;
        cq_shape shape;
        size_t header_bytes = 0, stream_bytes = 0;
        uint32_t k, j;
        REQUIRE_EQ(sample_code(&s, &c, which), CQ_OK);
        CHECK_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, &stream_bytes), CQ_OK);
        CHECK_EQ(stream_bytes, c.size);
        CHECK(header_bytes <= c.size);
        CHECK(header_bytes <= CQ_MAX_HEADER_BYTES);
        CHECK_EQ(shape.num_vertices, s.mesh.num_vertices);
        CHECK_EQ(shape.num_faces, s.mesh.num_faces);
        CHECK_EQ(shape.num_boundary_loops, c.shape.num_boundary_loops);
        CHECK_EQ(shape.num_boundary_edges, c.shape.num_boundary_edges);
        REQUIRE_EQ(shape.num_channels, s.input.shape.num_channels);
        for (k = 0; k < shape.num_channels; ++k) {
            const cq_channel *a = &shape.channel[k], *b = &s.input.shape.channel[k];
            CHECK_EQ(a->kind, b->kind);
            CHECK_EQ(a->components, b->components);
            CHECK_EQ(a->bits, b->bits);
            CHECK_EQ(a->merge, b->merge);
            CHECK_EQ(a->step, b->step);
            for (j = 0; j < b->components; ++j) CHECK_EQ(a->origin[j], b->origin[j]);
        }
        uncode(&c);
        sample_free(&s);
    }
}

TEST(every_part_of_a_header_needs_more_input_and_every_longer_piece_is_enough)
{
    int which;
    for (which = 0; which < SAMPLES; ++which) {
        sample s;
        coded c;
        cq_shape shape;
        size_t header_bytes = 0, size, got, total;
        REQUIRE_EQ(sample_code(&s, &c, which), CQ_OK);
        CHECK_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
        for (size = 0; size <= c.size; ++size) {
            uint8_t *piece = (uint8_t *)exact_copy(c.bytes, size);
            cq_result result = cq_peek(piece, size, &shape, &got, &total);
            CHECK_EQ(result, size < header_bytes ? CQ_NEED_INPUT : CQ_OK);
            if (result == CQ_OK) CHECK_EQ(got, header_bytes);
            if (result == CQ_OK) CHECK_EQ(total, c.size);
            exact_free(piece);
        }
        uncode(&c);
        sample_free(&s);
    }
}

TEST(nothing_at_all_needs_more_input)
{
    cq_shape shape;
    CHECK_EQ(cq_peek(NULL, 0, &shape, NULL, NULL), CQ_NEED_INPUT);
}

TEST(null_arguments_of_peek_are_an_error)
{
    static const uint8_t bytes[] = {'C', 'Q', 0};
    cq_shape shape;
    CHECK_EQ(cq_peek(bytes, 3, NULL, NULL, NULL), CQ_ERROR_ARGUMENT);
    CHECK_EQ(cq_peek(NULL, 3, &shape, NULL, NULL), CQ_ERROR_ARGUMENT);
}

TEST(a_wrong_magic_is_not_a_stream_at_any_length)
{
    sample s;
    coded c;
    size_t size;
    int at, byte;
    REQUIRE_EQ(sample_code(&s, &c, 1), CQ_OK);
    for (at = 0; at < 2; ++at) {
        for (byte = 0; byte < 256; ++byte) {
            cq_shape shape;
            uint8_t right = c.bytes[at];
            if (byte == right) continue;
            c.bytes[at] = (uint8_t)byte;
            for (size = (size_t)at + 1; size < 20; ++size)
                CHECK_EQ(cq_peek(c.bytes, size, &shape, NULL, NULL), CQ_ERROR_FORMAT);
            CHECK_EQ(cq_peek(c.bytes, c.size, &shape, NULL, NULL), CQ_ERROR_FORMAT);
            c.bytes[at] = right;
        }
    }
    uncode(&c);
    sample_free(&s);
}

TEST(another_version_is_not_known)
{
    sample s;
    coded c;
    int version;
    REQUIRE_EQ(sample_code(&s, &c, 1), CQ_OK);
    for (version = 0; version < 256; ++version) {
        cq_shape shape;
        if (version == CQ_STREAM_VERSION) continue;
        c.bytes[2] = (uint8_t)version;
        CHECK_EQ(cq_peek(c.bytes, 3, &shape, NULL, NULL), CQ_ERROR_VERSION);
        CHECK_EQ(cq_peek(c.bytes, c.size, &shape, NULL, NULL), CQ_ERROR_VERSION);
    }
    uncode(&c);
    sample_free(&s);
}

TEST(a_wrong_check_value_of_the_header_is_found)
{
    sample s;
    coded c;
    size_t header_bytes;
    int bit;
    cq_shape shape;
    REQUIRE_EQ(sample_code(&s, &c, 2), CQ_OK);
    REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
    for (bit = 0; bit < 16; ++bit) {
        uint8_t *byte = &c.bytes[header_bytes - 2 + (size_t)bit / 8];
        *byte = (uint8_t)(*byte ^ 1 << bit % 8);
        CHECK_EQ(cq_peek(c.bytes, c.size, &shape, NULL, NULL), CQ_ERROR_CHECKSUM);
        *byte = (uint8_t)(*byte ^ 1 << bit % 8);
    }
    uncode(&c);
    sample_free(&s);
}

TEST(no_flipped_bit_in_a_header_goes_unnoticed)
{
    int which;
    for (which = 0; which < SAMPLES; ++which) {
        sample s;
        coded c;
        size_t header_bytes, bit;
        cq_shape shape;
        REQUIRE_EQ(sample_code(&s, &c, which), CQ_OK);
        REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
        for (bit = 0; bit < 8 * header_bytes; ++bit) {
            decoding d;
            c.bytes[bit / 8] = (uint8_t)(c.bytes[bit / 8] ^ 1 << bit % 8);
            CHECK(cq_peek(c.bytes, c.size, &shape, NULL, NULL) != CQ_OK);
            decoding_begin_with(&d, 65536);
            CHECK(decoding_run(&d, c.bytes, c.size, c.size, CQ_NO_LIMIT) != CQ_DONE);
            CHECK_EQ(d.decoder->mesh.num_vertices, 0);
            decoding_free(&d);
            c.bytes[bit / 8] = (uint8_t)(c.bytes[bit / 8] ^ 1 << bit % 8);
        }
        uncode(&c);
        sample_free(&s);
    }
}

TEST(a_header_by_hand_is_understood)
{
    header h;
    cq_shape shape;
    put_start(&h, 300, 2, 17, -3);
    put(&h, 2, 1);
    put_channel(&h, CQ_POSITION, 3, 12);
    put_channel(&h, CQ_GENERIC, 1, 8);
    put_end(&h, 1000);
    REQUIRE_EQ(peek(&h, &shape), CQ_OK);
    CHECK_EQ(shape.num_vertices, 300);
    CHECK_EQ(shape.num_boundary_loops, 2);
    CHECK_EQ(shape.num_boundary_edges, 17);
    CHECK_EQ(shape.num_faces, 2 * (300 + 2) + 4 * 3 - 17);
    CHECK_EQ(shape.num_channels, 2);
    CHECK_EQ(shape.channel[0].bits, 12);
    CHECK_EQ(shape.channel[1].components, 1);
}

TEST(the_largest_header_fits_its_limit)
{
    sample s;
    coded c;
    cq_shape shape;
    size_t header_bytes;
    int k;
    sample_begin(&s, triangles_icosahedron());
    for (k = 0; k < CQ_MAX_CHANNELS; ++k) sample_channel(&s, CQ_GENERIC, CQ_MAX_COMPONENTS, CQ_MAX_BITS);
    code(&c, &s.input);
    REQUIRE_EQ(c.result, CQ_OK);
    REQUIRE_EQ(cq_peek(c.bytes, c.size, &shape, &header_bytes, NULL), CQ_OK);
    CHECK(header_bytes + 20 <= CQ_MAX_HEADER_BYTES);   /* counts of 5 bytes each instead of 1 */
    uncode(&c);
    sample_free(&s);
}

TEST(counts_that_no_closed_surface_has_are_corrupt)
{
    static const struct { uint32_t v, loops, edges; int32_t euler; } bad[] = {
        {4, 0, 0, 3},            /* 2 * 4 - 4 * 3 < 0 faces */
        {4, 1, 2, 1},            /* a loop of two edges */
        {10, 3, 8, 1},           /* three loops of less than nine */
        {4, 1, 0xffffffffu, 1},  /* more boundary edges than faces can have */
        {0xffffffffu, 0, 0, -0x40000000}, {0, 0, 0, 1}};
    size_t k;
    for (k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
        header h;
        cq_shape shape;
        put_start(&h, bad[k].v, bad[k].loops, bad[k].edges, bad[k].euler);
        put(&h, 0, 1);
        put_end(&h, 10);
        CHECK(peek(&h, &shape) == CQ_ERROR_CORRUPT);
        CHECK(decode(&h) == CQ_ERROR_CORRUPT);
    }
}

TEST(as_many_faces_as_32_bits_can_count_are_a_shape)
{
    header h;
    cq_shape shape;
    put_start(&h, 0x80000000u, 1, 3, 0);
    put(&h, 0, 1);
    put_end(&h, 10);
    CHECK_EQ(peek(&h, &shape), CQ_OK);
    CHECK_EQ(shape.num_faces, 0xffffffffu);
    put_start(&h, 0x80000001u, 1, 4, 0);
    put(&h, 0, 1);
    put_end(&h, 10);
    CHECK_EQ(peek(&h, &shape), CQ_ERROR_CORRUPT);
}

TEST(huge_counts_are_refused_before_any_work)
{
    static const uint32_t huge[] = {0x7fffffffu, 0xffffffffu, 100000000u, 21846u, 1000u};
    size_t k;
    for (k = 0; k < sizeof huge / sizeof huge[0]; ++k) {
        header h;
        cq_result result;
        put_start(&h, huge[k], 0, 0, 1);
        put(&h, 0, 1);
        put_end(&h, 10);
        result = decode(&h);
        CHECK(result == CQ_ERROR_MEMORY || result == CQ_ERROR_TOO_LARGE || result == CQ_ERROR_CORRUPT);
    }
}

TEST(a_number_that_is_not_in_its_shortest_form_is_corrupt)
{
    static const uint8_t long_forms[][6] = {{0x84, 0x00}, {0x84, 0x80, 0x00}, {0xff, 0xff, 0xff, 0xff, 0x10},
                                            {0xff, 0xff, 0xff, 0xff, 0xff, 0x01}, {0x80, 0x80, 0x80, 0x80, 0x00}};
    static const size_t sizes[] = {2, 3, 5, 6, 5};
    size_t k, j;
    for (k = 0; k < 5; ++k) {
        header h;
        cq_shape shape;
        h.size = 0;
        put(&h, 'C', 1);
        put(&h, 'Q', 1);
        put(&h, CQ_STREAM_VERSION, 1);
        for (j = 0; j < sizes[k]; ++j) put(&h, long_forms[k][j], 1);
        put(&h, 0, 3);
        put_end(&h, 10);
        CHECK_EQ(peek(&h, &shape), CQ_ERROR_CORRUPT);
    }
}

/* The table of SPEC.md, by hand. */
static int is_channel(uint32_t form, uint32_t components, uint32_t bits)
{
    static const char *const components_of[] = {"3", "1234", "23", "2", "34", "1234", "1234", "1", "1", "1", "234"};
    uint32_t kind = form % 16, merge = (form & ~(uint32_t)NO_GRID) / 16;
    if (kind == 9) return merge == 2 && components == 1 && bits == 1;
    if (kind > 10 || merge > 2 || components < 1 || components > 4) return 0;
    if (!strchr(components_of[kind], (int)('0' + components)) || (merge == 2 && components != 1)) return 0;
    return (bits >= 1 && bits <= 24) || bits == 32;
}

TEST(exactly_the_channels_of_the_specification_are_supported)
{
    uint32_t form, components, bits, count = 0;
    for (form = 0; form < 256; ++form) {
        for (components = 0; components < 6; ++components) {
            for (bits = 0; bits < 40; ++bits) {
                header h;
                cq_shape shape;
                int good = is_channel(form, components, bits);
                cq_result result;
                put_start(&h, 4, 0, 0, 1);
                put(&h, 1, 1);
                put_channel(&h, form, components > 4 ? 4 : components, bits);
                if (components > 4) h.bytes[h.size - (form & NO_GRID ? 0 : 4 * 4 + 4) - 2] = (uint8_t)components;
                put_end(&h, 10);
                result = peek(&h, &shape);
                CHECK_EQ(result, good ? CQ_OK : CQ_ERROR_UNSUPPORTED);
                if (result != CQ_OK) continue;
                CHECK_EQ(shape.channel[0].kind, form % 16);
                CHECK_EQ(shape.channel[0].merge, form / 16 & 3);
                CHECK_EQ(shape.channel[0].step == 0 && shape.channel[0].origin[0] == 0, (form & NO_GRID) != 0);
                CHECK_EQ(shape.channel[0].components, components);
                CHECK_EQ(shape.channel[0].bits, bits);
                count++;
            }
        }
    }
    /* With and without a grid: 23 of all components and kinds, 5 have one component, 1 one bit. */
    CHECK_EQ(count, 2 * ((23 + 23 + 5) * 25 + 1));
}

TEST(channels_that_do_not_exist_are_not_supported)
{
    static const struct { uint32_t kind, components, bits; } bad[] = {
        {9, 1, 8}, {255, 1, 8}, {CQ_GENERIC, 0, 8}, {CQ_GENERIC, 5, 8}, {CQ_GENERIC, 255, 8}, {CQ_GENERIC, 1, 0},
        {CQ_GENERIC, 1, 25}, {CQ_GENERIC, 1, 255}, {CQ_POSITION, 2, 8}, {CQ_POSITION, 4, 8}, {CQ_POSITION, 3, 33}};
    size_t k;
    for (k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
        header h;
        cq_shape shape;
        put_start(&h, 4, 0, 0, 1);
        put(&h, 1, 1);
        put_channel(&h, bad[k].kind, bad[k].components > 4 ? 4 : bad[k].components, bad[k].bits);
        if (bad[k].components > 4) h.bytes[h.size - 4 * 4 - 4 - 2] = (uint8_t)bad[k].components;
        put_end(&h, 10);
        CHECK_EQ(peek(&h, &shape), CQ_ERROR_UNSUPPORTED);
        CHECK_EQ(decode(&h), CQ_ERROR_UNSUPPORTED);
    }
}

TEST(more_channels_than_there_may_be_are_not_supported)
{
    uint32_t n;
    for (n = 0; n < 256; ++n) {
        header h;
        cq_shape shape;
        uint32_t k, m = n % 64, regular = n / 64 % 2;
        put_start(&h, 4, 0, 0, 1);
        put(&h, n, 1);
        for (k = 0; k < m && k < CQ_MAX_CHANNELS; ++k) put_channel(&h, CQ_GENERIC, 1, 8);
        if (n >= 128) put(&h, 0x00010500, 4), put(&h, 0, 1); /* no seams, five rows and a face aside, no metadata, no materials */
        put_end(&h, 10);
        CHECK_EQ(peek(&h, &shape), m <= CQ_MAX_CHANNELS ? CQ_OK : CQ_ERROR_UNSUPPORTED);
        CHECK_EQ(shape.num_channels, m <= CQ_MAX_CHANNELS ? m : 0);
        CHECK_EQ(shape.regular, regular);
        if (m <= CQ_MAX_CHANNELS) CHECK_EQ(shape.num_aside_rows, n >= 128 ? 5 : 0);
    }
}

TEST(regular_levels_have_any_channels_and_rows)
{
    static const struct { uint32_t kind, merge, components, bits; } channels[] = {
        { CQ_POSITION, CQ_AVERAGE, 3, 12 },
        { CQ_POSITION, CQ_COPY, 3, 12 },
        { CQ_POSITION, CQ_AVERAGE, 3, CQ_EXACT_BITS },
        { CQ_NUMBER, CQ_PER_FACE, 1, 1 },
    };
    uint32_t k, count, rows;
    for (k = 0; k < sizeof channels / sizeof channels[0]; ++k)
        for (count = 0; count < 3; ++count)
            for (rows = 0; rows < 2; ++rows) {
                header h;
                cq_shape shape;
                uint32_t n;
                put_start(&h, 4, 0, 0, 1);
                put(&h, REGULAR + EXTENDED * rows + count, 1);
                for (n = 0; n < count; ++n)
                    put_channel(&h, channels[k].kind | channels[k].merge << 4, channels[k].components, channels[k].bits);
                if (rows) put(&h, 5, 4), put(&h, 0, 1); /* five rows, nothing aside, no metadata, no materials */
                put_end(&h, 10);
                CHECK_EQ(peek(&h, &shape), CQ_OK);
                CHECK_EQ(shape.num_rows, rows ? 5 : 0);
                CHECK_EQ(shape.regular, 1);
            }
}

/* An insertion may have the values of two rows in a step. */
TEST(regular_levels_with_rows_have_as_many_components_as_a_step_may)
{
    uint32_t colors;
    for (colors = 1; colors <= CQ_MAX_CHANNELS; ++colors) {
        header h;
        cq_shape shape;
        uint32_t n;
        put_start(&h, 4, 0, 0, 1);
        put(&h, REGULAR + EXTENDED + colors, 1);
        for (n = 0; n < colors; ++n) put_channel(&h, CQ_COLOR, 4, 8);
        put(&h, 5, 4), put(&h, 0, 1);
        put_end(&h, 10);
        CHECK_EQ(peek(&h, &shape), 8 * colors <= CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS ? CQ_OK : CQ_ERROR_UNSUPPORTED);
    }
}

/* A stream of a mesh of so many vertices and five numbers: rows, rows and faces aside, bytes of metadata, materials. */
static header of_numbers(uint32_t vertices, const uint32_t *numbers)
{
    header h;
    int k;
    put_start(&h, vertices, 0, 0, vertices > 0);
    put(&h, EXTENDED, 1);
    for (k = 0; k < 5; ++k) put_varint(&h, numbers[k]);
    put_varint(&h, 0);
    put(&h, 0, 4);
    put(&h, crc32(h.bytes, h.size), 2);
    return h;
}

/* A stream of nothing but rows aside and a mesh of so many vertices. */
static header of_rows_aside(uint32_t vertices, uint32_t rows)
{
    uint32_t numbers[5] = { 0, 0, 0, 0, 0 };
    numbers[1] = rows;
    return of_numbers(vertices, numbers);
}

TEST(numbers_that_no_encoder_writes_are_corrupt)
{
    static const struct { uint32_t numbers[5]; cq_result result; } cases[] = {
        { { 0, 0, 0, 0, 0 }, CQ_ERROR_CORRUPT },                    /* then there would be none of them */
        { { 0, 0, 0, 0, 1 }, CQ_ERROR_CORRUPT },                    /* one material is none */
        { { 0, 0, 0, 0, 2 }, CQ_OK },
        { { 0, 0, 0, 0, CQ_MAX_MATERIALS }, CQ_OK },
        { { 0, 0, 0, 0, CQ_MAX_MATERIALS + 1 }, CQ_ERROR_CORRUPT },
        { { 0, 0, 0, CQ_MAX_METADATA, 0 }, CQ_OK },
        { { 0, 0, 0, CQ_MAX_METADATA + 1, 0 }, CQ_ERROR_CORRUPT },
        { { 4, 0, 0, 0, 0 }, CQ_ERROR_CORRUPT },                    /* as many rows as vertices need no rows */
        { { 5, 0, 0, 0, 0 }, CQ_OK },
        { { 12, 0, 0, 0, 0 }, CQ_OK },                              /* as many as corners */
        { { 13, 0, 0, 0, 0 }, CQ_ERROR_CORRUPT },
    };
    size_t k;
    for (k = 0; k < sizeof cases / sizeof *cases; ++k) {
        const header h = of_numbers(4, cases[k].numbers);
        cq_shape shape;
        CHECK_EQ(peek(&h, &shape), cases[k].result);
    }
}

/* A face aside names rows, of which there is none. */
TEST(a_face_aside_needs_a_row)
{
    static const uint32_t numbers[5] = { 0, 0, 1, 0, 0 };
    const header h = of_numbers(0, numbers);
    cq_decoder d;
    cq_bytes in;
    uint32_t memory[1024];
    in.data = h.bytes;
    in.size = h.size;
    CHECK_EQ(cq_decoder_init(&d, memory, sizeof memory), CQ_OK);
    CHECK_EQ(cq_decode(&d, &in, CQ_NO_LIMIT), CQ_ERROR_CORRUPT);
    CHECK_EQ(d.aside.num_faces, 0);
}

TEST(rows_aside_without_values_take_no_time)
{
    const uint32_t many = CQ_INDEX_BITS == 16 ? 0xffff : 0xffffffff;
    const header h = of_rows_aside(0, many);
    cq_decoder d;
    cq_bytes in = { h.bytes, h.size };
    uint32_t memory[1024];
    cq_result result = CQ_MORE;
    int steps = 0;
    cq_decoder_init(&d, memory, sizeof memory);
    for (; steps < 10 && result == CQ_MORE; ++steps) result = cq_decode(&d, &in, 1);
    CHECK_EQ(result, CQ_DONE);
    CHECK_EQ(d.aside.num_rows, many);
}

TEST(rows_and_rows_aside_are_no_more_than_can_be_numbered)
{
    const uint32_t many = CQ_INDEX_BITS == 16 ? 0xffff : 0xffffffff;
    header most = of_rows_aside(4, many - 4), more = of_rows_aside(4, many - 3);
    cq_shape shape;
    CHECK_EQ(peek(&most, &shape), CQ_OK);
    CHECK(cq_decoder_bytes(&shape) > 0);
    CHECK_EQ(peek(&more, &shape), CQ_OK);
    CHECK_EQ(cq_decoder_bytes(&shape), 0);
    CHECK_EQ(decode(&more), CQ_ERROR_TOO_LARGE);
}

#if CQ_INDEX_BITS == 16
TEST(sixteen_bit_builds_do_not_support_values_of_more_than_fifteen_bits)
{
    header h;
    cq_shape shape;
    put_start(&h, 4, 0, 0, 1);
    put(&h, 1, 1);
    put_channel(&h, CQ_GENERIC, 1, 16);
    put_end(&h, 10);
    CHECK_EQ(peek(&h, &shape), CQ_OK);
    CHECK_EQ(decode(&h), CQ_ERROR_UNSUPPORTED);
    put_start(&h, 4, 0, 0, 1);
    put(&h, 1, 1);
    put_channel(&h, CQ_GENERIC | CQ_COPY << 4, 1, CQ_EXACT_BITS);
    put_end(&h, 10);
    CHECK_EQ(peek(&h, &shape), CQ_OK);
    CHECK_EQ(shape.channel[0].bits, CQ_EXACT_BITS);
    CHECK_EQ(decode(&h), CQ_ERROR_UNSUPPORTED);
}
#endif

TEST(the_macro_and_the_function_for_decoder_memory_agree)
{
    uint32_t v, f, c;
    for (v = 0; v < 60; v += 5) {
        for (f = 0; f < 60; f += 3) {
            for (c = 0; c < 6; ++c) {
                cq_shape shape;
                memset(&shape, 0, sizeof shape);
                shape.num_vertices = v;
                shape.num_faces = f;
                shape.num_boundary_loops = f % 4;
                shape.num_boundary_edges = 3 * (f % 4);
                if (c > 0) {
                    shape.num_channels = c > 3 ? 2 : 1;
                    shape.channel[0].components = (uint8_t)(c > 3 ? c - 3 : c);
                    shape.channel[1].components = 3;
                }
                CHECK_EQ(cq_decoder_bytes(&shape) % 4, 0);
                if (v > 0 && f > 0)
                    CHECK_EQ(cq_decoder_bytes(&shape), CQ_DECODER_BYTES(v + f % 4, f + 3 * (f % 4), c));
                if (c > 3) {
                    shape.channel[0].merge = shape.channel[2].merge = CQ_PER_FACE;
                    shape.channel[0].components = shape.channel[2].components = 1;
                    shape.num_channels = 3;
                    CHECK_EQ(cq_decoder_bytes(&shape),
                             CQ_DECODER_BYTES(v + f % 4, f + 3 * (f % 4), 3) + 2 * CQ_FACE_BYTES(f));
                }
            }
        }
    }
}

TEST(memory_for_counts_that_cannot_be_numbered_is_zero)
{
    cq_shape shape;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 4;
    shape.num_faces = 0xfffffff0u;
    CHECK_EQ(cq_decoder_bytes(&shape), 0);
    CHECK_EQ(cq_encoder_bytes(&shape), 0);
    shape.num_faces = 4;
    shape.num_boundary_edges = 0xffffffffu;
    CHECK_EQ(cq_decoder_bytes(&shape), 0);
    CHECK_EQ(cq_encoder_bytes(&shape), 0);
    shape.num_boundary_edges = 0;
    shape.num_vertices = 0x80000000u;
    shape.num_boundary_loops = 0x80000000u;
    CHECK_EQ(cq_decoder_bytes(&shape), 0);
    CHECK_EQ(cq_encoder_bytes(&shape), 0);
    shape.num_vertices = 4;
    shape.num_boundary_loops = 0;
    CHECK(cq_decoder_bytes(&shape) > 0 && cq_encoder_bytes(&shape) > 0);
    shape.num_aside_faces = CQ_INDEX_BITS == 16 ? 0x5556 : 0x55555556;
    CHECK_EQ(cq_decoder_bytes(&shape), 0);
    CHECK_EQ(cq_encoder_bytes(&shape), 0);
    shape.num_aside_faces = 0;
    shape.num_materials = CQ_MAX_MATERIALS + 1;
    CHECK_EQ(cq_decoder_bytes(&shape), 0);
    CHECK_EQ(cq_encoder_bytes(&shape), 0);
    shape.num_materials = 0;
    shape.num_rows = 0x10000;
    CHECK_EQ(cq_decoder_bytes(&shape) == 0, CQ_INDEX_BITS == 16);
}

TEST(memory_at_most_is_there_for_all_counts_that_can_be_numbered)
{
    const uint32_t limit = CQ_INDEX_BITS == 16 ? 0xffff / 3 : 0xffffffff / 3;
    cq_shape shape;
    memset(&shape, 0, sizeof shape);
    CHECK(cq_encoder_bytes_at_most(&shape) >= cq_encoder_bytes(&shape));
    shape.num_vertices = shape.num_faces = limit;
    CHECK(cq_encoder_bytes_at_most(&shape) > cq_encoder_bytes(&shape));
    shape.num_boundary_edges = shape.num_rows = shape.num_aside_rows = 0xffffffff; /* these are not looked at */
    CHECK(cq_encoder_bytes_at_most(&shape) > 0);
    shape.num_vertices++;
    CHECK_EQ(cq_encoder_bytes_at_most(&shape), 0);
    shape.num_vertices = 4;
    shape.num_faces++;
    CHECK_EQ(cq_encoder_bytes_at_most(&shape), 0);
    shape.num_boundary_edges = shape.num_rows = shape.num_aside_rows = 0;
    shape.num_vertices = 1000; /* far more than corners */
    shape.num_faces = 4;
    CHECK(cq_encoder_bytes_at_most(&shape) >= cq_encoder_bytes(&shape));
}

TEST(memory_for_no_shape_is_zero)
{
    CHECK_EQ(cq_mesh_bytes(NULL), 0);
    CHECK_EQ(cq_decoder_bytes(NULL), 0);
    CHECK_EQ(cq_encoder_bytes(NULL), 0);
    CHECK_EQ(cq_encoder_bytes_at_most(NULL), 0);
}

TEST(memory_for_more_channels_than_there_may_be_is_zero)
{
    static const uint32_t many[] = {CQ_MAX_CHANNELS + 1, 256, 0xffffffffu};
    size_t k;
    for (k = 0; k < 3; ++k) {
        cq_shape *shape = (cq_shape *)exact_alloc(sizeof *shape);
        memset(shape, 0, sizeof *shape);
        shape->num_vertices = 4;
        shape->num_faces = 4;
        shape->num_channels = many[k];
        CHECK_EQ(cq_decoder_bytes(shape), 0);
        CHECK_EQ(cq_encoder_bytes(shape), 0);
        CHECK_EQ(cq_encoder_bytes_at_most(shape), 0);
        exact_free(shape);
    }
}

TEST(every_result_has_a_phrase_of_its_own)
{
    int a, b;
    for (a = CQ_ERROR_CHECKSUM; a <= CQ_MORE; ++a) {
        const char *phrase = cq_result_string((cq_result)a);
        REQUIRE(phrase != NULL);
        CHECK(phrase[0] != 0);
        for (b = CQ_ERROR_CHECKSUM; b < a; ++b) CHECK(strcmp(phrase, cq_result_string((cq_result)b)) != 0);
    }
    CHECK(strcmp(cq_result_string((cq_result)-17), cq_result_string((cq_result)5)) == 0);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(a_header_tells_the_shape_that_was_encoded);
    RUN(every_part_of_a_header_needs_more_input_and_every_longer_piece_is_enough);
    RUN(nothing_at_all_needs_more_input);
    RUN(null_arguments_of_peek_are_an_error);
    RUN(a_wrong_magic_is_not_a_stream_at_any_length);
    RUN(another_version_is_not_known);
    RUN(a_wrong_check_value_of_the_header_is_found);
    RUN(no_flipped_bit_in_a_header_goes_unnoticed);
    RUN(a_header_by_hand_is_understood);
    RUN(the_largest_header_fits_its_limit);
    RUN(counts_that_no_closed_surface_has_are_corrupt);
    RUN(as_many_faces_as_32_bits_can_count_are_a_shape);
    RUN(huge_counts_are_refused_before_any_work);
    RUN(a_number_that_is_not_in_its_shortest_form_is_corrupt);
    RUN(exactly_the_channels_of_the_specification_are_supported);
    RUN(channels_that_do_not_exist_are_not_supported);
    RUN(more_channels_than_there_may_be_are_not_supported);
    RUN(regular_levels_have_any_channels_and_rows);
    RUN(regular_levels_with_rows_have_as_many_components_as_a_step_may);
    RUN(numbers_that_no_encoder_writes_are_corrupt);
    RUN(a_face_aside_needs_a_row);
    RUN(rows_aside_without_values_take_no_time);
    RUN(rows_and_rows_aside_are_no_more_than_can_be_numbered);
#if CQ_INDEX_BITS == 16
    RUN(sixteen_bit_builds_do_not_support_values_of_more_than_fifteen_bits);
#endif
    RUN(the_macro_and_the_function_for_decoder_memory_agree);
    RUN(memory_for_counts_that_cannot_be_numbered_is_zero);
    RUN(memory_at_most_is_there_for_all_counts_that_can_be_numbered);
    RUN(memory_for_no_shape_is_zero);
    RUN(memory_for_more_channels_than_there_may_be_is_zero);
    RUN(every_result_has_a_phrase_of_its_own);
    return TEST_END();
}
