/* mesh_file.c - see mesh_file.h. SPDX-License-Identifier: MIT
 *
 * Functions that read return 1, or 0 after fail() has written the message, so that steps chain with &&. All numbers go
 * through double, which holds each float, each 32-bit integer and each index exactly. */
#include "mesh_file.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* -- Formats ------------------------------------------------------------------------------------------------------- */

static int equal_ignoring_case(const char *a, const char *b)
{
    while (*a != '\0' && tolower((unsigned char)*a) == tolower((unsigned char)*b))
        a++, b++;
    return *a == *b;
}

enum mesh_format mesh_format_by_name(const char *name)
{
    static const char *const names[] = { "off", "obj", "ply", "stl" };
    for (int i = 0; i < 4; i++)
        if (equal_ignoring_case(name, names[i]))
            return (enum mesh_format)(MESH_OFF + i);
    return MESH_UNKNOWN;
}

enum mesh_format mesh_format_of_path(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot == NULL ? MESH_UNKNOWN : mesh_format_by_name(dot + 1);
}

/* -- Reader -------------------------------------------------------------------------------------------------------- */

#define WORD_BYTES 64

struct reader {
    const uint8_t *data;
    size_t size;
    size_t at;        /* the next byte */
    size_t item;      /* where the last binary item began */
    size_t line;      /* of `at`, from 1; 0 in binary data, where messages name the byte */
    char *error;      /* char[MESH_ERROR_BYTES] */
};

/* Writes the message and the place; returns 0 for the caller to return. */
static int fail(struct reader *r, const char *format, ...)
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

/* Makes room for a mesh. Callers have checked the counts against the size of the file. */
static int allocate(struct reader *r, struct mesh_file *mesh, size_t num_vertices, size_t num_faces)
{
    if (num_vertices >= UINT32_MAX || num_faces >= UINT32_MAX || num_faces > SIZE_MAX / 3 / sizeof *mesh->indices)
        return fail(r, "too many vertices or faces");
    mesh->num_vertices = (uint32_t)num_vertices;
    mesh->num_faces = (uint32_t)num_faces;
    mesh->positions = calloc(num_vertices + 1, 3 * sizeof *mesh->positions);
    mesh->indices = calloc(num_faces + 1, 3 * sizeof *mesh->indices);
    if (mesh->positions == NULL || mesh->indices == NULL)
        return fail(r, "out of memory for %zu vertices and %zu faces", num_vertices, num_faces);
    return 1;
}

static int store_coordinate(struct reader *r, float *coordinate, double value)
{
    if (!(fabs(value) <= FLT_MAX))        /* also true for NaN */
        return fail(r, "coordinate is not a finite 32-bit float");
    *coordinate = (float)value;
    return 1;
}

static int store_corner(struct reader *r, struct mesh_file *mesh, size_t corner, double vertex)
{
    if (!(vertex >= 0 && vertex < mesh->num_vertices && vertex == floor(vertex)))
        return fail(r, "face %zu names vertex %.12g; there are %lu vertices", corner / 3, vertex,
                    (unsigned long)mesh->num_vertices);
    mesh->indices[corner] = (uint32_t)vertex;
    return 1;
}

static int check_corners(struct reader *r, size_t face, double corners)
{
    return corners == 3 || fail(r, "face %zu has %.12g corners; only triangles are supported", face, corners);
}

/* -- Attributes ---------------------------------------------------------------------------------------------------- */

const char *mesh_attribute_name(enum mesh_attribute attribute)
{
    static const char *const names[MESH_NUM_ATTRIBUTES] = { "normals", "texture coordinates", "colors" };
    return names[attribute];
}

/* Notes what is not kept, and why; of more than fit nothing but the last one. */
static void note_dropped(struct mesh_file *mesh, const char *format, ...)
{
    va_list arguments;
    int last = mesh->num_dropped < MESH_MAX_DROPPED ? mesh->num_dropped++ : MESH_MAX_DROPPED - 1;
    va_start(arguments, format);
    vsnprintf(mesh->dropped[last], MESH_ERROR_BYTES, format, arguments);
    va_end(arguments);
}

static void drop_attribute(struct mesh_file *mesh, enum mesh_attribute attribute, const char *why, size_t vertex)
{
    note_dropped(mesh, "%s: vertex %zu %s", mesh_attribute_name(attribute), vertex, why);
    free(mesh->attribute[attribute]);
    mesh->attribute[attribute] = NULL;
}

static int allocate_attribute(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute, int components)
{
    mesh->components[attribute] = components;
    mesh->attribute[attribute] = calloc((size_t)mesh->num_vertices + 1, (size_t)components * sizeof(float));
    return mesh->attribute[attribute] != NULL || fail(r, "out of memory for %s", mesh_attribute_name(attribute));
}

/* NaN marks what the file has not said. */
static float attribute_value(double value)
{
    return fabs(value) <= FLT_MAX ? (float)value : NAN;
}

/* Attributes that some vertex does not have, or not as the numbers that they are, go. */
static void check_attribute(struct mesh_file *mesh, enum mesh_attribute attribute)
{
    size_t components = (size_t)mesh->components[attribute], count = components * mesh->num_vertices;
    for (size_t i = 0; i < count && mesh->attribute[attribute] != NULL; i++) {
        float x = mesh->attribute[attribute][i];
        if (!isfinite(x))
            drop_attribute(mesh, attribute, "has none, or one that is not finite", i / components);
        else if (attribute == MESH_COLORS && !(x >= 0 && x <= 1))
            drop_attribute(mesh, attribute, "has one outside 0 .. 1", i / components);
    }
}

/* -- Text: words and lines ----------------------------------------------------------------------------------------- */

static int at_line_end(const struct reader *r)
{
    return r->at == r->size || r->data[r->at] == '\n' || r->data[r->at] == '\r';
}

/* Skips the rest of the line and its end: \n, \r\n or \r. */
static void next_line(struct reader *r)
{
    while (!at_line_end(r))
        r->at++;
    if (r->at == r->size)
        return;
    if (r->data[r->at++] == '\r' && r->at < r->size && r->data[r->at] == '\n')
        r->at++;
    r->line++;
}

static int at_blank(const struct reader *r)
{
    return r->at < r->size && (r->data[r->at] == ' ' || r->data[r->at] == '\t');
}

/* Skips blanks of this line, and a comment. */
static void skip_blanks(struct reader *r)
{
    while (at_blank(r))
        r->at++;
    if (r->at < r->size && r->data[r->at] == '#')
        while (!at_line_end(r))
            r->at++;
}

/* Moves to the next word, over line ends and comments; 0 if there is none. */
static int seek_word(struct reader *r)
{
    skip_blanks(r);
    while (at_line_end(r) && r->at < r->size) {
        next_line(r);
        skip_blanks(r);
    }
    return r->at < r->size;
}

