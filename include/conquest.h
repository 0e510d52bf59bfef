/* conquest.h - progressive-to-lossless triangle mesh codec in fixed memory. Version 0.1.0.
 * SPDX-License-Identifier: MIT
 *
 * A stream starts with a coarse mesh and refines it, vertex split by vertex split, to the exact mesh that was encoded.
 * Any prefix of a stream is a valid mesh. All memory is the caller's: no allocation, no globals, no recursion, integers
 * only, nothing from libc but memcpy and memset.
 *
 *     #define CONQUEST_IMPLEMENTATION        in one C or C++ file
 *     #include "conquest.h"                  everywhere else without the define
 *
 *     static cq_decoder dec;                                   model tables, a few KiB
 *     static uint32_t memory[CQ_DECODER_BYTES(...) / 4];       mesh, positions, queue
 *
 *     cq_decoder_init(&dec, memory, sizeof memory);
 *     while ((n = read_some(bytes)) > 0) {
 *         cq_bytes in = { bytes, n };
 *         result = cq_decode(&dec, &in, CQ_NO_LIMIT);          any piece size, any budget of steps
 *         draw(dec.mesh.origin, dec.mesh.num_faces, dec.channel[0], dec.mesh.num_vertices);
 *     }
 *     if (result == CQ_NEED_INPUT) result = cq_decode(&dec, NULL, CQ_NO_LIMIT);   the last bytes of a cut stream
 *
 * Method: Hao, Paker, Pearmain, "Mesh Connectivity Compression for Progressive-to-Lossless Transmission" ("the paper"
 * below): levels of edge collapses inside patches that are found through gates; two indices per vertex split. SPEC.md
 * defines the bytes.
 *
 * Words
 *     patch        all triangles around one vertex, its centre
 *     gate         directed edge (L, R) on the border of a conquered patch; the next patch lies to its left
 *     front        the vertex A of the triangle L, R, A to the left of a gate
 *     conquered    the vertex belongs to a patch of this level already; else it is available
 *     isolated     a patch whose centre is not split at this level
 *     level        one conquest that covers the mesh with patches that do not overlap
 *     split (i, j) i: steps clockwise from L to the first common vertex; j: counter-clockwise from R to the second
 *     base         the mesh that is left when no level collapses anything more; the head of the stream
 *
 * Threads: distinct objects are independent. Objects hold pointers into the caller's memory: do not move either
 * while in use. Bytes are the same on every platform. */
#ifndef CQ_CONQUEST_H
#define CQ_CONQUEST_H

/* -- Configuration ------------------------------------------------------------------------------------------------- */

/* Width of vertex, face and halfedge numbers: 32, or 16 for small devices (up to 65 535 halfedges, about 10 900
 * vertices; 15-bit channel values; half the memory). Does not change the bytes of a stream. */
#ifndef CQ_INDEX_BITS
#define CQ_INDEX_BITS 32
#endif
#if CQ_INDEX_BITS != 16 && CQ_INDEX_BITS != 32
#error "CQ_INDEX_BITS must be 16 or 32"
#endif

/* Linkage of the functions: extern by default; `#define CQ_API static inline` keeps them private to one file. */
#ifndef CQ_API
#define CQ_API extern
#endif

/* Names for the linker. Those of 16-bit indices end in _16: files that do not agree on the width, hence on the layout of
 * structures, do not link; and one program may have both. */
#if CQ_INDEX_BITS == 16
#define CQI_SYMBOL(name) name##_16
#else
#define CQI_SYMBOL(name) name
#endif
#define cq_result_string CQI_SYMBOL(cq_result_string)
#define cq_mesh_bytes CQI_SYMBOL(cq_mesh_bytes)
#define cq_mesh_build CQI_SYMBOL(cq_mesh_build)
#define cq_mesh_check CQI_SYMBOL(cq_mesh_check)
#define cq_mesh_can_collapse CQI_SYMBOL(cq_mesh_can_collapse)
#define cq_mesh_collapse CQI_SYMBOL(cq_mesh_collapse)
#define cq_mesh_split CQI_SYMBOL(cq_mesh_split)
#define cq_mesh_triangles CQI_SYMBOL(cq_mesh_triangles)
#define cq_mesh_changes CQI_SYMBOL(cq_mesh_changes)
#define cq_range_encoder_init CQI_SYMBOL(cq_range_encoder_init)
#define cq_range_decoder_init CQI_SYMBOL(cq_range_decoder_init)
#define cq_encode_bit CQI_SYMBOL(cq_encode_bit)
#define cq_decode_bit CQI_SYMBOL(cq_decode_bit)
#define cq_encode_freq CQI_SYMBOL(cq_encode_freq)
#define cq_decode_slot CQI_SYMBOL(cq_decode_slot)
#define cq_decode_freq CQI_SYMBOL(cq_decode_freq)
#define cq_encode_raw CQI_SYMBOL(cq_encode_raw)
#define cq_decode_raw CQI_SYMBOL(cq_decode_raw)
#define cq_range_encoder_finish CQI_SYMBOL(cq_range_encoder_finish)
#define cq_peek CQI_SYMBOL(cq_peek)
#define cq_decoder_bytes CQI_SYMBOL(cq_decoder_bytes)
#define cq_decoder_init CQI_SYMBOL(cq_decoder_init)
#define cq_decode CQI_SYMBOL(cq_decode)
#define cq_encoder_bytes CQI_SYMBOL(cq_encoder_bytes)
#define cq_encode CQI_SYMBOL(cq_encode)
#define cq_fit_grid CQI_SYMBOL(cq_fit_grid)
#define cq_align_grid CQI_SYMBOL(cq_align_grid)
#define cq_quantise CQI_SYMBOL(cq_quantise)
#define cq_reconstruct CQI_SYMBOL(cq_reconstruct)
#define cq_quantise_normals CQI_SYMBOL(cq_quantise_normals)
#define cq_reconstruct_normals CQI_SYMBOL(cq_reconstruct_normals)

/* CQ_NO_ENCODER, if defined where the implementation is, leaves out cq_encode and cq_encoder_bytes: a device that
 * only decodes carries no byte of them. CQ_NO_REPORTS leaves out the filling of reports, CQ_NO_QUANTISER the functions
 * that use floating point. CQ_ASSERT(condition) may be defined there too, as assert for example: it checks each
 * precondition below that no result reports, and never what a stream contains. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* -- Versions and limits ------------------------------------------------------------------------------------------- */

#define CQ_VERSION_STRING "0.1.0"    /* of this library */
#define CQ_STREAM_VERSION 0          /* of the bitstream, SPEC.md; version 0 may still change between releases */

#define CQ_MAX_CHANNELS 8            /* channels of one stream */
#define CQ_MAX_COMPONENTS 4          /* integers per vertex of one channel */
#define CQ_EXACT_BITS 32             /* `bits` of a channel whose values are any 32-bit patterns, as of floats */
#define CQ_MAX_VALENCE 24            /* valence of a centre that may be split, hence of a collapsed vertex */
#define CQ_MAX_LEVELS 255            /* levels of one stream */
#define CQ_MAX_HEADER_BYTES 256      /* a header is never longer */
#define CQ_NO_LIMIT 0xffffffffu      /* a budget that never runs out */

/* -- Results ------------------------------------------------------------------------------------------------------- */

/* Zero and above: the mesh is valid. Below zero: an error; what had been decoded before it stays valid. */
typedef enum cq_result {
    CQ_OK = 0,                   /* done; of a decoder: the budget is spent, there is more to refine */
    CQ_NEED_INPUT = 1,           /* all bytes given are used, the stream goes on */
    CQ_DONE = 2,                 /* the mesh is complete: the one that was encoded */
    CQ_TRUNCATED = 3,            /* the input ended early: the mesh is a coarser one, valid, and final */
    CQ_ERROR_ARGUMENT = -1,      /* a NULL pointer or a number outside its documented range */
    CQ_ERROR_MEMORY = -2,        /* the memory handed in is too small or misaligned; the shape tells what is needed */
    CQ_ERROR_OUTPUT = -3,        /* the output buffer is full */
    CQ_ERROR_TOO_LARGE = -4,     /* more vertices or faces than cq_index can number */
    CQ_ERROR_INDEX = -5,         /* mesh: a face names a vertex that does not exist */
    CQ_ERROR_FACE = -6,          /* mesh: a face names one vertex twice */
    CQ_ERROR_EDGE = -7,          /* mesh: an edge has more than two faces */
    CQ_ERROR_ORIENTATION = -8,   /* mesh: two faces run along an edge in the same direction */
    CQ_ERROR_VERTEX = -9,        /* mesh: the faces around a vertex are not one fan */
    CQ_ERROR_UNUSED = -10,       /* mesh: a vertex belongs to no face */
    CQ_ERROR_VALUE = -11,        /* a channel value outside 0 .. 2^bits - 1, or a float that has none */
    CQ_ERROR_FORMAT = -12,       /* stream: not a conquest stream */
    CQ_ERROR_VERSION = -13,      /* stream: a version that this library does not know */
    CQ_ERROR_UNSUPPORTED = -14,  /* a feature that this build does not know or is too small for */
    CQ_ERROR_CORRUPT = -15,      /* stream: bytes that no encoder writes */
    CQ_ERROR_CHECKSUM = -16      /* stream: the check value does not match */
} cq_result;

/* One English phrase for a result; never NULL. */
CQ_API const char *cq_result_string(cq_result result);

/* -- Types --------------------------------------------------------------------------------------------------------- */

#if CQ_INDEX_BITS == 16
typedef uint16_t cq_index;           /* number of a vertex, face or halfedge */
typedef int16_t cq_value;            /* one integer of a channel: 0 .. 2^15 - 1 */
#define CQ_NONE ((cq_index)0xffffu)  /* no vertex, face or halfedge */
#define CQ_MAX_BITS 15
#else
typedef uint32_t cq_index;
typedef int32_t cq_value;            /* one integer of a channel: 0 .. 2^24 - 1, or any with CQ_EXACT_BITS */
#define CQ_NONE ((cq_index)0xffffffffu)
#define CQ_MAX_BITS 24
#endif

/* Where a mesh error is. Fields that the error does not concern are CQ_NONE. */
typedef struct cq_place {
    cq_index face;        /* CQ_ERROR_INDEX, _FACE, _EDGE, _ORIENTATION: the face, in input order */
    cq_index vertex;      /* the vertex, or the edge's first vertex */
    cq_index other;       /* CQ_ERROR_EDGE, _ORIENTATION: the edge's second vertex */
} cq_place;

/* What a channel's numbers mean to a reader of the stream. Only positions mean something to the codec: the first
 * channel of them that is merged to midpoints tells where edges were collapsed. */
typedef enum cq_kind {
    CQ_POSITION = 0,      /* 3 components */
    CQ_GENERIC = 1,       /* anything else */
    CQ_NORMAL = 2,        /* 2 components, an octahedral pair; or 3, a vector */
    CQ_TEXCOORD = 3,      /* 2 components */
    CQ_COLOR = 4,         /* 3 components, red, green, blue; or 4, with alpha */
    CQ_JOINTS = 5,        /* of skinning: numbers of the joints */
    CQ_WEIGHTS = 6,       /* and their weights */
    CQ_NUMBER = 7,        /* 1 component: the vertex's or face's own number somewhere else */
    CQ_GROUP = 8          /* 1 component: the material or group that it belongs to */
} cq_kind;

/* What a collapse of B into A does to the values of A. */
typedef enum cq_merge {
    CQ_MIDPOINT = 0,      /* the merged vertex gets the midpoint, rounded down */
    CQ_KEEP = 1,          /* it keeps the values of A: for what may not be averaged */
    CQ_PER_FACE = 2       /* nothing: the channel has 1 component, and a value for each face instead of each vertex */
} cq_merge;

/* One channel: `components` integers per vertex or face, each in 0 .. 2^bits - 1. A reader gets component k of vertex v
 * back as origin[k] + step * value, both IEEE 754 binary32 bit patterns that the codec only carries.
 *
 * With CQ_EXACT_BITS and CQ_KEEP or CQ_PER_FACE a value is any 32-bit pattern, copied into a cq_value, and comes back
 * bit for bit. It costs least if it is a float. Needs 32-bit indices, else CQ_ERROR_UNSUPPORTED. */
typedef struct cq_channel {
    uint8_t kind;         /* cq_kind */
    uint8_t components;   /* 1 .. CQ_MAX_COMPONENTS, as its kind says */
    uint8_t bits;         /* 1 .. CQ_MAX_BITS, or CQ_EXACT_BITS */
    uint8_t merge;        /* cq_merge */
    uint32_t step;
    uint32_t origin[CQ_MAX_COMPONENTS];
} cq_channel;

/* Counts that decide how much memory a mesh needs, and the channels. */
typedef struct cq_shape {
    uint32_t num_vertices;
    uint32_t num_faces;
    uint32_t num_boundary_loops;
    uint32_t num_boundary_edges;     /* sum of the lengths of the loops */
    uint32_t fast;                   /* 0, or 1: simpler models of connectivity and values; decodes twice as fast, from
                                        3 to 12 % more bytes */
    uint32_t num_channels;           /* 0 .. CQ_MAX_CHANNELS */
    cq_channel channel[CQ_MAX_CHANNELS];
} cq_shape;

/* -- Mesh ----------------------------------------------------------------------------------------------------------
 *
 * Indexed halfedges. Face f owns halfedges 3f, 3f+1, 3f+2; halfedge h runs from origin[h] to origin[cq_next(h)], with
 * its face on the left (counter-clockwise faces). `origin` is the index buffer: cq_index[3 * num_faces].
 *
 * The mesh is always closed: each boundary loop is closed by one virtual vertex, fanned to the loop. Virtual
 * vertices are numbered first_virtual .. first_virtual + num_virtual - 1 and their faces first_virtual_face ..
 * first_virtual_face + num_virtual_faces - 1, behind room for all real ones, so that real vertices and faces are 0
 * .. n-1 at every level.
 *
 * A collapse frees one vertex and two faces; their slots have out[v] == CQ_NONE, origin[3f] == CQ_NONE and are reused
 * last in, first out. A decoder never collapses: its vertices and faces have no gaps.
 *
 * Invariants (cq_mesh_check): twin[twin[h]] == h != twin[h]; origin[next(twin[h])] == origin[h]; all halfedges from
 * a vertex form one cycle of valence[v] >= 2 (virtual: 3) that contains out[v]; no edge joins the same two vertices
 * twice; no two virtual vertices share an edge or a real neighbour. */
typedef struct cq_mesh {
    cq_index *origin;     /* cq_index[3 * all faces] */
    cq_index *twin;       /* cq_index[3 * all faces] */
    cq_index *out;        /* cq_index[all vertices], a halfedge that starts at the vertex */
    cq_index *valence;    /* cq_index[all vertices], number of neighbours, virtual ones included */
    uint8_t *mark;        /* uint8_t[all vertices], scratch of the operations, zero between them */
    cq_index num_vertices, num_faces;                 /* slots, real, free ones included */
    cq_index num_virtual, num_virtual_faces;          /* slots, virtual, free ones included */
    cq_index first_virtual, first_virtual_face;       /* capacity of the real ones */
    cq_index max_virtual, max_virtual_faces;          /* capacity of the virtual ones */
    cq_index free_vertex, free_face, free_virtual_face;  /* heads of the free lists, or CQ_NONE */
} cq_mesh;

/* A number of bytes, which may be more than a size_t of 16 bits can say. */
#if SIZE_MAX < 0xffffffffu
typedef uint32_t cqi_size;
#else
typedef size_t cqi_size;
#endif

/* Bytes of memory for a mesh: v vertices + boundary loops, f faces + boundary edges. A multiple of 4. */
#define CQ_MESH_BYTES(v, f) (CQI_ROUND(((cqi_size)(v) * 2 + (cqi_size)(f) * 6) * sizeof(cq_index) + (cqi_size)(v)))
#define CQI_ROUND(n) (((n) + 3) / 4 * 4)

/* The same for a shape; 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_mesh_bytes(const cq_shape *shape);

/* Builds a mesh from triangles.
 *
 * shape    in: num_vertices, num_faces. out: num_boundary_loops, num_boundary_edges as found (also on CQ_ERROR_MEMORY).
 * indices  cq_index[3 * num_faces], values 0 .. num_vertices - 1, counter-clockwise. Halfedge h starts at indices[h].
 * memory   cq_mesh_bytes(shape) bytes with the shape that comes out, aligned to 4. A closed mesh needs no second try:
 *          start with loops and edges 0, and on CQ_ERROR_MEMORY hand in cq_mesh_bytes(shape).
 * place    where the input is not an oriented 2-manifold; may be NULL.
 *
 * Any genus, number of components and of boundary loops. Returns CQ_OK, CQ_ERROR_MEMORY, _TOO_LARGE, _ARGUMENT or
 * the mesh errors CQ_ERROR_INDEX .. CQ_ERROR_UNUSED. Time O(vertices + faces). */
CQ_API cq_result cq_mesh_build(cq_mesh *mesh, cq_shape *shape, const cq_index *indices, void *memory,
                               size_t memory_size, cq_place *place);

/* Checks every invariant of the mesh in time O(vertices + faces), for any contents of its arrays and counts; uses
 * mark[] meanwhile. CQ_OK, or CQ_ERROR_INDEX, _FACE, _EDGE, _VERTEX with the place. */
CQ_API cq_result cq_mesh_check(const cq_mesh *mesh, cq_place *place);

/* 1 if halfedge h can be collapsed: both ends real, the link condition holds (the ends have exactly two common
 * neighbours, each of valence 4 or more), no two boundaries touch, and the valences of both ends and of the merged
 * vertex are at most max_valence. */
CQ_API int cq_mesh_can_collapse(const cq_mesh *mesh, cq_index h, cq_index max_valence);

/* Collapses halfedge h = A -> B: B's other edges go to A, B and the two faces at h are freed.
 *
 *            p                      p          h must satisfy cq_mesh_can_collapse.
 *          / | \                    |          p = origin[prev(h)] lies to the left of A -> B.
 *        --A-h>B--       =>       --A--        Ring of A clockwise: p, neighbours of B, q, neighbours of A.
 *          \ | /                    |          first = A -> p, last = A -> q: spokes that split it again.
 *            q                      q                                                                         */
CQ_API void cq_mesh_collapse(cq_mesh *mesh, cq_index h, cq_index *first, cq_index *last);

/* Splits vertex A = origin[first] = origin[last]: a new vertex B takes A's neighbours strictly clockwise between the
 * spokes `first` and `last`, and both keep the two spokes' ends, first != last. Undoes the last collapse that has not
 * been undone: each vertex and face gets its slot back, but a face may start at another corner and out[] may be another
 * spoke, so halfedges kept from before are stale: keep A and the spokes' ends.
 * Returns B, or CQ_NONE if the mesh is full or A is virtual. */
CQ_API cq_index cq_mesh_split(cq_mesh *mesh, cq_index first, cq_index last);

/* Writes the real triangles in slot order, skipping free slots: cq_index[3 * n]; returns n <= num_faces. */
CQ_API size_t cq_mesh_triangles(const cq_mesh *mesh, cq_index *triangles);

/* Marks what a decoder has changed since its mesh had `since` vertices, so that only that is uploaded to a GPU: 0 marks
 * all. Arrays are divided into blocks of 2^shift elements, for a split touches two vertices and about eight faces
 * anywhere in them; 1 is written for a block that has changed, other bytes stay as they are.
 *
 * faces     uint8_t[blocks], NULL: unwanted. Of faces that are new or have got a new vertex; face f is the indices
 *           origin[3 * f] .. [3 * f + 2].
 * vertices  uint8_t[blocks], NULL: unwanted. Of vertices that are new or have got new values, and of the other
 *           neighbours of new vertices.
 *
 * Time O(new vertices), a few faces for each. */
CQ_API void cq_mesh_changes(const cq_mesh *mesh, cq_index since, int shift, uint8_t *faces, uint8_t *vertices);

/* -- Range coder ---------------------------------------------------------------------------------------------------
 *
 * Byte-wise, 32-bit range, carry handled; usable alone. The encoder counts bytes beyond its buffer instead of writing
 * them. The decoder reads zeros beyond its input and counts them. Both run the same models and spend the same bits. */
typedef struct cq_range_encoder {
    uint64_t low;         /* low end of the interval, 33 bits with the carry */
    uint32_t range;       /* its width, > 2^24 after each call */
    uint8_t *data;        /* may be NULL if size is 0 */
    size_t size;          /* capacity of data */
    size_t count;         /* bytes produced, also those that did not fit */
    size_t zeros;         /* of these, zero bytes at the end */
    size_t pending;       /* 0xff bytes that wait for a carry */
    int cache;            /* the byte before them, -1 at the start */
} cq_range_encoder;

typedef struct cq_range_decoder {
    uint32_t code;        /* offset of the value in the interval, < range */
    uint32_t range;
    uint32_t slot;        /* width of one of the slots that cq_decode_slot made */
    const uint8_t *data;
    size_t size;
    size_t count;         /* bytes read; above size: the stream was too short */
} cq_range_decoder;

typedef uint16_t cq_bit_model;       /* probability of a 1 in 1/65536, kept in 32 .. 65504 */
#define CQ_BIT_MODEL_INIT 32768u

CQ_API void cq_range_encoder_init(cq_range_encoder *e, uint8_t *data, size_t size);
CQ_API void cq_range_decoder_init(cq_range_decoder *d, const uint8_t *data, size_t size);

/* Codes one bit, 0 or anything else, with an adaptive model; both sides must use the same rate 1 .. 8 (higher is
 * slower) per call. */
CQ_API void cq_encode_bit(cq_range_encoder *e, cq_bit_model *model, int rate, int bit);
CQ_API int cq_decode_bit(cq_range_decoder *d, cq_bit_model *model, int rate);

/* Codes a symbol that owns `freq` > 0 of `total` <= 2^24 slots (up to 2^16 lose nothing), from slot `start`. The
 * decoder first asks for the slot, looks up the symbol, and then takes it. */
CQ_API void cq_encode_freq(cq_range_encoder *e, uint32_t start, uint32_t freq, uint32_t total);
CQ_API uint32_t cq_decode_slot(cq_range_decoder *d, uint32_t total);
CQ_API void cq_decode_freq(cq_range_decoder *d, uint32_t start, uint32_t freq, uint32_t total);

/* Codes the low `bits` 0 .. 32 of a value, all equally likely. */
CQ_API void cq_encode_raw(cq_range_encoder *e, uint32_t value, int bits);
CQ_API uint32_t cq_decode_raw(cq_range_decoder *d, int bits);

/* Ends the code with as few bytes as a decoder needs that reads zeros beyond them; returns e->count. The data is
 * complete if that is <= size. */
CQ_API size_t cq_range_encoder_finish(cq_range_encoder *e);

/* -- Reports -------------------------------------------------------------------------------------------------------
 *
 * Encoder and decoder fill the same report, if given one. Costs are in 1/65536 bit; the parts add up to the stream. */
typedef struct cq_level {
    uint32_t num_vertices;           /* real vertices after the level is refined */
    uint32_t num_patches;            /* patches conquered */
    uint32_t num_splits;             /* of these, split; the others are isolated */
    uint32_t sum_i, sum_j;           /* of the indices of all splits */
    uint64_t flags, indices, values; /* cost */
} cq_level;

typedef struct cq_report {
    cq_shape shape;
    uint32_t num_components;
    uint32_t num_levels;
    uint32_t base_vertices, base_faces;                        /* real */
    uint64_t header, base, flags, indices, positions, channels;  /* cost; sum = 65536 * 8 * bytes */
    size_t bytes;                    /* of the stream */
    cq_level level[CQ_MAX_LEVELS];   /* coarsest first */
} cq_report;

/* -- Private types: their sizes are public, their contents are not ------------------------------------------------- */

/* Bytes that one step can need. Probabilities of bits and candidates are at least 2^-11 and 2^-22. A residual has 10
 * such bits and 29 raw ones, if exact 35: 145 bits, 1 more than here; of a fast stream less. The two face values of a
 * split have 6 and 64. A join of the base has 3 and 32; a split does not need 36 of its bits, more than one for each of
 * 32 components. */
#define CQI_STEP_BYTES(components) (9 + 18 * (size_t)(components))

/* Input that waits for its step, or a header. So large that when it is full and less than a step is left, that is less
 * than half, and moves to the start without overlap. */
#define CQI_BUFFER_BYTES (2 * CQI_STEP_BYTES(CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS))

#define CQI_CANDIDATES (CQ_MAX_VALENCE * (CQ_MAX_VALENCE - 1) / 2)
#define CQI_LOCATED 63               /* of them, at most: what bounds the time of a split */

/* A conquest in progress: the list of patches is the queue of gates too. */
typedef struct cqi_walk {
    cq_index seed;        /* next component to look for: a vertex (decoder) or its number (encoder) */
    cq_index head;        /* patch whose gates are being tried */
    cq_index tail;        /* patches found so far */
    cq_index spoke;       /* of patch `head`: the next gate is behind it, clockwise; CQ_NONE: head has not begun */
} cqi_walk;

typedef struct cqi_vector {
    int32_t x, y, z;
} cqi_vector;

/* In the plane of a patch. */
typedef struct cqi_point {
    int32_t x, y;
} cqi_point;

/* tan(angle / 2) and sin(angle), times 2^CQI_TURN_BITS, |angle| <= 90 degrees. */
typedef struct cqi_turn {
    int32_t tangent, sine;
} cqi_turn;

/* State of a ring vertex: how many patches that wait hold it, and whether one that was left did. */
enum { CQI_FREE, CQI_FREE_LEFT, CQI_HELD, CQI_HELD_LEFT, CQI_HELD_OFTEN, CQI_NEVER, CQI_STATES };

/* A candidate that the positions are asked about: entries of the tables of the same names. */
typedef struct cqi_located {
    uint16_t number;                           /* of the candidate */
    uint8_t p, q;
    uint8_t edges, outer, between;
} cqi_located;

/* The patch of a centre, from its entry spoke clockwise. */
typedef struct cqi_ring {
    int size;
    int side;                                  /* 0: any candidate; 1: q is the last; 2: p is the first */
    int level_class;                           /* 0: the finest level, 1: the next one, 2: coarser */
    int located;                               /* candidates are asked about with positions */
    cq_index spoke[CQ_MAX_VALENCE];
    cq_index vertex[CQ_MAX_VALENCE];           /* its end */
    cq_index seen[CQ_MAX_VALENCE];             /* the same, but the centre if that is virtual: whose values count */
    uint8_t valence[CQ_MAX_VALENCE];           /* of the vertex, at most CQI_LARGE_VALENCE */
    uint8_t state[CQ_MAX_VALENCE];             /* who else holds the vertex: CQI_STATES values */
    uint8_t edge[CQ_MAX_VALENCE];              /* class of the length of the spoke */
    uint8_t real[CQ_MAX_VALENCE + 1];          /* number of real vertices before a vertex */
    uint8_t best_before[CQ_MAX_VALENCE];       /* smallest valence of an alternative to B at or before p; plus p */
    uint8_t best_after[CQ_MAX_VALENCE];        /* at or after q; plus CQ_MAX_VALENCE - q */
    uint32_t offset_channel;                   /* channel of the next two, CQ_MAX_CHANNELS: none yet */
    int32_t before[(CQ_MAX_VALENCE + 1) * CQ_MAX_COMPONENTS];  /* sums of the offsets (values less those of the centre)
                                                  before a vertex, [vertex][component] */
    uint32_t spread[CQ_MAX_COMPONENTS];        /* sums of their magnitudes */
    uint16_t entry[CQ_MAX_VALENCE][3];         /* features as an end of B's part, for p; for q the next ones */
    int32_t of_p[CQ_MAX_VALENCE];              /* length of the spoke; then the sum of the weights of those for p, */
    int32_t of_q[CQ_MAX_VALENCE];              /* of those for q, */
    int32_t of_steps[CQ_MAX_VALENCE];          /* and for q - p */
    uint8_t apart[CQ_MAX_VALENCE];             /* class of q - p, times 8 */
    int shift;                                 /* the scale of what follows: offsets times 2^shift */
    int32_t mean_length;                       /* of the spokes */
    int32_t displacement[CQ_MAX_VALENCE];      /* what makes a predicted B - A relative to the edges, by q - p */
    union {
        int32_t gain[3][CQ_MAX_VALENCE];       /* what the weights of p, q, q - p learn; before that: */
        int32_t scaled[3 * CQ_MAX_VALENCE];    /* positions, the largest component with 8 bits */
    } now;
    cqi_turn turn[2];                          /* that make the normal of the patch the z axis */
    int32_t height;                            /* sum of the distances from the plane */
    cqi_point sum[CQ_MAX_VALENCE + 1];         /* in the plane: of the offsets before a vertex */
    cqi_point direction[CQ_MAX_VALENCE + 2];   /* that of vertex k - 1, spokes are 64 long; the ends are there twice */
} cqi_ring;

/* Adaptive weights of the split model, in 2^-CQI_UNIT octaves: at most 8 octaves, which is seen to after every 1024
 * splits. Until then a weight moves by at most 1024 CQI_STEP, so that the sum of a candidate's 12 does not overflow. */
#define CQI_UNIT 22
#define CQI_MOST ((int32_t)8 << CQI_UNIT)
#define CQI_LIMIT_EVERY 1024

/* Patches whose memory is asked for before their turn, and vertices from which on that pays; the fuzzers have it pay at
 * once. And halfedges between one that is read and the one that is asked for with it: six lines of memory. */
#define CQI_AHEAD 8
#define CQI_APART 96
#ifndef CQI_LARGE_MESH
#define CQI_LARGE_MESH 32768
#endif
#if defined(__GNUC__) && SIZE_MAX > 0xffffffff
#define CQI_FETCHES 1
#define CQI_FETCH(address) __builtin_prefetch(address)
#else
#define CQI_FETCHES 0
#define CQI_FETCH(address) ((void)(address))
#endif
#define CQI_FETCH_HALFEDGE(m, h) (CQI_FETCH((m)->twin + (h)), CQI_FETCH((m)->origin + (h)))
#define CQI_FETCH_VALUE(s, values, v) \
    (cqi_has_first_values(s) ? CQI_FETCH((values) + (size_t)(v) * (s)->channel[0].components) : (void)0)

/* Indices of tables in one array. */
enum {
    CQI_SIZE_B = 0,                                          /* [level class][q - p] */
    CQI_SIZE_A = CQI_SIZE_B + 3 * 16,                        /* [level class][size - (q - p)] */
    CQI_END_STATE = CQI_SIZE_A + 3 * 16,                     /* [valence][state][p or q] */
    CQI_END_VALENCE = CQI_END_STATE + 14 * 6 * 2,            /* [level class][valence][p or q] */
    CQI_END_EDGE = CQI_END_VALENCE + 3 * 14 * 2,             /* [length of the spoke, 0 without positions][p or q] */
    CQI_FAST_WEIGHTS = CQI_END_EDGE + 16 * 2,                /* from here on not in fast streams: */
    CQI_RULE = CQI_FAST_WEIGHTS,                             /* [alternatives before p][after q] */
    CQI_BARE_WEIGHTS = CQI_RULE + 36,                        /* and from here on only with positions: */
    CQI_EDGES = CQI_BARE_WEIGHTS,                            /* [length of the spoke to p, halved][to q] */
    CQI_OUTER = CQI_EDGES + 8 * 8,                           /* [how far B - A goes to p - 1][to q + 1] */
    CQI_BETWEEN = CQI_OUTER + 8 * 8,                         /* [steps from p to q][angle between their spokes] */
    CQI_WEIGHTS = CQI_BETWEEN + 8 * 8
};

/* Expected bits of a residual that are told apart, in half bits; beyond them by parity. */
#define CQI_EXPECTED 16

/* Spreads of values on a ring that fast streams tell apart: half bits, and 16 more of exact values; 66 at most. */
#define CQI_SPREADS 69

