/* decoder.c - conquest.h as a WebAssembly module that decodes: one instance, one stream. SPDX-License-Identifier: MIT
 *
 * The page reads `web_state` and the arrays it points to. Memory grows once, when the header is read, and not after. */
#define CQ_NO_ENCODER
#define CQ_NO_REPORTS
#define CQ_API static inline
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#define EXPORT(name) __attribute__((export_name(name)))
enum { PAGE = 65536, INPUT_BYTES = 65536, SHIFT = 6 };       /* an index block has 2^SHIFT faces */

extern uint8_t __heap_base;

/* A channel: what the stream has, and what a GPU wants: floats, or the values if they are whole numbers. */
typedef struct web_channel {
    uint32_t kind, components, bits, merge;
    float step, origin[CQ_MAX_COMPONENTS];
    const cq_value *values;
    void *array;
    uint32_t width;             /* numbers of the array for each vertex or face */
    uint32_t is_integer;
    uint32_t is_relative;       /* to the origin, as floats are too coarse for the sum */
} web_channel;

/* All that the page reads: uint32_t, pointers and floats of 4 bytes; conquest.js has the same order. */
typedef struct web_state {
    int32_t result;
    uint32_t bytes_used, num_vertices, num_faces, total_vertices, total_faces, level, error;
    uint32_t header_bytes, stream_bytes, num_channels;
    const cq_index *index;
    uint8_t *blocks;
    uint32_t memory_bytes;      /* that the stream needs, all arrays included */
    web_channel channel[CQ_MAX_CHANNELS];
} web_state;

static web_state state;
static cq_decoder decoder;
static cq_channel relative[CQ_MAX_CHANNELS];
static uint8_t input[INPUT_BYTES];
static cq_bytes waiting;

EXPORT("state") web_state *get_state(void) { return &state; }
EXPORT("input") uint8_t *get_input(void) { return input; }
EXPORT("message") const char *get_message(int32_t result) { return cq_result_string((cq_result)result); }

