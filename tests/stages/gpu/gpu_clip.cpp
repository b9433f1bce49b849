// Stages clip and download of the GPU engine: certified cells equal the CPU's, and others have a reason.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "gpu/cells/part_download.hpp"
#include "gpu/chunk.hpp"
#include "gpu/passes/kernel_choice.hpp"
#include "support/check.hpp"
#include "support/gpu/gpu.hpp"
#include "support/gpu/gpu_stages.hpp"
#include "test_shaders.hpp"

using test::GpuStages;
using test::PointSet;
using votess::gpu::Chunk;
using votess::gpu::ChunkJob;
using votess::gpu::Kernel;
using votess::gpu::PassSettings;

namespace {

// Cells by status.
using Counts = std::array<std::size_t, 8>;

double fraction(const Counts& counts, std::uint32_t status) {
    double all = 0;
    for (const std::size_t c : counts) all += static_cast<double>(c);
    return static_cast<double>(counts[status]) / all;
}

struct Wanted {
    bool walls = true, neighbors = true, second_tier = true;
    std::uint32_t chunk = 0;  // cells; 0 = all
};

// The results of a batch, by member.
struct DownloadedCells {
    std::vector<std::size_t> begins{0};
    std::vector<std::int32_t> rows;
    std::vector<double> geometry;

    DownloadedCells(GpuStages& gpu, votess::gpu::PartDownload& download, bool neighbors) {
        download.read_cells(*gpu.passes);
        for (const std::uint32_t length : download.lengths()) begins.push_back(begins.back() + length);
        if (neighbors)
            download.read_rows(*gpu.passes, [&](const votess::gpu::DeviceRows& slice) {
                REQUIRE(begins[slice.first] == rows.size());
                rows.insert(rows.end(), slice.ids.begin(), slice.ids.end());
            });
        if (gpu.passes->settings.measure)
            download.read_geometry([&](std::size_t first, std::size_t count, const votess::gpu::Numbers& numbers) {
                REQUIRE(4 * first == geometry.size());
                for (std::size_t i = 0; i < 4 * count; ++i) geometry.push_back(numbers[i]);
            });
    }
    [[nodiscard]] std::span<const std::int32_t> row(std::size_t member, std::size_t length) const {
        return std::span(rows).subspan(begins[member], length);
    }
};

// Clips all cells of a set and checks the certified ones.
Counts check_cells(GpuStages& gpu, const PointSet& set, const Wanted& wanted = {}) {
    CAPTURE(set.name);
    CAPTURE(set.size());
    auto options = test::all_options();
    options.list_walls = wanted.walls;
    const auto cpu = test::run(set, options);
    gpu.upload_and_sort(set);
    const auto order = gpu.seeds.order();
    const auto n = static_cast<std::uint32_t>(set.size());
    const std::uint32_t size = wanted.chunk == 0 ? n : wanted.chunk;
    ChunkJob job;
    job.walls = wanted.walls;
    job.neighbors = wanted.neighbors;
    job.own_count = n;
    job.volume_tolerance = 0.5e-5;
    Chunk chunk(*gpu.gpu.device, gpu.memory, size, gpu.passes->settings);
    votess::gpu::PartDownload download(*gpu.gpu.device, gpu.memory);
    download.begin({.members = n,
                    .neighbors = wanted.neighbors,
                    .measure = gpu.passes->settings.measure,
                    .min_entries = chunk.on_device().max_entries(size)});
    Counts counts{};
    for (std::uint32_t first = 0; first < n; first += size) {
        const std::uint32_t count = std::min(size, n - first);
        download.begin_batch();
        chunk.start(gpu.seeds, *gpu.passes, job, {.first = first, .count = count, .second_tier = wanted.second_tier},
                    download.on_device());
        chunk.wait();
        REQUIRE(chunk.info().size() == count);
        const DownloadedCells cells(gpu, download, wanted.neighbors);
        CHECK((!wanted.neighbors || chunk.entries() == cells.rows.size()));
        std::size_t left = 0;
        for (std::uint32_t c = 0; c < count; ++c) {
            const std::uint32_t info = chunk.info()[c], status = info & 0xff;
            const std::uint32_t input = order[first + c] & INDEX_MASK;
            const std::size_t length = download.lengths()[input];
            REQUIRE(download.info()[input] == info);
            REQUIRE(status < counts.size());
            ++counts[status];
            REQUIRE(((order[first + c] & DUPLICATE_BIT) != 0) == (status == STATUS_DUPLICATE));
            left += status != STATUS_CERTIFIED && status != STATUS_DUPLICATE;
            if (status != STATUS_CERTIFIED || !wanted.neighbors) REQUIRE(length == 0);
            if (status != STATUS_CERTIFIED) continue;
            CAPTURE(input);
            REQUIRE((info >> INFO_FACES_SHIFT & 0xff) == cpu.face_counts()[input]);
            REQUIRE((info >> INFO_VERTICES_SHIFT & 0xff) == cpu.vertex_counts()[input]);
            if (wanted.neighbors) REQUIRE(std::ranges::equal(cells.row(input, length), cpu.neighbors(input)));
            if (!gpu.passes->settings.measure) continue;
            const int exponent = static_cast<int>(info >> INFO_EXPONENT_SHIFT) - gpu.seeds.on_device().units().shift;
            const double volume = std::ldexp(cells.geometry[4 * input], 3 * exponent), exact = cpu.volumes()[input];
            REQUIRE(std::abs(volume - exact) <= 1e-5 * exact);
            for (std::uint32_t a = 0; a < 3; ++a) {
                const double centroid =
                    set.points[3 * input + a] + std::ldexp(cells.geometry[4 * input + 1 + a], exponent);
                // Certified cells are not needles: their volume gives their size.
                REQUIRE(std::abs(centroid - cpu.centroids()[3 * input + a]) <=
                        1e-4 * std::cbrt(exact) + 1e-15 * std::abs(centroid));
            }
        }
        if (wanted.second_tier) CHECK(chunk.left_count() >= left);
    }
    return counts;
}

// Of an invocation or of a subgroup per cell.
class Kernels {
public:
    explicit Kernels(Kernel kernel) : kernel_(kernel) {}

