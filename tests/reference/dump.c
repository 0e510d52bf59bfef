/* Prints what a stream decodes to, for comparison with decoder.py: dump [VERTICES] <STREAM.
 * SPDX-License-Identifier: MIT
 *
 * The kind of result, counts, levels if the stream is complete, the error of the level; the values of each vertex,
 * all channels in one line; the triangles, each with its values; ranges of materials; rows, what is aside, and metadata.
 * With VERTICES, stops as soon as the mesh has so many. Exit status 2: too large
 * for memory. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include <stdio.h>
#include <stdlib.h>

#define MAX_MEMORY ((size_t)1 << 28)

static const char *kind(cq_result result)
{
    switch ((int)result) {
    case CQ_MORE: return "stopped";
    case CQ_DONE: return "done";
    case CQ_TRUNCATED: return "truncated";
    case CQ_ERROR_FORMAT: return "format";
    case CQ_ERROR_VERSION: return "version";
    case CQ_ERROR_UNSUPPORTED: return "unsupported";
    case CQ_ERROR_CORRUPT: return "corrupt";
    case CQ_ERROR_CHECKSUM: return "checksum";
    default: return cq_result_string(result);
    }
}

static unsigned long number(cq_value value) { return (uint32_t)value; }

/* Those of the channels of vertices, of rows or of faces. */
static int print_values(const cq_decoder *d, size_t n, int of, const char *gap)
{
    uint32_t k, c;
    int any = 0;
    for (k = 0; k < d->shape.num_channels; k++)
        for (c = 0; c < d->shape.channel[k].components && cqi_class(&d->shape, k) == of; c++, gap = " ", any = 1)
            printf("%s%lu", gap, number(d->channel[k][n * d->shape.channel[k].components + c]));
    return any;
}

static void print_corners(const cq_index *v)
{
    printf("%lu %lu %lu", (unsigned long)v[0], (unsigned long)v[1], (unsigned long)v[2]);
}

static void print_aside(const cq_decoder *d)
{
    size_t n;
    uint32_t k, c;
    for (n = 0; n < d->aside.num_rows; n++) {
        printf("aside");
        for (k = 0; k < d->shape.num_channels; k++)
            for (c = 0; c < d->shape.channel[k].components && d->shape.channel[k].merge != CQ_PER_FACE; c++)
                printf(" %lu", number(d->aside.channel[k][n * d->shape.channel[k].components + c]));
        printf("\n");
    }
    for (n = 0; n < d->aside.num_faces; n++) {
        printf("aside ");
        print_corners(d->aside.index + 3 * n);
        if (d->aside.material) printf(" %lu", (unsigned long)d->aside.material[n]);
        for (k = 0; k < d->shape.num_channels; k++)
            if (d->shape.channel[k].merge == CQ_PER_FACE) printf(" %lu", number(d->aside.channel[k][n]));
        printf("\n");
    }
    if (d->shape.metadata_bytes) printf("metadata ");
    for (n = 0; n < d->shape.metadata_bytes; n++) printf("%02x", d->metadata[n]);
    if (d->shape.metadata_bytes) printf("\n");
}

/* Faces of a material; without materials all are those of number 0. */
static void print_faces(const cq_decoder *d, uint32_t m)
{
    cq_index first, count;
    size_t f;
    cq_material(d, m, &first, &count);
    for (f = first; f < (size_t)first + count; f++) {
        print_corners(d->mesh.origin + 3 * f);
        print_values(d, f, CQI_OF_FACE, " ");
        if (d->vertex) printf(" ");
        if (d->vertex) print_corners(d->index + 3 * f);
        printf("\n");
    }
}

static unsigned long num_faces(const cq_decoder *d)
{
    unsigned long n = 0;
    cq_index first, count;
    uint32_t m = 0;
    do {
        cq_material(d, m, &first, &count);
        n += count;
    } while (++m < d->shape.num_materials);
    return n;
}

static void print_ranges(const cq_decoder *d)
{
    cq_index first, count;
    uint32_t m;
    for (m = 0; d->mesh.num_vertices && m < d->shape.num_materials; m++) {
        cq_material(d, m, &first, &count);
        printf("material %lu %lu\n", (unsigned long)first, (unsigned long)count);
    }
}

static void print(const cq_decoder *d, cq_result result)
{
    size_t v;
    uint32_t m = 0;
    printf("%s\n%lu vertices, %lu triangles\n", kind(result), (unsigned long)d->mesh.num_vertices, num_faces(d));
    if (result == CQ_DONE) printf("%lu levels\n", (unsigned long)d->level);
    if (result >= CQ_OK) printf("error %lu\n", (unsigned long)d->error);
    for (v = 0; v < d->mesh.num_vertices; v++) {
        if (print_values(d, v, CQI_OF_VERTEX, "")) printf("\n");
    }
    if (d->vertex && d->mesh.num_vertices) printf("%lu rows\n", (unsigned long)d->num_rows);
    for (v = 0; d->vertex && d->mesh.num_vertices && v < d->num_rows; v++) {
        printf("%lu", (unsigned long)d->vertex[v]);
        print_values(d, v, CQI_OF_ROW, " ");
        printf("\n");
    }
    do print_faces(d, m);
    while (++m < d->shape.num_materials);
    print_ranges(d);
    if (result == CQ_DONE) print_aside(d);
}

/* Standard input, in a block of its size; NULL if there is no memory. */
static uint8_t *read_all(size_t *size)
{
    size_t capacity = 1 << 16, n = 1;
    uint8_t *data = (uint8_t *)malloc(capacity), *exact;
    for (*size = 0; data && n; *size += n) {
        if (*size == capacity) {
            uint8_t *larger = (uint8_t *)realloc(data, capacity *= 2);
            if (!larger) free(data);
            if (!larger) return NULL;
            data = larger;
        }
        n = fread(data + *size, 1, capacity - *size, stdin);
    }
    exact = data ? (uint8_t *)realloc(data, *size + !*size) : NULL;
    return exact ? exact : data;
}

static cq_result decode(cq_decoder *d, cq_bytes in, unsigned long vertices)
{
    cq_result result = CQ_MORE;
    int ended = 0;
    while (result == CQ_MORE && (!vertices || d->mesh.num_vertices < vertices)) {
        result = cq_decode(d, ended ? NULL : &in, vertices ? 1 : CQ_NO_LIMIT);
        ended = result == CQ_NEED_INPUT;
        if (ended) result = CQ_MORE;
    }
    return result;
}

int main(int argc, char **argv)
{
    static cq_decoder decoder;
    cq_shape shape;
    size_t size, bytes = 4;
    uint8_t *data = read_all(&size);
    void *memory;
    if (data && cq_peek(data, size, &shape, NULL, NULL) == CQ_OK) bytes = cq_decoder_bytes(&shape);
    memory = bytes && bytes <= MAX_MEMORY ? malloc(bytes) : NULL;
    if (!memory) {
        free(data);
        return 2;
    }
    if (cq_decoder_init(&decoder, memory, bytes) == CQ_OK) {
        cq_bytes in;
        in.data = data;
        in.size = size;
        print(&decoder, decode(&decoder, in, argc > 1 ? strtoul(argv[1], NULL, 10) : 0));
    }
    free(memory);
    free(data);
    return 0;
}
