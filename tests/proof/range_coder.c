/* Proofs about the range coder. Each is about one call from any state that satisfies the invariant below, not from the
 * first states of a stream: with `init establishes it` and `every call keeps it` they hold for streams of any length.
 *
 *     decoder   2^24 <= range < 2^32 and code < range
 *     encoder   2^24 <= range < 2^32, low + range < 2^33, -1 <= cache <= 255, and
 *               low + range <= 2^32 if cache is -1 or 255: no carry can be lost
 *     model     1 <= probability <= 65534
 *
 * The encoder's number is what it has put out, then cache, then `pending` bytes 0xff, then low; the interval of the
 * code is [number, number + range). Putting out bytes keeps the number, and the end picks a number of the interval. */
#include "proof.h"

/* -- States that satisfy the invariants ---------------------------------------------------------------------------- */

static int decoder_holds(const cq_range_decoder *d) { return d->range >= CQI_MIN_RANGE && d->code < d->range; }

/* The invariant; in the middle of a step, while bytes are put out, the range may be smaller. */
static int encoder_holds_in_step(const cq_range_encoder *e)
{
    int at_edge = e->cache == -1 || e->cache == 255;
    return e->range >= 1 && e->low + e->range <= ((uint64_t)1 << (at_edge ? 32 : 33)) - (at_edge ? 0 : 1) &&
           e->low >> 33 == 0 && e->cache >= -1 && e->cache <= 255 && e->zeros <= e->count;
}

static int encoder_holds(const cq_range_encoder *e)
{
    return e->range >= CQI_MIN_RANGE && encoder_holds_in_step(e);
}

static int model_holds(cq_bit_model model) { return model >= 1 && model <= 65534; }

/* Reads from `size` bytes of any contents; `count` may be anything: it is never used beyond `size`. */
static cq_range_decoder any_decoder(void)
{
    cq_range_decoder d;
    d.size = nondet_size();
    ASSUME(d.size <= 16);
    d.data = any_bytes(d.size);
    d.count = nondet_size();
    d.code = nondet_u32();
    d.range = nondet_u32();
    d.slot = nondet_u32();
    ASSUME(decoder_holds(&d));
    ASSUME(d.count <= SIZE_MAX - 16);
    return d;
}

static cq_range_encoder any_encoder_in_step(size_t max_pending)
{
    cq_range_encoder e;
    e.size = nondet_size();
    ASSUME(e.size <= 16);
    e.data = any_bytes(e.size);
    e.count = nondet_size();
    e.zeros = nondet_size();
    e.pending = nondet_size();
    e.low = nondet_u64();
    e.range = nondet_u32();
    e.cache = nondet_int();
    ASSUME(encoder_holds_in_step(&e));
    ASSUME(e.pending <= max_pending && e.count <= SIZE_MAX - 64);
    return e;
}

static cq_range_encoder any_encoder(size_t max_pending)
{
    cq_range_encoder e = any_encoder_in_step(max_pending);
    ASSUME(encoder_holds(&e));
    return e;
}

/* An encoder of which only the range matters. */
static cq_range_encoder any_range(void)
{
    cq_range_encoder e;
    cq_range_encoder_init(&e, NULL, 0);
    e.range = nondet_u32();
    ASSUME(encoder_holds(&e));
    return e;
}

static cq_bit_model any_model(void)
{
    cq_bit_model model = nondet_u16();
    ASSUME(model_holds(model));
    return model;
}

/* A symbol that owns freq > 0 of total slots from start. The totals are those of the claim, one after another: with any
 * total at once, no solver that we tried can follow the products. */
typedef struct symbol {
    uint32_t start, freq, total;
} symbol;

static symbol any_symbol(void)
{
    symbol s;
    s.start = nondet_u32();
    s.freq = nondet_u32();
    s.total = TOTAL;
    ASSUME(s.freq >= 1 && s.freq <= s.total && s.start <= s.total - s.freq);
    return s;
}

