// The Vulkan layer on any device, usually lavapipe.
#include <doctest/doctest.h>

#include <cstring>
#include <set>
#include <thread>

#include "support/gpu/vulkan.hpp"
#include "support/random.hpp"

using namespace votess::gpu::vulkan;
using test::Gpu;
using test::scale_pass;
using test::ScalePush;

namespace {

void run(Commands& commands) {
    commands.barrier_to_host();
    commands.end();
    commands.submit();
    commands.wait();
}

// Returns `buffer` as the host sees it, through a download buffer.
std::vector<std::uint32_t> contents(Gpu& gpu, Memory& memory, const Buffer& buffer) {
    Buffer result = memory.buffer(buffer.size(), MemoryKind::download);
    Commands commands(*gpu.device);
    commands.begin();
    commands.copy(buffer, 0, result, 0, buffer.size());
    run(commands);
    result.invalidate();
    const auto words = result.as<std::uint32_t>();
    return {words.begin(), words.end()};
}

Buffer counting(Memory& memory, std::uint32_t count) {
    Buffer buffer = memory.buffer(4 * VkDeviceSize{count}, MemoryKind::upload, "counting");
    const auto words = buffer.as<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) words[i] = i;
    buffer.flush();
    return buffer;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("vulkan: adapters tell what they are") {
        const auto instance = Instance::create();
        const auto adapters = instance->adapters();
        REQUIRE(!adapters.empty());
        for (const Adapter& a : adapters) {
            INFO(a.name << ": " << a.description());
            CHECK(!a.name.empty());
            CHECK(a.description().find("Vulkan 1.") != std::string::npos);
            CHECK(a.description().find('\n') == std::string::npos);
            if (!a.missing().empty()) continue;
            CHECK(a.device_memory > 0);
            CHECK(a.max_buffer > 0);
            CHECK(a.max_buffer <= a.max_allocation);
            CHECK(a.subgroup_size >= a.min_subgroup_size);
            CHECK(a.subgroup_size <= a.max_subgroup_size);
        }
        Adapter old = adapters.front();
        old.api_version = VK_API_VERSION_1_0;
        CHECK(old.missing() == "needs Vulkan 1.1, this device has 1.0.0");
        CHECK(test::error_of([&] { (void)Device::create(instance, old); }) == votess::ErrorCode::unsupported);
        CHECK(instance->take_messages().empty());
    }

    TEST_CASE("vulkan: a probe finds the size of subgroups where it varies") {
        const auto instance = Instance::create();
        Adapter adapter = Gpu::first(*instance);
        if (adapter.min_subgroup_size != adapter.max_subgroup_size) return;
        const std::uint32_t size = adapter.subgroup_size;
        adapter.subgroup_size_control = false;  // as MoltenVK on Apple's GPUs
        adapter.min_subgroup_size = 4;
        adapter.subgroup_size = adapter.max_subgroup_size = 2 * size;
        CHECK(Device::create(instance, adapter)->adapter().subgroup_size == size);
        CHECK(Device::create(instance, adapter)->adapter().min_subgroup_size == size);
        adapter.subgroup_operations = VK_SUBGROUP_FEATURE_BASIC_BIT;  // no probe
        CHECK(Device::create(instance, adapter)->adapter().subgroup_size == 2 * size);
        CHECK(instance->take_messages().empty());
    }

    TEST_CASE("vulkan: features are used when there and wanted") {
        Gpu with;
        CHECK(with.device->has_float64() == with.adapter.float64);
        Gpu without(DeviceOptions{.float64 = false});
        CHECK(!without.device->has_float64());
        if (!with.adapter.float64) return;
        Memory memory(*with.device);
        const Buffer source = counting(memory, 100);
        const Buffer target = memory.buffer(source.size(), MemoryKind::device);
        const Pass pass(*with.device, {.name = "test_doubles",
                                       .spirv = votess::gpu::shaders::test_doubles,
                                       .push_bytes = sizeof(ScalePush),
                                       .local_size = 32,
                                       .constants = {{1, 1}, {2, 4}}});
        Commands commands(*with.device);
        commands.begin();
        const BufferBinding buffers[] = {{2, &source}, {5, &target}};
        commands.dispatch(pass, buffers, push_bytes(ScalePush{100, 7}), 100);
        run(commands);
        const auto words = contents(with, memory, target);
        for (std::uint32_t i = 0; i < 100; ++i) REQUIRE(words[i] == i / 4 + 7);
    }

