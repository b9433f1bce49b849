// The grid that maps coordinates to positions along a Hilbert curve.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/arithmetic.hpp"
#include "index/hilbert.hpp"

namespace votess::cpu {

struct Bounds {
    std::array<double, 3> lower{infinity, infinity, infinity};
    std::array<double, 3> upper{-infinity, -infinity, -infinity};

    void add(double x, double y, double z) { unite({{x, y, z}, {x, y, z}}); }
    void unite(const Bounds& b) {
        for (int k = 0; k < 3; ++k) {
            lower[k] = b.lower[k] < lower[k] ? b.lower[k] : lower[k];
            upper[k] = b.upper[k] > upper[k] ? b.upper[k] : upper[k];
        }
    }
    [[nodiscard]] double longest() const {
        return std::max({upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]});
    }
};

// Cubic blocks, 2^levels along the longest axis of the bounds. Equal coordinates fall into the same block, the two ends
// of the longest axis into different octants.
class Grid {
public:
    static constexpr int max_levels = hilbert_levels;

    explicit Grid(const Bounds& bounds, int levels = max_levels)
        : lower_(bounds.lower), shift_(3 * (max_levels - levels)) {
        const double longest = bounds.longest();
        if (longest == 0) return;
        // The inverse of a subnormal extent would overflow.
        const double enlarged = longest < 0x1p-1000 ? 0x1p1000 : 1;
        enlarge_ = enlarged;
        // Slightly less than the number of blocks, so that the upper end lies in the last one.
        blocks_ = (1 << max_levels) * (1 - 0x1p-40) / (longest * enlarged);
    }

    [[nodiscard]] std::uint32_t key(double x, double y, double z) const {
        const auto block = [this](double p, double lower) {
            return static_cast<std::uint32_t>(static_cast<std::int32_t>((p - lower) * enlarge_ * blocks_));
        };
        return hilbert_index(block(x, lower_[0]), block(y, lower_[1]), block(z, lower_[2])) >> shift_;
    }

private:
    std::array<double, 3> lower_;
    double enlarge_ = 0, blocks_ = 0;
    int shift_;
};

}  // namespace votess::cpu
