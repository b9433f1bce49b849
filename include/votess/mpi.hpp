// One tessellation over the ranks of an MPI communicator, by votess/blocks.hpp. The library is votess_mpi; libvotess
// itself knows no MPI.
//
// The rows do not depend on the number of ranks, nor on which rank hands in which seed: they are those of one
// tessellate() with all seeds. Volumes, centroids and areas agree with it to the digits promised.
#pragma once

#include <mpi.h>

#include "votess/block_cells.hpp"

namespace votess::mpi {

enum class Cells : std::int32_t {
    handed_in = 0,  // of the seeds that the rank handed in, in their order
    made = 1,       // of those that lie in the rank's region, ascending by id: saves an exchange
};

struct Counts {
    std::uint64_t seeds = 0;                  // of all ranks
    std::uint64_t largest_block = 0;          // seeds of the largest
    std::uint64_t given = 0, needed = 0;      // sums of BlockCounts over all ranks
    std::uint64_t tested = 0, questions = 0;  // the same
    std::uint64_t bytes = 0;                  // that ranks sent to others, of seeds, questions, answers and cells
    unsigned rounds = 2;                      // exchanges of seeds between blocks: layers, answers
    std::uint64_t exact_cells = 0;            // the same
    double box_volume = 0;                    // of the domain
    double volume_sum = 0;                    // of all cells; 0 when volumes were not wanted
};

// BlockCells::tags are the ranks that handed the neighbors in. Seeds that were dropped have status `outside`.
struct Result {
    std::vector<std::int64_t> ids;  // N
    std::vector<double> points;     // (N, 3), of Cells::made
    std::vector<double> weights;    // N in a power diagram, if need be squares of radii; else none
    BlockCells cells;
    // What fields must travel: rank r needs the values of ids send[send_indptr[r] .. send_indptr[r + 1]), and sends
    // those of receive[receive_indptr[r] ..); each ascends. Of Cells::handed_in alone.
    std::vector<std::int64_t> send_indptr, receive_indptr;  // ranks + 1
    std::vector<std::int64_t> send, receive;
    Options options;  // with the box that was settled
    Counts counts;
};

// Collective. points: (N, 3), of this rank, which may have none. ids: N, each 0 or more and unlike all others of all
// ranks; or none on any rank: seeds are numbered rank after rank. Of seeds at one place the lowest id has the cell.
// options: the same on all ranks, except weights and radii, which are N of this rank's own, and threads and progress,
// which are those of each rank. progress is called while the rank finds its cells; where it returns false on one rank
// all ranks stop. Errors as of BlockDomain and Block; where one rank fails all throw the same error, which names the
// rank, and indices of its own points, or where there are no ids the numbers that these get.
[[nodiscard]] VOTESS_API Result tessellate(MPI_Comm comm, std::span<const double> points,
                                           std::span<const std::int64_t> ids = {}, const Options& options = {},
                                           Cells cells = Cells::handed_in);

// Collective: checks what tessellate() returned, as verify() does; the report is the same on all ranks. Volumes sum to
// the domain's (relative 1e-9), rows ascend, each pair is in both rows, over borders of ranks too, Euler's formula
// holds, and a sample of all cells equals cells clipped anew by every seed of every rank. points: those that were
// handed in; none for Cells::made. Errors as of tessellate().
[[nodiscard]] VOTESS_API VerifyReport verify(MPI_Comm comm, const Result& result, std::span<const double> points,
                                             const VerifyOptions& options = {});

}  // namespace votess::mpi
