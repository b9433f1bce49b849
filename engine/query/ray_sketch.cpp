#include "query/ray_sketch.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace votess::cpu {
namespace {

#define VOTESS_INLINE inline __attribute__((always_inline))

// Vectors of a register's length: GCC 12 splits comparisons of longer ones into lanes.
struct Four {
    static constexpr std::size_t lanes = 4;
    using Float = float __attribute__((vector_size(4 * lanes)));
    using Int = std::int32_t __attribute__((vector_size(4 * lanes)));
    using Short = std::int16_t __attribute__((vector_size(2 * lanes)));
    VOTESS_INLINE static void fill(auto& v, auto x) { v = std::remove_reference_t<decltype(v)>{x, x, x, x}; }
    VOTESS_INLINE static void count(Int& v) { v = Int{0, 1, 2, 3}; }
    VOTESS_INLINE static void swap_halves(auto& to, const auto& v) { to = __builtin_shufflevector(v, v, 2, 3, 0, 1); }
    VOTESS_INLINE static void swap_quarters(auto& to, const auto& v) { to = __builtin_shufflevector(v, v, 1, 0, 3, 2); }
    VOTESS_INLINE static void swap_eighths(auto& to, const auto& v) { to = v; }
};
struct Eight {
    static constexpr std::size_t lanes = 8;
    using Float = float __attribute__((vector_size(4 * lanes)));
    using Int = std::int32_t __attribute__((vector_size(4 * lanes)));
    using Short = std::int16_t __attribute__((vector_size(2 * lanes)));
    VOTESS_INLINE static void fill(auto& v, auto x) {
        v = std::remove_reference_t<decltype(v)>{x, x, x, x, x, x, x, x};
    }
    VOTESS_INLINE static void count(Int& v) { v = Int{0, 1, 2, 3, 4, 5, 6, 7}; }
    VOTESS_INLINE static void swap_halves(auto& to, const auto& v) {
        to = __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
    }
    VOTESS_INLINE static void swap_quarters(auto& to, const auto& v) {
        to = __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
    }
    VOTESS_INLINE static void swap_eighths(auto& to, const auto& v) {
        to = __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
    }
};

// All lanes become the smallest one. In pairs: a chain of lanes would take twice as long.
template <class Vectors>
VOTESS_INLINE void minimize(typename Vectors::Float& v) {
    typename Vectors::Float other;
    Vectors::swap_halves(other, v);
    v = other < v ? other : v;
    Vectors::swap_quarters(other, v);
    v = other < v ? other : v;
    Vectors::swap_eighths(other, v);
    v = other < v ? other : v;
}
template <class Vectors>
VOTESS_INLINE std::int32_t sum_of(const typename Vectors::Int& lanes) {
    typename Vectors::Int v = lanes, other;
    Vectors::swap_halves(other, v);
    v += other;
    Vectors::swap_quarters(other, v);
    v += other;
    return Vectors::lanes == 4 ? v[0] : v[0] + v[1];
}

constexpr std::size_t max_summed = 128;  // neighbors, whose sums cannot overflow

// First finds the earliest crossing, and by when it surely comes. Then keeps each neighbor whose a / b may be that
// early: a is at most b times that bound, up to errors.
template <class Vectors>
VOTESS_INLINE std::size_t select_body(const SketchedCell& cell, const SketchRay& ray, float* scratch,
                                      std::uint32_t* selected) {
    using Float = typename Vectors::Float;
    using Int = typename Vectors::Int;
    using Short = typename Vectors::Short;
    constexpr float never = std::numeric_limits<float>::infinity(), unit = 1 / RaySketch::units;
    Float square, min_slope, endless, largest, direction[3], twice_place[3];
    Vectors::fill(square, cell.constants != nullptr ? 0 : unit * unit);
    Vectors::fill(min_slope, ray.min_slope);
    Vectors::fill(endless, never);
    Vectors::fill(largest, std::numeric_limits<float>::max());
    Vectors::fill(direction[0], ray.direction[0]);
    Vectors::fill(direction[1], ray.direction[1]);
    Vectors::fill(direction[2], ray.direction[2]);
    Vectors::fill(twice_place[0], ray.twice_place[0]);
    Vectors::fill(twice_place[1], ray.twice_place[1]);
    Vectors::fill(twice_place[2], ray.twice_place[2]);
    Float best = endless, inverse_of_best{};
    float* write = scratch;
    for (std::size_t s = 0; s < cell.sketches.size(); ++s)
        for (std::size_t lane = 0; lane < RaySketch::lanes; lane += Vectors::lanes) {
            Float slope{}, rise{};
            if (cell.constants != nullptr) std::memcpy(&rise, &cell.constants[s][lane], sizeof rise);
            for (std::size_t k = 0; k < 3; ++k) {
                Short way;
                std::memcpy(&way, &cell.sketches[s].way[k][lane], sizeof way);
                const Float n = __builtin_convertvector(__builtin_convertvector(way, Int), Float);
                slope += n * direction[k];
                rise += n * (twice_place[k] + n * square);
            }
            std::memcpy(write, &rise, sizeof rise);
            std::memcpy(write + Vectors::lanes, &slope, sizeof slope);
            write += 2 * Vectors::lanes;
            const Float inverse = 1 / slope, time = slope > min_slope ? rise * inverse : endless;
            inverse_of_best = time < best ? inverse : inverse_of_best;
            best = time < best ? time : best;
        }
    const Float size = best < 0 ? -best : best;
    Float lates = best + ((ray.rise + ray.slope * size) * inverse_of_best + ray.constant + ray.relative * size);
    lates = lates < largest ? lates : largest;
    minimize<Vectors>(lates);
    const float bound = lates[0];
    const float error = ray.rise + ray.slope * std::abs(bound) + ray.constant + ray.max_relative;
    if (cell.count < max_summed) {
        // Sums the kept numbers, and above them how many they are.
        constexpr std::int32_t one = 1 << 24;
        Float errors;
        Int count, number, sums{};
        Vectors::fill(errors, error);
        Vectors::fill(count, static_cast<std::int32_t>(cell.count));
        Vectors::count(number);
        for (const float* read = scratch; read < write; read += 2 * Vectors::lanes) {
            Float rise, slope;
            std::memcpy(&rise, read, sizeof rise);
            std::memcpy(&slope, read + Vectors::lanes, sizeof slope);
            const Int skip = (slope < -min_slope) | ((slope > min_slope) & (rise - lates * slope > errors));
            sums += ~skip & (number < count) & (number | one);
            number += static_cast<std::int32_t>(Vectors::lanes);
        }
        const std::int32_t sum = sum_of<Vectors>(sums);
        selected[0] = static_cast<std::uint32_t>(sum % one);
        if (sum < 2 * one) return static_cast<std::size_t>(sum / one);
    }
    std::size_t found = 0;
    for (std::size_t i = 0; i < cell.count; ++i) {
        const float* read = scratch + i / Vectors::lanes * 2 * Vectors::lanes + i % Vectors::lanes;
        const float rise = read[0], slope = read[Vectors::lanes];
        if (slope < -ray.min_slope || (slope > ray.min_slope && rise - bound * slope > error)) continue;
        selected[found++] = static_cast<std::uint32_t>(i);
    }
    return found;
}

// One function for each instruction set. The body above is inlined into each.
#define VOTESS_SELECT(NAME, VECTORS, TARGET)                                                         \
    TARGET std::size_t select_##NAME(const SketchedCell& cell, const SketchRay& ray, float* scratch, \
                                     std::uint32_t* selected) {                                      \
        return select_body<VECTORS>(cell, ray, scratch, selected);                                   \
    }
VOTESS_SELECT(baseline, Four, )
#if defined(__x86_64__)
VOTESS_SELECT(avx2, Eight, __attribute__((target("avx2,fma"))))
#endif

}  // namespace

SelectCrossings select_crossings([[maybe_unused]] std::string_view instructions) {
#if defined(__x86_64__)
    if (instructions.starts_with("avx")) return select_avx2;
#endif
    return select_baseline;
}

}  // namespace votess::cpu
