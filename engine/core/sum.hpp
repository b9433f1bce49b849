#pragma once

namespace votess {

// A sum whose rounding does not grow with the number of terms (Knuth). is_exact: of numbers that do not round.
template <class Real, bool is_exact = false>
class AccurateSum {
public:
    void operator+=(const Real& x) {
        const Real sum = high_ + x;
        if constexpr (!is_exact) {
            const Real added = sum - high_;
            rest_ += (high_ - (sum - added)) + (x - added);
        }
        high_ = sum;
    }
    [[nodiscard]] Real value() const { return high_ + rest_; }

private:
    Real high_ = 0, rest_ = 0;
};
using Sum = AccurateSum<double>;

}  // namespace votess
