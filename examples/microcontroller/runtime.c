/* runtime.c - what every bare board needs: memory functions, start of main, stack paint. SPDX-License-Identifier: MIT
 *
 * Compile with -fno-tree-loop-distribute-patterns, or the loops become calls of themselves. */
#include "board.h"
#include "runtime.h"

#include <string.h>

extern uint32_t data_load[], data_start[], data_end[], bss_end[]; /* link.ld */

#define PAINT 0xc0a7ed5eu

void *memcpy(void *to, const void *from, size_t size)
{
    uint8_t *d = (uint8_t *)to;
    const uint8_t *s = (const uint8_t *)from;
    while (size--) *d++ = *s++;
    return to;
}

void *memset(void *to, int byte, size_t size)
{
    uint8_t *d = (uint8_t *)to;
    while (size--) *d++ = (uint8_t)byte;
    return to;
}

void start_main(void)
{
    const uint32_t *from = data_load;
    uint32_t *to = data_start;
    while (to < data_end) *to++ = *from++;
    while (to < bss_end) *to++ = 0;
    semihosting_exit(main());
}

void board_print(const char *text) { semihosting(SEMIHOSTING_WRITE0, (uintptr_t)text); }

void semihosting_exit(int status)
{
    uint32_t argument[2] = { SEMIHOSTING_STOPPED, 0 };
    argument[1] = (uint32_t)status;
    semihosting(SEMIHOSTING_EXIT, (uintptr_t)argument);
    for (;;) {}
}

void board_step(void) {}

/* The stack grows down to the end of the static data. */
void board_paint_stack(void)
{
    uint32_t *p = bss_end, *end = (uint32_t *)board_stack_pointer();
    while (p < end) *p++ = PAINT;
}

uint32_t board_stack_used(uintptr_t top)
{
    const uint32_t *p = bss_end;
    while (*p == PAINT) p++;
    return (uint32_t)(top - (uintptr_t)p);
}
