/* cqm.c - command line of the conquest mesh codec: help, options, main. SPDX-License-Identifier: MIT
 *
 *     cc -O2 -Iinclude examples/cqm/[a-z]*.c examples/mesh_file.c -o build/cqm -lm */
#define CONQUEST_IMPLEMENTATION
#include "cqm.h"

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
    "\n"
    "  cqm COMMAND --help                   options of a command\n"
    "  cqm --help                           this text\n"
    "  cqm --version                        version of the library\n"
    "\n"
    "Mesh files are OFF, OBJ, PLY and STL, told by the end of the name. They hold\n"
    "triangles only; an edge has one or two faces, which agree on the orientation;\n"
    "the faces around a vertex are one fan; each vertex has a face. Messages number\n"
    "vertices and faces from 0.\n"
    "\n"
    "The file name - is standard input or output. Options end at --, and take their\n"
    "value as the next argument or as --name=value.\n"
    "\n"
    "An output file appears only when it is complete. Exit status: 0 success, 1 bad\n"
    "data or a file that cannot be read or written, 2 bad usage.\n";

static const char encode_help[] =
    "cqm encode [OPTION]... IN OUT.cqm\n"
    "\n"
    "Encodes a mesh file. Decoding gives back the same triangles and, on the grid,\n"
    "the same positions, both in an order of their own.\n"
    "\n"
    "  --bits N           bits per coordinate, 1 to 24, default 12: positions are\n"
    "                     rounded to a uniform grid that begins at the minimum of the\n"
    "                     bounding box and has 2^N points along its longest side;\n"
    "                     32: floats as they are, and then coarse levels keep vertices\n"
    "                     where they are instead of moving them to midpoints\n"
    "  --channels LIST    what to keep beside the triangles, of positions, normals,\n"
    "                     texcoords, colors, materials, with commas; default: all\n"
    "                     that the file has for each vertex, and materials of OBJ.\n"
    "                     What cannot be kept is told. Normals get 2 x 10 bits,\n"
    "                     texture coordinates 2 x 12, colors 8 each; materials are\n"
    "                     numbered, their names are not kept\n"
    "  --connectivity     keep nothing beside the triangles\n"
    "  --keep-order       also keep the order of the vertices\n"
    "  --goal GOAL        balanced (default): features of the surface stay longest;\n"
    "                     best-looking: finer ones too, for 1 to 3 % more bytes;\n"
    "                     smallest: by valences, then by the lengths of edges; on\n"
    "                     most meshes 1 to 2 % fewer bytes, but coarse meshes are\n"
    "                     two to three times as far from the exact one;\n"
    "                     least-connectivity: by valences alone\n"
    "  --fast             decodes twice as fast, from 3 to 12 % more bytes: simpler\n"
    "                     models of connectivity and of positions\n"
    "  --format FORMAT    IN is off, obj, ply or stl, whatever its name\n"
    "  --quiet            do not tell what is dropped; show no progress, which is shown\n"
    "                     only on a terminal anyway\n"
    "  --help             this text\n";

static const char decode_help[] =
    "cqm decode [OPTION]... IN.cqm OUT\n"
    "\n"
    "Decodes a stream to a mesh file, all of it or up to the first of these limits:\n"
    "\n"
    "  --vertices N       until the mesh has N vertices, or as few as it can have\n"
    "  --level N          until N levels are refined; 0 gives the base mesh\n"
    "  --bytes N          with the first N bytes of the stream\n"
    "\n"
    "  --format FORMAT    OUT is off, obj, ply or stl, whatever its name\n"
    "  --quiet            do not warn that a stream has no positions, nor of what the\n"
    "                     format of OUT cannot hold\n"
    "  --help             this text\n"
    "\n"
    "A stream that ends too early gives the mesh that its bytes make, a message and\n"
    "exit status 1; with --bytes, no message and status 0. No mesh is written if not\n"
    "even the base is complete, or if bytes are corrupt or follow the stream's end.\n"
    "Without positions in the stream, all are written as 0 0 0, with a warning; STL\n"
    "would then hold nothing and is refused.\n";

static const char info_help[] =
    "cqm info [OPTION]... IN.cqm\n"
    "\n"
    "Decodes a stream and prints its counts, the size of its parts and a table of its\n"
    "levels, the coarsest first.\n"
    "\n"
    "  --json             print one JSON object; \"bits\" adds up to 8 * \"bytes\"\n"
    "  --help             this text\n";

static const char verify_help[] =
    "cqm verify [OPTION]... IN...\n"
    "\n"
    "Encodes each mesh file, decodes the stream in one piece and in small ones, and\n"
    "compares the triangles and, on their grids, all other numbers. Prints one line\n"
    "per file. Exit status 0: all are equal.\n"
    "\n"
    "  --bits N           as for encode\n"
    "  --channels LIST    as for encode\n"
    "  --connectivity     as for encode\n"
    "  --keep-order       as for encode\n"
    "  --goal GOAL        as for encode\n"
    "  --fast             as for encode\n"
    "  --format FORMAT    each IN is off, obj, ply or stl, whatever its name\n"
    "  --quiet            as for encode\n"
    "  --help             this text\n";

/* -- Commands and their options ------------------------------------------------------------------------------------ */

