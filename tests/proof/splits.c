/* Proofs about how splits are coded: scores of candidates, what their weights learn, residuals of fast streams.
 *
 * Each is about one function from any state that has the invariants below; what it calls is real, or a stub that says
 * what another claim proves. Rings have 3 to SIZE spokes. Invariants:
 *
 *     mean_bits   0 .. 128 (CQI_SPREADS - 1): those of cqi_start
 *     weights     at most 8 octaves and what 1024 splits add, MOST_WEIGHT; so scores of one end are at most three times
 *                 that, of a number of steps twice
 *     gains       0 between splits */
#include "proof.h"

#ifndef SIZE
#define SIZE CQ_MAX_VALENCE
#endif
#ifndef COMPONENTS
#define COMPONENTS 3
#endif
#define MOST_MEAN (128 * (CQI_SPREADS - 1))
#define MOST_WEIGHT (CQI_MOST + CQI_LIMIT_EVERY * CQI_STEP)

/* Of a pair of values on a ring, the upper 24 bits of exact ones; and of all of a ring. */
#define MOST_OFFSET 0xffffff
#define MOST_SPREAD ((uint32_t)SIZE * MOST_OFFSET)

static cq_decoder d;

static int within(int32_t x, int32_t limit) { return x >= -limit && x <= limit; }

static int32_t any_within(int32_t limit)
{
    int32_t x = nondet_int();
    ASSUME(within(x, limit));
    return x;
}

/* -- Residuals of fast streams ------------------------------------------------------------------------------------- */

static int mean_holds(const cq_decoder *of, int half_bits) { return of->model.mean_bits[half_bits] <= MOST_MEAN; }

/* What `d` writes `reader` reads: each symbol's value, and what it is about, the index of a model or, of raw bits,
 * CQI_MODELS and their number. */
enum { MOST_SYMBOLS = 16 };
static cq_decoder reader;
static uint32_t written[MOST_SYMBOLS];
static int about[MOST_SYMBOLS], num_written, num_read;

static uint32_t symbol(const cq_decoder *of, int what, uint32_t value)
{
    PROVE(of == &d || of == &reader);
    if (of == &d) {
        PROVE(num_written < MOST_SYMBOLS);
        about[num_written] = what;
        return written[num_written++] = value;
    }
    PROVE(num_read < num_written && about[num_read] == what);
    return written[num_read++];
}

int stub_copy_bit(cq_decoder *of, int index, int bit)
{
    PROVE(index >= CQI_FAST && index < CQI_PRIORS && (of != &d || bit == 0 || bit == 1));
    return (int)symbol(of, index, (uint32_t)bit);
}

/* As claim_raw_decodes of range_coder.c says; a writer gets what it gave. */
uint32_t stub_copy_raw(cq_decoder *of, uint32_t value, int bits)
{
    PROVE(bits >= 0 && bits <= 32);
    if (of == &reader) return symbol(of, CQI_MODELS + bits, 0);
    symbol(of, CQI_MODELS + bits, bits < 32 ? value & (((uint32_t)1 << bits) - 1) : value);
    return value;
}

/* Any residual: what is read is what was written, by the same means. */
void claim_fast_decodes(void)
{
    const int half_bits = any_between(0, CQI_SPREADS - 1);
    const int32_t residual = nondet_int();
    d.model.mean_bits[half_bits] = reader.model.mean_bits[half_bits] = nondet_u16();
    ASSUME(mean_holds(&d, half_bits));
    PROVE(cqi_code_fast(&d, half_bits, residual) == residual);
    PROVE(mean_holds(&d, half_bits));
    PROVE(cqi_code_fast(&reader, half_bits, nondet_int()) == residual);
    PROVE(reader.model.mean_bits[half_bits] == d.model.mean_bits[half_bits]);
    PROVE(num_read == num_written);
    REACHED();
}

int stub_any_bit(cq_decoder *of, int index, int bit)
{
    (void)bit;
    PROVE(of == &d && index >= CQI_FAST && index < CQI_PRIORS);
    return any_between(0, 1);
}

static int num_raw;

uint32_t stub_any_raw(cq_decoder *of, uint32_t value, int bits)
{
    value = nondet_u32();
    PROVE(of == &d && bits >= 0 && bits <= 32);
    ASSUME(bits == 32 || value >> bits == 0);
    num_raw += bits;
    return value;
}

