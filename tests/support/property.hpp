// A program of properties. RapidCheck prints the seed of a run and, on a failure, a line with RC_PARAMS; run the
// program again with it to see the same case:
//
//     RC_PARAMS='reproduce=BchR3bYZ...' build/tests/property/mesh      that case, shrunk
//     RC_PARAMS='seed=1234' build/tests/property/mesh                  the same run
//     RC_PARAMS='max_success=10000 max_size=200' ...                   a longer one
//     build/tests/property/mesh collapse                               only properties whose name contains "collapse"
#ifndef CQ_TESTS_PROPERTY_HPP
#define CQ_TESTS_PROPERTY_HPP

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>

#include <rapidcheck.h>

#include "exact.h"
#include "manifold.hpp"

class Properties {
public:
    // RapidCheck says how to reproduce failures when the program ends. What is registered before its first check comes
    // behind that: the counts are the last line.
    Properties(int argc, char **argv) : filter(argc > 1 ? argv[1] : "") { std::atexit(print_counts); }

    template <typename Testable>
    void operator()(const std::string &sentence, Testable &&testable) {
        if (sentence.find(filter) == std::string::npos) return;
        bool holds = rc::check(sentence, std::forward<Testable>(testable));
        ++(holds ? passed : failed);
        std::fflush(nullptr);
    }

    int end() const { return failed != 0 || passed == 0; }

private:
    std::string filter;
    static inline int passed = 0, failed = 0;

    static void print_counts() {
        std::cerr.flush();
        std::printf("%d passed, %d failed\n", passed, failed);
        std::fflush(nullptr);
    }
};

// A block of exactly `size` bytes, freed when a failed assertion leaves the property too.
class Exact {
public:
    explicit Exact(size_t size) : block(exact_alloc(size)) {}
    Exact(const void *from, size_t size) : block(exact_copy(from, size)) {}
    ~Exact() { exact_free(block); }
    Exact(const Exact &) = delete;
    Exact &operator=(const Exact &) = delete;
    uint8_t *data() const { return static_cast<uint8_t *>(block); }

private:
    void *block;
};

// Numbers of all 32 bits at any size of a case; only their count shrinks.
inline rc::Gen<std::vector<uint32_t>> any_numbers(double scale)
{
    auto number = rc::gen::noShrink(rc::gen::resize(rc::kNominalSize, rc::gen::arbitrary<uint32_t>()));
    return rc::gen::scale(scale, rc::gen::container<std::vector<uint32_t>>(number));
}

// Recipes of meshes with up to about 100 * scale operations.
inline rc::Gen<Recipe> any_recipe(double scale)
{
    auto seed = rc::gen::resize(rc::kNominalSize, rc::gen::arbitrary<uint32_t>());
    auto parts = rc::gen::tuple(any_numbers(0.04), any_numbers(scale), any_numbers(0.12), seed);
    return rc::gen::map(parts, [](const auto &t) {
        return Recipe{std::get<0>(t), std::get<1>(t), std::get<2>(t), std::get<3>(t)};
    });
}

#endif