    [[nodiscard]] PassSettings with(auto&& change) const {
        PassSettings settings = test::pass_settings();
        settings.subgroup_size = votess::gpu::choose_subgroup_size(gpu.gpu.device->adapter(), kernel_);
        change(settings);
        return settings;
    }
    void use(auto&& change) { gpu.use(with(change)); }
    void use() {
        use([](PassSettings&) {});
    }
    [[nodiscard]] bool by_subgroup() const { return kernel_ == Kernel::subgroup; }

    GpuStages gpu;

private:
    Kernel kernel_;
};

// Runs the check with both.
void with_both(auto&& check) {
    for (const Kernel kernel : {Kernel::invocation, test::by_subgroup()}) {
        CAPTURE(static_cast<int>(kernel));
        Kernels kernels(kernel);
        kernels.use();
        check(kernels);
    }
}

// Subgroups of sizes that lavapipe lacks, emulated by work-groups; that is slow.
void check_by_work_groups(std::uint32_t lanes) {
    Kernels kernels(Kernel::invocation);
    GpuStages& gpu = kernels.gpu;
    const auto spirv = gpu.gpu.device->has_float64() ? votess::gpu::shaders::test_clip_by_work_group_f64
                                                     : votess::gpu::shaders::test_clip_by_work_group_f32;
    kernels.use([&](PassSettings& s) { s.subgroup_size = lanes; });
    auto& pass = gpu.passes->clip_first;
    const std::uint32_t unit = std::bit_cast<std::uint32_t>(0x1p-23f);
    pass = votess::gpu::vulkan::Pass(*gpu.gpu.device, {.name = "clip_subgroup by work-groups",
                                                       .spirv = spirv,
                                                       .push_bytes = pass.push_bytes(),
                                                       .local_size = lanes,
                                                       .constants = {{CONSTANT_MAX_VERTICES, 64},
                                                                     {CONSTANT_LANES, lanes},
                                                                     {CONSTANT_SUBGROUPS, 1},
                                                                     {CONSTANT_LOCKSTEP, 0},
                                                                     {CONSTANT_FIRST_COUNT, 48},
                                                                     {CONSTANT_GEOMETRY, 1},
                                                                     {CONSTANT_UNIT_ROUNDOFF, unit},
                                                                     {CONSTANT_WALLS, 0},
                                                                     {CONSTANT_WEIGHTS, 0},
                                                                     {CONSTANT_TIER, 0}}});
    const std::size_t n = test::by_size(50, 40);
    CHECK(fraction(check_cells(gpu, test::uniform(n, 34), {.second_tier = false}), STATUS_CERTIFIED) > 0.97);
    CHECK(fraction(check_cells(gpu, test::clustered(n, 35), {.second_tier = false}), STATUS_CERTIFIED) > 0.6);
    CHECK(fraction(check_cells(gpu, test::fcc(3), {.second_tier = false}), STATUS_CERTIFIED) == 1);
    check_cells(gpu, test::with_duplicates(n, n / 10, 37));
    check_cells(gpu, test::on_sphere_and_center(n / 3, 39));
    for (const std::size_t few : {1, 9}) check_cells(gpu, test::uniform(few, few));
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu clip: every family") {
        with_both([](Kernels& kernels) {
            for (const PointSet& set : test::families(test::by_size(300, 100), 21)) check_cells(kernels.gpu, set);
        });
    }

