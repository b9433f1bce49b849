// Frames whose points and rows lie in device memory that another API maps, such as CUDA. A timeline semaphore orders
// both.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/thread_pool.hpp"
#include "gpu/seeds/device_seeds.hpp"
#include "gpu/vulkan/commands.hpp"
#include "gpu/vulkan/workspace.hpp"
#include "votess/vulkan.hpp"

namespace votess::gpu {

using Uuid = std::array<std::uint8_t, VK_UUID_SIZE>;

// A device of votess that exports memory, and semaphores where it can.
class ExportingDevice {
public:
    // Takes the device with this UUID. Throws `unsupported` with the reason.
    explicit ExportingDevice(const Uuid& uuid);
    ~ExportingDevice();
    ExportingDevice(const ExportingDevice&) = delete;
    ExportingDevice& operator=(const ExportingDevice&) = delete;

    [[nodiscard]] const std::shared_ptr<vulkan::Device>& device() const { return device_; }
    [[nodiscard]] VkQueue queue() const { return queue_; }
    [[nodiscard]] bool exports_semaphores() const { return exports_semaphores_; }

private:
    void create(const vulkan::Adapter& adapter);

    std::shared_ptr<vulkan::Instance> instance_;
    PFN_vkDestroyDevice destroy_ = nullptr;
    VkDevice handle_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    bool exports_semaphores_ = false;
    std::shared_ptr<vulkan::Device> device_;
};

// One call at a time.
class ExportedFrames {
public:
    // Bytes from the start of the exported buffer to each array; `none` where it was not requested.
    static constexpr std::uint64_t none = ~std::uint64_t{0};
    struct Places {
        std::uint64_t points = none, weights = none, status = none, indptr = none, indices = none, shifts = none,
                      face_areas = none, volumes = none, centroids = none;
    };

    // options: points are packed. Throws as Plan() and ExportingDevice().
    ExportedFrames(const Uuid& uuid, const votess::vulkan::PlanOptions& options, const Want& want, unsigned threads);
    ~ExportedFrames();
    ExportedFrames(const ExportedFrames&) = delete;
    ExportedFrames& operator=(const ExportedFrames&) = delete;

    [[nodiscard]] const vulkan::Device& device() const { return *exporting_.device(); }
    [[nodiscard]] const votess::vulkan::Plan& plan() const { return plan_; }
    [[nodiscard]] const Places& places() const { return places_; }
    [[nodiscard]] std::uint64_t memory_bytes() const { return memory_bytes_; }
    // Return new descriptors; who imports one owns it. The semaphore's is -1 where the device cannot export it.
    [[nodiscard]] int memory_descriptor();
    [[nodiscard]] int semaphore_descriptor();

    // Submits a frame of `count` points. It begins when the semaphore has the value `after`, and sets it to `done`.
    // Waits only when two frames are pending already.
    void submit(std::uint32_t count, std::uint64_t after, std::uint64_t done);
    // The host's part in the order: sets the semaphore's value, or waits for it.
    void signal(std::uint64_t value);
    void wait(std::uint64_t value);
    // Makes the unresolved cells of the last frame on the CPU, and writes all arrays again. Waits for the frame.
    // Nothing else may use the memory meanwhile. Returns how many cells that were.
    std::size_t resolve();

private:
    struct Output {
        vulkan::Buffer written, copy;
        [[nodiscard]] const vulkan::Buffer& seen() const { return copy ? copy : written; }
    };
    [[nodiscard]] Output output(VkDeviceSize bytes, const char* name);
    [[nodiscard]] Slice exported(std::uint64_t place, VkDeviceSize bytes) const { return {shared_, place, bytes}; }
    void make_shared();
    void make_frame();
    void make_passes();
    void take(vulkan::Commands& commands, bool here) const;
    void record_order(vulkan::Commands& commands, std::uint32_t count) const;
    void batch(std::uint64_t wait_value, std::uint64_t signal_value);
    void run_now(vulkan::Commands& commands);
    void check_messages() const;
    template <class Real>
    std::size_t resolve_as();

    ExportingDevice exporting_;
    votess::vulkan::Plan plan_;
    Want want_;
    ThreadPool pool_;
    VkDeviceSize memory_bytes_ = 0;
    Places places_;
    VkDeviceMemory shared_memory_ = VK_NULL_HANDLE;
    VkBuffer shared_ = VK_NULL_HANDLE;
    VkSemaphore semaphore_ = VK_NULL_HANDLE;
    vulkan::Memory memory_;
    OwnBuffers scratch_;
    vulkan::Buffer workspace_;
    Output header_, cells_, indices_, geometry_, areas_, shifts_;
    votess::vulkan::Frame frame_;
    Scan scan_;
    std::vector<vulkan::Pass> passes_;  // order_cells, order_rows
    std::array<std::unique_ptr<vulkan::Commands>, 2> flights_;
    std::size_t next_flight_ = 0;
    std::uint32_t count_ = 0;
    bool has_run_ = false;
};

}  // namespace votess::gpu
