// Volume, centroid and areas of a cell, from its corners alone: no edge is looked up.
//
// Between the seed, its foot on a face A, the foot on the line of A and B, and a corner on that line lies an
// orthoscheme, a tetrahedron with three right angles in a row; each corner has six of them, and with signs they fill
// the cell. Planes are a.x = h_a here, a being half the way to the neighbor, and the foot is f_a a,
// f_a = h_a / |a|^2: without weights h_a = |a|^2 and f_a = 1. With c the third plane of a corner x and
//     w_ab = (x.ab) sign(det) / |ab|^2,  ab = a x b,  det = a.(b x c),     q_a = (h_b - f_a a.b) w_ab
// the triangle on the face has the area |a| q_a / 2 and the orthoscheme the volume h_a q_a / 6. Its centroid is the
// quarter of the sum of f_a a, the corner, and the foot on the line, which is x - (x.ab) ab / |ab|^2.
//
// Error. Let u = 2^-53 and cond = |a||b||c| / |det|. No foot is farther away than x, so each orthoscheme has at most
// |x|^3 / 6. The corner is wrong by 62 u cond |x| (cell.hpp), ab by 6 u |a||b|, h_b - f_a a.b by 14 u |b||x|, and
// |ab| |c| >= |det|: that sums to 106 u cond |x|^3 / 6 for each of six. `corner_error` has room for what rounds the
// sums. With weights the rounding of a plane counts like that of a point farther away, by |n| / 4 (star.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpu/measure/cell_shape.hpp"

namespace votess::cpu {

template <class Isa>
class CellMeter {
    using Lanes = typename Isa::Lanes;  // four doubles
    using Pair __attribute__((vector_size(16), may_alias)) = double;
    using Bits __attribute__((vector_size(32))) = std::int64_t;
    using Stored __attribute__((vector_size(32), aligned(32), may_alias)) = double;
    struct Vector {
        Lanes x, y, z;
    };
    struct Planes {  // of four corners
        Vector n;
        Lanes h;
    };
    struct alignas(64) Sums {
        static constexpr int count = CellShape::most_planes + 4;  // with the fillers; a multiple of 4
        std::array<double, count> q, h, foot;                     // by rank
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

    // What the line of two planes a, b adds at a corner: to q_a, q_b and the volume (times 6), and by how much of a x b
    // the foot on the line differs from the corner.
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

    template <bool Weighted>
    static bool measure(CellShape& shape, CellMeasures& out) {
        constexpr double accepted_error = 5e-11;  // of the volume; the promise is 1e-10
        constexpr double unit = 0x1p-53;
        constexpr double corner_error = Weighted ? 240 * unit : 160 * unit;
        constexpr double smallest_volume = 1e-140, smallest_square = 1e-90;  // no product of six leaves the range
        constexpr double worst_condition2 = 1e16;

        // Planes are handled four at a time: what fills the last four is wanted by no corner.
        for (int p = shape.planes; p % 4 != 0; ++p) shape.plane[p] = shape.plane[0];
        Sums sums;
        Lanes least = Lanes{} + std::numeric_limits<double>::infinity(), longest{};
        for (int p = 0; p < shape.planes; p += 4) {
            CellShape::Plane* plane = &shape.plane[p];
            Planes four;
            load([&](int lane) { return plane + lane; }, four);
            Lanes square;
            dot(four.n, four.n, square);
            least = square < least ? square : least;
            if constexpr (Weighted) longest = square > longest ? square : longest;
            const Lanes h = Weighted ? square + four.h : square;
            for (int k = 0; k < 4; ++k) plane[k].power = h[k];
            lanes(&sums.h[p]) = h;
            lanes(&sums.q[p]) = Lanes{};
            if constexpr (Weighted) lanes(&sums.foot[p]) = h / square;
        }
        if (!(smallest(least) > smallest_square)) return false;
        lanes(&sums.q[CellShape::most_planes]) = lanes(&sums.foot[CellShape::most_planes]) = Lanes{};

        CornerOrder order;
        Isa::order_corners(shape, order);
        Vector moments{}, feet{};
        Lanes errors{}, farthest{}, conditions{};
        const double further = Weighted ? 0.5 * std::sqrt(largest(longest)) : 0;
        for (int i = 0; i < shape.corners; i += 4) {
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

            Lanes x2, products, error;
            dot(x, x, x2);
            farthest = x2 > farthest ? x2 : farthest;
            if constexpr (Weighted) {
                Lanes a2, b2, c2;
                dot(a.n, a.n, a2);
                dot(b.n, b.n, b2);
                dot(c.n, c.n, c2);
                products = a2 * b2 * c2;
            } else {
                products = a.h * b.h * c.h;
            }
            const Lanes condition2 = products * (inverse * inverse);
            conditions = condition2 > conditions ? condition2 : conditions;
            Lanes length2 = x2;
            if constexpr (Weighted) {
                Lanes length;
                square_roots(x2, length);
                length2 = (length + further) * (length + further);
            }
            square_roots(condition2 * (length2 * length2), error);
            errors += error;

            Line on_ab, on_bc, on_ca;
            meet<Weighted>(ab, a_b, x, sign, a.h, b.h, foot_a, foot_b, on_ab);
            add(on_ab.share * on_ab.volume, ab, feet);
            meet<Weighted>(bc, b_c, x, sign, b.h, c.h, foot_b, foot_c, on_bc);
            add(on_bc.share * on_bc.volume, bc, feet);
            meet<Weighted>(ca, c_a, x, sign, c.h, a.h, foot_c, foot_a, on_ca);
            add(on_ca.share * on_ca.volume, ca, feet);
            const Lanes volume = on_ab.volume + on_bc.volume + on_ca.volume;
            add(volume, x, moments);
            const Lanes q_a = on_ab.q_a + on_ca.q_b, q_b = on_ab.q_b + on_bc.q_a, q_c = on_bc.q_b + on_ca.q_a;
            for (int k = 0; k < 4; ++k) {
                at(sums.q.data(), rank_a[k]) += q_a[k];
                at(sums.q.data(), rank_b[k]) += q_b[k];
                at(sums.q.data(), rank_c[k]) += q_c[k];
            }
        }

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
        moment += Lanes{sum(2 * moments.x - feet.x), sum(2 * moments.y - feet.y), sum(2 * moments.z - feet.z)};
        const double volume = sum(volumes);
        out.farthest_squared = largest(farthest);
        out.volume = volume / 6;
        for (int k = 0; k < 3; ++k) out.centroid[k] = moment[k] / (4 * volume);
        const double reach = std::sqrt(out.farthest_squared) + further;
        return out.volume > smallest_volume && largest(conditions) <= worst_condition2 &&
               corner_error * sum(errors) * reach <= accepted_error * out.volume;
    }

public:
    static bool measure(CellShape& shape, CellMeasures& out) {
        return shape.weighted ? measure<true>(shape, out) : measure<false>(shape, out);
    }
};

}  // namespace votess::cpu
