#include "gpu/vulkan/memory.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/arithmetic.hpp"
#include "input/option_name.hpp"

namespace votess::gpu::vulkan {

// One VkDeviceMemory. `gaps` are its free ranges, offset to size; neighbors are merged.
struct MemoryBlock {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    std::uint32_t type = 0;
    MemoryKind kind = MemoryKind::device;
    VkDeviceSize bytes = 0;
    bool coherent = true;
    std::byte* host = nullptr;
    std::map<VkDeviceSize, VkDeviceSize> gaps;
};

namespace {

constexpr VkDeviceSize no_room = ~VkDeviceSize{0};

// Takes the first gap that fits; returns the offset, or no_room.
VkDeviceSize take(MemoryBlock& block, VkDeviceSize bytes, VkDeviceSize alignment) {
    for (auto gap = block.gaps.begin(); gap != block.gaps.end(); ++gap) {
        const auto [start, size] = *gap;
        const VkDeviceSize offset = round_up(start, alignment);
        if (offset - start > size || size - (offset - start) < bytes) continue;
        const VkDeviceSize rest = size - (offset - start) - bytes;
        if (rest > 0) block.gaps.emplace_hint(std::next(gap), offset + bytes, rest);
        if (offset > start) {
            gap->second = offset - start;
        } else {
            block.gaps.erase(gap);
        }
        return offset;
    }
    return no_room;
}

void give_back(MemoryBlock& block, VkDeviceSize offset, VkDeviceSize bytes) {
    const auto [gap, inserted] = block.gaps.emplace(offset, bytes);
    if (const auto next = std::next(gap); next != block.gaps.end() && offset + bytes == next->first) {
        gap->second += next->second;
        block.gaps.erase(next);
    }
    if (gap == block.gaps.begin()) return;
    if (const auto before = std::prev(gap); before->first + before->second == offset) {
        before->second += gap->second;
        block.gaps.erase(gap);
    }
}

// Ranks a type of memory: lower is better, negative is unusable.
int rank(VkMemoryPropertyFlags flags, MemoryKind kind, bool unified) {
    constexpr VkMemoryPropertyFlags known = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                            VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    if (flags & ~known) return -1;  // protected, lazily allocated, uncached for debugging ...
    const bool local = flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    const bool visible = flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
    const bool coherent = flags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const bool cached = flags & VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    if (kind == MemoryKind::device) return (local ? 0 : 8) + (visible == unified ? 0 : 4) + (unified && !coherent);
    if (!visible) return -1;
    // The host's window into the memory of a discrete device is small and slow to read: avoid it.
    const int window = local && !unified;
    if (kind == MemoryKind::upload) return (coherent ? 0 : 8) + 4 * window + (cached && !unified);
    return (cached ? 0 : 8) + 4 * window + (coherent ? 0 : 2);
}

}  // namespace

Buffer::Buffer(Buffer&& other) noexcept {
    *this = std::move(other);
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
    if (this == &other) return *this;
    if (memory_) memory_->destroy(*this);
    memory_ = std::exchange(other.memory_, nullptr);
    block_ = std::exchange(other.block_, nullptr);
    handle_ = std::exchange(other.handle_, VK_NULL_HANDLE);
    size_ = std::exchange(other.size_, 0);
    offset_ = std::exchange(other.offset_, 0);
    reserved_ = std::exchange(other.reserved_, 0);
    mapped_ = std::exchange(other.mapped_, {});
    return *this;
}

Buffer::~Buffer() {
    if (memory_) memory_->destroy(*this);
}

VkMappedMemoryRange Buffer::range() const {
    auto range = structure<VkMappedMemoryRange>(VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE);
    range.memory = block_->memory;
    range.offset = offset_;
    range.size = reserved_;
    return range;
}

void Buffer::flush() const {
    if (mapped_.empty() || block_->coherent) return;
    const VkMappedMemoryRange whole = range();
    Device& device = memory_->device_;
    check(device.table().vkFlushMappedMemoryRanges(device.handle(), 1, &whole), "vkFlushMappedMemoryRanges");
}

void Buffer::invalidate(VkDeviceSize bytes) const {
    if (mapped_.empty() || block_->coherent || bytes == 0) return;
    Device& device = memory_->device_;
    VkMappedMemoryRange part = range();
    const VkDeviceSize atom = std::max<VkDeviceSize>(device.adapter().limits.nonCoherentAtomSize, 1);
    if (bytes < part.size) part.size = round_up(bytes, atom);  // the size of the buffer's memory is a multiple too
    check(device.table().vkInvalidateMappedMemoryRanges(device.handle(), 1, &part), "vkInvalidateMappedMemoryRanges");
}

Memory::Memory(Device& device, VkDeviceSize block_bytes)
    : device_(device), preferred_block_(std::min(block_bytes, device.adapter().max_allocation)) {}

Memory::~Memory() {
    for (const auto& block : blocks_) device_.table().vkFreeMemory(device_.handle(), block->memory, nullptr);
}

VkDeviceSize Memory::max_buffer_bytes() const {
    return device_.adapter().max_buffer / 16 * 16;
}

std::vector<std::uint32_t> Memory::candidate_types(std::uint32_t allowed, MemoryKind kind) const {
    const Adapter& adapter = device_.adapter();
    std::vector<std::pair<int, std::uint32_t>> ranked;
    for (std::uint32_t type = 0; type < adapter.memory.memoryTypeCount; ++type) {
        if (!(allowed >> type & 1)) continue;
        const int r = rank(adapter.memory.memoryTypes[type].propertyFlags, kind, adapter.unified());
        if (r >= 0) ranked.emplace_back(r, type);
    }
    std::sort(ranked.begin(), ranked.end());
    // Shaders would be slower across the bus than with smaller chunks of work: fail instead.
    const bool has_fast = !ranked.empty() && ranked.front().first < 8;
    std::vector<std::uint32_t> types;
    for (const auto& [r, type] : ranked) {
        if (kind != MemoryKind::device || r < 8 || !has_fast) types.push_back(type);
    }
    return types;
}

MemoryBlock* Memory::new_block(std::uint32_t type, MemoryKind kind, VkDeviceSize bytes) {
    const Adapter& adapter = device_.adapter();
    const VkMemoryPropertyFlags flags = adapter.memory.memoryTypes[type].propertyFlags;
    auto block = std::make_unique<MemoryBlock>();
    block->type = type;
    block->kind = kind;
    block->bytes = bytes;
    block->coherent = flags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    block->gaps.emplace(0, bytes);
    blocks_.reserve(blocks_.size() + 1);  // nothing may throw once there is memory

    VolkDeviceTable& table = device_.table();
    auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    info.allocationSize = bytes;
    info.memoryTypeIndex = type;
    VkResult result = table.vkAllocateMemory(device_.handle(), &info, nullptr, &block->memory);
    const char* call = "vkAllocateMemory";
    const bool map = (flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) && (kind != MemoryKind::device || adapter.unified());
    if (result == VK_SUCCESS && map) {
        void* host = nullptr;
        result = table.vkMapMemory(device_.handle(), block->memory, 0, VK_WHOLE_SIZE, 0, &host);
        call = "vkMapMemory";
        block->host = static_cast<std::byte*>(host);
        if (result != VK_SUCCESS) table.vkFreeMemory(device_.handle(), block->memory, nullptr);
    }
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        case VK_ERROR_TOO_MANY_OBJECTS:
        case VK_ERROR_MEMORY_MAP_FAILED:
            return nullptr;
        default:
            check(result, call);
    }
    reserved_ += bytes;
    return blocks_.emplace_back(std::move(block)).get();
}

