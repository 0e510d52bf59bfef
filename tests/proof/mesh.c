/* Proofs about the mesh: meshes of bounded size, but any contents.
 *
 * A mesh has room for REAL_VERTICES + VIRTUAL_VERTICES and REAL_FACES + VIRTUAL_FACES; the contents of its arrays are
 * the verifier's choice, within what a claim assumes. Each array is a block of its own. */

/* These claims hold without the preconditions that assertions check. */
#define CQ_ASSERT(condition) ((void)0)
#include "proof.h"

enum {
    VERTICES = REAL_VERTICES + VIRTUAL_VERTICES,
    FACES = REAL_FACES + VIRTUAL_FACES,
    HALFEDGES = 3 * FACES
};
#include "tables.h"

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
