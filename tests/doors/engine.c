/* engine.c - README's lines for an engine: is what they hand to a GPU the mesh? SPDX-License-Identifier: MIT
 *
 *     engine STREAM        decodes it a kilobyte a frame; engine.inc is made from README */
#define CQ_ASSERT(c) ((c) ? (void)0 : abort())
#define CONQUEST_IMPLEMENTATION
#include <stdio.h>
#include <stdlib.h>
#include "conquest.h"

enum { MOST = 1 << 16 };

static uint8_t dirty[MOST >> 6];
static struct {
    cq_value vertices[3 * MOST];
    cq_index triangles[3 * MOST];
    uint32_t num_vertices, num_uploads;
} gpu;

static void append_vertices(const cq_value *from, uint32_t first, uint32_t end)
{
    if (first != gpu.num_vertices || end > MOST) abort();
    memcpy(gpu.vertices + 3 * first, from + 3 * first, 3 * (end - first) * sizeof *from);
    gpu.num_vertices = end;
}

/* Takes the marks off. */
static void upload_blocks(const cq_index *from, uint8_t *blocks, uint32_t count)
{
    uint32_t f;
    if (count > MOST) abort();
    for (f = 0; f < count; f++) {
        if (!blocks[f >> 6]) continue;
        memcpy(gpu.triangles + 3 * f, from + 3 * f, 3 * sizeof *from);
        gpu.num_uploads++;
    }
    memset(blocks, 0, (count + 63) >> 6);
}

#include "engine.inc"

static int is_mesh(const cq_decoder *dec)
{
    return gpu.num_vertices == dec->mesh.num_vertices &&
           memcmp(gpu.vertices, dec->channel[0], 3 * gpu.num_vertices * sizeof(cq_value)) == 0 &&
           memcmp(gpu.triangles, dec->index, 3 * dec->mesh.num_faces * sizeof(cq_index)) == 0;
}

int main(int argc, char **argv)
{
    static uint8_t bytes[MOST];
    static cq_decoder dec;
    cq_shape shape;
    cq_bytes arrived = { bytes, 0 };
    FILE *file = fopen(argv[argc - 1], "rb");
    size_t rest = file ? fread(bytes, 1, sizeof bytes, file) : 0, memory;
    cq_result result = cq_peek(bytes, rest, &shape, NULL, NULL);
    int frames = 0;
    if (file) fclose(file);
    if (result != CQ_OK) return 2;
    memory = cq_decoder_bytes(&shape);
    for (result = begin(&dec, malloc(memory), memory); result >= 0 && result != CQ_DONE; frames++) {
        if (!arrived.size) rest -= arrived.size = rest < 1000 ? rest : 1000;
        result = refine(&dec, &arrived);
        if (!is_mesh(&dec)) return 3;
    }
    printf("%s: %d frames, %lu vertices, %lu triangles uploaded\n", cq_result_string(result), frames,
           (unsigned long)gpu.num_vertices, (unsigned long)gpu.num_uploads);
    return result == CQ_DONE && frames > 5 ? 0 : 1;
}