/* -- The decoder --------------------------------------------------------------------------------------------------- */

void claim_decoder_init(void)
{
    size_t size = nondet_size();
    uint8_t *data;
    cq_range_decoder d;
    ASSUME(size <= 16);
    data = any_bytes(size);
    cq_range_decoder_init(&d, data, size);
    PROVE(decoder_holds(&d));
    PROVE(d.count == 4 && d.size == size && d.data == data);
    REACHED();
}

void claim_decode_bit(void)
{
    cq_range_decoder d = any_decoder();
    cq_bit_model model = any_model();
    size_t count = d.count;
    int rate = any_between(1, 8), bit;
    bit = cq_decode_bit(&d, &model, rate);
    PROVE(bit == 0 || bit == 1);
    PROVE(decoder_holds(&d));
    PROVE(model_holds(model));
    PROVE(d.count - count <= 2);
    REACHED();
}

/* The slot is one of total, and for any symbol that holds it the decoder stays in its interval. */
void claim_decode_freq(void)
{
    cq_range_decoder d = any_decoder();
    symbol s = any_symbol();
    size_t count = d.count;
    uint32_t slot = cq_decode_slot(&d, s.total);
    PROVE(slot < s.total);
    ASSUME(slot >= s.start && slot - s.start < s.freq);
    cq_decode_freq(&d, s.start, s.freq, s.total);
    PROVE(decoder_holds(&d));
    PROVE(d.count - count <= 3);
    REACHED();
}

/* -- The encoder --------------------------------------------------------------------------------------------------- */

void claim_encoder_init(void)
{
    size_t size = nondet_size();
    uint8_t *data;
    cq_range_encoder e;
    ASSUME(size <= 16);
    data = any_bytes(size);
    cq_range_encoder_init(&e, data, size);
    PROVE(encoder_holds(&e));
    PROVE(e.low == 0 && e.cache == -1 && e.count == 0 && e.pending == 0 && e.data == data && e.size == size);
    REACHED();
}

void claim_encode_bit(void)
{
    cq_range_encoder e = any_encoder(3);
    cq_bit_model model = any_model();
    int rate = any_between(1, 8), bit = nondet_int();
    cq_encode_bit(&e, &model, rate, bit);
    PROVE(encoder_holds(&e));
    PROVE(model_holds(model));
    REACHED();
}

void claim_encode_freq(void)
{
    cq_range_encoder e = any_encoder(3);
    symbol s = any_symbol();
    cq_encode_freq(&e, s.start, s.freq, s.total);
    PROVE(encoder_holds(&e));
    REACHED();
}

/* -- Both: a decoder in the encoder's interval takes what the encoder took -- */

/* The decoder's range is the encoder's. Its code lies anywhere in the part that the encoder's symbol took. */
void claim_bit_decodes(void)
{
    cq_range_encoder e = any_range();
    cq_range_decoder d = any_decoder();
    cq_bit_model of_encoder = any_model(), of_decoder = of_encoder;
    int rate = any_between(1, 8), bit = any_between(0, 1);
    uint32_t one = cqi_one_width(e.range, of_encoder), code = d.code;
    size_t count = d.count;
    ASSUME(d.range == e.range);
    ASSUME(bit ? code < one : code >= one);
    cq_encode_bit(&e, &of_encoder, rate, bit);
    PROVE(cq_decode_bit(&d, &of_decoder, rate) == bit);
    PROVE(d.range == e.range && of_decoder == of_encoder);
    PROVE(d.count != count || d.code == code - (bit ? 0 : one));
    REACHED();
}

void claim_freq_decodes(void)
{
    cq_range_encoder e = any_range();
    cq_range_decoder d = any_decoder();
    symbol s = any_symbol();
    uint32_t slot = e.range / s.total, at;
    uint32_t width = cqi_freq_width(e.range, slot, s.start, s.freq, s.total);
    ASSUME(d.range == e.range);
    ASSUME(d.code >= slot * s.start && d.code - slot * s.start < width);
    cq_encode_freq(&e, s.start, s.freq, s.total);
    at = cq_decode_slot(&d, s.total);
    PROVE(at >= s.start && at - s.start < s.freq);
    cq_decode_freq(&d, s.start, s.freq, s.total);
    PROVE(d.range == e.range);
    REACHED();
}

