/* rates.c - bits per vertex of many meshes, told apart by whether the priors were fitted to them.
 * SPDX-License-Identifier: MIT
 *
 *     rates TRAINED MESH...
 *
 * TRAINED is a text with the names of the files that were trained on, one a line. A mesh counts as trained on if its
 * name is there, or if another mesh of the arguments whose name is there has the same connectivity. Exit status: 0; 1
 * if a file is bad; 2 for bad usage. */
#include "measure.h"

#include <stdlib.h>
#include <string.h>

struct mesh {
    const char *name;
    struct measurement measurement;
    int trained;
};

/* -- Which meshes were trained on ---------------------------------------------------------------------------------- */

static const char *file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

/* 1 if a line of the text is the name. */
static int lists(const char *text, size_t size, const char *name)
{
    size_t length = strlen(name);
    for (const char *line = text, *end = text + size; line < end;) {
        const char *stop = memchr(line, '\n', (size_t)(end - line));
        if (stop == NULL)
            stop = end;
        if ((size_t)(stop - line) == length && memcmp(line, name, length) == 0)
            return 1;
        line = stop + 1;
    }
    return 0;
}

/* The encoder gives equal streams for equal faces, in equal order. */
static int same_connectivity(const struct encoding *a, const struct encoding *b)
{
    return a->size == b->size && memcmp(a->stream, b->stream, a->size) == 0;
}

static void find_trained(struct mesh *meshes, int n, const char *list, size_t size)
{
    for (int k = 0; k < n; k++)
        meshes[k].trained = lists(list, size, meshes[k].name);
    for (int k = 0; k < n; k++)
        for (int other = 0; other < n && lists(list, size, meshes[k].name); other++)
            if (same_connectivity(&meshes[k].measurement.encoding, &meshes[other].measurement.encoding))
                meshes[other].trained = 1;
}

/* -- The report ---------------------------------------------------------------------------------------------------- */

static void print_mesh(const struct mesh *m)
{
    const cq_shape *shape = &m->measurement.encoding.input.shape;
    printf("%-32s%10lu%10lu%10.3f%12.3f\n", m->name, (unsigned long)shape->num_vertices,
           (unsigned long)shape->num_boundary_loops, m->measurement.alone, m->measurement.with_positions);
}

/* The meshes with this `trained`, then their mean and the worst of each rate. */
static void print_meshes(const struct mesh *meshes, int n, int trained)
{
    const struct mesh *worst_alone = NULL, *worst_with = NULL;
    double sum_alone = 0, sum_with = 0;
    int count = 0;
    for (int k = 0; k < n; k++) {
        const struct mesh *m = &meshes[k];
        if (m->trained != trained)
            continue;
        print_mesh(m);
        sum_alone += m->measurement.alone;
        sum_with += m->measurement.with_positions;
        if (worst_alone == NULL || m->measurement.alone > worst_alone->measurement.alone)
            worst_alone = m;
        if (worst_with == NULL || m->measurement.with_positions > worst_with->measurement.with_positions)
            worst_with = m;
        count++;
    }
    if (count == 0)
        return;
    printf("%-32s%10d%10s%10.3f%12.3f\n", "mean of", count, "", sum_alone / count, sum_with / count);
    printf("%-32s%20s%10.3f%12.3f  %s, %s\n", "worst", "", worst_alone->measurement.alone,
           worst_with->measurement.with_positions, worst_alone->name, worst_with->name);
}

static void print_report(const struct mesh *meshes, int n)
{
    printf("Bits per vertex of the connectivity: alone, and in a stream with 12-bit positions\n");
    for (int trained = 0; trained <= 1; trained++) {
        printf("\n%-32s%10s%10s%10s%12s\n", trained ? "trained on" : "not trained on", "vertices", "loops", "alone",
               "positions");
        print_meshes(meshes, n, trained);
    }
}

/* Measures the files that can be; returns how many. */
static int measure_all(struct mesh *meshes, char **paths, int n)
{
    int measured = 0;
    for (int k = 0; k < n; k++) {
        meshes[measured].name = file_name(paths[k]);
        measured += take_measurement(&meshes[measured].measurement, paths[k]);
    }
    return measured;
}

int main(int argc, char **argv)
{
    size_t size;
    if (argc < 3) {
        fprintf(stderr, "usage: rates TRAINED MESH...\n");
        return EXIT_BAD_USAGE;
    }
    int num_paths = argc - 2;
    char *list = (char *)load_file(argv[1], &size);
    struct mesh *meshes = calloc((size_t)num_paths, sizeof *meshes);
    if (list == NULL || meshes == NULL)
        return EXIT_BAD_DATA;
    int n = measure_all(meshes, argv + 2, num_paths);
    find_trained(meshes, n, list, size);
    print_report(meshes, n);
    for (int k = 0; k < n; k++)
        free_measurement(&meshes[k].measurement);
    free(meshes);
    free(list);
    return n == num_paths ? 0 : EXIT_BAD_DATA;
}
