// What one physical device is and can do. All of it is queried, nothing is assumed.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/vulkan/api.hpp"
#include "gpu/vulkan/spirv.hpp"

namespace votess::gpu::vulkan {

struct Adapter {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    std::string name;
    std::string driver;  // name and version as the driver states them; empty when it does not
    VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
    std::uint32_t api_version = 0;
    std::uint32_t driver_version = 0;
    std::uint32_t vendor_id = 0;
    std::uint32_t device_id = 0;
    std::array<std::uint8_t, VK_UUID_SIZE> cache_uuid{};  // pipelineCacheUUID
    std::array<std::uint8_t, VK_UUID_SIZE> uuid{};        // of the device; 0 before Vulkan 1.1
    VkPhysicalDeviceLimits limits{};

    VkPhysicalDeviceMemoryProperties memory{};
    VkDeviceSize device_memory = 0;   // bytes of the largest device-local heap
    VkDeviceSize max_allocation = 0;  // of one VkDeviceMemory
    VkDeviceSize max_buffer = 0;      // of one VkBuffer; never more than max_allocation or the device's memory

    std::uint32_t subgroup_size = 0;  // of shaders that do not request another
    std::uint32_t min_subgroup_size = 0;
    std::uint32_t max_subgroup_size = 0;
    VkSubgroupFeatureFlags subgroup_operations = 0;
    bool subgroup_in_compute = false;
    bool subgroup_size_control = false;    // a compute shader can request a size and full subgroups
    bool subgroup_size_extension = false;  // ... after VK_EXT_subgroup_size_control was enabled
    std::uint32_t max_subgroups = 0;       // of a work-group that requests a size
    // Subgroups are vectors of a CPU: their lanes never part and need no barrier. llvmpipe (Mesa 25) must not get one:
    // it treats it as the work-group's, and ends the work-group with the first subgroup that ends.
    bool lockstep = false;

    bool float64 = false;
    FloatDemands offered;  // what shaders may demand

    // With compute, with timestamps if there is one, and without graphics if there is one.
    std::uint32_t queue_family = VK_QUEUE_FAMILY_IGNORED;
    std::vector<VkQueueFlags> families;                       // flags of each family; 0 where it has no queue
    std::uint32_t timestamp_bits = 0;                         // 0: no timestamps
    bool portability_subset = false;                          // must be enabled where it exists
    bool exports_memory = false, exports_semaphores = false;  // as file descriptors
    // The device is the CPU (lavapipe).
    [[nodiscard]] bool software() const { return type == VK_PHYSICAL_DEVICE_TYPE_CPU; }
    // Host and device share their memory.
    [[nodiscard]] bool unified() const { return software() || type == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU; }
    // Returns an empty text when votess can run here, else what the device lacks: "needs Vulkan 1.1, this device has
    // 1.0".
    [[nodiscard]] std::string missing() const;
    // Returns one line with type, version, memory and limits.
    [[nodiscard]] std::string description() const;
};

// Queries the device by the lower of its version and the instance's. A device older than Vulkan 1.1 gets the queries of
// 1.0 only, and missing() says so.
[[nodiscard]] Adapter query_adapter(const InstanceCalls& calls, VkPhysicalDevice device,
                                    std::uint32_t instance_version);

}  // namespace votess::gpu::vulkan
