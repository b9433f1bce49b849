#include "line_reader.hpp"

namespace clvotess {

std::size_t find_column(const Words& names, const std::string& wish, const std::string& where) {
    const auto same = std::find(names.begin(), names.end(), wish);
    if (same != names.end()) return static_cast<std::size_t>(same - names.begin());
    if (const auto number = read_uint64(wish); number && *number >= 1 && *number <= names.size()) return *number - 1;
    std::string list;
    for (const std::string_view name : names) add_name(list, name);
    throw bad_input(where + ": no column " + in_quotes(wish) + "; there are " + list);
}

}  // namespace clvotess
