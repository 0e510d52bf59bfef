// files.hpp - one comparison for each file of a command line. SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <exception>
#include <stdexcept>

// The exit status: 1 if one failed. A file that compare refuses as an invalid argument is only named.
template <typename Compare>
int compare_files(int argc, char **argv, Compare &&compare)
{
    int status = 0;
    for (int k = 1; k < argc; ++k) {
        try {
            compare(argv[k]);
        } catch (const std::invalid_argument &e) {
            std::fprintf(stderr, "not compared: %s\n", e.what());
        } catch (const std::exception &e) {
            std::fprintf(stderr, "FAILED: %s: %s\n", argv[k], e.what());
            status = 1;
        }
        std::fflush(stdout);
    }
    return status;
}
