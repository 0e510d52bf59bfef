/* Proofs that predictions do not overflow, for values of up to CQ_MAX_BITS, the most that a header can say: each claim
 * is about one function, for any inputs within bounds that the claims about those before it show. Bounds are numbers
 * of bits beside the sign:
 *
 *     values                 24, not negative; exact ones, without their last 8 bits, 23
 *     offsets of a ring      14
 *     what is beyond it      15
 *     features of the linear prediction, and heights above the plane     20
 *     features of regular levels                                         27
 */
#include "proof.h"

#ifndef SIZE
#define SIZE 4 /* vertices of a ring or fan */
#endif

/* Any number of so many bits and a sign; as the verifier sees best which bits are equal. */
static int32_t any_signed(int bits) { return (int32_t)(nondet_u32() << (31 - bits)) >> (31 - bits); }

static int fits(int64_t x, int bits) { return x >= -((int64_t)1 << bits) && x < (int64_t)1 << bits; }

static cqi_vector any_vector(int bits)
{
    cqi_vector v;
    v.x = any_signed(bits);
    v.y = any_signed(bits);
    v.z = any_signed(bits);
    return v;
}

static int vector_fits(cqi_vector v, int bits) { return fits(v.x, bits) && fits(v.y, bits) && fits(v.z, bits); }

static cq_value any_value(void) { return (cq_value)(nondet_u32() & 0xffffff); }

/* -- Offsets of the ring ------------------------------------------------------------------------------------------- */

static cq_index any_place(void) { return (cq_index)any_between(0, SIZE); }

void claim_locate_ring(void)
{
    static cq_mesh m;
    static cqi_ring r;
    static cq_value values[3 * (SIZE + 1)];
    cq_index origin[1];
    int k;
    origin[0] = any_place();
    m.origin = origin;
    r.spoke[0] = 0;
    r.size = any_between(2, SIZE);
    r.boundary = any_between(0, CQ_MAX_VALENCE);
    for (k = 0; k < SIZE; k++) r.vertex[k] = any_place();
    for (k = 0; k < 3 * (SIZE + 1); k++) values[k] = any_value();
    cqi_locate_ring(&m, values, &r);
    PROVE(r.shift >= -10 && r.shift <= CQI_FRACTION);
    for (k = 0; k < r.size; k++) {
        PROVE(vector_fits(r.at[k], 14));
    }
    REACHED();
}

/* The product of two vectors of the ring, for what is about sums of it. */
int32_t stub_dot(cqi_vector a, cqi_vector b)
{
    PROVE(vector_fits(a, 14) && vector_fits(b, 14));
    return any_between(-(3 << 28), 3 << 28);
}

void claim_dot(void)
{
    const cqi_vector a = any_vector(14);
    const int32_t dot = cqi_dot(a, any_vector(14)), square = cqi_dot(a, a);
    PROVE(dot >= -(3 << 28) && dot <= 3 << 28);
    PROVE(square >= 0 && square <= 3 << 28);
    REACHED();
}

void claim_classify_angles(void)
{
    static cqi_ring r;
    int k;
    r.size = any_between(2, SIZE);
    for (k = 0; k < SIZE; k++) {
        r.at[k] = any_vector(14);
        r.square[k] = any_between(0, 3 << 28);
    }
    cqi_classify_angles(&r);
    for (k = 0; k < r.size; k++) PROVE(r.opposite[k] <= 15);
    REACHED();
}

/* -- The fan of B and its features --------------------------------------------------------------------------------- */

cqi_vector stub_cross(cqi_vector a, cqi_vector b)
{
    PROVE(vector_fits(a, 10) && vector_fits(b, 10));
    return any_vector(21);
}

void claim_cross(void)
{
    const cqi_vector n = cqi_cross(any_vector(10), any_vector(10));
    PROVE(n.x >= -(2 << 20) && n.x <= 2 << 20);
    PROVE(n.y >= -(2 << 20) && n.y <= 2 << 20);
    PROVE(n.z >= -(2 << 20) && n.z <= 2 << 20);
    REACHED();
}

