/* Proofs that splits and collapses keep the invariant of the mesh, for meshes of any size: see local_mesh.h. */
#include "local_mesh.h"

#ifndef STEPS
#define STEPS 1 /* neighbours that B gets or has, beside A, p and q */
#endif
#ifndef AROUND_A
#define AROUND_A 3 /* valence of A, where a fan is walked around */
#endif
#ifndef VIRTUAL
#define VIRTUAL 0 /* which of p and q is a virtual vertex: 0 none, 1 p, 2 q */
#endif

/* With the tables filled from the real functions at three halfedges in a row. */
void claim_corners(void)
{
    cq_index f = any_index(), h[3], k;
    ASSUME(f < LIMIT);
    for (k = 0; k < 3; k++) {
        h[k] = (cq_index)(3 * f + k);
        next_of[h[k]] = cq_next(h[k]);
        prev_of[h[k]] = cq_prev(h[k]);
        face_of[h[k]] = h[k] / 3;
    }
    PROVE(is_face(f, h[0], h[1], h[2]));
    REACHED();
}

/* -- Splits -------------------------------------------------------------------------------------------------------- */

static cq_index a, b, p, q, first, last, from_p, from_q, f, g, moved;
static cq_index valence_a, valence_p, valence_q;

/* New slots, as claim_split_slots says. */
static int faces_taken;

cq_index stub_new_face(cq_mesh *of, int virtual_one)
{
    PROVE(of == &m && virtual_one == is_virtual(faces_taken ? q : p));
    return faces_taken++ ? g : f;
}

cq_index stub_new_vertex(cq_mesh *of)
{
    PROVE(of == &m);
    return b;
}

int stub_has_room(const cq_mesh *of, cq_index v, cq_index w)
{
    PROVE(of == &m && v == p && w == q);
    return 1;
}

static int is_of(cq_index face, cq_index h) { return h == 3 * face || h == 3 * face + 1 || h == 3 * face + 2; }
static int is_new(cq_index h) { return is_of(f, h) || is_of(g, h); }

/* h was used before the split: so were its twin and its origin. */
static void assume_used(cq_index h)
{
    ASSUME(!is_new(h) && !is_new(twin_of[h]) && origin_of[h] != b && edge_holds(h));
}

/* A split of any vertex, after up to STEPS spokes. */
static void any_split(void)
{
    any_mesh();
    know_face(f);
    know_face(g);
    ASSUME(f != g && first != last && origin_of[last] == origin_of[first]);
    assume_used(first);
    assume_used(last);
    a = origin_of[first];
    from_p = twin_of[first];
    from_q = twin_of[last];
    assume_used(from_p);
    assume_used(from_q);
    p = origin_of[from_p];
    q = origin_of[from_q];
    ASSUME(edges_are_simple(first, last) && edges_are_simple(first, from_p) && edges_are_simple(last, from_q));
    ASSUME(p != a && q != a); /* a loop would be two edges with the same ends */
    ASSUME(!is_virtual(a) && !is_virtual(b));
    valence_a = valence_of[a];
    valence_p = valence_of[p];
    valence_q = valence_of[q];
    assume_place(first);
    assume_place(last);
    assume_place(from_p);
    assume_place(from_q);
    assume_places(first, last);
    ASSUME(place_of[first] == 0 && place_of[from_p] == 0 && place_of[from_q] == 0); /* that is where to count from */
    moved = place_of[last];
    ASSUME(moved == STEPS);
}

/* The spokes that move are used, and x is none of them unless it has its place. */
static void assume_moved(cq_index x, cq_index y)
{
    cq_index s = first, k;
    for (k = 1; k <= STEPS; k++) {
        s = clockwise(s);
        ASSUME(origin_of[3 * face_of[s]] != CQ_NONE);
        assume_used(s);
        assume_place(s);
        assume_places(s, last);
        assume_places(s, x);
        assume_places(s, y);
    }
}

