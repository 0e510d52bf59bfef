/* cq_next, cq_prev and the face of a halfedge as tables, which are easier to solve than divisions. claim_tables says
 * that they are the same; the driver then puts stub_next and stub_prev in the place of cq_next and cq_prev. HALFEDGES
 * is how many there are. */
#ifndef TABLES_H
#define TABLES_H

#define FACE(f) f, f, f
#define NEXT(f) 3 * f + 1, 3 * f + 2, 3 * f
#define PREV(f) 3 * f + 2, 3 * f, 3 * f + 1
#define ALL(x) x(0), x(1), x(2), x(3), x(4), x(5), x(6), x(7)
enum { MAX_HALFEDGES = 24 };
static const uint8_t face_of[MAX_HALFEDGES] = { ALL(FACE) };
static const uint8_t next_of[MAX_HALFEDGES] = { ALL(NEXT) };
static const uint8_t prev_of[MAX_HALFEDGES] = { ALL(PREV) };

cq_index stub_next(cq_index h)
{
    PROVE(h < HALFEDGES);
    return next_of[h];
}

cq_index stub_prev(cq_index h)
{
    PROVE(h < HALFEDGES);
    return prev_of[h];
}

#endif
