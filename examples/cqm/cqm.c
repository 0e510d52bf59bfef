/* cqm.c - command line of the conquest mesh codec: help, options, main. SPDX-License-Identifier: MIT
 *
 *     cc -O2 -Iinclude examples/cqm/[a-z]*.c examples/mesh_file/[a-z]*.c -o build/cqm -lm */
#define CONQUEST_IMPLEMENTATION
#include "cqm.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- Help ---------------------------------------------------------------------------------------------------------- */

static const char main_help[] =
    "Progressive to lossless coding of triangle meshes.\n"
    "\n"
    "  cqm encode [OPTION]... IN OUT.cqm    mesh file to stream\n"
    "  cqm decode [OPTION]... IN.cqm OUT    stream, or the start of one, to mesh file\n"
    "  cqm info [OPTION]... IN.cqm          what a stream holds and what it costs\n"
    "  cqm verify [OPTION]... IN...         encode, decode, compare\n"
    "  cqm trace IN.cqm                     what a decoder reads, for those who write one\n"
    "\n"
    "  cqm COMMAND --help                   options of a command\n"
    "  cqm --help                           this text\n"
    "  cqm --version                        version of the library\n"
    "\n"
    "Mesh files are OFF, OBJ, PLY and STL, told by the end of the name. Any faces\n"
    "will do: polygons are cut into triangles, vertices may have other normals or\n"
    "texture coordinates in each face, and what is no surface is carried beside it.\n"
    "Messages number vertices and faces from 0.\n"
    "\n"
    "The file name - is standard input or output. Options end at --, and take their\n"
    "value as the next argument or as --name=value.\n"
    "\n"
    "An output file appears only when it is complete. Exit status: 0 success, 1 bad\n"
    "data or a file that cannot be read or written, 2 bad usage.\n";

static const char encode_help[] =
    "cqm encode [OPTION]... IN OUT.cqm\n"
    "\n"
    "Encodes a mesh file. Decoding gives back the same triangles, with all that their\n"
    "corners have, on the grid, in an order of their own. One line says what is no\n"
    "surface (repeated faces, faces without area, unused vertices) and where the\n"
    "surface had to be cut for coarser meshes; nothing of that is lost.\n"
    "\n"
    "  --bits N           bits per coordinate, 1 to 24, default 12: positions are\n"
    "                     rounded to a uniform grid that begins at the minimum of the\n"
    "                     bounding box and has 2^N points along its longest side;\n"
    "                     32: as 32-bit floats, far from the origin behind an origin\n"
    "                     of their own; coarse meshes are then made by valences alone,\n"
    "                     and their errors are not known. What floats cannot hold\n"
    "                     (doubles) is told, with the distance\n"
    "  --bits LIST        the same for several channels: normals=N, texcoords=N,\n"
    "                     colors=N, positions=N, with commas; default: normals=10,\n"
    "                     texcoords=12, colors=8\n"
    "  --grid X,Y,Z,STEP  round positions to the grid that begins at X,Y,Z and has\n"
    "                     points STEP apart, as many as the mesh needs, at most 2^24\n"
    "                     along an axis: tiles that share a grid meet without cracks\n"
    "  --channels LIST    what to keep beside the triangles, of positions, normals,\n"
    "                     texcoords, colors, materials, with commas; default: all\n"
    "                     that the file has. What cannot be kept is told. With the\n"
    "                     materials go groups and objects, and the names of all three.\n"
    "                     Smoothing groups become normals where a file has none\n"
    "  --connectivity     keep nothing beside the triangles\n"
    "  --keep-order       also keep the order of the vertices: those at the same place\n"
    "                     are then several, where the surface may open\n"
    "  --lock-border      keep the vertices at the border of the surface at every level,\n"
    "                     for tiles: with one --grid they meet without cracks\n"
    "  --clean            along seams only whole edges collapse, so that no row of the\n"
    "                     vertex buffers ever moves; the base is larger\n"
    "  --conquest-only    no regular levels, for devices whose decoder has been built\n"
    "                     without them\n"
    "  --goal GOAL        balanced (default): features of the surface stay longest;\n"
    "                     least-connectivity: by valences alone\n"
    "  --format FORMAT    IN is off, obj, ply or stl, for names that do not tell\n"
    "  --strict           exit with status 1, and write nothing, if part of the file is\n"
    "                     dropped or changed, other than by rounding to --bits\n"
    "  --quiet            do not tell what is dropped or changed; show no progress,\n"
    "                     which is shown only on a terminal anyway\n"
    "  --help             this text\n";

