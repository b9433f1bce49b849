// Points with weights, and images, for a triangulation: the predicates are those of the clipper.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "exact/double_double.hpp"
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
    explicit PowerSites(std::vector<Site> sites, const exact::Lattice* lattice = nullptr)
        : sites_(std::move(sites)), lattice_(lattice) {
        for (const exact::Point& point : {exact::Point{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
            sites_.push_back({point, {}, 0});
    }
    [[nodiscard]] int orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const override {
        return exact::orientation(point_of(d), bisector(d, a), bisector(d, b), bisector(d, c));
    }
    [[nodiscard]] int insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                               std::int32_t p) const override {
        const std::array planes{bisector(d, a), bisector(d, b), bisector(d, c), bisector(d, p)};
        const auto side = [&](const auto& of) {
            return exact::side_of_vertex(point_of(d), of[0], of[1], of[2], of[3]);
        };
        if (const int sign = side(planes); sign != 0) return sign;
        // Ties are decided as if weights grew by an infinitesimal part of |x|^2. That hides sites between others whose
        // cells have no volume: they would part the neighbors on both sides of them.
        auto plain = planes;
        for (exact::Plane& plane : plain) plane.power = {};
        return -side(plain);
    }

private:
    [[nodiscard]] const exact::Point& point_of(std::int32_t i) const {
        return sites_[static_cast<std::size_t>(i)].point;
    }
    [[nodiscard]] exact::Plane bisector(std::int32_t from, std::int32_t to) const {
        const Site &a = sites_[static_cast<std::size_t>(from)], &b = sites_[static_cast<std::size_t>(to)];
        exact::Plane plane = exact::Plane::bisector(b.point);
        if (lattice_ != nullptr) {
            exact::Shift by = b.shift;
            for (std::size_t j = 0; j < by.size(); ++j) by[j] -= a.shift[j];
            plane = exact::Plane::bisector(b.point, by, *lattice_);
        }
        plane.power = exact::two_sum(a.weight, -b.weight);
        return plane;
    }

    std::vector<Site> sites_;
    const exact::Lattice* lattice_;
};

}  // namespace votess::cpu
