/* Small oriented manifolds that grow as bytes direct: any genus, any number of components and of boundary loops, with
 * channels of values; and their streams. Works on a plain list of faces, apart from the mesh of the library. */
#ifndef CQ_FUZZ_SURFACE_H
#define CQ_FUZZ_SURFACE_H

#include "fuzz.h"

enum { SURFACE_VERTICES = 320, SURFACE_FACES = 640 };

typedef struct surface {
    uint32_t num_vertices, num_faces;
    uint32_t face[SURFACE_FACES][3];
} surface;

static inline void add_face(surface *s, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *face = s->face[s->num_faces++];
    face[0] = a, face[1] = b, face[2] = c;
}

static inline int has_room(const surface *s, uint32_t vertices, uint32_t faces)
{
    return s->num_vertices + vertices <= SURFACE_VERTICES && s->num_faces + faces <= SURFACE_FACES;
}

enum { NOWHERE = 3 * SURFACE_FACES };

/* The halfedge 3 * face + corner that runs from a to b, or NOWHERE. */
static inline uint32_t find(const surface *s, uint32_t a, uint32_t b)
{
    uint32_t h;
    for (h = 0; h < 3 * s->num_faces; h++)
        if (s->face[h / 3][h % 3] == a && s->face[h / 3][(h % 3 + 1) % 3] == b) return h;
    return NOWHERE;
}

/* Where the vertex `steps` corners behind the start of h is. */
static inline uint32_t *corner(surface *s, uint32_t h, uint32_t steps) { return &s->face[h / 3][(h % 3 + steps) % 3]; }

static inline int has_edge(const surface *s, uint32_t a, uint32_t b)
{
    return find(s, a, b) != NOWHERE || find(s, b, a) != NOWHERE;
}

/* -- Growing ------------------------------------------------------------------------------------------------------- */

/* A ring of w x h quads, both ways closed. */
static inline void add_torus(surface *s, uint32_t w, uint32_t h)
{
    uint32_t n = s->num_vertices, x, y;
    for (y = 0; y < h; y++)
        for (x = 0; x < w; x++) {
            uint32_t a = n + y * w + x, b = n + y * w + (x + 1) % w;
            uint32_t d = n + (y + 1) % h * w + x, c = n + (y + 1) % h * w + (x + 1) % w;
            add_face(s, a, b, c);
            add_face(s, a, c, d);
        }
    s->num_vertices += w * h;
}

/* Two poles and n rim vertices: 3 is a bipyramid over a triangle, many are hubs. */
static inline void add_bipyramid(surface *s, uint32_t n)
{
    uint32_t first = s->num_vertices, k;
    for (k = 0; k < n; k++) {
        add_face(s, first + k, first + (k + 1) % n, first + n);
        add_face(s, first + (k + 1) % n, first + k, first + n + 1);
    }
    s->num_vertices += n + 2;
}

static inline void add_component(surface *s, input *in)
{
    uint32_t kind = take(in), n = s->num_vertices;
    if (kind < 100 && has_room(s, 4, 4)) {
        add_face(s, n, n + 1, n + 2);
        add_face(s, n, n + 2, n + 3);
        add_face(s, n, n + 3, n + 1);
        add_face(s, n + 1, n + 3, n + 2);
        s->num_vertices += 4;
    } else if (kind < 140 && has_room(s, 3, 2)) {   /* two faces back to back */
        add_face(s, n, n + 1, n + 2);
        add_face(s, n + 2, n + 1, n);
        s->num_vertices += 3;
    } else if (kind < 200 && has_room(s, 42, 80)) {
        add_bipyramid(s, 3 + (kind - 140) % 38);
    } else if (has_room(s, 25, 50)) {
        add_torus(s, 3 + kind % 3, 3 + kind / 3 % 3);
    }
}

/* A new vertex in the face of h. */
static inline void split_face(surface *s, uint32_t h)
{
    uint32_t a = *corner(s, h, 0), b = *corner(s, h, 1), c = *corner(s, h, 2), v = s->num_vertices;
    if (!has_room(s, 1, 2)) return;
    s->num_vertices++;
    *corner(s, h, 2) = v;
    add_face(s, b, c, v);
    add_face(s, c, a, v);
}

/* A new vertex on the edge of h; not between two faces back to back. */
static inline void split_edge(surface *s, uint32_t h)
{
    uint32_t a = *corner(s, h, 0), b = *corner(s, h, 1), c = *corner(s, h, 2), v = s->num_vertices;
    uint32_t g = find(s, b, a), d = *corner(s, g, 2);
    if (c == d || !has_room(s, 1, 2)) return;
    s->num_vertices++;
    add_face(s, v, b, c);
    add_face(s, v, a, d);
    *corner(s, h, 1) = v;
    *corner(s, g, 1) = v;
}

