// A regular grid laid over a domain, and the tiles of it that threads take.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/ceil.hpp"
#include "core/convex_piece.hpp"
#include "input/job.hpp"

namespace votess::fields {

using Vector = ConvexPiece::Vector;
using Cell = std::array<std::int64_t, 3>;  // of the grid, by its numbers along the axes

// Grid cells from `first` to `last` along an axis. They are numbered on beyond a periodic domain.
struct Range {
    std::int64_t first = 0, last = -1;
};
using Window = std::array<Range, 3>;

// 0 to n - 1, for negative numbers too.
constexpr std::int64_t modulo(std::int64_t number, std::int64_t n) {
    return (number % n + n) % n;
}

// Along one axis.
struct Axis {
    std::int64_t count = 1;  // grid cells
    bool periodic = false;
    double length = 0;      // of the box or the edge
    std::int64_t tile = 1;  // grid cells of a tile, but for the last one

    [[nodiscard]] std::int64_t tiles() const { return ceil_div(count, tile); }
    // Tiles too are numbered on beyond a periodic domain.
    [[nodiscard]] std::int64_t tile_of(std::int64_t cell) const {
        const std::int64_t inside = modulo(cell, count);
        return (cell - inside) / count * tiles() + inside / tile;
    }
    [[nodiscard]] Range cells_of(std::int64_t tile_number) const {
        const std::int64_t inside = modulo(tile_number, tiles());
        const std::int64_t before = (tile_number - inside) / tiles() * count;
        return {before + inside * tile, before + std::min(count, (inside + 1) * tile) - 1};
    }
};

// Coordinates of the grid count grid cells: those of cell (i, j, k) go from i to i + 1, and so on.
class Frame {
public:
    Frame(const Job& job, const std::array<std::size_t, 3>& shape);

    [[nodiscard]] const Axis& axis(std::size_t k) const { return axes_[k]; }
    [[nodiscard]] std::size_t cells() const;
    [[nodiscard]] double cell_volume() const { return cell_volume_; }
    // Whether the coordinates of the grid are left-handed in space.
    [[nodiscard]] bool mirrored() const { return mirrored_; }
    // A place and a difference of places in coordinates of the grid.
    [[nodiscard]] Vector position(const double* x) const;
    [[nodiscard]] Vector difference(const double* from, const double* to) const;
    // The center of a grid cell, in space.
    [[nodiscard]] Vector center(const Cell& cell) const;

    // Where a grid cell lies in an array, and back. Along an axis that is projected the array has one element.
    [[nodiscard]] std::size_t index(const Cell& cell, std::optional<int> projected = {}) const;
    [[nodiscard]] Cell cell(std::size_t index) const;
    // The grid cells along an axis that a body meets whose coordinates go from `least` to `largest`.
    [[nodiscard]] Range cover(std::size_t k, double least, double largest) const;

private:
    std::array<Axis, 3> axes_;
    Vector origin_{};
    std::array<Vector, 3> edges_{};  // of a grid cell
    std::array<Vector, 3> rows_{};   // of the matrix from space to the grid
    double cell_volume_ = 0;
    bool mirrored_ = false;
};

}  // namespace votess::fields