    TEST_CASE("gpu clip: rows and areas seen through windows") {
        PassSettings settings = test::pass_settings();
        settings.areas = true;
        settings.measure_float64 = false;
        GpuStages gpu(settings);
        const PointSet set = test::uniform(400, 22);
        const auto cpu = test::run(set, test::all_options());
        gpu.upload_and_sort(set);
        constexpr std::uint32_t window_bits = 10;
        const auto entries = static_cast<std::uint32_t>(cpu.indices().size());
        REQUIRE(entries > 5u << window_bits);
        for (const std::uint32_t capacity : {entries, entries - 700, 3u << window_bits, 1000u}) {
            votess::gpu::OwnBuffers buffers(gpu.memory);
            votess::gpu::DeviceCells cells;
            cells.reserve(buffers, 400, gpu.passes->settings);
            const test::vk::Buffer rows = gpu.memory.buffer(capacity * 4, test::vk::MemoryKind::download);
            std::ranges::fill(rows.as<std::int32_t>(), -77);
            rows.flush();
            const test::vk::Buffer areas = gpu.memory.buffer(capacity * 8, test::vk::MemoryKind::download);
            cells.set_rows_out(
                {.rows = rows, .areas = areas, .shifts = {}, .capacity = capacity, .window_bits = window_bits});
            ChunkJob job;
            job.walls = true;
            job.own_count = 400;
            cells.set_job(gpu.seeds.on_device(), gpu.passes->settings, job, 0, 400);
            test::vk::Commands commands(*gpu.gpu.device);
            commands.begin();
            commands.fill(cells.state(), 0, sizeof(votess::gpu::ChunkState), 0);
            commands.barrier();
            cells.record_knn(commands, *gpu.passes);
            cells.record_clip(commands, *gpu.passes, true);
            cells.record_rows(commands, *gpu.passes);
            commands.barrier_to_host();
            commands.end();
            commands.submit();
            commands.wait();
            rows.invalidate();
            areas.invalidate();
            const auto lengths = gpu.read<std::uint32_t>(cells.words_of(WORDS_ROW_LENGTH), 400);
            const auto infos = gpu.read<std::uint32_t>(cells.words_of(WORDS_INFO), 400);
            const int shift = gpu.seeds.on_device().units().shift;
            const votess::gpu::Numbers of_areas{areas.mapped(), false};
            const auto found = rows.as<std::int32_t>().first(capacity);
            std::size_t at = 0;
            for (std::size_t c = 0; c < 400; at += lengths[c++]) {
                if (lengths[c] == 0) continue;
                if (at + lengths[c] > capacity) {  // not in part
                    REQUIRE(std::ranges::all_of(found.subspan(std::min<std::size_t>(at, capacity)),
                                                [](std::int32_t id) { return id == -77; }));
                    continue;
                }
                const std::uint32_t seed = gpu.seeds.order()[c] & INDEX_MASK;
                REQUIRE(std::ranges::equal(found.subspan(at, lengths[c]), cpu.neighbors(seed)));
                const int exponent = static_cast<int>(infos[c] >> INFO_EXPONENT_SHIFT) - shift;
                const auto of_cpu = cpu.face_areas().subspan(static_cast<std::size_t>(cpu.indptr()[seed]), lengths[c]);
                const double surface = std::accumulate(of_cpu.begin(), of_cpu.end(), 0.0);
                for (std::size_t i = 0; i < lengths[c]; ++i)
                    REQUIRE(std::abs(std::ldexp(of_areas[at + i], 2 * exponent) - of_cpu[i]) <= 1e-5 * surface);
            }
        }
    }

