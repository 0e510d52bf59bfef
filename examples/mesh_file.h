/* mesh_file.h - reads and writes triangle meshes as OFF, OBJ, PLY and STL.
 * SPDX-License-Identifier: MIT
 *
 * Vertices and faces come out as the file has them: same order, nothing merged, nothing dropped. Only STL, which has a
 * position for each corner, gets its indices here: corners with equal coordinates become one vertex. Normals, texture
 * coordinates and colors are kept where each vertex has one, materials of OBJ as numbers. Whatever else a file has is
 * named in `notes`.
 *
 *     struct mesh_file mesh;
 *     char error[MESH_ERROR_BYTES];
 *     if (!mesh_read(&mesh, data, size, MESH_OFF, error))
 *         fprintf(stderr, "%s\n", error);              "face 17 has 4 corners; only triangles are supported (line 60)"
 *     ...
 *     mesh_free(&mesh);
 *
 * Any bytes may be handed in. A file without faces is an error, unless it has a count of faces that says 0. Compile
 * mesh_file/[a-z]*.c with your program. Writing text needs LC_NUMERIC "C", as it is unless the program calls setlocale. */
#ifndef MESH_FILE_H
#define MESH_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* What a reader takes and a writer gives. Text may begin with a byte order mark; lines end in \n, \r\n or \r; numbers
 * may have any length.
 *
 * MESH_OFF  OFF and its variants with colors (C), normals (N), texture coordinates (ST) and a fourth coordinate (4) that
 *           divides the others, in text, with blanks or commas. One vertex or face a line; if there are fewer lines,
 *           as many numbers as there have to be. Written as OFF.
 * MESH_OBJ  `v` lines, also with red, green, blue behind the position; `vt` and `vn` lines, if all corners of a vertex
 *           have the same; `f` lines, with v, v/vt, v//vn, v/vt/vn and numbers that count from the end; `usemtl`
 *           lines; lines that a backslash continues.
 * MESH_PLY  ascii and binary of both byte orders: of element `vertex` x, y, z; nx, ny, nz; s, t or u, v or texture_u,
 *           texture_v; red, green, blue, alpha; list `vertex_indices` or `vertex_index` of the elements `face` and
 *           `tristrips`. Written as binary little-endian, colors in 8 bits.
 * MESH_STL  ascii and binary; written as binary. */
enum mesh_format { MESH_UNKNOWN, MESH_OFF, MESH_OBJ, MESH_PLY, MESH_STL };

#define MESH_ERROR_BYTES 160

/* What a vertex may have beside its position. */
enum mesh_attribute { MESH_NORMALS, MESH_TEXCOORDS, MESH_COLORS, MESH_NUM_ATTRIBUTES };

struct mesh_file {
    double *positions;                 /* double[3 * num_vertices], each within the range of a 32-bit float */
    uint32_t *indices;                 /* uint32_t[3 * num_faces], each < num_vertices */
    uint32_t num_vertices, num_faces;
    float *attribute[MESH_NUM_ATTRIBUTES];    /* float[components * num_vertices], finite; NULL: none */
    int components[MESH_NUM_ATTRIBUTES];      /* 3; 2; 3 or with alpha 4, each 0 .. 1 */
    uint32_t *materials;               /* uint32_t[num_faces], each <= num_materials, 0: none said; NULL: none */
    uint32_t num_materials;            /* numbered from 1 as faces first have them */
    double rounding;                   /* how far a coordinate moves at most if it becomes a 32-bit float, where the
                                          digits of the file tell the difference; 0: floats hold what the file says */
    char *notes;                       /* lines that end in \n: "dropped: ...", what the file has and this has not, or
                                          "changed: ..."; NULL: none */
};

/* "normals", "texture coordinates", "colors". */
const char *mesh_attribute_name(enum mesh_attribute attribute);

/* The format with this name ("off") or of a file with this path ("bunny.OFF"); MESH_UNKNOWN if there is none. */
enum mesh_format mesh_format_by_name(const char *name);
enum mesh_format mesh_format_of_path(const char *path);
const char *mesh_format_name(enum mesh_format format);

/* Reads a mesh from `size` bytes. Returns 1; or 0, an empty mesh and a message that says what is wrong and where.
 * Messages number vertices and faces from 0, lines from 1, bytes from 0. Memory: at most 40 bytes per byte of data. */
int mesh_read(struct mesh_file *mesh, const uint8_t *data, size_t size, enum mesh_format format,
              char error[MESH_ERROR_BYTES]);

/* Writes a mesh. Text has enough digits to read back the same numbers; positions that floats do not hold are written as
 * doubles, but STL has floats only. OFF and STL hold no attributes, OBJ no alpha; OBJ alone materials, under the names
 * material_1, material_2 and so on; a face without one has to come before them. Returns 1; or 0 if the file reports an
 * error. */
int mesh_write(const struct mesh_file *mesh, FILE *file, enum mesh_format format);

void mesh_free(struct mesh_file *mesh);

#endif
