/* stream.c - decodes standard input as it arrives, 256 bytes at a time. SPDX-License-Identifier: MIT
 *
 *     cc -Iinclude examples/stream.c -o stream && curl -s https://example.org/bunny.cqm | ./stream
 *
 * This is all that a device needs: the decoder, a block of memory, and a buffer that is used again for each piece. Here
 * the block is static; a program with a heap can ask cq_decoder_bytes once it has the header. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include <stdio.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#endif

#define MAX_VERTICES 50000          /* with one for each boundary loop */
#define MAX_FACES 100000            /* with one for each boundary edge */
#define MAX_COMPONENTS 3            /* of all channels: x, y, z */
#define PIECE_BYTES CQ_MAX_HEADER_BYTES
#define STEPS_PER_CALL 1000         /* bounds the time of a call, so that a frame can be drawn in between */

static cq_decoder dec;
static uint32_t memory[CQ_DECODER_BYTES(MAX_VERTICES, MAX_FACES, MAX_COMPONENTS) / sizeof(uint32_t)];

/* A renderer would draw here: triangles dec.mesh.origin[0 .. 3 * num_faces - 1], vertices dec.channel[0]. */
static void show(size_t bytes)
{
    printf("%8zu bytes  %8lu vertices  %8lu faces  level %lu\n", bytes, (unsigned long)dec.mesh.num_vertices,
           (unsigned long)dec.mesh.num_faces, (unsigned long)dec.level);
}

/* Uses up one piece of input, a bounded number of steps at a time. */
static cq_result decode_piece(cq_bytes *in)
{
    cq_result result;
    do
        result = cq_decode(&dec, in, STEPS_PER_CALL);
    while (result == CQ_MORE);
    return result;
}

/* Decodes until the mesh is complete, the input ends or an error is met. */
static cq_result decode_file(FILE *file, size_t *bytes)
{
    uint8_t piece[PIECE_BYTES];
    cq_result result = CQ_NEED_INPUT;
    *bytes = 0;
    while (result == CQ_NEED_INPUT) {
        cq_bytes in = { piece, fread(piece, 1, sizeof piece, file) };
        if (in.size == 0)
            return cq_decode(&dec, NULL, CQ_NO_LIMIT);       /* CQ_TRUNCATED: what there is stays a valid mesh */
        result = decode_piece(&in);
        *bytes += (size_t)(in.data - piece);
        show(*bytes);
    }
    return result;
}

/* What a decoder for this stream would have needed, if it did not fit. */
static void explain_memory(void)
{
    printf("%zu bytes of memory, %zu needed\n", sizeof memory, cq_decoder_bytes(&dec.shape));
}

int main(void)
{
    size_t bytes;
    cq_result result;
#ifdef _WIN32
    _setmode(0, _O_BINARY);
#endif
    result = cq_decoder_init(&dec, memory, sizeof memory);
    if (result == CQ_OK)
        result = decode_file(stdin, &bytes);
    if (result == CQ_ERROR_MEMORY)
        explain_memory();
    printf("%s: %lu of %lu vertices\n", cq_result_string(result), (unsigned long)dec.mesh.num_vertices,
           (unsigned long)dec.shape.num_vertices);
    return result == CQ_DONE ? 0 : 1;
}
