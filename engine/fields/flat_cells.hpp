// The cells of a plane, made of their neighbors alone.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/thread_pool.hpp"
#include "fields/frame.hpp"
#include "votess/votess.hpp"

namespace votess::fields {

// The seeds of a sheet, see plane/sheet.hpp. Their z is 0.
struct FlatSeeds {
    std::span<const double> places;   // 3N, inside a periodic domain
    std::span<const double> weights;  // N
    std::span<const Wall> walls;      // of the region
};

// Each line of a row bounds its cell on one edge, and edges are in the order of their directions. So corners are where
// a line meets the next. They are relative to the first of them: a cell far from its seed keeps its digits.
class FlatCells {
public:
    // t: the cells of the sheet, with neighbors and walls.
    FlatCells(const Tessellation& t, const Frame& frame, const FlatSeeds& seeds, ThreadPool& pool);

    // Coordinates of the grid, relative to at(). Counterclockwise there, empty without length.
    struct Edge {
        std::array<double, 2> from{}, to{};
    };
    [[nodiscard]] const Edge& edge(std::size_t entry) const { return edges_[entry]; }
    // The first corner of a cell: in space, and in the grid.
    [[nodiscard]] const Vector& first(std::size_t seed) const { return firsts_[seed]; }
    [[nodiscard]] const Vector& at(std::size_t seed) const { return ats_[seed]; }
    // Areas of the cells, and lengths of their edges.
    [[nodiscard]] std::span<const double> volumes() const { return volumes_; }
    [[nodiscard]] std::span<const double> areas() const { return areas_; }

private:
    class Maker;

    std::vector<Edge> edges_;
    std::vector<Vector> firsts_, ats_;
    std::vector<double> volumes_, areas_;
};

}  // namespace votess::fields
