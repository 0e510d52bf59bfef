/* Proofs about what is read from the start of a stream: any bytes, in a block of exactly their number, so that no read
 * goes past them. */
#include "proof.h"

void claim_crc(void)
{
    size_t size = nondet_size();
    ASSUME(size <= MAX_SIZE);
    cqi_crc32(nondet_u32(), any_bytes(size), size);
    REACHED();
}

/* A reader somewhere in its bytes, with any result so far. */
static cqi_reader any_reader(size_t max_size)
{
    cqi_reader r;
    r.size = nondet_size();
    ASSUME(r.size <= max_size);
    r.data = any_bytes(r.size);
    r.at = nondet_size();
    r.result = (cq_result)any_between(CQ_ERROR_CHECKSUM, CQ_MORE);
    ASSUME(r.at <= r.size);
    return r;
}

/* One number of 1 to 4 bytes: what the stub below does, and nothing else. */
void claim_read_uint(void)
{
    cqi_reader r = any_reader(8), before = r;
    int bytes = any_between(1, 4);
    uint32_t value = cqi_read_uint(&r, bytes);
    PROVE(r.size == before.size && r.data == before.data && r.at <= r.size);
    if (before.size - before.at < (size_t)bytes) {
        PROVE(r.at == r.size && value == 0);
        PROVE(r.result == (before.result == CQ_OK ? CQ_NEED_INPUT : before.result));
    } else {
        PROVE(r.at == before.at + (size_t)bytes && r.result == before.result);
        PROVE(bytes == 4 || value >> 8 * bytes == 0);
        REACHED();
    }
}

/* At most five bytes; a number that is not in its shortest form, or needs more than 32 bits, is corrupt. */
void claim_varint(void)
{
    cqi_reader r = any_reader(8);
    size_t at = r.at;
    uint32_t value;
    ASSUME(r.result == CQ_OK);
    value = cqi_read_varint(&r);
    PROVE(r.at <= r.size && r.at - at <= 5);
    PROVE(r.result != CQ_NEED_INPUT || r.size - at < 5);
    PROVE(r.result == CQ_OK || r.result == CQ_NEED_INPUT || r.result == CQ_ERROR_CORRUPT);
    if (r.result == CQ_OK) {
        uint8_t again[5], *to = again;
        size_t k;
        cqi_write_varint(&to, value);
        PROVE((size_t)(to - again) == r.at - at);
        for (k = 0; k < r.at - at; k++) PROVE(r.data[at + k] == again[k]);
        REACHED();
    }
}

/* A number as claim_varint says; those that were read are kept. */
static int64_t number[16];
static int num_read;

uint32_t stub_read_varint(cqi_reader *r)
{
    size_t bytes = nondet_size();
    ASSUME(bytes <= 5 && bytes <= r->size - r->at);
    if (r->result != CQ_OK) return 0;
    r->result = (cq_result)nondet_int();
    ASSUME(r->result == CQ_OK || r->result == CQ_ERROR_CORRUPT || (r->result == CQ_NEED_INPUT && r->size - r->at < 5));
    r->at += bytes;
    return r->result == CQ_OK ? (uint32_t)(number[num_read++] = nondet_u32()) : 0;
}

/* Counts of any 24 bytes: the number of faces that they imply is in range, and is that of the Euler formula. */
void claim_counts(void)
{
    cqi_reader r = any_reader(24);
    size_t at = r.at;
    cq_shape s;
    cq_result result;
    memset(&s, 0, sizeof s);
    ASSUME(r.result == CQ_OK);
    result = cqi_read_counts(&r, &s);
    PROVE(r.at <= r.size && r.at - at <= 20 && (result != CQ_OK || r.result == CQ_OK));
    PROVE(r.result != CQ_NEED_INPUT || r.size - at < 20);
    PROVE(result == CQ_OK || result == CQ_NEED_INPUT || result == CQ_ERROR_CORRUPT);
    if (result == CQ_OK) {
        int64_t loops = number[1], edges = loops ? number[2] : 0, zigzag = number[num_read - 1];
        int64_t euler = zigzag & 1 ? -(zigzag + 1) / 2 : zigzag / 2;
        PROVE(num_read == (loops ? 4 : 3));
        PROVE(s.num_vertices == number[0] && s.num_boundary_loops == loops && s.num_boundary_edges == edges);
        PROVE(s.num_faces == 2 * (number[0] + loops) - 4 * euler - edges);
        PROVE(s.num_boundary_edges / 3 >= s.num_boundary_loops);
        REACHED();
    }
}

