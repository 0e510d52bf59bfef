/* mesh_file.c - formats, memory and notes of mesh_file.h. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* -- Formats ------------------------------------------------------------------------------------------------------- */

static const char *const format_names[] = { "off", "obj", "ply", "stl" };

static int equal_ignoring_case(const char *a, const char *b)
{
    while (*a != '\0' && tolower((unsigned char)*a) == tolower((unsigned char)*b))
        a++, b++;
    return *a == *b;
}

enum mesh_format mesh_format_by_name(const char *name)
{
    for (int i = 0; i < 4; i++)
        if (equal_ignoring_case(name, format_names[i]))
            return (enum mesh_format)(MESH_OFF + i);
    return MESH_UNKNOWN;
}

const char *mesh_format_name(enum mesh_format format)
{
    return format_names[format - MESH_OFF];
}

enum mesh_format mesh_format_of_path(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot == NULL ? MESH_UNKNOWN : mesh_format_by_name(dot + 1);
}

/* -- Messages ------------------------------------------------------------------------------------------------------ */

int fail(struct reader *r, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(r->error, MESH_ERROR_BYTES, format, arguments);
    va_end(arguments);
    size_t used = strlen(r->error);
    if (r->line > 0)
        snprintf(r->error + used, MESH_ERROR_BYTES - used, " (line %zu)", r->line);
    else
        snprintf(r->error + used, MESH_ERROR_BYTES - used, " (byte %zu)", r->item);
    return 0;
}

