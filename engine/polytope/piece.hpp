// Measures of a clipped cell in a chosen precision, each with an error bound.
#pragma once

#include <array>
#include <vector>

#include "polytope/cell.hpp"

namespace votess::cpu {

// The source of the corners: the cell itself, or exact ones rounded to 113 or 2367 bits. The last has no error.
enum class Precision { cell, quad, wide };

struct Measured {
    double value = 0, error = 0;
};

struct FaceMeasure {
    Measured area;
    std::array<double, 3> moment{};  // the integral of x over the face, relative to the seed
};

// Returns the volume. Sums tetrahedra from one corner, so a piece far from its seed keeps its digits.
Measured measure_volume(const Cell& cell, const CellFaces& faces, Precision precision);
// Returns the area and the moment of a face.
FaceMeasure measure_face(const Cell& cell, const CellFaces& faces, std::size_t face, Precision precision);

}  // namespace votess::cpu