/* The edge of h becomes the other diagonal, if there is no such edge yet. */
static inline void flip_edge(surface *s, uint32_t h)
{
    uint32_t a = *corner(s, h, 0), b = *corner(s, h, 1), c = *corner(s, h, 2), g = find(s, b, a), d = *corner(s, g, 2);
    if (c == d || has_edge(s, c, d)) return;
    *corner(s, h, 1) = d;   /* a, b, c -> a, d, c */
    *corner(s, g, 1) = c;   /* b, a, d -> b, c, d */
}

/* The start of h keeps its other neighbours; a new vertex takes those behind the `count` faces from h on. */
static inline void split_vertex(surface *s, uint32_t h, uint32_t count)
{
    uint32_t v = *corner(s, h, 0), p = *corner(s, h, 1), q = p, w = s->num_vertices, taken[8], k;
    if (!has_room(s, 1, 2)) return;
    for (k = 0; k < count; k++) {
        taken[k] = find(s, v, q);
        q = *corner(s, taken[k], 2);
        if (q == p) return;
    }
    s->num_vertices++;
    for (k = 0; k < count; k++) *corner(s, taken[k], 0) = w;
    add_face(s, v, p, w);
    add_face(s, v, w, q);
}

/* A tube between two faces: a handle, or two components become one. No edge may occur twice. */
static inline void add_tube(surface *s, uint32_t f, uint32_t g)
{
    uint32_t a[3], b[3], i, j;
    if (f == g || !has_room(s, 0, 4)) return;
    for (i = 0; i < 3; i++) a[i] = s->face[f][i], b[i] = s->face[g][2 - i];
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++)
            if (a[i] == b[j] || has_edge(s, a[i], b[j])) return;
    s->face[f][2] = b[0];
    s->face[g][0] = a[1], s->face[g][1] = b[1], s->face[g][2] = b[0];
    for (i = 1; i < 3; i++) {
        j = (i + 1) % 3;
        add_face(s, a[i], a[j], b[i]);
        add_face(s, a[j], b[j], b[i]);
    }
}

static inline void grow(surface *s, input *in)
{
    uint32_t op = take(in), h = take_below(in, 3 * s->num_faces);
    switch (op % 8) {
    case 0: split_face(s, h); break;
    case 1: split_edge(s, h); break;
    case 2: case 3: flip_edge(s, h); break;
    case 4: case 5: split_vertex(s, h, 1 + op / 8 % 8); break;
    case 6: add_tube(s, h / 3, take_below(in, s->num_faces)); break;
    default: add_component(s, in); break;
    }
}

/* -- Holes --------------------------------------------------------------------------------------------------------- */

static inline int on_boundary(const surface *s, uint32_t v)
{
    uint32_t h;
    for (h = 0; h < 3 * s->num_faces; h++)
        if (s->face[h / 3][h % 3] == v && find(s, s->face[h / 3][(h % 3 + 1) % 3], v) == NOWHERE) return 1;
    return 0;
}

/* Removes face f if each of its vertices keeps one fan: a new hole, or one that grows over an edge. */
static inline void cut(surface *s, uint32_t f)
{
    uint32_t *v = s->face[f], k, open = 0, edge = 0;
    for (k = 0; k < 3; k++)
        if (find(s, v[(k + 1) % 3], v[k]) == NOWHERE) open++, edge = k;
    if (open > 1 || on_boundary(s, v[(edge + 2) % 3])) return;
    if (open == 0 && (on_boundary(s, v[0]) || on_boundary(s, v[1]))) return;
    s->num_faces--;
    memmove(s->face[f], s->face[s->num_faces], sizeof s->face[f]);
}

/* -- Numbering ----------------------------------------------------------------------------------------------------- */

static inline uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Vertices that no face names go away, the others get new numbers, and faces another order and first corner. */
static inline void renumber(surface *s, uint32_t seed)
{
    uint32_t number[SURFACE_VERTICES], f, k, j, n = 0;
    for (k = 0; k < s->num_vertices; k++) number[k] = SURFACE_VERTICES;
    for (f = 0; f < s->num_faces; f++)
        for (k = 0; k < 3; k++)
            if (number[s->face[f][k]] == SURFACE_VERTICES) number[s->face[f][k]] = n++;
    for (k = 0; seed != 0 && k < s->num_vertices; k++) {
        uint32_t other = next_random(&seed) % s->num_vertices, swap = number[k];
        if (swap == SURFACE_VERTICES || number[other] == SURFACE_VERTICES) continue;
        number[k] = number[other], number[other] = swap;
    }
    for (f = 0; f < s->num_faces; f++) {
        uint32_t other = seed != 0 ? next_random(&seed) % s->num_faces : f, turn = seed % 3, face[3];
        memcpy(face, s->face[f], sizeof face);
        memmove(s->face[f], s->face[other], sizeof face);
        for (j = 0; j < 3; j++) s->face[other][j] = face[(j + turn) % 3];
    }
    for (f = 0; f < s->num_faces; f++)
        for (k = 0; k < 3; k++) s->face[f][k] = number[s->face[f][k]];
    s->num_vertices = n;
}

