// The walk compiled for any processor.
#include "kernels/measure_cell.inl"
#include "kernels/star_kernels_plain.hpp"
#include "walk/star_walk.hpp"

namespace votess::cpu {

template class StarWalk<Baseline>;

std::unique_ptr<Star> make_star_baseline(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Baseline>>(seeds, hierarchy);
}

const StarKernels& star_kernels([[maybe_unused]] std::string_view name) {
#if defined(__x86_64__)
    if (name.starts_with("avx")) return star_kernels_avx2;
#endif
    return kernels_of<Baseline>;
}

const BentKernels& bent_kernels([[maybe_unused]] std::string_view name) {
#if defined(__x86_64__)
    if (name.starts_with("avx")) return bent_kernels_avx2;
#endif
    return bent_kernels_of<Baseline>;
}

std::unique_ptr<Star> make_star([[maybe_unused]] std::string_view instructions, const SortedSeeds& seeds,
                                const Hierarchy& hierarchy) {
#if defined(__x86_64__)
    if (instructions.starts_with("avx")) return make_star_avx2(seeds, hierarchy);
#endif
    return make_star_baseline(seeds, hierarchy);
}

}  // namespace votess::cpu
