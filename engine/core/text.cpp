#include "core/text.hpp"

#include <charconv>

namespace votess {

std::string number(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

}  // namespace votess