static inline void take_surface(surface *s, input *in)
{
    uint32_t steps = take(in) % 160, cuts = take(in), seed = take(in), k;
    s->num_vertices = s->num_faces = 0;
    add_component(s, in);
    for (k = 0; k < steps && in->size > 0; k++) grow(s, in);
    for (k = 0; k < cuts % 32; k++) cut(s, take_below(in, s->num_faces));
    renumber(s, seed);
}

/* -- What to encode ------------------------------------------------------------------------------------------------ */

typedef struct model {
    cq_input input;
    cq_index *indices;
    cq_value *values[CQ_MAX_CHANNELS];
} model;

/* Values: near to each other, all alike, only the limits, or noise. */
static inline void fill_values(model *m, uint32_t k, uint32_t texture)
{
    const cq_channel *c = &m->input.shape.channel[k];
    size_t n = num_values(c, m->input.shape.num_vertices, m->input.shape.num_faces), j;
    uint32_t top = c->bits == CQ_EXACT_BITS ? 0xffffffffu : ((uint32_t)1 << c->bits) - 1, seed = texture;
    m->values[k] = (cq_value *)block(n * sizeof(cq_value));
    for (j = 0; j < n; j++) {
        uint32_t random = next_random(&seed);
        uint32_t x = texture % 4 == 0 ? (uint32_t)j * 3 + random % 5 : texture % 4 == 1 ? texture
                   : texture % 4 == 2 ? (random & 1) * top : random;
        m->values[k][j] = (cq_value)(x & top);
    }
    m->input.values[k] = m->values[k];
}

static inline model take_model(input *in)
{
    model m;
    surface s;
    uint32_t k;
    memset(&m, 0, sizeof m);
    take_channels(in, &m.input.shape);
    take_surface(&s, in);
    m.input.shape.num_vertices = s.num_vertices;
    m.input.shape.num_faces = s.num_faces;
    m.input.goal = (cq_goal)(s.num_vertices % 2);
    m.indices = (cq_index *)block(3 * (size_t)s.num_faces * sizeof(cq_index));
    for (k = 0; k < 3 * s.num_faces; k++) m.indices[k] = (cq_index)s.face[k / 3][k % 3];
    m.input.indices = m.indices;
    for (k = 0; k < m.input.shape.num_channels; k++) fill_values(&m, k, take(in) + 1);
    return m;
}

static inline void model_free(model *m)
{
    uint32_t k;
    free(m->indices);
    for (k = 0; k < CQ_MAX_CHANNELS; k++) free(m->values[k]);
}

/* Encodes as the manual says, in exactly the memory and the output that it takes. An output that is a byte short must
 * be refused, with the same size. The maps and `report` may be NULL. */
static inline cq_result encode(model *m, stream *s, cq_index *map, cq_index *face_map, cq_report *report)
{
    void *memory = NULL;
    size_t memory_size = 0, size = 0, again = 0;
    cq_result result = CQ_ERROR_MEMORY;
    int tries;
    s->data = NULL;
    s->size = 0;
    m->input.map = map;
    m->input.face_map = face_map;
    for (tries = 0; result == CQ_ERROR_MEMORY && tries < 2; tries++) {
        free(memory);
        memory_size = cq_encoder_bytes(&m->input.shape);
        memory = block(memory_size);
        result = cq_encode(&m->input, memory, memory_size, NULL, 0, &size, NULL, NULL);
    }
    REQUIRE(result < 0 && result != CQ_ERROR_MEMORY);   /* nothing fits in no bytes */
    REQUIRE(memory_size <= cq_encoder_bytes_at_most(&m->input.shape));
    if (result == CQ_ERROR_OUTPUT) {
        s->size = size;
        s->data = (uint8_t *)block(size);
        REQUIRE(cq_encode(&m->input, memory, memory_size, s->data, size - 1, &again, NULL, NULL) == CQ_ERROR_OUTPUT);
        REQUIRE(again == size);
        result = cq_encode(&m->input, memory, memory_size, s->data, size, &again, NULL, report);
        REQUIRE(result == CQ_OK && again == size);
    }
    free(memory);
    return result;
}

/* The stream of a surface that the bytes direct. */
static inline stream take_encoded_stream(input *in)
{
    model m = take_model(in);
    stream s;
    REQUIRE(encode(&m, &s, NULL, NULL, NULL) == CQ_OK);
    model_free(&m);
    return s;
}

#endif
