/* Redoes regular levels as a decoder does, from what the plan says: the coarse faces in order, their marked edges split,
 * flips inside of faces, dissolved edges, second flips. Include conquest.h, test.h and triangles.h first. */
#ifndef CQ_TESTS_REDO_H
#define CQ_TESTS_REDO_H

enum { REDO_MAX_LEVELS = 40 };

/* A mesh that is taken apart level by level and put together again. */
typedef struct redo {
    built full;
    cqi_labels labels;
    void *scratch;
    cqi_collapse *note;
    cqi_plan plan;                             /* note, decoded, to_input and tables */
    cq_index *tables, *corners;                /* of the coarse faces */
    cq_index first[REDO_MAX_LEVELS + 1];       /* note of each level */
    uint64_t hash[REDO_MAX_LEVELS];            /* of the faces before each level was undone */
    int levels, check;                         /* check: the whole mesh after each operation */
    uint64_t random;
    long splits, pattern_flips, dissolves, seconds, bad;
} redo;

static inline void redo_wrong(redo *r) { r->bad++; }

/* A sum over all faces, that does not depend on their order, nor on where a face starts. */
static inline uint64_t redo_hash(const cq_mesh *m)
{
    uint64_t sum = 0;
    uint32_t f, faces = (uint32_t)m->first_virtual_face + m->max_virtual_faces;
    for (f = 0; f < faces; ++f) {
        const cq_index *v = m->origin + 3 * f;
        uint64_t x;
        int k = 0;
        if (v[0] == CQ_NONE || !cqi_is_face(m, (cq_index)f)) continue;
        if (v[1] < v[k]) k = 1;
        if (v[2] < v[k]) k = 2;
        x = ((uint64_t)v[k] * 0x9e3779b97f4a7c15u + v[(k + 1) % 3]) * 0x9e3779b97f4a7c15u + v[(k + 2) % 3];
        sum += next_random(&x);
    }
    return sum;
}

static inline size_t redo_vertices(const redo *r) { return (size_t)r->full.mesh.first_virtual + r->full.mesh.max_virtual; }
static inline size_t redo_faces(const redo *r) { return (size_t)r->full.mesh.first_virtual_face + r->full.mesh.max_virtual_faces; }

static inline void redo_free(redo *r)
{
    unbuild(&r->full);
    exact_free(r->scratch);
    exact_free(r->note);
    exact_free(r->tables);
    exact_free(r->plan.decoded);
    exact_free(r->plan.to_input);
    exact_free(r->corners);
}

/* Builds the mesh and makes room; frees the triangles. */
static inline cq_result redo_init(redo *r, triangles t, const cq_value *positions)
{
    size_t v, f, bytes;
    cq_result result;
    memset(r, 0, sizeof *r);
    result = build(&r->full, &t);
    triangles_free(&t);
    if (result != CQ_OK) return result;
    v = redo_vertices(r);
    f = redo_faces(r);
    bytes = CQI_LABEL_BYTES(v, f);
    r->scratch = exact_alloc(bytes);
    if (!cqi_labels_carve(&r->labels, &r->full.mesh, r->scratch, bytes)) return CQ_ERROR_MEMORY;
    r->labels.positions = positions;
    r->labels.least = 0; /* levels of irregular meshes, too */
    r->note = (cqi_collapse *)exact_alloc(v * sizeof(cqi_collapse));
    r->tables = (cq_index *)exact_alloc(6 * f * sizeof(cq_index));
    r->plan.decoded = (cq_index *)exact_alloc(v * sizeof(cq_index));
    r->plan.to_input = (cq_index *)exact_alloc(v * sizeof(cq_index));
    r->corners = (cq_index *)exact_alloc(6 * f * sizeof(cq_index));
    r->plan.note = r->note;
    r->plan.mesh = r->full.mesh;
    r->plan.mesh.twin = r->tables;
    r->plan.mesh.origin = r->tables + 3 * f;
    r->random = 1;
    return CQ_OK;
}

static inline void redo_verify(redo *r)
{
    if (r->check && cq_mesh_check(&r->full.mesh, NULL) != CQ_OK) redo_wrong(r);
}

/* Undoes levels as long as at least `least` percent of the vertices are odd. Returns their number. */
static inline int redo_undo(redo *r, int least, cq_index (*find)(cqi_labels *))
{
    cq_mesh *m = &r->full.mesh;
    uint32_t v, live = 0;
    for (v = 0; v < m->num_vertices; ++v) live += m->out[v] != CQ_NONE;
    while (r->levels < REDO_MAX_LEVELS) {
        cq_index odd = find(&r->labels), at = r->first[r->levels];
        if (odd == 0 || (uint64_t)odd * 100 < (uint64_t)live * (uint64_t)least) break;
        r->hash[r->levels++] = redo_hash(m);
        cqi_undo_level(&r->labels, m, r->note + at, (uint32_t)r->levels);
        r->first[r->levels] = (cq_index)(at + odd);
        live -= odd;
        redo_verify(r);
    }
    return r->levels;
}

