/* Headers of streams, written by hand after SPEC.md. */
#ifndef CQ_TESTS_HEADER_H
#define CQ_TESTS_HEADER_H

#include "conquest.h"

typedef struct header {
    uint8_t bytes[CQ_MAX_HEADER_BYTES + 64];
    size_t size;
} header;

static inline void put(header *h, uint32_t value, int bytes)
{
    for (; bytes > 0; --bytes, value >>= 8) h->bytes[h->size++] = (uint8_t)value;
}

static inline void put_varint(header *h, uint32_t value)
{
    for (; value >= 128; value >>= 7) h->bytes[h->size++] = (uint8_t)(value | 128);
    h->bytes[h->size++] = (uint8_t)value;
}

/* CRC-32 of IEEE 802.3, bit by bit; a header ends in its low 16 bits. */
static inline uint32_t crc32(const uint8_t *data, size_t size)
{
    uint32_t crc = 0xffffffffu;
    size_t k;
    int bit;
    for (k = 0; k < size; ++k) {
        crc ^= data[k];
        for (bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static inline void put_start(header *h, uint32_t vertices, uint32_t loops, uint32_t edges, int32_t euler)
{
    h->size = 0;
    put(h, 'C', 1);
    put(h, 'Q', 1);
    put(h, CQ_STREAM_VERSION, 1);
    put_varint(h, vertices);
    put_varint(h, loops);
    if (loops > 0) put_varint(h, edges);
    put_varint(h, euler < 0 ? ~((uint32_t)euler << 1) : (uint32_t)euler << 1);
}

enum { NO_GRID = 64 };                 /* bit of the form: step and origin are not there */
enum { REGULAR = 64, EXTENDED = 128 }; /* bits of the number of channels */

static inline void put_channel(header *h, uint32_t form, uint32_t components, uint32_t bits)
{
    uint32_t k;
    put(h, form, 1);
    put(h, components, 1);
    put(h, bits, 1);
    if (form & NO_GRID) return;
    put(h, 0x3f800000u, 4);
    for (k = 0; k < components; ++k) put(h, k, 4);
}

static inline void put_end(header *h, uint32_t payload)
{
    put_varint(h, payload);
    put(h, 0x12345678u, 4);
    put(h, crc32(h->bytes, h->size), 2);
}

#endif
