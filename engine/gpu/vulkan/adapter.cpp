#include "gpu/vulkan/adapter.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "shared/config.h"
#include "shared/interface.h"

namespace votess::gpu::vulkan {
namespace {

constexpr std::uint32_t min_storage_buffers = MAX_BINDINGS;
constexpr std::uint32_t min_push_bytes = 128;
constexpr std::uint32_t min_invocations = TILE_GROUP;

std::string version_text(std::uint32_t version) {
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
           std::to_string(VK_API_VERSION_PATCH(version));
}

std::string_view type_text(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return "discrete GPU";
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return "integrated GPU";
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return "virtual GPU";
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return "software";
        default:
            return "other";
    }
}

// What a physical device supports: its extensions, and its version as far as the instance may use it.
class Support {
public:
    Support(const InstanceCalls& calls, VkPhysicalDevice device, std::uint32_t version) : version_(version) {
        extensions_ =
            list_of<VkExtensionProperties>("vkEnumerateDeviceExtensionProperties", [&](auto* count, auto* to) {
                return calls.vkEnumerateDeviceExtensionProperties(device, nullptr, count, to);
            });
    }
    [[nodiscard]] bool has(std::string_view extension) const { return vulkan::has(extensions_, extension); }
    [[nodiscard]] bool is_at_least(std::uint32_t version) const { return version_ >= version; }
    // Returns whether the device has a feature that `version` took into its core and that was an extension before.
    [[nodiscard]] bool has(std::uint32_t version, std::string_view extension) const {
        return is_at_least(version) || has(extension);
    }

private:
    std::uint32_t version_;
    std::vector<VkExtensionProperties> extensions_;
};

// A pNext chain of the caller's structures.
template <class Head>
class Chain {
public:
    explicit Chain(Head& head) : last_(reinterpret_cast<VkBaseOutStructure*>(&head)) {}
    template <class Link>
    void add(Link& link) {
        last_->pNext = reinterpret_cast<VkBaseOutStructure*>(&link);
        last_ = last_->pNext;
    }

private:
    VkBaseOutStructure* last_;
};

void query_memory(Adapter& a, const InstanceCalls& calls) {
    calls.vkGetPhysicalDeviceMemoryProperties(a.handle, &a.memory);
    for (std::uint32_t i = 0; i < a.memory.memoryHeapCount; ++i) {
        const VkMemoryHeap& heap = a.memory.memoryHeaps[i];
        if (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) a.device_memory = std::max(a.device_memory, heap.size);
    }
}

void query_queues(Adapter& a, const InstanceCalls& calls) {
    std::uint32_t count = 0;
    calls.vkGetPhysicalDeviceQueueFamilyProperties(a.handle, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    calls.vkGetPhysicalDeviceQueueFamilyProperties(a.handle, &count, families.data());
    for (const VkQueueFamilyProperties& family : families)
        a.families.push_back(family.queueCount > 0 ? family.queueFlags : 0);
    // A family without graphics does not wait for frames that are drawn.
    int best = -1;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!(a.families[i] & VK_QUEUE_COMPUTE_BIT)) continue;
        const int value =
            (families[i].timestampValidBits > 0 ? 2 : 0) + (a.families[i] & VK_QUEUE_GRAPHICS_BIT ? 0 : 1);
        if (value <= best) continue;
        best = value;
        a.queue_family = i;
        a.timestamp_bits = families[i].timestampValidBits;
    }
}

void query_properties(Adapter& a, const InstanceCalls& calls, const Support& support) {
    auto all = structure<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
    auto subgroup =
        structure<VkPhysicalDeviceSubgroupProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
    auto limits =
        structure<VkPhysicalDeviceMaintenance3Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES);
    auto buffers =
        structure<VkPhysicalDeviceMaintenance4Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES);
    auto driver = structure<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
    auto sizes = structure<VkPhysicalDeviceSubgroupSizeControlProperties>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES);

    auto floats =
        structure<VkPhysicalDeviceFloatControlsProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES);
    auto ids = structure<VkPhysicalDeviceIDProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES);
    Chain chain(all);
    chain.add(ids);
    chain.add(subgroup);
    chain.add(limits);
    if (support.is_at_least(VK_API_VERSION_1_2)) chain.add(floats);
    if (support.has(VK_API_VERSION_1_3, VK_KHR_MAINTENANCE_4_EXTENSION_NAME)) chain.add(buffers);
    if (support.has(VK_API_VERSION_1_2, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME)) chain.add(driver);
    if (support.has(VK_API_VERSION_1_3, VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME)) chain.add(sizes);
    calls.vkGetPhysicalDeviceProperties2(a.handle, &all);

    std::copy_n(ids.deviceUUID, a.uuid.size(), a.uuid.begin());
    a.subgroup_size = subgroup.subgroupSize;
    a.min_subgroup_size = sizes.minSubgroupSize ? sizes.minSubgroupSize : subgroup.subgroupSize;
    a.max_subgroup_size = sizes.maxSubgroupSize ? sizes.maxSubgroupSize : subgroup.subgroupSize;
    a.subgroup_operations = subgroup.supportedOperations;
    a.max_subgroups = sizes.maxComputeWorkgroupSubgroups;
    a.subgroup_size_control = sizes.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT;
    a.subgroup_in_compute = subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT;
    a.max_allocation = limits.maxMemoryAllocationSize;
    a.max_buffer = buffers.maxBufferSize ? buffers.maxBufferSize : a.max_allocation;
    a.max_buffer = std::min({a.max_buffer, a.max_allocation, a.device_memory});
    a.offered = {floats.shaderRoundingModeRTEFloat32 != VK_FALSE, floats.shaderRoundingModeRTEFloat64 != VK_FALSE,
                 floats.shaderSignedZeroInfNanPreserveFloat32 != VK_FALSE,
                 floats.shaderSignedZeroInfNanPreserveFloat64 != VK_FALSE};
    if (floats.roundingModeIndependence == VK_SHADER_FLOAT_CONTROLS_INDEPENDENCE_NONE)  // both or none
        a.offered.nearest32 = a.offered.nearest64 = a.offered.nearest32 && a.offered.nearest64;
    a.lockstep = driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
    a.driver = driver.driverName;
    if (driver.driverInfo[0]) a.driver += std::string(" ") + driver.driverInfo;
}

