// The option `weights`: power diagrams.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using votess::Options;

// Proves the diagram in the unit box. Returns how many seeds have no cell.
std::size_t empty_cells(const Coordinates& points, const std::vector<double>& weights, bool periodic) {
    Options options;
    options.box = test::unit_box();
    options.periodic = {periodic, periodic, periodic};
    options.weights = weights;
    const auto t = votess::tessellate(points, options);
    CHECK(votess::verify(t, points).failure == "");
    return t.stats().empty_cells;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("weights: seeds at one place") {
        const Coordinates points{0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.2, 0.2, 0.2, 0.5, 0.5, 0.5};
        const std::vector<double> weights{0.01, 0.02, 0, 0.02};
        Options options = test::all_options(test::unit_box());
        options.weights = weights;
        const auto t = votess::tessellate(points, options);
        CHECK(t.status()[0] == votess::CellStatus::empty);
        CHECK(t.status()[1] == votess::CellStatus::certified);
        CHECK(t.status()[3] == votess::CellStatus::duplicate);
        CHECK(std::ranges::equal(t.duplicate_of(), std::vector<std::int32_t>{-1, -1, -1, 1}));
        CHECK(t.stats().empty_cells == 2);
        CHECK(test::check_right(points, options) == "");
    }

    TEST_CASE("weights: far above the squared spacing, full of near-ties") {
        for (std::size_t n = 0; n < test::by_size(40, 8); ++n) {
            CAPTURE(n);
            test::Random random(n + 1);
            // A crowd around 0, and a few heavy seeds at distances that nearly touch its cells.
            const double spacing = std::pow(10.0, -3 - 4 * random.uniform()), most = 0.3 + random.uniform();
            Coordinates points(300);
            std::vector<double> weights(100);
            for (double& x : points) x = spacing * random.gaussian();
            for (std::size_t i = 0; i < 12; ++i) {
                std::array<double, 3> u;
                double length = 0;
                for (double& x : u) x = random.gaussian(), length += x * x;
                weights.push_back(most * random.uniform(0.2, 1));
                // The bisector with 0 passes 0 at some spacings.
                const double distance = std::sqrt(weights.back()) * (1 + spacing * random.uniform(0, 2));
                for (const double x : u) points.push_back(x / std::sqrt(length) * distance);
            }
            Options options = test::all_options(test::cube(-2, 2));
            options.weights = weights;
            const auto t = votess::tessellate(points, options);
            REQUIRE(test::check_domain(t) == "");
            REQUIRE(votess::verify(t, points).failure == "");
        }
    }

    // The fuzz found the first: |q - p|^2 + w_p - w_q is 1e-27, in the last 34 bits of the sum.
    TEST_CASE("weights: volumes of cells whose planes lie nearer to the seed than the digits of the weights reach") {
        const double far = 0x1.205ec3593b46dp+4, near = 0x1.145ec3593b46dp+4;
        const Coordinates points{far, far, near, far, near, 0x1.105ec3593b46dp+4, 0x1.185ec3593b46dp+4, near, far};
        for (const double own : {0x1.3ce9a36f23c1p-88, 0x1p-60, 0x1p-140})
            for (const bool wall : {false, true}) {
                const std::vector<double> weights{own, 0.625, 1.375};
                Options options = test::all_options(votess::Box{{0, 0, 0}, {far, far, 20}});
                if (wall) options.walls = {{{1, 1, 1}, 3 * far}, {{1, 1, 0.5}, std::nextafter(far * 2 + near / 2, 99)}};
                options.weights = weights;
                CAPTURE(own);
                CAPTURE(wall);
                CHECK(test::check_right(points, options) == "");
            }
    }

    TEST_CASE("weights: the neighbors of a cluster do not depend on how small it is beside the box") {
        test::Random random(4);
        Coordinates points(1200);
        std::vector<double> weights(400);
        for (double& x : points) x = random.uniform(-1, 1);
        for (double& w : weights) w = 0.1 * random.uniform();
        const auto lists = [&](int exponent) {
            Coordinates small = points;
            std::vector<double> smaller = weights;
            for (double& x : small) x = std::ldexp(x, exponent);
            for (double& w : smaller) w = std::ldexp(w, 2 * exponent);
            Options options = test::all_options(votess::Box{{-1, -1, -1}, {1, 1, 1}});
            options.weights = smaller;
            const auto t = votess::tessellate(small, options);
            std::vector<std::vector<std::int32_t>> sorted;
            for (std::size_t i = 0; i < t.size(); ++i) {
                sorted.emplace_back(t.neighbors(i).begin(), t.neighbors(i).end());
                std::ranges::sort(sorted.back());
            }
            return sorted;
        };
        const auto expected = lists(-60);
        for (const int exponent : {-240, -266, -270, -340, -450}) {
            CAPTURE(exponent);
            CHECK(lists(exponent) == expected);
        }
    }

    TEST_CASE("weights: the heaviest of seeds nearer to each other than squares of distances reach has all") {
        const std::vector<double> weights{0.1, 0.2, 0};
        for (const int exponent : {-100, -400, -512, -520, -700, -850, -910, -1000, -1074}) {
            CAPTURE(exponent);
            const double apart = std::ldexp(1.0, exponent);
            const Coordinates points{0, 0, 0, 0, 0, apart, apart, 0, 0};
            for (const bool polygons : {false, true})
                for (const bool periodic : {false, true}) {
                    CAPTURE(polygons);
                    CAPTURE(periodic);
                    Options options = test::all_options(test::unit_box());
                    options.want.vertices = polygons;
                    options.weights = weights;
                    options.periodic = {periodic, periodic, periodic};
                    const auto t = votess::tessellate(points, options);
                    CHECK(t.stats().empty_cells == 2);
                    CHECK(t.volumes()[1] == 1);
                }
        }
    }

    TEST_CASE("weights: volumes at planes whose normals have squares without digits") {
        const double side = 13 / 64.0;
        for (int exponent = -560; exponent < -490; ++exponent) {
            CAPTURE(exponent);
            const double apart = std::ldexp(1.0, exponent);
            const Coordinates points{3 * apart, 0.5, 0.5, 15 * apart, 0.5, 0.5};
            const std::vector<double> weights{24 * side * apart, 0};
            Options options = test::all_options(test::unit_box());
            options.weights = weights;
            const auto t = votess::tessellate(points, options);
            CHECK(std::abs(t.volumes()[0] - side) <= 1e-10 * side);
        }
    }

    TEST_CASE("weights: one seed buries 20,000 others") {
        const std::size_t count = test::by_size(20'000, 2000);
        test::Random random(3);
        Coordinates points(3 * count);
        for (double& x : points) x = random.uniform();
        std::vector<double> weights(count);
        weights[count / 3] = 1e6;
        Options options = test::all_options(test::unit_box());
        options.weights = weights;
        const auto t = votess::tessellate(points, options);
        CHECK(t.stats().empty_cells == count - 1);
        CHECK(t.volumes()[count / 3] == doctest::Approx(1));
    }

    TEST_CASE("weights: minus the squared distance to 0 gives the diagram of seeds twice as far") {
        const std::size_t count = test::by_size(1500, 300);
        test::Random random(8);
        Coordinates points(3 * count), doubled;
        // Squares have no rounding.
        for (double& x : points) x = std::ldexp(static_cast<double>(random.below(1 << 20)), -20);
        for (const double x : points) doubled.push_back(2 * x);
        std::vector<double> weights;
        for (std::size_t i = 0; i < points.size(); i += 3)
            weights.push_back(-(points[i] * points[i] + points[i + 1] * points[i + 1] + points[i + 2] * points[i + 2]));
        Options options = test::all_options(test::cube(0, 2));
        const auto far = votess::tessellate(doubled, options);
        options.weights = weights;
        CHECK(test::rows_of(votess::tessellate(points, options)) == test::rows_of(far));
        // Most cells lie outside of an eighth of the box.
        options.box = test::unit_box();
        const auto t = votess::tessellate(points, options);
        CHECK(votess::verify(t, points).failure == "");
        CHECK(t.stats().empty_cells > count / 2);
    }

    TEST_CASE("weights: linear ones give the Voronoi diagram of a shifted box") {
        test::Random random(8);
        const std::size_t n = test::by_size(20000, 3000);
        Coordinates points(3 * n);
        for (double& x : points) x = random.uniform(0.3, 0.7);
        for (const double by : {0.001, 0.05, 0.2}) {  // up to 14 spacings
            CAPTURE(by);
            const std::array<double, 3> a{by, -0.7 * by, 0.3 * by};
            std::vector<double> weights(n, 7);
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t k = 0; k < 3; ++k) weights[i] += 2 * a[k] * points[3 * i + k];
            Options plain, weighted;
            plain.list_walls = weighted.list_walls = true;
            weighted.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
            weighted.weights = weights;
            plain.box = votess::Box{{a[0], a[1], a[2]}, {1 + a[0], 1 + a[1], 1 + a[2]}};
            const auto expected = votess::tessellate(points, plain), found = votess::tessellate(points, weighted);
            CHECK(std::ranges::equal(found.indptr(), expected.indptr()));
            CHECK(std::ranges::equal(found.indices(), expected.indices()));
            for (std::size_t i = 0; i < n; ++i)
                REQUIRE(std::abs(found.volumes()[i] / expected.volumes()[i] - 1) < 1e-8);
        }
    }

    // |y - q|^2 - w is y.y - 2 y.q + (T q)^2 for w = |q|^2 - |T q|^2, so y = T z is nearest to q where z is to T q.
    TEST_CASE("weights: those that bend along the axes give the Voronoi diagram of mapped seeds") {
        test::Random random(12);
        const std::size_t n = test::by_size(6000, 2000);
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Coordinates points(3 * n), mapped;
            // Without rounding, and inside of both boxes.
            for (std::size_t i = 0; i < points.size(); ++i)
                points[i] = std::ldexp(static_cast<double>(random.below(1 << 20)) - (1 << 19), i % 3 == 2 ? -20 : -21);
            constexpr std::array<double, 3> map{0.5, 1.5, 1};
            std::vector<double> weights;
            for (std::size_t i = 0; i < points.size(); i += 3) {
                weights.push_back(7);
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = points[i + k];
                    mapped.push_back(map[k] * x);
                    weights.back() += (1 - map[k] * map[k]) * x * x;
                }
            }
            Options plain, weighted;
            plain.list_walls = weighted.list_walls = true;
            plain.box = votess::Box{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
            weighted.box = votess::Box{{-0.25, -0.75, -0.5}, {0.25, 0.75, 0.5}};
            plain.periodic = weighted.periodic = {false, false, periodic};  // the weights are even along z
            weighted.weights = weights;
            const auto expected = votess::tessellate(mapped, plain), found = votess::tessellate(points, weighted);
            CHECK(std::ranges::equal(found.indptr(), expected.indptr()));
            CHECK(std::ranges::equal(found.indices(), expected.indices()));
            for (std::size_t i = 0; i < n; ++i)
                REQUIRE(std::abs(found.volumes()[i] / (0.75 * expected.volumes()[i]) - 1) < 1e-8);
        }
    }

    // 8 seconds when searches went by the heaviest weight of the domain.
    TEST_CASE("weights: waves in a periodic box") {
        test::Random random(9);
        for (const double displaced : {2, 6}) {  // spacings; the farther waves break, so that some cells are empty
            CAPTURE(displaced);
            const std::size_t n = displaced == 2 ? test::by_size(20000, 4000) : 4000;
            const double pi = 3.14159265358979, height = displaced / std::cbrt(static_cast<double>(n)) / pi;
            Coordinates points(3 * n);
            std::vector<double> weights(n);
            for (double& x : points) x = random.uniform();
            for (std::size_t i = 0; i < n; ++i)
                weights[i] = height * std::sin(2 * pi * points[3 * i]) * std::cos(2 * pi * points[3 * i + 1]);
            CHECK((empty_cells(points, weights, true) == 0) == (displaced == 2));
        }
    }

    TEST_CASE("weights: most seeds of a periodic box have no cell") {
        test::Random random(10);
        const std::size_t n = test::by_size(5000, 1000);
        Coordinates points(3 * n);
        std::vector<double> weights(n);
        for (double& x : points) x = random.uniform();
        for (double& w : weights) w = random.uniform();
        CHECK(empty_cells(points, weights, true) > n / 2);
    }

    // All planes pass through 0, so that only seeds on the convex hull have cells, with a corner there.
    TEST_CASE("weights: the squared distance to 0, in a corner of the box or inside of it") {
        test::Random random(11);
        const std::size_t n = test::by_size(200, 100);
        Coordinates points(3 * n);
        std::vector<double> weights;
        for (double& x : points) x = std::ldexp(static_cast<double>(random.below(1 << 20)), -20);
        for (std::size_t i = 0; i < points.size(); i += 3)
            weights.push_back(points[i] * points[i] + points[i + 1] * points[i + 1] + points[i + 2] * points[i + 2]);
        Options options;
        options.weights = weights;
        for (const double lower : {0., -1.}) {
            CAPTURE(lower);
            options.box = votess::Box{{lower, lower, lower}, {1, 1, 1}};
            const auto t = votess::tessellate(points, options);
            CHECK(votess::verify(t, points).failure == "");
            CHECK(t.stats().empty_cells > n / 2);
        }
    }

    // Most seeds tie with all others at the middle, up to the rounding of weights, and some have tiny cells there.
    TEST_CASE("weights: the squared distance to the middle of a periodic box, and two clusters") {
        test::Random random(12);
        const std::size_t n = test::by_size(2000, 500);
        for (const bool clustered : {false, true}) {
            CAPTURE(clustered);
            Coordinates points(3 * n);
            std::vector<double> weights(n, 0);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const double middle = !clustered ? 0.5 : i / 3 % 2 == 0 ? 0.3 : 0.8;
                points[i] = clustered ? middle + 0.02 * (random.uniform() - 0.5) : random.uniform();
                weights[i / 3] += (clustered ? -14 : 1) * (points[i] - middle) * (points[i] - middle);
            }
            for (const bool periodic : {true, false})
                CHECK((empty_cells(points, weights, periodic) > n / 2) == !clustered);
        }
    }

    // Seeds of a line whose weights tie exactly: one without a cell must not part the two beside it.
    TEST_CASE("weights: rounded ones of a lattice hide seeds exactly between others") {
        const int side = 12, step = 256;
        const auto middle = [](int k) { return (k + 0.5) / side - 0.5; };
        Coordinates points;
        std::vector<double> weights;
        for (int x = 0; x < side; ++x)
            for (int y = 0; y < side; ++y)
                for (int z = 0; z < side; ++z) {
                    for (const int k : {x, y, z}) points.push_back((k + 0.5) / side);
                    const double square = middle(x) * middle(x) + middle(y) * middle(y) + middle(z) * middle(z);
                    weights.push_back(std::round(square * step) / step);
                }
        Options options;
        options.box = test::unit_box();
        options.weights = weights;
        for (const bool periodic : {true, false}) {
            CAPTURE(periodic);
            options.periodic = {periodic, periodic, periodic};
            const auto t = votess::tessellate(points, options);
            CHECK(t.stats().empty_cells > 0);
            const auto has_cell = [&](std::int32_t j) {
                return j < 0 || t.status()[static_cast<std::size_t>(j)] == votess::CellStatus::certified;
            };
            CHECK(std::ranges::all_of(t.indices(), has_cell));
            CHECK(votess::verify(t, points).failure == "");
        }
    }
}
