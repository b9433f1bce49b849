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

// Replaces `input` of a seed that equals another, until all are sorted. The input index of the seed that keeps the cell
// replaces x.
constexpr std::int32_t dropped(std::int32_t input) {
    return ~input;
}

class BlockSorter {
public:
    void reserve(std::size_t seeds);

    // Sorts records, which are in input order, and writes them to out[begin ..]. Returns the number of dropped seeds.
    std::size_t sort(std::span<const SeedRecord> records, SortedSeeds& out, std::size_t begin);
    // For any number of records at one point.
    static std::size_t drop_all_but_first(std::span<const SeedRecord> records, SortedSeeds& out, std::size_t begin);

private:
    // The key, then the index among the records, so that all differ and ties keep the input order.
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
