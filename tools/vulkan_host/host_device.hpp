// The host's instance and device, which votess has no part in, made with exactly what votess asks for.
#pragma once

#include <volk.h>

#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>
#include <votess/vulkan.hpp>

namespace host {

// The machine lacks what the test needs; exit code 77.
struct NoDevice : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Throws for a negative result.
void check(VkResult result, const char* call);

// An object of a device, destroyed with it.
template <class Handle>
class Owned {
public:
    using Destroy = void(VKAPI_PTR*)(VkDevice, Handle, const VkAllocationCallbacks*);
    Owned() = default;
    Owned(VkDevice device, Handle handle, Destroy destroy) : device_(device), handle_(handle), destroy_(destroy) {}
    Owned(Owned&& other) noexcept { *this = std::move(other); }
    Owned& operator=(Owned&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        std::swap(destroy_, other.destroy_);
        return *this;
    }
    ~Owned() {
        if (handle_) destroy_(device_, handle_, nullptr);
    }
    [[nodiscard]] Handle get() const { return handle_; }

private:
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_ = VK_NULL_HANDLE;
    Destroy destroy_ = nullptr;
};

// What the validation layer says.
class Messages {
public:
    void add(std::string line);
    [[nodiscard]] std::vector<std::string> lines() const;

private:
    mutable std::mutex mutex_;
    std::vector<std::string> lines_;
};

struct DeviceOptions {
    std::string name;            // part of a name, "lavapipe", or an index; empty: the first that will do
    std::uint32_t validate = 0;  // 1: by the validation layer; 2: of synchronization too
    bool float64 = true;
    bool draws = true;  // else any queue that computes will do
};

class HostDevice {
public:
    // The messages outlive it: its end is looked at too.
    HostDevice(const DeviceOptions& options, Messages& messages);
    ~HostDevice();
    HostDevice(const HostDevice&) = delete;
    HostDevice& operator=(const HostDevice&) = delete;

    // What votess is told. Without a probe it gets no queue.
    [[nodiscard]] votess::vulkan::HostDevice for_votess(bool probe) const;

    [[nodiscard]] VkDevice device() const { return device_; }
    [[nodiscard]] VkQueue queue() const { return queue_; }
    [[nodiscard]] std::uint32_t queue_family() const { return queue_family_; }
    [[nodiscard]] VkPipelineCache pipeline_cache() const { return cache_.get(); }
    // Of timestamps of the queue; 0: it has none.
    [[nodiscard]] std::uint32_t timestamp_bits() const { return timestamp_bits_; }
    [[nodiscard]] const VkPhysicalDeviceProperties& properties() const { return properties_; }
    // A memory type out of `allowed` with these properties, if possible with the preferred ones too.
    [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed, VkMemoryPropertyFlags needed,
                                            VkMemoryPropertyFlags preferred) const;

private:
    static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                     VkDebugUtilsMessageTypeFlagsEXT types,
                                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void* messages);
    void create_instance();
    void choose(const std::string& name, bool draws);
    void create_device(bool float64);
    void destroy() noexcept;

    std::uint32_t validate_;
    Messages& messages_;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    VkPhysicalDeviceFeatures features_{};
    bool subgroup_size_control_ = false;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::uint32_t timestamp_bits_ = 0;
    std::uint32_t queue_family_ = 0;
    Owned<VkPipelineCache> cache_;
};

}  // namespace host
