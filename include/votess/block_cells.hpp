// The cells of one rank; see votess/mpi.hpp.
#pragma once

#include <cstdint>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// Arrays as those of Tessellation, except that ids have 64 bits. Rows hold ids of seeds, or walls below 0, and ascend
// by id, then shift. Arrays that were not requested are empty, except the rows.
struct BlockCells {
    std::vector<CellStatus> status;          // N
    std::vector<std::int64_t> duplicate_of;  // N ids of the seed that keeps the cell, -1 for seeds with a cell; or none
    std::vector<std::int64_t> indptr;        // N+1
    std::vector<std::int64_t> neighbors;     // entries
    std::vector<std::int32_t> tags;          // entries: tags of the neighbors, -1 for walls
    std::vector<std::int8_t> shifts;         // (entries, 3), in a periodic domain
    std::vector<double> areas, normals;      // entries, (entries, 3)
    std::vector<double> volumes, centroids, surface_areas, security_radii;  // N, (N, 3), N, N
    std::vector<std::uint32_t> face_counts, edge_counts, vertex_counts;     // N
};

}  // namespace votess
