// The polygon of planes at a vertex where many meet, against the convex hull by its definition in rational arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "exact/corner.hpp"
#include "exact/integer/word_cross.hpp"
#include "exact/tied_seeds.hpp"
#include "support/random.hpp"
#include "support/rational_planes.hpp"

using test::Random;
using test::rational;
using test::RationalPlane;
using votess::exact::Plane;
using votess::exact::Point;
using votess::exact::TiedSeeds;
using votess::exact::WordCross;
using votess::exact::WordVector;

namespace {

std::vector<int> polygon(const Point& p, const std::vector<Plane>& planes) {
    std::vector<const Plane*> pointers;
    for (const Plane& plane : planes) pointers.push_back(&plane);
    std::vector<int> out(planes.size(), -1);
    const auto written = votess::exact::corner_polygon(p, pointers, out);
    return {written.begin(), written.end()};
}

// Beginning with its smallest index.
std::vector<int> rotated(std::vector<int> ring) {
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    return ring;
}

std::vector<RationalPlane> rationals(const Point& p, const std::vector<Plane>& planes) {
    std::vector<RationalPlane> r;
    for (const Plane& plane : planes) r.push_back(rational(p, plane));
    return r;
}

// What singles the answer out: every side has all normals on its left or on it, and every corner turns.
void check_convex(const std::vector<int>& ring, const std::vector<RationalPlane>& n) {
    REQUIRE(ring.size() >= 3);
    std::vector<int> distinct = ring;
    std::sort(distinct.begin(), distinct.end());
    REQUIRE(std::adjacent_find(distinct.begin(), distinct.end()) == distinct.end());
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const auto &a = n[ring[i]], &b = n[ring[(i + 1) % ring.size()]], &c = n[ring[(i + 2) % ring.size()]];
        REQUIRE(sgn(test::determinant(a.n, b.n, c.n)) > 0);
        for (const auto& other : n) REQUIRE(sgn(test::determinant(a.n, b.n, other.n)) >= 0);
    }
}

struct Counts {
    int hulls = 0, flat = 0, inside = 0, on_edge = 0;
};

// The hull by definition, in the plane of the dual points N / (N.w) with one coordinate left out: i and j are ends of
// a side when every other point is strictly left of it or on the open segment. Of equal points the first counts.
std::vector<int> hull_by_definition(const std::vector<RationalPlane>& planes, const test::RationalVector& w,
                                    Counts& counts) {
    struct Dual {
        mpq_class x, y;
        bool operator==(const Dual& o) const { return x == o.x && y == o.y; }
    };
    int dropped = 0;
    while (w[dropped] == 0) ++dropped;
    const int first = (dropped + 1) % 3, second = (dropped + 2) % 3;
    std::vector<Dual> dual;
    for (const auto& plane : planes) {
        const mpq_class height = plane.n[0] * w[0] + plane.n[1] * w[1] + plane.n[2] * w[2];
        REQUIRE(sgn(height) > 0);
        dual.push_back({plane.n[first] / height, plane.n[second] / height});
    }
    std::vector<int> kept;
    for (std::size_t i = 0; i < dual.size(); ++i)
        if (std::find(dual.begin(), dual.begin() + static_cast<std::ptrdiff_t>(i), dual[i]) ==
            dual.begin() + static_cast<std::ptrdiff_t>(i))
            kept.push_back(static_cast<int>(i));
    auto turn = [&](int i, int j, int k) {
        const Dual &a = dual[i], &b = dual[j], &c = dual[k];
        return sgn(mpq_class((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)));
    };
    auto between = [&](int i, int j, int k) {  // k on the line of i, j
        const Dual &a = dual[i], &b = dual[j], &c = dual[k];
        return sgn(mpq_class((c.x - a.x) * (c.x - b.x) + (c.y - a.y) * (c.y - b.y))) < 0;
    };
    std::vector<int> next(planes.size(), -1);
    std::vector<bool> in_middle(planes.size(), false);
    bool flat = true;
    for (int i : kept)
        for (int j : kept) {
            if (i == j) continue;
            const bool side = std::all_of(kept.begin(), kept.end(), [&](int k) {
                if (k == i || k == j) return true;
                const int t = turn(i, j, k);
                flat = flat && t == 0;
                return t > 0 || (t == 0 && between(i, j, k));
            });
            if (!side) continue;
            next[i] = j;
            for (int k : kept)
                if (k != i && k != j && turn(i, j, k) == 0) in_middle[k] = true;
        }
    ++counts.hulls;
    if (flat) {
        ++counts.flat;
        return {};
    }
    std::vector<int> ring;
    for (int i = static_cast<int>(std::find_if(next.begin(), next.end(), [](int j) { return j >= 0; }) - next.begin());
         ring.empty() || i != ring.front(); i = next[i])
        ring.push_back(i);
    const auto middles = static_cast<int>(std::count(in_middle.begin(), in_middle.end(), true));
    counts.on_edge += middles;
    counts.inside += static_cast<int>(kept.size() - ring.size()) - middles;
    // Leaving out coordinate k keeps the sense of turning, as seen from outside, when w_k > 0.
    if (sgn(w[dropped]) < 0) std::reverse(ring.begin(), ring.end());
    return ring;
}

