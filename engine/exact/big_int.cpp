#include "exact/integer/big_int.hpp"

#include <algorithm>
#include <bit>

namespace votess::exact {
namespace {

bool less(const Limbs& a, const Limbs& b) {
    if (a.size() != b.size()) return a.size() < b.size();
    const std::uint64_t *x = a.begin(), *y = b.begin();
    std::size_t i = a.size();
    while (i > 0 && x[i - 1] == y[i - 1]) --i;
    return i > 0 && x[i - 1] < y[i - 1];
}

}  // namespace

BigInt BigInt::operator-() const& {
    BigInt result = *this;
    result.negative_ = !negative_ && !limbs_.empty();
    return result;
}

BigInt BigInt::sum(const BigInt& b, bool b_negative) const {
    BigInt result;
    const bool adds = negative_ == b_negative;
    const bool turned = adds ? limbs_.size() < b.limbs_.size() : less(limbs_, b.limbs_);
    const Limbs &large = turned ? b.limbs_ : limbs_, &small = turned ? limbs_ : b.limbs_;
    const std::size_t count = large.size(), both = small.size();
    result.limbs_ = Limbs(count + (adds ? 1 : 0));
    const std::uint64_t *x = large.begin(), *y = small.begin();
    std::uint64_t* const out = result.limbs_.begin();
    std::uint64_t carry = 0;  // or borrow
    for (std::size_t i = 0; i < count; ++i) {
        const Uint128 other = static_cast<Uint128>(i < both ? y[i] : 0) + carry;
        const Uint128 limb = adds ? x[i] + other : x[i] - other;
        out[i] = static_cast<std::uint64_t>(limb);
        carry = static_cast<std::uint64_t>(limb >> 64) & 1;
    }
    if (adds) out[count] = carry;
    result.negative_ = turned ? b_negative : negative_;
    result.trim();
    return result;
}

BigInt operator*(const BigInt& a, const BigInt& b) {
    BigInt result;
    const std::size_t a_size = a.limbs_.size(), b_size = b.limbs_.size();
    if (a_size == 0 || b_size == 0) return result;
    result.limbs_ = Limbs(a_size + b_size);
    const std::uint64_t *x = a.limbs_.begin(), *y = b.limbs_.begin();
    std::uint64_t* const out = result.limbs_.begin();
    std::fill_n(out, b_size, 0);
    for (std::size_t i = 0; i < a_size; ++i) {
        std::uint64_t carry = 0;
        for (std::size_t j = 0; j < b_size; ++j) {
            const Uint128 t = static_cast<Uint128>(x[i]) * y[j] + out[i + j] + carry;
            out[i + j] = static_cast<std::uint64_t>(t);
            carry = static_cast<std::uint64_t>(t >> 64);
        }
        out[i + b_size] = carry;
    }
    result.negative_ = a.negative_ != b.negative_;
    result.trim();
    return result;
}

BigInt::operator Quad() const {
    WideInt<4> leading;  // the top three limbs
    const std::size_t count = std::min<std::size_t>(limbs_.size(), 3);
    for (std::size_t i = 0; i < count; ++i) leading.limb[i] = limbs_[limbs_.size() - count + i];
    const Quad size = ldexp(Quad(leading), static_cast<int>(64 * (limbs_.size() - count)));
    return negative_ ? -size : size;
}

}  // namespace votess::exact
