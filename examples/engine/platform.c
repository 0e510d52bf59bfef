/* platform.c - SDL2 and OpenGL 3.3 for the engine. SPDX-License-Identifier: MIT */
#include "platform.h"

#include <stdlib.h>

static int complain(const char *what, const char *why)
{
    fprintf(stderr, "engine: %s: %s\n", what, why);
    return 0;
}

SDL_Window *open_window(const char *title)
{
    SDL_Window *window = NULL;
    if (SDL_Init(SDL_INIT_VIDEO) == 0) {
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
        SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 24);
        window = SDL_CreateWindow(title, SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, WINDOW_WIDTH, WINDOW_HEIGHT,
                                  SDL_WINDOW_OPENGL);
    }
    if (!window || !SDL_GL_CreateContext(window)) {
        complain("OpenGL 3.3", SDL_GetError());
        return NULL;
    }
    SDL_GL_SetSwapInterval(1);
    glEnable(GL_DEPTH_TEST);
    glClearColor(0.1f, 0.12f, 0.15f, 1);
    return window;
}

static int add_shader(GLuint program, GLenum type, const char *source)
{
    char log[1024];
    GLint compiled;
    GLuint shader = glCreateShader(type);
    glShaderSource(shader, 1, &source, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    glGetShaderInfoLog(shader, sizeof log, NULL, log);
    glAttachShader(program, shader);
    return compiled || complain("shader", log);
}

GLuint use_program(const char *vertex_shader, const char *fragment_shader)
{
    GLint linked;
    GLuint program = glCreateProgram();
    if (!add_shader(program, GL_VERTEX_SHADER, vertex_shader) ||
        !add_shader(program, GL_FRAGMENT_SHADER, fragment_shader))
        return 0;
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) return (GLuint)complain("shaders", "cannot be linked");
    glUseProgram(program);
    return program;
}

double seconds(void) { return (double)SDL_GetPerformanceCounter() / (double)SDL_GetPerformanceFrequency(); }

static int read_file(void *user)
{
    struct reader *r = user;
    const double begin = seconds();
    int arrived = 0;
    while (arrived < r->size && !SDL_AtomicGet(&r->ended)) {
        double allowed = r->rate > 0 ? r->rate * (seconds() - begin) : r->size;
        int end = allowed < r->size ? (int)allowed : r->size;
        int count = (int)fread(r->data + arrived, 1, (size_t)(end - arrived), r->file);
        if (count < end - arrived) break;
        arrived = end;
        SDL_AtomicSet(&r->arrived, arrived);
        SDL_Delay(1);
    }
    SDL_AtomicSet(&r->ended, 1);
    return 0;
}

SDL_Thread *start_reading(struct reader *r, const char *path, double rate)
{
    r->file = fopen(path, "rb");
    r->rate = rate;
    if (!r->file || fseek(r->file, 0, SEEK_END) != 0) return NULL;
    r->size = (int)ftell(r->file);
    rewind(r->file);
    r->data = r->size > 0 ? malloc((size_t)r->size) : NULL;
    return r->data ? SDL_CreateThread(read_file, "reader", r) : NULL;
}

void keep_time(struct times *times, double seconds_of_one)
{
    if (times->count < MAX_TIMES) times->seconds[times->count++] = seconds_of_one;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void report_times(const char *what, struct times *times)
{
    size_t n = times->count;
    qsort(times->seconds, n, sizeof times->seconds[0], by_size);
    if (n > 0)
        printf("%s: %lu, milliseconds: median %.3f, 99 %% %.3f, worst %.3f\n", what, (unsigned long)n,
               times->seconds[n / 2] * 1e3, times->seconds[n - 1 - n / 100] * 1e3, times->seconds[n - 1] * 1e3);
}

/* OpenGL's first row is the lowest. */
int save_picture(const char *path)
{
    static uint8_t pixels[WINDOW_HEIGHT][WINDOW_WIDTH * 3];
    int row;
    FILE *file = fopen(path, "wb");
    if (!file) return complain(path, "cannot be written");
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, WINDOW_WIDTH, WINDOW_HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    fprintf(file, "P6\n%d %d\n255\n", WINDOW_WIDTH, WINDOW_HEIGHT);
    for (row = WINDOW_HEIGHT - 1; row >= 0; row--) fwrite(pixels[row], 1, sizeof pixels[row], file);
    return fclose(file) == 0 || complain(path, "cannot be written");
}

const char usage[] = "usage: engine [--rate BYTES] [--steps N] [--instances N] [--shot VERTICES FILE.ppm]... FILE.cqm\n";

int read_options(struct options *o, char **argument)
{
    for (argument++; *argument; argument++) {
        const int more = argument[1] ? 1 + (argument[2] != NULL) : 0;
        if (!strcmp(*argument, "--rate") && more >= 1) o->rate = strtod(*++argument, NULL);
        else if (!strcmp(*argument, "--steps") && more >= 1) o->steps = (uint32_t)strtoul(*++argument, NULL, 10);
        else if (!strcmp(*argument, "--instances") && more >= 1) o->instances = atoi(*++argument);
        else if (!strcmp(*argument, "--shot") && more == 2 && o->shots < MAX_SHOTS) {
            o->shot[o->shots].vertices = (uint32_t)strtoul(*++argument, NULL, 10);
            o->shot[o->shots++].path = *++argument;
        } else if (!o->path && **argument != '-') o->path = *argument;
        else return 0;
    }
    return o->path && o->steps > 0 && o->instances > 0 && o->instances <= MAX_INSTANCES;
}
