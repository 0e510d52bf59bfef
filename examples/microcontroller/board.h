/* board.h - what main.c asks of a board. SPDX-License-Identifier: MIT
 *
 *     cortex_m.c   Cortex-M3 and M0        avr.c     ATmega1284P
 *     riscv.c      RV32                    host.c    a program for an operating system
 *
 * To the first two belong runtime.c and link.ld; string.h stands for a libc that is not there. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

void board_print(const char *text);

/* Called after each step of the decoder: the place to feed a watchdog, to read an input, to draw. */
void board_step(void);

/* The stack pointer of the caller. The host has none to show: 0. */
uintptr_t board_stack_pointer(void);

/* Fills the stack that is free with a pattern; later, how many bytes below `top` have been overwritten. */
void board_paint_stack(void);
uint32_t board_stack_used(uintptr_t top);

#endif
