// Position along a Hilbert curve through a cube of 1024^3 blocks, by tables of three levels of octants each.
#pragma once

#include <array>
#include <cstdint>

namespace votess::cpu {

inline constexpr int hilbert_levels = 10;

struct HilbertTables {
    static constexpr int orientations = 12;  // of the curve within its octants
    // Entries: the position among the 8 or 512 parts of an octant, plus 512 times the orientation within that part.
    std::array<std::uint16_t, 8> first;                     // one level, from the whole cube
    std::array<std::uint16_t, orientations * 512> deeper;   // three levels
    std::array<std::uint32_t, 1 << hilbert_levels> spread;  // bit i to bit 3i
};
extern const HilbertTables hilbert_tables;

// Returns 30 bits. Coordinates must be below 1024. Consecutive blocks along the curve share a face.
inline std::uint32_t hilbert_index(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    static_assert(hilbert_levels == 1 + 3 * 3);
    const auto& [first, deeper, spread] = hilbert_tables;
    const std::uint32_t octants = spread[x] << 2 | spread[y] << 1 | spread[z];
    std::uint32_t entry = first[octants >> 27];
    std::uint32_t index = entry % 512;
    for (int shift = 18; shift >= 0; shift -= 9) {
        entry = deeper[(entry & ~511u) | (octants >> shift & 511)];
        index = index << 9 | entry % 512;
    }
    return index;
}

}  // namespace votess::cpu
