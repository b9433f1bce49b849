#pragma once

#include <string>

namespace votess {

// The shortest text that reads back as the same double.
std::string number(double value);
// These are the names of the axes.
inline constexpr const char* axis_name[3] = {"x", "y", "z"};

}  // namespace votess
