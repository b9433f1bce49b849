// The arrays that describe cells row by row, with one name each. BlockCells and StreamRows have them; those of a
// Tessellation have the same names.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// List: a vector or a span of constants. The rows of n cells have `entries` faces. Orders and units are those of
// Tessellation. Ids have 64 bits. Arrays that were not requested are empty.
template <template <class> class List>
struct RowArrays {
    List<CellStatus> status;          // n
    List<std::int64_t> duplicate_of;  // n ids of the seed that keeps the cell, -1 for seeds with a cell; or none
    List<std::int64_t> indptr;        // n+1 offsets
    List<std::int64_t> indices;       // entries: ids of seeds, or walls below 0; ascending in a row, then by shift
    List<std::int8_t> shifts;         // (entries, 3), in a periodic domain
    List<double> face_areas;          // entries
    List<double> face_normals;        // (entries, 3)
    List<double> volumes;             // n
    List<double> centroids;           // (n, 3)
    List<double> surface_areas;       // n
    List<double> security_radii;      // n
    List<std::uint32_t> face_counts, edge_counts, vertex_counts;  // n
};

namespace detail {
template <class T>
using Vector = std::vector<T>;
template <class T>
using ConstSpan = std::span<const T>;
}  // namespace detail

}  // namespace votess
