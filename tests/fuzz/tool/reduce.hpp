#pragma once

#include <string>

#include "fuzz/isolate.hpp"

namespace test::fuzz {

// The least case that fails in the same way (sort_of the failure), as far as some time allows.
Case reduce(Case c, const std::string& failure, const Limits& limits);

}  // namespace test::fuzz
