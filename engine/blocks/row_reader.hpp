// Rows of a run among some seeds, with the ids that these have in the run of all.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "blocks/seeds.hpp"
#include "result/result.hpp"

namespace votess::blocks {

// One per thread.
class RowReader {
public:
    struct Entry {
        std::int64_t id;
        std::int32_t tag;  // -1 for walls
        std::array<std::int8_t, 3> shift;
        std::size_t at;  // in the arrays of the result
        friend bool operator<(const Entry& a, const Entry& b) { return a.id != b.id ? a.id < b.id : a.shift < b.shift; }
    };

    RowReader(const detail::Result& from, const Seeds& seeds) : from_(from), seeds_(seeds) {}

    // Row i, ascending by id, then by shift; until the next call.
    std::span<const Entry> read(std::size_t i) {
        const bool periodic = from_.shifts.size() > 0;
        row_.clear();
        for (auto e = begin(i); e < begin(i + 1); ++e) {
            const std::int32_t index = from_.indices[e];
            Entry entry{index, -1, {}, e};
            if (index >= 0) {
                entry.id = seeds_.ids[static_cast<std::size_t>(index)];
                entry.tag = seeds_.tags.empty() ? 0 : seeds_.tags[static_cast<std::size_t>(index)];
            }
            if (periodic) std::copy_n(from_.shifts.data() + 3 * e, 3, entry.shift.begin());
            row_.push_back(entry);
        }
        if (!std::ranges::is_sorted(row_, {}, &Entry::id)) std::ranges::sort(row_, std::less<>());
        return row_;
    }
    // The ids of row i, as its entries stand in the result; whether that is their order already.
    bool read_ids(std::size_t i, std::vector<std::int64_t>& ids) const {
        ids.clear();
        for (auto e = begin(i); e < begin(i + 1); ++e) {
            const std::int32_t index = from_.indices[e];
            ids.push_back(index < 0 ? index : seeds_.ids[static_cast<std::size_t>(index)]);
        }
        return std::ranges::is_sorted(ids);
    }
    [[nodiscard]] std::size_t begin(std::size_t i) const { return static_cast<std::size_t>(from_.indptr[i]); }

private:
    const detail::Result& from_;
    const Seeds& seeds_;
    std::vector<Entry> row_;
};

}  // namespace votess::blocks