    TEST_CASE("gpu clip: every size, whole and in chunks") {
        with_both([](Kernels& kernels) {
            for (const std::size_t n : test::sizes_across_groups) {
                if (n > test::by_size(1025, 260)) continue;
                const Counts counts = check_cells(kernels.gpu, test::uniform(n, n));
                CHECK(counts[STATUS_CERTIFIED] + n / 100 + 1 >= n);
            }
            for (const std::uint32_t chunk : {1u, 63u, 64u, 65u, 100u})
                check_cells(kernels.gpu, test::with_duplicates(test::by_size(300, 130), 30, 22), {.chunk = chunk});
        });
    }

    TEST_CASE("gpu clip: nearly all random cells are certified, no tie ever is") {
        with_both([](Kernels& kernels) {
            GpuStages& gpu = kernels.gpu;
            const std::size_t n = test::by_size(4000, 800);
            const Counts both = check_cells(gpu, test::uniform(n, 23));
            CHECK(fraction(both, STATUS_CERTIFIED) > 0.995);
            const Counts first = check_cells(gpu, test::uniform(n, 23), {.second_tier = false});
            CHECK(fraction(first, STATUS_CERTIFIED) > (kernels.by_subgroup() ? 0.98 : 0.9));
            CHECK(first[STATUS_CERTIFIED] <= both[STATUS_CERTIFIED]);
            const Counts lattice = check_cells(gpu, test::fcc(test::by_size(12, 6)));
            CHECK(fraction(lattice, STATUS_NEEDS_EXACT) > 0.9);
            const Counts duplicates = check_cells(gpu, test::with_duplicates(n / 4, n / 40, 24));
            CHECK(duplicates[STATUS_DUPLICATE] == n / 40);
            CHECK(duplicates[7] == 0);
            CHECK(duplicates[6] == 0);
        });
    }

    TEST_CASE("gpu clip: what is not wanted is not there") {
        with_both([](Kernels& kernels) {
            const PointSet set = test::uniform(test::by_size(700, 200), 25);
            check_cells(kernels.gpu, set, {.walls = false});
            check_cells(kernels.gpu, set, {.neighbors = false});
            kernels.use([](PassSettings& s) { s.measure = false; });
            check_cells(kernels.gpu, set);
        });
    }

    TEST_CASE("gpu clip: short lists, few planes and few vertices overflow with the right status") {
        with_both([](Kernels& kernels) {
            GpuStages& gpu = kernels.gpu;
            kernels.use([](PassSettings& s) { s.k = 8; });
            const PointSet set = test::uniform(test::by_size(700, 300), 26);
            const Counts short_lists = check_cells(gpu, set, {.second_tier = false});
            // A subgroup continues where the first search ended.
            if (!kernels.by_subgroup()) CHECK(fraction(short_lists, STATUS_CANDIDATES_EXHAUSTED) > 0.9);
            CHECK(fraction(check_cells(gpu, set), STATUS_CERTIFIED) > 0.95);

            kernels.use([](PassSettings& s) { s.tiers[0].vertices = 32; });
            CHECK(check_cells(gpu, set, {.second_tier = false})[STATUS_VERTEX_OVERFLOW] > set.size() / 20);
            CHECK(fraction(check_cells(gpu, set), STATUS_CERTIFIED) > 0.95);

            // A prism has more planes than vertices fit into; its cells are few.
            kernels.use([](PassSettings& s) {
                s.k = 200;
                s.tiers[0].vertices = 128;
            });
            PointSet star{"star", {}, test::cube(-2, 2)};
            for (int i = 0; i < 60; ++i) {
                const double angle = i * 0.104;
                star.points.insert(star.points.end(), {std::cos(angle), std::sin(angle), 0.001 * i});
            }
            star.points.insert(star.points.end(), {0, 0, 0.03});
            CHECK(check_cells(gpu, star, {.second_tier = false})[STATUS_PLANE_OVERFLOW] > 0);
            check_cells(gpu, star);
            check_cells(gpu, test::on_sphere_and_center(150, 27), {.second_tier = false});
            check_cells(gpu, test::on_sphere_and_center(150, 27));
        });
    }

