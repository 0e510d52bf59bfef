/* A unit test program in C99 with nothing but libc, so that it also runs on emulated targets.
 *
 *     TEST(a_tetrahedron_has_no_edge_to_collapse) { CHECK(...); CHECK_EQ(a, b); REQUIRE(...); }
 *     int main(int argc, char **argv) { TEST_BEGIN(argc, argv); RUN(a_tetrahedron_...); return TEST_END(); }
 *
 * The name of a test is a sentence. CHECK notes a failure and goes on, REQUIRE leaves the test. The last line of the
 * output is `N passed, N failed`; the exit status is 0 only if something ran and nothing failed. With an argument only
 * the tests whose name contains it run: `build/tests/unit/mesh bow_tie`. With TEST_STOPS the first that fails is the
 * last. */
#ifndef CQ_TESTS_TEST_H
#define CQ_TESTS_TEST_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TEST_MAX_LINES = 8 };   /* failures printed per test */

static struct test_state {
    const char *filter;
    int passed, failed;
    int failures;              /* of the test that is running */
} test_state;

static inline void test_fail(const char *file, int line, const char *what)
{
    if (test_state.failures++ < TEST_MAX_LINES) printf("  %s:%d: not true: %s\n", file, line, what);
}

static inline int test_equal(const char *file, int line, const char *a, const char *b, int64_t x, int64_t y)
{
    if (x == y) return 1;
    if (test_state.failures++ < TEST_MAX_LINES)
        printf("  %s:%d: %s is %lld, expected %s = %lld\n", file, line, a, (long long)x, b, (long long)y);
    return 0;
}

static inline void test_run(void (*test)(void), const char *name)
{
    char sentence[200];
    size_t i;
    for (i = 0; name[i] != 0 && i + 1 < sizeof sentence; ++i) sentence[i] = name[i] == '_' ? ' ' : name[i];
    sentence[i] = 0;
    if (test_state.filter != NULL && strstr(name, test_state.filter) == NULL) return;
    test_state.failures = 0;
    test();
    if (test_state.failures == 0) {
        test_state.passed++;
        printf("ok    %s\n", sentence);
    } else {
        test_state.failed++;
        printf("FAIL  %s (%d)\n", sentence, test_state.failures);
    }
    fflush(stdout);
#ifdef TEST_STOPS
    if (test_state.failures > 0) exit(1);
#endif
}

static inline void test_begin(int argc, char **argv)
{
    test_state.filter = argc > 1 ? argv[1] : NULL;
}

static inline int test_end(void)
{
    printf("%d passed, %d failed\n", test_state.passed, test_state.failed);
    return test_state.failed != 0 || test_state.passed == 0;
}

#define TEST(name) static void name(void)
#define RUN(name) test_run(name, #name)
#define TEST_BEGIN(argc, argv) test_begin(argc, argv)
#define TEST_END() test_end()
#define CHECK(c) do { if (!(c)) test_fail(__FILE__, __LINE__, #c); } while (0)
#define CHECK_EQ(a, b) ((void)test_equal(__FILE__, __LINE__, #a, #b, (int64_t)(a), (int64_t)(b)))
#define REQUIRE(c) do { if (!(c)) { test_fail(__FILE__, __LINE__, #c); return; } } while (0)
#define REQUIRE_EQ(a, b) \
    do { if (!test_equal(__FILE__, __LINE__, #a, #b, (int64_t)(a), (int64_t)(b))) return; } while (0)

#endif
