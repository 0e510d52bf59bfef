/* verify.c - encode, decode, compare. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- Comparing: the decoded mesh has its own order of vertices and faces ------------------------------------------- */

static int compare_triangles(const void *a, const void *b)
{
    const cq_index *s = a, *t = b;
    for (int i = 0; i < 3; i++)
        if (s[i] != t[i])
            return s[i] < t[i] ? -1 : 1;
    return 0;
}

/* All triangles in an order that depends on the set alone: each starts at its smallest vertex and keeps its direction.
 * map: new number of each vertex, or NULL. */
static cq_index *sorted_triangles(const cq_index *indices, size_t num_faces, const cq_index *map)
{
    cq_index *sorted = malloc((num_faces + 1) * 3 * sizeof *sorted);
    if (sorted == NULL)
        return NULL;
    for (size_t f = 0; f < num_faces; f++) {
        cq_index t[3];
        size_t first = 0;
        for (size_t i = 0; i < 3; i++) {
            t[i] = map != NULL ? map[indices[3 * f + i]] : indices[3 * f + i];
            first = t[i] < t[first] ? i : first;
        }
        for (size_t i = 0; i < 3; i++)
            sorted[3 * f + i] = t[(first + i) % 3];
    }
    qsort(sorted, num_faces, 3 * sizeof *sorted, compare_triangles);
    return sorted;
}

static int same_faces(const struct encoding *e, const cq_decoder *d)
{
    size_t num_faces = e->input.shape.num_faces;
    if (d->mesh.num_faces != num_faces)
        return 0;
    cq_index *sent = sorted_triangles(e->input.indices, num_faces, e->input.map);
    cq_index *received = sorted_triangles(d->mesh.origin, num_faces, NULL);
    int same = sent != NULL && received != NULL && memcmp(sent, received, num_faces * 3 * sizeof *sent) == 0;
    free(sent);
    free(received);
    return same;
}

/* 1 if the map takes each of so many input vertices or faces to a decoded one of its own. */
static int is_permutation(const cq_index *map, size_t count)
{
    uint8_t *taken = calloc(count + 1, 1);
    int ok = taken != NULL;
    for (size_t i = 0; ok && i < count; i++)
        ok = map[i] < count && !taken[map[i]] && (taken[map[i]] = 1);
    free(taken);
    return ok;
}

static int same_channel(const struct encoding *e, const cq_decoder *d, uint32_t k)
{
    const cq_channel *channel = &e->input.shape.channel[k];
    int per_face = channel->merge == CQ_PER_FACE;
    const cq_index *map = per_face ? e->input.face_map : e->input.map;
    size_t n = channel->components, count = per_face ? e->input.shape.num_faces : e->input.shape.num_vertices;
    for (size_t i = 0; i < count; i++)
        if (memcmp(&e->values[k][n * i], &d->channel[k][n * map[i]], n * sizeof(cq_value)) != 0)
            return 0;
    return 1;
}

static int same_values(const struct encoding *e, const cq_decoder *d)
{
    int same = d->shape.num_channels == e->input.shape.num_channels;
    for (uint32_t k = 0; same && k < d->shape.num_channels; k++)
        same = memcmp(&d->shape.channel[k], &e->input.shape.channel[k], sizeof d->shape.channel[k]) == 0
               && same_channel(e, d, k);
    return same;
}

/* Half a step, or in exact streams what a float is away, and where floats are used, their rounding. */
static double tolerance(const cq_channel *channel, double x)
{
    float step;
    memcpy(&step, &channel->step, sizeof step);
    return fabs(x) * 0x1p-23 + (channel->bits == CQ_EXACT_BITS ? 0 : 0.501 * (double)step);
}

/* Are the positions that a user gets those of the file? */
static int near_positions(const struct encoding *e, const cq_decoder *d)
{
    const cq_channel *channel = &d->shape.channel[0];
    if (d->shape.num_channels == 0 || channel->kind != CQ_POSITION)
        return 1;
    double *positions = reconstruct_positions(channel, d->channel[0], d->mesh.num_vertices);
    int near = positions != NULL;
    for (size_t i = 0; near && i < 3 * (size_t)d->mesh.num_vertices; i++) {
        double x = e->positions[i], found = positions[3 * (size_t)e->input.map[i / 3] + i % 3];
        near = fabs(found - x) <= tolerance(channel, x);
    }
    free(positions);
    return near;
}

