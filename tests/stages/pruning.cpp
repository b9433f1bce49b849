// Every test by which the CPU's searches leave a seed out, against the exact sign on near-ties: a seed within a few
// units in the last place of the sphere around a vertex. What cuts the cell off must pass all of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "domain/domain.hpp"
#include "domain/wall_tree.hpp"
#include "exact/predicate.hpp"
#include "index/hierarchy.hpp"
#include "index/lift.hpp"
#include "index/seed_images.hpp"
#include "index/sorted_seeds.hpp"
#include "input/settle.hpp"
#include "kernels/star_kernels.hpp"
#include "polytope/cell.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using votess::Box;
using votess::Domain;
using votess::exact::Plane;
using votess::exact::Point;
using votess::exact::Quad;
using votess::exact::Shift;

constexpr double unit = 0x1p-53;

// Where a cell and its near-ties are made: seeds around `center`, at distances of `spacing`, with weights of that size.
struct Setting {
    const char* name;
    Box box;
    std::array<bool, 3> periodic;
    double spacing;
    double weights;  // in squared spacings
};

Point rounded_image(const Point& q, const Shift& shift, const Domain& domain) {
    const auto at = votess::exact::differences({}, Plane::bisector(q, shift, domain.lattice)).x;
    return {at[0].high, at[1].high, at[2].high};
}

double size_of(const Point& x) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

struct Counts {
    std::size_t tried = 0, cuts = 0;
    std::size_t missed = 0;  // cuts that would be out of reach without the slack for rounded coordinates and weights
};

// Returns any paraboloid, with the place of its center in spacings.
votess::cpu::Lift lift_beside(const Point& p, double spacing, test::Random& random) {
    votess::cpu::Lift lift;
    lift.curvature = random.below(2) == 0 ? 1 - 0x1p-10 : 0x1p-20 * static_cast<double>(random.below(1 << 20));
    lift.shrink = 1 - lift.curvature;
    const double far = random.below(2) == 0 ? 1 : 30;
    for (std::size_t k = 0; k < 3; ++k) lift.center[k] = p[k] + far * spacing * random.uniform(-1, 1);
    return lift;
}

// Whether both bounds by a paraboloid let a seed q that cuts the cell of p pass.
bool in_lifted_reach(votess::cpu::Cell& cell, const votess::cpu::Lift& lift, const Point& p, double weight,
                     const Point& q, double other) {
    const double more = lift.max_rest(q, other) - lift.min_rest(p, weight);
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) square += (q[k] - p[k]) * (q[k] - p[k]);
    const votess::cpu::LiftedView view{lift.move(p), lift.shrink};
    return cell.may_cut(votess::cpu::seen_from(p, {q, q}), more, view) &&
           std::sqrt(square) * (1 - 1e-12) < cell.lifted_reach(view, std::max(0.0, more));
}

