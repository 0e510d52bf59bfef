/* Collapses and splits in any order, against the definition of each: what may be collapsed is found again by brute
 * force, the mesh is checked and built again from its triangles after each operation, and undoing gives back every
 * triangle. In the end the arrays are damaged, and the check must end with a verdict. */
#include "surface.h"

typedef struct subject {
    cq_mesh mesh;
    cq_shape shape;
    void *memory;
} subject;

static cq_result build(subject *s, const cq_index *indices, uint32_t num_vertices, uint32_t num_faces)
{
    cq_result result = CQ_ERROR_MEMORY;
    int tries;
    memset(s, 0, sizeof *s);
    s->shape.num_vertices = num_vertices;
    s->shape.num_faces = num_faces;
    for (tries = 0; result == CQ_ERROR_MEMORY && tries < 2; tries++) {
        free(s->memory);
        s->memory = block(cq_mesh_bytes(&s->shape));
        result = cq_mesh_build(&s->mesh, &s->shape, indices, s->memory, cq_mesh_bytes(&s->shape), NULL);
    }
    return result;
}

/* -- Brute force --------------------------------------------------------------------------------------------------- */

static uint32_t num_halfedges(const cq_mesh *m) { return 3 * ((uint32_t)m->first_virtual_face + m->num_virtual_faces); }

static int is_used(const cq_mesh *m, uint32_t h)
{
    if (h / 3 >= m->num_faces && h / 3 < m->first_virtual_face) return 0;
    return m->origin[h - h % 3] != CQ_NONE;
}

static int are_neighbours(const cq_mesh *m, cq_index a, cq_index b)
{
    uint32_t h;
    for (h = 0; h < num_halfedges(m); h++)
        if (is_used(m, h) && m->origin[h] == a && cq_target(m, (cq_index)h) == b) return 1;
    return 0;
}

/* The number of neighbours that a vertex has, or that two vertices have in common. */
static uint32_t count_neighbours(const cq_mesh *m, cq_index a, cq_index b)
{
    uint32_t h, n = 0;
    for (h = 0; h < num_halfedges(m); h++)
        if (is_used(m, h) && m->origin[h] == a) n += a == b || are_neighbours(m, b, cq_target(m, (cq_index)h));
    return n;
}

static int is_next_to_virtual(const cq_mesh *m, cq_index v)
{
    uint32_t k;
    for (k = 0; k < m->num_virtual; k++)
        if (are_neighbours(m, v, (cq_index)(m->first_virtual + k))) return 1;
    return 0;
}

/* What the manual of cq_mesh_can_collapse says, word for word. */
static int may_collapse(const cq_mesh *m, cq_index h, uint32_t max_valence)
{
    cq_index a = m->origin[h], b = cq_target(m, h);
    cq_index p = m->origin[cq_prev(h)], q = m->origin[cq_prev(m->twin[h])];
    uint32_t va = count_neighbours(m, a, a), vb = count_neighbours(m, b, b);
    if (cq_is_virtual(m, a) || cq_is_virtual(m, b) || va > max_valence || vb > max_valence) return 0;
    if (va + vb < 4 || va + vb - 4 > max_valence || p == q) return 0;
    if (count_neighbours(m, a, b) != 2 || count_neighbours(m, p, p) < 4 || count_neighbours(m, q, q) < 4) return 0;
    return cq_is_virtual(m, p) || cq_is_virtual(m, q) || !is_next_to_virtual(m, a) || !is_next_to_virtual(m, b);
}

/* -- What must hold after each operation --------------------------------------------------------------------------- */

