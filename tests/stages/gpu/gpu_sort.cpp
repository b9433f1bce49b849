// Stages upload and sort of the GPU engine, pass by pass, against exact integers and std::stable_sort.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>

#include "support/check.hpp"
#include "support/gpu/gpu_stages.hpp"
#include "support/random.hpp"

using test::GpuStages;
using test::Integers;
using test::PointSet;
using votess::gpu::RunState;

namespace {

// Returns floor(x 2^shift) modulo 2^64, and whether it lost digits.
std::pair<std::uint64_t, bool> exact_units(double x, int shift) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const int field = static_cast<int>(bits >> 52 & 0x7ff);
    __int128 m = static_cast<__int128>(bits & 0xfffffffffffff) + (field > 0 ? __int128{1} << 52 : 0);
    if (bits >> 63 != 0) m = -m;
    const int n = std::max(field, 1) - 1075 + shift;
    if (n >= 64) return {0, false};
    if (n >= 0) return {static_cast<std::uint64_t>(static_cast<unsigned __int128>(m) << n), false};
    const __int128 divisor = __int128{1} << std::min(-n, 100);
    const __int128 rest = (m % divisor + divisor) % divisor;
    return {static_cast<std::uint64_t>((m - rest) / divisor), rest != 0};
}

void check_upload(GpuStages& gpu, const votess::Job& job) {
    const int shift = gpu.seeds.on_device().units().shift;
    long double longest = 0;
    bool box_lost = false, points_lost = false;
    std::uint64_t origin[3];
    for (int a = 0; a < 3; ++a) {
        longest = std::max(longest, static_cast<long double>(job.box.upper[a]) - job.box.lower[a]);
        const auto [lower, lost] = exact_units(job.box.lower[a], shift);
        const auto [upper, upper_lost] = exact_units(job.box.upper[a], shift);
        box_lost = box_lost || lost || upper_lost;
        origin[a] = lower;
        CHECK(gpu.seeds.on_device().origin()[a] == lower);
        CHECK(gpu.seeds.on_device().extent()[a] == upper - lower);
        CHECK(gpu.seeds.on_device().extent()[a] <= std::uint64_t{1} << COORDINATE_BITS);
    }
    CHECK(std::ldexp(longest, shift) >= 0x1p61l * (1 - 0x1p-50l));
    CHECK(std::ldexp(longest, shift) <= 0x1p62l);
    const auto units = gpu.coordinates(BINDING_POINTS);
    for (std::size_t i = 0; i < job.points.coordinates(); ++i) {
        const auto [value, lost] = exact_units(job.points[i], shift);
        points_lost = points_lost || lost;
        if (units[i % 3][i / 3] == value - origin[i % 3]) continue;
        FAIL_CHECK("coordinate " << i << ", " << job.points[i] << " with shift " << shift << ", is "
                                 << units[i % 3][i / 3] << " instead of " << value - origin[i % 3]);
        return;
    }
    const RunState state = gpu.run_state();
    CHECK(state.lossy == (points_lost ? LOSSY_POINTS : 0u) + (box_lost ? LOSSY_BOX : 0u));
    CHECK(state.suspects == 0);
    CHECK(state.duplicates == 0);
}

void check_upload(GpuStages& gpu, const PointSet& set) {
    CAPTURE(set.name);
    CAPTURE(set.size());
    check_upload(gpu, gpu.upload(set));
}

void check_upload_of_floats(GpuStages& gpu, const std::vector<float>& points, const votess::Box& box) {
    votess::Options options;
    options.box = box;
    const votess::Job job = votess::make_job(votess::settle({{}, points}, options));
    gpu.seeds.upload(job, {}, job.box, *gpu.passes, gpu.pool);
    check_upload(gpu, job);
}

// Returns numbers of both signs with magnitudes of factor times a power of two between 2^-decades and 1, and zeros.
PointSet over_magnitudes(std::size_t n, double factor, int decades, std::uint64_t seed) {
    test::Random random(seed);
    PointSet set{"magnitudes", {}, test::cube(-factor, factor)};
    for (std::size_t i = 0; i < 3 * n; ++i) {
        const double x =
            std::ldexp(random.uniform(-1, 1), -static_cast<int>(random.below(static_cast<std::uint64_t>(decades))));
        set.points.push_back(random.chance(0.02) ? (random.chance(0.5) ? 0.0 : -0.0) : x * factor);
    }
    return set;
}

// --- keys -------------------------------------------------------------------------------------------------------

