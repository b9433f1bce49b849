// What does not go with what, as one table: the functions that read a result, and the results that they refuse. README
// has the same pairs; the test of all pairs compares both.
#pragma once

#include <array>
#include <string_view>

#include "votess/votess.hpp"

namespace votess {

// What a result may be.
enum Property : unsigned {
    probed = 1,   // cells of probes
    subset = 2,   // of some seeds
    in_mesh = 4,  // parts of cells in a mesh
    flat = 8,     // of the plane
};

struct Support {
    std::string_view function;
    unsigned refused;  // properties
};
inline constexpr std::array support{
    Support{"alpha_complex", probed | subset | in_mesh},
    Support{"count_tiny_faces", probed | subset | in_mesh | flat},
    Support{"delaunay", probed | subset | in_mesh},
    Support{"network", probed | subset | in_mesh},
    Support{"picture", probed | subset | in_mesh},
    Support{"verify", probed},
    Support{"watershed", probed | subset},
    Support{"wrapped_points", probed},
};

// Throws invalid_argument for a result that the function refuses; it is in the table.
void require(const Tessellation& tessellation, std::string_view function);

}  // namespace votess