void query_features(Adapter& a, const InstanceCalls& calls, const Support& support) {
    auto all = structure<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
    auto sizes = structure<VkPhysicalDeviceSubgroupSizeControlFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES);

    Chain chain(all);
    if (support.has(VK_API_VERSION_1_3, VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME)) chain.add(sizes);
    calls.vkGetPhysicalDeviceFeatures2(a.handle, &all);

    a.float64 = all.features.shaderFloat64;
    a.subgroup_size_control = a.subgroup_size_control && sizes.subgroupSizeControl && sizes.computeFullSubgroups;
}

}  // namespace

Adapter query_adapter(const InstanceCalls& calls, VkPhysicalDevice device, std::uint32_t instance_version) {
    VkPhysicalDeviceProperties properties{};
    calls.vkGetPhysicalDeviceProperties(device, &properties);
    Adapter a;
    a.handle = device;
    a.name = properties.deviceName;
    a.type = properties.deviceType;
    a.api_version = properties.apiVersion;
    a.driver_version = properties.driverVersion;
    a.vendor_id = properties.vendorID;
    a.device_id = properties.deviceID;
    std::copy_n(properties.pipelineCacheUUID, VK_UUID_SIZE, a.cache_uuid.begin());
    a.limits = properties.limits;
    query_memory(a, calls);
    query_queues(a, calls);

    const std::uint32_t usable = std::min(a.api_version, instance_version);
    if (usable < VK_API_VERSION_1_1) return a;
    const Support support(calls, device, usable);
    // volk does not include the header of provisional extensions, which has a macro for this name.
    a.portability_subset = support.has("VK_KHR_portability_subset");
    a.subgroup_size_extension = support.has(VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);
    a.exports_memory = support.has(VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME);
    a.exports_semaphores = support.has(VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME);
    query_properties(a, calls, support);
    query_features(a, calls, support);
    return a;
}

std::string Adapter::missing() const {
    const auto needs = [](std::string_view what, const std::string& found) {
        return "needs " + std::string(what) + ", this device has " + found;
    };
    if (api_version < VK_API_VERSION_1_1) return needs("Vulkan 1.1", version_text(api_version));
    if (queue_family == VK_QUEUE_FAMILY_IGNORED) return needs("a compute queue", "none");
    const std::uint32_t buffers =
        std::min(limits.maxPerStageDescriptorStorageBuffers, limits.maxDescriptorSetStorageBuffers);
    if (buffers < min_storage_buffers)
        return needs(std::to_string(min_storage_buffers) + " storage buffers per stage", std::to_string(buffers));
    if (limits.maxPushConstantsSize < min_push_bytes) {
        return needs(std::to_string(min_push_bytes) + " bytes of push constants",
                     std::to_string(limits.maxPushConstantsSize));
    }
    const std::uint32_t invocations =
        std::min(limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0]);
    if (invocations < min_invocations)
        return needs("work-groups of " + std::to_string(min_invocations) + " invocations", std::to_string(invocations));
    return {};
}

std::string Adapter::description() const {
    std::string text(type_text(type));
    text += ", Vulkan " + version_text(api_version);
    text += ", " + bytes_text(device_memory);
    text += ", storage buffers to " + bytes_text(limits.maxStorageBufferRange);
    text += ", subgroups of " + std::to_string(subgroup_size);
    text += float64 ? ", float64" : ", no float64";
    text += ", work-groups to " + std::to_string(limits.maxComputeWorkGroupInvocations) + " with " +
            bytes_text(limits.maxComputeSharedMemorySize) + " shared";
    return text;
}

}  // namespace votess::gpu::vulkan
