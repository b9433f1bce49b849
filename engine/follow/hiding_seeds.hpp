// Seeds that hide another: four whose half-spaces have no place in common, so that it has no cell.
//
// They are stored as a cell of four faces that is turned inside out. Their normals point to all sides, so each three
// planes meet in a right corner. It lies beyond the fourth plane.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "follow/kept_cell.hpp"
#include "follow/sign_test.hpp"

namespace votess::cpu {

inline constexpr std::size_t hiding_bytes = 56;

// Walks from cell to cell to the four seeds around a hidden one: the weights of other seeds do not matter. cells:
// records by sorted seed, or null. Returns false if it does not find them. The choice is a guess in floating point.
[[nodiscard]] bool find_hiding_seeds(const SignFrame& frame, std::span<std::byte* const> cells, std::size_t seed,
                                     std::span<std::byte, hiding_bytes> out);
// Returns whether they certainly hide the seed.
[[nodiscard]] bool hide(const SignFrame& frame, SignTester test, std::size_t seed, const KeptCell& four,
                        SignTest& signs);

}  // namespace votess::cpu
