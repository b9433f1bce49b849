#include "gpu/vulkan/recorder.hpp"

#include <algorithm>
#include <string>

#include "core/arithmetic.hpp"
#include "shared/interface.h"

namespace votess::gpu::vulkan {
namespace {

[[noreturn]] void misuse(const std::string& what) {
    throw Error(ErrorCode::internal, what);
}

constexpr VkPipelineStageFlags work = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;

}  // namespace

std::array<std::uint32_t, 3> group_counts(std::uint64_t invocations, std::uint32_t local_size,
                                          const VkPhysicalDeviceLimits& limits) {
    const auto& most = limits.maxComputeWorkGroupCount;
    const std::uint64_t groups = ceil_div(invocations, local_size);
    if (groups == 0) return {0, 0, 0};
    // Uses as few layers and rows as possible, equally long: the surplus is less than a row and a layer of columns.
    const std::uint64_t z = ceil_div(ceil_div(groups, most[0]), most[1]);
    const std::uint64_t y = ceil_div(ceil_div(groups, z), most[0]);
    const std::uint64_t x = ceil_div(groups, y * z);
    // Shaders count in 32 bits: work whose index wraps around would be done twice.
    if (z > most[2] || x * y * z > (std::uint64_t{1} << 32) / local_size) {
        misuse("a dispatch of " + std::to_string(invocations) + " invocations is too large");
    }
    return {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(z)};
}

DescriptorSets::~DescriptorSets() {
    for (const Pool& pool : pools_) device_.table().vkDestroyDescriptorPool(device_.handle(), pool.handle, nullptr);
}

void DescriptorSets::forget() {
    for (Pool& pool : pools_) {
        check(device_.table().vkResetDescriptorPool(device_.handle(), pool.handle, 0), "vkResetDescriptorPool");
        pool.sets = pool.max_sets;
        pool.descriptors = pool.max_descriptors;
    }
    known_.clear();
    infos_.clear();
}

DescriptorSets::Pool& DescriptorSets::pool_for(std::uint32_t descriptors) {
    for (Pool& pool : pools_) {
        if (pool.sets > 0 && pool.descriptors >= descriptors) return pool;
    }
    // Each pool is twice as large as the one before.
    const std::uint32_t sets = 32u << std::min<std::size_t>(pools_.size(), 8);
    Pool pool{VK_NULL_HANDLE, sets, std::max(8 * sets, descriptors), sets, std::max(8 * sets, descriptors)};
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, pool.max_descriptors};
    auto info = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    info.maxSets = pool.max_sets;
    info.poolSizeCount = 1;
    info.pPoolSizes = &size;
    pools_.reserve(pools_.size() + 1);
    check(device_.table().vkCreateDescriptorPool(device_.handle(), &info, nullptr, &pool.handle),
          "vkCreateDescriptorPool");
    return pools_.emplace_back(pool);
}

VkDescriptorSet DescriptorSets::get(const Pass& pass, std::span<const VkDescriptorBufferInfo> infos) {
    const auto same = [](const VkDescriptorBufferInfo& a, const VkDescriptorBufferInfo& b) {
        return a.buffer == b.buffer && a.offset == b.offset && a.range == b.range;
    };
    for (const Known& known : known_)
        if (known.layout == pass.set_layout() &&
            std::equal(infos.begin(), infos.end(), infos_.begin() + static_cast<std::ptrdiff_t>(known.first_info),
                       same))
            return known.set;

    const auto count = static_cast<std::uint32_t>(infos.size());
    Pool& pool = pool_for(count);
    const VkDescriptorSetLayout layout = pass.set_layout();
    auto info = structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    info.descriptorPool = pool.handle;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(device_.table().vkAllocateDescriptorSets(device_.handle(), &info, &set), "vkAllocateDescriptorSets");
    --pool.sets;
    pool.descriptors -= count;

    std::array<VkWriteDescriptorSet, MAX_BINDINGS> writes{};
    for (std::uint32_t i = 0; i < count; ++i) {
        writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[i].dstSet = set;
        writes[i].dstBinding = pass.bindings()[i];
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        writes[i].pBufferInfo = &infos[i];
    }
    device_.table().vkUpdateDescriptorSets(device_.handle(), count, writes.data(), 0, nullptr);
    known_.push_back({layout, set, infos_.size()});
    infos_.insert(infos_.end(), infos.begin(), infos.end());
    return set;
}