static int axes_hold(const cqi_fan *f)
{
    return f->axis[0] >= 0 && f->axis[1] >= 0 && f->axis[2] >= 0 && f->axis[0] != f->axis[1] &&
           f->axis[0] != f->axis[2] && f->axis[1] != f->axis[2] && f->axis[0] + f->axis[1] + f->axis[2] == 3;
}

static void any_axes(cqi_fan *f)
{
    f->axis[2] = any_between(0, 2);
    f->axis[0] = f->axis[2] < 2 ? f->axis[2] + 1 : 0;
    f->axis[1] = 3 - f->axis[2] - f->axis[0];
}

/* Of any ring; cqi_cross is a stub. */
void claim_find_plane(void)
{
    static cqi_ring r;
    static cqi_fan f;
    int k, p, q;
    r.size = any_between(2, CQ_MAX_VALENCE);
    r.boundary = any_between(0, CQ_MAX_VALENCE);
    for (k = 0; k < CQ_MAX_VALENCE; k++) r.at[k] = any_vector(14);
    p = any_between(0, r.size - 2);
    q = any_between(p + 1, r.size - 1);
    cqi_find_plane(&r, &f, p, q);
    PROVE(axes_hold(&f));
    PROVE(f.slope_x >= -256 && f.slope_x <= 256 && f.slope_y >= -256 && f.slope_y <= 256);
    REACHED();
}

static void any_fan(cqi_fan *f)
{
    int k;
    f->size = any_between(2, CQ_MAX_VALENCE + 1);
    f->boundary = any_between(0, 1);
    f->slope_x = any_between(-256, 256);
    f->slope_y = any_between(-256, 256);
    any_axes(f);
    for (k = 0; k < CQ_MAX_VALENCE + 1; k++) {
        f->at[k] = any_vector(14);
        f->outer[k] = any_vector(15);
    }
    f->at[0].x = f->at[0].y = f->at[0].z = 0;
}

/* Heights of what has up to 27 bits. */
void claim_height(void)
{
    static cqi_fan f;
    const cqi_vector v = any_vector(20);
    int32_t height;
    f.slope_x = any_between(-256, 256);
    f.slope_y = any_between(-256, 256);
    height = cqi_height(&f, v);
    PROVE(height >= -(3 << 20) && height <= 3 << 20);
    REACHED();
}

/* What is beyond the ring is any offset of its bounds, or nothing. */
int stub_locate_beyond(const cqi_fan *f, const cq_value *a, const cq_value *b, int shift, cqi_vector *x)
{
    (void)f, (void)a, (void)b, (void)shift;
    *x = any_vector(15);
    return any_between(0, 1);
}

void claim_locate_beyond(void)
{
    static cqi_fan f;
    cq_value a[3], b[3];
    cqi_vector x;
    int k;
    any_axes(&f);
    for (k = 0; k < 3; k++) {
        a[k] = any_value();
        b[k] = any_value();
    }
    if (!cqi_locate_beyond(&f, a, b, any_between(-10, CQI_FRACTION), &x)) return;
    PROVE(vector_fits(x, 15));
    REACHED();
}

/* The mean of n vertices of the ring; n is what cqi_locate_fan counts. */
static int mean_of;

void claim_mean(void)
{
    const int n = any_between(2, CQ_MAX_VALENCE + 1);
    const int32_t sum = any_signed(19);
    ASSUME(sum >= -(n << 14) && sum <= n << 14);
    PROVE(fits(cqi_product(sum, cqi_reciprocal[n], 16), 15)); /* some reciprocals are rounded up */
    PROVE(fits(cqi_product(any_signed(21), any_between(0, 65535), 17), 20));
    REACHED();
}

static int sum_fits(int32_t x) { return x >= -(mean_of << 14) && x <= mean_of << 14; }

cqi_vector stub_product_of(cqi_vector a, int32_t b, int shift)
{
    if (shift == 17) {
        PROVE(vector_fits(a, 21) && b >= 0 && b <= 65535);
        return any_vector(20);
    }
    PROVE(shift == 16 && b == cqi_reciprocal[mean_of] && sum_fits(a.x) && sum_fits(a.y) && sum_fits(a.z));
    return any_vector(15);
}

