#include "cpu/walk/neighborhood.hpp"

#include "cpu/sort/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t least_table = 1 << 14;
constexpr std::size_t usual_vertices = 16;  // more than a cell of a stretch finds by itself
constexpr std::size_t usual_slabs = 2048;   // cells at the front of a stretch

std::size_t hash(std::int32_t id) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(id)) * 0x9e3779b97f4a7c15ull) >> 32;
}

}  // namespace

void Neighborhood::begin(const SortedSeeds& seeds, std::size_t first, std::size_t last, std::int32_t walls,
                         bool positions) {
    first_ = first;
    last_ = last;
    walls_ = walls;
    const std::size_t count = last - first;
    own_count_ = static_cast<std::uint32_t>(count);
    own_end_ = walls_ + static_cast<std::int32_t>(count);
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
    if (known_.empty()) known_.resize(usual_slabs * primary);
    handed_.assign(count + 1, {});
    free_slabs_.clear();
    slabs_ = 1;
    forget_strangers();
    spilled_.assign(count + 1, -1);
    done_.assign(count, 0);
    group_done_.assign(count / group_size + 1, 0);
    if (!positions) return;
    positions_.reserve(usual_vertices * count);  // so that later jobs allocate nothing
    owners_.reserve(usual_vertices * count);
    seeds_.resize(count);
    for (std::size_t s = 0; s < count; ++s)
        seeds_[s] = {{seeds.x[first + s], seeds.y[first + s], seeds.z[first + s], 0}};
    const bool moved = seeds.images != nullptr && seeds.images->any_moved();
    lows_.resize(moved ? count : 0);
    for (std::size_t s = 0; s < lows_.size(); ++s) {
        const auto& low = seeds.images->low(static_cast<std::int32_t>(first + s));
        lows_[s] = {{low[0], low[1], low[2], 0}};
    }
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

std::uint32_t Neighborhood::take_slab() {
    if (!free_slabs_.empty()) {
        const std::uint32_t slab = free_slabs_.back();
        free_slabs_.pop_back();
        return slab;
    }
    if ((slabs_ + 1) * primary > known_.size()) known_.resize(2 * known_.size());
    return slabs_++;
}

void Neighborhood::spill(std::size_t s, const KnownVertex& known) {
    spill_.push_back({known, spilled_[s]});
    spilled_[s] = static_cast<std::int32_t>(spill_.size() - 1);
}

std::span<const KnownVertex> Neighborhood::with_spilled(std::size_t s) {
    const KnownVertex* known = known_.data() + handed_[s].slab * primary;
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
    forget_strangers();
}

}  // namespace votess::cpu
