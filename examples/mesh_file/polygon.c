/* polygon.c - cuts polygons into triangles. SPDX-License-Identifier: MIT
 *
 * Ear clipping in the plane of the polygon (Meisters, "Polygons have ears", 1975), with the cases of Held, "FIST", 2001:
 * corners that repeat or lie on a line, holes that a cut connects with the outside, and corners that are not quite in
 * one plane. Whatever the polygon, n corners give n - 2 triangles, in which each side of it occurs once in its direction
 * and each diagonal once in both. Triangles without area are the last resort, and those that overlap come after them:
 * polygons that cross themselves have no others. Those with ten thousands of corners may come to that,
 * too, so that no file takes hours. */
#include "reader.h"

#include <math.h>
#include <stdlib.h>

enum { MAX_WORK = 1 << 18 };          /* for each corner */

/* What the area of a triangle is compared with: `fat` is small against the square of the polygon's size. */
struct clip {
    double (*point)[2];               /* in the plane, counter-clockwise */
    uint32_t *previous, *next;        /* of the corners that are left */
    double fat;
    uint64_t work;                    /* corners that may be looked at yet */
};

/* -- The plane ----------------------------------------------------------------------------------------------------- */

/* The normal by Newell's method, which averages over corners that are not in one plane. */
static void newell_normal(const double (*corner)[3], size_t count, double normal[3])
{
    normal[0] = normal[1] = normal[2] = 0;
    for (size_t i = 0; i < count; i++) {
        const double *a = corner[i], *b = corner[i + 1 < count ? i + 1 : 0], *o = corner[0];
        for (int k = 0; k < 3; k++) {
            int u = (k + 1) % 3, v = (k + 2) % 3;
            normal[k] += (a[u] - o[u]) * (b[v] - o[v]) - (a[v] - o[v]) * (b[u] - o[u]);
        }
    }
}

/* Leaves out the coordinate in whose direction the normal is longest: exact, and nothing turns over. */
static void project(struct clip *c, const double (*corner)[3], size_t count)
{
    double normal[3], low[2], high[2];
    newell_normal(corner, count, normal);
    int k = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    k = fabs(normal[2]) >= fabs(normal[k]) ? 2 : k;
    int u = (k + (normal[k] < 0 ? 2 : 1)) % 3, v = 3 - k - u;
    for (size_t i = 0; i < count; i++) {
        c->point[i][0] = corner[i][u];
        c->point[i][1] = corner[i][v];
        for (int d = 0; d < 2; d++) {
            low[d] = i == 0 ? c->point[i][d] : fmin(low[d], c->point[i][d]);
            high[d] = i == 0 ? c->point[i][d] : fmax(high[d], c->point[i][d]);
        }
    }
    c->fat = 1e-12 * fmax(high[0] - low[0], high[1] - low[1]) * fmax(high[0] - low[0], high[1] - low[1]);
}

