/* verify.c - encode, decode, compare. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- Comparing: the decoded mesh has its own order of rows and faces, and some rows more or fewer ------------------ */

/* All that a mesh is: what a corner has of all channels is a row, and a face has three of them, and numbers. */
struct content {
    size_t rows, faces;
    cq_value *row;                     /* cq_value[rows][words of a row] */
    cq_value *number;                  /* cq_value[faces][words of a face] */
    cq_index *index;                   /* cq_index[3 * faces] */
};

struct comparison {
    const cq_shape *shape;             /* of the input */
    struct content sent, received;
    size_t row_words, face_words;
    uint32_t *row, *face;              /* of both meshes, those sent first: the first row and numbers that are equal */
};

static int is_of_face(const cq_channel *channel)
{
    return channel->merge == CQ_PER_FACE;
}

static void count_words(struct comparison *c)
{
    c->row_words = c->face_words = 1;            /* so that there is something to compare; of faces the material */
    for (uint32_t k = 0; k < c->shape->num_channels; k++)
        *(is_of_face(&c->shape->channel[k]) ? &c->face_words : &c->row_words) += c->shape->channel[k].components;
}

static int allocate_content(const struct comparison *c, struct content *m, size_t rows, size_t faces)
{
    m->rows = rows;
    m->faces = faces;
    m->row = calloc((rows + 1) * c->row_words, sizeof *m->row);
    m->number = calloc((faces + 1) * c->face_words, sizeof *m->number);
    return m->row != NULL && m->number != NULL;
}

/* Copies so many columns to place `at` of rows of `words`. */
static void put_columns(cq_value *to, size_t words, size_t at, const cq_value *from, size_t columns, size_t rows)
{
    for (size_t i = 0; i < rows; i++)
        memcpy(to + words * i + at, from + columns * i, columns * sizeof *to);
}

static int take_sent(struct comparison *c, const struct encoding *e)
{
    struct content *m = &c->sent;
    size_t row_at = 1, face_at = 1, faces = e->input.shape.num_faces;
    if (!allocate_content(c, m, e->input.shape.num_vertices, faces))
        return 0;
    for (uint32_t k = 0; k < c->shape->num_channels; k++) {
        size_t n = c->shape->channel[k].components;
        if (is_of_face(&c->shape->channel[k]))
            put_columns(m->number, c->face_words, face_at++, e->values[k], 1, faces);
        else
            put_columns(m->row, c->row_words, row_at, e->values[k], n, m->rows);
        row_at += is_of_face(&c->shape->channel[k]) ? 0 : n;
    }
    for (size_t f = 0; f < faces && e->materials != NULL; f++)
        m->number[c->face_words * f] = c->shape->num_materials > 1 ? (cq_value)e->materials[f] : 0;
    m->index = malloc((3 * faces + 1) * sizeof *m->index);
    if (m->index != NULL)
        memcpy(m->index, e->input.indices, 3 * faces * sizeof *m->index);
    return m->index != NULL;
}

static int take_rows(const struct comparison *c, struct content *m, const cq_decoder *d, uint32_t k, size_t at)
{
    cq_value *values = read_rows(d, k);
    if (values != NULL)
        put_columns(m->row, c->row_words, at, values, c->shape->channel[k].components, m->rows);
    free(values);
    return values != NULL;
}

static int take_received(struct comparison *c, const cq_decoder *d)
{
    struct content *m = &c->received;
    size_t row_at = 1, face_at = 1;
    int ok = allocate_content(c, m, count_rows(d), count_faces(d));
    for (uint32_t k = 0; k < c->shape->num_channels && ok; k++) {
        if (!is_of_face(&c->shape->channel[k])) {
            ok = take_rows(c, m, d, k, row_at);
            row_at += c->shape->channel[k].components;
            continue;
        }
        for (uint32_t f = 0; f < m->faces; f++)
            m->number[c->face_words * f + face_at] = face_value(d, k, f);
        face_at++;
    }
    for (uint32_t f = 0; f < m->faces && ok; f++)
        m->number[c->face_words * f] = (cq_value)face_material(d, f);
    return ok && (m->index = read_triangles(d)) != NULL;
}

/* The first equal row for each of both tables. NULL: no memory. */
static uint32_t *match(const cq_value *a, size_t a_rows, const cq_value *b, size_t b_rows, size_t words)
{
    cq_value *both = malloc((a_rows + b_rows + 1) * words * sizeof *both);
    uint32_t *first = NULL;
    if (both != NULL) {
        memcpy(both, a, a_rows * words * sizeof *both);
        memcpy(both + a_rows * words, b, b_rows * words * sizeof *both);
        first = mesh_first_equal(both, a_rows + b_rows, words * sizeof *both);
    }
    free(both);
    return first;
}

static int match_contents(struct comparison *c)
{
    const struct content *s = &c->sent, *r = &c->received;
    c->row = match(s->row, s->rows, r->row, r->rows, c->row_words);
    c->face = match(s->number, s->faces, r->number, r->faces, c->face_words);
    return c->row != NULL && c->face != NULL;
}

enum { KEY_WORDS = 4 };

static int compare_keys(const void *a, const void *b)
{
    const uint32_t *s = a, *t = b;
    for (int i = 0; i < KEY_WORDS; i++)
        if (s[i] != t[i])
            return s[i] < t[i] ? -1 : 1;
    return 0;
}

