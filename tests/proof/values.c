/* Proofs about the values of all channels, whatever a stream says: what is stored is in the range of its channel, or it
 * is refused; sums do not overflow. Channels are any that a header may name, values any that they may have, of which
 * exact ones are any 32 bits; what is coded is any answer. */
#include "vectors.h"

enum { ROWS = 3 };
static cq_decoder d;
static cqi_fan *const f = &d.now.fan;
static cq_value values[ROWS * CQ_MAX_COMPONENTS];
static cq_channel *const channel = &d.shape.channel[0];

/* A channel, and values of three vertices or rows of it. */
static void any_values(void)
{
    static cqi_fan fan;
    int k;
    d.now.fan = fan;
    channel->kind = nondet_u8();
    channel->merge = nondet_u8();
    channel->components = nondet_u8();
    channel->bits = nondet_u8();
    ASSUME(cqi_channel_is_valid(channel) && cqi_fits_value(channel));
    for (k = 0; k < ROWS * CQ_MAX_COMPONENTS; k++) {
        values[k] = (cq_value)nondet_u32();
        ASSUME(cqi_value_fits(channel, values[k]));
    }
    d.channel[0] = values;
    d.shape.num_channels = 1;
    d.located = any_between(-1, 1);
}

static cq_index any_row(void) { return (cq_index)any_between(0, ROWS - 1); }

static uint32_t any_component(void)
{
    const uint32_t c = nondet_u32();
    ASSUME(c < channel->components);
    return c;
}

static int all_fit(void)
{
    int k, fit = 1;
    for (k = 0; k < ROWS * CQ_MAX_COMPONENTS; k++) fit &= cqi_value_fits(channel, values[k]);
    return fit;
}

/* See claim_residual and claim_row_residual. */
static int32_t any_residual(int most)
{
    const int32_t x = nondet_int();
    PROVE(most == (cqi_is_exact(channel) ? 32 : 26));
    ASSUME(most == 32 || x == CQI_WILD || within(x, (1 << 26) - 1));
    return x;
}

int32_t stub_row_residual(cq_decoder *of, int set, int half_bits, int most, int32_t residual)
{
    (void)residual;
    PROVE(of == &d && set >= 0 && set < CQI_ROW_SETS && half_bits >= 0 && half_bits <= 78);
    return any_residual(most);
}

/* -- The base ------------------------------------------------------------------------------------------------------ */

int32_t stub_predict_base(const cq_decoder *of, const cq_channel *c, const cq_value *from, cq_index v)
{
    (void)v;
    PROVE(of == &d && c == channel && from >= values && from < values + channel->components);
    return nondet_int();
}

int32_t stub_base_residual(cq_decoder *of, const cq_channel *c, int32_t x, int32_t *size)
{
    (void)x, (void)size;
    PROVE(of == &d && c == channel);
    return any_residual(cqi_most_bits(c));
}

void claim_base_value(void)
{
    int32_t size = 0;
    any_values();
    if (!cqi_code_base_value(&d, 0, any_component(), any_row(), &size)) return;
    PROVE(all_fit());
    REACHED();
}

/* -- Vertices and rows by a fan ------------------------------------------------------------------------------------ */

int stub_code_rest(cq_decoder *of, uint32_t k, uint32_t c, cq_index input, int32_t *rest)
{
    (void)input;
    PROVE(of == &d && k == 0 && c < channel->components);
    *rest = nondet_int();
    return any_between(0, 1);
}

/* Differences of values have 24 bits and a sign. */
int32_t stub_compare_fan(cq_decoder *of, uint32_t k, uint32_t c, int joints, int32_t *mean, uint32_t *spread)
{
    PROVE(of == &d && k == 0 && c < channel->components && joints == -1);
    *mean = any_between(-(1 << 24), 1 << 24);
    *spread = nondet_u32();
    ASSUME(*spread <= 25u << 25);
    return any_signed(24);
}

int32_t stub_fit(const cqi_fan *of, const int32_t *x, int32_t mean, uint32_t *off)
{
    PROVE(of == f && x == f->scratch[0] && within(mean, 1 << 24));
    *off = nondet_u32();
    return any_between(-(1 << 26), 1 << 26);
}