void claim_locate_fan(void)
{
    static cqi_ring r;
    static cqi_fan f;
    static cq_value values[3 * 26];
    int k, p, q, n;
    r.size = any_between(2, SIZE);
    r.boundary = any_between(0, CQ_MAX_VALENCE);
    r.shift = any_between(-10, CQI_FRACTION);
    p = any_between(0, r.size - 2);
    q = any_between(p + 1, r.size - 1);
    for (k = 0; k < CQ_MAX_VALENCE; k++) r.at[k] = any_vector(14);
    for (k = 0; k < CQ_MAX_VALENCE + 1; k++) {
        f.vertex[k] = (cq_index)any_between(0, 25);
        f.beyond[k] = any_between(0, 1) ? CQ_NONE : (cq_index)any_between(0, 25);
    }
    any_axes(&f);
    mean_of = n = q - p + 2 - (r.boundary >= p && r.boundary <= q);
    cqi_locate_fan(&f, &r, values, p, q);
    for (k = 0; k < n; k++) PROVE(vector_fits(f.at[k], 14) && (f.beyond[k] == CQ_NONE || vector_fits(f.outer[k], 15)));
    PROVE(vector_fits(f.mean, 15));
    PROVE(vector_fits(f.feature[0], 20));
    REACHED();
}

/* -- Predictions that compete -------------------------------------------------------------------------------------- */

/* Votes of any predictions that cqi_add_rival lets in: differences fit 16 bits, as do the votes. */
void claim_vote(void)
{
    static cqi_fan f;
    int k;
    f.num_rivals = any_between(1, CQI_RIVALS);
    f.extent = any_between(0, 1 << 18);
    for (k = 0; k < CQI_RIVALS; k++) {
        f.rival[k] = any_vector(14);
        ASSUME(f.rival[k].x != -(1 << 14) && f.rival[k].y != -(1 << 14));
        f.rival[k].z = any_signed(17);
        f.rival_x[k] = (int16_t)f.rival[k].x;
        f.rival_y[k] = (int16_t)f.rival[k].y;
    }
    cqi_vote(&f, any_between(-10, CQI_FRACTION));
    PROVE(f.votes >= 0 && f.votes <= 2 * (CQI_RIVALS - 1));
    PROVE(f.radius >= 0 && f.radius == (int16_t)f.radius);
    PROVE(vector_fits(f.agreed, 18));
    REACHED();
}

/* Are there no more than have room, each within 14 bits along the surface? */
void claim_add_rival(void)
{
    static cqi_fan f;
    const int before = f.num_rivals = any_between(0, CQI_RIVALS);
    cqi_add_rival(&f, any_vector(29));
    PROVE(f.num_rivals <= CQI_RIVALS);
    if (f.num_rivals == before) return;
    PROVE(f.rival_x[before] == f.rival[before].x && f.rival_y[before] == f.rival[before].y);
    PROVE(f.rival_x[before] > -(1 << 14) && f.rival_x[before] < 1 << 14);
    PROVE(f.rival_y[before] > -(1 << 14) && f.rival_y[before] < 1 << 14);
    REACHED();
}

/* All rivals of any fan of SIZE vertices are sums that fit. */
void claim_list_rivals(void)
{
    static cqi_fan f;
    any_fan(&f);
    ASSUME(f.size <= SIZE);
    cqi_list_rivals(&f);
    PROVE(f.num_rivals >= 0 && f.num_rivals <= CQI_RIVALS);
    REACHED();
}

/* -- The place of B ------------------------------------------------------------------------------------------------ */

/* Any residual that a stream can say: up to 26 bits, or a wild one. */
int32_t stub_code_expected(cq_decoder *d, int kind, int half_bits, int most, int fraction, int32_t residual)
{
    (void)d, (void)residual;
    PROVE(kind >= 0 && half_bits >= 0 && most == 26 && fraction >= -1 && fraction <= 3);
    return any_between(0, 1) ? CQI_WILD : any_between(1 - (1 << 26), (1 << 26) - 1);
}

