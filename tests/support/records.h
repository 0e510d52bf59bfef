/* What goes into cq_encode against what comes out of cq_decode: the triangles, each as three rows of values in their cyclic
 * order, and the rows of no triangle, as multisets; the maps; and the rows of each mesh on the way. C99 and C++; include
 * conquest.h first. */
#ifndef CQ_TESTS_RECORDS_H
#define CQ_TESTS_RECORDS_H

#include <stdlib.h>
#include <string.h>

enum { ROW_VALUES = CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS };

/* All values of a row, and of a face. */
typedef struct row_record {
    int32_t value[ROW_VALUES];
} row_record;

typedef struct triangle_record {
    row_record corner[3];
    int32_t of_face[CQ_MAX_CHANNELS];
    int32_t material;
} triangle_record;

static inline int compare_row_records(const void *a, const void *b) { return memcmp(a, b, sizeof(row_record)); }
static inline int compare_triangle_records(const void *a, const void *b) { return memcmp(a, b, sizeof(triangle_record)); }

static inline row_record row_of_input(const cq_input *in, cq_index v)
{
    row_record r;
    uint32_t k, c, n = 0;
    memset(&r, 0, sizeof r);
    for (k = 0; k < in->shape.num_channels; ++k)
        for (c = 0; c < in->shape.channel[k].components && in->shape.channel[k].merge != CQ_PER_FACE; ++c)
            r.value[n++] = (int32_t)in->values[k][(size_t)v * in->shape.channel[k].components + c];
    return r;
}

static inline cq_index rows_of_mesh(const cq_decoder *d)
{
    return (cq_index)(d->vertex != NULL ? d->shape.num_rows : d->shape.num_vertices);
}

static inline row_record row_of_output(const cq_decoder *d, cq_index row)
{
    const cq_index rows = rows_of_mesh(d);
    row_record r;
    uint32_t k, c, n = 0;
    memset(&r, 0, sizeof r);
    for (k = 0; k < d->shape.num_channels; ++k) {
        const cq_channel *channel = &d->shape.channel[k];
        cq_value value[CQ_MAX_COMPONENTS];
        if (channel->merge == CQ_PER_FACE) continue;
        if (row < rows) cq_read_rows(d, k, row, 1, value);
        else memcpy(value, d->aside.channel[k] + (size_t)(row - rows) * channel->components, channel->components * sizeof(cq_value));
        for (c = 0; c < channel->components; ++c) r.value[n++] = (int32_t)value[c];
    }
    return r;
}

/* The corners from the least one on. */
static inline void turn_record(triangle_record *t)
{
    int best = 0, k, j;
    triangle_record turned[3];
    for (k = 0; k < 3; ++k) {
        turned[k] = *t;
        for (j = 0; j < 3; ++j) turned[k].corner[j] = t->corner[(k + j) % 3];
        if (memcmp(&turned[k], &turned[best], sizeof *t) < 0) best = k;
    }
    *t = turned[best];
}

static inline triangle_record *triangles_of_input(const cq_input *in)
{
    triangle_record *all = (triangle_record *)calloc(in->shape.num_faces + 1, sizeof *all);
    uint32_t f, k;
    for (f = 0; f < in->shape.num_faces; ++f) {
        for (k = 0; k < 3; ++k) all[f].corner[k] = row_of_input(in, in->indices[3 * f + k]);
        for (k = 0; k < in->shape.num_channels; ++k)
            if (in->shape.channel[k].merge == CQ_PER_FACE) all[f].of_face[k] = (int32_t)in->values[k][f];
        if (in->shape.num_materials > 1) all[f].material = (int32_t)in->materials[f];
        turn_record(&all[f]);
    }
    qsort(all, in->shape.num_faces, sizeof *all, compare_triangle_records);
    return all;
}

/* The material that has a face of the mesh, 0 without any. */
static inline uint32_t material_of_face(const cq_decoder *d, uint32_t f)
{
    cq_index first = 0, count = 0;
    uint32_t m;
    for (m = 0; m < d->shape.num_materials; ++m) {
        cq_material(d, m, &first, &count);
        if (f >= first && f - first < count) return m;
    }
    return 0;
}

/* Triangle f of a complete mesh; those aside follow the others. */
static inline triangle_record triangle_of_output(const cq_decoder *d, uint32_t f)
{
    const int aside = f >= d->mesh.num_faces;
    const uint32_t g = aside ? f - d->mesh.num_faces : f;
    triangle_record t;
    cq_index rows[3];
    uint32_t k;
    memset(&t, 0, sizeof t);
    if (aside) memcpy(rows, d->aside.index + 3 * (size_t)g, sizeof rows);
    else cq_read_triangles(d, (cq_index)f, 1, rows);
    for (k = 0; k < 3; ++k) t.corner[k] = row_of_output(d, rows[k]);
    for (k = 0; k < d->shape.num_channels; ++k)
        if (d->shape.channel[k].merge == CQ_PER_FACE && d->shape.channel[k].kind != CQ_TURNED)
            t.of_face[k] = (int32_t)(aside ? d->aside.channel[k] : d->channel[k])[g];
    t.material = aside && d->aside.material != NULL ? (int32_t)d->aside.material[g] : (int32_t)material_of_face(d, f);
    turn_record(&t);
    return t;
}