    TEST_CASE("gpu clip: in float64 far more is certain") {
        with_both([](Kernels& kernels) {
            GpuStages& gpu = kernels.gpu;
            if (!gpu.gpu.device->has_float64()) return;
            kernels.use([](PassSettings& s) { s.tiers[0].float64 = true; });
            const PointSet set = test::jittered(test::by_size(9, 5), 1e-6, 28);
            CHECK(fraction(check_cells(gpu, set, {.second_tier = false}), STATUS_CERTIFIED) > 0.9);
            kernels.use();
            CHECK(fraction(check_cells(gpu, set, {.second_tier = false}), STATUS_CERTIFIED) < 0.5);
            CHECK(fraction(check_cells(gpu, set), STATUS_CERTIFIED) > 0.9);  // by the second tier
        });
    }

    TEST_CASE("gpu clip: searches of a subgroup, short and long, in work-groups of few and many") {
        if (test::by_subgroup() != Kernel::subgroup) return;
        Kernels kernels(Kernel::subgroup);
        GpuStages& gpu = kernels.gpu;
        const std::size_t n = test::by_size(600, 150);
        const struct { std::uint32_t first_count, subgroups; } variants[] = {{1, 1}, {30, 16}};
        for (const auto& [first_count, subgroups] : variants) {
            CAPTURE(first_count);
            kernels.use([&](PassSettings& s) {
                s.first_count = first_count;
                s.subgroups = subgroups;
            });
            CHECK(fraction(check_cells(gpu, test::uniform(n, 29), {.second_tier = false}), STATUS_CERTIFIED) > 0.9);
            CHECK(fraction(check_cells(gpu, test::clustered(n, 30), {.second_tier = false}), STATUS_CERTIFIED) > 0.6);
            check_cells(gpu, test::nested_clusters(n, 31));
            check_cells(gpu, test::with_duplicates(n, n / 10, 32));
        }
        kernels.use([](PassSettings& s) { s.max_subgroup_visits[0] = 20; });
        CHECK(fraction(check_cells(gpu, test::uniform(n, 29), {.second_tier = false}), STATUS_CANDIDATES_EXHAUSTED) >
              0.9);
        CHECK(fraction(check_cells(gpu, test::uniform(n, 29)), STATUS_CERTIFIED) > 0.97);  // by longer searches
    }

    TEST_CASE("gpu clip: subgroups of another size than the kernel was made for leave all cells") {
        if (test::by_subgroup() != Kernel::subgroup) return;
        Kernels kernels(Kernel::subgroup);
        GpuStages& gpu = kernels.gpu;
        const PointSet set = test::uniform(test::by_size(300, 130), 33);
        const votess::gpu::vulkan::Adapter& adapter = gpu.gpu.device->adapter();
        const std::uint32_t other = 4;
        if (other >= adapter.min_subgroup_size && other <= adapter.max_subgroup_size) return;
        kernels.use([&](PassSettings& s) {
            s.subgroup_size = other;
            s.subgroups = 64 / other;
        });
        CHECK(fraction(check_cells(gpu, set), STATUS_CANDIDATES_EXHAUSTED) == 1);
    }

    // More lanes than planes. Mesa takes a minute to compile the kernel for 32.
    TEST_CASE("gpu clip: subgroups of 64, by work-groups") {
        check_by_work_groups(64);
    }

