/* Pieces of any size and budgets of any number of steps give what one call gives: the same result, the same mesh slot
 * for slot, the same values; without an error also the same number of bytes used. For good streams, damaged ones,
 * noise. */
#include "surface.h"

static stream take_pieces(input *in)
{
    uint32_t kind = take(in), k;
    stream s;
    if (kind < 96) return take_headed_stream(in);
    s = take_encoded_stream(in);
    for (k = 0; kind >= 192 && k < kind % 8; k++) s.data[take_below(in, (uint32_t)s.size)] ^= (uint8_t)take(in);
    if (kind >= 208) repair(&s);
    return s;
}

static void run_at_once(decoding *d, const stream *s)
{
    cq_bytes in;
    in.data = s->data;
    in.size = s->size;
    if (decoding_call(d, &in, CQ_NO_LIMIT, 1) == CQ_NEED_INPUT) decoding_call(d, NULL, CQ_NO_LIMIT, 1);
}

/* Each piece lies in a block of its own that is gone after the call. */
static void run_in_pieces(decoding *d, const stream *s, uint32_t choice, uint32_t seed)
{
    uint32_t most = 1 + seed % (choice & 1 ? 3 : 700), steps = 1 + seed % (choice & 2 ? 3 : 200);
    size_t at = 0;
    while (at < s->size && !is_permanent(d->result)) {
        size_t n = seed % (most + 1), used;
        uint32_t budget = choice & 4 ? CQ_NO_LIMIT : seed % (steps + 1);
        cq_bytes in;
        uint8_t *piece;
        seed = seed * 1664525u + 1013904223u;
        if (n > s->size - at) n = s->size - at;
        piece = (uint8_t *)copy_of(s->data + at, n);
        in.data = piece;
        in.size = n;
        used = d->used;
        decoding_call(d, &in, budget, 0);
        at += d->used - used;
        free(piece);
    }
    while (!is_permanent(d->result)) decoding_call(d, NULL, choice & 8 ? steps : CQ_NO_LIMIT, 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    uint32_t choice = take(&in), seed = take(&in);
    stream s = take_pieces(&in);
    decoding once = decoding_begin(&s), pieces = decoding_begin(&s);
    run_at_once(&once, &s);
    run_in_pieces(&pieces, &s, choice, seed);
    REQUIRE(once.result == pieces.result);
    REQUIRE(once.result < 0 || once.used == pieces.used);   /* before an error more may have been buffered */
    check_equal(once.decoder, pieces.decoder);
    decoding_end(&once);
    decoding_end(&pieces);
    free(s.data);
    return 0;
}