void stub_plain_features(cq_decoder *of, uint32_t k, uint32_t c, int joints, int32_t a, int32_t mean, int32_t *feature)
{
    (void)k, (void)c, (void)joints;
    PROVE(of == &d && fits(a, 24) && within(mean, 1 << 24));
    feature[0] = any_between(-(1 << 25), 1 << 25);
    feature[1] = any_between(-(1 << 24), 1 << 24);
    feature[2] = any_between(-(1 << 25), 1 << 25);
}

void stub_follow(int16_t *weight, int64_t product)
{
    (void)product;
    PROVE(weight >= d.model.plain[0] && weight < d.model.plain[0] + CQI_FEATURES);
}

void stub_learn_skin(cq_decoder *of, uint32_t k, uint32_t c, int32_t value)
{
    PROVE(of == &d && k == 0 && c < channel->components && cqi_value_fits(channel, value));
}

void claim_number(void)
{
    uint32_t c;
    cq_index row;
    int k;
    any_values();
    f->size = any_between(2, CQ_MAX_VALENCE + 1);
    for (k = 0; k < CQI_FEATURES; k++) d.model.plain[0][k] = (int16_t)nondet_int();
    d.model.skin[0] = nondet_int();
    d.model.skin[1] = nondet_int();
    c = any_component();
    row = any_row();
    if (!cqi_code_number(&d, 0, c, 0, values + (size_t)row * channel->components + c)) return;
    PROVE(all_fit());
    REACHED();
}

/* -- Rows at a seam, and copies ------------------------------------------------------------------------------------ */

/* Of any row, by those near and far, if they are there. */
static void prove_beside(int (*code)(cq_decoder *of, uint32_t k, uint32_t c, cq_index wedge, cq_index near, cq_index far,
                                     cq_value *to))
{
    uint32_t c;
    cq_index row, near, far;
    any_values();
    near = nondet_int() ? CQ_NONE : any_row();
    far = nondet_int() ? CQ_NONE : any_row();
    c = any_component();
    row = any_row();
    if (!code(&d, 0, c, 0, near, far, values + (size_t)row * channel->components + c)) return;
    PROVE(all_fit());
    REACHED();
}

void claim_near(void) { prove_beside(cqi_code_near); }

/* A value of those beside it, or of the bits of its channel; models are those of faces. */
int stub_code_bit(cq_decoder *of, int index, int bit)
{
    (void)bit;
    PROVE(of == &d && index >= CQI_FACE && index < CQI_FACE + 12);
    return any_between(0, 1);
}

void claim_copied(void)
{
    uint32_t c;
    cq_index row;
    int k;
    any_values();
    f->size = any_between(2, CQ_MAX_VALENCE + 1);
    for (k = 0; k <= CQ_MAX_VALENCE; k++) f->vertex[k] = any_row();
    c = any_component();
    row = any_row();
    if (!cqi_code_copied(&d, 0, c, 0, values + (size_t)row * channel->components + c)) return;
    PROVE(all_fit());
    REACHED();
}

void claim_near_copy(void) { prove_beside(cqi_code_near_copy); }

/* -- Pairs --------------------------------------------------------------------------------------------------------- */

int stub_pair_of(cqi_vector64 n, int32_t half, cqi_pair_of_normal *pair)
{
    (void)n;
    PROVE(half == (1 << (channel->bits - 1)) - 1);
    pair->x = any_between(-half, half);
    pair->y = any_between(-half, half);
    return any_between(0, 1);
}

int stub_folds_back(cq_decoder *of, int index, int bit)
{
    (void)bit;
    PROVE(of == &d && index == CQI_FOLDS_BACK);
    return any_between(0, 1);
}

uint32_t stub_spread(const cq_value *from, uint32_t stride, const cq_index *around, int n, int32_t half, int fold,
                     cqi_pair_of_normal p)
{
    (void)around, (void)fold;
    PROVE(from == values && stride == channel->components && n >= 0 && half > 0);
    PROVE(within(p.x, 2 << 24) && within(p.y, 2 << 24));
    return nondet_u32();
}

