// Sets on a Vulkan device whose seeds lie in a small part of the box, beside its faces or a few units apart.
#include <doctest/doctest.h>

#include <cmath>
#include <votess/votess.hpp>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"

using test::PointSet;
using votess::gpu::Kernel;

namespace {

// The answer of the CPU to each set, by both kernels with usual lists and short ones: other pipelines take long to
// make.
void check_on_device(const std::vector<PointSet>& sets) {
    votess::Tessellator tessellator;
    std::vector<votess::Tessellation> on_cpu;
    for (const PointSet& set : sets) on_cpu.push_back(votess::tessellate(set.points, test::all_options(set.box)));
    for (const Kernel kernel : {Kernel::invocation, test::by_subgroup()}) {
        const test::UseKernel chosen(kernel);
        for (const unsigned k_init : {0u, 12u})
            for (std::size_t i = 0; i < sets.size(); ++i) {
                votess::Options options = test::all_options(sets[i].box);
                options.device = test::device_name();
                options.k_init = k_init;
                CAPTURE(sets[i].name);
                CAPTURE(i);
                CAPTURE(k_init);
                CAPTURE(static_cast<int>(kernel));
                const auto gpu = tessellator.tessellate(sets[i].points, options);
                CHECK(test::check_same(gpu, on_cpu[i], sets[i].points, test::tolerance(options)) == "");
            }
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
        check_on_device({set});
    }

    TEST_CASE("gpu near ties: clusters of few seeds in a large box equal the CPU") {
        std::vector<PointSet> sets;
        for (std::uint64_t seed = 1; seed <= test::by_size(60, 6); ++seed) {
            sets.push_back(test::uniform(30 + seed % 34, seed));
            const double room = std::ldexp(1.0, 18 + static_cast<int>(seed % 6));
            sets.back().box = test::cube(-room, room);
        }
        check_on_device(sets);
    }
}
