/* Proofs about residuals and the places that they make, whatever a stream says: what is coded is any answer, from any
 * predictions within the bounds that predictions.c shows. Bounds:
 *
 *     shift of a ring        -10 to 4
 *     what is expected       -16 to 64 half bits; of a residual in the end, 0 to 78
 *     residuals              26 bits, or CQI_WILD; of exact values, any 32
 *     a coordinate           27 bits, and no more than MOST_PLACE in the scale of the ring
 */
#include "vectors.h"

#ifndef SIZE
#define SIZE 5 /* vertices of a fan */
#endif

static cq_decoder d;
static cqi_fan *const f = &d.now.fan;

/* -- Residuals ----------------------------------------------------------------------------------------------------- */

/* In place of cqi_code_bit: any answer, by a model of the residual's kind, or one for signs. */
static int kind_of, models_of;
int stub_code_bit(cq_decoder *of, int index, int bit)
{
    (void)bit;
    PROVE(of == &d && index >= 0 && index < CQI_MODELS);
    PROVE((index >= kind_of && index < kind_of + models_of) ||
          (index >= CQI_SIGN_SMALL && index < CQI_SIGN_SMALL + 3 * 4));
    return any_between(0, 1);
}

/* What a residual may be: the most bits of its channel, or what no encoder writes. */
static int residual_holds(int32_t x, int most)
{
    return most == 32 || x == CQI_WILD || within(x, (1 << 26) - 1);
}

static void any_kind(void)
{
    const int k = any_between(0, 7);
    kind_of = k == 0 ? CQI_OF_BASE : k == 1 ? CQI_FIRST : k == 2 ? CQI_SECOND : k == 3 ? CQI_NORMAL
            : k == 4 ? CQI_AGREED : k == 5 ? CQI_NEW_ALONG : k == 6 ? CQI_NEW_ABOVE : CQI_PLAIN;
    models_of = k ? CQI_RESIDUAL_MODELS : 41;
}

static int any_most(void) { return nondet_int() ? 26 : 32; }

void claim_residual(void)
{
    const int most = any_most(), expected = any_between(0, 39);
    int row = any_between(0, CQI_EXPECTED - 1);
    any_kind();
    if (kind_of == CQI_OF_BASE) row = 0;
    PROVE(residual_holds(cqi_code_residual(&d, kind_of, row, expected, most, any_between(-1, 3), nondet_int()), most));
    REACHED();
}

/* Of what is expected in half bits. */
int32_t stub_code_residual(cq_decoder *of, int kind, int row, int expected, int most, int fraction, int32_t residual)
{
    const int32_t x = nondet_int();
    (void)residual;
    PROVE(of == &d && kind == kind_of && row >= 0 && row < CQI_EXPECTED && expected >= 0 && expected <= 39);
    PROVE((most == 26 || most == 32) && fraction >= -1 && fraction <= 3);
    ASSUME(residual_holds(x, most));
    return x;
}

void claim_expected(void)
{
    const int most = any_most();
    any_kind();
    PROVE(residual_holds(cqi_code_expected(&d, kind_of, any_between(0, 78), most, any_between(-1, 3), nondet_int()),
                         most));
    REACHED();
}

/* What is coded is what was asked for: answers that an encoder gave. A decoder that gets the same answers, and knows no
 * residual, asks the same questions and gets it. */
enum { ANSWERS = 20 };
static int answer[ANSWERS], asked_of[ANSWERS], answers, replayed;

int stub_answer(cq_decoder *of, int index, int bit)
{
    (void)of;
    PROVE(answers < ANSWERS);
    if (replayed) {
        PROVE(index == asked_of[answers]);
        return answer[answers++];
    }
    asked_of[answers] = index;
    return answer[answers++] = bit != 0;
}

uint32_t stub_raw_answer(cq_decoder *of, uint32_t value, int bits)
{
    (void)of;
    PROVE(answers < ANSWERS && bits >= 0 && bits <= 32);
    if (replayed) {
        PROVE(asked_of[answers] == bits);
        return (uint32_t)answer[answers++];
    }
    PROVE(bits == 32 || value >> bits == 0);
    asked_of[answers] = bits;
    answer[answers++] = (int)value;
    return value;
}

