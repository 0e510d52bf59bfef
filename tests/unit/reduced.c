/* The smallest decoder: built without regular levels, seams and channels other than positions, it refuses streams that
 * have them, or may have them, at their header. */
#define CQ_NO_ENCODER
#define CQ_NO_REPORTS
#define CQ_NO_QUANTISER
#define CQ_NO_WEDGES
#define CQ_NO_REGULAR
#define CQ_NO_ATTRIBUTES
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "exact.h"
#include "header.h"
#include "test.h"

enum { POSITION_BITS = 12 };

/* The header of a tetrahedron with so many channels, which follow. */
static void put_tetrahedron(header *h, uint32_t num_channels)
{
    put_start(h, 4, 0, 0, 1);
    put(h, num_channels, 1);
}

/* What the header says of its own, to someone who peeks and to a decoder; the same for both. */
static cq_result read_header(const header *h)
{
    uint8_t *bytes = (uint8_t *)exact_copy(h->bytes, h->size), *memory = (uint8_t *)exact_alloc(8192);
    cq_decoder *d = (cq_decoder *)exact_alloc(sizeof *d);
    cq_bytes in;
    cq_shape shape;
    cq_result result = cq_peek(bytes, h->size, &shape, NULL, NULL), decoded;
    in.data = bytes;
    in.size = h->size;
    CHECK_EQ(cq_decoder_init(d, memory, 8192), CQ_OK);
    decoded = cq_decode(d, &in, CQ_NO_LIMIT);
    CHECK_EQ(decoded, result == CQ_OK ? CQ_NEED_INPUT : result);
    CHECK_EQ(d->mesh.num_vertices, 0);
    if (result != CQ_OK) CHECK_EQ(cq_decode(d, &in, CQ_NO_LIMIT), result);
    exact_free(d);
    exact_free(memory);
    exact_free(bytes);
    return result;
}

/* The same for a tetrahedron with one channel. */
static cq_result read_channel(uint32_t flags, uint32_t form, uint32_t components, uint32_t bits)
{
    header h;
    put_tetrahedron(&h, flags + 1);
    put_channel(&h, form, components, bits);
    if (flags & EXTENDED) put(&h, 0x01000000, 4), put(&h, 0, 1); /* a byte of metadata */
    put_end(&h, 100);
    return read_header(&h);
}

TEST(positions_and_bare_connectivity_are_read)
{
    header h;
    put_tetrahedron(&h, 0);
    put_end(&h, 100);
    CHECK_EQ(read_header(&h), CQ_OK);
    CHECK_EQ(read_channel(0, CQ_POSITION, 3, POSITION_BITS), CQ_OK);
    CHECK_EQ(read_channel(0, CQ_POSITION + NO_GRID, 3, POSITION_BITS), CQ_OK);
}

TEST(streams_that_may_have_regular_levels_are_unsupported)
{
    header h;
    put_tetrahedron(&h, REGULAR);
    put_end(&h, 100);
    CHECK_EQ(read_header(&h), CQ_ERROR_UNSUPPORTED);
    CHECK_EQ(read_channel(REGULAR, CQ_POSITION, 3, POSITION_BITS), CQ_ERROR_UNSUPPORTED);
}

TEST(streams_with_metadata_seams_or_materials_are_unsupported)
{
    CHECK_EQ(read_channel(EXTENDED, CQ_POSITION, 3, POSITION_BITS), CQ_ERROR_UNSUPPORTED);
}

TEST(streams_with_another_channel_are_unsupported)
{
    static const struct { uint32_t kind, components, bits; } channels[] = {
        { CQ_GENERIC, 1, 8 }, { CQ_NORMAL, 2, 10 }, { CQ_TEXCOORD, 2, 12 }, { CQ_COLOR, 3, 8 }, { CQ_JOINTS, 4, 8 },
        { CQ_WEIGHTS, 4, 8 }, { CQ_NUMBER, 1, 8 }, { CQ_GROUP, 1, 8 }, { CQ_TANGENT, 3, 8 },
        { CQ_POSITION, 3, CQ_EXACT_BITS },
    };
    size_t k;
    for (k = 0; k < sizeof channels / sizeof *channels; ++k) {
        header h;
        const uint32_t kind = channels[k].kind + NO_GRID;
        CHECK_EQ(read_channel(0, kind, channels[k].components, channels[k].bits), CQ_ERROR_UNSUPPORTED);
        put_tetrahedron(&h, 2);
        put_channel(&h, CQ_POSITION, 3, POSITION_BITS);
        put_channel(&h, kind, channels[k].components, channels[k].bits);
        put_end(&h, 100);
        CHECK_EQ(read_header(&h), CQ_ERROR_UNSUPPORTED);
    }
    CHECK_EQ(read_channel(0, CQ_POSITION + 16 * CQ_COPY, 3, POSITION_BITS), CQ_ERROR_UNSUPPORTED);
    CHECK_EQ(read_channel(0, CQ_GROUP + 16 * CQ_PER_FACE, 1, 8), CQ_ERROR_UNSUPPORTED);
    CHECK_EQ(read_channel(0, CQ_TURNED + 16 * CQ_PER_FACE, 1, 1), CQ_ERROR_UNSUPPORTED);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(positions_and_bare_connectivity_are_read);
    RUN(streams_that_may_have_regular_levels_are_unsupported);
    RUN(streams_with_metadata_seams_or_materials_are_unsupported);
    RUN(streams_with_another_channel_are_unsupported);
    return TEST_END();
}
