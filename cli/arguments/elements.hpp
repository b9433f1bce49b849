// Covalent radii of the elements, for --radii covalent.
#pragma once

#include <string>
#include <vector>

namespace clvotess {

// Returns the radius of each atom in angstrom. species: symbols of elements; digits and charges behind them are
// ignored. Throws Failure for another word.
[[nodiscard]] std::vector<double> covalent_radii(const std::vector<std::string>& species);

}  // namespace clvotess
