/* platform.h - what the engine wants of SDL2 and OpenGL 3.3. SPDX-License-Identifier: MIT
 *
 * Each function that can fail says why on standard error and returns 0. */
#ifndef PLATFORM_H
#define PLATFORM_H

#include <SDL.h>
#include <epoxy/gl.h>
#include <stdio.h>

#define WINDOW_WIDTH 800
#define WINDOW_HEIGHT 600

/* Opens the window with a context that is current; close it with SDL_Quit. */
SDL_Window *open_window(const char *title);

/* Compiles and uses a program of two shaders; returns it. */
GLuint use_program(const char *vertex_shader, const char *fragment_shader);

double seconds(void);

/* A file whose bytes come at a rate. */
struct reader {
    FILE *file;
    double rate;                  /* bytes a second; 0: as fast as they can be read */
    uint8_t *data;                /* bytes before `arrived` do not change any more */
    int size;
    SDL_atomic_t arrived, ended;
};

SDL_Thread *start_reading(struct reader *r, const char *path, double rate);

/* What the user wants. A shot is a picture at the moment when the mesh has so many vertices; nothing turns if there are
 * any, so that they can be compared. */
#define MAX_INSTANCES 16
#define MAX_SHOTS 8
struct options {
    const char *path;
    double rate;
    uint32_t steps;               /* of a frame, at most */
    int instances;
    int shots, next_shot;
    struct { uint32_t vertices; const char *path; } shot[MAX_SHOTS];
};

extern const char usage[];
int read_options(struct options *o, char **argument);

/* Times of frames, the first MAX_TIMES of them. */
#define MAX_TIMES 100000
struct times {
    size_t count;
    double seconds[MAX_TIMES];
};

void keep_time(struct times *times, double seconds_of_one);
void report_times(const char *what, struct times *times);       /* prints them, and sorts them */

/* Writes what is drawn to a PPM file. */
int save_picture(const char *path);

#endif
