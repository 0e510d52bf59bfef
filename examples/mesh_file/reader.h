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
    uint8_t *converted;   /* what `data` is then: the text as UTF-8, if the file is UTF-16 */
};

/* A word of the file, up to a blank or the end of its line; length 0 behind the last word of a line. */
struct word {
    const uint8_t *text;
    size_t length;
};

/* -- mesh_file.c --------------------------------------------------------------------------------------------------- */

/* Writes the message and the place; returns 0 for the caller to return. */
int fail(struct reader *r, const char *format, ...);

/* Adds to mesh->notes, or mesh->attribute_notes; a note ends with a line feed of the caller's. */
void note(struct mesh_file *mesh, const char *format, ...);
void note_attribute(struct mesh_file *mesh, const char *format, ...);

/* The ending of a word that so many have. */
const char *plural(size_t count);

/* Makes room for vertices. Callers have checked the count against the size of the file. */
int allocate(struct reader *r, struct mesh_file *mesh, size_t num_vertices);

/* Makes room for an attribute of vertices; all NaN, which marks what the file has not said. */
int allocate_attribute(struct reader *r, struct mesh_file *mesh, enum mesh_attribute attribute, int components);

/* Coordinate i of the positions. `unit`: of the last digit in the file, 0 for binary numbers. */
int store_coordinate(struct reader *r, struct mesh_file *mesh, size_t i, double value, double unit);

/* As a float, or NaN. */
float attribute_value(double value);

/* Divides colors by 255 if one of them is larger than 1. */
void scale_colors(struct mesh_file *mesh);

int read_off(struct reader *r, struct mesh_file *mesh);
int read_obj(struct reader *r, struct mesh_file *mesh);
int read_ply(struct reader *r, struct mesh_file *mesh);
int read_stl(struct reader *r, struct mesh_file *mesh);

/* -- faces.c ------------------------------------------------------------------------------------------------------- */

/* Faces as files have them, with any number of corners, until all positions are known. What corners name beside vertices
 * are normals and texture coordinates, or nothing; faces have labels, which readers number as they like, from 1. */
enum { FACE_ITEMS = MESH_TEXCOORDS + 1, FACE_SMOOTHING = MESH_NUM_LABELS, FACE_LABELS };

struct face_corner {
    uint32_t vertex, item[FACE_ITEMS];
};

struct face {
    uint32_t end;                      /* of its corners, from those of the face before on */
    uint32_t label[FACE_LABELS];
};

struct faces {
    struct face_corner *corner;
    struct face *face;
    size_t num_corners, num_faces, corner_room, face_room;
    uint32_t label[FACE_LABELS];       /* of the faces that follow */
    struct face_corner next;           /* what the corner that follows has beside a vertex */
    int has_items[FACE_ITEMS];         /* 1 if corners may have them */
};

void begin_faces(struct faces *faces);

/* A corner of the face that end_face() ends. */
int add_corner(struct reader *r, const struct mesh_file *mesh, struct faces *faces, double vertex);
int end_face(struct reader *r, struct faces *faces);

/* Cuts all faces into triangles and stores them, their labels and what their corners name. If wants_normals is set
 * and a face has a smoothing group, it also makes normals, which are continuous where faces of the same group meet; group
 * 0 is flat. */
int store_faces(struct reader *r, struct mesh_file *mesh, const struct faces *faces, int wants_normals);

void free_faces(struct faces *faces);

/* -- labels.c ------------------------------------------------------------------------------------------------------ */

/* Names that a file gives, in its order, and more than once. */
struct label_names {
    struct word *name;                 /* no text: the number in `length` is the name */
    size_t count, room;
};

int add_label_name(struct reader *r, struct label_names *names, struct word name);

/* From labels that are places in `names`, counted from 1, to numbers in the order in which faces first have them. */
int store_labels(struct reader *r, struct mesh_file *mesh, enum mesh_label label, const struct label_names *names);

/* Adds a line to text that may be NULL. */
int add_line(struct reader *r, char **text, struct word line);

/* -- polygon.c ----------------------------------------------------------------------------------------------------- */

/* Cuts a polygon of 3 corners or more into count - 2 triangles, given by numbers of corners. 0: no memory; 1: they may
 * overlap, since there are too many corners to find better ones; 2: else. */
int triangulate(const double (*corner)[3], size_t count, uint32_t (*triangle)[3]);

/* -- text.c -------------------------------------------------------------------------------------------------------- */

/* Goes to the start, behind a byte order mark; of UTF-16 text makes UTF-8. */
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
