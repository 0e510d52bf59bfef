/* train.c - fits the priors of conquest.h, and measures what the parts of the model are worth.
 * SPDX-License-Identifier: MIT
 *
 *     train MESH ... > priors.txt
 *     train --effects MESH ... -- TEST ...
 *
 * The second trains without one table at a time and prints what the TEST meshes then cost.
 *
 * Encodes the meshes over and over with one model that is never reset and learns more and more slowly, and prints what
 * it has learned as C tables: with 12-bit positions, connectivity alone, and fast streams of 12-bit positions.
 * Deterministic: the same meshes in the same order give the same tables. Meshes that the codec refuses are named and
 * skipped. */
static int train_rate, train_step, train_settled, omit_begin, omit_end; /* the first three: 0 as usual */
#define CQ_TRAINING
#define CQI_TUNED(name, usual) (train_##name ? train_##name : (usual))
#define CQI_OMITTED(index) ((index) >= omit_begin && (index) < omit_end)
#define CONQUEST_IMPLEMENTATION
#include "cqm.h"
#include <stdlib.h>

enum { PASSES = 8, MEAN_PASSES = 3 }; /* passes; the last of them make the mean */

/* Adaptation of bits and of weights in each pass over all meshes. */
static const int rates[PASSES] = { 5, 5, 6, 7, 7, 8, 8, 8 };
static const int steps[PASSES] = { 32, 24, 16, 10, 6, 4, 3, 2 };

static cqi_model model; /* carried from mesh to mesh */
static int keeping;     /* 0 while effects are measured: each mesh begins with the same model */

static void cqi_model_init(cqi_model *m, const cq_shape *s)
{
    (void)s;
    *m = model;
}

static void cqi_model_keep(const cqi_model *m)
{
    if (keeping) model = *m;
}

/* As the decoder does it. */
static void set_product_speed(void)
{
    keeping = 0;
    train_rate = train_step = train_settled = 0;
}

static void set_training_speed(int pass)
{
    keeping = 1;
    train_rate = rates[pass];
    train_step = 4096 * steps[pass];
    train_settled = 250 << CQI_UNIT;
}

/* The mean of the models after each mesh: no mesh has the last word. */
static double bit_sum[CQI_MODELS], weight_sum[CQI_WEIGHTS];
static int num_summed;

static void clear_mean(void)
{
    memset(bit_sum, 0, sizeof bit_sum);
    memset(weight_sum, 0, sizeof weight_sum);
    num_summed = 0;
}

static void add_to_mean(void)
{
    int k;
    for (k = 0; k < CQI_MODELS; k++) bit_sum[k] += model.bit[k];
    for (k = 0; k < CQI_WEIGHTS; k++) weight_sum[k] += model.weight[k];
    num_summed++;
}

static void take_mean(void)
{
    int k;
    for (k = 0; k < CQI_MODELS; k++) model.bit[k] = (cq_bit_model)(bit_sum[k] / num_summed);
    for (k = 0; k < CQI_WEIGHTS; k++) model.weight[k] = (int32_t)(weight_sum[k] / num_summed);
}

struct sample {
    const char *path;
    struct mesh_file mesh;
};

static uint32_t random_below(uint32_t *state, uint32_t n)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) % n;
}

static void reset_model(void)
{
    int k;
    memset(&model, 0, sizeof model);
    for (k = 0; k < CQI_MODELS; k++) model.bit[k] = CQ_BIT_MODEL_INIT;
}

static void shuffle(struct sample *samples, int n, uint32_t *state)
{
    for (; n > 1; n--) {
        int k = (int)random_below(state, (uint32_t)n);
        struct sample swapped = samples[k];
        samples[k] = samples[n - 1];
        samples[n - 1] = swapped;
    }
}

/* Encodes a sample and learns; returns the bits of what the split model and the flags cost, or 0 if it was refused. */
static double train_mesh(const struct sample *sample, const struct options *options)
{
    static struct encoding e;
    if (!encode_mesh(&e, &sample->mesh, sample->path, options)) return 0;
    free_encoding(&e);
    add_to_mean();
    return (double)(e.report.base + e.report.flags + e.report.indices) / 65536;
}

