/* Proofs that locked vertices stay: no collapse removes one, and no regular level makes one an odd vertex. Odd vertices
 * are made by waves, of which cqi_refuse takes locked ones back, and by cqi_fill after that. */
#define CQ_ASSERT(condition) ((void)0)
#include "proof.h"

enum { VERTICES = 5, HALFEDGES = 9 };

static cq_mesh m;
static cqi_labels labels;
static cq_index origin_of[HALFEDGES], out_of[VERTICES], valence_of[VERTICES];
static uint8_t locked[VERTICES], label_of[VERTICES];

static void any_arrays(void)
{
    int k;
    for (k = 0; k < HALFEDGES; k++) origin_of[k] = (cq_index)any_between(0, VERTICES - 1);
    for (k = 0; k < VERTICES; k++) {
        out_of[k] = any_index();
        valence_of[k] = any_index();
        locked[k] = nondet_u8();
        label_of[k] = nondet_u8();
    }
    m.origin = origin_of;
    m.out = out_of;
    m.valence = valence_of;
    m.num_vertices = (cq_index)any_between(0, VERTICES);
}

static void any_labels(void)
{
    static cq_index parent_of[2][VERTICES], since_of[VERTICES];
    int k;
    any_arrays();
    for (k = 0; k < VERTICES; k++) {
        parent_of[0][k] = (cq_index)any_between(0, VERTICES - 1);
        parent_of[1][k] = (cq_index)any_between(0, VERTICES - 1);
        since_of[k] = any_index();
    }
    labels.mesh = &m;
    labels.locked = locked;
    labels.label = label_of;
    labels.parent[0] = parent_of[0];
    labels.parent[1] = parent_of[1];
    labels.since = since_of;
    labels.limit = nondet_int();
}

/* The end of a collapse that is removed is none of them. */
void claim_locked_stays(void)
{
    static cqi_plan plan;
    const cq_index h = (cq_index)any_between(0, HALFEDGES - 1);
    any_arrays();
    plan.mesh = m;
    plan.locked = locked;
    if (cqi_may_be_removed(&plan, h)) {
        PROVE(!locked[cq_target(&plan.mesh, h)]);
        REACHED();
    }
}

int stub_are_few_acute(cqi_labels *l)
{
    (void)l;
    return any_between(0, 1);
}

/* Whatever waves have labelled, none of them is odd after it. */
void claim_locked_is_even(void)
{
    const int v = any_between(0, VERTICES - 1);
    any_labels();
    cqi_refuse(&labels);
    PROVE((cq_index)v >= m.num_vertices || !locked[v] || !cqi_is_odd(&labels, (cq_index)v));
    REACHED();
}

int stub_fill(cqi_labels *l, cq_index v)
{
    PROVE(l == &labels && !locked[v]);
    label_of[v] = CQI_ODD;
    REACHED();
    return any_between(0, 1);
}

/* None of them becomes odd when labels are filled up. */
void claim_locked_is_not_filled(void)
{
    any_labels();
    cqi_fill_all(&labels);
}
