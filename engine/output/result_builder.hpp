// The result while engines fill it: arrays in input order, and pending rows in the order of the engine. Functions may
// be called from one thread only unless they say otherwise.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "core/arena.hpp"
#include "core/page_stock.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"
#include "mesh/mesh_builder.hpp"
#include "output/near_rows.hpp"
#include "output/small_faces.hpp"
#include "result/result.hpp"

namespace votess {

struct CellCounters {
    std::uint64_t faces = 0;           // of the cells counted, walls included
    std::uint64_t exact_cells = 0;     // where exact arithmetic decided a sign
    std::uint64_t fallback_cells = 0;  // redone on the CPU after another device
    std::uint64_t empty_cells = 0;     // without interior, or outside; not duplicates
    std::uint64_t kept_cells = 0;      // not made, see follow/
};

// Values for the ids of rows, one or three for each id; empty if not requested.
struct RowValues {
    std::span<const double> areas, normals;
    std::span<const std::int8_t> shifts;
};

// A shift that is not 0.
struct RowShift {
    std::uint32_t row, entry;  // among the rows that have entries, and in that row
    std::array<std::int8_t, 3> shift;
};

class ResultBuilder {
public:
    // The most parts of the cells whose rows are placed one part after the other.
    static constexpr std::size_t max_parts = 4;

    // Sizes the arrays that the job requests, in the memory of job.arrays if any. Sets every cell to certified with an
    // empty row. The other arrays are not initialized: the engine writes them for each cell except duplicates.
    void begin(const Job& job, ThreadPool& pool);

    // Lends memory for pending rows, and its pages for the arrays of rows. It may have any contents, which are lost,
    // and stays as it is until finish().
    void lend(std::span<std::byte> memory) { stock_.put(memory); }

    // Makes the pages of a share of the arrays present, on all threads, so that later writes do not wait for them.
    // Shares ascend. row: expected entries of a row, 0 if unknown; then the arrays of rows wait for settle().
    void touch(double share, double row, ThreadPool& pool);

    // Engines write those by cell, except duplicate_of. Threads may write different cells at once. finish() throws if a
    // cell still has a hand-over status.
    [[nodiscard]] detail::Result& arrays() { return result_; }

    // Adds rows, from any thread. ids: the rows of `cells` (input indices) one after the other, each ascending (then by
    // shift, in a periodic domain); lengths[k] of them belong to cells[k]. values: the requested ones. A cell of length
    // 0 may get a row from another call. `cells` must stay valid until finish(), see allocate_cells(); the rest is
    // copied. Large results finish faster in blocks of at most some thousand cells. Does nothing if neighbors are not
    // requested.
    void add_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                  std::span<const std::int32_t> ids, const RowValues& values = {});
    // The same for `near`, which has no rows of length 0. near.input must stay valid until finish() too. shifts: those
    // that are not 0, instead of values.shifts.
    void add_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths, const NearRows& near,
                  const RowValues& values = {}, std::span<const RowShift> shifts = {});
    // Large lists are placed in parts: the memory of one part's pending rows becomes that of the next part's entries.
    // Whether there are parts, and the part of a cell.
    [[nodiscard]] bool has_parts() const { return has_parts_; }
    [[nodiscard]] std::size_t part_of(std::size_t cell) const { return cell >> part_bits_; }
    // Adds rows of cells of one part, copying `cells` too. No row has length 0. shifts: those that are not 0.
    void add_rows_of_part(std::size_t part, std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                          const NearRows& near, std::span<const RowShift> shifts);
    // Returns lent memory to the system that parts do not need.
    void release_spare();
    // Copies `cells` too, and cuts into blocks. From any thread.
    void copy_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                   std::span<const std::int32_t> ids, const RowValues& values = {});
    // Returns room for an array of cells until finish(). From any thread.
    std::span<std::int32_t> allocate_cells(std::size_t count);
    // Records of the cells of these rows. From any thread.
    [[nodiscard]] MeshBuilder& mesh() { return mesh_; }
    // From any thread.
    void count(const CellCounters& counters);
    // From any thread. Counts faces of cells whose areas are good to double precision.
    void count(const FaceTally& faces);

    // From any thread. Sets a missing cell: volume and counts 0, centroid NaN.
    void set_empty(std::size_t i, CellStatus status);
    // Sets the duplicates: status, volume and counts 0, centroid NaN. duplicate_of: N, or empty if there are none.
    // have_cells: sets the status alone.
    void set_duplicates(std::span<const std::int32_t> duplicate_of, ThreadPool& pool, bool have_cells = false);

    // Puts the pending rows into place and leaves room for later ones, for engines that have rows in input order.
    // later: N lengths, 0 for cells with a pending row; or none. No rows may be added from here on.
    void settle(std::span<const std::uint32_t> later, ThreadPool& pool);
    // Places the rows of the cells from `first` on, one after the other, with the lengths given to settle(). From any
    // thread, after settle().
    void place_rows(std::size_t first, std::span<const std::uint32_t> lengths, std::span<const std::int32_t> ids,
                    const RowValues& values = {});
    // The same for all rows from one cell to another, without values except shifts, which follow or are not requested.
    void place_run(std::size_t first, std::size_t end, std::span<const std::int32_t> ids,
                   std::span<const std::int8_t> shifts);
    // The same for cells in any order. Empty arrays are skipped.
    void place_each(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                    std::span<const std::int32_t> ids, const RowValues& values);

    // Settles if needed, and fills the result except stats.device and stats.seconds. The builder keeps its own memory
    // for the next begin(), but no array of the result.
    void finish(detail::Result& result, ThreadPool& pool);