/* Takes the next word of this line; "" at its end. Words can be printed: odd bytes become '?', and the end of a word
 * that is too long becomes '~'. Neither occurs in what the parsers accept. */
static void take_word(struct reader *r, char word[WORD_BYTES])
{
    size_t length = 0;
    skip_blanks(r);
    for (; !at_line_end(r) && !at_blank(r); r->at++)
        if (length < WORD_BYTES - 1)
            word[length++] = (char)(r->data[r->at] > ' ' && r->data[r->at] < 127 ? r->data[r->at] : '?');
        else
            word[length - 1] = '~';
    word[length] = '\0';
}

/* 1 if all of the word is a decimal number. No hexadecimal, no "inf", no "nan", which strtod would take. */
static int parse_number(const char *word, double *value)
{
    char *end;
    if (word[strspn(word, "+-.0123456789eE")] != '\0')
        return 0;
    *value = strtod(word, &end);
    return end != word && *end == '\0';
}

static int take_number(struct reader *r, double *value)
{
    char word[WORD_BYTES];
    take_word(r, word);
    if (parse_number(word, value))
        return 1;
    return word[0] == '\0' ? fail(r, "number expected, found the end of the line")
                           : fail(r, "number expected, found '%s'", word);
}

static int take_position(struct reader *r, float position[3])
{
    double value;
    for (int i = 0; i < 3; i++)
        if (!take_number(r, &value) || !store_coordinate(r, &position[i], value))
            return 0;
    return 1;
}

/* -- OFF ----------------------------------------------------------------------------------------------------------- */

/* Takes "OFF", with or without the marks of colours, normals and texture coordinates. Some files have no blank between
 * it and the first count. */
static int off_keyword(struct reader *r, struct mesh_file *mesh)
{
    static const char *const keywords[] = { "OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF" };
    seek_word(r);
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++) {
        size_t length = strlen(keywords[i]);
        if (r->size - r->at >= length && memcmp(r->data + r->at, keywords[i], length) == 0) {
            r->at += length;
            if (i > 0)
                note_dropped(mesh, "what %s has beside positions is not read", keywords[i]);
            return 1;
        }
    }
    return fail(r, "not an OFF file: no OFF, COFF, NOFF or STOFF at the start");
}

static int off_count(struct reader *r, double *count)
{
    if (!take_number(r, count))
        return 0;
    return (*count >= 0 && *count == floor(*count)) || fail(r, "%.12g is not a count", *count);
}

/* Takes the numbers of vertices and faces; that of edges is ignored. The shortest line "0 0 0" takes 6 bytes. */
static int off_counts(struct reader *r, struct mesh_file *mesh)
{
    double vertices, faces;
    seek_word(r);
    if (!off_count(r, &vertices) || !off_count(r, &faces))
        return 0;
    next_line(r);
    if (vertices + faces > (double)((r->size - r->at + 1) / 6))
        return fail(r, "%.12g vertices and %.12g faces do not fit in the file", vertices, faces);
    return allocate(r, mesh, (size_t)vertices, (size_t)faces);
}

static int off_vertices(struct reader *r, struct mesh_file *mesh)
{
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        if (!seek_word(r))
            return fail(r, "the file ends before vertex %zu", v);
        if (!take_position(r, &mesh->positions[3 * v]))
            return 0;
        next_line(r);
    }
    return 1;
}

static int off_face(struct reader *r, struct mesh_file *mesh, size_t face)
{
    double value;
    if (!take_number(r, &value) || !check_corners(r, face, value))
        return 0;
    for (size_t i = 0; i < 3; i++)
        if (!take_number(r, &value) || !store_corner(r, mesh, 3 * face + i, value))
            return 0;
    next_line(r);
    return 1;
}

static int off_faces(struct reader *r, struct mesh_file *mesh)
{
    for (size_t f = 0; f < mesh->num_faces; f++) {
        if (!seek_word(r))
            return fail(r, "the file ends before face %zu", f);
        if (!off_face(r, mesh, f))
            return 0;
    }
    return 1;
}

static int read_off(struct reader *r, struct mesh_file *mesh)
{
    return off_keyword(r, mesh) && off_counts(r, mesh) && off_vertices(r, mesh) && off_faces(r, mesh);
}

/* -- OBJ ----------------------------------------------------------------------------------------------------------- */

/* Normals and texture coordinates have numbers of their own, and corners name them: attribute a of the file is a list,
 * and corner[a] says for each corner which item it has, or OBJ_NONE. */
#define OBJ_NONE UINT32_MAX
enum { OBJ_LISTS = MESH_TEXCOORDS + 1 };

struct obj_material {
    const uint8_t *name;               /* in the file, up to the end of the line */
    size_t length;
    uint32_t line, first;              /* of the lines that name materials this one, from 1; the first with that name */
    uint32_t number;                   /* there: of the material; 0: no face has it yet */
};

struct obj {
    size_t vertices, faces;            /* lines, in all; then so far */
    size_t items[OBJ_LISTS];           /* likewise */
    size_t others;                     /* lines that are not read */
    char other[WORD_BYTES];            /* the first word of one */
    size_t material_lines;             /* in all; then so far */
    struct obj_material *material;     /* of each such line */
    float *list[OBJ_LISTS];
    uint32_t *corner[OBJ_LISTS];
};

static const char *const obj_words[OBJ_LISTS] = { "vn", "vt" };
static const int obj_components[OBJ_LISTS] = { 3, 2 };

static void obj_count_line(struct obj *obj, const char *word)
{
    static const char *const without_content[] = { "o", "s", "mtllib" };
    int known = 1;
    if (strcmp(word, "v") == 0)
        obj->vertices++;
    else if (strcmp(word, "f") == 0)
        obj->faces++;
    else if (strcmp(word, obj_words[MESH_NORMALS]) == 0)
        obj->items[MESH_NORMALS]++;
    else if (strcmp(word, obj_words[MESH_TEXCOORDS]) == 0)
        obj->items[MESH_TEXCOORDS]++;
    else if (strcmp(word, "usemtl") == 0)
        obj->material_lines++;
    else
        known = 0;
    for (int i = 0; i < 3 && !known; i++)
        known = strcmp(word, without_content[i]) == 0;
    if (!known && obj->others++ == 0)
        memcpy(obj->other, word, WORD_BYTES);
}

/* Counts lines by what they begin with, and goes back to the start. */
static void obj_count(struct reader *r, struct obj *obj)
{
    char word[WORD_BYTES];
    while (seek_word(r)) {
        take_word(r, word);
        obj_count_line(obj, word);
        next_line(r);
    }
    r->at = 0;
    r->line = 1;
}

