/* view.c - a decoded mesh as a mesh file. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

int find_channel(const cq_shape *shape, cq_kind kind, int per_face)
{
    for (uint32_t k = 0; k < shape->num_channels; k++)
        if (shape->channel[k].kind == kind && (shape->channel[k].merge == CQ_PER_FACE) == per_face)
            return (int)k;
    return -1;
}

/* -- Rows and faces of the mesh, and behind them those aside ------------------------------------------------------- */

uint32_t count_rows(const cq_decoder *d)
{
    return d->num_rows + d->aside.num_rows;
}

/* Those of the mesh that are there: a range for each material. */
static uint32_t count_mesh_faces(const cq_decoder *d)
{
    uint32_t faces = 0, m = 0;
    cq_index first, count;
    do {
        cq_material(d, m, &first, &count);
        faces += count;
    } while (++m < d->shape.num_materials);
    return faces;
}

uint32_t count_faces(const cq_decoder *d)
{
    return count_mesh_faces(d) + d->aside.num_faces;
}

/* Number of a face in the mesh, if they are counted material after material; and its material. */
static cq_index find_face(const cq_decoder *d, uint32_t face, uint32_t *material)
{
    cq_index first, count;
    *material = 0;
    for (;; ++*material, face -= count) {
        cq_material(d, *material, &first, &count);
        if (face < count)
            return first + face;
    }
}

cq_value *read_rows(const cq_decoder *d, uint32_t k)
{
    size_t components = d->shape.channel[k].components, aside = d->aside.num_rows;
    cq_value *values = malloc(((size_t)count_rows(d) + 1) * components * sizeof *values);
    if (values == NULL)
        return NULL;
    cq_read_rows(d, k, 0, d->num_rows, values);
    if (aside > 0)
        memcpy(values + components * d->num_rows, d->aside.channel[k], components * aside * sizeof *values);
    return values;
}

cq_value face_value(const cq_decoder *d, uint32_t k, uint32_t face)
{
    uint32_t faces = count_mesh_faces(d), material;
    return face < faces ? d->channel[k][find_face(d, face, &material)] : d->aside.channel[k][face - faces];
}

uint32_t face_material(const cq_decoder *d, uint32_t face)
{
    uint32_t faces = count_mesh_faces(d), material;
    if (d->shape.num_materials == 0)
        return 0;
    if (face >= faces)
        return d->aside.material[face - faces];
    find_face(d, face, &material);
    return material;
}

cq_index *read_triangles(const cq_decoder *d)
{
    size_t corners = 3 * (size_t)count_mesh_faces(d), aside = 3 * (size_t)d->aside.num_faces;
    cq_index *index = malloc((corners + aside + 1) * sizeof *index);
    if (index == NULL)
        return NULL;
    cq_index *to = index, first, count;
    uint32_t m = 0;
    do {
        cq_material(d, m, &first, &count);
        cq_read_triangles(d, first, count, to);
        to += 3 * (size_t)count;
    } while (++m < d->shape.num_materials);
    if (aside > 0)
        memcpy(index + corners, d->aside.index, aside * sizeof *index);
    return index;
}

/* -- Vertices of the file: those of the mesh, and a row aside has one of its own ----------------------------------- */

struct view {
    const cq_decoder *d;
    struct mesh_file *mesh;
    uint32_t rows;
    uint32_t *index;                   /* uint32_t[3 * faces] */
    uint32_t *vertex;                  /* of rows, in the file */
};

struct numbered {
    uint32_t number, item;
};

static int compare_numbered(const void *a, const void *b)
{
    const struct numbered *s = a, *t = b;
    if (s->number != t->number)
        return s->number < t->number ? -1 : 1;
    return (s->item > t->item) - (s->item < t->item);
}

static uint32_t vertex_of_row(const cq_decoder *d, uint32_t row)
{
    if (row >= d->num_rows)
        return d->mesh.num_vertices + (row - d->num_rows);
    return d->vertex != NULL ? d->vertex[row] : row;
}

static void take_vertices(struct view *v)
{
    v->mesh->num_vertices = v->d->mesh.num_vertices + v->d->aside.num_rows;
    for (uint32_t row = 0; row < v->rows; row++)
        v->vertex[row] = vertex_of_row(v->d, row);
}

