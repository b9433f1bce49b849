// The walk compiled for processors with AVX2.
#include "cpu/walk/star_context.hpp"

#if defined(__x86_64__)
#include "cpu/walk/kernels/star_kernels_avx2.inl"

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,bmi,bmi2,fma,lzcnt,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,fma,lzcnt,popcnt")
#endif
#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

constinit const StarKernels star_kernels_avx2 = kernels_avx2;

struct Avx2 {
    static constexpr const StarKernels& kernels = kernels_avx2;
    // What the walk calls, so that it can be inlined.
    template <class... Args>
    [[gnu::always_inline]] static bool select(Args&&... args) {
        return select_avx2(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static unsigned near_boxes(Args&&... args) {
        return near_boxes_avx2(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static unsigned inside_ball(Args&&... args) {
        return inside_ball_avx2(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static void first_hits(Args&&... args) {
        return first_hits_avx2(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static int touching(Args&&... args) {
        return touching_avx2(args...);
    }
};
template class StarWalk<Avx2>;

std::unique_ptr<Star> make_star_avx2(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Avx2>>(seeds, hierarchy);
}

}  // namespace votess::cpu
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
