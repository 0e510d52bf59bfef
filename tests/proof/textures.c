/* Proofs about texture coordinates by a similarity, and the plane of the fan that it starts from: nothing overflows or
 * is divided by 0, and what a stream says is in range or refused. Bounds are numbers of bits beside the sign:
 *
 *     offsets of a fan           25
 *     shifted ones               at most 2^12; areas and one axis at most 2^14, the other axis 2^17
 *     places                     at most 2^10
 *     texture coordinates        24; of the fan, minus the first ones and shifted, at most 2^20
 *     the similarity's number    at most 2^38, in 1/256
 */
#include "vectors.h"

#ifndef SIZE
#define SIZE (CQ_MAX_VALENCE + 1) /* vertices of a fan */
#endif

#define MOST_EDGE (1 << 12)
#define MOST_AREA (1 << 14)
#define MOST_AXIS (1 << 17)
#define MOST_FLAT (1 << CQI_FLAT_BITS)
#define MOST_TEXTURE (1 << 20)
#define MOST_NUMBER ((int64_t)1 << 38)

static cq_decoder d;
static cqi_fan fan, *f = &fan;

/* For functions of a decoder. What shares its memory with the fan is the fan from here on: the verifier keeps only what
 * the member in use of a union has. */
static void use_fan_of_decoder(void)
{
    d.now.fan = fan;
    f = &d.now.fan;
}

static uint32_t largest_of(cqi_vector a)
{
    const uint32_t x = cqi_abs(a.x), y = cqi_abs(a.y), z = cqi_abs(a.z);
    return x > y ? x > z ? x : z : y > z ? y : z;
}

static int is_zero(cqi_vector a) { return !(a.x | a.y | a.z); }

/* -- The plane of the fan ------------------------------------------------------------------------------------------ */

void claim_cross_of_edges(void)
{
    PROVE(near_zero(cqi_cross(any_near_zero(MOST_EDGE), any_near_zero(MOST_EDGE)), 1 << 25));
    REACHED();
}

cqi_vector stub_cross_of_edges(cqi_vector a, cqi_vector b)
{
    PROVE(near_zero(a, MOST_EDGE) && near_zero(b, MOST_EDGE));
    return any_near_zero(1 << 25);
}

static int offsets_hold(int shift)
{
    int k, hold = shift >= 0 && shift <= 14;
    for (k = 0; k < f->size && hold; k++) hold &= near_zero(cqi_shift(f->at[k], shift), MOST_EDGE);
    return hold;
}

/* Of offsets that are shifted before. */
void claim_area_of_fan(void)
{
    cqi_vector n;
    int k;
    f->size = any_between(1, SIZE);
    f->faces = nondet_u32();
    for (k = 0; k < SIZE; k++) f->at[k] = any_near_zero(MOST_EDGE);
    n = cqi_area_of_fan(f, 0);
    PROVE(near_zero(n, MOST_AREA) && !is_zero(n));
    REACHED();
}

/* Not longer than n in any direction, and at right angles to it. */
void claim_across(void)
{
    const cqi_vector n = any_near_zero(MOST_AREA);
    cqi_vector a;
    ASSUME(!is_zero(n));
    a = cqi_across(n);
    PROVE(largest_of(a) == largest_of(n));
    PROVE((a.x == 0 && a.y == n.z && a.z == -n.y) || (a.y == 0 && a.z == n.x && a.x == -n.z) ||
          (a.z == 0 && a.x == n.y && a.y == -n.x));
    REACHED();
}

/* The square of a length is that of its largest component, or more. */
void claim_square_of_area(void)
{
    const cqi_vector n = any_near_zero(MOST_AREA);
    const int64_t square = cqi_wide_dot(n, n), largest = largest_of(n);
    PROVE(square >= largest * largest && square <= (int64_t)3 << 28);
    REACHED();
}

/* So its root is no less than that component. */
void claim_length(void)
{
    const uint32_t square = nondet_u32(), largest = nondet_u32();
    uint32_t root;
    ASSUME(largest >= 1 && largest <= MOST_AREA && square >= largest * largest && square <= (uint32_t)3 << 28);
    root = cqi_square_root(square);
    PROVE(root >= largest && root <= 1 << 15);
    REACHED();
}

void claim_place_in_plane(void)
{
    PROVE(within(cqi_wide_dot(any_near_zero(MOST_EDGE), any_near_zero(MOST_AXIS)), 3 << 29));
    REACHED();
}

static int largest_bits; /* of the area and the first axis */

cqi_vector stub_area_of_fan(const cqi_fan *of, int shift)
{
    const cqi_vector n = any_near_zero(MOST_AREA);
    PROVE(of == f && offsets_hold(shift));
    ASSUME(!is_zero(n));
    largest_bits = cqi_bit_length(largest_of(n));
    return n;
}

