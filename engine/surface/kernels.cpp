#include "surface/kernels.hpp"

#include <cmath>
#include <cstring>
#include <string_view>

#include "solid/mesh_signs.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace votess::surface {
namespace {

#define VOTESS_INLINE inline __attribute__((always_inline))

namespace baseline {
constexpr std::size_t width = 2;
using Real = double __attribute__((vector_size(8 * width)));
VOTESS_INLINE unsigned bits_below(const Real& a, const Real& b) {
    return static_cast<unsigned>(a[0] < b[0]) | static_cast<unsigned>(a[1] < b[1]) << 1;
}
VOTESS_INLINE unsigned bits_at_most(const Real& a, const Real& b) {
    return static_cast<unsigned>(a[0] <= b[0]) | static_cast<unsigned>(a[1] <= b[1]) << 1;
}
VOTESS_INLINE Real root(const Real& a) {
    return Real{std::sqrt(a[0]), std::sqrt(a[1])};
}
#include "surface/kernels.inl"
}  // namespace baseline

#if defined(__x86_64__)
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace avx2 {
constexpr std::size_t width = 4;
using Real = double __attribute__((vector_size(8 * width)));
VOTESS_INLINE unsigned bits_below(const Real& a, const Real& b) {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ)));
}
VOTESS_INLINE unsigned bits_at_most(const Real& a, const Real& b) {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LE_OQ)));
}
VOTESS_INLINE Real root(const Real& a) {
    return _mm256_sqrt_pd(a);
}
#include "surface/kernels.inl"
}  // namespace avx2
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

}  // namespace

const SurfaceKernels& surface_kernels() {
    [[maybe_unused]] const std::string_view name = cpu::best_kernels().name;
#if defined(__x86_64__)
    if (name.starts_with("avx")) return avx2::all;
#endif
    return baseline::all;
}

}  // namespace votess::surface