void claim_residual_decodes(void)
{
    static cqi_plan plan;
    const int most = any_most(), expected = any_between(0, 39), fraction = any_between(-1, 3);
    const int32_t x = nondet_int();
    const int row = any_between(0, CQI_EXPECTED - 1);
    any_kind();
    ASSUME(most == 32 || within(x, (1 << 26) - 1));
    d.plan = &plan; /* an encoder */
    PROVE(cqi_code_residual(&d, kind_of, row, expected, most, fraction, x) == x);
    d.plan = NULL;
    replayed = 1;
    answers = 0;
    PROVE(cqi_code_residual(&d, kind_of, row, expected, most, fraction, 0) == x);
    REACHED();
}

/* Of rows: with models of their own if there are seams. */
static cqi_seams seams;
int stub_code_quick(cq_decoder *of, cqi_quick_model *model, int bit)
{
    (void)bit;
    PROVE(of == &d && model >= &seams.length[0][0][0] &&
          model < &seams.length[0][0][0] + CQI_ROW_SETS * CQI_ROW_CLASSES * CQI_ROW_LENGTHS);
    return any_between(0, 1);
}

int32_t stub_code_expected(cq_decoder *of, int kind, int half_bits, int most, int fraction, int32_t residual)
{
    const int32_t x = nondet_int();
    (void)residual;
    PROVE(of == &d && (kind == CQI_PLAIN || (kind >= CQI_FIRST && kind <= CQI_AGREED)));
    PROVE((kind - CQI_FIRST) % CQI_RESIDUAL_MODELS == 0 || kind == CQI_PLAIN);
    PROVE(half_bits >= 0 && half_bits <= 78 && (most == 26 || most == 32) && fraction >= -1 && fraction <= 3);
    ASSUME(residual_holds(x, most));
    return x;
}

void claim_row_residual(void)
{
    const int most = any_most();
    d.seams = nondet_int() ? &seams : NULL;
    PROVE(residual_holds(cqi_code_row_residual(&d, any_between(0, CQI_ROW_SETS - 1), any_between(0, 78), most,
                                               nondet_int()), most));
    REACHED();
}

/* Its models learn with a rate of 1 to 5, whatever was coded by them. */
int stub_decode_adaptive(cq_range_decoder *of, cq_bit_model *model, int rate)
{
    PROVE(of == &d.range && model == &seams.length[0][0][0].bit && rate >= 1 && rate <= 5);
    return any_between(0, 1);
}

void claim_quick(void)
{
    cqi_quick_model *const m = &seams.length[0][0][0];
    m->used = (uint8_t)any_between(0, 7);
    cqi_code_quick(&d, m, 0);
    PROVE(m->used <= 7);
    REACHED();
}

/* -- Residuals of the base ----------------------------------------------------------------------------------------- */

int32_t stub_base_residual(cq_decoder *of, int kind, int row, int expected, int most, int fraction, int32_t residual)
{
    kind_of = CQI_OF_BASE;
    PROVE(kind == CQI_OF_BASE && row == 0);
    return stub_code_residual(of, kind, row, expected, most, fraction, residual);
}

static void any_channel(cq_channel *c)
{
    c->kind = nondet_u8();
    c->merge = nondet_u8();
    c->components = nondet_u8();
    c->bits = nondet_u8();
    ASSUME(cqi_channel_is_valid(c) && cqi_fits_value(c));
}

/* The running mean of residuals stays within 2^28. */
void claim_base_residual(void)
{
    int32_t size = any_between(0, 1 << 28);
    any_channel(&d.shape.channel[0]);
    cqi_code_base_residual(&d, &d.shape.channel[0], nondet_int(), &size);
    PROVE(size >= 0 && size <= 1 << 28);
    REACHED();
}

/* -- A coordinate -------------------------------------------------------------------------------------------------- */

/* The ring's scale, as cqi_locate_ring leaves it. What shares its memory with the fan is the fan from here on: the
 * verifier keeps only what the member in use of a union has. */
static void any_scale(void)
{
    static cqi_fan fan;
    cqi_ring *const r = &d.ring;
    d.now.fan = fan;
    r->shift = any_between(-10, CQI_FRACTION);
    r->right = r->shift < 0 ? -r->shift : 0;
    r->factor = 1 << (r->shift + r->right);
}

static int is_expected(int half_bits) { return half_bits >= -40 && half_bits <= 78; }

static int coordinate_holds(int32_t x)
{
    if (!within(x, 1 << 27)) return 0;
    return within((int64_t)x * d.ring.factor, MOST_PLACE);
}

