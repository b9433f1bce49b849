// Buffers, and commands that are run once.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "host_device.hpp"

namespace host {

enum class Place { device, host };  // host: mapped, for copies from and to the device

class Buffer {
public:
    Buffer() = default;
    Buffer(const HostDevice& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place);

    [[nodiscard]] VkBuffer get() const { return buffer_.get(); }
    [[nodiscard]] VkDeviceSize bytes() const { return bytes_; }
    [[nodiscard]] std::span<std::byte> mapped() const { return {mapped_, static_cast<std::size_t>(bytes_)}; }

private:
    // In this order: the buffer goes before its memory.
    Owned<VkDeviceMemory> memory_;
    Owned<VkBuffer> buffer_;
    VkDeviceSize bytes_ = 0;
    std::byte* mapped_ = nullptr;
};

// A pool whose command buffers are begun anew for each use.
[[nodiscard]] Owned<VkCommandPool> make_command_pool(const HostDevice& device);
[[nodiscard]] VkCommandBuffer make_commands(const HostDevice& device, VkCommandPool pool);
[[nodiscard]] Owned<VkFence> make_fence(const HostDevice& device);
void wait(const HostDevice& device, VkFence fence);

// Makes writes at one stage visible to another.
void barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
             VkAccessFlags read);

// A pool of timestamps; null where the queue has none.
[[nodiscard]] Owned<VkQueryPool> make_timestamps(const HostDevice& device, std::uint32_t count);
// All of a finished pool, from the first on; empty for none.
[[nodiscard]] std::vector<double> seconds_of(const HostDevice& device, VkQueryPool pool, std::uint32_t count);

// Outside of the frames: records commands, submits them and waits.
void run_once(const HostDevice& device, const std::function<void(VkCommandBuffer)>& record);
void upload(const HostDevice& device, std::span<const std::byte> bytes, VkBuffer target);
[[nodiscard]] std::vector<std::byte> download(const HostDevice& device, VkBuffer source, VkDeviceSize bytes);

}  // namespace host
