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

static int parse(const char *text, double *value, double *unit)
{
    struct word word = { (const uint8_t *)text, strlen(text) };
    return parse_number(word, value, unit);
}

static uint32_t random_below(uint32_t n)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33) % n;
}

/* Up to `digits` digits with a point somewhere and perhaps an exponent. */
static void random_number(char *text, uint32_t digits)
{
    uint32_t n = 1 + random_below(digits), point = random_below(n + 1), k;
    if (random_below(2) == 0) *text++ = '-';
    for (k = 0; k < n; k++) {
        if (k == point) *text++ = '.';
        *text++ = (char)('0' + random_below(10));
    }
    *text = 0;
    if (random_below(2) == 0) sprintf(text, "e%d", (int)random_below(640) - 330);
}

TEST(numbers_are_those_of_strtod)
{
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

TEST(the_unit_is_what_the_last_digit_counts)
{
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

TEST(other_words_are_no_numbers)
{
    static const char *const words[] = { "", "+", "-", ".", "-.", "e1", "1e", "1e+", "1e-", "1.2.3", "1,5", "0x10", "nan",
                                         "inf", "1f", "--1", "1-", "1e1.5", "1 2", "\xb2" };
    size_t k;
    for (k = 0; k < sizeof words / sizeof *words; k++) {
        double value, unit;
        CHECK(!parse(words[k], &value, &unit));
    }
}

static double rounding_of(const char *x)
{
    char text[200], error[MESH_ERROR_BYTES];
    struct mesh_file mesh;
    double rounding = -1;
    sprintf(text, "v %s 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", x);
    if (mesh_read(&mesh, (const uint8_t *)text, strlen(text), MESH_OBJ, error)) rounding = mesh.rounding;
    mesh_free(&mesh);
    return rounding;
}

TEST(a_float_holds_what_nine_of_its_digits_say)
{
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

/* -- Vertices that have all that their corners have -- */

static uint32_t random_item(uint32_t count)
{
    return random_below(5) == 0 ? MESH_NONE : random_below(count);
}

static int random_attribute(struct mesh_file *mesh, int attribute, int components)
{
    struct mesh_values *a = &mesh->attribute[attribute];
    size_t k;
    a->components = components;
    a->count = 1 + random_below(6);
    a->values = malloc((size_t)components * a->count * sizeof *a->values);
    a->corner = malloc(3 * (size_t)mesh->num_faces * sizeof *a->corner);
    if (a->values == NULL || a->corner == NULL) return 0;
    for (k = 0; k < (size_t)components * a->count; k++) a->values[k] = (float)random_below(2) * (random_below(2) ? 1.0f : -1.0f);
    for (k = 0; k < 3 * (size_t)mesh->num_faces; k++) a->corner[k] = random_item(a->count);
    return 1;
}

/* Vertices that faces use, and others, whose colors belong to them. */
static int random_mesh(struct mesh_file *mesh)
{
    size_t k;
    memset(mesh, 0, sizeof *mesh);
    mesh->num_vertices = 1 + random_below(8);
    mesh->num_faces = 1 + random_below(12);
    mesh->positions = malloc(3 * (size_t)mesh->num_vertices * sizeof *mesh->positions);
    mesh->indices = malloc(3 * (size_t)mesh->num_faces * sizeof *mesh->indices);
    if (mesh->positions == NULL || mesh->indices == NULL) return 0;
    for (k = 0; k < 3 * (size_t)mesh->num_vertices; k++) mesh->positions[k] = (double)k;
    for (k = 0; k < 3 * (size_t)mesh->num_faces; k++) mesh->indices[k] = random_below(mesh->num_vertices);
    mesh->attribute[MESH_COLORS].components = 3;
    mesh->attribute[MESH_COLORS].count = mesh->num_vertices;
    mesh->attribute[MESH_COLORS].values = calloc(mesh->num_vertices, 3 * sizeof(float));
    if (mesh->attribute[MESH_COLORS].values == NULL) return 0;
    for (k = 0; k < mesh->num_vertices; k++) mesh->attribute[MESH_COLORS].values[3 * k] = (float)k;
    return random_attribute(mesh, MESH_NORMALS, 3) && random_attribute(mesh, MESH_TEXCOORDS, 2);
}

/* What corner c has of an attribute; what is missing is 0, of normals 0 0 1. */
static void value_of(const struct mesh_file *mesh, int attribute, size_t c, float value[3])
{
    const struct mesh_values *a = &mesh->attribute[attribute];
    uint32_t item = a->corner != NULL ? a->corner[c] : mesh->indices[c];
    int i;
    for (i = 0; i < 3; i++) value[i] = attribute == MESH_NORMALS && i == 2 ? 1.0f : 0.0f;
    for (i = 0; i < a->components && item != MESH_NONE; i++) value[i] = a->values[(size_t)a->components * item + (size_t)i];
}

enum { MAX_TEST_CORNERS = 36 };

/* Corners that are the first with their vertex and values, but for one of each vertex. What is missing is no value. */
static uint32_t most_copies(const uint32_t *vertex, float (*value)[MESH_NUM_ATTRIBUTES][3], const uint8_t *missing,
                            size_t corners)
{
    uint32_t kinds = 0, vertices = 0;
    size_t c, d;
    for (c = 0; c < corners; c++) {
        int is_new = 1, is_new_vertex = 1;
        for (d = 0; d < c; d++) {
            is_new_vertex = is_new_vertex && vertex[c] != vertex[d];
            is_new = is_new && (vertex[c] != vertex[d] || missing[c] != missing[d]
                                || memcmp(value[c], value[d], sizeof *value) != 0);
        }
        kinds += (uint32_t)is_new;
        vertices += (uint32_t)is_new_vertex;
    }
    return kinds - vertices;
}

TEST(expanding_keeps_what_corners_have_and_makes_no_vertex_too_many)
{
    static float before[MAX_TEST_CORNERS][MESH_NUM_ATTRIBUTES][3];
    static uint32_t vertex[MAX_TEST_CORNERS];
    static uint8_t missing[MAX_TEST_CORNERS];
    int k, a, i;
    uint32_t copies = 0;
    for (k = 0; k < 3000; k++) {
        struct mesh_file mesh;
        size_t c, corners;
        uint32_t old;
        REQUIRE(random_mesh(&mesh));
        corners = 3 * (size_t)mesh.num_faces;
        old = mesh.num_vertices;
        for (c = 0; c < corners; c++) {
            vertex[c] = mesh.indices[c];
            missing[c] = 0;
            for (a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
                value_of(&mesh, a, c, before[c][a]);
                for (i = 0; i < 3; i++) before[c][a][i] += 0.0f;          /* -0 is 0 */
                if (a != MESH_COLORS && mesh.attribute[a].corner[c] == MESH_NONE) missing[c] |= (uint8_t)(1 << a);
            }
        }
        REQUIRE(mesh_expand(&mesh, 7));
        copies += mesh.num_vertices - old;
        for (c = 0; c < corners; c++) {
            REQUIRE(mesh.indices[c] < mesh.num_vertices && mesh.number[mesh.indices[c]] == vertex[c]);
            REQUIRE(mesh.positions[3 * (size_t)mesh.indices[c]] == 3.0 * vertex[c]);
            for (a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
                float now[3];
                REQUIRE(mesh.attribute[a].corner == NULL && mesh.attribute[a].count == mesh.num_vertices);
                value_of(&mesh, a, c, now);
                for (i = 0; i < 3; i++) REQUIRE(now[i] == before[c][a][i]);
            }
        }
        for (c = 0; c < old; c++) REQUIRE(mesh.number[c] == c);
        REQUIRE_EQ(mesh.num_vertices, old + most_copies(vertex, before, missing, corners));
        mesh_free(&mesh);
    }
    CHECK(copies > 10000);
}

TEST(without_seams_vertices_stay_what_they_are)
{
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 7 7 7\nvt 0 0\nvt 1 0\nvt 0 0\nf 1/1 2/2 3/3\nf 3/1 2/2 1/3\n";
    char error[MESH_ERROR_BYTES];
    struct mesh_file mesh;
    REQUIRE(mesh_read(&mesh, (const uint8_t *)text, sizeof text - 1, MESH_OBJ, error));
    CHECK_EQ(mesh.attribute[MESH_TEXCOORDS].count, 3);
    REQUIRE(mesh_expand(&mesh, 7));
    CHECK_EQ(mesh.num_vertices, 4);
    CHECK(mesh.indices[0] == 0 && mesh.indices[3] == 2 && mesh.indices[5] == 0);
    CHECK(mesh.attribute[MESH_TEXCOORDS].values[2] == 1);
    mesh_free(&mesh);
}

TEST(attributes_that_are_not_wanted_make_no_seams)
{
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nf 1/1 2/2 3/1\nf 3/2 2/2 1/2\n";
    char error[MESH_ERROR_BYTES];
    struct mesh_file mesh;
    REQUIRE(mesh_read(&mesh, (const uint8_t *)text, sizeof text - 1, MESH_OBJ, error));
    REQUIRE(mesh_expand(&mesh, 1 << MESH_NORMALS));
    CHECK_EQ(mesh.num_vertices, 3);
    CHECK(mesh.attribute[MESH_TEXCOORDS].values == NULL);
    mesh_free(&mesh);
}

TEST(the_first_equal_row_is_found)
{
    static uint16_t rows[500][2];
    int k;
    for (k = 0; k < 200; k++) {
        uint32_t *first, count = random_below(500), range = 1 + random_below(40), i, j;
        for (i = 0; i < count; i++) {
            rows[i][0] = (uint16_t)random_below(range);
            rows[i][1] = (uint16_t)random_below(range);
        }
        first = mesh_first_equal(rows, count, sizeof *rows);
        REQUIRE(first != NULL);
        for (i = 0; i < count; i++) {
            for (j = 0; memcmp(rows[j], rows[i], sizeof *rows) != 0; j++) {}
            REQUIRE(first[i] == j);
        }
        free(first);
    }
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(numbers_are_those_of_strtod);
    RUN(the_unit_is_what_the_last_digit_counts);
    RUN(other_words_are_no_numbers);
    RUN(a_float_holds_what_nine_of_its_digits_say);
    RUN(expanding_keeps_what_corners_have_and_makes_no_vertex_too_many);
    RUN(without_seams_vertices_stay_what_they_are);
    RUN(attributes_that_are_not_wanted_make_no_seams);
    RUN(the_first_equal_row_is_found);
    return TEST_END();
}
