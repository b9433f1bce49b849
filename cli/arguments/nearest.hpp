// Finds the word that a mistyped one may mean.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clvotess {

// Returns the word with the fewest changed letters; the first of several. A change inserts, deletes or replaces a
// letter, or swaps two neighbors. Returns nothing when each word needs more than a third of its length.
[[nodiscard]] std::optional<std::string> nearest_word(std::string_view typed, const std::vector<std::string>& words);

}  // namespace clvotess