    TEST_CASE("gpu clip: what a device must have for a subgroup per cell") {
        if (test::by_subgroup() != Kernel::subgroup) return;
        const Kernels kernels(Kernel::subgroup);
        votess::gpu::vulkan::Adapter adapter = kernels.gpu.gpu.device->adapter();
        using votess::gpu::choose_subgroup_size;
        using votess::gpu::missing_for_subgroups;
        CHECK(missing_for_subgroups(adapter) == "");
        using votess::gpu::kernel_from_environment;
        for (const Kernel kernel : {Kernel::automatic, Kernel::invocation, Kernel::subgroup}) {
            const test::UseKernel chosen(kernel);
            CHECK(kernel_from_environment() == kernel);
        }
        {
            const test::Environment unknown("VOTESS_VULKAN_KERNEL", "warp");
            CHECK(test::error_of([] { (void)kernel_from_environment(); }) == votess::ErrorCode::invalid_argument);
        }
        CHECK(choose_subgroup_size(adapter, Kernel::invocation) == 0);
        CHECK(choose_subgroup_size(adapter, Kernel::subgroup) >= 8);
        adapter.type = VK_PHYSICAL_DEVICE_TYPE_CPU;
        CHECK(choose_subgroup_size(adapter, Kernel::automatic) == 0);
        adapter.type = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
        adapter.subgroup_size_control = false;
        for (const std::uint32_t size : {8u, 16u, 32u, 64u}) {
            adapter.subgroup_size = adapter.min_subgroup_size = adapter.max_subgroup_size = size;
            CHECK(choose_subgroup_size(adapter, Kernel::automatic) == size);
        }
        adapter.subgroup_size_control = true;  // then the size nearest to 32
        adapter.min_subgroup_size = 32, adapter.max_subgroup_size = 64;
        CHECK(choose_subgroup_size(adapter, Kernel::automatic) == 32);
        adapter.min_subgroup_size = 8, adapter.max_subgroup_size = 16;
        CHECK(choose_subgroup_size(adapter, Kernel::automatic) == 16);

        const auto refused = [](const votess::gpu::vulkan::Adapter& a, const std::string& word) {
            CHECK(choose_subgroup_size(a, Kernel::automatic) == 0);
            CHECK(missing_for_subgroups(a).find(word) != std::string::npos);
            std::string message;
            CHECK(test::error_of([&] { (void)choose_subgroup_size(a, Kernel::subgroup); }, &message) ==
                  votess::ErrorCode::unsupported);
            CHECK(message.find(word) != std::string::npos);
        };
        votess::gpu::vulkan::Adapter other = adapter;
        other.subgroup_operations &= ~static_cast<VkFlags>(VK_SUBGROUP_FEATURE_ARITHMETIC_BIT);
        refused(other, "arithmetic");
        other = adapter;
        other.subgroup_in_compute = false;
        refused(other, "compute");
        other = adapter;
        other.subgroup_size_control = false;
        refused(other, "which varies");
        other.vendor_id = 0x1002;
        CHECK(choose_subgroup_size(other, Kernel::automatic) == 64);
        other.min_subgroup_size = other.max_subgroup_size;
        other.subgroup_size = 128;
        refused(other, "128");
        other.subgroup_size = 4;
        refused(other, "it has 4");
    }

    TEST_CASE("gpu clip: numbers that measure a cell") {
        using votess::gpu::Measure;
        using votess::gpu::measure_from_environment;
        using votess::gpu::measures_in_float64;
        CHECK(measure_from_environment() == Measure::automatic);
        {
            const test::Environment asked("VOTESS_VULKAN_MEASURE", "float32");
            CHECK(measure_from_environment() == Measure::float32);
        }
        {
            const test::Environment unknown("VOTESS_VULKAN_MEASURE", "float16");
            CHECK(test::error_of([] { (void)measure_from_environment(); }) == votess::ErrorCode::invalid_argument);
        }
        votess::gpu::vulkan::Adapter adapter;
        adapter.type = VK_PHYSICAL_DEVICE_TYPE_CPU;
        CHECK(measures_in_float64(adapter, true, Measure::automatic));
        CHECK(!measures_in_float64(adapter, false, Measure::automatic));
        adapter.type = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
        const auto is_fast = [&](const char* name) {
            adapter.name = name;
            return measures_in_float64(adapter, true, Measure::automatic);
        };
        for (const char* name : {"NVIDIA H100 80GB HBM3", "NVIDIA A100-SXM4-80GB", "Tesla V100-PCIE-16GB",
                                 "NVIDIA TITAN V", "A30", "AMD Radeon VII (RADV VEGA20)"})
            CHECK_MESSAGE(is_fast(name), name);
        for (const char* name : {"NVIDIA RTX A3000 Laptop GPU", "NVIDIA GeForce RTX 4090", "NVIDIA TITAN Xp",
                                 "NVIDIA A10", "AMD Radeon RX 6800 (RADV NAVI21)", ""})
            CHECK_MESSAGE(!is_fast(name), name);
        CHECK(measures_in_float64(adapter, true, Measure::float64));
        CHECK(!measures_in_float64(adapter, true, Measure::float32));
        CHECK(test::error_of([&] { (void)measures_in_float64(adapter, false, Measure::float64); }) ==
              votess::ErrorCode::unsupported);
    }
}
