/* Polygons cut into triangles. All coordinates are small integers in some plane, so that areas are exact. The signed areas of
 * the triangles of a disc add up to that of its boundary: if none is negative and the boundary does not cross itself,
 * they cover it once. */
#include "../../examples/mesh_file/polygon.c"
#include "test.h"

enum { MAX_CORNERS = 4000, GRID = 12 };

static struct { int x, y; } point[MAX_CORNERS];
static size_t count;

static void add_point(int x, int y)
{
    point[count].x = x;
    point[count++].y = y;
}

static uint32_t random_below(uint32_t n)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33) % n;
}

static int64_t area_of_points(size_t i, size_t j, size_t k)
{
    return (int64_t)(point[j].x - point[i].x) * (point[k].y - point[i].y)
         - (int64_t)(point[j].y - point[i].y) * (point[k].x - point[i].x);
}

/* Integer planes, some of which turn the polygon over as seen along an axis. */
static void place_in_space(double (*corner)[3], uint32_t plane)
{
    static const int axes[6][2][3] = {
        { { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 1, 0 }, { 1, 0, 0 } }, { { 0, 0, 1 }, { 1, 0, 0 } },
        { { 1, 2, 0 }, { 0, 1, 3 } }, { { -1, 1, 4 }, { 2, 2, 1 } }, { { 0, 3, 1 }, { 0, -2, 5 } },
    };
    size_t i;
    int k;
    for (i = 0; i < count; i++)
        for (k = 0; k < 3; k++)
            corner[i][k] = axes[plane][0][k] * point[i].x + axes[plane][1][k] * point[i].y + 1000 * k;
}

/* Every side of the polygon once, in its direction, and every other side of a triangle once in each. */
static int is_disc(uint32_t (*triangle)[3])
{
    static uint8_t seen[400][400];
    size_t f, k, i, j;
    if (count > 400) return 1;
    memset(seen, 0, sizeof seen);
    for (f = 0; f + 2 < count; f++)
        for (k = 0; k < 3; k++) {
            if (triangle[f][k] >= count) return 0;
            if (seen[triangle[f][k]][triangle[f][(k + 1) % 3]]++ != 0) return 0;
        }
    for (i = 0; i < count; i++)
        for (j = 0; j < count; j++) {
            int is_side = j == (i + 1) % count, is_back = i == (j + 1) % count;
            if (is_side ? seen[i][j] != 1 : is_back ? seen[i][j] != 0 : seen[i][j] != seen[j][i]) return 0;
        }
    return 1;
}

struct outcome {
    int is_disc, negative, flat;
};

static struct outcome cut(uint32_t plane)
{
    static double corner[MAX_CORNERS][3];
    static uint32_t triangle[MAX_CORNERS][3];
    struct outcome o = { 0, 0, 0 };
    size_t f;
    place_in_space(corner, plane);
    if (!triangulate((const double (*)[3])corner, count, triangle)) return o;
    o.is_disc = is_disc(triangle);
    for (f = 0; f + 2 < count; f++) {
        int64_t area = area_of_points(triangle[f][0], triangle[f][1], triangle[f][2]);
        o.negative += area < 0;
        o.flat += area == 0;
    }
    return o;
}

/* A connected set of cells of a grid without holes that grows by chance, and its outline, with a corner at each point of
 * the grid, so that many are on a line. */
static uint8_t cell[GRID + 2][GRID + 2];

static int touches_by_corner_alone(int x, int y)
{
    int dx, dy;
    for (dx = -1; dx <= 1; dx += 2)
        for (dy = -1; dy <= 1; dy += 2)
            if (cell[x + dx][y + dy] && !cell[x + dx][y] && !cell[x][y + dy]) return 1;
    return 0;
}

/* Adding a cell keeps the outline in one piece if its neighbours that are filled follow each other around it. */
static int keeps_one_outline(int x, int y)
{
    static const int around[8][2] = { { 1, 0 }, { 1, 1 }, { 0, 1 }, { -1, 1 }, { -1, 0 }, { -1, -1 }, { 0, -1 }, { 1, -1 } };
    int k, changes = 0;
    for (k = 0; k < 8; k++)
        changes += cell[x + around[k][0]][y + around[k][1]] != cell[x + around[(k + 1) % 8][0]][y + around[(k + 1) % 8][1]];
    return changes == 2 && !touches_by_corner_alone(x, y);
}

