/* Encodes the triangles of an OFF file from standard input to a conquest stream.   SPDX-License-Identifier: MIT
 *     cc -Iinclude examples/minimal_encode.c -o minimal_encode && ./minimal_encode < bunny.off > bunny.cqm */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#endif

static float position[3 * 250000];
static cq_value value[3 * 250000];
static cq_index corner[3 * 500000];
static uint8_t stream[1 << 22];

static int read_off(uint32_t *num_vertices, uint32_t *num_faces)     /* no comments, polygons or colors */
{
    unsigned long vertices, faces, n = 0;
    if (scanf("OFF %lu %lu %*u", &vertices, &faces) != 2 || vertices > 250000 || faces > 500000)
        return 0;
    for (size_t i = 0; i < 3 * vertices; i++)
        if (scanf("%f", &position[i]) != 1)
            return 0;
    for (size_t i = 0; i < 3 * faces; i++) {
        if ((i % 3 == 0 && (scanf("%lu", &n) != 1 || n != 3)) || scanf("%lu", &n) != 1 || n >= vertices)
            return 0;
        corner[i] = (cq_index)n;
    }
    *num_vertices = (uint32_t)vertices;
    *num_faces = (uint32_t)faces;
    return 1;
}

int main(void)
{
#ifdef _WIN32
    _setmode(1, _O_BINARY);
#endif
    cq_input in = { 0 };
    cq_channel *const c = &in.shape.channel[0];
    if (!read_off(&in.shape.num_vertices, &in.shape.num_faces)) {
        fprintf(stderr, "no OFF file of triangles, or a large one\n");
        return 1;
    }
    in.indices = corner;
    in.values[0] = value;
    in.shape.num_channels = 1;
    c->kind = CQ_POSITION;
    c->components = 3;
    c->bits = 12;
    cq_result result = cq_fit_grid(c, position, in.shape.num_vertices, NULL);
    if (result == CQ_OK)
        result = cq_quantise(c, position, in.shape.num_vertices, value, NULL);
    size_t bytes = cq_encoder_bytes_at_most(&in.shape), written = 0;
    void *memory = malloc(bytes);
    if (result == CQ_OK)
        result = cq_encode(&in, memory, bytes, stream, sizeof stream, &written, NULL, NULL);
    free(memory);
    if (result != CQ_OK) {
        fprintf(stderr, "%s\n", cq_result_string(result));
        return 1;
    }
    return fwrite(stream, 1, written, stdout) == written && fflush(stdout) == 0 ? 0 : 1;
}
