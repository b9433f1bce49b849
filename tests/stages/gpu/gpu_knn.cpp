// Stage knn of the GPU engine: boxes that bound their seeds, and lists that hold all seeds up to their reach.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "gpu/cells/part_download.hpp"
#include "gpu/chunk.hpp"
#include "support/check.hpp"
#include "support/gpu/gpu_stages.hpp"
#include "support/random.hpp"

using test::GpuStages;
using test::Integers;
using test::PointSet;
using votess::gpu::Chunk;
using votess::gpu::ChunkJob;
using Squared = unsigned __int128;  // of units: below 2^126

namespace {

struct Node {
    std::uint64_t lower[3], upper[3];
    bool operator==(const Node&) const = default;
};

constexpr Node no_seeds{{test::no_coordinate, test::no_coordinate, test::no_coordinate}, {0, 0, 0}};

void check_boxes(GpuStages& gpu) {
    const auto seeds = gpu.coordinates(BINDING_SEEDS);
    const std::size_t n = gpu.seeds.count();
    const auto first = gpu.seeds.on_device().level_first();
    const std::size_t levels = gpu.seeds.on_device().level_first().size();
    const auto nodes = gpu.read<Node>(BINDING_NODES, first.back() + 1);
    REQUIRE(levels <= MAX_LEVELS);
    std::size_t width = GROUP_SEEDS;  // seeds below a node
    for (std::size_t level = 0; level < levels; ++level, width *= FAN) {
        const std::size_t count = (n + width - 1) / width;
        REQUIRE(first[level] + count == (level + 1 < levels ? first[level + 1] : first[level] + 1));
        for (std::size_t k = 0; k < count; ++k) {
            Node box = no_seeds;
            for (std::size_t s = k * width; s < std::min(n, (k + 1) * width); ++s)
                for (std::size_t a = 0; a < 3; ++a) {
                    if (seeds[a][s] == test::no_coordinate) continue;  // a duplicate
                    box.lower[a] = std::min(box.lower[a], seeds[a][s]);
                    box.upper[a] = std::max(box.upper[a], seeds[a][s]);
                }
            REQUIRE(nodes[first[level] + k] == box);
        }
    }
}

Squared square(std::uint64_t a, std::uint64_t b) {
    const Squared d = a > b ? a - b : b - a;
    return d * d;
}

// Finished lists of a chunk, and the checks on them.
struct Lists {
    std::uint32_t k, cells;
    std::vector<std::uint32_t> list, lengths;
    std::vector<float> reaches;
    std::vector<Integers> seeds;

    [[nodiscard]] std::uint32_t length(std::size_t cell) const { return lengths[cell] & 0xffff; }
    [[nodiscard]] std::uint32_t unsorted(std::size_t cell) const { return lengths[cell] >> 16; }
    [[nodiscard]] float reach(std::size_t cell) const { return reaches[cell]; }
    [[nodiscard]] std::uint32_t neighbor(std::size_t cell, std::size_t i) const { return list[i * cells + cell]; }
    [[nodiscard]] Squared distance(std::size_t s, std::size_t q) const {
        return square(seeds[0][s], seeds[0][q]) + square(seeds[1][s], seeds[1][q]) + square(seeds[2][s], seeds[2][q]);
    }
    [[nodiscard]] bool is_duplicate(std::size_t s) const { return seeds[0][s] == test::no_coordinate; }

