/* Work on hostile meshes and streams, counted in basic blocks: four times the size may take at most five times the
 * work, and never more than a bound per vertex, face and byte. Hubs of any valence, thousands of components, long
 * boundaries, many holes and handles, seams along every edge, faces that are no manifold at all, headers that promise what
 * does not come, streams whose second half is damaged. No clock is involved. The last line is `N passed, N failed`.
 *
 *     work [FACES]   meshes of about FACES faces and of a quarter of them; 160 000 without it */
#include "fuzz.h"

uint64_t work;
void __sanitizer_cov_trace_pc(void);
__attribute__((no_sanitize("coverage"))) void __sanitizer_cov_trace_pc(void) { work++; }

enum { MOST_PER_COUNT_TO_ENCODE = 1200 }; /* strips: half a dozen regular levels, then conquest levels to compare */
enum { MOST_PER_COUNT = 1000 };

static uint32_t most_faces = 160000;
static int passed, failed;

typedef struct faces {
    cq_index *index;
    uint32_t num_vertices, num_faces, room;
    cq_value *position, *texcoord;   /* of each vertex, or NULL: connectivity alone */
} faces;

static void add(faces *f, uint32_t a, uint32_t b, uint32_t c)
{
    cq_index *at;
    if (f->num_faces == f->room) {
        f->room = 2 * f->room + 64;
        f->index = (cq_index *)realloc(f->index, 3 * (size_t)f->room * sizeof(cq_index));
        REQUIRE(f->index != NULL);
    }
    at = f->index + 3 * (size_t)f->num_faces++;
    at[0] = (cq_index)a, at[1] = (cq_index)b, at[2] = (cq_index)c;
}

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* -- Meshes of about n faces --------------------------------------------------------------------------------------- */

static void cone(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, n, k, (k + 1) % n);
    f->num_vertices = n + 1;
}

static void hub_in_the_first_gate(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 0, 1 + k, 1 + (k + 1) % n);
    f->num_vertices = n + 1;
}

static void bipyramid(faces *f, uint32_t n)
{
    uint32_t k, m = n / 2;
    for (k = 0; k < m; k++) add(f, k, (k + 1) % m, m), add(f, (k + 1) % m, k, m + 1);
    f->num_vertices = m + 2;
}

static void open_fan(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 0, k + 1, k + 2);
    f->num_vertices = n + 2;
}

static void strip(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, k + k % 2, k + 1 - k % 2, k + 2);
    f->num_vertices = n + 2;
}

/* A polygon cut into triangles at random: every vertex is on the one boundary. */
static void polygon(faces *f, uint32_t n)
{
    uint32_t *stack = (uint32_t *)block(2 * ((size_t)n + 2) * sizeof *stack), size = 0, seed = 1;
    stack[size++] = 0, stack[size++] = n + 1;
    while (size > 0) {
        uint32_t b = stack[--size], a = stack[--size], c;
        if (b - a < 2) continue;
        c = a + 1 + next_random(&seed) % (b - a - 1);
        add(f, a, c, b);
        stack[size++] = a, stack[size++] = c;
        stack[size++] = c, stack[size++] = b;
    }
    f->num_vertices = n + 2;
    free(stack);
}

/* The same with a hub that closes its boundary: the hub is far from the first gate, or in it. */
static void capped_polygon(faces *f, uint32_t n)
{
    uint32_t k;
    polygon(f, n / 2);
    for (k = 0; k < f->num_vertices; k++) add(f, (k + 1) % f->num_vertices, k, f->num_vertices);
    f->num_vertices++;
}

static void tetrahedra(faces *f, uint32_t n)
{
    for (; 4 * (f->num_vertices / 4) < n; f->num_vertices += 4) {
        uint32_t v = f->num_vertices;
        add(f, v, v + 1, v + 2), add(f, v, v + 2, v + 3), add(f, v, v + 3, v + 1), add(f, v + 1, v + 3, v + 2);
    }
}

/* So many components that no level is worth coding: all is base, and the hub's faces come in its order. */
static void capped_polygon_among_tetrahedra(faces *f, uint32_t n)
{
    uint32_t v;
    capped_polygon(f, n / 3);
    v = f->num_vertices;
    while (f->num_faces < n) {
        add(f, v, v + 1, v + 2), add(f, v, v + 2, v + 3), add(f, v, v + 3, v + 1), add(f, v + 1, v + 3, v + 2);
        v += 4;
    }
    f->num_vertices = v;
}

