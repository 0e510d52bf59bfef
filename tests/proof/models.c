/* Proofs about what adapts and what waits during a level: whatever a stream says, weights, gains and scores stay in
 * their bounds, and the queue of vertices in its memory. Each claim is about one call from any state with the invariant:
 *
 *     weights                       any 16 bits: they move modulo 2^16
 *     models of questions           1 to 65534, of 65536
 *     queue                         count <= capacity, head < capacity
 */
#include "proof.h"

static int coder_holds(const cq_range_decoder *d) { return d->range >= CQI_MIN_RANGE && d->code < d->range; }

/* A decoder whose range coder is in any state that has the invariant. */
static void any_coder(cq_range_decoder *d)
{
    d->size = nondet_size();
    ASSUME(d->size <= 16);
    d->data = any_bytes(d->size);
    d->count = nondet_size();
    ASSUME(d->count <= SIZE_MAX - 16);
    d->code = nondet_u32();
    d->range = nondet_u32();
    ASSUME(coder_holds(d));
}

void claim_decode_part(void)
{
    cq_range_decoder d;
    uint32_t p = nondet_u32();
    size_t count;
    ASSUME(p >= 1 && p <= 65535);
    any_coder(&d);
    count = d.count;
    cqi_decode_part(&d, p);
    PROVE(coder_holds(&d));
    PROVE(d.count - count <= 2);
    REACHED();
}

/* Of any score a probability that the coder can use; what the weights learn of it is at most 1/128 nat. */
void claim_decision(void)
{
    static cq_decoder d;
    int32_t score = nondet_int(), error;
    any_coder(&d.range);
    ASSUME(score >= CQI_TRIED && score <= -CQI_TRIED);
    d.located = any_between(-1, CQ_MAX_CHANNELS - 1);
    cqi_code_decision(&d, score, 0, &error);
    PROVE(coder_holds(&d.range));
    PROVE(error <= CQI_NAT / 128 && -error <= CQI_NAT / 128);
    REACHED();
}

void claim_nudge(void)
{
    const int16_t before = (int16_t)nondet_int();
    const int32_t by = any_between(-(1 << 16), 1 << 16);
    int16_t weight = before;
    cqi_nudge(&weight, by);
    PROVE((uint16_t)weight == (uint16_t)((uint32_t)before + (uint32_t)by));
    REACHED();
}

/* The running mean of gains moves by a 32nd of what is between any two gains: so its 16 bits do not wrap around. */
void claim_question(void)
{
    static cqi_model m;
    const int k = any_between(0, CQI_QUESTIONS - 1);
    const int16_t before = (int16_t)nondet_int();
    const cq_bit_model model = nondet_u16();
    ASSUME(model >= 1 && model <= 65534 && before <= 16 * 1024);
    m.gain[k] = before;
    m.yes[k] = model;
    cqi_learn_question(&m, k, any_between(0, 1), nondet_int());
    PROVE(m.yes[k] >= 1 && m.yes[k] <= 65534);
    PROVE(m.gain[k] <= 16 * 1024);
    PROVE(m.gain[k] - before <= 1536 && before - m.gain[k] <= 1536);
    REACHED();
}

void claim_follow(void)
{
    const int16_t before = (int16_t)nondet_int();
    const int64_t product = (int64_t)nondet_u64();
    const int32_t step = product > 0 ? CQI_LINEAR_STEP : product < 0 ? -CQI_LINEAR_STEP : 0;
    int16_t weight = before;
    cqi_follow(&weight, product);
    PROVE((uint16_t)weight == (uint16_t)((uint32_t)before + (uint32_t)step));
    REACHED();
}

static cqi_vector any_vector(int32_t most)
{
    cqi_vector v;
    v.x = any_between(-most, most);
    v.y = any_between(-most, most);
    v.z = any_between(-most, most);
    return v;
}

/* Stands for the height of a feature above the plane. */
int32_t stub_height(const cqi_fan *f, cqi_vector v)
{
    (void)f, (void)v;
    return any_between(-(1 << 20), 1 << 20);
}

/* Features of up to 2^20, which is more than five times that of any ring and what is beyond it. */
void claim_linear(void)
{
    static cqi_model m;
    static cqi_fan f;
    int k;
    for (k = 0; k < 2 * CQI_FAN_CLASSES * CQI_FEATURES; k++) m.linear[k] = (int16_t)nondet_int();
    for (k = 0; k < CQI_FEATURES; k++) f.feature[k] = any_vector(1 << 20);
    f.mean = any_vector(1 << 20);
    f.size = any_between(2, CQ_MAX_VALENCE + 1);
    f.boundary = any_between(0, 1);
    cqi_predict_linear(&m, &f);
    PROVE(f.linear.x <= 13 << 20 && -f.linear.x <= 13 << 20);
    PROVE(f.linear.y <= 13 << 20 && -f.linear.y <= 13 << 20);
    PROVE(f.rise <= 12 << 20 && -f.rise <= 12 << 20);
    REACHED();
}

/* -- The queue ----------------------------------------------------------------------------------------------------- */

static int queue_holds(const cqi_walk *w) { return w->count <= w->capacity && w->head < w->capacity; }

static cqi_walk any_walk(void)
{
    cqi_walk w;
    w.capacity = any_index();
    w.head = any_index();
    w.count = any_index();
    w.full = any_between(0, 1);
    ASSUME(w.capacity <= MAX_COUNT && queue_holds(&w));
    w.queue = (cq_index *)malloc(w.capacity * sizeof(cq_index));
    ASSUME(w.queue != NULL);
    return w;
}

/* Marks and first halfedges of up to 4 vertices, of any contents. */
static void any_marks(cq_mesh *m, uint8_t mark[4], cq_index out[4])
{
    int k;
    for (k = 0; k < 4; k++) {
        mark[k] = nondet_u8();
        out[k] = any_index();
    }
    m->mark = mark;
    m->out = out;
}

/* One that waits is not queued again, one that is queued gets the last place; without room the walk says so. */
void claim_enqueue(void)
{
    static cq_mesh m;
    uint8_t mark[4];
    cq_index out[4];
    cqi_walk w = any_walk();
    const cq_index v = (cq_index)any_between(0, 3), before = w.count;
    int waits;
    any_marks(&m, mark, out);
    waits = (mark[v] & (CQI_STATE | CQI_QUEUED)) != 0;
    cqi_enqueue(&m, &w, v, any_index());
    PROVE(queue_holds(&w));
    PROVE(w.count == before + (!waits && before < w.capacity));
    PROVE(waits || before < w.capacity || w.full);
    if (w.count > before) {
        PROVE(mark[v] & CQI_QUEUED);
        PROVE(w.queue[((uint64_t)w.head + before) % w.capacity] == v);
        REACHED();
    }
}

/* What is taken is in the queue and free; every step of the search takes one. */
void claim_dequeue(void)
{
    static cq_mesh m;
    uint8_t mark[4];
    cq_index out[4], v;
    cqi_walk w = any_walk();
    const cq_index before = w.count;
    cq_index k;
    any_marks(&m, mark, out);
    for (k = 0; k < w.capacity; k++) {
        w.queue[k] = any_index();
        ASSUME(w.queue[k] < 4);
    }
    v = cqi_dequeue(&m, &w);
    PROVE(queue_holds(&w) && w.count <= before);
    PROVE(v == CQ_NONE ? w.count == 0 : w.count < before && (mark[v] & CQI_STATE) == CQI_FREE);
    if (v != CQ_NONE) REACHED();
}
