// The arrays of results, with one name each, and their table. BlockCells and StreamRows have those of rows; those of a
// Tessellation have the same names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// List: a vector or a span of constants. The rows of n cells have `entries` faces. Orders and units are those of
// Tessellation. Id: of seeds. Arrays that were not requested are empty.
template <template <class> class List, class Id = std::int64_t>
struct RowArrays {
    List<CellStatus> status;      // n
    List<Id> duplicate_of;        // n ids of the seed that keeps the cell, -1 for seeds with a cell; or none
    List<std::int64_t> indptr;    // n+1 offsets
    List<Id> indices;             // entries: ids of seeds, or walls below 0; ascending in a row, then by shift
    List<std::int8_t> shifts;     // (entries, 3), in a periodic domain
    List<double> face_areas;      // entries
    List<double> face_normals;    // (entries, 3)
    List<double> volumes;         // n
    List<double> centroids;       // (n, 3)
    List<double> surface_areas;   // n
    List<double> security_radii;  // n
    List<std::uint32_t> face_counts, edge_counts, vertex_counts;  // n
};

// What an array has `components` elements for.
enum class Per : std::uint8_t {
    cell,    // N, a row each
    entry,   // indptr[N], a face of a row each
    vertex,  // V, of the mesh
    other,   // offsets, and the elements between them
};

template <class Of>
struct ArrayInfo {
    std::string_view name;
    Of of;  // of(cells): the array of a Tessellation, BlockCells or StreamRows, if these have it
    Per per = Per::other;
    std::size_t components = 1;  // 3: a vector, which has two components in the plane
    bool Want::*word = nullptr;  // the group that wants it; null: part of every result
};
template <class Of>
ArrayInfo(std::string_view, Of, Per, std::size_t, bool Want::*) -> ArrayInfo<Of>;
template <class Of>
ArrayInfo(std::string_view, Of, Per, std::size_t) -> ArrayInfo<Of>;

// Returns the components of an array of space or of the plane.
template <class Of>
[[nodiscard]] constexpr std::size_t components_of(const ArrayInfo<Of>& array, bool planar) {
    return planar && array.components == 3 ? 2 : array.components;
}

#define VOTESS_ARRAY(name, ...)                                                              \
    ArrayInfo {                                                                              \
#name, [](auto& cells) -> decltype(auto) requires(                                   \
                                   requires { cells.name(); } || requires { cells.name; }) { \
            if constexpr (requires { cells.name(); })                                        \
                return cells.name();                                                         \
            else                                                                             \
                return (cells.name);                                                         \
        }                                                                                    \
        , __VA_ARGS__                                                                        \
    }

// Those of RowArrays, except indptr, in the order of files.
inline constexpr std::tuple row_arrays{
    VOTESS_ARRAY(indices, Per::entry, 1, &Want::neighbors),
    VOTESS_ARRAY(shifts, Per::entry, 3, &Want::neighbors),
    VOTESS_ARRAY(face_areas, Per::entry, 1, &Want::areas),
    VOTESS_ARRAY(face_normals, Per::entry, 3, &Want::normals),
    VOTESS_ARRAY(volumes, Per::cell, 1, &Want::volumes),
    VOTESS_ARRAY(centroids, Per::cell, 3, &Want::centroids),
    VOTESS_ARRAY(surface_areas, Per::cell, 1, &Want::surfaces),
    VOTESS_ARRAY(security_radii, Per::cell, 1, &Want::radii),
    VOTESS_ARRAY(face_counts, Per::cell, 1, &Want::counts),
    VOTESS_ARRAY(edge_counts, Per::cell, 1, &Want::counts),
    VOTESS_ARRAY(vertex_counts, Per::cell, 1, &Want::counts),
    VOTESS_ARRAY(status, Per::cell, 1),
    VOTESS_ARRAY(duplicate_of, Per::cell, 1),
};
// The others of a Tessellation.
inline constexpr std::tuple other_arrays{
    VOTESS_ARRAY(indptr, Per::other, 1, &Want::neighbors),
    VOTESS_ARRAY(mesh_areas, Per::cell, 1, &Want::surfaces),
    VOTESS_ARRAY(vertices, Per::vertex, 3, &Want::vertices),
    VOTESS_ARRAY(cell_vertex_indptr, Per::other, 1, &Want::vertices),
    VOTESS_ARRAY(cell_vertex_indices, Per::other, 1, &Want::vertices),
    VOTESS_ARRAY(face_offsets, Per::other, 1, &Want::faces),
    VOTESS_ARRAY(face_vertices, Per::other, 1, &Want::faces),
    VOTESS_ARRAY(ids, Per::cell, 1),
    VOTESS_ARRAY(weights, Per::other, 1),
};
#undef VOTESS_ARRAY

// Calls visit(array, number) for each of row_arrays.
template <class Visit>
constexpr void for_row_arrays(Visit&& visit) {
    std::size_t number = 0;
    std::apply([&](const auto&... array) { (visit(array, number++), ...); }, row_arrays);
}
// Calls visit(array) for all arrays of a Tessellation.
template <class Visit>
constexpr void for_all_arrays(Visit&& visit) {
    std::apply([&](const auto&... array) { (visit(array), ...); }, std::tuple_cat(row_arrays, other_arrays));
}

namespace detail {
template <class T>
using Vector = std::vector<T>;
template <class T>
using ConstSpan = std::span<const T>;
}  // namespace detail

}  // namespace votess
