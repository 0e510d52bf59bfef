/* Proofs about the rows of a split before it is done: what is decided about its corners, whatever a stream says. The
 * ring may have any size, its vertices and rows any numbers, and one vertex may be virtual. Of the rows before, only
 * what the invariant says is known:
 *
 *     vertex[index[h]] == origin[h] for each corner h of a real face, and index[h] < num_rows
 *
 * Parts, one after the other: claim_split_rows is about one corner that goes to B, from any state that those before it
 * leave, so about all of them. As its row is not one that A keeps, row z is not both in the run and kept, which
 * claim_list_choices assumes: so the choices are rows of their vertices. Claims about code_corner and code_corners say
 * that corners get these or new rows of their vertices, which are made one after the other: at most two of A's and six
 * of corners, each beside one that came before. That is what rows.c assumes (is_decided).
 *
 * Claims are about a spoke y and an old row z of the verifier's choice, instead of all, and its vertex. Halfedges of the
 * ring's faces have names in place of numbers, so cq_next and the rows of corners are stubs. */
#include "proof.h"

enum { MOST = CQ_MAX_VALENCE };

/* Spoke k, from A to vertex k, is halfedge k; then those from vertex k to A, and from vertex k to the one before. The
 * face of a spoke is between its vertex and the one before. */
enum { BACK = 32, RIM = 64, HALFEDGES = 96 };

static cq_decoder d;
static cqi_seams seams;
static cq_index row_of[HALFEDGES], twin_of[HALFEDGES], origin_of[1], vertex_of_new[CQI_MAX_NEW_ROWS];
static cq_index z, vertex_of_z;
static int z_goes; /* B's run has row z */

/* -- The ring ------------------------------------------------------------------------------------------------------ */

static int any_spoke(void) { return (int)(nondet_u8() & 31); }
static int follows(int k) { return k == d.ring.size - 1 ? 0 : k + 1; }
static int precedes(int k) { return k ? k - 1 : d.ring.size - 1; }
static int is_of_ring(int k) { return k < d.ring.size; }
static int is_in_run(int k) { return k > seams.p && k <= seams.q; }

/* Any size and pair. */
static void any_pair(void)
{
    int k;
    d.seams = &seams;
    d.ring.size = any_spoke();
    d.ring.boundary = any_spoke();
    seams.q = any_spoke();
    seams.p = any_spoke();
    ASSUME(d.ring.size <= MOST && seams.p < seams.q && seams.q < d.ring.size);
    ASSUME(d.ring.boundary < d.ring.size || d.ring.boundary == CQ_MAX_VALENCE);
    for (k = 0; k < MOST; k++) d.ring.spoke[k] = (cq_index)k;
}

/* Any rows at the corners of the ring's faces; what is known of one is said where it is read. */
static void any_ring(void)
{
    const cq_index a = any_index(), b = any_index();
    cq_index rows[HALFEDGES];
    int k;
    any_pair();
    ASSUME(a < b && b < CQ_NONE);
    origin_of[0] = a;
    d.mesh.origin = origin_of;
    d.mesh.twin = twin_of;
    d.mesh.num_vertices = b;
    d.num_rows = any_index();
    d.shape.num_rows = nondet_u32();
    ASSUME(d.num_rows <= d.shape.num_rows && d.shape.num_rows <= CQI_MAX_HALFEDGES);
    z = any_index();
    vertex_of_z = any_index();
    ASSUME(z < d.num_rows);
    for (k = 0; k < MOST; k++) {
        d.ring.vertex[k] = any_index();
        ASSUME(d.ring.vertex[k] != a && d.ring.vertex[k] != b);
        twin_of[k] = (cq_index)(BACK + k);
    }
    for (k = 0; k < HALFEDGES; k++) row_of[k] = rows[k];
}

