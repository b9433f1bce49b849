// The checked input of every engine.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/measure_unit.hpp"
#include "domain/domain.hpp"
#include "input/settled.hpp"
#include "votess/votess.hpp"

namespace votess {

class Snapshot;

// The seeds of the rows, if these are not all.
class Subset {
public:
    explicit Subset(std::vector<std::int32_t> ids) : ids_(std::move(ids)) {
        rows_.reserve(ids_.size());
        for (const std::int32_t id : ids_) rows_.emplace_back(id, static_cast<std::int32_t>(rows_.size()));
        std::ranges::sort(rows_);
    }
    [[nodiscard]] const std::vector<std::int32_t>& ids() const { return ids_; }
    // Returns the row of a seed, or -1.
    [[nodiscard]] std::int32_t row_of(std::int32_t id) const {
        const auto at = std::ranges::lower_bound(rows_, id, {}, &std::pair<std::int32_t, std::int32_t>::first);
        return at != rows_.end() && at->first == id ? at->second : -1;
    }

private:
    std::vector<std::int32_t> ids_;                            // by row
    std::vector<std::pair<std::int32_t, std::int32_t>> rows_;  // of ids, ascending
};

// A settled run in a domain with ends, with the power of two that brings it to order one. Copies share the domain,
// which took the weights.
struct Job : Settled {
    Box box;                // as given
    double box_volume = 0;  // of the domain, as given
    double scale = 1;
    std::shared_ptr<const Domain> domain;  // times scale
    std::vector<CellStatus> outside;       // N if seeds outside are dropped: `outside` for those
    std::vector<bool> beyond;              // N if seeds outside are kept: whether a seed is one
    std::shared_ptr<const Subset> only;    // the checked subset; null: all seeds have rows
    // N: the place of each seed in the order of the rows, if that is not the order of the indices. The last digits of
    // measures depend on this order alone.
    std::span<const std::int32_t> row_order;
    bool reports_weights = false;  // whether the result has them
    // Number of seeds if the points are queries among them; their cells do not form a diagram.
    std::optional<std::int32_t> probes_of;
    // Arrays of an earlier run; ResultBuilder::begin() takes their memory. May be null.
    detail::Result* arrays = nullptr;
    // Owner of the points. An engine that needs them no more may use its memory(). May be null.
    Snapshot* snapshot = nullptr;

    [[nodiscard]] MeasureUnit unit() const { return {1 / scale, region.thickness}; }
    [[nodiscard]] std::size_t rows() const { return only ? only->ids().size() : points.count(); }
};

}  // namespace votess
