// Cuts a convex body or polygon by the planes of a grid: into slabs across the first axis, each into bars, these into
// parts.
#pragma once

#include <array>

#include "core/progress.hpp"
#include "fields/frame.hpp"

namespace votess::fields {

// How coordinates of a body become those of the grid: along axis k, at[k] + along[k].x. So a small or flat body keeps
// its digits.
struct Place {
    Vector at{};
    std::array<Vector, 3> along{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

// A convex body.
struct Body {
    Place place;
    ConvexPiece piece;
};

// The grid cells that a piece meets along an axis.
template <class Piece>
Range cover(const Frame& frame, const Piece& piece, const Place& place, std::size_t axis) {
    const auto [least, largest] = piece.extent(place.along[axis]);
    return frame.cover(axis, place.at[axis], least, largest);
}

// Piece: ConvexPiece or ConvexPolygon.
template <class Piece>
class Slicer {
public:
    explicit Slicer(const Frame& frame) : frame_(frame) {}

    // Calls take(cell, part) with the part of the piece in each grid cell of the window. The piece is used up. The
    // parts of all windows of a grid sum to it.
    template <class Take>
    void slice(Piece& piece, const Place& place, const Window& window, const Take& take) {
        Cell cell{};
        slice_along(0, piece, place, window, cell, take);
    }

private:
    template <class Take>
    void slice_along(std::size_t k, Piece& piece, const Place& place, const Window& window, Cell& cell,
                     const Take& take) {
        if (k == 3) {
            if (++parts_ % parts_per_look == 0) check_stop();
            take(static_cast<const Cell&>(cell), piece);
            return;
        }
        const Range covered = cover(frame_, piece, place, k);
        const auto lower_side = [&](std::int64_t number) { return static_cast<double>(number) - place.at[k]; };
        Piece& below = below_[k];
        if (covered.first < window[k].first) piece.split(place.along[k], lower_side(window[k].first), below);
        const std::int64_t last = std::min(covered.last, window[k].last);
        for (cell[k] = std::max(covered.first, window[k].first); cell[k] <= last && !piece.empty(); ++cell[k]) {
            if (cell[k] == covered.last) {
                slice_along(k + 1, piece, place, window, cell, take);
                return;
            }
            piece.split(place.along[k], lower_side(cell[k] + 1), below);
            if (!below.empty()) slice_along(k + 1, below, place, window, cell, take);
        }
    }

    static constexpr std::size_t parts_per_look = 1024;  // after which the user may stop
    const Frame& frame_;
    std::size_t parts_ = 0;       // so far
    std::array<Piece, 3> below_;  // by axis
};

}  // namespace votess::fields