// Returns the place along the Hilbert curve, as in shaders/sort/sort_key.comp, but bit by bit into one number.
std::uint64_t hilbert(std::array<std::uint32_t, 3> x, std::uint32_t bits) {
    for (std::uint32_t q = 1u << (bits - 1); q > 1; q >>= 1)
        for (std::size_t i = 0; i < 3; ++i) {
            if (x[i] & q) {
                x[0] ^= q - 1;
            } else {
                const std::uint32_t t = (x[0] ^ x[i]) & (q - 1);
                x[0] ^= t;
                x[i] ^= t;
            }
        }
    x[1] ^= x[0];
    x[2] ^= x[1];
    std::uint32_t t = 0;
    for (std::uint32_t q = 1u << (bits - 1); q > 1; q >>= 1)
        if (x[2] & q) t ^= q - 1;
    std::uint64_t key = 0;
    for (int b = 19; b >= 0; --b)
        for (const std::uint32_t axis : x) key = key << 1 | ((axis ^ t) >> b & 1);
    return key;
}

Integers keys_of(const GpuStages& gpu, const std::vector<Integers>& points, std::uint32_t bits) {
    const std::uint64_t* extent = gpu.seeds.on_device().extent();
    const auto longest = static_cast<double>(std::max({extent[0], extent[1], extent[2]}));
    const auto blocks_per_unit = static_cast<float>(std::ldexp(1.0, 32 + static_cast<int>(bits)) / longest);
    Integers keys;
    for (std::size_t i = 0; i < gpu.seeds.count(); ++i) {
        std::array<std::uint32_t, 3> block;
        for (std::size_t a = 0; a < 3; ++a)
            block[a] =
                std::min(static_cast<std::uint32_t>(static_cast<float>(static_cast<std::uint32_t>(points[a][i] >> 32)) *
                                                    blocks_per_unit),
                         (1u << bits) - 1);
        keys.push_back(hilbert(block, bits));
    }
    return keys;
}

// Returns whether more seeds than a group have one key.
bool is_crowded(Integers keys) {
    std::ranges::sort(keys);
    for (std::size_t s = GROUP_SEEDS; s < keys.size(); ++s)
        if (keys[s] == keys[s - GROUP_SEEDS]) return true;
    return false;
}

