#include "exact/integer/big_int.hpp"

#include <algorithm>
#include <bit>

namespace votess::exact {
namespace {

using Limbs = std::vector<std::uint64_t>;

bool less(const Limbs& a, const Limbs& b) {
    if (a.size() != b.size()) return a.size() < b.size();
    return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
}

}  // namespace

BigInt BigInt::operator-() const& {
    BigInt result = *this;
    result.negative_ = !negative_ && !limbs_.empty();
    return result;
}

BigInt BigInt::sum(const BigInt& b, bool b_negative) const {
    BigInt result;
    if (negative_ == b_negative) {
        const Limbs &longer = limbs_.size() < b.limbs_.size() ? b.limbs_ : limbs_,
                    &shorter = limbs_.size() < b.limbs_.size() ? limbs_ : b.limbs_;
        result.limbs_.reserve(longer.size() + 1);
        Uint128 carry = 0;
        for (std::size_t i = 0; i < longer.size(); ++i) {
            carry += static_cast<Uint128>(longer[i]) + (i < shorter.size() ? shorter[i] : 0);
            result.limbs_.push_back(static_cast<std::uint64_t>(carry));
            carry >>= 64;
        }
        if (carry != 0) result.limbs_.push_back(1);
        result.negative_ = negative_;
    } else {
        const bool turned = less(limbs_, b.limbs_);
        const Limbs &large = turned ? b.limbs_ : limbs_, &small = turned ? limbs_ : b.limbs_;
        result.limbs_.reserve(large.size());
        std::uint64_t borrow = 0;
        for (std::size_t i = 0; i < large.size(); ++i) {
            const Uint128 d = static_cast<Uint128>(large[i]) - (i < small.size() ? small[i] : 0) - borrow;
            result.limbs_.push_back(static_cast<std::uint64_t>(d));
            borrow = static_cast<std::uint64_t>(d >> 64) & 1;
        }
        result.negative_ = turned ? b_negative : negative_;
    }
    result.trim();
    return result;
}

BigInt operator*(const BigInt& a, const BigInt& b) {
    BigInt result;
    result.limbs_.assign(a.limbs_.size() + b.limbs_.size(), 0);
    for (std::size_t i = 0; i < a.limbs_.size(); ++i) {
        if (a.limbs_[i] == 0) continue;
        std::uint64_t carry = 0;
        for (std::size_t j = 0; j < b.limbs_.size(); ++j) {
            const Uint128 t = static_cast<Uint128>(a.limbs_[i]) * b.limbs_[j] + result.limbs_[i + j] + carry;
            result.limbs_[i + j] = static_cast<std::uint64_t>(t);
            carry = static_cast<std::uint64_t>(t >> 64);
        }
        result.limbs_[i + b.limbs_.size()] = carry;
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