static const char decode_help[] =
    "cqm decode [OPTION]... IN.cqm OUT\n"
    "\n"
    "Decodes a stream to a mesh file, all of it or up to the first of these limits:\n"
    "\n"
    "  --vertices N       until the mesh has N vertices, or as few as it can have\n"
    "  --level N          until N levels are refined; 0 gives the base mesh\n"
    "  --error E          until no vertex of the exact mesh is further than E from the\n"
    "                     decoded one, in the unit of its coordinates; looked at before\n"
    "                     each level\n"
    "  --bytes N          with the first N bytes of the stream\n"
    "\n"
    "  --format FORMAT    OUT is off, obj, ply or stl, for names that do not tell\n"
    "  --strict           exit with status 1, and write nothing, if OUT cannot hold\n"
    "                     everything that the stream does\n"
    "  --quiet            do not warn that a stream has no positions, nor of what the\n"
    "                     format of OUT cannot hold\n"
    "  --help             this text\n"
    "\n"
    "A stream that ends too early gives the mesh that its bytes make, a message and\n"
    "exit status 1; with --bytes, no message and status 0. No mesh is written if no\n"
    "component of the base is complete, or if bytes are corrupt or follow the stream's end.\n"
    "Without positions in the stream, all are written as 0 0 0, with a warning; STL\n"
    "would then hold nothing and is refused. Names, unused vertices and faces that are\n"
    "no surface come with the last bytes.\n";

static const char info_help[] =
    "cqm info [OPTION]... IN.cqm\n"
    "\n"
    "Decodes a stream and prints its counts, the size of its parts and a table of its\n"
    "levels, the coarsest first. The error is that of the mesh before the level: how\n"
    "far a vertex of the exact mesh is from it at most, in steps of the grid; after\n"
    "the last level it is 0. Of a stream that ends too early it prints what it holds\n"
    "so far, with a message and exit status 1.\n"
    "\n"
    "  --json             print one JSON object; \"bits\" adds up to 8 * \"bytes\"\n"
    "  --help             this text\n";

static const char verify_help[] =
    "cqm verify [OPTION]... IN...\n"
    "\n"
    "Encodes each mesh file, decodes the stream in one piece and in small ones, and\n"
    "compares all triangles with all that their corners and faces have, as often as\n"
    "each occurs, unused vertices, names, and positions with those of the file. Prints\n"
    "one line per file. Exit status 0: all are equal.\n"
    "\n"
    "  --bits N or LIST   as for encode\n"
    "  --channels LIST    as for encode\n"
    "  --connectivity     as for encode\n"
    "  --keep-order       as for encode\n"
    "  --lock-border      as for encode\n"
    "  --clean            as for encode\n"
    "  --conquest-only    as for encode\n"
    "  --goal GOAL        as for encode\n"
    "  --grid X,Y,Z,STEP  as for encode\n"
    "  --format FORMAT    each IN is off, obj, ply or stl, for names that do not tell\n"
    "  --strict           as for encode\n"
    "  --quiet            as for encode\n"
    "  --help             this text\n";

static const char trace_help[] =
    "cqm trace IN.cqm\n"
    "\n"
    "Decodes a stream, or the start of one, and prints a line for each event, in the\n"
    "order of the stream and in the words of SPEC.md: what was read, to be compared\n"
    "with what another decoder has read. Of a stream with an error it prints what\n"
    "comes before it, and the error as cqm decode does, with exit status 1. Nothing is\n"
    "told of rows and faces aside, and of metadata.\n"
    "\n"
    "  material M T       the next triangle of material M is T: its first one, and\n"
    "                     those that are made next\n"
    "  triangle A B C     vertices of another triangle of the base; virtual vertices\n"
    "                     have the numbers from that of all vertices on\n"
    "  component V F M    has all its triangles: vertices and triangles so far; M: 1 if\n"
    "                     another component follows\n"
    "  values K N X...    of channel K, of vertex or row N\n"
    "  face K F X         value of channel K of triangle F\n"
    "  row R V            a new row, of vertex V\n"
    "  corner V R         the row of a corner at vertex V, where it was read\n"
    "  level N R E        begins; R: is it regular; E: code of its error\n"
    "  patch C L S        is conquered: centre, first vertex of the ring; S: 0 not\n"
    "                     split, 1 split, 2 passed over\n"
    "  split B P Q        new vertex, p and q\n"
    "  mark V A B         of a regular level: new vertex, and the edge that gets it\n"
    "  pattern F S        of a triangle with several marks: side of its hub; 3: none\n"
    "  dissolved A B      ends of an edge\n"
    "  insertion V A B    new vertex, ends of its edge\n"
    "  flip A B           ends of an edge, the lower number first\n"
    "  end N V F          levels, vertices, triangles\n"
    "\n"
    "  --help             this text\n";

