// Corners that cells hand on: where rows name no corners, each is searched by one of its cells, not by all four.
//
// Cells are closed in some order, in blocks. A cell is closed if its corners are found here, else it is left to
// RowPolytope::wrap(). A corner is shared if it lies between four seeds without shifts, all in one block, of which none
// is left when the first of them is closed. That one proves the corner and hands it to the others. So all four have it.
// Each of the others takes it as it is, or is left and names it, see Certificate::add_names(). All other corners are
// searched and named by each of their cells. In a closed cell
//   A. exactly one corner is on top, see shared_corners.hpp;
//   C. the normals of each corner turn positively: where it was proven, and so in all of its cells;
//   D. each edge has a positive length: one of its ends lies inside of the third plane of the other. An end that is
//      proven in the cell lies inside of all of its planes. If the ends come from two earlier cells, the first closed
//      cell of the edge has both, and compares them;
//   E. walls that are not among its planes lie out of its reach;
//   and each edge of each corner has two ends, see RowPolytope::wrap_surely().
// Then the cell is the polytope of its planes and of all walls, with these corners, by the proof in shared_corners.hpp.
// Of a cell that is left, the whole polytope is found within the walls. The order counts for nothing but speed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/at.hpp"
#include "verify/row_polytope.hpp"
#include "verify/shared_corners.hpp"

namespace votess {

class HandedCorners {
public:
    // Begins a block: the seeds order[begin] to order[end - 1]. ranks: the place in the order of each seed, or -1.
    void begin(std::span<const std::int32_t> order, std::span<const std::int32_t> ranks, std::size_t begin,
               std::size_t end);
    // Tries to close a cell of the block, whose polytope has its planes, of which the first `faces` must have faces.
    // Returns false where that fails. E is left to the caller.
    [[nodiscard]] bool close(RowPolytope& polytope, std::size_t seed, std::size_t faces);
    // Hands the new corners of that cell on. Returns false where an earlier cell lacks one.
    [[nodiscard]] bool hand_on(const RowPolytope& polytope);
    // Brings into the cache what a cell of the block needs soon.
    void prefetch(std::size_t next) const {
        const std::uint32_t end = cells_[next].end, begin = end & ~last;
        if (end == last) return;
        for (std::uint32_t k = begin; k < end; ++k) __builtin_prefetch(&found_[links_[k] >> 2]);
        const std::uint32_t before = links_[begin + last];
        for (std::uint32_t k = before; k < before + last && before > 0; ++k)
            __builtin_prefetch(&found_[links_[k] >> 2]);
    }
    // The corners of the cell that it must name.
    [[nodiscard]] std::span<const int> to_name() const { return to_name_; }
    // Leaves a cell. Calls visit(three seeds) for the corners that were handed to it.
    template <class Visit>
    void leave(std::size_t seed, const Visit& visit) {
        const std::uint32_t cell = local(static_cast<std::int32_t>(seed));
        for_handed(cell, [&](const Found& found, std::size_t k) {
            if (found.last_cell() == cell) free_found_.push_back(static_cast<std::uint32_t>(&found - found_.data()));
            const std::array<std::uint32_t, 3> others = found.seen_from(k);
            visit(std::array{order_[others[0]], order_[others[1]], order_[others[2]]});
            return true;
        });
        free_pieces_of(cell);
        cells_[cell].left = true;
    }

private:
    struct alignas(64) Found {
        std::array<std::uint32_t, 4> cells;  // numbers in the block; the first one found it
        Vector3 at;                          // seen from the first
        double error;
        // Returns the other cells in the order in which their normals turn positively in cell k. k is hard to foretell,
        // so there is no branch.
        [[nodiscard]] std::array<std::uint32_t, 3> seen_from(std::size_t k) const {
            static constexpr std::array<std::array<std::uint8_t, 3>, 4> others{
                {{1, 2, 3}, {0, 3, 2}, {1, 3, 0}, {2, 1, 0}}};
            return {cells[others[k][0]], cells[others[k][1]], cells[others[k][2]]};
        }
        [[nodiscard]] std::uint32_t last_cell() const { return std::max({cells[1], cells[2], cells[3]}); }
    };
    // Corners handed to cells: of each the number of the corner, four times, and that of the cell there. They lie in
    // pieces of 16, of which the last place names the piece before. Piece 0 is full and stands for none.
    static constexpr std::uint32_t piece_size = 16, last = piece_size - 1, none = 0xffffffff;
    struct Cell {
        std::uint32_t end = last;      // of its last piece
        std::uint32_t seen_by = none;  // the last cell that has it in its row
        std::uint16_t plane = 0;       // of that
        bool left = false;
    };
    enum class Side : std::uint8_t { other, earlier, later };  // of a plane: a closed cell, one to be closed, or none
    // Calls visit(found, k) for the corners handed to a cell, which is number k of each, until one returns false.
    template <class Visit>
    bool for_handed(std::uint32_t cell, const Visit& visit) const {
        for (std::uint32_t end = cells_[cell].end; end > last; end = links_[end | last] + last)
            for (std::uint32_t k = end & ~last; k < end; ++k)
                if (!visit(found_[links_[k] >> 2], links_[k] & 3)) return false;
        return true;
    }
    // Returns the number of a seed in the block; if it is not there, one beyond the end.
    [[nodiscard]] std::uint32_t local(std::int32_t seed) const {
        return static_cast<std::uint32_t>(ranks_[at(seed)] - begin_);
    }
    void look_around(const RowPolytope& polytope, std::uint32_t cell);
    [[nodiscard]] bool take_handed(RowPolytope& polytope, std::uint32_t cell);
    [[nodiscard]] bool has_one_top(const RowPolytope& polytope, std::size_t direction);
    [[nodiscard]] bool check_edges(RowPolytope& polytope);
    void free_pieces_of(std::uint32_t cell);

    void hand(std::uint32_t cell, std::uint32_t link);

    std::span<const std::int32_t> order_, ranks_;
    std::int32_t begin_ = 0;
    std::vector<Cell> cells_;
    std::vector<Found> found_;
    std::vector<std::uint32_t> links_;
    std::vector<std::uint32_t> free_found_, free_pieces_;  // that no cell waits for
    std::vector<std::uint32_t> done_;                      // corners for which no cell waits after this one
    std::vector<Side> sides_;                              // by plane
    std::vector<std::uint32_t> locals_;                    // by plane, of cells in the block
    std::vector<double> across_, along_;                   // by plane, of SeenNormal
    std::size_t handed_ = 0;                               // corners to the cell, its first ones
    std::vector<int> to_compare_, new_, to_name_;          // edges, corners of the polytope
    std::uint32_t cell_ = 0;
};

}  // namespace votess
