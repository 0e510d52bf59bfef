/* obj.c - reads OBJ. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Normals and texture coordinates have numbers of their own, and corners name them. */
static const char *const obj_words[FACE_ITEMS] = { "vn", "vt" };
static const char *const obj_label_words[MESH_NUM_LABELS] = { "usemtl", "g", "o" };

/* Lines that are not read, by their first word; the last one counts those for which there is no room, too. */
#define MAX_UNREAD 24

struct obj_unread {
    struct word word;
    size_t lines;
};

struct obj {
    size_t vertices, faces, items[FACE_ITEMS];      /* lines, in all; then so far, but for faces */
    size_t all[FACE_ITEMS];            /* items in all */
    struct faces face;
    struct label_names names[MESH_NUM_LABELS];
    struct obj_unread unread[MAX_UNREAD];
    size_t num_unread;
    size_t unknown[FACE_ITEMS];        /* corners that name an item which does not exist */
    int has_w, has_alpha, has_third;   /* 1 if there is a fourth coordinate, a fourth color, a third of textures */
    size_t with_others;                /* lines of vertices and items with words behind these */
    size_t continued_names;            /* lines of names that a backslash continues */
    int has_smoothing;
};

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

static int obj_find(struct word word, const char *const *words, int count)
{
    int i = 0;
    while (i < count && !word_is(word, words[i]))
        i++;
    return i;
}

/* "v1" is hardly a word of its own: without that vertex, faces would name others. */
static int obj_lacks_blank(struct word word)
{
    size_t letters = word.length > 2 && word.text[0] == 'v' && (word.text[1] == 't' || word.text[1] == 'n') ? 2 : 1;
    return word.length > letters && memchr("vflp", word.text[0], 4) != NULL
           && memchr("0123456789+-.", word.text[letters], 13) != NULL;
}

static void obj_count_line(struct obj *obj, struct word word)
{
    int item = obj_find(word, obj_words, FACE_ITEMS), label = obj_find(word, obj_label_words, MESH_NUM_LABELS);
    if (word_is(word, "v"))
        obj->vertices++;
    else if (word_is(word, "f") || word_is(word, "l") || word_is(word, "p"))
        obj->faces++;
    else if (item < FACE_ITEMS)
        obj->items[item]++;
    else if (label == MESH_NUM_LABELS && !word_is(word, "mtllib") && !word_is(word, "s"))
        count_unread(obj, word);
}

/* Counts lines by what they begin with, and goes back to the start. */
static int obj_count(struct reader *r, struct obj *obj)
{
    char text[WORD_BYTES];
    for (; seek_word(r); next_line(r)) {
        struct word word = take_word(r);
        if (obj_lacks_blank(word))
            return fail(r, "'%s' lacks a blank behind its first letters", show(text, word));
        obj_count_line(obj, word);
    }
    if (obj->faces == 0)
        return fail(r, "not an OBJ file, or one without faces: no line begins with 'f', 'l' or 'p'");
    return begin_text(r);
}