/* The faces next to a virtual vertex are virtual; their corners have no rows. */
static int is_of_virtual_face(cq_index h)
{
    const int k = (int)(h & 31), face = h >= BACK && h < RIM ? follows(k) : k;
    return d.ring.boundary < MOST && (face == d.ring.boundary || face == follows(d.ring.boundary));
}

cq_index stub_next(cq_index h)
{
    PROVE(h < HALFEDGES);
    if (h < BACK) return (cq_index)(RIM + h);
    return h < RIM ? (cq_index)follows((int)h - BACK) : (cq_index)(BACK + precedes((int)h - RIM));
}

/* A row of the corner's vertex. If B's run has row z, A keeps no corner with it. */
cq_index stub_row_at(const cq_decoder *of, cq_index h)
{
    const cq_index row = row_of[h];
    PROVE(of == &d && h < HALFEDGES && is_of_ring((int)(h & 31)));
    if (is_of_virtual_face(h)) ASSUME(row == CQ_NONE);
    else ASSUME(row < d.num_rows && (row != z || vertex_of_z == (h < BACK ? origin_of[0] : d.ring.vertex[h & 31])));
    ASSUME(!z_goes || row != z || h >= BACK || is_in_run((int)h));
    return row;
}

/* Only real faces have rows, and only their corners are read. */
void claim_row_at(void)
{
    const cq_index faces = (cq_index)any_between(0, 8), h = any_index();
    cq_index index[24], row;
    d.index = index + 24 - 3 * faces;
    d.mesh.first_virtual_face = faces;
    row = cqi_row_at(&d, h);
    PROVE(row == (h < 3 * faces ? d.index[h] : CQ_NONE));
    REACHED();
}

/* -- The rows that are made ---------------------------------------------------------------------------------------- */

static cq_index vertex_added;

/* See claim_add_row of rows.c. */
cq_index stub_add_row(cq_decoder *of, cq_index vertex, cq_index wedge)
{
    (void)wedge;
    PROVE(of == &d && seams.num_rows <= d.shape.num_rows);
    vertex_added = vertex;
    if (seams.num_rows == d.shape.num_rows) {
        seams.full = 1;
        return 0;
    }
    return seams.num_rows++;
}

cq_index stub_make_row(cq_decoder *of, cq_index vertex, cq_index beside, int corner, cq_index wedge)
{
    const int n = seams.num_new;
    PROVE(n >= 0 && n < CQI_MAX_NEW_ROWS);
    seams.made[n].beside = beside;
    seams.made[n].corner = corner;
    seams.num_new = n + 1;
    vertex_of_new[n] = vertex;
    return stub_add_row(of, vertex, wedge);
}

/* What is said of a new row is kept with it. */
void claim_make_row(void)
{
    const cq_index vertex = any_index(), beside = any_index(), rows = any_index();
    const int corner = any_between(0, CQI_CORNERS), before = any_between(0, CQI_MAX_NEW_ROWS - 1);
    cq_index row;
    int n;
    d.seams = &seams;
    d.shape.num_rows = nondet_u32();
    ASSUME(rows <= d.shape.num_rows);
    for (n = 0; n < CQI_MAX_NEW_ROWS; n++) {
        if (n != before) continue;
        seams.num_rows = rows;
        seams.num_new = n;
        row = cqi_make_row(&d, vertex, beside, corner, 0);
        PROVE(seams.num_new == n + 1 && seams.made[n].beside == beside && seams.made[n].corner == corner);
        PROVE(vertex_added == vertex && (seams.full || (row == rows && seams.num_rows == rows + 1)));
        REACHED();
    }
}

/* A row that is split from one of A: it is B's, and what it is beside was there before. */
static int made_holds(int n)
{
    return n >= seams.num_new || (seams.made[n].corner == CQI_CORNERS && seams.made[n].beside < d.num_rows &&
                                  vertex_of_new[n] == d.mesh.num_vertices);
}

/* New rows have the numbers behind all others, in their order. */
static int counts_hold(void)
{
    return seams.num_rows >= d.num_rows && seams.num_rows <= d.shape.num_rows &&
           seams.num_rows - d.num_rows == (cq_index)seams.num_new;
}

