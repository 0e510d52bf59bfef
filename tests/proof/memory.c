/* Proofs about memory: computing the sizes never wraps around, for any shape; and what is laid out fits the sizes, for
 * shapes of bounded counts. */
#include "proof.h"

#ifndef ROWS
#define ROWS 0 /* 1: shapes may have rows */
#endif

static cq_shape any_shape(void)
{
    cq_shape s;
    uint32_t k;
    s.num_vertices = nondet_u32();
    s.num_faces = nondet_u32();
    s.num_boundary_loops = nondet_u32();
    s.num_boundary_edges = nondet_u32();
    s.num_channels = nondet_u32();
    s.num_rows = nondet_u32();
    s.num_aside_rows = nondet_u32();
    s.num_aside_faces = nondet_u32();
    s.metadata_bytes = nondet_u32();
    s.num_materials = nondet_u32();
    s.regular = nondet_int() != 0;
    ASSUME(s.num_channels <= MAX_CHANNELS && s.metadata_bytes <= CQ_MAX_METADATA);
    ASSUME(!s.num_rows || (s.num_rows > s.num_vertices && s.num_rows <= 3 * (uint64_t)s.num_faces));
    for (k = 0; k < CQ_MAX_CHANNELS; k++) {
        s.channel[k].kind = nondet_u8();
        s.channel[k].components = nondet_u8();
        s.channel[k].bits = nondet_u8();
        s.channel[k].merge = nondet_u8();
        ASSUME(cqi_channel_is_valid(&s.channel[k]));
    }
    return s;
}

/* Components per vertex, row and face: any that claim_components allows, but always the same. */
uint32_t stub_all_components(const cq_shape *s, int of)
{
    static uint32_t components[3];
    static int chosen;
    int k;
    PROVE(s->num_channels <= CQ_MAX_CHANNELS && of >= 0 && of < 3); /* what claim_components asks for */
    for (k = 0; k < 3 && !chosen; k++) components[k] = (uint32_t)any_between(0, CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS);
    ASSUME(components[0] + components[1] + components[2] <= CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS);
    chosen = 1;
    return components[of];
}

void claim_components(void)
{
    cq_shape s = any_shape();
    ASSUME(s.num_channels <= CQ_MAX_CHANNELS);
    PROVE(cqi_all_components(&s, CQI_OF_VERTEX) + cqi_all_components(&s, CQI_OF_ROW) +
              cqi_all_components(&s, CQI_OF_FACE) <= CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS);
    REACHED();
}

/* With --unsigned-overflow-check: nothing on the way to the three sizes wraps around. A shape that has a size has
 * numbers for all of its vertices, faces and halfedges, and CQ_NONE is none of them. */
void claim_sizes(void)
{
    cq_shape s = any_shape();
    size_t mesh = cq_mesh_bytes(&s), decoder = cq_decoder_bytes(&s), encoder = cq_encoder_bytes(&s);
    PROVE((decoder == 0) == (encoder == 0) && (decoder || !mesh));
    if (!decoder) return;
    PROVE(cqi_all_vertices(&s) < CQ_NONE);
    PROVE(cqi_all_faces(&s) <= CQ_NONE / 3);
    REACHED();
}

/* A decoder takes more than its mesh, and an encoder more than a decoder. */
void claim_sizes_grow(void)
{
    cq_shape s = any_shape();
    size_t mesh = cq_mesh_bytes(&s), decoder = cq_decoder_bytes(&s), encoder = cq_encoder_bytes(&s);
    ASSUME(s.num_vertices <= MAX_COUNT && s.num_faces <= MAX_COUNT && s.num_aside_rows <= MAX_COUNT);
    ASSUME(s.num_boundary_loops <= MAX_COUNT && s.num_boundary_edges <= MAX_COUNT && s.num_aside_faces <= MAX_COUNT);
    ASSUME(decoder != 0);
    PROVE(mesh < decoder && decoder < encoder);
    REACHED();
}

void stub_init_seams(cqi_seams *s) { PROVE(__CPROVER_w_ok(s, sizeof(cqi_seams))); }

/* Stands for the models' initial values, which need no memory. */
void stub_model_init(cqi_model *m, const cq_shape *s)
{
    const int channel = cqi_context_channel(s);
    (void)m;
    PROVE(channel >= -1 && channel < CQ_MAX_CHANNELS);
}

