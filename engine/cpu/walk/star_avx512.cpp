// The walk compiled for processors with AVX-512.
#include "cpu/walk/star_context.hpp"

#if defined(__x86_64__)
#include "cpu/walk/kernels/star_kernels_avx512.inl"

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,bmi,bmi2,fma,lzcnt,popcnt"))), \
                             apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw,bmi,bmi2,fma,lzcnt,popcnt,prefer-vector-width=256")
#endif
#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

constinit const StarKernels star_kernels_avx512 = kernels_avx512;

struct Avx512 {
    static constexpr const StarKernels& kernels = kernels_avx512;
    // What the walk calls, so that it can be inlined.
    template <class... Args>
    [[gnu::always_inline]] static bool select(Args&&... args) {
        return select_avx512(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static unsigned near_boxes(Args&&... args) {
        return near_boxes_avx512(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static unsigned inside_ball(Args&&... args) {
        return inside_ball_avx512(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static void first_hits(Args&&... args) {
        return first_hits_avx512(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static int touching(Args&&... args) {
        return touching_avx512(args...);
    }
};
template class StarWalk<Avx512>;

std::unique_ptr<Star> make_star_avx512(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Avx512>>(seeds, hierarchy);
}

}  // namespace votess::cpu
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
