/* A mesh of any size, seen from a few of its halfedges: for proofs that operations keep the invariant (cq_mesh_check).
 *
 * The invariant is said of one halfedge, one vertex or two halfedges at a time. That the halfedges around a vertex are
 * one cycle is said through a ghost: place_of[h] counts from 0 to valence - 1 around the vertex, clockwise, from
 * wherever.
 * Nothing is assumed of all halfedges: a claim is about halfedges x and y of the verifier's choice, and assumes the
 * invariant where it needs it, of these and of those that the operation touches. README.md says why that is enough.
 *
 * Arrays have no end here; tests/proof/mesh.c has the claims about ranges. next_of, prev_of and face_of stand for
 * cq_next, cq_prev and a division by 3: all that is assumed of them is said of the real ones by claim_corners. */
#ifndef LOCAL_MESH_H
#define LOCAL_MESH_H

/* Assertions would walk around vertices of any valence; the claims assume what they check. */
#define CQ_ASSERT(condition) ((void)0)
#include "proof.h"

#define ENDLESS __CPROVER_constant_infinity_uint
#define LIMIT (CQ_NONE / 3) /* of vertices and faces */

static cq_mesh m;
static cq_index origin_of[ENDLESS], twin_of[ENDLESS], place_of[ENDLESS], out_of[ENDLESS], valence_of[ENDLESS];
static cq_index next_of[ENDLESS], prev_of[ENDLESS], face_of[ENDLESS];
static uint8_t mark_of[ENDLESS];

/* -- Corners ------------------------------------------------------------------------------------------------------- */

/* n comes behind h in its face. */
static int is_next(cq_index h, cq_index n) { return prev_of[n] == h && next_of[h] == n && face_of[n] == face_of[h]; }

/* The halfedges of a face, as numbers. */
static int is_face(cq_index f, cq_index h, cq_index i, cq_index j)
{
    return f < LIMIT && h == 3 * f && i == h + 1 && j == h + 2 && face_of[h] == f && is_next(h, i) && is_next(i, j) &&
           is_next(j, h);
}

cq_index stub_next(cq_index h)
{
    ASSUME(is_next(h, next_of[h]));
    return next_of[h];
}

cq_index stub_prev(cq_index h)
{
    ASSUME(is_next(prev_of[h], h));
    return prev_of[h];
}

static void know_face(cq_index f) { ASSUME(is_face(f, 3 * f, 3 * f + 1, 3 * f + 2)); }

/* -- The mesh ------------------------------------------------------------------------------------------------------ */

static void any_mesh(void)
{
    m.origin = origin_of;
    m.twin = twin_of;
    m.out = out_of;
    m.valence = valence_of;
    m.mark = mark_of;
    ASSUME(m.first_virtual < LIMIT && m.max_virtual < LIMIT - m.first_virtual);
    ASSUME(m.first_virtual_face < LIMIT && m.max_virtual_faces < LIMIT - m.first_virtual_face);
    ASSUME(cqi_counts_fit(&m));
}

static int is_virtual(cq_index v) { return cq_is_virtual(&m, v); }
static cq_index clockwise(cq_index h) { return cq_clockwise(&m, h); }
static cq_index target(cq_index h) { return cq_target(&m, h); }
static cq_index after(cq_index place, cq_index valence) { return place + 1 == valence ? 0 : (cq_index)(place + 1); }

/* Twins are two halfedges of one edge, each other's. */
static int edge_holds(cq_index h)
{
    cq_index t = twin_of[h];
    return t != h && twin_of[t] == h && target(t) == origin_of[h];
}

/* The halfedges around a vertex have its places one after the other. */
static void assume_place(cq_index h)
{
    cq_index valence = valence_of[origin_of[h]];
    ASSUME(place_of[h] < valence && place_of[clockwise(h)] == after(place_of[h], valence));
}

/* No two have the same place. */
static void assume_places(cq_index x, cq_index y)
{
    ASSUME(x == y || origin_of[x] != origin_of[y] || place_of[x] != place_of[y]);
}

/* No two have the same target, nor is more than one target virtual. */
static int edges_are_simple(cq_index x, cq_index y)
{
    return x == y || origin_of[x] != origin_of[y] ||
           (target(x) != target(y) && !(is_virtual(target(x)) && is_virtual(target(y))));
}

#endif
