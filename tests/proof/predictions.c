/* Proofs that predictions do not overflow, for values of up to CQ_MAX_BITS, the most that a header can say: each claim
 * is about one function, for any inputs within bounds that the claims about those before it show. Bounds are numbers
 * of bits beside the sign:
 *
 *     values                 24, not negative; exact ones, without their last 8 bits, 23
 *     offsets of a ring      14
 *     features of regular levels                                         27 or 28
 */
#include "vectors.h"

#ifndef SIZE
#define SIZE 4 /* vertices of a ring or fan */
#endif
#ifndef RING
#define RING 8 /* the largest one where a claim is not about all valences */
#endif

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
    cqi_measure_spokes(&r);
    for (k = 0; k < r.size; k++) {
        PROVE(vector_fits(r.at[k], 14));
    }
    REACHED();
}

/* The product of two vectors of the ring, for what is about sums of it. */
int32_t stub_dot(cqi_vector a, cqi_vector b)
{
    PROVE(vector_fits(a, 14) && vector_fits(b, 14));
    return any_between(a.x == b.x && a.y == b.y && a.z == b.z ? 0 : -(3 << 28), 3 << 28);
}

void claim_dot(void)
{
    const cqi_vector a = any_vector(14);
    const int32_t dot = cqi_dot(a, any_vector(14)), square = cqi_dot(a, a);
    PROVE(dot >= -(3 << 28) && dot <= 3 << 28);
    PROVE(square >= 0 && square <= 3 << 28);
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
    PROVE(vector_fits(n, 21));
    REACHED();
}

/* -- Predictions that compete -------------------------------------------------------------------------------------- */

/* Products of two vectors of 14 bits. */
static int crossed;
cqi_vector stub_cross_14(cqi_vector a, cqi_vector b)
{
    PROVE(vector_fits(a, 14) && vector_fits(b, 14));
    crossed = 1;
    return any_vector(29);
}

void claim_cross_14(void)
{
    PROVE(vector_fits(cqi_cross(any_vector(14), any_vector(14)), 29));
    REACHED();
}

/* A normal that is not steep; and what its shift makes of it: z of up to 15 bits or -2^15, of which x and y have at
 * most CQI_STEEP_BITS more. */
static int normal_holds(cqi_vector n)
{
    return vector_fits(n, 29) && cqi_abs(n.z) > (cqi_abs(n.x) + cqi_abs(n.y)) >> CQI_STEEP_BITS;
}

static int shifted_holds(cqi_vector n)
{
    int bits;
    if (!n.z || !within(n.z, 1 << 15)) return 0;
    bits = cqi_bit_length(cqi_abs(n.z)) + CQI_STEEP_BITS;
    return within(n.x, 1 << bits) && within(n.y, 1 << bits);
}

/* The shift leaves z 15 bits, or as many as it has. */
static int shift_holds(int32_t z, int bits)
{
    const uint32_t left = bits >= 0 && bits < 32 ? cqi_abs(z) >> bits : 0;
    return left && left < 1 << 15 && (!bits || left >= 1 << 14);
}

void claim_shift_normal(void)
{
    const cqi_vector n = any_vector(29);
    const int bits = any_between(0, 31);
    ASSUME(normal_holds(n) && shift_holds(n.z, bits));
    PROVE(shifted_holds(cqi_shift(n, bits)));
    REACHED();
}

/* Edges are shifted before the product of them, the normal after it. */
static cqi_vector shifted;
cqi_vector stub_shift(cqi_vector a, int bits)
{
    if (!crossed) {
        a.x = cqi_floor_shift(a.x, bits);
        a.y = cqi_floor_shift(a.y, bits);
        a.z = cqi_floor_shift(a.z, bits);
        return a;
    }
    PROVE(normal_holds(a) && shift_holds(a.z, bits));
    shifted.x = nondet_int();
    shifted.y = nondet_int();
    shifted.z = nondet_int();
    ASSUME(shifted_holds(shifted));
    return shifted;
}

/* A slope, of a normal whose z has so many bits; and the rise along an axis. In 64 bits the products are below 2^36. */
static int slope_holds(int32_t n, int32_t part, int bits)
{
    return within(n, 1 << (bits + CQI_STEEP_BITS)) && within(part, 1 << (30 - bits));
}

static int rise_holds(int32_t slope, int32_t x) { return within(slope, 1 << 18) && within(x, 5 << CQI_RING_BITS); }

