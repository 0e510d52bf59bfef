/* CQ_ASSERT: every documented precondition that no result reports is checked, on entry, with a condition that says
 * which one it is; and a call that keeps them passes. */
#include <setjmp.h>

static jmp_buf after_the_call;
static const char *tripped;

static inline void trip(const char *condition)
{
    tripped = condition;
    longjmp(after_the_call, 1);
}

#undef CQ_ASSERT
#define CQ_ASSERT(condition) ((condition) ? (void)0 : trip(#condition))
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "test.h"

/* The call must trip over an assertion whose condition contains the words. Variables that change between calls are
 * static, for longjmp. */
#define TRIPS(words, call) \
    do { \
        tripped = "nothing"; \
        if (setjmp(after_the_call) == 0) call; \
        if (strstr(tripped, words) == NULL) \
            printf("  %s trips over %s, expected %s\n", #call, tripped, words), test_state.failures++; \
    } while (0)

#define PASSES(call) TRIPS("nothing", call)

/* -- Levels of detail ---------------------------------------------------------------------------------------------- */

TEST(levels_that_are_asked_for_have_a_place)
{
    static cq_decoder decoder;
    static cq_lod lod;
    static cq_index index;
    PASSES(cq_keep_lods(&decoder, &lod, 1, &index, 1));
    PASSES(cq_keep_lods(&decoder, NULL, 0, NULL, 0));
    TRIPS("lod", cq_keep_lods(&decoder, NULL, 1, &index, 1));
    TRIPS("indices", cq_keep_lods(&decoder, &lod, 1, NULL, 1));
}

/* -- What a decoder has -------------------------------------------------------------------------------------------- */

TEST(rows_faces_and_materials_are_those_that_are_there)
{
    static cq_decoder d;
    static cq_value values[2 * 3], to[2 * 3];
    static cq_index index[3], triangle[3], begin, count;
    static uint8_t moved[1], bytes[6];
    static uint16_t words[6];
    d.shape.num_channels = 1;
    d.shape.channel[0].components = 3;
    d.channel[0] = values;
    d.index = index;
    d.num_rows = 2;
    d.mesh.num_faces = 1;
    PASSES(cq_read_rows(&d, 0, 0, 2, to));
    PASSES(cq_read_rows(&d, 0, 2, 0, to));
    TRIPS("num_channels", cq_read_rows(&d, 1, 0, 1, to));
    TRIPS("first", cq_read_rows(&d, 0, 3, 0, to));
    TRIPS("count", cq_read_rows(&d, 0, 1, 2, to));
    TRIPS("count", cq_read_rows(&d, 0, 1, CQ_NONE, to));
    d.shape.channel[0].bits = 8;
    PASSES(cq_read_rows_uint8(&d, 0, 0, 2, bytes, 3));
    PASSES(cq_read_rows_uint8(&d, 0, 2, 0, bytes, 3));
    TRIPS("num_channels", cq_read_rows_uint8(&d, 1, 0, 1, bytes, 3));
    TRIPS("first", cq_read_rows_uint8(&d, 0, 3, 0, bytes, 3));
    TRIPS("count", cq_read_rows_uint8(&d, 0, 1, 2, bytes, 3));
    TRIPS("stride", cq_read_rows_uint8(&d, 0, 0, 1, bytes, 2));
    d.shape.channel[0].bits = 9;
    TRIPS("bits", cq_read_rows_uint8(&d, 0, 0, 1, bytes, 3));
    d.shape.channel[0].bits = 16;
    PASSES(cq_read_rows_uint16(&d, 0, 0, 2, words, 3));
    PASSES(cq_read_rows_uint16(&d, 0, 2, 0, words, 3));
    TRIPS("num_channels", cq_read_rows_uint16(&d, 1, 0, 1, words, 3));
    TRIPS("first", cq_read_rows_uint16(&d, 0, 3, 0, words, 3));
    TRIPS("count", cq_read_rows_uint16(&d, 0, 1, 2, words, 3));
    TRIPS("stride", cq_read_rows_uint16(&d, 0, 0, 1, words, 2));
    d.shape.channel[0].bits = 17;
    TRIPS("bits", cq_read_rows_uint16(&d, 0, 0, 1, words, 3));
    d.shape.channel[0].bits = CQ_EXACT_BITS;
    TRIPS("bits", cq_read_rows_uint16(&d, 0, 0, 1, words, 3));
    PASSES(cq_read_triangles(&d, 0, 1, triangle));
    PASSES(cq_read_triangles(&d, 1, 0, triangle));
    TRIPS("first", cq_read_triangles(&d, 2, 0, triangle));
    TRIPS("count", cq_read_triangles(&d, 0, 2, triangle));
    PASSES(cq_material(&d, 0, &begin, &count));
    TRIPS("num_materials", cq_material(&d, 1, &begin, &count));
    PASSES(cq_moved_rows(&d, 0, 0, CQ_INDEX_BITS - 1, moved));
    TRIPS("shift", cq_moved_rows(&d, 0, 0, CQ_INDEX_BITS, moved));
    TRIPS("shift", cq_moved_rows(&d, 0, 0, -1, moved));
    TRIPS("rows", cq_moved_rows(&d, 0, 0, 0, NULL));
    PASSES(cq_watch_faces(&d, CQ_INDEX_BITS - 1, moved));
    PASSES(cq_watch_faces(&d, 0, NULL));
    TRIPS("shift", cq_watch_faces(&d, CQ_INDEX_BITS, moved));
}

/* -- Mesh ---------------------------------------------------------------------------------------------------------- */

static cq_mesh mesh;
static uint32_t mesh_memory[256];
static cq_index first, last;
static uint8_t blocks[16];

/* An octahedron, vertices 0 and 5 opposite each other; if it is open, without its last face. */
static void build_octahedron(int open)
{
    static const cq_index faces[] = { 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 5, 2, 1, 5, 3, 2, 5, 4, 3, 5, 1, 4 };
    cq_shape shape;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = 6;
    shape.num_faces = 8 - (uint32_t)open;
    CHECK_EQ(cq_mesh_build(&mesh, &shape, faces, mesh_memory, sizeof mesh_memory, NULL), CQ_OK);
}

static cq_index spoke(cq_index from, cq_index to)
{
    static cq_index h;
    h = mesh.out[from];
    while (cq_target(&mesh, h) != to) h = cq_clockwise(&mesh, h);
    return h;
}

TEST(only_halfedges_of_faces_can_be_asked_about)
{
    build_octahedron(0);
    PASSES(cq_mesh_can_collapse(&mesh, 23, 24));
    TRIPS("cqi_is_face", cq_mesh_can_collapse(&mesh, 24, 24));
    TRIPS("cqi_is_face", cq_mesh_can_collapse(&mesh, CQ_NONE, 24));
}

TEST(only_what_can_be_collapsed_is_collapsed)
{
    static cq_index freed;
    build_octahedron(1);
    TRIPS("can_collapse", cq_mesh_collapse(&mesh, spoke(1, mesh.first_virtual), &first, &last));
    TRIPS("cqi_is_face", cq_mesh_collapse(&mesh, CQ_NONE, &first, &last));
    build_octahedron(0);
    freed = spoke(0, 1);
    PASSES(cq_mesh_collapse(&mesh, freed, &first, &last));
    TRIPS("cqi_is_face", cq_mesh_collapse(&mesh, freed, &first, &last));
    TRIPS("can_collapse", cq_mesh_collapse(&mesh, spoke(0, 3), &first, &last));
}

TEST(spokes_of_a_split_are_two_of_one_vertex)
{
    build_octahedron(0);
    PASSES(cq_mesh_split(&mesh, spoke(0, 1), spoke(0, 3)));  /* there is no room */
    TRIPS("first != last", cq_mesh_split(&mesh, spoke(0, 1), spoke(0, 1)));
    TRIPS("origin[last]", cq_mesh_split(&mesh, spoke(0, 1), spoke(5, 3)));
    TRIPS("cqi_is_face", cq_mesh_split(&mesh, CQ_NONE, spoke(0, 3)));
    TRIPS("cqi_is_face", cq_mesh_split(&mesh, spoke(0, 1), CQ_NONE));
}

TEST(changes_are_of_blocks_and_of_a_mesh_without_gaps)
{
    build_octahedron(0);
    PASSES(cq_mesh_changes(&mesh, 0, 0, blocks));
    PASSES(cq_mesh_changes(&mesh, 0, CQ_INDEX_BITS - 1, blocks));
    TRIPS("shift", cq_mesh_changes(&mesh, 0, -1, blocks));
    TRIPS("shift", cq_mesh_changes(&mesh, 0, CQ_INDEX_BITS, blocks));
    TRIPS("faces", cq_mesh_changes(&mesh, 0, 0, NULL));
    PASSES(cq_mesh_collapse(&mesh, spoke(0, 1), &first, &last));
    TRIPS("free_vertex", cq_mesh_changes(&mesh, 0, 0, blocks));
}

/* -- Range coder --------------------------------------------------------------------------------------------------- */

static cq_range_encoder encoder;
static cq_range_decoder decoder;
static cq_bit_model model;
static uint8_t code[16];

static void begin(void)
{
    cq_range_encoder_init(&encoder, code, sizeof code);
    cq_range_decoder_init(&decoder, code, sizeof code);
    model = CQ_BIT_MODEL_INIT;
}

TEST(a_buffer_without_memory_is_of_size_0)
{
    PASSES(cq_range_encoder_init(&encoder, NULL, 0));
    PASSES(cq_range_decoder_init(&decoder, NULL, 0));
    TRIPS("data", cq_range_encoder_init(&encoder, NULL, 1));
    TRIPS("data", cq_range_decoder_init(&decoder, NULL, 1));
}

TEST(a_coder_is_initialised_before_it_codes)
{
    memset(&encoder, 0, sizeof encoder);
    memset(&decoder, 0, sizeof decoder);
    model = CQ_BIT_MODEL_INIT;
    TRIPS("e->range", cq_encode_bit(&encoder, &model, 4, 1));
    TRIPS("d->range", cq_decode_bit(&decoder, &model, 4));
    TRIPS("e->range", cq_encode_freq(&encoder, 0, 1, 2));
    TRIPS("d->range", cq_decode_slot(&decoder, 2));
}

TEST(rates_are_1_to_8)
{
    static const int wrong[] = { -1, 0, 9, 12 };
    static size_t k;
    static int rate;
    begin();
    for (rate = 1; rate <= 8; ++rate) {
        PASSES(cq_encode_bit(&encoder, &model, rate, 1));
        PASSES(cq_decode_bit(&decoder, &model, rate));
    }
    for (k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        TRIPS("rate", cq_encode_bit(&encoder, &model, wrong[k], 1));
        TRIPS("rate", cq_decode_bit(&decoder, &model, wrong[k]));
    }
}

TEST(models_keep_away_from_0_and_1)
{
    static const cq_bit_model wrong[] = { 0, 65535 };
    static size_t k;
    begin();
    for (k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        model = wrong[k];
        TRIPS("model", cq_encode_bit(&encoder, &model, 4, 1));
        TRIPS("model", cq_decode_bit(&decoder, &model, 4));
    }
    model = 1;
    PASSES(cq_encode_bit(&encoder, &model, 4, 0));
    model = 65534;
    PASSES(cq_decode_bit(&decoder, &model, 4));
}

TEST(frequencies_are_slots_of_their_total)
{
    static const uint32_t wrong[][3] = { { 0, 0, 8 }, { 8, 1, 8 }, { 7, 2, 8 }, { 0, 9, 8 }, { 0, 0, 0 }, { 0, 1, 0 },
                                         { 0xffffffffu, 2, 8 } };
    static size_t k;
    begin();
    PASSES(cq_encode_freq(&encoder, 0, 1, 0x1000000));
    PASSES(cq_encode_freq(&encoder, 0, 8, 8));
    TRIPS("total", cq_encode_freq(&encoder, 0, 1, 0x1000001));
    for (k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        TRIPS("freq", cq_encode_freq(&encoder, wrong[k][0], wrong[k][1], wrong[k][2]));
        begin();
        PASSES(cq_decode_slot(&decoder, 8));
        TRIPS("freq", cq_decode_freq(&decoder, wrong[k][0], wrong[k][1], wrong[k][2]));
    }
}

TEST(a_slot_is_asked_for_before_its_symbol_is_taken)
{
    begin();
    TRIPS("total", cq_decode_slot(&decoder, 0));
    TRIPS("total", cq_decode_slot(&decoder, 0x1000001));
    TRIPS("slot", cq_decode_freq(&decoder, 0, 1, 8));
    PASSES(cq_decode_slot(&decoder, 8));
    TRIPS("slot", cq_decode_freq(&decoder, 0, 1, 16));
    PASSES(cq_decode_freq(&decoder, 0, 1, 8));
    PASSES(cq_decode_slot(&decoder, 8));  /* the first one, as the code is all zeros */
    TRIPS("d->code >=", cq_decode_freq(&decoder, 1, 1, 8));
    code[0] = 0xff;
    begin();
    PASSES(cq_decode_slot(&decoder, 8));
    TRIPS("d->code -", cq_decode_freq(&decoder, 0, 7, 8));
    PASSES(cq_decode_freq(&decoder, 7, 1, 8));
    code[0] = 0;
}

TEST(raw_bits_are_0_to_32)
{
    begin();
    PASSES(cq_encode_raw(&encoder, 0, 0));
    PASSES(cq_encode_raw(&encoder, 0xffffffffu, 32));
    PASSES(cq_decode_raw(&decoder, 32));
    TRIPS("bits", cq_encode_raw(&encoder, 0, -1));
    TRIPS("bits", cq_encode_raw(&encoder, 0, 33));
    TRIPS("bits", cq_decode_raw(&decoder, -1));
    TRIPS("bits", cq_decode_raw(&decoder, 33));
}

/* -- Quantiser ----------------------------------------------------------------------------------------------------- */

static cq_value values[CQ_MAX_COMPONENTS];
static float floats[CQ_MAX_COMPONENTS];

TEST(values_of_1_to_4_components_are_reconstructed)
{
    cq_channel c;
    memset(&c, 0, sizeof c);
    c.bits = 8;
    TRIPS("components", cq_reconstruct(&c, values, 1, floats));
    c.components = CQ_MAX_COMPONENTS + 1;
    TRIPS("components", cq_reconstruct(&c, values, 1, floats));
    c.components = CQ_MAX_COMPONENTS;
    PASSES(cq_reconstruct(&c, values, 1, floats));
    PASSES(cq_reconstruct(&c, NULL, 0, NULL));
    PASSES(cq_channel_step(&c));
    TRIPS("channel", cq_channel_step(NULL));
    PASSES(cq_channel_origin(&c, CQ_MAX_COMPONENTS - 1));
    TRIPS("component", cq_channel_origin(&c, CQ_MAX_COMPONENTS));
    TRIPS("component", cq_channel_origin(&c, -1));
    TRIPS("channel", cq_channel_origin(NULL, 0));
    TRIPS("from", cq_reconstruct(&c, NULL, 1, floats));
    TRIPS("to", cq_reconstruct(&c, values, 1, NULL));
}

TEST(normals_have_2_bits_or_more)
{
    PASSES(cq_reconstruct_normals(2, values, 1, floats));
    PASSES(cq_reconstruct_normals(CQ_MAX_BITS, NULL, 0, NULL));
    TRIPS("bits", cq_reconstruct_normals(1, values, 1, floats));
    TRIPS("bits", cq_reconstruct_normals(CQ_MAX_BITS + 1, values, 1, floats));
    TRIPS("from", cq_reconstruct_normals(8, NULL, 1, floats));
    TRIPS("to", cq_reconstruct_normals(8, values, 1, NULL));
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(levels_that_are_asked_for_have_a_place);
    RUN(rows_faces_and_materials_are_those_that_are_there);
    RUN(only_halfedges_of_faces_can_be_asked_about);
    RUN(only_what_can_be_collapsed_is_collapsed);
    RUN(spokes_of_a_split_are_two_of_one_vertex);
    RUN(changes_are_of_blocks_and_of_a_mesh_without_gaps);
    RUN(a_buffer_without_memory_is_of_size_0);
    RUN(a_coder_is_initialised_before_it_codes);
    RUN(rates_are_1_to_8);
    RUN(models_keep_away_from_0_and_1);
    RUN(frequencies_are_slots_of_their_total);
    RUN(a_slot_is_asked_for_before_its_symbol_is_taken);
    RUN(raw_bits_are_0_to_32);
    RUN(values_of_1_to_4_components_are_reconstructed);
    RUN(normals_have_2_bits_or_more);
    return TEST_END();
}
