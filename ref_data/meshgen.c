/* meshgen: writes test meshes as OFF to standard output. SPDX-License-Identifier: MIT
 *
 * The same arguments give the same bytes on every platform: coordinates are integers in 1/65536, sines and roots are
 * computed in integers, random numbers come from an integer hash. `meshgen --help` lists the kinds. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNIT 65536                   /* one unit of length; coordinates below 256 units are exact in binary32 */
#define MAX_ARGS 4
#define MAX_ARG 100000000u
#define MAX_COUNT 0x2aaaaaaau        /* vertices or faces; three times as many halfedges still fit an int32 */
#define MAX_SIDE 500000u             /* squares of a sheet in one direction: int32 coordinates of a grid */
#define NONE UINT32_MAX

typedef struct { int32_t x, y, z; } point;
typedef struct { uint32_t v[3]; } triangle;

typedef struct {
    point *points;
    triangle *faces;
    uint32_t num_points, num_faces;
    uint32_t max_points, max_faces;
} mesh;

typedef struct {
    uint32_t n[MAX_ARGS];            /* numbers; optional ones that were not given are 0 */
    char **rest;                     /* of kinds that change another: what follows their number, NULL-terminated */
} arguments;

static void fail(const char *what, const char *which)
{
    fprintf(stderr, "meshgen: %s%s%s\n", what, *which ? ": " : "", which);
    exit(2);
}

/* -- Numbers ------------------------------------------------------------------------------------------------------- */

/* splitmix64's finaliser: every bit of the result depends on every bit of x. */
static uint32_t hash(uint64_t x)
{
    x += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)(x >> 32);
}

/* 0 .. n-1 from a counter that it advances. */
static uint32_t random_below(uint64_t *counter, uint32_t n)
{
    return (uint32_t)((uint64_t)hash((*counter)++) * n >> 32);
}

/* Sine of k/n of a turn times 65536: Taylor's series with 30 fractional bits on -90 .. 90 degrees. */
static int32_t sine(uint32_t k, uint32_t n)
{
    const int64_t turn = INT64_C(6746518852);  /* 2 pi 2^30 */
    int64_t x = turn * (k % n) / n;
    if (x > turn / 4)
        x = x > turn / 4 * 3 ? x - turn : turn / 2 - x;
    int64_t term = x, sum = x;
    for (int i = 2; i <= 12; i += 2) {
        term = -(term * x / (1 << 30)) * x / (1 << 30) / (i * (i + 1));
        sum += term;
    }
    return (int32_t)(sum >= 0 ? (sum + 8192) / 16384 : (sum - 8192) / 16384);
}

static int32_t cosine(uint32_t k, uint32_t n)
{
    return sine((4 * (k % n) + n) % (4 * n), 4 * n);
}

/* Largest r with r^2 <= x, bit by bit. */
static int64_t square_root(int64_t x)
{
    int64_t r = 0;
    for (int64_t bit = INT64_C(1) << 30; bit; bit >>= 1)
        if ((r + bit) * (r + bit) <= x)
            r += bit;
    return r;
}

static int32_t scale(int32_t a, int32_t b)
{
    return (int32_t)((int64_t)a * b / UNIT);
}

/* Value noise in 0 .. 65535 at (x, y): lattice points `cell` apart, blended by 3t^2 - 2t^3. */
static int32_t noise(uint32_t x, uint32_t y, uint32_t cell, uint32_t seed)
{
    int64_t corner[2][2], t[2] = { (int64_t)(x % cell) * UNIT / cell, (int64_t)(y % cell) * UNIT / cell };
    for (uint32_t j = 0; j < 2; ++j)
        for (uint32_t i = 0; i < 2; ++i)
            corner[j][i] = hash(((uint64_t)seed << 56) ^ ((uint64_t)(y / cell + j) << 28) ^ (x / cell + i)) >> 16;
    for (int k = 0; k < 2; ++k)
        t[k] = (t[k] * t[k] / UNIT) * (3 * UNIT - 2 * t[k]) / UNIT;
    for (int j = 0; j < 2; ++j)
        corner[j][0] += (corner[j][1] - corner[j][0]) * t[0] / UNIT;
    return (int32_t)(corner[0][0] + (corner[1][0] - corner[0][0]) * t[1] / UNIT);
}

/* Hills of five sizes, 0 .. 65535. */
static int32_t hills(uint32_t x, uint32_t y)
{
    int32_t sum = 0;
    for (uint32_t k = 0; k < 5; ++k)
        sum += noise(x, y, 64u >> k, k) >> (k + 1);
    return sum;
}

/* -- Mesh ---------------------------------------------------------------------------------------------------------- */

/* Room for one more element in an array that doubles; returns the array. */
static void *grow(void *array, uint32_t count, uint32_t *capacity, size_t size)
{
    if (count < *capacity)
        return array;
    if (count >= MAX_COUNT)
        fail("mesh too large", "");
    *capacity = *capacity ? 2 * *capacity : 64;
    array = realloc(array, *capacity * size);
    if (!array)
        fail("out of memory", "");
    return array;
}

static uint32_t add_point(mesh *m, int64_t x, int64_t y, int64_t z)
{
    if (x != (int32_t)x || y != (int32_t)y || z != (int32_t)z)
        fail("mesh too large", "");
    m->points = (point *)grow(m->points, m->num_points, &m->max_points, sizeof *m->points);
    m->points[m->num_points] = (point){ (int32_t)x, (int32_t)y, (int32_t)z };
    return m->num_points++;
}

static void add_face(mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    m->faces = (triangle *)grow(m->faces, m->num_faces, &m->max_faces, sizeof *m->faces);
    m->faces[m->num_faces++] = (triangle){ { a, b, c } };
}

static void add_quad(mesh *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    add_face(m, a, b, c);
    add_face(m, a, c, d);
}

static void free_mesh(mesh *m)
{
    free(m->points);
    free(m->faces);
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        fail("out of memory", "");
    return memory;
}

