// One block of a run: some of the seeds, and their cells among all seeds.
//
// Two seeds that are neighbors among all seeds are neighbors in any subset that holds both (Levy, arXiv 2406.04192,
// 2024). So each block clips with its own seeds and a halo. If a cell reaches beyond the halo, the block sends its
// seed and neighbors once to the block concerned, which finds the cell among these and its own seeds, and returns the
// neighbors that it owns. One round is enough, because cells only shrink.
//
// The order of use: halo_for() each other outline; clip() with the halo that others sent; requests(); reply() to those
// of others; complete() and finish(). A run that cannot hold all blocks at once keeps pending_cells() for
// finish_pending(), and the tiles of each block for reply().
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cpu/cpu_clipper.hpp"
#include "distributed/blocks/blocks.hpp"
#include "distributed/blocks/outline.hpp"
#include "input/job.hpp"
#include "input/seeds.hpp"
#include "result/result.hpp"

namespace votess::blocks {

// Pending cells of a block, for another one that may cut them further.
struct Requests {
    struct Reach {
        exact::Point place;  // of the seed, times the scale of the job
        double distance;     // no seed beyond this distance cuts the cell
    };
    Seeds cells;
    std::vector<Reach> reaches;  // of cells
    Seeds neighbors;             // that they have so far

    [[nodiscard]] std::size_t size() const { return cells.size(); }
    static auto parts(auto& some) { return std::tie(some.cells, some.reaches, some.neighbors); }
};

// Finds the seeds of a block that may cut a cell of the requests.
class NearSeeds {
public:
    // job: of the run, which stays with the caller. outline: of the block.
    NearSeeds(const Job& job, const Outline& outline, std::span<const Requests> requests);
    // Adds those of the first `count` seeds that are near: seeds of the block, ascending by id from call to call.
    void add(const Seeds& some, std::size_t count);
    [[nodiscard]] const Seeds& found() const { return found_; }

private:
    const Job& job_;
    Outline near_;  // the tiles with these seeds
    Seeds found_;
};
// Returns seeds for each of the requests: they include the neighbors of its cells in the block. whole: the run, with
// its box and without weights.
std::vector<Seeds> reply(const Settled& whole, const NearSeeds& near, std::span<const Requests> requests);

// Returns a distance beyond which no seed cuts a cell whose vertices lie within sqrt(square) of its seed. more: the
// weight by which other seeds may be heavier.
inline double reach_within(double square, double more) {
    constexpr double slack = 1 + 1e-6;  // covers the rounding of distances
    return (std::sqrt(square) + std::sqrt(square + std::max(0.0, more))) * slack;
}

// Seeds with their sorted copies and the result. The first seeds have cells.
struct Run {
    Seeds seeds;
    std::vector<std::int32_t> row_order;  // see Job
    Job job;
    cpu::CpuClipper clipper;
    std::vector<double> powers;  // see CpuClipper::clip_first(); empty if the result has radii
    detail::Result result;       // without rows if nobody wants them and it has radii
    // Rows of some cells, if the result has none.
    std::shared_ptr<const Subset> rows_of;
    detail::Result rows;