/* Adaptive bits. Indices of tables in one array. */
enum {
    CQI_COMPONENT = 0,                        /* base: another component follows */
    CQI_LOOP,                                 /* base: a new vertex is virtual */
    CQI_OTHER_LEVEL,                          /* a level is not of the one known type */
    CQI_SIDE,                                 /* [2] which of the three cases of a first gate */
    CQI_KIND_GROW = CQI_SIDE + 2,             /* [faces at u][at w] base: the kind of a gate */
    CQI_KIND_TURN = CQI_KIND_GROW + 64,       /* [faces at u] */
    CQI_KIND_CLOSE = CQI_KIND_TURN + 8,       /* [faces at w] */
    CQI_FLAG = CQI_KIND_CLOSE + 8,            /* [available ring vertices][valence] a patch is split */
    CQI_OF_BASE = CQI_FLAG + 4 * 12,          /* residuals of base values */
    CQI_ALONG = CQI_OF_BASE + 44,             /* of splits, along the predicted displacement, */
    CQI_ACROSS = CQI_ALONG + 28 + 16 * CQI_EXPECTED,    /* across it, */
    CQI_NORMAL = CQI_ACROSS + 28 + 16 * CQI_EXPECTED,   /* along the normal, */
    CQI_FAST = CQI_NORMAL + 28 + 16 * CQI_EXPECTED,     /* [fraction of mean_bits][8] of fast streams: more bits */
    CQI_PRIORS = CQI_FAST + 4 * 8,
    CQI_PLAIN = CQI_PRIORS,                             /* of one component alone; these begin as CQI_ALONG */
    CQI_FACE = CQI_PLAIN + 28 + 16 * CQI_EXPECTED,      /* [values refused][faces with it] value of a face: this one */
    CQI_MODELS = CQI_FACE + 12,
    CQI_SIGN = 0,                             /* tables for each of these: */
    CQI_TOP = 1,                              /* [bits] the second highest bit */
    CQI_BITS = 28                             /* [expected][16] number of bits: fewer?, how many more, how many less */
};

/* Everything that adapts. */
typedef struct cqi_model {
    cq_bit_model bit[CQI_MODELS];
    int32_t weight[CQI_WEIGHTS];
    uint16_t mean_bits[CQI_SPREADS];          /* of residuals of fast streams, in 1/256 */
} cqi_model;

/* -- Decoder ------------------------------------------------------------------------------------------------------- */

/* A piece of input: cq_decode advances data and shrinks size by what it has used. */
typedef struct cq_bytes {
    const uint8_t *data;
    size_t size;
} cq_bytes;

/* Reads the header at the start of a stream. CQ_OK and the shape; CQ_NEED_INPUT if `size` bytes are not all of it;
 * or an error. CQ_MAX_HEADER_BYTES are always enough. header_bytes and stream_bytes may be NULL. */
CQ_API cq_result cq_peek(const uint8_t *data, size_t size, cq_shape *shape, size_t *header_bytes, size_t *stream_bytes);

/* Bytes of memory for a decoder beside sizeof(cq_decoder): v vertices + boundary loops, f faces + boundary edges,
 * c components of all channels of vertices together. Each channel of faces needs CQ_FACE_BYTES(faces) more. */
#define CQ_DECODER_BYTES(v, f, c) \
    (CQ_MESH_BYTES(v, f) + CQI_ROUND(((cqi_size)(f) / 3 + 1) * sizeof(cq_index)) \
     + CQI_ROUND((cqi_size)(v) * (cqi_size)(c) * sizeof(cq_value)))
#define CQ_FACE_BYTES(f) CQI_ROUND((cqi_size)(f) * sizeof(cq_value))

/* The same for a shape; 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_decoder_bytes(const cq_shape *shape);

/* Public fields, for reading: shape and mesh and channel once the header is read; mesh.num_vertices and mesh.num_faces
 * grow with each split. The rest is private. */
typedef struct cq_decoder {
    cq_shape shape;                        /* of the full mesh */
    cq_mesh mesh;                          /* of this moment; mesh.origin is the index buffer */
    cq_value *channel[CQ_MAX_CHANNELS];    /* channel k: cq_value[num_vertices][components], vertex buffers; with
                                              CQ_PER_FACE cq_value[num_faces], in the order of the faces in origin */
    uint32_t level;                        /* levels begun; level - 1 of them are complete, all at CQ_DONE */
    uint32_t num_components;               /* of the mesh, once the base is read */
    cq_report *report;                     /* NULL, or set by the caller after init: filled while decoding */

    /* private */
    cq_result status;                      /* CQ_OK, or the permanent result */
    int phase;
    cq_mesh draft;                         /* the mesh while the base is read */
    uint8_t *memory;
    size_t memory_size;
    struct cqi_plan *plan;                 /* NULL, or what the encoder chose: then this object writes */
    uint8_t buffer[CQI_BUFFER_BYTES];
    size_t payload_left, payload_size;     /* bytes not yet in the buffer; of the whole payload */
    size_t step_bytes;                     /* input that one step may need */
    size_t dropped;                        /* bytes that have left the buffer */
    uint32_t crc, expected_crc;            /* of the payload: so far, and in the header */
    int ended;                             /* the caller has no more input */
    cq_range_decoder range;
    cq_index gate, before, before2;        /* base: the border halfedge to grow at, and the two before it */
    cq_index scan, virtual_scan;           /* base: all halfedges before these are closed */
    cq_index value;                        /* base: next vertex, then next face, to get its values */
    cq_index base_vertices;
    int32_t delta[CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS];  /* of the split being read: B - A */
    int rate;                              /* of adaptation of the bit models */
    cq_index *patch;                       /* entry spokes of the level's patches */
    cq_index splits;                       /* patches of this level that are split */
    uint32_t level_end;                    /* vertices when the level is complete */
    cqi_walk walk;
    cq_index ahead[CQI_AHEAD];             /* spokes of the patches that come next, see cqi_look_ahead */
    cqi_ring ring;
    int32_t score[CQI_CANDIDATES];         /* of the candidates, by q, then p; then their shares, then what they lose */
    uint8_t rule[CQI_CANDIDATES];          /* their entries in the table of that name */
    cqi_located located[CQI_LOCATED + 1];  /* the last one is scratch */
    int num_located;
    uint64_t cost;                         /* where the last report entry ended */
    cqi_model model;
} cq_decoder;

/* Prepares a decoder. memory: aligned to 4, contents need not be initialised; it is carved up when the header has been
 * read, and must hold cq_decoder_bytes of the shape. Returns CQ_OK or CQ_ERROR_ARGUMENT. */
CQ_API cq_result cq_decoder_init(cq_decoder *d, void *memory, size_t memory_size);

/* Decodes until the input or the budget is used up.
 *
 * in       the next piece of the stream, of any size; advanced past the bytes used, which need not be kept. Bytes
 *          behind the end of the stream are not used. NULL: no more input will come.
 * budget   at most so many steps; a step reads one face or vertex of the base, conquers one patch, makes one split, or
 *          gets 1024 vertices ready for a level. Budget 1 stops after every split.
 *
 * Returns CQ_OK (budget spent), CQ_NEED_INPUT, CQ_DONE, CQ_TRUNCATED (only for in == NULL) or an error;
 * CQ_ERROR_MEMORY if the shape needs more than was given. Errors and CQ_TRUNCATED are permanent. Before the base is
 * complete the mesh has no vertices. Time O(bytes + steps), and once O(max vertices) for the header and O(vertices)
 * for the base; no recursion. */
CQ_API cq_result cq_decode(cq_decoder *d, cq_bytes *in, uint32_t budget);

/* -- Encoder ------------------------------------------------------------------------------------------------------- */

/* What a collapse is chosen for; without positions that move to midpoints, all are CQ_LEAST_CONNECTIVITY. The stream is
 * of the same format, and decodes as fast. Of streams that stop early CQ_BALANCED shows two to three times as much as
 * CQ_LEAST_CONNECTIVITY (in distance from the exact mesh), CQ_BEST_LOOKING three times; for 1 and 3 % more bytes, and
 * encoding takes about 1.4 and 1.5 times as long. */
typedef enum cq_goal {
    CQ_BALANCED = 0,      /* features of the surface go last; of what may go the smallest valence, then the nearest */
    CQ_SMALLEST,          /* the smallest valence, then the nearest: positions cost least, and mostly the stream */
    CQ_BEST_LOOKING,      /* as CQ_BALANCED, but finer features count, too */
    CQ_LEAST_CONNECTIVITY /* by valences alone */
} cq_goal;

/* What to encode, and how. Zero-initialise, then set what you need. */
typedef struct cq_input {
    cq_shape shape;                        /* num_vertices, num_faces, fast, num_channels, channel[]; the rest is
                                              found */
    const cq_index *indices;               /* cq_index[3 * num_faces] */
    const cq_value *values[CQ_MAX_CHANNELS];  /* channel k: cq_value[num_vertices][components] or [num_faces] */
    cq_goal goal;
    cq_index *map;                         /* out, may be NULL: cq_index[num_vertices], decoded numbers */
    cq_index *face_map;                    /* the same for faces: cq_index[num_faces] */
    void (*progress)(void *user, uint32_t done, uint32_t total);  /* may be NULL; called now and then, done <= total */
    void *user;
} cq_input;

/* Bytes of memory for an encoder of a shape; 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_encoder_bytes(const cq_shape *shape);

/* Encodes a mesh.
 *
 * in       in->shape.num_boundary_loops and _edges are set as found; start with zeros (a closed mesh) and on
 *          CQ_ERROR_MEMORY hand in cq_encoder_bytes(&in->shape).
 * memory   cq_encoder_bytes(&in->shape) bytes, aligned to 8. An eighth more is mostly enough for boundaries at once.
 * out      uint8_t[out_size]; *stream_size is the size of the stream, also when CQ_ERROR_OUTPUT says it did not fit.
 * place    where a mesh error or CQ_ERROR_VALUE is; may be NULL.    report   may be NULL.
 *
 * A decoder has its own order of vertices and faces, and a face may start at another corner: input vertex v is decoded
 * vertex in->map[v], input face f decoded face in->face_map[f]. CQ_ERROR_ARGUMENT if a channel is not as cq_channel,
 * cq_kind and cq_merge say.
 *
 * The same input gives the same bytes on every platform and for both index widths. Time O(vertices + faces). */
CQ_API cq_result cq_encode(cq_input *in, void *memory, size_t memory_size, uint8_t *out, size_t out_size,
                           size_t *stream_size, cq_place *place, cq_report *report);

/* -- Quantiser -----------------------------------------------------------------------------------------------------
 *
 * Floats to values and back, for those who have no integers of their own: the one part that uses floating point. It
 * calls nothing, not even libm; CQ_NO_QUANTISER leaves it out. double must be IEEE 754 binary64.
 *
 * -ffast-math may change what this part does, and nothing else: it may not notice a NaN or an infinity, and the last bit
 * of what it computes may differ from other builds. The bytes of a stream depend on the values alone.
 *
 * A grid is what a channel says its numbers mean: value q of component k is origin[k] + step * q. */

/* Chooses the grid of a channel over the bounding box of all vertices: 2^bits points along its longest side, from its
 * minimum. The step is longer where floats are further apart than that, and 0 if all vertices are equal. If it is not
 * longer, with up to 22 bits, a grid chosen for what has come back gives the same values again.
 *
 * channel  in: components, bits. out: origin, step; the rest stays as it is.
 * from     float[count][components].
 * place    the first vertex with a NaN or an infinity; may be NULL.
 *
 * CQ_OK, CQ_ERROR_ARGUMENT or CQ_ERROR_VALUE, which without a vertex says that no float holds the step. */
CQ_API cq_result cq_fit_grid(cq_channel *channel, const float *from, size_t count, cq_place *place);

/* The same with a given step, a power of two: the origin is a multiple of it, and `bits` comes out, as many as the box
 * needs. Meshes with the same step meet without cracks: equal coordinates come back equal, whatever the origins.
 * CQ_ERROR_VALUE without a vertex says that the box needs more than CQ_MAX_BITS, or an origin beyond all floats. */
CQ_API cq_result cq_align_grid(cq_channel *channel, float step, const float *from, size_t count, cq_place *place);

/* Floats to the nearest points of a channel's grid: float[count][components] to cq_value[count][components]. CQ_OK,
 * CQ_ERROR_ARGUMENT, or CQ_ERROR_VALUE with the first vertex that is not finite or half a step or more off the grid.
 *
 * Coordinates come back with an error of at most (1/2 + 2^-26) step, and half the distance of two floats there. On a
 * grid of the two functions above, what has come back has the same values again, and comes back as the same floats. */
CQ_API cq_result cq_quantise(const cq_channel *channel, const float *from, size_t count, cq_value *to, cq_place *place);

/* Values to the nearest floats; never NaN or infinite, whatever the channel says. With CQ_EXACT_BITS both functions
 * copy the floats, whatever they are. */
CQ_API void cq_reconstruct(const cq_channel *channel, const cq_value *from, size_t count, float *to);

/* Directions float[count][3], of any length but 0, to octahedral pairs cq_value[count][2] of 2 .. CQ_MAX_BITS bits, and
 * back to unit vectors. The axes come back exactly, any other direction is turned by at most 2.122 / (2^(bits - 1) - 1)
 * radians and the rounding of floats: 0.96 degrees with 8 bits, 0.06 with 12. What has come back has the same pair
 * again, with up to 22 bits. Results and places as of cq_quantise.
 * Source: Meyer et al., "On Floating-Point Normal Vectors", 2010. */
CQ_API cq_result cq_quantise_normals(int bits, const float *from, size_t count, cq_value *to, cq_place *place);
CQ_API void cq_reconstruct_normals(int bits, const cq_value *from, size_t count, float *to);

#ifdef __cplusplus
}
#endif

/* -- Mesh: circulators, around the face of a halfedge and around its origin ------------------------------------------ */

static inline cq_index cq_next(cq_index h) { return (cq_index)(h % 3 == 2 ? h - 2 : h + 1); }
static inline cq_index cq_prev(cq_index h) { return (cq_index)(h % 3 == 0 ? h + 2 : h - 1); }
static inline cq_index cq_target(const cq_mesh *m, cq_index h) { return m->origin[cq_next(h)]; }
static inline cq_index cq_clockwise(const cq_mesh *m, cq_index h) { return cq_next(m->twin[h]); }
static inline cq_index cq_counterclockwise(const cq_mesh *m, cq_index h) { return m->twin[cq_prev(h)]; }
static inline int cq_is_virtual(const cq_mesh *m, cq_index v) { return v >= m->first_virtual; }

#endif /* CQ_CONQUEST_H */

/* Stop here if you only need the interface. Below is the implementation. */
#if defined(CONQUEST_IMPLEMENTATION) && !defined(CONQUEST_IMPLEMENTATION_DONE)
#define CONQUEST_IMPLEMENTATION_DONE /* a guard of its own: the interface may have been included before */

#include <string.h> /* memcpy, memset */

/* Asserts state what the programmer got wrong, never what a stream contains. */
#ifndef CQ_ASSERT
#define CQ_ASSERT(condition) ((void)0)
#endif

static int cqi_at_most(int x, int limit) { return x < limit ? x : limit; }
static uint32_t cqi_abs(int32_t x) { return x < 0 ? (uint32_t)0 - (uint32_t)x : (uint32_t)x; }

/* Modulo 2^32, for exact values and hostile residuals of fast streams; of all others no sum is that large. */
static int32_t cqi_sum(int32_t a, int32_t b) { return (int32_t)((uint32_t)a + (uint32_t)b); }
static int32_t cqi_difference(int32_t a, int32_t b) { return (int32_t)((uint32_t)a - (uint32_t)b); }

/* Number of bits of x without leading zeros: 0 for 0, 32 for 2^31 and above. */
static int cqi_bit_length(uint32_t x)
{
#if defined(__GNUC__) && __SIZEOF_INT__ == 4
    return x ? 32 - __builtin_clz(x) : 0;
#else
    int n = 0;
    if (x >> 16) { n += 16; x >>= 16; }
    if (x >> 8) { n += 8; x >>= 8; }
    if (x >> 4) { n += 4; x >>= 4; }
    if (x >> 2) { n += 2; x >>= 2; }
    return n + (int)(x >> 1 ? 2 : x);
#endif
}

/* x / 2^bits rounded down, bits > 0. */
static int32_t cqi_floor_shift(int32_t x, int bits)
{
    return x < 0 ? ~(~x >> bits) : x >> bits;
}

const char *cq_result_string(cq_result result)
{
    switch (result) {
    case CQ_OK: return "ok";
    case CQ_NEED_INPUT: return "more input needed";
    case CQ_DONE: return "complete";
    case CQ_TRUNCATED: return "the input ends early";
    case CQ_ERROR_ARGUMENT: return "bad argument";
    case CQ_ERROR_MEMORY: return "memory too small or misaligned";
    case CQ_ERROR_OUTPUT: return "output buffer full";
    case CQ_ERROR_TOO_LARGE: return "too many vertices or faces";
    case CQ_ERROR_INDEX: return "a face names a vertex that does not exist";
    case CQ_ERROR_FACE: return "a face names one vertex twice";
    case CQ_ERROR_EDGE: return "an edge has more than two faces";
    case CQ_ERROR_ORIENTATION: return "two faces run along an edge in the same direction";
    case CQ_ERROR_VERTEX: return "the faces around a vertex are not one fan";
    case CQ_ERROR_UNUSED: return "a vertex belongs to no face";
    case CQ_ERROR_VALUE: return "a channel value is out of range";
    case CQ_ERROR_FORMAT: return "not a conquest stream";
    case CQ_ERROR_VERSION: return "a stream version this library does not know";
    case CQ_ERROR_UNSUPPORTED: return "a stream feature this build does not support";
    case CQ_ERROR_CORRUPT: return "corrupt stream";
    case CQ_ERROR_CHECKSUM: return "check value mismatch";
    }
    return "unknown result";
}

/* -- Memory: carving the caller's block ---------------------------------------------------------------------------- */

typedef struct cqi_arena {
    uint8_t *next;
    size_t left;
} cqi_arena;

/* Takes the next `count` elements of `size` bytes; the caller has checked the sum. Blocks start at multiples of 4. */
static void *cqi_take(cqi_arena *arena, size_t count, size_t size)
{
    uint8_t *block = arena->next;
    size_t bytes = CQI_ROUND(count * size);
    CQ_ASSERT(bytes <= arena->left);
    arena->next += bytes;
    arena->left -= bytes;
    return block;
}

/* As the compiler aligns static uint32_t memory[]: to 4, but to 1 on AVR. */
struct cqi_alignment { char before; uint32_t word; };
static int cqi_aligned(const void *memory) { return (uintptr_t)memory % offsetof(struct cqi_alignment, word) == 0; }

/* Vertices with the virtual ones, faces with the virtual ones. */
static uint32_t cqi_all_vertices(const cq_shape *s) { return s->num_vertices + s->num_boundary_loops; }
static uint32_t cqi_all_faces(const cq_shape *s) { return s->num_faces + s->num_boundary_edges; }

/* The first channel of positions that move, or -1. */
static int cqi_position_channel(const cq_shape *s)
{
    uint32_t k;
    for (k = 0; k < s->num_channels; k++)
        if (s->channel[k].kind == CQ_POSITION && s->channel[k].merge == CQ_MIDPOINT) return (int)k;
    return -1;
}

/* The channel of positions that the connectivity is coded with, or -1. */
static int cqi_context_channel(const cq_shape *s) { return s->fast ? -1 : cqi_position_channel(s); }

/* Components of a channel, where a loop runs over an array of CQ_MAX_COMPONENTS: the bound must be one that the compiler
 * sees. From `components` alone LLVM 15 to 19 (-O3 -flto, AVX) also make a vectorised copy of the loop that reads 8
 * elements and can never run, and infer from it that the elements read by the other copy are undefined (llvm-project,
 * issue 107996). */
static uint32_t cqi_components(const cq_channel *c)
{
    return c->components < CQ_MAX_COMPONENTS ? c->components : CQ_MAX_COMPONENTS;
}

/* Numbers per vertex or, that is all channels of them, per face. */
static uint32_t cqi_all_components(const cq_shape *s, int per_face)
{
    uint32_t k, n = 0;
    for (k = 0; k < s->num_channels; k++)
        if ((s->channel[k].merge == CQ_PER_FACE) == per_face) n += s->channel[k].components;
    return n;
}

/* 0 if size_t has too few bits. */
static size_t cqi_bytes(cqi_size n) { return (size_t)n == n ? (size_t)n : 0; } /* unreachable: size_t of 16 bits */

/* Everything that cq_index can number, and small enough that no cqi_size below overflows: an encoder needs at most 121
 * bytes for each of CQI_MAX_HALFEDGES halfedges. And a mesh whose size a size_t can say. */
#define CQI_LARGEST_COUNT \
    (sizeof(size_t) < 4 ? 511 : sizeof(size_t) < 8 ? 0x01ffffffu : 0xffffffffu) /* unreachable: size_t of 64 bits */
#define CQI_MAX_HALFEDGES (CQ_INDEX_BITS == 16 ? 0xffffu : CQI_LARGEST_COUNT)

static int cqi_countable(const cq_shape *s)
{
    const uint32_t limit = (uint32_t)(CQI_MAX_HALFEDGES / 3);
    cqi_size bytes;
    if (s->num_vertices > limit || s->num_boundary_loops > limit - s->num_vertices) return 0;
    if (s->num_faces > limit || s->num_boundary_edges > limit - s->num_faces) return 0;
    bytes = CQ_MESH_BYTES(cqi_all_vertices(s), cqi_all_faces(s));
    return s->num_channels <= CQ_MAX_CHANNELS && cqi_bytes(bytes) == bytes;
}

size_t cq_mesh_bytes(const cq_shape *s)
{
    if (!s || !cqi_countable(s)) return 0;
    return cqi_bytes(CQ_MESH_BYTES(cqi_all_vertices(s), cqi_all_faces(s)));
}

/* Lays out a mesh without vertices and faces. Block sizes add up to CQ_MESH_BYTES: only the last one needs rounding
 * because 3 * 2 * faces + 2 * vertices indices are split as 6f and 2v, each an even number of 16-bit words. */
static void cqi_mesh_carve(cq_mesh *m, const cq_shape *s, cqi_arena *arena)
{
    size_t v = cqi_all_vertices(s), f = cqi_all_faces(s);
    cq_index *indices = (cq_index *)cqi_take(arena, 6 * f + 2 * v, sizeof(cq_index));
    m->origin = indices;
    m->twin = indices + 3 * f;
    m->out = indices + 6 * f;
    m->valence = indices + 6 * f + v;
    m->mark = (uint8_t *)cqi_take(arena, v, 1);
    memset(m->mark, 0, v);
    m->num_vertices = m->num_faces = m->num_virtual = m->num_virtual_faces = 0;
    m->first_virtual = (cq_index)s->num_vertices;
    m->first_virtual_face = (cq_index)s->num_faces;
    m->max_virtual = (cq_index)s->num_boundary_loops;
    m->max_virtual_faces = (cq_index)s->num_boundary_edges;
    m->free_vertex = m->free_face = m->free_virtual_face = CQ_NONE;
}

/* -- Mesh: building ------------------------------------------------------------------------------------------------ */

static cq_result cqi_error(cq_place *place, cq_result result, cq_index face, cq_index vertex, cq_index other)
{
    if (place) {
        place->face = face;
        place->vertex = vertex;
        place->other = other;
    }
    return result;
}

/* Every face names three different vertices that exist. */
static cq_result cqi_check_faces(const cq_index *indices, const cq_shape *s, cq_place *place)
{
    cq_index f, k;
    for (f = 0; f < s->num_faces; f++) {
        const cq_index *v = indices + 3 * (size_t)f;
        for (k = 0; k < 3; k++)
            if (v[k] >= s->num_vertices) return cqi_error(place, CQ_ERROR_INDEX, f, v[k], CQ_NONE);
        for (k = 0; k < 3; k++)
            if (v[k] == v[(k + 1) % 3]) return cqi_error(place, CQ_ERROR_FACE, f, v[k], CQ_NONE);
    }
    return CQ_OK;
}

static void cqi_pair(cq_mesh *m, cq_index g, cq_index h)
{
    m->twin[g] = h;
    m->twin[h] = g;
}

static cq_index cqi_smaller_end(const cq_index *indices, cq_index h)
{
    cq_index a = indices[h], b = indices[cq_next(h)];
    return a < b ? a : b;
}

static int cqi_same_edge(const cq_index *indices, cq_index g, cq_index h)
{
    cq_index a = indices[g], b = indices[cq_next(g)], c = indices[h], d = indices[cq_next(h)];
    return (a == c && b == d) || (a == d && b == c);
}

/* Sorts the halfedges by their smaller end, stable: first[v] is behind the last one of v. */
static void cqi_sort_halfedges(const cq_index *indices, const cq_shape *s, cq_index *sorted, cq_index *first)
{
    const cq_index n = (cq_index)(3 * s->num_faces);
    cq_index k, sum = 0;
    memset(first, 0, s->num_vertices * sizeof(cq_index));
    for (k = 0; k < n; k++) first[cqi_smaller_end(indices, k)]++;
    for (k = 0; k < s->num_vertices; k++) {
        cq_index count = first[k];
        first[k] = sum;
        sum = (cq_index)(sum + count);
    }
    for (k = 0; k < n; k++) sorted[first[cqi_smaller_end(indices, k)]++] = k;
}

/* Pairs halfedge g with *last if that is of the same edge, and g is then the last one. */
static cq_result cqi_match_twin(cq_mesh *m, const cq_index *indices, cq_index g, cq_index *last)
{
    const cq_index h = *last;
    *last = g;
    m->twin[g] = CQ_NONE;
    if (h == CQ_NONE || !cqi_same_edge(indices, g, h)) return CQ_OK;
    if (m->twin[h] != CQ_NONE) return CQ_ERROR_EDGE;
    cqi_pair(m, g, h);
    return indices[g] == indices[h] ? CQ_ERROR_ORIENTATION : CQ_OK;
}

/* Pairs the halfedges: twin[h], or CQ_NONE on a boundary. Linear time for any input: halfedges are visited by their
 * smaller end, and valence[v] is the last one so far that has v as the larger end. origin and out serve as scratch,
 * too; in the end origin = indices. An edge of three faces is reported, if there is none one of two that do not agree:
 * the first one in that order. */
static cq_result cqi_match_twins(cq_mesh *m, const cq_index *indices, const cq_shape *s, cq_place *place)
{
    const cq_index n = (cq_index)(3 * s->num_faces);
    cq_result result = CQ_OK;
    cq_index k;
    cqi_sort_halfedges(indices, s, m->origin, m->out);
    memset(m->valence, 0xff, s->num_vertices * sizeof(cq_index));
    for (k = 0; k < n && result != CQ_ERROR_EDGE; k++) {
        const cq_index g = m->origin[k], a = indices[g], b = indices[cq_next(g)];
        const cq_result found = cqi_match_twin(m, indices, g, &m->valence[a < b ? b : a]);
        if (found == CQ_ERROR_EDGE || (found != CQ_OK && result == CQ_OK))
            result = cqi_error(place, found, (cq_index)(g / 3), a, b);
    }
    if (n) memcpy(m->origin, indices, n * sizeof(cq_index));
    return result;
}

/* out[v] = the one boundary halfedge that starts at v, or CQ_NONE. */
static cq_result cqi_find_boundary(cq_mesh *m, cq_shape *s, cq_place *place)
{
    cq_index h;
    memset(m->out, 0xff, s->num_vertices * sizeof(cq_index));
    s->num_boundary_edges = 0;
    for (h = 0; h < 3 * s->num_faces; h++) {
        if (m->twin[h] != CQ_NONE) continue;
        if (m->out[m->origin[h]] != CQ_NONE)
            return cqi_error(place, CQ_ERROR_VERTEX, CQ_NONE, m->origin[h], CQ_NONE);
        m->out[m->origin[h]] = h;
        s->num_boundary_edges++;
    }
    return CQ_OK;
}

/* As many boundary halfedges enter a vertex as leave it, and cqi_find_boundary allows one: so every walk closes. */
static void cqi_count_loops(cq_mesh *m, cq_shape *s)
{
    cq_index v, w;
    s->num_boundary_loops = 0;
    for (v = 0; v < s->num_vertices; v++) {
        if (m->out[v] == CQ_NONE || m->mark[v]) continue;
        for (w = v; !m->mark[w]; w = cq_target(m, m->out[w])) m->mark[w] = 1;
        s->num_boundary_loops++;
    }
    memset(m->mark, 0, s->num_vertices);
}

/* Fans a virtual vertex w to the boundary loop that leaves v: for each boundary halfedge a -> b a face b, a, w. */
static void cqi_close_loop(cq_mesh *m, cq_index v)
{
    cq_index w = (cq_index)(m->first_virtual + m->num_virtual++);
    cq_index first = CQ_NONE, before = CQ_NONE, h = m->out[v], last;
    while (m->twin[h] == CQ_NONE) {
        cq_index b = cq_target(m, h);
        cq_index g = (cq_index)(3 * (m->first_virtual_face + m->num_virtual_faces++));
        m->origin[g] = b;
        m->origin[g + 1] = m->origin[h];
        m->origin[g + 2] = w;
        cqi_pair(m, g, h);
        if (before == CQ_NONE) first = g;
        else cqi_pair(m, (cq_index)(before + 2), (cq_index)(g + 1)); /* w -> a and a -> w */
        before = g;
        h = m->out[b];
    }
    last = (cq_index)(before + 2);
    cqi_pair(m, last, (cq_index)(first + 1));
}

static void cqi_close_loops(cq_mesh *m)
{
    cq_index v;
    for (v = 0; v < m->num_vertices; v++)
        if (m->out[v] != CQ_NONE && m->twin[m->out[v]] == CQ_NONE) cqi_close_loop(m, v);
}

/* Sets out and valence from the halfedges of faces first .. first + count - 1. */
static void cqi_count_valences(cq_mesh *m, cq_index first, cq_index count)
{
    cq_index h, end = (cq_index)(3 * (first + count));
    for (h = (cq_index)(3 * first); h < end; h++) {
        m->out[m->origin[h]] = h;
        m->valence[m->origin[h]]++;
    }
}

/* The halfedges around v form one cycle of its valence (that counts all of them). */
static int cqi_is_one_fan(const cq_mesh *m, cq_index v)
{
    cq_index h = m->out[v], n = 0;
    do {
        h = cq_clockwise(m, h);
        n++;
    } while (h != m->out[v] && n < m->valence[v]);
    return h == m->out[v] && n == m->valence[v];
}

static cq_result cqi_check_fans(const cq_mesh *m, cq_place *place)
{
    cq_index v;
    for (v = 0; v < m->num_vertices; v++) {
        if (!m->valence[v]) return cqi_error(place, CQ_ERROR_UNUSED, CQ_NONE, v, CQ_NONE);
        if (!cqi_is_one_fan(m, v)) return cqi_error(place, CQ_ERROR_VERTEX, CQ_NONE, v, CQ_NONE);
    }
    return CQ_OK;
}

/* Carves, pairs and counts; the shape is then complete and the mesh still open. */
static cq_result cqi_build_open(cq_mesh *m, cq_shape *s, const cq_index *indices, void *memory, size_t size,
                                cq_place *place)
{
    cqi_arena arena;
    cq_result r;
    arena.next = (uint8_t *)memory;
    arena.left = size;
    if (!cqi_countable(s)) return CQ_ERROR_TOO_LARGE;
    if (!memory || !cqi_aligned(memory) || size < cq_mesh_bytes(s)) return CQ_ERROR_MEMORY;
    cqi_mesh_carve(m, s, &arena);
    r = cqi_match_twins(m, indices, s, place);
    if (r == CQ_OK) r = cqi_find_boundary(m, s, place);
    if (r == CQ_OK) cqi_count_loops(m, s);
    return r;
}