/* -- Commands and their options ------------------------------------------------------------------------------------ */

enum command_id { ENCODE = 1, DECODE = 2, INFO = 4, VERIFY = 8, TRACE = 16 };

struct command {
    const char *name;
    enum command_id id;
    int (*run)(const struct options *options);
    int min_files, max_files;
    const char *files;
    const char *help;
};

static const struct command commands[] = {
    { "encode", ENCODE, run_encode, 2, 2, "two files, IN and OUT.cqm", encode_help },
    { "decode", DECODE, run_decode, 2, 2, "two files, IN.cqm and OUT", decode_help },
    { "info", INFO, run_info, 1, 1, "one file, IN.cqm", info_help },
    { "verify", VERIFY, run_verify, 1, INT32_MAX, "at least one file, IN", verify_help },
    { "trace", TRACE, run_trace, 1, 1, "one file, IN.cqm", trace_help },
};

enum option_id {
    BITS, CHANNELS, CONNECTIVITY, KEEP_ORDER, LOCK_BORDER, CLEAN, CONQUEST_ONLY, GOAL, GRID, FORMAT, STRICT, QUIET, VERTICES, LEVEL,
    ERROR, BYTES, JSON
};

#define NUMBERS "a number up to 4294967294"

struct option {
    const char *name;
    enum option_id id;
    const char *values;   /* what it takes; NULL: nothing */
    int commands;         /* sum of those that take it */
};

static const struct option option_list[] = {
    { "--bits", BITS, "1 to 24 or 32, or a list of positions=, normals=, texcoords=, colors= with 1 to 24 (normals: 2 to 24; "
      "positions: also 32)", ENCODE | VERIFY },
    { "--channels", CHANNELS, "a list of positions, normals, texcoords, colors, materials", ENCODE | VERIFY },
    { "--connectivity", CONNECTIVITY, NULL, ENCODE | VERIFY },
    { "--keep-order", KEEP_ORDER, NULL, ENCODE | VERIFY },
    { "--lock-border", LOCK_BORDER, NULL, ENCODE | VERIFY },
    { "--clean", CLEAN, NULL, ENCODE | VERIFY },
    { "--conquest-only", CONQUEST_ONLY, NULL, ENCODE | VERIFY },
    { "--goal", GOAL, "balanced or least-connectivity", ENCODE | VERIFY },
    { "--grid", GRID, "X,Y,Z,STEP: an origin and a step above 0", ENCODE | VERIFY },
    { "--format", FORMAT, "off, obj, ply or stl", ENCODE | DECODE | VERIFY },
    { "--strict", STRICT, NULL, ENCODE | DECODE | VERIFY },
    { "--quiet", QUIET, NULL, ENCODE | DECODE | VERIFY },
    { "--vertices", VERTICES, NUMBERS, DECODE },
    { "--level", LEVEL, NUMBERS, DECODE },
    { "--error", ERROR, "a distance, 0 or more", DECODE },
    { "--bytes", BYTES, NUMBERS, DECODE },
    { "--json", JSON, NULL, INFO },
};

static const struct command *find_command(const char *name)
{
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (strcmp(name, commands[i].name) == 0)
            return &commands[i];
    return NULL;
}

/* The option in "--name" or "--name=value" that the command takes; NULL if there is none. */
static const struct option *find_option(const struct command *command, const char *argument)
{
    size_t length = strcspn(argument, "=");
    for (size_t i = 0; i < sizeof option_list / sizeof *option_list; i++) {
        const struct option *o = &option_list[i];
        if (strlen(o->name) == length && memcmp(o->name, argument, length) == 0 && (o->commands & (int)command->id))
            return o;
    }
    return NULL;
}

/* -- Parsing ------------------------------------------------------------------------------------------------------- */

#define ITEM_BYTES 64

/* Digits only; 0 unless low <= number <= high. */
static int parse_uint(const char *text, uint32_t low, uint32_t high, uint32_t *number)
{
    uint64_t value = 0;
    if (*text == '\0')
        return 0;
    for (; *text != '\0'; text++) {
        if (*text < '0' || *text > '9' || value > high)
            return 0;
        value = 10 * value + (uint64_t)(*text - '0');
    }
    *number = (uint32_t)value;
    return value >= low && value <= high;
}

