/* Decodes a conquest stream from standard input to OFF, or the start of one.   SPDX-License-Identifier: MIT
 *     cc -Iinclude examples/minimal_decode.c -o minimal_decode && ./minimal_decode < bunny.cqm > bunny.off */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include <stdio.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#endif

static uint8_t stream[1 << 22];
static uint32_t memory[CQ_DECODER_BYTES(250000, 500000, 3) / 4];     /* vertices, faces, numbers per vertex */
static cq_decoder dec;

int main(void)
{
#ifdef _WIN32
    _setmode(0, _O_BINARY);
    _setmode(1, _O_BINARY);
#endif
    cq_bytes in = { stream, fread(stream, 1, sizeof stream, stdin) };
    cq_result result = cq_decoder_init(&dec, memory, sizeof memory);
    if (result == CQ_OK)
        result = cq_decode(&dec, &in, CQ_NO_LIMIT);
    if (result == CQ_NEED_INPUT)
        result = cq_decode(&dec, NULL, CQ_NO_LIMIT);     /* there is no more: CQ_TRUNCATED, a coarser mesh */
    if (result < 0 || dec.mesh.num_vertices == 0 || dec.shape.channel[0].components != 3) {
        fprintf(stderr, "%s\n", result < 0 ? cq_result_string(result) : "no mesh with positions");
        return 1;
    }
    printf("OFF\n%lu %lu 0\n", (unsigned long)dec.mesh.num_vertices, (unsigned long)dec.mesh.num_faces);
    for (size_t v = 0; v < dec.mesh.num_vertices; v++) {
        float at[3];
        cq_reconstruct(&dec.shape.channel[0], dec.channel[0] + 3 * v, 1, at);
        printf("%.9g %.9g %.9g\n", (double)at[0], (double)at[1], (double)at[2]);
    }
    for (size_t i = 0; i < 3 * (size_t)dec.mesh.num_faces; i++)
        printf("%s%lu%c", i % 3 == 0 ? "3 " : "", (unsigned long)dec.mesh.origin[i], i % 3 == 2 ? '\n' : ' ');
    if (result == CQ_TRUNCATED)
        fprintf(stderr, "the stream is cut off: this is a coarser mesh\n");
    return fflush(stdout) != 0 ? 1 : result == CQ_DONE ? 0 : 2;
}