    // Finds the cells of the first seeds. whole: the run, with its box and without weights.
    void clip(const Settled& whole, std::size_t first);
    // After clip(): finds the rows of certified cells.
    void clip_rows(std::vector<std::int32_t> cells);
    [[nodiscard]] bool has_rows() const { return !result.indptr.empty(); }
    // Returns the row of a cell, and its shifts, three an entry. The cell has a row.
    [[nodiscard]] std::span<const std::int32_t> neighbors(std::size_t cell) const {
        const auto [of, begin, size] = row_of(cell);
        return {of->indices.data() + begin, size};
    }
    [[nodiscard]] std::span<const std::int8_t> shifts(std::size_t cell) const {
        const auto [of, begin, size] = row_of(cell);
        return {of->shifts.data() + 3 * begin, 3 * size};
    }
    // After clip(): returns a distance beyond which no seed of at most that weight cuts the cell.
    [[nodiscard]] double reach_of(std::size_t cell, double heaviest) const;

private:
    struct Row {
        const detail::Result* of;
        std::size_t begin, size;
    };
    [[nodiscard]] Row row_of(std::size_t cell) const;
};
// Returns the cells, which ascend by id, and then the others, each seed once and ascending.
Seeds with_others(Seeds cells, const Seeds& others);

// Cells that wait for replies, and the seeds that include all neighbors which they keep.
struct PendingCells {
    Seeds cells, kept_neighbors;
    static auto parts(auto& pending) { return std::tie(pending.cells, pending.kept_neighbors); }
    std::uint64_t faces = 0;  // before the replies
};
// Finds the complete cells: the first ones of the run, in the order of pending.cells.
void finish_pending(const Settled& whole, const PendingCells& pending, const Seeds& replies, Run& run);

struct FarCells;

// Calls for one block must not overlap. The threads of the run work inside a call.
class VOTESS_API LocalBlock {
public:
    // whole: the run, with its box and without weights, and with a callback for the progress of clip().
    // own: ascending by id; the rows of finish() list their tags. Rows list walls if the run does.
    LocalBlock(const Settled& whole, Seeds own);
    ~LocalBlock();

    [[nodiscard]] const Outline& outline() const { return tiled_.outline; }
    [[nodiscard]] Seeds halo_for(const Outline& other) const;
    // outlines: of all blocks, this one's at `number`. halo: the seeds from the others.
    void clip(std::vector<Outline> outlines, std::size_t number, Seeds halo);
    // By block.
    [[nodiscard]] const std::vector<Requests>& requests() const { return requests_; }
    // Returns a reply to each of the requests.
    [[nodiscard]] std::vector<Seeds> reply(std::span<const Requests> requests) const;
    // Finds the pending cells. domain: this block is a part of its of_blocks().
    void complete(const Seeds& replies, const BlockDomain& domain);
    [[nodiscard]] const FarCells& far() const;
    // Returns the cells of the domain. all: the far cells of all blocks.
    [[nodiscard]] BlockCells finish(const FarCells& all, const BlockDomain& domain);
    // After clip(): the cells so far, and which of them are pending, ascending.
    [[nodiscard]] Run& run() { return all_; }
    [[nodiscard]] std::span<const std::uint32_t> pending() const { return pending_; }
    [[nodiscard]] PendingCells pending_cells() const;
    [[nodiscard]] const BlockCounts& counts() const { return counts_; }

private:
    struct Unknown {  // a box where another block has seeds that this one lacks
        Box box;
        std::uint32_t block;
        double largest_weight;
        double from_tile;  // squared distance from the tile of the cells
    };
    class Requester;

    void make_requests();
    [[nodiscard]] std::vector<Unknown> unknown_near(std::size_t tile, double reach) const;
    [[nodiscard]] double weight_of(std::size_t cell) const;
    [[nodiscard]] double longest_reach(double heaviest) const;
    [[nodiscard]] bool any_near(std::size_t tile, double reach) const;

    Settled whole_;
    std::size_t count_;  // own seeds
    Run all_;            // the own seeds, then the halo
    Job job_;            // of the own seeds
    Nearness nearness_;
    std::vector<exact::Point> places_;
    TiledSeeds tiled_;
    std::vector<Outline> outlines_;
    std::size_t number_ = 0;
    std::vector<std::int32_t> positions_;       // of all_.seeds among the sorted ones; -1: none
    std::vector<std::uint32_t> pending_;        // own cells, ascending
    std::vector<std::int32_t> kept_neighbors_;  // of pending cells: indices into all_.seeds
    std::uint64_t pending_faces_ = 0;
    std::vector<Requests> requests_;
    Run pending_run_;
    std::unique_ptr<FarCells> far_;
    std::vector<std::int32_t> far_row_;  // of own cells, in the run of far cells; -1: none
    BlockCounts counts_;
};

}  // namespace votess::blocks
