/* A decoder ends: whatever it reads, every step that goes on takes something from a number that is never negative.
 *
 * The real cqi_step, from any state of one phase that has the invariant below; after the step the phase is the same one
 * or the next. The arrays of the mesh have any contents that are in range, with fans that close within STEPS. What the
 * coder returns is the verifier's choice, so this holds for streams of any length. Splits, first patches, the check of
 * the base and the look ahead are stubs that do what they promise. PHASE, THEN and STEP are the two phases and the
 * function.
 *
 * The look ahead has a claim of its own, whose mesh need only be in range. The verifier has no opinion on what is
 * prefetched, so it is asked as a read. */
void stub_prefetch(const void *address);
#define __builtin_prefetch(address) stub_prefetch(address)
#include "proof.h"

enum {
    VERTICES = REAL_VERTICES + 1, FACES = REAL_FACES + VIRTUAL_FACES, HALFEDGES = 3 * FACES, MOST_VERTICES = 1 << 24
};
#include "tables.h"

static cq_decoder d;
static cq_index origin_of[HALFEDGES], twin_of[HALFEDGES], out_of[VERTICES], valence_of[VERTICES];
static cq_index patch_of[REAL_VERTICES];
static uint8_t mark_of[VERTICES];

void stub_prefetch(const void *address) { PROVE(__CPROVER_r_ok(address, 1)); }

/* -- Stubs --------------------------------------------------------------------------------------------------------- */

int stub_code_bit(cq_decoder *of, int index, int bit)
{
    (void)bit;
    PROVE(of == &d && index >= 0 && index < CQI_MODELS);
    return any_between(0, 1);
}

uint32_t stub_code_raw(cq_decoder *of, uint32_t value, int bits)
{
    value = nondet_u32();
    PROVE(of == &d && bits >= 0 && bits <= 32);
    ASSUME(bits == 32 || value >> bits == 0);
    return value;
}

cq_result stub_mesh_check(const cq_mesh *m, cq_place *place)
{
    PROVE(m == &d.draft && place == NULL);
    return nondet_int() ? CQ_OK : CQ_ERROR_VERTEX;
}

/* A component in which no patch has been found yet. */
cq_index stub_code_first_patch(cq_decoder *of, cq_index seed)
{
    cq_index spoke = any_index();
    PROVE(of == &d && seed < d.base_vertices);
    ASSUME(spoke < HALFEDGES && !cqi_is_conquered(&d.mesh, d.mesh.origin[spoke]));
    return spoke;
}

/* A split adds one vertex, or the stream is at fault. */
cq_result stub_code_split(cq_decoder *of, cq_index centre)
{
    PROVE(of == &d && centre < d.mesh.num_vertices);
    if (d.mesh.num_vertices == d.mesh.first_virtual || nondet_int()) return CQ_ERROR_CORRUPT;
    d.mesh.num_vertices++;
    return CQ_OK;
}

static int ahead_holds(void)
{
    int ok = 1, k;
    for (k = 0; k < CQI_AHEAD; k++) ok &= d.ahead[k] < HALFEDGES;
    return ok;
}

/* Changes nothing else. */
static void any_ahead(void)
{
    int k;
    for (k = 0; k < CQI_AHEAD; k++) d.ahead[k] = any_index();
    ASSUME(ahead_holds());
}

void stub_look_ahead(cq_decoder *of)
{
    PROVE(of == &d && d.walk.tail < REAL_VERTICES && ahead_holds());
    any_ahead();
}

/* The steps of other phases. */
cq_result stub_other_phase(cq_decoder *of)
{
    (void)of;
    PROVE(0);
    return CQ_OK;
}

/* -- What gets less ------------------------------------------------------------------------------------------------ */

static int32_t largest(int32_t a, int32_t b) { return a > b ? a : b; }
static int32_t smallest(int32_t a, int32_t b) { return a < b ? a : b; }

/* Of the arrays, which the drafts and the mesh share: a vertex holds a patch, or is the centre of one. */
static int is_centre(cq_index v) { return (mark_of[v] & CQI_CENTRE) != 0; }
static int number(cq_index v) { return mark_of[v] & CQI_MANY; }

/* Vertices that are not the centre of a patch. */
static int32_t num_left(void)
{
    int32_t n = 0;
    cq_index v;
    for (v = 0; v < REAL_VERTICES; v++) n += v < d.mesh.num_vertices && !is_centre(v);
    return n;
}

/* Patches that wait and are split. */
static int32_t num_waiting(void)
{
    int32_t n = 0;
    cq_index k;
    for (k = 0; k < REAL_VERTICES; k++) n += k < d.walk.tail && number(origin_of[patch_of[k]]) != 0;
    return n;
}

/* Steps that may still come, at most. A level of n vertices costs n + n / 1024 + 4 steps and one for each of at least
 * n / 16 + 1 splits: no more than 20 for each split. The last one may add too little, and end in an error. */