void claim_slope(void)
{
    const int32_t n = nondet_int(), part = nondet_int();
    int32_t slope;
    ASSUME(slope_holds(n, part, any_between(1, 16)));
    slope = cqi_product(n, part, 15);
    PROVE(within(slope, 1 << 18));
    REACHED();
}

void claim_rise(void)
{
    const int32_t slope = nondet_int(), x = nondet_int();
    int32_t rise;
    ASSUME(rise_holds(slope, x));
    rise = cqi_product(slope, x, 14);
    PROVE(within(rise, 5 << 18));
    REACHED();
}

int32_t stub_product(int32_t a, int32_t b, int shift)
{
    if (shift == 15) {
        PROVE(a == shifted.x || a == shifted.y);
        PROVE(slope_holds(a, b, cqi_bit_length(cqi_abs(shifted.z))));
        return any_between(-(1 << 18), 1 << 18);
    }
    PROVE(shift == 14 && rise_holds(a, b));
    return any_between(-(5 << 18), 5 << 18);
}

void stub_add_height(cqi_fan *f, cqi_vector a)
{
    (void)f;
    PROVE(fits(a.x, 22) && a.y == 0 && a.z == 0);
}

static int is_far(cqi_vector a) { return within(a.x, CQI_FAR) && within(a.y, CQI_FAR) && within(a.z, CQI_FAR); }

/* The plane through two vertices of a ring and one of it or beyond it. */
void claim_add_plane(void)
{
    static cqi_fan f;
    cqi_vector place;
    place.x = nondet_int();
    place.y = nondet_int();
    place.z = nondet_int();
    ASSUME(is_far(place));
    cqi_add_plane(&f, place, any_vector(14), any_vector(14), any_vector(15));
    REACHED();
}

/* Rivals, once they are added. */
static int rival_holds(cqi_vector a)
{
    return within(a.x, (1 << CQI_RING_BITS) - 1) && within(a.y, (1 << CQI_RING_BITS) - 1) && fits(a.z, 16);
}

static void any_rivals(cqi_fan *f)
{
    int k;
    f->num_rivals = any_between(0, CQI_RIVALS);
    for (k = 0; k < CQI_RIVALS; k++) {
        f->rival[k].x = nondet_int();
        f->rival[k].y = nondet_int();
        f->rival[k].z = nondet_int();
        ASSUME(rival_holds(f->rival[k]));
    }
}

void claim_add_rival(void)
{
    static cqi_fan f;
    cqi_vector a = any_vector(31);
    int k;
    a.z = any_signed(16);
    any_rivals(&f);
    cqi_add_rival(&f, a);
    PROVE(f.num_rivals >= 0 && f.num_rivals <= CQI_RIVALS);
    for (k = 0; k < CQI_RIVALS; k++) PROVE(rival_holds(f.rival[k]));
    REACHED();
}

/* A fan of any size, with what is beyond its edges; unknown places are any numbers. */
static void any_fan(cqi_fan *f)
{
    int k;
    f->size = any_between(2, CQ_MAX_VALENCE + 1);
    f->boundary = any_between(0, 1);
    f->known = nondet_u32();
    for (k = 0; k <= CQ_MAX_VALENCE; k++) {
        f->at[k] = any_vector(14);
        f->outer[k] = any_vector(31);
        ASSUME(!(f->known >> k & 1) || vector_fits(f->outer[k], 15));
    }
}

void stub_add_rival(cqi_fan *f, cqi_vector a)
{
    (void)f;
    PROVE(vector_fits(a, 16));
}

void claim_list_rivals(void)
{
    static cqi_fan f;
    any_fan(&f);
    cqi_list_rivals(&f);
    REACHED();
}

void stub_add_plane(cqi_fan *f, cqi_vector place, cqi_vector a, cqi_vector b, cqi_vector c)
{
    (void)f;
    PROVE(is_far(place) && vector_fits(a, 14) && vector_fits(b, 14) && vector_fits(c, 15));
}

void claim_list_planes(void)
{
    static cqi_fan f;
    cqi_vector place = any_vector(31);
    ASSUME(is_far(place));
    any_fan(&f);
    cqi_list_planes(&f, place);
    REACHED();
}

/* Votes: of 16 bits each, with a radius that claim_code_hit shows. */
#define MOST_RADIUS (1 << 14)
static int votes_hold(int votes) { return votes >= 0 && votes <= 2 * (CQI_RIVALS - 1); }