enum command_id { ENCODE = 1, DECODE = 2, INFO = 4, VERIFY = 8 };

struct command {
    const char *name;
    enum command_id id;
    int (*run)(const struct options *options);
    int min_files, max_files;
    const char *help;
};

static const struct command commands[] = {
    { "encode", ENCODE, run_encode, 2, 2, encode_help },
    { "decode", DECODE, run_decode, 2, 2, decode_help },
    { "info", INFO, run_info, 1, 1, info_help },
    { "verify", VERIFY, run_verify, 1, INT32_MAX, verify_help },
};

enum option_id { BITS, CHANNELS, CONNECTIVITY, KEEP_ORDER, GOAL, FAST, FORMAT, QUIET, VERTICES, LEVEL, BYTES, JSON };

struct option {
    const char *name;
    enum option_id id;
    int has_value;
    int commands;         /* sum of those that take it */
};

static const struct option option_list[] = {
    { "--bits", BITS, 1, ENCODE | VERIFY },
    { "--channels", CHANNELS, 1, ENCODE | VERIFY },
    { "--connectivity", CONNECTIVITY, 0, ENCODE | VERIFY },
    { "--keep-order", KEEP_ORDER, 0, ENCODE | VERIFY },
    { "--goal", GOAL, 1, ENCODE | VERIFY },
    { "--fast", FAST, 0, ENCODE | VERIFY },
    { "--format", FORMAT, 1, ENCODE | DECODE | VERIFY },
    { "--quiet", QUIET, 0, ENCODE | DECODE | VERIFY },
    { "--vertices", VERTICES, 1, DECODE },
    { "--level", LEVEL, 1, DECODE },
    { "--bytes", BYTES, 1, DECODE },
    { "--json", JSON, 0, INFO },
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
        { "balanced", CQ_BALANCED }, { "smallest", CQ_SMALLEST }, { "best-looking", CQ_BEST_LOOKING },
        { "least-connectivity", CQ_LEAST_CONNECTIVITY },
    };
    for (size_t i = 0; i < sizeof goals / sizeof *goals; i++) {
        *goal = goals[i].goal;
        if (strcmp(text, goals[i].name) == 0)
            return 1;
    }
    return 0;
}

static int parse_bits(const char *text, uint32_t *bits)
{
    return parse_uint(text, 1, CQ_EXACT_BITS, bits) && (*bits <= CQ_MAX_BITS || *bits == CQ_EXACT_BITS);
}

/* Names with commas between them; at least one. */
static int parse_channels(const char *text, struct options *options)
{
    static const char *const names[] = { "normals", "texcoords", "colors", "materials", "positions" };
    const int positions = MESH_NUM_ATTRIBUTES + 1;   /* the attributes are first, in the order of their bits */
    int kept = 0;
    for (;;) {
        size_t length = strcspn(text, ",");
        int i = 0;
        while (i <= positions && (strlen(names[i]) != length || memcmp(names[i], text, length) != 0))
            i++;
        if (i > positions)
            return 0;
        kept |= 1 << i;
        text += length;
        if (*text++ == '\0')
            break;
    }
    options->attributes = kept & ((1 << positions) - 1);
    options->connectivity = kept >> positions == 0;
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
    case BITS: return parse_bits(value, &options->bits);
    case CHANNELS: return parse_channels(value, options);
    case KEEP_ORDER: return options->keep_order = 1;
    case VERTICES: return parse_uint(value, 0, CQ_NO_LIMIT - 1, &options->max_vertices);
    case LEVEL: return parse_uint(value, 0, CQ_NO_LIMIT - 1, &options->max_levels);
    case BYTES: return parse_uint(value, 0, CQ_NO_LIMIT - 1, &options->max_bytes);
    case FORMAT: return (options->format = mesh_format_by_name(value)) != MESH_UNKNOWN;
    case CONNECTIVITY: return no_channels(options);
    case GOAL: return parse_goal(value, &options->goal);
    case FAST: return options->fast = 1;
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
        return complain(command->name, "no option '%s'; see --help", arguments[at]);
    char *value = strchr(arguments[at], '=');
    value = value != NULL ? value + 1 : option->has_value ? arguments[++at] : NULL;
    if ((value != NULL) != option->has_value)
        return complain(command->name, "%s takes %s value", option->name, option->has_value ? "a" : "no");
    if (!set_option(options, option->id, value))
        return complain(command->name, "%s cannot be '%s'; see --help", option->name, value);
    return at + 1;
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
        return complain(command->name, "%d file names are too %s; see --help", options->num_files,
                        options->num_files < command->min_files ? "few" : "many");
    return 1;
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
    options.bits = 12;
    options.attributes = KEEP_MATERIALS | (KEEP_MATERIALS - 1);
    options.max_vertices = options.max_bytes = options.max_levels = CQ_NO_LIMIT;
    options.files = arguments;       /* files move to the front: there are never more than arguments seen */
    if (!parse_arguments(&options, command, arguments))
        return EXIT_BAD_USAGE;
    return command->run(&options);
}

int main(int argc, char **argv)
{
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
        complain(argv[1], "no such command; see cqm --help");
        return EXIT_BAD_USAGE;
    }
    return run_command(command, argv + 2);
}
