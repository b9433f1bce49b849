// The planes of a kept cell at the present places: exact, and rounded as the walk and the clipper round them.
#pragma once

#include "domain/domain.hpp"
#include "follow/kept_cell.hpp"
#include "follow/sign_test.hpp"
#include "index/seed_images.hpp"
#include "index/sorted_seeds.hpp"
#include "polytope/cell.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

class KeptPlanes final : public ExactCorners {
public:
    explicit KeptPlanes(const SortedSeeds& seeds) : seeds_(seeds) {}
    // places: of all sorted seeds.
    void begin_job(const Domain& domain, const SeedPlace* places) {
        domain_ = &domain;
        places_ = places;
    }
    void begin(std::size_t seed, const KeptCell& cell) {
        seed_ = seed;
        cell_ = cell;
        base_ = {{seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]}, {}};
        if (seeds_.images != nullptr) base_ = seeds_.images->base(seed);
    }
    [[nodiscard]] const exact::Point& seed() const { return base_.point; }
    [[nodiscard]] exact::Plane plane(std::size_t face) const {
        const std::int32_t id = cell_.ids()[face];
        if (id < 0) return wall(id);
        const auto i = static_cast<std::size_t>(id);
        exact::Plane plane = seeds_.images != nullptr ? seeds_.images->bisector(base_, id, cell_.shift(face))
                                                      : exact::Plane::bisector({seeds_.x[i], seeds_.y[i], seeds_.z[i]});
        if (!seeds_.weights.empty()) plane.power = exact::two_sum(seeds_.weights[seed_], -seeds_.weights[i]);
        return plane;
    }
    // Writes the shape of the cell. It refers to this object.
    void shape(CellShape& out) const {
        const auto ids = cell_.ids();
        out.planes = out.slots = static_cast<int>(ids.size());
        out.weighted = !seeds_.weights.empty();
        out.exact = this;
        const SeedPlace& at = places_[seed_];
        const SeedImages* const images = seeds_.images;
        std::size_t walls = 0;  // which come first
        for (; walls < ids.size() && ids[walls] < 0; ++walls) {
            CellShape::Plane& plane = out.plane[walls] = {};
            const exact::Plane wall = this->wall(ids[walls]);
            if (wall.is_oblique()) {
                const auto image = mirror_image(make_plane(base_.point, ids[walls], wall));
                for (std::size_t k = 0; k < 3; ++k) plane.n[k] = 0.5 * image[k];
            } else {
                plane.n[wall.axis] = wall.wall - at.x[wall.axis];
            }
        }
        for (std::size_t f = 0; f < ids.size(); ++f) out.rank[f] = static_cast<std::uint8_t>(f);
        for (std::size_t f = walls; f < ids.size(); ++f) {
            const SeedPlace& other = places_[ids[f]];
            for (std::size_t k = 0; k < 3; ++k) out.plane[f].n[k] = 0.5 * (other.x[k] - at.x[k]);
            out.plane[f].power = -0.25 * (other.weight - at.weight);
        }
        const bool shifted = cell_.head().shifted;
        if (images != nullptr && (shifted || images->any_wrapped())) {
            const bool exact = images->is_exact(seed_);
            for (std::size_t f = walls; f < ids.size(); ++f) {
                const bool has_shift = shifted && cell_.near_shift(f) != KeptCell::NearShift{};
                if (exact && !has_shift && images->is_exact(static_cast<std::size_t>(ids[f]))) continue;
                const auto way = exact::differences(base_.point, this->plane(f)).x;
                for (std::size_t k = 0; k < 3; ++k) out.plane[f].n[k] = 0.5 * way[k].high;
            }
        }
        const auto corners = cell_.corners();
        out.corners = static_cast<int>(corners.size());
        for (std::size_t v = 0; v < corners.size(); ++v) {
            out.a[v] = corners[v][0];
            out.b[v] = corners[v][1];
            out.c[v] = corners[v][2];
        }
    }

private:
    [[nodiscard]] exact::Plane wall(std::int32_t id) const {
        return id < -6 ? domain_->walls[static_cast<std::size_t>(-7 - id)] : domain_->box_wall(-1 - id);
    }
    [[nodiscard]] std::array<double, 3> corner(const std::array<unsigned, 3>& ranks) const override {
        return exact::near_vertex(base_.point, plane(ranks[0]), plane(ranks[1]), plane(ranks[2]));
    }

    const SortedSeeds& seeds_;
    const Domain* domain_ = nullptr;
    const SeedPlace* places_ = nullptr;
    std::size_t seed_ = 0;
    KeptCell cell_;
    SeedImages::Base base_{};
};

}  // namespace votess::cpu
