// Parts of a job with more seeds than a device holds at once. A part is a compact set of seeds, with the seeds around
// it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/domain/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

// What a device has of all seeds and images.
struct KnownSeeds {
    // Seeds with an index of at least this are beside the part and get no cell.
    std::uint32_t own_count = 0;
    // Bounds in units from the box's lower corner. All seeds within them are known; see KnnPush.
    std::uint64_t lower[3]{}, upper[3]{};
    std::uint32_t bounded = 0;
    // Units by which the own seeds repeat along each axis; 0 where they do not, and where edges are oblique.
    std::uint64_t period[3]{};
};

struct Part : KnownSeeds {
    std::vector<std::int32_t> members;  // input indices, own seeds first; empty: all points are the part's own
};

class Parts {
public:
    // Makes parts of at most `max_seeds` members. One part when all points fit; else duplicates are in no part. Seeds
    // that were dropped are in no part either. Seeds beyond walls are beside the only part.
    Parts(const Job& job, std::span<const std::int32_t> duplicate_of, const Box& box, std::uint32_t max_seeds);

    [[nodiscard]] std::size_t size() const { return ends_.size(); }
    [[nodiscard]] Part get(std::size_t index) const;

private:
    void split(std::size_t begin, std::size_t end, std::size_t max_own);
    [[nodiscard]] Box bounds(std::size_t begin, std::size_t end) const;

    const Job& job_;
    Box box_;  // the device's
    Units units_;
    std::uint32_t max_seeds_;
    std::vector<std::int32_t> order_;  // part by part; empty when all points are in one
    std::vector<std::size_t> ends_;    // of each part in the order
    std::size_t inside_ = 0;           // own seeds of the only part
};

}  // namespace votess::gpu
