/* Proofs that a decoder ends in the phases of the base and of rows, and in those of regular levels that steps.c leaves
 * out: each step either turns to another phase, or moves on within what its phase has to do. What a step codes is any
 * answer (stubs); and growing the base leaves no array. */
#define CQ_ASSERT(condition) ((void)0)
#include "proof.h"

enum { REAL = 4, LOOPS = 1, FACES = 2, BORDER = 2, CHANNELS = 3, AROUND = 4, MATERIALS = 3 };
enum { VERTICES = REAL + LOOPS, ALL_FACES = FACES + BORDER, HALFEDGES = 3 * ALL_FACES };

static cq_decoder d;
static cqi_seams seams;
static cq_mesh *const draft = &d.base.draft;
static cq_index origin_of[HALFEDGES], twin_of[HALFEDGES], out_of[VERTICES], valence_of[VERTICES];
static uint8_t mark_of[VERTICES];

static cq_result any_result(void) { return nondet_int() ? CQ_OK : CQ_ERROR_CORRUPT; }

/* Bytes may be missing at any time. */
static void any_input(void)
{
    d.input.payload_left = nondet_size();
    d.range.count = nondet_size();
    d.range.size = nondet_size();
}

static void any_channels(void)
{
    uint32_t k;
    d.shape.num_channels = (uint32_t)any_between(0, CHANNELS);
    for (k = 0; k < CHANNELS; k++) {
        d.shape.channel[k].kind = nondet_u8();
        d.shape.channel[k].components = (uint8_t)any_between(1, 2);
        d.shape.channel[k].merge = (uint8_t)any_between(0, CQ_PER_FACE);
    }
    d.shape.num_rows = nondet_u32();
}

/* A mesh and the component that is being read, with any contents of their arrays. */
static void any_draft(void)
{
    int k;
    for (k = 0; k < HALFEDGES; k++) {
        origin_of[k] = any_index();
        twin_of[k] = any_index();
    }
    for (k = 0; k < VERTICES; k++) {
        out_of[k] = any_index();
        valence_of[k] = any_index();
    }
    draft->origin = origin_of;
    draft->twin = twin_of;
    draft->out = out_of;
    draft->valence = valence_of;
    draft->mark = mark_of;
    draft->first_virtual = REAL;
    draft->max_virtual = LOOPS;
    draft->first_virtual_face = FACES;
    draft->max_virtual_faces = BORDER;
    draft->num_vertices = (cq_index)any_between(0, REAL);
    draft->num_virtual = (cq_index)any_between(0, LOOPS);
    draft->num_faces = (cq_index)any_between(0, FACES);
    draft->num_virtual_faces = (cq_index)any_between(0, BORDER);
    draft->free_vertex = draft->free_face = draft->free_virtual_face = CQ_NONE;
    d.located = any_between(-1, 0);
}

int stub_code_bit(cq_decoder *of, int index, int bit)
{
    (void)of, (void)bit;
    PROVE(index >= 0 && index < CQI_MODELS);
    return any_between(0, 1);
}

/* -- Materials ----------------------------------------------------------------------------------------------------- */

/* The ranges of materials follow each other, up to the number of faces. */
void claim_step_materials(void)
{
    static cqi_material material[MATERIALS];
    uint32_t k;
    any_draft();
    any_input();
    d.materials = material;
    d.mesh = *draft;
    d.shape.num_vertices = nondet_u32();
    d.shape.num_faces = (uint32_t)any_between(0, FACES);
    d.shape.num_materials = (uint32_t)any_between(1, MATERIALS);
    d.base.material = k = (uint32_t)any_between(0, MATERIALS - 1);
    ASSUME(k < d.shape.num_materials);
    material[k].first = (cq_index)any_between(0, FACES);
    ASSUME(material[k].first <= d.shape.num_faces);
    d.phase = CQI_MATERIALS;
    if (cqi_step_materials(&d) != CQ_OK) return;
    PROVE(d.phase == CQI_MATERIALS || d.phase == CQI_BASE || d.phase == CQI_BASE_VALUES);
    if (d.phase != CQI_MATERIALS) return;
    PROVE(d.base.material == k + 1 && k + 1 < d.shape.num_materials);
    PROVE(material[k + 1].first >= material[k].first && material[k + 1].first <= d.shape.num_faces);
    REACHED();
}

