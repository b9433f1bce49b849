#include "gpu/cells/pending_cells.hpp"

#include <algorithm>
#include <mutex>

#include "core/arithmetic.hpp"
#include "shared/config.h"

namespace votess::gpu {
namespace {

constexpr std::size_t cells_at_once = 4096;  // per task

PendingCells::Reason reason_of(std::uint32_t status) {
    switch (status) {
        case STATUS_NEEDS_EXACT:
            return &FallbackReasons::uncertain;
        case STATUS_PLANE_OVERFLOW:
        case STATUS_VERTEX_OVERFLOW:
            return &FallbackReasons::overflow;
        default:
            return &FallbackReasons::exhausted;
    }
}

}  // namespace

void PendingCells::reset() {
    cells_.clear();
    reasons_.clear();
    counts_ = {};
}

void PendingCells::add(std::int32_t cell, Reason reason) {
    cells_.push_back(cell);
    reasons_.push_back(reason);
}

PendingCells::Left PendingCells::add_left(std::span<const std::uint32_t> info, std::span<const std::uint32_t> order,
                                          const Part& part, ThreadPool& pool) {
    std::mutex mutex;  // of cells_, reasons_ and found
    Left found;
    pool.run(ceil_div(info.size(), cells_at_once), [&](std::size_t block, unsigned) {
        const std::size_t begin = block * cells_at_once, end = std::min(info.size(), begin + cells_at_once);
        std::vector<std::int32_t> cells;
        std::vector<Reason> reasons;
        std::size_t beside = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t member = order[i] & INDEX_MASK;
            if (member >= part.own_count) {  // also images of duplicates
                ++beside;
                continue;
            }
            const std::uint32_t status = info[i] & 0xff;
            if (status == STATUS_CERTIFIED || status == STATUS_DUPLICATE || status == STATUS_EMPTY) continue;
            cells.push_back(part.members.empty() ? static_cast<std::int32_t>(member) : part.members[member]);
            reasons.push_back(reason_of(status));
        }
        const std::lock_guard lock(mutex);
        found.to_cpu += cells.size();
        found.beside += beside;
        cells_.insert(cells_.end(), cells.begin(), cells.end());
        reasons_.insert(reasons_.end(), reasons.begin(), reasons.end());
    });
    return found;
}

void PendingCells::clip(ExactClipper& clipper, ResultBuilder& result, const Share& share) {
    clipper.clip(cells_, result, share);
    for (std::size_t k = 0; k < cells_.size(); ++k)
        if (clipper.has_cell(cells_[k])) ++(counts_.*reasons_[k]);
    cells_.clear();
    reasons_.clear();
}

}  // namespace votess::gpu
