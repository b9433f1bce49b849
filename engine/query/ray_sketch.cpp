#include "query/ray_sketch.hpp"

#include <algorithm>
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

template <class Vectors>
VOTESS_INLINE std::size_t select_body(const SketchedCell& cell, const SketchRay& ray, float* earliest,
                                      std::uint32_t* selected) {
    using Float = typename Vectors::Float;
    using Int = typename Vectors::Int;
    using Short = typename Vectors::Short;
    const Float zero{}, never = zero + std::numeric_limits<float>::infinity();
    const Float min_slope = zero + ray.min_slope;
    const Float rise_error = zero + ray.rise, slope_error = zero + ray.slope;
    const Float constant = zero + ray.constant, relative = zero + ray.relative;
    constexpr float unit = 1 / RaySketch::units;
    const Float square = zero + (cell.constants != nullptr ? 0 : unit * unit);
    Float direction[3], twice_place[3];
    for (std::size_t k = 0; k < 3; ++k) direction[k] = zero + ray.direction[k];
    for (std::size_t k = 0; k < 3; ++k) twice_place[k] = zero + ray.twice_place[k];
    Float best = zero + std::numeric_limits<float>::max();
    float* write = earliest;
    for (std::size_t s = 0; s < cell.sketches.size(); ++s)
        for (std::size_t lane = 0; lane < RaySketch::lanes; lane += Vectors::lanes, write += Vectors::lanes) {
            Float slope{}, rise{};
            if (cell.constants != nullptr) std::memcpy(&rise, &cell.constants[s][lane], sizeof rise);
            for (std::size_t k = 0; k < 3; ++k) {
                Short way;
                std::memcpy(&way, &cell.sketches[s].way[k][lane], sizeof way);
                const Float n = __builtin_convertvector(way, Float);
                slope += n * direction[k];
                rise += n * (twice_place[k] + n * square);
            }
            const Float inverse = 1 / slope, time = rise * inverse, size = time < 0 ? -time : time;
            const Float error = (rise_error + slope_error * size) * inverse + (constant + relative * size);
            const Int approaches = slope > min_slope;
            const Float early = time - error, late = approaches ? time + error : never;
            const Float bound = approaches ? early : slope < -min_slope ? never : -never;
            std::memcpy(write, &bound, sizeof bound);
            best = late < best ? late : best;
        }
    float bound = best[0];
    for (std::size_t lane = 1; lane < Vectors::lanes; ++lane) bound = std::min(bound, best[lane]);
    const Int none{};
    Int number{}, kept{}, numbers{};
    for (std::size_t lane = 0; lane < Vectors::lanes; ++lane) number[lane] = static_cast<std::int32_t>(lane);
    const Int count = none + static_cast<std::int32_t>(cell.count);
    for (const float* read = earliest; read < write; read += Vectors::lanes) {
        Float early;
        std::memcpy(&early, read, sizeof early);
        const Int keep = ~(early > bound) & (number < count);
        kept -= keep;
        numbers += keep & number;
        number += static_cast<std::int32_t>(Vectors::lanes);
    }
    std::int32_t found = 0, sum = 0;
    for (std::size_t lane = 0; lane < Vectors::lanes; ++lane) found += kept[lane], sum += numbers[lane];
    selected[0] = static_cast<std::uint32_t>(sum);
    if (found <= 1) return static_cast<std::size_t>(found);
    found = 0;
    for (std::size_t i = 0; i < cell.count; ++i)
        if (!(earliest[i] > bound)) selected[found++] = static_cast<std::uint32_t>(i);
    return static_cast<std::size_t>(found);
}

// One function for each instruction set. The body above is inlined into each.
#define VOTESS_SELECT(NAME, VECTORS, TARGET)                                                          \
    TARGET std::size_t select_##NAME(const SketchedCell& cell, const SketchRay& ray, float* earliest, \
                                     std::uint32_t* selected) {                                       \
        return select_body<VECTORS>(cell, ray, earliest, selected);                                   \
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
