// Two frames in flight. Each moves the seeds, has votess find their cells, and draws these, in one command buffer.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "buffers.hpp"
#include "drawing.hpp"
#include "moving.hpp"

namespace host {

// What votess wrote for one plan, read back.
struct Results {
    votess::vulkan::Header header{};
    std::vector<votess::vulkan::Cell> cells;
    std::vector<std::int32_t> indices;
    std::vector<float> geometry;  // empty where the plan has none
};

struct FrameOptions {
    std::uint32_t seeds = 0;
    std::uint32_t width = 0, height = 0;
    std::uint32_t samples = 1;
};

class Frames {
public:
    static constexpr std::uint32_t in_flight = 2;

    // The first of the plans is drawn.
    Frames(const HostDevice& device, std::span<const votess::vulkan::Plan> plans, const FrameOptions& options);
    ~Frames();  // waits for what is in flight
    Frames(const Frames&) = delete;
    Frames& operator=(const Frames&) = delete;

    // Frames go 0, 1, 2, ...; the one before the last must have been waited for.
    void submit(std::uint32_t frame);
    // The picture: 4 bytes a pixel, until the next submit().
    [[nodiscard]] std::span<const std::byte> wait_for(std::uint32_t frame);
    // Of a frame that was waited for.
    [[nodiscard]] std::vector<float> seeds(std::uint32_t frame) const;  // 4 a seed
    [[nodiscard]] Results results(std::uint32_t frame, std::size_t plan) const;
    // How it was seen, and the cell in each pixel plus 1; 0: none. The latter is drawn for this, from the same buffers.
    [[nodiscard]] DrawPush view(std::uint32_t frame) const;
    [[nodiscard]] std::vector<std::uint32_t> cells_seen(std::uint32_t frame) const;

private:
    // Of one plan in one frame.
    struct Cells {
        Buffer workspace;
        Buffer results;  // header, cells, indices, geometry, one behind the other
        votess::vulkan::Buffers ranges;
        votess::vulkan::Frame frame;
    };
    struct Slot {
        Buffer seeds;
        std::vector<Cells> cells;
        Target target;
        Buffer picture;
        VkDescriptorSet moving = VK_NULL_HANDLE, drawing = VK_NULL_HANDLE;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        Owned<VkFence> fence;
        bool pending = false;
    };
    [[nodiscard]] Cells make_cells(const votess::vulkan::Plan& plan, VkBuffer seeds) const;
    void record(const Slot& slot, std::uint32_t frame) const;

    const HostDevice& device_;
    std::span<const votess::vulkan::Plan> plans_;
    FrameOptions options_;
    Moving moving_;
    Drawing drawing_;
    Owned<VkCommandPool> pool_;
    std::array<Slot, in_flight> slots_;
};

}  // namespace host