static void pairs_of_faces(faces *f, uint32_t n)
{
    uint32_t v;
    for (v = 0; f->num_faces < n; v += 3) add(f, v, v + 1, v + 2), add(f, v + 2, v + 1, v);
    f->num_vertices = v;
}

static void single_faces(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 3 * k, 3 * k + 1, 3 * k + 2);
    f->num_vertices = 3 * n;
}

/* Two tori of w x w quads, one inside the other, with a tube at every fourth crossing of every fourth row. */
static void handles(faces *f, uint32_t n)
{
    uint32_t w = 4, layer, x, y, k;
    while (4 * (w + 4) * (w + 4) <= n) w += 4;
    for (y = 0; y < w; y++)
        for (x = 0; x < w; x++) {
            uint32_t ring[2][4];
            for (layer = 0; layer < 2; layer++) {
                uint32_t first = layer * w * w, x1 = (x + 1) % w, y1 = (y + 1) % w, *r = ring[layer];
                r[0] = first + y * w + x, r[1] = first + y * w + x1;
                r[2] = first + y1 * w + x1, r[3] = first + y1 * w + x;
                if (x % 4 == 0 && y % 4 == 0) continue;
                add(f, r[0], r[layer ? 2 : 1], r[layer ? 1 : 2]);
                add(f, r[0], r[layer ? 3 : 2], r[layer ? 2 : 3]);
            }
            for (k = 0; x % 4 == 0 && y % 4 == 0 && k < 4; k++) {
                add(f, ring[0][k], ring[0][(k + 1) % 4], ring[1][k]);
                add(f, ring[0][(k + 1) % 4], ring[1][(k + 1) % 4], ring[1][k]);
            }
        }
    f->num_vertices = 2 * w * w;
}

static void grid(faces *f, uint32_t n)
{
    uint32_t w = 3, x, y;
    while (2 * w * w < n) w++;
    for (y = 0; y + 1 < w; y++)
        for (x = 0; x + 1 < w; x++) {
            uint32_t a = y * w + x;
            add(f, a, a + 1, a + w + 1), add(f, a, a + w + 1, a + w);
        }
    f->num_vertices = w * w;
}

/* A grid with a hole of one face in each square of two by two. */
static void holes(faces *f, uint32_t n)
{
    uint32_t w = 4, x, y;
    while (7 * (w / 2) * (w / 2) < n) w += 2;
    for (y = 0; y < w; y++)
        for (x = 0; x < w; x++) {
            uint32_t a = y * (w + 1) + x;
            add(f, a, a + 1, a + w + 2);
            if (x % 2 || y % 2) add(f, a, a + w + 2, a + w + 1);
        }
    f->num_vertices = (w + 1) * (w + 1);
}

/* -- Rows of vertex buffers: seams, copies, faces that lie on each other ------------------------------------------ */

/* A row for each corner of n faces. */
static void add_corners(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 3 * k, 3 * k + 1, 3 * k + 2);
    f->num_vertices = 3 * n;
    f->position = (cq_value *)block(9 * (size_t)n * sizeof(cq_value));
    f->texcoord = (cq_value *)block(6 * (size_t)n * sizeof(cq_value));
}

static void set_corner(faces *f, uint32_t row, uint32_t x, uint32_t y, uint32_t texcoord)
{
    f->position[3 * row] = (cq_value)x, f->position[3 * row + 1] = (cq_value)y, f->position[3 * row + 2] = 0;
    f->texcoord[2 * row] = (cq_value)(texcoord & 1023), f->texcoord[2 * row + 1] = (cq_value)(texcoord >> 10 & 1023);
}

/* A grid of which every edge is a seam. */
static void grid_of_seams(faces *f, uint32_t n)
{
    uint32_t w = 2, k, c, seed = 5;
    while (2 * w * w < n) w++;
    add_corners(f, 2 * w * w);
    for (k = 0; k < f->num_faces; k++)
        for (c = 0; c < 3; c++) {
            static const uint8_t right[2][3] = { { 0, 1, 1 }, { 0, 1, 0 } }, up[2][3] = { { 0, 0, 1 }, { 0, 1, 1 } };
            const uint32_t x = k / 2 % w + right[k % 2][c], y = k / 2 / w + up[k % 2][c];
            set_corner(f, 3 * k + c, x, y, next_random(&seed));
        }
}

/* All corners at random places of few: edges of any number of faces, faces that repeat, faces without area. */
static void crowd(faces *f, uint32_t n)
{
    uint32_t k, side = 2, seed = 9;
    while (side * side < n / 8) side++;
    add_corners(f, n);
    for (k = 0; k < 3 * n; k++) set_corner(f, k, next_random(&seed) % side, next_random(&seed) % side, next_random(&seed));
}