Memory::Place Memory::allocate(const VkMemoryRequirements& needs, MemoryKind kind) {
    // Flushing a buffer touches whole atoms of memory, which must be its own.
    const VkDeviceSize atom = std::max<VkDeviceSize>(device_.adapter().limits.nonCoherentAtomSize, 1);
    const VkDeviceSize bytes = round_up(needs.size, atom);
    const VkDeviceSize alignment = round_up(needs.alignment, atom);  // both are powers of two
    const bool own_block = bytes > preferred_block_ / 2;
    const auto candidates = candidate_types(needs.memoryTypeBits, kind);
    for (const std::uint32_t type : candidates) {
        for (const auto& block : blocks_) {
            if (own_block || block->type != type || block->kind != kind) continue;
            if (const VkDeviceSize offset = take(*block, bytes, alignment); offset != no_room) {
                return {block.get(), offset, bytes};
            }
        }
        MemoryBlock* block = own_block ? nullptr : new_block(type, kind, preferred_block_);
        if (!block) block = new_block(type, kind, bytes);
        if (block) return {block, take(*block, bytes, alignment), bytes};
    }
    throw Error(ErrorCode::out_of_memory, "no memory for a buffer of " + bytes_text(bytes) + " on " +
                                              device_.adapter().name + ", where votess has " + bytes_text(reserved_) +
                                              " now; try a smaller " + option("chunk_size") + " or another device");
}

void Memory::release(const Place& place) noexcept {
    give_back(*place.block, place.offset, place.bytes);
    const auto& gaps = place.block->gaps;
    if (gaps.size() != 1 || gaps.begin()->second != place.block->bytes) return;
    reserved_ -= place.block->bytes;
    device_.table().vkFreeMemory(device_.handle(), place.block->memory, nullptr);
    std::erase_if(blocks_, [&](const auto& block) { return block.get() == place.block; });
}

Buffer Memory::buffer(VkDeviceSize bytes, MemoryKind kind, const char* name) {
    if (bytes > max_buffer_bytes()) {
        throw Error(ErrorCode::out_of_memory, "a buffer of " + std::to_string(bytes) + " bytes is above the limit of " +
                                                  device_.adapter().name + ", " + std::to_string(max_buffer_bytes()) +
                                                  " bytes; try a smaller " + option("chunk_size") +
                                                  " or another device");
    }
    Buffer buffer;
    buffer.memory_ = this;
    auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    info.size = round_up(std::max<VkDeviceSize>(bytes, 1), 16);
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                 VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
    VolkDeviceTable& table = device_.table();
    check(table.vkCreateBuffer(device_.handle(), &info, nullptr, &buffer.handle_), "vkCreateBuffer");
    device_.name(buffer.handle_, VK_OBJECT_TYPE_BUFFER, name);

    VkMemoryRequirements needs{};
    table.vkGetBufferMemoryRequirements(device_.handle(), buffer.handle_, &needs);
    const Place place = allocate(needs, kind);
    buffer.block_ = place.block;
    buffer.offset_ = place.offset;
    buffer.reserved_ = place.bytes;
    used_ += place.bytes;
    peak_ = std::max(peak_, used_);
    check(table.vkBindBufferMemory(device_.handle(), buffer.handle_, place.block->memory, place.offset),
          "vkBindBufferMemory");
    buffer.size_ = bytes;
    if (place.block->host) buffer.mapped_ = {place.block->host + place.offset, static_cast<std::size_t>(bytes)};
    return buffer;
}

void Memory::destroy(Buffer& buffer) noexcept {
    if (buffer.handle_) device_.table().vkDestroyBuffer(device_.handle(), buffer.handle_, nullptr);
    if (!buffer.block_) return;
    used_ -= buffer.reserved_;
    release({buffer.block_, buffer.offset_, buffer.reserved_});
}

}  // namespace votess::gpu::vulkan
