// All stages recorded into a host's command buffer, on its buffers: votess::vulkan::Plan and Frame.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/device_cells.hpp"
#include "votess/vulkan.hpp"

namespace votess::vulkan::detail {

struct PlanState {
    std::shared_ptr<gpu::vulkan::Device> device;
    PlanOptions options;
    std::optional<gpu::Passes> passes;
    std::uint32_t chunk_cells = 0;
    std::uint32_t entries = 0;          // of the rows
    std::uint32_t images = 0;           // places for them
    std::vector<gpu::WallPlane> walls;  // of any direction
    Box box_of_walls;                   // the device's box where there are walls
    BufferSizes sizes;
};

struct FrameState {
    FrameState(std::shared_ptr<const PlanState> of, const Buffers& buffers);

    void record(VkCommandBuffer commands, const RecordOptions& options);

    std::shared_ptr<const PlanState> plan;

private:
    void record_stages(const RecordOptions& options);
    void record_upload(std::uint32_t count);
    void record_cells(std::uint32_t count);

    gpu::DeviceSeeds seeds_;
    gpu::DeviceCells cells_;
    gpu::Slice raw_, weights_, header_;
    gpu::Bindings outputs_;
    gpu::Recorder recorder_;
};

[[noreturn]] void refuse(const std::string& what);  // as invalid_argument

}  // namespace votess::vulkan::detail
