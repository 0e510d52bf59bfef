/* measure.c - what the codec makes of a mesh file. SPDX-License-Identifier: MIT */
#define CONQUEST_IMPLEMENTATION
#include "measure.h"

#include <math.h>
#include <stdlib.h>

/* -- Rates --------------------------------------------------------------------------------------------------------- */

/* Levels of the paper's kind; and as one would have it. */
static const struct options alone = { .connectivity = 1, .conquest_only = 1, .quiet = 1 };
static const struct options with_positions = {
    .bits = 12, .goal = CQ_LEAST_CONNECTIVITY, .conquest_only = 1, .quiet = 1
};
static const struct options regular = { .connectivity = 1, .quiet = 1 };

static double per_vertex(const struct encoding *e, double bits)
{
    return bits / e->input.shape.num_vertices;
}

static double connectivity_bits(const cq_report *r)
{
    return (double)(r->header + r->base + r->flags + r->indices) / 65536;
}

/* Encodes, and keeps a rate of it. */
static int measure_rate(double *rate, struct mesh_file *mesh, const char *path, const struct options *options)
{
    static struct encoding e;
    const int ok = encode_mesh(&e, mesh, path, options);
    if (ok)
        *rate = per_vertex(&e, options->connectivity ? 8 * (double)e.size : connectivity_bits(&e.report));
    free_encoding(&e);
    return ok;
}

static int measure_mesh(struct measurement *m, struct mesh_file *mesh, const char *path)
{
    if (!measure_rate(&m->with_positions, mesh, path, &with_positions) ||
        !measure_rate(&m->regular, mesh, path, &regular) || !encode_mesh(&m->encoding, mesh, path, &alone))
        return 0;
    m->alone = per_vertex(&m->encoding, 8 * (double)m->encoding.size);
    return 1;
}

int take_measurement(struct measurement *m, const char *path)
{
    struct mesh_file mesh;
    memset(m, 0, sizeof *m);
    if (!load_mesh(&mesh, path, mesh_format_of_path(path)))
        return 0;
    int ok = measure_mesh(m, &mesh, path);
    m->encoding.input.indices = NULL;      /* they go with the mesh */
    mesh_free(&mesh);
    if (!ok)
        free_measurement(m);
    return ok;
}

void free_measurement(struct measurement *m)
{
    free_encoding(&m->encoding);
}

/* -- Splits -------------------------------------------------------------------------------------------------------- */

struct histogram {
    uint32_t count[CQ_MAX_VALENCE];
    uint32_t total;
    uint64_t sum;
};

static void add(struct histogram *h, uint32_t value)
{
    h->count[value]++;
    h->total++;
    h->sum += value;
}

static double mean(const struct histogram *h)
{
    return h->total > 0 ? (double)h->sum / h->total : 0;
}

/* Bits of n symbols out of `total`, when each costs what its frequency tells. */
static double entropy_share(uint32_t n, uint32_t total)
{
    return n > 0 ? n * log2((double)total / n) : 0;
}

static double entropy(const struct histogram *h)
{
    double bits = 0;
    for (int k = 0; k < CQ_MAX_VALENCE; k++)
        bits += entropy_share(h->count[k], h->total);
    return bits;
}

/* Takes one step. If it is a split, the report's sums of the level have grown by its indices. */
static cq_result decode_step(cq_decoder *d, cq_bytes *in, struct histogram *i, struct histogram *j)
{
    const cq_level *level = d->level > 0 ? &d->report->level[d->level - 1] : NULL;
    uint32_t vertices = d->mesh.num_vertices;
    uint32_t sum_i = level != NULL ? level->sum_i : 0, sum_j = level != NULL ? level->sum_j : 0;
    cq_result result = cq_decode(d, in, 1);
    if (level != NULL && d->mesh.num_vertices > vertices) {
        add(i, level->sum_i - sum_i);
        add(j, level->sum_j - sum_j);
    }
    return result;
}

static cq_result decode_steps(cq_report *report, const struct encoding *e, struct histogram *i, struct histogram *j)
{
    static cq_decoder d;
    cq_bytes in = { e->stream, e->size };
    size_t memory_size = cq_decoder_bytes(&e->input.shape);
    void *memory = malloc(memory_size);
    cq_result result = cq_decoder_init(&d, memory, memory_size);
    d.report = report;
    if (result == CQ_OK)
        do
            result = decode_step(&d, &in, i, j);
        while (result == CQ_MORE);
    free(memory);
    return result;
}

int read_splits(struct split_statistics *s, const struct measurement *m, const char *path)
{
    static cq_report report;
    struct histogram i = { { 0 }, 0, 0 }, j = i;
    uint32_t patches = 0, splits = 0;
    cq_result result = decode_steps(&report, &m->encoding, &i, &j);
    for (uint32_t k = 0; k < report.num_levels; k++) {
        patches += report.level[k].num_patches;
        splits += report.level[k].num_splits;
    }
    if (result != CQ_DONE || i.total != splits)
        return complain(path, "the splits cannot be read: %s", cq_result_string(result));
    double flags = entropy_share(splits, patches) + entropy_share(patches - splits, patches);
    s->mean_i = mean(&i);
    s->mean_j = mean(&j);
    s->isolated = patches > 0 ? (double)(patches - splits) / patches : 0;
    s->order0 = per_vertex(&m->encoding, entropy(&i) + entropy(&j) + flags);
    return 1;
}
