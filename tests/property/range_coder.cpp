// The range coder on random mixtures of symbols, adaptive bits and raw numbers.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include <cmath>

#include "property.hpp"

namespace {

struct Operation {
    enum Kind { freq, bit, raw } kind;
    uint32_t start, width, total;   // freq; of raw: value and bits; of bit: bit, model and rate
};

enum { MODELS = 4 };

// A sequence that depends on nothing but the numbers. `skew` 0 .. 3: how improbable the improbable symbols are.
std::vector<Operation> operations_from(const std::vector<uint32_t> &numbers, uint32_t skew)
{
    std::vector<Operation> all;
    for (uint32_t number : numbers) {
        Random random{number};
        Operation o{};
        switch (random.below(3)) {
        case 0: {
            o.kind = Operation::freq;
            o.total = random.below(4) == 0 ? 65536 : 1 + random.below(random.below(2) == 0 ? 65536 : 16);
            o.start = random.below(o.total);
            o.width = 1 + random.below(o.total - o.start);
            if (skew == 3 && random.below(4) != 0) o.start = 0, o.width = o.total;
            break;
        }
        case 1:
            o.kind = Operation::bit;
            o.start = skew == 0 ? random.below(2) : random.below(20u << skew) == 0;
            o.width = random.below(MODELS);
            o.total = 1 + o.width * 2 + random.below(2);   // a model keeps nearly to its rate
            break;
        default:
            o.kind = Operation::raw;
            o.width = random.below(33);
            o.start = o.width == 0 ? 0 : static_cast<uint32_t>(random()) >> (32 - o.width);
            if (random.below(8) == 0) o.start = 0;
            else if (random.below(8) == 0 && o.width > 0) o.start = 0xffffffffu >> (32 - o.width);
            break;
        }
        all.push_back(o);
    }
    return all;
}

struct Models {
    cq_bit_model m[MODELS];
    Models() {
        for (cq_bit_model &x : m) x = CQ_BIT_MODEL_INIT;
    }
};

// Encodes into a buffer of exactly `size` bytes; the whole size of the code, the bits it should take, the bytes.
struct Code {
    size_t size;
    double bits = 0;
    std::vector<uint8_t> bytes;
    Models models;

