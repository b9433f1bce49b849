// The domain of a run as given: in two or three dimensions, a box or a cell with planes that are finite or at infinity,
// cut by walls or by a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// Without box and cell, a box is chosen around the seeds. A box may have infinite bounds. A cell has no end along an
// edge that is 0.
struct Region {
    std::optional<Box> box;
    std::array<bool, 3> periodic{};  // of the box
    std::optional<TriclinicBox> cell;
    std::vector<Wall> walls;
    std::optional<TriangleMesh> mesh;
    Outside outside = Outside::error;
    bool planar = false;
    // Of the sheet in space that stands for the plane, a power of two: a mesh reaches beyond its walls. Else 0.
    double thickness = 0;

    // Returns the axes, or the edges of the cell, along which it repeats.
    [[nodiscard]] const std::array<bool, 3>& repeats() const { return cell ? cell->periodic : periodic; }
    [[nodiscard]] bool is_periodic() const { return repeats() != std::array<bool, 3>{}; }
};

struct NamedVector {
    const char* name;
    const std::array<double, 3>& numbers;
};
[[nodiscard]] inline std::array<NamedVector, 4> vectors_of(const TriclinicBox& cell) {
    return {{{"origin", cell.origin}, {"a", cell.a}, {"b", cell.b}, {"c", cell.c}}};
}

// The sides of a domain that are at infinity.
class EndlessSides {
public:
    EndlessSides() = default;  // none
    explicit EndlessSides(const Region& region);

    [[nodiscard]] bool any() const { return sides_ != 0; }
    // Whether the wall of this id is at infinity. Those below -6 are FlatEnds.
    [[nodiscard]] bool has(std::int32_t id) const { return id < -6 || (id < 0 && (sides_ >> (-1 - id) & 1) != 0); }
    // Whether one of the walls of these ids is at infinity.
    [[nodiscard]] bool any_of(std::span<const std::int32_t> ids) const {
        return std::ranges::any_of(ids, [this](std::int32_t id) { return has(id); });
    }
    // The id of infinity in rows: of the sides that are there, the one nearest to -1.
    [[nodiscard]] std::int32_t id() const;

private:
    unsigned sides_ = 0;
};

// Returns the region of a sheet with walls at z = -height and height, for one of the plane.
[[nodiscard]] Region in_sheet(Region planar, double height);

// Checks a box, whose bounds are finite.
void check_box(const Box& box);
// Checks all that needs no seeds. Bounds that are not finite are checked with the seeds, see make_job().
void check_region(const Region& region);

}  // namespace votess
