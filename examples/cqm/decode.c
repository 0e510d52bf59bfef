/* decode.c - stream -> mesh file. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <math.h>
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
        return complain(path, "%zu bytes follow the end of the stream (byte %zu)", size - *stream_bytes, *stream_bytes);
    return 1;
}

int open_decoding(struct decoding *d, const char *path, const uint8_t *data, size_t size)
{
    d->memory = NULL;
    if (!check_header(path, data, size, &d->shape, &d->stream_bytes))
        return 0;
    size_t memory_size = cq_decoder_bytes(&d->shape);
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

/* As the codec chooses it: cq_kind and cq_merge tell. */
const cq_channel *find_measured(const cq_shape *shape)
{
    for (uint32_t k = 0; k < shape->num_channels; k++) {
        const cq_channel *c = &shape->channel[k];
        if (c->kind == CQ_POSITION && c->merge == CQ_AVERAGE && c->bits != CQ_EXACT_BITS)
            return c;
    }
    return NULL;
}

/* The decoder knows the error of the mesh from the beginning of the next level on. */
static int is_near_enough(const cq_decoder *d, const struct options *options)
{
    if (options->max_error < 0 || d->level == 0)
        return 0;
    return d->error / 16.0 * fabs((double)cq_channel_step(find_measured(&d->shape))) <= options->max_error;
}

static int is_fine_enough(const cq_decoder *d, const struct options *options)
{
    uint32_t vertices = d->mesh.num_vertices;
    return d->level > 0 && (vertices >= options->max_vertices || d->level > options->max_levels
                            || is_near_enough(d, options));
}

/* A step makes at most one vertex, so that many steps cannot pass the limit. Steps one by one stop between the levels
 * and at the base. */
static uint32_t step_budget(const cq_decoder *d, const struct options *options)
{
    if (options->max_levels != CQ_NO_LIMIT || options->max_error >= 0 || d->level == 0)
        return 1;
    return options->max_vertices - d->mesh.num_vertices;
}

/* CQ_MORE: a limit is reached. CQ_DONE, CQ_TRUNCATED or an error as cq_decode has it. */
static cq_result refine(cq_decoder *d, cq_bytes *in, const struct options *options)
{
    cq_result result = CQ_MORE;
    while (result == CQ_MORE && !is_fine_enough(d, options)) {
        result = cq_decode(d, in, step_budget(d, options));
        if (result == CQ_NEED_INPUT)
            result = cq_decode(d, NULL, step_budget(d, options));
    }
    return result;
}

/* -- The command --------------------------------------------------------------------------------------------------- */

static int save_mesh(struct mesh_file *mesh, const char *path, enum mesh_format format)
{
    struct output output;
    if (!open_output(&output, path))
        return 0;
    int is_good = mesh_write(mesh, output.file, format) || ferror(output.file) || complain(path, "out of memory");
    return close_output(&output, is_good);
}

/* Is channel k written to the file? Those of faces that are labels are told as such. */
static int is_written(const cq_shape *shape, uint32_t k, enum mesh_format format)
{
    const cq_channel *c = &shape->channel[k];
    int attributes = format == MESH_OBJ || format == MESH_PLY;
    if (c->merge == CQ_PER_FACE)
        return c->kind == CQ_TURNED || c->kind == CQ_GENERIC || find_channel(shape, CQ_GROUP, 1) == (int)k;
    if (find_channel(shape, (cq_kind)c->kind, 0) != (int)k)
        return 0;
    switch (c->kind) {
    case CQ_POSITION: return 1;
    case CQ_NUMBER: return format != MESH_STL;
    case CQ_NORMAL: case CQ_TEXCOORD: return attributes;
    case CQ_COLOR: return format == MESH_PLY || (format == MESH_OBJ && c->components == 3);
    default: return 0;
    }
}

/* The same for 32-bit floats, which is what STL has: how far do they move a coordinate at most? */
static double float_distance(const struct mesh_file *mesh)
{
    double distance = 0;
    for (size_t i = 0; i < 3 * (size_t)mesh->num_vertices; i++)
        distance = fmax(distance, fabs(mesh->positions[i] - (double)(float)mesh->positions[i]));
    return distance;
}

/* PLY has normals of vertices alone, and then texture coordinates, too: no face can be without. */
static int has_faces_without(const struct mesh_file *mesh)
{
    int lost = 1 << MESH_NORMALS;
    if (mesh->attribute[MESH_NORMALS].corner != NULL || mesh->attribute[MESH_COLORS].corner != NULL)
        lost |= 1 << MESH_TEXCOORDS;
    for (size_t f = 0; f < mesh->num_faces && mesh->marks != NULL; f++)
        if ((mesh->marks[f] & lost) != 0)
            return 1;
    return 0;
}

/* Materials, groups, objects. */
static int tell_labels_not_written(const struct mesh_file *mesh, const char *path, enum mesh_format format, int quiet)
{
    static const char *const names[MESH_NUM_LABELS] = { "materials", "groups", "objects" };
    int losses = 0;
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        if (mesh->label[k].of_face != NULL && format != MESH_OBJ && (format != MESH_PLY || k != MESH_MATERIALS)
                && ++losses > 0 && !quiet)
            complain(path, "dropped: %s of the stream, which this format does not have", names[k]);
    if (mesh->libraries != NULL && format != MESH_OBJ && ++losses > 0 && !quiet)
        complain(path, "dropped: names of material libraries");
    if (format == MESH_PLY && has_faces_without(mesh) && ++losses > 0 && !quiet)
        complain(path, "changed: faces without normals or texture coordinates get some, as PLY needs them");
    return losses;
}