/* Any symbols, as in a stream that no encoder wrote. */
void claim_fast_is_safe(void)
{
    const int half_bits = any_between(0, CQI_SPREADS - 1);
    d.model.mean_bits[half_bits] = nondet_u16();
    ASSUME(mean_holds(&d, half_bits));
    cqi_code_fast(&d, half_bits, 0);
    PROVE(mean_holds(&d, half_bits));
    PROVE(num_raw <= 5 + 32);
    REACHED();
}

int32_t stub_code_fast(cq_decoder *of, int half_bits, int32_t residual)
{
    PROVE(of == &d && half_bits >= 0 && half_bits < CQI_SPREADS);
    return residual;
}

/* Any spread that claim_offsets leaves. */
void claim_spreads(void)
{
    cq_channel channel;
    uint32_t spread = nondet_u32();
    channel.kind = nondet_u8();
    channel.components = nondet_u8();
    channel.bits = nondet_u8();
    channel.merge = nondet_u8();
    ASSUME(cqi_channel_is_valid(&channel) && spread <= MOST_SPREAD);
    d.shape.fast = 1;
    cqi_code_plain(&d, &channel, spread, nondet_int());
    REACHED();
}

/* -- Values on the ring -------------------------------------------------------------------------------------------- */

static int32_t value_of[(SIZE + 1) * CQ_MAX_COMPONENTS];

/* Values that fit, of ring vertices 0, 1, ... around the centre SIZE, some of them virtual. The sums that predict a
 * residual of any pair, which come from sums of what is before a vertex, are those over the fans. */
void claim_offsets(void)
{
    static cq_index origin_of[1] = { SIZE };
    cqi_ring *r = &d.ring;
    cq_channel *channel = &d.shape.channel[0];
    int p = nondet_int(), q = nondet_int(), k;
    int32_t sum_b = 0, sum_a = 0;
    uint32_t c = nondet_u32(), spread = 0;
    cqi_fans fans;
    channel->components = COMPONENTS;
    channel->bits = nondet_int() ? CQ_EXACT_BITS : (uint8_t)any_between(1, CQ_MAX_BITS);
    for (k = 0; k < (SIZE + 1) * COMPONENTS; k++) {
        value_of[k] = nondet_int();
        ASSUME(cqi_value_fits(channel, value_of[k]));
    }
    r->size = any_between(3, SIZE);
    for (k = 0; k < SIZE; k++) r->seen[k] = nondet_int() ? SIZE : (cq_index)k;
    d.mesh.origin = origin_of;
    d.channel[0] = value_of;
    ASSUME(c < COMPONENTS && p >= 0 && p < q && q < r->size);
    cqi_read_offsets(&d, 0);
    for (k = 0; k < SIZE; k++) {
        const int32_t *before = r->before + (uint32_t)k * COMPONENTS + c;
        const int32_t x = k < r->size ? before[COMPONENTS] - before[0] : 0;
        PROVE(within(x, MOST_OFFSET));
        sum_b += k >= p && k <= q ? x : 0;
        sum_a += k <= p || k >= q ? x : 0;
        spread += cqi_abs(x);
    }
    cqi_sum_fans(r, c, COMPONENTS, p, q, &fans);
    PROVE(fans.sum_a == sum_a && fans.sum_b == sum_b && r->spread[c] == spread && r->offset_channel == 0);
    PROVE(spread <= MOST_SPREAD);
    REACHED();
}

static void any_offsets(void)
{
    int k;
    d.ring.size = any_between(3, SIZE);
    for (k = 0; k < 3; k++) d.ring.before[k] = 0;
    for (k = 0; k < 3 * SIZE; k++) d.ring.before[k + 3] = d.ring.before[k] + any_within(MOST_OFFSET);
}

static void any_states(void)
{
    int k;
    for (k = 0; k < SIZE; k++) d.ring.state[k] = (uint8_t)any_between(CQI_FREE, CQI_NEVER);
}