cqi_vector stub_across(cqi_vector n)
{
    const cqi_vector a = any_near_zero(MOST_AREA);
    PROVE(near_zero(n, MOST_AREA) && !is_zero(n));
    ASSUME(largest_of(a) == largest_of(n));
    return a;
}

/* Of two vectors of so many bits. */
cqi_vector stub_cross_of_axes(cqi_vector a, cqi_vector b)
{
    cqi_vector n = any_vector(31);
    PROVE(largest_of(a) >> largest_bits == 0 && largest_of(b) >> largest_bits == 0);
    ASSUME(largest_of(n) >> (2 * largest_bits) <= 1);
    return n;
}

void claim_cross_of_axes(void)
{
    const int bits = any_between(1, 15);
    const cqi_vector a = any_near_zero(MOST_AREA), b = any_near_zero(MOST_AREA);
    ASSUME(largest_of(a) >> bits == 0 && largest_of(b) >> bits == 0);
    PROVE(largest_of(cqi_cross(a, b)) >> (2 * bits) <= 1);
    REACHED();
}

/* Of the area and itself, then of an edge and an axis. */
static int dots;
int64_t stub_wide_dot(cqi_vector a, cqi_vector b)
{
    const int64_t dot = (int64_t)nondet_u64();
    if (!dots++) {
        PROVE(near_zero(a, MOST_AREA) && !is_zero(a) && a.x == b.x && a.y == b.y && a.z == b.z);
        ASSUME(dot >= 1 && dot <= (int64_t)3 << 28);
        return dot;
    }
    PROVE(near_zero(a, MOST_EDGE) && near_zero(b, MOST_AXIS));
    ASSUME(within(dot, 3 << 29));
    return dot;
}

uint32_t stub_square_root(uint64_t x)
{
    const uint32_t root = (uint32_t)any_between(1, 1 << 15);
    PROVE(x >= 1 && x <= (uint64_t)3 << 28);
    ASSUME(cqi_bit_length(root) >= largest_bits);
    return root;
}

static int place_holds(cqi_vector a) { return within(a.x, MOST_FLAT) && within(a.y, MOST_FLAT); }

void claim_flatten_fan(void)
{
    int k;
    f->size = any_between(1, SIZE);
    for (k = 0; k < SIZE; k++) f->at[k] = any_vector(25);
    cqi_flatten_fan(f);
    for (k = 0; k < f->size; k++) PROVE(place_holds(f->outer[k]) && f->outer[k].z == 0);
    PROVE(place_holds(f->mean));
    REACHED();
}

/* -- The similarity ------------------------------------------------------------------------------------------------ */

/* The first n places and texture coordinates of a fan. */
static void any_places(int n)
{
    int k;
    f->size = n;
    for (k = 0; k < n; k++) {
        f->outer[k].x = any_between(-MOST_FLAT, MOST_FLAT);
        f->outer[k].y = any_between(-MOST_FLAT, MOST_FLAT);
        f->scratch[0][k] = any_between(-MOST_TEXTURE, MOST_TEXTURE);
        f->scratch[1][k] = any_between(-MOST_TEXTURE, MOST_TEXTURE);
    }
}

/* Of x = 0 and y = 0 it is 0; else any that is no longer. */
uint32_t stub_distance(uint64_t x)
{
    const uint32_t root = (uint32_t)any_between(0, 1449);
    PROVE(x <= 2 * MOST_FLAT * MOST_FLAT);
    return root;
}

static int means_hold(const cqi_similarity *s)
{
    return within(s->x, MOST_FLAT) && within(s->y, MOST_FLAT) && within(s->u, MOST_TEXTURE) &&
           within(s->v, MOST_TEXTURE);
}

#ifndef PLACES
#define PLACES 1
#endif

void claim_weigh_places(void)
{
    cqi_similarity s;
    int k;
    any_places(PLACES);
    cqi_weigh_places(f, PLACES, &s);
    for (k = 0; k < PLACES; k++) PROVE(f->outer[k].z >= 2 && f->outer[k].z <= 4096);
    PROVE(means_hold(&s));
    REACHED();
}

void claim_turning(void)
{
    int64_t sum[4];
    int k;
    for (k = 0; k < 4; k++) {
        sum[k] = (int64_t)nondet_u64();
        ASSUME(within(sum[k], (int64_t)25 << 44));
    }
    cqi_turning(sum[0], sum[1], sum[2], sum[3]);
    REACHED();
}

void stub_weigh_places(cqi_fan *of, int n, cqi_similarity *s)
{
    int k;
    PROVE(of == f && n >= 1 && n <= f->size);
    for (k = 0; k < n; k++) f->outer[k].z = any_between(2, 4096);
    s->x = nondet_int();
    s->y = nondet_int();
    s->u = nondet_int();
    s->v = nondet_int();
    ASSUME(means_hold(s));
}