/* Up to two rows that are split from A's. */
static void any_made(void)
{
    int n;
    seams.num_new = any_between(0, 2);
    ASSUME((cq_index)seams.num_new <= d.shape.num_rows - d.num_rows);
    seams.num_rows = (cq_index)(d.num_rows + (cq_index)seams.num_new);
    for (n = 0; n < 2; n++) {
        seams.made[n].beside = any_index();
        seams.made[n].corner = CQI_CORNERS;
        vertex_of_new[n] = d.mesh.num_vertices;
        ASSUME(n >= seams.num_new || seams.made[n].beside < d.num_rows);
    }
}

/* -- The corners that go to B -------------------------------------------------------------------------------------- */

/* Spoke y, and the row of its corner; the row that was looked at last. */
static cq_index y, row_of_y, asked;

static void any_kept_spoke(void)
{
    y = (cq_index)any_spoke();
    ASSUME(is_of_ring((int)y) && !is_in_run((int)y));
}

cq_index stub_row_of_kept(const cq_decoder *of, cq_index h)
{
    PROVE(of == &d && is_of_ring((int)h) && !is_in_run((int)h));
    asked = any_index();
    if (h == y) ASSUME(asked == row_of_y);
    return asked;
}

/* A row is kept if a corner that A keeps has it: all those are looked at, and no others. */
void claim_is_kept(void)
{
    const cq_index row = any_index();
    any_pair();
    any_kept_spoke();
    row_of_y = any_index();
    if (cqi_is_kept(&d, row)) PROVE(asked == row);
    else PROVE(row_of_y != row);
    REACHED();
}

static int said_kept;

int stub_is_kept(const cq_decoder *of, cq_index row)
{
    said_kept = any_between(0, 1);
    PROVE(of == &d && row != CQ_NONE);
    ASSUME(said_kept || row != row_of_y);
    return said_kept;
}

/* One corner of the run, from any rows that the corners before it have made: it gets its row if A does not keep that,
 * else a new one, which may be that of a corner before it. */
void claim_split_rows(void)
{
    const int n = any_between(0, CQI_MAX_NEW_ROWS - 1);
    int before;
    cq_index row, x, made_before;
    any_ring();
    any_made();
    any_kept_spoke();
    row_of_y = cqi_row_at(&d, y);
    before = seams.num_new;
    made_before = seams.made[n].beside;
    x = (cq_index)any_spoke();
    ASSUME(is_in_run((int)x));
    seams.p = (int)x - 1;
    seams.q = (int)x;
    cqi_split_rows(&d);
    if (seams.full) return;
    row = seams.run[x];
    PROVE(counts_hold() && seams.num_new >= before && seams.num_new <= 2 && made_holds(n));
    PROVE(n >= before || seams.made[n].beside == made_before);
    if (row_of[x] == CQ_NONE) PROVE(row == CQ_NONE);
    else if (!said_kept) PROVE(row == row_of[x] && row != row_of_y);
    else PROVE(row >= d.num_rows && row < seams.num_rows && seams.made[row - d.num_rows].beside == row_of[x]);
    REACHED();
}

/* -- The corners of the new faces ---------------------------------------------------------------------------------- */

/* Any row, of a spoke of the ring. */
cq_index stub_row_of_spoke(const cq_decoder *of, cq_index h)
{
    PROVE(of == &d && is_of_ring((int)h));
    return any_index();
}

void claim_rows_of_centre(void)
{
    int n;
    any_pair();
    n = cqi_rows_of_centre(&d);
    PROVE(n >= 0 && n <= 2);
    REACHED();
}

int stub_rows_of_centre(const cq_decoder *of)
{
    PROVE(of == &d);
    return any_between(0, 2);
}

/* A corner may have the row, whose vertex is that of the corner once the split is done: that of row z is B then, if
 * B's run has it. */
