#pragma once

#include <span>
#include <string>

namespace votess {

// Returns the shortest text that reads back as the same double.
std::string number(double value);
// Returns the numbers in parentheses.
std::string in_parentheses(std::span<const double> place);
// Quotes a user's text for a message. Control bytes become question marks, so that the message stays one line.
std::string in_quotes(std::string text);
inline constexpr const char* axis_name[3] = {"x", "y", "z"};

}  // namespace votess
