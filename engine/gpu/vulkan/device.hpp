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
// Tries it out. float64: whether the device has it, and it is enabled.
[[nodiscard]] Rounding probe_rounding(Device& device, bool float64);

// Features to use where the device has them.
struct DeviceOptions {
    bool float64 = true;
};

// A device that a host program has made.
struct HostDevice {
    VkDevice handle = VK_NULL_HANDLE;
    std::uint32_t queue_family = 0;
    VkQueue queue = VK_NULL_HANDLE;      // for the probe of rounding; null: there is none
    bool float64 = false;                // enabled
    bool subgroup_size_control = false;  // enabled
    VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
};

// Outlives all that is made from it (Memory, Buffer, Pass, Commands), which keep a reference to it.
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
    // Read at every call, so that tests can replace an entry to make it fail.
    [[nodiscard]] VolkDeviceTable& table() { return table_; }
    [[nodiscard]] const Adapter& adapter() const { return adapter_; }  // queue_family: that of the queue
    [[nodiscard]] Instance& instance() { return *instance_; }
    // It counts only where it is rounded to nearest: bounds of float64 arithmetic rely on that.
    [[nodiscard]] bool has_float64() const { return float64_ && rounding_.nearest64; }
    [[nodiscard]] bool rounds_to_nearest() const { return rounding_.nearest32; }
    // Pipelines that are kept on disk; a host's device has none.
    [[nodiscard]] const PipelineCache& pipeline_cache() const { return *cache_; }
    [[nodiscard]] PassCache& pass_cache() { return *passes_; }
    [[nodiscard]] VkPipelineCache cache_handle() const { return cache_ ? cache_->handle() : host_cache_; }

    // Thread-safe: Vulkan wants calls on a queue one at a time.
    void submit(VkCommandBuffer commands, VkFence fence);
    // Waits until the queue is empty, as well as a lost device can; for destructors.
    void drain() noexcept;
    // A name for tools and messages; does nothing without VK_EXT_debug_utils.
    template <class Handle>
    void name(Handle object, VkObjectType type, const char* text) {
        set_name((std::uint64_t)object, type, text);  // a pointer or an integer, as the platform has it
    }

private:
    Device(std::shared_ptr<Instance> instance, const Adapter& adapter, const DeviceOptions& options);
    Device(std::shared_ptr<Instance> instance, const Adapter& adapter, const HostDevice& host);
    void set_name(std::uint64_t object, VkObjectType type, const char* text);

    std::shared_ptr<Instance> instance_;
    Adapter adapter_;
    VkDevice handle_ = VK_NULL_HANDLE;
    VolkDeviceTable table_{};
    VkQueue queue_ = VK_NULL_HANDLE;
    std::mutex queue_mutex_;
    bool float64_ = false;  // enabled
    Rounding rounding_;
    std::optional<PipelineCache> cache_;
    std::unique_ptr<PassCache> passes_;
    VkPipelineCache host_cache_ = VK_NULL_HANDLE;
    bool owned_ = true;
};

}  // namespace votess::gpu::vulkan
