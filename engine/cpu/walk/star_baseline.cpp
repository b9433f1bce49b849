// The walk compiled for any processor.
#include "cpu/walk/kernels/star_kernels_plain.hpp"
#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

struct Baseline {
    static constexpr const StarKernels& kernels = kernels_baseline;
    // What the walk calls, so that it can be inlined.
    template <class... Args>
    [[gnu::always_inline]] static bool select(Args&&... args) {
        return select_body<4>(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static unsigned near_boxes(Args&&... args) {
        return near_boxes_body(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static unsigned inside_ball(Args&&... args) {
        return inside_ball_body(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static void first_hits(Args&&... args) {
        return first_hits_body<4>(args...);
    }
    template <class... Args>
    [[gnu::always_inline]] static int touching(Args&&... args) {
        return touching_body<4>(args...);
    }
};
template class StarWalk<Baseline>;

std::unique_ptr<Star> make_star_baseline(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Baseline>>(seeds, hierarchy);
}

const StarKernels& star_kernels([[maybe_unused]] std::string_view name) {
#if defined(__x86_64__)
    if (name == star_kernels_avx512.name) return star_kernels_avx512;
    if (name == star_kernels_avx2.name) return star_kernels_avx2;
#endif
    return kernels_baseline;
}

std::unique_ptr<Star> make_star([[maybe_unused]] std::string_view instructions, const SortedSeeds& seeds,
                                const Hierarchy& hierarchy) {
#if defined(__x86_64__)
    if (instructions == "avx512") return make_star_avx512(seeds, hierarchy);
    if (instructions == "avx2") return make_star_avx2(seeds, hierarchy);
#endif
    return make_star_baseline(seeds, hierarchy);
}

}  // namespace votess::cpu
