/* ply.c - reads PLY. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- Header --------------------------------------------------------------------------------------------------- */

#define PLY_MAX_ELEMENTS 32
#define PLY_MAX_PROPERTIES 256       /* of all elements together */
#define PLY_MAX_TEXTURES 65536

enum ply_encoding { PLY_ASCII, PLY_LITTLE_ENDIAN, PLY_BIG_ENDIAN };
enum ply_role { PLY_X, PLY_Y, PLY_Z, PLY_CORNERS, PLY_TEXCOORDS, PLY_TEXNUMBER, PLY_ATTRIBUTE, PLY_SKIPPED };

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
    struct word name;
};

struct ply_element {
    enum { PLY_VERTEX, PLY_FACE, PLY_STRIPS, PLY_OTHER } kind;
    size_t count;
    size_t first, end;                   /* its properties */
    struct word name;
};

struct ply {
    enum ply_encoding encoding;
    unsigned components[MESH_NUM_ATTRIBUTES];   /* those that properties have, a bit for each */
    size_t num_elements, num_properties;
    struct ply_element element[PLY_MAX_ELEMENTS];
    struct ply_property property[PLY_MAX_PROPERTIES];
    struct faces face;
    struct label_names texture;          /* those that comments name */
    size_t unknown_lines;                /* of the header; the first one: */
    struct word unknown;
    float *texcoords;                    /* of corners */
    size_t num_texcoords, texcoord_room;
    size_t without;                      /* faces with a texture number that means nothing */
    size_t with_other_texcoords;         /* faces with another number of them than corners have */
};

