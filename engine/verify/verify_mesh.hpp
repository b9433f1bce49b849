// The checks of verify() that need polygons, or areas and normals.
#pragma once

#include <string>

#include "result/result.hpp"

namespace votess {

// Whether the arrays for either of the two are there.
bool has_mesh(const detail::Result& result);
// "" or one line on the first cell that is not watertight or not closed; `tolerance` relative to its surface.
std::string check_mesh(const detail::Result& result, double tolerance);

}  // namespace votess
