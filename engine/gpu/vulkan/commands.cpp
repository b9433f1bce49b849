#include "gpu/vulkan/commands.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace votess::gpu::vulkan {

Commands::Commands(Device& device, std::uint32_t timestamps) : Recorder(device) {
    try {
        make_objects(device.adapter().timestamp_bits > 0 ? timestamps : 0);
    } catch (...) {
        destroy();
        throw;
    }
}

Commands::~Commands() {
    destroy();
}

void Commands::make_objects(std::uint32_t timestamps) {
    const VolkDeviceTable& table = device().table();
    auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.queueFamilyIndex = device().adapter().queue_family;
    check(table.vkCreateCommandPool(device().handle(), &pool, nullptr, &pool_), "vkCreateCommandPool");

    auto buffer = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    buffer.commandPool = pool_;
    buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    buffer.commandBufferCount = 1;
    check(table.vkAllocateCommandBuffers(device().handle(), &buffer, &commands_), "vkAllocateCommandBuffers");

    auto fence = structure<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
    check(table.vkCreateFence(device().handle(), &fence, nullptr, &fence_), "vkCreateFence");

    if (timestamps == 0) return;
    auto queries = structure<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = timestamps;
    check(table.vkCreateQueryPool(device().handle(), &queries, nullptr, &queries_), "vkCreateQueryPool");
    query_capacity_ = timestamps;
}

void Commands::destroy() noexcept {
    if (state_ == State::running) device().drain();
    const VolkDeviceTable& table = device().table();
    const VkDevice handle = device().handle();
    table.vkDestroyQueryPool(handle, queries_, nullptr);
    table.vkDestroyFence(handle, fence_, nullptr);
    table.vkDestroyCommandPool(handle, pool_, nullptr);  // and its command buffer
}

void Commands::expect(State state, const char* call) const {
    if (state_ != state) throw Error(ErrorCode::internal, std::string("Commands::") + call + " at the wrong time");
}

void Commands::begin() {
    wait();
    const VolkDeviceTable& table = device().table();
    close();
    state_ = State::idle;
    check(table.vkResetCommandPool(device().handle(), pool_, 0), "vkResetCommandPool");
    descriptor_sets().forget();
    auto info = structure<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    check(table.vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
    state_ = State::recording;
    open(commands_);
    query_count_ = 0;
    if (queries_) table.vkCmdResetQueryPool(commands_, queries_, 0, query_capacity_);
}

void Commands::end() {
    expect(State::recording, "end");
    check(device().table().vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
    close();
    state_ = State::ready;
}

std::uint32_t Commands::timestamp() {
    expect(State::recording, "timestamp");
    if (query_count_ == query_capacity_) return no_timestamp;
    write_timestamp(queries_, query_count_);
    return query_count_++;
}

double Commands::seconds(std::uint32_t from, std::uint32_t to) const {
    expect(State::ready, "seconds");
    if (from >= query_count_ || to >= query_count_) return 0;
    std::array<std::uint64_t, 2> ticks{};
    const std::array queries{from, to};
    for (std::size_t i = 0; i < 2; ++i) {
        const VkResult result =
            device().table().vkGetQueryPoolResults(device().handle(), queries_, queries[i], 1, sizeof ticks[i],
                                                   &ticks[i], sizeof ticks[i], VK_QUERY_RESULT_64_BIT);
        check(result, "vkGetQueryPoolResults");
        if (result != VK_SUCCESS) return 0;
    }
    // The counter has this many bits and wraps around.
    const std::uint32_t bits = device().adapter().timestamp_bits;
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    const double period = device().adapter().limits.timestampPeriod;
    return static_cast<double>((ticks[1] - ticks[0]) & mask) * period * 1e-9;
}

void Commands::submit() {
    expect(State::ready, "submit");
    check(device().table().vkResetFences(device().handle(), 1, &fence_), "vkResetFences");
    auto info = structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands_;
    device().submit(info, fence_);
    state_ = State::running;
}

bool Commands::finished() {
    return wait_for(std::chrono::nanoseconds{0});
}

bool Commands::wait_for(std::chrono::nanoseconds timeout) {
    if (state_ != State::running) return true;
    const auto limit = static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 0));
    const VkResult result = device().table().vkWaitForFences(device().handle(), 1, &fence_, VK_TRUE, limit);
    check(result, "vkWaitForFences");
    if (result != VK_SUCCESS) return false;
    state_ = State::ready;
    return true;
}

void Commands::wait() {
    // Waits in slices: some drivers notice a lost device only at the next call.
    while (!wait_for(std::chrono::milliseconds{500})) {
    }
}

}  // namespace votess::gpu::vulkan
