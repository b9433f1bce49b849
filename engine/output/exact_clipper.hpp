// The interface of the CPU's exact clipper, which finishes uncertified cells for every engine.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/progress.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"
#include "output/result_builder.hpp"

namespace votess {

// Rows of some cells, one after the other: input indices, and walls, which are ignored.
struct NeighborLists {
    std::span<const std::int32_t> cells;
    std::span<const std::uint32_t> lengths;
    std::span<const std::int32_t> ids;
    std::span<const std::array<std::int8_t, 3>> shifts;  // one for each id in a periodic domain, else empty
};

// One call at a time, from any thread. The calling thread works with the pool's threads.
class ExactClipper {
public:
    virtual ~ExactClipper() = default;

    // Begins a job, whose points must stay valid until end(). Seeds are sorted and the search structure is built on
    // first need.
    virtual void begin(const Job& job) = 0;
    // Has job.threads threads, is kept between jobs, and is free whenever no call of the clipper runs.
    virtual ThreadPool& pool() = 0;

    // Sorts and builds now, once a job, for a thread that would otherwise wait. Throws invalid_argument when there are
    // duplicates and the options refuse them.
    virtual void prepare() = 0;
    // Returns N indices as in the result, or none if all seeds differ. Valid until end().
    virtual std::span<const std::int32_t> duplicate_of() = 0;
    // Clips the cells of these seeds (input indices in any order, each once). Stores rows, geometry and counts, sets
    // their status to `certified` or `empty`, and counts them as fallback cells. Skips seeds without a cell. Calls
    // options.progress from the calling thread, with fractions of this share of the run. Throws `cancelled` on its
    // request.
    virtual void clip(std::span<const std::int32_t> cells, ResultBuilder& out, const Share& share) = 0;

    // Whether this seed has a cell, which clip() would make.
    [[nodiscard]] virtual bool has_cell(std::int32_t cell) const = 0;

    // Makes cells from their known neighbors alone, each cell once, in float64, and stores the same as clip(). They do
    // not count as fallback cells. Throws as clip().
    virtual void clip_listed(const NeighborLists& lists, ResultBuilder& out, const Share& share) = 0;

    // Sets the status of seeds without a cell, except duplicates: outside of walls, or lighter than another seed at the
    // same place.
    virtual void set_empty(ResultBuilder& out) = 0;

    // Ends the job, not before ResultBuilder::finish(). Threads and memory stay for the next.
    virtual void end() = 0;
};

}  // namespace votess
