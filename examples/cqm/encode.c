/* encode.c - mesh file -> stream. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "cqm.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* -- Channels ------------------------------------------------------------------------------------------------------ */

enum { NORMAL_BITS = 10, TEXCOORD_BITS = 12, COLOR_BITS = 8 };

cq_channel *add_channel(struct encoding *e, cq_kind kind, cq_merge merge, int components, uint32_t bits)
{
    uint32_t k = e->input.shape.num_channels++;
    cq_channel *channel = &e->input.shape.channel[k];
    channel->kind = (uint8_t)kind;
    channel->merge = (uint8_t)merge;
    channel->components = (uint8_t)components;
    channel->bits = (uint8_t)bits;
    size_t count = merge == CQ_PER_FACE ? e->input.shape.num_faces : e->input.shape.num_vertices;
    e->values[k] = calloc(count + 1, (size_t)components * sizeof(cq_value));
    e->input.values[k] = e->values[k];
    return e->values[k] != NULL ? channel : NULL;
}

static void find_range(const cq_value *values, size_t count, size_t components, cq_value *low, cq_value *high)
{
    *low = *high = values[0];
    for (size_t i = 0; i < count * components; i += components) {
        *low = values[i] < *low ? values[i] : *low;
        *high = values[i] > *high ? values[i] : *high;
    }
}

/* Are nine tenths of the values within a 32nd of the range? */
static int are_crowded(const cq_value *values, size_t count, size_t components, cq_value low, cq_value high)
{
    enum { PARTS = 64 };
    size_t part[PARTS + 1] = { 0 };
    for (size_t i = 0; i < count * components; i += components)
        part[(int64_t)(values[i] - low) * PARTS / ((int64_t)high - low + 1)]++;
    for (size_t i = 0; i < PARTS; i++)
        if ((part[i] + part[i + 1]) * 10 >= count * 9)
            return 1;
    return 0;
}

/* One point far away makes the step too long for all others: looks in the direction in which the box is longest. */
static int is_blurred(const struct encoding *e, uint32_t k)
{
    enum { FEW_VERTICES = 16, FEW_STEPS = 256 };
    size_t count = e->input.shape.num_vertices, components = e->input.shape.channel[k].components, longest = 0;
    cq_value low, high, range = 0;
    if (count < FEW_VERTICES || e->input.shape.channel[k].bits > CQ_MAX_BITS)
        return 0;
    for (size_t c = 0; c < components; c++) {
        find_range(e->values[k] + c, count, components, &low, &high);
        if (high - low > range) {
            range = high - low;
            longest = c;
        }
    }
    find_range(e->values[k] + longest, count, components, &low, &high);
    return range >= FEW_STEPS && are_crowded(e->values[k] + longest, count, components, low, high);
}

static void tell_blurred(struct encoding *e, const struct options *options, const char *path, const char *name,
                         const char *channel_name)
{
    uint32_t k = e->input.shape.num_channels - 1;
    const cq_channel *channel = &e->input.shape.channel[k];
    if (is_blurred(e, k))
        tell_loss(e, options, path, "changed: %s: a few are far from all others, so that all are rounded to multiples of "
                  "%.3g (%d bits); see --bits %s=N", name, (double)cq_channel_step(channel), channel->bits, channel_name);
}

static int add_position_channel(struct encoding *e, const struct mesh_file *mesh, const char *path,
                                const struct options *options)
{
    cq_channel *channel = add_channel(e, CQ_POSITION, CQ_AVERAGE, 3, options->bits);
    if (channel == NULL)
        return complain(path, "out of memory");
    if (!add_positions(e, channel, mesh, path, options))
        return 0;
    tell_blurred(e, options, path, "positions", "positions");
    return 1;
}

static uint32_t bits_of(const struct options *options, enum mesh_attribute a)
{
    static const uint32_t usual[MESH_NUM_ATTRIBUTES] = { NORMAL_BITS, TEXCOORD_BITS, COLOR_BITS };
    return options->attribute_bits[a] != 0 ? options->attribute_bits[a] : usual[a];
}