/* Without memory a note is not worth an error of its own: the reader is about to fail, too. */
void note(struct mesh_file *mesh, const char *format, ...)
{
    char text[2 * MESH_ERROR_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    size_t used = mesh->notes != NULL ? strlen(mesh->notes) : 0, more = strlen(text);
    char *notes = realloc(mesh->notes, used + more + 1);
    if (notes == NULL)
        return;
    memcpy(notes + used, text, more + 1);
    mesh->notes = notes;
}

/* -- Vertices and faces -------------------------------------------------------------------------------------------- */

int allocate(struct reader *r, struct mesh_file *mesh, size_t num_vertices, size_t num_faces)
{
    if (num_vertices >= UINT32_MAX || num_faces >= UINT32_MAX
            || num_vertices >= SIZE_MAX / 3 / sizeof *mesh->positions || num_faces >= SIZE_MAX / 3 / sizeof *mesh->indices)
        return fail(r, "too many vertices or faces");
    mesh->num_vertices = (uint32_t)num_vertices;
    mesh->num_faces = (uint32_t)num_faces;
    mesh->positions = calloc(num_vertices + 1, 3 * sizeof *mesh->positions);
    mesh->indices = calloc(num_faces + 1, 3 * sizeof *mesh->indices);
    if (mesh->positions == NULL || mesh->indices == NULL)
        return fail(r, "out of memory for %zu vertices and %zu faces", num_vertices, num_faces);
    return 1;
}

/* What the file does not tell is not lost: half of what its last digit counts. With nine digits, the largest float is
 * said to be a little larger than it is. */
int store_coordinate(struct reader *r, struct mesh_file *mesh, size_t i, double value, double unit)
{
    if (!(fabs(value) <= FLT_MAX + fmin(unit / 2, 1e30)))        /* also true for NaN */
        return fail(r, "coordinate is not a finite 32-bit float");
    if (fabs(value) > FLT_MAX)
        value = copysign(FLT_MAX, value);
    double rounding = fabs(value - (double)(float)value);
    if (rounding > 0.500001 * unit && rounding > mesh->rounding)
        mesh->rounding = rounding;
    mesh->positions[i] = value;
    return 1;
}

int store_corner(struct reader *r, struct mesh_file *mesh, size_t corner, double vertex)
{
    if (!(vertex >= 0 && vertex < mesh->num_vertices && vertex == floor(vertex)))
        return fail(r, "face %zu names vertex %.12g; there are %lu vertices", corner / 3, vertex,
                    (unsigned long)mesh->num_vertices);
    mesh->indices[corner] = (uint32_t)vertex;
    return 1;
}

int check_corners(struct reader *r, size_t face, double corners)
{
    return corners == 3 || fail(r, "face %zu has %.12g corners; only triangles are supported", face, corners);
}

/* -- Attributes ---------------------------------------------------------------------------------------------------- */

const char *mesh_attribute_name(enum mesh_attribute attribute)
{
    static const char *const names[MESH_NUM_ATTRIBUTES] = { "normals", "texture coordinates", "colors" };
    return names[attribute];
}

void drop_attribute(struct mesh_file *mesh, enum mesh_attribute attribute, const char *why, size_t vertex)
{
    note(mesh, "dropped: %s: vertex %zu %s\n", mesh_attribute_name(attribute), vertex, why);
    free(mesh->attribute[attribute]);
    mesh->attribute[attribute] = NULL;
}

int allocate_attribute(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute, int components)
{
    size_t count = (size_t)mesh->num_vertices + 1;
    mesh->components[attribute] = components;
    mesh->attribute[attribute] = malloc(count * (size_t)components * sizeof(float));
    if (mesh->attribute[attribute] == NULL)
        return fail(r, "out of memory for %s", mesh_attribute_name(attribute));
    for (size_t i = 0; i < count * (size_t)components; i++)
        mesh->attribute[attribute][i] = NAN;
    return 1;
}

float attribute_value(double value)
{
    return fabs(value) <= FLT_MAX ? (float)value : NAN;
}

void scale_colors(struct mesh_file *mesh)
{
    size_t count = (size_t)mesh->components[MESH_COLORS] * mesh->num_vertices, i = 0;
    float *color = mesh->attribute[MESH_COLORS];
    while (i < count && !(color[i] > 1))
        i++;
    for (size_t k = 0; i < count && k < count; k++)
        color[k] /= 255;
}

/* Less than half a step of 8 bits beyond 0 .. 1 is how some programs round. */
static void clamp_color(float *x)
{
    const float slack = 1.0f / 512;
    if (*x < 0 && *x >= -slack)
        *x = 0;
    if (*x > 1 && *x <= 1 + slack)
        *x = 1;
}

/* Attributes that some vertex does not have, or not as the numbers that they are, go. */
static void check_attribute(struct mesh_file *mesh, enum mesh_attribute attribute)
{
    size_t components = (size_t)mesh->components[attribute], count = components * mesh->num_vertices;
    for (size_t i = 0; i < count && mesh->attribute[attribute] != NULL; i++) {
        float *x = &mesh->attribute[attribute][i];
        if (attribute == MESH_COLORS)
            clamp_color(x);
        if (!isfinite(*x))
            drop_attribute(mesh, attribute, "has none, or one that is not finite", i / components);
        else if (attribute == MESH_COLORS && !(*x >= 0 && *x <= 1))
            drop_attribute(mesh, attribute, "has one outside 0 .. 1", i / components);
    }
}

/* -- Binary numbers ------------------------------------------------------------------------------------------------ */

uint64_t load_bytes(const uint8_t *data, size_t size, int big_endian)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++)
        value = value << 8 | data[big_endian ? i : size - 1 - i];
    return value;
}

float float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

double double_of_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* -- Reading ------------------------------------------------------------------------------------------------------- */

static int read_format(struct reader *r, struct mesh_file *mesh, enum mesh_format format)
{
    switch (format) {
    case MESH_OFF: return read_off(r, mesh);
    case MESH_OBJ: return read_obj(r, mesh);
    case MESH_PLY: return read_ply(r, mesh);
    case MESH_STL: return read_stl(r, mesh);
    default: return fail(r, "unknown mesh format");
    }
}

int mesh_read(struct mesh_file *mesh, const uint8_t *data, size_t size, enum mesh_format format,
              char error[MESH_ERROR_BYTES])
{
    struct reader r = { 0 };
    r.data = data;
    r.size = size;
    r.line = 1;
    r.error = error;
    memset(mesh, 0, sizeof *mesh);
    if (read_format(&r, mesh, format)) {
        for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++)
            check_attribute(mesh, (enum mesh_attribute)a);
        return 1;
    }
    mesh_free(mesh);
    return 0;
}

void mesh_free(struct mesh_file *mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++)
        free(mesh->attribute[a]);
    free(mesh->materials);
    free(mesh->notes);
    memset(mesh, 0, sizeof *mesh);
}
