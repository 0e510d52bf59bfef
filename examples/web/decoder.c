/* decoder.c - conquest.h as a WebAssembly module that decodes: one instance, one stream. SPDX-License-Identifier: MIT
 *
 * The page reads `web_state` and the arrays it points to. Memory grows once, when the header is read, and not after. What
 * a stream needs begins at HEAP in each variant of this module, so that one can go on where another has stopped. */
#define CQ_NO_ENCODER
#define CQ_NO_REPORTS
#define CQ_API static inline
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#define EXPORT(name) __attribute__((export_name(name)))
enum { PAGE = 65536, HEAP = 3 * PAGE, INPUT_BYTES = 65536, SHIFT = 6 };   /* a block has 2^SHIFT faces, or rows */

/* A channel, and its array: floats, or the values if they are whole numbers. */
typedef struct web_channel {
    uint32_t kind, components, bits, merge;
    float step, origin[CQ_MAX_COMPONENTS];
    void *array;
    uint32_t width;             /* numbers of the array for each row or face */
    uint32_t is_integer;
    uint32_t is_relative;       /* to the origin, as floats are too coarse for the sum */
    uint32_t moves;             /* do rows that move get other numbers? */
} web_channel;

/* Faces of a material that lie side by side. */
typedef struct web_group { uint32_t first, count, material; } web_group;

/* All that the page reads: uint32_t, pointers and floats of 4 bytes; conquest.js has the same order. */
typedef struct web_state {
    int32_t result;
    uint32_t bytes_used, num_rows, num_faces, total_rows, total_faces, level, error, num_vertices;
    uint32_t stream_bytes, num_channels, memory_bytes;
    uint32_t ready;             /* rows that the next update will find */
    uint32_t has_looked;
    uint32_t num_slots;         /* of the index, with those of materials that are free */
    uint32_t num_materials, num_groups;
    web_group *group;           /* of each material, whether it has faces or not; then of what is aside */
    cq_index *index;
    uint8_t *face_blocks, *row_blocks;
    uint8_t *metadata;
    uint32_t metadata_bytes;
    web_channel channel[CQ_MAX_CHANNELS];
} web_state;

static web_state state;
static cq_decoder decoder;
static cq_channel grid[CQ_MAX_CHANNELS];
static uint8_t input[INPUT_BYTES];
static cq_bytes waiting;

EXPORT("state") web_state *get_state(void) { return &state; }
EXPORT("input") uint8_t *get_input(void) { return input; }
EXPORT("message") const char *get_message(int32_t result) { return cq_result_string((cq_result)result); }

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t blocks_of(uint32_t count) { return (count + (1u << SHIFT) - 1) >> SHIFT; }

static uint32_t mesh_rows(const cq_shape *s) { return s->num_rows ? s->num_rows : s->num_vertices; }

/* Are the values themselves what a reader wants? */
static int is_integer(const cq_channel *c)
{
    const int whole = cq_channel_step(c) == 1 && !(c->origin[0] | c->origin[1] | c->origin[2] | c->origin[3]);
    return c->kind == CQ_JOINTS || c->kind == CQ_NUMBER || c->kind == CQ_GROUP || c->kind == CQ_TURNED
        || (c->kind == CQ_GENERIC && c->merge != CQ_AVERAGE && whole && c->bits != CQ_EXACT_BITS);
}

/* Is a step less than two floats apart, at the far end of the grid? 2^-23 is the distance of floats from 1 on. */
static int is_relative(const cq_channel *c)
{
    float far = 0;
    if (c->kind != CQ_POSITION || c->bits == CQ_EXACT_BITS) return 0;
    for (uint32_t k = 0; k < c->components; k++) {
        const float low = cq_channel_origin(c, (int)k), high = low + cq_channel_step(c) * (float)(1u << c->bits);
        if (far < __builtin_fabsf(low)) far = __builtin_fabsf(low);
        if (far < __builtin_fabsf(high)) far = __builtin_fabsf(high);
    }
    return far * 0x1p-23f > cq_channel_step(c);
}