static int obj_allocate(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    static const int components[FACE_ITEMS] = { 3, 2 };
    if (!allocate(r, mesh, obj->vertices))
        return 0;
    memcpy(obj->all, obj->items, sizeof obj->all);
    for (int a = 0; a < FACE_ITEMS; a++) {
        struct mesh_values *values = &mesh->attribute[a];
        if (obj->all[a] == 0)
            continue;
        values->components = components[a];
        values->count = (uint32_t)obj->all[a];
        values->values = obj->all[a] < MESH_NONE ? calloc(obj->all[a], (size_t)components[a] * sizeof(float)) : NULL;
        obj->face.has_items[a] = 1;
        if (values->values == NULL)
            return fail(r, "out of memory for %s", mesh_attribute_name((enum mesh_attribute)a));
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

static void obj_end_line(struct reader *r, struct obj *obj)
{
    obj->with_others += take_word(r).length > 0;
}

/* Takes what follows a position. One number is a weight that only curves need, three are a color. */
static int obj_color(struct reader *r, struct mesh_file *mesh, struct obj *obj, size_t vertex)
{
    float rgba[4];
    int count = 0;
    struct reader before = *r;
    while (count < 4 && !isnan(rgba[count] = obj_optional_number(r))) {
        before = *r;
        count++;
    }
    *r = before;
    obj_end_line(r, obj);
    obj->with_others += count == 2;
    obj->has_w |= count == 1 && rgba[0] != 1;
    obj->has_alpha |= count == 4;
    if (count < 3)
        return 1;
    if (mesh->attribute[MESH_COLORS].values == NULL && !allocate_attribute(r, mesh, MESH_COLORS, 3))
        return 0;
    memcpy(&mesh->attribute[MESH_COLORS].values[3 * vertex], rgba, 3 * sizeof *rgba);
    return 1;
}

static int obj_vertex(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    size_t vertex = obj->vertices++;
    return take_position(r, mesh, vertex) && obj_color(r, mesh, obj, vertex);
}

static int obj_is_line_end(struct reader r)
{
    return take_word(&r).length == 0;
}

/* A texture coordinate that is missing is 0, but not both. */
static void obj_list_item(struct reader *r, struct mesh_file *mesh, struct obj *obj, int a)
{
    struct mesh_values *values = &mesh->attribute[a];
    float *item = values->values + (size_t)values->components * obj->items[a]++;
    for (int i = 0; i < values->components; i++)
        item[i] = a == MESH_TEXCOORDS && i > 0 && obj_is_line_end(*r) ? 0 : obj_optional_number(r);
    struct reader before = *r;
    float third = a == MESH_TEXCOORDS ? obj_optional_number(r) : NAN;
    if (isnan(third))
        *r = before;
    else
        obj->has_third |= third != 0;
    obj_end_line(r, obj);
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

/* The normal or texture coordinates of a corner. */
static uint32_t obj_item(struct obj *obj, int a, struct word word)
{
    double number = obj_number(word, obj->items[a]);
    if (word.length == 0)
        return MESH_NONE;
    if (number >= 0 && number < (double)obj->all[a] && number == floor(number))
        return (uint32_t)number;
    obj->unknown[a]++;
    return MESH_NONE;
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

static int obj_corner(struct reader *r, struct mesh_file *mesh, struct obj *obj, struct word word)
{
    char text[WORD_BYTES];
    struct word part[3];
    obj_cut(word, part);
    double vertex = obj_number(part[0], obj->vertices);
    if (isnan(vertex))
        return fail(r, "face %zu has a corner '%s'", obj->face.num_faces, show(text, part[0]));
    for (int a = 0; a < FACE_ITEMS; a++)
        obj->face.next.item[a] = obj_item(obj, a, part[a == MESH_TEXCOORDS ? 1 : 2]);
    return add_corner(r, mesh, &obj->face, vertex);
}

static int obj_face(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    for (struct word word = take_word(r); word.length > 0; word = take_word(r))
        if (!obj_corner(r, mesh, obj, word))
            return 0;
    return end_face(r, &obj->face);
}

/* Each corner but the first one ends a line that begins at the corner before. */
static int obj_polyline(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    int corners = 0;
    for (struct word word = take_word(r); word.length > 0; word = take_word(r), corners++) {
        struct face_corner last = obj->face.next;
        if (corners > 1 && !add_corner(r, mesh, &obj->face, last.vertex))
            return 0;
        if (!obj_corner(r, mesh, obj, word) || (corners > 0 && !end_face(r, &obj->face)))
            return 0;
    }
    return corners > 1 || fail(r, "a line with %d corner%s", corners, plural((size_t)corners));
}

static int obj_points(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    for (struct word word = take_word(r); word.length > 0; word = take_word(r))
        if (!obj_corner(r, mesh, obj, word) || !end_face(r, &obj->face))
            return 0;
    return 1;
}

/* -- Labels -------------------------------------------------------------------------------------------------------- */

/* The rest of the line; lines that continue it, which may be meant as others, are none of it. */
static struct word obj_name(struct reader *r, struct obj *obj)
{
    struct word name = take_rest(r);
    struct reader next = *r;
    if (name.length > 0 && name.text[name.length - 1] == '\\') {
        next.at = (size_t)(name.text - r->data) + name.length - 1;
        obj->continued_names += take_word(&next).length > 0 && next.line > r->line;
    }
    return name;
}

/* The rest of the line is the name: it may have spaces. Without one, no label holds. */
static int obj_label(struct reader *r, struct obj *obj, int label)
{
    struct word name = obj_name(r, obj);
    if (name.length > 0 && !add_label_name(r, &obj->names[label], name))
        return 0;
    obj->face.label[label] = name.length > 0 ? (uint32_t)obj->names[label].count : 0;
    return 1;
}

/* Numbers from 1, or "off". */
static void obj_smoothing(struct reader *r, struct obj *obj)
{
    double number, unit;
    int is_group = parse_number(take_word(r), &number, &unit) && number >= 1 && number < MESH_NONE;
    obj->face.label[FACE_SMOOTHING] = is_group ? (uint32_t)number : 0;
    obj->has_smoothing |= is_group;
}

/* -- All of it ----------------------------------------------------------------------------------------------------- */

static int obj_line(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    struct word word = take_word(r);
    int item = obj_find(word, obj_words, FACE_ITEMS), label = obj_find(word, obj_label_words, MESH_NUM_LABELS);
    if (word_is(word, "v"))
        return obj_vertex(r, mesh, obj);
    if (word_is(word, "f"))
        return obj_face(r, mesh, obj);
    if (word_is(word, "l"))
        return obj_polyline(r, mesh, obj);
    if (word_is(word, "p"))
        return obj_points(r, mesh, obj);
    if (label < MESH_NUM_LABELS)
        return obj_label(r, obj, label);
    if (word_is(word, "mtllib"))
        return add_line(r, &mesh->libraries, obj_name(r, obj));
    if (word_is(word, "s"))
        obj_smoothing(r, obj);
    if (item < FACE_ITEMS)
        obj_list_item(r, mesh, obj, item);
    return 1;
}

static int obj_lines(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    obj->vertices = obj->items[MESH_NORMALS] = obj->items[MESH_TEXCOORDS] = 0;
    for (; seek_word(r); next_line(r)) {
        struct reader line = *r;         /* whatever is read of it, the next line begins where obj_count had it */
        if (!obj_line(&line, mesh, obj))
            return 0;
    }
    return 1;
}

/* Are there lines that are faces or surfaces, or none of the format? */
static int obj_may_lack_faces(const struct obj *obj)
{
    static const char *const words[] = { "fo", "curv", "curv2", "surf", "call" };
    int few = obj->num_unread < MAX_UNREAD;
    for (size_t i = 0; i < obj->num_unread; i++) {
        const struct word word = obj->unread[i].word;
        if (!few || word.text[0] < 'a' || word.text[0] > 'z' || obj_find(word, words, 5) < 5)
            return 1;
    }
    return 0;
}

static void obj_notes(struct mesh_file *mesh, const struct obj *obj)
{
    char text[WORD_BYTES];
    for (int a = 0; a < FACE_ITEMS; a++)
        if (obj->unknown[a] > 0)
            note_attribute(mesh, "dropped: %s of %zu corner%s, which do not exist\n",
                           mesh_attribute_name((enum mesh_attribute)a), obj->unknown[a], plural(obj->unknown[a]));
    if (obj->has_smoothing && obj->all[MESH_NORMALS] > 0)
        note_attribute(mesh, "dropped: smoothing groups, as there are normals\n");
    if (obj->has_w)
        note(mesh, "dropped: w, the fourth coordinate of vertices\n");
    if (obj->has_alpha)
        note_attribute(mesh, "dropped: alpha of colors\n");
    if (obj->has_third)
        note_attribute(mesh, "dropped: the third texture coordinate\n");
    if (obj->with_others > 0)
        note(mesh, "dropped: words that mean nothing behind 'v', 'vt' or 'vn' (%zu)\n", obj->with_others);
    if (obj->continued_names > 0)
        note(mesh, "dropped: lines behind names that end in a backslash (%zu)\n", obj->continued_names);
    void (*tell)(struct mesh_file *, const char *, ...) = obj_may_lack_faces(obj) ? note : note_attribute;
    for (size_t i = 0; i < obj->num_unread; i++)
        tell(mesh, "%s%zu '%s'%s", i == 0 ? "dropped: lines that are not read: " : ", ", obj->unread[i].lines,
             show(text, obj->unread[i].word), i + 1 == MAX_UNREAD ? " and others" : "");
    if (obj->num_unread > 0)
        tell(mesh, "\n");
}

static int obj_read(struct reader *r, struct mesh_file *mesh, struct obj *obj)
{
    if (!obj_count(r, obj) || !obj_allocate(r, mesh, obj) || !obj_lines(r, mesh, obj)
            || !store_faces(r, mesh, &obj->face, obj->all[MESH_NORMALS] == 0))
        return 0;
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        if (!store_labels(r, mesh, (enum mesh_label)k, &obj->names[k]))
            return 0;
    obj_notes(mesh, obj);
    return 1;
}

int read_obj(struct reader *r, struct mesh_file *mesh)
{
    struct obj obj;
    memset(&obj, 0, sizeof obj);
    begin_faces(&obj.face);
    r->comments = r->continued = 1;
    int ok = begin_text(r) && obj_read(r, mesh, &obj);
    free_faces(&obj.face);
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        free(obj.names[k].name);
    return ok;
}