/* Halfedges 3f + k as in the codec's mesh: from corner k of face f to the next one. */
static uint32_t next(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
static uint32_t prev(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
static uint32_t *corner(mesh *m, uint32_t h) { return &m->faces[h / 3].v[h % 3]; }

/* The opposite of each halfedge of a manifold, NONE at its boundary, through a hash table of the edges' lower and upper
 * vertex. */
static uint32_t *twins(mesh *m)
{
    uint32_t count = 3 * m->num_faces, size = 4;
    while (size < 2 * count)
        size *= 2;
    uint32_t *twin = (uint32_t *)allocate(count, sizeof *twin);
    uint32_t *slot = (uint32_t *)allocate(size, sizeof *slot);
    memset(slot, 0xff, size * sizeof *slot);
    memset(twin, 0xff, count * sizeof *twin);
    for (uint32_t h = 0; h < count; ++h) {
        uint32_t a = *corner(m, h), b = *corner(m, next(h));
        uint32_t i = hash(a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a) & (size - 1);
        while (slot[i] != NONE && (*corner(m, slot[i]) != b || *corner(m, next(slot[i])) != a))
            i = (i + 1) & (size - 1);
        if (slot[i] == NONE) {
            slot[i] = h;
        } else {
            twin[h] = slot[i];
            twin[slot[i]] = h;
        }
    }
    free(slot);
    return twin;
}

/* -- Platonic solids and spheres ----------------------------------------------------------------------------------- */

static void make_tetrahedron(mesh *m, const arguments *a)
{
    (void)a;
    for (int i = 0; i < 4; ++i)
        add_point(m, i & 1 ? UNIT : -UNIT, i & 2 ? UNIT : -UNIT, (i == 1 || i == 2) ? -UNIT : UNIT);
    add_face(m, 0, 1, 3);
    add_face(m, 0, 3, 2);
    add_face(m, 0, 2, 1);
    add_face(m, 1, 2, 3);
}

static void make_octahedron(mesh *m, const arguments *a)
{
    (void)a;
    for (int axis = 0; axis < 3; ++axis)
        for (int sign = 1; sign >= -1; sign -= 2)
            add_point(m, axis == 0 ? sign * UNIT : 0, axis == 1 ? sign * UNIT : 0, axis == 2 ? sign * UNIT : 0);
    for (uint32_t i = 0; i < 8; ++i) {
        uint32_t x = i & 1, y = 2 + (i >> 1 & 1), z = 4 + (i >> 2);
        int mirrored = (i ^ i >> 1 ^ i >> 2) & 1;
        add_face(m, x, mirrored ? z : y, mirrored ? y : z);
    }
}

static void make_icosahedron(mesh *m, const arguments *a)
{
    enum { S = 34453, L = 55747 };  /* 1 : golden ratio, on the unit sphere */
    static const uint8_t face[20][3] = {
        { 0, 8, 4 }, { 0, 2, 8 }, { 0, 9, 2 }, { 0, 6, 9 }, { 0, 4, 6 }, { 4, 1, 6 }, { 4, 10, 1 }, { 4, 8, 10 },
        { 8, 5, 10 }, { 8, 2, 5 }, { 2, 7, 5 }, { 2, 9, 7 }, { 9, 11, 7 }, { 9, 6, 11 }, { 6, 1, 11 }, { 3, 11, 1 },
        { 3, 7, 11 }, { 3, 5, 7 }, { 3, 10, 5 }, { 3, 1, 10 },
    };
    (void)a;
    for (int i = 0; i < 4; ++i)
        add_point(m, 0, i & 1 ? -S : S, i & 2 ? -L : L);
    for (int i = 0; i < 4; ++i)
        add_point(m, i & 1 ? -S : S, i & 2 ? -L : L, 0);
    for (int i = 0; i < 4; ++i)
        add_point(m, i & 2 ? -L : L, 0, i & 1 ? -S : S);
    for (int f = 0; f < 20; ++f)
        add_face(m, face[f][0], face[f][1], face[f][2]);
}

/* A point halfway between a and b, moved out to the unit sphere. */
static uint32_t add_middle(mesh *m, uint32_t a, uint32_t b)
{
    int64_t x = (int64_t)m->points[a].x + m->points[b].x;
    int64_t y = (int64_t)m->points[a].y + m->points[b].y;
    int64_t z = (int64_t)m->points[a].z + m->points[b].z;
    int64_t length = square_root(x * x + y * y + z * z);
    return add_point(m, x * UNIT / length, y * UNIT / length, z * UNIT / length);
}

static uint32_t add_on_sphere(mesh *m, const uint32_t *twin, uint32_t h)
{
    (void)twin;
    return add_middle(m, *corner(m, h), *corner(m, next(h)));
}

/* Each triangle into four; `place` adds the vertex of an edge. */
static void subdivide(mesh *m, uint32_t (*place)(mesh *m, const uint32_t *twin, uint32_t h))
{
    uint32_t count = m->num_faces, *twin = twins(m);
    uint32_t *middle = (uint32_t *)allocate(3 * (size_t)count, sizeof *middle);
    for (uint32_t h = 0; h < 3 * count; ++h)
        middle[h] = twin[h] < h ? middle[twin[h]] : place(m, twin, h);
    for (uint32_t f = 0; f < count; ++f) {
        const triangle t = m->faces[f];
        const uint32_t *mid = &middle[3 * f];
        m->faces[f] = (triangle){ { mid[0], mid[1], mid[2] } };
        for (int k = 0; k < 3; ++k)
            add_face(m, t.v[k], mid[k], mid[(k + 2) % 3]);
    }
    free(middle);
    free(twin);
}

static void make_sphere(mesh *m, const arguments *a)
{
    if (a->n[0] > 12)
        fail("sphere: at most 12 subdivisions", "");
    make_icosahedron(m, a);
    for (uint32_t i = 0; i < a->n[0]; ++i)
        subdivide(m, add_on_sphere);
}

/* -- Sheets: a grid of squares, perhaps closed to a ring in one or both directions --------------------------------- */

typedef enum { OPEN, RING, TWISTED } closing;  /* TWISTED: glued to a ring after half a turn */

typedef point (*placement)(const arguments *a, uint32_t i, uint32_t j);

/* The vertex at column i, row j of a sheet of m x n squares, both of which may be one past the end. */
static uint32_t sheet_vertex(uint32_t i, uint32_t j, uint32_t m, uint32_t n, closing across, closing along)
{
    if (across != OPEN && i == m) {
        i = 0;
        j = across == TWISTED ? n - j : j;
    }
    if (along == RING && j == n)
        j = 0;
    return j * (across == OPEN ? m + 1 : m) + i;
}

static void make_sheet(mesh *s, const arguments *a, closing across, closing along, placement place)
{
    uint32_t m = a->n[0], n = a->n[1];
    if (m > MAX_SIDE || n > MAX_SIDE || (uint64_t)m * n > MAX_COUNT / 2)
        fail("mesh too large", "");
    for (uint32_t j = 0; j < (along == OPEN ? n + 1 : n); ++j)
        for (uint32_t i = 0; i < (across == OPEN ? m + 1 : m); ++i) {
            point p = place(a, i, j);
            add_point(s, p.x, p.y, p.z);
        }
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < m; ++i)
            add_quad(s, sheet_vertex(i, j, m, n, across, along), sheet_vertex(i + 1, j, m, n, across, along),
                     sheet_vertex(i + 1, j + 1, m, n, across, along), sheet_vertex(i, j + 1, m, n, across, along));
}

/* The point at angle i/m and distance r from the axis, at height z. */
static point around_axis(uint32_t i, uint32_t m, int32_t r, int32_t z)
{
    return (point){ scale(r, cosine(i, m)), scale(r, sine(i, m)), z };
}

static point on_torus(const arguments *a, uint32_t i, uint32_t j)
{
    return around_axis(i, a->n[0], 2 * UNIT + cosine(j, a->n[1]), sine(j, a->n[1]));
}

static void make_torus(mesh *m, const arguments *a)
{
    make_sheet(m, a, RING, RING, on_torus);
}

static void make_klein(mesh *m, const arguments *a)
{
    make_sheet(m, a, TWISTED, RING, on_torus);
}

static point on_moebius(const arguments *a, uint32_t i, uint32_t j)
{
    int32_t across = (int32_t)((int64_t)UNIT * j / a->n[1]) - UNIT / 2;
    uint32_t half_turns = 2 * a->n[0];
    return around_axis(i, a->n[0], 2 * UNIT + scale(across, cosine(i, half_turns)), scale(across, sine(i, half_turns)));
}

static void make_moebius(mesh *m, const arguments *a)
{
    make_sheet(m, a, TWISTED, OPEN, on_moebius);
}

static point on_annulus(const arguments *a, uint32_t i, uint32_t j)
{
    return around_axis(i, a->n[0], (int32_t)(2 * UNIT - (int64_t)UNIT * j / a->n[1]), 0);
}

static void make_annulus(mesh *m, const arguments *a)
{
    make_sheet(m, a, RING, OPEN, on_annulus);
}

static point on_cylinder(const arguments *a, uint32_t i, uint32_t j)
{
    return around_axis(i, a->n[0], UNIT, (int32_t)((int64_t)4 * UNIT * j / a->n[1]));
}

/* A fan from a new vertex to the ring first .. first + n - 1, counter-clockwise seen from outside. */
static void add_cap(mesh *m, uint32_t first, uint32_t n, int32_t z, int below)
{
    uint32_t centre = add_point(m, 0, 0, z);
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t a = first + i, b = first + (i + 1) % n;
        add_face(m, below ? b : a, below ? a : b, centre);
    }
}

