/* own.c - a project's own unit of the implementation. SPDX-License-Identifier: MIT */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
