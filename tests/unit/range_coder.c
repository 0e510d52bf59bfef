/* The range coder alone: symbols, bits and raw numbers; carries; both ends of the code; byte accounting. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "exact.h"
#include "test.h"
#include "triangles.h"

enum { MAX_SYMBOLS = 4096, MAX_BYTES = 3 * MAX_SYMBOLS + 16 };

/* A sequence of symbols with their frequencies, and its code in a block of exactly its size. */
typedef struct sequence {
    uint32_t start[MAX_SYMBOLS], freq[MAX_SYMBOLS], total[MAX_SYMBOLS];
    uint32_t count;
    uint8_t *bytes;
    size_t size;
} sequence;

static void sequence_add(sequence *s, uint32_t start, uint32_t freq, uint32_t total)
{
    s->start[s->count] = start;
    s->freq[s->count] = freq;
    s->total[s->count] = total;
    s->count++;
}

static void sequence_encode(sequence *s)
{
    static uint8_t buffer[MAX_BYTES];
    cq_range_encoder e;
    uint32_t k;
    cq_range_encoder_init(&e, buffer, sizeof buffer);
    for (k = 0; k < s->count; ++k) cq_encode_freq(&e, s->start[k], s->freq[k], s->total[k]);
    s->size = cq_range_encoder_finish(&e);
    CHECK(s->size <= sizeof buffer);
    s->bytes = (uint8_t *)exact_copy(buffer, s->size);
}

/* How many symbols come back from `size` bytes before the first one that is wrong. */
static uint32_t sequence_decode(const sequence *s, const uint8_t *bytes, size_t size)
{
    cq_range_decoder d;
    uint32_t k;
    cq_range_decoder_init(&d, bytes, size);
    for (k = 0; k < s->count; ++k) {
        uint32_t slot = cq_decode_slot(&d, s->total[k]);
        CHECK(slot < s->total[k]);
        if (slot < s->start[k] || slot - s->start[k] >= s->freq[k]) break;
        cq_decode_freq(&d, s->start[k], s->freq[k], s->total[k]);
    }
    return k;
}

static void sequence_check(sequence *s)
{
    sequence_encode(s);
    CHECK_EQ(sequence_decode(s, s->bytes, s->size), s->count);
    exact_free(s->bytes);
    s->bytes = NULL;
}

/* -- Ends of the code ---------------------------------------------------------------------------------------------- */

TEST(an_empty_stream_has_no_bytes)
{
    cq_range_encoder e;
    cq_range_decoder d;
    cq_range_encoder_init(&e, NULL, 0);
    CHECK_EQ(cq_range_encoder_finish(&e), 0);
    cq_range_decoder_init(&d, NULL, 0);
    CHECK(d.count > d.size);
}

TEST(zeros_at_the_end_are_not_written)
{
    static sequence s;
    uint32_t k;
    s.count = 0;
    for (k = 0; k < 1000; ++k) sequence_add(&s, 0, 1, 256);   /* always the first symbol: the code is all zeros */
    sequence_encode(&s);
    CHECK_EQ(s.size, 0);
    CHECK_EQ(sequence_decode(&s, NULL, 0), 1000);
    exact_free(s.bytes);
}

TEST(the_last_byte_of_a_code_is_never_zero)
{
    uint64_t random = 1;
    static sequence s;
    int round;
    for (round = 0; round < 2000; ++round) {
        uint32_t k, n = 1 + (uint32_t)(next_random(&random) % 12);
        s.count = 0;
        for (k = 0; k < n; ++k) {
            uint32_t total = 1 + (uint32_t)(next_random(&random) % 300);
            sequence_add(&s, (uint32_t)(next_random(&random) % total), 1, total);
        }
        sequence_encode(&s);
        CHECK(s.size == 0 || s.bytes[s.size - 1] != 0);
        CHECK_EQ(sequence_decode(&s, s.bytes, s.size), s.count);
        exact_free(s.bytes);
    }
}

