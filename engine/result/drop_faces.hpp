// The options min_face and min_area.
#pragma once

#include <cstdint>

#include "result/result.hpp"

namespace votess {

// Drops faces below `area` and below `share` of the mean area, which faces that reach infinity do not count in. Needs
// rows with areas. Stores the limit in the result. Returns the number of dropped entries.
std::uint64_t drop_small_faces(detail::Result& result, double share, double area);

}  // namespace votess
