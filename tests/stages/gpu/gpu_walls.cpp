// Walls of any direction on a device (shaders/clip/walls.glsl) against exact arithmetic: their distances from near
// places, in boxes of any size anywhere.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <array>
#include <bit>
#include <cmath>

#include "gpu/domain/device_domain.hpp"
#include "gpu/domain/walls.hpp"
#include "input/settle.hpp"
#include "shared/interface.h"
#include "support/check.hpp"
#include "support/gpu/vulkan.hpp"
#include "support/random.hpp"

using namespace votess::gpu::vulkan;

namespace {

using votess::gpu::WallPlane;

constexpr int bits = 700;  // of numbers treated as exact

mpf_class power(mpf_class x, int exponent) {
    if (exponent >= 0)
        mpf_mul_2exp(x.get_mpf_t(), x.get_mpf_t(), static_cast<mp_bitcnt_t>(exponent));
    else
        mpf_div_2exp(x.get_mpf_t(), x.get_mpf_t(), static_cast<mp_bitcnt_t>(-exponent));
    return x;
}

mpf_class exact(double x) {
    return {x, bits};
}

// n.x <= height, as given.
struct Plane {
    std::array<mpf_class, 3> n{mpf_class{0, bits}, mpf_class{0, bits}, mpf_class{0, bits}};
    mpf_class height{0, bits};
};

std::vector<Plane> planes_of(const votess::Options& options) {
    std::vector<Plane> planes(6);
    if (options.box) {
        for (std::size_t k = 0; k < 3; ++k)
            for (const bool upper : {false, true}) {
                Plane& plane = planes[2 * k + (upper ? 1 : 0)];
                for (std::size_t j = 0; j < 3; ++j) plane.n[j] = exact(j != k ? 0 : (upper ? 1 : -1));
                plane.height = exact(upper ? options.box->upper[k] : -options.box->lower[k]);
            }
        for (const votess::Wall& wall : options.walls)
            planes.push_back(
                {{exact(wall.normal[0]), exact(wall.normal[1]), exact(wall.normal[2])}, exact(wall.offset)});
        return planes;
    }
    const std::array vectors{options.cell->a, options.cell->b, options.cell->c};
    for (std::size_t j = 0; j < 3; ++j) {
        const auto &u = vectors[(j + 1) % 3], &v = vectors[(j + 2) % 3];
        mpf_class lower{0, bits}, side{0, bits};
        std::array<mpf_class, 3> n;
        for (std::size_t k = 0; k < 3; ++k) {
            n[k] = exact(u[(k + 1) % 3]) * v[(k + 2) % 3] - exact(u[(k + 2) % 3]) * v[(k + 1) % 3];
            lower += n[k] * options.cell->origin[k];
            side += n[k] * vectors[j][k];
        }
        const int sign = sgn(side);
        for (std::size_t k = 0; k < 3; ++k) {
            planes[2 * j].n[k] = -sign * n[k];
            planes[2 * j + 1].n[k] = sign * n[k];
        }
        planes[2 * j].height = -sign * lower;
        planes[2 * j + 1].height = sign * (lower + side);
    }
    return planes;
}

struct Found {
    std::size_t near = 0, pruned = 0;
    std::string wrong;
};

// Places in units: most of them near a wall.
Found check(test::Gpu& gpu, const votess::Options& options, test::Random& random) {
    const test::Coordinates none;
    const votess::Job job = votess::make_job(votess::settle({none, {}}, options));
    const votess::Box box = votess::gpu::device_box(job);
    const auto units = votess::gpu::Units::for_box(box);
    const auto walls = votess::gpu::device_walls(job, box);
    const auto planes = planes_of(options);
    REQUIRE(walls.size() == planes.size());
    constexpr std::size_t count = 64;
    std::vector<std::uint64_t> places;
    bool lossy = false;
    std::array<std::uint64_t, 3> extent{};
    for (std::size_t k = 0; k < 3; ++k) extent[k] = units.of(box.upper[k], lossy) - units.of(box.lower[k], lossy);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            places.push_back(static_cast<std::uint64_t>(random.uniform(0.05, 0.9) * static_cast<double>(extent[k])));
        places.push_back(static_cast<std::uint64_t>(random.integer(SMALLEST_CELL_EXPONENT, COORDINATE_BITS - 1)));
        if (i % 4 == 0) continue;
        // Moves onto a wall, up to rounding of doubles.
        const WallPlane& wall = walls[random.below(walls.size())];
        if (wall.rough[3] >= UNBOUNDED) continue;
        double over = -wall.rough[3];
        for (std::size_t k = 0; k < 3; ++k)
            over += static_cast<double>(wall.rough[k]) * static_cast<double>(places[4 * i + k]);
        for (std::size_t k = 0; k < 3; ++k) {
            const double moved = static_cast<double>(places[4 * i + k]) - over * wall.rough[k];
            if (moved > 0 && moved < static_cast<double>(extent[k]))
                places[4 * i + k] = static_cast<std::uint64_t>(moved);
        }
    }

