// fit_volumes(): each cell gets its volume. The tests of Python have the exact cases and other domains.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>
#include <votess/fit.hpp>

#include "fit/laplacian.hpp"
#include "fit/revive.hpp"
#include "input/domain_of_result.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"

namespace {

using votess::ErrorCode;
using votess::FitError;
using votess::FitOptions;
using votess::Options;

struct Grains {
    std::vector<double> points, targets;
    Options options;
};

// In the unit box, with volumes that differ by up to a hundred.
Grains grains(std::size_t count, bool periodic) {
    test::Random random(count);
    Grains made;
    made.options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
    made.options.periodic = {periodic, periodic, periodic};
    made.options.device = "cpu";
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) made.points.push_back(random.uniform());
        made.targets.push_back(std::exp(0.6 * random.gaussian()));
        sum += made.targets.back();
    }
    for (double& target : made.targets) target /= sum;
    return made;
}

double largest_error(std::span<const double> volumes, std::span<const double> targets) {
    double error = 0;
    for (std::size_t i = 0; i < targets.size(); ++i) error = std::max(error, std::abs(volumes[i] / targets[i] - 1));
    return error;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("fit: volumes of another tessellation, for any number of threads") {
        for (const bool periodic : {false, true}) {
            Grains g = grains(test::by_size(3000, 300), periodic);
            g.options.want.centroids = true;
            g.options.threads = 1;
            const votess::VolumeFit fit = votess::fit_volumes(g.points, g.targets, g.options);
            CHECK(fit.residual <= 1e-9);
            CHECK(fit.tessellation.centroids().size() == g.points.size());
            CHECK(std::ranges::equal(fit.tessellation.weights(), fit.weights));
            CHECK(fit.seconds.total >= fit.seconds.tessellate + fit.seconds.assemble + fit.seconds.solve);
            Options again = g.options;
            again.weights = fit.weights;
            CHECK(largest_error(votess::tessellate(g.points, again).volumes(), g.targets) < 1.001e-9);
            g.options.threads = 3;
            CHECK(std::ranges::equal(votess::fit_volumes(g.points, g.targets, g.options).weights, fit.weights));
        }
    }

    TEST_CASE("fit: clusters, for any number of threads") {
        Grains g = grains(test::by_size(3000, 600), true);
        const double count = static_cast<double>(g.targets.size());
        test::Random random(7);
        for (std::size_t k = 0; k < g.points.size(); ++k) {
            // One coordinate of each of 30 centers comes from the first 30 points.
            const double x = g.points[k % 90] + 0.02 * random.gaussian();
            if (k >= 90) g.points[k] = x - std::floor(x);
        }
        std::ranges::fill(g.targets, 1 / count);
        g.options.threads = 1;
        const votess::VolumeFit fit = votess::fit_volumes(g.points, g.targets, g.options);
        CHECK(largest_error(fit.tessellation.volumes(), g.targets) < 1.001e-9);
        CHECK(fit.tessellations <= 15);
        g.options.threads = 3;
        CHECK(std::ranges::equal(votess::fit_volumes(g.points, g.targets, g.options).weights, fit.weights));
    }

    // Steps from the cells without weights were short: 11 for 1,000 seeds, 18 for 16,000.
    TEST_CASE("fit: seeds in tight clusters take as few steps as others, however many") {
        for (const bool planar : {false, true})
            for (const std::size_t count : {400, 1600}) {
                CAPTURE(planar);
                CAPTURE(count);
                test::Random random(8);
                const std::size_t dimensions = planar ? 2 : 3;
                test::Coordinates centers, points;
                for (std::size_t k = 0; k < 8 * dimensions; ++k) centers.push_back(random.uniform(0.1, 0.9));
                for (std::size_t i = 0; i < count; ++i) {
                    const std::size_t cluster = random.below(8);
                    for (std::size_t k = 0; k < dimensions; ++k)
                        points.push_back(centers[cluster * dimensions + k] + 1e-3 * random.gaussian());
                }
                const std::vector<double> targets(count, 1 / static_cast<double>(count));
                votess::FitOptions tolerance;
                tolerance.tolerance = 1e-6;
                Options options;
                options.device = "cpu";
                options.box = test::unit_box();
                options.planar = planar;
                if (planar) options.box->lower[2] = options.box->upper[2] = 0;
                const auto fit = votess::fit_volumes(points, targets, options, tolerance);
                CHECK(fit.steps <= 8);
                // The result keeps the cells of the last step.
                CHECK(fit.tessellation.stats().kept_cells > 9 * count / 10);
                options.weights = fit.weights;
                CHECK(test::check_identical(fit.tessellation, votess::tessellate(points, options)) == "");
                CHECK(largest_error(fit.tessellation.volumes(), targets) < 1.001e-6);
                const double sum = std::accumulate(fit.weights.begin(), fit.weights.end(), 0.0);
                CHECK(std::abs(sum) < 1e-12 * static_cast<double>(count));
            }
    }

    TEST_CASE("fit: empty cells are revived, with less weight for smaller targets") {
        const Grains g = grains(300, true);
        Options options = g.options;
        options.want.areas = options.want.centroids = true;
        const votess::Tessellation before = votess::tessellate(g.points, options);
        const std::vector<double> places = votess::wrapped_points(before, g.points);
        const votess::fit::Edges edges = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        const std::array<Eigen::Index, 3> emptied = {10, 120, 290};
        votess::fit::Vector weights = votess::fit::Vector::Zero(300);
        weights(emptied).setConstant(-0.1);
        options.weights = {weights.data(), 300};
        const votess::Tessellation after = votess::tessellate(g.points, options);
        CHECK(after.stats().empty_cells == 3);
        const votess::fit::Vector volumes = Eigen::Map<const votess::fit::Vector>(after.volumes().data(), 300);
        const auto revived = [&](double target, int attempt) {
            const votess::fit::Vector targets = votess::fit::Vector::Constant(300, target), least = 1e-4 * targets;
            votess::fit::Vector raised = weights;
            votess::fit::revive({places, edges, targets, before, after, volumes, after.centroids(), least}, attempt,
                                raised);
            return raised;
        };
        const votess::fit::Vector full = revived(1.0 / 300, 0), some = revived(1e-6, 0);
        for (Eigen::Index i = 0; i < 300; ++i) {
            const bool was_empty = std::ranges::count(emptied, i) > 0;
            CHECK((full[i] > some[i] && some[i] > weights[i]) == was_empty);
            CHECK((full[i] == weights[i]) == !was_empty);
        }
        CHECK(revived(1e-6, 3) == full);
        options.weights = {full.data(), 300};
        const votess::Tessellation again = votess::tessellate(g.points, options);
        for (const Eigen::Index i : emptied) CHECK(again.volumes()[static_cast<std::size_t>(i)] > 0.1 / 300);
    }

    TEST_CASE("fit: an error has the best weights so far, from which another fit goes on") {
        const Grains g = grains(300, true);
        std::vector<double> best;
        try {
            (void)votess::fit_volumes(g.points, g.targets, g.options, FitOptions{.max_steps = 2});
            FAIL("2 steps were enough");
        } catch (const FitError& error) {
            CHECK(error.code() == ErrorCode::not_converged);
            CHECK(error.steps() == 2);
            best = error.weights();
            Options options = g.options;
            options.weights = best;
            const double at = largest_error(votess::tessellate(g.points, options).volumes(), g.targets);
            CHECK(at == doctest::Approx(error.residual()).epsilon(1e-9));
            CHECK(votess::fit_volumes(g.points, g.targets, options).residual <= 1e-9);
        }
    }

    TEST_CASE("fit: an error says that more steps do not help, where float64 has no such weights") {
        const double next = std::nextafter(0.5, 1.0);  // two seeds are one bit apart
        const std::vector<double> points{0.5, 0.5, 0.5, next, 0.5, 0.5, 0.9, 0.1, 0.5, 0.1, 0.2, 0.3};
        const std::vector<double> targets{0.3, 0.35, 0.3, 0.05};
        Options options;
        options.box = test::cube(0, 1);
        for (std::size_t first = 0; first < 4; ++first) {  // the place of the pair
            std::vector<double> turned = points, turned_targets = targets;
            std::ranges::rotate(turned, turned.end() - static_cast<std::ptrdiff_t>(3 * first));
            std::ranges::rotate(turned_targets, turned_targets.end() - static_cast<std::ptrdiff_t>(first));
            std::string message;
            const auto fit = [&] { (void)votess::fit_volumes(turned, turned_targets, options, {.max_steps = 100}); };
            CHECK(test::error_of(fit, &message) == ErrorCode::not_converged);
            // Rounding decides which of the two is worse.
            const auto names = [&](std::size_t i, std::size_t j) {
                const std::string pair = std::to_string(i % 4) + ", " + std::to_string(j % 4);
                return message.find("at points " + pair + " and 2 others: the last ") != std::string::npos;
            };
            CAPTURE(message);
            CHECK((names(first, first + 1) || names(first + 1, first)));
        }
        CHECK_THROWS_WITH_AS((void)votess::fit_volumes(points, targets, options, {.max_steps = 5}),
                             doctest::Contains("raise FitOptions::max_steps"), FitError);
    }

    TEST_CASE("fit: weights at the start as radii") {
        Grains g = grains(300, false);
        std::vector<double> radii(300, 0.5);
        g.options.radii = radii;
        const votess::VolumeFit fit = votess::fit_volumes(g.points, g.targets, g.options);
        double sum = 0;
        for (const double weight : fit.weights) sum += weight;
        CHECK(sum / 300 == doctest::Approx(0.25));
        CHECK(largest_error(fit.tessellation.volumes(), g.targets) < 1.001e-9);
    }

    // The power diagram of points p with weights w is that of t p with the weights t w - t (1 - t) |p|^2.
    TEST_CASE("fit: points outside have the cells of points inside, moved towards the middle") {
        const double t = 0.25;
        Grains inside = grains(test::by_size(1000, 200), false);
        inside.options.box = votess::Box{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
        inside.options.want.centroids = true;
        for (double& x : inside.points) x -= 0.5;
        Grains outside = inside;
        outside.options.outside = votess::Outside::keep;
        for (double& x : outside.points) x /= t;
        for (const bool walls : {false, true}) {
            if (walls) outside.options.walls = {{{1, 1, 1}, 0.25}};
            const auto fit = votess::fit_volumes(outside.points, outside.targets, outside.options, {.normalize = true});
            CHECK(fit.residual <= 1e-9);
            std::vector<double> weights;
            for (std::size_t i = 0; i < fit.weights.size(); ++i) {
                double square = 0;
                for (std::size_t k = 0; k < 3; ++k) square += std::pow(outside.points[3 * i + k], 2);
                weights.push_back(t * fit.weights[i] - t * (1 - t) * square);
            }
            Options options = outside.options;
            options.weights = weights;
            const votess::Tessellation moved = votess::tessellate(inside.points, options);
            CHECK(largest_error(moved.volumes(), fit.tessellation.volumes()) < 1e-9);
            for (std::size_t i = 0; i < inside.points.size(); ++i)
                CHECK(std::abs(moved.centroids()[i] - fit.tessellation.centroids()[i]) < 1e-9);
        }
    }

    TEST_CASE("fit: parts of a mesh that no cell connects share their volume, with all seeds in one of them") {
        const test::Solid solid =
            test::joined(test::cuboid({0, 0, 0}, {1, 1, 1}), test::cuboid({1.5, 0, 0}, {2, 0.5, 0.5}));
        for (const double last : {1.0, 1.5}) {  // the last 10 seeds: in the same part, or beyond the gap
            Grains g = grains(50, false);
            for (std::size_t i = 40; i < 50 && last > 1; ++i) {
                g.points[3 * i] = last + 0.5 * g.points[3 * i];
                for (std::size_t k = 1; k < 3; ++k) g.points[3 * i + k] *= 0.5;
            }
            g.options.box.reset();
            g.options.mesh = solid.mesh();
            const votess::VolumeFit fit = votess::fit_volumes(g.points, g.targets, g.options, {.normalize = true});
            CHECK(fit.steps <= 25);
            try {  // steps upward may empty cells, but no error does
                (void)votess::fit_volumes(g.points, g.targets, g.options, {.max_steps = 4, .normalize = true});
                FAIL("4 steps were enough");
            } catch (const FitError& error) {
                const std::vector<double> best = error.weights();
                Options options = g.options;
                options.weights = best;
                CHECK(std::ranges::min(votess::tessellate(g.points, options).volumes()) > 0);
            }
            for (double& target : g.targets) target *= 1.125;
            CHECK(largest_error(fit.tessellation.volumes(), g.targets) < 1.001e-9);
        }
    }

    TEST_CASE("fit: two seeds in two parts of a mesh, whose cells touch nowhere") {
        const test::Solid solid = test::joined(test::cuboid({0, 0, 0}, {1, 1, 1}), test::cuboid({2, 0, 0}, {3, 1, 1}));
        Options options;
        options.mesh = solid.mesh();
        const std::vector<double> points{0.5, 0.5, 0.5, 2.5, 0.5, 0.5}, targets{0.75, 1.25};
        const votess::VolumeFit fit = votess::fit_volumes(points, targets, options);
        CHECK(fit.weights[1] - fit.weights[0] == doctest::Approx(3));  // they meet at x = 0.75
    }

    TEST_CASE("fit: masses under an image, half of which is black, for any number of threads") {
        Grains g = grains(400, false);
        std::vector<double> flat, pixels(16 * 12);
        for (std::size_t i = 0; i < 400; ++i) flat.insert(flat.end(), &g.points[3 * i], &g.points[3 * i] + 2);
        for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = i / 12 < 8 ? 0 : 1 + static_cast<double>(i % 12);
        const votess::Density image{{16, 12, 1}, pixels};
        g.options.planar = true;
        g.options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
        g.options.want.faces = true;
        FitOptions under;
        under.normalize = true;
        under.density = image;
        g.options.threads = 1;
        const votess::VolumeFit fit = votess::fit_volumes(flat, g.targets, g.options, under);
        CHECK(fit.steps <= 25);
        const votess::Masses of = votess::masses(fit.tessellation, image, 3);
        double sum = 0;
        for (const double pixel : pixels) sum += pixel / static_cast<double>(pixels.size());
        for (std::size_t i = 0; i < 400; ++i) {
            CHECK(std::abs(of.masses[i] / (g.targets[i] * sum) - 1) < 1.001e-9);
            CHECK(of.centroids[2 * i] > 0.5);
        }
        g.options.threads = 3;
        CHECK(std::ranges::equal(votess::fit_volumes(flat, g.targets, g.options, under).weights, fit.weights));
        under.density = votess::Density{{16, 12, 2}, pixels};
        std::string message;
        CHECK(test::error_of([&] { (void)votess::fit_volumes(flat, g.targets, g.options, under); }, &message) ==
              ErrorCode::invalid_argument);
        CHECK(message.find("shape[2] = 2: give 1 in two dimensions") != std::string::npos);
    }

    TEST_CASE("fit: dropped points have no goal") {
        Grains g = grains(300, false);
        g.options.box = votess::Box{{0, 0, 0}, {1, 1, 0.7}};
        g.options.outside = votess::Outside::drop;
        Grains rest;
        rest.options = g.options;
        std::vector<std::size_t> kept;
        for (std::size_t i = 0; i < g.targets.size(); ++i) {
            if (g.points[3 * i + 2] > 0.7) {
                g.targets[i] = -1;
                continue;
            }
            kept.push_back(i);
            rest.points.insert(rest.points.end(), &g.points[3 * i], &g.points[3 * i] + 3);
            rest.targets.push_back(g.targets[i]);
        }
        const auto all = votess::fit_volumes(g.points, g.targets, g.options, {.normalize = true});
        const auto some = votess::fit_volumes(rest.points, rest.targets, rest.options, {.normalize = true});
        for (std::size_t k = 0; k < kept.size(); ++k) CHECK(all.weights[kept[k]] == some.weights[k]);
        CHECK(kept.size() < all.weights.size());
        CHECK(std::ranges::count(all.tessellation.status(), votess::CellStatus::outside) ==
              std::ssize(g.targets) - std::ssize(kept));
    }

    TEST_CASE("fit: refused input") {
        const Grains g = grains(20, false);
        const auto refusal = [&](const Grains& bad, const FitOptions& fit = {}) {
            std::string message;
            CHECK(test::error_of([&] { (void)votess::fit_volumes(bad.points, bad.targets, bad.options, fit); },
                                 &message) == ErrorCode::invalid_argument);
            return message;
        };
        Grains bad = g;
        bad.targets[7] = 0;
        CHECK(refusal(bad).find("point 7 is 0") != std::string::npos);
        bad.targets.pop_back();
        CHECK(refusal(bad).find("19 target volumes for 20 points") != std::string::npos);
        bad = g;
        bad.targets[7] *= 1.001;
        CHECK(refusal(bad).find("normalize") != std::string::npos);
        bad = g;
        bad.points[4] = 1.5;
        CHECK(refusal(bad).find("point 1: y = 1.5 is outside the box") != std::string::npos);
        for (double& x : bad.points) x += 1;
        bad.options.outside = votess::Outside::drop;
        CHECK(refusal(bad).find("all points are outside") != std::string::npos);
        bad = g;
        std::copy_n(bad.points.begin() + 9, 3, bad.points.begin() + 30);
        CHECK(refusal(bad).find("point 10") != std::string::npos);
        CHECK(refusal(g, FitOptions{.tolerance = -1}).find("FitOptions::tolerance is -1") != std::string::npos);
    }

    TEST_CASE("fit: the derivatives are those of volumes, and the solver solves with them") {
        const Grains g = grains(700, true);  // three levels of the preconditioner
        Options options = g.options;
        options.want.areas = true;
        const votess::Tessellation t = votess::tessellate(g.points, options);
        votess::fit::Matrix matrix;
        votess::fit::set_laplacian(t, t.face_areas(), votess::wrapped_points(t, g.points),
                                   {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, matrix);
        CHECK(matrix.rows() == 700);

        test::Random random(1);
        std::vector<double> weights(700), before(700);
        for (std::size_t i = 0; i < 700; ++i) weights[i] = 1e-7 * (random.uniform() - 0.5), before[i] = -weights[i];
        Options moved = g.options;
        moved.weights = weights;
        const votess::Tessellation after = votess::tessellate(g.points, moved);
        moved.weights = before;
        const votess::Tessellation other = votess::tessellate(g.points, moved);
        const votess::fit::Vector change = matrix * Eigen::Map<const votess::fit::Vector>(weights.data(), 700);
        for (std::size_t i = 0; i < 700; ++i) {
            CHECK(std::abs((after.volumes()[i] - other.volumes()[i]) / 2 - change[static_cast<Eigen::Index>(i)]) <
                  1e-4 * change.lpNorm<Eigen::Infinity>());
        }

        votess::fit::Vector right = votess::fit::Vector::LinSpaced(700, -1, 1).array().cube();
        right.array() -= right.mean();
        const votess::fit::Vector x = votess::fit::solve(matrix, right, 1e-12);
        CHECK((matrix * x - right).norm() < 1e-10 * right.norm());
        CHECK(std::abs(x.mean()) < 1e-12 * x.norm());
    }
}
