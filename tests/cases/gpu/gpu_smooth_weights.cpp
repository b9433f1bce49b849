// Power diagrams with weights that vary smoothly, on a Vulkan device: the answer of the CPU, with few cells left to it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "cases/gpu/gpu_domain_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::Random;
using votess::Options;
using votess::gpu::Kernel;

constexpr double few = 0.04;  // share of cells that the device may leave to the CPU

double spacing(const Coordinates& points) {
    return 1 / std::cbrt(static_cast<double>(points.size()) / 3);
}

// Returns weights of the unit box, a sum of three waves along the axes, that displace seeds by up to this along each.
std::vector<double> waves(const Coordinates& points, double displacement) {
    constexpr double turn = 2 * std::numbers::pi;
    constexpr std::array phase{0.3, 1.7, 4.1};
    std::vector<double> weights(points.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        weights[i / 3] += 2 * displacement / turn * std::sin(turn * points[i] + phase[i % 3]);
    return weights;
}

// Returns weights 2 a.p, whose diagram is the Voronoi diagram of a box that is shifted by a.
std::vector<double> linear(const Coordinates& points, const std::array<double, 3>& a) {
    std::vector<double> weights(points.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i) weights[i / 3] += 2 * a[i % 3] * points[i];
    return weights;
}

// Compares these kernels. Returns the largest share of cells that the CPU made.
double share_left(votess::Tessellator& on_device, const Coordinates& points, const std::vector<double>& weights,
                  Options options, const std::vector<Kernel>& kernels = {Kernel::invocation, test::by_subgroup()}) {
    options.weights = weights;
    double share = 0;
    for (const Kernel kernel : kernels) {
        const test::Counts counts = test::compare_kernel(on_device, points, options, kernel);
        CHECK(counts.failure == "");
        share = std::max(share, static_cast<double>(counts.fallback) / static_cast<double>(weights.size()));
    }
    return share;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu smooth weights: waves in a periodic box and between walls") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t n = test::by_size(2000, 500);
        const Coordinates points = test::random_points(n, 1);
        for (const bool periodic : {true, false})
            for (const double spacings : {0.5, 1.0}) {
                if (spacings == 1 && n < 1000) continue;  // the waves are as short as the cells are large
                CAPTURE(periodic);
                CAPTURE(spacings);
                Options options = test::domain_options();
                options.periodic = {periodic, periodic, periodic};
                const double left = share_left(on_device, points, waves(points, spacings * spacing(points)), options);
                CHECK(left <=
                      (periodic && spacings == 1 ? 0.12 : few));  // far images are hardly lighter than near ones
            }
    }

    TEST_CASE("gpu smooth weights: linear ones give the Voronoi diagram of a shifted box") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t n = test::by_size(1500, 500);
        const Coordinates points = test::random_points(n, 2, 0.35, 0.65);
        for (const double length : {0.01, 0.1, 0.35}) {
            CAPTURE(length);
            const std::array<double, 3> a{0.6 * length, -0.5 * length, 0.62 * length};
            Options options = test::domain_options();
            for (std::size_t k = 0; k < 3; ++k) {
                options.box->lower[k] = -a[k];
                options.box->upper[k] = 1 - a[k];
            }
            CHECK(share_left(on_device, points, linear(points, a), options) <= few);
            Options shifted = test::domain_options();
            const auto voronoi = votess::tessellate(points, shifted);
            const auto weights = linear(points, a);
            options.weights = weights;
            options.device = test::device_name();
            const auto power = on_device.tessellate(points, options);
            CHECK(std::ranges::equal(power.indptr(), voronoi.indptr()));
            CHECK(std::ranges::equal(power.indices(), voronoi.indices()));
        }
    }

    TEST_CASE("gpu smooth weights: with noise, a heavy seed, several at a place, in double precision") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t n = test::by_size(2000, 400);
        Coordinates points = test::random_points(n, 3);
        const double h = spacing(points);
        Options options = test::domain_options();
        options.periodic = {true, true, true};
        Random random(4);
        std::vector<double> weights = waves(points, 0.4 * h);
        for (double& w : weights) w += random.uniform(0, 0.3 * h * h);
        CHECK(share_left(on_device, points, weights, options) <= 2 * few);
        weights[n / 3] += 25 * h * h;
        CHECK(share_left(on_device, points, weights, options) <= 4 * few);  // its neighbors are large
        for (std::size_t i = 0; i < n / 10; ++i) {
            std::copy_n(points.begin() + static_cast<std::ptrdiff_t>(6 * i), 3,
                        points.begin() + static_cast<std::ptrdiff_t>(6 * i + 3));
            weights[2 * i + 1] = weights[2 * i] + random.uniform(-0.1, 0.1) * h * h;
        }
        share_left(on_device, points, weights, options);
        points = test::random_points(n, 5);
        options.precision = test::double_precision();
        CHECK(share_left(on_device, points, waves(points, 0.4 * h), options, {Kernel::invocation}) < 0.3);
    }

    TEST_CASE("gpu smooth weights: walls of any direction, triclinic boxes, slabs, few seeds") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t n = test::by_size(1000, 300);
        const Coordinates points = test::random_points(n, 6);
        const double h = spacing(points);
        Options options = test::domain_options();
        options.outside = votess::Outside::drop;
        options.walls = {{{1, 0.3, 0.2}, 0.9}, {{-1, 0.5, -0.7}, 0.1}};
        CHECK(share_left(on_device, points, linear(points, {2 * h, -h, h}), options) <= few);
        options.walls = votess::sphere_walls({0.5, 0.5, 0.5}, 0.4, 60);
        CHECK(share_left(on_device, points, waves(points, h), options) <= few);
        for (const bool periodic : {false, true}) {
            Options triclinic = test::domain_options();
            triclinic.box.reset();
            triclinic.outside = votess::Outside::drop;
            triclinic.cell = votess::TriclinicBox{
                {0, 0, 0}, {0.9, 0.1, 0}, {0.2, 1.1, 0.1}, {-0.1, 0.2, 1}, {periodic, periodic, periodic}};
            const double left = share_left(on_device, points, linear(points, {h, h, -h}), triclinic);
            if (!periodic) CHECK(left <= few);
        }
        options = test::domain_options();
        options.periodic = {true, false, true};
        options.box->upper[2] = 1.25;  // the period is not the longest side, and images begin beyond it
        for (const std::size_t seeds : {9, 40, 65, 500}) {
            const Coordinates some = test::random_points(seeds, seeds);
            share_left(on_device, some, waves(some, 0.3 * spacing(some)), options);
        }
    }
}
