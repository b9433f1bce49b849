// Orientations, sides, positions and wide numbers against rational arithmetic.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "exact/double_double.hpp"
#include "exact/integer/big_int.hpp"
#include "exact/integer/wide_int.hpp"
#include "exact/pair_vertex.hpp"
#include "exact/predicate.hpp"
#include "exact/quad.hpp"
#include "exact/wide_float.hpp"
#include "support/random.hpp"
#include "support/rational_planes.hpp"

using test::Random;
using test::random_plane;
using test::rational;
using test::RationalPlane;
using votess::exact::DoubleDouble;
using votess::exact::Plane;
using votess::exact::Point;

namespace {

struct Family {
    const char* name;
    double (*coordinate)(Random&);
    bool tied;  // has many exact ties
};

double small_integer(Random& r) {
    return static_cast<double>(r.integer(-3, 3));
}

const Family families[] = {
    {"small integers", small_integer, true},
    {"eighths", [](Random& r) { return 0.125 * static_cast<double>(r.integer(-3, 3)); }, true},
    {"tiny", [](Random& r) { return 0x1p-300 * small_integer(r); }, true},
    {"huge", [](Random& r) { return 0x1p300 * small_integer(r); }, true},
    {"subnormal", [](Random& r) { return 0x1p-1074 * small_integer(r); }, true},
    {"nearly infinite", [](Random& r) { return 0x1p1021 * small_integer(r); }, true},
    {"offset", [](Random& r) { return 1e8 + 0.5 * static_cast<double>(r.integer(-2, 2)); }, true},
    {"integers of 11 bits", [](Random& r) { return static_cast<double>(r.integer(-1023, 1023)); }, false},
    {"integers of 24 bits", [](Random& r) { return static_cast<double>(r.integer(-(1 << 23) + 1, (1 << 23) - 1)); },
     false},
    {"corners of a cube of 14 bits", [](Random& r) { return r.chance(0.5) ? -8191.0 : 8192.0; }, true},
    {"multiples of a short odd number", [](Random& r) { return static_cast<double>(1365 * r.integer(-5, 5)); }, false},
    {"multiples of a long odd number", [](Random& r) { return 0x3243f6a8885a3p-50 * small_integer(r); }, true},
    {"corners of a cube of 11 bits", [](Random& r) { return r.chance(0.5) ? -1023.0 : 1024.0; }, true},
    {"corners of a cube of 24 bits", [](Random& r) { return r.chance(0.5) ? -0x1p23 : 0x1p23 - 1; }, true},
    {"tenths", [](Random& r) { return 0.1 * small_integer(r); }, false},
    {"uniform", [](Random& r) { return r.uniform(); }, false},
    {"small integers among finer ones",
     [](Random& r) { return r.chance(0.9) ? small_integer(r) : std::ldexp(1.0, -static_cast<int>(r.below(150))); },
     true},
    {"integers of 30 bits", [](Random& r) { return static_cast<double>(r.integer(-(1 << 30), 1 << 30)); }, false},
    {"twenty decades", [](Random& r) { return r.uniform(-1, 1) * std::pow(10.0, r.uniform(-20, 0)); }, false},
    {"all of float64",
     [](Random& r) { return r.uniform(-1, 1) * std::ldexp(1.0, static_cast<int>(r.integer(-1074, 1000))); }, false},
};

// In line with a and b as seen from p, or nearly when rounding moves it; walls as they are.
Plane between(const Point& p, const Plane& a, const Plane& b) {
    if (a.kind != Plane::Kind::bisector || b.kind != Plane::Kind::bisector) return a;
    Point q;
    for (int k = 0; k < 3; ++k) q[k] = p[k] + ((a.seed[k] - p[k]) + (b.seed[k] - p[k]));
    for (double x : q)
        if (!std::isfinite(x)) return a;
    return Plane::bisector(q);
}

// Checks that the error is at most 2^-52 of the length.
void check_near(const Point& found, const test::RationalVector& x) {
    mpq_class square, error;
    for (int k = 0; k < 3; ++k) {
        const mpq_class off = mpq_class(found[k]) - x[k];
        square += x[k] * x[k], error += off * off;
    }
    CHECK(error * mpq_class(0x1p104) <= square);
}

// Checks the vertex of three planes, rounded and in two doubles, where it has a relative error.
void check_position(const Point& p, const Plane& a, const Plane& b, const Plane& c, const test::RationalVector& x) {
    const auto position = votess::exact::vertex_position<double>(p, a, b, c);
    const auto quad = votess::exact::vertex_position<votess::exact::Quad>(p, a, b, c);
    double largest = 0;
    for (const mpq_class& coordinate : x) largest = std::max(largest, std::abs(coordinate.get_d()));
    if (largest > 1e-290 && largest < 1e290) check_near(votess::exact::near_vertex(p, a, b, c), x);
    for (int k = 0; k < 3; ++k) {
        const double truth = x[k].get_d();
        if (x[k] == 0) CHECK(position[k] == 0);
        if (!(std::abs(truth) > 1e-290 && std::abs(truth) < 1e290)) continue;
        CHECK(std::abs(position[k] - truth) <= 0x1p-49 * std::abs(truth));
        const auto high = static_cast<double>(quad[k]);
        CHECK(std::abs(high - truth) <= 0x1p-51 * std::abs(truth));
        const mpq_class error =
            abs(mpq_class(high) + mpq_class(static_cast<double>(quad[k] - high)) - x[k]) / abs(x[k]);
        CHECK(error.get_d() <= 0x1p-100);
    }
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("exact: orientation of three normals equals rational arithmetic") {
        for (const Family& family : families) {
            Random random(20);
            int ties = 0;
            for (int s = 0; s < 1500; ++s) {
                auto coordinate = [&] { return family.coordinate(random); };
                const Point p{coordinate(), coordinate(), coordinate()};
                const Plane a = random_plane(random, coordinate), b = random_plane(random, coordinate),
                            c = random.chance(0.5) ? random_plane(random, coordinate) : between(p, a, b);
                const RationalPlane ra = rational(p, a), rb = rational(p, b), rc = rational(p, c);
                const int expected = sgn(test::determinant(ra.n, rb.n, rc.n));
                ties += expected == 0;
                INFO(family.name, " set ", s);
                REQUIRE(votess::exact::orientation(p, a, b, c) == expected);
                REQUIRE(votess::exact::orientation(p, c, b, a) == -expected);
            }
            INFO(family.name);
            CHECK(ties > 100);
        }
    }

    TEST_CASE("exact: one vertex against many planes equals rational arithmetic") {
        for (const Family& family : families) {
            Random random(21);
            int solved = 0, ties = 0;
            for (int s = 0; s < 200; ++s) {
                auto coordinate = [&] { return family.coordinate(random); };
                const Point p{coordinate(), coordinate(), coordinate()};
                const Plane a = random_plane(random, coordinate), b = random_plane(random, coordinate),
                            c = random_plane(random, coordinate);
                test::RationalVector x;
                if (!test::solve(rational(p, a), rational(p, b), rational(p, c), x)) continue;
                ++solved;
                check_position(p, a, b, c, x);
                std::vector<Plane> planes{a, b, c};
                for (int d = 0; d < 12; ++d) planes.push_back(random_plane(random, coordinate));
                for (const Plane& d : planes) {
                    const int expected = test::side_of(x, rational(p, d));
                    ties += expected == 0;
                    INFO(family.name, " set ", s);
                    REQUIRE(votess::exact::side_of_vertex(p, a, b, c, d) == expected);
                    REQUIRE(votess::exact::side_of_vertex(p, c, a, b, d) == expected);
                }
            }
            INFO(family.name);
            CHECK(solved > 50);
            CHECK(ties >= 3 * solved + (family.tied ? 10 : 0));
        }
    }

    // Weights that nearly follow a paraboloid lead the bisectors through one place, the seed.
    TEST_CASE("exact: planes that nearly meet in a place, in pairs of doubles and all digits") {
        for (const Family& family : families) {
            Random random(22);
            int solved = 0, tests = 0, by_pairs = 0;
            for (int s = 0; s < 200; ++s) {
                auto coordinate = [&] { return family.coordinate(random); };
                const Point p{coordinate(), coordinate(), coordinate()};
                const auto plane = [&] {
                    Plane through = random_plane(random, coordinate);
                    if (!through.is_bisector()) return through;
                    double square = 0;
                    for (int k = 0; k < 3; ++k) square += (through.seed[k] - p[k]) * (through.seed[k] - p[k]);
                    if (std::isfinite(square)) through.power = {-square, random.chance(0.5) ? 0 : 0x1p-54 * square};
                    return through;
                };
                const Plane a = plane(), b = plane(), c = plane();
                test::RationalVector x;
                if (!test::solve(rational(p, a), rational(p, b), rational(p, c), x)) continue;
                ++solved;
                for (int k = 0; k < 12; ++k) {
                    const Plane d = plane();
                    const int expected = test::side_of(x, rational(p, d)),
                              side = votess::exact::side_in_pairs(p, a, b, c, d);
                    INFO(family.name, " set ", s);
                    REQUIRE(votess::exact::side_of_vertex(p, a, b, c, d) == expected);
                    REQUIRE(votess::exact::side_of_vertex(p, c, a, b, d) == expected);
                    REQUIRE((side == 0 || side == expected));
                    ++tests;
                    by_pairs += side != 0;
                }
            }
            INFO(family.name);
            CHECK(solved > 50);
            if (family.name == std::string_view("uniform")) CHECK(by_pairs > 0.9 * tests);
        }
    }

    // The direction to the vertex decides, or where it lies along the plane, all numbers.
    TEST_CASE("exact: sides of vertices on far walls equal rational arithmetic") {
        Random random(31);
        int solved = 0, ties = 0;
        for (int s = 0; s < 3000; ++s) {
            const int kind = static_cast<int>(random.below(3)), axis = static_cast<int>(random.below(3));
            const auto coordinate = [&] { return kind == 0 ? small_integer(random) : random.uniform(); };
            const auto point = [&] {
                Point x{coordinate(), coordinate(), coordinate()};
                if (kind == 2) x[static_cast<std::size_t>(axis)] = 0.3 + 0x1p-52 * small_integer(random);
                return x;
            };
            const Point p = point();
            const double far = std::ldexp(1.0, static_cast<int>(random.below(400)));
            const double other = random.chance(0.8) ? far : std::ldexp(1.0, static_cast<int>(random.below(400)));
            const std::size_t walls = 1 + random.below(3), first = random.below(3);
            std::array<Plane, 3> planes;
            for (std::size_t i = 0; i < 3; ++i) {
                const int k = static_cast<int>((first + i) % 3);
                const double at = i == 0 ? far : other;
                planes[i] = i >= walls           ? Plane::bisector(point())
                            : random.chance(0.5) ? Plane::upper(k, at)
                                                 : Plane::lower(k, -at);
                if (i >= walls && random.chance(0.3)) planes[i].power = {coordinate(), 0};
            }
            test::RationalVector x;
            if (!test::solve(rational(p, planes[0]), rational(p, planes[1]), rational(p, planes[2]), x)) continue;
            ++solved;
            for (int d = 0; d < 6; ++d) {
                const Plane plane = Plane::bisector(point());
                const int expected = test::side_of(x, rational(p, plane));
                ties += expected == 0;
                INFO("set ", s);
                REQUIRE(votess::exact::side_of_vertex(p, planes[1], planes[2], planes[0], plane) == expected);
            }
        }
        CHECK(solved > 1000);
        CHECK(ties > 30);
    }

    TEST_CASE("exact: integers of any size add and multiply like GMP") {
        using votess::exact::BigInt;
        Random random(32);
        const auto big = [](const mpz_class& x) {  // digit by digit
            BigInt sum;
            for (const char digit : mpz_class(abs(x)).get_str(16))
                sum = sum * BigInt(16) + BigInt(digit <= '9' ? digit - '0' : digit - 'a' + 10);
            return sgn(x) < 0 ? -sum : sum;
        };
        const auto equal = [&](const BigInt& x, const mpz_class& y) {
            return x.sign() == sgn(y) && (x - big(y)).sign() == 0 && (big(y + 1) - x).sign() > 0;
        };
        for (int s = 0; s < 60; ++s) {
            BigInt product = 1, sum;
            mpz_class product_of_y = 1, sum_of_y;
            // Up to 3,000 bits: numbers on the heap too.
            for (std::size_t terms = random.below(60); terms > 0; --terms) {
                const std::int64_t term = random.integer(-(std::int64_t{1} << 50), std::int64_t{1} << 50);
                product = product * BigInt(term);
                product_of_y *= mpz_class(static_cast<long>(term));
                const bool adds = random.chance(0.5);
                sum = adds ? sum + product : sum - product;
                sum_of_y += adds ? product_of_y : mpz_class(-product_of_y);
            }
            REQUIRE(equal(product, product_of_y));
            REQUIRE(equal(sum, sum_of_y));
            REQUIRE(equal(product * sum, product_of_y * sum_of_y));
            REQUIRE(equal(sum + -sum, 0));
            BigInt moved = std::move(sum), copy = moved;
            sum = copy;
            REQUIRE(equal(sum - product, sum_of_y - product_of_y));
        }
    }

    // Up to 2^-50 from parallel, where the refinement ends after one, two or many steps, or is given up.
    TEST_CASE("exact: a vertex of nearly parallel planes is wrong by 2^-52 of its length at most") {
        Random random(22);
        for (int s = 0; s < 1000; ++s) {
            const double offset = random.chance(0.5) ? 0 : 1e3;
            const auto point = [&] {
                return Point{offset + random.uniform(), offset + random.uniform(), random.uniform()};
            };
            const Point p = point();
            Plane planes[3];
            for (Plane& plane : planes) plane = Plane::bisector(point());
            const int copies = 1 + static_cast<int>(random.below(2));
            for (int i = 1; i <= copies; ++i) {
                const double apart = std::ldexp(1.0, -static_cast<int>(random.below(51)));
                for (int k = 0; k < 3; ++k) planes[i].seed[k] = planes[0].seed[k] + apart * random.uniform(-1, 1);
            }
            if (random.chance(0.3)) planes[0].power = {random.uniform(-1, 1), 0x1p-60 * random.uniform(-1, 1)};
            test::RationalVector x;
            if (!test::solve(rational(p, planes[0]), rational(p, planes[1]), rational(p, planes[2]), x)) continue;
            INFO("set ", s);
            check_near(votess::exact::near_vertex(p, planes[0], planes[1], planes[2]), x);
        }
    }

    TEST_CASE("exact: wide integers multiply, shift and compare like GMP") {
        Random random(8);
        const auto value = [](const auto& w) {
            mpz_class z, modulus = 1;
            mpz_import(z.get_mpz_t(), w.limb.size(), -1, sizeof w.limb[0], 0, 0, w.limb.data());
            modulus <<= 64 * w.limb.size();
            return mpz_class(w.negative() ? z - modulus : z);
        };
        // Sparse limbs exercise carries and signs.
        const auto fill = [&](auto& w) {
            for (auto& l : w.limb) l = random.chance(0.3) ? (random.chance(0.5) ? 0 : ~0ull) : random.next();
        };
        for (int i = 0; i < 2000; ++i) {
            votess::exact::WideInt<3> a;
            votess::exact::WideInt<2> b;
            fill(a);
            fill(b);
            REQUIRE(value(a * b) == value(a) * value(b));
            REQUIRE(a.sign() == sgn(value(a)));
            const int shift = static_cast<int>(random.below(190));
            REQUIRE(value(shift_left(votess::exact::resize<6>(a), shift)) == value(a) << shift);
            REQUIRE(value(votess::exact::resize<6>(a) - votess::exact::resize<6>(b)) == value(a) - value(b));
            if (value(a) != 0) {
                const auto scaled = votess::exact::to_scaled(a);
                REQUIRE(std::abs(scaled.mantissa) >= 0.5);
                REQUIRE(std::abs(std::ldexp(scaled.mantissa, scaled.exponent) / value(a).get_d() - 1) < 0x1p-50);
            }
            // Wider ones, of which some hold a shorter number.
            votess::exact::WideInt<12> c;
            votess::exact::WideInt<9> d;
            fill(c);
            fill(d);
            if (random.chance(0.5)) c = shift_left(votess::exact::resize<12>(a), static_cast<int>(random.below(500)));
            if (random.chance(0.5)) d = shift_left(votess::exact::resize<9>(b), static_cast<int>(random.below(400)));
            REQUIRE(value(c * d) == value(c) * value(d));
        }
    }

    TEST_CASE("exact: wide floating point divides to 2,300 bits") {
        Random random(9);
        for (int i = 0; i < 200; ++i) {
            using votess::exact::WideFloat;
            WideFloat b = random.uniform(0.5, 1);
            for (int k = 1; k < 40; ++k) b += ldexp(WideFloat(random.uniform(-1, 1)), -53 * k);
            if (random.chance(0.5)) b = -b;
            const WideFloat a = random.uniform(-1, 1), error = a / b * b - a;
            REQUIRE(std::abs(static_cast<double>(ldexp(error, 2300))) < 1);
        }
    }

    TEST_CASE("exact: quad keeps its bounds, also where leading bits cancel, and compares exactly") {
        using votess::exact::Quad;
        Random random(10);
        const auto value = [](Quad x, int exponent) -> mpq_class {  // x * 2^exponent, from three doubles
            mpq_class sum;
            x = ldexp(x, exponent);
            for (int k = 0; k < 3; ++k) {
                const auto part = static_cast<double>(x);
                sum += mpq_class(part), x = x - part;
            }
            REQUIRE(x == 0);
            return sum;
        };
        const auto draw = [&] {
            Quad x = random.uniform(-1, 1);
            for (int k = 1; k < 3; ++k) x += ldexp(Quad(random.uniform(-1, 1)), -53 * k);
            return x;
        };
        for (int i = 0; i < 20000; ++i) {
            const Quad a = draw();
            Quad b = draw();
            if (random.chance(0.5)) b = a + ldexp(b, -static_cast<int>(random.below(140)));
            if (random.chance(0.5)) b = ldexp(-b, static_cast<int>(random.below(5)) - 2);
            if (b == 0) continue;
            const mpq_class x = value(a, 0), y = value(b, 0), sum = x + y, product = x * y, quotient = x / y;
            REQUIRE(abs(value(a + b, 0) - sum) * mpq_class(0x1p126) <= abs(sum));
            REQUIRE(abs(value(a * b, 0) - product) * mpq_class(0x1p124) <= abs(product));
            REQUIRE(abs(value(a / b, 0) - quotient) * mpq_class(0x1p122) <= abs(quotient));
            REQUIRE(abs(mpq_class(ratio(a, b)) - quotient) * mpq_class(0x1p51) <= abs(quotient));
            REQUIRE((a < b) == (x < y));
            REQUIRE((a == b) == (x == y));
            // Far beyond the exponents of double.
            REQUIRE(value(ldexp(a, 9000) * ldexp(b, -19000), 10000) == value(a * b, 0));
        }
        for (const double x : {0.0, 1.0, -3.0, 0x1p-1074, 0x1.fffffffffffffp1023, -0x1.8p-1030})
            REQUIRE(static_cast<double>(Quad(x)) == x);
        REQUIRE(static_cast<double>(Quad(1) + 0x1p-53) == 1);  // ties to even
        REQUIRE(static_cast<double>(Quad(1) + 0x1p-53 + 0x1p-110) == 1 + 0x1p-52);
        REQUIRE(static_cast<double>(ldexp(Quad(1), 2000)) == HUGE_VAL);
    }

    TEST_CASE("exact: double-double sum and product keep 100 bits") {
        Random random(9);
        auto value = [](const DoubleDouble& d) -> mpq_class { return mpq_class(d.high) + mpq_class(d.low); };
        for (int i = 0; i < 2000; ++i) {
            const DoubleDouble a = votess::exact::two_sum(random.uniform(-1, 1), random.uniform(-1, 1) * 0x1p-54);
            const DoubleDouble b = votess::exact::two_sum(random.uniform(-1, 1), random.uniform(-1, 1) * 0x1p-54);
            const mpq_class product = value(a) * value(b), sum = value(a) + value(b);
            REQUIRE(abs(value(a * b) - product) <= abs(product) * mpq_class(0x1p-103));
            REQUIRE(abs(value(a + b) - sum) <= abs(sum) * mpq_class(0x1p-104));
            const mpq_class exact = mpq_class(a.high) * mpq_class(b.high);
            REQUIRE(value(votess::exact::two_product(a.high, b.high)) == exact);
        }
    }
}