/* Normals without a length have no direction to keep. */
static void point_upwards(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options)
{
    float *normal = mesh->attribute[MESH_NORMALS].values;
    size_t changed = 0;
    for (size_t v = 0; v < mesh->num_vertices; v++, normal += 3)
        if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) {
            normal[2] = 1;
            changed++;
        }
    if (changed > 0)
        tell_loss(e, options, path, "changed: normals without a length (%zu) became 0 0 1", changed);
}

static int add_normals(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options)
{
    uint32_t k = e->input.shape.num_channels, bits = bits_of(options, MESH_NORMALS);
    if (add_channel(e, CQ_NORMAL, CQ_AVERAGE, 2, bits) == NULL)
        return complain(path, "out of memory");
    point_upwards(e, mesh, path, options);
    return cq_quantise_normals((int)bits, mesh->attribute[MESH_NORMALS].values, mesh->num_vertices, e->values[k],
                               NULL) == CQ_OK
           || complain(path, "normals that cannot be rounded");
}

/* Far from 0 a step of the grid is longer than asked for, as floats are there; those near 0 suffer from it. */
static void tell_coarse(struct encoding *e, const struct options *options, const char *path, const float *from)
{
    const uint32_t k = e->input.shape.num_channels - 1;
    const cq_channel *channel = &e->input.shape.channel[k];
    double side = 0, distance = 0;
    const float step = cq_channel_step(channel);
    for (size_t c = 0; c < channel->components; c++) {
        double low = 0, high = 0;
        const float origin = cq_channel_origin(channel, (int)c);
        for (size_t i = c; i < (size_t)channel->components * e->input.shape.num_vertices; i += channel->components) {
            low = i == c ? (double)from[i] : fmin(low, (double)from[i]);
            high = i == c ? (double)from[i] : fmax(high, (double)from[i]);
            distance = fmax(distance, fabs((double)from[i] - ((double)origin + (double)step * e->values[k][i])));
        }
        side = fmax(side, high - low);
    }
    double wanted = side / (double)((1u << channel->bits) - 1);
    if ((double)step > 1.5 * wanted && distance > 0.53 * wanted)
        tell_loss(e, options, path, "changed: texture coordinates: the step of the grid is %.3g instead of %.3g, as they are "
                  "so far from 0", (double)step, wanted);
}

static int add_texcoords(struct encoding *e, struct mesh_file *mesh, const char *path,
                         const struct options *options)
{
    const float *from = mesh->attribute[MESH_TEXCOORDS].values;
    uint32_t k = e->input.shape.num_channels, bits = bits_of(options, MESH_TEXCOORDS);
    cq_channel *channel = add_channel(e, CQ_TEXCOORD, CQ_AVERAGE, 2, bits);
    if (channel == NULL)
        return complain(path, "out of memory");
    if (cq_fit_grid(channel, from, mesh->num_vertices, NULL) != CQ_OK
            || cq_quantise(channel, from, mesh->num_vertices, e->values[k], NULL) != CQ_OK)
        return complain(path, "texture coordinates too large for %lu bits", (unsigned long)bits);
    tell_coarse(e, options, path, from);
    tell_blurred(e, options, path, mesh_attribute_name(MESH_TEXCOORDS), "texcoords");
    return 1;
}

/* The grid is the one of integers with as many bits, so that those come back as they are. */
static int add_colors(struct encoding *e, struct mesh_file *mesh, const char *path,
                      const struct options *options)
{
    uint32_t bits = bits_of(options, MESH_COLORS);
    const float step = 1.0f / (float)((1u << bits) - 1);
    uint32_t k = e->input.shape.num_channels;
    cq_channel *channel = add_channel(e, CQ_COLOR, CQ_AVERAGE, mesh->attribute[MESH_COLORS].components, bits);
    if (channel == NULL)
        return complain(path, "out of memory");
    memcpy(&channel->step, &step, sizeof step);
    return cq_quantise(channel, mesh->attribute[MESH_COLORS].values, mesh->num_vertices, e->values[k], NULL) == CQ_OK
        || complain(path, "a color outside 0 .. 1");
}

