// What does not go with what, as one table: functions that read a result, and the results that they refuse. README
// names those that are pairs of a domain and an output.
#pragma once

#include <array>
#include <cstddef>
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
    Support{"groups", probed | subset},
    Support{"masses", probed | in_mesh},
    Support{"network", probed | subset | in_mesh},
    Support{"picture", probed | subset},
    Support{"verify", probed},
    Support{"watershed", probed | subset},
};

// A row of the table, by its function. Another name does not compile.
class SupportRow {
public:
    consteval SupportRow(const char* function) {
        while (row_ < support.size() && support[row_].function != function) ++row_;
        if (row_ == support.size()) throw "the table has no such function";
    }
    [[nodiscard]] const Support& operator*() const { return support[row_]; }

private:
    std::size_t row_ = 0;
};

// Throws invalid_argument for a result that the function refuses.
void require(const Tessellation& tessellation, SupportRow function);

}  // namespace votess
