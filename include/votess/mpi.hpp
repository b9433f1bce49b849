// One tessellation over the ranks of an MPI communicator. The library is votess_mpi; libvotess itself does not use MPI.
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
    std::uint64_t seeds = 0;          // of all ranks
    std::uint64_t largest_block = 0;  // seeds of the largest
    std::uint64_t given = 0;          // seeds that ranks got from others to clip their cells
    std::uint64_t needed = 0;         // of these, neighbors of the rank's cells
    std::uint64_t tested = 0;         // cells whose vertices were compared with boxes of unknown seeds
    std::uint64_t questions = 0;      // cells sent to other ranks, once for each
    std::uint64_t bytes = 0;          // that ranks sent to others: seeds, requests, replies and cells
    unsigned rounds = 2;              // exchanges of seeds between blocks
    std::uint64_t exact_cells = 0;    // cells where exact arithmetic decided a sign
    double box_volume = 0;            // of the domain
    double volume_sum = 0;            // of all cells; 0 when volumes were not wanted
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
// all ranks stop. Errors are those of tessellate(). Vertices, faces, min_face, min_area, duplicates =
// error and GPUs are `unsupported`. If one rank fails, all throw the same error, which names the rank and the index of
// its point, or without ids the number that this point gets.
[[nodiscard]] VOTESS_API Result tessellate(MPI_Comm comm, std::span<const double> points,
                                           std::span<const std::int64_t> ids = {}, const Options& options = {},
                                           Cells cells = Cells::handed_in);

// Checks what tessellate() returned, as verify() does. Collective; the report is the same on all ranks. The sample of
// all cells is clipped by every seed of every rank. Owners (BlockCells::tags) of Cells::handed_in are checked with the
// pairs. points: those that were handed in; none for Cells::made. Throws invalid_argument when arrays do not fit.
[[nodiscard]] VOTESS_API VerifyReport verify(MPI_Comm comm, const Result& result, std::span<const double> points,
                                             const VerifyOptions& options = {});

}  // namespace votess::mpi