static void describe(uint32_t k)
{
    const cq_channel *c = &decoder.shape.channel[k];
    web_channel *w = &state.channel[k];
    w->kind = c->kind;
    w->components = c->components;
    w->bits = c->bits;
    w->merge = c->merge;
    w->step = cq_channel_step(c);
    for (int i = 0; i < CQ_MAX_COMPONENTS; i++)
        w->origin[i] = cq_channel_origin(c, i);
    w->is_integer = (uint32_t)is_integer(c);
    w->is_relative = (uint32_t)is_relative(c);
    w->width = c->kind == CQ_NORMAL ? 3 : c->kind == CQ_TANGENT ? 4 : c->components;
    w->moves = decoder.shape.num_rows && c->merge != CQ_PER_FACE
        && c->kind != CQ_NORMAL && c->kind != CQ_TANGENT && c->kind != CQ_TEXCOORD && c->kind != CQ_COLOR;
    grid[k] = *c;
    if (w->is_relative)
        memset(grid[k].origin, 0, sizeof grid[k].origin);
}

static uint64_t array_bytes(uint32_t k)
{
    const web_channel *w = &state.channel[k];
    return (uint64_t)(w->merge == CQ_PER_FACE ? state.total_faces : state.total_rows) * w->width * sizeof(float);
}

/* Memory from HEAP on; NULL if the page does not give it. */
static uint8_t *grow(uint64_t bytes)
{
    const uint64_t pages = (HEAP + bytes + PAGE - 1) / PAGE, have = __builtin_wasm_memory_size(0);
    if (pages > 65536 || (pages > have && __builtin_wasm_memory_grow(0, (size_t)(pages - have)) == SIZE_MAX))
        return NULL;
    return (uint8_t *)HEAP;
}

/* Streams with rows or something aside. */
#ifdef CQ_NO_WEDGES
#define MAY_HAVE_ROWS 0
#else
#define MAY_HAVE_ROWS 1
#endif

/* Does the index buffer differ from the decoder's? */
static int has_own_index(const cq_shape *s)
{
    const int is_turned = s->num_channels && s->channel[s->num_channels - 1].kind == CQ_TURNED;
    return MAY_HAVE_ROWS && (s->num_aside_faces || is_turned);
}

static uint32_t num_groups(const cq_shape *s)
{
    return s->num_materials ? s->num_materials + s->num_aside_faces : 1;
}

static void carve(uint8_t *at, int own_index, uint32_t groups)
{
    state.group = (web_group *)(void *)at;
    memset(at, 0, groups * sizeof *state.group);
    at += groups * sizeof *state.group;
    for (uint32_t k = 0; k < state.num_channels; at += array_bytes(k), k++)
        state.channel[k].array = at;
    state.index = NULL;
    if (own_index) {
        state.index = (cq_index *)(void *)at;
        at += 3 * sizeof(cq_index) * state.total_faces;
    }
    state.face_blocks = at;
    state.row_blocks = at + blocks_of(state.total_faces);
    state.has_looked = 1;                                /* there may be anything in them */
}