/* As an encoder knows it: 25 bits. A decoder's is 0. */
static int32_t any_known(void) { return any_signed(25); }

/* x or y where predictions agree, or any component. */
static int place_is_known(int c, int agreed) { return c >= 0 && c < (agreed ? 2 : 3) && (agreed == 0 || agreed == 1); }

static int prediction_holds(int32_t x) { return within(x, 2 * MOST_LINEAR); }

int stub_code_same(cq_decoder *of, int c, int32_t predicted, int32_t *value)
{
    PROVE(of == &d && c >= 0 && c < 3 && d.ring.shift >= 0 && prediction_holds(predicted));
    PROVE(f->halves >= 0 && f->halves <= 78);
    f->asked = any_between(0, CQI_SAMES);
    if (nondet_int()) return 0;
    *value = any_signed(14);
    return 1;
}

void stub_learn_same(cq_decoder *of, int32_t predicted, int32_t value)
{
    PROVE(of == &d && f->asked >= 0 && f->asked <= CQI_SAMES && prediction_holds(predicted) && coordinate_holds(value));
}

void claim_coordinate(void)
{
    int32_t value = any_known();
    const int32_t predicted = nondet_int();
    const int half_bits = nondet_int(), c = any_between(0, 2), agreed = any_between(0, 1);
    any_scale();
    ASSUME(prediction_holds(predicted) && is_expected(half_bits) && place_is_known(c, agreed));
    f->same = any_between(0, CQI_SAMES);
    cqi_code_coordinate(&d, c, agreed, half_bits, predicted, &value);
    PROVE(coordinate_holds(value));
    PROVE(f->halves >= 0 && f->halves <= 78);
    REACHED();
}

enum { SAME_QUESTIONS = CQI_FLAT - CQI_SAME };
static int questions_of, most_questions;
int stub_code_question(cq_decoder *of, int index, int yes)
{
    (void)yes;
    PROVE(of == &d && index >= questions_of && index < questions_of + most_questions);
    return any_between(0, 1);
}

/* Of any fan: a coordinate of a vertex that is left, which is taken from those that are left with all that have it. */
void claim_common(void)
{
    static cqi_fan fan;
    uint32_t left = nondet_u32(), before = left;
    const int32_t predicted = nondet_int();
    int32_t common;
    int k, many;
    fan.size = any_between(2, SIZE);
    for (k = 0; k < SIZE; k++) fan.scratch[0][k] = any_signed(14);
    ASSUME(left && left >> fan.size == 0 && prediction_holds(predicted));
    common = cqi_choose_common(&fan, left, any_between(0, 1), predicted);
    many = cqi_take_equal(&fan, common, &left);
    PROVE(fits(common, 14) && many >= 1 && many <= fan.size);
    PROVE((left & ~before) == 0 && left != before);
    REACHED();
}

int32_t stub_choose_common(const cqi_fan *of, uint32_t left, int first, int32_t predicted)
{
    PROVE(of == f && left && left >> f->size == 0 && (first == 0 || first == 1) && prediction_holds(predicted));
    return any_signed(14);
}

int stub_take_equal(const cqi_fan *of, int32_t common, uint32_t *left)
{
    const uint32_t before = *left;
    PROVE(of == f && fits(common, 14) && before && before >> f->size == 0);
    *left = nondet_u32();
    ASSUME((*left & ~before) == 0 && *left != before);
    return any_between(1, CQ_MAX_VALENCE + 1);
}

/* Whether a coordinate is that of a neighbour: up to three questions, each one of their table. */
void claim_same(void)
{
    int32_t value = any_known();
    const int32_t predicted = nondet_int();
    int k, same;
    any_scale();
    ASSUME(d.ring.shift >= 0 && prediction_holds(predicted));
    f->size = any_between(2, CQ_MAX_VALENCE + 1);
    f->same = any_between(0, CQI_SAMES);
    f->halves = any_between(0, 78);
    questions_of = CQI_SAME;
    most_questions = SAME_QUESTIONS;
    f->asked = 0;
    same = cqi_code_same(&d, any_between(0, 2), predicted, &value);
    PROVE(f->asked >= 0 && f->asked <= f->same);
    for (k = 0; k < f->asked; k++) PROVE(fits(f->common[k], 14) && f->question[k] >= questions_of &&
                                         f->question[k] < questions_of + most_questions);
    PROVE(!same || fits(value, 14));
    REACHED();
}

