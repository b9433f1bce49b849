#include "cpu/walk/kernels/star_kernels.hpp"

#include "cpu/walk/kernels/star_kernels_plain.hpp"

namespace votess::cpu {
namespace {

constexpr StarKernels kernels_baseline{"baseline",     near_boxes_body,    inside_ball_body, to_window_body,
                                       select_body<4>, first_hits_body<4>, touching_body<4>, rank_body};

}  // namespace

const StarKernels& star_kernels(std::string_view name) {
#if defined(__x86_64__)
    if (name == star_kernels_avx512.name) return star_kernels_avx512;
    if (name == star_kernels_avx2.name) return star_kernels_avx2;
#endif
    return kernels_baseline;
}

}  // namespace votess::cpu