/* Twice the area of a triangle, negative if it is clockwise. */
static double area_of(const struct clip *c, uint32_t i, uint32_t j, uint32_t k)
{
    const double *p = c->point[i], *q = c->point[j], *r = c->point[k];
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

static int is_same_point(const struct clip *c, uint32_t i, uint32_t j)
{
    return c->point[i][0] == c->point[j][0] && c->point[i][1] == c->point[j][1];
}

/* -- Ears ---------------------------------------------------------------------------------------------------------- */

/* As seen from tip b of triangle a b d, which is counter-clockwise. */
static int is_between_sides(const struct clip *c, uint32_t a, uint32_t b, uint32_t d, uint32_t end)
{
    return area_of(c, a, b, end) >= 0 && area_of(c, b, d, end) >= 0;
}

/* Corner q is at the same place as tip b. Is part of the triangle outside the polygon there? */
static int opens_into(const struct clip *c, uint32_t a, uint32_t b, uint32_t d, uint32_t q)
{
    uint32_t before = c->previous[q], after = c->next[q];
    return area_of(c, before, q, after) < 0 && is_between_sides(c, a, b, d, before) && is_between_sides(c, a, b, d, after);
}

/* Is corner q in the way of cutting off corner b? */
static int is_in_the_way(const struct clip *c, uint32_t b, uint32_t q)
{
    uint32_t a = c->previous[b], d = c->next[b];
    if (is_same_point(c, q, a))
        return opens_into(c, d, a, b, q);
    if (is_same_point(c, q, b))
        return opens_into(c, a, b, d, q);
    if (is_same_point(c, q, d))
        return opens_into(c, b, d, a, q);
    return area_of(c, a, b, q) >= 0 && area_of(c, b, d, q) >= 0 && area_of(c, d, a, q) >= 0;
}

/* Is b an ear of more than this area? If anything is in the way, a corner that is not convex is. */
static int is_ear(struct clip *c, uint32_t b, double area)
{
    uint32_t a = c->previous[b], d = c->next[b];
    if (!(area_of(c, a, b, d) > area))
        return 0;
    for (uint32_t q = c->next[d]; q != a; q = c->next[q], c->work -= c->work > 0)
        if (area_of(c, c->previous[q], q, c->next[q]) <= 0 && is_in_the_way(c, b, q))
            return 0;
    return 1;
}

static int is_flat(const struct clip *c, uint32_t b)
{
    return area_of(c, c->previous[b], b, c->next[b]) == 0;
}

enum choice { FAT_EAR, EAR, REPEATED, FLAT, NUM_CHOICES };

static int may_be_cut(struct clip *c, uint32_t b, enum choice choice)
{
    switch (choice) {
    case FAT_EAR: return is_ear(c, b, c->fat);
    case EAR: return is_ear(c, b, 0);
    case REPEATED: return is_same_point(c, b, c->next[b]);
    default: return is_flat(c, b);
    }
}

/* The best corner to cut off, from `start` on. */
static uint32_t find_ear(struct clip *c, uint32_t start, size_t left)
{
    uint32_t b = start;
    for (int choice = 0; choice < NUM_CHOICES; choice++)
        for (size_t i = 0; i < left && c->work > 0; i++, b = c->next[b], c->work -= c->work > 0)
            if (may_be_cut(c, b, (enum choice)choice))
                return b;
    return start;
}

/* After an ear, its neighbours are left alone for a while: the triangles get less narrow. */
static void clip_ears(struct clip *c, size_t count, uint32_t (*triangle)[3])
{
    uint32_t at = 0;
    for (size_t left = count; left > 3; left--) {
        uint32_t b = find_ear(c, at, left), a = c->previous[b], d = c->next[b];
        (*triangle)[0] = a;
        (*triangle)[1] = b;
        (*triangle++)[2] = d;
        c->next[a] = d;
        c->previous[d] = a;
        at = c->next[d];
    }
    (*triangle)[0] = c->previous[at];
    (*triangle)[1] = at;
    (*triangle)[2] = c->next[at];
}

/* -- Either way ---------------------------------------------------------------------------------------------------- */

/* Triangles that all have corner 0, which is how most programs cut convex polygons. Returns 1 if each has an area. */
static int fan(const struct clip *c, size_t count, uint32_t (*triangle)[3])
{
    int is_good = 1;
    for (uint32_t i = 1; i + 1 < count; i++, triangle++) {
        (*triangle)[0] = 0;
        (*triangle)[1] = i;
        (*triangle)[2] = i + 1;
        is_good = is_good && area_of(c, 0, i, i + 1) > c->fat;
    }
    return is_good;
}

static void link_corners(struct clip *c, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        c->previous[i] = (i > 0 ? i : count) - 1;
        c->next[i] = i + 1 < count ? i + 1 : 0;
    }
}

static int triangulate_within(const double (*corner)[3], size_t count, uint32_t (*triangle)[3], uint64_t work)
{
    struct clip c = { 0 };
    c.point = malloc(count * sizeof *c.point);
    c.previous = malloc(count * sizeof *c.previous);
    c.next = malloc(count * sizeof *c.next);
    int is_cut_well = 1, ok = c.point != NULL && c.previous != NULL && c.next != NULL;
    if (ok) {
        project(&c, corner, count);
        link_corners(&c, (uint32_t)count);
        c.work = work;
        if (!fan(&c, count, triangle) && count > 3)
            clip_ears(&c, count, triangle);
        is_cut_well = c.work > 0;
    }
    free(c.point);
    free(c.previous);
    free(c.next);
    return ok ? 1 + is_cut_well : 0;
}

int triangulate(const double (*corner)[3], size_t count, uint32_t (*triangle)[3])
{
    return triangulate_within(corner, count, triangle, (uint64_t)MAX_WORK * count);
}
