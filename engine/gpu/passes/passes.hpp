// The compute pipelines of the engine, made for one device and one set of options.
#pragma once

#include <cstdint>
#include <memory>

#include "gpu/vulkan/pass.hpp"

namespace votess::gpu {

// The limits of a tier of clip. Where a subgroup makes a cell it has SUBGROUP_PLANES planes, in float64 and in the
// second tier twice as many. A cell that needs more goes to the next tier, and from the second to the CPU.
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
    bool on_cpu = false;                   // the device is the CPU and the kernel is automatic
    std::uint32_t max_visits = 4000;       // boxes visited in a search for a list
    std::uint32_t max_walk_visits = 2000;  // boxes visited for a cell of the second tier, beyond its list
    std::uint32_t max_subgroup_visits[2] = {4000, 4000};  // boxes visited in a subgroup's searches for a cell, by tier
    bool measure = true;                                  // volumes and centroids are requested
    bool measure_float64 = true;                          // these are measured in float64, else in float32
    bool areas = false;                                   // areas of the rows are requested too
    bool weights = false;                                 // of a power diagram
    bool frames = false;                                  // the passes are for recorded frames, not for parts
    bool walls = false;                                   // there are walls of any direction
    bool images = false;                                  // recorded frames have images
    bool triclinic = false;                               // recorded frames have triclinic boxes
    bool follow = false;                                  // recorded frames keep cells
    std::uint32_t local_size = 64;                        // work-groups of all passes that do not rely on a size
    // Invocations of a subgroup, which make a cell of the first tier together and search as they clip; 0: an invocation
    // makes a cell from a list.
    std::uint32_t subgroup_size = 0;
    // Subgroups of a work-group. With one, a value that is uniform in the subgroup is uniform in the work-group; only
    // then does SPIR-V promise that lanes are together again behind a branch that parted them.
    std::uint32_t subgroups = 1;
    std::uint32_t first_count = 48;  // seeds that the first search of a subgroup aims at

    // Returns whether a second tier pays. It needs larger limits than the first. The CPU's own clipper is as fast as a
    // device that is the CPU, and half of the time of a first run is that of compiling the second tier. But frames
    // leave the cells to the host program.
    [[nodiscard]] bool has_second_tier() const {
        return (frames || !on_cpu) && (subgroup_size == 0 || !tiers[0].float64);
    }
    bool operator==(const PassSettings&) const = default;
};

// Returns settings that suit the device; k = 0 lists the usual number. Throws as kernel_from_environment() and
// measure_from_environment(), and `unsupported` for a kernel or numbers that the device lacks.
[[nodiscard]] PassSettings usual_settings(const vulkan::Device& device, std::uint32_t k);

struct Passes {
    Passes(vulkan::Device& device, const PassSettings& settings);  // makes their pipelines side by side
    // Makes the passes that decide ties.
    void make_with_ties(vulkan::Device& device);

    PassSettings settings;
    vulkan::Pass upload;
    vulkan::Pass sort_key, sort_count, sort_scatter, sort_crowded, sort_gather, scan_blocks, scan_add;
    vulkan::Pass knn_boxes;
    vulkan::Pass clip_first, clip_todo;  // clip_first searches too where subgroups make cells
    vulkan::Pass clip_second;            // none without a second tier
    struct {
        vulkan::Pass clip_first, clip_second;
    } with_ties;              // none until they are made
    vulkan::Pass knn_search;  // none where subgroups make cells
    vulkan::Pass download_rows, download_total;
    // None when not needed.
    vulkan::Pass download_named_rows, download_place, download_gather;
    vulkan::Pass download_cells, upload_weights, image_reach, upload_walls, upload_wrap, upload_images;
    // In their order in a frame; the first match comes with each round.
    vulkan::Pass kept_places, kept_recall, clip_kept, kept_match, kept_cover, kept_judge, kept_drop, kept_store;

private:
    Passes(vulkan::PassBatch&& batch, const PassSettings& settings);
    void make_optional(vulkan::PassBatch& batch);
};

}  // namespace votess::gpu
