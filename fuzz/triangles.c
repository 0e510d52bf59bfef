/* Any triangles over any rows: seams, junctions, cuts, copies, materials, all that is no surface. They come back. The bytes are
 * coordinates of few bits, attributes of rows, and the rows of faces, which mostly follow each other in strips. */
#include "surface.h"

enum { MOST_FACES = 160 };
static cq_index *materials;

static void add_values(model *m, uint32_t kind, uint32_t components, uint32_t bits, input *in)
{
    const uint32_t k = m->input.shape.num_channels++, n = m->input.shape.num_vertices * components;
    cq_channel *channel = &m->input.shape.channel[k];
    uint32_t j;
    channel->kind = (uint8_t)kind;
    channel->components = (uint8_t)components;
    channel->bits = (uint8_t)bits;
    channel->merge = (uint8_t)(bits % 3 == 0 ? CQ_COPY : CQ_AVERAGE);
    m->values[k] = (cq_value *)block(n * sizeof(cq_value));
    m->input.values[k] = m->values[k];
    for (j = 0; j < n; j++) {
        uint32_t x = take(in);
        m->values[k][j] = (cq_value)(x < 128 && j >= components ? (uint32_t)m->values[k][j - components] : x % (1u << bits));
    }
}

/* They follow the number of the first row. */
static void add_materials(model *m, uint32_t count, input *in)
{
    const uint32_t width = 1 + take(in) % 16;
    uint32_t f;
    cq_index *material = (cq_index *)block(m->input.shape.num_faces * sizeof(cq_index));
    for (f = 0; f < m->input.shape.num_faces; f++) material[f] = (cq_index)(m->indices[3 * f] / width % count);
    m->input.shape.num_materials = count;
    m->input.materials = materials = material;
}

static model take_triangles(input *in)
{
    model m;
    uint32_t form = take(in), size = take(in), f, k;
    memset(&m, 0, sizeof m);
    m.input.shape.num_vertices = 1 + take(in) % 100;
    if (form & 1) add_values(&m, CQ_POSITION, 3, 1 + size % 5, in);
    if (form & 2) add_values(&m, CQ_NORMAL, 2, 2 + size % 7, in);
    if (form & 4) add_values(&m, CQ_TEXCOORD, 2, 1 + size % 8, in);
    if ((form & 6) == 6 && size & 16) add_values(&m, CQ_TANGENT, 2 + (size & 1), 2 + size % 7, in);
    if (form & 8) add_values(&m, CQ_JOINTS, 1 + size / 32 % 4, 3, in);
    if (form & 8 && size & 16) add_values(&m, CQ_WEIGHTS, 1 + size / 32 % 4, 4, in);
    m.input.clean = form >> 4 & 1;
    m.input.goal = (cq_goal)(form >> 5 & 1);
    m.input.shape.metadata_bytes = form >= 192 ? size : 0;
    m.input.metadata = (const uint8_t *)"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"
                       "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"
                       "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";
    m.indices = (cq_index *)block(3 * (size_t)MOST_FACES * sizeof(cq_index));
    m.input.indices = m.indices;
    for (f = 0; f < MOST_FACES && in->size > 0; f++) {
        uint32_t x = take(in);
        for (k = 0; k < 3; k++) {
            const uint32_t before = f > 0 ? m.indices[3 * f - 3 + (k + x) % 3] : k;
            m.indices[3 * f + k] = (cq_index)((k < 2 && x >= 64 ? before : take(in)) % m.input.shape.num_vertices);
        }
        if (x >= 160) {
            const cq_index a = m.indices[3 * f];
            m.indices[3 * f] = m.indices[3 * f + 1];
            m.indices[3 * f + 1] = a;
        }
    }
    m.input.shape.num_faces = f;
    if (size & 8) add_materials(&m, 2 + size % 7, in);
    return m;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    model m = take_triangles(&in);
    cq_index *map = (cq_index *)block(m.input.shape.num_vertices * sizeof(cq_index));
    cq_index *face_map = (cq_index *)block(m.input.shape.num_faces * sizeof(cq_index));
    stream s;
    decoding d;
    REQUIRE(encode(&m, &s, map, face_map, NULL) == CQ_OK);
    d = decoding_begin(&s);
    decoding_run(&d, &s);
    REQUIRE(d.result == CQ_DONE && d.used == s.size);
    REQUIRE(same_triangles(&m.input, d.decoder) && same_unused_rows(&m.input, d.decoder));
    REQUIRE(maps_are_right(&m.input, d.decoder, map, face_map));
    decoding_end(&d);
    free(s.data);
    free(materials);
    materials = NULL;
    free(map);
    free(face_map);
    model_free(&m);
    return 0;
}