void claim_pair_near(void)
{
    const cqi_vector64 n = { 0, 0, 0 };
    cq_index around[1];
    any_values();
    ASSUME(cqi_may_be_pair(channel));
    around[0] = any_row();
    if (!cqi_code_pair_near(&d, 0, any_row(), n, around, any_between(0, 1), any_between(0, 1), 0)) return;
    PROVE(all_fit());
    REACHED();
}

/* -- Regular levels ------------------------------------------------------------------------------------------------ */

cqi_vector stub_sum_features(cqi_vector from, const cqi_vector *feature, const int8_t *weight, int n)
{
    (void)from, (void)feature;
    PROVE(weight == d.regular.weight[0] && n >= 0 && n <= CQI_MOST);
    return any_vector(30);
}

int32_t stub_code_residual(cq_decoder *of, int kind, int row, int expected, int most, int fraction, int32_t residual)
{
    (void)residual;
    PROVE(of == &d && kind == CQI_PLAIN && row >= 0 && row < CQI_EXPECTED && expected >= 0 && expected <= 39);
    PROVE(fraction == -1);
    return any_residual(most);
}

void claim_other_part(void)
{
    static cqi_vector feature[CQI_MOST];
    static uint8_t mark[1];
    any_values();
    ASSUME(channel->merge == CQ_AVERAGE);
    mark[0] = nondet_u8();
    d.mesh.mark = mark;
    d.regular.size = nondet_u32();
    d.regular.size_of[0] = nondet_u16();
    ASSUME(d.regular.size <= 64 * 15 && d.regular.size_of[0] <= 64 * 64);
    d.regular.part = channel->components > 3 && nondet_int() ? 3 : 0;
    d.regular.fold = cqi_may_be_pair(channel) ? any_between(0, 1) : 0;
    if (!cqi_code_other_part(&d, 0, any_row(), feature, 0)) return;
    PROVE(all_fit());
    PROVE(d.regular.size_of[0] <= 64 * 64);
    REACHED();
}

/* Positions, given sums of weighted features whose bound is argued next to cqi_weigh: below 2^37, in 1/256. */
#define MOST_SUM ((int64_t)1 << 37)
int stub_expected_size(const cq_decoder *of, cq_index v)
{
    PROVE(of == &d && v < ROWS);
    return any_between(0, 60);
}

void stub_find_fine(const cq_decoder *of, cq_index v, cq_index h, cqi_vector *feature, cqi_tilt *t)
{
    (void)h, (void)feature;
    PROVE(of == &d && v < ROWS);
    t->axis[0] = any_between(0, 2);
    t->axis[1] = any_between(0, 2);
    t->axis[2] = any_between(0, 2);
    ASSUME(t->axis[0] != t->axis[1] && t->axis[0] != t->axis[2] && t->axis[1] != t->axis[2]);
    t->slope_x = any_between(-256, 256);
    t->slope_y = any_between(-256, 256);
}

void stub_weigh(const cqi_tilt *t, const cqi_vector *feature, const int8_t *weight, int n, int64_t *sum)
{
    int k;
    (void)t, (void)feature;
    PROVE(weight == d.regular.fine && n == CQI_FINE);
    for (k = 0; k < 3; k++) {
        sum[k] = (int64_t)nondet_u64();
        ASSUME(within(sum[k], MOST_SUM));
    }
}

int32_t stub_new_residual(cq_decoder *of, int kind, int row, int expected, int most, int fraction, int32_t residual)
{
    const int32_t x = nondet_int();
    (void)residual;
    PROVE(of == &d && (kind == CQI_NEW_ALONG || kind == CQI_NEW_ABOVE) && row >= 0 && row < CQI_EXPECTED);
    PROVE(expected >= 0 && expected <= 39 && fraction >= 0 && fraction <= 3 && most == 26);
    ASSUME(x == CQI_WILD || within(x, (1 << 26) - 1));
    return x;
}

void claim_new_position(void)
{
    static uint8_t mark[ROWS];
    any_values();
    d.located = cqi_context_channel(&d.shape);
    ASSUME(d.located == 0);
    d.mesh.mark = mark;
    d.regular.size = nondet_u32();
    ASSUME(d.regular.size <= 64 * 15);
    if (!cqi_code_new_position(&d, any_row(), 0, 0)) return;
    PROVE(all_fit());
    PROVE(d.regular.size <= 64 * 15);
    REACHED();
}
