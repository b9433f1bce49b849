// The walk compiled for any processor.
#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

struct Baseline {};
template class StarWalk<Baseline>;

std::unique_ptr<Star> make_star_baseline(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Baseline>>(seeds, hierarchy, star_kernels("baseline"));
}

std::unique_ptr<Star> make_star(std::string_view instructions, const SortedSeeds& seeds, const Hierarchy& hierarchy) {
#if defined(__x86_64__)
    if (instructions == "avx512") return make_star_avx512(seeds, hierarchy);
    if (instructions == "avx2") return make_star_avx2(seeds, hierarchy);
#endif
    return make_star_baseline(seeds, hierarchy);
}

}  // namespace votess::cpu
