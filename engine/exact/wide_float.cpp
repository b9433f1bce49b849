#include "exact/wide_float.hpp"

#include <cmath>

namespace votess::exact {

WideFloat::WideFloat(double x) {
    int exponent = 0;
    const double fraction = std::frexp(x, &exponent);
    *this = WideFloat(from_int128<1>(static_cast<std::int64_t>(std::ldexp(fraction, 53))), exponent - 53);
}

WideFloat WideFloat::operator-() const {
    WideFloat result = *this;
    result.mantissa_ = -mantissa_;
    return result;
}

WideFloat operator+(const WideFloat& a, const WideFloat& b) {
    if (a.mantissa_.zero()) return b;
    if (b.mantissa_.zero()) return a;
    if (a.exponent_ < b.exponent_) return b + a;
    const int gap = a.exponent_ - b.exponent_;
    if (gap > 64 * WideFloat::limbs) return a;
    constexpr int width = 2 * WideFloat::limbs + 1;
    return {shift_left(resize<width>(a.mantissa_), gap) + resize<width>(b.mantissa_), b.exponent_};
}

WideFloat operator*(const WideFloat& a, const WideFloat& b) {
    return {a.mantissa_ * b.mantissa_, a.exponent_ + b.exponent_};
}

WideFloat WideFloat::truncated(int kept) const {
    WideFloat result = *this;
    for (int i = 0; i < limbs - kept; ++i) result.mantissa_.limb[i] = 0;
    return result;
}

// Newton's iteration for 1/b doubles the 53 correct bits of its start each time. Each step takes the limbs that it can
// make correct, and one more.
WideFloat operator/(const WideFloat& a, const WideFloat& b) {
    constexpr int bits = 64 * WideFloat::limbs - 1;
    WideFloat divisor = b;  // scaled to between 1/2 and 1
    divisor.exponent_ = -bits;
    WideFloat inverse = 1 / static_cast<double>(divisor);
    for (int correct = 50; correct < bits; correct *= 2) {
        const int kept = std::min(WideFloat::limbs, 2 * correct / 64 + 2);
        inverse = (inverse + inverse * (1 - divisor.truncated(kept) * inverse)).truncated(kept);
    }
    return a * ldexp(inverse, -bits - b.exponent_);
}

}  // namespace votess::exact
