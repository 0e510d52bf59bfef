/* string.h - the two functions that conquest.h takes from libc, as instructions of WebAssembly. SPDX-License-Identifier: MIT */
#ifndef STRING_H
#define STRING_H

#define memcpy(to, from, size) __builtin_memcpy(to, from, size)
#define memset(to, byte, size) __builtin_memset(to, byte, size)

#endif
