// The arrays of cells that tables and .vtu hold, by the table of votess/arrays.h.
#pragma once

#include <string_view>
#include <type_traits>
#include <votess/row_arrays.hpp>

namespace clvotess {

// Calls visit(array, values) for each wanted array that is a column of a table of cells.
void for_columns(const votess::Tessellation& cells, const votess::Want& wanted, const auto& visit) {
    votess::for_all_arrays([&](const auto& array) {
        if (array.column.empty() || (array.word != nullptr && !(wanted.*array.word))) return;
        if (array.name == "mesh_areas" && !cells.in_mesh()) return;
        const auto values = array.of(cells);
        if constexpr (std::is_arithmetic_v<typename decltype(values)::value_type>) visit(array, values);
    });
}

[[nodiscard]] constexpr bool is_column(std::string_view name) {
    bool found = false;
    votess::for_all_arrays([&](const auto& array) { found = found || (!name.empty() && array.column == name); });
    return found;
}

}  // namespace clvotess
