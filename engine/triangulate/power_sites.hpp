// Points with weights, and images, for a triangulation: the predicates are those of the clipper.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "exact/predicate.hpp"
#include "triangulate/triangulation.hpp"

namespace votess::cpu {

class PowerSites final : public Sites {
public:
    struct Site {
        exact::Point point;
        exact::Shift shift;
        double weight;
    };
    // Adds four sites for Delaunay. lattice: of the shifts, or null.
    explicit PowerSites(std::vector<Site> sites, const exact::Lattice* lattice = nullptr);
    [[nodiscard]] int orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const override;
    [[nodiscard]] int insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                               std::int32_t p) const override;

private:
    // Each coordinate is the sum of both, up to an error.
    struct Place {
        exact::Point high, low;
    };

    void find_places();
    [[nodiscard]] const exact::Point& point_of(std::int32_t i) const {
        return sites_[static_cast<std::size_t>(i)].point;
    }
    [[nodiscard]] exact::Plane bisector(std::int32_t from, std::int32_t to) const;
    void subtract(std::int32_t from, std::int32_t last, exact::Point& row, exact::Point& size) const;

    std::vector<Site> sites_;
    const exact::Lattice* lattice_;
    std::vector<Place> places_;  // empty if they are too far for rounded tests
    double place_error_ = 0;     // of differences of places
};

}  // namespace votess::cpu
