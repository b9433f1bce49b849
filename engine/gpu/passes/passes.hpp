// The compute pipelines of the engine, made for one device and one set of options.
#pragma once

#include <cstdint>
#include <memory>

#include "gpu/vulkan/pass.hpp"

namespace votess::gpu {

// These limits are one tier's of clip. With a subgroup per cell the first tier has SUBGROUP_PLANES planes. A cell that
// needs more goes to the next tier, in the end to the CPU.
struct TierLimits {
    std::uint32_t planes = 32;    // alive at once; a multiple of 32
    std::uint32_t vertices = 64;  // alive at once; a multiple of 32
    bool float64 = false;         // clips in float64
    bool ties = false;            // decides ties of small whole numbers; else the CPU does
    bool operator==(const TierLimits&) const = default;
};

struct PassSettings {
    std::uint32_t k = 112;  // neighbors listed
    TierLimits tiers[2];
    std::uint32_t max_visits = 4000;        // boxes looked at in a search
    std::uint32_t max_walk_visits = 20000;  // boxes looked at for a cell of the second tier, beyond its list
    bool measure = true;                    // volumes and centroids are wanted
    bool measure_float64 = true;            // they are float64, else sums of two float32
    bool areas = false;                     // areas beside the rows are wanted too
    bool weights = false;                   // of a power diagram
    bool frames = false;                    // there are passes for recorded frames instead of parts
    bool walls = false;                     // there are walls of any direction
    bool images = false;                    // and for periodic ones
    bool triclinic = false;                 // whose boxes are triclinic
    std::uint32_t local_size = 64;          // work-groups of all passes that do not rely on a size
    // So many invocations make a cell of the first tier together, searching as they clip; 0: each makes one, from a
    // list.
    std::uint32_t subgroup_size = 0;
    // A work-group has so many. With one, what is uniform in a subgroup is so in the work-group, and only there SPIR-V
    // promises that lanes are together again behind a branch that parted them.
    std::uint32_t subgroups = 1;
    std::uint32_t first_count = 48;  // seeds that the subgroup's first search aims at
    bool operator==(const PassSettings&) const = default;
};

// Settings that suit the device; k = 0 lists the usual number. Throws as kernel_from_environment() and
// measure_from_environment(), and `unsupported` for a kernel that the device cannot run and numbers that it lacks.
[[nodiscard]] PassSettings usual_settings(const vulkan::Device& device, std::uint32_t k);

struct Passes {
    Passes(vulkan::Device& device, const PassSettings& settings);
    // Makes those that decide ties.
    void make_with_ties(vulkan::Device& device);

    PassSettings settings;
    vulkan::Pass upload;
    vulkan::Pass sort_key, sort_count, sort_scatter, sort_crowded, sort_gather, scan_blocks, scan_add;
    vulkan::Pass knn_boxes, knn_search;
    vulkan::Pass clip_cells[2], clip_todo;            // clip_cells[0] searches too where subgroups make cells
    std::unique_ptr<vulkan::Pass> clip_with_ties[2];  // null until they are made
    vulkan::Pass download_rows, download_total;
    // Null: not wanted.
    std::unique_ptr<vulkan::Pass> download_named_rows, download_place, download_gather;
    std::unique_ptr<vulkan::Pass> download_cells, upload_weights, upload_walls, upload_wrap, upload_images;
};

}  // namespace votess::gpu
