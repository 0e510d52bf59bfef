/* speed.c - how long a split takes. SPDX-License-Identifier: MIT
 *
 *     speed MESH ...
 *
 * Decodes each mesh many times, its connectivity alone and with 12-bit positions, and prints microseconds of the
 * processor per split, base and conquest included: of the fastest run, since what else the machine does only adds. */
#define CONQUEST_IMPLEMENTATION
#include "cqm.h"

#include <stdlib.h>
#include <time.h>

enum { RUNS = 40 };

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

/* Of one run; below 0 if the stream does not decode. */
static double decode_once(struct decoding *d, const struct encoding *e)
{
    cq_bytes in = { e->stream, e->size };
    double begin = seconds();
    cq_result result = cq_decode(&d->decoder, &in, CQ_NO_LIMIT);
    double end = seconds();
    return result == CQ_DONE ? end - begin : -1;
}

/* Microseconds per split, or below 0 after a complaint. */
static double measure(struct mesh_file *mesh, const char *path, const struct options *options)
{
    static struct encoding e;
    static struct decoding d;
    double best = -1;
    int ok = encode_mesh(&e, mesh, path, options);
    for (int run = 0; ok && run < RUNS; run++) {
        if (!open_decoding(&d, path, e.stream, e.size))
            break;
        double time = decode_once(&d, &e);
        if (time >= 0 && (best < 0 || time < best))
            best = time;
        close_decoding(&d);
    }
    if (ok)
        best *= 1e6 / (mesh->num_vertices - e.report.base_vertices);
    free_encoding(&e);
    return best;
}

static int print_row(const char *path)
{
    static const struct options ways[] = {
        { .connectivity = 1, .quiet = 1 },
        { .bits = 12, .quiet = 1 }
    };
    struct mesh_file mesh;
    double time[2];
    int ok = 1;
    if (!load_mesh(&mesh, path, mesh_format_of_path(path)))
        return 0;
    for (int k = 0; k < 2; k++)
        ok &= (time[k] = measure(&mesh, path, &ways[k])) >= 0;
    if (ok)
        printf("%-40s %9lu %8.2f %16.2f\n", path, (unsigned long)mesh.num_vertices, time[0], time[1]);
    mesh_free(&mesh);
    return ok;
}

int main(int argc, char **argv)
{
    int ok = argc > 1;
    printf("%-40s %9s %8s %16s   microseconds per split\n", "mesh", "vertices", "alone", "with positions");
    for (int k = 1; k < argc; k++)
        ok &= print_row(argv[k]);
    return ok ? 0 : 1;
}
