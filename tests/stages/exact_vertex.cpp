// Orientations, and vertices tested against many planes, against rational arithmetic.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "exact/vertex.hpp"
#include "support/random.hpp"
#include "support/rational_planes.hpp"

using test::Random;
using test::random_plane;
using test::rational;
using test::RationalPlane;
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
                mpq_class x[3];
                if (!test::solve(rational(p, a), rational(p, b), rational(p, c), x)) continue;
                ++solved;
                votess::exact::ExactVertex vertex(p, a, b, c);
                std::vector<Plane> planes{a, b, c};
                for (int d = 0; d < 12; ++d) planes.push_back(random_plane(random, coordinate));
                for (const Plane& d : planes) {
                    const int expected = test::side_of(x, rational(p, d));
                    ties += expected == 0;
                    INFO(family.name, " set ", s);
                    REQUIRE(vertex.side(d) == expected);
                    REQUIRE(votess::exact::side_of_vertex(p, c, a, b, d) == expected);
                }
            }
            INFO(family.name);
            CHECK(solved > 50);
            CHECK(ties >= 3 * solved + (family.tied ? 10 : 0));
        }
    }
}
