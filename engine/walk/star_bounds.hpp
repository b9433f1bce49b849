// Bounds on the rounding of the walk. tests/stages/star_bounds.cpp compares each bound with rationals.
//
// Lengths are in window units. u = 2^-53, e = 2^-24. X is an exact vertex relative to its seed, x the computed one. n
// is the exact normal of a plane n.X = h, and cond = |na||nb||nc| / det of the three planes of the vertex.
//
// Vertex. Cell has 62 u cond |X| for normals that are rounded once (cell.hpp); a second rounding adds 13 u. Hence
//     |x - X| <= 80 u cond |X|                       without weights.
// With weights h = (|n|^2 + d) / 2, d = w_p - w_q. It is rounded by less than u (5 |n|^2 + |d|), and d = 2 n.X - |n|^2,
// so by less than u |n| (6 |n| + 2 |X|). An error of h moves the vertex by as much over |n| times cond. Three planes,
// with L the longest normal, add u cond (18 L + 6 |X|); 15 u |X| of the 62 were for h already. Hence
//     |x - X| <= 100 u cond (|X| + L / 4)            with weights.
// cond is at most 10^6. `length` is |x| without weights and |x| + L / 4 with them. Then
//     |x - X| <= 0.6 margin length.                                                                            (1)
// L is not an independent length: |n - X|^2 = |X|^2 - d for a plane through X, and -d <= more, so
//     L <= |X| + sqrt(|X|^2 + more).                                                                           (2)
#pragma once

#include <algorithm>
#include <cmath>

namespace votess::cpu::bounds {

inline constexpr double unit = 0x1p-53;
inline constexpr double float_unit = 0x1p-24;
inline constexpr double margin = 2e-8;
inline constexpr double worst_condition = 1e6;
inline constexpr double solved_factor = 80 * unit, weighted_factor = 100 * unit;
static_assert(weighted_factor * worst_condition < 0.58 * margin);

// Returns an upper bound of |X|, by (1).
inline double max_distance(double x, double length) {
    return x + 2 * margin * length;
}

// Returns an upper bound of the distance from x to a seed that cuts X off; 0 if there is none. more: upper bound of the
// excess of its weight over the own weight, maybe negative.
//
// A seed q cuts X off when |q - X|^2 < |X|^2 + more. (1) bounds both |X| and the step from X to x. The excess of 1.4
// margin length in each is far more than the rounding of these sums. A bound in units of |x| alone does not hold: by
// (2) L may be much longer than |x|, where another seed has a larger `more`.
inline double reach_from_vertex(double x, double length, double more) {
    const double most = max_distance(x, length), square = most * most + more;
    return square > 0 ? std::sqrt(square) + 2 * margin * length : 0;
}

// Returns the same for the largest `more` of all seeds, which is 0 or more. By (2) length is then less than 1.6
// sqrt(x^2 + more). So by (1) both errors together are less than 2 margin sqrt(x^2 + more).
inline double widest_reach(double x2, double more) {
    return std::sqrt(x2 + more) * (1 + 4 * margin);
}

// Returns an upper bound of the squared distance from the own seed to one that cuts X off, for the largest `more`. The
// distance is less than |X| + sqrt(|X|^2 + more), by the triangle inequality. The errors are those above.
inline double widest_reach_squared(double x2, double more) {
    const double reach = std::sqrt(x2) + std::sqrt(x2 + more);
    return reach * reach * (1 + 16 * margin);
}
// Returns the same without weights: (2 |X|)^2, where |X| <= |x| (1 + 0.45 margin).
inline double widest_reach_squared(double x2) {
    return 4 * x2 * (1 + margin);
}

// Returns an upper bound of the power of a vertex, |X|^2 - w. It is equal for all its seeds, so one of them finds it
// for the others. square: upper bound of |X|^2. The difference may cancel.
inline double power(double square, double weight) {
    return square - weight + 2 * unit * (square + std::abs(weight));
}
// Returns an upper bound of |X|^2 again, for a seed of weight w, or for several seeds from their largest power and
// largest weight. |X|^2 is not negative, so no power or weight of theirs is larger in size than these two.
inline double back(double power, double weight) {
    return std::max(0.0, power + weight + 4 * unit * (std::abs(power) + std::abs(weight)));
}

// Candidate planes in floats. The walk asks whether h - n.X may be 0 or less, so only rounding that makes it larger
// matters. Seeds are whole numbers, each coordinate off by half a unit, that of an image by image_rounding more. Hence
// N, the difference of two of them, is n + d with |d| <= q < 1.8. With H = |N|^2 / 2
//     (H - N.X) - (|n|^2 / 2 - n.X) = d.(N - X) - |d|^2 / 2 <= q (|N| + |X|).
// In floats N is rounded by e, |N|^2 by 5 e, products and sums of H - N.X by 3 e |N||X| and 3 e (H + |N||X|), and x by
// e and by 0.2 e of the vertex. So H - N.X is too large by at most
//     e (6.3 |N||X| + 9 H) + q (|N| + |X|),
// whether or not the target fuses a*b+c. `quantum` bounds q, and the longest |N| all |N|.
inline constexpr double quantum = 2;
inline constexpr double image_rounding = 0x1p-8;

struct FloatMargin {  // of a vertex: by_square x^2 + constant
    double by_square, constant;
};
// longest: upper bound of |N| of each candidate. |X| <= X^2 / longest + longest / 4.
inline FloatMargin float_margin(double longest) {
    const double square = longest * longest;
    return {1.01 * (float_unit * 6.5 + quantum / longest),
            1.01 * (float_unit * (6.5 * 0.25 + 4.6) * square + quantum * 1.25 * longest)};
}
// With weights that span `span`, including the own one. Two weights a, b and their difference are rounded by e (|a| +
// |b| + |a - b|) <= 2 e span, which with the sums makes 3 e span in h. The vertex is off by 0.2 e L / 4 more, with L by
// (2).
inline FloatMargin float_margin(double longest, double more, double span) {
    FloatMargin m = float_margin(longest);
    m.by_square += 1.01 * float_unit * 0.5;
    m.constant += 1.01 * float_unit * (0.125 * longest * longest + 0.25 * longest * std::sqrt(more) + 3 * span);
    return m;
}

// Images in doubles. A coordinate of an image or a moved seed is off by image_rounding, so a difference n of two by r =
// 2 sqrt(3) image_rounding = 0.0136. n.X - |n|^2 / 2 is positive for seeds that cut X off. Rounding changes it by at
// most |n - X| r + r^2 / 2 < |X| r + r^2 / 2, and x by 0.45 margin |n||X|. The test for seeds in a ball
// (StarKernels::inside_ball) allows for 2 margin (|n|^2 + |X|^2). That is enough if 1.97 margin |X| >= r + r^2 / |X|:
// for |X|^2 above 2^36.8. The clipper handles cells with images that have nearer vertices. With weights |n - X| is less
// than sqrt(|X|^2 + more), and the test allows for four times as much, also of more.
inline constexpr double min_image_vertex2 = 0x1p37;

}  // namespace votess::cpu::bounds
