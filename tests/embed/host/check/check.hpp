// Whether the cells that a plan left in the host's buffers, filled in by resolve(), are those of the CPU engine, and
// whether the picture shows them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "frames.hpp"

namespace host {

struct Comparison {
    std::string difference;      // the first one in a line; empty: none
    double worst_volume = 0;     // relative error of a volume from the GPU
    std::uint32_t resolved = 0;  // cells by resolve()
};

// seeds: 4 numbers each. tolerance: of volumes from the GPU, relative, and of centroids in sizes of the cell.
[[nodiscard]] Comparison compare(const votess::vulkan::Plan& plan, std::span<const float> seeds, const Results& results,
                                 double tolerance);

// The cells in the pixels of a picture against the first solid ones on the rays through them, found by looking at all
// cells of the unit box. The first difference in a line; empty: none.
[[nodiscard]] std::string compare_picture(const DrawPush& view, std::uint32_t width, std::span<const float> seeds,
                                          const Results& results, std::span<const std::uint32_t> seen);

}  // namespace host
