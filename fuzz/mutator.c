/* A mutator for inputs of lean.c that changes one decision and keeps the others. Changing a byte of an arithmetic code
 * would change all decisions behind it.
 *
 * This file is compiled with a copy of the header in which the definitions of the five functions that decode (a bit with
 * a model, one of a probability, slots and raw bits) have other names (original_...): here they are replaced. While a
 * stream is read they do what they do and note what was decided; while one is written, they take decisions from the
 * notes, changed in one place, and encode them with the model that the decoder hands in. So all that is known here of
 * the format is that its decoder asks those five functions. A decoder that decides in another way is found out by
 * mutator_works(), and inputs
 * are then changed as bytes alone. */
#include "lean.h"

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
int mutator_works(const uint8_t *data, size_t size);

enum { MOST_DECISIONS = 20000, MOST_PAYLOAD = 8192 };

typedef enum kind { BIT, SLOT, RAW } kind;

typedef struct decision {
    uint8_t kind;
    uint32_t value;
} decision;

/* -- What the decoder asks ----------------------------------------------------------------------------------------- */

static struct {
    int writing;
    decision noted[MOST_DECISIONS], written[MOST_DECISIONS];
    size_t num_noted, num_written, next;     /* next: of those noted, the one to be written */
    cq_range_encoder encoder;
    uint8_t payload[MOST_PAYLOAD];
    uint32_t random;
} state;

static uint32_t random_bits(void)
{
    state.random ^= state.random << 13;
    state.random ^= state.random >> 17;
    state.random ^= state.random << 5;
    return state.random;
}

static uint32_t note(kind kind, uint32_t value)
{
    decision d = { (uint8_t)kind, value };
    if (!state.writing && state.num_noted < MOST_DECISIONS) state.noted[state.num_noted++] = d;
    if (state.writing && state.num_written < MOST_DECISIONS) state.written[state.num_written++] = d;
    return value;
}

/* What is to be written: the next decision of this kind that was noted, or when there are no more, any: `usual`. */
static uint32_t next_of_kind(kind kind, uint32_t usual)
{
    size_t k;
    for (k = state.next; k < state.num_noted; k++)
        if (state.noted[k].kind == kind) {
            state.next = k + 1;
            return state.noted[k].value;
        }
    return usual;
}

static int cqi_decode_part(cq_range_decoder *d, uint32_t p)
{
    uint32_t bit;
    if (!state.writing) return (int)note(BIT, (uint32_t)original_decode_part(d, p));
    bit = next_of_kind(BIT, random_bits() % 65536 < p) != 0;
    cqi_encode_part(&state.encoder, p, (int)bit);
    return (int)note(BIT, bit);
}

/* The original one asks the one above, but is one decision. */
static int cqi_decode_adaptive(cq_range_decoder *d, cq_bit_model *model, int rate)
{
    uint32_t bit;
    if (!state.writing) {
        const size_t before = state.num_noted;
        bit = (uint32_t)original_decode_adaptive(d, model, rate);
        state.num_noted = before;
        return (int)note(BIT, bit);
    }
    bit = next_of_kind(BIT, random_bits() % 65536 < *model) != 0;
    cq_encode_bit(&state.encoder, model, rate, (int)bit);
    return (int)note(BIT, bit);
}

static uint32_t cq_decode_slot(cq_range_decoder *d, uint32_t total)
{
    if (!state.writing) return original_decode_slot(d, total);
    return next_of_kind(SLOT, random_bits()) % total;
}

/* Of the slots of a symbol the first one is noted. */
static void cq_decode_freq(cq_range_decoder *d, uint32_t start, uint32_t freq, uint32_t total)
{
    if (!state.writing) original_decode_freq(d, start, freq, total);
    else cq_encode_freq(&state.encoder, start, freq, total);
    note(SLOT, start);
}

/* The original one asks the two above, but is one decision. */
static uint32_t cq_decode_raw(cq_range_decoder *d, int bits)
{
    uint32_t value;
    if (!state.writing) {
        size_t before = state.num_noted;
        value = original_decode_raw(d, bits);
        state.num_noted = before;
        return note(RAW, value);
    }
    value = next_of_kind(RAW, random_bits()) & (uint32_t)(((uint64_t)1 << bits) - 1);
    cq_encode_raw(&state.encoder, value, bits);
    return note(RAW, value);
}

