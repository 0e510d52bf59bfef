/* conquest.h - progressive-to-lossless triangle mesh codec in fixed memory. Version 0.2.0.
 * SPDX-License-Identifier: MIT
 *
 * A stream starts with a coarse mesh and refines it, vertex split by vertex split, to exactly the mesh that was
 * encoded. Any prefix of a stream is a valid mesh. All memory is the caller's: no allocation, no globals, no recursion,
 * integers only, nothing from libc but memcpy and memset.
 *
 * To use it, include it wherever it is needed; exactly one C or C++ file defines CONQUEST_IMPLEMENTATION first.
 *
 * This decodes a mesh of up to 10 000 vertices and 20 000 faces, closed and with positions only:
 *
 *     #define CONQUEST_IMPLEMENTATION
 *     #include "conquest.h"
 *
 *     static cq_decoder dec;                                           about 11 KB: models and an input buffer
 *     static uint32_t memory[CQ_DECODER_BYTES(10000, 20000, 3) / 4];   mesh, positions, queue
 *
 *     result = cq_decoder_init(&dec, memory, sizeof memory);
 *     while (result >= 0 && result != CQ_DONE && (n = read_some(bytes)) > 0) {
 *         cq_bytes in = { bytes, n };                                  a piece of the stream, of any size
 *         result = cq_decode(&dec, &in, CQ_NO_LIMIT);                  or at most this many steps
 *         draw(dec.index, dec.mesh.num_faces, dec.channel[0], dec.mesh.num_vertices);
 *     }
 *     if (result == CQ_NEED_INPUT) result = cq_decode(&dec, NULL, CQ_NO_LIMIT);   it was cut off: CQ_TRUNCATED
 *
 * dec.index has 3 vertex numbers per face, dec.channel[0] has 3 integers per vertex; cq_reconstruct turns these into
 * floats. To size the memory at run time, call cq_peek on the first CQ_MAX_HEADER_BYTES bytes of the stream, then
 * cq_decoder_bytes.
 *
 * Encode floats with 12 bits per coordinate:
 *
 *     cq_input in = { 0 };
 *     cq_channel *c = &in.shape.channel[0];
 *     in.shape.num_vertices = num_vertices;
 *     in.shape.num_faces = num_faces;
 *     in.shape.num_channels = 1;
 *     c->kind = CQ_POSITION;
 *     c->components = 3;
 *     c->bits = 12;
 *     result = cq_fit_grid(c, floats, num_vertices, NULL);             sets c->origin and c->step
 *     if (result == CQ_OK) result = cq_quantise(c, floats, num_vertices, values, NULL);
 *     in.indices = indices;                                            3 per face, counter-clockwise
 *     in.values[0] = values;                                           cq_value[3 * num_vertices]
 *     size = cq_encoder_bytes_at_most(&in.shape);
 *     memory = malloc(size);
 *     if (result == CQ_OK) result = cq_encode(&in, memory, size, out, out_size, &stream_size, NULL, NULL);
 *
 * examples/ has complete programs. Method: Hao, Paker, Pearmain, "Mesh Connectivity Compression for
 * Progressive-to-Lossless Transmission" ("the paper" below): levels of edge collapses inside patches that are found
 * through gates; two indices per vertex split. SPEC.md defines the bytes.
 *
 * Words
 *     patch        all triangles around one vertex, its centre
 *     gate         directed edge (L, R) on the border of a conquered patch; the next patch lies to its left
 *     front        the third vertex of the triangle to the left of a gate
 *     conquered    a vertex that already belongs to a patch of this level; until then it is available
 *     isolated     a patch whose centre is not split at this level
 *     spoke        a halfedge that starts at the centre of a patch, or at whichever vertex is looked at
 *     level        one conquest, which covers the mesh with patches that do not overlap; or one regular level
 *     regular      a level without gates: one step of subdivision, which inserts vertices into edges. The regular
 *                  levels of a stream are its finest ones
 *     A, B, p, q   a split makes vertex B, which takes some neighbours of A, the centre of a patch; p and q are the two
 *                  common neighbours of A and B
 *     split (i, j) i: steps clockwise on A's ring of neighbours from L to p; j: counter-clockwise from R to q
 *     base         the coarsest mesh, with which the stream begins
 *     row          one element of the vertex buffers. A mesh vertex has several where a seam runs through it
 *     channel      one attribute: 1 to 4 integers per vertex, face or row
 *     aside        faces and rows that are not part of the surface, and are carried beside it
 *     step         a small piece of decoding, the unit of a budget; of a channel, the distance between two values
 *
 * Threads: distinct objects are independent. A mesh belongs to one thread at a time, since even functions that take a
 * const cq_mesh write its array `mark` while they run. Objects hold pointers into the caller's memory: do not move
 * either while in use. Bytes are the same on every platform.
 *
 * Changes: CHANGELOG.md lists them by version. The license is at the end of this file. */
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

/* CQ_NO_REGULAR, defined in every file that includes the header, leaves out regular levels: 7 KB less code. Streams
 * whose header says that they may have some are then CQ_ERROR_UNSUPPORTED. It needs CQ_NO_ENCODER. */
#if (defined(CQ_NO_REGULAR) || defined(CQ_NO_ATTRIBUTES)) && defined(CONQUEST_IMPLEMENTATION) && !defined(CQ_NO_ENCODER)
#error "CQ_NO_REGULAR and CQ_NO_ATTRIBUTES need CQ_NO_ENCODER"
#endif

/* Linkage of the functions: extern by default; `#define CQ_API static inline` keeps them private to one file. */
#ifndef CQ_API
#define CQ_API extern
#endif

/* Names for the linker end in _16 with 16-bit indices, and in _nr without regular levels. Both change the layout of
 * structures: files that disagree about them do not link, and one program may have libraries of both kinds. */
#if CQ_INDEX_BITS == 16 && defined(CQ_NO_REGULAR)
#define CQI_SYMBOL(name) name##_16_nr
#elif CQ_INDEX_BITS == 16
#define CQI_SYMBOL(name) name##_16
#elif defined(CQ_NO_REGULAR)
#define CQI_SYMBOL(name) name##_nr
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
#define cq_watch_faces CQI_SYMBOL(cq_watch_faces)
#define cq_moved_rows CQI_SYMBOL(cq_moved_rows)
#define cq_read_rows CQI_SYMBOL(cq_read_rows)
#define cq_read_rows_uint16 CQI_SYMBOL(cq_read_rows_uint16)
#define cq_read_rows_uint8 CQI_SYMBOL(cq_read_rows_uint8)
#define cq_read_triangles CQI_SYMBOL(cq_read_triangles)
#define cq_material CQI_SYMBOL(cq_material)
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
#define cq_keep_lods CQI_SYMBOL(cq_keep_lods)
#define cq_encoder_bytes CQI_SYMBOL(cq_encoder_bytes)
#define cq_encoder_bytes_at_most CQI_SYMBOL(cq_encoder_bytes_at_most)
#define cq_encode CQI_SYMBOL(cq_encode)
#define cq_channel_step CQI_SYMBOL(cq_channel_step)
#define cq_channel_origin CQI_SYMBOL(cq_channel_origin)
#define cq_fit_grid CQI_SYMBOL(cq_fit_grid)
#define cq_align_grid CQI_SYMBOL(cq_align_grid)
#define cq_quantise CQI_SYMBOL(cq_quantise)
#define cq_reconstruct CQI_SYMBOL(cq_reconstruct)
#define cq_quantise_normals CQI_SYMBOL(cq_quantise_normals)
#define cq_reconstruct_normals CQI_SYMBOL(cq_reconstruct_normals)

/* Where the implementation is, these may be defined, too:
 *
 *     CQ_NO_ENCODER     no cq_encode and cq_encoder_bytes: a device that only decodes carries no byte of them
 *     CQ_NO_REPORTS     reports are not filled
 *     CQ_NO_QUANTISER   no functions that use floating point
 *     CQ_NO_WEDGES      nothing of "Rows and wedges", "Materials" and metadata: streams with them are unsupported, and
 *                       cq_encode takes oriented manifolds only
 *     CQ_NO_ATTRIBUTES  no channels but one of positions that is not exact: the smallest decoder; needs CQ_NO_ENCODER
 *     CQ_ASSERT(c)      such as assert: checks each precondition below that no result reports, and never what a
 *                       stream contains
 *     CQ_TRACE(decoder, event, a, b, c)   for those who write a decoder: a statement that is run with each event of
 *                       decoding, see cq_event; examples/cqm/trace.c prints them */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* -- Versions and limits ------------------------------------------------------------------------------------------- */

#define CQ_VERSION 200               /* of this library: 10000 * major + 100 * minor + patch */
#define CQ_VERSION_STRING "0.2.0"    /* the same for humans */
#define CQ_STREAM_VERSION 0          /* of the bitstream, SPEC.md; version 0 may still change between releases */

#define CQ_MAX_CHANNELS 16           /* channels of one stream */
#define CQ_MAX_COMPONENTS 4          /* integers per vertex of one channel */
#define CQ_EXACT_BITS 32             /* `bits` of a channel whose values are any 32-bit patterns, such as floats */
#define CQ_MAX_VALENCE 24            /* largest valence of a vertex that a split makes or takes apart; see cq_decode */
#define CQ_MAX_LEVELS 255            /* levels of one stream */
#define CQ_MAX_METADATA 0x100000     /* bytes of metadata of one stream */
#define CQ_MAX_MATERIALS 1024        /* materials of one stream */
#define CQ_MAX_HEADER_BYTES 512      /* a header is never longer */
#define CQ_NO_LIMIT 0xffffffffu      /* a budget that never runs out */

/* -- Results ------------------------------------------------------------------------------------------------------- */

/* Zero and above: the mesh is valid. Below zero: an error; what was decoded before it stays valid. */
typedef enum cq_result {
    CQ_OK = 0,                   /* done; cq_decode never returns this */
    CQ_NEED_INPUT = 1,           /* all bytes given are used, the stream goes on */
    CQ_DONE = 2,                 /* the mesh is complete: exactly the one that was encoded */
    CQ_TRUNCATED = 3,            /* the input ended early: the mesh is valid, but coarser, and stays so */
    CQ_MORE = 4,                 /* the budget is spent, and there is more to refine: call cq_decode again */
    CQ_ERROR_ARGUMENT = -1,      /* a NULL pointer or a number outside its documented range */
    CQ_ERROR_MEMORY = -2,        /* the memory handed in is too small or misaligned; the shape says what is needed */
    CQ_ERROR_OUTPUT = -3,        /* the output buffer is full */
    CQ_ERROR_TOO_LARGE = -4,     /* more vertices or faces than cq_index can number */
    CQ_ERROR_INDEX = -5,         /* mesh: a face has a vertex that does not exist */
    CQ_ERROR_FACE = -6,          /* mesh: a face has the same vertex twice */
    CQ_ERROR_EDGE = -7,          /* mesh: an edge has more than two faces */
    CQ_ERROR_ORIENTATION = -8,   /* mesh: two faces run along an edge in the same direction */
    CQ_ERROR_VERTEX = -9,        /* mesh: the faces around a vertex do not form a single fan */
    CQ_ERROR_UNUSED = -10,       /* mesh: a vertex belongs to no face */
    CQ_ERROR_VALUE = -11,        /* a channel value outside 0 .. 2^bits - 1, or a float that no value can stand for */
    CQ_ERROR_FORMAT = -12,       /* stream: not a conquest stream */
    CQ_ERROR_VERSION = -13,      /* stream: a version that this library does not know */
    CQ_ERROR_UNSUPPORTED = -14,  /* a feature that this build lacks, or values that need a build with 32-bit indices */
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

/* Where a mesh error is. Fields that do not apply to the error are CQ_NONE. */
typedef struct cq_place {
    cq_index face;        /* CQ_ERROR_INDEX, _FACE, _EDGE, _ORIENTATION: the face, in input order */
    cq_index vertex;      /* the vertex, or the edge's first vertex */
    cq_index other;       /* CQ_ERROR_EDGE, _ORIENTATION: the edge's second vertex */
} cq_place;

/* What a channel's numbers mean. Connectivity is predicted from the first channel of positions that is CQ_AVERAGE and
 * not exact; of the other kinds, some have predictions of their own. */
typedef enum cq_kind {
    CQ_POSITION = 0,      /* 3 components */
    CQ_GENERIC = 1,       /* 1 .. 4 components: anything else */
    CQ_NORMAL = 2,        /* 2 components, an octahedral pair; or 3, a vector */
    CQ_TEXCOORD = 3,      /* 2 components */
    CQ_COLOR = 4,         /* 3 components, red, green, blue; or 4, with alpha */
    CQ_JOINTS = 5,        /* 1 .. 4 components: joints of skinning, by number, */
    CQ_WEIGHTS = 6,       /* 1 .. 4 components: and their weights, in the same order */
    CQ_NUMBER = 7,        /* 1 component: the number of the vertex or face elsewhere, such as in the original file */
    CQ_GROUP = 8,         /* 1 component: the material or group that the vertex or face belongs to */
    CQ_TURNED = 9,        /* 1 component of 1 bit, CQ_PER_FACE: 1 if the mesh has the face with the opposite
                             orientation. Only cq_encode adds it: see cq_read_triangles */
    CQ_TANGENT = 10       /* 2 components, an octahedral pair; 3, with 0 or 1 for the sign of the bitangent; or 4, a
                             vector and w */
} cq_kind;

/* What the numbers of a channel belong to, and how new ones are predicted. */
typedef enum cq_merge {
    CQ_AVERAGE = 0,       /* to vertices; predicted from weighted means of neighbours */
    CQ_COPY = 1,          /* to vertices; predicted as copies of neighbours: for numbers whose mean has no meaning */
    CQ_PER_FACE = 2       /* to faces, 1 component; predicted as copies of neighbours */
} cq_merge;

/* One channel: `components` integers per vertex or face, each in 0 .. 2^bits - 1. Component k with value x stands for
 * the float origin[k] + step * x. The codec itself only carries step and origin, and any bit pattern is allowed;
 * cq_fit_grid sets them, cq_reconstruct computes the floats.
 *
 * With CQ_EXACT_BITS a value is any 32-bit pattern, copied into a cq_value, and comes back bit for bit. Patterns that
 * are floats take the fewest bytes. Needs 32-bit indices, else CQ_ERROR_UNSUPPORTED. */
typedef struct cq_channel {
    uint8_t kind;         /* cq_kind */
    uint8_t components;   /* 1 .. CQ_MAX_COMPONENTS, as many as its kind allows */
    uint8_t bits;         /* 1 .. CQ_MAX_BITS, or CQ_EXACT_BITS */
    uint8_t merge;        /* cq_merge */
    uint32_t step;                        /* distance of neighbouring values, the bits of an IEEE 754 binary32 */
    uint32_t origin[CQ_MAX_COMPONENTS];   /* what value 0 stands for, likewise */
} cq_channel;

/* Counts that decide how much memory a mesh needs, and the channels. */
typedef struct cq_shape {
    uint32_t num_vertices;           /* of the mesh; in a cq_input: rows of the vertex buffers */
    uint32_t num_faces;              /* of the mesh; in a cq_input: of the index buffer */
    uint32_t num_boundary_loops;
    uint32_t num_boundary_edges;     /* sum of the lengths of the loops */
    uint32_t num_channels;           /* 0 .. CQ_MAX_CHANNELS */
    cq_channel channel[CQ_MAX_CHANNELS];
    uint32_t num_rows;               /* rows of the mesh, see "Rows and wedges"; 0: row v is vertex v */
    uint32_t num_aside_rows, num_aside_faces;  /* rows and faces that are carried beside the mesh, see cq_aside */
    uint32_t metadata_bytes;         /* opaque bytes that travel with the mesh, 0 .. CQ_MAX_METADATA */
    uint32_t regular;                /* of a stream: 1 if it may have regular levels; ignored by cq_encode */
    uint32_t num_materials;          /* 0 .. CQ_MAX_MATERIALS, see "Materials"; 0 or 1: one range with all faces */
} cq_shape;

/* -- Rows and wedges -----------------------------------------------------------------------------------------------
 *
 * What a GPU calls a vertex is a row of its vertex buffers. Where a seam of normals or texture coordinates runs through
 * a surface, one vertex of the mesh has several rows. The faces around it that share one of them are a wedge (H. Hoppe,
 * "Efficient Implementation of Progressive Meshes", 1998):
 *
 *           \  1  |  2  /            One mesh vertex with two rows. The faces around it have its number in
 *             \   |   /              mesh.origin, which is what is refined, and one of the rows in `index`, which is
 *               \ | /                the index buffer. Corners with the same row have the same mesh vertex, and the
 *         ---- seam ----            two faces of an edge have the same two mesh vertices: so seams never open.
 *               / | \
 *             /   |   \              Per mesh vertex: positions, generic values, numbers, groups, joints and weights.
 *           /  1  |  2  \            Per row: normals, tangents, texture coordinates and colours.
 *
 * A decoded vertex never changes, and neither does a row, with one exception: if a split hands all corners of a row to
 * the new vertex, the row moves to that vertex, and takes over its values of the channels per mesh vertex.
 * cq_moved_rows tells which rows moved. With cq_input.clean none does.
 *
 * In a mesh without seams, index == mesh.origin, row v is vertex v, and none of this costs anything.
 *
 * Carried aside are faces that no surface can have, namely those with the same row or position twice, or with the same
 * three rows as another face; and rows that no face of the mesh uses. They are complete at CQ_DONE. */

/* Faces and rows aside. Rows aside are numbered after those of the mesh: row k below has the number shape.num_rows + k
 * in an index, or shape.num_vertices + k if there are no wedges. */
typedef struct cq_aside {
    uint32_t num_rows, num_faces;          /* as in the shape, or 0 before they are read */
    cq_index *index;                       /* cq_index[3 * num_faces], rows */
    cq_value *channel[CQ_MAX_CHANNELS];    /* channel k: cq_value[num_rows][components]; CQ_PER_FACE: [num_faces] */
    cq_index *material;                    /* cq_index[num_faces], or NULL without materials */
} cq_aside;

/* -- Materials -----------------------------------------------------------------------------------------------------
 *
 * The faces of each material have a range of face numbers of their own, as long as the full mesh needs. A range fills
 * from its start, so that at any moment one call draws a material, from the same vertex and index buffers:
 *
 *     index buffer   | a a a a . . | b b . . . | c c c c |      capacity 6, 5, 4; cq_material tells 4, 2, 4
 *
 * mesh.num_faces is then the sum of the capacities, and a face f that is not there yet is free: origin[3f] is CQ_NONE
 * or, while is_partial is set, a vertex that is not there yet either. No face ever changes its number.
 * Without materials all faces form one range. */

/* -- Decoder -------------------------------------------------------------------------------------------------------
 *
 * cq_decoder_init, then cq_decode with each piece of the stream. Between calls, the mesh and its values are there to be
 * drawn. To size the memory: cq_peek and cq_decoder_bytes, or the macros. */

/* A piece of input: cq_decode advances data and shrinks size by what it has used. */
typedef struct cq_bytes {
    const uint8_t *data;      /* uint8_t[size]; may be NULL if size is 0 */
    size_t size;
} cq_bytes;

/* Reads the header at the start of a stream.
 *
 * data           uint8_t[size], the first bytes of the stream: CQ_MAX_HEADER_BYTES are always enough.
 * shape          out: counts and channels.
 * header_bytes   out: length of the header; may be NULL.
 * stream_bytes   out: length of the whole stream; may be NULL.
 *
 * Returns CQ_OK, CQ_NEED_INPUT if `size` bytes are not the whole header, CQ_ERROR_ARGUMENT, _FORMAT, _VERSION,
 * _UNSUPPORTED, _TOO_LARGE, _CORRUPT or _CHECKSUM. Only with CQ_OK do the outputs mean anything. */
CQ_API cq_result cq_peek(const uint8_t *data, size_t size, cq_shape *shape, size_t *header_bytes, size_t *stream_bytes);

/* Bytes of memory for a decoder, beside sizeof(cq_decoder). v: vertices + boundary loops, f: faces + boundary edges,
 * c: components of all channels per vertex together. The macros that follow say what comes on top of that. */
#define CQ_DECODER_BYTES(v, f, c) \
    (CQ_MESH_BYTES(v, f) + CQI_ROUND(((cqi_size)(f) / 3 + 1) * sizeof(cq_index)) \
     + CQI_ROUND((cqi_size)(v) * (cqi_size)(c) * sizeof(cq_value)))

/* More for each channel CQ_PER_FACE. f: faces. */
#define CQ_FACE_BYTES(f) CQI_ROUND((cqi_size)(f) * sizeof(cq_value))

/* More for m bytes of metadata. */
#define CQ_METADATA_BYTES(m) ((m) ? CQI_ROUND((cqi_size)(m)) + 256 * sizeof(cq_bit_model) : 0)

/* More for m materials. a: faces aside. */
#define CQ_MATERIAL_BYTES(m, a) \
    ((m) ? CQI_ROUND((cqi_size)(m) * sizeof(cqi_material)) + CQI_ROUND((cqi_size)(a) * sizeof(cq_index)) : 0)

/* More with wedges. f: faces, w: rows, c: components of all channels per row together; these no longer count as
 * components per vertex. */
#define CQ_WEDGE_BYTES(f, w, c) CQI_WEDGE_BYTES(cqi_size, f, w, c)
#define CQI_WEDGE_BYTES(type, f, w, c) \
    (CQI_ROUND((type)(f) * 3 * sizeof(cq_index)) + CQI_ROUND((type)(w) * sizeof(cq_index)) \
     + CQI_ROUND((type)(w) * (c) * sizeof(cq_value)) + CQI_ROUND(sizeof(cqi_seams)))

/* More for f faces and r rows aside. c: components of all channels per vertex or row, d: channels CQ_PER_FACE. */
#define CQ_ASIDE_BYTES(f, r, c, d) CQI_ASIDE_BYTES(cqi_size, f, r, c, d)
#define CQI_ASIDE_BYTES(type, f, r, c, d) \
    (CQI_ROUND((type)(f) * 3 * sizeof(cq_index)) + CQI_ROUND((type)(r) * (c) * sizeof(cq_value)) \
     + (d) * CQI_ROUND((type)(f) * sizeof(cq_value)))

/* The sum of all of these for a shape; 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_decoder_bytes(const cq_shape *shape);

/* Its fields are at the end of this part: the mesh, its index and vertex buffers, how far it is. */
struct cq_decoder;
typedef struct cq_decoder cq_decoder;

/* Prepares a decoder; can also be called again to start over with another stream.
 *
 * memory   at least cq_decoder_bytes(shape) bytes for the shape in the header, aligned to 4; contents need not be
 *          initialised. In use as long as the decoder is. cq_decode returns CQ_ERROR_MEMORY if it turns out, once the
 *          header is read, to be too small or misaligned.
 *
 * Returns CQ_OK, or CQ_ERROR_ARGUMENT for NULL. */
CQ_API cq_result cq_decoder_init(cq_decoder *d, void *memory, size_t memory_size);

/* Decodes until the input or the budget is used up.
 *
 * in       the next piece of the stream, of any size; it is advanced past the bytes used, which need not be kept. Bytes
 *          after the end of the stream are not used. NULL: no more input will come.
 * budget   number of steps, at most. A step reads one face or vertex of the base, conquers one patch, makes one split,
 *          or prepares 1024 vertices for a level; in a regular level it looks at one face or inserts one vertex. With
 *          budget 1, each call makes at most one split. A step takes bounded time, except that it may walk around a
 *          vertex with more than CQ_MAX_VALENCE neighbours: about once a level around each of these.
 *
 * Returns CQ_MORE (budget spent), CQ_NEED_INPUT, CQ_DONE, CQ_TRUNCATED (only with in == NULL) or an error:
 * CQ_ERROR_ARGUMENT, _MEMORY, _TOO_LARGE, _FORMAT, _VERSION, _UNSUPPORTED, _CORRUPT or _CHECKSUM. All errors but
 * CQ_ERROR_ARGUMENT, and CQ_TRUNCATED, are permanent: later calls return the same. The mesh stays valid in any case.
 *
 * Before the first level begins (level 0), components arrive one after another: those with more levels first, and of
 * those with equally many the largest first. A component becomes part of the mesh when it is complete.
 *
 * Time O(bytes + steps), and once O(max vertices) for the header and O(vertices) for the base; no recursion. */
CQ_API cq_result cq_decode(cq_decoder *d, cq_bytes *in, uint32_t budget);

/* Values of rows first .. first + count - 1 of channel k as a vertex buffer has them, whether the channel is per vertex
 * or per row: cq_value[count][components]. k < shape.num_channels, first + count <= num_rows. */
CQ_API void cq_read_rows(const cq_decoder *d, uint32_t k, cq_index first, cq_index count, cq_value *to);

/* The same in less room, for a GPU: as uint16_t, of a channel of at most 16 bits, or as uint8_t, of at most 8. A row
 * begins every `stride` elements, at least as many as it has components; elements between rows are not written. Most
 * GPUs want rows of a multiple of 4 bytes, so three components take stride 4.
 *
 * `index` and `channel` can also be uploaded as they are: integers of CQ_INDEX_BITS bits. With normalised attributes,
 * which are value / 65535.0, or value / 255.0 of a uint8_t, a shader gets floats by
 *
 *     position = origin + step * 65535.0 * attribute;                    cq_channel_origin, cq_channel_step
 *
 * and the direction of an octahedral pair, in which exp2(bits - 1.0) - 1.0 stands for 0, by
 *
 *     vec2 p = attribute * 65535.0 / (exp2(bits - 1.0) - 1.0) - 1.0;
 *     vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
 *     if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
 *     normal = normalize(n); */
CQ_API void cq_read_rows_uint16(const cq_decoder *d, uint32_t k, cq_index first, cq_index count, uint16_t *to,
                                size_t stride);
CQ_API void cq_read_rows_uint8(const cq_decoder *d, uint32_t k, cq_index first, cq_index count, uint8_t *to,
                               size_t stride);

/* The index buffer of faces first .. first + count - 1 with the orientation that they had before cq_encode:
 * cq_index[3 * count]. Differs from `index` only if there is a channel CQ_TURNED. first + count <= mesh.num_faces. */
CQ_API void cq_read_triangles(const cq_decoder *d, cq_index first, cq_index count, cq_index *to);

/* The faces of material m that are there: *first .. *first + *count - 1. To draw them, draw 3 * *count indices from
 * index[3 * *first] on. Without materials, material 0 has all faces. m < shape.num_materials, or 0. */
CQ_API void cq_material(const cq_decoder *d, uint32_t m, cq_index *first, cq_index *count);

/* Has a decoder mark flips when they happen, for callers that upload in each frame: cq_mesh_changes with the same faces
 * and shift then marks only what has changed since the caller last cleared the bytes. Call it once after
 * cq_decoder_init; earlier flips are not marked.
 *
 * faces    uint8_t[blocks] as for cq_mesh_changes; in use until this is called with others, or NULL, or the decoder is
 *          done or initialised again. */
CQ_API void cq_watch_faces(cq_decoder *d, int shift, uint8_t *faces);

/* Marks the rows that have moved since there were `since_vertices` vertices and `since_rows` rows, as cq_mesh_changes
 * marks faces: uint8_t[blocks], blocks of 2^shift rows. New rows are not marked; without wedges, none are.
 * Time O(new vertices). */
CQ_API void cq_moved_rows(const cq_decoder *d, cq_index since_vertices, cq_index since_rows, int shift, uint8_t *rows);

/* -- Levels of detail -----------------------------------------------------------------------------------------------
 *
 * A vertex never changes once it is decoded, so the index buffer of any moment, with the vertex buffers of any later
 * one, is a level of detail. Index buffers that are kept while decoding goes on make a chain of levels with one set of
 * vertex buffers. A row that moves later on is drawn where it has moved to; with cq_input.clean none moves. */
typedef struct cq_lod {
    cq_index min_vertices;  /* in: keeps the first mesh with at least this many vertices (wedges: rows), and with */
    uint32_t max_error;     /* in: at most this error, as in cq_decoder; CQ_NO_LIMIT: any */
    cq_index num_vertices;  /* in: 0. out: its indices are 0 .. num_vertices - 1; 0: not kept yet */
    cq_index num_faces;     /* out */
    uint32_t error;         /* out: of this level; CQ_NO_LIMIT: not known */
    size_t first;           /* out: place of its 3 * num_faces indices in `indices`, material by material */
    cq_index *of_material;  /* in: NULL, or cq_index[num_materials]. out: faces of each */
} cq_lod;

/* Keeps the levels that are due, once the base is complete. Call it after each cq_decode: it sees no mesh between two
 * calls, so a level may have up to one vertex more than asked for per step of the budget.
 *
 * lod      cq_lod[count], the coarsest first: each is kept when it is due and those before it are kept.
 * indices  cq_index[capacity], for all levels, one after the other. Levels that are due in the same call share theirs.
 *
 * Returns how many are kept. A level for which there is no room is not, nor are those after it. Without positions
 * errors are not known, and a max_error is reached at CQ_DONE. */
CQ_API size_t cq_keep_lods(const cq_decoder *d, cq_lod *lod, size_t count, cq_index *indices, size_t capacity);

/* -- Encoder -------------------------------------------------------------------------------------------------------
 *
 * cq_encode makes a stream of triangles, in one call. */


/* How collapses are chosen; without positions, both are CQ_LEAST_CONNECTIVITY. */
typedef enum cq_goal {
    CQ_BALANCED = 0,      /* features of the surface last; else by the smallest valence, then the shortest edge */
    CQ_LEAST_CONNECTIVITY /* by valences alone */
} cq_goal;

/* What to encode, and how. Zero-initialise, then set what you need. Of `shape`, set num_vertices (rows of the vertex
 * buffers), num_faces, num_channels and channel[]; and, if you have any, metadata_bytes and num_materials. */
typedef struct cq_input {
    cq_shape shape;                        /* in and out: see cq_encode */
    const cq_index *indices;               /* cq_index[3 * num_faces], rows 0 .. num_vertices - 1 */
    const cq_value *values[CQ_MAX_CHANNELS];  /* channel k: cq_value[num_vertices][components]; CQ_PER_FACE:
                                                 [num_faces] */
    cq_goal goal;
    const uint8_t *metadata;               /* uint8_t[shape.metadata_bytes] */
    const cq_index *materials;             /* cq_index[num_faces], each < shape.num_materials; only if that is >= 2 */
    const uint8_t *locked;                 /* uint8_t[num_vertices], 1: the row is to be in the base; may be NULL */
    int clean;                             /* 1: no row ever moves, at the cost of a larger base */
    int conquest_only;                     /* 1: no regular levels, for decoders that were built with CQ_NO_REGULAR */
    cq_index *map;                         /* out: cq_index[num_vertices], the decoded row of each row; may be NULL */
    cq_index *face_map;                    /* out: cq_index[num_faces], the decoded face of each face; may be NULL */
    void (*progress)(void *user, uint32_t done, uint32_t total);  /* called now and then, done <= total; may be NULL */
    void *user;                            /* passed to progress */
} cq_input;

struct cq_report;
typedef struct cq_report cq_report; /* see "Reports" */

#ifndef CQ_NO_ENCODER

/* Bytes of memory for an encoder of a shape; 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_encoder_bytes(const cq_shape *shape);

/* Bytes that are enough for any triangles with num_vertices, num_faces and the channels of a shape, so that cq_encode
 * never returns CQ_ERROR_MEMORY; the shape's other counts are not looked at. That is room for triangles of which no two
 * share a vertex of the mesh: with two faces per row 1.3 KB per row, seven times what a closed mesh takes (with 16-bit
 * indices 0.43 KB, four times). 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_encoder_bytes_at_most(const cq_shape *shape);

/* Encodes any triangles: the rows and the index buffer of a GPU as they are. What is not an oriented manifold is made
 * one, and a decoder gets the same triangles and rows back; see "Rows and wedges" and cq_preparation. A line can be
 * carried as a face a, b, b and a point as a, a, a. Rows with the same values in all channels become one; a row where
 * the surface touches itself may become several. Without a channel of positions no rows become one.
 *
 * in       in->shape.num_boundary_loops, _edges, num_rows, num_aside_rows, _faces are set as found; begin with zeros.
 * memory   cq_encoder_bytes_at_most(&in->shape) bytes, aligned to 8. Or cq_encoder_bytes(&in->shape), which is enough
 *          for a closed mesh and much less: on CQ_ERROR_MEMORY call again with as many bytes as that returns then. With
 *          an eighth more at first, most meshes with boundaries need no second call.
 * out      uint8_t[out_size]. *stream_size is the size of the stream, also when CQ_ERROR_OUTPUT says it did not fit: a
 *          call with NULL and 0 tells it, in the time that encoding takes. No bound is promised. Random triangles with
 *          noise in all values have taken less than 4 bytes for each number there would be if no corners shared a row.
 * place    out: where CQ_ERROR_INDEX or CQ_ERROR_VALUE is; may be NULL.
 * report   out: where the bits went; may be NULL.
 *
 * Returns CQ_OK, CQ_ERROR_ARGUMENT if a channel is not as cq_channel, cq_kind and cq_merge say, CQ_ERROR_MEMORY,
 * _OUTPUT, _TOO_LARGE, _INDEX, _VALUE or _UNSUPPORTED; if built with CQ_NO_WEDGES also the errors of cq_mesh_build.
 *
 * A decoder has its own order of rows and faces, and a face may start at another corner: input row v is decoded row
 * in->map[v] (one of them, if it was copied), input face f is decoded face in->face_map[f]; or if that is
 * mesh.num_faces + k, face k aside.
 *
 * The finest levels are regular, whatever channels, seams and materials there are, if that makes the stream smaller;
 * locked vertices, edges of materials and seams stay what they are. With CQ_BALANCED, coarser meshes must also stay
 * about as near to the surface. To find out, cq_encode may encode the mesh two or three times; progress is told of the
 * first time only.
 *
 * The same input gives the same bytes on every platform and with both index widths. Time O(vertices + faces), beside
 * sorting of rows and open edges, O(n log n). */
CQ_API cq_result cq_encode(cq_input *in, void *memory, size_t memory_size, uint8_t *out, size_t out_size,
                           size_t *stream_size, cq_place *place, cq_report *report);

#endif /* CQ_NO_ENCODER */

/* -- Quantiser -----------------------------------------------------------------------------------------------------
 *
 * Floats to values and back, for callers who have no integers of their own: the only part that uses floating point. It
 * calls nothing, not even libm; CQ_NO_QUANTISER leaves it out. double must be IEEE 754 binary64.
 *
 * With -ffast-math these functions may miss a NaN or an infinity, and their results may differ from other builds in the
 * last bit. Nothing else is affected: the bytes of a stream depend on the values alone.
 *
 * The grid of a channel is the set of floats that its values stand for: origin[k] + step * q for value q of component
 * k. */

#ifndef CQ_NO_QUANTISER

/* step and origin[component] of a channel as floats: whatever is there, also an infinity or a NaN in a stream that says
 * so. component: 0 .. CQ_MAX_COMPONENTS - 1. */
CQ_API float cq_channel_step(const cq_channel *channel);
CQ_API float cq_channel_origin(const cq_channel *channel, int component);

/* Chooses the grid of a channel over the bounding box of all vertices: 2^bits points along its longest side, from its
 * minimum. The step is longer if floats in the box are further apart than these points would be, and 0 if all
 * vertices are equal. If it is not longer, and with up to 22 bits, a grid fitted to what cq_reconstruct returns gives
 * the same values.
 *
 * channel  in: components, bits. out: origin, step; the rest stays as it is.
 * from     float[count][components].
 * place    out: the first vertex with a NaN or an infinity; may be NULL.
 *
 * Returns CQ_OK, CQ_ERROR_ARGUMENT, or CQ_ERROR_VALUE: without a vertex if no float can hold the step. */
CQ_API cq_result cq_fit_grid(cq_channel *channel, const float *from, size_t count, cq_place *place);

/* The same with a given step, a power of two: origins become multiples of it, and `bits` as many as the box needs.
 * Meshes with the same step meet without cracks: equal coordinates come back equal, whatever the origins.
 * CQ_ERROR_VALUE without a vertex: the box needs more than CQ_MAX_BITS, or an origin is beyond all floats. On an error,
 * `bits` and `step` may have changed. */
CQ_API cq_result cq_align_grid(cq_channel *channel, float step, const float *from, size_t count, cq_place *place);

/* Floats to the nearest points of a channel's grid: float[count][components] to cq_value[count][components]. Returns
 * CQ_OK, CQ_ERROR_ARGUMENT, or CQ_ERROR_VALUE with the first vertex that is not finite or half a step or more off the
 * grid; place may be NULL.
 *
 * Coordinates come back with an error of at most (1/2 + 2^-26) step plus half the distance of neighbouring floats
 * there. On a grid of the two functions above, floats that have come back get the same values again, so that they come
 * back unchanged. */
CQ_API cq_result cq_quantise(const cq_channel *channel, const float *from, size_t count, cq_value *to, cq_place *place);

/* Values to the nearest floats, cq_value[count][components] to float[count][components]; never NaN or infinite,
 * whatever the channel says. With CQ_EXACT_BITS this and cq_quantise copy the floats, whatever they are. */
CQ_API void cq_reconstruct(const cq_channel *channel, const cq_value *from, size_t count, float *to);

/* Directions float[count][3], of any length but 0, to octahedral pairs cq_value[count][2] of 2 .. CQ_MAX_BITS bits, and
 * back to unit vectors. The axes come back exactly. Any other direction is turned by at most 2.122 / (2^(bits - 1) - 1)
 * radians plus the rounding of floats: 0.96 degrees with 8 bits, 0.06 with 12. With up to 22 bits, a direction that has
 * come back gets the same pair again. Results and places as with cq_quantise.
 * Source: Meyer et al., "On Floating-Point Normal Vectors", 2010. */
CQ_API cq_result cq_quantise_normals(int bits, const float *from, size_t count, cq_value *to, cq_place *place);
CQ_API void cq_reconstruct_normals(int bits, const cq_value *from, size_t count, float *to);

#endif /* CQ_NO_QUANTISER */

/* -- Mesh ----------------------------------------------------------------------------------------------------------
 *
 * Indexed halfedges. Face f owns halfedges 3f, 3f+1, 3f+2; halfedge h runs from origin[h] to origin[cq_next(h)], with
 * its face on the left (faces are counter-clockwise). `origin` is the index buffer: cq_index[3 * num_faces].
 *
 * The mesh is always closed: each boundary loop is filled by a fan of virtual faces around one virtual vertex. Virtual
 * vertices are numbered first_virtual .. first_virtual + num_virtual - 1, their faces first_virtual_face ..
 * first_virtual_face + num_virtual_faces - 1. Both come after room for all real ones, so that real vertices and faces
 * are 0 .. n-1 at every level.
 *
 * A collapse frees one vertex and two faces; free slots have out[v] == CQ_NONE, origin[3f] == CQ_NONE and are reused
 * last in, first out. A decoder never collapses: it has no free slots but those of faces of materials, which are on no
 * list.
 *
 * Invariants (cq_mesh_check): twin[twin[h]] == h != twin[h]; origin[next(twin[h])] == origin[h]; all halfedges that
 * start at a vertex form one cycle of length valence[v] >= 2 (virtual: 3) that contains out[v]; no two edges join the
 * same two vertices; no two virtual vertices share an edge or a real neighbour. */
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
    int is_partial;                                   /* 1: faces whose vertices are not there are free, too: see
                                                         "Materials" */
    cq_index flipped_from, flipped_to;                /* the new vertices of the last regular level, up to flipped_to -
                                                         1: its flips only changed faces of these; */
    cq_index flipped_before;                          /* and flipped_to of the regular level before; 0: none */
    uint8_t *watched;                                 /* blocks of faces where flips are marked; NULL: not watched; */
    int watched_shift;                                /* see cq_watch_faces */
} cq_mesh;

/* A number of bytes. Where a size_t has 16 bits, it may be more than that can hold. */
#if SIZE_MAX < 0xffffffffu
typedef uint32_t cqi_size;
#else
typedef size_t cqi_size;
#endif

/* Bytes of memory for a mesh, a multiple of 4. v: vertices + boundary loops, f: faces + boundary edges. */
#define CQ_MESH_BYTES(v, f) (CQI_ROUND(((cqi_size)(v) * 2 + (cqi_size)(f) * 6) * sizeof(cq_index) + (cqi_size)(v)))
#define CQI_ROUND(n) (((n) + 3) / 4 * 4)

/* The same for a shape; 0 if it is too large for cq_index or size_t. */
CQ_API size_t cq_mesh_bytes(const cq_shape *shape);

/* Builds a mesh from triangles.
 *
 * shape    in: num_vertices, num_faces. out: num_boundary_loops, num_boundary_edges as found (also on CQ_ERROR_MEMORY).
 * indices  cq_index[3 * num_faces], values 0 .. num_vertices - 1, counter-clockwise. Halfedge h starts at indices[h].
 * memory   cq_mesh_bytes(shape) bytes for the shape as it comes out, aligned to 4; in use as long as the mesh is. Start
 *          with loops and edges 0, which is enough for a closed mesh; on CQ_ERROR_MEMORY call again with as many bytes
 *          as cq_mesh_bytes(shape) returns then.
 * place    out: where the input is not an oriented 2-manifold; may be NULL.
 *
 * Any genus, number of components and of boundary loops. Returns CQ_OK, CQ_ERROR_MEMORY, _TOO_LARGE, _ARGUMENT or
 * the mesh errors CQ_ERROR_INDEX .. CQ_ERROR_UNUSED. Time O(vertices + faces). */
CQ_API cq_result cq_mesh_build(cq_mesh *mesh, cq_shape *shape, const cq_index *indices, void *memory,
                               size_t memory_size, cq_place *place);

/* Checks every invariant of the mesh in time O(vertices + faces), whatever its arrays and counts contain; writes mark[]
 * while it runs. Returns CQ_OK, or CQ_ERROR_INDEX, _FACE, _EDGE or _VERTEX with the place, which may be NULL. */
CQ_API cq_result cq_mesh_check(const cq_mesh *mesh, cq_place *place);

/* 1 if halfedge h can be collapsed: both ends real, the link condition holds (the ends have exactly two common
 * neighbours, each of valence 4 or more), no two boundaries touch, and the valences of both ends and of the merged
 * vertex are at most max_valence. */
CQ_API int cq_mesh_can_collapse(const cq_mesh *mesh, cq_index h, cq_index max_valence);

/* Collapses halfedge h = A -> B: B's other edges go to A; B and the two faces at h are freed.
 *
 *            p                      p          h must satisfy cq_mesh_can_collapse.
 *          / | \                    |          p = origin[prev(h)] lies to the left of A -> B.
 *        --A-h>B--       =>       --A--        Afterwards A's ring is, clockwise: p, neighbours of B, q, neighbours
 *          \ | /                    |          of A; *first is A -> p and *last is A -> q. cq_mesh_split with these
 *            q                      q          two undoes the collapse.                                              */
CQ_API void cq_mesh_collapse(cq_mesh *mesh, cq_index h, cq_index *first, cq_index *last);

/* Splits vertex A = origin[first] = origin[last], first != last: a new vertex B takes A's neighbours strictly between
 * `first` and `last`, clockwise, and the ends of `first` and `last` become neighbours of both. Undoes the last collapse
 * that has not been undone: each vertex and face gets its slot back. But a face may start at another corner, and out[]
 * be another halfedge, so that halfedges kept from before are stale: keep A and the ends of the two halfedges instead.
 * Returns B, or CQ_NONE if the mesh is full or A is virtual. */
CQ_API cq_index cq_mesh_split(cq_mesh *mesh, cq_index first, cq_index last);

/* Writes the real triangles in slot order, skipping free slots: cq_index[3 * n]. Returns n <= num_faces. */
CQ_API size_t cq_mesh_triangles(const cq_mesh *mesh, cq_index *triangles);

/* Marks the faces that a decoder has changed since its mesh had `since` vertices, so that only those are uploaded to a
 * GPU; since == 0 marks all. Vertices need no marks, as they never change: upload elements since .. num_vertices - 1 of
 * each vertex buffer, and those of each channel CQ_PER_FACE from the number of faces that there were then.
 *
 * Regular levels also flip edges between older vertices. While one is under way, all that it has changed since it began
 * is marked, unless cq_watch_faces was called with these `faces`.
 *
 * faces    uint8_t[blocks], blocks = (faces of the full mesh + 2^shift - 1) >> shift. The index buffer is divided into
 *          blocks of 2^shift faces, as a split touches about eight faces anywhere in it. The byte of a block becomes 1
 *          if a face in it is new or has a new vertex; other bytes stay as they are. With wedges the same blocks of
 *          cq_decoder.index have changed; cq_moved_rows tells which rows moved.
 * shift    0 .. CQ_INDEX_BITS - 1.
 *
 * Time O(new vertices), a few faces for each. */
CQ_API void cq_mesh_changes(const cq_mesh *mesh, cq_index since, int shift, uint8_t *faces);

/* -- Range coder ---------------------------------------------------------------------------------------------------
 *
 * Byte-wise, with a range of 32 bits and carry propagation (M. Schindler's range coder); usable alone. The encoder
 * counts bytes beyond its buffer instead of writing them. The decoder reads zeros beyond its input and counts them.
 * Both run the same models and spend the same bits. */
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

typedef uint16_t cq_bit_model;       /* probability of a 1, in 1/65536, kept in 1 .. 65534 */
#define CQ_BIT_MODEL_INIT 32768u

CQ_API void cq_range_encoder_init(cq_range_encoder *e, uint8_t *data, size_t size);
CQ_API void cq_range_decoder_init(cq_range_decoder *d, const uint8_t *data, size_t size);

/* Codes one bit, 0 or anything else, with an adaptive model like those of I. Pavlov's LZMA. Rate 1 .. 8: the
 * probability moves by 2^-rate of the way to the bit; both sides use the same rate for the same bit. */
CQ_API void cq_encode_bit(cq_range_encoder *e, cq_bit_model *model, int rate, int bit);
CQ_API int cq_decode_bit(cq_range_decoder *d, cq_bit_model *model, int rate);

/* Codes a symbol that owns slots start .. start + freq - 1 of `total`; freq > 0, total <= 2^24 (with up to 2^16,
 * rounding costs next to nothing). A decoder first asks for the slot, looks up the symbol that owns it, and then takes
 * that. */
CQ_API void cq_encode_freq(cq_range_encoder *e, uint32_t start, uint32_t freq, uint32_t total);
CQ_API uint32_t cq_decode_slot(cq_range_decoder *d, uint32_t total);
CQ_API void cq_decode_freq(cq_range_decoder *d, uint32_t start, uint32_t freq, uint32_t total);

/* Codes the low `bits` bits of a value, 0 .. 32 of them, all equally likely. */
CQ_API void cq_encode_raw(cq_range_encoder *e, uint32_t value, int bits);
CQ_API uint32_t cq_decode_raw(cq_range_decoder *d, int bits);

/* Ends the code with the fewest bytes that suffice for a decoder that reads zeros beyond them; returns e->count, the
 * number of bytes. The data is complete if that is <= size. */
CQ_API size_t cq_range_encoder_finish(cq_range_encoder *e);

/* -- Reports -------------------------------------------------------------------------------------------------------
 *
 * Encoder and decoder fill the same report, if given one. Costs are in 1/65536 bit and add up to the stream. */
typedef struct cq_level {
    uint32_t regular;                /* 1: a regular level, which has no patches and no indices */
    uint32_t num_vertices;           /* real vertices after the level is refined */
    uint32_t num_patches;            /* patches conquered */
    uint32_t num_splits;             /* of these, split; the others are isolated */
    uint32_t sum_i, sum_j;           /* sums of the two indices over all splits */
    uint32_t error;                  /* of the mesh before the level: no exact vertex is further from it, in 1/16 of the
                                        positions' step */
    uint64_t flags, indices, values; /* cost */
} cq_level;

/* What an encoder had to do to make a mesh of the triangles. Nothing is lost: a decoder gets all of them back. */
typedef struct cq_preparation {
    uint32_t degenerate_faces;       /* aside: the same row or position twice */
    uint32_t repeated_faces;         /* aside: the same rows as another face */
    uint32_t detached_faces;         /* joined to no other face, since two edges would join the same two vertices */
    uint32_t turned_faces;           /* their orientation is reversed in the mesh, to agree with their neighbours */
    uint32_t unused_rows;            /* aside: of no face */
    uint32_t merged_rows;            /* rows equal to another one, which have become that one */
    uint32_t copied_rows;            /* rows added: copies, where the surface touches itself at a vertex */
    uint32_t seam_edges;             /* joined, though their faces have different rows */
    uint32_t cut_edges;              /* not joined, though two or more faces lie there */
    uint32_t locked_vertices;        /* kept in the base because of such cuts, or because the caller asked for it */
} cq_preparation;

struct cq_report {
    cq_shape shape;
    cq_preparation prepared;         /* by an encoder */
    uint32_t num_components;
    uint32_t num_levels;
    uint32_t base_vertices, base_faces;                        /* real */
    uint64_t header, base, flags, indices, positions, channels, aside;  /* cost; their sum is 65536 * 8 * bytes */
    size_t bytes;                    /* of the stream */
    cq_level level[CQ_MAX_LEVELS];   /* coarsest first */
};

/* -- Trace ---------------------------------------------------------------------------------------------------------
 *
 * What CQ_TRACE is run with, in the words of SPEC.md. Each line below names `a`, `b`, `c`, in this order: they are of
 * type uint32_t, and 0 where nothing is named. An event comes as soon as its symbols are read, in the order of the
 * stream; none comes if bytes are missing for it. No event tells what is wrong with a stream, or anything of rows and
 * faces aside, or of metadata. */
typedef enum cq_event {
    CQ_EVENT_MATERIAL,   /* a material; its next triangle: where its range begins, or the one that is made next */
    CQ_EVENT_TRIANGLE,   /* another triangle of the base: its vertices */
    CQ_EVENT_COMPONENT,  /* has all its triangles; vertices and triangles so far; another component follows */
    CQ_EVENT_VALUES,     /* channel, number of the vertex or row; they are in decoder->channel[a] */
    CQ_EVENT_FACE,       /* channel of faces, number of the triangle, value */
    CQ_EVENT_ROW,        /* a new row; its vertex */
    CQ_EVENT_CORNER,     /* has a row that was read: vertex, row */
    CQ_EVENT_LEVEL,      /* begins: its number, is it regular, code of the error */
    CQ_EVENT_PATCH,      /* is conquered: centre; first vertex of the ring; 0 isolated, 1 split, 2 passed over */
    CQ_EVENT_SPLIT,      /* new vertex, p, q */
    CQ_EVENT_MARK,       /* regular level: new vertex, start and end of its edge */
    CQ_EVENT_PATTERN,    /* of a triangle with several marks: its number, the side of the hub or 3 */
    CQ_EVENT_DISSOLVED,  /* edge: its ends */
    CQ_EVENT_INSERTION,  /* new vertex, start and end of its edge; its values follow */
    CQ_EVENT_FLIP,       /* the ends of an edge, in any order */
    CQ_EVENT_END         /* of the stream: levels, vertices, triangles */
} cq_event;

/* -- Private types: their sizes are public, their contents are not -------------------------------------------------
 *
 * They are here so that a caller can declare a cq_decoder, which contains them. Its own fields, which follow them, are
 * interface again. */

/* Bytes of input that one step may need: 34, and 18 for each component, but 19 for a weight, and 72 for a pair that is
 * predicted from faces. At most, in bits:
 *
 *     adaptive bit        12.1    its symbol has 15/65536 or more, at the fastest rate, 4
 *     question            11.05
 *     pair that is tried   7.15
 *     residual           138.9    9 adaptive bits and 30 raw ones; if exact 36, then 144.9 of the 144 per component
 *     weight             151.0    one adaptive bit more
 *     pair               526.0    3 residuals, 7 adaptive bits, 25 raw ones
 *     copy               104.6    6 and 32          value of a face  136.6    6 and 64; the same for its material
 *     joint              132.9    9 and 24          join of the base  68.3    3 and 32
 *     split              250.7    of the 272 beside those of components: 3 flags, 16 pairs, the number of a pair (8.2)
 *                                 and 4 questions are 203.1; 61 exact components, each 0.9 over its 144, and 3 of the
 *                                 position, each 5.1 below it, 39.6; and 8 until the next byte
 *
 * In regular levels, an insertion has three residuals; the weights are 195 raw bits, and 72 more for each other
 * channel. */
#define CQI_STEP_BYTES(components) (34 + 18 * (size_t)(components))

/* The same for one channel of a row, if there are seams: two adaptive bits, and for each of 4 components 16 bits of
 * quick models, 11.05 each, and 5 and 32 raw ones: 880 of the 896 bits here. */
#define CQI_ROW_STEP_BYTES 112

/* The buffer holds input that waits for its step, or a header; it has room for the largest step. When it is full and
 * holds less than a step, what is left moves to its start; steps of most meshes are short, so that happens once for
 * many of them. The largest step has a position, a material and all other channels full of weights. If all channels are
 * full of weights, a step has no position and no questions, and takes no more: 158.9, 64 weights, 136.6 and 8, of 9968
 * bits. */
#define CQI_BUFFER_BYTES (CQI_STEP_BYTES(4) + 19 * (CQ_MAX_CHANNELS - 1) * CQ_MAX_COMPONENTS)

/* A conquest in progress. Vertices wait in a ring buffer until the gate that found them has its turn; out[v] is then
 * the halfedge from v to the L of that gate. */
typedef struct cqi_walk {
    cq_index *queue;
    cq_index capacity, head, count;
    int full;                 /* a vertex found no room */
} cqi_walk;

typedef struct cqi_vector {
    int32_t x, y, z;
#ifdef __TINYC__
    int32_t unused;           /* tcc 0.9.27 stores 16 bytes of a structure of 12 that a function returns */
#endif
} cqi_vector;

/* State of a vertex during a level, the two lowest bits of its mark. */
enum {
    CQI_FREE,             /* available */
    CQI_HELD,             /* on the ring of one patch */
    CQI_HELD_OFTEN,       /* on the rings of two or more */
    CQI_TAKEN,            /* cannot become a centre: is one, or new, or passed over, or virtual */
    CQI_STATE = 3,        /* mask of these */
    CQI_QUEUED = 4        /* bit: waits in the queue */
};

/* A patch: its centre's neighbours, clockwise from the first spoke. Offsets are positions minus that of the centre,
 * times 2^shift: so that the largest component has CQI_RING_BITS bits, but with a shift of at most CQI_FRACTION. */
#define CQI_RING_BITS 14
#define CQI_FRACTION 4
#define CQI_FAR ((int32_t)4 << CQI_RING_BITS)     /* offsets are clamped to that */
enum {
    CQI_SMALL_VALENCE = 2,                                      /* no vertex has less */
    CQI_LARGE_VALENCE = 9,                                      /* valences beside the centre are clamped to that */
    CQI_RULE_CLASSES = CQ_MAX_VALENCE + CQI_LARGE_VALENCE + 1,  /* of the valence of an alternative minus that of B */
    CQI_ANGLES = 16,                                            /* classes of angles, */
    CQI_LENGTHS = 16,                                           /* of lengths, */
    CQI_KINDS = 4 * (CQI_LARGE_VALENCE - CQI_SMALL_VALENCE + 1) /* and of valences and states */
};
typedef struct cqi_ring {
    int size;
    int boundary;                                /* place of the virtual vertex; CQ_MAX_VALENCE: there is none */
    int shift, right;                            /* 2^shift is factor / 2^right, and one of these is 1 */
    int32_t factor;
    cq_index spoke[CQ_MAX_VALENCE];
    cq_index vertex[CQ_MAX_VALENCE];             /* its end */
    cq_index front[CQ_MAX_VALENCE];              /* beyond the ring edge from this vertex to the next */
    uint8_t opposite[CQ_MAX_VALENCE];            /* class of the sum of the angles opposite to the spoke, */
    uint8_t length[CQ_MAX_VALENCE];              /* of the spoke's length, */
    uint8_t kind[CQ_MAX_VALENCE];                /* of the vertex, by its valence and state: see cqi_read_ring */
    cqi_vector at[CQ_MAX_VALENCE + 1];           /* offset of the vertex; 0 for a virtual one; */
    int32_t square[CQ_MAX_VALENCE + 1];          /* of the offset's length; after the last one, the first again */
} cqi_ring;

/* The candidates for the pair of common neighbours, p < q. The score of a pair is the sum of the scores of its parts,
 * see "The pair". */
#define CQI_PAIRS (CQ_MAX_VALENCE * (CQ_MAX_VALENCE - 1) / 2)
typedef struct cqi_choice {
    int steps;                                   /* the table of weights by q - p */
    int32_t end_p[CQ_MAX_VALENCE];               /* score of k as p, minus those of 0 .. k as neighbours of B alone */
    int32_t end_q[CQ_MAX_VALENCE];               /* score of k as q, plus those of 0 .. k - 1 likewise */
    uint8_t before[CQ_MAX_VALENCE], after[CQ_MAX_VALENCE]; /* what the rule compares: see cqi_find_alternatives */
    int32_t score[CQI_PAIRS];                    /* of each pair minus that of its q, by q, then p; CQI_TRIED */
    int32_t best[CQ_MAX_VALENCE];                /* the highest score of each q, see cqi_ranked */
} cqi_choice;

/* The outcome of predictions that compete. */
typedef struct cqi_contest {
    int32_t radius;                              /* two agree if they are less than this apart */
    cqi_vector linear;                           /* what is predicted without them */
    cqi_vector agreed;                           /* mean of those that agree with the one that most agree with */
    int question;                                /* the one about them, asked or not; -1: no predictions, so none */
} cqi_contest;

/* B's neighbours, once the pair is known: A, then p .. q, without a virtual vertex; and the vertices beyond the edges
 * of this ring: number k lies beyond the edge from k to k + 1, the last one beyond the edge back to A. */
#define CQI_FEATURES 3
#define CQI_RIVALS 16
#define CQI_SAMES 3
typedef struct cqi_fan {
    int size;
    int boundary;                                /* 1: one of B's neighbours is virtual */
    uint32_t faces;                              /* bit k: B gets one with vertices k + 1 and k */
    int above;                                   /* which component is z here; x and y follow it in a cycle */
    int32_t slope_x, slope_y;                    /* of the plane through the ring, in 1/256 */
    uint32_t known;                              /* bit k: the vertex beyond edge k is known, and near */
    cqi_vector mean;                             /* of the vertices */
    int32_t extent;                              /* their mean distance from it */
    cqi_vector linear;                           /* the linear prediction, */
    int32_t rise;                                /* and its height above the plane through the mean */
    int expected[3];                             /* sizes of the residuals, in half bits, by the shape of the fan */
    int halves;                                  /* size of the last residual of a coordinate, in half bits */
    int num_rivals;
    cqi_contest along, over;                     /* of predictions along the surface, and of planes for the height */
    int flat_sides;                              /* 1: planes compete for z */
    int same;                                    /* at most this many coordinates of neighbours are asked about, */
    int asked;                                   /* and this many were: */
    int question[CQI_SAMES];
    int32_t common[CQI_SAMES];
    int gain_same[2];                            /* saved by the first question, and by the others, in 1/64 bit */
    cqi_vector feature[CQI_FEATURES];            /* other predictions, minus the mean; */
    int32_t height[CQI_FEATURES];                /* above the plane */
    cq_index vertex[CQ_MAX_VALENCE + 1];
    cq_index beyond[CQ_MAX_VALENCE + 1];         /* CQ_NONE: a virtual one, or unknown */
    cqi_vector at[CQ_MAX_VALENCE + 1];           /* offsets of the vertices, */
    cqi_vector outer[CQ_MAX_VALENCE + 1];        /* and of those beyond */
    int32_t scratch[2][CQ_MAX_VALENCE + 1];      /* numbers for each vertex, for whichever function runs */
    cqi_vector rival[CQI_RIVALS];                /* predictions that compete */
} cqi_fan;

/* Weights of the split model: log-odds, natural, in units of 1 / CQI_NAT. Indices of tables in one array. */
#define CQI_NAT_BITS 12
#define CQI_NAT ((int32_t)1 << CQI_NAT_BITS)
enum {
    CQI_END = 0,                                             /* [angles], then [kind]: of p and q */
    CQI_BETWEEN = CQI_END + CQI_ANGLES + CQI_KINDS,          /* [angles], then [length]: of those between */
    CQI_STEPS = CQI_BETWEEN + CQI_ANGLES + CQI_LENGTHS,      /* [valence][steps] */
    CQI_GAP = CQI_STEPS + 10 * CQ_MAX_VALENCE,               /* [rank][score above the next] */
    CQI_RULE = CQI_GAP + 8 * 32,                             /* [before p, after q][class], see cqi_score_rule */
    CQI_WEIGHTS = CQI_RULE + 2 * CQI_RULE_CLASSES
};

/* Sets of models for the number of bits of a residual: by how many half bits are expected; from 10 on, by parity. */
#define CQI_EXPECTED 12

#ifdef CQ_NO_ATTRIBUTES
#define CQI_HAS_ATTRIBUTES 0
#else
#define CQI_HAS_ATTRIBUTES 1
#endif

#ifdef CQ_NO_REGULAR
#define CQI_HAS_REGULAR 0
#else
#define CQI_HAS_REGULAR 1
#endif

/* Adaptive bits. Indices of tables in one array. */
enum {
    CQI_COMPONENT = 0,                        /* base: another component follows */
    CQI_LOOP,                                 /* base: a new vertex is virtual */
    CQI_OTHER_LEVEL,                          /* a level is regular */
    CQI_BEGINS,                               /* another component takes part from this level on */
    CQI_RULED,                                /* pairs of this level are scored by the rule, too */
    CQI_ERROR,                                /* [8] the error of the mesh: how much less it is than before */
    CQI_SIDE = CQI_ERROR + 8,                 /* [2] which corner of the first gate's triangle is the first centre */
    CQI_PASSED = CQI_SIDE + 2,                /* a vertex is passed over */
    CQI_KIND_GROW,                            /* [faces at u][at w] base: the kind of a gate */
    CQI_KIND_TURN = CQI_KIND_GROW + 64,       /* [faces at u] */
    CQI_KIND_CLOSE = CQI_KIND_TURN + 8,       /* [faces at w] */
    CQI_FLAG = CQI_KIND_CLOSE + 8,            /* [available ring vertices][valence] a patch is split */
    CQI_OF_BASE = CQI_FLAG + 4 * 12,          /* residuals of base values */
    CQI_RESIDUAL_MODELS = 25 + 16 * CQI_EXPECTED,
    CQI_FIRST = CQI_OF_BASE + 41,             /* residuals of positions: first tangential component, */
    CQI_SECOND = CQI_FIRST + CQI_RESIDUAL_MODELS,
    CQI_NORMAL = CQI_SECOND + CQI_RESIDUAL_MODELS, /* the one above the surface; */
    CQI_AGREED = CQI_NORMAL + CQI_RESIDUAL_MODELS, /* along it, where predictions agree */
    CQI_SIGN_SMALL = CQI_AGREED + CQI_RESIDUAL_MODELS, /* [bits][fraction of the prediction] sign */
    CQI_OF_CONQUEST = CQI_SIGN_SMALL + 3 * 4,
    CQI_MARK = CQI_OF_CONQUEST,               /* [pair of pairs of states][length] a coarse edge gets a vertex */
    CQI_DISSOLVED = CQI_MARK + 21 * 5,        /* [marks around][shape] a coarse edge is flipped */
    CQI_SECOND_FLIP = CQI_DISSOLVED + 6 * 5,  /* [shape] and then an edge inside of one of its faces, too */
    CQI_TWO = CQI_SECOND_FLIP + 5,                  /* [shape] the diagonal of a face with two marks is flipped */
    CQI_CENTRAL = CQI_TWO + 5,                /* [before] a face with three marks has a triangle in the middle */
    CQI_SHORTEST = CQI_CENTRAL + 3,           /* else a fan around the new vertex that is nearest to the opposite
                                                 corner; */
    CQI_SHORTER,                              /* or the next one */
    CQI_NEW_ALONG,                            /* residuals of regular levels: along the surface, */
    CQI_NEW_ABOVE = CQI_NEW_ALONG + CQI_RESIDUAL_MODELS, /* and above it */
    CQI_ALL_PRIORS = CQI_NEW_ABOVE + CQI_RESIDUAL_MODELS,
    CQI_PRIORS = CQI_OF_CONQUEST + CQI_HAS_REGULAR * (CQI_ALL_PRIORS - CQI_OF_CONQUEST),
    CQI_PLAIN = CQI_PRIORS,                   /* of other channels; these begin as CQI_FIRST */
    CQI_FACE = CQI_PLAIN + CQI_RESIDUAL_MODELS, /* [values refused][faces with it] value of a face: this one */
    CQI_OTHER_JOINT = CQI_FACE + 12,          /* [values refused][neighbours with it] a joint: this one */
    CQI_TWO_ROWS = CQI_OTHER_JOINT + 4 * 6,   /* [ends with two rows] a new vertex has two if and only if an end has */
    CQI_REST = CQI_TWO_ROWS + 3,              /* [nothing is left, A ends, A goes on] a weight completes the sum */
    CQI_FOLDS_BACK = CQI_REST + 3,            /* a pair that is folded is what it was when it is folded back */
    CQI_COMMON_PAIR,                          /* [others around] a pair is the commonest one around */
    CQI_AHEAD = CQI_COMMON_PAIR + 4,          /* [by faces] a tangent is turned by 45 degrees at most, */
    CQI_BACK = CQI_AHEAD + 2,                 /* [by faces] or by 135 at least */
    CQI_SIDE_IS_BIT = CQI_BACK + 2,           /* the sign of a tangent is 0 or 1: */
    CQI_SAME_SIDE,                            /* [by faces] what is expected */
    CQI_MODELS = CQI_SAME_SIDE + 2,
    CQI_TOP = 0,                              /* tables for each kind of residual: [bits - 2] the second highest bit, */
    CQI_BITS = 25                             /* [expected][16] number of bits: fewer?, how many more, how many less */
};

/* Questions that are asked while they pay. */
enum {
    CQI_HIT = 0,                              /* [agreement][distance] B is near where predictions agree */
    CQI_SAME = CQI_HIT + 8 * 8,               /* [which][component][how many have it][distance] it is that of
                                                 neighbours */
    CQI_FLAT = CQI_SAME + CQI_SAMES * 3 * 16, /* [agreement][distance] its height is where planes agree */
    CQI_QUESTIONS = CQI_FLAT + 8 * 8
};

/* Corners of the two faces that a split makes: of A, B and p in the left one, of A, B and q in the right one. */
enum { CQI_LEFT_A, CQI_LEFT_B, CQI_AT_P, CQI_RIGHT_A, CQI_RIGHT_B, CQI_AT_Q, CQI_CORNERS };

/* Models of the rows of these corners. */
enum {
    CQI_ALL_USUAL = 0,                        /* all are the usual ones */
    CQI_USUAL = 1,                            /* [corner][what the two before are] it is the usual one */
    CQI_SECOND_CHOICE = CQI_USUAL + 4 * CQI_CORNERS, /* [corner] the other choice */
    CQI_BASE_SAME = CQI_SECOND_CHOICE + CQI_CORNERS, /* [rows of the vertex] base: the row of the corner before */
    CQI_BASE_NEW = CQI_BASE_SAME + 3,         /* [rows of the vertex] base: a new row */
    CQI_SEAM_MODELS = CQI_BASE_NEW + 3,
    CQI_SEAM_CONTEXTS = 27                    /* [A-p is a seam, no, a border][A-q][rows of A] */
};

/* A row that a split makes. */
typedef struct cqi_new_row {
    cq_index beside;                          /* the row that it is split from, or the one beyond the seam */
    int corner;                               /* its first one; CQI_CORNERS: split from a row of A */
} cqi_new_row;

/* A model that learns fast at first: a probability, and how often it was used, up to a limit. */
typedef struct cqi_quick_model {
    cq_bit_model bit;
    uint8_t used;
} cqi_quick_model;

/* Sets of models for residuals of rows, classes of what is expected, and lengths. */
enum {
    CQI_ROW_PAIR, CQI_ROW_PAIR_AT_SEAM, CQI_ROW_FITTED, CQI_ROW_AT_SEAM, CQI_ROW_TURN, CQI_ROW_TURN_BY_FACES,
    CQI_ROW_TEXTURE, CQI_ROW_TEXTURE_AT_SEAM, CQI_ROW_ROUNDING, CQI_ROW_SETS
};
#define CQI_ROW_CLASSES 20
#define CQI_ROW_LENGTHS 16

/* Models of whether a channel of a new row is equal to that of another row. */
enum {
    CQI_EQUAL_SPLIT = 0,                      /* [are the rows equal that they are split from] B's other new row */
    CQI_EQUAL_IN_FACE = 2,                    /* [is the one beside] the last row before it in its face */
    CQI_EQUAL_BESIDE = 4,                     /* [is there one in its face] the row beside */
    CQI_EQUAL_KNOWN = 6,                      /* in the base: the first known row around, */
    CQI_EQUAL_BEFORE,                         /* or the row before */
    CQI_EQUAL_NEARBY,                         /* [how many were asked about] another row of its vertex */
    CQI_EQUALS = CQI_EQUAL_NEARBY + 4
};

/* Which rows the corners have: models, and a split or a corner of the base whose rows are being read. */
#define CQI_MAX_NEW_ROWS (2 + CQI_CORNERS)
typedef struct cqi_seams {
    cq_bit_model model[CQI_SEAM_CONTEXTS][CQI_SEAM_MODELS];
    cq_bit_model equal[CQ_MAX_CHANNELS][CQI_EQUALS]; /* a channel of a new row is that of another one */
    cqi_quick_model length[CQI_ROW_SETS][CQI_ROW_CLASSES][CQI_ROW_LENGTHS]; /* residuals of rows, see
                                                                               cqi_code_row_residual */
    cq_index num_rows;                        /* also those that are not yet in the mesh */
    int full;                                 /* there were more */
    uint32_t channel;                         /* the next one of the row that is being read */
    cq_index vertex, corner, first;           /* of the base: what is read; the vertex' first row */
    int fresh;                                /* all its corners have their rows: values of new ones are being read, */
    cq_index row_of_base;                     /* now those of this one */
    int p, q;                                 /* of the split, */
    int context;
    int num_new, next;                        /* and the rows that it makes */
    cqi_new_row made[CQI_MAX_NEW_ROWS];
    cq_index run[CQ_MAX_VALENCE];             /* rows of the corners that go to B, by their spokes */
    cq_index row[CQI_CORNERS], usual[CQI_CORNERS], other[CQI_CORNERS];
    cq_index wanted[CQI_CORNERS];             /* by an encoder */
} cqi_seams;

/* The range of face numbers of a material. */
typedef struct cqi_material {
    cq_index first, count;                    /* the next face gets first + count; */
    cq_index shown;                           /* the count that cq_material tells */
    cq_index scan;                            /* base: all halfedges of the range before it are closed */
} cqi_material;

/* Everything that adapts. */
#define CQI_FAN_CLASSES 8
typedef struct cqi_model {
    int32_t worth_rivals, worth_flat, worth_same[2];         /* gain of all questions of a kind about one vertex */
    int32_t mirror;                                          /* of textures, see cqi_fit_similarity */
    int32_t trust[2];                                        /* how much nearer tangents are to what faces say than to
                                                                those around, of which there is one, or more */
    int32_t skin[2];                                         /* how far weights are from the mean of the fan: in the
                                                                same place, of the same joint; 16 times the running
                                                                mean */
    int16_t linear[2 * CQI_FAN_CLASSES * CQI_FEATURES]; /* [along the surface, above it][class of the fan][feature], */
    int16_t plain[CQ_MAX_CHANNELS][CQI_FEATURES]; /* and of other channels; see CQI_LINEAR_BITS */
    int16_t gain[CQI_QUESTIONS];                             /* by asking, in 1/1024 bit, running mean */
    cq_bit_model yes[CQI_QUESTIONS];
    int16_t weight[CQI_WEIGHTS];
    cq_bit_model bit[CQI_MODELS];
} cqi_model;

/* Running means of the residuals before, by channel and component; and of those where a connected component begins, or
 * no row around is known. */
typedef struct cqi_base_sizes {
    int32_t size[CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS], first[CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS];
} cqi_base_sizes;

/* A regular level in progress, see "Regular levels". */
enum { CQI_FIXED = 3, CQI_FINE = 8, CQI_FINE_OF_ROW = 4, CQI_MOST = 9 }; /* features of both predictions; normals have
                                                                            one more */
typedef struct cqi_regular {
    cq_index vertices, faces;              /* of the mesh before the level: with materials, all slots, and */
    cq_index real_faces;                   /* those that there are */
    cq_index count;                        /* marked edges: new vertices */
    cq_index at;                           /* the face or vertex that a phase has come to */
    cq_index record;                       /* the next face slot for a record; or how many buckets are filled */
    cq_index slot[2];                      /* of the record of the vertex at hand: left, right; CQ_NONE: no real face */
    cq_index ahead[2];                     /* straight on from both ends of the edge at hand, see cqi_straight, */
    int two_ahead[2];                      /* and whether there are two */
    cq_index own;                          /* first vertex that the face at hand has inserted, */
    uint8_t side[3];                       /* and on which of its sides; */
    cq_index dissolved;                    /* halfedge of the edge that is flipped next; CQ_NONE: of none */
    int bucket;                            /* a bucket of edges has 2^bucket halfedges */
    int axes;                              /* 0: the plane of each vertex; 1 .. 3: x, y, z is above */
    int central;                           /* what the last face with three marks had: 0, 1; 2: none was */
    uint32_t length;                       /* of marked edges, 1/16: running mean */
    uint32_t size;                         /* class of the residuals, 1/64: running mean */
    int8_t fixed[3 * CQI_FIXED], fine[3 * CQI_FINE]; /* weights: along the surface; above it; and more for the part
                                                        along the edge */
    int8_t weight[CQ_MAX_CHANNELS][CQI_MOST];        /* of other channels: of the prediction that is made next */
    uint16_t size_of[CQ_MAX_CHANNELS];               /* half bits of their residuals, 1/64: running means */
    cq_index first_row;                    /* of those that the level makes */
    uint32_t view, part;                   /* cqi_at looks at three components of this channel, from that one on; */
    int fold;                              /* 1: and folds them, as they are a pair */
} cqi_regular;

/* -- Decoder: its fields ------------------------------------------------------------------------------------------- */

/* The public fields are for reading; only `report` may be set. They are 0 or NULL until the header is read.
 * mesh.num_vertices, mesh.num_faces and num_rows grow with each split. */
struct cq_decoder {
    cq_shape shape;                        /* of the full mesh */
    cq_mesh mesh;                          /* as far as it is decoded */
    cq_index *index;                       /* cq_index[3 * mesh.num_faces], index buffer: mesh.origin, or with wedges
                                              rows */
    cq_value *channel[CQ_MAX_CHANNELS];    /* channel k, a vertex buffer: cq_value[mesh.num_vertices][components], or
                                              [num_rows], see "Rows and wedges"; with CQ_PER_FACE cq_value
                                              [mesh.num_faces], in the order of the faces in index */
    cq_index *vertex;                      /* cq_index[num_rows], the mesh vertex of each row; NULL: row v is vertex
                                              v */
    cq_index num_rows;                     /* of the mesh so far; mesh.num_vertices if vertex is NULL */
    cq_aside aside;
    uint8_t *metadata;                     /* uint8_t[shape.metadata_bytes], complete at CQ_DONE */
    uint32_t level;                        /* levels begun; level - 1 of them are complete, all at CQ_DONE */
    uint32_t error;                        /* of the mesh when the last level began: no exact vertex is further from
                                              it, in 1/16 of the positions' step. 0 at CQ_DONE, and where it is not
                                              known: before the first level, and without positions */
    uint32_t num_components;               /* connected components of the mesh so far */
    cq_report *report;                     /* in: NULL, or set after cq_decoder_init: filled while decoding */

    /* private */
    cq_result status;                      /* CQ_OK, or the permanent result */
    int phase;
    uint8_t *memory;
    size_t memory_size;
    struct cqi_plan *plan;                 /* NULL, or what the encoder chose: then this object writes */
    cqi_seams *seams;                      /* NULL without wedges */
    cqi_material *materials;               /* cqi_material[shape.num_materials], or NULL */
    cq_index new_face[2];                  /* with materials: those that a split makes, at p and at q */
    cq_bit_model *metadata_model;          /* cq_bit_model[256], see cqi_code_metadata_byte */
    uint32_t metadata_read;                /* bytes */
    struct {
        size_t payload_left, payload_size; /* bytes not yet in the buffer; of the whole payload */
        size_t step_bytes;                 /* input that one step may need */
        size_t dropped;                    /* bytes that have left the buffer */
        uint32_t crc, expected_crc;        /* of the payload: so far, and in the header */
        int ended;                         /* the caller has no more input */
    } input;
    cq_range_decoder range;
    struct {
        cq_mesh draft;                     /* the mesh, and the component that is being read */
        cq_index gate, before, before2;    /* the border halfedge to grow at, and the two before it */
        cq_index scan, virtual_scan;       /* all halfedges before these are closed */
        cq_index value;                    /* next vertex, then next face, of the component to get its values */
        cq_index faces, shown;             /* real ones; of these, those of complete components */
        cq_index last_face;                /* real one that was added last, or CQ_NONE; */
        cq_index valued_face;              /* and that got its values last */
        uint32_t material;                 /* the next one whose number of faces is read */
        cq_index vertices;                 /* of the base */
        int more;                          /* another component follows */
    } base;
    int located;                           /* channel of positions that the connectivity is predicted from, or -1 */
    int ruled;                             /* 1: pairs are scored by the rule, too: see cqi_score_rule */
    int rate;                              /* of adaptation of the bit models */
    uint32_t error_code;                   /* `error` as the stream has it */
    cq_index splits;                       /* patches of this level that are split */
    cq_index active;                       /* base vertices of the components that take part in the level */
    cq_index seed;                         /* base vertices before it: their components had their first patch */
    cq_index cleared;                      /* vertices that are ready for the level */
    cqi_walk walk;
    cqi_regular regular;
    cqi_ring ring;
    union {
        cqi_base_sizes base;               /* while the base is read, and what is aside; */
        cqi_choice choice;                 /* while the pair is coded; */
        cqi_fan fan;                       /* then, while values are */
    } now;
    uint64_t cost;                         /* where the last report entry ended */
    cqi_model model;
    uint8_t buffer[CQI_BUFFER_BYTES];      /* the largest arrays come last, which makes code shorter */
};

#ifdef __cplusplus
}
#endif

/* -- Mesh: circulators, around the face of a halfedge and around its origin ---------------------------------------- */

static inline cq_index cq_next(cq_index h) { return (cq_index)(h % 3 == 2 ? h - 2 : h + 1); }
static inline cq_index cq_prev(cq_index h) { return (cq_index)(h % 3 == 0 ? h + 2 : h - 1); }
static inline cq_index cq_target(const cq_mesh *m, cq_index h) { return m->origin[cq_next(h)]; }
static inline cq_index cq_clockwise(const cq_mesh *m, cq_index h) { return cq_next(m->twin[h]); }
static inline cq_index cq_counterclockwise(const cq_mesh *m, cq_index h) { return m->twin[cq_prev(h)]; }
static inline int cq_is_virtual(const cq_mesh *m, cq_index v) { return v >= m->first_virtual; }

#endif /* CQ_CONQUEST_H */

/* Stop here if you only need the interface. Below is the implementation; each part only uses those before it:
 *
 *     memory; mesh                       the caller's block; halfedges: build, check, collapse, split, flip
 *     range coder; header                bytes of a stream
 *     coding, plan, symbols, priors      what both directions share, and where they differ
 *     base; values; positions            the coarsest mesh; numbers of new vertices and faces
 *     conquest, pair, patches; rows      where a level splits, and how; seams
 *     regular levels                     insertions into edges, and flips
 *     steps; decoder; levels of detail   what a call of cq_decode does
 *     encoder                            collapses, their errors, and how far a level is from the exact surface;
 *                                        preparation: triangles become a manifold;
 *                                        labels of regular levels;
 *                                        the passes of cq_encode
 *     quantiser                          floats to values and back */
#if defined(CONQUEST_IMPLEMENTATION) && !defined(CONQUEST_IMPLEMENTATION_DONE)
#define CONQUEST_IMPLEMENTATION_DONE /* a guard of its own: the interface may have been included before */

#include <string.h> /* memcpy, memset */

/* Asserts state what the caller got wrong, never what a stream contains. */
#ifndef CQ_ASSERT
#define CQ_ASSERT(condition) ((void)0)
#endif

/* Does the processor have vectors of 16-bit numbers? Results are the same with and without. */
#if defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__)
#define CQI_VECTORS 1
#else
#define CQI_VECTORS 0
#endif

/* For functions whose variables should not take stack while their caller calls others. */
#ifdef __GNUC__
#define CQI_APART __attribute__((noinline))
#else
#define CQI_APART
#endif

/* Prefetches memory that will be read soon; makes no difference to the result. Functions that do nothing else must be
 * inlined: gcc takes them for functions without effect, and removes the calls. */
#if defined(__GNUC__) && __SIZEOF_POINTER__ == 8
#define CQI_SOON(address) __builtin_prefetch(address)
#define CQI_INLINED inline __attribute__((always_inline))
#else
#define CQI_SOON(address) ((void)(address))
#define CQI_INLINED inline
#endif
#define CQI_FETCH_AHEAD 16 /* how far ahead, in patches: about the time that memory takes */
#define CQI_MANY 128       /* with this many patches or more, memory does not stay in the nearest cache */

static int cqi_at_most(int x, int limit) { return x < limit ? x : limit; }

/* The one after k and the one before it, of n in a circle. */
static inline int cqi_next_of(int k, int n) { return k == n - 1 ? 0 : k + 1; }
static inline int cqi_previous_of(int k, int n) { return k ? k - 1 : n - 1; }

/* Half of an octahedral pair's range: numbers are 0 .. 2 half, and half stands for 0, see the quantiser. */
static inline int32_t cqi_octahedral_half(int bits) { return (int32_t)(((uint32_t)1 << (bits - 1)) - 1); }

static uint32_t cqi_abs(int32_t x) { return x < 0 ? (uint32_t)0 - (uint32_t)x : (uint32_t)x; }

/* x, or -x if `negative` is 1; without a branch, as the processor cannot predict signs of residuals. */
static inline uint32_t cqi_negated(uint32_t x, int negative)
{
    return (x ^ ((uint32_t)0 - (uint32_t)negative)) + (uint32_t)negative;
}

/* x without its sign bit: x, or -1 - x if x is negative. */
static inline uint32_t cqi_fold_sign(int32_t x) { return x < 0 ? ~(uint32_t)x : (uint32_t)x; }

/* Sums and differences modulo 2^32: exact values may overflow, all others are far too small. */
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

static int cqi_bit_length_wide(uint64_t x)
{
#if defined(__GNUC__) && __SIZEOF_LONG__ == 8
    return x ? 64 - __builtin_clzl(x) : 0;
#else
    const uint32_t high = (uint32_t)(x >> 32);
    return high ? 32 + cqi_bit_length(high) : cqi_bit_length((uint32_t)x);
#endif
}

/* x / 2^bits, rounded down. C leaves open what >> does to negative numbers: used where it is an arithmetic shift. */
#define CQI_SHIFTS_SIGNS ((-1 >> 1) == -1)
static inline int32_t cqi_floor_shift(int32_t x, int bits)
{
    return CQI_SHIFTS_SIGNS || x >= 0 ? x >> bits : ~(~x >> bits); /* unreachable: where >> keeps signs */
}

static inline int64_t cqi_floor_shift_wide(int64_t x, int bits)
{
    return CQI_SHIFTS_SIGNS || x >= 0 ? x >> bits : ~(~x >> bits); /* unreachable: where >> keeps signs */
}

const char *cq_result_string(cq_result result)
{
    switch (result) {
    case CQ_OK: return "ok";
    case CQ_NEED_INPUT: return "more input needed";
    case CQ_DONE: return "complete";
    case CQ_TRUNCATED: return "the input ends early";
    case CQ_MORE: return "more to decode";
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

/* -- Memory: how the caller's block is divided --------------------------------------------------------------------- */

typedef struct cqi_arena {
    uint8_t *next;
    size_t left;
} cqi_arena;

/* Takes the next `count` elements of `size` bytes, which the caller knows to fit. Blocks start at multiples of 4. */
static void *cqi_take(cqi_arena *arena, size_t count, size_t size)
{
    uint8_t *block = arena->next;
    size_t bytes = CQI_ROUND(count * size);
    CQ_ASSERT(bytes <= arena->left);
    arena->next += bytes;
    arena->left -= bytes;
    return block;
}

/* Is memory aligned as the compiler aligns static uint32_t memory[]: to 4, but to 1 on AVR? */
struct cqi_alignment { char before; uint32_t word; };
static int cqi_aligned(const void *memory) { return (uintptr_t)memory % offsetof(struct cqi_alignment, word) == 0; }

/* Counts that include virtual vertices and faces. In an encoder's shape num_vertices counts rows, so that the sum may
 * need more than 32 bits. */
static cqi_size cqi_all_vertices(const cq_shape *s) { return (cqi_size)s->num_vertices + s->num_boundary_loops; }
static uint32_t cqi_all_faces(const cq_shape *s) { return s->num_faces + s->num_boundary_edges; }

/* The channel of positions that connectivity is predicted from, or -1. */
static int cqi_context_channel(const cq_shape *s)
{
    uint32_t k;
    for (k = 0; k < s->num_channels; k++)
        if (s->channel[k].kind == CQ_POSITION && s->channel[k].merge == CQ_AVERAGE && s->channel[k].bits <= 24)
            return (int)k;
    return -1;
}

#if !defined(CQ_NO_ENCODER) || !defined(CQ_NO_QUANTISER)
/* Components of a channel, for loops over an array of CQ_MAX_COMPONENTS elements: their bound must be one that the
 * compiler sees. From `components` alone, LLVM 15 to 19 (-O3 -flto, AVX) also make a vectorised copy of the loop, which
 * reads 8 elements and never runs, and conclude that the elements read by the other copy are undefined (llvm-project,
 * issue 107996). */
static uint32_t cqi_components(const cq_channel *c)
{
    return c->components < CQ_MAX_COMPONENTS ? c->components : CQ_MAX_COMPONENTS;
}
#endif

/* What the numbers of a channel belong to: the class of the channel. */
enum { CQI_OF_VERTEX, CQI_OF_FACE, CQI_OF_ROW };

static int cqi_is_of_corner(int kind)
{
    return kind == CQ_NORMAL || kind == CQ_TEXCOORD || kind == CQ_COLOR || kind == CQ_TANGENT;
}

static int cqi_class(const cq_shape *s, uint32_t k)
{
    const int kind = s->channel[k].kind;
    if (s->channel[k].merge == CQ_PER_FACE) return CQI_OF_FACE;
    return s->num_rows && cqi_is_of_corner(kind) ? CQI_OF_ROW : CQI_OF_VERTEX;
}

/* Components of all channels per vertex, per face or per row together. */
static uint32_t cqi_all_components(const cq_shape *s, int of)
{
    uint32_t k, n = 0;
    for (k = 0; k < s->num_channels; k++)
        if (cqi_class(s, k) == of) n += s->channel[k].components;
    return n;
}

/* A size, or 0 if size_t has too few bits. */
static size_t cqi_bytes(cqi_size n) { return (size_t)n == n ? (size_t)n : 0; } /* unreachable: size_t of 16 bits */

/* A shape is countable if cq_index can number its halfedges and rows, size_t can hold the size of its mesh, and no
 * cqi_size below overflows: an encoder needs at most 121 bytes for each of CQI_MAX_HALFEDGES halfedges. */
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
    if (cqi_bytes(bytes) != bytes) return 0; /* unreachable: size_t of 64 bits */
    return s->num_channels <= CQ_MAX_CHANNELS && s->num_rows <= CQI_MAX_HALFEDGES &&
           s->num_aside_rows <= CQI_MAX_HALFEDGES - (s->num_rows ? s->num_rows : s->num_vertices) &&
           s->num_aside_faces <= limit && s->num_materials <= CQ_MAX_MATERIALS;
}

size_t cq_mesh_bytes(const cq_shape *s)
{
    if (!s || !cqi_countable(s)) return 0;
    return cqi_bytes(CQ_MESH_BYTES(cqi_all_vertices(s), cqi_all_faces(s)));
}

/* Lays out a mesh without vertices and faces. Its blocks add up to CQ_MESH_BYTES, as only the last one needs rounding:
 * the 6f + 2v indices before it are an even number of 16-bit words. */
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
    m->flipped_from = m->flipped_to = m->flipped_before = 0;
    m->is_partial = 0;
}

/* -- Mesh: building ------------------------------------------------------------------------------------------------
 *
 * Finds twins by sorting halfedges, fills boundary loops, and checks that each vertex has one fan of faces. */

static cq_result cqi_error(cq_place *place, cq_result result, cq_index face, cq_index vertex, cq_index other)
{
    if (place) {
        place->face = face;
        place->vertex = vertex;
        place->other = other;
    }
    return result;
}

/* Does every face have three different vertices, all of which exist? */
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

static void cqi_set_twins(cq_mesh *m, cq_index g, cq_index h)
{
    m->twin[g] = h;
    m->twin[h] = g;
}

/* The smaller ends of a face's edges. */
static void cqi_smaller_ends(const cq_index *corner, cq_index *end)
{
    const cq_index a = corner[0], b = corner[1], c = corner[2];
    end[0] = a < b ? a : b;
    end[1] = b < c ? b : c;
    end[2] = c < a ? c : a;
}

/* Turns counts of keys into the place where each key begins. */
static void cqi_sum_counts(cq_index *count, cq_index n)
{
    cq_index k, sum = 0;
    for (k = 0; k < n; k++) {
        const cq_index here = count[k];
        count[k] = sum;
        sum = (cq_index)(sum + here);
    }
}

/* Sorts the halfedges by their smaller end, stably. On return first[v] is the place after the last halfedge of v. */
static void cqi_sort_halfedges(const cq_index *indices, const cq_shape *s, cq_index *sorted, cq_index *first)
{
    const cq_index n = (cq_index)(3 * s->num_faces);
    cq_index k, j, end[3];
    memset(first, 0, s->num_vertices * sizeof(cq_index));
    for (k = 0; k < n; k = (cq_index)(k + 3)) {
        cqi_smaller_ends(indices + k, end);
        for (j = 0; j < 3; j++) first[end[j]]++;
    }
    cqi_sum_counts(first, (cq_index)s->num_vertices);
    for (k = 0; k < n; k = (cq_index)(k + 3)) {
        cqi_smaller_ends(indices + k, end);
        for (j = 0; j < 3; j++) sorted[first[end[j]]++] = (cq_index)(k + j);
    }
}

/* Pairs halfedge g with another one of the same edge. */
static cq_result cqi_match_twin(cq_mesh *m, const cq_index *indices, cq_index g, cq_index h)
{
    if (m->twin[h] != CQ_NONE) return CQ_ERROR_EDGE;
    cqi_set_twins(m, g, h);
    return indices[g] == indices[h] ? CQ_ERROR_ORIENTATION : CQ_OK;
}

/* Finds all twins; twin[h] is CQ_NONE on a boundary. Takes linear time for any input: halfedges are visited in the
 * order of their smaller ends, and valence[v] is the place in it of the last one so far that has v as its larger end.
 * That one is of the same edge if its place is not before the first one of this smaller end. origin and out are
 * scratch, too; in the end origin = indices. Of the errors it reports, in this order, the first edge with three faces;
 * if there is none, the first one along which two faces run in the same direction. */
static cq_result cqi_match_twins(cq_mesh *m, const cq_index *indices, const cq_shape *s, cq_place *place)
{
    const cq_index n = (cq_index)(3 * s->num_faces);
    cq_result result = CQ_OK;
    cq_index k, smaller = CQ_NONE, first = 0;
    cqi_sort_halfedges(indices, s, m->origin, m->out);
    memset(m->valence, 0xff, s->num_vertices * sizeof(cq_index));
    for (k = 0; k < n && result != CQ_ERROR_EDGE; k++) {
        const cq_index g = m->origin[k], a = indices[g], b = indices[cq_next(g)];
        cq_index *const of_larger = &m->valence[a < b ? b : a], last = *of_larger;
        cq_result found;
        if (smaller != (a < b ? a : b)) {
            smaller = a < b ? a : b;
            first = k;
        }
        *of_larger = k;
        m->twin[g] = CQ_NONE;
        if (last == CQ_NONE || last < first) continue;
        found = cqi_match_twin(m, indices, g, m->origin[last]);
        if (found == CQ_ERROR_EDGE || (found != CQ_OK && result == CQ_OK))
            result = cqi_error(place, found, (cq_index)(g / 3), a, b);
    }
    if (n) memcpy(m->origin, indices, n * sizeof(cq_index));
    return result;
}

/* Sets out[v] to the one boundary halfedge that starts at v, or to CQ_NONE, and counts boundary edges. */
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

/* Counts boundary loops. Every walk closes, since as many boundary halfedges enter a vertex as leave it, and
 * cqi_find_boundary allows one. */
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

/* Fills the boundary loop that leaves v with a fan around a virtual vertex w: each boundary halfedge a -> b gets a face
 * b, a, w. */
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
        cqi_set_twins(m, g, h);
        if (before == CQ_NONE) first = g;
        else cqi_set_twins(m, (cq_index)(before + 2), (cq_index)(g + 1)); /* w -> a and a -> w */
        before = g;
        h = m->out[b];
    }
    last = (cq_index)(before + 2);
    cqi_set_twins(m, last, (cq_index)(first + 1));
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

/* Do the halfedges around v form one cycle of valence[v], the number of all that start at v? */
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

/* Lays out the mesh, finds twins and boundaries, and completes the shape; boundary loops are still open. */
static cq_result cqi_build_open(cq_mesh *m, cq_shape *s, const cq_index *indices, void *memory, size_t size,
                                cq_place *place)
{
    cqi_arena arena;
    cq_result r;
    arena.next = (uint8_t *)memory;
    arena.left = size;
    if (!memory || !cqi_aligned(memory) || size < cq_mesh_bytes(s)) return CQ_ERROR_MEMORY;
    cqi_mesh_carve(m, s, &arena);
    m->watched = NULL;
    r = cqi_match_twins(m, indices, s, place);
    if (r == CQ_OK) r = cqi_find_boundary(m, s, place);
    if (r == CQ_OK) cqi_count_loops(m, s);
    return r;
}

/* Lays the mesh out again, with room for its virtual vertices and faces. twin and out move up, and the latter first, as
 * the blocks may overlap. */
static cq_result cqi_make_room(cq_mesh *m, const cq_shape *s, void *memory, size_t size)
{
    const cq_index *const twin = m->twin, *const out = m->out;
    cqi_arena arena;
    cq_index k;
    arena.next = (uint8_t *)memory;
    arena.left = size;
    if (!cqi_countable(s)) return CQ_ERROR_TOO_LARGE;
    if (size < cq_mesh_bytes(s)) return CQ_ERROR_MEMORY;
    cqi_mesh_carve(m, s, &arena);
    for (k = (cq_index)s->num_vertices; k--;) m->out[k] = out[k];
    for (k = (cq_index)(3 * s->num_faces); k--;) m->twin[k] = twin[k];
    return CQ_OK;
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
    if (r == CQ_OK && s->num_boundary_edges) r = cqi_make_room(m, s, memory, size);
    if (r != CQ_OK) return r;
    m->num_vertices = (cq_index)s->num_vertices;
    m->num_faces = (cq_index)s->num_faces;
    cqi_close_loops(m);
    memset(m->valence, 0, cqi_all_vertices(s) * sizeof(cq_index));
    cqi_count_valences(m, 0, m->num_faces);
    cqi_count_valences(m, m->first_virtual_face, m->num_virtual_faces);
    return cqi_check_fans(m, place);
}

/* -- Mesh: checking ------------------------------------------------------------------------------------------------
 *
 * For cq_mesh_check, and for each component of a base that was decoded. */

#define CQI_SCRATCH 0x80 /* bit of mark[v], for the mesh operations, which clear it again */

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
    return cqi_in_range(f, m->num_faces, m->first_virtual_face, m->num_virtual_faces) && m->origin[3 * f] != CQ_NONE &&
           !(m->is_partial && !cqi_is_vertex(m, m->origin[3 * f]));
}

/* Is h a halfedge of a real face? */
static inline int cqi_is_real_face(const cq_mesh *m, cq_index h) { return h < 3 * m->first_virtual_face; }

/* Number of virtual corners of a face. */
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

/* Is a real vertex next to at most one virtual vertex, and a virtual one to none? */
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

/* Checks vertices v .. num_vertices - 1, faces f .. num_faces - 1, and virtual ones from vv and vf on. `corners`: the
 * number of corners of other faces at these vertices. */
static cq_result cqi_check_from(const cq_mesh *m, cq_index v, cq_index f, cq_index vv, cq_index vf, cq_index corners,
                                cq_place *place)
{
    const cq_index faces = (cq_index)(m->num_faces - f), virtual_faces = (cq_index)(m->num_virtual_faces - vf);
    const cq_index first_virtual_face = (cq_index)(m->first_virtual_face + vf);
    cq_index in_fans = 0;
    cq_result r = cqi_check_halfedges(m, f, faces, place);
    if (r == CQ_OK) r = cqi_check_halfedges(m, first_virtual_face, virtual_faces, place);
    if (r == CQ_OK) r = cqi_check_vertices(m, v, (cq_index)(m->num_vertices - v), &in_fans, place);
    if (r == CQ_OK)
        r = cqi_check_vertices(m, (cq_index)(m->first_virtual + vv), (cq_index)(m->num_virtual - vv), &in_fans, place);
    if (r != CQ_OK) return r;
    corners = (cq_index)(corners + cqi_count_corners(m, f, faces));
    corners = (cq_index)(corners + cqi_count_corners(m, first_virtual_face, virtual_faces));
    return in_fans == corners ? CQ_OK : cqi_error(place, CQ_ERROR_VERTEX, CQ_NONE, CQ_NONE, CQ_NONE);
}

cq_result cq_mesh_check(const cq_mesh *m, cq_place *place)
{
    cq_result r = cqi_error(place, cqi_counts_fit(m) ? CQ_OK : CQ_ERROR_INDEX, CQ_NONE, CQ_NONE, CQ_NONE);
    return r == CQ_OK ? cqi_check_from(m, 0, 0, 0, 0, 0, place) : r;
}

/* -- Mesh: collapse and split --------------------------------------------------------------------------------------
 *
 * Encoders do both; decoders only split. */

/* May A -> B be collapsed, as far as valences tell? Those of the common neighbours p and q must stay 3 or more. */
static int cqi_keeps_valences(const cq_mesh *m, cq_index h, cq_index max_valence)
{
    const cq_index a = m->origin[h], b = cq_target(m, h);
    const cq_index p = m->origin[cq_prev(h)], q = m->origin[cq_prev(m->twin[h])];
    if (cq_is_virtual(m, a) || cq_is_virtual(m, b) || p == q) return 0;
    if (m->valence[p] < 4 || m->valence[q] < 4) return 0;
    if (m->valence[a] > max_valence || m->valence[b] > max_valence) return 0;
    return m->valence[a] + m->valence[b] - 4 <= max_valence;
}

/* May A -> B be collapsed, given that A's neighbours carry the scratch mark, and whether one of them is virtual? The
 * only common neighbours of A and B must be p and q. If both ends are on a boundary, so must the edge be: else two
 * loops would touch, or two places of one. */
static int cqi_collapsible(const cq_mesh *m, cq_index h, cq_index max_valence, int boundary)
{
    const cq_index g = m->twin[h], p = m->origin[cq_prev(h)], q = m->origin[cq_prev(g)];
    cq_index s = g, common = 0;
    int b_boundary = 0;
    if (!cqi_keeps_valences(m, h, max_valence)) return 0;
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
    if (!m->num_virtual) return 0;
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

/* Is there room for a vertex and the faces of a split with common neighbours p and q, at most one of them virtual? */
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
    cqi_set_twins(m, to_p, from_p);
    cqi_set_twins(m, to_q, from_q);
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
    for (s = cq_clockwise(m, first);; s = cq_clockwise(m, s)) { /* B takes the spokes after first up to last */
        m->origin[s] = b;
        moved++;
        if (s == last) break;
    }
    cqi_set_face(m, f, p, a, b); /* p -> A, A -> B, B -> p */
    cqi_set_face(m, g, a, q, b); /* A -> q, q -> B, B -> A */
    cqi_set_twins(m, (cq_index)(3 * f), first);
    cqi_set_twins(m, (cq_index)(3 * f + 2), from_p);
    cqi_set_twins(m, (cq_index)(3 * g), from_q);
    cqi_set_twins(m, (cq_index)(3 * g + 1), last);
    cqi_set_twins(m, (cq_index)(3 * f + 1), (cq_index)(3 * g + 2));
    m->valence[b] = (cq_index)(moved + 2);
    m->valence[a] = (cq_index)(m->valence[a] - moved + 2);
    m->valence[p]++;
    m->valence[q]++;
    m->out[a] = first;
    m->out[b] = last;
    return b;
}

#ifndef CQ_NO_REGULAR

/* -- Mesh: flip ----------------------------------------------------------------------------------------------------
 *
 * Regular levels also flip edges. A flip keeps all slots, so that it needs no room. */

/* Does an edge join v and w? Walks around the one with fewer neighbours. */
static int cqi_joined(const cq_mesh *m, cq_index v, cq_index w)
{
    const cq_index around = m->valence[v] < m->valence[w] ? v : w, wanted = around == v ? w : v;
    cq_index h = m->out[around];
    do {
        if (cq_target(m, h) == wanted) return 1;
        h = cq_clockwise(m, h);
    } while (h != m->out[around]);
    return 0;
}

/* 1 if the edge of h can be flipped, to join the two vertices opposite to it: all four are real, the ends keep a
 * valence of 3 or more, and no edge joins the opposite vertices yet. */
static int cqi_can_flip(const cq_mesh *m, cq_index h)
{
    const cq_index g = m->twin[h], a = m->origin[h], b = m->origin[g];
    const cq_index x = m->origin[cq_prev(h)], y = m->origin[cq_prev(g)];
    if (cq_is_virtual(m, a) || cq_is_virtual(m, b) || cq_is_virtual(m, x) || cq_is_virtual(m, y)) return 0;
    return m->valence[a] > 3 && m->valence[b] > 3 &&
           x != y && /* unreachable: two edges would join a and x, or a has two neighbours only */
           !cqi_joined(m, x, y);
}

/* Flips the edge a -> b of halfedge h.
 *
 *            x                      x          h must satisfy cqi_can_flip.
 *          /   \                  / | \        Both faces keep their slots: that of h is now y, x, a, with h = y -> x,
 *        a--h-->b      =>        a  h  b       that of its twin x, y, b.
 *          \   /                  \ | /
 *            y                      y                                                                         */
static void cqi_flip(cq_mesh *m, cq_index h)
{
    CQ_ASSERT(cqi_can_flip(m, h));
    const cq_index g = m->twin[h], hn = cq_next(h), hp = cq_prev(h), gn = cq_next(g), gp = cq_prev(g);
    const cq_index a = m->origin[h], b = m->origin[g], x = m->origin[hp], y = m->origin[gp];
    const cq_index a_to_x = m->twin[hp], x_to_b = m->twin[hn], b_to_y = m->twin[gp], y_to_a = m->twin[gn];
    m->origin[h] = m->origin[gn] = y;
    m->origin[g] = m->origin[hn] = x;
    m->origin[hp] = a;
    m->origin[gp] = b;
    cqi_set_twins(m, hn, a_to_x);
    cqi_set_twins(m, hp, y_to_a);
    cqi_set_twins(m, gn, b_to_y);
    cqi_set_twins(m, gp, x_to_b);
    m->out[a] = hp;
    m->out[b] = gp;
    m->out[x] = hn;
    m->out[y] = gn;
    m->valence[a]--;
    m->valence[b]--;
    m->valence[x]++;
    m->valence[y]++;
    if (m->watched) m->watched[h / 3 >> m->watched_shift] = m->watched[g / 3 >> m->watched_shift] = 1;
}

#endif /* CQ_NO_REGULAR */

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

/* All faces that changed since there were `since` vertices have a vertex whose number is the result or higher. A split
 * moves halfedges to its new vertex B, and these leave B only for newer vertices: so the faces that it changed have a
 * new vertex. Regular levels also flip edges between older vertices, but each face of a flip has a vertex of that
 * level. So if `since` is within the last regular level, the result is its first vertex; if within or before an earlier
 * one, it is 0. */
static cq_index cqi_changed_from(const cq_mesh *m, cq_index since)
{
    if (since <= m->flipped_before) return 0;
    return since > m->flipped_from && since <= m->flipped_to ? m->flipped_from : since;
}

static void cqi_mark_changes(const cq_mesh *m, cq_index v, int shift, uint8_t *faces)
{
    cq_index h = m->out[v];
    do {
        cq_index f = (cq_index)(h / 3);
        if (f < m->first_virtual_face) faces[f >> shift] = 1;
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
}

void cq_mesh_changes(const cq_mesh *m, cq_index since, int shift, uint8_t *faces)
{
    CQ_ASSERT(shift >= 0 && shift < CQ_INDEX_BITS);
    CQ_ASSERT(m->free_vertex == CQ_NONE); /* a decoder's */
    CQ_ASSERT(faces);
    cq_index v = faces == m->watched ? since : cqi_changed_from(m, since);
    for (; v < m->num_vertices; v++) cqi_mark_changes(m, v, shift, faces);
}

/* -- Range coder ---------------------------------------------------------------------------------------------------
 *
 * The encoder's interval [low, low + range) narrows with each symbol; 2^24 <= range < 2^32 before each. The decoder
 * keeps code = value - low, so that both sides compute the same ranges. 0 <= code < range holds for any input: a symbol
 * is only decoded if code lies in its part [offset, offset + width) of the range, and then code - offset < width. */
#define CQI_MIN_RANGE 0x1000000u

static void cqi_put_byte(cq_range_encoder *e, int byte)
{
    if (e->count < e->size) e->data[e->count] = (uint8_t)byte;
    e->count++;
    e->zeros = byte ? 0 : e->zeros + 1;
}

/* Moves the top byte of low out. Until it is known whether there will be a carry, a byte waits in cache, and the number
 * of 0xff bytes after it in pending. */
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
    uint32_t code = d->code - offset;
    while (width < CQI_MIN_RANGE) {
        width <<= 8;
        code = code << 8 | (d->count < d->size ? d->data[d->count] : 0u);
        d->count++;
    }
    d->code = code;
    d->range = width;
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

/* The part of the range for a 1 with probability p / 65536: neither 0 nor all of it, since 0 < p < 65536 and
 * range >= 2^24. */
static inline uint32_t cqi_one_width(uint32_t range, uint32_t p) { return (range >> 16) * p; }

/* A bit that is 1 with probability p / 65536, 0 < p < 65536. */
static inline void cqi_encode_part(cq_range_encoder *e, uint32_t p, int bit)
{
    const uint32_t one = cqi_one_width(e->range, p);
    cqi_encode_interval(e, bit ? 0 : one, bit ? one : e->range - one);
}

static inline int cqi_decode_part(cq_range_decoder *d, uint32_t p)
{
    const uint32_t one = cqi_one_width(d->range, p);
    if (d->code < one) {
        cqi_decode_interval(d, 0, one);
        return 1;
    }
    cqi_decode_interval(d, one, d->range - one);
    return 0;
}

/* The probability of the value that did not come, in 1/65535, loses 2^-rate of itself, rounded down: so it stays above
 * 0. */
static inline void cqi_adapt_bit(cq_bit_model *model, int rate, int bit)
{
    const uint32_t p = *model;
    *model = (cq_bit_model)(bit ? p + ((65535 - p) >> rate) : p - (p >> rate));
}

void cq_encode_bit(cq_range_encoder *e, cq_bit_model *model, int rate, int bit)
{
    CQ_ASSERT(e->range >= CQI_MIN_RANGE && *model >= 1 && *model <= 65534);
    CQ_ASSERT(rate >= 1 && rate <= 8);
    cqi_encode_part(e, *model, bit);
    cqi_adapt_bit(model, rate, bit != 0);
}

static inline int cqi_decode_adaptive(cq_range_decoder *d, cq_bit_model *model, int rate)
{
    const uint32_t one = cqi_one_width(d->range, *model);
    if (d->code < one) {
        cqi_adapt_bit(model, rate, 1);
        cqi_decode_interval(d, 0, one);
        return 1;
    }
    cqi_adapt_bit(model, rate, 0);
    cqi_decode_interval(d, one, d->range - one);
    return 0;
}

int cq_decode_bit(cq_range_decoder *d, cq_bit_model *model, int rate)
{
    CQ_ASSERT(d->range >= CQI_MIN_RANGE && *model >= 1 && *model <= 65534);
    CQ_ASSERT(rate >= 1 && rate <= 8);
    return cqi_decode_adaptive(d, model, rate);
}

/* Width of a symbol's part of the range. The last symbol also gets what the division leaves over, so that every code in
 * the range means something. */
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

/* The slot that the code is in, given the width of one. */
static inline uint32_t cqi_find_slot(cq_range_decoder *d, uint32_t width, uint32_t total)
{
    uint32_t slot;
    d->slot = width;
    slot = d->code / width;
    return slot < total ? slot : total - 1;
}

uint32_t cq_decode_slot(cq_range_decoder *d, uint32_t total)
{
    CQ_ASSERT(d->range >= CQI_MIN_RANGE && total && total <= CQI_MIN_RANGE);
    return cqi_find_slot(d, d->range / total, total);
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
        const uint32_t total = (uint32_t)1 << part, slot = cqi_find_slot(d, d->range >> part, total);
        cq_decode_freq(d, slot, 1, total);
        value = value << part | slot;
    }
    return value;
}

/* Of the numbers in [low, low + range), picks the one with the most zero bits at its end, writes it, and drops zero
 * bytes. It has at least 24, as any 2^24 successive numbers include one with that many. */
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

/* -- Header --------------------------------------------------------------------------------------------------------
 *
 * Reads headers: numbers of fixed length are little-endian, counts are LEB128. SPEC.md has the layout. */

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

/* Reads header bytes; its result is sticky: CQ_NEED_INPUT past the end, CQ_ERROR_CORRUPT for a bad number. */
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

/* An unsigned LEB128 of up to 32 bits; only its shortest form is valid. */
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

#define CQI_NO_GRID 0x40 /* bit of a channel's form: step and origin are 0 and left out */
static void cqi_read_channel(cqi_reader *r, cq_channel *c)
{
    const uint32_t form = cqi_read_uint(r, 1);
    uint32_t k;
    c->kind = (uint8_t)(form & 15);
    c->merge = (uint8_t)((form & ~(uint32_t)CQI_NO_GRID) >> 4);
    c->components = (uint8_t)cqi_read_uint(r, 1);
    c->bits = (uint8_t)cqi_read_uint(r, 1);
    if (form & CQI_NO_GRID) return;
    c->step = cqi_read_uint(r, 4);
    for (k = 0; k < c->components && k < CQ_MAX_COMPONENTS; k++) c->origin[k] = cqi_read_uint(r, 4);
}

static int cqi_channel_is_valid(const cq_channel *c)
{
    /* bit n: n are allowed */
    static const uint8_t components[CQ_TANGENT + 1] = { 8, 30, 12, 4, 24, 30, 30, 2, 2, 2, 28 };
    return c->kind <= CQ_TANGENT && (c->kind != CQ_TURNED || (c->merge == CQ_PER_FACE && c->bits == 1)) &&
           c->components <= CQ_MAX_COMPONENTS && (components[c->kind] >> c->components & 1) &&
           c->merge <= CQ_PER_FACE && (c->merge != CQ_PER_FACE || c->components == 1) && c->bits >= 1 &&
           (c->bits <= 24 || (c->bits == CQ_EXACT_BITS));
}

/* Instead of the number of faces, a stream has half the Euler characteristic of the closed mesh:
 * 2 V - F = 4 (components - genus). */
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

/* Flags in the byte that has the number of channels. A build without the feature leaves its flag in the number, which
 * is then too large: CQ_ERROR_UNSUPPORTED. */
#define CQI_REGULAR 0x40  /* there may be regular levels */
#define CQI_EXTENDED 0x80 /* counts follow of rows, things aside, metadata and materials, not all 0 */
static int cqi_is_extended(const cq_shape *s)
{
    return s->num_rows || s->num_aside_rows || s->num_aside_faces || s->metadata_bytes || s->num_materials;
}

static cq_result cqi_read_extension(cqi_reader *r, cq_shape *s)
{
    s->num_rows = cqi_read_varint(r);
    s->num_aside_rows = cqi_read_varint(r);
    s->num_aside_faces = cqi_read_varint(r);
    s->metadata_bytes = cqi_read_varint(r);
    s->num_materials = cqi_read_varint(r);
    if (r->result != CQ_OK) return r->result;
    if (!cqi_is_extended(s) || s->metadata_bytes > CQ_MAX_METADATA) return CQ_ERROR_CORRUPT;
    if (s->num_materials == 1 || s->num_materials > CQ_MAX_MATERIALS) return CQ_ERROR_CORRUPT;
    if (s->num_rows && (s->num_rows <= s->num_vertices || s->num_rows > 3 * (uint64_t)s->num_faces))
        return CQ_ERROR_CORRUPT;
    return CQ_OK;
}

/* An insertion of a regular level may read the values of two rows: together they must fit into one step. */
static int cqi_allows_regular(const cq_shape *s)
{
    return !s->num_rows || cqi_all_components(s, CQI_OF_VERTEX) + 2 * cqi_all_components(s, CQI_OF_ROW) <=
                               CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS;
}

static cq_result cqi_read_body(cqi_reader *r, cqi_header *h)
{
    cq_shape *s = h->shape;
    cq_result result = cqi_read_counts(r, s);
    uint32_t k, payload_size, extended;
    if (result != CQ_OK) return result;
    s->num_channels = cqi_read_uint(r, 1);
    extended = s->num_channels & CQI_EXTENDED;
#ifndef CQ_NO_WEDGES
    s->num_channels -= extended;
#endif
#ifndef CQ_NO_REGULAR
    s->regular = s->num_channels / CQI_REGULAR & 1;
    s->num_channels -= s->regular * CQI_REGULAR;
#endif
    if (s->num_channels > CQ_MAX_CHANNELS) {
        s->num_channels = 0; /* no shape has more than its array */
        return CQ_ERROR_UNSUPPORTED;
    }
    for (k = 0; k < s->num_channels; k++) {
        cqi_read_channel(r, &s->channel[k]);
        if (r->result == CQ_OK && !cqi_channel_is_valid(&s->channel[k])) return CQ_ERROR_UNSUPPORTED;
    }
    if (!CQI_HAS_ATTRIBUTES && s->num_channels && (s->num_channels > 1 || cqi_context_channel(s) < 0))
        return CQ_ERROR_UNSUPPORTED;
    if (extended) result = cqi_read_extension(r, s);
    if (result != CQ_OK) return result;
    if (s->regular && !cqi_allows_regular(s)) return CQ_ERROR_UNSUPPORTED;
    payload_size = cqi_read_varint(r);
    h->payload_size = (size_t)payload_size;
    h->payload_crc = cqi_read_uint(r, 4);
    if (h->payload_size != payload_size || h->payload_size > SIZE_MAX - CQ_MAX_HEADER_BYTES) /* unreachable: size_t of 64 bits */
        return CQ_ERROR_TOO_LARGE; /* unreachable: size_t of 64 bits */
    return r->result;
}

/* The check value comes last. Its place follows from the counts and channels, so that their errors are found first. */
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
    return CQ_DECODER_BYTES(cqi_all_vertices(s), cqi_all_faces(s), cqi_all_components(s, CQI_OF_VERTEX)) +
           cqi_all_components(s, CQI_OF_FACE) * CQ_FACE_BYTES(s->num_faces);
}

/* What comes on top of that: CQ_WEDGE_BYTES, CQ_ASIDE_BYTES, CQ_METADATA_BYTES and CQ_MATERIAL_BYTES, in 64 bits, so
 * that nothing overflows. */
static uint64_t cqi_more_bytes(const cq_shape *s)
{
    const uint64_t of_face = cqi_all_components(s, CQI_OF_FACE), of_row = cqi_all_components(s, CQI_OF_ROW);
    const uint64_t all = of_row + cqi_all_components(s, CQI_OF_VERTEX), faces = s->num_aside_faces;
    uint64_t bytes = CQ_METADATA_BYTES(s->metadata_bytes) + CQ_MATERIAL_BYTES(s->num_materials, faces);
    if (s->num_rows) bytes += CQI_WEDGE_BYTES(uint64_t, s->num_faces, s->num_rows, of_row);
    return bytes + CQI_ASIDE_BYTES(uint64_t, faces, s->num_aside_rows, all, of_face);
}

static size_t cqi_sum_of_sizes(uint64_t a, uint64_t b)
{
    return (size_t)(a + b) == a + b ? (size_t)(a + b) : 0; /* unreachable: size_t of 64 bits */
}

size_t cq_decoder_bytes(const cq_shape *s)
{
    if (!s || !cqi_countable(s)) return 0;
    return cqi_sum_of_sizes(cqi_decoder_size(s), cqi_more_bytes(s));
}

/* -- Coding: one routine for both directions ------------------------------------------------------------------------
 *
 * Everything from here to the encoder is run by the decoder, and by the encoder when it replays its choices from the
 * base on. A function cqi_code_x returns the x of the stream: a decoder reads it; an encoder writes the one that is
 * passed in, which it has looked up in its plan. Nothing else differs, so the two cannot drift apart. */

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

/* A collapse of B into A, as the encoder notes it for the split that undoes it. Vertices and faces have their numbers
 * in the input. */
typedef struct cqi_collapse {
    cq_index kept, removed;   /* A, B */
    cq_index face[2];         /* removed with B: the faces at p and at q */
    uint8_t p, q;             /* the two common neighbours, as places on the patch's ring */
    uint8_t first;            /* at a first gate: 1 + the side, see cqi_first_spoke; else 0. And see CQI_SIDES */
    uint8_t level;            /* 1 is the finest; 0: no collapse, but the end of a component's notes */
} cqi_collapse;

/* Further bits of `first`, with wedges: which corner of the face at p is A's, and which of the one at q is B's; and
 * whether a row of B has become the row of A that it continues, on the left and on the right. */
enum { CQI_SIDES = 3, CQI_CORNER_A = 2, CQI_CORNER_B = 4, CQI_TIED_LEFT = 0x40, CQI_TIED_RIGHT = 0x80 };

/* A component: its first gate L -> R, and the end of its notes that are not yet replayed. */
typedef struct cqi_seed {
    cq_index l, r, notes;
} cqi_seed;

#define CQI_MAX_REGULAR 32
#define CQI_FEW_SAMPLES 512u /* for fits, see cqi_most_samples */
#define CQI_MOST_SAMPLES 2048u

/* A vertex for fitting the weights of regular levels, see "Regular levels: weights of an encoder". */
typedef struct cqi_sample {
    int16_t feature[3][CQI_MOST];       /* 0 after the last one */
    int32_t offset[3];
    int32_t state[3];                   /* the shares of its equations in the sums; then what the present weights leave
                                           of the offset, 1/256 */
    int16_t edge_x, edge_y;             /* direction of its edge, 1/4096 */
} cqi_sample;

/* What the encoder noted while it simplified. Vertices and faces of its own mesh have "input" numbers. */
typedef struct cqi_plan {
    cq_range_encoder range;
    cq_mesh mesh;                       /* simplified step by step; in the end the base */
    cqi_walk walk;
    cqi_ring ring;
    const cq_value *positions;          /* that decide what is collapsed; or NULL */
    const cq_value *measured;           /* that the levels' errors are measured with; or NULL */
    uint32_t most_quadric;              /* largest quadric error of a collapse of this level; CQI_ANY_QUADRIC: any */
    uint32_t refused_quadric;           /* smallest one that was refused at this level */
    int tries;                          /* of this level so far, each with another first patch */
    const cq_value *const *input;       /* values as handed in */
    cqi_collapse *note;                 /* component after component, each from its finest level on */
    cq_index num_notes;
    cq_index next;                      /* note that is replayed next, of this component and level */
    cq_index *attached;                 /* to each face: a removed vertex that is near it, or CQ_NONE */
    cq_index *follower;                 /* of each removed vertex: the next one that is attached to the same face */
    cq_index root;                      /* of the component that is measured: first in its list, see decoded */
    uint32_t looks;                     /* how many more searches it may have for the vertex nearest to another */
    uint8_t *passed;                    /* last level that passed over the vertex */
    cq_index *decoded;                  /* of input vertices, virtual ones too: numbers in the decoded mesh; CQ_NONE:
                                           not yet there. Before the replay: next vertex of the component */
    cq_index *to_input;                 /* input vertices of those of the decoded base */
    cqi_sample *sample;                 /* room for this many: */
    uint32_t most_samples;
    int8_t before[2][3 * CQI_FINE];     /* weights of the regular level before: of both predictions */
    cqi_seed *seed;                     /* components, those with the most levels first */
    cq_index num_seeds, next_seed, num_active;
    cq_index *face_input, *face_decoded;  /* input halfedge of decoded halfedge 3f; decoded halfedge of input halfedge
                                             3f: a face may start at another corner */
    int follows_faces;                  /* 1: kept at all levels, for values or face_map; 0: only in the base */
    uint32_t num_levels;
    uint32_t num_regular;               /* of these, regular levels: the finest ones */
    uint32_t most_regular;              /* at most this many are allowed; if CQI_MAX_REGULAR, */
    uint32_t rejected;                  /* this one ended the encoding, as it does not pay; 1: none has */
    int is_near;                        /* 1: the mesh before the finest is near enough to the exact one */
    int is_smooth;                      /* 1: the exact mesh has no sharp edges */
    int surely_regular;                 /* 1: it is near, and so regular that encoding without them need not be tried */
    cq_index count_of[CQI_MAX_REGULAR + 1]; /* of each regular level: vertices, */
    uint32_t bytes_of[CQI_MAX_REGULAR + 1]; /* and bytes */
    uint32_t bytes_at[CQ_MAX_LEVELS + 1]; /* bytes before each level */
    uint32_t level;                     /* being made or replayed; 1 is the finest */
    uint8_t level_error[CQ_MAX_LEVELS + 1];  /* of the mesh without the levels up to this one */
    const uint8_t *locked;              /* of each vertex: it stays; or NULL */
    int clean;                          /* no row may move */
    const cq_index *row_of_vertex;      /* rows of the input; NULL: the same numbers, and none of the following */
    const cq_index *row_of_wedge;
    const cq_index *face_of_input;      /* of each face of the mesh: its number as handed in */
    const uint8_t *face_state;          /* of these, see CQI_FACE_ASIDE */
    const cq_index *corners;            /* vertices of these faces; NULL: there are seams */
    int copies_rows;                    /* an input row may be at several vertices, so rows do not identify faces */
    cq_index *index;                    /* wedges of the corners of the mesh, as it is simplified; NULL: no seams */
    cq_index *uses;                     /* corners of each wedge */
    cq_index *wedge_of_row;             /* wedges of the rows of the decoded mesh, */
    cq_index *row_decoded;              /* and rows of the wedges */
    const cq_index *target;             /* of each row of the input: its wedge; or if it is aside, the number of wedges
                                           + its number there */
    const cq_index *aside_row;          /* rows of the input that are aside */
    const cq_index *triangles;          /* as handed in */
    const uint8_t *metadata;            /* as handed in */
    const cq_index *materials;          /* as handed in */
    cq_index num_wedges, aside_face;    /* aside_face: the next face of the input that may be aside */
} cqi_plan;

/* Adaptation rate of the bit models; higher is slower. */
#define CQI_RATE(num_vertices) ((num_vertices) < 512 ? 4 : (num_vertices) < 4096 ? 5 : 6)

/* -- The plan: what the encoder looks up while it replays --
 *
 * The encoder replays its collapses as splits, in the order of the decoder. Here it finds what to write: the next
 * component or collapse, and the numbers that vertices and faces have in its own mesh and in the decoded one. */

/* Bytes of the stream so far. */
static uint32_t cqi_plan_bytes(const cqi_plan *p) { return (uint32_t)(p->range.count + p->range.pending); }

/* The halfedge from one vertex to a neighbour of it. */
static cq_index cqi_find_spoke(const cq_mesh *m, cq_index from, cq_index to)
{
    cq_index h = m->out[from];
    while (cq_target(m, h) != to) h = cq_clockwise(m, h);
    return h;
}

/* Corner k of the face of halfedge h, counted from h. */
static cq_index cqi_corner(cq_index h, int k) { return k == 0 ? h : k == 1 ? cq_next(h) : cq_prev(h); }

/* The first gate of the next component, as an input halfedge. */
static cq_index cqi_plan_seed(cqi_plan *p)
{
    const cqi_seed *s = &p->seed[p->next_seed++];
    return cqi_find_spoke(&p->mesh, s->l, s->r);
}

static void cqi_plan_vertex(cqi_plan *p, cq_index input, cq_index decoded)
{
    p->decoded[input] = decoded;
    p->to_input[decoded] = input;
}

/* The face of input halfedge h has become decoded face f, with corner 0 at h. */
static void cqi_plan_face(cqi_plan *p, cq_index h, cq_index f)
{
    p->face_input[f] = h;
    p->face_decoded[h / 3] = (cq_index)(3 * f + (3 - h % 3) % 3);
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

/* The border halfedge that ends at x, for a new face with halfedge x -> w. Walks clockwise around x to the first face
 * that is there already: there the gap ends that the new face begins to fill. Only for a join is this more than one
 * step; and a join splits the gap in two, so a vertex has no more long walks than joins. */
static cq_index cqi_plan_border(const cqi_plan *p, cq_index x_to_w)
{
    cq_index t = p->mesh.twin[x_to_w];
    while (cqi_plan_to_decoded(p, t) == CQ_NONE) t = p->mesh.twin[cq_next(t)];
    return cqi_plan_to_decoded(p, t);
}

/* Does the next component, which there is, take part in the level that begins? */
static int cqi_plan_begins(const cqi_plan *p)
{
    return p->note[p->seed[p->num_active].notes - 1].level >= p->level;
}

/* Moves on to the collapses of a component at this level: the last ones that are not yet replayed. */
static void cqi_plan_component(cqi_plan *p)
{
    cqi_seed *s = &p->seed[p->next_seed++];
    while (p->note[s->notes - 1].level == p->level) s->notes--;
    p->next = s->notes;
}

/* The next collapse if it was in the patch of this centre; else NULL. */
static const cqi_collapse *cqi_plan_split(const cqi_plan *p, cq_index centre)
{
    const cqi_collapse *c = &p->note[p->next];
    return c->level == p->level && p->decoded[c->kept] == centre ? c : NULL;
}

/* Which case of a first gate the first collapse of a component at this level is, see cqi_first_spoke. */
static int cqi_plan_side(const cqi_plan *p)
{
    const int side = p->note[p->next].first & CQI_SIDES;
    return side ? side - 1 : 0;
}

#ifndef CQ_NO_REGULAR

/* -- The plan of a regular level --
 *
 * A note of each odd vertex (new at the level) has: removed, the vertex; kept and face[0], its parents a and b; p and
 * q, what it knows of the coarse face to the left and to the right of a -> b, see CQI_SIDE_HUB; and with seams face[1],
 * its wedge on the left, whose entry in p->uses is the one on the right. When the level begins, the base has been read
 * and p->mesh is idle: twin[h] then becomes the note of decoded halfedge h, and origin[v] the note of input vertex
 * v. */

/* What a note says of a coarse face: its vertex is the hub there (or if the face has no other mark, a spoke of it is
 * flipped, see cqi_plan_second); in the face, the edge after its own is dissolved; the edge before its own is. */
enum { CQI_SIDE_HUB = 1, CQI_SIDE_NEXT = 2, CQI_SIDE_PREVIOUS = 4 };

/* The halfedge between two neighbours in the decoded mesh, found around the one with fewer neighbours. Over all edges
 * this takes linear time at any fixed genus (Chiba, Nishizeki, "Arboricity and Subgraph Listing Algorithms", 1985). */
static cq_index cqi_find_edge(const cq_mesh *m, cq_index a, cq_index b)
{
    return m->valence[a] < m->valence[b] ? cqi_find_spoke(m, a, b) : cqi_find_spoke(m, b, a);
}

/* Moves on to a level with notes first .. first + count - 1, before any of it is inserted in the decoded mesh m. */
static void cqi_plan_regular(cqi_plan *p, const cq_mesh *m, cq_index first, cq_index count)
{
    cq_index k, h;
    for (h = 0; h < 3 * (m->first_virtual_face + m->num_virtual_faces); h++) p->mesh.twin[h] = CQ_NONE;
    for (k = first; k < first + count; k++) {
        const cqi_collapse *c = &p->note[k];
        h = cqi_find_edge(m, p->decoded[c->kept], p->decoded[c->face[0]]);
        p->mesh.twin[h] = p->mesh.twin[m->twin[h]] = k;
        p->mesh.origin[c->removed] = k;
    }
}

/* The input vertex that this level inserts in a decoded edge; or CQ_NONE. Asked before the first insertion. */
static cq_index cqi_plan_mark(const cqi_plan *p, cq_index h)
{
    const cq_index k = p->mesh.twin[h];
    return k == CQ_NONE ? k : p->note[k].removed;
}

/* The note of a decoded vertex that is new at this level. */
static const cqi_collapse *cqi_plan_odd(const cqi_plan *p, cq_index decoded)
{
    return &p->note[p->mesh.origin[p->to_input[decoded]]];
}

/* Is a spoke of a new vertex flipped after an edge of its coarse face is dissolved? Its face has no other mark: so the
 * spoke lies between those to the two parents. */
static int cqi_plan_second(const cqi_plan *p, const cq_mesh *m, cq_index spoke)
{
    const cqi_collapse *c = cqi_plan_odd(p, m->origin[spoke]);
    const cq_index left = cq_target(m, cq_counterclockwise(m, spoke));
    return (left == p->decoded[c->kept] ? c->p : c->q) & CQI_SIDE_HUB;
}

/* Does halfedge `marked` have a note, and bit `side` in what this says of the face of `marked`? See CQI_SIDE_HUB. */
static int cqi_plan_mark_says(const cqi_plan *p, const cq_mesh *m, cq_index marked, int side)
{
    const cq_index k = p->mesh.twin[marked];
    if (k == CQ_NONE) return 0;
    return ((p->decoded[p->note[k].kept] == m->origin[marked] ? p->note[k].p : p->note[k].q) & side) != 0;
}

/* Is a decoded edge without a mark dissolved? Asked before the first insertion; each mark of its two faces knows. */
static int cqi_plan_dissolved(const cqi_plan *p, const cq_mesh *m, cq_index h)
{
    const cq_index g = m->twin[h];
    return cqi_plan_mark_says(p, m, cq_prev(h), CQI_SIDE_NEXT) ||
           cqi_plan_mark_says(p, m, cq_next(h), CQI_SIDE_PREVIOUS) ||
           cqi_plan_mark_says(p, m, cq_prev(g), CQI_SIDE_NEXT) ||
           cqi_plan_mark_says(p, m, cq_next(g), CQI_SIDE_PREVIOUS);
}

#endif /* CQ_NO_REGULAR */

/* -- Symbols --
 *
 * Bits and numbers in both directions, on which all other coding is built; and what they cost, for reports. */

/* A bit that is 1 with probability p / 65536. */
static inline int cqi_code_part(cq_decoder *d, uint32_t p, int bit)
{
    if (CQI_ENCODING(d)) cqi_encode_part(&d->plan->range, p, bit);
    else bit = cqi_decode_part(&d->range, p);
    return bit;
}

/* A bit with a model, which adapts to it. */
static inline int cqi_code_adaptive(cq_decoder *d, cq_bit_model *model, int rate, int bit)
{
    if (CQI_ENCODING(d)) cq_encode_bit(&d->plan->range, model, rate, bit);
    else bit = cqi_decode_adaptive(&d->range, model, rate);
    return bit;
}

/* A bit with model number `index`. */
static inline int cqi_code_bit(cq_decoder *d, int index, int bit)
{
    return cqi_code_adaptive(d, &d->model.bit[index], d->rate, bit);
}

static uint32_t cqi_code_raw(cq_decoder *d, uint32_t value, int bits)
{
    if (!CQI_ENCODING(d)) return cq_decode_raw(&d->range, bits);
    cq_encode_raw(&d->plan->range, value, bits);
    return value;
}

/* One of `count` numbers, all equally likely. */
static uint32_t cqi_code_uniform(cq_decoder *d, uint32_t value, uint32_t count)
{
    if (CQI_ENCODING(d)) {
        cq_encode_freq(&d->plan->range, value, 1, count);
    } else {
        value = cq_decode_slot(&d->range, count);
        cq_decode_freq(&d->range, value, 1, count);
    }
    return value;
}

/* Did the last symbols need bytes that are not there? Asked before what they say is applied. */
static int cqi_starved(const cq_decoder *d) { return d->input.payload_left && d->range.count > d->range.size; }

/* An event of decoding, see CQ_TRACE; the encoder's replay tells none. */
#ifdef CQ_TRACE
#define CQI_TRACE_IF(condition, d, event, a, b, c) \
    do { \
        if ((condition) && !CQI_ENCODING(d) && !cqi_starved(d)) \
            CQ_TRACE(d, event, (uint32_t)(a), (uint32_t)(b), (uint32_t)(c)); \
    } while (0)
#else
#define CQI_TRACE_IF(condition, d, event, a, b, c) ((void)0)
#endif
#define CQI_TRACE(d, event, a, b, c) CQI_TRACE_IF(1, d, event, a, b, c)

/* log2(x) in 1/65536, within 1/6000, x > 0: log2(1 + f) is f plus f (1 - f) times a polynomial. */
static uint32_t cqi_log2(uint32_t x)
{
    const int n = cqi_bit_length(x) - 1;
    const uint32_t f = (uint32_t)((uint64_t)x << (32 - n) >> 16) & 0xffff;
    const uint32_t factor = 28784 - (f * (15791 - (f * 5500 >> 16)) >> 16);
    return (uint32_t)n * 65536 + f + ((f * (65536 - f) >> 16) * factor >> 16);
}

/* Adds the cost of what was coded since the last call to two entries of the report, in 1/65536 bit. */
static void cqi_charge(cq_decoder *d, uint64_t *entry, uint64_t *level_entry)
{
    uint64_t bytes = d->input.dropped + d->range.count, now;
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

#ifndef CQ_TRAINING
#define CQI_TUNED(name, usual) (usual)
#endif

/* -- Priors: what the models know before the first symbol --
 *
 * Fitted by `make train` (tests/train) on meshes that are neither in the paper's Table 1 nor in the bench, and written
 * by it between the two marks below. Bits: probability of a 1, in 1/256. Weights: in 1/16 nat, for connectivity alone
 * and with positions. They are part of the format: other tables are another stream version. */
#ifndef CQ_TRAINING
/* priors begin */
static const uint8_t cqi_prior_bit[CQI_OF_CONQUEST] = {
    116, 82, 14, 169, 37, 138, 196, 173, 166, 169, 174, 179, 128, 142, 112, 2, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 255, 128, 128, 128, 128, 128, 128, 128, 62, 102, 108, 80, 51, 31, 34, 128, 169, 97, 132,
    90, 75, 110, 48, 128, 160, 84, 92, 52, 42, 52, 21, 128, 137, 90, 70, 51, 42, 43, 34, 128, 136,
    90, 68, 22, 56, 48, 26, 128, 118, 45, 56, 36, 26, 24, 15, 128, 128, 164, 70, 118, 140, 147, 147,
    128, 0, 77, 98, 123, 127, 112, 134, 128, 128, 128, 25, 20, 40, 101, 182, 215, 231, 221, 176, 128, 128,
    128, 114, 56, 85, 144, 207, 233, 235, 220, 208, 128, 128, 128, 255, 105, 117, 162, 218, 241, 245, 242, 216,
    128, 128, 128, 128, 255, 168, 189, 229, 245, 245, 247, 243, 110, 103, 114, 104, 121, 111, 105, 96, 88, 94,
    31, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 139, 153, 113, 126, 186, 232, 249,
    248, 149, 144, 150, 149, 126, 154, 138, 128, 113, 104, 97, 89, 83, 77, 77, 77, 63, 60, 14, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 145, 95, 166, 185, 202, 177, 163, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 163, 56, 63, 186, 186, 175, 108, 128, 128, 128, 128, 128, 128, 128, 128,
    185, 95, 40, 97, 159, 114, 144, 119, 0, 128, 128, 128, 128, 128, 128, 128, 188, 115, 47, 42, 123, 146,
    142, 99, 0, 128, 128, 128, 128, 128, 128, 128, 102, 74, 29, 95, 159, 57, 127, 128, 93, 0, 128, 128,
    128, 128, 128, 128, 109, 80, 33, 76, 138, 121, 110, 106, 98, 0, 128, 128, 128, 128, 128, 128, 66, 46,
    26, 94, 85, 91, 109, 128, 157, 91, 0, 128, 128, 128, 128, 128, 97, 64, 18, 32, 55, 95, 150, 150,
    132, 88, 0, 128, 128, 128, 128, 128, 62, 38, 18, 49, 52, 128, 137, 145, 156, 126, 82, 0, 128, 128,
    128, 128, 95, 71, 24, 24, 58, 81, 120, 115, 143, 121, 89, 0, 128, 128, 128, 128, 73, 51, 18, 25,
    38, 82, 132, 122, 157, 139, 122, 102, 60, 43, 38, 128, 114, 89, 29, 21, 28, 76, 83, 128, 142, 130,
    119, 100, 51, 41, 39, 128, 115, 108, 99, 90, 82, 79, 77, 81, 76, 63, 29, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 132, 92, 151, 176, 194, 169, 156, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 171, 81, 67, 163, 179, 113, 140, 128, 128, 128, 128, 128, 128, 128, 128, 170, 82, 59,
    144, 188, 152, 122, 106, 0, 128, 128, 128, 128, 128, 128, 128, 182, 126, 49, 60, 168, 194, 79, 108, 0,
    128, 128, 128, 128, 128, 128, 128, 106, 61, 42, 132, 182, 91, 134, 151, 109, 0, 128, 128, 128, 128, 128,
    128, 111, 71, 30, 56, 149, 123, 88, 108, 98, 0, 128, 128, 128, 128, 128, 128, 60, 41, 23, 106, 110,
    128, 124, 152, 148, 95, 0, 128, 128, 128, 128, 128, 102, 61, 20, 43, 118, 64, 122, 101, 128, 91, 0,
    128, 128, 128, 128, 128, 61, 37, 15, 43, 65, 137, 141, 106, 157, 120, 85, 0, 128, 128, 128, 128, 93,
    72, 22, 24, 61, 58, 113, 128, 150, 120, 86, 0, 128, 128, 128, 128, 74, 52, 20, 35, 30, 80, 126,
    112, 155, 140, 122, 102, 59, 44, 42, 128, 115, 91, 30, 26, 23, 53, 103, 128, 143, 129, 119, 103, 52,
    43, 32, 128, 91, 83, 81, 81, 83, 85, 85, 84, 63, 69, 59, 116, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 87, 35, 86, 143, 108, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    128, 124, 35, 10, 87, 127, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 112, 38, 26, 19, 73, 128,
    128, 128, 0, 128, 128, 128, 128, 128, 128, 128, 140, 77, 44, 29, 7, 125, 128, 128, 0, 128, 128, 128,
    128, 128, 128, 128, 61, 58, 40, 21, 56, 109, 128, 128, 132, 0, 128, 128, 128, 128, 128, 128, 77, 64,
    35, 30, 29, 54, 127, 127, 129, 0, 128, 128, 128, 128, 128, 128, 43, 53, 37, 27, 67, 114, 95, 128,
    188, 126, 0, 128, 128, 128, 128, 128, 59, 72, 49, 30, 37, 58, 116, 120, 177, 117, 0, 128, 128, 128,
    128, 128, 36, 68, 44, 29, 55, 91, 101, 128, 204, 170, 111, 0, 128, 128, 128, 128, 49, 86, 62, 40,
    47, 41, 136, 149, 197, 160, 102, 0, 128, 128, 128, 128, 44, 92, 56, 36, 48, 37, 86, 128, 206, 181,
    153, 116, 61, 60, 71, 128, 64, 112, 83, 44, 41, 32, 74, 119, 192, 168, 140, 111, 58, 68, 83, 128,
    94, 92, 80, 84, 77, 54, 110, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 118, 21,
    80, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 153, 68, 16, 32, 128, 128, 128, 128, 0,
    128, 128, 128, 128, 128, 128, 128, 158, 98, 55, 10, 55, 128, 128, 128, 0, 128, 128, 128, 128, 128, 128,
    128, 79, 82, 39, 13, 98, 128, 128, 128, 122, 0, 128, 128, 128, 128, 128, 128, 110, 108, 39, 48, 25,
    123, 128, 128, 121, 0, 128, 128, 128, 128, 128, 128, 63, 71, 27, 56, 93, 121, 128, 128, 171, 113, 0,
    128, 128, 128, 128, 128, 79, 103, 36, 50, 82, 108, 128, 128, 183, 123, 0, 128, 128, 128, 128, 128, 54,
    61, 22, 64, 127, 128, 128, 128, 192, 176, 131, 0, 128, 128, 128, 128, 76, 97, 21, 60, 105, 128, 128,
    128, 166, 141, 105, 0, 128, 128, 128, 128, 57, 67, 7, 101, 128, 128, 128, 128, 183, 161, 135, 114, 71,
    77, 32, 128, 93, 94, 6, 105, 128, 128, 128, 128, 163, 162, 124, 107, 51, 75, 117, 128, 168, 147, 127,
    91, 149, 134, 120, 106, 141, 132, 123, 116,
};
#ifndef CQ_NO_REGULAR
static const uint8_t cqi_prior_regular[CQI_PRIORS - CQI_OF_CONQUEST] = {
    128, 30, 16, 124, 49, 128, 15, 20, 100, 32, 128, 18, 1, 12, 4, 155, 27, 17, 110, 46, 128, 9,
    5, 52, 23, 128, 27, 14, 82, 38, 128, 180, 120, 236, 240, 128, 63, 37, 184, 173, 128, 166, 66, 229,
    239, 128, 254, 242, 254, 255, 128, 131, 59, 181, 145, 128, 23, 11, 67, 62, 128, 113, 26, 142, 119, 128,
    252, 215, 251, 254, 128, 241, 153, 225, 243, 104, 58, 21, 139, 89, 128, 14, 8, 55, 38, 61, 32, 17,
    106, 93, 128, 238, 167, 248, 253, 128, 196, 103, 204, 222, 184, 146, 60, 174, 194, 210, 192, 58, 17, 128,
    39, 149, 8, 1, 128, 250, 236, 142, 8, 128, 247, 236, 142, 59, 128, 181, 202, 53, 3, 128, 96, 122,
    31, 0, 128, 14, 33, 2, 0, 128, 216, 192, 88, 35, 128, 244, 254, 255, 246, 168, 98, 97, 105, 84,
    93, 119, 89, 74, 72, 154, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128,
    29, 12, 147, 184, 154, 130, 163, 128, 128, 128, 128, 128, 128, 128, 128, 128, 49, 23, 110, 159, 141, 150,
    165, 128, 128, 128, 128, 128, 128, 128, 128, 128, 75, 57, 72, 108, 127, 124, 139, 128, 128, 128, 128, 128,
    128, 128, 128, 128, 117, 96, 72, 89, 136, 124, 137, 128, 128, 128, 128, 128, 128, 128, 128, 128, 151, 131,
    90, 90, 137, 124, 132, 128, 128, 128, 128, 128, 128, 128, 128, 182, 162, 123, 121, 121, 103, 128, 71, 0,
    128, 128, 128, 128, 128, 128, 128, 198, 187, 162, 140, 122, 94, 134, 114, 0, 128, 128, 128, 128, 128, 128,
    128, 172, 188, 161, 123, 85, 148, 186, 136, 123, 0, 128, 128, 128, 128, 128, 128, 197, 199, 177, 116, 80,
    158, 183, 137, 111, 0, 128, 128, 128, 128, 128, 128, 160, 175, 125, 85, 153, 194, 134, 1, 141, 115, 0,
    128, 128, 128, 128, 128, 178, 188, 141, 103, 150, 178, 137, 2, 125, 124, 0, 128, 128, 128, 128, 128, 143,
    180, 161, 155, 141, 84, 11, 50, 168, 157, 130, 71, 12, 21, 128, 128, 92, 84, 89, 82, 80, 179, 55,
    14, 28, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 36, 15, 85,
    102, 119, 104, 112, 128, 128, 128, 128, 128, 128, 128, 128, 128, 55, 26, 50, 131, 152, 161, 163, 128, 128,
    128, 128, 128, 128, 128, 128, 128, 99, 50, 37, 104, 201, 179, 37, 128, 128, 128, 128, 128, 128, 128, 128,
    128, 131, 68, 32, 115, 173, 150, 69, 128, 128, 128, 128, 128, 128, 128, 128, 128, 149, 79, 40, 123, 138,
    130, 125, 128, 128, 128, 128, 128, 128, 128, 128, 164, 115, 60, 127, 135, 134, 123, 137, 0, 128, 128, 128,
    128, 128, 128, 128, 181, 145, 95, 98, 105, 113, 143, 165, 0, 128, 128, 128, 128, 128, 128, 128, 136, 116,
    96, 109, 120, 144, 144, 103, 121, 0, 128, 128, 128, 128, 128, 128, 153, 139, 97, 90, 89, 148, 191, 153,
    106, 0, 128, 128, 128, 128, 128, 128, 108, 115, 93, 119, 201, 224, 142, 19, 138, 110, 0, 128, 128, 128,
    128, 128, 125, 147, 128, 124, 201, 225, 138, 15, 128, 113, 0, 128, 128, 128, 128, 128, 98, 185, 187, 199,
    132, 84, 20, 10, 192, 152, 144, 76, 4, 86, 128, 128,
};
#endif
static const int8_t cqi_prior_bare[CQI_WEIGHTS] = {
    -11, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 8,
    0, 0, 2, 4, 4, 4, 0, 1, -2, 2, -4, -3, -5, 3, -4, -3, -4, 4, -6, -5, -6, 4,
    -5, -4, -5, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 25, 32, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 19, 31, 27, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 6, 21, 23,
    12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -6,
    11, 16, 14, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, -15, 2, 11, 11, 7, -23, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, -31, -2, 6, 13, 9, 3, -21, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, -36, -6, 4, 8, 10, 7, 6, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, -35, -12, 1, 6, 8, 9, 11, -1, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, -38, -24, -6, 0, 2, 5, 11, -1, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -41, -26, -12, -5, -4, -3, -4, -4, -3, -4, -3,
    -5, -4, -3, -3, -2, -2, -2, -1, 0, 0, 0, 0, -26, -17, -12, -4, 0, 3, 6, 4, 2, 1,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    -26, -16, -11, -9, -3, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -26, -17, -15, -6, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 20, -24, -15,
    -3, 2, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, -23, -3, 19, 23, 13, 2, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -21, -9, 2, 2,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 19, -18, -5, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -12, 8, 33, 44, 40, 18,
    1, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 41, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, -2, -3, -3, -3, -4,
    -4, -4, -7, -12, -16, -16, -11, -8, 7, 14, 13, 14, 12, 12, 14, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, -1, -2, -2, -3, -3, -3, -3, -3, -3, -5, -7, -15, -20, -18, 7, 13, 11,
    10, 10, 9, 10, 11, 0,
};
static const int8_t cqi_prior_located[CQI_WEIGHTS] = {
    -4, -2, -2, -2, -1, -1, -1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 0, 2, 1,
    0, -3, 1, 1, 2, -2, 1, 2, -1, -1, -2, -1, -2, -2, -1, 0, 0, -1, -2, -1, 0, 0,
    -2, 0, 1, 0, 3, -1, -1, -1, -2, -2, -2, -3, -3, -4, -4, -4, -4, -4, -5, -5, -9, -8,
    -7, -5, -3, -2, -1, 0, 0, 0, 0, 0, 0, 0, 0, -9, 0, 22, 29, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 14, 27, 26, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 22, 26,
    21, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -4,
    16, 22, 23, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, -14, 7, 16, 18, 16, -3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, -29, 0, 9, 16, 12, 10, -8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, -31, -6, 4, 7, 8, 7, 4, -7, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, -33, -12, -3, 1, 1, 3, 2, -9, -7, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, -35, -22, -8, -5, -4, -2, 0, -3, -7, -3, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -45, -30, -13, -10, -12, -10, -10, -7, -8, -5, -5,
    -2, -2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -24, -13, -2, 9, 12, 11, 7, 2, 1, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    -25, -14, -5, 3, 5, 4, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -25, -15, -6, 0, 2, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 25, -23, -12,
    -2, 5, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, -23, -10, 3, 7, 3, 1, 1, 1, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -22, -9, 3, 7,
    1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 29, -21, -11, 2, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -17, 0, 15, 19, 16, 10,
    6, 2, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 53, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, -1, 0, -3, -6, -13, -18, -17, -3, 3, 2, 2, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -6, -17, -21, -3, 2, 0,
    0, -1, -2, -2, -2, 0,
};
static const uint8_t cqi_prior_yes[CQI_QUESTIONS] = {
    59, 68, 31, 10, 4, 0, 78, 78, 120, 94, 51, 28, 16, 5, 78, 78, 144, 114, 78, 46, 23, 5,
    78, 78, 197, 160, 128, 96, 63, 7, 78, 78, 236, 200, 189, 168, 119, 43, 78, 78, 252, 244, 235, 210,
    114, 80, 78, 78, 255, 250, 253, 214, 161, 84, 78, 78, 255, 255, 253, 183, 27, 78, 78, 78, 26, 13,
    5, 0, 157, 75, 5, 0, 194, 107, 17, 9, 248, 166, 57, 9, 24, 13, 5, 0, 154, 75, 7, 0,
    226, 110, 20, 0, 251, 211, 54, 58, 34, 8, 4, 3, 104, 32, 13, 2, 180, 94, 77, 35, 217, 168,
    164, 55, 79, 22, 9, 0, 168, 92, 15, 1, 88, 74, 65, 71, 78, 78, 78, 78, 76, 19, 6, 1,
    148, 70, 30, 0, 153, 139, 50, 18, 78, 96, 110, 78, 69, 13, 6, 4, 148, 69, 58, 13, 213, 167,
    108, 71, 197, 78, 93, 78, 43, 22, 3, 0, 101, 81, 9, 0, 74, 61, 62, 78, 78, 78, 78, 78,
    48, 25, 2, 0, 110, 55, 5, 0, 78, 69, 49, 71, 78, 78, 78, 78, 25, 8, 4, 1, 111, 60,
    30, 16, 62, 64, 66, 57, 78, 78, 78, 78, 70, 74, 55, 61, 33, 7, 78, 78, 107, 88, 68, 59,
    39, 37, 78, 78, 144, 117, 82, 43, 36, 39, 78, 78, 180, 135, 97, 75, 92, 81, 78, 78, 226, 166,
    115, 142, 170, 150, 78, 78, 242, 203, 193, 206, 203, 156, 78, 78, 253, 255, 252, 251, 242, 204, 78, 78,
    253, 235, 243, 229, 213, 251, 78, 78,
};
static const int8_t cqi_prior_gain[CQI_QUESTIONS] = {
    -47, -40, -19, -9, -8, -10, 0, 0, -65, -34, -5, 3, 3, -4, 0, 0, -40, -3, 32, 40, 22, -4,
    0, 0, -18, 27, 83, 110, 94, -3, 0, 0, 1, 102, 127, 127, 127, 72, 0, 0, 53, 127, 127, 127,
    127, 127, 0, 0, 117, 127, 127, 127, 127, 26, 0, 0, 97, 127, 127, 127, 17, 0, 0, 0, 1, 2,
    -7, -10, 105, 105, -3, -9, 127, 127, 20, 6, 127, 127, 109, 4, 2, 3, -6, -8, 105, 100, 0, -9,
    127, 127, 21, -9, 127, 127, 97, 77, -1, -7, -8, -5, 55, 26, 11, -5, 115, 127, 127, 52, 127, 127,
    127, 95, 48, 13, 0, -8, 125, 95, 11, -10, 17, -2, 96, -3, 0, 0, 0, 0, 41, 12, -1, -10,
    117, 83, 40, -8, 68, 95, 33, -18, 0, 12, 119, 0, 27, 1, -3, -4, 124, 96, 99, 12, 127, 127,
    127, 32, 112, 0, 58, 0, 21, 16, -6, -8, 127, 87, -3, -10, -2, -9, -8, 0, 0, 0, 0, 0,
    33, 28, -6, -10, 127, 72, -1, -8, 0, -4, 2, -3, 0, 0, 0, 0, 3, -3, -4, -8, 127, 82,
    37, 17, -8, -2, 32, -10, 0, 0, 0, 0, -58, -34, -26, -4, -9, -8, 0, 0, -69, -52, -33, -16,
    -8, 8, 0, 0, -56, -47, -21, -11, -2, 19, 0, 0, -58, -50, -14, 17, 68, 78, 0, 0, -29, -35,
    5, 88, 127, 127, 0, 0, -6, 19, 124, 127, 127, 127, 0, 0, 51, 127, 127, 127, 127, 127, 0, 0,
    -8, 120, 127, 127, 127, 127, 0, 0,
};
static const int8_t cqi_prior_linear[2 * CQI_FAN_CLASSES * CQI_FEATURES] = {
    0, 17, 0, 2, 3, -2, -3, 1, -22, -12, 8, -15, -14, 15, -22, -12, 22, -20, -9, 29, -18, -13,
    37, -15, 0, 31, 0, -34, -31, -77, -28, 26, 2, -25, 39, 17, -23, 18, -16, -20, 26, -16, -17, 33,
    -16, -13, 43, -13,
};
/* priors end */

static void cqi_model_init(cqi_model *m, const cq_shape *s)
{
    const int8_t *prior = cqi_context_channel(s) >= 0 ? cqi_prior_located : cqi_prior_bare;
    int k, j;
    for (k = 0; k < CQI_OF_CONQUEST; k++) m->bit[k] = (cq_bit_model)(256u * cqi_prior_bit[k] + 128u);
#ifndef CQ_NO_REGULAR
    for (; k < CQI_PRIORS; k++) m->bit[k] = (cq_bit_model)(256u * cqi_prior_regular[k - CQI_OF_CONQUEST] + 128u);
#endif
    for (; k < CQI_FACE; k++) m->bit[k] = m->bit[k - (CQI_PLAIN - CQI_FIRST)];
    for (; k < CQI_MODELS; k++) m->bit[k] = 256u * 240u + 128u;
    for (k = 0; k < CQI_WEIGHTS; k++) m->weight[k] = (int16_t)(prior[k] * (CQI_NAT / 16));
    for (k = 0; k < 2 * CQI_FAN_CLASSES * CQI_FEATURES; k++) m->linear[k] = (int16_t)(cqi_prior_linear[k] * 128);
    m->worth_rivals = m->worth_flat = m->worth_same[0] = m->worth_same[1] = 16 * 16;
    m->mirror = 1;
    m->skin[0] = m->skin[1] = m->trust[0] = m->trust[1] = 0;
    for (k = 0; k < CQI_QUESTIONS; k++) {
        m->yes[k] = (cq_bit_model)(256u * cqi_prior_yes[k] + 128u);
        m->gain[k] = (int16_t)(cqi_prior_gain[k] * 16);
    }
    for (k = 0; k < CQ_MAX_CHANNELS; k++)
        for (j = 0; j < CQI_FEATURES; j++)
            m->plain[k][j] = prior == cqi_prior_located ? 1 << 13 : m->linear[5 * CQI_FEATURES + j];
}
#else
static void cqi_model_init(cqi_model *m, const cq_shape *s); /* these three are the trainer's */
static void cqi_model_keep(const cqi_model *m);
static void cqi_model_omit(cqi_model *m);                     /* takes out the parts that it is to do without */
#endif

/* What the next step does. Those up to CQI_BASE_ROWS come before the base is complete. */
enum {
    CQI_HEADER, CQI_MATERIALS, CQI_BASE, CQI_BASE_VALUES, CQI_BASE_ROWS, CQI_LEVEL, CQI_ACTIVE, CQI_CLEAR, CQI_PATCHES,
    CQI_WIPE, CQI_MARKS, CQI_TABLE, CQI_EXPECT, CQI_DISSOLVES, CQI_RECORDS, CQI_SWEEP, CQI_READ_CORNERS, CQI_READ_ROWS,
    CQI_READ_ASIDE, CQI_COMPLETE
};

/* A value that is mostly equal to one of the n beside it: asks for each distinct one of these whether the value is
 * equal to it, up to the first yes; without one its bits follow. */
static int32_t cqi_code_copy(cq_decoder *d, int bits, const int32_t *beside, int n, int32_t value)
{
    int i, j, refused = 0;
    for (i = 0; i < n; i++) {
        int asked = 0, same = 0;
        for (j = 0; j < n; j++) {
            same += beside[j] == beside[i];
            asked += j < i && beside[j] == beside[i];
        }
        if (asked) continue;
        if (cqi_code_bit(d, CQI_FACE + 4 * cqi_at_most(refused, 2) + cqi_at_most(same, 3), value == beside[i]))
            return beside[i];
        refused++;
    }
    return (int32_t)cqi_code_raw(d, (uint32_t)value, bits);
}

/* -- Materials: ranges of face numbers --
 *
 * The mesh has room for all faces from the start, and takes new ones from its stack of free faces. The slot that a face
 * is to get is put on that stack just before. */

#ifdef CQ_NO_WEDGES
#define cqi_code_base_material(d, input) 1
#define cqi_code_new_materials(d, p, q) 1
#define cqi_take_new_faces(d) ((void)0)
#define cqi_count_new_faces(d, is_counted) ((void)0)
#define cqi_show_materials(d) ((void)0)
#define cqi_next_of_material(d, f) (f)
#define cqi_next_coarse(d, f) (f)
#define cqi_face_of_component(d, n) (cq_index)((d)->mesh.num_faces + (n))
#define cqi_check_material_faces(d, corners) CQ_OK
#define cqi_step_materials(d) CQ_ERROR_UNSUPPORTED
#define cqi_aside_material(d, face) 1
#else

static cq_index cqi_end_of_material(const cq_decoder *d, uint32_t m)
{
    return m + 1 < d->shape.num_materials ? d->materials[m + 1].first : (cq_index)d->shape.num_faces;
}

/* The material of a face: the last one whose range does not begin after it. */
static uint32_t cqi_material_of(const cq_decoder *d, cq_index face)
{
    uint32_t low = 0, high = d->shape.num_materials;
    while (high - low > 1) {
        const uint32_t m = low + (high - low) / 2;
        if (d->materials[m].first <= face) low = m;
        else high = m;
    }
    return low;
}

static uint32_t cqi_plan_material(const cq_decoder *d, cq_index face)
{
    const cqi_plan *p = d->plan;
    return p->materials[p->face_of_input ? p->face_of_input[face] : face];
}

/* An encoder counts the faces of each material, in `shown`. */
static void cqi_count_materials(cq_decoder *d)
{
    cq_index f;
    for (f = 0; f < d->shape.num_faces; f++) d->materials[cqi_plan_material(d, f)].shown++;
}

/* The number of faces of the next material, of those that are left. The last material has the rest, without a code. */
static cq_result cqi_step_materials(cq_decoder *d)
{
    const uint32_t k = d->base.material++;
    cqi_material *m = &d->materials[k];
    uint32_t left = d->shape.num_faces - m->first, n;
    if (CQI_ENCODING(d) && !k) cqi_count_materials(d);
    n = m->shown;
    m->shown = 0;
    if (k + 1 == d->shape.num_materials) {
        memset(d->mesh.origin, 0xff, 3 * (size_t)d->shape.num_faces * sizeof(cq_index));
        d->base.draft.num_faces = (cq_index)d->shape.num_faces;
        d->phase = d->shape.num_vertices ? CQI_BASE : CQI_BASE_VALUES;
        return CQ_OK;
    }
    n = cqi_code_raw(d, n, cqi_bit_length(left));
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->base, NULL);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (n > left) return CQ_ERROR_CORRUPT;
    m[1].first = (cq_index)(m->first + (cq_index)n);
    CQI_TRACE(d, CQ_EVENT_MATERIAL, k + 1, m[1].first, 0);
    m[1].scan = (cq_index)(3 * m[1].first);
    return CQ_OK;
}

/* A material, given those of faces nearby; -1 if what was decoded is none. */
static int32_t cqi_code_material(cq_decoder *d, const int32_t *beside, int n, uint32_t material)
{
    const int32_t m = cqi_code_copy(d, cqi_bit_length(d->shape.num_materials - 1), beside, n, (int32_t)material);
    return m < (int32_t)d->shape.num_materials ? m : -1;
}

/* Gives the next face of the base, behind the gate, its slot. 0 if it cannot have one. */
static int cqi_code_base_material(cq_decoder *d, cq_index input)
{
    int32_t beside[2], m;
    cqi_material *of;
    int n = 0;
    if (cqi_is_real_face(&d->base.draft, d->base.gate))
        beside[n++] = (int32_t)cqi_material_of(d, (cq_index)(d->base.gate / 3));
    beside[n++] = d->base.last_face != CQ_NONE ? (int32_t)cqi_material_of(d, d->base.last_face) : 0;
    m = cqi_code_material(d, beside, n, CQI_ENCODING(d) ? cqi_plan_material(d, (cq_index)(input / 3)) : 0);
    if (m < 0) return 0;
    of = &d->materials[m];
    if (of->first + of->count == cqi_end_of_material(d, (uint32_t)m)) return 0;
    d->base.last_face = (cq_index)(of->first + of->count++);
    cqi_free_face(&d->base.draft, d->base.last_face);
    CQI_TRACE(d, CQ_EVENT_MATERIAL, m, d->base.last_face, 0);
    return 1;
}

/* Finds slots for the faces that a split at p, q is going to make, in the order of cqi_code_new_faces. */
static int cqi_code_new_materials(cq_decoder *d, int p, int q)
{
    int32_t m = 0, beside[3];
    int end, side, n;
    d->new_face[0] = d->new_face[1] = CQ_NONE;
    for (end = 0; end < 2; end++) {
        cq_index spoke = d->ring.spoke[end ? q : p];
        if (cq_is_virtual(&d->mesh, cq_target(&d->mesh, spoke))) continue;
        beside[0] = m;
        n = d->new_face[0] != CQ_NONE;
        for (side = 0; side < 2; side++, spoke = d->mesh.twin[spoke])
            if (cqi_is_real_face(&d->mesh, spoke)) beside[n++] = (int32_t)cqi_material_of(d, (cq_index)(spoke / 3));
        m = cqi_code_material(d, beside, n,
                              CQI_ENCODING(d) ? cqi_plan_material(d, d->plan->note[d->plan->next].face[end]) : 0);
        if (m < 0) return 0;
        d->new_face[end] = (cq_index)(d->materials[m].first + d->materials[m].count);
        if (d->new_face[0] != CQ_NONE && end && d->new_face[end] == d->new_face[0]) d->new_face[end]++;
        if (d->new_face[end] >= cqi_end_of_material(d, (uint32_t)m)) return 0;
        CQI_TRACE(d, CQ_EVENT_MATERIAL, m, d->new_face[end], 0);
    }
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->channels, &cqi_level_report(d)->values);
    return 1;
}

#ifndef CQ_NO_REGULAR
/* Takes the next free face of the material of face f, and counts it; or CQ_NONE. */
static cq_index cqi_next_of_material(const cq_decoder *d, cq_index f)
{
    const uint32_t k = cqi_material_of(d, f);
    cqi_material *const m = &d->materials[k];
    if (m->first + m->count == cqi_end_of_material(d, k)) return CQ_NONE;
    return (cq_index)(m->first + m->count++);
}

/* The next face of a regular level's coarse mesh, from f on. Those of a material end at its `scan`. */
static cq_index cqi_next_coarse(const cq_decoder *d, cq_index f)
{
    uint32_t k;
    for (k = d->materials ? cqi_material_of(d, f) : 0; d->materials && k < d->shape.num_materials; k++) {
        if (f < d->materials[k].scan) break;
        f = cqi_end_of_material(d, k);
    }
    return f;
}
#endif

/* Makes the two slots in new_face the next free faces of the mesh, the one at p first. */
static void cqi_take_new_faces(cq_decoder *d)
{
    int end;
    for (end = 1; end >= 0; end--)
        if (d->new_face[end] != CQ_NONE) cqi_free_face(&d->mesh, d->new_face[end]);
}

/* Counts the faces in new_face once the split has made them, unless they have been counted. */
static void cqi_count_new_faces(cq_decoder *d, int is_counted)
{
    int end;
    for (end = 0; end < 2; end++) {
        cqi_material *m;
        if (d->new_face[end] == CQ_NONE) continue;
        m = &d->materials[cqi_material_of(d, d->new_face[end])];
        m->count = (cq_index)(m->count + !is_counted);
        m->shown = m->count;
    }
}

/* Makes public what has been added to the base. */
static void cqi_show_materials(cq_decoder *d)
{
    uint32_t m;
    for (m = 0; d->materials && m < d->shape.num_materials; m++) d->materials[m].shown = d->materials[m].count;
}

/* Face n of the component that is being read, in the order of face numbers. Of each material, its faces are those that
 * are not yet shown. Call it with n = 0, 1, 2 .. in turn, and only as long as there is such a face. */
static cq_index cqi_face_of_component(const cq_decoder *d, cq_index n)
{
    const cqi_material *m = d->materials;
    cq_index f = 0;
    if (!m) return (cq_index)(d->mesh.num_faces + n);
    if (n) f = (cq_index)(d->base.valued_face + 1);
    for (m += cqi_material_of(d, f); f >= m->first + m->count || m->shown == m->count;) m++;
    return f < m->first + m->shown ? (cq_index)(m->first + m->shown) : f;
}

/* Are the twins of the component's faces right? Adds the number of their corners to *corners. */
static cq_result cqi_check_material_faces(const cq_decoder *d, cq_index *corners)
{
    cq_result result = CQ_OK;
    uint32_t k;
    for (k = 0; d->materials && k < d->shape.num_materials && result == CQ_OK; k++) {
        const cqi_material *m = &d->materials[k];
        const cq_index n = (cq_index)(m->count - m->shown);
        result = cqi_check_halfedges(&d->base.draft, (cq_index)(m->first + m->shown), n, NULL);
        *corners = (cq_index)(*corners + 3 * n);
    }
    return result;
}

/* The material of the next face aside, given that of the one before. Returns 0 if what was decoded is none. */
static int cqi_aside_material(cq_decoder *d, cq_index face)
{
    const cq_index k = (cq_index)d->aside.num_faces;
    const int32_t before = k ? (int32_t)d->aside.material[k - 1] : 0;
    const int32_t m = cqi_code_material(d, &before, 1, CQI_ENCODING(d) ? (uint32_t)d->plan->materials[face] : 0);
    d->aside.material[k] = (cq_index)m;
    return m >= 0;
}

#endif /* CQ_NO_WEDGES */

/* Number of faces that the mesh has so far, without gaps. */
static cq_index cqi_num_faces(const cq_decoder *d)
{
    cq_index n = 0;
    uint32_t k;
    if (!d->materials) return d->mesh.num_faces;
    for (k = 0; k < d->shape.num_materials; k++) n = (cq_index)(n + d->materials[k].shown);
    return n;
}

/* -- Base ------------------------------------------------------------------------------------------------------------
 *
 * Components come one after another, each grown face by face from the triangle of its first gate, in d->base.draft.
 * When its values are complete, d->mesh becomes the draft: so what a caller sees is always a mesh. While a component
 * grows, twin[] is a permutation: border halfedges form loops, twin[h] being the border halfedge after h. A loop that
 * has shrunk to two halfedges makes them each other's twins, just as in a mesh, so that gluing needs no step of its
 * own. The gate is a border halfedge u -> w; behind it follows a face w, u, x, and only x is coded:
 *
 *     grow    x is new
 *     turn    x is the start of the border halfedge before the gate: the face closes the fan of u
 *     close   x is the end of the one after the gate: the face closes the fan of w
 *     join    x is the end of any other border halfedge, whose number is coded: splits the loop, or merges two
 *
 * Growing a border by one of a few operations comes from the Cut-Border Machine (S. Gumhold, W. Strasser, 1998) and
 * Edgebreaker (J. Rossignac, 1999). */
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

/* A new vertex, real or, where that is allowed, virtual. CQ_NONE if there is no room. */
static cq_index cqi_code_base_vertex(cq_decoder *d, int may_be_virtual, int is_virtual)
{
    cq_mesh *m = &d->base.draft;
    cq_index v;
    may_be_virtual = may_be_virtual && m->num_virtual < m->max_virtual;
    is_virtual = may_be_virtual && cqi_code_bit(d, CQI_LOOP, is_virtual);
    v = is_virtual ? cqi_new_virtual(m) : cqi_new_vertex(m);
    if (v != CQ_NONE) m->valence[v] = 0;
    return v;
}

/* The same for a vertex with an input number, by which the encoder knows it. */
static cq_index cqi_code_new_vertex(cq_decoder *d, int may_be_virtual, cq_index input)
{
    cq_index v = cqi_code_base_vertex(d, may_be_virtual, CQI_ENCODING(d) && cq_is_virtual(&d->plan->mesh, input));
    if (CQI_ENCODING(d)) cqi_plan_vertex(d->plan, input, v);
    return v;
}

/* Adds face a, b, c without twins; `input` is its first halfedge in the encoder. CQ_NONE if there is no room. */
static cq_index cqi_add_face(cq_decoder *d, cq_index a, cq_index b, cq_index c, cq_index input)
{
    cq_mesh *m = &d->base.draft;
    const int is_virtual = cq_is_virtual(m, a) || cq_is_virtual(m, b) || cq_is_virtual(m, c);
    cq_index f;
    if (d->materials && !is_virtual && !cqi_code_base_material(d, input)) return CQ_NONE;
    f = cqi_new_face(m, is_virtual);
    if (f == CQ_NONE) return CQ_NONE;
    d->base.faces = (cq_index)(d->base.faces + !is_virtual);
    cqi_set_face(m, f, a, b, c);
    m->valence[a]++;
    m->valence[b]++;
    m->valence[c]++;
    m->out[a] = (cq_index)(3 * f);
    m->out[b] = (cq_index)(3 * f + 1);
    m->out[c] = (cq_index)(3 * f + 2);
    if (CQI_ENCODING(d)) cqi_plan_face(d->plan, input, f);
    CQI_TRACE(d, CQ_EVENT_TRIANGLE, a, b, c);
    return f;
}

#define CQI_SEED 0x40 /* bit of mark[v]: v is the L of its component's first gate, v + 1 the R */

/* The first triangle L, R, X of a component. L -> R is the gate that grows first. */
static cq_result cqi_start_component(cq_decoder *d)
{
    cq_mesh *m = &d->base.draft;
    cq_index v[3] = { CQ_NONE, CQ_NONE, CQ_NONE }, input = 0, corner = 0, f, h;
    int k;
    if (CQI_ENCODING(d)) input = cqi_plan_seed(d->plan);
    for (k = 0; k < 3; k++) {
        if (CQI_ENCODING(d)) corner = d->plan->mesh.origin[cqi_corner(input, k)];
        v[k] = cqi_code_new_vertex(d, k == 2, corner);
        if (v[k] == CQ_NONE || cqi_starved(d)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
    }
    d->base.gate = 3 * m->first_virtual_face; /* there is none before the first face */
    f = cqi_add_face(d, v[0], v[1], v[2], input);
    if (f == CQ_NONE || cqi_starved(d)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
    m->mark[v[0]] |= CQI_SEED;
    h = (cq_index)(3 * f);
    m->twin[h] = (cq_index)(h + 1);
    m->twin[h + 1] = (cq_index)(h + 2);
    m->twin[h + 2] = h;
    d->base.gate = h;
    d->base.before = (cq_index)(h + 2);
    d->base.before2 = (cq_index)(h + 1);
    return CQ_OK;
}

/* Halfedges of the draft, numbered without a gap: real ones, then virtual ones. */
static cq_index cqi_num_halfedges(const cq_mesh *m) { return (cq_index)(3 * (m->num_faces + m->num_virtual_faces)); }

static cq_index cqi_nth_halfedge(const cq_mesh *m, cq_index n)
{
    return (cq_index)(n < 3 * m->num_faces ? n : n - 3 * m->num_faces + 3 * m->first_virtual_face);
}

static cq_index cqi_halfedge_number(const cq_mesh *m, cq_index h)
{
    return (cq_index)(h < 3 * m->num_faces ? h : h - 3 * m->first_virtual_face + 3 * m->num_faces);
}

/* The kind of the gate, and for a join the border halfedge, which an encoder passes in. */
static int cqi_code_gate(cq_decoder *d, int kind, cq_index *border)
{
    const cq_mesh *m = &d->base.draft;
    cq_index u = m->valence[m->origin[d->base.gate]], w = m->valence[cq_target(m, d->base.gate)], n;
    u = u < 7 ? u : 7;
    w = w < 7 ? w : 7;
    if (cqi_code_bit(d, CQI_KIND_GROW + (int)(8 * u + w), kind == CQI_GROW)) return CQI_GROW;
    if (cqi_code_bit(d, CQI_KIND_TURN + (int)u, kind == CQI_TURN)) return CQI_TURN;
    if (cqi_code_bit(d, CQI_KIND_CLOSE + (int)w, kind == CQI_CLOSE)) return CQI_CLOSE;
    n = CQI_ENCODING(d) ? cqi_halfedge_number(m, *border) : 0;
    n = (cq_index)cqi_code_raw(d, n, cqi_bit_length((uint32_t)cqi_num_halfedges(m) - 1));
    *border = n < cqi_num_halfedges(m) ? cqi_nth_halfedge(m, n) : d->base.gate;
    if (m->origin[*border / 3 * 3] == CQ_NONE) *border = d->base.gate; /* a face that is not there */
    return CQI_JOIN;
}

/* What the encoder sees behind the gate: the kind, x, and the border halfedge that ends at x. */
static int cqi_plan_gate(const cq_decoder *d, cq_index behind, cq_index *apex, cq_index *border)
{
    const cqi_plan *p = d->plan;
    *apex = p->mesh.origin[cq_prev(behind)];
    if (p->decoded[*apex] == CQ_NONE) return CQI_GROW;
    if (cqi_plan_to_decoded(p, p->mesh.twin[cq_next(behind)]) == d->base.before) return CQI_TURN;
    *border = cqi_plan_border(p, cq_prev(behind));
    return *border == d->base.draft.twin[d->base.gate] ? CQI_CLOSE : CQI_JOIN;
}

/* Links the new face w, u, x, with halfedge k = w -> u, into the border. `border` ends at x; CQ_NONE if x is new. */
static void cqi_link_face(cq_decoder *d, cq_index k, cq_index border)
{
    cq_mesh *m = &d->base.draft;
    cq_index u_to_x = (cq_index)(k + 1), x_to_w = (cq_index)(k + 2), after = m->twin[d->base.gate];
    m->twin[u_to_x] = border == CQ_NONE ? x_to_w : m->twin[border];
    m->twin[d->base.before] = u_to_x;
    if (border != CQ_NONE) m->twin[border] = x_to_w;
    m->twin[x_to_w] = after;
    cqi_set_twins(m, d->base.gate, k);
}

/* The first open halfedge from *scan on becomes the second one before the gate. Closed halfedges never open again, so
 * that all scans together take linear time. */
static int cqi_scan_gate(cq_decoder *d, cq_index *scan, cq_index end)
{
    const cq_mesh *m = &d->base.draft;
    while (*scan < end && !cqi_is_open(m, *scan)) ++*scan;
    if (*scan == end) return 0;
    d->base.before2 = *scan;
    d->base.before = m->twin[d->base.before2];
    d->base.gate = m->twin[d->base.before];
    return 1;
}

/* Finds a gate on another loop. 0 if there is none: the component is complete. */
static int cqi_find_gate(cq_decoder *d)
{
    cq_index virtual_end = (cq_index)(3 * (d->base.draft.first_virtual_face + d->base.draft.num_virtual_faces));
    uint32_t k;
    for (k = 0; d->materials && k < d->shape.num_materials; k++) {
        cqi_material *of = &d->materials[k];
        if (cqi_scan_gate(d, &of->scan, (cq_index)(3 * (of->first + of->count)))) return 1;
    }
    if (d->materials) return cqi_scan_gate(d, &d->base.virtual_scan, virtual_end);
    return cqi_scan_gate(d, &d->base.scan, (cq_index)(3 * d->base.draft.num_faces)) ||
           cqi_scan_gate(d, &d->base.virtual_scan, virtual_end);
}

/* Adds the face behind the gate, and finds the next gate: at u again, or past w once u is closed. */
static cq_result cqi_grow_base(cq_decoder *d)
{
    cq_mesh *m = &d->base.draft;
    cq_index u = m->origin[d->base.gate], w = cq_target(m, d->base.gate), x, border = CQ_NONE;
    cq_index behind = 0, apex = 0, f, k;
    int kind = CQI_GROW;
    if (CQI_ENCODING(d)) {
        behind = d->plan->mesh.twin[cqi_plan_to_input(d->plan, d->base.gate)];
        kind = cqi_plan_gate(d, behind, &apex, &border);
    }
    kind = cqi_code_gate(d, kind, &border);
    if (kind == CQI_TURN) border = d->base.before2;
    if (kind == CQI_CLOSE) border = m->twin[d->base.gate];
    if (kind == CQI_GROW) {
        border = CQ_NONE;
        x = cqi_code_new_vertex(d, !cq_is_virtual(m, u) && !cq_is_virtual(m, w), apex);
    } else {
        x = cqi_is_open(m, border) ? cq_target(m, border) : u;
    }
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (x == CQ_NONE || x == u || x == w) return CQ_ERROR_CORRUPT;
    f = cqi_add_face(d, w, u, x, behind);
    if (f == CQ_NONE || cqi_starved(d)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
    k = (cq_index)(3 * f);
    cqi_link_face(d, k, border);
    if (kind == CQI_TURN) {
        d->base.before2 = border;
        d->base.before = (cq_index)(k + 2);
        d->base.gate = m->twin[d->base.before];
    } else {
        d->base.gate = (cq_index)(k + 1);
    }
    return CQ_OK;
}

/* Does the complete base have the header's number of boundary loops and Euler characteristic? */
static int cqi_base_fits(const cq_decoder *d)
{
    const cq_mesh *m = &d->base.draft;
    const cq_shape *s = &d->shape;
    const int64_t euler = 2 * (int64_t)m->num_vertices - d->base.faces - (int64_t)m->num_virtual_faces;
    const int64_t full = 2 * (int64_t)s->num_vertices - s->num_faces - (int64_t)s->num_boundary_edges;
    return m->num_virtual == m->max_virtual && euler == full;
}

/* All faces of a component are there: is it a mesh? d->mesh has the components before it, with which it shares nothing,
 * as only open halfedges are glued, and they have none left. */
static cq_result cqi_finish_component(const cq_decoder *d)
{
    const cq_mesh *m = &d->mesh;
    cq_index corners = 0;
    cq_result result = cqi_check_material_faces(d, &corners);
    if (result == CQ_OK)
        result = cqi_check_from(&d->base.draft, m->num_vertices, d->materials ? d->base.draft.num_faces : m->num_faces,
                                m->num_virtual, m->num_virtual_faces, corners, NULL);
    return result == CQ_OK && (d->base.more || cqi_base_fits(d)) ? CQ_OK : CQ_ERROR_CORRUPT;
}

/* -- Values ----------------------------------------------------------------------------------------------------------
 *
 * A collapse of B into A leaves the values of A as they are, so that a split only has the values of B to code: those of
 * all other vertices are final. */

#define CQI_WILD 0x4000000 /* beyond any difference of values: stands for residuals that no encoder writes */

/* Exact values are any 32 bits. cqi_number maps them to integers that are in the order of the floats, and back; the
 * upper 24 bits of these take part in predictions (cqi_rough, cqi_unrough). Other channels' values stay as they are. */
static int cqi_is_exact(const cq_channel *c)
{
    return CQI_HAS_ATTRIBUTES && CQ_MAX_BITS >= 24 && c->bits == CQ_EXACT_BITS;
}
static int32_t cqi_number(const cq_channel *c, int32_t x) { return cqi_is_exact(c) && x < 0 ? x ^ 0x7fffffff : x; }

static int32_t cqi_rough(const cq_channel *c, int32_t x)
{
    return cqi_is_exact(c) ? cqi_floor_shift(cqi_number(c, x), 8) : x;
}

static int32_t cqi_unrough(const cq_channel *c, int32_t x)
{
    return cqi_is_exact(c) ? (int32_t)((uint32_t)x << 8) : x;
}

/* A number 0 .. 38: asks up to seven times whether it is larger still, each time with a model of its own; after
 * the seventh yes, 5 raw bits follow. */
static inline int cqi_code_count(cq_decoder *d, int index, int count)
{
    int k = 0;
    while (k < 7 && cqi_code_bit(d, index + k, count > k)) k++;
    return k < 7 ? k : 7 + (int)cqi_code_raw(d, (uint32_t)(count - 7), 5);
}

/* Number of bits of a magnitude, as its difference from the number that is expected. */
static int cqi_code_bits(cq_decoder *d, int index, int expected, int bits)
{
    int less;
    if (!expected || cqi_code_bit(d, index, bits >= expected))
        return expected + cqi_code_count(d, index + 1, bits - expected);
    less = 1 + cqi_code_count(d, index + 8, expected - 1 - bits);
    return less < expected ? expected - less : 0;
}

/* The most bits that a residual of the channel may have. */
static int cqi_most_bits(const cq_channel *c) { return cqi_is_exact(c) ? 32 : 26; }

/* The bits of a magnitude below the highest one, and the sign. The second highest bit has a model, by kind and by the
 * number of bits up to 26; so has the sign of small residuals whose prediction had a fraction (in quarters; -1: it had
 * none). All others are raw. */
static inline int32_t cqi_code_low_bits(cq_decoder *d, int kind, int bits, uint32_t magnitude, int negative, int fraction)
{
    const int modelled = bits <= 3 && fraction >= 0, low = bits > 2 ? bits - 2 : 0;
    uint32_t x = 1, raw = magnitude & (((uint32_t)1 << low) - 1);
    if (bits > 1) {
        const int top = kind + CQI_TOP + cqi_at_most(bits, 26) - 2;
        x = 2 | (uint32_t)cqi_code_bit(d, top, (int)(magnitude >> low & 1));
    }
    if (modelled) negative = cqi_code_bit(d, CQI_SIGN_SMALL + 4 * (bits - 1) + fraction, negative);
    else raw |= (uint32_t)negative << low;
    if (low || !modelled) raw = cqi_code_raw(d, raw, low + !modelled);
    if (!modelled) negative = (int)(raw >> low);
    x = x << low | (raw & (((uint32_t)1 << low) - 1));
    return (int32_t)cqi_negated(x, negative);
}

/* A residual: number of bits, magnitude and sign. kind: its tables of models; row: the one for the number of bits. */
static int32_t cqi_code_residual(cq_decoder *d, int kind, int row, int expected, int most, int fraction,
                                 int32_t residual)
{
    const uint32_t magnitude = CQI_ENCODING(d) ? cqi_abs(residual) : 0;
    const int bits = cqi_code_bits(d, kind + CQI_BITS + 16 * row, expected, cqi_bit_length(magnitude));
    if (bits == 0) return 0;
    if (bits > most) return CQI_WILD;
    return cqi_code_low_bits(d, kind, bits, magnitude, residual < 0, fraction);
}

/* A residual, of which half_bits / 2 bits are expected. */
static int32_t cqi_code_expected(cq_decoder *d, int kind, int half_bits, int most, int fraction, int32_t residual)
{
    const int limit = CQI_EXPECTED - 2, row = half_bits < limit ? half_bits : limit + half_bits % 2;
    return cqi_code_residual(d, kind, row, half_bits >> 1, most, fraction, residual);
}

/* Twice the base-2 logarithm of x, as a number of bits: what to expect of a residual of this size, in half bits. */
static int cqi_half_bits(uint32_t x) { return x < 0x8000 ? cqi_bit_length(x * x) : 2 * cqi_bit_length(x); }

static int cqi_value_fits(const cq_channel *c, int32_t value)
{
    return cqi_is_exact(c) || (value >= 0 && value >> c->bits == 0);
}

/* Stores what was expected plus a residual, unless it is out of range: then returns 0. */
static int cqi_store_value(const cq_channel *c, int32_t expected, int32_t residual, cq_value *to)
{
    const int32_t x = cqi_number(c, cqi_sum(expected, residual));
    if (!cqi_value_fits(c, x)) return 0;
    *to = (cq_value)x;
    return 1;
}

/* Component c of channel k of an input vertex or wedge, as the caller of the encoder has it; */
static int32_t cqi_plan_bits(const cq_decoder *d, uint32_t k, uint32_t c, cq_index input)
{
    const cqi_plan *p = d->plan;
    if (p->row_of_vertex)
        input = cqi_class(&d->shape, k) == CQI_OF_ROW ? p->row_of_wedge[input] : p->row_of_vertex[input];
    return p->input[k][(size_t)input * d->shape.channel[k].components + c];
}

/* and as an integer in the order of the floats. */
static int32_t cqi_plan_value(const cq_decoder *d, uint32_t k, uint32_t c, cq_index input)
{
    return cqi_number(&d->shape.channel[k], cqi_plan_bits(d, k, c, input));
}

enum { CQI_FACE_ASIDE = 1, CQI_FACE_TURNED = 2 }; /* bits of the state of a face */
static int32_t cqi_plan_of_face(const cq_decoder *d, uint32_t k, cq_index face)
{
    const cqi_plan *p = d->plan;
    if (p->face_of_input) face = p->face_of_input[face];
    return d->shape.channel[k].kind == CQ_TURNED ? (p->face_state[face] & CQI_FACE_TURNED) != 0 : p->input[k][face];
}

/* Base values are predicted by the mean of the neighbours that are known, those with lower numbers; at most 64. */
static int32_t cqi_predict_base(const cq_decoder *d, const cq_channel *channel, const cq_value *values, cq_index v)
{
    const cq_mesh *m = &d->base.draft;
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

/* A residual, given the running mean *size of those before, which it updates. */
static int32_t cqi_code_base_residual(cq_decoder *d, const cq_channel *channel, int32_t x, int32_t *size)
{
    x = cqi_code_residual(d, CQI_OF_BASE, 0, cqi_bit_length((uint32_t)*size), cqi_most_bits(channel), -1, x);
    *size = (3 * *size + (int32_t)(cqi_abs(x) >> 28 ? (uint32_t)1 << 28 : cqi_abs(x))) / 4;
    return x;
}

/* Component c of channel k of base vertex v. */
static int cqi_code_base_value(cq_decoder *d, uint32_t k, uint32_t c, cq_index v, int32_t *size)
{
    const cq_channel *channel = &d->shape.channel[k];
    const uint32_t stride = channel->components;
    cq_value *values = d->channel[k] + c;
    int32_t p = cqi_predict_base(d, channel, values, v), x = 0;
    if (CQI_ENCODING(d)) x = cqi_difference(cqi_plan_value(d, k, c, d->plan->to_input[v]), p);
    return cqi_store_value(channel, p, cqi_code_base_residual(d, channel, x, size), values + (size_t)v * stride);
}

/* -- Values of faces: mostly equal to that of a face nearby --
 *
 * Materials of faces, see above, are coded in the same way. */

/* Channel k of base face f, given the value of the face before it. */
static void cqi_code_base_face(cq_decoder *d, uint32_t k, cq_index f)
{
    cq_value *values = d->channel[k];
    int32_t before = d->base.valued_face != CQ_NONE ? values[d->base.valued_face] : 0, x = 0;
    if (CQI_ENCODING(d)) x = cqi_plan_of_face(d, k, (cq_index)(d->plan->face_input[f] / 3));
    values[f] = (cq_value)cqi_code_copy(d, d->shape.channel[k].bits, &before, 1, x);
    CQI_TRACE(d, CQ_EVENT_FACE, k, f, values[f]);
}

/* All channels of the component's next vertex or face. */
static cq_result cqi_code_base_values(cq_decoder *d)
{
    const cq_index vertices = (cq_index)(d->base.draft.num_vertices - d->mesh.num_vertices);
    const int of_face = d->base.value >= vertices;
    const cq_index v = of_face ? cqi_face_of_component(d, (cq_index)(d->base.value - vertices))
                               : (cq_index)(d->mesh.num_vertices + d->base.value);
    uint32_t k, c;
    d->base.value++;
    for (k = 0; k < d->shape.num_channels; k++) {
        const int begins = d->base.value == 1 && v; /* another component, perhaps far away */
        int32_t *size = (begins ? d->now.base.first : d->now.base.size) + k * CQ_MAX_COMPONENTS;
        if (cqi_class(&d->shape, k) != (of_face ? CQI_OF_FACE : CQI_OF_VERTEX)) continue;
        if (of_face) cqi_code_base_face(d, k, v);
        for (c = 0; c < d->shape.channel[k].components && !of_face; c++)
            if (!cqi_code_base_value(d, k, c, v, size++)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
        CQI_TRACE_IF(!of_face, d, CQ_EVENT_VALUES, k, v, 0);
        cqi_charge_channel(d, k);
    }
    if (of_face) d->base.valued_face = v;
    return cqi_starved(d) ? CQ_TRUNCATED : CQ_OK;
}

/* Channel k of the faces that a split at p, q is going to make, the one at p first, given the values of the faces that
 * they will share an edge with. Virtual faces have none. */
static CQI_APART void cqi_code_new_faces(cq_decoder *d, uint32_t k, int p, int q)
{
    const cq_mesh *m = &d->mesh;
    cq_value *values = d->channel[k];
    cq_index f = m->num_faces;
    int32_t x = 0, beside[3];
    int end, side, n;
    for (end = 0; end < 2; end++) {
        cq_index spoke = d->ring.spoke[end ? q : p];
        if (cq_is_virtual(m, cq_target(m, spoke))) continue;
        beside[0] = x;
        n = f > m->num_faces;
        for (side = 0; side < 2; side++, spoke = m->twin[spoke])
            if (cqi_is_real_face(m, spoke)) beside[n++] = values[spoke / 3];
        if (CQI_ENCODING(d)) x = cqi_plan_of_face(d, k, d->plan->note[d->plan->next].face[end]);
        x = cqi_code_copy(d, d->shape.channel[k].bits, beside, n, x);
        CQI_TRACE(d, CQ_EVENT_FACE, k, d->materials ? d->new_face[end] : f, x);
        if (d->materials) values[d->new_face[end]] = (cq_value)x;
        else if (f < m->first_virtual_face) values[f] = (cq_value)x; /* else the split will fail */
        f++;
    }
}

/* -- Vectors and other arithmetic --
 *
 * In integers, as everything that decides bytes must be the same on every machine. */

static inline cqi_vector cqi_plus(cqi_vector a, cqi_vector b)
{
    a.x += b.x;
    a.y += b.y;
    a.z += b.z;
    return a;
}

static inline cqi_vector cqi_minus(cqi_vector a, cqi_vector b)
{
    a.x -= b.x;
    a.y -= b.y;
    a.z -= b.z;
    return a;
}

static inline cqi_vector cqi_absolute(cqi_vector a)
{
    a.x = (int32_t)cqi_abs(a.x);
    a.y = (int32_t)cqi_abs(a.y);
    a.z = (int32_t)cqi_abs(a.z);
    return a;
}

static inline cqi_vector cqi_scale(cqi_vector a, int32_t factor)
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

static inline cqi_vector cqi_cross(cqi_vector a, cqi_vector b)
{
    cqi_vector n;
    n.x = a.y * b.z - a.z * b.y;
    n.y = a.z * b.x - a.x * b.z;
    n.z = a.x * b.y - a.y * b.x;
    return n;
}

static int64_t cqi_wide_dot(cqi_vector a, cqi_vector b)
{
    return (int64_t)a.x * b.x + (int64_t)a.y * b.y + (int64_t)a.z * b.z;
}

static inline int32_t cqi_dot(cqi_vector a, cqi_vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* The length, within 10 % except for tiny vectors; without a square root, and without overflow below 2^26. */
static inline int32_t cqi_norm(cqi_vector a)
{
    const int32_t x = (int32_t)cqi_abs(a.x), y = (int32_t)cqi_abs(a.y), z = (int32_t)cqi_abs(a.z);
    int32_t largest = x > y ? x : y;
    largest = largest > z ? largest : z;
    return (int32_t)((uint32_t)(11 * largest + 5 * (x + y + z)) >> 4);
}

static inline int32_t cqi_clamp(int32_t x, int32_t low, int32_t high) { return x < low ? low : x > high ? high : x; }

/* a b / 2^shift, rounded down. */
static inline int32_t cqi_product(int32_t a, int32_t b, int shift)
{
    return (int32_t)cqi_floor_shift_wide((int64_t)a * b, shift);
}

/* a / n, toward zero. */
static inline cqi_vector cqi_part(cqi_vector a, int32_t n)
{
    a.x /= n;
    a.y /= n;
    a.z /= n;
    return a;
}

static inline cqi_vector cqi_offset(const cq_value *positions, cq_index from, cq_index to)
{
    const cq_value *a = positions + 3 * (size_t)from, *b = positions + 3 * (size_t)to;
    cqi_vector x;
    x.x = (int32_t)b[0] - a[0];
    x.y = (int32_t)b[1] - a[1];
    x.z = (int32_t)b[2] - a[2];
    return x;
}

/* The square root, rounded down, bit by bit. */
static uint32_t cqi_square_root(uint64_t x)
{
    uint64_t root = 0, bit = x ? (uint64_t)1 << ((cqi_bit_length_wide(x) - 1) & ~1) : 0;
    for (; bit; bit >>= 2) { /* without a branch, which would be taken half of the time */
        const uint64_t here = root + bit, fits = (uint64_t)0 - (x >= here);
        x -= here & fits;
        root = (root >> 1) + (bit & fits);
    }
    return (uint32_t)root;
}

/* Base-2 logarithm of x > 0, in 1/8. */
static inline int cqi_logarithm(uint32_t x)
{
    const int zeros = 32 - cqi_bit_length(x); /* the top four bits after them are 8 .. 15 */
    return 8 * (30 - zeros) + (int)(x << zeros >> 28);
}

/* x in the scale of a ring, times 2^shift; and back, rounded to the nearest. */
static inline int32_t cqi_scaled(int32_t x, const cqi_ring *r) { return cqi_floor_shift(x * r->factor, r->right); }

static inline int32_t cqi_unscaled(int32_t x, int shift)
{
    if (shift <= 0) return x * ((int32_t)1 << -shift);
    return cqi_floor_shift(x + ((int32_t)1 << (shift - 1)), shift);
}

/* Moves a weight, modulo 2^16. */
static inline void cqi_nudge(int16_t *weight, int32_t by)
{
    *weight = (int16_t)((int32_t)((uint32_t)(*weight + by + 0x8000) & 0xffff) - 0x8000);
}

/* Adapts a weight of a linear prediction: it moves by a constant step in the direction of the sign of error times input
 * (sign-sign LMS); without a branch, as the processor cannot predict that sign. */
#define CQI_LINEAR_BITS 13 /* such weights are in 2^-13, between -4 and 4 */
#define CQI_LINEAR_STEP 25
static inline void cqi_follow(int16_t *weight, int64_t product)
{
    cqi_nudge(weight, CQI_TUNED(linear, CQI_LINEAR_STEP) * ((product > 0) - (product < 0)));
}

/* -- Positions: what the neighbours of B tell --
 *
 * Once the pair is known, so are B's neighbours: A, and those from p to q. All are relative to A, in the scale of A's
 * ring, and with their components in another order: z is nearest to the normal of the fan. It is coded last, and
 * predicted above the fan's plane at the x and y that are known by then: a shear instead of a rotation, so that all is
 * exact in integers (A. Paeth, "A Fast Algorithm for General Raster Rotation", 1986). */

/* x, y, or from 2 on z. */
static inline int32_t cqi_component(cqi_vector a, int k) { return k == 0 ? a.x : k == 1 ? a.y : a.z; }

/* The components in the cyclic order in which component `last` is the last. */
static inline cqi_vector cqi_in_cycle(cqi_vector a, int last)
{
    cqi_vector b = a;
    if (last == 2) return a;
    if (last == 1) {
        b.x = a.z;
        b.y = a.x;
        b.z = a.y;
    } else {
        b.x = a.y;
        b.y = a.z;
        b.z = a.x;
    }
    return b;
}

/* And back in their own order. */
static inline cqi_vector cqi_out_of_cycle(cqi_vector a, int last) { return cqi_in_cycle(a, last == 2 ? 2 : 1 - last); }

/* B's neighbours are A and those of the ring from p to q, but for a virtual one. */
static void cqi_size_fan(const cqi_ring *r, cqi_fan *f, int p, int q)
{
    f->boundary = r->boundary >= p && r->boundary <= q;
    f->size = q - p + 2 - f->boundary;
}

/* The plane, normal to the sum of the areas of A's triangles between p and q; the order of the axes; and the sum of the
 * offsets of B's neighbours, in which A and a virtual vertex are 0. */
static cqi_vector cqi_find_plane(const cqi_ring *r, cqi_fan *f, int p, int q)
{
    cqi_vector normal = { 0, 0, 0 }, sum = r->at[p], a = cqi_shift(sum, 4);
    uint32_t all;
    int k;
    for (k = p + 1; k <= q; k++) {
        const cqi_vector b = cqi_shift(r->at[k], 4);
        sum = cqi_plus(sum, r->at[k]);
        normal = cqi_plus(normal, cqi_cross(a, b));
        if (k != r->boundary) a = b;
    }
    all = cqi_fold_sign(normal.x) | cqi_fold_sign(normal.y) | cqi_fold_sign(normal.z);
    normal = cqi_shift(normal, 1 + cqi_bit_length(all >> 20));
    a = cqi_absolute(normal);
    f->above = a.z > a.x && a.z > a.y ? 2 : a.y > a.x;
    normal = cqi_in_cycle(normal, f->above);
    f->slope_x = normal.z ? -(normal.x * 256 / normal.z) : 0;
    f->slope_y = normal.z ? -(normal.y * 256 / normal.z) : 0;
    return sum;
}

/* Height above the plane, which goes through A. */
static inline int32_t cqi_height(const cqi_fan *f, cqi_vector a)
{
    return a.z - cqi_floor_shift(f->slope_x * a.x + f->slope_y * a.y, 8);
}

/* Finds the offset from A of a vertex beyond the ring. Returns 0 if the vertex is, along some axis, at least twice as
 * far away as one of the ring can be: then it tells nothing. */
static inline int cqi_locate_beyond(const cqi_ring *r, const cq_value *a, const cq_value *b, cqi_vector *x)
{
    const uint32_t limit = (uint32_t)2 << CQI_RING_BITS;
    x->x = cqi_scaled((int32_t)b[0] - a[0], r);
    x->y = cqi_scaled((int32_t)b[1] - a[1], r);
    x->z = cqi_scaled((int32_t)b[2] - a[2], r);
    return (((uint32_t)x->x + limit) | ((uint32_t)x->y + limit) | ((uint32_t)x->z + limit)) < 2 * limit;
}

/* Takes note of what lies beyond edge k of B's ring. Returns 1. */
static inline int cqi_add_beyond(const cqi_fan *f, int k, cqi_vector *sum, uint32_t *known)
{
    *sum = cqi_plus(*sum, f->outer[k]);
    *known |= (uint32_t)1 << k;
    return 1;
}

/* Feature 0: the mean of what lies beyond the edges of B's ring. Beyond the two edges at A are vertices of A's ring. A
 * boundary leaves a gap in B's ring, beyond which nothing is known. */
static void cqi_look_beyond(const cq_decoder *d, cqi_fan *f, const cq_value *values, cqi_vector mean, int p, int q)
{
    const cqi_ring *const r = &d->ring;
    const cq_value *const a = values + 3 * (size_t)d->mesh.origin[r->spoke[0]];
    const int before = cqi_previous_of(p, r->size), after = cqi_next_of(q, r->size);
    const cqi_vector none = { 0, 0, 0 };
    cqi_vector sum = none;
    uint32_t known = 0;
    int num_known = 0, k;
    if (!f->boundary) {
        f->outer[0] = r->at[before];
        f->outer[q - p + 1] = r->at[after];
        if (before != r->boundary) num_known += cqi_add_beyond(f, 0, &sum, &known);
        if (after != r->boundary) num_known += cqi_add_beyond(f, q - p + 1, &sum, &known);
        for (k = p; k < q; k++) {
            const cq_index v = r->front[k];
            if (!cq_is_virtual(&d->mesh, v) && cqi_locate_beyond(r, a, values + 3 * (size_t)v, &f->outer[k - p + 1]))
                num_known += cqi_add_beyond(f, k - p + 1, &sum, &known);
        }
    }
    f->known = known;
    f->feature[0] = cqi_in_cycle(num_known ? cqi_minus(cqi_part(sum, num_known), mean) : none, f->above);
}

/* Offsets of B's neighbours and of the vertices beyond, along the fan's axes. */
static void cqi_turn_fan(const cqi_ring *r, cqi_fan *f, int p, int q)
{
    int k, n = 1;
    f->at[0].x = f->at[0].y = f->at[0].z = 0;
    for (k = p; k <= q; k++)
        if (k != r->boundary) f->at[n++] = cqi_in_cycle(r->at[k], f->above);
    for (k = 0; k < n; k++) f->outer[k] = cqi_in_cycle(f->outer[k], f->above);
}

/* -- Positions: a linear prediction --
 *
 * The mean of B's neighbours, plus a weighted sum of features: other predictions, minus that mean. The weights along
 * the surface differ from those above it. */

/* What to expect of residuals, from how far the neighbours are from their mean along each axis. */
#define CQI_LESS 4        /* x, y: this many half bits less than three times the mean distance has */
#define CQI_LESS_ABOVE 5  /* z: this many half bits less than the mean distances along all axes together have */
static void cqi_expect_residuals(const cqi_ring *r, cqi_fan *f, cqi_vector mean, int p, int q)
{
    const cqi_vector none = { 0, 0, 0 };
    cqi_vector extent = f->boundary ? none : cqi_absolute(mean); /* of A, at 0; a virtual vertex stands in for it */
    int k;
    for (k = p; k <= q; k++) extent = cqi_plus(extent, cqi_absolute(cqi_minus(r->at[k], mean)));
    extent = cqi_in_cycle(cqi_part(extent, f->size), f->above);
    f->extent = extent.x + extent.y + extent.z;
    f->expected[0] = cqi_half_bits(3 * (uint32_t)extent.x) - 2 * r->shift - CQI_LESS;
    f->expected[1] = cqi_half_bits(3 * (uint32_t)extent.y) - 2 * r->shift - CQI_LESS;
    f->expected[2] = cqi_half_bits((uint32_t)f->extent) - 2 * r->shift - CQI_LESS_ABOVE;
}

/* The mean of B's neighbours; and features 1: A; 2: the middle between the two common neighbours. */
static void cqi_find_features(cq_decoder *d, cqi_fan *f, const cq_value *values, int p, int q)
{
    const cqi_ring *const r = &d->ring;
    const cqi_vector none = { 0, 0, 0 };
    cqi_vector mean, middle;
    cqi_size_fan(&d->ring, f, p, q);
    mean = cqi_part(cqi_find_plane(r, f, p, q), f->size);
    middle = cqi_minus(cqi_shift(cqi_plus(r->at[p], r->at[q]), 1), mean);
    cqi_look_beyond(d, f, values, mean, p, q);
    cqi_expect_residuals(r, f, mean, p, q);
    f->mean = cqi_in_cycle(mean, f->above);
    f->feature[1] = cqi_minus(none, f->mean);
    f->feature[2] = f->boundary ? none : cqi_in_cycle(middle, f->above);
}

/* Weights differ by the number of neighbours; class 0: an incomplete ring. */
static int cqi_fan_class(const cqi_fan *f) { return f->boundary || f->size < 3 ? 0 : cqi_at_most(f->size, 9) - 2; }

/* The linear prediction, and its height above the plane through the mean. */
static void cqi_predict_linear(const cqi_model *m, cqi_fan *f)
{
    const int16_t *const along = m->linear + CQI_FEATURES * cqi_fan_class(f);
    const int16_t *const above = along + CQI_FEATURES * CQI_FAN_CLASSES;
    cqi_vector x = { 0, 0, 0 };
    int64_t sum_x = 0, sum_y = 0, rise = 0;
    int k;
    for (k = 0; k < CQI_FEATURES; k++) {
        const cqi_vector v = f->feature[k];
        f->height[k] = cqi_height(f, v);
        sum_x += (int64_t)along[k] * v.x;
        sum_y += (int64_t)along[k] * v.y;
        rise += (int64_t)above[k] * f->height[k];
    }
    x.x = (int32_t)cqi_floor_shift_wide(sum_x, CQI_LINEAR_BITS);
    x.y = (int32_t)cqi_floor_shift_wide(sum_y, CQI_LINEAR_BITS);
    f->rise = (int32_t)cqi_floor_shift_wide(rise, CQI_LINEAR_BITS);
    f->linear = cqi_plus(f->mean, x);
}

/* Adapts the weights, once B's place and its height above the plane through the mean are known. */
static void cqi_learn_linear(cqi_model *m, const cqi_fan *f, cqi_vector place, int32_t rise)
{
    int16_t *const along = m->linear + CQI_FEATURES * cqi_fan_class(f);
    int16_t *const above = along + CQI_FEATURES * CQI_FAN_CLASSES;
    const cqi_vector error = cqi_minus(place, f->linear);
    int k;
    for (k = 0; k < CQI_FEATURES; k++) {
        const cqi_vector v = f->feature[k];
        cqi_follow(&along[k], (int64_t)error.x * v.x + (int64_t)error.y * v.y);
        cqi_follow(&above[k], (int64_t)(rise - f->rise) * f->height[k]);
    }
}

/* -- Positions: predictions that compete --
 *
 * On surfaces that were made by rules, one of a few simple predictions is often exact, and then several agree. So each
 * prediction votes for those near it, and the one with the most votes is asked about first. */

/* Adds a prediction, unless its x or y is beyond those of all vertices of a ring. The limit must be a power of 2. */
static void cqi_add_rival(cqi_fan *f, cqi_vector a)
{
    const uint32_t limit = (uint32_t)1 << CQI_RING_BITS;
    if (f->num_rivals == CQI_RIVALS || (cqi_abs(a.x) | cqi_abs(a.y)) >= limit) return;
    f->rival[f->num_rivals++] = a;
}

static cqi_vector cqi_parallelogram(cqi_vector a, cqi_vector b, cqi_vector opposite)
{
    return cqi_minus(cqi_plus(a, b), opposite);
}

/* Parallelograms across the edges of the fan and inside it, and midpoints of its vertices. */
static void cqi_list_rivals(cqi_fan *f)
{
    const cqi_vector *const at = f->at;
    const int n = f->size;
    int k, j;
    f->num_rivals = 0;
    if (f->boundary || n < 4) return;
    for (k = 0; k < n; k++)
        if (f->known >> k & 1)
            cqi_add_rival(f, cqi_parallelogram(at[k], at[cqi_next_of(k, n)], f->outer[k]));
    for (k = 0; k < n; k++)
        cqi_add_rival(f, cqi_parallelogram(at[cqi_previous_of(k, n)], at[cqi_next_of(k, n)], at[k]));
    for (k = 0; k < n - 2; k++)
        for (j = k + 2; j < n - (k == 0); j++) cqi_add_rival(f, cqi_shift(cqi_plus(at[k], at[j]), 1));
}

/* Where a surface has sharp edges, B often lies in the plane of a flat side to which only some triangles nearby belong.
 * So once x and y are known, planes compete for z in the same way: as predictions with z in place of x, and 0 for y.
 *
 * Adds the height at a place, at most CQI_FAR away, of the plane through three points, unless the plane is steep: then
 * it tells little. Nothing overflows: components of edges are below 2^16, and 2^14 once they are shifted; those of the
 * cross product below 2^29. Its z is then made at most 2^15, and x and y are at most 8 more than 8 times that: so
 * slopes, in 2^-14, are at most 2^18, and all products at most 2^35. */
#define CQI_STEEP_BITS 3  /* steep: the slope is 2^3 or more */
static void cqi_add_plane(cqi_fan *f, cqi_vector place, cqi_vector a, cqi_vector b, cqi_vector c)
{
    const cqi_vector at = cqi_minus(place, a);
    cqi_vector n = cqi_cross(cqi_shift(cqi_minus(b, a), 2), cqi_shift(cqi_minus(c, a), 2)), z = { 0, 0, 0 };
    const uint32_t steep = (cqi_abs(n.x) + cqi_abs(n.y)) >> CQI_STEEP_BITS;
    int32_t part;
    if (cqi_abs(n.z) <= steep) return;
    n = cqi_shift(n, (int)cqi_clamp(cqi_bit_length(cqi_abs(n.z)) - 15, 0, 31));
    part = ((int32_t)1 << 29) / n.z;
    z.x = a.z - cqi_product(cqi_product(n.x, part, 15), at.x, 14) - cqi_product(cqi_product(n.y, part, 15), at.y, 14);
    cqi_add_rival(f, z);
}

/* Planes of the triangles across the edges of the fan, and of those inside it. */
static void cqi_list_planes(cqi_fan *f, cqi_vector place)
{
    const cqi_vector *const at = f->at;
    const int n = f->size;
    int k;
    if (f->boundary || n < 3) return;
    for (k = 0; k < n; k++)
        if (f->known >> k & 1) cqi_add_plane(f, place, at[k], at[cqi_next_of(k, n)], f->outer[k]);
    for (k = 0; k < n && n > 3; k++)
        cqi_add_plane(f, place, at[k], at[cqi_previous_of(k, n)], at[cqi_next_of(k, n)]);
}

/* Distance along the surface: the larger of those in x and y. */
static inline int32_t cqi_apart(cqi_vector a, cqi_vector b)
{
    const int32_t x = (int32_t)cqi_abs(a.x - b.x), y = (int32_t)cqi_abs(a.y - b.y);
    return x > y ? x : y;
}

/* Places of the rivals along the surface, and how many agree with each, twice if closely. */
typedef struct {
    int16_t x[CQI_RIVALS], y[CQI_RIVALS], of[CQI_RIVALS];
} cqi_votes;

/* Rival `from` and each of the first `count` vote for each other. Returns the votes for `from`. */
static int cqi_add_votes(cqi_votes *v, int from, int count, int16_t radius)
{
    const int16_t x = v->x[from], y = v->y[from], half = (int16_t)(radius / 2);
    int k, all = 0;
    for (k = 0; k < count; k++) {
        const int16_t east = (int16_t)(v->x[k] - x), west = (int16_t)(x - v->x[k]), ax = east > west ? east : west;
        const int16_t north = (int16_t)(v->y[k] - y), south = (int16_t)(y - v->y[k]), ay = north > south ? north : south;
        const int16_t apart = ax > ay ? ax : ay, vote = (int16_t)((apart < radius) + (apart < half));
        v->of[k] = (int16_t)(v->of[k] + vote);
        all += vote;
    }
    return all;
}

/* Counts all votes. A loop of fixed length becomes vector instructions where there are some; there, each rival also
 * votes for itself, which is subtracted, and for the zeros after the last one, whose votes nobody reads. */
static void cqi_count_votes(const cqi_fan *f, int16_t radius, cqi_votes *v)
{
    int k;
#if CQI_VECTORS
    memset(v->x, 0, sizeof v->x);
    memset(v->y, 0, sizeof v->y);
    memset(v->of, 0, sizeof v->of);
#endif
    for (k = 0; k < f->num_rivals; k++) {
        v->x[k] = (int16_t)f->rival[k].x;
        v->y[k] = (int16_t)f->rival[k].y;
    }
    for (k = 0; k < f->num_rivals; k++) {
#if CQI_VECTORS
        cqi_add_votes(v, k, CQI_RIVALS, radius);
        v->of[k] = (int16_t)(v->of[k] - (radius > 0) - (radius > 1));
#else
        v->of[k] = (int16_t)cqi_add_votes(v, k, k, radius);
#endif
    }
}

/* Finds the place that most predictions agree on: two agree if they are less than the radius apart, and count twice if
 * less than half of it. Returns the votes for the place. */
static CQI_APART int cqi_vote(const cqi_fan *f, cqi_contest *c)
{
    int k, best = 0, n = 0;
    cqi_vector sum = { 0, 0, 0 };
    cqi_votes votes;
    cqi_count_votes(f, (int16_t)c->radius, &votes);
    for (k = 1; k < f->num_rivals; k++)
        if (votes.of[k] > votes.of[best]) best = k;
    for (k = 0; k < f->num_rivals; k++) {
        if (k != best && cqi_apart(f->rival[k], f->rival[best]) >= c->radius) continue;
        sum = cqi_plus(sum, f->rival[k]);
        n++;
    }
    c->agreed = cqi_part(sum, n);
    return votes.of[best];
}

/* Classes of agreement: 0, 1, 2, 3 .. 4, 5 .. 7, 8 .. 11, 12 .. 17 votes, and more. */
static int cqi_vote_class(int votes)
{
    return votes < 3 ? votes : votes < 5 ? 3 : votes < 8 ? 4 : votes < 12 ? 5 : votes < 18 ? 6 : 7;
}

/* Is a place where predictions agree? */
static int cqi_is_hit(const cqi_contest *c, cqi_vector place) { return cqi_apart(place, c->agreed) < c->radius * 3 / 2; }

/* -- Questions that are asked while they pay --
 *
 * A question is a bit that could be left out, but whose yes saves other bits. Both sides keep a running mean of what
 * asking has gained, or would have gained where nothing was asked; while that is negative, they do not ask, and the
 * answer is no. */

/* -log2(p / 65536), in 1/64 bit. */
static int cqi_cost(uint32_t p) { return 64 * 16 - 8 * cqi_logarithm(p); }

/* Asks, if that has paid so far, and returns the answer. */
static int cqi_code_question(cq_decoder *d, int index, int yes)
{
    return d->model.gain[index] < 0 ? 0 : cqi_code_part(d, d->model.yes[index], yes);
}

/* Updates the mean of what asking gains, given what a yes saves before its own cost, in 1/64 bit. Returns what was
 * gained this time, 0 if it was not asked. */
static int cqi_learn_question(cqi_model *m, int index, int yes, int saved)
{
    const uint32_t p = m->yes[index];
    const int asked = m->gain[index] >= 0;
    const int gain = yes ? (int)cqi_clamp(saved, -1024, 1024) - cqi_cost(p) : -cqi_cost(65536 - p);
    m->gain[index] = (int16_t)(m->gain[index] + cqi_floor_shift((int32_t)16 * gain - m->gain[index], 5));
    cqi_adapt_bit(&m->yes[index], 5, yes);
    return asked ? gain : 0;
}

/* Estimate of the bits that a residual takes, in 1/64; x is in the scale of the ring. */
static int cqi_residual_cost(int32_t x, int shift)
{
    const int32_t least = shift > 0 ? (int32_t)3 << shift >> 2 : 1;
    return 32 * (cqi_half_bits(cqi_abs(x) + (uint32_t)least) - 2 * shift);
}

/* -- Positions: coding --
 *
 * Coordinates are coded relative to A, in steps of the channel; predictions are in the scale of the ring. */

/* Chooses from the coordinates of the vertices that are left, at least one: the first time the commonest coordinate, of
 * equally common ones the nearest to the prediction; later just the nearest. */
static int32_t cqi_choose_common(const cqi_fan *f, uint32_t left, int first, int32_t predicted)
{
    const int32_t *const x = f->scratch[0];
    int32_t off = 0, common = 0;
    int k, j, most = 0;
    for (k = 0; k < f->size; k++) {
        const int32_t apart = (int32_t)cqi_abs(x[k] - predicted);
        int many = 1;
        if (!(left >> k & 1)) continue;
        for (j = 0; first && j < k; j++) many += x[j] == x[k];
        if (many < most || (many == most && apart >= off)) continue;
        most = many;
        off = apart;
        common = x[k];
    }
    return common;
}

/* Takes the vertices with this coordinate from those that are left. Returns how many have it. */
static int cqi_take_equal(const cqi_fan *f, int32_t common, uint32_t *left)
{
    int k, many = 0;
    for (k = 0; k < f->size; k++) {
        if (f->scratch[0][k] != common) continue;
        *left &= ~((uint32_t)1 << k);
        many++;
    }
    return many;
}

/* Classes of the distance from the prediction to a coordinate of neighbours: how many half bits it has more than what
 * is expected of a residual, -3 and less, -2 .. 0, 1 .. 3, and more. */
static int cqi_class_of_same(uint32_t apart, const cqi_fan *f, int shift)
{
    const int more = cqi_half_bits(apart) - 2 * shift - f->halves;
    return more < -2 ? 0 : more < 1 ? 1 : more < 4 ? 2 : 3;
}

/* Asks whether component c of B is one of its neighbours': the commonest one, then those nearest to the prediction. */
static int cqi_code_same(cq_decoder *d, int c, int32_t predicted, int32_t *value)
{
    cqi_fan *const f = &d->now.fan;
    uint32_t left = ((uint32_t)1 << f->size) - 1;
    int k;
    for (k = 0; k < f->size; k++) f->scratch[0][k] = cqi_component(f->at[k], c);
    while (f->asked < f->same && left) {
        const int32_t common = cqi_choose_common(f, left, !f->asked, predicted);
        const int32_t same = cqi_floor_shift(common, d->ring.shift);
        const int many = cqi_at_most(cqi_take_equal(f, common, &left), 4) - 1;
        const int far = cqi_class_of_same(cqi_abs(common - predicted), f, d->ring.shift);
        const int question = CQI_SAME + 16 * (3 * f->asked + c) + 4 * many + far;
        f->common[f->asked] = common;
        f->question[f->asked++] = question;
        if (!cqi_code_question(d, question, *value == same)) continue;
        *value = same;
        return 1;
    }
    return 0;
}

/* Updates what asking gains, now that the coordinate is known: of all questions up to the first yes. */
#define CQI_EXACT_SAVES 192 /* what a yes saves beside the residual's bits, in 1/64 bit */
static void cqi_learn_same(cq_decoder *d, int32_t predicted, int32_t value)
{
    cqi_fan *const f = &d->now.fan;
    const int shift = d->ring.shift;
    int k, yes = 0;
    for (k = 0; k < f->asked && !yes; k++) {
        const int saved = cqi_residual_cost(f->common[k] - predicted, shift) + CQI_EXACT_SAVES;
        yes = value == cqi_floor_shift(f->common[k], shift);
        f->gain_same[k > 0] += cqi_learn_question(&d->model, f->question[k], yes, saved);
    }
}

/* Component c of B: that of a neighbour, or a residual of which half_bits / 2 bits are expected. agreed: it is x or y,
 * where predictions agree. f->halves becomes the actual size of the residual, in half bits. */
static void cqi_code_coordinate(cq_decoder *d, int c, int agreed, int half_bits, int32_t predicted, int32_t *value)
{
    cqi_fan *const f = &d->now.fan;
    const int shift = d->ring.shift;
    f->halves = half_bits < 0 ? 0 : half_bits;
    f->asked = 0;
    if (!f->same || shift < 0 || !cqi_code_same(d, c, predicted, value)) {
        const int32_t near = cqi_clamp(predicted, -CQI_FAR, CQI_FAR), p = cqi_unscaled(near, shift);
        const int fraction = shift >= 2 ? cqi_floor_shift(near + (1 << (shift - 1)), shift - 2) & 3 : -1;
        const int kind = agreed ? CQI_AGREED : CQI_FIRST + c * CQI_RESIDUAL_MODELS;
        const int32_t x = cqi_code_expected(d, kind, f->halves, 26, fraction, *value - p);
        f->halves = cqi_half_bits(cqi_negated((uint32_t)x, x < 0));
        *value = p + x;
    }
    cqi_learn_same(d, predicted, *value);
}

/* Asks, if there are predictions, whether the place, which only an encoder knows, is where they agree. The model
 * depends on their votes, and on how far from c->linear they agree. Two agree within part / 256 of the fan's extent and
 * one and a half steps more. */
#define CQI_RIVALS_APART 14
#define CQI_PLANES_APART 2
static int cqi_code_hit(cq_decoder *d, cqi_contest *c, int questions, int part, cqi_vector place)
{
    const cqi_fan *f = &d->now.fan;
    const int shift = d->ring.shift;
    int apart = 0;
    int32_t x;
    c->question = -1;
    if (!f->num_rivals) return 0;
    c->radius = f->extent * part / 256 + (shift >= 0 ? (int32_t)3 << shift >> 1 : 1);
    c->question = questions + 8 * cqi_vote_class(cqi_vote(f, c));
    x = cqi_apart(c->agreed, c->linear);
    while (apart < 5 && x >= c->radius << apart) apart++;
    c->question += apart;
    return cqi_code_question(d, c->question, CQI_ENCODING(d) && cqi_is_hit(c, place));
}

/* Updates what asking gains, now that the place is known. Its residual has `count` components. */
static void cqi_learn_hit(cq_decoder *d, const cqi_contest *c, cqi_vector place, int count, int32_t *worth)
{
    const int shift = d->ring.shift;
    int saved;
    if (c->question < 0) return;
    saved = cqi_residual_cost(cqi_apart(place, c->linear), shift) - cqi_residual_cost(cqi_apart(place, c->agreed), shift);
    saved = cqi_learn_question(&d->model, c->question, cqi_is_hit(c, place), count * saved);
    *worth += cqi_floor_shift((int32_t)16 * saved - *worth, 6);
}

/* x and y of B; hit: predictions agree about it. Returns the larger size of both residuals. */
static int cqi_code_along(cq_decoder *d, int hit, cqi_vector *value)
{
    cqi_fan *f = &d->now.fan;
    int halves;
    if (hit) {
        const int half_bits = cqi_half_bits((uint32_t)f->along.radius) - 2 * d->ring.shift;
        cqi_code_coordinate(d, 0, 1, half_bits, f->along.agreed.x, &value->x);
        halves = f->halves;
        cqi_code_coordinate(d, 1, 1, (half_bits + halves + 1) / 2, f->along.agreed.y, &value->y);
    } else {
        cqi_code_coordinate(d, 0, 0, f->expected[0], f->linear.x, &value->x);
        halves = f->halves;
        cqi_code_coordinate(d, 1, 0, f->expected[1], f->linear.y, &value->y);
    }
    return halves > f->halves ? halves : f->halves;
}

/* Predictions that compete and common components take time, and save bits only on some surfaces. They are used while
 * the running mean of what they gain per vertex is above CQI_WORTH_IT; else only at one vertex in CQI_PROBE, to update
 * that mean. */
#define CQI_WORTH_IT 24    /* in 1/1024 bit */
#define CQI_PROBE 32

/* Are all features of the linear prediction within four steps of the fan's plane? Then planes tell nothing new. */
static int cqi_is_flat(const cqi_fan *f, int shift)
{
    return (cqi_abs(f->height[0]) | cqi_abs(f->height[1]) | cqi_abs(f->height[2])) < (uint32_t)4 << (shift > 0 ? shift : 0);
}

/* z of B, whose x and y are in *place. */
static void cqi_code_above(cq_decoder *d, int half_bits, int32_t predicted, cqi_vector *place, int32_t *value)
{
    cqi_fan *f = &d->now.fan;
    cqi_contest *c = &f->over;
    cqi_vector z = { 0, 0, 0 };
    f->num_rivals = 0;
    if (f->flat_sides) {
        z.x = cqi_clamp(place->x, -CQI_FAR, CQI_FAR);
        z.y = cqi_clamp(place->y, -CQI_FAR, CQI_FAR);
        cqi_list_planes(f, z);
        z.x = cqi_scaled(*value, &d->ring);
        z.y = 0;
    }
    c->linear.x = predicted;
    c->linear.y = 0;
    if (cqi_code_hit(d, c, CQI_FLAT, CQI_PLANES_APART, z)) {
        predicted = c->agreed.x;
        half_bits = cqi_half_bits((uint32_t)c->radius) - 2 * d->ring.shift;
    }
    cqi_code_coordinate(d, 2, 0, half_bits, predicted, value);
    place->z = z.x = cqi_scaled(*value, &d->ring);
    cqi_learn_hit(d, c, z, 1, &d->model.worth_flat);
}

/* Codes B relative to A. Even a residual of CQI_WILD only makes a value of 27 bits, at most slightly above 2^30 in the
 * scale of the ring. */
static void cqi_code_place(cq_decoder *d, int p, int q, cqi_vector *value)
{
    cqi_fan *f = &d->now.fan;
    cqi_model *m = &d->model;
    const int probe = d->mesh.num_vertices % CQI_PROBE == 0, rivals = probe || m->worth_rivals > CQI_WORTH_IT;
    int half_bits, hit, k;
    cqi_vector place, above = { 0, 0, 0 };
    int32_t plane, rise;
    f->same = probe || m->worth_same[0] > CQI_WORTH_IT;
    if (f->same && (probe || m->worth_same[1] > CQI_WORTH_IT)) f->same = CQI_SAMES;
    f->flat_sides = (probe || m->worth_flat > CQI_WORTH_IT) && !cqi_is_flat(f, d->ring.shift);
    f->gain_same[0] = f->gain_same[1] = f->num_rivals = 0;
    if (rivals || f->same || f->flat_sides) cqi_turn_fan(&d->ring, f, p, q);
    if (rivals) cqi_list_rivals(f);
    place.x = cqi_scaled(value->x, &d->ring);
    place.y = cqi_scaled(value->y, &d->ring);
    f->along.linear = f->linear;
    hit = cqi_code_hit(d, &f->along, CQI_HIT, CQI_RIVALS_APART, place);
    half_bits = (f->expected[2] + cqi_code_along(d, hit, value)) / 2;
    place.x = cqi_scaled(value->x, &d->ring);
    place.y = cqi_scaled(value->y, &d->ring);
    above.x = cqi_clamp(place.x - f->mean.x, -CQI_FAR, CQI_FAR);
    above.y = cqi_clamp(place.y - f->mean.y, -CQI_FAR, CQI_FAR);
    plane = f->mean.z - cqi_height(f, above);
    rise = hit ? cqi_height(f, cqi_minus(f->along.agreed, f->mean)) : f->rise;
    cqi_code_above(d, half_bits, plane + rise, &place, &value->z);
    cqi_learn_linear(m, f, place, place.z - plane);
    cqi_learn_hit(d, &f->along, place, 2, &m->worth_rivals);
    for (k = 0; k < 2 && k < f->same; k++)
        m->worth_same[k] += cqi_floor_shift((int32_t)16 * f->gain_same[k] - m->worth_same[k], 6);
}

/* Codes the position of B into `to`. 0 if what was decoded is not a position. */
static int cqi_code_position(cq_decoder *d, uint32_t channel, int p, int q, cq_index input, cq_value *to)
{
    cqi_fan *f = &d->now.fan;
    const cq_value *const a = d->channel[channel] + 3 * (size_t)d->mesh.origin[d->ring.spoke[0]];
    cqi_vector x = { 0, 0, 0 };
    cqi_find_features(d, f, d->channel[channel], p, q);
    cqi_predict_linear(&d->model, f);
    if (CQI_ENCODING(d)) {
        x.x = cqi_plan_value(d, channel, 0, input) - a[0];
        x.y = cqi_plan_value(d, channel, 1, input) - a[1];
        x.z = cqi_plan_value(d, channel, 2, input) - a[2];
        x = cqi_in_cycle(x, f->above);
    }
    cqi_code_place(d, p, q, &x);
    x = cqi_out_of_cycle(x, f->above);
    x.x += a[0];
    x.y += a[1];
    x.z += a[2];
    to[0] = (cq_value)x.x;
    to[1] = (cq_value)x.y;
    to[2] = (cq_value)x.z;
    return (uint32_t)(x.x | x.y | x.z) >> d->shape.channel[channel].bits == 0;
}

static int64_t cqi_clamp_wide(int64_t x, int64_t most) { return x < -most ? -most : x > most ? most : x; }

/* A bit with a model that adapts fast at first: its rates are 1, 2, 2, 3, 3, 4, 4, and from then on 5. */
static int cqi_code_quick(cq_decoder *d, cqi_quick_model *model, int bit)
{
    bit = cqi_code_adaptive(d, &model->bit, 1 + (model->used + 1) / 2, bit);
    model->used = (uint8_t)(model->used + (model->used < 7));
    return bit;
}

/* A residual of a row, of which half_bits / 2 bits are expected: its number of bits, 0 .. 47, by asking up to 16 times
 * whether it has more; then the bits below the highest one, and the sign. A mesh without seams has no such models. */
static int32_t cqi_code_row_residual(cq_decoder *d, int set, int half_bits, int most, int32_t residual)
{
    cqi_quick_model *model;
    const uint32_t magnitude = cqi_abs(residual);
    const int length = cqi_bit_length(magnitude);
    uint32_t low, x;
    int n = 0;
    if (!d->seams) return cqi_code_expected(d, CQI_PLAIN, set == CQI_ROW_ROUNDING ? 0 : half_bits, most, -1, residual);
    model = d->seams->length[set][cqi_at_most(half_bits, CQI_ROW_CLASSES - 1)];
    while (n < CQI_ROW_LENGTHS && cqi_code_quick(d, &model[n], n < length)) n++;
    if (n == CQI_ROW_LENGTHS) n += (int)cqi_code_raw(d, (uint32_t)(length - n), 5);
    if (!n) return 0;
    if (n > most) return CQI_WILD;
    low = ((uint32_t)1 << (n - 1)) - 1;
    x = cqi_code_raw(d, (magnitude & low) << 1 | (residual < 0), n);
    return (int32_t)(x & 1 ? (uint32_t)0 - (low + 1 + (x >> 1)) : low + 1 + (x >> 1));
}

/* Component c of channel k of a vertex or row that is `input`, given what is expected. 0 if it is out of range. */
static int cqi_code_row_value(cq_decoder *d, uint32_t k, uint32_t c, int set, int half_bits, int32_t expected,
                              cq_index input, cq_value *to)
{
    const cq_channel *channel = &d->shape.channel[k];
    int32_t x = 0;
    if (CQI_ENCODING(d)) x = cqi_difference(cqi_plan_value(d, k, c, input), expected);
    if (cqi_is_exact(channel)) half_bits += 16;
    x = cqi_code_row_residual(d, set, half_bits, cqi_most_bits(channel), x);
    return cqi_store_value(channel, expected, x, to);
}

/* -- Attributes from geometry --
 *
 * The position of B is known before its other values, and so are its faces. What these tell of B, or of one of its
 * rows, is kept in d->now.fan. */

/* The sum of the areas of the fan's faces, as a vector at right angles to them, with 14 bits; offsets are shifted to 12
 * before. If it is 0, any vector will do. */
static cqi_vector cqi_area_of_fan(const cqi_fan *f, int shift)
{
    cqi_vector sum = { 0, 0, 0 };
    int k;
    for (k = 0; k < f->size; k++) {
        const cqi_vector at = cqi_shift(f->at[k], shift), next = cqi_shift(f->at[cqi_next_of(k, f->size)], shift);
        if (f->faces >> k & 1) sum = cqi_plus(sum, cqi_cross(next, at));
    }
    sum = cqi_shift(sum, cqi_bit_length((cqi_abs(sum.x) | cqi_abs(sum.y) | cqi_abs(sum.z)) >> 14));
    if (!(sum.x | sum.y | sum.z)) sum.z = 1;
    return sum;
}

/* A vector at right angles to n, of about the same length: without n's smallest component. */
static cqi_vector cqi_across(cqi_vector n)
{
    const uint32_t x = cqi_abs(n.x), y = cqi_abs(n.y), z = cqi_abs(n.z);
    cqi_vector a = { 0, 0, 0 };
    if (x <= y && x <= z) {
        a.y = n.z;
        a.z = -n.y;
    } else if (y <= z) {
        a.z = n.x;
        a.x = -n.z;
    } else {
        a.x = n.y;
        a.y = -n.x;
    }
    return a;
}

/* Sets f->outer to the places of the neighbours in the plane of the fan, with CQI_FLAT_BITS bits, and f->mean to the
 * mean of these. Axes have 15 bits; before they are shifted, places have 29. */
#define CQI_FLAT_BITS 10
static void cqi_flatten_fan(cqi_fan *f)
{
    cqi_vector n, u, v, sum = { 0, 0, 0 };
    uint32_t all = 0;
    int32_t length;
    int k, shift;
    for (k = 0; k < f->size; k++) all |= cqi_abs(f->at[k].x) | cqi_abs(f->at[k].y) | cqi_abs(f->at[k].z);
    shift = cqi_bit_length(all >> 12);
    n = cqi_area_of_fan(f, shift);
    u = cqi_across(n);
    v = cqi_cross(n, u);
    length = (int32_t)cqi_square_root((uint64_t)cqi_wide_dot(n, n));
    v.x /= length;
    v.y /= length;
    v.z /= length;
    for (k = 0, all = 0; k < f->size; k++) {
        const cqi_vector at = cqi_shift(f->at[k], shift);
        f->outer[k].x = (int32_t)cqi_wide_dot(at, u);
        f->outer[k].y = (int32_t)cqi_wide_dot(at, v);
        f->outer[k].z = 0;
        all |= cqi_abs(f->outer[k].x) | cqi_abs(f->outer[k].y);
    }
    shift = cqi_bit_length(all >> CQI_FLAT_BITS);
    for (k = 0; k < f->size; k++) {
        f->outer[k] = cqi_shift(f->outer[k], shift);
        sum = cqi_plus(sum, f->outer[k]);
    }
    f->mean = cqi_part(sum, f->size);
}

/* Lists B's neighbours and the vertices beyond. */
static void cqi_list_fan_of_b(cq_decoder *d, int p, int q)
{
    const cqi_ring *r = &d->ring;
    cqi_fan *f = &d->now.fan;
    int k, n = 1;
    f->vertex[0] = d->mesh.origin[r->spoke[0]];
    f->beyond[0] = r->vertex[cqi_previous_of(p, r->size)];
    for (k = p; k <= q; k++) {
        f->vertex[n] = r->vertex[k];
        f->beyond[n] = r->front[k];
        n += k != r->boundary;
    }
    f->beyond[n - 1] = r->vertex[cqi_next_of(q, r->size)];
    for (k = 0; k < n; k++)
        if (f->boundary || cq_is_virtual(&d->mesh, f->beyond[k])) f->beyond[k] = CQ_NONE;
}

/* Prepares the fan of B for its other channels. Between the neighbours of a virtual one there is no face. */
static void cqi_locate_fan_of_b(cq_decoder *d, int p, int q)
{
    cqi_fan *f = &d->now.fan;
    int k;
    cqi_size_fan(&d->ring, f, p, q);
    cqi_list_fan_of_b(d, p, q);
    f->faces = ((uint32_t)1 << f->size) - 1;
    if (f->boundary) f->faces -= (uint32_t)1 << (d->ring.boundary - p);
    if (d->located < 0) return;
    for (k = 0; k < f->size; k++) f->at[k] = cqi_offset(d->channel[d->located], d->mesh.num_vertices, f->vertex[k]);
}

/* -- Numbers by an affine fit --
 *
 * Colours and other numbers are often close to an affine function of the position. It is fitted to B's neighbours by
 * least squares, in the two coordinates along the surface. */

static int64_t cqi_minor(int32_t a, int32_t b, int32_t c, int32_t d) { return (int64_t)a * b - (int64_t)c * d; }

/* Number of bits that the largest of three numbers has beyond `bits`; at most 31. */
static int cqi_excess(int64_t x, int64_t y, int64_t z, int bits)
{
    return cqi_bit_length((uint32_t)(((x < 0 ? ~x : x) | (y < 0 ? ~y : y) | (z < 0 ? ~z : z)) >> bits));
}

/* Offset of place k from the mean of all, shifted to 9 bits. */
static cqi_vector cqi_from_mean(const cqi_fan *f, int k) { return cqi_shift(cqi_minus(f->outer[k], f->mean), 2); }

/* What the fit predicts for B, minus the mean of its neighbours, given their values x and this mean; clamped to twice
 * the largest of their differences from it. A little is added to the squares, so that neighbours on a line have a fit,
 * too. *off becomes the sum of the fit's distances from the neighbours; without a fit it stays as it is.
 *
 * Offsets from the mean have 9 bits, sums of up to 25 products 23, determinants 46; values 23 and sums with them 37,
 * numerators 61, of which 30 are looked at.
 *
 * The determinant is never 0. Let s be the sum of all squares; if it is 0, the determinant is 1. Else what is added makes
 * it larger than s and than s^2 / 64. Numerators are below 2^25 s^(3/2): if they have more than 30 bits, all are divided by
 * less than s^(3/2) / 16. More than 16 s^(-1/2) and s^(1/2) / 4 are left of the determinant then: at least 2. */
static int32_t cqi_fit(const cqi_fan *f, const int32_t *x, int32_t mean, uint32_t *off)
{
    int64_t ux = 0, uy = 0, det;
    int32_t xx = 0, yy = 0, xy = 0, limit = 0, ridge;
    cqi_vector along = { 0, 0, 0 };
    int k, bits;
    for (k = 0; k < f->size; k++) {
        const cqi_vector at = cqi_from_mean(f, k);
        const int32_t u = cqi_floor_shift(x[k] - mean, 2);
        xx += at.x * at.x;
        yy += at.y * at.y;
        xy += at.x * at.y;
        ux += (int64_t)u * at.x;
        uy += (int64_t)u * at.y;
        limit = u > limit ? u : -u > limit ? -u : limit;
    }
    ridge = (xx + yy) / 64 + 1;
    xx += ridge;
    yy += ridge;
    det = yy * ux - xy * uy;
    uy = xx * uy - xy * ux;
    bits = cqi_excess(det, uy, 0, 30);
    along.x = (int32_t)cqi_floor_shift_wide(det, bits);
    along.y = (int32_t)cqi_floor_shift_wide(uy, bits);
    det = ((int64_t)xx * yy - (int64_t)xy * xy) >> bits;
    if (!det) return 0; /* unreachable: see above */
    for (k = 0, *off = 0; k < f->size; k++) {
        const int64_t fit = cqi_wide_dot(along, cqi_from_mean(f, k)) / det - cqi_floor_shift(x[k] - mean, 2);
        *off += (uint32_t)(4 * cqi_abs((int32_t)cqi_clamp_wide(fit, 4 * (int64_t)limit)));
    }
    return -4 * (int32_t)cqi_clamp_wide(cqi_wide_dot(along, cqi_shift(f->mean, 2)) / det, 2 * (int64_t)limit);
}

/* -- Texture coordinates, by a similarity --
 *
 * What lays a surface flat for its texture turns and scales what is small, and perhaps mirrors it, but keeps its angles
 * as well as it can. So the map from the plane of the fan to the texture is sought among the similarities: with places
 * and texture coordinates as complex numbers, a product by one number, after turning y over where the texture is
 * mirrored. It is fitted to those around by least squares, weighted by the inverse of their distances. */
typedef struct cqi_similarity {
    int32_t x, y, u, v;   /* weighted means of the places and of the texture coordinates, of up to 10 and 20 bits */
    int64_t re, im;       /* the number, in 1/256 */
    int32_t mirror;       /* -1: y is turned over before; else 1 */
    int32_t most;         /* the largest difference of a texture coordinate from its mean */
} cqi_similarity;

/* Sets f->outer[k].z to the weights of the first n places, at most 4096, and finds the weighted means. */
static void cqi_weigh_places(cqi_fan *f, int n, cqi_similarity *s)
{
    const int32_t *const u = f->scratch[0], *const v = f->scratch[1];
    int64_t sum_u = 0, sum_v = 0;
    int32_t sum_x = 0, sum_y = 0, sum = 0;
    int k;
    for (k = 0; k < n; k++) {
        cqi_vector *const at = &f->outer[k];
        at->z = (4 << CQI_FLAT_BITS) / (1 + (int32_t)cqi_square_root((uint32_t)(at->x * at->x + at->y * at->y)));
        sum += at->z;
        sum_x += at->z * at->x;
        sum_y += at->z * at->y;
        sum_u += (int64_t)at->z * u[k];
        sum_v += (int64_t)at->z * v[k];
    }
    s->x = sum_x / sum;
    s->y = sum_y / sum;
    s->u = (int32_t)(sum_u / sum);
    s->v = (int32_t)(sum_v / sum);
}

/* The determinant of the four sums, shifted to 30 bits: positive if u and v turn as x and y do, negative if the texture
 * is mirrored. */
static int64_t cqi_turning(int64_t xu, int64_t xv, int64_t yu, int64_t yv)
{
    int bits = cqi_excess(xu, xv, yu, 30);
    const int more = cqi_excess(yv, 0, 0, 30);
    bits = more > bits ? more : bits;
    xu = cqi_floor_shift_wide(xu, bits);
    xv = cqi_floor_shift_wide(xv, bits);
    return xu * cqi_floor_shift_wide(yv, bits) - xv * cqi_floor_shift_wide(yu, bits);
}

/* Fits the similarity to the first n places. Where these do not tell whether the texture is mirrored, as two never do,
 * *mirror says so; else it becomes what is found.
 *
 * Differences have 11 and 21 bits, sums of 25 products with weights 49, squares of places 40. The number has at most
 * 29, as |x| + |y| is at most x^2 + y^2; it is clamped because a verifier cannot see that. */
static void cqi_fit_similarity(cqi_fan *f, int n, int32_t *mirror, cqi_similarity *s)
{
    const int64_t most = (int64_t)1 << 38;
    int64_t xu = 0, xv = 0, yu = 0, yv = 0, squares = 0, turning;
    int k;
    cqi_weigh_places(f, n, s);
    s->most = 0;
    for (k = 0; k < n; k++) {
        const int32_t x = f->outer[k].x - s->x, y = f->outer[k].y - s->y;
        const int32_t u = f->scratch[0][k] - s->u, v = f->scratch[1][k] - s->v;
        const int64_t weighted_x = f->outer[k].z * x, weighted_y = f->outer[k].z * y;
        xu += weighted_x * u;
        xv += weighted_x * v;
        yu += weighted_y * u;
        yv += weighted_y * v;
        squares += weighted_x * x + weighted_y * y;
        if ((int32_t)cqi_abs(u) > s->most) s->most = (int32_t)cqi_abs(u);
        if ((int32_t)cqi_abs(v) > s->most) s->most = (int32_t)cqi_abs(v);
    }
    turning = cqi_turning(xu, xv, yu, yv);
    if (n > 2 && turning) *mirror = turning < 0 ? -1 : 1;
    s->mirror = *mirror;
    squares += !squares;
    s->re = cqi_clamp_wide((xu + s->mirror * yv) * 256 / squares, most);
    s->im = cqi_clamp_wide((xv - s->mirror * yu) * 256 / squares, most);
}

/* Where the similarity takes a place: both texture coordinates minus their means, clamped. */
static void cqi_map_place(const cqi_similarity *s, int32_t x, int32_t y, int64_t most, int32_t *to)
{
    x -= s->x;
    y = s->mirror * (y - s->y);
    to[0] = (int32_t)cqi_clamp_wide((s->re * x - s->im * y) / 256, most);
    to[1] = (int32_t)cqi_clamp_wide((s->im * x + s->re * y) / 256, most);
}

/* How far the similarity misses the first n texture coordinates, in total; with n < 3, how far apart these are. */
static uint32_t cqi_misses(const cqi_fan *f, int n, const cqi_similarity *s)
{
    const int32_t *const u = f->scratch[0], *const v = f->scratch[1];
    uint32_t sum = 0;
    int32_t to[2];
    int k;
    if (n < 3) return cqi_abs(u[n - 1]) + cqi_abs(v[n - 1]);
    for (k = 0; k < n; k++) {
        cqi_map_place(s, f->outer[k].x, f->outer[k].y, (int64_t)1 << 22, to);
        sum += cqi_abs(to[0] + s->u - u[k]) + cqi_abs(to[1] + s->v - v[k]);
    }
    return sum;
}

/* -- Normals --
 *
 * The normals of the faces of a fan, each weighted by its angle, predict that of their common corner. Octahedral pairs
 * have the lower hemisphere folded out to the border of the square, where close directions may be far apart. If the
 * prediction is in the lower hemisphere, all pairs are folded before they are compared: the upper hemisphere is then
 * outside. */

/* An octahedral pair, relative to the middle of the square, whose border is `half` away. */
typedef struct cqi_pair_of_normal {
    int32_t x, y;
} cqi_pair_of_normal;

/* Folds a pair: the hemisphere that was inside is then outside. Undoes itself, except for some points on the border. */
static cqi_pair_of_normal cqi_folded(cqi_pair_of_normal a, int32_t half)
{
    const int32_t x = half - (int32_t)cqi_abs(a.y), y = half - (int32_t)cqi_abs(a.x);
    a.x = a.x < 0 ? -x : x;
    a.y = a.y < 0 ? -y : y;
    return a;
}

typedef struct cqi_vector64 {
    int64_t x, y, z;
} cqi_vector64;

/* The angle of a direction in a plane, y >= 0, in 1/65536 radian. Up to pi/4 it is t (pi/4 + 0.273 (1 - t)), within
 * 0.004, for t = y / x. */
static int64_t cqi_angle(int64_t x, int64_t y)
{
    const int64_t size = x < 0 ? -x : x, low = size < y ? size : y, high = size < y ? y : size;
    const int64_t t = high ? low * 65536 / high : 0;
    int64_t angle = t * (51472 + (17891 * (65536 - t) >> 16)) >> 16;
    if (size < y) angle = 102944 - angle;
    return x < 0 ? 205887 - angle : angle;
}

/* The angle between two offsets of 25 bits, which are shifted down to 14. Also their cross product, of 30 bits, and the
 * length of that, of 31. */
static int64_t cqi_angle_between(cqi_vector u, cqi_vector v, cqi_vector *normal, int64_t *length)
{
    u = cqi_shift(u, cqi_bit_length((cqi_abs(u.x) | cqi_abs(u.y) | cqi_abs(u.z)) >> 14));
    v = cqi_shift(v, cqi_bit_length((cqi_abs(v.x) | cqi_abs(v.y) | cqi_abs(v.z)) >> 14));
    *normal = cqi_cross(u, v);
    *length = (int64_t)cqi_square_root((uint64_t)cqi_wide_dot(*normal, *normal));
    return cqi_angle(cqi_wide_dot(u, v), *length);
}

/* Adds a direction, divided by its length, times an angle of 18 bits: 43 bits for each of up to 26 directions. */
static void cqi_add_direction(cqi_vector64 *sum, cqi_vector a, int64_t length, int64_t angle)
{
    const int64_t weight = length ? angle * 0x1000000 / length : 0;
    sum->x += a.x * weight;
    sum->y += a.y * weight;
    sum->z += a.z * weight;
}

/* Adds the normal of a triangle, given the offsets of two corners from the third one, by the angle there. */
static void cqi_add_normal(cqi_vector64 *n, cqi_vector u, cqi_vector v)
{
    cqi_vector normal;
    int64_t length;
    const int64_t angle = cqi_angle_between(u, v, &normal, &length);
    cqi_add_direction(n, normal, length, angle);
}

/* Sum of the normals of the faces of a fan. */
static cqi_vector64 cqi_normal_of_fan(const cqi_fan *f)
{
    cqi_vector64 n = { 0, 0, 0 };
    int k;
    for (k = 0; k < f->size; k++)
        if (f->faces >> k & 1) cqi_add_normal(&n, f->at[cqi_next_of(k, f->size)], f->at[k]);
    return n;
}

/* The octahedral pair of a direction; 0 if it is the zero vector. */
static int cqi_pair_of(cqi_vector64 n, int32_t half, cqi_pair_of_normal *pair)
{
    const int64_t x = n.x < 0 ? -n.x : n.x, y = n.y < 0 ? -n.y : n.y, z = n.z < 0 ? -n.z : n.z;
    int64_t sum = x + y + z;
    int shift = 0;
    while (sum >> shift >> 38) shift++;
    sum >>= shift;
    if (!sum) return 0;
    pair->x = (int32_t)(((x >> shift) * half + sum / 2) / sum);
    pair->y = (int32_t)(((y >> shift) * half + sum / 2) / sum);
    if (n.x < 0) pair->x = -pair->x;
    if (n.y < 0) pair->y = -pair->y;
    if (n.z < 0) *pair = cqi_folded(*pair, half);
    return 1;
}

static cqi_pair_of_normal cqi_pair_at(const cq_value *values, uint32_t stride, cq_index row, int32_t half, int fold)
{
    cqi_pair_of_normal a;
    a.x = values[stride * (size_t)row] - half;
    a.y = values[stride * (size_t)row + 1] - half;
    return fold ? cqi_folded(a, half) : a;
}

/* Is this a channel of octahedral pairs? They are only predicted as such if there are positions. */
static int cqi_may_be_pair(const cq_channel *c)
{
    const int is_pair = (c->kind == CQ_NORMAL && c->components == 2) || (c->kind == CQ_TANGENT && c->components < 4);
    return is_pair && c->merge == CQ_AVERAGE && c->bits > 1 && c->bits <= 24;
}

static int cqi_has_pairs(const cq_decoder *d, uint32_t k)
{
    return d->located >= 0 && cqi_may_be_pair(&d->shape.channel[k]);
}

/* The mean distance, per component, of the pairs around from the one that is expected. */
static uint32_t cqi_spread_of_pairs(const cq_value *values, uint32_t stride, const cq_index *around, int n,
                                    int32_t half, int fold, cqi_pair_of_normal p)
{
    uint32_t sum = 0;
    int k;
    for (k = 0; k < n; k++) {
        const cqi_pair_of_normal a = cqi_pair_at(values, stride, around[k], half, fold);
        sum += (cqi_abs(a.x - p.x) + cqi_abs(a.y - p.y)) / (uint32_t)n;
    }
    return sum / 2;
}

/* Codes a pair, given the expected direction and the n rows around: those of the fan, or in the base the known ones, or
 * at a seam one or none. `turned`: the direction was turned to where the pair is, so that only rounding is left. */
static int cqi_code_pair_near(cq_decoder *d, uint32_t k, cq_index row, cqi_vector64 direction,
                                   const cq_index *around, int n, int turned, cq_index wedge)
{
    const cq_channel *channel = &d->shape.channel[k];
    const uint32_t stride = channel->components;
    cq_value *const values = d->channel[k], *const to = values + stride * (size_t)row;
    const int32_t half = cqi_octahedral_half(channel->bits);
    cqi_pair_of_normal expected, wanted = { 0, 0 };
    const int set = turned ? CQI_ROW_ROUNDING : n > 1 ? CQI_ROW_PAIR : CQI_ROW_PAIR_AT_SEAM;
    int fold, half_bits, odd = 0;
    if (!cqi_pair_of(direction, half, &expected))
        expected = n ? cqi_pair_at(values, stride, around[0], half, 0) : wanted;
    fold = (int32_t)(cqi_abs(expected.x) + cqi_abs(expected.y)) > half;
    if (fold) expected = cqi_folded(expected, half);
    half_bits = turned ? 0 : cqi_half_bits(cqi_spread_of_pairs(values, stride, around, n, half, fold, expected));
    if (CQI_ENCODING(d)) {
        wanted.x = cqi_plan_bits(d, k, 0, wedge) - half;
        wanted.y = cqi_plan_bits(d, k, 1, wedge) - half;
        if (fold) {
            const cqi_pair_of_normal in = cqi_folded(wanted, half), out = cqi_folded(in, half);
            odd = out.x != wanted.x || out.y != wanted.y;
            if (!odd) wanted = in;
        }
    }
    if (fold) odd = !cqi_code_bit(d, CQI_FOLDS_BACK, !odd);
    wanted.x = expected.x + cqi_code_row_residual(d, set, half_bits, 26, wanted.x - expected.x);
    wanted.y = expected.y + cqi_code_row_residual(d, set, half_bits, 26, wanted.y - expected.y);
    if (cqi_abs(wanted.x) >> 25 || cqi_abs(wanted.y) >> 25) return 0;
    if (fold && !odd) wanted = cqi_folded(wanted, half);
    if (!cqi_value_fits(channel, wanted.x + half) || !cqi_value_fits(channel, wanted.y + half)) return 0;
    to[0] = (cq_value)(wanted.x + half);
    to[1] = (cq_value)(wanted.y + half);
    return 1;
}

/* -- Tangents --
 *
 * The normal is coded first. In its plane, a tangent is expected in the direction that texture coordinates of faces
 * give, or in the mean direction of the tangents around. The angle by which it is turned from there is coded; what is
 * left for the pair is rounding. */

/* The direction of a pair, with |x| + |y| + |z| = half. */
static cqi_vector cqi_vector_of(cqi_pair_of_normal p, int32_t half)
{
    cqi_vector n = { 0, 0, 0 };
    n.z = half - (int32_t)cqi_abs(p.x) - (int32_t)cqi_abs(p.y);
    if (n.z < 0) p = cqi_folded(p, half);
    n.x = p.x;
    n.y = p.y;
    return n;
}

static cqi_vector64 cqi_wide_cross(cqi_vector a, cqi_vector b)
{
    cqi_vector64 n;
    n.x = cqi_minor(a.y, b.z, a.z, b.y);
    n.y = cqi_minor(a.z, b.x, a.x, b.z);
    n.z = cqi_minor(a.x, b.y, a.y, b.x);
    return n;
}

static int32_t cqi_half_of(const cq_channel *c) { return cqi_octahedral_half(c->bits); }

/* The first channel of octahedral normals, if it comes before channel k; or -1. */
static int cqi_normals_before(const cq_decoder *d, uint32_t k)
{
    uint32_t j;
    for (j = 0; j < k; j++)
        if (d->shape.channel[j].kind == CQ_NORMAL && cqi_has_pairs(d, j)) return (int)j;
    return -1;
}

/* The first channel before k of texture coordinates that are CQ_AVERAGE and not exact; or -1. */
static int cqi_texcoords_before(const cq_shape *s, uint32_t k)
{
    uint32_t j;
    for (j = 0; j < k; j++)
        if (s->channel[j].kind == CQ_TEXCOORD && s->channel[j].bits <= 24 && s->channel[j].merge == CQ_AVERAGE)
            return (int)j;
    return -1;
}

/* What the texture coordinates of faces say of a tangent: the direction in which the first coordinate grows, and on
 * which side of it the second one does. */
typedef struct cqi_growth {
    cqi_vector64 along;
    int64_t side;                             /* above 0 if on the left, seen from outside */
} cqi_growth;

/* Adds that of a triangle, weighted by its angle at one corner. a and b are the offsets of the other two corners from
 * it, of_a and of_b those of their texture coordinates. All have 25 bits, sums of two products 51, of which 20 are
 * used. */
static void cqi_add_growth(cqi_growth *g, cqi_vector a, cqi_vector b, const int32_t *of_a, const int32_t *of_b)
{
    const int64_t det = cqi_minor(of_a[0], of_b[1], of_a[1], of_b[0]), x = cqi_minor(a.x, of_b[1], b.x, of_a[1]);
    const int64_t y = cqi_minor(a.y, of_b[1], b.y, of_a[1]), z = cqi_minor(a.z, of_b[1], b.z, of_a[1]);
    const int shift = cqi_excess(x, y, z, 20);
    cqi_vector along = { 0, 0, 0 }, normal;
    int64_t length, angle = cqi_angle_between(a, b, &normal, &length);
    along.x = (int32_t)cqi_floor_shift_wide(x, shift);
    along.y = (int32_t)cqi_floor_shift_wide(y, shift);
    along.z = (int32_t)cqi_floor_shift_wide(z, shift);
    length = (int64_t)cqi_square_root((uint64_t)cqi_wide_dot(along, along));
    if (!det || !length) return;
    if (det < 0) angle = -angle;
    g->side += angle;
    cqi_add_direction(&g->along, along, length, angle);
}

/* The sum of these over the faces of a fan, that of vertex or row `own`. */
static cqi_growth cqi_growth_of_fan(const cq_decoder *d, uint32_t k, cq_index own)
{
    const cqi_fan *f = &d->now.fan;
    const int texcoords = cqi_texcoords_before(&d->shape, k);
    cqi_growth g = { { 0, 0, 0 }, 0 };
    int i;
    size_t c;
    for (i = 0; i < f->size && texcoords >= 0; i++) {
        const int next = cqi_next_of(i, f->size);
        const cq_value *const values = d->channel[texcoords];
        int32_t of_a[2], of_b[2];
        if (!(f->faces >> i & 1)) continue;
        for (c = 0; c < 2; c++) {
            of_a[c] = (int32_t)values[2 * (size_t)f->vertex[next] + c] - values[2 * (size_t)own + c];
            of_b[c] = (int32_t)values[2 * (size_t)f->vertex[i] + c] - values[2 * (size_t)own + c];
        }
        cqi_add_growth(&g, f->at[next], f->at[i], of_a, of_b);
    }
    return g;
}

/* Axes in the plane of a normal: at right angles and of the same length. */
typedef struct cqi_axes {
    cqi_vector t, side;
} cqi_axes;

/* Sets the axes: the part of a direction in the plane, and the same turned by a right angle. 0: it has no such part.
 * Vectors have 24 bits, cross products 49, and divided by the normal's length 26. */
static int cqi_find_axes(cqi_vector64 t, cqi_vector normal, int32_t half, cqi_axes *axes)
{
    const int64_t length = (int64_t)cqi_square_root((uint64_t)cqi_wide_dot(normal, normal));
    cqi_pair_of_normal p;
    if (!cqi_pair_of(t, half, &p) || !cqi_pair_of(cqi_wide_cross(normal, cqi_vector_of(p, half)), half, &p) ||
        !cqi_pair_of(cqi_wide_cross(cqi_vector_of(p, half), normal), half, &p))
        return 0;
    axes->t = cqi_vector_of(p, half);
    t = cqi_wide_cross(normal, axes->t);
    axes->side.x = (int32_t)(t.x / length);
    axes->side.y = (int32_t)(t.y / length);
    axes->side.z = (int32_t)(t.z / length);
    return 1;
}

/* The angle by which a tangent vector is turned from t, as its trigonometric tangent, in 1/half and at most 4. */
static int32_t cqi_turn_of(cqi_vector a, const cqi_axes *axes, int32_t half)
{
    const int64_t along = cqi_wide_dot(a, axes->t) / half, x = cqi_wide_dot(a, axes->side), most = 4 * (int64_t)half;
    if (along <= 0) return along || x ? 4 * half : 0;
    return (int32_t)cqi_clamp_wide((x < 0 ? x - along / 2 : x + along / 2) / along, most);
}

/* By how many right angles a tangent is turned from t, rounded. */
static int cqi_quarters_of(cqi_vector a, const cqi_axes *axes)
{
    const int64_t along = cqi_wide_dot(a, axes->t), x = cqi_wide_dot(a, axes->side);
    if ((x < 0 ? -x : x) > (along < 0 ? -along : along)) return x < 0 ? 3 : 1;
    return along < 0 ? 2 : 0;
}

static int cqi_code_quarters(cq_decoder *d, int by_faces, int quarters)
{
    if (cqi_code_bit(d, CQI_AHEAD + by_faces, !quarters)) return 0;
    if (cqi_code_bit(d, CQI_BACK + by_faces, quarters == 2)) return 2;
    return 1 + 2 * (int)cqi_code_raw(d, quarters == 3, 1);
}

static cqi_vector cqi_less(cqi_vector a)
{
    a.x = -a.x;
    a.y = -a.y;
    a.z = -a.z;
    return a;
}

static void cqi_turn_quarters(cqi_axes *axes, int quarters)
{
    const cqi_vector t = axes->t;
    if (quarters & 1) {
        axes->t = axes->side;
        axes->side = cqi_less(t);
    }
    if (quarters & 2) {
        axes->t = cqi_less(axes->t);
        axes->side = cqi_less(axes->side);
    }
}

static cqi_vector cqi_tangent_of(const cq_decoder *d, uint32_t k, cq_index row)
{
    const int32_t half = cqi_half_of(&d->shape.channel[k]);
    return cqi_vector_of(cqi_pair_at(d->channel[k], d->shape.channel[k].components, row, half, 0), half);
}

/* Axes by the mean of the tangents around. */
static int cqi_find_axes_around(const cq_decoder *d, uint32_t k, cqi_vector normal, const cq_index *around, int n,
                                cqi_axes *axes)
{
    cqi_vector64 sum = { 0, 0, 0 };
    int j;
    for (j = 0; j < n; j++) {
        const cqi_vector a = cqi_tangent_of(d, k, around[j]);
        sum.x += a.x;
        sum.y += a.y;
        sum.z += a.z;
    }
    return cqi_find_axes(sum, normal, cqi_half_of(&d->shape.channel[k]), axes);
}

/* The mean of how far the tangents around are turned from given axes. */
static uint32_t cqi_spread_of_turns(const cq_decoder *d, uint32_t k, const cq_index *around, int n,
                                    const cqi_axes *axes)
{
    const int32_t half = cqi_half_of(&d->shape.channel[k]);
    uint32_t sum = 0;
    int j;
    for (j = 0; j < n; j++) sum += cqi_abs(cqi_turn_of(cqi_tangent_of(d, k, around[j]), axes, half)) / (uint32_t)n;
    return sum;
}

/* Codes by how much the tangent is turned from the axes. Returns the direction that this gives, of up to 54 bits. */
static cqi_vector64 cqi_code_turn_from(cq_decoder *d, uint32_t k, cqi_axes axes, int by_faces, uint32_t spread,
                                        cq_index wedge)
{
    const int32_t half = cqi_half_of(&d->shape.channel[k]);
    cqi_vector wanted = { 0, 0, 0 };
    cqi_vector64 expected;
    int32_t turn = 0;
    if (CQI_ENCODING(d)) {
        cqi_pair_of_normal p;
        p.x = cqi_plan_bits(d, k, 0, wedge) - half;
        p.y = cqi_plan_bits(d, k, 1, wedge) - half;
        wanted = cqi_vector_of(p, half);
    }
    cqi_turn_quarters(&axes, cqi_code_quarters(d, by_faces, cqi_quarters_of(wanted, &axes)));
    if (CQI_ENCODING(d)) turn = cqi_turn_of(wanted, &axes, half);
    turn = cqi_code_row_residual(d, by_faces ? CQI_ROW_TURN_BY_FACES : CQI_ROW_TURN, cqi_half_bits(spread), 26, turn);
    expected.x = (int64_t)axes.t.x * half + (int64_t)axes.side.x * turn;
    expected.y = (int64_t)axes.t.y * half + (int64_t)axes.side.y * turn;
    expected.z = (int64_t)axes.t.z * half + (int64_t)axes.side.z * turn;
    return expected;
}

/* Learns which axes were nearer: those by faces, or those by tangents around. */
static void cqi_learn_trust(int32_t *trust, cqi_vector64 tangent, const cqi_axes *by_faces, const cqi_axes *around,
                            int32_t half)
{
    cqi_vector a = { 0, 0, 0 };
    a.x = (int32_t)(tangent.x / half);
    a.y = (int32_t)(tangent.y / half);
    a.z = (int32_t)(tangent.z / half);
    *trust += (int32_t)cqi_abs(cqi_turn_of(a, around, half)) - (int32_t)cqi_abs(cqi_turn_of(a, by_faces, half)) -
              *trust / 16;
}

/* The tangent is turned either from *direction, which faces give, or from the mean of the tangents around. Codes by how
 * much; *direction becomes that of the tangent. 0: there is no normal, or neither of the two directions. */
static int cqi_code_turn(cq_decoder *d, uint32_t k, cq_index row, cqi_vector64 *direction, const cq_index *around,
                         int n, cq_index wedge)
{
    const int normals = cqi_normals_before(d, k);
    int32_t *const trust = &d->model.trust[n > 1];
    cqi_vector normal;
    cqi_axes by_faces, by_others, *axes;
    int has_faces, has_others;
    if (normals < 0) return 0;
    normal = cqi_tangent_of(d, (uint32_t)normals, row);
    has_faces = cqi_find_axes(*direction, normal, cqi_half_of(&d->shape.channel[k]), &by_faces);
    has_others = cqi_find_axes_around(d, k, normal, around, n, &by_others);
    if (!has_faces && !has_others) return 0;
    axes = has_faces && (!has_others || *trust >= 0) ? &by_faces : &by_others;
    *direction = cqi_code_turn_from(d, k, *axes, axes == &by_faces, cqi_spread_of_turns(d, k, around, n, axes), wedge);
    if (has_faces && has_others)
        cqi_learn_trust(trust, *direction, &by_faces, &by_others, cqi_half_of(&d->shape.channel[k]));
    return 1;
}

/* The third component that a tangent may have, mostly a sign, 0 or 1: as faces say, or else as row `near` has it. */
static void cqi_code_sign(cq_decoder *d, uint32_t k, cq_index near, int64_t by_faces, cq_index row, cq_index wedge)
{
    const cq_channel *channel = &d->shape.channel[k];
    const int nearby = near != CQ_NONE && d->channel[k][3 * (size_t)near + 2] != 0;
    const int side = by_faces ? by_faces > 0 : nearby;
    int32_t x = CQI_ENCODING(d) ? cqi_plan_bits(d, k, 2, wedge) : 0;
    if (cqi_code_bit(d, CQI_SIDE_IS_BIT, x >> 1 == 0))
        x = side ^ !cqi_code_bit(d, CQI_SAME_SIDE + (by_faces != 0), x == side);
    else
        x = (int32_t)cqi_code_raw(d, (uint32_t)x, channel->bits);
    d->channel[k][3 * (size_t)row + 2] = (cq_value)x;
}

/* -- Pairs of both kinds -- */

static int cqi_pair_is(const cq_value *values, uint32_t stride, cq_index row, int32_t x, int32_t y)
{
    return values[stride * (size_t)row] == x && values[stride * (size_t)row + 1] == y;
}

/* Finds the commonest of the pairs around: *common is one row that has it. Returns how many have. */
static int cqi_find_common_pair(const cq_value *values, uint32_t stride, const cq_index *around, int n,
                                cq_index *common)
{
    int i, j, most = 0;
    for (i = 0; i < n; i++) {
        const cq_value *const a = values + stride * (size_t)around[i];
        int same = 0;
        for (j = 0; j < n; j++) same += cqi_pair_is(values, stride, around[j], a[0], a[1]);
        if (same <= most) continue;
        most = same;
        *common = around[i];
    }
    return most;
}

/* Is a pair equal to the commonest one around? Then it is copied. Not asked if all are different. */
static int cqi_code_common_pair(cq_decoder *d, uint32_t k, cq_index row, const cq_index *around, int n, cq_index wedge)
{
    const uint32_t stride = d->shape.channel[k].components;
    cq_value *const values = d->channel[k];
    cq_index common = 0;
    const int same = cqi_find_common_pair(values, stride, around, n, &common);
    int is_common = CQI_ENCODING(d);
    if (same < 2) return 0;
    if (is_common)
        is_common = cqi_pair_is(values, stride, common, cqi_plan_bits(d, k, 0, wedge), cqi_plan_bits(d, k, 1, wedge));
    if (!cqi_code_bit(d, CQI_COMMON_PAIR + cqi_at_most(n - same, 3), is_common)) return 0;
    memcpy(values + stride * (size_t)row, values + stride * (size_t)common, 2 * sizeof *values);
    return 1;
}

/* A pair: of a normal, by the faces of the fan; of a tangent, by their texture coordinates and the tangents around.
 * Even if n is 0, around[0] is read; it may then be CQ_NONE. */
static int cqi_code_expected_pair(cq_decoder *d, uint32_t k, cq_index row, const cq_index *around, int n,
                                  cq_index wedge)
{
    const cq_channel *channel = &d->shape.channel[k];
    const int is_tangent = channel->kind == CQ_TANGENT, is_common = cqi_code_common_pair(d, k, row, around, n, wedge);
    cqi_growth g = { { 0, 0, 0 }, 0 };
    if (is_tangent) g = cqi_growth_of_fan(d, k, row);
    else if (!is_common) g.along = cqi_normal_of_fan(&d->now.fan);
    if (!is_common) {
        const int turned = is_tangent && cqi_code_turn(d, k, row, &g.along, around, n, wedge);
        if (is_tangent && !turned) g.along.x = g.along.y = g.along.z = 0;
        if (!cqi_code_pair_near(d, k, row, g.along, around, n, turned, wedge)) return 0;
    }
    if (channel->components > 2) cqi_code_sign(d, k, around[0], g.side, row, wedge);
    return 1;
}

/* -- Other channels --
 *
 * Weights of skinning are predicted by the weights that the same joint has at other vertices, in whichever component,
 * as long as these have been nearer than the weights in the same component. And weights mostly have the same sum as
 * those of A. */

/* The channel of joints that goes with the weights of channel k: the n-th with the n-th, if it comes before and has as
 * many components; or -1. */
static int cqi_joints_of(const cq_shape *s, uint32_t k)
{
    uint32_t j, nth = 0, found = 0;
    if (s->channel[k].kind != CQ_WEIGHTS) return -1;
    for (j = 0; j < k; j++) nth += s->channel[j].kind == CQ_WEIGHTS && s->channel[j].merge != CQ_PER_FACE;
    for (j = 0; j < k; j++)
        if (s->channel[j].kind == CQ_JOINTS && s->channel[j].merge != CQ_PER_FACE && found++ == nth)
            return s->channel[j].components == s->channel[k].components ? (int)j : -1;
    return -1;
}

/* Component c of a vertex or row; or with a channel of joints, its weight for the joint in component c of B, or 0. */
static int32_t cqi_value_near(const cq_decoder *d, uint32_t k, uint32_t c, cq_index vertex, int joints)
{
    const uint32_t stride = d->shape.channel[k].components;
    const cq_value *const values = d->channel[k] + (size_t)vertex * stride, *joint;
    cq_value wanted;
    uint32_t j;
    if (joints < 0) return values[c];
    joint = d->channel[joints] + (size_t)vertex * stride;
    wanted = d->channel[joints][(size_t)d->mesh.num_vertices * stride + c];
    for (j = 0; j < stride; j++)
        if (joint[j] == wanted) return values[j];
    return 0;
}

/* What is left for component c of channel k and those after it, if the weights of B have the same sum as those of A;
 * modulo 2^32, as some may be exact. *more: A has weights other than 0 after that component. */
static int32_t cqi_rest_of_weights(const cq_decoder *d, uint32_t k, uint32_t c, cq_index a, int *more)
{
    const cq_shape *s = &d->shape;
    const cq_index b = d->mesh.num_vertices;
    int64_t rest = 0;
    uint32_t j, e;
    *more = 0;
    for (j = 0; j < s->num_channels; j++) {
        const uint32_t n = s->channel[j].components;
        if (s->channel[j].kind != CQ_WEIGHTS || s->channel[j].merge == CQ_PER_FACE) continue;
        for (e = 0; e < n; e++) {
            const int32_t of_a = d->channel[j][(size_t)a * n + e];
            rest += of_a;
            if (j < k || (j == k && e < c)) rest -= d->channel[j][(size_t)b * n + e];
            else *more |= of_a && (j > k || e > c);
        }
    }
    return (int32_t)(uint32_t)rest;
}

/* Is a weight of B all that is left of the sum? It usually is, if nothing is left or if A has no weights after it. */
static int cqi_code_rest(cq_decoder *d, uint32_t k, uint32_t c, cq_index input, int32_t *rest)
{
    int more, usual, is_rest;
    *rest = cqi_rest_of_weights(d, k, c, d->now.fan.vertex[0], &more);
    usual = !*rest || !more;
    is_rest = CQI_ENCODING(d) && cqi_plan_value(d, k, c, input) == *rest;
    return cqi_code_bit(d, CQI_REST + (*rest ? 1 + more : 0), is_rest == usual) == usual;
}

/* Sets f->scratch[0] to component c of the fan's vertices minus that of A, which is returned; all as cqi_rough gives
 * them. Also finds the mean of the differences, and the sum of their distances from it. */
static int32_t cqi_compare_fan(cq_decoder *d, uint32_t k, uint32_t c, int joints, int32_t *mean, uint32_t *spread)
{
    cqi_fan *f = &d->now.fan;
    const cq_channel *channel = &d->shape.channel[k];
    const int32_t a = cqi_rough(channel, cqi_value_near(d, k, c, f->vertex[0], joints));
    int32_t *const x = f->scratch[0], sum = 0;
    int n;
    for (n = 0; n < f->size; n++) sum += x[n] = cqi_rough(channel, cqi_value_near(d, k, c, f->vertex[n], joints)) - a;
    *mean = sum / f->size;
    for (n = 0, *spread = 0; n < f->size; n++) *spread += cqi_abs(x[n] - *mean);
    return a;
}

/* Without positions there are three features: how far the vertices beyond the fan's edges are from the middles of these
 * edges, on average; and A and the middle between the common neighbours, both minus the mean. */
static void cqi_find_plain_features(cq_decoder *d, uint32_t k, uint32_t c, int joints, int32_t a, int32_t mean,
                                    int32_t *feature)
{
    const cqi_fan *f = &d->now.fan;
    const int32_t *const x = f->scratch[0];
    int32_t outer = 0;
    int n, beyond = 0;
    for (n = 0; n < f->size; n++) {
        int32_t o;
        if (f->beyond[n] == CQ_NONE) continue;
        o = cqi_rough(&d->shape.channel[k], cqi_value_near(d, k, c, f->beyond[n], joints)) - a;
        outer += cqi_floor_shift(2 * o - x[n] - x[cqi_next_of(n, f->size)], 2);
        beyond++;
    }
    feature[0] = beyond ? 2 * (outer / beyond) : 0;
    feature[1] = -mean;
    feature[2] = f->boundary ? 0 : cqi_floor_shift(x[1] + x[f->size - 1], 1) - mean;
}

/* Learns which mean of the fan, by component or by joint, was nearer to this weight of B. Numbers have 25 bits, sums
 * and running means 30. */
static void cqi_learn_skin(cq_decoder *d, uint32_t k, uint32_t c, int32_t value)
{
    const cq_channel *channel = &d->shape.channel[k];
    const int joints = cqi_joints_of(&d->shape, k);
    int i;
    for (i = 0; i < 2 && joints >= 0; i++) {
        const cqi_fan *f = &d->now.fan;
        int32_t sum = 0;
        int n;
        for (n = 0; n < f->size; n++)
            sum += cqi_rough(channel, cqi_value_near(d, k, c, f->vertex[n], i ? joints : -1));
        d->model.skin[i] += (int32_t)cqi_abs(cqi_rough(channel, value) - sum / f->size) - d->model.skin[i] / 16;
    }
}

/* One component of B, or of one of its rows, by the fit; or without positions, by the linear prediction. */
static CQI_APART int cqi_code_number(cq_decoder *d, uint32_t k, uint32_t c, cq_index input, cq_value *to)
{
    const cq_channel *channel = &d->shape.channel[k];
    const int joints = d->model.skin[1] <= d->model.skin[0] ? cqi_joints_of(&d->shape, k) : -1;
    const uint32_t size = (uint32_t)d->now.fan.size;
    int16_t *const weight = d->model.plain[k];
    int32_t feature[CQI_FEATURES], mean, p;
    uint32_t spread, off;
    int n, half_bits, features = d->located >= 0 ? 1 : CQI_FEATURES;
    if (channel->kind == CQ_WEIGHTS && channel->bits <= 24 && cqi_code_rest(d, k, c, input, &p)) {
        *to = (cq_value)p;
        return cqi_value_fits(channel, p);
    }
    p = cqi_compare_fan(d, k, c, joints, &mean, &spread);
    off = spread;
    if (d->located >= 0) feature[0] = cqi_fit(&d->now.fan, d->now.fan.scratch[0], mean, &off);
    else cqi_find_plain_features(d, k, c, joints, p, mean, feature);
    p += mean;
    for (n = 0; n < features; n++) p += cqi_product(feature[n], weight[n], CQI_LINEAR_BITS);
    p = cqi_unrough(channel, p);
    half_bits = (cqi_half_bits(spread / size) + cqi_half_bits(off / size)) / 2;
    if (!cqi_code_row_value(d, k, c, CQI_ROW_FITTED, half_bits, p, input, to)) return 0;
    p = cqi_difference(cqi_number(channel, *to), p);
    for (n = 0; n < features; n++) cqi_follow(&weight[n], (int64_t)p * feature[n]);
    if (channel->kind == CQ_WEIGHTS) cqi_learn_skin(d, k, c, *to);
    return 1;
}

/* Is this a channel of texture coordinates that a similarity predicts? */
static int cqi_is_texture(const cq_decoder *d, uint32_t k)
{
    const cq_channel *channel = &d->shape.channel[k];
    return d->located >= 0 && channel->kind == CQ_TEXCOORD && channel->merge == CQ_AVERAGE && channel->components == 2;
}

/* Sets f->scratch to the texture coordinates of the fan's first n vertices minus those of the first one, which go to
 * `first`. The differences are shifted to 20 bits; returns by how many bits to the left. */
static int cqi_compare_textures(cq_decoder *d, uint32_t k, int n, int32_t *first)
{
    cqi_fan *f = &d->now.fan;
    const cq_channel *channel = &d->shape.channel[k];
    uint32_t all = 0;
    int c, j, up;
    for (c = 0; c < 2; c++) {
        const cq_value *const values = d->channel[k] + c;
        first[c] = cqi_rough(channel, values[2 * (size_t)f->vertex[0]]);
        for (j = 0; j < n; j++) {
            f->scratch[c][j] = cqi_rough(channel, values[2 * (size_t)f->vertex[j]]) - first[c];
            all |= cqi_abs(f->scratch[c][j]);
        }
    }
    up = 20 - cqi_bit_length(all);
    for (c = 0; c < 2; c++)
        for (j = 0; j < n; j++) f->scratch[c][j] = cqi_unscaled(f->scratch[c][j], -up);
    return up;
}

/* Texture coordinates of B, or of a row, by the first n vertices of its fan. */
static CQI_APART int cqi_code_texture(cq_decoder *d, uint32_t k, int n, int set, cq_index input, cq_value *to)
{
    const cq_channel *channel = &d->shape.channel[k];
    cqi_similarity s;
    int32_t first[2], p[2];
    uint32_t misses;
    int c, half_bits;
    const int up = cqi_compare_textures(d, k, n, first);
    cqi_fit_similarity(&d->now.fan, n, &d->model.mirror, &s);
    misses = cqi_misses(&d->now.fan, n, &s) / (uint32_t)(2 * n);
    half_bits = up < 0 ? cqi_half_bits(misses) - 2 * up : cqi_half_bits(misses >> up);
    cqi_map_place(&s, 0, 0, 2 * (int64_t)s.most, p);
    p[0] += s.u;
    p[1] += s.v;
    for (c = 0; c < 2; c++) {
        const int32_t expected = cqi_unrough(channel, first[c] + cqi_unscaled(p[c], up));
        if (!cqi_code_row_value(d, k, (uint32_t)c, set, half_bits, expected, input, to + c)) return 0;
    }
    return 1;
}

/* One component of B, mostly a copy of a neighbour's: asks about A, then the common neighbours, then the others.
 * Whatever comes is in range: a neighbour has it, or it has as many bits as the channel. */
static CQI_APART int cqi_code_copied(cq_decoder *d, uint32_t k, uint32_t c, cq_index input, cq_value *to)
{
    enum { ASKED = 6 };
    const cqi_fan *f = &d->now.fan;
    const uint32_t stride = d->shape.channel[k].components;
    const cq_value *values = d->channel[k] + c;
    int32_t beside[ASKED], x = 0;
    const int n = cqi_at_most(f->size, ASKED);
    int j;
    for (j = 0; j < n; j++) beside[j] = values[f->vertex[j == 2 ? f->size - 1 : j > 2 ? j - 1 : j] * (size_t)stride];
    if (CQI_ENCODING(d)) x = cqi_plan_bits(d, k, c, input);
    x = cqi_code_copy(d, d->shape.channel[k].bits, beside, n, x);
    *to = (cq_value)x;
    return 1;
}

/* Joints nearby: the same component of B's first neighbours, then other components of A and the common neighbours. */
enum { CQI_AT_PLACE = 6, CQI_JOINTS_NEARBY = CQI_AT_PLACE + 3 * (CQ_MAX_COMPONENTS - 1) };
static int cqi_list_joints(const cq_decoder *d, uint32_t k, uint32_t c, int32_t *near)
{
    const cqi_fan *f = &d->now.fan;
    const uint32_t stride = d->shape.channel[k].components;
    int n = 0, at;
    uint32_t e;
    for (at = 0; at < f->size && at < CQI_AT_PLACE; at++)
        near[n++] = d->channel[k][f->vertex[at == 2 ? f->size - 1 : at > 2 ? at - 1 : at] * (size_t)stride + c];
    for (at = 0; at < 3; at++)
        for (e = 0; e < stride; e++)
            if (e != c) near[n++] = d->channel[k][f->vertex[at == 2 ? f->size - 1 : at] * (size_t)stride + e];
    return n;
}

/* A joint of B, mostly one of those nearby. Those other than 0 that B has already are asked about last. */
static CQI_APART int cqi_code_joint(cq_decoder *d, uint32_t k, uint32_t c, cq_index input, cq_value *to)
{
    enum { ASKED = 9 };
    int32_t near[CQI_JOINTS_NEARBY], x = CQI_ENCODING(d) ? cqi_plan_bits(d, k, c, input) : 0;
    const int n = cqi_list_joints(d, k, c, near);
    int i, j, refused = 0;
    uint32_t e;
    for (i = 0; i < 2 * n && refused < ASKED; i++) {
        const int32_t joint = near[i % n];
        int same = 0, asked = 0, had = 0;
        for (e = 0; e < c && joint; e++) had |= (to - c)[e] == joint;
        for (j = 0; j < n; j++) {
            same += near[j] == joint;
            asked |= j < i % n && near[j] == joint;
        }
        if (asked || had != (i >= n)) continue;
        *to = (cq_value)joint;
        if (cqi_code_bit(d, CQI_OTHER_JOINT + 4 * cqi_at_most(refused, 5) + cqi_at_most(same, 4) - 1, x == joint))
            return 1;
        refused++;
    }
    x = (int32_t)cqi_code_raw(d, (uint32_t)x, d->shape.channel[k].bits);
    *to = (cq_value)x;
    return cqi_value_fits(&d->shape.channel[k], x);
}

/* Channel k of B, or of one of its rows, by its fan. `own`: number of the vertex or row. */
static int cqi_code_by_fan(cq_decoder *d, uint32_t k, cq_index own, cq_index input)
{
    const cq_channel *channel = &d->shape.channel[k];
    cqi_fan *f = &d->now.fan;
    cq_value *to = d->channel[k] + (size_t)own * channel->components;
    uint32_t c;
    if (cqi_has_pairs(d, k)) return cqi_code_expected_pair(d, k, own, f->vertex, f->size, input);
    if (d->located >= 0 && channel->merge != CQ_COPY) cqi_flatten_fan(f);
    if (cqi_is_texture(d, k)) return cqi_code_texture(d, k, f->size, CQI_ROW_TEXTURE, input, to);
    for (c = 0; c < channel->components; c++) {
        const int joint = channel->kind == CQ_JOINTS && channel->merge == CQ_COPY;
        const int ok = joint ? cqi_code_joint(d, k, c, input, to + c)
                     : channel->merge == CQ_COPY ? cqi_code_copied(d, k, c, input, to + c)
                                                 : cqi_code_number(d, k, c, input, to + c);
        if (!ok) return 0;
    }
    return 1;
}

/* All values of B, its position first, and of the new faces. */
static int cqi_code_values(cq_decoder *d, int p, int q, cq_index input, cq_index b)
{
    uint32_t k;
    if (d->materials && !cqi_code_new_materials(d, p, q)) return 0;
    if (d->located >= 0) {
        k = (uint32_t)d->located;
        if (!cqi_code_position(d, k, p, q, input, d->channel[k] + 3 * (size_t)b)) return 0;
        CQI_TRACE(d, CQ_EVENT_VALUES, k, b, 0);
        cqi_charge_channel(d, k);
    }
    if (!CQI_HAS_ATTRIBUTES || d->shape.num_channels == (uint32_t)(d->located >= 0)) return 1;
    cqi_locate_fan_of_b(d, p, q);
    for (k = 0; k < d->shape.num_channels; k++) {
        const int of = cqi_class(&d->shape, k);
        if ((int)k == d->located) continue;
        if (of == CQI_OF_FACE) cqi_code_new_faces(d, k, p, q);
        else if (of == CQI_OF_VERTEX && !cqi_code_by_fan(d, k, b, input)) return 0;
        CQI_TRACE_IF(of == CQI_OF_VERTEX, d, CQ_EVENT_VALUES, k, b, 0);
        cqi_charge_channel(d, k);
    }
    return 1;
}

/* -- Conquest (sections 2.2 to 2.4 of the paper) ---------------------------------------------------------------------
 *
 * When a patch is conquered, the vertices in front of its gates are queued, each with the first gate that found it; and
 * if the patch's flag says so, its centre is split at once. A vertex that is still free when its turn comes is the
 * centre of the next patch: nothing around it has changed since it was queued. */

static int cqi_state(const cq_mesh *m, cq_index v) { return m->mark[v] & CQI_STATE; }

static void cqi_take_vertex(cq_mesh *m, cq_index v) { m->mark[v] |= CQI_TAKEN; }

/* Virtual vertices are never the centre of a patch. */
static void cqi_take_virtual(cq_mesh *m) { memset(m->mark + m->first_virtual, CQI_TAKEN, m->num_virtual); }

/* Reads and holds the ring of the spoke's origin, of at most CQ_MAX_VALENCE vertices. Returns how many were free. */
static int cqi_read_ring(cq_mesh *m, cqi_ring *r, cq_index spoke)
{
    const cq_index *const origin = m->origin, *const twin = m->twin;
    cq_index h = spoke;
    int n = 0, available = 0;
    r->boundary = CQ_MAX_VALENCE;
    do {
        const cq_index in = twin[h], v = origin[in];
        const cq_index valence = m->valence[v] < CQI_LARGE_VALENCE ? m->valence[v] : (cq_index)CQI_LARGE_VALENCE;
        uint8_t *const mark = m->mark + v;
        const int state = *mark & CQI_STATE;
        *mark = (uint8_t)(*mark + (state < CQI_HELD_OFTEN));
        r->spoke[n] = h;
        h = cq_next(in);
        r->vertex[n] = v;
        r->kind[n] = (uint8_t)(CQI_ANGLES + 4 * (valence - CQI_SMALL_VALENCE) + (cq_index)state);
        available += state == CQI_FREE;
        if (cq_is_virtual(m, v)) r->boundary = n;
        n++;
    } while (h != spoke);
    r->size = n;
    return available;
}

/* Undoes cqi_read_ring: the patch is not conquered. */
static void cqi_release_ring(cq_mesh *m, const cqi_ring *r)
{
    int k;
    for (k = 0; k < r->size; k++)
        if ((r->kind[k] & CQI_STATE) < CQI_HELD_OFTEN) m->mark[r->vertex[k]]--;
}

/* Queues a vertex that is free and does not wait yet, with its spoke to the L of the gate. If there is no room, an
 * encoder gives up the level, and a decoder the stream. */
static void cqi_enqueue(cq_mesh *m, cqi_walk *w, cq_index v, cq_index spoke)
{
    if (m->mark[v] & (CQI_STATE | CQI_QUEUED)) return;
    if (w->count == w->capacity) {
        w->full = 1;
        return;
    }
    w->queue[w->head < w->capacity - w->count ? w->head + w->count : w->head - (w->capacity - w->count)] = v;
    w->count++;
    m->mark[v] |= CQI_QUEUED;
    m->out[v] = spoke;
}

/* Queues the vertices in front of the patch's gates: first across the ring edge from the last spoke to the first one,
 * then on counter-clockwise, which costs fewer bits than clockwise. */
static void cqi_queue_fronts(cq_mesh *m, cqi_walk *w, cqi_ring *r)
{
    const cq_index *const origin = m->origin, *const twin = m->twin;
    cq_index spoke = r->spoke[0]; /* the ring edge is in its face */
    int k;
    for (k = r->size - 1; k >= 0; k--) {
        const cq_index beyond = cq_prev(twin[cq_next(spoke)]), v = origin[beyond];
        spoke = r->spoke[k];
        r->front[k] = v;
        cqi_enqueue(m, w, v, beyond);
    }
}

/* Queues the neighbours of a vertex that is passed over, each with its spoke to that vertex, clockwise from the first
 * spoke on. A neighbour that is removed before its turn makes no difference: the vertex that it is collapsed into is in
 * the queue before it. Takes time proportional to the number of neighbours. */
static void cqi_queue_neighbours(cq_mesh *m, cqi_walk *w, cq_index spoke)
{
    cq_index h = spoke;
    do {
        const cq_index in = m->twin[h];
        cqi_enqueue(m, w, m->origin[in], in);
        h = cq_next(in);
    } while (h != spoke);
}

/* Holds a free vertex: it can no longer become a centre or be removed. */
static void cqi_hold(cq_mesh *m, cq_index v) { m->mark[v]++; }

/* The vertex of the queue that has its turn after this many others. */
static cq_index cqi_queued(const cqi_walk *w, cq_index after)
{
    return w->queue[w->head < w->capacity - after ? w->head + after : w->head - (w->capacity - after)];
}

/* Prefetches vertices of the queue, and the first faces of nearer ones. A vertex that has been removed has no spoke. */
static CQI_INLINED void cqi_expect_patches(const cq_mesh *m, const cqi_walk *w)
{
    cq_index v, h;
    if (w->count < CQI_MANY) return;
    v = cqi_queued(w, CQI_FETCH_AHEAD);
    CQI_SOON(&m->out[v]);
    CQI_SOON(&m->mark[v]);
    CQI_SOON(&m->valence[v]);
    h = m->out[cqi_queued(w, CQI_FETCH_AHEAD / 2)];
    if (h == CQ_NONE) return;
    CQI_SOON(&m->twin[h]);
    CQI_SOON(&m->origin[h]);
    h = m->out[cqi_queued(w, CQI_FETCH_AHEAD / 4)];
    if (h == CQ_NONE) return;
    CQI_SOON(&m->twin[m->twin[h]]);
    CQI_SOON(&m->origin[m->twin[h]]);
}

/* The next vertex of the queue that is free; CQ_NONE if there is none. */
static cq_index cqi_dequeue(const cq_mesh *m, cqi_walk *w)
{
    while (w->count) {
        const cq_index v = w->queue[w->head];
        w->head = (cq_index)(w->head + 1 < w->capacity ? w->head + 1 : 0);
        w->count--;
        cqi_expect_patches(m, w);
        if (cqi_state(m, v) == CQI_FREE) return v;
    }
    return CQ_NONE;
}

/* The first spoke of the first patch of a component (section 2.4), given the first gate L -> R. `side` says which
 * vertex is the centre. 0: the front vertex, on the side where that is real; 1: L, and its ring ends at R; 2: R, and
 * its ring begins at L. */
static cq_index cqi_first_spoke(const cq_mesh *m, cq_index gate, int side)
{
    if (side == 1) return cq_clockwise(m, gate);
    if (side == 2) return m->twin[gate];
    return cq_prev(cq_is_virtual(m, m->origin[cq_prev(gate)]) ? m->twin[gate] : gate);
}

/* -- The pair: which two neighbours of A are neighbours of B, too --
 *
 * A centre of valence D has D (D - 1) / 2 pairs p < q; the paper's indices are i = p and j = D - 1 - q. A pair's score
 * is the sum of the weights of its features. Pairs are tried in the order of their scores, the best first: "is it this
 * one?" is asked with a probability that is a logistic function of the score and of how far it is above the next one.
 * Each answer moves the weights along the gradient (online logistic regression). The features are:
 *
 *     of p and q           angles opposite to the spoke, valence and state of the vertex
 *     of p + 1 .. q - 1    the same angles, and the length of the spoke: these become neighbours of B alone
 *     of both              q - p, by the centre's valence
 *     by the rule          whether the encoder's rule would rather have removed another vertex, see cqi_score_rule
 *
 * Without positions all lengths and angles are of one class, and tell nothing. */

#define CQI_TRIED (-0x2000000) /* instead of the score of a pair that was tried: far below any score */
#define CQI_TRIES 16      /* pairs that are tried before the number of the pair is coded */
#define CQI_LEARN(located) ((located) ? 7 : 8) /* a weight moves by 2^-7 or 2^-8 of the error */

/* 65536 / (1 + exp(-(k - 63.5) / 8)) for k = 24 .. 103. */
static const uint16_t cqi_logistic[80] = {
    467, 528, 598, 677, 766, 867, 980, 1109, 1253, 1417, 1601, 1808, 2041, 2303, 2598, 2928,
    3298, 3713, 4176, 4692, 5266, 5904, 6611, 7392, 8252, 9197, 10230, 11357, 12579, 13898, 15316, 16832,
    18442, 20143, 21928, 23788, 25712, 27689, 29705, 31744, 33792, 35831, 37847, 39824, 41748, 43608, 45393, 47094,
    48704, 50220, 51638, 52957, 54179, 55306, 56339, 57284, 58144, 58925, 59632, 60270, 60844, 61360, 61823, 62238,
    62608, 62938, 63233, 63495, 63728, 63935, 64119, 64283, 64427, 64556, 64669, 64770, 64859, 64938, 65008, 65069
};

/* Codes a yes or no whose log-odds are `score`. *error: what is to be added to the weights. */
static inline int cqi_code_decision(cq_decoder *d, int32_t score, int yes, int32_t *error)
{
    const int shift = 16 - CQI_NAT_BITS + CQI_TUNED(learn, CQI_LEARN(d->located >= 0));
    int32_t k = cqi_floor_shift(score, CQI_NAT_BITS - 3) + 40;
    uint32_t p;
    k = k < 0 ? 0 : k > 79 ? 79 : k;
    p = cqi_logistic[k];
    yes = cqi_code_part(d, p, yes);
    *error = cqi_floor_shift((yes ? 65536 : 0) - (int32_t)p + (1 << (shift - 1)), shift);
    return yes;
}

/* 0 for 0; else a number of one bit more than x has without its sign bit. */
static inline uint32_t cqi_changes_of_bits(int32_t x) { return (uint32_t)x ^ (uint32_t)x << 1; }

/* Offsets of the ring's vertices from the centre; and the ring's scale. */
static void cqi_locate_ring(const cq_mesh *m, const cq_value *values, cqi_ring *r)
{
    const cq_value *const a = values + 3 * (size_t)m->origin[r->spoke[0]];
    const int32_t ax = a[0], ay = a[1], az = a[2];
    cqi_vector *const at = r->at;
    const int size = r->size, boundary = r->boundary;
    uint32_t all = 0;
    int k;
    for (k = 0; k < size; k++) {
        const cq_value *const b = k == boundary ? a : values + 3 * (size_t)r->vertex[k];
        at[k].x = b[0] - ax;
        at[k].y = b[1] - ay;
        at[k].z = b[2] - az;
        all |= cqi_changes_of_bits(at[k].x) | cqi_changes_of_bits(at[k].y) | cqi_changes_of_bits(at[k].z);
    }
    r->shift = cqi_at_most(CQI_RING_BITS + 1 - cqi_bit_length(all), CQI_FRACTION);
    r->right = r->shift < 0 ? -r->shift : 0;
    r->factor = (int32_t)1 << (r->shift + r->right);
}

/* Class of a spoke's length, by its ratio to the mean of the two shortest ones. Logarithms are of squares. */
static uint8_t cqi_length_class(int logarithm, int base)
{
    return (uint8_t)(CQI_ANGLES + cqi_clamp(cqi_floor_shift(3 * (logarithm - base), 3), 0, CQI_LENGTHS - 2));
}

/* Scales the offsets; returns the logarithm where the classes of lengths begin. */
static int cqi_measure_spokes(cqi_ring *r)
{
    const int32_t factor = r->factor;
    const int right = r->right, boundary = r->boundary, size = r->size;
    int shortest = 255, second = 255, k;
    for (k = 0; k < size; k++) {
        const cqi_vector at = cqi_shift(cqi_scale(r->at[k], factor), right);
        const int32_t square = cqi_dot(at, at);
        const int x = k == boundary ? 255 : cqi_logarithm((uint32_t)square + 8);
        const int larger = x > shortest ? x : shortest;
        r->at[k] = at;
        r->square[k] = square;
        r->length[k] = (uint8_t)x;
        second = larger < second ? larger : second;
        shortest = x < shortest ? x : shortest;
    }
    return (shortest + second) / 2 - 8;
}

/* Classes of the sum of the two angles opposite to each spoke, as in the Delaunay criterion. In the triangle of spokes
 * a and b, the angle opposite to a has the cosine b (b - a) / (|b| |b - a|). In place of that product of lengths, both
 * angles take half the sum of the squares of all sides, a a + b b - a b: this gives 1/3 if the sides are equal, and the
 * less the larger the angle is. Squares have 30 bits, the sum has 32, and quotients are in 1/65536. */
static uint8_t cqi_angle_class(int32_t narrow)
{
    return (uint8_t)cqi_clamp(cqi_floor_shift(narrow, 12) + 1, 0, CQI_ANGLES - 1);
}

static void cqi_classify_spokes(cqi_ring *r, int base)
{
    const int size = r->size;
    int32_t first = 0, before = 0;
    int k;
    r->at[size] = r->at[0];
    r->square[size] = r->square[0];
    for (k = 0; k < size; k++) {
        const int32_t dot = cqi_dot(r->at[k], r->at[k + 1]), of_a = r->square[k + 1] - dot, of_b = r->square[k] - dot;
        const uint32_t sum = (uint32_t)r->square[k] + (uint32_t)of_a;
        const int32_t inverse = (int32_t)(0x10000u / ((sum >> 14) + 1)), here = cqi_floor_shift(of_a, 14) * inverse;
        r->length[k] = cqi_length_class(r->length[k], base);
        r->opposite[k] = cqi_angle_class(here + before);
        if (!k) first = here;
        before = cqi_floor_shift(of_b, 14) * inverse;
    }
    r->opposite[0] = cqi_angle_class(first + before);
    if (r->boundary < CQ_MAX_VALENCE) r->length[r->boundary] = CQI_ANGLES + CQI_LENGTHS - 1;
}

/* Classes of the ring's vertices by their positions. */
static void cqi_classify_ring(cq_decoder *d)
{
    cqi_ring *r = &d->ring;
    if (d->located >= 0) {
        cqi_locate_ring(&d->mesh, d->channel[d->located], r);
        cqi_classify_spokes(r, cqi_measure_spokes(r));
    } else {
        memset(r->opposite, 0, sizeof r->opposite);
        memset(r->length, CQI_ANGLES, sizeof r->length);
    }
}

static void cqi_score_ends(const int16_t *w, const cqi_ring *r, cqi_choice *c)
{
    const int16_t *const of_end = w + CQI_END, *const of_between = w + CQI_BETWEEN;
    const int size = r->size;
    int32_t between = 0;
    int k;
    for (k = 0; k < size; k++) {
        const int opposite = r->opposite[k];
        const int32_t end = of_end[opposite] + of_end[r->kind[k]];
        c->end_q[k] = end + between;
        between += of_between[opposite] + of_between[r->length[k]];
        c->end_p[k] = end - between;
    }
}

/* The valence of vertex k of the ring if it is free, so that it could have been B instead; else CQI_LARGE_VALENCE. */
static int cqi_valence_of_free(const cqi_ring *r, int k)
{
    const int kind = r->kind[k];
    return kind & CQI_STATE ? (int)CQI_LARGE_VALENCE : (kind - CQI_ANGLES) / 4 + CQI_SMALL_VALENCE;
}

/* The smallest valence of a vertex that could have been B instead: from the first place of the ring to each p, and from
 * each q to the last place. p and q themselves had one neighbour more when B was chosen. before[] has p added, for the
 * index of a weight. */
static void cqi_find_alternatives(const cqi_ring *r, cqi_choice *c)
{
    int smallest = CQI_LARGE_VALENCE, k;
    for (k = 0; k < r->size; k++) {
        const int valence = cqi_valence_of_free(r, k);
        c->before[k] = (uint8_t)(cqi_at_most(valence + 1, smallest) + k);
        smallest = cqi_at_most(valence, smallest);
    }
    for (smallest = CQI_LARGE_VALENCE; k--;) {
        const int valence = cqi_valence_of_free(r, k);
        c->after[k] = (uint8_t)cqi_at_most(valence + 1, smallest);
        smallest = cqi_at_most(valence, smallest);
    }
}

static int32_t cqi_best_of(const int32_t *score, int n)
{
    const int32_t *const end = score + n;
    int32_t best = *score;
    while (++score < end) best = *score > best ? *score : best;
    return best;
}

/* A score and its q as one number: larger for a higher score, and with equal scores for a larger q. Cannot overflow: a
 * score is a sum of at most 52 weights, of 16 bits. */
static inline int32_t cqi_ranked(int32_t score, int q) { return score * 32 + q; }

/* Adds to the scores how likely it is that the encoder's rule, the smallest valence, would have removed B rather than
 * the best alternative up to p, or the best one from q on: weights by the alternative's valence minus that of B. With
 * goals other than CQ_LEAST_CONNECTIVITY, this would save no more than 0.03 bit. */
static int32_t cqi_score_rule(const int16_t *w, const cqi_ring *r, cqi_choice *c)
{
    int32_t *score = c->score, top = 32 * CQI_TRIED;
    int p, q;
    cqi_find_alternatives(r, c);
    for (q = 1; q < r->size; score += q++) {
        const int16_t *const before = w + CQI_RULE + CQ_MAX_VALENCE - q;
        const int16_t *const after = before + CQI_RULE_CLASSES + c->after[q];
        for (p = 0; p < q; p++) score[p] += before[c->before[p]] + after[p];
        c->best[q] = cqi_ranked(c->end_q[q] + cqi_best_of(score, q), q);
        top = c->best[q] > top ? c->best[q] : top;
    }
    return top;
}

/* The scores of all pairs; returns the highest one, see cqi_ranked. */
static int32_t cqi_score_pairs(cq_decoder *d)
{
    cqi_choice *c = &d->now.choice;
    const int16_t *const w = d->model.weight, *of_steps;
    const int size = d->ring.size;
    int32_t *score = c->score, top = 32 * CQI_TRIED;
    int p, q;
    c->steps = CQI_STEPS + CQ_MAX_VALENCE * cqi_clamp(size - 3, 0, 9);
    of_steps = w + c->steps;
    cqi_score_ends(w, &d->ring, c);
    for (q = 1; q < size; score += q++) {
        int32_t best = CQI_TRIED;
        for (p = 0; p < q; p++) {
            const int32_t x = c->end_p[p] + of_steps[q - p];
            score[p] = x;
            best = x > best ? x : best;
        }
        best = c->best[q] = cqi_ranked(c->end_q[q] + best, q);
        top = best > top ? best : top;
    }
    return d->ruled ? cqi_score_rule(w, &d->ring, c) : top;
}

/* Takes out the best of the pairs with this q, the first of equal ones; returns its p. */
static int cqi_take_best(cqi_choice *c, int q, int32_t best)
{
    int32_t *const score = c->score + ((unsigned)(q * (q - 1)) >> 1);
    int p = 0;
    best -= c->end_q[q];
    while (score[p] != best) p++;
    score[p] = CQI_TRIED;
    c->best[q] = cqi_ranked(c->end_q[q] + cqi_best_of(score, q), q);
    return p;
}

/* Class of a score's distance from the next one, a >= b. */
static int cqi_gap(int32_t a, int32_t b)
{
    const uint32_t x = ((uint32_t)a - (uint32_t)b) >> (CQI_NAT_BITS - 2);
    return x > 31 ? 31 : (int)x;
}

/* Moves all weights of a pair's score. */
static void cqi_learn_pair(cq_decoder *d, int p, int q, int32_t error)
{
    const cqi_ring *r = &d->ring;
    int16_t *w = d->model.weight;
    int k;
    cqi_nudge(&w[CQI_END + r->opposite[p]], error);
    cqi_nudge(&w[CQI_END + r->kind[p]], error);
    cqi_nudge(&w[CQI_END + r->opposite[q]], error);
    cqi_nudge(&w[CQI_END + r->kind[q]], error);
    for (k = p + 1; k < q; k++) {
        cqi_nudge(&w[CQI_BETWEEN + r->opposite[k]], error);
        cqi_nudge(&w[CQI_BETWEEN + r->length[k]], error);
    }
    cqi_nudge(&w[d->now.choice.steps + q - p], error);
    if (!d->ruled) return;
    w += CQI_RULE + CQ_MAX_VALENCE - q;
    cqi_nudge(&w[d->now.choice.before[p]], error);
    cqi_nudge(&w[CQI_RULE_CLASSES + d->now.choice.after[q] + p], error);
}

/* Is it the pair p, q? Asks, given its score and that of the next one, and learns from the answer. */
static int cqi_code_try(cq_decoder *d, int rank, int p, int q, int yes, int32_t score, int32_t next)
{
    int16_t *const of_gap = d->model.weight + CQI_GAP + 32 * cqi_at_most(rank, 7) + cqi_gap(score, next);
    int32_t error;
    yes = cqi_code_decision(d, score + *of_gap, yes, &error);
    if (!error) return yes;
    cqi_nudge(of_gap, error);
    cqi_learn_pair(d, p, q, error);
    return yes;
}

/* Codes the pair by its number among all. */
static void cqi_code_any_pair(cq_decoder *d, int *p, int *q)
{
    const uint32_t all = (uint32_t)(d->ring.size * (d->ring.size - 1) / 2);
    const int number = (int)cqi_code_uniform(d, (uint32_t)(*q * (*q - 1) / 2 + *p), all);
    for (*q = 1; number >= *q * (*q + 1) / 2;) ++*q;
    *p = number - *q * (*q - 1) / 2;
}

/* Codes the pair p, q of the patch. */
static CQI_APART void cqi_code_pair(cq_decoder *d, int *p, int *q)
{
    cqi_choice *c = &d->now.choice;
    int32_t next;
    int rank;
    cqi_classify_ring(d);
    next = cqi_score_pairs(d);
    for (rank = 0; rank < CQI_TRIES && next > 16 * CQI_TRIED; rank++) {
        const int32_t score = cqi_floor_shift(next, 5);
        const int best_q = next & 31, best_p = cqi_take_best(c, best_q, score);
        next = cqi_best_of(c->best + 1, d->ring.size - 1);
        if (cqi_code_try(d, rank, best_p, best_q, best_p == *p && best_q == *q, score, cqi_floor_shift(next, 5))) {
            *p = best_p;
            *q = best_q;
            return;
        }
    }
    cqi_code_any_pair(d, p, q);
}

/* A level must add one vertex for every 16 that take part in it: so all levels together take linear time. */
#define CQI_MIN_SPLITS(num_vertices) ((num_vertices) / 16 + 1)

/* -- Patches --
 *
 * What happens at each patch of a conquest: its flag, its split, and what an encoder notes of both. */

#define CQI_AT_ONCE 1024 /* vertices that one step prepares: bounds its time */

#define CQI_HUB (CQ_MAX_VALENCE / 2 + 1) /* least valence of a vertex that may be passed over, see cqi_code_pass */

/* Is the patch split? The model depends on the centre's valence, and on how many neighbours were available to the
 * encoder for a collapse. */
static int cqi_code_flag(cq_decoder *d, int available, int split)
{
    return cqi_code_bit(d, CQI_FLAG + 12 * cqi_at_most(available, 3) + cqi_at_most(d->ring.size, 11), split);
}

/* Looks through some vertices for the next component that takes part in the level. Returns the L of its first gate, or
 * CQ_NONE. */
static cq_index cqi_next_seed(cq_decoder *d)
{
    int k;
    for (k = 0; k < CQI_AT_ONCE && d->seed < d->active; k++, d->seed++)
        if (d->mesh.mark[d->seed] & CQI_SEED) return d->seed++;
    return CQ_NONE;
}

static void cqi_report_split(cq_decoder *d, int p, int q)
{
    cq_level *level = cqi_level_report(d);
    level->sum_i += (uint32_t)p;
    level->sum_j += (uint32_t)(d->ring.size - 1 - q);
}

static void cqi_plan_new_vertex(cq_decoder *d, cq_index b, cq_index num_faces, int p, int q)
{
    cqi_plan *plan = d->plan;
    const cqi_collapse *c = &plan->note[plan->next++];
    const cqi_ring *r = &d->ring;
    cqi_plan_vertex(plan, c->removed, b);
    if (!plan->follows_faces) return;
    if (p != r->boundary) cqi_plan_face(plan, (cq_index)(3 * c->face[0]), d->materials ? d->new_face[0] : num_faces++);
    if (q != r->boundary) cqi_plan_face(plan, (cq_index)(3 * c->face[1]), d->materials ? d->new_face[1] : num_faces);
}

/* Splits the patch, once its values are there. */
static cq_result cqi_apply_split(cq_decoder *d, int p, int q)
{
    const cq_index num_faces = d->mesh.num_faces, b = d->mesh.num_vertices;
    if (d->materials) cqi_take_new_faces(d);
    if (cq_mesh_split(&d->mesh, d->ring.spoke[p], d->ring.spoke[q]) == CQ_NONE) return CQ_ERROR_CORRUPT;
    if (d->materials) cqi_count_new_faces(d, 0);
    cqi_take_vertex(&d->mesh, b);
    d->splits++;
#ifdef CQ_TRAINING
    cqi_model_omit(&d->model);
#endif
    if (CQI_REPORTING(d)) cqi_report_split(d, p, q);
    if (CQI_ENCODING(d)) cqi_plan_new_vertex(d, b, num_faces, p, q);
    return CQ_OK;
}

/* -- Rows of a split's corners --
 *
 * Before the split, the corners of A form two runs: those between the spokes to p and q, which B gets, and those that A
 * keeps. A row that occurs in both is split: B gets a new row. A row that only occurs in B's run moves to B. As rows of
 * B's run occur only around A, corners with the same row still have the same vertex. Then follow the six corners of the
 * two new faces: each has the row of the face beside it, or another one, see cqi_list_choices, or a new row. */

#ifdef CQ_NO_WEDGES
#define cqi_begin_corners(d, p, q) CQ_ERROR_UNSUPPORTED
#define cqi_begin_base_rows(d) CQ_ERROR_UNSUPPORTED
#define cqi_has_aside(d) 0
#else

/* Row of the corner of a halfedge; virtual faces have none. */
static cq_index cqi_row_at(const cq_decoder *d, cq_index h)
{
    return h / 3 < d->mesh.first_virtual_face ? d->index[h] : CQ_NONE;
}

static int cqi_code_with(cq_decoder *d, cq_bit_model *model, int bit)
{
    return cqi_code_adaptive(d, model, d->rate, bit);
}

/* Is it the row of the encoder's wedge? */
static int cqi_is_wanted(const cq_decoder *d, cq_index row, cq_index wedge)
{
    return CQI_ENCODING(d) && d->plan->wedge_of_row[row] == wedge;
}

static cq_index cqi_add_row(cq_decoder *d, cq_index vertex, cq_index wedge)
{
    cqi_seams *s = d->seams;
    if (s->num_rows == d->shape.num_rows) {
        s->full = 1;
        return 0;
    }
    d->vertex[s->num_rows] = vertex;
    if (CQI_ENCODING(d)) {
        d->plan->wedge_of_row[s->num_rows] = wedge;
        d->plan->row_decoded[wedge] = s->num_rows;
    }
    CQI_TRACE(d, CQ_EVENT_ROW, s->num_rows, vertex, 0);
    return s->num_rows++;
}

/* Adds the next row of those that the split makes. */
static cq_index cqi_make_row(cq_decoder *d, cq_index vertex, cq_index beside, int corner, cq_index wedge)
{
    cqi_new_row *row = &d->seams->made[d->seams->num_new++];
    row->beside = beside;
    row->corner = corner;
    return cqi_add_row(d, vertex, wedge);
}

/* Wedges of the six corners of the faces that a collapse removed. */
static void cqi_removed_corners(const cqi_plan *p, const cqi_collapse *c, cq_index *corner)
{
    const cq_index a = (cq_index)(3 * c->face[0] + (c->first >> CQI_CORNER_A & 3));
    const cq_index b = (cq_index)(3 * c->face[1] + (c->first >> CQI_CORNER_B & 3));
    const int left = c->face[0] < p->mesh.first_virtual_face, right = c->face[1] < p->mesh.first_virtual_face;
    corner[CQI_LEFT_A] = left ? p->index[a] : CQ_NONE;
    corner[CQI_LEFT_B] = left ? p->index[cq_next(a)] : CQ_NONE;
    corner[CQI_AT_P] = left ? p->index[cq_prev(a)] : CQ_NONE;
    corner[CQI_RIGHT_A] = right ? p->index[cq_next(b)] : CQ_NONE;
    corner[CQI_RIGHT_B] = right ? p->index[b] : CQ_NONE;
    corner[CQI_AT_Q] = right ? p->index[cq_prev(b)] : CQ_NONE;
}

/* Does the row occur in the run that A keeps? */
static int cqi_is_kept(const cq_decoder *d, cq_index row)
{
    const cqi_ring *r = &d->ring;
    int k = d->seams->q;
    do {
        k = cqi_next_of(k, r->size);
        if (cqi_row_at(d, r->spoke[k]) == row) return 1;
    } while (k != d->seams->p);
    return 0;
}

/* The new row of B for a row that both runs have; no encoder needs more than two. */
static cq_index cqi_split_row(cq_decoder *d, cq_index row)
{
    cqi_seams *s = d->seams;
    cq_index wedge = 0;
    int k;
    for (k = 0; k < s->num_new; k++)
        if (s->made[k].beside == row) return (cq_index)(d->num_rows + (cq_index)k);
    if (s->num_new == 2) {
        s->full = 1;
        return row;
    }
    if (CQI_ENCODING(d)) {
        const int left = d->plan->note[d->plan->next].first & CQI_TIED_LEFT;
        wedge = s->wanted[left && cqi_is_wanted(d, row, s->wanted[CQI_LEFT_A]) ? CQI_LEFT_B : CQI_RIGHT_B];
    }
    return cqi_make_row(d, d->mesh.num_vertices, row, CQI_CORNERS, wedge);
}

static void cqi_split_rows(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    int k;
    for (k = s->p + 1; k <= s->q; k++) {
        const cq_index row = cqi_row_at(d, d->ring.spoke[k]);
        s->run[k] = row != CQ_NONE && cqi_is_kept(d, row) ? cqi_split_row(d, row) : row;
    }
}

/* What an edge is, by the rows that one end has on both sides of it. 0: neither of these, 1: a seam, 2: a border. */
static int cqi_seam_class(cq_index a, cq_index b) { return a == CQ_NONE || b == CQ_NONE ? 2 : a != b; }

/* Number of different rows of A, at most 3, minus 1. */
static int cqi_rows_of_centre(const cq_decoder *d)
{
    const cqi_ring *r = &d->ring;
    cq_index first = CQ_NONE, second = CQ_NONE;
    int k;
    for (k = 0; k < r->size; k++) {
        const cq_index row = cqi_row_at(d, r->spoke[k]);
        if (row == CQ_NONE || row == first || row == second) continue;
        if (second != CQ_NONE) return 2;
        if (first == CQ_NONE) first = row;
        else second = row;
    }
    return second != CQ_NONE;
}

static void cqi_set_choice(cqi_seams *s, int corner, cq_index usual, cq_index other)
{
    s->usual[corner] = usual != CQ_NONE ? usual : other;
    s->other[corner] = usual != CQ_NONE && other != usual ? other : CQ_NONE;
}

/* Lists the rows that each corner may have: the usual one, as in the face beside it, and another one at p and q.
 * Corners of A and B in the right face may also have the rows of the left one, see cqi_code_corners. */
static void cqi_list_choices(cq_decoder *d)
{
    const cqi_ring *r = &d->ring;
    cqi_seams *s = d->seams;
    const cq_index to_p = r->spoke[s->p], to_q = r->spoke[s->q], from_p = d->mesh.twin[to_p],
                   from_q = d->mesh.twin[to_q];
    const cq_index at_a = cqi_row_at(d, cq_next(from_q));
    const int at_p = cqi_seam_class(cqi_row_at(d, to_p), cqi_row_at(d, cq_next(from_p)));
    s->context = (3 * at_p + cqi_seam_class(at_a, cqi_row_at(d, to_q))) * 3 + cqi_rows_of_centre(d);
    cqi_set_choice(s, CQI_LEFT_A, cqi_row_at(d, to_p), CQ_NONE);
    cqi_set_choice(s, CQI_LEFT_B, s->run[s->p + 1], CQ_NONE);
    cqi_set_choice(s, CQI_AT_P, cqi_row_at(d, cq_next(to_p)), cqi_row_at(d, from_p));
    cqi_set_choice(s, CQI_RIGHT_A, at_a, CQ_NONE);
    cqi_set_choice(s, CQI_RIGHT_B, s->run[s->q], CQ_NONE);
    cqi_set_choice(s, CQI_AT_Q, cqi_row_at(d, from_q), cqi_row_at(d, cq_next(to_q)));
}

/* Which model a corner uses: by whether corners before it have their usual rows. */
static int cqi_corner_history(const cqi_seams *s, int corner)
{
    const cq_index *const row = s->row, *const usual = s->usual;
    const int left_a = row[CQI_LEFT_A] == usual[CQI_LEFT_A], left_b = row[CQI_LEFT_B] == usual[CQI_LEFT_B];
    const int right_a = row[CQI_RIGHT_A] == usual[CQI_RIGHT_A], right_b = row[CQI_RIGHT_B] == usual[CQI_RIGHT_B];
    switch (corner) {
    case CQI_LEFT_A: return 0;
    case CQI_LEFT_B: return left_a;
    case CQI_AT_P: return 2 * (s->other[corner] == CQ_NONE) + (left_a && left_b);
    case CQI_RIGHT_A: return 2 * left_a + left_b;
    case CQI_RIGHT_B: return 2 * left_b + right_a;
    default: return 2 * (s->other[corner] == CQ_NONE) + (right_a && right_b);
    }
}

static cq_index cqi_vertex_of_corner(const cq_decoder *d, int corner)
{
    if (corner % 3 == CQI_LEFT_A) return d->mesh.origin[d->ring.spoke[0]];
    if (corner % 3 == CQI_LEFT_B) return d->mesh.num_vertices;
    return d->ring.vertex[corner == CQI_AT_P ? d->seams->p : d->seams->q];
}

static cq_index cqi_code_corner(cq_decoder *d, int corner)
{
    cqi_seams *s = d->seams;
    cq_bit_model *const model = s->model[s->context];
    const cq_index usual = s->usual[corner], other = s->other[corner], wedge = s->wanted[corner];
    int history = cqi_corner_history(s, corner);
    if (usual != CQ_NONE && cqi_code_with(d, &model[CQI_USUAL + 4 * corner + history], cqi_is_wanted(d, usual, wedge)))
        return usual;
    if (other != CQ_NONE && cqi_code_with(d, &model[CQI_SECOND_CHOICE + corner], cqi_is_wanted(d, other, wedge)))
        return other;
    return cqi_make_row(d, cqi_vertex_of_corner(d, corner), usual, corner, wedge);
}

/* Do all corners that are present have a usual row? And does the encoder want these? */
static int cqi_may_be_usual(const cqi_seams *s, const int *present)
{
    int k;
    for (k = 0; k < CQI_CORNERS; k++)
        if (present[k / 3] && s->usual[k] == CQ_NONE) return 0;
    return 1;
}

static int cqi_plan_usual(const cq_decoder *d, const int *present)
{
    const cqi_seams *s = d->seams;
    int k;
    for (k = 0; k < CQI_CORNERS; k++)
        if (present[k / 3] && !cqi_is_wanted(d, s->usual[k], s->wanted[k])) return 0;
    return 1;
}

static void cqi_code_corners(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    const int present[2] = { s->p != d->ring.boundary, s->q != d->ring.boundary };
    int k, all = cqi_may_be_usual(s, present);
    if (all)
        all = cqi_code_with(d, &s->model[s->context][CQI_ALL_USUAL], CQI_ENCODING(d) && cqi_plan_usual(d, present));
    for (k = 0; k < CQI_CORNERS; k++) {
        s->row[k] = CQ_NONE;
        if (!present[k / 3]) continue;
        if (all) {
            s->row[k] = s->usual[k];
            continue;
        }
        if ((k == CQI_RIGHT_A || k == CQI_RIGHT_B) && present[0])
            cqi_set_choice(s, k, s->usual[k], s->row[k - CQI_RIGHT_A + CQI_LEFT_A]);
        s->row[k] = cqi_code_corner(d, k);
        CQI_TRACE(d, CQ_EVENT_CORNER, cqi_vertex_of_corner(d, k), s->row[k], 0);
    }
}

/* -- Values of the rows that a split makes -- */

/* Lists the fan of a row that is split from `beside`: that one, then the neighbours of B that corners with the row
 * have, as rows. Like cqi_list_fan_of_b, but without the vertices beyond; and with the faces that have the row. */
static void cqi_list_fan_of_row(cq_decoder *d, cq_index row, cq_index beside)
{
    const cqi_ring *r = &d->ring;
    const cqi_seams *s = d->seams;
    cqi_fan *f = &d->now.fan;
    int k, n = 1;
    f->vertex[0] = beside;
    f->faces = 0;
    for (k = s->p; k <= s->q; k++) {
        const int before = k > s->p && s->run[k] == row, after = k < s->q && s->run[k + 1] == row;
        if (!before && !after) continue;
        if (before) f->faces |= (uint32_t)1 << (n - 1);
        f->vertex[n++] = cqi_row_at(d, before ? cq_next(r->spoke[k]) : d->mesh.twin[r->spoke[k]]);
    }
    if (s->run[s->p + 1] == row && s->row[CQI_LEFT_B] == row) f->faces |= 1;
    if (s->run[s->q] == row && s->row[CQI_RIGHT_B] == row) f->faces |= (uint32_t)1 << (n - 1);
    f->size = n;
    f->boundary = 1;
    for (k = 0; k < n; k++) {
        f->beyond[k] = CQ_NONE;
        if (d->located < 0) continue;
        f->at[k] = cqi_offset(d->channel[d->located], d->mesh.num_vertices, d->vertex[f->vertex[k]]);
    }
}

/* Lists the fan of a row that only new faces have: the other two corners of each of these. */
static void cqi_list_fan_of_corner(cq_decoder *d, cq_index row)
{
    static const uint8_t following[CQI_CORNERS] = { CQI_LEFT_B, CQI_AT_P,    CQI_LEFT_A,
                                                    CQI_AT_Q,   CQI_RIGHT_A, CQI_RIGHT_B };
    const cqi_seams *s = d->seams;
    cqi_fan *f = &d->now.fan;
    int corner, other, j;
    f->size = 0;
    f->faces = 0;
    for (corner = 0; corner < CQI_CORNERS && d->located >= 0; corner++) {
        if (s->row[corner] != row) continue;
        f->faces |= (uint32_t)1 << f->size;
        for (j = 0, other = following[following[corner]]; j < 2; j++, other = following[following[other]]) {
            f->vertex[f->size] = s->row[other];
            f->at[f->size++] = cqi_offset(d->channel[d->located], cqi_vertex_of_corner(d, corner),
                                          cqi_vertex_of_corner(d, other));
        }
    }
}

static int cqi_rows_are_equal(const cq_decoder *d, uint32_t k, cq_index a, cq_index b)
{
    const size_t n = d->shape.channel[k].components;
    const cq_value *const of_a = d->channel[k] + a * n, *const of_b = d->channel[k] + b * n;
    size_t c = 0;
    while (c < n && of_a[c] == of_b[c]) c++;
    return c == n;
}

/* Is channel k of a row equal to that of another one? Then it is copied. */
static int cqi_code_equal(cq_decoder *d, uint32_t k, int model, cq_index row, cq_index other)
{
    const uint32_t n = d->shape.channel[k].components;
    cq_value *const to = d->channel[k] + (size_t)row * n;
    const cq_value *const from = d->channel[k] + (size_t)other * n;
    uint32_t c;
    int equal = CQI_ENCODING(d);
    for (c = 0; c < n && equal; c++) equal = cqi_plan_bits(d, k, c, d->plan->wedge_of_row[row]) == from[c];
    equal = cqi_code_with(d, &d->seams->equal[k][model], equal);
    for (c = 0; c < n && equal; c++) to[c] = from[c];
    return equal;
}

/* One component of a row, given the row that it is expected to be near, and perhaps another one, which is farther. */
static int cqi_code_near(cq_decoder *d, uint32_t k, uint32_t c, cq_index wedge, cq_index near, cq_index far,
                         cq_value *to)
{
    const cq_channel *channel = &d->shape.channel[k];
    const cq_value *const values = d->channel[k] + c;
    const uint32_t stride = channel->components;
    const int32_t expected = near != CQ_NONE ? cqi_number(channel, values[(size_t)near * stride]) : 0;
    int32_t apart = channel->bits < 24 ? (int32_t)1 << channel->bits >> 2 : (int32_t)1 << 22;
    if (near != CQ_NONE && far != CQ_NONE && far != near)
        apart = cqi_rough(channel, values[(size_t)far * stride]) - cqi_rough(channel, values[(size_t)near * stride]);
    return cqi_code_row_value(d, k, c, CQI_ROW_AT_SEAM, cqi_half_bits(cqi_abs(apart)), expected, wedge, to);
}

static int cqi_code_near_copy(cq_decoder *d, uint32_t k, uint32_t c, cq_index wedge, cq_index near, cq_index far,
                              cq_value *to)
{
    const cq_channel *channel = &d->shape.channel[k];
    const cq_value *const values = d->channel[k] + c;
    int32_t beside[2], x = 0;
    int n = 0;
    if (near != CQ_NONE) beside[n++] = values[(size_t)near * channel->components];
    if (far != CQ_NONE) beside[n++] = values[(size_t)far * channel->components];
    if (CQI_ENCODING(d)) x = cqi_plan_bits(d, k, c, wedge);
    x = cqi_code_copy(d, d->shape.channel[k].bits, beside, n, x);
    *to = (cq_value)x;
    return 1;
}

/* Rows with values that a new row may have in a channel, each value once. */
enum { CQI_NEARBY = 6 };
typedef struct cqi_nearby {
    cq_index row[CQI_NEARBY];
    int num_rows;
} cqi_nearby;

static void cqi_add_nearby(const cq_decoder *d, uint32_t k, cq_index candidate, cqi_nearby *n)
{
    int j = 0;
    if (candidate == CQ_NONE || n->num_rows == CQI_NEARBY) return;
    while (j < n->num_rows && !cqi_rows_are_equal(d, k, candidate, n->row[j])) j++;
    if (j == n->num_rows) n->row[n->num_rows++] = candidate;
}

/* Adds rows of the vertex of a corner: of A or B all, but of p or q those in four faces on each side of the spoke. Only
 * rows before `row` have values. */
static void cqi_list_nearby(const cq_decoder *d, uint32_t k, int corner, cq_index row, cqi_nearby *n)
{
    const cqi_ring *r = &d->ring;
    const cqi_seams *s = d->seams;
    const cq_mesh *m = &d->mesh;
    cq_index h = r->spoke[corner == CQI_AT_P ? s->p : s->q], back = m->twin[h];
    int j;
    if (corner % 3 == CQI_LEFT_A) {
        for (j = s->p; j != s->q; j = cqi_previous_of(j, r->size)) cqi_add_nearby(d, k, cqi_row_at(d, r->spoke[j]), n);
    } else if (corner % 3 == CQI_LEFT_B) {
        for (j = s->p + 1; j <= s->q; j++) cqi_add_nearby(d, k, s->run[j] < row ? s->run[j] : CQ_NONE, n);
    } else {
        for (j = 0, h = cq_next(h); j < 4; j++, h = cq_clockwise(m, h), back = cq_counterclockwise(m, back)) {
            cqi_add_nearby(d, k, cqi_row_at(d, h), n);
            cqi_add_nearby(d, k, cqi_row_at(d, back), n);
        }
    }
}

/* For a row that only new faces have: is its channel k equal to that of the last row before it in its face, of the row
 * beside, or of another row of its vertex? */
static int cqi_code_equal_seam_row(cq_decoder *d, uint32_t k, cq_index row, const cqi_new_row *made, cq_index in_face)
{
    const cq_index beside = made->beside;
    cqi_nearby nearby = { { 0 }, 0 };
    int j, asked, as_beside;
    cqi_add_nearby(d, k, in_face, &nearby);
    cqi_add_nearby(d, k, beside, &nearby);
    asked = nearby.num_rows;
    as_beside = beside != CQ_NONE && asked == 1;
    if (in_face != CQ_NONE && cqi_code_equal(d, k, CQI_EQUAL_IN_FACE + as_beside, row, in_face)) return 1;
    if (beside != CQ_NONE && cqi_code_equal(d, k, CQI_EQUAL_BESIDE + (in_face != CQ_NONE), row, beside)) return 1;
    cqi_list_nearby(d, k, made->corner, row, &nearby);
    for (j = asked; j < nearby.num_rows; j++)
        if (cqi_code_equal(d, k, CQI_EQUAL_NEARBY + cqi_at_most(j - asked, 3), row, nearby.row[j])) return 1;
    return 0;
}

/* The last row before `row` that the corners of its new face have, or CQ_NONE. */
static cq_index cqi_row_in_face(const cqi_seams *s, int corner, cq_index row)
{
    cq_index last = CQ_NONE;
    int j;
    for (j = corner / 3 * 3; j < corner / 3 * 3 + 3; j++)
        if (s->row[j] < row && (last == CQ_NONE || s->row[j] > last)) last = s->row[j];
    return last;
}

/* Flattens the fan of a row that only new faces have, and keeps what is known: the rows that came before it, each once.
 * Returns how many. */
static int cqi_keep_known(cqi_fan *f, cq_index row)
{
    int k, j, known = 0;
    cqi_flatten_fan(f);
    for (k = 0; k < f->size; k++) {
        for (j = 0; j < known && f->vertex[j] != f->vertex[k]; j++) {}
        if (j < known || f->vertex[k] >= row) continue;
        f->vertex[known] = f->vertex[k];
        f->outer[known++] = f->outer[k];
    }
    return known;
}

/* Channel k of a row that only new faces have: equal to that of another row; or by these faces; or near that of the
 * last row before it in its face, or of the row beside. */
static int cqi_code_seam_row(cq_decoder *d, uint32_t k, cq_index row, const cqi_new_row *made, cq_index wedge)
{
    const cqi_seams *s = d->seams;
    const cq_channel *channel = &d->shape.channel[k];
    cq_value *to = d->channel[k] + (size_t)row * channel->components;
    const cq_index beside = made->beside, in_face = cqi_row_in_face(s, made->corner, row);
    int ok = 1, swap;
    uint32_t c;
    if (cqi_code_equal_seam_row(d, k, row, made, in_face)) return 1;
    if (cqi_has_pairs(d, k)) {
        const int other = beside == CQ_NONE || (channel->kind == CQ_TANGENT && in_face != CQ_NONE);
        const cq_index *around = other ? &in_face : &made->beside;
        return cqi_code_expected_pair(d, k, row, around, *around != CQ_NONE, wedge);
    }
    if (cqi_is_texture(d, k)) {
        const int known = cqi_keep_known(&d->now.fan, row);
        if (known > 1) return cqi_code_texture(d, k, known, CQI_ROW_TEXTURE_AT_SEAM, wedge, to);
    }
    swap = beside == CQ_NONE || (channel->kind == CQ_NORMAL && in_face != CQ_NONE);
    for (c = 0; c < channel->components && ok; c++) {
        const cq_index near = swap ? in_face : beside, far = swap ? beside : in_face;
        ok = channel->merge == CQ_COPY ? cqi_code_near_copy(d, k, c, wedge, near, far, to + c)
                                       : cqi_code_near(d, k, c, wedge, near, far, to + c);
    }
    return ok;
}

/* Channel k of a new row of B that is split from one of A: equal to that of B's other one, or by B's neighbours. */
static int cqi_code_split_row(cq_decoder *d, uint32_t k, cq_index row, cq_index wedge)
{
    const cqi_seams *s = d->seams;
    if (row > d->num_rows) {
        const int were_equal = cqi_rows_are_equal(d, k, s->made[0].beside, s->made[1].beside);
        if (cqi_code_equal(d, k, CQI_EQUAL_SPLIT + were_equal, row, (cq_index)(row - 1))) return 1;
    }
    return cqi_code_by_fan(d, k, row, wedge);
}

/* The next channel of the rows that the split makes; 0: there is none. */
static int cqi_next_channel(const cq_decoder *d, uint32_t *k)
{
    while (*k < d->shape.num_channels && cqi_class(&d->shape, *k) != CQI_OF_ROW) ++*k;
    return *k < d->shape.num_channels;
}

static void cqi_set_face_rows(cq_index *rows, cq_index a, cq_index b, cq_index c)
{
    rows[0] = a;
    rows[1] = b;
    rows[2] = c;
}

/* The split, with the rows of all its corners. */
static cq_result cqi_apply_rows(cq_decoder *d)
{
    const cqi_seams *s = d->seams;
    const cq_index b = d->mesh.num_vertices, *const row = s->row;
    const cq_result result = cqi_apply_split(d, s->p, s->q);
    cq_index f, g;
    int k;
    if (result != CQ_OK) return result;
    for (k = s->p + 1; k <= s->q; k++) {
        if (s->run[k] == CQ_NONE) continue;
        d->index[d->ring.spoke[k]] = s->run[k];
        d->vertex[s->run[k]] = b;
    }
    f = d->mesh.twin[d->ring.spoke[s->p]]; /* p -> A */
    g = cq_prev(d->mesh.twin[d->ring.spoke[s->q]]); /* A -> q */
    if (s->p != d->ring.boundary) cqi_set_face_rows(d->index + f, row[CQI_AT_P], row[CQI_LEFT_A], row[CQI_LEFT_B]);
    if (s->q != d->ring.boundary) cqi_set_face_rows(d->index + g, row[CQI_RIGHT_A], row[CQI_AT_Q], row[CQI_RIGHT_B]);
    d->num_rows = s->num_rows;
    d->phase = CQI_PATCHES;
    return CQ_OK;
}

static cq_result cqi_begin_corners(cq_decoder *d, int p, int q)
{
    d->seams->p = p;
    d->seams->q = q;
    d->phase = CQI_READ_CORNERS;
    return CQ_OK;
}

static CQI_APART cq_result cqi_step_corners(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    s->num_new = s->next = 0;
    s->channel = 0;
    if (CQI_ENCODING(d)) cqi_removed_corners(d->plan, &d->plan->note[d->plan->next], s->wanted);
    cqi_split_rows(d);
    cqi_list_choices(d);
    cqi_code_corners(d);
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->indices, &cqi_level_report(d)->indices);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (s->full) return CQ_ERROR_CORRUPT;
    d->phase = CQI_READ_ROWS;
    return CQ_OK;
}

static int cqi_code_new_row(cq_decoder *d, uint32_t k, int nth)
{
    const cqi_new_row *made = &d->seams->made[nth];
    const cq_index row = (cq_index)(d->num_rows + (cq_index)nth),
                   wedge = CQI_ENCODING(d) ? d->plan->wedge_of_row[row] : 0;
    if (made->corner == CQI_CORNERS) {
        cqi_list_fan_of_row(d, row, made->beside);
        return cqi_code_split_row(d, k, row, wedge);
    }
    cqi_list_fan_of_corner(d, row);
    return cqi_code_seam_row(d, k, row, made, wedge);
}

/* Channel by channel, the values of the next new row; or the split, when all values are there. */
static CQI_APART cq_result cqi_step_rows(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    uint32_t k;
    int ok;
    if (s->next == s->num_new) {
        s->next = 0;
        s->channel++;
    }
    if (!s->num_new || !cqi_next_channel(d, &s->channel)) return cqi_apply_rows(d);
    k = s->channel;
    ok = cqi_code_new_row(d, k, s->next++);
    CQI_TRACE_IF(ok, d, CQ_EVENT_VALUES, k, d->num_rows + (cq_index)s->next - 1, 0);
    cqi_charge_channel(d, k);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    return ok ? CQ_OK : CQ_ERROR_CORRUPT;
}

#endif /* CQ_NO_WEDGES */

/* The split of the patch: both indices, then the values, then the mesh; with seams, rows come before the mesh, in steps
 * of their own. */
static cq_result cqi_code_split(cq_decoder *d)
{
    const cq_index b = d->mesh.num_vertices;
    const cqi_collapse *note = CQI_ENCODING(d) ? &d->plan->note[d->plan->next] : NULL;
    int p = note ? note->p : 0, q = note ? note->q : 0;
    if (b == d->mesh.first_virtual) return CQ_ERROR_CORRUPT;
    cqi_code_pair(d, &p, &q);
    CQI_TRACE(d, CQ_EVENT_SPLIT, b, p, q);
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->indices, &cqi_level_report(d)->indices);
    if (!cqi_code_values(d, p, q, note ? note->removed : 0, b)) return cqi_starved(d) ? CQ_TRUNCATED : CQ_ERROR_CORRUPT;
    if (cqi_starved(d)) return CQ_TRUNCATED;
    return d->seams ? cqi_begin_corners(d, p, q) : cqi_apply_split(d, p, q);
}

/* Is a vertex that is not split passed over, so that its ring stays free? Only asked about large ones. The encoder
 * passes over vertices of a valence above CQ_MAX_VALENCE. Here, after the collapses of the level, they still have at
 * least CQI_HUB neighbours: they only lose a neighbour where that is collapsed into another one, and no vertex takes
 * part in two collapses. */
static int cqi_code_pass(cq_decoder *d, cq_index centre)
{
    int pass = 0;
    if (d->ring.size < CQI_HUB) return 0;
    if (CQI_ENCODING(d)) pass = d->plan->passed[d->plan->to_input[centre]] == d->plan->level;
    return cqi_code_bit(d, CQI_PASSED, pass);
}

/* Conquers the patch of the spoke's origin. */
static cq_result cqi_code_patch(cq_decoder *d, cq_index spoke)
{
    const cq_index centre = d->mesh.origin[spoke];
    int available, split, pass = d->mesh.valence[centre] > CQ_MAX_VALENCE;
    cqi_take_vertex(&d->mesh, centre);
    if (!pass) {
        available = cqi_read_ring(&d->mesh, &d->ring, spoke);
        split = CQI_ENCODING(d) && cqi_plan_split(d->plan, centre) != NULL;
        split = cqi_code_flag(d, available, split);
        pass = !split && cqi_code_pass(d, centre);
        if (cqi_starved(d)) return CQ_TRUNCATED;
        if (CQI_REPORTING(d)) cqi_charge(d, &d->report->flags, &cqi_level_report(d)->flags);
        if (pass) cqi_release_ring(&d->mesh, &d->ring);
    }
    CQI_TRACE(d, CQ_EVENT_PATCH, centre, cq_target(&d->mesh, spoke), pass ? 2 : split);
    if (pass) {
        cqi_queue_neighbours(&d->mesh, &d->walk, spoke);
        return d->walk.full ? CQ_ERROR_CORRUPT : CQ_OK;
    }
    if (CQI_REPORTING(d)) cqi_level_report(d)->num_patches++;
    cqi_queue_fronts(&d->mesh, &d->walk, &d->ring);
    if (d->walk.full) return CQ_ERROR_CORRUPT;
    return split ? cqi_code_split(d) : CQ_OK;
}

/* The first patch of a component, given the L of its first gate. L and R are held even where the patch does not hold
 * them, so that they and the edge between them stay. */
static cq_result cqi_code_first_patch(cq_decoder *d, cq_index l)
{
    const cq_index gate = cqi_find_spoke(&d->mesh, l, (cq_index)(l + 1));
    int side = 0;
    if (CQI_ENCODING(d)) {
        cqi_plan_component(d->plan);
        side = cqi_plan_side(d->plan);
    }
    if (cqi_code_bit(d, CQI_SIDE, side != 0)) side = 1 + cqi_code_bit(d, CQI_SIDE + 1, side == 2);
    else side = 0;
    cqi_hold(&d->mesh, l);
    cqi_hold(&d->mesh, (cq_index)(l + 1));
    return cqi_code_patch(d, cqi_first_spoke(&d->mesh, gate, side));
}

#ifndef CQ_NO_REGULAR

/* -- Regular levels --------------------------------------------------------------------------------------------------
 *
 * A regular level is one step of subdivision: its new vertices lie on edges of the mesh before, the coarse edges.
 *
 *     marks        for each coarse edge: does it get a vertex? New vertices are in the order of the edges
 *     expected     for each new vertex a place that the coarse mesh alone predicts: it is kept where the vertex's final
 *                  values will be, which is not part of the mesh yet
 *     patterns     for each face with two or three new vertices: into which triangles is it cut?
 *     dissolves    for some edges without a vertex: is the edge flipped, once its faces have got theirs?
 *     sweep        coarse face after coarse face: the new vertices of its edges that are not there yet, one by one,
 *                  each with its final position; then flips, which make the wanted triangles of the face; and flips of
 *                  dissolved edges that it shares with earlier faces
 *
 * So the mesh is valid after each insertion and each flip, and what has arrived is final. The first vertex that is
 * inserted into a face is at first its hub: if two or three are, the triangles make a fan around it.
 *
 *            c                c                   c                    c
 *          /   \            / | \               / | \                / | \        the edge from the hub to the opposite
 *         /     \          /  |  \             /  |  m1             m2 |  m1      corner may be flipped; with three
 *        /       \        /   |   \           /   | /  \           /  \|/   \     new vertices that gives a triangle
 *       a---------b      a---hub---b         a---hub----b         a---hub----b    in the middle, and another flip a fan
 *                                                                                 around m1 or m2
 *
 * The level keeps its notes in memory of vertices and faces that are still to come. Of new vertex v, out[v] is its
 * coarse edge (the smaller halfedge), valence[v] belongs to the table of cqi_vertex_on, bits 4 and 5 of mark[v] are its
 * side in the face of the twin, and the slots of the faces that its insertion makes hold its record, see there.
 * Bits of the coarse faces are in the queue. All this is written while the mesh is coarse: halfedges in it are of the
 * coarse mesh. */

/* -- Regular levels: bits of the coarse faces --
 *
 * Five for each face: of each side, whether it is marked; then two, by the number of these marks:
 *
 *     none     0, or 1 + the side whose edge is dissolved, and flipped in the turn of this face
 *     one      the same; or 1 + the marked side, if the face has a dissolved edge that is flipped in the turn of the
 *              face beyond it
 *     two      1 if the third side is dissolved and flipped in this turn; 2 if of the two marked sides, the one before
 *              the third side is the hub's, see cqi_code_pattern
 *     three    the side of the hub, or 3
 *
 * The queue has room: with F = 3k + i faces it has k + 1 elements or more, so at least 2k + 2 bytes, and byte 1 of the
 * last face is number (15k + 5i - 5) / 8 + 1 <= 2k + 1. */

static int cqi_has_mark(const cq_decoder *d, cq_index h)
{
    const size_t bit = h + 2 * (size_t)(h / 3);
    return ((const uint8_t *)d->walk.queue)[bit >> 3] >> (bit & 7) & 1;
}

/* All five bits of a face. */
static int cqi_state_of(const cq_decoder *d, cq_index f)
{
    const uint8_t *const byte = (const uint8_t *)d->walk.queue + (5 * (size_t)f >> 3);
    return (byte[0] | byte[1] << 8) >> (5 * f & 7) & 31;
}

/* Sets bits that are clear, or clears bits that are set. */
static void cqi_toggle_state(cq_decoder *d, cq_index f, int bits)
{
    uint8_t *const byte = (uint8_t *)d->walk.queue + (5 * (size_t)f >> 3);
    bits <<= 5 * f & 7;
    byte[0] = (uint8_t)(byte[0] ^ bits);
    byte[1] = (uint8_t)(byte[1] ^ bits >> 8);
}

static void cqi_set_mark(cq_decoder *d, cq_index h) { cqi_toggle_state(d, (cq_index)(h / 3), 1 << h % 3); }

/* The marked sides of a face, as bits; and its other two bits. */
static int cqi_marks_of(const cq_decoder *d, cq_index f) { return cqi_state_of(d, f) & 7; }

static int cqi_face_bits(const cq_decoder *d, cq_index f) { return cqi_state_of(d, f) >> 3; }

static void cqi_toggle_face_bits(cq_decoder *d, cq_index f, int bits) { cqi_toggle_state(d, f, bits << 3); }

static const uint8_t cqi_ones[8] = { 0, 1, 1, 2, 1, 2, 2, 3 };
static const uint8_t cqi_odd_side[8] = { 3, 0, 1, 2, 2, 1, 0, 3 }; /* the only marked or unmarked one; 3: there is none */

/* 1 + the side whose edge is dissolved; or for a face with one mark, perhaps 1 + that side, see above; 0: none. */
static int cqi_dissolved_side(const cq_decoder *d, cq_index f)
{
    static const uint8_t side[32] = { 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 3, 1, 2, 1, 0,
                                      2, 2, 2, 0, 2, 0, 0, 0, 3, 3, 3, 3, 3, 2, 1, 0 };
    return side[cqi_state_of(d, f)];
}

/* The side of the hub of a face with marks; 3: it has none. */
static int cqi_hub_of(int state)
{
    static const uint8_t side[32] = { 3, 0, 1, 0, 2, 2, 1, 0, 3, 0, 1, 0, 2, 2, 1, 1,
                                      3, 0, 1, 1, 2, 0, 2, 2, 3, 0, 1, 1, 2, 0, 2, 3 };
    return side[state];
}

static int cqi_hub_side(const cq_decoder *d, cq_index f) { return cqi_hub_of(cqi_state_of(d, f)); }

/* -- Regular levels: marks -- */

/* Folds a pair, or folds it back. */
static void cqi_fold_seen(const cq_channel *channel, cqi_vector *x)
{
    const int32_t half = cqi_half_of(channel);
    cqi_pair_of_normal a;
    a.x = x->x - half;
    a.y = x->y - half;
    a = cqi_folded(a, half);
    x->x = a.x + half;
    x->y = a.y + half;
}

/* Up to three components of a vertex's values as a vector; a pair is folded if regular.fold says so. */
static cqi_vector cqi_seen(const cq_decoder *d, const cq_value *values)
{
    const cq_channel *const channel = &d->shape.channel[d->regular.view];
    const uint32_t n = channel->components - d->regular.part;
    cqi_vector x = { 0, 0, 0 };
    values += d->regular.part;
    x.x = cqi_rough(channel, values[0]);
    if (n > 1) x.y = cqi_rough(channel, values[1]);
    if (n > 2) x.z = cqi_rough(channel, values[2]);
    if (d->regular.fold) cqi_fold_seen(channel, &x);
    return x;
}

/* Values of a vertex in the channel that cqi_look_at has set. */
static CQI_APART cqi_vector cqi_seen_at(const cq_decoder *d, cq_index v)
{
    const uint32_t k = d->regular.view;
    return cqi_seen(d, d->channel[k] + d->shape.channel[k].components * (size_t)v);
}

static inline cqi_vector cqi_position(const cq_decoder *d, cq_index v)
{
    const cq_value *const p = d->channel[d->located] + 3 * (size_t)v;
    cqi_vector x;
    x.x = p[0];
    x.y = p[1];
    x.z = p[2];
    return x;
}

static int cqi_looks_elsewhere(const cq_decoder *d)
{
    return CQI_HAS_ATTRIBUTES && (int)d->regular.view != d->located;
}

static inline cqi_vector cqi_at(const cq_decoder *d, cq_index v)
{
    return cqi_looks_elsewhere(d) ? cqi_seen_at(d, v) : cqi_position(d, v);
}

static inline cqi_vector cqi_from(const cq_decoder *d, cqi_vector a, cq_index v) { return cqi_minus(cqi_at(d, v), a); }

static uint32_t cqi_distance(const cq_decoder *d, cq_index a, cq_index b)
{
    CQ_ASSERT((int)d->regular.view == d->located);
    return (uint32_t)cqi_norm(cqi_minus(cqi_position(d, b), cqi_position(d, a)));
}

/* 0: not marked, 1: marked, 2: not yet known when it is the turn of halfedge `now`. */
static int cqi_mark_state(const cq_decoder *d, cq_index h, cq_index now)
{
    return h < now || d->mesh.twin[h] < now ? cqi_has_mark(d, h) : 2;
}

/* Class of the states of the two other edges of h's face, whose order makes no difference. */
static int cqi_mark_pair(const cq_decoder *d, cq_index h, cq_index now)
{
    static const uint8_t pair[9] = { 0, 1, 2, 1, 3, 4, 2, 4, 5 };
    if (!cqi_is_real_face(&d->mesh, h)) return 0;
    return pair[3 * cqi_mark_state(d, cq_next(h), now) + cqi_mark_state(d, cq_prev(h), now)];
}

/* Class of the ratio a / b; limits are in 1/8 octave. */
static int cqi_ratio_class(uint32_t a, uint32_t b, int low, int middle, int high)
{
    const int x = cqi_logarithm(a + 1) - cqi_logarithm(b + 1);
    return x < low ? 0 : x < middle ? 1 : x < high ? 2 : 3;
}

#ifdef CQ_NO_WEDGES
#define cqi_code_rows_of_mark(d, h, v) 1
#else

/* The wedge of an odd vertex of the encoder, on the left or on the right of the decoded halfedge h. */
static cq_index cqi_plan_wedge(const cqi_plan *p, const cq_mesh *m, cq_index h, int right)
{
    const cqi_collapse *const c = &p->note[p->mesh.twin[h]];
    const int turned = p->decoded[c->kept] != m->origin[h];
    return turned != right ? p->uses[c->face[1]] : c->face[1];
}

/* Codes whether the new vertex v has one row, or one on each side of its edge h, and adds these. */
static int cqi_code_rows_of_mark(cq_decoder *d, cq_index h, cq_index v)
{
    const cq_index g = d->mesh.twin[h], *const row = d->index;
    const cq_index left = CQI_ENCODING(d) ? cqi_plan_wedge(d->plan, &d->mesh, h, 0) : 0;
    const cq_index right = CQI_ENCODING(d) ? cqi_plan_wedge(d->plan, &d->mesh, h, 1) : 0;
    int two = 0;
    if (cqi_is_real_face(&d->mesh, g)) {
        two = (row[h] != row[cq_next(g)]) + (row[cq_next(h)] != row[g]);
        two = (two > 0) == cqi_code_bit(d, CQI_TWO_ROWS + two, (two > 0) == (left != right));
    }
    cqi_add_row(d, v, left);
    if (two) cqi_add_row(d, v, right);
    return !d->seams->full;
}

#endif

/* Is the edge of h marked? By what is known of the edges around, and by its length compared with marked ones. */
static cq_result cqi_code_mark(cq_decoder *d, cq_index h)
{
    cqi_regular *r = &d->regular;
    const cq_mesh *m = &d->mesh;
    const cq_index g = m->twin[h], v = (cq_index)(r->vertices + r->count);
    int a = cqi_mark_pair(d, h, h), b = cqi_mark_pair(d, g, h), row = 0;
    uint32_t length = 0;
    if (a > b) {
        const int larger = a;
        a = b;
        b = larger;
    }
    if (d->located >= 0) {
        length = 16 * cqi_distance(d, m->origin[h], m->origin[g]);
        if (r->count) row = 1 + cqi_ratio_class(length, r->length, -10, -4, 4);
    }
    if (!cqi_code_bit(d, CQI_MARK + 5 * (b * (b + 1) / 2 + a) + row,
                      CQI_ENCODING(d) && cqi_plan_mark(d->plan, h) != CQ_NONE))
        return CQ_OK;
    if (v >= m->first_virtual) return CQ_ERROR_CORRUPT;
    r->length = r->count ? r->length - (r->length >> 5) + (length >> 5) : length;
    r->count++;
    d->mesh.out[v] = h;
    d->mesh.mark[v] = (uint8_t)(g % 3 << 4);
    cqi_set_mark(d, h);
    if (cqi_is_real_face(m, g)) cqi_set_mark(d, g);
    CQI_TRACE(d, CQ_EVENT_MARK, v, m->origin[h], m->origin[g]);
    return d->seams && !cqi_code_rows_of_mark(d, h, v) ? CQ_ERROR_CORRUPT : CQ_OK;
}

/* Are there enough new vertices for linear time, one for every 16 old ones and for every 32 faces? */
static int cqi_is_worth_it(const cqi_regular *r)
{
    return r->count >= CQI_MIN_SPLITS(r->vertices) && r->count > r->real_faces / 32;
}

/* The marks of one face. */
static cq_result cqi_step_marks(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    cq_index h;
    cq_result result = CQ_OK;
    r->at = cqi_next_coarse(d, r->at);
    if (r->at == r->faces) {
        if (!cqi_is_worth_it(r)) return CQ_ERROR_CORRUPT;
        for (r->bucket = 0; (3 * r->faces - 1) >> r->bucket >= r->count;) r->bucket++;
        r->at = r->record = 0;
        d->phase = CQI_TABLE;
        if (CQI_REPORTING(d)) cqi_charge(d, &d->report->flags, &cqi_level_report(d)->flags);
        return CQ_OK;
    }
    h = (cq_index)(3 * r->at++);
    for (; h < 3 * r->at && result == CQ_OK; h++)
        if (d->mesh.twin[h] > h) result = cqi_code_mark(d, h);
    return cqi_starved(d) ? CQ_TRUNCATED : result;
}

/* -- Regular levels: other channels --
 *
 * Channels that may be averaged are predicted as positions are, from the same vertices, but with the same weights for
 * all components and directions. Weights of skinning are predicted from the two ends of the edge, as in levels of
 * patches. What may not be averaged is mostly a copy of one of these ends. */

/* Is the channel predicted as positions are? */
static int cqi_is_expected(const cq_decoder *d, uint32_t k)
{
    const cq_channel *const c = &d->shape.channel[k];
    return CQI_HAS_ATTRIBUTES && (int)k != d->located && c->merge == CQ_AVERAGE && c->kind != CQ_WEIGHTS;
}

/* Is any channel predicted as positions are, or are there positions? */
static int cqi_has_expected(const cq_decoder *d)
{
    uint32_t k;
    for (k = 0; k < d->shape.num_channels; k++)
        if ((int)k == d->located || cqi_is_expected(d, k)) return 1;
    return 0;
}

/* Lets cqi_at look at channel k, at three components from `part` on. */
static void cqi_look_at(cq_decoder *d, uint32_t k, uint32_t part)
{
    d->regular.view = k;
    d->regular.part = part;
    d->regular.fold = 0;
}

static void cqi_look_at_positions(cq_decoder *d) { cqi_look_at(d, (uint32_t)(d->located < 0 ? 0 : d->located), 0); }

/* Has pairs folded if that of v, final or expected, is in the lower hemisphere. */
static void cqi_look_around(cq_decoder *d, cq_index v)
{
    const cq_channel *const c = &d->shape.channel[d->regular.view];
    const int32_t half = cqi_half_of(c);
    cqi_vector x;
    d->regular.fold = 0;
    if (!cqi_may_be_pair(c)) return;
    x = cqi_at(d, v);
    d->regular.fold = (int32_t)(cqi_abs(x.x - half) + cqi_abs(x.y - half)) > half;
}

/* -- Regular levels: slots of faces -- */

/* Prepares for the first vertex to take slots: for its record, or for its faces. */
static void cqi_rewind_slots(cq_decoder *d)
{
    uint32_t k;
    d->regular.record = d->regular.faces;
    for (k = 0; d->materials && k < d->shape.num_materials; k++)
        d->materials[k].count = (cq_index)(d->materials[k].scan - d->materials[k].first);
}

/* Takes the slots of the faces that an insertion into the edge h makes; they have the materials of the edge's faces. 0:
 * there is no room. */
static int cqi_take_slots(cq_decoder *d, cq_index h)
{
    const cq_index side[2] = { h, d->mesh.twin[h] };
    int i;
    for (i = 0; i < 2; i++) {
        cq_index *const slot = &d->regular.slot[i];
        *slot = CQ_NONE;
        if (!cqi_is_real_face(&d->mesh, side[i])) continue;
        *slot = d->materials ? cqi_next_of_material(d, (cq_index)(side[i] / 3)) : d->regular.record++;
        if (*slot >= d->mesh.first_virtual_face) return 0;
    }
    return 1;
}

/* -- Regular levels: the new vertices by their edges --
 *
 * out[] of new vertices is in ascending order. Halfedges are divided into buckets of 2^bucket, no more buckets than new
 * vertices; valence[] of new vertex k is the first new vertex in bucket k. A bucket has at most 128 halfedges; with
 * materials more, as free slots count, too. The search in a bucket halves what is left until that is 8 halfedges: it
 * looks at no more than `bucket` + 6 vertices. */

static cq_result cqi_step_table(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    const cq_index *out = d->mesh.out + r->vertices;
    cq_index *first = d->mesh.valence + r->vertices;
    int k;
    for (k = 0; k < CQI_AT_ONCE && r->at < r->count; k++) {
        if (r->record <= out[r->at] >> r->bucket) first[r->record++] = r->at;
        else r->at++;
    }
    if (r->at < r->count) return CQ_OK;
    r->at = cqi_has_expected(d) ? 0 : r->count;
    d->phase = CQI_EXPECT;
    return CQ_OK;
}

/* The new vertex on a coarse edge, or CQ_NONE. */
static cq_index cqi_vertex_on(const cq_decoder *d, cq_index h)
{
    const cqi_regular *r = &d->regular;
    const cq_mesh *m = &d->mesh;
    cq_index v;
    int bits;
    if (m->twin[h] < h) h = m->twin[h];
    if (!cqi_has_mark(d, h)) return CQ_NONE;
    v = (cq_index)(r->vertices + m->valence[r->vertices + (h >> r->bucket)]);
    if (m->out[v] == h) return v;
    for (bits = r->bucket; bits > 3;) {
        const cq_index ahead = (cq_index)(v + ((cq_index)1 << --bits));
        if (ahead < r->vertices + r->count && m->out[ahead] <= h) v = ahead;
    }
    while (m->out[v] != h) v++;
    return v;
}

/* -- Regular levels: predictions --
 *
 * A prediction is a weighted sum of features. Weights along the surface differ from those above it: a tilt takes two
 * components as x and y, and the third one as z, which is measured above a plane that rises by the slopes. */

typedef struct cqi_tilt {
    int axis[3];                 /* components that are x, y, z here */
    int32_t slope_x, slope_y;    /* in 1/256 */
    int32_t edge_x, edge_y;      /* the edge in x and y, with 12 bits, */
    int32_t inverse;             /* 2^39 / its square; all three 0: it has no direction there */
} cqi_tilt;

/* Sets the direction of an edge. Its square is at least 2^22 and below 2^25, so 2^14 < inverse <= 2^17. */
static void cqi_set_edge(cqi_tilt *t, cqi_vector edge)
{
    const int bits = cqi_bit_length(cqi_abs(edge.x) | cqi_abs(edge.y));
    t->edge_x = bits > 12 ? cqi_floor_shift(edge.x, bits - 12) : edge.x * (1 << (12 - bits));
    t->edge_y = bits > 12 ? cqi_floor_shift(edge.y, bits - 12) : edge.y * (1 << (12 - bits));
    t->inverse = bits ? (int32_t)(0x80000000u / ((uint32_t)(t->edge_x * t->edge_x + t->edge_y * t->edge_y) >> 8)) : 0;
}

/* Sets a tilt to the plane of a normal, which is below 2^30, and to an edge in it. */
static void cqi_set_tilt(cqi_tilt *t, cqi_vector edge, cqi_vector normal, int axes)
{
    const int shift = 1 + cqi_bit_length((cqi_abs(normal.x) | cqi_abs(normal.y) | cqi_abs(normal.z)) >> 20);
    int k = axes - 1;
    int32_t nearest = 0;
    if (!axes) {
        normal = cqi_shift(normal, shift);
        k = cqi_abs(normal.y) > cqi_abs(normal.x);
        if (cqi_abs(normal.z) > cqi_abs(k ? normal.y : normal.x)) k = 2;
        normal = cqi_in_cycle(normal, k);
        nearest = normal.z;
    }
    t->axis[2] = k;
    t->axis[0] = k < 2 ? k + 1 : 0;
    t->axis[1] = 3 - k - t->axis[0];
    t->slope_x = nearest ? -(normal.x * 256 / nearest) : 0;
    t->slope_y = nearest ? -(normal.y * 256 / nearest) : 0;
    cqi_set_edge(t, cqi_in_cycle(edge, k));
}

static cqi_vector cqi_tilted(const cqi_tilt *t, cqi_vector a) { return cqi_in_cycle(a, t->axis[2]); }

/* The same with z as the height above the plane. */
static cqi_vector cqi_above(const cqi_tilt *t, cqi_vector a)
{
    cqi_vector x = cqi_tilted(t, a);
    x.z -= cqi_product(t->slope_x, x.x, 8) + cqi_product(t->slope_y, x.y, 8);
    return x;
}

/* Normal of one or two triangles at the edge a -> b: to c on its left, and to e on its right. */
static cqi_vector cqi_normal_of(cqi_vector b, const cqi_vector *c, const cqi_vector *e)
{
    cqi_vector sum = { 0, 0, 0 };
    uint32_t bits = cqi_abs(b.x) | cqi_abs(b.y) | cqi_abs(b.z);
    int shift;
    if (c) bits |= cqi_abs(c->x) | cqi_abs(c->y) | cqi_abs(c->z);
    if (e) bits |= cqi_abs(e->x) | cqi_abs(e->y) | cqi_abs(e->z);
    shift = cqi_bit_length(bits >> 13);
    b = cqi_shift(b, shift);
    if (c) sum = cqi_cross(b, cqi_shift(*c, shift));
    if (e) sum = cqi_plus(sum, cqi_cross(cqi_shift(*e, shift), b));
    return sum;
}

/* The halfedge that goes straight on from the origin of h, seen from its target; along a boundary, if h is on it. An
 * odd valence has two, this one and the next one clockwise: then *two is set. CQ_NONE: there is none. */
static cq_index cqi_straight(const cq_mesh *m, cq_index h, int *two)
{
    const cq_index n = m->valence[m->origin[h]];
    cq_index end = h, k;
    *two = 0;
    if (n > CQ_MAX_VALENCE) return CQ_NONE;
    if (m->num_virtual) {
        const cq_index right = cq_clockwise(m, h), left = cq_counterclockwise(m, h);
        if (cq_is_virtual(m, cq_target(m, right))) return cq_clockwise(m, right);
        if (cq_is_virtual(m, cq_target(m, left))) return cq_counterclockwise(m, left);
        if (cqi_on_boundary(m, m->origin[h])) return CQ_NONE;
    }
    for (k = 0; k < n / 2; k++) end = cq_clockwise(m, end);
    *two = n & 1;
    return end;
}

/* Finds the halfedges that go straight on from both ends of the edge at hand, which is that of h. */
static void cqi_look_ahead(cq_decoder *d, cq_index h)
{
    cqi_regular *r = &d->regular;
    r->ahead[0] = cqi_straight(&d->mesh, h, &r->two_ahead[0]);
    r->ahead[1] = cqi_straight(&d->mesh, d->mesh.twin[h], &r->two_ahead[1]);
}

/* Twice the place of what lies straight on from an end of the edge at hand. */
static cqi_vector cqi_place_ahead(const cq_decoder *d, int end)
{
    const cq_mesh *m = &d->mesh;
    const cq_index on = d->regular.ahead[end], two = d->regular.two_ahead[end] ? cq_clockwise(m, on) : on;
    return cqi_plus(cqi_at(d, cq_target(m, on)), cqi_at(d, cq_target(m, two)));
}

/* What the coarse mesh says of the middle of the edge a -> b of a real face, as the butterfly scheme does (N. Dyn, D.
 * Levin, J. Gregory, 1990): offsets from that middle, times 4. Wings are the vertices beyond the other edges of the two
 * faces; what lies straight on from a and b gives the four-point rule. t is NULL for other channels than positions. */
static void cqi_find_fixed(const cq_decoder *d, cq_index h, cqi_vector *feature, cqi_tilt *t)
{
    const cq_mesh *m = &d->mesh;
    const cq_index side[2] = { h, m->twin[h] };
    const cqi_vector a = cqi_at(d, m->origin[h]), b = cqi_from(d, a, m->origin[side[1]]), none = { 0, 0, 0 };
    cqi_vector tip[2], wings = none, ahead = none;
    int inner = 0, num_wings = 0, num_ahead = 0, i;
    for (i = 0; i < 2; i++) {
        const cq_index s = side[i], next = m->twin[cq_next(s)], prev = m->twin[cq_prev(s)];
        inner = cqi_is_real_face(m, s);
        tip[i] = none;
        if (d->regular.ahead[i] != CQ_NONE) {
            num_ahead += 1 + i;
            ahead = cqi_plus(ahead, cqi_minus(cqi_place_ahead(d, i), cqi_scale(a, 2)));
        }
        if (!inner) continue;
        tip[i] = cqi_from(d, a, m->origin[cq_prev(s)]);
        if (!cqi_is_real_face(m, next) || !cqi_is_real_face(m, prev)) continue;
        wings = cqi_plus(wings, cqi_plus(cqi_at(d, m->origin[cq_prev(next)]), cqi_at(d, m->origin[cq_prev(prev)])));
        num_wings += 2;
    }
    if (t) cqi_set_tilt(t, b, cqi_normal_of(b, &tip[0], inner ? &tip[1] : NULL), d->regular.axes);
    feature[0] = inner ? cqi_scale(cqi_minus(cqi_plus(tip[0], tip[1]), b), 2) : none;
    feature[1] = num_wings == 4 ? cqi_minus(wings, cqi_plus(cqi_scale(a, 4), cqi_scale(b, 2))) : feature[0];
    if (num_ahead == 1) ahead = cqi_plus(ahead, cqi_scale(b, 4));        /* beyond a: b + (b - a) instead of what is
                                                                            beyond b */
    feature[2] = num_ahead ? cqi_minus(ahead, cqi_scale(b, num_ahead == 2 ? 4 : 2)) : none;
}

/* Weighted sums of n features, in 1/256. Of the sum that the last n weights give, only the part along the edge is
 * added. That is below 2^39 after the first shift, has 56 bits times the inverse, and in the end 53 times the edge. */
static void cqi_weigh(const cqi_tilt *t, const cqi_vector *feature, const int8_t *weight, int n, int64_t *sum)
{
    int64_t part = 0, sum_x = 0, sum_y = 0, sum_z = 0;
    int k;
    for (k = 0; k < n; k++) {
        const cqi_vector x = cqi_above(t, feature[k]);
        sum_x += (int64_t)weight[k] * x.x;
        sum_y += (int64_t)weight[k] * x.y;
        sum_z += (int64_t)weight[n + k] * x.z;
        if (weight[2 * n + k]) part += weight[2 * n + k] * ((int64_t)t->edge_x * x.x + (int64_t)t->edge_y * x.y);
    }
    sum[0] = sum_x;
    sum[1] = sum_y;
    sum[2] = sum_z;
    if (!part) return;
    part = cqi_floor_shift_wide(cqi_floor_shift_wide(part, 12) * t->inverse, 15);
    sum[0] += cqi_floor_shift_wide(part * t->edge_x, 12);
    sum[1] += cqi_floor_shift_wide(part * t->edge_y, 12);
}

static int32_t cqi_rounded(int64_t x) { return (int32_t)cqi_floor_shift_wide(x + 128, 8); }

/* Puts new vertex v where the fixed prediction expects it. */
static void cqi_expect(cq_decoder *d, cq_index v)
{
    const cq_index h = d->mesh.out[v], a = d->mesh.origin[h];
    const int32_t most = (int32_t)(((uint32_t)1 << d->shape.channel[d->located].bits) - 1);
    cq_value *const to = d->channel[d->located] + 3 * (size_t)v;
    const cq_value *const from = d->channel[d->located] + 3 * (size_t)a;
    cqi_vector feature[CQI_FIXED], b;
    cqi_tilt t;
    int64_t sum[3];
    int32_t x[3];
    int c;
    cqi_find_fixed(d, h, feature, &t);
    cqi_weigh(&t, feature, d->regular.fixed, CQI_FIXED, sum);
    b = cqi_tilted(&t, cqi_from(d, cqi_at(d, a), cq_target(&d->mesh, h)));
    x[0] = cqi_rounded(sum[0] + 128 * (int64_t)b.x);
    x[1] = cqi_rounded(sum[1] + 128 * (int64_t)b.y);
    sum[2] +=
        t.slope_x * (int64_t)(x[0] - cqi_floor_shift(b.x, 1)) + t.slope_y * (int64_t)(x[1] - cqi_floor_shift(b.y, 1));
    x[2] = cqi_rounded(sum[2] + 128 * (int64_t)b.z);
    for (c = 0; c < 3; c++) to[t.axis[c]] = (cq_value)cqi_clamp(from[t.axis[c]] + x[c], 0, most);
}

/* The values that a vector stands for, clamped to their range; a pair is folded back. */
static cqi_vector cqi_unseen(const cq_decoder *d, cqi_vector x)
{
    const cq_channel *const c = &d->shape.channel[d->regular.view];
    const int32_t low = cqi_is_exact(c) ? -0x800000 : 0;
    const int32_t most = (int32_t)(((uint32_t)1 << (cqi_is_exact(c) ? 23 : c->bits)) - 1);
    x.x = cqi_clamp(x.x, low, most);
    x.y = cqi_clamp(x.y, low, most);
    x.z = cqi_clamp(x.z, low, most);
    if (d->regular.fold) cqi_fold_seen(c, &x);
    return x;
}

/* A vector plus the weighted sum of n features, with weights in 1/256. */
static cqi_vector cqi_sum_features(cqi_vector from, const cqi_vector *feature, const int8_t *weight, int n)
{
    int64_t x = 0, y = 0, z = 0;
    int k;
    for (k = 0; k < n; k++) {
        x += (int64_t)weight[k] * feature[k].x;
        y += (int64_t)weight[k] * feature[k].y;
        z += (int64_t)weight[k] * feature[k].z;
    }
    from.x += cqi_rounded(x);
    from.y += cqi_rounded(y);
    from.z += cqi_rounded(z);
    return from;
}

#ifdef CQ_NO_WEDGES
#define cqi_expect_rows(d, v) ((void)0)
#define cqi_note_rows(d, s, f) ((void)0)
#else

/* -- Regular levels: rows --
 *
 * A new vertex has one row; or two, one on each side of its edge, if that is a seam there. Corners on one side of the
 * edge have the same row, as no edge inside of a coarse face is a seam. A row is expected to be the mean of the rows at
 * the edge's ends, on its side; a single row, on the left side. The record of a new vertex, see "records" below, also
 * has rows, in index[]: those of the opposite vertex and of the new vertices on the other two edges, on that side. */

static int cqi_has_row_values(const cq_decoder *d, uint32_t k)
{
    return d->seams && cqi_class(&d->shape, k) == CQI_OF_ROW;
}

/* The first row of a new vertex; rows are in the order of the vertices. */
static cq_index cqi_first_row(const cq_decoder *d, cq_index v)
{
    cq_index low = d->regular.first_row, high = d->seams->num_rows;
    while (low < high) {
        const cq_index middle = (cq_index)(low + (high - low) / 2);
        if (d->vertex[middle] < v) low = (cq_index)(middle + 1);
        else high = middle;
    }
    return low;
}

static int cqi_has_two_rows(const cq_decoder *d, cq_index v, cq_index first)
{
    return first + 1 < d->seams->num_rows && d->vertex[first + 1] == v;
}

/* The row of the new vertex on a coarse edge, on the left of halfedge h; or CQ_NONE. */
static cq_index cqi_row_on(const cq_decoder *d, cq_index h)
{
    const cq_index v = cqi_vertex_on(d, h);
    cq_index row;
    if (v == CQ_NONE) return v;
    row = cqi_first_row(d, v);
    return (cq_index)(row + (d->mesh.out[v] != h && cqi_has_two_rows(d, v, row)));
}

/* Writes the rows of the record of halfedge s, in face slot f. */
static void cqi_note_rows(cq_decoder *d, cq_index s, cq_index f)
{
    d->index[3 * f] = d->index[cq_prev(s)];
    d->index[3 * f + 1] = cqi_row_on(d, cq_next(s));
    d->index[3 * f + 2] = cqi_row_on(d, cq_prev(s));
}

/* Puts the values that are expected into the rows of a new vertex. */
static void cqi_expect_rows(cq_decoder *d, cq_index v)
{
    const cq_index h = d->mesh.out[v], g = d->mesh.twin[h], first = cqi_first_row(d, v);
    const cq_index a[2] = { d->index[h], d->index[cq_next(g)] }, b[2] = { d->index[cq_next(h)], d->index[g] };
    uint32_t k, c;
    int i;
    for (k = 0; k < d->shape.num_channels; k++) {
        const cq_channel *const channel = &d->shape.channel[k];
        const size_t n = channel->components;
        cq_value *const to = d->channel[k];
        if (!cqi_has_row_values(d, k) || !cqi_is_expected(d, k)) continue;
        for (i = 0; i < 1 + cqi_has_two_rows(d, v, first); i++)
            for (c = 0; c < n; c++) {
                const int32_t sum = cqi_rough(channel, to[a[i] * n + c]) + cqi_rough(channel, to[b[i] * n + c]);
                to[(first + (cq_index)i) * n + c] =
                    (cq_value)cqi_number(channel, cqi_unrough(channel, cqi_floor_shift(sum, 1)));
            }
    }
}

#endif

/* Puts the values that are expected of a new vertex into its places in the other channels. */
static void cqi_expect_others(cq_decoder *d, cq_index v)
{
    const cq_index h = d->mesh.out[v], a = d->mesh.origin[h], b = cq_target(&d->mesh, h);
    uint32_t k, part, c;
    for (k = 0; k < d->shape.num_channels; k++) {
        const cq_channel *const channel = &d->shape.channel[k];
        if (!cqi_is_expected(d, k) || cqi_class(&d->shape, k) == CQI_OF_ROW) continue;
        for (part = 0; part < channel->components; part += 3) {
            cq_value *const to = d->channel[k] + channel->components * (size_t)v + part;
            cqi_vector feature[CQI_FIXED], x;
            cqi_look_at(d, k, part);
            cqi_look_around(d, a);
            cqi_find_fixed(d, h, feature, NULL);
            x = cqi_shift(cqi_plus(cqi_at(d, a), cqi_at(d, b)), 1);
            x = cqi_unseen(d, cqi_sum_features(x, feature, d->regular.weight[k], CQI_FIXED));
            for (c = 0; c < 3 && part + c < channel->components; c++)
                to[c] = (cq_value)cqi_number(channel, cqi_unrough(channel, cqi_component(x, (int)c)));
        }
    }
    if (d->seams) cqi_expect_rows(d, v);
    cqi_look_at_positions(d);
}

/* -- Regular levels: what is known of the refined mesh -- */

/* The vertex that will be opposite to the unmarked edge of h, once its face has its new vertices. */
static cq_index cqi_expected_tip(const cq_decoder *d, cq_index h)
{
    cq_index v = cqi_vertex_on(d, cq_next(h));
    if (v == CQ_NONE) v = cqi_vertex_on(d, cq_prev(h));
    return v != CQ_NONE ? v : d->mesh.origin[cq_prev(h)];
}

/* Is the edge of h, which has no mark, dissolved? The later one of its faces has noted that. */
static int cqi_is_dissolved(const cq_decoder *d, cq_index h)
{
    const cq_index g = d->mesh.twin[h] > h ? d->mesh.twin[h] : h;
    return cqi_is_real_face(&d->mesh, g) && cqi_dissolved_side(d, (cq_index)(g / 3)) == 1 + (int)(g % 3);
}

/* Which edges the refined mesh has around the origin of h, on h and then counter-clockwise up to the next coarse edge.
 * Bit 0: the one on h, unless that is dissolved. Bit 1: one into the face of h, to a hub opposite to the origin; or if
 * the face has no mark, across the opposite edge, if that is dissolved. The table has two bits for each side of a face in
 * each state: the side is marked; and the hub is opposite to its origin. */
static int cqi_spokes_of(const cq_decoder *d, cq_index h)
{
    static const uint8_t by_state[32] = { 0, 33, 6, 37, 24, 25, 22, 53, 0, 33, 6, 37, 24, 25, 22, 23,
                                          0, 33, 6, 7,  24, 49, 28, 29, 0, 33, 6, 7,  24, 49, 28, 21 };
    const cq_index f = (cq_index)(h / 3), side = (cq_index)(h - 3 * f);
    const int state = cqi_state_of(d, f), spokes = by_state[state] >> 2 * side & 3;
    if (spokes & 1) return spokes;
    return spokes + !cqi_is_dissolved(d, h) + 2 * (!(state & 7) && cqi_is_dissolved(d, cq_next(h)));
}

static cq_index cqi_spoke_end(const cq_decoder *d, cq_index h, int inside)
{
    const cq_index v = cqi_vertex_on(d, inside ? cq_next(h) : h);
    if (v != CQ_NONE) return v;
    return inside ? cqi_expected_tip(d, d->mesh.twin[cq_next(h)]) : cq_target(&d->mesh, h);
}

/* What will lie straight on from the origin of coarse halfedge h: one vertex twice, or two; or CQ_NONE twice. */
static void cqi_find_ahead(const cq_decoder *d, cq_index h, cq_index *ahead)
{
    const cq_mesh *m = &d->mesh;
    const cq_index v = m->origin[h];
    cq_index around[CQ_MAX_VALENCE];
    uint8_t edge[2 * CQ_MAX_VALENCE]; /* around v: twice the number of a halfedge, and 1 if it is inside of its face */
    cq_index s = h;
    int n = 0, i = 0, k;
    ahead[0] = ahead[1] = CQ_NONE;
    if (m->valence[v] > CQ_MAX_VALENCE) return;
    if (cqi_on_boundary(m, v)) {
        s = cqi_straight(m, h, &k);
        if (s != CQ_NONE) ahead[0] = ahead[1] = cqi_spoke_end(d, s, 0);
        return;
    }
    do {
        const int spokes = cqi_spokes_of(d, s);
        edge[n] = (uint8_t)(2 * i);
        n += spokes & 1;
        edge[n] = (uint8_t)(2 * i + 1);
        n += spokes >> 1;
        around[i++] = s;
        s = cq_counterclockwise(m, s);
    } while (s != h);
    for (k = 0; k <= (n & 1) && n > 2; k++)
        ahead[k] = cqi_spoke_end(d, around[edge[n / 2 + k] / 2], edge[n / 2 + k] & 1);
    if (!(n & 1)) ahead[1] = ahead[0];
}

/* -- Regular levels: records --
 *
 * For each real face of its edge a -> b, a new vertex has a face slot that its insertion will fill. Until then, the
 * slot holds its record of this face, as origin[] and twin[]: the opposite vertex; the new vertices on the next and the
 * previous edge; what lies straight on from the edge's start, the second one if there are two; and, of the faces beyond
 * these two edges, the new vertices on those edges that meet this one at b or at a.
 *
 * Some of these are written otherwise:
 *
 *     opposite vertex w    CQ_NONE - 2 w, and 1 less if the new vertex is the hub of this face: so the slot is no face,
 *                          as 2 V < CQ_NONE - V
 *     next, previous       if a fan around the new vertex of the third edge separates it from that of a -> b: CQ_NONE,
 *                          and it takes the place of the one beyond
 *     straight on          around a vertex of valence 5, the first of two is also the one beyond the previous edge:
 *                          then the second one, w, is written as CQI_JOINED - w
 *     next, previous       if that edge is dissolved, which joins the new vertex of a -> b to a vertex beyond it:
 *                          CQI_JOINED, and that vertex is in the place of the one beyond */

#define CQI_JOINED ((cq_index)(CQ_NONE - 1))

/* What the record of h says of `edge`, its next or previous one, and beyond it. by_fan: a fan around the new vertex of
 * the third edge separates the new vertices of these two. */
static void cqi_write_beyond(const cq_decoder *d, cq_index h, cq_index edge, int by_fan, cq_index *beside, cq_index *beyond)
{
    const cq_index g = d->mesh.twin[edge], v = cqi_vertex_on(d, edge);
    *beside = v;
    *beyond = CQ_NONE;
    if (by_fan && v != CQ_NONE) {
        *beside = CQ_NONE;
        *beyond = v;
    }
    else if (v == CQ_NONE && cqi_is_dissolved(d, edge) && cqi_expected_tip(d, edge) == cqi_vertex_on(d, h)) {
        *beside = CQI_JOINED;
        *beyond = cqi_expected_tip(d, g);
    }
    else if (cqi_is_real_face(&d->mesh, g)) *beyond = cqi_vertex_on(d, edge == cq_next(h) ? cq_next(g) : cq_prev(g));
}

static void cqi_write_side(cq_decoder *d, cq_index s, int end)
{
    cq_mesh *m = &d->mesh;
    const cq_index f = d->regular.slot[end], t = (cq_index)(s / 3), next = cq_next(s), prev = cq_prev(s);
    const cq_index hub = (cq_index)(3 * t + (cq_index)cqi_hub_side(d, t));
    cq_index *const origin = m->origin + 3 * f, *const twin = m->twin + 3 * f, ahead[2];
    cqi_find_ahead(d, s, ahead);
    origin[0] = (cq_index)(CQ_NONE - 2 * m->origin[prev] - (hub == s));
    cqi_write_beyond(d, s, next, hub == prev, &origin[1], &twin[1]);
    cqi_write_beyond(d, s, prev, hub == next, &origin[2], &twin[2]);
    twin[0] = ahead[0] == twin[2] && ahead[1] != CQ_NONE ? (cq_index)(CQI_JOINED - ahead[1]) : ahead[1];
    if (d->seams) cqi_note_rows(d, s, f);
}

/* Writes the record of a vertex; 0 if there is no room for its faces. */
static int cqi_write_record(cq_decoder *d, cq_index v)
{
    const cq_index h = d->mesh.out[v];
    if (!cqi_take_slots(d, h)) return 0;
    cqi_write_side(d, h, 0);
    if (d->regular.slot[1] != CQ_NONE) cqi_write_side(d, d->mesh.twin[h], 1);
    return 1;
}

/* The vertex opposite to a new one, in the record. */
static cq_index cqi_record_tip(const cq_mesh *m, cq_index slot)
{
    return (cq_index)((CQ_NONE - m->origin[3 * slot]) / 2);
}

/* Is the new vertex the hub of the face? */
static int cqi_is_hub(const cq_mesh *m, cq_index slot) { return (CQ_NONE - m->origin[3 * slot]) & 1; }

/* Does the record have two vertices straight on? And which is the only one, or the second of two? */
static int cqi_has_two_ahead(const cq_mesh *m, cq_index slot)
{
    return m->twin[3 * slot] >= CQ_NONE / 2 && m->twin[3 * slot] != CQ_NONE;
}

static cq_index cqi_record_ahead(const cq_mesh *m, cq_index slot)
{
    const cq_index x = m->twin[3 * slot];
    return cqi_has_two_ahead(m, slot) ? (cq_index)(CQI_JOINED - x) : x;
}

/* Adds the offset of v from the place where the new vertex is expected. */
static inline void cqi_add_offset(const cq_decoder *d, cqi_vector *sum, const cqi_vector *place, cq_index v)
{
    if (v != CQ_NONE) *sum = cqi_plus(*sum, cqi_from(d, *place, v));
}

/* Features around the place where v is expected, in its edge h, and the plane of its faces. Vertices whose place is
 * final have other weights than those that are only expected. */
static void cqi_find_fine(const cq_decoder *d, cq_index v, cq_index h, cqi_vector *feature, cqi_tilt *t)
{
    const cq_mesh *m = &d->mesh;
    const cq_index *const slot = d->regular.slot;
    const cqi_vector place = cqi_at(d, v), a = cqi_at(d, m->origin[h]), b = cqi_at(d, cq_target(m, h));
    cqi_vector tip[2];
    int i, k;
    memset(feature, 0, CQI_FINE * sizeof *feature);
    for (i = 0; i < 2 && slot[i] != CQ_NONE; i++) {
        const cq_index *const origin = m->origin + 3 * slot[i], *const twin = m->twin + 3 * slot[i];
        const cq_index opposite = cqi_record_tip(m, slot[i]);
        const cq_index ahead = cqi_record_ahead(m, slot[i]);
        tip[i] = cqi_from(d, a, opposite);
        for (k = 1; k < 3; k++) {
            const int joined = origin[k] == CQI_JOINED;
            if (!joined) cqi_add_offset(d, &feature[origin[k] < v ? 0 : 1], &place, origin[k]);
            cqi_add_offset(d, &feature[joined ? 7 : twin[k] < v ? 3 : 4], &place, twin[k]);
        }
        cqi_add_offset(d, &feature[cqi_is_hub(m, slot[i]) ? 7 : 2], &place, opposite);
        cqi_add_offset(d, &feature[5], &place, ahead);
        cqi_add_offset(d, &feature[5], &place, cqi_has_two_ahead(m, slot[i]) ? twin[2] : ahead);
    }
    feature[2] = cqi_scale(feature[2], 2);
    feature[6] = cqi_scale(cqi_plus(cqi_minus(a, place), cqi_minus(b, place)), 2);
    feature[7] = cqi_scale(feature[7], 2);
    if (!t) return;
    cqi_set_tilt(t, cqi_minus(b, a), cqi_normal_of(cqi_minus(b, a), &tip[0], slot[1] != CQ_NONE ? &tip[1] : NULL),
                 d->regular.axes);
}

/* Are normals of faces a feature of the channel? */
static int cqi_has_normals(const cq_decoder *d, uint32_t k)
{
    return cqi_has_pairs(d, k) && d->shape.channel[k].kind == CQ_NORMAL;
}

/* What the normals of its faces say of v's pair. Places that are not final yet are those that are expected. */
static void cqi_find_normal(const cq_decoder *d, cq_index v, cq_index number, cq_index h, int sides,
                            cqi_vector *feature)
{
    const cq_mesh *m = &d->mesh;
    const cq_channel *const channel = &d->shape.channel[d->regular.view];
    const cq_value *const at = d->channel[d->located];
    const cq_index end[2] = { m->origin[h], cq_target(m, h) };
    const cqi_vector expected = cqi_at(d, number);
    cqi_vector64 sum = { 0, 0, 0 };
    cqi_pair_of_normal pair;
    int i, k;
    for (i = 0; i < 2 && d->regular.slot[i] != CQ_NONE; i++) {
        const cq_index *const record = m->origin + 3 * d->regular.slot[i];
        const int alone = record[1] >= CQI_JOINED && record[2] >= CQI_JOINED;
        const cq_index around[3] = { alone ? cqi_record_tip(m, d->regular.slot[i]) : record[1], record[2], end[i] };
        cq_index before = end[1 - i];
        for (k = 0; k < 3; k++) {
            if (around[k] >= CQI_JOINED || !(sides >> i & 1)) continue;
            cqi_add_normal(&sum, cqi_offset(at, v, before), cqi_offset(at, v, around[k]));
            before = around[k];
        }
    }
    memset(feature, 0, sizeof *feature);
    if (!cqi_pair_of(sum, cqi_half_of(channel), &pair)) return;
    feature->x = pair.x + cqi_half_of(channel);
    feature->y = pair.y + cqi_half_of(channel);
    if (d->regular.fold) cqi_fold_seen(channel, feature);
    *feature = cqi_scale(cqi_minus(*feature, expected), 4);
}

/* Number of features of the fine prediction of a channel: for rows, without what is beyond the faces and ahead. */
static int cqi_num_fine(const cq_decoder *d, uint32_t k)
{
    return (cqi_class(&d->shape, k) == CQI_OF_ROW ? CQI_FINE_OF_ROW : CQI_FINE) + cqi_has_normals(d, k);
}

#ifndef CQ_NO_WEDGES

/* Features around a row: on one side of the edge h, or on both. */
static void cqi_find_row(const cq_decoder *d, cq_index v, cq_index row, cq_index h, int sides, cqi_vector *feature)
{
    const cq_mesh *m = &d->mesh;
    const cq_index g = m->twin[h], first = cqi_first_row(d, v);
    const cq_index end[2][2] = { { d->index[h], d->index[cq_next(h)] }, { d->index[cq_next(g)], d->index[g] } };
    const cqi_vector place = cqi_at(d, row);
    int i, k;
    memset(feature, 0, CQI_MOST * sizeof *feature);
    for (i = 0; i < 2; i++) {
        const cq_index slot = d->regular.slot[i], *const beside = d->index + 3 * slot;
        if (!(sides >> i & 1) || slot == CQ_NONE) continue;
        for (k = 1; k < 3; k++) cqi_add_offset(d, &feature[beside[k] < first ? 0 : 1], &place, beside[k]);
        cqi_add_offset(d, &feature[beside[1] == CQ_NONE || beside[2] == CQ_NONE ? 3 : 2], &place, beside[0]);
        for (k = 0; k < 2; k++) cqi_add_offset(d, &feature[3], &place, end[i][k]);
    }
    feature[2] = cqi_scale(feature[2], 2);
    feature[3] = cqi_scale(feature[3], 2);
    if (cqi_has_normals(d, d->regular.view)) cqi_find_normal(d, v, row, h, sides, &feature[CQI_FINE_OF_ROW]);
}

/* The sides of the edge that row i of a vertex is on, given whether it has two. */
static int cqi_sides_of_row(int two, int i) { return two ? 1 << i : 3; }

#endif

/* -- Regular levels: weights -- */

static void cqi_code_signed(cq_decoder *d, int8_t *weight, int n)
{
    for (; n--; weight++) {
        const int x = (int)cqi_code_raw(d, (uint32_t)*weight & 255, 8);
        *weight = (int8_t)(x < 128 ? x : x - 256);
    }
}

/* Codes the axes, and the weights of n features; a bit says whether the last third is 0. */
static void cqi_code_weights(cq_decoder *d, int8_t *weight, int n)
{
    uint32_t any = 0;
    int k;
    for (k = 2 * n; k < 3 * n; k++) any |= CQI_ENCODING(d) && weight[k];
    d->regular.axes = (int)cqi_code_raw(d, (uint32_t)d->regular.axes, 2);
    cqi_code_signed(d, weight, 2 * n);
    if (cqi_code_raw(d, any, 1)) cqi_code_signed(d, weight + 2 * n, n);
    else memset(weight + 2 * n, 0, (size_t)n);
}

/* -- Regular levels: weights of an encoder --
 *
 * Iteratively reweighted least squares, in integers: an equation counts by its error to the power -1, later -3/2, so
 * that the residuals get short codes. As there are many minima, this is done three times, beginning with the weights of
 * the level before, with those of least squares and with zeros. Each weight of the best result is then moved to and fro
 * by ever smaller steps, where that makes the residuals cheaper. A sample is a vertex, one of CQI_MOST_SAMPLES at most:
 * its features along x, y and above the surface, and what their weighted sum should be.
 *
 * Bounds: features have 13 bits and a sign; offsets, which are in 1/16, have 16; shares have 12; so sums have 54. */
enum { CQI_PASSES = 8, CQI_SIZES = 24, CQI_FIRST_STEP = 16, CQI_LATER_STEP = 4, CQI_CHANGES = 4 };

typedef struct cqi_sums {
    int64_t a[CQI_MOST][CQI_MOST], b[CQI_MOST];
} cqi_sums;

/* Equations whose share in the sums has to change. */
typedef struct cqi_changes {
    const int16_t *x[CQI_CHANGES];
    int32_t y[CQI_CHANGES], change[CQI_CHANGES];
    int count;
} cqi_changes;

/* Samples to fit weights to. */
typedef struct cqi_samples {
    cqi_sample *sample;
    uint32_t count, some;          /* the first ones, every second sample, are enough to begin with */
    int parts;                     /* 4: this many for each choice of axes, one part after the other; else 1 */
} cqi_samples;

/* n weights that are fitted to components first .. last of the samples. */
typedef struct cqi_equations {
    const cqi_samples *samples;
    int first, last, n;
    cqi_sums sums;                 /* of all samples by their shares, without `changes`; not above the diagonal */
    cqi_changes changes;
    uint32_t size[CQI_SIZES];      /* errors of each size */
} cqi_equations;

/* Number of bits, without the sign, of an error in 1/256 after the prediction is rounded. */
static int cqi_size_of_error(int32_t error) { return cqi_bit_length(cqi_fold_sign(error - 1) + 128) - 8; }

/* What the errors of all samples, in so many components, cost in 1/8 bit, given how many have each size: the entropy of
 * the sizes, and the bits of each error. As the components share their models, they share the counts. */
static uint32_t cqi_cost_of_sizes(const cqi_samples *samples, const uint32_t *size, int components)
{
    const uint32_t all = cqi_log2(samples->count * (uint32_t)components);
    uint64_t cost = 0;
    int k;
    for (k = 0; k < CQI_SIZES; k++)
        if (size[k]) cost += (uint64_t)size[k] * (all - cqi_log2(size[k]) + 65536 * (uint32_t)k);
    return (uint32_t)(cost >> 13);
}

/* By how much less an equation with this error counts, in 1/8 octave. The error is in 1/256; 0 if it rounds to 0. */
static uint32_t cqi_discount(int32_t error)
{
    return cqi_abs(error) < 128 ? 0 : (uint32_t)cqi_logarithm((cqi_abs(error) >> 4) + 4) - 28;
}

/* The share of an equation with this error: the error to the power -power/2. */
static int32_t cqi_share(int32_t error, uint32_t power)
{
    static const uint16_t root[8] = { 4096, 3756, 3444, 3158, 2896, 2656, 2435, 2233 }; /* 2^(12 - k / 8) */
    const uint32_t less = power * cqi_discount(error) / 2;
    return (int32_t)((uint32_t)root[less % 8] >> less / 8);
}

/* Makes the changes to the sums: several at once, as loading and storing the sums takes most of the time. */
static void cqi_make_changes(cqi_equations *fit)
{
    cqi_changes *const c = &fit->changes;
    int i, j;
    for (; c->count < CQI_CHANGES; c->count++) {
        c->x[c->count] = c->x[0];
        c->change[c->count] = 0;
    }
    c->count = 0;
    for (i = 0; i < fit->n; i++) {
        const int64_t z0 = c->change[0] * c->x[0][i], z1 = c->change[1] * c->x[1][i];
        const int64_t z2 = c->change[2] * c->x[2][i], z3 = c->change[3] * c->x[3][i];
        for (j = 0; j <= i; j++)
            fit->sums.a[i][j] += z0 * c->x[0][j] + z1 * c->x[1][j] + z2 * c->x[2][j] + z3 * c->x[3][j];
        fit->sums.b[i] += z0 * c->y[0] + z1 * c->y[1] + z2 * c->y[2] + z3 * c->y[3];
    }
}

/* Changes the share of an equation in the sums: that of features x, whose weighted sum should be y in 1/16. */
static void cqi_change_share(cqi_equations *fit, const int16_t *x, int32_t y, int32_t change)
{
    cqi_changes *const c = &fit->changes;
    c->x[c->count] = x;
    c->y[c->count] = y;
    c->change[c->count] = change;
    if (++c->count == CQI_CHANGES) cqi_make_changes(fit);
}

/* Scales the equations to 28 bits, and adds a little to the diagonal, so that no feature is left undetermined. */
static void cqi_scale_fit(cqi_sums *fit, int n)
{
    int64_t most = 0;
    int i, j, shift = 0;
    for (i = 0; i < n; i++) most = fit->a[i][i] > most ? fit->a[i][i] : most;
    while (most >> shift >> 28) shift++;
    for (i = 0; i < n; i++) {
        for (j = 0; j <= i; j++) fit->a[i][j] = fit->a[j][i] = cqi_floor_shift_wide(fit->a[i][j], shift);
        fit->b[i] = cqi_floor_shift_wide(fit->b[i], shift);
        fit->a[i][i] += (fit->a[i][i] >> 16) + 1;
    }
}

/* Gaussian elimination; no pivots are needed, as the matrix is positive definite. Returns 1 if a weight changes. */
static int cqi_solve(const cqi_sums *sums, int8_t *weight, int n)
{
    cqi_sums scaled = *sums, *const fit = &scaled;
    int64_t x[CQI_MOST];
    int i, j, k, changed = 0;
    cqi_scale_fit(fit, n);
    for (i = 0; i < n; i++) {
        if (fit->a[i][i] < 1) fit->a[i][i] = 1;
        for (j = i + 1; j < n; j++) {
            const int64_t factor = fit->a[j][i] * ((int64_t)1 << 24) / fit->a[i][i];
            for (k = i; k < n; k++) fit->a[j][k] -= cqi_floor_shift_wide(factor * fit->a[i][k], 24);
            fit->b[j] -= cqi_floor_shift_wide(factor * fit->b[i], 24);
        }
    }
    for (i = n; i--;) {
        x[i] = 4096 * fit->b[i];
        for (k = i + 1; k < n; k++) x[i] -= fit->a[i][k] * x[k];
        x[i] /= fit->a[i][i];
        x[i] = x[i] < -0x7fff ? -0x7fff : x[i] > 0x7fff ? 0x7fff : x[i];
        k = cqi_clamp((int32_t)cqi_floor_shift_wide(x[i] + 128, 8), -127, 127);
        changed |= weight[i] != k;
        weight[i] = (int8_t)k;
    }
    return changed;
}

/* The error that the weights leave in a sample, in 1/256. */
static int32_t cqi_left_of(const int16_t *weight, const int16_t *x, int32_t y)
{
    int32_t sum = 0;
    int i;
    for (i = 0; i < CQI_FINE; i++) sum += (int32_t)weight[i] * x[i];
    return 16 * y - sum - (int32_t)weight[CQI_FINE] * x[CQI_FINE];
}

/* The weights with zeros after them: so all loops that multiply them are of the same length. */
static void cqi_widen(const int8_t *weight, int n, int16_t *wide)
{
    int i;
    for (i = 0; i < CQI_MOST; i++) wide[i] = i < n ? weight[i] : 0;
}

/* What the errors cost that the weights leave. Unless power is below 0, each equation then counts in the sums by its
 * error to the power -power/2. */
static uint32_t cqi_sum_equations(cqi_equations *fit, const int8_t *weight, int power)
{
    cqi_sample *const end = fit->samples->sample + fit->samples->count, *s;
    int16_t wide[CQI_MOST];
    int c;
    cqi_widen(weight, fit->n, wide);
    memset(fit->size, 0, sizeof fit->size);
    for (c = fit->first; c <= fit->last; c++)
        for (s = fit->samples->sample; s < end; s++) {
            const int32_t error = cqi_left_of(wide, s->feature[c], s->offset[c]);
            int32_t share;
            fit->size[cqi_size_of_error(error)]++;
            if (power < 0) continue;
            share = cqi_share(error, (uint32_t)power);
            if (share == s->state[c]) continue;
            cqi_change_share(fit, s->feature[c], s->offset[c], share - s->state[c]);
            s->state[c] = share;
        }
    if (fit->changes.count) cqi_make_changes(fit);
    return cqi_cost_of_sizes(fit->samples, fit->size, fit->last - fit->first + 1);
}

/* Fits the weights, beginning with those given; or with `squares`, with least squares. Returns about what the errors
 * cost, in 1/8 bit. If a pass changes nothing, further ones with the same power would not either. */
static uint32_t cqi_fit_from(cqi_equations *fit, int8_t *weight, int passes, int squares)
{
    int8_t best[CQI_MOST];
    uint32_t least = UINT32_MAX;
    int pass;
    for (pass = -squares;; pass++) {
        const int power = pass < 0 ? 0 : pass < passes / 2 ? 2 : pass < passes ? 3 : -1;
        const uint32_t cost = cqi_sum_equations(fit, weight, power);
        if (cost < least) {
            least = cost;
            memcpy(best, weight, (size_t)fit->n);
        }
        if (power < 0) break;
        if (cqi_solve(&fit->sums, weight, fit->n)) continue;
        if (power == 3) break;
        pass = passes / 2 - 1;
    }
    memcpy(weight, best, (size_t)fit->n);
    return least;
}

/* What the errors would cost if weight i were larger by `change`, and if it were less by that. */
static void cqi_cost_changes(const cqi_equations *fit, int i, int32_t change, uint32_t *cost)
{
    const cqi_sample *const end = fit->samples->sample + fit->samples->count, *s;
    uint32_t size[2][CQI_SIZES];
    int c;
    memset(size, 0, sizeof size);
    for (c = fit->first; c <= fit->last; c++)
        for (s = fit->samples->sample; s < end; s++) {
            const int32_t part = change * s->feature[c][i];
            size[0][cqi_size_of_error(s->state[c] - part)]++;
            size[1][cqi_size_of_error(s->state[c] + part)]++;
        }
    for (c = 0; c < 2; c++) cost[c] = cqi_cost_of_sizes(fit->samples, size[c], fit->last - fit->first + 1);
}

/* Makes weight i larger by `change`, or else less by that, if the errors cost less then. */
static uint32_t cqi_move_weight(const cqi_equations *fit, int8_t *weight, int i, int32_t change, uint32_t cost)
{
    cqi_sample *const end = fit->samples->sample + fit->samples->count, *s;
    uint32_t moved[2];
    int c, side = 0;
    cqi_cost_changes(fit, i, change, moved);
    if (moved[0] >= cost || cqi_abs(weight[i] + change) > 127) {
        side = 1;
        change = -change;
        if (moved[1] >= cost || cqi_abs(weight[i] + change) > 127) return cost;
    }
    weight[i] = (int8_t)(weight[i] + change);
    for (s = fit->samples->sample; s < end; s++)
        for (c = fit->first; c <= fit->last; c++) s->state[c] -= change * s->feature[c][i];
    return moved[side];
}

/* Moves the weights to and fro, by steps that get smaller. Returns about what the errors cost. */
static uint32_t cqi_move_weights(cqi_equations *fit, int8_t *weight, int first_step, int last_step)
{
    cqi_sample *const end = fit->samples->sample + fit->samples->count, *s;
    uint32_t size[CQI_SIZES] = { 0 }, cost;
    int16_t wide[CQI_MOST];
    int i, c, step;
    cqi_widen(weight, fit->n, wide);
    for (s = fit->samples->sample; s < end; s++)
        for (c = fit->first; c <= fit->last; c++) {
            s->state[c] = cqi_left_of(wide, s->feature[c], s->offset[c]);
            size[cqi_size_of_error(s->state[c])]++;
        }
    cost = cqi_cost_of_sizes(fit->samples, size, fit->last - fit->first + 1);
    for (step = first_step; step >= last_step; step /= 2)
        for (i = 0; i < fit->n; i++) cost = cqi_move_weight(fit, weight, i, step, cost);
    return cost;
}

/* Fits weights to some of the samples, beginning with the weights given. With all passes, also begins elsewhere, and
 * then moves the best weights: by large steps with some of the samples, by smaller ones with all. */
static uint32_t cqi_fit_weights(const cqi_samples *samples, int first, int last, int8_t *weight, int n, int passes)
{
    cqi_equations fit;
    cqi_samples some = *samples;
    uint32_t cost;
    int i, given = 0;
    memset(&fit, 0, sizeof fit);
    some.count = samples->some;
    fit.samples = &some;
    fit.first = first;
    fit.last = last;
    fit.n = n;
    for (i = 0; i < n; i++) given |= weight[i];
    cost = cqi_fit_from(&fit, weight, passes, 0);
    if (passes < CQI_PASSES) return cost;
    for (i = 0; i <= (given != 0); i++) {
        int8_t other[CQI_MOST] = { 0 };
        const uint32_t other_cost = cqi_fit_from(&fit, other, passes / 2, !i);
        if (other_cost >= cost) continue;
        cost = other_cost;
        memcpy(weight, other, (size_t)n);
    }
    cqi_move_weights(&fit, weight, CQI_FIRST_STEP, 2 * CQI_LATER_STEP);
    fit.samples = samples;
    return cqi_move_weights(&fit, weight, CQI_LATER_STEP, 1);
}

/* Makes component 2 of the samples what components 0 and 1 are along the edge, or across it. */
static void cqi_turn_samples(const cqi_samples *samples, int n, int across)
{
    cqi_sample *const end = samples->sample + samples->count, *s;
    for (s = samples->sample; s < end; s++) {
        const int32_t a = across ? -s->edge_y : s->edge_x, b = across ? s->edge_x : s->edge_y;
        int k;
        for (k = 0; k < n; k++)
            s->feature[2][k] = (int16_t)cqi_floor_shift(a * s->feature[0][k] + b * s->feature[1][k], 12);
        s->offset[2] = (int32_t)cqi_floor_shift_wide((int64_t)a * s->offset[0] + (int64_t)b * s->offset[1], 12);
        s->state[2] = 0;
    }
}

/* The cost of the errors in x and y, with 3 n weights. */
static uint32_t cqi_cost_of_weights(const cqi_samples *samples, const int8_t *weight, int n)
{
    const cqi_sample *const end = samples->sample + samples->count, *s;
    uint32_t size[CQI_SIZES];
    memset(size, 0, sizeof size);
    for (s = samples->sample; s < end; s++) {
        int32_t x = 16 * s->offset[0], y = 16 * s->offset[1], part = 0;
        int k;
        for (k = 0; k < n; k++) {
            x -= (int32_t)weight[k] * s->feature[0][k];
            y -= (int32_t)weight[k] * s->feature[1][k];
            part += weight[2 * n + k] *
                    cqi_floor_shift(s->edge_x * s->feature[0][k] + s->edge_y * s->feature[1][k], 12);
        }
        x -= (int32_t)cqi_floor_shift_wide((int64_t)part * s->edge_x, 12);
        y -= (int32_t)cqi_floor_shift_wide((int64_t)part * s->edge_y, 12);
        size[cqi_size_of_error(x)]++;
        size[cqi_size_of_error(y)]++;
    }
    return cqi_cost_of_sizes(samples, size, 2);
}

/* Fits all weights of n features to the samples, which stand for `count` vertices, beginning with those given. Weights
 * along the edge only differ from those across it if that saves more than the n bytes that it takes. */
static uint32_t cqi_fit_all(const cqi_samples *samples, cq_index count, int8_t *weight, int n, int passes)
{
    int8_t along[CQI_FINE], other[3 * CQI_FINE];
    uint32_t cost, other_cost, above;
    int k;
    memset(weight + 2 * n, 0, (size_t)n);
    cost = cqi_fit_weights(samples, 0, 1, weight, n, passes);
    above = cqi_fit_weights(samples, 2, 2, weight + n, n, passes);
    if (passes < CQI_PASSES) return cost + above;
    memcpy(along, weight, (size_t)n);
    memcpy(other, weight, (size_t)n);
    for (k = 0; k < 2; k++) {
        cqi_turn_samples(samples, n, k);
        cqi_fit_weights(samples, 2, 2, k ? other : along, n, passes / 2);
    }
    for (k = 0; k < n; k++) other[2 * n + k] = (int8_t)cqi_clamp(along[k] - other[k], -127, 127);
    other_cost = cqi_cost_of_weights(samples, other, n);
    if (other_cost >= cost || (uint64_t)(cost - other_cost) * count < (uint64_t)(64 * n) * samples->count)
        return cost + above;
    memcpy(weight, other, (size_t)n);
    memcpy(weight + 2 * n, other + 2 * n, (size_t)n);
    return other_cost + above;
}

/* Fills a sample: n features, and the offset in 1/16 that their weighted sum should give. */
static void cqi_set_sample(cqi_sample *s, const cqi_tilt *t, const cqi_vector *feature, int n, cqi_vector offset,
                           int shift)
{
    const int32_t most = 8191, far = 65535;
    int k;
    memset(s, 0, sizeof *s);
    for (k = 0; k < n; k++) {
        const cqi_vector f = cqi_above(t, feature[k]);
        s->feature[0][k] = (int16_t)cqi_clamp(cqi_floor_shift(f.x, shift), -most, most);
        s->feature[1][k] = (int16_t)cqi_clamp(cqi_floor_shift(f.y, shift), -most, most);
        s->feature[2][k] = (int16_t)cqi_clamp(cqi_floor_shift(f.z, shift), -most, most);
    }
    offset = cqi_above(t, offset);
    s->offset[0] = cqi_clamp(cqi_floor_shift(offset.x, shift), -far, far);
    s->offset[1] = cqi_clamp(cqi_floor_shift(offset.y, shift), -far, far);
    s->offset[2] = cqi_clamp(cqi_floor_shift(offset.z, shift), -far, far);
}

/* Fills in the direction of its edge, which only fits with all passes need. */
static void cqi_set_sample_edge(cqi_sample *s, const cqi_tilt *t)
{
    const int32_t length = (int32_t)cqi_square_root((uint64_t)(t->edge_x * t->edge_x + t->edge_y * t->edge_y)) + 1;
    s->edge_x = (int16_t)(4096 * t->edge_x / length);
    s->edge_y = (int16_t)(4096 * t->edge_y / length);
}

/* Shift of positions, by which most features are below 2^13; larger ones are clamped. */
static int cqi_fit_shift(const cq_decoder *d)
{
    return (int)d->regular.view != d->located ? 0 : cqi_at_most(cqi_bit_length(d->regular.length >> 14), 12);
}

/* Final values of a new vertex. */
static void cqi_plan_values(const cq_decoder *d, cq_index v, cq_value *to)
{
    const cq_index input = cqi_plan_mark(d->plan, d->mesh.out[v]);
    const uint32_t k = d->regular.view;
    uint32_t c;
    for (c = 0; c < d->shape.channel[k].components; c++) to[c] = (cq_value)cqi_plan_bits(d, k, c, input);
}

static cqi_vector cqi_plan_position(const cq_decoder *d, cq_index v)
{
    cq_value values[CQ_MAX_COMPONENTS];
    cqi_plan_values(d, v, values);
    return cqi_seen(d, values);
}

/* Axes as they are; no edge. */
static void cqi_set_plain(cqi_tilt *t)
{
    memset(t, 0, sizeof *t);
    t->axis[1] = 1;
    t->axis[2] = 2;
}

/* The new vertex that is sample k: one from each of `samples` equal parts of the level. */
static cq_index cqi_sampled_vertex(const cqi_regular *r, uint32_t samples, uint32_t k)
{
    const cq_index begin = (cq_index)((uint64_t)k * r->count / samples),
                   end = (cq_index)((uint64_t)(k + 1) * r->count / samples);
    return (cq_index)(r->vertices + begin + (k * 0x9e3779b9u >> 8) % (end - begin));
}

/* Samples for a level, in so many parts: half as many as vertices, or a quarter of what there is room for if that is
 * more. */
static cqi_samples cqi_take_samples(const cq_decoder *d, int parts)
{
    const uint32_t most = d->plan->most_samples / (uint32_t)parts, least = most / 4;
    const uint32_t all = d->regular.count, half = all / 2;
    cqi_samples samples;
    samples.count = half < least ? least : half < most ? half : most;
    if (samples.count > all) samples.count = all;
    samples.some = parts > 1 || samples.count <= CQI_FEW_SAMPLES ? samples.count : (samples.count + 1) / 2;
    samples.sample = d->plan->sample;
    samples.parts = parts;
    return samples;
}

/* The place of sample k. If some are enough to begin with, these come first: 0, 2, 4 .. */
static uint32_t cqi_place_of_sample(const cqi_samples *samples, uint32_t k)
{
    return samples->some == samples->count ? k : k % 2 ? samples->some + k / 2 : k / 2;
}

/* Fills sample k, a vertex in the edge of h, in all parts; t is the tilt of the first part. */
static void cqi_set_samples(const cq_decoder *d, const cqi_samples *samples, uint32_t k, cq_index h, cqi_tilt *t,
                            const cqi_vector *feature, int n, cqi_vector offset)
{
    const cqi_vector edge = cqi_from(d, cqi_at(d, d->mesh.origin[h]), cq_target(&d->mesh, h)), none = { 0, 0, 0 };
    cqi_sample *const s = samples->sample + cqi_place_of_sample(samples, k);
    int part;
    for (part = 0; part < samples->parts; part++) {
        if (part) cqi_set_tilt(t, edge, none, part);
        cqi_set_sample(s + (uint32_t)part * samples->count, t, feature, n, offset, cqi_fit_shift(d));
    }
    if (samples->parts == 1) cqi_set_sample_edge(s, t);
}

static void cqi_fixed_sample(cq_decoder *d, const cqi_samples *samples, uint32_t k)
{
    const cq_index v = cqi_sampled_vertex(&d->regular, samples->count, k), h = d->mesh.out[v], a = d->mesh.origin[h];
    const int other = (int)d->regular.view != d->located;
    cqi_vector feature[CQI_FIXED], offset;
    cqi_tilt t;
    if (other) cqi_look_around(d, a);
    cqi_set_plain(&t);
    cqi_look_ahead(d, h);
    cqi_find_fixed(d, h, feature, other ? NULL : &t);
    offset = cqi_scale(cqi_minus(cqi_plan_position(d, v), cqi_at(d, a)), 16);
    offset = cqi_minus(offset, cqi_scale(cqi_from(d, cqi_at(d, a), cq_target(&d->mesh, h)), 8));
    cqi_set_samples(d, samples, k, h, &t, feature, CQI_FIXED, offset);
}

/* Samples for the fixed prediction. */
static cqi_samples cqi_fixed_samples(cq_decoder *d, int parts)
{
    const cqi_samples samples = cqi_take_samples(d, parts);
    uint32_t k;
    for (k = 0; k < samples.count; k++) cqi_fixed_sample(d, &samples, k);
    return samples;
}

/* Some of the new vertices in the record of v, 10 at most, will be final when v has its turn. Puts their final values
 * in place of the expected ones, which are kept in `place`; or, if `back`, undoes that. */
static void cqi_exchange(cq_decoder *d, cq_index v, cq_value (*place)[CQ_MAX_COMPONENTS], int back)
{
    const uint32_t stride = d->shape.channel[d->regular.view].components;
    int k;
    for (k = 0; k < 12; k++) {
        const int i = back ? 11 - k : k;
        const cq_index slot = d->regular.slot[i / 6], f = (cq_index)(3 * slot + (cq_index)i % 3);
        const cq_index w = slot == CQ_NONE || !(i % 6) ? CQ_NONE
                           : i % 6 == 3                ? cqi_record_ahead(&d->mesh, slot)
                           : i % 6 < 3                 ? d->mesh.origin[f]
                                                       : d->mesh.twin[f];
        cq_value *to, old[CQ_MAX_COMPONENTS];
        if (w < d->regular.vertices || w >= v) continue;
        to = d->channel[d->regular.view] + stride * (size_t)w;
        if (!back) cqi_plan_values(d, w, place[i]);
        memcpy(old, to, stride * sizeof *to);
        memcpy(to, place[i], stride * sizeof *to);
        memcpy(place[i], old, stride * sizeof *to);
    }
}

/* What normals will say when v has its turn: its position is known then, if that channel comes before this one. */
static void cqi_plan_normal(cq_decoder *d, cq_index v, cqi_vector *feature)
{
    const uint32_t k = d->regular.view, located = (uint32_t)d->located;
    const int fold = d->regular.fold;
    cq_value place[12][CQ_MAX_COMPONENTS], *const to = d->channel[located] + 3 * (size_t)v, old[3];
    cqi_look_at_positions(d);
    cqi_exchange(d, v, place, 0);
    memcpy(old, to, sizeof old);
    if (located < k) cqi_plan_values(d, v, to);
    cqi_look_at(d, k, 0);
    d->regular.fold = fold;
    cqi_find_normal(d, v, v, d->mesh.out[v], 3, feature);
    cqi_look_at_positions(d);
    memcpy(to, old, sizeof old);
    cqi_exchange(d, v, place, 1);
    cqi_look_at(d, k, 0);
    d->regular.fold = fold;
}

#ifndef CQ_NO_WEDGES

/* Samples for the fine prediction of a channel per row: of each sampled vertex the first row. Even values around it
 * that will be final when it has its turn are taken as they are expected. */
static cqi_samples cqi_fine_samples_of_rows(cq_decoder *d)
{
    const cqi_samples samples = cqi_take_samples(d, 1);
    cqi_regular *r = &d->regular;
    const cq_mesh *m = &d->mesh;
    cq_index v = r->vertices;
    uint32_t k, c;
    cqi_rewind_slots(d);
    for (k = 0; k < samples.count; k++) {
        const cq_index sampled = cqi_sampled_vertex(r, samples.count, k), first = cqi_first_row(d, sampled);
        cqi_vector feature[CQI_MOST];
        cq_value values[CQ_MAX_COMPONENTS];
        cqi_tilt t;
        for (; v <= sampled; v++) cqi_take_slots(d, m->out[v]);
        cqi_look_around(d, first);
        cqi_set_plain(&t);
        cqi_find_row(d, sampled, first, m->out[sampled], cqi_sides_of_row(cqi_has_two_rows(d, sampled, first), 0),
                     feature);
        for (c = 0; c < d->shape.channel[r->view].components; c++)
            values[c] = (cq_value)cqi_plan_bits(d, r->view, c, d->plan->wedge_of_row[first]);
        cqi_set_sample(&samples.sample[k], &t, feature, cqi_num_fine(d, r->view),
                       cqi_scale(cqi_minus(cqi_seen(d, values), cqi_at(d, first)), 16), 0);
    }
    return samples;
}

#endif

/* Samples for the fine prediction. */
static cqi_samples cqi_fine_samples(cq_decoder *d, int parts)
{
    cqi_regular *r = &d->regular;
    const cq_mesh *m = &d->mesh;
    const int fine = (int)r->view != d->located ? cqi_num_fine(d, r->view) : CQI_FINE;
    cq_index v = r->vertices;
    cqi_samples samples;
    uint32_t k;
#ifndef CQ_NO_WEDGES
    if (cqi_has_row_values(d, r->view)) return cqi_fine_samples_of_rows(d);
#endif
    samples = cqi_take_samples(d, parts);
    cqi_rewind_slots(d);
    for (k = 0; k < samples.count; k++) {
        const cq_index sampled = cqi_sampled_vertex(r, samples.count, k);
        const int other = (int)r->view != d->located;
        cqi_vector feature[CQI_MOST];
        cq_value place[12][CQ_MAX_COMPONENTS];
        cqi_tilt t;
        for (; v <= sampled; v++) cqi_take_slots(d, m->out[v]);
        if (other) cqi_look_around(d, sampled);
        cqi_exchange(d, sampled, place, 0);
        cqi_set_plain(&t);
        cqi_find_fine(d, sampled, m->out[sampled], feature, other ? NULL : &t);
        cqi_exchange(d, sampled, place, 1);
        if (fine > CQI_FINE) cqi_plan_normal(d, sampled, &feature[CQI_FINE]);
        cqi_set_samples(d, &samples, k, m->out[sampled], &t, feature, fine,
                        cqi_scale(cqi_minus(cqi_plan_position(d, sampled), cqi_at(d, sampled)), 16));
    }
    return samples;
}

/* Fits a prediction's weights with these axes and all passes, beginning with those of the level before. */
static uint32_t cqi_fit_axes(cq_decoder *d, int8_t *weight, int n, int axes,
                             cqi_samples (*fill)(cq_decoder *d, int parts))
{
    cqi_samples samples;
    d->regular.axes = axes;
    samples = fill(d, 1);
    memcpy(weight, d->plan->before[n == CQI_FINE], 3 * (size_t)n);
    return cqi_fit_all(&samples, d->regular.count, weight, n, CQI_PASSES);
}

/* Chooses the axes and the weights of a prediction: the axes that are best with a part of the samples and passes; or
 * the second best, if they cost less than a 16th more there, and less with all samples. */
static CQI_APART void cqi_plan_weights(cq_decoder *d, int8_t *weight, int n,
                                       cqi_samples (*fill)(cq_decoder *d, int parts))
{
    int8_t kept[3 * CQI_FINE];
    uint32_t cost[4], other = UINT32_MAX;
    int axes, first = 0, second = -1;
    cqi_samples samples;
    d->regular.axes = 0;
    samples = fill(d, 4);
    for (axes = 0; axes < 4; axes++, samples.sample += samples.count) {
        memset(weight, 0, 3 * (size_t)n);
        cost[axes] = cqi_fit_all(&samples, d->regular.count, weight, n, CQI_PASSES / 2);
        if (cost[axes] < cost[first]) first = axes;
    }
    for (axes = 0; axes < 4; axes++)
        if (axes != first && (second < 0 || cost[axes] < cost[second])) second = axes;
    if (cost[second] - cost[first] < cost[first] / 16) {
        other = cqi_fit_axes(d, weight, n, second, fill);
        memcpy(kept, weight, 3 * (size_t)n);
    }
    if (cqi_fit_axes(d, weight, n, first, fill) > other) {
        d->regular.axes = second;
        memcpy(weight, kept, 3 * (size_t)n);
    }
    memcpy(d->plan->before[n == CQI_FINE], weight, 3 * (size_t)n);
}

/* Fits the weights of another channel. */
static void cqi_plan_others(cq_decoder *d, uint32_t k, int n, cqi_samples (*fill)(cq_decoder *d, int parts))
{
    const cqi_samples samples = fill(d, 1);
    memset(d->regular.weight[k], 0, CQI_MOST);
    cqi_fit_weights(&samples, 0, cqi_at_most((int)d->shape.channel[k].components - 1, 2), d->regular.weight[k], n,
                    CQI_PASSES);
}

/* The weights of all channels, for one of the two predictions. */
static void cqi_code_all_weights(cq_decoder *d, int8_t *weight, int n, cqi_samples (*fill)(cq_decoder *d, int parts))
{
    uint32_t k;
    if (d->located >= 0) {
        if (CQI_ENCODING(d)) cqi_plan_weights(d, weight, n, fill);
        cqi_code_weights(d, weight, n);
        cqi_charge_channel(d, (uint32_t)d->located);
    }
    for (k = 0; k < d->shape.num_channels; k++) {
        const int n_of_k = n == CQI_FIXED ? n : cqi_num_fine(d, k);
        if (!cqi_is_expected(d, k) || (n == CQI_FIXED && cqi_class(&d->shape, k) == CQI_OF_ROW)) continue;
        cqi_look_at(d, k, 0);
        if (CQI_ENCODING(d)) cqi_plan_others(d, k, n_of_k, fill);
        cqi_code_signed(d, d->regular.weight[k], n_of_k);
        cqi_charge_channel(d, k);
    }
    cqi_look_at_positions(d);
}

/* For the next new vertex: the place where it is expected. */
static cq_result cqi_step_expect(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    const cq_index v = (cq_index)(r->vertices + r->at);
    if (r->at == r->count) {
        r->at = 0;
        d->phase = CQI_DISSOLVES;
        return CQ_OK;
    }
    if (!r->at) {
        cqi_code_all_weights(d, r->fixed, CQI_FIXED, cqi_fixed_samples);
        if (cqi_starved(d)) return CQ_TRUNCATED;
    }
    cqi_look_ahead(d, d->mesh.out[v]);
    if (d->located >= 0) cqi_expect(d, v);
    cqi_expect_others(d, v);
    r->at++;
    return CQ_OK;
}

/* -- Regular levels: dissolved edges -- */

/* Class of the length of edge a - b when it is flipped to x - y, compared with its own; 4: without positions. */
static int cqi_shape_class(const cq_decoder *d, cq_index a, cq_index b, cq_index x, cq_index y)
{
    if (d->located < 0) return 4;
    return cqi_ratio_class(cqi_distance(d, x, y), cqi_distance(d, a, b), -4, 0, 4);
}

/* Class of the marks of the two faces of an edge: how many each has, and if both have one, whether these meet. */
static int cqi_marks_around(const cq_decoder *d, cq_index h, cq_index g)
{
    const int of_h = cqi_ones[cqi_marks_of(d, (cq_index)(h / 3))], of_g = cqi_ones[cqi_marks_of(d, (cq_index)(g / 3))];
    if (of_h + of_g < 3)
        return of_h + of_g < 2 ? 0
               : of_h != of_g  ? 1
                               : 2 + (cqi_has_mark(d, cq_next(h)) != cqi_has_mark(d, cq_next(g)));
    return of_h + of_g + 1;
}

/* Is the edge of h dissolved? Only asked of unmarked edges of two real faces, of which one at least has a mark, and
 * none has a dissolved edge yet. */
static void cqi_code_dissolve(cq_decoder *d, cq_index h)
{
    const cq_mesh *m = &d->mesh;
    const cq_index g = m->twin[h], f = (cq_index)(h / 3), e = (cq_index)(g / 3);
    const int marks = cqi_marks_of(d, f);
    int shape;
    if (!cqi_is_real_face(m, g) || cqi_has_mark(d, h) || !(marks | cqi_marks_of(d, e))) return;
    if (cqi_dissolved_side(d, f) || cqi_dissolved_side(d, e)) return;
    shape = cqi_shape_class(d, m->origin[h], m->origin[g], cqi_expected_tip(d, h), cqi_expected_tip(d, g));
    if (!cqi_code_bit(d, CQI_DISSOLVED + 5 * cqi_marks_around(d, h, g) + shape,
                      CQI_ENCODING(d) && cqi_plan_dissolved(d->plan, m, h)))
        return;
    CQI_TRACE(d, CQ_EVENT_DISSOLVED, m->origin[h], m->origin[g], 0);
    cqi_toggle_face_bits(d, e, cqi_ones[cqi_marks_of(d, e)] == 2 ? 1 : 1 + (int)(g % 3));
    if (cqi_ones[marks] == 1) cqi_toggle_face_bits(d, f, 1 + cqi_odd_side[marks]);
}

/* Around which of three new vertices the fan is: asked in the order of their distances from the opposite corners. */
static int cqi_code_fan(cq_decoder *d, const uint32_t *length, int fan)
{
    int order[3] = { 0, 1, 2 }, k, j;
    for (k = 1; k < 3; k++) {
        for (j = k; j && length[order[j - 1]] > length[k]; j--) order[j] = order[j - 1];
        order[j] = k;
    }
    if (cqi_code_bit(d, CQI_SHORTEST, fan == order[0])) return order[0];
    return cqi_code_bit(d, CQI_SHORTER, fan == order[1]) ? order[1] : order[2];
}

/* How a face with two or three marks is cut: into a fan around a new vertex, its hub; or with three marks, perhaps with
 * a triangle in the middle. */
static void cqi_code_pattern(cq_decoder *d, cq_index f)
{
    const cq_mesh *m = &d->mesh;
    const cq_index *const corner = m->origin + 3 * f;
    const int odd = cqi_odd_side[cqi_marks_of(d, f)];
    cq_index v[3];
    uint32_t length[3] = { 0, 0, 0 };
    int k, hub = 3, bits;
    for (k = 0; k < 3; k++) {
        v[k] = cqi_vertex_on(d, (cq_index)(3 * f + (cq_index)k));
        if (CQI_ENCODING(d) && cqi_plan_mark_says(d->plan, m, (cq_index)(3 * f + (cq_index)k), CQI_SIDE_HUB)) hub = k;
        if (d->located >= 0 && k != odd) length[k] = cqi_distance(d, v[k], corner[(k + 2) % 3]);
    }
    if (odd == 3) {
        d->regular.central = cqi_code_bit(d, CQI_CENTRAL + d->regular.central, hub == 3);
        bits = d->regular.central ? 3 : cqi_code_fan(d, length, hub);
    }
    else {
        const int a = (odd + 1) % 3, b = (odd + 2) % 3, later = v[a] < v[b]; /* b is inserted after a */
        const int first = later ? a : b, other = later ? b : a;
        const int shape = d->located < 0 ? 4 : cqi_ratio_class(length[other], length[first], -4, 0, 4);
        bits = 2 * (cqi_code_bit(d, CQI_TWO + shape, hub == other) == later);
    }
    cqi_toggle_face_bits(d, f, bits);
    CQI_TRACE(d, CQ_EVENT_PATTERN, f, cqi_hub_side(d, f), 0);
}

/* The pattern of a face; and which of the edges that it shares with later ones are dissolved. */
static cq_result cqi_step_dissolves(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    cq_index h;
    r->at = cqi_next_coarse(d, r->at);
    if (r->at == r->faces) {
        if (CQI_REPORTING(d)) cqi_charge(d, &d->report->indices, &cqi_level_report(d)->indices);
        r->at = cqi_has_expected(d) ? 0 : r->count;
        cqi_rewind_slots(d);
        d->phase = CQI_RECORDS;
        return CQ_OK;
    }
    if (cqi_ones[cqi_marks_of(d, r->at)] > 1) cqi_code_pattern(d, r->at);
    h = (cq_index)(3 * r->at++);
    for (; h < 3 * r->at; h++)
        if (d->mesh.twin[h] > h) cqi_code_dissolve(d, h);
    return cqi_starved(d) ? CQ_TRUNCATED : CQ_OK;
}

/* The record of the next new vertex; after the last one, the weights of the fine prediction. */
static cq_result cqi_step_records(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    if (r->at < r->count) return cqi_write_record(d, (cq_index)(r->vertices + r->at++)) ? CQ_OK : CQ_ERROR_CORRUPT;
    cqi_code_all_weights(d, r->fine, CQI_FINE, cqi_fine_samples);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    cqi_rewind_slots(d);
    r->at = 0;
    r->own = r->vertices;
    d->mesh.flipped_before = d->mesh.flipped_to;
    d->mesh.flipped_from = r->vertices;
    d->mesh.flipped_to = (cq_index)(r->vertices + r->count);
    d->phase = CQI_SWEEP;
    return CQ_OK;
}

/* -- Regular levels: residuals -- */

/* Class of the size of residuals: half bits of their sum; kept in the lowest four bits of the vertex's mark. */
static int cqi_size_class(uint32_t size) { return cqi_at_most(cqi_half_bits(size), 15); }

static int cqi_size_of(const cq_mesh *m, cq_index v) { return m->mark[v] & 15; }

/* The class to expect, in 1/4: a mean of the classes of final vertices around, of which neighbours count twice, and of
 * the running mean. */
static int cqi_expected_size(const cq_decoder *d, cq_index v)
{
    const cq_mesh *m = &d->mesh;
    const cq_index *const slot = d->regular.slot;
    int sum = 0, weight = 1, i, k;
    for (i = 0; i < 2 && slot[i] != CQ_NONE; i++) {
        const cq_index *const origin = m->origin + 3 * slot[i], *const twin = m->twin + 3 * slot[i];
        for (k = 1; k < 3; k++) {
            if (origin[k] < v) {
                sum += 2 * cqi_size_of(m, origin[k]);
                weight += 2;
            }
            if (twin[k] >= d->regular.vertices && twin[k] < v) {
                sum += cqi_size_of(m, twin[k]);
                weight++;
            }
        }
    }
    return (int)((uint32_t)(64 * sum) + d->regular.size) / (16 * weight);
}

/* An offset by its residual; the prediction is in 1/256. */
static int32_t cqi_code_offset(cq_decoder *d, int kind, int size, int64_t predicted, int32_t value)
{
    const int32_t p = cqi_rounded(predicted);
    const int fraction = (int)cqi_floor_shift_wide(predicted + 128, 6) & 3, row = (size + 2) / 4;
    const int expected = row < 4 ? 0 : (row - 3) / 2;
    return p + cqi_code_residual(d, kind, cqi_at_most(row, CQI_EXPECTED - 1), expected, 26, fraction, value - p);
}

/* Codes the position of v in edge h. 0 if what was decoded is no position. */
static int cqi_code_new_position(cq_decoder *d, cq_index v, cq_index h, cq_index input)
{
    const cq_channel *const channel = &d->shape.channel[d->located];
    cq_value *const to = d->channel[d->located] + 3 * (size_t)v;
    int32_t value[3] = { 0, 0, 0 }, x[3], size[3];
    cqi_vector feature[CQI_FINE];
    cqi_tilt t;
    int64_t sum[3];
    int expected, c;
    expected = cqi_expected_size(d, v);
    cqi_find_fine(d, v, h, feature, &t);
    cqi_weigh(&t, feature, d->regular.fine, CQI_FINE, sum);
    for (c = 0; c < 3; c++) {
        if (CQI_ENCODING(d))
            value[c] = cqi_plan_value(d, (uint32_t)d->located, (uint32_t)t.axis[c], input) - to[t.axis[c]];
    }
    x[0] = cqi_code_offset(d, CQI_NEW_ALONG, expected, sum[0], value[0]);
    size[0] = (int32_t)cqi_abs(x[0] - cqi_rounded(sum[0]));
    x[1] = cqi_code_offset(d, CQI_NEW_ALONG, (3 * expected + 4 * cqi_size_class((uint32_t)size[0] * 3)) / 4, sum[1],
                           value[1]);
    size[1] = (int32_t)cqi_abs(x[1] - cqi_rounded(sum[1]));
    sum[2] += (int64_t)t.slope_x * x[0] + (int64_t)t.slope_y * x[1];
    x[2] = cqi_code_offset(d, CQI_NEW_ABOVE,
                           (3 * expected + 4 * cqi_size_class((uint32_t)(size[0] + size[1]) * 3 / 2)) / 4, sum[2],
                           value[2]);
    size[2] = (int32_t)cqi_abs(x[2] - cqi_rounded(sum[2]));
    for (c = 0; c < 3; c++) {
        const int32_t p = to[t.axis[c]] + x[c];
        if (!cqi_value_fits(channel, p)) return 0;
        to[t.axis[c]] = (cq_value)p;
    }
    c = cqi_size_class((uint32_t)(size[0] + size[1] + size[2]));
    d->mesh.mark[v] = (uint8_t)(d->mesh.mark[v] | c);
    d->regular.size = d->regular.size - (d->regular.size >> 5) + 2 * (uint32_t)c;
    return 1;
}

/* A residual of another channel, by the sizes of its residuals at other vertices, and of the component before. */
static int32_t cqi_code_other_residual(cq_decoder *d, uint32_t k, int *size, int32_t residual)
{
    const cq_channel *const channel = &d->shape.channel[k];
    const int row = (*size + 32) / 64, expected = row < 4 ? 0 : row / 2;
    residual = cqi_code_residual(d, CQI_PLAIN, cqi_at_most(row, CQI_EXPECTED - 1), expected, cqi_most_bits(channel), -1,
                                 residual);
    *size = 64 * cqi_half_bits(cqi_abs(residual));
    d->regular.size_of[k] = (uint16_t)(d->regular.size_of[k] + (*size - (int)d->regular.size_of[k]) / 32);
    return residual;
}

/* Codes three components of a channel of v, or of one of its rows, which the encoder knows as `input`. */
static int cqi_code_other_part(cq_decoder *d, cq_index v, cq_index number, const cqi_vector *feature, cq_index input)
{
    const uint32_t k = d->regular.view, part = d->regular.part;
    const cq_channel *const channel = &d->shape.channel[k];
    cq_value *const to = d->channel[k] + channel->components * (size_t)number;
    int size = d->regular.size_of[k];
    cqi_vector x;
    uint32_t c;
    if (d->located >= 0 && d->located < (int)k) size += (64 * cqi_size_of(&d->mesh, v) - (int)d->regular.size) / 4;
    if (size < 0) size = 0;
    x = cqi_unseen(d, cqi_sum_features(cqi_at(d, number), feature, d->regular.weight[k], cqi_num_fine(d, k)));
    for (c = part; c < part + 3 && c < channel->components; c++) {
        const int32_t p = cqi_unrough(channel, cqi_component(x, (int)(c - part)));
        const int32_t residual = CQI_ENCODING(d) ? cqi_difference(cqi_plan_value(d, k, c, input), p) : 0;
        if (!cqi_store_value(channel, p, cqi_code_other_residual(d, k, &size, residual), to + c)) return 0;
        size = (size + (int)d->regular.size_of[k]) / 2;
    }
    return 1;
}

/* Channel k of v in edge h, if it is predicted as positions are. */
static int cqi_code_other(cq_decoder *d, uint32_t k, cq_index v, cq_index h, cq_index input)
{
    cqi_vector feature[CQI_MOST];
    uint32_t part;
    for (part = 0; part < d->shape.channel[k].components; part += 3) {
        cqi_look_at(d, k, part);
        cqi_look_around(d, v);
        cqi_find_fine(d, v, h, feature, NULL);
        if (cqi_has_normals(d, k)) cqi_find_normal(d, v, v, h, 3, &feature[CQI_FINE]);
        if (!cqi_code_other_part(d, v, v, feature, input)) return 0;
    }
    return 1;
}

#ifdef CQ_NO_WEDGES
#define cqi_has_row_values(d, k) 0
#define cqi_code_rows_of_channel(d, k, v, h) 1
#else

/* Channel k of the rows of v. */
static int cqi_code_rows_of_channel(cq_decoder *d, uint32_t k, cq_index v, cq_index h)
{
    const cq_channel *const channel = &d->shape.channel[k];
    const cq_index g = d->mesh.twin[h], first = d->num_rows;
    const int two = cqi_has_two_rows(d, v, first);
    cqi_vector feature[CQI_MOST];
    uint32_t part;
    int i;
    for (i = 0; i < 1 + two; i++) {
        const cq_index row = (cq_index)(first + (cq_index)i), wedge = CQI_ENCODING(d) ? d->plan->wedge_of_row[row] : 0;
        if (channel->merge == CQ_COPY) {
            d->now.fan.vertex[0] = i ? d->index[cq_next(g)] : d->index[h];
            d->now.fan.vertex[1] = i ? d->index[g] : d->index[cq_next(h)];
            for (part = 0; part < channel->components; part++)
                cqi_code_copied(d, k, part, wedge, d->channel[k] + channel->components * (size_t)row + part);
            CQI_TRACE(d, CQ_EVENT_VALUES, k, row, 0);
            continue;
        }
        for (part = 0; part < channel->components; part += 3) {
            cqi_look_at(d, k, part);
            cqi_look_around(d, row);
            cqi_find_row(d, v, row, h, cqi_sides_of_row(two, i), feature);
            if (!cqi_code_other_part(d, v, row, feature, wedge)) return 0;
        }
        CQI_TRACE(d, CQ_EVENT_VALUES, k, row, 0);
    }
    return 1;
}

#endif

/* Makes the two ends of an edge the fan, for channels that are coded as in levels of patches. */
static void cqi_list_ends(cq_decoder *d, cq_index h)
{
    cqi_fan *const f = &d->now.fan;
    f->size = 2;
    f->boundary = 1;
    f->vertex[0] = d->mesh.origin[h];
    f->vertex[1] = cq_target(&d->mesh, h);
    f->beyond[0] = f->beyond[1] = CQ_NONE;
    memset(f->at, 0, 2 * sizeof *f->at); /* no fit */
    f->faces = 0;
}

/* All channels of v in edge h. */
static int cqi_code_new_values(cq_decoder *d, cq_index v, cq_index h, cq_index input)
{
    uint32_t k;
    int ok = 1;
    for (k = 0; k < d->shape.num_channels && ok; k++) {
        if (cqi_class(&d->shape, k) == CQI_OF_FACE) continue;
        cqi_list_ends(d, h);
        if ((int)k == d->located) ok = cqi_code_new_position(d, v, h, input);
        else if (cqi_has_row_values(d, k)) ok = cqi_code_rows_of_channel(d, k, v, h);
        else ok = cqi_is_expected(d, k) ? cqi_code_other(d, k, v, h, input) : cqi_code_by_fan(d, k, v, input);
        CQI_TRACE_IF(ok && !cqi_has_row_values(d, k), d, CQ_EVENT_VALUES, k, v, 0);
        cqi_look_at_positions(d);
        cqi_charge_channel(d, k);
    }
    return ok;
}

/* -- Regular levels: insertions and flips -- */

/* The coarse halfedge that was in slot h, as long as its edge has no new vertex. An insertion into another edge of its
 * face, at the end that they share, may have put another halfedge there: one that joins its other end to the new
 * vertex.
 *
 *          x                x
 *        /   \            / | \         v is inserted into a -> b. The slot of x -> a now has x -> v, and x -> a is the
 *       a-----b          a--v--b        next one clockwise around x; on the other side of a -> b, counter-clockwise.
 *
 * The later of two insertions is undone first.
 *
 * No flip touches a face before its turn, see cqi_code_flips. So when this is asked, only vertices on the other two
 * edges of the face are new in it: these are two steps at most. */
static cq_index cqi_current_edge(const cq_decoder *d, cq_index h)
{
    const cq_mesh *m = &d->mesh;
    for (;;) {
        const cq_index from = m->origin[h], to = cq_target(m, h);
        if (from < d->regular.vertices && to < d->regular.vertices) return h;
        h = to > from ? cq_clockwise(m, h) : cq_prev(m->twin[h]);
    }
}

#ifdef CQ_NO_WEDGES
#define cqi_split_index(d, v, h) ((void)0)
#define cqi_flip_index(m, index, h) 1
#else

/* Sets the rows of the corners that the insertion of v into the edge h makes. */
static void cqi_split_index(cq_decoder *d, cq_index v, cq_index h)
{
    const cq_index g = cq_next(d->mesh.twin[h]), *const slot = d->regular.slot;
    const int two = cqi_has_two_rows(d, v, d->num_rows);
    const cq_index left = d->num_rows, right = (cq_index)(left + (cq_index)two);
    cqi_set_face_rows(d->index + 3 * slot[0], d->index[cq_prev(h)], d->index[h], left);
    d->index[h] = left;
    if (slot[1] != CQ_NONE) {
        cqi_set_face_rows(d->index + 3 * slot[1], d->index[g], d->index[cq_next(g)], right);
        d->index[g] = right;
    }
    d->num_rows = (cq_index)(right + 1);
}

/* Changes the rows for the flip of an edge, which must not be a seam; before the mesh is changed. */
static int cqi_flip_index(const cq_mesh *m, cq_index *index, cq_index h)
{
    const cq_index g = m->twin[h], hn = cq_next(h), hp = cq_prev(h), gn = cq_next(g), gp = cq_prev(g);
    const cq_index a = index[h], b = index[g], x = index[hp], y = index[gp];
    if (index[gn] != a || index[hn] != b) return 0;
    index[h] = index[gn] = y;
    index[g] = index[hn] = x;
    index[hp] = a;
    index[gp] = b;
    return 1;
}

#endif

/* Gives the new faces the values of the faces that they are cut off from. */
static void cqi_copy_faces(cq_decoder *d, cq_index h, cq_index g)
{
    const cq_index from[2] = { (cq_index)(h / 3), (cq_index)(g / 3) }, *const slot = d->regular.slot;
    uint32_t k;
    int i;
    for (k = 0; k < d->shape.num_channels; k++) {
        if (cqi_class(&d->shape, k) != CQI_OF_FACE) continue;
        for (i = 0; i < 2; i++)
            if (slot[i] != CQ_NONE) d->channel[k][slot[i]] = d->channel[k][from[i]];
    }
}

/* Inserts the next new vertex into its edge, by a split of the edge's start. Not possible where two faces share all
 * three edges: the new vertex would be joined to their third corner twice. */
static cq_result cqi_code_insertion(cq_decoder *d)
{
    cq_mesh *m = &d->mesh;
    const cq_index v = m->num_vertices, slot = m->out[v], h = cqi_current_edge(d, slot);
    const cq_index input = CQI_ENCODING(d) ? cqi_plan_mark(d->plan, slot) : 0;
    const cq_index g = m->twin[h];
    int ok;
    if (m->valence[m->origin[h]] == 2 || !cqi_take_slots(d, h)) return CQ_ERROR_CORRUPT;
    CQI_TRACE(d, CQ_EVENT_INSERTION, v, m->origin[h], m->origin[g]);
    ok = cqi_code_new_values(d, v, h, input);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (!ok) return CQ_ERROR_CORRUPT;
    if (CQI_HAS_ATTRIBUTES) cqi_copy_faces(d, h, g);
    d->new_face[0] = d->regular.slot[0];
    d->new_face[1] = d->regular.slot[1];
    if (d->materials) cqi_take_new_faces(d);
    if (!cqi_has_room(m, m->origin[cq_prev(h)], m->origin[cq_prev(g)])) return CQ_ERROR_CORRUPT;
    if (d->seams) cqi_split_index(d, v, h);
    if (cq_mesh_split(m, cq_counterclockwise(m, h), cq_clockwise(m, h)) == CQ_NONE) /* unreachable: there is room */
        return CQ_ERROR_CORRUPT; /* unreachable: there is room */
    if (d->materials) cqi_count_new_faces(d, 1);
    d->regular.side[v - d->regular.own] = (uint8_t)(slot % 3);
    if (CQI_ENCODING(d)) cqi_plan_vertex(d->plan, input, v);
    return CQ_OK;
}

static cq_result cqi_flip_checked(cq_decoder *d, cq_index h)
{
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (!cqi_can_flip(&d->mesh, h)) return CQ_ERROR_CORRUPT;
    if (d->seams && !cqi_flip_index(&d->mesh, d->index, h)) return CQ_ERROR_CORRUPT;
    CQI_TRACE(d, CQ_EVENT_FLIP, d->mesh.origin[h], cq_target(&d->mesh, h), 0);
    cqi_flip(&d->mesh, h);
    return CQ_OK;
}

/* The side of the face at hand that a new vertex is on. */
static int cqi_side_here(const cq_decoder *d, cq_index v)
{
    return v < d->regular.own ? d->mesh.mark[v] >> 4 & 3 : d->regular.side[v - d->regular.own];
}

/* The spoke from the first hub of face f to the corner opposite to its side, before any flip. Each triangle of the face
 * has this hub as a corner, and at most one other new vertex. Counter-clockwise, the hub's spokes in the face go to:
 * the end of its side, the new vertex of the next side, the opposite corner, the new vertex of the previous side, the
 * start of its side. */
static cq_index cqi_find_hub(const cq_decoder *d, cq_index f, int marks)
{
    const cq_mesh *m = &d->mesh;
    const cq_index old = d->regular.vertices;
    cq_index h = CQ_NONE, k, p, q;
    int next;
    for (k = (cq_index)(3 * f); k < 3 * f + 3; k++)
        if (m->origin[k] >= old && (h == CQ_NONE || m->origin[k] < m->origin[h])) h = k;
    next = (cqi_side_here(d, m->origin[h]) + 1) % 3;
    p = cq_target(m, h);
    q = m->origin[cq_prev(h)];
    if (p >= old) return cqi_side_here(d, p) == next ? cq_counterclockwise(m, h) : cq_clockwise(m, h);
    return q < old && !(marks >> next & 1) ? cq_counterclockwise(m, h) : h;
}

/* Makes the pattern of a face out of the fan around the vertex that was inserted first, of which `spoke` goes to the
 * opposite corner. */
static cq_result cqi_make_pattern(cq_decoder *d, cq_index f, cq_index spoke, int marks)
{
    const int first = cqi_side_here(d, d->mesh.origin[spoke]), hub = cqi_hub_side(d, f);
    cq_result result;
    if (hub == first) return CQ_OK;
    result = cqi_flip_checked(d, spoke);
    if (result != CQ_OK || marks != 7 || hub == 3) return result;
    return cqi_flip_checked(d, hub == (first + 1) % 3 ? cq_next(spoke) : cq_prev(spoke));
}

/* The edge inside of a face with one mark, from its new vertex to the opposite corner, as a halfedge of the triangle
 * beyond it. h is a halfedge of another edge of the face, one that is dissolved. CQ_NONE: the face of h does not have
 * exactly one mark.
 *
 * One of the two triangles of such a face is in the face's own slot, the other one in a new slot. If h is in the new
 * one, the own slot is beyond one of the other two sides of h's triangle. Another face with one mark, beyond one of
 * these sides, might be taken for it; but that has its marked side there, and the own slot does not. All this only
 * holds while the face is as its insertion has left it: so its bits are cleared when it is found, and it is not found
 * again. */
static cq_index cqi_take_inside(cq_decoder *d, cq_index h)
{
    const cq_mesh *m = &d->mesh;
    const cq_index side[3] = { h, m->twin[cq_next(h)], m->twin[cq_prev(h)] };
    int k;
    if (m->origin[cq_prev(h)] < d->regular.vertices) return CQ_NONE;
    for (k = 0; k < 3; k++) {
        const cq_index f = (cq_index)(side[k] / 3);
        const int marks = f < d->regular.faces ? cqi_marks_of(d, f) : 0;
        const int marked = cqi_odd_side[marks], at = (int)(side[k] % 3);
        if (cqi_ones[marks] != 1 || marked == at || !cqi_face_bits(d, f)) continue;
        cqi_toggle_face_bits(d, f, cqi_face_bits(d, f));
        return k ? side[k] : m->twin[3 * f + (cq_index)(3 - marked - at)];
    }
    return CQ_NONE;
}

/* Is h, the edge inside of a face, flipped after the face's dissolved edge? It then joins the vertex beyond that edge
 * to the one beyond h, and may only be flipped if the former is new. */
static int cqi_code_second_flip(cq_decoder *d, cq_index h, cq_index beyond)
{
    const cq_mesh *m = &d->mesh;
    const cq_index g = m->twin[h];
    const cq_index spoke = m->origin[h] < d->regular.vertices ? g : h;
    if (beyond < d->regular.vertices) return 0;
    return cqi_code_bit(d,
                        CQI_SECOND_FLIP + cqi_shape_class(d, m->origin[h], m->origin[g], m->origin[cq_prev(h)], beyond),
                        CQI_ENCODING(d) && cqi_plan_second(d->plan, m, spoke));
}

/* Flips a dissolved edge; then, if that is coded, the edges inside of those of its two faces that have one mark. */
static cq_result cqi_step_dissolved(cq_decoder *d)
{
    const cq_mesh *m = &d->mesh;
    const cq_index h = d->regular.dissolved, g = m->twin[h], tip[2] = { m->origin[cq_prev(h)], m->origin[cq_prev(g)] };
    const cq_index inside[2] = { cqi_take_inside(d, h), cqi_take_inside(d, g) };
    int flip[2] = { 0, 0 }, k;
    cq_result result;
    d->regular.dissolved = CQ_NONE;
    for (k = 0; k < 2; k++)
        if (inside[k] != CQ_NONE) flip[k] = cqi_code_second_flip(d, inside[k], tip[1 - k]);
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->indices, &cqi_level_report(d)->indices);
    result = cqi_flip_checked(d, h);
    for (k = 0; k < 2; k++)
        if (flip[k] && result == CQ_OK) result = cqi_flip_checked(d, inside[k]);
    return result;
}

/* The flips inside of a face, once all its new vertices are there. None of them moves its dissolved edge, which is
 * flipped in the next step; and all stay within the face, or in the two faces of the dissolved edge, which both have
 * had their turn. */
static cq_result cqi_code_flips(cq_decoder *d, cq_index f)
{
    const int marks = cqi_marks_of(d, f), side = cqi_dissolved_side(d, f);
    cq_result result = CQ_OK;
    if (side && !(marks >> (side - 1) & 1))
        d->regular.dissolved = d->mesh.twin[cqi_current_edge(d, (cq_index)(3 * f + (cq_index)side - 1))];
    if (cqi_ones[marks] > 1) result = cqi_make_pattern(d, f, cqi_find_hub(d, f, marks), marks);
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->indices, &cqi_level_report(d)->indices);
    return result;
}

/* A guess of what n vertices take without regular levels, in 1/16 bit, if m of them take `mean` each: with positions,
 * each takes 3.5 bits less for each doubling of their number. */
static int64_t cqi_guess_size(uint32_t n, uint32_t m, int64_t mean, int located)
{
    return n * (mean - (located ? (56 * ((int64_t)cqi_log2(n) - cqi_log2(m))) / 65536 : 0));
}

/* The number of vertices after regular level k, 1 being the finest one. */
static uint32_t cqi_vertices_after(const cqi_plan *p, uint32_t k, uint32_t num_vertices)
{
    while (--k) num_vertices -= p->count_of[k];
    return num_vertices;
}

/* cqi_guess_size of the vertices after level k, judged by those before all regular levels. `bytes`: of the stream so
 * far, which may not have the finest levels yet. */
static int64_t cqi_guess_after(const cqi_plan *p, size_t bytes, uint32_t num_vertices, uint32_t k, int located)
{
    uint32_t rest = cqi_vertices_after(p, p->num_regular + 1, num_vertices), j;
    for (j = 1; j <= p->num_regular; j++) bytes -= p->bytes_of[j];
    rest += !rest;
    return cqi_guess_size(cqi_vertices_after(p, k, num_vertices), rest, (int64_t)((uint64_t)bytes * 128 / rest), located);
}

/* Do the vertices of level k take less than they would without it, or are those before all regular levels too few to
 * tell? */
static int cqi_pays(const cqi_plan *p, uint32_t k, size_t bytes, uint32_t num_vertices, int located)
{
    if (cqi_vertices_after(p, k, num_vertices) / 16 > cqi_vertices_after(p, p->num_regular + 1, num_vertices)) return 1;
    return (int64_t)((uint64_t)p->bytes_of[k] * 128) < cqi_guess_after(p, bytes, num_vertices, k, located) -
                                                           cqi_guess_after(p, bytes, num_vertices, k + 1, located);
}

/* Moves on to the plan of a regular level that begins; at its end, notes the bytes that it has taken. */
static void cqi_plan_level(cqi_plan *p, const cq_mesh *m, int end)
{
    cq_index first = 0, count = 0;
    const uint32_t bytes = cqi_plan_bytes(p);
    p->bytes_of[p->level] = bytes - (end ? p->bytes_of[p->level] : 0);
    if (end) return;
    while (p->note[first].level != p->level) first++;
    while (p->note[first + count].level == p->level) count++;
    cqi_plan_regular(p, m, first, count);
}

static cq_result cqi_end_regular(cq_decoder *d)
{
    d->mesh.is_partial = 0;
    if (CQI_ENCODING(d)) {
        cqi_plan *const p = d->plan;
        cqi_plan_level(p, &d->mesh, 1);
        if (p->level > 1 && p->most_regular == CQI_MAX_REGULAR &&
            !cqi_pays(p, p->level, p->range.count, d->shape.num_vertices, d->shape.num_channels > 0)) {
            p->rejected = p->level;
            return CQ_ERROR_CORRUPT;
        }
    }
    if (CQI_REPORTING(d)) {
        cq_level *level = cqi_level_report(d);
        d->report->num_levels = d->level;
        level->num_splits = d->regular.count;
        level->num_vertices = (uint32_t)d->mesh.num_vertices;
    }
    d->phase = CQI_LEVEL;
    return CQ_OK;
}

/* Inserts the next new vertex of the face at hand; or does its flips, and moves on to the next face. */
static cq_result cqi_step_sweep(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    const cq_index v = d->mesh.num_vertices;
    cq_result result;
    if (r->dissolved != CQ_NONE) return cqi_step_dissolved(d);
    r->at = cqi_next_coarse(d, r->at);
    if (r->at == r->faces) return cqi_end_regular(d);
    if (v < r->vertices + r->count && d->mesh.out[v] / 3 == r->at) return cqi_code_insertion(d);
    result = cqi_code_flips(d, r->at);
    r->at++;
    r->own = v;
    return result;
}

/* Clears the bits of the coarse faces. */
static cq_result cqi_step_wipe(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    uint8_t *const bits = (uint8_t *)d->walk.queue;
    const cq_index n = (cq_index)((5 * (size_t)r->faces + 7) / 8);
    int k;
    for (k = 0; k < CQI_AT_ONCE && r->at < n; k++) bits[r->at++] = 0;
    if (r->at < n) return CQ_OK;
    r->at = 0;
    d->phase = CQI_MARKS;
    return CQ_OK;
}

static cq_result cqi_begin_regular(cq_decoder *d)
{
    cqi_regular *r = &d->regular;
    uint32_t k;
    memset(r, 0, sizeof *r);
    r->vertices = d->mesh.num_vertices;
    r->faces = d->mesh.num_faces;
    r->real_faces = cqi_num_faces(d);
    r->first_row = d->num_rows;
    for (k = 0; d->materials && k < d->shape.num_materials; k++)
        d->materials[k].scan = (cq_index)(d->materials[k].first + d->materials[k].count);
    d->mesh.is_partial = d->materials != NULL;
    r->central = 2;
    r->dissolved = CQ_NONE;
    cqi_look_at_positions(d);
    if (CQI_ENCODING(d)) cqi_plan_level(d->plan, &d->mesh, 0);
    if (CQI_REPORTING(d)) cqi_level_report(d)->regular = 1;
    d->phase = CQI_WIPE;
    return CQ_OK;
}

#endif /* CQ_NO_REGULAR */

/* -- Steps ---------------------------------------------------------------------------------------------------------
 *
 * A call of cqi_step is one step of a caller's budget. It codes what it needs, then applies it; d->phase says what the
 * next one does. If bytes are missing, it returns CQ_TRUNCATED and applies nothing. */

/* The faces of a component are complete: codes whether another one follows, and moves on to the values of this one. */
static cq_result cqi_end_component(cq_decoder *d)
{
    d->base.more = cqi_code_bit(d, CQI_COMPONENT, CQI_ENCODING(d) && d->plan->next_seed < d->plan->num_seeds);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->base, NULL);
    d->base.value = 0;
    d->phase = CQI_BASE_VALUES;
    CQI_TRACE(d, CQ_EVENT_COMPONENT, d->base.draft.num_vertices, d->base.faces, d->base.more);
    return cqi_finish_component(d);
}

static CQI_APART cq_result cqi_step_base(cq_decoder *d)
{
    if (d->mesh.num_vertices == d->base.draft.num_vertices) return cqi_start_component(d);
    if (!cqi_is_open(&d->base.draft, d->base.gate) && !cqi_find_gate(d)) return cqi_end_component(d);
    return cqi_grow_base(d);
}

/* -- Rows of the base, and what is aside --
 *
 * Vertex by vertex: first the row of each corner around it, then the values of the rows that are new there. */

static cq_result cqi_step_base_values(cq_decoder *d);

#ifndef CQ_NO_WEDGES

/* To begin with, what is usual has a probability of 9/10. */
static void cqi_init_seams(cqi_seams *s)
{
    int j, k;
    memset(s, 0, sizeof *s);
    for (j = 0; j < CQI_SEAM_CONTEXTS; j++)
        for (k = 0; k < CQI_SEAM_MODELS; k++) s->model[j][k] = k < CQI_SECOND_CHOICE ? 59000u : CQ_BIT_MODEL_INIT;
    for (j = 0; j < CQ_MAX_CHANNELS; j++) {
        for (k = 0; k < CQI_EQUALS; k++) s->equal[j][k] = CQ_BIT_MODEL_INIT;
    }
    memset(s->length, 0, sizeof s->length);
    for (j = 0; j < CQI_ROW_SETS * CQI_ROW_CLASSES * CQI_ROW_LENGTHS; j++)
        (&s->length[0][0][0])[j].bit = CQ_BIT_MODEL_INIT;
}

/* Lays out what only a mesh with seams, metadata, materials or things aside has. */
static void cqi_start_rows(cq_decoder *d, cqi_arena *arena)
{
    const cq_shape *s = &d->shape;
    const size_t of_row = cqi_all_components(s, CQI_OF_ROW), all = of_row + cqi_all_components(s, CQI_OF_VERTEX);
    cq_value *values, *aside;
    uint32_t k;
    if (s->num_rows) {
        d->index = (cq_index *)cqi_take(arena, 3 * (size_t)s->num_faces, sizeof(cq_index));
        d->vertex = (cq_index *)cqi_take(arena, s->num_rows, sizeof(cq_index));
        d->seams = (cqi_seams *)cqi_take(arena, 1, sizeof(cqi_seams));
        cqi_init_seams(d->seams);
    }
    values = (cq_value *)cqi_take(arena, s->num_rows * of_row, sizeof(cq_value));
    if (s->metadata_bytes) {
        d->metadata_model = (cq_bit_model *)cqi_take(arena, 256, sizeof(cq_bit_model));
        d->metadata = (uint8_t *)cqi_take(arena, s->metadata_bytes, 1);
        for (k = 0; k < 256; k++) d->metadata_model[k] = CQ_BIT_MODEL_INIT;
    }
    if (s->num_materials) {
        d->materials = (cqi_material *)cqi_take(arena, s->num_materials, sizeof(cqi_material));
        memset(d->materials, 0, s->num_materials * sizeof(cqi_material));
        d->aside.material = (cq_index *)cqi_take(arena, s->num_aside_faces, sizeof(cq_index));
        d->phase = CQI_MATERIALS;
    }
    d->aside.index = (cq_index *)cqi_take(arena, 3 * (size_t)s->num_aside_faces, sizeof(cq_index));
    aside = (cq_value *)cqi_take(arena, s->num_aside_rows * all, sizeof(cq_value));
    for (k = 0; k < s->num_channels; k++) {
        const int of = cqi_class(s, k);
        if (of == CQI_OF_FACE) {
            d->aside.channel[k] = (cq_value *)cqi_take(arena, s->num_aside_faces, sizeof(cq_value));
            continue;
        }
        d->aside.channel[k] = aside;
        aside += (size_t)s->num_aside_rows * s->channel[k].components;
        if (of != CQI_OF_ROW) continue;
        d->channel[k] = values;
        values += (size_t)s->num_rows * s->channel[k].components;
    }
}

static cq_result cqi_begin_base_rows(cq_decoder *d)
{
    d->seams->vertex = d->mesh.num_vertices;
    d->seams->corner = d->base.draft.out[d->mesh.num_vertices];
    d->phase = CQI_BASE_ROWS;
    return CQ_OK;
}

/* The row of the next corner, clockwise around a base vertex: that of the corner before; or a new one; or another one
 * of the vertex, by its number. */
static int cqi_code_base_corner(cq_decoder *d)
{
    const cq_mesh *m = &d->base.draft;
    cqi_seams *s = d->seams;
    const cq_index h = s->corner, known = (cq_index)(s->num_rows - s->first);
    const cq_index before = h == m->out[s->vertex] ? CQ_NONE : cqi_row_at(d, cq_counterclockwise(m, h));
    const cq_index others = (cq_index)(known - (before != CQ_NONE)),
                   wedge = CQI_ENCODING(d) ? d->plan->index[cqi_plan_to_input(d->plan, h)] : 0;
    const int rows = cqi_at_most((int)(known < 3 ? known : 3), 3) - 1;
    cq_index row = CQI_ENCODING(d) ? d->plan->row_decoded[wedge] : CQ_NONE;
    if (before != CQ_NONE && cqi_code_with(d, &s->model[0][CQI_BASE_SAME + rows], row == before)) {
        d->index[h] = before;
        return 1;
    }
    if (!others || cqi_code_with(d, &s->model[0][CQI_BASE_NEW + rows], row == CQ_NONE)) {
        d->index[h] = cqi_add_row(d, s->vertex, wedge);
        return !s->full;
    }
    row = (cq_index)(row - s->first - (before != CQ_NONE && row > before));
    row = (cq_index)cqi_code_raw(d, row, cqi_bit_length((uint32_t)others - 1));
    if (row >= others) return 0;
    row = (cq_index)(row + s->first);
    d->index[h] = (cq_index)(row + (before != CQ_NONE && row >= before));
    return 1;
}

/* What predicts the values of a base row: at most CQI_BASE_FACES of its faces. */
#define CQI_BASE_FACES 16
typedef struct cqi_base_row {
    cq_index known[2 * CQI_BASE_FACES];       /* rows of its faces' other corners, of vertices with lower numbers */
    int num_known;
    cqi_vector64 normal;                     /* sum of the normals of its faces */
} cqi_base_row;

static void cqi_add_known(cqi_base_row *b, cq_index row)
{
    int k = 0;
    while (k < b->num_known && b->known[k] != row) k++;
    if (k == b->num_known) b->known[b->num_known++] = row;
}

/* Adds what the face of halfedge h tells, at whose origin the row is. */
static void cqi_look_at_face(const cq_decoder *d, cq_index h, cqi_base_row *b)
{
    const cq_mesh *m = &d->base.draft;
    const cq_index v = m->origin[h], u = m->origin[cq_next(h)], w = m->origin[cq_prev(h)];
    if (u < v) cqi_add_known(b, d->index[cq_next(h)]);
    if (w < v) cqi_add_known(b, d->index[cq_prev(h)]);
    if (d->located >= 0) {
        const cq_value *const at = d->channel[d->located];
        cqi_add_normal(&b->normal, cqi_offset(at, v, u), cqi_offset(at, v, w));
    }
}

/* Finds what predicts a row. New rows are numbered in the order of their first corners, so that all searches for these
 * together go around the vertex once. Only corners of the row that adjoin the first one without a gap count. */
static void cqi_look_around_row(cq_decoder *d, cq_index row, cqi_base_row *b)
{
    const cq_mesh *m = &d->base.draft;
    cq_index h, before, end;
    int k;
    while (cqi_row_at(d, d->seams->corner) != row) d->seams->corner = cq_clockwise(m, d->seams->corner);
    h = end = d->seams->corner;
    for (k = 1; k < CQI_BASE_FACES; k++) {
        before = cq_counterclockwise(m, h);
        if (before == end || cqi_row_at(d, before) != row) break;
        h = before;
    }
    end = h;
    b->num_known = 0;
    b->normal.x = b->normal.y = b->normal.z = 0;
    for (k = 0; k < CQI_BASE_FACES && cqi_row_at(d, h) == row && (k == 0 || h != end); k++) {
        cqi_look_at_face(d, h, b);
        h = cq_clockwise(m, h);
    }
}

/* The mean of the known rows around; if there are none, the value of the row before. */
static int32_t cqi_predict_base_row(const cq_decoder *d, uint32_t k, uint32_t c, cq_index row, const cqi_base_row *b)
{
    const cq_channel *channel = &d->shape.channel[k];
    const size_t stride = channel->components;
    const cq_value *const values = d->channel[k] + c;
    int32_t sum = 0;
    int j;
    if (!b->num_known && row) return cqi_number(channel, values[(row - 1) * stride]);
    if (!b->num_known) return cqi_is_exact(channel) ? 0 : (int32_t)1 << (channel->bits - 1);
    if (b->num_known == 1) return cqi_number(channel, values[b->known[0] * stride]);
    for (j = 0; j < b->num_known; j++) sum += cqi_rough(channel, values[b->known[j] * stride]);
    return cqi_unrough(channel, sum / b->num_known);
}

/* Channel k of a new row of the base. */
static int cqi_code_base_row(cq_decoder *d, uint32_t k, cq_index row)
{
    const cq_channel *channel = &d->shape.channel[k];
    const cq_index wedge = CQI_ENCODING(d) ? d->plan->wedge_of_row[row] : 0;
    cqi_base_row b;
    uint32_t c;
    cqi_look_around_row(d, row, &b);
    if (b.num_known && cqi_code_equal(d, k, CQI_EQUAL_KNOWN, row, b.known[0])) return 1;
    if (row > d->seams->first && cqi_code_equal(d, k, CQI_EQUAL_BEFORE, row, (cq_index)(row - 1))) return 1;
    if (channel->kind == CQ_NORMAL && cqi_has_pairs(d, k))
        return cqi_code_pair_near(d, k, row, b.normal, b.known, b.num_known, 0, wedge);
    for (c = 0; c < channel->components; c++) {
        int32_t *const size = (b.num_known ? d->now.base.size : d->now.base.first) + k * CQ_MAX_COMPONENTS + c;
        int32_t p = cqi_predict_base_row(d, k, c, row, &b), x = 0;
        if (CQI_ENCODING(d)) x = cqi_difference(cqi_plan_value(d, k, c, wedge), p);
        x = cqi_code_base_residual(d, channel, x, size);
        if (!cqi_store_value(channel, p, x, d->channel[k] + (size_t)row * channel->components + c)) return 0;
    }
    return 1;
}

/* Moves on to the next corner of the vertex; when all have their rows, to the values of the new ones. */
static void cqi_next_base_corner(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    s->corner = cq_clockwise(&d->base.draft, s->corner);
    s->fresh = s->corner == d->base.draft.out[s->vertex];
    s->row_of_base = s->first;
}

static void cqi_next_base_vertex(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    s->fresh = 0;
    s->first = s->num_rows;
    if (++s->vertex < d->base.draft.num_vertices) s->corner = d->base.draft.out[s->vertex];
}

/* The row of the next corner; or, when all corners of a vertex have theirs, one channel of a new row. */
static CQI_APART cq_result cqi_step_base_rows(cq_decoder *d)
{
    cqi_seams *s = d->seams;
    int ok = 1;
    if (s->vertex == d->base.draft.num_vertices) return cqi_step_base_values(d);
    if (!s->fresh) {
        if (s->corner / 3 < d->mesh.first_virtual_face) ok = cqi_code_base_corner(d);
        CQI_TRACE_IF(ok && cqi_row_at(d, s->corner) != CQ_NONE, d, CQ_EVENT_CORNER, s->vertex, d->index[s->corner], 0);
        cqi_next_base_corner(d);
        if (CQI_REPORTING(d)) cqi_charge(d, &d->report->base, NULL);
    } else if (s->row_of_base == s->num_rows) {
        cqi_next_base_vertex(d);
    } else if (cqi_next_channel(d, &s->channel)) {
        const uint32_t k = s->channel++;
        ok = cqi_code_base_row(d, k, s->row_of_base);
        CQI_TRACE_IF(ok, d, CQ_EVENT_VALUES, k, s->row_of_base, 0);
        cqi_charge_channel(d, k);
    } else {
        s->channel = 0;
        s->row_of_base++;
    }
    if (cqi_starved(d)) return CQ_TRUNCATED;
    return ok ? CQ_OK : CQ_ERROR_CORRUPT;
}

/* Moves on to what is aside and to metadata, unless they have been read: then returns 0. */
static int cqi_has_aside(cq_decoder *d)
{
    if (d->aside.num_rows == d->shape.num_aside_rows && d->aside.num_faces == d->shape.num_aside_faces &&
        d->metadata_read == d->shape.metadata_bytes)
        return 0;
    memset(d->now.base.size, 0, sizeof d->now.base.size);
    d->base.value = 0;
    d->phase = CQI_READ_ASIDE;
    return 1;
}

/* Channel k of the next row aside, given the one before. */
static int cqi_code_aside_row(cq_decoder *d, uint32_t k)
{
    const cq_channel *channel = &d->shape.channel[k];
    const uint32_t n = channel->components;
    cq_value *to = d->aside.channel[k] + (size_t)d->aside.num_rows * n;
    uint32_t c;
    for (c = 0; c < n; c++) {
        int32_t p = cqi_is_exact(channel) ? 0 : (int32_t)1 << (channel->bits - 1), x = 0;
        if (d->aside.num_rows) p = cqi_number(channel, to[(int32_t)c - (int32_t)n]);
        if (CQI_ENCODING(d)) {
            const size_t row = d->plan->aside_row[d->aside.num_rows];
            x = cqi_difference(cqi_number(channel, d->plan->input[k][row * n + c]), p);
        }
        x = cqi_code_base_residual(d, channel, x, &d->now.base.size[k * CQ_MAX_COMPONENTS + c]);
        if (!cqi_store_value(channel, p, x, to + c)) return 0;
    }
    return 1;
}

/* The number that a row of the input has in the stream. */
static cq_index cqi_plan_row(const cqi_plan *p, cq_index row, cq_index num_rows)
{
    const cq_index t = p->target[row];
    if (t >= p->num_wedges) return (cq_index)(num_rows + (t - p->num_wedges));
    return p->index ? p->row_decoded[t] : p->decoded[t];
}

/* The next face aside: its rows, then its values, given those of the one before. */
static int cqi_code_aside_face(cq_decoder *d)
{
    const cq_shape *s = &d->shape;
    const cq_index num_rows = d->seams ? (cq_index)s->num_rows : (cq_index)s->num_vertices;
    const uint32_t all = (uint32_t)num_rows + s->num_aside_rows;
    cq_index *const to = d->aside.index + 3 * (size_t)d->aside.num_faces, face = 0;
    uint32_t k;
    if (CQI_ENCODING(d)) {
        while (!(d->plan->face_state[d->plan->aside_face] & CQI_FACE_ASIDE)) d->plan->aside_face++;
        face = d->plan->aside_face++;
    }
    for (k = 0; k < 3; k++) {
        uint32_t row = CQI_ENCODING(d) ? cqi_plan_row(d->plan, d->plan->triangles[3 * (size_t)face + k], num_rows) : 0;
        row = cqi_code_raw(d, row, all ? cqi_bit_length(all - 1) : 0);
        if (row >= all) return 0;
        to[k] = (cq_index)row;
    }
    if (d->materials && !cqi_aside_material(d, face)) return 0;
    for (k = 0; k < s->num_channels; k++) {
        cq_value *value = d->aside.channel[k] + d->aside.num_faces;
        int32_t before = 0, x = 0;
        if (cqi_class(s, k) != CQI_OF_FACE) continue;
        if (d->aside.num_faces) before = value[-1];
        if (CQI_ENCODING(d) && s->channel[k].kind != CQ_TURNED) x = d->plan->input[k][face];
        *value = (cq_value)cqi_code_copy(d, d->shape.channel[k].bits, &before, 1, x);
    }
    return 1;
}

/* A byte of the metadata, highest bit first; the bits before choose the model of each. */
static void cqi_code_metadata_byte(cq_decoder *d)
{
    const int byte = CQI_ENCODING(d) ? d->plan->metadata[d->metadata_read] : 0;
    int node = 1, k;
    for (k = 7; k >= 0; k--) node = 2 * node + cqi_code_with(d, &d->metadata_model[node], byte >> k & 1);
    d->metadata[d->metadata_read++] = (uint8_t)node;
}

/* Do rows have any values? Else there is nothing to read for them, nor does memory bound their number. */
static int cqi_has_rows(const cq_shape *s)
{
    return cqi_all_components(s, CQI_OF_VERTEX) || cqi_all_components(s, CQI_OF_ROW);
}

/* One channel of a row aside, or if rows have no values all rows at once; or a face; or a byte of metadata. */
static CQI_APART cq_result cqi_step_aside(cq_decoder *d)
{
    int ok = 1;
    if (d->aside.num_rows < d->shape.num_aside_rows) {
        const uint32_t k = (uint32_t)d->base.value;
        if (k < d->shape.num_channels && cqi_class(&d->shape, k) != CQI_OF_FACE) ok = cqi_code_aside_row(d, k);
        if (++d->base.value >= d->shape.num_channels && ok && !cqi_starved(d)) {
            d->base.value = 0;
            d->aside.num_rows = cqi_has_rows(&d->shape) ? d->aside.num_rows + 1 : d->shape.num_aside_rows;
        }
    } else if (d->aside.num_faces < d->shape.num_aside_faces) {
        ok = cqi_code_aside_face(d);
        if (ok && !cqi_starved(d)) d->aside.num_faces++;
    } else if (d->metadata_read < d->shape.metadata_bytes) {
        cqi_code_metadata_byte(d);
    } else {
        d->phase = CQI_LEVEL;
    }
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->aside, NULL);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    return ok ? CQ_OK : CQ_ERROR_CORRUPT;
}

#endif /* CQ_NO_WEDGES */

/* Does a vertex or face of the component still have to get its values? */
static int cqi_has_base_values(const cq_decoder *d)
{
    const cq_mesh *draft = &d->base.draft;
    cq_index n = (cq_index)(draft->num_vertices - d->mesh.num_vertices);
    if (cqi_all_components(&d->shape, CQI_OF_FACE)) n = (cq_index)(n + (d->base.faces - d->base.shown));
    return d->base.value < n;
}

/* Makes the component part of the mesh, whose arrays are those of the draft. */
static void cqi_show_component(cq_decoder *d)
{
    const cq_mesh *draft = &d->base.draft;
    d->num_components += d->mesh.num_vertices < draft->num_vertices; /* not of an empty mesh */
    d->mesh.num_vertices = draft->num_vertices;
    d->mesh.num_faces = draft->num_faces;
    d->mesh.num_virtual = draft->num_virtual;
    d->mesh.num_virtual_faces = draft->num_virtual_faces;
    d->mesh.is_partial = d->base.more && d->materials;
    d->base.shown = d->base.faces;
    cqi_show_materials(d);
    if (d->seams) d->num_rows = d->seams->num_rows;
}

/* The values of a vertex or face; when all have theirs, the component becomes public. After the last component, levels
 * follow. */
static CQI_APART cq_result cqi_step_base_values(cq_decoder *d)
{
    if (cqi_has_base_values(d)) return cqi_code_base_values(d);
    if (d->phase == CQI_BASE_VALUES && d->seams) return cqi_begin_base_rows(d);
    cqi_show_component(d);
    if (CQI_REPORTING(d)) {
        d->report->num_components = d->num_components;
        d->report->base_vertices = d->mesh.num_vertices;
        d->report->base_faces = d->base.shown;
    }
    d->phase = CQI_BASE;
    if (d->base.more) return CQ_OK;
    cqi_take_virtual(&d->mesh);
    d->base.vertices = d->mesh.num_vertices;
    d->active = 0;
    if (CQI_ENCODING(d)) d->plan->num_active = 0;
    d->phase = CQI_LEVEL;
    return CQ_OK;
}

/* The distance in 1/16 step that a code stands for: 0, then in eighths of an octave from 1 on. */
static uint32_t cqi_error_of_code(uint32_t code)
{
    const uint32_t octave = code ? (code - 1) / 8 : 0;
    const uint64_t eighths = (uint64_t)(8 + (code + 7) % 8) << octave;
    return code ? (uint32_t)(octave > 27 ? 0xffffffff : (eighths + 7) / 8) : 0;
}

/* The mesh's distance from the exact one at the beginning of a level: never more than before. */
static void cqi_code_error(cq_decoder *d)
{
    uint32_t error = CQI_ENCODING(d) ? d->plan->level_error[d->plan->level] : 0;
    int less;
    if (d->located < 0) return;
    if (d->level == 1) {
        d->error_code = cqi_code_raw(d, error, 8);
    } else {
        less = cqi_code_count(d, CQI_ERROR, cqi_at_most((int)(d->error_code - error), 38));
        d->error_code = (uint32_t)less < d->error_code ? d->error_code - (uint32_t)less : 0;
    }
    if (!cqi_starved(d)) d->error = cqi_error_of_code(d->error_code);
}

/* Does another component take part from this level on? Components join in the order of their vertices. `active` is the
 * vertex where the next one begins, or on its way there. */
static cq_result cqi_step_active(cq_decoder *d)
{
    int k, begins;
    for (k = 0; d->active < d->base.vertices && !(d->mesh.mark[d->active] & CQI_SEED); k++) {
        if (k == CQI_AT_ONCE) return CQ_OK;
        d->active++;
    }
    begins = d->active < d->base.vertices;
    if (begins) begins = cqi_code_bit(d, CQI_BEGINS, CQI_ENCODING(d) && cqi_plan_begins(d->plan));
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (begins) {
        d->active++;
        if (CQI_ENCODING(d)) d->plan->num_active++;
        return CQ_OK;
    }
    d->ruled = d->located < 0 || cqi_code_bit(d, CQI_RULED, CQI_ENCODING(d) && !d->plan->positions);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    if (CQI_REPORTING(d)) cqi_charge(d, &d->report->flags, &cqi_level_report(d)->flags);
    d->phase = CQI_CLEAR;
    return CQ_OK;
}

/* Moves on to the level that follows `level` others. */
static void cqi_plan_next_level(cqi_plan *p, uint32_t level)
{
    p->level = p->num_levels - level;
    p->bytes_at[p->level] = cqi_plan_bytes(p);
}

/* Begins a level; or, when all vertices are there, ends the stream, of which all bytes must have been used. */
static cq_result cqi_step_level(cq_decoder *d)
{
    int regular = CQI_HAS_REGULAR && d->regular.count; /* after one, the first gates are no edges any more */
    if (d->mesh.num_vertices == d->shape.num_vertices) {
        if (d->seams && d->num_rows != d->shape.num_rows) return CQ_ERROR_CORRUPT;
        if (cqi_has_aside(d)) return CQ_OK;
        d->phase = CQI_COMPLETE;
        if (CQI_ENCODING(d)) return CQ_DONE;
        return d->range.count < d->range.size || d->input.payload_left ? CQ_ERROR_CORRUPT : CQ_DONE;
    }
    if (d->level == CQ_MAX_LEVELS) return CQ_ERROR_CORRUPT; /* unreachable: by meshes below 5 million vertices */
    if (CQI_ENCODING(d)) cqi_plan_next_level(d->plan, d->level);
    if (CQI_HAS_REGULAR && d->shape.regular && !regular)
        regular = cqi_code_bit(d, CQI_OTHER_LEVEL, CQI_ENCODING(d) && d->plan->level <= d->plan->num_regular);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    d->level++;
    cqi_code_error(d);
    if (cqi_starved(d)) return CQ_TRUNCATED;
    CQI_TRACE(d, CQ_EVENT_LEVEL, d->level, regular, d->error_code);
    if (CQI_REPORTING(d)) {
        memset(cqi_level_report(d), 0, sizeof(cq_level));
        cqi_level_report(d)->error = d->error;
    }
    d->rate = CQI_TUNED(rate, CQI_RATE(d->mesh.num_vertices));
#ifndef CQ_NO_REGULAR
    if (regular) return cqi_begin_regular(d);
#endif
    d->splits = 0;
    d->seed = d->cleared = 0;
    d->walk.head = d->walk.count = 0;
    d->walk.full = 0;
    d->phase = CQI_ACTIVE;
    return CQ_OK;
}

/* Clears the marks that the level before left, of the next vertices that take part: base vertices up to `active`, and
 * all that are not of the base. */
static cq_result cqi_step_clear(cq_decoder *d)
{
    cq_mesh *m = &d->mesh;
    const cq_index base_end = d->base.vertices; /* the base from d->active on is not in this level yet */
    cq_index v = d->cleared, end = v < d->active ? d->active : m->num_vertices;
    if (end - v > CQI_AT_ONCE) end = (cq_index)(v + CQI_AT_ONCE);
    for (; v < end && v < d->base.vertices; v++) m->mark[v] &= CQI_SEED; /* others are not seeds */
    memset(m->mark + v, 0, (size_t)(end - v));
    v = end;
    d->cleared = v == d->active && v < base_end ? base_end : v;
    if (d->cleared < m->num_vertices) return CQ_OK;
    if (CQI_ENCODING(d)) d->plan->next_seed = 0;
    d->phase = CQI_PATCHES;
    return CQ_OK;
}

static cq_result cqi_end_level(cq_decoder *d)
{
    const cq_index before = (cq_index)(d->mesh.num_vertices - d->splits - (d->base.vertices - d->active));
    if (d->splits < CQI_MIN_SPLITS(before)) return CQ_ERROR_CORRUPT;
    if (CQI_REPORTING(d)) {
        cq_level *level = cqi_level_report(d);
        d->report->num_levels = d->level;
        cqi_charge(d, &d->report->flags, &level->flags);
        level->num_splits = d->splits;
        level->num_vertices = (uint32_t)d->mesh.num_vertices;
    }
    d->phase = CQI_LEVEL;
    return CQ_OK;
}

static cq_result cqi_step_patch(cq_decoder *d)
{
    cq_index v = cqi_dequeue(&d->mesh, &d->walk);
    if (v != CQ_NONE) return cqi_code_patch(d, d->mesh.out[v]);
    v = cqi_next_seed(d);
    if (v != CQ_NONE) return cqi_code_first_patch(d, v);
    return d->seed < d->active ? CQ_OK : cqi_end_level(d);
}

static CQI_APART cq_result cqi_step(cq_decoder *d)
{
    switch (d->phase) {
    case CQI_MATERIALS: return cqi_step_materials(d);
    case CQI_BASE: return cqi_step_base(d);
    case CQI_BASE_VALUES: return cqi_step_base_values(d);
#ifndef CQ_NO_WEDGES
    case CQI_BASE_ROWS: return cqi_step_base_rows(d);
    case CQI_READ_CORNERS: return cqi_step_corners(d);
    case CQI_READ_ROWS: return cqi_step_rows(d);
    case CQI_READ_ASIDE: return cqi_step_aside(d);
#endif
    case CQI_LEVEL: return cqi_step_level(d);
    case CQI_ACTIVE: return cqi_step_active(d);
    case CQI_CLEAR: return cqi_step_clear(d);
#ifndef CQ_NO_REGULAR
    case CQI_WIPE: return cqi_step_wipe(d);
    case CQI_MARKS: return cqi_step_marks(d);
    case CQI_TABLE: return cqi_step_table(d);
    case CQI_EXPECT: return cqi_step_expect(d);
    case CQI_DISSOLVES: return cqi_step_dissolves(d);
    case CQI_RECORDS: return cqi_step_records(d);
    case CQI_SWEEP: return cqi_step_sweep(d);
#endif
    default: return cqi_step_patch(d);
    }
}

/* -- Decoder ------------------------------------------------------------------------------------------------------- */

/* See CQI_STEP_BYTES and CQI_BUFFER_BYTES. */
static size_t cqi_step_bytes(const cq_shape *s)
{
    size_t bytes = CQI_STEP_BYTES(s->num_materials != 0);
    uint32_t k;
    for (k = 0; k < s->num_channels; k++) {
        const cq_channel *c = &s->channel[k];
        bytes += cqi_may_be_pair(c) ? 72u : (c->kind == CQ_WEIGHTS ? 19u : 18u) * (size_t)c->components;
    }
    return bytes < CQI_BUFFER_BYTES ? bytes : CQI_BUFFER_BYTES;
}

/* Divides the memory, which holds at least cq_decoder_bytes of d->shape, and prepares the first step. */
static void cqi_start(cq_decoder *d)
{
    cqi_arena arena;
    cq_value *values;
    size_t v = cqi_all_vertices(&d->shape);
    uint32_t k;
    arena.next = d->memory;
    arena.left = d->memory_size;
    cqi_mesh_carve(&d->mesh, &d->shape, &arena);
    d->walk.capacity = (cq_index)(cqi_all_faces(&d->shape) / 3 + 1);
    d->walk.queue = (cq_index *)cqi_take(&arena, d->walk.capacity, sizeof(cq_index));
    values = (cq_value *)cqi_take(&arena, v * cqi_all_components(&d->shape, CQI_OF_VERTEX), sizeof(cq_value));
    for (k = 0; k < d->shape.num_channels; k++) {
        const int of = cqi_class(&d->shape, k);
        if (of == CQI_OF_FACE) d->channel[k] = (cq_value *)cqi_take(&arena, d->shape.num_faces, sizeof(cq_value));
        if (of != CQI_OF_VERTEX) continue;
        d->channel[k] = values;
        values += v * d->shape.channel[k].components;
    }
    d->located = cqi_context_channel(&d->shape);
    cqi_model_init(&d->model, &d->shape);
    d->index = d->mesh.origin;
    d->phase = d->shape.num_vertices ? CQI_BASE : CQI_BASE_VALUES;
#ifndef CQ_NO_WEDGES
    cqi_start_rows(d, &arena);
#endif
    d->input.step_bytes = cqi_step_bytes(&d->shape);
    if (d->shape.regular && d->seams)
        d->input.step_bytes = CQI_BUFFER_BYTES;
    if (d->seams && d->input.step_bytes < CQI_ROW_STEP_BYTES) d->input.step_bytes = CQI_ROW_STEP_BYTES;
    d->base.draft = d->mesh;
    memset(&d->now.base, 0, sizeof d->now.base);
    d->rate = CQI_TUNED(rate, CQI_RATE(0));
    d->base.virtual_scan = (cq_index)(3 * d->mesh.first_virtual_face);
    d->base.last_face = d->base.valued_face = CQ_NONE;
}

cq_result cq_decoder_init(cq_decoder *d, void *memory, size_t memory_size)
{
    if (!d || !memory) return CQ_ERROR_ARGUMENT;
    memset(d, 0, sizeof *d);
    d->memory = (uint8_t *)memory;
    d->memory_size = memory_size;
    return CQ_OK;
}

void cq_watch_faces(cq_decoder *d, int shift, uint8_t *faces)
{
    CQ_ASSERT(shift >= 0 && shift < CQ_INDEX_BITS);
    d->mesh.watched = faces;
    d->mesh.watched_shift = shift;
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
    d->input.payload_left = d->input.payload_size = h->payload_size;
    d->input.expected_crc = h->payload_crc;
    if (CQI_REPORTING(d)) {
        memset(d->report, 0, sizeof *d->report);
        d->report->shape = d->shape;
        d->report->bytes = h->header_size + h->payload_size;
    }
    d->range.size = 0;
    cqi_start(d);
    return CQ_OK;
}

/* Takes header bytes one by one, so that none after a short stream is touched. */
static CQI_APART cq_result cqi_take_header(cq_decoder *d, cq_bytes *in)
{
    cqi_header h;
    cq_result result = CQ_NEED_INPUT;
    h.shape = &d->shape;
    while (result == CQ_NEED_INPUT && in && in->size) {
        d->buffer[d->range.size++] = *in->data++;
        in->size--;
        result = cqi_read_header(d->buffer, d->range.size, &h);
    }
    if (result == CQ_NEED_INPUT && d->input.ended) return CQ_TRUNCATED;
    return result == CQ_OK ? cqi_open_stream(d, &h) : result;
}

/* Moves what is left in the buffer to its start, byte by byte, as the two may overlap. */
static void cqi_drop_used(cq_decoder *d)
{
    const size_t left = d->range.size - d->range.count;
    size_t k;
    for (k = 0; k < left; k++) d->buffer[k] = d->buffer[d->range.count + k];
    d->input.dropped += d->range.count;
    d->range.size = left;
    d->range.count = 0;
}

/* Moves payload bytes from the input to the buffer while less than a step is left there. */
static void cqi_take_payload(cq_decoder *d, cq_bytes *in)
{
    while (d->range.size < d->range.count + d->input.step_bytes && d->input.payload_left && in && in->size) {
        size_t n;
        if (d->range.size == CQI_BUFFER_BYTES) cqi_drop_used(d);
        n = CQI_BUFFER_BYTES - d->range.size;
        n = n < in->size ? n : in->size;
        n = n < d->input.payload_left ? n : d->input.payload_left;
        memcpy(d->buffer + d->range.size, in->data, n);
        d->input.crc = cqi_crc32(d->input.crc, in->data, n);
        d->range.size += n;
        d->input.payload_left -= n;
        in->data += n;
        in->size -= n;
    }
}

/* Is there enough input for any step: as much as one may need, or all that will come? */
static int cqi_is_ready(const cq_decoder *d)
{
    return d->range.size >= d->range.count + d->input.step_bytes || !d->input.payload_left || d->input.ended;
}

static cq_result cqi_finish_stream(cq_decoder *d)
{
    if (d->input.crc != d->input.expected_crc) return CQ_ERROR_CHECKSUM;
    CQI_TRACE(d, CQ_EVENT_END, d->level, d->mesh.num_vertices, d->mesh.num_faces);
    d->error = 0;
    if (CQI_REPORTING(d)) {
        cq_report *r = d->report;
        r->header =
            (uint64_t)r->bytes * 8 * 65536 - r->base - r->flags - r->indices - r->positions - r->channels - r->aside;
    }
    return CQ_DONE;
}

static cq_result cqi_run(cq_decoder *d, cq_bytes *in, uint32_t budget)
{
    cq_result result = CQ_OK;
    while (budget) {
        cqi_take_payload(d, in);
        if (!cqi_is_ready(d)) {
            result = CQ_NEED_INPUT;
            break;
        }
        if (!d->range.data) {
            cq_range_decoder_init(&d->range, d->buffer, d->range.size);
            if (CQI_REPORTING(d)) d->cost = 4 * 8 * 65536 - cqi_log2(0xffffffffu);
        }
        budget--;
        result = cqi_step(d);
        if (result != CQ_OK) break;
    }
    if (!d->seams) d->num_rows = d->mesh.num_vertices;
    if (result == CQ_OK) return CQ_MORE;
    if (result == CQ_NEED_INPUT) return result;
    if (result == CQ_DONE) result = cqi_finish_stream(d);
    d->status = result;
    return result;
}

cq_result cq_decode(cq_decoder *d, cq_bytes *in, uint32_t budget)
{
    if (!d || (in && in->size && !in->data)) return CQ_ERROR_ARGUMENT;
    if (d->status != CQ_OK) return d->status;
    if (!in) d->input.ended = 1;
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

/* Values of row r in channel k, which may be those of its vertex. */
static const cq_value *cqi_values_of_row(const cq_decoder *d, uint32_t k, cq_index r)
{
    const int follow = d->vertex && cqi_class(&d->shape, k) == CQI_OF_VERTEX;
    return d->channel[k] + (size_t)(follow ? d->vertex[r] : r) * d->shape.channel[k].components;
}

void cq_read_rows(const cq_decoder *d, uint32_t k, cq_index first, cq_index count, cq_value *to)
{
    CQ_ASSERT(k < d->shape.num_channels && first <= d->num_rows && count <= d->num_rows - first);
    const size_t n = d->shape.channel[k].components;
    cq_index r;
    for (r = first; r < first + count; r++, to += n) memcpy(to, cqi_values_of_row(d, k, r), n * sizeof(cq_value));
}

void cq_read_rows_uint16(const cq_decoder *d, uint32_t k, cq_index first, cq_index count, uint16_t *to, size_t stride)
{
    CQ_ASSERT(k < d->shape.num_channels && first <= d->num_rows && count <= d->num_rows - first);
    CQ_ASSERT(d->shape.channel[k].bits <= 16 && stride >= d->shape.channel[k].components);
    const size_t n = d->shape.channel[k].components;
    cq_index r;
    size_t c;
    for (r = first; r < first + count; r++, to += stride) {
        const cq_value *const from = cqi_values_of_row(d, k, r);
        for (c = 0; c < n; c++) to[c] = (uint16_t)from[c];
    }
}

void cq_read_rows_uint8(const cq_decoder *d, uint32_t k, cq_index first, cq_index count, uint8_t *to, size_t stride)
{
    CQ_ASSERT(k < d->shape.num_channels && first <= d->num_rows && count <= d->num_rows - first);
    CQ_ASSERT(d->shape.channel[k].bits <= 8 && stride >= d->shape.channel[k].components);
    const size_t n = d->shape.channel[k].components;
    cq_index r;
    size_t c;
    for (r = first; r < first + count; r++, to += stride) {
        const cq_value *const from = cqi_values_of_row(d, k, r);
        for (c = 0; c < n; c++) to[c] = (uint8_t)from[c];
    }
}

/* Values of the channel CQ_TURNED, which is the last one; or NULL. */
static const cq_value *cqi_turned(const cq_decoder *d)
{
    const uint32_t last = d->shape.num_channels - 1;
    return d->shape.num_channels && d->shape.channel[last].kind == CQ_TURNED ? d->channel[last] : NULL;
}

void cq_read_triangles(const cq_decoder *d, cq_index first, cq_index count, cq_index *to)
{
    CQ_ASSERT(first <= d->mesh.num_faces && count <= d->mesh.num_faces - first);
    const cq_value *turned = cqi_turned(d);
    cq_index f;
    for (f = first; f < first + count; f++, to += 3) {
        const cq_index *const from = d->index + 3 * (size_t)f;
        const int over = turned && turned[f];
        to[0] = from[0];
        to[1] = from[over ? 2 : 1];
        to[2] = from[over ? 1 : 2];
    }
}

void cq_material(const cq_decoder *d, uint32_t m, cq_index *first, cq_index *count)
{
    CQ_ASSERT(m < d->shape.num_materials || !m);
    *first = 0;
    *count = d->mesh.num_faces;
    if (!d->materials) return;
    *first = d->materials[m].first;
    *count = d->materials[m].shown;
}

/* Rows only move to new vertices, so those that have moved are around these. */
void cq_moved_rows(const cq_decoder *d, cq_index since_vertices, cq_index since_rows, int shift, uint8_t *rows)
{
    CQ_ASSERT(shift >= 0 && shift < CQ_INDEX_BITS);
    CQ_ASSERT(rows);
    cq_index v, h;
    for (v = since_vertices; d->vertex && v < d->mesh.num_vertices; v++) {
        h = d->mesh.out[v];
        do {
            if (h / 3 < d->mesh.first_virtual_face && d->index[h] < since_rows) rows[d->index[h] >> shift] = 1;
            h = cq_clockwise(&d->mesh, h);
        } while (h != d->mesh.out[v]);
    }
}

/* -- Levels of detail ----------------------------------------------------------------------------------------------
 *
 * For cq_keep_lods. */

/* Is d->error known? At level 1, a 0 may mean that it has not been read yet. */
static int cqi_knows_error(const cq_decoder *d)
{
    return d->status == CQ_DONE || (d->located >= 0 && (d->error || d->level > 1));
}

static int cqi_is_due(const cq_decoder *d, const cq_lod *lod)
{
    const int base_is_complete = d->phase > CQI_BASE_ROWS;
    return base_is_complete && d->num_rows && d->num_rows >= lod->min_vertices &&
           (lod->max_error == CQ_NO_LIMIT || (cqi_knows_error(d) && d->error <= lod->max_error));
}

/* Copies the indices of all faces that are there, material by material. */
static void cqi_keep_faces(const cq_decoder *d, cq_index *to, cq_index *of_material)
{
    uint32_t m = 0;
    do {
        cq_index first, count;
        cq_material(d, m, &first, &count);
        memcpy(to, d->index + 3 * (size_t)first, 3 * (size_t)count * sizeof(cq_index));
        to += 3 * (size_t)count;
        if (of_material) of_material[m] = count;
    } while (++m < d->shape.num_materials);
}

size_t cq_keep_lods(const cq_decoder *d, cq_lod *lod, size_t count, cq_index *indices, size_t capacity)
{
    const cq_index faces = cqi_num_faces(d);
    const size_t corners = 3 * (size_t)faces;
    size_t end = 0, k = 0;
    CQ_ASSERT((!count || lod) && (!capacity || indices));
    while (k < count && lod[k].num_vertices) {
        end = lod[k].first + 3 * (size_t)lod[k].num_faces;
        k++;
    }
    for (; k < count && cqi_is_due(d, &lod[k]); k++) {
        const int is_new = !k || lod[k - 1].num_faces != faces; /* each split adds faces */
        if (is_new && corners > capacity - end) break;
        if (is_new) end += corners;
        cqi_keep_faces(d, indices + (end - corners), lod[k].of_material);
        lod[k].first = end - corners;
        lod[k].num_vertices = d->num_rows;
        lod[k].num_faces = faces;
        lod[k].error = cqi_knows_error(d) ? d->error : CQ_NO_LIMIT;
    }
    return k;
}

/* -- Encoder: simplification (section 2.2 of the paper) ------------------------------------------------------------
 *
 * An encoder builds the mesh, undoes regular levels, and simplifies what is left level by level, noting each collapse.
 * Then it replays the notes, coarsest first, by the steps of a decoder that write instead of read. cqi_encode_pass has
 * it all in order. */

#ifndef CQ_NO_ENCODER

/* What a pass may take over from the one before, whose notes of these regular levels are still there. */
typedef struct cqi_known {
    uint32_t levels;                        /* the finest ones; 0 if the input had to be prepared */
    cq_index count_of[CQI_MAX_REGULAR + 1];
    uint8_t alike[CQI_MAX_REGULAR + 1];     /* cqi_labels.alike of each, */
    int is_sharp, limit, found;             /* and these fields of the labels of the finest one */
} cqi_known;

typedef struct cqi_encoder {
    cqi_plan plan;
    cq_decoder replay;
    cq_input coded;           /* the input, with the shape of the mesh that is coded */
    cq_report report;         /* of the pass to compare, see cqi_encode_best. A pass clears all above, but not this, */
    cqi_known known;          /* nor this */
} cqi_encoder;

/* Room for samples, by the number of vertices. */
static uint32_t cqi_most_samples(cqi_size num_vertices)
{
    const cqi_size tenth = num_vertices / 10;
    return tenth < CQI_FEW_SAMPLES ? CQI_FEW_SAMPLES : tenth < CQI_MOST_SAMPLES ? (uint32_t)tenth : CQI_MOST_SAMPLES;
}

#define CQI_ENCODER_BYTES ((sizeof(cqi_encoder) + 7) / 8 * 8)

#ifndef CQ_NO_WEDGES
static uint64_t cqi_preparing_bytes(const cq_shape *s);
static uint64_t cqi_prepared_bytes(const cq_shape *s);
#endif

/* Once a call of cq_encode has set num_rows, the mesh has at most that many vertices. */
size_t cq_encoder_bytes(const cq_shape *shape)
{
    cq_shape coded, *s = &coded;
    cqi_size v, f, plan;
    uint64_t all, preparing = 0, more = 0;
    if (!shape || !cqi_countable(shape)) return 0;
    coded = *shape;
#ifndef CQ_NO_WEDGES
    preparing = CQI_ENCODER_BYTES + cqi_preparing_bytes(shape);
    if (s->num_rows) {
        more = cqi_prepared_bytes(shape) + cqi_more_bytes(s) + CQ_FACE_BYTES(s->num_faces);
        more += CQ_FACE_BYTES(s->num_aside_faces);
        more += (uint64_t)s->num_boundary_loops * cqi_all_components(s, CQI_OF_ROW) *
                sizeof(cq_value); /* if it has no seams */
        s->num_vertices = s->num_rows;
    }
#endif
    v = cqi_all_vertices(s);
    f = cqi_all_faces(s);
    plan = (v + 1) * (sizeof(cqi_collapse) + 1) + (3 * v + f / 3 + 1 + 2 * f) * sizeof(cq_index);
    plan += (cqi_size)cqi_most_samples(v) * sizeof(cqi_sample);
    plan += 8 * 4; /* roundings of blocks */
    if (!shape->num_rows) more = cqi_more_bytes(s);
    all = (uint64_t)CQI_ENCODER_BYTES + CQ_MESH_BYTES(v, f) + CQI_ROUND(plan) + cqi_decoder_size(s);
    return cqi_sum_of_sizes(all + more > preparing ? all : preparing, all + more > preparing ? more : 0);
}

static uint32_t cqi_limited(uint64_t count, uint32_t limit) { return count < limit ? (uint32_t)count : limit; }

/* The largest counts that cq_encode may set in a shape with v vertices and f faces, but none that is larger than
 * cqi_countable lets pass. Before the call, the counts of rows and of what is aside are 0.
 *
 * Triangles that need no preparation are a mesh with v vertices. Of the 3f halfedges, at most one boundary halfedge
 * leaves each vertex; and a loop has 3 edges or more, as the two halfedges of an edge are twins. Of triangles that are
 * prepared, some may go aside. The others have at most 3f corners, and as many halfedges: each corner can be a wedge,
 * which is a row of the mesh, and each halfedge can be open, again in loops of 3 or more, as no two edges join the same
 * fans. A row aside is one of the v rows.
 *
 * cq_encoder_bytes grows with each count. Where the sum of rows and rows aside is limited, rows of the mesh come first,
 * as each of them takes more bytes than a row aside. */
static void cqi_set_most(cq_shape *s, int prepared)
{
    const uint32_t v = s->num_vertices, f = s->num_faces, limit = (uint32_t)(CQI_MAX_HALFEDGES / 3);
    const uint64_t corners = 3 * (uint64_t)f;
    s->num_boundary_edges = cqi_limited(!prepared && v < corners ? v : corners, limit - f);
    s->num_boundary_loops = cqi_limited(s->num_boundary_edges / 3, limit - v);
    if (!prepared) return;
    s->num_rows = f ? cqi_limited(corners, CQI_MAX_HALFEDGES) : 1;
    s->num_aside_rows = cqi_limited(v, CQI_MAX_HALFEDGES - s->num_rows);
    s->num_aside_faces = f;
}

size_t cq_encoder_bytes_at_most(const cq_shape *shape)
{
    cq_shape most;
    size_t as_they_are, prepared;
    if (!shape) return 0;
    most = *shape;
    most.num_boundary_loops = most.num_boundary_edges = 0;
    most.num_rows = most.num_aside_rows = most.num_aside_faces = 0;
    if (!cqi_countable(&most)) return 0;
    cqi_set_most(&most, 0);
    as_they_are = cq_encoder_bytes(&most);
#ifdef CQ_NO_WEDGES
    prepared = as_they_are;
#else
    cqi_set_most(&most, 1);
    prepared = cq_encoder_bytes(&most);
#endif
    if (!as_they_are || !prepared) return 0; /* unreachable: size_t of 64 bits */
    return prepared > as_they_are ? prepared : as_they_are;
}

static uint64_t cqi_square_distance(const cq_value *positions, cq_index a, cq_index b)
{
    const cq_value *const from = positions + 3 * (size_t)a, *const to = positions + 3 * (size_t)b;
    const int64_t x = (int64_t)to[0] - from[0], y = (int64_t)to[1] - from[1], z = (int64_t)to[2] - from[2];
    return (uint64_t)(x * x + y * y + z * z);
}

/* -- Quadric error of a collapse: CQ_BALANCED --
 *
 * Quadric error (Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997) without memory
 * (Lindstrom, Turk, "Fast and Memory Efficient Polygonal Simplification", 1998): squared distances of A from the planes
 * of the triangles around B, times their areas; and from the lines of boundary edges, times their squared lengths. A
 * crease has planes on both sides, and so resists by itself. If a collapse turns a triangle over, or leaves less than
 * an eighth of its area as seen along its normal, the error is infinite (CQI_ANY_QUADRIC).
 *
 * A level refuses collapses with a larger error than a limit, and of the others takes the one with the smallest valence.
 * At first the limit is half of the median error of edges, or less. It grows from level to level about as the errors on
 * a smooth surface do: with a sixth fewer vertices, areas and distances from the planes are 1.2 times as large, and
 * errors 1.7 times. What stays refused are features. If the limit grew less, more patches would be isolated, whose
 * flags cost bits. It also grows when a level removes too few vertices, and is lifted in the end.
 *
 * Quadric errors are compared by their logarithms, in 1/256 octave.
 *
 * Bounds: offsets from the centre of a fan have 12 bits, areas 25, volumes 38. Distances in sixteenths are below 2^18,
 * as cqi_norm is never less than half a length; so their products with volumes are below 2^56. Squares of areas at
 * boundary edges and seams are below 2^52, and the sum over a fan is below 2^58. */
#define CQI_ANY_QUADRIC 0xffffffffu
#define CQI_OFFSET_BITS 12
#define CQI_OCTAVE 256

/* By how much the limit grows from one level to the next; and by how much at least if a level is tried again. */
#define CQI_LEVEL_QUADRIC (4 * CQI_OCTAVE / 5)
#define CQI_MORE_QUADRIC ((uint32_t)2 * CQI_OCTAVE)

/* Vertices that a level with a limit must remove if it keeps this many: half of what one without a limit can remove. */
#define CQI_WORTH(num_vertices) ((num_vertices) / 8 + 1)

/* The triangles around a vertex, with offsets from it. */
typedef struct cqi_fan_of_input {
    int size, shift;                             /* offsets are shifted down to CQI_OFFSET_BITS */
    int common, boundary;                        /* neighbours with the scratch mark; is any virtual? */
    cq_index vertex[CQ_MAX_VALENCE + 1];         /* clockwise, the first again at the end */
    cqi_vector at[CQ_MAX_VALENCE + 1];           /* 0 for virtual ones */
    cqi_vector area[CQ_MAX_VALENCE];             /* twice that of the triangle with the next one; boundary: its edge */
    int32_t norm[CQ_MAX_VALENCE];                /* length of that; -1: a boundary */
    cq_index spoke[CQ_MAX_VALENCE];              /* to the vertex */
} cqi_fan_of_input;

#ifdef CQ_NO_WEDGES
#define cqi_is_seam(p, h) 0
#else
static int cqi_is_seam(const cqi_plan *p, cq_index h);
#endif

/* Lists the neighbours of the spoke's origin, not more than CQ_MAX_VALENCE, from the end of the spoke on. */
static void cqi_list_fan(const cqi_plan *p, cqi_fan_of_input *f, cq_index spoke)
{
    const cq_mesh *m = &p->mesh;
    const cq_index *const origin = m->origin, *const twin = m->twin;
    const cq_value *const a = p->positions + 3 * (size_t)origin[spoke];
    const int32_t ax = a[0], ay = a[1], az = a[2];
    cq_index h = spoke;
    uint32_t all = 0, bits = 0;
    int k, n = 0, common = 0, boundary = 0;
    do {
        const cq_index in = twin[h], w = origin[in];
        const int is_virtual = cq_is_virtual(m, w);
        const cq_value *const b = is_virtual ? a : p->positions + 3 * (size_t)w;
        const int32_t x = b[0] - ax, y = b[1] - ay, z = b[2] - az;
        common += m->mark[w] / CQI_SCRATCH;
        boundary |= is_virtual;
        all |= cqi_changes_of_bits(x) | cqi_changes_of_bits(y) | cqi_changes_of_bits(z);
        f->vertex[n] = w;
        f->spoke[n] = h;
        f->at[n].x = x;
        f->at[n].y = y;
        f->at[n++].z = z;
        h = cq_next(in);
    } while (h != spoke);
    f->common = common;
    f->boundary = boundary;
    for (k = 0; all >> CQI_OFFSET_BITS && k < n; k++)
        bits |= cqi_abs(f->at[k].x) | cqi_abs(f->at[k].y) | cqi_abs(f->at[k].z);
    f->shift = cqi_bit_length(bits >> CQI_OFFSET_BITS);
    for (k = 0; f->shift && k < n; k++) f->at[k] = cqi_shift(f->at[k], f->shift);
    f->vertex[n] = f->vertex[0];
    f->at[n] = f->at[0];
    f->size = n;
}

/* The area of triangle k, or a boundary's edge; and its norm, or -1. */
static void cqi_measure_triangle(const cqi_plan *p, cqi_fan_of_input *f, int k)
{
    const int from = cq_is_virtual(&p->mesh, f->vertex[k]), to = cq_is_virtual(&p->mesh, f->vertex[k + 1]);
    f->area[k] = from ? f->at[k + 1] : to ? f->at[k] : cqi_cross(f->at[k], f->at[k + 1]);
    f->norm[k] = from || to ? -1 : cqi_norm(f->area[k]);
}

/* The quadric error of triangle k if the centre moves to the first vertex; 0 if it has no area. */
static uint64_t cqi_triangle_quadric(const cqi_fan_of_input *f, int k)
{
    const cqi_vector x = f->at[0];
    uint64_t sum = 0;
    if (f->norm[k] > 0) {
        const int64_t volume = cqi_wide_dot(f->area[k], x);
        const uint64_t above = (uint64_t)(volume < 0 ? -volume : volume);
        sum = 16 * above / (uint32_t)f->norm[k] * above >> 4;
    } else if (f->norm[k]) {
        const cqi_vector area = cqi_cross(f->area[k], x);
        sum = (uint64_t)cqi_wide_dot(area, area);
    }
    return sum;
}

/* The quadric error if the centre moves to the first vertex; or a part of it that is `enough` already. The planes of the
 * two triangles there, which are removed, go through that vertex, and so does a boundary edge to it. */
static uint64_t cqi_fan_quadric(const cqi_plan *p, cqi_fan_of_input *f, uint64_t enough)
{
    uint64_t sum = 0;
    int k;
    for (k = 1; p->index && k < f->size; k++) {
        const cqi_vector area = cqi_cross(f->at[k], f->at[0]);
        if (cqi_is_seam(p, f->spoke[k])) sum += (uint64_t)cqi_wide_dot(area, area);
    }
    for (k = 1; k + 1 < f->size && sum < enough; k++) {
        cqi_measure_triangle(p, f, k);
        sum += cqi_triangle_quadric(f, k);
    }
    return sum;
}

/* Does a triangle that stays turn over, or keep no more than an eighth of its area as seen along its normal, if the
 * centre moves to the first vertex? */
static int cqi_turns_a_face(const cqi_fan_of_input *f)
{
    int k;
    for (k = 1; k + 1 < f->size; k++) {
        const cqi_vector along = cqi_minus(f->at[k + 1], f->at[k]);
        int64_t before, less;
        if (f->norm[k] <= 0) continue;
        before = cqi_wide_dot(f->area[k], f->area[k]);
        less = cqi_wide_dot(f->area[k], cqi_cross(f->at[0], along));
        if (8 * (before - less) <= before) return 1;
    }
    return 0;
}

/* The quadric error 16^shift x as a logarithm, in 1/CQI_OCTAVE octave. */
static uint32_t cqi_log_quadric(uint64_t x, int shift)
{
    const int n = cqi_bit_length_wide(x);
    const uint32_t fraction = (uint32_t)(n > 8 ? x >> (n - 9) : x << (9 - n)) & 255;
    return x ? (uint32_t)(n + 4 * shift) * CQI_OCTAVE + fraction : 0;
}

/* A sum x for which cqi_log_quadric(x, shift) is above the limit. */
static uint64_t cqi_sum_above(uint32_t limit, int shift)
{
    const int octave = (int)(limit / CQI_OCTAVE) - 4 * shift;
    return octave < 0 ? 1 : octave < 64 ? (uint64_t)1 << octave : UINT64_MAX;
}

/* The quadric error of moving the centre B to the first vertex A. If it is above both limits, any number above them. */
static uint32_t cqi_quadric_of(const cqi_plan *p, cqi_fan_of_input *fan)
{
    const uint32_t limit = p->most_quadric > p->refused_quadric ? p->most_quadric : p->refused_quadric;
    const uint32_t quadric = cqi_log_quadric(cqi_fan_quadric(p, fan, cqi_sum_above(limit, fan->shift)), fan->shift);
    if (quadric > p->most_quadric) return quadric;
    return cqi_turns_a_face(fan) ? CQI_ANY_QUADRIC : quadric;
}

/* What cqi_collapsible says of a fan, whose second and last vertex are p and q. */
static int cqi_fan_is_collapsible(const cq_mesh *m, const cqi_fan_of_input *f, int boundary)
{
    if (boundary && f->boundary && !cq_is_virtual(m, f->vertex[1]) && !cq_is_virtual(m, f->vertex[f->size - 1]))
        return 0;
    return f->common == 2;
}

/* May h be collapsed, if valences and wedges allow that, and is its quadric error one that this level allows? Notes
 * the smallest one that is refused. */
static int cqi_allows(cqi_plan *p, cq_index h, int boundary)
{
    cqi_fan_of_input fan;
    uint32_t quadric;
    if (p->most_quadric == CQI_ANY_QUADRIC) return cqi_collapsible(&p->mesh, h, CQ_MAX_VALENCE, boundary);
    cqi_list_fan(p, &fan, p->mesh.twin[h]);
    if (!cqi_fan_is_collapsible(&p->mesh, &fan, boundary)) return 0;
    quadric = cqi_quadric_of(p, &fan);
    if (quadric <= p->most_quadric) return 1;
    if (quadric < p->refused_quadric) p->refused_quadric = quadric;
    return 0;
}

/* Raises the limit for another try, after a level that removed too few vertices. */
static void cqi_allow_more_quadric(cqi_plan *p)
{
    uint32_t more = p->most_quadric + CQI_MORE_QUADRIC;
    p->most_quadric = p->refused_quadric > more ? p->refused_quadric : more;
}

/* The first limit: an octave below that of the median quadric error, of 256 edges or more that are spread over the vertices. */
static uint32_t cqi_first_limit(cqi_plan *p, cq_index num_vertices)
{
    const cq_mesh *m = &p->mesh;
    const cq_index step = (cq_index)(num_vertices / 512 + 1);
    uint32_t count[128], all = 0, below = 0, octave = 0;
    cq_index v;
    memset(count, 0, sizeof count);
    p->most_quadric = CQI_ANY_QUADRIC - 1;
    for (v = 0; v < num_vertices; v = (cq_index)(v + step)) {
        cq_index h = m->out[v], w = h == CQ_NONE ? h : cq_target(m, h);
        cqi_fan_of_input fan;
        uint32_t quadric;
        if (cq_is_virtual(m, w) || m->valence[v] > CQ_MAX_VALENCE || m->valence[w] > CQ_MAX_VALENCE) continue;
        cqi_list_fan(p, &fan, m->twin[h]);
        quadric = cqi_quadric_of(p, &fan);
        all++;
        if (quadric != CQI_ANY_QUADRIC) count[quadric / CQI_OCTAVE]++;
    }
    while (octave < 127 && 2 * (below += count[octave]) < all) octave++;
    return octave ? (octave - 1) * CQI_OCTAVE : 0;
}

/* -- How far a level is from the exact surface --
 *
 * Each vertex that has been removed is attached to a face. Whichever face that is, the vertex is no further from the
 * mesh than from its face: so the largest such distance bounds the error, without any assumption. A collapse replaces
 * faces around A and B by its cover: the faces that A has instead of B's. What was attached to the old faces, and B, is
 * attached to the cover, each vertex to a face that is near it; all others stay where they are.
 *
 * The error of a level is never smaller than that of a finer one, so a vertex need only be within the error so far.
 * Mostly a test without a division shows that it is, and the first face that passes will do. Else the nearest face of
 * the cover is found; if that is too far away, faces of the component outside the cover are tried before the error
 * grows.
 *
 * Time: no face belongs to two patches of a level, while the faces that a collapse replaces and its cover belong to
 * one. So a level attaches each vertex at most once, to one of less than CQ_MAX_VALENCE faces. The search outside
 * visits all vertices of the component; it is done at most CQI_LOOKS times a level, and what a level leaves of these
 * the next coarser one may use, too.
 *
 * Bounds: coordinates of corners, from the centre, are at most 2^13, edges 2^14, normals 2^27, areas below 2^56, to_u
 * and to_v at most 2^41. Attached vertices are below 2^15, and 2^15.4 from other corners. So their products with to_u
 * are below 2^59, cross products with edges below 2^31, squares of these below 2^63. */
#define CQI_CORNER_BITS 13
#define CQI_LOOKS 4

/* Coordinates that are shifted down lose less than one unit, all in the same direction: so distances change by less
 * than 2 units; in 1/16. */
#define CQI_ROUNDED 32

/* A face u, A, v, seen from A. The products of to_u and to_v with a point are its barycentric coordinates for u and v,
 * times the area; what is left of the area is that for A. */
typedef struct cqi_facet {
    cq_index h;                             /* A -> v */
    cq_index *list;                         /* of what is attached to it */
    cqi_vector64 u, v, normal, to_u, to_v;
    int64_t area;                           /* square of the normal */
    int64_t limit, margin, most;            /* see cqi_passes; most: area + 3 margin */
} cqi_facet;

/* Positions are seen from a centre, in units of 2^shift. */
typedef struct cqi_view {
    cqi_vector64 centre;
    int shift;
} cqi_view;

typedef struct cqi_cover {
    cqi_view view;                          /* from A */
    uint32_t slack;                         /* the error so far, in 1/16 unit */
    cq_index rest;                          /* first of the vertices that did not pass */
    int size;
    cqi_facet facet[CQ_MAX_VALENCE];
} cqi_cover;

/* The nearest face so far, and how far it is, in 1/16 step. */
typedef struct cqi_nearest {
    cq_index h;
    uint32_t error;
} cqi_nearest;

static inline int64_t cqi_dot64(cqi_vector64 a, cqi_vector64 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline cqi_vector64 cqi_cross64(cqi_vector64 a, cqi_vector64 b)
{
    cqi_vector64 n;
    n.x = a.y * b.z - a.z * b.y;
    n.y = a.z * b.x - a.x * b.z;
    n.z = a.x * b.y - a.y * b.x;
    return n;
}

static inline cqi_vector64 cqi_subtract64(cqi_vector64 a, cqi_vector64 b)
{
    a.x -= b.x;
    a.y -= b.y;
    a.z -= b.z;
    return a;
}

static inline int64_t cqi_abs64(int64_t x) { return x < 0 ? -x : x; }

static inline int64_t cqi_larger64(int64_t a, int64_t b) { return a > b ? a : b; }

static inline int64_t cqi_largest(cqi_vector64 a)
{
    return cqi_larger64(cqi_larger64(cqi_abs64(a.x), cqi_abs64(a.y)), cqi_abs64(a.z));
}

static uint32_t cqi_square_root_above(uint64_t x)
{
    const uint32_t root = cqi_square_root(x);
    return root + ((uint64_t)root * root < x);
}

/* An upper bound of a distance, in 1/16 step, given its square as seen in units of 2^shift, in 1/256. */
static uint32_t cqi_error_of_square(uint64_t square, int shift)
{
    return (cqi_square_root_above(square) + (shift ? CQI_ROUNDED : 0)) << shift;
}

/* The smallest code that stands for at least an error in 1/16 step, see cqi_error_of_code. */
static uint8_t cqi_error_code(uint32_t error)
{
    int code = error ? 1 + cqi_logarithm(error) : 0;
    if (cqi_error_of_code((uint32_t)code) < error) code++;
    return (uint8_t)code;
}

/* The error so far. */
static uint32_t cqi_error_now(const cqi_plan *p) { return cqi_error_of_code(p->level_error[p->level]); }

/* -- Distances of a point from a face --
 *
 * Exact squares of distances, and cheaper tests whether one is small. */

static inline cqi_vector64 cqi_shift64(cqi_vector64 x, int shift)
{
    x.x = cqi_floor_shift_wide(x.x, shift);
    x.y = cqi_floor_shift_wide(x.y, shift);
    x.z = cqi_floor_shift_wide(x.z, shift);
    return x;
}

static inline cqi_vector64 cqi_see(const cqi_plan *p, const cqi_view *view, cq_index v)
{
    const cq_value *at = p->measured + 3 * (size_t)v;
    cqi_vector64 x;
    x.x = at[0] - view->centre.x;
    x.y = at[1] - view->centre.y;
    x.z = at[2] - view->centre.z;
    return cqi_shift64(x, view->shift);
}

/* The view from a vertex, in steps. */
static void cqi_set_view(const cqi_plan *p, cqi_view *view, cq_index centre)
{
    memset(view, 0, sizeof *view);
    view->centre = cqi_see(p, view, centre);
}

static void cqi_set_facet(cqi_facet *f, cqi_vector64 u, cqi_vector64 v)
{
    f->u = u;
    f->v = v;
    f->normal = cqi_cross64(u, v);
    f->area = cqi_dot64(f->normal, f->normal);
    f->to_u = cqi_cross64(v, f->normal);
    f->to_v = cqi_cross64(f->normal, u);
}

/* Does a point pass, which shows that it is within the slack s? Its barycentric coordinates are then -margin / area or
 * more, at most two of them below 0. If these are set to 0, and the others scaled to a sum of 1, they give a point of
 * the face at most 2 margin / area times the longest edge from the foot of the perpendicular, that is s / 2 or less.
 * The perpendicular is at most 13/16 s; and (1/2)^2 + (13/16)^2 < 1. */
static inline int cqi_passes(const cqi_facet *f, cqi_vector64 x)
{
    const int64_t u = cqi_dot64(f->to_u, x) + f->margin, v = cqi_dot64(f->to_v, x) + f->margin;
    if ((u | v | (f->most - u - v)) < 0) return 0;
    return cqi_abs64(cqi_dot64(f->normal, x)) <= f->limit;
}

/* Sets limit and margin for a slack in 1/16 unit. A vector's length is 1 to 7/4 times its largest coordinate. */
static void cqi_set_slack(cqi_facet *f, int64_t slack)
{
    const int64_t uv = cqi_larger64(cqi_largest(f->u), cqi_largest(f->v));
    const int64_t longest = cqi_larger64(uv, cqi_largest(cqi_subtract64(f->u, f->v)));
    f->limit = f->area ? slack * 13 * cqi_largest(f->normal) / 256 : -1;
    f->margin = slack < 112 * longest ? f->area / (112 * longest) * slack : f->area;
    f->most = f->area + 3 * f->margin;
}

/* Does x lie beside the segment from 0 to e, within a distance from it? */
static inline int cqi_is_beside(cqi_vector64 x, cqi_vector64 e, int64_t distance)
{
    const int64_t at = cqi_dot64(x, e), length = cqi_dot64(e, e);
    cqi_vector64 n;
    if (at < 0 || at > length) return 0;
    n = cqi_cross64(x, e);
    return cqi_dot64(n, n) <= distance * distance * length;
}

/* Is x outside an edge of the face, and within the slack of it? */
static inline int cqi_passes_edge(const cqi_facet *f, cqi_vector64 x, uint32_t slack)
{
    const int64_t u = cqi_dot64(f->to_u, x), v = cqi_dot64(f->to_v, x), distance = slack / 16;
    return (v < 0 && cqi_is_beside(x, f->u, distance)) || (u < 0 && cqi_is_beside(x, f->v, distance)) ||
           (u + v > f->area && cqi_is_beside(cqi_subtract64(x, f->u), cqi_subtract64(f->v, f->u), distance));
}

/* Square of the distance from a segment, in 1/256, rounded up. */
static uint64_t cqi_segment_square(cqi_vector64 x, cqi_vector64 e)
{
    const cqi_vector64 rest = cqi_subtract64(x, e), n = cqi_cross64(x, e);
    const int64_t at = cqi_dot64(x, e), length = cqi_dot64(e, e), area = cqi_dot64(n, n);
    if (at <= 0) return (uint64_t)(256 * cqi_dot64(x, x));
    if (at >= length) return (uint64_t)(256 * cqi_dot64(rest, rest));
    return (uint64_t)(area / length * 256 + (area % length * 256 + length - 1) / length);
}

/* The same for the plane of a face. */
static uint64_t cqi_plane_square(const cqi_facet *f, cqi_vector64 x)
{
    const uint32_t length = cqi_square_root(256 * (uint64_t)f->area);
    const uint64_t distance = (256 * (uint64_t)cqi_abs64(cqi_dot64(f->normal, x)) + length - 1) / length;
    return distance * distance;
}

/* The same for the face: if it is not the distance from the plane, it is that from an edge that x is outside of. */
static uint64_t cqi_facet_square(const cqi_facet *f, cqi_vector64 x)
{
    const int64_t u = cqi_dot64(f->to_u, x), v = cqi_dot64(f->to_v, x), w = f->area - u - v;
    uint64_t least = UINT64_MAX, other;
    if (f->area && (u | v | w) >= 0) return cqi_plane_square(f, x);
    if (v < 0 || !f->area) least = cqi_segment_square(x, f->u);
    if (u < 0 || !f->area) {
        other = cqi_segment_square(x, f->v);
        least = other < least ? other : least;
    }
    if (w < 0 || !f->area) {
        other = cqi_segment_square(cqi_subtract64(x, f->u), cqi_subtract64(f->v, f->u));
        least = other < least ? other : least;
    }
    return least;
}

/* -- Covers --
 *
 * The faces that a collapse leaves around A, as seen from A. */

/* Lists the real faces of a cover. If there are none, as where a tip was cut off, those next to it are used. One of
 * these is real: else A and B would have had no faces but the removed ones, and could not have been collapsed. */
static void cqi_list_cover(const cq_mesh *m, const cqi_collapse *c, cqi_cover *cover)
{
    const cq_index first = m->out[c->kept];
    cq_index h = cq_clockwise(m, first);
    int k;
    cover->size = 0;
    for (k = c->p; k < c->q; k++, h = cq_clockwise(m, h))
        if (cqi_is_real_face(m, h)) cover->facet[cover->size++].h = h;
    if (cover->size) return;
    if (cqi_is_real_face(m, first)) cover->facet[cover->size++].h = first;
    if (cqi_is_real_face(m, h)) cover->facet[cover->size++].h = h;
    CQ_ASSERT(cover->size);
}

/* Reads the corners, and chooses the shift that keeps the bounds above: what is attached is within the error so far of
 * the old faces, whose corners are those of the cover and B. */
static void cqi_scale_cover(const cqi_plan *p, cqi_cover *cover, const cqi_collapse *c)
{
    const cq_mesh *m = &p->mesh;
    cqi_facet *f = cover->facet;
    cq_index last = CQ_NONE;
    int64_t corner = 0, reach;
    cqi_set_view(p, &cover->view, c->kept);
    for (; f < cover->facet + cover->size; f++) {
        const cq_index before = m->origin[cq_prev(f->h)];
        if (before == last) {
            f->u = f[-1].v;
        } else {
            f->u = cqi_see(p, &cover->view, before);
            corner = cqi_larger64(corner, cqi_largest(f->u));
        }
        last = cq_target(m, f->h);
        f->v = cqi_see(p, &cover->view, last);
        corner = cqi_larger64(corner, cqi_largest(f->v));
    }
    reach = cqi_larger64(corner, cqi_largest(cqi_see(p, &cover->view, c->removed))) + cqi_error_now(p) / 16 + 1;
    cover->view.shift = cqi_bit_length((uint32_t)(corner >> CQI_CORNER_BITS | reach >> (CQI_CORNER_BITS + 2)));
}

/* Sets the slack of the faces to the error so far. */
static void cqi_open_cover(const cqi_plan *p, cqi_cover *c)
{
    int k;
    c->slack = cqi_error_now(p) >> c->view.shift;
    if (c->view.shift) c->slack = c->slack > CQI_ROUNDED ? c->slack - CQI_ROUNDED : 0;
    for (k = 0; k < c->size; k++) cqi_set_slack(&c->facet[k], c->slack);
}

static void cqi_find_cover(const cqi_plan *p, cqi_cover *cover, const cqi_collapse *c)
{
    cqi_facet *f = cover->facet;
    cqi_list_cover(&p->mesh, c, cover);
    cqi_scale_cover(p, cover, c);
    for (; f < cover->facet + cover->size; f++) {
        f->list = &p->attached[f->h / 3];
        cqi_set_facet(f, cqi_shift64(f->u, cover->view.shift), cqi_shift64(f->v, cover->view.shift));
    }
    cqi_open_cover(p, cover);
}

/* -- Outside the cover --
 *
 * For vertices that no face of the cover is near enough to. */

/* An offset in units of 2^shift. */
static inline cqi_vector64 cqi_widened(cqi_vector a, int shift)
{
    cqi_vector64 x;
    x.x = cqi_floor_shift(a.x, shift);
    x.y = cqi_floor_shift(a.y, shift);
    x.z = cqi_floor_shift(a.z, shift);
    return x;
}

static inline uint32_t cqi_bits_of(cqi_vector a) { return cqi_abs(a.x) | cqi_abs(a.y) | cqi_abs(a.z); }

/* Makes the face of h the nearest one if it is real and nearer to v. */
static void cqi_try_face(const cqi_plan *p, cq_index h, cq_index v, cqi_nearest *n)
{
    const cq_mesh *m = &p->mesh;
    cqi_vector a, b, x;
    cqi_facet f;
    uint64_t square;
    uint32_t error;
    int shift;
    if (!cqi_is_real_face(m, h)) return;
    a = cqi_offset(p->measured, m->origin[h], m->origin[cq_prev(h)]);
    b = cqi_offset(p->measured, m->origin[h], cq_target(m, h));
    x = cqi_offset(p->measured, m->origin[h], v);
    shift = cqi_bit_length((cqi_bits_of(a) | cqi_bits_of(b) | cqi_bits_of(x)) >> CQI_CORNER_BITS);
    cqi_set_facet(&f, cqi_widened(a, shift), cqi_widened(b, shift));
    square = cqi_facet_square(&f, cqi_widened(x, shift));
    if (n->error == 0 || square > (uint64_t)(n->error - 1) * (n->error - 1)) return; /* not nearer, however rounded */
    error = cqi_error_of_square(square, shift);
    if (error >= n->error) return;
    n->error = error;
    n->h = h;
}

/* The vertex of the component that is nearest to v. */
static cq_index cqi_nearest_vertex(const cqi_plan *p, cq_index v)
{
    uint64_t least = UINT64_MAX;
    cq_index w = p->root, best = w;
    for (; w != CQ_NONE; w = p->decoded[w]) {
        const uint64_t square = cqi_square_distance(p->measured, v, w);
        if (square >= least || p->mesh.out[w] == CQ_NONE) continue;
        least = square;
        best = w;
    }
    return best;
}

/* Tries faces beside the nearest one so far, and around the nearest vertex. */
static void cqi_look_outside(cqi_plan *p, cq_index v, cqi_nearest *n)
{
    const cq_mesh *m = &p->mesh;
    cq_index h = n->h;
    int k;
    for (k = 0; k < 3; k++, h = cq_next(h)) cqi_try_face(p, m->twin[h], v, n);
    if (n->error <= cqi_error_now(p) || !p->looks) return;
    p->looks--;
    h = m->out[cqi_nearest_vertex(p, v)];
    for (k = 0; k < CQ_MAX_VALENCE; k++, h = cq_clockwise(m, h)) cqi_try_face(p, h, v, n);
}

/* -- Attaching --
 *
 * Moves what was attached to faces that a collapse replaces to faces of its cover. */

/* The list that takes x: that of the first face of the cover that x passes at, beginning with face number `from` and
 * going round; else that of the first face of which x passes an edge; else that of the rest. */
static inline cq_index *cqi_first_pass(cqi_cover *c, cqi_vector64 x, int from)
{
    int k;
    for (k = from; k < c->size; k++)
        if (cqi_passes(&c->facet[k], x)) return c->facet[k].list;
    for (k = 0; k < from; k++)
        if (cqi_passes(&c->facet[k], x)) return c->facet[k].list;
    for (k = 0; k < c->size; k++)
        if (cqi_passes_edge(&c->facet[k], x, c->slack)) return c->facet[k].list;
    return &c->rest;
}

/* The face of the cover that is nearest to x; *least: the square of its distance. */
static cq_index cqi_nearest_in_cover(const cqi_cover *c, cqi_vector64 x, uint64_t *least)
{
    cq_index h = c->facet[0].h;
    int k;
    *least = cqi_facet_square(&c->facet[0], x);
    for (k = 1; k < c->size; k++) {
        const uint64_t square = cqi_facet_square(&c->facet[k], x);
        if (square >= *least) continue;
        *least = square;
        h = c->facet[k].h;
    }
    return h;
}

/* A face near v, in the cover or outside. If even the nearest one that is found is too far away, the error grows. */
static cq_index cqi_nearest_face(cqi_plan *p, cqi_cover *c, cq_index v)
{
    cqi_nearest n;
    uint64_t square;
    n.h = cqi_nearest_in_cover(c, cqi_see(p, &c->view, v), &square);
    if (square <= (uint64_t)c->slack * c->slack) return n.h;
    n.error = cqi_error_of_square(square, c->view.shift);
    cqi_look_outside(p, v, &n);
    if (n.error <= cqi_error_now(p)) return n.h;
    p->level_error[p->level] = cqi_error_code(n.error);
    cqi_open_cover(p, c);
    return n.h;
}

static void cqi_push(cqi_plan *p, cq_index *list, cq_index v)
{
    p->follower[v] = *list;
    *list = v;
}

/* Attaches the vertices of a list that pass, trying face `from` first; the others go to c->rest. */
static void cqi_attach_passing(cqi_plan *p, cqi_cover *c, cq_index v, int from)
{
    while (v != CQ_NONE) {
        const cq_index next = p->follower[v];
        cqi_push(p, cqi_first_pass(c, cqi_see(p, &c->view, v), from), v);
        v = next;
    }
}

static void cqi_attach_rest(cqi_plan *p, cqi_cover *c)
{
    while (c->rest != CQ_NONE) {
        const cq_index v = c->rest;
        c->rest = p->follower[v];
        cqi_push(p, &p->attached[cqi_nearest_face(p, c, v) / 3], v);
    }
}

static cq_index cqi_detach(cq_index *list)
{
    const cq_index v = *list;
    *list = CQ_NONE;
    return v;
}

static void cqi_measure_collapse(cqi_plan *p, const cqi_collapse *c)
{
    cqi_cover cover;
    cq_index first[CQ_MAX_VALENCE];
    int k;
    cqi_find_cover(p, &cover, c);
    for (k = 0; k < cover.size; k++) first[k] = cqi_detach(cover.facet[k].list);
    cover.rest = p->follower[c->removed] = CQ_NONE;
    cqi_attach_passing(p, &cover, c->removed, 0);
    for (k = 0; k < cover.size; k++) cqi_attach_passing(p, &cover, first[k], k);
    cqi_attach_passing(p, &cover, cqi_detach(&p->attached[c->face[0]]), 0);
    cqi_attach_passing(p, &cover, cqi_detach(&p->attached[c->face[1]]), cover.size - 1);
    cqi_attach_rest(p, &cover);
}

/* Prefetches a face of a cover; */
static CQI_INLINED void cqi_expect_face(const cqi_plan *p, cq_index h)
{
    CQI_SOON(&p->mesh.twin[h]);
    CQI_SOON(&p->mesh.origin[h]);
    CQI_SOON(&p->attached[h / 3]);
}

/* the first vertex that is attached to a face; */
static CQI_INLINED void cqi_expect_list(const cqi_plan *p, cq_index f)
{
    const cq_index v = p->attached[f];
    if (v == CQ_NONE) return;
    CQI_SOON(&p->follower[v]);
    CQI_SOON(&p->measured[3 * (size_t)v]);
}

/* and what the collapses after this one need. */
static CQI_INLINED void cqi_expect_covers(const cqi_plan *p, const cqi_collapse *c)
{
    const cqi_collapse *const far = c + CQI_FETCH_AHEAD, *const near = c + CQI_FETCH_AHEAD / 2;
    CQI_SOON(&p->mesh.out[far->kept]);
    CQI_SOON(&p->measured[3 * (size_t)far->kept]);
    CQI_SOON(&p->measured[3 * (size_t)far->removed]);
    CQI_SOON(&p->attached[far->face[0]]);
    CQI_SOON(&p->attached[far->face[1]]);
    cqi_expect_list(p, near->face[0]);
    cqi_expect_list(p, near->face[1]);
    cqi_expect_face(p, p->mesh.out[near->kept]);
    cqi_expect_face(p, cq_clockwise(&p->mesh, p->mesh.out[c[CQI_FETCH_AHEAD / 4].kept]));
}

/* Measures the error of a level, whose collapses begin with this note. */
static void cqi_measure_level(cqi_plan *p, cq_index root, cq_index note)
{
    uint8_t *code = &p->level_error[p->level];
    if (code[0] < code[-1]) code[0] = code[-1];
    p->root = root;
    p->looks = CQI_LOOKS + (p->level > p->num_regular + 1 ? p->looks : 0);
    for (; note < p->num_notes; note++) {
        if (p->num_notes - note > CQI_MANY) cqi_expect_covers(p, &p->note[note]);
        cqi_measure_collapse(p, &p->note[note]);
    }
}

/* -- Encoder: wedges of an edge that is collapsed --
 *
 * B's corners go to A with their wedges. Where one of the two faces joins a wedge of B to a wedge of A, and both are
 * also in other faces, the two are tied: they become one, A's, of which the split will make two again. An edge may only
 * be collapsed if the split can name the wedges of all six corners, see cqi_code_corners. */

#ifdef CQ_NO_WEDGES
static int cqi_may_be_removed(const cqi_plan *p, cq_index h)
{
    return !p->locked || !p->locked[cq_target(&p->mesh, h)];
}
#define cqi_collapse_wedges(p, h, c) ((void)0)
#define cqi_undo_wedges(p, c, first, last) ((void)0)
#else

static cq_index cqi_wedge_at(const cqi_plan *p, cq_index h)
{
    return h / 3 < p->mesh.first_virtual_face ? p->index[h] : CQ_NONE;
}

/* Is the edge a seam at the origin of h? */
static int cqi_is_seam(const cqi_plan *p, cq_index h)
{
    return p->index && cqi_seam_class(cqi_wedge_at(p, h), cqi_wedge_at(p, cq_clockwise(&p->mesh, h))) == 1;
}

/* Does a corner strictly between two spokes, clockwise, have the wedge? */
static int cqi_is_between(const cqi_plan *p, cq_index from, cq_index to, cq_index wedge)
{
    cq_index s = cq_clockwise(&p->mesh, from);
    while (s != to && cqi_wedge_at(p, s) != wedge) s = cq_clockwise(&p->mesh, s);
    return s != to;
}

/* Wedges of the corners of the two faces at h = A -> B. */
static void cqi_list_corners(const cqi_plan *p, cq_index h, cq_index *corner)
{
    const cq_index t = p->mesh.twin[h];
    corner[CQI_LEFT_A] = cqi_wedge_at(p, h);
    corner[CQI_LEFT_B] = cqi_wedge_at(p, cq_next(h));
    corner[CQI_AT_P] = cqi_wedge_at(p, cq_prev(h));
    corner[CQI_RIGHT_A] = cqi_wedge_at(p, cq_next(t));
    corner[CQI_RIGHT_B] = cqi_wedge_at(p, t);
    corner[CQI_AT_Q] = cqi_wedge_at(p, cq_prev(t));
}

/* On which sides a wedge of B is tied to one of A: CQI_TIED_LEFT and CQI_TIED_RIGHT. If the left side is tied, the
 * right one is not if it has the same wedge of A or of B. */
static int cqi_tied(const cqi_plan *p, cq_index h, const cq_index *corner)
{
    const cq_index t = p->mesh.twin[h], at_a = cq_next(t), at_b = cq_next(h);
    const int left = corner[CQI_LEFT_B] != CQ_NONE && cqi_is_between(p, at_b, t, corner[CQI_LEFT_B]) &&
                     cqi_is_between(p, at_a, h, corner[CQI_LEFT_A]);
    int right = corner[CQI_RIGHT_B] != CQ_NONE && cqi_is_between(p, at_b, t, corner[CQI_RIGHT_B]) &&
                cqi_is_between(p, at_a, h, corner[CQI_RIGHT_A]);
    if (left && (corner[CQI_RIGHT_B] == corner[CQI_LEFT_B] || corner[CQI_RIGHT_A] == corner[CQI_LEFT_A])) right = 0;
    return (left ? CQI_TIED_LEFT : 0) | (right ? CQI_TIED_RIGHT : 0);
}

/* Can the split name the wedge of each corner: as one of its choices, or as one that is nowhere else? */
static int cqi_can_be_named(const cqi_plan *p, cq_index h, const cq_index *corner)
{
    const cq_mesh *m = &p->mesh;
    const cq_index t = m->twin[h], at_a = cq_next(t), at_b = cq_next(h);
    const cq_index *c = corner;
    const cq_index to_p = m->twin[cq_prev(h)], from_p = m->twin[at_b], from_q = m->twin[at_a],
                   to_q = m->twin[cq_prev(t)];
    if (c[CQI_LEFT_A] != CQ_NONE) {
        if (c[CQI_LEFT_A] != cqi_wedge_at(p, to_p) && cqi_is_between(p, at_a, h, c[CQI_LEFT_A])) return 0;
        if (c[CQI_LEFT_B] != cqi_wedge_at(p, cq_next(from_p)) && cqi_is_between(p, at_b, t, c[CQI_LEFT_B])) return 0;
        if (c[CQI_AT_P] != cqi_wedge_at(p, cq_next(to_p)) && c[CQI_AT_P] != cqi_wedge_at(p, from_p) &&
            p->uses[c[CQI_AT_P]] > 1)
            return 0;
    }
    if (c[CQI_RIGHT_A] != CQ_NONE) {
        if (c[CQI_RIGHT_A] != cqi_wedge_at(p, cq_next(from_q)) && c[CQI_RIGHT_A] != c[CQI_LEFT_A] &&
            cqi_is_between(p, at_a, h, c[CQI_RIGHT_A]))
            return 0;
        if (c[CQI_RIGHT_B] != cqi_wedge_at(p, to_q) && c[CQI_RIGHT_B] != c[CQI_LEFT_B] &&
            cqi_is_between(p, at_b, t, c[CQI_RIGHT_B]))
            return 0;
        if (c[CQI_AT_Q] != cqi_wedge_at(p, from_q) && c[CQI_AT_Q] != cqi_wedge_at(p, cq_next(to_q)) &&
            p->uses[c[CQI_AT_Q]] > 1)
            return 0;
    }
    return 1;
}

/* Would a wedge of B move to A, so that a row of the decoder moves back? */
static int cqi_moves_a_wedge(const cqi_plan *p, cq_index h, const cq_index *corner, int tied)
{
    const cq_index t = p->mesh.twin[h];
    cq_index s = cq_clockwise(&p->mesh, cq_next(h));
    for (; s != t; s = cq_clockwise(&p->mesh, s)) {
        const cq_index wedge = cqi_wedge_at(p, s);
        if (wedge == CQ_NONE || (tied & CQI_TIED_LEFT && wedge == corner[CQI_LEFT_B])) continue;
        if (!(tied & CQI_TIED_RIGHT) || wedge != corner[CQI_RIGHT_B]) return 1;
    }
    return 0;
}

/* May B be removed, as far as its wedges and locks decide? */
static int cqi_may_be_removed(const cqi_plan *p, cq_index h)
{
    cq_index corner[CQI_CORNERS];
    if (p->locked && p->locked[cq_target(&p->mesh, h)]) return 0;
    if (!p->index) return 1;
    cqi_list_corners(p, h, corner);
    if (!cqi_can_be_named(p, h, corner)) return 0;
    return !p->clean || !cqi_moves_a_wedge(p, h, corner, cqi_tied(p, h, corner));
}

static void cqi_rename(cqi_plan *p, cq_index h, cq_index from, cq_index to)
{
    if (cqi_wedge_at(p, h) != from) return;
    p->index[h] = to;
    p->uses[from]--;
    p->uses[to]++;
}

static void cqi_count_corners_of(cqi_plan *p, const cq_index *corner, int change)
{
    int k;
    for (k = 0; k < CQI_CORNERS; k++)
        if (corner[k] != CQ_NONE) p->uses[corner[k]] = (cq_index)(p->uses[corner[k]] + (cq_index)change);
}

/* Changes the wedges for the collapse of h, which comes next, and notes how. */
static void cqi_collapse_wedges(cqi_plan *p, cq_index h, cqi_collapse *c)
{
    cq_index corner[CQI_CORNERS], s;
    const cq_index t = p->mesh.twin[h];
    int tied;
    if (!p->index) return;
    cqi_list_corners(p, h, corner);
    tied = cqi_tied(p, h, corner);
    c->first = (uint8_t)(c->first | tied | (int)(h % 3) << CQI_CORNER_A | (int)(t % 3) << CQI_CORNER_B);
    for (s = cq_clockwise(&p->mesh, cq_next(h)); s != t; s = cq_clockwise(&p->mesh, s)) {
        if (tied & CQI_TIED_LEFT) cqi_rename(p, s, corner[CQI_LEFT_B], corner[CQI_LEFT_A]);
        if (tied & CQI_TIED_RIGHT) cqi_rename(p, s, corner[CQI_RIGHT_B], corner[CQI_RIGHT_A]);
    }
    cqi_count_corners_of(p, corner, -1);
}

/* Undoes that, before the split that undoes the collapse: in B's corners, and in the two faces, with their corners in
 * the order in which the split makes them. */
static void cqi_undo_wedges(cqi_plan *p, const cqi_collapse *c, cq_index first, cq_index last)
{
    cq_index s = first, corner[CQI_CORNERS];
    if (!p->index) return;
    cqi_removed_corners(p, c, corner);
    while (s != last) {
        s = cq_clockwise(&p->mesh, s);
        if (c->first & CQI_TIED_LEFT) cqi_rename(p, s, corner[CQI_LEFT_A], corner[CQI_LEFT_B]);
        if (c->first & CQI_TIED_RIGHT) cqi_rename(p, s, corner[CQI_RIGHT_A], corner[CQI_RIGHT_B]);
    }
    if (corner[CQI_LEFT_A] != CQ_NONE)
        cqi_set_face_rows(p->index + 3 * (size_t)c->face[0], corner[CQI_AT_P], corner[CQI_LEFT_A], corner[CQI_LEFT_B]);
    if (corner[CQI_RIGHT_A] != CQ_NONE)
        cqi_set_face_rows(p->index + 3 * (size_t)c->face[1], corner[CQI_RIGHT_A], corner[CQI_AT_Q],
                          corner[CQI_RIGHT_B]);
    cqi_count_corners_of(p, corner, 1);
}

#endif

/* -- Choosing collapses --
 *
 * Conquers the mesh as the decoder will, patch by patch, and collapses an edge in each patch that has one. */

/* All neighbours of A; and of those that could be collapsed into A, the spokes, and the squared distances, once they
 * are needed. */
typedef struct cqi_candidates {
    int size, all;
    cq_index neighbour[CQ_MAX_VALENCE];
    cq_index vertex[CQ_MAX_VALENCE], spoke[CQ_MAX_VALENCE];
    uint64_t square[CQ_MAX_VALENCE]; /* UINT64_MAX: not yet computed */
} cqi_candidates;

static uint64_t cqi_candidate_square(const cqi_plan *p, cqi_candidates *c, int k)
{
    if (c->square[k] == UINT64_MAX)
        c->square[k] = cqi_square_distance(p->positions, p->mesh.origin[c->spoke[k]], c->vertex[k]);
    return c->square[k];
}

/* Is candidate k better than another one: of smaller valence, or with CQ_BALANCED nearer? */
static int cqi_is_better(const cqi_plan *p, cqi_candidates *c, int k, int than)
{
    const cq_index valence = p->mesh.valence[c->vertex[k]], other = p->mesh.valence[c->vertex[than]];
    if (valence != other || !p->positions) return valence < other;
    return cqi_candidate_square(p, c, k) < cqi_candidate_square(p, c, than);
}

/* Lists the spokes to available neighbours, clockwise from the first spoke, and marks all neighbours. The first and the
 * last neighbour must stay: so the faces at the first spoke stay, and B's part of the ring is in one piece. */
static void cqi_list_candidates(const cq_mesh *m, cq_index spoke, cqi_candidates *c, int *boundary)
{
    const cq_index *const origin = m->origin, *const twin = m->twin;
    cq_index h = spoke;
    int size = 0, all = 0, any_virtual = 0;
    do {
        const cq_index in = twin[h], b = origin[in];
        uint8_t *const mark = m->mark + b;
        any_virtual |= cq_is_virtual(m, b);
        if ((*mark & CQI_STATE) == CQI_FREE && all) {
            c->square[size] = UINT64_MAX;
            c->vertex[size] = b;
            c->spoke[size++] = h;
        }
        *mark |= CQI_SCRATCH;
        c->neighbour[all++] = b;
        h = cq_next(in);
    } while (h != spoke);
    *boundary = any_virtual;
    c->all = all;
    c->size = size && c->vertex[size - 1] == c->neighbour[all - 1] ? size - 1 : size;
}

/* Takes the best of the candidates out of the list, the first of equal ones. */
static cq_index cqi_take_candidate(const cqi_plan *p, cqi_candidates *c)
{
    int best = 0, k;
    cq_index h;
    for (k = 1; k < c->size; k++)
        if (cqi_is_better(p, c, k, best)) best = k;
    h = c->spoke[best];
    for (c->size--, k = best; k < c->size; k++) {
        c->spoke[k] = c->spoke[k + 1];
        c->vertex[k] = c->vertex[k + 1];
        c->square[k] = c->square[k + 1];
    }
    return h;
}

/* The halfedge A -> B from the spoke's origin A to the best neighbour B that can be collapsed into it, with no larger
 * error than this level allows. CQ_NONE: the patch is isolated. */
static cq_index cqi_choose(cqi_plan *p, cq_index spoke)
{
    const cq_mesh *m = &p->mesh;
    cq_index chosen = CQ_NONE;
    cqi_candidates c;
    int boundary, k;
    if (m->valence[m->origin[spoke]] > CQ_MAX_VALENCE) return CQ_NONE;
    cqi_list_candidates(m, spoke, &c, &boundary);
    while (c.size && chosen == CQ_NONE) {
        const cq_index h = cqi_take_candidate(p, &c);
        if (cqi_keeps_valences(m, h, CQ_MAX_VALENCE) && cqi_may_be_removed(p, h) && cqi_allows(p, h, boundary))
            chosen = h;
    }
    for (k = 0; k < c.all; k++) m->mark[c.neighbour[k]] &= (uint8_t)~CQI_SCRATCH;
    return chosen;
}

/* The place of a spoke on the ring that begins with another. */
static int cqi_spoke_number(const cq_mesh *m, cq_index spoke, cq_index wanted)
{
    int n = 0;
    for (; spoke != wanted; spoke = cq_clockwise(m, spoke)) n++;
    return n;
}

/* Notes the collapse of h = A -> B, but for p and q. first: 0, or 1 + the side of a first gate. */
static void cqi_note_collapse(cqi_plan *p, cq_index h, int first)
{
    cq_mesh *m = &p->mesh;
    cqi_collapse *c = &p->note[p->num_notes++];
    c->kept = m->origin[h];
    c->removed = cq_target(m, h);
    c->face[0] = (cq_index)(h / 3);
    c->face[1] = (cq_index)(m->twin[h] / 3);
    c->level = (uint8_t)p->level;
    c->first = (uint8_t)first;
}

/* Undoes the last collapse. */
static void cqi_undo_collapse(cqi_plan *p)
{
    const cqi_collapse *c = &p->note[--p->num_notes];
    const cq_index first = p->mesh.out[c->kept];
    cq_index last = first;
    int k;
    for (k = c->p; k < c->q; k++) last = cq_clockwise(&p->mesh, last);
    cqi_undo_wedges(p, c, first, last);
    cq_mesh_split(&p->mesh, first, last);
}

/* Holds the ring of the spoke's origin, and lists its spokes: what is needed of cqi_read_ring. */
static void cqi_hold_ring(cq_mesh *m, cqi_ring *r, cq_index spoke)
{
    const cq_index *const origin = m->origin, *const twin = m->twin;
    cq_index h = spoke;
    int n = 0;
    do {
        const cq_index in = twin[h];
        uint8_t *const mark = m->mark + origin[in];
        *mark = (uint8_t)(*mark + ((*mark & CQI_STATE) < CQI_HELD_OFTEN));
        r->spoke[n++] = h;
        h = cq_next(in);
    } while (h != spoke);
    r->size = n;
}

/* Conquers a patch: collapses h into its centre, unless that is CQ_NONE. A centre of too large a valence is passed
 * over. */
static void cqi_conquer_patch(cqi_plan *p, cq_index spoke, cq_index h, int first)
{
    cq_mesh *m = &p->mesh;
    const cq_index centre = m->origin[spoke];
    cqi_take_vertex(m, centre);
    if (m->valence[centre] > CQ_MAX_VALENCE) {
        p->passed[centre] = (uint8_t)p->level;
        cqi_queue_neighbours(m, &p->walk, spoke);
        return;
    }
    if (h != CQ_NONE) {
        cqi_collapse *c = &p->note[p->num_notes];
        const cq_index removed = cq_target(m, h);
        cq_index to_p, to_q;
        c->p = (uint8_t)(cqi_spoke_number(m, spoke, h) - 1);
        c->q = (uint8_t)(c->p + m->valence[removed] - 2); /* all neighbours of B but A */
        cqi_note_collapse(p, h, first);
        cqi_collapse_wedges(p, h, c);
        cq_mesh_collapse(m, h, &to_p, &to_q);
        m->mark[removed] = CQI_TAKEN;
    }
    cqi_hold_ring(m, &p->ring, spoke);
    cqi_queue_fronts(m, &p->walk, &p->ring);
}

/* The three cases of a first gate, in the order in which they are tried: by the valence of the centre, since a large
 * patch leaves few vertices to others. Further tries of a level begin with the second or the third. */
static void cqi_order_sides(const cq_mesh *m, cq_index gate, int try_number, int *order)
{
    int k, j;
    for (k = 0; k < 3; k++) {
        const cq_index valence = m->valence[m->origin[cqi_first_spoke(m, gate, k)]];
        for (j = k; j && m->valence[m->origin[cqi_first_spoke(m, gate, order[j - 1])]] > valence; j--)
            order[j] = order[j - 1];
        order[j] = k;
    }
    for (; try_number; try_number--) {
        const int first = order[0];
        order[0] = order[1];
        order[1] = order[2];
        order[2] = first;
    }
}

/* Conquers the first patch of a component. It contains L, R and the front vertex, of which L and R stay. If nothing can
 * be collapsed in it, its centre is the front vertex. */
static void cqi_conquer_first_patch(cqi_plan *p, const cqi_seed *seed)
{
    cq_mesh *m = &p->mesh;
    const cq_index gate = cqi_find_spoke(m, seed->l, seed->r);
    cq_index h = CQ_NONE, spoke = CQ_NONE;
    int order[3], k, side = 0;
    cqi_order_sides(m, gate, p->tries, order);
    cqi_hold(m, seed->l);
    cqi_hold(m, seed->r);
    for (k = 0; k < 3 && h == CQ_NONE; k++) {
        side = order[k];
        spoke = cqi_first_spoke(m, gate, side);
        h = cqi_choose(p, spoke);
    }
    if (h == CQ_NONE) spoke = cqi_first_spoke(m, gate, 0);
    cqi_conquer_patch(p, spoke, h, h == CQ_NONE ? 0 : 1 + side);
}

/* Clears the marks of those vertices of a component that are left, unlists the others, and returns how many are
 * left. */
static cq_index cqi_clear_component(cqi_plan *p, cq_index root)
{
    cq_mesh *m = &p->mesh;
    cq_index v = root, *link = NULL, n = 0;
    for (; v != CQ_NONE; v = p->decoded[v]) {
        if (m->out[v] == CQ_NONE && link) {
            *link = p->decoded[v];
            continue;
        }
        m->mark[v] = CQI_FREE;
        if (p->passed[v] == p->level) p->passed[v] = 0; /* by a try that was not worth it */
        n = (cq_index)(n + (m->out[v] != CQ_NONE));
        link = &p->decoded[v];
    }
    return n;
}

/* Simplifies a component by one level. 0: it removed too few vertices, and the mesh is unchanged. */
static int cqi_simplify(cqi_plan *p, const cqi_seed *seed)
{
    const cq_index before = cqi_clear_component(p, seed->notes), notes = p->num_notes;
    cq_index kept, splits, v;
    p->walk.head = p->walk.count = 0;
    p->walk.full = 0;
    cqi_conquer_first_patch(p, seed);
    while ((v = cqi_dequeue(&p->mesh, &p->walk)) != CQ_NONE) {
        const cq_index spoke = p->mesh.out[v];
        cqi_conquer_patch(p, spoke, cqi_choose(p, spoke), 0);
    }
    splits = (cq_index)(p->num_notes - notes);
    kept = (cq_index)(before - splits);
    if (p->walk.full || splits < (p->most_quadric == CQI_ANY_QUADRIC ? CQI_MIN_SPLITS(kept) : CQI_WORTH(kept))) {
        while (p->num_notes > notes) cqi_undo_collapse(p);
        return 0;
    }
    return 1;
}

/* Union-find with path halving: the vertex that stands for all that are known to be connected with v. */
static cq_index cqi_find_root(cq_index *parent, cq_index v)
{
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

static void cqi_union(cq_index *parent, cq_index a, cq_index b)
{
    if (parent[a] == parent[b]) return;
    a = cqi_find_root(parent, a);
    b = cqi_find_root(parent, b);
    parent[a < b ? b : a] = a < b ? a : b;
}

/* Finds the components. The first gate of each is the first halfedge of its first face; the vertices of each are listed
 * through p->decoded, beginning with the smallest. `parent` is scratch. */
static void cqi_find_components(cqi_plan *p, cq_index *parent)
{
    cq_mesh *m = &p->mesh;
    cq_index *next = p->decoded, v, f;
    for (v = 0; v < m->num_vertices; v++) parent[v] = v;
    for (f = 0; f < m->num_faces; f++) {
        if (!cqi_is_face(m, f)) continue;
        cqi_union(parent, m->origin[3 * f], m->origin[3 * f + 1]);
        cqi_union(parent, m->origin[3 * f], m->origin[3 * f + 2]);
    }
    for (v = 0; v < m->num_vertices; v++) next[v] = CQ_NONE;
    for (v = m->num_vertices; v--;) {
        const cq_index root = cqi_find_root(parent, v);
        if (root == v) continue;
        next[v] = next[root];
        next[root] = v;
    }
    p->num_seeds = 0;
    for (f = 0; f < m->num_faces; f++) {
        const cq_index root = cqi_is_face(m, f) ? cqi_find_root(parent, m->origin[3 * f]) : CQ_NONE;
        cqi_seed *s = &p->seed[p->num_seeds];
        if (root == CQ_NONE || m->mark[root]) continue;
        m->mark[root] = 1;
        s->l = m->origin[3 * f];
        s->r = m->origin[3 * f + 1];
        s->notes = root;
        p->num_seeds++;
    }
}

/* -- Encoder: preparation --
 *
 * The triangles, whose corners are rows, become an oriented manifold: faces that no surface can have go aside,
 * halfedges are glued in pairs, and the corners that glued edges join, a fan, become one vertex. cq_preparation tells
 * what it took. Nearly all of it is sorting, in linear time except for rows, and uses nothing but the caller's memory.
 *
 * Halfedges are numbered here through the faces that stay, in the orientation that the mesh will have. */

#ifndef CQ_NO_WEDGES

enum { CQI_FACE_CUT_OFF = 4 }; /* bit of the state of a face, beside CQI_FACE_ASIDE and _TURNED */

/* What makes two ends of halfedges equal: the row, its values, its place, or the fan. */
enum { CQI_BY_ROW, CQI_BY_VALUES, CQI_BY_PLACE, CQI_BY_FAN };

typedef struct cqi_preparer {
    const cq_input *in;
    cq_preparation counts;
    const cq_value *positions;         /* NULL: there are none, or only exact ones */
    int located;                       /* 1: there are positions; equal ones are one place */
    cq_index num_faces;                /* of those that stay */
    uint8_t *state;                    /* of each face of the input */
    uint8_t *locked;                   /* of each fan */
    cq_index *same;                    /* of each row: the first one with the same values */
    cq_index *place;                   /* and its place: rows equal in the channels per mesh vertex share one */
    cq_index *source;                  /* of each face that stays: its number in the input */
    cq_index *sorted, *twin, *list, *fan; /* [3 * num_faces] */
    cq_index *row;                     /* [3 * num_faces] that of each corner, in the order of the turned faces */
    cq_index *count;                   /* [rows, or 3 * num_faces if that is more], scratch */
    cq_index num_fans, num_wedges, num_aside;
    cq_index num_glued;                /* pairs, but for those glued by their rows */
    cq_index num_open, num_loops;      /* halfedges without a twin, and the loops that they form */
} cqi_preparer;

/* -- Rows with the same values --
 *
 * Sorts rows: those with the same values of the channels per mesh vertex, such as positions, are at one place; those
 * with the same values of all channels are one row. */

/* Orders two rows by the channels per mesh vertex, or by those per row: below, equal to or above 0. */
static int cqi_compare_rows(const cq_input *in, cq_index a, cq_index b, int of_row)
{
    uint32_t k, c;
    for (k = 0; k < in->shape.num_channels; k++) {
        const uint32_t n = in->shape.channel[k].components;
        if (in->shape.channel[k].merge == CQ_PER_FACE || cqi_is_of_corner(in->shape.channel[k].kind) != of_row) continue;
        for (c = 0; c < n; c++) {
            const cq_value x = in->values[k][(size_t)a * n + c], y = in->values[k][(size_t)b * n + c];
            if (x != y) return x < y ? -1 : 1;
        }
    }
    return 0;
}

static int cqi_row_is_less(const cq_input *in, cq_index a, cq_index b)
{
    int order = cqi_compare_rows(in, a, b, 0);
    if (!order) order = cqi_compare_rows(in, a, b, 1);
    return order ? order < 0 : a < b;
}

/* Orders the edges of two halfedges by the places of their ends, whichever way they run. */
static int cqi_compare_edges(const cq_input *in, const cq_mesh *m, cq_index g, cq_index h)
{
    const cq_index a = m->origin[g], b = cq_target(m, g), c = m->origin[h], d = cq_target(m, h);
    const int first = cqi_compare_rows(in, a, b, 0) < 0, second = cqi_compare_rows(in, c, d, 0) < 0;
    const int order = cqi_compare_rows(in, first ? a : b, second ? c : d, 0);
    return order ? order : cqi_compare_rows(in, first ? b : a, second ? d : c, 0);
}

/* Order of halfedges if there is a mesh, else of rows. */
static int cqi_is_less(const cq_input *in, const cq_mesh *m, cq_index a, cq_index b)
{
    return m ? cqi_compare_edges(in, m, a, b) < 0 : cqi_row_is_less(in, a, b);
}

/* Heapsort: sinks an element of the heap of n. */
static void cqi_sink(const cq_input *in, const cq_mesh *m, cq_index *heap, size_t at, size_t n)
{
    const cq_index element = heap[at];
    size_t child;
    while ((child = 2 * at + 1) < n) {
        if (child + 1 < n && cqi_is_less(in, m, heap[child], heap[child + 1])) child++;
        if (!cqi_is_less(in, m, element, heap[child])) break;
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = element;
}

static void cqi_sort(const cq_input *in, const cq_mesh *m, cq_index *list, size_t n)
{
    size_t k;
    for (k = n / 2; k--;) cqi_sink(in, m, list, k, n);
    for (k = n; k > 1; k--) {
        const cq_index last = list[k - 1];
        list[k - 1] = list[0];
        list[0] = last;
        cqi_sink(in, m, list, 0, k - 1);
    }
}

static void cqi_find_places(cqi_preparer *p)
{
    const cq_index n = (cq_index)p->in->shape.num_vertices;
    cq_index *const rows = p->count, k, places = 0;
    for (k = 0; k < n; k++) rows[k] = p->same[k] = p->place[k] = k;
    if (!p->located) return;
    cqi_sort(p->in, NULL, rows, n);
    for (k = 0; k < n; k++) {
        const int here = k && !cqi_compare_rows(p->in, rows[k - 1], rows[k], 0);
        places = (cq_index)(places + !here);
        p->place[rows[k]] = (cq_index)(places - 1);
        if (here && !cqi_compare_rows(p->in, rows[k - 1], rows[k], 1)) p->same[rows[k]] = p->same[rows[k - 1]];
    }
}

/* -- Keys of halfedges, and sorting by them --
 *
 * Edges are compared by a key of each end, see CQI_BY_ROW; sorting brings halfedges of the same edge together. */

static cq_index cqi_key(const cqi_preparer *p, int by, cq_index h)
{
    if (by == CQI_BY_FAN) return p->fan[h];
    return by == CQI_BY_ROW ? p->row[h] : by == CQI_BY_VALUES ? p->same[p->row[h]] : p->place[p->row[h]];
}

static cq_index cqi_edge_key(const cqi_preparer *p, int by, cq_index h, int larger)
{
    const cq_index a = cqi_key(p, by, h), b = cqi_key(p, by, cq_next(h));
    return (a < b) == larger ? b : a;
}

static int cqi_same_keys(const cqi_preparer *p, int by, cq_index g, cq_index h)
{
    return cqi_edge_key(p, by, g, 0) == cqi_edge_key(p, by, h, 0) &&
           cqi_edge_key(p, by, g, 1) == cqi_edge_key(p, by, h, 1);
}

/* All keys are below this number. */
static cq_index cqi_num_keys(const cqi_preparer *p, int by)
{
    return by == CQI_BY_FAN ? (cq_index)(3 * p->num_faces) : (cq_index)p->in->shape.num_vertices;
}

/* Sorts a list of halfedges by the larger or the smaller end of their edges, stably. */
static void cqi_sort_by_end(const cqi_preparer *p, int by, int larger, const cq_index *from, cq_index *to, cq_index n)
{
    cq_index k;
    memset(p->count, 0, cqi_num_keys(p, by) * sizeof(cq_index));
    for (k = 0; k < n; k++) p->count[cqi_edge_key(p, by, from[k], larger)]++;
    cqi_sum_counts(p->count, cqi_num_keys(p, by));
    for (k = 0; k < n; k++) to[p->count[cqi_edge_key(p, by, from[k], larger)]++] = from[k];
}

/* Lists halfedges in the order of their edges: all, or those that are open, or one of each edge. Returns their
 * number. */
enum { CQI_ALL, CQI_OPEN, CQI_ONCE };
static cq_index cqi_list_edges(const cqi_preparer *p, int by, int which)
{
    cq_index h, n = 0;
    for (h = 0; h < 3 * p->num_faces; h++)
        if (which == CQI_ALL || p->twin[h] == CQ_NONE || (which == CQI_ONCE && h < p->twin[h])) p->list[n++] = h;
    cqi_sort_by_end(p, by, 1, p->list, p->sorted, n);
    cqi_sort_by_end(p, by, 0, p->sorted, p->list, n);
    return n;
}

/* The end of the group of halfedges that are of the same edge as the one at `begin` in the list. */
static cq_index cqi_group_end(const cqi_preparer *p, int by, cq_index begin, cq_index n)
{
    cq_index end = (cq_index)(begin + 1);
    while (end < n && cqi_same_keys(p, by, p->list[begin], p->list[end])) end++;
    return end;
}

/* -- Faces that go aside --
 *
 * Faces with two corners in one place, and all but the first of faces with the same rows. */

/* Key number k of a face's corners, in ascending order. */
static cq_index cqi_face_key(const cqi_preparer *p, const cq_index *of, cq_index face, int k)
{
    const cq_index *const rows = p->in->indices + 3 * (size_t)face;
    const cq_index a = of[rows[0]], b = of[rows[1]], c = of[rows[2]];
    const cq_index low = a < b ? a : b, high = a < b ? b : a;
    if (k == 0) return low < c ? low : c;
    if (k == 2) return high > c ? high : c;
    return c < low ? low : c > high ? high : c;
}

/* Sorts the faces in p->list by their keys, into p->twin; p->sorted is scratch. */
static void cqi_sort_faces(const cqi_preparer *p, const cq_index *of, cq_index n)
{
    const cq_index keys = (cq_index)p->in->shape.num_vertices;
    cq_index *from = p->list, *to = p->twin, j;
    int k;
    for (k = 2; k >= 0; k--) {
        memset(p->count, 0, keys * sizeof(cq_index));
        for (j = 0; j < n; j++) p->count[cqi_face_key(p, of, from[j], k)]++;
        cqi_sum_counts(p->count, keys);
        for (j = 0; j < n; j++) to[p->count[cqi_face_key(p, of, from[j], k)]++] = from[j];
        from = to;
        to = k == 2 ? p->sorted : p->twin;
    }
}

static int cqi_same_face(const cqi_preparer *p, const cq_index *of, cq_index a, cq_index b)
{
    int k;
    for (k = 0; k < 3; k++)
        if (cqi_face_key(p, of, a, k) != cqi_face_key(p, of, b, k)) return 0;
    return 1;
}

static void cqi_put_faces_aside(cqi_preparer *p)
{
    cq_index f, n = 0;
    for (f = 0; f < p->in->shape.num_faces; f++) {
        const cq_index a = cqi_face_key(p, p->place, f, 0), b = cqi_face_key(p, p->place, f, 1);
        p->state[f] = a == b || b == cqi_face_key(p, p->place, f, 2) ? CQI_FACE_ASIDE : 0;
        if (!p->state[f]) p->list[n++] = f;
        else p->counts.degenerate_faces++;
    }
    cqi_sort_faces(p, p->same, n);
    for (f = 1; f < n; f++) {
        if (!cqi_same_face(p, p->same, p->twin[f - 1], p->twin[f])) continue;
        p->state[p->twin[f]] = CQI_FACE_ASIDE;
        p->counts.repeated_faces++;
    }
    for (f = 0; f < p->in->shape.num_faces; f++) {
        if (p->state[f]) continue;
        memcpy(p->row + 3 * (size_t)p->num_faces, p->in->indices + 3 * (size_t)f, 3 * sizeof(cq_index));
        p->source[p->num_faces++] = f;
    }
}

/* -- Faces that are turned over --
 *
 * Where an edge has just two faces, they should run along it in opposite directions. Faces that are connected by such
 * edges form a sheet; of each sheet the smaller part is turned over. */

/* Union-find with path compression, for sheets: the root of a face, and whether just one of the two is to be turned.
 * parent[f] is 2 * the parent of f, plus 1 if just one of f and the parent is to be turned. */
static cq_index cqi_find_sheet(cq_index *parent, cq_index f, cq_index *turned)
{
    cq_index root = f, sum = 0;
    while (parent[root] / 2 != root) {
        sum ^= parent[root] & 1;
        root = (cq_index)(parent[root] / 2);
    }
    *turned = sum;
    while (parent[f] / 2 != f) {
        const cq_index next = (cq_index)(parent[f] / 2), rest = sum ^ (parent[f] & 1);
        parent[f] = (cq_index)(2 * root + sum);
        sum = rest;
        f = next;
    }
    return root;
}

static void cqi_join_sheets(cqi_preparer *p, cq_index g, cq_index h, cq_index differ)
{
    cq_index *const parent = p->fan, of_g, of_h;
    const cq_index a = cqi_find_sheet(parent, (cq_index)(g / 3), &of_g),
                   b = cqi_find_sheet(parent, (cq_index)(h / 3), &of_h);
    const cq_index turned = (cq_index)(of_g ^ of_h ^ differ);
    if (a < b) parent[b] = (cq_index)(2 * a + turned);
    if (b < a) parent[a] = (cq_index)(2 * b + turned);
}

/* Joins faces across edges that have just two: those that agree first, then the others. Returns 0 if all agree. */
static int cqi_find_sheets(cqi_preparer *p)
{
    const cq_index n = cqi_list_edges(p, CQI_BY_PLACE, CQI_ALL);
    cq_index differ, begin, end;
    int any = 0;
    for (differ = 0; differ < 2; differ++) {
        for (begin = 0; begin < n; begin = end) {
            const cq_index g = p->list[begin], h = p->list[begin + 1 < n ? begin + 1 : begin];
            end = cqi_group_end(p, CQI_BY_PLACE, begin, n);
            if (end - begin != 2 || (cqi_key(p, CQI_BY_PLACE, g) == cqi_key(p, CQI_BY_PLACE, h)) != (int)differ)
                continue;
            cqi_join_sheets(p, g, h, differ);
            any |= (int)differ;
        }
    }
    return any;
}

static void cqi_turn_faces(cqi_preparer *p)
{
    cq_index *const parent = p->fan, *const balance = p->count, f, turned, root, row;
    if (p->in->shape.num_channels == CQ_MAX_CHANNELS) return;
    for (f = 0; f < p->num_faces; f++) parent[f] = (cq_index)(2 * f);
    if (!cqi_find_sheets(p)) return;
    memset(balance, 0, p->num_faces * sizeof(cq_index));
    for (f = 0; f < p->num_faces; f++) {
        root = cqi_find_sheet(parent, f, &turned);
        balance[root] = (cq_index)(balance[root] + 1 - 2 * turned); /* faces that stay minus those that do not, modulo
                                                                       2^CQ_INDEX_BITS */
    }
    for (f = 0; f < p->num_faces; f++) {
        root = cqi_find_sheet(parent, f, &turned);
        if (balance[root] >> (CQ_INDEX_BITS - 1)) turned ^= 1;
        if (!turned) continue;
        p->state[p->source[f]] |= CQI_FACE_TURNED;
        p->counts.turned_faces++;
        row = p->row[3 * f + 1];
        p->row[3 * f + 1] = p->row[3 * f + 2];
        p->row[3 * f + 2] = row;
    }
}

/* -- Gluing --
 *
 * Halfedges become twins: where rows agree, then where values do, then where places do, the flattest pair first. */

static void cqi_glue(cqi_preparer *p, cq_index g, cq_index h)
{
    const int from = cqi_key(p, CQI_BY_VALUES, g) == cqi_key(p, CQI_BY_VALUES, cq_next(h));
    const int to = cqi_key(p, CQI_BY_VALUES, h) == cqi_key(p, CQI_BY_VALUES, cq_next(g));
    p->twin[g] = h;
    p->twin[h] = g;
    p->num_glued++;
    p->counts.seam_edges += !from || !to;
}

/* Glues edges of which there is just one halfedge in each direction. */
static void cqi_glue_pairs(cqi_preparer *p, int by)
{
    const cq_index n = cqi_list_edges(p, by, CQI_OPEN);
    cq_index begin, end;
    for (begin = 0; begin < n; begin = end) {
        const cq_index g = p->list[begin], h = p->list[begin + 1 < n ? begin + 1 : begin];
        end = cqi_group_end(p, by, begin, n);
        if (end - begin == 2 && cqi_key(p, by, g) != cqi_key(p, by, h)) cqi_glue(p, g, h);
    }
}

static cqi_vector cqi_corner_offset(const cqi_preparer *p, cq_index from, cq_index to)
{
    return cqi_offset(p->positions, p->row[from], p->row[to]);
}

/* Normal of a face, with length 2^14. Offsets have 25 bits, products of two 50. */
static cqi_vector cqi_face_normal(const cqi_preparer *p, cq_index h)
{
    const cqi_vector none = { 0, 0, 0 };
    cqi_vector64 w;
    cqi_vector n;
    int64_t length;
    int shift;
    if (!p->positions) return none;
    w = cqi_wide_cross(cqi_corner_offset(p, h, cq_next(h)), cqi_corner_offset(p, h, cq_prev(h)));
    shift = cqi_bit_length_wide(((uint64_t)(w.x < 0 ? -w.x : w.x) | (uint64_t)(w.y < 0 ? -w.y : w.y) |
                                 (uint64_t)(w.z < 0 ? -w.z : w.z)) >> 16);
    n.x = (int32_t)cqi_floor_shift_wide(w.x, shift);
    n.y = (int32_t)cqi_floor_shift_wide(w.y, shift);
    n.z = (int32_t)cqi_floor_shift_wide(w.z, shift);
    length = (int64_t)cqi_square_root((uint64_t)cqi_wide_dot(n, n)) + 1;
    n.x = (int32_t)(n.x * ((int64_t)1 << 14) / length);
    n.y = (int32_t)(n.y * ((int64_t)1 << 14) / length);
    n.z = (int32_t)(n.z * ((int64_t)1 << 14) / length);
    return n;
}

/* May two open halfedges of one place be glued: are they opposite, and are their faces not copies of each other, with
 * the same three places? They are of two faces, as a face has three different places. */
static int cqi_may_glue(const cqi_preparer *p, cq_index g, cq_index h)
{
    return p->twin[g] == CQ_NONE && p->twin[h] == CQ_NONE &&
           cqi_key(p, CQI_BY_PLACE, g) != cqi_key(p, CQI_BY_PLACE, h) &&
           cqi_key(p, CQI_BY_PLACE, cq_prev(g)) != cqi_key(p, CQI_BY_PLACE, cq_prev(h));
}

/* Glues open halfedges of one place, the flattest pair first. If there are more than CQI_MOST_AT_EDGE, none is. */
#define CQI_MOST_AT_EDGE 32
static void cqi_glue_flattest(cqi_preparer *p, const cq_index *group, cq_index n)
{
    cqi_vector normal[CQI_MOST_AT_EDGE];
    cq_index j, k;
    if (n < 2 || n > CQI_MOST_AT_EDGE) return;
    for (k = 0; k < n; k++) normal[k] = cqi_face_normal(p, group[k]);
    for (;;) {
        int64_t best = INT64_MIN;
        cq_index g = 0, h = CQ_NONE;
        for (j = 0; j < n; j++) {
            for (k = (cq_index)(j + 1); k < n; k++) {
                const int64_t flat = cqi_wide_dot(normal[j], normal[k]);
                if (flat <= best || !cqi_may_glue(p, group[j], group[k])) continue;
                best = flat;
                g = group[j];
                h = group[k];
            }
        }
        if (h == CQ_NONE) return;
        cqi_glue(p, g, h);
    }
}

static void cqi_glue_places(cqi_preparer *p)
{
    const cq_index n = cqi_list_edges(p, CQI_BY_PLACE, CQI_OPEN);
    cq_index begin, end;
    for (begin = 0; begin < n; begin = end) {
        end = cqi_group_end(p, CQI_BY_PLACE, begin, n);
        cqi_glue_flattest(p, p->list + begin, (cq_index)(end - begin));
    }
}

/* -- Fans --
 *
 * No two edges may join the same two fans. Two such edges that are open are glued, if there is no third one; else faces
 * are cut off all around, which gives them fans of their own. Cutting off never makes a second edge between two fans,
 * and a round cuts off one face of each second edge, which has two at most: so when nothing is glued any more, two more
 * rounds are enough. No edge joins a fan with itself, as a fan is at one place, and a face at three. */

static void cqi_find_fans(cqi_preparer *p)
{
    const cq_index n = (cq_index)(3 * p->num_faces);
    cq_index h;
    for (h = 0; h < n; h++) p->fan[h] = h;
    for (h = 0; h < n; h++) {
        const cq_index t = p->twin[h];
        if (t == CQ_NONE || t < h) continue;
        cqi_union(p->fan, h, cq_next(t));
        cqi_union(p->fan, cq_next(h), t);
    }
    for (h = 0; h < n; h++) p->fan[h] = cqi_find_root(p->fan, h);
}

/* Mends edges that join the same two fans, a halfedge of each being in the group. If two are open they are opposite:
 * at most one open halfedge leaves a fan. */
static void cqi_mend_edge(cqi_preparer *p, const cq_index *group, cq_index n, int may_glue)
{
    const cq_index g = group[0], h = group[1];
    cq_index k;
    if (may_glue && n == 2 && p->twin[g] == CQ_NONE && p->twin[h] == CQ_NONE) {
        cqi_glue(p, g, h);
        return;
    }
    for (k = 1; k < n; k++) p->state[p->source[group[k] / 3]] |= CQI_FACE_CUT_OFF;
}

static void cqi_cut_off(cqi_preparer *p)
{
    cq_index h;
    for (h = 0; h < 3 * p->num_faces; h++) {
        uint8_t *const state = &p->state[p->source[h / 3]];
        if (!(*state & CQI_FACE_CUT_OFF)) continue;
        if (p->twin[h] != CQ_NONE) p->twin[p->twin[h]] = CQ_NONE;
        p->twin[h] = CQ_NONE;
        if (h % 3 < 2) continue;
        *state = (uint8_t)(*state - CQI_FACE_CUT_OFF);
        p->counts.detached_faces++;
    }
}

static void cqi_mend_fans(cqi_preparer *p)
{
    cq_index begin, end, n;
    int round = 0, bad = 1;
    while (bad) {
        bad = 0;
        cqi_find_fans(p);
        n = cqi_list_edges(p, CQI_BY_FAN, CQI_ONCE);
        for (begin = 0; begin < n; begin = end) {
            end = cqi_group_end(p, CQI_BY_FAN, begin, n);
            if (end - begin < 2) continue;
            cqi_mend_edge(p, p->list + begin, (cq_index)(end - begin), round < 3);
            bad = 1;
        }
        cqi_cut_off(p);
        round++;
    }
}

/* Counts the edges where faces meet that are not glued. */
static void cqi_count_cuts(cqi_preparer *p)
{
    const cq_index n = cqi_list_edges(p, CQI_BY_PLACE, CQI_ALL);
    cq_index begin, end, k;
    for (begin = 0; begin < n; begin = end) {
        int open = 0;
        end = cqi_group_end(p, CQI_BY_PLACE, begin, n);
        for (k = begin; k < end; k++) open |= p->twin[p->list[k]] == CQ_NONE;
        p->counts.cut_edges += open && end - begin > 1;
    }
}

/* Numbers the fans in the order of their first corners. */
static void cqi_number_fans(cqi_preparer *p)
{
    cq_index h;
    for (h = 0; h < 3 * p->num_faces; h++) {
        if (p->fan[h] == h) p->count[h] = p->num_fans++;
        p->fan[h] = p->count[p->fan[h]];
    }
}

/* Counts boundary edges and loops. At most one open halfedge leaves a fan. */
static void cqi_count_borders(cqi_preparer *p)
{
    cq_index *const leaving = p->count, h, next;
    for (h = 0; h < 3 * p->num_faces; h++)
        if (p->twin[h] == CQ_NONE) leaving[p->fan[h]] = h;
    for (h = 0; h < 3 * p->num_faces; h++) {
        if (p->twin[h] != CQ_NONE) continue;
        p->num_open++;
        if (leaving[p->fan[h]] == CQ_NONE) continue;
        p->num_loops++;
        for (next = h; leaving[p->fan[next]] != CQ_NONE; ) {
            const cq_index fan = p->fan[next];
            next = cq_next(leaving[fan]);
            leaving[fan] = CQ_NONE;
        }
    }
}

/* -- Locks --
 *
 * Several fans at one place are a junction; its vertices stay in the base, so that no gap opens there. The two sides of
 * a double-sided face, which are copies of each other, do not make one. */

/* Joins the fans of faces that are copies of each other; p->twin has the faces, sorted by their places. */
static void cqi_join_copies(cqi_preparer *p, cq_index *parent)
{
    cq_index k, j, i;
    for (k = 1; k < p->num_faces; k++) {
        const cq_index g = (cq_index)(3 * p->twin[k - 1]), h = (cq_index)(3 * p->twin[k]);
        if (!cqi_same_face(p, p->place, p->source[g / 3], p->source[h / 3])) continue;
        for (j = 0; j < 3; j++)
            for (i = 0; i < 3; i++)
                if (cqi_key(p, CQI_BY_PLACE, (cq_index)(g + i)) == cqi_key(p, CQI_BY_PLACE, (cq_index)(h + j)))
                    cqi_union(parent, p->fan[g + i], p->fan[h + j]);
    }
}

/* Writes the faces that stay into p->twin, sorted by their places. Their numbers in the input become those among the
 * faces that stay: these are looked up in source[], which is ascending. */
static void cqi_sort_by_places(cqi_preparer *p)
{
    cq_index k;
    for (k = 0; k < p->num_faces; k++) p->list[k] = p->source[k];
    cqi_sort_faces(p, p->place, p->num_faces);
    for (k = 0; k < p->num_faces; k++) {
        cq_index low = 0, high = p->num_faces;
        while (high - low > 1) {
            const cq_index middle = (cq_index)(low + (high - low) / 2);
            if (p->source[middle] <= p->twin[k]) low = middle;
            else high = middle;
        }
        p->twin[k] = low;
    }
}

static void cqi_lock(cqi_preparer *p, cq_index fan)
{
    p->counts.locked_vertices += !p->locked[fan];
    p->locked[fan] = 1;
}

static void cqi_find_locks(cqi_preparer *p)
{
    cq_index *const parent = p->sorted, *const first = p->count, h;
    memset(p->locked, 0, p->num_fans);
    cqi_sort_by_places(p);
    for (h = 0; h < p->num_fans; h++) parent[h] = h;
    cqi_join_copies(p, parent);
    memset(first, 0xff, p->in->shape.num_vertices * sizeof(cq_index));
    for (h = 0; h < 3 * p->num_faces; h++) {
        cq_index *const other = &first[cqi_key(p, CQI_BY_PLACE, h)];
        if (*other == CQ_NONE) *other = p->fan[h];
        if (cqi_find_root(parent, *other) != cqi_find_root(parent, p->fan[h])) {
            cqi_lock(p, *other);
            cqi_lock(p, p->fan[h]);
        }
        if (p->in->locked && p->in->locked[p->row[h]]) cqi_lock(p, p->fan[h]);
    }
}

/* -- Wedges, and numbers of rows --
 *
 * Corners of a fan with the same row are a wedge. Each row of the input is then a wedge, or aside. */

/* Sorts the corners into p->list: by their fans, and within a fan by rows. */
static void cqi_sort_corners(cqi_preparer *p)
{
    const cq_index n = (cq_index)(3 * p->num_faces), rows = (cq_index)p->in->shape.num_vertices;
    cq_index h, k;
    memset(p->count, 0, rows * sizeof(cq_index));
    for (h = 0; h < n; h++) p->count[cqi_key(p, CQI_BY_VALUES, h)]++;
    cqi_sum_counts(p->count, rows);
    for (h = 0; h < n; h++) p->sorted[p->count[cqi_key(p, CQI_BY_VALUES, h)]++] = h;
    memset(p->count, 0, p->num_fans * sizeof(cq_index));
    for (h = 0; h < n; h++) p->count[p->fan[h]]++;
    cqi_sum_counts(p->count, p->num_fans);
    for (k = 0; k < n; k++) p->list[p->count[p->fan[p->sorted[k]]]++] = p->sorted[k];
}

/* Numbers the wedges in the order of their fans: p->sorted becomes the wedge of each corner. Behind it follow a row of
 * each fan and the row of each wedge: in the place of p->twin, and of the part of p->list that has been read. */
static void cqi_number_wedges(cqi_preparer *p)
{
    const cq_index n = (cq_index)(3 * p->num_faces);
    cq_index *const row_of_fan = p->twin, *const row_of_wedge = p->twin + p->num_fans, k, before = CQ_NONE,
                    fan = CQ_NONE;
    cqi_sort_corners(p);
    for (k = 0; k < n; k++) {
        const cq_index h = p->list[k], row = cqi_key(p, CQI_BY_VALUES, h);
        if (p->fan[h] != fan || row != before) row_of_wedge[p->num_wedges++] = row;
        fan = p->fan[h];
        before = row;
        row_of_fan[fan] = row;
        p->sorted[h] = (cq_index)(p->num_wedges - 1);
    }
}

/* Replaces p->same by what becomes of each row of the input, see cqi_plan.target: rows of the mesh, then rows of faces
 * aside, then rows of no face. */
static void cqi_find_targets(cqi_preparer *p)
{
    const cq_index rows = (cq_index)p->in->shape.num_vertices, *const indices = p->in->indices;
    cq_index *const of = p->place, *const used = p->count, h, k, different = 0;
    memset(of, 0xff, rows * sizeof(cq_index));
    memset(used, 0, rows * sizeof(cq_index));
    for (h = 0; h < 3 * p->num_faces; h++) {
        cq_index *const to = &of[cqi_key(p, CQI_BY_VALUES, h)];
        different = (cq_index)(different + (*to == CQ_NONE));
        *to = p->sorted[h];
    }
    p->counts.copied_rows = (uint32_t)(p->num_wedges - different);
    for (k = 0; k < p->in->shape.num_faces; k++) {
        for (h = 0; h < 3; h++) {
            const cq_index row = indices[3 * (size_t)k + h];
            used[row] = 1;
            if (of[p->same[row]] == CQ_NONE) of[p->same[row]] = (cq_index)(p->num_wedges + p->num_aside++);
        }
    }
    for (k = 0; k < rows; k++) {
        p->counts.merged_rows += used[k] && p->same[k] != k;
        p->counts.unused_rows += !used[k];
        p->same[k] = used[k] ? of[p->same[k]] : (cq_index)(p->num_wedges + p->num_aside++);
    }
}

/* -- The whole --
 *
 * The preparation's memory, its steps in order, and what is kept of it. */

/* Bytes for the preparation, and for what is kept of it; see cqi_preparer_carve and cqi_carve_prepared. */
static uint64_t cqi_preparing_bytes(const cq_shape *s)
{
    const uint64_t v = s->num_vertices, f = s->num_faces;
    return CQI_ROUND(4 * f) + (2 * v + 16 * f + (v > 3 * f ? v : 3 * f)) * sizeof(cq_index) + 9 * 4;
}

static uint64_t cqi_prepared_bytes(const cq_shape *s)
{
    const uint64_t v = s->num_vertices, f = s->num_faces, w = s->num_rows;
    return CQI_ROUND(4 * f) + (v + 4 * f + 5 * w + s->num_aside_rows) * sizeof(cq_index) + 8 * 4;
}

static void cqi_preparer_carve(cqi_preparer *p, cqi_arena *arena)
{
    const size_t v = p->in->shape.num_vertices, f = p->in->shape.num_faces;
    p->state = (uint8_t *)cqi_take(arena, 4 * f, 1);
    p->locked = p->state + f;
    p->same = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->source = (cq_index *)cqi_take(arena, f, sizeof(cq_index));
    p->sorted = (cq_index *)cqi_take(arena, 9 * f, sizeof(cq_index));
    p->twin = p->sorted + 3 * f;
    p->list = p->twin + 3 * f;
    p->fan = (cq_index *)cqi_take(arena, 3 * f, sizeof(cq_index));
    p->place = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->count = (cq_index *)cqi_take(arena, v > 3 * f ? v : 3 * f, sizeof(cq_index));
    p->row = (cq_index *)cqi_take(arena, 3 * f, sizeof(cq_index));
}

/* Is there a channel of positions, exact ones included? With three components, it is not of faces. */
static int cqi_has_places(const cq_shape *s)
{
    uint32_t k;
    for (k = 0; k < s->num_channels; k++)
        if (s->channel[k].kind == CQ_POSITION) return 1;
    return 0;
}

static void cqi_prepare(cqi_preparer *p)
{
    const int channel = cqi_context_channel(&p->in->shape);
    p->positions = channel >= 0 ? p->in->values[channel] : NULL;
    p->located = cqi_has_places(&p->in->shape);
    cqi_find_places(p);
    cqi_put_faces_aside(p);
    memset(p->twin, 0xff, 3 * (size_t)p->num_faces * sizeof(cq_index));
    cqi_turn_faces(p);
    cqi_glue_pairs(p, CQI_BY_ROW);
    p->num_glued = 0;
    cqi_glue_pairs(p, CQI_BY_VALUES);
    cqi_glue_places(p);
    cqi_mend_fans(p);
    cqi_count_cuts(p);
    cqi_number_fans(p);
    cqi_count_borders(p);
    cqi_find_locks(p);
    cqi_number_wedges(p);
    cqi_find_targets(p);
}

/* Lays out what is kept of the preparation; the first three blocks are where they were. Returns room for the rows
 * aside. */
static cq_index *cqi_carve_prepared(const cqi_preparer *p, cqi_plan *plan, cqi_arena *arena)
{
    const size_t w = p->num_wedges;
    cqi_take(arena, 4 * (size_t)p->in->shape.num_faces, 1);
    cqi_take(arena, p->in->shape.num_vertices, sizeof(cq_index));
    cqi_take(arena, p->in->shape.num_faces, sizeof(cq_index));
    plan->index = (cq_index *)cqi_take(arena, 3 * (size_t)p->in->shape.num_faces + p->num_fans + w, sizeof(cq_index));
    plan->row_of_vertex = plan->index + 3 * (size_t)p->in->shape.num_faces;
    plan->row_of_wedge = plan->row_of_vertex + p->num_fans;
    plan->uses = (cq_index *)cqi_take(arena, 3 * w, sizeof(cq_index));
    plan->wedge_of_row = plan->uses + w;
    plan->row_decoded = plan->wedge_of_row + w;
    return (cq_index *)cqi_take(arena, p->num_aside, sizeof(cq_index));
}

/* Makes the shape that of the mesh, with a channel of the faces that are turned over. */
static void cqi_set_prepared_shape(const cqi_preparer *p, int has_seams, cq_shape *shape)
{
    shape->num_vertices = p->num_fans;
    shape->num_faces = p->num_faces;
    shape->num_rows = has_seams ? p->num_wedges : 0;
    shape->num_boundary_loops = shape->num_boundary_edges = 0;
    shape->num_aside_rows = p->num_aside;
    shape->num_aside_faces = (uint32_t)(p->in->shape.num_faces - p->num_faces);
    if (p->counts.turned_faces) {
        cq_channel *c = &shape->channel[shape->num_channels++];
        memset(c, 0, sizeof *c);
        c->kind = CQ_TURNED;
        c->components = c->bits = 1;
        c->merge = CQ_PER_FACE;
    }
}

/* Keeps what the plan needs of the preparation, and moves the faces of the mesh to the end of the memory, where they
 * are until it is built; the shape becomes that of the mesh. */
static const cq_index *cqi_keep_prepared(const cqi_preparer *p, cqi_plan *plan, cq_shape *shape, cqi_arena *arena)
{
    const size_t n = 3 * (size_t)p->num_faces, w = p->num_wedges;
    cq_index *faces, *aside, k;
    size_t j;
    arena->left -= n * sizeof(cq_index) + arena->left % 4;
    faces = (cq_index *)(void *)(arena->next + arena->left);
    for (j = n; j--;) faces[j] = p->fan[j];
    aside = cqi_carve_prepared(p, plan, arena);
    memset(plan->uses, 0, w * sizeof(cq_index));
    memset(plan->row_decoded, 0xff, w * sizeof(cq_index));
    for (j = 0; j < n; j++) plan->uses[plan->index[j]]++;
    for (k = 0; k < p->in->shape.num_vertices; k++)
        if (p->same[k] >= w) aside[p->same[k] - w] = k;
    plan->aside_row = aside;
    plan->target = p->same;
    plan->num_wedges = p->num_wedges;
    plan->face_of_input = p->source;
    plan->face_state = p->state;
    plan->copies_rows = p->counts.copied_rows != 0;
    plan->triangles = p->in->indices;
    plan->locked = p->locked;
    if (p->num_wedges == p->num_fans) {
        plan->corners = plan->index;
        plan->index = NULL;
    }
    cqi_set_prepared_shape(p, plan->index != NULL, shape);
    return faces;
}

#endif /* CQ_NO_WEDGES */

/* -- Regular levels: labels ----------------------------------------------------------------------------------------
 *
 * A regular level undoes one step of subdivision, in regions or everywhere. Every vertex is even (it stays) or odd (it
 * is removed). An odd one has two parents, real even neighbours, whose edge it was inserted in. An edge is cut if both
 * ends are even, or if it joins an odd vertex with a parent. Cut edges divide the faces into polygons. Their corners
 * are even vertices; their sides are one edge, or two edges with an odd vertex between.
 *
 * A labelling can be coded if all of this holds:
 *   1. Each polygon is a disc of at most six faces without inner vertices, with 3 or 4 corners, all different.
 *   2. A polygon of 4 corners consists of two coarse faces, see below, and none of its corners is virtual.
 *   3. The vertices around each even vertex are all different: the other ends of its sides, and the opposite corners of
 *      its polygons of 4 corners.
 *
 * A polygon of 3 corners is a coarse face. Its odd vertices are its marks. No edge inside joins two corners, as that
 * would be cut: so with no mark or one mark there is one triangulation; with two marks, two; and with three marks,
 * four: a triangle in the middle or one of three fans. The hub of a face is the odd vertex that is joined to the corner
 * opposite to its side: one of two marks, one or none of three.
 *
 * A polygon of 4 corners is two coarse faces whose common edge, from A to C, is dissolved: it was flipped after both
 * had been triangulated. So there is an edge x - y inside whose triangles have A and C as their third corners; if it is
 * flipped back, each half is a polygon of 3 corners as above. The polygon has at least one odd vertex, or the edge
 * inside would be cut. In a half with one mark x, the edge from x to the corner opposite to it may have been flipped
 * afterwards, too: the second flip.
 *
 * Then the coarse mesh is simple: coarse edges are sides, or diagonals of polygons of 4 corners, and by 3 those at a
 * vertex lead to different vertices. And at least three polygons meet at each even vertex v with an odd vertex in one
 * of its polygons. For if only two did, they would share both sides at v, to a and b. If one of them has 4 corners, b
 * is opposite to a in it, and in the other one opposite to a or the end of a side at a, against 3. If both have 3
 * corners, their third sides lead from a to b, and are the same by 3. Then both have the same vertices; and as any two
 * triangulations with the same marks share an edge, the mesh would have this edge twice.
 *
 * A decoder may insert odd vertices, then flip to the wanted triangulations of faces, then dissolve, then do the second
 * flips, in any order of polygons: the mesh stays valid. Valences: in every state a polygon has a triangle at each of
 * its corners, and two at each odd vertex; so all vertices keep three or more neighbours. Edges: every edge inside of a
 * polygon, if it is no coarse one, has an odd end x. It could only be there twice if the two polygons at x shared
 * a vertex other than x and its parents a, b. Let them be a b c (d) and b a e (f), in this order around each. If c is
 * also the last corner of the second one, which is f, or e where there is no f, then both sides b - c are the same by
 * 3, and only two polygons meet at b. The same holds at a for d, or c where there is no d, and e. So no side is shared,
 * and hence no odd vertex, whose parents would be shared. What is left are two polygons of four corners with c = e or d
 * = f: then c is opposite to a in one and the end of a side at a in the other, or d likewise for b, against 3. */

/* The two lowest bits are the label; the others are flags until the level is undone. Then, of an odd vertex, they are
 * what the note will say of the two coarse faces, 3 bits each: see CQI_SIDE_HUB. */
enum {
    CQI_UNLABELLED, CQI_EVEN, CQI_ODD, CQI_LABEL = 3, CQI_LOOK_AROUND = 4, CQI_MAY_FILL = 8, CQI_CONFLICT = 16,
    CQI_TOO_FAR = 32, CQI_ACUTE = 64 /* of the waves, see cqi_has_sharp_edges and cqi_is_acute */
};

#define CQI_POLYGON_FACES 6  /* of a polygon that can be coded */
#define CQI_REGION_FACES 24  /* looked at of a region that is no polygon */

typedef struct cqi_labels {
    const cq_mesh *mesh;
    const cq_input *input;       /* faces of a polygon have the same material, and values; NULL: whatever they have */
    const cq_index *input_face;  /* numbers of faces in the input; NULL: the same; */
    const uint8_t *face_state;   /* and what has been done with these */
    const uint8_t *locked;       /* of each vertex: it stays even; or NULL */
    cq_index *index, *uses;      /* wedges of the corners, and corners of these; or NULL */
    const cq_value *positions;   /* or NULL */
    int32_t step;                /* 1/4096 of what the positions span; 0: never a limit */
    int32_t limit;               /* of an odd vertex from its parents' edge, or 0 */
    int is_sharp;                /* there are sharp edges */
    int least, strips;           /* per mille of odd vertices that waves must find, else there is no level; but if they
                                    find less than `strips`, strips are tried */
    int found;                   /* what they have found */
    cq_index *parent[2];         /* of each odd vertex */
    cq_index *since;             /* when an odd vertex got its label; of an even one, how many have it as a parent */
    uint8_t *label;
    cq_index *queue;             /* vertices whose neighbours are still to be labelled; scratch */
    cq_index *waiting;           /* faces whose polygons are still to be checked */
    uint8_t *face;               /* CQI_WAITS, CQI_LISTED_FACE */
    cq_index num_waiting, clock;
    cq_index spare;              /* how many odd vertices may still become even before the labelling is given up */
    int alike;                   /* 1: strips, whose dissolved edges should all run the same way */
    int ready;                   /* number of the labelling that the waves have just made */
} cqi_labels;

/* Bytes of memory for v vertices and f faces, virtual ones included: 27 per vertex of a closed mesh. */
#define CQI_LABEL_BYTES(v, f) \
    (4 * CQI_ROUND((v) * sizeof(cq_index)) + CQI_ROUND((f) * sizeof(cq_index)) + CQI_ROUND(v) + CQI_ROUND(f))

/* Lays out labels in memory that is idle. 0: that is too small. */
static int cqi_labels_carve(cqi_labels *l, const cq_mesh *m, void *memory, size_t size)
{
    const size_t v = (size_t)m->first_virtual + m->max_virtual;
    const size_t f = (size_t)m->first_virtual_face + m->max_virtual_faces;
    cqi_arena arena;
    arena.next = (uint8_t *)memory;
    arena.left = size;
    memset(l, 0, sizeof *l);
    if (size < CQI_LABEL_BYTES(v, f)) return 0;
    l->parent[0] = (cq_index *)cqi_take(&arena, v, sizeof(cq_index));
    l->parent[1] = (cq_index *)cqi_take(&arena, v, sizeof(cq_index));
    l->since = (cq_index *)cqi_take(&arena, v, sizeof(cq_index));
    l->queue = (cq_index *)cqi_take(&arena, v, sizeof(cq_index));
    l->waiting = (cq_index *)cqi_take(&arena, f, sizeof(cq_index));
    l->label = (uint8_t *)cqi_take(&arena, v, 1);
    l->face = (uint8_t *)cqi_take(&arena, f, 1);
    l->mesh = m;
    l->least = l->strips = 385;
    return 1;
}

static int cqi_label(const cqi_labels *l, cq_index v) { return l->label[v] & CQI_LABEL; }
static int cqi_is_odd(const cqi_labels *l, cq_index v) { return cqi_label(l, v) == CQI_ODD; }

/* Numbers of vertices, and of faces, are below these: virtual ones and the slots before them are included. */
static cq_index cqi_vertex_slots(const cq_mesh *m) { return (cq_index)(m->first_virtual + m->num_virtual); }
static cq_index cqi_face_slots(const cq_mesh *m) { return (cq_index)(m->first_virtual_face + m->num_virtual_faces); }

static int cqi_is_locked(const cqi_labels *l, cq_index v) { return l->locked && l->locked[v]; }

static int cqi_is_parent(const cqi_labels *l, cq_index v, cq_index odd)
{
    return l->parent[0][odd] == v || l->parent[1][odd] == v;
}

static inline int cqi_is_cut(const cqi_labels *l, cq_index h)
{
    const cq_index a = l->mesh->origin[h], b = l->mesh->origin[l->mesh->twin[h]];
    if (cqi_is_odd(l, a)) return !cqi_is_odd(l, b) && cqi_is_parent(l, b, a);
    return !cqi_is_odd(l, b) || cqi_is_parent(l, a, b);
}

static cq_index cqi_count_odd(const cqi_labels *l)
{
    cq_index v, n = 0;
    for (v = 0; v < l->mesh->num_vertices; v++) n = (cq_index)(n + (cq_index)cqi_is_odd(l, v));
    return n;
}

/* -- Regular levels: polygons --
 *
 * Reads the polygon that a face lies in, and flips it back to coarse faces. */

/* A polygon, or as much of a region as was looked at. Its border runs counter-clockwise; place k is the origin of
 * border halfedge k. What follows `border` is for polygons only. Sets of places are bits. */
typedef struct cqi_polygon {
    int faces, size, inner;                       /* size: of the border; inner: edges inside */
    cq_index face[CQI_REGION_FACES];
    cq_index border[CQI_REGION_FACES + 2];
    int corners, corner[4];                       /* places of the corners */
    int edge[CQI_REGION_FACES][2];                /* places that an edge inside joins */
    uint8_t joined[CQI_POLYGON_FACES + 2];        /* of each place: those that it is joined to */
    uint8_t even, second;                         /* places of corners; of odd vertices with a second flip */
    int undone, undo[3][2];                       /* flips that lead to the coarse faces; the last one is of x - y */
    int diagonal;                                 /* of 4 corners: 0 or 1, the first corner at the dissolved edge */
} cqi_polygon;

static cq_index cqi_place(const cqi_labels *l, const cqi_polygon *p, int k) { return l->mesh->origin[p->border[k]]; }

/* Walks over the region that face f lies in, face by face across edges that are not cut. 0 if it has more than `most`
 * faces, or if the walk comes back to a face. Otherwise the faces form a tree, so that the region is a disc without
 * inner vertices. */
static int cqi_read_region(const cqi_labels *l, cq_index f, int most, cqi_polygon *p)
{
    const cq_mesh *m = l->mesh;
    cq_index stack[3 + 3 * CQI_REGION_FACES];   /* halfedges; CQ_NONE: all behind an edge inside has been seen, and */
    int from[3 + 3 * CQI_REGION_FACES], n = 0;  /* from here it runs to the next place */
    p->faces = 1;
    p->size = p->inner = 0;
    p->face[0] = f;
    stack[n++] = (cq_index)(3 * f + 2);
    stack[n++] = (cq_index)(3 * f + 1);
    stack[n++] = (cq_index)(3 * f);
    while (n) {
        const cq_index h = stack[--n], g = h == CQ_NONE ? h : m->twin[h];
        if (h == CQ_NONE) {
            p->edge[p->inner][0] = from[n];
            p->edge[p->inner++][1] = p->size;
        } else if (cqi_is_cut(l, h)) {
            p->border[p->size++] = h;
        } else {
            if (p->faces == most) return 0;
            p->face[p->faces++] = (cq_index)(g / 3);
            from[n] = p->size;
            stack[n++] = CQ_NONE;
            stack[n++] = cq_prev(g);
            stack[n++] = cq_next(g);
        }
    }
    return 1;
}

/* Does the region have 3 corners, or 4 real ones, and are all its vertices different? Fills in corners and joined. */
static int cqi_find_corners(const cqi_labels *l, cqi_polygon *p)
{
    cq_index at[CQI_POLYGON_FACES + 2];
    int k, j, any_virtual = 0;
    p->corners = p->undone = 0;
    p->even = p->second = 0;
    for (k = 0; k < p->size; k++) {
        const cq_index v = at[k] = cqi_place(l, p, k);
        for (j = 0; j < k; j++)
            if (v == at[j]) return 0;
        p->joined[k] = (uint8_t)(1 << cqi_next_of(k, p->size) | 1 << cqi_previous_of(k, p->size));
        if (cqi_is_odd(l, v)) continue;
        if (p->corners == 4) return 0;
        any_virtual |= cq_is_virtual(l->mesh, v);
        p->corner[p->corners++] = k;
        p->even = (uint8_t)(p->even | 1 << k);
    }
    for (k = 0; k < p->inner; k++) {
        int *e = p->edge[k];
        if (e[1] == p->size) e[1] = 0;
        p->joined[e[0]] = (uint8_t)(p->joined[e[0]] | 1 << e[1]);
        p->joined[e[1]] = (uint8_t)(p->joined[e[1]] | 1 << e[0]);
    }
    return p->corners == 3 || (p->corners == 4 && !any_virtual);
}

static int cqi_lowest_bit(int x)
{
    int k = 0;
    while (!(x >> k & 1)) k++;
    return k;
}

/* The third corners of the two triangles at edge e: the two places that are joined to both its ends. */
static void cqi_third_corners(const cqi_polygon *p, int e, int *low, int *high)
{
    const int both = p->joined[p->edge[e][0]] & p->joined[p->edge[e][1]];
    *low = cqi_lowest_bit(both);
    *high = cqi_lowest_bit(both & (both - 1));
}

static void cqi_flip_inside(cqi_polygon *p, int e)
{
    int *ends = p->edge[e], low, high;
    cqi_third_corners(p, e, &low, &high);
    p->joined[ends[0]] = (uint8_t)(p->joined[ends[0]] & ~(1 << ends[1]));
    p->joined[ends[1]] = (uint8_t)(p->joined[ends[1]] & ~(1 << ends[0]));
    p->joined[low] = (uint8_t)(p->joined[low] | 1 << high);
    p->joined[high] = (uint8_t)(p->joined[high] | 1 << low);
    ends[0] = low;
    ends[1] = high;
}

/* The number of the corner at a place, counted along the border. */
static int cqi_corner_number(const cqi_polygon *p, int place)
{
    int k = 0;
    while (p->corner[k] != place) k++;
    return k;
}

/* Flips edge e, and notes it as one of those that lead to the coarse faces. */
static void cqi_undo_inside(cqi_polygon *p, int e)
{
    p->undo[p->undone][0] = p->edge[e][0];
    p->undo[p->undone++][1] = p->edge[e][1];
    cqi_flip_inside(p, e);
}

/* Flips the dissolved edge x - y back: one whose triangles have opposite corners of four as their third corners; those
 * at `diagonal` if that is not -1. */
static int cqi_find_dissolved(cqi_polygon *p, int diagonal)
{
    int e, low, high;
    for (e = 0; e < p->inner; e++) {
        cqi_third_corners(p, e, &low, &high);
        if (!(p->even >> low & p->even >> high & 1)) continue;
        low = cqi_corner_number(p, low);
        if (cqi_corner_number(p, high) != low + 2 || (diagonal >= 0 && low != diagonal)) continue;
        p->diagonal = low;
        cqi_undo_inside(p, e);
        return 1;
    }
    return 0;
}

static int cqi_next_place(const cqi_polygon *p, int k) { return cqi_next_of(k, p->size); }
static int cqi_previous_place(const cqi_polygon *p, int k) { return cqi_previous_of(k, p->size); }

/* Flips edge e back if a second flip can have made it: it runs from a corner B to an odd vertex, and has on one side
 * the odd vertex of a side at B, on the other side the corner C next to B. Returns the diagonal that must then be
 * dissolved, that at C; or -1. */
static int cqi_undo_second(cqi_polygon *p, int e)
{
    int b = p->edge[e][0], odd, c;
    if (!(p->even >> b & 1)) b = p->edge[e][1];
    if (!(p->even >> b & 1)) return -1;
    cqi_third_corners(p, e, &odd, &c);
    if (p->even >> odd & 1) {
        const int other = odd;
        odd = c;
        c = other;
    }
    if ((p->even >> odd & 1) || !(p->even >> c & 1)) return -1;
    if (odd != cqi_next_place(p, b) && odd != cqi_previous_place(p, b)) return -1;
    cqi_undo_inside(p, e);
    p->second = (uint8_t)(p->second | 1 << odd);
    return cqi_corner_number(p, c) & 1;
}

/* Does the last second flip, of edge e, again. */
static void cqi_redo_inside(cqi_polygon *p, int e, int second)
{
    cqi_flip_inside(p, e);
    p->undone--;
    p->second = (uint8_t)second;
}

/* Flips a polygon of 4 corners back to two coarse faces: without second flips, or with one, or with two; at the
 * diagonal `wanted` if that is not -1. */
static int cqi_find_faces(cqi_polygon *p, int wanted)
{
    int i, j;
    if (cqi_find_dissolved(p, wanted)) return 1;
    for (i = 0; i < p->inner; i++) {
        const int diagonal = cqi_undo_second(p, i), second = p->second;
        if (diagonal < 0) continue;
        if ((wanted < 0 || wanted == diagonal) && cqi_find_dissolved(p, diagonal)) return 1;
        for (j = i + 1; j < p->inner; j++) {
            const int other = cqi_undo_second(p, j);
            if (other < 0) continue;
            if (other == diagonal && (wanted < 0 || wanted == diagonal) && cqi_find_dissolved(p, diagonal)) return 1;
            cqi_redo_inside(p, j, second);
        }
        cqi_redo_inside(p, i, 0);
    }
    return 0;
}

/* Is there an odd vertex on the side after that corner? */
static int cqi_is_marked(const cqi_polygon *p, int corner)
{
    return !(p->even >> cqi_next_place(p, p->corner[corner]) & 1);
}

/* The diagonal by which all polygons with odd vertices on just two sides, opposite ones, are dissolved alike: it joins
 * the ends of these two sides, counter-clockwise. Each of their triangulations leads back to it. -1 for all others. */
static int cqi_alike(const cqi_polygon *p)
{
    if (p->size != 6 || cqi_is_marked(p, 0) != cqi_is_marked(p, 2)) return -1;
    return cqi_is_marked(p, 0);
}

/* Does the face have an edge that is inside of a polygon and a seam? If a polygon has a virtual corner, all its faces are
 * virtual: sides there have no odd vertex, as parents are real; so there is one on the third side at most, and then its
 * two faces meet at the edge from there to the virtual corner. */
static int cqi_has_seam_inside(const cqi_labels *l, cq_index f)
{
    cq_index h;
    for (h = 3 * f; l->index && h < 3 * f + 3 && f < l->mesh->first_virtual_face; h++) {
        const cq_index g = l->mesh->twin[h];
        if (cqi_is_cut(l, h)) continue;
        if (!cqi_is_real_face(l->mesh, g)) continue; /* unreachable: a polygon has only real faces or only virtual ones */
        if (l->index[h] != l->index[cq_next(g)] || l->index[cq_next(h)] != l->index[g]) return 1;
    }
    return 0;
}

/* Do two faces have the same material and the same values? */
static int cqi_are_alike(const cqi_labels *l, cq_index f, cq_index g)
{
    const cq_input *const in = l->input;
    uint32_t k;
    if (!in || f >= l->mesh->first_virtual_face) return 1;
    if (g >= l->mesh->first_virtual_face) return 1; /* unreachable: a polygon has only real faces or only virtual ones */
    if (l->input_face) {
        f = l->input_face[f];
        g = l->input_face[g];
    }
    if (in->shape.num_materials && in->materials[f] != in->materials[g]) return 0;
    if (l->face_state && (l->face_state[f] ^ l->face_state[g]) & CQI_FACE_TURNED) return 0;
    for (k = 0; k < in->shape.num_channels; k++)
        if (cqi_class(&in->shape, k) == CQI_OF_FACE && in->values[k] && in->values[k][f] != in->values[k][g]) return 0;
    return 1;
}

/* Reads the polygon of face f, and flips it back to coarse faces. 0 if it cannot be coded. */
static int cqi_read_polygon(const cqi_labels *l, cq_index f, cqi_polygon *p)
{
    int k;
    if (!cqi_read_region(l, f, CQI_POLYGON_FACES, p) || !cqi_find_corners(l, p)) return 0;
    for (k = 0; k < p->faces; k++)
        if (!cqi_are_alike(l, p->face[0], p->face[k]) || cqi_has_seam_inside(l, p->face[k])) return 0;
    return p->corners == 3 || cqi_find_faces(p, l->alike ? cqi_alike(p) : -1);
}

/* What the note of the odd vertex after a corner says of its coarse face in this polygon: see CQI_SIDE_HUB. */
static int cqi_side_of(const cqi_polygon *p, int corner)
{
    const int place = cqi_next_place(p, p->corner[corner]);
    int bits = 0, marks = p->size - 3, opposite = (corner + 2) % p->corners;
    if (p->corners == 4 && ((corner ^ p->diagonal) & 1)) {
        bits = CQI_SIDE_NEXT;
        opposite = (corner + 3) % 4;
        marks = 1 + cqi_is_marked(p, opposite);
    } else if (p->corners == 4) {
        bits = CQI_SIDE_PREVIOUS;
        marks = 1 + cqi_is_marked(p, (corner + 1) % 4);
    }
    return bits | ((marks > 1 ? p->joined[place] >> p->corner[opposite] : p->second >> place) & CQI_SIDE_HUB);
}

/* -- Regular levels: the wave --
 *
 * A wave goes out from an even vertex: each neighbour w of an even vertex v becomes odd; its parents are v and the
 * vertex straight behind w, which becomes even, too. A mesh that was subdivided is labelled completely that way;
 * elsewhere waves meet and disagree. */

/* The vertex straight behind the origin of `back`, seen from its target: on the opposite spoke of an even valence, which
 * must be 6 unless `any_valence`; or along a boundary. CQ_NONE: there is none. */
static cq_index cqi_behind(const cq_mesh *m, cq_index back, int any_valence)
{
    const cq_index v = m->origin[back];
    const int only_boundary = !any_valence && m->valence[v] != 6;
    cq_index ahead;
    int two;
    if (only_boundary && !m->num_virtual) return CQ_NONE;
    ahead = cqi_straight(m, back, &two);
    if (ahead == CQ_NONE || two || (only_boundary && !cqi_on_boundary(m, v))) return CQ_NONE;
    return cq_target(m, ahead);
}

static void cqi_make_odd(cqi_labels *l, cq_index v, cq_index a, cq_index b)
{
    l->label[v] = CQI_ODD;
    l->parent[0][v] = a;
    l->parent[1][v] = b;
    l->since[v] = l->clock++;
}

static void cqi_wave(cqi_labels *l, cq_index seed, int any_valence)
{
    const cq_mesh *m = l->mesh;
    cq_index head = 0, tail = 0;
    l->label[seed] = CQI_EVEN;
    l->queue[tail++] = seed;
    while (head < tail) {
        const cq_index v = l->queue[head++];
        cq_index h = m->out[v];
        do {
            const cq_index back = m->twin[h], w = m->origin[back];
            if (cqi_label(l, w) == CQI_UNLABELLED) {
                const cq_index b = cqi_behind(m, back, any_valence);
                if (b != CQ_NONE && !cqi_is_odd(l, b)) {
                    cqi_make_odd(l, w, v, b);
                    if (cqi_label(l, b) == CQI_UNLABELLED) l->queue[tail++] = b;
                    l->label[b] = CQI_EVEN;
                }
            }
            h = cq_next(back);
        } while (h != m->out[v]);
    }
}

/* Takes all labels off; virtual vertices and free slots count as even. */
static void cqi_clear_labels(cqi_labels *l)
{
    const cq_mesh *m = l->mesh;
    cq_index v;
    memset(l->label, CQI_EVEN, cqi_vertex_slots(m));
    for (v = 0; v < m->num_vertices; v++)
        if (m->out[v] != CQ_NONE) l->label[v] = CQI_UNLABELLED;
    l->clock = 0;
}

/* Waves from the seed, then from vertices that none has reached: irregular ones, then any. */
static void cqi_label_all(cqi_labels *l, cq_index seed, int any_valence)
{
    cq_index v;
    int pass;
    cqi_clear_labels(l);
    cqi_wave(l, seed, any_valence);
    for (pass = 0; pass < 2; pass++)
        for (v = 0; v < l->mesh->num_vertices; v++)
            if (cqi_label(l, v) == CQI_UNLABELLED && (pass || l->mesh->valence[v] != 6)) cqi_wave(l, v, any_valence);
}

/* -- Regular levels: strips --
 *
 * Quads that were cut along either diagonal, without order, have no straight lines of edges. There every second row of
 * quads' corners is taken away: above and below an even vertex are odd ones, to its right and left even ones. Each even
 * vertex has a frame: its halfedges up, down, right and left, some of which may be missing. The wave carries frames on:
 * along a row past one or two edges, whichever way the quad was cut; and straight on up and down. Frames are kept in
 * arrays that have idle entries for even vertices, and in `waiting`. */

#define CQI_STRIP_SAMPLE 1024
enum { CQI_UP, CQI_RIGHT, CQI_DOWN, CQI_LEFT }; /* in this order clockwise */

/* The cosine of the angle a v b, in 1/1024. */
static int cqi_cosine(const cqi_labels *l, cq_index a, cq_index v, cq_index b)
{
    cqi_vector x = cqi_offset(l->positions, v, a), y = cqi_offset(l->positions, v, b);
    x = cqi_shift(x, cqi_bit_length((cqi_abs(x.x) | cqi_abs(x.y) | cqi_abs(x.z)) >> CQI_OFFSET_BITS));
    y = cqi_shift(y, cqi_bit_length((cqi_abs(y.x) | cqi_abs(y.y) | cqi_abs(y.z)) >> CQI_OFFSET_BITS));
    return (int)(1024 * cqi_wide_dot(x, y) /
                 ((int64_t)cqi_square_root((uint64_t)cqi_wide_dot(x, x) * (uint64_t)cqi_wide_dot(y, y)) + 1));
}

/* The real spoke at the origin of h, other than h, that goes on straightest from vertex `from`; CQ_NONE if all bend by
 * 60 degrees or more. */
static cq_index cqi_straightest(const cqi_labels *l, cq_index from, cq_index h)
{
    const cq_mesh *m = l->mesh;
    cq_index s = cq_clockwise(m, h), best = CQ_NONE;
    int least = -512;
    for (; s != h; s = cq_clockwise(m, s)) {
        int cosine;
        if (cq_is_virtual(m, cq_target(m, s))) continue;
        cosine = cqi_cosine(l, from, m->origin[h], cq_target(m, s));
        if (cosine >= least) continue;
        least = cosine;
        best = s;
    }
    return best;
}

/* The real spoke strictly between two, counter-clockwise, that goes on from vertex `from`: the only one, the middle one
 * of three, or else the straightest. If `from` is CQ_NONE, the middle one. */
static cq_index cqi_between(const cqi_labels *l, cq_index first, cq_index last, cq_index from)
{
    const cq_mesh *m = l->mesh;
    cq_index s, best = CQ_NONE;
    int all = 0, n = 0, k = 0, least = 2048, middle;
    for (s = cq_counterclockwise(m, first); s != last; s = cq_counterclockwise(m, s)) {
        all++;
        n += !cq_is_virtual(m, cq_target(m, s));
    }
    middle = n == 1 || from == CQ_NONE || (n == 3 && all == 3);
    for (s = cq_counterclockwise(m, first); s != last; s = cq_counterclockwise(m, s)) {
        int cosine;
        if (cq_is_virtual(m, cq_target(m, s))) continue;
        cosine = middle ? (k++ == n / 2 ? 0 : 4096) : cqi_cosine(l, from, m->origin[first], cq_target(m, s));
        if (cosine >= least) continue;
        least = cosine;
        best = s;
    }
    return best;
}

/* Carries spoke u along spoke r of the same vertex: the halfedge from the end of r that is parallel to u on the other
 * side of the quad between them; or CQ_NONE. left: u is counter-clockwise of r. */
static cq_index cqi_carry(const cq_mesh *m, cq_index r, cq_index u, int left)
{
    const cq_index side = left ? cq_next(r) : cq_prev(m->twin[r]); /* the edge from the end of r to the corner beside */
    const cq_index beside = left ? cq_target(m, side) : m->origin[side];
    const cq_index second =
        left ? cq_counterclockwise(m, cq_counterclockwise(m, r)) : cq_clockwise(m, cq_clockwise(m, r));
    cq_index over, found;
    if (cq_is_virtual(m, beside)) return CQ_NONE;
    if (beside != cq_target(m, u)) return second != u ? CQ_NONE : left ? side : m->twin[side];
    over = m->twin[side]; /* the quad's diagonal is that side, the corner sought lies behind it */
    found = left ? cq_next(over) : m->twin[cq_prev(over)];
    return cq_is_virtual(m, cq_target(m, found)) ? CQ_NONE : found;
}

static cq_index *cqi_frame(cqi_labels *l, cq_index v, int direction)
{
    return direction == CQI_UP ? &l->parent[0][v] : direction == CQI_DOWN ? &l->parent[1][v]
         : direction == CQI_RIGHT ? &l->since[v] : &l->waiting[v];
}

/* If v has no label, makes it even, with this frame, and queues it. */
static void cqi_begin_frame(cqi_labels *l, cq_index v, const cq_index *frame, cq_index *tail)
{
    int k;
    if (cqi_label(l, v) != CQI_UNLABELLED) return;
    l->label[v] = CQI_EVEN;
    for (k = 0; k < 4; k++) *cqi_frame(l, v, k) = frame[k];
    l->queue[(*tail)++] = v;
}

static cq_index cqi_end_of(const cq_mesh *m, cq_index h) { return h == CQ_NONE ? CQ_NONE : cq_target(m, h); }

/* The right and left of a frame whose up and down are known. */
static void cqi_complete_frame(const cqi_labels *l, cq_index *f)
{
    if (f[CQI_UP] == CQ_NONE || f[CQI_DOWN] == CQ_NONE) return;
    if (f[CQI_RIGHT] == CQ_NONE)
        f[CQI_RIGHT] = cqi_between(l, f[CQI_DOWN], f[CQI_UP], cqi_end_of(l->mesh, f[CQI_LEFT]));
    if (f[CQI_LEFT] == CQ_NONE)
        f[CQI_LEFT] = cqi_between(l, f[CQI_UP], f[CQI_DOWN], cqi_end_of(l->mesh, f[CQI_RIGHT]));
}

/* Spoke u, if there is one, carried along h, on its right or left. */
static cq_index cqi_carry_if(const cq_mesh *m, cq_index h, cq_index u, int left)
{
    return u == CQ_NONE ? CQ_NONE : cqi_carry(m, h, u, left);
}

/* The spoke that goes straight on at the end of h; right, left: the spokes of that end, or CQ_NONE. */
static cq_index cqi_go_on(const cqi_labels *l, cq_index h, cq_index right, cq_index left)
{
    const cq_mesh *m = l->mesh;
    if (right != CQ_NONE && left != CQ_NONE) return cqi_between(l, right, left, m->origin[h]);
    return cqi_straightest(l, m->origin[h], m->twin[h]);
}

/* Goes up or down, along h from v: to an odd vertex, and an even one behind it. right, left: of v, as seen along h. */
static void cqi_cross_rows(cqi_labels *l, cq_index h, cq_index right, cq_index left, int down, cq_index *tail)
{
    const cq_mesh *m = l->mesh;
    const cq_index v = m->origin[h], odd = cq_target(m, h), back = m->twin[h];
    cq_index far, w, frame[4];
    if (cqi_label(l, odd) != CQI_UNLABELLED || m->valence[odd] > CQ_MAX_VALENCE) return;
    right = cqi_carry_if(m, h, right, 0);
    left = cqi_carry_if(m, h, left, 1);
    far = cqi_go_on(l, h, right, left);
    if (far == CQ_NONE) return;
    w = cq_target(m, far);
    if (cqi_is_odd(l, w) || w == v) return;
    if (cq_counterclockwise(m, far) == back || cq_clockwise(m, far) == back) return;
    cqi_make_odd(l, odd, v, w);
    if (cqi_label(l, w) != CQI_UNLABELLED) return;
    right = cqi_carry_if(m, far, right, 0);
    left = cqi_carry_if(m, far, left, 1);
    frame[down ? CQI_UP : CQI_DOWN] = m->twin[far];
    frame[down ? CQI_DOWN : CQI_UP] = cqi_go_on(l, far, right, left);
    frame[down ? CQI_LEFT : CQI_RIGHT] = right;
    frame[down ? CQI_RIGHT : CQI_LEFT] = left;
    cqi_begin_frame(l, w, frame, tail);
}

/* Goes right or left, along h: to an even vertex of the same row. */
static void cqi_along_row(cqi_labels *l, cq_index h, const cq_index *f, int left, cq_index *tail)
{
    const cq_mesh *m = l->mesh;
    cq_index frame[4];
    if (h == CQ_NONE) return;
    frame[CQI_UP] = cqi_carry_if(m, h, f[CQI_UP], !left);
    frame[CQI_DOWN] = cqi_carry_if(m, h, f[CQI_DOWN], left);
    frame[left ? CQI_RIGHT : CQI_LEFT] = m->twin[h];
    frame[left ? CQI_LEFT : CQI_RIGHT] = CQ_NONE;
    if (frame[CQI_UP] != CQ_NONE || frame[CQI_DOWN] != CQ_NONE) cqi_begin_frame(l, cq_target(m, h), frame, tail);
}

/* A wave of strips from the origin of `up`; it ends when `most` even vertices have had their turn. */
static void cqi_strip_wave(cqi_labels *l, cq_index up, cq_index most)
{
    const cq_mesh *m = l->mesh;
    cq_index head = 0, tail = 0, f[4];
    int k;
    f[CQI_UP] = up;
    f[CQI_RIGHT] = f[CQI_LEFT] = CQ_NONE;
    f[CQI_DOWN] = cqi_straightest(l, cq_target(m, up), up);
    cqi_begin_frame(l, m->origin[up], f, &tail);
    while (head < tail && head < most) {
        const cq_index v = l->queue[head++];
        for (k = 0; k < 4; k++) f[k] = *cqi_frame(l, v, k);
        cqi_complete_frame(l, f);
        if (f[CQI_UP] != CQ_NONE) cqi_cross_rows(l, f[CQI_UP], f[CQI_RIGHT], f[CQI_LEFT], 0, &tail);
        if (f[CQI_DOWN] != CQ_NONE) cqi_cross_rows(l, f[CQI_DOWN], f[CQI_LEFT], f[CQI_RIGHT], 1, &tail);
        cqi_along_row(l, f[CQI_RIGHT], f, 0, &tail);
        cqi_along_row(l, f[CQI_LEFT], f, 1, &tail);
    }
}

/* A spoke of v whose end is real. */
static cq_index cqi_real_spoke(const cq_mesh *m, cq_index v)
{
    const cq_index h = m->out[v];
    return cq_is_virtual(m, cq_target(m, h)) ? cq_counterclockwise(m, h) : h;
}

/* Waves of strips from the seed, then from vertices that none has reached. */
static void cqi_label_strips(cqi_labels *l, cq_index seed)
{
    const cq_mesh *m = l->mesh;
    cq_index v;
    cqi_clear_labels(l);
    cqi_strip_wave(l, cqi_real_spoke(m, seed), CQ_NONE);
    for (v = 0; v < m->num_vertices; v++)
        if (cqi_label(l, v) == CQI_UNLABELLED) cqi_strip_wave(l, cqi_real_spoke(m, v), CQ_NONE);
}

/* Is the mesh one of quads? In these, of the first vertices that a wave of strips reaches, 42 % or more are odd; in
 * other meshes less than 40 %. Frames need as many faces as vertices, for their memory. */
static int cqi_are_quads(cqi_labels *l, cq_index seed)
{
    const cq_mesh *m = l->mesh;
    cq_index v, odd, even = 0;
    if (!l->positions || cqi_face_slots(m) < cqi_vertex_slots(m)) return 0;
    cqi_clear_labels(l);
    cqi_strip_wave(l, cqi_real_spoke(m, seed), CQI_STRIP_SAMPLE);
    odd = l->clock;
    for (v = 0; v < m->num_vertices; v++)
        if (m->out[v] != CQ_NONE) even = (cq_index)(even + (cqi_label(l, v) == CQI_EVEN));
    return (uint64_t)odd * 58 >= (uint64_t)even * 42;
}

/* -- Regular levels: repair --
 *
 * As long as there is a polygon that cannot be coded, one of its odd vertices becomes even: the one that leaves the
 * fewest such polygons around it; of several the one that was labelled last. That adds cut edges only at this vertex,
 * and each piece of a polygon that they cut has a face there: so only the faces there are checked again. This ends, as
 * each face is a polygon when no odd vertex is left; but if half of the odd vertices must go, the level is given up,
 * which bounds the time. */

enum { CQI_WAITS = 1, CQI_LISTED_FACE = 2, CQI_OF_FOUR = 4 }; /* bits of a face: to be checked; in the list of those
                                                                 that wait; its polygon has 4 corners */

static void cqi_wait(cqi_labels *l, cq_index f)
{
    if (!(l->face[f] & CQI_LISTED_FACE)) l->waiting[l->num_waiting++] = f;
    l->face[f] = CQI_WAITS | CQI_LISTED_FACE;
}

static void cqi_make_even(cqi_labels *l, cq_index v)
{
    const cq_mesh *m = l->mesh;
    cq_index h = m->out[v];
    l->label[v] = CQI_EVEN;
    l->since[v] = 0;
    if (l->spare) l->spare--;
    do {
        cqi_wait(l, (cq_index)(h / 3));
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
}

/* Number of polygons around an even vertex that cannot be coded. Each begins at a cut edge. */
static int cqi_count_bad(const cqi_labels *l, cq_index v)
{
    const cq_mesh *m = l->mesh;
    cqi_polygon p;
    cq_index h = m->out[v];
    int bad = 0;
    do {
        bad += cqi_is_cut(l, h) && !cqi_read_polygon(l, (cq_index)(h / 3), &p);
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    return bad;
}

/* The odd vertex of a region that becomes even. */
static cq_index cqi_choose_even(cqi_labels *l, const cqi_polygon *region)
{
    cq_index best = CQ_NONE;
    int k, least = 0;
    for (k = 0; k < 3 * region->faces; k++) {
        const cq_index v = l->mesh->origin[3 * region->face[k / 3] + (cq_index)(k % 3)];
        int bad;
        if (!cqi_is_odd(l, v) || v == best) continue;
        l->label[v] = CQI_EVEN;
        bad = cqi_count_bad(l, v);
        l->label[v] = CQI_ODD;
        if (best != CQ_NONE && (bad > least || (bad == least && l->since[v] <= l->since[best]))) continue;
        best = v;
        least = bad;
    }
    return best;
}

/* Notes that a polygon has been checked: its corners are to be looked around again, and may be filled. */
static void cqi_note_polygon(cqi_labels *l, const cqi_polygon *p)
{
    int k;
    for (k = 0; k < p->corners; k++) l->label[cqi_place(l, p, p->corner[k])] |= CQI_LOOK_AROUND | CQI_MAY_FILL;
    for (k = 0; k < p->faces; k++) {
        uint8_t *face = &l->face[p->face[k]];
        *face = (uint8_t)((*face & CQI_LISTED_FACE) | (p->corners == 4 ? CQI_OF_FOUR : 0));
    }
}

static void cqi_repair(cqi_labels *l)
{
    cqi_polygon p;
    while (l->num_waiting && l->spare) {
        const cq_index f = l->waiting[--l->num_waiting];
        l->face[f] &= (uint8_t)~CQI_LISTED_FACE;
        if (!(l->face[f] & CQI_WAITS)) continue;
        if (cqi_read_polygon(l, f, &p)) {
            cqi_note_polygon(l, &p);
        } else {
            cqi_wait(l, f);
            cqi_read_region(l, f, CQI_REGION_FACES, &p);
            cqi_make_even(l, cqi_choose_even(l, &p));
        }
    }
}

static void cqi_wait_all(cqi_labels *l)
{
    const cq_mesh *m = l->mesh;
    cq_index f;
    memset(l->face, 0, cqi_face_slots(m));
    l->num_waiting = 0;
    for (f = cqi_face_slots(m); f--;)
        if (cqi_is_face(m, f)) cqi_wait(l, f);
}

/* -- Regular levels: what lies around an even vertex --
 *
 * Where condition 3 above does not hold, odd vertices become even until it does. */

#define CQI_ROUNDS 64

/* The odd vertex of a polygon that was labelled last, or CQ_NONE. */
static cq_index cqi_last_odd(const cqi_labels *l, const cqi_polygon *p)
{
    cq_index last = CQ_NONE;
    int k;
    for (k = 0; k < p->size; k++) {
        const cq_index v = cqi_place(l, p, k);
        if (cqi_is_odd(l, v) && (last == CQ_NONE || l->since[v] > l->since[last])) last = v;
    }
    return last;
}

/* Lists vertex w as one that lies around; `odd` is the odd vertex that puts it there, or CQ_NONE. since[w] becomes its
 * place in the list. If w is listed already, returns the odd vertex that is to become even. */
static cq_index cqi_note_around(cqi_labels *l, cq_index *n, cq_index w, cq_index odd)
{
    if (l->mesh->mark[w] & CQI_SCRATCH) return odd == CQ_NONE ? l->waiting[l->since[w]] : odd;
    l->mesh->mark[w] |= CQI_SCRATCH;
    l->since[w] = *n;
    l->queue[*n] = w;
    l->waiting[(*n)++] = odd;
    return CQ_NONE;
}

/* Adds an odd vertex to those in conflict, a list that grows down from the end of the queue. The other list there has
 * even vertices only, so both fit. */
static void cqi_list_conflict(cqi_labels *l, cq_index odd, cq_index *conflicts)
{
    if (odd == CQ_NONE || l->label[odd] & CQI_CONFLICT) return;
    l->label[odd] |= CQI_CONFLICT;
    l->queue[cqi_vertex_slots(l->mesh) - ++*conflicts] = odd;
}

/* The end of a side that leaves v along h, and the odd vertex on it. */
static cq_index cqi_side_end(const cqi_labels *l, cq_index v, cq_index h, cq_index *odd)
{
    const cq_index w = cq_target(l->mesh, h);
    *odd = cqi_is_odd(l, w) ? w : CQ_NONE;
    return *odd == CQ_NONE ? w : l->parent[l->parent[0][w] == v][w];
}

/* The corner opposite v in the polygon of 4 corners that face f lies in. */
static cq_index cqi_opposite_corner(const cqi_labels *l, cq_index v, cq_index f, cqi_polygon *p)
{
    int k, of_v = 0;
    cqi_read_region(l, f, CQI_POLYGON_FACES, p);
    p->corners = 0;
    for (k = 0; k < p->size; k++) {
        const cq_index w = cqi_place(l, p, k);
        if (cqi_is_odd(l, w)) continue;
        if (w == v) of_v = p->corners;
        p->corner[p->corners++ & 3] = k;
    }
    return cqi_place(l, p, p->corner[(of_v + 2) & 3]);
}

/* Lists the odd vertices near v that must become even because a vertex lies around v twice; returns their number. */
static cq_index cqi_find_conflicts(cqi_labels *l, cq_index v)
{
    const cq_mesh *m = l->mesh;
    cq_index h = m->out[v], n = 0, conflicts = 0, odd, w;
    cqi_polygon p;
    do {
        if (cqi_is_cut(l, h)) {
            w = cqi_side_end(l, v, h, &odd);
            cqi_list_conflict(l, cqi_note_around(l, &n, w, odd), &conflicts);
            if (l->face[h / 3] & CQI_OF_FOUR) {
                w = cqi_opposite_corner(l, v, (cq_index)(h / 3), &p);
                cqi_list_conflict(l, cqi_note_around(l, &n, w, cqi_last_odd(l, &p)), &conflicts);
            }
        }
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    while (n) m->mark[l->queue[--n]] &= (uint8_t)~CQI_SCRATCH;
    return conflicts;
}

/* Makes vertices even until there is no conflict; corners of polygons that have changed are looked around again. 0
 * after too many rounds, which bounds the time at vertices with many neighbours; or if the repair has given up, so that
 * faces no longer say what their polygons are. */
static int cqi_settle(cqi_labels *l)
{
    const cq_mesh *m = l->mesh;
    int rounds, again = 1;
    for (rounds = 0; again && rounds < CQI_ROUNDS; rounds++) {
        cq_index v, k, conflicts;
        again = 0;
        for (v = 0; v < cqi_vertex_slots(m) && l->spare; v++) {
            if (!(l->label[v] & CQI_LOOK_AROUND)) continue;
            l->label[v] &= (uint8_t)~CQI_LOOK_AROUND;
            conflicts = cqi_find_conflicts(l, v);
            for (k = 1; k <= conflicts; k++) {
                const cq_index odd = l->queue[cqi_vertex_slots(m) - k];
                if (!cqi_is_odd(l, odd)) continue;
                cqi_make_even(l, odd);
                cqi_repair(l);
                again = 1;
            }
        }
    }
    return !again && l->spare;
}

/* -- Regular levels: limits --
 *
 * On a mesh with sharp edges, an odd vertex becomes even if its parents' edge runs too far from the surface: so sharp
 * edges survive in the coarse mesh, which then predicts better. The distance is that from the planes of the faces
 * around the vertex to the point of the parents' edge that is nearest to it. */

#define CQI_LIMIT 8 /* steps */
#define CQI_NORMAL_BITS 12

/* The point of the segment from a to b that is nearest to the origin, times 16. Offsets have CQI_OFFSET_BITS bits, so
 * products have 2 * 13 + 2; the result has 18. */
static cqi_vector cqi_nearest_point(cqi_vector a, cqi_vector b)
{
    const cqi_vector along = cqi_minus(b, a);
    const int64_t length = cqi_wide_dot(along, along), at = -cqi_wide_dot(a, along);
    const int64_t part = at <= 0 ? 0 : at >= length ? 4096 : at * 4096 / length;
    cqi_vector x;
    x.x = (int32_t)(16 * (int64_t)a.x + part * along.x / 256);
    x.y = (int32_t)(16 * (int64_t)a.y + part * along.y / 256);
    x.z = (int32_t)(16 * (int64_t)a.z + part * along.z / 256);
    return x;
}

/* Square of the distance of `point`, in 1/16, from the plane through the origin and a, b, in 1/256. The normal is
 * reduced to 12 bits, so its product with the point has 32, and the square of that 64. */
static uint64_t cqi_square_off_plane(cqi_vector a, cqi_vector b, cqi_vector point)
{
    cqi_vector normal = cqi_cross(a, b);
    int64_t product;
    const uint32_t bits = cqi_abs(normal.x) | cqi_abs(normal.y) | cqi_abs(normal.z);
    normal = cqi_shift(normal, cqi_bit_length(bits >> CQI_NORMAL_BITS));
    product = cqi_wide_dot(normal, point);
    product = product < 0 ? -product : product;
    return (uint64_t)product * (uint64_t)product / ((uint64_t)cqi_wide_dot(normal, normal) + !product);
}

/* Square of the distance between the edge a - b and the surface at v, in 1/256 square step. */
static uint64_t cqi_square_off(const cqi_labels *l, cq_index v, cq_index a, cq_index b)
{
    const cq_mesh *m = l->mesh;
    cqi_vector at[CQ_MAX_VALENCE + 1], nearest;
    int real[CQ_MAX_VALENCE + 1], n = 0, k, shift;
    cq_index h = m->out[v];
    uint32_t bits = 0;
    uint64_t most = 0;
    do {
        const cq_index w = cq_target(m, h);
        real[n] = !cq_is_virtual(m, w);
        if (real[n]) {
            at[n] = cqi_offset(l->positions, v, w);
            bits |= cqi_abs(at[n].x) | cqi_abs(at[n].y) | cqi_abs(at[n].z);
        }
        n++;
        h = cq_clockwise(m, h);
    } while (h != m->out[v]);
    shift = cqi_bit_length(bits >> CQI_OFFSET_BITS);
    for (k = 0; k < n; k++)
        if (real[k]) at[k] = cqi_shift(at[k], shift);
    nearest = cqi_nearest_point(cqi_shift(cqi_offset(l->positions, v, a), shift),
                                cqi_shift(cqi_offset(l->positions, v, b), shift));
    for (k = 0; k < n; k++) {
        const int next = cqi_next_of(k, n);
        const uint64_t square = real[k] && real[next] ? cqi_square_off_plane(at[k], at[next], nearest) : 0;
        if (square > most) most = square;
    }
    return most << 2 * shift;
}

static uint64_t cqi_square_limit(int64_t steps) { return (uint64_t)(256 * steps * steps); }

/* Does the edge a - b run too far from the surface at v for l->limit? */
static int cqi_is_too_far(const cqi_labels *l, cq_index v, cq_index a, cq_index b)
{
    return l->limit && cqi_square_off(l, v, a, b) > cqi_square_limit(l->limit);
}

/* Is the angle between the parents, as seen from an odd vertex, a right angle or less? */
static int cqi_is_acute(const cqi_labels *l, cq_index v)
{
    return cqi_wide_dot(cqi_offset(l->positions, v, l->parent[0][v]),
                        cqi_offset(l->positions, v, l->parent[1][v])) >= 0;
}

/* Marks the odd vertices with such an angle. Are they few? Then they were labelled across a fold; else the surface is
 * rough. */
static int cqi_are_few_acute(const cqi_labels *l)
{
    cq_index v, odd = 0, acute = 0;
    for (v = 0; l->positions && v < l->mesh->num_vertices; v++) {
        if (!cqi_is_odd(l, v)) continue;
        odd++;
        if (!cqi_is_acute(l, v)) continue;
        acute++;
        l->label[v] |= CQI_ACUTE;
    }
    return acute < odd / 64;
}

/* Marks odd vertices that are too far from the surface for l->limit. */
static void cqi_mark_far(cqi_labels *l)
{
    cq_index v;
    for (v = 0; l->limit && v < l->mesh->num_vertices; v++)
        if (cqi_is_odd(l, v) && cqi_is_too_far(l, v, l->parent[0][v], l->parent[1][v])) l->label[v] |= CQI_TOO_FAR;
}

/* Before polygons are checked, makes odd vertices even that are locked, across a fold, or too far for a limit. Returns
 * how many are left. */
static cq_index cqi_refuse(cqi_labels *l)
{
    const int few = cqi_are_few_acute(l), refused = (few ? CQI_ACUTE : 0) | (l->limit ? CQI_TOO_FAR : 0);
    cq_index v, odd = 0;
    for (v = 0; v < l->mesh->num_vertices; v++) {
        const int even = l->label[v] & refused || cqi_is_locked(l, v);
        l->label[v] = even ? CQI_EVEN : l->label[v] & CQI_LABEL;
        odd = (cq_index)(odd + (cq_index)cqi_is_odd(l, v));
    }
    return odd;
}

/* Does the mesh have sharp edges? Then distances of odd vertices are either small or large: of those above 8 steps,
 * three fifths are above 16, and an eighth is above 32; or more than an eighth, if many are above 8. Marks those above
 * 8 steps for cqi_refuse. */
static int cqi_has_sharp_edges(cqi_labels *l)
{
    cq_index odd = 0, far[3] = { 0, 0, 0 }, v;
    int k;
    for (v = 0; v < l->mesh->num_vertices; v++) {
        uint64_t square;
        if (!cqi_is_odd(l, v)) continue;
        square = cqi_square_off(l, v, l->parent[0][v], l->parent[1][v]);
        if (square > cqi_square_limit((int64_t)l->step * CQI_LIMIT)) l->label[v] |= CQI_TOO_FAR;
        for (k = 0; k < 3; k++)
            far[k] = (cq_index)(far[k] + (square > cqi_square_limit((int64_t)l->step * (CQI_LIMIT << k))));
        odd++;
    }
    return far[1] > odd / 128 && far[1] / 2 <= odd / 3 && far[1] / 3 >= far[0] / 5 &&
           (uint64_t)far[2] * 8 * odd >= (uint64_t)far[0] * odd + (uint64_t)far[0] * 4 * far[0];
}

/* -- Regular levels: filling --
 *
 * Vertices that the waves left even can often be odd, too: an even vertex v that is no parent, between two even
 * neighbours a and b. That joins the polygons around v into two, one on each side of a - v - b. Of the pairs a, b whose
 * polygons can be coded, the one with the lowest cost is taken, if that is less than one more dissolved edge costs. The
 * cost is the number of additional dissolved edges, plus four times the distance of v from the middle of its parents,
 * divided by the parents' distance. On a boundary, the parents are those along it. */

#define CQI_FILL_VALENCE 8
#define CQI_FILL_COST 64 /* of a dissolved edge */

/* The spokes of v, counter-clockwise. virtual_one: place of the virtual neighbour, or -1. */
typedef struct cqi_fill_ring {
    int size, virtual_one;
    cq_index spoke[CQI_FILL_VALENCE];
    uint8_t even[CQI_FILL_VALENCE];
} cqi_fill_ring;

static void cqi_read_fill_ring(const cqi_labels *l, cq_index v, cqi_fill_ring *r)
{
    const cq_mesh *m = l->mesh;
    cq_index h = m->out[v];
    r->size = 0;
    r->virtual_one = -1;
    do {
        if (cq_is_virtual(m, cq_target(m, h))) r->virtual_one = r->size;
        r->even[r->size] = !cqi_is_odd(l, cq_target(m, h));
        r->spoke[r->size++] = h;
        h = cq_counterclockwise(m, h);
    } while (h != m->out[v]);
}

/* Could places i and j be the parents? The even vertices on each side become corners: at most two, and a virtual vertex
 * must be alone on its side. */
static int cqi_are_opposite(const cqi_fill_ring *r, int i, int j)
{
    int inside = 0, outside = 0, k;
    if (!r->even[i] || !r->even[j]) return 0;
    for (k = 0; k < r->size; k++) {
        if (k == i || k == j) continue;
        if (k > i && k < j) inside += r->even[k];
        else outside += r->even[k];
    }
    if (inside > 2 || outside > 2) return 0;
    if (r->virtual_one < 0) return 1;
    k = (j - i + r->size) % r->size;
    if (r->virtual_one == i + 1) return k == 2;
    if (r->virtual_one == j + 1) return k == r->size - 2;
    return r->virtual_one == 0 && i == 1 && j == r->size - 1;
}

/* Four times the distance of v from the middle of a and b, divided by their distance, in 1/CQI_FILL_COST. */
static uint32_t cqi_fill_distance(const cqi_labels *l, cq_index v, cq_index a, cq_index b)
{
    cqi_vector to_a, to_b, sum;
    if (!l->positions) return 0;
    to_a = cqi_offset(l->positions, v, a);
    to_b = cqi_offset(l->positions, v, b);
    sum.x = to_a.x + to_b.x;
    sum.y = to_a.y + to_b.y;
    sum.z = to_a.z + to_b.z;
    to_a = cqi_minus(to_a, to_b);
    return (uint32_t)((uint64_t)2 * CQI_FILL_COST * cqi_square_root((uint64_t)cqi_wide_dot(sum, sum)) /
                      (cqi_square_root((uint64_t)cqi_wide_dot(to_a, to_a)) + (uint64_t)1));
}

/* Polygons of 4 corners around v. */
static int cqi_count_of_four(const cqi_labels *l, const cqi_fill_ring *r)
{
    int k, n = 0;
    for (k = 0; k < r->size; k++)
        n += cqi_is_cut(l, r->spoke[k]) && l->face[r->spoke[k] / 3] & CQI_OF_FOUR;
    return n;
}

/* Makes v odd, if there are parents for it. A failure is final until one of the polygons with the corner v changes. */
static int cqi_fill(cqi_labels *l, cq_index v)
{
    const cq_mesh *m = l->mesh;
    cqi_fill_ring r;
    cqi_polygon left, right;
    const uint8_t label = (uint8_t)(l->label[v] & ~CQI_MAY_FILL);
    int i, j, before, best_i = -1, best_j = -1, best = CQI_FILL_COST;
    cqi_read_fill_ring(l, v, &r);
    before = cqi_count_of_four(l, &r);
    l->label[v] = CQI_ODD;
    for (i = 0; i < r.size; i++)
        for (j = i + 2; j < r.size; j++) {
            int cost;
            if (!cqi_are_opposite(&r, i, j)) continue;
            l->parent[0][v] = cq_target(m, r.spoke[i]);
            l->parent[1][v] = cq_target(m, r.spoke[j]);
            cost = (int)cqi_fill_distance(l, v, l->parent[0][v], l->parent[1][v]) - CQI_FILL_COST * before;
            if (cost >= best || !cqi_read_polygon(l, (cq_index)(r.spoke[i] / 3), &left)) continue;
            cost += left.corners == 4 ? CQI_FILL_COST : 0;
            if (cost >= best || !cqi_read_polygon(l, (cq_index)(r.spoke[j] / 3), &right)) continue;
            cost += right.corners == 4 ? CQI_FILL_COST : 0;
            if (cost >= best || cqi_is_too_far(l, v, l->parent[0][v], l->parent[1][v])) continue;
            best = cost;
            best_i = i;
            best_j = j;
        }
    l->label[v] = label;
    if (best_i < 0) return 0;
    cqi_make_odd(l, v, cq_target(m, r.spoke[best_i]), cq_target(m, r.spoke[best_j]));
    cqi_read_polygon(l, (cq_index)(r.spoke[best_i] / 3), &left);
    cqi_read_polygon(l, (cq_index)(r.spoke[best_j] / 3), &right);
    cqi_note_polygon(l, &left);
    cqi_note_polygon(l, &right);
    l->since[l->parent[0][v]]++;
    l->since[l->parent[1][v]]++;
    return 1;
}

static void cqi_count_children(cqi_labels *l)
{
    const cq_mesh *m = l->mesh;
    cq_index v;
    for (v = 0; v < m->num_vertices; v++)
        if (!cqi_is_odd(l, v)) l->since[v] = 0;
    for (v = 0; v < m->num_vertices; v++) {
        if (!cqi_is_odd(l, v)) continue;
        l->since[l->parent[0][v]]++;
        l->since[l->parent[1][v]]++;
    }
}

#define CQI_FILL_PASSES 4
static void cqi_fill_all(cqi_labels *l)
{
    const cq_mesh *m = l->mesh;
    int pass;
    cqi_count_children(l);
    for (pass = 0; pass < CQI_FILL_PASSES; pass++) {
        cq_index v, n = 0;
        for (v = 0; v < m->num_vertices; v++)
            if ((l->label[v] & (CQI_LABEL | CQI_MAY_FILL)) == (CQI_EVEN | CQI_MAY_FILL) && l->since[v] == 0 &&
                m->valence[v] <= CQI_FILL_VALENCE && !cqi_is_locked(l, v))
                n = (cq_index)(n + (cq_index)cqi_fill(l, v));
        if (!n) break;
    }
}

/* -- Regular levels: the best labelling --
 *
 * Waves are tried, the best ones chosen, then repaired, filled and settled. */

/* A seed for waves: beginning at a place that depends on the number of the try, the first inner vertex that is
 * irregular, or with `eight` of valence 8; if there is none, any vertex. */
static cq_index cqi_find_seed(const cq_mesh *m, uint32_t try_number, int eight)
{
    const cq_index n = m->num_vertices, start = (cq_index)((try_number * 0x9e3779b9u >> 8) % n);
    cq_index k, any = CQ_NONE;
    for (k = 0; k < n; k++) {
        const cq_index v = (cq_index)((start + k) % n);
        if (m->out[v] == CQ_NONE) continue;
        if (any == CQ_NONE) any = v;
        if ((eight ? m->valence[v] == 8 : m->valence[v] != 6) && !cqi_on_boundary(m, v)) return v;
    }
    return any;
}

/* Labellings are tried until one is nearly as good as can be. Seeds are irregular vertices, which were there before the
 * subdivision. Waves across any even valence are for quads whose diagonals alternate, so that valences are 4 and 8;
 * they must begin at an 8. Elsewhere, waves that cross no valence but 6 leave more to filling. */
enum { CQI_ANY_VALENCE = 1, CQI_STRIPS = 12, CQI_NO_LABELS }; /* numbers of labellings; others below: valence 6 only */
#define CQI_MORE_LABELS(vertices) ((vertices) / 5 * 2)        /* with fewer odd ones, other seeds do not help */

/* The waves of a labelling. */
static void cqi_try_waves(cqi_labels *l, int number)
{
    const int any_valence = number == CQI_ANY_VALENCE;
    l->alike = number == CQI_STRIPS;
    if (number == CQI_STRIPS) cqi_label_strips(l, cqi_find_seed(l->mesh, 0, 0));
    else cqi_label_all(l, cqi_find_seed(l->mesh, (uint32_t)number, any_valence), any_valence);
}

/* Repairs what waves have labelled, so that all polygons can be coded. 0: too many odd vertices had to become even. */
static int cqi_finish_waves(cqi_labels *l)
{
    const cq_index odd = cqi_refuse(l);
    cqi_wait_all(l);
    l->spare = (cq_index)(odd / 2 + 1);
    cqi_repair(l);
    return l->spare != 0;
}

/* A complete labelling; returns the number of odd vertices. */
static cq_index cqi_label_with(cqi_labels *l, int number, int32_t limit)
{
    l->limit = limit;
    if (number != l->ready) {
        cqi_try_waves(l, number);
        cqi_mark_far(l);
    }
    l->ready = CQI_NO_LABELS;
    if (!cqi_finish_waves(l)) return 0;
    cqi_fill_all(l);
    return cqi_settle(l) ? cqi_count_odd(l) : 0;
}

static cq_index cqi_count_live(const cq_mesh *m)
{
    cq_index v, n = 0;
    for (v = 0; v < m->num_vertices; v++) n = (cq_index)(n + (m->out[v] != CQ_NONE));
    return n;
}

/* Number of odd vertices if nearly all faces were made by cutting coarse ones in four: one on each coarse edge. No
 * labelling can have many more. */
static cq_index cqi_all_odd(const cq_mesh *m)
{
    cq_index f, faces = 0, boundary = 0;
    for (f = 0; f < m->num_faces; f++) faces = (cq_index)(faces + (cq_index)cqi_is_face(m, f));
    for (f = m->first_virtual_face; f < cqi_face_slots(m); f++)
        boundary = (cq_index)(boundary + (cq_index)cqi_is_face(m, f));
    return (cq_index)(faces / 8 * 3 + boundary / 4 - faces / 512);
}

/* Numbers of odd vertices that no waves can exceed, across valence 6 and across any even valence: inner ones of such a
 * valence, and every second one on a boundary. */
static void cqi_bound_odd(const cq_mesh *m, cq_index *bound)
{
    cq_index v, h, six = 0, even = 0, boundary = 0;
    for (v = 0; v < m->num_vertices; v++) {
        if (m->out[v] == CQ_NONE) continue;
        six = (cq_index)(six + (m->valence[v] == 6));
        even = (cq_index)(even + !(m->valence[v] & 1));
    }
    for (h = (cq_index)(3 * m->first_virtual_face); h < 3 * cqi_face_slots(m); h++) {
        if (!cqi_is_face(m, (cq_index)(h / 3)) || !cq_is_virtual(m, m->origin[h])) continue;
        v = cq_target(m, h);
        six = (cq_index)(six - (m->valence[v] == 6));
        even = (cq_index)(even - !(m->valence[v] & 1));
        boundary++;
    }
    bound[0] = (cq_index)(six + boundary / 2);
    bound[1] = (cq_index)(even + boundary / 2);
}

/* The labelling whose waves make the most vertices odd. As later stages mostly lessen that, only this one is completed.
 * Waves across any valence make a third of any mesh odd, much of which the repair undoes, so a third is subtracted. */
static int cqi_choose_labelling(cqi_labels *l)
{
    const cq_index live = cqi_count_live(l->mesh);
    const cq_index all = cqi_all_odd(l->mesh);
    const uint64_t enough = (uint64_t)live * (uint32_t)cqi_at_most(l->least, l->strips) / 1000;
    cq_index most = 0, bound[2];
    int k, chosen = CQI_NO_LABELS;
    l->limit = 0;
    cqi_bound_odd(l->mesh, bound);
    bound[1] = (cq_index)(bound[1] - bound[1] / 3);
    for (k = 0; k < CQI_STRIPS && most < all; k++) {
        cq_index n;
        if (k == 2 && most < CQI_MORE_LABELS(live)) break;
        if (bound[k == CQI_ANY_VALENCE] < enough && bound[k == CQI_ANY_VALENCE] < CQI_MORE_LABELS(live)) continue;
        cqi_try_waves(l, k);
        l->ready = k;
        n = l->clock; /* odd vertices so far: none has become even again */
        if (k == CQI_ANY_VALENCE) n = (cq_index)(n - n / 3);
        if (k > CQI_ANY_VALENCE && n == most) break; /* another seed that finds as many: so will others */
        if (n <= most) continue;
        most = n;
        chosen = k;
    }
    l->found = (int)((uint64_t)most * 1000 / live);
    if (l->found >= l->least) return chosen;
    l->ready = CQI_NO_LABELS;
    return l->found < l->strips && cqi_are_quads(l, cqi_find_seed(l->mesh, 0, 0)) ? CQI_STRIPS : CQI_NO_LABELS;
}

/* Labels the mesh of l; returns the number of odd vertices. With sharp edges, a limit is used if enough pass. */
static cq_index cqi_find_labels(cqi_labels *l)
{
    const int number = cqi_choose_labelling(l);
    cq_index n;
    if (number == CQI_NO_LABELS) return 0;
    if (number != l->ready) cqi_try_waves(l, number);
    l->ready = number;
    l->is_sharp = l->step && cqi_has_sharp_edges(l);
    if (l->is_sharp) {
        n = cqi_label_with(l, number, CQI_LIMIT * l->step);
        if (n > cqi_count_live(l->mesh) / 3) return n;
    }
    return cqi_label_with(l, number, 0);
}

/* The labels by which the notes were written, see cqi_undo_level. */
static void cqi_recall_labels(cqi_labels *l, const cqi_collapse *note, cq_index count)
{
    cq_index k;
    memset(l->label, CQI_EVEN, cqi_vertex_slots(l->mesh));
    for (k = 0; k < count; k++) cqi_make_odd(l, note[k].removed, note[k].kept, note[k].face[0]);
}

/* -- Regular levels: undoing one --
 *
 * Polygons are flipped back to coarse faces, then odd vertices collapsed into a parent. */

/* Flips an edge back, with the wedges of its corners. */
static void cqi_undo_flip(const cqi_labels *l, cq_mesh *m, cq_index h)
{
    const cq_index g = m->twin[h];
    if (l->index) {
        l->uses[l->index[h]]--;
        l->uses[l->index[g]]--;
        l->uses[l->index[cq_prev(h)]]++;
        l->uses[l->index[cq_prev(g)]]++;
        (void)cqi_flip_index(m, l->index, h);
    }
    cqi_flip(m, h);
}

/* Adds what a polygon knows to the labels of the odd vertices on its sides, and flips it back to coarse faces. */
static void cqi_undo_polygon(cqi_labels *l, cq_mesh *m, const cqi_polygon *p)
{
    cq_index at[CQI_POLYGON_FACES + 2];
    int k;
    for (k = 0; k < p->size; k++) at[k] = cqi_place(l, p, k);
    for (k = 0; k < p->corners; k++) {
        const cq_index a = at[p->corner[k]], odd = at[cqi_next_place(p, p->corner[k])];
        if (cqi_is_marked(p, k))
            l->label[odd] |= (uint8_t)(cqi_side_of(p, k) << (l->parent[0][odd] == a ? 2 : 5));
    }
    for (k = 0; k < p->undone; k++) {
        const cq_index x = at[p->undo[k][0]], y = at[p->undo[k][1]];
        cqi_undo_flip(l, m, cqi_is_odd(l, x) ? cqi_find_spoke(m, x, y) : cqi_find_spoke(m, y, x));
    }
}

/* Can this edge at an odd vertex be flipped within its coarse face, as the vertex has another edge inside it? */
static int cqi_is_extra(const cqi_labels *l, cq_index h)
{
    const cq_mesh *m = l->mesh;
    return !cqi_is_cut(l, h) &&
           (cqi_is_odd(l, m->origin[cq_prev(h)]) || cqi_is_odd(l, m->origin[cq_prev(m->twin[h])]));
}

/* Before v is collapsed along h into its first parent: its corners get the parent's wedges. *wedge becomes v's wedge on
 * the left of the way from the first parent to the other one; `uses` of that, the one on the right. */
static void cqi_undo_index(const cqi_labels *l, const cq_mesh *m, cq_index h, cq_index *wedge)
{
    const cq_index t = m->twin[h], left = cq_next(m->twin[cq_next(t)]), right = m->twin[cq_prev(h)];
    const int is_left = cqi_is_real_face(m, t), is_right = cqi_is_real_face(m, h);
    const cq_index of_left = l->index[is_left ? cq_next(t) : h], of_right = l->index[is_right ? h : cq_next(t)];
    if (is_left) {
        l->uses[l->index[cq_prev(t)]]--;
        l->index[left] = l->index[t];
    }
    if (is_right) {
        l->uses[l->index[cq_prev(h)]]--;
        l->index[right] = l->index[cq_next(h)];
    }
    l->uses[of_left] = of_right;
    *wedge = of_left;
}

/* Takes an odd vertex out of its edge: flips until it has four neighbours, then collapses it into a parent. */
static void cqi_undo_odd(cqi_labels *l, cq_mesh *m, cq_index v, cq_index *wedge)
{
    cq_index first, last, h = m->out[v];
    while (m->valence[v] > 4) {
        if (cqi_is_extra(l, h)) {
            cqi_undo_flip(l, m, h);
            h = m->out[v];
        } else {
            h = cq_clockwise(m, h);
        }
    }
    l->label[v] = (uint8_t)((l->label[v] & ~CQI_LABEL) | CQI_EVEN);
    h = cqi_find_spoke(m, v, l->parent[0][v]);
    if (l->index) cqi_undo_index(l, m, h, wedge);
    cq_mesh_collapse(m, m->twin[h], &first, &last);
}

/* Undoes the level on the mesh, which l was made for, and writes a note for each odd vertex. */
static void cqi_undo_level(cqi_labels *l, cq_mesh *m, cqi_collapse *note, uint32_t level)
{
    cq_index f, v;
    cqi_polygon p;
    memset(l->face, 0, cqi_face_slots(m));
    for (f = 0; f < cqi_face_slots(m); f++) {
        int k;
        if (!cqi_is_face(m, f) || l->face[f]) continue;
        cqi_read_polygon(l, f, &p);
        for (k = 0; k < p.faces; k++) l->face[p.face[k]] = 1;
        cqi_undo_polygon(l, m, &p);
    }
    for (v = 0; v < m->num_vertices; v++) {
        if (!cqi_is_odd(l, v)) continue;
        note->face[1] = CQ_NONE;
        cqi_undo_odd(l, m, v, &note->face[1]);
        note->removed = v;
        note->kept = l->parent[0][v];
        note->face[0] = l->parent[1][v];
        note->p = l->label[v] >> 2 & 7;
        note->q = l->label[v] >> 5;
        note->first = 0;
        note->level = (uint8_t)level;
        note++;
    }
}

/* -- Encoder: input and memory -- */

static cq_result cqi_check_channel(const cq_input *in, uint32_t k, cq_place *place)
{
    const cq_channel *channel = &in->shape.channel[k];
    const int per_face = channel->merge == CQ_PER_FACE;
    size_t i, c, n = per_face ? in->shape.num_faces : in->shape.num_vertices;
    if (!cqi_channel_is_valid(channel) || !in->values[k] || channel->kind == CQ_TURNED) return CQ_ERROR_ARGUMENT;
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
    for (k = 0; in->shape.num_materials > 1 && k < in->shape.num_faces; k++)
        if (in->materials[k] >= in->shape.num_materials)
            return cqi_error(place, CQ_ERROR_VALUE, (cq_index)k, CQ_NONE, CQ_NONE);
    for (k = 0; k < in->shape.num_channels && result == CQ_OK; k++) result = cqi_check_channel(in, k, place);
    return result;
}

/* Lays out what follows the encoder's struct. What is attached to faces is in the memory of the replay, which begins
 * when all is measured. */
static void cqi_encoder_carve(cqi_encoder *e, const cq_input *in, cqi_arena *arena)
{
    cqi_plan *p = &e->plan;
    const cq_shape *s = &in->shape;
    size_t v = cqi_all_vertices(s), f = cqi_all_faces(s);
    p->most_samples = cqi_most_samples(v);
    p->sample = (cqi_sample *)cqi_take(arena, p->most_samples, sizeof(cqi_sample));
    p->note = (cqi_collapse *)cqi_take(arena, v + 1, sizeof(cqi_collapse));
    p->decoded = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->to_input = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    p->seed = (cqi_seed *)cqi_take(arena, v, sizeof(cq_index)); /* a component has three vertices or more */
    p->walk.capacity = (cq_index)(f / 3 + 1);
    p->walk.queue = (cq_index *)cqi_take(arena, p->walk.capacity, sizeof(cq_index));
    p->face_input = (cq_index *)cqi_take(arena, f, sizeof(cq_index));
    p->face_decoded = (cq_index *)cqi_take(arena, f, sizeof(cq_index));
    p->passed = (uint8_t *)cqi_take(arena, v, 1);
    memset(p->passed, 0, v);
    memset(p->face_decoded, 0xff, f * sizeof(cq_index));
    p->input = in->values;
    p->follows_faces = in->face_map || cqi_all_components(s, CQI_OF_FACE) || s->num_materials;
    p->materials = in->materials;
    p->clean = in->clean;
    p->metadata = in->metadata;
    e->replay.shape = *s;
    e->replay.plan = p;
    e->replay.memory = arena->next;
    e->replay.memory_size = arena->left;
    p->attached = (cq_index *)cqi_take(arena, f, sizeof(cq_index));
    p->follower = (cq_index *)cqi_take(arena, v, sizeof(cq_index));
    memset(p->attached, 0xff, f * sizeof(cq_index));
}

static void cqi_progress(const cq_input *in, uint32_t done)
{
    if (in->progress) in->progress(in->user, done, 2 * in->shape.num_vertices);
}

/* Positions of the mesh vertices. */
static const cq_value *cqi_gather_positions(const cqi_plan *p, const cq_input *in, int channel, cq_value *scratch)
{
    size_t v;
    if (!p->row_of_vertex) return in->values[channel];
    for (v = 0; v < in->shape.num_vertices; v++)
        memcpy(scratch + 3 * v, in->values[channel] + 3 * (size_t)p->row_of_vertex[v], 3 * sizeof(cq_value));
    return scratch;
}

/* Chooses the positions that are measured, and with CQ_BALANCED decide collapses. scratch: room for these. */
static void cqi_set_goal(cqi_plan *p, const cq_input *in, cq_value *scratch)
{
    const int channel = cqi_context_channel(&in->shape);
    p->most_quadric = CQI_ANY_QUADRIC;
    if (channel < 0) return;
    p->measured = cqi_gather_positions(p, in, channel, scratch);
    if (in->goal == CQ_LEAST_CONNECTIVITY) return;
    p->positions = p->measured;
    p->most_quadric = cqi_first_limit(p, (cq_index)in->shape.num_vertices);
}

/* -- Encoder: components -- */

/* Longest side of the bounding box of a component; without positions, its number of vertices. */
static cq_index cqi_component_size(const cqi_plan *p, cq_index root)
{
    cq_value low[3], high[3];
    cq_index v = root, n = 0, longest = 0;
    int k;
    for (k = 0; p->measured && k < 3; k++) low[k] = high[k] = p->measured[3 * (size_t)root + (size_t)k];
    for (; v != CQ_NONE; v = p->decoded[v], n++) {
        for (k = 0; p->measured && k < 3; k++) {
            const cq_value x = p->measured[3 * (size_t)v + (size_t)k];
            if (x < low[k]) low[k] = x;
            if (x > high[k]) high[k] = x;
        }
    }
    for (k = 0; p->measured && k < 3; k++)
        if ((cq_index)(high[k] - low[k]) > longest) longest = (cq_index)(high[k] - low[k]);
    return p->measured ? longest : n;
}

/* Simplifies a component, level by level. A note of level 0 comes before its collapses. `kept` of the note after them,
 * which is the one of level 0 of the next component, is the component's size. */
static void cqi_simplify_component(cqi_plan *p, cqi_seed *seed, uint32_t most_quadric)
{
    const cq_index size = cqi_component_size(p, seed->notes);
    p->note[p->num_notes++].level = 0;
    p->most_quadric = most_quadric;
    p->tries = 0;
    p->level = p->num_regular + 1;
    while (p->level <= CQ_MAX_LEVELS) {
        const cq_index notes = p->num_notes;
        p->refused_quadric = CQI_ANY_QUADRIC;
        if (cqi_simplify(p, seed)) {
            if (p->measured) cqi_measure_level(p, seed->notes, notes);
            p->level++;
            p->tries = 0;
            if (p->most_quadric != CQI_ANY_QUADRIC) p->most_quadric += CQI_LEVEL_QUADRIC;
        } else if (p->most_quadric != CQI_ANY_QUADRIC) {
            cqi_allow_more_quadric(p);
        } else if (p->tries < 2) {
            p->tries++;
        } else {
            break;
        }
    }
    seed->notes = p->num_notes;
    p->note[p->num_notes].kept = size;
    if (p->num_levels < p->level - 1) p->num_levels = p->level - 1;
}

/* One pass of a radix sort of components by their sizes, large ones first. */
static void cqi_sort_by_size(const cqi_plan *p, const cqi_seed *from, cqi_seed *to, int shift)
{
    cq_index end[256], k;
    memset(end, 0, sizeof end);
    for (k = 0; k < p->num_seeds; k++) end[255 - (p->note[from[k].notes].kept >> shift & 255)]++;
    cqi_sum_counts(end, 256);
    for (k = 0; k < p->num_seeds; k++) to[end[255 - (p->note[from[k].notes].kept >> shift & 255)]++] = from[k];
}

/* Sorts the components: those with more levels come first, and of these the larger ones. `sorted` is scratch. */
static void cqi_sort_components(cqi_plan *p, cqi_seed *sorted)
{
    cq_index end[CQ_MAX_LEVELS + 1], k;
    int level;
    for (level = 0; level < CQ_INDEX_BITS; level += 16) {
        cqi_sort_by_size(p, p->seed, sorted, level);
        cqi_sort_by_size(p, sorted, p->seed, level + 8);
    }
    memset(end, 0, sizeof end);
    for (k = 0; k < p->num_seeds; k++) end[CQ_MAX_LEVELS - p->note[p->seed[k].notes - 1].level]++;
    cqi_sum_counts(end, CQ_MAX_LEVELS + 1);
    for (k = 0; k < p->num_seeds; k++)
        sorted[end[CQ_MAX_LEVELS - p->note[p->seed[k].notes - 1].level]++] = p->seed[k];
    if (p->num_seeds) memcpy(p->seed, sorted, p->num_seeds * sizeof *sorted);
}

/* -- How far a regular level is from the exact surface --
 *
 * Each vertex that has been removed is attached to the nearest face that a walk finds. It begins with the faces around
 * a vertex nearby that is left; then it tries those around the corners of the best face, as long as that helps. */

/* Tries the faces around a vertex until one is near enough. */
static void cqi_try_around(const cqi_plan *p, cq_index centre, cq_index v, cqi_nearest *n)
{
    const cq_mesh *m = &p->mesh;
    const uint32_t enough = cqi_error_now(p);
    cq_index h = m->out[centre];
    int k = 0;
    do {
        cqi_try_face(p, h, v, n);
        h = cq_clockwise(m, h);
    } while (h != m->out[centre] && (n->error == UINT32_MAX || (n->error > enough && ++k < CQ_MAX_VALENCE)));
}

static void cqi_measure_vertex(cqi_plan *p, cq_index v, cq_index near)
{
    const cq_mesh *m = &p->mesh;
    cq_index before = CQ_NONE;
    cqi_nearest n;
    int k, step;
    n.error = UINT32_MAX;
    cqi_try_around(p, near, v, &n);
    for (step = 0; step < 16 && n.h != before && n.error > cqi_error_now(p); step++) {
        before = n.h;
        for (k = 0; k < 3; k++) cqi_try_around(p, m->origin[cqi_corner(before, k)], v, &n);
    }
    cqi_push(p, &p->attached[n.h / 3], v);
    if (n.error > cqi_error_now(p)) p->level_error[p->level] = cqi_error_code(n.error);
}

/* Measures a level that has been undone. p->decoded[v] becomes a vertex near v that is left, for each removed v: coarse
 * levels come first, so that the vertices of finer ones find one. */
static void cqi_measure_regular(cqi_plan *p, const cq_shape *s)
{
    cq_index k = p->num_notes;
    p->level_error[p->level] = p->level_error[p->level - 1];
    memset(p->attached, 0xff, cqi_all_faces(s) * sizeof(cq_index));
    while (k--) {
        const cq_index v = p->note[k].removed, kept = p->note[k].kept;
        p->decoded[v] = p->mesh.out[kept] == CQ_NONE ? p->decoded[kept] : kept;
        cqi_measure_vertex(p, v, p->decoded[v]);
    }
}

/* May there be regular levels? Decoded faces must be found by their vertices in the end, see cqi_match_face. */
static int cqi_may_be_regular(const cqi_plan *p, const cq_input *in)
{
    return (!p->copies_rows || p->corners) && !in->conquest_only && cqi_allows_regular(&in->shape);
}

/* Regular levels have paid on all meshes without sharp edges that have CQI_SMALL vertices or more, of which waves make
 * CQI_SURELY per mille or more odd; conquest levels alone are then not tried. */
#define CQI_SURELY 620
#define CQI_SMALL 750

/* Is a mesh of this many vertices large, and the one before its finest level near it: with an error below 3/2 of the
 * span of the positions, divided by the square root of the number of vertices? Counts in 1/4096 of the span. */
static int cqi_is_near_before(const cqi_plan *p, const cqi_labels *l, cq_index live)
{
    const uint64_t error = l->step ? cqi_error_of_code(p->level_error[1]) / 16 / (uint32_t)l->step : 0;
    return live >= CQI_SMALL && error < 4096 && error * error * live < (uint64_t)6144 * 6144;
}

/* Are the labels of the finest level good enough? A mesh with copied rows takes time to prepare: to prepare it again
 * just to compare is not worth it, so there the level must be sure to pay. */
static int cqi_is_worth_comparing(const cqi_plan *p, const cqi_labels *l, cq_index live)
{
    return !p->copies_rows || p->num_regular || (l->found >= CQI_SURELY && live >= CQI_SMALL && !l->limit);
}

/* The labels of the next regular level: those that are known, or the best ones. Returns the number of odd vertices. */
static cq_index cqi_next_labels(const cqi_plan *p, cqi_known *known, cqi_labels *l)
{
    const uint32_t level = p->num_regular + 1;
    if (level > known->levels) {
        known->count_of[level] = cqi_find_labels(l);
        known->alike[level] = (uint8_t)l->alike;
        if (level > 1) return known->count_of[level];
        known->is_sharp = l->is_sharp;
        known->limit = l->limit;
        known->found = l->found;
    }
    else {
        cqi_recall_labels(l, p->note + p->num_notes, known->count_of[level]);
        l->alike = known->alike[level];
        l->is_sharp = known->is_sharp;
        l->limit = known->limit;
        l->found = known->found;
    }
    return known->count_of[level];
}

/* Undoes regular levels while that is worth it. idle: memory for the labels. */
static void cqi_take_regular(cqi_plan *p, cqi_known *known, const cq_input *in, const cqi_arena *idle)
{
    cq_index live = (cq_index)in->shape.num_vertices;
    const int channel = cqi_context_channel(&in->shape);
    cqi_arena scratch = *idle;
    p->num_regular = 0;
    if (channel >= 0)
        p->measured = cqi_gather_positions(
            p, in, channel, (cq_value *)cqi_take(&scratch, p->row_of_vertex ? 3 * (size_t)live : 0, sizeof(cq_value)));
    while (live && cqi_may_be_regular(p, in) && p->num_regular < p->most_regular) {
        cqi_labels l;
        cq_index n;
        if (!cqi_labels_carve(&l, &p->mesh, scratch.next, scratch.left)) return;
        l.positions = p->measured;
        l.input = p->face_state || in->shape.num_materials || cqi_all_components(&in->shape, CQI_OF_FACE) ? in : NULL;
        l.input_face = p->face_of_input;
        l.face_state = p->face_state;
        l.locked = p->locked;
        l.index = p->index;
        l.uses = p->uses;
        if (p->num_regular) {
            l.least = 340;
            l.strips = 300;
        }
        l.step = channel < 0
                     ? 0
                     : (int32_t)1 << (in->shape.channel[channel].bits > 12 ? in->shape.channel[channel].bits - 12 : 0);
        n = cqi_next_labels(p, known, &l);
        if (n < live / 12 + 1 || n < 24 || !cqi_is_worth_comparing(p, &l, live)) return;
        p->num_regular++;
        p->count_of[p->num_regular] = n;
        cqi_undo_level(&l, &p->mesh, p->note + p->num_notes, p->num_regular);
        p->num_notes = (cq_index)(p->num_notes + n);
        p->level = p->num_regular;
        if (p->measured) cqi_measure_regular(p, &in->shape);
        if (p->num_regular == 1) {
            p->is_near = cqi_is_near_before(p, &l, live);
            p->is_smooth = !l.is_sharp;
            p->surely_regular = p->is_near && l.found >= CQI_SURELY && !l.limit;
        }
        live = (cq_index)(live - n);
    }
}

static void cqi_simplify_all(cqi_encoder *e, const cq_input *in)
{
    cqi_plan *p = &e->plan;
    uint32_t most_quadric, k;
    cq_index live = (cq_index)in->shape.num_vertices;
    p->num_levels = p->num_regular;
    live = (cq_index)(live - p->num_notes);
    cqi_set_goal(p, in, (cq_value *)(void *)(p->follower + cqi_all_vertices(&in->shape))); /* the replay's memory */
    most_quadric = p->most_quadric;
    cqi_find_components(p, p->to_input);
    memset(p->mesh.mark, 0, p->mesh.num_vertices);
    cqi_take_virtual(&p->mesh);
    for (k = 0; k < p->num_seeds; k++) {
        const cq_index notes = p->num_notes;
        cqi_simplify_component(p, &p->seed[k], most_quadric);
        live = (cq_index)(live - (p->num_notes - notes - 1));
        cqi_progress(in, in->shape.num_vertices - live);
    }
    p->note[p->num_notes].level = 0;
    cqi_sort_components(p, (cqi_seed *)p->to_input);
    for (k = 1; k <= p->num_levels; k++)
        if (p->level_error[k] < p->level_error[k - 1]) p->level_error[k] = p->level_error[k - 1];
    memset(p->decoded, 0xff, cqi_all_vertices(&in->shape) * sizeof(cq_index));
}

/* Runs the decoder's steps, which write here. CQ_DONE, unless the plan is wrong or a level is rejected. */
static cq_result cqi_replay(cqi_encoder *e, const cq_input *in)
{
    cq_result result;
    uint32_t n = 0;
    memset(e->plan.before, 0, sizeof e->plan.before);
    e->replay.cost = 4 * 8 * 65536 - cqi_log2(0xffffffffu);
    cqi_start(&e->replay);
    while ((result = cqi_step(&e->replay)) == CQ_OK)
        if (++n % 4096 == 0) cqi_progress(in, in->shape.num_vertices + e->replay.mesh.num_vertices);
#ifdef CQ_TRAINING
    if (result == CQ_DONE) cqi_model_keep(&e->replay.model);
#endif
    CQ_ASSERT(result == CQ_DONE || e->plan.rejected > 1);
    return result;
}

/* -- Encoder: header -- */

static void cqi_write_uint(uint8_t **to, uint32_t value, int bytes)
{
    for (; bytes; bytes--, value >>= 8) *(*to)++ = (uint8_t)value;
}

static void cqi_write_varint(uint8_t **to, uint32_t value)
{
    for (; value >= 128; value >>= 7) *(*to)++ = (uint8_t)(value | 128);
    *(*to)++ = (uint8_t)value;
}

static int cqi_has_grid(const cq_channel *c)
{
    uint32_t all = c->step, k;
    for (k = 0; k < cqi_components(c); k++) all |= c->origin[k];
    return all != 0;
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
    cqi_write_uint(&to, s->num_channels | s->regular * CQI_REGULAR | (cqi_is_extended(s) ? CQI_EXTENDED : 0u), 1);
    for (k = 0; k < s->num_channels; k++) {
        const cq_channel *c = &s->channel[k];
        const int has_grid = cqi_has_grid(c);
        cqi_write_uint(&to, c->kind | (uint32_t)c->merge << 4 | (has_grid ? 0u : CQI_NO_GRID), 1);
        cqi_write_uint(&to, c->components | (uint32_t)c->bits << 8, 2);
        if (!has_grid) continue;
        cqi_write_uint(&to, c->step, 4);
        for (j = 0; j < cqi_components(c); j++) cqi_write_uint(&to, c->origin[j], 4);
    }
    if (cqi_is_extended(s)) {
        cqi_write_varint(&to, s->num_rows);
        cqi_write_varint(&to, s->num_aside_rows);
        cqi_write_varint(&to, s->num_aside_faces);
        cqi_write_varint(&to, s->metadata_bytes);
        cqi_write_varint(&to, s->num_materials);
    }
    cqi_write_varint(&to, (uint32_t)payload_size);
    cqi_write_uint(&to, payload_crc, 4);
    cqi_write_uint(&to, cqi_crc32(0, data, (size_t)(to - data)) & 0xffff, 2);
    return (size_t)(to - data);
}

/* Moves bytes up, the last chunk first, as source and target may overlap. */
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

/* Puts the header in front of the payload, which was written after a gap for the shortest header. */
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

/* The decoded face of an input face, by two of its decoded vertices: the one to the left of the edge from a to b. */
static cq_index cqi_match_face(const cq_mesh *decoded, cq_index a, cq_index b)
{
    const cq_index h = cqi_find_edge(decoded, a, b);
    return (cq_index)((decoded->origin[h] == a ? h : decoded->twin[h]) / 3);
}

#ifndef CQ_NO_WEDGES
/* The decoded vertex of a row of the input that is not aside, if there are seams. */
static cq_index cqi_vertex_of_row(const cqi_plan *p, const cq_decoder *d, cq_index row)
{
    return d->vertex[p->row_decoded[p->target[row]]];
}
#endif

/* Writes in->map and in->face_map of an input that was prepared; */
static void cqi_write_prepared_maps(const cq_input *in, const cqi_plan *p, const cq_shape *coded,
                                    const cq_decoder *d)
{
#ifndef CQ_NO_WEDGES
    const cq_index rows = (cq_index)(coded->num_rows ? coded->num_rows : coded->num_vertices);
    cq_index v, f, aside = (cq_index)coded->num_faces;
    for (v = 0; in->map && v < in->shape.num_vertices; v++) in->map[v] = cqi_plan_row(p, v, rows);
    for (f = 0; in->face_map && f < in->shape.num_faces; f++)
        if (p->face_state[f] & CQI_FACE_ASIDE) in->face_map[f] = aside++;
    for (f = 0; in->face_map && f < coded->num_faces; f++) {
        const cq_index face = p->face_of_input[f], *const row = in->indices + 3 * (size_t)face;
        const int turned = (p->face_state[face] & CQI_FACE_TURNED) != 0;
        const cq_index *const corner = p->corners ? p->corners + 3 * (size_t)f : NULL;
        in->face_map[face] = (cq_index)(p->face_decoded[f] / 3);
        if (p->num_regular && corner)
            in->face_map[face] = cqi_match_face(&d->mesh, p->decoded[corner[0]], p->decoded[corner[1]]);
        else if (p->num_regular)
            in->face_map[face] = cqi_match_face(&d->mesh, cqi_vertex_of_row(p, d, row[turned]),
                                                cqi_vertex_of_row(p, d, row[!turned]));
    }
#else
    (void)in, (void)p, (void)coded, (void)d;
#endif
}

/* and of one that was not. */
static void cqi_write_maps(const cq_input *in, const cqi_encoder *e)
{
    const cqi_plan *p = &e->plan;
    cq_index v, f;
    for (f = 0; p->num_regular && in->face_map && f < in->shape.num_faces; f++) {
        const cq_index *const corner = in->indices + 3 * (size_t)f;
        in->face_map[f] = cqi_match_face(&e->replay.mesh, p->decoded[corner[0]], p->decoded[corner[1]]);
    }
    for (v = 0; in->map && v < in->shape.num_vertices; v++) in->map[v] = p->decoded[v];
    for (f = 0; !p->num_regular && in->face_map && f < in->shape.num_faces; f++)
        in->face_map[f] = (cq_index)(p->face_decoded[f] / 3);
}

static void cqi_report_encoding(cq_report *r, const cq_shape *s, size_t bytes)
{
    r->shape = *s;
    r->bytes = bytes;
    r->header = (uint64_t)bytes * 8 * 65536 - r->base - r->flags - r->indices - r->positions - r->channels - r->aside;
}

static cq_result cqi_check_indices(const cq_input *in, cq_place *place)
{
    size_t h, n = 3 * (size_t)in->shape.num_faces;
    for (h = 0; h < n; h++)
        if (in->indices[h] >= in->shape.num_vertices)
            return cqi_error(place, CQ_ERROR_INDEX, (cq_index)(h / 3), in->indices[h], CQ_NONE);
    return CQ_OK;
}

#ifndef CQ_NO_WEDGES

/* Marks the faces with two corners in one place, which the preparation would put aside. Returns their number. */
static cq_index cqi_mark_degenerate(const cq_mesh *m, const cq_input *in, uint8_t *degenerate)
{
    cq_index h, f, n = 0;
    memset(degenerate, 0, m->num_faces);
    for (h = 0; h < 3 * m->num_faces; h++) {
        const cq_index t = m->twin[h];
        if (t < h || cqi_compare_rows(in, m->origin[h], m->origin[t], 0)) continue;
        degenerate[h / 3] = 1;
        if (cqi_is_real_face(m, t)) degenerate[t / 3] = 1;
    }
    for (f = 0; f < m->num_faces; f++) n = (cq_index)(n + degenerate[f]);
    return n;
}

/* Lists the halfedges that are open, or would be without these faces. Returns their number. */
static cq_index cqi_list_open(const cq_mesh *m, const uint8_t *degenerate, cq_index *open)
{
    cq_index h, n = 0;
    for (h = 0; h < 3 * m->num_faces; h++) {
        const cq_index t = m->twin[h];
        if (!degenerate[h / 3] && (!cqi_is_real_face(m, t) || degenerate[t / 3])) open[n++] = h;
    }
    return n;
}

/* The number of pairs of halfedges of the same place: no more can be glued. `open` is sorted by places. */
static cq_index cqi_count_pairs(const cq_mesh *m, const cq_input *in, const cq_index *open, cq_index n)
{
    cq_index k, single = 0, pairs = 0;
    for (k = 1; k < n; k++) {
        if (k == single || cqi_compare_edges(in, m, open[k - 1], open[k])) continue;
        pairs++;
        single = (cq_index)(k + 1);
    }
    return pairs;
}

/* Could more pairs of halfedges be glued than faces would go aside? Else borders do not become shorter. The memory
 * behind the mesh is free: even if it is just what cq_encoder_bytes asks for first, there is room for the plan and the
 * replay of a mesh without borders. That is more than what is needed here and what the borders add to the mesh, as at
 * most one of their edges begins at each vertex. */
static int cqi_borders_may_meet(const cqi_encoder *e, const cq_input *in, const cqi_arena *arena)
{
    const cq_mesh *const m = &e->plan.mesh;
    const size_t used = cq_mesh_bytes(&in->shape), flags = CQI_ROUND((size_t)m->num_faces);
    uint8_t *const degenerate = arena->next + used;
    cq_index *const open = (cq_index *)(void *)(degenerate + flags), aside, n;
    const size_t all = used + flags + 3 * (size_t)m->num_faces * sizeof(cq_index);
    if (arena->left < all) return 1; /* unreachable: there is room for the plan and the replay of the mesh when closed */
    aside = cqi_mark_degenerate(m, in, degenerate);
    n = cqi_list_open(m, degenerate, open);
    if (n / 2 <= aside) return 0;
    cqi_sort(in, m, open, n);
    return cqi_count_pairs(m, in, open, n) > aside;
}

/* Prepares the triangles, and builds their mesh if they are no manifold as they are, or one whose borders become
 * shorter by gluing more pairs of halfedges than faces go aside. Else CQ_DONE: they are fine as they are. */
static cq_result cqi_build_prepared(cqi_encoder *e, cq_input *in, cqi_arena *arena, int is_manifold, size_t memory_size,
                                    cq_preparation *counts)
{
    cqi_preparer p;
    cqi_arena scratch = *arena;
    cq_shape *s = &e->coded.shape;
    const cq_index *faces;
    cq_result result;
    memset(&p, 0, sizeof p);
    p.in = in;
    cqi_preparer_carve(&p, &scratch);
    cqi_prepare(&p);
    if (is_manifold && (p.num_open >= in->shape.num_boundary_edges || p.num_glued <= in->shape.num_faces - p.num_faces))
        return CQ_DONE;
    in->shape.num_rows = p.num_wedges ? p.num_wedges : 1;
    in->shape.num_aside_rows = p.num_aside;
    in->shape.num_aside_faces = (uint32_t)(in->shape.num_faces - p.num_faces);
    in->shape.num_boundary_loops = p.num_loops;
    in->shape.num_boundary_edges = p.num_open;
    *counts = p.counts;
    if (!cq_encoder_bytes(&in->shape)) return CQ_ERROR_TOO_LARGE;
    if (memory_size < cq_encoder_bytes(&in->shape)) return CQ_ERROR_MEMORY;
    faces = cqi_keep_prepared(&p, &e->plan, s, arena);
    result = cq_mesh_build(&e->plan.mesh, s, faces, arena->next, arena->left, NULL);
    arena->left += 3 * (size_t)p.num_faces * sizeof(cq_index); /* the faces are no longer needed */
    CQ_ASSERT(result == CQ_OK && s->num_boundary_loops == p.num_loops && s->num_boundary_edges == p.num_open);
    return result;
}

#endif

/* Builds the mesh that is coded, from the triangles as they are or prepared. */
static cq_result cqi_build(cqi_encoder *e, cq_input *in, cqi_arena *arena, size_t memory_size, cq_place *place,
                           cq_preparation *counts)
{
    cq_result result;
    int is_manifold;
    in->shape.num_rows = in->shape.num_aside_rows = in->shape.num_aside_faces = 0;
    result = cq_mesh_build(&e->plan.mesh, &in->shape, in->indices, arena->next, arena->left, place);
    is_manifold = result == CQ_OK;
    e->coded = *in;
#ifndef CQ_NO_WEDGES
    if (result <= CQ_ERROR_INDEX || (is_manifold && !e->known.levels && in->shape.num_boundary_loops &&
                                      cqi_has_places(&in->shape) && cqi_borders_may_meet(e, in, arena))) {
        result = cqi_build_prepared(e, in, arena, is_manifold, memory_size, counts);
        if (result == CQ_DONE)
            result = cq_mesh_build(&e->plan.mesh, &in->shape, in->indices, arena->next, arena->left, place);
        else if (place) place->face = place->vertex = place->other = CQ_NONE;
    }
#else
    (void)is_manifold;
    (void)counts;
    (void)memory_size;
#endif
    if (!e->plan.row_of_vertex) {
        e->plan.locked = in->locked;
        e->coded.shape = in->shape;
    }
    if (e->coded.shape.num_materials == 1) e->coded.shape.num_materials = 0;
    return result;
}

static void cqi_write_all_maps(cq_input *in, cqi_encoder *e)
{
    if (e->plan.row_of_vertex) cqi_write_prepared_maps(in, &e->plan, &e->coded.shape, &e->replay);
    else cqi_write_maps(in, e);
}

/* Encodes with at most `most_regular` regular levels. */
static cq_result cqi_encode_pass(cq_input *in, void *memory, size_t memory_size, uint32_t most_regular, uint8_t *out,
                                 size_t out_size, size_t *stream_size, cq_place *place, cq_report *report)
{
    cqi_encoder *e = (cqi_encoder *)memory;
    cq_preparation counts;
    cqi_arena arena;
    cq_result result;
    size_t gap;
    uint8_t header[CQ_MAX_HEADER_BYTES];
    const cq_input *coded;
    memset(e, 0, offsetof(cqi_encoder, report));
    memset(&counts, 0, sizeof counts);
    coded = &e->coded;
    arena.next = (uint8_t *)memory + CQI_ENCODER_BYTES;
    arena.left = memory_size - CQI_ENCODER_BYTES;
    result = cqi_build(e, in, &arena, memory_size, place, &counts);
    if (result != CQ_OK) return result;
    if (memory_size < cq_encoder_bytes(&in->shape)) return CQ_ERROR_MEMORY;
    arena.next += cq_mesh_bytes(&coded->shape);
    arena.left -= cq_mesh_bytes(&coded->shape);
    cqi_encoder_carve(e, coded, &arena);
    gap = cqi_write_header(header, &coded->shape, 0, 0);
    cq_range_encoder_init(&e->plan.range, out_size > gap ? out + gap : out, out_size > gap ? out_size - gap : 0);
    if (report) memset(report, 0, sizeof *report);
    if (report) report->prepared = counts;
    e->replay.report = report;
    e->plan.most_regular = most_regular;
    e->plan.rejected = 1;
    cqi_take_regular(&e->plan, &e->known, coded, &arena);
    e->known.levels = e->plan.row_of_vertex ? 0 : e->plan.num_regular;
    e->coded.shape.regular = e->replay.shape.regular = e->plan.num_regular > 0;
    cqi_simplify_all(e, coded);
    if (cqi_replay(e, coded) != CQ_DONE) return CQ_ERROR_CORRUPT;
    result = cqi_wrap(&coded->shape, out, out_size, gap, cq_range_encoder_finish(&e->plan.range), stream_size);
    if (report) cqi_report_encoding(report, &coded->shape, *stream_size);
    return result;
}

/* Bits that a vertex of regular level k may take, in 1/16: the mean without regular levels, and 3/2 bits more for each
 * time that the number of vertices has been halved by finer levels, as coarser meshes always take more bits per
 * vertex. */
static uint32_t cqi_most_of_level(const cqi_plan *p, uint32_t k, size_t without, uint32_t num_vertices)
{
    uint32_t live = num_vertices, j;
    for (j = 1; j < k; j++) live -= p->count_of[j];
    return (uint32_t)((uint64_t)without * 128 / num_vertices) +
           3 * (uint32_t)(cqi_logarithm(num_vertices) - cqi_logarithm(live));
}

/* Is the mesh before regular level k about as near to the exact one as the mesh that a plan without regular levels has
 * after as many bytes? Errors are maxima, and most vertices are much nearer. So the error may be larger by a step, and
 * by a factor: 1, plus 1 for each 24th of `bytes` that is saved, but at most 4 * without / bytes. */
static int cqi_is_near(const cqi_plan *p, uint32_t k, const cqi_plan *other, size_t bytes, size_t without)
{
    const uint64_t gain = 24 * (uint64_t)(without - bytes) + bytes, most = 4 * (uint64_t)without;
    uint32_t level = other->num_levels, error;
    while (level > 1 && other->bytes_at[level - 1] <= p->bytes_at[k]) level--;
    error = cqi_error_of_code(other->level_error[level]);
    return bytes * (uint64_t)cqi_error_of_code(p->level_error[k]) <=
           (gain < most ? gain : most) * error + 16 * (uint64_t)bytes;
}

/* How many regular levels there should be, given the bytes of a plan with them and of one without: none if they make
 * the stream longer; else the finest ones, as long as their vertices do not take too much. With CQ_BALANCED, they must
 * also save a 50th, and the meshes before them must be near enough: by cqi_is_near, or for the finest one by
 * cqi_is_near_before instead. */
static uint32_t cqi_choose_regular(const cqi_plan *p, const cqi_plan *other, size_t bytes, size_t without,
                                   const cq_input *in)
{
    const uint32_t num_vertices = in->shape.num_vertices;
    uint32_t k = 1;
    if (without < bytes + (in->goal == CQ_BALANCED && p->measured ? bytes / 50 : 0)) return 0;
    while (k <= p->num_regular &&
           p->bytes_of[k] * (uint64_t)128 <=
               (uint64_t)p->count_of[k] * cqi_most_of_level(p, k, without, num_vertices) &&
           (in->goal != CQ_BALANCED || !p->measured || (k == 1 && p->is_near) ||
            cqi_is_near(p, k, other, bytes, without)))
        k++;
    return k - 1;
}

/* How many regular levels there should be, without another plan to compare with: one, and more as long as they pay. 0:
 * that is in question, as the stream is probably not much smaller than one without any, or the mesh before the finest
 * level is far from the exact one. The guess is better for smooth meshes. */
static uint32_t cqi_guess_regular(const cqi_plan *p, size_t bytes, uint32_t num_vertices, int located)
{
    const int64_t size = (int64_t)((uint64_t)bytes * 128), all = cqi_guess_after(p, bytes, num_vertices, 1, located);
    uint32_t k = 1;
    if (!p->surely_regular && (!p->is_near || 32 * size > (p->is_smooth ? 31 : 29) * all)) return 0;
    while (k < p->num_regular && cqi_pays(p, k + 1, bytes, num_vertices, located)) k++;
    return k;
}

/* Encodes with all regular levels that there are; if one of these turns out not to pay, again with only those finer
 * than it. Then, if it is in question whether they pay, without any, to compare: that stream goes into what is left of
 * the output, and is only moved if it is chosen. If some of the levels are best, or if there was no room for the stream
 * that is chosen, the mesh is encoded once more. Should a plan with regular levels be wrong, it is encoded without
 * any. */
static cq_result cqi_encode_best(cq_input *in, void *memory, size_t memory_size, uint8_t *out, size_t out_size,
                                 size_t *stream_size, cq_place *place, cq_report *report)
{
    cqi_encoder *const e = (cqi_encoder *)memory;
    cqi_plan plan;
    cq_input plain;
    size_t without = 0, room, k;
    uint32_t best;
    cq_result result;
    e->known.levels = 0;
    result = cqi_encode_pass(in, memory, memory_size, CQI_MAX_REGULAR, out, out_size, stream_size, place, report);
    plain = *in;
    plain.progress = NULL;
    if (result == CQ_ERROR_CORRUPT)
        result = cqi_encode_pass(&plain, memory, memory_size, e->plan.rejected - 1, out, out_size, stream_size, place,
                                 report);
    if (result < CQ_OK && result != CQ_ERROR_OUTPUT) return result;
    cqi_write_all_maps(in, e);
#ifdef CQ_TRAINING
    return result;
#endif
    plan = e->plan;
    if (!plan.num_regular) return result;
    room = result == CQ_OK ? out_size - *stream_size : 0;
    best = cqi_guess_regular(&plan, *stream_size, in->shape.num_vertices, in->shape.num_channels > 0);
    if (!best) {
        cqi_encode_pass(&plain, memory, memory_size, 0, room ? out + *stream_size : NULL, room, &without, NULL,
                        report ? &e->report : NULL);
        best = cqi_choose_regular(&plan, &e->plan, *stream_size, without, in);
    }
    if (best == plan.num_regular) return result;
    if (best || without > room) {
        result = cqi_encode_pass(&plain, memory, memory_size, best, out, out_size, stream_size, place, report);
    } else {
        for (k = 0; k < without; k++) out[k] = out[*stream_size + k];
        *stream_size = without;
        if (report) *report = e->report;
    }
    cqi_write_all_maps(in, e);
    return result;
}

cq_result cq_encode(cq_input *in, void *memory, size_t memory_size, uint8_t *out, size_t out_size,
                    size_t *stream_size, cq_place *place, cq_report *report)
{
    cq_result result;
    if (!in || !stream_size || (out_size && !out) || in->shape.num_channels > CQ_MAX_CHANNELS ||
        (in->shape.num_faces && !in->indices))
        return CQ_ERROR_ARGUMENT;
#ifdef CQ_NO_WEDGES
    if (in->shape.metadata_bytes || in->shape.num_materials > 1) return CQ_ERROR_UNSUPPORTED;
#endif
    if (in->shape.num_materials > CQ_MAX_MATERIALS ||
        (in->shape.num_materials > 1 && in->shape.num_faces && !in->materials))
        return CQ_ERROR_ARGUMENT;
    if (in->shape.metadata_bytes > CQ_MAX_METADATA || (in->shape.metadata_bytes && !in->metadata))
        return CQ_ERROR_ARGUMENT;
    if (place) place->face = place->vertex = place->other = CQ_NONE;
    result = cqi_check_values(in, place);
    if (result != CQ_OK) return result;
    if (!cq_encoder_bytes(&in->shape)) return CQ_ERROR_TOO_LARGE;
    if (!memory || (uintptr_t)memory % 8 || memory_size < cq_encoder_bytes(&in->shape)) return CQ_ERROR_MEMORY;
    result = cqi_check_indices(in, place);
    if (result != CQ_OK) return result;
    return cqi_encode_best(in, memory, memory_size, out, out_size, stream_size, place, report);
}

#endif /* CQ_NO_ENCODER */

/* -- Quantiser ----------------------------------------------------------------------------------------------------- */

#ifndef CQ_NO_QUANTISER

#define CQI_LARGEST_FLOAT 0x7f7fffffu /* its bits */

static float cqi_float_of(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static double cqi_float(uint32_t bits) { return (double)cqi_float_of(bits); }

float cq_channel_step(const cq_channel *channel)
{
    CQ_ASSERT(channel);
    return cqi_float_of(channel->step);
}

float cq_channel_origin(const cq_channel *channel, int component)
{
    CQ_ASSERT(channel && component >= 0 && component < CQ_MAX_COMPONENTS);
    return cqi_float_of(channel->origin[component]);
}

/* The float nearest to x; never infinite, and 0 for a NaN. */
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

/* The largest integer that is not above x, for |x| < 2^31. */
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

/* The step, so that the points of the grid reach over the box; `last` is the number of the last point. It is longer
 * than the distance of neighbouring floats at the end of the box: rounding a point to a float then moves it by less
 * than half a step, too little for another point to be nearer. With more than 22 bits, a step that was rounded down to
 * a float may leave the end of the box half a step or more beyond the last point; the next float is used then. */
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

/* The largest multiple of step, a power of two, that is not above x. A float of 2^24 steps or more is a multiple. */
static double cqi_align(double x, double step)
{
    return cqi_magnitude(x) < step * 0x1000000 ? cqi_floor(x / step) * step : x;
}

/* Why there are no cracks: quantising finds the multiple n of step that is nearest to x, and reconstructing rounds
 * n * step; neither depends on the origin. For (x - origin) / step + 1/2 has a rounding error below 2^-28, which would
 * only matter if x were that near to the middle of two multiples, but not equal to it. It is not: either the middle is
 * a float, at least half a step from 0, and the next float is 2^-25 of that away; or no float lies between the
 * multiples. */
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

/* Floats as exact values, and back. Each goes through a local variable: memory from malloc takes the type of what
 * memcpy puts there (C99 6.5, paragraph 6), so that an array of floats copied as a whole would still be one of floats.
 * Only bytes are copied, as a signalling NaN would not survive the registers of an x87. */
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

/* The product is exact, so it makes no difference whether a compiler contracts it with the sum. */
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
 * A direction, scaled to |x| + |y| + |z| = 1, is a point of an octahedron, whose lower half (z < 0) is folded outwards
 * around the upper one, into a square: the pair is (x, y) in -1 .. 1, in units of 1 / half. On an edge of the square,
 * two points at the same distance from its middle stand for the same direction; the one to the right or above is used.
 *
 * The bound: each number is off by at most half a unit, and a point of the octahedron therefore by sqrt(6) times that.
 * Seen from the centre, which is at least 1 / sqrt(3) away, that is an angle of sqrt(18) / 2 = 2.1213 units. */

static void cqi_fold(double *x, double *y)
{
    double a = 1 - cqi_magnitude(*y), b = 1 - cqi_magnitude(*x);
    *x = *x < 0 ? -a : a;
    *y = *y < 0 ? -b : b;
}

/* 1 / sqrt(x) for 1/3 <= x <= 1: five steps of Newton's method from a guess that is within 9 %. */
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

/* A number of a pair as -1 .. 1; values that are out of range are clamped. */
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

/* -- License -------------------------------------------------------------------------------------------------------
 *
 * MIT License
 *
 * Copyright (c) 2026 The conquest developers
 *
 * Permission is hereby granted, free of charge, to any person obtaining a copy
 * of this software and associated documentation files (the "Software"), to deal
 * in the Software without restriction, including without limitation the rights
 * to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
 * copies of the Software, and to permit persons to whom the Software is
 * furnished to do so, subject to the following conditions:
 *
 * The above copyright notice and this permission notice shall be included in all
 * copies or substantial portions of the Software.
 *
 * THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
 * IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
 * FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
 * AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
 * LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
 * OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
 * SOFTWARE. */