/* Offsets in the scale of the ring have 8 bits; one more if they are negative. */
void claim_scale(void)
{
    int k;
    any_offsets();
    cqi_scale_ring(&d.ring);
    PROVE(d.ring.shift >= -16 && d.ring.shift <= 8);
    for (k = 0; k < 3 * SIZE; k++) PROVE(k >= 3 * d.ring.size || within(d.ring.now.scaled[k], 256));
    REACHED();
}

/* Lengths are positive, and only those of virtual spokes are CQI_WILD. */
void claim_lengths(void)
{
    int k;
    any_offsets();
    any_states();
    cqi_measure_ring(&d.ring);
    for (k = 0; k < SIZE && k < d.ring.size; k++) {
        PROVE(d.ring.of_p[k] >= 1 && d.ring.of_p[k] <= CQI_WILD);
        PROVE((d.ring.of_p[k] == CQI_WILD) == (d.ring.state[k] == CQI_NEVER));
    }
    REACHED();
}

/* Any lengths: classes of the table, and the last one is that of virtual spokes. */
void claim_classes(void)
{
    int k;
    d.ring.size = any_between(3, SIZE);
    for (k = 0; k < SIZE; k++) d.ring.of_p[k] = any_between(1, CQI_WILD);
    cqi_classify_edges(&d.ring);
    for (k = 0; k < SIZE && k < d.ring.size; k++) {
        PROVE(d.ring.edge[k] <= 15);
        PROVE((d.ring.edge[k] == 15) == (d.ring.of_p[k] == CQI_WILD));
    }
    REACHED();
}

/* -- Scores -------------------------------------------------------------------------------------------------------- */

void stub_read_offsets(cq_decoder *of, uint32_t k)
{
    PROVE(of == &d && k < CQ_MAX_CHANNELS);
    d.ring.offset_channel = k;
}

void stub_measure_ring(cqi_ring *r) { PROVE(r == &d.ring); }

void stub_classify_edges(cqi_ring *r)
{
    int k;
    PROVE(r == &d.ring);
    for (k = 0; k < SIZE; k++) r->edge[k] = (uint8_t)any_between(0, 15);
}

/* Of a fast stream, with positions or without: scores and entries in their bounds, and no other weight is read. */
void claim_scores(void)
{
    cqi_ring *r = &d.ring;
    int k, j;
    d.shape.fast = 1;
    d.shape.num_channels = (uint32_t)any_between(0, 1);
    d.shape.channel[0].kind = CQ_POSITION;
    d.shape.channel[0].merge = (uint8_t)any_between(CQ_MIDPOINT, CQ_PER_FACE);
    r->size = any_between(3, SIZE);
    r->level_class = any_between(0, 2);
    any_states();
    for (k = 0; k < SIZE; k++) r->valence[k] = (uint8_t)any_between(3, CQI_LARGE_VALENCE);
    for (k = 0; k < CQI_WEIGHTS; k++) d.model.weight[k] = k < CQI_FAST_WEIGHTS ? any_within(MOST_WEIGHT) : INT32_MAX;
    for (k = 0; k < SIZE; k++) r->now.gain[0][k] = r->now.gain[1][k] = r->now.gain[2][k] = nondet_int();
    cqi_score_ring(&d);
    for (k = 0; k < SIZE && k < r->size; k++) {
        PROVE(!r->now.gain[0][k] && !r->now.gain[1][k] && !r->now.gain[2][k]);
        for (j = 0; j < 3; j++) PROVE(r->entry[k][j] >= CQI_END_STATE && r->entry[k][j] < CQI_FAST_WEIGHTS - 1);
        PROVE(r->entry[k][0] < r->entry[k][1] && r->entry[k][1] < r->entry[k][2]);
        PROVE(within(r->of_p[k], 3 * MOST_WEIGHT) && within(r->of_q[k], 3 * MOST_WEIGHT));
        PROVE(within(r->of_steps[k], 2 * MOST_WEIGHT));
    }
    REACHED();
}

void claim_share(void)
{
    const uint32_t share = cqi_share(nondet_u32());
    PROVE(share >= 1 && share <= (uint32_t)1 << CQI_HEAVIEST);
    REACHED();
}

uint32_t stub_share(uint32_t below)
{
    (void)below;
    return (uint32_t)any_between(1, 1 << CQI_HEAVIEST);
}

static uint32_t the_slot;

