/* Runs committed inputs without libFuzzer: all files of fuzz/seeds/TARGET and fuzz/regressions/TARGET, each in a
 * process of its own; or, given `TARGET FILE...`, these files. All targets are linked in, and for inputs of lean the
 * mutator, which must know their decisions. Counts basic blocks where the build lets it, so that the bounds on work are
 * checked too. The last line is `N passed, N failed`. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define TARGETS(x) x(decode) x(lean) x(chunks) x(truncate) x(flip) x(roundtrip) x(triangles) x(mesh_ops) x(range_coder) x(mesh_file)

#define DECLARE(name) int fuzz_##name(const uint8_t *data, size_t size);
TARGETS(DECLARE)

static const struct target {
    const char *name;
    int (*function)(const uint8_t *data, size_t size);
} targets[] = {
#define LIST(name) { #name, fuzz_##name },
    TARGETS(LIST)
};

/* mutator.c, which need not be linked; and what libFuzzer has for it, which its check does not call. */
__attribute__((weak)) int mutator_works(const uint8_t *data, size_t size);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size)
{
    (void)data, (void)max_size;
    return size;
}

enum { NUM_TARGETS = sizeof targets / sizeof *targets, PATH_BYTES = 1000, MOST_BYTES = 1 << 20, MOST_SECONDS = 120 };

#ifdef FUZZ_COUNTS_WORK
extern uint64_t work;
uint64_t work;
void __sanitizer_cov_trace_pc(void);
__attribute__((no_sanitize("coverage"))) void __sanitizer_cov_trace_pc(void) { work++; }
#endif

static int passed, failed;

/* Reads into a block of exactly the file's size. Exits with 0 if the target comes back. */
static void run_here(const struct target *target, const char *path)
{
    FILE *file = fopen(path, "rb");
    uint8_t *all = (uint8_t *)malloc(MOST_BYTES), *data;
    size_t size = file != NULL && all != NULL ? fread(all, 1, MOST_BYTES, file) : MOST_BYTES;
    data = (uint8_t *)malloc(size);
    if (size == MOST_BYTES || (data == NULL && size > 0)) {
        fprintf(stderr, "cannot read %s\n", path);
        exit(1);
    }
    if (size > 0) memcpy(data, all, size);
    fclose(file);
    free(all);
    alarm(MOST_SECONDS);
    target->function(data, size);
    if (mutator_works != NULL && strcmp(target->name, "lean") == 0 && !mutator_works(data, size)) {
        fprintf(stderr, "%s: the mutator does not know all decisions of the decoder\n", path);
        exit(1);
    }
    free(data);
    exit(0);
}

static void run(const struct target *target, const char *path)
{
    int status = 1;
    pid_t child;
    fflush(NULL);
    child = fork();
    if (child == 0) run_here(target, path);
    if (child > 0 && waitpid(child, &status, 0) == child && status == 0) {
        passed++;
        return;
    }
    failed++;
    printf("FAIL %s %s (%s %d)\n", target->name, path, WIFSIGNALED(status) ? "signal" : "status",
           WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
}

/* All files of a folder; a folder that is not there has none. */
static int run_folder(const struct target *target, const char *kind)
{
    char folder[PATH_BYTES], path[2 * PATH_BYTES];
    struct dirent **entries;
    int n, k, files = 0;
    snprintf(folder, sizeof folder, "fuzz/%s/%s", kind, target->name);
    n = scandir(folder, &entries, NULL, alphasort);
    for (k = 0; k < n; k++) {
        if (entries[k]->d_name[0] != '.') {
            snprintf(path, sizeof path, "%s/%s", folder, entries[k]->d_name);
            run(target, path);
            files++;
        }
        free(entries[k]);
    }
    if (n >= 0) free(entries);
    return files;
}

static void run_committed(const struct target *target)
{
    int seeds = run_folder(target, "seeds"), regressions = run_folder(target, "regressions");
    printf("%-12s %4d seeds %3d regressions\n", target->name, seeds, regressions);
    if (seeds == 0) {
        printf("FAIL %s has no seeds\n", target->name);
        failed++;
    }
}

int main(int argc, char **argv)
{
    int k, j;
    for (k = 0; k < NUM_TARGETS; k++) {
        if (argc == 1) run_committed(&targets[k]);
        for (j = 2; j < argc && strcmp(argv[1], targets[k].name) == 0; j++) run(&targets[k], argv[j]);
    }
    if (mutator_works == NULL) printf("without the mutator\n");
    printf("%d passed, %d failed\n", passed, failed);
    return failed != 0 || passed == 0;
}
