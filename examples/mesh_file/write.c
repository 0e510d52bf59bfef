/* write.c - writes all formats. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STL_HEADER_BYTES 84
#define STL_TRIANGLE_BYTES 50

/* Do floats hold all positions? */
static int positions_are_floats(const struct mesh_file *mesh)
{
    for (size_t i = 0; i < 3 * (size_t)mesh->num_vertices; i++)
        if ((double)(float)mesh->positions[i] != mesh->positions[i])
            return 0;
    return 1;
}

/* With blanks between them. */
static void write_position(const struct mesh_file *mesh, FILE *file, size_t vertex, int are_floats)
{
    const double *p = &mesh->positions[3 * vertex];
    if (are_floats)
        fprintf(file, "%.9g %.9g %.9g", p[0], p[1], p[2]);
    else
        fprintf(file, "%.17g %.17g %.17g", p[0], p[1], p[2]);
}

/* Lines have two, points one. */
static int corners_of_face(const struct mesh_file *mesh, size_t face)
{
    if (mesh->marks == NULL || (mesh->marks[face] & (MESH_LINE | MESH_POINT)) == 0)
        return 3;
    return (mesh->marks[face] & MESH_POINT) != 0 ? 1 : 2;
}

static void write_off(const struct mesh_file *mesh, FILE *file)
{
    int are_floats = positions_are_floats(mesh);
    fprintf(file, "OFF\n%lu %lu 0\n", (unsigned long)mesh->num_vertices, (unsigned long)mesh->num_faces);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        write_position(mesh, file, v, are_floats);
        fputc('\n', file);
    }
    for (size_t f = 0; f < mesh->num_faces; f++) {
        fprintf(file, "%d", corners_of_face(mesh, f));
        for (size_t c = 3 * f; c < 3 * f + (size_t)corners_of_face(mesh, f); c++)
            fprintf(file, " %lu", (unsigned long)mesh->indices[c]);
        fputc('\n', file);
    }
}

static void write_numbers(FILE *file, const float *numbers, int count)
{
    for (int i = 0; i < count; i++)
        fprintf(file, " %.9g", (double)numbers[i]);
}

static void write_obj_values(const struct mesh_values *a, FILE *file, const char *word)
{
    for (size_t i = 0; a->values != NULL && i < a->count; i++) {
        fputs(word, file);
        write_numbers(file, a->values + (size_t)a->components * i, a->components);
        fputc('\n', file);
    }
}

static void write_obj_vertices(const struct mesh_file *mesh, FILE *file)
{
    const struct mesh_values *colors = &mesh->attribute[MESH_COLORS];
    int are_floats = positions_are_floats(mesh);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        fputs("v ", file);
        write_position(mesh, file, v, are_floats);
        if (colors->values != NULL)
            write_numbers(file, colors->values + (size_t)colors->components * v, 3);
        fputc('\n', file);
    }
}

/* The value that a corner has; MESH_NONE if it has none. */
static uint32_t item_of_corner(const struct mesh_file *mesh, enum mesh_attribute attribute, size_t corner)
{
    const struct mesh_values *a = &mesh->attribute[attribute];
    if (a->values == NULL || (mesh->marks != NULL && (mesh->marks[corner / 3] >> attribute & 1) != 0))
        return MESH_NONE;
    return a->corner != NULL ? a->corner[corner] : mesh->indices[corner];
}

static void write_obj_corner(const struct mesh_file *mesh, FILE *file, size_t corner)
{
    uint32_t texcoord = item_of_corner(mesh, MESH_TEXCOORDS, corner), normal = item_of_corner(mesh, MESH_NORMALS, corner);
    fprintf(file, " %lu", mesh->indices[corner] + 1ul);
    if (texcoord != MESH_NONE)
        fprintf(file, "/%lu", texcoord + 1ul);
    if (normal != MESH_NONE)
        fprintf(file, texcoord != MESH_NONE ? "/%lu" : "//%lu", normal + 1ul);
}

/* -- Names --------------------------------------------------------------------------------------------------------- */

/* Where each of the names begins; and behind the last one, where they end. NULL: no memory. */
static const char **find_names(const struct mesh_labels *labels)
{
    const char **name = malloc(((size_t)labels->count + 1) * sizeof *name);
    if (name == NULL)
        return NULL;
    name[0] = labels->names;
    for (uint32_t i = 0; i < labels->count; i++)
        name[i + 1] = strchr(name[i], '\n') + 1;
    return name;
}

/* A backslash at the end of a line would mean something. */
static void write_line(FILE *file, const char *word, const char *text, size_t length)
{
    fprintf(file, "%s %.*s%s\n", word, (int)length, text, length > 0 && text[length - 1] == '\\' ? " " : "");
}

