// The table of arrays of votess/row_arrays.hpp for Result. Code that copies, filters, joins, names or exposes arrays
// iterates over it, so that a new array needs a row there, its maker and its test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "result/result.hpp"

namespace votess::detail {

#define VOTESS_ARRAY(name, ...)          \
    ArrayInfo {                          \
#name, [](auto& rows) -> auto& { \
            return rows.name;            \
        }                                \
        , __VA_ARGS__                    \
    }

// Those that a Tessellation does not show.
inline constexpr std::tuple inner_arrays{
    VOTESS_ARRAY(vertex_image_of, Per::vertex, 1, &Want::vertices, ""),
    VOTESS_ARRAY(vertex_shifts, Per::vertex, 3, &Want::vertices, ""),
    VOTESS_ARRAY(dropped_offsets, Per::other, 1, &Want::faces, ""),
    VOTESS_ARRAY(dropped_vertices, Per::other, 1, &Want::faces, ""),
};
#undef VOTESS_ARRAY

inline constexpr std::size_t row_array_count = std::tuple_size_v<decltype(row_arrays)>;

// Calls visit(array) for all arrays of Result.
template <class Visit>
constexpr void for_arrays(Visit&& visit) {
    for_all_arrays(visit);
    std::apply([&](const auto&... array) { (visit(array), ...); }, inner_arrays);
}

// Returns the number of a row array.
[[nodiscard]] constexpr std::size_t number_of(std::string_view name) {
    std::size_t found = row_array_count;
    for_row_arrays([&](const auto& array, std::size_t number) {
        if (array.name == name) found = number;
    });
    return found;
}

// Returns an empty result that has the memory of an old one.
[[nodiscard]] inline Result emptied(Result&& old) {
    Result empty;
    for_arrays([&](const auto& array) {
        auto& values = array.of(empty);
        values = std::move(array.of(old));
        values.resize_uninitialized(0);
    });
    return empty;
}

// Empties the arrays that are not wanted, and drops walls unless the rows list them.
void keep_wanted(Result& result, const Want& want, bool list_walls);

// Copies the values of cell k of `from` to cell i, in the arrays that both have. The row stays.
inline void copy_cell(Result& to, std::size_t i, const Result& from, std::size_t k) {
    for_arrays([&](const auto& array) {
        auto& values = array.of(to);
        const auto& others = array.of(from);
        if (array.per != Per::cell || values.empty() || others.empty()) return;
        for (std::size_t c = 0; c < array.components; ++c)
            values[array.components * i + c] = others[array.components * k + c];
    });
}

// Moves the vectors of a result to the plane: drops the last component of each.
void drop_third_components(Result& result);

// Keeps some vertices, in their order, with all of their images. number: of each among those that stay, or -1. Rows and
// polygons keep the old numbers.
void keep_vertices(Result& result, std::span<const std::int32_t> number);

// Keeps some entries of the rows, in their order, with their polygons. stays: indptr[N] of them.
void keep_entries(Result& result, const std::vector<bool>& stays);

}  // namespace votess::detail
