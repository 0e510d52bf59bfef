/* encode.c - mesh file -> stream. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "cqm.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* -- Positions ----------------------------------------------------------------------------------------------------- */

static int add_positions(struct encoding *e, const struct mesh_file *mesh, const char *path, uint32_t bits)
{
    cq_channel *channel = &e->input.shape.channel[0];
    cq_result result;
    e->positions = malloc((3 * (size_t)mesh->num_vertices + 1) * sizeof *e->positions);
    if (e->positions == NULL)
        return complain(path, "out of memory");
    channel->kind = CQ_POSITION;
    channel->components = 3;
    channel->bits = (uint8_t)bits;
    result = cq_fit_grid(channel, mesh->positions, mesh->num_vertices, NULL);
    if (result == CQ_OK)
        result = cq_quantise(channel, mesh->positions, mesh->num_vertices, e->positions, NULL);
    e->input.shape.num_channels = 1;
    e->input.values[0] = e->positions;
    return result == CQ_OK || complain(path, "too large for %lu bits", (unsigned long)bits);
}

/* -- Progress ------------------------------------------------------------------------------------------------------ */

struct progress {
    time_t start;
    int percent;       /* shown; -1: nothing yet */
};

/* Shows per cent on the terminal once encoding has taken two seconds. */
static void show_progress(void *user, uint32_t done, uint32_t total)
{
    struct progress *p = user;
    int percent = total > 0 ? (int)((uint64_t)done * 100 / total) : 0;
    if (percent == p->percent || time(NULL) - p->start < 2)
        return;
    p->percent = percent;
    fprintf(stderr, "\rencoding %3d %%", percent);
}

static void clear_progress(const struct progress *p)
{
    if (p->percent >= 0)
        fprintf(stderr, "\r              \r");
}

/* -- Encoding ------------------------------------------------------------------------------------------------------ */

static int complain_mesh(const char *path, cq_result result, const cq_place *at)
{
    unsigned long face = at->face, a = at->vertex, b = at->other;
    switch (result) {
    case CQ_ERROR_INDEX:
        return complain(path, "face %lu names vertex %lu, which does not exist", face, a);
    case CQ_ERROR_FACE:
        return complain(path, "face %lu names vertex %lu twice", face, a);
    case CQ_ERROR_EDGE:
        return complain(path, "edge %lu-%lu has more than two faces (face %lu)", a, b, face);
    case CQ_ERROR_ORIENTATION:
        return complain(path, "edge %lu-%lu has two faces of opposite orientation (face %lu)", a, b, face);
    case CQ_ERROR_VERTEX:
        return complain(path, "the faces around vertex %lu are not one fan", a);
    case CQ_ERROR_UNUSED:
        return complain(path, "vertex %lu belongs to no face", a);
    default:
        return complain(path, "%s", cq_result_string(result));
    }
}

/* One try with as much memory as the shape is known to need. */
static cq_result encode_once(struct encoding *e, size_t capacity, cq_place *place)
{
    size_t memory_size = cq_encoder_bytes(&e->input.shape);
    if (memory_size == 0)
        return CQ_ERROR_TOO_LARGE;
    void *memory = malloc(memory_size);
    free(e->stream);
    e->stream = malloc(capacity);
    cq_result result = CQ_ERROR_MEMORY;
    if (memory != NULL && e->stream != NULL)
        result = cq_encode(&e->input, memory, memory_size, e->stream, capacity, &e->size, place, &e->report);
    free(memory);
    return result;
}

/* Boundaries are known after the first try, the size of the stream after one that did not fit. */
static cq_result encode_with_retries(struct encoding *e, cq_place *place)
{
    size_t capacity = 4096 + 16 * (size_t)e->input.shape.num_vertices;
    cq_result result = encode_once(e, capacity, place);
    if (result == CQ_ERROR_MEMORY)
        result = encode_once(e, capacity, place);
    if (result == CQ_ERROR_OUTPUT)
        result = encode_once(e, e->size, place);
    return result;
}

static int prepare_input(struct encoding *e, const struct mesh_file *mesh, const char *path,
                         const struct options *options)
{
    memset(e, 0, sizeof *e);
    e->input.shape.num_vertices = mesh->num_vertices;
    e->input.shape.num_faces = mesh->num_faces;
    e->input.indices = mesh->indices;
    e->input.goal = options->goal;
    e->input.map = malloc(((size_t)mesh->num_vertices + 1) * sizeof *e->input.map);
    if (e->input.map == NULL)
        return complain(path, "out of memory");
    return options->connectivity || add_positions(e, mesh, path, options->bits);
}

int encode_mesh(struct encoding *e, const struct mesh_file *mesh, const char *path, const struct options *options)
{
    struct progress progress = { time(NULL), -1 };
    cq_place place;
    if (!prepare_input(e, mesh, path, options))
        return 0;
    if (isatty(STDERR_FILENO) && !options->quiet) {
        e->input.progress = show_progress;
        e->input.user = &progress;
    }
    cq_result result = encode_with_retries(e, &place);
    clear_progress(&progress);
    return result == CQ_OK || complain_mesh(path, result, &place);
}

void free_encoding(struct encoding *e)
{
    free(e->positions);
    free(e->input.map);
    free(e->stream);
}

static int save_stream(const char *path, const uint8_t *data, size_t size)
{
    struct output output;
    if (!open_output(&output, path))
        return 0;
    fwrite(data, 1, size, output.file);
    return close_output(&output);
}

int run_encode(const struct options *options)
{
    static struct encoding e;
    struct mesh_file mesh;
    enum mesh_format format = choose_format(options->files[0], options);
    if (format == MESH_UNKNOWN)
        return EXIT_BAD_USAGE;
    if (!load_mesh(&mesh, options->files[0], format))
        return EXIT_BAD_DATA;
    int ok = encode_mesh(&e, &mesh, options->files[0], options) && save_stream(options->files[1], e.stream, e.size);
    free_encoding(&e);
    mesh_free(&mesh);
    return ok ? 0 : EXIT_BAD_DATA;
}
