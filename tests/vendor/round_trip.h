/* round_trip.h - an octahedron to a stream and back, in C and C++. SPDX-License-Identifier: MIT */
#include "conquest.h"

#include <string.h>

enum { VERTICES = 6, FACES = 8, BITS = 10 };

/* 1 if the decoded mesh has the positions of the one that was encoded, each where the map says. */
static int round_trip(void)
{
    static const cq_index indices[3 * FACES] = { 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                                 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5 };
    static const cq_value positions[3 * VERTICES] = { 1023, 512, 512, 0, 512, 512, 512, 1023, 512,
                                                      512, 0, 512, 512, 512, 1023, 512, 512, 0 };
    static uint64_t memory[16384];
    static uint8_t stream[1024];
    static cq_decoder decoder;
    static cq_input input;
    cq_index map[VERTICES];
    cq_bytes bytes;
    size_t size = 0, v;

    input.shape.num_vertices = VERTICES;
    input.shape.num_faces = FACES;
    input.shape.num_channels = 1;
    input.shape.channel[0].kind = CQ_POSITION;
    input.shape.channel[0].components = 3;
    input.shape.channel[0].bits = BITS;
    input.indices = indices;
    input.values[0] = positions;
    input.map = map;
    if (cq_encode(&input, memory, sizeof memory, stream, sizeof stream, &size, NULL, NULL) != CQ_OK) return 0;

    bytes.data = stream;
    bytes.size = size;
    if (cq_decoder_init(&decoder, memory, sizeof memory) != CQ_OK) return 0;
    if (cq_decode(&decoder, &bytes, CQ_NO_LIMIT) != CQ_DONE || decoder.mesh.num_faces != FACES) return 0;
    for (v = 0; v < VERTICES; v++)
        if (memcmp(decoder.channel[0] + 3 * (size_t)map[v], positions + 3 * v, 3 * sizeof(cq_value))) return 0;
    return 1;
}
