// The seeds of a periodic domain with the images around it, as one part. The passes see a larger box with walls. Cells
// that need seeds from beyond it are left to the exact clipper.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/thread_pool.hpp"
#include "gpu/domain/device_domain.hpp"
#include "gpu/domain/parts.hpp"

namespace votess::gpu {

struct PeriodicPart {
    Part part;
    Box box;                                 // of seeds and images, in the units of length given
    std::vector<std::uint64_t> coordinates;  // 3 for each member: in units, modulo 2^64
    std::vector<std::array<std::int8_t, 3>>
        shifts;                                // by member: shift of the image from its seed's place in the domain
    bool lossy = false;                        // some coordinates were rounded down
    std::vector<std::array<double, 3>> wraps;  // by seed: translation into the domain; empty when none is moved
    // By seed: shift from there into the reduced cell, which rows do not count; empty when none is moved.
    std::vector<std::array<std::int8_t, 3>> moves;
};

// Returns nothing when the range holds more than `max_seeds`, or shifts are too large for rows.
std::optional<PeriodicPart> periodic_part(const Job& job, const ImageRange& range, std::uint32_t max_seeds,
                                          ThreadPool& pool);

}  // namespace votess::gpu
