// The walk compiled for processors with AVX2.
#include "walk/star_context.hpp"

#if defined(__x86_64__)
#include "kernels/star_kernels_avx2.inl"

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,bmi,bmi2,fma,lzcnt,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,fma,lzcnt,popcnt")
#endif
#include "kernels/measure_cell.inl"
#include "walk/star_walk.hpp"

namespace votess::cpu {

constinit const StarKernels star_kernels_avx2 = kernels_of<Avx2>;
constinit const BentKernels bent_kernels_avx2 = bent_kernels_of<Avx2>;
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
