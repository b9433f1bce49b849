// delaunay: predicates and triangulations against rational arithmetic; the cells that come from them.
#include "triangulate/delaunay.hpp"

#include <doctest/doctest.h>
#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/progress.hpp"
#include "cpu/cell_builder.hpp"
#include "cpu/cpu_clipper.hpp"
#include "exact/insphere.hpp"
#include "index/seed_images.hpp"
#include "input/settle.hpp"
#include "polytope/cell.hpp"
#include "query/parts.hpp"
#include "support/cell_faces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"
#include "support/vectors.hpp"
#include "triangulate/power_sites.hpp"
#include "triangulate/triangulation.hpp"

using namespace votess::cpu;
using test::Random;
using votess::exact::Point;

namespace {

using test::determinant;
using test::minus;
using Rational = test::RationalVector;

Rational rational_point(const Point& p) {
    return test::rational(p.data());
}

mpq_class square(const Rational& a) {
    return test::dot(a, a);
}

// The circumsphere by its center, unlike the engine's lifting. With weights, of equal powers instead of distances.
struct Sphere {
    Rational base, center;  // center relative to base, a point on the sphere
    mpq_class weight;       // of base

    Sphere(const Rational& a, const Rational& b, const Rational& c, const Rational& d,
           const std::array<mpq_class, 4>& weights = {})
        : base(a), weight(weights[0]) {
        const Rational u = minus(b, a), v = minus(c, a), w = minus(d, a);
        const Rational h{(square(u) - weights[1] + weight) / 2, (square(v) - weights[2] + weight) / 2,
                         (square(w) - weights[3] + weight) / 2};
        const mpq_class det = determinant(u, v, w);
        for (int k = 0; k < 3; ++k) {
            Rational m[3] = {u, v, w};
            for (int row = 0; row < 3; ++row) m[row][k] = h[row];
            center[k] = determinant(m[0], m[1], m[2]) / det;
        }
    }
    // +1 when p lies strictly inside.
    [[nodiscard]] int side(const Rational& p, const mpq_class& of_p = {}) const {
        return sgn(mpq_class(square(center) - weight - square(minus(minus(p, base), center)) + of_p));
    }
};

// Weighted points with rational predicates.
class WeightedSites final : public Sites {
public:
    WeightedSites(const std::vector<Point>& points, const std::vector<double>& weights) {
        for (const Point& p : points) x_.push_back(rational_point(p));
        for (const double w : weights) weights_.emplace_back(w);
    }
    [[nodiscard]] int orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const override {
        return sgn(determinant(minus(x_[a], x_[d]), minus(x_[b], x_[d]), minus(x_[c], x_[d])));
    }
    [[nodiscard]] int insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                               std::int32_t p) const override {
        return Sphere(x_[a], x_[b], x_[c], x_[d], {weights_[a], weights_[b], weights_[c], weights_[d]})
            .side(x_[p], weights_[p]);
    }

private:
    std::vector<Rational> x_;
    std::vector<mpq_class> weights_;
};

void check_predicates(const char* name, std::uint64_t seed, int sets, int min_ties, auto coordinate) {
    Random random(seed);
    int solid = 0, ties = 0;
    for (int s = 0; s < sets; ++s) {
        Point p[5];
        Rational r[5];
        for (int i = 0; i < 5; ++i) {
            for (auto& x : p[i]) x = coordinate(random);
            r[i] = rational_point(p[i]);
        }
        INFO(name, " set ", s);
        const int oriented = sgn(determinant(minus(r[0], r[3]), minus(r[1], r[3]), minus(r[2], r[3])));
        REQUIRE(votess::exact::orient(p[0], p[1], p[2], p[3]) == oriented);
        ties += oriented == 0;
        if (oriented == 0) continue;
        const int side = Sphere(r[0], r[1], r[2], r[3]).side(r[4]);
        REQUIRE(votess::exact::insphere(p[0], p[1], p[2], p[3], p[4]) * oriented == side);
        ++solid;
        ties += side == 0;
    }
    CHECK(solid > sets / 4);
    CHECK(ties >= min_ties);
}