static void make_cylinder(mesh *m, const arguments *a)
{
    make_sheet(m, a, RING, OPEN, on_cylinder);
    add_cap(m, a->n[0] * a->n[1], a->n[0], 4 * UNIT, 0);
    add_cap(m, 0, a->n[0], 0, 1);
}

static point on_disc(const arguments *a, uint32_t i, uint32_t j)
{
    return around_axis(i, a->n[0], (int32_t)(UNIT - (int64_t)UNIT * j / (a->n[1] + 1)), 0);
}

static void make_disc(mesh *m, const arguments *a)
{
    make_sheet(m, a, RING, OPEN, on_disc);
    add_cap(m, a->n[0] * a->n[1], a->n[0], 0, 0);
}

/* Hills of n[2] hundredths of a square and noise of n[3] hundredths. */
static point on_grid(const arguments *a, uint32_t i, uint32_t j)
{
    const int32_t square = UNIT / 16, height = (int32_t)(a->n[2] % 10000), rough = (int32_t)(a->n[3] % 10000);
    int32_t random = (int32_t)(hash((uint64_t)j << 32 | i) >> 16);
    int64_t z = (int64_t)square * (hills(i, j) / 4 * height + random / 4 * rough) / (UNIT / 4) / 100;
    return (point){ (int32_t)i * square, (int32_t)j * square, (int32_t)z };
}

static void make_grid(mesh *m, const arguments *a)
{
    make_sheet(m, a, OPEN, OPEN, on_grid);
}

/* N x N square holes, no two of which touch. */
static void make_holes(mesh *m, const arguments *a)
{
    uint32_t side = 2 * a->n[0] + 1, kept = 0;
    arguments grid = { { side, side, 0, 0 }, NULL };
    make_grid(m, &grid);
    for (uint32_t f = 0; f < m->num_faces; ++f) {
        uint32_t i = f / 2 % side, j = f / 2 / side;
        if (!(i & j & 1))
            m->faces[kept++] = m->faces[f];
    }
    m->num_faces = kept;
}

/* -- Vertices of large valence ------------------------------------------------------------------------------------- */

