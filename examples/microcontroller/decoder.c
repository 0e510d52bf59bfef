/* decoder.c - the library, without the encoder, reports, and floating point. SPDX-License-Identifier: MIT
 *
 * Devices are built with CQ_NO_REGULAR and CQ_NO_WEDGES, too, unless they need these. */
#define CQ_NO_ENCODER
#define CQ_NO_REPORTS
#define CQ_NO_QUANTISER
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
