/* Says in numbers what the codec does with meshes, so that two builds of it can be compared line by line:
 *
 *     portability FILE.off ...
 *
 * For each mesh of the files and some that are made here, with and without channels: size and hash of the stream, hash
 * of the order of the vertices, and of what a decoder has after every quarter of the stream and at its end. Numbers are
 * hashed as 32-bit little-endian words whatever the machine, and coordinates are read without floating point, so that
 * all machines, compilers and index widths must print the same. C99 and C++. The exit status is 0 only if every decoded
 * mesh is valid and, at the end, has the values that were encoded. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POSITION_BITS = 12, MAX_LINE = 256 };

typedef struct model {
    uint32_t num_vertices, num_faces;
    cq_index *indices;     /* cq_index[3 * num_faces] */
    cq_value *positions;   /* cq_value[3 * num_vertices], 0 .. 2^POSITION_BITS - 1 */
} model;

static int failures;

static void check(int condition, const char *name, const char *what)
{
    if (condition) return;
    failures++;
    printf("%s: %s\n", name, what);
}

static void *allocate(size_t size)
{
    void *block = calloc(size ? size : 1, 1);
    if (block != NULL) return block;
    printf("no memory\n");
    exit(1);
}

/* -- Hashes: FNV-1a of 32-bit words -- */

static uint32_t hash_word(uint32_t hash, uint32_t word)
{
    int k;
    for (k = 0; k < 4; k++) hash = (hash ^ (word >> 8 * k & 0xff)) * 16777619u;
    return hash;
}

static uint32_t hash_bytes(const uint8_t *bytes, size_t size)
{
    uint32_t hash = 2166136261u;
    size_t k;
    for (k = 0; k < size; k++) hash = (hash ^ bytes[k]) * 16777619u;
    return hash;
}

static uint32_t hash_indices(uint32_t hash, const cq_index *indices, size_t count)
{
    size_t k;
    for (k = 0; k < count; k++) hash = hash_word(hash, indices[k]);
    return hash;
}

static uint32_t hash_decoded(const cq_decoder *d)
{
    uint32_t hash = hash_word(hash_word(2166136261u, d->mesh.num_vertices), d->mesh.num_faces), k;
    size_t j;
    hash = hash_indices(hash, d->mesh.origin, 3 * (size_t)d->mesh.num_faces);
    for (k = 0; k < d->shape.num_channels; k++)
        for (j = 0; j < (size_t)d->shape.channel[k].components * d->mesh.num_vertices; j++)
            hash = hash_word(hash, (uint32_t)d->channel[k][j]);
    return hash_word(hash, d->level);
}

/* -- Meshes -- */

static model new_model(uint32_t num_vertices, uint32_t num_faces)
{
    model m;
    m.num_vertices = num_vertices;
    m.num_faces = num_faces;
    m.indices = (cq_index *)allocate(3 * (size_t)num_faces * sizeof(cq_index));
    m.positions = (cq_value *)allocate(3 * (size_t)num_vertices * sizeof(cq_value));
    return m;
}

static void free_model(model *m)
{
    free(m->indices);
    free(m->positions);
}

/* A decimal number in millionths; *text moves behind it. */
static int64_t read_millionths(const char **text)
{
    int64_t value = 0;
    int negative, places = -1;
    while (**text == ' ') ++*text;
    negative = **text == '-';
    *text += negative;
    for (; (**text >= '0' && **text <= '9') || **text == '.'; ++*text) {
        if (**text == '.') places = 0;
        else if (places < 6) {
            value = 10 * value + (**text - '0');
            places += places >= 0;
        }
    }
    for (places = places < 0 ? 0 : places; places < 6; places++) value *= 10;
    return negative ? -value : value;
}

/* Coordinates onto the grid of POSITION_BITS bits, all with one step. */
static void quantise(model *m, const int64_t *from)
{
    int64_t low = from[0], high = from[0];
    size_t k, n = 3 * (size_t)m->num_vertices;
    for (k = 0; k < n; k++) {
        low = from[k] < low ? from[k] : low;
        high = from[k] > high ? from[k] : high;
    }
    for (k = 0; k < n; k++)
        m->positions[k] = (cq_value)((from[k] - low) * ((1 << POSITION_BITS) - 1) / (high > low ? high - low : 1));
}