TEST(no_shorter_code_means_the_same)
{
    /* For each code of one or two bytes, try every code that is one byte shorter. */
    uint64_t random = 2;
    static sequence s;
    int round, tried = 0;
    for (round = 0; round < 400; ++round) {
        uint32_t k, n = 1 + (uint32_t)(next_random(&random) % 3);
        s.count = 0;
        for (k = 0; k < n; ++k) {
            uint32_t total = 2 + (uint32_t)(next_random(&random) % 9);
            sequence_add(&s, (uint32_t)(next_random(&random) % total), 1, total);
        }
        sequence_encode(&s);
        if (s.size == 1) {
            CHECK(sequence_decode(&s, NULL, 0) < s.count);
            tried++;
        } else if (s.size == 2) {
            for (k = 0; k < 256; ++k) {
                uint8_t shorter[1];
                shorter[0] = (uint8_t)k;
                CHECK(sequence_decode(&s, shorter, 1) < s.count);
            }
            tried++;
        }
        exact_free(s.bytes);
    }
    CHECK(tried > 300);
}

TEST(any_bytes_may_follow_in_memory_but_only_size_bytes_are_read)
{
    static sequence s;
    uint32_t k;
    s.count = 0;
    for (k = 0; k < 100; ++k) sequence_add(&s, k % 7, 1, 7);
    sequence_encode(&s);   /* the block is exact: AddressSanitizer sees one byte more */
    CHECK_EQ(sequence_decode(&s, s.bytes, s.size), 100);
    exact_free(s.bytes);
}

/* Four bytes 0xff are the end of the first interval, which belongs to no symbol: as good as the number before it. */
TEST(a_code_that_no_encoder_writes_is_the_last_symbol)
{
    static const uint8_t bytes[] = {0xff, 0xff, 0xff, 0xff};
    cq_range_decoder d;
    cq_range_decoder_init(&d, bytes, sizeof bytes);
    CHECK(d.code < d.range);
    CHECK_EQ(cq_decode_slot(&d, 1000), 999);
}

TEST(a_decoder_counts_the_bytes_it_wanted_past_the_end)
{
    static sequence s;
    cq_range_decoder d;
    uint32_t k;
    size_t before;
    s.count = 0;
    for (k = 0; k < 100; ++k) sequence_add(&s, 255, 1, 256);
    sequence_encode(&s);
    cq_range_decoder_init(&d, s.bytes, s.size);
    CHECK_EQ(d.count, 4);
    for (k = 0; k < 100; ++k) {
        CHECK_EQ(cq_decode_slot(&d, 256), 255);
        cq_decode_freq(&d, 255, 1, 256);
    }
    CHECK(d.count >= s.size);
    before = d.count;
    for (k = 0; k < 100; ++k) cq_decode_freq(&d, cq_decode_slot(&d, 256), 1, 256);
    CHECK_EQ(d.count, before + 100);
    CHECK_EQ(d.size, s.size);
    exact_free(s.bytes);
}

TEST(a_decoder_has_read_four_bytes_more_than_the_encoder_has_shifted_out)
{
    /* One byte goes out for each byte that goes in: 8 bits a symbol, exactly. */
    uint8_t data[64];
    cq_range_encoder e;
    cq_range_decoder d;
    uint32_t k;
    size_t size;
    cq_range_encoder_init(&e, data, sizeof data);
    for (k = 0; k < 20; ++k) cq_encode_freq(&e, 17 * k % 256, 1, 256);
    size = cq_range_encoder_finish(&e);
    cq_range_decoder_init(&d, data, size);
    for (k = 0; k < 20; ++k) {
        CHECK_EQ(cq_decode_slot(&d, 256), 17 * k % 256);
        cq_decode_freq(&d, 17 * k % 256, 1, 256);
    }
    CHECK(d.count >= size && d.count <= size + 4);
}

TEST(finish_costs_at_most_two_bytes)
{
    /* 2^24 <= range, so a byte and a bit are enough to name a number in the interval. */
    uint64_t random = 7;
    uint32_t n;
    for (n = 0; n < 200; ++n) {
        static sequence s;
        uint32_t k;
        s.count = 0;
        for (k = 0; k < n; ++k) sequence_add(&s, (uint32_t)(next_random(&random) & 255), 1, 256);
        sequence_encode(&s);
        CHECK(s.size <= n + 2);
        CHECK(s.size + 2 >= n);
        CHECK_EQ(sequence_decode(&s, s.bytes, s.size), n);
        exact_free(s.bytes);
    }
}

