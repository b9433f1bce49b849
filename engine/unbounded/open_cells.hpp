// Results of a domain without end, from those of boxes with ends. Cells that reach infinity are open: their volume,
// surface and security radius are infinite, their centroid is not a number. Infinity is one wall, whose id
// EndlessSides::id() chooses, with an empty polygon. In polygons -1 stands for infinity, after the last corner.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "result/result.hpp"
#include "unbounded/endless_box.hpp"

namespace votess {

// Whether row i of a result lists a wall of which is_end() is true.
[[nodiscard]] bool lists_end(const detail::Result& rows, std::size_t i, const auto& is_end) {
    return std::any_of(rows.indices.begin() + rows.indptr[i], rows.indices.begin() + rows.indptr[i + 1], is_end);
}

// Turns a result of end_far() or end_near(), whose rows list walls, into that of the domain. Counts and
// areas need polygons.
void open_cells(detail::Result& result, const Region& domain);

// Takes cells of `far` into the result `near` of end_near(); open_cells() has turned both. rows: the near row of each
// far one, ascending. taken: by near row, whether the far cell replaces the near one. names: the seeds that the ids of
// `far` mean; empty if both results have the same ids. Vertices that taken cells share with others need far cells of
// all neighbors of the taken ones.
[[nodiscard]] detail::Result join_cells(detail::Result&& near, const detail::Result& far,
                                        std::span<const std::int32_t> rows, const std::vector<bool>& taken,
                                        std::span<const std::int32_t> names, const Region& domain);

}  // namespace votess
