/* own_16.c - the same for 16-bit indices. SPDX-License-Identifier: MIT */
#define CQ_INDEX_BITS 16
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
