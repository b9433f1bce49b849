// Volume, centroid and areas of a cell, from its corners only. No edge is looked up.
//
// Between the seed, its foot on a face A, the foot on the line of A and B, and a corner on that line lies an
// orthoscheme: a tetrahedron with three right angles in a row. Each corner has six of them, and with signs they fill
// the cell. Planes are a.x = h_a, where a is half the way to the neighbor. The foot is f_a a with f_a = h_a / |a|^2;
// without weights h_a = |a|^2 and f_a = 1. With c the third plane of a corner x and
//     w_ab = (x.ab) sign(det) / |ab|^2,  ab = a x b,  det = a.(b x c),     q_a = (h_b - f_a a.b) w_ab
// the triangle on the face has the area |a| q_a / 2 and the orthoscheme the volume h_a q_a / 6. Its centroid is a
// quarter of the sum of f_a a, the corner, and the foot on the line, which is x - (x.ab) ab / |ab|^2.
//
// Error. Let u = 2^-53 and cond = |a||b||c| / |det|. No foot is farther away than x, so each orthoscheme has at most
// |x|^3 / 6, and |f_a a| |x|^2 / 6. The corner is wrong by 62 u cond |x| (cell.hpp), ab by 6 u |a||b|, h_b - f_a a.b by
// 14 u |b||x|, and |ab| |c| >= |det|: that sums to 106 u cond |x|^3 / 6 for each of six. `corner_error` also covers the
// rounding of the sums. Corners whose cond is large are solved exactly. Their error is that of their lines, whose cond
// |a||b| / |ab| is smaller. With weights the rounding of a plane counts like that of a point farther away, by |n| / 4
// (star_bounds.hpp).
//
// With weights the seed may lie far outside of its cell. All that is measured around a point near the cell instead: the
// seed moved by -m, where the planes are n.x = h_n + n.m, with m by least squares so that these are close to |n|^2.
// That counts like a corner farther away by |m| / 4.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "polytope/cell_shape.hpp"

namespace votess::cpu {

template <class Isa>
class CellMeter {
    static constexpr double accepted_error = 5e-11;  // of the volume; the promise is 1e-10
    static constexpr double unit = 0x1p-53;
    template <bool Weighted>
    static constexpr double corner_error = Weighted ? 240 * unit : 160 * unit;
    static constexpr double unknown_sign2 = 1e26;  // beyond this the sign of the determinant is unknown
    // The squared conditions beyond which corners are solved exactly: at first, and if the errors are too large then.
    static constexpr double worst_condition2 = 4e6, careful_condition2 = 1e4;

    using Lanes = typename Isa::Lanes;  // four doubles
    using Pair __attribute__((vector_size(16), may_alias)) = double;
    using Bits __attribute__((vector_size(32))) = std::int64_t;
    using Words __attribute__((vector_size(32))) = std::uint64_t;
    using Stored __attribute__((vector_size(32), aligned(32), may_alias)) = double;
    struct Vector {
        Lanes x, y, z;
    };
    struct Planes {  // of four corners
        Vector n;
        Lanes h;
    };
    struct alignas(64) Sums {
        static constexpr int count = CellShape::max_planes + 4;  // with the fillers; a multiple of 4
        std::array<double, count> q, h, foot;                    // by rank
    };