static void split(void)
{
    faces_taken = 0;
    PROVE(cq_mesh_split(&m, first, last) == b);
}

/* Any halfedge of the mesh after the split: new, or used before. */
static void assume_any(cq_index x)
{
    if (is_new(x)) return;
    assume_used(x);
    assume_used(twin_of[x]);
    assume_place(x);
    assume_places(x, first);
    assume_places(x, from_p);
    assume_places(x, from_q);
}

void claim_split_edges(void)
{
    cq_index x = any_index();
    int was_virtual;
    any_split();
    assume_moved(x, x);
    assume_any(x);
    was_virtual = is_virtual(origin_of[x]);
    split();
    PROVE(edge_holds(x));
    PROVE(is_new(x) || is_virtual(origin_of[x]) == was_virtual);
    REACHED();
}

/* A starts at `first`, B behind it; p and q get a place behind the halfedge to A and B. */
static cq_index place_after_split(cq_index h)
{
    const cq_index v = origin_of[h];
    if (h == 3 * f || h == 3 * f + 1 || h == 3 * g + 1) return 1;
    if (h == 3 * g) return 2;
    if (h == 3 * g + 2) return moved;
    if (h == 3 * f + 2) return (cq_index)(moved + 1);
    if (v == b) return (cq_index)(place_of[h] - 1);
    if (v == a && place_of[h]) return (cq_index)(place_of[h] - moved + 2);
    if ((v == p || v == q) && place_of[h]) return (cq_index)(place_of[h] + 1);
    return place_of[h];
}

void claim_split_places(void)
{
    cq_index x = any_index(), valence;
    any_split();
    assume_moved(x, x);
    assume_any(x);
    ASSUME(valence_a < CQ_NONE && valence_p < CQ_NONE && valence_q < CQ_NONE);
    split();
    valence = valence_of[origin_of[x]];
    PROVE(place_after_split(x) < valence);
    PROVE(place_after_split(clockwise(x)) == after(place_after_split(x), valence));
    REACHED();
}

void claim_split_fans(void)
{
    cq_index x = any_index(), y = any_index();
    any_split();
    assume_moved(x, y);
    assume_any(x);
    assume_any(y);
    assume_places(x, y);
    ASSUME(valence_a < CQ_NONE && valence_p < CQ_NONE && valence_q < CQ_NONE);
    split();
    PROVE(x == y || origin_of[x] != origin_of[y] || place_after_split(x) != place_after_split(y));
    REACHED();
}

static void assume_simple(cq_index x)
{
    if (is_new(x)) return;
    ASSUME(target(x) != origin_of[x]);
    ASSUME(edges_are_simple(x, first) && edges_are_simple(x, last));
    ASSUME(edges_are_simple(x, from_p) && edges_are_simple(x, from_q));
    assume_place(twin_of[x]);
}

void claim_split_simple(void)
{
    cq_index x = any_index(), y = any_index();
    any_split();
    assume_moved(x, y);
    assume_any(x);
    assume_any(y);
    assume_simple(x);
    assume_simple(y);
    ASSUME(is_new(x) || is_new(y) || edges_are_simple(x, y));
    split();
    PROVE(edges_are_simple(x, y));
    REACHED();
}

void claim_split_vertices(void)
{
    cq_index v = any_index(), least;
    any_split();
    ASSUME(v == b || origin_of[out_of[v]] == v);
    assume_moved(out_of[v], out_of[v]);
    if (v != b) assume_used(out_of[v]);
    if (v != b) assume_any(out_of[v]);
    least = is_virtual(v) ? 3 : 2;
    ASSUME(v == b || valence_of[v] >= least);
    ASSUME(valence_a < CQ_NONE && valence_p < CQ_NONE && valence_q < CQ_NONE);
    split();
    PROVE(origin_of[out_of[v]] == v && valence_of[v] >= least);
    REACHED();
}

