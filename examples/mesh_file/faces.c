/* faces.c - faces with any number of corners become triangles; smoothing groups become normals.
 * SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- As they come -------------------------------------------------------------------------------------------------- */

void begin_faces(struct faces *faces)
{
    memset(faces, 0, sizeof *faces);
    for (int a = 0; a < FACE_ITEMS; a++)
        faces->next.item[a] = MESH_NONE;
}

/* Room for one item more, of so many bytes. */
static int grow(struct reader *r, void **items, size_t count, size_t *room, size_t bytes)
{
    if (count < *room)
        return 1;
    size_t more = *room + *room / 2 + 64;
    void *larger = more < UINT32_MAX && more < SIZE_MAX / bytes ? realloc(*items, more * bytes) : NULL;
    if (larger == NULL)
        return fail(r, "out of memory for %zu corners or faces", more);
    *items = larger;
    *room = more;
    return 1;
}

int add_corner(struct reader *r, const struct mesh_file *mesh, struct faces *faces, double vertex)
{
    void *corners = faces->corner;
    if (!(vertex >= 0 && vertex < mesh->num_vertices && vertex == floor(vertex)))
        return fail(r, "face %zu names vertex %.12g; there are %lu vertices", faces->num_faces, vertex,
                    (unsigned long)mesh->num_vertices);
    if (!grow(r, &corners, faces->num_corners, &faces->corner_room, sizeof *faces->corner))
        return 0;
    faces->corner = corners;
    faces->next.vertex = (uint32_t)vertex;
    faces->corner[faces->num_corners++] = faces->next;
    return 1;
}

int end_face(struct reader *r, struct faces *faces)
{
    void *list = faces->face;
    if (!grow(r, &list, faces->num_faces, &faces->face_room, sizeof *faces->face))
        return 0;
    faces->face = list;
    struct face *face = &faces->face[faces->num_faces++];
    face->end = (uint32_t)faces->num_corners;
    memcpy(face->label, faces->label, sizeof face->label);
    return 1;
}

void free_faces(struct faces *faces)
{
    free(faces->corner);
    free(faces->face);
}

/* -- Triangles ----------------------------------------------------------------------------------------------------- */

struct store {
    struct mesh_file *mesh;
    const struct faces *faces;
    uint32_t *smoothing;               /* of triangles; NULL: not wanted */
    double (*point)[3];                /* of the corners of a face */
    uint32_t (*triangle)[3];
    size_t triangles;                  /* in all, with lines and points */
    size_t larger, empty;              /* faces with more than three corners, and with none */
    size_t too_large;                  /* faces whose triangles may overlap */
};

static size_t first_corner(const struct faces *faces, size_t face)
{
    return face > 0 ? faces->face[face - 1].end : 0;
}

static size_t count_corners(const struct faces *faces, size_t face)
{
    return faces->face[face].end - first_corner(faces, face);
}

/* Of all faces together, and the largest number of corners of one. */
static size_t count_triangles(const struct faces *faces, size_t *largest)
{
    size_t triangles = 0;
    *largest = 3;
    for (size_t f = 0; f < faces->num_faces; f++) {
        size_t corners = count_corners(faces, f);
        triangles += corners > 3 ? corners - 2 : corners > 0;
        *largest = corners > *largest ? corners : *largest;
    }
    return triangles;
}

static int has_label(const struct faces *faces, int label)
{
    for (size_t f = 0; f < faces->num_faces; f++)
        if (faces->face[f].label[label] != 0)
            return 1;
    return 0;
}

/* Of labels that some face has, and of attributes that some corner may have. */
static int allocate_labels(struct store *s, size_t triangles)
{
    int ok = 1;
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        if (has_label(s->faces, k))
            ok = (s->mesh->label[k].of_face = malloc(triangles * sizeof(uint32_t))) != NULL && ok;
    for (int a = 0; a < FACE_ITEMS; a++)
        if (s->faces->has_items[a])
            ok = (s->mesh->attribute[a].corner = malloc(triangles * 3 * sizeof(uint32_t))) != NULL && ok;
    return ok;
}

