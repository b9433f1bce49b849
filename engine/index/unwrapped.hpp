// Seeds of a periodic domain, moved by whole periods so that those near each other lie together. A sphere of seeds that
// crosses a side of the domain is one sphere again, so a triangulation of its seeds alone finds their neighbors.
#pragma once

#include <optional>
#include <vector>

#include "core/thread_pool.hpp"
#include "index/hierarchy.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {

struct Unwrapped {
    std::vector<exact::Shift> shifts;  // by sorted seed
    SortedSeeds seeds;                 // at their new places, rounded, without images or weights
    Hierarchy hierarchy;
    exact::Point rounding{};  // of coordinates

    // The shift of an image, from places as they are here to places among the sorted seeds.
    [[nodiscard]] exact::Shift shift_between(std::int32_t from, std::int32_t to, const exact::Shift& by = {}) const {
        exact::Shift shift = by;
        for (std::size_t j = 0; j < shift.size(); ++j)
            shift[j] += shifts[static_cast<std::size_t>(to)][j] - shifts[static_cast<std::size_t>(from)][j];
        return shift;
    }
};

// Returns nothing if that parts about as many near seeds as the sides of the domain do, or if few are near each other,
// or if they fill a sheet.
std::optional<Unwrapped> unwrap(const SortedSeeds& seeds, ThreadPool& pool);

}  // namespace votess::cpu
