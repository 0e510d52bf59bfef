/* decode.c - stream -> mesh file. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <stdlib.h>
#include <string.h>

/* -- Opening a stream ---------------------------------------------------------------------------------------------- */

int complain_stream(const char *path, cq_result result, size_t used)
{
    return complain(path, "%s (byte %zu)", cq_result_string(result), used);
}

static int check_header(const char *path, const uint8_t *data, size_t size, cq_shape *shape, size_t *stream_bytes)
{
    cq_result result = cq_peek(data, size, shape, NULL, stream_bytes);
    if (result == CQ_NEED_INPUT)
        return complain(path, "the file ends inside the header (byte %zu)", size);
    if (result != CQ_OK)
        return complain_stream(path, result, 0);
    if (size > *stream_bytes)
        return complain(path, "%zu bytes too many behind the stream (byte %zu)", size - *stream_bytes, *stream_bytes);
    return 1;
}

int open_decoding(struct decoding *d, const char *path, const uint8_t *data, size_t size)
{
    cq_shape shape;
    d->memory = NULL;
    if (!check_header(path, data, size, &shape, &d->stream_bytes))
        return 0;
    size_t memory_size = cq_decoder_bytes(&shape);
    if (memory_size == 0)
        return complain_stream(path, CQ_ERROR_TOO_LARGE, 0);
    d->memory = malloc(memory_size);
    if (d->memory == NULL)
        return complain(path, "cannot have %zu bytes of memory", memory_size);
    cq_result result = cq_decoder_init(&d->decoder, d->memory, memory_size);
    return result == CQ_OK || complain_stream(path, result, 0);
}

void close_decoding(struct decoding *d)
{
    free(d->memory);
}

/* -- Refining as far as the options say ---------------------------------------------------------------------------- */

static int is_fine_enough(const cq_decoder *d, const struct options *options)
{
    uint32_t vertices = d->mesh.num_vertices;
    return vertices > 0 && (vertices >= options->max_vertices || d->level > options->max_levels);
}

/* A step makes at most one vertex, so that many steps cannot pass the limit. Steps one by one stop between the levels
 * and at the base. */
static uint32_t step_budget(const cq_decoder *d, const struct options *options)
{
    if (options->max_levels != CQ_NO_LIMIT || d->mesh.num_vertices == 0)
        return 1;
    return options->max_vertices - d->mesh.num_vertices;
}

/* CQ_OK: a limit is reached. CQ_DONE, CQ_TRUNCATED or an error as cq_decode has it. */
static cq_result refine(cq_decoder *d, cq_bytes *in, const struct options *options)
{
    cq_result result = CQ_OK;
    while (result == CQ_OK && !is_fine_enough(d, options)) {
        result = cq_decode(d, in, step_budget(d, options));
        if (result == CQ_NEED_INPUT)
            result = cq_decode(d, NULL, step_budget(d, options));
    }
    return result;
}

/* -- From channel values to coordinates ---------------------------------------------------------------------------- */

/* The first channel with positions; -1 if there is none. */
static int find_positions(const cq_shape *shape)
{
    for (uint32_t k = 0; k < shape->num_channels; k++)
        if (shape->channel[k].kind == CQ_POSITION && shape->channel[k].components == 3)
            return (int)k;
    return -1;
}

static void fill_positions(float *positions, const cq_decoder *d, int channel)
{
    size_t count = d->mesh.num_vertices;
    if (channel < 0)
        memset(positions, 0, 3 * count * sizeof *positions);
    else
        cq_reconstruct(&d->shape.channel[channel], d->channel[channel], count, positions);
}

/* The decoded mesh; its indices are the decoder's own, only the positions are new. */
static int view_mesh(struct mesh_file *mesh, const cq_decoder *d, int channel)
{
    mesh->num_vertices = d->mesh.num_vertices;
    mesh->num_faces = d->mesh.num_faces;
    mesh->indices = d->mesh.origin;
    mesh->positions = malloc(((size_t)mesh->num_vertices + 1) * 3 * sizeof *mesh->positions);
    if (mesh->positions == NULL)
        return 0;
    fill_positions(mesh->positions, d, channel);
    return 1;
}

/* -- The command --------------------------------------------------------------------------------------------------- */

static int save_mesh(const struct mesh_file *mesh, const char *path, enum mesh_format format)
{
    struct output output;
    if (!open_output(&output, path))
        return 0;
    mesh_write(mesh, output.file, format);
    return close_output(&output);
}

/* Without positions STL, which has nothing else, would hold nothing. */
static int check_positions(const struct options *options, int channel, enum mesh_format format)
{
    if (channel >= 0)
        return 1;
    if (format == MESH_STL)
        return complain(options->files[0], "has no positions, which is all that STL holds; use OFF, OBJ or PLY");
    if (!options->quiet)
        complain(options->files[0], "has no positions; all are written as 0 0 0");
    return 1;
}

static int save_decoded(const cq_decoder *d, const struct options *options, enum mesh_format format)
{
    struct mesh_file mesh;
    int channel = find_positions(&d->shape);
    if (!check_positions(options, channel, format))
        return 0;
    if (!view_mesh(&mesh, d, channel))
        return complain(options->files[1], "out of memory");
    int ok = save_mesh(&mesh, options->files[1], format);
    free(mesh.positions);
    return ok;
}

/* A stream may only be short if the user made it so. */
static int check_complete(const struct decoding *d, const struct options *options, cq_result result, size_t size)
{
    if (result != CQ_TRUNCATED || options->max_bytes != CQ_NO_LIMIT)
        return 1;
    return complain(options->files[0], "truncated after %zu of %zu bytes; wrote %lu of %lu vertices", size,
                    d->stream_bytes, (unsigned long)d->decoder.mesh.num_vertices,
                    (unsigned long)d->decoder.shape.num_vertices);
}

static int decode_stream(struct decoding *d, const struct options *options, enum mesh_format format,
                         const uint8_t *data, size_t size)
{
    const char *path = options->files[0];
    cq_bytes in = { data, size < options->max_bytes ? size : options->max_bytes };
    if (!open_decoding(d, path, data, size))
        return 0;
    cq_result result = refine(&d->decoder, &in, options);
    size_t used = (size_t)(in.data - data);
    if (result < 0)
        return complain_stream(path, result, used);
    if (d->decoder.mesh.num_vertices == 0)
        return complain(path, "the bytes end inside the base mesh (byte %zu)", used);
    return save_decoded(&d->decoder, options, format) && check_complete(d, options, result, size);
}

int run_decode(const struct options *options)
{
    static struct decoding d;
    size_t size;
    enum mesh_format format = choose_format(options->files[1], options);
    if (format == MESH_UNKNOWN)
        return EXIT_BAD_USAGE;
    uint8_t *data = load_file(options->files[0], &size);
    if (data == NULL)
        return EXIT_BAD_DATA;
    int ok = decode_stream(&d, options, format, data, size);
    close_decoding(&d);
    free(data);
    return ok ? 0 : EXIT_BAD_DATA;
}