static int is_right(cq_index row, int corner)
{
    const cq_index vertex = cqi_vertex_of_corner(&d, corner);
    if (row >= d.num_rows) return row < seams.num_rows && vertex_of_new[row - d.num_rows] == vertex;
    return row != z || (z_goes ? d.mesh.num_vertices : vertex_of_z) == vertex;
}

/* Is the new face of the corner real? */
static int is_present(int corner) { return d.ring.boundary != (corner < 3 ? seams.p : seams.q); }

static int choice_is_right(int corner)
{
    const cq_index usual = seams.usual[corner], other = seams.other[corner];
    return (usual == CQ_NONE || is_right(usual, corner)) &&
           (other == CQ_NONE || (usual != CQ_NONE && is_right(other, corner)));
}

/* What claim_split_rows says of a corner that goes to B. */
static void any_run_row(int k)
{
    const cq_index row = any_index();
    seams.run[k] = row;
    if (cqi_row_at(&d, (cq_index)k) == CQ_NONE) ASSUME(row == CQ_NONE);
    else if (row >= d.num_rows) ASSUME(row < seams.num_rows && vertex_of_new[row - d.num_rows] == d.mesh.num_vertices);
    else ASSUME(row == row_of[k] && (row != z || z_goes));
}

/* Whatever the run's rows are, corners may choose among rows of their vertices. */
void claim_list_choices(void)
{
    const int corner = any_between(0, CQI_CORNERS - 1);
    any_ring();
    any_made();
    z_goes = any_between(0, 1);
    any_run_row(seams.p + 1);
    if (seams.q != seams.p + 1) any_run_row(seams.q);
    ASSUME(!z_goes || vertex_of_z == origin_of[0]);
    cqi_list_choices(&d);
    PROVE(seams.context >= 0 && seams.context < CQI_SEAM_CONTEXTS);
    PROVE(!is_present(corner) || choice_is_right(corner));
    REACHED();
}

/* Any answer. */
int stub_code_with(cq_decoder *of, cq_bit_model *model, int bit)
{
    (void)bit;
    PROVE(of == &d && __CPROVER_same_object(model, &seams));
    PROVE(__CPROVER_POINTER_OFFSET(model) < sizeof seams.model);
    return any_between(0, 1);
}

/* Each corner is at A, B, p or q. */
void claim_vertex_of_corner(void)
{
    const int corner = any_between(0, CQI_CORNERS - 1);
    cq_index vertex;
    any_ring();
    vertex = cqi_vertex_of_corner(&d, corner);
    if (corner == CQI_LEFT_A || corner == CQI_RIGHT_A) PROVE(vertex == origin_of[0]);
    else if (corner == CQI_LEFT_B || corner == CQI_RIGHT_B) PROVE(vertex == d.mesh.num_vertices);
    else PROVE(vertex == d.ring.vertex[corner == CQI_AT_P ? seams.p : seams.q]);
    REACHED();
}

/* What a row was made of. */
static cq_index row_made, vertex_of_made, beside_of_made;
static int corner_of_made;

cq_index stub_record_row(cq_decoder *of, cq_index vertex, cq_index beside, int corner, cq_index wedge)
{
    (void)wedge;
    PROVE(of == &d);
    vertex_of_made = vertex;
    beside_of_made = beside;
    corner_of_made = corner;
    row_made = any_index();
    return row_made;
}

/* One corner: its row is one of its choices, or a new one of its vertex, beside the usual one. */
void claim_code_corner(void)
{
    const int corner = any_between(0, CQI_CORNERS - 1);
    cq_index row;
    int k;
    any_ring();
    seams.context = any_between(0, CQI_SEAM_CONTEXTS - 1);
    for (k = 0; k < CQI_CORNERS; k++) {
        seams.row[k] = any_index();
        seams.usual[k] = any_index();
        seams.other[k] = any_index();
    }
    corner_of_made = CQI_CORNERS;
    row = cqi_code_corner(&d, corner);
    if (corner_of_made == CQI_CORNERS) {
        PROVE(row != CQ_NONE && (row == seams.usual[corner] || row == seams.other[corner]));
    } else {
        PROVE(row == row_made && corner_of_made == corner && beside_of_made == seams.usual[corner]);
        PROVE(vertex_of_made == cqi_vertex_of_corner(&d, corner));
    }
    REACHED();
}