static int store_allocate(struct reader *r, struct store *s)
{
    size_t largest, triangles = count_triangles(s->faces, &largest);
    s->triangles = triangles;
    s->mesh->indices = malloc((triangles + 1) * 3 * sizeof *s->mesh->indices);
    s->point = malloc(largest * sizeof *s->point);
    s->triangle = malloc(largest * sizeof *s->triangle);
    s->smoothing = malloc((triangles + 1) * sizeof *s->smoothing);
    return (triangles < UINT32_MAX / 3 && s->mesh->indices != NULL && s->point != NULL && s->triangle != NULL
            && s->smoothing != NULL && allocate_labels(s, triangles + 1))
           || fail(r, "out of memory for %zu faces", triangles);
}

/* From corners of a face to a triangle of the mesh. */
static void store_triangle(struct store *s, const struct face *face, const struct face_corner *corner,
                           const uint32_t triangle[3])
{
    struct mesh_file *mesh = s->mesh;
    size_t f = mesh->num_faces++;
    for (size_t i = 0; i < 3; i++) {
        const struct face_corner *c = &corner[triangle[i]];
        mesh->indices[3 * f + i] = c->vertex;
        for (int a = 0; a < FACE_ITEMS; a++)
            if (mesh->attribute[a].corner != NULL)
                mesh->attribute[a].corner[3 * f + i] = c->item[a];
    }
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        if (mesh->label[k].of_face != NULL)
            mesh->label[k].of_face[f] = face->label[k];
    s->smoothing[f] = face->label[FACE_SMOOTHING];
}

/* A line, or a point. */
static int store_line(struct store *s, const struct face *face, const struct face_corner *corner, size_t corners)
{
    static const uint32_t line[3] = { 0, 1, 1 }, point[3] = { 0, 0, 0 };
    if (s->mesh->marks == NULL && (s->mesh->marks = calloc(s->triangles, 1)) == NULL)
        return 0;
    s->mesh->marks[s->mesh->num_faces] = corners == 2 ? MESH_LINE : MESH_POINT;
    store_triangle(s, face, corner, corners == 2 ? line : point);
    return 1;
}

static int store_face(struct store *s, size_t f)
{
    size_t corners = count_corners(s->faces, f);
    s->larger += corners > 3;
    s->empty += corners == 0;
    if (corners == 0)
        return 1;
    const struct face_corner *corner = s->faces->corner + first_corner(s->faces, f);
    if (corners < 3)
        return store_line(s, &s->faces->face[f], corner, corners);
    for (size_t i = 0; i < corners; i++)
        memcpy(s->point[i], &s->mesh->positions[3 * (size_t)corner[i].vertex], sizeof *s->point);
    int result = triangulate((const double (*)[3])s->point, corners, s->triangle);
    s->too_large += result == 1;
    if (result == 0)
        return 0;
    for (size_t t = 0; t < corners - 2; t++)
        store_triangle(s, &s->faces->face[f], corner, s->triangle[t]);
    return 1;
}

static int store_all(struct reader *r, struct store *s)
{
    if (!store_allocate(r, s))
        return 0;
    for (size_t f = 0; f < s->faces->num_faces; f++)
        if (!store_face(s, f))
            return fail(r, "out of memory for a face with %zu corners", count_corners(s->faces, f));
    if (s->larger > 0)
        note(s->mesh, "changed: faces with more than three corners (%zu) are cut into triangles\n", s->larger);
    if (s->too_large > 0)
        note(s->mesh, "changed: faces with too many corners (%zu): their triangles may overlap\n", s->too_large);
    if (s->empty > 0)
        note(s->mesh, "dropped: faces without corners (%zu)\n", s->empty);
    return s->mesh->num_faces > 0 || s->faces->num_faces == 0 || fail(r, "no face has a corner");
}