int stub_code_question(cq_decoder *d, int index, int yes)
{
    (void)d, (void)yes;
    PROVE(index >= 0 && index < CQI_QUESTIONS);
    return any_between(0, 1);
}

int stub_learn_question(cqi_model *m, int index, int yes, int saved)
{
    (void)m, (void)yes, (void)saved;
    PROVE(index >= 0 && index < CQI_QUESTIONS);
    return any_between(-2048, 2048);
}

void stub_list_rivals(cqi_fan *f) { f->num_rivals = any_between(0, CQI_RIVALS); }

void stub_vote(cqi_fan *f, int shift)
{
    (void)shift;
    f->votes = any_between(0, 2 * (CQI_RIVALS - 1));
    f->radius = any_between(0, 0x7fff);
    f->agreed = any_vector(18);
}

int32_t stub_height(const cqi_fan *f, cqi_vector v)
{
    (void)f;
    PROVE(vector_fits(v, 20));
    return any_between(-(3 << 20), 3 << 20);
}

void stub_learn_linear(cqi_model *m, const cqi_fan *f, cqi_vector place, int32_t rise)
{
    (void)m, (void)f;
    PROVE(vector_fits(place, 29) && fits(rise, 30));
}

/* Whatever a stream says of a place: no sum overflows, and what is accepted has 25 bits. */
void claim_code_place(void)
{
    static cq_decoder d;
    cqi_vector value = { 0, 0, 0 };
    cqi_fan *const f = &d.now.fan;
    int k;
    any_fan(f);
    ASSUME(f->size <= SIZE);
    d.ring.shift = any_between(-10, CQI_FRACTION);
    d.mesh.num_vertices = any_index();
    d.model.worth_same = any_between(-(1 << 20), 1 << 20);
    d.model.worth_rivals = any_between(-(1 << 20), 1 << 20);
    f->mean = any_vector(15);
    f->linear = any_vector(25);
    f->rise = any_signed(25);
    for (k = 0; k < 3; k++) f->expected[k] = any_between(-64, 64);
    if (!cqi_code_place(&d, &value)) return;
    PROVE(vector_fits(value, 25));
    REACHED();
}

/* What a place teaches. */
void claim_learn_linear(void)
{
    static cqi_model m;
    static cqi_fan f;
    int k;
    f.size = any_between(2, CQ_MAX_VALENCE + 1);
    f.boundary = any_between(0, 1);
    for (k = 0; k < 2 * CQI_FAN_CLASSES * CQI_FEATURES; k++) m.linear[k] = any_between(-0x40000, 0x40000);
    for (k = 0; k < CQI_FEATURES; k++) {
        f.feature[k] = any_vector(20);
        f.height[k] = any_between(-(3 << 20), 3 << 20);
    }
    f.linear = any_vector(25);
    f.rise = any_signed(25);
    cqi_learn_linear(&m, &f, any_vector(29), any_signed(30));
    k = any_between(0, 2 * CQI_FAN_CLASSES * CQI_FEATURES - 1);
    PROVE(m.linear[k] >= -0x40000 && m.linear[k] <= 0x40000);
    REACHED();
}

/* -- Regular levels ------------------------------------------------------------------------------------------------ */

/* Products of two vectors of 13 bits, for what is about their sums. */
cqi_vector stub_cross_13(cqi_vector a, cqi_vector b)
{
    PROVE(vector_fits(a, 13) && vector_fits(b, 13));
    return any_vector(27);
}

void claim_cross_13(void)
{
    const cqi_vector n = cqi_cross(any_vector(13), any_vector(13));
    PROVE(n.x >= -(2 << 26) && n.x <= 2 << 26);
    PROVE(n.y >= -(2 << 26) && n.y <= 2 << 26);
    PROVE(n.z >= -(2 << 26) && n.z <= 2 << 26);
    REACHED();
}

