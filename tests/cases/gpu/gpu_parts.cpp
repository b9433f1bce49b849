// The GPU engine with limits of smaller devices: seeds in several parts, other work-groups, no float64.
#include <doctest/doctest.h>

#include <algorithm>
#include <optional>

#include "support/gpu/gpu.hpp"

namespace {

using test::PointSet;
using votess::Options;
using votess::gpu::EngineLimits;
using votess::gpu::Kernel;

std::string compare(test::GpuRunner& runner, const PointSet& set, Options options = test::all_options()) {
    const auto gpu = runner.run(set, options);
    return test::check_same(gpu, test::run(set, options), set.points, test::tolerance(options));
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu: seeds in parts, every family") {
        const test::SharedGpu shared;
        test::GpuRunner small(shared.gpu, {.max_seeds = 300});
        for (const auto kernel : {Kernel::invocation, test::by_subgroup()})
            for (const PointSet& set : test::families(350, 91)) {
                if (test::reduced() && kernel != Kernel::invocation) continue;
                CAPTURE(static_cast<int>(kernel));
                CAPTURE(set.name);
                const test::UseKernel chosen(kernel);
                CHECK(compare(small, set) == "");
            }
        test::GpuRunner large(shared.gpu, {.max_seeds = 1000});
        const std::size_t n = test::by_size(2500, 1100);
        for (const PointSet& set : {test::clustered(n, 88), test::with_duplicates(n, n / 5, 89), test::on_walls(n, 90)})
            CHECK(compare(large, set) == "");
    }

    TEST_CASE("gpu: chunks follow the device's speed, and digits stay the same") {
        const test::SharedGpu shared;
        // Half of the cells are hopeless for the device.
        const std::size_t side = test::by_size(16, 13);
        PointSet half = test::jittered(side, 1e-15, 94);
        const PointSet uniform = test::uniform(side * side * side, 95);
        const auto length = static_cast<double>(side);
        half.box->upper[0] += length;
        for (std::size_t i = 0; i < uniform.points.size(); ++i)
            half.points.push_back(uniform.points[i] * length - 0.5 + (i % 3 == 0 ? length : 0));
        Options options = test::all_options();
        options.threads = 0;
        options.chunk_size = 3000;
        for (const PointSet& set : {test::uniform(test::by_size(9000, 5000), 93), half}) {
            std::optional<votess::Tessellation> first;
            for (const double seconds : {1e-4, 0.02, 1e3}) {
                CAPTURE(seconds);
                test::GpuRunner runner(shared.gpu, {.chunk_seconds = seconds});
                const auto t = runner.run(set, options);
                if (first) {
                    CHECK(std::ranges::equal(t.volumes(), first->volumes()));
                    CHECK(std::ranges::equal(t.centroids(), first->centroids()));
                    continue;
                }
                CHECK(test::check_same(t, test::run(set, options), set.points, test::tolerance(options)) == "");
                first = t;
            }
        }
    }

    TEST_CASE("gpu: rows of a few chunks at a time on the device") {
        const test::SharedGpu shared;
        Options options = test::all_options();
        options.chunk_size = 50;
        for (const std::uint32_t most : {1u, 4000u}) {
            CAPTURE(most);
            test::GpuRunner runner(shared.gpu, {.max_entries = most});
            for (const PointSet& set : {test::uniform(600, 81), test::with_duplicates(500, 90, 82)})
                CHECK(compare(runner, set, options) == "");
            Options periodic = options;
            periodic.periodic = {true, true, true};
            CHECK(compare(runner, test::uniform(400, 83), periodic) == "");
            test::GpuRunner parts(shared.gpu, {.max_seeds = 300, .max_entries = most});
            CHECK(compare(parts, test::uniform(500, 84), options) == "");
        }
    }

    TEST_CASE("gpu: parts leave few cells to the CPU") {
        const test::SharedGpu shared;
        test::GpuRunner runner(shared.gpu, {.max_seeds = test::reduced() ? 2000u : 5000u});
        const PointSet set = test::uniform(test::by_size(12000, 4000), 92);
        Options options = test::all_options();
        options.threads = 0;
        options.chunk_size = 500;
        {
            const test::UseKernel chosen(test::by_subgroup());
            CHECK(runner.run(set, options).stats().fallback_cells < set.size() / 3);
        }
        std::vector<double> fractions;
        options.progress = [&](double fraction) {
            fractions.push_back(fraction);
            return true;
        };
        const auto t = runner.run(set, options);
        CHECK(std::is_sorted(fractions.begin(), fractions.end()));
        CHECK(fractions.back() > 0.5);  // the end is reported by the caller
        CHECK(fractions.back() <= 1);
        options.progress = nullptr;
        CHECK(t.stats().fallback_cells < set.size() / 3);
        CHECK(test::check_same(t, test::run(set, options), set.points, 1e-5) == "");
    }