/* -- Carries ------------------------------------------------------------------------------------------------------- */

/* Symbols whose interval always holds the number that `bytes` are the head of (zeros follow). */
static void sequence_follow(sequence *s, const uint8_t *bytes, size_t size, uint32_t count, uint32_t total)
{
    cq_range_decoder d;
    uint32_t k;
    s->count = 0;
    cq_range_decoder_init(&d, bytes, size);
    for (k = 0; k < count; ++k) {
        uint32_t slot = cq_decode_slot(&d, total);
        sequence_add(s, slot, 1, total);
        cq_decode_freq(&d, slot, 1, total);
    }
}

/* The most 0xff bytes that waited for a carry while the sequence was encoded. */
static size_t longest_wait(const sequence *s)
{
    cq_range_encoder e;
    uint32_t k;
    size_t most = 0;
    cq_range_encoder_init(&e, NULL, 0);
    for (k = 0; k < s->count; ++k) {
        cq_encode_freq(&e, s->start[k], s->freq[k], s->total[k]);
        if (e.pending > most) most = e.pending;
    }
    return most;
}

TEST(a_carry_goes_through_a_long_run_of_ff_bytes)
{
    /* The interval straddles 0x80 00 00 ... for as long as wanted: its low end is 0x7f ff ff ... Then one symbol below
     * the boundary leaves the run as it is, one above it carries through all of it. */
    static const uint8_t boundaries[][3] = {
        {0x80, 0, 0}, {0x01, 0, 0}, {0xff, 0, 0}, {0x12, 0x34, 0}, {0x12, 0x34, 0x56}};
    static const uint32_t totals[] = {3, 5, 7, 10, 255, 257, 1000, 65535};
    static const uint32_t lengths[] = {1, 2, 5, 50, 1000};
    size_t b, t, l, longest = 0;
    int with_carry = 0, without = 0;
    for (b = 0; b < sizeof boundaries / sizeof boundaries[0]; ++b) {
        for (t = 0; t < sizeof totals / sizeof totals[0]; ++t) {
            for (l = 0; l < sizeof lengths / sizeof lengths[0]; ++l) {
                static sequence s;
                uint32_t k, last;
                size_t wait;
                sequence_follow(&s, boundaries[b], 3, lengths[l], totals[t]);
                wait = longest_wait(&s);
                if (wait > longest) longest = wait;
                for (last = 0; last < 16; ++last) {   /* 16 parts of the interval: some below, some above */
                    s.count = lengths[l];
                    sequence_add(&s, last, 1, 16);
                    sequence_encode(&s);
                    CHECK_EQ(sequence_decode(&s, s.bytes, s.size), s.count);
                    for (k = 0; k < 3 && k < s.size && s.bytes[k] == boundaries[b][k]; ++k) {}
                    if (wait > 3) *(k == 3 ? &with_carry : &without) += 1;
                    exact_free(s.bytes);
                }
            }
        }
    }
    CHECK(longest > 500);
    CHECK(with_carry > 100);
    CHECK(without > 100);
}

TEST(a_run_of_ff_bytes_without_a_carry_comes_out_as_it_is)
{
    static sequence s;
    uint32_t k, ff = 0;
    s.count = 0;
    for (k = 0; k < 300; ++k) sequence_add(&s, 255, 1, 256);
    sequence_encode(&s);
    for (k = 0; k < s.size; ++k) ff += s.bytes[k] == 0xff;
    CHECK(ff > 280);
    CHECK_EQ(sequence_decode(&s, s.bytes, s.size), 300);
    exact_free(s.bytes);
}

TEST(a_code_ends_well_while_bytes_still_wait_for_a_carry)
{
    static const uint8_t boundary[] = {0x80};
    uint32_t n;
    for (n = 0; n < 400; ++n) {
        static sequence s;
        sequence_follow(&s, boundary, 1, n, 3);
        sequence_check(&s);
    }
}

/* -- Symbols ------------------------------------------------------------------------------------------------------- */