static void add_apex_fan(mesh *m, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i) {
        point p = around_axis(i, n, UNIT, 0);
        add_point(m, p.x, p.y, p.z);
    }
    add_cap(m, 0, n, UNIT, 0);
}

static void make_cone(mesh *m, const arguments *a)
{
    add_apex_fan(m, a->n[0]);
}

/* The base is triangulated in zigzag, so that only the apex has a large valence. */
static void make_pyramid(mesh *m, const arguments *a)
{
    uint32_t low = 0, high = a->n[0] - 1;
    add_apex_fan(m, a->n[0]);
    for (int odd = 0; high - low >= 2; odd ^= 1) {
        uint32_t third = odd ? high - 1 : low + 1;
        add_face(m, third, low, high);
        if (odd)
            high = third;
        else
            low = third;
    }
}

/* -- Surfaces of cube sets: any genus ------------------------------------------------------------------------------ */

typedef struct {
    uint32_t size[3];
    int (*solid)(const uint32_t cube[3]);
    uint32_t *vertex;                /* of each corner of the lattice, or NONE */
} cubes;

static int in_ladder(const uint32_t c[3]) { return !((c[0] & 1) && c[1] == 1); }
static int in_sponge(const uint32_t c[3]) { return (c[0] & 1) + (c[1] & 1) + (c[2] & 1) <= 1; }

static int is_solid(const cubes *s, const uint32_t c[3])
{
    return c[0] < s->size[0] && c[1] < s->size[1] && c[2] < s->size[2] && s->solid(c);
}

static uint32_t lattice_vertex(mesh *m, cubes *s, const uint32_t c[3])
{
    uint32_t *v = &s->vertex[((size_t)c[2] * (s->size[1] + 1) + c[1]) * (s->size[0] + 1) + c[0]];
    if (*v == NONE)
        *v = add_point(m, (int64_t)c[0] * (UNIT / 16), (int64_t)c[1] * (UNIT / 16), (int64_t)c[2] * (UNIT / 16));
    return *v;
}

/* The square between a cube and its empty neighbour along an axis, upwards or downwards. */
static void add_side(mesh *m, cubes *s, const uint32_t cube[3], int axis, int up)
{
    uint32_t v[4];
    for (int k = 0; k < 4; ++k) {
        uint32_t c[3] = { cube[0], cube[1], cube[2] };
        c[axis] += (uint32_t)up;
        c[(axis + 1) % 3] += k == 1 || k == 2;
        c[(axis + 2) % 3] += k >= 2;
        v[k] = lattice_vertex(m, s, c);
    }
    if (up)
        add_quad(m, v[0], v[1], v[2], v[3]);
    else
        add_quad(m, v[0], v[3], v[2], v[1]);
}

static void add_sides(mesh *m, cubes *s, const uint32_t cube[3])
{
    for (int axis = 0; axis < 3; ++axis)
        for (int up = 0; up < 2; ++up) {
            uint32_t beside[3] = { cube[0], cube[1], cube[2] };
            beside[axis] += up ? 1u : NONE;  /* NONE: minus one, and beyond the size below 0 */
            if (!is_solid(s, beside))
                add_side(m, s, cube, axis, up);
        }
}

static void make_cubes(mesh *m, uint32_t nx, uint32_t ny, uint32_t nz, int (*solid)(const uint32_t cube[3]))
{
    cubes s = { { nx, ny, nz }, solid, NULL };
    size_t corners = (size_t)(nx + 1) * (ny + 1) * (nz + 1);
    s.vertex = (uint32_t *)allocate(corners, sizeof *s.vertex);
    memset(s.vertex, 0xff, corners * sizeof *s.vertex);
    for (uint32_t z = 0; z < nz; ++z)
        for (uint32_t y = 0; y < ny; ++y)
            for (uint32_t x = 0; x < nx; ++x) {
                const uint32_t cube[3] = { x, y, z };
                if (is_solid(&s, cube))
                    add_sides(m, &s, cube);
            }
    free(s.vertex);
}

static void make_genus(mesh *m, const arguments *a)
{
    make_cubes(m, 2 * a->n[0] + 1, 3, 1, in_ladder);
}

/* The edges of a lattice of N^3 cells, thickened: genus 3 N (N+1)^2 - (N+1)^3 + 1. */
static void make_sponge(mesh *m, const arguments *a)
{
    uint32_t side = 2 * a->n[0] + 1;
    if (a->n[0] > 500)
        fail("sponge: at most 500", "");
    make_cubes(m, side, side, side, in_sponge);
}

/* -- Random manifolds ---------------------------------------------------------------------------------------------- */

typedef struct {
    mesh *m;
    uint32_t *twin;                  /* room for the final number of faces */
    uint64_t counter;                /* of random_below */
} shuffler;

static void link_twins(shuffler *s, uint32_t h, uint32_t t)
{
    s->twin[h] = t;
    s->twin[t] = h;
}

/*        c                    c
 *       / \                 / | \       A new vertex v in the face of h = a -> b. Face (a, b, v) keeps its slot, the
 *      /   \      =>       /  v  \      others are new.
 *     /     \             / /   \ \
 *    a --h-> b           a --h---> b                                                                                 */
static void insert_vertex(shuffler *s, uint32_t h)
{
    mesh *m = s->m;
    uint32_t a = *corner(m, h), b = *corner(m, next(h)), c = *corner(m, prev(h));
    uint32_t bc = s->twin[next(h)], ca = s->twin[prev(h)], g = 3 * m->num_faces;
    const point *p = m->points;
    uint32_t v = add_point(m, ((int64_t)p[a].x + p[b].x + p[c].x) / 3, ((int64_t)p[a].y + p[b].y + p[c].y) / 3,
                           ((int64_t)p[a].z + p[b].z + p[c].z) / 3 + random_below(&s->counter, UNIT / 16));
    *corner(m, prev(h)) = v;
    add_face(m, b, c, v);
    add_face(m, c, a, v);
    link_twins(s, g, bc);
    link_twins(s, g + 3, ca);
    link_twins(s, next(h), g + 2);       /* b v */
    link_twins(s, g + 1, g + 5);         /* c v */
    link_twins(s, g + 4, prev(h));       /* a v */
}

