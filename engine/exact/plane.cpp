#include <algorithm>
#include <cmath>

#include "exact/predicate.hpp"

namespace votess::exact {
namespace {

// Sum of doubles without rounding: components that do not overlap, smallest first (Shewchuk, Adaptive precision
// floating-point arithmetic, Discrete Comput. Geom. 18, 1997, grow-expansion).
class Expansion {
public:
    void add(double x) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            const auto [sum, rest] = two_sum(x, terms_[i]);
            if (rest != 0) terms_[kept++] = rest;
            x = sum;
        }
        size_ = kept;
        if (x != 0) terms_[size_++] = x;
    }
    void add(DoubleDouble x) {
        add(x.low);
        add(x.high);
    }
    // The sum; `exact` becomes false when it takes more than two doubles.
    [[nodiscard]] DoubleDouble rounded(bool& exact) const {
        DoubleDouble sum{};
        double lost = 0;
        for (std::size_t i = size_; i-- > 0;) {
            const auto low = two_sum(sum.low, terms_[i]);
            const auto high = two_sum(sum.high, low.high);
            sum = high;
            lost += low.low;
        }
        exact = exact && lost == 0;
        return sum;
    }

private:
    static constexpr std::size_t most_terms = 16;  // a coordinate, that of p, and four for each of three vectors
    std::array<double, most_terms> terms_{};
    std::size_t size_ = 0;
};

}  // namespace

Differences image_differences(const Point& p, const Plane& bisector) {
    Differences d;
    for (int k = 0; k < 3; ++k) {
        Expansion sum;
        sum.add(two_sum(bisector.seed[k], -p[k]));
        for (int j = 0; j < 3; ++j) {
            if (bisector.shift[j] == 0) continue;
            const DoubleDouble& length = bisector.lattice->vector[j][k];
            const auto times = static_cast<double>(bisector.shift[j]);
            sum.add(two_product(length.low, times));
            sum.add(two_product(length.high, times));
        }
        d.x[k] = sum.rounded(d.exact);
    }
    return d;
}

}  // namespace votess::exact
