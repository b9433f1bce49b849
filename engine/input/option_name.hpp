// The names of options in messages. Each interface puts its own in their place.
#pragma once

#include <string>
#include <string_view>

namespace votess {

// tests/house/check_words.py checks that there is such an option.
[[nodiscard]] inline std::string option(std::string_view name) {
    return "Options::" + std::string(name);
}

}  // namespace votess
