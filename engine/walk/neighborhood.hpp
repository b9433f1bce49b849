// A stretch of the sorted seeds whose cells are built by one thread. Cells hand new vertices to the other cells that
// share them, so each vertex is computed once.
//
// Local ids of cells: first the walls (0..5 those of the box), then the seeds of the stretch, then other seeds in order
// of use.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "index/sorted_seeds.hpp"

namespace votess::cpu {

struct alignas(32) Four {
    double x[4];
};

// A vertex as seen by a cell: the three neighbors at the vertex, the outward normals of whose faces are positively
// oriented. A vertex with more neighbors refers to Neighborhood::tie().
struct alignas(16) KnownVertex {
    std::array<std::int32_t, 3> cells;  // local ids; cells[0] < 0 refers to a tie
    std::uint32_t vertex;               // number of its position, see Neighborhood::position()

    [[nodiscard]] bool is_tie() const { return cells[0] < 0; }
    // Whether the cells of the tie are the neighbors in the order of corner_polygon(), not all of its cells.
    [[nodiscard]] bool is_ordered() const { return cells[1] != 0; }
};

class Neighborhood {
public:
    // walls: their ids are -1 .. -walls.
    void begin(const SortedSeeds& seeds, std::size_t first, std::size_t last, std::int32_t walls, bool positions);

    [[nodiscard]] bool holds(std::int64_t seed) const {
        return seed >= static_cast<std::int64_t>(first_) && seed < static_cast<std::int64_t>(last_);
    }
    [[nodiscard]] bool overlaps(std::size_t begin, std::size_t end) const { return begin < last_ && end > first_; }
    // Returns the local id. id: a sorted seed, or a wall below 0.
    [[nodiscard, gnu::always_inline]] std::int32_t local(std::int32_t id) {
        const std::uint32_t place = static_cast<std::uint32_t>(id) - static_cast<std::uint32_t>(first_);
        if (place < own_count_) return walls_ + static_cast<std::int32_t>(place);
        return id < 0 ? -1 - id : foreign(id);
    }
    [[nodiscard]] std::int32_t id(std::int32_t local) const { return ids_[static_cast<std::size_t>(local)]; }
    // Whether a local id is a wall or a seed of the stretch.
    [[nodiscard]] bool is_own(std::int32_t local) const { return local < own_end_; }
    [[nodiscard]] std::int32_t locals() const { return static_cast<std::int32_t>(ids_.size()); }

    // Whether a cell of the stretch has handed over all of its vertices.
    [[nodiscard]] bool done(std::size_t seed) const { return done_[seed - first_] != 0; }
    void set_done(std::size_t seed) {
        done_[seed - first_] = 1;
        ++group_done_[(seed - first_) / group_size];
        release(seed - first_);
    }
    // Without a branch, which would be mispredicted.
    [[nodiscard]] bool group_done(std::size_t group) const {
        return group_done_[std::min(group - first_ / group_size, group_done_.size() - 1)] == group_size;
    }
    static constexpr std::size_t block_groups = 8;
    // The same for groups block * block_groups and on.
    [[nodiscard]] bool block_done(std::size_t block) const {
        constexpr std::uint64_t all = group_size * 0x0101010101010101;
        std::uint64_t done;
        static_assert(sizeof done == block_groups);
        const std::size_t begin = block * block_groups - first_ / group_size;
        std::memcpy(&done, &group_done_[std::min(begin, group_done_.size() - block_groups)], sizeof done);
        return done == all;
    }

    // When positions are kept: stores a vertex of a seed of the stretch. Returns its number in the stretch.
    [[gnu::always_inline]] std::uint32_t place(std::int32_t owner, const Four& position) {
        if (vertices_ == positions_.size()) grow_positions();
        positions_[vertices_] = position;
        owners_[vertices_] = owner - walls_;
        return vertices_++;
    }
    // Hands a vertex of cells[0], a seed of the stretch, to the other three cells. The normals of their faces are
    // positively oriented.
    [[gnu::always_inline]] void give(const std::array<std::int32_t, 4>& cells, std::uint32_t vertex) {
        const auto& [p, a, b, c] = cells;
        const std::size_t at_a = place_of(a), at_b = place_of(b), at_c = place_of(c);
        const std::uint32_t to_a = next_[at_a], to_b = next_[at_b], to_c = next_[at_c];
        if (to_a % slab_size == 0 || to_b % slab_size == 0 || to_c % slab_size == 0) return give_slowly(cells, vertex);
        // Even permutations of the four keep the orientation.
        const Record four{p, a, b, c}, last{static_cast<std::int32_t>(vertex)};
        record(to_a) = __builtin_shufflevector(four, last, 0, 3, 2, 4);
        record(to_b) = __builtin_shufflevector(four, last, 0, 1, 3, 4);
        record(to_c) = __builtin_shufflevector(four, last, 0, 2, 1, 4);
        next_[at_a] = to_a + 1;
        next_[at_b] = to_b + 1;
        next_[at_c] = to_c + 1;
        clear_foreign();
    }
    // Hands a vertex of more than four cells, in any order, to all but the first. power: its squared distance from a
    // seed, minus the weight of the seed.
    void give_tie(std::span<const std::int32_t> cells, std::uint32_t vertex, double power);
    // Hands such a vertex to one cell, with its neighbors in the order of corner_polygon().
    void give_polygon(std::int32_t cell, std::span<const std::int32_t> neighbors, std::uint32_t vertex, double power);

