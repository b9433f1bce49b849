// Numbers of seeds, vertices and places, as indices of arrays.
#pragma once

#include <cstddef>
#include <cstdint>

namespace votess {

[[nodiscard]] inline std::size_t at(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

}  // namespace votess
