// Integers of any size, for sums and quotients whose width is not known in advance. Slower than WideInt.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "exact/integer/wide_int.hpp"
#include "exact/quad.hpp"

namespace votess::exact {

// A number of limbs, on the heap if there are many.
class Limbs {
public:
    Limbs() {}  // NOLINT(modernize-use-equals-default): that would clear the limbs
    explicit Limbs(std::size_t size) : size_(size) {
        if (size > few) many_.resize(size);
    }
    Limbs(const Limbs& other) : size_(other.size_), many_(other.many_) { copy_few(other); }
    Limbs(Limbs&& other) noexcept : size_(other.size_), many_(std::move(other.many_)) {
        copy_few(other);
        other.clear();
    }
    Limbs& operator=(const Limbs& other) {
        many_ = other.many_;
        size_ = other.size_;
        copy_few(other);
        return *this;
    }
    Limbs& operator=(Limbs&& other) noexcept {
        many_ = std::move(other.many_);
        size_ = other.size_;
        copy_few(other);
        if (this != &other) other.clear();
        return *this;
    }
    ~Limbs() = default;

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    std::uint64_t* begin() { return many_.empty() ? few_.data() : many_.data(); }
    [[nodiscard]] const std::uint64_t* begin() const { return many_.empty() ? few_.data() : many_.data(); }
    std::uint64_t& operator[](std::size_t i) { return begin()[i]; }
    std::uint64_t operator[](std::size_t i) const { return begin()[i]; }
    [[nodiscard]] std::uint64_t back() const { return begin()[size_ - 1]; }
    void pop_back() { --size_; }

private:
    static constexpr std::size_t few = 32;
    void copy_few(const Limbs& other) {
        if (many_.empty() && &other != this) std::copy_n(other.few_.data(), size_, few_.data());
    }
    void clear() {
        size_ = 0;
        many_.clear();
    }

    std::size_t size_ = 0;
    std::array<std::uint64_t, few> few_;
    std::vector<std::uint64_t> many_;
};

class BigInt {
public:
    BigInt() = default;
    BigInt(std::int64_t x) : limbs_(x != 0 ? 1 : 0) {  // NOLINT(google-explicit-constructor): a number as any other
        if (x != 0) limbs_[0] = x < 0 ? 0 - static_cast<std::uint64_t>(x) : static_cast<std::uint64_t>(x);
        negative_ = x < 0;
    }
    template <int W>
    explicit BigInt(const WideInt<W>& x) : limbs_(W), negative_(x.negative()) {
        const WideInt<W> size = negative_ ? -x : x;
        std::copy_n(size.limb.begin(), W, limbs_.begin());
        trim();
    }

    [[nodiscard]] int sign() const { return negative_ ? -1 : limbs_.empty() ? 0 : 1; }
    // Truncates.
    explicit operator Quad() const;

    BigInt operator-() const&;
    friend BigInt operator+(const BigInt& a, const BigInt& b) { return a.sum(b, b.negative_); }
    friend BigInt operator-(const BigInt& a, const BigInt& b) { return a.sum(b, !b.negative_); }
    friend BigInt operator*(const BigInt& a, const BigInt& b);

private:
    // Returns *this plus |b|, or minus that.
    [[nodiscard]] BigInt sum(const BigInt& b, bool b_negative) const;
    void trim() {
        while (!limbs_.empty() && limbs_.back() == 0) limbs_.pop_back();
        if (limbs_.empty()) negative_ = false;
    }

    Limbs limbs_;  // of the absolute value, little endian; the last is not 0
    bool negative_ = false;
};

// A quotient, not reduced. The denominator is positive.
struct Fraction {
    BigInt numerator, denominator = 1;

    Fraction() = default;
    Fraction(BigInt n, BigInt d) : numerator(std::move(n)), denominator(std::move(d)) {
        if (denominator.sign() < 0) numerator = -numerator, denominator = -denominator;
    }
    [[nodiscard]] int sign() const { return numerator.sign(); }
    explicit operator Quad() const {
        return sign() == 0 ? Quad() : static_cast<Quad>(numerator) / static_cast<Quad>(denominator);
    }
    friend Fraction operator+(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.denominator + b.numerator * a.denominator, a.denominator * b.denominator};
    }
    friend Fraction operator-(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.denominator - b.numerator * a.denominator, a.denominator * b.denominator};
    }
    friend Fraction operator*(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.numerator, a.denominator * b.denominator};
    }
    friend bool operator<(const Fraction& a, const Fraction& b) { return (a - b).sign() < 0; }
    friend bool operator==(const Fraction& a, const Fraction& b) { return (a - b).sign() == 0; }
};

}  // namespace votess::exact