uint32_t stub_decode_slot(cq_range_decoder *of, uint32_t total)
{
    PROVE(of == &d.range && total >= 1 && total < (uint32_t)1 << 22);
    the_slot = nondet_u32();
    ASSUME(the_slot < total);
    return the_slot;
}

void stub_decode_freq(cq_range_decoder *of, uint32_t start, uint32_t freq, uint32_t total)
{
    PROVE(of == &d.range && freq >= 1 && start + freq <= total);
    PROVE(the_slot >= start && the_slot - start < freq);
}

static int num_learned;

void stub_find_gradients(int32_t *share, int count, uint32_t total, int chosen)
{
    PROVE(share == d.score && total >= 1 && chosen >= 0 && chosen < count);
    num_learned++;
}

/* Any scores, any stream: one of the candidates, the one whose part of the total holds the slot. */
void claim_scored(void)
{
    const int count = any_between(1, SIZE - 1), learns = any_between(0, 1);
    int k, value;
    d.shape.fast = 1;
    d.ring.side = any_between(0, 2);
    for (k = 0; k < SIZE; k++) d.score[k] = nondet_int();
    value = cqi_code_scored(&d, count, nondet_int(), learns);
    PROVE(value >= 0 && value < count && num_learned == learns);
    REACHED();
}

/* What claim_best_pair, claim_scored and claim_gradients say. Each candidate has a score in bounds, and what it learns
 * is handed on once. */
static int num_candidates, num_gained;

int stub_best_pair(const cqi_ring *r, int steps)
{
    PROVE(r == &d.ring && steps >= 1 && steps < r->size);
    return any_between(0, r->size - 1 - steps);
}

int stub_code_scored(cq_decoder *of, int count, int value, int learns)
{
    int k;
    (void)value;
    PROVE(of == &d && count >= 1 && count < SIZE && num_gained == (learns ? num_candidates : 0));
    for (k = 0; k < SIZE && k < count; k++) {
        PROVE(within(d.score[k], 8 * MOST_WEIGHT));
        d.score[k] = any_within(CQI_STEP);
    }
    num_candidates = num_gained + count;
    return any_between(0, count - 1);
}

void stub_gain(cqi_ring *r, int p, int q, int32_t gradient)
{
    PROVE(r == &d.ring && p >= 0 && p < q && q < r->size && within(gradient, CQI_STEP));
    num_gained++;
}

void stub_learn_gains(cqi_model *m, cqi_ring *r)
{
    PROVE(m == &d.model && r == &d.ring && num_gained == num_candidates);
    num_learned++;
}

/* Any scores, any stream: a pair of the ring, where the side of a first gate says so. One of CQI_LEARN_EVERY splits is
 * learned from. */
void claim_pair(void)
{
    cqi_ring *r = &d.ring;
    int p = 0, q = 0, k;
    d.shape.fast = 1;
    d.mesh.num_vertices = any_index();
    r->size = any_between(3, SIZE);
    r->side = any_between(0, 2);
    for (k = 0; k < SIZE; k++) {
        r->of_p[k] = any_within(3 * MOST_WEIGHT);
        r->of_q[k] = any_within(3 * MOST_WEIGHT);
        r->of_steps[k] = any_within(2 * MOST_WEIGHT);
    }
    cqi_code_steps(&d, &p, &q);
    PROVE(p >= 0 && p < q && q < r->size);
    PROVE(r->side != 1 || q == r->size - 1);
    PROVE(r->side != 2 || p == 0);
    PROVE(num_learned == (d.mesh.num_vertices % CQI_LEARN_EVERY == 0) && (num_learned || !num_gained));
    REACHED();
}

static void any_ends(void)
{
    int k;
    d.ring.size = any_between(3, SIZE);
    for (k = 0; k < SIZE; k++) {
        d.ring.of_p[k] = any_within(3 * MOST_WEIGHT);
        d.ring.of_q[k] = any_within(3 * MOST_WEIGHT);
    }
}

/* A pair so many steps apart. */
void claim_best_pair(void)
{
    const int steps = nondet_int();
    int at;
    any_ends();
    ASSUME(steps >= 1 && steps < d.ring.size);
    at = cqi_best_pair(&d.ring, steps);
    PROVE(at >= 0 && at + steps < d.ring.size);
    REACHED();
}