/* What is trained for, each with a model of its own. */
enum kind { WITH_POSITIONS, CONNECTIVITY, FAST, NUM_KINDS };

static void set_options(struct options *options, enum kind kind)
{
    memset(options, 0, sizeof *options);
    options->connectivity = kind == CONNECTIVITY;
    options->fast = kind == FAST;
    options->goal = kind == FAST ? CQ_BALANCED : CQ_LEAST_CONNECTIVITY;
    options->bits = 12;
    options->quiet = 1;
}

/* Encodes all samples once; returns the mean bits per vertex. With positions every eighth mesh is encoded for the goal
 * `smallest` too: enough for it to gain, and too little for the other goal to lose. */
static double train_pass(const struct sample *samples, int n, const struct options *options)
{
    double sum = 0;
    int k;
    for (k = 0; k < n; k++) {
        struct options other = *options;
        other.goal = CQ_SMALLEST;
        if (!options->connectivity && k % 8 == 0) train_mesh(&samples[k], &other);
        sum += train_mesh(&samples[k], options) / samples[k].mesh.num_vertices;
    }
    return sum / n;
}

static void train(struct sample *samples, int n, enum kind kind)
{
    struct options options;
    uint32_t state = 1;
    int pass;
    reset_model();
    set_options(&options, kind);
    for (pass = 0; pass < PASSES; pass++) {
        set_training_speed(pass);
        if (pass <= PASSES - MEAN_PASSES) clear_mean();
        shuffle(samples, n, &state);
        fprintf(stderr, "pass %d of %d: %.4f bits per vertex\n", pass + 1, PASSES, train_pass(samples, n, &options));
    }
    take_mean();
}

static int rounded_weight(int weight)
{
    int unit = 1 << (CQI_UNIT - 4), x = (weight + (weight < 0 ? -unit : unit) / 2) / unit;
    return x < -127 ? -127 : x > 127 ? 127 : x;
}

static void print_number(int k, int x) { printf("%s%d,", k % 22 ? " " : "\n    ", x); }

/* Only fast streams teach the models that only they have. */
static void print_bits(const cqi_model *with_positions, const cqi_model *fast)
{
    int k;
    printf("static const uint8_t cqi_prior_bit[CQI_PRIORS] = {");
    for (k = 0; k < CQI_PRIORS; k++) print_number(k, (k < CQI_FAST ? with_positions : fast)->bit[k] >> 8);
    printf("\n};\n");
}

static void print_weights(const char *name, const char *size, const cqi_model *m, int count)
{
    int k;
    printf("static const int8_t %s[%s] = {", name, size);
    for (k = 0; k < count; k++) print_number(k, rounded_weight(m->weight[k]));
    printf("\n};\n");
}

/* Loads what can be encoded; returns how many. */
static int load_samples(struct sample *samples, char **paths, int n)
{
    struct options options;
    int k, loaded = 0;
    memset(&options, 0, sizeof options);
    options.connectivity = options.quiet = 1;
    set_training_speed(0);
    reset_model();
    for (k = 0; k < n; k++) {
        static struct encoding e;
        samples[loaded].path = paths[k];
        if (!load_mesh(&samples[loaded].mesh, paths[k], mesh_format_of_path(paths[k]))) continue;
        if (!encode_mesh(&e, &samples[loaded].mesh, paths[k], &options)) continue;
        free_encoding(&e);
        loaded++;
    }
    return loaded;
}

/* -- Effects -- */

static void round_model(void)
{
    int k;
    for (k = 0; k < CQI_MODELS; k++) model.bit[k] = (cq_bit_model)((model.bit[k] & 0xff00) + 128);
    for (k = 0; k < CQI_WEIGHTS; k++) model.weight[k] = rounded_weight(model.weight[k]) * (1 << (CQI_UNIT - 4));
}

/* Mean bits per vertex for the connectivity of the test meshes, with the model as it is. */
static double measure(const struct sample *tests, int n, enum kind kind)
{
    struct options options;
    double sum = 0;
    int k;
    set_options(&options, kind);
    set_product_speed();
    for (k = 0; k < n; k++) {
        static struct encoding e;
        if (!encode_mesh(&e, &tests[k].mesh, tests[k].path, &options)) continue;
        sum += (double)(e.report.header + e.report.base + e.report.flags + e.report.indices) / 65536 /
               tests[k].mesh.num_vertices;
        free_encoding(&e);
    }
    return sum / n;
}