static void check(const subject *s, uint32_t vertices, uint32_t faces)
{
    const cq_mesh *m = &s->mesh;
    uint32_t slots = m->num_vertices, v, n = 0;
    cq_index *triangles = (cq_index *)block(3 * (size_t)m->num_faces * sizeof(cq_index));
    cq_index *number = (cq_index *)block(slots * sizeof(cq_index));
    subject again;
    REQUIRE(cq_mesh_check(m, NULL) == CQ_OK);
    for (v = 0; v < slots; v++) number[v] = (cq_index)(m->out[v] != CQ_NONE ? n++ : 0);
    for (v = 0; v < (uint32_t)m->first_virtual + m->num_virtual; v++)
        if (v < slots || v >= m->first_virtual) REQUIRE(m->mark[v] == 0);
    REQUIRE(n == vertices);
    REQUIRE(cq_mesh_triangles(m, triangles) == faces);
    for (v = 0; v < 3 * faces; v++) triangles[v] = number[triangles[v]];
    REQUIRE(build(&again, triangles, vertices, faces) == CQ_OK);
    REQUIRE(again.shape.num_boundary_loops == s->shape.num_boundary_loops);
    free(again.memory);
    free(triangles);
    free(number);
}

/* The triangles of all slots, each from its smallest vertex on: equal before a collapse and after it was undone. */
static cq_index *picture_of(const cq_mesh *m)
{
    uint32_t f, k, n = (uint32_t)m->first_virtual_face + m->num_virtual_faces;
    cq_index *picture = (cq_index *)block(3 * (size_t)n * sizeof(cq_index));
    for (f = 0; f < n; f++) {
        const cq_index *v = m->origin + 3 * (size_t)f;
        uint32_t least = 0;
        if (!is_used(m, 3 * f)) {
            for (k = 0; k < 3; k++) picture[3 * f + k] = CQ_NONE;
            continue;
        }
        for (k = 1; k < 3; k++) least = v[k] < v[least] ? k : least;
        for (k = 0; k < 3; k++) picture[3 * f + k] = v[(least + k) % 3];
    }
    return picture;
}

/* -- Operations ---------------------------------------------------------------------------------------------------- */

enum { MOST_UNDO = 64 };

typedef struct history {
    cq_index centre[MOST_UNDO], p[MOST_UNDO], q[MOST_UNDO], removed[MOST_UNDO];
    cq_index *picture[MOST_UNDO];
    uint32_t vertices[MOST_UNDO], faces[MOST_UNDO];
    uint32_t size;
} history;

static void forget(history *done)
{
    while (done->size > 0) free(done->picture[--done->size]);
}

static void collapse(subject *s, history *done, cq_index h, uint32_t max_valence, uint32_t *vertices, uint32_t *faces)
{
    cq_mesh *m = &s->mesh;
    cq_index first, last;
    uint32_t at = done->size, virtuals;
    int can = cq_mesh_can_collapse(m, h, (cq_index)max_valence);
    REQUIRE(can == may_collapse(m, h, max_valence));
    if (!can || at == MOST_UNDO) return;
    done->picture[at] = picture_of(m);
    done->removed[at] = cq_target(m, h);
    done->vertices[at] = *vertices;
    done->faces[at] = *faces;
    virtuals = (uint32_t)cq_is_virtual(m, m->origin[cq_prev(h)]);
    virtuals += (uint32_t)cq_is_virtual(m, m->origin[cq_prev(m->twin[h])]);
    done->centre[at] = m->origin[h];
    cq_mesh_collapse(m, h, &first, &last);
    REQUIRE(m->origin[first] == done->centre[at] && m->origin[last] == done->centre[at]);
    done->p[at] = cq_target(m, first);
    done->q[at] = cq_target(m, last);
    done->size++;
    *vertices -= 1;
    *faces -= 2 - virtuals;
}

static void undo(subject *s, history *done, uint32_t *vertices, uint32_t *faces)
{
    cq_mesh *m = &s->mesh;
    cq_index *picture, first, last;
    uint32_t at;
    if (done->size == 0) return;
    at = --done->size;
    first = cqi_find_spoke(m, done->centre[at], done->p[at]);   /* a face that was away may start at another corner */
    last = cqi_find_spoke(m, done->centre[at], done->q[at]);
    REQUIRE(cq_mesh_split(m, first, last) == done->removed[at]);
    picture = picture_of(m);
    REQUIRE(memcmp(picture, done->picture[at],
                   3 * ((size_t)m->first_virtual_face + m->num_virtual_faces) * sizeof(cq_index)) == 0);
    *vertices = done->vertices[at];
    *faces = done->faces[at];
    free(picture);
    free(done->picture[at]);
}