    Memory memory(*gpu.device, 1 << 20);
    PassInfo info;
    info.name = "test_walls";
    info.spirv = votess::gpu::shaders::test_walls;
    info.push_bytes = 4;
    info.local_size = 64;
    info.constants = {
        {CONSTANT_UNIT_ROUNDOFF, std::bit_cast<std::uint32_t>(gpu.device->rounds_to_nearest() ? 0x1p-24f : 0x1p-23f)},
        {CONSTANT_WALLS, 1},
        {CONSTANT_WEIGHTS, 0}};
    const Pass pass(*gpu.device, info);
    const Buffer in = memory.buffer(places.size() * 8, MemoryKind::upload, "places");
    const std::size_t state = sizeof(votess::gpu::RunState);
    const Buffer planes_in = memory.buffer(state + walls.size() * sizeof(WallPlane), MemoryKind::upload, "walls");
    const Buffer out = memory.buffer(count * walls.size() * 16, MemoryKind::download, "distances");
    std::ranges::copy(places, in.as<std::uint64_t>().begin());
    std::ranges::copy(std::as_bytes(std::span(walls)), planes_in.mapped().begin() + static_cast<std::ptrdiff_t>(state));
    in.flush();
    planes_in.flush();
    const BufferBinding bindings[] = {{2, &in}, {5, &out}, {BINDING_RUN_STATE, &planes_in}};
    const auto push = static_cast<std::uint32_t>(count);
    gpu.run(pass, bindings, push_bytes(push), count);
    out.invalidate();

    Found found;
    const auto words = out.as<std::uint32_t>();
    for (std::size_t w = 0; w < walls.size(); ++w) {
        const Plane& plane = planes[w];
        const mpf_class square = plane.n[0] * plane.n[0] + plane.n[1] * plane.n[1] + plane.n[2] * plane.n[2];
        const mpf_class length = sqrt(square);
        for (std::size_t i = 0; i < count; ++i) {
            mpf_class over{0, bits};
            for (std::size_t k = 0; k < 3; ++k)
                over +=
                    plane.n[k] * (exact(units.floor_of(box.lower[k])) + mpf_class(mpz_class(places[4 * i + k]), bits));
            const mpf_class truth = (power(plane.height, units.shift) - over) / length;
            const std::uint32_t* told = &words[4 * (i * walls.size() + w)];
            if (walls[w].rough[3] >= UNBOUNDED) continue;
            const auto distance = mpf_class(mpz_class((std::uint64_t{told[1]} << 32) | told[0]), bits);
            const float scale = std::ldexp(1.0F, -static_cast<int>(places[4 * i + 3]));
            const mpf_class error = truth < 0 ? mpf_class(distance) : mpf_class(abs(distance - truth));
            found.near += abs(truth) < 1e6;
            const auto least = std::bit_cast<float>(told[2]), height = std::bit_cast<float>(told[3]);
            found.pruned += least > 0;
            const std::string of = " of wall " + std::to_string(w) + ", place " + std::to_string(i);
            if (error > 2) found.wrong = "distance" + of + ": " + std::to_string(error.get_d());
            if (least > 0 && exact(least) > truth * exact(scale)) found.wrong = "rough distance" + of;
            if (abs(exact(height) - distance * exact(scale)) > exact(height) * exact(0x1p-23))
                found.wrong = "plane" + of;
        }
    }
    return found;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu walls: distances are right to two units") {
        test::Gpu gpu;
        test::Random random(51);
        std::size_t near = 0, pruned = 0;
        for (int set = 0; set < static_cast<int>(test::by_size(40, 8)); ++set) {
            votess::Options options = test::all_options(test::unit_box());
            const double size =
                std::ldexp(random.uniform(1, 2), set % 5 == 0 ? 0 : static_cast<int>(random.integer(-40, 40)));
            const double away = set % 3 == 0 ? 0 : size * std::exp2(random.uniform(-4, 27));
            if (set % 2 == 0) {
                for (std::size_t k = 0; k < 3; ++k) {
                    options.box->lower[k] = away * random.uniform(-1, 1);
                    options.box->upper[k] =
                        options.box->lower[k] + size * (k == 0 ? 1 : std::exp2(random.uniform(-10, 0)));
                }
                for (int w = 0; w < 8; ++w) {
                    votess::Wall wall{};
                    double at = 0;
                    for (std::size_t k = 0; k < 3; ++k) {
                        wall.normal[k] = random.uniform(-1, 1) * (random.chance(0.2) ? 1e-9 : 1);
                        at += wall.normal[k] * random.uniform(options.box->lower[k], options.box->upper[k]);
                    }
                    wall.offset = at;
                    options.walls.push_back(wall);
                }
            } else {
                options.box.reset();
                const auto lean = [&] { return size * random.uniform(-0.5, 0.5); };
                options.cell = votess::TriclinicBox{{away, -away / 3, size},
                                                    {size, lean() * 1e-6, lean()},
                                                    {lean(), size / 3, 0},
                                                    {lean(), lean(), size}};
                options.cell->periodic = {false, false, false};
            }
            CAPTURE(set);
            const Found found = check(gpu, options, random);
            CHECK(found.wrong == "");
            near += found.near;
            pruned += found.pruned;
        }
        CHECK(near > test::by_size(50, 10));
        CHECK(pruned > 1000);
    }

    TEST_CASE("gpu walls: those that cut nothing off the box are left out, exactly") {
        votess::Options options = test::all_options(test::unit_box());
        options.walls = {{{1, 0, 0}, 1}, {{1, 1, 1}, 3}, {{1, 1, 1}, std::nextafter(3, 0)}, {{-1, -2, 0}, 0}};
        const test::Coordinates none;
        const votess::Job job = votess::make_job(votess::settle({none, {}}, options));
        const auto walls = votess::gpu::device_walls(job, votess::gpu::device_box(job));
        REQUIRE(walls.size() == 10);
        for (std::size_t w = 0; w < 10; ++w) CHECK((walls[w].rough[3] >= UNBOUNDED) == (w >= 6 && w != 8));
    }
}