cq_result cq_mesh_build(cq_mesh *m, cq_shape *s, const cq_index *indices, void *memory, size_t size, cq_place *place)
{
    cq_result r;
    if (place) place->face = place->vertex = place->other = CQ_NONE;
    if (!m || !s || (s->num_faces && !indices)) return CQ_ERROR_ARGUMENT;
    s->num_boundary_loops = s->num_boundary_edges = 0;
    if (!cqi_countable(s)) return CQ_ERROR_TOO_LARGE;
    r = cqi_check_faces(indices, s, place);
    if (r == CQ_OK) r = cqi_build_open(m, s, indices, memory, size, place);
    if (r == CQ_OK && s->num_boundary_edges) r = cqi_build_open(m, s, indices, memory, size, place); /* now with room */
    if (r != CQ_OK) return r;
    m->num_vertices = (cq_index)s->num_vertices;
    m->num_faces = (cq_index)s->num_faces;
    cqi_close_loops(m);
    memset(m->valence, 0, cqi_all_vertices(s) * sizeof(cq_index));
    cqi_count_valences(m, 0, m->num_faces);
    cqi_count_valences(m, m->first_virtual_face, m->num_virtual_faces);
    return cqi_check_fans(m, place);
}

/* -- Mesh: checking ------------------------------------------------------------------------------------------------ */

#define CQI_SCRATCH 0x80 /* bit of mark[v] that the mesh operations use and clear again */

static int cqi_in_range(cq_index x, cq_index count, cq_index first, cq_index virtual_count)
{
    return x < count || (x >= first && x - first < virtual_count);
}

static int cqi_is_vertex(const cq_mesh *m, cq_index v)
{
    return cqi_in_range(v, m->num_vertices, m->first_virtual, m->num_virtual) && m->out[v] != CQ_NONE;
}

static int cqi_is_face(const cq_mesh *m, cq_index f)
{
    return cqi_in_range(f, m->num_faces, m->first_virtual_face, m->num_virtual_faces) &&
           m->origin[3 * f] != CQ_NONE;
}

/* Number of corners of a face that are virtual. */
static int cqi_virtual_corners(const cq_mesh *m, cq_index f)
{
    return cq_is_virtual(m, m->origin[3 * f]) + cq_is_virtual(m, m->origin[3 * f + 1]) +
           cq_is_virtual(m, m->origin[3 * f + 2]);
}

static cq_result cqi_check_halfedges(const cq_mesh *m, cq_index first, cq_index count, cq_place *place)
{
    cq_index f, h;
    for (f = first; f < first + count; f++) {
        if (!cqi_is_face(m, f)) continue;
        for (h = (cq_index)(3 * f); h < 3 * f + 3; h++) {
            cq_index t = m->twin[h];
            if (!cqi_is_vertex(m, m->origin[h]))
                return cqi_error(place, CQ_ERROR_INDEX, f, m->origin[h], CQ_NONE);
            if (t == CQ_NONE || t == h || !cqi_is_face(m, (cq_index)(t / 3)) || m->twin[t] != h ||
                cq_target(m, t) != m->origin[h])
                return cqi_error(place, CQ_ERROR_EDGE, f, m->origin[h], cq_target(m, h));
        }
        if (cqi_virtual_corners(m, f) != (f >= m->first_virtual_face))
            return cqi_error(place, CQ_ERROR_FACE, f, CQ_NONE, CQ_NONE);
    }
    return CQ_OK;
}

