/* Proofs that a decoder ends: each kind of step either turns to another phase, or moves on within what its phase has to
 * do; and that regular levels keep within their notes. What a step codes is any answer (stubs). */
#define CQ_ASSERT(condition) ((void)0)
#include "proof.h"

#ifndef MAX_NEW
#define MAX_NEW 6
#endif
enum { NEW = MAX_NEW, FACES = 8, OLD = 5 }; /* new vertices, coarse faces and old vertices of a regular level, at most */

static cq_decoder d;
static cqi_regular *const r = &d.regular;
static cq_index out_of[OLD + NEW], valence_of[OLD + NEW], twin_of[3 * FACES];
static uint8_t mark_of[OLD + NEW];

static void any_level(void)
{
    int k;
    for (k = 0; k < 3 * FACES; k++) twin_of[k] = any_index();
    for (k = 0; k < OLD + NEW; k++) {
        out_of[k] = any_index();
        valence_of[k] = any_index();
        mark_of[k] = nondet_u8();
    }
    r->vertices = OLD;
    r->faces = (cq_index)any_between(1, FACES);
    r->count = (cq_index)any_between(0, NEW);
    d.mesh.out = out_of;
    d.mesh.valence = valence_of;
    d.mesh.twin = twin_of;
    d.mesh.mark = mark_of;
    d.mesh.first_virtual = OLD + NEW;
    d.mesh.first_virtual_face = (cq_index)any_between(0, 3 * FACES);
    d.located = any_between(-1, 0);
    d.walk.capacity = (cq_index)(r->faces / 3 + 1);
    d.walk.queue = (cq_index *)malloc(d.walk.capacity * sizeof(cq_index));
    ASSUME(d.walk.queue != NULL);
}

cq_index stub_next_coarse(const cq_decoder *of, cq_index f)
{
    cq_index next = any_index();
    (void)of;
    PROVE(f <= r->faces);
    ASSUME(next >= f && next <= r->faces);
    ASSUME(next == f || r->own == d.mesh.num_vertices); /* a face that has begun is one of them */
    return next;
}

static cq_result any_result(void) { return nondet_int() ? CQ_OK : CQ_ERROR_CORRUPT; }

/* -- Bits of the coarse faces -------------------------------------------------------------------------------------- */

void claim_step_wipe(void)
{
    cq_index before;
    any_level();
    d.phase = CQI_WIPE;
    r->at = before = any_index();
    ASSUME(r->at < (5 * r->faces + 7) / 8);
    PROVE(cqi_step_wipe(&d) == CQ_OK);
    PROVE(d.phase == CQI_MARKS || r->at > before);
    REACHED();
}

/* Each face has bits of its own, within the queue. Those of face f + 8 are 5 bytes behind those of f, of eight faces all
 * positions in a byte are tried. */
void claim_face_states(void)
{
    const cq_index faces = any_index(), last = any_index();
    cq_index f, g, h;
    int before, of_f, bits;
    ASSUME(last < faces && faces <= CQ_NONE / 3);
    PROVE((5 * (size_t)last >> 3) + 1 < ((size_t)faces / 3 + 1) * 2);
    any_level();
    ASSUME(r->faces == FACES);
    f = (cq_index)any_between(0, FACES - 1);
    g = (cq_index)any_between(0, FACES - 1);
    h = (cq_index)any_between(0, 3 * FACES - 1);
    bits = any_between(0, 31);
    of_f = cqi_state_of(&d, f);
    before = cqi_state_of(&d, g);
    PROVE(cqi_has_mark(&d, h) == (cqi_state_of(&d, (cq_index)(h / 3)) >> h % 3 & 1));
    cqi_toggle_state(&d, f, bits);
    PROVE(cqi_state_of(&d, f) == (of_f ^ bits) && (f == g || cqi_state_of(&d, g) == before));
    REACHED();
}

/* -- Marks and the table ------------------------------------------------------------------------------------------- */

cq_result stub_code_mark(cq_decoder *of, cq_index h)
{
    (void)of;
    PROVE(h < 3 * r->faces);
    r->count = (cq_index)(r->count + (cq_index)any_between(0, 1));
    return any_result();
}

/* Each step turns to the next face, or to the table if there are enough marks: then a bucket has at most 128 of the
 * halfedges. Of meshes without materials, whose faces are all there. */
