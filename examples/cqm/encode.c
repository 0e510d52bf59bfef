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
enum { MAX_METADATA_BYTES = 1 << 20 };

/* A channel with room for its values, all 0. NULL if there is no memory. */
static cq_channel *add_channel(struct encoding *e, cq_kind kind, cq_merge merge, int components, uint32_t bits)
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
    float step;
    memcpy(&step, &channel->step, sizeof step);
    if (is_blurred(e, k))
        tell_loss(e, options, path, "changed: %s: a few are far from all others, so that all are rounded to multiples of "
                  "%.3g (%d bits); see --bits %s=N", name, (double)step, channel->bits, channel_name);
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

/* As few bits as may be for numbers up to this one. */
static uint32_t bits_of_number(uint32_t largest)
{
    int bits = bits_for(largest);
    return bits <= CQ_MAX_BITS ? (uint32_t)bits : CQ_EXACT_BITS;
}

/* The faces of each material, and behind them those that have none. */
static int add_materials(struct encoding *e, const struct mesh_file *mesh, const char *path)
{
    const struct mesh_labels *materials = &mesh->label[MESH_MATERIALS];
    if (materials->of_face == NULL)
        return 1;
    e->input.shape.num_materials = materials->count + (uint32_t)has_face_without_material(mesh);
    e->material = malloc(((size_t)mesh->num_faces + 1) * sizeof *e->material);
    e->input.material = e->material;
    for (size_t f = 0; f < mesh->num_faces && e->material != NULL; f++)
        e->material[f] = (materials->of_face[f] > 0 ? materials->of_face[f] : e->input.shape.num_materials) - 1;
    return e->material != NULL || complain(path, "out of memory");
}

static uint32_t face_number(const struct mesh_file *mesh, int kind, size_t face)
{
    return kind == FACE_MISSING ? mesh->missing[face] : mesh->label[kind].of_face[face];
}

/* Groups, objects, and which attributes are missing, where these differ from face to face. */
static int add_face_numbers(struct encoding *e, const struct mesh_file *mesh, const char *path, int kind)
{
    uint32_t k = e->input.shape.num_channels;
    uint32_t largest = kind == FACE_MISSING ? (1u << MESH_NUM_ATTRIBUTES) - 1 : mesh->label[kind].count;
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

/* What faces belong to, with the names. */
static int add_labels(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options)
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
        size = 0;
    }
    e->input.shape.metadata_bytes = (uint32_t)size;
    e->input.metadata = (const uint8_t *)e->words;
    return 1;
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

/* What the reader could not keep; where positions alone are wanted, only what it changed. */
static void tell_notes(struct encoding *e, const struct options *options, const struct mesh_file *mesh,
                       const char *path)
{
    const char *end, *line = mesh->notes;
    for (; line != NULL && (end = strchr(line, '\n')) != NULL; line = end + 1) {
        if (options->attributes == 0 && strncmp(line, "dropped", 7) == 0)
            continue;
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
    tell_notes(e, options, mesh, path);
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

/* For --lock-border: the vertices at edges of the surface that has one face there stay as they are at every level. */
static int lock_border(struct encoding *e, const struct mesh_file *mesh, const char *path)
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
    free(e->locked);
    free(e->material);
    free(e->words);
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
