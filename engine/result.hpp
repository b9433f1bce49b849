// The arrays behind a Tessellation, in input order; see votess.hpp for shapes and units.
#pragma once

#include <cstdint>
#include <vector>

#include "votess/votess.hpp"

namespace votess::detail {

struct Result {
    Box box;
    bool lists_walls = false;
    std::vector<std::int64_t> indptr;
    std::vector<std::int32_t> indices;
    std::vector<double> volumes, centroids, face_areas;
    std::vector<std::uint32_t> face_counts, edge_counts, vertex_counts;
    std::vector<CellStatus> status;
    std::vector<std::int32_t> duplicate_of;
    Stats stats;
};

}  // namespace votess::detail
