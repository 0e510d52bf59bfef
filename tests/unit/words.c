/* The metadata that cqm writes: names of a mesh file there and back, and any bytes that a stream may have instead. */
#include "../../examples/cqm/words.c"
#include "test.h"

static uint32_t random_below(uint32_t n)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33) % n;
}

static int same_text(const char *a, const char *b)
{
    return a == NULL || b == NULL ? a == b : strcmp(a, b) == 0;
}

static struct words parsed;

static int parse_text(const char *text)
{
    return parse_words(&parsed, (const uint8_t *)text, strlen(text));
}

TEST(names_come_back)
{
    static uint32_t materials[4] = { 1, 2, 2, 1 }, groups[4] = { 1, 1, 1, 1 }, objects[4] = { 0, 2, 1, 2 };
    static uint8_t marks[4] = { 0, 0, 0, 1 };
    struct mesh_file mesh;
    char *text;
    memset(&mesh, 0, sizeof mesh);
    mesh.num_faces = 4;
    mesh.label[MESH_MATERIALS].of_face = materials;
    mesh.label[MESH_MATERIALS].names = (char *)"red\ndark  green\n";
    mesh.label[MESH_GROUPS].of_face = groups;
    mesh.label[MESH_GROUPS].names = (char *)"g\n";
    mesh.label[MESH_OBJECTS].of_face = objects;
    mesh.label[MESH_OBJECTS].names = (char *)"usemtl x\nfaces o\n";
    mesh.libraries = (char *)"a b.mtl\n";
    mesh.marks = marks;
    text = make_words(&mesh);
    REQUIRE(text != NULL);
    CHECK(strcmp(text, "faces o marks\nmtllib a b.mtl\nusemtl red\nusemtl dark  green\ng g\no usemtl x\no faces o\n") == 0);
    REQUIRE(parse_text(text));
    CHECK(same_text(parsed.names[MESH_MATERIALS], mesh.label[MESH_MATERIALS].names));
    CHECK(same_text(parsed.names[MESH_GROUPS], mesh.label[MESH_GROUPS].names));
    CHECK(same_text(parsed.names[MESH_OBJECTS], mesh.label[MESH_OBJECTS].names));
    CHECK(same_text(parsed.libraries, mesh.libraries));
    CHECK(parsed.channel[FACE_GROUP] == 0 && parsed.channel[FACE_OBJECT] == 1 && parsed.channel[FACE_MARKS] == 2);
    free_words(&parsed);
    free(text);
}

TEST(a_mesh_without_names_has_no_words)
{
    struct mesh_file mesh;
    char *text;
    memset(&mesh, 0, sizeof mesh);
    mesh.num_faces = 3;
    text = make_words(&mesh);
    REQUIRE(text != NULL);
    CHECK(*text == '\0');
    free(text);
}

/* Whatever is parsed can be written as lines of a mesh file. */
static void check_lines(const char *text)
{
    const char *c;
    for (c = text; c != NULL && *c != '\0'; c++) CHECK(*c != '\r');
    CHECK(text == NULL || (*text != '\0' && text[strlen(text) - 1] == '\n'));
}

TEST(any_bytes_may_be_there)
{
    static const char *const pieces[] = { "faces", " g", " o", " marks", "usemtl", "mtllib", "g", "o", " ", "\n", "\r", "x", "\xff" };
    int k, i, names = 0;
    for (k = 0; k < 20000; k++) {
        uint8_t text[200];
        size_t size = 0;
        uint32_t n = random_below(20), j;
        for (j = 0; j < n; j++) {
            const char *piece = pieces[random_below(sizeof pieces / sizeof *pieces)];
            memcpy(text + size, piece, strlen(piece));
            size += strlen(piece);
            if (random_below(9) == 0) text[size++] = 0;
        }
        REQUIRE(parse_words(&parsed, text, size));
        for (i = 0; i < MESH_NUM_LABELS; i++) {
            check_lines(parsed.names[i]);
            names += parsed.names[i] != NULL;
        }
        check_lines(parsed.libraries);
        for (i = 0; i < NUM_FACE_NUMBERS; i++) CHECK(parsed.channel[i] >= 0 && parsed.channel[i] <= 20);
        free_words(&parsed);
    }
    CHECK(names > 1000);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(names_come_back);
    RUN(a_mesh_without_names_has_no_words);
    RUN(any_bytes_may_be_there);
    return TEST_END();
}
