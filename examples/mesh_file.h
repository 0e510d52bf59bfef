/* mesh_file.h - reads and writes triangle meshes as OFF, OBJ, PLY and STL.
 * SPDX-License-Identifier: MIT
 *
 * Vertices and faces come out as the file has them: same order, nothing merged, nothing dropped. Only STL, which has a
 * position for each corner, gets its indices here: corners with equal coordinates become one vertex. Faces with more
 * than three corners are cut into triangles, in their place. Normals, texture coordinates and colors belong to vertices
 * or to corners of faces, names of materials, groups and objects to faces. Whatever else a file has is named in notes, but
 * for comments and, of STL, normals and the name of a single solid.
 *
 *     struct mesh_file mesh;
 *     char error[MESH_ERROR_BYTES];
 *     if (!mesh_read(&mesh, data, size, MESH_OFF, error))
 *         fprintf(stderr, "%s\n", error);              "face 17 names vertex 9; there are 8 vertices (line 60)"
 *     ...
 *     mesh_free(&mesh);
 *
 * mesh_expand() makes vertex buffers of it, in which each vertex has all of its attributes.
 *
 * Any bytes may be handed in. A file without faces is an error, unless its counts say so. Compile
 * mesh_file/[a-z]*.c with your program. Writing text needs LC_NUMERIC "C", as it is unless the program calls setlocale. */
#ifndef MESH_FILE_H
#define MESH_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* What a reader takes and a writer gives. Text may begin with a byte order mark and be UTF-16; lines end in \n, \r\n
 * or \r; numbers may have any length.
 *
 * MESH_OFF  OFF and its variants with colors (C), normals (N), texture coordinates (ST) and a fourth coordinate (4) that
 *           divides the others, in text, with blanks or commas. One vertex or face a line; if there are fewer lines,
 *           as many numbers as there have to be. Written as OFF.
 * MESH_OBJ  `v` lines, also with red, green, blue behind the position; `vt` and `vn` lines; `f` lines, `l`
 *           and `p`, with v, v/vt, v//vn, v/vt/vn and numbers that count from the end; `usemtl`, `g`, `o` and
 *           `mtllib` lines; `s` lines, which
 *           become normals if there are no `vn` lines; lines that a backslash continues.
 * MESH_PLY  ascii and binary of both byte orders: of element `vertex` x, y, z; nx, ny, nz; s, t or u, v or texture_u,
 *           texture_v; red, green, blue, alpha; of the elements `face` and `tristrips` list `vertex_indices` or
 *           `vertex_index`; of `face` list `texcoord`, two numbers for each corner, and `texnumber`, which is a
 *           material, named by a comment `TextureFile`. Written as binary little-endian, colors in 8 bits.
 * MESH_STL  ascii and binary; written as binary. */
enum mesh_format { MESH_UNKNOWN, MESH_OFF, MESH_OBJ, MESH_PLY, MESH_STL };

#define MESH_ERROR_BYTES 160

/* What a vertex may have beside its position, or each corner of a face. */
enum mesh_attribute { MESH_NORMALS, MESH_TEXCOORDS, MESH_COLORS, MESH_NUM_ATTRIBUTES };

#define MESH_NONE UINT32_MAX

/* Lines and points are faces, too: a line from a to b is a, b, b, and a point a, a, a. */
enum { MESH_LINE = 1 << MESH_NUM_ATTRIBUTES, MESH_POINT = MESH_LINE << 1 };

struct mesh_values {
    float *values;                     /* float[components * count], finite; NULL: none */
    int components;                    /* of normals 3, of texture coordinates 2, of colors, each 0 .. 1, 3 or 4 */
    uint32_t count;
    uint32_t *corner;                  /* uint32_t[3 * num_faces], which one each corner has, MESH_NONE: none; NULL:
                                          vertex v has value v, count is num_vertices */
};

/* What a face may be said to belong to. */
enum mesh_label { MESH_MATERIALS, MESH_GROUPS, MESH_OBJECTS, MESH_NUM_LABELS };

struct mesh_labels {
    uint32_t *of_face;                 /* uint32_t[num_faces], each <= count, 0: none said; NULL: no face has one */
    uint32_t count;                    /* numbered from 1 as faces first have them */
    char *names;                       /* of number 1, 2, ...: a line each, without \0, which ends in \n */
};

struct mesh_file {
    double *positions;                 /* double[3 * num_vertices], each within the range of a 32-bit float */
    uint32_t *indices;                 /* uint32_t[3 * num_faces], each < num_vertices */
    uint32_t num_vertices, num_faces;
    struct mesh_values attribute[MESH_NUM_ATTRIBUTES];
    struct mesh_labels label[MESH_NUM_LABELS];
    uint8_t *marks;                    /* uint8_t[num_faces]: bits 1 << MESH_NORMALS and so on for what no corner of the face
                                          has, where others have it; MESH_LINE, MESH_POINT; NULL: all 0 */
    uint32_t *number;                  /* uint32_t[num_vertices], of the vertex in the file; NULL: its own */
    char *libraries;                   /* of materials: the names of files, a line each; NULL: none */
    double rounding;                   /* how far a coordinate moves at most if it becomes a 32-bit float, where the
                                          digits of the file tell the difference; 0: floats hold what the file says */
    double unit;                       /* what the last digit of a coordinate counts at least; 0: binary numbers */
    char *notes;                       /* lines that end in \n: "dropped: ...", what the file has and this has not, or
                                          "changed: ..."; NULL: none */
    char *attribute_notes;             /* the same of attributes and labels, for those who want any */
};

/* "normals", "texture coordinates", "colors". */
const char *mesh_attribute_name(enum mesh_attribute attribute);

/* The format with this name ("off") or of a file with this path ("bunny.OFF"); MESH_UNKNOWN if there is none. */
enum mesh_format mesh_format_by_name(const char *name);
enum mesh_format mesh_format_of_path(const char *path);
const char *mesh_format_name(enum mesh_format format);

/* Reads a mesh from `size` bytes. Returns 1; or 0, an empty mesh and a message that says what is wrong and where.
 * Messages number vertices and faces from 0, lines from 1, bytes from 0. Memory: at most 100 bytes per byte of data. */
int mesh_read(struct mesh_file *mesh, const uint8_t *data, size_t size, enum mesh_format format,
              char error[MESH_ERROR_BYTES]);

/* Keeps the attributes whose bits 1 << MESH_NORMALS and so on are set. Then gives each vertex what its corners have, so
 * that there are no values of corners any more: vertices whose corners differ in value are repeated behind the others,
 * and mesh->number says of which vertex each is a copy. What a corner or an unused vertex has not is 0; of normals, 0 0
 * 1. Returns 0 if there is no memory; the mesh can then only be freed. */
int mesh_expand(struct mesh_file *mesh, unsigned attributes);

/* For each of so many rows of bytes, the first one that is equal. free() it. NULL: no memory. */
uint32_t *mesh_first_equal(const void *rows, size_t count, size_t bytes);

/* Writes a mesh. Text has enough digits to read back the same numbers; positions that floats do not hold are written as
 * doubles, but STL has floats only. OFF and STL hold no attributes and no labels, OBJ no alpha, PLY materials alone. Where
 * the format has an attribute for vertices alone, mesh_expand() is called before. Returns 1; or 0 if the file reports an
 * error or there is no memory. */
int mesh_write(struct mesh_file *mesh, FILE *file, enum mesh_format format);

void mesh_free(struct mesh_file *mesh);

#endif