static int bits_for(uint32_t largest)
{
    int bits = 1;
    while (bits < 32 && largest >> bits != 0)
        bits++;
    return bits;
}

uint32_t bits_of_number(uint32_t largest)
{
    int bits = bits_for(largest);
    return bits <= CQ_MAX_BITS ? (uint32_t)bits : CQ_EXACT_BITS;
}

/* Vertices have the numbers that the file gave them. */
static int add_order(struct encoding *e, const struct mesh_file *mesh, const char *path)
{
    uint32_t k = e->input.shape.num_channels, n = mesh->num_vertices;
    if (add_channel(e, CQ_NUMBER, CQ_COPY, 1, bits_of_number(n)) == NULL)
        return complain(path, "out of memory");
    for (uint32_t v = 0; v < n; v++)
        e->values[k][v] = (cq_value)(mesh->number != NULL ? mesh->number[v] : v);
    return 1;
}

static int add_attribute(struct encoding *e, struct mesh_file *mesh, const char *path,
                         const struct options *options, enum mesh_attribute a)
{
    switch (a) {
    case MESH_NORMALS: return add_normals(e, mesh, path, options);
    case MESH_TEXCOORDS: return add_texcoords(e, mesh, path, options);
    default: return add_colors(e, mesh, path, options);
    }
}