/* -- Growing the base ---------------------------------------------------------------------------------------------- */

static int is_used_face(cq_index f)
{
    return f < draft->num_faces || (f >= FACES && f < FACES + draft->num_virtual_faces);
}

static int is_used(cq_index h) { return h < HALFEDGES && is_used_face(h / 3); }

static int is_used_vertex(cq_index v)
{
    return v < draft->num_vertices || (v >= REAL && v < REAL + draft->num_virtual);
}

/* Faces in use name vertices and halfedges in use, as does the gate. */
static int draft_holds(void)
{
    cq_index h;
    int holds = is_used(d.base.gate) & is_used(d.base.before) & is_used(d.base.before2);
    for (h = 0; h < HALFEDGES; h++)
        holds &= !is_used(h) | (is_used(twin_of[h]) & is_used_vertex(origin_of[h]));
    return holds;
}

static cq_index used_faces(void) { return (cq_index)(draft->num_faces + draft->num_virtual_faces); }

static void any_component(void)
{
    any_draft();
    any_input();
    d.base.gate = any_index();
    d.base.before = any_index();
    d.base.before2 = any_index();
    d.base.faces = draft->num_faces;
}

/* The first face of a component. */
void claim_base_starts(void)
{
    cq_index before;
    any_component();
    d.base.gate = d.base.before = d.base.before2 = used_faces() ? (draft->num_faces ? 0 : 3 * FACES) : CQ_NONE;
    ASSUME(!used_faces() || draft_holds());
    before = used_faces();
    if (cqi_start_component(&d) != CQ_OK) return;
    PROVE(draft_holds() && used_faces() == before + 1 && d.base.faces == draft->num_faces);
    REACHED();
}

/* Each face behind it, at any gate: one is added of those that there are, or the stream is given up. */
void claim_base_grows(void)
{
    cq_index before;
    any_component();
    ASSUME(draft_holds());
    before = used_faces();
    if (cqi_grow_base(&d) != CQ_OK) return;
    PROVE(draft_holds() && used_faces() == before + 1 && d.base.faces == draft->num_faces);
    REACHED();
}

/* The search for a gate goes through all halfedges once: it never turns back. */
void claim_find_gate(void)
{
    cq_index scan, virtual_scan;
    int found;
    any_component();
    ASSUME(draft_holds());
    d.base.scan = scan = any_index();
    d.base.virtual_scan = virtual_scan = any_index();
    ASSUME(scan <= 3 * draft->num_faces);
    ASSUME(virtual_scan >= 3 * FACES && virtual_scan <= 3 * (FACES + draft->num_virtual_faces));
    found = cqi_find_gate(&d);
    PROVE(d.base.scan >= scan && d.base.scan <= 3 * draft->num_faces);
    PROVE(d.base.virtual_scan >= virtual_scan && d.base.virtual_scan <= 3 * (FACES + draft->num_virtual_faces));
    PROVE(!found || (draft_holds() && cqi_is_open(draft, d.base.before2)));
    PROVE(found || (d.base.scan == 3 * draft->num_faces &&
                    d.base.virtual_scan == 3 * (FACES + draft->num_virtual_faces)));
    if (found) REACHED();
}

static int started, grown, looked, gates;

cq_result stub_start_component(cq_decoder *of)
{
    started = 1;
    of->base.draft.num_vertices = (cq_index)(of->base.draft.num_vertices + 2);
    return any_result();
}

int stub_find_gate(cq_decoder *of)
{
    (void)of;
    looked = 1;
    return gates = any_between(0, 1);
}

cq_result stub_grow_base(cq_decoder *of)
{
    (void)of;
    grown = 1;
    return any_result();
}

cq_result stub_finish_component(const cq_decoder *of)
{
    (void)of;
    return any_result();
}

