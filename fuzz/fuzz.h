/* What the fuzz targets share: bytes that direct a case, memory of exactly the size asked for, headers with right check
 * values, and a decoding that checks after each call what the header promises.
 *
 * A target is LLVMFuzzerTestOneInput in one file. It runs under libFuzzer (`make fuzz`), and on the committed inputs
 * without it (run.c, part of `make test`). */
#ifndef CQ_FUZZ_H
#define CQ_FUZZ_H

#define CQ_API static inline /* run.c links all targets together */
#ifndef CQ_ASSERT
#define CQ_ASSERT(condition) ((condition) ? (void)0 : __builtin_trap())
#endif
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include <stdio.h>
#include <stdlib.h>
#include "records.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A promise that must hold; a broken one is printed and ends the process, which is what a fuzzer looks for. */
#define REQUIRE(condition) \
    do { if (!(condition)) broken(__FILE__, __LINE__, #condition); } while (0)

static inline void broken(const char *file, int line, const char *condition)
{
    fprintf(stderr, "%s:%d: not true: %s\n", file, line, condition);
    abort();
}

/* -- The bytes that direct a case ---------------------------------------------------------------------------------- */

typedef struct input {
    const uint8_t *data;
    size_t size;
} input;

/* The next byte; 0 when there are no more. */
static inline uint32_t take(input *in)
{
    if (in->size == 0) return 0;
    in->size--;
    return *in->data++;
}

static inline uint32_t take_two(input *in)
{
    uint32_t low = take(in);
    return low | take(in) << 8;
}

static inline uint32_t take_four(input *in)
{
    uint32_t low = take_two(in);
    return low | take_two(in) << 16;
}

/* A number below n > 0. */
static inline uint32_t take_below(input *in, uint32_t n) { return (n <= 256 ? take(in) : take_two(in)) % n; }

/* -- Memory -------------------------------------------------------------------------------------------------------- */

/* Exactly `size` bytes, not initialised: one byte beyond them is an error of AddressSanitizer, and a branch on what was
 * never written one of MemorySanitizer. */
static inline void *block(size_t size)
{
    void *memory = malloc(size);
    REQUIRE(memory != NULL || size == 0);
    return memory;
}

static inline void *copy_of(const void *data, size_t size)
{
    void *copy = block(size);
    if (size > 0) memcpy(copy, data, size);
    return copy;
}

/* -- Work: basic blocks executed, where the build counts them (run.c, work.c); else always 0 ----------------------- */

#ifdef FUZZ_COUNTS_WORK
extern uint64_t work;
#else
enum { work = 0 };
#endif

/* -- Streams ------------------------------------------------------------------------------------------------------- */

typedef struct stream {
    uint8_t *data;   /* uint8_t[size], exactly */
    size_t size;
} stream;

static inline stream stream_of(const uint8_t *data, size_t size)
{
    stream s;
    s.data = (uint8_t *)copy_of(data, size);
    s.size = size;
    return s;
}

/* A header of this shape, with right check values, in front of the payload. */
static inline stream frame(const cq_shape *shape, const uint8_t *payload, size_t size)
{
    uint8_t header[CQ_MAX_HEADER_BYTES];
    size_t header_size = cqi_write_header(header, shape, size, cqi_crc32(0, payload, size));
    stream s;
    REQUIRE(header_size <= sizeof header);
    s.size = header_size + size;
    s.data = (uint8_t *)block(s.size);
    memcpy(s.data, header, header_size);
    if (size > 0) memcpy(s.data + header_size, payload, size);
    return s;
}

/* Puts the right check values into whatever can be read as a header with a payload. */
static inline void repair(stream *s)
{
    cq_shape shape;
    cqi_header header;
    cqi_reader r = { s->data, s->size, 3, CQ_OK };
    size_t at, left, k;
    uint32_t crc;
    if (s->size < 3) return;
    memset(&shape, 0, sizeof shape);
    header.shape = &shape;
    header.payload_size = 0;
    if (cqi_read_body(&r, &header) != CQ_OK || s->size - r.at < 2) return;
    at = r.at;
    left = s->size - at - 2;
    crc = cqi_crc32(0, s->data + at + 2, left < header.payload_size ? left : header.payload_size);
    for (k = 0; k < 4; k++) s->data[at - 4 + k] = (uint8_t)(crc >> (8 * k));
    crc = cqi_crc32(0, s->data, at);
    for (k = 0; k < 2; k++) s->data[at + k] = (uint8_t)(crc >> (8 * k));
}

/* Any kind and any way to predict, with as many components as they may have. */
static inline void choose_form(cq_channel *channel, uint32_t choice)
{
    channel->kind = (uint8_t)(choice % (CQ_GROUP + 1));
    channel->merge = (uint8_t)(choice / (CQ_GROUP + 1) % (CQ_PER_FACE + 1));
    if (CQ_MAX_BITS == 24 && channel->bits % 3 == 0) channel->bits = CQ_EXACT_BITS;
    while (!cqi_channel_is_valid(channel) && channel->components < CQ_MAX_COMPONENTS) channel->components++;
    if (cqi_channel_is_valid(channel)) return;
    channel->kind = CQ_GENERIC;
    channel->components = 1;
}

static inline void take_channels(input *in, cq_shape *shape)
{
    uint32_t k, c;
    shape->num_channels = take_below(in, 4);
    for (k = 0; k < shape->num_channels; k++) {
        cq_channel *channel = &shape->channel[k];
        uint32_t choice = take(in);
        channel->kind = (uint8_t)(choice & 1 ? CQ_POSITION : CQ_GENERIC);
        channel->components = (uint8_t)(choice & 1 ? 3 : 1 + (choice >> 1) % CQ_MAX_COMPONENTS);
        channel->bits = (uint8_t)(1 + take_below(in, CQ_MAX_BITS));
        if (choice >= 128) choose_form(channel, choice);
        channel->step = choice * 0x01020304u;
        for (c = 0; c < channel->components; c++) channel->origin[c] = ~channel->step + c;
    }
}

/* Seams, things aside, metadata. */
static inline void take_extension(input *in, cq_shape *shape)
{
    shape->num_rows = shape->num_vertices + take(in) % 64;
    if (shape->num_rows == shape->num_vertices) shape->num_rows = 0;
    shape->num_aside_rows = take(in) % 8;
    shape->num_aside_faces = take(in) % 8;
    shape->metadata_bytes = take(in) % 16;
}

/* Counts that a mesh may have: V, loops, edges and components minus genus decide the number of faces. */
static inline stream take_headed_stream(input *in)
{
    cq_shape shape;
    uint32_t size = take(in), loops = take(in);
    int64_t faces;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = size < 224 ? size % 64 : size < 248 ? 3 + take_below(in, 600) : 3 + take_below(in, 9000);
    shape.num_boundary_loops = loops < 160 ? 0 : loops % 8;
    if (shape.num_boundary_loops > 0) shape.num_boundary_edges = 3 * shape.num_boundary_loops + take_below(in, 64);
    faces = 2 * ((int64_t)shape.num_vertices + shape.num_boundary_loops) - (int64_t)shape.num_boundary_edges;
    faces -= 4 * ((int64_t)take_below(in, 32 + shape.num_vertices / 3) - 4);
    shape.num_faces = faces < 0 ? (uint32_t)(faces & 3) : (uint32_t)faces;
    take_channels(in, &shape);
    if (loops % 16 == 9) take_extension(in, &shape);
    return frame(&shape, in->data, in->size);
}

/* -- A decoding that is checked after each call -------------------------------------------------------------------- */

enum { MOST_MEMORY = 1 << 22 };   /* streams that ask for more only get to see too little */

typedef struct decoding {
    cq_decoder *decoder;
    void *memory;
    size_t memory_size;
    cq_report *report;        /* for streams of odd size; else NULL */
    cq_result result;         /* of the last call */
    size_t used;              /* bytes of input */
    uint32_t vertices, faces, level; /* after the last call */
    uint64_t calls;
} decoding;

/* A decoder with exactly the memory that the header asks for, or with none worth the name. */
static inline decoding decoding_begin(const stream *s)
{
    decoding d;
    cq_shape shape;
    memset(&d, 0, sizeof d);
    d.memory_size = 8;
    if (cq_peek(s->data, s->size, &shape, NULL, NULL) == CQ_OK && cq_decoder_bytes(&shape) <= MOST_MEMORY)
        d.memory_size = cq_decoder_bytes(&shape);
    d.memory = block(d.memory_size);
    d.decoder = (cq_decoder *)block(sizeof *d.decoder);
    d.result = cq_decoder_init(d.decoder, d.memory, d.memory_size);
    REQUIRE(d.result == CQ_OK);
    if (s->size % 2) d.decoder->report = d.report = (cq_report *)block(sizeof *d.report);
    return d;
}

static inline void decoding_end(decoding *d)
{
    free(d->decoder);
    free(d->memory);
    free(d->report);
}

static inline int is_permanent(cq_result result) { return result != CQ_OK && result != CQ_MORE && result != CQ_NEED_INPUT; }

/* Channel k belongs to rows, of which there may be more than vertices. */
static inline size_t num_owners(const cq_decoder *d, uint32_t k)
{
    return cqi_class(&d->shape, k) == CQI_OF_ROW ? d->num_rows : d->mesh.num_vertices;
}

/* Values of a channel, of all vertices or of all faces. */
static inline size_t num_values(const cq_channel *c, size_t num_vertices, size_t num_faces)
{
    return c->merge == CQ_PER_FACE ? num_faces : num_vertices * c->components;
}

/* Every value of every vertex and face that is there is one that its channel may have. */
static inline void check_values(const cq_decoder *d)
{
    uint32_t k;
    size_t j;
    for (k = 0; k < d->shape.num_channels; k++) {
        const cq_channel *c = &d->shape.channel[k];
        for (j = 0; j < num_values(c, num_owners(d, k), d->mesh.num_faces) && c->bits != CQ_EXACT_BITS; j++)
            REQUIRE((c->merge == CQ_PER_FACE && !face_is_there(d, (uint32_t)j)) ||
                    (d->channel[k][j] >= 0 && (uint32_t)d->channel[k][j] < (uint32_t)1 << c->bits));
    }
}

/* The triangles alone, as a renderer has them, are an oriented manifold with the header's boundary loops. */
static inline void check_triangles(const cq_mesh *m, uint32_t num_loops)
{
    cq_mesh again;
    cq_shape shape;
    void *memory = NULL;
    cq_index *const triangles = (cq_index *)block(3 * (size_t)m->num_faces * sizeof(cq_index));
    cq_result result = CQ_ERROR_MEMORY;
    uint32_t v;
    int tries;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = m->num_vertices;
    shape.num_faces = (uint32_t)cq_mesh_triangles(m, triangles);
    for (tries = 0; result == CQ_ERROR_MEMORY && tries < 2; tries++) {
        free(memory);
        memory = block(cq_mesh_bytes(&shape));
        result = cq_mesh_build(&again, &shape, triangles, memory, cq_mesh_bytes(&shape), NULL);
    }
    REQUIRE(result == CQ_OK);
    REQUIRE(shape.num_boundary_loops == num_loops);
    for (v = 0; v < m->num_vertices; v++) REQUIRE(again.valence[v] == m->valence[v]);
    free(memory);
    free(triangles);
}

/* The parts of a complete report add up. */
static inline void check_report(const cq_report *r, const cq_decoder *d)
{
    uint32_t k, splits = 0;
    uint64_t flags = 0, indices = 0;
    REQUIRE(r->header + r->base + r->flags + r->indices + r->positions + r->channels + r->aside ==
            (uint64_t)r->bytes * 8 * 65536);
    REQUIRE(r->num_levels <= CQ_MAX_LEVELS);
    for (k = 0; k < r->num_levels; k++) {
        splits += r->level[k].num_splits;
        flags += r->level[k].flags;
        indices += r->level[k].indices;
        REQUIRE(r->level[k].num_vertices == r->base_vertices + splits);
    }
    REQUIRE(r->base_vertices + splits == d->shape.num_vertices);
    REQUIRE(flags == r->flags && indices == r->indices);
}

/* What holds after every call, whatever it returned. Before the first level there are some components of the base. */
static inline void check_decoder(const cq_decoder *d)
{
    const cq_mesh *m = &d->mesh;
    const cq_shape *s = &d->shape;
    uint32_t k, faces = 0;
    REQUIRE(cq_mesh_check(m, NULL) == CQ_OK);
    if (m->num_vertices == 0) {
        REQUIRE(m->num_faces == 0 && m->num_virtual == 0 && m->num_virtual_faces == 0);
        return;
    }
    REQUIRE(m->num_vertices <= s->num_vertices && m->num_faces <= s->num_faces);
    REQUIRE(m->num_virtual <= s->num_boundary_loops && m->num_virtual_faces <= s->num_boundary_edges);
    for (k = 0; k < m->num_faces; k++) faces += (uint32_t)face_is_there(d, k);
    REQUIRE(faces == m->num_faces || s->num_materials > 0);
    REQUIRE(materials_are_valid(d));
    if (d->level > 0) {
        REQUIRE(m->num_virtual == s->num_boundary_loops);
        REQUIRE(2 * (int64_t)m->num_vertices - faces - (int64_t)m->num_virtual_faces ==
                2 * (int64_t)s->num_vertices - s->num_faces - (int64_t)s->num_boundary_edges);
    }
    for (k = 0; k < 3 * (uint32_t)m->num_faces; k++) REQUIRE(!face_is_there(d, k / 3) || m->origin[k] < m->num_vertices);
    for (k = 0; k < m->num_vertices; k++) REQUIRE(m->out[k] != CQ_NONE);
    REQUIRE(rows_are_valid(d));
    check_values(d);
    check_triangles(m, m->num_virtual);
}

/* One call of cq_decode. `thoroughly`: check the whole mesh after it, which takes time O(vertices). */
static inline cq_result decoding_call(decoding *d, cq_bytes *in, uint32_t budget, int thoroughly)
{
    const cq_decoder *r = d->decoder;
    size_t before = in != NULL ? in->size : 0;
    cq_result last = d->result;
    d->result = cq_decode(d->decoder, in, budget);
    d->calls++;
    if (in != NULL) REQUIRE(in->size <= before);
    if (in != NULL) d->used += before - in->size;
    if (is_permanent(last)) REQUIRE(d->result == last && (in == NULL || in->size == before));
    REQUIRE(d->result != CQ_OK);
    if (d->result == CQ_NEED_INPUT) REQUIRE(in != NULL && in->size == 0);
    if (d->result == CQ_TRUNCATED) REQUIRE(in == NULL || is_permanent(last));
    REQUIRE(r->mesh.num_vertices >= d->vertices && r->mesh.num_faces >= d->faces);
    if (d->level > 0 && budget == 1) REQUIRE(r->mesh.num_vertices - d->vertices <= 1);
    d->vertices = r->mesh.num_vertices;
    d->faces = r->mesh.num_faces;
    d->level = r->level;
    if (d->result == CQ_DONE) {
        REQUIRE(r->mesh.num_vertices == r->shape.num_vertices && r->mesh.num_faces == r->shape.num_faces);
        REQUIRE(r->num_rows == rows_of_mesh(r) && r->metadata_read == r->shape.metadata_bytes);
        REQUIRE(r->aside.num_rows == r->shape.num_aside_rows && r->aside.num_faces == r->shape.num_aside_faces);
        REQUIRE(r->mesh.num_virtual == r->shape.num_boundary_loops);
        REQUIRE(r->mesh.num_virtual_faces == r->shape.num_boundary_edges);
        if (d->report != NULL) check_report(d->report, r);
    }
    if (thoroughly || is_permanent(d->result)) check_decoder(r);
    return d->result;
}

/* A level adds a vertex for every 16 that it walks over, a patch of a walk has two faces or more, and a split is a
 * step: so a stream takes at most 17 steps a vertex, one level that fails, and one call for the end of input. Before
 * that, the number of faces of each material is a step. */
static inline uint64_t most_calls(const cq_decoder *d)
{
    return 18 * (uint64_t)d->shape.num_vertices + 8 + d->shape.num_materials + most_calls_for_rows(&d->shape);
}

/* Work of a decoding apart from that of the splits themselves, and of one split: a centre of valence 24 has 276
 * candidates, and 32 values of each of its neighbours may be summed. */
enum { WORK_PER_COUNT = 1500, WORK_PER_CASE = 40000, WORK_PER_SPLIT = 40000 };

/* All of it in one piece, one step at a time, then the end of the input. Bounds the steps, and the work where
 * counted. */
static inline void decoding_run(decoding *d, const stream *s)
{
    cq_bytes in;
    uint64_t spent = 0, counts;
    int ended = 0;
    in.data = s->data;
    in.size = s->size;
    do {
        uint32_t vertices = d->vertices, level = d->level;
        uint64_t before = work, now;
        int small = d->decoder->shape.num_vertices < 80;
        ended |= d->result == CQ_NEED_INPUT;
        decoding_call(d, ended ? NULL : &in, 1, 0);
        now = work - before;
        if (level > 0 && d->vertices > vertices) now -= now < WORK_PER_SPLIT ? now : WORK_PER_SPLIT;
        spent += now;
        if (d->vertices > vertices && (small || d->calls % 64 == 0)) check_decoder(d->decoder);
    } while (!is_permanent(d->result));
    counts = s->size;
    if (d->decoder->phase != 0) counts += (uint64_t)d->decoder->shape.num_vertices + d->decoder->shape.num_faces;
    if (d->decoder->phase != 0) counts += most_calls_for_rows(&d->decoder->shape);
    REQUIRE(d->calls <= most_calls(d->decoder));
    REQUIRE(spent <= WORK_PER_COUNT * counts + WORK_PER_CASE);
    REQUIRE(decoding_call(d, &in, 1, 0) == decoding_call(d, NULL, CQ_NO_LIMIT, 0));
}

/* Elements of faces that are there are the same; without materials all are. */
static inline int same_of_faces(const cq_decoder *d, const void *a, const void *b, size_t size)
{
    size_t f;
    for (f = 0; f < d->mesh.num_faces; f++)
        if (face_is_there(d, (uint32_t)f) && memcmp((const uint8_t *)a + f * size, (const uint8_t *)b + f * size, size) != 0)
            return 0;
    return 1;
}

/* The same mesh, slot for slot, and the same values. out[] may be any of a vertex's halfedges. */
static inline void check_equal(const cq_decoder *a, const cq_decoder *b)
{
    const cq_mesh *m = &a->mesh, *n = &b->mesh;
    uint32_t k;
    REQUIRE(m->num_vertices == n->num_vertices && m->num_faces == n->num_faces);
    REQUIRE(m->num_virtual == n->num_virtual && m->num_virtual_faces == n->num_virtual_faces);
    if (m->num_vertices == 0) return;
    for (k = 0; k < 2; k++) {
        size_t vertex = k ? m->first_virtual : 0, vertices = (k ? m->num_virtual : m->num_vertices) * sizeof(cq_index);
        size_t corner = k ? 3 * (size_t)m->first_virtual_face : 0;
        size_t corners = 3 * (size_t)m->num_virtual_faces * sizeof(cq_index);
        if (k) REQUIRE(memcmp(m->origin + corner, n->origin + corner, corners) == 0);
        if (k) REQUIRE(memcmp(m->twin + corner, n->twin + corner, corners) == 0);
        REQUIRE(memcmp(m->valence + vertex, n->valence + vertex, vertices) == 0);
    }
    REQUIRE(same_of_faces(a, m->origin, n->origin, 3 * sizeof(cq_index)));
    REQUIRE(same_of_faces(a, m->twin, n->twin, 3 * sizeof(cq_index)));
    for (k = 0; k < a->shape.num_channels; k++) {
        const cq_channel *c = &a->shape.channel[k];
        if (c->merge == CQ_PER_FACE) REQUIRE(same_of_faces(a, a->channel[k], b->channel[k], sizeof(cq_value)));
        else REQUIRE(memcmp(a->channel[k], b->channel[k], num_values(c, num_owners(a, k), 0) * sizeof(cq_value)) == 0);
    }
    if (a->vertex != NULL) {
        REQUIRE(a->num_rows == b->num_rows);
        REQUIRE(same_of_faces(a, a->index, b->index, 3 * sizeof(cq_index)));
        REQUIRE(memcmp(a->vertex, b->vertex, a->num_rows * sizeof(cq_index)) == 0);
    }
}

#endif
