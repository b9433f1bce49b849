// The polygons of a cell in the coordinates of a grid.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/frame.hpp"
#include "votess/votess.hpp"

namespace votess::fields {

// Both arguments must outlive it. A cell of the plane is a prism from z = 0 to 1, without the polygons below and above.
// Its entries are edges too.
class CellPolygons {
public:
    CellPolygons(const Tessellation& t, const Frame& frame) : t_(t), frame_(frame), dimensions_(t.planar() ? 2 : 3) {}

    // Returns false for a seed without a cell.
    [[nodiscard]] bool load(std::size_t seed) {
        if (t_.status()[seed] != CellStatus::certified) return false;
        begin_ = static_cast<std::size_t>(t_.indptr()[seed]);
        end_ = static_cast<std::size_t>(t_.indptr()[seed + 1]);
        first_ = vertex(t_.face_offsets()[begin_]);
        at_ = frame_.position(first_.data());
        return true;
    }

    // The entries of its row.
    [[nodiscard]] std::size_t begin() const { return begin_; }
    [[nodiscard]] std::size_t end() const { return end_; }
    // Its first corner: in space, and in the grid.
    [[nodiscard]] const Vector& first() const { return first_; }
    [[nodiscard]] const Vector& at() const { return at_; }
    // Returns the polygon of an entry, counterclockwise seen from outside, relative to at(). Valid until the next call.
    [[nodiscard]] std::span<const Vector> polygon(std::size_t entry) {
        polygon_.clear();
        for (std::int64_t k = t_.face_offsets()[entry]; k < t_.face_offsets()[entry + 1]; ++k)
            polygon_.push_back(frame_.difference(first_.data(), vertex(k).data()));
        for (std::size_t k = polygon_.size(); dimensions_ == 2 && k-- > 0;)
            polygon_.push_back({polygon_[k][0], polygon_[k][1], 1});
        if (frame_.mirrored()) std::ranges::reverse(polygon_);
        return polygon_;
    }
    // Returns the edge of an entry in the plane, counterclockwise in the grid, relative to at().
    [[nodiscard]] std::array<Vector, 2> edge(std::size_t entry) const {
        const std::int64_t corner = t_.face_offsets()[entry];
        std::array<Vector, 2> edge;
        for (std::int64_t k = 0; k < 2; ++k)
            edge[static_cast<std::size_t>(frame_.mirrored() ? 1 - k : k)] =
                frame_.difference(first_.data(), vertex(corner + k).data());
        return edge;
    }

private:
    [[nodiscard]] Vector vertex(std::int64_t corner) const {
        const auto v = static_cast<std::size_t>(t_.face_vertices()[static_cast<std::size_t>(corner)]);
        Vector place{};
        for (std::size_t k = 0; k < dimensions_; ++k) place[k] = t_.vertices()[dimensions_ * v + k];
        return place;
    }

    const Tessellation& t_;
    const Frame& frame_;
    std::size_t dimensions_;
    std::size_t begin_ = 0, end_ = 0;
    Vector first_{}, at_{};
    std::vector<Vector> polygon_;
};

}  // namespace votess::fields
