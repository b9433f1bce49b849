// Frames whose points and rows lie in device memory that another API maps, such as CUDA. A timeline semaphore orders
// both.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/thread_pool.hpp"
#include "gpu/frames/frame_buffers.hpp"
#include "gpu/frames/gradients.hpp"
#include "gpu/seeds/device_seeds.hpp"
#include "gpu/vulkan/commands.hpp"
#include "gpu/vulkan/workspace.hpp"
#include "votess/vulkan.hpp"

namespace votess::gpu {

using Uuid = std::array<std::uint8_t, VK_UUID_SIZE>;

// One call at a time.
class ExportedFrames {
public:
    // uuid: of the device, which exports memory. options: points are packed. Throws as Plan(), and `unsupported`.
    // gradients: whether there is submit_vjp().
    ExportedFrames(const Uuid& uuid, const votess::vulkan::PlanOptions& options, const Want& want, unsigned threads,
                   bool gradients);
    ~ExportedFrames();
    ExportedFrames(const ExportedFrames&) = delete;
    ExportedFrames& operator=(const ExportedFrames&) = delete;

    [[nodiscard]] const std::shared_ptr<vulkan::Device>& device() const { return device_; }
    [[nodiscard]] const votess::vulkan::Plan& plan() const { return plan_; }
    // Returns where the arrays are, with new descriptors; who imports one owns it.
    [[nodiscard]] detail::ExportedArrays arrays();

    // Submits a frame of `count` points. It begins when the semaphore has the value `after`, and sets it to `done`.
    // Waits only when two frames are pending already.
    void submit(std::uint32_t count, std::uint64_t after, std::uint64_t done);
    [[nodiscard]] bool has_gradients() const { return gradients_.has_value(); }
    // Submits the gradient for the points of the last frame. given: the vectors that are written to the memory.
    void submit_vjp(const Want& given, std::uint64_t after, std::uint64_t done);
    // The host's part in the order: sets the semaphore's value, or waits for it.
    void signal(std::uint64_t value);
    void wait(std::uint64_t value);
    // Makes the unresolved cells of the last frame on the CPU, and writes all arrays again. Waits for the frame.
    // Nothing else may use the memory meanwhile. Returns how many cells that were.
    std::size_t resolve();

private:
    // The exported buffer and the semaphore.
    struct Shared {
        vulkan::Device& device;
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkSemaphore semaphore = VK_NULL_HANDLE;
        ~Shared();
    };

    [[nodiscard]] Slice exported(std::uint64_t place, VkDeviceSize bytes) const {
        return {shared_.buffer, place, bytes};
    }
    void make_shared();
    void make_passes();
    void take(vulkan::Commands& commands, bool here) const;
    void record_order(vulkan::Commands& commands, std::uint32_t count) const;
    template <class Record>
    void submit_recorded(std::uint64_t after, std::uint64_t done, const Record& record);
    void batch(std::uint64_t wait_value, std::uint64_t signal_value);
    void run_now(vulkan::Commands& commands);
    template <class Real>
    std::size_t resolve_as();

    std::shared_ptr<vulkan::Device> device_;
    votess::vulkan::Plan plan_;
    Want want_;
    ThreadPool pool_;
    detail::ExportedArrays arrays_;  // without descriptors
    Shared shared_;
    vulkan::Memory memory_;
    OwnBuffers scratch_;
    std::optional<FrameBuffers> buffers_;
    std::optional<Gradients> gradients_;
    Slice slopes_;
    Scan scan_;
    std::vector<vulkan::Pass> passes_;  // order_cells, order_rows
    std::array<std::unique_ptr<vulkan::Commands>, 2> flights_;
    std::size_t next_flight_ = 0;
    std::uint32_t count_ = 0;
    bool has_run_ = false;
};

}  // namespace votess::gpu
