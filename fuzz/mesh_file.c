/* The readers of examples/mesh_file on any bytes: a message, or a mesh whose numbers are in range. What was read can be
 * written in each format and read back as it was; STL welds vertices, so there the corners are compared. PLY and OBJ
 * hold attributes too. */
#define _POSIX_C_SOURCE 200809L /* open_memstream */
#include "fuzz.h"

#include "../examples/mesh_file/mesh_file.c"
#include "../examples/mesh_file/obj.c"
#include "../examples/mesh_file/off.c"
#include "../examples/mesh_file/ply.c"
#include "../examples/mesh_file/stl.c"
#include "../examples/mesh_file/text.c"
#include "../examples/mesh_file/write.c"

/* Lines that begin with one of two words, and can be printed. */
static void check_notes(const char *notes) {
    for (; notes != NULL && *notes != '\0'; notes = strchr(notes, '\n') + 1) {
        const char *c;
        REQUIRE(strncmp(notes, "dropped: ", 9) == 0 || strncmp(notes, "changed: ", 9) == 0);
        REQUIRE(strchr(notes, '\n') != NULL);
        for (c = notes; *c != '\n'; c++) REQUIRE(*c >= ' ' && *c < 127);
    }
}

static void check_mesh(const struct mesh_file *m) {
    size_t k;
    int a;
    for (k = 0; k < 3 * (size_t)m->num_vertices; k++) REQUIRE(fabs(m->positions[k]) <= (double)FLT_MAX);
    REQUIRE(m->rounding >= 0 && isfinite(m->rounding));
    for (k = 0; k < 3 * (size_t)m->num_faces; k++) REQUIRE(m->indices[k] < m->num_vertices);
    for (k = 0; m->materials != NULL && k < m->num_faces; k++) REQUIRE(m->materials[k] <= m->num_materials);
    for (a = 0; a < MESH_NUM_ATTRIBUTES; a++) {
        if (m->attribute[a] == NULL) continue;
        REQUIRE(m->components[a] == (a == MESH_TEXCOORDS ? 2 : 3) || (a == MESH_COLORS && m->components[a] == 4));
        for (k = 0; k < (size_t)m->components[a] * m->num_vertices; k++) {
            REQUIRE(isfinite(m->attribute[a][k]));
            REQUIRE(a != MESH_COLORS || (m->attribute[a][k] >= 0 && m->attribute[a][k] <= 1));
        }
    }
    check_notes(m->notes);
}

/* Normals and texture coordinates come back as they were, colors of PLY to 8 bits. */
static void require_equal_attributes(const struct mesh_file *a, const struct mesh_file *b, enum mesh_format format) {
    int i;
    size_t k;
    for (i = 0; i < MESH_NUM_ATTRIBUTES; i++) {
        size_t shared = (size_t)(a->components[i] == 4 && format == MESH_OBJ ? 3 : a->components[i]);
        if (a->num_vertices == 0) continue;
        if (format == MESH_OBJ && i != MESH_COLORS && b->attribute[i] == NULL) continue;  /* a vertex without a face */
        REQUIRE((a->attribute[i] != NULL) == (b->attribute[i] != NULL));
        for (k = 0; a->attribute[i] != NULL && k < shared * a->num_vertices; k++) {
            float x = a->attribute[i][k / shared * (size_t)a->components[i] + k % shared], y = b->attribute[i][k];
            REQUIRE(x == y || (i == MESH_COLORS && format == MESH_PLY && fabs((double)x - (double)y) < 0.0020));
        }
    }
}

/* OBJ tells materials only of faces; where no face has one, nothing. */
static void require_equal_materials(const struct mesh_file *a, const struct mesh_file *b) {
    size_t k;
    REQUIRE(a->num_materials == b->num_materials);
    for (k = 0; a->num_materials > 0 && k < a->num_faces; k++) REQUIRE(a->materials[k] == b->materials[k]);
}

/* Text has nine digits of floats, STL holds floats only. */
static void require_equal_coordinates(double x, double y, enum mesh_format format) {
    REQUIRE(x == y || (float)x == (float)y);
    REQUIRE(x == y || format == MESH_STL || x == (double)(float)x);
    REQUIRE(x == y || format != MESH_PLY);
}

static void require_equal_corners(const struct mesh_file *a, const struct mesh_file *b, enum mesh_format format) {
    size_t k, c;
    REQUIRE(a->num_faces == b->num_faces);
    for (k = 0; k < 3 * (size_t)a->num_faces; k++)
        for (c = 0; c < 3; c++)
            require_equal_coordinates(a->positions[3 * (size_t)a->indices[k] + c],
                                      b->positions[3 * (size_t)b->indices[k] + c], format);
}

static void check_same(const struct mesh_file *a, const struct mesh_file *b, enum mesh_format format) {
    size_t k;
    require_equal_corners(a, b, format);
    REQUIRE(a->num_vertices == b->num_vertices);
    REQUIRE(a->num_faces == 0 || memcmp(a->indices, b->indices, 3 * (size_t)a->num_faces * sizeof *a->indices) == 0);
    for (k = 0; k < 3 * (size_t)a->num_vertices; k++)
        require_equal_coordinates(a->positions[k], b->positions[k], format);
}

static void check_writing(const struct mesh_file *m, enum mesh_format format) {
    char *text = NULL, error[MESH_ERROR_BYTES];
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    struct mesh_file again;
    uint8_t *exact;
    REQUIRE(file != NULL);
    REQUIRE(mesh_write(m, file, format));
    REQUIRE(fclose(file) == 0);
    exact = (uint8_t *)copy_of(text, size);
    if (format == MESH_OBJ && m->num_faces == 0) {
        REQUIRE(!mesh_read(&again, exact, size, format, error));
        free(exact);
        free(text);
        return;
    }
    if (!mesh_read(&again, exact, size, format, error)) {
        fprintf(stderr, "written, but not read: %s\n", error);
        abort();
    }
    check_mesh(&again);
    if (format == MESH_STL) require_equal_corners(m, &again, format);
    else check_same(m, &again, format);
    if (format == MESH_PLY || format == MESH_OBJ) require_equal_attributes(m, &again, format);
    if (format == MESH_OBJ) require_equal_materials(m, &again);
    mesh_free(&again);
    free(exact);
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = { data, size };
    uint32_t kind = take(&in);
    char error[MESH_ERROR_BYTES];
    struct mesh_file mesh;
    uint8_t *bytes = (uint8_t *)copy_of(in.data, in.size);
    memset(error, 'x', sizeof error);
    if (mesh_read(&mesh, bytes, in.size, (enum mesh_format)(MESH_OFF + kind % 4), error)) {
        int format;
        check_mesh(&mesh);
        for (format = MESH_OFF; format <= MESH_STL; format++) check_writing(&mesh, (enum mesh_format)format);
        mesh_free(&mesh);
    } else {
        REQUIRE(mesh.num_vertices == 0 && mesh.num_faces == 0 && mesh.positions == NULL && mesh.indices == NULL);
        REQUIRE(strlen(error) > 0 && strlen(error) < sizeof error);
    }
    free(bytes);
    return 0;
}
