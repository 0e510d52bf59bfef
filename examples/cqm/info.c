/* info.c - what a stream holds and what it costs. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- Numbers ------------------------------------------------------------------------------------------------------- */

/* The report counts in 1/65536 bit; a double holds such a number exactly below 2^53. */
static double in_bits(uint64_t cost)
{
    return (double)cost / 65536;
}

/* Of the grid; levels tell distances in sixteenths. */
static double in_steps(uint32_t error)
{
    return error / 16.0;
}

static double ratio(double a, double b)
{
    return b > 0 ? a / b : 0;
}

/* Sum of the genus over all components: each has Euler characteristic 2 - 2 genus once its boundary loops are closed,
 * by one vertex and as many faces as the loop has edges. */
static long long genus(const cq_report *report)
{
    const cq_shape *s = &report->shape;
    long long vertices = (long long)s->num_vertices + s->num_boundary_loops;
    long long faces = (long long)s->num_faces + s->num_boundary_edges;
    long long euler = vertices - faces / 2;        /* 3/2 as many edges as faces */
    return report->num_components - euler / 2;
}

/* How much of a stream there is, and what it holds. */
struct extent {
    size_t bytes, stream_bytes;
    uint32_t vertices, faces;
};

static int is_whole(const struct extent *extent)
{
    return extent->bytes == extent->stream_bytes;
}

/* The empty mesh has one, too. */
static int has_base(const struct extent *extent)
{
    return extent->vertices > 0 || is_whole(extent);
}

struct part {
    const char *name;
    uint64_t cost;
};

#define NUM_PARTS 7

static void list_parts(const cq_report *r, struct part parts[NUM_PARTS])
{
    const struct part list[NUM_PARTS] = {
        { "header", r->header }, { "base", r->base }, { "flags", r->flags },
        { "indices", r->indices }, { "positions", r->positions }, { "channels", r->channels },
        { "aside", r->aside },
    };
    for (int i = 0; i < NUM_PARTS; i++)
        parts[i] = list[i];
}

const char *channel_kind_name(const cq_channel *channel)
{
    static const char *const names[CQ_TURNED + 1] = { "position", "generic", "normal", "texcoord", "color",
                                                      "joints", "weights", "number", "group", "turned" };
    return names[channel->kind];
}

static const char *merge_name(const cq_channel *channel)
{
    static const char *const names[CQ_PER_FACE + 1] = { "average", "copy", "face" };
    return names[channel->merge];
}

/* -- For people ---------------------------------------------------------------------------------------------------- */

static void print_so_far(const struct extent *extent)
{
    printf("so far          %zu of %zu bytes: %lu vertices, %lu faces\n", extent->bytes, extent->stream_bytes,
           (unsigned long)extent->vertices, (unsigned long)extent->faces);
}

/* What not every stream has. */
static void print_other_counts(const cq_shape *s)
{
    if (s->num_rows > 0)
        printf("rows            %lu\n", (unsigned long)s->num_rows);
    if (s->num_aside_rows > 0 || s->num_aside_faces > 0)
        printf("aside           %lu vertices, %lu faces\n", (unsigned long)s->num_aside_rows,
               (unsigned long)s->num_aside_faces);
    if (s->num_materials > 0)
        printf("materials       %lu\n", (unsigned long)s->num_materials);
    if (s->metadata_bytes > 0)
        printf("metadata        %lu bytes\n", (unsigned long)s->metadata_bytes);
}

static void print_counts(const cq_report *r, const struct extent *extent)
{
    printf("vertices        %lu\n", (unsigned long)r->shape.num_vertices);
    printf("faces           %lu\n", (unsigned long)r->shape.num_faces);
    print_other_counts(&r->shape);
    if (!is_whole(extent))
        print_so_far(extent);
    printf("boundary loops  %lu\n", (unsigned long)r->shape.num_boundary_loops);
    if (has_base(extent)) {
        printf("components      %lu\n", (unsigned long)r->num_components);
        printf("genus           %lld\n", genus(r));
        printf("base            %lu vertices, %lu faces\n", (unsigned long)r->base_vertices,
               (unsigned long)r->base_faces);
        printf("levels          %lu%s\n", (unsigned long)r->num_levels, is_whole(extent) ? "" : " so far");
    }
    for (uint32_t k = 0; k < r->shape.num_channels; k++) {
        const cq_channel *c = &r->shape.channel[k];
        printf("channel %lu       %s, %d x %d bits, step %.9g, %s\n", (unsigned long)k, channel_kind_name(c),
               c->components, c->bits, (double)cq_channel_step(c), merge_name(c));
    }
}