/* Each step starts a component, or adds a face at a gate, or finds none and turns to the values. */
void claim_step_base(void)
{
    cq_index before;
    int open;
    any_component();
    ASSUME(d.base.gate < HALFEDGES && twin_of[d.base.gate] < HALFEDGES);
    d.mesh.num_vertices = (cq_index)any_between(0, REAL);
    ASSUME(d.mesh.num_vertices <= draft->num_vertices);
    before = (cq_index)(draft->num_vertices - d.mesh.num_vertices);
    open = cqi_is_open(draft, d.base.gate);
    d.base.value = any_index();
    d.phase = CQI_BASE;
    if (cqi_step_base(&d) != CQ_OK) return;
    PROVE(started == !before);
    PROVE(!grown || (before && (open || gates)));
    PROVE(started || grown || (d.phase == CQI_BASE_VALUES && d.base.value == 0));
    PROVE(d.phase == CQI_BASE || (looked && !gates)); /* no gate is left */
    PROVE(started + grown < 2);
    REACHED();
}

/* -- Values of the base -------------------------------------------------------------------------------------------- */

int stub_base_value(cq_decoder *of, uint32_t k, uint32_t c, cq_index v, int32_t *size)
{
    PROVE(k < of->shape.num_channels && c < of->shape.channel[k].components);
    PROVE(v >= of->mesh.num_vertices && v < of->base.draft.num_vertices);
    PROVE(size >= of->now.base.size || size >= of->now.base.first);
    return any_between(0, 1);
}

void stub_base_face(cq_decoder *of, uint32_t k, cq_index f)
{
    PROVE(k < of->shape.num_channels && cqi_class(&of->shape, k) == CQI_OF_FACE);
    PROVE(f >= of->mesh.num_faces && f < of->base.draft.num_faces);
}

/* Each step codes the values of the next vertex or face of the component; or it turns to rows; or the component is
 * shown, and levels follow, or another one. */
void claim_step_base_values(void)
{
    cq_index value, vertices;
    any_draft();
    any_input();
    any_channels();
    d.seams = nondet_int() ? &seams : NULL;
    d.mesh = *draft;
    d.mesh.num_vertices = vertices = (cq_index)any_between(0, REAL);
    d.mesh.num_faces = (cq_index)any_between(0, FACES);
    ASSUME(d.mesh.num_vertices < draft->num_vertices && d.mesh.num_faces <= draft->num_faces);
    d.base.shown = d.mesh.num_faces;
    d.base.faces = draft->num_faces;
    d.base.value = value = any_index();
    d.base.more = any_between(0, 1);
    d.phase = nondet_int() ? CQI_BASE_VALUES : CQI_BASE_ROWS;
    ASSUME(d.phase == CQI_BASE_VALUES || (d.seams && !cqi_has_base_values(&d)));
    if (cqi_has_base_values(&d)) {
        if (cqi_step_base_values(&d) != CQ_OK) return;
        PROVE(d.phase == CQI_BASE_VALUES && d.base.value == value + 1);
    } else {
        const int rows = d.phase == CQI_BASE_VALUES && d.seams;
        PROVE(cqi_step_base_values(&d) == CQ_OK);
        PROVE(d.phase == (rows ? CQI_BASE_ROWS : d.base.more ? CQI_BASE : CQI_LEVEL));
        PROVE(d.phase != CQI_BASE || d.mesh.num_vertices > vertices);
        PROVE(!rows || (seams.vertex == vertices && seams.corner == out_of[vertices]));
    }
    REACHED();
}

/* -- Rows of the base ---------------------------------------------------------------------------------------------- */

static cq_index corner_before;

int stub_base_corner(cq_decoder *of)
{
    PROVE(of->seams->corner == corner_before && of->seams->vertex < of->base.draft.num_vertices);
    of->seams->num_rows = (cq_index)(of->seams->num_rows + (cq_index)any_between(0, 1));
    return any_between(0, 1);
}

int stub_base_row(cq_decoder *of, uint32_t k, cq_index row)
{
    PROVE(k < of->shape.num_channels && cqi_class(&of->shape, k) == CQI_OF_ROW);
    PROVE(row >= of->seams->first && row < of->seams->num_rows);
    return any_between(0, 1);
}

