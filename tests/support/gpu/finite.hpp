// Shaders as a compiler may make them that assumes finite numbers: where a result is infinite or not a number, it may
// give any other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace test {

// The number that an infinite result or NaN becomes.
enum class Instead { largest, zero };

// Returns the module with this change behind each operation that returns floats, reads them or takes them from bits.
std::vector<std::uint32_t> with_finite_results(std::span<const std::uint32_t> spirv, Instead instead);

// Returns whether a constant is infinite or NaN, or an operation looks for such numbers.
bool mentions_infinity(std::span<const std::uint32_t> spirv);

}  // namespace test