// Sites with weights and shifts, some of them nearly in ties: four are on a plane or a sphere up to rounding.
void check_power_sites(const char* name, std::uint64_t seed, int sets, const votess::exact::Lattice& lattice,
                       double max_shift, double weight_scale) {
    Random random(seed);
    int solid = 0;
    for (int s = 0; s < sets; ++s) {
        std::vector<PowerSites::Site> sites;
        std::vector<Rational> places;
        std::vector<mpq_class> weights;
        const double apart = std::pow(10.0, -static_cast<double>(random.below(12)));
        for (int i = 0; i < 5; ++i) {
            PowerSites::Site site{{}, {}, weight_scale * apart * random.uniform(-1, 1)};
            for (double& x : site.point) x = 0.3 + apart * random.uniform(-1, 1);
            if (s % 3 == 0) site.point[2] = 0.3 + 0x1p-40 * random.uniform();
            for (auto& shift : site.shift) shift = static_cast<std::int32_t>(max_shift * random.uniform(-1, 1));
            Rational place = rational_point(site.point);
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k)
                    place[k] += site.shift[j] * (mpq_class(lattice.vector[j][k].high) + lattice.vector[j][k].low);
            // The points of one set are near each other again.
            for (int j = 0; j < 3; ++j)
                if (s % 2 == 0) site.point[j] = mpq_class(2 * mpq_class(site.point[j]) - place[j]).get_d();
            place = rational_point(site.point);
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k)
                    place[k] += site.shift[j] * (mpq_class(lattice.vector[j][k].high) + lattice.vector[j][k].low);
            sites.push_back(site);
            places.push_back(place);
            weights.emplace_back(site.weight);
        }
        const PowerSites power(sites, &lattice);
        INFO(name, " set ", s);
        const int oriented =
            sgn(determinant(minus(places[0], places[3]), minus(places[1], places[3]), minus(places[2], places[3])));
        REQUIRE(power.orient(0, 1, 2, 3) == oriented);
        if (oriented == 0) continue;
        ++solid;
        const Sphere sphere(places[0], places[1], places[2], places[3],
                            {weights[0], weights[1], weights[2], weights[3]});
        const int side = sphere.side(places[4], weights[4]);
        const int found = oriented > 0 ? power.insphere(0, 1, 2, 3, 4) : power.insphere(1, 0, 2, 3, 4);
        if (side != 0) REQUIRE(found == side);
    }
    CHECK(solid > sets / 2);
}

SortedSeeds sorted_seeds(const test::PointSet& set, votess::ThreadPool& pool) {
    // As the pipeline does: largest coordinate of order one.
    double largest = 0;
    for (double x : set.points) largest = std::max(largest, std::abs(x));
    const double scale = largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1;
    SortedSeeds seeds;
    SeedSorter().sort(std::span<const double>(set.points), scale, 0, pool, seeds);
    return seeds;
}

std::vector<Point> points_of(const SortedSeeds& seeds) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < seeds.size(); ++i) points.push_back({seeds.x[i], seeds.y[i], seeds.z[i]});
    return points;
}

// Inserts all points; false when they are coplanar.
bool triangulate(const std::vector<Point>& points, Triangulation& triangulation) {
    const auto count = static_cast<std::int32_t>(points.size());
    for (std::int32_t b = 1; b < count; ++b)
        for (std::int32_t c = b + 1; c < count; ++c)
            for (std::int32_t d = c + 1; d < count; ++d) {
                if (votess::exact::orient(points[0], points[b], points[c], points[d]) == 0) continue;
                triangulation.begin(0, b, c, d);
                for (std::int32_t p = 1; p < count; ++p)
                    if (p != b && p != c && p != d) triangulation.insert(p);
                return true;
            }
    return false;
}