static int obj_allocate(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    if (!allocate(r, mesh, obj->vertices, obj->faces))
        return 0;
    if (obj->material_lines > 0) {
        obj->material = calloc(obj->material_lines, sizeof *obj->material);
        mesh->materials = calloc(obj->faces + 1, sizeof *mesh->materials);
        if (obj->material == NULL || mesh->materials == NULL)
            return fail(r, "out of memory for materials");
    }
    for (int a = 0; a < OBJ_LISTS; a++) {
        if (obj->items[a] == 0)
            continue;
        obj->list[a] = calloc(obj->items[a], (size_t)obj_components[a] * sizeof *obj->list[a]);
        obj->corner[a] = malloc((3 * obj->faces + 1) * sizeof *obj->corner[a]);
        if (obj->list[a] == NULL || obj->corner[a] == NULL)
            return fail(r, "out of memory for %s", mesh_attribute_name((enum mesh_attribute)a));
        memset(obj->corner[a], 0xff, (3 * obj->faces + 1) * sizeof *obj->corner[a]);
    }
    return 1;
}

/* The next number of the line, or NaN. */
static float obj_optional_number(struct reader *r)
{
    char word[WORD_BYTES];
    double value;
    take_word(r, word);
    return parse_number(word, &value) ? attribute_value(value) : NAN;
}

/* A position, and perhaps three numbers for a color; a fourth coordinate is none. */
static int obj_vertex(struct reader *r, struct mesh_file *mesh, size_t vertex)
{
    float rgb[3];
    if (!take_position(r, &mesh->positions[3 * vertex]))
        return 0;
    for (int i = 0; i < 3; i++)
        rgb[i] = obj_optional_number(r);
    if (isnan(rgb[2]) && mesh->attribute[MESH_COLORS] == NULL)
        return 1;
    if (mesh->attribute[MESH_COLORS] == NULL) {
        if (!allocate_attribute(r, mesh, MESH_COLORS, 3))
            return 0;
        for (size_t i = 0; i < 3 * vertex; i++)
            mesh->attribute[MESH_COLORS][i] = NAN;
    }
    memcpy(&mesh->attribute[MESH_COLORS][3 * vertex], rgb, sizeof rgb);
    return 1;
}

/* A number of a corner counts from 1, or backwards from the last one yet, which is -1. NaN if it is none. */
static double obj_number(const char *word, size_t so_far)
{
    double number;
    if (!parse_number(word, &number) || number == 0)
        return NAN;
    return number > 0 ? number - 1 : (double)so_far + number;
}

/* The normal or texture coordinates of a corner; OBJ_NONE for what does not exist. */
static uint32_t obj_item(const char *word, size_t so_far, size_t end)
{
    double number = obj_number(word, so_far);
    return number >= 0 && number < (double)end && number == floor(number) ? (uint32_t)number : OBJ_NONE;
}

/* Cuts "v/vt/vn" into its parts; missing ones are "". */
static void obj_cut(char *word, const char *part[3])
{
    for (int i = 0; i < 3; i++) {
        part[i] = word;
        word += strcspn(word, "/");
        if (*word != '\0')
            *word++ = '\0';
    }
}

static int obj_corner(struct reader *r, struct mesh_file *mesh, struct obj *obj, const size_t *all, size_t corner,
                      char *word)
{
    const char *part[3];
    obj_cut(word, part);
    double vertex = obj_number(part[0], obj->vertices);
    if (isnan(vertex))
        return fail(r, "face %zu has a corner '%s'", corner / 3, part[0]);
    if (!store_corner(r, mesh, corner, vertex))
        return 0;
    for (int a = 0; a < OBJ_LISTS; a++)
        if (obj->corner[a] != NULL)
            obj->corner[a][corner] = obj_item(part[a == MESH_TEXCOORDS ? 1 : 2], obj->items[a], all[a]);
    return 1;
}

static int obj_face(struct reader *r, struct mesh_file *mesh, struct obj *obj, const size_t *all)
{
    char word[WORD_BYTES];
    size_t corners = 0;
    if (mesh->materials != NULL)
        mesh->materials[obj->faces] = (uint32_t)obj->material_lines;
    for (take_word(r, word); word[0] != '\0'; take_word(r, word), corners++)
        if (corners < 3 && !obj_corner(r, mesh, obj, all, 3 * obj->faces + corners, word))
            return 0;
    return check_corners(r, obj->faces++, (double)corners);
}

/* The rest of the line is the name: it may have spaces. */
static void obj_use_material(const struct reader *r, struct obj *obj)
{
    struct obj_material *material = &obj->material[obj->material_lines++];
    size_t begin = r->at, end;
    while (begin < r->size && (r->data[begin] == ' ' || r->data[begin] == '\t'))
        begin++;
    for (end = begin; end < r->size && r->data[end] != '\n' && r->data[end] != '\r'; end++) {}
    while (end > begin && (r->data[end - 1] == ' ' || r->data[end - 1] == '\t'))
        end--;
    material->name = r->data + begin;
    material->length = end - begin;
    material->line = (uint32_t)obj->material_lines;
}

static int compare_names(const struct obj_material *a, const struct obj_material *b)
{
    if (a->length != b->length)
        return a->length < b->length ? -1 : 1;
    return memcmp(a->name, b->name, a->length);
}

static int compare_by_name(const void *a, const void *b)
{
    const struct obj_material *s = a, *t = b;
    int order = compare_names(s, t);
    return order != 0 ? order : (s->line > t->line) - (s->line < t->line);
}

static int compare_by_line(const void *a, const void *b)
{
    const struct obj_material *s = a, *t = b;
    return (s->line > t->line) - (s->line < t->line);
}

/* From lines that name materials to their numbers, in the order in which faces have them. */
static void obj_materials(struct mesh_file *mesh, struct obj *obj)
{
    struct obj_material *material = obj->material;
    size_t n = obj->material_lines;
    if (n == 0)
        return;
    qsort(material, n, sizeof *material, compare_by_name);
    for (size_t i = 0; i < n; i++)
        material[i].first = i > 0 && compare_names(&material[i - 1], &material[i]) == 0 ? material[i - 1].first
                                                                                        : material[i].line;
    qsort(material, n, sizeof *material, compare_by_line);
    for (size_t f = 0; f < mesh->num_faces; f++) {
        if (mesh->materials[f] == 0)
            continue;
        struct obj_material *named = &material[material[mesh->materials[f] - 1].first - 1];
        if (named->number == 0)
            named->number = ++mesh->num_materials;
        mesh->materials[f] = named->number;
    }
    if (mesh->num_materials == 0) {
        free(mesh->materials);
        mesh->materials = NULL;
        return;
    }
    note_dropped(mesh, "names of materials: the first of %lu comes back as material_1, and so on",
                 (unsigned long)mesh->num_materials);
}

