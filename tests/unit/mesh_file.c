/* The readers of examples/mesh_file, where a small input and a number say more than a file: numbers in text. */
#include "../../examples/mesh_file/expand.c"
#include "../../examples/mesh_file/faces.c"
#include "../../examples/mesh_file/labels.c"
#include "../../examples/mesh_file/mesh_file.c"
#include "../../examples/mesh_file/obj.c"
#include "../../examples/mesh_file/off.c"
#include "../../examples/mesh_file/ply.c"
#include "../../examples/mesh_file/polygon.c"
#include "../../examples/mesh_file/stl.c"
#include "../../examples/mesh_file/text.c"
#include "test.h"

static int parse(const char *text, double *value, double *unit) {
    struct word word = { (const uint8_t *)text, strlen(text) };
    return parse_number(word, value, unit);
}

static uint32_t random_below(uint32_t n) {
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33) % n;
}

/* Up to `digits` digits with a point somewhere and perhaps an exponent. */
static void random_number(char *text, uint32_t digits) {
    uint32_t n = 1 + random_below(digits), point = random_below(n + 1), k;
    if (random_below(2) == 0) *text++ = '-';
    for (k = 0; k < n; k++) {
        if (k == point) *text++ = '.';
        *text++ = (char)('0' + random_below(10));
    }
    *text = 0;
    if (random_below(2) == 0) sprintf(text, "e%d", (int)random_below(640) - 330);
}

TEST(numbers_are_those_of_strtod) {
    char text[120];
    double value, unit;
    int k, rounded = 0;
    for (k = 0; k < 100000; k++) {
        random_number(text, k % 2 ? 18 : 80);
        if (!parse(text, &value, &unit) || value != strtod(text, NULL)) {
            printf("  %s: %.17g, expected %.17g\n", text, value, strtod(text, NULL));
            CHECK(0);
            return;
        }
        rounded += strlen(text) > 20;
    }
    CHECK(rounded > 10000);
}

TEST(the_unit_is_what_the_last_digit_counts) {
    static const struct { const char *text; double unit; } cases[] = {
        { "7", 1 }, { "7.", 1 }, { "0.25", 0.01 }, { "-.5", 0.1 }, { "70", 1 }, { "7e3", 1000 }, { "1.50e-3", 1e-5 },
    };
    size_t k;
    for (k = 0; k < sizeof cases / sizeof *cases; k++) {
        double value, unit;
        REQUIRE(parse(cases[k].text, &value, &unit));
        CHECK(fabs(unit - cases[k].unit) < 1e-12 * cases[k].unit);
    }
}

TEST(other_words_are_no_numbers) {
    static const char *const words[] = { "", "+", "-", ".", "-.", "e1", "1e", "1e+", "1e-", "1.2.3", "1,5", "0x10", "nan",
                                         "inf", "1f", "--1", "1-", "1e1.5", "1 2", "\xb2" };
    size_t k;
    for (k = 0; k < sizeof words / sizeof *words; k++) {
        double value, unit;
        CHECK(!parse(words[k], &value, &unit));
    }
}

static double rounding_of(const char *x) {
    char text[200], error[MESH_ERROR_BYTES];
    struct mesh_file mesh;
    double rounding = -1;
    sprintf(text, "v %s 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", x);
    if (mesh_read(&mesh, (const uint8_t *)text, strlen(text), MESH_OBJ, error)) rounding = mesh.rounding;
    mesh_free(&mesh);
    return rounding;
}

TEST(a_float_holds_what_nine_of_its_digits_say) {
    char text[40];
    int k;
    for (k = 0; k < 20000; k++) {
        uint32_t bits = random_below(0x7f800000u);
        sprintf(text, "%.9g", (double)float_of_bits(bits));
        REQUIRE(rounding_of(text) == 0);
    }
    CHECK(rounding_of("3.40282347e38") == 0);
    CHECK(rounding_of("3.40282348e38") == -1);
    CHECK(rounding_of("0.1") == 0);
    CHECK(fabs(rounding_of("5411932.678") - 0.178) < 1e-6);
    CHECK(rounding_of("0.100000000000") > 1e-9);
    CHECK(rounding_of("0.125000000000") == 0);
}

int main(int argc, char **argv) {
    TEST_BEGIN(argc, argv);
    RUN(numbers_are_those_of_strtod);
    RUN(the_unit_is_what_the_last_digit_counts);
    RUN(other_words_are_no_numbers);
    RUN(a_float_holds_what_nine_of_its_digits_say);
    return TEST_END();
}
