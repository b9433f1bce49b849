#pragma once

#include <string>

#include "fuzz/job.hpp"

namespace test::fuzz {

struct Judgement {
    std::string failure;      // one line, "" when all answers are right
    std::size_t jobs = 0;     // tried
    std::size_t refused = 0;  // jobs, all of which may be refused
    std::size_t cells = 0;
    std::size_t fallback_cells = 0;
    [[nodiscard]] bool right() const { return failure.empty(); }
};

// Returns the words of a failure without its numbers. Failures of the same sort have the same words.
std::string sort_of(const std::string& failure);

// Runs the jobs on `kept` and proves the answers. measure: too much time or memory for few seeds is a failure too.
Judgement judge(const Case& c, const std::string& device, bool measure, votess::Tessellator& kept);

}  // namespace test::fuzz
