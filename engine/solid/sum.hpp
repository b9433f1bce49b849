// Neumaier's sum: its rounding does not grow with the number of terms.
#pragma once

#include <cmath>

namespace votess::solid {

class Sum {
public:
    void operator+=(double x) {
        const double next = sum_ + x;
        rest_ += std::abs(sum_) >= std::abs(x) ? (sum_ - next) + x : (x - next) + sum_;
        sum_ = next;
    }
    [[nodiscard]] double value() const { return sum_ + rest_; }

private:
    double sum_ = 0, rest_ = 0;
};

}  // namespace votess::solid
