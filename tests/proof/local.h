/* The whole invariant of the mesh, halfedge by halfedge, for meshes of any size.
 *
 * Each clause is about one halfedge, one vertex, or two halfedges. A claim proves all clauses after an operation for a
 * halfedge, a vertex and a pair that are the verifier's choice, so for all of them. Before the operation it assumes the
 * clauses only where the proof needs them: at those, and around the vertices that the operation walks around. To assume
 * an invariant at a few places is to assume less than the invariant. So nothing bounds the mesh but the width of its
 * indices; what is bounded is the valence that the operation's loop walks over.
 *
 * That the halfedges of a vertex are one cycle of its valence is said with ranks: its halfedges have different ranks
 * below the valence, and clockwise is the next rank, from the last one to 0. If that holds, they are one cycle; and a
 * cycle has such ranks, which may begin at any of its halfedges. */
#ifndef LOCAL_H
#define LOCAL_H

#include "proof.h"

enum { HALFEDGES = 3 * SLOTS, MAX_SLOTS = 32 };

/* cq_next, cq_prev and the face of a halfedge as tables, which are easier to solve than divisions. claim_tables says
 * that they are the same; the driver then puts stub_next and stub_prev in the place of cq_next and cq_prev. */
#define FACE(f) f, f, f
#define NEXT(f) 3 * f + 1, 3 * f + 2, 3 * f
#define PREV(f) 3 * f + 2, 3 * f, 3 * f + 1
#define EIGHT(x, f) x((f)), x((f + 1)), x((f + 2)), x((f + 3)), x((f + 4)), x((f + 5)), x((f + 6)), x((f + 7))
#define ALL(x) EIGHT(x, 0), EIGHT(x, 8), EIGHT(x, 16), EIGHT(x, 24)
static const uint8_t face_of[3 * MAX_SLOTS] = { ALL(FACE) };
static const uint8_t next_of[3 * MAX_SLOTS] = { ALL(NEXT) };
static const uint8_t prev_of[3 * MAX_SLOTS] = { ALL(PREV) };

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

/* Defined nowhere: of any contents. */
extern cq_index origin_of[HALFEDGES], twin_of[HALFEDGES], rank_of[HALFEDGES], out_of[SLOTS], valence_of[SLOTS];
extern uint8_t mark_of[SLOTS];

/* Any contents of the arrays; counts within capacities, and those within what there is. Free slots only as heads say. */
static cq_mesh any_mesh(void)
{
    cq_mesh m;
    m.origin = origin_of;
    m.twin = twin_of;
    m.out = out_of;
    m.valence = valence_of;
    m.mark = mark_of;
    m.num_vertices = any_index();
    m.num_faces = any_index();
    m.num_virtual = any_index();
    m.num_virtual_faces = any_index();
    m.first_virtual = any_index();
    m.first_virtual_face = any_index();
    m.max_virtual = any_index();
    m.max_virtual_faces = any_index();
    m.free_vertex = any_index();
    m.free_face = any_index();
    m.free_virtual_face = any_index();
    ASSUME(cqi_counts_fit(&m));
    ASSUME(m.first_virtual <= SLOTS && m.max_virtual <= SLOTS - m.first_virtual);
    ASSUME(m.first_virtual_face <= SLOTS && m.max_virtual_faces <= SLOTS - m.first_virtual_face);
    return m;
}

/* -- Clauses -- */

/* Halfedge h of a face in use. */
static int halfedge_holds(const cq_mesh *m, cq_index h)
{
    cq_index f = face_of[h], t = m->twin[h], v = m->origin[h], c;
    if (t >= HALFEDGES || t == h || !cqi_is_face(m, face_of[t]) || m->twin[t] != h) return 0;
    if (v >= SLOTS || !cqi_is_vertex(m, v)) return 0;
    c = cq_next(t);
    return m->origin[c] == v && rank_of[h] < m->valence[v] &&
           rank_of[c] == (rank_of[h] + 1 == m->valence[v] ? 0 : rank_of[h] + 1);
}

/* A face in use has a virtual corner if it is a virtual face, and never two. */
static int face_holds(const cq_mesh *m, cq_index f)
{
    return cqi_virtual_corners(m, f) == (f >= m->first_virtual_face);
}

/* A vertex in use. */
static int vertex_holds(const cq_mesh *m, cq_index v)
{
    return m->out[v] < HALFEDGES && cqi_is_face(m, face_of[m->out[v]]) && m->origin[m->out[v]] == v &&
           m->valence[v] >= (cq_is_virtual(m, v) ? 3 : 2);
}

/* Two halfedges of faces in use: from one vertex they have different ranks and targets, at most one of which is
 * virtual; and no edge is between virtual vertices. */
static int pair_holds(const cq_mesh *m, cq_index g, cq_index h)
{
    if (cq_is_virtual(m, m->origin[h]) && cq_is_virtual(m, cq_target(m, h))) return 0;
    if (g == h || m->origin[g] != m->origin[h]) return 1;
    return rank_of[g] != rank_of[h] && cq_target(m, g) != cq_target(m, h) &&
           !(cq_is_virtual(m, cq_target(m, g)) && cq_is_virtual(m, cq_target(m, h)));
}

/* -- The same as assumptions -- */

static void assume_halfedge(const cq_mesh *m, cq_index h)
{
    ASSUME(h < HALFEDGES);
    if (cqi_is_face(m, face_of[h])) ASSUME(halfedge_holds(m, h) && face_holds(m, face_of[h]));
}

static void assume_pair(const cq_mesh *m, cq_index g, cq_index h)
{
    if (cqi_is_face(m, face_of[g]) && cqi_is_face(m, face_of[h])) ASSUME(pair_holds(m, g, h));
}

static void assume_vertex(const cq_mesh *m, cq_index v)
{
    ASSUME(v < SLOTS);
    if (cqi_is_vertex(m, v)) ASSUME(vertex_holds(m, v));
}

#endif
