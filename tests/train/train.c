/* train.c - fits the priors of conquest.h, and measures what the parts of the model are worth.
 * SPDX-License-Identifier: MIT
 *
 *     train MESH ... > priors.txt
 *     train --effects MESH ... -- TEST ...
 *
 * The second trains without one part at a time and prints what the TEST meshes then cost.
 *
 * Encodes the meshes over and over with one model that is never reset and learns more and more slowly, and prints what
 * it has learned as C tables: connectivity alone, and with 12-bit positions. Deterministic: the same meshes in the same
 * order give the same tables. Meshes that the codec refuses are named and skipped. */
static int train_rate, train_learn, train_linear; /* 0: as usual */
#define CQ_TRAINING
#define CQI_TUNED(name, usual) (train_##name ? train_##name : (usual))
#define CONQUEST_IMPLEMENTATION
#include "cqm.h"
#include <stdlib.h>

enum { PASSES = 8, MEAN_PASSES = 3 }; /* passes; the last of them make the mean */

/* Adaptation in each pass over all meshes: of bits (higher is slower), of weights by 2^-learn of the error, of linear
 * predictions in 1/8192. */
static const int rates[PASSES] = { 5, 5, 6, 7, 7, 8, 8, 8 };
static const int learns[PASSES] = { 6, 7, 7, 8, 8, 9, 9, 10 };
static const int linears[PASSES] = { 100, 50, 50, 25, 25, 12, 12, 6 };

/* -- The model, carried from mesh to mesh -- */

enum { LINEARS = 2 * CQI_FAN_CLASSES * CQI_FEATURES };

static cqi_model model;
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

/* Nothing is known, and every question is asked. */
static void reset_model(void)
{
    int k;
    memset(&model, 0, sizeof model);
    for (k = 0; k < CQI_MODELS; k++) model.bit[k] = CQ_BIT_MODEL_INIT;
    for (k = 0; k < CQI_QUESTIONS; k++) model.yes[k] = 20000;
    model.worth_rivals = model.worth_flat = model.worth_same[0] = model.worth_same[1] = 1 << 20;
}

/* As the decoder does it. */
static void set_product_speed(void)
{
    keeping = 0;
    train_rate = train_learn = train_linear = 0;
}

static void set_training_speed(int pass)
{
    keeping = 1;
    train_rate = rates[pass];
    train_learn = learns[pass];
    train_linear = linears[pass];
}

/* -- The mean of the models after each mesh: no mesh has the last word -- */

static struct sums {
    double bit[CQI_MODELS], weight[CQI_WEIGHTS], linear[LINEARS], yes[CQI_QUESTIONS], gain[CQI_QUESTIONS];
    int count;
} sums;

static void add_to_mean(void)
{
    int k;
    for (k = 0; k < CQI_MODELS; k++) sums.bit[k] += model.bit[k];
    for (k = 0; k < CQI_WEIGHTS; k++) sums.weight[k] += model.weight[k];
    for (k = 0; k < LINEARS; k++) sums.linear[k] += model.linear[k];
    for (k = 0; k < CQI_QUESTIONS; k++) sums.yes[k] += model.yes[k];
    for (k = 0; k < CQI_QUESTIONS; k++) sums.gain[k] += model.gain[k];
    sums.count++;
}

static void take_mean(void)
{
    int k;
    for (k = 0; k < CQI_MODELS; k++) model.bit[k] = (cq_bit_model)(sums.bit[k] / sums.count);
    for (k = 0; k < CQI_WEIGHTS; k++) model.weight[k] = (int16_t)(sums.weight[k] / sums.count);
    for (k = 0; k < LINEARS; k++) model.linear[k] = (int16_t)(sums.linear[k] / sums.count);
    for (k = 0; k < CQI_QUESTIONS; k++) model.yes[k] = (cq_bit_model)(sums.yes[k] / sums.count);
    for (k = 0; k < CQI_QUESTIONS; k++) model.gain[k] = (int16_t)(sums.gain[k] / sums.count);
}

/* -- Training -- */

struct sample {
    const char *path;
    struct mesh_file mesh;
};

static uint32_t random_below(uint32_t *state, uint32_t n)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) % n;
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

/* What is trained for, each with a model of its own. */
enum kind { CONNECTIVITY, WITH_POSITIONS, NUM_KINDS };

static struct options options_of(enum kind kind, cq_goal goal, int conquest_only)
{
    struct options options;
    memset(&options, 0, sizeof options);
    options.connectivity = kind == CONNECTIVITY;
    options.goal = goal;
    options.bits = 12;
    options.quiet = 1;
    options.conquest_only = conquest_only;
    return options;
}

/* Encodes a sample and learns; returns its bits per vertex, or 0 if it was refused. */
static double train_mesh(struct sample *sample, enum kind kind, cq_goal goal, int conquest_only)
{
    static struct encoding e;
    const struct options options = options_of(kind, goal, conquest_only);
    if (!encode_mesh(&e, &sample->mesh, sample->path, &options)) return 0;
    free_encoding(&e);
    add_to_mean();
    return 8 * (double)e.size / sample->mesh.num_vertices;
}

