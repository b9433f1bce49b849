// Many small seeded sets on the GPU against the CPU: lists, counts and statuses identical, volumes near.
// VOTESS_FUZZ_SETS: how many; VOTESS_FUZZ_SEED: of the first set, the others follow. A failure prints the set, reduced
// to the fewest points that still fail, as source for a named case.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::Random;

constexpr int kinds = 10;

// One point of a set of this kind and size, with coordinates of order one.
std::array<double, 3> draw(int kind, int size, double jitter, Random& random) {
    const auto grid = [&] {
        return (static_cast<double>(random.integer(0, size)) + jitter * random.uniform(-1, 1)) / size;
    };
    switch (kind) {
        case 0:
            return {random.uniform(), random.uniform(), random.uniform()};
        case 1:
            return {grid(), grid(), grid()};
        case 2: {  // body-centered
            const double half = random.chance(0.5) ? 0.5 / size : 0;
            return {grid() + half, grid() + half, grid() + half};
        }
        case 3:  // a slab or a needle
            return {random.uniform(), random.uniform() * jitter, grid()};
        case 4: {  // clusters in clusters
            const double scale = std::ldexp(1.0, -static_cast<int>(random.below(30)));
            return {0.3 + scale * random.uniform(), 0.4 + scale * random.uniform(), 0.2 + scale * random.uniform()};
        }
        case 5: {  // nearly on a plane
            const double u = random.uniform(), v = random.uniform();
            return {u, v, 0.25 + 0.25 * u + 0.5 * v + jitter * random.uniform(-1, 1)};
        }
        case 6: {  // nearly on a sphere
            std::array<double, 3> p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            const double r = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) + 1e-3;
            for (auto& x : p) x = x / r * (1 + jitter * random.uniform(-1, 1));
            return p;
        }
        case 8: {  // small whole numbers
            const auto whole = [&] { return static_cast<double>(random.integer(0, size)); };
            return {whole(), whole(), whole()};
        }
        case 9: {  // whole numbers on a sphere, a plane or a line
            static constexpr std::array<std::array<double, 3>, 4> on_sphere{
                {{9, 0, 0}, {8, 4, 1}, {7, 4, 4}, {6, 6, 3}}};
            std::array<double, 3> p = on_sphere[random.below(4)];
            std::swap(p[0], p[random.below(3)]);
            std::swap(p[1], p[1 + random.below(2)]);
            for (auto& x : p)
                if (random.chance(0.5)) x = -x;
            if (size > 4) p = {p[0], p[1], -p[0] - p[1]};
            if (size == 6) p = {p[0], 2 * p[0], -3 * p[0]};
            return p;
        }
        default: {  // on walls of the unit box
            std::array<double, 3> p{random.uniform(), random.uniform(), random.uniform()};
            for (auto& x : p)
                if (random.chance(0.4)) x = static_cast<double>(random.below(2));
            return p;
        }
    }
}

test::PointSet make(std::uint64_t seed) {
    Random random(seed);
    const int kind = static_cast<int>(random.below(kinds)), size = static_cast<int>(random.integer(1, 6));
    constexpr double jitters[] = {0, 0, 1e-17, 1e-15, 1e-12, 1e-7, 1e-4, 1e-2, 0.3};
    const double jitter = jitters[random.below(std::size(jitters))];
    const double near = random.chance(0.3) ? random.uniform(0, 0.5) : 0.02;  // share of near-duplicates
    const auto n = random.chance(0.5) ? random.integer(2, 30) : random.integer(31, 200);
    test::PointSet set;
    for (std::int64_t i = 0; i < n; ++i) {
        auto p = draw(kind, size, jitter, random);
        if (i > 0 && random.chance(near)) {
            const auto j = 3 * random.below(static_cast<std::uint64_t>(i));
            for (std::size_t a = 0; a < 3; ++a) {
                p[a] = set.points[j + a];
                if (random.chance(0.4)) p[a] = std::nextafter(p[a], random.chance(0.5) ? 2.0 : -2.0);
            }
        }
        set.points.insert(set.points.end(), p.begin(), p.end());
    }
    if (random.chance(0.3)) {  // far from the origin: digits are lost, and ties appear
        const double offset = std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(50)));
        for (auto& x : set.points) x += offset;
    }
    if (random.chance(0.4)) {
        const double factor = std::ldexp(1.0, static_cast<int>(random.integer(-230, 230)));
        for (auto& x : set.points) x *= factor;
    }
    if (random.chance(0.5)) {  // else the default box
        votess::Box box;
        bool valid = true;
        const double room = random.chance(0.5) ? 0 : std::ldexp(random.uniform(), static_cast<int>(random.below(20)));
        for (std::size_t a = 0; a < 3; ++a) {
            box.lower[a] = box.upper[a] = set.points[a];
            for (std::size_t i = a; i < set.points.size(); i += 3) {
                box.lower[a] = std::min(box.lower[a], set.points[i]);
                box.upper[a] = std::max(box.upper[a], set.points[i]);
            }
            const double width = box.upper[a] - box.lower[a];
            box.lower[a] -= room * width;
            box.upper[a] += room * width;
            valid = valid && box.lower[a] < box.upper[a];
        }
        if (valid) set.box = box;
    }
    return set;
}