/* How far around the vertex a halfedge is, clockwise from the first; the valence if it is not there. */
static int place(cq_index h)
{
    cq_index s = out_of[seams.vertex];
    int k;
    for (k = 0; k < AROUND && s != h; k++) s = cq_clockwise(draft, s);
    return k;
}

/* Each step gives the next corner around a vertex its row, or codes the next channel of the vertex' next new row, or
 * turns to the next vertex. The halfedges of the vertex are a cycle of at most AROUND, see flip.c and surgery.c. */
void claim_step_base_rows(void)
{
    cq_index vertex, row, valence, next;
    uint32_t channel;
    int fresh, at;
    any_draft();
    any_input();
    any_channels();
    d.seams = &seams;
    d.mesh = *draft;
    for (at = 0; at < HALFEDGES; at++) ASSUME(twin_of[at] < HALFEDGES);
    for (at = 0; at < VERTICES; at++) ASSUME(out_of[at] < HALFEDGES);
    seams.vertex = vertex = any_index();
    seams.corner = corner_before = any_index();
    seams.first = any_index();
    seams.num_rows = any_index();
    seams.row_of_base = row = any_index();
    seams.channel = channel = nondet_u32();
    seams.fresh = fresh = any_between(0, 1);
    ASSUME(vertex < draft->num_vertices && seams.first <= seams.num_rows && seams.num_rows < CQ_NONE);
    ASSUME(row >= seams.first && row <= seams.num_rows && channel <= d.shape.num_channels);
    at = place(corner_before);
    ASSUME(at < AROUND);
    next = out_of[vertex];
    for (valence = 1; valence <= AROUND && (next = cq_clockwise(draft, next)) != out_of[vertex];) valence++;
    ASSUME(valence <= AROUND);
    d.phase = CQI_BASE_ROWS;
    if (cqi_step_base_rows(&d) != CQ_OK) return;
    PROVE(d.phase == CQI_BASE_ROWS && seams.vertex <= draft->num_vertices);
    if (seams.vertex == vertex + 1) {
        PROVE(fresh && row == seams.num_rows && !seams.fresh && seams.first == seams.num_rows);
        PROVE(seams.vertex == draft->num_vertices || seams.corner == out_of[seams.vertex]);
        return;
    }
    PROVE(seams.vertex == vertex && (!fresh || seams.fresh));
    if (!fresh) PROVE(seams.fresh ? (cq_index)at + 1 == valence : place(seams.corner) == at + 1);
    if (!fresh) PROVE(!seams.fresh || seams.row_of_base == seams.first);
    if (fresh) PROVE(seams.row_of_base > row ? !seams.channel && seams.row_of_base == row + 1
                                             : seams.row_of_base == row && seams.channel > channel);
    PROVE(seams.row_of_base <= seams.num_rows && seams.channel <= d.shape.num_channels);
    REACHED();
}

/* -- Rows of a split ----------------------------------------------------------------------------------------------- */

void stub_on_corners(cq_decoder *of)
{
    PROVE(of == &d);
    seams.num_new = any_between(0, CQI_MAX_NEW_ROWS);
    seams.full = any_between(0, 1);
}

/* The corners of a split, which turn to the first channel of its first row. */
void claim_step_corners(void)
{
    any_input();
    d.seams = &seams;
    d.phase = CQI_READ_CORNERS;
    if (cqi_step_corners(&d) != CQ_OK) return;
    PROVE(d.phase == CQI_READ_ROWS && !seams.next && !seams.channel && !seams.full);
    REACHED();
}

static int applied;

cq_result stub_apply_rows(cq_decoder *of)
{
    applied = 1;
    of->phase = CQI_PATCHES;
    return any_result();
}

int stub_new_row(cq_decoder *of, uint32_t k, int nth)
{
    PROVE(k < of->shape.num_channels && cqi_class(&of->shape, k) == CQI_OF_ROW);
    PROVE(nth >= 0 && nth < of->seams->num_new);
    return any_between(0, 1);
}