/* Of any offsets of two values: below 2^30, as cqi_set_tilt wants. */
void claim_normal_of(void)
{
    const cqi_vector b = any_vector(25), c = any_vector(25), e = any_vector(25);
    const cqi_vector n = cqi_normal_of(b, nondet_int() ? &c : NULL, nondet_int() ? &e : NULL);
    PROVE(vector_fits(n, 29));
    REACHED();
}

/* Bounds of a tilt that claim_weigh relies on. */
static int tilt_holds(const cqi_tilt *t)
{
    return t->slope_x >= -256 && t->slope_x <= 256 && t->slope_y >= -256 && t->slope_y <= 256 && fits(t->edge_x, 12) &&
           fits(t->edge_y, 12) && t->inverse >= 0 && t->inverse <= 1 << 17;
}

void stub_set_edge(cqi_tilt *t, cqi_vector edge)
{
    PROVE(vector_fits(edge, 25));
    t->edge_x = any_signed(12);
    t->edge_y = any_signed(12);
    t->inverse = any_between(0, 1 << 17);
}

void claim_set_edge(void)
{
    cqi_tilt t;
    cqi_vector edge = any_vector(25);
    cqi_set_edge(&t, edge);
    PROVE(fits(t.edge_x, 12) && fits(t.edge_y, 12) && t.inverse >= 0 && t.inverse <= 1 << 17);
    REACHED();
}

void claim_set_tilt(void)
{
    cqi_tilt t;
    const int axes = any_between(0, 3);
    cqi_set_tilt(&t, any_vector(25), any_vector(29), axes);
    PROVE(tilt_holds(&t) && t.axis[0] >= 0 && t.axis[0] < 3 && t.axis[1] >= 0 && t.axis[1] < 3 && t.axis[2] >= 0 &&
          t.axis[2] < 3 && t.axis[0] != t.axis[1] && t.axis[0] != t.axis[2] && t.axis[1] != t.axis[2]);
    REACHED();
}

/* The height above the plane of a feature. */
void claim_above(void)
{
    cqi_tilt t;
    cqi_vector x;
    t.axis[2] = any_between(0, 2);
    t.slope_x = any_between(-256, 256);
    t.slope_y = any_between(-256, 256);
    x = cqi_above(&t, any_vector(27));
    PROVE(fits(x.x, 27) && fits(x.y, 27) && fits(x.z, 29));
    REACHED();
}

cqi_vector stub_above(const cqi_tilt *t, cqi_vector a)
{
    cqi_vector x = any_vector(27);
    (void)t;
    PROVE(vector_fits(a, 27));
    x.z = any_signed(29);
    return x;
}

static void any_weights(int8_t *weight, int n)
{
    for (; n--; weight++) *weight = (int8_t)nondet_u8();
}

/* The weighted sums of FEATURES features, of any weights, fit 64 bits, as does what is added along the edge. */
#ifndef FEATURES
#define FEATURES CQI_FIXED
#endif
void claim_weigh(void)
{
    cqi_vector feature[FEATURES];
    int8_t weight[3 * FEATURES];
    int64_t sum[3];
    cqi_tilt t;
    int k;
    for (k = 0; k < FEATURES; k++) feature[k] = any_vector(27);
    any_weights(weight, 3 * FEATURES);
    t.edge_x = any_signed(12);
    t.edge_y = any_signed(12);
    t.inverse = any_between(0, 1 << 17);
    cqi_weigh(&t, feature, weight, FEATURES, sum);
    PROVE(fits(sum[2], 39));
    REACHED();
}

/* Of other channels: of CQI_MOST features, and the middle that they are added to. */
void claim_sum_features(void)
{
    cqi_vector feature[CQI_MOST], sum;
    int8_t weight[CQI_MOST];
    int k;
    for (k = 0; k < CQI_MOST; k++) feature[k] = any_vector(27);
    any_weights(weight, CQI_MOST);
    sum = cqi_sum_features(any_vector(25), feature, weight, CQI_MOST);
    PROVE(vector_fits(sum, 30));
    REACHED();
}