/* Sets or clears the scratch bit of v's neighbours. Returns one that had it already, or CQ_NONE. */
static cq_index cqi_mark_ring(const cq_mesh *m, cq_index v, int set)
{
    cq_index h = m->out[v], repeated = CQ_NONE;
    do {
        cq_index w = cq_target(m, h);
        if (set && (m->mark[w] & CQI_SCRATCH)) repeated = w;
        m->mark[w] = (uint8_t)(set ? m->mark[w] | CQI_SCRATCH : m->mark[w] & ~CQI_SCRATCH);
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    return repeated;
}

/* Is a real vertex next to at most one virtual vertex, a virtual one to none? */
static int cqi_boundary_is_simple(const cq_mesh *m, cq_index v)
{
    cq_index h = m->out[v], n = 0;
    do {
        n = (cq_index)(n + (cq_index)cq_is_virtual(m, cq_target(m, h)));
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    return n <= (cq_index)!cq_is_virtual(m, v);
}

static cq_result cqi_check_vertices(const cq_mesh *m, cq_index first, cq_index count, cq_index *corners,
                                    cq_place *place)
{
    cq_index v, twice;
    for (v = first; v < first + count; v++) {
        if (!cqi_is_vertex(m, v)) continue;
        if (!cqi_is_face(m, (cq_index)(m->out[v] / 3)) || m->origin[m->out[v]] != v ||
            m->valence[v] < (cq_is_virtual(m, v) ? 3u : 2u) || !cqi_is_one_fan(m, v) ||
            !cqi_boundary_is_simple(m, v))
            return cqi_error(place, CQ_ERROR_VERTEX, CQ_NONE, v, CQ_NONE);
        twice = cqi_mark_ring(m, v, 1);
        cqi_mark_ring(m, v, 0);
        if (twice != CQ_NONE) return cqi_error(place, CQ_ERROR_EDGE, CQ_NONE, v, twice);
        *corners = (cq_index)(*corners + m->valence[v]);
    }
    return CQ_OK;
}

static int cqi_counts_fit(const cq_mesh *m)
{
    return m->num_vertices <= m->first_virtual && m->num_virtual <= m->max_virtual &&
           m->num_faces <= m->first_virtual_face && m->num_virtual_faces <= m->max_virtual_faces;
}

static cq_index cqi_count_corners(const cq_mesh *m, cq_index first, cq_index count)
{
    cq_index f, n = 0;
    for (f = first; f < first + count; f++)
        if (cqi_is_face(m, f)) n = (cq_index)(n + 3);
    return n;
}

cq_result cq_mesh_check(const cq_mesh *m, cq_place *place)
{
    cq_index in_fans = 0, corners;
    cq_result r = cqi_error(place, cqi_counts_fit(m) ? CQ_OK : CQ_ERROR_INDEX, CQ_NONE, CQ_NONE, CQ_NONE);
    if (r == CQ_OK) r = cqi_check_halfedges(m, 0, m->num_faces, place);
    if (r == CQ_OK) r = cqi_check_halfedges(m, m->first_virtual_face, m->num_virtual_faces, place);
    if (r == CQ_OK) r = cqi_check_vertices(m, 0, m->num_vertices, &in_fans, place);
    if (r == CQ_OK) r = cqi_check_vertices(m, m->first_virtual, m->num_virtual, &in_fans, place);
    if (r != CQ_OK) return r;
    corners = cqi_count_corners(m, 0, m->num_faces);
    corners = (cq_index)(corners + cqi_count_corners(m, m->first_virtual_face, m->num_virtual_faces));
    return in_fans == corners ? CQ_OK : cqi_error(place, CQ_ERROR_VERTEX, CQ_NONE, CQ_NONE, CQ_NONE);
}

/* -- Mesh: collapse and split -------------------------------------------------------------------------------------- */

/* A -> B may be collapsed, given that A's neighbours carry the scratch mark and `boundary` says whether one of them is
 * virtual. Common neighbours of A and B must be p and q only; they keep valence 3 or more; if both ends are on a
 * boundary, the edge must be too (else two loops, or two places of one, would touch). */
static int cqi_collapsible(const cq_mesh *m, cq_index h, cq_index max_valence, int boundary)
{
    cq_index a = m->origin[h], b = cq_target(m, h), g = m->twin[h], s, common = 0;
    cq_index p = m->origin[cq_prev(h)], q = m->origin[cq_prev(g)];
    int b_boundary = 0;
    if (cq_is_virtual(m, a) || cq_is_virtual(m, b) || p == q) return 0;
    if (m->valence[p] < 4 || m->valence[q] < 4) return 0;
    if (m->valence[a] > max_valence || m->valence[b] > max_valence) return 0;
    if (m->valence[a] + m->valence[b] - 4 > max_valence) return 0;
    s = g;
    do {
        cq_index w = cq_target(m, s);
        common = (cq_index)(common + (m->mark[w] & CQI_SCRATCH ? 1 : 0));
        b_boundary |= cq_is_virtual(m, w);
        s = cq_clockwise(m, s);
    } while (s != g);
    if (boundary && b_boundary && !cq_is_virtual(m, p) && !cq_is_virtual(m, q)) return 0;
    return common == 2;
}

static int cqi_on_boundary(const cq_mesh *m, cq_index v)
{
    cq_index h = m->out[v];
    do {
        if (cq_is_virtual(m, cq_target(m, h))) return 1;
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    return 0;
}

int cq_mesh_can_collapse(const cq_mesh *m, cq_index h, cq_index max_valence)
{
    CQ_ASSERT(cqi_is_face(m, (cq_index)(h / 3)));
    cq_index a = m->origin[h];
    int can;
    if (m->valence[a] > max_valence) return 0; /* bounds the time of what follows */
    cqi_mark_ring(m, a, 1);
    can = cqi_collapsible(m, h, max_valence, cqi_on_boundary(m, a));
    cqi_mark_ring(m, a, 0);
    return can;
}

/* Free slots form stacks: of vertices through valence[], of faces through origin[3f + 1]. */
static void cqi_free_vertex(cq_mesh *m, cq_index v)
{
    m->out[v] = CQ_NONE;
    m->valence[v] = m->free_vertex;
    m->free_vertex = v;
}

static void cqi_free_face(cq_mesh *m, cq_index f)
{
    cq_index *head = f >= m->first_virtual_face ? &m->free_virtual_face : &m->free_face;
    m->origin[3 * f] = CQ_NONE;
    m->origin[3 * f + 1] = *head;
    *head = f;
}

static cq_index cqi_new_vertex(cq_mesh *m)
{
    cq_index v = m->free_vertex;
    if (v != CQ_NONE) m->free_vertex = m->valence[v];
    else if (m->num_vertices < m->first_virtual) v = m->num_vertices++;
    return v;
}

static cq_index cqi_new_face(cq_mesh *m, int is_virtual)
{
    cq_index *head = is_virtual ? &m->free_virtual_face : &m->free_face, f = *head;
    if (f != CQ_NONE) *head = m->origin[3 * f + 1];
    else if (is_virtual && m->num_virtual_faces < m->max_virtual_faces)
        f = (cq_index)(m->first_virtual_face + m->num_virtual_faces++);
    else if (!is_virtual && m->num_faces < m->first_virtual_face) f = m->num_faces++;
    return f;
}

/* Room for one vertex and the faces of a split with common neighbours p and q, of which at most one is virtual. */
static int cqi_has_room(const cq_mesh *m, cq_index p, cq_index q)
{
    cq_index want = (cq_index)(2 - cq_is_virtual(m, p) - cq_is_virtual(m, q)), f = m->free_face;
    cq_index room = (cq_index)(m->first_virtual_face - m->num_faces);
    if (want < 2 && m->free_virtual_face == CQ_NONE && m->num_virtual_faces == m->max_virtual_faces) return 0;
    if (m->free_vertex == CQ_NONE && m->num_vertices == m->first_virtual) return 0;
    for (; room < want && f != CQ_NONE; f = m->origin[3 * f + 1]) room++;
    return room >= want;
}

void cq_mesh_collapse(cq_mesh *m, cq_index h, cq_index *first, cq_index *last)
{
    CQ_ASSERT(cq_mesh_can_collapse(m, h, CQ_NONE));
    cq_index g = m->twin[h], a = m->origin[h], b = m->origin[g], s;
    cq_index p = m->origin[cq_prev(h)], q = m->origin[cq_prev(g)];
    cq_index to_p = m->twin[cq_prev(h)], from_p = m->twin[cq_next(h)]; /* A -> p, p -> B */
    cq_index to_q = m->twin[cq_prev(g)], from_q = m->twin[cq_next(g)]; /* B -> q, q -> A */
    for (s = cq_clockwise(m, g); s != g; s = cq_clockwise(m, s)) m->origin[s] = a;
    cqi_pair(m, to_p, from_p);
    cqi_pair(m, to_q, from_q);
    m->valence[a] = (cq_index)(m->valence[a] + m->valence[b] - 4);
    m->valence[p]--;
    m->valence[q]--;
    m->out[a] = to_p;
    m->out[p] = from_p;
    m->out[q] = from_q;
    cqi_free_vertex(m, b);
    cqi_free_face(m, (cq_index)(g / 3));
    cqi_free_face(m, (cq_index)(h / 3));
    *first = to_p;
    *last = to_q;
}

static void cqi_set_face(cq_mesh *m, cq_index f, cq_index a, cq_index b, cq_index c)
{
    m->origin[3 * f] = a;
    m->origin[3 * f + 1] = b;
    m->origin[3 * f + 2] = c;
}

cq_index cq_mesh_split(cq_mesh *m, cq_index first, cq_index last)
{
    CQ_ASSERT(cqi_is_face(m, (cq_index)(first / 3)) && cqi_is_face(m, (cq_index)(last / 3)));
    CQ_ASSERT(m->origin[first] == m->origin[last] && first != last);
    cq_index a = m->origin[first], p = cq_target(m, first), q = cq_target(m, last);
    cq_index from_p = m->twin[first], from_q = m->twin[last];
    cq_index b, f, g, s, moved = 0;
    if (cq_is_virtual(m, a) || !cqi_has_room(m, p, q)) return CQ_NONE;
    f = cqi_new_face(m, cq_is_virtual(m, p));
    g = cqi_new_face(m, cq_is_virtual(m, q));
    b = cqi_new_vertex(m);
    for (s = cq_clockwise(m, first);; s = cq_clockwise(m, s)) { /* B takes the spokes behind first up to last */
        m->origin[s] = b;
        moved++;
        if (s == last) break;
    }
    cqi_set_face(m, f, p, a, b); /* p -> A, A -> B, B -> p */
    cqi_set_face(m, g, a, q, b); /* A -> q, q -> B, B -> A */
    cqi_pair(m, (cq_index)(3 * f), first);
    cqi_pair(m, (cq_index)(3 * f + 2), from_p);
    cqi_pair(m, (cq_index)(3 * g), from_q);
    cqi_pair(m, (cq_index)(3 * g + 1), last);
    cqi_pair(m, (cq_index)(3 * f + 1), (cq_index)(3 * g + 2));
    m->valence[b] = (cq_index)(moved + 2);
    m->valence[a] = (cq_index)(m->valence[a] - moved + 2);
    m->valence[p]++;
    m->valence[q]++;
    m->out[a] = first;
    m->out[b] = last;
    return b;
}

size_t cq_mesh_triangles(const cq_mesh *m, cq_index *triangles)
{
    size_t n = 0;
    cq_index f;
    for (f = 0; f < m->num_faces; f++) {
        if (!cqi_is_face(m, f)) continue;
        memcpy(triangles + 3 * n, m->origin + 3 * (size_t)f, 3 * sizeof(cq_index));
        n++;
    }
    return n;
}

/* A split moves halfedges to its new vertex B, and they only leave B for newer ones: what changed is around new
 * vertices. So is the centre that was split: its edge to B too only ever passes on to newer vertices. */
static void cqi_mark_changes(const cq_mesh *m, cq_index v, int shift, uint8_t *faces, uint8_t *vertices)
{
    cq_index h = m->out[v];
    do {
        cq_index f = (cq_index)(h / 3), w = cq_target(m, h);
        if (faces && f < m->first_virtual_face) faces[f >> shift] = 1;
        if (vertices && !cq_is_virtual(m, w)) vertices[w >> shift] = 1;
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    if (vertices) vertices[v >> shift] = 1;
}

void cq_mesh_changes(const cq_mesh *m, cq_index since, int shift, uint8_t *faces, uint8_t *vertices)
{
    CQ_ASSERT(shift >= 0 && shift < CQ_INDEX_BITS);
    CQ_ASSERT(m->free_vertex == CQ_NONE); /* a decoder's */
    cq_index v;
    for (v = since; v < m->num_vertices; v++) cqi_mark_changes(m, v, shift, faces, vertices);
}

/* -- Range coder ---------------------------------------------------------------------------------------------------
 *
 * The interval [low, low + range) of the encoder narrows with each symbol; 2^24 <= range < 2^32 before each. The
 * decoder keeps code = value - low, so both sides compute the same ranges and 0 <= code < range holds for any input:
 * a step takes code to code - offset only if code >= offset, and the part it then takes is wider than what is left
 * of code. */
#define CQI_MIN_RANGE 0x1000000u

static void cqi_put_byte(cq_range_encoder *e, int byte)
{
    if (e->count < e->size) e->data[e->count] = (uint8_t)byte;
    e->count++;
    e->zeros = byte ? 0 : e->zeros + 1;
}

/* Moves the top byte of low out. A byte waits in cache, and 0xff bytes behind it in pending, until the carry is
 * known. */
static void cqi_shift_low(cq_range_encoder *e)
{
    uint32_t low = (uint32_t)e->low;
    int carry = (int)(e->low >> 32);
    if (low < 0xff000000u || carry) {
        if (e->cache >= 0) cqi_put_byte(e, (e->cache + carry) & 0xff); /* the first byte of all can't carry: low < 1 */
        for (; e->pending; e->pending--) cqi_put_byte(e, (0xff + carry) & 0xff);
        e->cache = (int)(low >> 24);
    } else {
        e->pending++;
    }
    e->low = (uint64_t)(low << 8);
}

static void cqi_encode_interval(cq_range_encoder *e, uint32_t offset, uint32_t width)
{
    e->low += offset;
    e->range = width;
    while (e->range < CQI_MIN_RANGE) {
        e->range <<= 8;
        cqi_shift_low(e);
    }
}

static inline void cqi_decode_interval(cq_range_decoder *d, uint32_t offset, uint32_t width)
{
    d->code -= offset;
    d->range = width;
    while (d->range < CQI_MIN_RANGE) {
        d->range <<= 8;
        d->code = d->code << 8 | (d->count < d->size ? d->data[d->count] : 0u);
        d->count++;
    }
}

void cq_range_encoder_init(cq_range_encoder *e, uint8_t *data, size_t size)
{
    CQ_ASSERT(data || !size);
    memset(e, 0, sizeof *e);
    e->range = 0xffffffffu;
    e->data = data;
    e->size = size;
    e->cache = -1;
}

void cq_range_decoder_init(cq_range_decoder *d, const uint8_t *data, size_t size)
{
    CQ_ASSERT(data || !size);
    int k;
    memset(d, 0, sizeof *d);
    d->range = 0xffffffffu;
    d->data = data;
    d->size = size;
    for (k = 0; k < 4; k++, d->count++) d->code = d->code << 8 | (d->count < size ? data[d->count] : 0u);
    if (d->code == d->range) d->code--; /* no encoder writes that */
}

/* The part of the range that a 1 gets: never 0 and never all, since 32 <= model <= 65504 and range >= 2^24. */
static uint32_t cqi_one_width(uint32_t range, cq_bit_model model) { return (range >> 16) * model; }

static void cqi_adapt_bit(cq_bit_model *model, int rate, int bit)
{
    const int32_t p = *model, least = 31 + ((int32_t)1 << rate), goal = least + ((65504 - least) & -(int32_t)bit);
    *model = (cq_bit_model)(p + cqi_floor_shift(goal - p, rate));
}

void cq_encode_bit(cq_range_encoder *e, cq_bit_model *model, int rate, int bit)
{
    CQ_ASSERT(e->range >= CQI_MIN_RANGE && *model >= 32 && *model <= 65504);
    CQ_ASSERT(rate >= 1 && rate <= 8);
    uint32_t one = cqi_one_width(e->range, *model);
    cqi_encode_interval(e, bit ? 0 : one, bit ? one : e->range - one);
    cqi_adapt_bit(model, rate, bit != 0);
}

int cq_decode_bit(cq_range_decoder *d, cq_bit_model *model, int rate)
{
    CQ_ASSERT(d->range >= CQI_MIN_RANGE && *model >= 32 && *model <= 65504);
    CQ_ASSERT(rate >= 1 && rate <= 8);
    const uint32_t one = cqi_one_width(d->range, *model), rest = d->range - one;
    const int bit = d->code < one;
    const uint32_t if_zero = (uint32_t)bit - 1; /* masks: a branch would often be mispredicted */
    cqi_decode_interval(d, one & if_zero, (rest & if_zero) | (one & ~if_zero));
    cqi_adapt_bit(model, rate, bit);
    return bit;
}

/* The last symbol also gets what the division leaves over, so that every code of the interval means something. */
static uint32_t cqi_freq_width(uint32_t range, uint32_t slot, uint32_t start, uint32_t freq, uint32_t total)
{
    return start + freq == total ? range - slot * start : slot * freq;
}

void cq_encode_freq(cq_range_encoder *e, uint32_t start, uint32_t freq, uint32_t total)
{
    CQ_ASSERT(e->range >= CQI_MIN_RANGE && total <= CQI_MIN_RANGE);
    CQ_ASSERT(freq && freq <= total && start <= total - freq);
    uint32_t slot = e->range / total;
    cqi_encode_interval(e, slot * start, cqi_freq_width(e->range, slot, start, freq, total));
}

uint32_t cq_decode_slot(cq_range_decoder *d, uint32_t total)
{
    CQ_ASSERT(d->range >= CQI_MIN_RANGE && total && total <= CQI_MIN_RANGE);
    uint32_t slot;
    d->slot = d->range / total;
    slot = d->code / d->slot;
    return slot < total ? slot : total - 1;
}

void cq_decode_freq(cq_range_decoder *d, uint32_t start, uint32_t freq, uint32_t total)
{
    CQ_ASSERT(freq && freq <= total && start <= total - freq);
    CQ_ASSERT(total <= CQI_MIN_RANGE && d->slot == d->range / total); /* cq_decode_slot came before, */
    CQ_ASSERT(d->code >= d->slot * start);                            /* and told a slot of this symbol */
    CQ_ASSERT(d->code - d->slot * start < cqi_freq_width(d->range, d->slot, start, freq, total));
    cqi_decode_interval(d, d->slot * start, cqi_freq_width(d->range, d->slot, start, freq, total));
}

void cq_encode_raw(cq_range_encoder *e, uint32_t value, int bits)
{
    CQ_ASSERT(bits >= 0 && bits <= 32);
    for (; bits > 16; bits -= 8) cq_encode_freq(e, value >> (bits - 8) & 0xff, 1, 256);
    if (bits > 0) cq_encode_freq(e, value & (((uint32_t)1 << bits) - 1), 1, (uint32_t)1 << bits);
}

uint32_t cq_decode_raw(cq_range_decoder *d, int bits)
{
    CQ_ASSERT(bits >= 0 && bits <= 32);
    uint32_t value = 0;
    for (; bits > 0; bits -= bits > 16 ? 8 : bits) {
        const int part = bits > 16 ? 8 : bits;
        const uint32_t total = (uint32_t)1 << part;
        uint32_t slot;
        d->slot = d->range >> part;
        slot = d->code / d->slot;
        slot = slot < total ? slot : total - 1;
        cq_decode_freq(d, slot, 1, total);
        value = value << part | slot;
    }
    return value;
}

/* Picks the number in [low, low + range) with the most zero bits at its end, writes it, and drops zero bytes. Any 2^24
 * numbers have one with 24 zero bits. */
size_t cq_range_encoder_finish(cq_range_encoder *e)
{
    uint64_t end = e->low + e->range, value;
    int bits = 32;
    do {
        uint64_t mask = ((uint64_t)1 << bits--) - 1;
        value = (e->low + mask) & ~mask;
    } while (value >= end);
    e->low = value;
    cqi_shift_low(e); /* the cache */
    cqi_shift_low(e); /* the one byte of low that is not zero */
    e->count -= e->zeros;
    e->zeros = 0;
    return e->count;
}

/* -- Header -------------------------------------------------------------------------------------------------------- */

typedef struct cqi_header {
    cq_shape *shape;
    size_t header_size, payload_size;
    uint32_t payload_crc;
} cqi_header;

/* CRC-32 (IEEE 802.3, reflected), four bits at a time. */
static uint32_t cqi_crc32(uint32_t crc, const uint8_t *data, size_t size)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
        0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu, 0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu
    };
    size_t k;
    crc = ~crc;
    for (k = 0; k < size; k++) {
        crc ^= data[k];
        crc = crc >> 4 ^ table[crc & 15];
        crc = crc >> 4 ^ table[crc & 15];
    }
    return ~crc;
}

/* A reader of header bytes with a sticky result: CQ_NEED_INPUT past the end, CQ_ERROR_CORRUPT for a bad number. */
typedef struct cqi_reader {
    const uint8_t *data;
    size_t size, at;
    cq_result result;
} cqi_reader;

static uint32_t cqi_read_uint(cqi_reader *r, int bytes)
{
    uint32_t value = 0;
    int k;
    if (r->size - r->at < (size_t)bytes) {
        if (r->result == CQ_OK) r->result = CQ_NEED_INPUT;
        r->at = r->size;
        return 0;
    }
    for (k = 0; k < bytes; k++) value |= (uint32_t)r->data[r->at++] << (8 * k);
    return value;
}

/* LEB128, 32 bits, in its shortest form only. */
static uint32_t cqi_read_varint(cqi_reader *r)
{
    uint32_t value = 0, byte;
    int shift = 0;
    do {
        byte = cqi_read_uint(r, 1);
        if (r->result != CQ_OK) return 0;
        if ((shift == 28 && byte > 15) || (shift && !byte)) r->result = CQ_ERROR_CORRUPT;
        value |= (byte & 127) << shift;
        shift += 7;
    } while (byte & 128 && r->result == CQ_OK);
    return value;
}

static void cqi_read_channel(cqi_reader *r, cq_channel *c)
{
    uint32_t k;
    c->kind = (uint8_t)cqi_read_uint(r, 1);
    c->merge = (uint8_t)(c->kind >> 4);
    c->kind &= 15;
    c->components = (uint8_t)cqi_read_uint(r, 1);
    c->bits = (uint8_t)cqi_read_uint(r, 1);
    c->step = cqi_read_uint(r, 4);
    for (k = 0; k < c->components && k < CQ_MAX_COMPONENTS; k++) c->origin[k] = cqi_read_uint(r, 4);
}

static int cqi_channel_is_valid(const cq_channel *c)
{
    static const uint8_t components[CQ_GROUP + 1] = { 8, 30, 12, 4, 24, 30, 30, 2, 2 }; /* bit n: n are allowed */
    return c->kind <= CQ_GROUP && c->components <= CQ_MAX_COMPONENTS && (components[c->kind] >> c->components & 1) &&
           c->merge <= CQ_PER_FACE && (c->merge != CQ_PER_FACE || c->components == 1) && c->bits >= 1 &&
           (c->bits <= 24 || (c->bits == CQ_EXACT_BITS && c->merge != CQ_MIDPOINT));
}

/* Twice the Euler characteristic of the closed mesh, 2 (V - E + F) = 2 V - F, is 4 (components - genus). */
static cq_result cqi_read_counts(cqi_reader *r, cq_shape *s)
{
    int64_t euler, faces;
    uint32_t zigzag;
    s->num_vertices = cqi_read_varint(r);
    s->num_boundary_loops = cqi_read_varint(r);
    if (s->num_boundary_loops) s->num_boundary_edges = cqi_read_varint(r);
    zigzag = cqi_read_varint(r);
    if (r->result != CQ_OK) return r->result;
    if (!s->num_vertices && (s->num_boundary_loops || zigzag)) return CQ_ERROR_CORRUPT;
    euler = zigzag & 1 ? -(int64_t)(zigzag >> 1) - 1 : (int64_t)(zigzag >> 1);
    faces = 2 * ((int64_t)s->num_vertices + s->num_boundary_loops) - 4 * euler - (int64_t)s->num_boundary_edges;
    if (faces < 0 || faces > 0xffffffff || s->num_boundary_edges / 3 < s->num_boundary_loops) return CQ_ERROR_CORRUPT;
    s->num_faces = (uint32_t)faces;
    return CQ_OK;
}

static cq_result cqi_read_body(cqi_reader *r, cqi_header *h)
{
    cq_shape *s = h->shape;
    cq_result result = cqi_read_counts(r, s);
    uint32_t k, payload_size;
    if (result != CQ_OK) return result;
    s->num_channels = cqi_read_uint(r, 1);
    s->fast = s->num_channels >> 7;
    s->num_channels &= 0x7f;
    if (s->num_channels > CQ_MAX_CHANNELS) return CQ_ERROR_UNSUPPORTED;
    for (k = 0; k < s->num_channels; k++) {
        cqi_read_channel(r, &s->channel[k]);
        if (r->result == CQ_OK && !cqi_channel_is_valid(&s->channel[k])) return CQ_ERROR_UNSUPPORTED;
    }
    payload_size = cqi_read_varint(r);
    h->payload_size = (size_t)payload_size;
    h->payload_crc = cqi_read_uint(r, 4);
    if (h->payload_size != payload_size || h->payload_size > SIZE_MAX - CQ_MAX_HEADER_BYTES)
        return CQ_ERROR_TOO_LARGE; /* unreachable: size_t of 64 bits */
    return r->result;
}

/* The check value comes last: what the counts and channels say decides where it is, and is judged on the way. */
static cq_result cqi_read_header(const uint8_t *data, size_t size, cqi_header *h)
{
    static const uint8_t magic[3] = { 'C', 'Q', CQ_STREAM_VERSION };
    cqi_reader r;
    cq_result result;
    size_t k;
    memset(h->shape, 0, sizeof *h->shape);
    h->header_size = h->payload_size = 0;
    for (k = 0; k < size && k < 3; k++)
        if (data[k] != magic[k]) return k < 2 ? CQ_ERROR_FORMAT : CQ_ERROR_VERSION;
    if (size < 3) return CQ_NEED_INPUT;
    r.data = data;
    r.size = size;
    r.at = 3;
    r.result = CQ_OK;
    result = cqi_read_body(&r, h);
    if (result != CQ_OK) return result;
    k = r.at;
    if (cqi_read_uint(&r, 2) != (cqi_crc32(0, data, k) & 0xffff) && r.result == CQ_OK) return CQ_ERROR_CHECKSUM;
    h->header_size = r.at;
    return r.result;
}

cq_result cq_peek(const uint8_t *data, size_t size, cq_shape *shape, size_t *header_bytes, size_t *stream_bytes)
{
    cqi_header h;
    cq_result result;
    if (!shape || (size && !data)) return CQ_ERROR_ARGUMENT;
    h.shape = shape;
    result = cqi_read_header(data, size, &h);
    if (header_bytes) *header_bytes = h.header_size;
    if (stream_bytes) *stream_bytes = h.header_size + h.payload_size;
    return result;
}

static cqi_size cqi_decoder_size(const cq_shape *s)
{
    return CQ_DECODER_BYTES(cqi_all_vertices(s), cqi_all_faces(s), cqi_all_components(s, 0)) +
           cqi_all_components(s, 1) * CQ_FACE_BYTES(s->num_faces);
}

size_t cq_decoder_bytes(const cq_shape *s)
{
    if (!s || !cqi_countable(s)) return 0;
    return cqi_bytes(cqi_decoder_size(s));
}

/* -- Coding: one routine for both directions ------------------------------------------------------------------------
 *
 * Everything from here to the encoder is run by the decoder, and by the encoder when it replays its choices from the
 * base. A function called cqi_code_x returns the x of the stream: when decoding it reads it, when encoding it writes
 * the one that is passed in, which the plan has looked up. Nothing else differs, so the two cannot drift apart. */

#ifdef CQ_NO_ENCODER
#define CQI_ENCODING(d) 0
#else
#define CQI_ENCODING(d) ((d)->plan != NULL)
#endif

#ifdef CQ_NO_REPORTS
#define CQI_REPORTING(d) 0
#else
#define CQI_REPORTING(d) ((d)->report != NULL)
#endif

/* What the encoder notes of a collapse, for the split that takes it back. */
typedef struct cqi_collapse {
    cq_index removed;     /* B, by its input number */
    cq_index patch;       /* number of its patch in the level */
    uint8_t p, q;         /* its two common neighbours, as positions on the patch's ring */
    uint8_t side;         /* of a first gate, see cqi_first_spoke */
    uint8_t level;        /* that collapsed it, 1 is the finest */
} cqi_collapse;

/* What the encoder noted while it simplified. Vertices of its own mesh have "input" numbers. */
typedef struct cqi_plan {
    cq_range_encoder range;
    cq_mesh mesh;                       /* simplified step by step, in the end the base */
    const cq_value *positions;          /* those in value, if they decide what is collapsed; or NULL */
    uint32_t most_loss;                 /* of a collapse at this level; CQI_ANY_LOSS: whatever it is */
    uint32_t level_loss;                /* how much it grows from level to level */
    uint32_t refused_loss;              /* smallest one that was refused at this level */
    cq_value *value[CQ_MAX_CHANNELS];   /* of input vertices; after the collapse of B into A, B's slot holds B - A,
                                           with CQ_KEEP still B */
    const cq_value *const *input;       /* values as handed in: those of faces */
    cqi_collapse *collapse;             /* in order; the replay takes the last level first */
    cq_index next_collapse;             /* where the next one is put, or is taken from */
    cq_index *decoded;                  /* numbers of input vertices, virtual ones too, in the decoded mesh; CQ_NONE:
                                           not yet there */
    cq_index *to_input;                 /* input vertices of those of the decoded base */
    cq_index *patch;                    /* of the conquest, as in the decoder */
    cq_index *seed;                     /* components: cq_index[components][2], L and R of the first gate */
    cq_index num_seeds, next_seed;
    cq_index *face_input, *face_decoded;  /* input halfedge of decoded 3f; decoded halfedge of input 3f; faces that a
                                             split makes may be turned */
    int follows_faces;                  /* of all levels, for their values or face_map; or of the base only */
    uint32_t num_levels;
    uint32_t current;                   /* level being made or replayed */
} cqi_plan;

/* Speed of adaptation: of bit models (higher is slower), and of weights, where the wrong candidate was certain; after
 * how many splits they learn from one. And how far under the best candidate positions are not asked about another. */
#define CQI_RATE(num_vertices) ((num_vertices) < 1024 ? 5 : (num_vertices) < 8192 ? 6 : 7)
#define CQI_STEP 110000
#define CQI_LEARN_EVERY 8
#define CQI_SETTLED ((int32_t)5 << CQI_UNIT)

/* The trainer has its own: it learns slowly, and asks about all. */
#ifndef CQ_TRAINING
#define CQI_TUNED(name, usual) (usual)
#endif

/* -- What is asked for before it is read --
 *
 * Neighbours are far apart in a large mesh, so that most time would go into waiting for memory. CQI_FETCH is a hint,
 * which changes nothing, and may ask for what is never read. (It is a macro as GCC drops calls of functions that do
 * nothing else.) */

/* The faces of a level lie in the order of its splits, which is that of its patches, reversed: a conquest reads the
 * faces of each level backwards, so it will read these. The encoder's lie as they came, mostly forwards. Both are
 * halfedges of the mesh. */
static inline cq_index cqi_before(cq_index h) { return (cq_index)(h > CQI_APART ? h - CQI_APART : 0); }
static inline cq_index cqi_behind(const cq_mesh *m, cq_index h)
{
    return (cq_index)(h + CQI_APART < 3 * m->first_virtual_face ? h + CQI_APART : h);
}

/* Do vertices have values of the first channel, which are asked for too? */
static inline int cqi_has_first_values(const cq_shape *s)
{
    return s->num_channels && s->channel[0].merge != CQ_PER_FACE;
}

/* -- The plan: what the encoder looks up while it replays -- */

/* The spoke that runs from one vertex to a neighbour of it. */
static cq_index cqi_find_spoke(const cq_mesh *m, cq_index from, cq_index to)
{
    cq_index h = m->out[from];
    while (cq_target(m, h) != to) h = cq_clockwise(m, h);
    return h;
}

/* Corner k of the face at h, counted from h. */
static cq_index cqi_corner(cq_index h, int k) { return k == 0 ? h : k == 1 ? cq_next(h) : cq_prev(h); }

/* First gate of the next component, as an input halfedge. */
static cq_index cqi_plan_seed(cqi_plan *p)
{
    const cq_index *gate = p->seed + 2 * (size_t)p->next_seed++;
    return cqi_find_spoke(&p->mesh, gate[0], gate[1]);
}

static void cqi_plan_vertex(cqi_plan *p, cq_index input, cq_index decoded)
{
    p->decoded[input] = decoded;
    p->to_input[decoded] = input;
}

/* Face at input halfedge h is now decoded face f, corner 0 at h. */
static void cqi_plan_face(cqi_plan *p, cq_index h, cq_index f)
{
    p->face_input[f] = h;
    p->face_decoded[h / 3] = (cq_index)(3 * f + (3 - h % 3) % 3);
}

/* Decoded faces first .. end - 1 are new: those that the collapse removed, as slots are reused last in, first out. */
static void cqi_plan_new_faces(cqi_plan *p, cq_index first, cq_index end)
{
    for (; first < end; first++) cqi_plan_face(p, (cq_index)(3 * cqi_new_face(&p->mesh, 0)), first);
}

static cq_index cqi_plan_to_input(const cqi_plan *p, cq_index decoded)
{
    return cqi_corner(p->face_input[decoded / 3], (int)(decoded % 3));
}

static cq_index cqi_plan_to_decoded(const cqi_plan *p, cq_index input)
{
    cq_index first = p->face_decoded[input / 3];
    return first == CQ_NONE ? CQ_NONE : cqi_corner(first, (int)(input % 3));
}

/* The border halfedge that ends at x, seen from a new face with halfedge x -> w: the gap at x that the face begins
 * to fill ends at the first face clockwise that is there already. More than a step only for a join, which splits the
 * gap in two: no valence is searched more often than joins meet at it. */
static cq_index cqi_plan_border(const cqi_plan *p, cq_index x_to_w)
{
    cq_index t = p->mesh.twin[x_to_w];
    while (cqi_plan_to_decoded(p, t) == CQ_NONE) t = p->mesh.twin[cq_next(t)];
    return cqi_plan_to_decoded(p, t);
}

/* The collapses of a level are replayed twice: forth when its patches are conquered, then back as they are split. */
static void cqi_plan_rewind(cqi_plan *p, uint32_t level)
{
    p->current = level;
    while (p->next_collapse && p->collapse[p->next_collapse - 1].level == level) p->next_collapse--;
}

/* The next collapse, if it is that of a patch of this level; or NULL. */
static const cqi_collapse *cqi_plan_patch(const cqi_plan *p, cq_index patch)
{
    const cqi_collapse *c = &p->collapse[p->next_collapse];
    return c->level == p->current && c->patch == patch ? c : NULL;
}

/* Bit with model number `index`. */
static int cqi_code_bit(cq_decoder *d, int index, int bit)
{
    cq_bit_model *model = &d->model.bit[index];
    if (!CQI_ENCODING(d)) return cq_decode_bit(&d->range, model, d->rate);
    cq_encode_bit(&d->plan->range, model, d->rate, bit);
    return bit;
}

static uint32_t cqi_code_raw(cq_decoder *d, uint32_t value, int bits)
{
    if (!CQI_ENCODING(d)) return cq_decode_raw(&d->range, bits);
    cq_encode_raw(&d->plan->range, value, bits);
    return value;
}

/* Did the last symbols need bytes that are missing? Asked before what they say is applied. */
static int cqi_starved(const cq_decoder *d) { return d->payload_left && d->range.count > d->range.size; }

/* log2(x) in 1/65536, rounded down, x > 0. */
static uint32_t cqi_log2(uint32_t x)
{
    int n = cqi_bit_length(x) - 1, k;
    uint64_t m = (uint64_t)x << (31 - n); /* in [1, 2) with 31 fraction bits */
    uint32_t result = (uint32_t)n;
    for (k = 0; k < 16; k++) {
        m = m * m >> 31;
        result = result << 1 | (uint32_t)(m >> 32);
        if (m >> 32) m >>= 1;
    }
    return result;
}

/* Adds what was coded since the last call to two entries of the report, in 1/65536 bit. */
static void cqi_charge(cq_decoder *d, uint64_t *entry, uint64_t *level_entry)
{
    uint64_t bytes = d->dropped + d->range.count, now;
    uint32_t range = d->range.range;
    if (CQI_ENCODING(d)) {
        bytes = d->plan->range.count + d->plan->range.pending + (d->plan->range.cache >= 0 ? 5 : 4);
        range = d->plan->range.range;
    }
    now = bytes * 8 * 65536 - cqi_log2(range);
    *entry += now - d->cost;
    if (level_entry) *level_entry += now - d->cost;
    d->cost = now;
}

static cq_level *cqi_level_report(cq_decoder *d) { return &d->report->level[(d->level - 1) % CQ_MAX_LEVELS]; }

static void cqi_charge_channel(cq_decoder *d, uint32_t channel)
{
    cq_report *r = d->report;
    if (!CQI_REPORTING(d)) return;
    cqi_charge(d, d->shape.channel[channel].kind == CQ_POSITION ? &r->positions : &r->channels,
               d->level ? &cqi_level_report(d)->values : NULL);
}

/* -- Priors: what the models know before the first symbol --
 *
 * Fitted by `make train` (tests/train) on meshes that are neither in the paper's Table 1 nor in the bench; written
 * by it between the two marks. Bits: probability of a 1 in 1/256. Weights: in 1/16 octave, for bare connectivity and
 * with positions. They are part of the format: another table is another stream version. */
#ifndef CQ_TRAINING
/* priors begin */
static const uint8_t cqi_prior_bit[CQI_PRIORS] = {
    120, 76, 0, 109, 114, 128, 128, 128, 128, 128, 128, 128, 128, 128, 255, 128, 128, 128, 128, 128, 128, 128,
    93, 135, 129, 93, 112, 62, 95, 128, 144, 117, 88, 88, 54, 77, 42, 128, 143, 112, 76, 65, 81, 47,
    44, 128, 135, 55, 45, 15, 55, 26, 15, 128, 141, 89, 64, 42, 42, 65, 36, 128, 127, 56, 54, 27,
    30, 31, 21, 128, 128, 130, 102, 130, 145, 140, 145, 128, 0, 66, 124, 130, 144, 137, 148, 128, 128, 128,
    49, 16, 43, 124, 191, 238, 229, 226, 141, 128, 128, 128, 255, 242, 243, 249, 251, 251, 248, 249, 228, 128,
    128, 128, 89, 255, 252, 253, 253, 253, 252, 252, 239, 128, 128, 128, 123, 246, 254, 254, 254, 254, 254, 254,
    252, 128, 128, 128, 157, 115, 122, 111, 123, 113, 104, 96, 82, 72, 79, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 142, 150, 110, 114, 165, 212, 239, 248, 138, 133, 124, 130, 116, 117, 106,
    128, 121, 128, 128, 115, 108, 101, 93, 84, 82, 78, 67, 64, 79, 62, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 128, 118, 84, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 163, 92, 90, 115, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 178, 96, 50, 99, 128,
    128, 128, 128, 16, 128, 128, 128, 128, 128, 128, 128, 183, 141, 72, 17, 115, 128, 128, 128, 0, 128, 128,
    128, 128, 128, 128, 128, 120, 87, 27, 37, 128, 128, 128, 128, 111, 0, 128, 128, 128, 128, 128, 128, 162,
    117, 42, 8, 94, 128, 128, 128, 97, 0, 128, 128, 128, 128, 128, 128, 86, 58, 7, 34, 128, 128, 128,
    128, 134, 93, 0, 128, 128, 128, 128, 128, 115, 83, 28, 45, 15, 128, 128, 128, 128, 89, 0, 128, 128,
    128, 128, 128, 65, 46, 18, 4, 128, 128, 128, 128, 155, 125, 88, 0, 128, 128, 128, 128, 87, 67, 14,
    13, 47, 128, 128, 128, 160, 141, 95, 0, 128, 128, 128, 128, 57, 36, 14, 8, 104, 128, 128, 128, 175,
    150, 138, 102, 0, 128, 128, 128, 94, 70, 23, 9, 44, 128, 128, 128, 144, 129, 111, 89, 0, 128, 128,
    128, 61, 55, 17, 13, 77, 128, 128, 128, 168, 152, 139, 127, 105, 0, 128, 128, 98, 95, 39, 15, 14,
    128, 128, 128, 158, 149, 150, 144, 119, 0, 128, 128, 88, 90, 57, 3, 57, 128, 128, 128, 161, 142, 141,
    130, 122, 115, 14, 128, 123, 125, 73, 22, 2, 115, 128, 128, 144, 134, 128, 121, 112, 96, 30, 128, 145,
    128, 128, 107, 115, 106, 90, 81, 78, 80, 70, 63, 62, 85, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 128, 128, 100, 81, 115, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    135, 76, 42, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 179, 105, 42, 71, 115, 128, 128,
    128, 1, 128, 128, 128, 128, 128, 128, 128, 183, 151, 66, 11, 87, 128, 128, 128, 0, 128, 128, 128, 128,
    128, 128, 128, 121, 94, 23, 1, 126, 128, 128, 128, 101, 0, 128, 128, 128, 128, 128, 128, 150, 106, 45,
    6, 62, 128, 128, 128, 96, 0, 128, 128, 128, 128, 128, 128, 90, 81, 27, 7, 63, 128, 128, 128, 153,
    129, 0, 128, 128, 128, 128, 128, 111, 124, 47, 14, 5, 104, 128, 128, 149, 114, 0, 128, 128, 128, 128,
    128, 78, 67, 21, 7, 62, 115, 128, 128, 164, 137, 101, 0, 128, 128, 128, 128, 98, 109, 46, 13, 6,
    104, 128, 128, 165, 145, 106, 0, 128, 128, 128, 128, 73, 72, 27, 12, 17, 128, 128, 128, 166, 151, 135,
    102, 0, 128, 128, 128, 110, 111, 47, 24, 24, 59, 128, 128, 150, 139, 127, 92, 0, 128, 128, 128, 84,
    76, 39, 22, 43, 106, 115, 128, 155, 144, 139, 120, 99, 0, 128, 128, 124, 116, 60, 30, 11, 83, 128,
    128, 146, 137, 123, 127, 87, 0, 128, 128, 93, 91, 43, 18, 5, 128, 128, 128, 156, 143, 131, 130, 124,
    91, 48, 128, 129, 127, 66, 18, 14, 94, 128, 128, 154, 137, 127, 129, 109, 97, 15, 128, 99, 128, 128,
    92, 87, 84, 86, 85, 91, 79, 73, 61, 22, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 120, 67, 3, 79, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 151, 89,
    10, 19, 77, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 167, 109, 28, 16, 70, 97, 115, 128, 0,
    128, 128, 128, 128, 128, 128, 128, 189, 117, 53, 22, 32, 101, 77, 128, 0, 128, 128, 128, 128, 128, 128,
    128, 99, 59, 26, 9, 73, 115, 104, 128, 97, 0, 128, 128, 128, 128, 128, 128, 117, 81, 35, 12, 29,
    111, 128, 116, 91, 0, 128, 128, 128, 128, 128, 128, 58, 55, 19, 22, 77, 109, 114, 128, 146, 93, 0,
    128, 128, 128, 128, 128, 83, 80, 45, 20, 13, 129, 114, 128, 135, 88, 0, 128, 128, 128, 128, 128, 48,
    75, 19, 4, 98, 128, 128, 128, 168, 125, 87, 0, 128, 128, 128, 128, 78, 93, 33, 15, 35, 144, 139,
    113, 153, 115, 89, 0, 128, 128, 128, 128, 55, 55, 18, 25, 106, 140, 115, 128, 166, 139, 117, 85, 0,
    128, 128, 128, 94, 87, 42, 30, 26, 115, 128, 128, 149, 129, 111, 87, 0, 128, 128, 128, 68, 73, 33,
    23, 94, 115, 128, 128, 158, 136, 122, 111, 76, 0, 128, 128, 108, 110, 67, 15, 42, 116, 127, 128, 149,
    135, 130, 111, 89, 0, 128, 128, 90, 93, 30, 9, 96, 115, 128, 128, 158, 144, 136, 134, 129, 91, 41,
    128, 122, 117, 56, 16, 18, 128, 128, 128, 149, 131, 143, 115, 108, 99, 37, 128, 32, 36, 32, 51, 44,
    76, 111, 128, 46, 39, 16, 29, 86, 109, 107, 128, 64, 55, 26, 53, 55, 91, 41, 128, 76, 62, 21,
    24, 36, 44, 126, 128,
};
static const int8_t cqi_prior_bare[CQI_BARE_WEIGHTS] = {
    0, -70, 0, 27, 45, 29, 6, -13, -17, -6, -2, 1, 0, 1, 0, -1, 0, -70, 7, 29, 36, 19,
    17, -8, -22, -8, -1, -1, 1, 0, 1, 0, 0, -99, -12, 17, 31, 31, 32, 24, 12, -2, -5, -9,
    -4, -2, -7, -8, 0, -64, 7, 35, 50, 32, 8, -18, -27, -18, -4, -1, -1, -2, 1, 3, 0, -68,
    11, 37, 44, 23, 19, -11, -31, -21, -3, -3, 1, -2, 3, 0, 0, -89, -4, 25, 37, 33, 31, 20,
    13, -1, -7, -10, -7, -11, -13, -18, 29, 35, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 1,
    3, 5, 21, 17, 0, 0, 0, 0, 9, 19, -1, -6, 1, 1, 2, 1, 0, 0, 0, 0, 13, 23,
    -9, -11, -5, -7, -5, -6, -3, -3, -5, -9, 7, 10, -6, -8, -7, -3, -9, -9, -6, -8, -9, -10,
    21, 15, -6, -10, -12, -15, -12, -14, -11, -14, -14, -13, 16, 23, 0, -4, -15, -16, -6, -7, -11, -16,
    -11, -14, 12, 23, 2, -1, -14, -16, 0, -2, -11, -11, -14, -11, 17, 20, 0, 0, -13, -18, 7, 6,
    -4, 1, -3, -7, 15, 12, 3, 0, -10, -13, 5, 4, -2, 1, -3, -3, 9, 11, -1, 0, -4, -8,
    7, -1, 9, -2, -1, 2, 6, 14, 0, 0, -2, -8, 2, 0, 2, 13, -1, 1, 10, 8, 0, 0,
    -5, -1, -1, 0, 4, -3, 3, 0, 9, 7, -1, 0, -9, 4, 0, 1, -2, 8, 5, 4, 14, 16,
    5, 16, 18, 17, 12, 13, -11, -14, -19, -25, -19, -26, -14, -17, -4, -5, 3, 2, 1, 0, 9, 0,
    -2, 5, 8, 0, 12, 34, 6, 3, 11, 17, 2, 5, -6, -7, 5, 8, -14, -10, -9, -8, -9, -11,
    2, -5, 3, 0, 4, 1, 9, 3, -2, 1, -4, 4, 19, 17, 5, 8, 1, 1, -4, -4, -3, -6,
    -7, -6, -8, -8, -6, -5, -4, -3, -1, 1, 3, 2, 3, 6, 4, 2, -1, -6, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, -21, -28, -21, -10, -11, -52, -28, -33, -21, -22, -22, -58, -31, -39, -24, -27,
    -22, -53, -20, -25, 70, 63, 60, 57, -9, -28, 69, 61, 57, 54, -56, -60, 64, 57, 56, 53,
};
static const int8_t cqi_prior_located[CQI_WEIGHTS] = {
    0, -39, -4, 22, 36, 22, 3, -19, -14, -5, -2, 0, 0, 1, 0, 0, 0, -40, 3, 24, 26, 9,
    11, -12, -18, -4, -1, -1, 1, 0, 1, 0, 0, -66, -14, 15, 23, 22, 23, 17, 6, -5, -7, -7,
    0, 1, -4, -4, 0, -43, -1, 17, 32, 21, 8, -9, -11, -9, -5, -1, 0, -2, 0, 2, 0, -46,
    6, 19, 27, 12, 17, -4, -16, -13, -1, -3, 1, -2, 3, 0, 0, -60, -6, 11, 21, 22, 26, 20,
    15, 3, -2, -6, -5, -9, -11, -18, 17, 20, 0, 0, 0, 0, 0, 0, 0, 0, -6, -6, -2, -4,
    -3, -4, 13, 11, 0, 0, 0, 0, 5, 12, -5, -8, -4, -4, -2, -2, 0, 0, 0, 0, 11, 18,
    -9, -10, -8, -9, -6, -5, -5, -5, -5, -6, 1, -1, -3, -5, -4, -1, -8, -5, -5, -6, -7, -6,
    12, 5, 0, -4, -9, -11, -10, -9, -9, -10, -11, -8, 9, 10, 0, -1, -8, -8, 1, 0, -6, -11,
    -4, -8, -1, 9, 2, 0, -8, -7, 5, 2, -5, -2, -4, -4, 5, 6, 0, 0, -13, -11, 10, 7,
    0, 4, 3, 1, 6, 0, 3, 0, -9, -6, 6, 4, 3, 5, 4, 7, 1, -3, -1, -1, 2, -4,
    6, 0, 13, 2, 3, 9, -1, 3, 0, 0, 0, -5, 1, 1, 5, 15, 5, 9, 4, -5, 0, 0,
    -2, 3, -1, 0, 5, 1, 9, 6, -1, -2, -1, 0, -5, 10, 1, 1, 5, 15, 16, 14, -2, -3,
    -3, 1, 10, 3, 6, 7, -17, -20, -17, -23, -12, -18, -7, -8, 3, 8, 4, 6, 3, 2, 9, 3,
    -1, 3, 8, 2, 14, 35, -1, -6, 4, 10, -2, 0, -8, -9, 8, 11, -11, -8, -2, -4, -3, -7,
    3, -2, 3, 1, 7, 2, 10, 3, -3, 3, -2, 6, 16, 18, -1, 3, -4, -3, -7, -7, -5, -6,
    -6, -5, -8, -7, -5, -6, -1, -2, 2, 3, 5, 3, 6, 8, 6, 3, 2, -3, 27, 28, 10, 11,
    9, 7, -2, -4, -4, -3, -8, -9, -3, -5, -8, -6, -9, -11, -8, -6, -9, -7, -9, -8, -11, -12,
    0, -1, -18, -18, 44, 43, -17, -22, -19, -11, -12, -53, -26, -29, -17, -21, -25, -62, -27, -38, -5, -8,
    -11, -21, -20, -29, 59, 55, 54, 49, -11, -34, 58, 55, 53, 48, -55, -65, 56, 51, 51, 48, 29, 16,
    6, -7, -11, -13, -11, -4, 13, 5, -1, -9, -10, -14, -6, -10, 5, 2, 5, -4, 1, -6, -4, -4,
    -6, -4, -3, 0, 2, -2, -2, 0, -10, -7, -3, -2, 2, 2, 1, 5, -11, -9, -5, 1, -1, 13,
    -2, 2, -11, -10, -9, 2, -2, 6, 7, 6, -4, -11, -3, 3, 7, 4, 7, 35, 16, 21, 19, 14,
    13, 10, 5, -2, 22, 17, 17, 14, 11, 5, -5, -16, 19, 17, 14, 14, 7, -1, -13, -24, 14, 13,
    13, 13, 2, -12, -22, -16, 14, 9, 9, 2, -1, -12, -23, -9, 11, 4, -5, -8, -13, -16, -18, -12,
    6, -5, -14, -15, -17, -23, -21, -12, -1, -11, -8, -7, -14, -15, -10, -15, 0, 0, 0, 0, 0, 0,
    0, 0, -5, -7, -9, -15, -6, -22, -30, -37, 37, 28, 18, 13, 5, 2, 2, 3, 22, 8, 3, -2,
    -5, -5, -6, -8, 14, 3, 3, 0, 8, 5, 6, 0, -5, -9, -1, -6, -10, -33, -42, -40, 22, 19,
    10, 3, -4, -5, -4, 4, 21, 8, 4, 2, 1, 1, -2, -8,
};
static const int8_t cqi_prior_fast[CQI_FAST_WEIGHTS] = {
    0, -57, 7, 31, 40, 11, -8, -16, -5, -3, -1, 0, 0, 0, 0, 0, 0, -62, 18, 32, 29, 5,
    0, -10, -8, -2, 0, 0, 0, 0, 0, -1, 0, -52, 19, 31, 25, 9, 1, -10, -4, -11, 1, -2,
    -3, -1, -1, -3, 0, -40, -2, 25, 38, 21, 0, -20, -16, -4, -1, -1, 0, 0, 0, 0, 0, -42,
    9, 23, 31, 13, 7, -12, -18, -8, -2, 0, -1, 0, 0, 2, 0, -56, 7, 19, 21, 12, 7, 1,
    -2, -3, -3, -1, -3, 1, -1, 1, 9, 7, 0, 0, 0, 0, 0, 0, 0, 0, -1, 3, -3, 0,
    0, -3, 4, 8, 0, 0, 0, 0, -1, 4, -3, -2, -2, 1, -4, -3, 0, 0, 0, 0, 6, 3,
    -7, -5, -5, -5, -7, -4, -4, -6, -8, -9, -1, 3, 0, 1, -2, -1, -1, -3, -5, -4, -6, -5,
    -3, 1, 0, 0, -6, -6, -2, -2, -5, -5, -4, -4, 2, -2, 5, -2, -7, -4, 0, 1, -5, 0,
    5, -1, 3, -1, 0, 1, -6, -2, 2, 0, 6, 1, -4, -3, 1, 0, 1, 0, -4, -1, -1, 0,
    3, 3, 5, 4, 4, -2, 0, 0, 2, -1, 0, 0, -1, 4, 5, -2, 3, 2, 0, 0, 3, -3,
    1, 0, 0, 1, 4, 2, 2, 0, 0, 0, -1, -2, 0, 0, 5, -2, 3, 4, 0, 1, 0, 0,
    -2, 0, 0, 0, 1, -2, 3, 5, -1, 1, 0, 0, 3, 1, 0, 0, -1, 11, 6, 10, 17, 16,
    0, 2, 10, 9, 7, 9, -14, -13, -14, -11, -4, -10, -4, -6, 3, 0, 1, 2, 0, 1, 2, 0,
    6, -1, 0, 2, 8, 17, 4, 0, -3, 2, -3, -4, -10, -8, 3, 3, -6, -9, 7, 2, -4, -1,
    4, 0, 4, -1, -1, 1, 1, 1, 0, 2, 6, 12, 5, 8, -6, -2, -6, -6, -8, -6, -5, -3,
    -5, -2, -2, -2, -1, -2, 2, 2, 4, 3, 8, -2, 1, 1, 2, 0, 11, 10, 41, 38, 25, 24,
    8, 7, -5, -4, -11, -11, -13, -15, -15, -15, -12, -14, -12, -12, -11, -9, -11, -9, -13, -6, -4, -4,
    -2, -1, 5, 4, 29, 27,
};
/* priors end */

static void cqi_model_init(cqi_model *m, const cq_shape *s)
{
    const int located = cqi_context_channel(s) >= 0;
    const int8_t *prior = s->fast ? cqi_prior_fast : located ? cqi_prior_located : cqi_prior_bare;
    const int num_weights = s->fast ? CQI_FAST_WEIGHTS : located ? CQI_WEIGHTS : CQI_BARE_WEIGHTS;
    int k;
    for (k = 0; k < CQI_FACE; k++) {
        int from = k < CQI_PRIORS ? k : k - (CQI_PLAIN - CQI_ALONG);
        m->bit[k] = (cq_bit_model)(256u * cqi_prior_bit[from] + 128u);
    }
    for (; k < CQI_MODELS; k++) m->bit[k] = 256u * 240u + 128u;
    memset(m->weight, 0, sizeof m->weight);
    for (k = 0; k < num_weights; k++) m->weight[k] = prior[k] * ((int32_t)1 << (CQI_UNIT - 4));
}
#else
static void cqi_model_init(cqi_model *m, const cq_shape *s); /* the trainer's: both */
static void cqi_model_keep(const cqi_model *m);
#endif

/* -- Base ------------------------------------------------------------------------------------------------------------
 *
 * Components one after another, each grown face by face from the triangle of its first gate. While it grows, twin[]
 * is a permutation: border halfedges form loops, twin[h] being the border halfedge after h, and where a loop has
 * shrunk to two halfedges they are each other's twins in the sense of the mesh. So gluing needs no step of its own.
 * The gate is a border halfedge u -> w; what follows is a face w, u, x, and only x is coded:
 *
 *     grow    x is new
 *     turn    x is the start of the border halfedge before the gate: the face closes the fan of u
 *     close   x is the end of the one after the gate: the face closes the fan of w
 *     join    x is the end of any other border halfedge, whose number is coded: splits the loop, or merges two
 */
enum { CQI_GROW, CQI_TURN, CQI_CLOSE, CQI_JOIN };

typedef struct cqi_base_op {
    int kind;
    cq_index border;  /* the border halfedge that ends at x; CQI_GROW: unused */
    cq_index vertex;  /* x */
} cqi_base_op;

static int cqi_is_open(const cq_mesh *m, cq_index h) { return m->twin[m->twin[h]] != h; }

static cq_index cqi_new_virtual(cq_mesh *m)
{
    return m->num_virtual < m->max_virtual ? (cq_index)(m->first_virtual + m->num_virtual++) : CQ_NONE;
}

/* A new vertex, virtual ones only where allowed. CQ_NONE if there is no room. */
static cq_index cqi_code_base_vertex(cq_decoder *d, int may_be_virtual, int is_virtual)
{
    cq_mesh *m = &d->draft;
    cq_index v;
    may_be_virtual = may_be_virtual && m->num_virtual < m->max_virtual;
    is_virtual = may_be_virtual && cqi_code_bit(d, CQI_LOOP, is_virtual);
    v = is_virtual ? cqi_new_virtual(m) : cqi_new_vertex(m);
    if (v != CQ_NONE) m->valence[v] = 0;
    return v;
}

/* The same for the vertex that the encoder knows by its input number. */
static cq_index cqi_code_new_vertex(cq_decoder *d, int may_be_virtual, cq_index input)
{
    cq_index v = cqi_code_base_vertex(d, may_be_virtual, CQI_ENCODING(d) && cq_is_virtual(&d->plan->mesh, input));
    if (CQI_ENCODING(d)) cqi_plan_vertex(d->plan, input, v);
    return v;
}

/* Adds face a, b, c with its halfedges unlinked; `input` is where the encoder finds it. CQ_NONE if there is no room. */
static cq_index cqi_add_face(cq_decoder *d, cq_index a, cq_index b, cq_index c, cq_index input)
{
    cq_mesh *m = &d->draft;
    cq_index f = cqi_new_face(m, cq_is_virtual(m, a) || cq_is_virtual(m, b) || cq_is_virtual(m, c));
    if (f == CQ_NONE) return CQ_NONE;
    cqi_set_face(m, f, a, b, c);
    m->valence[a]++;
    m->valence[b]++;
    m->valence[c]++;
    m->out[a] = (cq_index)(3 * f);
    m->out[b] = (cq_index)(3 * f + 1);
    m->out[c] = (cq_index)(3 * f + 2);
    if (CQI_ENCODING(d)) cqi_plan_face(d->plan, input, f);
    return f;
}

#define CQI_SEED 0x40 /* bit of mark[v]: v is the L of its component's first gate, v + 1 the R */

/* The first triangle L, R, X of a component. The first gate to be grown at is L -> R. */
static cq_result cqi_start_component(cq_decoder *d)
{
    cq_mesh *m = &d->draft;
    cq_index v[3] = { CQ_NONE, CQ_NONE, CQ_NONE }, input = 0, corner = 0, f, h;
    int k;
    if (CQI_ENCODING(d)) input = cqi_plan_seed(d->plan);
    for (k = 0; k < 3; k++) {
        if (CQI_ENCODING(d)) corner = d->plan->mesh.origin[cqi_corner(input, k)];
        v[k] = cqi_code_new_vertex(d, k == 2, corner);
        if (v[k] == CQ_NONE || cqi_starved(d)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
    }
    f = cqi_add_face(d, v[0], v[1], v[2], input);
    if (f == CQ_NONE) return CQ_ERROR_CORRUPT;
    m->mark[v[0]] |= CQI_SEED;
    h = (cq_index)(3 * f);
    m->twin[h] = (cq_index)(h + 1);
    m->twin[h + 1] = (cq_index)(h + 2);
    m->twin[h + 2] = h;
    d->gate = h;
    d->before = (cq_index)(h + 2);
    d->before2 = (cq_index)(h + 1);
    d->num_components++;
    return CQ_OK;
}

/* Halfedges of the draft, real ones first, as numbers without a gap. */
static cq_index cqi_num_halfedges(const cq_mesh *m) { return (cq_index)(3 * (m->num_faces + m->num_virtual_faces)); }

static cq_index cqi_nth_halfedge(const cq_mesh *m, cq_index n)
{
    return (cq_index)(n < 3 * m->num_faces ? n : n - 3 * m->num_faces + 3 * m->first_virtual_face);
}

static cq_index cqi_halfedge_number(const cq_mesh *m, cq_index h)
{
    return (cq_index)(h < 3 * m->num_faces ? h : h - 3 * m->first_virtual_face + 3 * m->num_faces);
}

/* The kind of the gate, and for a join the border halfedge. In an encoder *border is the right one already. */
static int cqi_code_gate(cq_decoder *d, int kind, cq_index *border)
{
    const cq_mesh *m = &d->draft;
    cq_index u = m->valence[m->origin[d->gate]], w = m->valence[cq_target(m, d->gate)], n;
    u = u < 7 ? u : 7;
    w = w < 7 ? w : 7;
    if (cqi_code_bit(d, CQI_KIND_GROW + (int)(8 * u + w), kind == CQI_GROW)) return CQI_GROW;
    if (cqi_code_bit(d, CQI_KIND_TURN + (int)u, kind == CQI_TURN)) return CQI_TURN;
    if (cqi_code_bit(d, CQI_KIND_CLOSE + (int)w, kind == CQI_CLOSE)) return CQI_CLOSE;
    n = CQI_ENCODING(d) ? cqi_halfedge_number(m, *border) : 0;
    n = (cq_index)cqi_code_raw(d, n, cqi_bit_length((uint32_t)cqi_num_halfedges(m) - 1));
    *border = n < cqi_num_halfedges(m) ? cqi_nth_halfedge(m, n) : d->gate;
    return CQI_JOIN;
}

/* What the encoder sees behind the gate: the kind, the apex and the border halfedge before it. */
static int cqi_plan_gate(const cq_decoder *d, cq_index behind, cq_index *apex, cq_index *border)
{
    const cqi_plan *p = d->plan;
    *apex = p->mesh.origin[cq_prev(behind)];
    if (p->decoded[*apex] == CQ_NONE) return CQI_GROW;
    if (cqi_plan_to_decoded(p, p->mesh.twin[cq_next(behind)]) == d->before) return CQI_TURN;
    *border = cqi_plan_border(p, cq_prev(behind));
    return *border == d->draft.twin[d->gate] ? CQI_CLOSE : CQI_JOIN;
}

/* Links the new face w, u, x at halfedge k into the border; n is the border halfedge after the gate, and `border`
 * the one that ends at x, or CQ_NONE if x is new. */
static void cqi_link_face(cq_decoder *d, cq_index k, cq_index border)
{
    cq_mesh *m = &d->draft;
    cq_index u_to_x = (cq_index)(k + 1), x_to_w = (cq_index)(k + 2), after = m->twin[d->gate];
    m->twin[u_to_x] = border == CQ_NONE ? x_to_w : m->twin[border];
    m->twin[d->before] = u_to_x;
    if (border != CQ_NONE) m->twin[border] = x_to_w;
    m->twin[x_to_w] = after;
    cqi_pair(m, d->gate, k);
}

/* The first open halfedge from *scan on becomes the gate's second predecessor. Halfedges never open again, so all scans
 * together take linear time. */
static int cqi_scan_gate(cq_decoder *d, cq_index *scan, cq_index end)
{
    const cq_mesh *m = &d->draft;
    while (*scan < end && !cqi_is_open(m, *scan)) ++*scan;
    if (*scan == end) return 0;
    d->before2 = *scan;
    d->before = m->twin[d->before2];
    d->gate = m->twin[d->before];
    return 1;
}

/* Another gate for a loop that is used up. 0 if there is none: the component is complete. */
static int cqi_find_gate(cq_decoder *d)
{
    cq_index virtual_end = (cq_index)(3 * (d->draft.first_virtual_face + d->draft.num_virtual_faces));
    return cqi_scan_gate(d, &d->scan, (cq_index)(3 * d->draft.num_faces)) ||
           cqi_scan_gate(d, &d->virtual_scan, virtual_end);
}

/* One face behind the gate, then the next gate: at u again, or past w once u is closed. */
static cq_result cqi_grow_base(cq_decoder *d)
{
    cq_mesh *m = &d->draft;
    cq_index u = m->origin[d->gate], w = cq_target(m, d->gate), x, border = CQ_NONE, behind = 0, apex = 0, f, k;
    int kind = CQI_GROW;
    if (CQI_ENCODING(d)) {
        behind = d->plan->mesh.twin[cqi_plan_to_input(d->plan, d->gate)];
        kind = cqi_plan_gate(d, behind, &apex, &border);
    }
    kind = cqi_code_gate(d, kind, &border);
    if (kind == CQI_TURN) border = d->before2;
    if (kind == CQI_CLOSE) border = m->twin[d->gate];
    if (kind == CQI_GROW) {
        border = CQ_NONE;
        x = cqi_code_new_vertex(d, !cq_is_virtual(m, u) && !cq_is_virtual(m, w), apex);
    } else {
        x = cqi_is_open(m, border) ? cq_target(m, border) : u;
    }
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (x == CQ_NONE || x == u || x == w) return CQ_ERROR_CORRUPT;
    f = cqi_add_face(d, w, u, x, behind);
    if (f == CQ_NONE) return CQ_ERROR_CORRUPT;
    k = (cq_index)(3 * f);
    cqi_link_face(d, k, border);
    if (kind == CQI_TURN) {
        d->before2 = border;
        d->before = (cq_index)(k + 2);
        d->gate = m->twin[d->before];
    } else {
        d->gate = (cq_index)(k + 1);
    }
    return CQ_OK;
}

/* The base is complete: it must be a mesh with the header's boundary loops and Euler characteristic. */
static cq_result cqi_finish_base(cq_decoder *d)
{
    const cq_mesh *m = &d->draft;
    const cq_shape *s = &d->shape;
    int64_t euler = 2 * (int64_t)m->num_vertices - m->num_faces - (int64_t)m->num_virtual_faces;
    int64_t full = 2 * (int64_t)s->num_vertices - s->num_faces - (int64_t)s->num_boundary_edges;
    if (m->num_virtual != m->max_virtual || euler != full) return CQ_ERROR_CORRUPT;
    return cq_mesh_check(m, NULL) == CQ_OK ? CQ_OK : CQ_ERROR_CORRUPT;
}

/* -- Values ----------------------------------------------------------------------------------------------------------
 *
 * A collapse merges values a, b to floor((a + b) / 2), or keeps a, and leaves delta = b - a, from which the split gets
 * both back. */

#define CQI_WILD 0x4000000 /* beyond any difference of values: stands for residuals that no encoder writes */

static int32_t cqi_floor_half(int32_t x) { return (x - (x & 1)) / 2; }

/* What a collapse adds to the value of A. */
static int32_t cqi_moved(const cq_channel *c, int32_t delta) { return c->merge == CQ_KEEP ? 0 : cqi_floor_half(delta); }

/* Exact values: a number that grows with the float, which has the sign and the magnitude of its bits; and back. In
 * predictions the upper 24 bits take part. */
static int cqi_is_exact(const cq_channel *c) { return CQ_MAX_BITS >= 24 && c->bits == CQ_EXACT_BITS; }
static int32_t cqi_number(const cq_channel *c, int32_t x) { return cqi_is_exact(c) && x < 0 ? x ^ 0x7fffffff : x; }

static int32_t cqi_rough(const cq_channel *c, int32_t x)
{
    return cqi_is_exact(c) ? cqi_floor_shift(cqi_number(c, x), 8) : x;
}

static int32_t cqi_unrough(const cq_channel *c, int32_t x)
{
    return cqi_is_exact(c) ? (int32_t)((uint32_t)x << 8) : x;
}

/* A number, 0 .. 38: up to seven times whether it is more, each time by a model of its own, then raw. */
static int cqi_code_count(cq_decoder *d, int index, int count)
{
    int k = 0;
    while (k < 7 && cqi_code_bit(d, index + k, count > k)) k++;
    return k < 7 ? k : 7 + (int)cqi_code_raw(d, (uint32_t)(count - 7), 5);
}

/* Bits of a magnitude, by their difference from the number that is expected. */
static int cqi_code_bits(cq_decoder *d, int index, int expected, int bits)
{
    int less;
    if (!expected || cqi_code_bit(d, index, bits >= expected))
        return expected + cqi_code_count(d, index + 1, bits - expected);
    less = 1 + cqi_code_count(d, index + 8, expected - 1 - bits);
    return less < expected ? expected - less : 0;
}

/* Bits that a residual of the channel may have; and no more than 26 have a model for the second highest one. */
static int cqi_most_bits(const cq_channel *c) { return cqi_is_exact(c) ? 32 : 26; }

/* The bits of a magnitude below the highest one, by the models of a kind for the second highest bit and the sign. */
static int32_t cqi_code_low_bits(cq_decoder *d, int kind, int bits, uint32_t magnitude, int negative)
{
    uint32_t x = 1;
    if (bits > 1) {
        const int top = kind + CQI_TOP + cqi_at_most(bits, 26);
        x = 2 | (uint32_t)cqi_code_bit(d, top, (int)(magnitude >> (bits - 2) & 1));
        x = x << (bits - 2) | cqi_code_raw(d, magnitude & (((uint32_t)1 << (bits - 2)) - 1), bits - 2);
    }
    return (int32_t)(cqi_code_bit(d, kind + CQI_SIGN, negative) ? (uint32_t)0 - x : x);
}

/* Number of bits, magnitude and sign, by the models of a kind; `row` of those of the number. */
static int32_t cqi_code_residual(cq_decoder *d, int kind, int row, int expected, int most, int32_t residual)
{
    const uint32_t magnitude = cqi_abs(residual);
    const int bits = cqi_code_bits(d, kind + CQI_BITS + 16 * row, expected, cqi_bit_length(magnitude));
    if (bits == 0) return 0;
    if (bits > most) return CQI_WILD;
    return cqi_code_low_bits(d, kind, bits, magnitude, residual < 0);
}

/* The residual of a split, of which half_bits / 2 bits are expected. */
static int32_t cqi_code_expected(cq_decoder *d, int kind, int half_bits, int most, int32_t residual)
{
    const int limit = CQI_EXPECTED - 2, row = half_bits < limit ? half_bits : limit + half_bits % 2;
    return cqi_code_residual(d, kind, row, half_bits / 2, most, residual);
}

/* Bits to expect of a number of this size, in half bits: its logarithm, in halves. */
static int cqi_half_bits(uint32_t x) { return x < 0x8000 ? cqi_bit_length(x * x) : 2 * cqi_bit_length(x); }

static int cqi_value_fits(const cq_channel *c, int32_t value)
{
    return cqi_is_exact(c) || (value >= 0 && value >> c->bits == 0);
}

/* Base values are predicted by the mean of the neighbours that are known, those with lower numbers. */
static int32_t cqi_predict_base(const cq_decoder *d, const cq_channel *channel, const cq_value *values, cq_index v)
{
    const cq_mesh *m = &d->draft;
    const uint32_t stride = channel->components;
    cq_index h = m->out[v];
    int32_t sum = 0, n = 0;
    do {
        cq_index w = cq_target(m, h);
        if (w < v && n < 64) {
            sum += cqi_rough(channel, values[(size_t)w * stride]);
            n++;
        }
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    if (n) return cqi_unrough(channel, sum / n);
    if (v) return cqi_number(channel, values[(size_t)(v - 1) * stride]);
    return cqi_is_exact(channel) ? 0 : (int32_t)1 << (channel->bits - 1);
}

/* Component c of channel k, of base vertex v. `size`: that of the residuals before. */
static int cqi_code_base_value(cq_decoder *d, uint32_t k, uint32_t c, cq_index v, int32_t *size)
{
    const cq_channel *channel = &d->shape.channel[k];
    const uint32_t stride = channel->components;
    cq_value *values = d->channel[k] + c;
    int32_t p = cqi_predict_base(d, channel, values, v), x = 0;
    if (CQI_ENCODING(d))
        x = cqi_difference(cqi_number(channel, d->plan->value[k][(size_t)d->plan->to_input[v] * stride + c]), p);
    x = cqi_code_residual(d, CQI_OF_BASE, 0, cqi_bit_length((uint32_t)*size), cqi_most_bits(channel), x);
    *size = (3 * *size + (int32_t)(cqi_abs(x) >> 28 ? (uint32_t)1 << 28 : cqi_abs(x))) / 4;
    x = cqi_number(channel, cqi_sum(p, x));
    values[(size_t)v * stride] = (cq_value)x;
    return cqi_value_fits(channel, x);
}

/* -- Values of faces: mostly that of a face nearby -- */

/* The value of a face of channel k, given those of faces near it. */
static int32_t cqi_code_face(cq_decoder *d, uint32_t k, const int32_t *beside, int n, int32_t value)
{
    int i, j, refused = 0;
    for (i = 0; i < n; i++) {
        int asked = 0, same = 0;
        for (j = 0; j < n; j++) {
            same += beside[j] == beside[i];
            asked += j < i && beside[j] == beside[i];
        }
        if (asked) continue;
        if (cqi_code_bit(d, CQI_FACE + 4 * refused + same, value == beside[i])) return beside[i];
        refused++;
    }
    return (int32_t)cqi_code_raw(d, (uint32_t)value, d->shape.channel[k].bits);
}

/* Channel k of base face f, given the value of the face before it. */
static void cqi_code_base_face(cq_decoder *d, uint32_t k, cq_index f)
{
    cq_value *values = d->channel[k];
    int32_t before = f ? values[f - 1] : 0, x = 0;
    if (CQI_ENCODING(d)) x = d->plan->input[k][d->plan->face_input[f] / 3];
    values[f] = (cq_value)cqi_code_face(d, k, &before, 1, x);
}

/* All channels of vertices or of faces, of the next base vertex or face. */
static cq_result cqi_code_base_values(cq_decoder *d)
{
    const int of_face = d->value >= d->draft.num_vertices;
    const cq_index v = (cq_index)(of_face ? d->value - d->draft.num_vertices : d->value);
    int32_t *size = d->delta;
    uint32_t k, c;
    d->value++;
    for (k = 0; k < d->shape.num_channels; k++) {
        if ((d->shape.channel[k].merge == CQ_PER_FACE) != of_face) continue;
        if (of_face) cqi_code_base_face(d, k, v);
        for (c = 0; c < d->shape.channel[k].components && !of_face; c++)
            if (!cqi_code_base_value(d, k, c, v, size++)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
        cqi_charge_channel(d, k);
    }
    return cqi_starved(d) ? CQ_TRUNCATED : CQ_OK;
}

/* Values of the faces of channel k that a split at p, q is going to make, the one at p first, given those of the faces
 * that they will share an edge with. Virtual ones have none. */
static void cqi_code_new_faces(cq_decoder *d, uint32_t k, int p, int q)
{
    const cq_mesh *m = &d->mesh;
    cq_value *values = d->channel[k];
    cq_index f = m->num_faces, input = CQI_ENCODING(d) ? d->plan->mesh.free_face : 0; /* see cqi_plan_new_faces */
    int32_t x = 0, beside[3];
    int end, side, n;
    for (end = 0; end < 2; end++) {
        cq_index spoke = d->ring.spoke[end ? q : p];
        if (cq_is_virtual(m, cq_target(m, spoke))) continue;
        beside[0] = x;
        n = f > m->num_faces;
        for (side = 0; side < 2; side++, spoke = m->twin[spoke])
            if (spoke / 3 < m->num_faces) beside[n++] = values[spoke / 3];
        if (CQI_ENCODING(d)) {
            x = d->plan->input[k][input];
            input = d->plan->mesh.origin[3 * input + 1];
        }
        x = cqi_code_face(d, k, beside, n, x);
        if (f < m->first_virtual_face) values[f] = (cq_value)x; /* else the split will fail */
        f++;
    }
}

/* The values that a split's fans predict those of A and B from, relative to that of the centre. */
typedef struct cqi_fans {
    int32_t sum_a, sum_b;            /* over the neighbours of A and of B but for each other */
    int32_t n_a, n_b;                /* their number, and 1 */
} cqi_fans;

static void cqi_count_fans(const cqi_ring *r, int p, int q, cqi_fans *fans)
{
    int32_t all = r->real[r->size], between = r->real[q] - r->real[p + 1];
    fans->n_b = r->real[q + 1] - r->real[p] + 1;
    fans->n_a = all - between + 1;
}

/* What the values of channel k on the ring are relative to the centre, and sums of that. */
static void cqi_read_offsets(cq_decoder *d, uint32_t k)
{
    cqi_ring *r = &d->ring;
    const cq_channel *channel = &d->shape.channel[k];
    const size_t stride = cqi_components(channel);
    const int size = r->size;
    size_t c;
    r->offset_channel = k;
    for (c = 0; c < stride; c++) {
        const cq_value *const values = d->channel[k] + c;
        const int32_t centre = cqi_rough(channel, values[d->mesh.origin[r->spoke[0]] * stride]);
        int32_t *before = r->before + c, sum = 0;
        uint32_t spread = 0;
        int n;
        for (n = 0; n < size; n++, before += stride) {
            const int32_t x = cqi_rough(channel, values[r->seen[n] * stride]) - centre;
            *before = sum;
            sum += x;
            spread += cqi_abs(x);
        }
        *before = sum;
        r->spread[c] = spread;
    }
}

/* Sums of component c of the offsets in the ring, of so many components. */
static void cqi_sum_fans(const cqi_ring *r, uint32_t c, uint32_t components, int p, int q, cqi_fans *fans)
{
    const int32_t *before = r->before + c, *at_p = before + components * (uint32_t)p;
    const int32_t *at_q = before + components * (uint32_t)q;
    fans->sum_b = at_q[components] - at_p[0];
    fans->sum_a = before[components * (uint32_t)r->size] - (at_q[0] - at_p[components]);
}

/* B - A if both were the mean of their neighbours and the centre their midpoint; if the centre is A, no difference, or
 * that of exact values if B is the mean of its neighbours. With 18-bit values no product exceeds
 * 2 * 24 * 24 * 2^18 < 2^29; wider ones are shifted down to that first, which costs precision, not correctness. */
static int32_t cqi_predict_delta(const cqi_fans *f, const cq_channel *channel)
{
    int shift = channel->bits > 18 ? channel->bits - 18 : 0;
    int32_t b, a;
    if (channel->merge == CQ_KEEP) return cqi_is_exact(channel) ? cqi_unrough(channel, f->sum_b / f->n_b) : 0;
    b = cqi_floor_shift(f->sum_b, shift);
    a = cqi_floor_shift(f->sum_a, shift);
    return 2 * (f->n_a * b - f->n_b * a) / (2 * f->n_a * f->n_b + f->n_a + f->n_b) * ((int32_t)1 << shift);
}

static int32_t cqi_plan_delta(const cq_decoder *d, cq_index v, uint32_t k, uint32_t component)
{
    const cq_channel *channel = &d->shape.channel[k];
    const cq_index b = d->plan->collapse[d->plan->next_collapse].removed;
    const int32_t x = d->plan->value[k][(size_t)b * channel->components + component];
    if (channel->merge == CQ_MIDPOINT) return x;
    return cqi_difference(cqi_number(channel, x),
                          cqi_number(channel, d->channel[k][(size_t)v * channel->components + component]));
}

/* -- Vectors of up to 26 bits -- */

static inline cqi_vector cqi_at(const int32_t *components, int k)
{
    cqi_vector a;
    a.x = components[3 * k];
    a.y = components[3 * k + 1];
    a.z = components[3 * k + 2];
    return a;
}

static cqi_vector cqi_scale(cqi_vector a, int32_t factor)
{
    a.x *= factor;
    a.y *= factor;
    a.z *= factor;
    return a;
}

static inline cqi_vector cqi_shift(cqi_vector a, int bits)
{
    a.x = cqi_floor_shift(a.x, bits);
    a.y = cqi_floor_shift(a.y, bits);
    a.z = cqi_floor_shift(a.z, bits);
    return a;
}

static cqi_vector cqi_cross(cqi_vector a, cqi_vector b)
{
    cqi_vector n;
    n.x = a.y * b.z - a.z * b.y;
    n.y = a.z * b.x - a.x * b.z;
    n.z = a.x * b.y - a.y * b.x;
    return n;
}

/* Scaled by the power of two that gives the largest component so many bits. */
static cqi_vector cqi_fit(cqi_vector a, int bits)
{
    int shift = bits - cqi_bit_length(cqi_abs(a.x) | cqi_abs(a.y) | cqi_abs(a.z));
    return shift < 0 ? cqi_shift(a, -shift) : cqi_scale(a, (int32_t)1 << shift);
}

/* Length within 10 %, of tiny vectors less: no square root, and no overflow below 2^26. */
static inline int32_t cqi_norm(cqi_vector a)
{
    int32_t x = (int32_t)cqi_abs(a.x), y = (int32_t)cqi_abs(a.y), z = (int32_t)cqi_abs(a.z);
    int32_t largest = x > y ? x : y;
    largest = largest > z ? largest : z;
    return (int32_t)((uint32_t)(11 * largest + 5 * (x + y + z)) >> 4);
}

/* -- Axes: residuals of positions, turned so that the normal of the patch and the predicted displacement are axes --
 *
 * A turn in a plane is three shears, each rounded, so it can be taken back exactly, whatever the factors are. */

enum { CQI_TURNED_BITS = 18, CQI_TURN_BITS = 9 };

/* The length of (x, y) within 0.2 %: an estimate and one step of Newton's method. 0 <= x, y < 2^15. */
static int32_t cqi_hypotenuse(int32_t x, int32_t y)
{
    int32_t estimate = x > y ? x + 3 * y / 8 : y + 3 * x / 8;
    return estimate ? (int32_t)((x * x + y * y) / estimate + estimate) / 2 : 0;
}

/* The turn that takes (x, y) to (its length or minus that, 0), and *x there. */
static cqi_turn cqi_find_turn(int32_t *x, int32_t y)
{
    cqi_turn t;
    int32_t side = (int32_t)cqi_abs(*x), length = cqi_hypotenuse(side, (int32_t)cqi_abs(y));
    t.tangent = t.sine = 0;
    if (length) {
        t.sine = -y * ((int32_t)1 << CQI_TURN_BITS) / length;
        t.tangent = -y * ((int32_t)1 << CQI_TURN_BITS) / (length + side);
    }
    if (*x < 0) {
        t.sine = -t.sine;
        t.tangent = -t.tangent;
        length = -length;
    }
    *x = length;
    return t;
}

static int32_t cqi_shear(int32_t by, int32_t factor) { return cqi_floor_shift(by * factor, CQI_TURN_BITS); }

static void cqi_turn_forth(const cqi_turn *t, int32_t *x, int32_t *y)
{
    *x -= cqi_shear(*y, t->tangent);
    *y += cqi_shear(*x, t->sine);
    *x -= cqi_shear(*y, t->tangent);
}

static void cqi_turn_back(const cqi_turn *t, int32_t *x, int32_t *y)
{
    *x += cqi_shear(*y, t->tangent);
    *y -= cqi_shear(*x, t->sine);
    *x += cqi_shear(*y, t->tangent);
}

/* The turn that makes the predicted displacement, as seen along the normal of the patch, the x axis. And what to expect
 * of a residual along the surface and along the normal, in half bits. */
typedef struct cqi_axes {
    cqi_turn turn;
    int along, normal;
} cqi_axes;

/* Bits to expect of a length that is an eighth of `x` in the scale of the ring, in half bits. */
static int cqi_expect(const cqi_ring *r, int32_t x)
{
    int half_bits = cqi_half_bits((uint32_t)x) - 2 * (3 + r->shift);
    return half_bits < 0 ? 0 : half_bits;
}

static void cqi_find_axes(const cqi_ring *r, const int32_t *predicted, cqi_axes *axes)
{
    cqi_vector along = cqi_at(predicted, 0);
    cqi_turn_forth(&r->turn[0], &along.x, &along.y);
    cqi_turn_forth(&r->turn[1], &along.z, &along.x);
    along.z = 0;
    along = cqi_fit(along, 14);
    axes->turn = cqi_find_turn(&along.x, along.y);
    axes->along = cqi_expect(r, 3 * r->mean_length);
    axes->normal = cqi_expect(r, 8 * r->height / r->size);
}

/* Codes the residual of a position along the axes of the patch. False if it is beyond any difference of values. */
static int cqi_code_turned(cq_decoder *d, const int32_t *predicted, int32_t *residual)
{
    const int32_t limit = (int32_t)1 << (CQI_TURNED_BITS + 2);
    int32_t x = residual[0], y = residual[1], z = residual[2];
    const cqi_turn *const turn = d->ring.turn;
    cqi_axes axes;
    cqi_find_axes(&d->ring, predicted, &axes);
    cqi_turn_forth(&turn[0], &x, &y);
    cqi_turn_forth(&turn[1], &z, &x);
    cqi_turn_forth(&axes.turn, &x, &y);
    x = cqi_code_expected(d, CQI_ALONG, axes.along, 26, x);
    y = cqi_code_expected(d, CQI_ACROSS, (3 * axes.along + cqi_half_bits(cqi_abs(x))) / 4, 26, y);
    z = cqi_code_expected(d, CQI_NORMAL, (3 * axes.normal + cqi_half_bits(cqi_abs(x) + cqi_abs(y))) / 4, 26, z);
    if (x > limit || x < -limit || y > limit || y < -limit || z > limit || z < -limit) return 0;
    cqi_turn_back(&axes.turn, &x, &y);
    cqi_turn_back(&turn[1], &z, &x);
    cqi_turn_back(&turn[0], &x, &y);
    residual[0] = x;
    residual[1] = y;
    residual[2] = z;
    return 1;
}

/* A residual of a fast stream, with its sign as the lowest bit. Its lower bits are coded without models: one more than
 * residuals had in the mean where as many half bits were expected. */
static int32_t cqi_code_fast(cq_decoder *d, int half_bits, int32_t residual)
{
    uint16_t *mean = &d->model.mean_bits[half_bits];
    uint32_t x = ((uint32_t)residual << 1) ^ ((uint32_t)0 - (residual < 0)), high;
    const int low = cqi_at_most(*mean / 256 + 1, 32), bits = cqi_bit_length(x);
    const int more = cqi_code_count(d, CQI_FAST + 8 * (*mean / 64 % 4), bits > low ? bits - low : 0);
    if (low + more > 32) return CQI_WILD;
    high = more ? (uint32_t)1 << (low + more - 1) : 0;
    x = high | cqi_code_raw(d, x - high, low + more - (more > 0));
    *mean = (uint16_t)(*mean - *mean / 64 + 4 * cqi_bit_length(x));
    return (int32_t)((x >> 1) ^ ((uint32_t)0 - (x & 1)));
}

/* The residual of one component alone: the wider its values are spread, the larger. */
static int32_t cqi_code_plain(cq_decoder *d, const cq_channel *channel, uint32_t spread, int32_t residual)
{
    const int exact = cqi_is_exact(channel) ? 2 * 8 : 0;
    const int half_bits = cqi_half_bits(d->shape.fast ? spread / 16 : spread / (uint32_t)d->ring.size) + exact;
    if (d->shape.fast) return cqi_code_fast(d, half_bits, residual);
    return cqi_code_expected(d, CQI_PLAIN, half_bits, cqi_most_bits(channel), residual);
}

/* delta[] of channel k for a split of v at ring positions p, q. */
static int cqi_code_channel(cq_decoder *d, uint32_t k, cq_index v, int p, int q, cqi_fans *fans, int32_t *delta)
{
    const cq_channel *channel = &d->shape.channel[k];
    const uint32_t stride = cqi_components(channel);
    const cq_value *values = d->channel[k] + (size_t)v * stride;
    const int turned = (int)k == cqi_context_channel(&d->shape) && channel->bits <= CQI_TURNED_BITS;
    int32_t residual[CQ_MAX_COMPONENTS], predicted[CQ_MAX_COMPONENTS];
    uint32_t c;
    if (d->ring.offset_channel != k) cqi_read_offsets(d, k);
    for (c = 0; c < stride; c++) {
        cqi_sum_fans(&d->ring, c, stride, p, q, fans);
        predicted[c] = cqi_predict_delta(fans, channel);
        residual[c] = CQI_ENCODING(d) ? cqi_difference(cqi_plan_delta(d, v, k, c), predicted[c]) : 0;
        if (!turned) residual[c] = cqi_code_plain(d, channel, d->ring.spread[c], residual[c]);
    }
    if (turned && !cqi_code_turned(d, predicted, residual)) return 0;
    for (c = 0; c < stride; c++) {
        int32_t low;
        delta[c] = cqi_sum(predicted[c], residual[c]);
        low = cqi_difference(values[c], cqi_moved(channel, delta[c]));
        if (!cqi_value_fits(channel, low) || !cqi_value_fits(channel, cqi_sum(low, delta[c]))) return 0;
    }
    return 1;
}

/* d->delta, and the values of the new faces. */
static int cqi_code_deltas(cq_decoder *d, cq_index v, int p, int q)
{
    int32_t *delta = d->delta;
    uint32_t k;
    cqi_fans fans;
    cqi_count_fans(&d->ring, p, q, &fans);
    for (k = 0; k < d->shape.num_channels; k++) {
        if (d->shape.channel[k].merge == CQ_PER_FACE) cqi_code_new_faces(d, k, p, q);
        else if (!cqi_code_channel(d, k, v, p, q, &fans, delta)) return 0;
        delta += d->shape.channel[k].components;
        cqi_charge_channel(d, k);
    }
    return 1;
}

static void cqi_apply_deltas(cq_decoder *d, cq_index a, cq_index b)
{
    const int32_t *delta = d->delta;
    uint32_t k, c;
    for (k = 0; k < d->shape.num_channels; delta += d->shape.channel[k++].components) {
        const cq_channel *channel = &d->shape.channel[k];
        if (channel->merge == CQ_PER_FACE) continue;
        for (c = 0; c < channel->components; c++) {
            cq_value *at = d->channel[k] + (size_t)a * channel->components + c;
            *at = (cq_value)(*at - cqi_moved(channel, delta[c]));
            d->channel[k][(size_t)b * channel->components + c] =
                (cq_value)cqi_number(channel, cqi_sum(cqi_number(channel, *at), delta[c]));
        }
    }
}

/* -- Conquest (sections 2.2 to 2.4 of the paper) ---------------------------------------------------------------------
 *
 * mark[v] during a level: how many patches hold v on their ring, exact below CQI_MANY, and flags. In the second
 * phase of a level, when patches are left in reverse order, the number counts the patches that are still waiting. */
enum {
    CQI_MANY = 15,        /* this number of patches or more; never counted down again */
    CQI_LEFT = 0x10,      /* a patch that holds v has been left */
    CQI_CENTRE = 0x20     /* v is the centre of a patch; its number says instead whether it is split */
    /* CQI_SEED = 0x40, CQI_SCRATCH = 0x80 */
};

static int cqi_is_conquered(const cq_mesh *m, cq_index v) { return (m->mark[v] & (CQI_MANY | CQI_CENTRE)) != 0; }

#define CQI_CLEAR_AT_ONCE 1024 /* vertices: what bounds the time of a step */

static void cqi_walk_begin(cqi_walk *w)
{
    w->seed = w->head = w->tail = 0;
    w->spoke = CQ_NONE;
}

/* Virtual vertices are conquered from the start: they are never the centre of a patch. */
static void cqi_conquer_virtual(cq_mesh *m) { memset(m->mark + m->first_virtual, CQI_MANY, m->num_virtual); }

/* Takes the marks of the level before from the next vertices; 0 when that was done for all. */
static int cqi_walk_clear(cq_mesh *m, cqi_walk *w)
{
    cq_index k;
    for (k = 0; k < CQI_CLEAR_AT_ONCE && w->seed < m->num_vertices; k++) m->mark[w->seed++] &= CQI_SEED;
    if (w->seed < m->num_vertices) return 1;
    cqi_conquer_virtual(m);
    w->seed = 0;
    return 0;
}

/* Takes a vertex of a ring; returns whether it was available. */
static inline int cqi_conquer_vertex(uint8_t *mark)
{
    const int available = (*mark & (CQI_MANY | CQI_CENTRE)) == 0;
    *mark = (uint8_t)(*mark + ((*mark & CQI_MANY) < CQI_MANY));
    return available;
}

/* Takes the ring of the spoke's origin; returns how many of its vertices were available. From both sides at once: in a
 * large mesh each spoke has to wait for the one before. */
static int cqi_conquer_ring(cq_mesh *m, cq_index spoke)
{
    const cq_index *const origin = m->origin, *const twin = m->twin;
    uint8_t *const marks = m->mark;
    cq_index h = spoke, g = spoke;
    int available = 0;
    do {
        const cq_index in = twin[h], before = cq_prev(g);
        CQI_FETCH_HALFEDGE(m, cqi_before(in));
        CQI_FETCH_HALFEDGE(m, cqi_before(before));
        available += cqi_conquer_vertex(&marks[origin[in]]);
        h = cq_next(in);
        if (h == g) break;
        available += cqi_conquer_vertex(&marks[origin[before]]);
        g = twin[before];
    } while (h != g);
    return available;
}

/* Takes the patch of the spoke's origin. */
static void cqi_conquer(cq_mesh *m, cqi_walk *w, cq_index *patch, cq_index spoke, int split)
{
    cq_index centre = m->origin[spoke];
    m->mark[centre] = (uint8_t)(m->mark[centre] | CQI_CENTRE | split);
    patch[w->tail++] = spoke;
}

/* The next gate of the patches found so far whose front vertex is available, as the spoke front -> L; or CQ_NONE.
 *
 * Ring edges of a patch are tried counter-clockwise from its entry spoke, the entry edge itself first, then on from R
 * to L: that costs fewer bits than from L to R (tests/train). */
static cq_index cqi_next_gate(const cq_mesh *m, cqi_walk *w, const cq_index *patch)
{
    for (; w->head < w->tail; w->head++, w->spoke = CQ_NONE) {
        if (w->spoke == CQ_NONE) w->spoke = patch[w->head];
        do {
            cq_index gate = m->twin[cq_next(w->spoke)];
            if (!cqi_is_conquered(m, m->origin[cq_prev(gate)])) return cq_prev(gate);
            w->spoke = cq_counterclockwise(m, w->spoke);
        } while (w->spoke != patch[w->head]);
    }
    return CQ_NONE;
}

/* The first gate of a component (section 2.4), given its halfedge L -> R: the side whose front vertex is real. */
static cq_index cqi_first_gate(const cq_mesh *m, cq_index h)
{
    return cq_is_virtual(m, m->origin[cq_prev(h)]) ? m->twin[h] : h;
}

/* Entry spoke of the first patch of a component. Case 0: the front vertex is the centre. 1: the front vertex was
 * collapsed into L, the centre is L, its ring ends at R. 2: into R, the centre is R, its ring begins at L. */
static cq_index cqi_first_spoke(const cq_mesh *m, cq_index gate, int side)
{
    if (side == 1) return cq_clockwise(m, gate);
    return side == 2 ? m->twin[gate] : cq_prev(gate);
}

/* A component of two triangles is passed over: nothing collapses to it, so it has no patch. All other patches have
 * three triangles or more of their own, which is why a list of faces / 3 patches is long enough. */
static int cqi_is_pillow(const cq_mesh *m, cq_index v) { return m->valence[v] == 2; }

static cq_index cqi_next_seed(const cq_mesh *m, cqi_walk *w, cq_index end)
{
    while (w->seed < end && (!(m->mark[w->seed] & CQI_SEED) || cqi_is_pillow(m, w->seed))) w->seed++;
    return w->seed < end ? w->seed++ : CQ_NONE;
}

/* Is the patch split? Tells mostly by whether the encoder had an available neighbour to collapse with. */
static int cqi_code_flag(cq_decoder *d, cq_index spoke, int available, int split)
{
    int valence = (int)d->mesh.valence[d->mesh.origin[spoke]];
    if (valence > CQ_MAX_VALENCE) return 0;
    return cqi_code_bit(d, CQI_FLAG + 12 * cqi_at_most(available, 3) + cqi_at_most(valence, 11), split);
}

/* Which of the three cases of a first gate; only asked where one of L, R, front is split. */
static int cqi_plan_side(const cq_decoder *d)
{
    const cqi_collapse *c = cqi_plan_patch(d->plan, d->walk.tail);
    return c ? c->side : 0;
}

static cq_index cqi_code_first_patch(cq_decoder *d, cq_index seed)
{
    cq_index gate = cqi_first_gate(&d->mesh, cqi_find_spoke(&d->mesh, seed, (cq_index)(seed + 1)));
    int side = CQI_ENCODING(d) ? cqi_plan_side(d) : 0;
    if (cqi_code_bit(d, CQI_SIDE, side != 0)) side = 1 + cqi_code_bit(d, CQI_SIDE + 1, side == 2);
    else side = 0;
    return cqi_first_spoke(&d->mesh, gate, side);
}

/* Conquers one patch. CQ_DONE when the conquest is complete. */
static cq_result cqi_code_patch(cq_decoder *d)
{
    cq_index spoke = cqi_next_gate(&d->mesh, &d->walk, d->patch);
    int split;
    if (spoke == CQ_NONE) {
        cq_index seed = cqi_next_seed(&d->mesh, &d->walk, d->base_vertices);
        if (seed == CQ_NONE) return CQ_DONE;
        spoke = cqi_code_first_patch(d, seed);
    }
    split = CQI_ENCODING(d) && cqi_plan_patch(d->plan, d->walk.tail);
    split = cqi_code_flag(d, spoke, cqi_conquer_ring(&d->mesh, spoke), split);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    cqi_conquer(&d->mesh, &d->walk, d->patch, spoke, split);
    d->splits = (cq_index)(d->splits + (cq_index)split);
    if (CQI_ENCODING(d)) d->plan->next_collapse = (cq_index)(d->plan->next_collapse + (cq_index)split);
    return CQ_OK;
}

/* -- Splits: which candidate -----------------------------------------------------------------------------------------
 *
 * One symbol says which pair of ring vertices p < q the split's common neighbours are: D (D - 1) / 2 candidates for
 * a centre of valence D. The paper's indices are i = p and j = D - 1 - q. The probabilities are those of a
 * log-linear model (multinomial logit): a candidate's score is the sum of one weight for each of its features, its
 * share of the range is 2^score, and after each split every weight moves along the gradient of the log-likelihood,
 * by CQI_STEP times (1 if the split had the feature, minus the probability that the model had given to that). All in
 * integers, so all alike. Fast streams have two such symbols, and learn from one of CQI_LEARN_EVERY splits. */

enum {
    CQI_HEAVIEST = 13,    /* share 2^13 for the best candidate, at least 1 for all others: in all less than 2^22 */
    CQI_SHARES = 16 * (CQI_HEAVIEST + 1)
};

enum { CQI_LARGE_VALENCE = 31 }; /* and more, of a vertex beside the centre */

/* 1 + 2^(-(k + 1/2) / 16) * 2^CQI_HEAVIEST */
static const uint16_t cqi_shares[CQI_SHARES] = {
    8017, 7677, 7352, 7040, 6742, 6456, 6182, 5920, 5669, 5429, 5199, 4978, 4767, 4565, 4372, 4186, 4009, 3839, 3676,
    3520, 3371, 3228, 3091, 2960, 2835, 2715, 2600, 2489, 2384, 2283, 2186, 2093, 2005, 1920, 1838, 1760, 1686, 1614,
    1546, 1480, 1418, 1358, 1300, 1245, 1192, 1142, 1093, 1047, 1003, 960, 919, 880, 843, 807, 773, 740, 709, 679,
    650, 623, 596, 571, 547, 524, 502, 480, 460, 440, 422, 404, 387, 370, 355, 340, 325, 312, 298, 286, 274, 262, 251,
    240, 230, 220, 211, 202, 194, 185, 178, 170, 163, 156, 149, 143, 137, 131, 126, 120, 115, 110, 106, 101, 97, 93,
    89, 85, 82, 78, 75, 72, 69, 66, 63, 60, 58, 55, 53, 51, 49, 47, 45, 43, 41, 39, 38, 36, 35, 33, 32, 30, 29, 28,
    27, 26, 25, 24, 23, 22, 21, 20, 19, 18, 18, 17, 16, 15, 15, 14, 14, 13, 13, 12, 12, 11, 11, 10, 10, 9, 9, 9, 8, 8,
    8, 7, 7, 7, 7, 6, 6, 6, 6, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3, 3, 3, 3, 3, 2, 2, 2, 2, 2, 2, 2, 2,
    2, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1
};

/* Share of a candidate whose score is `below` under the best one. */
static inline uint32_t cqi_share(uint32_t below)
{
    const uint32_t k = below >> (CQI_UNIT - 4);
    return cqi_shares[k < CQI_SHARES ? k : CQI_SHARES - 1];
}

static inline void cqi_learn(cqi_model *m, int index, int32_t gradient)
{
#ifdef CQ_TRAINING
    if (CQI_OMITTED(index)) return;
#endif
    m->weight[index] += gradient;
}

static void cqi_limit_weights(cqi_model *m)
{
    int k;
    for (k = 0; k < CQI_WEIGHTS; k++) {
        if (m->weight[k] > CQI_MOST) m->weight[k] = CQI_MOST;
        if (m->weight[k] < -CQI_MOST) m->weight[k] = -CQI_MOST;
    }
}

/* -- The patch -- */

static uint8_t cqi_ring_state(int mark)
{
    const int holders = mark & CQI_MANY, left = (mark & CQI_LEFT) != 0;
    return (uint8_t)(holders > 1 ? CQI_HELD_OFTEN : 2 * holders + left);
}

/* A ring vertex has three neighbours or more: with two, its component were a pillow. */
static int cqi_valence_class(int valence) { return valence < 16 ? valence - 3 : 13; }

/* At a first gate the centre may be L or R; then the other one is a common neighbour. */
static int cqi_side_of_patch(const cq_decoder *d, cq_index centre, cq_index first)
{
    const cq_mesh *m = &d->mesh;
    cq_index other = CQ_NONE;
    if (m->mark[centre] & CQI_SEED) other = (cq_index)(centre + 1);
    else if (centre && centre < d->base_vertices && m->mark[centre - 1] & CQI_SEED) other = (cq_index)(centre - 1);
    if (other == CQ_NONE) return 0;
    return first == other ? 2 : 1;
}

/* The finest level is the input's own and often the most regular; how far is this one from it? */
static int cqi_level_class(const cq_decoder *d)
{
    uint32_t after = d->level_end, all = d->shape.num_vertices;
    return after == all ? 0 : after >= all - all / 5 ? 1 : 2;
}

/* Leaves the patch, in the reverse order of conquest, and keeps what its ring was then. */
static void cqi_leave(cq_decoder *d, cq_index spoke)
{
    cq_mesh *m = &d->mesh;
    cqi_ring *r = &d->ring;
    const cq_index centre = m->origin[spoke];
    const cq_index *const origin = m->origin, *const twin = m->twin;
    cq_index h = spoke;
    int n = 0;
    r->real[0] = 0;
    do {
        cq_index in = twin[h], v = origin[in];
        int mark = m->mark[v];
        mark -= (unsigned)(mark & CQI_MANY) - 1 < CQI_MANY - 1;
        m->mark[v] = (uint8_t)(mark | CQI_LEFT);
        if (n < CQ_MAX_VALENCE) {
            const int is_real = !cq_is_virtual(m, v);
            r->spoke[n] = h;
            r->vertex[n] = v;
            r->seen[n] = is_real ? v : centre;
            r->real[n + 1] = (uint8_t)(r->real[n] + is_real);
            r->valence[n] = (uint8_t)(m->valence[v] < CQI_LARGE_VALENCE ? (int)m->valence[v] : CQI_LARGE_VALENCE);
            r->state[n] = is_real ? cqi_ring_state(mark) : (uint8_t)CQI_NEVER;
            n++;
        }
        h = cq_next(in);
    } while (h != spoke);
    r->size = n;
}

/* What else is to know about the patch that was left. */
static void cqi_read_ring(cq_decoder *d)
{
    cqi_ring *r = &d->ring;
    r->located = cqi_context_channel(&d->shape) >= 0;
    r->offset_channel = CQ_MAX_CHANNELS; /* of none yet */
    r->side = cqi_side_of_patch(d, d->mesh.origin[r->spoke[0]], r->vertex[0]);
    r->level_class = cqi_level_class(d);
}

/* -- Geometry of the patch: what the positions say about where it was split -- */

/* Class of each spoke's length: quarters of the mean of the two shortest. Virtual ones have CQI_WILD. */
static void cqi_classify_edges(cqi_ring *r)
{
    const int size = r->size;
    int32_t shortest = CQI_WILD, second = CQI_WILD, sum, scale;
    int k, shift;
    for (k = 0; k < size; k++) {
        const int32_t x = r->of_p[k], larger = x > shortest ? x : shortest;
        second = larger < second ? larger : second;
        shortest = x < shortest ? x : shortest;
    }
    sum = shortest + second;
    shift = cqi_bit_length((uint32_t)sum >> 14);
    scale = ((int32_t)1 << 26) / (sum >> shift);
    for (k = 0; k < size; k++) {
        const int32_t length = r->of_p[k];
        const int32_t x = length > 2 * sum ? 14 : ((length >> shift) * scale >> 23) - 3;
        r->edge[k] = (uint8_t)(length == CQI_WILD ? 15 : x < 0 ? 0 : x);
    }
}

/* What is the same for all pairs of q - p = b steps. The class of the shorter side: 1 .. 4 through B's neighbours, 5
 * .. 7: 1 .. 3 through A's. And 2^22 over the denominator of cqi_predict_delta times the mean length of the spokes. */
static void cqi_prepare_steps(cqi_ring *r)
{
    int b, a;
    for (b = 1, a = r->size - 1; b <= a; b++, a--) {
        const int n_a = a + 2, n_b = b + 2;
        r->apart[a] = (uint8_t)(8 * (4 + cqi_at_most(b, 3)));
        r->apart[b] = (uint8_t)(8 * (b < a ? cqi_at_most(b, 4) : 4 + cqi_at_most(a, 3)));
        r->displacement[a] = ((int32_t)1 << 22) / ((2 * n_a * n_b + n_a + n_b) * r->mean_length);
        r->displacement[b] = r->displacement[a];
    }
}

/* The offsets of positions, as they are; returns the magnitudes of all, or-ed together. */
static uint32_t cqi_find_offsets(cqi_ring *r)
{
    uint32_t largest = 0;
    int k;
    for (k = 0; k < 3 * r->size; k++) {
        r->now.scaled[k] = r->before[k + 3] - r->before[k];
        largest |= cqi_abs(r->now.scaled[k]);
    }
    return largest;
}

/* In the scale of the ring: times the power of two that gives the largest component 8 bits. */
static void cqi_scale_ring(cqi_ring *r)
{
    int32_t up;
    int k, down;
    r->shift = 8 - cqi_bit_length(cqi_find_offsets(r));
    down = r->shift < 0 ? -r->shift : 0;
    up = (int32_t)1 << (r->shift + down);
    for (k = 0; k < 3 * r->size; k++) r->now.scaled[k] = cqi_floor_shift(r->now.scaled[k] * up, down);
}

/* The normal of the patch, by the areas of its triangles, with 14 bits. */
static cqi_vector cqi_normal(const cqi_ring *r)
{
    cqi_vector n = { 0, 0, 0 }, a = cqi_at(r->now.scaled, r->size - 1);
    int k;
    for (k = 0; k < r->size; k++) {
        const cqi_vector b = cqi_at(r->now.scaled, k), area = cqi_cross(a, b);
        n.x += area.x;
        n.y += area.y;
        n.z += area.z;
        a = b;
    }
    return cqi_fit(n, 14);
}

/* The ring as seen along its normal. */
static void cqi_flatten_ring(cqi_ring *r)
{
    cqi_vector normal = cqi_normal(r);
    const cqi_turn around_z = cqi_find_turn(&normal.x, normal.y), around_y = cqi_find_turn(&normal.z, normal.x);
    cqi_point sum = { 0, 0 };
    int32_t sum_of_lengths = 0, height = 0;
    int k;
    for (k = 0; k < r->size; k++) {
        cqi_vector x = cqi_at(r->now.scaled, k);
        const int32_t norm = cqi_norm(x) + 1, scale = ((int32_t)1 << 16) / norm;
        r->of_p[k] = r->state[k] == CQI_NEVER ? CQI_WILD : norm;
        sum_of_lengths += norm;
        cqi_turn_forth(&around_z, &x.x, &x.y);
        cqi_turn_forth(&around_y, &x.z, &x.x);
        height += (int32_t)cqi_abs(x.z);
        r->sum[k] = sum;
        sum.x += x.x;
        sum.y += x.y;
        r->direction[k + 1].x = cqi_floor_shift(x.x * scale, 10);
        r->direction[k + 1].y = cqi_floor_shift(x.y * scale, 10);
    }
    r->sum[k] = sum;
    r->direction[0] = r->direction[k];
    r->direction[k + 1] = r->direction[1];
    r->turn[0] = around_z;
    r->turn[1] = around_y;
    r->height = height;
    r->mean_length = sum_of_lengths / k + 1;
}

static void cqi_locate_ring(cqi_ring *r)
{
    cqi_scale_ring(r);
    cqi_flatten_ring(r);
    cqi_prepare_steps(r);
}

/* Of fast streams only how long the spokes are. */
static void cqi_measure_ring(cqi_ring *r)
{
    int k;
    cqi_find_offsets(r);
    for (k = 0; k < r->size; k++)
        r->of_p[k] = r->state[k] == CQI_NEVER ? CQI_WILD : cqi_norm(cqi_at(r->now.scaled, k)) + 1;
}

static inline int32_t cqi_dot(cqi_point a, cqi_point b) { return a.x * b.x + a.y * b.y; }

/* Eight classes of numbers from -4 to 3, and beyond. */
static inline int cqi_octant(int32_t x)
{
    x = x < -4 ? -4 : x;
    return 4 + (int)(x > 3 ? 3 : x);
}

/* How far a displacement goes in a direction, in eighths of the mean length of the spokes. */
static inline int cqi_advance(cqi_point u, cqi_point displacement)
{
    return cqi_octant(cqi_floor_shift(cqi_dot(u, displacement), 9));
}

/* Features of a candidate. Half the displacement B - A that its fans predict (cqi_predict_delta), in 1/128 of the mean
 * length of the spokes, is less than 7 of them, since no spoke counts more than max(n_a, n_b) / (2 n_a n_b) <= 1/6. */
static inline void cqi_locate_candidate(const cqi_ring *r, cqi_located *c)
{
    const cqi_point *p = r->sum + c->p, *q = r->sum + c->q, all = r->sum[r->size];
    const cqi_point *u = r->direction + c->p + 1, *v = r->direction + c->q + 1;
    const int steps = c->q - c->p, n_a = r->size - steps + 2, n_b = steps + 2;
    const int32_t scale = r->displacement[steps];
    cqi_point x;
    x.x = cqi_floor_shift((n_a * (q[1].x - p[0].x) - n_b * (all.x - q[0].x + p[1].x)) * scale, 15);
    x.y = cqi_floor_shift((n_a * (q[1].y - p[0].y) - n_b * (all.y - q[0].y + p[1].y)) * scale, 15);
    c->edges = (uint8_t)(r->edge[c->p] / 2 * 8 + r->edge[c->q] / 2);
    c->outer = (uint8_t)(8 * cqi_advance(u[-1], x) + cqi_advance(v[1], x));
    c->between = (uint8_t)(r->apart[steps] + cqi_octant(cqi_floor_shift(cqi_dot(*u, *v), 10)));
}

/* -- The model -- */

/* The valence of vertex k if B could have been that instead, a neighbour of A that no waiting patch holds. */
static int cqi_alternative(const cqi_ring *r, int k)
{
    return r->valence[k] | CQI_LARGE_VALENCE * (r->state[k] > CQI_FREE_LEFT);
}

/* The smallest valence of an alternative from each end of the ring to k. As a common neighbour, k itself has one more
 * neighbour than now. */
static void cqi_find_alternatives(cqi_ring *r)
{
    int smallest = CQI_LARGE_VALENCE, k;
    for (k = 0; k < r->size; k++) {
        const int valence = cqi_alternative(r, k);
        r->best_before[k] = (uint8_t)(cqi_at_most(valence + 1, smallest) + k);
        smallest = cqi_at_most(valence, smallest);
    }
    for (smallest = CQI_LARGE_VALENCE; k--;) {
        const int valence = cqi_alternative(r, k);
        r->best_after[k] = (uint8_t)(cqi_at_most(valence + 1, smallest) + CQ_MAX_VALENCE - k);
        smallest = cqi_at_most(valence, smallest);
    }
}

/* Would the encoder's rule (the smallest valence, then the first) have preferred the best alternative to B? Classes
 * 0 .. 5 of its valence minus that of B, 0 for less than -2, at [valence - steps from p to q + CQ_MAX_VALENCE]. */
static const uint8_t cqi_rule_class[CQ_MAX_VALENCE + CQI_LARGE_VALENCE + 1] = {
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3,
    4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5
};

/* Features of the ring vertices as ends of B's part: entries for p, each with that for q behind it; and their scores.
 * (Without positions all edges are of class 0. What all candidates have in common learns nothing, as what some gain
 * the others lose.) */
static void cqi_score_ends(const cqi_model *m, cqi_ring *r)
{
    const int size = r->size;
    int k;
    for (k = 0; k < size; k++) {
        const int valence = cqi_valence_class(r->valence[k]);
        const int by_state = CQI_END_STATE + 2 * (CQI_STATES * valence + r->state[k]);
        const int by_level = CQI_END_VALENCE + 2 * (14 * r->level_class + valence);
        const int by_edge = CQI_END_EDGE + 2 * r->edge[k];
        r->now.gain[0][k] = r->now.gain[1][k] = r->now.gain[2][k] = 0;
        r->entry[k][0] = (uint16_t)by_state;
        r->entry[k][1] = (uint16_t)by_level;
        r->entry[k][2] = (uint16_t)by_edge;
        r->of_p[k] = m->weight[by_state] + m->weight[by_level] + m->weight[by_edge];
        r->of_q[k] = m->weight[by_state + 1] + m->weight[by_level + 1] + m->weight[by_edge + 1];
    }
}

/* Features of the number of neighbours that go to B, and of those that stay. */
static int cqi_size_b(const cqi_ring *r, int steps)
{
    return CQI_SIZE_B + 16 * r->level_class + cqi_at_most(steps, 15);
}

static int cqi_size_a(const cqi_ring *r, int steps)
{
    return CQI_SIZE_A + 16 * r->level_class + cqi_at_most(r->size - steps, 15);
}

/* Candidates are listed by q, then by p. */
static int cqi_pair_number(int p, int q) { return q * (q - 1) / 2 + p; }

/* Scores of all candidates by valences. Returns the best one. */
static int32_t cqi_score_candidates(cq_decoder *d)
{
    const cqi_ring *r = &d->ring;
    const int32_t *weight = d->model.weight + CQI_RULE;
    int32_t *score = d->score, best = INT32_MIN;
    uint8_t *rule = d->rule;
    int p, q;
    for (q = 1; q < r->size; q++) {
        const uint8_t *before = cqi_rule_class + CQ_MAX_VALENCE - q, *after = cqi_rule_class + r->best_after[q];
        const int32_t *of_steps = r->of_steps + q, of_q = r->of_q[q];
        for (p = 0; p < q; p++) {
            const int x = 6 * before[r->best_before[p]] + after[p];
            const int32_t sum = of_q + r->of_p[p] + of_steps[-p] + weight[x];
            rule[p] = (uint8_t)x;
            score[p] = sum;
            best = sum > best ? sum : best;
        }
        rule += q;
        score += q;
    }
    return best;
}

static int32_t cqi_best(const int32_t *score, int count)
{
    int32_t best = score[0];
    int k;
    for (k = 1; k < count; k++) best = score[k] > best ? score[k] : best;
    return best;
}

/* Lists the candidates that valences have not settled. */
static void cqi_list_located(cq_decoder *d, int32_t enough)
{
    const int32_t *score = d->score;
    cqi_located *c = d->located, *const last = c + CQI_LOCATED;
    int p, q, number = 0;
    for (q = 1; q < d->ring.size; q++) {
        for (p = 0; p < q; p++, number++) {
            c->number = (uint16_t)number;
            c->p = (uint8_t)p;
            c->q = (uint8_t)q;
            c += (score[number] >= enough) & (c < last);
        }
    }
    d->num_located = (int)(c - d->located);
}

/* Adds to the scores what the positions say. */
static void cqi_locate_candidates(cq_decoder *d)
{
    const int32_t *weight = d->model.weight;
    cqi_located *c = d->located, *const end = c + d->num_located;
    for (; c < end; c++) {
        cqi_locate_candidate(&d->ring, c);
        d->score[c->number] +=
            weight[CQI_EDGES + c->edges] + weight[CQI_OUTER + c->outer] + weight[CQI_BETWEEN + c->between];
    }
}

/* Gets the ring's features and their scores ready. */
static void cqi_score_ring(cq_decoder *d)
{
    cqi_ring *r = &d->ring;
    const int positions = cqi_position_channel(&d->shape);
    int k;
    if (positions >= 0) {
        cqi_read_offsets(d, (uint32_t)positions);
        if (r->located) cqi_locate_ring(r);
        else cqi_measure_ring(r);
        cqi_classify_edges(r);
    }
    if (!d->shape.fast) cqi_find_alternatives(r);
    cqi_score_ends(&d->model, r);
    for (k = 1; k < r->size; k++)
        r->of_steps[k] = d->model.weight[cqi_size_b(r, k)] + d->model.weight[cqi_size_a(r, k)];
}

/* At a first gate that was a centre one end is known: the others get no share. Returns what they had. */
static uint32_t cqi_forbid(const cqi_ring *r, int32_t *share)
{
    uint32_t lost = 0;
    int p, q;
    for (q = 1; q < r->size; q++) {
        for (p = 0; p < q; p++, share++) {
            if (r->side == 1 ? q == r->size - 1 : p == 0) continue;
            lost += (uint32_t)*share;
            *share = 0;
        }
    }
    return lost;
}

/* Turns scores into shares; returns their total. */
static uint32_t cqi_share_range(int32_t *score, int count)
{
    const int32_t best = cqi_best(score, count);
    uint32_t total = 0;
    int k;
    for (k = 0; k < count; k++) {
        uint32_t share = cqi_share((uint32_t)best - (uint32_t)score[k]);
        score[k] = (int32_t)share;
        total += share;
    }
    return total;
}

/* Codes one of several numbers that have shares of a total. */
static int cqi_code_share(cq_decoder *d, const int32_t *share, uint32_t total, int value)
{
    uint32_t start = 0, slot;
    int k = 0;
    if (CQI_ENCODING(d)) {
        for (; k < value; k++) start += (uint32_t)share[k];
        cq_encode_freq(&d->plan->range, start, (uint32_t)share[k], total);
        return k;
    }
    slot = cq_decode_slot(&d->range, total);
    for (; start + (uint32_t)share[k] <= slot; k++) start += (uint32_t)share[k];
    cq_decode_freq(&d->range, start, (uint32_t)share[k], total);
    return k;
}

/* Turns shares into what weights learn: all lose in proportion, and the chosen one gains what the others lose, so that
 * the sum of all scores does not drift. */
static void cqi_find_gradients(int32_t *share, int count, uint32_t total, int chosen)
{
    const uint32_t scale = ((uint32_t)CQI_TUNED(step, CQI_STEP) << 14) / total;
    int32_t gained = 0;
    int k;
    share[chosen] = 0;
    for (k = 0; k < count; k++) {
        const int32_t lost = (int32_t)((uint32_t)share[k] * scale >> 14);
        share[k] = -lost;
        gained += lost;
    }
    share[chosen] = gained;
}

/* Codes one of so many numbers by their scores; if it learns, these become what weights learn. */
static int cqi_code_scored(cq_decoder *d, int count, int value, int learns)
{
    uint32_t total = cqi_share_range(d->score, count);
    if (d->ring.side && !d->shape.fast) total -= cqi_forbid(&d->ring, d->score);
    value = cqi_code_share(d, d->score, total, value);
    if (learns) cqi_find_gradients(d->score, count, total, value);
    return value;
}

/* -- All candidates at once -- */

/* Keeps what a candidate learns, by what it has in common with others. */
static inline void cqi_gain(cqi_ring *r, int p, int q, int32_t gradient)
{
    r->now.gain[0][p] += gradient;
    r->now.gain[1][q] += gradient;
    r->now.gain[2][q - p] += gradient;
}

static void cqi_gain_all(cq_decoder *d)
{
    const uint8_t *rule = d->rule;
    const int32_t *gradient = d->score;
    int p, q;
    for (q = 1; q < d->ring.size; q++) {
        for (p = 0; p < q; p++, gradient++) {
            cqi_gain(&d->ring, p, q, *gradient);
            cqi_learn(&d->model, CQI_RULE + *rule++, *gradient);
        }
    }
}

/* Hands that on to the weights. */
static void cqi_learn_gains(cqi_model *m, cqi_ring *r)
{
    int k, j;
    for (k = 0; k < r->size; k++) {
        for (j = 0; j < 3; j++) {
            cqi_learn(m, r->entry[k][j], r->now.gain[0][k]);
            cqi_learn(m, r->entry[k][j] + 1, r->now.gain[1][k]);
        }
        if (k) {
            cqi_learn(m, cqi_size_b(r, k), r->now.gain[2][k]);
            cqi_learn(m, cqi_size_a(r, k), r->now.gain[2][k]);
        }
    }
}

static void cqi_learn_located(cq_decoder *d)
{
    const cqi_located *c = d->located, *const end = c + d->num_located;
    for (; c < end; c++) {
        const int32_t gradient = d->score[c->number];
        cqi_learn(&d->model, CQI_EDGES + c->edges, gradient);
        cqi_learn(&d->model, CQI_OUTER + c->outer, gradient);
        cqi_learn(&d->model, CQI_BETWEEN + c->between, gradient);
    }
}

/* Codes the pair as one of all candidates, and adapts. */
static void cqi_code_candidate(cq_decoder *d, int *p, int *q)
{
    cqi_ring *r = &d->ring;
    const int count = r->size * (r->size - 1) / 2;
    const int32_t best = cqi_score_candidates(d);
    int chosen = 0;
    if (r->located) {
        cqi_list_located(d, best - CQI_TUNED(settled, CQI_SETTLED));
        cqi_locate_candidates(d);
    }
    if (CQI_ENCODING(d)) chosen = cqi_pair_number(*p, *q);
    chosen = cqi_code_scored(d, count, chosen, 1);
    for (*q = 1; chosen >= cqi_pair_number(0, *q + 1);) ++*q;
    *p = chosen - cqi_pair_number(0, *q);
    cqi_gain_all(d);
    cqi_learn_gains(&d->model, r);
    if (r->located) cqi_learn_located(d);
}

/* -- Fast streams: first how far it is from p to q, then where p is --
 *
 * Two symbols with a few candidates each instead of one with D (D - 1) / 2: first the best pair of each number of
 * steps, then all pairs with as many. A pair's score is that of its ends and of the sizes that it makes. */

/* The p of the best pair so many steps apart. */
static int cqi_best_pair(const cqi_ring *r, int steps)
{
    const int32_t *of_p = r->of_p, *of_q = r->of_q + steps;
    const int count = r->size - steps;
    int32_t best = INT32_MIN;
    int p, at = 0;
    for (p = 0; p < count; p++) {
        const int32_t sum = of_p[p] + of_q[p];
        at = sum > best ? p : at;
        best = sum > best ? sum : best;
    }
    return at;
}

/* Codes which one it is of the pairs so many steps apart; or, for 0 steps, of the best pair for each number of them. */
static int cqi_code_listed(cq_decoder *d, int count, int steps, int value, int learns)
{
    cqi_ring *r = &d->ring;
    cqi_located *c = d->located;
    int k;
    for (k = 0; k < count; k++) {
        const int apart = steps ? steps : k + 1, p = steps ? k : cqi_best_pair(r, apart);
        c[k].p = (uint8_t)p;
        c[k].q = (uint8_t)(p + apart);
        d->score[k] = r->of_p[p] + r->of_q[p + apart] + r->of_steps[apart];
    }
    value = cqi_code_scored(d, count, value, learns);
    for (k = 0; k < count && learns; k++) cqi_gain(r, c[k].p, c[k].q, d->score[k]);
    return value;
}

/* Codes the pair; adapts after one of CQI_LEARN_EVERY splits. At a first gate that was a centre one end is known, and
 * so where p is. */
static void cqi_code_steps(cq_decoder *d, int *p, int *q)
{
    const int learns = d->mesh.num_vertices % CQI_LEARN_EVERY == 0;
    cqi_ring *r = &d->ring;
    const int steps = 1 + cqi_code_listed(d, r->size - 1, 0, *q - *p - 1, learns), count = r->size - steps;
    if (r->side) *p = r->side == 1 ? count - 1 : 0;
    else *p = cqi_code_listed(d, count, steps, *p, learns);
    *q = *p + steps;
    if (learns) cqi_learn_gains(&d->model, r);
}

/* Codes the pair p, q of the patch in d->ring, and adapts. */
static void cqi_code_pair(cq_decoder *d, int *p, int *q)
{
    cqi_score_ring(d);
    if (d->shape.fast) cqi_code_steps(d, p, q);
    else cqi_code_candidate(d, p, q);
    if (d->mesh.num_vertices % CQI_LIMIT_EVERY == 0) cqi_limit_weights(&d->model);
}

/* The pair that the plan has for the next split; what it says about one some splits away is asked for. */
static void cqi_plan_pair(const cq_decoder *d, int *p, int *q)
{
    cqi_plan *plan = d->plan;
    const cqi_collapse *c = &plan->collapse[--plan->next_collapse];
    if (plan->next_collapse >= CQI_AHEAD) {
        const cq_index b = c[-CQI_AHEAD].removed;
        CQI_FETCH(plan->decoded + b);
        CQI_FETCH_VALUE(&d->shape, plan->value[0], b);
    }
    *p = c->p;
    *q = c->q;
}

/* It became vertex b and the faces behind the first num_faces. */
static void cqi_plan_split(cq_decoder *d, cq_index b, cq_index num_faces)
{
    cqi_plan *p = d->plan;
    p->decoded[p->collapse[p->next_collapse].removed] = b;
    if (p->follows_faces) cqi_plan_new_faces(p, num_faces, d->mesh.num_faces);
}

static void cqi_report_split(cq_decoder *d, int p, int q)
{
    cq_level *level = cqi_level_report(d);
    level->sum_i += (uint32_t)p;
    level->sum_j += (uint32_t)(d->ring.size - 1 - q);
}

/* The split of the patch in d->ring: both indices, then the values, then the mesh. */
static cq_result cqi_code_split(cq_decoder *d, cq_index centre)
{
    const cq_index num_faces = d->mesh.num_faces;
    cq_index b;
    int p = 0, q = 0;
    cqi_read_ring(d);
    if (CQI_ENCODING(d)) cqi_plan_pair(d, &p, &q);
    cqi_code_pair(d, &p, &q);
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->indices, &cqi_level_report(d)->indices);
    if (!cqi_code_deltas(d, centre, p, q)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
    if (cqi_starved(d)) return CQ_TRUNCATED;
    b = cq_mesh_split(&d->mesh, d->ring.spoke[p], d->ring.spoke[q]);
    if (b == CQ_NONE) return CQ_ERROR_CORRUPT;
    cqi_apply_deltas(d, centre, b);
    if (CQI_REPORTING(d)) cqi_report_split(d, p, q);
    if (CQI_ENCODING(d)) cqi_plan_split(d, b, num_faces);
    return CQ_OK;
}

/* -- Steps --------------------------------------------------------------------------------------------------------- */

enum { CQI_HEADER, CQI_BASE, CQI_BASE_VALUES, CQI_LEVEL, CQI_CLEAR, CQI_WALK, CQI_SPLITS, CQI_COMPLETE };

/* A level must add a vertex for every 16 that it walks over: so all walks together take linear time. */
#define CQI_MIN_SPLITS(num_vertices) ((num_vertices) / 16 + 1)

static cq_result cqi_end_component(cq_decoder *d)
{
    cq_result result;
    int more = CQI_ENCODING(d) && d->plan->next_seed < d->plan->num_seeds;
    more = cqi_code_bit(d, CQI_COMPONENT, more);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (more) return cqi_start_component(d);
    result = cqi_finish_base(d);
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->base, NULL);
    d->phase = CQI_BASE_VALUES;
    return result;
}

static cq_result cqi_step_base(cq_decoder *d)
{
    if (!d->num_components) return cqi_start_component(d);
    if (!cqi_is_open(&d->draft, d->gate) && !cqi_find_gate(d)) return cqi_end_component(d);
    return cqi_grow_base(d);
}

static cq_result cqi_step_base_values(cq_decoder *d)
{
    cq_index faces = (cq_index)(cqi_all_components(&d->shape, 1) ? d->draft.num_faces : 0);
    if (d->value < d->draft.num_vertices + faces) return cqi_code_base_values(d);
    if (CQI_REPORTING(d)) {
        d->report->num_components = d->num_components;
        d->report->base_vertices = d->draft.num_vertices;
        d->report->base_faces = d->draft.num_faces;
    }
    d->mesh = d->draft;
    d->base_vertices = d->mesh.num_vertices;
    d->phase = CQI_LEVEL;
    return CQ_OK;
}

/* Begins a level, or ends the stream when all vertices are there: then all bytes must have been used. */
static cq_result cqi_step_level(cq_decoder *d)
{
    int other;
    if (d->mesh.num_vertices == d->shape.num_vertices) {
        d->phase = CQI_COMPLETE;
        if (CQI_ENCODING(d)) return CQ_DONE;
        return d->range.count < d->range.size || d->payload_left ? CQ_ERROR_CORRUPT : CQ_DONE;
    }
    if (d->level == CQ_MAX_LEVELS) return CQ_ERROR_CORRUPT; /* unreachable: by meshes below 5 million vertices */
    other = cqi_code_bit(d, CQI_OTHER_LEVEL, 0);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (other) return CQ_ERROR_UNSUPPORTED;
    d->level++;
    d->splits = 0;
    if (CQI_ENCODING(d)) cqi_plan_rewind(d->plan, d->plan->num_levels + 1 - d->level);
    d->rate = CQI_TUNED(rate, CQI_RATE(d->mesh.num_vertices));
    cqi_walk_begin(&d->walk);
    d->phase = CQI_CLEAR;
    return CQ_OK;
}

static void cqi_report_walk(cq_decoder *d)
{
    cq_level *level = cqi_level_report(d);
    d->report->num_levels = d->level;
    memset(level, 0, sizeof *level);
    cqi_charge(d, &d->report->flags, &level->flags);
    level->num_patches = d->walk.tail;
    level->num_splits = d->splits;
    level->num_vertices = (uint32_t)d->mesh.num_vertices + d->splits;
}

static cq_result cqi_step_walk(cq_decoder *d)
{
    cq_result result = cqi_code_patch(d);
    if (result != CQ_DONE) return result;
    if (d->splits < CQI_MIN_SPLITS(d->mesh.num_vertices)) return CQ_ERROR_CORRUPT;
    if (d->splits > d->shape.num_vertices - d->mesh.num_vertices) return CQ_ERROR_CORRUPT;
    if (CQI_REPORTING(d)) cqi_report_walk(d);
    d->level_end = d->mesh.num_vertices + d->splits;
    d->phase = CQI_SPLITS;
    return CQ_OK;
}

/* What a split of a large mesh reads is all over the memory, so it is asked for some patches before, one spoke of each
 * at a time. The halfedges exist, but after a split they may be those of another vertex. */
static void cqi_fetch_ring(const cq_decoder *d, cq_index *at)
{
    const cq_mesh *m = &d->mesh;
    const cq_index v = m->origin[*at], next = m->twin[cq_next(*at)];
    CQI_FETCH(m->mark + v);
    CQI_FETCH(m->valence + v);
    CQI_FETCH_VALUE(&d->shape, d->channel[0], v);
    CQI_FETCH_HALFEDGE(m, next);
    *at = next;
}

static void cqi_look_ahead(cq_decoder *d)
{
    const cq_index *spoke = d->patch + d->walk.tail;
    int k;
    if (!CQI_FETCHES || d->shape.num_vertices < CQI_LARGE_MESH) return;
    if (d->walk.tail > CQI_AHEAD) {
        spoke -= CQI_AHEAD + 1;
        CQI_FETCH_HALFEDGE(&d->mesh, spoke[0]);
        d->ahead[d->walk.tail % CQI_AHEAD] = cq_prev(spoke[1]);
    }
    for (k = 0; k < CQI_AHEAD; k++) cqi_fetch_ring(d, &d->ahead[k]);
}

/* Leaves patches in reverse order down to the next split one, and splits it. */
static cq_result cqi_step_split(cq_decoder *d)
{
    cq_mesh *m = &d->mesh;
    while (d->walk.tail) {
        cq_index spoke = d->patch[--d->walk.tail], centre = m->origin[spoke];
        int split = m->mark[centre] & CQI_MANY;
        m->mark[centre] &= CQI_SEED;
        cqi_look_ahead(d);
        cqi_leave(d, spoke);
        if (split) return cqi_code_split(d, centre);
    }
    d->phase = CQI_LEVEL;
    return CQ_OK;
}

static cq_result cqi_step(cq_decoder *d)
{
    switch (d->phase) {
    case CQI_BASE: return cqi_step_base(d);
    case CQI_BASE_VALUES: return cqi_step_base_values(d);
    case CQI_LEVEL: return cqi_step_level(d);
    case CQI_CLEAR:
        if (!cqi_walk_clear(&d->mesh, &d->walk)) d->phase = CQI_WALK;
        return CQ_OK;
    case CQI_WALK: return cqi_step_walk(d);
    default: return cqi_step_split(d);
    }
}

/* -- Decoder ------------------------------------------------------------------------------------------------------- */

/* Gets ready for the first step. The memory holds at least cq_decoder_bytes of d->shape. */
static void cqi_start(cq_decoder *d)
{
    cqi_arena arena;
    cq_value *values;
    size_t v = cqi_all_vertices(&d->shape);
    uint32_t k;
    arena.next = d->memory;
    arena.left = d->memory_size;
    cqi_mesh_carve(&d->mesh, &d->shape, &arena);
    d->patch = (cq_index *)cqi_take(&arena, cqi_all_faces(&d->shape) / 3 + 1, sizeof(cq_index));
    values = (cq_value *)cqi_take(&arena, v * cqi_all_components(&d->shape, 0), sizeof(cq_value));
    for (k = 0; k < d->shape.num_channels; k++) {
        if (d->shape.channel[k].merge == CQ_PER_FACE) {
            d->channel[k] = (cq_value *)cqi_take(&arena, d->shape.num_faces, sizeof(cq_value));
            continue;
        }
        d->channel[k] = values;
        values += v * d->shape.channel[k].components;
    }
    d->step_bytes = CQI_STEP_BYTES(cqi_all_components(&d->shape, 0) + cqi_all_components(&d->shape, 1));
    d->draft = d->mesh;
    d->rate = CQI_TUNED(rate, CQI_RATE(0));
    memset(d->delta, 0, sizeof d->delta);
    d->virtual_scan = (cq_index)(3 * d->mesh.first_virtual_face);
    cqi_model_init(&d->model, &d->shape);
    for (k = 0; k < CQI_SPREADS; k++) d->model.mean_bits[k] = (uint16_t)(128 * k);
    d->phase = d->shape.num_vertices ? CQI_BASE : CQI_BASE_VALUES;
}

cq_result cq_decoder_init(cq_decoder *d, void *memory, size_t memory_size)
{
    if (!d || !memory) return CQ_ERROR_ARGUMENT;
    memset(d, 0, sizeof *d);
    d->memory = (uint8_t *)memory;
    d->memory_size = memory_size;
    return CQ_OK;
}

static int cqi_fits_value(const cq_channel *c) { return c->bits <= CQ_MAX_BITS || cqi_is_exact(c); }

static cq_result cqi_fits_build(const cq_shape *s)
{
    uint32_t k;
    for (k = 0; k < s->num_channels; k++)
        if (!cqi_fits_value(&s->channel[k])) return CQ_ERROR_UNSUPPORTED;
    return cq_decoder_bytes(s) ? CQ_OK : CQ_ERROR_TOO_LARGE;
}

static cq_result cqi_open_stream(cq_decoder *d, const cqi_header *h)
{
    cq_result result;
    result = cqi_fits_build(&d->shape);
    if (result != CQ_OK) return result;
    if (!cqi_aligned(d->memory) || d->memory_size < cq_decoder_bytes(&d->shape)) return CQ_ERROR_MEMORY;
    d->payload_left = d->payload_size = h->payload_size;
    d->expected_crc = h->payload_crc;
    if (CQI_REPORTING(d)) {
        memset(d->report, 0, sizeof *d->report);
        d->report->shape = d->shape;
        d->report->bytes = h->header_size + h->payload_size;
    }
    d->range.size = 0;
    cqi_start(d);
    return CQ_OK;
}

/* Takes header bytes one by one, so that none behind a short stream is touched. */
static cq_result cqi_take_header(cq_decoder *d, cq_bytes *in)
{
    cqi_header h;
    cq_result result = CQ_NEED_INPUT;
    h.shape = &d->shape;
    while (result == CQ_NEED_INPUT && in && in->size) {
        d->buffer[d->range.size++] = *in->data++;
        in->size--;
        result = cqi_read_header(d->buffer, d->range.size, &h);
    }
    if (result == CQ_NEED_INPUT && d->ended) return CQ_TRUNCATED;
    return result == CQ_OK ? cqi_open_stream(d, &h) : result;
}

/* Moves what is left in the buffer to its start: less than half of it. */
static void cqi_drop_used(cq_decoder *d)
{
    size_t left = d->range.size - d->range.count;
    memcpy(d->buffer, d->buffer + d->range.count, left);
    d->dropped += d->range.count;
    d->range.size = left;
    d->range.count = 0;
}

/* Moves payload bytes from the input to the buffer while less than a step is left there. */
static void cqi_take_payload(cq_decoder *d, cq_bytes *in)
{
    while (d->range.size < d->range.count + d->step_bytes && d->payload_left && in && in->size) {
        size_t n;
        if (d->range.size == CQI_BUFFER_BYTES) cqi_drop_used(d);
        n = CQI_BUFFER_BYTES - d->range.size;
        n = n < in->size ? n : in->size;
        n = n < d->payload_left ? n : d->payload_left;
        memcpy(d->buffer + d->range.size, in->data, n);
        d->crc = cqi_crc32(d->crc, in->data, n);
        d->range.size += n;
        d->payload_left -= n;
        in->data += n;
        in->size -= n;
    }
}

/* Enough input for any step: all that can be needed, or all that there is. */
static int cqi_is_ready(const cq_decoder *d)
{
    return d->range.size >= d->range.count + d->step_bytes || !d->payload_left || d->ended;
}

static cq_result cqi_finish_stream(cq_decoder *d)
{
    if (d->crc != d->expected_crc) return CQ_ERROR_CHECKSUM;
    if (CQI_REPORTING(d)) {
        cq_report *r = d->report;
        r->header = (uint64_t)r->bytes * 8 * 65536 - r->base - r->flags - r->indices - r->positions - r->channels;
    }
    return CQ_DONE;
}

static cq_result cqi_run(cq_decoder *d, cq_bytes *in, uint32_t budget)
{
    cq_result result = CQ_OK;
    while (budget) {
        cqi_take_payload(d, in);
        if (!cqi_is_ready(d)) return CQ_NEED_INPUT;
        if (!d->range.data) {
            cq_range_decoder_init(&d->range, d->buffer, d->range.size);
            if (CQI_REPORTING(d)) d->cost = 4 * 8 * 65536 - cqi_log2(0xffffffffu);
        }
        budget--;
        result = cqi_step(d);
        if (result != CQ_OK) break;
    }
    if (result == CQ_DONE) result = cqi_finish_stream(d);
    d->status = result;
    return result;
}

cq_result cq_decode(cq_decoder *d, cq_bytes *in, uint32_t budget)
{
    if (!d || (in && in->size && !in->data)) return CQ_ERROR_ARGUMENT;
    if (d->status != CQ_OK) return d->status;
    if (!in) d->ended = 1;
    if (d->phase == CQI_HEADER) {
        cq_result result = cqi_take_header(d, in);
        if (result == CQ_NEED_INPUT) return result;
        if (result != CQ_OK) {
            d->status = result;
            return result;
        }
    }
    return cqi_run(d, in, budget);
}

/* -- Encoder: simplification (section 2.2 of the paper) ------------------------------------------------------------ */

#ifndef CQ_NO_ENCODER

typedef struct cqi_encoder {
    cqi_plan plan;
    cq_decoder replay;
} cqi_encoder;

#define CQI_ENCODER_BYTES ((sizeof(cqi_encoder) + 7) / 8 * 8)

size_t cq_encoder_bytes(const cq_shape *s)
{
    cqi_size v, f, c, plan;
    if (!s || !cqi_countable(s)) return 0;
    v = cqi_all_vertices(s);
    f = cqi_all_faces(s);
    c = cqi_all_components(s, 0);
    plan = (v + 1) * sizeof(cqi_collapse) + (3 * v + f / 3 + 1 + 2 * f) * sizeof(cq_index);
    plan += s->num_vertices * c * sizeof(cq_value);
    plan += 7 * (4 - sizeof(cq_index)); /* roundings of blocks of indices */
    return cqi_bytes(CQI_ENCODER_BYTES + CQ_MESH_BYTES(v, f) + CQI_ROUND(plan) + cqi_decoder_size(s));
}

/* Joins the values of b to those of a; b's become the difference. */
static void cqi_merge_values(cqi_plan *p, const cq_shape *s, cq_index a, cq_index b)
{
    uint32_t k, c;
    for (k = 0; k < s->num_channels; k++) {
        uint32_t stride = s->channel[k].components;
        if (s->channel[k].merge != CQ_MIDPOINT) continue;
        for (c = 0; c < stride; c++) {
            cq_value *at = p->value[k] + (size_t)a * stride + c, *bt = p->value[k] + (size_t)b * stride + c;
            int32_t delta = *bt - *at;
            *at = (cq_value)(*at + cqi_floor_half(delta));
            *bt = (cq_value)delta;
        }
    }
}

static void cqi_split_values(cqi_plan *p, const cq_shape *s, cq_index a, cq_index b)
{
    uint32_t k, c;
    for (k = 0; k < s->num_channels; k++) {
        uint32_t stride = s->channel[k].components;
        if (s->channel[k].merge != CQ_MIDPOINT) continue;
        for (c = 0; c < stride; c++) {
            cq_value *at = p->value[k] + (size_t)a * stride + c, *bt = p->value[k] + (size_t)b * stride + c;
            *at = (cq_value)(*at - cqi_floor_half(*bt));
            *bt = (cq_value)(*at + *bt);
        }
    }
}

/* Would the collapse of a first gate's front vertex with b leave a virtual vertex in front of the gate? The decoder
 * would then take the gate from its other side. */
static int cqi_turns_gate(const cq_mesh *m, cq_index spoke, cq_index b)
{
    cq_index l_to_r = cq_next(spoke), r_to_a = cq_next(l_to_r), across = CQ_NONE;
    if (b == m->origin[l_to_r]) across = m->twin[r_to_a];
    if (b == m->origin[r_to_a]) across = m->twin[spoke];
    return across != CQ_NONE && cq_is_virtual(m, m->origin[cq_prev(across)]);
}

static uint64_t cqi_square_distance(const cq_value *positions, cq_index a, cq_index b)
{
    uint64_t sum = 0;
    int c;
    for (c = 0; c < 3; c++) {
        int64_t x = (int64_t)positions[3 * (size_t)a + (size_t)c] - positions[3 * (size_t)b + (size_t)c];
        sum += (uint64_t)(x * x);
    }
    return sum;
}

/* -- What a collapse loses: the goals balanced and best-looking --
 *
 * Quadric error (Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997) without memory
 * (Lindstrom, Turk, "Fast and Memory Efficient Polygonal Simplification", 1998): squared distances of the merged vertex
 * from the planes of the triangles around both ends, times their areas; and from the lines of boundary edges, times
 * their squared lengths. A crease has planes on both sides, and so resists by itself. A collapse that turns a triangle
 * over, or leaves it an eighth of its area as seen along its normal, loses anything.
 *
 * A level refuses collapses that lose more than a limit, and still takes the smallest valence of the others. At first
 * the limit is what half of the edges lose, or less. It grows from level to level about as the losses of a smooth
 * surface do: a sixth fewer vertices make areas 1.2 times as large, distances from the planes too, losses 1.7 times.
 * What stays refused are features; where the limit grows less, more patches are isolated, whose flags cost bits. It
 * also grows when a level is not worth its walk; in the end it falls.
 *
 * Losses are compared as numbers that grow with their logarithm, in 1/256 octave.
 *
 * Bounds: offsets from the centre of a fan have 12 bits, half an edge 11, areas 25, volumes 38. So distances, in
 * sixteenths, are below 2^17, as cqi_norm is never less than half a length; their products with volumes are
 * below 2^55; squares of areas of a boundary's edge and half an edge below 2^50; and all of both fans together below
 * 2^57. */
#define CQI_ANY_LOSS 0xffffffffu
#define CQI_OFFSET_BITS 12
#define CQI_OCTAVE 256

/* How much more a level may lose than the one before; and at least so much more than itself, if it is done again. */
#define CQI_LEVEL_LOSS(goal) ((goal) == CQ_BALANCED ? 4 * CQI_OCTAVE / 5 : CQI_OCTAVE / 2)
#define CQI_MORE_LOSS ((uint32_t)2 * CQI_OCTAVE)

/* Vertices that a level with a limit must remove, of one that keeps so many: half of what one without can. */
#define CQI_WORTH(num_vertices) ((num_vertices) / 8 + 1)

/* The triangles around a vertex, with offsets from it. */
typedef struct cqi_fan {
    cq_index centre;
    int size, shift;                             /* offsets are shifted down to CQI_OFFSET_BITS */
    cq_index vertex[CQ_MAX_VALENCE + 1];         /* clockwise, the first again at the end */
    cqi_vector at[CQ_MAX_VALENCE + 1];           /* 0 for virtual ones */
    cqi_vector area[CQ_MAX_VALENCE];             /* twice, of the triangle with the next; of a boundary: its edge */
    int32_t norm[CQ_MAX_VALENCE];                /* of that; -1: a boundary */
} cqi_fan;

static int64_t cqi_wide_dot(cqi_vector a, cqi_vector b)
{
    return (int64_t)a.x * b.x + (int64_t)a.y * b.y + (int64_t)a.z * b.z;
}

static cqi_vector cqi_subtract(cqi_vector a, cqi_vector b)
{
    a.x -= b.x;
    a.y -= b.y;
    a.z -= b.z;
    return a;
}

static cqi_vector cqi_offset(const cqi_plan *p, cq_index from, cq_index to)
{
    const cq_value *a = p->positions + 3 * (size_t)from, *b = p->positions + 3 * (size_t)to;
    cqi_vector x;
    x.x = (int32_t)b[0] - a[0];
    x.y = (int32_t)b[1] - a[1];
    x.z = (int32_t)b[2] - a[2];
    return x;
}

/* Lists the neighbours of v, not more than CQ_MAX_VALENCE. */
static void cqi_list_fan(const cqi_plan *p, cqi_fan *f, cq_index v)
{
    const cq_mesh *m = &p->mesh;
    const cqi_vector none = { 0, 0, 0 };
    cq_index h = m->out[v];
    uint32_t bits = 0;
    int k, n = 0;
    do {
        cq_index w = m->origin[m->twin[h]];
        cqi_vector x = cq_is_virtual(m, w) ? none : cqi_offset(p, v, w);
        f->vertex[n] = w;
        f->at[n++] = x;
        bits |= cqi_abs(x.x) | cqi_abs(x.y) | cqi_abs(x.z);
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    f->shift = cqi_bit_length(bits >> CQI_OFFSET_BITS);
    for (k = 0; f->shift && k < n; k++) f->at[k] = cqi_shift(f->at[k], f->shift);
    f->vertex[n] = f->vertex[0];
    f->at[n] = f->at[0];
    f->size = n;
    f->centre = v;
}

static void cqi_read_fan(const cqi_plan *p, cqi_fan *f, cq_index v)
{
    int k;
    cqi_list_fan(p, f, v);
    for (k = 0; k < f->size; k++) {
        int from = cq_is_virtual(&p->mesh, f->vertex[k]), to = cq_is_virtual(&p->mesh, f->vertex[k + 1]);
        f->area[k] = from ? f->at[k + 1] : to ? f->at[k] : cqi_cross(f->at[k], f->at[k + 1]);
        f->norm[k] = from || to ? -1 : cqi_norm(f->area[k]);
    }
}

/* If the centre goes to x. Triangles without an area lose nothing. */
static uint64_t cqi_fan_loss(const cqi_fan *f, cqi_vector x)
{
    uint64_t sum = 0;
    int k;
    for (k = 0; k < f->size; k++) {
        if (f->norm[k] > 0) {
            int64_t volume = cqi_wide_dot(f->area[k], x);
            uint64_t above = (uint64_t)(volume < 0 ? -volume : volume);
            sum += 16 * above / (uint32_t)f->norm[k] * above >> 4;
        } else if (f->norm[k]) {
            cqi_vector area = cqi_cross(f->area[k], x);
            sum += (uint64_t)cqi_wide_dot(area, area);
        }
    }
    return sum;
}

/* Is a triangle turned if the centre goes to x? Those that the collapse removes are not. */
static int cqi_turns(const cqi_fan *f, cqi_vector x, cq_index removed)
{
    int k;
    for (k = 0; k < f->size; k++) {
        cqi_vector along = cqi_subtract(f->at[k + 1], f->at[k]);
        int64_t before, less;
        if (f->norm[k] <= 0 || f->vertex[k] == removed || f->vertex[k + 1] == removed) continue;
        before = cqi_wide_dot(f->area[k], f->area[k]);
        less = cqi_wide_dot(f->area[k], cqi_cross(x, along));
        if (8 * (before - less) <= before) return 1;
    }
    return 0;
}

/* A loss of 16^shift x. */
static uint32_t cqi_loss(uint64_t x, int shift)
{
    int n = x >> 32 ? 32 + cqi_bit_length((uint32_t)(x >> 32)) : cqi_bit_length((uint32_t)x);
    uint32_t fraction = (uint32_t)(n > 8 ? x >> (n - 9) : x << (9 - n)) & 255;
    return x ? (uint32_t)(n + 4 * shift) * CQI_OCTAVE + fraction : 0;
}

/* Of a collapse of h: a number above the limit if it is above the limit. */
static uint32_t cqi_loss_of(const cqi_plan *p, cqi_fan *fan, cq_index h)
{
    cqi_fan *a = fan, *b = fan + 1;
    const cq_index from = p->mesh.origin[h], to = cq_target(&p->mesh, h);
    cqi_vector x = cqi_offset(p, from, to), half, rest;
    uint64_t sum;
    uint32_t loss;
    int shift;
    half.x = cqi_floor_half(x.x);
    half.y = cqi_floor_half(x.y);
    half.z = cqi_floor_half(x.z);
    rest = cqi_subtract(half, x);
    if (a->centre != from) cqi_read_fan(p, a, from);
    half = a->shift ? cqi_shift(half, a->shift) : half;
    sum = cqi_fan_loss(a, half);
    loss = cqi_loss(sum, a->shift);
    if (loss > p->most_loss) return loss;
    cqi_read_fan(p, b, to);
    rest = b->shift ? cqi_shift(rest, b->shift) : rest;
    shift = a->shift > b->shift ? a->shift : b->shift;
    sum = (sum >> 4 * (shift - a->shift)) + (cqi_fan_loss(b, rest) >> 4 * (shift - b->shift));
    loss = cqi_loss(sum, shift);
    if (loss > p->most_loss) return loss;
    return cqi_turns(a, half, to) || cqi_turns(b, rest, from) ? CQI_ANY_LOSS : loss;
}

/* Does the collapse of h lose no more than this level allows? What is refused is noted. */
static int cqi_allows(cqi_plan *p, cqi_fan *fan, cq_index h)
{
    uint32_t loss;
    if (p->most_loss == CQI_ANY_LOSS) return 1;
    loss = cqi_loss_of(p, fan, h);
    if (loss <= p->most_loss) return 1;
    if (loss < p->refused_loss) p->refused_loss = loss;
    return 0;
}

/* The limit for another try, when a level was not worth its walk. */
static void cqi_allow_more_loss(cqi_plan *p)
{
    uint32_t more = p->most_loss + CQI_MORE_LOSS;
    p->most_loss = p->refused_loss > more ? p->refused_loss : more;
}

/* What half of the edges lose, in whole octaves, of 256 or more that are spread over the vertices. */
static uint32_t cqi_first_limit(cqi_plan *p, cq_index num_vertices)
{
    const cq_mesh *m = &p->mesh;
    const cq_index step = (cq_index)(num_vertices / 512 + 1);
    uint32_t count[128], all = 0, below = 0, octave = 0;
    cqi_fan fan[2];
    cq_index v;
    memset(count, 0, sizeof count);
    p->most_loss = CQI_ANY_LOSS - 1;
    for (v = 0; v < num_vertices; v = (cq_index)(v + step)) {
        cq_index h = m->out[v], w = cq_target(m, h);
        uint32_t loss;
        if (cq_is_virtual(m, w) || m->valence[v] > CQ_MAX_VALENCE || m->valence[w] > CQ_MAX_VALENCE) continue;
        fan->centre = CQ_NONE;
        loss = cqi_loss_of(p, fan, h);
        all++;
        if (loss != CQI_ANY_LOSS) count[loss / CQI_OCTAVE]++;
    }
    while (octave < 127 && 2 * (below += count[octave]) < all) octave++;
    return octave * CQI_OCTAVE;
}

/* -- Choosing collapses -- */

/* Is b better to collapse a with than the best one so far? Smaller valence; then, if that is the goal, nearer. */
static int cqi_is_better(const cqi_plan *p, cq_index a, cq_index b, cq_index best)
{
    cq_index valence = p->mesh.valence[b], other = p->mesh.valence[best];
    if (valence != other || !p->positions) return valence < other;
    return cqi_square_distance(p->positions, a, b) < cqi_square_distance(p->positions, a, best);
}

/* Lists the spokes to neighbours that are available, clockwise from L, and marks all neighbours. */
static int cqi_list_candidates(const cq_mesh *m, cq_index spoke, cq_index *candidate, int *boundary)
{
    cq_index h = spoke;
    int n = 0;
    *boundary = 0;
    do {
        const cq_index b = cq_target(m, h);
        CQI_FETCH_HALFEDGE(m, cqi_behind(m, h));
        *boundary |= cq_is_virtual(m, b);
        if (!cqi_is_conquered(m, b)) candidate[n++] = h;
        m->mark[b] |= CQI_SCRATCH;
        h = cq_clockwise(m, h);
    } while (h != spoke);
    return n;
}

/* The best of the candidates, of equal ones the first. */
static int cqi_best_candidate(const cqi_plan *p, cq_index a, const cq_index *candidate, int n)
{
    int best = 0, k;
    for (k = 1; k < n; k++)
        if (cqi_is_better(p, a, cq_target(&p->mesh, candidate[k]), cq_target(&p->mesh, candidate[best]))) best = k;
    return best;
}

/* The neighbour B to collapse the front vertex A with, as the halfedge A -> B: the best one that can be, and loses no
 * more than is allowed. CQ_NONE: the patch is isolated. */
static cq_index cqi_choose(cqi_plan *p, cq_index spoke, int first)
{
    const cq_mesh *m = &p->mesh;
    cq_index a = m->origin[spoke], candidate[CQ_MAX_VALENCE], chosen = CQ_NONE;
    cqi_fan fan[2];
    int boundary, n, k;
    if (m->valence[a] > CQ_MAX_VALENCE) return CQ_NONE;
    fan->centre = CQ_NONE;
    n = cqi_list_candidates(m, spoke, candidate, &boundary);
    while (n && chosen == CQ_NONE) {
        const int best = cqi_best_candidate(p, a, candidate, n);
        const cq_index h = candidate[best];
        if (cqi_collapsible(m, h, CQ_MAX_VALENCE, boundary) &&
            !(first && cqi_turns_gate(m, spoke, cq_target(m, h))) && cqi_allows(p, fan, h))
            chosen = h;
        for (n--, k = best; k < n; k++) candidate[k] = candidate[k + 1];
    }
    cqi_mark_ring(m, a, 0);
    return chosen;
}

/* The number of a spoke on the ring that begins with another. */
static uint8_t cqi_spoke_number(const cq_mesh *m, cq_index spoke, cq_index wanted)
{
    uint8_t n = 0;
    for (; spoke != wanted; spoke = cq_clockwise(m, spoke)) n++;
    return n;
}

static cq_index cqi_nth_spoke(const cq_mesh *m, cq_index spoke, int n)
{
    for (; n; n--) spoke = cq_clockwise(m, spoke);
    return spoke;
}

/* Collapses A -> B in the next patch, entered by a spoke of the gate's front vertex, and notes that. Returns the entry
 * spoke of what it is collapsed to. */
static cq_index cqi_collapse_noted(cqi_plan *p, const cq_shape *s, const cqi_walk *w, cq_index spoke, cq_index h,
                                   int side)
{
    cq_mesh *m = &p->mesh;
    cqi_collapse *c = &p->collapse[p->next_collapse++];
    const cq_index a = m->origin[h], b = cq_target(m, h), l = cq_target(m, spoke), r = cq_target(m, cq_next(spoke));
    cq_index first, last;
    CQI_FETCH_VALUE(s, p->value[0], a);
    CQI_FETCH_VALUE(s, p->value[0], b);
    cq_mesh_collapse(m, h, &first, &last);
    cqi_merge_values(p, s, a, b);
    if (side) spoke = cqi_first_spoke(m, cqi_find_spoke(m, l, r), side);
    c->removed = b;
    c->patch = w->tail;
    c->p = cqi_spoke_number(m, spoke, first);
    c->q = cqi_spoke_number(m, spoke, last);
    c->side = (uint8_t)side;
    c->level = (uint8_t)p->current;
    return spoke;
}

/* Takes back the last collapse. */
static void cqi_undo_collapse(cqi_plan *p, const cq_shape *s)
{
    const cqi_collapse *c = &p->collapse[--p->next_collapse];
    const cq_index spoke = p->patch[c->patch];
    cq_mesh_split(&p->mesh, cqi_nth_spoke(&p->mesh, spoke, c->p), cqi_nth_spoke(&p->mesh, spoke, c->q));
    cqi_split_values(p, s, p->mesh.origin[spoke], c->removed);
}

/* One patch: the gate's front vertex is collapsed with a neighbour, or is isolated. At a first gate, a front vertex A
 * that goes with L or R is collapsed into it, so that L and R live on. Returns 1 if something was collapsed. */
static int cqi_conquer_patch(cqi_plan *p, const cq_shape *s, cqi_walk *w, cq_index spoke, int first)
{
    cq_mesh *m = &p->mesh;
    cq_index h = cqi_choose(p, spoke, first);
    if (h != CQ_NONE) {
        const cq_index b = cq_target(m, h);
        const int side = !first ? 0 : b == cq_target(m, spoke) ? 1 : b == cq_target(m, cq_next(spoke)) ? 2 : 0;
        spoke = cqi_collapse_noted(p, s, w, spoke, side ? m->twin[h] : h, side);
    }
    cqi_conquer_ring(m, spoke);
    cqi_conquer(m, w, p->patch, spoke, h != CQ_NONE);
    return h != CQ_NONE;
}

static cq_index cqi_plan_next_spoke(cqi_plan *p, cqi_walk *w, int *first)
{
    cq_index spoke = cqi_next_gate(&p->mesh, w, p->patch);
    *first = spoke == CQ_NONE;
    while (*first && w->seed < p->num_seeds && cqi_is_pillow(&p->mesh, p->seed[2 * (size_t)w->seed])) w->seed++;
    if (!*first || w->seed == p->num_seeds) return spoke;
    spoke = cqi_find_spoke(&p->mesh, p->seed[2 * (size_t)w->seed], p->seed[2 * (size_t)w->seed + 1]);
    w->seed++;
    return cq_prev(cqi_first_gate(&p->mesh, spoke));
}

/* Simplifies by one level. False if that is not worth it; the mesh is then unchanged. */
static int cqi_simplify(cqi_plan *p, const cq_shape *s, cq_index *num_live)
{
    cqi_walk w;
    cq_index spoke, kept, splits = 0;
    int first;
    cqi_walk_begin(&w);
    memset(p->mesh.mark, 0, p->mesh.num_vertices);
    cqi_conquer_virtual(&p->mesh);
    while ((spoke = cqi_plan_next_spoke(p, &w, &first)) != CQ_NONE)
        splits = (cq_index)(splits + (cq_index)cqi_conquer_patch(p, s, &w, spoke, first));
    kept = (cq_index)(*num_live - splits);
    if (splits < (p->most_loss == CQI_ANY_LOSS ? CQI_MIN_SPLITS(kept) : CQI_WORTH(kept))) {
        while (splits--) cqi_undo_collapse(p, s);
        return 0;
    }
    *num_live = kept;
    return 1;
}

/* The vertex that stands for all that are known to be connected with v: the end of a chain, halved on the way. */
static cq_index cqi_find_root(cq_index *parent, cq_index v)
{
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

/* Finds the components and a first gate for each: the first halfedge of its first face. parent is scratch. */
static void cqi_find_components(cqi_plan *p, cq_index *parent)
{
    cq_mesh *m = &p->mesh;
    cq_index v, f, h;
    for (v = 0; v < m->num_vertices; v++) parent[v] = v;
    for (h = 0; h < 3 * m->num_faces; h++) {
        cq_index a = cqi_find_root(parent, m->origin[h]), b = cqi_find_root(parent, cq_target(m, h));
        parent[a < b ? b : a] = a < b ? a : b;
    }
    p->num_seeds = 0;
    for (f = 0; f < m->num_faces; f++) {
        cq_index root = cqi_find_root(parent, m->origin[3 * f]);
        if (m->mark[root]) continue;
        m->mark[root] = 1;
        p->seed[2 * (size_t)p->num_seeds] = m->origin[3 * f];
        p->seed[2 * (size_t)p->num_seeds++ + 1] = m->origin[3 * f + 1];
    }
}

static cq_result cqi_check_channel(const cq_input *in, uint32_t k, cq_place *place)
{
    const cq_channel *channel = &in->shape.channel[k];
    const int per_face = channel->merge == CQ_PER_FACE;
    size_t i, c, n = per_face ? in->shape.num_faces : in->shape.num_vertices;
    if (!cqi_channel_is_valid(channel) || !in->values[k]) return CQ_ERROR_ARGUMENT;
    if (!cqi_fits_value(channel)) return CQ_ERROR_UNSUPPORTED;
    for (i = 0; i < n; i++)
        for (c = 0; c < channel->components; c++)
            if (!cqi_value_fits(channel, in->values[k][i * channel->components + c]))
                return cqi_error(place, CQ_ERROR_VALUE, per_face ? (cq_index)i : CQ_NONE,
                                 per_face ? CQ_NONE : (cq_index)i, CQ_NONE);
    return CQ_OK;
}

static cq_result cqi_check_values(const cq_input *in, cq_place *place)
{
    cq_result result = CQ_OK;
    uint32_t k;
    for (k = 0; k < in->shape.num_channels && result == CQ_OK; k++) result = cqi_check_channel(in, k, place);
    return result;
}

/* Lays out the encoder behind its struct, and copies the values. */
static void cqi_encoder_carve(cqi_encoder *e, const cq_input *in, cqi_arena *arena)
{
    cqi_plan *p = &e->plan;
    const cq_shape *s = &in->shape;
    size_t v = cqi_all_vertices(s), f = cqi_all_faces(s);
    cq_value *values;
    uint32_t k;
    p->collapse = (cqi_collapse *)cqi_take(arena, v + 1, sizeof(cqi_collapse));
    p->decoded = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->to_input = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->seed = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->patch = (cq_index *)cqi_take(arena, f / 3 + 1, sizeof(cq_index));
    p->face_input = (cq_index *)cqi_take(arena, f, sizeof(cq_index));
    p->face_decoded = (cq_index *)cqi_take(arena, f, sizeof(cq_index));
    memset(p->decoded, 0xff, v * sizeof(cq_index));
    memset(p->face_decoded, 0xff, f * sizeof(cq_index));
    values = (cq_value *)cqi_take(arena, (size_t)s->num_vertices * cqi_all_components(s, 0), sizeof(cq_value));
    for (k = 0; k < s->num_channels; k++) {
        size_t n = (size_t)s->num_vertices * s->channel[k].components;
        if (s->channel[k].merge == CQ_PER_FACE) continue;
        p->value[k] = values;
        memcpy(values, in->values[k], n * sizeof(cq_value));
        values += n;
    }
    p->input = in->values;
    p->follows_faces = in->face_map || cqi_all_components(s, 1);
    e->replay.shape = *s;
    e->replay.plan = p;
    e->replay.memory = arena->next;
    e->replay.memory_size = arena->left;
}

static void cqi_progress(const cq_input *in, uint32_t done)
{
    if (in->progress) in->progress(in->user, done, 2 * in->shape.num_vertices);
}

static void cqi_set_goal(cqi_plan *p, const cq_input *in)
{
    const int channel = cqi_position_channel(&in->shape);
    p->most_loss = CQI_ANY_LOSS;
    if (in->goal == CQ_LEAST_CONNECTIVITY || channel < 0) return;
    p->positions = p->value[channel];
    if (in->goal == CQ_SMALLEST) return;
    p->level_loss = CQI_LEVEL_LOSS(in->goal);
    p->most_loss = cqi_first_limit(p, (cq_index)in->shape.num_vertices);
}

static void cqi_simplify_all(cqi_encoder *e, const cq_input *in)
{
    cqi_plan *p = &e->plan;
    cq_index live = (cq_index)in->shape.num_vertices;
    cqi_set_goal(p, in);
    cqi_find_components(p, p->to_input);
    p->current = 1;
    while (p->current <= CQ_MAX_LEVELS) {
        p->refused_loss = CQI_ANY_LOSS;
        if (cqi_simplify(p, &in->shape, &live)) {
            p->current++;
            if (p->most_loss != CQI_ANY_LOSS) p->most_loss += p->level_loss;
            cqi_progress(in, in->shape.num_vertices - live);
        } else if (p->most_loss != CQI_ANY_LOSS) {
            cqi_allow_more_loss(p);
        } else {
            break;
        }
    }
    p->num_levels = p->current - 1;
    p->collapse[p->next_collapse].level = 0; /* of no level */
}

/* Runs the decoder's steps, writing. */
static void cqi_replay(cqi_encoder *e, const cq_input *in)
{
    uint32_t n = 0;
    e->replay.cost = 4 * 8 * 65536 - cqi_log2(0xffffffffu);
    cqi_start(&e->replay);
    while (cqi_step(&e->replay) == CQ_OK)
        if (++n % 4096 == 0) cqi_progress(in, in->shape.num_vertices + e->replay.mesh.num_vertices);
#ifdef CQ_TRAINING
    cqi_model_keep(&e->replay.model);
#endif
}

static void cqi_write_uint(uint8_t **to, uint32_t value, int bytes)
{
    for (; bytes; bytes--, value >>= 8) *(*to)++ = (uint8_t)value;
}

static void cqi_write_varint(uint8_t **to, uint32_t value)
{
    for (; value >= 128; value >>= 7) *(*to)++ = (uint8_t)(value | 128);
    *(*to)++ = (uint8_t)value;
}

/* Writes a header into uint8_t[CQ_MAX_HEADER_BYTES]; returns its size. */
static size_t cqi_write_header(uint8_t *data, const cq_shape *s, size_t payload_size, uint32_t payload_crc)
{
    uint8_t *to = data;
    uint32_t k, j;
    int64_t euler = (2 * (int64_t)cqi_all_vertices(s) - (int64_t)cqi_all_faces(s)) / 4;
    cqi_write_uint(&to, 'C' | 'Q' << 8 | (uint32_t)CQ_STREAM_VERSION << 16, 3);
    cqi_write_varint(&to, s->num_vertices);
    cqi_write_varint(&to, s->num_boundary_loops);
    if (s->num_boundary_loops) cqi_write_varint(&to, s->num_boundary_edges);
    cqi_write_varint(&to, euler < 0 ? (uint32_t)(-euler * 2 - 1) : (uint32_t)(euler * 2));
    cqi_write_uint(&to, s->num_channels | s->fast << 7, 1);
    for (k = 0; k < s->num_channels; k++) {
        const cq_channel *c = &s->channel[k];
        cqi_write_uint(&to, (uint32_t)(c->kind | c->merge << 4), 1);
        cqi_write_uint(&to, c->components | (uint32_t)c->bits << 8, 2);
        cqi_write_uint(&to, c->step, 4);
        for (j = 0; j < cqi_components(c); j++) cqi_write_uint(&to, c->origin[j], 4);
    }
    cqi_write_varint(&to, (uint32_t)payload_size);
    cqi_write_uint(&to, payload_crc, 4);
    cqi_write_uint(&to, cqi_crc32(0, data, (size_t)(to - data)) & 0xffff, 2);
    return (size_t)(to - data);
}

/* Moves bytes up by less than a chunk, the last chunk first. */
static void cqi_move_up(uint8_t *data, size_t size, size_t distance)
{
    uint8_t chunk[64];
    size_t n;
    for (; size; size -= n) {
        n = size < sizeof chunk ? size : sizeof chunk;
        memcpy(chunk, data + size - n, n);
        memcpy(data + size - n + distance, chunk, n);
    }
}

/* Puts the header in front of the payload, which was written behind the shortest possible one. */
static cq_result cqi_wrap(const cq_shape *s, uint8_t *out, size_t out_size, size_t gap, size_t payload_size,
                           size_t *stream_size)
{
    uint8_t header[CQ_MAX_HEADER_BYTES];
    size_t header_size = cqi_write_header(header, s, payload_size, 0);
    if ((uint32_t)payload_size != payload_size) return CQ_ERROR_TOO_LARGE; /* unreachable: by less than 4 GiB */
    *stream_size = header_size + payload_size;
    if (*stream_size > out_size) return CQ_ERROR_OUTPUT;
    cqi_move_up(out + gap, payload_size, header_size - gap);
    cqi_write_header(header, s, payload_size, cqi_crc32(0, out + header_size, payload_size));
    memcpy(out, header, header_size);
    return CQ_OK;
}

static void cqi_write_maps(const cq_input *in, const cqi_plan *p)
{
    cq_index v, f;
    for (v = 0; in->map && v < in->shape.num_vertices; v++) in->map[v] = p->decoded[v];
    for (f = 0; in->face_map && f < in->shape.num_faces; f++) in->face_map[f] = (cq_index)(p->face_decoded[f] / 3);
}

static void cqi_report_encoding(cq_report *r, const cq_shape *s, size_t bytes)
{
    r->shape = *s;
    r->bytes = bytes;
    r->header = (uint64_t)bytes * 8 * 65536 - r->base - r->flags - r->indices - r->positions - r->channels;
}

cq_result cq_encode(cq_input *in, void *memory, size_t memory_size, uint8_t *out, size_t out_size,
                    size_t *stream_size, cq_place *place, cq_report *report)
{
    cqi_encoder *e = (cqi_encoder *)memory;
    cqi_arena arena;
    cq_result result;
    size_t gap;
    uint8_t header[CQ_MAX_HEADER_BYTES];
    if (!in || !stream_size || (out_size && !out) || in->shape.num_channels > CQ_MAX_CHANNELS || in->shape.fast > 1)
        return CQ_ERROR_ARGUMENT;
    if (place) place->face = place->vertex = place->other = CQ_NONE;
    result = cqi_check_values(in, place);
    if (result != CQ_OK) return result;
    if (!cq_encoder_bytes(&in->shape)) return CQ_ERROR_TOO_LARGE;
    if (!memory || (uintptr_t)memory % 8 || memory_size < cq_encoder_bytes(&in->shape)) return CQ_ERROR_MEMORY;
    memset(e, 0, sizeof *e);
    arena.next = (uint8_t *)memory + CQI_ENCODER_BYTES;
    arena.left = memory_size - CQI_ENCODER_BYTES;
    result = cq_mesh_build(&e->plan.mesh, &in->shape, in->indices, arena.next, arena.left, place);
    if (result != CQ_OK) return result;
    if (memory_size < cq_encoder_bytes(&in->shape)) return CQ_ERROR_MEMORY;
    arena.next += cq_mesh_bytes(&in->shape);
    arena.left -= cq_mesh_bytes(&in->shape);
    cqi_encoder_carve(e, in, &arena);
    gap = cqi_write_header(header, &in->shape, 0, 0);
    cq_range_encoder_init(&e->plan.range, out_size > gap ? out + gap : out, out_size > gap ? out_size - gap : 0);
    if (report) memset(report, 0, sizeof *report);
    e->replay.report = report;
    cqi_simplify_all(e, in);
    cqi_replay(e, in);
    result = cqi_wrap(&in->shape, out, out_size, gap, cq_range_encoder_finish(&e->plan.range), stream_size);
    if (report) cqi_report_encoding(report, &in->shape, *stream_size);
    cqi_write_maps(in, &e->plan);
    return result;
}

#endif /* CQ_NO_ENCODER */

/* -- Quantiser ----------------------------------------------------------------------------------------------------- */

#ifndef CQ_NO_QUANTISER

#define CQI_LARGEST_FLOAT 0x7f7fffffu /* its bits */

static double cqi_float(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return (double)x;
}

/* The float nearest to x, never infinite or NaN. */
static float cqi_round(double x)
{
    const double largest = cqi_float(CQI_LARGEST_FLOAT);
    return x > largest ? (float)largest : x < -largest ? (float)-largest : x == x ? (float)x : 0;
}

static uint32_t cqi_float_bits(double x)
{
    float rounded = cqi_round(x);
    uint32_t bits;
    memcpy(&bits, &rounded, sizeof bits);
    return bits;
}

static double cqi_magnitude(double x) { return x < 0 ? -x : x; }
static double cqi_larger(double a, double b) { return a > b ? a : b; }
static int cqi_is_finite(double x) { return cqi_magnitude(x) <= cqi_float(CQI_LARGEST_FLOAT); }

/* The largest integer that is not above x, |x| < 2^31. */
static int32_t cqi_floor(double x)
{
    int32_t n = (int32_t)x;
    return n - (n > x);
}

typedef struct cqi_box {
    double low[CQ_MAX_COMPONENTS], high[CQ_MAX_COMPONENTS];
    double side;          /* the longest one */
    double reach;         /* largest magnitude of a coordinate */
} cqi_box;

static cq_result cqi_find_box(cqi_box *box, const float *from, size_t count, uint32_t components, cq_place *place)
{
    size_t v;
    uint32_t c;
    memset(box, 0, sizeof *box);
    for (v = 0; v < count; v++) {
        for (c = 0; c < components; c++) {
            double x = (double)*from++;
            if (!cqi_is_finite(x)) return cqi_error(place, CQ_ERROR_VALUE, CQ_NONE, (cq_index)v, CQ_NONE);
            if (!v || x < box->low[c]) box->low[c] = x;
            if (!v || x > box->high[c]) box->high[c] = x;
            box->side = cqi_larger(box->side, box->high[c] - box->low[c]);
            box->reach = cqi_larger(box->reach, cqi_magnitude(x));
        }
    }
    return cqi_error(place, CQ_OK, CQ_NONE, CQ_NONE, CQ_NONE);
}

/* A step is longer than the distance of two floats at the end of the box. The rounding of a point to a float is then
 * less than half a step, too little for another point to be nearer. Above 22 bits a step that was rounded down to a
 * float may leave the end of the box too far from the last point. */
static uint32_t cqi_fit_step(const cqi_box *box, double last)
{
    uint32_t least, step;
    if (box->side <= 0) return 0;
    least = 1 + cqi_float_bits(box->reach - cqi_float(cqi_float_bits(box->reach) - 1));
    step = cqi_float_bits(box->side / last);
    if (step < least) step = least;
    return box->side / cqi_float(step) < last + 0.5 ? step : step + 1;
}

cq_result cq_fit_grid(cq_channel *channel, const float *from, size_t count, cq_place *place)
{
    cqi_box box;
    cq_result result;
    uint32_t c;
    if (!channel || (count && !from) || !cqi_channel_is_valid(channel) || channel->bits > CQ_MAX_BITS)
        return CQ_ERROR_ARGUMENT;
    result = cqi_find_box(&box, from, count, cqi_components(channel), place);
    if (result != CQ_OK) return result;
    for (c = 0; c < cqi_components(channel); c++) channel->origin[c] = cqi_float_bits(box.low[c]);
    channel->step = cqi_fit_step(&box, (double)(((uint32_t)1 << channel->bits) - 1));
    return channel->step <= CQI_LARGEST_FLOAT ? CQ_OK : CQ_ERROR_VALUE;
}

static int cqi_is_power_of_two(uint32_t float_bits)
{
    uint32_t exponent = float_bits >> 23, fraction = float_bits & 0x7fffff;
    return exponent ? exponent < 255 && !fraction : fraction && !(fraction & (fraction - 1));
}

/* The multiple of a power of two at x or below it. A float of 2^24 steps or more is a multiple. */
static double cqi_align(double x, double step)
{
    return cqi_magnitude(x) < step * 0x1000000 ? cqi_floor(x / step) * step : x;
}

/* Why there are no cracks: quantising finds the multiple n of step that is nearest to x, and reconstructing rounds
 * n * step, neither of which depends on the origin. For in (x - origin) / step + 1/2 rounding is an error below 2^-28,
 * and x is the middle of two multiples exactly, or further from it: middles are floats, or no float is between their
 * multiples; and the float next to a middle, which is half a step at least from 0, is 2^-25 of that away. */
cq_result cq_align_grid(cq_channel *channel, float step, const float *from, size_t count, cq_place *place)
{
    const uint32_t step_bits = cqi_float_bits((double)step);
    cqi_box box;
    double last = 0;
    cq_result result;
    uint32_t c;
    if (!channel || (count && !from) || !cqi_is_power_of_two(step_bits)) return CQ_ERROR_ARGUMENT;
    channel->bits = 1;
    if (!cqi_channel_is_valid(channel)) return CQ_ERROR_ARGUMENT;
    result = cqi_find_box(&box, from, count, cqi_components(channel), place);
    if (result != CQ_OK) return result;
    channel->step = step_bits;
    for (c = 0; c < cqi_components(channel); c++) {
        double origin = cqi_align(box.low[c], (double)step);
        if (!cqi_is_finite(origin)) return CQ_ERROR_VALUE;
        channel->origin[c] = cqi_float_bits(origin);
        last = cqi_larger(last, (box.high[c] - origin) / (double)step + 0.5);
    }
    if (last >= (double)((uint32_t)1 << CQ_MAX_BITS)) return CQ_ERROR_VALUE;
    channel->bits = (uint8_t)cqi_bit_length((uint32_t)last | 1);
    return CQ_OK;
}

/* Floats as exact values, and back. Memory from malloc takes the type of what memcpy puts there (C99 6.5, paragraph 6),
 * so that an array of floats copied as a whole would still be one of floats: each goes through a local. Only bytes are
 * copied, since a signalling NaN would not survive the registers of an x87. */
static void cqi_copy_floats(const float *from, size_t n, cq_value *to)
{
    for (; n; n--) {
        int32_t bits;
        memcpy(&bits, from++, sizeof bits);
        *to++ = (cq_value)bits;
    }
}

static void cqi_copy_values(const cq_value *from, size_t n, float *to)
{
    for (; n; n--) {
        const int32_t bits = *from++;
        float x;
        memcpy(&x, &bits, sizeof x);
        memcpy(to++, &x, sizeof x);
    }
}

cq_result cq_quantise(const cq_channel *channel, const float *from, size_t count, cq_value *to, cq_place *place)
{
    double step, end;
    size_t v;
    uint32_t c;
    if (!channel || (count && (!from || !to)) || !cqi_channel_is_valid(channel) || !cqi_fits_value(channel))
        return CQ_ERROR_ARGUMENT;
    if (cqi_is_exact(channel)) {
        cqi_copy_floats(from, count * channel->components, to);
        return cqi_error(place, CQ_OK, CQ_NONE, CQ_NONE, CQ_NONE);
    }
    step = cqi_float(channel->step);
    end = (double)((uint32_t)1 << channel->bits);
    for (v = 0; v < count; v++) {
        for (c = 0; c < cqi_components(channel); c++) {
            double offset = (double)*from++ - cqi_float(channel->origin[c]);
            double at = 0.5 + (offset == 0 ? 0 : offset / step);
            if (!(at >= 0 && at < end)) return cqi_error(place, CQ_ERROR_VALUE, CQ_NONE, (cq_index)v, CQ_NONE);
            *to++ = (cq_value)at;
        }
    }
    return cqi_error(place, CQ_OK, CQ_NONE, CQ_NONE, CQ_NONE);
}

/* The product is exact, so that it does not matter whether it is rounded before the sum. */
void cq_reconstruct(const cq_channel *channel, const cq_value *from, size_t count, float *to)
{
    CQ_ASSERT(channel->components >= 1 && channel->components <= CQ_MAX_COMPONENTS && (!count || (from && to)));
    const double step = cqi_float(channel->step);
    size_t v;
    uint32_t c;
    if (cqi_is_exact(channel)) {
        cqi_copy_values(from, count * channel->components, to);
        return;
    }
    for (v = 0; v < count; v++)
        for (c = 0; c < cqi_components(channel); c++) *to++ = cqi_round(cqi_float(channel->origin[c]) + step * *from++);
}

/* -- Octahedral normals --
 *
 * A direction, scaled to |x| + |y| + |z| = 1, is a point of an octahedron, whose lower half (z < 0) is folded up around
 * the upper one into a square: the pair is (x, y) in -1 .. 1, in units of 1 / half. The numbers along an edge of the
 * square stand for the same points on both sides of its middle; those of the right or upper side are used.
 *
 * The bound: a number is off by half a unit at most, a point of the octahedron then by sqrt(6) times that, and all of
 * its points are 1 / sqrt(3) or more from the middle, where the angle is seen: sqrt(18) / (2 half) = 2.1213 / half. */

static int32_t cqi_octahedral_half(int bits) { return (int32_t)(((uint32_t)1 << (bits - 1)) - 1); }

static void cqi_fold(double *x, double *y)
{
    double a = 1 - cqi_magnitude(*y), b = 1 - cqi_magnitude(*x);
    *x = *x < 0 ? -a : a;
    *y = *y < 0 ? -b : b;
}

/* 1 / sqrt(x) for 1/3 <= x <= 1: from 9 % off, five steps of Newton's method. */
static double cqi_reciprocal_root(double x)
{
    double y = 2 - x;
    int k;
    for (k = 0; k < 5; k++) y *= 1.5 - 0.5 * x * y * y;
    return y;
}

static int cqi_quantise_normal(int32_t half, const float *from, cq_value *to)
{
    double x = (double)from[0], y = (double)from[1], z = (double)from[2];
    double size = cqi_magnitude(x) + cqi_magnitude(y) + cqi_magnitude(z);
    int32_t a, b;
    if (!(size > 0 && cqi_is_finite(x) && cqi_is_finite(y) && cqi_is_finite(z))) return 0;
    x /= size;
    y /= size;
    if (z < 0) cqi_fold(&x, &y);
    a = cqi_floor(x * half + 0.5);
    b = cqi_floor(y * half + 0.5);
    to[0] = (cq_value)(half + (cqi_abs(b) == (uint32_t)half ? (int32_t)cqi_abs(a) : a));
    to[1] = (cq_value)(half + (cqi_abs(a) == (uint32_t)half ? (int32_t)cqi_abs(b) : b));
    return 1;
}

cq_result cq_quantise_normals(int bits, const float *from, size_t count, cq_value *to, cq_place *place)
{
    size_t v;
    if (bits < 2 || bits > CQ_MAX_BITS || (count && (!from || !to))) return CQ_ERROR_ARGUMENT;
    for (v = 0; v < count; v++)
        if (!cqi_quantise_normal(cqi_octahedral_half(bits), from + 3 * v, to + 2 * v))
            return cqi_error(place, CQ_ERROR_VALUE, CQ_NONE, (cq_index)v, CQ_NONE);
    return cqi_error(place, CQ_OK, CQ_NONE, CQ_NONE, CQ_NONE);
}

/* From -1 to 1, whatever the value. */
static double cqi_octahedral_number(int32_t half, cq_value value)
{
    const int32_t x = (int32_t)value - half;
    return (double)(x < -half ? -half : x > half ? half : x) / half;
}

void cq_reconstruct_normals(int bits, const cq_value *from, size_t count, float *to)
{
    CQ_ASSERT(bits >= 2 && bits <= CQ_MAX_BITS && (!count || (from && to)));
    const int32_t half = cqi_octahedral_half(bits);
    size_t v;
    for (v = 0; v < count; v++, from += 2, to += 3) {
        double x = cqi_octahedral_number(half, from[0]), y = cqi_octahedral_number(half, from[1]), scale;
        double z = 1 - cqi_magnitude(x) - cqi_magnitude(y);
        if (z < 0) cqi_fold(&x, &y);
        scale = cqi_reciprocal_root(x * x + y * y + z * z);
        to[0] = (float)(x * scale);
        to[1] = (float)(y * scale);
        to[2] = (float)(z * scale);
    }
}

#endif /* CQ_NO_QUANTISER */

#endif /* CONQUEST_IMPLEMENTATION */