/* Reads the header, of `size` bytes of input, and takes the memory for all that is to come. */
EXPORT("begin") int32_t begin(uint32_t size)
{
    cq_shape *shape = &decoder.shape;
    size_t header, stream;
    const cq_result result = cq_peek(input, size, shape, &header, &stream);
    if (result != CQ_OK) return state.result = result;
    const size_t own = cq_decoder_bytes(shape);
    const int own_index = has_own_index(shape);
    const uint32_t groups = num_groups(shape);
    state.stream_bytes = (uint32_t)stream;
    state.total_rows = mesh_rows(shape) + shape->num_aside_rows;
    state.total_faces = shape->num_faces + shape->num_aside_faces;
    state.num_channels = shape->num_channels;
    state.num_materials = shape->num_materials;
    state.metadata_bytes = shape->metadata_bytes;
    uint64_t bytes = (uint64_t)own + groups * (uint64_t)sizeof(web_group) + blocks_of(state.total_faces) + blocks_of(state.total_rows);
    if (own_index)
        bytes += (uint64_t)3 * sizeof(cq_index) * state.total_faces;
    for (uint32_t k = 0; k < shape->num_channels; k++) {
        describe(k);
        bytes += array_bytes(k);
    }
    state.memory_bytes = bytes > UINT32_MAX ? UINT32_MAX : (uint32_t)bytes;
    uint8_t *at = own ? grow(bytes) : NULL;
    if (!at) return state.result = CQ_ERROR_MEMORY;
    if (shape->num_materials) memset(at, 0, own);   /* slots that are free are no triangles, whoever draws them */
    cq_decoder_init(&decoder, at, own);         /* reads the header again: the shape is empty until then */
    carve(at + own, own_index, groups);
    cq_watch_faces(&decoder, SHIFT, state.face_blocks);
    return state.result = CQ_OK;
}

/* Says that `size` bytes of input are there; all before are used. */
EXPORT("give") void give(uint32_t size) { waiting = (cq_bytes){ input, size }; }

static uint32_t count_rows(void) { return decoder.vertex ? decoder.num_rows : decoder.mesh.num_vertices; }

/* Marks are of what has changed since the page looked, and are there until it decodes on. */
static void begin_marks(void)
{
    if (state.has_looked) memset(state.face_blocks, 0, blocks_of(state.total_faces) + blocks_of(state.total_rows));
    state.has_looked = 0;
}

static int32_t run(cq_bytes *from, uint32_t budget)
{
    begin_marks();
    state.result = cq_decode(&decoder, from, budget);
    state.ready = count_rows();
    return state.result;
}

/* Decodes what was given, at most `budget` steps. */
EXPORT("decode") int32_t decode(uint32_t budget)
{
    const size_t before = waiting.size;
    run(&waiting, budget);
    state.bytes_used += (uint32_t)(before - waiting.size);
    return state.result;
}

/* No more input will come. */
EXPORT("finish") int32_t finish(void) { return run(NULL, CQ_NO_LIMIT); }

/* Pairs, and for tangents the sign of the bitangent: 1 is negative. */
static void convert_pairs(const web_channel *w, const cq_value *from, uint32_t count, float *to)
{
    for (uint32_t i = 0; i < count; i++, from += w->components, to += w->width) {
        cq_reconstruct_normals((int)w->bits, from, 1, to);
        if (w->width == 4) to[3] = w->components == 3 && from[2] ? -1 : 1;
    }
}

/* Values to what the array has. */
static void convert(uint32_t k, const cq_value *from, uint32_t first, uint32_t count)
{
    const web_channel *w = &state.channel[k];
    float *to = (float *)w->array + (size_t)first * w->width;
    if (w->is_integer)
        memcpy(to, from, sizeof(cq_value) * count * w->width);
    else if (w->components < w->width)
        convert_pairs(w, from, count, to);
    else
        cq_reconstruct(&grid[k], from, count, to);
}

static void convert_rows(uint32_t k, uint32_t first, uint32_t end)
{
    cq_value block[(1 << SHIFT) * CQ_MAX_COMPONENTS];
    while (first < end) {
        const uint32_t count = least(end - first, 1u << SHIFT);
        cq_read_rows(&decoder, k, first, count, block);
        convert(k, block, first, count);
        first += count;
    }
}

/* A face aside, with its material: it goes to the last group, or begins one. */
static void append_face(uint32_t face, uint32_t material)
{
    web_group *g = &state.group[state.num_groups - 1];
    if (g->material != material || g->first + g->count != face)
        *(g = &state.group[state.num_groups++]) = (web_group){ face, 0, material };
    g->count++;
}

