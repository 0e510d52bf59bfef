/* decoder.c - the library, without the encoder. SPDX-License-Identifier: MIT */
#define CQ_NO_ENCODER
#define CQ_NO_REPORTS
#define CQ_NO_QUANTISER
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
