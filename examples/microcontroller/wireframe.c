/* wireframe.c - see wireframe.h. SPDX-License-Identifier: MIT */
#include "wireframe.h"

#include <string.h>

/* -- The screen ---------------------------------------------------------------------------------------------------- */

int is_lit(const screen *s, uint8_t x, uint8_t y) { return s->page[y / 8][x] >> (y % 8) & 1; }

static void light(screen *s, int x, int y) { s->page[y / 8][x] |= (uint8_t)(1 << (y % 8)); }

static int distance(int a, int b) { return a < b ? b - a : a - b; }

/* Bresenham's algorithm: `error` is the sum of both coordinates' distances to the line, times its extents. */
static void draw_line(screen *s, pixel from, pixel to)
{
    int x = from.x, y = from.y, dx = distance(x, to.x), dy = distance(y, to.y), error = dx - dy, twice;
    const int right = x < to.x ? 1 : -1, down = y < to.y ? 1 : -1;
    light(s, x, y);
    while (x != to.x || y != to.y) {
        twice = 2 * error;
        if (twice > -dy) error -= dy, x += right;
        if (twice < dx) error += dx, y += down;
        light(s, x, y);
    }
}

/* -- From the mesh to the screen ----------------------------------------------------------------------------------- */

/* 256 times the sine of a part of WIREFRAME_TURN. */
static int32_t sine(uint8_t part)
{
    static const uint8_t quarter[16] = { 0, 25, 50, 74, 98, 121, 142, 162, 181, 198, 213, 226, 237, 245, 251, 255 };
    const uint8_t k = part % 16;
    const int32_t size = part & 16 ? (k ? quarter[16 - k] : 256) : quarter[k];
    return part & 32 ? -size : size;
}

/* A vertex never changes once it is decoded, so that only new ones may make the box larger. */
static void add_to_box(wireframe *w, const cq_decoder *decoder)
{
    for (; w->num_seen < decoder->mesh.num_vertices; w->num_seen++) {
        const cq_value *at = decoder->channel[0] + 3 * (size_t)w->num_seen;
        int k;
        for (k = 0; k < 3; k++) {
            if (!w->num_seen || at[k] < w->low[k]) w->low[k] = at[k];
            if (!w->num_seen || at[k] > w->high[k]) w->high[k] = at[k];
        }
    }
}

typedef struct view {
    int32_t centre[3], divisor;        /* units of the grid, so that all is below 2^10 afterwards */
    int32_t sine, cosine, scale;       /* times 256, 256, 1024 */
} view;

/* The hypotenuse of a box is at most its longer side and half of the shorter one, at whatever angle it stands. */
static view make_view(const wireframe *w, uint8_t angle)
{
    view v;
    int32_t half[3], across, up, k;
    for (k = 0, v.divisor = 1; k < 3; k++) {
        v.centre[k] = (w->low[k] + w->high[k]) / 2;
        half[k] = (w->high[k] - w->low[k] + 1) / 2;
        while (half[k] / v.divisor >= 1024) v.divisor *= 2;
    }
    across = (half[0] < half[1] ? half[1] + half[0] / 2 : half[0] + half[1] / 2) / v.divisor + 1;
    up = (222 * (half[2] / v.divisor) + 128 * across) / 256 + 1;       /* cosine and sine of 30 degrees */
    v.scale = 1024 * (SCREEN_HEIGHT / 2 - 2) / up;
    if (v.scale > 1024 * (SCREEN_WIDTH / 2 - 2) / across) v.scale = 1024 * (SCREEN_WIDTH / 2 - 2) / across;
    v.sine = sine(angle % WIREFRAME_TURN);
    v.cosine = sine((uint8_t)((angle + WIREFRAME_TURN / 4) % WIREFRAME_TURN));
    return v;
}

/* Below 2^10 * 256 * 3, and, with |right| <= across and |up| <= up of make_view, on the screen. */
static pixel project(const view *v, const cq_value *at)
{
    const int32_t x = (at[0] - v->centre[0]) / v->divisor, y = (at[1] - v->centre[1]) / v->divisor;
    const int32_t z = (at[2] - v->centre[2]) / v->divisor;
    const int32_t right = (v->cosine * x - v->sine * y) / 256, behind = (v->sine * x + v->cosine * y) / 256;
    const int32_t up = (222 * z + 128 * behind) / 256;
    pixel p;
    p.x = (uint8_t)(SCREEN_WIDTH / 2 + right * v->scale / 1024);
    p.y = (uint8_t)(SCREEN_HEIGHT / 2 - up * v->scale / 1024);
    return p;
}

/* Counter-clockwise, on a screen whose y runs down. */
static int faces_viewer(pixel a, pixel b, pixel c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0;
}

void draw_wireframe(screen *s, wireframe *w, const cq_decoder *decoder, uint8_t angle)
{
    view v;
    size_t i;
    add_to_box(w, decoder);
    v = make_view(w, angle);
    for (i = 0; i < w->num_seen; i++) w->at[i] = project(&v, decoder->channel[0] + 3 * i);
    memset(s, 0, sizeof *s);
    for (i = 0; i < decoder->mesh.num_faces; i++) {
        const cq_index *corner = decoder->mesh.origin + 3 * i;
        const pixel a = w->at[corner[0]], b = w->at[corner[1]], c = w->at[corner[2]];
        if (!faces_viewer(a, b, c)) continue;
        draw_line(s, a, b);
        draw_line(s, b, c);
        draw_line(s, c, a);
    }
}
