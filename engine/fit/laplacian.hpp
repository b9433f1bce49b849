// The derivatives of volumes by weights, and the solution of systems with them.
#pragma once

#include <array>
#include <span>

#include "fit/multigrid.hpp"
#include "votess/votess.hpp"

namespace votess::fit {

using Edges = std::array<std::array<double, 3>, 3>;

// Sets the matrix to the derivatives of volumes by weights: -area / (2 distance) for neighbors, and the diagonal that
// makes each row sum to 0. tessellation: with neighbors; walls do not count. areas: of its faces, or their masses.
// places: 3N, inside a periodic domain. edges: of the domain.
void set_laplacian(const Tessellation& tessellation, std::span<const double> areas, std::span<const double> places,
                   const Edges& edges, Matrix& matrix);

// Returns x of mean 0 with matrix x = right, for a right side that sums to 0. tolerance: norm of the residual, relative
// to the right side.
[[nodiscard]] Vector solve(const Matrix& matrix, const Vector& right, double tolerance);

}  // namespace votess::fit