    TEST_CASE("vulkan: buffers never overlap and are aligned") {
        Gpu gpu;
        Memory memory(*gpu.device, 1 << 16);
        struct Held {
            Buffer buffer;
            std::uint8_t mark;
        };
        std::vector<Held> held;
        test::Random random(7);
        const auto intact = [](const Held& h) {
            return std::all_of(h.buffer.mapped().begin(), h.buffer.mapped().end(),
                               [&](std::byte b) { return b == std::byte{h.mark}; });
        };
        for (int round = 0; round < 3000; ++round) {
            if (held.size() < 5 || (held.size() < 60 && random.chance(0.55))) {
                const auto kind = static_cast<MemoryKind>(random.below(3));
                const VkDeviceSize bytes = random.chance(0.05) ? random.below(200000) : random.below(5000);
                Buffer buffer = memory.buffer(bytes, kind, "fuzz");
                REQUIRE(buffer.size() == bytes);
                if (kind != MemoryKind::device || gpu.adapter.unified()) REQUIRE(buffer.mapped().size() == bytes);
                VkMemoryRequirements needs{};
                gpu.device->table().vkGetBufferMemoryRequirements(gpu.device->handle(), buffer.handle(), &needs);
                // Mapped memory begins at a multiple of 64 at least.
                const auto address = reinterpret_cast<std::uintptr_t>(buffer.mapped().data());
                REQUIRE(address % std::min<VkDeviceSize>(needs.alignment, 64) == 0);
                const auto mark = static_cast<std::uint8_t>(random.below(256));
                std::fill(buffer.mapped().begin(), buffer.mapped().end(), std::byte{mark});
                held.push_back({std::move(buffer), mark});
            } else {
                const auto victim = held.begin() + static_cast<std::ptrdiff_t>(random.below(held.size()));
                REQUIRE(intact(*victim));
                std::swap(*victim, held.back());
                held.pop_back();
            }
        }
        for (const Held& h : held) CHECK(intact(h));
        CHECK(memory.used_bytes() <= memory.block_bytes());
        CHECK(memory.peak_bytes() >= memory.used_bytes());
        held.clear();
        CHECK(memory.used_bytes() == 0);
        CHECK(memory.block_bytes() == 0);
        CHECK(memory.block_count() == 0);
    }

    TEST_CASE("vulkan: buffers above the limits are refused") {
        Gpu gpu;
        Memory memory(*gpu.device);
        std::string message;
        const auto error =
            test::error_of([&] { (void)memory.buffer(~VkDeviceSize{0} / 2, MemoryKind::device); }, &message);
        CHECK(error == votess::ErrorCode::out_of_memory);
        CHECK(message.find(std::to_string(memory.max_buffer_bytes())) != std::string::npos);
        CHECK(memory.block_count() == 0);
    }

    TEST_CASE("vulkan: what is copied comes back") {
        Gpu gpu;
        Memory memory(*gpu.device);
        constexpr std::uint32_t count = 100000;
        const Buffer source = counting(memory, count);
        const Buffer middle = memory.buffer(source.size(), MemoryKind::device, "middle");
        Commands commands(*gpu.device);
        for (int round = 0; round < 3; ++round) {
            commands.begin();
            {
                const auto label = commands.label("fill and copy");
                commands.fill(middle, 0, middle.size(), 77);
                commands.barrier();
                commands.copy(source, 40, middle, 80, 400);
                commands.copy(source, 0, middle, 0, 0);
            }
            run(commands);
            CHECK(commands.finished());
            const auto words = contents(gpu, memory, middle);
            for (std::uint32_t i = 0; i < count; ++i) REQUIRE(words[i] == (i >= 20 && i < 120 ? i - 10 : 77));
        }
    }