struct part {
    const char *name;
    int begin, end;
};

static const struct part parts[] = {
    { "nothing", 0, 0 },
    { "valence of B, by distance from the finest level", CQI_SIZE_B, CQI_SIZE_A },
    { "valence of A, by distance from the finest level", CQI_SIZE_A, CQI_END_STATE },
    { "the encoder's rule: would it have chosen this B?", CQI_RULE, CQI_BARE_WEIGHTS },
    { "valences and states of the common neighbours", CQI_END_STATE, CQI_END_VALENCE },
    { "their valences, by distance from the finest level", CQI_END_VALENCE, CQI_END_EDGE },
    { "lengths of their spokes", CQI_END_EDGE, CQI_FAST_WEIGHTS },
    { "lengths of both spokes together", CQI_EDGES, CQI_OUTER },
    { "how far B - A goes to the vertices beside them, on A's side", CQI_OUTER, CQI_BETWEEN },
    { "angle between the common neighbours", CQI_BETWEEN, CQI_WEIGHTS },
    { "all features", 0, CQI_WEIGHTS }
};

static void print_costs(const char *name, const double *cost)
{
    printf("%-60s %12.3f %14.3f %6.3f\n", name, cost[CONNECTIVITY], cost[WITH_POSITIONS], cost[FAST]);
    fflush(stdout);
}

static void print_effects(struct sample *samples, int n, const struct sample *tests, int num_tests)
{
    double cost[NUM_KINDS];
    size_t k;
    int kind;
    printf("%-60s %12s %14s %6s\n", "without", "connectivity", "with positions", "fast");
    for (k = 0; k < sizeof parts / sizeof *parts; k++) {
        omit_begin = parts[k].begin;
        omit_end = parts[k].end;
        for (kind = 0; kind < NUM_KINDS; kind++) {
            train(samples, n, (enum kind)kind);
            round_model();
            cost[kind] = measure(tests, num_tests, (enum kind)kind);
        }
        print_costs(parts[k].name, cost);
    }
    omit_begin = omit_end = 0;
    reset_model();
    for (kind = 0; kind < NUM_KINDS; kind++) cost[kind] = measure(tests, num_tests, (enum kind)kind);
    print_costs("trained priors", cost);
}

static int run_effects(struct sample *samples, int argc, char **argv)
{
    int split = 2, n, num_tests;
    while (split < argc && strcmp(argv[split], "--") != 0) split++;
    n = load_samples(samples, argv + 2, split - 2);
    num_tests = split < argc ? load_samples(samples + n, argv + split + 1, argc - split - 1) : 0;
    if (n == 0 || num_tests == 0) {
        fprintf(stderr, "train: --effects wants meshes to learn from, --, and meshes to measure\n");
        return 1;
    }
    print_effects(samples, n, samples + n, num_tests);
    return 0;
}

static int run_training(struct sample *samples, int argc, char **argv)
{
    static cqi_model models[NUM_KINDS];
    int kind, n = load_samples(samples, argv + 1, argc - 1);
    if (n == 0) {
        fprintf(stderr, "train: no mesh to learn from\n");
        return 1;
    }
    for (kind = 0; kind < NUM_KINDS; kind++) {
        train(samples, n, (enum kind)kind);
        models[kind] = model;
    }
    print_bits(&models[WITH_POSITIONS], &models[FAST]);
    print_weights("cqi_prior_bare", "CQI_BARE_WEIGHTS", &models[CONNECTIVITY], CQI_BARE_WEIGHTS);
    print_weights("cqi_prior_located", "CQI_WEIGHTS", &models[WITH_POSITIONS], CQI_WEIGHTS);
    print_weights("cqi_prior_fast", "CQI_FAST_WEIGHTS", &models[FAST], CQI_FAST_WEIGHTS);
    return 0;
}

int main(int argc, char **argv)
{
    struct sample *samples = (struct sample *)calloc((size_t)argc, sizeof *samples);
    if (!samples) return 1;
    if (argc > 1 && strcmp(argv[1], "--effects") == 0) return run_effects(samples, argc, argv);
    return run_training(samples, argc, argv);
}