/* Whether an edge joins the origin of h and vertex v. */
static int is_joined(shuffler *s, uint32_t h, uint32_t v)
{
    uint32_t spoke = h;
    do {
        if (*corner(s->m, next(spoke)) == v)
            return 1;
        spoke = s->twin[prev(spoke)];
    } while (spoke != h);
    return 0;
}

/*        c                  c
 *      /   \              / ^ \         Turns the edge h = a -> b into d -> c, unless that edge exists already.
 *     a -h-> b     =>    a  h  b
 *      \   /              \ | /
 *        d                  d                                                                                        */
static void flip_edge(shuffler *s, uint32_t h)
{
    mesh *m = s->m;
    uint32_t t = s->twin[h], c = *corner(m, prev(h)), d = *corner(m, prev(t));
    uint32_t bc = s->twin[next(h)], ca = s->twin[prev(h)], ad = s->twin[next(t)], db = s->twin[prev(t)];
    if (is_joined(s, prev(h), d))
        return;
    *corner(m, prev(h)) = *corner(m, h);
    *corner(m, prev(t)) = *corner(m, t);
    *corner(m, h) = *corner(m, next(t)) = d;
    *corner(m, t) = *corner(m, next(h)) = c;
    link_twins(s, next(h), ca);
    link_twins(s, prev(h), ad);
    link_twins(s, next(t), db);
    link_twins(s, prev(t), bc);
}

/* Removes vertices that no face uses. */
static void drop_unused(mesh *m)
{
    uint32_t *number = (uint32_t *)allocate(m->num_points, sizeof *number), kept = 0;
    for (uint32_t h = 0; h < 3 * m->num_faces; ++h)
        number[*corner(m, h)] = 1;
    for (uint32_t v = 0; v < m->num_points; ++v)
        if (number[v]) {
            m->points[kept] = m->points[v];
            number[v] = kept++;
        }
    for (uint32_t h = 0; h < 3 * m->num_faces; ++h)
        *corner(m, h) = number[*corner(m, h)];
    m->num_points = kept;
    free(number);
}

enum { FACE_GONE = 1, VERTEX_ON_HOLE = 2 };

/* Marks the faces around the origin of h as gone, unless its star touches an older hole. */
static void open_star(shuffler *s, uint32_t h, uint8_t *face, uint8_t *vertex)
{
    uint32_t spoke = h;
    do {
        if (vertex[*corner(s->m, spoke)] || vertex[*corner(s->m, next(spoke))])
            return;
        spoke = s->twin[prev(spoke)];
    } while (spoke != h);
    vertex[*corner(s->m, h)] = VERTEX_ON_HOLE;
    do {
        face[spoke / 3] = FACE_GONE;
        vertex[*corner(s->m, next(spoke))] = VERTEX_ON_HOLE;
        spoke = s->twin[prev(spoke)];
    } while (spoke != h);
}

/* Opens the stars of up to `loops` random vertices that do not touch each other. */
static void open_holes(shuffler *s, uint32_t loops)
{
    mesh *m = s->m;
    uint8_t *face = (uint8_t *)allocate(m->num_faces, 1), *vertex = (uint8_t *)allocate(m->num_points, 1);
    for (uint32_t i = 0; i < loops; ++i)
        open_star(s, random_below(&s->counter, 3 * m->num_faces), face, vertex);
    uint32_t kept = 0;
    for (uint32_t f = 0; f < m->num_faces; ++f)
        if (face[f] != FACE_GONE)
            m->faces[kept++] = m->faces[f];
    m->num_faces = kept;
    drop_unused(m);
    free(face);
    free(vertex);
}

/* Grows a tetrahedron, or a ladder of genus n[2], to n[0] vertices; n[3] holes at most. Three flips a vertex. */
static void make_random(mesh *m, const arguments *a)
{
    arguments genus = { { a->n[2] }, NULL };
    if (a->n[2])
        make_genus(m, &genus);
    else
        make_tetrahedron(m, &genus);
    shuffler s = { m, twins(m), (uint64_t)a->n[1] << 32 };
    uint32_t more = a->n[0] > m->num_points ? a->n[0] - m->num_points : 0;
    s.twin = (uint32_t *)realloc(s.twin, (m->num_faces + 2 * (size_t)more) * 3 * sizeof *s.twin);
    if (!s.twin)
        fail("out of memory", "");
    for (uint32_t i = 0; i < more; ++i) {
        insert_vertex(&s, random_below(&s.counter, 3 * m->num_faces));
        for (int k = 0; k < 3; ++k)
            flip_edge(&s, random_below(&s.counter, 3 * m->num_faces));
    }
    if (a->n[3])
        open_holes(&s, a->n[3]);
    free(s.twin);
}

/* -- Small open meshes and bad ones -------------------------------------------------------------------------------- */

static void make_triangle(mesh *m, const arguments *a)
{
    (void)a;
    add_point(m, 0, 0, 0);
    add_point(m, UNIT, 0, 0);
    add_point(m, 0, UNIT, 0);
    add_face(m, 0, 1, 2);
}

static void make_pillow(mesh *m, const arguments *a)
{
    make_triangle(m, a);
    add_face(m, 0, 2, 1);
}

static void make_book(mesh *m, const arguments *a)
{
    arguments grid = { { 4, 4 }, NULL };
    (void)a;
    make_grid(m, &grid);
    add_face(m, 12, 11, add_point(m, UNIT / 8, UNIT / 8, UNIT));
}

/* Two tetrahedra that share a vertex. */
static void make_bowtie(mesh *m, const arguments *a)
{
    make_tetrahedron(m, a);
    for (uint32_t i = 0; i < 3; ++i)
        add_point(m, m->points[i].x + 2 * UNIT, m->points[i].y + 2 * UNIT, m->points[i].z + 2 * UNIT);
    for (uint32_t f = 0; f < 4; ++f) {
        const triangle t = m->faces[f];
        add_face(m, t.v[0] == 3 ? 3 : t.v[0] + 4, t.v[1] == 3 ? 3 : t.v[1] + 4, t.v[2] == 3 ? 3 : t.v[2] + 4);
    }
}