// By definition: tetrahedra positive, their circumspheres empty, the hull triangles with no point beyond, together
// exactly the hull's volume; neighbors mutual. Returns how many points are hidden, none without weights.
std::size_t check_triangulation(const std::vector<Point>& points, std::span<const Tetrahedron> cells,
                                const std::vector<double>& weights = {}) {
    std::vector<Rational> r;
    for (const Point& p : points) r.push_back(rational_point(p));
    std::set<std::int32_t> met;
    mpq_class volume, hull;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const Tetrahedron& t = cells[i];
        if (t.vertex[0] == Triangulation::unused) continue;
        for (int k = 0; k < 4; ++k) {
            const Tetrahedron& n = cells[t.neighbor[k]];
            REQUIRE(std::ranges::count(n.neighbor, static_cast<std::int32_t>(i)) == 1);
            for (int j = 0; j < 4; ++j) REQUIRE(std::ranges::count(n.vertex, t.vertex[j]) == (j == k ? 0 : 1));
            met.insert(t.vertex[k]);
        }
        auto at = [&](int k) -> const Rational& { return r[t.vertex[k]]; };
        if (Triangulation::is_finite(t)) {
            const mpq_class d = determinant(minus(at(0), at(3)), minus(at(1), at(3)), minus(at(2), at(3)));
            REQUIRE(sgn(d) > 0);
            volume += d;
            const auto weight = [&](std::size_t i) { return mpq_class(weights.empty() ? 0 : weights[i]); };
            const auto weight_at = [&](int k) { return weight(static_cast<std::size_t>(t.vertex[k])); };
            const Sphere sphere(at(0), at(1), at(2), at(3), {weight_at(0), weight_at(1), weight_at(2), weight_at(3)});
            for (std::size_t p = 0; p < r.size(); ++p) REQUIRE(sphere.side(r[p], weight(p)) <= 0);
        } else {
            const auto slot = static_cast<int>(std::ranges::find(t.vertex, Triangulation::infinite) - t.vertex.begin());
            auto beyond = [&](const Rational& p) {
                const auto corner = [&](int k) -> const Rational& { return k == slot ? p : at(k); };
                return determinant(minus(corner(0), corner(3)), minus(corner(1), corner(3)),
                                   minus(corner(2), corner(3)));
            };
            for (const Rational& p : r) REQUIRE(sgn(beyond(p)) <= 0);
            hull -= beyond(r[0]);
        }
    }
    CHECK(volume == hull);
    CHECK((met.size() == points.size() + 1 || !weights.empty()));
    CHECK(*met.begin() == Triangulation::infinite);
    return points.size() + 1 - met.size();
}

