/* engine.c - a mesh streams into a game while it is drawn. SPDX-License-Identifier: MIT
 *
 *     make engine && build/engine --rate 100000 bunny.cqm
 *
 * What an engine does with a stream, in the order of this file:
 *
 *     upload    the new vertices, which are never touched again, and the blocks of indices that have changed
 *     levels    when the mesh has twice the faces, the GPU copies its index buffer: levels of detail, all with one
 *               vertex buffer; each knows how far it is from the exact mesh
 *     refine    at most a millisecond a frame, and at most so many steps
 *     draw      several instances, each at the coarsest level whose error is less than a pixel there; the mesh as it is
 *               now with one call for each material
 *
 * All memory, of the processor and the GPU, is allocated when the header has come. platform.c opens the window, and has a
 * thread that brings the bytes of the file, at a rate that stands for a disk or a network. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "platform.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define FRAME 0.001               /* seconds of a frame that decoding and uploading may take, */
#define MARGIN 0.0002             /* of which this is kept free for steps that are long */
#define STEPS_A_LOOK 16           /* steps between two looks at the clock */
#define SHIFT 6                   /* blocks of 64 faces */
#define MAX_LEVELS 32
#define PIXELS 1.0f               /* of error that may be seen */
#define FOCUS 2.0f                /* cotangent of half the vertical angle of view */

/* -- Scene --------------------------------------------------------------------------------------------------------- */

struct level {
    size_t first, count;          /* of its indices in the buffer of levels */
    float error;                  /* in the size of the mesh */
};

struct scene {
    struct reader reader;
    struct options *options;
    cq_decoder dec;
    size_t used;                  /* bytes that the decoder has taken */
    cq_result result;
    uint8_t *dirty;               /* blocks of indices that are out of date on the GPU */
    cq_index uploaded;            /* vertices that are there */
    GLuint vertices, indices, levels;
    GLuint vertex_array[2];       /* the vertices with the indices of now, and with those of levels */
    GLint place, grid, tint;      /* of the shaders */
    float size;                   /* of the mesh: its grid, in the unit of its coordinates */
    struct level level[MAX_LEVELS];
    int num_levels;
    uint32_t begun;               /* levels of the stream that have been seen to begin */
    uint32_t frame_steps, most_steps;
    size_t frame_bytes, most_bytes, all_bytes;
};

/* -- Upload -------------------------------------------------------------------------------------------------------- */

static void upload(struct scene *s, GLenum target, const void *source, size_t stride, size_t first, size_t end)
{
    if (first == end) return;
    glBufferSubData(target, (GLintptr)(first * stride), (GLsizeiptr)((end - first) * stride),
                    (const uint8_t *)source + first * stride);
    s->frame_bytes += (end - first) * stride;
}

/* Each run of dirty blocks at once; the last block may be in part. */
static void upload_indices(struct scene *s)
{
    const size_t faces = s->dec.mesh.num_faces;
    uint8_t *begin, *end, *at = s->dirty, *stop = s->dirty + (faces >> SHIFT) + 1;
    while ((begin = memchr(at, 1, (size_t)(stop - at))) != NULL) {
        size_t first = (size_t)(begin - s->dirty) << SHIFT, last;
        end = memchr(begin, 0, (size_t)(stop - begin));
        at = end ? end : stop;
        last = (size_t)(at - s->dirty) << SHIFT;
        memset(begin, 0, (size_t)(at - begin));
        last = last < faces ? last : faces;
        upload(s, GL_ELEMENT_ARRAY_BUFFER, s->dec.mesh.origin, 3 * sizeof(cq_index), first, last);
    }
}

static void upload_changes(struct scene *s)
{
    const cq_index count = s->dec.mesh.num_vertices;
    if (count == s->uploaded) return;
    glBindVertexArray(s->vertex_array[0]);
    glBindBuffer(GL_ARRAY_BUFFER, s->vertices);
    upload(s, GL_ARRAY_BUFFER, s->dec.channel[0], 3 * sizeof(cq_value), s->uploaded, count);
    cq_mesh_changes(&s->dec.mesh, s->uploaded, SHIFT, s->dirty);
    upload_indices(s);
    s->uploaded = count;
}

/* -- Levels -------------------------------------------------------------------------------------------------------- */

static float error_of_now(const struct scene *s)
{
    return (float)s->dec.error / 16 * cq_channel_step(&s->dec.shape.channel[0]) / s->size;
}