/* A line for each line of text. */
static void write_lines(FILE *file, const char *word, const char *text)
{
    for (const char *end; text != NULL && (end = strchr(text, '\n')) != NULL; text = end + 1)
        write_line(file, word, text, (size_t)(end - text));
}

/* A label holds until the next is named; 0 has no name. */
static void write_obj_label(const struct mesh_labels *labels, const char **name, FILE *file, const char *word,
                            uint32_t *now, size_t face)
{
    if (labels->of_face == NULL || labels->of_face[face] == *now)
        return;
    *now = labels->of_face[face];
    if (*now > 0)
        write_line(file, word, name[*now - 1], (size_t)(name[*now] - name[*now - 1]) - 1);
    else
        fprintf(file, "%s\n", word);
}

/* Normals of lines and points have no word but that for faces. */
static void write_obj_face(const struct mesh_file *mesh, FILE *file, size_t face)
{
    int corners = corners_of_face(mesh, face), has_normals = item_of_corner(mesh, MESH_NORMALS, 3 * face) != MESH_NONE;
    fputc(corners == 3 || has_normals ? 'f' : corners == 2 ? 'l' : 'p', file);
    for (size_t c = 3 * face; c < 3 * face + (size_t)corners; c++)
        write_obj_corner(mesh, file, c);
    fputc('\n', file);
}

static int write_obj_faces(const struct mesh_file *mesh, FILE *file)
{
    static const enum mesh_label order[MESH_NUM_LABELS] = { MESH_OBJECTS, MESH_GROUPS, MESH_MATERIALS };
    static const char *const words[MESH_NUM_LABELS] = { "o", "g", "usemtl" };
    const char **name[MESH_NUM_LABELS];
    uint32_t now[MESH_NUM_LABELS] = { 0 };
    int ok = 1;
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        ok = (name[k] = find_names(&mesh->label[order[k]])) != NULL && ok;
    for (size_t f = 0; f < mesh->num_faces && ok; f++) {
        for (int k = 0; k < MESH_NUM_LABELS; k++)
            write_obj_label(&mesh->label[order[k]], name[k], file, words[k], &now[k], f);
        write_obj_face(mesh, file, f);
    }
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        free(name[k]);
    return ok;
}

static int write_obj(const struct mesh_file *mesh, FILE *file)
{
    write_lines(file, "mtllib", mesh->libraries);
    write_obj_vertices(mesh, file);
    write_obj_values(&mesh->attribute[MESH_TEXCOORDS], file, "vt");
    write_obj_values(&mesh->attribute[MESH_NORMALS], file, "vn");
    return write_obj_faces(mesh, file);
}

static void put_u32(uint8_t *bytes, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        bytes[i] = (uint8_t)(value >> 8 * i);
}

static void put_float(uint8_t *bytes, float number)
{
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    put_u32(bytes, bits);
}

static void put_double(uint8_t *bytes, double number)
{
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    put_u32(bytes, (uint32_t)bits);
    put_u32(bytes + 4, (uint32_t)(bits >> 32));
}

static void put_floats(uint8_t *bytes, const float *numbers, int count)
{
    for (int i = 0; i < count; i++)
        put_float(bytes + 4 * i, numbers[i]);
}

static void write_ply_header(const struct mesh_file *mesh, FILE *file, int are_floats)
{
    const char *type = are_floats ? "float" : "double";
    const struct mesh_values *texcoords = &mesh->attribute[MESH_TEXCOORDS], *colors = &mesh->attribute[MESH_COLORS];
    fputs("ply\nformat binary_little_endian 1.0\n", file);
    write_lines(file, "comment TextureFile", mesh->label[MESH_MATERIALS].names);
    fprintf(file, "element vertex %lu\nproperty %s x\nproperty %s y\nproperty %s z\n",
            (unsigned long)mesh->num_vertices, type, type, type);
    if (mesh->attribute[MESH_NORMALS].values != NULL)
        fputs("property float nx\nproperty float ny\nproperty float nz\n", file);
    if (texcoords->values != NULL && texcoords->corner == NULL)
        fputs("property float s\nproperty float t\n", file);
    if (colors->values != NULL)
        fputs("property uchar red\nproperty uchar green\nproperty uchar blue\n", file);
    if (colors->values != NULL && colors->components == 4)
        fputs("property uchar alpha\n", file);
    fprintf(file, "element face %lu\nproperty list uchar uint vertex_indices\n", (unsigned long)mesh->num_faces);
    if (texcoords->corner != NULL)
        fputs("property list uchar float texcoord\n", file);
    if (mesh->label[MESH_MATERIALS].of_face != NULL)
        fputs("property int texnumber\n", file);
    fputs("end_header\n", file);
}

static void write_ply_position(const struct mesh_file *mesh, FILE *file, size_t v, int are_floats)
{
    uint8_t row[24];
    for (size_t i = 0; i < 3; i++)
        if (are_floats)
            put_float(row + 4 * i, (float)mesh->positions[3 * v + i]);
        else
            put_double(row + 8 * i, mesh->positions[3 * v + i]);
    fwrite(row, are_floats ? 12 : 24, 1, file);
}