std::string judge(votess::Tessellator& tessellator, const Coordinates& points, votess::Options options) {
    const auto outcome = [&](const std::string& device, std::string& refusal) {
        options.device = device;
        try {
            return tessellator.tessellate(points, options);
        } catch (const std::exception& error) {
            refusal = error.what();
            return votess::Tessellation();
        }
    };
    std::string gpu_refusal, cpu_refusal;
    const auto gpu = outcome(test::device_name(), gpu_refusal), cpu = outcome("cpu", cpu_refusal);
    if (gpu_refusal != cpu_refusal) return "threw: " + gpu_refusal + ", the CPU: " + cpu_refusal;
    return gpu_refusal.empty() ? test::check_same(gpu, cpu, points, test::tolerance(options)) : "";
}

// Weights for a set, of kinds that bury no seed or most of them.
std::vector<double> make_weights(const test::PointSet& set, Random& random) {
    double size = 0;
    for (const double x : set.points) size = std::max(size, std::abs(x - set.points[0]));
    const std::size_t n = set.points.size() / 3;
    const double spacing = size / std::cbrt(static_cast<double>(n)), square = spacing * spacing;
    const int kind = static_cast<int>(random.below(7)), steps = static_cast<int>(random.integer(1, 6));
    const double factor = std::ldexp(square, static_cast<int>(random.integer(-12, 6)));
    const double offset = std::ldexp(square, static_cast<int>(random.integer(0, 50)));
    std::vector<double> weights(n);
    for (double& w : weights) {
        const double any = random.uniform(0, 1);
        switch (kind) {
            case 0:
                w = factor * any;
                break;
            case 1:  // as of balls of up to some radius
                w = factor * any * any;
                break;
            case 2:
                w = offset + factor * any;
                break;
            case 3:
                w = -factor * any;
                break;
            case 4:  // ties on grids of so many steps
                w = size * size * static_cast<double>(random.below(4)) / (steps * steps);
                break;
            case 5:
                w = random.chance(0.5) ? factor : 0;
                break;
            default:
                w = random.chance(0.1) ? 100 * factor : random.chance(0.02) ? -1e6 * factor : factor * any;
        }
    }
    if (random.chance(0.2)) weights[random.below(n)] = std::ldexp(square, static_cast<int>(random.integer(0, 12)));
    return weights;
}

}  // namespace

TEST_SUITE("fuzz") {
    TEST_CASE("gpu: small power diagrams equal the CPU") {
        const auto first = test::environment("VOTESS_FUZZ_SEED", 1);
        const auto sets = test::environment("VOTESS_FUZZ_SETS", test::by_size(60, 30));
        votess::Tessellator tessellator;
        int failures = 0;
        for (std::uint64_t seed = first; seed < first + sets && failures < 5; ++seed) {
            const test::PointSet set = make(seed);
            Random random(seed + 1000000);
            const std::vector<double> weights = make_weights(set, random);
            votess::Options options = test::all_options(set.box);
            options.weights = weights;
            options.list_walls = seed % 3 != 0;
            const std::uint64_t quarter = (seed - first) * 4 / std::max<std::uint64_t>(sets, 1);
            options.k_init = quarter == 0 ? 12 : 0;
            options.precision = quarter == 3 ? test::double_precision() : votess::Precision::single;
            const test::UseKernel chosen((seed - first) * 8 / sets % 2 == 0 ? test::by_subgroup()
                                                                            : votess::gpu::Kernel::invocation);
            if (set.box && random.chance(0.3)) options.periodic = {true, random.chance(0.7), random.chance(0.7)};
            const std::string wrong = judge(tessellator, set.points, options);
            failures += wrong.empty() ? 0 : 1;
            CHECK_MESSAGE(wrong.empty(), "seed " << seed << ": " << wrong);
        }
    }

    TEST_CASE("gpu: small sets equal the CPU") {
        const auto first = test::environment("VOTESS_FUZZ_SEED", 1);
        const auto sets = test::environment("VOTESS_FUZZ_SETS", test::by_size(120, 30));
        votess::Tessellator tessellator;
        int failures = 0;
        for (std::uint64_t seed = first; seed < first + sets && failures < 5; ++seed) {
            const test::PointSet set = make(seed);
            votess::Options options = test::all_options(set.box);
            options.list_walls = seed % 3 != 0;
            // Other pipelines take long to make: one kind of them after the other.
            options.k_init = seed - first < sets / 4 ? 12 : 0;
            options.precision = seed - first > sets / 4 * 3 ? test::double_precision() : votess::Precision::single;
            const auto quarter = std::max<std::uint64_t>(sets / 4, 1);
            const test::UseKernel chosen((seed - first) % quarter < quarter / 2 ? test::by_subgroup()
                                                                                : votess::gpu::Kernel::invocation);
            constexpr unsigned grids[] = {0, 0, 1, 2, 5, 50}, chunks[] = {0, 0, 0, 64, 150};
            options.grid_resolution = grids[seed % 6];
            options.chunk_size = chunks[seed % 5];
            INFO("seed " << seed);
            const std::string wrong = judge(tessellator, set.points, options);
            if (wrong.empty()) continue;
            ++failures;
            std::string source;
            try {
                options.box = votess::tessellate(set.points, options).box();
                const auto fewest = test::minimize(set.points, [&](const Coordinates& points) {
                    return !points.empty() && !judge(tessellator, points, options).empty();
                });
                source = judge(tessellator, fewest, options) + '\n' + test::print_points(fewest, *options.box);
            } catch (const std::exception&) {
                source = test::print_points(set.points, set.box.value_or(votess::Box{}));
            }
            FAIL_CHECK("seed " << seed << ", grid_resolution " << options.grid_resolution << ", k_init "
                               << options.k_init << ", chunk_size " << options.chunk_size << ": " << wrong
                               << "\nfewest points: " << source);
        }
    }
}