void Recorder::expect_open(const char* call) const {
    if (!open_) misuse(std::string("Commands::") + call + " at the wrong time");
}

void Recorder::open(VkCommandBuffer commands) {
    buffer_ = commands;
    open_ = true;
}

void Recorder::copy(const Slice& from, VkDeviceSize from_offset, const Slice& to, VkDeviceSize to_offset,
                    VkDeviceSize bytes) {
    expect_open("copy");
    if (bytes == 0) return;
    if (from_offset > from.size || bytes > from.size - from_offset || to_offset > to.size ||
        bytes > to.size - to_offset) {
        misuse("Commands::copy beyond the end of a buffer");
    }
    if (buffer_ == VK_NULL_HANDLE) return;
    const VkBufferCopy region{from.offset + from_offset, to.offset + to_offset, bytes};
    device_.table().vkCmdCopyBuffer(buffer_, from.handle, to.handle, 1, &region);
}

void Recorder::fill(const Slice& buffer, VkDeviceSize offset, VkDeviceSize bytes, std::uint32_t word) {
    expect_open("fill");
    if (bytes == 0) return;
    if (offset > buffer.size || bytes > buffer.size - offset) misuse("Commands::fill beyond the end of a buffer");
    if (offset % 4 != 0 || bytes % 4 != 0) misuse("Commands::fill takes whole words");
    if (buffer_ == VK_NULL_HANDLE) return;
    device_.table().vkCmdFillBuffer(buffer_, buffer.handle, buffer.offset + offset, bytes, word);
}

void Recorder::write(const Slice& buffer, VkDeviceSize offset, std::span<const std::byte> bytes) {
    constexpr std::size_t max_at_once = 65536;
    expect_open("write");
    if (offset > buffer.size || bytes.size() > buffer.size - offset)
        misuse("Commands::write beyond the end of a buffer");
    if (buffer_ == VK_NULL_HANDLE) return;
    for (std::size_t done = 0; done < bytes.size(); done += max_at_once) {
        const auto piece = bytes.subspan(done, std::min(max_at_once, bytes.size() - done));
        device_.table().vkCmdUpdateBuffer(buffer_, buffer.handle, buffer.offset + offset + done, piece.size(),
                                          piece.data());
    }
}

VkDescriptorBufferInfo Recorder::descriptor(const Pass& pass, std::uint32_t binding,
                                            std::span<const BufferBinding> buffers) const {
    const auto wrong = [&](const std::string& what) {
        misuse("binding " + std::to_string(binding) + " of the pass " + pass.name() + what);
    };
    const auto it = std::find_if(buffers.begin(), buffers.end(), [&](const auto& b) { return b.binding == binding; });
    if (it == buffers.end() || !it->slice) wrong(" has no buffer");
    const VkPhysicalDeviceLimits& limits = device_.adapter().limits;
    const VkDeviceSize size = it->slice.size;
    if (it->offset > size) wrong(" begins beyond the end of its buffer");
    const VkDeviceSize rest = size - it->offset;
    const VkDeviceSize bytes = it->bytes == VK_WHOLE_SIZE ? rest : it->bytes;
    if (bytes > rest) wrong(" goes beyond the end of its buffer");
    if ((it->slice.offset + it->offset) % std::max<VkDeviceSize>(limits.minStorageBufferOffsetAlignment, 1) != 0) {
        wrong(" begins at an offset that the device cannot bind");
    }
    if (bytes == 0) return {it->slice.handle, it->slice.offset, 16};  // Vulkan has no empty range; shaders check bounds
    const VkDeviceSize whole_words = round_up(bytes, 4);
    if (whole_words > limits.maxStorageBufferRange) {
        wrong(" is larger than the device can bind: " + std::to_string(whole_words) + " bytes of " +
              std::to_string(limits.maxStorageBufferRange));
    }
    return {it->slice.handle, it->slice.offset + it->offset, whole_words};
}

