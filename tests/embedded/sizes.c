/* sizes.c - on a machine whose size_t and int have 16 bits: what does not fit is refused, 16 raw bits are coded.
 * SPDX-License-Identifier: MIT */
#undef CQ_NO_REGULAR /* an encoder has them */
#undef CQ_NO_ATTRIBUTES
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "board.h"

static uint8_t failed;

static void check(int good, const char *what)
{
    if (good) return;
    board_print("FAIL ");
    board_print(what);
    board_print("\n");
    failed = 1;
}

/* 3 vertices and 5174 faces: the mesh takes 62104 bytes, all of the decoder 65556, which is 20 modulo 2^16. */
static void check_sizes(void)
{
    cq_shape s;
    memset(&s, 0, sizeof s);
    s.num_vertices = 3;
    s.num_faces = 5174;
    check(cq_mesh_bytes(&s) == 62104u, "a mesh that fits");
    check(cq_decoder_bytes(&s) == 0, "a decoder that does not fit");
    check(cq_encoder_bytes(&s) == 0, "an encoder that does not fit");
    s.num_faces = 6000;
    check(cq_mesh_bytes(&s) == 0, "a mesh that does not fit");
}

/* A tetrahedron's header with a payload of 65544 bytes, 8 modulo 2^16. */
static void check_payload(void)
{
    uint8_t header[16] = { 'C', 'Q', CQ_STREAM_VERSION, 4, 0, 2, 0, 0x88, 0x80, 0x04, 0, 0, 0, 0 };
    cq_shape s;
    uint32_t crc = cqi_crc32(0, header, 14);
    header[14] = (uint8_t)crc;
    header[15] = (uint8_t)(crc >> 8);
    check(cq_peek(header, sizeof header, &s, NULL, NULL) == CQ_ERROR_TOO_LARGE, "a payload that does not fit");
}

static void check_raw_bits(void)
{
    uint8_t bytes[8];
    cq_range_encoder e;
    cq_range_decoder d;
    cq_range_encoder_init(&e, bytes, sizeof bytes);
    cq_encode_raw(&e, 12345, 16);
    cq_encode_raw(&e, 54321, 16);
    cq_range_decoder_init(&d, bytes, cq_range_encoder_finish(&e));
    check(cq_decode_raw(&d, 16) == 12345 && cq_decode_raw(&d, 16) == 54321, "16 raw bits");
}

int main(void)
{
    check_sizes();
    check_payload();
    check_raw_bits();
    board_print(failed ? "failed\n" : "all refused\n");
    return 0;
}