static void make_flipped(mesh *m, const arguments *a)
{
    make_octahedron(m, a);
    const triangle t = m->faces[5];
    m->faces[5] = (triangle){ { t.v[0], t.v[2], t.v[1] } };
}

static void make_doubled(mesh *m, const arguments *a)
{
    make_octahedron(m, a);
    const triangle t = m->faces[2];
    add_face(m, t.v[0], t.v[1], t.v[2]);
}

static void make_unused(mesh *m, const arguments *a)
{
    make_octahedron(m, a);
    add_point(m, 0, 0, 0);
}

static void make_degenerate(mesh *m, const arguments *a)
{
    make_octahedron(m, a);
    add_face(m, 0, 2, 2);
}

static void make_range(mesh *m, const arguments *a)
{
    make_octahedron(m, a);
    m->faces[6].v[1] = m->num_points;
}

/* -- Subdivided meshes, and quads cut along other diagonals: they change another kind ------------------------------- */

static arguments make_inner(mesh *m, const arguments *a);

/* Adds k times point v to a sum. */
static void add_times(int64_t sum[3], const mesh *m, uint32_t v, int k)
{
    sum[0] += (int64_t)k * m->points[v].x;
    sum[1] += (int64_t)k * m->points[v].y;
    sum[2] += (int64_t)k * m->points[v].z;
}

static uint32_t add_halfway(mesh *m, const uint32_t *twin, uint32_t h)
{
    int64_t sum[3] = { 0, 0, 0 };
    (void)twin;
    add_times(sum, m, *corner(m, h), 1);
    add_times(sum, m, *corner(m, next(h)), 1);
    return add_point(m, sum[0] / 2, sum[1] / 2, sum[2] / 2);
}

/* C. Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987: 3/8 of both ends, 1/8 of both opposite vertices. */
static uint32_t add_smooth(mesh *m, const uint32_t *twin, uint32_t h)
{
    int64_t sum[3] = { 0, 0, 0 };
    if (twin[h] == NONE)
        return add_halfway(m, twin, h);
    add_times(sum, m, *corner(m, h), 3);
    add_times(sum, m, *corner(m, next(h)), 3);
    add_times(sum, m, *corner(m, prev(h)), 1);
    add_times(sum, m, *corner(m, prev(twin[h])), 1);
    return add_point(m, sum[0] / 8, sum[1] / 8, sum[2] / 8);
}

/* Where the old vertices go: 5/8 of themselves and 3/8 of the mean of their neighbours, 7/16 and 9/16 with three of
 * them; at a boundary 3/4 and 1/4 of the mean of the two on it. */
static point *smoothed(mesh *m)
{
    uint32_t *twin = twins(m), *count = (uint32_t *)allocate(m->num_points, sizeof *count);
    int64_t (*sum)[3] = (int64_t (*)[3])allocate(m->num_points, sizeof *sum);
    uint8_t *border = (uint8_t *)allocate(m->num_points, 1);
    point *to = (point *)allocate(m->num_points, sizeof *to);
    for (uint32_t h = 0; h < 3 * m->num_faces; ++h)
        if (twin[h] == NONE)
            border[*corner(m, h)] = border[*corner(m, next(h))] = 1;
    for (uint32_t h = 0; h < 3 * m->num_faces; ++h) {
        const uint32_t a = *corner(m, h), b = *corner(m, next(h));
        if (!border[a] || twin[h] == NONE) {
            add_times(sum[a], m, b, 1);
            ++count[a];
        }
        if (border[b] && twin[h] == NONE) {
            add_times(sum[b], m, a, 1);
            ++count[b];
        }
    }
    for (uint32_t v = 0; v < m->num_points; ++v) {
        const int64_t n = count[v] ? count[v] : 1, own = border[v] ? 12 : n == 3 ? 7 : 10;
        const point *p = &m->points[v];
        to[v].x = (int32_t)((own * n * p->x + (16 - own) * sum[v][0]) / (16 * n));
        to[v].y = (int32_t)((own * n * p->y + (16 - own) * sum[v][1]) / (16 * n));
        to[v].z = (int32_t)((own * n * p->z + (16 - own) * sum[v][2]) / (16 * n));
    }
    free(twin);
    free(count);
    free(sum);
    free(border);
    return to;
}

static void check_times(const arguments *a)
{
    if (a->n[0] > 12)
        fail("at most 12 subdivisions", "");
}

static void make_split(mesh *m, const arguments *a)
{
    check_times(a);
    make_inner(m, a);
    for (uint32_t i = 0; i < a->n[0]; ++i)
        subdivide(m, add_halfway);
}

static void make_loop(mesh *m, const arguments *a)
{
    check_times(a);
    make_inner(m, a);
    for (uint32_t i = 0; i < a->n[0]; ++i) {
        const uint32_t count = m->num_points;
        point *old = smoothed(m);
        subdivide(m, add_smooth);
        memcpy(m->points, old, count * sizeof *old);
        free(old);
    }
}

enum { DIAGONALS_TURNED, DIAGONALS_ALTERNATE, DIAGONALS_RANDOM };

/* Cuts squares, as add_quad makes them, along the other diagonal: all, every other one in a chequerboard, or any. */
static void make_diagonals(mesh *m, const arguments *a)
{
    const arguments inner = make_inner(m, a);
    const uint32_t row = inner.n[0] ? inner.n[0] : 1, mode = a->n[0];
    if (mode > DIAGONALS_RANDOM)
        fail("diagonals: 0, 1 or 2", "");
    for (uint32_t q = 0; q < m->num_faces / 2; ++q) {
        triangle *f = &m->faces[2 * q];
        const uint32_t x = f[0].v[0], y = f[0].v[1], z = f[0].v[2], w = f[1].v[2];
        const uint32_t turn = mode == DIAGONALS_ALTERNATE ? (q % row + q / row) & 1 : mode == DIAGONALS_RANDOM ? hash(q) & 1 : 1;
        if (!turn || f[1].v[0] != x || f[1].v[1] != z)
            continue;
        f[0] = (triangle){ { x, y, w } };
        f[1] = (triangle){ { y, z, w } };
    }
}

