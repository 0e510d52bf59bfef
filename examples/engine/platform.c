/* platform.c - SDL2 and OpenGL 3.3 for the engine. SPDX-License-Identifier: MIT */
#include "platform.h"

#include <stdio.h>
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
