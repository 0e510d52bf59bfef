/* Small meshes as index buffers, and a mesh built from one in memory of the exact size. C99 and C++; include conquest.h
 * first. Faces are counter-clockwise seen from outside (or from above). */
#ifndef CQ_TESTS_TRIANGLES_H
#define CQ_TESTS_TRIANGLES_H

#include "exact.h"

enum { TRIANGLES_MAX_FACES = 1 << 16 };

typedef struct triangles {
    uint32_t num_vertices, num_faces;
    cq_index *indices;   /* cq_index[3 * num_faces] in a block of exactly that size */
} triangles;

static inline triangles triangles_none(void)
{
    triangles t;
    t.num_vertices = t.num_faces = 0;
    t.indices = (cq_index *)exact_alloc(0);
    return t;
}

static inline void triangles_free(triangles *t)
{
    exact_free(t->indices);
    t->indices = NULL;
    t->num_vertices = t->num_faces = 0;
}

/* Triangles that are written out. */
static inline triangles triangles_of(uint32_t num_vertices, uint32_t num_faces, const int *faces)
{
    triangles t;
    uint32_t i;
    t.num_vertices = num_vertices;
    t.num_faces = num_faces;
    t.indices = (cq_index *)exact_alloc(3 * (size_t)num_faces * sizeof(cq_index));
    for (i = 0; i < 3 * num_faces; ++i) t.indices[i] = (cq_index)faces[i];
    return t;
}

/* Appends `other` as more components and frees it. */
static inline void triangles_append(triangles *t, triangles other)
{
    uint32_t n = 3 * t->num_faces, m = 3 * other.num_faces, i;
    cq_index *joined = (cq_index *)exact_alloc((size_t)(n + m) * sizeof(cq_index));
    for (i = 0; i < n; ++i) joined[i] = t->indices[i];
    for (i = 0; i < m; ++i) joined[n + i] = (cq_index)(other.indices[i] + t->num_vertices);
    exact_free(t->indices);
    t->indices = joined;
    t->num_vertices += other.num_vertices;
    t->num_faces += other.num_faces;
    triangles_free(&other);
}

/* Removes one face; the others move up. Vertices stay. */
static inline void triangles_remove(triangles *t, uint32_t face)
{
    triangles rest;
    uint32_t i;
    rest.num_vertices = t->num_vertices;
    rest.num_faces = t->num_faces - 1;
    rest.indices = (cq_index *)exact_alloc(3 * (size_t)rest.num_faces * sizeof(cq_index));
    for (i = 0; i < 3 * rest.num_faces; ++i) rest.indices[i] = t->indices[i < 3 * face ? i : i + 3];
    triangles_free(t);
    *t = rest;
}

static inline triangles triangles_single(void)
{
    static const int f[] = {0, 1, 2};
    return triangles_of(3, 1, f);
}

/* Two faces back to back: the smallest closed mesh, all vertices of valence 2. */
static inline triangles triangles_pillow(void)
{
    static const int f[] = {0, 1, 2, 2, 1, 0};
    return triangles_of(3, 2, f);
}

