// Bounds on the rounding of the walk. tests/stages/star_bounds.cpp compares each bound with rationals.
//
// Lengths are in window units. u = 2^-53, e = 2^-24. X is an exact vertex relative to its seed, x the computed one. n
// is the exact normal of a plane n.X = h, and cond = |na||nb||nc| / det of the three planes of the vertex.
//
// Vertex. Cell has 62 u cond |X| for normals that are rounded once (cell.hpp); a second rounding adds 13 u. Hence
//     |x - X| <= 80 u cond |X|                       without weights.
// Tilt. Weights that vary smoothly are w = c + 2 a.q + r around a home, with small residuals r. The power diagram of
// (q, w) at Y is that of (q, r) at Y + a. So with weights the walk sees vertices moved by a: X = Y + a. A plane through
// Y is n.Y = (|n|^2 + w_p - w_q) / 2, and as r_p - r_q = w_p - w_q + 2 a.n,
//     n.X = h = (|n|^2 + w_p - w_q) / 2 + a.n = (|n|^2 + r_p - r_q) / 2.
// All that follows is about X and r; the exact planes have w. A seed cuts X off only if h < |n||X|, so only if its
// plane is nearer to the moved seed than X. With its distance |n| >= D, the residuals and `more` >= r_q - r_p, 0 or
// more, that takes D^2 - more < 2 D |X|.
//
// With weights h = (|n|^2 + d) / 2 + a.n, d = w_p - w_q. It is rounded by less than u (5 |n|^2 + |d| + 5 |n||a| + |h|),
// and d = 2 n.(X - a) - |n|^2, so by less than u |n| (6 |n| + 3 |X| + 7 |a|). An error of h moves the vertex by as much
// over |n| times cond. Three planes, with L the longest normal, add u cond (18 L + 9 |X| + 21 |a|); 15 u |X| of the 62
// were for h already. Hence
//     |x - X| <= 100 u cond (|X| + (L + |a|) / 4)    with weights.
// cond is at most 10^6. `length` is |x| without weights, and |x| + (L + |a|) / 4 or more with them. Then
//     |x - X| <= 0.6 margin length.                                                                            (1)
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

// Returns the square of `length` with weights, or more: (a + b)^2 <= 2 a^2 + 2 b^2.
inline double weighted_length2(double x2, double longest2, double tilt2) {
    return 2 * x2 + 0.25 * (longest2 + tilt2);
}

// Returns an upper bound of |X|^2, by (1). factor: 1, or if x2 and |X| are lengths by another metric, the largest
// square of such a length of a vector of length 1.
inline double max_square(double x2, double length2, double factor) {
    return x2 + 2 * margin * (x2 + 1.01 * factor * length2);
}

// Returns an upper bound of the distance from x to a seed that cuts X off, without weights: |X| and the step to x.
inline double widest_reach(double x2) {
    return std::sqrt(x2) * (1 + 4 * margin);
}

// Returns an upper bound of (2 |X|)^2 without weights, where |X| <= |x| (1 + 0.45 margin).
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

// An image is off by image_step, see below.
inline constexpr double image_step = 0.0137;

// Returns the error that residuals add to h. They span `span`, including the own one. Two of them, in floats, and their
// difference are rounded by e (|r| + |s| + |r - s|) <= 2 e span, which with the sums makes 3 e span. Before, r = w -
// base
// - 2 a.(q - origin) was rounded in doubles, in units of terms of at most 2 |a| sqrt(3) extent and |r| plus that. The
// place of an image is off by image_step, which moves a.q. extent: of the window on either side, along an axis.
inline double weight_rounding(double span, double tilt, double extent) {
    return 1.01 * (3 * float_unit * span + 8 * unit * (span + 8 * tilt * extent)) + image_step * tilt;
}

// Returns the error of turn.N / 2 in h, where a seed's own tilt differs from the window's by turn / 2. N is off by q
// and e |N|, turn by e, its three products and sums with residuals round 3 e |turn||N| more. What they round of
// residuals fits into weight_rounding().
inline double turn_rounding(double turn, double longest) {
    return 1.01 * (4 * float_unit * turn * longest + 0.5 * quantum * turn);
}

// With weights the vertex is off by 0.2 e (L + |a|) / 4 more, where L is at most `longest`.
inline FloatMargin float_margin(double longest, double tilt, double weight_rounding) {
    FloatMargin m = float_margin(longest);
    m.constant += 1.01 * float_unit * 0.0625 * longest * (longest + tilt) + weight_rounding;
    return m;
}

// Returns how much smaller h may be than it seems, for a seed that the search for planes nearer than `distance` skips.
// Its H in floats is larger than H by at most 5 e |N|^2 and the error of residuals, and |N| is at most 2 sqrt(3)
// extent. From H >= distance |N| + slack follows for the exact plane, as |N|^2 - |n|^2 <= q (2 |N| + q),
//     h >= distance |N| - q (|N| + q / 2) + 2 quantum distance,  |n| <= |N| + q,
// hence h / |n| >= distance - quantum.
inline double select_slack(double distance, double extent, double weight_rounding) {
    return 1.01 * 60 * float_unit * extent * extent + weight_rounding + 2 * quantum * distance;
}

// Images in doubles. A coordinate of an image or a moved seed is off by image_rounding, so a difference n of two by r =
// 2 sqrt(3) image_rounding = 0.0136. n.X - |n|^2 / 2 is positive for seeds that cut X off. Rounding changes it by at
// most |n - X| r + r^2 / 2 < |X| r + r^2 / 2, and x by 0.45 margin |n||X|. The test for seeds in a ball
// (StarKernels::inside_ball) allows for 2 margin (|n|^2 + |X|^2). That is enough if 1.97 margin |X| >= r + r^2 / |X|:
// for |X|^2 above 2^36.8. The clipper handles cells with images that have nearer vertices. With weights the test
// allows for four times as much, and for r |a|, as h moves by a.n.
inline constexpr double min_image_vertex2 = 0x1p37;

}  // namespace votess::cpu::bounds