/* The choices that were listed, the rows that the corners got, and how many corners were asked about. */
static cq_index listed[2][CQI_CORNERS], got[CQI_CORNERS];
static int next_corner, num_asked;

static int is_listed(cq_index row, int corner)
{
    if (row == CQ_NONE || row == listed[0][corner] || row == listed[1][corner]) return 1;
    return (corner == CQI_RIGHT_A || corner == CQI_RIGHT_B) && is_present(0) && row == got[corner - 3];
}

cq_index stub_code_corner(cq_decoder *of, int corner)
{
    PROVE(of == &d && corner >= next_corner && is_present(corner));
    PROVE(is_listed(seams.usual[corner], corner) && is_listed(seams.other[corner], corner));
    PROVE(seams.usual[corner] != CQ_NONE || seams.other[corner] == CQ_NONE);
    next_corner = corner + 1;
    num_asked++;
    got[corner] = any_index();
    ASSUME(got[corner] != CQ_NONE);
    return got[corner];
}

/* Each corner has the row that is usual, or is asked about once; what it may choose is what was listed for it, or the
 * row of the other new face at the same vertex. */
void claim_code_corners(void)
{
    const int corner = any_between(0, CQI_CORNERS - 1);
    int k;
    d.seams = &seams;
    d.ring.boundary = any_spoke();
    seams.q = any_spoke();
    seams.p = any_spoke();
    seams.context = any_between(0, CQI_SEAM_CONTEXTS - 1);
    for (k = 0; k < CQI_CORNERS; k++) {
        listed[0][k] = seams.usual[k] = any_index();
        listed[1][k] = seams.other[k] = any_index();
        ASSUME(seams.usual[k] != CQ_NONE || seams.other[k] == CQ_NONE);
    }
    cqi_code_corners(&d);
    PROVE(num_asked <= CQI_CORNERS);
    if (!is_present(corner)) PROVE(seams.row[corner] == CQ_NONE);
    else PROVE(seams.row[corner] != CQ_NONE && seams.row[corner] == (num_asked ? got : listed[0])[corner]);
    REACHED();
}

/* -- Rows that values are taken from ------------------------------------------------------------------------------- */

static cq_index made_row; /* the row whose values are being read: all before it have theirs */

static int came_before(cq_index row) { return row == CQ_NONE || row < made_row; }

/* The last row before it that its face has, or none: whatever rows the corners have. */
void claim_row_in_face(void)
{
    const int corner = any_between(0, CQI_CORNERS - 1), other = any_between(0, CQI_CORNERS - 1);
    cq_index last;
    int k;
    made_row = any_index();
    for (k = 0; k < CQI_CORNERS; k++) seams.row[k] = any_index();
    last = cqi_row_in_face(&seams, corner, made_row);
    PROVE(came_before(last));
    if (other / 3 == corner / 3 && seams.row[other] < made_row) PROVE(last != CQ_NONE && last >= seams.row[other]);
    REACHED();
}

int stub_rows_are_equal(const cq_decoder *of, uint32_t k, cq_index a, cq_index b)
{
    (void)k;
    PROVE(of == &d && a < made_row && b < made_row);
    return any_between(0, 1);
}

static cqi_nearby nearby;

static int nearby_holds(const cqi_nearby *n, int j)
{
    return n->num_rows >= 0 && n->num_rows <= CQI_NEARBY && (j >= n->num_rows || n->row[j] < made_row);
}

