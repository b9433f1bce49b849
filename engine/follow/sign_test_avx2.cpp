// The tests compiled for processors with AVX2.
#include <algorithm>
#include <cmath>

#include "follow/sign_test.hpp"

#if defined(__x86_64__)
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,bmi,bmi2,fma,lzcnt,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,fma,lzcnt,popcnt")
#endif
#include "follow/sign_test.inl"

namespace votess::cpu {

bool test_signs_avx2(const SignFrame& frame, std::size_t seed, const KeptCell& cell, SignTest& out) {
    return SignKernel<struct WithAvx2>::test(frame, seed, cell, out);
}

}  // namespace votess::cpu
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