/* What is learnt of questions. A gain is at most 1024, and the cost of a no or yes at most that of a probability of
 * 1 / 65536. */
enum { MOST_GAIN = 1024 + 64 * 17 };
int stub_learn_question(cqi_model *m, int index, int yes, int saved)
{
    (void)yes, (void)saved;
    PROVE(m == &d.model && index >= questions_of && index < questions_of + most_questions);
    return any_between(-MOST_GAIN, MOST_GAIN);
}

void claim_learn_question(void)
{
    static cqi_model m;
    const int k = any_between(0, CQI_QUESTIONS - 1);
    m.gain[k] = (int16_t)any_between(-(16 * MOST_GAIN) - 128, 16 * 1024);
    m.yes[k] = nondet_u16();
    ASSUME(m.yes[k] >= 1 && m.yes[k] <= 65534);
    PROVE(within(cqi_learn_question(&m, k, any_between(0, 1), nondet_int()), MOST_GAIN));
    REACHED();
}

void claim_learn_same(void)
{
    const int32_t predicted = nondet_int(), value = nondet_int();
    const int before = any_between(0, 2) * CQI_SAMES * MOST_GAIN;
    int k;
    any_scale();
    ASSUME(prediction_holds(predicted) && coordinate_holds(value));
    f->asked = d.ring.shift < 0 ? 0 : any_between(0, CQI_SAMES);
    questions_of = CQI_SAME;
    most_questions = SAME_QUESTIONS;
    for (k = 0; k < CQI_SAMES; k++) {
        f->common[k] = any_signed(14);
        f->question[k] = CQI_SAME + any_between(0, most_questions - 1);
    }
    for (k = 0; k < 2; k++) {
        f->gain_same[k] = nondet_int();
        ASSUME(within(f->gain_same[k], before));
    }
    cqi_learn_same(&d, predicted, value);
    for (k = 0; k < 2; k++) PROVE(within(f->gain_same[k], before + CQI_SAMES * MOST_GAIN));
    REACHED();
}

/* -- A place ------------------------------------------------------------------------------------------------------- */

#define MOST_RADIUS (1 << 14)
#define MOST_GAINS (3 * CQI_SAMES * MOST_GAIN)

static cqi_vector any_place(void) { return any_near_zero(MOST_PLACE); }

static int at_of;
void stub_code_coordinate(cq_decoder *of, int c, int agreed, int half_bits, int32_t predicted, int32_t *value)
{
    PROVE(of == &d && place_is_known(c, agreed) && is_expected(half_bits) && prediction_holds(predicted));
    PROVE(fits(*value, 25));
    at_of = c;
    *value = nondet_int();
    ASSUME(coordinate_holds(*value));
    f->halves = any_between(0, 78);
}

/* A fan, as find_features, predict_linear and code_hit leave it. */
static void any_prediction(void)
{
    int k;
    for (k = 0; k < 3; k++) f->expected[k] = any_between(-16, 64);
    f->linear = any_near_zero(MOST_LINEAR);
    f->rise = any_between(-MOST_LINEAR, MOST_LINEAR);
    f->mean = any_near_zero(1 << 14);
    f->along.radius = any_between(0, MOST_RADIUS);
    f->along.agreed = any_near_zero(1 << 16);
}

void claim_along(void)
{
    cqi_vector value = any_vector(25);
    int halves;
    any_scale();
    any_prediction();
    halves = cqi_code_along(&d, any_between(0, 1), &value);
    PROVE(halves >= 0 && halves <= 78);
    PROVE(coordinate_holds(value.x) && coordinate_holds(value.y));
    REACHED();
}

void stub_list_planes(cqi_fan *of, cqi_vector place)
{
    PROVE(of == f && near_zero(place, CQI_FAR));
    f->num_rivals = any_between(0, CQI_RIVALS);
}

