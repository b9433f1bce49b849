// Whether the library's answers to a case are right.
#pragma once

#include <string>

#include "fuzz/job.hpp"

namespace test::fuzz {

struct Judgement {
    std::string failure;      // one line, "" when all is right
    std::size_t refused = 0;  // jobs that were refused, and might be
    [[nodiscard]] bool right() const { return failure.empty(); }
};

// The words of a failure without the numbers: what failures of one sort have in common.
std::string sort_of(const std::string& failure);

// measure: too much time or memory for few seeds is a failure too.
Judgement judge(const Case& c, const std::string& device, bool measure);

}  // namespace test::fuzz