/* -- Output -------------------------------------------------------------------------------------------------------- */

/* Writes a decimal number and one more character to s; returns the end. */
static char *put_number(char *s, int64_t n, char after)
{
    char digits[24];
    int count = 0;
    uint64_t rest = n < 0 ? (uint64_t)-n : (uint64_t)n;
    if (n < 0)
        *s++ = '-';
    do
        digits[count++] = (char)('0' + rest % 10);
    while (rest /= 10);
    while (count)
        *s++ = digits[--count];
    *s++ = after;
    return s;
}

static void write_counts(uint32_t points, uint32_t faces)
{
    printf("OFF\n%lu %lu 0\n", (unsigned long)points, (unsigned long)faces);
}

static void write_point(const point *p)
{
    printf("%.9g %.9g %.9g\n", p->x / (double)UNIT, p->y / (double)UNIT, p->z / (double)UNIT);
}

static void write_face(uint32_t a, uint32_t b, uint32_t c)
{
    char line[80], *s = put_number(line, 3, ' ');
    s = put_number(put_number(put_number(s, a, ' '), b, ' '), c, '\n');
    fwrite(line, 1, (size_t)(s - line), stdout);
}

static void write_mesh(const mesh *m)
{
    write_counts(m->num_points, m->num_faces);
    for (uint32_t v = 0; v < m->num_points; ++v)
        write_point(&m->points[v]);
    for (uint32_t f = 0; f < m->num_faces; ++f)
        write_face(m->faces[f].v[0], m->faces[f].v[1], m->faces[f].v[2]);
}

/* A grid of at least V vertices with hills, jitter and random diagonals, valences 4 to 8; whole numbers, no memory. */
static void write_terrain(const arguments *a)
{
    uint32_t side = (uint32_t)square_root(a->n[0]);
    if (side < 2 || side * side < a->n[0])
        ++side;
    write_counts(side * side, 2 * (side - 1) * (side - 1));
    for (uint32_t v = 0; v < side * side; ++v) {
        uint32_t i = v % side, j = v / side, jitter = hash(v);
        char line[80], *s = put_number(line, 16 * i + jitter % 11, ' ');
        s = put_number(s, 16 * j + (jitter >> 8) % 11, ' ');
        s = put_number(s, (hills(i, j) >> 6) + (int32_t)(jitter >> 30), '\n');
        fwrite(line, 1, (size_t)(s - line), stdout);
    }
    for (uint32_t v = 0; v < side * (side - 1); ++v) {
        if (v % side == side - 1)
            continue;
        uint32_t corners[5] = { v, v + 1, v + 1 + side, v + side, v }, turn = hash(~(uint64_t)v) & 1;
        write_face(corners[turn], corners[turn + 1], corners[turn + 2]);
        write_face(corners[turn + 2], corners[(turn + 3) % 4], corners[turn]);
    }
}

/* -- Kinds --------------------------------------------------------------------------------------------------------- */

typedef struct {
    const char *name, *synopsis, *help;
    int required, optional;          /* number arguments */
    uint32_t least[MAX_ARGS];        /* smallest value of each */
    void (*make)(mesh *, const arguments *);
    void (*write)(const arguments *);  /* instead of make: writes the file itself */
} kind;

static void make_components(mesh *m, const arguments *a);

static const kind kinds[] = {
    { "triangle", "", "one triangle", 0, 0, { 0 }, make_triangle, NULL },
    { "pillow", "", "two triangles back to back: valence 2", 0, 0, { 0 }, make_pillow, NULL },
    { "tetrahedron", "", "4 vertices", 0, 0, { 0 }, make_tetrahedron, NULL },
    { "octahedron", "", "6 vertices", 0, 0, { 0 }, make_octahedron, NULL },
    { "icosahedron", "", "12 vertices", 0, 0, { 0 }, make_icosahedron, NULL },
    { "sphere", "N", "icosahedron, each triangle cut into four N times", 1, 0, { 0 }, make_sphere, NULL },
    { "torus", "M N", "M around, N about the tube; every valence 6", 2, 0, { 3, 3 }, make_torus, NULL },
    { "annulus", "M N", "M around, N squares wide; two boundary loops", 2, 0, { 3, 1 }, make_annulus, NULL },
    { "disc", "M N", "M around, N rings and a fan of valence M", 2, 0, { 3, 1 }, make_disc, NULL },
    { "cylinder", "M N", "M around, N high, closed by two fans of valence M", 2, 0, { 3, 1 }, make_cylinder, NULL },
    { "grid", "M N [HILLS [NOISE]]", "M x N squares; heights in hundredths of a square", 2, 2, { 1, 1 }, make_grid,
      NULL },
    { "holes", "N", "square sheet with N x N holes", 1, 0, { 1 }, make_holes, NULL },
    { "cone", "N", "apex of valence N, open at the base", 1, 0, { 3 }, make_cone, NULL },
    { "pyramid", "N", "apex of valence N, closed by a zigzag of triangles", 1, 0, { 3 }, make_pyramid, NULL },
    { "genus", "G", "ladder of cubes with G holes through it", 1, 0, { 0 }, make_genus, NULL },
    { "sponge", "N", "lattice of N^3 cells, genus 3N(N+1)^2 - (N+1)^3 + 1", 1, 0, { 1 }, make_sponge, NULL },
    { "components", "N KIND [ARG...]", "N copies side by side", 1, 0, { 1 }, make_components, NULL },
    { "random", "V SEED [GENUS [LOOPS]]", "random insertions and flips, up to LOOPS holes", 2, 2, { 4, 0 }, make_random,
      NULL },
    { "split", "N KIND [ARG...]", "each triangle cut into four N times, vertices halfway", 1, 0, { 0 }, make_split, NULL },
    { "loop", "N KIND [ARG...]", "the same with Loop's smooth vertices", 1, 0, { 0 }, make_loop, NULL },
    { "diagonals", "D KIND [ARG...]", "squares cut the other way: D = 0 all, 1 in a chequerboard, 2 at random", 1, 0,
      { 0 }, make_diagonals, NULL },
    { "terrain", "V", "large: V vertices or a few more, valences 4 to 8, fast", 1, 0, { 4 }, NULL, write_terrain },
    { "moebius", "M N", "bad: not orientable, one boundary loop", 2, 0, { 3, 1 }, make_moebius, NULL },
    { "klein", "M N", "bad: not orientable, closed", 2, 0, { 3, 3 }, make_klein, NULL },
    { "book", "", "bad: three faces on an edge", 0, 0, { 0 }, make_book, NULL },
    { "bowtie", "", "bad: two fans around a vertex", 0, 0, { 0 }, make_bowtie, NULL },
    { "flipped", "", "bad: one face of an octahedron turned over", 0, 0, { 0 }, make_flipped, NULL },
    { "doubled", "", "bad: one face given twice", 0, 0, { 0 }, make_doubled, NULL },
    { "unused", "", "bad: a vertex in no face", 0, 0, { 0 }, make_unused, NULL },
    { "degenerate", "", "bad: a face with one vertex twice", 0, 0, { 0 }, make_degenerate, NULL },
    { "range", "", "bad: a face with a vertex that does not exist", 0, 0, { 0 }, make_range, NULL },
};