static inline void redo_insert(redo *r, cq_index a, cq_index b, cq_index input)
{
    cq_mesh *m = &r->full.mesh;
    cq_index h = cqi_find_edge(m, a, b), v;
    v = cq_mesh_split(m, cq_counterclockwise(m, h), cq_clockwise(m, h));
    r->plan.decoded[input] = v;
    r->plan.to_input[v] = input;
    r->splits++;
    redo_verify(r);
}

/* Returns 1 if that was done. */
static inline int redo_flip(redo *r, cq_index h, long *count)
{
    cq_mesh *m = &r->full.mesh;
    if (!cqi_can_flip(m, h)) {
        redo_wrong(r);
        return 0;
    }
    cqi_flip(m, h);
    ++*count;
    redo_verify(r);
    return 1;
}

/* Odd vertices of coarse face f: input numbers, or CQ_NONE. */
static inline cq_index redo_mark(const redo *r, uint32_t f, int k) { return r->corners[6 * f + 3 + (uint32_t)k % 3]; }
static inline cq_index redo_corner(const redo *r, uint32_t f, int k) { return r->corners[6 * f + (uint32_t)k % 3]; }
static inline cq_index redo_odd(const redo *r, uint32_t f, int k) { return r->plan.decoded[redo_mark(r, f, k)]; }
static inline int redo_marks(const redo *r, uint32_t f)
{
    return (redo_mark(r, f, 0) != CQ_NONE) + (redo_mark(r, f, 1) != CQ_NONE) + (redo_mark(r, f, 2) != CQ_NONE);
}

static inline int redo_inserted(const redo *r, cq_index input) { return r->plan.decoded[input] != CQ_NONE; }

static inline void redo_split_face(redo *r, uint32_t f)
{
    int k;
    for (k = 0; k < 3; ++k)
        if (redo_mark(r, f, k) != CQ_NONE && !redo_inserted(r, redo_mark(r, f, k)))
            redo_insert(r, redo_corner(r, f, k), redo_corner(r, f, k + 1), redo_mark(r, f, k));
}

/* The spoke from the odd vertex on side k that runs inside the face: clockwise of the one to the corner at its start. */
static inline cq_index redo_inner_spoke(const redo *r, uint32_t f, int k)
{
    const cq_mesh *m = &r->full.mesh;
    return cq_clockwise(m, cqi_find_spoke(m, redo_odd(r, f, k), redo_corner(r, f, k)));
}

/* Is the odd vertex on side k the hub of the face? Its note knows that of the face on the left of its parents' edge a -> b in p. */
static inline int redo_is_hub(const redo *r, uint32_t f, int k)
{
    const cqi_collapse *c = cqi_plan_odd(&r->plan, redo_odd(r, f, k));
    return ((r->plan.decoded[c->kept] == redo_corner(r, f, k) ? c->p : c->q) & CQI_SIDE_HUB) != 0;
}

/* Flips until the face with two or three marks is triangulated as the plan wants. Then the hub is joined to its opposite
 * corner, others are not: a vertex that is and should not be flips that edge; the central triangle then flips what
 * joins the wanted hub's neighbours. */
static inline void redo_pattern(redo *r, uint32_t f)
{
    const cq_mesh *m = &r->full.mesh;
    int k, hub = -1;
    if (redo_marks(r, f) < 2) return;
    for (k = 0; k < 3; ++k)
        if (redo_mark(r, f, k) != CQ_NONE && redo_is_hub(r, f, k)) {
            if (hub >= 0) redo_wrong(r);
            hub = k;
        }
    if (redo_marks(r, f) == 2 && hub < 0) redo_wrong(r);
    for (k = 0; k < 3; ++k) {
        cq_index from, to;
        if (k == hub || redo_mark(r, f, k) == CQ_NONE) continue;
        from = redo_odd(r, f, k);
        to = redo_corner(r, f, k + 2);
        if (!cqi_joined(m, from, to)) continue;
        redo_flip(r, cqi_find_spoke(m, from, to), &r->pattern_flips);
    }
    if (redo_marks(r, f) == 3 && hub >= 0 && !cqi_joined(m, redo_odd(r, f, hub), redo_corner(r, f, hub + 2)))
        redo_flip(r, cqi_find_edge(m, redo_odd(r, f, hub + 1), redo_odd(r, f, hub + 2)), &r->pattern_flips);
}

/* Is the edge inside a face with one mark, on that side, flipped in the end? */
static inline int redo_wants_second(const redo *r, uint32_t f, int *side)
{
    int k;
    if (redo_marks(r, f) != 1) return 0;
    for (k = 0; redo_mark(r, f, k) == CQ_NONE;) ++k;
    *side = k;
    return cqi_plan_second(&r->plan, &r->full.mesh, redo_inner_spoke(r, f, k));
}

static inline void redo_second(redo *r, uint32_t f, int side)
{
    const cq_mesh *m = &r->full.mesh;
    redo_flip(r, cqi_find_spoke(m, redo_odd(r, f, side), redo_corner(r, f, side + 2)), &r->seconds);
}

