// Memory for the arrays of the passes: buffers of their own, or parts of one buffer of a host.
#pragma once

#include <algorithm>
#include <vector>

#include "core/arithmetic.hpp"
#include "gpu/vulkan/memory.hpp"

namespace votess::gpu {

using vulkan::Slice;

class Workspace {
public:
    virtual ~Workspace() = default;
    [[nodiscard]] virtual Slice take(VkDeviceSize bytes, const char* name) = 0;
    [[nodiscard]] Slice take_words(VkDeviceSize words, const char* name) { return take(4 * words, name); }
};

class OwnBuffers final : public Workspace {
public:
    explicit OwnBuffers(vulkan::Memory& memory) : memory_(memory) {}
    [[nodiscard]] Slice take(VkDeviceSize bytes, const char* name) override {
        return buffers_.emplace_back(memory_.buffer(bytes, vulkan::MemoryKind::device, name));
    }
    void clear() { buffers_.clear(); }

private:
    vulkan::Memory& memory_;
    std::vector<vulkan::Buffer> buffers_;
};

// Places arrays from `offset` on; without a buffer it only counts.
class PartOfBuffer final : public Workspace {
public:
    PartOfBuffer(const vulkan::Device& device, VkBuffer buffer, VkDeviceSize offset)
        : alignment_(std::max<VkDeviceSize>(device.adapter().limits.minStorageBufferOffsetAlignment, 16)),
          buffer_(buffer),
          begin_(offset),
          end_(offset) {}
    [[nodiscard]] Slice take(VkDeviceSize bytes, const char*) override {
        const Slice slice{buffer_, end_, bytes};
        // An empty array is bound as 16 bytes.
        end_ += round_up(std::max<VkDeviceSize>(bytes, 16), alignment_);
        largest_ = std::max(largest_, bytes);
        return slice;
    }
    [[nodiscard]] VkDeviceSize bytes() const { return end_ - begin_; }
    [[nodiscard]] VkDeviceSize largest() const { return largest_; }

private:
    VkDeviceSize alignment_;
    VkBuffer buffer_;
    VkDeviceSize begin_, end_;
    VkDeviceSize largest_ = 0;
};

}  // namespace votess::gpu
