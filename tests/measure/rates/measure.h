/* measure.h - what the codec makes of a mesh file. SPDX-License-Identifier: MIT */
#ifndef MEASURE_H
#define MEASURE_H

#include "cqm.h"

/* Rates are in bits per vertex of the whole mesh. */
struct measurement {
    struct encoding encoding;      /* of the connectivity alone */
    double alone;                  /* the whole stream: header, base mesh and check values too */
    double regular;                /* the same, with regular levels if these make it smaller */
    double with_positions;         /* of a stream with 12-bit positions: header, base, flags, indices */
};

/* What the paper counts, over all levels. */
struct split_statistics {
    double mean_i, mean_j;         /* of the two indices of a split */
    double isolated;               /* share of the patches, 0 .. 1 */
    double order0;                 /* entropy of i, of j and of the flags of isolated patches, in bits per vertex: what
                                    * they cost if only their frequencies in the whole stream are known */
};

/* Both return 1; or 0 after a complaint. A measurement that was taken holds memory until it is freed. */
int take_measurement(struct measurement *m, const char *path);
int read_splits(struct split_statistics *s, const struct measurement *m, const char *path);
void free_measurement(struct measurement *m);

#endif
