// Puts the cells of a frame into the order of the points, on the host.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/thread_pool.hpp"
#include "result/frame_rows.hpp"
#include "votess/vulkan.hpp"

namespace votess::gpu {

// The buffers of a frame, see votess::vulkan::BufferSizes. Arrays that were not requested are empty.
struct FrameArrays {
    std::span<const double> seeds;
    std::span<const votess::vulkan::Cell> cells;  // as many as the frame has
    std::span<const std::int32_t> indices;
    std::span<const float> geometry, areas;
    std::span<const std::int8_t> shifts;
    std::size_t kept = 0;  // see Header
};

// Returns the cells. more: those that the CPU made instead. narrow: whether centroids are float32.
[[nodiscard]] detail::FrameRows gather_rows(const FrameArrays& frame, const votess::vulkan::Resolved& more,
                                            const Want& want, bool narrow, ThreadPool& pool);

// Returns the shifts as shaders read them: int8 x y z 0.
[[nodiscard]] std::vector<std::int8_t> padded_shifts(const detail::FrameRows& rows);

}  // namespace votess::gpu
