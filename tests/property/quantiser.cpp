// The quantiser on random boxes: anywhere, of any size that floats have, and flat ones; and on random directions.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "property.hpp"

#include <algorithm>
#include <cmath>

namespace {

using Floats = std::vector<float>;
using Values = std::vector<cq_value>;

float clamped(double x) { return static_cast<float>(std::fmax(-3.4028234e38, std::fmin(x, 3.4028234e38))); }

double uniform(Random &random) { return random.below(1u << 31) / 2147483648.0; }

// Coordinates of up to 40 vertices. The box has any size between the smallest and the largest float, is around zero,
// beside it or far from it, and may be flat in some directions, or a point.
Floats any_box(Random &random, uint32_t components)
{
    double size = std::ldexp(1 + uniform(random), static_cast<int>(random.below(276)) - 149);
    double shift = random.below(3) == 0 ? -0.5 : std::ldexp(uniform(random) - 0.5, static_cast<int>(random.below(30)));
    uint32_t flat = random.below(2) ? 0 : random.below(1u << components);
    Floats box(components * (1 + random.below(40)));
    for (size_t i = 0; i < box.size(); ++i) {
        double x = flat >> i % components & 1 ? 0.25 : random.below(4) ? uniform(random) : random.below(2);
        box[i] = clamped((x + shift) * size);
    }
    return box;
}

int any_bits(Random &random, int limit)
{
    return 1 + static_cast<int>(random.below(static_cast<size_t>(std::min(limit, CQ_MAX_BITS))));
}

cq_channel any_channel(Random &random)
{
    cq_channel c{};
    c.kind = CQ_GENERIC;
    c.components = static_cast<uint8_t>(1 + random.below(CQ_MAX_COMPONENTS));
    c.bits = static_cast<uint8_t>(any_bits(random, CQ_MAX_BITS));
    return c;
}

double step_of(const cq_channel &c) { return static_cast<double>(cq_channel_step(&c)); }

Values quantise(const cq_channel &c, const Floats &from)
{
    Values to(from.size());
    RC_ASSERT(cq_quantise(&c, from.data(), from.size() / c.components, to.data(), nullptr) == CQ_OK);
    for (cq_value x : to) RC_ASSERT(x >= 0 && x >> c.bits == 0);
    return to;
}

Floats reconstruct(const cq_channel &c, const Values &from)
{
    Floats to(from.size());
    cq_reconstruct(&c, from.data(), from.size() / c.components, to.data());
    return to;
}

// Half the distance from x to the next float away from zero.
double half_ulp(float x)
{
    float magnitude = std::fabs(x);
    return (static_cast<double>(std::nextafter(magnitude, HUGE_VALF)) - static_cast<double>(magnitude)) / 2;
}

void check_bound(const cq_channel &c, const Floats &from, const Floats &back)
{
    double bound = (0.5 + std::ldexp(1.0, -26)) * step_of(c);
    for (size_t i = 0; i < from.size(); ++i) {
        double error = std::fabs(static_cast<double>(from[i]) - static_cast<double>(back[i]));
        RC_ASSERT(error <= bound + (from[i] == back[i] ? 0 : half_ulp(back[i])));
    }
}

bool same_floats(const Floats &a, const Floats &b)
{
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

Random any_random() { return Random{*rc::gen::noShrink(rc::gen::arbitrary<uint32_t>())}; }

void coordinates_come_back_within_half_a_step_and_then_for_ever()
{
    Random random = any_random();
    cq_channel c = any_channel(random);
    Floats box = any_box(random, c.components);
    if (cq_fit_grid(&c, box.data(), box.size() / c.components, nullptr) != CQ_OK) {
        RC_ASSERT(c.bits == 1);
        return;
    }
    Values values = quantise(c, box);
    Floats back = reconstruct(c, values);
    check_bound(c, box, back);
    RC_ASSERT(quantise(c, back) == values);
    RC_TAG(step_of(c) == 0 ? "flat" : step_of(c) < 1e-36 ? "tiny" : step_of(c) > 1e30 ? "huge" : "usual");
}

void all_points_of_a_grid_within_the_box_are_different_floats()
{
    Random random = any_random();
    cq_channel c = any_channel(random);
    Floats box = any_box(random, c.components);
    if (cq_fit_grid(&c, box.data(), box.size() / c.components, nullptr) != CQ_OK || c.step == 0) return;
    Values values = quantise(c, box), limit(values.begin(), values.begin() + c.components);
    for (size_t i = 0; i < values.size(); ++i)
        limit[i % c.components] = std::max(limit[i % c.components], values[i]);
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<cq_value>(random.below(static_cast<uint32_t>(limit[i % c.components]) + 1));
    RC_ASSERT(quantise(c, reconstruct(c, values)) == values);
}

// The longest side then does not reach the last point.
bool is_lengthened(const cq_channel &c, const Values &values)
{
    return *std::max_element(values.begin(), values.end()) < (1 << c.bits) - 1;
}

void a_new_grid_for_what_came_back_gives_the_same_values()
{
    Random random = any_random();
    cq_channel c = any_channel(random);
    c.bits = static_cast<uint8_t>(any_bits(random, 22));
    Floats box = any_box(random, c.components);
    if (cq_fit_grid(&c, box.data(), box.size() / c.components, nullptr) != CQ_OK) return;
    Values values = quantise(c, box);
    if (is_lengthened(c, values)) return;
    Floats back = reconstruct(c, values);
    cq_channel again = c;
    RC_ASSERT(cq_fit_grid(&again, back.data(), back.size() / c.components, nullptr) == CQ_OK);
    RC_ASSERT(quantise(again, back) == values);
}

// Two meshes that share some vertices, each with a grid of its own of the same step.
void meshes_with_the_same_step_meet_without_cracks()
{
    Random random = any_random();
    cq_channel one = any_channel(random), two;
    Floats shared = any_box(random, one.components), a = shared, b = shared;
    int exponent = 0;
    double reach = 0;
    for (float x : shared) reach = std::fmax(reach, std::fabs(static_cast<double>(x)));
    std::frexp(reach, &exponent);
    exponent = std::max(-149, std::min(127, exponent - static_cast<int>(random.below(CQ_MAX_BITS - 1))));
    float step = static_cast<float>(std::ldexp(1.0, exponent));
    for (uint32_t k = 0; k < one.components; ++k) {
        a.push_back(clamped(static_cast<double>(shared[k]) + uniform(random) * static_cast<double>(step) * 100));
        b.push_back(clamped(static_cast<double>(shared[k]) - uniform(random) * static_cast<double>(step) * 100));
        shared[k] = static_cast<float>((random.below(1000) + 0.5) * static_cast<double>(step));   // a middle, or nearly
        shared[k] = std::nextafter(shared[k], static_cast<float>(random.below(3)) - 1);
        a[k] = b[k] = shared[k];
    }
    two = one;
    if (cq_align_grid(&one, step, a.data(), a.size() / one.components, nullptr) != CQ_OK) return;
    if (cq_align_grid(&two, step, b.data(), b.size() / two.components, nullptr) != CQ_OK) return;
    Floats from_a = reconstruct(one, quantise(one, a)), from_b = reconstruct(two, quantise(two, b));
    check_bound(one, a, from_a);
    from_a.resize(shared.size());
    from_b.resize(shared.size());
    for (size_t i = 0; i < shared.size(); ++i) RC_ASSERT(from_a[i] == from_b[i]);
    RC_ASSERT(same_floats(reconstruct(one, quantise(one, from_a)), from_a));
    RC_TAG(std::memcmp(one.origin, two.origin, sizeof one.origin) ? "other origin" : "same origin");
}

void directions_come_back_within_their_bound_and_then_for_ever()
{
    Random random = any_random();
    int bits = std::max(2, any_bits(random, CQ_MAX_BITS));
    float normal[3], back[3], again[3];
    cq_value pair[2], second[2];
    double length = 0, cross[3];
    for (float &x : normal) x = random.below(5) ? static_cast<float>(uniform(random) * 2 - 1) : 0.0f;
    for (float x : normal) length += static_cast<double>(x) * static_cast<double>(x);
    if (length == 0) return;
    RC_ASSERT(cq_quantise_normals(bits, normal, 1, pair, nullptr) == CQ_OK);
    RC_ASSERT(pair[0] >= 0 && pair[0] >> bits == 0 && pair[1] >= 0 && pair[1] >> bits == 0);
    cq_reconstruct_normals(bits, pair, 1, back);
    double dot = 0, sine = 0;
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        dot += static_cast<double>(normal[k]) * static_cast<double>(back[k]);
        cross[k] = static_cast<double>(normal[i]) * static_cast<double>(back[j]) -
                   static_cast<double>(normal[j]) * static_cast<double>(back[i]);
        sine += cross[k] * cross[k];
    }
    RC_ASSERT(std::atan2(std::sqrt(sine), dot) <= 2.122 / ((1 << (bits - 1)) - 1) + 2e-7);
    if (bits > 22) return;
    RC_ASSERT(cq_quantise_normals(bits, back, 1, second, nullptr) == CQ_OK);
    RC_ASSERT(pair[0] == second[0] && pair[1] == second[1]);
    cq_reconstruct_normals(bits, second, 1, again);
    RC_ASSERT(std::memcmp(back, again, sizeof back) == 0);
}

}  // namespace

int main(int argc, char **argv)
{
    Properties property(argc, argv);
    property("coordinates come back within half a step, and then for ever",
             coordinates_come_back_within_half_a_step_and_then_for_ever);
    property("all points of a grid within the box are different floats",
             all_points_of_a_grid_within_the_box_are_different_floats);
    property("a new grid for what came back gives the same values",
             a_new_grid_for_what_came_back_gives_the_same_values);
    property("meshes with the same step meet without cracks", meshes_with_the_same_step_meet_without_cracks);
    property("directions come back within their bound, and then for ever",
             directions_come_back_within_their_bound_and_then_for_ever);
    return property.end();
}
