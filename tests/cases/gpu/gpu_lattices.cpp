// Ties and near ties on a Vulkan device. It decides ties of lattices with coordinates that are small whole numbers.
#include <doctest/doctest.h>

#include <cmath>
#include <votess/votess.hpp>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"

using test::PointSet;
using votess::gpu::Kernel;

namespace {

// Returns the seeds below the upper faces of the box. The others are their images.
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

// Returns float32 coordinates in clusters far smaller than their steps. They are whole numbers of steps, and many equal
// seeds are in one block of the curve, so that the device does not mark them all.
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

// Compares lists, counts and geometry with the CPU's, for both kernels, and invocations with these lengths of lists.
void check_on_device(const std::vector<Case>& cases, const std::vector<unsigned>& k_inits = {0}) {
    votess::Tessellator& tessellator = test::shared_tessellator();
    std::vector<votess::Options> options;
    std::vector<votess::Tessellation> on_cpu;
    for (const Case& c : cases) {
        options.push_back(test::all_options(c.set.box));
        options.back().periodic = {c.periodic, c.periodic, c.periodic};
        on_cpu.push_back(votess::tessellate(c.set.points, options.back()));
        options.back().device = test::device_name();
    }
    for (const Kernel kernel : {Kernel::invocation, test::by_subgroup()}) {
        const test::UseKernel chosen(kernel);
        for (const unsigned k_init : k_inits) {  // the outer loop: other pipelines take long to make
            if (k_init != 0 && kernel != Kernel::invocation) continue;  // subgroups search as they go
            for (std::size_t i = 0; i < cases.size(); ++i) {
                const Case& c = cases[i];
                options[i].k_init = k_init;
                CAPTURE(c.set.name);
                CAPTURE(i);
                CAPTURE(k_init);
                CAPTURE(static_cast<int>(kernel));
                const auto gpu = tessellator.tessellate(c.set.points, options[i]);
                CHECK(test::check_same(gpu, on_cpu[i], c.set.points, test::tolerance(options[i])) == "");
                CHECK(static_cast<double>(gpu.stats().fallback_cells) <=
                      c.max_left_to_cpu * static_cast<double>(c.set.size()));
            }
        }
    }
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu lattices: the device makes all cells") {
        const auto large = static_cast<int>(test::by_size(12, 8));
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
        const auto large = static_cast<int>(test::by_size(12, 8));
        check_on_device({{test::cubic(static_cast<std::size_t>(large)), true},
                         {one_period(test::bcc(large)), true},
                         {one_period(test::fcc(large)), true},
                         {one_period(test::diamond(large)), true}});
    }

    TEST_CASE("gpu lattices: the CPU decides where coordinates are not small numbers") {
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

    // In steps of 2^32 units of the device. The middle seed is at nearly 1, and its neighbors make its cell a cube. The
    // last seed is at 33 and cuts off a corner, at a distance of 32 along each axis; the one at -32 is at a distance of
    // 33. Whole steps give the wrong order.
    TEST_CASE("gpu near ties: a seed that cuts is nearer than one that is fewer whole steps away") {
        const double step = 0x1p-29, middle = 0.5 + step - 0x1p-53, side = 32.005 * step;
        PointSet set{"corner of a cube", {middle, middle, middle}, test::unit_box()};
        for (int k = 0; k < 6; ++k)
            for (int a = 0; a < 3; ++a)
                set.points.push_back(a == k / 2 ? middle + (k % 2 == 0 ? side : -side) : middle);
        set.points.insert(set.points.end(), {middle - 45 * step, middle, middle - 20 * step});  // cuts nothing
        for (const double whole : {-32.0, 33.0}) set.points.insert(set.points.end(), 3, 0.5 + whole * step);
        check_on_device({{set, false, 1}}, {0, 12});
    }

    TEST_CASE("gpu near ties: clusters of few seeds in a large box equal the CPU") {
        std::vector<Case> cases;
        for (std::uint64_t seed = 1; seed <= test::by_size(24, 6); ++seed) {
            cases.push_back({test::uniform(30 + seed % 34, seed), false, 1});
            const double room = std::ldexp(1.0, 18 + static_cast<int>(seed % 6));
            cases.back().set.box = test::cube(-room, room);
        }
        check_on_device(cases, {0, 12});
    }
}
