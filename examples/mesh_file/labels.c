/* labels.c - names of materials, groups and objects. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <stdlib.h>
#include <string.h>

int add_label_name(struct reader *r, struct label_names *names, struct word name)
{
    if (names->count == names->room) {
        size_t room = 2 * names->room + 16;
        struct word *larger = room < SIZE_MAX / sizeof *larger ? realloc(names->name, room * sizeof *larger) : NULL;
        if (larger == NULL)
            return fail(r, "out of memory for %zu names", room);
        names->name = larger;
        names->room = room;
    }
    names->name[names->count++] = name;
    return 1;
}

/* -- Equal names --------------------------------------------------------------------------------------------------- */

struct numbered_name {
    struct word name;
    uint32_t place, first;             /* in the list, from 1; of the first one with the same name */
    uint32_t number;                   /* there: of the label; 0: no face has it yet */
};

static int compare_names(const struct numbered_name *a, const struct numbered_name *b)
{
    if ((a->name.text == NULL) != (b->name.text == NULL))
        return a->name.text == NULL ? -1 : 1;
    if (a->name.length != b->name.length)
        return a->name.length < b->name.length ? -1 : 1;
    return a->name.text == NULL ? 0 : memcmp(a->name.text, b->name.text, a->name.length);
}

static int compare_by_name(const void *a, const void *b)
{
    const struct numbered_name *s = a, *t = b;
    int order = compare_names(s, t);
    return order != 0 ? order : (s->place > t->place) - (s->place < t->place);
}

static int compare_by_place(const void *a, const void *b)
{
    const struct numbered_name *s = a, *t = b;
    return (s->place > t->place) - (s->place < t->place);
}

/* NULL: no memory. */
static struct numbered_name *find_equal_names(const struct label_names *names)
{
    struct numbered_name *list = calloc(names->count + 1, sizeof *list);
    if (list == NULL)
        return NULL;
    for (size_t i = 0; i < names->count; i++) {
        list[i].name = names->name[i];
        list[i].place = (uint32_t)i + 1;
    }
    qsort(list, names->count, sizeof *list, compare_by_name);
    for (size_t i = 0; i < names->count; i++)
        list[i].first = i > 0 && compare_names(&list[i - 1], &list[i]) == 0 ? list[i - 1].first : list[i].place;
    qsort(list, names->count, sizeof *list, compare_by_place);
    return list;
}

/* -- Their text ---------------------------------------------------------------------------------------------------- */

/* A name cannot have the byte that ends all of them. */
int add_line(struct reader *r, char **text, struct word line)
{
    size_t used = *text != NULL ? strlen(*text) : 0;
    char *longer = realloc(*text, used + line.length + 2);
    if (longer == NULL)
        return fail(r, "out of memory for names");
    for (size_t i = 0; i < line.length; i++)
        longer[used + i] = (char)(line.text[i] != '\0' ? line.text[i] : '?');
    longer[used + line.length] = '\n';
    longer[used + line.length + 1] = '\0';
    *text = longer;
    return 1;
}

static int add_name(struct reader *r, struct mesh_labels *labels, struct word name)
{
    char number[WORD_BYTES];
    if (name.text == NULL) {
        name.length = (size_t)snprintf(number, sizeof number, "material_%zu", name.length);
        name.text = (const uint8_t *)number;
    }
    return add_line(r, &labels->names, name);
}

int store_labels(struct reader *r, struct mesh_file *mesh, enum mesh_label label, const struct label_names *names)
{
    struct mesh_labels *labels = &mesh->label[label];
    struct numbered_name *list = find_equal_names(names);
    int ok = list != NULL || fail(r, "out of memory for %zu names", names->count);
    for (size_t f = 0; f < mesh->num_faces && labels->of_face != NULL && ok; f++) {
        if (labels->of_face[f] == 0)
            continue;
        struct numbered_name *first = &list[list[labels->of_face[f] - 1].first - 1];
        if (first->number == 0) {
            first->number = ++labels->count;
            ok = add_name(r, labels, first->name);
        }
        labels->of_face[f] = first->number;
    }
    free(list);
    if (labels->count == 0) {
        free(labels->of_face);
        labels->of_face = NULL;
    }
    return ok;
}
