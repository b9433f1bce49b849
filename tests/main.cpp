#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "polytope/cell_kernels.hpp"
#include "support/at_end.hpp"

namespace {

// Makes the named instructions the best ones. Returns false where the processor lacks them.
bool limit_instructions(const std::string& name) {
    const votess::cpu::Kernels* kernels = votess::cpu::find_kernels(name);
    if (kernels != nullptr) votess::cpu::set_best_kernels(*kernels);
    return kernels != nullptr;
}

std::vector<std::function<void()>>& calls_at_end() {
    static std::vector<std::function<void()>> calls;
    return calls;
}

}  // namespace

void test::at_end(std::function<void()> call) {
    calls_at_end().push_back(std::move(call));
}

// VOTESS_TEST_BEST limits the vector instructions of all tests: avx512, avx2 or baseline.
int main(int count, char** values) {
    const char* best = std::getenv("VOTESS_TEST_BEST");
    if (best != nullptr && !limit_instructions(best)) {
        std::printf("VOTESS_TEST_BEST=%s: this processor has no such instructions; use avx512, avx2 or baseline\n",
                    best);
        return 2;
    }
    const int result = doctest::Context(count, values).run();
    for (const auto& call : calls_at_end()) call();
    return result;
}
