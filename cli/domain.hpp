// The domain of a run: what the user names goes before what the file states, and that before the bounds of the points.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <votess/votess.hpp>

#include "read/input.hpp"

namespace clvotess {

// Box (or cell) and periodic axes may come from different sources.
struct DomainFrom {
    DomainSource box = DomainSource::by_default, periodic = DomainSource::by_default;
};

// "option", "stated", "assumed" or "default".
[[nodiscard]] const char* word_of(DomainSource source);

// options: with --box or --cell if given; they get the rest. periodic: of --periodic. Throws Failure when a periodic
// axis has no length.
[[nodiscard]] DomainFrom choose_domain(const FileDomain& stated, const std::optional<std::array<bool, 3>>& periodic,
                                       votess::Options& options);

// For the summary: "box 0,0,0 to 1,1,1, periodic xy; box stated, periodicity assumed".
[[nodiscard]] std::string domain_text(const votess::Tessellation& cells, const DomainFrom& from);
// An object: kind, lower, upper, origin, a, b, c, periodic, from, periodic_from.
[[nodiscard]] std::string domain_json(const votess::Tessellation& cells, const DomainFrom& from);

}  // namespace clvotess