static void print_parts(const cq_report *r, const struct extent *extent)
{
    struct part parts[NUM_PARTS];
    double bits = 8 * (double)extent->bytes, vertices = extent->vertices;
    list_parts(r, parts);
    printf("\n%-12s%12s%16s\n", "part", "bytes", "bits/vertex");
    for (int i = 0; i < NUM_PARTS; i++) {
        double part_bits = in_bits(parts[i].cost);
        printf("%-12s%12.1f%16.3f\n", parts[i].name, part_bits / 8, ratio(part_bits, vertices));
    }
    printf("%-12s%12.1f%16.3f\n", "total", bits / 8, ratio(bits, vertices));
}

/* Means are per split, or per vertex that a regular level inserts; of such one `i` and `j` mean nothing. The error is
 * that of the mesh before the level, in steps of the grid. */
static void print_level(const cq_report *r, uint32_t k)
{
    const cq_level *l = &r->level[k];
    double splits = l->num_splits;
    printf("%5lu%10lu%10lu%10lu", (unsigned long)k + 1, (unsigned long)l->num_vertices, (unsigned long)l->num_patches,
           (unsigned long)l->num_splits);
    if (l->regular)
        printf("%16s", "regular");
    else
        printf("%8.2f%8.2f", ratio(l->sum_i, splits), ratio(l->sum_j, splits));
    printf("%8.2f%8.2f%8.2f", ratio(in_bits(l->flags), splits), ratio(in_bits(l->indices), splits),
           ratio(in_bits(l->values), splits));
    if (find_measured(&r->shape) != NULL)
        printf("%10.2f\n", in_steps(l->error));
    else
        printf("%10s\n", "-");
}

static void print_text(const cq_report *r, const struct extent *extent)
{
    print_counts(r, extent);
    print_parts(r, extent);
    printf("\n%51s%24s%10s\n", "mean of", "bits per split of", "before:");
    printf("%5s%10s%10s%10s%8s%8s%8s%8s%8s%10s\n", "level", "vertices", "patches", "splits", "i", "j", "flags", "indices",
           "values", "error");
    for (uint32_t k = 0; k < r->num_levels; k++)
        print_level(r, k);
}

/* -- For programs -------------------------------------------------------------------------------------------------- */

/* Exactly: 1/65536 has 16 decimals. */
static void print_json_bits(const char *name, uint64_t cost, const char *end)
{
    printf("\"%s\": %.16f%s", name, in_bits(cost), end);
}

/* JSON has no infinity; a hostile header may. */
static void print_json_float(double value)
{
    if (isfinite(value))
        printf("%.9g", value);
    else
        printf("null");
}

static void print_json_channel(const cq_channel *c)
{
    printf("{\"kind\": \"%s\", \"merge\": \"%s\", \"components\": %d, \"bits\": %d, \"step\": ", channel_kind_name(c),
           merge_name(c), c->components, c->bits);
    print_json_float((double)cq_channel_step(c));
    printf(", \"origin\": [");
    for (int i = 0; i < c->components; i++) {
        printf("%s", i == 0 ? "" : ", ");
        print_json_float((double)cq_channel_origin(c, i));
    }
    printf("]}");
}

static void print_json_level(const cq_shape *shape, const cq_level *l)
{
    printf("{\"type\": \"%s\", ", l->regular ? "regular" : "conquest");
    printf("\"vertices\": %lu, \"patches\": %lu, \"splits\": %lu, \"sum_i\": %lu, \"sum_j\": %lu, ",
           (unsigned long)l->num_vertices, (unsigned long)l->num_patches, (unsigned long)l->num_splits,
           (unsigned long)l->sum_i, (unsigned long)l->sum_j);
    print_json_bits("flags", l->flags, ", ");
    print_json_bits("indices", l->indices, ", ");
    print_json_bits("values", l->values, ", ");
    if (find_measured(shape) != NULL)
        printf("\"error_before\": %.4f}", in_steps(l->error));
    else
        printf("\"error_before\": null}");
}