/* Any split of a vertex. It fails if there is no room, and then changes nothing; else the past cannot be undone. */
static void split(subject *s, history *done, cq_index first, uint32_t steps, uint32_t *vertices, uint32_t *faces)
{
    cq_mesh *m = &s->mesh;
    cq_index last = first, *before = picture_of(m), *after;
    size_t bytes = 3 * ((size_t)m->first_virtual_face + m->num_virtual_faces) * sizeof(cq_index);
    uint32_t virtuals;
    for (; steps > 0; steps--) last = cq_clockwise(m, last);
    if (last == first) last = cq_clockwise(m, last);
    virtuals = (uint32_t)cq_is_virtual(m, cq_target(m, first)) + (uint32_t)cq_is_virtual(m, cq_target(m, last));
    if (cq_mesh_split(m, first, last) == CQ_NONE) {
        after = picture_of(m);
        REQUIRE(memcmp(before, after, bytes) == 0);
        free(after);
    } else {
        forget(done);
        *vertices += 1;
        *faces += 2 - virtuals;
    }
    free(before);
}

/* The check may be asked about any contents: numbers in the arrays, and counts up to the capacity. What it accepts
 * names no vertex that is not there. */
static void damage_mesh(subject *s, input *in)
{
    cq_mesh *m = &s->mesh;
    size_t vertices = (size_t)m->first_virtual + m->max_virtual;
    size_t indices = 6 * ((size_t)m->first_virtual_face + m->max_virtual_faces) + 2 * vertices;
    uint32_t count = take(in) % 4, k, n = 0;
    cq_index *triangles;
    cq_place place;
    for (k = 0; k < count; k++) {
        uint32_t at = take_two(in), kind = take(in), value = take(in);
        m->origin[at % indices] = (cq_index)(kind < 16 ? CQ_NONE : kind < 32 ? CQ_NONE - value : kind < 144 ? value
                                             : m->origin[(at + value) % indices]);
    }
    if (count > 0 && in->size > 0) m->num_faces = (cq_index)(take(in) % (m->first_virtual_face + 2u));
    if (count > 0 && in->size > 0) m->num_vertices = (cq_index)(take(in) % (m->first_virtual + 2u));
    if (count > 0 && in->size > 0) m->num_virtual = (cq_index)(take(in) % (m->max_virtual + 2u));
    if (cq_mesh_check(m, &place) != CQ_OK) return;
    triangles = (cq_index *)block(3 * (size_t)m->num_faces * sizeof(cq_index));
    n = (uint32_t)cq_mesh_triangles(m, triangles);
    for (k = 0; k < 3 * n; k++) REQUIRE(triangles[k] < m->num_vertices);
    free(triangles);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    surface *grown = (surface *)block(sizeof *grown);
    cq_index *indices;
    subject s;
    history done;
    uint32_t vertices, faces, k;
    take_surface(grown, &in);
    vertices = grown->num_vertices < 80 ? grown->num_vertices : 0;   /* brute force takes time O(faces^2) */
    faces = grown->num_faces;
    indices = (cq_index *)block(3 * (size_t)faces * sizeof(cq_index));
    for (k = 0; k < 3 * faces; k++) indices[k] = (cq_index)grown->face[k / 3][k % 3];
    free(grown);
    if (vertices > 0) {
        REQUIRE(build(&s, indices, vertices, faces) == CQ_OK);
        done.size = 0;
        check(&s, vertices, faces);
        for (k = 0; k < 64 && in.size > 16; k++) {
            uint32_t op = take(&in), h = take_two(&in) % num_halfedges(&s.mesh);
            if (op >= 224) undo(&s, &done, &vertices, &faces);
            else if (!is_used(&s.mesh, h)) continue;
            else if (op < 160) collapse(&s, &done, (cq_index)h, 4 + op % 24, &vertices, &faces);
            else split(&s, &done, (cq_index)h, op % 32, &vertices, &faces);
            check(&s, vertices, faces);
        }
        while (done.size > 0) undo(&s, &done, &vertices, &faces);
        check(&s, vertices, faces);
        damage_mesh(&s, &in);
        free(s.memory);
    }
    free(indices);
    return 0;
}