static float float_of(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static uint32_t rows_of(const cq_channel *c, uint32_t vertices, uint32_t faces)
{
    return c->merge == CQ_PER_FACE ? faces : vertices;
}

/* Are the values themselves what a reader wants? */
static int is_integer(const cq_channel *c)
{
    const int whole = float_of(c->step) == 1 && !(c->origin[0] | c->origin[1] | c->origin[2] | c->origin[3]);
    return c->kind == CQ_JOINTS || c->kind == CQ_NUMBER || c->kind == CQ_GROUP
        || (c->kind == CQ_GENERIC && c->merge != CQ_AVERAGE && whole && c->bits != CQ_EXACT_BITS);
}

/* Is a step less than two floats apart, at the far end of the grid? 2^-23 is the distance of floats from 1 on. */
static int is_relative(const cq_channel *c)
{
    float far = 0;
    if (c->kind != CQ_POSITION || c->bits == CQ_EXACT_BITS) return 0;
    for (uint32_t k = 0; k < c->components; k++) {
        const float low = float_of(c->origin[k]), high = low + float_of(c->step) * (float)(1u << c->bits);
        if (far < __builtin_fabsf(low)) far = __builtin_fabsf(low);
        if (far < __builtin_fabsf(high)) far = __builtin_fabsf(high);
    }
    return far * 0x1p-23f > float_of(c->step);
}

static void describe(uint32_t k)
{
    const cq_channel *c = &decoder.shape.channel[k];
    web_channel *w = &state.channel[k];
    *w = (web_channel){ c->kind, c->components, c->bits, c->merge, float_of(c->step), { 0 }, NULL, NULL, 0, 0, 0 };
    for (int i = 0; i < CQ_MAX_COMPONENTS; i++)
        w->origin[i] = float_of(c->origin[i]);
    w->is_integer = (uint32_t)is_integer(c);
    w->is_relative = (uint32_t)is_relative(c);
    w->width = c->kind == CQ_NORMAL ? 3 : c->components;
    relative[k] = *c;
    if (w->is_relative)
        memset(relative[k].origin, 0, sizeof relative[k].origin);
}

static uint64_t array_bytes(uint32_t k)
{
    const uint32_t rows = rows_of(&decoder.shape.channel[k], state.total_vertices, state.total_faces);
    return state.channel[k].is_integer ? 0 : (uint64_t)rows * state.channel[k].width * sizeof(float);
}

/* Memory from the heap's start on; 0 if the page does not give it. */
static uint8_t *grow(uint64_t bytes)
{
    const uint64_t end = (uintptr_t)&__heap_base + bytes + 15;
    const uint64_t pages = (end + PAGE - 1) / PAGE, have = __builtin_wasm_memory_size(0);
    if (pages > 65536 || (pages > have && __builtin_wasm_memory_grow(0, (size_t)(pages - have)) == SIZE_MAX))
        return NULL;
    return (uint8_t *)(((uintptr_t)&__heap_base + 15) & ~(uintptr_t)15);
}

/* Reads the header, of `size` bytes of input, and takes the memory for all that is to come. */
EXPORT("begin") int32_t begin(uint32_t size)
{
    cq_shape *shape = &decoder.shape;
    size_t header, stream;
    const cq_result result = cq_peek(input, size, shape, &header, &stream);
    if (result != CQ_OK) return state.result = result;
    const size_t own = cq_decoder_bytes(shape);
    const uint32_t blocks = (shape->num_faces + (1u << SHIFT) - 1) >> SHIFT;
    uint64_t bytes = (uint64_t)own + (blocks + 3u) / 4 * 4;
    state.header_bytes = (uint32_t)header;
    state.stream_bytes = (uint32_t)stream;
    state.total_vertices = shape->num_vertices;
    state.total_faces = shape->num_faces;
    state.num_channels = shape->num_channels;
    for (uint32_t k = 0; k < shape->num_channels; k++) {
        describe(k);
        bytes += array_bytes(k);
    }
    state.memory_bytes = bytes > UINT32_MAX ? UINT32_MAX : (uint32_t)bytes;
    uint8_t *at = own ? grow(bytes) : NULL;
    if (!at) return state.result = CQ_ERROR_MEMORY;
    cq_decoder_init(&decoder, at, own);
    at += own;
    for (uint32_t k = 0; k < state.num_channels; k++, at += array_bytes(k - 1))
        state.channel[k].array = at;
    state.blocks = at;
    return state.result = CQ_OK;
}

/* Floats of the rows that are new. */
static void reconstruct(uint32_t k, uint32_t first, uint32_t end)
{
    web_channel *w = &state.channel[k];
    const cq_value *from = decoder.channel[k] + (size_t)first * w->components;
    float *to = (float *)w->array + (size_t)first * w->width;
    w->values = decoder.channel[k];
    if (w->is_integer)
        w->array = decoder.channel[k];
    else if (w->kind == CQ_NORMAL && w->components == 2)
        cq_reconstruct_normals((int)w->bits, from, end - first, to);
    else
        cq_reconstruct(&relative[k], from, end - first, to);
}

static int32_t update(cq_result result)
{
    const uint32_t vertices = decoder.mesh.num_vertices, faces = decoder.mesh.num_faces;
    for (uint32_t k = 0; vertices && k < state.num_channels; k++) {
        const cq_channel *c = &decoder.shape.channel[k];
        reconstruct(k, rows_of(c, state.num_vertices, state.num_faces), rows_of(c, vertices, faces));
    }
    state.num_vertices = vertices;
    state.num_faces = faces;
    state.index = decoder.mesh.origin;
    state.level = decoder.level;
    state.error = decoder.error;
    return state.result = result;
}

/* Says that `size` bytes of input are there; all before are used. */
EXPORT("give") void give(uint32_t size) { waiting = (cq_bytes){ input, size }; }

/* Decodes what was given, at most `budget` steps. */
EXPORT("decode") int32_t decode(uint32_t budget)
{
    const size_t before = waiting.size;
    const cq_result result = cq_decode(&decoder, &waiting, budget);
    state.bytes_used += (uint32_t)(before - waiting.size);
    return update(result);
}

/* No more input will come. */
EXPORT("finish") int32_t finish(void) { return update(cq_decode(&decoder, NULL, CQ_NO_LIMIT)); }

/* Marks the index blocks that have changed since there were so many vertices: bytes at state.blocks. */
EXPORT("changes") uint32_t changes(uint32_t since)
{
    const uint32_t count = (state.num_faces + (1u << SHIFT) - 1) >> SHIFT;
    memset(state.blocks, 0, count);
    if (count) cq_mesh_changes(&decoder.mesh, since, SHIFT, state.blocks);
    return count;
}
