// Seeds, box vectors and weights of any domain as integers of one unit, for oracles: everything that follows from them
// by sums and products is exact.
#pragma once

#include <gmpxx.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/vectors.hpp"

namespace test {

using Integers = VectorOf<mpz_class>;

// A half-space n.x <= h, of x relative to a seed.
struct IntegerPlane {
    Integers n;
    mpz_class h;
    ExactFace face;
};

class IntegerDomain {
public:
    // options: box (also when the library chose it) or cell, periodic, planes, weights. points: 3N.
    IntegerDomain(std::span<const double> points, const votess::Options& options);

    [[nodiscard]] std::size_t size() const { return place_.size(); }
    [[nodiscard]] bool is_periodic() const { return active_[0] || active_[1] || active_[2]; }
    [[nodiscard]] int quantum() const { return quantum_; }  // the unit of length is 2^quantum
    // Where the seed lies inside the domain.
    [[nodiscard]] const Integers& place(std::size_t i) const { return place_[i]; }
    // Whether the seed has no part in the diagram.
    [[nodiscard]] bool is_outside(std::size_t i) const { return outside_[i] != 0; }

    [[nodiscard]] IntegerPlane bisector(std::size_t i, std::size_t j, const std::array<int, 3>& shift) const;
    // Returns the walls of the box, then the planes.
    [[nodiscard]] std::vector<IntegerPlane> walls(std::size_t i) const;
    // Shifts of seed j, some too many, that may touch the cell of seed i. A cell lies within the Voronoi cell V of the
    // lattice around its seed, so seeds that touch are at most 2 V apart.
    [[nodiscard]] std::vector<std::array<int, 3>> near_shifts(std::size_t i, std::size_t j) const;

private:
    void reduce();
    [[nodiscard]] Integers difference(std::size_t i, std::size_t j, const std::array<int, 3>& shift) const;

    int quantum_ = 0;
    std::array<bool, 3> active_{};
    bool has_cell_ = false;
    Integers lower_, upper_;
    std::array<Integers, 3> vector_;
    std::array<Integers, 3> short_;       // reduced basis of the lattice, and vectors across it
    std::array<Integers, 3> short_dual_;  // dual_[k] . short_[j] = determinant_ when k = j, else 0
    mpz_class determinant_;
    std::array<std::array<long, 3>, 3> short_shift_{};
    std::array<std::array<double, 3>, 3> rounded_short_{};  // 0 across
    std::vector<std::array<double, 3>> relevant_;           // lattice vectors whose slabs hold the lattice's cell
    std::vector<Integers> place_;
    std::vector<mpz_class> weight_;
    std::vector<char> outside_;
    struct Plane {
        Integers n;
        mpz_class h;
    };
    std::vector<Plane> planes_;  // of absolute x
};

}  // namespace test