/* Each step codes the next row's part of a channel, row by row and channel by channel; or it is the split. */
void claim_step_rows(void)
{
    uint32_t channel;
    int next;
    any_input();
    any_channels();
    d.seams = &seams;
    seams.num_new = any_between(0, CQI_MAX_NEW_ROWS);
    seams.next = next = any_between(0, CQI_MAX_NEW_ROWS);
    seams.channel = channel = nondet_u32();
    ASSUME(next <= seams.num_new && channel <= d.shape.num_channels);
    d.phase = CQI_READ_ROWS;
    if (cqi_step_rows(&d) != CQ_OK) return;
    PROVE(applied == (d.phase == CQI_PATCHES));
    if (applied) return;
    PROVE(d.phase == CQI_READ_ROWS && seams.next <= seams.num_new && seams.channel < d.shape.num_channels);
    PROVE(seams.channel > channel || (seams.channel == channel && seams.next == next + 1));
    REACHED();
}

/* -- Regular levels ------------------------------------------------------------------------------------------------ */

static cqi_regular *const r = &d.regular;

static void any_level(void)
{
    any_draft();
    any_input();
    d.mesh = *draft;
    r->vertices = (cq_index)any_between(0, REAL);
    r->faces = (cq_index)any_between(0, FACES);
    r->count = any_index();
    ASSUME(r->count <= REAL - r->vertices);
    r->at = any_index();
}

void stub_code_weights(cq_decoder *of, int8_t *weight, int n, cqi_samples (*fill)(cq_decoder *, int))
{
    (void)fill;
    PROVE(of == &d && weight && (n == CQI_FIXED || n == CQI_FINE));
}

static cq_index expected;

void stub_look_ahead(cq_decoder *of, cq_index h)
{
    PROVE(of == &d && h == out_of[expected]);
}

void stub_expect(cq_decoder *of, cq_index v)
{
    PROVE(of == &d && v == expected && v < r->vertices + r->count);
}

/* Each step expects one vertex of those that there are. */
void claim_step_expect(void)
{
    cq_index at;
    any_level();
    at = r->at;
    ASSUME(at <= r->count);
    expected = (cq_index)(r->vertices + at);
    d.phase = CQI_EXPECT;
    if (cqi_step_expect(&d) != CQ_OK) return;
    PROVE(at < r->count ? d.phase == CQI_EXPECT && r->at == at + 1 : d.phase == CQI_DISSOLVES && r->at == 0);
    REACHED();
}

void stub_code_pattern(cq_decoder *of, cq_index f) { PROVE(of == &d && f < r->faces); }
int stub_marks_of(const cq_decoder *of, cq_index f)
{
    PROVE(of == &d && f < r->faces);
    return any_between(0, 7);
}

void stub_code_dissolve(cq_decoder *of, cq_index h)
{
    PROVE(of == &d && h < 3 * r->faces && twin_of[h] > h); /* of both halfedges one is asked for */
}

/* Each step asks for one face, and each edge is asked for once. */
void claim_step_dissolves(void)
{
    cq_index at;
    any_level();
    at = r->at;
    ASSUME(at <= r->faces);
    d.phase = CQI_DISSOLVES;
    if (cqi_step_dissolves(&d) != CQ_OK) return;
    PROVE(at < r->faces ? d.phase == CQI_DISSOLVES && r->at == at + 1
                        : d.phase == CQI_RECORDS && (r->at == 0 || r->at == r->count));
    REACHED();
}

int stub_write_record(cq_decoder *of, cq_index v)
{
    PROVE(of == &d && v >= r->vertices && v < r->vertices + r->count);
    return any_between(0, 1);
}

/* Each step writes a record, of those vertices that there are. */
void claim_step_records(void)
{
    cq_index at;
    any_level();
    at = r->at;
    ASSUME(at <= r->count);
    d.phase = CQI_RECORDS;
    if (cqi_step_records(&d) != CQ_OK) return;
    PROVE(at < r->count ? d.phase == CQI_RECORDS && r->at == at + 1
                        : d.phase == CQI_SWEEP && r->at == 0 && r->own == r->vertices);
    REACHED();
}
