/* main.c - decodes a mesh on a microcontroller, from flash into static memory. SPDX-License-Identifier: MIT
 *
 *     make embedded        builds it for Cortex-M3, Cortex-M0, RV32 and AVR, runs it, checks hashes and budgets
 *
 * No heap, no operating system, no libc: board.h is all that it asks of the device. stream.h is made from a stream when
 * the program is built and holds `static const uint8_t stream[]`, STREAM_VERTICES and STREAM_FACES, boundary loops and
 * boundary edges included. Prints one `key value` a line; the exit status is 0 if the mesh is complete. */
#include "board.h"
#include "conquest.h"
#include "report.h"
#include "stream.h"

static cq_decoder decoder;
static uint32_t memory[CQ_DECODER_BYTES(STREAM_VERTICES, STREAM_FACES, 3) / sizeof(uint32_t)];

static uint32_t num_values(uint32_t channel)
{
    const cq_channel *c = &decoder.shape.channel[channel];
    return c->merge == CQ_PER_FACE ? decoder.mesh.num_faces : (uint32_t)decoder.mesh.num_vertices * c->components;
}

/* Of the faces and all values: equal meshes have equal hashes, whatever the device and the width of its indices. */
static uint32_t hash_mesh(void)
{
    uint32_t hash = 0x811c9dc5u, i, k;
    for (i = 0; i < 3 * (uint32_t)decoder.mesh.num_faces; i++) hash = add_to_hash(hash, decoder.mesh.origin[i]);
    for (k = 0; k < decoder.shape.num_channels; k++)
        for (i = 0; i < num_values(k); i++)
            hash = add_to_hash(hash, (uint32_t)decoder.channel[k][i]);
    return hash;
}

/* One step at a time: between any two the device can do something else, and the mesh is a valid one. */
static cq_result decode(uint32_t *base_vertices)
{
    cq_bytes in = { stream, sizeof stream };
    cq_result result;
    cq_decoder_init(&decoder, memory, sizeof memory);
    do {
        result = cq_decode(&decoder, &in, 1);
        if (!*base_vertices) *base_vertices = decoder.mesh.num_vertices;
        board_step();
    } while (result == CQ_MORE);
    return result;
}

int main(void)
{
    uintptr_t top = board_stack_pointer();
    uint32_t base_vertices = 0, stack;
    cq_result result;
    board_paint_stack();
    result = decode(&base_vertices);
    stack = board_stack_used(top);
    board_print("result ");
    board_print(cq_result_string(result));
    print_number("\nvertices ", decoder.mesh.num_vertices, 10);
    print_number("faces ", decoder.mesh.num_faces, 10);
    print_number("splits ", decoder.mesh.num_vertices - base_vertices, 10);
    print_number("hash ", hash_mesh(), 16);
    print_number("decoder ", sizeof decoder, 10);
    print_number("memory ", sizeof memory, 10);
    print_number("stack ", stack, 10);
    return result == CQ_DONE ? 0 : 1;
}