    Code(const std::vector<Operation> &all, size_t capacity) {
        Exact buffer(capacity);
        cq_range_encoder e;
        cq_range_encoder_init(&e, buffer.data(), capacity);
        for (const Operation &o : all) {
            if (o.kind == Operation::freq) {
                cq_encode_freq(&e, o.start, o.width, o.total);
                bits += std::log2(double(o.total) / o.width);
            } else if (o.kind == Operation::bit) {
                cq_bit_model &m = models.m[o.width];
                bits += std::log2(65536.0 / (o.start ? m : 65536 - m));
                cq_encode_bit(&e, &m, static_cast<int>(o.total), static_cast<int>(o.start));
            } else {
                cq_encode_raw(&e, o.start, static_cast<int>(o.width));
                bits += o.width;
            }
        }
        size = cq_range_encoder_finish(&e);
        bytes.assign(buffer.data(), buffer.data() + std::min(size, capacity));
    }
};

// How many operations come back right.
size_t decode(const std::vector<Operation> &all, const std::vector<uint8_t> &bytes, Models &models,
              cq_range_decoder &d)
{
    Exact data(bytes.data(), bytes.size());
    cq_range_decoder_init(&d, data.data(), bytes.size());
    size_t right = 0;
    for (const Operation &o : all) {
        if (o.kind == Operation::freq) {
            uint32_t slot = cq_decode_slot(&d, o.total);
            RC_ASSERT(slot < o.total);
            if (slot < o.start || slot - o.start >= o.width) break;
            cq_decode_freq(&d, o.start, o.width, o.total);
        } else if (o.kind == Operation::bit) {
            if (cq_decode_bit(&d, &models.m[o.width], static_cast<int>(o.total)) != static_cast<int>(o.start)) break;
        } else {
            if (cq_decode_raw(&d, static_cast<int>(o.width)) != o.start) break;
        }
        right++;
    }
    d.data = nullptr;
    return right;
}

enum { PLENTY = 1 << 16 };

std::vector<Operation> any_operations(double scale)
{
    auto skew = *rc::gen::inRange<uint32_t>(0, 4);
    return operations_from(*any_numbers(scale), skew);
}

void any_mixture_comes_back()
{
    auto all = any_operations(10.0);
    Code code(all, PLENTY);
    RC_ASSERT(code.bytes.size() == code.size);
    Models models;
    cq_range_decoder d;
    RC_ASSERT(decode(all, code.bytes, models, d) == all.size());
    for (int k = 0; k < MODELS; ++k) RC_ASSERT(models.m[k] == code.models.m[k]);
}

void a_buffer_of_the_exact_size_is_enough_and_a_smaller_one_gets_the_head()
{
    auto all = any_operations(1.0);
    Code whole(all, PLENTY);
    for (size_t capacity = 0; capacity <= whole.size; ++capacity) {
        Code part(all, capacity);
        RC_ASSERT(part.size == whole.size);
        RC_ASSERT(std::equal(part.bytes.begin(), part.bytes.end(), whole.bytes.begin()));
    }
}

// Ends in 32 bits of ones, so that the end of the code cannot be left out as zeros by good luck.
void the_bytes_are_within_one_percent_of_the_entropy()
{
    auto skew = *rc::gen::inRange<uint32_t>(0, 3);
    Random random{*rc::gen::arbitrary<uint32_t>()};
    std::vector<uint32_t> numbers(3000);
    for (uint32_t &n : numbers) n = static_cast<uint32_t>(random());
    auto all = operations_from(numbers, skew);
    all.push_back({Operation::raw, 0xffffffffu, 32, 0});
    Code code(all, 0);
    double bits = 8.0 * double(code.size);
    RC_ASSERT(bits >= code.bits * 0.99 - 16);   // the last symbol of a total gets what the division leaves
    RC_ASSERT(bits <= code.bits * 1.01 + 16);
}

void the_code_alone_needs_no_end_marker()
{
    // Any bytes may follow a code that was given its size: the decoder never looks at them.
    auto all = any_operations(2.0);
    Code code(all, PLENTY);
    Models models;
    cq_range_decoder d;
    RC_ASSERT(decode(all, code.bytes, models, d) == all.size());
    RC_ASSERT(d.size == code.size);
    if (code.size > 0) {   // its last byte is needed
        RC_ASSERT(code.bytes.back() != 0);
        std::vector<uint8_t> shorter(code.bytes.begin(), code.bytes.end() - 1);
        Models again;
        RC_ASSERT(decode(all, shorter, again, d) < all.size());
    }
}

void any_bytes_decode_to_something_in_range()
{
    auto numbers = *any_numbers(4.0);
    auto noise = *rc::gen::container<std::vector<uint8_t>>(rc::gen::arbitrary<uint8_t>());
    bool ones = *rc::gen::arbitrary<bool>();
    for (size_t k = 0; ones && k < 8 && k < noise.size(); ++k) noise[k] = 0xff;
    Exact data(noise.data(), noise.size());
    cq_range_decoder d;
    cq_bit_model model = CQ_BIT_MODEL_INIT;
    cq_range_decoder_init(&d, data.data(), noise.size());
    for (const Operation &o : operations_from(numbers, 0)) {
        size_t before = d.count;
        if (o.kind == Operation::freq) {
            uint32_t slot = cq_decode_slot(&d, o.total);
            RC_ASSERT(slot < o.total);
            cq_decode_freq(&d, slot, 1, o.total);
        } else if (o.kind == Operation::bit) {
            int bit = cq_decode_bit(&d, &model, static_cast<int>(o.total));
            RC_ASSERT((bit == 0 || bit == 1));
            RC_ASSERT((model >= 1u && model <= 65534u));
        } else {
            uint32_t value = cq_decode_raw(&d, static_cast<int>(o.width));
            RC_ASSERT((o.width == 32u || value >> o.width == 0u));
        }
        RC_ASSERT(d.code < d.range);
        RC_ASSERT(d.count >= before);
    }
}

}  // namespace

int main(int argc, char **argv)
{
    Properties property(argc, argv);
    property("any mixture comes back", any_mixture_comes_back);
    property("a buffer of the exact size is enough and a smaller one gets the head",
             a_buffer_of_the_exact_size_is_enough_and_a_smaller_one_gets_the_head);
    property("the bytes are within one percent of the entropy", the_bytes_are_within_one_percent_of_the_entropy);
    property("the code alone needs no end marker", the_code_alone_needs_no_end_marker);
    property("any bytes decode to something in range", any_bytes_decode_to_something_in_range);
    return property.end();
}
