// Records passes, copies and barriers into a command buffer, and makes the descriptor sets for them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/vulkan/memory.hpp"
#include "gpu/vulkan/pass.hpp"

namespace votess::gpu::vulkan {

struct BufferBinding {
    std::uint32_t binding = 0;
    Slice slice;
    VkDeviceSize offset = 0;             // in the slice; both together a multiple of minStorageBufferOffsetAlignment
    VkDeviceSize bytes = VK_WHOLE_SIZE;  // to the end; shaders see whole 32-bit words

    BufferBinding() = default;
    BufferBinding(std::uint32_t number, const Slice& buffer) : binding(number), slice(buffer) {}
    BufferBinding(std::uint32_t number, const Buffer* buffer, VkDeviceSize from = 0, VkDeviceSize size = VK_WHOLE_SIZE)
        : binding(number), slice(buffer != nullptr ? Slice(*buffer) : Slice{}), offset(from), bytes(size) {}
};

// Returns the bytes of a push-constant block.
template <class T>
[[nodiscard]] std::span<const std::byte> push_bytes(const T& block) {
    return std::as_bytes(std::span(&block, 1));
}

// Returns numbers of work-groups along three axes. Their product times local_size is at least `invocations` and little
// more. Shaders count groups as x + num.x * (y + num.y * z) and check bounds. 0 invocations give {0, 0, 0}.
[[nodiscard]] std::array<std::uint32_t, 3> group_counts(std::uint64_t invocations, std::uint32_t local_size,
                                                        const VkPhysicalDeviceLimits& limits);

// Descriptor sets, found by what they bind: the same pass with the same buffers gets the same set.
class DescriptorSets {
public:
    explicit DescriptorSets(Device& device) : device_(device) {}
    ~DescriptorSets();
    DescriptorSets(const DescriptorSets&) = delete;
    DescriptorSets& operator=(const DescriptorSets&) = delete;

    // infos: one for each binding of the pass, in its order.
    [[nodiscard]] VkDescriptorSet get(const Pass& pass, std::span<const VkDescriptorBufferInfo> infos);
    // Drops all sets. None may be in use any more.
    void forget();

private:
    struct Pool {
        VkDescriptorPool handle;
        std::uint32_t max_sets, max_descriptors;
        std::uint32_t sets, descriptors;  // still free
    };
    struct Known {
        VkDescriptorSetLayout layout;
        VkDescriptorSet set;
        std::size_t first_info;  // in infos_
    };

    [[nodiscard]] Pool& pool_for(std::uint32_t descriptors);

    Device& device_;
    std::vector<Pool> pools_;
    std::vector<Known> known_;
    std::vector<VkDescriptorBufferInfo> infos_;
};

// Its device must outlive it, and everything recorded must last until the work is done. One thread at a time. Recording
// allocates nothing when the same passes were recorded with the same buffers before.
class Recorder {
public:
    explicit Recorder(Device& device) : device_(device), sets_(device) {}
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    // Calls between open() and close() record into `commands`; when it is null they only make their descriptor sets.
    void open(VkCommandBuffer commands);
    void close() { open_ = false; }

    // Offsets and sizes are in bytes, and multiples of 4 for fill and write. 0 bytes record nothing.
    void copy(const Slice& from, VkDeviceSize from_offset, const Slice& to, VkDeviceSize to_offset, VkDeviceSize bytes);
    void write(const Slice& buffer, VkDeviceSize offset, std::span<const std::byte> bytes);
    void fill(const Slice& buffer, VkDeviceSize offset, VkDeviceSize bytes, std::uint32_t word);

    // `buffers` may hold more bindings than the pass has. `push` has exactly push_bytes() bytes. 0 invocations record
    // nothing.
    void dispatch(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push,
                  std::uint64_t invocations);
    // The same with a barrier() behind it. buffers: has a list() of them.
    void run(const Pass& pass, const auto& buffers, const auto& push, std::uint64_t invocations) {
        dispatch(pass, buffers.list(), push_bytes(push), invocations);
        barrier();
    }
    // The three group counts are a VkDispatchIndirectCommand in `args`.
    void dispatch_indirect(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push,
                           const Slice& args, VkDeviceSize offset = 0);

    // Makes writes of shaders and copies visible to later shaders, copies and indirect dispatches.
    void barrier();
    // Makes them visible to the host after the wait. Needed once before end() when the host reads anything.
    void barrier_to_host();
    // Makes them visible to all later commands of any kind.
    void barrier_to_all();

    // Records the time at which all earlier commands are done.
    void write_timestamp(VkQueryPool pool, std::uint32_t query);

    // Names the commands recorded during its life, for tools. Does nothing without VK_EXT_debug_utils.
    class [[nodiscard]] Label {
    public:
        Label(Recorder& recorder, const char* text);
        ~Label();
        Label(const Label&) = delete;
        Label& operator=(const Label&) = delete;

    private:
        Recorder& recorder_;
    };
    [[nodiscard]] Label label(const char* text) { return Label(*this, text); }

protected:
    void expect_open(const char* call) const;
    [[nodiscard]] Device& device() const { return device_; }
    [[nodiscard]] DescriptorSets& descriptor_sets() { return sets_; }

private:
    void bind(const Pass& pass, std::span<const BufferBinding> buffers, std::span<const std::byte> push);
    [[nodiscard]] VkDescriptorBufferInfo descriptor(const Pass& pass, std::uint32_t binding,
                                                    std::span<const BufferBinding> buffers) const;
    void memory_barrier(VkAccessFlags to, VkPipelineStageFlags stages);

    Device& device_;
    DescriptorSets sets_;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE;
    bool open_ = false;
};

}  // namespace votess::gpu::vulkan
