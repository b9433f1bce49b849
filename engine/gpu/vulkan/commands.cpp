#include "gpu/vulkan/commands.hpp"

#include <algorithm>
#include <string>

namespace votess::gpu::vulkan {
namespace {

constexpr std::uint64_t ceil_div(std::uint64_t a, std::uint64_t b) {
    return a / b + (a % b != 0);
}

[[noreturn]] void misuse(const std::string& what) {
    throw Error(ErrorCode::internal, what);
}

}  // namespace

std::array<std::uint32_t, 3> group_counts(std::uint64_t invocations, std::uint32_t local_size,
                                          const VkPhysicalDeviceLimits& limits) {
    const auto& most = limits.maxComputeWorkGroupCount;
    const std::uint64_t groups = ceil_div(invocations, local_size);
    if (groups == 0) return {0, 0, 0};
    // As few layers and rows as will do, then of equal length: the surplus is less than a row and a layer of columns.
    const std::uint64_t z = ceil_div(ceil_div(groups, most[0]), most[1]);
    const std::uint64_t y = ceil_div(ceil_div(groups, z), most[0]);
    const std::uint64_t x = ceil_div(groups, y * z);
    // Shaders count in 32 bits: an index that wraps around would do its work twice.
    if (z > most[2] || x * y * z > (std::uint64_t{1} << 32) / local_size) {
        misuse("a dispatch of " + std::to_string(invocations) + " invocations is too large");
    }
    return {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(z)};
}

Commands::Commands(Device& device, std::uint32_t timestamps) : device_(device) {
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
    const VolkDeviceTable& table = device_.table();
    VkCommandPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool.queueFamilyIndex = device_.adapter().queue_family;
    check(table.vkCreateCommandPool(device_.handle(), &pool, nullptr, &pool_), "vkCreateCommandPool");

    VkCommandBufferAllocateInfo buffer{};
    buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    buffer.commandPool = pool_;
    buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    buffer.commandBufferCount = 1;
    check(table.vkAllocateCommandBuffers(device_.handle(), &buffer, &buffer_), "vkAllocateCommandBuffers");

    VkFenceCreateInfo fence{};
    fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    check(table.vkCreateFence(device_.handle(), &fence, nullptr, &fence_), "vkCreateFence");

    if (timestamps == 0) return;
    VkQueryPoolCreateInfo queries{};
    queries.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = timestamps;
    check(table.vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_), "vkCreateQueryPool");
    query_capacity_ = timestamps;
}

void Commands::destroy() noexcept {
    if (state_ == State::running) device_.drain();
    const VolkDeviceTable& table = device_.table();
    const VkDevice device = device_.handle();
    table.vkDestroyQueryPool(device, queries_, nullptr);
    for (const DescriptorPool& pool : descriptor_pools_) table.vkDestroyDescriptorPool(device, pool.handle, nullptr);
    table.vkDestroyFence(device, fence_, nullptr);
    table.vkDestroyCommandPool(device, pool_, nullptr);  // and its command buffer
}

void Commands::expect(State state, const char* call) const {
    if (state_ != state) misuse(std::string("Commands::") + call + " at the wrong time");
}

void Commands::begin() {
    wait();
    const VolkDeviceTable& table = device_.table();
    state_ = State::idle;
    check(table.vkResetCommandPool(device_.handle(), pool_, 0), "vkResetCommandPool");
    for (DescriptorPool& pool : descriptor_pools_) {
        check(table.vkResetDescriptorPool(device_.handle(), pool.handle, 0), "vkResetDescriptorPool");
        pool.sets = pool.max_sets;
        pool.descriptors = pool.max_descriptors;
    }
    VkCommandBufferBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    check(table.vkBeginCommandBuffer(buffer_, &info), "vkBeginCommandBuffer");
    state_ = State::recording;
    query_count_ = 0;
    if (queries_) table.vkCmdResetQueryPool(buffer_, queries_, 0, query_capacity_);
}

void Commands::end() {
    expect(State::recording, "end");
    check(device_.table().vkEndCommandBuffer(buffer_), "vkEndCommandBuffer");
    state_ = State::ready;
}

void Commands::copy(const Buffer& from, VkDeviceSize from_offset, const Buffer& to, VkDeviceSize to_offset,
                    VkDeviceSize bytes) {
    expect(State::recording, "copy");
    if (bytes == 0) return;
    if (from_offset > from.size() || bytes > from.size() - from_offset || to_offset > to.size() ||
        bytes > to.size() - to_offset) {
        misuse("Commands::copy beyond the end of a buffer");
    }
    const VkBufferCopy region{from_offset, to_offset, bytes};
    device_.table().vkCmdCopyBuffer(buffer_, from.handle(), to.handle(), 1, &region);
}

