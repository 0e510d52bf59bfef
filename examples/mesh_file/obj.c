/* obj.c - reads OBJ. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Normals and texture coordinates have numbers of their own, and corners name them: attribute a of the file is a list,
 * and corner[a] says for each corner which item it has, or OBJ_NONE. */
#define OBJ_NONE UINT32_MAX
enum { OBJ_LISTS = MESH_TEXCOORDS + 1 };

struct obj_material {
    struct word name;
    uint32_t line, first;              /* of the lines that name materials this one, from 1; the first with that name */
    uint32_t number;                   /* there: of the material; 0: no face has it yet */
};

/* Lines that are not read, by their first word; the last one counts those for which there is no room, too. */
#define MAX_UNREAD 24

struct obj_unread {
    struct word word;
    size_t lines;
};

struct obj {
    size_t vertices, faces;            /* lines, in all; then so far */
    size_t items[OBJ_LISTS];           /* likewise */
    size_t material_lines;             /* in all; then so far */
    struct obj_material *material;     /* of each such line */
    float *list[OBJ_LISTS];
    uint32_t *corner[OBJ_LISTS];
    struct obj_unread unread[MAX_UNREAD];
    size_t num_unread;
    int has_w, has_alpha, has_third;   /* 1 if there is a fourth coordinate, a fourth color, a third of textures */
};

static const char *const obj_words[OBJ_LISTS] = { "vn", "vt" };
static const int obj_components[OBJ_LISTS] = { 3, 2 };

/* -- First reading: counts ----------------------------------------------------------------------------------------- */

static void count_unread(struct obj *obj, struct word word)
{
    size_t i = 0;
    while (i < obj->num_unread && !same_word(word, obj->unread[i].word))
        i++;
    if (i == MAX_UNREAD)
        i--;
    if (i == obj->num_unread)
        obj->unread[obj->num_unread++].word = word;
    obj->unread[i].lines++;
}

static void obj_count_line(struct obj *obj, struct word word)
{
    if (word_is(word, "v"))
        obj->vertices++;
    else if (word_is(word, "f"))
        obj->faces++;
    else if (word_is(word, obj_words[MESH_NORMALS]))
        obj->items[MESH_NORMALS]++;
    else if (word_is(word, obj_words[MESH_TEXCOORDS]))
        obj->items[MESH_TEXCOORDS]++;
    else if (word_is(word, "usemtl"))
        obj->material_lines++;
    else
        count_unread(obj, word);
}

