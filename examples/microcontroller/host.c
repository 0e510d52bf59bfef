/* host.c - the board that is a process: for comparison. SPDX-License-Identifier: MIT */
#include "board.h"

#include <stdio.h>

void board_print(const char *text) { fputs(text, stdout); }
void board_step(void) {}
uintptr_t board_stack_pointer(void) { return 0; }
void board_paint_stack(void) {}
uint32_t board_stack_used(uintptr_t top) { return (uint32_t)top; }
