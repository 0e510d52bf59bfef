/* off.c - reads OFF. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
#include <string.h>

#define MAX_EXTRA 9        /* numbers behind a position that mean something: normal, color with alpha, texture */

struct off {
    int normals, colors, texcoords, homogeneous;    /* which of these the keyword announces */
    int colors_first;                               /* before the normals */
    size_t color_components;
    size_t num_faces;
    size_t vertex_extras;                           /* numbers of vertex 0 that the keyword does not announce */
    int face_extras;                                /* 1 if faces have such */
};

/* -- The keyword and the counts ------------------------------------------------------------------------------------ */

static int skip_letters(struct reader *r, const char *letters)
{
    size_t length = strlen(letters);
    if (r->size - r->at < length || memcmp(r->data + r->at, letters, length) != 0)
        return 0;
    r->at += length;
    return 1;
}

static int fail_binary(struct reader *r)
{
    size_t at = r->at;
    if (word_is(take_word(r), "BINARY"))
        return fail(r, "OFF BINARY is not supported; convert it to text or PLY");
    r->at = at;
    return 1;
}

/* Takes "OFF" with the letters before it. Some files have no blank between it and the first count. The letters are in
 * the reverse order of what they announce, but texture coordinates are always last: CNOFF by Geomview has normals before
 * colors, NCOFF by MeshLab colors before normals. */
static int off_keyword(struct reader *r, struct off *off)
{
    seek_word(r);
    while (!skip_letters(r, "OFF"))
        if (skip_letters(r, "ST")) {
            off->texcoords = 1;
        } else if (skip_letters(r, "C")) {
            off->colors = 1;
            off->colors_first = off->normals;
        } else if (skip_letters(r, "N")) {
            off->normals = 1;
        } else if (skip_letters(r, "4")) {
            off->homogeneous = 1;
        } else if (skip_letters(r, "n")) {
            return fail(r, "nOFF is not supported: vertices have three coordinates");
        } else {
            return fail(r, "not an OFF file: no OFF, COFF, NOFF or STOFF at the start");
        }
    return fail_binary(r);
}

static int off_count(struct reader *r, double *count)
{
    seek_word(r);
    if (!take_number(r, count))
        return 0;
    return (*count >= 0 && *count == floor(*count)) || fail(r, "%.12g is not a count", *count);
}

/* Lines mean nothing if there are fewer than vertices and faces behind this one, or if the first has no three numbers. */
static int is_free_form(struct reader r, double rows)
{
    double lines = 0;
    int words = 0;
    next_line(&r);
    seek_word(&r);
    for (struct reader first = r; take_word(&first).length > 0; words++) {}
    for (; seek_word(&r) && lines < rows; next_line(&r))
        lines++;
    return lines < rows || (rows > 0 && words < 3);
}

/* Takes the numbers of vertices and faces; that of edges is ignored. The shortest lines "0 0 0" and "0" take 6 bytes
 * and 2. */
static int off_counts(struct reader *r, struct mesh_file *mesh, struct off *off)
{
    double vertices, faces, edges;
    if (!off_count(r, &vertices) || !off_count(r, &faces))
        return 0;
    r->free_form = is_free_form(*r, vertices + faces);
    if (r->free_form && !take_number(r, &edges))
        return 0;
    if (!r->free_form)
        next_line(r);
    if (6 * vertices + 2 * faces > (double)(r->size - r->at + 1))
        return fail(r, "%.12g vertices and %.12g faces do not fit in the file", vertices, faces);
    off->num_faces = (size_t)faces;
    return allocate(r, mesh, (size_t)vertices);
}

/* -- Vertices ------------------------------------------------------------------------------------------------------ */

/* Takes numbers to the end of the line, or as many as are announced if lines mean nothing. Returns how many there are,
 * of which those beyond MAX_EXTRA are not stored. */
static size_t take_extras(struct reader *r, size_t announced, float extra[MAX_EXTRA])
{
    double value, unit;
    size_t count = 0;
    for (; !r->free_form || count < announced; count++) {
        if (r->free_form)
            seek_word(r);
        struct word word = take_word(r);
        if (word.length == 0)
            break;
        if (count < MAX_EXTRA)
            extra[count] = parse_number(word, &value, &unit) ? attribute_value(value) : NAN;
    }
    return count;
}

static size_t announced_numbers(const struct off *off)
{
    return (off->normals ? 3 : 0) + (off->colors ? off->color_components : 0) + (off->texcoords ? 2 : 0);
}

static void store_extras(struct mesh_file *mesh, enum mesh_attribute a, size_t vertex, const float *extra)
{
    size_t components = (size_t)mesh->attribute[a].components;
    memcpy(mesh->attribute[a].values + components * vertex, extra, components * sizeof *extra);
}

/* The first vertex tells whether colors have an alpha. */
static int off_allocate_attributes(struct reader *r, struct mesh_file *mesh, struct off *off, size_t numbers)
{
    off->color_components = numbers == announced_numbers(off) + 3 ? 3 : 4;
    return (!off->normals || allocate_attribute(r, mesh, MESH_NORMALS, 3))
           && (!off->colors || allocate_attribute(r, mesh, MESH_COLORS, (int)off->color_components))
           && (!off->texcoords || allocate_attribute(r, mesh, MESH_TEXCOORDS, 2));
}

