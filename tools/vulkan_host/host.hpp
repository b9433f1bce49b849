// A small Vulkan host for tests and benchmarks: an instance and a device made through volk, buffers, commands.
#pragma once

#include <volk.h>

#include <cstddef>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>
#include <votess/vulkan.hpp>

namespace host {

// Thrown when the machine lacks a device that matches; tests skip then.
struct NoDevice : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Throws std::runtime_error for a negative result.
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

class Device {
public:
    using GetRequirements = votess::vulkan::Requirements(const votess::vulkan::HostInstance&, VkPhysicalDevice);

    // name: part of a device's name, "lavapipe", or an index. get_requirements: votess::vulkan::requirements, which
    // this library does not link; null for a device that votess is not given. Throws NoDevice.
    Device(const std::string& name, GetRequirements* get_requirements);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] votess::vulkan::HostDevice for_votess() const;
    [[nodiscard]] VkDevice handle() const { return device_; }
    [[nodiscard]] VkQueue queue() const { return queue_; }
    [[nodiscard]] std::uint32_t queue_family() const { return queue_family_; }
    // Bits of the queue's timestamps; 0: it has none.
    [[nodiscard]] std::uint32_t timestamp_bits() const { return timestamp_bits_; }
    [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return properties_.limits; }
    // Returns a memory type out of `allowed` with the needed properties, and the preferred ones if there is such a
    // type.
    [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed, VkMemoryPropertyFlags needed,
                                            VkMemoryPropertyFlags preferred) const;

private:
    void create_instance();
    void choose(const std::string& name);
    void create_device(GetRequirements* get_requirements);
    void destroy() noexcept;

    VkInstance instance_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    votess::vulkan::Requirements requirements_;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::uint32_t queue_family_ = 0;
    std::uint32_t timestamp_bits_ = 0;
    Owned<VkPipelineCache> cache_;
};

enum class Place { device, host };  // host: mapped, for copies from and to the device

class Buffer {
public:
    Buffer() = default;
    Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place);

    [[nodiscard]] VkBuffer get() const { return buffer_.get(); }
    [[nodiscard]] VkDeviceSize bytes() const { return bytes_; }
    [[nodiscard]] std::span<std::byte> mapped() const { return {mapped_, static_cast<std::size_t>(bytes_)}; }

private:
    // In this order: the buffer is destroyed before its memory.
    Owned<VkDeviceMemory> memory_;
    Owned<VkBuffer> buffer_;
    VkDeviceSize bytes_ = 0;
    std::byte* mapped_ = nullptr;
};

// Records commands, submits them and waits.
void run_once(const Device& device, const std::function<void(VkCommandBuffer)>& record);
void upload(const Device& device, std::span<const std::byte> bytes, VkBuffer target);
[[nodiscard]] std::vector<std::byte> download(const Device& device, VkBuffer source, VkDeviceSize bytes);

// Makes a pool of timestamps; null if the queue has none.
[[nodiscard]] Owned<VkQueryPool> make_timestamps(const Device& device, std::uint32_t count);
// Returns the seconds from the first timestamp to each; empty for a null pool.
[[nodiscard]] std::vector<double> seconds_of(const Device& device, VkQueryPool pool, std::uint32_t count);

}  // namespace host
