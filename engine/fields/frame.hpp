// A regular grid laid over a domain, and the tiles of it that threads take.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/arithmetic.hpp"
#include "core/convex_piece.hpp"
#include "input/job.hpp"
#include "votess/votess.hpp"

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
    std::int64_t tile = 1;  // grid cells of a tile; the last one may have fewer

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

// mantissa * 2^exponent, which no double need hold.
struct Size {
    double mantissa = 1;
    int exponent = 0;
};

// Coordinates of the grid count grid cells: those of cell (i, j, k) go from i to i + 1, and so on.
class Frame {
public:
    Frame(const Job& job, const std::array<std::size_t, 3>& shape);
    // Over the domain of a result. The plane is one unit thick.
    Frame(const Tessellation& tessellation, const std::array<std::size_t, 3>& shape);

    [[nodiscard]] const Axis& axis(std::size_t k) const { return axes_[k]; }
    [[nodiscard]] std::size_t cells() const;
    // Volume of a grid cell; its area in the plane, or across an axis that is projected.
    [[nodiscard]] Size cell_size(std::optional<int> projected = {}) const;
    // Whether the coordinates of the grid are left-handed in space.
    [[nodiscard]] bool mirrored() const { return mirrored_; }
    // A place of the input, and a difference of two, in coordinates of the grid.
    [[nodiscard]] Vector position(const double* x) const;
    [[nodiscard]] Vector difference(const double* from, const double* to) const;
    // A difference that is times the scale of the job, and where the domain begins at that scale.
    [[nodiscard]] Vector in_grid(const Vector& difference) const;
    [[nodiscard]] const Vector& origin() const { return origin_; }
    // Edge k of the domain, and the scale of both.
    [[nodiscard]] const Vector& edge(std::size_t k) const { return edges_[k]; }
    [[nodiscard]] double scale() const { return scale_; }
    // The difference of two places of the input, from that in coordinates of the grid.
    [[nodiscard]] Vector in_space(const Vector& difference) const;
    // The center of a grid cell, in space.
    [[nodiscard]] Vector center(const Cell& cell) const;

    // Where a grid cell lies in an array, and back. Along an axis that is projected the array has one element.
    [[nodiscard]] std::size_t index(const Cell& cell, std::optional<int> projected = {}) const;
    [[nodiscard]] Cell cell(std::size_t index) const;
    // Returns the grid cells along an axis that a body meets whose coordinates go from at + least to at + largest.
    [[nodiscard]] Range cover(std::size_t k, double at, double least, double largest) const;

private:
    // origin, edges: of the domain, times a power of two, the scale.
    struct Domain {
        Vector origin{};
        std::array<Vector, 3> edges{};
        double scale = 1;
    };
    [[nodiscard]] static Domain domain_of(const Box& box, const std::optional<TriclinicBox>& cell, double scale);
    [[nodiscard]] static Domain domain_of(const Tessellation& tessellation);
    Frame(const Domain& domain, const std::array<bool, 3>& periodic, const std::array<std::size_t, 3>& shape);

    std::array<Axis, 3> axes_;
    double scale_ = 1;  // of the job, as all lengths below
    Vector origin_{};
    std::array<Vector, 3> edges_{};  // of the domain
    // Edges differ in length by any factor, so these are of edges times 2^-exponents_[k].
    std::array<Vector, 3> rows_{};  // of the matrix from space to the grid
    std::array<double, 3> lengths_{};
    double determinant_ = 0;
    std::array<int, 3> exponents_{};
    std::array<std::array<double, 2>, 3> powers_{};  // 2^-exponents_[k] is the product of two, for it may overflow
    bool mirrored_ = false;
    int flat_exponent_ = 0;  // of the thickness of a sheet
};

}  // namespace votess::fields
