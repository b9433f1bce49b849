// Vector loops over the candidates of a star, for several instruction sets, chosen at run time. Their results are exact
// or checked, so lists do not depend on the choice.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#include "polytope/cell_kernels.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

inline constexpr int box_fan = 8;

// Boxes of eight siblings. Missing ones are infinitely far away.
struct alignas(64) BoxBlock {
    double lower[3][box_fan];
    double upper[3][box_fan];
};

// Upper bounds of the weights of seeds in eight boxes: w <= top + slope.(x - c), where c is the center of the box. For
// sums of few terms, also w <= at_zero + slope.x, and `size` is the largest sum of the sizes of these terms.
struct alignas(64) WeightBlock {
    double top[box_fan];
    double slope[3][box_fan];
    double at_zero[box_fan], size[box_fan];

    // Sets at_zero and size from the others.
    void extend(std::size_t i, const Box& box_i) {
        constexpr double slack = 4e-15;  // of the terms of a bound
        double by = 0, terms = std::abs(top[i]), farthest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double along = slope[k][i] * (0.5 * (box_i.lower[k] + box_i.upper[k]));
            by += along;
            terms += std::abs(along);
            farthest += std::abs(slope[k][i]) * std::max(std::abs(box_i.lower[k]), std::abs(box_i.upper[k]));
        }
        at_zero[i] = top[i] - by + slack * terms;
        size[i] = std::abs(at_zero[i]) + farthest;
    }
};

// The excess of a seed over those whose cells are searched: its residual w - base - slope.(x - origin) less `least`,
// the smallest residual of theirs, rounded down.
struct WeightTilt {
    double slope[3], origin[3];
    double base, least;
    double largest;  // bound on coordinates of seeds
};

// Whether a seed is so near and so heavy that D^2 - 2 length D < square + its excess, where D is its distance, or
// `nearest` if that is more.
//
// As 2 D <= D^2 / far + far for any `far`, no seed passes where share D^2 - excess >= square + length far, with share =
// 1 - length / far. This is sharp at D = far, and where length is 0.
struct HeavierTest {
    HeavierTest(const WeightTilt& tilt, double max_length, double added, double nearest_seed)
        : length(max_length), square(added), nearest(nearest_seed), constant(tilt.base + tilt.least) {
        double size = std::abs(tilt.base) + std::abs(tilt.least);
        for (std::size_t k = 0; k < 3; ++k) {
            slope[k] = tilt.slope[k];
            constant -= slope[k] * tilt.origin[k];
            size += std::abs(slope[k]) * (std::abs(tilt.origin[k]) + tilt.largest);
        }
        // The place in a box is off by a few units of its coordinates.
        rounding = 4e-15 * size + 1e-30 * tilt.largest * tilt.largest;
        set_far(std::max(nearest, length + std::sqrt(length * length + square)));
    }
    // Sets `far`, at least `length`.
    void set_far(double far) {
        share = far > 0 ? std::max(0.0, 1 - length / far) : 1;
        turn = share > 0 ? 0.5 / share : 0;
        limit_at(far, limit);
    }
    // far: of one box, or of several in vectors.
    template <class Far>
    [[gnu::always_inline]] void limit_at(const Far& far, Far& out) const {
        constexpr double smallest_area = 1e-140;  // squares below it may have underflowed
        out = length * (1 + 1e-12) * far + (square + rounding + smallest_area);
    }

    double length, square, nearest;
    double slope[3], constant;  // the excess is w - slope.x - constant
    double rounding;            // of the excess, except that of the bound of w
    double share, turn, limit;  // turn = 0.5 / share
};

// Seeds near a home group as integers: (coordinate - origin) * scale, rounded, or clamped to +-window_range. Seeds
// other than candidates are `far_away`.
inline constexpr std::int32_t window_range = 1 << 29;
inline constexpr std::int32_t far_away = (1 << 30) - 1;
struct WindowSeeds {
    const std::int32_t* x;
    const std::int32_t* y;
    const std::int32_t* z;
    const std::int32_t* id;
    const float* weight;  // in a power diagram the residuals, in squared units; else null
    int count;            // readable up to the next multiple of 16, with seeds far away
};

// Candidate planes n.x = h of a cell in window units. h = |n|^2 / 2, or (|n|^2 + r_p - r_q) / 2 in a power diagram,
// with the residuals r of weights. A wall is the bisector with the mirror image. From `count` up to the next multiple
// of 16 are planes that nothing touches.
struct CandidatePlanes {
    static constexpr int capacity = 400;
    static constexpr float never = 1e30f;           // h of a plane that nothing touches
    static constexpr int room = 2 * capacity + 32;  // select() first puts the far ones behind the others
    static constexpr int index_bits = 0x1ff;        // cover `capacity` and the planes behind the last one
    static_assert(capacity + 16 <= index_bits);
    alignas(64) float nx[room];
    alignas(64) float ny[room];
    alignas(64) float nz[room];
    alignas(64) float h[room];
    alignas(64) std::int32_t id[room];
    int count = 0;
    int near = 0;               // planes of the walls and of the nearest seeds come first
    float longest_squared = 0;  // of the normals that select() has added, in a power diagram
};

