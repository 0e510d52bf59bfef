/* string.h - the two functions that conquest.h takes from libc, for a compiler that comes without one; they are in
 * runtime.c. SPDX-License-Identifier: MIT */
#ifndef STRING_H
#define STRING_H

#include <stddef.h>

void *memcpy(void *to, const void *from, size_t size);
void *memset(void *to, int byte, size_t size);

#endif
