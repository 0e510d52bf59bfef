/* platform.h - what the engine wants of SDL2 and OpenGL 3.3. SPDX-License-Identifier: MIT
 *
 * Each function that can fail says why on standard error and returns 0. */
#ifndef PLATFORM_H
#define PLATFORM_H

#include <SDL.h>
#include <epoxy/gl.h>

#define WINDOW_WIDTH 800
#define WINDOW_HEIGHT 600

/* Opens the window with a context that is current; close it with SDL_Quit. */
SDL_Window *open_window(const char *title);

/* Compiles and uses a program of two shaders; returns it. */
GLuint use_program(const char *vertex_shader, const char *fragment_shader);

double seconds(void);

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
