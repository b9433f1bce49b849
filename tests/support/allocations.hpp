#pragma once

#include <cstddef>
#include <optional>

namespace test {

// Times that memory was taken by `new`, by any thread since the start; none under sanitizers, which have their own.
std::optional<std::size_t> allocations();

}  // namespace test
