// Sets on a Vulkan device whose seeds lie in a small part of the box, beside its faces or a few units apart.
#include <doctest/doctest.h>

#include <cmath>
#include <votess/votess.hpp>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu.hpp"

using test::PointSet;
using votess::Kernel;

namespace {

// The answer of the CPU, by both kernels.
void check_on_device(const PointSet& set, unsigned k_init = 0) {
    votess::Options options = test::all_options(set.box);
    const auto cpu = votess::tessellate(set.points, options);
    options.device = test::device_name();
    options.k_init = k_init;
    for (const Kernel kernel : {Kernel::invocation, test::by_subgroup()}) {
        options.kernel = kernel;
        CAPTURE(set.name);
        CAPTURE(k_init);
        CAPTURE(static_cast<int>(kernel));
        const auto gpu = votess::tessellate(set.points, options);
        CHECK(test::check_same(gpu, cpu, set.points, test::tolerance(options)) == "");
    }
}

}  // namespace

TEST_SUITE("cases") {
    // In steps of 2^32 units of the device: the seed in the middle lies at nearly 1, its neighbors make a cube of its
    // cell, `last` at 33 cuts off a corner of that, at a distance of 32 along each axis; `farther` at -32 is at 33.
    // Whole steps have the wrong order.
    TEST_CASE("gpu near ties: a seed that cuts is nearer than one with less whole steps to it") {
        const double step = 0x1p-29, middle = 0.5 + step - 0x1p-53, side = 32.005 * step;
        PointSet set{"corner of a cube", {middle, middle, middle}, test::unit_box()};
        for (int k = 0; k < 6; ++k)
            for (int a = 0; a < 3; ++a)
                set.points.push_back(a == k / 2 ? middle + (k % 2 == 0 ? side : -side) : middle);
        set.points.insert(set.points.end(), {middle - 45 * step, middle, middle - 20 * step});  // cuts nothing
        for (const double whole : {-32.0, 33.0}) set.points.insert(set.points.end(), 3, 0.5 + whole * step);
        check_on_device(set);
        check_on_device(set, 8);
    }

    TEST_CASE("gpu near ties: clusters of few seeds in a large box equal the CPU") {
        for (std::uint64_t seed = 1; seed <= test::by_size(60, 6); ++seed) {
            PointSet set = test::uniform(30 + seed % 34, seed);
            set.box = test::cube(-std::ldexp(1.0, 18 + static_cast<int>(seed % 6)),
                                 std::ldexp(1.0, 18 + static_cast<int>(seed % 6)));
            check_on_device(set, seed % 2 == 0 ? 24 : 0);
        }
    }
}
