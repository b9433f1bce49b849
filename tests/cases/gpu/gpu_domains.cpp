// Domains on a Vulkan device have the CPU's answer.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>
#include <votess/votess.hpp>

#include "cases/gpu/gpu_domain_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"

namespace {

using test::Coordinates;
using test::Counts;
using test::domain_options;
using test::random_points;
using votess::Options;

Counts compare(votess::Tessellator& on_device, const Coordinates& points, const Options& options) {
    return test::compare_domain(on_device, points, options);
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu domains: periodic boxes are clipped on the device") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1500, 300);
        for (std::size_t mask = 1; mask < 8; mask += test::by_size(1, 3)) {
            Options options = domain_options();
            for (unsigned k = 0; k < 3; ++k) options.periodic[k] = ((mask >> k) & 1) != 0;
            CAPTURE(mask);
            const Counts counts = compare(on_device, random_points(many, mask), options);
            CHECK(counts.failure == "");
            CHECK(counts.fallback < many / 4);
            CHECK(compare(on_device, random_points(1, mask), options).failure == "");
            CHECK(compare(on_device, random_points(6, mask, -3, 3), mask == 7 ? options : [&] {
                      Options wide = options;
                      wide.box = test::cube(-3, 3);
                      return wide;
                  }()).failure == "");
        }
    }

    TEST_CASE("gpu domains: triclinic boxes, lengths that are no doubles, lattices") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(2000, 300);
        Options options = domain_options();
        options.box.reset();
        options.cell = votess::TriclinicBox{{0.1, 0.2, 0.3}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}};
        CHECK(compare(on_device, random_points(many, 1), options).failure == "");
        options.cell = votess::TriclinicBox{{0, 0, 0}, {20, 0, 0}, {9, 1, 0}, {-9, 0.45, 1}};
        CHECK(compare(on_device, random_points(many, 2, 0, 20), options).failure == "");
        options = domain_options();
        options.periodic = {true, true, true};
        options.box = votess::Box{{-0.1, 0.3, 1e-3}, {0.7, 1.1, 0.9}};
        CHECK(compare(on_device, random_points(many, 3, -2, 2), options).failure == "");
        Coordinates lattice;
        for (int i = 0; i < 512; ++i) lattice.insert(lattice.end(), {(i % 8) / 8.0, (i / 8 % 8) / 8.0, (i / 64) / 8.0});
        options.box = test::unit_box();
        CHECK(compare(on_device, lattice, options).failure == "");
    }

    TEST_CASE("gpu domains: triclinic boxes that are periodic along some edges") {
        votess::Tessellator& on_device = test::shared_tessellator();
        Options options = domain_options();
        options.box.reset();
        options.cell = votess::TriclinicBox{{-1, -1, -1}, {3, 0.1, 0}, {0.4, 3, 0.2}, {-0.3, 0.2, 3}};
        for (unsigned mask = 0; mask < 7; ++mask) {
            options.cell->periodic = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
            CAPTURE(mask);
            CHECK(compare(on_device, random_points(test::by_size(500, 100), 10 + mask), options).failure == "");
        }
    }

    TEST_CASE("gpu domains: polytopes of periodic cells") {
        Options options = domain_options();
        options.periodic = {true, true, false};
        options.want.faces = options.want.normals = true;
        const Coordinates points = random_points(test::by_size(2000, 300), 4);
        const auto cpu = votess::tessellate(std::span<const double>(points), options);
        options.device = test::device_name();
        const auto gpu = test::shared_tessellator().tessellate(std::span<const double>(points), options);
        CHECK(std::ranges::equal(cpu.face_vertices(), gpu.face_vertices()));
        CHECK(std::ranges::equal(cpu.cell_vertex_indices(), gpu.cell_vertex_indices()));
        CHECK(votess::verify(gpu, points).failure == "");
    }

    TEST_CASE("gpu domains: dropped seeds are not neighbors") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1000, 200);
        Options options = domain_options();
        options.outside = votess::Outside::drop;
        for (const bool repeats : {false, true}) {
            options.periodic = {repeats, false, repeats};
            Coordinates points = random_points(many, 6, -0.2, 1.2);
            CHECK(compare(on_device, random_points(20, 7, -0.2, 1.2), options).failure == "");
            for (std::size_t i = 0; i < 30; ++i) points[3 * i + 1] = 7e300;
            for (std::size_t i = 0; i < 30; ++i) points.push_back(points[300 + i]);  // duplicates
            const Counts counts = compare(on_device, points, options);
            CHECK(counts.failure == "");
            CHECK(counts.fallback < many / 10);
            CHECK(compare(on_device, random_points(5, 8, 3, 4), options).failure == "");
        }
    }

    TEST_CASE("gpu domains: walls and weights") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1000, 200);
        Options options = domain_options();
        options.walls.push_back({{1, 1, 1}, 1.5});
        options.outside = votess::Outside::drop;
        CHECK(compare(on_device, random_points(many, 5), options).failure == "");
        options = domain_options();
        test::Random random(7);
        std::vector<double> weights(many);
        for (double& w : weights) w = random.uniform(0, 0.02);
        options.weights = weights;
        CHECK(compare(on_device, random_points(many, 8), options).failure == "");
        options.periodic = {true, true, true};
        CHECK(compare(on_device, random_points(many, 9), options).failure == "");
    }
    TEST_CASE("gpu domains: the device makes whole cells in a mesh, and the CPU cuts them") {
        const test::Solid ring = test::torus(12, 6);
        const Coordinates points = random_points(test::by_size(1500, 300), 10, -1.3, 1.3);
        Options options;
        options.mesh = ring.mesh();
        options.device = "cpu";
        const auto expected = votess::tessellate(points, options);
        options.device = test::device_name();
        const auto t = test::shared_tessellator().tessellate(points, options);
        CHECK(t.stats().device != "cpu");
        CHECK(t.in_mesh());
        CHECK(test::check_same(t, expected, points, test::single_tolerance) == "");
        CHECK(std::abs(t.stats().volume_sum / ring.volume() - 1) < test::single_tolerance);
    }
}
