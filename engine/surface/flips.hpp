// Flips of edges in a triangle mesh whose vertices lie nearly on lines.
#pragma once

#include <cstdint>
#include <vector>

namespace votess::surface {

// Flips the longest edge of flat triangles where that makes the smallest angle of both larger, and triangles turn away
// from each other by less than `sharp` degrees. The mesh joins the same as before. Triangles begin with their lowest
// vertex and ascend.
void flip_flat(const std::vector<double>& vertices, double sharp, std::vector<std::int32_t>& triangles);

}  // namespace votess::surface