/* Dissolves the edge on side k of f, and then does the second flips of both faces. */
static inline void redo_dissolve(redo *r, uint32_t f, int k, uint32_t g)
{
    const cq_mesh *m = &r->full.mesh;
    int side[2] = {0, 0}, second[2];
    second[0] = redo_wants_second(r, f, &side[0]);
    second[1] = redo_wants_second(r, g, &side[1]);
    if (!redo_flip(r, cqi_find_spoke(m, redo_corner(r, f, k), redo_corner(r, f, k + 1)), &r->dissolves)) return;
    if (second[0]) redo_second(r, f, side[0]);
    if (second[1]) redo_second(r, g, side[1]);
}

/* Redoes the last level that was undone. order 0: face by face, dissolving as soon as both faces are there, as a decoder;
 * 1: the same in random order; 2: all insertions, then all patterns, then all dissolves, in random order. */
static inline void redo_level(redo *r, int order)
{
    cq_mesh *m = &r->full.mesh;
    const int level = --r->levels;
    const uint32_t faces = (uint32_t)redo_faces(r);
    uint32_t f, i, n = 0, *sequence = (uint32_t *)exact_alloc(faces * sizeof *sequence);
    cq_index *other = (cq_index *)exact_alloc(3 * (size_t)faces * sizeof *other);
    uint8_t *done = (uint8_t *)exact_alloc(faces), *dissolved = (uint8_t *)exact_alloc(3 * (size_t)faces);
    size_t v;
    int k, pass;
    for (v = 0; v < redo_vertices(r); ++v) {
        r->plan.decoded[v] = r->plan.to_input[v] = (cq_index)v;
        r->plan.mesh.origin[v] = CQ_NONE;
    }
    cqi_plan_regular(&r->plan, m, r->first[level], (cq_index)(r->first[level + 1] - r->first[level]));
    memset(done, 0, faces);
    for (f = 0; f < m->num_faces; ++f) {
        if (m->origin[3 * f] == CQ_NONE) continue;
        sequence[n++] = f;
        for (k = 0; k < 3; ++k) {
            r->corners[6 * f + (uint32_t)k] = m->origin[3 * f + (uint32_t)k];
            r->corners[6 * f + 3 + (uint32_t)k] = cqi_plan_mark(&r->plan, (cq_index)(3 * f + (uint32_t)k));
            other[3 * f + (uint32_t)k] = (cq_index)(m->twin[3 * f + (uint32_t)k] / 3);
            dissolved[3 * f + (uint32_t)k] = (uint8_t)cqi_plan_dissolved(&r->plan, m, (cq_index)(3 * f + (uint32_t)k));
        }
    }
    for (i = r->first[level]; i < r->first[level + 1]; ++i) r->plan.decoded[r->note[i].removed] = CQ_NONE;
    for (pass = 0; pass < (order == 2 ? 3 : 1); ++pass) {
        for (i = n; order && i > 1; --i) {
            const uint32_t j = (uint32_t)(next_random(&r->random) % i), x = sequence[j];
            sequence[j] = sequence[i - 1];
            sequence[i - 1] = x;
        }
        for (i = 0; i < n; ++i) {
            f = sequence[i];
            if (order != 2 || pass == 0) redo_split_face(r, f);
            if (order != 2 || pass == 1) redo_pattern(r, f);
            done[f] = 1;
            for (k = 0; k < 3 && (order != 2 || pass == 2); ++k) {
                const uint32_t g = other[3 * f + (uint32_t)k];
                if (dissolved[3 * f + (uint32_t)k] && (order == 2 ? g > f : done[g]))
                    redo_dissolve(r, f, k, g);
            }
        }
    }
    for (i = r->first[level]; i < r->first[level + 1]; ++i)
        if (!redo_inserted(r, r->note[i].removed)) redo_wrong(r);
    exact_free(sequence);
    exact_free(other);
    exact_free(done);
    exact_free(dissolved);
}

/* Gives the vertices of the mesh their input numbers: a decoder reuses free slots in its own order. */
static inline void redo_renumber(redo *r)
{
    cq_mesh *m = &r->full.mesh;
    uint32_t h, n = 3 * (uint32_t)redo_faces(r);
    size_t v, bytes = redo_vertices(r) * sizeof(cq_index);
    cq_index *out = (cq_index *)exact_copy(m->out, bytes), *valence = (cq_index *)exact_copy(m->valence, bytes);
    for (h = 0; h < n; ++h)
        if (m->origin[h - h % 3] != CQ_NONE) m->origin[h] = r->plan.to_input[m->origin[h]];
    for (v = 0; v < redo_vertices(r); ++v) {
        if (out[v] == CQ_NONE) continue;
        m->out[r->plan.to_input[v]] = out[v];
        m->valence[r->plan.to_input[v]] = valence[v];
    }
    exact_free(out);
    exact_free(valence);
}

/* Redoes all levels; counts what is not as it was. */
static inline void redo_all(redo *r, int order)
{
    while (r->levels && r->bad == 0) {
        redo_level(r, order);
        redo_renumber(r);
        r->bad += redo_hash(&r->full.mesh) != r->hash[r->levels];
        r->bad += cq_mesh_check(&r->full.mesh, NULL) != CQ_OK;
    }
}

#endif
