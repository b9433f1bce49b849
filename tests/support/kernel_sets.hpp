// The loops of the walk in each set of instructions.
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "kernels/star_kernels.hpp"
#include "polytope/cell_kernels.hpp"

namespace test {

// Calls test(kernels) for each set of loops that this processor can run; avx512 has those of avx2.
template <class Test>
void for_each_set(const Test& test) {
    for (const votess::cpu::Kernels* supported : votess::cpu::supported_kernels()) {
        if (std::string(supported->name) == "avx512") continue;
        const votess::cpu::StarKernels& kernels = votess::cpu::star_kernels(supported->name);
        REQUIRE(std::string(kernels.name) == supported->name);
        INFO(std::string(kernels.name));
        test(kernels);
    }
}

}  // namespace test
