// Options::min_face.
#pragma once

#include <cstdint>

#include "result/result.hpp"

namespace votess {

// Needs rows with areas. Notes the area below which faces go; how many entries went.
std::uint64_t drop_small_faces(detail::Result& result, double share);

}  // namespace votess