/* The number that the bytes, the cache, the pending bytes and low make together; of up to two bytes put out. */
static uint64_t number(const cq_range_encoder *e)
{
    uint64_t n = 0;
    size_t k;
    for (k = 0; k < e->count; k++) n = n << 8 | e->data[k];
    if (e->cache >= 0) n = n << 8 | (uint64_t)e->cache;
    for (k = 0; k < e->pending; k++) n = n << 8 | 0xff;
    return (n << 32) + e->low;
}

/* Putting out the top byte of low keeps the number, which gets a zero byte at its end. */
void claim_shift_keeps_the_number(void)
{
    cq_range_encoder e = any_encoder_in_step(1);
    uint64_t before;
    ASSUME(e.count <= 1 && e.size >= 4);
    ASSUME(e.cache >= 0 || (e.count == 0 && e.pending == 0));
    before = number(&e);
    ASSUME(before >> 56 == 0);
    cqi_shift_low(&e);
    PROVE(number(&e) == before << 8);
    PROVE(e.low >> 32 == 0);
    REACHED();
}

/* The end picks a number in [low, low + range) and drops nothing but zero bytes. */
void claim_finish_stays_in_the_interval(void)
{
    cq_range_encoder e = any_encoder(1);
    uint64_t low, range, result = 0;
    size_t k, places, count;
    ASSUME(e.count == 0 && e.zeros == 0 && e.size >= 8);
    low = number(&e);
    range = e.range;
    places = (e.cache >= 0 ? 5 : 4) + e.pending;
    ASSUME(e.cache >= 0 || (e.pending == 0 && e.low + e.range <= (uint64_t)1 << 32));
    count = cq_range_encoder_finish(&e);
    PROVE(count <= places && count == e.count);
    PROVE(count == 0 || e.data[count - 1] != 0);
    for (k = 0; k < places; k++) result = result << 8 | (k < count ? e.data[k] : 0u);
    PROVE(result >= low && result - low < range);
    REACHED();
}

/* -- Raw bits ------------------------------------------------------------------------------------------------------ */

/* The symbols of a number's parts as they were written; a decoder that comes to one of them is anywhere in its part of
 * the range, and so has its slot: claim_freq_decodes. */
static symbol part[4];
static int num_written, num_read;

void stub_encode_freq(cq_range_encoder *e, uint32_t start, uint32_t freq, uint32_t total)
{
    (void)e;
    PROVE(num_written < 4 && freq == 1 && start < total && total <= 0x10000);
    part[num_written].start = start;
    part[num_written++].total = total;
}

void stub_decode_freq(cq_range_decoder *d, uint32_t start, uint32_t freq, uint32_t total)
{
    PROVE(num_read < num_written && freq == 1 && start < total && total == part[num_read].total);
    PROVE(d->slot >= 1 && (uint64_t)d->slot * total <= d->range && d->range - d->slot * total < total);
    ASSUME(start == part[num_read].start);
    num_read++;
    d->range = nondet_u32();
    d->code = nondet_u32();
    ASSUME(decoder_holds(d));
}

/* Any number of up to 32 bits, and any state: the decoder gets the number, from as many symbols of the same totals. */
void claim_raw_decodes(void)
{
    cq_range_encoder e = any_range();
    cq_range_decoder d = any_decoder();
    const int bits = any_between(0, 32);
    const uint32_t value = nondet_u32();
    ASSUME(bits == 32 || value >> bits == 0);
    cq_encode_raw(&e, value, bits);
    PROVE(cq_decode_raw(&d, bits) == value);
    PROVE(num_read == num_written);
    REACHED();
}
