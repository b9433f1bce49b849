// Seeds of which a half lie outside of their domain, for the option `outside`.
#pragma once

#include <cstdint>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"

namespace test {

struct Scattered {
    Coordinates points;
    std::vector<double> weights;
    votess::Options options;  // refer to the weights

    Scattered() = default;
    Scattered(const Scattered&) = delete;
};

inline constexpr int kinds_of_scattered = 6;  // a box, periodic along one axis or two, round walls, two triclinic boxes
// Sets `out`. far: up to how many sizes of the domain every other seed lies outside along each axis. Weights make cells
// of such seeds reach the domain.
void scatter(int kind, std::size_t count, double far, bool weighted, std::uint64_t rng_seed, Scattered& out);

}  // namespace test