static int read_off(model *m, const char *path)
{
    char line[MAX_LINE];
    unsigned long v = 0, f = 0, a, b, c;
    FILE *file = fopen(path, "r");
    int64_t *at;
    size_t k;
    int ok = file != NULL && fgets(line, sizeof line, file) != NULL && fgets(line, sizeof line, file) != NULL &&
             sscanf(line, "%lu %lu", &v, &f) == 2;
    if (!ok) {
        if (file != NULL) fclose(file);
        return 0;
    }
    *m = new_model((uint32_t)v, (uint32_t)f);
    at = (int64_t *)allocate(3 * (v + 1) * sizeof *at);
    for (k = 0; ok && k < 3 * v; k += 3) {
        const char *text = line;
        ok = fgets(line, sizeof line, file) != NULL;
        at[k] = read_millionths(&text);
        at[k + 1] = read_millionths(&text);
        at[k + 2] = read_millionths(&text);
    }
    quantise(m, at);
    for (k = 0; ok && k < 3 * f; k += 3) {
        ok = fgets(line, sizeof line, file) != NULL && sscanf(line, "3 %lu %lu %lu", &a, &b, &c) == 3;
        m->indices[k] = (cq_index)a;
        m->indices[k + 1] = (cq_index)b;
        m->indices[k + 2] = (cq_index)c;
    }
    free(at);
    fclose(file);
    return ok;
}

/* A grid of squares, each cut in one of two ways; closed to a torus, or open. Heights from a linear congruence. */
static model make_grid(uint32_t width, uint32_t height, int closed)
{
    uint32_t columns = width - !closed, rows = height - !closed, x, y, random = 12345;
    model m = new_model(width * height, 2 * columns * rows);
    cq_index *to = m.indices;
    for (y = 0; y < height; y++)
        for (x = 0; x < width; x++) {
            cq_value *at = m.positions + 3 * (size_t)(y * width + x);
            random = random * 1664525u + 1013904223u;
            at[0] = (cq_value)(x * 4000 / width);
            at[1] = (cq_value)(y * 4000 / height);
            at[2] = (cq_value)(random >> 24);
        }
    for (y = 0; y < rows; y++)
        for (x = 0; x < columns; x++) {
            uint32_t right = (x + 1) % width, above = (y + 1) % height;
            cq_index a = (cq_index)(y * width + x), b = (cq_index)(y * width + right);
            cq_index c = (cq_index)(above * width + right), d = (cq_index)(above * width + x);
            int cut = (x * 7 + y * 3) % 5 < 2;
            *to++ = a; *to++ = b; *to++ = cut ? c : d;
            *to++ = cut ? a : b; *to++ = c; *to++ = d;
        }
    return m;
}

/* -- Encoding and decoding -- */

typedef struct coded {
    uint8_t *bytes;
    size_t size;
    cq_index *map;
} coded;

/* No channel, the positions, or these and the same numbers as a channel that is no position, for the other goal. */
static cq_result encode(coded *c, const model *m, uint32_t num_channels)
{
    cq_input in;
    uint32_t k;
    cq_result result = CQ_ERROR_MEMORY;
    size_t capacity = 4096 + 64 * (size_t)m->num_vertices;
    int tries;
    memset(&in, 0, sizeof in);
    in.shape.num_vertices = m->num_vertices;
    in.shape.num_faces = m->num_faces;
    in.shape.num_channels = num_channels;
    for (k = 0; k < num_channels; k++) {
        in.shape.channel[k].kind = (uint8_t)(k == 0 ? CQ_POSITION : CQ_GENERIC);
        in.shape.channel[k].components = 3;
        in.shape.channel[k].bits = POSITION_BITS;
        in.values[k] = m->positions;
    }
    in.goal = num_channels > 1 ? CQ_LEAST_CONNECTIVITY : CQ_BALANCED;
    in.indices = m->indices;
    in.map = c->map = (cq_index *)allocate((size_t)m->num_vertices * sizeof(cq_index));
    c->bytes = (uint8_t *)allocate(capacity);
    c->size = 0;
    for (tries = 0; result == CQ_ERROR_MEMORY && tries < 4; tries++) {
        size_t size = cq_encoder_bytes(&in.shape);
        void *memory = allocate(size);
        result = cq_encode(&in, memory, size, c->bytes, capacity, &c->size, NULL, NULL);
        free(memory);
    }
    return result;
}