void claim_count_votes(void)
{
    static cqi_fan f;
    cqi_votes v;
    int k;
    any_rivals(&f);
    cqi_count_votes(&f, (int16_t)any_between(0, MOST_RADIUS), &v);
    for (k = 0; k < f.num_rivals; k++) PROVE(votes_hold(v.of[k]));
    REACHED();
}

void stub_count_votes(const cqi_fan *f, int16_t radius, cqi_votes *v)
{
    int k;
    PROVE(radius >= 0 && radius <= MOST_RADIUS);
    for (k = 0; k < f->num_rivals; k++) {
        v->of[k] = (int16_t)nondet_u16();
        ASSUME(votes_hold(v->of[k]));
    }
}

/* A mean of as many as a fan may have, each at most so far from 0. */
static int32_t furthest = 1 << 16;
static int sum_holds(cqi_vector sum, int32_t n)
{
    return n >= 1 && n <= CQ_MAX_VALENCE + 1 && near_zero(sum, n * furthest);
}

/* Of what is not negative, none is. */
static int mean_holds(cqi_vector sum, cqi_vector mean)
{
    return near_zero(mean, furthest) && (sum.x < 0 || mean.x >= 0) && (sum.y < 0 || mean.y >= 0) &&
           (sum.z < 0 || mean.z >= 0);
}

void claim_part(void)
{
    const cqi_vector sum = any_vector(31);
    const int32_t n = nondet_int();
    furthest = 1 << any_between(14, 16);
    ASSUME(sum_holds(sum, n));
    PROVE(mean_holds(sum, cqi_part(sum, n)));
    REACHED();
}

cqi_vector stub_part(cqi_vector sum, int32_t n)
{
    const cqi_vector mean = any_vector(31);
    PROVE(sum_holds(sum, n));
    ASSUME(mean_holds(sum, mean));
    return mean;
}

void claim_vote(void)
{
    static cqi_fan f;
    cqi_contest c;
    any_rivals(&f);
    ASSUME(f.num_rivals);
    c.radius = any_between(0, MOST_RADIUS);
    PROVE(votes_hold(cqi_vote(&f, &c)));
    PROVE(near_zero(c.agreed, 1 << 16));
    REACHED();
}

int stub_vote(const cqi_fan *f, cqi_contest *c)
{
    PROVE(f->num_rivals > 0 && c->radius >= 0 && c->radius <= MOST_RADIUS);
    c->agreed = any_near_zero(1 << 16);
    return any_between(0, 2 * (CQI_RIVALS - 1));
}

static int questions_of; /* a table of 8 by 8 */
int stub_code_question(cq_decoder *d, int index, int yes)
{
    (void)d, (void)yes;
    PROVE(index >= questions_of && index < questions_of + 64);
    return any_between(0, 1);
}

void claim_code_hit(void)
{
    static cq_decoder d;
    const int over = any_between(0, 1);
    cqi_contest *const c = over ? &d.now.fan.over : &d.now.fan.along;
    any_rivals(&d.now.fan);
    d.ring.shift = any_between(-10, CQI_FRACTION);
    d.now.fan.extent = any_between(0, 3 << 16);
    c->linear = any_near_zero(over ? 2 * MOST_LINEAR : MOST_LINEAR);
    questions_of = over ? CQI_FLAT : CQI_HIT;
    cqi_code_hit(&d, c, questions_of, over ? CQI_PLANES_APART : CQI_RIVALS_APART, any_near_zero(MOST_PLACE));
    PROVE(c->question == -1 || (c->question >= questions_of && c->question < questions_of + 64));
    REACHED();
}

/* -- The fan ------------------------------------------------------------------------------------------------------- */

/* The component that becomes z, and that the others do not get lost. */
void claim_in_cycle(void)
{
    const int last = any_between(0, 2);
    const cqi_vector a = any_vector(31), b = cqi_in_cycle(a, last), c = cqi_out_of_cycle(b, last);
    PROVE(b.z == (last == 0 ? a.x : last == 1 ? a.y : a.z));
    PROVE(c.x == a.x && c.y == a.y && c.z == a.z);
    REACHED();
}

/* Of a normal: its largest component becomes z. */
cqi_vector stub_in_cycle(cqi_vector a, int last)
{
    const uint32_t x = cqi_abs(a.x), y = cqi_abs(a.y), z = cqi_abs(a.z), most = last == 0 ? x : last == 1 ? y : z;
    cqi_vector n = any_near_zero(1 << 19);
    PROVE(last >= 0 && last <= 2 && most >= x && most >= y && most >= z && most <= 1 << 19);
    ASSUME(cqi_abs(n.x) <= cqi_abs(n.z) && cqi_abs(n.y) <= cqi_abs(n.z));
    return n;
}

