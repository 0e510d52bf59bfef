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
static void add_note(char **notes, const char *format, va_list arguments)
{
    char text[2 * MESH_ERROR_BYTES];
    vsnprintf(text, sizeof text, format, arguments);
    size_t used = *notes != NULL ? strlen(*notes) : 0, more = strlen(text);
    char *longer = realloc(*notes, used + more + 1);
    if (longer == NULL)
        return;
    memcpy(longer + used, text, more + 1);
    *notes = longer;
}

void note(struct mesh_file *mesh, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_note(&mesh->notes, format, arguments);
    va_end(arguments);
}

void note_attribute(struct mesh_file *mesh, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_note(&mesh->attribute_notes, format, arguments);
    va_end(arguments);
}

const char *plural(size_t count)
{
    return count == 1 ? "" : "s";
}

/* -- Vertices ------------------------------------------------------------------------------------------------------ */

int allocate(struct reader *r, struct mesh_file *mesh, size_t num_vertices)
{
    if (num_vertices >= UINT32_MAX || num_vertices >= SIZE_MAX / 3 / sizeof *mesh->positions)
        return fail(r, "too many vertices");
    mesh->num_vertices = (uint32_t)num_vertices;
    mesh->positions = calloc(num_vertices + 1, 3 * sizeof *mesh->positions);
    return mesh->positions != NULL || fail(r, "out of memory for %zu vertices", num_vertices);
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
    if (i == 0 || unit < mesh->unit)
        mesh->unit = unit;
    mesh->positions[i] = value;
    return 1;
}

/* -- Attributes ---------------------------------------------------------------------------------------------------- */

const char *mesh_attribute_name(enum mesh_attribute attribute)
{
    static const char *const names[MESH_NUM_ATTRIBUTES] = { "normals", "texture coordinates", "colors" };
    return names[attribute];
}

int allocate_attribute(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute, int components)
{
    struct mesh_values *a = &mesh->attribute[attribute];
    size_t count = ((size_t)mesh->num_vertices + 1) * (size_t)components;
    a->components = components;
    a->count = mesh->num_vertices;
    a->values = malloc(count * sizeof *a->values);
    if (a->values == NULL)
        return fail(r, "out of memory for %s", mesh_attribute_name(attribute));
    for (size_t i = 0; i < count; i++)
        a->values[i] = NAN;
    return 1;
}

float attribute_value(double value)
{
    return fabs(value) <= FLT_MAX ? (float)value : NAN;
}

void scale_colors(struct mesh_file *mesh)
{
    struct mesh_values *colors = &mesh->attribute[MESH_COLORS];
    size_t count = (size_t)colors->components * colors->count, i = 0;
    while (i < count && !(colors->values[i] > 1))
        i++;
    for (size_t k = 0; i < count && k < count; k++)
        colors->values[k] /= 255;
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

static void free_values(struct mesh_values *a)
{
    free(a->values);
    free(a->corner);
    memset(a, 0, sizeof *a);
}

/* Is there a number that is not finite, or a color outside 0 .. 1? */
static const char *find_wrong(struct mesh_values *a, enum mesh_attribute attribute, size_t item)
{
    for (size_t i = item * (size_t)a->components; i < (item + 1) * (size_t)a->components; i++) {
        if (attribute == MESH_COLORS)
            clamp_color(&a->values[i]);
        if (!isfinite(a->values[i]))
            return "has none, or one that is not finite";
        if (attribute == MESH_COLORS && !(a->values[i] >= 0 && a->values[i] <= 1))
            return "has one outside 0 .. 1";
    }
    return NULL;
}

/* Attributes that some vertex does not have, or not as the numbers that they are, go. */
static void check_vertices(struct mesh_file *mesh, enum mesh_attribute attribute)
{
    struct mesh_values *a = &mesh->attribute[attribute];
    for (size_t v = 0; v < a->count; v++) {
        const char *wrong = find_wrong(a, attribute, v);
        if (wrong == NULL)
            continue;
        note_attribute(mesh, "dropped: %s: vertex %zu %s\n", mesh_attribute_name(attribute), v, wrong);
        free_values(a);
        return;
    }
}

/* -- Attributes of corners ----------------------------------------------------------------------------------------- */

/* Corners lose values that are no numbers. */
static void check_items(struct mesh_file *mesh, enum mesh_attribute attribute)
{
    struct mesh_values *a = &mesh->attribute[attribute];
    size_t wrong = 0;
    for (size_t c = 0; c < 3 * (size_t)mesh->num_faces; c++)
        if (a->corner[c] != MESH_NONE && find_wrong(a, attribute, a->corner[c]) != NULL) {
            a->corner[c] = MESH_NONE;
            wrong++;
        }
    for (size_t i = 0; i < (size_t)a->components * a->count; i++)
        if (!isfinite(a->values[i]))
            a->values[i] = 0;
    if (wrong > 0)
        note_attribute(mesh, "dropped: %s of %zu corner%s, which are no finite numbers\n", mesh_attribute_name(attribute),
                       wrong, plural(wrong));
}

/* How many corners of a face have one. */
static int count_with(const struct mesh_values *a, size_t face)
{
    const uint32_t *corner = a->corner + 3 * face;
    return (corner[0] != MESH_NONE) + (corner[1] != MESH_NONE) + (corner[2] != MESH_NONE);
}

/* Which faces have none? An attribute that no face has is none. */
static int check_missing(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute)
{
    struct mesh_values *a = &mesh->attribute[attribute];
    size_t without = 0, partly = 0;
    for (size_t f = 0; f < mesh->num_faces; f++) {
        without += count_with(a, f) == 0;
        partly += (size_t)(count_with(a, f) % 3);
    }
    if (without == mesh->num_faces) {
        note_attribute(mesh, "dropped: %s, which no face has\n", mesh_attribute_name(attribute));
        free_values(a);
        return 1;
    }
    if (partly > 0)
        note_attribute(mesh, "changed: %s: where only some corners of a face have one, the others get 0\n",
                       mesh_attribute_name(attribute));
    if (without > 0 && mesh->marks == NULL && (mesh->marks = calloc(mesh->num_faces, 1)) == NULL)
        return fail(r, "out of memory for %lu faces", (unsigned long)mesh->num_faces);
    for (size_t f = 0; f < mesh->num_faces && without > 0; f++)
        if (count_with(a, f) == 0)
            mesh->marks[f] |= (uint8_t)(1 << attribute);
    return 1;
}

static int check_attribute(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute)
{
    if (mesh->attribute[attribute].corner == NULL) {
        check_vertices(mesh, attribute);
        return 1;
    }
    check_items(mesh, attribute);
    return check_missing(r, mesh, attribute);
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
    int ok = read_format(&r, mesh, format);
    free(r.converted);
    for (int a = 0; a < MESH_NUM_ATTRIBUTES && ok; a++)
        ok = mesh->attribute[a].values == NULL || check_attribute(&r, mesh, (enum mesh_attribute)a);
    if (!ok)
        mesh_free(mesh);
    return ok;
}

void mesh_free(struct mesh_file *mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++)
        free_values(&mesh->attribute[a]);
    for (int k = 0; k < MESH_NUM_LABELS; k++) {
        free(mesh->label[k].of_face);
        free(mesh->label[k].names);
    }
    free(mesh->marks);
    free(mesh->number);
    free(mesh->libraries);
    free(mesh->notes);
    free(mesh->attribute_notes);
    memset(mesh, 0, sizeof *mesh);
}
