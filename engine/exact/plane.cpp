#include <algorithm>
#include <cmath>

#include "exact/predicate.hpp"

namespace votess::exact {
namespace {

// A sum of doubles without rounding: components that do not overlap, smallest first (Shewchuk, Adaptive precision
// floating-point arithmetic, Discrete Comput. Geom. 18, 1997, grow-expansion).
class Expansion {
public:
    static constexpr std::size_t max_terms = 16;  // a coordinate, that of p, and four for each of three vectors

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
        if (x.low != 0) add(x.low);
        add(x.high);
    }
    // Returns the sum as two doubles: the nearest one, and the one nearest to the rest. Equal sums give equal doubles
    // in any order of terms. Sets `exact` to false when two are not enough.
    [[nodiscard]] DoubleDouble rounded(bool& exact) const {
        if (size_ == 0) return {};
        if (size_ == 1) return {terms_[0], 0};
        if (size_ == 2) return two_sum(terms_[1], terms_[0]);
        DoubleDouble sum{nearest(), 0};
        Expansion rest = *this;
        rest.add(-sum.high);
        sum.low = rest.nearest();
        rest.add(-sum.low);
        exact = exact && rest.size_ == 0;
        return sum;
    }

private:
    // Returns the sum rounded to nearest, ties to even. Components do not overlap, so the first rounding from the top
    // that leaves a rest decides. If the rest is half a unit, the sign of the next component decides.
    [[nodiscard]] double nearest() const {
        if (size_ == 0) return 0;
        std::size_t i = size_ - 1;
        DoubleDouble sum{terms_[i], 0};
        while (i > 0 && sum.low == 0) sum = two_sum(sum.high, terms_[--i]);
        if (i > 0 && (sum.low < 0) == (terms_[i - 1] < 0)) {
            const DoubleDouble up = two_sum(sum.high, 2 * sum.low);
            if (up.low == 0) return up.high;
        }
        return sum.high;
    }

    std::array<double, max_terms> terms_;
    std::size_t size_ = 0;
};

}  // namespace

Differences image_differences(const Point& p, const Plane& bisector) {
    Differences d;
    for (int k = 0; k < 3; ++k) {
        std::array<double, Expansion::max_terms> terms;  // those that are not zero
        int count = 0;
        const auto add = [&](DoubleDouble x) {
            if (x.low != 0) terms[count++] = x.low;
            if (x.high != 0) terms[count++] = x.high;
        };
        add(two_sum(bisector.seed[k], -p[k]));
        for (int j = 0; j < 3; ++j) {
            if (bisector.shift[j] == 0) continue;
            const DoubleDouble& length = bisector.lattice->vector[j][k];
            const auto times = static_cast<double>(bisector.shift[j]);
            if (length.low != 0) add(two_product(length.low, times));
            if (length.high != 0) add(two_product(length.high, times));
        }
        if (count <= 2) {
            d.x[k] = count == 0 ? DoubleDouble{} : two_sum(terms[0], count == 1 ? 0.0 : terms[1]);
            continue;
        }
        Expansion sum;
        for (int i = 0; i < count; ++i) sum.add(terms[i]);
        d.x[k] = sum.rounded(d.exact);
    }
    return d;
}

void set_across(Lattice& lattice) {
    for (int j = 0; j < 3; ++j) {
        const auto &u = lattice.vector[(j + 1) % 3], &v = lattice.vector[(j + 2) % 3];
        for (int k = 0; k < 3; ++k) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            Expansion sum;
            sum.add(two_product(u[l].high, v[m].high));
            sum.add(two_product(-u[m].high, v[l].high));
            bool exact = true;
            lattice.across[j][k] = sum.rounded(exact);
        }
    }
}

}  // namespace votess::exact