/* Three rows and numbers, from the corner on that gives the smallest key. */
static void make_key(const uint32_t *row, const cq_index *index, uint32_t face, uint32_t key[KEY_WORDS])
{
    uint32_t turned[KEY_WORDS];
    for (size_t first = 0; first < 3; first++) {
        for (size_t i = 0; i < 3; i++)
            turned[i] = row[index[(first + i) % 3]];
        turned[3] = face;
        if (first == 0 || compare_keys(turned, key) < 0)
            memcpy(key, turned, sizeof turned);
    }
}

/* uint32_t[faces][KEY_WORDS]. NULL: no memory. */
static uint32_t *make_keys(const struct content *m, const uint32_t *row, const uint32_t *face)
{
    uint32_t *keys = malloc((m->faces + 1) * KEY_WORDS * sizeof *keys);
    for (size_t f = 0; f < m->faces && keys != NULL; f++)
        make_key(row, &m->index[3 * f], face[f], keys + KEY_WORDS * f);
    return keys;
}

static int same_keys(const uint32_t *a, const uint32_t *b, size_t count)
{
    return memcmp(a, b, count * KEY_WORDS * sizeof *a) == 0;
}

/* As often as each face was sent, it comes back; and where the face map says. */
static const char *compare_faces(const struct comparison *c, const struct encoding *e)
{
    const struct content *s = &c->sent, *r = &c->received;
    uint32_t *sent = make_keys(s, c->row, c->face), *received = make_keys(r, c->row + s->rows, c->face + s->faces);
    const char *difference = sent == NULL || received == NULL ? "there is no memory to compare" : NULL;
    for (size_t f = 0; f < s->faces && difference == NULL; f++)
        if (e->input.face_map[f] >= r->faces
                || !same_keys(sent + KEY_WORDS * f, received + KEY_WORDS * (size_t)e->input.face_map[f], 1))
            difference = "the face map leads to another face";
    if (difference == NULL) {
        qsort(sent, s->faces, KEY_WORDS * sizeof *sent, compare_keys);
        qsort(received, r->faces, KEY_WORDS * sizeof *received, compare_keys);
        difference = same_keys(sent, received, s->faces) ? NULL : "the faces differ";
    }
    free(sent);
    free(received);
    return difference;
}

/* Each row that was sent comes back, where the map says, and no other one. */
static const char *compare_rows(const struct comparison *c, const struct encoding *e)
{
    size_t sent = c->sent.rows, received = c->received.rows;
    for (size_t i = 0; i < sent; i++)
        if (e->input.map[i] >= received || c->row[sent + e->input.map[i]] != c->row[i])
            return "the map leads to another row";
    for (size_t i = 0; i < received; i++)
        if (c->row[sent + i] >= sent)
            return "there is a row that was not sent";
    return NULL;
}

static int same_channels(const struct encoding *e, const cq_decoder *d)
{
    uint32_t sent = e->input.shape.num_channels, received = d->shape.num_channels;
    if (received == sent + 1 && d->shape.channel[sent].kind == CQ_TURNED)
        received--;
    return received == sent && memcmp(d->shape.channel, e->input.shape.channel, sent * sizeof *d->shape.channel) == 0;
}

static int same_words(const struct encoding *e, const cq_decoder *d)
{
    size_t size = e->input.shape.metadata_bytes;
    return d->shape.metadata_bytes == size && (size == 0 || memcmp(d->metadata, e->words, size) == 0);
}

static const char *compare_contents(struct comparison *c, const struct encoding *e, const cq_decoder *d)
{
    const char *difference;
    count_words(c);
    if (!take_sent(c, e) || !take_received(c, d) || !match_contents(c))
        return "there is no memory to compare";
    if (c->sent.faces != c->received.faces)
        return "the number of faces differs";
    difference = compare_rows(c, e);
    return difference != NULL ? difference : compare_faces(c, e);
}

static void free_content(struct content *m)
{
    free(m->row);
    free(m->number);
    free(m->index);
}

static const char *find_difference_in_contents(const struct encoding *e, const cq_decoder *d)
{
    struct comparison c = { 0 };
    c.shape = &e->input.shape;
    const char *difference = compare_contents(&c, e, d);
    free_content(&c.sent);
    free_content(&c.received);
    free(c.row);
    free(c.face);
    return difference;
}

/* Half a step, or in exact streams what a float is away, and where floats are used, their rounding. */
static double tolerance(const cq_channel *channel, double x)
{
    return fabs(x) * 0x1p-23 + (channel->bits == CQ_EXACT_BITS ? 0 : 0.501 * (double)cq_channel_step(channel));
}

/* Are the positions that a user gets those of the file? */
static int near_positions(const struct encoding *e, const cq_decoder *d)
{
    const cq_channel *channel = &d->shape.channel[0];
    if (d->shape.num_channels == 0 || channel->kind != CQ_POSITION)
        return 1;
    cq_value *values = read_rows(d, 0);
    double *positions = values != NULL ? reconstruct_positions(channel, values, count_rows(d)) : NULL;
    int near = positions != NULL;
    for (size_t i = 0; near && i < 3 * (size_t)e->input.shape.num_vertices; i++) {
        double x = e->positions[i], found = positions[3 * (size_t)e->input.map[i / 3] + i % 3];
        near = fabs(found - x) <= tolerance(channel, x);
    }
    free(values);
    free(positions);
    return near;
}

/* NULL if the decoded mesh is the input; else what differs. */
static const char *find_difference(const struct encoding *e, const cq_decoder *d)
{
    if (!same_channels(e, d))
        return "the channels differ";
    if (!same_words(e, d))
        return "the metadata differ";
    const char *difference = find_difference_in_contents(e, d);
    if (difference != NULL)
        return difference;
    if (!near_positions(e, d))
        return "the positions differ";
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
        while (result == CQ_MORE);
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
