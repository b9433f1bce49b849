// The product of the derivatives of a frame's volumes, centroids and areas with given vectors, on the device.
#pragma once

#include <cstdint>

#include "gpu/vulkan/recorder.hpp"
#include "votess/vulkan.hpp"

namespace votess::gpu {

using vulkan::Slice;

// The cells of a frame in the order of the points, and the vectors. Numbers of points, centroids, their vectors and the
// gradient are those of the plan's format. Arrays that do not exist are empty.
struct GradientArrays {
    Slice points, status, indptr, indices, shifts, volumes, centroids;
    Slice given_volumes, given_centroids, given_areas;  // one for each number of the arrays
    Slice slopes;                                       // scratch, slope_bytes a point
    Slice gradient;  // 4 numbers for each of the plan's max_seeds: 3 by each point, then those by weights
};

// The pipelines, for a device with float64.
struct GradientPasses {
    // wide: whether points, centroids and their vectors are float64.
    GradientPasses(vulkan::Device& device, bool wide);
    vulkan::Pass cells, faces;

private:
    GradientPasses(vulkan::PassBatch&& batch, bool wide);
};

class Gradients {
public:
    static constexpr VkDeviceSize slope_bytes = 32;

    // Makes the pipelines. Throws invalid_argument for a plan without rows, `unsupported` for a device without float64.
    explicit Gradients(const votess::vulkan::Plan& plan);

    // Records the passes, with a barrier behind them. frame: its last recording was that of the points. Points without
    // a row that have a cell get NaN.
    void record(vulkan::Recorder& recorder, const votess::vulkan::Frame& frame, std::uint32_t count,
                const GradientArrays& arrays) const;

private:
    votess::vulkan::Plan plan_;
    GradientPasses passes_;
};

}  // namespace votess::gpu
