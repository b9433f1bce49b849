// How far cells reach along the lattice of a periodic domain, and numbers that depend on its axes alone. The domain may
// be far longer along others.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/vector3.hpp"
#include "domain/domain.hpp"

namespace votess {

// How far a seed lies from those whose cells touch its own. A shared point is as near to the seeds as to their images
// by any vector +-a of the lattice, of the same weight. So n.a <= |a|^2 for the difference n of the seeds. This
// excludes images across an axis far shorter than the cells, which rounding leaves within their reach.
class LatticeReach {
public:
    LatticeReach() = default;
    explicit LatticeReach(const Domain& domain) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (!domain.periodic[j]) continue;
            const Vector3& a = domain.reduced.vector[j];
            length_[j] = length3(a);
            for (std::size_t k = 0; k < 3; ++k) along_[j][k] = a[k] / length_[j];
            sum_ += length_[j];
        }
        sum_ *= 1 + slack;
    }

    // Returns the same bound for the length of n, also for seeds that have no images themselves, like queries.
    // Infinite if nothing repeats.
    [[nodiscard]] double distance() const { return sum_ > 0 ? sum_ : std::numeric_limits<double>::infinity(); }

    // Returns false only if no cells touch whose seeds differ by a vector of that box.
    [[nodiscard]] bool may_touch(const Box& differences) const {
        for (std::size_t j = 0; j < 3; ++j) {
            double least = 0, most = 0, size = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double low = along_[j][k] * differences.lower[k], high = along_[j][k] * differences.upper[k];
                least += std::min(low, high);
                most += std::max(low, high);
                size += std::max(std::abs(low), std::abs(high));
            }
            const double farthest = length_[j] * (1 + slack) + rounding * size;
            if (least > farthest || most < -farthest) return false;
        }
        return true;
    }

private:
    static constexpr double slack = 1e-9, rounding = 1e-14;
    std::array<double, 3> length_{};  // of the reduced vectors; 0 along other axes
    std::array<Vector3, 3> along_{};  // their directions
    double sum_ = 0;
};

// Returns the largest size along an axis that fraction j depends on, for Basis::fraction_error().
inline double size_for(const Basis& basis, int j, const std::array<double, 3>& size) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (basis.dual[static_cast<std::size_t>(j)][k] != 0) largest = std::max(largest, size[k]);
    return largest;
}

}  // namespace votess
