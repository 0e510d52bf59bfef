/* Proofs that a flip keeps the invariant of the mesh, for meshes of any size and vertices of any valence: see
 * local_mesh.h. Names are those of the picture at cqi_flip. */
#include "local_mesh.h"

#ifndef AROUND
#define AROUND 3 /* valence of a vertex whose fan is walked around */
#endif
#ifndef WHERE
#define WHERE 0 /* the vertex whose places are looked at: 0 a, 1 b, 2 x, 3 y, 4 any other one */
#endif

static cq_index h, g, hn, hp, gn, gp, a_to_x, x_to_b, b_to_y, y_to_a; /* that a flip reads or writes */
static cq_index a, b, x, y;
static uint8_t watched_of[ENDLESS];

static int is_of_flip(cq_index k) { return k == h || k == hn || k == hp || k == g || k == gn || k == gp; }

/* What cqi_can_flip says, but for the walk around a fan. */
static int ends_allow_it(void)
{
    return !is_virtual(a) && !is_virtual(b) && !is_virtual(x) && !is_virtual(y) && valence_of[a] > 3 &&
           valence_of[b] > 3 && x != y;
}

/* k joins neither x to y nor y to x: of the halfedges that are asked for. */
static void assume_not_joined(cq_index k)
{
    ASSUME(origin_of[k] != x || target(k) != y);
    ASSUME(origin_of[k] != y || target(k) != x);
}

int stub_joined(const cq_mesh *of, cq_index v, cq_index w)
{
    (void)v, (void)w;
    PROVE(of == &m);
    return 0; /* as assume_not_joined says */
}

static void know_halfedge(cq_index k)
{
    ASSUME(edge_holds(k) && target(k) != origin_of[k]); /* a loop would be two edges with the same ends */
    assume_place(k);
    assume_not_joined(k);
}

/* The names of any halfedge of a mesh. */
static void any_halfedge(void)
{
    any_mesh();
    know_face(face_of[h]);
    ASSUME(h - 3 * face_of[h] < 3);
    g = twin_of[h];
    know_face(face_of[g]);
    ASSUME(g - 3 * face_of[g] < 3);
    hn = cq_next(h), hp = cq_prev(h), gn = cq_next(g), gp = cq_prev(g);
    a_to_x = twin_of[hp], x_to_b = twin_of[hn], b_to_y = twin_of[gp], y_to_a = twin_of[gn];
    a = origin_of[h], b = origin_of[g], x = origin_of[hp], y = origin_of[gp];
}

/* What is known of any edge. */
static void any_edge(void)
{
    any_halfedge();
    ASSUME(valence_of[x] >= 2 && valence_of[y] >= 2);
    know_halfedge(h), know_halfedge(hn), know_halfedge(hp);
    know_halfedge(g), know_halfedge(gn), know_halfedge(gp);
    know_halfedge(a_to_x), know_halfedge(x_to_b), know_halfedge(b_to_y), know_halfedge(y_to_a);
}

/* The four vertices are different ones, and so are the halfedges. */
static int names_differ(void)
{
    return a != b && a != x && a != y && b != x && b != y && x != y && face_of[h] != face_of[g] && !is_of_flip(a_to_x) &&
           !is_of_flip(x_to_b) && !is_of_flip(b_to_y) && !is_of_flip(y_to_a);
}

/* Of any edge that cqi_can_flip allows. */
void claim_flip_names(void)
{
    any_edge();
    if (!cqi_can_flip(&m, h)) return;
    PROVE(names_differ());
    REACHED();
}

/* A flip of any edge that allows it. */
static void any_flip(void)
{
    any_edge();
    ASSUME(ends_allow_it());
    m.watched = nondet_int() ? watched_of : NULL;
    ASSUME(m.watched_shift <= 31);
    ASSUME(names_differ()); /* see claim_flip_names */
    ASSUME(place_of[h] == 0 && place_of[g] == 0 && place_of[x_to_b] == 0 && place_of[y_to_a] == 0); /* count from there */
}

