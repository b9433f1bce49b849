#include "gpu/pending_cells.hpp"

namespace votess::gpu {

void PendingCells::reset() {
    cells_.clear();
    reasons_.clear();
    counts_ = {};
}

void PendingCells::add(std::int32_t cell, Reason reason) {
    cells_.push_back(cell);
    reasons_.push_back(reason);
}

void PendingCells::clip(ExactClipper& clipper, ResultBuilder& result, const Share& share) {
    clipper.clip(cells_, result, share);
    for (std::size_t k = 0; k < cells_.size(); ++k)
        if (clipper.takes(cells_[k])) ++(counts_.*reasons_[k]);
    cells_.clear();
    reasons_.clear();
}

}  // namespace votess::gpu