/* -- Slots of a split ---------------------------------------------------------------------------------------------- */

static int is_used_vertex(cq_index v) { return cqi_is_vertex(&m, v); }
static int is_used_face(cq_index k) { return cqi_is_face(&m, k); }
static int is_free_vertex(cq_index v) { return v < m.num_vertices && !is_used_vertex(v); }

static int is_free_face(cq_index k, int virtual_one)
{
    const cq_index start = virtual_one ? m.first_virtual_face : 0;
    return k >= start && k - start < (virtual_one ? m.num_virtual_faces : m.num_faces) && !is_used_face(k);
}

/* The first free slot is one, or there is none. */
static int heads_hold(void)
{
    return (m.free_vertex == CQ_NONE || is_free_vertex(m.free_vertex)) &&
           (m.free_face == CQ_NONE || is_free_face(m.free_face, 0)) &&
           (m.free_virtual_face == CQ_NONE || is_free_face(m.free_virtual_face, 1));
}

/* So is the slot behind it, which is another one: it was freed before. */
static void assume_link(cq_index k, int virtual_one)
{
    const cq_index link = origin_of[3 * k + 1];
    if (k != CQ_NONE) ASSUME(link == CQ_NONE || (link != k && is_free_face(link, virtual_one)));
}

static void assume_links(void)
{
    const cq_index v = m.free_vertex;
    cq_index link;
    ASSUME(heads_hold());
    if (v != CQ_NONE) ASSUME(valence_of[v] == CQ_NONE || (valence_of[v] != v && is_free_vertex(valence_of[v])));
    assume_link(m.free_virtual_face, 1);
    assume_link(m.free_face, 0);
    if (m.free_face == CQ_NONE) return;
    link = origin_of[3 * m.free_face + 1];
    assume_link(link, 0);
    ASSUME(link == CQ_NONE || origin_of[3 * link + 1] != m.free_face);
}

/* A vertex for which there is room is a free one, or behind all others. */
void claim_new_vertex(void)
{
    cq_index before;
    any_mesh();
    assume_links();
    before = m.num_vertices;
    ASSUME(cqi_has_room(&m, any_index(), any_index()));
    b = m.free_vertex == CQ_NONE || is_free_vertex(m.free_vertex) ? cqi_new_vertex(&m) : CQ_NONE;
    PROVE(!is_virtual(b) && (b == before || is_free_vertex(b)) && b < m.num_vertices && cqi_counts_fit(&m));
    PROVE(m.free_vertex == CQ_NONE || (m.free_vertex != b && is_free_vertex(m.free_vertex)));
    REACHED();
}

/* Faces that a split may take. */
static void know_slots(void)
{
    if (m.free_face != CQ_NONE) know_face(m.free_face);
    if (m.free_face != CQ_NONE && origin_of[3 * m.free_face + 1] != CQ_NONE) know_face(origin_of[3 * m.free_face + 1]);
    if (m.free_virtual_face != CQ_NONE) know_face(m.free_virtual_face);
    if (m.num_faces < m.first_virtual_face) know_face(m.num_faces);
    if (m.num_faces + 1 < m.first_virtual_face) know_face((cq_index)(m.num_faces + 1));
    if (m.num_virtual_faces < m.max_virtual_faces) know_face((cq_index)(m.first_virtual_face + m.num_virtual_faces));
}