    // Returns the vertices that a seed of the stretch was given.
    [[nodiscard]] std::span<const KnownVertex> known(std::size_t seed) {
        const std::uint32_t next = next_[seed - first_], count = next % slab_size;
        if (count == 0 && next != 0) return with_spilled(seed - first_);
        return {known_.data() + (next - count + 1), count == 0 ? 0 : count - 1};
    }
    [[nodiscard]] std::span<const std::int32_t> tie(const KnownVertex& known) const {
        const auto at = static_cast<std::size_t>(-1 - known.cells[0]);
        return {ties_.data() + at + 1, static_cast<std::size_t>(ties_[at])};
    }

    // Returns the largest power of the ties that a seed of the stretch was given, or no_tie.
    [[nodiscard]] double power_of_ties(std::size_t seed) const { return tie_powers_[seed - first_]; }
    static constexpr double no_tie = -std::numeric_limits<double>::infinity();

    // When positions are kept: a vertex relative to its owner in x[0..3), with a bound on its error in x[3]. Owners and
    // seeds are indices in the stretch. Moved seeds are sums of two doubles.
    [[nodiscard]] const Four& position(std::uint32_t vertex) const { return positions_[vertex]; }
    [[nodiscard]] std::size_t owner(std::uint32_t vertex) const { return static_cast<std::size_t>(owners_[vertex]); }
    [[nodiscard]] const Four& seed_position(std::size_t place) const { return seeds_[place]; }
    [[nodiscard]] bool has_lows() const { return !lows_.empty(); }
    [[nodiscard]] const Four& seed_low(std::size_t place) const { return lows_[place]; }

private:
    // The vertices given to a seed are in a slab of known_, behind its first place, then in a linked list. Seeds that
    // are done return their slabs, so the front of the stretch stays in the cache.
    static constexpr std::uint32_t slab_size = 32;
    struct Spill {
        KnownVertex vertex;
        std::int32_t next;
    };

    using Record __attribute__((vector_size(16), may_alias)) = std::int32_t;  // a KnownVertex
    static_assert(sizeof(Record) == sizeof(KnownVertex));

    [[gnu::always_inline]] Record& record(std::uint32_t at) { return reinterpret_cast<Record&>(known_[at]); }
    // The same as give(), where a slab is missing or full.
    [[gnu::noinline]] void give_slowly(const std::array<std::int32_t, 4>& cells, std::uint32_t vertex);
    [[gnu::noinline]] std::int32_t foreign(std::int32_t id);
    void grow_table();
    [[gnu::noinline]] void grow_positions();
    void give(std::int32_t cell, std::int32_t a, std::int32_t b, std::int32_t c, std::uint32_t vertex);
    // Cells that are not of the stretch share a place behind it.
    [[nodiscard, gnu::always_inline]] std::size_t place_of(std::int32_t cell) const {
        return std::min(static_cast<std::uint32_t>(cell - walls_), own_count_);
    }
    void note_power(std::int32_t cell, double power) {
        double& largest = tie_powers_[place_of(cell)];
        largest = std::max(largest, power);
    }
    // Returns the place of a new tie.
    std::int32_t add_tie(std::span<const std::int32_t> cells);
    // Empties the slab of foreign cells, the first one. It is never full.
    void clear_foreign() { next_[own_count_] = 1; }
    // Returns false when the seed has a slab, which is full.
    bool allocate_slab(std::size_t s);
    void release(std::size_t s) {
        if (next_[s] > 0) free_slabs_.push_back((next_[s] - 1) / slab_size);
    }
    void spill(std::size_t s, const KnownVertex& known);
    [[nodiscard]] std::span<const KnownVertex> with_spilled(std::size_t s);

    std::size_t first_ = 0, last_ = 0;
    std::uint32_t own_count_ = 0;
    std::int32_t walls_ = 0, own_end_ = 0;
    std::uint32_t vertices_ = 0;
    std::vector<std::int32_t> ids_;    // by local id
    std::vector<std::int32_t> table_;  // open addressing: local ids of other seeds, or -1
    std::vector<Four> positions_, seeds_, lows_;
    std::vector<std::int32_t> owners_;
    std::vector<KnownVertex> known_;   // slabs
    std::vector<std::uint32_t> next_;  // by seed: the place in known_ for its next vertex; full slabs end at multiples
    std::vector<std::uint32_t> free_slabs_;
    std::uint32_t slabs_ = 0;
    std::vector<std::int32_t> spilled_;
    std::vector<Spill> spill_;
    std::vector<KnownVertex> gathered_;
    std::vector<std::int32_t> ties_;               // of each, the number of cells, then the cells
    std::vector<double> tie_powers_;               // by seed
    std::vector<std::uint8_t> done_, group_done_;  // the last block_groups of group_done_ are never whole
};

}  // namespace votess::cpu
