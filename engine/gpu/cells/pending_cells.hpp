// Cells that wait for the exact clipper, each with the reason why the device left it. Knows no Vulkan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/domain/parts.hpp"
#include "output/exact_clipper.hpp"
#include "output/result_builder.hpp"

namespace votess::gpu {

class PendingCells {
public:
    using Reason = std::uint64_t FallbackReasons::*;

    // Drops the cells and the counts.
    void reset();
    // cell: input index.
    void add(std::int32_t cell, Reason reason);

    struct Left {
        std::size_t to_cpu = 0;
        std::size_t beside = 0;  // seeds beside the part, which get no cell
    };
    // Adds the cells that a chunk leaves. info, order: status and member of each of its cells.
    Left add_left(std::span<const std::uint32_t> info, std::span<const std::uint32_t> order, const Part& part,
                  ThreadPool& pool);

    // Clips them all on the CPU; none is pending then.
    void clip(ExactClipper& clipper, ResultBuilder& result, const Share& share);

    [[nodiscard]] bool empty() const { return cells_.empty(); }
    // Counts the cells that were clipped, without duplicates.
    [[nodiscard]] const FallbackReasons& reasons() const { return counts_; }

private:
    std::vector<std::int32_t> cells_;
    std::vector<Reason> reasons_;  // of each cell
    FallbackReasons counts_;
};

}  // namespace votess::gpu
