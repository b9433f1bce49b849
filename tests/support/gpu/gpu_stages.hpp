// Runs single passes of the GPU engine and reads their results.
#pragma once

#include <memory>
#include <vector>

#include "gpu/passes/passes.hpp"
#include "gpu/seeds/seed_store.hpp"
#include "input/settle.hpp"
#include "shared/interface.h"
#include "support/generators.hpp"
#include "support/gpu/vulkan.hpp"

namespace test {

using Integers = std::vector<std::uint64_t>;

// Around the sizes of groups, tiles and levels.
inline const std::vector<std::size_t> sizes_across_groups{1,    2,    7,    8,    9,    31,    32,    33,   63,
                                                          64,   65,   127,  128,  129,  255,   256,   257,  1023,
                                                          1024, 1025, 8191, 8192, 8193, 65535, 65536, 65537};

inline votess::gpu::PassSettings pass_settings(std::uint32_t k = 112) {
    votess::gpu::PassSettings s;
    s.k = k;
    s.tiers[0] = {.planes = 32, .vertices = 64, .float64 = false};
    s.tiers[1] = {.planes = 64, .vertices = 128, .float64 = true};
    return s;
}

struct GpuStages {
    SharedGpu shared;
    Gpu& gpu = shared.gpu;
    vk::Memory memory{*gpu.device};
    std::unique_ptr<votess::gpu::Passes> passes;
    votess::gpu::SeedStore seeds{*gpu.device, memory};
    votess::ThreadPool pool{2};

    explicit GpuStages(const votess::gpu::PassSettings& settings = pass_settings()) { use(settings); }
    // With float64 where the device has it.
    void use(votess::gpu::PassSettings settings) {
        for (auto& tier : settings.tiers) tier.float64 = tier.float64 && gpu.device->has_float64();
        settings.measure_float64 = settings.measure_float64 && gpu.device->has_float64();
        passes.reset();
        passes = std::make_unique<votess::gpu::Passes>(*gpu.device, settings);
    }

    // Uploads a set, whose points must stay.
    votess::Job upload(const PointSet& set) {
        votess::Options options;
        options.box = set.box;
        votess::Job job = votess::make_job(votess::settle({set.points, {}}, options));
        seeds.upload(job, {}, job.box, *passes, pool);
        return job;
    }
    votess::Job upload_and_sort(const PointSet& set, std::uint32_t key_bits = KEY_BITS_PER_AXIS) {
        votess::Job job = upload(set);
        seeds.sort(*passes, key_bits);
        seeds.build_hierarchy(*passes, {});
        return job;
    }

    template <class T>
    std::vector<T> read(const vk::Slice& buffer, std::size_t count) {
        const vk::Buffer copy = memory.buffer(count * sizeof(T), vk::MemoryKind::download);
        vk::Commands commands(*gpu.device);
        commands.begin();
        commands.barrier();
        commands.copy(buffer, 0, copy, 0, count * sizeof(T));
        commands.barrier_to_host();
        commands.end();
        commands.submit();
        commands.wait();
        copy.invalidate();
        const auto all = copy.as<T>();
        return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)};
    }
    template <class T>
    std::vector<T> read(std::uint32_t binding, std::size_t count) {
        for (const vk::BufferBinding& b : seeds.on_device().bindings().list())
            if (b.binding == binding) return read<T>(b.slice, count);
        FAIL("no such binding");
        return {};
    }
    // Returns coordinates in units, of points (BINDING_POINTS) or seeds (BINDING_SEEDS), axis by axis.
    std::vector<Integers> coordinates(std::uint32_t binding) {
        const std::size_t n = seeds.count();
        const auto numbers = read<std::uint64_t>(binding, 3 * n);
        std::vector<Integers> all;
        for (std::size_t a = 0; a < 3; ++a)
            all.emplace_back(numbers.begin() + static_cast<std::ptrdiff_t>(a * n),
                             numbers.begin() + static_cast<std::ptrdiff_t>((a + 1) * n));
        return all;
    }
    votess::gpu::RunState run_state() { return read<votess::gpu::RunState>(BINDING_RUN_STATE, 1)[0]; }
};

// NO_COORDINATE in both words.
inline constexpr std::uint64_t no_coordinate = ~std::uint64_t{0};

}  // namespace test
