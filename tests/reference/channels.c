/* Encodes an OFF mesh with channels that cqm does not write: channels SEED [CHANNEL...] <MESH >STREAM.
 * SPDX-License-Identifier: MIT
 *
 * A channel is four numbers: kind,merge,components,bits, as in conquest.h. Without one the seed decides how many there
 * are and which ones. It also decides the noise on their values, which follow the coordinates. From SEED 1000 on the mesh gets
 * seams: groups of faces have vertices of their own at the same places, with other values; and some faces that are no
 * surface, a vertex of no face, and metadata. Every third seed gives it materials. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include <stdio.h>
#include <stdlib.h>

static uint32_t state;

static uint32_t random_below(uint32_t n)
{
    state = state * 1664525u + 1013904223u;
    return (state >> 8) % n;
}

static void fail(const char *what)
{
    fprintf(stderr, "channels: %s\n", what);
    exit(1);
}

static void *allocate(size_t size)
{
    void *block = calloc(size + 1, 1);
    if (!block) fail("no memory");
    return block;
}

static void read_channel(cq_channel *c, const char *text)
{
    unsigned kind, merge, components, bits;
    if (sscanf(text, "%u,%u,%u,%u", &kind, &merge, &components, &bits) != 4) fail("not a channel");
    c->kind = (uint8_t)kind;
    c->merge = (uint8_t)merge;
    c->components = (uint8_t)components;
    c->bits = (uint8_t)bits;
    if (!cqi_channel_is_valid(c)) fail("not a valid channel");
}

/* text: NULL for a random one. */
static void make_channel(cq_channel *c, const char *text)
{
    uint32_t k;
    if (text) read_channel(c, text);
    else do {
        c->kind = (uint8_t)(random_below(2) ? CQ_POSITION : random_below(CQ_GROUP + 2));
        if (c->kind == CQ_TURNED) c->kind = CQ_TANGENT;
        c->merge = (uint8_t)(random_below(2) ? CQ_AVERAGE : random_below(CQ_PER_FACE + 1));
        c->components = (uint8_t)(1 + random_below(CQ_MAX_COMPONENTS));
        c->bits = (uint8_t)(random_below(4) ? 1 + random_below(CQ_MAX_BITS) : CQ_EXACT_BITS);
    } while (!cqi_channel_is_valid(c));
    c->step = state;
    for (k = 0; k < c->components; k++) c->origin[k] = state * (k + 1);
}

/* Coordinates of ref_data are small numbers: -8 .. 8 is stretched to the range of the channel, and noise is added. */
static cq_value scaled(const cq_channel *c, double x, uint32_t noise)
{
    double largest = (double)(((uint32_t)1 << c->bits) - 1);
    x = (x / 16 + 0.5) * largest + (double)random_below(1 + noise);
    return (cq_value)(x < 0 ? 0 : x > largest ? largest : x);
}

/* The float, at times another pattern. */
static cq_value exact(double x, uint32_t noise)
{
    float single = (float)x;
    cq_value value;
    memcpy(&value, &single, sizeof value);
    if (noise && random_below(8) == 0) value = (cq_value)(random_below(1 << 16) * 65537u);
    return value;
}

/* Those of a face are those of a coordinate of its first corner, in few steps. */
static cq_value *make_values(const cq_channel *c, const double *xyz, const cq_index *indices, const cq_shape *s,
                             uint32_t noise)
{
    const int per_face = c->merge == CQ_PER_FACE;
    size_t n = per_face ? s->num_faces : s->num_vertices, v, k;
    cq_value *values = (cq_value *)allocate(n * c->components * sizeof(cq_value));
    for (v = 0; v < n; v++)
        for (k = 0; k < c->components; k++) {
            double x = per_face ? (double)((int)xyz[3 * indices[3 * v]] / 2) : xyz[3 * v + k % 3];
            values[v * c->components + k] = c->bits == CQ_EXACT_BITS ? exact(x, noise) : scaled(c, x, noise);
        }
    return values;
}

/* Room for a mesh that gets seams: a vertex for each corner, and one more; four faces more. */
static cq_index *first_copy; /* of each vertex: the one that it is a copy of */

static void make_seams(cq_shape *s, cq_index *indices, double *xyz)
{
    const uint32_t groups = 2 + random_below(4), size = 1 + random_below(s->num_faces), vertices = s->num_vertices;
    cq_index *copy = (cq_index *)allocate(vertices * sizeof(cq_index));
    uint32_t group, h, v;
    for (v = 0; v < vertices; v++) first_copy[v] = (cq_index)v;
    for (group = 1; group < groups; group++) {
        memset(copy, 0xff, vertices * sizeof(cq_index));
        for (h = 0; h < 3 * s->num_faces; h++) {
            if (h / 3 / size % groups != group) continue;
            v = indices[h];
            if (copy[v] == CQ_NONE) {
                copy[v] = (cq_index)s->num_vertices++;
                first_copy[copy[v]] = (cq_index)v;
                memcpy(xyz + 3 * copy[v], xyz + 3 * v, 3 * sizeof(double));
            }
            indices[h] = copy[v];
        }
    }
    first_copy[s->num_vertices++] = 0;
    memcpy(indices + 3 * s->num_faces, indices, 3 * sizeof(cq_index));
    memcpy(indices + 3 * s->num_faces + 3, indices, 3 * sizeof(cq_index));
    indices[3 * s->num_faces + 4] = indices[0];
    s->num_faces += 2;
    free(copy);
}