struct Ray {  // o + t d; o[3] and d[3] are free
    float o[4], d[4];
    float limit;
};

// Tests for seeds q in the ball around p + v / scale through p: n.v >= |n|^2 / 2 - slack.
struct GroupTest {
    std::array<double, 3> p;
    double scale;
    std::array<double, 3> v;
    double slack;
};

struct GroupSource {
    const double* seeds[3];  // coordinates
    const double* weights;   // null without weights
    std::span<const std::uint32_t> groups;
    std::size_t kept;
};
struct WindowFrame {
    Box home;
    double distance_squared;  // without weights
    double origin[3], scale;
    const WeightTilt* tilt;  // null without weights
    double length;           // with weights, see near_heavier()
};
// Which planes to select: those nearer to the seed than sqrt(distance_squared) / 2, by more than `slack` in h.
struct SelectLimits {
    float near_squared, distance_squared;
    float slack;
};

struct StarKernels {
    const char* name;
    // Returns bit k if box k is nearer than sqrt(distance_squared) to the box home. For a point, lower = upper.
    unsigned (*near_boxes)(const BoxBlock&, const Box& home, double distance_squared);
    // Returns bit k if a seed in box k may pass the test, with its distance from the box home.
    unsigned (*near_heavier)(const BoxBlock&, const WeightBlock&, const Box& home, const HeavierTest&);
    // Writes first + k for each bit k of eight, in order. There is room for eight. Returns the number of bits.
    int (*list_bits)(unsigned mask, std::uint32_t first, std::uint32_t* out);
    // Returns the bits of those of eight seeds that may lie in the ball, and are at least sqrt(least) / scale from p.
    unsigned (*inside_ball)(const double* x, const double* y, const double* z, const GroupTest&, double least);
    // Writes seeds of groups as window integers, their ids, and with weights their residuals: all seeds of the first
    // `kept` groups, and seeds of the others that are nearer to `home` than sqrt(distance_squared), or that pass the
    // test of near_heavier() with square = 0. Returns their number. There must be room for all.
    int (*to_window)(const GroupSource&, const WindowFrame&, std::int32_t* const* out, std::int32_t* ids,
                     float* residuals);
    // Adds the planes of all window seeds within the limits. Planes nearer than sqrt(near_squared) / 2 come first.
    // weight: of p, as in the window. Returns false when they are too many.
    bool (*select)(const WindowSeeds&, const std::int32_t* p, float weight, const SelectLimits&, CandidatePlanes&);
    // Finds the first plane that each of some rays hits, among the first `count` planes that it leaves (n.d > limit);
    // -1 if none. This is a guess: planes within 2^-12 of the smallest t count as equal, and the plane may be beyond
    // `count`.
    void (*first_hits)(const CandidatePlanes&, int count, const Ray* rays, int number, int* hits);
    // Returns the first plane with h - n.v <= v[3] other than the three, from plane `begin` on, or -1 if none of the
    // first `count` is. It may be beyond `count`.
    int (*touching)(const CandidatePlanes&, int count, const float* v, const std::int32_t* three, int begin);
    // places[k] = how many of `count` different ids are smaller than ids[k]. There is room for 32 places or more.
    void (*rank)(const std::int32_t* ids, int count, std::uint32_t* places);
    // Sorts the corners and appends fillers.
    void (*order_corners)(const CellShape&, CornerOrder&);
    // Returns false if rounding might spoil promised digits. Last digits depend on the instruction set.
    bool (*measure)(CellShape&, CellMeasures&);
};

template <class Isa>
class CellMeter;

// The functions of one instruction set. The walk calls them by name, so that they can be inlined.
template <class Isa>
inline constexpr StarKernels kernels_of{Isa::name,        Isa::near_boxes, Isa::near_heavier,  Isa::list_bits,
                                        Isa::inside_ball, Isa::to_window,  Isa::select,        Isa::first_hits,
                                        Isa::touching,    Isa::rank,       Isa::order_corners, CellMeter<Isa>::measure};
extern const StarKernels star_kernels_avx2;

// Returns the functions for a set of supported_kernels(). avx512 gets those of AVX2: loops over vectors of 512 bits
// took 4 to 12 % longer for a cell on one processor. On another these and 256 bits with masks gained 1.5 % at most.
const StarKernels& star_kernels(std::string_view name);

}  // namespace votess::cpu
