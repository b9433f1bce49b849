// The columns of a LAMMPS data file, by atom style, by a line of names, or by their number.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "files/line_reader.hpp"

namespace clvotess {

// The columns of a row up to the image flags. Unknown names are empty.
struct AtomColumns {
    Words names;
    std::size_t x = 0;     // column of x; y and z follow
    bool guessed = false;  // derived from the number of columns only
};

// Returns the columns of rows of `size` words in an atom style. hint: its name and sub-styles. Throws Failure for rows
// of another size.
[[nodiscard]] AtomColumns columns_of_style(const Words& hint, std::size_t size, const LineReader& lines);

// Returns whether the first word is an atom style.
[[nodiscard]] bool knows_style(const Words& hint);

// Returns the columns by their number, which is unique in common styles.
[[nodiscard]] AtomColumns columns_by_size(std::size_t size, const LineReader& lines);

// Returns the columns for names in lower case, such as "id type x y z" or "atom-id atom-type q x y z". Returns nothing
// unless an id comes first and x, y, z occur once, in this order.
[[nodiscard]] std::optional<AtomColumns> columns_by_names(const Words& names);

inline constexpr const char* ask_for_style = "name the atom style behind the word Atoms, as in \"Atoms # sphere\"";

}  // namespace clvotess
