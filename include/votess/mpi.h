// C interface of votess/mpi.hpp, which describes the method and the arrays; in the library votess_mpi. Rules, options
// and errors are those of votess/votess.h.
#ifndef VOTESS_MPI_H
#define VOTESS_MPI_H

#include <mpi.h>
#include <votess/votess.h>

#ifdef __cplusplus
extern "C" {
#endif

#define VOTESS_MPI_HANDED_IN 0  // cells of the seeds that the rank handed in, in their order
#define VOTESS_MPI_MADE 1       // cells of the seeds in the rank's region, ascending by id; of no dropped seeds

// The fields of Counts in mpi.hpp.
typedef struct votess_mpi_counts {
    uint32_t struct_size;  // set it to sizeof(votess_mpi_counts) before votess_mpi_read_counts
    uint32_t rounds;
    uint64_t seeds, largest_block, given, needed, tested, questions, bytes;
    double box_volume, volume_sum;
    uint64_t exact_cells;
} votess_mpi_counts;

typedef struct votess_mpi_result votess_mpi_result;

// Returns sizeof(MPI_Comm) in the MPI of the library, for callers that do not include its header.
VOTESS_API size_t votess_mpi_sizeof_comm(void);

// Walls around the convex hull of the points of all ranks, as those of votess_hull_new(). Collective; free them by
// votess_hull_free().
VOTESS_API votess_status votess_mpi_hull_new(MPI_Comm comm, const double* points, size_t count,
                                             const votess_options* options, votess_hull** out);

// Tessellates the seeds of all ranks. Collective. On success *out is a new result on every rank; else it is NULL, with
// the same error on every rank. points: 3 * count coordinates of this rank, in the plane 2 * count; NULL only when
// count is 0. ids: count, or NULL on all ranks that have seeds. options: NULL = defaults; weights and radii belong to
// this rank's points; progress is called while this rank finds its cells and stops all ranks; log is not called. cells:
// VOTESS_MPI_*.
VOTESS_API votess_status votess_mpi_tessellate(MPI_Comm comm, const double* points, size_t count, const int64_t* ids,
                                               const votess_options* options, int32_t cells, votess_mpi_result** out);
VOTESS_API void votess_mpi_free(votess_mpi_result* result);

// Sets *array to an array of N cells, see votess_array. Orders as in Result and BlockCells of mpi.hpp. d: 2 in the
// plane, else 3. R: ranks.
//   int64_t   ids (N), indptr (N + 1), indices (indptr[N]), send_indptr (R + 1), send, receive_indptr (R + 1), receive
//   int64_t   duplicate_of (N), where seeds are equal
//   int32_t   owners (indptr[N]), ranks
//   double    points (N, d), with VOTESS_MPI_MADE; box (2, 3), as given or assumed, empty for a triclinic one
// and, with the names and types of votess_result_array, shifts, status, and those (N) and (indptr[N]) that options.want
// can ask for.
VOTESS_API votess_status votess_mpi_array(const votess_mpi_result* result, const char* name, votess_array* array);
VOTESS_API votess_status votess_mpi_read_counts(const votess_mpi_result* result, votess_mpi_counts* counts);
// Checks a result, see verify() in mpi.hpp. Collective. points: the 3 * count coordinates that were handed in; NULL and
// 0 for VOTESS_MPI_MADE. The other arguments are those of votess_verify: all cells are proven if they
// passed and `unproven` is "".
VOTESS_API votess_status votess_mpi_verify(MPI_Comm comm, const votess_mpi_result* result, const double* points,
                                           size_t count, size_t sample, uint64_t rng_seed, int* passed,
                                           uint32_t* skipped, size_t* sampled, char* failure, size_t failure_size,
                                           char* unproven, size_t unproven_size);

#ifdef __cplusplus
}
#endif

#endif
