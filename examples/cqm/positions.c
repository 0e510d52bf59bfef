/* positions.c - positions of a mesh file, which are doubles, to values of a channel and back. SPDX-License-Identifier: MIT
 *
 * Where floats hold the positions well, the quantiser of the library does it. Far from the origin they do not: 0.5 is the
 * distance of two floats at 5 000 000. But a grid may begin there, at a float; its points are origin + step * value in
 * doubles, and so is what comes back. Exact positions are floats, behind such an origin where that is better. */
#include "cqm.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static double step_of_grid(const cq_channel *channel) { return (double)cq_channel_step(channel); }
static double origin_of_grid(const cq_channel *channel, size_t c) { return (double)cq_channel_origin(channel, (int)c); }

static uint32_t float_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_not_above(double x)
{
    float nearest = (float)x;
    return (double)nearest <= x ? nearest : nextafterf(nearest, -FLT_MAX);
}

static float float_not_below(double x)
{
    return -float_not_above(-x);
}

struct box {
    double low[3], high[3], side;      /* the longest one */
};

static void find_box(struct box *box, const double *positions, size_t count)
{
    memset(box, 0, sizeof *box);
    for (size_t i = 0; i < 3 * count; i++) {
        double x = positions[i];
        if (i < 3 || x < box->low[i % 3])
            box->low[i % 3] = x;
        if (i < 3 || x > box->high[i % 3])
            box->high[i % 3] = x;
    }
    for (int c = 0; c < 3; c++)
        box->side = fmax(box->side, box->high[c] - box->low[c]);
}

/* The distance of two points of a grid with so many bits along a side. */
static double step_of(double side, uint32_t bits)
{
    return side / (double)(((uint32_t)1 << bits) - 1);
}

/* -- Grids --------------------------------------------------------------------------------------------------------- */

static int quantise_floats(cq_channel *channel, const struct mesh_file *mesh, cq_value *values)
{
    size_t count = 3 * (size_t)mesh->num_vertices;
    float *positions = malloc((count + 1) * sizeof *positions);
    for (size_t i = 0; i < count && positions != NULL; i++)
        positions[i] = (float)mesh->positions[i];
    int ok = positions != NULL && cq_fit_grid(channel, positions, mesh->num_vertices, NULL) == CQ_OK
             && cq_quantise(channel, positions, mesh->num_vertices, values, NULL) == CQ_OK;
    free(positions);
    return ok;
}

/* How far the points of a grid are from the positions at most. */
static double grid_distance(const cq_channel *channel, const struct mesh_file *mesh, const cq_value *values)
{
    double distance = 0;
    for (size_t i = 0; i < 3 * (size_t)mesh->num_vertices; i++) {
        double x = origin_of_grid(channel, i % 3) + step_of_grid(channel) * values[i];
        distance = fmax(distance, fabs(mesh->positions[i] - x));
    }
    return distance;
}

/* Values on a grid that is chosen already. Returns the first vertex that it does not reach, or the number of vertices. */
static size_t quantise_doubles(const cq_channel *channel, const struct mesh_file *mesh, cq_value *values)
{
    double step = step_of_grid(channel), end = (double)((uint32_t)1 << channel->bits);
    for (size_t i = 0; i < 3 * (size_t)mesh->num_vertices; i++) {
        double offset = mesh->positions[i] - origin_of_grid(channel, i % 3);
        double at = floor(0.5 + (offset == 0 ? 0 : offset / step));
        if (!(at >= 0 && at < end))
            return i / 3;
        values[i] = (cq_value)at;
    }
    return mesh->num_vertices;
}

/* As many bits as numbers up to this one need. */
static uint32_t bits_to_reach(double last)
{
    uint32_t bits = 1;
    while (bits < CQ_MAX_BITS && last >= (double)((uint32_t)1 << bits))
        bits++;
    return bits;
}

/* A grid that begins at the floats below the box, which may be far below it; so more bits than along the side, which
 * cost little, since all values have them in common. */
