/* narrow.c - a unit with 16-bit indices. SPDX-License-Identifier: MIT */
#define CQ_INDEX_BITS 16
#include "round_trip.h"

extern int round_trip_16(void);
int round_trip_16(void) { return round_trip(); }
