// The seeds of a periodic domain with their images around it, as one part: the passes then see a larger box with walls,
// and cells that would need seeds from beyond it are left to the exact clipper.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "gpu/domain/device_domain.hpp"
#include "gpu/domain/parts.hpp"

namespace votess::gpu {

struct PeriodicPart {
    Part part;
    Box box;                                         // of seeds and images, in the units of length given
    std::vector<std::uint64_t> coordinates;          // 3 for each member: in units, modulo 2^64
    std::vector<std::array<std::int8_t, 3>> shifts;  // by member: of the image, from where its seed lies in the domain
    bool lossy = false;                              // some coordinates have been rounded down
    std::vector<std::array<double, 3>> wraps;  // by seed: what carries it into the domain; empty when none is moved
    // By seed: from there into the cell where the device has it, which rows do not count; empty when none is moved.
    std::vector<std::array<std::int8_t, 3>> moves;
};

// Returns nothing when the range holds more than `max_seeds`, or shifts are too large for rows.
std::optional<PeriodicPart> periodic_part(const Job& job, const ImageRange& range, std::uint32_t max_seeds);

}  // namespace votess::gpu