static int32_t steps_left(int phase)
{
    const int32_t all = (int32_t)d.shape.num_vertices, n = d.mesh.num_vertices, least = (n >> 4) + 1;
    const int32_t reserve = 19 * ((all >> 4) + 1), rest = 20 * (all - n);
    const cq_mesh *m = &d.draft;
    switch (phase) {
    case CQI_BASE:
        return (m->first_virtual_face - m->num_faces) + (m->max_virtual_faces - m->num_virtual_faces) + 21 * all + 3 +
               reserve;
    case CQI_BASE_VALUES: return (m->num_vertices - d.value) + 2 + 20 * (all - m->num_vertices) + reserve;
    case CQI_LEVEL: return 1 + rest + reserve;
    case CQI_CLEAR: return ((n - d.walk.seed) >> 10) + 1 + n + 3 + rest - 19 * least + reserve;
    case CQI_WALK: return num_left() + 3 + rest - 19 * largest(least, smallest((int32_t)d.splits, all - n)) + reserve;
    default: return num_waiting() + 2 + 20 * (all - (int32_t)d.level_end) + reserve;
    }
}

/* -- The invariant ------------------------------------------------------------------------------------------------- */

static int in_range(cq_index h) { return h < HALFEDGES; }

/* Patches are of different centres, which have no centre for a neighbour; and while patches are looked for, the
 * neighbours of a centre are taken. */
static int patches_hold(int phase)
{
    cq_index h, k, j;
    int ok = d.walk.tail <= REAL_VERTICES;
    for (h = 0; h < HALFEDGES; h++) {
        cq_index v = origin_of[h], w = origin_of[next_of[h]];
        ok &= !is_centre(v) || (!is_centre(w) && (phase != CQI_WALK || number(w)));
    }
    for (k = 0; k < REAL_VERTICES; k++) {
        cq_index v = origin_of[patch_of[k]];
        ok &= k >= d.walk.tail || (patch_of[k] < HALFEDGES && v < REAL_VERTICES && is_centre(v));
        for (j = 0; j < k; j++) ok &= k >= d.walk.tail || origin_of[patch_of[j]] != v;
    }
    return ok;
}

/* Up to the seed. */
static int marks_are_clear(void)
{
    int ok = 1;
    cq_index v;
    for (v = 0; v < REAL_VERTICES; v++) ok &= v >= d.walk.seed || (mark_of[v] & ~CQI_SEED) == 0;
    return ok;
}

static int walk_holds(void)
{
    return number(REAL_VERTICES) && d.walk.head <= d.walk.tail && patches_hold(CQI_WALK) &&
           num_left() + d.walk.tail == d.mesh.num_vertices && num_waiting() == d.splits &&
           (d.walk.spoke == CQ_NONE || (in_range(d.walk.spoke) && d.walk.head < d.walk.tail &&
                                        origin_of[d.walk.spoke] == origin_of[patch_of[d.walk.head]]));
}

static int splits_hold(void)
{
    return num_waiting() + d.mesh.num_vertices == d.level_end && d.level_end <= d.shape.num_vertices &&
           patches_hold(CQI_SPLITS);
}

static int state_holds(int phase)
{
    const cq_mesh *m = phase <= CQI_BASE_VALUES ? &d.draft : &d.mesh;
    if (!cqi_counts_fit(m) || d.shape.num_vertices > MOST_VERTICES || m->num_vertices > d.shape.num_vertices) return 0;
    if (!ahead_holds()) return 0;
    switch (phase) {
    case CQI_BASE: return d.value == 0 && in_range(d.gate) && in_range(d.before) && in_range(d.before2);
    case CQI_BASE_VALUES: return d.value <= m->num_vertices;
    case CQI_LEVEL: return 1;
    case CQI_CLEAR: return d.walk.seed <= m->num_vertices && d.walk.head == 0 && d.walk.tail == 0 &&
                           d.walk.spoke == CQ_NONE && d.splits == 0 && marks_are_clear();
    case CQI_WALK: return walk_holds();
    case CQI_SPLITS: return splits_hold();
    default: return 0;
    }
}

/* Numbers in range; where patches are walked around, twins in pairs, and the halfedges of a vertex one fan. */
static void any_mesh(cq_mesh *m)
{
    cq_index h, v, s, k;
    int n, all;
    for (h = 0; h < HALFEDGES; h++) {
        origin_of[h] = any_index();
        twin_of[h] = any_index();
        ASSUME(origin_of[h] < VERTICES && twin_of[h] < HALFEDGES);
    }
    for (v = 0; v < VERTICES; v++) {
        out_of[v] = any_index();
        valence_of[v] = any_index();
        mark_of[v] = nondet_u8();
        ASSUME(out_of[v] < HALFEDGES);
    }
    m->origin = origin_of;
    m->twin = twin_of;
    m->out = out_of;
    m->valence = valence_of;
    m->mark = mark_of;
    m->num_vertices = any_index();
    m->num_faces = any_index();
    m->num_virtual_faces = any_index();
    m->first_virtual = REAL_VERTICES;
    m->first_virtual_face = REAL_FACES;
    m->num_virtual = m->max_virtual = 1;
    m->max_virtual_faces = VIRTUAL_FACES;
    m->free_vertex = m->free_face = m->free_virtual_face = CQ_NONE;
    if (PHASE < CQI_CLEAR) return;
    for (h = 0; h < HALFEDGES; h++) {
        ASSUME(twin_of[twin_of[h]] == h && origin_of[next_of[twin_of[h]]] == origin_of[h]);
        for (s = next_of[twin_of[h]], n = 1; s != h && n < STEPS; n++) s = next_of[twin_of[s]];
        for (k = 0, all = 0; k < HALFEDGES; k++) all += origin_of[k] == origin_of[h];
        ASSUME(s == h && n == all && origin_of[h] != origin_of[next_of[h]]);
        ASSUME(origin_of[h] < m->num_vertices || origin_of[h] == REAL_VERTICES);
    }
}

