/* stl.c - reads STL. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <stdlib.h>
#include <string.h>

#define STL_HEADER_BYTES 84          /* comment, number of triangles */
#define STL_TRIANGLE_BYTES 50        /* normal, three positions, two bytes */

/* Both readers first give each corner a vertex of its own. */
static int stl_allocate(struct reader *r, struct mesh_file *mesh, size_t corners)
{
    return corners < UINT32_MAX ? allocate(r, mesh, corners) : fail(r, "too many triangles");
}

/* Gives corners with equal positions the same vertex, numbered as they first occur. Works in place: the vertex is never
 * behind the corner. */
static int stl_weld(struct reader *r, struct mesh_file *mesh)
{
    size_t corners = mesh->num_vertices;
    for (size_t i = 0; i < 3 * corners; i++)
        mesh->positions[i] += 0.0;        /* -0 becomes 0: equal numbers have equal bytes */
    uint32_t *first = mesh_first_equal(mesh->positions, corners, 3 * sizeof *mesh->positions);
    if (first == NULL)
        return fail(r, "out of memory for %zu corners", corners);
    mesh->num_vertices = 0;
    for (size_t c = 0; c < corners; c++) {
        if (first[c] != c) {
            first[c] = first[first[c]];
            continue;
        }
        memmove(&mesh->positions[3 * (size_t)mesh->num_vertices], &mesh->positions[3 * c], 3 * sizeof *mesh->positions);
        first[c] = mesh->num_vertices++;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->num_faces; i++)
        mesh->indices[i] = first[mesh->indices[i]];
    free(first);
    return 1;
}

/* -- Binary -------------------------------------------------------------------------------------------------------- */

/* What the header says and the size of the file leaves. The two bytes of a triangle mean nothing, or a color, or how
 * many bytes follow it. */
struct stl_layout {
    size_t said, triangles;
    int has_attributes;              /* bytes behind triangles, as many as each says */
    size_t behind;                   /* bytes behind the last triangle */
};

static size_t stl_attribute_bytes(const struct reader *r, size_t at)
{
    return (size_t)load_bytes(r->data + at + STL_TRIANGLE_BYTES - 2, 2, 0);
}

/* Do so many triangles with their attributes fill the file? */
static int stl_attributes_fit(const struct reader *r, size_t triangles)
{
    size_t at = STL_HEADER_BYTES;
    for (size_t i = 0; i < triangles; i++) {
        if (r->size - at < STL_TRIANGLE_BYTES)
            return 0;
        size_t bytes = STL_TRIANGLE_BYTES + stl_attribute_bytes(r, at);
        if (r->size - at < bytes)
            return 0;
        at += bytes;
    }
    return at == r->size;
}

/* A count of 0 with triangles behind it is one that was never filled in. */
static struct stl_layout stl_find_layout(const struct reader *r)
{
    size_t room = (r->size - STL_HEADER_BYTES) / STL_TRIANGLE_BYTES;
    struct stl_layout layout = { 0 };
    layout.said = (size_t)load_bytes(r->data + STL_HEADER_BYTES - 4, 4, 0);
    layout.triangles = layout.said == 0 && (r->size - STL_HEADER_BYTES) % STL_TRIANGLE_BYTES == 0 ? room : layout.said;
    if (layout.triangles <= room)
        layout.behind = r->size - STL_HEADER_BYTES - layout.triangles * STL_TRIANGLE_BYTES;
    layout.has_attributes = layout.behind > 0 && stl_attributes_fit(r, layout.said);
    if (layout.has_attributes)
        layout.behind = 0;
    return layout;
}

static int stl_has_room(const struct reader *r)
{
    if (r->size < STL_HEADER_BYTES)
        return 0;
    struct stl_layout layout = stl_find_layout(r);
    return layout.triangles <= (r->size - STL_HEADER_BYTES) / STL_TRIANGLE_BYTES;
}

/* The file is binary if it has the size that its count says, whatever its comment begins with. */
static int stl_fits(const struct reader *r)
{
    if (r->size < STL_HEADER_BYTES)
        return 0;
    struct stl_layout layout = stl_find_layout(r);
    return layout.said * STL_TRIANGLE_BYTES == r->size - STL_HEADER_BYTES || layout.has_attributes;
}

/* Some programs put it there, of all faces. */
static int stl_has_color(const struct reader *r)
{
    for (size_t i = 0; i + 6 <= STL_HEADER_BYTES - 4; i++)
        if (memcmp(r->data + i, "COLOR=", 6) == 0)
            return 1;
    return 0;
}