static inline triangles triangles_tetrahedron(void)
{
    static const int f[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    return triangles_of(4, 4, f);
}

/* Poles 0 and 5, equator 1 2 3 4. */
static inline triangles triangles_octahedron(void)
{
    static const int f[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 5, 2, 1, 5, 3, 2, 5, 4, 3, 5, 1, 4};
    return triangles_of(6, 8, f);
}

/* Poles n and n + 1 over an equator 0 .. n-1: bipyramid(3) has valences 3 and 4, bipyramid(4) is an octahedron. */
static inline triangles triangles_bipyramid(uint32_t n)
{
    triangles t;
    uint32_t i;
    t.num_vertices = n + 2;
    t.num_faces = 2 * n;
    t.indices = (cq_index *)exact_alloc(3 * (size_t)t.num_faces * sizeof(cq_index));
    for (i = 0; i < n; ++i) {
        uint32_t j = (i + 1) % n;
        cq_index *f = t.indices + 6 * i;
        f[0] = (cq_index)i, f[1] = (cq_index)j, f[2] = (cq_index)n;
        f[3] = (cq_index)j, f[4] = (cq_index)i, f[5] = (cq_index)(n + 1);
    }
    return t;
}

static inline triangles triangles_icosahedron(void)
{
    static const int f[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 1, 1, 6, 2, 2, 6, 7, 2, 7, 3, 3, 7,
                            8, 3, 8, 4, 4, 8, 9, 4, 9, 5, 5, 9, 10, 5, 10, 1, 1, 10, 6, 11, 7, 6, 11, 8,
                            7, 11, 9, 8, 11, 10, 9, 11, 6, 10};
    return triangles_of(12, 20, f);
}

/* A grid of w x h vertices, each dimension closed to a ring or open; `twist` mirrors the seam of w (Moebius strip). A
 * ring needs at least 3 vertices to be a simplicial complex. */
static inline triangles triangles_grid(uint32_t w, uint32_t h, int ring_w, int ring_h, int twist)
{
    uint32_t cells_w = ring_w ? w : w - 1, cells_h = ring_h ? h : h - 1, x, y, n = 0;
    triangles t;
    t.num_vertices = w * h;
    t.num_faces = 2 * cells_w * cells_h;
    t.indices = (cq_index *)exact_alloc(3 * (size_t)t.num_faces * sizeof(cq_index));
    for (y = 0; y < cells_h; ++y) {
        for (x = 0; x < cells_w; ++x) {
            uint32_t y1 = (y + 1) % h, x1 = (x + 1) % w;
            int seam = twist && x + 1 == w;
            uint32_t a = y * w + x, d = y1 * w + x;
            uint32_t b = (seam ? h - 1 - y : y) * w + x1, c = (seam ? h - 1 - y1 : y1) * w + x1;
            cq_index *f = t.indices + n;
            f[0] = (cq_index)a, f[1] = (cq_index)b, f[2] = (cq_index)c;
            f[3] = (cq_index)a, f[4] = (cq_index)c, f[5] = (cq_index)d;
            n += 6;
        }
    }
    return t;
}

static inline triangles triangles_torus(uint32_t w, uint32_t h) { return triangles_grid(w, h, 1, 1, 0); }
static inline triangles triangles_sheet(uint32_t w, uint32_t h) { return triangles_grid(w, h, 0, 0, 0); }
static inline triangles triangles_moebius(uint32_t w) { return triangles_grid(w, 2, 1, 0, 1); }

/* A band around a ring: two boundary loops of length n. */
static inline triangles triangles_annulus(uint32_t n) { return triangles_grid(n, 2, 1, 0, 0); }

/* A fan of n faces around vertex 0: one boundary loop of length n. */
static inline triangles triangles_disc(uint32_t n)
{
    triangles t;
    uint32_t i;
    t.num_vertices = n + 1;
    t.num_faces = n;
    t.indices = (cq_index *)exact_alloc(3 * (size_t)n * sizeof(cq_index));
    for (i = 0; i < n; ++i) {
        t.indices[3 * i] = 0;
        t.indices[3 * i + 1] = (cq_index)(1 + i);
        t.indices[3 * i + 2] = (cq_index)(1 + (i + 1) % n);
    }
    return t;
}

/* -- A mesh built from them ---------------------------------------------------------------------------------------- */

typedef struct built {
    cq_mesh mesh;
    cq_shape shape;
    cq_place place;
    void *memory;      /* exactly `size` bytes */
    size_t size;
    int tries;
} built;

/* Builds as the manual says: first as if closed, and once more with the memory that the shape then asks for. */
static inline cq_result build(built *b, const triangles *t)
{
    cq_result result = CQ_ERROR_MEMORY;
    memset(b, 0, sizeof *b);
    b->shape.num_vertices = t->num_vertices;
    b->shape.num_faces = t->num_faces;
    while (result == CQ_ERROR_MEMORY && b->tries < 2) {
        exact_free(b->memory);
        b->size = cq_mesh_bytes(&b->shape);
        b->memory = exact_alloc(b->size);
        result = cq_mesh_build(&b->mesh, &b->shape, t->indices, b->memory, b->size, &b->place);
        b->tries++;
    }
    return result;
}

static inline void unbuild(built *b)
{
    exact_free(b->memory);
    b->memory = NULL;
}

/* The halfedge from a to b, or CQ_NONE. Looks at every halfedge: it is a test. */
static inline cq_index find_halfedge(const cq_mesh *m, uint32_t a, uint32_t b)
{
    uint32_t faces = (uint32_t)m->first_virtual_face + m->max_virtual_faces, h;
    for (h = 0; h < 3 * faces; ++h)
        if (m->origin[h - h % 3] != CQ_NONE && m->origin[h] == a && m->origin[cq_next((cq_index)h)] == b)
            return (cq_index)h;
    return CQ_NONE;
}

/* A deterministic pseudo-random sequence (splitmix64): the same on every platform. */
static inline uint64_t next_random(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

#endif