    [[gnu::always_inline]] static void cross(const Vector& a, const Vector& b, Vector& out) {
        Isa::multiply_subtract(a.y, b.z, a.z * b.y, out.x);
        Isa::multiply_subtract(a.z, b.x, a.x * b.z, out.y);
        Isa::multiply_subtract(a.x, b.y, a.y * b.x, out.z);
    }
    [[gnu::always_inline]] static void dot(const Vector& a, const Vector& b, Lanes& out) {
        Isa::multiply_add(a.y, b.y, a.x * b.x, out);
        Isa::multiply_add(a.z, b.z, out, out);
    }
    // out += by * v
    [[gnu::always_inline]] static void add(const Lanes& by, const Vector& v, Vector& out) {
        Isa::multiply_add(by, v.x, out.x, out.x);
        Isa::multiply_add(by, v.y, out.y, out.y);
        Isa::multiply_add(by, v.z, out.z, out.z);
    }
    // plane(k) is the address of the plane of lane k.
    template <class Plane>
    [[gnu::always_inline]] static void load(Plane plane, Planes& out) {
        const auto half = [&](int lane, int which) -> const Pair& {
            return reinterpret_cast<const Pair*>(plane(lane))[which];
        };
        const Lanes xy02 = __builtin_shufflevector(half(0, 0), half(2, 0), 0, 1, 2, 3);
        const Lanes xy13 = __builtin_shufflevector(half(1, 0), half(3, 0), 0, 1, 2, 3);
        const Lanes zh02 = __builtin_shufflevector(half(0, 1), half(2, 1), 0, 1, 2, 3);
        const Lanes zh13 = __builtin_shufflevector(half(1, 1), half(3, 1), 0, 1, 2, 3);
        out.n.x = __builtin_shufflevector(xy02, xy13, 0, 4, 2, 6);
        out.n.y = __builtin_shufflevector(xy02, xy13, 1, 5, 3, 7);
        out.n.z = __builtin_shufflevector(zh02, zh13, 0, 4, 2, 6);
        out.h = __builtin_shufflevector(zh02, zh13, 1, 5, 3, 7);
    }
    [[gnu::always_inline]] static void load(const CellShape& shape, const std::uint16_t* rank, Planes& out) {
        static_assert(sizeof(CellShape::Plane) == 8 * CornerOrder::rank_step);
        const auto* planes = reinterpret_cast<const std::byte*>(shape.plane.data());
        load([&](int lane) { return planes + std::size_t{8} * rank[lane]; }, out);
    }
    [[gnu::always_inline]] static double& at(double* values, std::uint16_t rank) {
        static_assert(sizeof(double) == 2 * CornerOrder::rank_step);
        return *reinterpret_cast<double*>(reinterpret_cast<std::byte*>(values) + std::size_t{2} * rank);
    }
    [[gnu::always_inline]] static Stored& lanes(double* at) { return *reinterpret_cast<Stored*>(at); }
    [[gnu::always_inline]] static double sum(const Lanes& v) { return (v[0] + v[1]) + (v[2] + v[3]); }
    [[gnu::always_inline]] static double smallest(const Lanes& v) {
        return std::min(std::min(v[0], v[1]), std::min(v[2], v[3]));
    }
    [[gnu::always_inline]] static double largest(const Lanes& v) {
        return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
    }
    [[gnu::always_inline]] static void square_roots(const Lanes& v, Lanes& out) {
        out = Lanes{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
    }

    // Writes upper bounds of the square roots, at most 7 % larger; NaN if they are infinite. The processor finds them
    // while it divides, unlike roots: halving the exponent is sharp at powers of 4, and a root is concave between them.
    [[gnu::always_inline]] static void root_bound(const Lanes& v, Lanes& out) {
        constexpr std::uint64_t half_of_one = std::uint64_t{1023} << 51;  // of its exponent
        const Lanes root = reinterpret_cast<Lanes>((reinterpret_cast<Words>(v) >> 1) + half_of_one);
        Isa::multiply_add(v, Lanes{}, root, out);
    }

    // The terms of the line of two planes a, b at a corner: of q_a, q_b and the volume (times 6), and the multiple of a
    // x b by which the corner differs from the foot on the line.
    struct Line {
        Lanes q_a, q_b, volume, share;
    };
    // product: a.b
    template <bool Weighted>
    [[gnu::always_inline]] static void meet(const Vector& ab, const Lanes& product, const Vector& x, const Bits& sign,
                                            const Lanes& a_h, const Lanes& b_h, const Lanes& foot_a,
                                            const Lanes& foot_b, Line& out) {
        Lanes square, along;
        dot(ab, ab, square);
        dot(x, ab, along);
        out.share = along / square;
        const Lanes w = reinterpret_cast<Lanes>(reinterpret_cast<Bits>(out.share) ^ sign);
        out.q_a = (b_h - (Weighted ? foot_a * product : product)) * w;
        out.q_b = (a_h - (Weighted ? foot_b * product : product)) * w;
        Isa::multiply_add(a_h, out.q_a, b_h * out.q_b, out.volume);
    }

    // The place around which a cell is measured, with weights.
    struct Center {
        std::array<double, 3> move{};  // from there to the seed
        double moved = 0;              // a quarter of its length
        double further = 0;            // a quarter of the distance of the farthest neighbor
    };

    // Sums over corners.
    struct Totals {
        Vector moments{}, feet{};
        Lanes errors{}, farthest{};  // farthest: squared
        Lanes from_seed{};           // the same from the seed, with weights
    };

    // Solves those of four corners exactly whose squared condition is above `worst`. Their condition2 becomes that of
    // the worst of the three lines, which may still be good.
    [[gnu::noinline]] static void solve_doubtful(const ExactCorners& exact, const Center& center, const Planes& a,
                                                 const Planes& b, const Planes& c,
                                                 const std::uint16_t* const (&ranks)[3], double worst, Vector& x,
                                                 Lanes& condition2) {
        for (int k = 0; k < 4; ++k) {
            if (condition2[k] <= worst) continue;
            if (!(condition2[k] <= unknown_sign2)) {
                condition2[k] = std::numeric_limits<double>::infinity();
                continue;
            }
            std::array<unsigned, 3> three;
            for (std::size_t p = 0; p < 3; ++p) three[p] = unsigned{ranks[p][k]} / CornerOrder::rank_step;
            const std::array<double, 3> at = exact.corner(three);
            x.x[k] = at[0] + center.move[0], x.y[k] = at[1] + center.move[1], x.z[k] = at[2] + center.move[2];
            condition2[k] = worst_line(a, b, c, k);
        }
    }
    // Returns the squared condition of the worst line of two of three planes.
    static double worst_line(const Planes& a, const Planes& b, const Planes& c, int k) {
        const auto line = [k](const Vector& u, const Vector& v) {
            const double across[3] = {u.y[k] * v.z[k] - u.z[k] * v.y[k], u.z[k] * v.x[k] - u.x[k] * v.z[k],
                                      u.x[k] * v.y[k] - u.y[k] * v.x[k]};
            return (u.x[k] * u.x[k] + u.y[k] * u.y[k] + u.z[k] * u.z[k]) *
                   (v.x[k] * v.x[k] + v.y[k] * v.y[k] + v.z[k] * v.z[k]) /
                   (across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
        };
        return std::max({line(a.n, b.n), line(b.n, c.n), line(c.n, a.n)});
    }

    // Adds four corners from the i-th on. Without Doubtful, returns false if the squared condition of one is above
    // `worst`.
    template <bool Weighted, bool Doubtful>
    [[gnu::always_inline]] static bool add_corners(const CellShape& shape, const CornerOrder& order, int i,
                                                   const Center& center, double worst, Sums& sums, Totals& totals) {
        const std::uint16_t *rank_a = &order.rank[0][i], *rank_b = &order.rank[1][i], *rank_c = &order.rank[2][i];
        Planes a, b, c;
        load(shape, rank_a, a);
        load(shape, rank_b, b);
        load(shape, rank_c, c);
        Lanes foot_a{}, foot_b{}, foot_c{};
        if constexpr (Weighted)
            for (int k = 0; k < 4; ++k) {
                foot_a[k] = at(sums.foot.data(), rank_a[k]);
                foot_b[k] = at(sums.foot.data(), rank_b[k]);
                foot_c[k] = at(sums.foot.data(), rank_c[k]);
            }
        Lanes a_b, b_c, c_a, determinant;
        Vector ab, bc, ca;
        dot(a.n, b.n, a_b);
        cross(a.n, b.n, ab);
        dot(b.n, c.n, b_c);
        cross(b.n, c.n, bc);
        dot(a.n, bc, determinant);
        dot(c.n, a.n, c_a);
        cross(c.n, a.n, ca);
        const Lanes inverse = 1 / determinant;
        Vector x{a.h * bc.x, a.h * bc.y, a.h * bc.z};
        add(b.h, ca, x);
        add(c.h, ab, x);
        x.x *= inverse, x.y *= inverse, x.z *= inverse;
        const Bits sign = reinterpret_cast<Bits>(determinant) & std::numeric_limits<std::int64_t>::min();

        Lanes products;
        if constexpr (Weighted) {
            Lanes a2, b2, c2;
            dot(a.n, a.n, a2);
            dot(b.n, b.n, b2);
            dot(c.n, c.n, c2);
            products = a2 * b2 * c2;
        } else {
            products = a.h * b.h * c.h;
        }
        Lanes condition2 = products * (inverse * inverse);
        if constexpr (Doubtful)
            solve_doubtful(*shape.exact, center, a, b, c, {rank_a, rank_b, rank_c}, worst, x, condition2);
        else if (Isa::any_above(condition2, worst))
            return false;
        Lanes x2, error;
        dot(x, x, x2);
        totals.farthest = x2 > totals.farthest ? x2 : totals.farthest;
        Lanes length2 = x2;
        if constexpr (Weighted) {
            const Vector seen{x.x - center.move[0], x.y - center.move[1], x.z - center.move[2]};
            Lanes distance2;
            dot(seen, seen, distance2);
            const Bits is_corner = Bits{i, i + 1, i + 2, i + 3} < shape.corners;  // fillers meet in the center
            totals.from_seed = (is_corner & (distance2 > totals.from_seed)) ? distance2 : totals.from_seed;
            Lanes length;
            square_roots(x2, length);
            length += center.further;
            length2 = length * (length + center.moved);
        }
        root_bound(condition2 * (length2 * length2), error);
        totals.errors += error;

        Line on_ab, on_bc, on_ca;
        meet<Weighted>(ab, a_b, x, sign, a.h, b.h, foot_a, foot_b, on_ab);
        add(on_ab.share * on_ab.volume, ab, totals.feet);
        meet<Weighted>(bc, b_c, x, sign, b.h, c.h, foot_b, foot_c, on_bc);
        add(on_bc.share * on_bc.volume, bc, totals.feet);
        meet<Weighted>(ca, c_a, x, sign, c.h, a.h, foot_c, foot_a, on_ca);
        add(on_ca.share * on_ca.volume, ca, totals.feet);
        const Lanes volume = on_ab.volume + on_bc.volume + on_ca.volume;
        add(volume, x, totals.moments);
        const Lanes q_a = on_ab.q_a + on_ca.q_b, q_b = on_ab.q_b + on_bc.q_a, q_c = on_bc.q_b + on_ca.q_a;
        for (int k = 0; k < 4; ++k) {
            at(sums.q.data(), rank_a[k]) += q_a[k];
            at(sums.q.data(), rank_b[k]) += q_b[k];
            at(sums.q.data(), rank_c[k]) += q_c[k];
        }
        return true;
    }
    template <bool Weighted>
    [[gnu::noinline]] static void add_doubtful(const CellShape& shape, const CornerOrder& order, int i,
                                               const Center& center, double worst, Sums& sums, Totals& totals) {
        add_corners<Weighted, true>(shape, order, i, center, worst, sums, totals);
    }

    // Bounds the errors of volume and areas more sharply, for long or flat cells, with D the distance of a face and t
    // and s the distances from its foot to the line and from there to the corner. An orthoscheme has D t s / 6. The
    // corner is wrong by e, s by e + 24 u c |x| where c is the condition of the line, t by 14 u c |x|, D by 8 u D; the
    // sums are rounded as above.
    template <bool Weighted>
    [[gnu::noinline]] static bool is_exact_enough(const CellShape& shape, const CornerOrder& order,
                                                  const Center& center, double worst, const CellMeasures& found) {
        double volume_error = 0, area_error = 0;
        for (int i = 0; i < shape.corners; i += 4) {
            Planes a, b, c;
            load(shape, &order.rank[0][i], a);
            load(shape, &order.rank[1][i], b);
            load(shape, &order.rank[2][i], c);
            Vector ab, bc, ca;
            cross(a.n, b.n, ab);
            cross(b.n, c.n, bc);
            cross(c.n, a.n, ca);
            Lanes determinant, a2, b2, c2;
            dot(a.n, bc, determinant);
            dot(a.n, a.n, a2);
            dot(b.n, b.n, b2);
            dot(c.n, c.n, c2);
            for (int k = 0; k < std::min(4, shape.corners - i); ++k) {
                const auto coordinate = [&](const Lanes& u, const Lanes& v, const Lanes& w) {
                    return (a.h[k] * u[k] + b.h[k] * v[k] + c.h[k] * w[k]) / determinant[k];
                };
                const double x = coordinate(bc.x, ca.x, ab.x), y = coordinate(bc.y, ca.y, ab.y),
                             z = coordinate(bc.z, ca.z, ab.z);
                const double condition2 = a2[k] * b2[k] * c2[k] / (determinant[k] * determinant[k]);
                if (!(condition2 <= unknown_sign2)) return false;
                const double longest = Weighted ? std::sqrt(std::max({a2[k], b2[k], c2[k]})) : 0;
                const double wrong = 62 * std::sqrt(condition2);  // this x, in units of its length
                const double length =
                    (std::sqrt(x * x + y * y + z * z) + 0.5 * longest + center.moved) * (1 + unit * wrong);
                const double corner = (condition2 > worst ? 2 : wrong) * length;
                // on: the plane of the face
                const auto add = [&](const Planes& on, double square, const Planes& other, double other2,
                                     const Vector& line) {
                    const double across = line.x[k] * line.x[k] + line.y[k] * line.y[k] + line.z[k] * line.z[k];
                    const double product =
                        on.n.x[k] * other.n.x[k] + on.n.y[k] * other.n.y[k] + on.n.z[k] * other.n.z[k];
                    const double norm = std::sqrt(square), edge = 1 / std::sqrt(across);
                    const double along =
                        std::abs(x * line.x[k] + y * line.y[k] + z * line.z[k]) * edge + unit * wrong * length;
                    const double to_line = std::abs(other.h[k] - on.h[k] / square * product) * norm * edge;
                    const double of_line = norm * std::sqrt(other2) * edge * length;
                    const double error = to_line * (corner + 32 * of_line + 54 * along) + 14 * of_line * along;
                    volume_error += error * (std::abs(on.h[k]) / norm + (Weighted ? norm : 0)) / 6;
                    area_error += error / 2;
                };
                add(a, a2[k], b, b2[k], ab), add(b, b2[k], a, a2[k], ab);
                add(b, b2[k], c, c2[k], bc), add(c, c2[k], b, b2[k], bc);
                add(c, c2[k], a, a2[k], ca), add(a, a2[k], c, c2[k], ca);
            }
        }
        const double surface = std::accumulate(found.areas.begin(), found.areas.begin() + shape.planes, 0.0);
        constexpr double rounded = Weighted ? 1.5 * unit : unit;
        return rounded * volume_error <= accepted_error * found.volume &&
               rounded * area_error <= 2 * accepted_error * surface;
    }

    // Solves the normal equations of power + n.move = 0, each divided by |n|^2.
    [[gnu::noinline]] static void find_center(const CellShape& shape, Center& center) {
        Lanes xx{}, xy{}, xz{}, yy{}, yz{}, zz{}, bx{}, by{}, bz{};
        for (int p = 0; p < shape.planes; p += 4) {
            Planes four;
            load([&](int lane) { return &shape.plane[p + lane]; }, four);
            Lanes square, there;
            dot(four.n, four.n, square);
            for (int k = 0; k < 4; ++k) there[k] = p + k < shape.planes ? 1 : 0;
            const Lanes share = there / square, x = share * four.n.x, y = share * four.n.y, z = share * four.n.z;
            xx += x * four.n.x, xy += x * four.n.y, xz += x * four.n.z;
            yy += y * four.n.y, yz += y * four.n.z, zz += z * four.n.z;
            bx -= x * four.h, by -= y * four.h, bz -= z * four.h;
        }
        const double a = sum(xx), b = sum(xy), c = sum(xz), d = sum(yy), e = sum(yz), f = sum(zz);
        const double u = sum(bx), v = sum(by), w = sum(bz);
        const double df = d * f - e * e, ce = c * e - b * f, be = b * e - c * d;
        const double determinant = a * df + b * ce + c * be;
        constexpr double flat = 1e-3;  // the trace is the number of planes
        if (!(determinant > flat)) return;
        center.move = {(df * u + ce * v + be * w) / determinant,
                       (ce * u + (a * f - c * c) * v + (b * c - a * e) * w) / determinant,
                       (be * u + (b * c - a * e) * v + (a * d - b * b) * w) / determinant};
        const auto& [x, y, z] = center.move;
        center.moved = 0.25 * std::sqrt(x * x + y * y + z * z);
        if (!(center.moved < std::numeric_limits<double>::infinity())) center = {};
    }

    // Fills h and the feet of the planes, and h of the shape. Clears q. Returns false if a plane is too near for
    // products of six.
    template <bool Weighted>
    static bool read_planes(CellShape& shape, Center& center, Sums& sums) {
        constexpr double smallest_square = 1e-90;
        // Planes are handled four at a time; the padding lanes are ignored.
        for (int p = shape.planes; p % 4 != 0; ++p) shape.plane[p] = shape.plane[0];
        if constexpr (Weighted) find_center(shape, center);
        Lanes least = Lanes{} + std::numeric_limits<double>::infinity(), longest{};
        for (int p = 0; p < shape.planes; p += 4) {
            CellShape::Plane* plane = &shape.plane[p];
            Planes four;
            load([&](int lane) { return plane + lane; }, four);
            Lanes square;
            dot(four.n, four.n, square);
            least = square < least ? square : least;
            if constexpr (Weighted) longest = square > longest ? square : longest;
            Lanes h = square;
            if constexpr (Weighted) {
                h += four.h;
                Isa::multiply_add(Lanes{} + center.move[0], four.n.x, h, h);
                Isa::multiply_add(Lanes{} + center.move[1], four.n.y, h, h);
                Isa::multiply_add(Lanes{} + center.move[2], four.n.z, h, h);
            }
            for (int k = 0; k < 4; ++k) plane[k].power = h[k];
            lanes(&sums.h[p]) = h;
            lanes(&sums.q[p]) = Lanes{};
            if constexpr (Weighted) lanes(&sums.foot[p]) = h / square;
        }
        lanes(&sums.q[CellShape::max_planes]) = Lanes{};
        lanes(&sums.foot[CellShape::max_planes]) = Lanes{};
        center.further = Weighted ? 0.5 * std::sqrt(largest(longest)) : 0;
        return smallest(least) > smallest_square;
    }

    // Solves corners exactly whose squared condition is above `worst`. Returns false if the errors may be too large.
    template <bool Weighted>
    static bool sum_corners(CellShape& shape, const CornerOrder& order, const Center& center, double worst, Sums& sums,
                            CellMeasures& out) {
        Totals totals;
        std::array<std::uint8_t, CellShape::max_corners / 4> doubtful;  // groups of four
        int doubts = 0;
        for (int i = 0; i < shape.corners; i += 4)
            if (!add_corners<Weighted, false>(shape, order, i, center, worst, sums, totals))
                doubtful[doubts++] = static_cast<std::uint8_t>(i / 4);
        if (doubts == 0) return sum_planes<Weighted>(shape, order, center, worst, sums, totals, out);
        // In memory, while those above are in registers.
        Totals with_doubtful = totals;
        for (int k = 0; k < doubts; ++k)
            add_doubtful<Weighted>(shape, order, 4 * doubtful[k], center, worst, sums, with_doubtful);
        return sum_planes<Weighted>(shape, order, center, worst, sums, with_doubtful, out);
    }

    // Sums over planes, when the corners are summed.
    template <bool Weighted>
    [[gnu::always_inline]] static bool sum_planes(CellShape& shape, const CornerOrder& order, const Center& center,
                                                  double worst, Sums& sums, const Totals& totals, CellMeasures& out) {
        constexpr double smallest_volume = 1e-140;  // no product of six leaves the range
        Lanes volumes{}, moment{};
        for (int p = 0; p < shape.planes; p += 4) {
            const Lanes h = lanes(&sums.h[p]), q = lanes(&sums.q[p]);
            Lanes part = h * q, squares = h, length;
            volumes += part;
            if constexpr (Weighted) {
                Planes four;
                load([&](int lane) { return &shape.plane[p + lane]; }, four);
                dot(four.n, four.n, squares);
                part *= lanes(&sums.foot[p]);
            }
            square_roots(squares, length);
            const Lanes area = 0.5 * length * q, none{};
            lanes(&out.areas[p]) = area > none ? area : none;
            for (int k = 0; k < 4; ++k) Isa::multiply_add(none + part[k], lanes(shape.plane[p + k].n), moment, moment);
        }
        moment += Lanes{sum(2 * totals.moments.x - totals.feet.x), sum(2 * totals.moments.y - totals.feet.y),
                        sum(2 * totals.moments.z - totals.feet.z)};
        const double volume = sum(volumes);
        out.farthest_squared = largest(Weighted ? totals.from_seed : totals.farthest);
        out.volume = volume / 6;
        for (int k = 0; k < 3; ++k) out.centroid[k] = moment[k] / (4 * volume) - center.move[k];
        const double reach = std::sqrt(largest(totals.farthest)) + center.further;
        return out.volume > smallest_volume &&
               (corner_error<Weighted> * sum(totals.errors) * reach <= accepted_error * out.volume ||
                is_exact_enough<Weighted>(shape, order, center, worst, out));
    }

    template <bool Weighted>
    static bool measure(CellShape& shape, CellMeasures& out) {
        Center center;
        Sums sums;
        if (!read_planes<Weighted>(shape, center, sums)) return false;
        CornerOrder order;
        Isa::order_corners(shape, order);
        for (const double worst : {worst_condition2, careful_condition2}) {
            if (sum_corners<Weighted>(shape, order, center, worst, sums, out)) return true;
            sums.q.fill(0);
        }
        return false;
    }

public:
    static bool measure(CellShape& shape, CellMeasures& out) {
        return shape.weighted ? measure<true>(shape, out) : measure<false>(shape, out);
    }
};

}  // namespace votess::cpu