/* Encodes all samples once; returns the mean bits per vertex. The priors are also for the goal of the least
 * connectivity, with positions, and for streams without regular levels: every third mesh is encoded for that goal, too,
 * and the others without these levels. */
static double train_pass(struct sample *samples, int n, enum kind kind)
{
    double sum = 0;
    int k;
    for (k = 0; k < n; k++) {
        if (kind == WITH_POSITIONS && k % 3 == 0) train_mesh(&samples[k], kind, CQ_LEAST_CONNECTIVITY, 0);
        if (k % 3 != 0) train_mesh(&samples[k], kind, CQ_BALANCED, 1);
        sum += train_mesh(&samples[k], kind, CQ_BALANCED, 0);
    }
    return sum / n;
}

static void train(struct sample *samples, int n, enum kind kind)
{
    uint32_t state = 1;
    int pass;
    reset_model();
    for (pass = 0; pass < PASSES; pass++) {
        set_training_speed(pass);
        if (pass <= PASSES - MEAN_PASSES) memset(&sums, 0, sizeof sums);
        shuffle(samples, n, &state);
        fprintf(stderr, "pass %d of %d: %.4f bits per vertex\n", pass + 1, PASSES, train_pass(samples, n, kind));
    }
    take_mean();
}

/* -- The tables: as bytes -- */

enum { WEIGHT_UNIT = CQI_NAT / 16, LINEAR_UNIT = 128, GAIN_UNIT = 16 };

static int in_units(int x, int unit)
{
    x = (x + (x < 0 ? -unit : unit) / 2) / unit;
    return x < -127 ? -127 : x > 127 ? 127 : x;
}

static void print_number(int k, int x) { printf("%s%d,", k % 22 ? " " : "\n    ", x); }

static void print_bits(const char *name, const char *size, const cq_bit_model *bits, int count)
{
    int k;
    printf("static const uint8_t %s[%s] = {", name, size);
    for (k = 0; k < count; k++) print_number(k, bits[k] >> 8);
    printf("\n};\n");
}

static void print_weights(const char *name, const char *size, const int16_t *weights, int count, int unit)
{
    int k;
    printf("static const int8_t %s[%s] = {", name, size);
    for (k = 0; k < count; k++) print_number(k, in_units(weights[k], unit));
    printf("\n};\n");
}

static void print_linears(const char *name, const char *size, const int16_t *weights, int count, int unit)
{
    int k;
    printf("static const int8_t %s[%s] = {", name, size);
    for (k = 0; k < count; k++) print_number(k, in_units(weights[k], unit));
    printf("\n};\n");
}

static void print_tables(const cqi_model *bare, const cqi_model *located)
{
    print_bits("cqi_prior_bit", "CQI_OF_CONQUEST", located->bit, CQI_OF_CONQUEST);
    printf("#ifndef CQ_NO_REGULAR\n");
    print_bits("cqi_prior_regular", "CQI_PRIORS - CQI_OF_CONQUEST", located->bit + CQI_OF_CONQUEST,
               CQI_PRIORS - CQI_OF_CONQUEST);
    printf("#endif\n");
    print_weights("cqi_prior_bare", "CQI_WEIGHTS", bare->weight, CQI_WEIGHTS, WEIGHT_UNIT);
    print_weights("cqi_prior_located", "CQI_WEIGHTS", located->weight, CQI_WEIGHTS, WEIGHT_UNIT);
    print_bits("cqi_prior_yes", "CQI_QUESTIONS", located->yes, CQI_QUESTIONS);
    print_weights("cqi_prior_gain", "CQI_QUESTIONS", located->gain, CQI_QUESTIONS, GAIN_UNIT);
    print_linears("cqi_prior_linear", "2 * CQI_FAN_CLASSES * CQI_FEATURES", located->linear, LINEARS, LINEAR_UNIT);
}

/* What the decoder has of the model that was learned. */
static void round_model(void)
{
    int k;
    for (k = 0; k < CQI_MODELS; k++) model.bit[k] = (cq_bit_model)((model.bit[k] & 0xff00) + 128);
    for (k = 0; k < CQI_WEIGHTS; k++) model.weight[k] = (int16_t)(in_units(model.weight[k], WEIGHT_UNIT) * WEIGHT_UNIT);
    for (k = 0; k < LINEARS; k++) model.linear[k] = (int16_t)(in_units(model.linear[k], LINEAR_UNIT) * LINEAR_UNIT);
    for (k = 0; k < CQI_QUESTIONS; k++) model.yes[k] = (cq_bit_model)((model.yes[k] & 0xff00) + 128);
    for (k = 0; k < CQI_QUESTIONS; k++) model.gain[k] = (int16_t)(in_units(model.gain[k], GAIN_UNIT) * GAIN_UNIT);
}

/* -- Effects -- */

/* Parts of the model, as ranges of weights of the split model, of questions, and of features of the linear prediction. */
enum table { NO_TABLE, WEIGHT, QUESTION, FEATURE };

struct part {
    const char *name;
    enum table table;
    int begin, end;
};