/* 1 if all triangles come out that went in, and no other ones. */
static inline int same_triangles(const cq_input *in, const cq_decoder *d)
{
    const uint32_t n = in->shape.num_faces, m = d->mesh.num_faces + d->aside.num_faces;
    triangle_record *a, *b;
    uint32_t f;
    int same;
    if (n != m) return 0;
    a = triangles_of_input(in);
    b = (triangle_record *)calloc(m + 1, sizeof *b);
    for (f = 0; f < m; ++f) b[f] = triangle_of_output(d, f);
    qsort(b, m, sizeof *b, compare_triangle_records);
    same = memcmp(a, b, n * sizeof *a) == 0;
    free(a);
    free(b);
    return same;
}

/* The same for rows that no triangle has. */
static inline int same_unused_rows(const cq_input *in, const cq_decoder *d)
{
    const uint32_t rows = rows_of_mesh(d), most = in->shape.num_vertices + d->aside.num_rows;
    row_record *a = (row_record *)calloc(most + 1, sizeof *a), *b = (row_record *)calloc(most + 1, sizeof *b);
    uint8_t *used = (uint8_t *)calloc(most + 1, 1);
    uint32_t k, n = 0, m = 0;
    int same;
    for (k = 0; k < 3 * in->shape.num_faces; ++k) used[in->indices[k]] = 1;
    for (k = 0; k < in->shape.num_vertices; ++k)
        if (!used[k]) a[n++] = row_of_input(in, (cq_index)k);
    memset(used, 0, most + 1);
    for (k = 0; k < 3 * d->aside.num_faces; ++k)
        if (d->aside.index[k] >= rows) used[d->aside.index[k] - rows] = 1;
    for (k = 0; k < d->aside.num_rows; ++k)
        if (!used[k]) b[m++] = row_of_output(d, (cq_index)(rows + k));
    qsort(a, n, sizeof *a, compare_row_records);
    qsort(b, m, sizeof *b, compare_row_records);
    same = n == m && memcmp(a, b, n * sizeof *a) == 0;
    free(a);
    free(b);
    free(used);
    return same;
}

/* Maps lead to rows with the same values, and to the same triangles. */
static inline int maps_are_right(const cq_input *in, const cq_decoder *d, const cq_index *map, const cq_index *face_map)
{
    uint32_t k, j;
    for (k = 0; k < in->shape.num_vertices; ++k) {
        const row_record a = row_of_input(in, (cq_index)k), b = row_of_output(d, map[k]);
        if (memcmp(&a, &b, sizeof a) != 0) return 0;
    }
    for (k = 0; k < in->shape.num_faces; ++k) {
        triangle_record t, u;
        memset(&t, 0, sizeof t);
        for (j = 0; j < 3; ++j) t.corner[j] = row_of_input(in, in->indices[3 * k + j]);
        for (j = 0; j < in->shape.num_channels; ++j)
            if (in->shape.channel[j].merge == CQ_PER_FACE) t.of_face[j] = (int32_t)in->values[j][k];
        if (in->shape.num_materials > 1) t.material = (int32_t)in->materials[k];
        turn_record(&t);
        if (face_map[k] >= d->mesh.num_faces + d->aside.num_faces) return 0;
        u = triangle_of_output(d, face_map[k]);
        if (memcmp(&t, &u, sizeof t) != 0) return 0;
    }
    return 1;
}

/* Materials leave gaps until all is there. */
static inline int face_is_there(const cq_decoder *d, uint32_t f)
{
    const cq_index v = d->mesh.origin[3 * f];
    return v != CQ_NONE && !(d->mesh.is_partial && v >= d->mesh.num_vertices);
}

/* A face is there if and only if it is one of those that are told of its material; these fill their ranges from the start, and
 * the ranges all numbers. */
static inline int materials_are_valid(const cq_decoder *d)
{
    uint32_t f = 0, m;
    for (m = 0; m < d->shape.num_materials; ++m) {
        cq_index first, count, next = (cq_index)d->shape.num_faces;
        cq_material(d, m, &first, &count);
        if (m + 1 < d->shape.num_materials) {
            cq_index unused;
            cq_material(d, m + 1, &next, &unused);
        }
        if (first != f || count > next - first) return 0;
        for (; f < next; ++f)
            if (face_is_there(d, f) != (f < (uint32_t)first + count)) return 0;
    }
    return 1;
}

