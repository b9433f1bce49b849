#include "query/ray_sketch.hpp"

#include <cmath>
#include <cstring>
#include <limits>

namespace votess::cpu {
namespace {

#define VOTESS_INLINE inline __attribute__((always_inline))

// Vectors of a register's length: GCC 12 splits comparisons of longer ones into lanes.
struct Four {
    static constexpr std::size_t lanes = 4;
    using Float = float __attribute__((vector_size(4 * lanes)));
    using Int = std::int32_t __attribute__((vector_size(4 * lanes)));
    using Short = std::int16_t __attribute__((vector_size(2 * lanes)));
};
struct Eight {
    static constexpr std::size_t lanes = 8;
    using Float = float __attribute__((vector_size(4 * lanes)));
    using Int = std::int32_t __attribute__((vector_size(4 * lanes)));
    using Short = std::int16_t __attribute__((vector_size(2 * lanes)));
};

constexpr std::size_t max_summed = 128;  // neighbors

template <class Vector, class Value>
VOTESS_INLINE void fill(Vector& v, Value value) {
    for (std::size_t lane = 0; lane < sizeof v / sizeof value; ++lane) v[lane] = value;
}

// First finds the earliest crossing, and by when it surely comes. Then keeps each neighbor whose a / b may be that
// early: a <= b bound, but for errors.
template <class Vectors>
VOTESS_INLINE std::size_t select_body(const SketchedCell& cell, const SketchRay& ray, float* scratch,
                                      std::uint32_t* selected) {
    using Float = typename Vectors::Float;
    using Int = typename Vectors::Int;
    using Short = typename Vectors::Short;
    constexpr float never = std::numeric_limits<float>::infinity(), unit = 1 / RaySketch::units;
    Float square, min_slope, endless, direction[3], twice_place[3];
    fill(square, cell.constants != nullptr ? 0 : unit * unit);
    fill(min_slope, ray.min_slope);
    fill(endless, never);
    for (std::size_t k = 0; k < 3; ++k) fill(direction[k], ray.direction[k]);
    for (std::size_t k = 0; k < 3; ++k) fill(twice_place[k], ray.twice_place[k]);
    Float best = endless, slope_of_best = endless;
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
            const Float time = slope > min_slope ? rise / slope : endless;
            slope_of_best = time < best ? slope : slope_of_best;
            best = time < best ? time : best;
        }
    const Float size = best < 0 ? -best : best;
    const Float lates = best + ((ray.rise + ray.slope * size) / slope_of_best + ray.constant + ray.relative * size);
    std::array<float, Vectors::lanes> late;
    std::memcpy(late.data(), &lates, sizeof lates);
    float bound = std::numeric_limits<float>::max();
    for (const float time : late) bound = time < bound ? time : bound;
    const float error = ray.rise + ray.slope * std::abs(bound) + ray.constant + ray.max_relative;
    Float times, errors;
    fill(times, bound);
    fill(errors, error);
    // Sums the kept numbers, and above them how many they are.
    constexpr std::int32_t one = 1 << 24;
    Int count, number, sums{};
    fill(count, static_cast<std::int32_t>(cell.count));
    for (std::size_t lane = 0; lane < Vectors::lanes; ++lane) number[lane] = static_cast<std::int32_t>(lane);
    for (const float* read = scratch; read < write; read += 2 * Vectors::lanes) {
        Float rise, slope;
        std::memcpy(&rise, read, sizeof rise);
        std::memcpy(&slope, read + Vectors::lanes, sizeof slope);
        const Int skip = (slope < -min_slope) | ((slope > min_slope) & (rise - times * slope > errors));
        sums += ~skip & (number < count) & (number | one);
        number += static_cast<std::int32_t>(Vectors::lanes);
    }
    std::array<std::int32_t, Vectors::lanes> parts;
    std::memcpy(parts.data(), &sums, sizeof sums);
    std::int32_t sum = 0;
    for (const std::int32_t part : parts) sum += part;
    selected[0] = static_cast<std::uint32_t>(sum) % one;
    std::size_t found = static_cast<std::uint32_t>(sum) / one;
    if (cell.count < max_summed && found <= 1) return found;
    found = 0;
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
