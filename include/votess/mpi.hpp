// One tessellation over the ranks of an MPI communicator. The library is votess_mpi; libvotess itself does not use MPI.
//
// Rows are those of one tessellate() with all seeds. They do not depend on the number of ranks, nor on which rank hands
// in which seed. Volumes, centroids and areas agree with it to the promised digits.
#pragma once

#include <mpi.h>

#include "votess/block_cells.hpp"

namespace votess::mpi {

// Which cells a rank gets.
enum class Cells : std::int32_t {
    handed_in = 0,  // those of the seeds that it handed in, in their order
    made = 1,       // those of the seeds in its region, ascending by id; saves an exchange. Dropped seeds are in none
};

// Sums over all ranks, the same on each.
struct Counts {
    std::uint64_t seeds = 0;
    std::uint64_t largest_block = 0;  // seeds of the largest block
    std::uint64_t given = 0;          // seeds that ranks got from others to clip their cells
    std::uint64_t needed = 0;         // neighbors of the rank's cells among these
    std::uint64_t tested = 0;         // cells whose vertices were compared with boxes of unknown seeds
    std::uint64_t questions = 0;      // requests: cells sent to other ranks, once for each rank
    std::uint64_t bytes = 0;          // sent between ranks: seeds, requests, replies and cells
    unsigned rounds = 2;              // exchanges of seeds between blocks
    std::uint64_t exact_cells = 0;    // cells where exact arithmetic decided a sign
    double box_volume = 0;            // volume of the domain
    double volume_sum = 0;            // of all cells; 0 when volumes were not requested
};

// BlockCells::owners are the ranks that handed the neighbors in. Dropped seeds have the status `outside` on the rank
// that handed them in, and are on no rank with Cells::made.
struct Result {
    std::vector<std::int64_t> ids;  // N
    std::vector<double> points;     // (N, 3), in the plane (N, 2), only for Cells::made
    std::vector<double> weights;    // N in a power diagram (squares of radii too); else none
    BlockCells cells;
    // Which ids to exchange before using a field of the neighbors; only for Cells::handed_in. Rank r needs the values
    // of ids send[send_indptr[r] .. send_indptr[r + 1]) and sends those of receive[receive_indptr[r] ..); each
    // ascends.
    std::vector<std::int64_t> send_indptr, receive_indptr;  // ranks + 1
    std::vector<std::int64_t> send, receive;
    Options options;  // with the box that was used
    Counts counts;
};

// Returns the cells of this rank. Collective.
// points: (N, 3), in the plane (N, 2), of this rank; N may be 0. ids: N, at least 0 and unique over all ranks; or none
// on any rank, which numbers the seeds rank after rank. The lowest id of duplicates keeps the cell. options: the same
// on all ranks, except weights and radii (N, of this rank), threads and progress. progress is called while the rank
// finds its cells; when it returns false on one rank, all ranks stop. cells: the same on all ranks. Throws Error as
// votess::tessellate(), and `unsupported` for vertices, faces, min_face, min_area, duplicates = error, meshes and GPUs,
// and in a domain without end for a cell that weights leave empty near the seeds. When one rank fails, all ranks throw
// the same error. It names the rank and the index of its point, or the number of the seed where there are no ids.
[[nodiscard]] VOTESS_API Result tessellate(MPI_Comm comm, std::span<const double> points,
                                           std::span<const std::int64_t> ids = {}, const Options& options = {},
                                           Cells cells = Cells::handed_in);

// Returns the walls of votess::hull_walls() around the points of all ranks, for Options::walls. Collective; the walls
// are the same on all ranks. Ranks exchange the corners of their hulls. points: (N, 3), in the plane (N, 2), of this
// rank.
[[nodiscard]] VOTESS_API std::vector<Wall> hull_walls(MPI_Comm comm, std::span<const double> points,
                                                      const Options& options = {});

// Checks the result of tessellate() as votess::verify() does, across ranks. Collective; the report is the same on all
// ranks. points: those that were handed in; none for Cells::made. options: the same on all ranks. Throws Error as
// tessellate().
[[nodiscard]] VOTESS_API VerifyReport verify(MPI_Comm comm, const Result& result, std::span<const double> points,
                                             const VerifyOptions& options = {});

}  // namespace votess::mpi