int stub_code_hit(cq_decoder *of, cqi_contest *c, int questions, int part, cqi_vector place)
{
    PROVE(of == &d && (c == &f->along || c == &f->over));
    PROVE(questions == (c == &f->over ? CQI_FLAT : CQI_HIT));
    PROVE(part == (c == &f->over ? CQI_PLANES_APART : CQI_RIVALS_APART));
    PROVE(within(place.x, MOST_PLACE) && within(place.y, MOST_PLACE)); /* z is not looked at */
    PROVE(near_zero(c->linear, c == &f->over ? 2 * MOST_LINEAR : MOST_LINEAR));
    c->question = -1;
    if (!f->num_rivals) return 0;
    c->question = questions + any_between(0, 63);
    c->radius = any_between(0, MOST_RADIUS);
    c->agreed = any_near_zero(1 << 16);
    return any_between(0, 1);
}

static int contest_holds(const cqi_contest *c, int questions)
{
    if (c->question < 0) return 1;
    return c->question >= questions && c->question < questions + 64 && c->radius >= 0 && c->radius <= MOST_RADIUS &&
           near_zero(c->agreed, 1 << 16) &&
           near_zero(c->linear, questions == CQI_FLAT ? 2 * MOST_LINEAR : MOST_LINEAR);
}

/* The running mean of what all questions of a vertex gain. */
static int worth_holds(int32_t x) { return within(x, 16 * MOST_GAINS); }

void stub_learn_hit(cq_decoder *of, const cqi_contest *c, cqi_vector place, int count, int32_t *worth)
{
    PROVE(of == &d && contest_holds(c, c == &f->over ? CQI_FLAT : CQI_HIT) && near_zero(place, MOST_PLACE));
    PROVE((count == 1 || count == 2) && worth == (c == &f->over ? &d.model.worth_flat : &d.model.worth_rivals));
    *worth = nondet_int();
    ASSUME(worth_holds(*worth));
}

void claim_above_place(void)
{
    int32_t value = any_known();
    const int half_bits = nondet_int();
    const int32_t predicted = nondet_int();
    cqi_vector place = any_place();
    any_scale();
    any_prediction();
    ASSUME(is_expected(half_bits) && prediction_holds(predicted));
    f->flat_sides = any_between(0, 1);
    cqi_code_above(&d, half_bits, predicted, &place, &value);
    PROVE(coordinate_holds(value) && near_zero(place, MOST_PLACE));
    PROVE(at_of == 2);
    REACHED();
}

/* What is learnt, in 64 bits, and of the questions. */
void stub_follow(int16_t *weight, int64_t product)
{
    (void)product;
    PROVE(weight >= d.model.linear && weight < d.model.linear + 2 * CQI_FAN_CLASSES * CQI_FEATURES);
}

static int rise_holds(int32_t rise) { return within(rise, MOST_PLACE + (1 << 22)); }

void claim_learn_linear(void)
{
    const int32_t rise = nondet_int();
    int k;
    any_prediction();
    ASSUME(rise_holds(rise));
    f->size = any_between(2, CQ_MAX_VALENCE + 1);
    f->boundary = any_between(0, 1);
    for (k = 0; k < CQI_FEATURES; k++) {
        f->feature[k] = any_near_zero(1 << 16);
        f->height[k] = any_between(-(3 << 16), 3 << 16);
    }
    cqi_learn_linear(&d.model, f, any_place(), rise);
    REACHED();
}

void claim_learn_hit(void)
{
    const int over = any_between(0, 1);
    static cqi_contest of;
    cqi_contest *const c = &of;
    int32_t worth = nondet_int();
    any_scale();
    questions_of = over ? CQI_FLAT : CQI_HIT;
    most_questions = 64;
    c->question = any_between(-1, CQI_QUESTIONS - 1);
    c->radius = any_between(0, MOST_RADIUS);
    c->agreed = any_near_zero(1 << 16);
    c->linear = any_near_zero(2 * MOST_LINEAR);
    ASSUME(contest_holds(c, questions_of) && worth_holds(worth));
    cqi_learn_hit(&d, c, any_place(), over ? 1 : 2, &worth);
    PROVE(worth_holds(worth));
    REACHED();
}

void stub_turn_fan(const cqi_ring *r, cqi_fan *of, int p, int q)
{
    PROVE(r == &d.ring && of == f && p < q);
}

void stub_list_rivals(cqi_fan *of)
{
    PROVE(of == f);
    f->num_rivals = any_between(0, CQI_RIVALS);
}

