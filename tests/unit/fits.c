/* Fits of the weights of regular levels: that they find the weights that made the rows, from some of them and from all. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "test.h"

enum { MAX_ROWS = 2048, NUM_WEIGHTS = 8 };

static cqi_row row[MAX_ROWS];
static uint32_t random_state;

static int any(int least, int most) {
    random_state = random_state * 1664525u + 1013904223u;
    return least + (int)((random_state >> 8) % (uint32_t)(most - least + 1));
}

/* Rows that these weights leave errors of at most `noise` in; those from `some` on of any size. */
static void make_rows(cqi_rows *rows, uint32_t count, uint32_t some, const int8_t *weight, int noise) {
    uint32_t i;
    int c, k;
    random_state = count;
    rows->row = row;
    rows->count = count;
    rows->some = some;
    rows->parts = 1;
    memset(row, 0, sizeof row);
    for (i = 0; i < count; ++i)
        for (c = 0; c < 3; ++c) {
            int32_t sum = 0;
            for (k = 0; k < NUM_WEIGHTS; ++k) {
                row[i].feature[c][k] = (int16_t)any(-2000, 2000);
                sum += weight[k] * row[i].feature[c][k];
            }
            row[i].offset[c] = sum / 16 + 16 * any(-noise, noise);
        }
}

TEST(weights_are_found_that_made_the_rows) {
    static const int8_t made[NUM_WEIGHTS] = {31, -7, 0, 18, -40, 3, 25, -12};
    static const uint32_t counts[4][2] = {{60, 60}, {512, 512}, {513, 257}, {2000, 1000}};
    int i, noise;
    for (i = 0; i < 4; ++i)
        for (noise = 0; noise < 2; ++noise) {
            int8_t weight[NUM_WEIGHTS] = {0};
            cqi_rows rows;
            uint32_t cost;
            make_rows(&rows, counts[i][0], counts[i][1], made, noise);
            cost = cqi_fit_weights(&rows, 0, 1, weight, NUM_WEIGHTS, CQI_PASSES);
            CHECK(!memcmp(weight, made, sizeof made));
            CHECK(noise ? cost > 0 && cost < 8 * 3 * 2 * counts[i][0] : cost == 0);
        }
}

/* The last steps see all rows: most of them say that one weight is larger by 3. */
TEST(rows_that_are_not_among_some_have_the_last_word) {
    static const int8_t first[NUM_WEIGHTS] = {31, -7, 0, 18, -40, 3, 25, -12};
    int8_t last[NUM_WEIGHTS], weight[NUM_WEIGHTS] = {0};
    cqi_rows rows;
    uint32_t i;
    int k;
    memcpy(last, first, sizeof last);
    last[3] += 3;
    make_rows(&rows, 2000, 200, last, 0);
    for (i = 0; i < rows.some; ++i) {
        int32_t sum = 0;
        for (k = 0; k < NUM_WEIGHTS; ++k) sum += first[k] * row[i].feature[0][k];
        row[i].offset[0] = sum / 16;
    }
    cqi_fit_weights(&rows, 0, 0, weight, NUM_WEIGHTS, CQI_PASSES);
    CHECK(!memcmp(weight, last, sizeof last));
    rows.count = rows.some;
    for (i = 0; i < rows.count; ++i) memset(row[i].state, 0, sizeof row[i].state); /* as in rows that are new */
    memset(weight, 0, sizeof weight);
    cqi_fit_weights(&rows, 0, 0, weight, NUM_WEIGHTS, CQI_PASSES);
    CHECK(!memcmp(weight, first, sizeof first));
}

TEST(each_sample_has_a_place_and_every_second_one_is_among_some) {
    static const uint32_t counts[6] = {1, 2, 512, 513, 514, 2048};
    static uint8_t taken[MAX_ROWS];
    int i;
    for (i = 0; i < 6; ++i) {
        cqi_rows rows;
        uint32_t k;
        rows.count = counts[i];
        rows.some = counts[i] <= CQI_FEW_ROWS ? counts[i] : (counts[i] + 1) / 2;
        memset(taken, 0, sizeof taken);
        for (k = 0; k < rows.count; ++k) {
            const uint32_t place = cqi_place_of_sample(&rows, k);
            CHECK(place < rows.count && !taken[place]);
            CHECK(rows.some == rows.count ? place == k : (place < rows.some) == (k % 2 == 0));
            taken[place] = 1;
        }
    }
}

TEST(there_is_room_for_a_tenth_of_the_vertices_within_limits) {
    CHECK_EQ(cqi_most_rows(3), 512);
    CHECK_EQ(cqi_most_rows(5129), 512);
    CHECK_EQ(cqi_most_rows(5130), 513);
    CHECK_EQ(cqi_most_rows(20479), 2047);
    CHECK_EQ(cqi_most_rows(20480), 2048);
    CHECK_EQ(cqi_most_rows(1000000), 2048);
}

/* As for the stream, it makes no difference which of two components an error is of. */
TEST(components_share_the_counts_of_their_errors) {
    uint32_t apart[CQI_SIZES] = {0}, together[CQI_SIZES] = {0};
    cqi_rows rows;
    rows.count = 100;
    apart[0] = 100;
    CHECK_EQ(cqi_cost_of_sizes(&rows, apart, 1), 0);
    together[0] = 100;
    together[5] = 100;
    CHECK_EQ(cqi_cost_of_sizes(&rows, together, 2), 8 * (200 + 500)); /* a bit for each of 200, and 5 for 100 of them */
}

int main(void) {
    RUN(weights_are_found_that_made_the_rows);
    RUN(rows_that_are_not_among_some_have_the_last_word);
    RUN(each_sample_has_a_place_and_every_second_one_is_among_some);
    RUN(there_is_room_for_a_tenth_of_the_vertices_within_limits);
    RUN(components_share_the_counts_of_their_errors);
    return TEST_END();
}