static void stl_binary_notes(struct mesh_file *mesh, const struct stl_layout *layout, size_t attributes, int has_color)
{
    if (layout->said != layout->triangles)
        note(mesh, "changed: the file says that it has 0 triangles; read the %zu that follow\n", layout->triangles);
    if (attributes > 0)
        note_attribute(mesh, "dropped: attributes of %zu face%s, which may be colors\n", attributes, plural(attributes));
    else if (has_color)
        note_attribute(mesh, "dropped: the color that the comment tells\n");
    if (layout->behind > 0)
        note(mesh, "dropped: %zu byte%s behind the last triangle\n", layout->behind, plural(layout->behind));
}

static int stl_triangle(struct reader *r, struct mesh_file *mesh, struct faces *faces, size_t at)
{
    size_t face = faces->num_faces;
    for (size_t i = 0; i < 9; i++) {
        r->item = at + 12 + 4 * i;
        float value = float_of_bits((uint32_t)load_bytes(r->data + r->item, 4, 0));
        if (!store_coordinate(r, mesh, 9 * face + i, (double)value, 0))
            return 0;
    }
    for (size_t i = 0; i < 3; i++)
        if (!add_corner(r, mesh, faces, (double)(3 * face + i)))
            return 0;
    return end_face(r, faces);
}

static int stl_read_binary(struct reader *r, struct mesh_file *mesh, struct faces *faces)
{
    struct stl_layout layout = stl_find_layout(r);
    size_t at = STL_HEADER_BYTES, attributes = 0;
    r->line = 0;
    r->item = r->size;
    if (layout.triangles > (r->size - at) / STL_TRIANGLE_BYTES)
        return fail(r, "the file says that it has %zu triangles, and ends before", layout.triangles);
    if (layout.triangles == 0 && layout.behind > 0)
        return fail(r, "the file says that it has 0 triangles, and does not end there");
    if (!stl_allocate(r, mesh, 3 * layout.triangles))
        return 0;
    while (faces->num_faces < layout.triangles) {
        if (!stl_triangle(r, mesh, faces, at))
            return 0;
        size_t bytes = stl_attribute_bytes(r, at);
        attributes += bytes != 0;
        at += STL_TRIANGLE_BYTES + (layout.has_attributes ? bytes : 0);
    }
    stl_binary_notes(mesh, &layout, attributes, stl_has_color(r));
    return 1;
}

/* -- Text ---------------------------------------------------------------------------------------------------------- */

/* Counts the words "vertex", of which names may have some more, and goes back to the start. */
static size_t stl_count_corners(struct reader *r)
{
    size_t corners = 0;
    while (seek_word(r))
        corners += (size_t)word_is_in_any_case(take_word(r), "vertex");
    begin_text(r);
    return corners;
}

struct stl_text {
    struct faces *faces;
    size_t corners, solids;              /* so far; of solids those with facets */
    int in_facet, in_solid;              /* 1 from "facet" to "endloop", and from the first facet to "endsolid" */
    size_t stray_line;                   /* of the first word that belongs to nothing; 0: there is none */
};

static int stl_next_is(struct reader r, const char *keyword)
{
    return seek_word(&r) && word_is_in_any_case(take_word(&r), keyword);
}

static int stl_at_facet(struct reader r)
{
    return word_is_in_any_case(take_word(&r), "facet") && (stl_next_is(r, "normal") || stl_next_is(r, "outer"));
}

/* A word that is not in the line of a name should not be there. */
static void stl_skip_word(struct reader *r, struct stl_text *t, size_t line)
{
    if (r->line != line && t->stray_line == 0)
        t->stray_line = r->line;
    take_word(r);
}

/* Skips a name, which is any words up to a facet, "endsolid" or the end of the file. */
static void stl_skip_name(struct reader *r, struct stl_text *t)
{
    size_t line = r->line;
    t->in_solid = 0;
    while (seek_word(r) && !stl_at_facet(*r) && !stl_next_is(*r, "endsolid"))
        stl_skip_word(r, t, line);
}

/* Skips up to the next solid, or a facet in a line of its own: the rest of a line is a name. */
static void stl_skip_to_solid(struct reader *r, struct stl_text *t)
{
    size_t line = r->line;
    t->in_solid = 0;
    while (seek_word(r) && !stl_next_is(*r, "solid") && !(r->line != line && stl_at_facet(*r)))
        stl_skip_word(r, t, line);
}

/* Also "end loop" for "endloop". */
static int stl_is_keyword(struct reader *r, struct word word, const char *keyword)
{
    if (word_is_in_any_case(word, keyword))
        return 1;
    if (strncmp(keyword, "end", 3) != 0 || !word_is_in_any_case(word, "end") || !stl_next_is(*r, keyword + 3))
        return 0;
    seek_word(r);
    take_word(r);
    return 1;
}

