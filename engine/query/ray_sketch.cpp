#include "query/ray_sketch.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

namespace votess::cpu {
namespace {

#define VOTESS_INLINE inline __attribute__((always_inline))

using Float8 = float __attribute__((vector_size(4 * RaySketch::lanes)));
using Int8 = std::int32_t __attribute__((vector_size(4 * RaySketch::lanes)));
using Short8 = std::int16_t __attribute__((vector_size(2 * RaySketch::lanes)));

// Replaces the lanes that are not chosen. GCC 12 splits `?:` of vectors that are longer than a register into lanes.
VOTESS_INLINE void replace_unless(Float8& x, const Int8& chosen, const Float8& by) {
    x = reinterpret_cast<Float8>((reinterpret_cast<Int8>(x) & chosen) | (reinterpret_cast<Int8>(by) & ~chosen));
}
VOTESS_INLINE std::size_t sum_of(const Int8& x) {
    return static_cast<std::size_t>(((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7])));
}
VOTESS_INLINE float minimum_of(const Float8& x) {
    return std::min({x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]});
}

VOTESS_INLINE std::size_t select_body(const SketchedCell& cell, const SketchRay& ray, float* earliest,
                                      std::uint32_t* selected) {
    const Float8 zero{}, never = zero + std::numeric_limits<float>::infinity();
    Float8 best = zero + std::numeric_limits<float>::max();
    float* write = earliest;
    for (std::size_t s = 0; s < cell.sketches.size(); ++s, write += RaySketch::lanes) {
        Float8 slope{}, rise{};
        if (cell.constants != nullptr) std::memcpy(&rise, cell.constants[s].data(), sizeof rise);
        const float square = cell.constants != nullptr ? 0 : 1 / (RaySketch::units * RaySketch::units);
        for (std::size_t k = 0; k < 3; ++k) {
            Short8 way;
            std::memcpy(&way, cell.sketches[s].way[k].data(), sizeof way);
            const Float8 n = __builtin_convertvector(way, Float8);
            slope += n * ray.direction[k];
            rise += n * (ray.twice_place[k] + n * square);
        }
        const Float8 inverse = 1 / slope, time = rise * inverse;
        const Float8 size = reinterpret_cast<Float8>(reinterpret_cast<Int8>(time) & 0x7fffffff);
        const Float8 error = (ray.rise + ray.slope * size) * inverse + (ray.constant + ray.relative * size);
        const Int8 approaches = slope > ray.min_slope;
        Float8 early = never, late = time + error;
        replace_unless(early, slope < -ray.min_slope, -never);
        replace_unless(late, approaches, never);
        Float8 sure = time - error;
        replace_unless(sure, approaches, early);
        std::memcpy(write, &sure, sizeof sure);
        replace_unless(best, ~(late < best), late);
    }
    const float bound = minimum_of(best);
    Int8 number{0, 1, 2, 3, 4, 5, 6, 7}, kept{}, numbers{};
    const auto count = static_cast<std::int32_t>(cell.count);
    for (const float* read = earliest; read < write; read += RaySketch::lanes) {
        Float8 early;
        std::memcpy(&early, read, sizeof early);
        const Int8 keep = ~(early > bound) & (number < count);
        kept -= keep;
        numbers += keep & number;
        number += RaySketch::lanes;
    }
    std::size_t found = sum_of(kept);
    selected[0] = static_cast<std::uint32_t>(sum_of(numbers));
    if (found <= 1) return found;
    found = 0;
    for (std::size_t i = 0; i < cell.count; ++i)
        if (!(earliest[i] > bound)) selected[found++] = static_cast<std::uint32_t>(i);
    return found;
}

// One function for each instruction set. The body above is inlined into each.
#define VOTESS_SELECT(NAME, TARGET)                                                                        \
    TARGET std::size_t select_##NAME(const SketchedCell& cell, const SketchRay& ray, float* earliest,      \
                                     std::uint32_t* selected) {                                            \
        return select_body(cell, ray, earliest, selected);                                                 \
    }
VOTESS_SELECT(baseline, )
#if defined(__x86_64__)
VOTESS_SELECT(avx2, __attribute__((target("avx2,fma"))))
#endif

}  // namespace

SelectCrossings select_crossings([[maybe_unused]] std::string_view instructions) {
#if defined(__x86_64__)
    if (instructions.starts_with("avx")) return select_avx2;
#endif
    return select_baseline;
}

}  // namespace votess::cpu
