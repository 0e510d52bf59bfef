/* display.c - a device with a display of 128 x 64 pixels: the mesh turns while it arrives. SPDX-License-Identifier: MIT
 *
 *     make embedded        builds it for a Cortex-M3, runs it, prints its last frame
 *
 * Beside the decoder it needs the framebuffer, 1 KiB, and two bytes per vertex. Each frame decodes STEPS steps: what a
 * frame takes is bounded, whatever has arrived. Prints vertices, lit pixels and a hash of each frame, and the last one
 * with a character for two pixels; the exit status is 0 if the mesh is complete. */
#include "board.h"
#include "conquest.h"
#include "report.h"
#include "stream.h"
#include "wireframe.h"

enum { STEPS = 8 };

static cq_decoder decoder;
static uint32_t memory[CQ_DECODER_BYTES(STREAM_VERTICES, STREAM_FACES, 3) / sizeof(uint32_t)];
static pixel pixels[STREAM_VERTICES];
static screen framebuffer;

/* In place of the driver of a display. */
static void show_frame(uint32_t number)
{
    uint32_t hash = 0x811c9dc5u, lit = 0;
    uint8_t x, y;
    for (y = 0; y < SCREEN_HEIGHT; y++)
        for (x = 0; x < SCREEN_WIDTH; x++) {
            lit += (uint32_t)is_lit(&framebuffer, x, y);
            hash = add_to_hash(hash, (uint32_t)is_lit(&framebuffer, x, y));
        }
    print_number("frame ", number, 10);
    print_number("vertices ", decoder.mesh.num_vertices, 10);
    print_number("lit ", lit, 10);
    print_number("frame_hash ", hash, 16);
}

static void print_picture(void)
{
    char line[SCREEN_WIDTH + 2];
    uint8_t x, y;
    line[SCREEN_WIDTH] = '\n';
    line[SCREEN_WIDTH + 1] = '\0';
    for (y = 0; y < SCREEN_HEIGHT; y += 2) {
        for (x = 0; x < SCREEN_WIDTH; x++)
            line[x] = " '.:"[is_lit(&framebuffer, x, y) + 2 * is_lit(&framebuffer, x, (uint8_t)(y + 1))];
        board_print(line);
    }
}

int main(void)
{
    cq_bytes in = { stream, sizeof stream };
    wireframe frame = { pixels, 0, { 0, 0, 0 }, { 0, 0, 0 } };
    cq_result result;
    uint32_t number = 0;
    cq_decoder_init(&decoder, memory, sizeof memory);
    do {
        result = cq_decode(&decoder, &in, STEPS);
        if (result < 0 || decoder.shape.channel[0].components != 3) break;
        draw_wireframe(&framebuffer, &frame, &decoder, (uint8_t)number);
        show_frame(number++);
        board_step();
    } while (result == CQ_MORE);
    print_picture();
    board_print("result ");
    board_print(cq_result_string(result));
    board_print("\n");
    return result == CQ_DONE ? 0 : 1;
}
