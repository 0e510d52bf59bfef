/* Meshes with values to encode. C99 and C++; include conquest.h first. */
#ifndef CQ_TESTS_SAMPLE_H
#define CQ_TESTS_SAMPLE_H

#include "codec.h"
#include "triangles.h"

typedef struct sample {
    triangles mesh;
    cq_value *values[CQ_MAX_CHANNELS];
    cq_input input;       /* points to the two above */
} sample;

static inline void sample_begin(sample *s, triangles mesh)
{
    memset(s, 0, sizeof *s);
    s->mesh = mesh;
    s->input.shape.num_vertices = mesh.num_vertices;
    s->input.shape.num_faces = mesh.num_faces;
    s->input.indices = s->mesh.indices;
}

/* A float near 1, sometimes one that arithmetic would not give back: -0, NaNs with payloads, infinity. */
static inline uint32_t sample_float(uint32_t ramp, uint64_t random)
{
    static const uint32_t odd[] = {0x80000000u, 0, 0x7fc00001u, 0xffc12345u, 0x7f800001u, 0xff800000u, 0xffffffffu};
    return random % 4 == 0 ? odd[random / 4 % 7] : 0x3f800000u + (ramp << 14) + (uint32_t)(random % 5000);
}

/* Adds a channel of values: neighbours in numbering are near each other, with some noise; faces are in groups. */
static inline void sample_merged(sample *s, cq_kind kind, cq_merge merge, int components, int bits)
{
    uint32_t k = s->input.shape.num_channels++, v, n;
    cq_channel *channel = &s->input.shape.channel[k];
    uint64_t random = 1000 + k;
    int c;
    channel->kind = (uint8_t)kind;
    channel->merge = (uint8_t)merge;
    channel->components = (uint8_t)components;
    channel->bits = (uint8_t)bits;
    channel->step = 0x3f800000u + k;
    for (c = 0; c < components; ++c) channel->origin[c] = 0xc0000000u + (uint32_t)c;
    n = num_owners(channel, s->mesh.num_vertices, s->mesh.num_faces);
    s->values[k] = (cq_value *)exact_alloc((size_t)n * (size_t)components * sizeof(cq_value));
    for (v = 0; v < n; ++v) {
        for (c = 0; c < components; ++c) {
            cq_value *value = &s->values[k][v * (uint32_t)components + (uint32_t)c];
            uint32_t range = (uint32_t)1 << (bits < 32 ? bits : 31);
            uint32_t ramp = (v * (uint32_t)(3 + 8 * c)) % range;
            uint32_t noise = (uint32_t)(next_random(&random) % (1 + range / 16));
            *value = (cq_value)(merge == CQ_PER_FACE ? v / 9 % range : (ramp + noise) % range);
            if (bits == CQ_EXACT_BITS) *value = (cq_value)sample_float(v, next_random(&random));
        }
    }
    s->input.values[k] = s->values[k];
}

static inline void sample_channel(sample *s, cq_kind kind, int components, int bits)
{
    sample_merged(s, kind, CQ_AVERAGE, components, bits);
}

static inline void sample_free(sample *s)
{
    uint32_t k;
    triangles_free(&s->mesh);
    for (k = 0; k < CQ_MAX_CHANNELS; ++k) exact_free(s->values[k]);
    memset(s, 0, sizeof *s);
}

enum { SAMPLES = 9 };

/* A build that can't have exact values has plain ones. */
#define SAMPLE_EXACT_BITS (CQ_INDEX_BITS == 16 ? 14 : CQ_EXACT_BITS)

/* Samples that between them have every feature: no channels and some, closed and not, one level and many, one component
 * and many, a component that is a single triangle, a mesh whose base is all of it, all ways to predict. */
static inline void sample_make(sample *s, int which)
{
    triangles t;
    int k;
    switch (which) {
    case 0: sample_begin(s, triangles_tetrahedron()); break;
    case 1: sample_begin(s, triangles_icosahedron()), sample_channel(s, CQ_POSITION, 3, 10); break;
    case 2: sample_begin(s, triangles_sheet(9, 8)), sample_channel(s, CQ_POSITION, 3, 12); break;
    case 3:
        sample_begin(s, triangles_torus(8, 9));
        sample_channel(s, CQ_GENERIC, 2, 8);
        sample_channel(s, CQ_POSITION, 3, 11);
        sample_channel(s, CQ_GENERIC, 4, 1);
        sample_channel(s, CQ_GENERIC, 1, 15);
        break;
    case 4: sample_begin(s, triangles_torus(16, 15)); break;
    case 5:
        t = triangles_annulus(12);
        triangles_append(&t, triangles_single());
        triangles_append(&t, triangles_pillow());
        triangles_append(&t, triangles_torus(5, 5));
        triangles_append(&t, triangles_disc(40));
        triangles_append(&t, triangles_icosahedron());
        triangles_append(&t, triangles_bipyramid(30));
        sample_begin(s, t);
        sample_channel(s, CQ_POSITION, 3, 15);
        break;
    case 6:
        t = triangles_tetrahedron();
        for (k = 0; k < 60; ++k) triangles_append(&t, k % 3 == 0 ? triangles_tetrahedron() : triangles_single());
        sample_begin(s, t);
        sample_channel(s, CQ_POSITION, 3, 4);
        break;
    case 7: sample_begin(s, triangles_grid(12, 12, 1, 0, 0)), sample_channel(s, CQ_POSITION, 3, 12); break;
    default:
        t = triangles_annulus(14);
        triangles_append(&t, triangles_torus(6, 7));
        sample_begin(s, t);
        sample_merged(s, CQ_POSITION, CQ_AVERAGE, 3, SAMPLE_EXACT_BITS);
        sample_merged(s, CQ_GROUP, CQ_PER_FACE, 1, 5);
        sample_channel(s, CQ_POSITION, 3, 12);
        sample_merged(s, CQ_JOINTS, CQ_COPY, 4, 8);
        sample_channel(s, CQ_NORMAL, 2, 9);
        sample_merged(s, CQ_NUMBER, CQ_PER_FACE, 1, SAMPLE_EXACT_BITS);
        sample_merged(s, CQ_NUMBER, CQ_COPY, 1, 15);
        break;
    }
}

/* A sample and its stream. */
static inline cq_result sample_code(sample *s, coded *c, int which)
{
    sample_make(s, which);
    code(c, &s->input);
    return c->result;
}

#endif
