// Messages of the library in the words of the command line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clvotess {

// Returns the message with each option under its name here: Options::min_face becomes --min-face, and
// "Options::outside = drop" becomes "--outside drop". A function becomes the option that calls it: watershed() is
// --watershed.
[[nodiscard]] std::string in_words_of_options(std::string_view message);

// Returns "1 cell that reaches infinity", or "2 cells that reach infinity".
[[nodiscard]] std::string open_cells(std::uint64_t count);

}  // namespace clvotess
