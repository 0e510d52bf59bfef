/* The decoder and nothing else, as often as a second allows: any bytes behind the header of a small mesh, in one call;
 * what came of it is checked once. mutator.c changes single decisions of such streams. */
#include "lean.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    cq_shape shape;
    stream s;
    decoding d;
    cq_bytes bytes;
    take_small_shape(&in, &shape);
    s = frame(&shape, in.data, in.size);
    d = decoding_begin(&s);
    bytes.data = s.data;
    bytes.size = s.size;
    decoding_call(&d, &bytes, CQ_NO_LIMIT, 0);
    decoding_call(&d, NULL, CQ_NO_LIMIT, 1);
    REQUIRE(is_permanent(d.result));
    decoding_end(&d);
    free(s.data);
    return 0;
}
