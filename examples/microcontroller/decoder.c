/* decoder.c - the library, without the encoder, reports, and floating point. SPDX-License-Identifier: MIT */
#define CQ_NO_ENCODER
#define CQ_NO_REPORTS
#define CQ_NO_QUANTISER
#define CQ_NO_WEDGES
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