/* A sum of as many offsets; the slopes of the plane. */
void claim_find_plane(void)
{
    static cqi_ring r;
    static cqi_fan f;
    const int p = any_between(0, CQ_MAX_VALENCE - 2), q = any_between(1, CQ_MAX_VALENCE - 1);
    cqi_vector sum;
    int k;
    ASSUME(p < q);
    for (k = 0; k < CQ_MAX_VALENCE; k++) r.at[k] = any_vector(14);
    r.boundary = any_between(0, CQ_MAX_VALENCE);
    sum = cqi_find_plane(&r, &f, p, q);
    PROVE(near_zero(sum, (q - p + 1) << 14));
    PROVE(f.above >= 0 && f.above <= 2);
    PROVE(within(f.slope_x, 256) && within(f.slope_y, 256));
    REACHED();
}

/* Of what has 20 bits along the surface. */
void claim_height(void)
{
    static cqi_fan f;
    cqi_vector a = any_vector(20);
    int32_t z;
    f.slope_x = any_between(-256, 256);
    f.slope_y = any_between(-256, 256);
    a.z = 0;
    z = cqi_height(&f, a);
    PROVE(within(z, 2 << 20));
    a.z = any_signed(28);
    PROVE(cqi_height(&f, a) == a.z + z);
    REACHED();
}

/* The scale of a ring, as cqi_locate_ring leaves it. */
static void any_scale(cqi_ring *r)
{
    r->shift = any_between(-10, CQI_FRACTION);
    r->right = r->shift < 0 ? -r->shift : 0;
    r->factor = 1 << (r->shift + r->right);
}

/* A vertex beyond the ring, at any offset: one that is near has 15 bits. */
void claim_locate_beyond(void)
{
    static cqi_ring r;
    cq_value a[3], b[3];
    cqi_vector x;
    int k;
    any_scale(&r);
    for (k = 0; k < 3; k++) {
        a[k] = any_value();
        b[k] = any_value();
    }
    PROVE(!cqi_locate_beyond(&r, a, b, &x) || vector_fits(x, 15));
    REACHED();
}

/* Vertices in front of the ring are any of the mesh, the last one virtual. */
static const cq_value *all_values;
int stub_locate_beyond(const cqi_ring *r, const cq_value *a, const cq_value *b, cqi_vector *x)
{
    (void)r;
    PROVE(a >= all_values && a <= all_values + 3 * (SIZE - 1) && b >= all_values && b <= all_values + 3 * (SIZE - 1));
    *x = any_vector(31);
    if (nondet_int()) return 0;
    ASSUME(vector_fits(*x, 15));
    return 1;
}

static void any_ring(cqi_ring *r)
{
    int k;
    r->size = any_between(2, RING);
    r->boundary = any_between(0, CQ_MAX_VALENCE);
    r->spoke[0] = 0;
    for (k = 0; k < RING; k++) {
        r->at[k] = any_vector(14);
        r->front[k] = any_place();
    }
}

/* What lies beyond a fan: feature 0, and for each edge an offset of 15 bits if it is known. */
void claim_look_beyond(void)
{
    static cq_decoder d;
    static cqi_fan f;
    static cq_value values[3 * SIZE];
    const int p = any_between(0, RING - 2), q = any_between(1, RING - 1);
    cq_index origin[1];
    int k;
    origin[0] = (cq_index)any_between(0, SIZE - 1);
    d.mesh.origin = origin;
    d.mesh.first_virtual = SIZE;
    all_values = values;
    any_ring(&d.ring);
    ASSUME(p < q && q < d.ring.size);
    cqi_size_fan(&d.ring, &f, p, q);
    f.above = any_between(0, 2);
    furthest = 1 << 15;
    cqi_look_beyond(&d, &f, values, any_near_zero(1 << 14), p, q);
    PROVE(near_zero(f.feature[0], (1 << 15) + (1 << 14)));
    for (k = 0; k <= RING; k++) PROVE(!(f.known >> k & 1) || vector_fits(f.outer[k], 15));
    PROVE(f.known >> f.size == 0);
    REACHED();
}

