// Marks the parts of a domain that are near given places or their images.
#pragma once

#include <cstdint>
#include <vector>

#include "domain/domain.hpp"

namespace votess {

class NearPlaces {
public:
    // spacing: of the grid, approximately.
    NearPlaces(const Domain& domain, double spacing);

    void add(const exact::Point& x, double distance);
    // Returns false only if x is farther from each added place than its distance.
    [[nodiscard]] bool holds(const exact::Point& x) const;
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
