// The arrays of a result, as one table. Code that copies, filters, joins, names or exposes arrays iterates over it, so
// that a new array needs a row here, its maker and its test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "result/result.hpp"

namespace votess::detail {

// What an array has `components` elements for.
enum class Per : std::uint8_t {
    cell,    // N, a row each
    entry,   // indptr[N], a face of a row each
    vertex,  // V, of the mesh
    other,   // offsets, and the elements between them
};

template <class T>
struct Array {
    std::string_view name;  // empty: not public
    Buffer<T> Result::*values;
    Per per = Per::other;
    std::size_t components = 1;  // 3: a vector, which has two components in the plane
    bool Want::*word = nullptr;  // the group that wants it; null: part of every result
};
template <class T>
Array(std::string_view, Buffer<T> Result::*, Per, std::size_t, bool Want::*) -> Array<T>;
template <class T>
Array(std::string_view, Buffer<T> Result::*, Per, std::size_t) -> Array<T>;

inline constexpr std::tuple array_table{
    Array{"indptr", &Result::indptr, Per::other, 1, &Want::neighbors},
    Array{"indices", &Result::indices, Per::entry, 1, &Want::neighbors},
    Array{"shifts", &Result::shifts, Per::entry, 3, &Want::neighbors},
    Array{"volumes", &Result::volumes, Per::cell, 1, &Want::volumes},
    Array{"centroids", &Result::centroids, Per::cell, 3, &Want::centroids},
    Array{"face_areas", &Result::face_areas, Per::entry, 1, &Want::areas},
    Array{"face_normals", &Result::face_normals, Per::entry, 3, &Want::normals},
    Array{"surface_areas", &Result::surface_areas, Per::cell, 1, &Want::surfaces},
    Array{"mesh_areas", &Result::mesh_areas, Per::cell, 1, &Want::surfaces},
    Array{"security_radii", &Result::security_radii, Per::cell, 1, &Want::radii},
    Array{"face_counts", &Result::face_counts, Per::cell, 1, &Want::counts},
    Array{"edge_counts", &Result::edge_counts, Per::cell, 1, &Want::counts},
    Array{"vertex_counts", &Result::vertex_counts, Per::cell, 1, &Want::counts},
    Array{"vertices", &Result::vertices, Per::vertex, 3, &Want::vertices},
    Array{"cell_vertex_indptr", &Result::cell_vertex_indptr, Per::other, 1, &Want::vertices},
    Array{"cell_vertex_indices", &Result::cell_vertex_indices, Per::other, 1, &Want::vertices},
    Array{"face_offsets", &Result::face_offsets, Per::other, 1, &Want::faces},
    Array{"face_vertices", &Result::face_vertices, Per::other, 1, &Want::faces},
    Array{"status", &Result::status, Per::cell, 1},
    Array{"duplicate_of", &Result::duplicate_of, Per::cell, 1},
    Array{"ids", &Result::ids, Per::cell, 1},
    Array{"weights", &Result::weights, Per::other, 1},
    Array{"", &Result::vertex_image_of, Per::vertex, 1, &Want::vertices},
    Array{"", &Result::vertex_shifts, Per::vertex, 3, &Want::vertices},
    Array{"", &Result::dropped_offsets, Per::other, 1, &Want::faces},
    Array{"", &Result::dropped_vertices, Per::other, 1, &Want::faces},
};

// Calls visit(array) for each row of the table.
template <class Visit>
constexpr void for_each_array(Visit&& visit) {
    std::apply([&](const auto&... array) { (visit(array), ...); }, array_table);
}

// Returns an empty result that has the memory of an old one.
[[nodiscard]] inline Result emptied(Result&& old) {
    Result empty;
    for_each_array([&](const auto& array) {
        empty.*array.values = std::move(old.*array.values);
        (empty.*array.values).resize_uninitialized(0);
    });
    return empty;
}

// Empties the arrays that are not wanted, and drops walls unless the rows list them.
void keep_wanted(Result& result, const Want& want, bool list_walls);

// Copies the values of cell k of `from` to cell i, in the arrays that both have. The row stays.
inline void copy_cell(Result& to, std::size_t i, const Result& from, std::size_t k) {
    for_each_array([&](const auto& array) {
        auto& values = to.*array.values;
        const auto& others = from.*array.values;
        if (array.per != Per::cell || values.empty() || others.empty()) return;
        for (std::size_t c = 0; c < array.components; ++c)
            values[array.components * i + c] = others[array.components * k + c];
    });
}

// Moves the vectors of a result to the plane: drops the last component of each.
void drop_third_components(Result& result);

// Keeps some entries of the rows, in their order, with their polygons. stays: indptr[N] of them.
void keep_entries(Result& result, const std::vector<bool>& stays);

}  // namespace votess::detail