static void grow_cells(uint32_t cells)
{
    uint32_t tries;
    memset(cell, 0, sizeof cell);
    cell[GRID / 2][GRID / 2] = 1;
    for (tries = 0; tries < 40 * cells && cells > 1; tries++) {
        int x = 1 + (int)random_below(GRID), y = 1 + (int)random_below(GRID);
        if (cell[x][y] || !(cell[x - 1][y] || cell[x + 1][y] || cell[x][y - 1] || cell[x][y + 1])) continue;
        if (!keeps_one_outline(x, y)) continue;
        cell[x][y] = 1;
        cells--;
    }
}

/* With the filled cells on the left. */
static void trace_outline(void)
{
    static const int step[4][2] = { { 1, 0 }, { 0, 1 }, { -1, 0 }, { 0, -1 } };
    static const int left[4][2] = { { 0, 0 }, { -1, 0 }, { -1, -1 }, { 0, -1 } };
    int x, y, d = 0, start_x, start_y;
    for (x = 1; !cell[x][GRID / 2]; x++) {}
    for (y = GRID / 2; cell[x][y - 1]; y--) {}
    start_x = x;
    start_y = y;
    count = 0;
    do {
        add_point(x, y);
        x += step[d][0];
        y += step[d][1];
        for (d = (d + 3) % 4; !cell[x + left[d][0]][y + left[d][1]] || cell[x + left[(d + 3) % 4][0]][y + left[(d + 3) % 4][1]];)
            d = (d + 1) % 4;
    } while (x != start_x || y != start_y);
}

static void repeat_points(void)
{
    size_t i, at;
    for (i = 0; i < 5; i++) {
        at = random_below((uint32_t)count);
        memmove(&point[at + 1], &point[at], (count - at) * sizeof *point);
        count++;
    }
}

static void turn_list(size_t by)
{
    size_t i;
    for (i = 0; i < by % count; i++) {
        point[count] = point[0];
        memmove(&point[0], &point[1], count * sizeof *point);
    }
}

TEST(outlines_with_corners_on_a_line_have_triangles_with_an_area)
{
    int k, corners = 0;
    for (k = 0; k < 3000; k++) {
        struct outcome o;
        grow_cells(1 + random_below(90));
        trace_outline();
        turn_list(random_below((uint32_t)count));
        o = cut((uint32_t)k % 6);
        corners += (int)count;
        REQUIRE(o.is_disc);
        REQUIRE_EQ(o.negative, 0);
        REQUIRE_EQ(o.flat, 0);
    }
    CHECK(corners > 50000);
}

TEST(corners_that_repeat_cost_a_flat_triangle_each)
{
    int k;
    for (k = 0; k < 1000; k++) {
        struct outcome o;
        grow_cells(1 + random_below(60));
        trace_outline();
        repeat_points();
        o = cut((uint32_t)k % 6);
        REQUIRE(o.is_disc);
        REQUIRE_EQ(o.negative, 0);
        REQUIRE_EQ(o.flat, 5);
    }
}

TEST(a_star_with_random_spikes)
{
    int k;
    for (k = 0; k < 2000; k++) {
        struct outcome o;
        uint32_t n = 3 + random_below(40), i;
        count = 0;
        for (i = 0; i < n; i++) {
            double angle = 6.283185307179586 * i / n;
            int radius = 1000 + (int)random_below(100000);
            add_point((int)(radius * cos(angle)), (int)(radius * sin(angle)));
        }
        o = cut((uint32_t)k % 6);
        REQUIRE(o.is_disc);
        REQUIRE_EQ(o.negative, 0);
        REQUIRE_EQ(o.flat, 0);
    }
}

static void add_square(int x, int y, int side, int is_clockwise)
{
    add_point(x, y);
    if (is_clockwise) add_point(x, y + side); else add_point(x + side, y);
    add_point(x + side, y + side);
    if (is_clockwise) add_point(x + side, y); else add_point(x, y + side);
    add_point(x, y);
}

/* Cuts lead from a corner of the square to each hole and back. */
TEST(holes_that_cuts_connect_with_the_outside)
{
    int k, hole;
    for (k = 0; k < 6; k++) {
        struct outcome o;
        count = 0;
        add_square(0, 0, 100, 0);
        for (hole = 4; hole-- > 0;) {
            add_square(60, 10 + 20 * hole, 5, 1);
            add_point(0, 0);
        }
        count--;
        o = cut((uint32_t)k);
        REQUIRE(o.is_disc);
        CHECK_EQ(o.negative, 0);
    }
}

/* The cuts of two holes meet in one corner of a third. */
TEST(a_cut_that_ends_at_a_hole_from_which_another_one_begins)
{
    struct outcome o;
    count = 0;
    add_square(0, 0, 100, 0);
    add_square(20, 10, 10, 1);
    add_square(50, 5, 10, 1);
    add_point(20, 10);
    o = cut(0);
    CHECK(o.is_disc);
    CHECK_EQ(o.negative, 0);
}