/* Materials are ranges of faces, which fill from their starts; without any there is one range. */
static uint32_t num_ranges(const struct scene *s) { return s->dec.shape.num_materials ? s->dec.shape.num_materials : 1; }

static size_t count_indices(const struct scene *s)
{
    size_t count = 0;
    cq_index first, faces;
    for (uint32_t m = 0; m < num_ranges(s); m++) {
        cq_material(&s->dec, m, &first, &faces);
        count += 3 * (size_t)faces;
    }
    return count;
}

/* Range by range, one behind the other. */
static void copy_indices(const struct scene *s, size_t to)
{
    cq_index first, faces;
    glBindBuffer(GL_COPY_READ_BUFFER, s->indices);
    glBindBuffer(GL_COPY_WRITE_BUFFER, s->levels);
    for (uint32_t m = 0; m < num_ranges(s); m++) {
        cq_material(&s->dec, m, &first, &faces);
        glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, (GLintptr)(3 * (size_t)first * sizeof(cq_index)),
                            (GLintptr)(to * sizeof(cq_index)), (GLsizeiptr)(3 * (size_t)faces * sizeof(cq_index)));
        to += 3 * (size_t)faces;
    }
}

/* Keeps the indices of a level that is complete, if it has twice the faces of the last one that was kept: all together
 * then have less than twice the faces of the mesh. */
static void keep_level(struct scene *s)
{
    const struct level *last = s->num_levels > 0 ? &s->level[s->num_levels - 1] : NULL;
    struct level *next = &s->level[s->num_levels];
    s->begun = s->dec.level;
    next->count = count_indices(s);
    if (next->count == 0 || s->num_levels == MAX_LEVELS || (last && next->count < 2 * last->count)) return;
    next->first = last ? last->first + last->count : 0;
    next->error = error_of_now(s);
    s->num_levels++;
    upload_changes(s);
    copy_indices(s, next->first);
}

/* -- Refine -------------------------------------------------------------------------------------------------------- */

static int goes_on(const struct scene *s) { return s->result >= 0 && s->result != CQ_DONE && s->result != CQ_TRUNCATED; }

static int shot_is_due(const struct scene *s)
{
    const struct options *o = s->options;
    return o->next_shot < o->shots &&
           (s->dec.mesh.num_vertices >= o->shot[o->next_shot].vertices || !goes_on(s));
}

/* One step of the decoder with the bytes that have come. */
static cq_result step(struct scene *s)
{
    int ended = SDL_AtomicGet(&s->reader.ended);                     /* asked first: then all that came is seen */
    size_t arrived = (size_t)SDL_AtomicGet(&s->reader.arrived);
    cq_bytes in = { s->reader.data + s->used, arrived - s->used };
    cq_result result = cq_decode(&s->dec, ended && in.size == 0 ? NULL : &in, 1);
    s->used = arrived - in.size;
    return result;
}

/* This frame's share. Of the upload it is known that it takes about as long as the last one. */
static void refine(struct scene *s, double begin)
{
    static double upload_seconds;
    const double end = begin + FRAME - MARGIN - 1.5 * upload_seconds;
    double decoded;
    s->frame_steps = 0;
    s->frame_bytes = 0;
    while (goes_on(s) && s->frame_steps < s->options->steps && !shot_is_due(s)) {
        if (s->frame_steps % STEPS_A_LOOK == STEPS_A_LOOK - 1 && seconds() > end) break;
        s->result = step(s);
        s->frame_steps++;
        if (s->dec.level != s->begun) keep_level(s);
        if (s->result == CQ_NEED_INPUT) break;
    }
    decoded = seconds();
    upload_changes(s);
    upload_seconds = seconds() - decoded;
    s->all_bytes += s->frame_bytes;
    if (s->frame_bytes > s->most_bytes) s->most_bytes = s->frame_bytes;
    if (s->frame_steps > s->most_steps) s->most_steps = s->frame_steps;
}

/* -- Draw ---------------------------------------------------------------------------------------------------------- */

/* Instance k stands at `place`: x, z and its rotation. A value of the grid becomes a point of the unit cube. */
static const char vertex_shader[] =
    "#version 330 core\n"
    "uniform vec4 place; uniform vec3 grid; layout(location = 0) in vec3 value; out vec3 at;\n"
    "void main() {\n"
    "    vec3 p = value * grid.x - 0.5 * vec3(1);\n"
    "    at = vec3(place.z * p.x + place.w * p.z, p.y, place.z * p.z - place.w * p.x) + vec3(place.x, 0, -place.y);\n"
    "    gl_Position = vec4(at.x * grid.y, at.y * grid.z, -1.001 * at.z - 0.1, -at.z);\n"
    "}\n";