// Cells of some bisectors each; for each vertex seeds that nearly touch it.
Counts try_setting(const Setting& setting, std::size_t cells, std::uint64_t seed) {
    test::Random random(seed);
    Domain domain = votess::box_domain(setting.box, setting.periodic);
    const bool weighted = setting.weights > 0;
    domain.largest_weight = weighted ? setting.weights * setting.spacing * setting.spacing : 0;
    if (weighted) domain.weights = {domain.largest_weight};
    Counts counts;
    votess::cpu::Cell cell(votess::cpu::best_kernels());
    votess::cpu::CellFaces faces;
    const auto direction = [&] {
        Point x{};
        double square = 0;
        while (!(square > 0.01 && square < 1)) {
            for (double& c : x) c = random.uniform(-1, 1);
            square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        }
        for (double& c : x) c /= std::sqrt(square);
        return x;
    };
    // A point as given, and the shift that brings its image near `wanted`: beyond a periodic face it is an image.
    const auto as_given = [&](const Point& wanted) {
        std::pair<Point, Shift> given{wanted, {}};
        for (std::size_t k = 0; k < 3; ++k) {
            if (!setting.periodic[k]) continue;
            const double period = setting.box.upper[k] - setting.box.lower[k];
            const double way = wanted[k] < setting.box.lower[k] ? 1 : wanted[k] >= setting.box.upper[k] ? -1 : 0;
            given.first[k] += way * period;
            given.second[k] = -static_cast<std::int32_t>(way);
        }
        return given;
    };
    for (std::size_t c = 0; c < cells; ++c) {
        Point wanted;
        for (std::size_t k = 0; k < 3; ++k) {
            // Beside a face when that is periodic, so that neighbors are images.
            const double side = setting.box.upper[k] - setting.box.lower[k];
            wanted[k] = setting.periodic[k] ? setting.box.upper[k] - setting.spacing * random.uniform(-0.5, 0.5)
                                            : setting.box.lower[k] + side * random.uniform(0.3, 0.7);
        }
        const auto [p, own_shift] = as_given(wanted);
        const Point at = rounded_image(p, own_shift, domain);
        const double weight = weighted ? domain.largest_weight * random.uniform() : 0;
        const auto bisector = [&](const std::pair<Point, Shift>& q, double other) {
            Shift shift;
            for (std::size_t k = 0; k < 3; ++k) shift[k] = q.second[k] - own_shift[k];
            Plane plane = Plane::bisector(q.first, shift, domain.lattice);
            if (weighted) plane.power = votess::exact::two_sum(weight, -other);
            return plane;
        };
        cell.start(p, domain);
        for (std::int32_t n = 0; n < 12; ++n) {
            const Point u = direction();
            const double distance =
                setting.spacing * random.uniform(0.8, 1.5) * std::sqrt(1 + (weighted ? 2 * setting.weights : 0));
            const auto q = as_given({at[0] + distance * u[0], at[1] + distance * u[1], at[2] + distance * u[2]});
            cell.clip(1 + n, bisector(q, weighted ? domain.largest_weight * random.uniform() : 0), q.second);
        }
        if (cell.empty()) continue;
        const votess::cpu::Lift lift = lift_beside(at, setting.spacing, random);
        cell.canonical_faces(faces);
        std::vector<std::int32_t> slots(faces.corners);
        std::ranges::sort(slots);
        slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
        for (const std::int32_t slot : slots) {
            const auto v = cell.position(slot);
            const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            const auto [a, b, d] = cell.corner_planes(slot);
            for (int tries = 0; tries < 8; ++tries) {
                // The heaviest seed, or any, which may be lighter than the cell's.
                const double other = domain.largest_weight * (tries < 6 ? 1 : random.uniform());
                if (square + other - weight < 0) continue;
                const double radius = std::sqrt(square + other - weight);
                const double more = weighted ? std::min(domain.max_heavier_by(weight), other - weight) : 0;
                const Point u = direction();
                Point near;
                for (std::size_t k = 0; k < 3; ++k) {
                    near[k] = at[k] + v[k] + radius * u[k];
                    const double step = 4 * unit * (std::abs(near[k]) + setting.spacing);
                    near[k] += step * random.uniform(-1, 1) * (tries % 2 == 0 ? 1 : 0.25);
                }
                const auto q = as_given(near);
                const Point image = rounded_image(q.first, q.second, domain);
                const Plane plane = bisector(q, other);
                ++counts.tried;
                if (votess::exact::side_of_vertex(p, a->source, b->source, d->source, plane) <= 0) continue;
                ++counts.cuts;
                const bool images = domain.is_periodic();
                if (weighted && !images && !in_lifted_reach(cell, lift, at, weight, image, other))
                    FAIL_CHECK("a seed that cuts the cell is out of reach where weights follow a paraboloid");
                const double largest = std::max(size_of(at), size_of(image));
                const double rounding = images ? 8 * unit * largest : 0;  // as CellBuilder's
                Point of_axis{};
                for (std::size_t k = 0; k < 3; ++k)
                    if (setting.periodic[k]) of_axis[k] = 8 * unit * std::max(std::abs(at[k]), std::abs(image[k]));
                const auto box = votess::cpu::seen_from(at, {image, image}, of_axis);
                if (!cell.in_reach(box, more) || !cell.may_cut(box, std::max(0.0, more))) {
                    CAPTURE(setting.name);
                    CAPTURE(c);
                    FAIL_CHECK("a seed that cuts the cell is out of reach");
                }
                counts.missed +=
                    cell.in_reach(votess::cpu::seen_from(at, {image, image}), more - 1e-9 * std::abs(more)) ? 0 : 1;
                // The bounds of an image by its shift hold the exact place.
                if (!images) continue;
                const auto by = votess::shifts_around(domain, {image, image}, at,
                                                      (std::sqrt(square) + radius) * (1 + 1e-9) + rounding);
                if (!(by.lower <= std::array<std::int32_t, 3>{} && std::array<std::int32_t, 3>{} <= by.upper))
                    FAIL_CHECK("a shift within the distance is missing");
            }
        }
    }
    return counts;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("pruning: what cuts a cell by an exact sign is in reach of it") {
        const Box unit_box{{0, 0, 0}, {1, 1, 1}};
        const Setting settings[] = {
            {"box", unit_box, {}, 0.1, 0},
            {"far from 0", {{1e8, 1e8, 1e8}, {1e8 + 1, 1e8 + 1, 1e8 + 1}}, {}, 0.01, 0},
            {"tiny", {{0, 0, 0}, {1e-9, 1e-9, 1e-9}}, {}, 1e-10, 0},
            {"periodic", unit_box, {true, true, true}, 0.1, 0},
            {"periodic, spacing 1e-8 of the coordinates", unit_box, {true, true, true}, 1e-8, 0},
            {"periodic, spacing 1e-12 of the coordinates", unit_box, {true, true, true}, 1e-12, 0},
            {"periodic, sides that are no doubles",
             {{-0.23936944299295215, 0.1, -0.7}, {1.6371147878177517, 1.3, 0.2}},
             {true, true, true},
             1e-9,
             0},
            {"periodic along y, far from 0",
             {{1e6, 1e6, 1e6}, {1e6 + 1, 1e6 + 0.7, 1e6 + 1}},
             {false, true, false},
             1e-6,
             0},
            {"weights below the squared spacing", unit_box, {}, 0.1, 1e-9},
            {"weights like the squared spacing", unit_box, {}, 0.1, 1},
            {"weights far above the squared spacing", unit_box, {}, 0.001, 1e4},
            {"weights far from 0", {{1e6, 1e6, 1e6}, {1e6 + 1, 1e6 + 1, 1e6 + 1}}, {}, 1e-5, 10},
            {"weights in a periodic box", unit_box, {true, true, true}, 1e-4, 100},
            {"weights in a periodic box, far from 0",
             {{1e6, 1e6, 1e6}, {1e6 + 1, 1e6 + 1, 1e6 + 1}},
             {true, true, true},
             1e-5,
             10},
        };
        std::size_t tried = 0, missed = 0;
        for (const Setting& setting : settings) {
            const Counts counts = try_setting(setting, test::by_size(900, 30), 7);
            tried += counts.tried;
            missed += counts.missed;
            CAPTURE(setting.name);
            // The seeds lie on both sides: the test can fail, and does where slack is left out.
            CHECK(counts.cuts > counts.tried / 10);
            CHECK(counts.cuts < counts.tried * 9 / 10);
        }
        CHECK(tried > test::by_size(1'000'000, 30'000));
        CHECK(missed > 0);
    }

    TEST_CASE("pruning: a paraboloid is found in weights that follow one") {
        test::Random random(5);
        const Point center{3, -2, 7};
        for (const int dimensions : {3, 2, 1})
            for (const double curvature : {0.9, 0.25, 0.0}) {
                CAPTURE(dimensions);
                CAPTURE(curvature);
                constexpr std::size_t count = 400;
                votess::cpu::SortedSeeds seeds;
                votess::Buffer<double>* const axes[3] = {&seeds.x, &seeds.y, &seeds.z};
                for (auto* axis : axes) axis->resize_uninitialized(count);
                seeds.input.resize_uninitialized(count);
                for (std::size_t s = 0; s < count; ++s) {
                    double square = 0;
                    for (int k = 0; k < 3; ++k) {
                        (*axes[k])[s] = k < dimensions ? random.uniform(-1, 1) : 0.5;
                        square += ((*axes[k])[s] - center[k]) * ((*axes[k])[s] - center[k]);
                    }
                    seeds.weights.push_back(curvature * square + random.uniform(0, 1e-3));
                }
                const votess::cpu::Lift lift = votess::cpu::fit_lift(seeds);
                REQUIRE(lift.exists() == (curvature > 0));
                if (curvature == 0) continue;
                CHECK(lift.curvature == doctest::Approx(curvature).epsilon(0.01));
                const auto [least, most] = std::ranges::minmax(lift.rests);
                CHECK(most - least < 2e-3);
            }
    }

    TEST_CASE("pruning: images by a range of shifts lie within its bounds") {
        test::Random random(11);
        const std::size_t domains = test::by_size(3000, 200);
        for (std::size_t n = 0; n < domains; ++n) {
            const double size = std::ldexp(1.0, static_cast<int>(random.below(40)) - 20);
            votess::TriclinicBox given{};
            for (auto* vector : {&given.origin, &given.a, &given.b, &given.c})
                for (double& x : *vector) x = random.uniform(-0.4, 0.4) * size;
            given.a[0] += size, given.b[1] += size * random.uniform(0.01, 1), given.c[2] += size;
            for (double& x : given.b) x += static_cast<double>(random.below(50)) * given.a[&x - given.b.data()];
            std::optional<Domain> domain;
            try {
                domain = votess::triclinic_domain(given);
            } catch (const votess::Error&) {
                continue;  // too flat
            }
            for (int tries = 0; tries < 40; ++tries) {
                Point q;
                for (double& x : q) x = random.uniform(-1, 1) * size;
                votess::ShiftRange range;
                for (std::size_t j = 0; j < 3; ++j) {
                    range.lower[j] = static_cast<std::int32_t>(random.below(200)) - 100;
                    range.upper[j] = range.lower[j] + static_cast<std::int32_t>(random.below(3));
                }
                votess::ShiftRange one;
                for (std::size_t j = 0; j < 3; ++j)
                    one.lower[j] = one.upper[j] =
                        range.lower[j] + static_cast<std::int32_t>(random.below(
                                             static_cast<std::uint64_t>(range.upper[j] - range.lower[j]) + 1));
                const Shift shift = votess::only_shift(*domain, one);
                const auto exact = votess::exact::difference<Quad>({}, Plane::bisector(q, shift, domain->lattice));
                // Seen from beside the image nearly all digits cancel.
                Point x;
                for (std::size_t k = 0; k < 3; ++k)
                    x[k] = static_cast<double>(exact[k]) + (tries % 2 == 0 ? 0 : random.uniform(-1, 1) * size);
                const Box bounds = votess::images_of(*domain, {q, q}, range, x);
                bool within = true;
                for (std::size_t k = 0; k < 3; ++k)
                    within = within && bounds.lower[k] <= exact[k] - x[k] && exact[k] - x[k] <= bounds.upper[k];
                REQUIRE(within);
                // Halving the range keeps the shift, and a search around the seed finds it.
                Point p;
                double square = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    p[k] = static_cast<double>(exact[k]) + random.uniform(-1, 1) * size;
                    const auto gap = static_cast<double>(exact[k] - p[k]);
                    square += gap * gap;
                }
                const auto around = votess::shifts_around(*domain, {q, q}, p, std::sqrt(square) * (1 + 1e-15));
                for (std::size_t j = 0; j < 3; ++j) {
                    REQUIRE(around.lower[j] <= one.lower[j]);
                    REQUIRE(one.lower[j] <= around.upper[j]);
                }
            }
        }
    }

    TEST_CASE("pruning: all images nearer to a seed than is known are among the seeds") {
        test::Random random(13);
        votess::ThreadPool pool(1);
        const std::size_t sets = test::by_size(300, 30);
        std::size_t found = 0;
        for (std::size_t n = 0; n < sets; ++n) {
            const double offset = random.below(3) == 0 ? 1e7 : 0;
            votess::Options options;
            Box box;
            for (std::size_t k = 0; k < 3; ++k) {
                box.lower[k] = offset + random.uniform(-1, 1);
                box.upper[k] = box.lower[k] + random.uniform(0.1, 1);
                options.periodic[k] = k == 0 || random.below(2) == 0;
            }
            options.box = box;
            std::vector<double> points;
            for (std::size_t i = 0; i < 6; ++i)
                for (std::size_t k = 0; k < 3; ++k)
                    points.push_back(
                        std::clamp(random.uniform(box.lower[k], box.upper[k]), box.lower[k], box.upper[k]));
            const votess::Job job = votess::make_job(votess::settle({points, {}}, options));
            votess::cpu::SeedSorter sorter;
            votess::cpu::SortedSeeds seeds;
            votess::cpu::SeedImages images;
            images.sort(job, {}, sorter, pool, seeds);
            for (std::size_t s = 0; s < seeds.size(); ++s) {
                const auto own = images.base(s);
                const Point seed{seeds.x[s], seeds.y[s], seeds.z[s]};
                const double reach = images.reach(seed);
                Box around;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double end = random.uniform(box.lower[k], box.upper[k]);
                    around.lower[k] = std::min(seed[k], end), around.upper[k] = std::max(seed[k], end);
                }
                double least = votess::infinity;
                for (int corner = 0; corner < 8; ++corner) {
                    Point place;
                    for (std::size_t k = 0; k < 3; ++k)
                        place[k] = (corner >> k & 1) != 0 ? around.upper[k] : around.lower[k];
                    least = std::min(least, images.reach(place));
                }
                REQUIRE(std::abs(images.reach(around) - least) < 1e-7);
                for (std::int32_t home = 0; home < static_cast<std::int32_t>(seeds.size()); ++home)
                    for (int code = 0; code < 125; ++code) {
                        const Shift shift{code % 5 - 2, code / 5 % 5 - 2, code / 25 - 2};
                        bool possible = shift != Shift{};
                        for (std::size_t k = 0; k < 3; ++k)
                            possible = possible && (shift[k] == 0 || options.periodic[k]);
                        if (!possible) continue;
                        const auto d = votess::exact::difference<Quad>(own.point, images.bisector(own, home, shift));
                        const Quad square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                        if (!(square < Quad(reach) * reach)) continue;
                        ++found;
                        bool there = false;
                        for (std::size_t id = seeds.size(); id < seeds.images_end && !there; ++id) {
                            const auto i = static_cast<std::int32_t>(id);
                            there = images.is_image(i) && images.home(i) == home && images.shift(i) == shift;
                        }
                        REQUIRE(there);
                    }
            }
        }
        CHECK(found > sets);
    }

    TEST_CASE("pruning: the ball of the walk's search holds what cuts its vertex") {
        test::Random random(17);
        const auto& kernels = votess::cpu::star_kernels(votess::cpu::best_kernels().name);
        const std::size_t vertices = test::by_size(30'000, 1000);
        std::size_t tried = 0, cuts = 0;
        for (std::size_t n = 0; n < vertices; ++n) {
            const double offset = random.below(2) == 0 ? 0 : 1e6;
            Point p;
            for (double& x : p) x = offset + random.uniform();
            std::array<Point, 3> q;
            std::array<std::array<double, 3>, 3> d;
            for (std::size_t j = 0; j < 3; ++j)
                for (std::size_t k = 0; k < 3; ++k) {
                    q[j][k] = p[k] + (j == k ? 1 : 0.4) * random.uniform(-0.1, 0.1);
                    d[j][k] = q[j][k] - p[k];
                }
            const double determinant = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                                       d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                                       d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
            if (std::abs(determinant) < 1e-6) continue;
            const std::array planes{Plane::bisector(q[0]), Plane::bisector(q[1]), Plane::bisector(q[2])};
            const auto v = votess::exact::vertex_position<double>(p, planes[0], planes[1], planes[2]);
            const double x2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], scale = 0x1p28;
            // A vertex of the walk has an error of 2e-8 at most, in window units.
            constexpr double margin = 2e-8;
            votess::cpu::GroupTest test{p, scale, {}, 2 * margin * x2 * scale * scale};
            const double error = random.uniform(-1, 1) * margin * 0.4;
            for (std::size_t k = 0; k < 3; ++k) test.v[k] = v[k] * scale * (1 + error);
            double x[3][8];
            for (int i = 0; i < 8; ++i) {
                Point u;
                double length = 0;
                for (double& c : u) c = random.uniform(-1, 1), length += c * c;
                for (std::size_t k = 0; k < 3; ++k)
                    x[k][i] = p[k] + v[k] + u[k] * std::sqrt(x2 / length) * (1 + random.uniform(-1, 1) * 1e-9);
            }
            const unsigned inside = kernels.inside_ball(x[0], x[1], x[2], test, 0);
            for (int i = 0; i < 8; ++i) {
                ++tried;
                const Plane bisector = Plane::bisector({x[0][i], x[1][i], x[2][i]});
                if (votess::exact::side_of_vertex(p, planes[0], planes[1], planes[2], bisector) <= 0) continue;
                ++cuts;
                if (((inside >> i) & 1) == 0) FAIL_CHECK("a seed that cuts the vertex is not in its ball");
            }
        }
        CHECK(cuts > tried / 4);
        CHECK(tried > vertices);
    }

    // Places lie near the walls, where the tree has to look.
    TEST_CASE("pruning: a tree over walls leaves no wall out, and looks at few of a round hull") {
        test::Random random(71);
        const auto direction = [&] {
            Point n;
            for (double& x : n) x = random.uniform(-1, 1);
            return n;
        };
        for (const double flat : {1.0, 1e-3}) {
            for (const std::size_t count : {33, 500, 8000}) {
                CAPTURE(flat);
                CAPTURE(count);
                const Point middle{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
                std::vector<Plane> walls;
                while (walls.size() < count) {
                    const Point n = direction();
                    const double length = std::hypot(n[0], n[1], n[2] * flat);  // of an ellipsoid
                    double offset = length;
                    for (std::size_t k = 0; k < 3; ++k) offset += n[k] * middle[k];
                    walls.push_back(Plane::any_wall(n, offset));
                }
                const votess::WallTree tree(walls, middle);
                std::size_t visited = 0;
                constexpr std::size_t places = 40;
                for (std::size_t i = 0; i < places; ++i) {
                    Point x = direction();
                    const double length = std::hypot(x[0], x[1], x[2]), r = 1 - std::ldexp(1, random.integer(-50, -8));
                    for (std::size_t k = 0; k < 3; ++k) x[k] = middle[k] + x[k] / length * r * (k == 2 ? flat : 1);
                    std::vector<bool> found(count);
                    std::vector<std::size_t> nodes{0};
                    for (std::size_t k = 0; k < nodes.size(); ++k) {
                        if (!tree.may_exclude(nodes[k], x, 0)) continue;
                        found[tree.wall(nodes[k])] = true;
                        for (const std::size_t child : {2 * nodes[k] + 1, 2 * nodes[k] + 2})
                            if (child < count) nodes.push_back(child);
                    }
                    visited += nodes.size();
                    bool complete = true;
                    for (std::size_t w = 0; w < count; ++w)
                        complete = complete && (found[w] || votess::inside(walls[w], x));
                    CHECK(complete);
                }
                if (flat == 1 && count == 8000) CHECK(visited < 150 * places);
            }
        }
    }
}