/* All corners at two places. */
static void no_area(faces *f, uint32_t n)
{
    uint32_t k;
    add_corners(f, n);
    for (k = 0; k < 3 * n; k++) set_corner(f, k, k % 2, 0, k);
}

/* All faces have one edge in common. */
static void book_of_rows(faces *f, uint32_t n)
{
    uint32_t k;
    add_corners(f, n);
    for (k = 0; k < n; k++)
        set_corner(f, 3 * k, 0, 0, k), set_corner(f, 3 * k + 1, 1, 0, k), set_corner(f, 3 * k + 2, k % 1000, 1 + k / 1000, k);
}

/* -- Faces that are no oriented manifold: must be refused, as fast ------------------------------------------------- */

static void book(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 0, 1, k + 2);
    f->num_vertices = n + 2;
}

static void faces_at_one_vertex(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 0, 2 * k + 1, 2 * k + 2);
    f->num_vertices = 2 * n + 1;
}

static void cones_at_one_vertex(faces *f, uint32_t n)
{
    uint32_t k, j;
    for (k = 0; k < n / 4; k++)
        for (j = 0; j < 4; j++) add(f, 0, 4 * k + j + 1, 4 * k + (j + 1) % 4 + 1);
    f->num_vertices = n / 4 * 4 + 1;
}

static void one_face_many_times(faces *f, uint32_t n)
{
    uint32_t k;
    for (k = 0; k < n; k++) add(f, 0, 1, 2);
    f->num_vertices = 3;
}

static void noise(faces *f, uint32_t n)
{
    uint32_t k, seed = 7;
    for (k = 0; k < n; k++) {
        uint32_t a = next_random(&seed) % n, b = (a + 1 + next_random(&seed) % (n - 2)) % n;
        add(f, a, b, (uint32_t)((uint64_t)a + b) % n == a || (a + b) % n == b ? (a + 1) % n : (a + b) % n);
    }
    f->num_vertices = n;
}

/* -- Measuring ----------------------------------------------------------------------------------------------------- */

typedef struct cost {
    uint64_t encoding, decoding, damaged, counts;   /* blocks; vertices + faces + bytes */
    cq_result result;
} cost;

static uint8_t fill(int byte, uint32_t *seed) { return (uint8_t)(byte >= 0 ? (uint32_t)byte : next_random(seed)); }

static uint64_t decoding_work(const uint8_t *data, size_t size, cq_result *result)
{
    cq_shape shape;
    cq_decoder *d = (cq_decoder *)block(sizeof *d);
    void *memory;
    cq_bytes in;
    REQUIRE(cq_peek(data, size, &shape, NULL, NULL) == CQ_OK);
    memory = block(cq_decoder_bytes(&shape));
    REQUIRE(cq_decoder_init(d, memory, cq_decoder_bytes(&shape)) == CQ_OK);
    in.data = data;
    in.size = size;
    work = 0;
    *result = cq_decode(d, &in, CQ_NO_LIMIT);
    if (*result == CQ_NEED_INPUT) *result = cq_decode(d, NULL, CQ_NO_LIMIT);
    free(memory);
    free(d);
    return work;
}

/* The most work of a good stream whose second half of the payload is zeros, ones or noise, under right check values. */
static uint64_t damaged_work(const uint8_t *data, size_t size)
{
    static const int bytes[3] = { 0, 0xff, -1 };
    uint64_t most = 0;
    cq_shape shape;
    size_t header, j;
    int k;
    REQUIRE(cq_peek(data, size, &shape, &header, NULL) == CQ_OK);
    for (k = 0; k < 3; k++) {
        const size_t payload_size = size - header;
        uint8_t *payload = (uint8_t *)block(payload_size);
        uint32_t seed = 11;
        uint64_t blocks;
        cq_result result;
        stream s;
        memcpy(payload, data + header, payload_size);
        for (j = payload_size / 2; j < payload_size; j++) payload[j] = fill(bytes[k], &seed);
        s = frame(&shape, payload, payload_size);
        blocks = decoding_work(s.data, s.size, &result);
        most = blocks > most ? blocks : most;
        free(s.data);
        free(payload);
    }
    return most;
}

static void set_channel(cq_input *in, cq_kind kind, uint32_t components, const cq_value *values)
{
    cq_channel *c = &in->shape.channel[in->shape.num_channels];
    c->kind = (uint8_t)kind;
    c->components = (uint8_t)components;
    c->bits = 12;
    in->values[in->shape.num_channels++] = values;
}

