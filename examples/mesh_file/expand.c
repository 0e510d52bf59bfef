/* expand.c - from values of corners to vertices that have all of them. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <stdlib.h>
#include <string.h>

/* -- Equal rows ---------------------------------------------------------------------------------------------------- */

static uint32_t hash_bytes(const uint8_t *data, size_t bytes)
{
    uint32_t hash = 0;
    for (size_t i = 0; i < bytes; i++) {
        hash = (hash ^ data[i]) * 0x9e3779b1u;
        hash ^= hash >> 15;
    }
    return hash;
}

/* The first row in the table that is equal to this one, which otherwise goes there. */
static uint32_t find_or_add(const uint8_t *rows, size_t bytes, uint32_t *table, size_t mask, uint32_t row)
{
    size_t slot = hash_bytes(rows + bytes * row, bytes) & mask;
    while (table[slot] != MESH_NONE && memcmp(rows + bytes * table[slot], rows + bytes * row, bytes) != 0)
        slot = (slot + 1) & mask;
    if (table[slot] == MESH_NONE)
        table[slot] = row;
    return table[slot];
}

/* The table is at most half full. */
uint32_t *mesh_first_equal(const void *rows, size_t count, size_t bytes)
{
    size_t slots = 2;
    while (slots < 2 * count)
        slots *= 2;
    uint32_t *first = count < MESH_NONE ? malloc((count + 1) * sizeof *first) : NULL;
    uint32_t *table = slots <= SIZE_MAX / sizeof *table ? malloc(slots * sizeof *table) : NULL;
    if (first == NULL || table == NULL) {
        free(first);
        free(table);
        return NULL;
    }
    memset(table, 0xff, slots * sizeof *table);
    for (size_t i = 0; i < count; i++)
        first[i] = find_or_add(rows, bytes, table, slots - 1, (uint32_t)i);
    free(table);
    return first;
}

/* -- Which vertex each corner gets --------------------------------------------------------------------------------- */

/* What a corner has: the vertex, and of each attribute the first item with the same value. */
struct corner_key {
    uint32_t vertex, item[MESH_NUM_ATTRIBUTES];
};

struct expansion {
    struct corner_key *key;            /* of corners */
    uint32_t *first;                   /* of corners: the first one that has the same */
    uint32_t *source;                  /* of vertices: a corner that has what the vertex gets, MESH_NONE: no corner */
    uint32_t *number;                  /* of vertices: which one of the mesh each is a copy of */
    size_t num_vertices;
};

/* Items are equal if their numbers are; 0 and -0 are. */
static int add_items(struct expansion *x, struct mesh_file *mesh, int attribute)
{
    struct mesh_values *a = &mesh->attribute[attribute];
    if (a->corner == NULL)
        return 1;
    for (size_t i = 0; i < (size_t)a->components * a->count; i++)
        a->values[i] += 0.0f;
    uint32_t *first = mesh_first_equal(a->values, a->count, (size_t)a->components * sizeof *a->values);
    for (size_t c = 0; c < 3 * (size_t)mesh->num_faces && first != NULL; c++)
        x->key[c].item[attribute] = a->corner[c] != MESH_NONE ? first[a->corner[c]] : MESH_NONE;
    free(first);
    return first != NULL;
}

static int find_keys(struct expansion *x, struct mesh_file *mesh)
{
    size_t corners = 3 * (size_t)mesh->num_faces;
    int ok = (x->key = calloc(corners + 1, sizeof *x->key)) != NULL;
    for (size_t c = 0; c < corners && ok; c++)
        x->key[c].vertex = mesh->indices[c];
    for (int a = 0; a < MESH_NUM_ATTRIBUTES && ok; a++)
        ok = add_items(x, mesh, a);
    return ok && (x->first = mesh_first_equal(x->key, corners, sizeof *x->key)) != NULL;
}

/* The vertex of a corner that is the first of its kind: the one of the mesh, or if that has other values, a new one. */
static uint32_t vertex_of_first(struct expansion *x, uint32_t corner)
{
    uint32_t vertex = x->key[corner].vertex, copy = (uint32_t)x->num_vertices;
    if (x->source[vertex] == MESH_NONE) {
        x->source[vertex] = corner;
        return vertex;
    }
    x->source[copy] = corner;
    x->number[copy] = vertex;
    x->num_vertices++;
    return copy;
}

