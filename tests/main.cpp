#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "polytope/cell_kernels.hpp"

namespace {

std::string variable(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
}

// As on a processor that has nothing better than these; false when this one lacks them or has nothing better.
bool lower_to(const std::string& instructions) {
    const votess::cpu::Kernels* kernels = votess::cpu::find_kernels(instructions);
    if (kernels == nullptr || kernels == &votess::cpu::best_kernels()) return false;
    votess::cpu::set_best_kernels(*kernels);
    return true;
}

}  // namespace

// VOTESS_TEST_BEST: the best instructions that the processor shall seem to have, for a run of all tests.
// VOTESS_TEST_INSTRUCTIONS: set by ctest for tests that run once more with these.
int main(int count, char** values) {
    const std::string best = variable("VOTESS_TEST_BEST"), again = variable("VOTESS_TEST_INSTRUCTIONS");
    if (!best.empty() && best != "avx512" && best != "avx2" && best != "baseline") {
        std::printf("VOTESS_TEST_BEST=%s: give avx512, avx2 or baseline\n", best.c_str());
        return 2;
    }
    lower_to(best);
    if (!again.empty() && !lower_to(again)) {
        std::printf("skipped: this processor lacks the instructions, or all tests run with them\n");
        return 77;
    }
    return doctest::Context(count, values).run();
}
