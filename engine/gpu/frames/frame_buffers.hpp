// The buffers that a frame writes, in memory of votess.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gpu/frames/gather_rows.hpp"
#include "gpu/vulkan/commands.hpp"
#include "votess/vulkan.hpp"

namespace votess::gpu {

class FrameBuffers {
public:
    enum Array : std::uint8_t { header, cells, indices, geometry, areas, shifts };

    // seeds, weights: where the frame reads them.
    FrameBuffers(vulkan::Memory& memory, const votess::vulkan::Plan& plan, const votess::vulkan::BufferRange& seeds,
                 const votess::vulkan::BufferRange& weights);

    [[nodiscard]] const votess::vulkan::Frame& frame() const { return frame_; }
    [[nodiscard]] const vulkan::Buffer& operator[](Array array) const { return made_[array].written; }
    // Records the copies of arrays that the host does not see. Call invalidate() after the wait, before seen().
    void record_copies(vulkan::Commands& commands) const;
    void invalidate() const;
    // Returns the arrays of `count` cells as the host sees them.
    [[nodiscard]] FrameArrays seen(std::span<const double> seeds, std::size_t count) const;

private:
    // copy: empty where the host sees `written`, or the array was not requested.
    struct Made {
        vulkan::Buffer written, copy;
        [[nodiscard]] const vulkan::Buffer& seen() const { return copy ? copy : written; }
    };

    vulkan::Buffer workspace_, kept_;
    std::array<Made, 6> made_;
    votess::vulkan::Frame frame_;
};

}  // namespace votess::gpu