static cost measure(const faces *f)
{
    cost c = { 0, 0, 0, 0, CQ_ERROR_MEMORY };
    cq_input in;
    size_t size = 0, capacity = 64 + 4 * ((size_t)f->num_vertices + f->num_faces);
    uint8_t *out = (uint8_t *)block(capacity);
    void *memory = NULL;
    int tries;
    memset(&in, 0, sizeof in);
    in.shape.num_vertices = f->num_vertices;
    in.shape.num_faces = f->num_faces;
    in.indices = f->index;
    if (f->position) {
        set_channel(&in, CQ_POSITION, 3, f->position);
        set_channel(&in, CQ_TEXCOORD, 2, f->texcoord);
        capacity += 16 * (size_t)f->num_vertices;
        free(out);
        out = (uint8_t *)block(capacity);
    }
    for (tries = 0; c.result == CQ_ERROR_MEMORY && tries < 2; tries++) {
        free(memory);
        memory = block(cq_encoder_bytes(&in.shape));
        work = 0;
        c.result = cq_encode(&in, memory, cq_encoder_bytes(&in.shape), out, capacity, &size, NULL, NULL);
        c.encoding += work;
    }
    REQUIRE(cq_encoder_bytes(&in.shape) <= cq_encoder_bytes_at_most(&in.shape));
    c.counts = (uint64_t)f->num_vertices + f->num_faces + size;
    if (c.result == CQ_OK) {
        cq_result decoded;
        c.decoding = decoding_work(out, size, &decoded);
        REQUIRE(decoded == CQ_DONE);
        c.damaged = damaged_work(out, size);
    }
    free(memory);
    free(out);
    return c;
}

static struct { double encoding, decoding, growth; } worst;

static void at_least(double *most, double x) { *most = x > *most ? x : *most; }

static void verdict(const char *name, uint64_t small, uint64_t large, uint64_t counts, const char *result)
{
    const int encoding = strncmp(name, "encode", 6) == 0;
    int ok = large <= 5 * small + 10000 && large <= (encoding ? MOST_PER_COUNT_TO_ENCODE : MOST_PER_COUNT) * counts;
    at_least(encoding ? &worst.encoding : &worst.decoding, (double)large / (double)counts);
    at_least(&worst.growth, (double)large / (double)(small + 1));
    printf("%s %-50s %6.1f blocks per vertex, face and byte; 4 times as much takes %.2f times the work (%s)\n",
           ok ? "ok  " : "FAIL", name, (double)large / (double)counts, (double)large / (double)(small + 1), result);
    ok ? passed++ : failed++;
}

static void check_mesh(const char *name, void (*make)(faces *f, uint32_t n), int is_manifold)
{
    cost c[2];
    char label[100];
    int k;
    for (k = 0; k < 2; k++) {
        faces f = { NULL, 0, 0, 0, NULL, NULL };
        make(&f, k ? most_faces : most_faces / 4);
        c[k] = measure(&f);
        REQUIRE(c[k].result == CQ_OK || !is_manifold);
        free(f.index);
        free(f.position);
        free(f.texcoord);
    }
    snprintf(label, sizeof label, "encode %s", name);
    verdict(label, c[0].encoding, c[1].encoding, c[1].counts, cq_result_string(c[1].result));
    snprintf(label, sizeof label, "decode %s", name);
    if (is_manifold) verdict(label, c[0].decoding, c[1].decoding, c[1].counts, "complete");
    snprintf(label, sizeof label, "decode damaged %s", name);
    /* where the damage ends a decoding is chance, so only the bound counts */
    if (is_manifold) verdict(label, c[1].damaged / 4, c[1].damaged, c[1].counts, "the worst of three");
}

enum { PLAIN, REGULAR, POSITIONS, SEAMS, MATERIALS };   /* what a header says beside counts */

static void set_feature(cq_shape *shape, int feature)
{
    cq_input in;
    memset(&in, 0, sizeof in);
    in.shape = *shape;
    if (feature == POSITIONS || feature == SEAMS) set_channel(&in, CQ_POSITION, 3, NULL);
    if (feature == SEAMS) set_channel(&in, CQ_TEXCOORD, 2, NULL);
    *shape = in.shape;
    shape->regular = feature == REGULAR || feature == POSITIONS;
    if (feature == MATERIALS) shape->num_materials = 5;
    if (feature != SEAMS) return;
    shape->num_rows = 2 * shape->num_vertices;
    shape->num_aside_rows = shape->num_aside_faces = shape->num_vertices / 8;
}

