#include "cpu/neighborhood.hpp"

#include <algorithm>

namespace votess::cpu {
namespace {

constexpr std::size_t least_table = 1 << 14;

std::size_t hash(std::int32_t id) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(id)) * 0x9e3779b97f4a7c15ull) >> 32;
}

}  // namespace

void Neighborhood::begin(const SortedSeeds& seeds, std::size_t first, std::size_t last, bool positions) {
    first_ = first;
    last_ = last;
    const std::size_t count = last - first;
    own_end_ = walls + static_cast<std::int32_t>(count);
    keep_positions_ = positions;
    foreign_ids_.clear();
    if (table_.empty()) table_.resize(least_table);
    std::fill(table_.begin(), table_.end(), -1);
    vertex_count_ = 0;
    if (positions) {
        positions_.resize(vertices_.size());
        seeds_.resize(std::max(seeds_.size(), count));
        for (std::size_t s = 0; s < count; ++s) seeds_[s] = {{seeds.x[first + s], seeds.y[first + s], seeds.z[first + s], 0}};
    }
    // One more for cells of other stretches, which get nothing.
    known_.resize(std::max(known_.size(), (count + 1) * primary));
    known_count_.assign(count + 1, 0);
    spilled_.assign(count + 1, -1);
    spill_.clear();
    done_.assign(count, 0);
    group_done_.assign(count / group_size + 1, 0);
}

void Neighborhood::set_done(std::size_t seed) {
    done_[seed - first_] = 1;
    ++group_done_[(seed - first_) / group_size];
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

void Neighborhood::spill(std::size_t s, KnownVertex vertex) {
    spill_.push_back({vertex, spilled_[s]});
    spilled_[s] = static_cast<std::int32_t>(spill_.size() - 1);
}

}  // namespace votess::cpu
