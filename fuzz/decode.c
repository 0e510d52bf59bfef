/* Any bytes as a stream: as they are, with right check values, or as the payload behind a header of small counts. After
 * every call the mesh must be valid, and the steps are bounded by the counts. */
#include "fuzz.h"

static stream take_stream(input *in) {
    uint32_t kind = take(in);
    stream s;
    if (kind >= 64) return take_headed_stream(in);
    s = stream_of(in->data, in->size);
    if (kind >= 32) repair(&s);
    return s;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = { data, size };
    stream s = take_stream(&in);
    decoding d = decoding_begin(&s);
    decoding_run(&d, &s);
    decoding_end(&d);
    free(s.data);
    return 0;
}