void claim_step_marks(void)
{
    cq_index before;
    any_level();
    r->faces = any_index();
    ASSUME(r->faces > 0 && r->faces < 1 << 24);
    r->real_faces = r->faces;
    r->count = any_index();
    ASSUME(r->count <= 3 * r->faces);
    r->vertices = any_index();
    ASSUME(r->vertices < 1 << 24);
    r->at = before = any_index();
    ASSUME(r->at <= r->faces);
    ASSUME(r->faces < FACES || r->at == r->faces); /* a face in reach of twin_of, or none is left */
    d.phase = CQI_MARKS;
    if (cqi_step_marks(&d) != CQ_OK) return;
    PROVE(d.phase == CQI_TABLE || r->at > before);
    PROVE(d.phase != CQI_TABLE || (r->bucket <= 7 && (3 * r->faces - 1) >> r->bucket < r->count));
    if (d.phase == CQI_TABLE) REACHED();
}

/* New vertices are in ascending order of their edges, all of which are below 2^bucket times their number. */
static void any_new_vertices(void)
{
    cq_index k;
    r->bucket = any_between(0, 7);
    ASSUME(r->count > 0 && (3 * r->faces - 1) >> r->bucket < r->count);
    for (k = 0; k < r->count; k++) {
        out_of[OLD + k] = any_index();
        ASSUME(out_of[OLD + k] < 3 * r->faces && (!k || out_of[OLD + k] > out_of[OLD + k - 1]));
    }
}

/* Bucket k begins with the first new vertex that is not before it. */
static int bucket_holds(cq_index k)
{
    const cq_index first = valence_of[OLD + k];
    return first < r->count && out_of[OLD + first] >> r->bucket >= k &&
           (!first || out_of[OLD + first - 1] >> r->bucket < k);
}

/* The table so far: buckets before `record` are filled, and those of vertices before `at`. */
static int table_holds(void)
{
    cq_index k;
    if (r->at > r->count || r->record > r->count) return 0;
    if (r->at && (out_of[OLD + r->at - 1] >> r->bucket) >= r->record) return 0;
    if (r->at < r->count && r->at && r->record > (out_of[OLD + r->at] >> r->bucket) + 1) return 0;
    if (!r->at && r->record > (out_of[OLD] >> r->bucket) + 1) return 0;
    for (k = 0; k < r->record; k++)
        if (!bucket_holds(k)) return 0;
    return 1;
}

/* A step fills buckets, or passes vertices: until all are passed, and the buckets up to the last one's are filled. */
void claim_step_table(void)
{
    cq_index at, record;
    any_level();
    any_new_vertices();
    d.phase = CQI_TABLE;
    r->at = at = any_index();
    r->record = record = any_index();
    ASSUME(table_holds() && r->at < r->count);
    PROVE(cqi_step_table(&d) == CQ_OK);
    PROVE(d.phase == CQI_EXPECT);
    for (record = 0; record <= out_of[OLD + r->count - 1] >> r->bucket; record++) PROVE(bucket_holds(record));
    REACHED();
}

/* The new vertex of any marked edge is found, within the records, and an edge without a mark has none. */
void claim_vertex_on(void)
{
    cq_index h, k, v;
    any_level();
    any_new_vertices();
    for (k = 0; k < r->count; k++) {
        ASSUME((out_of[OLD + k] >> r->bucket) < r->count);
        ASSUME(k > out_of[OLD + r->count - 1] >> r->bucket || bucket_holds(k));
    }
    h = any_index();
    ASSUME(h < 3 * r->faces && twin_of[h] > h); /* of two halfedges the smaller one is marked and noted */
    v = any_index();
    if (cqi_has_mark(&d, h)) ASSUME(v >= OLD && v < OLD + r->count && out_of[v] == h);
    else v = CQ_NONE;
    PROVE(cqi_vertex_on(&d, h) == v);
    REACHED();
}

/* -- The sweep ----------------------------------------------------------------------------------------------------- */

static int inserted, flipped;

cq_result stub_code_insertion(cq_decoder *of)
{
    const cq_index v = d.mesh.num_vertices;
    PROVE(of == &d && v < r->vertices + r->count && v - r->own < 3);
    d.mesh.num_vertices++;
    inserted = 1;
    return any_result();
}

cq_result stub_code_flips(cq_decoder *of, cq_index f)
{
    PROVE(of == &d && f < r->faces);
    r->dissolved = any_index();
    return any_result();
}

cq_result stub_step_dissolved(cq_decoder *of)
{
    PROVE(of == &d && r->dissolved != CQ_NONE);
    r->dissolved = CQ_NONE;
    flipped = 1;
    return any_result();
}

cq_result stub_end_regular(cq_decoder *of)
{
    of->phase = CQI_LEVEL;
    return CQ_OK;
}

/* Each step flips a dissolved edge, of which a face has one at most; inserts a vertex, of which a face has three at
 * most; or turns to the next face. */
