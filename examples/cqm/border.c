/* border.c - keeps the border of a surface at every level. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <stdlib.h>

/* The first vertex at the place of each, as the grid has it. NULL: no memory. */
static uint32_t *find_places(const struct encoding *e, const struct mesh_file *mesh)
{
    if (e->input.shape.num_channels > 0 && e->input.shape.channel[0].kind == CQ_POSITION)
        return mesh_first_equal(e->values[0], mesh->num_vertices, 3 * sizeof(cq_value));
    uint32_t *place = malloc(((size_t)mesh->num_vertices + 1) * sizeof *place);
    for (uint32_t v = 0; v < mesh->num_vertices && place != NULL; v++)
        place[v] = mesh->number != NULL ? mesh->number[v] : v;
    return place;
}

/* Edges as pairs of places, the smaller one first. NULL: no memory. */
static uint32_t *list_edges(const struct mesh_file *mesh, const uint32_t *place)
{
    uint32_t *edge = malloc((3 * (size_t)mesh->num_faces + 1) * 2 * sizeof *edge);
    for (size_t c = 0; c < 3 * (size_t)mesh->num_faces && edge != NULL; c++) {
        uint32_t a = place[mesh->indices[c]], b = place[mesh->indices[c % 3 == 2 ? c - 2 : c + 1]];
        edge[2 * c] = a < b ? a : b;
        edge[2 * c + 1] = a < b ? b : a;
    }
    return edge;
}

/* Marks places at edges with one face. `first`: the first edge that is equal to each; `faces`: how many are. */
static void mark_border(struct encoding *e, const uint32_t *edge, const uint32_t *first, uint32_t *faces, size_t edges)
{
    for (size_t i = 0; i < edges; i++)
        faces[first[i]]++;
    for (size_t i = 0; i < edges; i++)
        if (faces[first[i]] == 1 && edge[2 * i] != edge[2 * i + 1])
            e->locked[edge[2 * i]] = e->locked[edge[2 * i + 1]] = 1;
}

int lock_border(struct encoding *e, const struct mesh_file *mesh, const char *path)
{
    size_t edges = 3 * (size_t)mesh->num_faces;
    uint32_t *place = find_places(e, mesh), *edge = place != NULL ? list_edges(mesh, place) : NULL;
    uint32_t *first = edge != NULL ? mesh_first_equal(edge, edges, 2 * sizeof *edge) : NULL;
    uint32_t *faces = calloc(edges + 1, sizeof *faces);
    e->locked = calloc((size_t)mesh->num_vertices + 1, 1);
    int ok = first != NULL && faces != NULL && e->locked != NULL;
    if (ok)
        mark_border(e, edge, first, faces, edges);
    for (size_t v = 0; v < mesh->num_vertices && ok; v++)
        e->locked[v] = e->locked[place[v]];
    e->input.locked = e->locked;
    free(place);
    free(edge);
    free(first);
    free(faces);
    return ok || complain(path, "out of memory");
}
