/* cqm.h - what the parts of the command line share. SPDX-License-Identifier: MIT
 *
 *     cqm.c      help, options, main            encode.c   mesh file -> stream
 *     file.c     whole files in and out         decode.c   stream -> mesh file
 *     verify.c   encode, decode, compare        info.c     what a stream holds and what it costs
 *     positions.c   doubles to values of a channel and back
 *     labels.c   materials, groups and objects of faces
 *     words.c    their names as metadata, and back
 *     border.c   keeps the border of a surface
 *     view.c     a decoded mesh as a mesh file
 *     trace.c    what a decoder reads, event by event
 *
 * Each command returns the exit status. A function that can fail reports the error itself and returns 0 or NULL. */
#ifndef CQM_H
#define CQM_H

#include "conquest.h"
#include "../mesh_file.h"

#if CQ_INDEX_BITS != 32
#error "cqm hands the 32-bit indices of mesh_file.h to the codec"
#endif

#define EXIT_BAD_DATA 1
#define EXIT_BAD_USAGE 2

#define KEEP_MATERIALS (1 << MESH_NUM_ATTRIBUTES)

struct options {
    int connectivity, keep_order, lock_border, clean, conquest_only, json, quiet, strict;
    int attributes;                             /* to keep: 1 << MESH_NORMALS and so on, KEEP_MATERIALS */
    cq_goal goal;
    uint32_t bits;                              /* per coordinate; CQ_EXACT_BITS: floats as they are */
    uint32_t attribute_bits[MESH_NUM_ATTRIBUTES];   /* per component; 0: as many as is usual */
    double grid_origin[3], grid_step;           /* of positions; step 0: a grid that fits the mesh */
    uint32_t max_vertices, max_bytes, max_levels;  /* of what is decoded; CQ_NO_LIMIT: all */
    double max_error;                           /* of what is decoded; below 0: none */
    enum mesh_format format;                    /* MESH_UNKNOWN: by the name of the file */
    char **files;
    int num_files;
};

int run_encode(const struct options *options);
int run_decode(const struct options *options);
int run_info(const struct options *options);
int run_verify(const struct options *options);
int run_trace(const struct options *options);

/* -- file.c -------------------------------------------------------------------------------------------------------- */

/* Prints "cqm: PATH: message" to stderr. Returns 0. */
int complain(const char *path, const char *format, ...);

/* Do both paths lead to the same file, which is not "-"? */
int is_same_file(const char *a, const char *b);

/* Standard input and output are for bytes: where the system makes a difference, it is told. */
void set_binary_streams(void);

/* All bytes of a file, or of standard input if the path is "-"; free() them. NULL after a complaint. */
uint8_t *load_file(const char *path, size_t *size);

/* A file that appears under its name only when it is complete: what is written goes to a new file next to it. "-" is
 * standard output; what is not a regular file, like /dev/null, is written directly. */
struct output {
    const char *path;
    char *temporary;      /* name of the new file; NULL if there is none */
    FILE *file;
};

int open_output(struct output *output, const char *path);
int close_output(struct output *output, int is_good);   /* 0, and no file, if it is not or a write has failed */

/* The format that the options or the name of the file tell; complains and returns MESH_UNKNOWN if they do not, or
 * contradict each other. */
enum mesh_format choose_format(const char *path, const struct options *options);

int load_mesh(struct mesh_file *mesh, const char *path, enum mesh_format format);

/* -- encode.c ------------------------------------------------------------------------------------------------------ */

/* An encoded mesh with what it was made from. */
struct encoding {
    cq_input input;                      /* indices belong to the mesh file */
    const double *positions;             /* of the mesh file, too */
    cq_value *values[CQ_MAX_CHANNELS];
    cq_index *materials;
    uint8_t *locked;
    char *words;                         /* the metadata */
    uint8_t *stream;
    size_t size;
    int losses;              /* of what the mesh file has, some is dropped or changed */
    cq_report report;
};

/* Says what is lost, unless the options say --quiet, and counts it. */
void tell_loss(struct encoding *e, const struct options *options, const char *path, const char *format, ...);

/* Expands the mesh: its vertices are then the rows that are encoded. */
int encode_mesh(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options);
void free_encoding(struct encoding *e);

/* A channel with room for its values, all 0. NULL if there is no memory. */
cq_channel *add_channel(struct encoding *e, cq_kind kind, cq_merge merge, int components, uint32_t bits);

