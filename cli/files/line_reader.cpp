#include "files/line_reader.hpp"

namespace clvotess {

std::string lower_case(std::string_view text) {
    std::string result(text);
    for (char& c : result) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return result;
}

std::string columns_text(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " column" : " columns");
}

std::size_t find_column(const Words& names, const std::string& wish, const std::string& where) {
    const auto same = std::find(names.begin(), names.end(), wish);
    if (same != names.end()) return static_cast<std::size_t>(same - names.begin());
    if (const auto number = read_uint64(wish); number && *number >= 1 && *number <= names.size()) return *number - 1;
    std::string list;
    for (const std::string_view name : names) add_name(list, name);
    throw bad_input(where + ": no column " + in_quotes(wish) + "; there are " + list);
}

}  // namespace clvotess
