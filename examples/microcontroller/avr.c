/* avr.c - an ATmega1284P: 8 bits, an int of 16, 16 KiB of RAM. SPDX-License-Identifier: MIT
 *
 * Prints to its first serial port. avr-gcc has its own start-up code and libc, and keeps constants in RAM, so that only
 * small meshes fit. */
#include "board.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

static void put(char c)
{
    while (!(UCSR0A & _BV(UDRE0))) {}
    UDR0 = (uint8_t)c;
}

void board_print(const char *text)
{
    UCSR0B = _BV(TXEN0);
    while (*text) put(*text++);
}

void board_step(void) {}
uintptr_t board_stack_pointer(void) { return 0; }
void board_paint_stack(void) {}
uint32_t board_stack_used(uintptr_t top) { return top; }

/* After main: sleeps for ever, which ends the simulator. */
__attribute__((destructor)) static void stop(void)
{
    cli();
    sleep_mode();
}
