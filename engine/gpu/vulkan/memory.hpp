// Buffers in sub-allocated device memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu::vulkan {

enum class MemoryKind {
    device,    // fast for shaders; mapped only where host and device share their memory
    upload,    // the host writes from front to back, the device reads
    download,  // the device writes, the host reads; cached where there is such memory
};

class Memory;
struct MemoryBlock;

// A part of a VkBuffer, not owned.
struct Slice {
    VkBuffer handle = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
    VkDeviceSize size = 0;
    [[nodiscard]] explicit operator bool() const { return handle != VK_NULL_HANDLE; }
};

// A buffer for shaders, vertices, copies and indirect dispatch, with its memory. Its Memory must outlive it.
class Buffer {
public:
    Buffer() = default;
    Buffer(Buffer&& other) noexcept;
    Buffer& operator=(Buffer&& other) noexcept;
    ~Buffer();

    [[nodiscard]] VkBuffer handle() const { return handle_; }
    // Returns the requested size. The VkBuffer is at least as large, and a multiple of 16 bytes.
    [[nodiscard]] VkDeviceSize size() const { return size_; }
    [[nodiscard]] explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
    [[nodiscard]] operator Slice() const { return {handle_, 0, size_}; }

    // Returns the bytes as the host sees them, valid as long as the buffer; empty when it cannot see them.
    [[nodiscard]] std::span<std::byte> mapped() const { return mapped_; }
    // The same as an array of T; a rest shorter than a T is dropped.
    template <class T>
    [[nodiscard]] std::span<T> as() const {
        return {reinterpret_cast<T*>(mapped_.data()), mapped_.size() / sizeof(T)};
    }
    // Call flush() between the host's writes and submit, invalidate() between the wait and the host's reads. They do
    // nothing where memory is coherent.
    void flush() const;
    void invalidate(VkDeviceSize bytes = VK_WHOLE_SIZE) const;  // from the front

private:
    friend class Memory;
    [[nodiscard]] VkMappedMemoryRange range() const;

    Memory* memory_ = nullptr;
    MemoryBlock* block_ = nullptr;
    VkBuffer handle_ = VK_NULL_HANDLE;
    VkDeviceSize size_ = 0;
    VkDeviceSize offset_ = 0;    // in the block
    VkDeviceSize reserved_ = 0;  // bytes reserved in the block
    std::span<std::byte> mapped_;
};

// Allocates memory from the device in blocks and gives parts of them to buffers. One thread at a time may make and
// destroy buffers of a Memory; any thread may use them. The device must outlive it.
class Memory {
public:
    static constexpr VkDeviceSize default_block_bytes = VkDeviceSize{64} << 20;

    // A buffer above half of `block_bytes` gets a block of its own. Empty blocks are freed at once.
    explicit Memory(Device& device, VkDeviceSize block_bytes = default_block_bytes);
    ~Memory();
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    // Throws `out_of_memory`: above the device's limits, or no memory left. 0 bytes make a valid buffer.
    [[nodiscard]] Buffer buffer(VkDeviceSize bytes, MemoryKind kind, const char* name = nullptr);
    // Returns the size of the largest buffer that buffer() tries to make.
    [[nodiscard]] VkDeviceSize max_buffer_bytes() const;

    // Bytes in use by buffers now, and at most so far; bytes of the blocks now.
    [[nodiscard]] VkDeviceSize used_bytes() const { return used_; }
    [[nodiscard]] VkDeviceSize peak_bytes() const { return peak_; }
    [[nodiscard]] VkDeviceSize block_bytes() const { return reserved_; }
    [[nodiscard]] std::size_t block_count() const { return blocks_.size(); }

private:
    friend class Buffer;
    struct Place {
        MemoryBlock* block;
        VkDeviceSize offset;
        VkDeviceSize bytes;
    };
    [[nodiscard]] Place allocate(const VkMemoryRequirements& needs, MemoryKind kind);
    [[nodiscard]] MemoryBlock* new_block(std::uint32_t type, MemoryKind kind,
                                         VkDeviceSize bytes);  // null: out of memory
    [[nodiscard]] std::vector<std::uint32_t> candidate_types(std::uint32_t allowed, MemoryKind kind) const;
    void release(const Place& place) noexcept;
    void destroy(Buffer& buffer) noexcept;

    Device& device_;
    VkDeviceSize preferred_block_;
    std::vector<std::unique_ptr<MemoryBlock>> blocks_;
    VkDeviceSize used_ = 0;
    VkDeviceSize peak_ = 0;
    VkDeviceSize reserved_ = 0;
};

}  // namespace votess::gpu::vulkan
