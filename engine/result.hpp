// The arrays behind a Tessellation, in input order; see votess.hpp for shapes and units.
#pragma once

#include <cstdint>

#include "buffer.hpp"
#include "votess/votess.hpp"

namespace votess::detail {

struct Result {
    Box box;
    bool lists_walls = false;
    Buffer<std::int64_t> indptr;
    Buffer<std::int32_t> indices;
    Buffer<double> volumes, centroids, face_areas;
    Buffer<std::uint32_t> face_counts, edge_counts, vertex_counts;
    Buffer<CellStatus> status;
    Buffer<std::int32_t> duplicate_of;
    Stats stats;
};

}  // namespace votess::detail