/* -- Normals from smoothing groups --------------------------------------------------------------------------------- */

/* Of a corner of a triangle: the normal of the triangle as long as the angle there. Source: Thuermer and Wuethrich,
 * "Computing vertex normals from polygonal facets", 1998. Zero if it has no area. */
static void corner_normal(const struct mesh_file *mesh, size_t corner, double normal[3])
{
    double u[3], v[3], sine = 0, cosine = 0;
    const uint32_t *t = &mesh->indices[corner - corner % 3];
    const double *a = &mesh->positions[3 * (size_t)t[corner % 3]];
    const double *b = &mesh->positions[3 * (size_t)t[(corner + 1) % 3]];
    const double *c = &mesh->positions[3 * (size_t)t[(corner + 2) % 3]];
    for (int i = 0; i < 3; i++) {
        u[i] = b[i] - a[i];
        v[i] = c[i] - a[i];
        cosine += u[i] * v[i];
    }
    for (int i = 0; i < 3; i++) {
        normal[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
        sine += normal[i] * normal[i];
    }
    sine = sqrt(sine);
    for (int i = 0; i < 3; i++)
        normal[i] = sine > 0 ? normal[i] * (atan2(sine, cosine) / sine) : 0;
}

static void set_length_one(const double sum[3], float normal[3])
{
    double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (int i = 0; i < 3; i++)
        normal[i] = length > 0 ? (float)(sum[i] / length) : (float)(i == 2);
}

/* Corners whose triangles share a normal have equal keys: the vertex, and the group or the triangle itself. */
static uint32_t *find_shared(const struct mesh_file *mesh, const uint32_t *smoothing)
{
    size_t corners = 3 * (size_t)mesh->num_faces;
    uint32_t (*key)[3] = malloc((corners + 1) * sizeof *key), *shared = NULL;
    for (size_t c = 0; c < corners && key != NULL; c++) {
        key[c][0] = mesh->indices[c];
        key[c][1] = smoothing[c / 3];
        key[c][2] = smoothing[c / 3] == 0 ? (uint32_t)(c / 3) : 0;
    }
    if (key != NULL)
        shared = mesh_first_equal(key, corners, sizeof *key);
    free(key);
    return shared;
}

static int smooth_normals(struct reader *r, struct mesh_file *mesh, const uint32_t *smoothing)
{
    struct mesh_values *normals = &mesh->attribute[MESH_NORMALS];
    size_t corners = 3 * (size_t)mesh->num_faces;
    double (*sum)[3] = calloc(corners + 1, sizeof *sum), normal[3];
    normals->components = 3;
    normals->count = (uint32_t)corners;
    normals->corner = find_shared(mesh, smoothing);
    normals->values = malloc((corners + 1) * 3 * sizeof *normals->values);
    int ok = sum != NULL && normals->corner != NULL && normals->values != NULL;
    for (size_t c = 0; c < corners && ok; c++) {
        corner_normal(mesh, c, normal);
        for (int i = 0; i < 3; i++)
            sum[normals->corner[c]][i] += normal[i];
    }
    for (size_t c = 0; c < corners && ok; c++)
        set_length_one(sum[c], &normals->values[3 * c]);
    free(sum);
    return ok || fail(r, "out of memory for %zu normals", corners);
}

int store_faces(struct reader *r, struct mesh_file *mesh, const struct faces *faces, int wants_normals)
{
    struct store s = { 0 };
    s.mesh = mesh;
    s.faces = faces;
    int is_smooth = wants_normals && has_label(faces, FACE_SMOOTHING);
    int ok = store_all(r, &s) && (!is_smooth || smooth_normals(r, mesh, s.smoothing));
    if (ok && is_smooth)
        note_attribute(mesh, "dropped: smoothing groups, which became normals\n");
    free(s.point);
    free(s.triangle);
    free(s.smoothing);
    return ok;
}
