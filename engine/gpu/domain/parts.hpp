// More seeds than the device can hold at once are tessellated part by part: compact sets of seeds, each with the seeds
// around it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/domain/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

struct Part {
    std::vector<std::int32_t> members;  // input indices, own ones first; empty = all points are the part's own
    std::uint32_t own_count = 0;
    // Bounds in units from the box's lower corner within which all seeds are members; see KnnPush.
    std::uint64_t lower[3]{}, upper[3]{};
    std::uint32_t bounded = 0;
};

class Parts {
public:
    // At most `max_seeds` members a part. One part when all points fit; else duplicates are in none. Seeds outside of
    // the domain are in none at all.
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
};

}  // namespace votess::gpu