    // Checks the list of sorted seed `s`, which is `cell` in the chunk. Returns an empty text when it is right.
    [[nodiscard]] std::string check(std::size_t s, std::size_t cell) const {
        const std::uint32_t n = length(cell);
        const auto wrong = [&](const char* what) { return "seed " + std::to_string(s) + ": " + what; };
        if (n > k || unsorted(cell) > n) return wrong("too many");
        std::vector<bool> listed(seeds[0].size());
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t q = neighbor(cell, i);
            if (q >= listed.size() || q == s || listed[q] || is_duplicate(q)) return wrong("lists a wrong seed");
            listed[q] = true;
        }
        for (std::size_t q = 0; q < listed.size(); ++q)
            if (!listed[q] && q != s && !is_duplicate(q) &&
                static_cast<long double>(distance(s, q)) < static_cast<long double>(reach(cell)))
                return wrong("misses a seed within its reach");
        Squared nearest_beyond = 0;  // later ones may not be nearer
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t q = neighbor(cell, i);
            const Squared d = distance(s, q);
            const auto rough = static_cast<long double>(d);
            if (rough < static_cast<long double>(nearest_beyond) * BUCKET_SLACK * (1 - 1e-5l))
                return wrong("is not sorted by bucket");
            if (i >= unsorted(cell)) nearest_beyond = std::max(nearest_beyond, d);
        }
        // The first bucket is nearer than the rest.
        Squared farthest_first = 0;
        for (std::uint32_t i = 0; i < unsorted(cell); ++i)
            farthest_first = std::max(farthest_first, distance(s, neighbor(cell, i)));
        for (std::uint32_t i = unsorted(cell); i < n; ++i)
            if (static_cast<long double>(distance(s, neighbor(cell, i))) <
                static_cast<long double>(farthest_first) * (1 - 1e-5l))
                return wrong("has farther seeds in the first bucket than behind");
        return "";
    }
};

ChunkJob whole_job(std::uint32_t own_count) {
    ChunkJob job;
    job.own_count = own_count;
    return job;
}

Lists search(GpuStages& gpu, std::uint32_t k, const ChunkJob& job, std::uint32_t first, std::uint32_t count) {
    Chunk chunk(*gpu.gpu.device, gpu.memory, count, gpu.passes->settings);
    votess::gpu::PartDownload download(*gpu.gpu.device, gpu.memory);
    download.begin({.members = job.own_count, .min_entries = chunk.on_device().max_entries(count)});
    chunk.start(gpu.seeds, *gpu.passes, job, {.first = first, .count = count, .second_tier = false},
                download.on_device());
    chunk.wait();
    const votess::gpu::DeviceCells& cells = chunk.on_device();
    test::vk::Slice lists = cells.words_of(WORDS_LIST);
    lists.size *= k;
    return {k,
            count,
            gpu.read<std::uint32_t>(lists, std::size_t{k} * count),
            gpu.read<std::uint32_t>(cells.words_of(WORDS_LIST_LENGTHS), count),
            gpu.read<float>(cells.words_of(WORDS_LIST_REACH), count),
            gpu.coordinates(BINDING_SEEDS)};
}

struct Reached {
    std::size_t cells = 0, none = 0, all = 0;  // lists without reach, and with unlimited reach
    double mean_length = 0;
};

// Checks all lists of a set, and about `samples` of them against all seeds.
Reached check_lists(GpuStages& gpu, const PointSet& set, std::uint32_t k, std::size_t samples) {
    CAPTURE(set.name);
    CAPTURE(set.size());
    CAPTURE(k);
    gpu.upload_and_sort(set);
    check_boxes(gpu);
    const Lists lists = search(gpu, k, whole_job(gpu.seeds.count()), 0, gpu.seeds.count());
    Reached reached;
    test::Random random(set.size());
    for (std::size_t s = 0; s < lists.cells; ++s) {
        if (lists.is_duplicate(s)) {
            REQUIRE(lists.length(s) == 0);
            continue;
        }
        ++reached.cells;
        reached.none += lists.reach(s) == 0;
        reached.all += lists.reach(s) >= static_cast<float>(UNBOUNDED);
        reached.mean_length += lists.length(s);
        if (random.chance(static_cast<double>(samples) / lists.cells)) REQUIRE(lists.check(s, s) == "");
    }
    reached.mean_length /= static_cast<double>(std::max<std::size_t>(reached.cells, 1));
    return reached;
}

