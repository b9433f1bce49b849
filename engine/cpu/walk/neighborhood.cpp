#include "cpu/walk/neighborhood.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t least_table = 1 << 14;
constexpr std::size_t usual_vertices = 16;  // more than a cell of a stretch finds by itself

std::size_t hash(std::int32_t id) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(id)) * 0x9e3779b97f4a7c15ull) >> 32;
}

}  // namespace

void Neighborhood::begin(const SortedSeeds& seeds, std::size_t first, std::size_t last, bool positions) {
    first_ = first;
    last_ = last;
    const std::size_t count = last - first;
    own_count_ = static_cast<std::uint32_t>(count);
    own_end_ = walls + static_cast<std::int32_t>(count);
    keep_positions_ = positions;
    foreign_ids_.clear();
    if (table_.empty()) {
        table_.resize(least_table);
        foreign_ids_.reserve(least_table / 2 + 1);
    }
    std::fill(table_.begin(), table_.end(), -1);
    vertices_ = 0;
    positions_.clear();
    owners_.clear();
    ties_.clear();
    spill_.clear();
    if (known_.size() < (count + 1) * primary) known_.resize((count + 1) * primary);
    known_count_.assign(count + 1, 0);
    spilled_.assign(count + 1, -1);
    done_.assign(count, 0);
    group_done_.assign(count / group_size + 1, 0);
    if (!positions) return;
    positions_.reserve(usual_vertices * count);  // so that later jobs allocate nothing
    owners_.reserve(usual_vertices * count);
    seeds_.resize(count);
    for (std::size_t s = 0; s < count; ++s)
        seeds_[s] = {{seeds.x[first + s], seeds.y[first + s], seeds.z[first + s], 0}};
}

std::int32_t Neighborhood::foreign(std::int32_t id) {
    const std::size_t mask = table_.size() - 1;
    std::size_t at = hash(id) & mask;
    for (; table_[at] >= 0; at = (at + 1) & mask)
        if (foreign_ids_[table_[at]] == id) return own_end_ + table_[at];
    const auto index = static_cast<std::int32_t>(foreign_ids_.size());
    table_[at] = index;
    foreign_ids_.push_back(id);
    if (foreign_ids_.size() * 2 > table_.size()) grow_table();
    return own_end_ + index;
}

void Neighborhood::grow_table() {
    table_.assign(2 * table_.size(), -1);
    const std::size_t mask = table_.size() - 1;
    for (std::size_t i = 0; i < foreign_ids_.size(); ++i) {
        std::size_t at = hash(foreign_ids_[i]) & mask;
        while (table_[at] >= 0) at = (at + 1) & mask;
        table_[at] = static_cast<std::int32_t>(i);
    }
}

void Neighborhood::spill(std::size_t s, const KnownVertex& known) {
    spill_.push_back({known, spilled_[s]});
    spilled_[s] = static_cast<std::int32_t>(spill_.size() - 1);
}

std::span<const KnownVertex> Neighborhood::with_spilled(std::size_t s) {
    const KnownVertex* known = known_.data() + s * primary;
    gathered_.assign(known, known + primary);
    for (std::int32_t node = spilled_[s]; node >= 0; node = spill_[node].next) gathered_.push_back(spill_[node].vertex);
    return gathered_;
}

void Neighborhood::add_tie(std::span<const std::int32_t> cells, const Four& position) {
    const std::uint32_t index = add_position(cells[0], position);
    const auto at = static_cast<std::int32_t>(ties_.size());
    ties_.push_back(static_cast<std::int32_t>(cells.size()));
    ties_.insert(ties_.end(), cells.begin(), cells.end());
    for (const std::int32_t cell : cells.subspan(1)) give(cell, -1 - at, 0, 0, index);
    known_count_[own_count_] = 0;
}

}  // namespace votess::cpu
