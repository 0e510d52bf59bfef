/* A good stream that is cut anywhere gives a mesh on the way to the full one, and CQ_TRUNCATED; never an error. More
 * bytes never give fewer vertices. */
#include "surface.h"

/* Decodes the first `size` bytes and then, from the start, as many steps of the whole stream as give as many
 * vertices. */
static uint32_t check_cut(const stream *s, size_t size)
{
    decoding cut = decoding_begin(s), whole = decoding_begin(s);
    uint8_t *bytes = (uint8_t *)copy_of(s->data, size);
    cq_bytes head, all;
    uint32_t vertices;
    head.data = bytes;
    head.size = size;
    all.data = s->data;
    all.size = s->size;
    REQUIRE(decoding_call(&cut, &head, CQ_NO_LIMIT, 1) == CQ_NEED_INPUT);
    REQUIRE(decoding_call(&cut, NULL, CQ_NO_LIMIT, 1) == CQ_TRUNCATED);
    REQUIRE(cut.used == size);
    while (whole.vertices < cut.vertices) REQUIRE(decoding_call(&whole, &all, 1, 0) >= 0);
    if (cut.vertices > 0) check_equal(cut.decoder, whole.decoder);
    vertices = cut.vertices;
    decoding_end(&cut);
    decoding_end(&whole);
    free(bytes);
    return vertices;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    uint32_t first = take_two(&in), second = take_two(&in), few, more;
    stream s = take_encoded_stream(&in);
    first %= (uint32_t)s.size;
    second = first + second % ((uint32_t)s.size - first);
    few = check_cut(&s, first);
    more = check_cut(&s, second);
    REQUIRE(few <= more);
    REQUIRE(check_cut(&s, s.size - 1) >= more);
    free(s.data);
    return 0;
}