/* At most as many as there is room for are listed, and no others than come before. */
void claim_add_nearby(void)
{
    const cq_index candidate = any_index();
    const int j = any_between(0, CQI_NEARBY - 1);
    int k, before;
    made_row = any_index();
    nearby.num_rows = before = any_between(0, CQI_NEARBY);
    for (k = 0; k < CQI_NEARBY; k++) {
        nearby.row[k] = any_index();
        ASSUME(nearby_holds(&nearby, k));
    }
    ASSUME(came_before(candidate));
    cqi_add_nearby(&d, 0, candidate, &nearby);
    PROVE(nearby_holds(&nearby, j) && nearby.num_rows >= before && nearby.num_rows <= before + 1);
    REACHED();
}

void stub_add_nearby(const cq_decoder *of, uint32_t k, cq_index candidate, cqi_nearby *n)
{
    (void)k;
    PROVE(of == &d && came_before(candidate) && n == &nearby);
}

/* A mesh in range: any halfedge may follow any other one, and any row may be at it that is in the mesh. */
cq_index stub_any_next(cq_index h)
{
    const cq_index next = (cq_index)(nondet_u8() & 127);
    PROVE(h < HALFEDGES);
    ASSUME(next < HALFEDGES);
    return next;
}

cq_index stub_any_row(const cq_decoder *of, cq_index h)
{
    const cq_index row = any_index();
    PROVE(of == &d && h < HALFEDGES);
    ASSUME(row == CQ_NONE || row < d.num_rows);
    return row;
}

/* The rows of the vertex of any corner; B's run may have new ones that come later. */
void claim_list_nearby(void)
{
    const int corner = any_between(0, CQI_CORNERS - 1);
    int k;
    any_ring();
    for (k = 0; k < HALFEDGES; k++) {
        twin_of[k] = (cq_index)(nondet_u8() & 127);
        ASSUME(twin_of[k] < HALFEDGES);
    }
    for (k = 0; k < CQ_MAX_VALENCE; k++) seams.run[k] = any_index();
    made_row = any_index();
    ASSUME(made_row >= d.num_rows && made_row < d.shape.num_rows);
    cqi_list_nearby(&d, 0, corner, made_row, &nearby);
    REACHED();
}

int stub_code_equal(cq_decoder *of, uint32_t k, int model, cq_index row, cq_index other)
{
    (void)k;
    PROVE(of == &d && model >= 0 && model < CQI_EQUALS);
    PROVE(row == made_row && other < made_row);
    return any_between(0, 1);
}

/* What claim_add_nearby says of any number of rows. */
static void add_any_nearby(cqi_nearby *n)
{
    const int before = n->num_rows;
    int k;
    n->num_rows = any_between(0, CQI_NEARBY);
    ASSUME(n->num_rows >= before);
    for (k = 0; k < CQI_NEARBY; k++) {
        if (k >= before) n->row[k] = any_index();
        ASSUME(nearby_holds(n, k));
    }
}

void stub_add_some(const cq_decoder *of, uint32_t k, cq_index candidate, cqi_nearby *n)
{
    const int before = n->num_rows;
    (void)k;
    PROVE(of == &d && came_before(candidate));
    add_any_nearby(n);
    ASSUME(n->num_rows <= before + 1);
}

void stub_list_nearby(const cq_decoder *of, uint32_t k, int corner, cq_index row, cqi_nearby *n)
{
    (void)k;
    PROVE(of == &d && corner >= 0 && corner < CQI_CORNERS && row == made_row);
    add_any_nearby(n);
}

/* A row is only asked to be equal to one that came before; the models are those that there are. */
void claim_code_equal_seam_row(void)
{
    const cq_index in_face = any_index();
    cqi_new_row made;
    made.beside = any_index();
    made.corner = any_between(0, CQI_CORNERS - 1);
    made_row = any_index();
    ASSUME(came_before(made.beside) && came_before(in_face));
    cqi_code_equal_seam_row(&d, 0, made_row, &made, in_face);
    REACHED();
}
