#pragma once

#include <sstream>
#include <string>

namespace test {

// Returns one line of anything that can be printed, numbers with all their digits.
template <class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream out;
    out.precision(17);
    (out << ... << parts);
    return out.str();
}

inline bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace test
