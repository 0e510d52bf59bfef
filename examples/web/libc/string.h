/* string.h - what conquest.h takes from libc, for a compiler that comes without one. SPDX-License-Identifier: MIT */
#ifndef STRING_H
#define STRING_H

#define memcpy(to, from, size) __builtin_memcpy(to, from, size)
#define memset(to, byte, size) __builtin_memset(to, byte, size)

#endif