/* Counts that are small, and nothing but a mesh and its channels; or also rows. */
static int is_small(const cq_shape *s)
{
    return cqi_all_vertices(s) <= MAX_COUNT && cqi_all_faces(s) <= MAX_COUNT && s->num_rows <= (ROWS ? MAX_COUNT : 0) &&
           !s->num_aside_rows && !s->num_aside_faces && !s->metadata_bytes && !s->num_materials;
}

/* What cqi_start lays out lies in cq_decoder_bytes: CQ_ASSERT in cqi_take, and no block overlaps the one before. */
void claim_decoder_layout(void)
{
    static cq_decoder d;
    size_t v, f;
    uint32_t k;
    d.shape = any_shape();
    d.memory_size = cq_decoder_bytes(&d.shape);
    ASSUME(is_small(&d.shape) && d.memory_size != 0);
    d.memory = (uint8_t *)malloc(d.memory_size);
    ASSUME(d.memory != NULL);
    cqi_start(&d);
    v = cqi_all_vertices(&d.shape);
    f = cqi_all_faces(&d.shape);
    PROVE(__CPROVER_w_ok(d.mesh.origin, 3 * f * sizeof(cq_index)));
    PROVE(__CPROVER_w_ok(d.mesh.twin, 3 * f * sizeof(cq_index)));
    PROVE(__CPROVER_w_ok(d.mesh.out, v * sizeof(cq_index)));
    PROVE(__CPROVER_w_ok(d.mesh.valence, v * sizeof(cq_index)));
    PROVE(__CPROVER_w_ok(d.mesh.mark, v));
    PROVE(__CPROVER_w_ok(d.walk.queue, (f / 3 + 1) * sizeof(cq_index)));
    PROVE(d.mesh.twin >= d.mesh.origin + 3 * f && d.mesh.out >= d.mesh.twin + 3 * f);
    PROVE(d.mesh.valence >= d.mesh.out + v && (cq_index *)d.mesh.mark >= d.mesh.valence + v);
    PROVE((uint8_t *)d.walk.queue >= d.mesh.mark + v);
    for (k = 0; k < d.shape.num_channels; k++) {
        const cq_channel *c = &d.shape.channel[k];
        const int of = cqi_class(&d.shape, k);
        size_t values = of == CQI_OF_FACE ? d.shape.num_faces : (of == CQI_OF_ROW ? d.shape.num_rows : v) * c->components;
        PROVE(__CPROVER_w_ok(d.channel[k], values * sizeof(cq_value)));
    }
    if (d.shape.num_rows) {
        PROVE(__CPROVER_w_ok(d.index, 3 * (size_t)d.shape.num_faces * sizeof(cq_index)));
        PROVE(__CPROVER_w_ok(d.vertex, d.shape.num_rows * sizeof(cq_index)));
        PROVE(__CPROVER_w_ok(d.seams, sizeof(cqi_seams)));
    }
    REACHED();
}

void claim_encoder_layout(void)
{
    static cqi_encoder e;
    cq_input in;
    cqi_arena arena;
    uint32_t k;
    memset(&in, 0, sizeof in);
    in.shape = any_shape();
    arena.left = cq_encoder_bytes(&in.shape);
    ASSUME(arena.left && is_small(&in.shape));
    arena.left -= CQI_ENCODER_BYTES;
    arena.next = (uint8_t *)malloc(arena.left);
    ASSUME(arena.next != NULL);
    for (k = 0; k < in.shape.num_channels; k++) {
        size_t values = in.shape.num_vertices * in.shape.channel[k].components;
        in.values[k] = (const cq_value *)malloc(values * sizeof(cq_value));
        ASSUME(in.values[k] != NULL);
    }
    arena.next += cq_mesh_bytes(&in.shape);
    arena.left -= cq_mesh_bytes(&in.shape);
    cqi_encoder_carve(&e, &in, &arena);
    PROVE(e.replay.memory_size >= cq_decoder_bytes(&in.shape));
    PROVE(__CPROVER_w_ok(e.replay.memory, e.replay.memory_size));
    REACHED();
}