void Recorder::bind(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push) {
    expect_open("dispatch");
    if (push.size() != pass.push_bytes()) {
        misuse("the pass " + pass.name() + " takes " + std::to_string(pass.push_bytes()) +
               " bytes of push constants, not " + std::to_string(push.size()));
    }
    const std::size_t count = pass.bindings().size();
    std::array<VkDescriptorBufferInfo, MAX_BINDINGS> infos;
    if (count > infos.size()) misuse("the pass " + pass.name() + " has too many bindings");
    for (std::size_t i = 0; i < count; ++i) infos[i] = descriptor(pass, pass.bindings()[i], buffers);
    const VkDescriptorSet set = count == 0 ? VK_NULL_HANDLE : sets_.get(pass, std::span(infos).first(count));
    if (buffer_ == VK_NULL_HANDLE) return;
    const VolkDeviceTable& table = device_.table();
    table.vkCmdBindPipeline(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pass.pipeline());
    if (!push.empty()) {
        table.vkCmdPushConstants(buffer_, pass.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, pass.push_bytes(),
                                 push.data());
    }
    if (count > 0)
        table.vkCmdBindDescriptorSets(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pass.layout(), 0, 1, &set, 0, nullptr);
}

void Recorder::dispatch(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push,
                        std::uint64_t invocations) {
    const auto [x, y, z] = group_counts(invocations, pass.local_size(), device_.adapter().limits);
    if (x == 0) return;
    bind(pass, buffers, push);
    if (buffer_ != VK_NULL_HANDLE) device_.table().vkCmdDispatch(buffer_, x, y, z);
}

void Recorder::dispatch_indirect(const Pass& pass, std::span<const BufferBinding> buffers,
                                 std::span<const std::byte> push, const Slice& args, VkDeviceSize offset) {
    if (offset % 4 != 0 || offset > args.size || args.size - offset < sizeof(VkDispatchIndirectCommand)) {
        misuse("the arguments of the indirect pass " + pass.name() + " are not in their buffer");
    }
    bind(pass, buffers, push);
    if (buffer_ != VK_NULL_HANDLE) device_.table().vkCmdDispatchIndirect(buffer_, args.handle, args.offset + offset);
}

void Recorder::memory_barrier(VkAccessFlags to, VkPipelineStageFlags stages) {
    if (buffer_ == VK_NULL_HANDLE) return;
    auto all = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    all.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    all.dstAccessMask = to;
    device_.table().vkCmdPipelineBarrier(buffer_, work, stages, 0, 1, &all, 0, nullptr, 0, nullptr);
}

void Recorder::barrier() {
    expect_open("barrier");
    memory_barrier(VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                       VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT,
                   work | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT);
}

void Recorder::barrier_to_host() {
    expect_open("barrier_to_host");
    memory_barrier(VK_ACCESS_HOST_READ_BIT, VK_PIPELINE_STAGE_HOST_BIT);
}

void Recorder::barrier_to_all() {
    expect_open("barrier_to_all");
    memory_barrier(VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
}

void Recorder::write_timestamp(VkQueryPool pool, std::uint32_t query) {
    expect_open("timestamp");
    if (buffer_ == VK_NULL_HANDLE) return;
    device_.table().vkCmdWriteTimestamp(buffer_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool, query);
}

Recorder::Label::Label(Recorder& recorder, const char* text) : recorder_(recorder) {
    recorder.expect_open("label");
    if (recorder.buffer_ == VK_NULL_HANDLE || !recorder.device_.instance().debug_utils()) return;
    auto label = structure<VkDebugUtilsLabelEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
    label.pLabelName = text;
    recorder.device_.instance().calls().vkCmdBeginDebugUtilsLabelEXT(recorder.buffer_, &label);
}

Recorder::Label::~Label() {
    if (!recorder_.open_ || recorder_.buffer_ == VK_NULL_HANDLE || !recorder_.device_.instance().debug_utils()) return;
    recorder_.device_.instance().calls().vkCmdEndDebugUtilsLabelEXT(recorder_.buffer_);
}

}  // namespace votess::gpu::vulkan
