// A logical device with one compute queue.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "gpu/vulkan/instance.hpp"
#include "gpu/vulkan/pipeline_cache.hpp"

namespace votess::gpu::vulkan {

class Device;
class PassCache;

// How a device rounds.
struct Rounding {
    // float32 sums, products and conversions are rounded to nearest even, fma() once or twice, and quotients and roots
    // are right to a few units in the last place.
    bool nearest32 = false;
    bool nearest64 = false;  // the same in float64
};
// Runs a shader to find out. float64: whether the device has it and it is enabled.
[[nodiscard]] Rounding probe_rounding(Device& device, bool float64);

// Runs a shader to find the size of its subgroups. Returns 0 where they differ or have missing lanes.
[[nodiscard]] std::uint32_t probe_subgroup_size(Device& device);

// Features to enable where the device has them.
struct DeviceOptions {
    bool float64 = true;
    bool exports = false;  // timeline semaphores and memory for another API; of Vulkan 1.2 with exports_memory
};

// A device of a host program.
struct HostDevice {
    VkDevice handle = VK_NULL_HANDLE;
    std::uint32_t queue_family = 0;
    VkQueue queue = VK_NULL_HANDLE;      // runs the probes; null: none
    bool float64 = false;                // enabled
    bool subgroup_size_control = false;  // enabled
    VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
};

// Must outlive the Memory, Buffer, Pass and Commands made from it, which keep a reference to it.
class Device {
public:
    // Throws `unsupported` with Adapter::missing() when that is not empty.
    [[nodiscard]] static std::shared_ptr<Device> create(std::shared_ptr<Instance> instance, const Adapter& adapter,
                                                        const DeviceOptions& options = {});
    // Borrows the device, which the host destroys. Throws as create() does.
    [[nodiscard]] static std::shared_ptr<Device> adopt(std::shared_ptr<Instance> instance, const Adapter& adapter,
                                                       const HostDevice& host);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] VkDevice handle() const { return handle_; }
    // Tests replace entries to make them fail; so the table is read at every call.
    [[nodiscard]] VolkDeviceTable& table() { return table_; }
    // queue_family: that of the queue. Sizes of subgroups: as probed, where they vary and shaders cannot choose.
    [[nodiscard]] const Adapter& adapter() const { return adapter_; }
    [[nodiscard]] Instance& instance() { return *instance_; }
    // Returns whether float64 is enabled and rounds to nearest, on which the error bounds rely.
    [[nodiscard]] bool has_float64() const { return float64_ && rounding_.nearest64; }
    [[nodiscard]] bool rounds_to_nearest() const { return rounding_.nearest32; }
    // What shaders must demand.
    [[nodiscard]] const FloatDemands& demands() const { return demands_; }
    // The pipelines on disk. A host's device has none.
    [[nodiscard]] const PipelineCache& pipeline_cache() const { return *cache_; }
    [[nodiscard]] PassCache& pass_cache() { return *passes_; }
    [[nodiscard]] VkPipelineCache cache_handle() const { return cache_ ? cache_->handle() : host_cache_; }

    // Thread-safe: a mutex orders the calls on the queue.
    void submit(const VkSubmitInfo& info, VkFence fence);
    // Waits until the queue is empty or the device is lost. For destructors.
    void drain() noexcept;
    // Names an object for tools and messages; does nothing without VK_EXT_debug_utils.
    template <class Handle>
    void name(Handle object, VkObjectType type, const char* text) {
        set_name((std::uint64_t)object, type, text);  // the platform decides: a pointer or an integer
    }

private:
    Device(std::shared_ptr<Instance> instance, const Adapter& adapter, const DeviceOptions& options);
    Device(std::shared_ptr<Instance> instance, const Adapter& adapter, const HostDevice& host);
    template <class How>
    [[nodiscard]] static std::shared_ptr<Device> make(std::shared_ptr<Instance> instance, const Adapter& adapter,
                                                      const How& how);
    void find_rounding();
    void find_subgroup_size();
    void set_name(std::uint64_t object, VkObjectType type, const char* text);

    std::shared_ptr<Instance> instance_;
    Adapter adapter_;
    VkDevice handle_ = VK_NULL_HANDLE;
    VolkDeviceTable table_{};
    VkQueue queue_ = VK_NULL_HANDLE;
    std::mutex queue_mutex_;
    bool float64_ = false;  // enabled
    Rounding rounding_;
    FloatDemands demands_;
    std::optional<PipelineCache> cache_;
    std::unique_ptr<PassCache> passes_;
    VkPipelineCache host_cache_ = VK_NULL_HANDLE;
    bool owned_ = true;
};

}  // namespace votess::gpu::vulkan
