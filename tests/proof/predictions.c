/* Proofs that predictions do not overflow, for values of up to CQ_MAX_BITS, the most that a header can say: each claim
 * is about one function, for any inputs within bounds that the claims about those before it show. Bounds are numbers
 * of bits beside the sign:
 *
 *     values                 24, not negative; exact ones, without their last 8 bits, 23
 *     offsets of a ring      14
 *     features of regular levels                                         27 or 28
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
    x = cqi_above(&t, any_vector(28));
    PROVE(fits(x.x, 28) && fits(x.y, 28) && fits(x.z, 30));
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
    for (k = 0; k < CQI_FINE; k++) PROVE(vector_fits(feature[k], 28));
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
