// The result while engines fill it: arrays in input order, and rows of neighbors that wait, block by block and
// in the order of the engine, until all lengths are known. What is called from several threads says so.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "core/arena.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"
#include "mesh/mesh_builder.hpp"
#include "output/small_faces.hpp"
#include "result/result.hpp"

namespace votess {

struct CellCounters {
    std::uint64_t faces = 0;           // of the cells counted, walls included
    std::uint64_t exact_cells = 0;     // where exact arithmetic decided a sign
    std::uint64_t fallback_cells = 0;  // redone on the CPU after another device
    std::uint64_t empty_cells = 0;     // without interior, or outside; not duplicates
};

// Beside the ids of rows, one for each or three; empty when they are not wanted.
struct RowValues {
    std::span<const double> areas, normals;
    std::span<const std::int8_t> shifts;
};

class ResultBuilder {
public:
    // Sizes the arrays that the job wants, in the memory of job.arrays if there is any. Every cell is certified and its
    // row empty; the other arrays are not initialized: the engine writes them for each cell but duplicates.
    void begin(const Job& job, ThreadPool& pool);

    // The arrays of N, centroids 3N; those not wanted are empty. Threads may write different cells at once. finish()
    // takes a cell whose status is a reason to hand it on for a bug.
    [[nodiscard]] std::span<CellStatus> status() { return result_.status; }
    [[nodiscard]] std::span<double> volumes() { return result_.volumes; }
    [[nodiscard]] std::span<double> centroids() { return result_.centroids; }
    [[nodiscard]] std::span<double> surface_areas() { return result_.surface_areas; }
    [[nodiscard]] std::span<double> security_radii() { return result_.security_radii; }
    [[nodiscard]] std::span<std::uint32_t> face_counts() { return result_.face_counts; }
    [[nodiscard]] std::span<std::uint32_t> edge_counts() { return result_.edge_counts; }
    [[nodiscard]] std::span<std::uint32_t> vertex_counts() { return result_.vertex_counts; }

    // From any thread. ids: rows of `cells` (input indices) one after the other, each ascending (then by shift, when
    // the domain is periodic); lengths[k] of them belong to cells[k]. values: those that are wanted. A cell of length 0
    // has no row here and may get one by another call. `cells` must stay as it is until finish(), see allocate_cells();
    // the other arrays are the caller's again on return. Large results finish faster in blocks of some thousand cells
    // or less. Does nothing when neighbors are not wanted.
    void add_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                  std::span<const std::int32_t> ids, const RowValues& values = {});
    // From any thread. The same, cut into blocks: `cells` too is the caller's again on return.
    void copy_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                   std::span<const std::int32_t> ids, const RowValues& values = {});
    // From any thread. Room for an array of cells that stays until finish().
    std::span<std::int32_t> allocate_cells(std::size_t count);
    // Records of the cells of these rows; from any thread.
    [[nodiscard]] MeshBuilder& mesh() { return mesh_; }
    // From any thread.
    void count(const CellCounters& counters);
    // From any thread. Faces of cells whose areas are good to double precision.
    void count(const FaceTally& faces);

    // From any thread. A cell that is not there: volume and counts 0, centroid NaN.
    void set_empty(std::size_t i, CellStatus status);
    // duplicate_of: N, or empty when there are none. Gives the duplicates their status, volume and counts 0, centroid
    // NaN.
    void set_duplicates(std::span<const std::int32_t> duplicate_of, ThreadPool& pool);

    // For engines that have rows in the order of the input: puts the rows that wait into place, beside room for later
    // ones. later: N lengths, 0 for cells with a row that waits; or none. No other call adds rows from here on.
    void settle(std::span<const std::uint32_t> later, ThreadPool& pool);
    // From any thread, after settle(). The rows of the cells from `first` on, one after the other, and their lengths as
    // settle() was told.
    void place_rows(std::size_t first, std::span<const std::uint32_t> lengths, std::span<const std::int32_t> ids,
                    const RowValues& values = {});

    // Settles where that has not been done, and fills everything of the result but stats.device and stats.seconds,
    // which it leaves alone. The builder keeps no array of the result, but its own memory, for the next begin().
    void finish(detail::Result& result, ThreadPool& pool);

private:
    struct Block {
        std::span<const std::int32_t> cells;  // those that have a row here
        std::span<const std::int32_t> ids;
        RowValues values;
    };

    // Throws when they are not those wanted, each of the right size.
    void check_values(const RowValues& values, std::size_t ids) const;
    // Notes the lengths; whether some are 0.
    bool set_lengths(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths, std::size_t ids);
    void push(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
              std::span<const std::int32_t> ids, const RowValues& values, bool copy_cells);
    template <class T>
    [[nodiscard]] std::span<const T> keep_copy(std::span<const T> values);
    void check_status(ThreadPool& pool) const;
    void sum_lengths(std::span<const std::uint32_t> later, ThreadPool& pool);
    void place_block(const Block& block);
    // Copies rows, or one, that begin at these entries.
    void copy_entries(const std::int32_t* ids, const RowValues& values, std::size_t from, std::size_t to,
                      std::size_t count);
    void finish_stats(Stats& stats, ThreadPool& pool) const;
    void measure_polygons(ThreadPool& pool);
    void count_tiny_faces(Stats& stats) const;

    bool want_neighbors_ = false, want_areas_ = false, want_normals_ = false, want_shifts_ = false;
    bool settled_ = false;
    double min_face_ = 0, min_area_ = 0;
    double box_volume_ = 0, scale_ = 1;
    detail::Result result_;  // indptr[i + 1] holds the length of row i until settle()
    std::mutex mutex_;       // of what follows
    Arena memory_;
    std::vector<Block> blocks_;
    CellCounters counters_;
    FaceTally faces_;
    MeshBuilder mesh_;
};

}  // namespace votess