static int ply_type_named(struct reader *r, struct word name, const struct ply_type **type)
{
    char text[WORD_BYTES];
    static const struct ply_type types[] = {
        { "char", "int8", 1, PLY_SIGNED },     { "uchar", "uint8", 1, PLY_UNSIGNED },
        { "short", "int16", 2, PLY_SIGNED },   { "ushort", "uint16", 2, PLY_UNSIGNED },
        { "int", "int32", 4, PLY_SIGNED },     { "uint", "uint32", 4, PLY_UNSIGNED },
        { "float", "float32", 4, PLY_FLOAT },  { "double", "float64", 8, PLY_FLOAT },
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (word_is(name, types[i].name) || word_is(name, types[i].other_name)) {
            *type = &types[i];
            return 1;
        }
    return fail(r, "unknown type '%s'", show(text, name));
}

static int ply_encoding_line(struct reader *r, struct ply *ply)
{
    static const char *const names[] = { "ascii", "binary_little_endian", "binary_big_endian" };
    char text[WORD_BYTES];
    struct word word = take_word(r);
    for (int i = 0; i < 3; i++)
        if (word_is(word, names[i])) {
            ply->encoding = (enum ply_encoding)i;
            return 1;
        }
    return fail(r, "unknown PLY encoding '%s'", show(text, word));
}

static int ply_element_kind(struct reader *r, struct ply *ply, struct ply_element *element)
{
    char text[WORD_BYTES];
    element->name = take_word(r);
    element->kind = word_is(element->name, "vertex") ? PLY_VERTEX
                  : word_is(element->name, "face") ? PLY_FACE
                  : word_is(element->name, "tristrips") ? PLY_STRIPS : PLY_OTHER;
    for (size_t i = 0; i < ply->num_elements; i++)
        if (element->kind != PLY_OTHER && ply->element[i].kind == element->kind)
            return fail(r, "second element '%s'", show(text, element->name));
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
static enum ply_role ply_role_of(const struct ply_element *element, struct word name, int is_list)
{
    if (element->kind == PLY_VERTEX && !is_list && name.length == 1 && name.text[0] >= 'x' && name.text[0] <= 'z')
        return (enum ply_role)(PLY_X + (name.text[0] - 'x'));
    if ((element->kind == PLY_FACE || element->kind == PLY_STRIPS) && is_list
            && (word_is(name, "vertex_indices") || word_is(name, "vertex_index")))
        return PLY_CORNERS;
    if (element->kind == PLY_FACE && is_list && word_is(name, "texcoord"))
        return PLY_TEXCOORDS;
    if (element->kind == PLY_FACE && !is_list && word_is(name, "texnumber"))
        return PLY_TEXNUMBER;
    return PLY_SKIPPED;
}

/* Is a scalar of the vertices part of an attribute? Each component is read from its first property. */
static int ply_is_attribute(struct ply *ply, struct ply_property *property, struct word name)
{
    static const struct { const char *name; enum mesh_attribute attribute; int component; } names[] = {
        { "nx", MESH_NORMALS, 0 }, { "ny", MESH_NORMALS, 1 }, { "nz", MESH_NORMALS, 2 },
        { "s", MESH_TEXCOORDS, 0 }, { "t", MESH_TEXCOORDS, 1 }, { "u", MESH_TEXCOORDS, 0 }, { "v", MESH_TEXCOORDS, 1 },
        { "texture_u", MESH_TEXCOORDS, 0 }, { "texture_v", MESH_TEXCOORDS, 1 },
        { "red", MESH_COLORS, 0 }, { "green", MESH_COLORS, 1 }, { "blue", MESH_COLORS, 2 }, { "alpha", MESH_COLORS, 3 },
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        unsigned bit = 1u << names[i].component;
        if (!word_is(name, names[i].name) || (ply->components[names[i].attribute] & bit) != 0)
            continue;
        ply->components[names[i].attribute] |= bit;
        property->attribute = names[i].attribute;
        property->component = names[i].component;
        return 1;
    }
    return 0;
}

/* Takes "TYPE" or "list TYPE TYPE". */
static int ply_property_types(struct reader *r, struct ply_property *property)
{
    struct word word = take_word(r);
    property->count_type = NULL;
    if (!word_is(word, "list"))
        return ply_type_named(r, word, &property->type);
    if (!ply_type_named(r, take_word(r), &property->count_type))
        return 0;
    if (property->count_type->kind == PLY_FLOAT)
        return fail(r, "a list cannot have a count of type %s", property->count_type->name);
    return ply_type_named(r, take_word(r), &property->type);
}

static int ply_property_line(struct reader *r, struct ply *ply)
{
    if (ply->num_elements == 0)
        return fail(r, "property before the first element");
    if (ply->num_properties == PLY_MAX_PROPERTIES)
        return fail(r, "more than %d properties", PLY_MAX_PROPERTIES);
    struct ply_element *element = &ply->element[ply->num_elements - 1];
    struct ply_property *property = &ply->property[ply->num_properties];
    if (!ply_property_types(r, property))
        return 0;
    property->name = take_word(r);
    property->role = ply_role_of(element, property->name, property->count_type != NULL);
    if (property->role == PLY_SKIPPED && element->kind == PLY_VERTEX && property->count_type == NULL
            && ply_is_attribute(ply, property, property->name))
        property->role = PLY_ATTRIBUTE;
    if (property->role == PLY_CORNERS && property->type->kind == PLY_FLOAT)
        return fail(r, "vertex numbers of faces cannot be of type %s", property->type->name);
    element->end = ++ply->num_properties;
    return 1;
}

/* One note for each element that has properties which are not read. */
static void ply_note_skipped(const struct ply *ply, struct mesh_file *mesh)
{
    char text[WORD_BYTES];
    for (size_t e = 0; e < ply->num_elements; e++) {
        const struct ply_element *element = &ply->element[e];
        size_t skipped = 0;
        for (size_t i = element->first; i < element->end && element->count > 0; i++)
            if (ply->property[i].role == PLY_SKIPPED) {
                if (skipped++ == 0)
                    note_attribute(mesh, "dropped: properties of element '%s': ", show(text, element->name));
                note_attribute(mesh, "%s'%s'", skipped > 1 ? ", " : "", show(text, ply->property[i].name));
            }
        if (skipped > 0)
            note_attribute(mesh, "\n");
    }
}

/* A texture without a name has its number as one. */
static int ply_add_texture(struct reader *r, struct ply *ply, struct word name)
{
    struct word number = { NULL, ply->texture.count };
    return add_label_name(r, &ply->texture, name.length > 0 ? name : number);
}

/* MeshLab names the images of textures in comments, in the order of their numbers. */
static int ply_comment(struct reader *r, struct ply *ply)
{
    return !word_is(take_word(r), "TextureFile") || ply_add_texture(r, ply, take_rest(r));
}

static int ply_header_line(struct reader *r, struct ply *ply, struct word word, int *has_encoding)
{
    if (word_is(word, "format"))
        return *has_encoding = ply_encoding_line(r, ply);
    if (word_is(word, "element"))
        return ply_element_line(r, ply);
    if (word_is(word, "property"))
        return ply_property_line(r, ply);
    if (word_is(word, "comment"))
        return ply_comment(r, ply);
    if (!word_is(word, "obj_info") && !word_is(word, "end_header") && ply->unknown_lines++ == 0)
        ply->unknown = word;
    return 1;
}

/* Takes lines up to and with end_header. If the first ends in a lone \r, all do, and a \n behind the last is data. */
static int ply_header(struct reader *r, struct ply *ply)
{
    int has_encoding = 0;
    struct word word = take_word(r);
    if (!word_is(word, "ply"))
        return fail(r, "not a PLY file: no 'ply' at the start");
    r->lone_cr = r->size - r->at >= 2 && r->data[r->at] == '\r' && r->data[r->at + 1] != '\n';
    while (!word_is(word, "end_header")) {
        next_line(r);
        if (!seek_word(r))
            return fail(r, "the file ends inside the header");
        word = take_word(r);
        if (!ply_header_line(r, ply, word, &has_encoding))
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
    if ((element->kind == PLY_FACE || element->kind == PLY_STRIPS) && ply_count_role(ply, element, PLY_CORNERS) != 1)
        return fail(r, "element %s needs one list vertex_indices or vertex_index",
                    element->kind == PLY_FACE ? "face" : "tristrips");
    return 1;
}

static int ply_allocate(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    size_t vertices = 0, elements[PLY_OTHER + 1] = { 0 };
    for (size_t i = 0; i < ply->num_elements; i++) {
        const struct ply_element *element = &ply->element[i];
        if (!ply_check_element(r, ply, element))
            return 0;
        vertices += element->kind == PLY_VERTEX ? element->count : 0;
        elements[element->kind]++;
    }
    if (elements[PLY_VERTEX] == 0)
        return fail(r, "no element 'vertex'");
    if (elements[PLY_FACE] + elements[PLY_STRIPS] == 0)
        return fail(r, "no element 'face' or 'tristrips'");
    return allocate(r, mesh, vertices);
}

/* Only whole attributes are kept: all components, or of colors all but alpha. */
static int ply_allocate_attributes(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    static const unsigned whole[MESH_NUM_ATTRIBUTES] = { 7, 3, 7 };
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
        unsigned found = ply->components[a];
        int alpha = a == MESH_COLORS && (found & 8) != 0;
        if (found != 0 && (found & whole[a]) != whole[a])
            note_attribute(mesh, "dropped: %s: a component is missing\n", mesh_attribute_name((enum mesh_attribute)a));
        else if (found != 0
                 && !allocate_attribute(r, mesh, (enum mesh_attribute)a, a == MESH_TEXCOORDS ? 2 : 3 + alpha))
            return 0;
    }
    return 1;
}

/* -- Data ---------------------------------------------------------------------------------------------------------- */

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

static int ply_seek_row(struct reader *r)
{
    return seek_word(r) || fail(r, "the file ends inside its data");
}

/* Each row has a line, but for long lists, unless there are too few lines or the first has too few words. */
static int ply_seek_word(struct reader *r)
{
    struct reader next = *r;
    if (r->free_form)
        return ply_seek_row(r);
    return take_word(&next).length > 0 || fail(r, "number expected, found the end of the line");
}

static int ply_has_lines(struct reader r, const struct ply *ply)
{
    size_t rows = 0, lines = 0, words = 0, needed = 0;
    for (size_t e = 0; e < ply->num_elements; e++) {
        if (rows == 0 && ply->element[e].count > 0)
            needed = ply->element[e].end - ply->element[e].first;
        rows += ply->element[e].count;
    }
    seek_word(&r);
    for (struct reader first = r; take_word(&first).length > 0;)
        words++;
    for (; lines < rows && seek_word(&r); next_line(&r))
        lines++;
    return lines == rows && words >= needed;
}

static int ply_take(struct reader *r, const struct ply *ply, const struct ply_type *type, double *value)
{
    uint64_t bits = 0;
    if (ply->encoding == PLY_ASCII)
        return ply_seek_word(r) && take_number(r, value);
    if (!ply_take_bits(r, ply, type, &bits))
        return 0;
    *value = ply_value(type, bits);
    return 1;
}

/* Takes a number of an attribute: NaN if it is none. */
static int ply_take_number(struct reader *r, const struct ply *ply, const struct ply_type *type, double *value)
{
    double unit;
    if (ply->encoding != PLY_ASCII)
        return ply_take(r, ply, type, value);
    if (!ply_seek_word(r))
        return 0;
    if (!parse_number(take_word(r), value, &unit))
        *value = NAN;
    return 1;
}

/* Takes a value that nobody needs, which in text may be "nan". */
static int ply_skip(struct reader *r, const struct ply *ply, const struct ply_type *type)
{
    uint64_t bits = 0;
    if (ply->encoding != PLY_ASCII)
        return ply_take_bits(r, ply, type, &bits);
    if (!ply_seek_word(r))
        return 0;
    take_word(r);
    return 1;
}

/* Three vertices of a strip, of which each second triangle is the other way round. Strips repeat vertices to turn. */
static int ply_strip_triangle(struct reader *r, struct ply *ply, const struct mesh_file *mesh, const double last[3],
                              int odd)
{
    if (last[0] == last[1] || last[1] == last[2] || last[0] == last[2])
        return 1;
    return add_corner(r, mesh, &ply->face, last[odd]) && add_corner(r, mesh, &ply->face, last[1 - odd])
           && add_corner(r, mesh, &ply->face, last[2]) && end_face(r, &ply->face);
}

/* -1 ends a strip and begins the next. */
static int ply_strips(struct reader *r, struct ply *ply, const struct ply_type *type, struct mesh_file *mesh, double count)
{
    double last[3] = { 0 };
    int length = 0;              /* of the strip; from 3 on, 3 if it is odd and 4 if it is even */
    for (double i = 0; i < count; i++) {
        last[0] = last[1];
        last[1] = last[2];
        if (!ply_take(r, ply, type, &last[2]))
            return 0;
        length = last[2] == -1 ? 0 : length < 4 ? length + 1 : 3;
        if (length >= 3 && !ply_strip_triangle(r, ply, mesh, last, length == 4))
            return 0;
    }
    return 1;
}

static int ply_corners(struct reader *r, struct ply *ply, const struct ply_type *type, struct mesh_file *mesh,
                       double count)
{
    double vertex;
    for (double i = 0; i < count; i++)
        if (!ply_take(r, ply, type, &vertex) || !add_corner(r, mesh, &ply->face, vertex))
            return 0;
    return 1;
}

/* Two numbers for each corner. */
static int ply_texcoords(struct reader *r, struct ply *ply, const struct ply_type *type, double count)
{
    for (double i = 0; i < count; i++) {
        double value;
        if (ply->num_texcoords == ply->texcoord_room) {
            size_t room = 2 * ply->texcoord_room + 64;
            float *larger = room < SIZE_MAX / sizeof *larger ? realloc(ply->texcoords, room * sizeof *larger) : NULL;
            if (larger == NULL)
                return fail(r, "out of memory for texture coordinates");
            ply->texcoords = larger;
            ply->texcoord_room = room;
        }
        if (!ply_take_number(r, ply, type, &value))
            return 0;
        ply->texcoords[ply->num_texcoords++] = attribute_value(value);
    }
    return 1;
}

static int ply_list_items(struct reader *r, struct ply *ply, const struct ply_property *property, int is_face,
                          struct mesh_file *mesh, double count)
{
    if (property->role == PLY_CORNERS && is_face)
        return ply_corners(r, ply, property->type, mesh, count);
    if (property->role == PLY_CORNERS)
        return ply_strips(r, ply, property->type, mesh, count);
    if (property->role == PLY_TEXCOORDS)
        return ply_texcoords(r, ply, property->type, count);
    for (double i = 0; i < count; i++)
        if (!ply_skip(r, ply, property->type))
            return 0;
    return 1;
}

static int ply_list(struct reader *r, struct ply *ply, const struct ply_property *property, int is_face,
                    struct mesh_file *mesh)
{
    double count;
    int free_form = r->free_form;
    if (!ply_take(r, ply, property->count_type, &count))
        return 0;
    if (!(count >= 0 && count == floor(count)))
        return fail(r, "list of %.12g items", count);
    r->free_form = 1;
    int ok = ply_list_items(r, ply, property, is_face, mesh, count);
    r->free_form = free_form;
    return ok;
}

/* -1 means none. */
static int ply_texnumber(struct reader *r, struct ply *ply, const struct ply_type *type)
{
    double number;
    if (!ply_take(r, ply, type, &number))
        return 0;
    int is_good = number >= 0 && number < PLY_MAX_TEXTURES && number == floor(number);
    ply->face.label[MESH_MATERIALS] = is_good ? (uint32_t)number + 1 : 0;
    ply->without += !is_good && number != -1;
    return 1;
}

/* Takes a component of an attribute. Integers of colors are fractions of the largest one. */
static int ply_attribute(struct reader *r, const struct ply *ply, const struct ply_property *property,
                         struct mesh_file *mesh, size_t row)
{
    const struct ply_type *type = property->type;
    struct mesh_values *a = &mesh->attribute[property->attribute];
    double value;
    if (!ply_take_number(r, ply, type, &value))
        return 0;
    if (property->attribute == MESH_COLORS && type->kind != PLY_FLOAT)
        value /= ldexp(1, 8 * type->size - (type->kind == PLY_SIGNED)) - 1;
    if (a->values != NULL)
        a->values[(size_t)a->components * row + (size_t)property->component] = attribute_value(value);
    return 1;
}

static int ply_coordinate(struct reader *r, const struct ply *ply, const struct ply_property *property,
                          struct mesh_file *mesh, size_t row)
{
    double value, unit = 0;
    size_t i = 3 * row + (size_t)(property->role - PLY_X);
    if (ply->encoding != PLY_ASCII)
        return ply_take(r, ply, property->type, &value) && store_coordinate(r, mesh, i, value, 0);
    return ply_seek_word(r) && take_number_and_unit(r, &value, &unit) && store_coordinate(r, mesh, i, value, unit);
}

static int ply_item(struct reader *r, struct ply *ply, const struct ply_property *property, int is_face,
                    struct mesh_file *mesh, size_t row)
{
    if (property->count_type != NULL)
        return ply_list(r, ply, property, is_face, mesh);
    switch (property->role) {
    case PLY_SKIPPED: return ply_skip(r, ply, property->type);
    case PLY_ATTRIBUTE: return ply_attribute(r, ply, property, mesh, row);
    case PLY_TEXNUMBER: return ply_texnumber(r, ply, property->type);
    default: return ply_coordinate(r, ply, property, mesh, row);
    }
}

/* Texture coordinates may come before the corners that they belong to; they count if each corner has two. */
static int ply_end_face(struct reader *r, struct ply *ply, size_t first_corner, size_t first_texcoord)
{
    size_t corners = ply->face.num_corners - first_corner, numbers = ply->num_texcoords - first_texcoord;
    for (size_t i = 0; i < corners && numbers == 2 * corners; i++)
        ply->face.corner[first_corner + i].item[MESH_TEXCOORDS] = (uint32_t)(first_texcoord / 2 + i);
    if (numbers != 2 * corners) {
        ply->num_texcoords = first_texcoord;
        ply->with_other_texcoords += numbers > 0;
    }
    return end_face(r, &ply->face);
}

static int ply_row(struct reader *r, struct ply *ply, const struct ply_element *element, struct mesh_file *mesh,
                   size_t row)
{
    char text[WORD_BYTES];
    size_t first_corner = ply->face.num_corners, first_texcoord = ply->num_texcoords;
    if (ply->encoding == PLY_ASCII && !ply_seek_row(r))
        return 0;
    for (size_t i = element->first; i < element->end; i++)
        if (!ply_item(r, ply, &ply->property[i], element->kind == PLY_FACE, mesh, row))
            return 0;
    if (ply->encoding == PLY_ASCII && !r->free_form && take_word(r).length > 0)
        return fail(r, "row %zu of element '%s' has more numbers than the header says", row, show(text, element->name));
    return element->kind != PLY_FACE || ply_end_face(r, ply, first_corner, first_texcoord);
}

static int ply_rows(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    for (size_t e = 0; e < ply->num_elements; e++) {
        memset(ply->face.label, 0, sizeof ply->face.label);
        for (size_t row = 0; row < ply->element[e].count; row++)
            if (!ply_row(r, ply, &ply->element[e], mesh, row))
                return 0;
    }
    return 1;
}

static int ply_says_faces(const struct ply *ply)
{
    size_t rows = 0;
    for (size_t e = 0; e < ply->num_elements; e++)
        if (ply->element[e].kind == PLY_FACE || ply->element[e].kind == PLY_STRIPS)
            rows += ply->element[e].count;
    return rows > 0;
}

/* Is there something behind the last row? In text, a word. */
static int ply_has_more(struct reader *r, const struct ply *ply)
{
    return ply->encoding == PLY_ASCII ? seek_word(r) : r->at < r->size;
}

/* What follows the last row is told; but not where it says that the counts are wrong. A binary face takes 4 bytes. */
static int ply_check_end(struct reader *r, const struct ply *ply)
{
    if (!ply_has_more(r, ply))
        return 1;
    if (ply->encoding == PLY_ASCII && r->free_form)
        return fail(r, "there are more numbers than the rows of the header have");
    r->item = r->at;
    return ply_says_faces(ply) || (ply->encoding != PLY_ASCII && r->size - r->at < 4)
           || fail(r, "the file says that it has no faces, and does not end there");
}

/* Those of corners are kept rather than those of vertices. */
static void ply_store_texcoords(struct ply *ply, struct mesh_file *mesh)
{
    struct mesh_values *a = &mesh->attribute[MESH_TEXCOORDS];
    if (ply->num_texcoords == 0)
        return;
    if (a->values != NULL)
        note_attribute(mesh, "dropped: texture coordinates of vertices, as there are some of corners\n");
    free(a->values);
    a->values = ply->texcoords;
    a->components = 2;
    a->count = (uint32_t)(ply->num_texcoords / 2);
    ply->texcoords = NULL;
    ply->face.has_items[MESH_TEXCOORDS] = 1;
}

/* There may be more textures than comments. */
static int ply_store_textures(struct reader *r, struct ply *ply, struct mesh_file *mesh)
{
    uint32_t *texture = mesh->label[MESH_MATERIALS].of_face, last = 0;
    for (size_t f = 0; f < mesh->num_faces && texture != NULL; f++)
        last = texture[f] > last ? texture[f] : last;
    const struct word no_name = { NULL, 0 };
    while (ply->texture.count < last)
        if (!ply_add_texture(r, ply, no_name))
            return 0;
    return store_labels(r, mesh, MESH_MATERIALS, &ply->texture);
}

static void ply_notes(struct reader *r, const struct ply *ply, struct mesh_file *mesh)
{
    char text[WORD_BYTES];
    if (ply->unknown_lines > 0)
        note(mesh, "dropped: header lines that are not PLY (%zu), the first begins with '%s'\n", ply->unknown_lines,
             show(text, ply->unknown));
    if (ply->without > 0)
        note_attribute(mesh, "dropped: texture numbers that are none (%zu)\n", ply->without);
    if (ply->with_other_texcoords > 0)
        note_attribute(mesh, "dropped: texture coordinates of faces that have not two for each corner (%zu)\n",
                       ply->with_other_texcoords);
    ply_note_skipped(ply, mesh);
    if (ply_has_more(r, ply))
        note(mesh, "dropped: what follows the last row of data\n");
}

static int ply_read(struct reader *r, struct mesh_file *mesh, struct ply *ply)
{
    if (!begin_text(r) || !ply_header(r, ply) || !ply_allocate(r, ply, mesh) || !ply_allocate_attributes(r, ply, mesh))
        return 0;
    if (ply->encoding != PLY_ASCII)
        r->line = 0;
    r->free_form = ply->encoding == PLY_ASCII && !ply_has_lines(*r, ply);
    if (!ply_rows(r, ply, mesh))
        return 0;
    if (ply->face.num_faces == 0 && ply_says_faces(ply))
        return fail(r, "no strip has a triangle");
    if (!ply_check_end(r, ply))
        return 0;
    ply_store_texcoords(ply, mesh);
    if (!store_faces(r, mesh, &ply->face, 0) || !ply_store_textures(r, ply, mesh))
        return 0;
    ply_notes(r, ply, mesh);
    return 1;
}

int read_ply(struct reader *r, struct mesh_file *mesh)
{
    struct ply ply;
    memset(&ply, 0, sizeof ply);
    begin_faces(&ply.face);
    int ok = ply_read(r, mesh, &ply);
    free_faces(&ply.face);
    free(ply.texture.name);
    free(ply.texcoords);
    return ok;
}
