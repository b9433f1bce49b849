// Which places of a domain are near one of some, or near an image of it.
#pragma once

#include <cstdint>
#include <vector>

#include "domain/domain.hpp"

namespace votess {

// Marks in a grid over the fractions of the domain's short vectors.
class NearPlaces {
public:
    // spacing: of the grid, about.
    NearPlaces(const Domain& domain, double spacing);

    // Marks all that is within that distance of x.
    void add(const exact::Point& x, double distance);
    // False only when x is beyond the distance of all that were added.
    [[nodiscard]] bool holds(const exact::Point& x) const;
    // The part of the domain that is marked.
    [[nodiscard]] double share() const;

private:
    [[nodiscard]] std::array<double, 3> fraction(const exact::Point& x) const;
    [[nodiscard]] std::int64_t step(std::size_t j, double fraction) const;

    const Domain& domain_;
    std::array<std::int64_t, 3> steps_{};
    std::array<double, 3> error_{};  // of fractions
    std::vector<std::uint8_t> marked_;
};

}  // namespace votess
