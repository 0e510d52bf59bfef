// coder.hpp - adaptive binary range coder, as in LZMA, with 16-bit probabilities. SPDX-License-Identifier: MIT
#ifndef FACE_COLLAPSE_CODER_HPP
#define FACE_COLLAPSE_CODER_HPP

#include <cstddef>
#include <cstdint>
#include <vector>

// The probability of a 0: the mean of what was seen, in which what is long ago fades.
class Context {
public:
    uint32_t share(uint32_t range) const { return (range >> 16) * probability; }
    void learn(bool bit) {
        int target = bit ? 32 : 65536 - 32;
        probability += (target - probability) * 2 / (2 * seen + 3);
        if (seen < 255) ++seen;
    }

private:
    int probability = 32768, seen = 0;
};

class Writer {
public:
    std::vector<uint8_t> bytes;

    bool bit(bool value, Context &context) {
        uint32_t zero = context.share(range);
        if (value) low += zero;
        range = value ? range - zero : zero;
        for (; range < 1u << 24; range <<= 8) shift();
        context.learn(value);
        return value;
    }
    void finish() {
        for (int k = 0; k < 5; ++k) shift();
    }

private:
    uint64_t low = 0;
    uint32_t range = 0xffffffff;

    void shift() {
        if (low >> 32)
            for (size_t k = bytes.size(); k-- > 0 && ++bytes[k] == 0;) {}
        bytes.push_back(static_cast<uint8_t>(low >> 24));
        low = (low & 0xffffff) << 8;
    }
};

class Reader {
public:
    explicit Reader(const std::vector<uint8_t> &b) : bytes(b) {
        for (int k = 0; k < 4; ++k) code = code << 8 | next();
    }

    bool bit(bool, Context &context) {   // the value is what a writer would write
        uint32_t zero = context.share(range);
        bool value = code >= zero;
        if (value) code -= zero;
        range = value ? range - zero : zero;
        for (; range < 1u << 24; range <<= 8) code = code << 8 | next();
        context.learn(value);
        return value;
    }

private:
    const std::vector<uint8_t> &bytes;
    size_t position = 0;
    uint32_t code = 0, range = 0xffffffff;

    uint32_t next() { return position < bytes.size() ? bytes[position++] : 0; }
};

#endif
