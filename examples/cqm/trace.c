/* trace.c - what a decoder reads of a stream, event by event. SPDX-License-Identifier: MIT
 *
 * It has a decoder of its own, as that of the other commands need not be slower for it. */
#define CQ_API static inline
#define CQ_NO_ENCODER
#define CQ_NO_QUANTISER
#include "cqm.h"

#include <inttypes.h>
#include <stdlib.h>

static const struct { const char *name; int num_numbers; } events[] = {
    [CQ_EVENT_MATERIAL] = { "material", 2 },   [CQ_EVENT_TRIANGLE] = { "triangle", 3 },
    [CQ_EVENT_COMPONENT] = { "component", 3 }, [CQ_EVENT_VALUES] = { "values", 2 },
    [CQ_EVENT_FACE] = { "face", 3 },           [CQ_EVENT_ROW] = { "row", 2 },
    [CQ_EVENT_CORNER] = { "corner", 2 },       [CQ_EVENT_LEVEL] = { "level", 3 },
    [CQ_EVENT_PATCH] = { "patch", 3 },         [CQ_EVENT_SPLIT] = { "split", 3 },
    [CQ_EVENT_MARK] = { "mark", 3 },           [CQ_EVENT_PATTERN] = { "pattern", 2 },
    [CQ_EVENT_DISSOLVED] = { "dissolved", 2 }, [CQ_EVENT_INSERTION] = { "insertion", 3 },
    [CQ_EVENT_FLIP] = { "flip", 2 },           [CQ_EVENT_END] = { "end", 3 },
};

static void print_channel(const cq_decoder *d, uint32_t k, size_t n)
{
    size_t components = d->shape.channel[k].components;
    for (size_t c = 0; c < components; c++)
        printf(" %" PRIu32, (uint32_t)d->channel[k][n * components + c]);
}

/* The ends of a flipped edge come in any order; they are printed with the lower number first. */
static void print_event(const cq_decoder *d, cq_event event, uint32_t a, uint32_t b, uint32_t c)
{
    int turned = event == CQ_EVENT_FLIP && a > b;
    printf("%s %" PRIu32 " %" PRIu32, events[event].name, turned ? b : a, turned ? a : b);
    if (events[event].num_numbers == 3)
        printf(" %" PRIu32, c);
    if (event == CQ_EVENT_VALUES)
        print_channel(d, a, b);
    putchar('\n');
}

#define CQ_TRACE(decoder, event, a, b, c) print_event(decoder, event, a, b, c)
#define CONQUEST_IMPLEMENTATION
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" /* gcc loses sight of what a complete header has filled in */
#endif
#include "conquest.h"

static int trace(struct decoding *d, const char *path, const uint8_t *data, size_t size)
{
    cq_bytes in = { data, size };
    if (!open_decoding(d, path, data, size))
        return 0;
    cq_result result = cq_decode(&d->decoder, &in, CQ_NO_LIMIT);
    if (result == CQ_NEED_INPUT)
        result = cq_decode(&d->decoder, NULL, CQ_NO_LIMIT);
    if (fflush(stdout) != 0)
        return complain("-", "cannot write");
    if (result == CQ_TRUNCATED)
        return complain(path, "truncated after %zu of %zu bytes", size, d->stream_bytes);
    return result == CQ_DONE || complain_stream(path, result, (size_t)(in.data - data));
}

int run_trace(const struct options *options)
{
    static struct decoding d;
    size_t size;
    uint8_t *data = load_file(options->files[0], &size);
    if (data == NULL)
        return EXIT_BAD_DATA;
    int ok = trace(&d, options->files[0], data, size);
    close_decoding(&d);
    free(data);
    return ok ? 0 : EXIT_BAD_DATA;
}
