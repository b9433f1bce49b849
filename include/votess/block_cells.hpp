// The cells that one rank returns; see votess/mpi.hpp.
#pragma once

#include <cstdint>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// Arrays as those of Tessellation, but ids have 64 bits: rows hold ids of seeds, or walls below 0, and ascend by them,
// then by shift. Arrays that are not wanted are empty; the rows are always there.
struct BlockCells {
    std::vector<CellStatus> status;          // N
    std::vector<std::int64_t> duplicate_of;  // N: the id of the seed that has the cell, -1 for others; or none at all
    std::vector<std::int64_t> indptr;        // N+1
    std::vector<std::int64_t> neighbors;     // entries
    std::vector<std::int32_t> tags;          // entries: of the neighbors, -1 for walls
    std::vector<std::int8_t> shifts;         // (entries, 3), where the domain is periodic
    std::vector<double> areas, normals;      // entries, (entries, 3)
    std::vector<double> volumes, centroids, surface_areas, security_radii;  // N, (N, 3), N, N
    std::vector<std::uint32_t> face_counts, edge_counts, vertex_counts;     // N
};

}  // namespace votess