int64_t stub_turning(int64_t xu, int64_t xv, int64_t yu, int64_t yv)
{
    const int64_t limit = (int64_t)PLACES << 44;
    PROVE(within(xu, limit) && within(xv, limit) && within(yu, limit) && within(yv, limit));
    return (int64_t)nondet_u64();
}

static int similarity_holds(const cqi_similarity *s)
{
    return means_hold(s) && within(s->re, MOST_NUMBER) && within(s->im, MOST_NUMBER) &&
           (s->mirror == 1 || s->mirror == -1) && s->most >= 0 && s->most <= 2 * MOST_TEXTURE;
}

void claim_fit_similarity(void)
{
    cqi_similarity s;
    int32_t mirror = nondet_int() ? 1 : -1;
    any_places(PLACES);
    cqi_fit_similarity(f, PLACES, &mirror, &s);
    PROVE(similarity_holds(&s) && s.mirror == mirror);
    REACHED();
}

static void any_similarity(cqi_similarity *s)
{
    s->x = nondet_int();
    s->y = nondet_int();
    s->u = nondet_int();
    s->v = nondet_int();
    s->re = (int64_t)nondet_u64();
    s->im = (int64_t)nondet_u64();
    s->mirror = nondet_int();
    s->most = nondet_int();
    ASSUME(similarity_holds(s));
}

void claim_map_place(void)
{
    cqi_similarity s;
    int32_t to[2];
    const int32_t limit = any_between(0, 1 << 22);
    any_similarity(&s);
    cqi_map_place(&s, any_between(-MOST_FLAT, MOST_FLAT), any_between(-MOST_FLAT, MOST_FLAT), limit, to);
    PROVE(within(to[0], limit) && within(to[1], limit));
    REACHED();
}

void stub_map_place(const cqi_similarity *s, int32_t x, int32_t y, int64_t limit, int32_t *to)
{
    PROVE(similarity_holds(s) && within(x, MOST_FLAT) && within(y, MOST_FLAT) && limit >= 0 && limit <= 1 << 22);
    to[0] = nondet_int();
    to[1] = nondet_int();
    ASSUME(within(to[0], limit) && within(to[1], limit));
}

static int misses_hold(uint32_t misses, int n) { return misses <= (uint32_t)(2 * n) * (6u << 20); }

void claim_misses(void)
{
    cqi_similarity s;
    const int n = any_between(1, SIZE);
    any_similarity(&s);
    any_places(SIZE);
    PROVE(misses_hold(cqi_misses(f, n, &s), n));
    REACHED();
}

/* -- What is coded ------------------------------------------------------------------------------------------------- */

enum { ROWS = 3 };
static cq_value values[2 * ROWS];
static cq_channel *const channel = &d.shape.channel[0];

static void any_channel(void)
{
    channel->kind = CQ_TEXCOORD;
    channel->merge = CQ_AVERAGE;
    channel->components = 2;
    channel->bits = nondet_u8();
    ASSUME(cqi_channel_is_valid(channel) && cqi_fits_value(channel));
    d.shape.num_channels = 1;
    d.channel[0] = values;
}

static cq_value any_fitting(void)
{
    const cq_value x = (cq_value)nondet_u32();
    ASSUME(cqi_value_fits(channel, x));
    return x;
}

static void any_textures(void)
{
    int k;
    any_channel();
    for (k = 0; k < 2 * ROWS; k++) values[k] = any_fitting();
}

static int may_be_unscaled(int32_t x, int shift)
{
    return shift >= -20 && shift <= 4 && cqi_abs(x) >> (20 + shift) == 0;
}

void claim_unscaled(void)
{
    const int32_t x = nondet_int();
    const int shift = any_between(-20, 4);
    ASSUME(may_be_unscaled(x, shift));
    PROVE(within(cqi_unscaled(x, shift), MOST_TEXTURE));
    PROVE(x || !cqi_unscaled(x, shift));
    REACHED();
}

int32_t stub_unscaled(int32_t x, int shift)
{
    PROVE(may_be_unscaled(x, shift));
    return x ? any_between(-MOST_TEXTURE, MOST_TEXTURE) : 0;
}

void claim_compare_textures(void)
{
    const int n = any_between(1, SIZE);
    int32_t first[2];
    int k, up;
    any_textures();
    f->size = SIZE;
    use_fan_of_decoder();
    for (k = 0; k < SIZE; k++) f->vertex[k] = (cq_index)any_between(0, ROWS - 1);
    up = cqi_compare_textures(&d, 0, n, first);
    PROVE(up >= -4 && up <= 20);
    for (k = 0; k < n; k++) PROVE(within(f->scratch[0][k], MOST_TEXTURE) && within(f->scratch[1][k], MOST_TEXTURE));
    for (k = 0; k < 2; k++) {
        PROVE(f->scratch[k][0] == 0);
        PROVE(first[k] == cqi_rough(channel, values[2 * f->vertex[0] + k]));
    }
    REACHED();
}

