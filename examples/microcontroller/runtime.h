/* runtime.h - between runtime.c and the start-up code of a processor. SPDX-License-Identifier: MIT
 *
 * Semihosting: calls to the debugger or emulator that the device is attached to. A product has a UART instead. */
#ifndef RUNTIME_H
#define RUNTIME_H

#include <stdint.h>

enum { SEMIHOSTING_WRITE0 = 0x04, SEMIHOSTING_EXIT = 0x20, SEMIHOSTING_STOPPED = 0x20026 };

int main(void);

/* runtime.c: sets up static data, runs main and ends with its status; ends with a status. */
void start_main(void);
void semihosting_exit(int status);

/* The processor's: one call. */
uintptr_t semihosting(uintptr_t operation, uintptr_t argument);

#endif
