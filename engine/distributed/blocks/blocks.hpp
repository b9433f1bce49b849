// A run in blocks: each has some of the seeds, and finds the cells that these have among the seeds of all blocks. The
// rows are those of one tessellate() with all seeds, whatever the blocks are. How blocks reach each other is up to the
// caller, who carries bytes between them; votess/mpi.hpp does it by MPI. In the order of use:
//
//   1. BlockDomain, the same for all, from the options and what bounds all seeds; check() the seeds
//   2. split(), the same for all, from a sample of their places; blocks_of() says where each seed belongs
//   3. Block, with its seeds; each outline() goes to all
//   4. layer_for() each outline goes to its block; clip() with all layers
//   5. question_for() each block goes to it, its answer() comes back; finish() with all answers
//
// An empty Message says nothing and need not be sent. If j is a neighbor of i among all seeds, it is one among any that
// contain both, so a block that is asked may answer for its own seeds alone (Levy: Large-scale semi-discrete
// optimal transport with distributed Voronoi diagrams, arXiv 2406.04192, 2024). One question is enough: what comes back
// makes a cell smaller, and a smaller cell reaches nothing that the larger one did not.
//
// Cells are found on the CPU. Not with want.vertices or want.faces, nor min_face or min_area (`unsupported`). Errors as
// of tessellate().
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/bytes.hpp"
#include "votess/block_cells.hpp"

namespace votess {

namespace detail {
struct BlockDomainState;
struct BlockState;
}  // namespace detail

class VOTESS_API BlockDomain {
public:
    // options: those of the run, except weights and radii; each Block calls progress while it finds cells, from 0 on.
    // bounds: of all seeds, where options name neither box nor cell; seeds: how many there are in all.
    BlockDomain(const Options& options, const Box& bounds, std::uint64_t seeds);

    // The options with the box that was settled.
    [[nodiscard]] const Options& options() const noexcept;
    // The volume of the domain; with walls 0 unless some seed is given, inside of them.
    [[nodiscard]] double volume(std::span<const double> seed = {}) const;
    // N bytes for the points (N, 3): `outside` for seeds that are to be left out, else `certified`. Throws
    // invalid_argument that names the first bad point by its index, counted from `first` on. weights, radii: N, or
    // none.
    [[nodiscard]] std::vector<CellStatus> check(std::span<const double> points, std::span<const double> weights = {},
                                                std::span<const double> radii = {}, std::uint64_t first = 0) const;
    // (N, 3): where seeds lie after wrapping, in a unit of its own.
    [[nodiscard]] std::vector<double> places(std::span<const double> points) const;
    // Splits space into so many blocks of about equal numbers of seeds, by a sample (M, 3) of places that must be the
    // same, in the same order, for all.
    void split(std::span<const double> sample, std::size_t blocks);
    // N numbers of blocks, after split(). Seeds at one place belong to one block.
    [[nodiscard]] std::vector<std::uint32_t> blocks_of(std::span<const double> places) const;

private:
    friend class Block;
    std::shared_ptr<detail::BlockDomainState> state_;
};

struct BlockCounts {
    std::uint64_t given = 0;        // seeds that other blocks gave: layers and answers
    std::uint64_t needed = 0;       // of these, neighbors of cells of the block
    std::uint64_t tested = 0;       // cells whose vertices were compared with where other seeds may be
    std::uint64_t questions = 0;    // cells asked about, once for each block asked
    std::uint64_t exact_cells = 0;  // cells where exact arithmetic decided a sign, twice if also after an answer
};

// One block. Not for several threads at once; options.threads work inside of a call.
class VOTESS_API Block {
public:
    // ids: N, ascending, from 0 on, unlike those of any other block. points: (N, 3). weights: N in a power diagram, if
    // need be squares of radii; else none. tags: N numbers that stand in rows beside the ids, or none: 0.
    Block(const BlockDomain& domain, std::span<const std::int64_t> ids, std::span<const double> points,
          std::span<const double> weights = {}, std::span<const std::int32_t> tags = {});
    Block(Block&&) noexcept;
    Block& operator=(Block&&) noexcept;
    ~Block();

    [[nodiscard]] Message outline() const;
    [[nodiscard]] Message layer_for(const Message& outline) const;
    // outlines: of all blocks, in their order; own: which of them is this one's. layers: those that others made for it,
    // in the same order, its own empty.
    void clip(std::span<const Message> outlines, std::size_t own, std::span<const Message> layers);
    [[nodiscard]] Message question_for(std::size_t block) const;
    [[nodiscard]] Message answer(const Message& question);
    [[nodiscard]] BlockCells finish(std::span<const Message> answers);
    [[nodiscard]] const BlockCounts& counts() const noexcept;

private:
    std::unique_ptr<detail::BlockState> state_;
};

}  // namespace votess