/* So are two faces, different ones, virtual if they ought to be. */
void claim_new_faces(void)
{
    cq_index faces, virtual_faces;
    any_mesh();
    assume_links();
    faces = m.num_faces;
    virtual_faces = m.num_virtual_faces;
    ASSUME(is_virtual(p) == (VIRTUAL == 1) && is_virtual(q) == (VIRTUAL == 2));
    know_slots();
    ASSUME(cqi_has_room(&m, p, q));
    f = cqi_new_face(&m, is_virtual(p));
    g = cqi_new_face(&m, is_virtual(q));
    PROVE(f != g && (f >= m.first_virtual_face) == is_virtual(p) && (g >= m.first_virtual_face) == is_virtual(q));
    PROVE(cqi_counts_fit(&m));
    PROVE(is_free_face(f, is_virtual(p)) || f - (is_virtual(p) ? m.first_virtual_face + virtual_faces : faces) < 2);
    PROVE(is_free_face(g, is_virtual(q)) || g - (is_virtual(q) ? m.first_virtual_face + virtual_faces : faces) < 2);
    PROVE(m.free_face == CQ_NONE || (m.free_face != f && m.free_face != g && is_free_face(m.free_face, 0)));
    PROVE(m.free_virtual_face == CQ_NONE ||
          (m.free_virtual_face != f && m.free_virtual_face != g && is_free_face(m.free_virtual_face, 1)));
    REACHED();
}

/* A split puts vertices and faces into these slots, and leaves all others as they are. */
void claim_split_slots(void)
{
    cq_index v = any_index(), k = any_index(), link, valence;
    int v_free, k_free;
    any_split();
    assume_moved(k, k);
    know_face(k);
    v_free = out_of[v] == CQ_NONE;
    k_free = origin_of[3 * k] == CQ_NONE;
    ASSUME((!v_free || (v != a && v != p && v != q)) && a != CQ_NONE && p != CQ_NONE && b != CQ_NONE);
    ASSUME(first != CQ_NONE && last != CQ_NONE);
    valence = valence_of[v];
    link = origin_of[3 * k + 1];
    split();
    PROVE((out_of[v] == CQ_NONE) == (v_free && v != b) &&
          (origin_of[3 * k] == CQ_NONE) == (k_free && k != f && k != g));
    if (v_free && v != b) PROVE(valence_of[v] == valence);
    if (k_free && k != f && k != g) PROVE(origin_of[3 * k + 1] == link);
    REACHED();
}

/* -- Collapses ----------------------------------------------------------------------------------------------------- */

static cq_index h, twin_h, to_p, to_q, valence_b;

/* Frees g and f, as claim_collapse_slots says. */
static int faces_freed;

void stub_free_face(cq_mesh *of, cq_index face)
{
    const cq_index k = faces_freed++ ? f : g;
    PROVE(of == &m);
#ifdef WHICH_FACES
    PROVE(is_of(face, k == g ? twin_h : h));
#endif
    (void)face;
    origin_of[3 * k] = CQ_NONE;
    origin_of[3 * k + 1] = any_index();
}

/* Where a halfedge started before. */
static cq_index home_of[ENDLESS];
static void assume_home(cq_index x) { ASSUME(home_of[x] == origin_of[x]); }

/* Two halfedges of A and of B have different targets, but for p and q; only one of them is virtual. */
static void assume_link_condition(cq_index x, cq_index y)
{
    if (origin_of[x] == b && origin_of[y] == a) {
        ASSUME(target(x) != target(y) || target(x) == p || target(x) == q);
        ASSUME(!is_virtual(target(x)) || !is_virtual(target(y)) || is_virtual(p) || is_virtual(q));
    }
}

static void assume_edge(cq_index x) { ASSUME(edge_holds(x)); }