static const struct part parts[] = {
    { "nothing", NO_TABLE, 0, 0 },
    { "angles opposite to the common neighbours' spokes", WEIGHT, CQI_END, CQI_END + CQI_ANGLES },
    { "their valences and states", WEIGHT, CQI_END + CQI_ANGLES, CQI_BETWEEN },
    { "angles opposite to the spokes that go to B", WEIGHT, CQI_BETWEEN, CQI_BETWEEN + CQI_ANGLES },
    { "lengths of these", WEIGHT, CQI_BETWEEN + CQI_ANGLES, CQI_STEPS },
    { "valences of A and B", WEIGHT, CQI_STEPS, CQI_GAP },
    { "gaps between scores", WEIGHT, CQI_GAP, CQI_RULE },
    { "the encoder's rule: would it have chosen this B?", WEIGHT, CQI_RULE, CQI_WEIGHTS },
    { "all of these", WEIGHT, 0, CQI_WEIGHTS },
    { "predictions that compete", QUESTION, CQI_HIT, CQI_SAME },
    { "coordinates equal to the commonest of the ring", QUESTION, CQI_SAME, CQI_FLAT },
    { "planes that compete for the height", QUESTION, CQI_FLAT, CQI_QUESTIONS },
    { "linear prediction: what is beyond the ring's edges", FEATURE, 0, 1 },
    { "linear prediction: A", FEATURE, 1, 2 },
    { "linear prediction: the common neighbours", FEATURE, 2, 3 },
    { "linear prediction: all but the mean", FEATURE, 0, CQI_FEATURES }
};

static const struct part *omitted = &parts[0];

/* After each split and before each mesh: weights are 0, and nothing is asked whose gain is below that. */
static void cqi_model_omit(cqi_model *m)
{
    int k, j;
    for (k = omitted->begin; k < omitted->end; k++) {
        if (omitted->table == WEIGHT) m->weight[k] = 0;
        if (omitted->table == QUESTION) m->gain[k] = INT16_MIN / 2;
        for (j = k; omitted->table == FEATURE && j < LINEARS; j += CQI_FEATURES) m->linear[j] = 0;
    }
}

/* Mean bits per vertex of the test meshes without regular levels, with the model as it is: of connectivity, or of the
 * whole. */
static double measure(struct sample *tests, int n, enum kind kind, cq_goal goal, int whole)
{
    const struct options options = options_of(kind, goal, 1);
    double sum = 0;
    int k;
    set_product_speed();
    for (k = 0; k < n; k++) {
        static struct encoding e;
        const cq_report *r = &e.report;
        if (!encode_mesh(&e, &tests[k].mesh, tests[k].path, &options)) continue;
        sum += (double)(r->header + r->base + r->flags + r->indices + (whole ? r->positions : 0)) / 65536 /
               tests[k].mesh.num_vertices;
        free_encoding(&e);
    }
    return sum / n;
}

static void print_effect(const char *name, struct sample *samples, int n, struct sample *tests, int num_tests)
{
    double alone, located, whole;
    if (n) train(samples, n, CONNECTIVITY);
    cqi_model_omit(&model);
    round_model();
    alone = measure(tests, num_tests, CONNECTIVITY, CQ_BALANCED, 0);
    if (n) train(samples, n, WITH_POSITIONS);
    cqi_model_omit(&model);
    round_model();
    located = measure(tests, num_tests, WITH_POSITIONS, CQ_LEAST_CONNECTIVITY, 0);
    whole = measure(tests, num_tests, WITH_POSITIONS, CQ_BALANCED, 1);
    printf("%-52s %12.3f %14.3f %10.3f\n", name, alone, located, whole);
    fflush(stdout);
}

static void print_effects(struct sample *samples, int n, struct sample *tests, int num_tests)
{
    size_t k;
    printf("%-52s %27s %10s\n%-52s %12s %14s %10s\n", "", "connectivity", "all,", "without", "alone", "with positions",
           "balanced");
    for (k = 0; k < sizeof parts / sizeof *parts; k++) {
        omitted = &parts[k];
        print_effect(parts[k].name, samples, n, tests, num_tests);
    }
    omitted = &parts[0];
    reset_model();
    print_effect("trained priors", samples, 0, tests, num_tests);
}

/* -- Command -- */

/* Loads what can be encoded; returns how many. */
static int load_samples(struct sample *samples, char **paths, int n)
{
    const struct options options = options_of(CONNECTIVITY, CQ_BALANCED, 1);
    int k, loaded = 0;
    set_product_speed();
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
    static cqi_model bare;
    int n = load_samples(samples, argv + 1, argc - 1);
    if (n == 0) {
        fprintf(stderr, "train: no mesh to learn from\n");
        return 1;
    }
    train(samples, n, CONNECTIVITY);
    bare = model;
    train(samples, n, WITH_POSITIONS);
    print_tables(&bare, &model);
    return 0;
}

int main(int argc, char **argv)
{
    struct sample *samples = (struct sample *)calloc((size_t)argc, sizeof *samples);
    if (!samples) return 1;
    if (argc > 1 && strcmp(argv[1], "--effects") == 0) return run_effects(samples, argc, argv);
    return run_training(samples, argc, argv);
}
