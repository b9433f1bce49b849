// A run in blocks. Each block holds some of the seeds and finds their cells among the seeds of all blocks. Rows are
// those of one tessellate() with all seeds, for any blocks. The caller carries messages between blocks; votess/mpi.hpp
// does so by MPI. In the order of use:
//
//   1. BlockDomain, the same for all, from the options and the bounds of all seeds; check() the seeds
//   2. split(), the same for all, from a sample of places; blocks_of() returns the block of each seed
//   3. Block, with its seeds; send each outline() to all blocks
//   4. send layer_for() of each outline to its block; clip() with all layers
//   5. send question_for() each block to it, and its answer() back; finish() with all answers
//
// An empty Message need not be sent.
//
// Method: two seeds that are neighbors among all seeds are neighbors in any subset that holds both. So a block may
// answer for its own seeds alone (Levy: Large-scale semi-discrete optimal transport with distributed Voronoi diagrams,
// arXiv 2406.04192, 2024). One question is enough: an answer only makes a cell smaller, and the smaller cell reaches no
// further block.
//
// Cells are found on the CPU. want.vertices, want.faces, min_face and min_area are `unsupported`. Errors as of
// tessellate().
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// Bytes from one block to another. Both need the same version of votess and a machine of the same kind.
using Message = std::vector<std::byte>;

namespace detail {
struct BlockDomainState;
struct BlockState;
struct BlockVerifierState;
}  // namespace detail

class VOTESS_API BlockDomain {
public:
    // options: those of the run, without weights and radii. Each Block calls progress while it finds cells, from 0 on.
    // bounds: of all seeds; used when options have neither box nor cell. seeds: number of all seeds.
    BlockDomain(const Options& options, const Box& bounds, std::uint64_t seeds);

    // Returns the options with the box that is used.
    [[nodiscard]] const Options& options() const noexcept;
    // Returns the volume of the domain; with walls 0 unless one seed inside them is given.
    [[nodiscard]] double volume(std::span<const double> seed = {}) const;
    // Returns N bytes: `outside` for seeds to drop, else `certified`. points: (N, 3). weights, radii: N, or none.
    // Throws invalid_argument, which names the first bad point by its index, counted from `first`.
    [[nodiscard]] std::vector<CellStatus> check(std::span<const double> points, std::span<const double> weights = {},
                                                std::span<const double> radii = {}, std::uint64_t first = 0) const;
    // Returns (N, 3): the places of seeds after wrapping, in a unit of its own.
    [[nodiscard]] std::vector<double> places(std::span<const double> points) const;
    // Splits space into blocks of about equal numbers of seeds. sample: (M, 3) places, the same in the same order for
    // all.
    void split(std::span<const double> sample, std::size_t blocks);
    // Returns N numbers of blocks; needs split(). Seeds at one place belong to one block.
    [[nodiscard]] std::vector<std::uint32_t> blocks_of(std::span<const double> places) const;

private:
    friend class Block;
    std::shared_ptr<detail::BlockDomainState> state_;
};

// The cells of a block's seeds, in their order. Arrays as those of Tessellation, except that rows hold ids, or walls
// below 0, and ascend by id, then shift. Arrays that were not requested are empty, except the rows.
struct BlockCells {
    std::vector<CellStatus> status;          // N
    std::vector<std::int64_t> duplicate_of;  // N ids of the seed that keeps the cell, -1 for seeds with a cell; or none
    std::vector<std::int64_t> indptr;        // N+1
    std::vector<std::int64_t> neighbors;     // entries
    std::vector<std::int32_t> tags;          // entries: tags of the neighbors, -1 for walls
    std::vector<std::int8_t> shifts;         // (entries, 3), in a periodic domain
    std::vector<double> areas, normals;      // entries, (entries, 3)
    std::vector<double> volumes, centroids, surface_areas, security_radii;  // N, (N, 3), N, N
    std::vector<std::uint32_t> face_counts, edge_counts, vertex_counts;     // N
};