TEST(the_first_and_the_last_symbol_survive_at_every_total)
{
    uint32_t total;
    for (total = 1; total <= 65536; total = total < 600 ? total + 1 : total + 397) {
        static sequence s;
        uint32_t k;
        s.count = 0;
        for (k = 0; k < 12; ++k) sequence_add(&s, k % 3 == 0 ? 0 : total - 1, 1, total);
        sequence_check(&s);
    }
}

TEST(a_total_of_two_to_the_sixteen_is_allowed)
{
    static sequence s;
    static const uint32_t slots[] = {0, 1, 255, 256, 32767, 32768, 65279, 65280, 65534, 65535};
    uint32_t k, j;
    s.count = 0;
    for (k = 0; k < 10; ++k)
        for (j = 0; j < 10; ++j) sequence_add(&s, slots[(k * j + k) % 10], 1, 65536);
    sequence_add(&s, 0, 65535, 65536);
    sequence_add(&s, 1, 65535, 65536);
    sequence_add(&s, 0, 65536, 65536);
    sequence_check(&s);
}

TEST(a_symbol_that_owns_every_slot_costs_nothing)
{
    cq_range_encoder e;
    cq_range_decoder d;
    uint8_t data[16];
    uint32_t k;
    size_t size;
    cq_range_encoder_init(&e, data, sizeof data);
    cq_encode_raw(&e, 0xabc, 12);
    for (k = 0; k < 10000; ++k) cq_encode_freq(&e, 0, 5, 5);
    cq_encode_raw(&e, 0xdef, 12);
    size = cq_range_encoder_finish(&e);
    CHECK(size <= 4);
    cq_range_decoder_init(&d, data, size);
    CHECK_EQ(cq_decode_raw(&d, 12), 0xabc);
    for (k = 0; k < 10000; ++k) {
        CHECK(cq_decode_slot(&d, 5) < 5);
        cq_decode_freq(&d, 0, 5, 5);
    }
    CHECK_EQ(cq_decode_raw(&d, 12), 0xdef);
}

TEST(symbols_of_any_width_come_back)
{
    uint64_t random = 3;
    static sequence s;
    int round;
    for (round = 0; round < 200; ++round) {
        uint32_t k;
        s.count = 0;
        for (k = 0; k < 300; ++k) {
            uint32_t total = 1 + (uint32_t)(next_random(&random) % (round % 2 == 0 ? 65536 : 20));
            uint32_t start = (uint32_t)(next_random(&random) % total);
            uint32_t freq = 1 + (uint32_t)(next_random(&random) % (total - start));
            sequence_add(&s, start, freq, total);
        }
        sequence_check(&s);
    }
}

TEST(a_decoder_of_noise_returns_slots_in_range)
{
    uint64_t random = 4;
    int round;
    for (round = 0; round < 300; ++round) {
        size_t size = (size_t)(next_random(&random) % 40), k;
        uint8_t *noise = (uint8_t *)exact_alloc(size);
        cq_range_decoder d;
        cq_bit_model model = CQ_BIT_MODEL_INIT;
        for (k = 0; k < size; ++k) noise[k] = round % 3 == 0 ? 0xff : (uint8_t)next_random(&random);
        cq_range_decoder_init(&d, noise, size);
        for (k = 0; k < 100; ++k) {
            uint32_t total = 1 + (uint32_t)(next_random(&random) % 65536), slot = cq_decode_slot(&d, total);
            int bits = (int)(next_random(&random) % 33), bit;
            uint32_t raw;
            CHECK(slot < total);
            cq_decode_freq(&d, slot, 1, total);
            CHECK(d.code < d.range);
            raw = cq_decode_raw(&d, bits);
            CHECK(bits == 32 || raw >> bits == 0);
            bit = cq_decode_bit(&d, &model, 1 + (int)(k % 8));
            CHECK(bit == 0 || bit == 1);
            CHECK(d.code < d.range);
        }
        exact_free(noise);
    }
}

/* -- Bits ---------------------------------------------------------------------------------------------------------- */