// Cells clipped by their Delaunay neighbors only against cells searched until proven.
void check_cells(const test::PointSet& set) {
    CAPTURE(set.name);
    votess::ThreadPool pool(1);
    const SortedSeeds seeds = sorted_seeds(set, pool);
    Hierarchy hierarchy;
    hierarchy.build(seeds, pool);
    const Delaunay delaunay(seeds);
    REQUIRE(delaunay.valid());
    votess::Box box{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
    for (const Point& p : points_of(seeds))
        for (int k = 0; k < 3; ++k) {
            box.lower[k] = std::min(box.lower[k], p[k] - 0.5);
            box.upper[k] = std::max(box.upper[k], p[k] + 0.5);
        }
    CellBuilder search(seeds, hierarchy), clip(seeds, hierarchy);
    const votess::Domain domain = votess::box_domain(box, {});
    search.begin_job(domain);
    clip.begin_job(domain);
    std::vector<std::int32_t> neighbors, back;
    std::vector<std::uint8_t> marks;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        delaunay.neighbors(i, neighbors, marks);
        std::ranges::sort(neighbors);
        REQUIRE(std::ranges::adjacent_find(neighbors) == neighbors.end());
        for (const std::int32_t n : neighbors) {
            delaunay.neighbors(static_cast<std::size_t>(n), back, marks);
            REQUIRE(std::ranges::find(back, static_cast<std::int32_t>(i)) != back.end());
        }
        REQUIRE(test::faces_of(clip.build_from(i, neighbors)) == test::faces_of(search.build(i)));
    }
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("delaunay: predicates equal rational arithmetic in every width") {
        check_predicates("small integers", 1, 4000, 100, [](Random& r) { return 1.0 * r.integer(-3, 3); });
        check_predicates("offset integers", 2, 1000, 20, [](Random& r) { return 1e8 + 1.0 * r.integer(-2, 2); });
        check_predicates("uniform", 3, 2000, 0, [](Random& r) { return r.uniform(); });
        check_predicates("tenths", 4, 4000, 0, [](Random& r) { return 0.1 * r.integer(-2, 2); });
        check_predicates("twenty decades", 5, 2000, 0,
                         [](Random& r) { return r.uniform(-1, 1) * std::pow(10.0, r.uniform(-20, 0)); });
        check_predicates("all that order one leaves of float64", 6, 600, 0, [](Random& r) {
            return r.uniform(-1, 1) * std::ldexp(1.0, static_cast<int>(r.integer(-1074, 60)));
        });
        check_predicates("subnormal lattice", 7, 600, 10,
                         [](Random& r) { return std::ldexp(1.0 * r.integer(-3, 3), -1074); });
        // 61 bits and one more.
        check_predicates("long integers", 8, 2000, 0, [](Random& r) {
            return (r.chance(0.5) ? -0x1p59 : 0x1p59 - 64) + 1.0 * r.integer(-1, 1) * std::ldexp(1.0, r.below(9));
        });
    }

    TEST_CASE("delaunay: signs of weighted points and images equal rational arithmetic") {
        votess::exact::Lattice box, skewed;
        for (int k = 0; k < 3; ++k) box.vector[k][k] = votess::exact::two_sum(1 + 0.1 * k, 0x1p-60);
        skewed.vector = {{{{{1, 0}, {0, 0}, {0, 0}}}, {{{0.4, 0}, {1, 0}, {0, 0}}}, {{{0.2, 0}, {0.3, 0}, {0.9, 0}}}}};
        check_power_sites("no images", 1, 2000, box, 0, 1);
        check_power_sites("box", 2, 2000, box, 2.5, 0);
        check_power_sites("weights", 3, 2000, skewed, 2.5, 1);
        check_power_sites("far images", 4, 2000, skewed, 0x1p29, 1);
        check_power_sites("heavy", 5, 1000, skewed, 1.5, 1e9);
        check_power_sites("beyond the range of rounded tests", 6, 300, box, 0, 1e60);
    }

    TEST_CASE("delaunay: triangulations of small sets are right by definition") {
        int solid = 0;
        for (const test::PointSet& set : test::families(test::by_size(40, 20), 21)) {
            CAPTURE(set.name);
            votess::ThreadPool pool(1);
            const std::vector<Point> points = points_of(sorted_seeds(set, pool));
            for (const bool reversed : {false, true}) {
                std::vector<Point> order = points;
                if (reversed) std::ranges::reverse(order);
                const PointSites sites(order);
                Triangulation triangulation(sites);
                if (!triangulate(order, triangulation)) continue;
                ++solid;
                (void)check_triangulation(order, triangulation.tetrahedra());
            }
        }
        CHECK(solid > 30);
    }

    TEST_CASE("delaunay: triangulations of random small integers, mostly ties") {
        Random random(9);
        for (std::size_t round = 0; round < test::by_size(150, 15); ++round) {
            std::set<Point> distinct;
            const auto size = static_cast<std::int64_t>(1 + random.below(3));
            for (std::uint64_t i = 4 + random.below(24); i > 0; --i)
                distinct.insert(
                    {1.0 * random.integer(0, size), 1.0 * random.integer(0, size), 1.0 * random.integer(0, size)});
            std::vector<Point> points;
            const std::vector<Point> ascending(distinct.begin(), distinct.end());
            for (const std::size_t i : test::permutation(ascending.size(), random)) points.push_back(ascending[i]);
            const PointSites sites(points);
            Triangulation triangulation(sites);
            if (triangulate(points, triangulation)) (void)check_triangulation(points, triangulation.tetrahedra());
        }
    }

    TEST_CASE("delaunay: triangulations with weights and hidden points, many of them ties or at one place") {
        Random random(10);
        std::size_t hidden = 0, rounds = 0;
        for (std::size_t round = 0; round < test::by_size(60, 20); ++round) {
            std::vector<Point> points;
            std::vector<double> weights;
            for (std::uint64_t i = 5 + random.below(20); i > 0; --i) {
                points.push_back({1.0 * random.integer(0, 3), 1.0 * random.integer(0, 3), 1.0 * random.integer(0, 3)});
                weights.push_back(round % 2 == 0 ? 1.0 * random.integer(0, 4) : random.uniform(0, 3));
            }
            const WeightedSites sites(points, weights);
            Triangulation triangulation(sites);
            if (!triangulate(points, triangulation)) continue;
            ++rounds;
            hidden += check_triangulation(points, triangulation.tetrahedra(), weights);
        }
        CHECK(rounds > 10);
        CHECK(hidden > 2 * rounds);
    }

    TEST_CASE("delaunay: every Voronoi neighbor is a Delaunay neighbor") {
        for (const test::PointSet& set : test::families(test::by_size(30, 20), 22)) {
            CAPTURE(set.name);
            votess::ThreadPool pool(1);
            const SortedSeeds seeds = sorted_seeds(set, pool);
            const Delaunay delaunay(seeds);
            REQUIRE(delaunay.valid());
            const auto t = test::run(set);
            REQUIRE(test::check_exact(t, set.points) == "");
            std::vector<std::int32_t> neighbors;
            std::vector<std::uint8_t> marks;
            for (std::size_t i = 0; i < seeds.size(); ++i) {
                delaunay.neighbors(i, neighbors, marks);
                std::vector<std::int32_t> inputs;
                for (const std::int32_t n : neighbors) inputs.push_back(seeds.input[n]);
                for (const std::int32_t face : t.neighbors(seeds.input[i]))
                    if (face >= 0) REQUIRE(std::ranges::count(inputs, face) == 1);
            }
        }
    }

    TEST_CASE("delaunay: cells clipped by Delaunay neighbors equal those of a search") {
        for (const test::PointSet& set : test::families(test::by_size(300, 60), 23)) check_cells(set);
        check_cells(test::uniform(test::by_size(2500, 500), 24));
        check_cells(test::cubic(test::by_size(12, 5)));
        check_cells(test::on_sphere(test::by_size(1200, 200), 25));
        check_cells(test::cospherical(test::by_size(3001, 101)));
        for (std::size_t n = 1; n <= 5; ++n) check_cells(test::uniform(n, 26));
    }

    TEST_CASE("delaunay: parts of a query are clipped by few of its neighbors") {
        Random random(26);
        for (const int kind : {0, 1, 2, 3}) {
            CAPTURE(kind);
            const bool weighted = kind % 2 == 1;
            for (const std::size_t n : {200, 800}) {
                std::vector<double> points = test::on_sphere(n, 27).points;
                for (double& x : points) x = 0.5 + 0.25 * x;
                votess::Options options;
                options.box = test::unit_box();
                options.periodic = {kind >= 2, kind >= 2, kind >= 2};
                std::vector<double> weights;
                for (std::size_t i = 0; i < n && weighted; ++i) weights.push_back(random.uniform(0, 1e-7));
                options.weights = weights;
                const votess::Job job = votess::make_job(votess::settle({points, {}}, options));
                CpuClipper clipper;
                clipper.begin(job);
                clipper.prepare();
                std::vector<Member> members;
                for (std::size_t s = 0; s < n; ++s) members.push_back({static_cast<std::int32_t>(s)});
                Parts parts(clipper.seeds(), clipper.hierarchy(), best_kernels());
                parts.begin_job(*job.domain);
                const Point middle{0.5 * job.scale, 0.5 * job.scale, 0.5 * job.scale};
                const auto divided = parts.divide({middle, {middle}, 0}, members, false);
                CHECK(divided.size() > n / 2);
                CHECK(parts.clips() < 40 * n);
            }
        }
    }

    TEST_CASE("delaunay: a user who stops it, and too many tetrahedra") {
        votess::ThreadPool pool(1);
        const SortedSeeds many = sorted_seeds(test::uniform(10000, 27), pool);
        votess::Progress stopping([](double) { return false; });
        {
            const votess::Stoppable stoppable(stopping);
            CHECK_THROWS_AS(Delaunay{many}, votess::Error);
        }
        CHECK(Delaunay(many).valid());
        if (test::reduced()) return;
        // Two skew lines: each pair of neighbors on one and on the other is a tetrahedron.
        test::PointSet lines{"skew lines", {}, std::nullopt};
        for (int i = 0; i < 2500; ++i) lines.points.insert(lines.points.end(), {1.0 * i, 0, 0, 0, 1.0 * i, 1});
        CHECK_FALSE(Delaunay(sorted_seeds(lines, pool)).valid());
    }

    TEST_CASE("hard cells: spheres equal the unbounded search") {
        for (const std::size_t n : {test::by_size(300, 100), test::by_size(2000, 300)}) {
            const test::PointSet set = test::on_sphere(n, 28);
            CAPTURE(n);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            votess::ThreadPool pool(1);
            SortedSeeds seeds;
            SeedSorter().sort(std::span<const double>(set.points), 1, 0, pool, seeds);
            Hierarchy hierarchy;
            hierarchy.build(seeds, pool);
            CellBuilder search(seeds, hierarchy);
            const votess::Domain domain = votess::box_domain(t.box(), {});
            search.begin_job(domain);
            for (std::size_t i = 0; i<seeds.size(); i += n> 1000 ? 10 : 1) {
                std::vector<std::int32_t> ids = test::faces_of(search.build(i));
                for (auto& id : ids) id = id < 0 ? id : seeds.input[id];
                std::ranges::sort(ids);
                REQUIRE(test::row_of(t, seeds.input[i]) == ids);
            }
        }
    }

    TEST_CASE("hard cells: spheres among other seeds, for all threads and settings") {
        // Hard cells in some blocks only; with a center, which is no neighbor of most.
        test::PointSet mixed = test::uniform(test::by_size(2000, 400), 29);
        for (const double radius : {0.2, 0.01}) {
            const test::PointSet sphere = test::on_sphere(test::by_size(2500, 500), 30);
            for (double x : sphere.points) mixed.points.push_back(0.5 + radius * x);
        }
        // Nothing inside the spheres.
        test::PointSet hollow{"hollow", {}, mixed.box};
        for (std::size_t i = 0; i < mixed.points.size(); i += 3) {
            const double* p = &mixed.points[i];
            const double r = std::hypot(p[0] - 0.5, p[1] - 0.5, p[2] - 0.5);
            if (r > 0.199 || (r > 0.009 && r < 0.011)) hollow.points.insert(hollow.points.end(), p, p + 3);
        }
        for (const test::PointSet& set :
             {mixed, hollow, test::on_sphere_and_center(test::by_size(2000, 300), 31),
              test::on_sphere(test::by_size(2000, 300), 32), test::cospherical(test::by_size(3001, 101))}) {
            CAPTURE(set.name);
            const auto one = test::run(set);
            CHECK(test::check_invariants(one, set.points) == "");
            auto options = test::all_options(set.box);
            options.threads = 3;
            const auto three = test::run(set, options);
            CHECK(test::check_invariants(three, set.points) == "");
            CHECK(test::rows_of(one) == test::rows_of(three));
            options.want = {.neighbors = true, .volumes = false, .centroids = false, .counts = false};
            CHECK(test::rows_of(one) == test::rows_of(test::run(set, options)));
        }
    }

    // Images only cut cells, so the triangulation of the seeds alone tells the neighbors among them.
    TEST_CASE("hard cells: a sphere in a periodic box equals the certificate, and takes tests in proportion") {
        struct Tests {
            double among_images, searched;  // of a seed
        };
        const auto tests_of = [](std::size_t n, bool crosses) {
            test::PointSet set = test::on_sphere(n, 35);
            for (std::size_t k = 0; k < set.points.size(); ++k)
                set.points[k] = 0.375 * set.points[k] + (crosses && k % 3 < 2 ? 0.125 : 0.5);
            votess::Options options;
            options.box = test::cube(0, 1);
            options.periodic = {true, true, false};
            votess::ThreadPool pool(1);
            const votess::Job job = votess::make_job(votess::settle({set.points, {}}, options));
            SeedSorter sorter;
            SortedSeeds seeds;
            votess::cpu::SeedImages images;
            images.sort(job, {}, sorter, pool, seeds);
            Hierarchy hierarchy;
            hierarchy.build(seeds, pool);
            CellBuilder builder(seeds, hierarchy);
            builder.begin_job(*job.domain);
            const auto unwrapped = votess::cpu::unwrap(seeds, pool);
            REQUIRE(unwrapped.has_value() == crosses);
            std::vector<PowerSites::Site> sites;
            for (std::size_t s = 0; s < seeds.size() && crosses; ++s) {
                auto at = images.base(s);
                for (std::size_t j = 0; j < 3; ++j) at.shift[j] += unwrapped->shifts[s][j];
                sites.push_back({at.point, at.shift, 0});
            }
            const Delaunay delaunay =
                crosses ? Delaunay(seeds.size(), PowerSites(sites, &job.domain->lattice)) : Delaunay(seeds);
            std::vector<std::int32_t> candidates;
            std::vector<std::uint8_t> marks;
            Tests tests{};
            for (std::size_t s = 0; s < seeds.size(); s += 20) {
                delaunay.neighbors(s, candidates, marks);
                std::vector<std::int32_t> ids =
                    test::faces_of(crosses ? builder.build_among_images(s, candidates, *unwrapped)
                                           : builder.build_among_images(s, candidates));
                tests.among_images += static_cast<double>(builder.tests());
                std::vector<std::int32_t> searched = test::faces_of(builder.build(s));
                tests.searched += static_cast<double>(builder.tests());
                std::ranges::sort(ids);
                std::ranges::sort(searched);
                REQUIRE(ids == searched);
            }
            const auto built = static_cast<double>((seeds.size() + 19) / 20);
            return Tests{tests.among_images / built, tests.searched / built};
        };
        for (const bool crosses : {false, true}) {
            CAPTURE(crosses);
            const Tests few = tests_of(300, crosses), many = tests_of(1200, crosses);
            CHECK(many.searched > 2.5 * few.searched);
            CHECK(many.among_images < 2 * few.among_images);
            CHECK(many.among_images < 0.2 * many.searched);
        }

        constexpr double inf = std::numeric_limits<double>::infinity();
        for (const bool wrapped : {false, true})  // then places are rounded
            for (const votess::Box& box : {test::cube(0, 1), votess::Box{{0, 0, -inf}, {1, 1, inf}}}) {
                test::PointSet set = test::on_sphere(200, 36);
                for (std::size_t k = 0; k < set.points.size(); ++k)
                    set.points[k] = 0.4 * set.points[k] + (wrapped && k % 3 < 2 ? 0.1 : 0.5);
                auto options = test::all_options(box);
                options.periodic = {true, true, box.upper[2] == 1};
                const auto report =
                    votess::verify(votess::tessellate(std::span<const double>(set.points), options), set.points);
                CHECK(report.failure == "");
                CHECK(report.proven);
            }
    }

    TEST_CASE("hard cells: a sphere across all sides of a skewed cell, and one that a box cuts, are proven") {
        test::PointSet set = test::on_sphere(test::by_size(600, 400), 37);
        for (double& x : set.points) x = 0.45 * x + 0.5;
        auto options = test::all_options(test::cube(0, 1));
        options.box.reset();
        options.cell = votess::TriclinicBox{.a = {1, 0, 0}, .b = {0.4, 1, 0}, .c = {0.2, 0.3, 1}};
        const auto skewed = votess::tessellate(std::span<const double>(set.points), options);
        for (const auto& report : {votess::verify(skewed, set.points), [&] {
                                       auto cut = test::all_options(test::cube(0.125, 0.875));
                                       cut.outside = votess::Outside::keep;
                                       const auto t = votess::tessellate(std::span<const double>(set.points), cut);
                                       return votess::verify(t, set.points);
                                   }()}) {
            CHECK(report.failure == "");
            CHECK(report.proven);
        }
    }

    TEST_CASE("hard cells: a large sphere among small ones on a sphere, which are proven") {
        for (const bool filled : {false, true}) {
            test::PointSet set = test::on_sphere(test::by_size(600, 300), 33);
            if (filled) {  // some of these are hidden in the large one
                const test::PointSet inside = test::uniform(300, 34);
                for (const double x : inside.points) set.points.push_back(x - 0.5);
            }
            std::vector<double> weights(set.points.size() / 3, 1e-4);
            weights[0] = 0.25;
            auto options = test::all_options(test::cube(-2, 2));
            options.weights = weights;
            const auto t = votess::tessellate(set.points, options);
            CHECK(t.stats().empty_cells > 0);
            const auto report = votess::verify(t, set.points);
            CHECK(report.failure == "");
            CHECK(report.proven);
        }
    }
}
