/* write.c - writes all formats. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <math.h>
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

static void write_off(const struct mesh_file *mesh, FILE *file)
{
    int are_floats = positions_are_floats(mesh);
    fprintf(file, "OFF\n%lu %lu 0\n", (unsigned long)mesh->num_vertices, (unsigned long)mesh->num_faces);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        write_position(mesh, file, v, are_floats);
        fputc('\n', file);
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
    int are_floats = positions_are_floats(mesh);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        fputs("v ", file);
        write_position(mesh, file, v, are_floats);
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
    fprintf(file, "ply\nformat binary_little_endian 1.0\n"
            "element vertex %lu\nproperty %s x\nproperty %s y\nproperty %s z\n",
            (unsigned long)mesh->num_vertices, type, type, type);
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
    int are_floats = positions_are_floats(mesh);
    write_ply_header(mesh, file, are_floats);
    for (size_t v = 0; v < mesh->num_vertices; v++) {
        write_ply_position(mesh, file, v, are_floats);
        write_ply_attributes(mesh, file, v);
    }
    row[0] = 3;
    for (size_t f = 0; f < mesh->num_faces; f++) {
        for (size_t i = 0; i < 3; i++)
            put_u32(row + 1 + 4 * i, mesh->indices[3 * f + i]);
        fwrite(row, 13, 1, file);
    }
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
