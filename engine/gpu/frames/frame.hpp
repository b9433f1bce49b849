// votess::vulkan::Plan and Frame: all stages, recorded into a host's command buffer, on its buffers.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "gpu/cells/device_cells.hpp"
#include "gpu/frames/kept_frames.hpp"
#include "votess/vulkan.hpp"

namespace votess::vulkan::detail {

struct PlanState {
    std::shared_ptr<gpu::vulkan::Device> device;
    PlanOptions options;
    std::optional<gpu::Passes> passes;
    std::uint32_t chunk_cells = 0;
    std::uint32_t entries = 0;          // of the rows
    std::uint32_t images = 0;           // places for images
    std::vector<gpu::WallPlane> walls;  // of any direction
    Box box_of_walls;                   // the device's box where there are walls
    BufferSizes sizes;
};

struct FrameState {
    FrameState(std::shared_ptr<const PlanState> of, const Buffers& buffers);

    void record(VkCommandBuffer commands, const RecordOptions& options);

    std::shared_ptr<const PlanState> plan;

    [[nodiscard]] const gpu::DeviceSeeds& seeds() const { return seeds_; }

private:
    void record_stages(const RecordOptions& options);
    void record_upload(const RecordOptions& options);
    void record_cells(std::uint32_t count);
    void record_kept_cells(const RecordOptions& options);
    void record_download(const gpu::ChunkJob& job, std::uint32_t first, std::uint32_t cells);
    [[nodiscard]] gpu::ChunkJob chunk_job(std::uint32_t count) const;

    gpu::DeviceSeeds seeds_;
    gpu::DeviceCells cells_;
    gpu::KeptFrames kept_;
    gpu::Slice raw_, weights_, header_;
    gpu::Bindings outputs_;
    gpu::Recorder recorder_;
};

// Makes plans on devices of votess, and shows what they hold.
struct PlanAccess {
    [[nodiscard]] static Plan plan(std::shared_ptr<gpu::vulkan::Device> device, const PlanOptions& options);
    [[nodiscard]] static const gpu::Passes& passes(const Plan& plan) { return *plan.state_->passes; }
    [[nodiscard]] static gpu::vulkan::Device& device(const Plan& plan) { return *plan.state_->device; }
    // Returns the seeds of the frame's last recording.
    [[nodiscard]] static const gpu::DeviceSeeds& seeds(const Frame& frame) { return frame.state_->seeds(); }
};

// Returns whether a cell waits for resolve(). status: CellStatus.
[[nodiscard]] bool is_unresolved(std::uint32_t status);

// The domain of recorded frames: box, images, weights and walls of a plan (frame_domain.cpp).

inline constexpr std::uint32_t max_of_all = 1u << 27;  // seeds: entries of rows have 32 bits

[[nodiscard]] inline bool is_periodic(const PlanOptions& options) {
    return options.cell || options.periodic != std::array<bool, 3>{};
}

// Throws as Plan() does, or as Frame::record() does for a recording's box or cell.
void check_domain(const PlanOptions& options);
void check_domain(const PlanOptions& options, const RecordOptions& of_frame);

// Returns the number of places for the images of a periodic plan.
[[nodiscard]] std::uint32_t usual_images(const PlanOptions& options);
// Makes the walls of the plan for the device.
void make_walls(PlanState& plan);
// Sets box, images and weights of the seeds for a recording. Allocates nothing. Throws `unsupported` as Frame::record()
// does.
void set_domain(gpu::DeviceSeeds& seeds, const PlanState& plan, const RecordOptions& of_frame);

}  // namespace votess::vulkan::detail
