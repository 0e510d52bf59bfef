/* Encoding and decoding in memory of exactly the documented sizes. C99 and C++; include conquest.h first. */
#ifndef CQ_TESTS_CODEC_H
#define CQ_TESTS_CODEC_H

#include "exact.h"

/* -- Encoding ------------------------------------------------------------------------------------------------------ */

typedef struct coded {
    cq_result result;
    uint8_t *bytes;        /* uint8_t[size], exactly; NULL unless result is CQ_OK */
    size_t size;
    cq_index *map;         /* cq_index[num_vertices], exactly */
    cq_index *face_map;    /* cq_index[num_faces], exactly */
    uint32_t num_vertices;
    cq_shape shape;        /* as found */
    cq_place place;
    cq_report *report;
} coded;

/* Encodes as the manual says: encoder memory on a second try if there are boundaries; the output is measured with an
 * empty buffer and then written into one of exactly that size. */
static inline void code(coded *c, const cq_input *input)
{
    cq_input in = *input;
    void *memory = NULL;
    size_t memory_size = 0, size = 0;
    int tries = 0;
    memset(c, 0, sizeof *c);
    c->num_vertices = in.shape.num_vertices;
    c->map = (cq_index *)exact_alloc((size_t)in.shape.num_vertices * sizeof(cq_index));
    c->report = (cq_report *)exact_alloc(sizeof(cq_report));
    c->face_map = (cq_index *)exact_alloc((size_t)in.shape.num_faces * sizeof(cq_index));
    in.map = c->map;
    in.face_map = c->face_map;
    do {
        exact_free(memory);
        memory_size = cq_encoder_bytes(&in.shape);
        memory = exact_alloc(memory_size);
        c->result = cq_encode(&in, memory, memory_size, NULL, 0, &size, &c->place, c->report);
    } while (c->result == CQ_ERROR_MEMORY && ++tries < 2);
    if (c->result == CQ_ERROR_OUTPUT) {
        c->bytes = (uint8_t *)exact_alloc(size);
        c->result = cq_encode(&in, memory, memory_size, c->bytes, size, &c->size, &c->place, c->report);
        if (c->result == CQ_OK && c->size != size) c->result = CQ_ERROR_OUTPUT;  /* two sizes for one mesh */
    }
    if (cq_encoder_bytes(&in.shape) > cq_encoder_bytes_at_most(&input->shape)) c->result = CQ_ERROR_MEMORY;
    c->shape = in.shape;
    exact_free(memory);
}

static inline void uncode(coded *c)
{
    exact_free(c->bytes);
    exact_free(c->map);
    exact_free(c->face_map);
    exact_free(c->report);
    memset(c, 0, sizeof *c);
}

/* -- Channels ------------------------------------------------------------------------------------------------------ */

static inline int is_per_face(const cq_channel *channel) { return channel->merge == CQ_PER_FACE; }

/* Vertices or faces of a mesh: what the channel has values for. */
static inline uint32_t num_owners(const cq_channel *channel, uint32_t num_vertices, uint32_t num_faces)
{
    return is_per_face(channel) ? num_faces : num_vertices;
}

static inline int value_is_in_range(const cq_channel *channel, cq_value value)
{
    return channel->bits == CQ_EXACT_BITS || (value >= 0 && (int32_t)value >> channel->bits == 0);
}

/* Numbers of channel k that a decoder shows. */
static inline uint32_t num_shown(const cq_decoder *d, uint32_t k)
{
    const cq_channel *channel = &d->shape.channel[k];
    return num_owners(channel, d->mesh.num_vertices, d->mesh.num_faces) * channel->components;
}

/* -- Decoding ------------------------------------------------------------------------------------------------------ */

typedef struct decoding {
    cq_decoder *decoder;
    void *memory;
    size_t memory_size;
    cq_report *report;
    cq_result result;      /* of the last call */
    size_t used;           /* bytes consumed */
} decoding;

static inline void decoding_begin_with(decoding *d, size_t memory_size)
{
    memset(d, 0, sizeof *d);
    d->decoder = (cq_decoder *)exact_alloc(sizeof(cq_decoder));
    d->memory = exact_alloc(memory_size);
    d->memory_size = memory_size;
    d->result = cq_decoder_init(d->decoder, d->memory, memory_size);
}

/* A decoder with exactly the memory that the header of the stream asks for; none if the header is not one. */
static inline void decoding_begin(decoding *d, const uint8_t *bytes, size_t size)
{
    cq_shape shape;
    size_t memory_size = 0;
    if (cq_peek(bytes, size, &shape, NULL, NULL) == CQ_OK) memory_size = cq_decoder_bytes(&shape);
    decoding_begin_with(d, memory_size);
}

static inline void decoding_report(decoding *d)
{
    d->report = (cq_report *)exact_alloc(sizeof(cq_report));
    d->decoder->report = d->report;
}

/* Feeds a piece, which lies in a block of its own, in steps of `budget` until it is used up or the decoder is done. */
static inline cq_result decoding_feed(decoding *d, const uint8_t *bytes, size_t size, uint32_t budget)
{
    uint8_t *piece = (uint8_t *)exact_copy(bytes, size);
    cq_bytes in;
    in.data = piece;
    in.size = size;
    do {
        d->result = cq_decode(d->decoder, &in, budget);
    } while (d->result == CQ_MORE);
    d->used += size - in.size;
    exact_free(piece);
    return d->result;
}

/* No more input will come. */
static inline cq_result decoding_end(decoding *d, uint32_t budget)
{
    do {
        d->result = cq_decode(d->decoder, NULL, budget);
    } while (d->result == CQ_MORE);
    return d->result;
}

/* The whole stream in pieces of `chunk` bytes, then the end of input if it is still wanted. */
static inline cq_result decoding_run(decoding *d, const uint8_t *bytes, size_t size, size_t chunk, uint32_t budget)
{
    size_t at = 0;
    d->result = CQ_NEED_INPUT;
    while (at < size && d->result == CQ_NEED_INPUT) {
        size_t n = size - at < chunk ? size - at : chunk;
        decoding_feed(d, bytes + at, n, budget);
        at += n;
    }
    return d->result == CQ_NEED_INPUT ? decoding_end(d, budget) : d->result;
}

static inline void decoding_free(decoding *d)
{
    exact_free(d->decoder);
    exact_free(d->memory);
    exact_free(d->report);
    memset(d, 0, sizeof *d);
}

#endif
