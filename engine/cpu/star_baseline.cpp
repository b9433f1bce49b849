// The walk compiled for any processor.
#include "cpu/star_walk.hpp"

namespace votess::cpu {

struct Baseline {};
template class StarWalk<Baseline>;

std::unique_ptr<Star> make_star_baseline(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Box& box) {
    return std::make_unique<StarWalk<Baseline>>(seeds, hierarchy, box, star_kernels("baseline"));
}

std::unique_ptr<Star> make_star(std::string_view instructions, const SortedSeeds& seeds, const Hierarchy& hierarchy,
                                const Box& box) {
#if defined(__x86_64__)
    if (instructions == "avx512") return make_star_avx512(seeds, hierarchy, box);
    if (instructions == "avx2") return make_star_avx2(seeds, hierarchy, box);
#endif
    return make_star_baseline(seeds, hierarchy, box);
}

}  // namespace votess::cpu
