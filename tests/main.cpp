#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>

#include "cpu/kernels.hpp"
#include "support/check.hpp"

int main(int count, char** values) {
    // The best instructions of this processor are what the tests run with anyway.
    const std::string forced = test::forced_instructions();
    const votess::cpu::Kernels* kernels = votess::cpu::find_kernels(forced);
    if (!forced.empty() && (kernels == nullptr || kernels == &votess::cpu::best_kernels())) {
        std::printf("skipped: %s\n", kernels == nullptr ? "this processor lacks the instructions" : "tested already");
        return 77;
    }
    return doctest::Context(count, values).run();
}