int stub_code_along(cq_decoder *of, int hit, cqi_vector *value)
{
    PROVE(of == &d && contest_holds(&f->along, CQI_HIT) && (!hit || f->along.question >= 0));
    PROVE(vector_fits(*value, 25));
    value->x = nondet_int();
    value->y = nondet_int();
    ASSUME(coordinate_holds(value->x) && coordinate_holds(value->y));
    for (hit = 0; hit < 2; hit++) {
        const int more = any_between(-2 * CQI_SAMES * MOST_GAIN, 2 * CQI_SAMES * MOST_GAIN);
        PROVE(f->gain_same[hit] == 0);
        f->gain_same[hit] = more;
    }
    return any_between(0, 78);
}

/* See claim_height. */
int32_t stub_height(const cqi_fan *of, cqi_vector a)
{
    PROVE(of == f && fits(a.x, 20) && fits(a.y, 20) && fits(a.z, 28));
    return a.z + any_between(-(1 << 21), 1 << 21);
}

void stub_code_above(cq_decoder *of, int half_bits, int32_t predicted, cqi_vector *place, int32_t *value)
{
    int k;
    PROVE(of == &d && is_expected(half_bits) && prediction_holds(predicted));
    PROVE(within(place->x, MOST_PLACE) && within(place->y, MOST_PLACE));
    PROVE(fits(*value, 25));
    *value = nondet_int();
    place->z = nondet_int();
    ASSUME(coordinate_holds(*value) && within(place->z, MOST_PLACE));
    for (k = 0; k < 2; k++) f->gain_same[k] += any_between(-CQI_SAMES * MOST_GAIN, CQI_SAMES * MOST_GAIN);
}

void stub_learn_linear(cqi_model *m, const cqi_fan *of, cqi_vector place, int32_t rise)
{
    PROVE(m == &d.model && of == f && near_zero(place, MOST_PLACE) && rise_holds(rise));
}

static void any_worth(int32_t *worth)
{
    *worth = nondet_int();
    ASSUME(worth_holds(*worth));
}

void claim_place(void)
{
    const int p = any_between(0, CQ_MAX_VALENCE - 2), q = any_between(1, CQ_MAX_VALENCE - 1);
    cqi_vector value = any_vector(25);
    int k;
    ASSUME(p < q);
    any_scale();
    any_prediction();
    for (k = 0; k < CQI_FEATURES; k++) f->height[k] = nondet_int();
    any_worth(&d.model.worth_rivals);
    any_worth(&d.model.worth_flat);
    any_worth(&d.model.worth_same[0]);
    any_worth(&d.model.worth_same[1]);
    d.mesh.num_vertices = any_index();
    cqi_code_place(&d, p, q, &value);
    PROVE(coordinate_holds(value.x) && coordinate_holds(value.y) && coordinate_holds(value.z));
    PROVE(f->same >= 0 && f->same <= CQI_SAMES);
    for (k = 0; k < 2; k++) PROVE(worth_holds(d.model.worth_same[k]));
    REACHED();
}

/* -- A position ---------------------------------------------------------------------------------------------------- */

void stub_find_features(cq_decoder *of, cqi_fan *fan, const cq_value *values, int p, int q)
{
    (void)p, (void)q;
    PROVE(of == &d && fan == f && values == d.channel[0]);
    f->above = any_between(0, 2);
}

void stub_predict_linear(const cqi_model *m, cqi_fan *of) { PROVE(m == &d.model && of == f); }

void stub_code_place(cq_decoder *of, int p, int q, cqi_vector *value)
{
    (void)p, (void)q;
    PROVE(of == &d && vector_fits(*value, 25));
    *value = any_near_zero(1 << 27);
}

/* A position is refused if one of its coordinates is not in range. */
void claim_position(void)
{
    static cq_value values[3 * 2];
    static cq_index origin[1];
    cq_value to[3];
    int k, bits;
    any_channel(&d.shape.channel[0]);
    d.shape.num_channels = 1;
    d.channel[0] = values;
    d.mesh.origin = origin;
    d.located = cqi_context_channel(&d.shape);
    ASSUME(d.located == 0);
    bits = d.shape.channel[0].bits;
    origin[0] = (cq_index)any_between(0, 1);
    for (k = 0; k < 6; k++) {
        values[k] = (cq_value)nondet_u32();
        ASSUME(cqi_value_fits(&d.shape.channel[0], values[k]));
    }
    if (!cqi_code_position(&d, 0, 0, 1, 0, to)) return;
    for (k = 0; k < 3; k++) PROVE(to[k] >= 0 && to[k] < 1 << bits);
    REACHED();
}