/* Rows with the same number were one vertex of the file; vertices have the order of their numbers. */
static int sort_vertices(struct view *v, uint32_t channel)
{
    cq_value *number = read_rows(v->d, channel);
    struct numbered *order = malloc(((size_t)v->rows + 1) * sizeof *order);
    int ok = number != NULL && order != NULL;
    for (uint32_t i = 0; i < v->rows && ok; i++) {
        order[i].number = (uint32_t)number[i];
        order[i].item = i;
    }
    if (ok)
        qsort(order, v->rows, sizeof *order, compare_numbered);
    for (uint32_t i = 0; i < v->rows && ok; i++) {
        v->mesh->num_vertices += i == 0 || order[i].number != order[i - 1].number;
        v->vertex[order[i].item] = v->mesh->num_vertices - 1;
    }
    free(number);
    free(order);
    return ok;
}

static int number_vertices(struct view *v)
{
    int channel = find_channel(&v->d->shape, CQ_NUMBER, 0);
    v->vertex = malloc(((size_t)v->rows + 1) * sizeof *v->vertex);
    if (v->vertex == NULL)
        return 0;
    if (channel >= 0)
        return sort_vertices(v, (uint32_t)channel);
    take_vertices(v);
    return 1;
}

static int add_positions_of_rows(struct view *v)
{
    int channel = find_channel(&v->d->shape, CQ_POSITION, 0);
    v->mesh->positions = calloc((size_t)v->mesh->num_vertices + 1, 3 * sizeof *v->mesh->positions);
    if (channel < 0 || v->mesh->positions == NULL)
        return v->mesh->positions != NULL;
    cq_value *values = read_rows(v->d, (uint32_t)channel);
    double *positions = values != NULL ? reconstruct_positions(&v->d->shape.channel[channel], values, v->rows) : NULL;
    for (size_t row = 0; row < v->rows && positions != NULL; row++)
        memcpy(&v->mesh->positions[3 * (size_t)v->vertex[row]], &positions[3 * row], 3 * sizeof *positions);
    int ok = positions != NULL;
    free(values);
    free(positions);
    return ok;
}

static int add_indices(struct view *v)
{
    size_t corners = 3 * (size_t)count_faces(v->d);
    v->mesh->num_faces = count_faces(v->d);
    v->mesh->indices = malloc((corners + 1) * sizeof *v->mesh->indices);
    for (size_t c = 0; c < corners && v->mesh->indices != NULL; c++)
        v->mesh->indices[c] = v->vertex[v->index[c]];
    return v->mesh->indices != NULL;
}

/* -- Attributes: of vertices if each has one row, else of corners -------------------------------------------------- */

static const cq_kind kind_of_attribute[MESH_NUM_ATTRIBUTES] = { CQ_NORMAL, CQ_TEXCOORD, CQ_COLOR };

/* What an exact channel holds may be no number, and colors may be beyond their range. */
static void sanitize(float *numbers, size_t count, float low, float high)
{
    for (size_t i = 0; i < count; i++)
        numbers[i] = numbers[i] >= low ? numbers[i] <= high ? numbers[i] : high : low;
}

/* float[rows][components], or two numbers to the three of a normal. NULL: no memory. */
static float *reconstruct(const struct view *v, uint32_t k)
{
    const cq_channel *c = &v->d->shape.channel[k];
    size_t components = c->kind == CQ_NORMAL ? 3 : c->components;
    cq_value *values = read_rows(v->d, k);
    float *numbers = malloc(((size_t)v->rows + 1) * components * sizeof *numbers);
    int ok = values != NULL && numbers != NULL;
    if (ok && c->kind == CQ_NORMAL && c->components == 2)
        cq_reconstruct_normals(c->bits, values, v->rows, numbers);
    else if (ok)
        cq_reconstruct(c, values, v->rows, numbers);
    if (ok && c->kind == CQ_COLOR)
        sanitize(numbers, v->rows * components, 0, 1);
    else if (ok && c->bits == CQ_EXACT_BITS)
        sanitize(numbers, v->rows * components, -FLT_MAX, FLT_MAX);
    free(values);
    if (!ok)
        free(numbers);
    return ok ? numbers : NULL;
}

/* The values of vertices from those of their rows. */
static int attach(const struct view *v, struct mesh_values *a)
{
    size_t components = (size_t)a->components;
    float *sorted = malloc(((size_t)v->rows + 1) * components * sizeof *sorted);
    for (size_t row = 0; row < v->rows && sorted != NULL; row++)
        memcpy(sorted + components * v->vertex[row], a->values + components * row, components * sizeof *sorted);
    free(a->values);
    a->values = sorted;
    return sorted != NULL;
}

