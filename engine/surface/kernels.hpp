// Vector loops over seeds and over corners on a triangle, compiled for several instruction sets and chosen at run time.
// All do the same operations in the same order, so their results are equal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/vector3.hpp"
#include "exact/predicate.hpp"
#include "kernels/star_kernels.hpp"

namespace votess::surface {

inline constexpr std::size_t group = 8;  // seeds that follow each other

// A triangle, relative to its center except for the box.
struct TriangleFrame {
    Box box;
    exact::Point center;
    Vector3 first;               // the first vertex
    std::array<Vector3, 2> way;  // from there to the others
    double length;               // a bound on all three
};

// At weights (u, v) of the triangle's second and third vertex the square of the distance from a seed, less that from
// the center, is f + u du + v dv.
struct alignas(64) SeedFunctions {
    double f[group], du[group], dv[group];
    double error[group];   // bounds, of each
    double change[group];  // |du| + |dv|
    double square[group];  // of the distance from the triangle's box
};

// Corners of the lower envelope of some functions. From `count` up to the next multiple of 8 they have a value of -inf
// and a square of 0.
struct alignas(64) Envelope {
    static constexpr std::size_t max_seeds = 512, room = 2 * max_seeds + 2 + group;
    double u[room], v[room];
    double value[room], square[room];  // square: of the distance from the seeds there
    double error[room];                // bounds, of u and v
    std::size_t count = 0;
    double max_error = 0;                        // of all corners so far
    double max_value_error = 0, max_change = 0;  // of all functions there so far
    double reach = 0;                            // square of the distance up to which seeds may cut

    // Errors of values at a corner, by those of the functions there: weights add up to less than 5, and sums are
    // rounded.
    static constexpr double value_errors = 10;
};

// The sites around a new cell, in order. Along the side with each the function g + u gu + v gv is 0. The first follows
// the last again.
struct alignas(64) Ring {
    static constexpr std::size_t room = Envelope::room + group;
    double g[room], gu[room], gv[room];
    double error[room];  // bounds, of each
    double size[room];   // of the largest
    std::size_t count = 0;
    // Corners: each lies between a site and the next.
    double u[room], v[room], value[room], square[room], corner_error[room];
};

struct SurfaceKernels {
    // Returns bit k if the square of the distance of box k from `home` is at most `reach`. Writes the squares.
    unsigned (*near_boxes)(const cpu::BoxBlock&, const Box& home, double reach, double* squares);
    // Returns bit k if the square of the distance of seed k from the triangle's box is at most `reach`. Then writes the
    // functions of all eight.
    unsigned (*near_seeds)(const double* const* places, const TriangleFrame&, double reach, SeedFunctions&);
    // Returns the first pending seed that is nearer to a corner than its seeds are, or may be, and clears its bit and
    // those before; or returns `group`. Bit j of removed[b] becomes 1 if it is surely nearer to corner 8 b + j.
    // is_sure: whether all signs are sure.
    std::size_t (*next_cutting)(const SeedFunctions&, unsigned& pending, const Envelope&, std::uint8_t* removed,
                                bool& is_sure);
    // Finds the corners of a ring around the cell with a function. Where the bound on their error is not below 1, it is
    // 1, and they lie somewhere in the triangle.
    void (*place_corners)(Ring&, const TriangleFrame&, double f, double du, double dv);
    // Returns the largest square of a corner.
    double (*largest_square)(const Envelope&);
};

// Those for the best instruction set. avx512 gets those of AVX2: on a processor that has it, its own gained 8 % with
// 110 seeds on each triangle, and nothing with 6.
[[nodiscard]] const SurfaceKernels& surface_kernels();

}  // namespace votess::surface
