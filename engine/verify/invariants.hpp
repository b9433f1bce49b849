// What holds for all cells together, and for each without others. "" or one line on what is wrong.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "core/text.hpp"
#include "votess/votess.hpp"

namespace votess {

// certified: whether there is such a cell; with no seed inside, no cell fills the domain.
inline std::string check_volume_sum(const Stats& s, bool certified, double tolerance) {
    // Subnormal volumes are rounded to a multiple of the least double.
    const double rounding = static_cast<double>(s.points + 1) * std::numeric_limits<double>::denorm_min();
    const double expected = certified ? s.box_volume : 0;
    if (s.volume_sum == expected || std::abs(s.volume_sum - expected) <= tolerance * s.box_volume + rounding) return {};
    return "volumes sum to " + number(s.volume_sum) + ", the box holds " + number(s.box_volume);
}

inline std::string check_euler_formula(std::int64_t id, std::int64_t vertices, std::int64_t edges, std::int64_t faces) {
    if (vertices - edges + faces == 2) return {};
    return "cell " + std::to_string(id) + " has " + std::to_string(vertices) + " vertices, " + std::to_string(edges) +
           " edges and " + std::to_string(faces) + " faces, against Euler's formula";
}

inline std::string not_ascending(std::int64_t id, std::int64_t at) {
    return "the row of seed " + std::to_string(id) + " does not ascend at " + std::to_string(at);
}

}  // namespace votess
