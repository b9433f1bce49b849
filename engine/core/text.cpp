#include "core/text.hpp"

#include <charconv>

namespace votess {

std::string number(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

std::string in_parentheses(std::span<const double> place) {
    std::string text;
    for (const double x : place) text += (text.empty() ? "(" : ", ") + number(x);
    return text + ")";
}

std::string in_quotes(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return "'" + text + "'";
}

}  // namespace votess
