/* Proofs about the mesh: meshes of bounded size, but any contents.
 *
 * A mesh has room for REAL_VERTICES + VIRTUAL_VERTICES and REAL_FACES + VIRTUAL_FACES; the contents of its arrays are
 * the verifier's choice, within what a claim assumes. Each array is a block of its own. */
#include "proof.h"

enum {
    VERTICES = REAL_VERTICES + VIRTUAL_VERTICES,
    FACES = REAL_FACES + VIRTUAL_FACES,
    HALFEDGES = 3 * FACES
};

/* cq_next, cq_prev and the face of a halfedge as tables, which are easier to solve than divisions. claim_tables says
 * that they are the same; the driver then puts stub_next and stub_prev in the place of cq_next and cq_prev. */
#define FACE(f) f, f, f
#define NEXT(f) 3 * f + 1, 3 * f + 2, 3 * f
#define PREV(f) 3 * f + 2, 3 * f, 3 * f + 1
#define ALL(x) x(0), x(1), x(2), x(3), x(4), x(5), x(6), x(7)
enum { MAX_HALFEDGES = 24 };
static const uint8_t face_of[MAX_HALFEDGES] = { ALL(FACE) };
static const uint8_t next_of[MAX_HALFEDGES] = { ALL(NEXT) };
static const uint8_t prev_of[MAX_HALFEDGES] = { ALL(PREV) };

cq_index stub_next(cq_index h)
{
    PROVE(h < HALFEDGES);
    return next_of[h];
}

cq_index stub_prev(cq_index h)
{
    PROVE(h < HALFEDGES);
    return prev_of[h];
}

void claim_tables(void)
{
    cq_index h = any_index();
    ASSUME(h < MAX_HALFEDGES);
    PROVE(next_of[h] == cq_next(h) && prev_of[h] == cq_prev(h) && face_of[h] == h / 3);
    REACHED();
}

static cq_index origin_of[HALFEDGES], twin_of[HALFEDGES], out_of[VERTICES], valence_of[VERTICES];
static uint8_t mark_of[VERTICES];

/* Any contents; counts within the capacities. */
static cq_mesh any_mesh(void)
{
    cq_mesh m;
    int k;
    for (k = 0; k < HALFEDGES; k++) {
        origin_of[k] = any_index();
        twin_of[k] = any_index();
    }
    for (k = 0; k < VERTICES; k++) {
        out_of[k] = any_index();
        valence_of[k] = any_index();
        mark_of[k] = 0;
    }
    m.origin = origin_of;
    m.twin = twin_of;
    m.out = out_of;
    m.valence = valence_of;
    m.mark = mark_of;
    m.first_virtual = REAL_VERTICES;
    m.first_virtual_face = REAL_FACES;
    m.max_virtual = VIRTUAL_VERTICES;
    m.max_virtual_faces = VIRTUAL_FACES;
    m.num_vertices = any_index();
    m.num_faces = any_index();
    m.num_virtual = any_index();
    m.num_virtual_faces = any_index();
    m.free_vertex = m.free_face = m.free_virtual_face = CQ_NONE;
    return m;
}

/* -- The check ----------------------------------------------------------------------------------------------------- */

/* Any contents, any counts: no access outside the arrays, no loop without end, and marks left as they were. */
void claim_check_is_safe(void)
{
    cq_mesh m = any_mesh();
    cq_place place;
    cq_result r = cq_mesh_check(&m, &place);
    cq_index v = any_index();
    ASSUME(v < VERTICES);
    PROVE(r == CQ_OK || (r <= CQ_ERROR_INDEX && r >= CQ_ERROR_VERTEX));
    PROVE(m.mark[v] == 0);
    REACHED();
}

/* -- Collapse and split --------------------------------------------------------------------------------------------
 *
 * The local part of the invariant is that twins are an involution without fixed points, and that origins agree across
 * every edge. All faces are in use, vertices may be connected in any way, fans close within STEPS. */

static void assume_local(const cq_mesh *m)
{
    cq_index h;
    for (h = 0; h < HALFEDGES; h++) {
        cq_index t = m->twin[h];
        ASSUME(t < HALFEDGES && t != h && m->origin[h] < VERTICES);
        ASSUME(m->twin[t] == h && m->origin[next_of[t]] == m->origin[h]);
    }
}