/* In bands of a coordinate. */
static cq_index *make_materials(cq_shape *s, const double *xyz, const cq_index *indices)
{
    cq_index *material = (cq_index *)allocate(s->num_faces * sizeof(cq_index));
    const uint32_t bands = 1 + random_below(40);
    size_t f;
    s->num_materials = 2 + random_below(40);
    for (f = 0; f < s->num_faces; f++)
        material[f] = (cq_index)((uint32_t)((xyz[3 * indices[3 * f]] + 8) * bands) % s->num_materials);
    return material;
}

/* A copy has the values of its vertex, but for channels of rows. */
static void copy_values(const cq_channel *c, const cq_shape *s, cq_value *values)
{
    const int of_row = c->kind == CQ_NORMAL || c->kind == CQ_TEXCOORD || c->kind == CQ_COLOR || c->kind == CQ_TANGENT;
    uint32_t v, k;
    for (v = 0; v < s->num_vertices && c->merge != CQ_PER_FACE; v++)
        for (k = 0; k < c->components && (!of_row || random_below(5) == 0); k++)
            values[v * c->components + k] = values[first_copy[v] * c->components + k];
}

int main(int argc, char **argv)
{
    static cq_input in;
    unsigned long v, f, k, index, seams;
    double *xyz;
    cq_index *indices, *materials = NULL;
    uint8_t *out;
    size_t size, stream, tries;
    cq_result result = CQ_ERROR_MEMORY;
    if (argc < 2 || argc > 2 + CQ_MAX_CHANNELS) fail("usage: channels SEED [CHANNEL...] <MESH >STREAM");
    state = (uint32_t)strtoul(argv[1], NULL, 10) * 2654435761u;
    if (scanf("OFF %lu %lu %*d", &v, &f) != 2 || v > 100000 || f > 200000) fail("not an OFF file");
    xyz = (double *)allocate(3 * (v + 3 * f + 1) * sizeof(double));
    indices = (cq_index *)allocate(3 * (f + 4) * sizeof(cq_index));
    first_copy = (cq_index *)allocate((v + 3 * f + 1) * sizeof(cq_index));
    for (k = 0; k < 3 * v; k++)
        if (scanf("%lf", &xyz[k]) != 1) fail("a coordinate is missing");
    for (k = 0; k < 3 * f; k++) {
        if (k % 3 == 0 && (scanf("%lu", &index) != 1 || index != 3)) fail("not a triangle");
        if (scanf("%lu", &index) != 1) fail("a corner is missing");
        indices[k] = (cq_index)index;
    }
    in.shape.num_vertices = (uint32_t)v;
    in.shape.num_faces = (uint32_t)f;
    seams = strtoul(argv[1], NULL, 10) >= 1000;
    if (seams) make_seams(&in.shape, indices, xyz);
    in.shape.metadata_bytes = seams ? random_below(6) : 0;
    in.metadata = (const uint8_t *)"stone";
    v = in.shape.num_vertices;
    if (strtoul(argv[1], NULL, 10) % 3 == 1) in.materials = materials = make_materials(&in.shape, xyz, indices);
    in.shape.num_channels = argc > 2 ? (uint32_t)argc - 2 : random_below(CQ_MAX_CHANNELS + 1);
    in.indices = indices;
    for (k = 0; k < in.shape.num_channels; k++) {
        make_channel(&in.shape.channel[k], argc > 2 ? argv[2 + k] : NULL);
        in.values[k] = make_values(&in.shape.channel[k], xyz, indices, &in.shape,
                                   random_below(2) ? random_below(1000) : 0);
        if (seams) copy_values(&in.shape.channel[k], &in.shape, (cq_value *)(uintptr_t)in.values[k]);
    }
    size = 4096 + 256 * v;
    out = (uint8_t *)allocate(size);
    for (tries = 0; tries < 3 && result == CQ_ERROR_MEMORY; tries++) {
        size_t bytes = cq_encoder_bytes(&in.shape);
        void *memory = allocate(bytes);
        result = cq_encode(&in, memory, bytes, out, size, &stream, NULL, NULL);
        free(memory);
    }
    if (result != CQ_OK) fail(cq_result_string(result));
    fwrite(out, 1, stream, stdout);
    for (k = 0; k < in.shape.num_channels; k++) {
        union { const cq_value *constant; void *block; } values;
        values.constant = in.values[k];
        free(values.block);
    }
    free(out);
    free(indices);
    free(materials);
    free(xyz);
    free(first_copy);
    return fflush(stdout) == 0 ? 0 : 1;
}
