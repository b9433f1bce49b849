// Cells that are vast beside the distances of their neighbors, as at the border of a domain without end. A measure that
// is exact to 1e-10 of their surface says nothing about the faces next to the seed.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

namespace votess::cpu {

constexpr double vast_surface = 0x1p16;  // times the squared distance of the farthest neighbor

// Whether a cell in a sphere around its seed is surely not vast, by any neighbor. Distances are squared. Its surface is
// at most that of the sphere, as it is convex.
[[nodiscard]] inline bool is_surely_compact(double radius2, double neighbor2) {
    return 13 * radius2 <= vast_surface * neighbor2;
}

// Returns the squared distance beyond which walls belong to the vast part of a cell; nothing if the cell is not vast,
// or has no face that rounding of the largest ones hides. is_wall and distance2 take a face; distance2 is that of a
// neighbor, squared.
[[nodiscard]] std::optional<double> vast_beyond(std::span<const double> areas, const auto& is_wall,
                                                const auto& distance2) {
    constexpr double least_part = 0x1p-20;  // of the surface
    double surface = 0, smallest = std::numeric_limits<double>::infinity(), farthest2 = 0;
    for (std::size_t f = 0; f < areas.size(); ++f) {
        surface += areas[f];
        if (!is_wall(f)) smallest = std::min(smallest, areas[f]);
    }
    if (!(smallest < least_part * surface)) return {};
    for (std::size_t f = 0; f < areas.size(); ++f)
        if (!is_wall(f)) farthest2 = std::max(farthest2, distance2(f));
    if (!(surface > vast_surface * farthest2)) return {};
    return vast_surface * farthest2;
}

}  // namespace votess::cpu