/* Any halfedge k of the mesh, against those that the flip touches. */
static void assume_any(cq_index k)
{
    know_halfedge(k);
    know_halfedge(twin_of[k]);
    assume_places(k, h), assume_places(k, hn), assume_places(k, hp);
    assume_places(k, g), assume_places(k, gn), assume_places(k, gp);
    assume_places(k, a_to_x), assume_places(k, x_to_b), assume_places(k, b_to_y), assume_places(k, y_to_a);
}

static void assume_simple(cq_index k)
{
    ASSUME(edges_are_simple(k, h) && edges_are_simple(k, hn) && edges_are_simple(k, hp));
    ASSUME(edges_are_simple(k, g) && edges_are_simple(k, gn) && edges_are_simple(k, gp));
    ASSUME(edges_are_simple(k, a_to_x) && edges_are_simple(k, x_to_b));
    ASSUME(edges_are_simple(k, b_to_y) && edges_are_simple(k, y_to_a));
}

/* Twins stay pairs of one edge's halfedges, and no corner gets virtual or real. */
void claim_flip_edges(void)
{
    cq_index k = any_index();
    int was_virtual;
    any_flip();
    assume_any(k);
    was_virtual = is_virtual(origin_of[k]);
    cqi_flip(&m, h);
    PROVE(edge_holds(k) && target(k) != origin_of[k]);
    PROVE(is_virtual(origin_of[k]) == was_virtual);
    REACHED();
}

/* a and b lose the place of the edge, x and y get one behind the halfedge to b and to a. */
static cq_index place_after_flip(cq_index k)
{
    const cq_index v = origin_of[k];
    if (k == hp || k == gp) return 0;
    if (k == g || k == h) return 1;
    if (k == hn || k == gn) return 2;
    if (v == a || v == b) return (cq_index)(place_of[k] - 1);
    if ((v == x || v == y) && place_of[k]) return (cq_index)(place_of[k] + 1);
    return place_of[k];
}

static void assume_valences_fit(void)
{
    ASSUME(valence_of[x] < CQ_NONE && valence_of[y] < CQ_NONE);
}

/* After the flip, does k start at the vertex that the claim is about? */
static int is_around(cq_index k)
{
    const cq_index v = origin_of[k];
    return WHERE == 0 ? v == a : WHERE == 1 ? v == b : WHERE == 2 ? v == x : WHERE == 3 ? v == y
                                                     : v != a && v != b && v != x && v != y;
}

void claim_flip_places(void)
{
    cq_index k = any_index(), valence;
    any_flip();
    assume_any(k);
    assume_valences_fit();
    cqi_flip(&m, h);
    valence = valence_of[origin_of[k]];
    ASSUME(is_around(k));
    PROVE(place_after_flip(k) < valence);
    PROVE(place_after_flip(clockwise(k)) == after(place_after_flip(k), valence));
    REACHED();
}

void claim_flip_fans(void)
{
    cq_index j = any_index(), k = any_index();
    any_flip();
    assume_any(j);
    assume_any(k);
    assume_places(j, k);
    assume_valences_fit();
    cqi_flip(&m, h);
    PROVE(j == k || origin_of[j] != origin_of[k] || place_after_flip(j) != place_after_flip(k));
    REACHED();
}

void claim_flip_simple(void)
{
    cq_index j = any_index(), k = any_index();
    any_flip();
    assume_any(j);
    assume_any(k);
    assume_simple(j);
    assume_simple(k);
    ASSUME(edges_are_simple(j, k));
    cqi_flip(&m, h);
    PROVE(edges_are_simple(j, k));
    REACHED();
}