    TEST_CASE("vulkan: group counts cover the invocations and little more") {
        VkPhysicalDeviceLimits limits{};
        limits.maxComputeWorkGroupCount[0] = limits.maxComputeWorkGroupCount[1] = limits.maxComputeWorkGroupCount[2] =
            100;
        CHECK(group_counts(0, 8, limits) == std::array<std::uint32_t, 3>{0, 0, 0});
        CHECK(group_counts(1, 8, limits) == std::array<std::uint32_t, 3>{1, 1, 1});
        CHECK(group_counts(800, 8, limits) == std::array<std::uint32_t, 3>{100, 1, 1});
        CHECK(group_counts(801, 8, limits) == std::array<std::uint32_t, 3>{51, 2, 1});
        test::Random random(3);
        for (int round = 0; round < 10000; ++round) {
            const std::uint64_t n = 1 + random.below(random.chance(0.5) ? 8000000 : 90000);
            const auto [x, y, z] = group_counts(n, 8, limits);
            const std::uint64_t product = std::uint64_t{x} * y * z;
            REQUIRE(std::max({x, y, z}) <= 100);
            REQUIRE(product * 8 >= n);
            REQUIRE((product - std::uint64_t{y} * z) * 8 < n);  // one column fewer is too few
        }
        CHECK_THROWS_AS((void)group_counts(8000001, 8, limits), votess::Error);
    }

    TEST_CASE("vulkan: every invocation of a large dispatch runs once") {
        Gpu gpu;
        Memory memory(*gpu.device);
        constexpr std::uint32_t local = 8, count = 3 * 65535 * local + 5;
        const Buffer source = counting(memory, count);
        const Buffer target = memory.buffer(source.size(), MemoryKind::device, "target");
        const Pass pass = scale_pass(*gpu.device, local, 3, 2);
        Commands commands(*gpu.device, 3);
        commands.begin();
        commands.fill(target, 0, target.size(), 0);
        commands.barrier();
        const auto t0 = commands.timestamp();
        const BufferBinding buffers[] = {{0, nullptr}, {5, &target}, {2, &source}};
        commands.dispatch(pass, buffers, push_bytes(ScalePush{count, 9}), count);
        commands.dispatch(pass, buffers, push_bytes(ScalePush{count, 9}), 0);
        const auto t1 = commands.timestamp();
        commands.barrier();
        commands.dispatch(pass, buffers, push_bytes(ScalePush{count, 1}), count);
        const auto t2 = commands.timestamp();
        CHECK(commands.timestamp() == Commands::no_timestamp);
        run(commands);
        const auto words = contents(gpu, memory, target);
        for (std::uint32_t i = 0; i < count; ++i) REQUIRE(words[i] == 2 * (i * 3 / 2) + 10);

        CHECK(commands.seconds(t0, t0) == 0);
        CHECK(commands.seconds(t0, Commands::no_timestamp) == 0);
        if (gpu.adapter.timestamp_bits == 0) return;
        CHECK(commands.seconds(t0, t1) > 0);
        CHECK(commands.seconds(t1, t2) > 0);
        CHECK(commands.seconds(t0, t1) + commands.seconds(t1, t2) == doctest::Approx(commands.seconds(t0, t2)));
        CHECK(commands.seconds(t0, t2) < 100);
    }

    TEST_CASE("vulkan: a shader decides how much an indirect dispatch does") {
        Gpu gpu;
        Memory memory(*gpu.device);
        constexpr std::uint32_t count = 1000, wanted = 640;
        const Buffer source = counting(memory, count);
        const Buffer target = memory.buffer(source.size(), MemoryKind::device, "target");
        const Buffer arguments = memory.buffer(512, MemoryKind::device, "arguments");
        const Pass decide(*gpu.device, {.name = "test_arguments",
                                        .spirv = votess::gpu::shaders::test_arguments,
                                        .push_bytes = sizeof(ScalePush),
                                        .local_size = 64,
                                        .constants = {{1, 1}, {2, 1}}});
        const Pass pass = scale_pass(*gpu.device, 64);
        Commands commands(*gpu.device);
        commands.begin();
        commands.fill(target, 0, target.size(), 0);
        const BufferBinding first[] = {{2, &source}, {5, &arguments, 256, 12}};
        commands.dispatch(decide, first, push_bytes(ScalePush{wanted, 0}), 1);
        commands.barrier();
        const BufferBinding second[] = {{2, &source}, {5, &target}};
        commands.dispatch_indirect(pass, second, push_bytes(ScalePush{count, 1}), arguments, 256);
        run(commands);
        const auto words = contents(gpu, memory, target);
        for (std::uint32_t i = 0; i < count; ++i) REQUIRE(words[i] == (i < wanted ? i + 1 : 0));
    }