// Planes through c of a cell of p, all in integers: seeds as far from c as p, and walls.
struct Corner {
    Point p, c;
    std::vector<Plane> planes;
};

Corner random_corner(Random& random, std::size_t most) {
    Corner corner;
    for (int k = 0; k < 3; ++k) {
        corner.p[k] = static_cast<double>(random.integer(-2, 2));
        corner.c[k] = corner.p[k] + 0.5 * static_cast<double>(random.integer(-4, 4));
    }
    auto distance = [&](const Point& q) {
        double d = 0;
        for (int k = 0; k < 3; ++k) d += (q[k] - corner.c[k]) * (q[k] - corner.c[k]);
        return d;
    };
    const double radius = distance(corner.p);
    for (int x = -7; x <= 7; ++x)
        for (int y = -7; y <= 7; ++y)
            for (int z = -7; z <= 7; ++z) {
                const Point q{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
                if (q != corner.p && distance(q) == radius) corner.planes.push_back(Plane::bisector(q));
            }
    for (int k = 0; k < 3; ++k) {
        if (!random.chance(0.2)) continue;
        const bool upper = corner.c[k] > corner.p[k] || (corner.c[k] == corner.p[k] && random.chance(0.5));
        corner.planes.push_back(upper ? Plane::upper(k, corner.c[k]) : Plane::lower(k, corner.c[k]));
    }
    if (!corner.planes.empty() && random.chance(0.1))
        corner.planes.push_back(corner.planes[random.below(corner.planes.size())]);
    std::vector<Plane> shuffled;
    for (std::size_t i : test::permutation(corner.planes.size(), random))
        if (shuffled.size() < most) shuffled.push_back(corner.planes[i]);
    corner.planes = shuffled;
    return corner;
}

// The same corner, moved and scaled; the caller sees to it that nothing rounds.
template <class Map>
Corner mapped(Corner corner, Map map) {
    for (double& x : corner.p) x = map(x);
    for (Plane& plane : corner.planes) {
        for (double& x : plane.seed) x = map(x);
        plane.wall = map(plane.wall);
    }
    return corner;
}

// Seeds on a sphere. The second and third are neighbors of the first along one facet, and the first four span space.
// Fewer than five if there are no such seeds.
std::vector<Point> seeds_of(const Corner& corner) {
    std::vector<Plane> planes;
    for (const Plane& plane : corner.planes)
        if (plane.kind == Plane::Kind::bisector &&
            std::ranges::none_of(planes, [&](const Plane& other) { return other.seed == plane.seed; }))
            planes.push_back(plane);
    const auto ring = polygon(corner.p, planes);
    if (ring.empty() || planes.size() < 4) return {};
    std::vector<Point> seeds{corner.p, planes[ring[1]].seed, planes[ring[0]].seed, planes[ring[2]].seed};
    for (int k = 0; k < static_cast<int>(planes.size()); ++k)
        if (k != ring[0] && k != ring[1] && k != ring[2]) seeds.push_back(planes[k].seed);
    return seeds;
}

votess::exact::Differences vector_to(const Point& q, const Point& p) {
    return votess::exact::differences(p, Plane::bisector(q));
}

bool begin(TiedSeeds& tied, const std::vector<Point>& seeds) {
    return tied.begin(vector_to(seeds[1], seeds[0]), vector_to(seeds[2], seeds[0]), vector_to(seeds[3], seeds[0]));
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("exact: the polygon at a vertex of many planes is the hull of their duals") {
        Random random(30);
        Counts counts;
        for (int s = 0; s < 2500; ++s) {
            const Corner corner = random_corner(random, 3 + random.below(9));
            if (corner.planes.size() < 3) {
                CHECK(polygon(corner.p, corner.planes).empty());
                continue;
            }
            // The inside of all planes seen from c: towards p, and away from walls through p.
            test::RationalVector w;
            for (int k = 0; k < 3; ++k) w[k] = corner.c[k] - corner.p[k];
            for (const Plane& plane : corner.planes) {
                if (plane.kind == Plane::Kind::bisector || plane.wall != corner.p[plane.axis]) continue;
                w[plane.axis] = (plane.kind == Plane::Kind::upper_wall ? 1 : -1) * mpq_class(1, 1000);
            }
            INFO("set ", s);
            const auto n = rationals(corner.p, corner.planes);
            const auto expected = hull_by_definition(n, w, counts);
            const auto ring = polygon(corner.p, corner.planes);
            REQUIRE(ring.size() == expected.size());
            if (ring.empty()) continue;
            REQUIRE(rotated(ring) == rotated(expected));
            check_convex(ring, n);

            const double scale = std::ldexp(1.0, static_cast<int>(random.integer(-320, 320)));
            const double odd = std::floor(std::ldexp(1.0, static_cast<int>(random.below(48)))) + 1;
            CHECK(polygon(mapped(corner, [=](double x) { return scale * x; }).p,
                          mapped(corner, [=](double x) { return scale * x; }).planes) == ring);
            for (const Corner& other :
                 {mapped(corner, [](double x) { return x + 1e8; }), mapped(corner, [=](double x) { return odd * x; }),
                  mapped(corner, [](double x) { return 0x1p-1070 * x; }),
                  mapped(corner, [](double x) { return 0x1p1018 * x; })})
                REQUIRE(polygon(other.p, other.planes) == ring);
            // Only directions of normals count, so each may have a length of its own: this needs wide integers.
            for (const int reach : {10, 35, 55, 300}) {
                Corner other = mapped(corner, [](double x) { return x; });
                for (Plane& plane : other.planes) {
                    if (plane.kind != Plane::Kind::bisector) continue;
                    const double length = std::ldexp(1.0, static_cast<int>(random.integer(-reach, reach)));
                    for (int k = 0; k < 3; ++k) plane.seed[k] = length * (plane.seed[k] - corner.p[k]);
                }
                other.p = {};
                REQUIRE(polygon(other.p, other.planes) == ring);
            }
        }
        CHECK(counts.hulls > 1500);
        CHECK(counts.flat > 50);
        CHECK(counts.inside > 500);
        CHECK(counts.on_edge > 500);
    }

    TEST_CASE("exact: the polygon of rounded coordinates is convex in rational arithmetic") {
        Random random(31);
        for (int s = 0; s < 300; ++s) {
            // Normals near those of a lattice's corner: nearly all turns are nearly straight.
            const Corner corner = mapped(random_corner(random, 20), [](double x) { return 0.1 * x; });
            const auto ring = polygon(corner.p, corner.planes);
            INFO("set ", s);
            if (!ring.empty()) check_convex(ring, rationals(corner.p, corner.planes));
        }
    }

    TEST_CASE("exact: the polygon of more planes than the fixed room holds") {
        // 95 bisectors meet at the center of a sphere of squared radius 41.
        const Point p{-6, -2, -1};
        std::vector<Plane> planes;
        for (int x = -6; x <= 6; ++x)
            for (int y = -6; y <= 6; ++y)
                for (int z = -6; z <= 6; ++z)
                    if (x * x + y * y + z * z == 41 && !(x == -6 && y == -2 && z == -1))
                        planes.push_back(
                            Plane::bisector({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}));
        REQUIRE(planes.size() == 95);
        const auto ring = polygon(p, planes);
        check_convex(ring, rationals(p, planes));
        for (Plane& plane : planes)
            for (int k = 0; k < 3; ++k) plane.seed[k] = p[k] + 0x1.000002p-40 * (plane.seed[k] - p[k]);
        CHECK(polygon(p, planes) == ring);
    }

    TEST_CASE("exact: corners of lattices and of the box") {
        // Cubic: of seven planes the three axis neighbors' have faces.
        const Point p{4, 7, 1};
        std::vector<Plane> planes;
        for (int i = 1; i < 8; ++i)
            planes.push_back(Plane::bisector({p[0] + (i & 1), p[1] + (i >> 1 & 1), p[2] + (i >> 2 & 1)}));
        CHECK(rotated(polygon(p, planes)) == std::vector<int>{0, 1, 3});
        // With walls half a step away only these are left beside what they cut off nothing from.
        for (int k = 0; k < 3; ++k) planes.push_back(Plane::upper(k, p[k] + 0.5));
        CHECK(polygon(p, planes).size() == 3);
        // FCC, around an octahedral hole: the seed across touches the vertex only.
        planes.clear();
        for (const Point& n : {Point{2, 0, 0}, {1, 1, 0}, {1, -1, 0}, {1, 0, 1}, {1, 0, -1}})
            planes.push_back(Plane::bisector({p[0] + n[0], p[1] + n[1], p[2] + n[2]}));
        CHECK(rotated(polygon(p, planes)) == std::vector<int>{1, 3, 2, 4});
        // A corner of the box with the seed in it.
        planes = {Plane::lower(0, p[0]), Plane::lower(2, p[2]), Plane::upper(1, p[1])};
        const auto ring = polygon(p, planes);
        check_convex(ring, rationals(p, planes));
        planes.pop_back();
        CHECK(polygon(p, planes).empty());
    }

    TEST_CASE("exact: the hull of tied seeds has the polygons of all of their cells") {
        Random random(33);
        TiedSeeds tied;
        int hulls = 0, boxes = 0, large = 0, far_apart = 0;
        for (int s = 0; s < 2500; ++s) {
            const Corner corner = random_corner(random, random.chance(0.3) ? 100 : 4 + random.below(9));
            const double odd = std::floor(std::ldexp(1.0, static_cast<int>(random.below(48)))) + 1;
            const double scale = std::ldexp(1.0, static_cast<int>(random.integer(-320, 320)));
            for (const Corner& moved : {corner, mapped(corner, [=](double x) { return odd * x; }),
                                        mapped(corner, [=](double x) { return scale * x; }),
                                        mapped(corner, [](double x) { return x + 1e8; })}) {
                const auto seeds = seeds_of(moved);
                if (seeds.size() < 5 || seeds.size() > TiedSeeds::max_seeds) continue;
                INFO("set ", s);
                REQUIRE(begin(tied, seeds));
                for (std::size_t k = 4; k < seeds.size() && tied.usable(); ++k) {
                    const auto side = tied.side(vector_to(seeds[k], seeds[0]));
                    if (side) REQUIRE(*side == 0);
                }
                if (!tied.usable()) {  // the first three are far nearer than the last
                    ++far_apart;
                    continue;
                }
                REQUIRE(tied.wrap());
                ++hulls;
                boxes += seeds.size() == 8 ? 1 : 0;
                large += seeds.size() > 12 ? 1 : 0;
                for (std::size_t k = 0; k < seeds.size(); ++k) {
                    std::vector<Plane> others;
                    for (std::size_t j = 0; j < seeds.size(); ++j)
                        if (j != k) others.push_back(Plane::bisector(seeds[j]));
                    std::vector<int> expected = polygon(seeds[k], others);
                    for (int& other : expected) other += other >= static_cast<int>(k) ? 1 : 0;
                    const auto around = tied.around(k);
                    REQUIRE(rotated({around.begin(), around.end()}) == rotated(expected));
                }
            }
        }
        CHECK(hulls > 3000);
        CHECK(boxes > 300);
        CHECK(large > 300);
        CHECK(far_apart < 100);
    }

    TEST_CASE("exact: the side of a seed among tied seeds, near the sphere and on it") {
        Random random(34);
        TiedSeeds tied;
        int sides[3] = {};
        for (int s = 0; s < 1500; ++s) {
            const double step = random.chance(0.5) ? 0.1 : 1;
            const double offset = random.chance(0.3) ? 1e5 : 0;
            const auto seeds = seeds_of(mapped(random_corner(random, 12), [=](double x) { return offset + step * x; }));
            if (seeds.size() < 5) continue;
            INFO("set ", s);
            REQUIRE(begin(tied, seeds));
            const auto plane = [&](const Point& q) { return Plane::bisector(q); };
            test::RationalVector vertex;
            REQUIRE(test::solve(rational(seeds[0], plane(seeds[1])), rational(seeds[0], plane(seeds[2])),
                                rational(seeds[0], plane(seeds[3])), vertex));
            for (std::size_t k = 4; k < seeds.size(); ++k) {
                Point q = seeds[k];
                if (random.chance(0.3)) q[random.below(3)] *= 1 + std::ldexp(random.integer(-1, 1), -52);
                if (random.chance(0.1)) q[random.below(3)] += 0.5 * step;
                const auto side = tied.side(vector_to(q, seeds[0]));
                if (!side) break;
                REQUIRE(*side == test::side_of(vertex, rational(seeds[0], plane(q))));
                ++sides[*side + 1];
            }
        }
        for (const int count : sides) CHECK(count > 500);
    }

    TEST_CASE("exact: tied seeds refuse what 60 bits cannot hold") {
        TiedSeeds tied;
        const std::vector<Point> cube{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
        const auto scaled = [&](double scale, double x) {
            std::vector<Point> seeds = cube;
            for (Point& q : seeds)
                for (double& y : q) y *= scale;
            seeds[3][0] = x;
            return seeds;
        };
        CHECK(begin(tied, scaled(1, 0x1p-56)));
        CHECK(tied.side({{{{1, 0}, {1, 0}, {0, 0}}}, true}) == 0);
        CHECK(tied.side({{{{1, 0}, {0, 0x1p-56}, {0, 0}}}, true}).has_value());
        CHECK_FALSE(tied.side({{{{16, 0}, {0, 0}, {0, 0}}}, true}));
        CHECK_FALSE(tied.usable());
        CHECK_FALSE(begin(tied, scaled(1, 0x1p-57)));
        CHECK_FALSE(begin(tied, scaled(1, 0x1p-1070)));
        CHECK_FALSE(begin(tied, scaled(0x1p-1000, 0)));
        CHECK_FALSE(begin(tied, scaled(0x1p1000, 0)));
        CHECK_FALSE(tied.begin({{{{1, 0}, {0, 0}, {0, 0}}}, false}, {{{{0, 0}, {1, 0}, {0, 0}}}, true},
                               {{{{0, 0}, {0, 0}, {1, 0}}}, true}));
    }

    TEST_CASE("exact: turns of integer vectors") {
        Random random(35);
        int turns[3] = {}, zero = 0;
        for (int s = 0; s < 20000; ++s) {
            const auto most = std::int64_t{1} << random.integer(1, 61);
            const auto vector = [&] {
                WordVector v;
                for (std::int64_t& x : v) x = random.chance(0.2) ? 0 : random.integer(-most, most);
                return v;
            };
            const WordVector a = vector();
            WordVector b = vector(), c = vector();
            if (random.chance(0.2))
                for (int k = 0; k < 3; ++k) b[k] = a[k] / 3 * 2;
            if (random.chance(0.5))  // nearly in their plane
                for (int k = 0; k < 3; ++k)
                    c[k] = a[k] / 2 + b[k] / 4 + (random.chance(0.2) ? random.integer(-1, 1) : 0);
            const auto exact = [](const WordVector& v, test::RationalVector& out) {
                for (int k = 0; k < 3; ++k) out[k] = mpq_class(std::to_string(v[k]));
            };
            test::RationalVector u, v, w;
            exact(a, u), exact(b, v), exact(c, w);
            const WordCross cross(a, b);
            const int turn = cross.turn(c);
            REQUIRE(turn == sgn(test::determinant(u, v, w)));
            const bool parallel =
                u[0] * v[1] == u[1] * v[0] && u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2];
            REQUIRE(cross.is_zero() == parallel);
            ++turns[turn + 1];
            zero += parallel ? 1 : 0;
        }
        for (const int count : turns) CHECK(count > 2000);
        CHECK(zero > 100);
    }
}
