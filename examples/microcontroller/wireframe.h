/* wireframe.h - draws the mesh of a decoder into a small framebuffer. SPDX-License-Identifier: MIT
 *
 * Integers only; memory is the caller's. What faces away is not drawn. Positions have at most 24 bits a coordinate. */
#ifndef WIREFRAME_H
#define WIREFRAME_H

#include "conquest.h"

enum { SCREEN_WIDTH = 128, SCREEN_HEIGHT = 64, WIREFRAME_TURN = 64 };

/* As controllers of displays take it (SSD1306): a byte is eight pixels below each other, the lowest bit on top. */
typedef struct screen {
    uint8_t page[SCREEN_HEIGHT / 8][SCREEN_WIDTH];
} screen;

/* A vertex on the screen. */
typedef struct pixel {
    uint8_t x, y;
} pixel;

/* Between frames. Begin with zeros, and with room for all vertices in `at`. */
typedef struct wireframe {
    pixel *at;                         /* pixel[shape.num_vertices + shape.num_boundary_loops] */
    uint32_t num_seen;                 /* vertices that are in the box */
    int32_t low[3], high[3];           /* the box */
} wireframe;

/* Draws the mesh of this moment, turned about its third axis by `angle`, in parts of WIREFRAME_TURN, and seen from 30
 * degrees above. O(vertices + faces * pixels of an edge) */
void draw_wireframe(screen *s, wireframe *w, const cq_decoder *decoder, uint8_t angle);

int is_lit(const screen *s, uint8_t x, uint8_t y);

#endif