static int number_vertices(struct expansion *x, struct mesh_file *mesh)
{
    size_t corners = 3 * (size_t)mesh->num_faces, most = mesh->num_vertices + corners;
    x->num_vertices = mesh->num_vertices;
    x->source = malloc((most + 1) * sizeof *x->source);
    x->number = malloc((most + 1) * sizeof *x->number);
    if (x->source == NULL || x->number == NULL || most >= MESH_NONE)
        return 0;
    memset(x->source, 0xff, (most + 1) * sizeof *x->source);
    for (uint32_t v = 0; v < mesh->num_vertices; v++)
        x->number[v] = v;
    for (uint32_t c = 0; c < corners; c++)
        mesh->indices[c] = x->first[c] == c ? vertex_of_first(x, c) : mesh->indices[x->first[c]];
    return 1;
}

/* -- Their values -------------------------------------------------------------------------------------------------- */

static int expand_positions(const struct expansion *x, struct mesh_file *mesh)
{
    double *positions = realloc(mesh->positions, (x->num_vertices + 1) * 3 * sizeof *positions);
    if (positions == NULL)
        return 0;
    mesh->positions = positions;
    for (size_t v = mesh->num_vertices; v < x->num_vertices; v++)
        memcpy(&positions[3 * v], &positions[3 * (size_t)x->number[v]], 3 * sizeof *positions);
    return 1;
}

/* The item of a vertex; MESH_NONE if it has none. */
static uint32_t item_of_vertex(const struct expansion *x, const struct mesh_values *a, size_t vertex)
{
    if (a->corner == NULL)
        return x->number[vertex];
    return x->source[vertex] != MESH_NONE ? a->corner[x->source[vertex]] : MESH_NONE;
}

static int expand_attribute(const struct expansion *x, struct mesh_values *a, enum mesh_attribute attribute)
{
    size_t components = (size_t)a->components;
    float *values = calloc((x->num_vertices + 1) * components, sizeof *values);
    for (size_t v = 0; v < x->num_vertices && values != NULL; v++) {
        uint32_t item = item_of_vertex(x, a, v);
        if (item != MESH_NONE)
            memcpy(values + components * v, a->values + components * item, components * sizeof *values);
        else if (attribute == MESH_NORMALS)
            values[components * v + 2] = 1;
    }
    free(a->values);
    free(a->corner);
    a->corner = NULL;
    a->values = values;
    a->count = (uint32_t)x->num_vertices;
    return values != NULL;
}

static int expand_values(struct expansion *x, struct mesh_file *mesh)
{
    int ok = expand_positions(x, mesh);
    for (int a = 0; a < MESH_NUM_ATTRIBUTES && ok; a++)
        ok = mesh->attribute[a].values == NULL || expand_attribute(x, &mesh->attribute[a], (enum mesh_attribute)a);
    for (size_t v = 0; v < x->num_vertices && mesh->number != NULL; v++)
        x->number[v] = mesh->number[x->number[v]];
    free(mesh->number);
    mesh->number = x->number;
    x->number = NULL;
    mesh->num_vertices = (uint32_t)x->num_vertices;
    return ok;
}

static void drop_others(struct mesh_file *mesh, unsigned attributes)
{
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
        if ((attributes >> a & 1) != 0)
            continue;
        free(mesh->attribute[a].values);
        free(mesh->attribute[a].corner);
        memset(&mesh->attribute[a], 0, sizeof mesh->attribute[a]);
    }
    for (size_t f = 0; f < mesh->num_faces && mesh->marks != NULL; f++)
        mesh->marks[f] &= (uint8_t)(attributes | MESH_LINE | MESH_POINT);
}

static int has_values_of_corners(const struct mesh_file *mesh)
{
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++)
        if (mesh->attribute[a].corner != NULL)
            return 1;
    return 0;
}

int mesh_expand(struct mesh_file *mesh, unsigned attributes)
{
    struct expansion x = { 0 };
    drop_others(mesh, attributes);
    if (!has_values_of_corners(mesh))
        return 1;
    int ok = find_keys(&x, mesh) && number_vertices(&x, mesh) && expand_values(&x, mesh);
    free(x.key);
    free(x.first);
    free(x.source);
    free(x.number);
    return ok;
}
