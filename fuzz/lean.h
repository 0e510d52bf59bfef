/* What lean.c reads and mutator.c writes: some bytes that choose the shape of a small mesh, then a payload. */
#ifndef CQ_FUZZ_LEAN_H
#define CQ_FUZZ_LEAN_H

#include "fuzz.h"

/* Up to 31 vertices and 3 boundary loops; counts that fit together, but for the genus, which may be too large. One in
 * eight has seams, triangles aside or metadata. */
static inline void take_small_shape(input *in, cq_shape *shape)
{
    uint32_t size = take(in), loops = take(in);
    int32_t faces;
    memset(shape, 0, sizeof *shape);
    shape->num_vertices = 3 + size % 29;
    shape->num_boundary_loops = loops < 128 ? 0 : loops % 4;
    if (shape->num_boundary_loops > 0) shape->num_boundary_edges = 3 * shape->num_boundary_loops + loops / 4 % 8;
    faces = 2 * (int32_t)(shape->num_vertices + shape->num_boundary_loops) - (int32_t)shape->num_boundary_edges;
    faces -= 4 * ((int32_t)(size / 29) % 4 + (size >= 232 ? -5 : 1)); /* parts less handles */
    shape->num_faces = faces < 0 ? (uint32_t)(faces & 3) : (uint32_t)faces;
    take_channels(in, shape);
    if (loops % 8 == 5) take_extension(in, shape);
}

#endif
