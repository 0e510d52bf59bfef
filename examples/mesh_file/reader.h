/* reader.h - what the readers of the formats share. SPDX-License-Identifier: MIT
 *
 * Functions that read return 1, or 0 after fail() has written the message, so that steps chain with &&. All numbers go
 * through double, which holds each float, each 32-bit integer and each index exactly. */
#ifndef MESH_FILE_READER_H
#define MESH_FILE_READER_H

#include "../mesh_file.h"

#define WORD_BYTES 64

struct reader {
    const uint8_t *data;
    size_t size;
    size_t at;        /* the next byte */
    size_t item;      /* where the last binary item began */
    size_t line;      /* of `at`, from 1; 0 in binary data, where messages name the byte */
    int comments;     /* text: 1 if # begins a comment (OFF, OBJ) */
    int commas;       /* text: 1 if commas are blanks (OFF) */
    int free_form;    /* text: 1 if numbers may be on the next line */
    int continued;    /* text: 1 if a backslash at the end of a line continues it (OBJ) */
    int lone_cr;      /* text: 1 if a line ends in \r and what follows may be data that begins with \n (PLY) */
    char *error;      /* char[MESH_ERROR_BYTES] */
};

/* A word of the file, up to a blank or the end of its line; length 0 behind the last word of a line. */
struct word {
    const uint8_t *text;
    size_t length;
};

/* -- mesh_file.c --------------------------------------------------------------------------------------------------- */

/* Writes the message and the place; returns 0 for the caller to return. */
int fail(struct reader *r, const char *format, ...);

/* Adds to mesh->notes; a note ends with a line feed of the caller's. */
void note(struct mesh_file *mesh, const char *format, ...);

/* Makes room for a mesh. Callers have checked the counts against the size of the file. */
int allocate(struct reader *r, struct mesh_file *mesh, size_t num_vertices, size_t num_faces);

/* Makes room for an attribute; all NaN, which marks what the file has not said. */
int allocate_attribute(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute, int components);
void drop_attribute(struct mesh_file *mesh, enum mesh_attribute attribute, const char *why, size_t vertex);

/* Coordinate i of the positions. `unit`: of the last digit in the file, 0 for binary numbers. */
int store_coordinate(struct reader *r, struct mesh_file *mesh, size_t i, double value, double unit);
int store_corner(struct reader *r, struct mesh_file *mesh, size_t corner, double vertex);
int check_corners(struct reader *r, size_t face, double corners);

/* As a float, or NaN. */
float attribute_value(double value);

/* Divides colors by 255 if one of them is larger than 1. */
void scale_colors(struct mesh_file *mesh);

int read_off(struct reader *r, struct mesh_file *mesh);
int read_obj(struct reader *r, struct mesh_file *mesh);
int read_ply(struct reader *r, struct mesh_file *mesh);
int read_stl(struct reader *r, struct mesh_file *mesh);

/* -- polygon.c ----------------------------------------------------------------------------------------------------- */

/* Cuts a polygon of 3 corners or more into count - 2 triangles, given by numbers of corners. 0: no memory. */
int triangulate(const double (*corner)[3], size_t count, uint32_t (*triangle)[3]);

/* -- text.c -------------------------------------------------------------------------------------------------------- */

/* Names text that is no UTF-8, and skips a byte order mark. */
int begin_text(struct reader *r);

/* Skips the rest of the line and its end: \n, \r\n or \r. */
void next_line(struct reader *r);

/* Moves to the next word, over line ends and comments; 0 if there is none. */
int seek_word(struct reader *r);

/* The next word of this line. */
struct word take_word(struct reader *r);

/* The rest of this line without blanks at its ends. */
struct word take_rest(struct reader *r);

int word_is(struct word word, const char *text);
int word_is_in_any_case(struct word word, const char *text);
int same_word(struct word a, struct word b);

/* Copies the word for messages: odd bytes become '?', and a word that is too long ends in '~'. Returns text. */
const char *show(char text[WORD_BYTES], struct word word);

/* 1 if all of the word is a decimal number, of any length. `unit` is what its last digit counts, 0.01 in 1.25. No
 * hexadecimal, no "inf", no "nan". */
int parse_number(struct word word, double *value, double *unit);

int take_number(struct reader *r, double *value);
int take_number_and_unit(struct reader *r, double *value, double *unit);

/* Takes x, y, z of a vertex. */
int take_position(struct reader *r, struct mesh_file *mesh, size_t vertex);

/* -- binary numbers ------------------------------------------------------------------------------------------------ */

uint64_t load_bytes(const uint8_t *data, size_t size, int big_endian);
float float_of_bits(uint32_t bits);
double double_of_bits(uint64_t bits);

#endif
