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

#include "votess/votess.hpp"

namespace votess {

// What one block says to another: for the same version of votess on a machine of the same kind.
using Message = std::vector<std::byte>;

namespace detail {
struct BlockDomainState;
struct BlockState;
struct BlockVerifierState;
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

// The cells of a block's seeds, in their order. Arrays as those of Tessellation, but rows hold ids, or walls below 0,
// and ascend by them, then by shift. Arrays that are not wanted are empty; the rows are always there.
struct BlockCells {
    std::vector<CellStatus> status;          // N
    std::vector<std::int64_t> duplicate_of;  // N: the id of the seed that has the cell, -1 for others; or none at all
    std::vector<std::int64_t> indptr;        // N+1
    std::vector<std::int64_t> neighbors;     // entries
    std::vector<std::int32_t> tags;          // entries: of the neighbors, -1 for walls
    std::vector<std::int8_t> shifts;         // (entries, 3), where the domain is periodic
    std::vector<double> areas, normals;      // entries, (entries, 3)
    std::vector<double> volumes, centroids, surface_areas, security_radii;  // N, (N, 3), N, N
    std::vector<std::uint32_t> face_counts, edge_counts, vertex_counts;     // N
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

// Checks cells as verify() does, those of each block against the seeds of all. Texts are one line on the first thing
// that is wrong, "" where nothing is. In the order of use:
//
//   1. check_rows(), check_euler(); volumes of all sum to that of the domain
//   2. pairs() go to their blocks; check_pairs() of each that comes
//   3. seeds() of some cells go to all blocks; from each faces_of() them come back; check_cells()
//
// Not for several threads at once. Errors as of tessellate().
class VOTESS_API BlockVerifier {
public:
    // The arrays must outlive it. ids: N, each unlike those of other blocks. points: (N, 3). weights: N in a power
    // diagram, else none. cells: of these seeds. holders: entries, which block has the cell of each neighbor; any
    // number for walls.
    BlockVerifier(const BlockDomain& domain, std::span<const std::int64_t> ids, std::span<const double> points,
                  std::span<const double> weights, const BlockCells& cells, std::span<const std::int32_t> holders);
    BlockVerifier(BlockVerifier&&) noexcept;
    BlockVerifier& operator=(BlockVerifier&&) noexcept;
    ~BlockVerifier();

    [[nodiscard]] std::string check_rows() const;   // ascend, without which pairs are not found
    [[nodiscard]] std::string check_euler() const;  // where there are counts
    // By block: what rows first to last, in the order of ids, say of its cells.
    [[nodiscard]] std::vector<Message> pairs(std::size_t blocks, std::size_t first, std::size_t last) const;
    [[nodiscard]] std::string check_pairs(const Message& pairs) const;

    // Cells that may be tried by brute force: of seeds that are neither duplicates nor outside.
    [[nodiscard]] std::size_t candidates() const noexcept;
    [[nodiscard]] Message seeds(std::span<const std::size_t> candidates) const;
    // Clips the cells of these seeds by every seed of the block, without any search structure.
    [[nodiscard]] Message faces_of(const Message& seeds);
    // faces: from each block, of the seeds() of these candidates.
    [[nodiscard]] std::string check_cells(std::span<const std::size_t> candidates, std::span<const Message> faces);
    // Whether faces_of() has taken about a second, counted in what it did.
    [[nodiscard]] bool has_worked_enough() const noexcept;

private:
    std::unique_ptr<detail::BlockVerifierState> state_;
};

}  // namespace votess
