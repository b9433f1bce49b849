// C interface of votess/stream.hpp, which describes the method and the arrays. Rules, options and errors are those of
// votess/votess.h.
#ifndef VOTESS_STREAM_H
#define VOTESS_STREAM_H

#include <votess/votess.h>

#ifdef __cplusplus
extern "C" {
#endif

// Some seeds, in input order. The caller keeps the arrays until the next callback.
typedef struct votess_stream_seeds {
    size_t count;           // at most 2^31 - 1
    const double* points;   // 3 * count, in the plane 2 * count, as all vectors
    const double* weights;  // count, or NULL; at most one of weights and radii
    const double* radii;    // count, or NULL
} votess_stream_seeds;

// Known before the first row.
typedef struct votess_stream_head {
    uint64_t seeds;
    uint64_t entries;                   // of all rows; 0 when neighbors were not requested
    int32_t duplicates;                 // 1 when there are any
    int32_t periodic;                   // 1 when rows have shifts
    double box_lower[3], box_upper[3];  // the box that was given or assumed; 0 where a cell was given
} votess_stream_head;

// The cells of `count` seeds from `first` on, until the callback returns.
typedef struct votess_stream_rows {
    uint64_t first;
    size_t count, entries;
    const void* cells;  // for votess_stream_array
} votess_stream_rows;

// Sets *array to an array of rows, see votess_array; one that was not requested is empty. Names and types are those of
// votess_result_array, except that ids have 64 bits:
//   int64_t   indptr (count + 1), counted from the first seed of the run; indices (entries)
//   int64_t   duplicate_of (count); empty in a run without duplicates
// and shifts, status, and those (N) and (indptr[N]) that options.want can ask for.
VOTESS_API votess_status votess_stream_array(const votess_stream_rows* rows, const char* name, votess_array* array);

// Values that callbacks return. They run in the thread of the call; VOTESS_STREAM_STOP ends it with
// VOTESS_ERROR_CANCELLED.
#define VOTESS_STREAM_STOP (-1)
#define VOTESS_STREAM_END 0  // next: no more seeds; restart: the seeds can be read only once
#define VOTESS_STREAM_GO_ON 1

typedef struct votess_stream {
    uint32_t struct_size;   // set it to sizeof(votess_stream)
    int32_t verify;         // 1: check all rows on their way to the caller; or 0
    uint64_t memory;        // bytes, at least 1,000,000, see StreamOptions in stream.hpp
    const char* temporary;  // folder of temporary files; NULL or "": that of TMPDIR, or /tmp; on Windows the user's
    // Goes back to the first seed; called first and once more. NULL: the seeds can be read only once.
    int (*restart)(void* user);
    // Writes the next seeds to *seeds, which is all 0.
    int (*next)(votess_stream_seeds* seeds, void* user);
    int (*begin)(const votess_stream_head* head, void* user);  // may be NULL
    int (*rows)(const votess_stream_rows* rows, void* user);
    void* user;
    int32_t hull;  // 1: the domain is the convex hull of all seeds, see StreamOptions in stream.hpp; or 0
    int32_t reserved;
} votess_stream;

typedef struct votess_stream_counts {
    uint32_t struct_size;  // set it to sizeof(votess_stream_counts)
    int32_t reserved;
    uint64_t blocks, largest_block, asked_cells, temporary_bytes;  // see StreamResult in stream.hpp
    // With votess_stream.verify, else 0, see votess_verify():
    int32_t passed;           // 1 when all checks passed
    uint32_t checks_skipped;  // VOTESS_CHECK_* bits
    uint64_t sampled;         // cells clipped again by every seed
    char failure[256];        // one line of UTF-8 on the first failed check, cut to fit; "" when passed
    char unproven[128];       // the same on why not all cells are proven
} votess_stream_counts;

// Tessellates the seeds of a stream and calls its callbacks. options: NULL = defaults; without weights and radii.
// counts, stats: may be NULL.
VOTESS_API votess_status votess_tessellate_stream(const votess_stream* stream, const votess_options* options,
                                                  votess_stream_counts* counts, votess_stats* stats);

#ifdef __cplusplus
}
#endif

#endif
