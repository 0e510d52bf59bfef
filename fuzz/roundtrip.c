/* A mesh comes back as it was, through the map; so do faces that are no oriented manifold, but only as triangles of rows of
 * values. What names a vertex that there is not is refused. The mesh is grown by the bytes, then perhaps damaged, or
 * its faces are the
 * bytes. */
#include "surface.h"

/* Faces that name any vertices. */
static model take_noise(input *in)
{
    model m;
    uint32_t k, most = 1 + take(in) % 16;
    memset(&m, 0, sizeof m);
    m.input.shape.num_vertices = take(in) % 16;
    m.input.shape.num_faces = (uint32_t)(in->size < 600 ? in->size / 3 : 200);
    m.indices = (cq_index *)block(3 * (size_t)m.input.shape.num_faces * sizeof(cq_index));
    for (k = 0; k < 3 * m.input.shape.num_faces; k++) m.indices[k] = (cq_index)(take(in) % most);
    m.input.indices = m.indices;
    return m;
}

static void damage_faces(model *m, input *in)
{
    uint32_t count = take(in) % 4, k;
    for (k = 0; k < count && m->input.shape.num_faces > 0; k++) {
        uint32_t at = take_two(in) % (3 * m->input.shape.num_faces);
        m->indices[at] = (cq_index)(take(in) % (m->input.shape.num_vertices + 1));
    }
}

static int compare_faces(const void *a, const void *b) { return memcmp(a, b, 3 * sizeof(cq_index)); }

/* The faces through the map (NULL: as they are), each from its smallest vertex on, sorted. */
static cq_index *face_set(const cq_index *indices, uint32_t num_faces, const cq_index *map)
{
    cq_index *set = (cq_index *)block(3 * (size_t)num_faces * sizeof(cq_index));
    uint32_t f, k;
    for (f = 0; f < num_faces; f++) {
        cq_index v[3];
        uint32_t least;
        for (k = 0; k < 3; k++) v[k] = map != NULL ? map[indices[3 * f + k]] : indices[3 * f + k];
        least = v[0] < v[1] ? (v[0] < v[2] ? 0 : 2) : (v[1] < v[2] ? 1 : 2);
        for (k = 0; k < 3; k++) set[3 * f + k] = v[(least + k) % 3];
    }
    qsort(set, num_faces, 3 * sizeof *set, compare_faces);
    return set;
}

static void check_permutation(const cq_index *map, uint32_t n)
{
    uint32_t v;
    uint8_t *seen = (uint8_t *)block(n);
    memset(seen, 0, n);
    for (v = 0; v < n; v++) {
        REQUIRE(map[v] < n && !seen[map[v]]);
        seen[map[v]] = 1;
    }
    free(seen);
}

/* Does the triangle have the corners of the other one, through the map, in the same cyclic order? */
static int is_turned(const cq_index *from, const cq_index *map, const cq_index *to)
{
    uint32_t k;
    for (k = 0; k < 3; k++)
        if (map[from[0]] == to[k] && map[from[1]] == to[(k + 1) % 3] && map[from[2]] == to[(k + 2) % 3]) return 1;
    return 0;
}

static void check_decoded(const model *m, const cq_index *map, const cq_index *face_map, const cq_decoder *d)
{
    uint32_t n = m->input.shape.num_vertices, faces = m->input.shape.num_faces, f, k;
    size_t j;
    cq_index *a, *b;
    REQUIRE(d->mesh.num_vertices == n && d->mesh.num_faces == faces);
    check_permutation(map, n);
    check_permutation(face_map, faces);
    for (f = 0; f < faces; f++) REQUIRE(is_turned(m->indices + 3 * f, map, d->mesh.origin + 3 * (size_t)face_map[f]));
    a = face_set(m->indices, faces, map);
    b = face_set(d->mesh.origin, faces, NULL);
    REQUIRE(memcmp(a, b, 3 * (size_t)faces * sizeof *a) == 0);
    REQUIRE(memcmp(d->shape.channel, m->input.shape.channel, sizeof d->shape.channel) == 0);
    for (k = 0; k < d->shape.num_channels; k++) {
        const cq_channel *channel = &d->shape.channel[k];
        const cq_index *to = channel->merge == CQ_PER_FACE ? face_map : map;
        for (j = 0; j < num_values(channel, n, faces); j++) {
            size_t stride = channel->components;
            REQUIRE(d->channel[k][to[j / stride] * stride + j % stride] == m->values[k][j]);
        }
    }
    free(a);
    free(b);
}

