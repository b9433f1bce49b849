// A run in blocks: each has some of the seeds, and finds their cells among the seeds of all blocks; local_block.hpp
// explains why that works. The rows are those of one tessellate() with all seeds, whatever the blocks are. The caller
// carries messages between blocks, as distributed/mpi does over ranks. The order of use:
//
//   1. BlockDomain, the same for all blocks, from a settled run and the bounds of all seeds; check() the seeds
//   2. split(), the same for all blocks, from a sample of places; blocks_of() returns the block of each seed
//   3. LocalBlock, with its seeds; send the summary_of() each outline() to all blocks
//   4. send halo_for() each outline to its block; clip() with all halos
//   5. send requests() to their blocks, and the reply() to all requests back; complete() with all replies
//   6. in a domain without end, send far() to all blocks; finish() with all of them, else without
//
// Points have three coordinates, in the plane z = 0. Cells are found on the CPU. want.vertices, want.faces, min_face,
// min_area, meshes and duplicates = error are `unsupported`. Errors are those of tessellate(). libvotess_mpi uses these
// classes of libvotess; neither is installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/bytes.hpp"
#include "input/settled.hpp"
#include "verify/reported_cell.hpp"
#include "votess/block_cells.hpp"

namespace votess {

namespace detail {
struct BlockDomainState;
struct Result;
}  // namespace detail

class VOTESS_API BlockDomain {
public:
    // whole: in space or in the plane; its weights are ignored. Each Block calls progress while it finds cells, from 0
    // on. bounds: of all seeds, used when the region has neither box nor cell. seeds: their number in all.
    BlockDomain(Settled whole, const Box& bounds, std::uint64_t seeds);

    // Returns the run with its box.
    [[nodiscard]] const Settled& whole() const noexcept;
    // Returns the run in space. For the plane it is that of a sheet.
    [[nodiscard]] const Settled& in_space() const noexcept;
    // Returns the run of each block. It has near ends where the domain has none, and rows list these.
    [[nodiscard]] const Settled& of_blocks() const noexcept;
    [[nodiscard]] bool endless() const noexcept;
    // Returns whether the wall of this id is a near end.
    [[nodiscard]] bool is_end(std::int32_t id) const noexcept;
    // Turns cells that were made with these into those of the domain.
    void complete(detail::Result& cells) const;
    // Returns the volume of the domain. With walls, it is 0 unless a seed inside them is given.
    [[nodiscard]] double volume(std::span<const double> seed = {}) const;
    // Returns N statuses: `outside` for seeds to drop, else `certified`. Throws invalid_argument that names the first
    // bad point by its index plus `first`. points: (N, 3). weights: N, or none.
    [[nodiscard]] std::vector<CellStatus> check(std::span<const double> points, const Weights& weights = {},
                                                std::uint64_t first = 0) const;
    // Returns (N, 3): where seeds are after wrapping, in an internal unit.
    [[nodiscard]] std::vector<double> places(std::span<const double> points) const;
    // Splits space into blocks with about equal numbers of seeds. sample: (M, 3) places, the same for all in the same
    // order.
    void split(std::span<const double> sample, std::size_t blocks);
    // After split(): returns N block numbers. Seeds at one place have the same block.
    [[nodiscard]] std::vector<std::uint32_t> blocks_of(std::span<const double> places) const;

private:
    std::shared_ptr<detail::BlockDomainState> state_;
};

// Returns what a checker of rows needs. volume: of the domain.
[[nodiscard]] VOTESS_API CheckedRun checked_run(const BlockDomain& domain, std::uint64_t seeds, double volume);

struct BlockCounts {
    std::uint64_t given = 0;        // seeds from other blocks: halos and replies
    std::uint64_t needed = 0;       // of these, neighbors of cells of the block
    std::uint64_t tested = 0;       // cells whose vertices were compared with boxes of unknown seeds
    std::uint64_t questions = 0;    // requests: a cell counts once for each block
    std::uint64_t exact_cells = 0;  // cells where exact arithmetic decided a sign; twice if also after a reply
};

}  // namespace votess
