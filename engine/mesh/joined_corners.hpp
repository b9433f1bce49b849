// Vertices of the mesh that count as one: images in a periodic domain, and vertices joined by dropped faces and short
// edges.
#pragma once

#include <vector>

#include "mesh/dual.hpp"

namespace votess {

class JoinedCorners {
public:
    // Throws invalid_argument where a kept face collapses, see delaunay().
    explicit JoinedCorners(const detail::Result& result);

    // Whether dropped faces or short edges joined any.
    [[nodiscard]] bool any() const { return !originals_.empty(); }
    // The first of the vertices that are one, and how far the vertex is from it.
    [[nodiscard]] std::size_t original(std::int32_t vertex) const {
        return any() ? at(originals_[at(vertex)]) : votess::original(result_, vertex);
    }
    [[nodiscard]] ByteShift shift(std::int32_t vertex) const {
        return any() ? shifts_[at(vertex)] : shift_in(result_.vertex_shifts, at(vertex), 1, dimensions_of(result_));
    }

private:
    const detail::Result& result_;
    std::vector<std::int32_t> originals_;  // by vertex
    std::vector<ByteShift> shifts_;
};

}  // namespace votess