/* What is said of values, offsets of them: of any mesh and any channel. */
cqi_vector stub_from(const cq_decoder *d, cq_index a, cq_index b)
{
    (void)d, (void)a, (void)b;
    return any_vector(24);
}

enum { HALFEDGES = 24 };
static cq_index origin_of[HALFEDGES], twin_of[HALFEDGES];

static void any_edge(cq_decoder *d)
{
    int k;
    for (k = 0; k < HALFEDGES; k++) {
        origin_of[k] = any_index();
        twin_of[k] = (cq_index)any_between(0, HALFEDGES - 1);
    }
    d->mesh.origin = origin_of;
    d->mesh.twin = twin_of;
    d->mesh.first_virtual_face = (cq_index)any_between(0, HALFEDGES / 3);
    for (k = 0; k < 2; k++) {
        d->regular.ahead[k] = nondet_int() ? CQ_NONE : (cq_index)any_between(0, HALFEDGES - 1);
        d->regular.two_ahead[k] = any_between(0, 1);
        d->regular.slot[k] = k && nondet_int() ? CQ_NONE : (cq_index)any_between(0, HALFEDGES / 3 - 1);
    }
    d->regular.axes = any_between(0, 3);
}

void stub_set_tilt(cqi_tilt *t, cqi_vector edge, cqi_vector normal, int axes)
{
    (void)t;
    PROVE(vector_fits(edge, 25) && vector_fits(normal, 29) && axes >= 0 && axes <= 3);
}

cqi_vector stub_normal_of(cqi_vector b, const cqi_vector *c, const cqi_vector *e)
{
    PROVE(vector_fits(b, 25) && (!c || vector_fits(*c, 25)) && (!e || vector_fits(*e, 25)));
    return any_vector(29);
}

/* The features of the coarse mesh, of any edge. */
void claim_find_fixed(void)
{
    static cq_decoder d;
    cqi_vector feature[CQI_FIXED];
    cqi_tilt t;
    int k;
    any_edge(&d);
    cqi_find_fixed(&d, (cq_index)any_between(0, HALFEDGES - 1), feature, nondet_int() ? &t : NULL);
    for (k = 0; k < CQI_FIXED; k++) PROVE(vector_fits(feature[k], 27));
    REACHED();
}

/* Those of any record. */
void claim_find_fine(void)
{
    static cq_decoder d;
    cqi_vector feature[CQI_FINE];
    cqi_tilt t;
    int k;
    any_edge(&d);
    cqi_find_fine(&d, any_index(), (cq_index)any_between(0, HALFEDGES - 1), feature, nondet_int() ? &t : NULL);
    for (k = 0; k < CQI_FINE; k++) PROVE(vector_fits(feature[k], 27));
    REACHED();
}

/* Values as they are looked at, out of the fold or in it, and of any channel; two of them differ by 24 bits at most. */
void claim_seen(void)
{
    static cq_decoder d;
    cq_value value[CQ_MAX_COMPONENTS];
    cq_channel *const c = &d.shape.channel[0];
    cqi_vector x;
    int k;
    c->components = (uint8_t)any_between(1, 4);
    c->bits = nondet_u8();
    c->kind = nondet_u8();
    c->merge = nondet_u8();
    ASSUME(cqi_channel_is_valid(c) && cqi_fits_value(c));
    for (k = 0; k < CQ_MAX_COMPONENTS; k++) {
        value[k] = (cq_value)nondet_u32();
        ASSUME(cqi_value_fits(c, value[k]));
    }
    d.regular.part = c->components > 3 && nondet_int() ? 3 : 0;
    d.regular.fold = cqi_may_be_pair(c) ? any_between(0, 1) : 0;
    x = cqi_seen(&d, value);
    PROVE(vector_fits(x, 24) && (!cqi_is_exact(c) || vector_fits(x, 23)));
    PROVE(d.regular.fold || cqi_is_exact(c) || (x.x >= 0 && x.y >= 0 && x.z >= 0));
    x = cqi_unseen(&d, any_vector(30));
    PROVE(vector_fits(x, 24));
    REACHED();
}