/* The words of the normal need not be numbers. */
static void stl_begin_facet(struct reader *r, struct stl_text *t)
{
    t->solids += !t->in_solid;
    t->in_solid = t->in_facet = 1;
    if (!stl_next_is(*r, "normal"))
        return;
    for (int i = 0; i < 4 && seek_word(r); i++)
        take_word(r);
}

static int stl_corner(struct reader *r, struct mesh_file *mesh, struct stl_text *t)
{
    return take_position(r, mesh, t->corners) && add_corner(r, mesh, t->faces, (double)t->corners++);
}

static int stl_take(struct reader *r, struct mesh_file *mesh, struct stl_text *t)
{
    char text[WORD_BYTES];
    struct word word = take_word(r);
    if (stl_is_keyword(r, word, "vertex"))
        return stl_corner(r, mesh, t);
    if (stl_is_keyword(r, word, "endloop")) {
        t->in_facet = 0;
        return end_face(r, t->faces);
    }
    if (stl_is_keyword(r, word, "facet"))
        stl_begin_facet(r, t);
    else if (stl_is_keyword(r, word, "solid"))
        stl_skip_name(r, t);
    else if (stl_is_keyword(r, word, "endsolid"))
        stl_skip_to_solid(r, t);
    else if (!stl_is_keyword(r, word, "outer") && !stl_is_keyword(r, word, "loop")
             && !stl_is_keyword(r, word, "endfacet"))
        return fail(r, "unknown STL word '%s'", show(text, word));
    return 1;
}

/* The last lines may be missing, but not a corner. */
static int stl_end_text(struct reader *r, struct mesh_file *mesh, struct stl_text *t)
{
    size_t complete = t->faces->num_faces > 0 ? t->faces->face[t->faces->num_faces - 1].end : 0;
    if (t->corners - complete == 3 && !end_face(r, t->faces))
        return 0;
    if (t->corners - complete != 3 && (t->corners > complete || t->in_facet))
        return fail(r, "the file ends inside face %zu", t->faces->num_faces);
    if (t->faces->num_faces == 0)
        return fail(r, "the file has no triangles");
    if (t->in_solid)
        note(mesh, "dropped: the end of the file, which may have had more faces: there is no 'endsolid'\n");
    if (t->stray_line > 0)
        note(mesh, "dropped: words outside of solids and facets, the first in line %zu\n", t->stray_line);
    if (t->solids > 1)
        note_attribute(mesh, "dropped: which of %zu solids a face belongs to\n", t->solids);
    mesh->num_vertices = (uint32_t)t->corners;
    return 1;
}

/* There may be more words "vertex" than corners, in names. */
static int stl_read_text(struct reader *r, struct mesh_file *mesh, struct faces *faces)
{
    struct stl_text t = { 0 };
    t.faces = faces;
    if (!stl_allocate(r, mesh, stl_count_corners(r)))
        return 0;
    r->free_form = 1;
    while (seek_word(r))
        if (!stl_take(r, mesh, &t))
            return 0;
    return stl_end_text(r, mesh, &t);
}

/* -- Either -------------------------------------------------------------------------------------------------------- */

/* Text has no zeros; a binary file, whose count is below 2^24, has one. But where that count cannot be, text may have
 * some all the same. */
static int stl_is_text(const struct reader *r)
{
    if (!stl_next_is(*r, "solid"))
        return 0;
    if (memchr(r->data, 0, r->size) == NULL)
        return 1;
    struct reader behind_name = *r;
    struct stl_text t = { 0 };
    stl_skip_name(&behind_name, &t);
    return stl_at_facet(behind_name) && !stl_has_room(r);
}

static int stl_read(struct reader *r, struct mesh_file *mesh, struct faces *faces)
{
    if (stl_fits(r))
        return stl_read_binary(r, mesh, faces);
    if (!begin_text(r))
        return 0;
    if (stl_is_text(r))
        return stl_read_text(r, mesh, faces);
    if (r->size < STL_HEADER_BYTES)
        return fail(r, "not an STL file: no 'solid' at the start, and too short for a binary one");
    if (memchr(r->data, 0, r->size) == NULL)
        return fail(r, "not an STL file: text without 'solid' at the start");
    return stl_read_binary(r, mesh, faces);
}

int read_stl(struct reader *r, struct mesh_file *mesh)
{
    struct faces faces;
    begin_faces(&faces);
    int ok = stl_read(r, mesh, &faces) && store_faces(r, mesh, &faces, 0) && stl_weld(r, mesh);
    free_faces(&faces);
    return ok;
}