static int obj_lines(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    char word[WORD_BYTES];
    size_t all[OBJ_LISTS];
    memcpy(all, obj->items, sizeof all);
    obj->vertices = obj->faces = obj->items[MESH_NORMALS] = obj->items[MESH_TEXCOORDS] = obj->material_lines = 0;
    while (seek_word(r)) {
        take_word(r, word);
        if (strcmp(word, "v") == 0 && !obj_vertex(r, mesh, obj->vertices++))
            return 0;
        if (strcmp(word, "f") == 0 && !obj_face(r, mesh, obj, all))
            return 0;
        if (strcmp(word, "usemtl") == 0)
            obj_use_material(r, obj);
        for (int a = 0; a < OBJ_LISTS; a++)
            if (strcmp(word, obj_words[a]) == 0) {
                float *item = obj->list[a] + (size_t)obj_components[a] * obj->items[a]++;
                for (int i = 0; i < obj_components[a]; i++)
                    item[i] = obj_optional_number(r);
            }
        next_line(r);
    }
    return 1;
}

/* Gives each vertex what its corners name, if they agree. */
static int obj_attribute(struct reader *r, struct mesh_file *mesh, const struct obj *obj, enum mesh_attribute a)
{
    size_t components = (size_t)obj_components[a];
    if (obj->corner[a] == NULL)
        return 1;
    if (!allocate_attribute(r, mesh, a, obj_components[a]))
        return 0;
    for (size_t i = 0; i < components * mesh->num_vertices; i++)
        mesh->attribute[a][i] = NAN;
    for (size_t c = 0; c < 3 * (size_t)mesh->num_faces; c++) {
        uint32_t item = obj->corner[a][c], vertex = mesh->indices[c];
        if (item == OBJ_NONE) {
            drop_attribute(mesh, a, "has a corner without", vertex);
            return 1;
        }
        float *at = mesh->attribute[a] + components * vertex;
        const float *value = obj->list[a] + components * item;
        if (!isnan(at[0]) && memcmp(at, value, components * sizeof *at) != 0) {
            drop_attribute(mesh, a, "has corners that differ", vertex);
            return 1;
        }
        memcpy(at, value, components * sizeof *at);
    }
    return 1;
}

static int read_obj(struct reader *r, struct mesh_file *mesh)
{
    struct obj obj;
    memset(&obj, 0, sizeof obj);
    obj_count(r, &obj);
    int ok = obj_allocate(r, mesh, &obj) && obj_lines(r, mesh, &obj) && obj_attribute(r, mesh, &obj, MESH_NORMALS)
             && obj_attribute(r, mesh, &obj, MESH_TEXCOORDS);
    if (ok)
        obj_materials(mesh, &obj);
    free(obj.material);
    for (int a = 0; a < OBJ_LISTS; a++) {
        free(obj.list[a]);
        free(obj.corner[a]);
    }
    if (obj.others > 0)
        note_dropped(mesh, "%zu lines that are not read, such as '%s'", obj.others, obj.other);
    return ok;
}

/* -- PLY: header --------------------------------------------------------------------------------------------------- */

#define PLY_MAX_ELEMENTS 32
#define PLY_MAX_PROPERTIES 256       /* of all elements together */

enum ply_encoding { PLY_ASCII, PLY_LITTLE_ENDIAN, PLY_BIG_ENDIAN };
enum ply_role { PLY_X, PLY_Y, PLY_Z, PLY_CORNERS, PLY_ATTRIBUTE, PLY_SKIPPED };

struct ply_type {
    const char *name, *other_name;
    uint8_t size;
    enum { PLY_UNSIGNED, PLY_SIGNED, PLY_FLOAT } kind;
};

struct ply_property {
    const struct ply_type *count_type;   /* of a list; NULL for a scalar */
    const struct ply_type *type;
    enum ply_role role;
    enum mesh_attribute attribute;       /* of PLY_ATTRIBUTE */
    int component;
};

struct ply_element {
    enum { PLY_VERTEX, PLY_FACE, PLY_OTHER } kind;
    size_t count;
    size_t first, end;                   /* its properties */
    char name[WORD_BYTES];
};

struct ply {
    enum ply_encoding encoding;
    unsigned components[MESH_NUM_ATTRIBUTES];   /* those that properties have, a bit for each */
    size_t num_elements, num_properties;
    struct ply_element element[PLY_MAX_ELEMENTS];
    struct ply_property property[PLY_MAX_PROPERTIES];
};

static int ply_type_named(struct reader *r, const char *name, const struct ply_type **type)
{
    static const struct ply_type types[] = {
        { "char", "int8", 1, PLY_SIGNED },     { "uchar", "uint8", 1, PLY_UNSIGNED },
        { "short", "int16", 2, PLY_SIGNED },   { "ushort", "uint16", 2, PLY_UNSIGNED },
        { "int", "int32", 4, PLY_SIGNED },     { "uint", "uint32", 4, PLY_UNSIGNED },
        { "float", "float32", 4, PLY_FLOAT },  { "double", "float64", 8, PLY_FLOAT },
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(name, types[i].name) == 0 || strcmp(name, types[i].other_name) == 0) {
            *type = &types[i];
            return 1;
        }
    return fail(r, "unknown type '%s'", name);
}

static int ply_encoding_line(struct reader *r, struct ply *ply)
{
    static const char *const names[] = { "ascii", "binary_little_endian", "binary_big_endian" };
    char word[WORD_BYTES];
    take_word(r, word);
    for (int i = 0; i < 3; i++)
        if (strcmp(word, names[i]) == 0) {
            ply->encoding = (enum ply_encoding)i;
            return 1;
        }
    return fail(r, "unknown PLY encoding '%s'", word);
}

static int ply_element_kind(struct reader *r, struct ply *ply, struct ply_element *element)
{
    char name[WORD_BYTES];
    take_word(r, name);
    if (strcmp(name, "tristrips") == 0)
        return fail(r, "triangle strips (element tristrips) are not supported");
    memcpy(element->name, name, sizeof name);
    element->kind = strcmp(name, "vertex") == 0 ? PLY_VERTEX : strcmp(name, "face") == 0 ? PLY_FACE : PLY_OTHER;
    for (size_t i = 0; i < ply->num_elements; i++)
        if (element->kind != PLY_OTHER && ply->element[i].kind == element->kind)
            return fail(r, "second element '%s'", name);
    return 1;
}

