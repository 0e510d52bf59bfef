/* The range coder alone: what was coded comes back, in as many bytes as were announced, and any bytes decode to symbols
 * that exist, with the interval in order after each. */
#include "fuzz.h"

enum { MODELS = 8, MOST_SYMBOLS = 2000 };

typedef struct symbol {
    uint32_t kind;                 /* 0 bit, 1 frequencies, 2 raw */
    uint32_t model, rate, bit;
    uint32_t start, freq, total;
    uint32_t value;
    int bits;
} symbol;

static symbol take_symbol(input *in)
{
    symbol s;
    uint32_t op = take(in);
    memset(&s, 0, sizeof s);
    s.kind = op % 4 < 2 ? 0 : op % 4 - 1;
    s.model = op / 4 % MODELS;
    s.rate = 1 + s.model;
    s.bit = op / 32 % 2;
    if (s.kind == 1) {
        uint32_t order = op / 32;   /* total from 1 to 2^24 */
        s.total = 1 + take_four(in) % ((uint32_t)1 << (3 * order + 3));
        s.start = take_four(in) % s.total;
        s.freq = 1 + take_two(in) % (s.total - s.start);
    }
    if (s.kind == 2) {
        s.bits = (int)(take(in) % 33);
        s.value = take_four(in);
        if (s.bits < 32) s.value &= ((uint32_t)1 << s.bits) - 1;
    }
    return s;
}

static void begin(cq_bit_model *models)
{
    uint32_t k;
    for (k = 0; k < MODELS; k++) models[k] = CQ_BIT_MODEL_INIT;
}

static size_t encode(input in, uint8_t *data, size_t size)
{
    cq_range_encoder e;
    cq_bit_model models[MODELS];
    uint32_t n;
    begin(models);
    cq_range_encoder_init(&e, data, size);
    for (n = 0; in.size > 0 && n < MOST_SYMBOLS; n++) {
        symbol s = take_symbol(&in);
        if (s.kind == 0) cq_encode_bit(&e, &models[s.model], (int)s.rate, (int)s.bit);
        if (s.kind == 1) cq_encode_freq(&e, s.start, s.freq, s.total);
        if (s.kind == 2) cq_encode_raw(&e, s.value, s.bits);
        REQUIRE(e.range >= (uint32_t)1 << 24);
    }
    n = (uint32_t)cq_range_encoder_finish(&e);
    REQUIRE(e.count == n);
    return n;
}

/* Decodes what the bytes in `in` say, from any data. `faithful`: the data is theirs. */
static void decode(input in, const uint8_t *data, size_t size, int faithful)
{
    cq_range_decoder d;
    cq_bit_model models[MODELS];
    uint32_t n, k;
    begin(models);
    cq_range_decoder_init(&d, data, size);
    for (n = 0; in.size > 0 && n < MOST_SYMBOLS; n++) {
        symbol s = take_symbol(&in);
        uint32_t got = 0;
        if (s.kind == 0) got = (uint32_t)cq_decode_bit(&d, &models[s.model], (int)s.rate);
        if (s.kind == 1) {
            got = cq_decode_slot(&d, s.total);
            REQUIRE(got < s.total);
            if (faithful || (got >= s.start && got - s.start < s.freq)) cq_decode_freq(&d, s.start, s.freq, s.total);
            else cq_decode_freq(&d, got, 1, s.total);
        }
        if (s.kind == 2) got = cq_decode_raw(&d, s.bits);
        REQUIRE(d.range >= (uint32_t)1 << 24 && d.code < d.range);
        if (s.kind == 0) REQUIRE(got <= 1);
        if (s.kind == 2) REQUIRE(s.bits == 32 || got >> s.bits == 0);
        if (faithful && s.kind == 0) REQUIRE(got == s.bit);
        if (faithful && s.kind == 1) REQUIRE(got >= s.start && got - s.start < s.freq);
        if (faithful && s.kind == 2) REQUIRE(got == s.value);
        for (k = 0; k < MODELS; k++) REQUIRE(models[k] >= 1 && models[k] <= 65534);
    }
    if (faithful) REQUIRE(d.count >= size);   /* no byte is in vain */
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size }, noise;
    uint32_t cut = take_two(&in);
    size_t bytes = encode(in, NULL, 0);
    uint8_t *all = (uint8_t *)block(bytes), *few;
    REQUIRE(encode(in, all, bytes) == bytes);
    REQUIRE(bytes == 0 || all[bytes - 1] != 0);
    decode(in, all, bytes, 1);
    cut %= (uint32_t)bytes + 1;
    few = (uint8_t *)block(cut);
    REQUIRE(encode(in, few, cut) == bytes);          /* counts what does not fit */
    REQUIRE(cut == 0 || memcmp(few, all, cut) == 0);
    decode(in, few, cut, 0);
    noise = in;
    noise.size = in.size / 2;
    decode(noise, in.data + noise.size, in.size - noise.size, 0);
    free(all);
    free(few);
    return 0;
}
