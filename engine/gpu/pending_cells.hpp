// Cells that wait for the exact clipper, and why the device left each.
#pragma once

#include <cstdint>
#include <vector>

#include "output/exact_clipper.hpp"
#include "output/result_builder.hpp"

namespace votess::gpu {

class PendingCells {
public:
    using Reason = std::uint64_t FallbackReasons::*;

    // Forgets the cells and the counts.
    void reset();
    // cell: input index.
    void add(std::int32_t cell, Reason reason);
    // Has the clipper make them; none are left then.
    void clip(ExactClipper& clipper, ResultBuilder& result, const Share& share);

    [[nodiscard]] bool empty() const { return cells_.empty(); }
    // Counts all that were clipped, but no duplicates.
    [[nodiscard]] const FallbackReasons& reasons() const { return counts_; }

private:
    std::vector<std::int32_t> cells_;
    std::vector<Reason> reasons_;  // beside these
    FallbackReasons counts_;
};

}  // namespace votess::gpu