/* A collapse of any edge; B has up to STEPS + 1 neighbours. */
static void any_collapse(void)
{
    any_mesh();
    twin_h = twin_of[h];
    faces_freed = 0;
    ASSUME(f != g && is_of(f, h) && is_of(g, twin_h));
    know_face(f);
    know_face(g);
    assume_edge(h);
    assume_edge(twin_h);
    a = origin_of[h];
    b = origin_of[twin_h];
    p = origin_of[cq_prev(h)];
    q = origin_of[cq_prev(twin_h)];
    to_p = twin_of[cq_prev(h)];
    to_q = twin_of[cq_prev(twin_h)];
    from_p = twin_of[cq_next(h)];
    from_q = twin_of[cq_next(twin_h)];
    assume_edge(cq_next(h));
    assume_edge(cq_prev(h));
    assume_edge(cq_next(twin_h));
    assume_edge(cq_prev(twin_h));
    assume_edge(to_p);
    assume_edge(to_q);
    assume_edge(from_p);
    assume_edge(from_q);
    ASSUME(!is_virtual(a) && !is_virtual(b) && p != q && a != b && p != a && p != b && q != a && q != b);
    valence_a = valence_of[a];
    valence_b = valence_of[b];
    valence_p = valence_of[p];
    valence_q = valence_of[q];
    ASSUME(valence_p >= 4 && valence_q >= 4 && valence_b == STEPS + 2);
    ASSUME(place_of[h] == 0 && place_of[twin_h] == 0 && place_of[from_p] == 0 && place_of[from_q] == 0);
    assume_place(h);
    assume_place(twin_h);
    assume_place(from_p);
    assume_place(from_q);
    assume_place(to_p);
    assume_place(to_q);
    assume_place(cq_next(h));
    assume_place(cq_next(twin_h));
    assume_place(cq_prev(h));
    assume_place(cq_prev(twin_h));
    assume_places(to_p, cq_next(twin_h));
    assume_places(to_q, cq_next(h));
}

/* B's spokes, and x and y may be some of them. */
static void assume_spokes(cq_index x, cq_index y)
{
    cq_index s = twin_h, k;
    for (k = 0; k < STEPS + 2; k++) {
        s = clockwise(s);
        ASSUME(origin_of[3 * face_of[s]] != CQ_NONE);
        assume_edge(s);
        assume_place(s);
        assume_places(s, twin_h);
        assume_places(s, x);
        assume_places(s, y);
    }
}

/* Any halfedge that is left. */
static void assume_left(cq_index x)
{
    ASSUME(!is_new(x));
    assume_edge(x);
    assume_edge(twin_of[x]);
    assume_place(x);
    assume_places(x, h);
    assume_places(x, twin_h);
    assume_places(x, from_p);
    assume_places(x, from_q);
    assume_places(x, cq_next(h));
    assume_places(x, cq_next(twin_h));
    assume_places(x, cq_prev(h));
    assume_places(x, cq_prev(twin_h));
    assume_places(x, to_p);
    assume_places(x, to_q);
}

void claim_collapse_edges(void)
{
    cq_index x = any_index(), start, end;
    int was_virtual;
    any_collapse();
    assume_spokes(x, x);
    assume_left(x);
    was_virtual = is_virtual(origin_of[x]);
    cq_mesh_collapse(&m, h, &start, &end);
    PROVE(edge_holds(x) && !is_new(twin_of[x]));
    PROVE(origin_of[x] != b && is_virtual(origin_of[x]) == was_virtual);
    PROVE(start == to_p && end == to_q);
    REACHED();
}

/* A has B's spokes first; p and q lose the place behind the halfedge to B and A. */
static cq_index place_after_collapse(cq_index x)
{
    const cq_index v = home_of[x];
    if (v == b) return (cq_index)(place_of[x] - 2);
    if (v == a) return (cq_index)(place_of[x] - 2 + (valence_b - 2));
    if ((v == p || v == q) && place_of[x]) return (cq_index)(place_of[x] - 1);
    return place_of[x];
}

static void assume_homes(cq_index x)
{
    assume_home(x);
    assume_home(clockwise(x));
    assume_home(clockwise(cq_next(h)));
    assume_home(clockwise(cq_next(twin_h)));
    assume_home(cq_next(to_p));
    assume_home(cq_next(to_q));
}

void claim_collapse_places(void)
{
    cq_index x = any_index(), valence, start, end;
    any_collapse();
    assume_spokes(x, x);
    assume_left(x);
    assume_homes(x);
    ASSUME(valence_a < CQ_NONE - valence_b);
    cq_mesh_collapse(&m, h, &start, &end);
    valence = valence_of[origin_of[x]];
    PROVE(place_after_collapse(x) < valence);
    PROVE(place_after_collapse(clockwise(x)) == after(place_after_collapse(x), valence));
    REACHED();
}

