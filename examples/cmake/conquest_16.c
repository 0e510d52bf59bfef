/* conquest_16.c - the same for 16-bit indices; one program may have both. SPDX-License-Identifier: MIT */
#define CQ_INDEX_BITS 16
#include "conquest.c"
