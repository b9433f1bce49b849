// Unevaluated sums of two doubles, about 106 bits. Sum and product have relative errors below 3.1 u^2 and 5.1 u^2, with
// u = 2^-53: algorithms 6 and 10 of Joldes, Muller, Popescu: Tight and rigorous error bounds for basic building blocks
// of double-word arithmetic (ACM TOMS 44(2), 2017). Wrong if the compiler contracts a*b+c.
#pragma once

namespace votess::exact {

struct DoubleDouble {
    double high = 0, low = 0;
};

inline DoubleDouble two_sum(double a, double b) {
    const double s = a + b, bb = s - a;
    return {s, (a - (s - bb)) + (b - bb)};
}

inline DoubleDouble fast_two_sum(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
}

// Dekker 1971: halves of 26 bits multiply exactly.
inline DoubleDouble two_product(double a, double b) {
    constexpr double splitter = 134217729;  // 2^27 + 1
    const double p = a * b;
    const double ta = splitter * a, ah = ta - (ta - a), al = a - ah;
    const double tb = splitter * b, bh = tb - (tb - b), bl = b - bh;
    return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble s = two_sum(a.high, b.high), t = two_sum(a.low, b.low);
    const DoubleDouble v = fast_two_sum(s.high, s.low + t.high);
    return fast_two_sum(v.high, t.low + v.low);
}

inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble p = two_product(a.high, b.high);
    return fast_two_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}

}  // namespace votess::exact