#define NUM_KINDS (sizeof kinds / sizeof kinds[0])

static const kind *find_kind(const char *name)
{
    for (size_t i = 0; i < NUM_KINDS; ++i)
        if (!strcmp(kinds[i].name, name))
            return &kinds[i];
    fail("unknown kind, see meshgen --help", name);
    return NULL;
}

static uint32_t parse_number(const char *text, uint32_t least)
{
    char *end;
    unsigned long n = strtoul(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || n < least || n > MAX_ARG)
        fail("number missing, too small or too large", text);
    return (uint32_t)n;
}

static int changes_another(const kind *k)
{
    return k->make == make_components || k->make == make_split || k->make == make_loop || k->make == make_diagonals;
}

static arguments parse_arguments(const kind *k, char **argv)
{
    arguments a = { { 0 }, NULL };
    int count = 0;
    while (argv[count] && count < k->required + k->optional) {
        a.n[count] = parse_number(argv[count], k->least[count]);
        ++count;
    }
    if (count < k->required)
        fail("arguments missing", k->synopsis);
    a.rest = argv + count;
    if (!changes_another(k) && *a.rest)
        fail("too many arguments", *a.rest);
    return a;
}

/* Largest coordinate of the mesh, either sign. */
static int32_t extent(const mesh *m)
{
    int32_t most = 0;
    for (uint32_t v = 0; v < m->num_points; ++v) {
        const int32_t c[3] = { m->points[v].x, m->points[v].y, m->points[v].z };
        for (int k = 0; k < 3; ++k)
            if (abs(c[k]) > most)
                most = abs(c[k]);
    }
    return most;
}

/* The mesh of the kind in a->rest; returns its arguments. */
static arguments make_inner(mesh *m, const arguments *a)
{
    if (!*a->rest)
        fail("which kind?", "");
    const kind *k = find_kind(*a->rest);
    if (!k->make)
        fail("cannot be changed or repeated", k->name);
    arguments inner = parse_arguments(k, a->rest + 1);
    k->make(m, &inner);
    return inner;
}

/* Copies in a cube of side^3 places, side by side. */
static void make_components(mesh *m, const arguments *a)
{
    mesh one = { 0 };
    make_inner(&one, a);
    uint32_t side = 1;
    while ((uint64_t)side * side * side < a->n[0])
        ++side;
    const int64_t step = (int64_t)extent(&one) * 5 / 2;
    for (uint32_t n = 0; n < a->n[0]; ++n) {
        const int64_t dx = n % side * step, dy = n / side % side * step, dz = n / side / side * step;
        const uint32_t first = m->num_points;
        for (uint32_t v = 0; v < one.num_points; ++v)
            add_point(m, one.points[v].x + dx, one.points[v].y + dy, one.points[v].z + dz);
        for (uint32_t f = 0; f < one.num_faces; ++f)
            add_face(m, one.faces[f].v[0] + first, one.faces[f].v[1] + first, one.faces[f].v[2] + first);
    }
    free_mesh(&one);
}

static void print_kinds(void)
{
    for (size_t i = 0; i < NUM_KINDS; ++i)
        printf("  %-11s %-23s %s\n", kinds[i].name, kinds[i].synopsis, kinds[i].help);
}

static void print_help(void)
{
    puts("usage: meshgen KIND [ARG...] > FILE.off\n"
         "       meshgen --list | --help\n"
         "\n"
         "Writes a test mesh as OFF. The same arguments give the same bytes on every platform.\n"
         "\n"
         "kinds:");
    print_kinds();
}

static void generate(char **argv)
{
    const kind *k = find_kind(argv[0]);
    arguments a = parse_arguments(k, argv + 1);
    mesh m = { 0 };
    if (k->write) {
        k->write(&a);
        return;
    }
    k->make(&m, &a);
    write_mesh(&m);
    free_mesh(&m);
}

int main(int argc, char **argv)
{
    if (argc < 2)
        fail("which kind? see meshgen --help", "");
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))
        print_help();
    else if (!strcmp(argv[1], "--list"))
        print_kinds();
    else
        generate(argv + 1);
    if (fflush(stdout) || ferror(stdout)) {
        perror("meshgen: standard output");
        return 1;
    }
    return 0;
}