static double fit_far_grid(cq_channel *channel, const struct box *box, double step)
{
    double reach = 0;
    for (int c = 0; c < 3; c++) {
        float origin = float_not_above(box->low[c]);
        channel->origin[c] = float_bits(origin);
        reach = fmax(reach, box->high[c] - (double)origin);
    }
    step = fmax(fmax(step, step_of(reach, CQ_MAX_BITS)), (double)FLT_MIN);
    channel->step = float_bits(float_not_below(step));
    channel->bits = (uint8_t)bits_to_reach(reach / step_of_grid(channel) + 0.5);
    return step_of_grid(channel);
}

/* How far floats behind an origin are from the positions at most. */
static double float_rounding(const struct mesh_file *mesh, const double origin[3])
{
    double rounding = 0;
    for (size_t i = 0; i < 3 * (size_t)mesh->num_vertices; i++) {
        double x = mesh->positions[i] - origin[i % 3];
        rounding = fmax(rounding, fabs(x - (double)(float)x));
    }
    return rounding;
}

/* Where floats do not hold what the file says, they are counted from an origin in the middle, if that is far better.
 * Returns how far they are from the numbers of the file at most; 0 if that is less than its digits tell. */
static double choose_origin(cq_channel *channel, const struct mesh_file *mesh, const struct box *box)
{
    double middle[3];
    for (int c = 0; c < 3 && mesh->rounding > 0; c++)
        middle[c] = (double)(float)(box->low[c] + (box->high[c] - box->low[c]) / 2);
    double rounding = mesh->rounding > 0 ? float_rounding(mesh, middle) : 0;
    if (8 * rounding >= mesh->rounding)
        return mesh->rounding;
    for (int c = 0; c < 3; c++)
        channel->origin[c] = float_bits((float)middle[c]);
    return rounding > 0.500001 * mesh->unit ? rounding : 0;
}

static int quantise_exactly(const cq_channel *channel, const struct mesh_file *mesh, cq_value *values)
{
    for (size_t i = 0; i < 3 * (size_t)mesh->num_vertices; i++) {
        double origin = origin_of_grid(channel, i % 3);
        uint32_t bits = float_bits((float)(origin != 0 ? mesh->positions[i] - origin : mesh->positions[i]));
        memcpy(&values[i], &bits, sizeof bits);
    }
    return 1;
}

static int add_exact(struct encoding *e, cq_channel *channel, const struct mesh_file *mesh, const char *path,
                     const struct options *options, const struct box *box)
{
    double best = step_of(box->side, CQ_MAX_BITS) / 2, rounding = choose_origin(channel, mesh, box);
    const char *from = channel->origin[0] != 0 || channel->origin[1] != 0 || channel->origin[2] != 0
                       ? " behind an origin" : "";
    if (rounding > best)
        tell_loss(e, options, path, "changed: positions: exact means the nearest 32-bit floats%s, up to %.3g away from "
                  "the numbers of the file; --bits 24 would be within %.3g", from, rounding, best);
    else if (rounding > 0)
        tell_loss(e, options, path, "changed: positions: exact means the nearest 32-bit floats%s, up to %.3g away from "
                  "the numbers of the file", from, rounding);
    return quantise_exactly(channel, mesh, e->values[0]);
}

/* How far are the points of the channel's grid from those that were asked for? */
static double given_grid_distance(const cq_channel *channel, const struct options *options)
{
    double origin = 0, step = fabs(step_of_grid(channel) - options->grid_step);
    for (int c = 0; c < 3; c++)
        origin = fmax(origin, fabs(origin_of_grid(channel, (size_t)c) - options->grid_origin[c]));
    return origin + step * (double)((uint32_t)1 << channel->bits);
}

