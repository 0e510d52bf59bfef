/* A split keeps the whole invariant of the mesh, of any size; B takes at most STEPS spokes. */
#include "local.h"

static cq_index spoke[STEPS + 1];    /* from `first` clockwise to `last` */

/* A free slot of a list: the head, or the one behind it. */
static void assume_free_face(const cq_mesh *m, cq_index f, int is_virtual)
{
    if (f == CQ_NONE) return;
    if (is_virtual) ASSUME(f >= m->first_virtual_face && f - m->first_virtual_face < m->num_virtual_faces);
    else ASSUME(f < m->num_faces);
    ASSUME(m->origin[3 * f] == CQ_NONE);
}

static void assume_free_slots(const cq_mesh *m)
{
    cq_index v = m->free_vertex, f = m->free_face;
    if (v != CQ_NONE) ASSUME(v < m->num_vertices && m->out[v] == CQ_NONE);
    assume_free_face(m, m->free_virtual_face, 1);
    assume_free_face(m, f, 0);
    if (f == CQ_NONE) return;
    ASSUME(m->origin[3 * f + 1] != f);
    assume_free_face(m, m->origin[3 * f + 1], 0);
}

/* The spokes of A from first to last have ranks 0, 1, ... size - 1. */
static cq_index assume_spokes(const cq_mesh *m, cq_index first, cq_index last)
{
    cq_index size = rank_of[last], k;
    ASSUME(rank_of[first] == 0 && size <= STEPS);
    spoke[0] = first;
    for (k = 0; k < size; k++) {
        spoke[k + 1] = cq_clockwise(m, spoke[k]);
        assume_halfedge(m, spoke[k + 1]);
        assume_pair(m, spoke[k + 1], first);
        assume_pair(m, spoke[k + 1], last);
    }
    return size;
}

/* What is to be known about a halfedge before the split: its clauses, and those with what the split touches. */
static void assume_near(const cq_mesh *m, cq_index h, cq_index from_p, cq_index from_q, cq_index size)
{
    cq_index k;
    assume_halfedge(m, h);
    assume_pair(m, h, from_p);
    assume_pair(m, h, from_q);
    for (k = 0; k <= size; k++) assume_pair(m, h, spoke[k]);
}

/* Ranks after the split: of A -> B, B -> p and so on, and of the spokes of A and B. */
static cq_index new_rank(const cq_mesh *m, cq_index h, cq_index f, cq_index g, cq_index a, cq_index b, cq_index size)
{
    if (h == 3 * f) return (cq_index)(m->valence[m->origin[h]] - 1);      /* p -> A, behind p -> B */
    if (h == 3 * g + 1) return (cq_index)(m->valence[m->origin[h]] - 1);  /* q -> B, behind q -> A */
    if (h == 3 * f + 1) return 1;                                         /* A -> B, behind first */
    if (h == 3 * g) return 2;                                             /* A -> q */
    if (h == 3 * g + 2) return size;                                      /* B -> A, behind last */
    if (h == 3 * f + 2) return (cq_index)(size + 1);                      /* B -> p */
    if (m->origin[h] == b) return (cq_index)(rank_of[h] - 1);
    if (m->origin[h] == a && rank_of[h]) return (cq_index)(rank_of[h] - size + 2);
    return rank_of[h];
}

void claim_split(void)
{
    cq_mesh m = any_mesh(), before = m;
    cq_index first = any_index(), last = any_index(), x = any_index(), y = any_index(), v = any_index();
    cq_index a, b, f, g, from_p, from_q, size, after[4];
    (void)before;
    ASSUME(first < HALFEDGES && last < HALFEDGES && first != last && x < HALFEDGES && y < HALFEDGES && v < SLOTS);
    ASSUME(cqi_is_face(&m, face_of[first]) && cqi_is_face(&m, face_of[last]));
    ASSUME(m.origin[first] == m.origin[last]);
    assume_free_slots(&m);
    assume_halfedge(&m, first);
    assume_halfedge(&m, last);
    assume_pair(&m, first, last);
    a = m.origin[first];
    from_p = m.twin[first];
    from_q = m.twin[last];
    assume_halfedge(&m, from_p);
    assume_halfedge(&m, from_q);
    ASSUME(rank_of[from_p] == m.valence[m.origin[from_p]] - 1);
    ASSUME(rank_of[from_q] == m.valence[m.origin[from_q]] - 1);
    size = assume_spokes(&m, first, last);
    assume_near(&m, x, from_p, from_q, size);
    assume_near(&m, y, from_p, from_q, size);
    assume_pair(&m, x, y);
    assume_vertex(&m, v);
    assume_vertex(&m, a);
    assume_vertex(&m, m.origin[from_p]);
    assume_vertex(&m, m.origin[from_q]);
    b = cq_mesh_split(&m, first, last);
    if (b == CQ_NONE) return;
    f = face_of[m.twin[first]];
    g = face_of[m.twin[last]];
    after[0] = x;
    after[1] = y;
    ASSUME(cqi_is_face(&m, face_of[x]) && cqi_is_face(&m, face_of[y]));
    PROVE(m.twin[x] < HALFEDGES);
    after[2] = cq_clockwise(&m, x);
    {
        cq_index rx = new_rank(&m, x, f, g, a, b, size), ry = new_rank(&m, y, f, g, a, b, size);
        cq_index rc = new_rank(&m, after[2], f, g, a, b, size);
        rank_of[x] = rx;
        rank_of[y] = ry;
        rank_of[after[2]] = rc;
    }
    PROVE(cqi_counts_fit(&m));
    PROVE(halfedge_holds(&m, x));
    PROVE(face_holds(&m, face_of[x]));
    PROVE(pair_holds(&m, x, y));
    if (cqi_is_vertex(&m, v)) PROVE(vertex_holds(&m, v));
    REACHED();
}
