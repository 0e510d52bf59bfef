/* encoder.c - conquest.h as a WebAssembly module that encodes: one instance, one mesh. SPDX-License-Identifier: MIT */
#define CQ_NO_REPORTS
#define CQ_API static inline
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#define EXPORT(name) __attribute__((export_name(name)))
enum { PAGE = 65536 };

extern uint8_t __heap_base;

__attribute__((import_module("page"), import_name("progress"))) void page_progress(uint32_t done, uint32_t total);

static cq_input in;
static cq_place place;
static struct { size_t stream, stream_size, map, face_map; } out;
static uint64_t taken;

EXPORT("place") cq_place *get_place(void) { return &place; }
EXPORT("output") void *get_output(void) { return &out; }
EXPORT("message") const char *get_message(int32_t result) { return cq_result_string((cq_result)result); }

/* Memory behind all that was taken before, a multiple of 8; NULL if the page does not give it. */
EXPORT("take") void *take(uint32_t bytes)
{
    const uint64_t start = ((uintptr_t)&__heap_base + taken + 7) / 8 * 8;
    const uint64_t pages = (start + bytes + PAGE - 1) / PAGE, have = __builtin_wasm_memory_size(0);
    if (pages > 65536 || (pages > have && __builtin_wasm_memory_grow(0, (size_t)(pages - have)) == SIZE_MAX))
        return NULL;
    taken = start + bytes - (uintptr_t)&__heap_base;
    return (void *)(uintptr_t)start;
}

EXPORT("mesh") void set_mesh(uint32_t vertices, uint32_t faces, const cq_index *indices, uint32_t goal)
{
    in.shape.num_vertices = vertices;
    in.shape.num_faces = faces;
    in.indices = indices;
    in.goal = (cq_goal)goal;
}

EXPORT("materials") void set_materials(uint32_t count, const cq_index *of_faces)
{
    in.shape.num_materials = count;
    in.materials = of_faces;
}

EXPORT("metadata") void set_metadata(const uint8_t *bytes, uint32_t size)
{
    in.metadata = bytes;
    in.shape.metadata_bytes = size;
}

static cq_channel *next_channel(uint32_t kind, uint32_t components, uint32_t bits, uint32_t merge)
{
    cq_channel *c = &in.shape.channel[in.shape.num_channels];
    c->kind = (uint8_t)kind;
    c->components = (uint8_t)components;
    c->bits = (uint8_t)bits;
    c->merge = (uint8_t)merge;
    return c;
}

static uint32_t bits_of(float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

/* One more channel, of whole numbers. */
EXPORT("integers") void add_integers(uint32_t kind, uint32_t components, uint32_t bits, uint32_t merge,
                                     const cq_value *values)
{
    cq_channel *c = next_channel(kind, components, bits, merge);
    c->step = bits_of(1);
    in.values[in.shape.num_channels++] = values;
}

/* Positions that are rounded already, on a grid whose origin is below them. */
EXPORT("grid") void add_grid(uint32_t bits, float step, float x, float y, float z, const cq_value *values)
{
    cq_channel *c = next_channel(CQ_POSITION, 3, bits, CQ_AVERAGE);
    c->step = bits_of(step);
    c->origin[0] = bits_of(x);
    c->origin[1] = bits_of(y);
    c->origin[2] = bits_of(z);
    in.values[in.shape.num_channels++] = values;
}

/* Vectors of `width` numbers to pairs; of tangents, which have 4, also the sign of the bitangent. */
static cq_result quantise_pairs(uint32_t bits, uint32_t width, const float *from, size_t count, cq_value *to)
{
    cq_result result = CQ_OK;
    for (size_t i = 0; i < count && result == CQ_OK; i++, from += width, to += width - 1) {
        result = cq_quantise_normals((int)bits, from, 1, to, &place);
        if (width == 4) to[2] = from[3] < 0;
        if (result != CQ_OK) place.vertex = (cq_index)i;
    }
    return result;
}

/* One more channel, of floats; with a step of 0 the grid is fitted to them. */
EXPORT("floats") int32_t add_floats(uint32_t kind, uint32_t components, uint32_t bits, uint32_t merge, float step,
                                    const float *from)
{
    const size_t count = merge == CQ_PER_FACE ? in.shape.num_faces : in.shape.num_vertices;
    const int is_pair = (kind == CQ_NORMAL || kind == CQ_TANGENT) && bits != CQ_EXACT_BITS;
    cq_channel *c = next_channel(kind, is_pair ? components - 1 : components, bits, merge);
    cq_value *to = (cq_value *)take((uint32_t)(count * components * sizeof *to));
    cq_result result = to ? CQ_OK : CQ_ERROR_MEMORY;
    c->step = bits_of(step);
    if (result == CQ_OK && bits != CQ_EXACT_BITS && !is_pair && step == 0)
        result = cq_fit_grid(c, from, count, &place);
    if (result == CQ_OK)
        result = is_pair ? quantise_pairs(bits, components, from, count, to)
                         : cq_quantise(c, from, count, to, &place);
    in.values[in.shape.num_channels++] = to;
    return result;
}

static void progress(void *user, uint32_t done, uint32_t total)
{
    (void)user;
    page_progress(done, total);
}

/* Memory as the shape asks for it, until that is enough: a second round has the boundaries as they were found. */
static cq_result encode_with(uint8_t *stream, size_t size)
{
    cq_result result = CQ_ERROR_MEMORY;
    for (int round = 0; round < 8 && result == CQ_ERROR_MEMORY; round++) {
        const uint64_t before = taken;
        const size_t bytes = cq_encoder_bytes(&in.shape);
        void *memory = bytes && bytes <= UINT32_MAX ? take((uint32_t)bytes) : NULL;
        if (!memory) return bytes ? CQ_ERROR_MEMORY : CQ_ERROR_TOO_LARGE;
        result = cq_encode(&in, memory, bytes, stream, size, &out.stream_size, &place, NULL);
        taken = before;
    }
    return result;
}

/* Encodes; the stream and where vertices and faces went are in the output. */
EXPORT("encode") int32_t encode(void)
{
    const size_t vertices = in.shape.num_vertices, faces = in.shape.num_faces;
    in.map = (cq_index *)take((uint32_t)(vertices * sizeof *in.map));
    in.face_map = (cq_index *)take((uint32_t)(faces * sizeof *in.face_map));
    if (!in.map || !in.face_map) return CQ_ERROR_MEMORY;
    in.progress = progress;
    out.map = (uintptr_t)in.map;
    out.face_map = (uintptr_t)in.face_map;
    size_t size = 1024 + 8 * vertices;
    cq_result result = CQ_ERROR_OUTPUT;
    for (int round = 0; round < 2 && result == CQ_ERROR_OUTPUT; round++) {
        uint8_t *stream = take((uint32_t)size);
        if (!stream) return CQ_ERROR_MEMORY;
        out.stream = (uintptr_t)stream;
        result = encode_with(stream, size);
        size = out.stream_size;
    }
    return result;
}
