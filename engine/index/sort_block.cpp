#include "index/sort_block.hpp"

#include <algorithm>
#include <bit>

#include "index/sort_grid.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t crowded = 8;  // seeds in one block of a grid before it is binned again
constexpr std::size_t few = 24;     // items that insertion sorts fastest
constexpr int max_digit_bits = 11;  // counters of a pass stay in the first-level cache
constexpr std::uint64_t drop_mark = 1ull << 63;

std::uint32_t key_of(std::uint64_t item) {
    return static_cast<std::uint32_t>(item >> 32);
}

void insertion_sort(std::span<std::uint64_t> items) {
    for (std::size_t i = 1; i < items.size(); ++i) {
        const std::uint64_t item = items[i];
        std::size_t at = i;
        for (; at > 0 && items[at - 1] > item; --at) items[at] = items[at - 1];
        items[at] = item;
    }
}

bool equal(const SeedRecord& a, const SeedRecord& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

}  // namespace

void BlockSorter::reserve(std::size_t seeds) {
    items_.resize_uninitialized(seeds);
    moved_.resize_uninitialized(seeds);
}

const SeedRecord& BlockSorter::record(Item item) const {
    return records_[static_cast<std::uint32_t>(item)];
}

std::size_t BlockSorter::sort(std::span<const SeedRecord> records, SortedSeeds& out, std::size_t begin) {
    records_ = records;
    dropped_ = 0;
    const std::span<Item> items(items_.data(), records.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
        __builtin_prefetch(reinterpret_cast<const char*>(&records[i]) + 2048);
        items[i] = Item{records[i].key} << 32 | i;
    }
    sort_items(items);
    resolve(items);
    double *x = &out.x[begin], *y = &out.y[begin], *z = &out.z[begin];
    std::int32_t* input = &out.input[begin];
    for (std::size_t i = 0; i < items.size(); ++i) {
        const SeedRecord& r = record(items[i]);
        x[i] = r.x, y[i] = r.y, z[i] = r.z;
        input[i] = r.input;
    }
    if (dropped_ > 0)
        for (std::size_t i = 0; i < items.size(); ++i)
            if (items[i] & drop_mark) {
                input[i] = dropped(input[i]);
                x[i] = records[key_of(items[i] & ~drop_mark)].input;
            }
    return dropped_;
}

std::size_t BlockSorter::drop_all_but_first(std::span<const SeedRecord> records, SortedSeeds& out, std::size_t begin) {
    const SeedRecord& first = records[0];
    out.x[begin] = first.x, out.y[begin] = first.y, out.z[begin] = first.z;
    out.input[begin] = first.input;
    for (std::size_t i = 1; i < records.size(); ++i) {
        out.x[begin + i] = first.input;
        out.input[begin + i] = dropped(records[i].input);
    }
    return records.size() - 1;
}

// Sorts from the highest bits that differ to the lowest.
void BlockSorter::sort_items(std::span<Item> items) {
    if (items.size() <= few) return insertion_sort(items);
    Item differ = 0;
    for (const Item i : items) differ |= i ^ items[0];
    const int bits = std::bit_width(key_of(differ));
    if (bits == 0) return;  // in order already: passes are stable
    const int digit_bits = std::min({bits, max_digit_bits, static_cast<int>(std::bit_width(items.size()))});
    const int shift = 32 + bits - digit_bits;
    const std::size_t digits = std::size_t{1} << digit_bits;
    const auto digit = [=](Item i) { return i >> shift & (digits - 1); };

    std::uint32_t end[1 << max_digit_bits];
    std::fill_n(end, digits, 0);
    for (const Item i : items) ++end[digit(i)];
    std::uint32_t sum = 0, most = 0;
    for (std::size_t d = 0; d < digits; ++d) {
        const std::uint32_t count = end[d];
        end[d] = sum;
        sum += count;
        most = std::max(most, count);
    }
    for (const Item i : items) moved_[end[digit(i)]++] = i;
    std::copy_n(moved_.begin(), items.size(), items.begin());
    if (most <= few) return insertion_sort(items);
    for (std::size_t d = 0, begin = 0; d < digits; begin = end[d++])
        if (end[d] - begin > 1) sort_items(items.subspan(begin, end[d] - begin));
}

// Resolves runs of equal keys in sorted items.
void BlockSorter::resolve(std::span<Item> items) {
    for (std::size_t begin = 0; begin + 1 < items.size();) {
        std::size_t end = begin + 1;
        while (end < items.size() && key_of(items[end]) == key_of(items[begin])) ++end;
        if (end - begin > 1) resolve_run(items.subspan(begin, end - begin));
        begin = end;
    }
}

void BlockSorter::resolve_run(std::span<Item> run) {
    if (run.size() <= crowded) {
        // From the last item on, because earlier items must not be marked yet.
        for (std::size_t i = run.size() - 1; i > 0; --i)
            for (std::size_t j = 0; j < i; ++j)
                if (equal(record(run[i]), record(run[j]))) {
                    drop(run[i], run[j]);
                    break;
                }
        return;
    }
    Bounds bounds;
    for (const Item i : run) bounds.add(record(i).x, record(i).y, record(i).z);
    if (bounds.lower == bounds.upper) {
        for (std::size_t i = 1; i < run.size(); ++i) drop(run[i], run[0]);
        return;
    }
    const Grid grid(bounds);
    for (Item& i : run) {
        const SeedRecord& r = record(i);
        i = Item{grid.key(r.x, r.y, r.z)} << 32 | static_cast<std::uint32_t>(i);
    }
    sort_items(run);
    resolve(run);
}

// Replaces the key, which is no longer needed.
void BlockSorter::drop(Item& item, Item first) {
    item = drop_mark | Item{static_cast<std::uint32_t>(first)} << 32 | static_cast<std::uint32_t>(item);
    ++dropped_;
}

}  // namespace votess::cpu
