/* Proofs about memory: the sizes that are published hold what is laid out in them, for every shape that is accepted, and
 * no sum or product on the way overflows; in 64 and in 32 bits of size_t, with 16- and with 32-bit indices.
 *
 * The true sums are computed in 64 bits: counts are below 2^32, components at most 32, so that they stay below 2^42. */
#include "proof.h"

typedef uint64_t wide;

static cq_shape any_shape(void)
{
    cq_shape s;
    uint32_t k;
    s.num_vertices = nondet_u32();
    s.num_faces = nondet_u32();
    s.num_boundary_loops = nondet_u32();
    s.num_boundary_edges = nondet_u32();
    s.num_channels = NUM_CHANNELS;
    for (k = 0; k < CQ_MAX_CHANNELS; k++) {
        s.channel[k].kind = nondet_u8();
        s.channel[k].components = COMPONENTS;
        s.channel[k].bits = nondet_u8();
        s.channel[k].reserved = 0;
        ASSUME(cqi_channel_is_valid(&s.channel[k]));
    }
    return s;
}

static wide round4(wide n) { return (n + 3) / 4 * 4; }

/* What cqi_mesh_carve and cqi_start lay out. */
static wide mesh_sum(const cq_shape *s)
{
    wide v = (wide)s->num_vertices + s->num_boundary_loops, f = (wide)s->num_faces + s->num_boundary_edges;
    return round4((6 * f + 2 * v) * sizeof(cq_index)) + round4(v);
}

static wide decoder_sum(const cq_shape *s, wide components)
{
    wide v = (wide)s->num_vertices + s->num_boundary_loops, f = (wide)s->num_faces + s->num_boundary_edges;
    return mesh_sum(s) + round4((f / 3 + 1) * sizeof(cq_index)) + round4(v * components * sizeof(cq_value));
}

/* What cqi_encoder_carve lays out before the decoder. */
static wide notes_sum(const cq_shape *s, wide components)
{
    wide v = (wide)s->num_vertices + s->num_boundary_loops, f = (wide)s->num_faces + s->num_boundary_edges;
    return 7 * round4(v * sizeof(cq_index)) + round4(v) + round4((f / 3 + 1) * sizeof(cq_index)) +
           2 * round4(f * sizeof(cq_index)) + round4((wide)s->num_vertices * components * sizeof(cq_value));
}

/* Numbers of vertices, faces and halfedges fit in cq_index, and CQ_NONE is none of them. */
static int countable(const cq_shape *s)
{
    wide v = (wide)s->num_vertices + s->num_boundary_loops, f = (wide)s->num_faces + s->num_boundary_edges;
    return v < CQ_NONE && 3 * f <= CQ_NONE;
}

void claim_sizes(void)
{
    cq_shape s = any_shape();
    size_t mesh = cq_mesh_bytes(&s), decoder = cq_decoder_bytes(&s), encoder = cq_encoder_bytes(&s);
    wide components;
    if (!mesh) {
        PROVE(!decoder && !encoder);
        return;
    }
    components = cqi_all_components(&s);
    PROVE(components <= CQ_MAX_CHANNELS * CQ_MAX_COMPONENTS);
    PROVE(countable(&s));
    PROVE(mesh == mesh_sum(&s));
    PROVE(decoder == decoder_sum(&s, components));
    PROVE(encoder >= CQI_ENCODER_BYTES + mesh_sum(&s) + notes_sum(&s, components) + decoder_sum(&s, components));
    PROVE(encoder % 4 == 0 && decoder % 4 == 0 && mesh % 4 == 0);
    REACHED();
}

/* Every shape that a size was published for is laid out inside that many bytes: CQ_ASSERT in cqi_take. */
void claim_decoder_layout(void)
{
    static cq_decoder d;
    size_t v, f;
    uint32_t k;
    d.shape = any_shape();
    d.memory_size = cq_decoder_bytes(&d.shape);
    ASSUME(d.memory_size && d.memory_size <= MAX_SIZE);
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
    PROVE(__CPROVER_w_ok(d.patch, (f / 3 + 1) * sizeof(cq_index)));
    PROVE(d.mesh.twin >= d.mesh.origin + 3 * f && d.mesh.out >= d.mesh.twin + 3 * f);
    PROVE(d.mesh.valence >= d.mesh.out + v && (cq_index *)d.mesh.mark >= d.mesh.valence + v);
    PROVE((uint8_t *)d.patch >= d.mesh.mark + v);
    for (k = 0; k < d.shape.num_channels; k++)
        PROVE(__CPROVER_w_ok(d.channel[k], v * d.shape.channel[k].components * sizeof(cq_value)));
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
    ASSUME(arena.left && cqi_all_vertices(&in.shape) <= MAX_COUNT && cqi_all_faces(&in.shape) <= MAX_COUNT);
    arena.left -= CQI_ENCODER_BYTES;
    arena.next = (uint8_t *)malloc(arena.left);
    ASSUME(arena.next != NULL);
    for (k = 0; k < in.shape.num_channels; k++) {
        in.values[k] = (const cq_value *)malloc(in.shape.num_vertices * in.shape.channel[k].components * sizeof(cq_value));
        ASSUME(in.values[k] != NULL);
    }
    arena.next += cq_mesh_bytes(&in.shape);
    arena.left -= cq_mesh_bytes(&in.shape);
    cqi_encoder_carve(&e, &in, &arena);
    PROVE(e.replay.memory_size >= cq_decoder_bytes(&in.shape));
    PROVE(__CPROVER_w_ok(e.replay.memory, e.replay.memory_size));
    REACHED();
}