/* Encoder and decoder spend the same bits on the same things. */
static void check_same_report(const cq_report *a, const cq_report *b)
{
    REQUIRE(a->bytes == b->bytes && a->num_levels == b->num_levels && a->num_components == b->num_components);
    REQUIRE(a->base_vertices == b->base_vertices && a->base_faces == b->base_faces);
    REQUIRE(a->header == b->header && a->base == b->base && a->flags == b->flags);
    REQUIRE(a->indices == b->indices && a->positions == b->positions && a->channels == b->channels && a->aside == b->aside);
    REQUIRE(memcmp(a->level, b->level, a->num_levels * sizeof *a->level) == 0);
}

/* 1 if no two faces share an edge in one direction, no edge has three faces, and each vertex has one fan: by
 * counting. */
static int is_manifold(const cq_index *indices, uint32_t num_vertices, uint32_t num_faces)
{
    uint32_t v, f, k;
    for (f = 0; f < 3 * num_faces; f++)
        if (indices[f] >= num_vertices || indices[f] == indices[f / 3 * 3 + (f % 3 + 1) % 3]) return 0;
    for (v = 0; v < num_vertices; v++) {
        /* The edges opposite v, as a map from start to end, are one path or one cycle. */
        uint32_t next[SURFACE_VERTICES], before[SURFACE_VERTICES], count = 0, first = SURFACE_VERTICES, length = 0;
        for (k = 0; k < num_vertices; k++) next[k] = before[k] = SURFACE_VERTICES;
        for (f = 0; f < 3 * num_faces; f++) {
            uint32_t a = indices[f / 3 * 3 + (f % 3 + 1) % 3], b = indices[f / 3 * 3 + (f % 3 + 2) % 3];
            if (indices[f] != v) continue;
            if (next[a] != SURFACE_VERTICES || before[b] != SURFACE_VERTICES) return 0;
            next[a] = b;
            before[b] = a;
            first = a;
            count++;
        }
        if (count == 0) return 0;
        for (k = 0; k < count && before[first] != SURFACE_VERTICES; k++) first = before[first];
        for (k = first; next[k] != SURFACE_VERTICES && (length == 0 || k != first); length++) k = next[k];
        if (length != count) return 0;
    }
    return 1;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    uint32_t kind = take(&in), n, k, outside = 0;
    model m = kind < 16 ? take_noise(&in) : take_model(&in);
    cq_index *map = NULL, *face_map = NULL;
    cq_report *report = (cq_report *)block(sizeof *report);
    stream s;
    cq_result result;
    if (kind >= 240) damage_faces(&m, &in);
    n = m.input.shape.num_vertices;
    map = (cq_index *)block(n * sizeof(cq_index));
    face_map = (cq_index *)block(m.input.shape.num_faces * sizeof(cq_index));
    result = encode(&m, &s, map, face_map, report);
    for (k = 0; k < 3 * m.input.shape.num_faces; k++) outside |= m.indices[k] >= n;
    REQUIRE(result == (outside ? CQ_ERROR_INDEX : CQ_OK));
    if (result == CQ_OK) {
        decoding d = decoding_begin(&s);
        decoding_run(&d, &s);
        REQUIRE(d.result == CQ_DONE && d.used == s.size);
        REQUIRE(same_triangles(&m.input, d.decoder) && same_unused_rows(&m.input, d.decoder));
        REQUIRE(maps_are_right(&m.input, d.decoder, map, face_map));
        if (report->prepared.seam_edges + report->prepared.merged_rows == 0 && is_manifold(m.indices, n, m.input.shape.num_faces) &&
            d.decoder->shape.num_rows + d.decoder->aside.num_faces == 0)
            check_decoded(&m, map, face_map, d.decoder);
        if (d.report != NULL) check_same_report(d.report, report);
        decoding_end(&d);
    }
    free(s.data);
    free(report);
    free(map);
    free(face_map);
    model_free(&m);
    return 0;
}
