// Options::min_face and min_area.
#pragma once

#include <cstdint>

#include "result/result.hpp"

namespace votess {

// Needs rows with areas. share: of the mean area. Notes the area below which faces go; how many entries went.
std::uint64_t drop_small_faces(detail::Result& result, double share, double area);

}  // namespace votess