void claim_step_sweep(void)
{
    cq_index at, v, k;
    any_level();
    any_new_vertices();
    r->at = at = any_index();
    d.mesh.num_vertices = v = any_index();
    r->own = any_index();
    r->dissolved = any_index();
    ASSUME(at <= r->faces && r->own >= OLD && r->own <= v && v <= OLD + r->count);
    for (k = r->own; k < v; k++) ASSUME(out_of[k] / 3 == at); /* those that this face has inserted */
    if (cqi_step_sweep(&d) != CQ_OK) return;
    PROVE(d.phase == CQI_LEVEL || flipped || (inserted && d.mesh.num_vertices == v + 1) || r->at > at);
    PROVE(!flipped || (r->at == at && d.mesh.num_vertices == v && r->dissolved == CQ_NONE));
    PROVE(d.mesh.num_vertices <= OLD + r->count);
    REACHED();
}

/* -- Levels of patches --------------------------------------------------------------------------------------------- */

/* Components that take part: the next vertex is looked at, or marks are cleared next. */
void claim_step_active(void)
{
    cq_index before;
    any_level();
    d.base.vertices = (cq_index)any_between(0, OLD);
    d.active = before = (cq_index)any_between(0, OLD);
    ASSUME(d.active <= d.base.vertices);
    d.phase = CQI_ACTIVE;
    if (cqi_step_active(&d) != CQ_OK) return;
    PROVE(d.active <= d.base.vertices);
    PROVE(d.phase == CQI_CLEAR || d.active > before);
    REACHED();
}

int stub_code_bit(cq_decoder *of, int index, int bit)
{
    (void)of, (void)bit;
    PROVE(index >= 0 && index < CQI_MODELS);
    return any_between(0, 1);
}

/* Marks: the next ones are cleared, or patches follow. */
void claim_step_clear(void)
{
    cq_index before;
    any_level();
    d.mesh.num_vertices = (cq_index)any_between(0, OLD + NEW);
    d.base.vertices = (cq_index)any_between(0, OLD);
    d.active = (cq_index)any_between(0, OLD);
    d.cleared = before = any_index();
    ASSUME(d.active <= d.base.vertices && d.base.vertices <= d.mesh.num_vertices && before <= d.mesh.num_vertices);
    d.phase = CQI_CLEAR;
    PROVE(cqi_step_clear(&d) == CQ_OK);
    PROVE(d.phase == CQI_PATCHES || d.cleared > before);
    REACHED();
}

cq_index stub_dequeue(const cq_mesh *m, cqi_walk *w)
{
    PROVE(m == &d.mesh && w == &d.walk);
    return nondet_int() ? CQ_NONE : (cq_index)any_between(0, OLD + NEW - 1);
}

static int conquered;

cq_result stub_code_patch(cq_decoder *of, cq_index spoke)
{
    (void)of, (void)spoke;
    conquered = 1;
    return any_result();
}

/* Patches: one is conquered (claim_patch_takes), the next vertices are looked at, or the level ends with enough
 * splits. */
void claim_step_patch(void)
{
    cq_index before;
    any_level();
    d.active = (cq_index)any_between(0, OLD);
    d.seed = before = (cq_index)any_between(0, OLD);
    d.splits = any_index();
    d.mesh.num_vertices = any_index();
    d.base.vertices = any_index();
    ASSUME(d.active <= d.base.vertices && d.base.vertices <= d.mesh.num_vertices && before <= d.active);
    ASSUME(d.splits <= d.mesh.num_vertices - d.base.vertices);
    d.phase = CQI_PATCHES;
    if (cqi_step_patch(&d) != CQ_OK) return;
    PROVE(conquered || d.seed > before || (d.phase == CQI_LEVEL && d.splits > 0));
    PROVE(d.seed <= d.active);
    REACHED();
}

int stub_read_ring(cq_mesh *m, cqi_ring *ring, cq_index spoke)
{
    (void)m, (void)spoke;
    ring->size = any_between(2, CQ_MAX_VALENCE);
    return any_between(0, ring->size);
}

int stub_code_flag(cq_decoder *of, int available, int split)
{
    (void)of, (void)available, (void)split;
    return any_between(0, 1);
}

void stub_release_ring(cq_mesh *m, const cqi_ring *ring) { (void)m, (void)ring; }
void stub_queue_neighbours(cq_mesh *m, cqi_walk *w, cq_index spoke) { (void)m, (void)spoke, w->full = any_between(0, 1); }
void stub_queue_fronts(cq_mesh *m, cqi_walk *w, cqi_ring *ring) { (void)m, (void)ring, w->full = any_between(0, 1); }