static int name_corners(const struct view *v, struct mesh_values *a)
{
    size_t corners = 3 * (size_t)v->mesh->num_faces;
    a->corner = malloc((corners + 1) * sizeof *a->corner);
    if (a->corner != NULL)
        memcpy(a->corner, v->index, corners * sizeof *a->corner);
    return a->corner != NULL;
}

static int add_attributes(const struct view *v)
{
    int ok = 1;
    for (int k = 0; k < MESH_NUM_ATTRIBUTES && ok; k++) {
        struct mesh_values *a = &v->mesh->attribute[k];
        int channel = find_channel(&v->d->shape, kind_of_attribute[k], 0);
        if (channel < 0)
            continue;
        a->components = k == MESH_NORMALS ? 3 : v->d->shape.channel[channel].components;
        a->count = v->rows;
        a->values = reconstruct(v, (uint32_t)channel);
        ok = a->values != NULL && (v->mesh->num_vertices == v->rows ? attach(v, a) : name_corners(v, a));
    }
    return ok;
}

/* -- Labels of faces ----------------------------------------------------------------------------------------------- */

static uint32_t count_lines(const char *text)
{
    uint32_t lines = 0;
    for (; text != NULL && *text != '\0'; text++)
        lines += *text == '\n';
    return lines;
}

/* As many names as there have to be; where the stream tells none, by number. */
static int complete_names(struct mesh_labels *labels)
{
    size_t used = labels->names != NULL ? strlen(labels->names) : 0;
    for (uint32_t i = count_lines(labels->names); i < labels->count; i++) {
        char *longer = realloc(labels->names, used + 64);
        if (longer == NULL)
            return 0;
        labels->names = longer;
        used += (size_t)snprintf(longer + used, 64, "material_%lu\n", i + 1ul);
    }
    return 1;
}

static uint32_t *new_face_numbers(const struct view *v)
{
    return calloc((size_t)v->mesh->num_faces + 1, sizeof(uint32_t));
}

static void take_names(struct mesh_labels *labels, char **names)
{
    labels->names = *names;
    *names = NULL;
}

static uint32_t largest_number(const struct view *v, uint32_t channel)
{
    uint32_t largest = 0;
    for (uint32_t f = 0; f < v->mesh->num_faces; f++) {
        uint32_t number = (uint32_t)face_value(v->d, channel, f);
        largest = number > largest ? number : largest;
    }
    return largest;
}

/* A number without a name is none, if there are names. */
static int add_materials(const struct view *v, struct words *words)
{
    enum { MAX_WITHOUT_NAMES = 65536 };
    struct mesh_labels *materials = &v->mesh->label[MESH_MATERIALS];
    int channel = find_channel(&v->d->shape, CQ_GROUP, 1), ranges = v->d->shape.num_materials > 0;
    if (channel < 0 && !ranges && words->names[MESH_MATERIALS] == NULL)
        return 1;
    take_names(materials, &words->names[MESH_MATERIALS]);
    materials->count = count_lines(materials->names);
    if (materials->names == NULL && ranges)
        materials->count = v->d->shape.num_materials;
    else if (materials->names == NULL && v->mesh->num_faces > 0)
        materials->count = largest_number(v, (uint32_t)channel) % MAX_WITHOUT_NAMES + 1;
    materials->of_face = new_face_numbers(v);
    for (uint32_t f = 0; f < v->mesh->num_faces && materials->of_face != NULL; f++) {
        uint32_t number = ranges || channel < 0 ? face_material(v->d, f) : (uint32_t)face_value(v->d, (uint32_t)channel, f);
        materials->of_face[f] = number < materials->count ? number + 1 : 0;
    }
    return materials->of_face != NULL && complete_names(materials);
}

/* The channel of a kind of face numbers, -1: none. */
static int channel_of(const cq_decoder *d, const struct words *words, int kind)
{
    int place = words->channel[kind];
    for (uint32_t k = 0; k < d->shape.num_channels && place > 0; k++)
        if (d->shape.channel[k].kind == CQ_GENERIC && d->shape.channel[k].merge == CQ_PER_FACE && --place == 0)
            return (int)k;
    return -1;
}

/* Numbers without a name are none. */
static int view_label(const struct view *v, struct words *words, int kind)
{
    struct mesh_labels *labels = &v->mesh->label[kind];
    int channel = channel_of(v->d, words, kind);
    take_names(labels, &words->names[kind]);
    labels->count = count_lines(labels->names);
    if (labels->count == 0)
        return 1;
    labels->of_face = new_face_numbers(v);
    for (uint32_t f = 0; f < v->mesh->num_faces && labels->of_face != NULL; f++) {
        uint32_t number = channel < 0 ? 1 : (uint32_t)face_value(v->d, (uint32_t)channel, f);
        labels->of_face[f] = number <= labels->count ? number : 0;
    }
    return labels->of_face != NULL;
}