PointSet all_equal(std::size_t n) {
    PointSet set{"all equal", {}, test::unit_box()};
    for (std::size_t i = 0; i < n; ++i) set.points.insert(set.points.end(), {0.3, 0.3, 0.6});
    return set;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu knn: boxes bound their seeds, every size") {
        GpuStages gpu;
        std::vector<std::size_t> sizes = test::sizes_across_groups;
        sizes.insert(sizes.end(), {511, 512, 513, 4095, 4096, 4097, 200000});
        for (const std::size_t n : sizes) {
            if (n > test::by_size(300000, 5000)) continue;
            CAPTURE(n);
            gpu.upload_and_sort(test::uniform(n, n));
            check_boxes(gpu);
        }
        gpu.upload_and_sort(test::with_duplicates(1000, 400, 1));
        check_boxes(gpu);
        gpu.upload_and_sort(all_equal(500));
        check_boxes(gpu);
    }

    TEST_CASE("gpu knn: few seeds are all listed") {
        GpuStages gpu(test::pass_settings(64));
        for (const std::size_t n : {1, 2, 7, 8, 9, 31, 32, 33, 63, 64}) {
            const Reached reached = check_lists(gpu, test::uniform(n, n), 64, n);
            CHECK(reached.none == 0);
            CHECK(reached.all == reached.cells);
            CHECK(reached.mean_length == static_cast<double>(n - 1));
        }
        const Reached reached = check_lists(gpu, all_equal(200), 64, 200);
        CHECK(reached.cells == 1);
        CHECK(reached.all == 1);
    }

    TEST_CASE("gpu knn: lists are complete up to their reach, for every k") {
        GpuStages gpu;
        const std::size_t n = test::by_size(2000, 600);
        const std::size_t samples = test::by_size(200, 60);
        for (const std::uint32_t k : {1u, 8u, 64u, 200u}) {
            gpu.use(test::pass_settings(k));
            const Reached uniform = check_lists(gpu, test::uniform(n, 2), k, samples);
            // The last bucket may not fit, or the only one.
            CHECK(uniform.none <= (k >= 8 ? 0 : uniform.cells / 10));
            if (k >= 64) CHECK(uniform.mean_length > 0.75 * k);
            for (const PointSet& set :
                 {test::clustered(n, 3), test::nested_clusters(n / 2, 4), test::with_duplicates(n, n / 4, 5),
                  test::near_duplicates(n / 2, 6), test::far_from_origin(n / 2, 7), test::on_sphere(n / 2, 8),
                  test::on_axis_line(n / 2, 9), test::on_axis_plane(n / 2, 10), test::on_oblique_plane(n / 2, 11)}) {
                CAPTURE(set.name);
                CAPTURE(k);
                const Reached reached = check_lists(gpu, set, k, samples / 2);
                // Lists span few octaves of distance: clusters in clusters need more.
                if (k >= 64 && set.name != "nested clusters") CHECK(reached.none < reached.cells / 5);
            }
            // Many at the same distance do not fit into short lists.
            for (const PointSet& set : {test::cubic(test::by_size(12, 7)), test::fcc(test::by_size(10, 6)),
                                        test::cospherical_and_center(1001)})
                check_lists(gpu, set, k, samples / 2);
        }
    }

    TEST_CASE("gpu knn: many seeds") {
        GpuStages gpu;
        for (const std::size_t n : {1023, 1024, 1025, 8193}) {
            if (n > test::by_size(10000, 1100)) continue;
            const Reached reached = check_lists(gpu, test::uniform(n, n), 112, test::by_size(100, 30));
            CHECK(reached.none == 0);
        }
    }

    TEST_CASE("gpu knn: scales, flat boxes and lost digits") {
        GpuStages gpu(test::pass_settings(64));
        const std::size_t n = test::by_size(1000, 300);
        for (const double thickness : {1e-6, 1e-12, 1e-17}) {
            PointSet set = test::uniform(n, 12);
            for (std::size_t i = 2; i < set.points.size(); i += 3) set.points[i] *= thickness;
            set.box->upper[2] *= thickness;
            CHECK(check_lists(gpu, set, 64, n / 4).none == 0);
        }
        for (const double room : {1e3, 1e9, 1e14}) {  // the seeds take few units
            PointSet set = test::uniform(n, 13);
            set.box = test::cube(-room, room);
            check_lists(gpu, set, 64, n / 4);
        }
    }

    TEST_CASE("gpu knn: few seeds in a small part of the box, where high words alone do not tell their order") {
        for (const std::uint32_t k : {64u, 20u}) {
            GpuStages gpu(test::pass_settings(k));
            for (const std::size_t n : {12, 30, 60, 100, 200})
                for (const double room : {1e2, 1e4, 1e6, 1e7, 1e9}) {
                    PointSet set = test::uniform(n, 17);
                    set.box = test::cube(-room, room);
                    check_lists(gpu, set, k, n);
                    // One is far away: the search reaches it and still orders the near ones.
                    for (int a = 0; a < 3; ++a) set.points.push_back(0.7 * room);
                    check_lists(gpu, set, k, n);
                }
        }
    }

    TEST_CASE("gpu knn: chunks of the seeds give the same lists") {
        GpuStages gpu(test::pass_settings(64));
        gpu.upload_and_sort(test::clustered(1000, 14));
        const Lists all = search(gpu, 64, whole_job(1000), 0, 1000);
        for (const auto& [first, count] : {std::pair{0u, 1u}, {999u, 1u}, {17u, 63u}, {64u, 64u}, {500u, 500u}}) {
            const Lists some = search(gpu, 64, whole_job(1000), first, count);
            for (std::uint32_t c = 0; c < count; ++c) {
                REQUIRE(some.length(c) == all.length(first + c));
                REQUIRE(some.reach(c) == all.reach(first + c));
                for (std::uint32_t i = 0; i < some.length(c); ++i)
                    REQUIRE(some.neighbor(c, i) == all.neighbor(first + c, i));
            }
        }
    }

    TEST_CASE("gpu knn: lists reach no farther than the bounds, and strangers have none") {
        GpuStages gpu(test::pass_settings(64));
        gpu.upload_and_sort(test::uniform(1500, 15));
        const std::uint64_t side = gpu.seeds.on_device().extent()[0];
        const auto input = gpu.read<std::uint32_t>(BINDING_SEED_INPUT, 1500);
        for (std::uint32_t bounded = 0; bounded < 64; bounded += bounded == 0 ? 1 : bounded) {
            for (const std::uint32_t also : {0u, 63u}) {
                ChunkJob job = whole_job(900);
                job.bounded = bounded | also;
                for (int a = 0; a < 3; ++a) {
                    job.lower[a] = side / 100 * static_cast<std::uint64_t>(5 + a);
                    job.upper[a] = side / 100 * static_cast<std::uint64_t>(90 + a);
                }
                const Lists lists = search(gpu, 64, job, 0, 1500);
                for (std::size_t s = 0; s < 1500; ++s) {
                    if (input[s] >= job.own_count) {
                        REQUIRE(lists.length(s) == 0);
                        continue;
                    }
                    for (std::size_t a = 0; a < 3; ++a) {
                        const std::uint64_t p = lists.seeds[a][s];
                        const auto within = [&](std::uint64_t from, std::uint64_t to) {
                            const Squared most = from > to ? 0 : square(from, to);
                            return static_cast<long double>(lists.reach(s)) <= static_cast<long double>(most);
                        };
                        if ((job.bounded >> a & 1) != 0) REQUIRE(within(job.lower[a], p));
                        if ((job.bounded >> (3 + a) & 1) != 0) REQUIRE(within(p, job.upper[a]));
                    }
                    if (s % 16 == 0) REQUIRE(lists.check(s, s) == "");
                }
            }
        }
    }

    TEST_CASE("gpu knn: a search that looks at too many boxes says so") {
        votess::gpu::PassSettings settings = test::pass_settings(64);
        settings.max_visits = 5;
        GpuStages gpu(settings);
        const Reached reached = check_lists(gpu, test::uniform(3000, 16), 64, 50);
        CHECK(reached.none == reached.cells);
    }
}