// Sorts the set and checks order, seeds, duplicates and suspects.
void check_sort(GpuStages& gpu, const PointSet& set, std::uint32_t bits) {
    CAPTURE(set.name);
    CAPTURE(set.size());
    CAPTURE(bits);
    gpu.upload(set);
    const bool lossy = (gpu.run_state().lossy & LOSSY_POINTS) != 0;
    gpu.seeds.sort(*gpu.passes, bits);
    const std::size_t n = set.size();
    const auto points = gpu.coordinates(BINDING_POINTS);
    constexpr std::uint32_t coarse = votess::gpu::DeviceSeeds::coarse_bits;
    Integers keys = keys_of(gpu, points, std::min(bits, coarse));
    if (bits > coarse && is_crowded(keys)) keys = keys_of(gpu, points, bits);
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return keys[a] < keys[b]; });
    REQUIRE(gpu.read<std::uint32_t>(gpu.seeds.on_device().sorted_index(), n) == order);
    Integers sorted_keys = gpu.read<std::uint64_t>(gpu.seeds.on_device().sorted_keys(), n);
    for (auto& key : sorted_keys) key = (key >> 32) << KEY_WORD_BITS | (key & 0xffffffff);
    for (std::size_t s = 0; s < n; ++s) REQUIRE(sorted_keys[s] == keys[order[s]]);

    const auto same = [&](std::uint32_t i, std::uint32_t j) {
        return points[0][i] == points[0][j] && points[1][i] == points[1][j] && points[2][i] == points[2][j];
    };
    const auto seeds = gpu.coordinates(BINDING_SEEDS);
    const auto input = gpu.read<std::uint32_t>(BINDING_SEED_INPUT, n);
    std::uint32_t duplicates = 0;
    bool suspects = false;
    for (std::size_t s = 0; s < n; ++s) {
        bool found = false, given_up = false;
        for (std::size_t back = 1; back <= s && !found && !given_up && keys[order[s - back]] == keys[order[s]]; ++back)
            (back > MAX_LOOK_BACK ? given_up : found) = back > MAX_LOOK_BACK || same(order[s], order[s - back]);
        suspects = suspects || given_up || (found && lossy);
        const bool marked = found && !lossy;
        duplicates += marked ? 1 : 0;
        REQUIRE(input[s] == (marked ? order[s] | DUPLICATE_BIT : order[s]));
        for (std::size_t a = 0; a < 3; ++a)
            REQUIRE(seeds[a][s] == (marked ? test::no_coordinate : points[a][order[s]]));
    }
    const RunState state = gpu.seeds.state();
    CHECK(state.duplicates == duplicates);
    CHECK(state.suspects == (suspects ? 1u : 0u));
    CHECK(std::ranges::equal(gpu.seeds.order(), input));
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu upload: exact units, every size") {
        GpuStages gpu;
        for (const std::size_t n : test::sizes_across_groups)
            if (n <= test::by_size(100000, 2000)) check_upload(gpu, test::uniform(n, n));
        check_upload(gpu, test::uniform(test::by_size(400000, 3000), 1));  // more than the staging buffer holds
        check_upload(gpu, test::uniform(5, 2));
        CHECK(gpu.run_state().lossy == 0);  // multiples of 2^-53 in the unit box
    }

    TEST_CASE("gpu upload: magnitudes, signs, scales, offsets") {
        GpuStages gpu;
        const std::size_t n = test::by_size(3000, 500);
        check_upload(gpu, over_magnitudes(n, 1, 80, 3));
        check_upload(gpu, over_magnitudes(n, 1, 1074, 4));
        check_upload(gpu, over_magnitudes(n, 1e-300, 70, 5));
        check_upload(gpu, over_magnitudes(n, 0x1p-1020, 70, 6));
        check_upload(gpu, over_magnitudes(n, 0x1p-1060, 12, 7));
        check_upload(gpu, over_magnitudes(n, 1e300, 900, 8));
        check_upload(gpu, over_magnitudes(n, 0x1.fffffffffffffp1022, 900, 9));
        for (const double offset : {1e3, -1e8, 1e15, -1e300}) {
            const double step = std::nextafter(offset, 0.0) - offset;
            test::Random random(10);
            PointSet set{"offset", {}, std::nullopt};
            for (std::size_t i = 0; i < 3 * n; ++i)
                set.points.push_back(offset + step * static_cast<double>(random.below(1000)));
            check_upload(gpu, set);
        }
        // The box is not a whole number of units, the points are.
        PointSet set = test::uniform(n, 11);
        set.box = test::cube(-0x1p-80, 1);
        check_upload(gpu, set);
        CHECK(gpu.run_state().lossy == LOSSY_BOX);
        for (const PointSet& family : test::families(test::by_size(300, 100), 12)) check_upload(gpu, family);
    }

    TEST_CASE("gpu upload: float32") {
        GpuStages gpu;
        test::Random random(13);
        for (const float factor : {1.0f, 0x1p-126f, 0x1p-140f, 0x1p127f, 1e-3f, 1e6f}) {
            CAPTURE(factor);
            std::vector<float> points;
            for (std::size_t i = 0; i < 3 * test::by_size(2000, 400); ++i) {
                const double x = std::ldexp(random.uniform(-1, 1), -static_cast<int>(random.below(40)));
                points.push_back(random.chance(0.02) ? -0.0f : static_cast<float>(x) * factor);
            }
            check_upload_of_floats(gpu, points, test::cube(-factor, factor));
            check_upload_of_floats(gpu, points, test::cube(-2e38, 3e38));
        }
        for (const std::size_t n : {1, 2, 7, 63, 64, 65, 257, 1025})
            check_upload_of_floats(gpu, std::vector<float>(3 * n, 0.3f), test::unit_box());
    }

    TEST_CASE("gpu upload: some members of the points") {
        GpuStages gpu;
        const PointSet set = test::uniform(1000, 14);
        votess::Options options;
        options.box = set.box;
        const votess::Job job = votess::make_job(votess::settle({set.points, {}}, options));
        test::Random random(15);
        std::vector<std::int32_t> members;
        for (const std::size_t i : test::permutation(1000, random)) members.push_back(static_cast<std::int32_t>(i));
        members.resize(333);
        gpu.seeds.upload(job, members, job.box, *gpu.passes, gpu.pool);
        REQUIRE(gpu.seeds.count() == 333);
        const auto units = gpu.coordinates(BINDING_POINTS);
        for (std::size_t m = 0; m < members.size(); ++m)
            for (std::size_t a = 0; a < 3; ++a)
                REQUIRE(units[a][m] == exact_units(set.points[3 * static_cast<std::size_t>(members[m]) + a],
                                                   gpu.seeds.on_device().units().shift)
                                           .first);
    }

    TEST_CASE("gpu scan: sums of all that is before, every size") {
        GpuStages gpu;
        test::Random random(16);
        std::vector<std::size_t> sizes = test::sizes_across_groups;
        sizes.insert(sizes.end(), {199999, 1024 * 1024, 1024 * 1024 + 1});  // the last needs three levels
        for (const std::size_t n : sizes) {
            if (n > test::by_size(2000000, 3000)) continue;
            CAPTURE(n);
            const test::vk::Buffer data = gpu.memory.buffer(n * 4, test::vk::MemoryKind::upload);
            std::vector<std::uint32_t> expected;
            std::uint32_t sum = 0;
            for (auto& word : data.as<std::uint32_t>().first(n)) {
                word = static_cast<std::uint32_t>(random.next());  // sums are modulo 2^32
                expected.push_back(sum);
                sum += word;
            }
            data.flush();
            votess::gpu::Scan scan;
            votess::gpu::OwnBuffers buffers(gpu.memory);
            scan.reserve(buffers, static_cast<std::uint32_t>(n + random.below(3)));
            test::vk::Commands commands(*gpu.gpu.device);
            commands.begin();
            scan.record(commands, *gpu.passes, data, static_cast<std::uint32_t>(n));
            commands.end();
            commands.submit();
            commands.wait();
            REQUIRE(gpu.read<std::uint32_t>(data, n) == expected);
        }
    }

    TEST_CASE("gpu sort: as std::stable_sort, every size and number of key bits") {
        GpuStages gpu;
        for (const std::size_t n : test::sizes_across_groups)
            if (n <= test::by_size(100000, 2000)) check_sort(gpu, test::uniform(n, n), 20);
        for (const std::uint32_t bits : {1u, 2u, 5u, 9u, 10u, 11u, 19u, 20u})
            for (const std::size_t n : {1, 33, 1025, 5000})
                check_sort(gpu, test::with_duplicates(n, n / 10, n + bits), bits);
        check_sort(gpu, test::clustered(test::by_size(200001, 2500), 17), 10);
        check_sort(gpu, test::nested_clusters(test::by_size(20000, 1000), 18), 20);
    }

    TEST_CASE("gpu sort: every family, with its duplicates and suspects") {
        GpuStages gpu;
        for (const PointSet& set : test::families(test::by_size(700, 200), 19))
            for (const std::uint32_t bits : {20u, 3u}) check_sort(gpu, set, bits);
    }

    TEST_CASE("gpu sort: the curve goes from block to block") {
        GpuStages gpu;
        for (const std::uint32_t bits : {1u, 2u, 4u}) {
            const std::size_t side = std::size_t{1} << bits;
            PointSet set = test::cubic(side);
            set.box = test::cube(-0.5, static_cast<double>(side) - 0.5);
            check_sort(gpu, set, bits);
            const auto order = gpu.seeds.order();
            for (std::size_t s = 1; s < order.size(); ++s) {
                double steps = 0;
                for (std::size_t a = 0; a < 3; ++a)
                    steps += std::abs(set.points[3 * order[s] + a] - set.points[3 * order[s - 1] + a]);
                REQUIRE(steps == 1);
            }
        }
    }

    TEST_CASE("gpu sort: the lowest index of equal points stays; long runs of equal keys are suspect") {
        GpuStages gpu;
        const PointSet set = test::with_duplicates(test::by_size(5000, 1000), 400, 20);
        check_sort(gpu, set, 20);
        std::map<std::array<double, 3>, std::uint32_t> first;
        std::vector<bool> expected;
        for (std::size_t i = 0; i < set.size(); ++i)
            expected.push_back(!first
                                    .try_emplace({set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]},
                                                 static_cast<std::uint32_t>(i))
                                    .second);
        CHECK(gpu.seeds.state().suspects == 0);
        CHECK(gpu.seeds.state().duplicates == 400);
        for (const std::uint32_t word : gpu.seeds.order())
            REQUIRE(((word & DUPLICATE_BIT) != 0) == expected[word & INDEX_MASK]);

        PointSet same{"same", {}, test::unit_box()};
        for (int i = 0; i < 300; ++i) same.points.insert(same.points.end(), {0.25, 0.5, 0.75});
        check_sort(gpu, same, 20);
        CHECK(gpu.seeds.state().duplicates == 299);
        CHECK(gpu.seeds.state().suspects == 0);

        check_sort(gpu, test::uniform(2000, 21), 1);  // one block holds some 250 different points
        CHECK(gpu.seeds.state().suspects == 1);
        for (const std::size_t n : {MAX_LOOK_BACK, MAX_LOOK_BACK + 1, MAX_LOOK_BACK + 2}) {
            PointSet few = test::uniform(n, 22);
            for (double& x : few.points) x /= 8;  // all in one block
            check_sort(gpu, few, 1);
            CHECK(gpu.seeds.state().suspects == (n > MAX_LOOK_BACK + 1 ? 1u : 0u));
        }
        // Equal in units, different as given.
        PointSet lossy{"lossy", {0.5, 0.5, 0.5, 0x1p-70, 0.25, 0.75, 0x1p-71, 0.25, 0.75}, test::unit_box()};
        check_sort(gpu, lossy, 20);
        CHECK(gpu.seeds.state().suspects == 1);
        CHECK(gpu.seeds.state().duplicates == 0);
    }
}
