// The domain of recorded frames: box, images, weights and walls of a plan.
#pragma once

#include "gpu/frames/frame.hpp"

namespace votess::vulkan::detail {

inline constexpr std::uint32_t most_of_all = 1u << 27;  // seeds: rows have 32 bits for their entries

[[nodiscard]] inline bool is_periodic(const PlanOptions& options) {
    return options.cell || options.periodic != std::array<bool, 3>{};
}

// Throws as Plan() does; of a recording's box or cell, as Frame::record().
void check_domain(const PlanOptions& options);
void check_domain(const PlanOptions& options, const RecordOptions& of_frame);

// Places that will do for the images of a periodic plan.
[[nodiscard]] std::uint32_t usual_images(const PlanOptions& options);
// Finds the walls of the plan as a device has them.
void make_walls(PlanState& plan);
// Tells the seeds all but the walls, for a recording. Allocates nothing. Throws `unsupported` as Frame::record() does.
void set_domain(gpu::DeviceSeeds& seeds, const PlanState& plan, const RecordOptions& of_frame);

}  // namespace votess::vulkan::detail