void Commands::fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize bytes, std::uint32_t word) {
    expect(State::recording, "fill");
    if (bytes == 0) return;
    if (offset > buffer.size() || bytes > buffer.size() - offset) misuse("Commands::fill beyond the end of a buffer");
    if (offset % 4 != 0 || bytes % 4 != 0) misuse("Commands::fill of something else than words");
    device_.table().vkCmdFillBuffer(buffer_, buffer.handle(), offset, bytes, word);
}

Commands::DescriptorPool& Commands::pool_for(std::uint32_t descriptors) {
    for (DescriptorPool& pool : descriptor_pools_) {
        if (pool.sets > 0 && pool.descriptors >= descriptors) return pool;
    }
    // Each pool is twice as large as the one before.
    const std::uint32_t sets = 32u << std::min<std::size_t>(descriptor_pools_.size(), 8);
    DescriptorPool pool{VK_NULL_HANDLE, sets, std::max(8 * sets, descriptors), sets, std::max(8 * sets, descriptors)};
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, pool.max_descriptors};
    VkDescriptorPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    info.maxSets = pool.max_sets;
    info.poolSizeCount = 1;
    info.pPoolSizes = &size;
    descriptor_pools_.reserve(descriptor_pools_.size() + 1);
    check(device_.table().vkCreateDescriptorPool(device_.handle(), &info, nullptr, &pool.handle),
          "vkCreateDescriptorPool");
    return descriptor_pools_.emplace_back(pool);
}

VkDescriptorSet Commands::new_set(const Pass& pass) {
    const auto descriptors = static_cast<std::uint32_t>(pass.bindings().size());
    DescriptorPool& pool = pool_for(descriptors);
    const VkDescriptorSetLayout layout = pass.set_layout();
    VkDescriptorSetAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    info.descriptorPool = pool.handle;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(device_.table().vkAllocateDescriptorSets(device_.handle(), &info, &set), "vkAllocateDescriptorSets");
    --pool.sets;
    pool.descriptors -= descriptors;
    return set;
}

VkDescriptorBufferInfo Commands::descriptor(const Pass& pass, std::uint32_t binding,
                                            std::span<const BufferBinding> buffers) const {
    const auto where = "binding " + std::to_string(binding) + " of the pass " + pass.name();
    const auto it = std::find_if(buffers.begin(), buffers.end(), [&](const auto& b) { return b.binding == binding; });
    if (it == buffers.end() || !it->buffer || !*it->buffer) misuse(where + " has no buffer");
    const VkPhysicalDeviceLimits& limits = device_.adapter().limits;
    const VkDeviceSize size = it->buffer->size();
    if (it->offset > size) misuse(where + " begins beyond the end of its buffer");
    const VkDeviceSize rest = size - it->offset;
    const VkDeviceSize bytes = it->bytes == VK_WHOLE_SIZE ? rest : it->bytes;
    if (bytes > rest) misuse(where + " goes beyond the end of its buffer");
    if (it->offset % std::max<VkDeviceSize>(limits.minStorageBufferOffsetAlignment, 1) != 0) {
        misuse(where + " begins at an offset that the device cannot bind");
    }
    if (bytes == 0) return {it->buffer->handle(), 0, 16};  // Vulkan has no empty range; shaders check bounds
    const VkDeviceSize whole_words = ceil_div(bytes, 4) * 4;
    if (whole_words > limits.maxStorageBufferRange) {
        misuse(where + " is larger than the device can bind: " + std::to_string(whole_words) + " bytes of " +
               std::to_string(limits.maxStorageBufferRange));
    }
    return {it->buffer->handle(), it->offset, whole_words};
}

void Commands::bind(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push) {
    expect(State::recording, "dispatch");
    if (push.size() != pass.push_bytes()) {
        misuse("the pass " + pass.name() + " takes " + std::to_string(pass.push_bytes()) +
               " bytes of push constants, not " + std::to_string(push.size()));
    }
    const VolkDeviceTable& table = device_.table();
    table.vkCmdBindPipeline(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pass.pipeline());
    if (!push.empty()) {
        table.vkCmdPushConstants(buffer_, pass.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, pass.push_bytes(),
                                 push.data());
    }
    if (pass.bindings().empty()) return;
    const std::size_t count = pass.bindings().size();
    std::vector<VkDescriptorBufferInfo> infos(count);
    std::vector<VkWriteDescriptorSet> writes(count);
    for (std::size_t i = 0; i < count; ++i) infos[i] = descriptor(pass, pass.bindings()[i], buffers);
    const VkDescriptorSet set = new_set(pass);
    for (std::size_t i = 0; i < count; ++i) {
        writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[i].dstSet = set;
        writes[i].dstBinding = pass.bindings()[i];
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        writes[i].pBufferInfo = &infos[i];
    }
    table.vkUpdateDescriptorSets(device_.handle(), static_cast<std::uint32_t>(count), writes.data(), 0, nullptr);
    table.vkCmdBindDescriptorSets(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pass.layout(), 0, 1, &set, 0, nullptr);
}