/* The fan along its axes: A, then each vertex of the ring but a virtual one. */
void claim_turn_fan(void)
{
    static cqi_ring r;
    static cqi_fan f;
    cqi_vector at;
    const int p = any_between(0, RING - 2), q = any_between(1, RING - 1);
    int k;
    any_ring(&r);
    ASSUME(p < q && q < r.size);
    cqi_size_fan(&r, &f, p, q);
    f.above = any_between(0, 2);
    f.known = nondet_u32();
    for (k = 0; k <= RING; k++) {
        f.outer[k] = any_vector(31);
        ASSUME(!(f.known >> k & 1) || vector_fits(f.outer[k], 15));
    }
    cqi_turn_fan(&r, &f, p, q);
    for (k = 0; k <= RING; k++) {
        PROVE(k >= f.size || vector_fits(f.at[k], 14));
        PROVE(!(f.known >> k & 1) || vector_fits(f.outer[k], 15));
    }
    k = any_between(0, RING - 1);
    ASSUME(k >= p && k <= q && k != r.boundary);
    at = cqi_in_cycle(r.at[k], f.above);
    k = 1 + k - p - (r.boundary >= p && r.boundary < k);
    PROVE(k < f.size && f.at[k].x == at.x && f.at[k].y == at.y && f.at[k].z == at.z);
    REACHED();
}

/* The mean of a fan and what is derived from it, given the plane and what is beyond. */
cqi_vector stub_find_plane(const cqi_ring *r, cqi_fan *f, int p, int q)
{
    (void)r;
    f->above = any_between(0, 2);
    return any_near_zero((q - p + 1) << 14);
}

void stub_look_beyond(const cq_decoder *d, cqi_fan *f, const cq_value *values, cqi_vector mean, int p, int q)
{
    (void)d, (void)values, (void)p, (void)q;
    PROVE(near_zero(mean, 1 << 14));
    f->feature[0] = any_near_zero(1 << 16);
}

void stub_expect_residuals(const cqi_ring *r, cqi_fan *f, cqi_vector mean, int p, int q)
{
    (void)r, (void)f;
    PROVE(p < q && near_zero(mean, 1 << 14));
}

void claim_find_features(void)
{
    static cq_decoder d;
    static cqi_fan f;
    const int p = any_between(0, CQ_MAX_VALENCE - 2), q = any_between(1, CQ_MAX_VALENCE - 1);
    int k;
    ASSUME(p < q);
    for (k = 0; k < CQ_MAX_VALENCE; k++) d.ring.at[k] = any_vector(14);
    d.ring.boundary = any_between(0, CQ_MAX_VALENCE);
    furthest = 1 << 14;
    cqi_find_features(&d, &f, NULL, p, q);
    PROVE(f.size >= 2 && f.size <= CQ_MAX_VALENCE + 1 && near_zero(f.mean, 1 << 14));
    for (k = 0; k < CQI_FEATURES; k++) PROVE(near_zero(f.feature[k], 1 << 16));
    REACHED();
}

/* How far the vertices of a fan are from their mean. */
void claim_expect_residuals(void)
{
    static cqi_ring r;
    static cqi_fan f;
    const int p = any_between(0, CQ_MAX_VALENCE - 2), q = any_between(1, CQ_MAX_VALENCE - 1);
    int k;
    ASSUME(p < q);
    for (k = 0; k < CQ_MAX_VALENCE; k++) r.at[k] = any_vector(14);
    r.boundary = any_between(0, CQ_MAX_VALENCE);
    r.shift = any_between(-10, CQI_FRACTION);
    f.above = any_between(0, 2);
    furthest = 1 << 15;
    cqi_size_fan(&r, &f, p, q);
    cqi_expect_residuals(&r, &f, any_near_zero(1 << 14), p, q);
    PROVE(f.extent >= 0 && f.extent <= 3 << 15);
    for (k = 0; k < 3; k++) PROVE(f.expected[k] >= -16 && f.expected[k] <= 64);
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
    PROVE(vector_fits(n, 27));
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

/* What is said of values: of any mesh and any channel they lie within 24 bits of the least one. */
static int32_t least;

cqi_vector stub_at(const cq_decoder *d, cq_index v)
{
    cqi_vector x;
    (void)d, (void)v;
    x.x = least + (int32_t)(nondet_u32() & 0xffffff);
    x.y = least + (int32_t)(nondet_u32() & 0xffffff);
    x.z = least + (int32_t)(nondet_u32() & 0xffffff);
    return x;
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
    least = -any_between(0, 1 << 23);
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