/* The least and greatest texture coordinates around, minus the first ones, before and after they are shifted. */
static int32_t least[2], greatest[2];

static int rough_fits(int32_t x)
{
    return cqi_is_exact(channel) ? fits(x, 23) : cqi_value_fits(channel, x);
}

int stub_compare_textures(cq_decoder *of, uint32_t k, int n, int32_t *first)
{
    const int up = any_between(-4, 20);
    int c;
    PROVE(of == &d && k == 0 && n >= 1 && n <= f->size);
    for (c = 0; c < 2; c++) {
        first[c] = nondet_int();
        least[c] = any_between(-(1 << 24), 0);
        greatest[c] = any_between(0, 1 << 24);
        ASSUME(rough_fits(first[c]) && rough_fits(first[c] + least[c]) && rough_fits(first[c] + greatest[c]));
        ASSUME(up < 0 || (within(least[c], MOST_TEXTURE >> up) && within(greatest[c], MOST_TEXTURE >> up)));
        least[c] = cqi_unscaled(least[c], -up);
        greatest[c] = cqi_unscaled(greatest[c], -up);
        ASSUME(within(least[c], MOST_TEXTURE) && within(greatest[c], MOST_TEXTURE));
    }
    return up;
}

void stub_fit_similarity(cqi_fan *of, int n, int32_t *mirror, cqi_similarity *s)
{
    PROVE(of == f && n >= 1 && n <= f->size && mirror == &d.model.mirror && (*mirror == 1 || *mirror == -1));
    any_similarity(s);
    ASSUME(s->u >= least[0] && s->u <= greatest[0] && s->v >= least[1] && s->v <= greatest[1]);
    ASSUME(s->most <= greatest[0] - least[0] || s->most <= greatest[1] - least[1]);
}

uint32_t stub_misses(const cqi_fan *of, int n, const cqi_similarity *s)
{
    const uint32_t misses = nondet_u32();
    PROVE(of == f && n >= 1 && n <= f->size && similarity_holds(s));
    ASSUME(misses_hold(misses, n));
    return misses;
}

int32_t stub_plan_value(const cq_decoder *of, uint32_t k, uint32_t c, cq_index input)
{
    (void)input;
    PROVE(of == &d && k == 0 && c < 2);
    return cqi_number(channel, any_fitting());
}

/* An encoder has residuals of the bits of its channel. */
int32_t stub_row_residual(cq_decoder *of, int set, int half_bits, int bits, int32_t residual)
{
    const int32_t x = nondet_int();
    PROVE(of == &d && (set == CQI_ROW_TEXTURE || set == CQI_ROW_TEXTURE_AT_SEAM) && half_bits >= 0 && half_bits <= 78);
    PROVE(bits == (cqi_is_exact(channel) ? 32 : 26));
    PROVE(bits == 32 || within(residual, (1 << 26) - 1));
    ASSUME(bits == 32 || x == CQI_WILD || within(x, (1 << 26) - 1));
    return x;
}

void claim_texture(void)
{
    static cqi_plan plan;
    cq_value to[2];
    any_channel();
    d.plan = nondet_int() ? &plan : NULL;
    d.model.mirror = nondet_int() ? 1 : -1;
    f->size = SIZE;
    use_fan_of_decoder();
    if (!cqi_code_texture(&d, 0, any_between(1, SIZE), nondet_int() ? CQI_ROW_TEXTURE : CQI_ROW_TEXTURE_AT_SEAM, 0, to))
        return;
    PROVE(cqi_value_fits(channel, to[0]) && cqi_value_fits(channel, to[1]));
    REACHED();
}

/* -- At seams ------------------------------------------------------------------------------------------------------ */

void stub_flatten_fan(cqi_fan *of) { PROVE(of == f && f->size >= 1); }

/* Each row that came before is kept once, with its place. */
void claim_keep_known(void)
{
    const cq_index row = any_index();
    int k, j, known, size;
    size = f->size = any_between(1, SIZE);
    for (k = 0; k < SIZE; k++) {
        f->vertex[k] = any_index();
        f->outer[k].x = (int32_t)f->vertex[k];
    }
    known = cqi_keep_known(f, row);
    PROVE(known >= 0 && known <= size);
    for (k = 0; k < known; k++) {
        PROVE(f->vertex[k] < row && f->outer[k].x == (int32_t)f->vertex[k]);
        for (j = 0; j < k; j++) PROVE(f->vertex[j] != f->vertex[k]);
    }
    REACHED();
}
