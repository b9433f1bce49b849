// Shaders and C++ agree on shaders/shared/interface.h: Vulkan gets for each pipeline what its SPIR-V declares.
#include <doctest/doctest.h>

#include <cstdint>
#include <deque>
#include <mutex>
#include <set>

#include "gpu/frames/gradients.hpp"
#include "gpu/passes/passes.hpp"
#include "gpu/vulkan/spirv.hpp"
#include "shaders.hpp"
#include "shared/interface.h"
#include "support/gpu/finite.hpp"
#include "support/gpu/gpu_stages.hpp"

using test::Gpu;
using votess::gpu::PassSettings;
using Ids = std::multiset<std::uint32_t>;

namespace {

// The ids that a shader declares, its capabilities, and the widths in which it demands to round to nearest and to keep
// infinities.
struct Declared {
    Ids sets, bindings, constants, capabilities, nearest, infinities;
    bool operator==(const Declared&) const = default;
};

Declared read_spirv(std::span<const std::uint32_t> words) {
    constexpr std::uint32_t magic = 0x07230203, op_decorate = 71, spec_id = 1, binding = 33, descriptor_set = 34;
    constexpr std::uint32_t op_execution_mode = 16, op_capability = 17, rounding_to_nearest = 4462;
    constexpr std::uint32_t keeping_infinities = 4461;
    Declared found;
    REQUIRE(words[0] == magic);
    for (std::size_t at = 5; at < words.size(); at += words[at] >> 16) {
        REQUIRE((words[at] >> 16) != 0);
        const std::uint32_t operation = words[at] & 0xffff;
        if (operation == op_capability) found.capabilities.insert(words[at + 1]);
        if (operation == op_execution_mode && words[at + 2] == rounding_to_nearest) found.nearest.insert(words[at + 3]);
        if (operation == op_execution_mode && words[at + 2] == keeping_infinities)
            found.infinities.insert(words[at + 3]);
        if (operation != op_decorate) continue;
        const std::uint32_t value = words[at + 3];
        switch (words[at + 2]) {
            case spec_id:
                found.constants.insert(value);
                break;
            case binding:
                found.bindings.insert(value);
                break;
            case descriptor_set:
                found.sets.insert(value);
                break;
            default:
                break;
        }
    }
    return found;
}

// The arguments of the calls. Nothing is compiled. Threads make pipelines, each first its module.
thread_local Declared declared;
struct Calls {
    std::mutex mutex;
    std::deque<Ids> bindings;  // of a layout, whose handle points here
    std::size_t max_bindings = 0, asks_for_nearest = 0, asks_for_infinities = 0;
    std::set<std::uint32_t> all_bindings, all_constants;
} calls;

VKAPI_ATTR VkResult VKAPI_CALL note_set_layout(VkDevice, const VkDescriptorSetLayoutCreateInfo* info,
                                               const VkAllocationCallbacks*, VkDescriptorSetLayout* layout) {
    const std::lock_guard lock(calls.mutex);
    Ids& bindings = calls.bindings.emplace_back();
    for (const auto& slot : std::span(info->pBindings, info->bindingCount)) bindings.insert(slot.binding);
    *layout = (VkDescriptorSetLayout)(std::uintptr_t)&bindings;  // the platform decides: a pointer or an integer
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL note_layout(VkDevice, const VkPipelineLayoutCreateInfo* info,
                                           const VkAllocationCallbacks*, VkPipelineLayout* layout) {
    CHECK(info->setLayoutCount == 1);
    *layout = (VkPipelineLayout)info->pSetLayouts[0];
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL note_module(VkDevice, const VkShaderModuleCreateInfo* info, const VkAllocationCallbacks*,
                                           VkShaderModule* module) {
    declared = read_spirv({info->pCode, info->codeSize / 4});
    CHECK_FALSE(test::mentions_infinity({info->pCode, info->codeSize / 4}));
    *module = VK_NULL_HANDLE;
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL compare(VkDevice, VkPipelineCache, std::uint32_t,
                                       const VkComputePipelineCreateInfo* info, const VkAllocationCallbacks*,
                                       VkPipeline* pipeline) {
    const std::lock_guard lock(calls.mutex);
    const Ids& bindings = *(const Ids*)(std::uintptr_t)info->layout;
    const VkSpecializationInfo& given = *info->stage.pSpecializationInfo;
    Ids constants;
    for (const auto& entry : std::span(given.pMapEntries, given.mapEntryCount)) {
        constants.insert(entry.constantID);
        CHECK(entry.size == 4);
        CHECK(entry.offset + entry.size <= given.dataSize);
    }
    CHECK(constants == declared.constants);
    CHECK(bindings == declared.bindings);
    CHECK(declared.nearest.count(32) == calls.asks_for_nearest);
    CHECK(declared.infinities.count(32) == calls.asks_for_infinities);
    CHECK(declared.sets.size() == declared.sets.count(0));  // in set 0, all of them
    // Ids are declared once.
    const std::set<std::uint32_t> once(constants.begin(), constants.end());
    CHECK(once.size() == constants.size());
    calls.max_bindings = std::max(calls.max_bindings, bindings.size());
    calls.all_bindings.insert(bindings.begin(), bindings.end());
    calls.all_constants.insert(constants.begin(), constants.end());
    *pipeline = VK_NULL_HANDLE;
    return VK_SUCCESS;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu interface: all pipelines get the constants and the bindings that their shaders declare") {
        // Without the validation layer, which does not know objects that were not made.
        const auto instance = test::vk::Instance::create({.validation = false});
        const auto device = test::vk::Device::create(instance, Gpu::first(*instance));
        calls.asks_for_nearest = device->demands().nearest32;
        calls.asks_for_infinities = device->demands().infinities32;
        VolkDeviceTable& table = device->table();
        table.vkCreateDescriptorSetLayout = note_set_layout;
        table.vkCreatePipelineLayout = note_layout;
        table.vkCreateShaderModule = note_module;
        table.vkCreateComputePipelines = compare;
        table.vkDestroyDescriptorSetLayout = [](auto...) {};
        table.vkDestroyPipelineLayout = [](auto...) {};
        for (unsigned bits = 0; bits < 256; ++bits) {
            const auto bit = [&](unsigned at) { return (bits >> at & 1) != 0; };
            PassSettings s = test::pass_settings();
            s.measure = bit(0);
            s.areas = bit(1);
            s.frames = bit(2);
            s.images = bit(3);
            s.walls = bit(6);
            s.triclinic = bit(0);
            s.follow = bit(2);
            s.subgroup_size = bit(4) ? 32 : 0;
            s.tiers[0].float64 = bit(5) && device->has_float64();
            s.weights = bit(6);
            s.measure_float64 = bit(7) && device->has_float64();
            s.tiers[1].float64 = device->has_float64();
            CAPTURE(bits);
            const votess::gpu::Passes passes(*device, s);
        }
        for (const bool wide : {false, true}) const votess::gpu::GradientPasses passes(*device, wide);
        // All ids of the table are used.
        CHECK(calls.all_bindings.size() == BINDING_COUNT);
        CHECK(*calls.all_bindings.rbegin() == BINDING_COUNT - 1);
        CHECK(calls.all_constants.size() == CONSTANT_COUNT);
        CHECK(*calls.all_constants.rbegin() == CONSTANT_COUNT - 1);
        CHECK(calls.max_bindings == MAX_BINDINGS);
    }

    TEST_CASE(
        "gpu interface: shaders demand to round to nearest and to keep infinities, in the widths that they have") {
        constexpr std::uint32_t capability_float64 = 10, capability_infinities = 4466, capability_rounding = 4467;
        for (const auto spirv : {votess::gpu::shaders::clip_f32, votess::gpu::shaders::clip_f64}) {
            const Declared before = read_spirv(spirv);
            const bool has_float64 = before.capabilities.count(capability_float64) == 1;
            for (unsigned bits = 0; bits < 16; ++bits) {
                CAPTURE(has_float64);
                CAPTURE(bits);
                const votess::gpu::vulkan::FloatDemands demands{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0,
                                                                (bits & 8) != 0};
                Declared expected = before;
                if (demands.nearest32) expected.nearest.insert(32);
                if (demands.nearest64 && has_float64) expected.nearest.insert(64);
                if (demands.infinities32) expected.infinities.insert(32);
                if (demands.infinities64 && has_float64) expected.infinities.insert(64);
                if (!expected.nearest.empty()) expected.capabilities.insert(capability_rounding);
                if (!expected.infinities.empty()) expected.capabilities.insert(capability_infinities);
                CHECK(read_spirv(votess::gpu::vulkan::with_demands(spirv, demands)) == expected);
            }
        }
    }

    TEST_CASE("gpu interface: a pass with other constants than its shader's is refused") {
        Gpu gpu;
        const auto with = [&](std::vector<votess::gpu::vulkan::Constant> constants) {
            return test::error_of([&] {
                const votess::gpu::vulkan::Pass pass(*gpu.device, {.name = "knn_search",
                                                                   .spirv = votess::gpu::shaders::knn_search,
                                                                   .push_bytes = sizeof(votess::gpu::KnnPush),
                                                                   .local_size = 64,
                                                                   .constants = std::move(constants)});
            });
        };
        CHECK(!with({{CONSTANT_K, 64}, {CONSTANT_WEIGHTS, 0}}));
        CHECK(with({}) == votess::ErrorCode::internal);
        CHECK(with({{CONSTANT_K, 64}}) == votess::ErrorCode::internal);
        CHECK(with({{CONSTANT_K, 64}, {CONSTANT_TIER, 0}, {CONSTANT_WEIGHTS, 0}}) == votess::ErrorCode::internal);
        CHECK(with({{CONSTANT_K, 64}, {CONSTANT_K, 64}, {CONSTANT_WEIGHTS, 0}}) == votess::ErrorCode::internal);
    }
}