cq_result stub_code_split(cq_decoder *of)
{
    (void)of;
    return any_result();
}

/* A patch takes its centre, split or not: so no vertex is the centre of two patches of a level. */
void claim_patch_takes(void)
{
    static cq_index origin[3];
    const cq_index spoke = (cq_index)any_between(0, 2);
    any_level();
    origin[spoke] = (cq_index)any_between(0, OLD + NEW - 1);
    d.mesh.origin = origin;
    if (cqi_code_patch(&d, spoke) != CQ_OK) return;
    PROVE((mark_of[origin[spoke]] & CQI_STATE) == CQI_TAKEN);
    REACHED();
}

int stub_count(cq_decoder *of, int index, int count)
{
    (void)of, (void)index, (void)count;
    return any_between(0, 38);
}

uint32_t stub_code_byte(cq_decoder *of, uint32_t value, int bits)
{
    (void)of, (void)value;
    PROVE(bits == 8);
    return (uint32_t)any_between(0, 255);
}

cq_result stub_begin_regular(cq_decoder *of)
{
    of->phase = CQI_WIPE;
    return CQ_OK;
}

/* There are at most CQ_MAX_LEVELS levels; behind the last one is the end, or what is aside. */
void claim_step_level(void)
{
    uint32_t before;
    d.mesh.num_vertices = any_index();
    d.shape.num_vertices = nondet_u32();
    d.shape.regular = nondet_int() != 0;
    d.regular.count = any_index();
    d.level = before = nondet_u32();
    d.located = any_between(-1, 0);
    d.error_code = nondet_u32();
    d.range.count = nondet_size();
    d.range.size = nondet_size();
    d.input.payload_left = nondet_u32();
    ASSUME(d.level <= CQ_MAX_LEVELS && d.mesh.num_vertices <= d.shape.num_vertices && d.error_code <= 255);
    d.phase = CQI_LEVEL;
    if (cqi_step_level(&d) != CQ_OK) return;
    PROVE(d.level == before + 1 && d.level <= CQ_MAX_LEVELS && d.phase != CQI_LEVEL);
    PROVE(d.error_code <= 255);
    REACHED();
}

/* -- What is aside ------------------------------------------------------------------------------------------------- */

int stub_aside_row(cq_decoder *of, uint32_t k)
{
    PROVE(of->aside.num_rows < of->shape.num_aside_rows && k < of->shape.num_channels);
    return any_between(0, 1);
}

int stub_aside_face(cq_decoder *of)
{
    PROVE(of->aside.num_faces < of->shape.num_aside_faces);
    return any_between(0, 1);
}

void stub_metadata_byte(cq_decoder *of)
{
    PROVE(of->metadata_read < of->shape.metadata_bytes);
    of->metadata_read++;
}

/* Rows, faces and metadata stay within their counts, and each step reads one more, or one more channel of a row. */
void claim_step_aside(void)
{
    uint32_t rows, faces, bytes, value;
    uint32_t k;
    d.shape.num_channels = (uint32_t)any_between(0, 2);
    for (k = 0; k < 2; k++) {
        d.shape.channel[k].components = (uint8_t)any_between(1, 4);
        d.shape.channel[k].merge = (uint8_t)any_between(0, CQ_PER_FACE);
    }
    d.shape.num_aside_rows = nondet_u32();
    d.shape.num_aside_faces = nondet_u32();
    d.shape.metadata_bytes = nondet_u32();
    d.aside.num_rows = rows = nondet_u32();
    d.aside.num_faces = faces = nondet_u32();
    d.metadata_read = bytes = nondet_u32();
    d.base.value = value = (uint32_t)any_between(0, 2);
    ASSUME(rows <= d.shape.num_aside_rows && faces <= d.shape.num_aside_faces && bytes <= d.shape.metadata_bytes);
    ASSUME(value == 0 || value < d.shape.num_channels);
    d.phase = CQI_READ_ASIDE;
    if (cqi_step_aside(&d) != CQ_OK) return;
    PROVE(d.aside.num_rows <= d.shape.num_aside_rows && d.aside.num_faces <= d.shape.num_aside_faces);
    PROVE(d.metadata_read <= d.shape.metadata_bytes);
    PROVE(d.phase == CQI_LEVEL || d.aside.num_rows > rows || d.aside.num_faces > faces || d.metadata_read > bytes ||
          d.base.value > value);
    PROVE(d.aside.num_rows >= rows && d.aside.num_faces >= faces && d.metadata_read >= bytes);
    REACHED();
}
