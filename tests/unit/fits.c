/* Fits of the weights of regular levels: that they find the weights that made the samples, from some and from all. */
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "test.h"

enum { MAX_SAMPLES = 2048, NUM_WEIGHTS = 8 };

static cqi_sample sample[MAX_SAMPLES];
static uint32_t random_state;

static int any(int least, int most)
{
    random_state = random_state * 1664525u + 1013904223u;
    return least + (int)((random_state >> 8) % (uint32_t)(most - least + 1));
}

/* Samples that these weights leave errors of at most `noise` in; those from `some` on of any size. */
static void make_samples(cqi_samples *samples, uint32_t count, uint32_t some, const int8_t *weight, int noise)
{
    uint32_t i;
    int c, k;
    random_state = count;
    samples->sample = sample;
    samples->count = count;
    samples->some = some;
    samples->parts = 1;
    memset(sample, 0, sizeof sample);
    for (i = 0; i < count; ++i)
        for (c = 0; c < 3; ++c) {
            int32_t sum = 0;
            for (k = 0; k < NUM_WEIGHTS; ++k) {
                sample[i].feature[c][k] = (int16_t)any(-2000, 2000);
                sum += weight[k] * sample[i].feature[c][k];
            }
            sample[i].offset[c] = sum / 16 + 16 * any(-noise, noise);
        }
}

TEST(weights_are_found_that_made_the_samples)
{
    static const int8_t made[NUM_WEIGHTS] = {31, -7, 0, 18, -40, 3, 25, -12};
    static const uint32_t counts[4][2] = {{60, 60}, {512, 512}, {513, 257}, {2000, 1000}};
    int i, noise;
    for (i = 0; i < 4; ++i)
        for (noise = 0; noise < 2; ++noise) {
            int8_t weight[NUM_WEIGHTS] = {0};
            cqi_samples samples;
            uint32_t cost;
            make_samples(&samples, counts[i][0], counts[i][1], made, noise);
            cost = cqi_fit_weights(&samples, 0, 1, weight, NUM_WEIGHTS, CQI_PASSES);
            CHECK(!memcmp(weight, made, sizeof made));
            CHECK(noise ? cost > 0 && cost < 8 * 3 * 2 * counts[i][0] : cost == 0);
        }
}

/* The last steps see all samples: most of them say that one weight is larger by 3. */
TEST(samples_that_are_not_among_some_have_the_last_word)
{
    static const int8_t first[NUM_WEIGHTS] = {31, -7, 0, 18, -40, 3, 25, -12};
    int8_t last[NUM_WEIGHTS], weight[NUM_WEIGHTS] = {0};
    cqi_samples samples;
    uint32_t i;
    int k;
    memcpy(last, first, sizeof last);
    last[3] += 3;
    make_samples(&samples, 2000, 200, last, 0);
    for (i = 0; i < samples.some; ++i) {
        int32_t sum = 0;
        for (k = 0; k < NUM_WEIGHTS; ++k) sum += first[k] * sample[i].feature[0][k];
        sample[i].offset[0] = sum / 16;
    }
    cqi_fit_weights(&samples, 0, 0, weight, NUM_WEIGHTS, CQI_PASSES);
    CHECK(!memcmp(weight, last, sizeof last));
    samples.count = samples.some;
    for (i = 0; i < samples.count; ++i) memset(sample[i].state, 0, sizeof sample[i].state); /* as in new ones */
    memset(weight, 0, sizeof weight);
    cqi_fit_weights(&samples, 0, 0, weight, NUM_WEIGHTS, CQI_PASSES);
    CHECK(!memcmp(weight, first, sizeof first));
}

TEST(each_sample_has_a_place_and_every_second_one_is_among_some)
{
    static const uint32_t counts[6] = {1, 2, 512, 513, 514, 2048};
    static uint8_t taken[MAX_SAMPLES];
    int i;
    for (i = 0; i < 6; ++i) {
        cqi_samples samples;
        uint32_t k;
        samples.count = counts[i];
        samples.some = counts[i] <= CQI_FEW_SAMPLES ? counts[i] : (counts[i] + 1) / 2;
        memset(taken, 0, sizeof taken);
        for (k = 0; k < samples.count; ++k) {
            const uint32_t place = cqi_place_of_sample(&samples, k);
            CHECK(place < samples.count && !taken[place]);
            CHECK(samples.some == samples.count ? place == k : (place < samples.some) == (k % 2 == 0));
            taken[place] = 1;
        }
    }
}

TEST(there_is_room_for_a_tenth_of_the_vertices_within_limits)
{
    CHECK_EQ(cqi_most_samples(3), 512);
    CHECK_EQ(cqi_most_samples(5129), 512);
    CHECK_EQ(cqi_most_samples(5130), 513);
    CHECK_EQ(cqi_most_samples(20479), 2047);
    CHECK_EQ(cqi_most_samples(20480), 2048);
    CHECK_EQ(cqi_most_samples(1000000), 2048);
}

/* As for the stream, it makes no difference which of two components an error is of. */
TEST(components_share_the_counts_of_their_errors)
{
    uint32_t apart[CQI_SIZES] = {0}, together[CQI_SIZES] = {0};
    cqi_samples samples;
    samples.count = 100;
    apart[0] = 100;
    CHECK_EQ(cqi_cost_of_sizes(&samples, apart, 1), 0);
    together[0] = 100;
    together[5] = 100;
    /* a bit for each of 200, and 5 for 100 of them */
    CHECK_EQ(cqi_cost_of_sizes(&samples, together, 2), 8 * (200 + 500));
}

int main(void)
{
    RUN(weights_are_found_that_made_the_samples);
    RUN(samples_that_are_not_among_some_have_the_last_word);
    RUN(each_sample_has_a_place_and_every_second_one_is_among_some);
    RUN(there_is_room_for_a_tenth_of_the_vertices_within_limits);
    RUN(components_share_the_counts_of_their_errors);
    return TEST_END();
}