struct BlockCounts {
    std::uint64_t given = 0;        // seeds from other blocks: layers and answers
    std::uint64_t needed = 0;       // those among them that are neighbors of cells of the block
    std::uint64_t tested = 0;       // cells whose vertices were compared with the regions of other blocks
    std::uint64_t questions = 0;    // questions about a cell, one for each cell and block
    std::uint64_t exact_cells = 0;  // cells where exact arithmetic decided a sign; twice if again after an answer
};

// One block. One thread at a time may call it; a call uses options.threads threads.
class VOTESS_API Block {
public:
    // ids: N, ascending, at least 0, unique over all blocks. points: (N, 3). weights: N in a power diagram (squares of
    // radii too), else none. tags: N numbers that rows hold beside the ids; none: 0.
    Block(const BlockDomain& domain, std::span<const std::int64_t> ids, std::span<const double> points,
          std::span<const double> weights = {}, std::span<const std::int32_t> tags = {});
    Block(Block&&) noexcept;
    Block& operator=(Block&&) noexcept;
    ~Block();

    [[nodiscard]] Message outline() const;
    [[nodiscard]] Message layer_for(const Message& outline) const;
    // outlines: of all blocks, in their order. own: the number of this block. layers: from all blocks, in the same
    // order, its own empty.
    void clip(std::span<const Message> outlines, std::size_t own, std::span<const Message> layers);
    [[nodiscard]] Message question_for(std::size_t block) const;
    [[nodiscard]] Message answer(const Message& question);
    [[nodiscard]] BlockCells finish(std::span<const Message> answers);
    [[nodiscard]] const BlockCounts& counts() const noexcept;

private:
    std::unique_ptr<detail::BlockState> state_;
};

// Checks cells as verify() does, those of each block against the seeds of all. Checks return one line on the first
// fault, or "". In the order of use:
//
//   1. check_rows(), check_euler(); the volumes of all blocks sum to that of the domain
//   2. send pairs() to their blocks; check_pairs() of each message received
//   3. send seeds() of some cells to all blocks, and faces_of() them back; check_cells()
//
// One thread at a time may call it. Errors as of tessellate().
class VOTESS_API BlockVerifier {
public:
    // The arrays must outlive it. ids: N, unique over all blocks. points: (N, 3). weights: N in a power diagram, else
    // none. cells: of these seeds. holders: entries, the block that has the cell of each neighbor; any number for
    // walls.
    BlockVerifier(const BlockDomain& domain, std::span<const std::int64_t> ids, std::span<const double> points,
                  std::span<const double> weights, const BlockCells& cells, std::span<const std::int32_t> holders);
    BlockVerifier(BlockVerifier&&) noexcept;
    BlockVerifier& operator=(BlockVerifier&&) noexcept;
    ~BlockVerifier();

    [[nodiscard]] std::string check_rows() const;   // that rows ascend; pairs() needs it
    [[nodiscard]] std::string check_euler() const;  // Euler's formula, where there are counts
    // Returns one message for each block: the entries of rows first to last, in the order of ids, that name its cells.
    [[nodiscard]] std::vector<Message> pairs(std::size_t blocks, std::size_t first, std::size_t last) const;
    [[nodiscard]] std::string check_pairs(const Message& pairs) const;

    // Returns the number of cells that may be clipped again: those of seeds neither duplicate nor outside.
    [[nodiscard]] std::size_t candidates() const noexcept;
    [[nodiscard]] Message seeds(std::span<const std::size_t> candidates) const;
    // Clips the cells of these seeds by every seed of the block, without a search structure.
    [[nodiscard]] Message faces_of(const Message& seeds);
    // faces: one message from each block, for the seeds() of these candidates.
    [[nodiscard]] std::string check_cells(std::span<const std::size_t> candidates, std::span<const Message> faces);
    // Returns whether faces_of() has worked for about a second, by a count of operations.
    [[nodiscard]] bool has_worked_enough() const noexcept;

private:
    std::unique_ptr<detail::BlockVerifierState> state_;
};

}  // namespace votess