static const char fragment_shader[] =
    "#version 330 core\n"
    "uniform vec3 tint; in vec3 at; out vec4 color;\n"
    "void main() {\n"
    "    vec3 normal = normalize(cross(dFdx(at), dFdy(at)));\n"
    "    color = vec4(tint * (0.25 + 0.75 * max(dot(normal, normalize(vec3(0.3, 0.5, 0.8))), 0)), 1);\n"
    "}\n";

/* The first is near on the left, the others ever further away to the right. */
static float distance_of(int instance) { return 1.6f + 1.4f * (float)(instance * instance); }
static float side_of(int instance) { return distance_of(instance) * (0.6f - 0.85f / (float)(1 + instance)); }

/* The coarsest level that is good enough there, or -1: as fine as the mesh is now. */
static int choose_level(const struct scene *s, float distance, float *pixels)
{
    const float pixels_of_one = 0.5f * WINDOW_HEIGHT * FOCUS / (distance - 0.5f);
    int k;
    for (k = 0; k < s->num_levels; k++)
        if ((*pixels = s->level[k].error * pixels_of_one) <= PIXELS) return k;
    *pixels = error_of_now(s) * pixels_of_one;
    return -1;
}

static void draw_indices(size_t first, size_t count)
{
    glDrawElements(GL_TRIANGLES, (GLsizei)count, GL_UNSIGNED_INT, (const void *)(first * sizeof(cq_index)));
}

/* The mesh as it is now: each material has a tint. */
static void draw_materials(const struct scene *s)
{
    cq_index first, faces;
    for (uint32_t m = 0; m < num_ranges(s); m++) {
        cq_material(&s->dec, m, &first, &faces);
        glUniform3f(s->tint, 1.0f - 0.3f * (float)(m % 3), 0.8f - 0.2f * (float)(m % 5 % 3), 0.7f + 0.1f * (float)(m % 4));
        draw_indices(3 * (size_t)first, 3 * (size_t)faces);
    }
}

static void draw_instance(const struct scene *s, int instance, float angle, int tell)
{
    float pixels, distance = distance_of(instance);
    int k = choose_level(s, distance, &pixels);
    size_t count = k < 0 ? count_indices(s) : s->level[k].count;
    glBindVertexArray(s->vertex_array[k < 0 ? 0 : 1]);
    glUniform4f(s->place, side_of(instance), distance, cosf(angle), sinf(angle));
    glUniform3f(s->tint, 0.7f, 0.8f, 1.0f);
    if (k < 0) draw_materials(s);
    else draw_indices(s->level[k].first, count);
    if (tell)
        printf("instance %d: distance %.1f, %lu faces, error %.3f pixels, level %d\n", instance, (double)distance,
               (unsigned long)count / 3, (double)pixels, k);
}

static void draw(const struct scene *s, float angle, int tell)
{
    int k;
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (k = 0; k < s->options->instances; k++) draw_instance(s, k, angle, tell);
}

/* -- Begin --------------------------------------------------------------------------------------------------------- */

static GLuint make_buffer(GLenum target, size_t size)
{
    GLuint buffer;
    glGenBuffers(1, &buffer);
    glBindBuffer(target, buffer);
    glBufferData(target, (GLsizeiptr)size, NULL, GL_DYNAMIC_DRAW);
    return buffer;
}

static void make_buffers(struct scene *s, const cq_shape *shape)
{
    const size_t index_bytes = (size_t)shape->num_faces * 3 * sizeof(cq_index);
    int k;
    glGenVertexArrays(2, s->vertex_array);
    s->vertices = make_buffer(GL_ARRAY_BUFFER, (size_t)shape->num_vertices * 3 * sizeof(cq_value));
    for (k = 0; k < 2; k++) {
        glBindVertexArray(s->vertex_array[k]);
        glVertexAttribPointer(0, 3, GL_INT, GL_FALSE, 0, NULL);
        glEnableVertexAttribArray(0);
        *(k ? &s->levels : &s->indices) = make_buffer(GL_ELEMENT_ARRAY_BUFFER, index_bytes * (k ? 2 : 1));
    }
}