/* A channel of any 32 bytes: at most 23 are read, whatever number of components the stream names. */
void claim_channel(void)
{
    cqi_reader r = any_reader(32);
    size_t at = r.at;
    cq_result before = r.result;
    cq_channel c;
    memset(&c, 0, sizeof c);
    cqi_read_channel(&r, &c);
    PROVE(r.at <= r.size && r.at - at <= 23);
    PROVE(before != CQ_OK || r.result == CQ_OK || (r.result == CQ_NEED_INPUT && r.size - at < 23));
    if (r.result == CQ_OK && cqi_channel_is_valid(&c)) REACHED();
}

/* -- The whole header: its parts are stubs that do what the claims above promise -- */

/* Moves a reader on by at most so many bytes; more input is only wanted where fewer are left. */
static void move_on(cqi_reader *r, size_t most)
{
    const size_t bytes = nondet_size();
    ASSUME(bytes <= most && bytes <= r->size - r->at);
    if (r->result != CQ_OK) return;
    if (nondet_int() && r->size - r->at < most) r->result = CQ_NEED_INPUT;
    r->at += bytes;
}

cq_result stub_read_counts(cqi_reader *r, cq_shape *s)
{
    move_on(r, 20);
    if (r->result != CQ_OK) return r->result;
    s->num_vertices = nondet_u32();
    s->num_faces = nondet_u32();
    s->num_boundary_loops = nondet_u32();
    s->num_boundary_edges = nondet_u32();
    ASSUME(s->num_boundary_edges / 3 >= s->num_boundary_loops);
    return nondet_int() ? CQ_OK : CQ_ERROR_CORRUPT;
}

void stub_read_channel(cqi_reader *r, cq_channel *c)
{
    move_on(r, 23);
    c->kind = nondet_u8();
    c->components = nondet_u8();
    c->bits = nondet_u8();
    c->merge = nondet_u8();
}

uint32_t stub_crc32(uint32_t crc, const uint8_t *data, size_t size)
{
    (void)crc;
    PROVE(size == 0 || __CPROVER_r_ok(data, size));
    return nondet_u32();
}

static int is_header_result(cq_result r)
{
    return r == CQ_OK || r == CQ_NEED_INPUT || r == CQ_ERROR_FORMAT || r == CQ_ERROR_VERSION || r == CQ_ERROR_CORRUPT ||
           r == CQ_ERROR_UNSUPPORTED || r == CQ_ERROR_CHECKSUM || r == CQ_ERROR_TOO_LARGE;
}

/* What it accepts can be decoded: channels that are known, and sizes that do not wrap around. */
void claim_peek(void)
{
    const size_t size = nondet_size();
    const uint8_t *data;
    cq_shape shape;
    size_t header_bytes, stream_bytes;
    cq_result result;
    ASSUME(size <= MAX_SIZE);
    data = any_bytes(size);
    result = cq_peek(data, size, &shape, &header_bytes, &stream_bytes);
    PROVE(is_header_result(result) && header_bytes <= size && header_bytes <= stream_bytes);
    PROVE(result != CQ_NEED_INPUT || size < CQ_MAX_HEADER_BYTES);
    if (result == CQ_OK) {
        uint32_t k = nondet_u32();
        PROVE(header_bytes >= 3 + 1 + 4 + 2 && header_bytes <= CQ_MAX_HEADER_BYTES);
        PROVE(shape.num_channels <= CQ_MAX_CHANNELS);
        PROVE(k >= shape.num_channels || cqi_channel_is_valid(&shape.channel[k]));
        PROVE(shape.num_boundary_edges / 3 >= shape.num_boundary_loops);
        REACHED();
    }
}