static int ply_element_line(struct reader *r, struct ply *ply)
{
    double count;
    if (ply->num_elements == PLY_MAX_ELEMENTS)
        return fail(r, "more than %d elements", PLY_MAX_ELEMENTS);
    struct ply_element *element = &ply->element[ply->num_elements];
    if (!ply_element_kind(r, ply, element) || !take_number(r, &count))
        return 0;
    if (!(count >= 0 && count <= (double)r->size && count == floor(count)))
        return fail(r, "%.12g rows of an element do not fit in the file", count);
    element->count = (size_t)count;
    element->first = element->end = ply->num_properties;
    ply->num_elements++;
    return 1;
}

/* A property with a part in the mesh has one place: x, y, z of the vertices are scalars, the corners are a list. */
static enum ply_role ply_role_of(const struct ply_element *element, const char *name, int is_list)
{
    if (element->kind == PLY_VERTEX && !is_list && name[0] >= 'x' && name[0] <= 'z' && name[1] == '\0')
        return (enum ply_role)(PLY_X + (name[0] - 'x'));
    if (element->kind == PLY_FACE && is_list
            && (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0))
        return PLY_CORNERS;
    return PLY_SKIPPED;
}

/* Is a scalar of the vertices part of an attribute? Each component is read from its first property. */
static int ply_is_attribute(struct ply *ply, struct ply_property *property, const char *name)
{
    static const struct { const char *name; enum mesh_attribute attribute; int component; } names[] = {
        { "nx", MESH_NORMALS, 0 }, { "ny", MESH_NORMALS, 1 }, { "nz", MESH_NORMALS, 2 },
        { "s", MESH_TEXCOORDS, 0 }, { "t", MESH_TEXCOORDS, 1 }, { "u", MESH_TEXCOORDS, 0 }, { "v", MESH_TEXCOORDS, 1 },
        { "texture_u", MESH_TEXCOORDS, 0 }, { "texture_v", MESH_TEXCOORDS, 1 },
        { "red", MESH_COLORS, 0 }, { "green", MESH_COLORS, 1 }, { "blue", MESH_COLORS, 2 }, { "alpha", MESH_COLORS, 3 },
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        unsigned bit = 1u << names[i].component;
        if (strcmp(name, names[i].name) != 0 || (ply->components[names[i].attribute] & bit) != 0)
            continue;
        ply->components[names[i].attribute] |= bit;
        property->attribute = names[i].attribute;
        property->component = names[i].component;
        return 1;
    }
    return 0;
}

/* Takes "TYPE NAME" or "list TYPE TYPE NAME". */
static int ply_property_types(struct reader *r, struct ply_property *property)
{
    char word[WORD_BYTES];
    property->count_type = NULL;
    take_word(r, word);
    if (strcmp(word, "list") != 0)
        return ply_type_named(r, word, &property->type);
    take_word(r, word);
    if (!ply_type_named(r, word, &property->count_type))
        return 0;
    if (property->count_type->kind == PLY_FLOAT)
        return fail(r, "a list cannot have a count of type %s", word);
    take_word(r, word);
    return ply_type_named(r, word, &property->type);
}

static int ply_property_line(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    char name[WORD_BYTES];
    if (ply->num_elements == 0)
        return fail(r, "property before the first element");
    if (ply->num_properties == PLY_MAX_PROPERTIES)
        return fail(r, "more than %d properties", PLY_MAX_PROPERTIES);
    struct ply_element *element = &ply->element[ply->num_elements - 1];
    struct ply_property *property = &ply->property[ply->num_properties];
    if (!ply_property_types(r, property))
        return 0;
    take_word(r, name);
    property->role = ply_role_of(element, name, property->count_type != NULL);
    if (property->role == PLY_SKIPPED && element->kind == PLY_VERTEX && property->count_type == NULL
            && ply_is_attribute(ply, property, name))
        property->role = PLY_ATTRIBUTE;
    if (property->role == PLY_SKIPPED && element->count > 0)
        note_dropped(mesh, "property '%s' of element '%s'", name, element->name);
    if (property->role == PLY_CORNERS && property->type->kind == PLY_FLOAT)
        return fail(r, "vertex numbers of faces cannot be of type %s", property->type->name);
    element->end = ++ply->num_properties;
    return 1;
}

/* Takes lines up to and with end_header. */
static int ply_header(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    char word[WORD_BYTES];
    int has_encoding = 0;
    take_word(r, word);
    if (strcmp(word, "ply") != 0)
        return fail(r, "not a PLY file: no 'ply' at the start");
    while (strcmp(word, "end_header") != 0) {
        int ok = 1;
        next_line(r);
        if (!seek_word(r))
            return fail(r, "the file ends inside the header");
        take_word(r, word);
        if (strcmp(word, "format") == 0)
            ok = has_encoding = ply_encoding_line(r, ply);
        else if (strcmp(word, "element") == 0)
            ok = ply_element_line(r, ply);
        else if (strcmp(word, "property") == 0)
            ok = ply_property_line(r, ply, mesh);
        else if (strcmp(word, "comment") != 0 && strcmp(word, "obj_info") != 0 && strcmp(word, "end_header") != 0)
            ok = fail(r, "unknown header line '%s'", word);
        if (!ok)
            return 0;
    }
    next_line(r);
    return has_encoding || fail(r, "the header has no format line");
}

static size_t ply_count_role(const struct ply *ply, const struct ply_element *element, enum ply_role role)
{
    size_t count = 0;
    for (size_t i = element->first; i < element->end; i++)
        count += ply->property[i].role == role;
    return count;
}

/* Each role is played once, and the rows can be in the file: an item takes a digit and a blank, or its size. */
static int ply_check_element(struct reader *r, const struct ply *ply, const struct ply_element *element)
{
    size_t row = 0;
    for (size_t i = element->first; i < element->end; i++) {
        const struct ply_property *p = &ply->property[i];
        row += ply->encoding == PLY_ASCII ? 2 : p->count_type != NULL ? p->count_type->size : p->type->size;
    }
    if (element->count > 0 && (row == 0 || element->count > (r->size - r->at + 1) / row))
        return fail(r, "%zu rows of an element do not fit in the file", element->count);
    for (int role = PLY_X; role <= PLY_Z; role++)
        if (element->kind == PLY_VERTEX && ply_count_role(ply, element, (enum ply_role)role) != 1)
            return fail(r, "element vertex needs one property %c", 'x' + (role - PLY_X));
    if (element->kind == PLY_FACE && ply_count_role(ply, element, PLY_CORNERS) != 1)
        return fail(r, "element face needs one list vertex_indices or vertex_index");
    return 1;
}