    TEST_CASE("gpu: parts and options") {
        const test::SharedGpu shared;
        for (const std::uint32_t most : {2u, 40u}) {
            test::GpuRunner runner(shared.gpu, {.max_seeds = most});
            for (const PointSet& set : {test::uniform(90, 93), test::with_duplicates(90, 20, 94),
                                        test::on_walls(90, 95), test::on_axis_plane(60, 96), test::cubic(4)}) {
                Options options = test::all_options();
                CAPTURE(set.name);
                CAPTURE(most);
                CHECK(compare(runner, set, options) == "");
                options.list_walls = false;
                options.want = {true, false, true, false, set.name != "cubic"};
                options.chunk_size = 16;
                options.threads = 2;
                CHECK(compare(runner, set, options) == "");
            }
        }
        test::GpuRunner runner(shared.gpu, {.max_seeds = 400});
        for (const std::size_t n : {900, 300, 0, 401, 400}) {
            CAPTURE(n);
            CHECK(compare(runner, test::clustered(n, n + 1)) == "");
            CHECK(compare(runner, test::far_from_origin(n, n + 2)) == "");
        }
        Options options = test::all_options();
        options.precision = test::double_precision();
        CHECK(compare(runner, test::uniform(test::by_size(2000, 900), 97), options) == "");
        PointSet set = test::uniform(900, 98);  // all on the bounds of every part
        for (std::size_t i = 0; i < set.points.size(); i += 3) set.points[i] = static_cast<double>(i % 2);
        CHECK(compare(runner, set) == "");
    }

    TEST_CASE("gpu: duplicates in different parts are refused with the CPU's message") {
        const test::SharedGpu shared;
        test::GpuRunner runner(shared.gpu, {.max_seeds = 100});
        Options options = test::all_options();
        options.duplicates = votess::Duplicates::error;
        const PointSet set = test::with_duplicates(600, 60, 99);
        std::string ours, cpus;
        CHECK(test::error_of([&] { (void)runner.run(set, options); }, &ours) == votess::ErrorCode::invalid_argument);
        (void)test::error_of([&] { (void)test::run(set, options); }, &cpus);
        CHECK(ours == cpus);
        CHECK(compare(runner, test::uniform(600, 100), options) == "");
    }

    TEST_CASE("gpu: work-groups of another size") {
        const test::SharedGpu shared;
        test::GpuRunner runner(shared.gpu, {.local_size = 128});
        for (const PointSet& set :
             {test::uniform(test::by_size(1000, 300), 101), test::with_duplicates(513, 40, 102),
              test::nested_clusters(257, 103), test::uniform(1, 104), test::bcc(5), test::on_walls(129, 105)}) {
            CAPTURE(set.name);
            CHECK(compare(runner, set) == "");
            const test::UseKernel chosen(test::by_subgroup());
            CHECK(compare(runner, set) == "");
        }
    }

    TEST_CASE("gpu: the smallest device, without float64") {
        test::Gpu gpu({.float64 = false}, [](VkPhysicalDeviceLimits& limits) {
            limits.maxPerStageDescriptorStorageBuffers = 8;
            // Vulkan's minimum.
            limits.maxDescriptorSetStorageBuffers = 24;
            limits.maxPushConstantsSize = 128;
            limits.maxStorageBufferRange = 1u << 27;
            limits.maxComputeSharedMemorySize = 16384;
            limits.maxComputeWorkGroupInvocations = limits.maxComputeWorkGroupSize[0] = 128;
            limits.minStorageBufferOffsetAlignment = 256;
        });
        CHECK(gpu.adapter.missing().empty());
        CHECK_FALSE(gpu.device->has_float64());
        test::GpuRunner runner(gpu);
        for (const auto kernel : {Kernel::invocation, test::by_subgroup()})
            for (const PointSet& set : test::families(test::by_size(150, 100), 106)) {
                CAPTURE(static_cast<int>(kernel));
                CAPTURE(set.name);
                const test::UseKernel chosen(kernel);
                CHECK(compare(runner, set) == "");
            }
        Options options = test::all_options();
        const PointSet set = test::uniform(test::by_size(3000, 500), 107);
        CHECK(runner.run(set, options).stats().fallback_cells < set.size() / 20);
        options.precision = votess::Precision::double_;
        std::string message;
        CHECK(test::error_of([&] { (void)runner.run(set, options); }, &message) == votess::ErrorCode::unsupported);
        CHECK(message.find("float64") != std::string::npos);
        options.precision = votess::Precision::single;
        CHECK(compare(runner, set, options) == "");
    }

    TEST_CASE("gpu: cells measured in float32, and in float64 by the second tier") {
        const test::Environment sums("VOTESS_VULKAN_MEASURE", "float32");
        const test::SharedGpu shared;
        test::GpuRunner runner(shared.gpu);
        for (const auto kernel : {Kernel::invocation, test::by_subgroup()}) {
            CAPTURE(static_cast<int>(kernel));
            const test::UseKernel chosen(kernel);
            Options options = test::all_options();
            // Short lists of invocations leave cells to the second tier.
            options.k_init = kernel == Kernel::invocation ? 12 : 0;
            for (const PointSet& set :
                 {test::uniform(test::by_size(1000, 300), 108), test::clustered(test::by_size(500, 200), 109)}) {
                CAPTURE(set.name);
                CHECK(compare(runner, set, options) == "");
            }
        }
        Options options = test::all_options();
        options.precision = test::double_precision();  // in float64 nevertheless
        CHECK(compare(runner, test::uniform(300, 110), options) == "");
    }
}