static int add_on_given_grid(struct encoding *e, cq_channel *channel, const struct mesh_file *mesh, const char *path,
                             const struct options *options, const struct box *box)
{
    double last = 0;
    channel->step = float_bits((float)options->grid_step);
    for (int c = 0; c < 3; c++) {
        channel->origin[c] = float_bits((float)options->grid_origin[c]);
        last = fmax(last, (box->high[c] - origin_of_grid(channel, (size_t)c)) / step_of_grid(channel) + 0.5);
    }
    channel->bits = (uint8_t)bits_to_reach(last);
    size_t vertex = quantise_doubles(channel, mesh, e->values[0]);
    double off = given_grid_distance(channel, options);
    if (vertex == mesh->num_vertices && off > options->grid_step / 64)
        tell_loss(e, options, path, "changed: positions: the points of --grid are up to %.3g from where they should be, "
                  "as its origin and step are 32-bit floats", off);
    if (vertex == mesh->num_vertices)
        return 1;
    const double *p = &mesh->positions[3 * vertex];
    return complain(path, "vertex %zu at %.9g %.9g %.9g is beyond --grid, which has 2^24 points from its origin on along "
                    "each axis", vertex, p[0], p[1], p[2]);
}

int add_positions(struct encoding *e, cq_channel *channel, const struct mesh_file *mesh, const char *path,
                  const struct options *options)
{
    struct box box;
    find_box(&box, mesh->positions, mesh->num_vertices);
    if (channel->bits == CQ_EXACT_BITS)
        return add_exact(e, channel, mesh, path, options, &box);
    if (options->grid_step > 0)
        return add_on_given_grid(e, channel, mesh, path, options, &box);
    double step = step_of(box.side, channel->bits);
    if (mesh->rounding <= step / 64) {
        if (!quantise_floats(channel, mesh, e->values[0]))
            return complain(path, "too large for %lu bits", (unsigned long)options->bits);
        if (grid_distance(channel, mesh, e->values[0]) <= 0.53 * step)       /* floats may be too coarse for more */
            return 1;
    }
    double fitted = fit_far_grid(channel, &box, step);
    if (fitted > 1.5 * step)
        tell_loss(e, options, path, "changed: positions: the step of the grid is %.3g instead of %.3g, as %s", fitted,
                  step, fitted > (double)FLT_MIN ? "they are so far from the origin" : "no float is smaller");
    return quantise_doubles(channel, mesh, e->values[0]) == mesh->num_vertices
           || complain(path, "positions too far apart");
}

/* -- And back ------------------------------------------------------------------------------------------------------ */

static double clamp_to_floats(double x)
{
    return x >= -(double)FLT_MAX ? fmin(x, (double)FLT_MAX) : x < 0 ? -(double)FLT_MAX : 0;
}

/* Unless they move a point by more than an eighth of a step, floats are what others expect. */
static void prefer_floats(double *positions, size_t count, double step)
{
    double moved = 0;
    for (size_t i = 0; i < count; i++)
        moved = fmax(moved, fabs(positions[i] - (double)(float)positions[i]));
    for (size_t i = 0; i < count && moved <= step / 8; i++)
        positions[i] = (double)(float)positions[i];
}

/* Exact values are floats behind an origin; where that is 0, -0 stays what it is. */
static double position_of(const cq_channel *channel, size_t component, cq_value value)
{
    double origin = origin_of_grid(channel, component);
    if (channel->bits != CQ_EXACT_BITS)
        return origin + step_of_grid(channel) * value;
    float number;
    memcpy(&number, &value, sizeof number);
    return origin != 0 ? origin + (double)number : (double)number;
}

double *reconstruct_positions(const cq_channel *channel, const cq_value *values, size_t count)
{
    double *positions = malloc((count + 1) * 3 * sizeof *positions);
    double step = channel->bits != CQ_EXACT_BITS ? step_of_grid(channel) : 0;
    for (size_t i = 0; i < 3 * count && positions != NULL; i++)
        positions[i] = clamp_to_floats(position_of(channel, i % 3, values[i]));
    if (positions != NULL)
        prefer_floats(positions, 3 * count, step);
    return positions;
}
