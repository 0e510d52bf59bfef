/* memory.c - prints how much memory the codec needs. SPDX-License-Identifier: MIT */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include <stdio.h>

/* A closed mesh of genus 0 with n vertices, positions or none. */
static cq_shape sphere(uint32_t n, int positions)
{
    cq_shape s;
    memset(&s, 0, sizeof s);
    s.num_vertices = n;
    s.num_faces = 2 * n - 4;
    s.num_channels = (uint32_t)positions;
    s.channel[0].components = 3;
    return s;
}

int main(void)
{
    const uint32_t n = 10000;
    cq_shape located = sphere(n, 1), bare = sphere(n, 0);
    printf("%d-bit indices, bytes: cq_decoder %u (%.0f KB) + per vertex: "
           "decoder with positions %.1f, without %.1f, encoder %.1f, of any triangles at most %.0f\n",
           CQ_INDEX_BITS, (unsigned)sizeof(cq_decoder), (double)sizeof(cq_decoder) / 1000, (double)cq_decoder_bytes(&located) / n,
           (double)cq_decoder_bytes(&bare) / n, (double)(cq_encoder_bytes(&located) - sizeof(cqi_encoder)) / n,
           (double)(cq_encoder_bytes_at_most(&located) - sizeof(cqi_encoder)) / n);
    return 0;
}