static int parse_goal(const char *text, cq_goal *goal)
{
    static const struct { const char *name; cq_goal goal; } goals[] = {
        { "balanced", CQ_BALANCED }, { "least-connectivity", CQ_LEAST_CONNECTIVITY },
    };
    for (size_t i = 0; i < sizeof goals / sizeof *goals; i++) {
        *goal = goals[i].goal;
        if (strcmp(text, goals[i].name) == 0)
            return 1;
    }
    return 0;
}

/* The names of --channels and --bits: attributes in the order of their bits. */
static const char *const channel_names[] = { "normals", "texcoords", "colors", "materials", "positions" };
enum { MATERIALS = MESH_NUM_ATTRIBUTES, POSITIONS, NUM_CHANNEL_NAMES };

/* Which channel has this name; NUM_CHANNEL_NAMES if none has. */
static int find_channel_name(const char *text, size_t length)
{
    int i = 0;
    while (i < NUM_CHANNEL_NAMES && (strlen(channel_names[i]) != length || memcmp(channel_names[i], text, length) != 0))
        i++;
    return i;
}

/* Takes the text up to a comma or its end into `item`; returns what follows, or NULL at the end. */
static const char *cut_item(const char *text, char item[ITEM_BYTES])
{
    size_t length = strcspn(text, ",");
    snprintf(item, ITEM_BYTES, "%.*s", (int)(length < ITEM_BYTES ? length : ITEM_BYTES - 1), text);
    return text[length] == ',' ? text + length + 1 : NULL;
}

/* "N" or "NAME=N". */
static int parse_bits_item(const char *item, struct options *options)
{
    const char *number = strchr(item, '=');
    int channel = number != NULL ? find_channel_name(item, (size_t)(number - item)) : POSITIONS;
    number = number != NULL ? number + 1 : item;
    if (channel == POSITIONS)
        return parse_uint(number, 1, CQ_EXACT_BITS, &options->bits)
               && (options->bits <= CQ_MAX_BITS || options->bits == CQ_EXACT_BITS);
    return channel < MESH_NUM_ATTRIBUTES
           && parse_uint(number, channel == MESH_NORMALS ? 2 : 1, CQ_MAX_BITS, &options->attribute_bits[channel]);
}

static int parse_bits(const char *text, struct options *options)
{
    char item[ITEM_BYTES];
    while (text != NULL) {
        text = cut_item(text, item);
        if (!parse_bits_item(item, options))
            return 0;
    }
    return 1;
}

/* Three coordinates and a step, as numbers of the "C" locale that floats can hold. */
static int parse_grid(const char *text, struct options *options)
{
    char item[ITEM_BYTES], *end;
    double number[4];
    for (int i = 0; i < 4; i++) {
        if (text == NULL)
            return 0;
        text = cut_item(text, item);
        number[i] = strtod(item, &end);
        if (end == item || *end != '\0' || !(fabs(number[i]) <= (double)FLT_MAX))
            return 0;
    }
    memcpy(options->grid_origin, number, sizeof options->grid_origin);
    options->grid_step = number[3];
    return text == NULL && number[3] >= (double)FLT_MIN;
}

/* A number of the "C" locale that is not negative. */
static int parse_distance(const char *text, double *distance)
{
    char *end;
    *distance = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*distance) && *distance >= 0;
}

/* Names with commas between them; at least one. */
static int parse_channels(const char *text, struct options *options)
{
    int kept = 0;
    while (text != NULL) {
        char item[ITEM_BYTES];
        text = cut_item(text, item);
        int channel = find_channel_name(item, strlen(item));
        if (channel == NUM_CHANNEL_NAMES)
            return 0;
        kept |= 1 << channel;
    }
    options->attributes = kept & ((1 << POSITIONS) - 1);
    options->connectivity = kept >> POSITIONS == 0;
    return 1;
}

static int no_channels(struct options *options)
{
    options->attributes = 0;
    return options->connectivity = 1;
}