/* What is aside follows the mesh. */
static void append_aside(uint32_t faces, uint32_t rows)
{
    const cq_aside *aside = &decoder.aside;
    for (uint32_t k = 0; k < state.num_channels; k++)
        if (aside->channel[k] && state.channel[k].merge == CQ_PER_FACE)
            convert(k, aside->channel[k], faces, aside->num_faces);
        else if (aside->channel[k]) convert(k, aside->channel[k], rows, aside->num_rows);
    if (aside->num_faces)
        memcpy(state.index + 3 * (size_t)faces, aside->index, 3 * sizeof(cq_index) * aside->num_faces);
    for (uint32_t f = 0; f < aside->num_faces; f++) {
        append_face(faces + f, aside->material ? aside->material[f] : 0);
        state.face_blocks[(faces + f) >> SHIFT] = 1;
    }
    state.num_slots += aside->num_faces;
    state.num_faces += aside->num_faces;
    state.num_rows += aside->num_rows;
}

/* Copies the triangles of the blocks that have changed. */
static void copy_triangles(uint32_t faces)
{
    for (uint32_t b = 0; b << SHIFT < faces; b++) {
        const uint32_t first = b << SHIFT, left = faces - first;
        if (state.face_blocks[b])
            cq_read_triangles(&decoder, first, least(left, 1u << SHIFT), state.index + 3 * (size_t)first);
    }
}

static void update_rows(uint32_t k, uint32_t before, uint32_t rows)
{
    convert_rows(k, before, rows);
    for (uint32_t b = 0; MAY_HAVE_ROWS && state.channel[k].moves && b << SHIFT < before; b++)
        if (state.row_blocks[b]) convert_rows(k, b << SHIFT, least((b + 1) << SHIFT, before));
}

/* The faces of a material, and channels of those that are new. */
static void update_group(uint32_t m)
{
    web_group *g = &state.group[m];
    cq_index first, count;
    cq_material(&decoder, m, &first, &count);
    for (uint32_t k = 0, from = first + g->count; k < state.num_channels; k++)
        if (state.channel[k].merge == CQ_PER_FACE)
            convert(k, decoder.channel[k] + from, from, count - g->count);
    *g = (web_group){ first, count, m };
    state.num_faces += count;
}

static void update_groups(void)
{
    state.num_faces = 0;
    state.num_groups = state.num_materials ? state.num_materials : 1;
    for (uint32_t m = 0; m < state.num_groups; m++)
        update_group(m);
}

/* Brings arrays and counts up to date, and marks the blocks of faces that have changed and of rows that have moved. */
EXPORT("update") void update(void)
{
    const uint32_t rows = count_rows(), slots = decoder.mesh.num_faces;
    begin_marks();
    state.level = decoder.level;
    state.error = decoder.error;
    state.metadata = decoder.metadata;
    if (!rows && state.result != CQ_DONE) return;
    state.has_looked = 1;
    if (state.num_rows > rows || state.num_slots > slots) return;      /* what is aside is there already */
    cq_mesh_changes(&decoder.mesh, state.num_vertices, SHIFT, state.face_blocks);
    if (MAY_HAVE_ROWS)
        cq_moved_rows(&decoder, state.num_vertices, state.num_rows, SHIFT, state.row_blocks);
    for (uint32_t k = 0; k < state.num_channels; k++)
        if (state.channel[k].merge != CQ_PER_FACE) update_rows(k, state.num_rows, rows);
    update_groups();
    if (has_own_index(&decoder.shape)) copy_triangles(slots);
    else state.index = decoder.index;
    state.num_vertices = decoder.mesh.num_vertices;
    state.num_rows = rows;
    state.num_slots = slots;
    if (MAY_HAVE_ROWS && state.result == CQ_DONE) append_aside(slots, rows);
}
