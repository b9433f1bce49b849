// Where the columns of a LAMMPS data file's rows come from: the atom style, a line of names, or their number.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "files/line_reader.hpp"

namespace clvotess {

// The columns of a row up to the image flags; those whose names are not known have empty ones.
struct AtomColumns {
    Words names;
    std::size_t x = 0;     // the column of x; y and z follow it
    bool guessed = false;  // from the number of columns alone
};

// The columns of rows of `size` words in an atom style, whose name and sub-styles are the words of `hint`. Throws
// Failure when its rows have another size.
[[nodiscard]] AtomColumns columns_of_style(const Words& hint, std::size_t size, const LineReader& lines);

// Whether the first word is the name of an atom style.
[[nodiscard]] bool knows_style(const Words& hint);

// In the common styles the place of the coordinates follows from the number of columns.
[[nodiscard]] AtomColumns columns_by_size(std::size_t size, const LineReader& lines);

// What words in lower case say that name columns, as "id type x y z" or "atom-id atom-type q x y z"; nothing unless an
// id comes first and x, y, z once, in this order.
[[nodiscard]] std::optional<AtomColumns> columns_by_names(const Words& names);

inline constexpr const char* ask_for_style = "name the atom style behind the word Atoms, as in \"Atoms # sphere\"";

}  // namespace clvotess
