// Lattices on a Vulkan device, which decides their ties itself where coordinates are small whole numbers.
#include <doctest/doctest.h>

#include <cmath>
#include <votess/votess.hpp>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"

using test::PointSet;
using votess::gpu::Kernel;

namespace {

// The seeds below the upper faces of the box, so that the others are their images.
PointSet one_period(PointSet set) {
    test::Coordinates inside;
    for (std::size_t i = 0; i < set.size(); ++i) {
        bool below = true;
        for (std::size_t k = 0; k < 3; ++k) below = below && set.points[3 * i + k] < set.box->upper[k];
        if (below) inside.insert(inside.end(), &set.points[3 * i], &set.points[3 * i] + 3);
    }
    set.points = inside;
    return set;
}

// Coordinates of float32 in clusters far smaller than their steps: whole numbers of steps, and many equal seeds in one
// block of the curve that seeds are sorted along, so that the device does not mark them all.
PointSet crowded_steps() {
    PointSet set = test::nested_clusters(500, 63);
    for (double& x : set.points) x = static_cast<float>(x);
    return set;
}

struct Case {
    PointSet set;
    bool periodic = false;
    double max_left_to_cpu = 0;  // share of the cells
};

// The CPU's lists, counts and geometry, by both kernels.
void check_on_device(const std::vector<Case>& cases) {
    votess::Tessellator tessellator;
    for (const Kernel kernel : {Kernel::invocation, test::by_subgroup()}) {
        const test::UseKernel chosen(kernel);
        for (const Case& c : cases) {
            votess::Options options = test::all_options(c.set.box);
            options.periodic = {c.periodic, c.periodic, c.periodic};
            CAPTURE(c.set.name);
            CAPTURE(c.periodic);
            CAPTURE(static_cast<int>(kernel));
            const auto cpu = votess::tessellate(c.set.points, options);
            options.device = test::device_name();
            const auto gpu = tessellator.tessellate(c.set.points, options);
            CHECK(test::check_same(gpu, cpu, c.set.points, test::tolerance(options)) == "");
            CHECK(static_cast<double>(gpu.stats().fallback_cells) <=
                  c.max_left_to_cpu * static_cast<double>(c.set.size()));
        }
    }
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu lattices: the device makes all cells") {
        const auto large = static_cast<int>(test::by_size(16, 8));
        check_on_device({{test::cubic(static_cast<std::size_t>(large))},
                         {test::cubic(6, 0x1p-40)},
                         {test::cubic(6, 3 * 0x1p40)},
                         {test::bcc(large)},
                         {test::fcc(large)},
                         {test::hexagonal(large)},
                         {test::close_packed(20)},
                         {test::diamond(large)}});
    }

    TEST_CASE("gpu lattices: periodic ones too") {
        const auto large = static_cast<int>(test::by_size(16, 8));
        check_on_device({{test::cubic(static_cast<std::size_t>(large)), true},
                         {one_period(test::bcc(large)), true},
                         {one_period(test::fcc(large)), true},
                         {one_period(test::diamond(large)), true}});
    }

    TEST_CASE("gpu lattices: where coordinates are no small numbers the CPU decides") {
        check_on_device({{test::cubic(8, 1.0 / 3), false, 1}, {test::jittered(8, 1e-12, 3), false, 1}});
    }

    TEST_CASE("gpu lattices: equal seeds that the device has not marked") {
        check_on_device({{crowded_steps(), false, 1}});
    }

    TEST_CASE("gpu lattices: many seeds on spheres of whole numbers, lines and planes") {
        check_on_device({{test::cospherical(194), false, 1},
                         {test::cospherical_and_center(194), false, 1},
                         {test::cocircular(65, 4), false, 1},
                         {test::on_oblique_plane(300, 4), false, 1},
                         {test::on_oblique_line(200, 5), false, 1}});
    }
}