/* Cutting off the tip that the hole touches would cut through the hole, of which no corner is inside the triangle. */
TEST(a_hole_that_touches_a_tip)
{
    size_t k;
    for (k = 0; k < 9; k++) {
        struct outcome o;
        count = 0;
        add_square(0, 0, 100, 0);
        add_point(20, 60);
        add_point(30, 80);
        add_point(100, 0);
        add_point(20, 60);
        turn_list(k);
        o = cut((uint32_t)k % 6);
        CHECK(o.is_disc);
        CHECK_EQ(o.negative, 0);
    }
}

TEST(a_spiral)
{
    struct outcome o;
    int k, turns = 60;
    count = 0;
    for (k = 0; k < turns; k++) add_point((k % 4 == 0 || k % 4 == 3 ? -1 : 1) * (5 + 3 * k), (k % 4 < 2 ? -1 : 1) * (5 + 3 * k));
    for (k = turns; k-- > 0;) add_point((k % 4 == 0 || k % 4 == 3 ? -1 : 1) * (6 + 3 * k), (k % 4 < 2 ? -1 : 1) * (6 + 3 * k));
    o = cut(3);
    CHECK(o.is_disc);
    CHECK_EQ(o.flat, 0);
}

/* As most programs do: corner 0 has all triangles of a convex polygon, and a quad is cut where it must be. */
TEST(convex_polygons_are_fans)
{
    static const double square[4][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } };
    static const double dart[4][3] = { { 0, 0, 0 }, { 4, 0, 0 }, { 1, 1, 0 }, { 0, 4, 0 } };
    uint32_t triangle[2][3], k;
    CHECK_EQ(triangulate(square, 4, triangle), 2);
    for (k = 0; k < 2; k++) CHECK(triangle[k][0] == 0 && triangle[k][1] == k + 1 && triangle[k][2] == k + 2);
    REQUIRE(triangulate(dart, 4, triangle));
    for (k = 0; k < 2; k++) CHECK(triangle[k][0] == 0 && triangle[k][1] == k + 1 && triangle[k][2] == k + 2);
    {
        static const double turned[4][3] = { { 4, 0, 0 }, { 1, 1, 0 }, { 0, 4, 0 }, { 0, 0, 0 } };
        uint32_t corners = 0;
        REQUIRE(triangulate(turned, 4, triangle));
        for (k = 0; k < 6; k++) corners += triangle[k / 3][k % 3] == 1 || triangle[k / 3][k % 3] == 3;
        CHECK_EQ(corners, 4);        /* the cut is between 1 and 3 */
    }
}

TEST(polygons_that_are_none_are_cut_all_the_same)
{
    int k;
    for (k = 0; k < 2000; k++) {
        uint32_t n = 4 + random_below(30), i, size = 1 + random_below(6);
        count = 0;
        for (i = 0; i < n; i++) add_point((int)random_below(size), (int)random_below(size));
        REQUIRE(cut((uint32_t)k % 6).is_disc);
    }
}

/* What has too many corners is a disc all the same, and said to be cut badly. */
TEST(work_has_a_limit)
{
    static double corner[MAX_CORNERS][3];
    static uint32_t triangle[MAX_CORNERS][3];
    uint64_t work;
    size_t k;
    count = 0;
    for (k = 0; k < 60; k++) add_point((int)random_below(9), (int)random_below(9));
    place_in_space(corner, 0);
    for (work = 0; work < 4000; work += 40) {
        CHECK_EQ(triangulate_within((const double (*)[3])corner, count, triangle, work), 1);
        REQUIRE(is_disc(triangle));
    }
    CHECK_EQ(triangulate((const double (*)[3])corner, count, triangle), 2);
}

int main(int argc, char **argv)
{
    TEST_BEGIN(argc, argv);
    RUN(outlines_with_corners_on_a_line_have_triangles_with_an_area);
    RUN(corners_that_repeat_cost_a_flat_triangle_each);
    RUN(a_star_with_random_spikes);
    RUN(holes_that_cuts_connect_with_the_outside);
    RUN(a_cut_that_ends_at_a_hole_from_which_another_one_begins);
    RUN(a_hole_that_touches_a_tip);
    RUN(a_spiral);
    RUN(convex_polygons_are_fans);
    RUN(polygons_that_are_none_are_cut_all_the_same);
    RUN(work_has_a_limit);
    return TEST_END();
}