/* None of those has a higher score. */
void claim_no_better_pair(void)
{
    const cqi_ring *r = &d.ring;
    const int steps = nondet_int(), other = nondet_int();
    int at;
    any_ends();
    ASSUME(steps >= 1 && steps < r->size && other >= 0 && other < r->size - steps);
    at = cqi_best_pair(r, steps);
    PROVE(r->of_p[at] + r->of_q[at + steps] >= r->of_p[other] + r->of_q[other + steps]);
    REACHED();
}

/* Any shape: models and weights begin in their bounds. */
void claim_models(void)
{
    int k;
    d.shape.fast = (uint32_t)any_between(0, 1);
    d.shape.num_channels = (uint32_t)any_between(0, 1);
    d.shape.channel[0].kind = CQ_POSITION;
    d.shape.channel[0].merge = (uint8_t)any_between(CQ_MIDPOINT, CQ_PER_FACE);
    for (k = 0; k < CQI_WEIGHTS; k++) d.model.weight[k] = INT32_MAX;
    cqi_model_init(&d.model, &d.shape);
    for (k = 0; k < CQI_WEIGHTS; k++) PROVE(within(d.model.weight[k], CQI_MOST));
    for (k = 0; k < CQI_MODELS; k++) PROVE(d.model.bit[k] >= 32 && d.model.bit[k] <= 65504);
    REACHED();
}

/* -- What is learned ----------------------------------------------------------------------------------------------- */

/* What the others lose the chosen one gains, and nobody more than a step. */
void claim_gradients(void)
{
    int32_t share[SIZE], all = 0;
    uint32_t total = 0;
    int count = any_between(1, SIZE), chosen = nondet_int(), k;
    ASSUME(chosen >= 0 && chosen < count);
    for (k = 0; k < SIZE && k < count; k++) total += (uint32_t)(share[k] = any_between(1, 1 << CQI_HEAVIEST));
    cqi_find_gradients(share, count, total, chosen);
    for (k = 0; k < SIZE && k < count; k++) {
        PROVE(k == chosen ? share[k] >= 0 && share[k] <= CQI_STEP : share[k] >= -CQI_STEP && share[k] <= 0);
        all += share[k];
    }
    PROVE(all == 0);
    REACHED();
}

static int the_weight, num_times;

void stub_learn(cqi_model *m, int index, int32_t gradient)
{
    PROVE(m == &d.model && index >= 0 && index < CQI_FAST_WEIGHTS && within(gradient, 5 * CQI_STEP));
    num_times += index == the_weight;
}

/* A candidate's part is that of its ends and of the steps between them. Of what is learned no weight gets more than one
 * part for each end or number of steps, so not more than all candidates have. */
void claim_gains(void)
{
    cqi_ring *r = &d.ring;
    const int32_t gradient = any_within(CQI_STEP);
    int32_t of_p, of_q, of_steps;
    int p = nondet_int(), q = nondet_int(), k;
    the_weight = any_between(0, CQI_FAST_WEIGHTS - 1);
    r->size = any_between(3, SIZE);
    r->level_class = any_between(0, 2);
    for (k = 0; k < SIZE; k++) {
        r->entry[k][0] = (uint16_t)(CQI_END_STATE + 2 * any_between(0, 14 * 6 - 1));
        r->entry[k][1] = (uint16_t)(CQI_END_VALENCE + 2 * any_between(0, 3 * 14 - 1));
        r->entry[k][2] = (uint16_t)(CQI_END_EDGE + 2 * any_between(0, 15));
        r->now.gain[0][k] = any_within(4 * CQI_STEP);
        r->now.gain[1][k] = any_within(4 * CQI_STEP);
        r->now.gain[2][k] = any_within(4 * CQI_STEP);
    }
    ASSUME(p >= 0 && p < q && q < r->size);
    of_p = r->now.gain[0][p];
    of_q = r->now.gain[1][q];
    of_steps = r->now.gain[2][q - p];
    cqi_gain(r, p, q, gradient);
    PROVE(r->now.gain[0][p] == of_p + gradient && r->now.gain[1][q] == of_q + gradient);
    PROVE(r->now.gain[2][q - p] == of_steps + gradient);
    cqi_learn_gains(&d.model, r);
    PROVE(num_times <= r->size);
    REACHED();
}
