/* game_loop.c - refines a mesh for at most a millisecond per frame and uploads what changed.
 * SPDX-License-Identifier: MIT
 *
 *     cc -O2 -Iinclude examples/game_loop.c -o game_loop && ./game_loop bunny.cqm
 *
 * The decoder's arrays are the index and the vertex buffer, in place. A vertex never changes once it is there, so the
 * vertex buffer only grows at its end; of the index buffer the blocks change that cq_mesh_changes reports. Here the GPU
 * is a copy that gets only these, and at the end must be equal. Times are of the processor. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define FRAME 0.001               /* seconds for decoding and upload together */
#define STEPS 16                  /* between two looks at the clock: some 50 microseconds, */
#define MARGIN 0.0002             /* for which, and for caches that are cold, this is kept free */
#define SHIFT 6                   /* blocks of 64 faces */
#define MAX_FRAMES 1000000

/* A buffer of the GPU and its source. */
struct buffer {
    uint8_t *gpu;
    const void *source;
    size_t stride;                /* bytes of an element */
};

static cq_decoder dec;
static uint8_t *dirty;            /* blocks of the index buffer that are out of date on the GPU */
static double frame_seconds[MAX_FRAMES];
static size_t uploaded;

/* Memory that the system has really given: no frame waits for it. */
static void *allocate(size_t size)
{
    void *memory = malloc(size);
    return memory ? memset(memory, 1, size) : NULL;
}

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static int make_buffer(struct buffer *b, const void *source, size_t count, size_t stride)
{
    b->source = source;
    b->stride = stride;
    b->gpu = allocate(count * stride + 1);
    return b->gpu != NULL;
}

/* glBufferSubData, WriteBuffer, Map ... of elements first .. end - 1. */
static void upload_range(struct buffer *b, size_t first, size_t end)
{
    memcpy(b->gpu + first * b->stride, (const uint8_t *)b->source + first * b->stride, (end - first) * b->stride);
    uploaded += (end - first) * b->stride;
}

/* Uploads each run of dirty blocks and takes the marks off; the last block may be in part. */
static void upload_dirty(struct buffer *b, size_t count)
{
    uint8_t *begin, *end, *at = dirty, *stop = dirty + (count >> SHIFT) + 1;
    while ((begin = memchr(at, 1, (size_t)(stop - at))) != NULL) {
        size_t first = (size_t)(begin - dirty) << SHIFT, last;
        end = memchr(begin, 0, (size_t)(stop - begin));
        at = end ? end : stop;
        last = (size_t)(at - dirty) << SHIFT;
        memset(begin, 0, (size_t)(at - begin));
        upload_range(b, first, last < count ? last : count);
    }
}

/* Refines until the time is up. */
static cq_result refine(cq_bytes *in, double until)
{
    cq_result result;
    do
        result = cq_decode(&dec, in, STEPS);
    while (result == CQ_MORE && seconds() < until);
    return result;
}

/* One frame's share of the work. The upload gets half as much time again as the last one took. */
static cq_result frame(cq_bytes *in, struct buffer *faces, struct buffer *vertices, double begin)
{
    static double upload_seconds;
    cq_index since = dec.mesh.num_vertices;
    cq_result result = refine(in, begin + FRAME - MARGIN - 1.5 * upload_seconds);
    double decoded = seconds();
    cq_mesh_changes(&dec.mesh, since, SHIFT, dirty);
    upload_dirty(faces, dec.mesh.num_faces);
    upload_range(vertices, since, dec.mesh.num_vertices);
    upload_seconds = seconds() - decoded;
    return result;
}

static int by_time(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(size_t frames, size_t whole)
{
    size_t late = 0;
    qsort(frame_seconds, frames, sizeof frame_seconds[0], by_time);
    while (late < frames && frame_seconds[frames - 1 - late] > FRAME) late++;
    printf("%zu frames, milliseconds each: median %.3f, 99 %% %.3f, longest %.3f; %zu over %.0f\n", frames,
           frame_seconds[frames / 2] * 1e3, frame_seconds[frames - 1 - frames / 100] * 1e3,
           frame_seconds[frames - 1] * 1e3, late, FRAME * 1e3);
    printf("uploaded %.1f KB a frame; all of the buffers every time: %.1f KB\n",
           (double)uploaded / 1e3 / (double)frames, (double)whole / 1e3 / (double)frames);
}

/* Loading: the header, and memory for the mesh as it will be. */
static cq_result load(cq_bytes *in)
{
    cq_shape shape;
    cq_result result = cq_peek(in->data, in->size, &shape, NULL, NULL);
    size_t size = cq_decoder_bytes(&shape);
    if (result == CQ_OK) result = cq_decoder_init(&dec, allocate(size), size);
    if (result == CQ_OK) result = cq_decode(&dec, in, 1);
    if (result == CQ_MORE && (dec.shape.num_channels == 0 || dec.shape.channel[0].merge == CQ_PER_FACE))
        return CQ_ERROR_UNSUPPORTED;
    return result;
}

static cq_result play(cq_bytes *in)
{
    struct buffer faces, vertices;
    size_t frames = 0, whole = 0, vertex_bytes;
    cq_result result = load(in);
    if (result != CQ_MORE) return result;
    vertex_bytes = dec.shape.channel[0].components * sizeof(cq_value);
    dirty = calloc((dec.shape.num_faces >> SHIFT) + 1, 1);
    if (!dirty || !make_buffer(&faces, dec.mesh.origin, dec.shape.num_faces, 3 * sizeof(cq_index)) ||
        !make_buffer(&vertices, dec.channel[0], dec.shape.num_vertices, vertex_bytes))
        return CQ_ERROR_MEMORY;
    cq_watch_faces(&dec, SHIFT, dirty);
    for (; result == CQ_MORE && frames < MAX_FRAMES; frames++) {
        double begin = seconds();
        result = frame(in, &faces, &vertices, begin);
        frame_seconds[frames] = seconds() - begin;
        whole += dec.mesh.num_faces * faces.stride + dec.mesh.num_vertices * vertices.stride;
        /* A renderer draws here: dec.mesh.num_faces triangles. */
    }
    report(frames, whole);
    if (memcmp(faces.gpu, faces.source, dec.mesh.num_faces * faces.stride) ||
        memcmp(vertices.gpu, vertices.source, dec.mesh.num_vertices * vertices.stride))
        return CQ_ERROR_CHECKSUM;
    return result;
}

static cq_bytes load_file(const char *path)
{
    cq_bytes file = { NULL, 0 };
    static uint8_t bytes[1 << 26];
    FILE *f = fopen(path, "rb");
    if (!f) return file;
    file.data = bytes;
    file.size = fread(bytes, 1, sizeof bytes, f);
    fclose(f);
    return file;
}

int main(int argc, char **argv)
{
    cq_bytes in = load_file(argc == 2 ? argv[1] : "");
    cq_result result;
    if (!in.data) {
        fprintf(stderr, "usage: game_loop FILE.cqm\n");
        return 2;
    }
    result = play(&in);
    printf("%s: %lu of %lu vertices\n", cq_result_string(result), (unsigned long)dec.mesh.num_vertices,
           (unsigned long)dec.shape.num_vertices);
    return result == CQ_DONE ? 0 : 1;
}
