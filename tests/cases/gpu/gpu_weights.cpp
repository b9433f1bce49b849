// Power diagrams on a Vulkan device: the answer of the CPU and of exact half-spaces, with few cells left to the CPU.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "cases/gpu/gpu_domain_cases.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::Random;
using votess::Options;
using votess::gpu::Kernel;

struct Seeds {
    Coordinates points;
    std::vector<double> weights;
};

// Returns uniform seeds in the unit cube with radii up to `largest`.
Seeds balls(std::size_t n, double largest, std::uint64_t seed) {
    Random random(seed);
    Seeds seeds;
    for (std::size_t i = 0; i < 3 * n; ++i) seeds.points.push_back(random.uniform());
    for (std::size_t i = 0; i < n; ++i) seeds.weights.push_back(std::pow(random.uniform(0, largest), 2));
    return seeds;
}

Options power_options() {
    Options options = test::all_options(test::unit_box());
    options.want.centroids = options.want.areas = true;
    return options;
}

struct Outcome {
    std::string failure;
    double left = 0;  // share of the cells that the CPU made
    std::uint64_t empty = 0;
};

// Compares these kernels. Returns the largest share.
Outcome compare(votess::Tessellator& on_device, const Seeds& seeds, Options options,
                const std::vector<Kernel>& kernels = {Kernel::invocation, test::by_subgroup()}) {
    options.weights = seeds.weights;
    Outcome outcome;
    for (const Kernel kernel : kernels) {
        const test::Counts counts = test::compare_kernel(on_device, seeds.points, options, kernel);
        if (outcome.failure.empty()) outcome.failure = counts.failure;
        outcome.left =
            std::max(outcome.left, static_cast<double>(counts.fallback) / static_cast<double>(seeds.weights.size()));
        outcome.empty = counts.empty;
    }
    return outcome;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu weights: radii below the spacing and far above are clipped on the device") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1500, 400);
        for (const double largest : {0.05, 1.0})
            for (const bool periodic : {false, true}) {
                Options options = power_options();
                options.periodic = {periodic, periodic, periodic};
                CAPTURE(largest);
                CAPTURE(periodic);
                const Outcome outcome = compare(on_device, balls(many, largest, 1), options);
                CHECK(outcome.failure == "");
                CHECK((largest < 1 || outcome.empty > many / 2));
                CHECK(outcome.left <= (largest < 1 ? 0.03 : 0.2));  // the few large cells of a periodic box reach far
                if (!periodic) CHECK(outcome.left <= 0.03);
            }
    }

    TEST_CASE("gpu weights: in both precisions, with an offset, negative, equal, in units far from one") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1000, 200);
        const auto share = [&](const Seeds& seeds, const Options& options) {
            const Outcome outcome = compare(on_device, seeds, options, {Kernel::invocation});
            CHECK(outcome.failure == "");
            return outcome.left;
        };
        Options options = power_options();
        options.precision = test::double_precision();
        CHECK(share(balls(many, 0.1, 2), options) < 0.2);
        options.precision = votess::Precision::single;
        Seeds seeds = balls(many, 0.1, 3);
        for (double& w : seeds.weights) w += 1e6;
        CHECK(share(seeds, options) < 0.03);
        for (double& w : seeds.weights) w = -w;
        CHECK(share(seeds, options) < 0.03);
        std::ranges::fill(seeds.weights, -7.0);
        CHECK(share(seeds, options) < 0.03);
        for (const double scale : {1e-10, 1e10}) {
            seeds = balls(many, 0.1, 4);
            for (double& x : seeds.points) x *= scale;
            for (double& w : seeds.weights) w *= scale * scale;
            options.box = test::cube(0, scale);
            CHECK(share(seeds, options) < 0.03);
        }
    }

    TEST_CASE("gpu weights: one heavy seed, clusters, half of the seeds buried") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1000, 300);
        const Options options = power_options();
        Seeds seeds = balls(many, 0.02, 5);
        seeds.weights[many / 2] = 0.2;
        Outcome outcome = compare(on_device, seeds, options);
        CHECK(outcome.failure == "");
        CHECK(outcome.left <= 0.03);
        seeds.weights[many / 2] = 1e9;  // buries all others
        outcome = compare(on_device, seeds, options);
        CHECK(outcome.failure == "");
        CHECK(outcome.empty == many - 1);
        CHECK(outcome.left <= 0.03);
        seeds = balls(400, 0.02, 6);
        for (std::size_t i = 0; i < 400; i += 2) seeds.weights[i] += 0.05;
        outcome = compare(on_device, seeds, options);
        CHECK(outcome.failure == "");
        CHECK(outcome.empty > 150);
        CHECK(outcome.left <= 0.03);
        Random random(7);
        for (std::size_t i = 0; i < 400; ++i) {
            const double size = std::ldexp(1.0, -static_cast<int>(random.below(12)));
            for (std::size_t k = 0; k < 3; ++k) seeds.points[3 * i + k] = 0.4 + 0.5 * size * random.uniform();
            seeds.weights[i] = 1e-3 * size * size * random.uniform();
        }
        CHECK(compare(on_device, seeds, options).failure == "");
    }

    TEST_CASE("gpu weights: whole weights on a grid, and several seeds at a place") {
        votess::Tessellator& on_device = test::shared_tessellator();
        Options options = power_options();
        options.box = test::cube(-0.5, 5.5);
        Random random(8);
        Seeds seeds;
        for (int i = 0; i < 216; ++i) {
            seeds.points.insert(seeds.points.end(), {1.0 * (i % 6), 1.0 * (i / 6 % 6), 1.0 * (i / 36)});
            seeds.weights.push_back(static_cast<double>(random.below(3)));
        }
        CHECK(compare(on_device, seeds, options).failure == "");
        for (int i = 0; i < 60; ++i) {  // lighter, equal and heavier seeds, before and after
            const std::size_t of = random.below(seeds.weights.size());
            for (std::size_t k = 0; k < 3; ++k) seeds.points.push_back(seeds.points[3 * of + k]);
            seeds.weights.push_back(static_cast<double>(random.below(3)));
        }
        CHECK(compare(on_device, seeds, options).failure == "");
        for (double& w : seeds.weights) w = w / 3 + 1e-9 * static_cast<double>(random.below(2));  // not whole numbers
        CHECK(compare(on_device, seeds, options).failure == "");
    }

    TEST_CASE("gpu weights: walls of any direction, and triclinic boxes with walls") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1000, 300);
        const auto share = [&](const Seeds& seeds, const Options& options) {
            const Outcome outcome = compare(on_device, seeds, options);
            CHECK(outcome.failure == "");
            return outcome.left;
        };
        Options options = power_options();
        options.outside = votess::Outside::drop;
        options.walls = {{{1, 0.3, 0.2}, 0.9}, {{-1, 0.5, -0.7}, 0.1}};
        for (const double largest : {0.05, 0.5}) CHECK(share(balls(many, largest, 11), options) <= 0.03);
        Seeds seeds = balls(many, 0.05, 12);
        options.walls = votess::sphere_walls({0.5, 0.5, 0.5}, 0.4, 60);
        seeds.weights[many / 3] = 0.1;  // it cuts off many cells
        CHECK(share(seeds, options) <= 0.03);
        for (const bool periodic : {false, true}) {
            Options triclinic = power_options();
            triclinic.box.reset();
            triclinic.outside = votess::Outside::drop;
            triclinic.cell = votess::TriclinicBox{
                {0, 0, 0}, {0.9, 0.1, 0}, {0.2, 1.1, 0.1}, {-0.1, 0.2, 1}, {periodic, false, periodic}};
            CHECK(share(balls(many / 2, 0.1, 13), triclinic) <= (periodic ? 0.2 : 0.03));
        }
    }

    TEST_CASE("gpu weights: a dropped seed is heavier than the others may be") {
        votess::Tessellator& on_device = test::shared_tessellator();
        Options options = power_options();
        options.outside = votess::Outside::drop;
        Seeds seeds = balls(100, 0.1, 14);
        seeds.points[30] = 1.5;
        seeds.weights[10] = 1000;
        for (const bool walls : {false, true}) {
            if (walls) options.walls = {{{1, 0.2, 0.1}, 1.1}};
            options.weights = seeds.weights;
            const test::Counts counts = test::compare_domain(on_device, seeds.points, options);
            CHECK(counts.failure == "");
            CHECK(counts.fallback <= 3);
        }
    }

    TEST_CASE("gpu weights: exact half-spaces have the same faces") {
        votess::Tessellator& on_device = test::shared_tessellator();
        for (const bool periodic : {false, true})
            for (const double largest : {0.2, 0.5}) {
                Options options = power_options();
                options.periodic = {periodic, false, periodic};
                if (!periodic) options.walls = {{{1, 1, 1}, 2.9}, {{-0.3, 1, 0.2}, 1.1}};
                options.outside = votess::Outside::drop;
                const Seeds seeds = balls(periodic ? 6 : 20, largest, 9);
                options.weights = seeds.weights;
                options.device = test::device_name();
                CHECK(test::check_against_half_spaces(on_device.tessellate(seeds.points, options), seeds.points,
                                                      options) == "");
            }
    }

    TEST_CASE("gpu weights: parts, and polytopes from the lists of the device") {
        const test::SharedGpu shared;
        const Seeds seeds = balls(test::by_size(2000, 400), 0.1, 10);
        Options options = power_options();
        options.weights = seeds.weights;
        const auto cpu = votess::tessellate(seeds.points, options);
        test::PointSet set;
        set.points = seeds.points;
        set.box = test::unit_box();
        for (const bool faces : {false, true}) {
            test::GpuRunner runner(shared.gpu, {.max_seeds = faces ? 0 : static_cast<std::uint32_t>(cpu.size() / 2)});
            options.want.faces = faces;
            const auto result = runner.run(set, options);
            CHECK(test::check_same(result, cpu, seeds.points, test::tolerance(options)) == "");
            if (faces) CHECK(votess::verify(result, seeds.points).failure == "");
        }
    }

    TEST_CASE("gpu weights: a heavy seed that is not among the seeds of most parts") {
        const test::SharedGpu shared;
        Seeds seeds = balls(test::by_size(2000, 400), 0.05, 15);
        std::fill_n(seeds.points.begin(), 3, 0.95);
        seeds.weights[0] = 0.5;
        Options options = power_options();
        options.weights = seeds.weights;
        const auto cpu = votess::tessellate(seeds.points, options);
        test::PointSet set;
        set.points = seeds.points;
        set.box = test::unit_box();
        test::GpuRunner runner(shared.gpu, {.max_seeds = static_cast<std::uint32_t>(cpu.size() / 4)});
        CHECK(test::check_same(runner.run(set, options), cpu, seeds.points, test::tolerance(options)) == "");
    }
}
