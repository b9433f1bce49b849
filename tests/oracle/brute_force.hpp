// The exact Voronoi diagram by definition, in integer arithmetic: slow, short, and without a line of the engine.
// The face of two seeds is the part of their bisector inside the box and on the near side of every other bisector; they
// are neighbors when that polygon has positive area.
#pragma once

#include <gmpxx.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace test {

inline constexpr mp_bitcnt_t precision = 320;

struct ExactCell {
    std::vector<std::int32_t> faces;  // neighbors and walls -1..-6, ascending
    std::size_t edges = 0;
    std::size_t vertices = 0;
    // 320 bits: sums of exact parts without cancellation, so every double that could be right is told from the others.
    // As one rational it would have tens of thousands of digits.
    mpf_class volume{0, precision};
    std::array<mpf_class, 3> centroid;  // absolute; 0 for a duplicate
    std::array<double, 3> extent{};     // size of the cell along each axis
};

struct ExactDiagram {
    std::vector<ExactCell> cells;            // a duplicate has an empty cell
    std::vector<std::int32_t> duplicate_of;  // -1 for those that are not
};

ExactDiagram brute_force(std::span<const double> points, const votess::Box& box);

// Whether cell i has a face with j (a wall when negative) for one pair among many seeds: candidates come nearest first
// and stop at twice the distance of the farthest vertex left, beyond which no bisector reaches the polygon.
bool exact_face(std::span<const double> points, const votess::Box& box, std::size_t i, std::int32_t j);

mpf_class exact_volume(const votess::Box& box);

}  // namespace test