void claim_step(void)
{
    int32_t before;
    cq_result result;
    d.phase = PHASE;
    any_mesh(PHASE <= CQI_BASE_VALUES ? &d.draft : &d.mesh);
    d.shape.num_vertices = nondet_u32();
    d.level = nondet_u32();
    d.num_components = nondet_u32();
    d.payload_left = nondet_size();
    d.range.count = nondet_size();
    d.range.size = nondet_size();
    d.gate = any_index();
    d.before = any_index();
    d.before2 = any_index();
    d.scan = any_index();
    d.virtual_scan = any_index();
    d.value = any_index();
    d.base_vertices = any_index();
    d.splits = any_index();
    d.level_end = nondet_u32();
    d.patch = patch_of;
    d.walk.seed = any_index();
    d.walk.head = any_index();
    d.walk.tail = any_index();
    d.walk.spoke = any_index();
    ASSUME(d.walk.tail <= REAL_VERTICES && d.base_vertices <= d.mesh.num_vertices);
    for (cq_index k = 0; k < REAL_VERTICES; k++) {
        patch_of[k] = any_index();
        ASSUME(patch_of[k] < HALFEDGES);
    }
    any_ahead();
    ASSUME(d.scan <= 3 * d.draft.num_faces);
    ASSUME(d.virtual_scan >= 3 * REAL_FACES && d.virtual_scan <= 3 * (REAL_FACES + d.draft.num_virtual_faces));
    ASSUME(state_holds(PHASE) && (PHASE != CQI_BASE || d.shape.num_vertices >= REAL_VERTICES));
    before = steps_left(PHASE);
    PROVE(before >= 0);
    result = STEP(&d);
    if (result != CQ_OK) return;
    PROVE(d.phase == PHASE || d.phase == THEN);
    if (d.phase == PHASE) {
        PROVE(state_holds(PHASE));
        PROVE(steps_left(PHASE) < before);
    } else {
        PROVE(state_holds(THEN));
        PROVE(steps_left(THEN) < before);
    }
    REACHED();
}

/* -- The look ahead ------------------------------------------------------------------------------------------------ */

/* With a first channel of any form, whose block has exactly its values. The patches that wait begin at halfedges in
 * range. */
void claim_look_ahead_is_safe(void)
{
    enum { WAITING = CQI_AHEAD + 4 };
    static cq_index waiting[WAITING];
    cq_channel *channel = &d.shape.channel[0];
    size_t owners;
    int k;
    any_mesh(&d.mesh);
    any_ahead();
    for (k = 0; k < WAITING; k++) {
        waiting[k] = any_index();
        ASSUME(waiting[k] < HALFEDGES);
    }
    d.shape.num_vertices = nondet_u32();
    d.shape.num_channels = nondet_int() ? 1 : 0;
    channel->merge = (uint8_t)any_between(CQ_MIDPOINT, CQ_PER_FACE);
    channel->components = (uint8_t)any_between(1, CQ_MAX_COMPONENTS);
    owners = channel->merge == CQ_PER_FACE ? REAL_FACES : VERTICES;
    if (d.shape.num_channels) d.channel[0] = (cq_value *)any_bytes(owners * channel->components * sizeof(cq_value));
    d.patch = waiting;
    d.walk.tail = any_index();
    ASSUME(d.walk.tail < WAITING);
    cqi_look_ahead(&d);
    PROVE(ahead_holds());
    REACHED();
}

/* What is asked for with a halfedge of a mesh of any size is one of the mesh, so many away where there are so many. */
void claim_near_halfedges(void)
{
    const uint64_t real = nondet_u32(), all = nondet_u32();
    const cq_index h = any_index(), before = cqi_before(h);
    cq_index behind;
    ASSUME(real <= all && 3 * all <= CQ_NONE && h < 3 * all);
    d.mesh.first_virtual_face = (cq_index)real;
    behind = cqi_behind(&d.mesh, h);
    PROVE(h < CQI_APART ? before == 0 : h - before == CQI_APART);
    PROVE(behind < 3 * all && (behind == h ? (uint64_t)h + CQI_APART >= 3 * real : behind - h == CQI_APART));
    REACHED();
}
