// The output of a test program in C++ whose cases are too many to name: one line for each sentence that was checked, at
// most some lines about what failed, and `N passed, N failed` at the end.
#ifndef CQ_TESTS_REPORT_HPP
#define CQ_TESTS_REPORT_HPP

#include <cstdio>
#include <string>

#include <unistd.h>

class Report {
public:
    Report() { watch(); }

    // What follows must end in time: a case that hangs is a failure, not a test that never ends.
    static void watch() { alarm(MOST_SECONDS); }

    // Notes a failure of the sentence that is being checked, and where.
    void fail(const std::string &what) {
        if (failures++ < MOST_LINES) std::printf("  %s\n", what.c_str());
    }

    bool expect(bool condition, const std::string &what) {
        if (!condition) fail(what);
        return condition;
    }

    // Ends a sentence: it holds if nothing failed since the last one.
    void end(const std::string &sentence) {
        ++(failures == 0 ? passed : failed);
        std::printf("%s  %s\n", failures == 0 ? "ok  " : "FAIL", sentence.c_str());
        std::fflush(stdout);
        failures = 0;
        watch();
    }

    // The last line, and the exit status.
    int summary() const {
        std::printf("%d passed, %d failed\n", passed, failed);
        return failed != 0 || passed == 0;
    }

private:
    enum { MOST_LINES = 8, MOST_SECONDS = 300 };
    int passed = 0, failed = 0, failures = 0;
};

#endif
