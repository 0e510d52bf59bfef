/* report.h - numbers for a serial line, and a hash. SPDX-License-Identifier: MIT */
#ifndef REPORT_H
#define REPORT_H

#include "board.h"

static void print_number(const char *key, uint32_t value, uint32_t base)
{
    char text[12];
    int at = sizeof text - 1;
    text[at] = '\0';
    do {
        text[--at] = "0123456789abcdef"[value % base];
        value /= base;
    } while (value);
    board_print(key);
    board_print(text + at);
    board_print("\n");
}

/* FNV-1a of a number's four bytes, the lowest first. */
static uint32_t add_to_hash(uint32_t hash, uint32_t value)
{
    int k;
    for (k = 0; k < 4; k++) {
        hash = (hash ^ (value & 0xff)) * 0x01000193u;
        value >>= 8;
    }
    return hash;
}

#endif