private:
    struct Block {
        std::span<const std::int32_t> cells{};  // those that have a row here
        std::span<const std::int32_t> ids{};    // or `near`
        NearRows near{};
        std::span<const double> areas{}, normals{};
        std::span<const RowShift> shifts{};
    };

    void check_values(const RowValues& values, std::size_t ids, bool shifts) const;
    // Stores the lengths. Returns whether some are 0.
    bool set_lengths(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths, std::size_t ids);
    // block: its ids, copied, and its shifts unless they are among the values; push() copies the rest.
    void push(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths, Block block,
              const RowValues& values, bool copy_cells);
    template <class T>
    [[nodiscard]] std::span<const T> keep_copy(std::span<const T> values, Arena& memory);
    [[nodiscard]] std::span<const RowShift> keep_shifts(std::span<const std::uint32_t> lengths,
                                                        std::span<const std::int8_t> shifts);
    void check_status(ThreadPool& pool) const;
    // Sizes the arrays of rows.
    void resize_entries(std::size_t entries);
    // Makes their pages present up to this entry.
    void touch_entries(std::size_t end, ThreadPool& pool);
    void sum_lengths(std::span<const std::uint32_t> later, ThreadPool& pool);
    // Sizes an array of rows. components: of an entry. Returns whether it is new.
    template <class T>
    bool make_array(Buffer<T>& array, std::size_t components);
    // Makes its pages from one entry to another present, with pages of the stock if it is new. is_last: nothing else
    // needs the stock.
    template <class T>
    void make_present(Buffer<T>& array, std::size_t components, bool is_new, std::size_t begin, std::size_t end,
                      bool is_last, ThreadPool& pool);
    // Both, for all entries.
    template <class T>
    bool make_room(Buffer<T>& array, std::size_t components, bool is_last, ThreadPool& pool);
    // Calls place(k, begin, length) for the rows of cells: their entries in the result. Prefetches those of `array`.
    template <class T, class Place>
    void for_rows(std::span<const std::int32_t> cells, const Buffer<T>& array, std::size_t components,
                  Place place) const;
    void place_values(std::span<const double> Block::*values, Arena& memory, Buffer<double>& array,
                      std::size_t components, ThreadPool& pool);
    void place_shifts(ThreadPool& pool);
    void place_ids(const Block& block);
    void place_ids_of_parts(ThreadPool& pool);
    // Copies `count` entries, one or more rows.
    void copy_entries(const std::int32_t* ids, const RowValues& values, std::size_t from, std::size_t to,
                      std::size_t count);
    void finish_stats(Stats& stats, ThreadPool& pool) const;
    void measure_polygons(ThreadPool& pool);
    void count_tiny_faces(Stats& stats) const;

    bool want_neighbors_ = false, want_areas_ = false, want_normals_ = false, want_shifts_ = false;
    bool settled_ = false;
    bool has_parts_ = false;
    int part_bits_ = 0;                                    // of the cells of a part
    std::size_t touched_cells_ = 0, touched_entries_ = 0;  // with pages made present
    double min_face_ = 0, min_area_ = 0;
    double box_volume_ = 0, scale_ = 1;
    MeasureUnit unit_;
    detail::Result result_;  // indptr[i + 1] holds the length of row i until settle()
    std::mutex mutex_;       // guards the following members
    PageStock stock_;
    Arena cells_memory_, ids_memory_, areas_memory_, normals_memory_, shifts_memory_;
    std::vector<Block> blocks_;
    struct Part {
        Arena memory;  // of ids and cells
        std::vector<Block> blocks;
    };
    std::array<Part, max_parts> parts_;
    CellCounters counters_;
    FaceTally faces_;
    MeshBuilder mesh_;
};

}  // namespace votess
