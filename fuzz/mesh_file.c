/* The readers of examples/mesh_file on any bytes: a message, or a mesh whose numbers are in range. What was read can be
 * written in each format and read back: OFF gives the same vertices, STL, which welds them, the same corners; OBJ and PLY
 * give the same attributes of corners, too, OBJ the same names. */
#define _POSIX_C_SOURCE 200809L /* open_memstream */
#include "fuzz.h"

#include "../examples/mesh_file/expand.c"
#include "../examples/mesh_file/faces.c"
#include "../examples/mesh_file/labels.c"
#include "../examples/mesh_file/mesh_file.c"
#include "../examples/mesh_file/obj.c"
#include "../examples/mesh_file/off.c"
#include "../examples/mesh_file/ply.c"
#include "../examples/mesh_file/polygon.c"
#include "../examples/mesh_file/stl.c"
#include "../examples/mesh_file/text.c"
#include "../examples/mesh_file/write.c"

/* Lines that begin with one of two words, and can be printed. */
static void check_notes(const char *notes)
{
    for (; notes != NULL && *notes != '\0'; notes = strchr(notes, '\n') + 1) {
        const char *c;
        REQUIRE(strncmp(notes, "dropped: ", 9) == 0 || strncmp(notes, "changed: ", 9) == 0);
        REQUIRE(strchr(notes, '\n') != NULL);
        for (c = notes; *c != '\n'; c++) REQUIRE(*c >= ' ' && *c < 127);
    }
}

/* As many names as there are labels; each is a line that is not empty. */
static void check_labels(const struct mesh_labels *l, size_t num_faces)
{
    const char *name = l->names;
    size_t k;
    REQUIRE((l->of_face != NULL) == (l->count > 0) && (l->names != NULL) == (l->count > 0));
    for (k = 0; k < num_faces && l->of_face != NULL; k++) REQUIRE(l->of_face[k] <= l->count);
    for (k = 0; k < l->count; k++) {
        REQUIRE(strchr(name, '\n') > name);
        name = strchr(name, '\n') + 1;
    }
    REQUIRE(name == NULL || *name == '\0');
}

static void check_attribute_values(const struct mesh_file *m, int attribute)
{
    const struct mesh_values *a = &m->attribute[attribute];
    size_t k;
    if (a->values == NULL) return;
    REQUIRE(a->components == (attribute == MESH_TEXCOORDS ? 2 : 3) || (attribute == MESH_COLORS && a->components == 4));
    REQUIRE(a->corner != NULL || a->count == m->num_vertices);
    for (k = 0; k < (size_t)a->components * a->count; k++) {
        REQUIRE(isfinite(a->values[k]));
        REQUIRE(attribute != MESH_COLORS || (a->values[k] >= 0 && a->values[k] <= 1));
    }
    for (k = 0; a->corner != NULL && k < 3 * (size_t)m->num_faces; k++)
        REQUIRE(a->corner[k] == MESH_NONE || a->corner[k] < a->count);
}

static void check_mesh(const struct mesh_file *m)
{
    size_t k;
    int a;
    for (k = 0; k < 3 * (size_t)m->num_vertices; k++) REQUIRE(fabs(m->positions[k]) <= (double)FLT_MAX);
    REQUIRE(m->rounding >= 0 && isfinite(m->rounding));
    for (k = 0; k < 3 * (size_t)m->num_faces; k++) REQUIRE(m->indices[k] < m->num_vertices);
    for (a = 0; a < MESH_NUM_ATTRIBUTES; a++) check_attribute_values(m, a);
    for (a = 0; a < MESH_NUM_LABELS; a++) check_labels(&m->label[a], m->num_faces);
    check_notes(m->notes);
    check_notes(m->attribute_notes);
}

static const float *value_of(const struct mesh_file *m, int attribute, size_t corner)
{
    const struct mesh_values *a = &m->attribute[attribute];
    uint32_t item;
    if (a->values == NULL || (m->marks != NULL && (m->marks[corner / 3] >> attribute & 1) != 0)) return NULL;
    item = a->corner != NULL ? a->corner[corner] : m->indices[corner];
    return item != MESH_NONE ? a->values + (size_t)a->components * item : NULL;
}

/* Normals and texture coordinates come back as they were, colors of PLY to 8 bits. */
static void require_equal_values(const struct mesh_file *a, const struct mesh_file *b, int i, enum mesh_format format)
{
    int shared = a->attribute[i].components == 4 && format == MESH_OBJ ? 3 : a->attribute[i].components, n;
    size_t k;
    for (k = 0; k < 3 * (size_t)a->num_faces; k++) {
        const float *x = value_of(a, i, k), *y = value_of(b, i, k);
        REQUIRE((x != NULL) == (y != NULL));
        for (n = 0; x != NULL && n < shared; n++)
            REQUIRE(x[n] == y[n] || (i == MESH_COLORS && format == MESH_PLY && fabs((double)x[n] - (double)y[n]) < 0.0020));
    }
}

