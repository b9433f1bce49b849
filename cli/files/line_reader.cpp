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

std::string not_a_number(std::string_view word) {
    if (has_decimal_comma(word)) return in_quotes(word) + " has a decimal comma: decimals need a point, as in 0.5";
    return in_quotes(word) + " is not a number";
}

}  // namespace clvotess
