/* Proofs about what is read from the start of a stream: any bytes, in a block of exactly their number, so that no read
 * goes past them. A header that is accepted is one that the rest of the decoder can rely on. */
#include "proof.h"

static int shape_holds(const cq_shape *s)
{
    uint32_t k;
    if (s->num_channels > CQ_MAX_CHANNELS) return 0;
    for (k = 0; k < s->num_channels; k++)
        if (!cqi_channel_is_valid(&s->channel[k])) return 0;
    return s->num_boundary_edges / 3 >= s->num_boundary_loops;
}

/* Stands for the check value, which claim_crc is about: any number, of bytes that may be read. */
uint32_t stub_crc32(uint32_t crc, const uint8_t *data, size_t size)
{
    (void)crc;
    PROVE(__CPROVER_r_ok(data, size));
    return nondet_u32();
}

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
    r.result = (cq_result)any_between(CQ_ERROR_CHECKSUM, CQ_TRUNCATED);
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

/* Stands for it: any value of so many bytes. */
uint32_t stub_read_uint(cqi_reader *r, int bytes)
{
    uint32_t value = nondet_u32();
    PROVE(bytes >= 1 && bytes <= 4 && r->at <= r->size);
    if (r->size - r->at < (size_t)bytes) {
        if (r->result == CQ_OK) r->result = CQ_NEED_INPUT;
        r->at = r->size;
        return 0;
    }
    r->at += (size_t)bytes;
    ASSUME(bytes == 4 || value >> 8 * bytes == 0);
    return value;
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

/* Counts of any 24 bytes: the number of faces that they imply is in range, and comes from the Euler formula. */
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
        PROVE(s.num_boundary_edges / 3 >= s.num_boundary_loops);
        PROVE((2 * (uint64_t)s.num_vertices + 2 * (uint64_t)s.num_boundary_loops - s.num_faces - s.num_boundary_edges) %
              4 == 0);
        REACHED();
    }
}

/* Stands for the counts: claim_counts says that their fields are at most 20 bytes and what they are like if accepted. */
cq_result stub_read_counts(cqi_reader *r, cq_shape *s)
{
    size_t bytes = nondet_size(), left = r->size - r->at;
    cq_result result = nondet_u8() ? CQ_OK : CQ_ERROR_CORRUPT;
    PROVE(r->at <= r->size && r->result == CQ_OK);
    ASSUME(bytes <= 20 && bytes <= left);
    r->at += bytes;
    s->num_vertices = nondet_u32();
    s->num_faces = nondet_u32();
    s->num_boundary_loops = nondet_u32();
    s->num_boundary_edges = nondet_u32();
    ASSUME(s->num_boundary_edges / 3 >= s->num_boundary_loops);
    if (nondet_u8()) r->result = result = nondet_u8() ? CQ_NEED_INPUT : CQ_ERROR_CORRUPT;
    ASSUME(r->result != CQ_NEED_INPUT || left < 20);
    return result;
}

/* Stands for a number of 1 to 5 bytes: claim_varint. */
uint32_t stub_read_varint(cqi_reader *r)
{
    size_t bytes = nondet_size(), left = r->size - r->at;
    PROVE(r->at <= r->size);
    if (r->result != CQ_OK) return 0;
    ASSUME(bytes <= 5 && bytes <= left);
    r->at += bytes;
    if (nondet_u8()) r->result = nondet_u8() ? CQ_NEED_INPUT : CQ_ERROR_CORRUPT;
    ASSUME(r->result != CQ_NEED_INPUT || left < 5);
    return nondet_u32();
}

void claim_header(void)
{
    size_t size = nondet_size(), header_bytes, stream_bytes;
    const uint8_t *data;
    cq_shape shape;
    cq_result result;
    ASSUME(size <= MAX_SIZE);
    data = any_bytes(size);
    result = cq_peek(data, size, &shape, &header_bytes, &stream_bytes);
    PROVE(result == CQ_OK || result == CQ_NEED_INPUT || result == CQ_ERROR_FORMAT || result == CQ_ERROR_VERSION ||
          result == CQ_ERROR_UNSUPPORTED || result == CQ_ERROR_CORRUPT || result == CQ_ERROR_CHECKSUM ||
          result == CQ_ERROR_TOO_LARGE);
    PROVE(result != CQ_NEED_INPUT || size < CQ_MAX_HEADER_BYTES);
    if (result == CQ_OK) {
        PROVE(header_bytes <= size && header_bytes < CQ_MAX_HEADER_BYTES);
        PROVE(stream_bytes >= header_bytes);
        PROVE(shape_holds(&shape));
        REACHED();
    }
}

/* What the encoder writes for a shape is what a decoder reads, in every field, and not longer than promised. */
void claim_header_round_trip(void)
{
    uint8_t data[CQ_MAX_HEADER_BYTES];
    cq_shape shape;
    cqi_header h;
    size_t size, payload = nondet_u32();
    uint32_t crc = nondet_u32(), k, j;
    int64_t twice_euler;
    memset(&shape, 0, sizeof shape);
    shape.num_vertices = nondet_u32();
    shape.num_boundary_loops = nondet_u32();
    shape.num_boundary_edges = nondet_u32();
    shape.num_faces = nondet_u32();
    shape.num_channels = NUM_CHANNELS;
    for (k = 0; k < shape.num_channels; k++) {
        cq_channel *c = &shape.channel[k];
        c->kind = nondet_u8();
        c->components = nondet_u8();
        c->bits = nondet_u8();
        c->step = nondet_u32();
        ASSUME(cqi_channel_is_valid(c));
        for (j = 0; j < c->components; j++) c->origin[j] = nondet_u32();
    }
    ASSUME(cqi_countable(&shape));
    ASSUME(shape.num_boundary_edges / 3 >= shape.num_boundary_loops);
    ASSUME(shape.num_boundary_loops || !shape.num_boundary_edges);
    twice_euler = 2 * (int64_t)cqi_all_vertices(&shape) - cqi_all_faces(&shape);
    ASSUME(twice_euler % 4 == 0);
    ASSUME(shape.num_vertices || (!shape.num_faces && !shape.num_boundary_loops));
    size = cqi_write_header(data, &shape, payload, crc);
    PROVE(size < CQ_MAX_HEADER_BYTES);
    PROVE(cqi_read_header(data, size, &h) == CQ_OK);
    PROVE(h.header_size == size && h.payload_size == payload && h.payload_crc == crc);
    PROVE(h.shape.num_vertices == shape.num_vertices && h.shape.num_faces == shape.num_faces);
    PROVE(h.shape.num_boundary_loops == shape.num_boundary_loops);
    PROVE(h.shape.num_boundary_edges == shape.num_boundary_edges);
    for (k = 0; k < shape.num_channels; k++) {
        PROVE(h.shape.channel[k].kind == shape.channel[k].kind && h.shape.channel[k].bits == shape.channel[k].bits);
        PROVE(h.shape.channel[k].components == shape.channel[k].components);
        PROVE(h.shape.channel[k].step == shape.channel[k].step);
    }
    REACHED();
}