struct stl_losses {
    size_t unused, merged, lines;      /* vertices of no face, vertices at the place of others, lines and points */
};

static int count_stl_losses(const struct mesh_file *mesh, struct stl_losses *losses)
{
    uint32_t *first = mesh_first_equal(mesh->positions, mesh->num_vertices, 3 * sizeof *mesh->positions);
    uint8_t *used = calloc((size_t)mesh->num_vertices + 1, 1);
    int ok = first != NULL && used != NULL;
    for (size_t c = 0; c < 3 * (size_t)mesh->num_faces && ok; c++)
        used[mesh->indices[c]] = 1;
    for (size_t v = 0; v < mesh->num_vertices && ok; v++) {
        losses->unused += used[v] == 0;
        losses->merged += used[v] != 0 && used[first[v]] != 0 && first[v] != v;
    }
    for (size_t f = 0; f < mesh->num_faces && mesh->marks != NULL; f++)
        losses->lines += (mesh->marks[f] & (MESH_LINE | MESH_POINT)) != 0;
    free(first);
    free(used);
    return ok;
}

/* STL is triangles of points. Returns how many things are lost, -1: no memory. */
static int tell_stl_losses(const struct mesh_file *mesh, const char *path, int quiet)
{
    struct stl_losses losses = { 0 };
    double distance = float_distance(mesh);
    if (!count_stl_losses(mesh, &losses))
        return -1;
    if (distance > 0 && !quiet)
        complain(path, "changed: positions: STL has 32-bit floats, which move them by up to %.3g", distance);
    if (losses.unused > 0 && !quiet)
        complain(path, "dropped: vertices of no face (%zu), which STL does not have", losses.unused);
    if (losses.merged > 0 && !quiet)
        complain(path, "changed: vertices at the place of others (%zu) become one with them, as STL has places alone",
                 losses.merged);
    if (losses.lines > 0 && !quiet)
        complain(path, "changed: lines and points (%zu) become triangles without area", losses.lines);
    return (distance > 0) + (losses.unused > 0) + (losses.merged > 0) + (losses.lines > 0);
}

/* Says what the file does not hold of the stream. Returns how many things these are, -1: no memory. */
static int tell_not_written(const cq_shape *shape, const struct mesh_file *mesh, const char *path,
                            enum mesh_format format, int quiet)
{
    int losses = tell_labels_not_written(mesh, path, format, quiet);
    for (uint32_t k = 0; k < shape->num_channels; k++)
        if (!is_written(shape, k, format) && ++losses > 0 && !quiet)
            complain(path, "dropped: %s%s of the stream, which this format or this program does not write",
                     channel_kind_name(&shape->channel[k]),
                     shape->channel[k].kind == CQ_COLOR && format == MESH_OBJ ? "'s alpha" : "");
    int colors = find_channel(shape, CQ_COLOR, 0), bits = colors >= 0 ? shape->channel[colors].bits : 0;
    if (format == MESH_PLY && bits > 8 && ++losses > 0 && !quiet)
        complain(path, "changed: colors: PLY gets 8 of their %d bits", bits);
    int of_stl = format == MESH_STL ? tell_stl_losses(mesh, path, quiet) : 0;
    return of_stl < 0 ? -1 : losses + of_stl;
}

/* Without positions STL, which has nothing else, would hold nothing. */
static int check_positions(const struct options *options, const cq_shape *shape, enum mesh_format format)
{
    if (find_channel(shape, CQ_POSITION, 0) >= 0 || shape->num_vertices == 0)
        return 1;
    if (format == MESH_STL)
        return complain(options->files[0], "has no positions, which is all that STL holds; use OFF, OBJ or PLY");
    if (!options->quiet)
        complain(options->files[0], "has no positions; all are written as 0 0 0");
    return 1;
}

static int save_decoded(const cq_decoder *d, const struct options *options, enum mesh_format format, int is_complete)
{
    const char *path = options->files[1];
    struct mesh_file mesh;
    if (!check_positions(options, &d->shape, format))
        return 0;
    int ok = view_mesh(&mesh, d, is_complete) || complain(path, "out of memory");
    int losses = ok ? tell_not_written(&d->shape, &mesh, path, format, options->quiet) : 0;
    if (losses < 0)
        ok = complain(path, "out of memory");
    if (losses > 0 && options->strict)
        ok = complain(path, "not written, for --strict: part of the stream would be dropped or changed");
    ok = ok && save_mesh(&mesh, path, format);
    mesh_free(&mesh);
    return ok;
}

/* Only the positions of a grid have errors. */
static int check_error(const struct options *options, const cq_shape *shape)
{
    if (options->max_error < 0 || find_measured(shape) != NULL || shape->num_vertices == 0)
        return 1;
    return complain(options->files[0], "--error: this stream does not tell how far its meshes are from the exact one, "
                    "as it has no positions on a grid");
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
    if (!open_decoding(d, path, data, size) || !check_error(options, &d->shape))
        return 0;
    cq_result result = refine(&d->decoder, &in, options);
    size_t used = (size_t)(in.data - data);
    if (result < 0)
        return complain_stream(path, result, used);
    if (d->decoder.mesh.num_vertices == 0 && result != CQ_DONE)
        return complain(path, "the bytes end inside the base mesh (byte %zu)", used);
    return save_decoded(&d->decoder, options, format, result == CQ_DONE) && check_complete(d, options, result, size);
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
