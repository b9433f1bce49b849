// The domain of a run. Options override the file; the file overrides the default box.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <votess/votess.hpp>

#include "read/input.hpp"

namespace clvotess {

// Sources of box (or cell) and periodic axes, which may differ.
struct DomainFrom {
    DomainSource box = DomainSource::by_default, periodic = DomainSource::by_default;
};

// Returns the number of components of vectors: 3, in the plane 2.
[[nodiscard]] std::size_t size_of_vectors(const votess::Tessellation& cells);

// Returns "option", "stated", "assumed" or "default".
[[nodiscard]] const char* word_of(DomainSource source);

// Completes the domain of the options, which hold --box or --cell if given. periodic: value of --periodic. hull: --box
// hull is given, whose walls set_hull() makes. Throws Failure when a periodic axis has no length.
[[nodiscard]] DomainFrom choose_domain(const FileDomain& stated, const std::optional<std::array<bool, 3>>& periodic,
                                       votess::Options& options, bool hull = false);

// Throws Failure for points outside of a cell whose corner the file does not state, unless the user drops or keeps
// those.
void check_corner(const Input& input, const votess::Options& options, const DomainFrom& from);

// Sets the walls of --box hull. Throws votess::Error for other options of a domain.
void set_hull(std::span<const double> points, votess::Options& options);

// Throws Failure, which names the file, if a cell that it states repeats along an edge of length 0.
void check_edges(const std::string& path, const votess::TriclinicBox& cell);
// Returns whether the domain of a diagram has ends, once options are settled. hull: see choose_domain().
[[nodiscard]] bool has_ends(const votess::Options& options, bool hull);

// In two dimensions leaves z 0 in the box of --box none.
void set_ends_of_z(votess::Options& options);

// Sets Options::planar for points of the plane. Throws Failure if the options have a domain of two dimensions, but the
// points have three coordinates.
void choose_dimensions(bool planar, votess::Options& options);

// Returns the line of the summary: "box 0,0,0 to 1,1,1, periodic xy; box stated, periodicity assumed".
[[nodiscard]] std::string domain_text(const votess::Tessellation& cells, const DomainFrom& from);
// Returns a JSON object: kind, lower, upper, origin, a, b, c, periodic, from, periodic_from.
[[nodiscard]] std::string domain_json(const votess::Tessellation& cells, const DomainFrom& from);

}  // namespace clvotess