/* A header of many vertices, and a payload of one byte repeated, or of noise. */
static void check_stream(const char *name, uint32_t components, uint32_t loops, size_t bytes, int byte, int feature)
{
    uint64_t small = 0, large = 0, counts = 0;
    cq_result result = CQ_OK;
    int k;
    for (k = 0; k < 2; k++) {
        cq_shape shape;
        uint8_t *payload = (uint8_t *)block(bytes);
        uint32_t seed = 3;
        stream s;
        size_t j;
        memset(&shape, 0, sizeof shape);
        shape.num_vertices = k ? most_faces : most_faces / 4;
        shape.num_boundary_loops = loops;
        shape.num_boundary_edges = 4 * loops;
        shape.num_faces = 2 * (shape.num_vertices + loops) - 4 * loops - 4 * components;
        set_feature(&shape, feature);
        for (j = 0; j < bytes; j++) payload[j] = fill(byte, &seed);
        s = frame(&shape, payload, bytes);
        large = decoding_work(s.data, s.size, &result);
        if (k == 0) small = large;
        counts = (uint64_t)shape.num_vertices + shape.num_faces + s.size;
        free(s.data);
        free(payload);
    }
    verdict(name, small, large, counts, cq_result_string(result));
}

int main(int argc, char **argv)
{
    if (argc > 1) most_faces = (uint32_t)strtoul(argv[1], NULL, 10);
    REQUIRE(most_faces >= 100000 && most_faces <= 10000000);
#define MESH(name, is_manifold) check_mesh(#name, name, is_manifold)
    MESH(cone, 1);
    MESH(hub_in_the_first_gate, 1);
    MESH(bipyramid, 1);
    MESH(open_fan, 1);
    MESH(strip, 1);
    MESH(polygon, 1);
    MESH(capped_polygon, 1);
    MESH(capped_polygon_among_tetrahedra, 1);
    MESH(tetrahedra, 1);
    MESH(pairs_of_faces, 1);
    MESH(single_faces, 1);
    MESH(handles, 1);
    MESH(grid, 1);
    MESH(holes, 1);
    MESH(grid_of_seams, 1);
    MESH(crowd, 1);
    MESH(no_area, 0);
    MESH(book_of_rows, 1);
    MESH(book, 0);
    MESH(faces_at_one_vertex, 0);
    MESH(cones_at_one_vertex, 0);
    MESH(one_face_many_times, 0);
    MESH(noise, 0);
    check_stream("stream of nothing", 1, 0, 0, 0, PLAIN);
    check_stream("stream of zeros", 1, 0, 5000, 0, PLAIN);
    check_stream("stream of ones", 1, 0, 5000, 0xff, PLAIN);
    check_stream("stream of noise", 1, 0, 5000, -1, PLAIN);
    check_stream("stream of zeros, components", 2000, 0, 5000, 0, PLAIN);
    check_stream("stream of ones, components", 2000, 0, 5000, 0xff, PLAIN);
    check_stream("stream of noise, loops", 1, 1000, 5000, -1, PLAIN);
    check_stream("stream of zeros, loops", 1, 1000, 5000, 0, PLAIN);
    check_stream("stream of zeros, regular", 1, 0, 5000, 0, REGULAR);
    check_stream("stream of ones, regular", 1, 0, 5000, 0xff, REGULAR);
    check_stream("stream of noise, regular", 1, 0, 5000, -1, REGULAR);
    check_stream("stream of noise, regular, loops", 1, 1000, 5000, -1, REGULAR);
    check_stream("stream of zeros, regular, positions", 1, 0, 5000, 0, POSITIONS);
    check_stream("stream of noise, regular, positions", 1, 0, 5000, -1, POSITIONS);
    check_stream("stream of zeros, seams", 1, 0, 5000, 0, SEAMS);
    check_stream("stream of ones, seams", 1, 0, 5000, 0xff, SEAMS);
    check_stream("stream of noise, seams", 1, 0, 5000, -1, SEAMS);
    check_stream("stream of noise, seams, components", 2000, 0, 5000, -1, SEAMS);
    check_stream("stream of zeros, materials", 1, 0, 5000, 0, MATERIALS);
    check_stream("stream of noise, materials", 1, 0, 5000, -1, MATERIALS);
    printf("worst: %.1f blocks to decode, %.1f to encode, %.2f times the work\n", worst.decoding, worst.encoding, worst.growth);
    printf("%d passed, %d failed\n", passed, failed);
    return failed != 0 || passed == 0;
}
