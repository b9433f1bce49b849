// One line of anything that can be printed, numbers with all their digits.
#pragma once

#include <sstream>
#include <string>

namespace test {

template <class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream out;
    out.precision(17);
    (out << ... << parts);
    return out.str();
}

}  // namespace test
