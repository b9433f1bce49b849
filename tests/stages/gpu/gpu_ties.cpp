// The exact side of a vertex on a device (shaders/clip/exact_side.glsl) against the CPU's.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "exact/predicate.hpp"
#include "gpu/domain/units.hpp"
#include "shared/interface.h"
#include "support/check.hpp"
#include "support/gpu/vulkan.hpp"
#include "support/random.hpp"

using namespace votess::gpu::vulkan;
using votess::exact::Plane;
using votess::exact::Point;

namespace {

constexpr int unknown = 2;

struct TiesPush {
    std::array<std::array<std::uint32_t, 2>, 3> extent;
    std::uint32_t count;
};

// Coordinates of seeds are whole numbers up to `extent`, which are 2^zeros units.
struct Case {
    std::array<std::array<std::int64_t, 3>, 5> seeds;  // the cell's, and those of planes a, b, c, d
    std::array<std::int32_t, 4> walls{};               // of the box, instead of a seed's bisector where not 0
};

Plane plane(const Case& c, std::size_t i, std::int64_t extent) {
    if (c.walls[i] < 0) {
        const int wall = -1 - c.walls[i];
        return wall % 2 == 1 ? Plane::upper(wall / 2, static_cast<double>(extent)) : Plane::lower(wall / 2, 0);
    }
    Point q;
    for (std::size_t k = 0; k < 3; ++k) q[k] = static_cast<double>(c.seeds[i + 1][k]);
    return Plane::bisector(q);
}

// Returns the exact sides, after ordering planes a and b positively. Replaces cases without a vertex.
int exact_side(Case& c, std::int64_t extent, const auto& make) {
    for (;;) {
        Point p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = static_cast<double>(c.seeds[0][k]);
        const int turn = votess::exact::orientation(p, plane(c, 0, extent), plane(c, 1, extent), plane(c, 2, extent));
        if (turn < 0) {
            std::swap(c.seeds[1], c.seeds[2]);
            std::swap(c.walls[0], c.walls[1]);
        }
        if (turn != 0)
            return votess::exact::side_of_vertex(p, plane(c, 0, extent), plane(c, 1, extent), plane(c, 2, extent),
                                                 plane(c, 3, extent));
        c = make();
    }
}

// Differences up to `reach` an axis from a seed of the cell anywhere in the box.
Case random_case(test::Random& random, std::int64_t extent, std::int64_t reach) {
    Case c;
    for (auto& x : c.seeds[0]) x = random.integer(reach, extent - reach);
    for (std::size_t i = 1; i < 5; ++i) {
        do {
            for (std::size_t k = 0; k < 3; ++k) c.seeds[i][k] = c.seeds[0][k] + random.integer(-reach, reach);
        } while (c.seeds[i] == c.seeds[0]);
        if (random.chance(0.15)) c.walls[i - 1] = static_cast<std::int32_t>(random.integer(-6, -1));
    }
    return c;
}

std::vector<std::int32_t> sides_on(test::Gpu& gpu, const std::vector<Case>& cases, std::int64_t extent, int zeros) {
    const auto count = static_cast<std::uint32_t>(cases.size());
    Memory memory(*gpu.device, 1 << 22);
    PassInfo info;
    info.name = "test_ties";
    info.spirv = votess::gpu::shaders::test_ties;
    info.push_bytes = sizeof(TiesPush);
    info.local_size = 64;
    info.constants = {{CONSTANT_UNIT_ROUNDOFF, 0}, {CONSTANT_WEIGHTS, 0}};
    const Pass pass(*gpu.device, info);
    const Buffer in = memory.buffer(VkDeviceSize{count} * 120, MemoryKind::upload, "coordinates");
    auto coordinate = in.as<std::uint64_t>().begin();
    for (std::size_t k = 0; k < 3; ++k)
        for (const Case& c : cases)
            for (const auto& seed : c.seeds) *coordinate++ = static_cast<std::uint64_t>(seed[k]) << zeros;
    in.flush();
    const Buffer planes = memory.buffer(VkDeviceSize{count} * 16, MemoryKind::upload, "planes");
    const Buffer out = memory.buffer(VkDeviceSize{count} * 4, MemoryKind::download, "sides");
    auto at = planes.as<std::int32_t>().begin();
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < 4; ++k)
            *at++ = cases[i].walls[k] < 0 ? cases[i].walls[k] : static_cast<std::int32_t>(5 * i + 1 + k);
    planes.flush();
    TiesPush push{{}, 5 * count};
    for (auto& words : push.extent) {
        const auto w = votess::gpu::words(static_cast<std::uint64_t>(extent) << zeros);
        words = {w.x, w.y};
    }
    const BufferBinding bindings[] = {{BINDING_SEEDS, &in}, {BINDING_SEED_INPUT, &planes}, {BINDING_CHUNK, &out}};
    gpu.run(pass, bindings, push_bytes(push), count);
    out.invalidate();
    const auto found = out.as<std::int32_t>();
    return {found.begin(), found.end()};
}

struct Counts {
    std::size_t zeros = 0, unknown = 0, wrong = 0;
};

Counts judge(test::Gpu& gpu, std::int64_t extent, std::int64_t reach, int zeros, std::uint64_t seed) {
    test::Random random(seed);
    const auto make = [&] { return random_case(random, extent, reach); };
    std::vector<Case> cases(test::by_size(40000, 4000));
    std::vector<int> exact;
    for (Case& c : cases) {
        c = make();
        exact.push_back(exact_side(c, extent, make));
    }
    const auto found = sides_on(gpu, cases, extent, zeros);
    Counts counts;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        counts.zeros += found[i] == 0;
        counts.unknown += found[i] == unknown;
        counts.wrong += found[i] != unknown && found[i] != exact[i];
    }
    return counts;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu ties: sides of vertices are the exact ones, and nothing small is unknown") {
        test::Gpu gpu;
        for (const int zeros : {0, 17, 31, 40}) {
            CAPTURE(zeros);
            for (const std::int64_t reach : {1, 2, 5, 300, 2047}) {
                CAPTURE(reach);
                const Counts counts = judge(gpu, std::int64_t{1} << 20, reach, zeros, 71);
                CHECK(counts.wrong == 0);
                CHECK(counts.unknown == 0);
                if (reach <= 5) CHECK(counts.zeros > test::by_size(400, 40));
            }
            // Larger ones are undecided, except with trailing zeros.
            const Counts counts = judge(gpu, std::int64_t{1} << 20, 4000, zeros, 72);
            CHECK(counts.wrong == 0);
            CHECK(counts.unknown > test::by_size(20000, 2000));
        }
        // Walls are farther than 2^23.
        const Counts counts = judge(gpu, std::int64_t{1} << 27, 4, 30, 73);
        CHECK(counts.wrong == 0);
        CHECK(counts.unknown > test::by_size(4000, 400));
    }
}
