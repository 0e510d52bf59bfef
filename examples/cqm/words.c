/* words.c - names of materials, groups, objects and libraries as metadata, and back. SPDX-License-Identifier: MIT */
#include "cqm.h"

#include <stdlib.h>
#include <string.h>

static const char *const label_words[MESH_NUM_LABELS] = { "usemtl", "g", "o" };
static const char *const face_words[NUM_FACE_NUMBERS] = { "", "g", "o", "marks" };

/* -- Making -------------------------------------------------------------------------------------------------------- */

static int has_marks(const struct mesh_file *mesh)
{
    for (size_t f = 0; f < mesh->num_faces && mesh->marks != NULL; f++)
        if (mesh->marks[f] != 0)
            return 1;
    return 0;
}

int needs_face_numbers(const struct mesh_file *mesh, int kind)
{
    if (kind == FACE_MARKS)
        return has_marks(mesh);
    const uint32_t *of_face = mesh->label[kind].of_face;
    for (size_t f = 0; f < mesh->num_faces && of_face != NULL; f++)
        if (of_face[f] != of_face[0])
            return 1;
    return 0;
}

/* Adds to text that grows; 0: no memory. */
static int add_text(char **text, size_t *size, const char *more, size_t length)
{
    char *longer = realloc(*text, *size + length + 1);
    if (longer == NULL)
        return 0;
    memcpy(longer + *size, more, length);
    longer[*size += length] = '\0';
    *text = longer;
    return 1;
}

static int add_lines(char **text, size_t *size, const char *word, const char *lines)
{
    int ok = 1;
    for (const char *end; lines != NULL && ok && (end = strchr(lines, '\n')) != NULL; lines = end + 1)
        ok = add_text(text, size, word, strlen(word)) && (end == lines || add_text(text, size, " ", 1))
             && add_text(text, size, lines, (size_t)(end - lines) + 1);
    return ok;
}

static int add_face_line(char **text, size_t *size, const struct mesh_file *mesh)
{
    int ok = 1, count = 0;
    for (int kind = FACE_GROUP; kind < NUM_FACE_NUMBERS && ok; kind++)
        if (needs_face_numbers(mesh, kind))
            ok = (count++ > 0 || add_text(text, size, "faces", 5)) && add_text(text, size, " ", 1)
                 && add_text(text, size, face_words[kind], strlen(face_words[kind]));
    return ok && (count == 0 || add_text(text, size, "\n", 1));
}

char *make_words(const struct mesh_file *mesh)
{
    char *text = NULL;
    size_t size = 0;
    int ok = add_text(&text, &size, "", 0) && add_face_line(&text, &size, mesh)
             && add_lines(&text, &size, "mtllib", mesh->libraries);
    for (int k = 0; k < MESH_NUM_LABELS && ok; k++)
        ok = add_lines(&text, &size, label_words[k], mesh->label[k].names);
    if (!ok)
        free(text);
    return ok ? text : NULL;
}

/* -- Reading: any bytes -------------------------------------------------------------------------------------------- */

struct line {
    const char *text;
    size_t length;
};

/* Takes a word and a blank off the line if it begins so. */
static int take(struct line *line, const char *word)
{
    size_t length = strlen(word);
    if (line->length < length || memcmp(line->text, word, length) != 0
            || (line->length > length && line->text[length] != ' '))
        return 0;
    length += line->length > length;
    line->text += length;
    line->length -= length;
    return 1;
}

static int add_name(char **names, struct line name)
{
    size_t size = *names != NULL ? strlen(*names) : 0;
    return add_text(names, &size, name.text, name.length) && add_text(names, &size, "\n", 1);
}

static void parse_faces(struct words *words, struct line line)
{
    for (int channel = 1; line.length > 0; channel++) {
        int kind = FACE_GROUP;
        while (kind < NUM_FACE_NUMBERS && !take(&line, face_words[kind]))
            kind++;
        if (kind == NUM_FACE_NUMBERS)
            return;
        words->channel[kind] = channel;
    }
}

static int parse_line(struct words *words, struct line line)
{
    if (take(&line, "faces"))
        parse_faces(words, line);
    else if (take(&line, "mtllib"))
        return add_name(&words->libraries, line);
    else
        for (int k = 0; k < MESH_NUM_LABELS; k++)
            if (take(&line, label_words[k]))
                return add_name(&words->names[k], line);
    return 1;
}

/* Control characters, which no name has, would break the lines of a mesh file. */
int parse_words(struct words *words, const uint8_t *text, size_t size)
{
    char *copy = malloc(size + 1);
    int ok = copy != NULL;
    memset(words, 0, sizeof *words);
    for (size_t i = 0; i < size && ok; i++)
        copy[i] = text[i] == '\0' || text[i] == '\r' ? '?' : (char)text[i];
    for (size_t at = 0, end; at < size && ok; at = end + 1) {
        for (end = at; end < size && copy[end] != '\n';)
            end++;
        struct line line = { copy + at, end - at };
        ok = parse_line(words, line);
    }
    free(copy);
    return ok;
}

void free_words(struct words *words)
{
    for (int k = 0; k < MESH_NUM_LABELS; k++)
        free(words->names[k]);
    free(words->libraries);
}
