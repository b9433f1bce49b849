// The exact tier against rational arithmetic.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <cmath>

#include "exact/double_double.hpp"
#include "exact/integer/wide_int.hpp"
#include "exact/predicate.hpp"
#include "support/random.hpp"
#include "support/rational_planes.hpp"

using test::Random;
using test::random_plane;
using test::rational;
using votess::exact::DoubleDouble;
using votess::exact::Plane;
using votess::exact::Point;

namespace {

void check_family(const char* name, std::uint64_t seed, int sets, int min_ties, auto make_coordinate) {
    Random random(seed);
    int solved = 0, ties = 0;
    for (int s = 0; s < sets; ++s) {
        auto coordinate = [&] { return make_coordinate(random); };
        const Point p{coordinate(), coordinate(), coordinate()};
        const Plane a = random_plane(random, coordinate), b = random_plane(random, coordinate),
                    c = random_plane(random, coordinate), d = random_plane(random, coordinate);
        mpq_class x[3];
        if (!test::solve(rational(p, a), rational(p, b), rational(p, c), x)) continue;
        ++solved;
        const int expected = test::side_of(x, rational(p, d));
        ties += expected == 0;
        INFO(name, " set ", s);
        REQUIRE(votess::exact::side_of_vertex(p, a, b, c, d) == expected);
        const auto position = votess::exact::vertex_position<double>(p, a, b, c);
        const auto quad = votess::exact::vertex_position<votess::exact::Quad>(p, a, b, c);
        for (int k = 0; k < 3; ++k) {
            // Subnormal and overflowing positions cannot keep a relative error.
            const double truth = x[k].get_d();
            if (std::abs(truth) > 1e-290 && std::abs(truth) < 1e290) {
                CHECK(std::abs(position[k] - truth) <= 0x1p-49 * std::abs(truth));
                CHECK(std::abs(static_cast<double>(quad[k]) - truth) <= 0x1p-51 * std::abs(truth));
                const auto high = static_cast<double>(quad[k]);
                const mpq_class error =
                    abs(mpq_class(high) + mpq_class(static_cast<double>(quad[k] - high)) - x[k]) / abs(x[k]);
                CHECK(error.get_d() <= 0x1p-100);
            } else if (truth == 0) {
                CHECK(position[k] == 0);
            }
        }
    }
    CHECK(solved > sets / 4);
    CHECK(ties >= min_ties);
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("exact: side and position of vertices equal rational arithmetic in every width") {
        check_family("small integers", 1, 4000, 60, [](Random& r) { return static_cast<double>(r.integer(-3, 3)); });
        check_family("offset integers", 2, 1000, 10,
                     [](Random& r) { return 1e8 + static_cast<double>(r.integer(-2, 2)); });
        check_family("integers of 30 bits", 3, 1000, 0,
                     [](Random& r) { return static_cast<double>(r.integer(-(1 << 30), 1 << 30)); });
        check_family("uniform", 4, 2000, 0, [](Random& r) { return r.uniform(); });
        check_family("tenths", 5, 4000, 0, [](Random& r) { return 0.1 * static_cast<double>(r.integer(-2, 2)); });
        check_family("twenty decades", 6, 2000, 0,
                     [](Random& r) { return r.uniform(-1, 1) * std::pow(10.0, r.uniform(-20, 0)); });
        check_family("all of float64", 7, 600, 0, [](Random& r) {
            return r.uniform(-1, 1) * std::ldexp(1.0, static_cast<int>(r.integer(-1074, 1000)));
        });
    }

    TEST_CASE("exact: wide integers multiply, shift and compare like GMP") {
        Random random(8);
        for (int i = 0; i < 2000; ++i) {
            votess::exact::WideInt<3> a;
            votess::exact::WideInt<2> b;
            // Sparse limbs exercise carries and signs.
            for (auto& l : a.limb) l = random.chance(0.3) ? (random.chance(0.5) ? 0 : ~0ull) : random.next();
            for (auto& l : b.limb) l = random.chance(0.3) ? (random.chance(0.5) ? 0 : ~0ull) : random.next();
            auto value = [](const auto& w) {
                mpz_class z = static_cast<long>(static_cast<std::int64_t>(w.limb.back()));
                for (std::size_t k = w.limb.size() - 1; k-- > 0;)
                    z = (z << 64) + mpz_class(static_cast<unsigned long>(w.limb[k]));
                return z;
            };
            REQUIRE(value(a * b) == value(a) * value(b));
            REQUIRE(a.sign() == sgn(value(a)));
            const int shift = static_cast<int>(random.below(190));
            REQUIRE(value(shift_left(votess::exact::resize<6>(a), shift)) == value(a) << shift);
            REQUIRE(value(votess::exact::resize<6>(a) - votess::exact::resize<6>(b)) == value(a) - value(b));
            if (value(a) != 0) {
                const auto scaled = votess::exact::to_scaled<double>(a);
                REQUIRE(std::abs(scaled.mantissa) >= 0.5);
                REQUIRE(std::abs(std::ldexp(scaled.mantissa, scaled.exponent) / value(a).get_d() - 1) < 0x1p-50);
            }
        }
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