void claim_collapse_fans(void)
{
    cq_index x = any_index(), y = any_index(), start, end;
    any_collapse();
    assume_spokes(x, y);
    assume_left(x);
    assume_left(y);
    assume_places(x, y);
    assume_home(x);
    assume_home(y);
    ASSUME(valence_a < CQ_NONE - valence_b);
    cq_mesh_collapse(&m, h, &start, &end);
    PROVE(x == y || origin_of[x] != origin_of[y] || place_after_collapse(x) != place_after_collapse(y));
    REACHED();
}

/* Two edges of p to A and B, which become one. */
static void assume_simple_left(cq_index x)
{
    ASSUME(target(x) != origin_of[x]);
    ASSUME(edges_are_simple(x, from_p) && edges_are_simple(x, from_q) && edges_are_simple(x, cq_prev(h)));
    ASSUME(edges_are_simple(x, cq_prev(twin_h)) && edges_are_simple(x, to_p) && edges_are_simple(x, to_q));
    ASSUME(edges_are_simple(x, cq_next(h)) && edges_are_simple(x, cq_next(twin_h)));
    ASSUME(edges_are_simple(x, h) && edges_are_simple(x, twin_h));
}

void claim_collapse_simple(void)
{
    cq_index x = any_index(), y = any_index(), start, end;
    any_collapse();
    assume_spokes(x, y);
    assume_left(x);
    assume_left(y);
    assume_simple_left(x);
    assume_simple_left(y);
    assume_link_condition(x, y);
    assume_link_condition(y, x);
    assume_link_condition(twin_of[x], twin_of[y]);
    assume_link_condition(twin_of[y], twin_of[x]);
    ASSUME(edges_are_simple(x, y));
    cq_mesh_collapse(&m, h, &start, &end);
    PROVE(edges_are_simple(x, y));
    REACHED();
}

/* No vertex but A, B, p and q has a halfedge in the two faces. */
void claim_collapse_vertices(void)
{
    cq_index v = any_index(), x, least, start, end;
    any_collapse();
    x = out_of[v];
    assume_spokes(x, x);
    ASSUME(v != b && origin_of[x] == v);
    assume_edge(x);
    least = is_virtual(v) ? 3 : 2;
    ASSUME(valence_of[v] >= least && valence_a < CQ_NONE - valence_b);
    cq_mesh_collapse(&m, h, &start, &end);
    x = out_of[v];
    PROVE(origin_of[x] == v && !is_new(x) && valence_of[v] >= least);
    REACHED();
}

/* The vertex and the two faces get free, that of h last, and no other slot changes. */
void claim_collapse_slots(void)
{
    cq_index v = any_index(), k = any_index(), link, valence, start, end, free_vertex, free_face, free_virtual_face;
    int v_free, k_free;
    any_collapse();
    assume_spokes(k, k);
    know_face(k);
    v_free = out_of[v] == CQ_NONE;
    k_free = origin_of[3 * k] == CQ_NONE;
    valence = valence_of[v];
    link = origin_of[3 * k + 1];
    free_vertex = m.free_vertex;
    ASSUME(!v_free || (v != a && v != b && v != p && v != q));
    ASSUME(a != CQ_NONE && to_p != CQ_NONE && from_p != CQ_NONE && from_q != CQ_NONE);
    cq_mesh_collapse(&m, h, &start, &end);
    PROVE((out_of[v] == CQ_NONE) == (v_free || v == b));
    PROVE((origin_of[3 * k] == CQ_NONE) == (k_free || k == f || k == g));
    PROVE(m.free_vertex == b && valence_of[b] == free_vertex);
    if (v_free) PROVE(valence_of[v] == valence);
    if (k_free && k != f && k != g) PROVE(origin_of[3 * k + 1] == link);
    REACHED();
}

