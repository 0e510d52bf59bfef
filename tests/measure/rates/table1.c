/* table1.c - the paper's Table 1 beside what this codec does. SPDX-License-Identifier: MIT
 *
 *     table1 FOLDER TORUS
 *
 * Three rows for each model of the table that FOLDER has as NAME.off, .obj, .ply or .stl, and for the torus, which is
 * in the file TORUS: what the paper says, what is measured here, and four fifths of the paper's rate, which is the least
 * that is expected (but of the torus, whose connectivity levels of patches cannot tell as cheaply as it is).
 * Then the paper's claims, checked on these models.
 *
 * Exit status: 0; 1 if a rate is not as expected, a file is bad or the folder has none of the models; 2 for bad usage. */
#include "measure.h"

#include <string.h>

/* -- Table 1 ------------------------------------------------------------------------------------------------------- */

struct model {
    const char *name;
    unsigned vertices, base_vertices, levels;
    double index1, index2, isolated, rate;     /* per cent; bits per vertex */
    double alliez_desbrun;                     /* reference [2] of the paper, 2001; 0: not listed */
    int expected;                              /* four fifths of the rate */
};

static const struct model models[] = {
    { "fandisk", 6475, 4, 38, 1.50, 1.24, 5.7, 4.06, 4.99, 1 },
    { "horse", 19851, 4, 45, 1.43, 1.28, 6.6, 4.47, 4.61, 1 },
    { "mannequin", 11703, 4, 41, 1.49, 1.25, 5.7, 3.83, 3.58, 1 },
    { "torus", 36450, 12, 42, 1.36, 1.48, 3.5, 3.04, 0.39, 0 },
    { "dinosaur", 14070, 4, 42, 1.47, 1.26, 7.8, 4.59, 0, 1 },
    { "eight", 766, 18, 23, 1.67, 1.32, 8.3, 4.45, 0, 1 },
    { "feline", 49864, 13, 49, 1.44, 1.26, 7.3, 4.48, 0, 1 },
    { "sampleavatar", 1290, 4, 32, 1.52, 1.39, 8.0, 4.53, 0, 1 },
};

enum { NUM_MODELS = sizeof models / sizeof models[0], MAX_PATH = 4096 };

/* The paper's bound of the rate: two integers from 0 with mean 3/2, section 3. */
#define BOUND 4.85

/* -- Claims -------------------------------------------------------------------------------------------------------- */

/* Smallest and largest of what was measured, and on which models. */
struct range {
    double low, high;
    const char *low_name, *high_name;
};

static void widen(struct range *r, double value, const char *name)
{
    if (r->low_name == NULL || value < r->low) {
        r->low = value;
        r->low_name = name;
    }
    if (r->high_name == NULL || value > r->high) {
        r->high = value;
        r->high_name = name;
    }
}

static struct range isolated, mean_index, order0, alone, with_positions, saved_alone, saved_with_positions;

static void note_for_claims(const struct measurement *m, const struct split_statistics *s, const struct model *p)
{
    const char *name = p->name;
    widen(&isolated, 100 * s->isolated, name);
    widen(&mean_index, (s->mean_i + s->mean_j) / 2, name);
    widen(&order0, s->order0, name);
    widen(&alone, m->alone, name);
    widen(&with_positions, m->with_positions, name);
    widen(&saved_alone, 100 * (1 - m->alone / p->rate), name);
    widen(&saved_with_positions, 100 * (1 - m->with_positions / p->rate), name);
}

static void print_claim(int holds, const char *claim)
{
    printf("%s  %s\n", holds ? "HOLDS" : "FAILS", claim);
}

static void print_range(const char *what, const struct range *r)
{
    printf("       %-40s %.2f (%s) to %.2f (%s)\n", what, r->low, r->low_name, r->high, r->high_name);
}

static void print_saved(const char *what, const struct range *r)
{
    printf("       %-40s %.0f (%s) to %.0f (%s)\n", what, r->low, r->low_name, r->high, r->high_name);
}

/* Near: nearer than 1/4. The means of the paper's own table are 1.35 to 1.50. */
static void print_claims(void)
{
    printf("\nThe paper's claims\n\n");
    print_claim(isolated.high < 10, "less than 10 % of the patches are isolated, on every model");
    print_range("isolated, per cent", &isolated);
    print_claim(mean_index.low > 1.25 && mean_index.high < 1.75, "the mean of the two indices is near 1.5");
    print_range("mean of both indices", &mean_index);
    print_claim(order0.high < BOUND && alone.high < BOUND && with_positions.high < BOUND,
                "every rate is below the bound of section 3, 4.85 bits per vertex");
    print_range("order-0 entropy, as the paper codes", &order0);
    print_range("this codec, connectivity alone", &alone);
    print_range("this codec, positions present", &with_positions);
    printf("\nPer cent less than the paper's rates\n\n");
    print_saved("connectivity alone", &saved_alone);
    print_saved("positions present", &saved_with_positions);
}

/* -- The table ----------------------------------------------------------------------------------------------------- */