/* -- Reading and writing streams ----------------------------------------------------------------------------------- */

/* Runs a decoder over a payload; whatever that returns, the decisions have been asked. */
static void ask(const cq_shape *shape, const uint8_t *payload, size_t size)
{
    stream s = frame(shape, payload, size);
    size_t memory_size = cq_decoder_bytes(shape);
    void *memory = block(memory_size);
    cq_decoder *d = (cq_decoder *)block(sizeof *d);
    cq_bytes in = { s.data, s.size };
    if (cq_decoder_init(d, memory, memory_size) == CQ_OK && cq_decode(d, &in, CQ_NO_LIMIT) == CQ_NEED_INPUT)
        cq_decode(d, NULL, CQ_NO_LIMIT);
    free(d);
    free(memory);
    free(s.data);
}

static void read_decisions(const cq_shape *shape, const uint8_t *payload, size_t size)
{
    state.writing = 0;
    state.num_noted = 0;
    ask(shape, payload, size);
}

/* The payload of what was noted; returns its size. The decoder reads zeros meanwhile, of which it has enough for any
 * step and takes none. */
static size_t write_decisions(const cq_shape *shape)
{
    static const uint8_t zeros[CQI_BUFFER_BYTES];
    state.writing = 1;
    state.num_written = state.next = 0;
    cq_range_encoder_init(&state.encoder, state.payload, sizeof state.payload);
    ask(shape, zeros, sizeof zeros);
    return cq_range_encoder_finish(&state.encoder);
}

static uint32_t changed(uint8_t kind, uint32_t value)
{
    if (kind == BIT) return !value;
    if (random_bits() % 4 == 0) return random_bits();
    return random_bits() % 2 ? value + random_bits() % 4 : value ^ (uint32_t)1 << random_bits() % 32;
}

/* One decision is another one, missing, or there twice. */
static void change_one(void)
{
    decision *const noted = state.noted;
    const size_t at = random_bits() % state.num_noted;
    switch (random_bits() % 8) {
    case 0:
        memmove(noted + at, noted + at + 1, (--state.num_noted - at) * sizeof *noted);
        break;
    case 1:
        if (state.num_noted == MOST_DECISIONS) break;
        memmove(noted + at + 1, noted + at, (state.num_noted++ - at) * sizeof *noted);
        break;
    default: noted[at].value = changed(noted[at].kind, noted[at].value);
    }
}

/* -- For libFuzzer and run.c --------------------------------------------------------------------------------------- */

/* Of what was noted, how much is at the start of what was written. */
static size_t num_equal(void)
{
    size_t k = 0;
    while (k < state.num_noted && k < state.num_written && state.noted[k].kind == state.written[k].kind &&
           state.noted[k].value == state.written[k].value)
        k++;
    return k;
}

/* 1 if what is read from a payload and written again without a change is read as the same. Of a payload that ends early
 * more is written than was read. */
int mutator_works(const uint8_t *data, size_t size)
{
    input in = { data, size };
    cq_shape shape;
    size_t written, n;
    take_small_shape(&in, &shape);
    read_decisions(&shape, in.data, in.size);
    n = state.num_noted;
    state.random = 1;
    written = write_decisions(&shape);
    if (num_equal() < n || written > MOST_PAYLOAD) return 0;
    read_decisions(&shape, state.payload, written);
    return num_equal() >= n;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    input in = { data, size };
    cq_shape shape;
    size_t head, written;
    state.random = seed | 1;
    take_small_shape(&in, &shape);
    head = size - in.size;
    if (random_bits() % 2 == 0 || in.size == 0) return LLVMFuzzerMutate(data, size, max_size);
    read_decisions(&shape, in.data, in.size);
    if (state.num_noted == 0) return LLVMFuzzerMutate(data, size, max_size);
    change_one();
    written = write_decisions(&shape);
    if (head + written > max_size || written > MOST_PAYLOAD) return LLVMFuzzerMutate(data, size, max_size);
    memcpy(data + head, state.payload, written);
    return head + written;
}
