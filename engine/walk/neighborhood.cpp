#include "walk/neighborhood.hpp"

#include <numeric>

#include "index/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t min_table = 1 << 14;
constexpr std::size_t reserved_vertices = 16;  // more than a cell of a stretch finds by itself
constexpr std::size_t min_positions = 1 << 14;
constexpr std::size_t initial_slabs = 2048;  // cells at the front of a stretch

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
    if (table_.empty()) table_.resize(min_table);
    ids_.reserve(static_cast<std::size_t>(own_end_) + min_table / 2 + 1);
    ids_.resize(static_cast<std::size_t>(own_end_));
    for (std::int32_t wall = 0; wall < walls_; ++wall) ids_[wall] = -1 - wall;
    std::iota(ids_.begin() + walls_, ids_.end(), static_cast<std::int32_t>(first));
    std::fill(table_.begin(), table_.end(), -1);
    vertices_ = 0;
    ties_.clear();
    tie_powers_.assign(count + 1, no_tie);
    spill_.clear();
    if (known_.empty()) known_.resize(initial_slabs * slab_size);
    next_.assign(count + 1, 0);
    free_slabs_.clear();
    slabs_ = 1;
    clear_foreign();
    spilled_.assign(count + 1, -1);
    done_.assign(count, 0);
    group_done_.assign(count / group_size + block_groups, 0);
    if (!positions) return;
    if (positions_.size() < reserved_vertices * count) {  // so that later jobs allocate nothing
        positions_.resize(reserved_vertices * count);
        owners_.resize(reserved_vertices * count);
    }
    seeds_.resize(count);
    for (std::size_t s = 0; s < count; ++s)
        seeds_[s] = {{seeds.x[first + s], seeds.y[first + s], seeds.z[first + s], 0}};
    const bool moved = seeds.images != nullptr && seeds.images->any_wrapped();
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
        if (ids_[table_[at]] == id) return table_[at];
    const std::int32_t local = locals();
    table_[at] = local;
    ids_.push_back(id);
    if (static_cast<std::size_t>(local - own_end_) * 2 > table_.size()) grow_table();
    return local;
}

void Neighborhood::grow_table() {
    table_.assign(2 * table_.size(), -1);
    const std::size_t mask = table_.size() - 1;
    for (std::int32_t local = own_end_; local < locals(); ++local) {
        std::size_t at = hash(ids_[local]) & mask;
        while (table_[at] >= 0) at = (at + 1) & mask;
        table_[at] = local;
    }
}

void Neighborhood::grow_positions() {
    positions_.resize(std::max(min_positions, 2 * positions_.size()));
    owners_.resize(positions_.size());
}

void Neighborhood::give_slowly(const std::array<std::int32_t, 4>& cells, std::uint32_t vertex) {
    const auto& [p, a, b, c] = cells;
    give(a, p, c, b, vertex);
    give(b, p, a, c, vertex);
    give(c, p, b, a, vertex);
    clear_foreign();
}

void Neighborhood::give(std::int32_t cell, std::int32_t a, std::int32_t b, std::int32_t c, std::uint32_t vertex) {
    const std::size_t s = place_of(cell);
    std::uint32_t& next = next_[s];
    if (next % slab_size == 0 && !allocate_slab(s)) return spill(s, {{a, b, c}, vertex});
    known_[next++] = {{a, b, c}, vertex};
}

bool Neighborhood::allocate_slab(std::size_t s) {
    if (s == own_count_) {
        clear_foreign();
        return true;
    }
    if (next_[s] != 0) return false;
    std::uint32_t slab = slabs_;
    if (!free_slabs_.empty()) {
        slab = free_slabs_.back();
        free_slabs_.pop_back();
    } else if ((++slabs_ + 1) * slab_size > known_.size()) {
        known_.resize(2 * known_.size());
    }
    next_[s] = slab * slab_size + 1;
    return true;
}

void Neighborhood::spill(std::size_t s, const KnownVertex& known) {
    spill_.push_back({known, spilled_[s]});
    spilled_[s] = static_cast<std::int32_t>(spill_.size() - 1);
}

std::span<const KnownVertex> Neighborhood::with_spilled(std::size_t s) {
    const KnownVertex* end = known_.data() + next_[s];
    gathered_.assign(end - (slab_size - 1), end);
    for (std::int32_t node = spilled_[s]; node >= 0; node = spill_[node].next) gathered_.push_back(spill_[node].vertex);
    return gathered_;
}

std::int32_t Neighborhood::add_tie(std::span<const std::int32_t> cells) {
    const auto at = static_cast<std::int32_t>(ties_.size());
    ties_.push_back(static_cast<std::int32_t>(cells.size()));
    ties_.insert(ties_.end(), cells.begin(), cells.end());
    return at;
}

void Neighborhood::give_tie(std::span<const std::int32_t> cells, std::uint32_t vertex, double power) {
    const std::int32_t tie = add_tie(cells);
    for (const std::int32_t cell : cells.subspan(1)) {
        give(cell, -1 - tie, 0, 0, vertex);
        note_power(cell, power);
    }
    clear_foreign();
}

void Neighborhood::give_polygon(std::int32_t cell, std::span<const std::int32_t> neighbors, std::uint32_t vertex,
                                double power) {
    if (place_of(cell) == own_count_) return;
    if (neighbors.size() == 3)
        give(cell, neighbors[0], neighbors[1], neighbors[2], vertex);
    else
        give(cell, -1 - add_tie(neighbors), 1, 0, vertex);
    note_power(cell, power);
}

}  // namespace votess::cpu