/* An edge of the input that two triangles have, by the positions of its ends; the second end of each is that of the edge. */
typedef struct shared_edge {
    int32_t place[6];    /* positions, the smaller one first */
    uint32_t face, corner, turned;
} shared_edge;

static inline int compare_shared_edges(const void *a, const void *b) { return memcmp(a, b, 6 * sizeof(int32_t)); }

static inline shared_edge edge_of_input(const cq_input *in, uint32_t f, uint32_t k)
{
    const cq_value *x = in->values[0] + 3 * in->indices[3 * f + k], *y = in->values[0] + 3 * in->indices[3 * f + (k + 1) % 3];
    shared_edge e;
    uint32_t j;
    e.face = f;
    e.corner = k;
    e.turned = 0;
    for (j = 0; j < 3 && x[j] == y[j]; ++j) {}
    if (j < 3 && x[j] > y[j]) e.turned = 1;
    for (j = 0; j < 3; ++j) {
        e.place[j] = (int32_t)(e.turned ? y : x)[j];
        e.place[3 + j] = (int32_t)(e.turned ? x : y)[j];
    }
    return e;
}

/* Mesh vertex of a decoded corner that has the values of an input corner. */
static inline cq_index vertex_at(const cq_input *in, const cq_decoder *d, cq_index face, cq_index row)
{
    const row_record wanted = row_of_input(in, row);
    uint32_t k;
    for (k = 0; k < 3; ++k) {
        const row_record found = row_of_output(d, d->index[3 * face + k]);
        if (memcmp(&found, &wanted, sizeof found) == 0) return d->mesh.origin[3 * face + k];
    }
    return CQ_NONE;
}

/* In a complete mesh without edges of more than two faces, those that two triangles of the input share by position have both
 * sides on the same two mesh vertices: nowhere can they come apart. Channel 0 has positions. Returns how many edges there are,
 * or 0 if one is open. */
static inline uint32_t shared_edges(const cq_input *in, const cq_decoder *d, const cq_index *face_map)
{
    const uint32_t n = 3 * in->shape.num_faces;
    shared_edge *e = (shared_edge *)calloc(n + 1u, sizeof *e);
    uint32_t k, shared = 0, open = 0;
    for (k = 0; k < n; ++k) e[k] = edge_of_input(in, k / 3, k % 3);
    qsort(e, n, sizeof *e, compare_shared_edges);
    for (k = 0; k + 1 < n; ++k) {
        const int before = k > 0 && compare_shared_edges(&e[k - 1], &e[k]) == 0, after = k + 2 < n && compare_shared_edges(&e[k + 2], &e[k]) == 0;
        cq_index at[4];
        uint32_t j;
        if (compare_shared_edges(&e[k], &e[k + 1]) != 0 || before || after) continue;
        for (j = 0; j < 4; ++j) {
            const shared_edge *s = &e[k + j / 2];
            const uint32_t corner = (s->corner + (j + s->turned) % 2) % 3;
            if (face_map[s->face] >= d->mesh.num_faces) break;
            at[j] = vertex_at(in, d, face_map[s->face], in->indices[3 * s->face + corner]);
        }
        if (j < 4) continue; /* a face aside */
        ++shared;
        open += at[0] == CQ_NONE || at[0] != at[2] || at[1] != at[3];
    }
    free(e);
    return open ? 0 : shared;
}

/* Corners with one row have one vertex, which is the row's; and each row has a corner. */
static inline int rows_are_valid(const cq_decoder *d)
{
    uint8_t *used;
    uint32_t h, n = 0;
    if (d->vertex == NULL) return d->index == d->mesh.origin;
    used = (uint8_t *)calloc(d->num_rows + 1u, 1);
    for (h = 0; h < 3 * (uint32_t)d->mesh.num_faces; ++h) {
        const cq_index row = d->index[h];
        if (!face_is_there(d, h / 3)) continue;
        if (row >= d->num_rows || d->vertex[row] != d->mesh.origin[h]) break;
        n += !used[row];
        used[row] = 1;
    }
    free(used);
    return h == 3 * (uint32_t)d->mesh.num_faces && n == d->num_rows;
}

/* With seams a split takes three steps, each corner and row of the base two, and each channel of a row one; what is aside
 * takes one for each channel of a row, each face and each byte. */
static inline uint64_t most_calls_for_rows(const cq_shape *s)
{
    uint64_t n = s->num_aside_rows * (s->num_channels + (uint64_t)1) + s->num_aside_faces + s->metadata_bytes + 2;
    if (s->num_rows) n += 3 * (uint64_t)s->num_vertices + 6 * (uint64_t)s->num_faces + 2 * (uint64_t)s->num_boundary_edges;
    if (s->num_rows) n += s->num_rows * (s->num_channels + (uint64_t)2);
    return n;
}

#endif