/* 0 if the value is not one for this option. */
static int set_option(struct options *options, enum option_id id, const char *value)
{
    switch (id) {
    case BITS: return parse_bits(value, options);
    case CHANNELS: return parse_channels(value, options);
    case KEEP_ORDER: return options->keep_order = 1;
    case LOCK_BORDER: return options->lock_border = 1;
    case CLEAN: return options->clean = 1;
    case CONQUEST_ONLY: return options->conquest_only = 1;
    case VERTICES: return parse_uint(value, 0, CQ_NO_LIMIT - 1, &options->max_vertices);
    case LEVEL: return parse_uint(value, 0, CQ_NO_LIMIT - 1, &options->max_levels);
    case ERROR: return parse_distance(value, &options->max_error);
    case BYTES: return parse_uint(value, 0, CQ_NO_LIMIT - 1, &options->max_bytes);
    case FORMAT: return (options->format = mesh_format_by_name(value)) != MESH_UNKNOWN;
    case CONNECTIVITY: return no_channels(options);
    case GOAL: return parse_goal(value, &options->goal);
    case GRID: return parse_grid(value, options);
    case STRICT: return options->strict = 1;
    case QUIET: return options->quiet = 1;
    case JSON: return options->json = 1;
    }
    return 0;
}

/* Takes the option at argument `at`, with its value there or in the next one. Returns the next argument, or 0. */
static int take_option(struct options *options, const struct command *command, int at, char **arguments)
{
    const struct option *option = find_option(command, arguments[at]);
    if (option == NULL)
        return complain(command->name, "unknown option '%s'; see cqm %s --help", arguments[at], command->name);
    char *value = strchr(arguments[at], '=');
    value = value != NULL ? value + 1 : option->values != NULL ? arguments[++at] : NULL;
    if (option->values == NULL && value != NULL)
        return complain(command->name, "%s takes no value", option->name);
    if (option->values != NULL && value == NULL)
        return complain(command->name, "%s needs a value: %s", option->name, option->values);
    if (!set_option(options, option->id, value))
        return complain(command->name, "%s cannot be '%s'; it takes %s", option->name, value, option->values);
    return at + 1;
}

/* What no option can tell by itself. */
static int check_options(const struct options *options, const struct command *command)
{
    if (options->grid_step > 0 && options->bits != 0)
        return complain(command->name, "--grid decides how many bits positions have; leave out --bits for them");
    if (command->max_files == 2 && is_same_file(options->files[0], options->files[1]))
        return complain(command->name, "'%s' and '%s' are the same file", options->files[0], options->files[1]);
    return 1;
}

/* Sorts the arguments, which end with NULL, into options and files; 0 after a complaint. */
static int parse_arguments(struct options *options, const struct command *command, char **arguments)
{
    int at = 0, only_files = 0;
    while (arguments[at] != NULL) {
        char *argument = arguments[at];
        if (only_files || argument[0] != '-' || argument[1] == '\0')
            options->files[options->num_files++] = arguments[at++];
        else if (strcmp(argument, "--") == 0)
            only_files = ++at;
        else if ((at = take_option(options, command, at, arguments)) == 0)
            return 0;
    }
    if (options->num_files < command->min_files || options->num_files > command->max_files)
        return complain(command->name, "takes %s, but got %d; see cqm %s --help", command->files, options->num_files,
                        command->name);
    return check_options(options, command);
}

/* -- Main ---------------------------------------------------------------------------------------------------------- */

static int print(const char *text)
{
    fputs(text, stdout);
    return fflush(stdout) == 0 || complain("-", "cannot write") ? 0 : EXIT_BAD_DATA;
}

static int asks_for_help(char **arguments)
{
    for (; *arguments != NULL && strcmp(*arguments, "--") != 0; arguments++)
        if (strcmp(*arguments, "--help") == 0 || strcmp(*arguments, "-h") == 0)
            return 1;
    return 0;
}

static int run_command(const struct command *command, char **arguments)
{
    struct options options = { 0 };
    options.attributes = KEEP_MATERIALS | (KEEP_MATERIALS - 1);
    options.max_vertices = options.max_bytes = options.max_levels = CQ_NO_LIMIT;
    options.max_error = -1;
    options.files = arguments;       /* files move to the front: there are never more than arguments seen */
    if (!parse_arguments(&options, command, arguments))
        return EXIT_BAD_USAGE;
    if (options.bits == 0)
        options.bits = 12;
    return command->run(&options);
}

int main(int argc, char **argv)
{
    set_binary_streams();
    if (argc < 2) {
        fputs(main_help, stderr);
        return EXIT_BAD_USAGE;
    }
    if (strcmp(argv[1], "--version") == 0)
        return print("cqm " CQ_VERSION_STRING "\n");
    const struct command *command = find_command(argv[1]);
    if (asks_for_help(argv + 1))
        return print(command != NULL ? command->help : main_help);
    if (command == NULL) {
        complain(argv[1], "unknown command; see cqm --help");
        return EXIT_BAD_USAGE;
    }
    return run_command(command, argv + 2);
}