/* Where some vertices alone have more numbers than the keyword announces, it may be that they are none. */
static int off_check_extras(struct reader *r, struct off *off, size_t vertex, size_t numbers)
{
    size_t extras = numbers > announced_numbers(off) ? numbers - announced_numbers(off) : 0;
    if (vertex == 0)
        off->vertex_extras = extras;
    return extras == off->vertex_extras
           || fail(r, "vertex %zu has %zu number%s more than its keyword announces, and vertex 0 has %zu", vertex, extras,
                   plural(extras), off->vertex_extras);
}

static int off_attributes(struct reader *r, struct mesh_file *mesh, struct off *off, size_t vertex, size_t begin)
{
    float extra[MAX_EXTRA];
    for (int i = 0; i < MAX_EXTRA; i++)
        extra[i] = NAN;
    size_t numbers = take_extras(r, announced_numbers(off) + (vertex == 0 && off->colors ? 4 : 0), extra);
    if (vertex == 0 && !off_allocate_attributes(r, mesh, off, numbers))
        return 0;
    if (numbers > announced_numbers(off) && memchr(r->data + begin, ',', r->at - begin) != NULL)
        return fail(r, "vertex %zu has %zu number%s too many; are its commas decimal points?", vertex,
                    numbers - announced_numbers(off), plural(numbers - announced_numbers(off)));
    if (!off_check_extras(r, off, vertex, numbers))
        return 0;
    size_t normal = off->colors_first ? off->color_components : 0;
    size_t color = off->normals && !off->colors_first ? 3 : 0;
    if (off->normals)
        store_extras(mesh, MESH_NORMALS, vertex, extra + normal);
    if (off->colors)
        store_extras(mesh, MESH_COLORS, vertex, extra + color);
    if (off->texcoords)
        store_extras(mesh, MESH_TEXCOORDS, vertex, extra + announced_numbers(off) - 2);
    return 1;
}

static int off_divide(struct reader *r, struct mesh_file *mesh, size_t vertex)
{
    double w;
    if (!take_number(r, &w))
        return 0;
    for (size_t i = 3 * vertex; i < 3 * vertex + 3 && w != 1; i++)
        if (!store_coordinate(r, mesh, i, mesh->positions[i] / w, 0))
            return 0;
    return 1;
}

static int off_vertices(struct reader *r, struct mesh_file *mesh, struct off *off)
{
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        if (!seek_word(r))
            return fail(r, "the file ends before vertex %zu", v);
        size_t begin = r->at;
        if (!take_position(r, mesh, v) || (off->homogeneous && !off_divide(r, mesh, v))
                || !off_attributes(r, mesh, off, v, begin))
            return 0;
        if (!r->free_form)
            next_line(r);
    }
    return 1;
}

/* -- Faces --------------------------------------------------------------------------------------------------------- */

static int off_face(struct reader *r, struct mesh_file *mesh, struct off *off, struct faces *faces)
{
    double corners, value;
    if (!take_number(r, &corners))
        return 0;
    if (!(corners >= 0 && corners == floor(corners)))
        return fail(r, "face %zu has %.12g corners", faces->num_faces, corners);
    for (double i = 0; i < corners; i++)
        if (!take_number(r, &value) || !add_corner(r, mesh, faces, value))
            return 0;
    if (!r->free_form) {
        off->face_extras |= take_word(r).length > 0;
        next_line(r);
    }
    return end_face(r, faces);
}

/* What follows the last face is told; but not where it says that the counts are wrong. */
static int off_check_end(struct reader *r, const struct off *off)
{
    if (!seek_word(r))
        return 1;
    if (off->num_faces == 0)
        return fail(r, "the file says that it has 0 faces, and does not end there");
    return !r->free_form || fail(r, "there are more numbers than the counts of vertices and faces tell");
}

static int off_faces(struct reader *r, struct mesh_file *mesh, struct off *off, struct faces *faces)
{
    while (faces->num_faces < off->num_faces) {
        if (!seek_word(r))
            return fail(r, "the file ends before face %zu", faces->num_faces);
        if (!off_face(r, mesh, off, faces))
            return 0;
    }
    return store_faces(r, mesh, faces, 0) && off_check_end(r, off);
}

static void off_notes(struct reader *r, struct mesh_file *mesh, const struct off *off)
{
    if (off->vertex_extras > 0)
        note_attribute(mesh, "dropped: numbers behind the positions of vertices, which the word OFF does not announce\n");
    if (off->face_extras)
        note_attribute(mesh, "dropped: colors of faces\n");
    if (seek_word(r))
        note(mesh, "dropped: what follows the last face (line %zu)\n", r->line);
}

int read_off(struct reader *r, struct mesh_file *mesh)
{
    struct off off = { 0 };
    struct faces faces;
    begin_faces(&faces);
    if (!begin_text(r))
        return 0;
    r->comments = r->commas = 1;
    int ok = off_keyword(r, &off) && off_counts(r, mesh, &off) && off_vertices(r, mesh, &off)
             && off_faces(r, mesh, &off, &faces);
    free_faces(&faces);
    if (!ok)
        return 0;
    off_notes(r, mesh, &off);
    if (mesh->attribute[MESH_COLORS].values != NULL)
        scale_colors(mesh);
    return 1;
}
