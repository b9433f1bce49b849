// Sorts the seeds of one stretch of the curve, few enough for a cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/buffer.hpp"
#include "index/sorted_seeds.hpp"

namespace votess::cpu {

struct SeedRecord {
    double x, y, z;
    std::int32_t input;
    std::uint32_t key;  // along the curve; below 2^30
};

// A seed that equals another keeps its place among the sorted seeds until all are sorted, with this in place of `input`
// and, in place of x, the input index of the seed that keeps the cell.
constexpr std::int32_t dropped(std::int32_t input) {
    return ~input;
}

// One per thread; holds scratch memory.
class BlockSorter {
public:
    // Room for blocks of so many seeds.
    void reserve(std::size_t seeds);

    // Writes the records in order to out[begin ..]; they come in the order of the input. Returns how many are dropped.
    std::size_t sort(std::span<const SeedRecord> records, SortedSeeds& out, std::size_t begin);
    // For records that all lie at one point, any number of them.
    static std::size_t drop_all_but_first(std::span<const SeedRecord> records, SortedSeeds& out, std::size_t begin);

private:
    // The key, then the place among the records, so that all differ and ties keep the order of the input.
    using Item = std::uint64_t;

    void sort_items(std::span<Item> items);
    void resolve(std::span<Item> items);
    void resolve_run(std::span<Item> run);
    void drop(Item& item, Item first);
    [[nodiscard]] const SeedRecord& record(Item item) const;

    std::span<const SeedRecord> records_;
    Buffer<Item> items_, moved_;
    std::size_t dropped_ = 0;
};

}  // namespace votess::cpu
