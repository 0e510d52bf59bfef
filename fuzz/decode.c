/* Any bytes as a stream: as they are, with right check values, as the payload behind a header of small counts, or
 * grafted on the head of a good stream. After every call the mesh must be valid, and the steps are bounded by the
 * counts. */
#include "surface.h"

/* The payload of a good stream up to some byte, then any bytes, behind a header that promises more vertices: so that
 * noise meets a decoder that has a base already. Zeros in between keep the last symbols of the head as they were. */
static stream take_grafted_stream(input *in)
{
    uint32_t more = take_two(in) % 200, edges = take(in) % 4, zeros = take(in), kept;
    stream s = take_encoded_stream(in), grafted;
    cq_shape shape;
    size_t header_bytes;
    uint8_t *payload;
    REQUIRE(cq_peek(s.data, s.size, &shape, &header_bytes, NULL) == CQ_OK);
    if (shape.num_boundary_loops == 0 || edges > 2 * more) edges = 0;
    shape.num_vertices += more;
    shape.num_faces += 2 * more - edges;
    shape.num_boundary_edges += edges;
    kept = (uint32_t)(s.size - header_bytes);
    if (zeros >= 128) kept = kept * (zeros & 31) / 32;
    zeros = zeros / 32 % 4 * (zeros < 128);
    payload = (uint8_t *)block(kept + zeros + in->size);
    memcpy(payload, s.data + header_bytes, kept);
    memset(payload + kept, 0, zeros);
    if (in->size > 0) memcpy(payload + kept + zeros, in->data, in->size);
    grafted = frame(&shape, payload, kept + zeros + in->size);
    free(payload);
    free(s.data);
    return grafted;
}

static stream take_stream(input *in)
{
    uint32_t kind = take(in);
    stream s;
    if (kind >= 128) return take_grafted_stream(in);
    if (kind >= 64) return take_headed_stream(in);
    s = stream_of(in->data, in->size);
    if (kind >= 32) repair(&s);
    return s;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    stream s = take_stream(&in);
    decoding d = decoding_begin(&s);
    decoding_run(&d, &s);
    decoding_end(&d);
    free(s.data);
    return 0;
}
