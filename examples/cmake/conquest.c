/* conquest.c - the implementation of conquest.h as a unit of its own. SPDX-License-Identifier: MIT */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