static int ply_allocate(struct reader *r, const struct ply *ply, struct mesh_file *mesh)
{
    size_t vertices = 0, faces = 0;
    for (size_t i = 0; i < ply->num_elements; i++) {
        const struct ply_element *element = &ply->element[i];
        if (!ply_check_element(r, ply, element))
            return 0;
        vertices += element->kind == PLY_VERTEX ? element->count : 0;
        faces += element->kind == PLY_FACE ? element->count : 0;
    }
    return allocate(r, mesh, vertices, faces);
}

/* Only whole attributes are kept: all components, or of colors all but alpha. */
static int ply_allocate_attributes(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    static const unsigned whole[MESH_NUM_ATTRIBUTES] = { 7, 3, 7 };
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
        unsigned found = ply->components[a];
        int alpha = a == MESH_COLORS && (found & 8) != 0;
        if (found != 0 && (found & whole[a]) != whole[a])
            note_dropped(mesh, "%s: a component is missing", mesh_attribute_name((enum mesh_attribute)a));
        else if (found != 0
                 && !allocate_attribute(r, mesh, (enum mesh_attribute)a, a == MESH_TEXCOORDS ? 2 : 3 + alpha))
            return 0;
    }
    return 1;
}

/* -- PLY: data ----------------------------------------------------------------------------------------------------- */

static uint64_t load_bytes(const uint8_t *data, size_t size, int big_endian)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++)
        value = value << 8 | data[big_endian ? i : size - 1 - i];
    return value;
}

static float float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double double_of_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double ply_value(const struct ply_type *type, uint64_t bits)
{
    if (type->kind == PLY_FLOAT)
        return type->size == 4 ? (double)float_of_bits((uint32_t)bits) : double_of_bits(bits);
    int negative = type->kind == PLY_SIGNED && bits >> (8 * type->size - 1) != 0;
    return (double)bits - (negative ? ldexp(1, 8 * type->size) : 0);
}

static int ply_take_bits(struct reader *r, const struct ply *ply, const struct ply_type *type, uint64_t *bits)
{
    r->item = r->at;
    if (r->size - r->at < type->size)
        return fail(r, "the file ends inside its data");
    *bits = load_bytes(r->data + r->at, type->size, ply->encoding == PLY_BIG_ENDIAN);
    r->at += type->size;
    return 1;
}

static int ply_seek_word(struct reader *r)
{
    return seek_word(r) || fail(r, "the file ends inside its data");
}

static int ply_take(struct reader *r, const struct ply *ply, const struct ply_type *type, double *value)
{
    uint64_t bits;
    if (ply->encoding == PLY_ASCII)
        return ply_seek_word(r) && take_number(r, value);
    if (!ply_take_bits(r, ply, type, &bits))
        return 0;
    *value = ply_value(type, bits);
    return 1;
}

/* Takes a value that nobody needs, which in text may be "nan". */
static int ply_skip(struct reader *r, const struct ply *ply, const struct ply_type *type)
{
    char word[WORD_BYTES];
    uint64_t bits;
    if (ply->encoding != PLY_ASCII)
        return ply_take_bits(r, ply, type, &bits);
    if (!ply_seek_word(r))
        return 0;
    take_word(r, word);
    return 1;
}

static int ply_corners(struct reader *r, const struct ply *ply, const struct ply_type *type, struct mesh_file *mesh,
                       size_t face)
{
    double vertex;
    for (size_t i = 0; i < 3; i++)
        if (!ply_take(r, ply, type, &vertex) || !store_corner(r, mesh, 3 * face + i, vertex))
            return 0;
    return 1;
}

static int ply_list(struct reader *r, const struct ply *ply, const struct ply_property *property,
                    struct mesh_file *mesh, size_t row)
{
    double count;
    if (!ply_take(r, ply, property->count_type, &count))
        return 0;
    if (property->role == PLY_CORNERS)
        return check_corners(r, row, count) && ply_corners(r, ply, property->type, mesh, row);
    if (!(count >= 0 && count == floor(count)))
        return fail(r, "list of %.12g items", count);
    for (double i = 0; i < count; i++)
        if (!ply_skip(r, ply, property->type))
            return 0;
    return 1;
}

/* Takes a component of an attribute: NaN if it is no number. Integers are fractions of the largest one. */
static int ply_attribute(struct reader *r, const struct ply *ply, const struct ply_property *property,
                         struct mesh_file *mesh, size_t row)
{
    const struct ply_type *type = property->type;
    size_t components = (size_t)mesh->components[property->attribute];
    double value = NAN;
    if (ply->encoding == PLY_ASCII) {
        char word[WORD_BYTES];
        if (!ply_seek_word(r))
            return 0;
        take_word(r, word);
        value = parse_number(word, &value) ? value : NAN;
    } else if (!ply_take(r, ply, type, &value)) {
        return 0;
    }
    if (property->attribute == MESH_COLORS && type->kind != PLY_FLOAT)
        value /= ldexp(1, 8 * type->size - (type->kind == PLY_SIGNED)) - 1;
    if (mesh->attribute[property->attribute] != NULL)
        mesh->attribute[property->attribute][components * row + (size_t)property->component] = attribute_value(value);
    return 1;
}

static int ply_row(struct reader *r, const struct ply *ply, const struct ply_element *element, struct mesh_file *mesh,
                   size_t row)
{
    for (size_t i = element->first; i < element->end; i++) {
        const struct ply_property *property = &ply->property[i];
        double value;
        int ok = property->count_type != NULL ? ply_list(r, ply, property, mesh, row)
               : property->role == PLY_SKIPPED ? ply_skip(r, ply, property->type)
               : property->role == PLY_ATTRIBUTE ? ply_attribute(r, ply, property, mesh, row)
               : ply_take(r, ply, property->type, &value)
                 && store_coordinate(r, &mesh->positions[3 * row + (size_t)(property->role - PLY_X)], value);
        if (!ok)
            return 0;
    }
    return 1;
}

static int read_ply(struct reader *r, struct mesh_file *mesh)
{
    struct ply ply;
    memset(&ply, 0, sizeof ply);
    if (!ply_header(r, &ply, mesh) || !ply_allocate(r, &ply, mesh)
            || !ply_allocate_attributes(r, &ply, mesh))
        return 0;
    if (ply.encoding != PLY_ASCII)
        r->line = 0;
    for (size_t e = 0; e < ply.num_elements; e++)
        for (size_t row = 0; row < ply.element[e].count; row++)
            if (!ply_row(r, &ply, &ply.element[e], mesh, row))
                return 0;
    return 1;
}

/* -- STL ----------------------------------------------------------------------------------------------------------- */

#define STL_HEADER_BYTES 84          /* comment, number of triangles */
#define STL_TRIANGLE_BYTES 50        /* normal, three positions, two bytes that mean nothing */
#define STL_NO_VERTEX UINT32_MAX

