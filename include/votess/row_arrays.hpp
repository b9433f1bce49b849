// The table of arrays for code that iterates over it. BlockCells and StreamRows have those of rows; those of a
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

// The rows of n cells, with indptr[n] entries. List: a vector or a span of constants. Id: of seeds. Arrays that were
// not requested are empty; duplicate_of may be empty without duplicates.
template <template <class> class List, class Id = std::int64_t>
struct RowArrays {
#define VOTESS_ROW_STARTS(name, type, ...) List<type> name;
#define VOTESS_ROW_ARRAY(name, type, ...) List<type> name;
#include "votess/arrays.h"
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
    Per per;
    std::size_t components;   // 3: a vector, which has two components in the plane
    bool Want::*word;         // the group that wants it; null: part of every result
    std::string_view column;  // its name in tables of cells; "": none
};
template <class Of>
ArrayInfo(std::string_view, Of, Per, std::size_t, bool Want::*, std::string_view) -> ArrayInfo<Of>;

// Returns the components of an array of space or of the plane.
template <class Of>
[[nodiscard]] constexpr std::size_t components_of(const ArrayInfo<Of>& array, bool planar) {
    return planar && array.components == 3 ? 2 : array.components;
}

// A group of arrays; the bit of its C interface.
struct GroupInfo {
    std::string_view name;
    bool Want::*word;
    std::uint32_t bit;
};
inline constexpr GroupInfo array_groups[] = {
#define VOTESS_GROUP(name, NAME, bit, value) {#name, &Want::name, bit},
#include "votess/arrays.h"
};

namespace detail::words {
inline constexpr bool Want::*every = nullptr;
#define VOTESS_GROUP(name, ...) inline constexpr bool Want::*name = &Want::name;
#include "votess/arrays.h"
}  // namespace detail::words

#define VOTESS_ARRAY(name, per, components, group, column)                                   \
    ArrayInfo {                                                                              \
#name, [](auto& cells) -> decltype(auto) requires(                                   \
                                   requires { cells.name(); } || requires { cells.name; }) { \
            if constexpr (requires { cells.name(); })                                        \
                return cells.name();                                                         \
            else                                                                             \
                return (cells.name);                                                         \
        }                                                                                    \
        , Per::per, components, detail::words::group, column                                 \
    }
// Those of RowArrays, except indptr, in the order of files.
inline constexpr std::tuple row_arrays{
#define VOTESS_ROW_ARRAY(name, type, per, components, group, column, text) \
    VOTESS_ARRAY(name, per, components, group, column),
#include "votess/arrays.h"
};
// The others of a Tessellation.
inline constexpr std::tuple other_arrays{
#define VOTESS_ROW_STARTS(name, type, per, components, group, column, text) \
    VOTESS_ARRAY(name, per, components, group, column),
#define VOTESS_OTHER_ARRAY(name, type, per, components, group, column, text) \
    VOTESS_ARRAY(name, per, components, group, column),
#include "votess/arrays.h"
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
