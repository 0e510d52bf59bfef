/* Proofs that corners with the same row stay at the same vertex, and that rows stay within their counts: what a stream
 * says is any answer to any question. The mesh is an octahedron, of which vertex SIDE may be virtual; its rows are any
 * ones with the invariant:
 *
 *     vertex[index[h]] == origin[h] for each corner h of a real face, and index[h] < num_rows
 *
 * A split, an insertion or a flip reads and writes the rows of one or two faces or of one vertex of valence 4, and of
 * the faces beside them; the other faces of the octahedron stand for all others. */
#define CQ_ASSERT(condition) ((void)0)
#include "proof.h"

#ifndef BOUNDARY
#define BOUNDARY 0 /* 1: SIDE is a virtual vertex */
#endif
#ifndef LAST
#define LAST 1 /* of a split: number of the spoke to q, from that to p on; all others are rotations of these */
#endif
#ifndef START
#define START 0 /* the halfedge of the operation, or which one clockwise around the top; all are alike without SIDE */
#endif

enum { ROWS = 12, MORE_ROWS = 8, TOP = 0, BOTTOM = 4, SIDE = BOUNDARY ? 6 : 5, REAL = BOUNDARY ? 6 : 7 };
enum { FIRST_VIRTUAL_FACE = BOUNDARY ? 6 : 10, ALL_FACES = BOUNDARY ? 11 : 10, VERTICES = REAL + 1 };

static cq_decoder d;
static cqi_seams seams;
static cq_index origin_of[3 * ALL_FACES], twin_of[3 * ALL_FACES], index_of[3 * FIRST_VIRTUAL_FACE];
static cq_index out_of[VERTICES], valence_of[VERTICES], vertex_of[ROWS + MORE_ROWS];
static uint8_t mark_of[VERTICES];

/* Slots of the faces: those with SIDE are virtual if it is. */
static const cq_index face[8][4] = {
    { 0, TOP, 1, 2 }, { 1, TOP, 2, 3 }, { 2, BOTTOM, 2, 1 }, { 3, BOTTOM, 3, 2 },
    { BOUNDARY ? 6 : 4, TOP, 3, SIDE }, { BOUNDARY ? 7 : 5, TOP, SIDE, 1 },
    { BOUNDARY ? 8 : 6, BOTTOM, SIDE, 3 }, { BOUNDARY ? 9 : 7, BOTTOM, 1, SIDE }
};

static void octahedron(void)
{
    cq_mesh *m = &d.mesh;
    int i, j, k, l;
    m->origin = origin_of;
    m->twin = twin_of;
    m->out = out_of;
    m->valence = valence_of;
    m->mark = mark_of;
    m->first_virtual = REAL;
    m->num_vertices = REAL - 1;
    m->num_virtual = m->max_virtual = BOUNDARY;
    m->first_virtual_face = FIRST_VIRTUAL_FACE;
    m->num_faces = BOUNDARY ? 4 : 8;
    m->num_virtual_faces = BOUNDARY ? 4 : 0;
    m->max_virtual_faces = ALL_FACES - FIRST_VIRTUAL_FACE;
    m->free_vertex = m->free_face = m->free_virtual_face = CQ_NONE;
    for (i = 0; i < 8; i++)
        for (k = 0; k < 3; k++) {
            origin_of[3 * face[i][0] + k] = face[i][1 + k];
            out_of[face[i][1 + k]] = (cq_index)(3 * face[i][0] + k);
            valence_of[face[i][1 + k]] = 4;
        }
    for (i = 0; i < 8; i++)
        for (k = 0; k < 3; k++)
            for (j = 0; j < 8; j++)
                for (l = 0; l < 3; l++)
                    if (face[i][1 + k] == face[j][1 + (l + 1) % 3] && face[i][1 + (k + 1) % 3] == face[j][1 + l])
                        twin_of[3 * face[i][0] + k] = (cq_index)(3 * face[j][0] + l);
    d.index = index_of;
    d.vertex = vertex_of;
    d.seams = &seams;
    d.located = -1;
}

/* The corner of a real face in use has a row of its vertex. */
static int corner_holds(cq_index h)
{
    return h / 3 >= d.mesh.num_faces || (index_of[h] < d.num_rows && vertex_of[index_of[h]] == origin_of[h]);
}

static void any_rows(void)
{
    cq_index h;
    octahedron();
    for (h = 0; h < ROWS; h++) vertex_of[h] = (cq_index)any_between(0, BOTTOM);
    if (!BOUNDARY)
        for (h = 0; h < ROWS; h++) vertex_of[h] = (cq_index)any_between(0, SIDE);
    d.num_rows = seams.num_rows = (cq_index)any_between(1, ROWS);
    d.shape.num_rows = (uint32_t)any_between(0, ROWS + MORE_ROWS);
    ASSUME(d.shape.num_rows >= d.num_rows);
    for (h = 0; h < 3 * FIRST_VIRTUAL_FACE; h++) {
        index_of[h] = any_index();
        ASSUME(corner_holds(h));
    }
}

static void all_hold(void)
{
    cq_index h;
    PROVE(d.num_rows <= d.shape.num_rows);
    for (h = 0; h < 3 * FIRST_VIRTUAL_FACE; h++) PROVE(corner_holds(h));
}

/* Any answer. */
int stub_code_with(cq_decoder *of, cq_bit_model *model, int bit)
{
    (void)of, (void)bit;
    PROVE(model >= &seams.model[0][0] && model < &seams.model[0][0] + CQI_SEAM_CONTEXTS * CQI_SEAM_MODELS);
    return any_between(0, 1);
}