/* Waits for the header, and allocates everything. */
static cq_result begin(struct scene *s)
{
    cq_shape shape;
    cq_result result;
    size_t size;
    void *memory;
    GLuint program;
    int ended;
    do {
        ended = SDL_AtomicGet(&s->reader.ended);
        SDL_Delay(1);
        result = cq_peek(s->reader.data, (size_t)SDL_AtomicGet(&s->reader.arrived), &shape, NULL, NULL);
    } while (result == CQ_NEED_INPUT && !ended);
    if (result != CQ_OK) return result;
    if (shape.num_channels == 0 || shape.channel[0].kind != CQ_POSITION || shape.channel[0].bits == CQ_EXACT_BITS)
        return CQ_ERROR_UNSUPPORTED;
    size = cq_decoder_bytes(&shape);
    memory = malloc(size);
    s->dirty = calloc((shape.num_faces >> SHIFT) + 1, 1);
    program = use_program(vertex_shader, fragment_shader);
    if (!memory || !s->dirty || !program) return CQ_ERROR_MEMORY;
    memset(memory, 0, size);                                         /* the system gives it now, not in some frame */
    make_buffers(s, &shape);
    s->size = cq_channel_step(&shape.channel[0]) * (float)(1ul << shape.channel[0].bits);
    s->place = glGetUniformLocation(program, "place");
    s->tint = glGetUniformLocation(program, "tint");
    s->grid = glGetUniformLocation(program, "grid");
    glUniform3f(s->grid, 1.0f / (float)(1ul << shape.channel[0].bits), FOCUS * WINDOW_HEIGHT / WINDOW_WIDTH, FOCUS);
    result = cq_decoder_init(&s->dec, memory, size);
    if (result == CQ_OK) cq_watch_faces(&s->dec, SHIFT, s->dirty);
    return result;
}

/* -- The loop ------------------------------------------------------------------------------------------------------ */

static int take_shot(struct scene *s)
{
    struct options *o = s->options;
    printf("shot of %lu vertices\n", (unsigned long)s->dec.mesh.num_vertices);
    draw(s, 0.5f, 1);
    return save_picture(o->shot[o->next_shot++].path);
}

static int user_goes_on(const struct options *o)
{
    SDL_Event event;
    while (SDL_PollEvent(&event))
        if (event.type == SDL_QUIT) return 0;
    return o->shots == 0 || o->next_shot < o->shots;
}

static int run(struct scene *s, SDL_Window *window)
{
    static struct times work, frames;
    int good = 1;
    while (good && user_goes_on(s->options)) {
        double start = seconds();
        refine(s, start);
        if (s->frame_steps > 0) keep_time(&work, seconds() - start);
        if (shot_is_due(s)) good = take_shot(s);
        else draw(s, 0.2f * (float)start, 0);
        SDL_GL_SwapWindow(window);
        keep_time(&frames, seconds() - start);
    }
    report_times("refining and uploading", &work);
    report_times("frames", &frames);
    printf("steps of a frame: most %lu\nbytes uploaded in a frame that refines: mean %lu, most %lu\nlevels kept: %d\n",
           (unsigned long)s->most_steps, (unsigned long)(s->all_bytes / (work.count ? work.count : 1)),
           (unsigned long)s->most_bytes, s->num_levels);
    return good && s->result >= 0;
}

int main(int argc, char **argv)
{
    static struct scene scene;
    static struct options options = { .steps = 4096, .instances = 5 };
    SDL_Window *window;
    SDL_Thread *thread;
    int good = 0;
    if (argc < 2 || !read_options(&options, argv)) {
        fprintf(stderr, "%s", usage);
        return 2;
    }
    scene.options = &options;
    window = open_window(options.path);
    thread = window ? start_reading(&scene.reader, options.path, options.rate) : NULL;
    if (thread) {
        scene.result = begin(&scene);
        good = scene.result == CQ_OK && run(&scene, window);
        SDL_AtomicSet(&scene.reader.ended, 1);
        SDL_WaitThread(thread, NULL);
    }
    printf("%s: %lu of %lu vertices\n", thread ? cq_result_string(scene.result) : "cannot begin",
           (unsigned long)scene.dec.mesh.num_vertices, (unsigned long)scene.dec.shape.num_vertices);
    SDL_Quit();
    return good ? 0 : 1;
}
