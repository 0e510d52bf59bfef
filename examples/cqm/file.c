/* file.c - whole files in and out. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "cqm.h"

#ifdef _WIN32
#include <io.h>
#define lstat stat           /* no symbolic links */
#else
#define O_BINARY 0
#endif

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int complain(const char *path, const char *format, ...)
{
    va_list arguments;
    fprintf(stderr, "cqm: %s: ", path);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    return 0;
}

/* -- The system -------------------------------------------------------------------------------------------------- */

void set_binary_streams(void)
{
#ifdef _WIN32
    _setmode(_fileno(stdin), _O_BINARY);
    _setmode(_fileno(stdout), _O_BINARY);
#endif
}

/* Where the system numbers files, other names of the same one are found out, too. */
int is_same_file(const char *a, const char *b)
{
    struct stat s, t;
    if (strcmp(a, "-") == 0 || strcmp(b, "-") == 0)
        return 0;
    return strcmp(a, b) == 0 || (stat(a, &s) == 0 && stat(b, &t) == 0 && S_ISREG(s.st_mode) && s.st_ino != 0
                                 && s.st_ino == t.st_ino && s.st_dev == t.st_dev);
}

/* Renames a file to a name that another one may have, which not every system does in one step. */
static int replace_file(const char *from, const char *to)
{
#ifdef _WIN32
    remove(to);
#endif
    return rename(from, to) == 0;
}

/* -- Input --------------------------------------------------------------------------------------------------------- */

/* Reads to the end; the size need not be known, so that pipes work. */
static uint8_t *read_all(FILE *file, const char *path, size_t *size)
{
    size_t capacity = 1 << 16, got;
    uint8_t *data = malloc(capacity), *larger = data;
    *size = 0;
    while (larger != NULL && (got = fread(data + *size, 1, capacity - *size, file)) > 0) {
        *size += got;
        if (*size == capacity && (larger = realloc(data, capacity *= 2)) != NULL)
            data = larger;
    }
    if (larger != NULL && !ferror(file))
        return data;
    complain(path, "%s", larger == NULL ? "out of memory" : strerror(errno));
    free(data);
    return NULL;
}

uint8_t *load_file(const char *path, size_t *size)
{
    if (strcmp(path, "-") == 0)
        return read_all(stdin, path, size);
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        complain(path, "%s", strerror(errno));
        return NULL;
    }
    uint8_t *data = read_all(file, path, size);
    fclose(file);
    return data;
}

enum mesh_format choose_format(const char *path, const struct options *options)
{
    enum mesh_format by_name = mesh_format_of_path(path), by_option = options->format;
    if (by_name == MESH_UNKNOWN && by_option == MESH_UNKNOWN)
        complain(path, "unknown format: the name does not end in .off, .obj, .ply or .stl; use --format");
    if (by_name == MESH_UNKNOWN || by_option == MESH_UNKNOWN || by_name == by_option)
        return by_name == MESH_UNKNOWN ? by_option : by_name;
    complain(path, "--format says %s, but the name ends in .%s", mesh_format_name(by_option), mesh_format_name(by_name));
    return MESH_UNKNOWN;
}

int load_mesh(struct mesh_file *mesh, const char *path, enum mesh_format format)
{
    char error[MESH_ERROR_BYTES];
    size_t size;
    uint8_t *data = load_file(path, &size);
    if (data == NULL)
        return 0;
    int ok = mesh_read(mesh, data, size, format, error) || complain(path, "%s", error);
    free(data);
    return ok;
}

/* -- Output -------------------------------------------------------------------------------------------------------- */

/* 1 if a new file may take the place of what is there now. */
static int is_replaceable(const char *path)
{
    struct stat status;
    return lstat(path, &status) != 0 || S_ISREG(status.st_mode);
}

/* Creates "PATH.PID.part", which must be new. */
static FILE *create_temporary(struct output *output)
{
    size_t size = strlen(output->path) + 32;
    output->temporary = malloc(size);
    if (output->temporary == NULL)
        return NULL;
    snprintf(output->temporary, size, "%s.%ld.part", output->path, (long)getpid());
    int descriptor = open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_BINARY, 0666);
    return descriptor < 0 ? NULL : fdopen(descriptor, "wb");
}

int open_output(struct output *output, const char *path)
{
    output->path = path;
    output->temporary = NULL;
    if (strcmp(path, "-") == 0)
        output->file = stdout;
    else if (is_replaceable(path))
        output->file = create_temporary(output);
    else
        output->file = fopen(path, "wb");
    if (output->file != NULL)
        return 1;
    complain(path, "%s", strerror(errno));
    free(output->temporary);
    return 0;
}

int close_output(struct output *output, int is_good)
{
    int ok = fflush(output->file) == 0 && !ferror(output->file);
    if (output->file != stdout)
        ok = fclose(output->file) == 0 && ok;
    if (ok && is_good && output->temporary != NULL)
        ok = replace_file(output->temporary, output->path);
    if (!ok)
        complain(output->path, "cannot write: %s", strerror(errno));
    if ((!ok || !is_good) && output->temporary != NULL)
        remove(output->temporary);
    free(output->temporary);
    return ok && is_good;
}