void Commands::dispatch(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push,
                        std::uint64_t invocations) {
    const auto [x, y, z] = group_counts(invocations, pass.local_size(), device_.adapter().limits);
    if (x == 0) return;
    bind(pass, buffers, push);
    device_.table().vkCmdDispatch(buffer_, x, y, z);
}

void Commands::dispatch_indirect(const Pass& pass, std::span<const BufferBinding> buffers,
                                 std::span<const std::byte> push, const Buffer& args, VkDeviceSize offset) {
    if (offset % 4 != 0 || offset > args.size() || args.size() - offset < sizeof(VkDispatchIndirectCommand)) {
        misuse("the arguments of the indirect pass " + pass.name() + " are not in their buffer");
    }
    bind(pass, buffers, push);
    device_.table().vkCmdDispatchIndirect(buffer_, args.handle(), offset);
}

void Commands::barrier() {
    expect(State::recording, "barrier");
    VkMemoryBarrier all{};
    all.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    all.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    all.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                        VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
    constexpr VkPipelineStageFlags work = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    device_.table().vkCmdPipelineBarrier(buffer_, work, work | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT, 0, 1, &all, 0,
                                         nullptr, 0, nullptr);
}

void Commands::barrier_to_host() {
    expect(State::recording, "barrier_to_host");
    VkMemoryBarrier all{};
    all.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    all.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    all.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    device_.table().vkCmdPipelineBarrier(buffer_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                                         VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &all, 0, nullptr, 0, nullptr);
}

Commands::Label::Label(Commands& commands, const char* text) : commands_(commands) {
    commands.expect(State::recording, "label");
    if (!commands.device_.instance().debug_utils()) return;
    VkDebugUtilsLabelEXT label{};
    label.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT;
    label.pLabelName = text;
    commands.device_.instance().calls().vkCmdBeginDebugUtilsLabelEXT(commands.buffer_, &label);
}

Commands::Label::~Label() {
    if (commands_.state_ != State::recording || !commands_.device_.instance().debug_utils()) return;
    commands_.device_.instance().calls().vkCmdEndDebugUtilsLabelEXT(commands_.buffer_);
}

std::uint32_t Commands::timestamp() {
    expect(State::recording, "timestamp");
    if (query_count_ == query_capacity_) return no_timestamp;
    device_.table().vkCmdWriteTimestamp(buffer_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, query_count_);
    return query_count_++;
}

double Commands::seconds(std::uint32_t from, std::uint32_t to) const {
    expect(State::ready, "seconds");
    if (from >= query_count_ || to >= query_count_) return 0;
    std::array<std::uint64_t, 2> ticks{};
    const std::array queries{from, to};
    for (std::size_t i = 0; i < 2; ++i) {
        const VkResult result =
            device_.table().vkGetQueryPoolResults(device_.handle(), queries_, queries[i], 1, sizeof ticks[i], &ticks[i],
                                                  sizeof ticks[i], VK_QUERY_RESULT_64_BIT);
        check(result, "vkGetQueryPoolResults");
        if (result != VK_SUCCESS) return 0;
    }
    // The counter has this many bits and wraps around.
    const std::uint32_t bits = device_.adapter().timestamp_bits;
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    const double period = device_.adapter().limits.timestampPeriod;
    return static_cast<double>((ticks[1] - ticks[0]) & mask) * period * 1e-9;
}

void Commands::submit() {
    expect(State::ready, "submit");
    check(device_.table().vkResetFences(device_.handle(), 1, &fence_), "vkResetFences");
    device_.submit(buffer_, fence_);
    state_ = State::running;
}

bool Commands::finished() {
    return wait_for(std::chrono::nanoseconds{0});
}

bool Commands::wait_for(std::chrono::nanoseconds timeout) {
    if (state_ != State::running) return true;
    const auto limit = static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 0));
    const VkResult result = device_.table().vkWaitForFences(device_.handle(), 1, &fence_, VK_TRUE, limit);
    check(result, "vkWaitForFences");
    if (result != VK_SUCCESS) return false;
    state_ = State::ready;
    return true;
}

void Commands::wait() {
    // In slices: some drivers notice a lost device only when they are asked again.
    while (!wait_for(std::chrono::milliseconds{500})) {
    }
}

}  // namespace votess::gpu::vulkan
