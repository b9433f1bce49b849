#include "arguments/nearest.hpp"

#include <algorithm>
#include <utility>

namespace clvotess {
namespace {

// Returns the edit distance, where a swap of neighbors is one change.
std::size_t changes(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before_last, last, row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before_last = std::exchange(last, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
    }
    return row.back();
}

}  // namespace

std::optional<std::string> nearest_word(std::string_view typed, const std::vector<std::string>& words) {
    constexpr std::size_t longest = 64;
    if (typed.size() > longest) return std::nullopt;
    std::optional<std::string> nearest;
    std::size_t fewest = longest;
    for (const std::string& word : words) {
        // The start of a word counts as one change, however long the rest is.
        const bool begins = typed.size() >= 3 && word.starts_with(typed);
        const std::size_t count = begins ? 1 : changes(typed, word);
        if (count >= fewest || 3 * count > word.size()) continue;
        fewest = count;
        nearest = word;
    }
    return nearest;
}

}  // namespace clvotess