TEST(a_bit_model_stays_within_its_limits_at_every_rate)
{
    int rate, bit;
    for (rate = 1; rate <= 8; ++rate) {
        for (bit = 0; bit < 2; ++bit) {
            cq_range_encoder e;
            cq_bit_model model = CQ_BIT_MODEL_INIT;
            int k;
            cq_range_encoder_init(&e, NULL, 0);
            for (k = 0; k < 5000; ++k) {
                cq_bit_model before = model;
                cq_encode_bit(&e, &model, rate, bit);
                CHECK(model >= 1 && model <= 65534);
                CHECK(bit ? model >= before : model <= before);
            }
            CHECK(bit ? model > 65000 : model < 536);
        }
    }
}

TEST(any_number_but_0_is_a_bit_that_is_set)
{
    static const int set[] = {1, 2, -1, 256, INT32_MAX, -INT32_MAX - 1};
    size_t k;
    for (k = 0; k < sizeof set / sizeof *set; ++k) {
        uint8_t byte[8];
        cq_range_encoder e;
        cq_bit_model model = 20000, same = 20000;
        cq_range_encoder_init(&e, byte, sizeof byte);
        cq_encode_bit(&e, &model, 4, set[k]);
        cq_encode_bit(&e, &same, 4, 1);
        CHECK_EQ(model, same);
        CHECK(model > 20000);
    }
}

TEST(a_model_learns_faster_at_a_lower_rate)
{
    int rate;
    cq_bit_model last = 65535;
    for (rate = 1; rate <= 8; ++rate) {
        cq_range_encoder e;
        cq_bit_model model = CQ_BIT_MODEL_INIT;
        cq_range_encoder_init(&e, NULL, 0);
        cq_encode_bit(&e, &model, rate, 1);
        CHECK(model > CQ_BIT_MODEL_INIT);
        CHECK(model < last);
        last = model;
    }
}

TEST(bits_at_both_limits_of_probability_come_back)
{
    /* Long runs bring the model to its limit, then the improbable bit comes. */
    int rate, common;
    for (rate = 1; rate <= 8; ++rate) {
        for (common = 0; common < 2; ++common) {
            static uint8_t data[4096];
            cq_range_encoder e;
            cq_range_decoder d;
            cq_bit_model m = CQ_BIT_MODEL_INIT, n = CQ_BIT_MODEL_INIT;
            int k;
            size_t size;
            cq_range_encoder_init(&e, data, sizeof data);
            for (k = 0; k < 9000; ++k) cq_encode_bit(&e, &m, rate, k % 3000 > 2995 ? !common : common);
            size = cq_range_encoder_finish(&e);
            CHECK(size < 300);
            cq_range_decoder_init(&d, data, size);
            for (k = 0; k < 9000; ++k) CHECK_EQ(cq_decode_bit(&d, &n, rate), k % 3000 > 2995 ? !common : common);
            CHECK_EQ(m, n);
        }
    }
}

TEST(a_model_set_to_its_limit_codes_both_bits)
{
    static const cq_bit_model limits[] = {1, 2, 32768, 65533, 65534};
    size_t k;
    int first, second;
    for (k = 0; k < sizeof limits / sizeof limits[0]; ++k) {
        for (first = 0; first < 2; ++first) {
            for (second = 0; second < 2; ++second) {
                uint8_t data[16];
                cq_range_encoder e;
                cq_range_decoder d;
                cq_bit_model m = limits[k], n = limits[k];
                size_t size;
                cq_range_encoder_init(&e, data, sizeof data);
                cq_encode_bit(&e, &m, 5, first);
                cq_encode_bit(&e, &m, 5, second);
                cq_encode_raw(&e, 0x5a, 8);
                size = cq_range_encoder_finish(&e);
                cq_range_decoder_init(&d, data, size);
                CHECK_EQ(cq_decode_bit(&d, &n, 5), first);
                CHECK_EQ(cq_decode_bit(&d, &n, 5), second);
                CHECK_EQ(cq_decode_raw(&d, 8), 0x5a);
                CHECK_EQ(m, n);
            }
        }
    }
}

