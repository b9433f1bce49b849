// A command buffer that is recorded, submitted and waited for, again and again.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/vulkan/memory.hpp"
#include "gpu/vulkan/pass.hpp"

namespace votess::gpu::vulkan {

struct BufferBinding {
    std::uint32_t binding = 0;
    const Buffer* buffer = nullptr;
    VkDeviceSize offset = 0;             // a multiple of minStorageBufferOffsetAlignment
    VkDeviceSize bytes = VK_WHOLE_SIZE;  // to the end; shaders see whole 32-bit words
};

// Work-groups for so many invocations, one number per axis: their product times local_size is at least `invocations`
// and little more. Shaders count groups as x + num.x * (y + num.y * z) and check bounds. {0, 0, 0} for 0 invocations.
[[nodiscard]] std::array<std::uint32_t, 3> group_counts(std::uint64_t invocations, std::uint32_t local_size,
                                                        const VkPhysicalDeviceLimits& limits);

// Its device must outlive it, and so must everything recorded, until the work is done. One thread at a time.
class Commands {
public:
    // Up to `timestamps` of them in one recording; 0 = none.
    explicit Commands(Device& device, std::uint32_t timestamps = 0);
    ~Commands();  // waits for submitted work
    Commands(const Commands&) = delete;
    Commands& operator=(const Commands&) = delete;

    void begin();  // waits for the previous submission and forgets its recording
    void end();

    // Offsets and sizes are in bytes; of fill, multiples of 4. 0 bytes record nothing.
    void copy(const Buffer& from, VkDeviceSize from_offset, const Buffer& to, VkDeviceSize to_offset,
              VkDeviceSize bytes);
    void fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize bytes, std::uint32_t word);

    // `buffers` may hold more bindings than the pass has: it picks its own. `push` has exactly push_bytes() bytes.
    // 0 invocations record nothing.
    void dispatch(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push,
                  std::uint64_t invocations);
    // The three group counts are a VkDispatchIndirectCommand in `args`.
    void dispatch_indirect(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push,
                           const Buffer& args, VkDeviceSize offset = 0);

    // What shaders and copies have written becomes visible to later shaders, copies and indirect dispatches.
    void barrier();
    // ... and to the host after the wait. Needed once before end() when the host is to read anything.
    void barrier_to_host();

    // Names what is recorded during its life, for tools; nothing without VK_EXT_debug_utils.
    class [[nodiscard]] Label {
    public:
        Label(Commands& commands, const char* text);
        ~Label();
        Label(const Label&) = delete;
        Label& operator=(const Label&) = delete;

    private:
        Commands& commands_;
    };
    [[nodiscard]] Label label(const char* text) { return Label(*this, text); }

    // Records the time at which all before it is done. The index is for seconds(); where timestamps are unsupported or
    // the pool is full it is `no_timestamp`.
    static constexpr std::uint32_t no_timestamp = UINT32_MAX;
    std::uint32_t timestamp();
    // Between two timestamps of the finished submission; 0 when one of them is no_timestamp.
    [[nodiscard]] double seconds(std::uint32_t from, std::uint32_t to) const;

    void submit();
    // True when nothing is running. Throws device_lost as the waits do.
    [[nodiscard]] bool finished();
    // Waits at most so long; whether it has finished.
    bool wait_for(std::chrono::nanoseconds timeout);
    void wait();

private:
    enum class State { idle, recording, ready, running };
    struct DescriptorPool {
        VkDescriptorPool handle;
        std::uint32_t max_sets, max_descriptors;
        std::uint32_t sets, descriptors;  // left
    };

    void expect(State state, const char* call) const;
    void make_objects(std::uint32_t timestamps);
    void destroy() noexcept;
    [[nodiscard]] VkDescriptorSet new_set(const Pass& pass);
    [[nodiscard]] DescriptorPool& pool_for(std::uint32_t descriptors);
    void bind(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push);
    [[nodiscard]] VkDescriptorBufferInfo descriptor(const Pass& pass, std::uint32_t binding,
                                                    std::span<const BufferBinding> buffers) const;

    Device& device_;
    State state_ = State::idle;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    std::vector<DescriptorPool> descriptor_pools_;
    VkQueryPool queries_ = VK_NULL_HANDLE;
    std::uint32_t query_capacity_ = 0;
    std::uint32_t query_count_ = 0;
};

// The bytes of a push-constant block.
template <class T>
[[nodiscard]] std::span<const std::byte> push_bytes(const T& block) {
    return std::as_bytes(std::span(&block, 1));
}

}  // namespace votess::gpu::vulkan
