// Frames recorded into a host's command buffer, on its buffers: include/votess/vulkan.hpp.
#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <votess/vulkan.hpp>

#include "support/allocations.hpp"
#include "support/generators.hpp"
#include "support/gpu/frame.hpp"
#include "support/random.hpp"

using namespace test::frame;
using test::Coordinates;
using test::PointSet;

namespace {

// A driver whose queues compute nothing.
PFN_vkGetInstanceProcAddr real_address = nullptr;
PFN_vkGetPhysicalDeviceQueueFamilyProperties real_families = nullptr;

VKAPI_ATTR void VKAPI_CALL families_without_compute(VkPhysicalDevice device, std::uint32_t* count,
                                                    VkQueueFamilyProperties* families) {
    real_families(device, count, families);
    for (std::uint32_t i = 0; families != nullptr && i < *count; ++i)
        families[i].queueFlags &= ~VkQueueFlags{VK_QUEUE_COMPUTE_BIT};
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL address_without_compute(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction address = real_address(instance, name);
    if (std::strcmp(name, "vkGetPhysicalDeviceQueueFamilyProperties") != 0) return address;
    real_families = reinterpret_cast<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(address);
    return reinterpret_cast<PFN_vkVoidFunction>(families_without_compute);
}

// A driver that counts the pipelines that it makes.
PFN_vkGetDeviceProcAddr real_device_address = nullptr;
PFN_vkCreateComputePipelines real_create = nullptr;
std::atomic<int> pipelines_made;

VKAPI_ATTR VkResult VKAPI_CALL count_pipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count,
                                               const VkComputePipelineCreateInfo* infos,
                                               const VkAllocationCallbacks* allocator, VkPipeline* pipelines) {
    ++pipelines_made;
    return real_create(device, cache, count, infos, allocator, pipelines);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_address_that_counts(VkDevice device, const char* name) {
    const PFN_vkVoidFunction address = real_device_address(device, name);
    if (std::strcmp(name, "vkCreateComputePipelines") != 0) return address;
    real_create = reinterpret_cast<PFN_vkCreateComputePipelines>(address);
    return reinterpret_cast<PFN_vkVoidFunction>(count_pipelines);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL address_that_counts(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction address = real_address(instance, name);
    if (std::strcmp(name, "vkGetDeviceProcAddr") != 0) return address;
    real_device_address = reinterpret_cast<PFN_vkGetDeviceProcAddr>(address);
    return reinterpret_cast<PFN_vkVoidFunction>(device_address_that_counts);
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: every family equals the CPU") {
        Host host;
        const std::size_t n = test::by_size(600, 80);
        CHECK(check(host, test::families(n, n + 3), {}) == "");
    }

    TEST_CASE("gpu frame: few seeds, with walls in the rows") {
        Host host;
        PlanOptions options;
        options.list_walls = true;
        const PointSet sets[] = {test::uniform(1, 1), test::uniform(2, 2), test::uniform(3, 3), test::uniform(9, 9)};
        CHECK(check(host, sets, options) == "");
    }

    TEST_CASE("gpu frame: chunks, strides, short lists") {
        Host host;
        const PointSet set = test::clustered(test::by_size(3000, 300), 5);
        for (const auto& [chunk, stride, k_init] : {std::array{0u, 4u, 0u}, {100u, 3u, 12u}, {1001u, 7u, 0u}}) {
            PlanOptions options = options_for(set);
            options.chunk_size = chunk;
            options.stride = stride;
            options.k_init = k_init;
            CHECK(check(host, set, options) == "");
        }
    }

    TEST_CASE("gpu frame: a subgroup per cell") {
        Host host;
        const test::UseKernel chosen(test::by_subgroup());
        PlanOptions options;
        options.chunk_size = 100;
        const PointSet sets[] = {test::uniform(300, 15), test::clustered(300, 16), test::with_duplicates(130, 20, 17),
                                 test::bcc(3)};
        CHECK(check(host, sets, options) == "");
        // With a requested size, where the device allows it.
        host.first.reset();
        host.subgroup_size_control = requirements(host.instance(), host.gpu.adapter.handle).subgroup_size_control;
        const PointSet set = test::uniform(300, 18);
        options = options_for(set);
        CHECK(check(host, set, options) == "");
        options.box = test::unit_box();
        options.periodic = {true, false, true};
        CHECK(check(host, set, options) == "");
        options.max_images = 1;  // too few
        CHECK(check(host, set, options) == "");
    }

    TEST_CASE("gpu frame: float32 seeds") {
        Host host;
        PointSet set = test::uniform(test::by_size(2000, 200), 6);
        set.box = test::unit_box();
        for (double& x : set.points) x = static_cast<double>(static_cast<float>(x));
        PlanOptions options = options_for(set);
        options.format = SeedFormat::float32;
        options.stride = 4;
        const Plan plan = host.plan(options);
        Target target(host, plan);
        target.write<float>(set.points, 4);
        run(host, target, options.max_seeds);
        CHECK(target.head().unresolved < set.size() / 50);
        CHECK(compare(collect<float>(plan, target, set.size()), on_cpu(set, options)) == "");
    }

    TEST_CASE("gpu frame: seeds outside of the box, not finite, equal") {
        Host host;
        PointSet set = test::uniform(200, 7);
        set.box = votess::Box{{-1e-3, 0, 0}, {1, 1, 1}};
        for (const bool narrow : {false, true}) {
            Coordinates points = set.points;
            const double inf = std::numeric_limits<double>::infinity();
            const double above = narrow ? std::nextafter(1.0f, 2.0f) : std::nextafter(1.0, 2);
            const std::vector<std::pair<std::size_t, double>> bad{
                {0, above},  {7, -1e-30}, {100, std::numeric_limits<double>::quiet_NaN()}, {301, inf}, {402, -inf},
                {500, 1e30}, {31, -2}};
            for (const auto& [at, x] : bad) points[at] = x;
            points[34] = -0.0;   // y of seed 11: on the wall
            points[36] = 1;      // x of seed 12: on the wall
            points[39] = 1e-40;  // a subnormal float
            for (std::size_t k = 0; k < 3; ++k) points[3 * 150 + k] = points[3 * 50 + k];
            if (narrow)
                for (double& x : points) x = static_cast<double>(static_cast<float>(x));
            PlanOptions options = options_for(set);
            options.format = narrow ? SeedFormat::float32 : SeedFormat::float64;
            const Plan plan = host.plan(options);
            Target target(host, plan);
            if (narrow)
                target.write<float>(points, 3);
            else
                target.write<double>(points, 3);
            run(host, target, options.max_seeds);
            check_header(target.head(), target.cell(set.size()));
            CHECK(target.head().outside == bad.size());
            CHECK(target.head().duplicates <= 1);  // resolve() decides where a tiny coordinate was rounded
            const Rows rows =
                narrow ? collect<float>(plan, target, set.size()) : collect<double>(plan, target, set.size());
            CHECK(rows.status[150] == CellStatus::duplicate);
            CHECK(rows.rows[150].empty());
            // The other rows are those of the seeds inside.
            std::vector<std::int32_t> kept;
            Coordinates inside;
            for (std::size_t i = 0; i < set.size(); ++i) {
                if (rows.status[i] == CellStatus::outside) continue;
                kept.push_back(static_cast<std::int32_t>(i));
                inside.insert(inside.end(), points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                              points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
            }
            REQUIRE(kept.size() + bad.size() == set.size());
            const auto t = on_cpu({"inside", inside, set.box}, options);
            for (std::size_t i = 0; i < kept.size(); ++i) {
                std::vector<std::int32_t> row(t.neighbors(i).begin(), t.neighbors(i).end());
                for (std::int32_t& id : row) id = kept[static_cast<std::size_t>(id)];
                CHECK(rows.rows[static_cast<std::size_t>(kept[i])] == row);
            }
        }
    }

    TEST_CASE("gpu frame: rows that do not fit are counted, and resolve() makes them") {
        Host host;
        const PointSet set = test::uniform(test::by_size(1000, 200), 8);
        PlanOptions options = options_for(set);
        options.chunk_size = 150;
        const auto expected = on_cpu(set, options);
        for (const std::uint32_t entries : {1u, 500u, static_cast<std::uint32_t>(expected.indices().size() - 1)}) {
            options.max_entries = entries;
            const OneFrame frame(host, options, set.points);
            const Header h = frame.head();
            CHECK(h.entries > entries);
            CHECK(h.unresolved > 0);
            std::uint32_t written = 0;
            for (const Cell& cell : frame.cells()) {
                written += cell.row_length;
                CHECK(cell.row_begin + cell.row_length <= entries);
            }
            CHECK(written <= entries);
            CHECK(compare(frame.rows(), expected) == "");
        }
    }

    TEST_CASE("gpu frame: moving seeds, fewer seeds, no allocations; two frames in one command buffer") {
        Host host;
        PointSet set = test::uniform(test::by_size(1500, 300), 9);
        set.box = test::unit_box();
        PlanOptions options = options_for(set);
        const Plan plan = host.plan(options);
        PlanOptions other = options;
        other.list_walls = true;
        other.chunk_size = 200;
        const Plan second = plan.with(other);
        Target target(host, plan), beside(host, second);
        const Target* const both[] = {&target, &beside};
        test::Random random(10);
        for (int frame = 0; frame < 4; ++frame) {
            for (double& x : set.points) x = std::clamp(x + random.uniform(-0.02, 0.02), 0.0, 1.0);
            const std::uint32_t count = options.max_seeds - static_cast<std::uint32_t>(frame) * 37;
            set.points.resize(std::size_t{3} * count);
            target.write<double>(set.points, 3);
            beside.write<double>(set.points, 3);
            run(host, both, {.count = count});
            CHECK(compare(collect<double>(plan, target, count), on_cpu(set, options)) == "");
            CHECK(compare(collect<double>(second, beside, count), on_cpu(set, other)) == "");
        }
        // Recording allocates nothing, except in the validation layer.
        host.commands.begin();
        const auto recording = test::allocations();
        target.frame.record(host.commands.handle(), {.count = 100});
        beside.frame.record(host.commands.handle(), {.count = options.max_seeds - 1});
        const auto after = test::allocations();
        host.commands.end();
        if (recording && !host.gpu.instance->validation()) CHECK(*recording == *after);
    }

    TEST_CASE("gpu frame: a number of seeds that only the GPU knows") {
        Host host;
        PointSet set = test::uniform(400, 21);
        set.box = test::unit_box();
        const vk::Buffer number = host.memory.buffer(8, vk::MemoryKind::upload);
        for (const bool periodic : {false, true}) {
            PlanOptions options = options_for(set);
            options.periodic = {periodic, periodic, false};
            options.areas = true;  // as other tests: the same pipelines
            const Plan plan = host.plan(options);
            const Target target(host, plan);
            const Target* const one[] = {&target};
            for (const std::uint32_t present : {400u, 5000u, 250u, 1u, 0u}) {  // 5000: more than are recorded
                CAPTURE(periodic);
                CAPTURE(present);
                const std::uint32_t count = std::min(present, options.max_seeds);
                PointSet shown = set;
                shown.points.resize(std::size_t{3} * count);
                Coordinates given = shown.points;
                given.resize(set.points.size(), 0.5);  // not read; they would be duplicates
                target.write<double>(given, 3);
                number.as<std::uint32_t>()[1] = present;
                number.flush();
                run(host, one, {.count = options.max_seeds, .count_buffer = {number.handle(), 4}});
                const Header head = target.head();
                CHECK(head.seeds == present);
                CHECK(head.outside == 0);
                CHECK(head.duplicates == 0);
                CHECK(head.certified + head.unresolved == count);
                for (std::uint32_t i = count; i < options.max_seeds; ++i)
                    REQUIRE(target.cell(options.max_seeds)[i].status ==
                            static_cast<std::uint32_t>(CellStatus::outside));
                if (count > 0) CHECK(compare(collect<double>(plan, target, count), on_cpu(shown, options)) == "");
            }
        }
        CHECK(test::error_of([&] {
                  Frame frame = Target(host, host.plan(options_for(set))).frame;
                  frame.record(host.commands.handle(), {.count = 1, .count_buffer = {number.handle(), 2}});
              }) == votess::ErrorCode::invalid_argument);
    }

    TEST_CASE("gpu frame: seeds and results in one buffer") {
        Host host;
        const PointSet set = test::uniform(test::by_size(1000, 200), 19);
        const PlanOptions options = options_for(set);
        const Plan plan = host.plan(options);
        Target target(host, plan);
        target.write<double>(set.points, 3);
        const vk::Buffer* const parts[] = {&target.seeds,   &target.header,   &target.cells,
                                           &target.indices, &target.geometry, &target.areas};
        const VkDeviceSize alignment = host.gpu.adapter.limits.minStorageBufferOffsetAlignment;
        constexpr std::size_t count = std::size(parts);
        std::array<VkDeviceSize, count + 1> at{};
        for (std::size_t i = 0; i < count; ++i)
            at[i + 1] = (at[i] + parts[i]->mapped().size() + alignment - 1) / alignment * alignment;
        const vk::Buffer all = host.memory.buffer(at.back(), vk::MemoryKind::download);
        std::ranges::copy(target.seeds.mapped(), all.mapped().begin());
        all.flush();
        target.frame = plan.frame({.seeds = {all.handle(), at[0]},
                                   .workspace = {target.workspace.handle()},
                                   .header = {all.handle(), at[1]},
                                   .cells = {all.handle(), at[2]},
                                   .indices = {all.handle(), at[3]},
                                   .geometry = {all.handle(), at[4]},
                                   .areas = {all.handle(), at[5]}});
        run(host, target, options.max_seeds);
        all.invalidate();
        for (std::size_t i = 1; i < count; ++i)
            std::ranges::copy(all.mapped().subspan(at[i], parts[i]->mapped().size()), parts[i]->mapped().begin());
        check_header(target.head(), target.cell(set.size()));
        CHECK(target.head().unresolved < set.size() / 10);
        CHECK(compare(collect<double>(plan, target, set.size()), on_cpu(set, options)) == "");
    }

    TEST_CASE("gpu frame: no float64, no probe, neighbors or geometry alone, no seeds") {
        const PointSet set = test::uniform(test::by_size(1000, 200), 11);
        for (const bool float64 : {false, true}) {
            Host host(float64);
            host.probe = !float64;  // with both it is the usual frame
            CHECK(check(host, set, options_for(set)) == "");
        }
        Host host;
        PlanOptions options = options_for(set);
        options.geometry = options.areas = false;
        const OneFrame rows(host, options, set.points);
        CHECK(rows.plan.sizes().geometry == 0);
        const auto t = on_cpu(set, options);
        for (std::size_t i = 0; i < set.size(); ++i) {
            const Cell& cell = rows.cells()[i];
            if (cell.status != 0) continue;
            CHECK(std::ranges::equal(rows.target.indices.as<std::int32_t>().subspan(cell.row_begin, cell.row_length),
                                     t.neighbors(i)));
        }
        options.geometry = true;
        options.neighbors = options.areas = false;
        const OneFrame geometry(host, options, set.points);
        CHECK(geometry.plan.sizes().indices == 0);
        for (std::size_t i = 0; i < set.size(); ++i)
            if (geometry.cells()[i].status == 0)
                CHECK(geometry.target.geometry.as<float>()[4 * i + 3] == doctest::Approx(t.volumes()[i]).epsilon(1e-5));
        run(host, geometry.target, 0);
        CHECK(geometry.head().seeds == 0);
        CHECK(geometry.head().certified == 0);
    }

    TEST_CASE("gpu frame: plans of a device share pipelines, and the workspace has the size that vulkan.hpp states") {
        Host host;
        const test::UseKernel chosen(test::by_subgroup());
        PlanOptions options;
        options.box = test::unit_box();
        options.max_seeds = 1;
        auto device = host.device();
        real_address = device.host.get_instance_proc_addr;
        device.host.get_instance_proc_addr = address_that_counts;
        pipelines_made = 0;
        const Plan first(device, options);
        const int of_first = pipelines_made;
        CHECK(of_first > 10);
        options.format = votess::vulkan::SeedFormat::float64;
        options.box = test::cube(1, 2);
        CHECK(first.with(options).options().format == options.format);
        CHECK(pipelines_made == of_first);
        options.geometry = false;
        (void)first.with(options);
        CHECK(pipelines_made > of_first);
        CHECK(pipelines_made < of_first + 5);
        options.max_seeds = 0;
        CHECK(test::error_of([&] { (void)first.with(options); }) == votess::ErrorCode::invalid_argument);
        options.geometry = true;
        for (const std::uint32_t seeds : {1000u, 100000u, 5000000u})
            for (const std::uint32_t chunk : {100u, 10000u}) {
                options.max_seeds = seeds;
                options.chunk_size = chunk;
                if (seeds == 100000) options.weights = WeightOptions{0, 1};
                const VkDeviceSize each = options.weights ? 90 + 18 : 90;
                const VkDeviceSize workspace = first.with(options).sizes().workspace;
                CHECK(workspace < each * seeds + 900 * VkDeviceSize{chunk} + (1u << 20));
                CHECK(workspace > (each - 10) * seeds);
                options.weights.reset();
            }
    }

    TEST_CASE("gpu frame: refused plans, recordings and calls") {
        Host host;
        const PointSet set = test::uniform(50, 12);
        const PlanOptions good = options_for(set);
        std::string said;
        const auto refused = [&](auto call) {
            const auto code = test::error_of(call, &said);
            return code == votess::ErrorCode::invalid_argument;
        };
        CHECK(refused([&] { Plan({}, good); }));
        for (const std::uint32_t family : {99u, VK_QUEUE_FAMILY_IGNORED}) {
            HostDevice device = host.device();
            device.queue_family = family;
            CHECK(refused([&] { Plan(device, good); }));
            CHECK(said.starts_with("queue_family = " + std::to_string(family) + ", but "));
        }
        {
            HostDevice device = host.device();
            real_address = device.host.get_instance_proc_addr;
            device.host.get_instance_proc_addr = address_without_compute;
            CHECK(refused([&] { Plan(device, good); }));
            CHECK(said.starts_with("queue_family = " + std::to_string(device.queue_family) + " has no compute"));
        }
        PlanOptions options = good;
        options.max_seeds = 0;
        CHECK(refused([&] { Plan(host.device(), options); }));
        CHECK(said == "max_seeds = 0 must be 1 to 134217728");
        options = good;
        options.stride = 2;
        CHECK(refused([&] { Plan(host.device(), options); }));
        options = good;
        options.format = static_cast<SeedFormat>(2);
        CHECK(refused([&] { Plan(host.device(), options); }));
        CHECK(said == "format = 2 is neither float32 nor float64");
        {
            const test::Environment environment("VOTESS_VULKAN_KERNEL", "warp");
            CHECK(refused([&] { Plan(host.device(), good); }));
            CHECK(said == "VOTESS_VULKAN_KERNEL is 'warp': give automatic, invocation or subgroup");
        }
        options = good;
        options.k_init = 1025;
        CHECK(refused([&] { Plan(host.device(), options); }));
        options = good;
        options.box.upper = options.box.lower;
        CHECK(refused([&] { Plan(host.device(), options); }));
        const Plan plan = host.plan(good);
        CHECK(plan.kernel().find(" make cells") != std::string::npos);
        CHECK(refused([&] { Frame().record(VK_NULL_HANDLE, {}); }));
        CHECK(refused([&] { static_cast<void>(plan.frame({})); }));
        CHECK(said == "the buffer of workspace is null");
        Target target(host, plan);
        CHECK(refused([&] { target.frame.record(VK_NULL_HANDLE, {}); }));
        host.commands.begin();
        CHECK(refused([&] { target.frame.record(host.commands.handle(), {.count = 51}); }));
        CHECK(said == "count = 51 is more than max_seeds = 50");
        host.commands.end();
        const std::vector<double> few(10);
        const std::vector<Cell> cells(50);
        CHECK(refused([&] { static_cast<void>(plan.resolve(few, cells)); }));
        CHECK(requirements(host.instance(), host.gpu.adapter.handle).missing.empty());
        CHECK(refused([&] { static_cast<void>(requirements({}, host.gpu.adapter.handle)); }));
    }
}
