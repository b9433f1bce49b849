// Whether the library's answers to a case are right.
#pragma once

#include <string>

#include "fuzz/job.hpp"

namespace test::fuzz {

struct Judgement {
    std::string failure;      // one line, "" when all is right; its first word is the sort of failure
    std::size_t refused = 0;  // jobs that were refused, and might be
    [[nodiscard]] bool right() const { return failure.empty(); }
};

// measure: too much time or memory for few seeds is a failure too.
Judgement judge(const Case& c, const std::string& device, bool measure);

}  // namespace test::fuzz