/* Both readers first give each corner a vertex of its own. */
static int stl_allocate(struct reader *r, struct mesh_file *mesh, size_t faces)
{
    if (faces > UINT32_MAX / 3)
        return fail(r, "too many triangles");
    return allocate(r, mesh, 3 * faces, faces);
}

static int stl_read_binary(struct reader *r, struct mesh_file *mesh)
{
    r->line = 0;
    if (!stl_allocate(r, mesh, (r->size - STL_HEADER_BYTES) / STL_TRIANGLE_BYTES))
        return 0;
    for (size_t i = 0; i < 9 * (size_t)mesh->num_faces; i++) {
        r->item = STL_HEADER_BYTES + i / 9 * STL_TRIANGLE_BYTES + 12 + i % 9 * 4;
        float value = float_of_bits((uint32_t)load_bytes(r->data + r->item, 4, 0));
        if (!store_coordinate(r, &mesh->positions[i], (double)value))
            return 0;
    }
    return 1;
}

/* Counts the lines that begin with "vertex" and goes back to the start. */
static size_t stl_count_corners(struct reader *r)
{
    char word[WORD_BYTES];
    size_t corners = 0;
    while (seek_word(r)) {
        take_word(r, word);
        if (equal_ignoring_case(word, "vertex"))
            corners++;
        next_line(r);
    }
    r->at = 0;
    r->line = 1;
    return corners;
}

/* Lines that frame the positions: of these only "endloop" matters, at which a face must have its three corners. */
static int stl_frame_line(struct reader *r, const char *word, size_t corners, size_t *faces)
{
    static const char *const frame[] = { "solid", "facet", "outer", "endfacet", "endsolid" };
    if (equal_ignoring_case(word, "endloop"))
        return check_corners(r, *faces, (double)corners - 3 * (double)*faces) && ++*faces;
    for (size_t i = 0; i < sizeof frame / sizeof *frame; i++)
        if (equal_ignoring_case(word, frame[i]))
            return 1;
    return fail(r, "unknown STL line '%s'", word);
}

static int stl_read_text(struct reader *r, struct mesh_file *mesh)
{
    char word[WORD_BYTES];
    size_t corners = stl_count_corners(r), faces = 0;
    if (!stl_allocate(r, mesh, (corners + 2) / 3))
        return 0;
    corners = 0;
    while (seek_word(r)) {
        take_word(r, word);
        if (!(equal_ignoring_case(word, "vertex") ? take_position(r, &mesh->positions[3 * corners++])
                                                  : stl_frame_line(r, word, corners, &faces)))
            return 0;
        next_line(r);
    }
    return corners == 3 * faces || fail(r, "the file ends inside face %zu", faces);
}

static uint32_t hash_position(const float position[3])
{
    uint32_t bits[3], hash = 0;
    memcpy(bits, position, sizeof bits);
    for (int i = 0; i < 3; i++) {
        hash = (hash ^ bits[i]) * 0x9e3779b1u;
        hash ^= hash >> 15;
    }
    return hash;
}

/* The vertex with this position; a new one behind the others if there is none yet. */
static uint32_t find_or_add(struct mesh_file *mesh, uint32_t *table, size_t mask, const float position[3])
{
    size_t slot = hash_position(position) & mask;
    while (table[slot] != STL_NO_VERTEX
            && memcmp(&mesh->positions[3 * (size_t)table[slot]], position, 3 * sizeof *position) != 0)
        slot = (slot + 1) & mask;
    if (table[slot] == STL_NO_VERTEX) {
        table[slot] = mesh->num_vertices++;
        memmove(&mesh->positions[3 * (size_t)table[slot]], position, 3 * sizeof *position);
    }
    return table[slot];
}

/* Gives corners with equal positions the same vertex, numbered as they first occur. Works in place: the vertex is never
 * behind the corner. The table is at most half full. */
static int stl_weld(struct reader *r, struct mesh_file *mesh)
{
    size_t corners = 3 * (size_t)mesh->num_faces, slots = 2;
    while (slots < 2 * corners)
        slots *= 2;
    uint32_t *table = slots > SIZE_MAX / sizeof *table ? NULL : malloc(slots * sizeof *table);
    if (table == NULL)
        return fail(r, "out of memory for %zu corners", corners);
    memset(table, 0xff, slots * sizeof *table);
    mesh->num_vertices = 0;
    for (size_t i = 0; i < 3 * corners; i++)
        mesh->positions[i] += 0.0f;       /* -0 becomes 0: equal numbers have equal bytes */
    for (size_t c = 0; c < corners; c++)
        mesh->indices[c] = find_or_add(mesh, table, slots - 1, &mesh->positions[3 * c]);
    free(table);
    return 1;
}

/* A binary file is one whose size fits its count: its comment may begin with "solid" as a text does. */
static int stl_is_binary(const struct reader *r)
{
    return r->size >= STL_HEADER_BYTES && (r->size - STL_HEADER_BYTES) % STL_TRIANGLE_BYTES == 0
           && (r->size - STL_HEADER_BYTES) / STL_TRIANGLE_BYTES == load_bytes(r->data + STL_HEADER_BYTES - 4, 4, 0);
}

static int read_stl(struct reader *r, struct mesh_file *mesh)
{
    char word[WORD_BYTES];
    if (stl_is_binary(r))
        return stl_read_binary(r, mesh) && stl_weld(r, mesh);
    seek_word(r);
    take_word(r, word);
    if (!equal_ignoring_case(word, "solid"))
        return fail(r, "not an STL file: no 'solid' at the start, nor a size that fits a number of triangles");
    return stl_read_text(r, mesh) && stl_weld(r, mesh);
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
    struct reader r = { NULL, 0, 0, 0, 1, NULL };
    r.data = data;
    r.size = size;
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
    memset(mesh, 0, sizeof *mesh);
}

/* -- Writing ------------------------------------------------------------------------------------------------------- */

static void write_off(const struct mesh_file *mesh, FILE *file)
{
    fprintf(file, "OFF\n%lu %lu 0\n", (unsigned long)mesh->num_vertices, (unsigned long)mesh->num_faces);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        const float *p = &mesh->positions[3 * v];
        fprintf(file, "%.9g %.9g %.9g\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (size_t f = 0; f < mesh->num_faces; f++) {
        const uint32_t *i = &mesh->indices[3 * f];
        fprintf(file, "3 %lu %lu %lu\n", (unsigned long)i[0], (unsigned long)i[1], (unsigned long)i[2]);
    }
}

static void write_numbers(FILE *file, const float *numbers, int count)
{
    for (int i = 0; i < count; i++)
        fprintf(file, " %.9g", (double)numbers[i]);
}

