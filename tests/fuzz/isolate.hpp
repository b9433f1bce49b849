// Judges a case in a process of its own, which crashes, hangs and takes memory alone.
#pragma once

#include <string>

#include "fuzz/job.hpp"

namespace test::fuzz {

struct Limits {
    std::string device = "cpu";
    unsigned seconds = 20;  // of processor time for one case, then it hangs; ten times that on the wall
};

// For the process that judges: it ends by a signal beyond these.
void start_limits(const Limits& limits);
void limit_memory(const Limits& limits);
// How the process ended: "" when it did by itself.
std::string describe_end(int status);

// What judge() says of the case, or how the process ended.
std::string judge_apart(const Case& c, const Limits& limits);

}  // namespace test::fuzz
