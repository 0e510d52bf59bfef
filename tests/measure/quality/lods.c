/* lods.c - levels of detail out of a stream, as mesh files. SPDX-License-Identifier: MIT
 *
 *     lods IN.cqm OUT VERTICES...     the coarsest first; writes OUT-0.ply and so on, prints vertices and triangles of each
 *
 * All levels are written after the end of the stream, from one buffer of vertices and one of indices. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "mesh_file.h"

#include <stdlib.h>

enum { MAX_LEVELS = 16, STEPS = 64 };

static cq_decoder dec;
static uint8_t stream[1 << 26];
static cq_lod lod[MAX_LEVELS];

static int fail(const char *why)
{
    fprintf(stderr, "lods: %s\n", why);
    return 1;
}

/* The levels have at most as many vertices as asked for, and a budget more; a mesh has few more than two faces for each. */
static size_t capacity_of(int count)
{
    size_t corners = 0;
    int k;
    for (k = 0; k < count; k++) corners += 8 * ((size_t)lod[k].min_vertices + STEPS);
    return corners;
}

static cq_result decode(cq_bytes in, int count, cq_index *indices, size_t capacity)
{
    cq_shape shape;
    cq_result result = cq_peek(in.data, in.size, &shape, NULL, NULL);
    size_t size = cq_decoder_bytes(&shape);
    void *memory = malloc(size);
    if (!memory || !indices) return CQ_ERROR_MEMORY;
    if (result != CQ_OK) return result;
    cq_decoder_init(&dec, memory, size);
    do {
        result = cq_decode(&dec, &in, STEPS);
        cq_keep_lods(&dec, lod, (size_t)count, indices, capacity);
    } while (result == CQ_MORE);
    return result;
}

static int write_level(const cq_lod *level, cq_index *indices, double *positions, const char *out, int k)
{
    char path[1024];
    struct mesh_file mesh = { 0 };
    FILE *file;
    int good;
    mesh.positions = positions;
    mesh.num_vertices = level->num_vertices;
    mesh.indices = indices + level->first;
    mesh.num_faces = level->num_faces;
    snprintf(path, sizeof path, "%s-%d.ply", out, k);
    file = fopen(path, "wb");
    if (!file) return 0;
    good = mesh_write(&mesh, file, MESH_PLY);
    printf("%lu %lu\n", (unsigned long)level->num_vertices, (unsigned long)level->num_faces);
    return fclose(file) == 0 && good;
}

static double *read_positions(void)
{
    double *positions = malloc(3 * (size_t)dec.mesh.num_vertices * sizeof *positions);
    size_t v;
    for (v = 0; positions && v < dec.mesh.num_vertices; v++) {
        float at[3];
        cq_reconstruct(&dec.shape.channel[0], dec.channel[0] + 3 * v, 1, at);
        positions[3 * v] = (double)at[0], positions[3 * v + 1] = (double)at[1], positions[3 * v + 2] = (double)at[2];
    }
    return positions;
}

int main(int argc, char **argv)
{
    const int count = argc - 3;
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
    cq_bytes in = { stream, 0 };
    cq_index *indices;
    double *positions;
    int k;
    if (!file || count < 1 || count > MAX_LEVELS) return fail("usage: lods IN.cqm OUT VERTICES...");
    in.size = fread(stream, 1, sizeof stream, file);
    fclose(file);
    for (k = 0; k < count; k++) {
        lod[k].min_vertices = (cq_index)strtoul(argv[3 + k], NULL, 10);
        lod[k].max_error = CQ_NO_LIMIT;
    }
    indices = malloc(capacity_of(count) * sizeof *indices);
    if (decode(in, count, indices, capacity_of(count)) != CQ_DONE || dec.shape.num_channels == 0 ||
        dec.shape.channel[0].components != 3)
        return fail("no whole stream with positions");
    positions = read_positions();
    for (k = 0; k < count; k++)
        if (!positions || lod[k].num_vertices == 0 || !write_level(&lod[k], indices, positions, argv[2], k))
            return fail("a level cannot be written");
    return 0;
}