/* NULL if the decoded mesh is the input; else what differs. */
static const char *find_difference(const struct encoding *e, const cq_decoder *d)
{
    if (d->mesh.num_vertices != e->input.shape.num_vertices)
        return "the number of vertices differs";
    if (!is_permutation(e->input.map, e->input.shape.num_vertices))
        return "the vertex map is no permutation";
    if (!is_permutation(e->input.face_map, e->input.shape.num_faces))
        return "the face map is no permutation";
    if (!same_values(e, d))
        return "the values differ";
    if (!near_positions(e, d))
        return "the positions differ";
    if (!same_faces(e, d))
        return "the faces differ";
    if (cq_mesh_check(&d->mesh, NULL) != CQ_OK)
        return "the decoded mesh is not valid";
    return NULL;
}

/* -- Decoding in pieces -------------------------------------------------------------------------------------------- */

/* Feeds the stream in pieces of `chunk` bytes and lets the decoder take `budget` steps at a time. */
static cq_result decode_in_pieces(cq_decoder *d, const uint8_t *data, size_t size, size_t chunk, uint32_t budget)
{
    cq_result result = CQ_NEED_INPUT;
    for (size_t at = 0; at < size && result == CQ_NEED_INPUT; at += chunk) {
        cq_bytes in = { data + at, size - at < chunk ? size - at : chunk };
        do
            result = cq_decode(d, &in, budget);
        while (result == CQ_OK);
        if (result == CQ_DONE && at + chunk < size)
            return CQ_ERROR_CORRUPT;      /* done before the end */
    }
    return result;
}

static int verify_pieces(const struct encoding *e, const char *path, size_t chunk, uint32_t budget)
{
    static struct decoding d;
    const char *difference = NULL;
    int ok = open_decoding(&d, path, e->stream, e->size);
    if (ok) {
        cq_result result = decode_in_pieces(&d.decoder, e->stream, e->size, chunk, budget);
        difference = result == CQ_DONE ? find_difference(e, &d.decoder) : cq_result_string(result);
    }
    close_decoding(&d);
    if (difference != NULL)
        return complain(path, "%s, decoded in pieces of %zu bytes and %lu steps", difference, chunk,
                        (unsigned long)budget);
    return ok;
}

static int verify_encoding(const struct encoding *e, const char *path)
{
    return verify_pieces(e, path, e->size, CQ_NO_LIMIT) && verify_pieces(e, path, 1, CQ_NO_LIMIT)
           && verify_pieces(e, path, 7, 5) && verify_pieces(e, path, 4099, 1);
}

/* -- The command --------------------------------------------------------------------------------------------------- */

static void print_result(const struct encoding *e, const char *path)
{
    const cq_shape *shape = &e->input.shape;
    double bits = shape->num_vertices > 0 ? 8 * (double)e->size / shape->num_vertices : 0;
    printf("%s: ok, %lu vertices, %lu faces, %zu bytes, %.3f bits per vertex\n", path,
           (unsigned long)shape->num_vertices, (unsigned long)shape->num_faces, e->size, bits);
    fflush(stdout);          /* in step with the complaints about other files */
}

static int verify_file(const char *path, enum mesh_format format, const struct options *options)
{
    static struct encoding e;
    struct mesh_file mesh;
    if (!load_mesh(&mesh, path, format))
        return 0;
    int ok = encode_mesh(&e, &mesh, path, options) && verify_encoding(&e, path);
    if (ok)
        print_result(&e, path);
    free_encoding(&e);
    mesh_free(&mesh);
    return ok;
}

int run_verify(const struct options *options)
{
    int ok = 1;
    for (int i = 0; i < options->num_files; i++) {
        enum mesh_format format = choose_format(options->files[i], options);
        if (format == MESH_UNKNOWN)
            return EXIT_BAD_USAGE;
        ok = verify_file(options->files[i], format, options) && ok;
    }
    if (ferror(stdout))
        ok = complain("-", "cannot write");
    return ok ? 0 : EXIT_BAD_DATA;
}
