#include "verify/plane_loops.hpp"

#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/arithmetic.hpp"
#include "polytope/cell_kernels.hpp"

namespace votess {
namespace {

using Real4 = double __attribute__((vector_size(32)));
using Mask4 = std::int64_t __attribute__((vector_size(32)));

#define VOTESS_INLINE inline __attribute__((always_inline))

VOTESS_INLINE void load(Real4& r, const double* p) {
    std::memcpy(&r, p, sizeof r);
}

VOTESS_INLINE int slacks_body(const PlaneArrays& planes, const std::array<double, 3>& at, const SureBound& bound,
                              double* slack) {
    Mask4 sure{};
    for (std::size_t f = 0; f < planes.padded; f += plane_lanes) {
        Real4 x, y, z, d, length, size;
        load(x, planes.nx + f);
        load(y, planes.ny + f);
        load(z, planes.nz + f);
        load(d, planes.d + f);
        load(length, planes.length + f);
        load(size, planes.size + f);
        const Real4 rest = d - (x * at[0] + y * at[1] + z * at[2]);
        std::memcpy(slack + f, &rest, sizeof rest);
        sure -= rest > length * bound.slope + size * bound.constant + bound.floor;  // true is -1
    }
    return static_cast<int>(sure[0] + sure[1] + sure[2] + sure[3]);
}

VOTESS_INLINE Hit first_hit_body(const PlaneArrays& planes, const double* slack, const std::array<double, 3>& along) {
    Real4 least{infinity, infinity, infinity, infinity};
    Mask4 first{-1, -1, -1, -1}, index{0, 1, 2, 3};
    for (std::size_t f = 0; f < planes.padded; f += plane_lanes, index += static_cast<std::int64_t>(plane_lanes)) {
        Real4 x, y, z, rest;
        load(x, planes.nx + f);
        load(y, planes.ny + f);
        load(z, planes.nz + f);
        load(rest, slack + f);
        const Real4 speed = x * along[0] + y * along[1] + z * along[2], time = rest / speed;
        const Mask4 nearer = (speed > 0) & (time < least);
        least = nearer ? time : least;
        first = nearer ? index : first;
    }
    Hit hit{static_cast<int>(first[0]), least[0]};
    for (std::size_t k = 1; k < plane_lanes; ++k) {
        const bool nearer = least[k] < hit.time;  // without a branch, which nothing foretells
        hit.plane = nearer ? static_cast<int>(first[k]) : hit.plane;
        hit.time = nearer ? least[k] : hit.time;
    }
    return hit;
}

#define VOTESS_LOOPS(NAME, TARGET)                                                                                    \
    TARGET int slacks_##NAME(const PlaneArrays& planes, const std::array<double, 3>& at, const SureBound& bound,      \
                             double* slack) {                                                                         \
        return slacks_body(planes, at, bound, slack);                                                                 \
    }                                                                                                                 \
    TARGET Hit first_hit_##NAME(const PlaneArrays& planes, const double* slack, const std::array<double, 3>& along) { \
        return first_hit_body(planes, slack, along);                                                                  \
    }                                                                                                                 \
    constexpr PlaneLoops loops_##NAME{slacks_##NAME, first_hit_##NAME};

VOTESS_LOOPS(baseline, )
#if defined(__x86_64__)
VOTESS_LOOPS(avx2, __attribute__((target("avx2"))))
#endif

}  // namespace

const PlaneLoops& plane_loops() {
#if defined(__x86_64__)
    if (std::string_view(cpu::best_kernels().name) != "baseline") return loops_avx2;
#endif
    return loops_baseline;
}

}  // namespace votess
