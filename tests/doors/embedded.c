/* embedded.c - README's lines for a microcontroller, on one. SPDX-License-Identifier: MIT
 *
 * embedded.inc is made from README; stream.h, board.h and report.h are as for examples/microcontroller/main.c. */
#include <stdint.h>

static uint32_t num_drawn;
static void draw_triangles(const uint16_t *index, uint16_t count, const int16_t *positions)
{
    (void)positions;
    while (count--) num_drawn += index[3 * count] != index[3 * count + 1];
}

#include "embedded.inc"
#include "report.h"
#include "stream.h"

static uint32_t hash_mesh(void)
{
    uint32_t hash = 0x811c9dc5u, i;
    for (i = 0; i < 3 * (uint32_t)dec.mesh.num_faces; i++) hash = add_to_hash(hash, dec.mesh.origin[i]);
    for (i = 0; i < 3 * (uint32_t)dec.mesh.num_vertices; i++) hash = add_to_hash(hash, (uint32_t)dec.channel[0][i]);
    return hash;
}

int main(void)
{
    cq_bytes in = { stream, sizeof stream };
    int result = begin();
    if (result != CQ_OK) return 2;
    do {
        result = receive(&in);
        num_drawn = 0;
        draw();
        if (num_drawn != dec.mesh.num_faces) return 3;
        board_step();
    } while (result == CQ_MORE);
    board_print("result ");
    board_print(cq_result_string((cq_result)result));
    print_number("\nhash ", hash_mesh(), 16);
    return result == CQ_DONE ? 0 : 1;
}