/* As few bits as may be for numbers up to this one. */
uint32_t bits_of_number(uint32_t largest);

/* -- labels.c, border.c -------------------------------------------------------------------------------------------- */

/* What faces belong to, and the names; or if these are not wanted, what has none of them. */
int add_labels(struct encoding *e, struct mesh_file *mesh, const char *path, const struct options *options);

/* For --lock-border: the vertices at edges that have one face stay as they are at every level. */
int lock_border(struct encoding *e, const struct mesh_file *mesh, const char *path);

/* -- positions.c --------------------------------------------------------------------------------------------------- */

/* Chooses the grid of the first channel and gives it its values; kind, components, merge and bits are set. */
int add_positions(struct encoding *e, cq_channel *channel, const struct mesh_file *mesh, const char *path,
                  const struct options *options);

/* double[count][3], floats if these are good enough, each finite as a float. NULL: no memory. */
double *reconstruct_positions(const cq_channel *channel, const cq_value *values, size_t count);

/* -- words.c ------------------------------------------------------------------------------------------------------- */

/* What faces may have numbers of, beside materials, which are ranges of faces, or a channel of kind CQ_GROUP if they are more
 * than CQ_MAX_MATERIALS: channels of kind CQ_GENERIC, CQ_PER_FACE, in the order of the words of the line "faces". The metadata of a stream is text, a line for each name:
 *
 *     faces g marks          channels of faces: numbers of groups; marks of mesh_file.h
 *     mtllib scene.mtl       where materials are described
 *     usemtl red             material 0, of all faces if there is no other; 1 is none
 *     g hand                 group 1; 0 is none
 *     o figure               object 1, of which all faces are: it has no channel */
enum face_number { FACE_GROUP = MESH_GROUPS, FACE_OBJECT = MESH_OBJECTS, FACE_MARKS, NUM_FACE_NUMBERS };

/* Has the mesh numbers of this kind that differ from face to face? */
int needs_face_numbers(const struct mesh_file *mesh, int kind);

/* The metadata for a mesh; an empty text if it has none. NULL: no memory. */
char *make_words(const struct mesh_file *mesh);

/* What metadata says. */
struct words {
    int channel[NUM_FACE_NUMBERS];       /* which of the channels of faces has them, from 1; 0: none */
    char *names[MESH_NUM_LABELS], *libraries;    /* as in mesh_file.h; NULL: none */
};

int parse_words(struct words *words, const uint8_t *text, size_t size);
void free_words(struct words *words);

/* -- view.c -------------------------------------------------------------------------------------------------------- */

/* The decoded mesh in arrays of its own. Vertices have the order of their numbers, if the stream has them; faces are
 * sorted by material. Names are there if all is complete. 0: no memory. */
int view_mesh(struct mesh_file *mesh, const cq_decoder *d, int is_complete);

/* Rows and faces, of the mesh and behind them those aside. */
uint32_t count_rows(const cq_decoder *d);
uint32_t count_faces(const cq_decoder *d);

/* Values of all rows, cq_value[rows][components]; indices of all faces, cq_index[3 * faces]. NULL: no memory. */
cq_value *read_rows(const cq_decoder *d, uint32_t k);
cq_index *read_triangles(const cq_decoder *d);
cq_value face_value(const cq_decoder *d, uint32_t k, uint32_t face);
uint32_t face_material(const cq_decoder *d, uint32_t face);    /* 0 without materials */

/* The first channel of a kind, of faces or not; -1 if there is none. */
int find_channel(const cq_shape *shape, cq_kind kind, int per_face);

/* -- decode.c ------------------------------------------------------------------------------------------------------ */

/* A decoder with its memory, ready for the first byte. */
struct decoding {
    cq_decoder decoder;
    void *memory;
    cq_shape shape;          /* as the header says, */
    size_t stream_bytes;     /* and this */
};

/* Prepares for the stream in data; complains if that is none, or goes on behind its end. */
int open_decoding(struct decoding *d, const char *path, const uint8_t *data, size_t size);
void close_decoding(struct decoding *d);

/* The channel of positions whose steps the errors of levels are counted in; NULL: the stream tells no errors. */
const cq_channel *find_measured(const cq_shape *shape);

/* What a channel means, in one word. */
const char *channel_kind_name(const cq_channel *channel);

/* Complains about an error that the decoder met when it had used so many bytes. Returns 0. */
int complain_stream(const char *path, cq_result result, size_t used);

#endif