static void write_obj_attribute(const struct mesh_file *mesh, FILE *file, enum mesh_attribute a, const char *word)
{
    size_t components = (size_t)mesh->components[a];
    for (size_t v = 0; mesh->attribute[a] != NULL && v < mesh->num_vertices; v++) {
        fputs(word, file);
        write_numbers(file, mesh->attribute[a] + components * v, mesh->components[a]);
        fputc('\n', file);
    }
}

static void write_obj_vertices(const struct mesh_file *mesh, FILE *file)
{
    size_t components = (size_t)mesh->components[MESH_COLORS];
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        fputc('v', file);
        write_numbers(file, mesh->positions + 3 * v, 3);
        if (mesh->attribute[MESH_COLORS] != NULL)
            write_numbers(file, mesh->attribute[MESH_COLORS] + components * v, 3);
        fputc('\n', file);
    }
}

/* A vertex has the same number everywhere. */
static void write_obj_face(const struct mesh_file *mesh, FILE *file, size_t face)
{
    int texcoords = mesh->attribute[MESH_TEXCOORDS] != NULL, normals = mesh->attribute[MESH_NORMALS] != NULL;
    fputc('f', file);
    for (size_t c = 3 * face; c < 3 * face + 3; c++) {
        unsigned long v = mesh->indices[c] + 1ul;
        fprintf(file, " %lu", v);
        if (texcoords)
            fprintf(file, "/%lu", v);
        if (normals)
            fprintf(file, texcoords ? "/%lu" : "//%lu", v);
    }
    fputc('\n', file);
}

/* In their order: a material holds until the next is named. */
static void write_obj_faces(const struct mesh_file *mesh, FILE *file)
{
    uint32_t material = 0;
    for (size_t f = 0; f < mesh->num_faces; f++) {
        if (mesh->materials != NULL && mesh->materials[f] != material)
            fprintf(file, "usemtl material_%lu\n", (unsigned long)(material = mesh->materials[f]));
        write_obj_face(mesh, file, f);
    }
}

static void write_obj(const struct mesh_file *mesh, FILE *file)
{
    write_obj_vertices(mesh, file);
    write_obj_attribute(mesh, file, MESH_TEXCOORDS, "vt");
    write_obj_attribute(mesh, file, MESH_NORMALS, "vn");
    write_obj_faces(mesh, file);
}

static void put_u32(uint8_t *bytes, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        bytes[i] = (uint8_t)(value >> 8 * i);
}

static void put_floats(uint8_t *bytes, const float *numbers, int count)
{
    for (int i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &numbers[i], sizeof bits);
        put_u32(bytes + 4 * i, bits);
    }
}

static void write_ply_header(const struct mesh_file *mesh, FILE *file)
{
    fprintf(file, "ply\nformat binary_little_endian 1.0\n"
            "element vertex %lu\nproperty float x\nproperty float y\nproperty float z\n",
            (unsigned long)mesh->num_vertices);
    if (mesh->attribute[MESH_NORMALS] != NULL)
        fputs("property float nx\nproperty float ny\nproperty float nz\n", file);
    if (mesh->attribute[MESH_TEXCOORDS] != NULL)
        fputs("property float s\nproperty float t\n", file);
    if (mesh->attribute[MESH_COLORS] != NULL)
        fputs("property uchar red\nproperty uchar green\nproperty uchar blue\n", file);
    if (mesh->attribute[MESH_COLORS] != NULL && mesh->components[MESH_COLORS] == 4)
        fputs("property uchar alpha\n", file);
    fprintf(file, "element face %lu\nproperty list uchar uint vertex_indices\nend_header\n",
            (unsigned long)mesh->num_faces);
}

static void write_ply_vertex(const struct mesh_file *mesh, FILE *file, size_t v)
{
    uint8_t row[12];
    put_floats(row, &mesh->positions[3 * v], 3);
    fwrite(row, 12, 1, file);
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
        if (mesh->attribute[a] == NULL)
            continue;
        size_t components = (size_t)mesh->components[a];
        const float *value = mesh->attribute[a] + components * v;
        if (a != MESH_COLORS)
            put_floats(row, value, mesh->components[a]);
        for (size_t i = 0; a == MESH_COLORS && i < components; i++)
            row[i] = (uint8_t)(255 * fmax(0, fmin((double)value[i], 1)) + 0.5);
        fwrite(row, components * (a == MESH_COLORS ? 1 : 4), 1, file);
    }
}

static void write_ply(const struct mesh_file *mesh, FILE *file)
{
    uint8_t row[13];
    write_ply_header(mesh, file);
    for (size_t v = 0; v < mesh->num_vertices; v++)
        write_ply_vertex(mesh, file, v);
    row[0] = 3;
    for (size_t f = 0; f < mesh->num_faces; f++) {
        for (size_t i = 0; i < 3; i++)
            put_u32(row + 1 + 4 * i, mesh->indices[3 * f + i]);
        fwrite(row, 13, 1, file);
    }
}

/* The unit normal of a triangle, in double against overflow; zero if it has no area. */
static void triangle_normal(const float *a, const float *b, const float *c, float normal[3])
{
    double u[3], v[3], n[3], length = 0;
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - (double)a[i];
        v[i] = (double)c[i] - (double)a[i];
    }
    for (int i = 0; i < 3; i++) {
        n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
        length += n[i] * n[i];
    }
    for (int i = 0; i < 3; i++)
        normal[i] = length > 0 ? (float)(n[i] / sqrt(length)) : 0;
}

static void write_stl(const struct mesh_file *mesh, FILE *file)
{
    uint8_t header[STL_HEADER_BYTES] = "binary STL", row[STL_TRIANGLE_BYTES] = { 0 };
    put_u32(header + STL_HEADER_BYTES - 4, mesh->num_faces);
    fwrite(header, sizeof header, 1, file);
    for (size_t f = 0; f < mesh->num_faces; f++) {
        const float *corner[3];
        float normal[3];
        for (size_t i = 0; i < 3; i++) {
            corner[i] = &mesh->positions[3 * (size_t)mesh->indices[3 * f + i]];
            put_floats(row + 12 + 12 * i, corner[i], 3);
        }
        triangle_normal(corner[0], corner[1], corner[2], normal);
        put_floats(row, normal, 3);
        fwrite(row, sizeof row, 1, file);
    }
}

int mesh_write(const struct mesh_file *mesh, FILE *file, enum mesh_format format)
{
    switch (format) {
    case MESH_OFF: write_off(mesh, file); break;
    case MESH_OBJ: write_obj(mesh, file); break;
    case MESH_PLY: write_ply(mesh, file); break;
    case MESH_STL: write_stl(mesh, file); break;
    default: return 0;
    }
    return !ferror(file);
}