TEST(a_hundred_thousand_sure_bits_cost_under_fourteen_bytes)
{
    /* 100000 * -log2(65534 / 65536) = 4.4 bits, and what learning costs. */
    cq_range_encoder e;
    cq_bit_model model = CQ_BIT_MODEL_INIT;
    int k;
    cq_range_encoder_init(&e, NULL, 0);
    for (k = 0; k < 100000; ++k) cq_encode_bit(&e, &model, 1, 0);
    CHECK(cq_range_encoder_finish(&e) < 14);
    cq_range_encoder_init(&e, NULL, 0);
    model = CQ_BIT_MODEL_INIT;
    for (k = 0; k < 100000; ++k) cq_encode_bit(&e, &model, 1, 1);
    CHECK(cq_range_encoder_finish(&e) < 14);
}

TEST(a_bit_at_even_odds_costs_one_bit)
{
    cq_range_encoder e;
    uint64_t random = 5;
    int k;
    size_t size;
    cq_range_encoder_init(&e, NULL, 0);
    for (k = 0; k < 80000; ++k) {
        cq_bit_model even = CQ_BIT_MODEL_INIT;
        cq_encode_bit(&e, &even, 4, (int)(next_random(&random) & 1));
    }
    size = cq_range_encoder_finish(&e);
    CHECK(size >= 9990 && size <= 10010);
}

/* -- Raw numbers --------------------------------------------------------------------------------------------------- */

TEST(raw_numbers_of_0_to_32_bits_come_back)
{
    int bits;
    for (bits = 0; bits <= 32; ++bits) {
        uint32_t mask = bits == 0 ? 0 : 0xffffffffu >> (32 - bits);
        uint32_t value[5], k;
        static uint8_t data[128];
        cq_range_encoder e;
        cq_range_decoder d;
        size_t size;
        value[0] = 0;
        value[1] = mask;
        value[2] = 0xaaaaaaaau & mask;
        value[3] = 0x55555555u & mask;
        value[4] = bits == 0 ? 0 : (uint32_t)1 << (bits - 1);
        cq_range_encoder_init(&e, data, sizeof data);
        for (k = 0; k < 20; ++k) cq_encode_raw(&e, value[(k * k) % 5], bits);
        size = cq_range_encoder_finish(&e);
        CHECK(size <= (20u * (uint32_t)bits + 7) / 8 + 1);
        cq_range_decoder_init(&d, data, size);
        for (k = 0; k < 20; ++k) CHECK_EQ(cq_decode_raw(&d, bits), value[(k * k) % 5]);
    }
}

TEST(only_the_low_bits_of_a_raw_number_count)
{
    int bits;
    for (bits = 0; bits <= 32; ++bits) {
        uint8_t one[16], two[16];
        uint32_t value = 0x9e3779b9u, mask = bits == 0 ? 0 : 0xffffffffu >> (32 - bits);
        cq_range_encoder e;
        size_t n, m;
        cq_range_encoder_init(&e, one, sizeof one);
        cq_encode_raw(&e, value, bits);
        n = cq_range_encoder_finish(&e);
        cq_range_encoder_init(&e, two, sizeof two);
        cq_encode_raw(&e, value & mask, bits);
        m = cq_range_encoder_finish(&e);
        CHECK_EQ(n, m);
        CHECK(memcmp(one, two, n) == 0);
    }
}

TEST(no_raw_bits_are_no_code)
{
    cq_range_encoder e;
    uint8_t data[8];
    int k;
    cq_range_encoder_init(&e, data, sizeof data);
    for (k = 0; k < 1000; ++k) cq_encode_raw(&e, 0xffffffffu, 0);
    CHECK_EQ(cq_range_encoder_finish(&e), 0);
}

/* -- Buffers ------------------------------------------------------------------------------------------------------- */

static size_t encode_sample(uint8_t *data, size_t size)
{
    cq_range_encoder e;
    cq_bit_model model = CQ_BIT_MODEL_INIT;
    uint64_t random = 6;
    int k;
    cq_range_encoder_init(&e, data, size);
    for (k = 0; k < 60; ++k) {
        cq_encode_bit(&e, &model, 4, (next_random(&random) & 3) == 0);
        cq_encode_freq(&e, (uint32_t)(next_random(&random) % 11), 1, 11);
        if (k % 10 == 0) cq_encode_raw(&e, (uint32_t)next_random(&random), 20);
    }
    return cq_range_encoder_finish(&e);
}