/* PLY has values where others had none, if its vertices had to be those of mesh_expand(). */
static void require_equal_attributes(const struct mesh_file *a, const struct mesh_file *b, enum mesh_format format)
{
    int i;
    for (i = 0; i < MESH_NUM_ATTRIBUTES; i++) require_equal_values(a, b, i, format);
}

static void require_equal_labels(const struct mesh_file *a, const struct mesh_file *b, int kind)
{
    const struct mesh_labels *l = &a->label[kind], *m = &b->label[kind];
    REQUIRE(l->count == m->count);
    REQUIRE(l->count == 0 || strcmp(l->names, m->names) == 0);
    REQUIRE(l->count == 0 || memcmp(l->of_face, m->of_face, a->num_faces * sizeof *l->of_face) == 0);
}

/* Text has nine digits of floats, STL holds floats only. */
static void require_equal_coordinates(double x, double y, enum mesh_format format)
{
    REQUIRE(x == y || (float)x == (float)y);
    REQUIRE(x == y || format == MESH_STL || x == (double)(float)x);
    REQUIRE(x == y || format != MESH_PLY);
}

static void require_equal_corners(const struct mesh_file *a, const struct mesh_file *b, enum mesh_format format)
{
    size_t k, c;
    REQUIRE(a->num_faces == b->num_faces);
    for (k = 0; k < 3 * (size_t)a->num_faces; k++)
        for (c = 0; c < 3; c++)
            require_equal_coordinates(a->positions[3 * (size_t)a->indices[k] + c],
                                      b->positions[3 * (size_t)b->indices[k] + c], format);
}

static void check_same(const struct mesh_file *a, const struct mesh_file *b, enum mesh_format format)
{
    size_t k;
    require_equal_corners(a, b, format);
    REQUIRE(a->num_vertices == b->num_vertices);
    REQUIRE(a->num_faces == 0 || memcmp(a->indices, b->indices, 3 * (size_t)a->num_faces * sizeof *a->indices) == 0);
    for (k = 0; k < 3 * (size_t)a->num_vertices; k++)
        require_equal_coordinates(a->positions[k], b->positions[k], format);
}

/* Are there vertices of their own for what corners have? */
static int has_values_of_corners_but_texture(const struct mesh_file *m)
{
    return m->attribute[MESH_NORMALS].corner != NULL || m->attribute[MESH_COLORS].corner != NULL;
}

static void compare(const struct mesh_file *m, const struct mesh_file *again, enum mesh_format format)
{
    int k;
    if (format == MESH_STL) require_equal_corners(m, again, format);
    else check_same(m, again, format);
    if (format == MESH_PLY || format == MESH_OBJ) require_equal_attributes(m, again, format);
    for (k = 0; k < MESH_NUM_LABELS; k++)
        if (format == MESH_OBJ || (format == MESH_PLY && k == MESH_MATERIALS)) require_equal_labels(m, again, k);
    REQUIRE(format != MESH_OBJ || (m->libraries == NULL) == (again->libraries == NULL));
    REQUIRE(format != MESH_OBJ || m->libraries == NULL || strcmp(m->libraries, again->libraries) == 0);
}

static void check_writing(struct mesh_file *m, enum mesh_format format)
{
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
    compare(m, &again, format);
    mesh_free(&again);
    free(exact);
    free(text);
}

/* All but PLY leave values to corners. A face that misses some has them then, as 0. */
static void check_expanding(struct mesh_file *m)
{
    int a;
    REQUIRE(mesh_expand(m, (1u << MESH_NUM_ATTRIBUTES) - 1));
    check_mesh(m);
    for (a = 0; a < MESH_NUM_ATTRIBUTES; a++) REQUIRE(m->attribute[a].corner == NULL);
    check_writing(m, MESH_OBJ);
    free(m->marks);
    m->marks = NULL;
    check_writing(m, MESH_PLY);
    REQUIRE(mesh_expand(m, 0));
    for (a = 0; a < MESH_NUM_ATTRIBUTES; a++) REQUIRE(m->attribute[a].values == NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = { data, size };
    uint32_t kind = take(&in);
    char error[MESH_ERROR_BYTES];
    struct mesh_file mesh;
    uint8_t *bytes = (uint8_t *)copy_of(in.data, in.size);
    memset(error, 'x', sizeof error);
    if (mesh_read(&mesh, bytes, in.size, (enum mesh_format)(MESH_OFF + kind % 4), error)) {
        check_mesh(&mesh);
        check_writing(&mesh, MESH_OFF);
        check_writing(&mesh, MESH_STL);
        check_writing(&mesh, MESH_OBJ);
        if (!has_values_of_corners_but_texture(&mesh)) check_writing(&mesh, MESH_PLY);
        check_expanding(&mesh);
        mesh_free(&mesh);
    } else {
        REQUIRE(mesh.num_vertices == 0 && mesh.num_faces == 0 && mesh.positions == NULL && mesh.indices == NULL);
        REQUIRE(strlen(error) > 0 && strlen(error) < sizeof error);
    }
    free(bytes);
    return 0;
}
