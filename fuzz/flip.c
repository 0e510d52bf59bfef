/* A good stream with some bits flipped, bytes changed, moved or lost, in the header or behind it, and the check values
 * made right again: the damage that a check value does not find. */
#include "surface.h"

static void damage_stream(stream *s, input *in)
{
    uint32_t kind = take(in), at = take_two(in) % (uint32_t)s->size, amount = take(in);
    switch (kind % 4) {
    case 0: s->data[at] ^= (uint8_t)(1u << amount % 8); break;
    case 1: s->data[at] = (uint8_t)amount; break;
    case 2: s->data[at] = s->data[(at + amount) % s->size]; break;
    default:
        amount = 1 + amount % 8;
        if (amount > s->size - at) amount = (uint32_t)(s->size - at);
        s->size -= amount;
        memmove(s->data + at, s->data + at + amount, s->size - at);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size }, noted;
    uint32_t count = take(&in), k;
    uint8_t notes[4 * 8];
    stream s, exact;
    decoding d;
    for (k = 0; k < sizeof notes; k++) notes[k] = (uint8_t)(k < 4 * (1 + count % 8) ? take(&in) : 0);
    noted.data = notes;
    noted.size = sizeof notes;
    s = take_encoded_stream(&in);
    for (k = 0; k <= count % 8 && s.size > 0; k++) damage_stream(&s, &noted);
    if (count < 224) repair(&s);
    exact = stream_of(s.data, s.size);
    d = decoding_begin(&exact);
    decoding_run(&d, &exact);
    decoding_end(&d);
    free(exact.data);
    free(s.data);
    return 0;
}
