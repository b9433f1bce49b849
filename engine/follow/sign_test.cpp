#include "follow/sign_test.hpp"

#include "follow/sign_test.inl"

namespace votess::cpu {

SignTester sign_tester(std::string_view instructions) {
#if defined(__x86_64__)
    if (instructions != "baseline") return test_signs_avx2;
#endif
    (void)instructions;
    return SignKernel<struct AnyProcessor>::test;
}

}  // namespace votess::cpu
