// Counting tiny faces.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/arithmetic.hpp"
#include "result/result.hpp"

namespace votess {

// Counts faces that are tiny compared with the mean area. The mean is known only when all are measured. Until then
// small areas are counted by powers of two.
class FaceTally {
public:
    static constexpr double tiny = 1e-9;  // of the mean area

    // largest: a bound on the areas.
    void begin(double largest) {
        *this = {};
        below_ = tiny * largest;
    }
    // areas: of a cell's faces with other cells.
    void add(std::span<const double> areas) {
        constexpr std::size_t lanes = 4;
        std::array<double, lanes> sum{}, least{};
        least.fill(below_);
        std::size_t i = 0;
        for (; i + lanes <= areas.size(); i += lanes)
            for (std::size_t k = 0; k < lanes; ++k) {
                sum[k] += areas[i + k];
                least[k] = areas[i + k] < least[k] ? areas[i + k] : least[k];
            }
        for (; i < areas.size(); ++i) {
            sum[0] += areas[i];
            least[0] = std::min(least[0], areas[i]);
        }
        sum_ += (sum[0] + sum[1]) + (sum[2] + sum[3]);
        faces_ += areas.size();
        ++cells_;
        if (std::min({least[0], least[1], least[2], least[3]}) < below_)
            for (const double area : areas)
                if (area < below_) ++small_[bin(area)];
    }
    void add(const FaceTally& other) {
        for (std::size_t b = 0; b < bins; ++b) small_[b] += other.small_[b];
        sum_ += other.sum_;
        faces_ += other.faces_;
        cells_ += other.cells_;
    }

    [[nodiscard]] std::uint64_t cells() const { return cells_; }
    // Returns the largest power of two that does not exceed 1e-9 of the mean area.
    [[nodiscard]] double limit() const {
        const double mean = faces_ == 0 ? 0 : sum_ / static_cast<double>(faces_);
        return std::ldexp(1.0, static_cast<int>(bin(tiny * mean)) - double_bias);
    }
    // Returns the number of smaller faces, each counted once for each of its cells.
    [[nodiscard]] std::uint64_t count() const {
        std::uint64_t count = 0;
        for (std::size_t b = 0; b < bin(limit()); ++b) count += small_[b];
        return count;
    }

private:
    static constexpr std::size_t bins = 2048;
    // Returns the biased exponent of an area, which must not be negative.
    static std::size_t bin(double area) { return std::bit_cast<std::uint64_t>(area) >> 52 & (bins - 1); }

    double below_ = 0;  // larger ones cannot be tiny
    double sum_ = 0;
    std::uint64_t faces_ = 0, cells_ = 0;
    std::array<std::uint64_t, bins> small_{};
};

}  // namespace votess