TEST(a_short_buffer_gets_the_head_of_the_code_and_the_count_is_the_whole)
{
    uint8_t whole[256];
    size_t size = encode_sample(whole, sizeof whole), k;
    REQUIRE(size < sizeof whole);
    CHECK_EQ(encode_sample(NULL, 0), size);
    for (k = 0; k <= size; ++k) {
        uint8_t *part = (uint8_t *)exact_alloc(k);
        CHECK_EQ(encode_sample(part, k), size);
        CHECK(memcmp(part, whole, k) == 0);
        exact_free(part);
    }
}

TEST(the_same_symbols_give_the_same_bytes)
{
    uint8_t one[256], two[256];
    size_t size = encode_sample(one, sizeof one);
    memset(two, 0xcc, sizeof two);
    CHECK_EQ(encode_sample(two, sizeof two), size);
    CHECK(memcmp(one, two, size) == 0);
}

TEST(the_code_of_a_known_sequence_is_known)
{
    /* By hand: range 0xffffffff, one third is 0x55555555; the middle symbol of three, [0x55555555, 0xaaaaaaaa), holds
     * 0x80000000, whose one byte has the most zeros behind it. */
    uint8_t data[8];
    cq_range_encoder e;
    cq_range_encoder_init(&e, data, sizeof data);
    cq_encode_freq(&e, 1, 1, 3);
    REQUIRE_EQ(cq_range_encoder_finish(&e), 1);
    CHECK_EQ(data[0], 0x80);
    /* 8 raw bits of 0x12 from 0xffffffff / 256 = 0x00ffffff: [0x11ffffee, 0x12ffffed) holds 0x12000000. */
    cq_range_encoder_init(&e, data, sizeof data);
    cq_encode_raw(&e, 0x12, 8);
    REQUIRE_EQ(cq_range_encoder_finish(&e), 1);
    CHECK_EQ(data[0], 0x12);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(an_empty_stream_has_no_bytes);
    RUN(zeros_at_the_end_are_not_written);
    RUN(the_last_byte_of_a_code_is_never_zero);
    RUN(no_shorter_code_means_the_same);
    RUN(any_bytes_may_follow_in_memory_but_only_size_bytes_are_read);
    RUN(a_code_that_no_encoder_writes_is_the_last_symbol);
    RUN(a_decoder_counts_the_bytes_it_wanted_past_the_end);
    RUN(a_decoder_has_read_four_bytes_more_than_the_encoder_has_shifted_out);
    RUN(finish_costs_at_most_two_bytes);
    RUN(a_carry_goes_through_a_long_run_of_ff_bytes);
    RUN(a_run_of_ff_bytes_without_a_carry_comes_out_as_it_is);
    RUN(a_code_ends_well_while_bytes_still_wait_for_a_carry);
    RUN(the_first_and_the_last_symbol_survive_at_every_total);
    RUN(a_total_of_two_to_the_sixteen_is_allowed);
    RUN(a_symbol_that_owns_every_slot_costs_nothing);
    RUN(symbols_of_any_width_come_back);
    RUN(a_decoder_of_noise_returns_slots_in_range);
    RUN(a_bit_model_stays_within_its_limits_at_every_rate);
    RUN(any_number_but_0_is_a_bit_that_is_set);
    RUN(a_model_learns_faster_at_a_lower_rate);
    RUN(bits_at_both_limits_of_probability_come_back);
    RUN(a_model_set_to_its_limit_codes_both_bits);
    RUN(a_hundred_thousand_sure_bits_cost_under_fourteen_bytes);
    RUN(a_bit_at_even_odds_costs_one_bit);
    RUN(raw_numbers_of_0_to_32_bits_come_back);
    RUN(only_the_low_bits_of_a_raw_number_count);
    RUN(no_raw_bits_are_no_code);
    RUN(a_short_buffer_gets_the_head_of_the_code_and_the_count_is_the_whole);
    RUN(the_same_symbols_give_the_same_bytes);
    RUN(the_code_of_a_known_sequence_is_known);
    return TEST_END();
}
