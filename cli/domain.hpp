// The domain of a run: what the user names goes before what the file states, and that before the bounds of the points.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <votess/votess.hpp>

#include "read/input.hpp"

namespace clvotess {

// options: with --box or --cell if given; they get the rest. periodic: of --periodic. Returns where the domain comes
// from: "given", "file" or "bounds". Throws Failure when an axis is to repeat whose length nobody has told.
std::string choose_domain(const FileDomain& stated, const std::optional<std::array<bool, 3>>& periodic,
                          votess::Options& options);

// For the summary: "box 0,0,0 to 1,1,1, periodic xy".
[[nodiscard]] std::string domain_text(const votess::Tessellation& cells, const std::string& from);
// An object: kind, lower, upper, origin, a, b, c, periodic, from.
[[nodiscard]] std::string domain_json(const votess::Tessellation& cells, const std::string& from);

}  // namespace clvotess
