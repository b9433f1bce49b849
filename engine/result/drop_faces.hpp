// The options min_face and min_area.
#pragma once

#include <cstdint>

#include "result/result.hpp"
#include "result/rows.hpp"

namespace votess {

// Returns the area of a face of cell i that counts for both sides: the lower cell's, or the later face's if a cell
// meets itself twice. Rows are symmetric.
double area_of_pair(const detail::Result& r, const Rows& rows, std::size_t i, std::size_t entry);

// Drops faces below `area` and below `share` of the mean area, which faces that reach infinity do not count in. Needs
// rows with areas. Stores the limit in the result. Returns the number of dropped entries.
std::uint64_t drop_small_faces(detail::Result& result, double share, double area);

}  // namespace votess
