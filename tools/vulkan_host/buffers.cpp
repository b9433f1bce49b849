#include "buffers.hpp"

#include <algorithm>

namespace host {

Buffer::Buffer(const HostDevice& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place) : bytes_(bytes) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = bytes;
    info.usage = usage;
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(device.device(), &info, nullptr, &buffer), "vkCreateBuffer");
    buffer_ = {device.device(), buffer, vkDestroyBuffer};

    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device.device(), buffer, &needs);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    constexpr VkMemoryPropertyFlags visible =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    allocate.memoryTypeIndex =
        place == Place::host ? device.memory_type(needs.memoryTypeBits, visible, VK_MEMORY_PROPERTY_HOST_CACHED_BIT)
                             : device.memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device.device(), &allocate, nullptr, &memory), "vkAllocateMemory");
    memory_ = {device.device(), memory, vkFreeMemory};
    check(vkBindBufferMemory(device.device(), buffer, memory, 0), "vkBindBufferMemory");
    if (place == Place::device) return;
    void* mapped = nullptr;
    check(vkMapMemory(device.device(), memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    mapped_ = static_cast<std::byte*>(mapped);
}

Owned<VkCommandPool> make_command_pool(const HostDevice& device) {
    VkCommandPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    info.queueFamilyIndex = device.queue_family();
    VkCommandPool pool = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device.device(), &info, nullptr, &pool), "vkCreateCommandPool");
    return {device.device(), pool, vkDestroyCommandPool};
}

VkCommandBuffer make_commands(const HostDevice& device, VkCommandPool pool) {
    VkCommandBufferAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    info.commandPool = pool;
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    check(vkAllocateCommandBuffers(device.device(), &info, &commands), "vkAllocateCommandBuffers");
    return commands;
}

Owned<VkFence> make_fence(const HostDevice& device) {
    VkFenceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    VkFence fence = VK_NULL_HANDLE;
    check(vkCreateFence(device.device(), &info, nullptr, &fence), "vkCreateFence");
    return {device.device(), fence, vkDestroyFence};
}

void wait(const HostDevice& device, VkFence fence) {
    constexpr std::uint64_t minutes = 60'000'000'000;
    const VkResult result = vkWaitForFences(device.device(), 1, &fence, VK_TRUE, 5 * minutes);
    check(result, "vkWaitForFences");
    if (result == VK_TIMEOUT) throw std::runtime_error("the device has not finished after five minutes");
}

void barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
             VkAccessFlags read) {
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = written;
    memory.dstAccessMask = read;
    vkCmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

Owned<VkQueryPool> make_timestamps(const HostDevice& device, std::uint32_t count) {
    if (device.timestamp_bits() == 0) return {};
    VkQueryPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = count;
    VkQueryPool pool = VK_NULL_HANDLE;
    check(vkCreateQueryPool(device.device(), &info, nullptr, &pool), "vkCreateQueryPool");
    return {device.device(), pool, vkDestroyQueryPool};
}

std::vector<double> seconds_of(const HostDevice& device, VkQueryPool pool, std::uint32_t count) {
    if (pool == VK_NULL_HANDLE) return {};
    std::vector<std::uint64_t> ticks(count);
    check(vkGetQueryPoolResults(device.device(), pool, 0, count, count * sizeof ticks[0], ticks.data(), sizeof ticks[0],
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "vkGetQueryPoolResults");
    // The counter has so many bits, and wraps around.
    const std::uint32_t bits = device.timestamp_bits();
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    const double period = static_cast<double>(device.properties().limits.timestampPeriod) * 1e-9;
    std::vector<double> seconds;
    for (const std::uint64_t tick : ticks) seconds.push_back(static_cast<double>((tick - ticks[0]) & mask) * period);
    return seconds;
}

void run_once(const HostDevice& device, const std::function<void(VkCommandBuffer)>& record) {
    const Owned<VkCommandPool> pool = make_command_pool(device);
    const Owned<VkFence> fence = make_fence(device);
    const VkCommandBuffer commands = make_commands(device, pool.get());
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    record(commands);
    check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    check(vkQueueSubmit(device.queue(), 1, &submit, fence.get()), "vkQueueSubmit");
    wait(device, fence.get());
}

void upload(const HostDevice& device, std::span<const std::byte> bytes, VkBuffer target) {
    const Buffer staging(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Place::host);
    std::copy(bytes.begin(), bytes.end(), staging.mapped().begin());
    run_once(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, 0, bytes.size()};
        vkCmdCopyBuffer(commands, staging.get(), target, 1, &copy);
        barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT);
    });
}

std::vector<std::byte> download(const HostDevice& device, VkBuffer source, VkDeviceSize bytes) {
    const Buffer staging(device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::host);
    run_once(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, 0, bytes};
        vkCmdCopyBuffer(commands, source, staging.get(), 1, &copy);
        barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                VK_ACCESS_HOST_READ_BIT);
    });
    return {staging.mapped().begin(), staging.mapped().end()};
}

}  // namespace host