    TEST_CASE("vulkan: many dispatches outgrow a descriptor pool, and recordings repeat") {
        Gpu gpu;
        Memory memory(*gpu.device);
        const Buffer source = counting(memory, 64);
        const Buffer target = memory.buffer(source.size(), MemoryKind::device, "target");
        const Pass pass = scale_pass(*gpu.device, 64, 0);
        const BufferBinding buffers[] = {{2, &source}, {5, &target}};
        Commands commands(*gpu.device);
        for (int round = 0; round < 3; ++round) {
            commands.begin();
            commands.fill(target, 0, target.size(), 0);
            for (int i = 0; i < 500; ++i) {
                commands.barrier();
                commands.dispatch(pass, buffers, push_bytes(ScalePush{64, 2}), 64);
            }
            run(commands);
            commands.submit();  // the same again
            commands.wait();
            CHECK(contents(gpu, memory, target) == std::vector<std::uint32_t>(64, 1000));
        }
    }

    TEST_CASE("vulkan: a device keeps its passes") {
        Gpu gpu;
        static PFN_vkCreateComputePipelines original;
        static int made;
        original = gpu.original.vkCreateComputePipelines;
        made = 0;
        gpu.device->table().vkCreateComputePipelines =
            [](VkDevice device, VkPipelineCache cache, std::uint32_t count, const VkComputePipelineCreateInfo* infos,
               const VkAllocationCallbacks* allocator, VkPipeline* pipelines) {
                ++made;
                return original(device, cache, count, infos, allocator, pipelines);
            };
        const auto get = [&](std::uint32_t local_size, std::uint32_t factor) {
            PassBatch batch(*gpu.device);
            Pass pass = batch.get(test::scale_info(local_size, factor));
            batch.make();
            return pass;
        };
        const Pass first = get(64, 3);
        CHECK(get(64, 3).pipeline() == first.pipeline());
        CHECK(made == 1);
        CHECK(get(64, 4).pipeline() != first.pipeline());
        CHECK(get(32, 3).pipeline() != first.pipeline());
        CHECK(made == 3);
        // More than it keeps: the one in use stays, and the last one.
        for (std::uint32_t factor = 5; factor < 75; ++factor) (void)get(64, factor);
        CHECK(made == 73);
        CHECK(get(64, 3).pipeline() == first.pipeline());
        (void)get(64, 74);
        CHECK(made == 73);
        (void)get(64, 4);
        CHECK(made == 74);
    }

    TEST_CASE("vulkan: several threads use one device") {
        Gpu gpu;
        const Pass pass = scale_pass(*gpu.device, 64);
        const auto work = [&](bool& good) {
            Memory memory(*gpu.device);
            const Buffer source = counting(memory, 1000);
            const Buffer target = memory.buffer(source.size(), MemoryKind::download);
            const BufferBinding buffers[] = {{2, &source}, {5, &target}};
            Commands commands(*gpu.device);
            good = true;
            for (int round = 0; round < 20; ++round) {
                commands.begin();
                commands.fill(target, 0, target.size(), 0);
                commands.barrier();
                commands.dispatch(pass, buffers, push_bytes(ScalePush{1000, 5}), 1000);
                run(commands);
                target.invalidate();
                for (std::uint32_t i = 0; i < 1000; ++i) good = good && target.as<std::uint32_t>()[i] == i + 5;
            }
        };
        bool good[3] = {};
        std::thread other[] = {std::thread(work, std::ref(good[0])), std::thread(work, std::ref(good[1]))};
        work(good[2]);
        for (std::thread& thread : other) thread.join();
        for (const bool g : good) CHECK(g);
    }
}