/* The patch of the top, and a pair of it. */
static void any_pair(void)
{
    cq_index spoke;
    int k;
    any_rows();
    spoke = out_of[TOP];
    for (k = 0; k < START; k++) spoke = cq_clockwise(&d.mesh, spoke);
    cqi_read_ring(&d.mesh, &d.ring, spoke);
    cqi_begin_corners(&d, 0, LAST);
}

/* The vertex that a row has once its split is done: that of B, if it is in the run that goes there. */
static cq_index vertex_after(cq_index row)
{
    cq_index v = vertex_of[row];
    int k;
    for (k = 1; k <= LAST; k++)
        if (seams.run[k] == row) v = d.mesh.num_vertices;
    return v;
}

/* What is decided about the corners of a split: those that go to B have rows of A that A does not keep, or new ones;
 * and each corner of the new faces has a row of its vertex. corners.c proves that this is what is decided. */
static int is_decided(void)
{
    int k, j, holds = d.num_rows <= seams.num_rows && seams.num_rows <= d.shape.num_rows;
    for (k = 1; k <= LAST; k++) {
        const cq_index row = seams.run[k];
        holds &= (row == CQ_NONE) == (cqi_row_at(&d, d.ring.spoke[k]) == CQ_NONE);
        if (row == CQ_NONE) continue;
        holds &= row < seams.num_rows;
        if (row >= seams.num_rows) return 0;
        holds &= vertex_of[row] == TOP || vertex_of[row] == d.mesh.num_vertices;
        for (j = 0; j < d.ring.size; j++)
            if (j < 1 || j > LAST) holds &= cqi_row_at(&d, d.ring.spoke[j]) != row;
    }
    for (k = 0; k < CQI_CORNERS; k++) {
        if (d.ring.boundary == (k < 3 ? 0 : LAST)) continue;
        if (seams.row[k] >= seams.num_rows) return 0;
        holds &= vertex_after(seams.row[k]) == cqi_vertex_of_corner(&d, k);
    }
    return holds;
}

/* The split, whatever was decided. */
void claim_rows_are_applied(void)
{
    cq_index h;
    int k;
    any_pair();
    seams.num_rows = any_index();
    ASSUME(seams.num_rows <= ROWS + MORE_ROWS);
    for (k = 1; k <= LAST; k++) seams.run[k] = any_index();
    for (k = 0; k < CQI_CORNERS; k++) seams.row[k] = any_index();
    for (h = 0; h < ROWS + MORE_ROWS; h++)
        if (h >= d.num_rows) vertex_of[h] = any_index();
    ASSUME(is_decided());
    if (cqi_apply_rows(&d) != CQ_OK) return;
    all_hold();
    PROVE(d.num_rows == seams.num_rows);
    REACHED();
}

/* Any flip that a regular level may do. */
void claim_rows_of_flip(void)
{
    const cq_index h = START;
    any_rows();
    if (cqi_flip_checked(&d, h) != CQ_OK) return;
    all_hold();
    REACHED();
}

/* Any insertion, into an edge of a real face, of a vertex with one row or two, whose slots are those of its record. */
void claim_rows_of_insertion(void)
{
    const cq_index h = START;
    cq_mesh *m = &d.mesh;
    cq_index v;
    any_rows();
    v = m->num_vertices;
    seams.num_rows = (cq_index)(d.num_rows + (cq_index)any_between(1, 2));
    ASSUME(seams.num_rows <= d.shape.num_rows);
    vertex_of[d.num_rows] = v;
    vertex_of[d.num_rows + 1] = any_index();
    d.regular.record = m->num_faces;
    ASSUME(cqi_take_slots(&d, h));
    cqi_split_index(&d, v, h);
    if (cq_mesh_split(m, cq_counterclockwise(m, h), cq_clockwise(m, h)) == CQ_NONE) return;
    all_hold();
    PROVE(d.num_rows <= seams.num_rows);
    REACHED();
}

/* The corners of a new vertex of the base: each row is one of those that the vertex has, or a new one. */
void claim_row_of_base(void)
{
    cq_index h, k, before;
    any_rows();
    seams.first = (cq_index)any_between(0, ROWS);
    ASSUME(seams.first <= seams.num_rows);
    for (k = 0; k < ROWS; k++) ASSUME(k < seams.first || vertex_of[k] == TOP);
    d.base.draft = d.mesh;
    seams.vertex = TOP;
    h = out_of[TOP];
    for (k = 0; k < START; k++) h = cq_clockwise(&d.mesh, h);
    seams.corner = h;
    before = cqi_row_at(&d, cq_counterclockwise(&d.mesh, h)); /* of this vertex, if it has had its turn */
    ASSUME(h == out_of[TOP] || before == CQ_NONE || (before >= seams.first && before < seams.num_rows));
    if (!cqi_code_base_corner(&d)) return;
    PROVE(index_of[h] >= seams.first && index_of[h] < seams.num_rows && vertex_of[index_of[h]] == TOP);
    PROVE(seams.num_rows <= d.shape.num_rows);
    REACHED();
}

/* A row is added where there is room, else the level is given up. */
void claim_add_row(void)
{
    cq_index row, before;
    octahedron();
    d.shape.num_rows = (uint32_t)any_between(0, ROWS + MORE_ROWS);
    before = seams.num_rows = (cq_index)any_between(0, ROWS + MORE_ROWS);
    ASSUME(before <= d.shape.num_rows);
    row = cqi_add_row(&d, TOP, 0);
    PROVE(seams.num_rows <= d.shape.num_rows);
    PROVE(seams.full || (row == before && seams.num_rows == before + 1 && vertex_of[row] == TOP));
    REACHED();
}