/* Counts lines by what they begin with, and goes back to the start. */
static int obj_count(struct reader *r, struct obj *obj)
{
    for (; seek_word(r); next_line(r))
        obj_count_line(obj, take_word(r));
    if (obj->faces == 0)
        return fail(r, "not an OBJ file, or one without faces: no line begins with 'f'");
    return begin_text(r);
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

/* -- Second reading: vertices -------------------------------------------------------------------------------------- */

/* The next number of the line, or NaN. */
static float obj_optional_number(struct reader *r)
{
    double value, unit;
    return parse_number(take_word(r), &value, &unit) ? attribute_value(value) : NAN;
}

/* Takes what follows a position. One number is a weight that only curves need, three are a color. */
static int obj_color(struct reader *r, struct mesh_file *mesh, struct obj *obj, size_t vertex)
{
    float rgba[4];
    for (int i = 0; i < 4; i++)
        rgba[i] = obj_optional_number(r);
    if (isnan(rgba[2])) {
        obj->has_w |= !isnan(rgba[0]) && rgba[0] != 1;
        return 1;
    }
    obj->has_alpha |= !isnan(rgba[3]);
    if (mesh->attribute[MESH_COLORS] == NULL && !allocate_attribute(r, mesh, MESH_COLORS, 3))
        return 0;
    memcpy(&mesh->attribute[MESH_COLORS][3 * vertex], rgba, 3 * sizeof *rgba);
    return 1;
}

static int obj_vertex(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    size_t vertex = obj->vertices++;
    return take_position(r, mesh, vertex) && obj_color(r, mesh, obj, vertex);
}

static void obj_list_item(struct reader *r, struct obj *obj, int a)
{
    float *item = obj->list[a] + (size_t)obj_components[a] * obj->items[a]++;
    for (int i = 0; i < obj_components[a]; i++)
        item[i] = obj_optional_number(r);
    if (a == MESH_TEXCOORDS) {
        float third = obj_optional_number(r);
        obj->has_third |= !isnan(third) && third != 0;
    }
}

/* -- Second reading: faces ----------------------------------------------------------------------------------------- */

/* A number of a corner counts from 1, or backwards from the last one yet, which is -1. NaN if it is none. */
static double obj_number(struct word word, size_t so_far)
{
    double number, unit;
    if (!parse_number(word, &number, &unit) || number == 0)
        return NAN;
    return number > 0 ? number - 1 : (double)so_far + number;
}

/* The normal or texture coordinates of a corner; OBJ_NONE for what does not exist. */
static uint32_t obj_item(struct word word, size_t so_far, size_t end)
{
    double number = obj_number(word, so_far);
    return number >= 0 && number < (double)end && number == floor(number) ? (uint32_t)number : OBJ_NONE;
}

/* Cuts "v/vt/vn" into its parts; missing ones are empty. */
static void obj_cut(struct word word, struct word part[3])
{
    for (int i = 0; i < 3; i++) {
        const uint8_t *slash = word.length > 0 ? memchr(word.text, '/', word.length) : NULL;
        size_t length = slash != NULL ? (size_t)(slash - word.text) : word.length;
        part[i].text = word.text;
        part[i].length = length;
        word.text += length + (slash != NULL);
        word.length -= length + (slash != NULL);
    }
}

static int obj_corner(struct reader *r, struct mesh_file *mesh, struct obj *obj, const size_t *all, size_t corner,
                      struct word word)
{
    char text[WORD_BYTES];
    struct word part[3];
    obj_cut(word, part);
    double vertex = obj_number(part[0], obj->vertices);
    if (isnan(vertex))
        return fail(r, "face %zu has a corner '%s'", corner / 3, show(text, part[0]));
    if (!store_corner(r, mesh, corner, vertex))
        return 0;
    for (int a = 0; a < OBJ_LISTS; a++)
        if (obj->corner[a] != NULL)
            obj->corner[a][corner] = obj_item(part[a == MESH_TEXCOORDS ? 1 : 2], obj->items[a], all[a]);
    return 1;
}

static int obj_face(struct reader *r, struct mesh_file *mesh, struct obj *obj, const size_t *all)
{
    size_t corners = 0;
    if (mesh->materials != NULL)
        mesh->materials[obj->faces] = (uint32_t)obj->material_lines;
    for (struct word word = take_word(r); word.length > 0; word = take_word(r), corners++)
        if (corners < 3 && !obj_corner(r, mesh, obj, all, 3 * obj->faces + corners, word))
            return 0;
    return check_corners(r, obj->faces++, (double)corners);
}

/* -- Materials ----------------------------------------------------------------------------------------------------- */

/* The rest of the line is the name: it may have spaces. */
static void obj_use_material(struct reader *r, struct obj *obj)
{
    struct obj_material *material = &obj->material[obj->material_lines++];
    material->name = take_rest(r);
    material->line = (uint32_t)obj->material_lines;
}

static int compare_names(const struct obj_material *a, const struct obj_material *b)
{
    if (a->name.length != b->name.length)
        return a->name.length < b->name.length ? -1 : 1;
    return memcmp(a->name.text, b->name.text, a->name.length);
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
    note(mesh, "dropped: names of materials: the first of %lu comes back as material_1, and so on\n",
         (unsigned long)mesh->num_materials);
}

/* -- All of it ----------------------------------------------------------------------------------------------------- */

static int obj_line(struct reader *r, struct mesh_file *mesh, struct obj *obj, const size_t *all)
{
    struct word word = take_word(r);
    if (word_is(word, "v"))
        return obj_vertex(r, mesh, obj);
    if (word_is(word, "f"))
        return obj_face(r, mesh, obj, all);
    if (word_is(word, "usemtl"))
        obj_use_material(r, obj);
    for (int a = 0; a < OBJ_LISTS; a++)
        if (word_is(word, obj_words[a]))
            obj_list_item(r, obj, a);
    return 1;
}

static int obj_lines(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    size_t all[OBJ_LISTS];
    memcpy(all, obj->items, sizeof all);
    obj->vertices = obj->faces = obj->items[MESH_NORMALS] = obj->items[MESH_TEXCOORDS] = obj->material_lines = 0;
    for (; seek_word(r); next_line(r)) {
        struct reader line = *r;         /* whatever is read of it, the next line begins where obj_count had it */
        if (!obj_line(&line, mesh, obj, all))
            return 0;
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

static void obj_notes(struct mesh_file *mesh, const struct obj *obj)
{
    char text[WORD_BYTES];
    if (obj->has_w)
        note(mesh, "dropped: w, the fourth coordinate of vertices\n");
    if (obj->has_alpha)
        note(mesh, "dropped: alpha of colors\n");
    if (obj->has_third)
        note(mesh, "dropped: the third texture coordinate\n");
    for (size_t i = 0; i < obj->num_unread; i++)
        note(mesh, "%s%zu '%s'%s", i == 0 ? "dropped: lines that are not read: " : ", ", obj->unread[i].lines,
             show(text, obj->unread[i].word), i + 1 == MAX_UNREAD ? " and others" : "");
    if (obj->num_unread > 0)
        note(mesh, "\n");
}

static int obj_read(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    if (!obj_count(r, obj) || !obj_allocate(r, mesh, obj) || !obj_lines(r, mesh, obj)
            || !obj_attribute(r, mesh, obj, MESH_NORMALS) || !obj_attribute(r, mesh, obj, MESH_TEXCOORDS))
        return 0;
    obj_materials(mesh, obj);
    obj_notes(mesh, obj);
    return 1;
}

int read_obj(struct reader *r, struct mesh_file *mesh)
{
    struct obj obj;
    memset(&obj, 0, sizeof obj);
    r->comments = r->continued = 1;
    int ok = begin_text(r) && obj_read(r, mesh, &obj);
    free(obj.material);
    for (int a = 0; a < OBJ_LISTS; a++) {
        free(obj.list[a]);
        free(obj.corner[a]);
    }
    return ok;
}