void tell_loss(struct encoding *e, const struct options *options, const char *path, const char *format, ...)
{
    char text[2 * MESH_ERROR_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    e->losses++;
    if (!options->quiet)
        complain(path, "%s", text);
}

/* What the reader could not keep. */
static void tell_notes(struct encoding *e, const struct options *options, const char *line, const char *path)
{
    for (const char *end; line != NULL && (end = strchr(line, '\n')) != NULL; line = end + 1) {
        e->losses++;
        if (!options->quiet)
            complain(path, "%.*s", (int)(end - line), line);
    }
}

static int add_channels(struct encoding *e, struct mesh_file *mesh, const char *path,
                        const struct options *options)
{
    if (!options->connectivity && !add_position_channel(e, mesh, path, options))
        return 0;
    if (options->connectivity && options->attributes != 0)
        tell_loss(e, options, path, "dropped: positions, which --channels does not list");
    for (int a = 0; a < MESH_NUM_ATTRIBUTES; a++)
        if ((options->attributes >> a & 1) != 0 && mesh->attribute[a].values != NULL
                && !add_attribute(e, mesh, path, options, (enum mesh_attribute)a))
            return 0;
    tell_notes(e, options, mesh->notes, path);
    tell_notes(e, options, options->attributes != 0 ? mesh->attribute_notes : NULL, path);
    return add_labels(e, mesh, path, options) && (!options->keep_order || add_order(e, mesh, path));
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
    if (result == CQ_ERROR_VALUE)
        return complain(path, "vertex %lu has a value that no channel holds", (unsigned long)at->vertex);
    return complain(path, "%s", cq_result_string(result));
}

/* One try with as much memory as the shape is known to need, and some more: mostly enough for its boundaries. */
static cq_result encode_once(struct encoding *e, size_t capacity, cq_place *place)
{
    size_t memory_size = cq_encoder_bytes(&e->input.shape);
    if (memory_size == 0 || memory_size > SIZE_MAX - memory_size / 8)
        return CQ_ERROR_TOO_LARGE;
    memory_size += memory_size / 8;
    void *memory = malloc(memory_size);
    free(e->stream);
    e->stream = malloc(capacity);
    cq_result result = CQ_ERROR_MEMORY;
    if (memory != NULL && e->stream != NULL)
        result = cq_encode(&e->input, memory, memory_size, e->stream, capacity, &e->size, place, &e->report);
    free(memory);
    return result;
}

/* What the mesh needs is found step by step: boundaries, rows, the size of the stream. */
static cq_result encode_with_retries(struct encoding *e, cq_place *place)
{
    enum { MAX_TRIES = 6 };
    size_t capacity = 4096 + 16 * (size_t)e->input.shape.num_vertices + e->input.shape.metadata_bytes;
    cq_result result = CQ_ERROR_MEMORY;
    for (int i = 0; i < MAX_TRIES && (result == CQ_ERROR_MEMORY || result == CQ_ERROR_OUTPUT); i++) {
        result = encode_once(e, capacity, place);
        capacity = result == CQ_ERROR_OUTPUT ? e->size : capacity;
    }
    return result;
}

/* -- What the encoder had to do ------------------------------------------------------------------------------------ */

struct count {
    uint32_t number;
    const char *one, *many;
};

/* Adds those that are not 0 to the text. */
static void list_counts(char *text, size_t size, const char *title, const struct count *counts, int n)
{
    int listed = 0;
    for (int i = 0; i < n; i++) {
        size_t used = strlen(text);
        if (counts[i].number > 0)
            snprintf(text + used, size - used, "%s%lu %s", listed++ > 0 ? ", " : title, (unsigned long)counts[i].number,
                     counts[i].number == 1 ? counts[i].one : counts[i].many);
    }
}

/* One line, if there is something to tell: nothing of it is lost. */
static void tell_preparation(const struct encoding *e, const char *path, const struct options *options)
{
    const cq_preparation *p = &e->report.prepared;
    const struct count aside[] = {
        { p->degenerate_faces, "face without area", "faces without area" },
        { p->repeated_faces, "repeated face", "repeated faces" },
        { p->unused_rows, "unused vertex", "unused vertices" },
    };
    const struct count cut[] = {
        { p->cut_edges, "edge cut", "edges cut" },
        { p->detached_faces, "face cut off", "faces cut off" },
        { p->copied_rows, "vertex copied", "vertices copied" },
        { p->turned_faces, "face turned over", "faces turned over" },
    };
    char text[512] = "";
    list_counts(text, sizeof text, "set aside: ", aside, 3);
    list_counts(text, sizeof text, text[0] != '\0' ? "; " : "", cut, 4);
    if (text[0] != '\0' && !options->quiet)
        complain(path, "%s; decoding gives all of it back", text);
}

/* -- All of it ----------------------------------------------------------------------------------------------------- */

static int prepare_input(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options)
{
    memset(e, 0, sizeof *e);
    if (!mesh_expand(mesh, (unsigned)options->attributes & (KEEP_MATERIALS - 1)))
        return complain(path, "out of memory");
    e->input.shape.num_vertices = mesh->num_vertices;
    e->input.shape.num_faces = mesh->num_faces;
    e->input.indices = mesh->indices;
    e->positions = mesh->positions;
    e->input.goal = options->goal;
    e->input.clean = options->clean;
    e->input.conquest_only = options->conquest_only;
    e->input.map = malloc(((size_t)mesh->num_vertices + 1) * sizeof *e->input.map);
    e->input.face_map = malloc(((size_t)mesh->num_faces + 1) * sizeof *e->input.face_map);
    if (e->input.map == NULL || e->input.face_map == NULL)
        return complain(path, "out of memory");
    return add_channels(e, mesh, path, options) && (!options->lock_border || lock_border(e, mesh, path));
}

int encode_mesh(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options)
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
    if (result != CQ_OK)
        return complain_mesh(path, result, &place);
    tell_preparation(e, path, options);
    if (options->strict && e->losses > 0)
        return complain(path, "refused, for --strict: part of the file would be dropped or changed");
    return 1;
}

void free_encoding(struct encoding *e)
{
    for (int k = 0; k < CQ_MAX_CHANNELS; k++)
        free(e->values[k]);
    free(e->input.map);
    free(e->input.face_map);
    free(e->materials);
    free(e->locked);
    free(e->words);
    free(e->stream);
}

static int save_stream(const char *path, const uint8_t *data, size_t size)
{
    struct output output;
    if (!open_output(&output, path))
        return 0;
    fwrite(data, 1, size, output.file);
    return close_output(&output, 1);
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