static void print_json_so_far(const struct extent *extent)
{
    printf("  \"so_far\": {\"bytes\": %zu, \"vertices\": %lu, \"faces\": %lu},\n", extent->bytes,
           (unsigned long)extent->vertices, (unsigned long)extent->faces);
}

static void print_json_counts(const cq_report *r)
{
    printf("  \"vertices\": %lu,\n  \"faces\": %lu,\n  \"levels\": %lu,\n  \"components\": %lu,\n",
           (unsigned long)r->shape.num_vertices, (unsigned long)r->shape.num_faces, (unsigned long)r->num_levels,
           (unsigned long)r->num_components);
    printf("  \"boundary_loops\": %lu,\n  \"boundary_edges\": %lu,\n  \"genus\": %lld,\n",
           (unsigned long)r->shape.num_boundary_loops, (unsigned long)r->shape.num_boundary_edges, genus(r));
    printf("  \"rows\": %lu,\n  \"aside_rows\": %lu,\n  \"aside_faces\": %lu,\n", (unsigned long)r->shape.num_rows,
           (unsigned long)r->shape.num_aside_rows, (unsigned long)r->shape.num_aside_faces);
    printf("  \"materials\": %lu,\n  \"metadata_bytes\": %lu,\n", (unsigned long)r->shape.num_materials,
           (unsigned long)r->shape.metadata_bytes);
    printf("  \"base_vertices\": %lu,\n  \"base_faces\": %lu,\n", (unsigned long)r->base_vertices,
           (unsigned long)r->base_faces);
    printf("  \"bytes\": %zu,\n  \"bits_per_vertex\": %.17g,\n", r->bytes,
           ratio(8 * (double)r->bytes, r->shape.num_vertices));
}

static void print_json(const cq_report *r, const struct extent *extent)
{
    struct part parts[NUM_PARTS];
    list_parts(r, parts);
    printf("{\n");
    if (!is_whole(extent))
        print_json_so_far(extent);
    print_json_counts(r);
    printf("  \"bits\": {");
    for (int i = 0; i < NUM_PARTS; i++)
        print_json_bits(parts[i].name, parts[i].cost, i + 1 < NUM_PARTS ? ", " : "},\n");
    printf("  \"channels\": [");
    for (uint32_t k = 0; k < r->shape.num_channels; k++) {
        printf("%s", k == 0 ? "" : ", ");
        print_json_channel(&r->shape.channel[k]);
    }
    printf("],\n  \"per_level\": [");
    for (uint32_t k = 0; k < r->num_levels; k++) {
        printf("%s\n    ", k == 0 ? "" : ",");
        print_json_level(&r->shape, &r->level[k]);
    }
    printf("\n  ]\n}\n");
}

/* -- The command --------------------------------------------------------------------------------------------------- */

/* Costs are known when all is decoded that there is. */
static int fill_report(struct decoding *d, cq_report *report, struct extent *extent, const char *path,
                       const uint8_t *data, size_t size)
{
    cq_bytes in = { data, size };
    if (!open_decoding(d, path, data, size))
        return 0;
    d->decoder.report = report;
    cq_result result = cq_decode(&d->decoder, &in, CQ_NO_LIMIT);
    if (result == CQ_NEED_INPUT)
        result = cq_decode(&d->decoder, NULL, CQ_NO_LIMIT);
    extent->bytes = size;
    extent->stream_bytes = d->stream_bytes;
    extent->vertices = d->decoder.mesh.num_vertices;
    extent->faces = count_faces(&d->decoder) - d->decoder.aside.num_faces;
    return result == CQ_DONE || result == CQ_TRUNCATED || complain_stream(path, result, (size_t)(in.data - data));
}

int run_info(const struct options *options)
{
    static struct decoding d;
    static cq_report report;
    struct extent extent = { 0 };
    size_t size;
    uint8_t *data = load_file(options->files[0], &size);
    if (data == NULL)
        return EXIT_BAD_DATA;
    int ok = fill_report(&d, &report, &extent, options->files[0], data, size);
    if (ok && options->json)
        print_json(&report, &extent);
    else if (ok)
        print_text(&report, &extent);
    close_decoding(&d);
    free(data);
    if (fflush(stdout) != 0)
        ok = complain("-", "cannot write");
    if (ok && !is_whole(&extent))
        ok = complain(options->files[0], "truncated after %zu of %zu bytes", size, extent.stream_bytes);
    return ok ? 0 : EXIT_BAD_DATA;
}
