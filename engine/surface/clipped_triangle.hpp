// One triangle, clipped to one cell.
//
// The part is a convex polygon. A list of its sides describes it: edges of the triangle, and bisectors. Clipping it by
// a bisector needs the side of each corner, which MeshSigns decides. Ranks decide ties: see mesh_signs.hpp. So the
// parts are those of a power diagram in general position, and tile the triangle.
//
// A seed cuts the part only if a corner is nearer to it. So seeds are tried in the order of their distance, until the
// balls around all corners that touch the seed are searched. Their places need only be good enough for that.
//
// Places of corners are weights of the triangle's vertices, in double with a bound on the error. Where it exceeds
// `weight_rounding`, or that of the place `place_rounding`, weights are rounded from exact quotients.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"
#include "solid/mesh_signs.hpp"
#include "surface/surface.hpp"

namespace votess::surface {

// A seed beyond a bisector; or -1, -2, -3 for the triangle's edges, -1 - i from its corner i.
using Side = std::int32_t;

[[nodiscard]] inline std::size_t corner_of(Side edge) {
    return at(-1 - edge);
}

class ClippedTriangle {
public:
    explicit ClippedTriangle(const Surface& surface) : surface_(surface) {}

    // near: seeds around this one, the nearest first, without itself. Returns whether there is a part.
    bool clip(std::int32_t triangle, std::int32_t seed, std::span<const std::int32_t> near);

    // Sides of the part: side i leads from corner i.
    [[nodiscard]] std::size_t size() const { return sides_.size(); }
    [[nodiscard]] Side side(std::size_t i) const { return sides_[i] < 0 ? sides_[i] : ids_[at(sides_[i])]; }
    // Returns where corner i lies: weights of the second and third vertex. For a corner on an edge of the triangle: the
    // weight of the edge's higher vertex, and 0.
    [[nodiscard]] std::array<double, 2> place(std::size_t i) const;
    // Finds which sides have no length, and whether the part has no area.
    void find_ties();
    [[nodiscard]] bool has_length(std::size_t i) const { return lengthless_.empty() || lengthless_[i] == 0; }
    [[nodiscard]] bool has_area() const { return has_area_; }

private:
    struct Corner {
        Vector3 x;      // relative to the seed
        double error;   // bound on the distance
        double reach;   // square of the distance within which seeds may cut it off, without weights
        double radius;  // distance from the seed, at most
    };
    struct Weights {
        std::array<double, 3> of;  // vertices of the triangle
        double error;              // bound, of each
    };
    [[nodiscard]] bool try_seed(std::int32_t id);
    [[nodiscard]] bool in_reach(std::int32_t id) const;
    [[nodiscard]] bool in_reach(const SeedTree::Node& node) const;
    [[nodiscard]] bool clip_by(std::size_t b);
    [[nodiscard]] int sign_at(Side in, Side out, std::size_t b) const;
    [[nodiscard]] Weights weights(Side in, Side out) const;
    [[nodiscard]] Weights exact_weights(Side in, Side out) const;
    [[nodiscard]] std::array<exact::BigInt, 3> exact_values(std::int32_t id, const exact::BitRange& range) const;
    [[nodiscard]] Corner corner(Side in, Side out) const;
    [[nodiscard]] Side before(std::size_t i) const { return sides_[i == 0 ? sides_.size() - 1 : i - 1]; }

    const Surface& surface_;
    const Surface::Triangle* triangle_ = nullptr;
    std::int32_t seed_ = 0;
    double size_ = 0;  // a bound on the triangle's longest edge
    solid::MeshSigns signs_;
    solid::MeshSigns::Places places_;
    std::vector<std::int32_t> ids_;                 // by bisector: the seed beyond it
    std::vector<solid::MeshSigns::Values> values_;  // by bisector
    std::vector<Side> sides_, next_sides_;          // with numbers of bisectors
    std::vector<Corner> corners_, next_corners_;
    std::vector<int> outside_;
    std::vector<std::uint8_t> lengthless_;
    bool is_tied_ = false, has_area_ = true;
};

}  // namespace votess::surface
