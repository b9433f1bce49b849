// The exact clipper of the CPU as other engines see it: they hand it the cells that they could not certify.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/progress.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"
#include "output/result_builder.hpp"

namespace votess {

// Rows of some cells, one after the other: input indices, and walls, which count for nothing.
struct NeighborLists {
    std::span<const std::int32_t> cells;
    std::span<const std::uint32_t> lengths;
    std::span<const std::int32_t> ids;
    std::span<const std::array<std::int8_t, 3>> shifts;  // beside ids in a periodic domain, else empty
};

// One call at a time, from any thread; the calling thread works with the pool's.
class ExactClipper {
public:
    virtual ~ExactClipper() = default;

    // Begins a job, whose points must stay until end(). Cheap but for threads when their number changes: seeds are
    // sorted and searched first by whichever call below needs it.
    virtual void begin(const Job& job) = 0;
    // Threads as job.options.threads says. Kept between jobs; free whenever no call of the clipper is running.
    virtual ThreadPool& pool() = 0;

    // Sorts the seeds and builds the search structure now, once a job: for a thread that would otherwise wait.
    // Throws invalid_argument when there are duplicates and the options refuse them.
    virtual void prepare() = 0;
    // Returns what the result holds: N indices, or none when no two seeds are equal. They are valid until end().
    virtual std::span<const std::int32_t> duplicate_of() = 0;
    // Clips the cells of these seeds (input indices in any order, each once) and stores rows, geometry and counts;
    // their status becomes `certified` or `empty`, and they count as fallback cells. Seeds without a cell among them
    // are left as they are: they are for set_empty() and ResultBuilder::set_duplicates(). Calls options.progress from
    // the calling thread, with fractions of this share of the run, and throws `cancelled` when it says so.
    virtual void clip(std::span<const std::int32_t> cells, ResultBuilder& out, const Share& share) = 0;

    // Whether clip() takes this seed, which it was given.
    [[nodiscard]] virtual bool has_cell(std::int32_t cell) const = 0;

    // For cells whose neighbors are known, each cell once: makes their polytopes from these alone, in float64, and
    // stores what clip() would, though they do not count as fallback cells. Throws as clip().
    virtual void clip_listed(const NeighborLists& lists, ResultBuilder& out, const Share& share) = 0;

    // Tells of the seeds that have no cell, but for duplicates: outside of walls, or lighter than another at their
    // place.
    virtual void set_empty(ResultBuilder& out) = 0;

    // Forgets the job; threads and memory stay for the next. Not before ResultBuilder::finish().
    virtual void end() = 0;
};

}  // namespace votess