static int add_marks(const struct view *v, const struct words *words)
{
    int channel = channel_of(v->d, words, FACE_MARKS);
    if (channel < 0)
        return 1;
    v->mesh->marks = calloc((size_t)v->mesh->num_faces + 1, 1);
    for (uint32_t f = 0; f < v->mesh->num_faces && v->mesh->marks != NULL; f++)
        v->mesh->marks[f] = (uint8_t)face_value(v->d, (uint32_t)channel, f);
    return v->mesh->marks != NULL;
}

static int view_labels(const struct view *v, struct words *words)
{
    v->mesh->libraries = words->libraries;
    words->libraries = NULL;
    return add_materials(v, words) && view_label(v, words, FACE_GROUP) && view_label(v, words, FACE_OBJECT)
           && add_marks(v, words);
}

/* -- The order of faces -------------------------------------------------------------------------------------------- */

/* Rows of so many bytes, row order[i].item first i = 0, then 1, ... NULL: no memory. */
static int reorder(void **rows, size_t bytes, const struct numbered *order, size_t count)
{
    if (*rows == NULL)
        return 1;
    char *sorted = malloc((count + 1) * bytes);
    if (sorted == NULL)
        return 0;
    for (size_t i = 0; i < count; i++)
        memcpy(sorted + bytes * i, (char *)*rows + bytes * order[i].item, bytes);
    free(*rows);
    *rows = sorted;
    return 1;
}

static int reorder_u32(uint32_t **rows, size_t columns, const struct numbered *order, size_t count)
{
    void *moved = *rows;
    int ok = reorder(&moved, columns * sizeof **rows, order, count);
    *rows = moved;
    return ok;
}

static int reorder_faces(struct mesh_file *mesh, const struct numbered *order)
{
    void *marks = mesh->marks;
    int ok = reorder_u32(&mesh->indices, 3, order, mesh->num_faces) && reorder(&marks, 1, order, mesh->num_faces);
    mesh->marks = marks;
    for (int a = 0; a < MESH_NUM_ATTRIBUTES && ok; a++)
        ok = reorder_u32(&mesh->attribute[a].corner, 3, order, mesh->num_faces);
    for (int k = 0; k < MESH_NUM_LABELS && ok; k++)
        ok = reorder_u32(&mesh->label[k].of_face, 1, order, mesh->num_faces);
    return ok;
}

/* By material, those without first, so that few lines of OBJ name them; then by group or object. */
static int sort_faces(struct mesh_file *mesh)
{
    struct numbered *order = malloc(((size_t)mesh->num_faces + 1) * sizeof *order);
    int ok = order != NULL;
    static const enum mesh_label by[MESH_NUM_LABELS] = { MESH_OBJECTS, MESH_GROUPS, MESH_MATERIALS };
    for (int k = 0; k < MESH_NUM_LABELS && ok; k++) {
        const uint32_t *of_face = mesh->label[by[k]].of_face;
        if (of_face == NULL)
            continue;
        for (uint32_t f = 0; f < mesh->num_faces; f++) {
            order[f].number = of_face[f];
            order[f].item = f;
        }
        qsort(order, mesh->num_faces, sizeof *order, compare_numbered);
        ok = reorder_faces(mesh, order);
    }
    free(order);
    return ok;
}

/* -- All of it ----------------------------------------------------------------------------------------------------- */

static int view_all(struct view *v, int is_complete)
{
    struct words words;
    v->index = read_triangles(v->d);
    int ok = parse_words(&words, v->d->metadata, is_complete ? v->d->shape.metadata_bytes : 0);
    ok = ok && v->index != NULL && number_vertices(v) && add_positions_of_rows(v) && add_indices(v) && add_attributes(v)
         && view_labels(v, &words) && sort_faces(v->mesh);
    free_words(&words);
    return ok;
}

int view_mesh(struct mesh_file *mesh, const cq_decoder *d, int is_complete)
{
    struct view v = { 0 };
    memset(mesh, 0, sizeof *mesh);
    v.d = d;
    v.mesh = mesh;
    v.rows = count_rows(d);
    int ok = view_all(&v, is_complete);
    free(v.index);
    free(v.vertex);
    return ok;
}
