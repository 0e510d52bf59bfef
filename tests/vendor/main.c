/* main.c - a program outside conquest: both widths of indices, and the version that the package says.
 * SPDX-License-Identifier: MIT */
#include "round_trip.h"

#include <stdio.h>

extern int round_trip_16(void);

int main(void)
{
    char version[16];
    snprintf(version, sizeof version, "%d.%d.%d", CQ_VERSION / 10000, CQ_VERSION / 100 % 100, CQ_VERSION % 100);
    puts(CQ_VERSION_STRING);
    return !(strcmp(version, CQ_VERSION_STRING) == 0 && round_trip() && round_trip_16());
}
