// How far cells reach along the lattice of a periodic domain, and numbers that depend on its axes alone. The domain may
// be far longer along others.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/vector3.hpp"
#include "domain/domain.hpp"

namespace votess {

// Returns a bound on the distance along the lattice between seeds whose cells touch: twice that from a seed to the
// bisectors of its own images, between which its cell lies. The same for a place and the seed whose cell holds it.
// Infinite if nothing repeats.
inline double neighbor_reach(const Domain& domain) {
    if (!domain.is_periodic()) return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const auto& [x, y, z] = domain.reduced.vector[j];
        if (domain.periodic[j]) sum += length3(x, y, z);
    }
    return sum * (1 + 1e-9);
}

// Returns the largest size along an axis that fraction j depends on, for Basis::fraction_error().
inline double size_for(const Basis& basis, int j, const std::array<double, 3>& size) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (basis.dual[static_cast<std::size_t>(j)][k] != 0) largest = std::max(largest, size[k]);
    return largest;
}

}  // namespace votess