/* The faces that are freed are those of h and its twin. */
void claim_collapse_frees(void)
{
    cq_index start, end;
    any_mesh();
    faces_freed = 0;
    h = any_index();
    twin_h = twin_of[h];
    ASSUME(h < 3 * LIMIT && twin_h < 3 * LIMIT && f != g && twin_of[twin_h] == h);
    ASSUME(twin_of[cq_next(h)] == cq_prev(twin_h)); /* B has no other spokes */
    cq_mesh_collapse(&m, h, &start, &end);
    REACHED();
}

/* A face goes to the head of the list of its kind. */
void claim_free_face(void)
{
    cq_index k = any_index(), *head;
    cq_index before;
    any_mesh();
    know_face(k);
    head = k >= m.first_virtual_face ? &m.free_virtual_face : &m.free_face;
    before = *head;
    cqi_free_face(&m, k);
    PROVE(*head == k && origin_of[3 * k] == CQ_NONE && origin_of[3 * k + 1] == before);
    REACHED();
}

/* What a collapse asks for: x and y are spokes of B and A, which have STEPS + 2 and AROUND_A. */
void claim_can_collapse(void)
{
    cq_index x = any_index(), y = any_index(), s, k;
    any_mesh();
    twin_h = twin_of[h];
    ASSUME(is_of(f, h) && is_of(g, twin_h));
    know_face(f);
    know_face(g);
    a = origin_of[h];
    b = origin_of[twin_h];
    p = origin_of[cq_prev(h)];
    q = origin_of[cq_prev(twin_h)];
    ASSUME(origin_of[x] == b && origin_of[y] == a && origin_of[out_of[a]] == a && a != b);
    ASSUME(place_of[out_of[a]] == 0 && place_of[twin_h] == 0);
    ASSUME(valence_of[a] == AROUND_A && valence_of[b] == STEPS + 2);
    assume_edge(h);
    assume_place(x);
    assume_place(y);
    assume_place(h);
    to_p = twin_of[cq_prev(h)];
    to_q = twin_of[cq_prev(twin_h)];
    assume_edge(cq_prev(h));
    assume_edge(cq_prev(twin_h));
    assume_edge(cq_next(h));
    assume_edge(cq_next(twin_h));
    assume_edge(twin_h);
    assume_edge(to_p);
    assume_edge(to_q);
    assume_place(to_p);
    assume_place(to_q);
    assume_place(twin_h);
    assume_place(cq_next(h));
    assume_place(cq_next(twin_h));
    for (s = out_of[a], k = 0; k <= AROUND_A; k++, s = clockwise(s)) {
        assume_edge(s);
        assume_place(s);
        assume_places(s, out_of[a]);
        assume_places(s, y);
        assume_places(s, to_p);
        assume_places(s, cq_next(twin_h));
        ASSUME(!(mark_of[target(s)] & CQI_SCRATCH));
    }
    for (s = twin_h, k = 0; k <= STEPS + 2; k++, s = clockwise(s)) {
        assume_edge(s);
        assume_place(s);
        assume_places(s, twin_h);
        assume_places(s, x);
        assume_places(s, to_q);
        assume_places(s, cq_next(h));
        ASSUME(!(mark_of[target(s)] & CQI_SCRATCH));
    }
    ASSUME(!is_virtual(target(x)) || m.num_virtual > 0); /* virtual vertices are counted */
    if (!cq_mesh_can_collapse(&m, h, CQ_NONE)) return;
    PROVE(!is_virtual(a) && !is_virtual(b) && p != q && valence_of[p] >= 4 && valence_of[q] >= 4);
    PROVE(target(x) != target(y) || target(x) == p || target(x) == q);
    PROVE(!is_virtual(target(x)) || !is_virtual(target(y)) || is_virtual(p) || is_virtual(q));
    REACHED();
}
