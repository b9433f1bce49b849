// What a mistyped word may have meant.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clvotess {

// Returns the word that takes the fewest changes of a letter, the first of several. A change puts in, leaves out or
// replaces one, or swaps two neighbors. Returns nothing when each word takes more than a third of its length.
[[nodiscard]] std::optional<std::string> nearest_word(std::string_view typed, const std::vector<std::string>& words);

}  // namespace clvotess