static void print_heading(void)
{
    printf("%-14s%-8s%16s%8s%14s%10s%10s%16s%10s%9s\n", "", "", "", "", "mean of", "isolated", "order-0",
           "bits per vertex", "Alliez,", "regular");
    printf("%-14s%-8s%16s%8s%14s%10s%10s%8s%8s%10s%9s\n", "", "", "vertices", "", "index", "patches", "entropy", "alone",
           "with", "Desbrun", "levels,");
    printf("%-14s%-8s%16s%8s%7s%7s%10s%10s%8s%8s%10s%9s\n", "model", "", "to base", "levels", "1", "2", "per cent", "",
           "", "pos.", "2001", "alone");
}

static void print_counts(const char *name, const char *source, unsigned vertices, unsigned base, unsigned levels)
{
    char counts[32];
    snprintf(counts, sizeof counts, "%u -> %u", vertices, base);
    printf("%-14s%-8s%16s%8u", name, source, counts, levels);
}

/* A rate, or "-" for one that there is not. */
static void print_rate(int width, double rate)
{
    if (rate > 0)
        printf("%*.2f", width, rate);
    else
        printf("%*s", width, "-");
}

static void print_paper(const struct model *p)
{
    print_counts(p->name, "paper", p->vertices, p->base_vertices, p->levels);
    printf("%7.2f%7.2f%10.1f%10s%8.2f%8s", p->index1, p->index2, p->isolated, "-", p->rate, "-");
    print_rate(10, p->alliez_desbrun);
    printf("\n");
}

static void print_here(const struct measurement *m, const struct split_statistics *s)
{
    const cq_report *r = &m->encoding.report;
    print_counts("", "here", r->shape.num_vertices, r->base_vertices, r->num_levels);
    printf("%7.2f%7.2f%10.1f%10.2f%8.3f%8.3f%10s%9.3f\n", s->mean_i, s->mean_j, 100 * s->isolated, s->order0, m->alone,
           m->with_positions, "", m->regular);
}

static int print_expected(const struct model *p, const struct measurement *m)
{
    const double expected = 0.8 * p->rate;
    const int holds = m->alone <= expected && m->with_positions <= expected;
    printf("%-14s%-8s%58s%8.2f%8.2f%10s\n", "", "4/5", "", expected, expected, holds ? "holds" : "MISSED");
    return holds;
}

/* The rows of one model. Returns 1 if its rates are as expected. */
static int print_model(const struct model *p, const char *path)
{
    static struct measurement m;
    struct split_statistics s;
    if (!take_measurement(&m, path))
        return 0;
    int ok = read_splits(&s, &m, path);
    if (ok) {
        note_for_claims(&m, &s, p);
        print_paper(p);
        print_here(&m, &s);
        ok = p->expected ? print_expected(p, &m) : 1;
        fflush(stdout);
    }
    free_measurement(&m);
    return ok;
}

/* -- Files --------------------------------------------------------------------------------------------------------- */

static int exists(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file != NULL)
        fclose(file);
    return file != NULL;
}

static int find_model(char path[MAX_PATH], const char *folder, const char *name)
{
    static const char *const endings[] = { "off", "obj", "ply", "stl" };
    for (size_t k = 0; k < sizeof endings / sizeof endings[0]; k++) {
        int length = snprintf(path, MAX_PATH, "%s/%s.%s", folder, name, endings[k]);
        if (length < MAX_PATH && exists(path))
            return 1;
    }
    return 0;
}

/* Fills in the path of each model, "" where there is none; returns how many the folder has. */
static int find_models(char paths[NUM_MODELS][MAX_PATH], const char *folder, const char *torus)
{
    int found = 0;
    for (int k = 0; k < NUM_MODELS; k++) {
        int is_torus = strcmp(models[k].name, "torus") == 0;
        if (is_torus)
            snprintf(paths[k], MAX_PATH, "%s", torus);
        else if (find_model(paths[k], folder, models[k].name))
            found++;
        else
            paths[k][0] = '\0';
    }
    return found;
}

static void print_missing(FILE *file, char paths[NUM_MODELS][MAX_PATH], const char *folder)
{
    const char *separator = "";
    fprintf(file, "Not in %s as .off, .obj, .ply or .stl: ", folder);
    for (int k = 0; k < NUM_MODELS; k++) {
        if (paths[k][0] != '\0')
            continue;
        fprintf(file, "%s%s", separator, models[k].name);
        separator = ", ";
    }
    fprintf(file, "\n");
}

static int print_table(char paths[NUM_MODELS][MAX_PATH])
{
    int ok = 1;
    print_heading();
    for (int k = 0; k < NUM_MODELS; k++)
        if (paths[k][0] != '\0')
            ok = print_model(&models[k], paths[k]) && ok;
    printf("\n");
    return ok;
}

int main(int argc, char **argv)
{
    static char paths[NUM_MODELS][MAX_PATH];
    if (argc != 3) {
        fprintf(stderr, "usage: table1 FOLDER TORUS\n");
        return EXIT_BAD_USAGE;
    }
    int found = find_models(paths, argv[1], argv[2]);
    if (found == 0) {
        fprintf(stderr, "table1: name a folder that has models of the paper's Table 1: make table1 MESHES=DIR\n");
        print_missing(stderr, paths, argv[1]);
        return EXIT_BAD_DATA;
    }
    int ok = print_table(paths);
    if (found < NUM_MODELS - 1)      /* all but the torus */
        print_missing(stdout, paths, argv[1]);
    if (order0.low_name != NULL)
        print_claims();
    return ok ? 0 : EXIT_BAD_DATA;
}