static void prove_local(const cq_mesh *m)
{
    cq_index h = any_index(), t;
    ASSUME(h < HALFEDGES && m->origin[face_of[h] * 3] != CQ_NONE);
    t = m->twin[h];
    PROVE(t < HALFEDGES && t != h && m->origin[h] < VERTICES);
    PROVE(m->origin[face_of[t] * 3] != CQ_NONE);
    PROVE(m->twin[t] == h && m->origin[next_of[t]] == m->origin[h]);
}

/* All that the absence of faults needs: numbers in range, fans that close within STEPS. */
static cq_mesh any_mesh_in_range(void)
{
    cq_mesh m = any_mesh();
    cq_index h, v;
    for (h = 0; h < HALFEDGES; h++) ASSUME(m.twin[h] < HALFEDGES && m.origin[h] < VERTICES);
    for (v = 0; v < VERTICES; v++) ASSUME(m.out[v] < HALFEDGES);
    m.num_vertices = REAL_VERTICES;
    m.num_virtual = VIRTUAL_VERTICES;
    m.num_faces = REAL_FACES;
    m.num_virtual_faces = VIRTUAL_FACES;
    return m;
}

/* The fan of h's origin, from h: closes within STEPS steps. Returns its size. */
static cq_index assume_fan(const cq_mesh *m, cq_index h)
{
    cq_index s = h, n = 0;
    do {
        s = next_of[m->twin[s]];
        n++;
    } while (s != h && n < STEPS);
    ASSUME(s == h);
    return n;
}

static cq_mesh any_local_mesh(void)
{
    cq_mesh m = any_mesh();
    assume_local(&m);
    m.num_vertices = REAL_VERTICES;
    m.num_virtual = VIRTUAL_VERTICES;
    m.num_faces = REAL_FACES;
    m.num_virtual_faces = VIRTUAL_FACES;
    return m;
}

static cq_index any_halfedge(void)
{
    cq_index h = any_index();
    ASSUME(h < HALFEDGES);
    return h;
}

/* Only the two ends have to be used right: a halfedge of each fan, which closes. */
void claim_can_collapse_is_safe(void)
{
    cq_mesh m = any_mesh_in_range();
    cq_index h = any_halfedge();
    assume_fan(&m, m.out[m.origin[h]]);
    assume_fan(&m, m.twin[h]);
    if (cq_mesh_can_collapse(&m, h, any_index())) REACHED();
}

void claim_collapse_is_safe(void)
{
    cq_mesh m = any_mesh_in_range();
    cq_index h = any_halfedge(), g = m.twin[h], first, last;
    assume_fan(&m, g);
    cq_mesh_collapse(&m, h, &first, &last);
    PROVE(first < HALFEDGES && last < HALFEDGES);
    REACHED();
}

/* From `first` clockwise, `last` comes within STEPS; any part of the capacity is in use. */
void claim_split_is_safe(void)
{
    cq_mesh m = any_mesh_in_range();
    cq_index first = any_halfedge(), last = any_halfedge(), s = first, n = 0, b;
    do {
        s = next_of[m.twin[s]];
        n++;
    } while (s != last && n < STEPS);
    ASSUME(s == last);
    ASSUME(!cq_is_virtual(&m, m.origin[next_of[first]]) || !cq_is_virtual(&m, m.origin[next_of[last]]));
    m.num_vertices = any_index();
    m.num_faces = any_index();
    m.num_virtual_faces = any_index();
    ASSUME(m.num_vertices <= REAL_VERTICES && m.num_faces <= REAL_FACES && m.num_virtual_faces <= VIRTUAL_FACES);
    b = cq_mesh_split(&m, first, last);
    PROVE(b == CQ_NONE || b == m.num_vertices - 1);
    PROVE(m.num_vertices <= REAL_VERTICES && m.num_faces <= REAL_FACES && m.num_virtual_faces <= VIRTUAL_FACES);
    if (b != CQ_NONE) REACHED();
}

/* Apexes that differ from both ends are what the link condition gives. */
void claim_collapse_keeps_local(void)
{
    cq_mesh m = any_local_mesh();
    cq_index h = any_halfedge(), g = m.twin[h], a = m.origin[h], b = m.origin[g], p, q, first, last;
    p = m.origin[prev_of[h]];
    q = m.origin[prev_of[g]];
    ASSUME(face_of[g] != face_of[h] && a != b && p != a && p != b && q != a && q != b && p != q);
    ASSUME(face_of[m.twin[next_of[h]]] != face_of[g] && face_of[m.twin[prev_of[h]]] != face_of[g]);
    ASSUME(m.twin[next_of[h]] != prev_of[h] && m.twin[next_of[g]] != prev_of[g]);
    assume_fan(&m, g);
    ASSUME(a < m.first_virtual && b < m.first_virtual);
    cq_mesh_collapse(&m, h, &first, &last);
    prove_local(&m);
    PROVE(m.origin[first] == a && m.origin[last] == a);
    PROVE(m.origin[next_of[first]] == p && m.origin[next_of[last]] == q);
    PROVE(m.out[b] == CQ_NONE && m.free_vertex == b && m.free_face != CQ_NONE);
    REACHED();
}