/* Of a row, aside or not. */
static void read_row(const cq_decoder *d, uint32_t channel, cq_index row, cq_value *to)
{
    if (row < d->num_rows) cq_read_rows(d, channel, row, 1, to);
    else memcpy(to, d->aside.channel[channel] + 3 * (size_t)(row - d->num_rows), 3 * sizeof *to);
}

static void check_values(const cq_decoder *d, const model *m, const coded *c, const char *name)
{
    size_t v, k;
    uint32_t channel;
    check(d->mesh.num_faces + d->aside.num_faces == m->num_faces, name, "other counts");
    for (channel = 0; channel < d->shape.num_channels && d->shape.channel[channel].kind != CQ_TURNED; channel++)
        for (v = 0; v < m->num_vertices; v++) {
            cq_value row[3];
            read_row(d, channel, c->map[v], row);
            for (k = 0; k < 3; k++)
                if (row[k] != m->positions[3 * v + k]) {
                    check(0, name, "other values");
                    return;
                }
        }
}

/* The hashes after each quarter of the stream, which is fed in pieces of 7 bytes. */
static void print_decoded(const model *m, const coded *c, const char *name)
{
    cq_decoder *d = (cq_decoder *)allocate(sizeof(cq_decoder));
    cq_shape shape;
    void *memory;
    cq_result result;
    size_t at = 0, n, memory_size;
    uint32_t quarter;
    check(cq_peek(c->bytes, c->size, &shape, NULL, NULL) == CQ_OK, name, "header is not read");
    memory_size = cq_decoder_bytes(&shape);
    memory = allocate(memory_size);
    result = cq_decoder_init(d, memory, memory_size);
    for (quarter = 1; quarter <= 4; quarter++) {
        for (; at < c->size * quarter / 4; at += n) {
            cq_bytes in;
            n = c->size * quarter / 4 - at < 7 ? c->size * quarter / 4 - at : 7;
            in.data = c->bytes + at;
            in.size = n;
            result = cq_decode(d, &in, CQ_NO_LIMIT);
        }
        check(result == (quarter < 4 ? CQ_NEED_INPUT : CQ_DONE), name, cq_result_string(result));
        check(!d->mesh.num_vertices || cq_mesh_check(&d->mesh, NULL) == CQ_OK, name, "not a mesh");
        printf(" %08lx", (unsigned long)hash_decoded(d));
    }
    check_values(d, m, c, name);
    free(memory);
    free(d);
}

static void print_model(const model *m, const char *name)
{
    uint32_t num_channels;
    for (num_channels = 0; num_channels < 3; num_channels++) {
        coded c;
        cq_result result = encode(&c, m, num_channels);
        printf("%s %lu: %d", name, (unsigned long)num_channels, (int)result);
        if (result == CQ_OK) {
            printf(" %lu bytes %08lx order %08lx decoded", (unsigned long)c.size,
                   (unsigned long)hash_bytes(c.bytes, c.size),
                   (unsigned long)hash_indices(2166136261u, c.map, m->num_vertices));
            print_decoded(m, &c, name);
        }
        printf("\n");
        free(c.bytes);
        free(c.map);
    }
}

int main(int argc, char **argv)
{
    static const struct { uint32_t width, height; int closed; const char *name; } grids[] = {
        { 3, 3, 1, "torus 3 x 3" }, { 5, 4, 1, "torus 5 x 4" }, { 40, 25, 1, "torus 40 x 25" },
        { 2, 2, 0, "grid 2 x 2" }, { 7, 2, 0, "grid 7 x 2" }, { 60, 50, 0, "grid 60 x 50" }
    };
    size_t k;
    int i;
    for (k = 0; k < sizeof grids / sizeof *grids; k++) {
        model m = make_grid(grids[k].width, grids[k].height, grids[k].closed);
        print_model(&m, grids[k].name);
        free_model(&m);
    }
    for (i = 1; i < argc; i++) {
        model m;
        int ok = read_off(&m, argv[i]);
        check(ok, argv[i], "not read");
        if (!ok) continue;
        print_model(&m, argv[i]);
        free_model(&m);
    }
    return fflush(stdout) != 0 || failures != 0;
}