void claim_flip_vertices(void)
{
    cq_index v = any_index(), least;
    any_flip();
    ASSUME(origin_of[out_of[v]] == v);
    assume_any(out_of[v]);
    least = is_virtual(v) ? 3 : 2;
    ASSUME(valence_of[v] >= least);
    assume_valences_fit();
    cqi_flip(&m, h);
    PROVE(origin_of[out_of[v]] == v && valence_of[v] >= least);
    REACHED();
}

/* No slot is taken or freed, and who watches is told of both faces. */
void claim_flip_slots(void)
{
    cq_index v = any_index(), k = any_index(), link, valence;
    int v_free, k_free;
    cq_mesh before;
    any_flip();
    know_face(k);
    before = m;
    v_free = out_of[v] == CQ_NONE;
    k_free = origin_of[3 * k] == CQ_NONE;
    valence = valence_of[v];
    link = origin_of[3 * k + 1];
    ASSUME(hn != CQ_NONE && hp != CQ_NONE && gn != CQ_NONE && gp != CQ_NONE);
    ASSUME(a != CQ_NONE && b != CQ_NONE && x != CQ_NONE && y != CQ_NONE);
    ASSUME(!v_free || (v != a && v != b && v != x && v != y)); /* the slots of the flip are used */
    ASSUME(!k_free || (k != face_of[h] && k != face_of[g]));
    cqi_flip(&m, h);
    PROVE((out_of[v] == CQ_NONE) == v_free && (origin_of[3 * k] == CQ_NONE) == k_free);
    if (v_free) PROVE(valence_of[v] == valence);
    if (k_free) PROVE(origin_of[3 * k + 1] == link);
    PROVE(m.num_vertices == before.num_vertices && m.num_faces == before.num_faces);
    PROVE(m.num_virtual == before.num_virtual && m.num_virtual_faces == before.num_virtual_faces);
    PROVE(m.free_vertex == before.free_vertex && m.free_face == before.free_face);
    PROVE(m.free_virtual_face == before.free_virtual_face);
    PROVE(!m.watched || (watched_of[h / 3 >> m.watched_shift] && watched_of[g / 3 >> m.watched_shift]));
    REACHED();
}

/* -- Which edges may be flipped ------------------------------------------------------------------------------------ */

/* What it says yes to can be flipped: the walk around the vertex with fewer neighbours finds any halfedge k. */
void claim_can_flip(void)
{
    cq_index k = any_index(), around, s, i;
    any_halfedge();
    around = valence_of[x] < valence_of[y] ? x : y;
    s = out_of[around];
    ASSUME(valence_of[around] == AROUND && origin_of[s] == around && place_of[s] == 0);
    ASSUME(edge_holds(k) && edge_holds(twin_of[k]));
    assume_place(k);
    assume_place(twin_of[k]);
    for (i = 0; i <= AROUND; i++, s = clockwise(s)) {
        ASSUME(edge_holds(s));
        assume_place(s);
        assume_places(s, out_of[around]);
        assume_places(s, k);
        assume_places(s, twin_of[k]);
    }
    if (!cqi_can_flip(&m, h)) return;
    PROVE(ends_allow_it());
    PROVE((origin_of[k] != x || target(k) != y) && (origin_of[k] != y || target(k) != x));
    REACHED();
}

/* -- Who flips ----------------------------------------------------------------------------------------------------- */

static cq_decoder decoder;
static int may_flip, flips;

int stub_can_flip(const cq_mesh *of, cq_index of_edge)
{
    PROVE(of == &decoder.mesh && of_edge == h);
    return may_flip;
}

void stub_flip(cq_mesh *of, cq_index of_edge)
{
    PROVE(of == &decoder.mesh && of_edge == h && may_flip);
    flips++;
}

/* A decoder flips an edge only if it may be flipped, and else gives up the stream. */
void claim_flip_checked(void)
{
    cq_result result;
    h = any_index();
    may_flip = nondet_int() != 0;
    result = cqi_flip_checked(&decoder, h);
    PROVE((result == CQ_OK) == may_flip && flips == may_flip);
    REACHED();
}