static void write_ply_attributes(const struct mesh_file *mesh, FILE *file, size_t v)
{
    uint8_t row[12];
    for (int k = 0; k < MESH_NUM_ATTRIBUTES; k++) {
        const struct mesh_values *a = &mesh->attribute[k];
        if (a->values == NULL || a->corner != NULL)
            continue;
        size_t components = (size_t)a->components;
        const float *value = a->values + components * v;
        if (k != MESH_COLORS)
            put_floats(row, value, a->components);
        for (size_t i = 0; k == MESH_COLORS && i < components; i++)
            row[i] = (uint8_t)(255 * fmax(0, fmin((double)value[i], 1)) + 0.5);
        fwrite(row, components * (k == MESH_COLORS ? 1 : 4), 1, file);
    }
}

/* Two numbers for each corner, or none if no corner has any. */
static void write_ply_texcoords(const struct mesh_file *mesh, FILE *file, size_t face)
{
    const struct mesh_values *a = &mesh->attribute[MESH_TEXCOORDS];
    const float nothing[2] = { NAN, NAN };
    uint8_t row[25] = { 0 };
    int corners = corners_of_face(mesh, face);
    for (size_t i = 0; i < (size_t)corners; i++) {
        uint32_t item = item_of_corner(mesh, MESH_TEXCOORDS, 3 * face + i);
        put_floats(row + 1 + 8 * i, item != MESH_NONE ? a->values + 2 * (size_t)item : nothing, 2);
        row[0] = item != MESH_NONE ? (uint8_t)(2 * corners) : row[0];
    }
    fwrite(row, 1 + 4 * (size_t)row[0], 1, file);
}

static void write_ply_face(const struct mesh_file *mesh, FILE *file, size_t face)
{
    uint8_t row[13];
    int corners = corners_of_face(mesh, face);
    row[0] = (uint8_t)corners;
    for (size_t i = 0; i < (size_t)corners; i++)
        put_u32(row + 1 + 4 * i, mesh->indices[3 * face + i]);
    fwrite(row, 1 + 4 * (size_t)corners, 1, file);
    if (mesh->attribute[MESH_TEXCOORDS].corner != NULL)
        write_ply_texcoords(mesh, file, face);
    if (mesh->label[MESH_MATERIALS].of_face != NULL) {
        put_u32(row, mesh->label[MESH_MATERIALS].of_face[face] - 1u);
        fwrite(row, 4, 1, file);
    }
}

static void write_ply(const struct mesh_file *mesh, FILE *file)
{
    int are_floats = positions_are_floats(mesh);
    write_ply_header(mesh, file, are_floats);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        write_ply_position(mesh, file, v, are_floats);
        write_ply_attributes(mesh, file, v);
    }
    for (size_t f = 0; f < mesh->num_faces; f++)
        write_ply_face(mesh, file, f);
}

/* The unit normal of a triangle; zero if it has no area. */
static void triangle_normal(const double *a, const double *b, const double *c, float normal[3])
{
    double u[3], v[3], n[3], length = 0;
    for (int i = 0; i < 3; i++) {
        u[i] = b[i] - a[i];
        v[i] = c[i] - a[i];
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
        const double *corner[3];
        float normal[3];
        for (size_t i = 0; i < 9; i++) {
            corner[i / 3] = &mesh->positions[3 * (size_t)mesh->indices[3 * f + i / 3]];
            put_float(row + 12 + 4 * i, (float)corner[i / 3][i % 3]);
        }
        triangle_normal(corner[0], corner[1], corner[2], normal);
        put_floats(row, normal, 3);
        fwrite(row, sizeof row, 1, file);
    }
}

/* PLY has texture coordinates of corners, but no normals; neither it nor OBJ has colors. */
static int must_expand(const struct mesh_file *mesh, enum mesh_format format)
{
    return (mesh->attribute[MESH_COLORS].corner != NULL && (format == MESH_OBJ || format == MESH_PLY))
           || (mesh->attribute[MESH_NORMALS].corner != NULL && format == MESH_PLY);
}

int mesh_write(struct mesh_file *mesh, FILE *file, enum mesh_format format)
{
    int ok = !must_expand(mesh, format) || mesh_expand(mesh, (1u << MESH_NUM_ATTRIBUTES) - 1);
    if (!ok)
        return 0;
    switch (format) {
    case MESH_OFF: write_off(mesh, file); break;
    case MESH_OBJ: ok = write_obj(mesh, file); break;
    case MESH_PLY: write_ply(mesh, file); break;
    case MESH_STL: write_stl(mesh, file); break;
    default: return 0;
    }
    return ok && !ferror(file);
}