/* Two spokes of one fan; the last real vertex and the last two real faces are the room that the split needs. */
void claim_split_keeps_local(void)
{
    cq_mesh m = any_mesh();
    cq_index h, first = any_index(), last = any_index(), a, b, p, q, s, n;
    const cq_index faces = REAL_FACES - 2;
    for (h = 0; h < 3 * faces; h++) {
        cq_index t = m.twin[h];
        ASSUME(t < 3 * faces && t != h && m.origin[h] < REAL_VERTICES - 1);
        ASSUME(m.twin[t] == h && m.origin[next_of[t]] == m.origin[h]);
    }
    m.num_vertices = REAL_VERTICES - 1;
    m.num_virtual = VIRTUAL_VERTICES;
    m.num_faces = faces;
    m.num_virtual_faces = VIRTUAL_FACES;
    ASSUME(first < 3 * faces && last < 3 * faces && first != last && m.origin[first] == m.origin[last]);
    ASSUME(m.twin[first] != last);
    n = 0;
    s = first;
    do {
        s = next_of[m.twin[s]];
        n++;
    } while (s != last && n < STEPS);
    ASSUME(s == last);
    a = m.origin[first];
    p = m.origin[next_of[first]];
    q = m.origin[next_of[last]];
    ASSUME(m.valence[a] >= n && m.valence[a] < 100 && m.valence[p] < 100 && m.valence[q] < 100);
    b = cq_mesh_split(&m, first, last);
    PROVE(b == REAL_VERTICES - 1 && m.num_vertices == REAL_VERTICES && m.num_faces == REAL_FACES);
    prove_local(&m);
    PROVE(m.valence[b] == n + 2 && m.origin[m.out[a]] == a && m.origin[m.out[b]] == b);
    PROVE(m.origin[last] == b && m.origin[first] == a);
    REACHED();
}

/* No room, or a virtual vertex: nothing changes. */
void claim_split_without_room(void)
{
    cq_mesh m = any_local_mesh();
    cq_index first = any_halfedge(), last = any_halfedge(), k = any_halfedge(), v = any_index();
    cq_index origin = m.origin[k], twin = m.twin[k], valence, out;
    ASSUME(v < VERTICES);
    valence = m.valence[v];
    out = m.out[v];
    PROVE(cq_mesh_split(&m, first, last) == CQ_NONE);
    PROVE(m.origin[k] == origin && m.twin[k] == twin && m.valence[v] == valence && m.out[v] == out);
    PROVE(m.num_vertices == REAL_VERTICES && m.num_faces == REAL_FACES);
    REACHED();
}

/* -- Building ------------------------------------------------------------------------------------------------------ */

/* Any triangles: no fault, in exactly the memory for as much boundary as the virtual capacities allow. */
void claim_build(void)
{
    cq_index indices[3 * REAL_FACES];
    cq_mesh m;
    cq_shape s, room;
    cq_place place;
    cq_result r;
    void *memory;
    size_t size, k;
    memset(&s, 0, sizeof s);
    s.num_vertices = nondet_u32();
    s.num_faces = nondet_u32();
    ASSUME(s.num_vertices <= REAL_VERTICES && s.num_faces <= REAL_FACES);
    for (k = 0; k < 3 * REAL_FACES; k++) indices[k] = any_index();
    room = s;
    room.num_boundary_loops = VIRTUAL_VERTICES;
    room.num_boundary_edges = VIRTUAL_FACES;
    size = cq_mesh_bytes(&room);
    memory = malloc(size);
    ASSUME(memory != NULL);
    r = cq_mesh_build(&m, &s, indices, memory, size, &place);
    PROVE(r == CQ_OK || r == CQ_ERROR_MEMORY || (r <= CQ_ERROR_INDEX && r >= CQ_ERROR_UNUSED));
    if (r == CQ_OK) {
        if (m.num_faces == REAL_FACES) REACHED();
    }
}
