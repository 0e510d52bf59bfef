/* labels.c - materials, groups and objects of faces, with their names, go into a stream. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_METADATA_BYTES = 1 << 20 };

static int has_faces_of_none(const struct mesh_file *mesh)
{
    for (size_t f = 0; f < mesh->num_faces; f++)
        if (mesh->label[MESH_MATERIALS].of_face[f] == 0)
            return 1;
    return 0;
}

/* Materials count from 0; the number behind the last one is none. */
static int add_materials(struct encoding *e, const struct mesh_file *mesh, const char *path)
{
    const struct mesh_labels *materials = &mesh->label[MESH_MATERIALS];
    uint32_t k = e->input.shape.num_channels, none = materials->count;
    if (materials->of_face == NULL)
        return 1;
    if (none + 1 <= CQ_MAX_MATERIALS) {
        e->input.shape.num_materials = none + (uint32_t)has_faces_of_none(mesh);
        e->materials = malloc((mesh->num_faces + (size_t)1) * sizeof *e->materials);
        e->input.materials = e->materials;
        for (size_t f = 0; f < mesh->num_faces && e->materials != NULL; f++)
            e->materials[f] = materials->of_face[f] > 0 ? materials->of_face[f] - 1 : none;
        return e->materials != NULL || complain(path, "out of memory");
    }
    if (add_channel(e, CQ_GROUP, CQ_PER_FACE, 1, bits_of_number(none)) == NULL)
        return complain(path, "out of memory");
    for (size_t f = 0; f < mesh->num_faces; f++)
        e->values[k][f] = (cq_value)(materials->of_face[f] > 0 ? materials->of_face[f] - 1 : none);
    return 1;
}

static uint32_t face_number(const struct mesh_file *mesh, int kind, size_t face)
{
    return kind == FACE_MARKS ? mesh->marks[face] : mesh->label[kind].of_face[face];
}

/* Groups, objects and marks, where these differ from face to face. */
static int add_face_numbers(struct encoding *e, const struct mesh_file *mesh, const char *path, int kind)
{
    uint32_t k = e->input.shape.num_channels;
    uint32_t largest = kind == FACE_MARKS ? 2u * MESH_POINT - 1 : mesh->label[kind].count;
    if (!needs_face_numbers(mesh, kind))
        return 1;
    if (add_channel(e, CQ_GENERIC, CQ_PER_FACE, 1, bits_of_number(largest)) == NULL)
        return complain(path, "out of memory");
    for (size_t f = 0; f < mesh->num_faces; f++)
        e->values[k][f] = (cq_value)face_number(mesh, kind, f);
    return 1;
}

static void drop_labels(struct mesh_file *mesh)
{
    for (int k = 0; k < MESH_NUM_LABELS; k++) {
        free(mesh->label[k].of_face);
        free(mesh->label[k].names);
        memset(&mesh->label[k], 0, sizeof mesh->label[k]);
    }
    free(mesh->libraries);
    mesh->libraries = NULL;
}

int add_labels(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options)
{
    if ((options->attributes & KEEP_MATERIALS) == 0)
        drop_labels(mesh);
    int ok = add_materials(e, mesh, path);
    for (int kind = FACE_GROUP; kind < NUM_FACE_NUMBERS && ok; kind++)
        ok = add_face_numbers(e, mesh, path, kind);
    if (!ok)
        return 0;
    if ((e->words = make_words(mesh)) == NULL)
        return complain(path, "out of memory");
    size_t size = strlen(e->words);
    if (size > MAX_METADATA_BYTES) {
        tell_loss(e, options, path, "dropped: names of materials, groups and objects, which have %zu bytes", size);
        size = strncmp(e->words, "faces", 5) == 0 ? strcspn(e->words, "\n") + 1 : 0;     /* no name */
    }
    e->input.shape.metadata_bytes = (uint32_t)size;
    e->input.metadata = (const uint8_t *)e->words;
    return 1;
}
