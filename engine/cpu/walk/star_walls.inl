// StarWalk: walls. To the walk a wall is the bisector of the seed and its mirror image.
#pragma once

#include "cpu/clip/cell.hpp"
#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

template <class Isa>
void StarWalk<Isa>::begin_job(const Domain& domain) {
    domain_ = &domain;
    weighted_ = domain.has_weights();
    weight_ = 0;
    plain_ = !weighted_ && seeds_.images == nullptr;
    walls_.clear();
    wall_places_.assign(6 + domain.walls.size(), -1);
    double size = largest_coordinate(domain.box);
    for (int k = 0; k < 3; ++k) size = std::max(size, std::abs(domain.origin[k]));
    for (std::size_t w = 0; w < wall_places_.size(); ++w) {
        const int of_box = static_cast<int>(w);
        if (w < 6 && !domain.has_box_wall(of_box)) continue;
        wall_places_[w] = static_cast<std::int32_t>(walls_.size());
        Wall wall{};
        wall.id = -1 - of_box;
        wall.plane = w < 6 ? domain.box_wall(of_box) : domain.walls[w - 6];
        wall.mirror_of = ~std::size_t{0};
        if (wall.plane.is_oblique()) {
            const CellPlane at_origin = make_plane({}, wall.id, wall.plane);
            const double inverse = 1 / at_origin.norm;
            for (std::size_t k = 0; k < 3; ++k) wall.normal[k] = at_origin.n[k] * inverse;
            wall.offset = at_origin.h * inverse;
            wall.error = 64 * unit * (4 * size + std::abs(wall.offset));
        } else {
            const int axis = of_box / 2;
            wall.normal[static_cast<std::size_t>(axis)] = of_box % 2 == 0 ? -1 : 1;
            wall.offset = of_box % 2 == 0 ? -domain.box.lower[axis] : domain.box.upper[axis];
        }
        walls_.push_back(wall);
    }
}

// At most how far the seed lies inside.
template <class Isa>
double StarWalk<Isa>::distance_to(const Wall& wall) const {
    const auto& n = wall.normal;
    return wall.offset - (n[0] * p_[0] + n[1] * p_[1] + n[2] * p_[2]) - wall.error;
}

// Those nearer than `reach` to a box.
template <class Isa>
void StarWalk<Isa>::collect_near_walls(const Box& home, double reach) {
    near_walls_.clear();
    for (std::size_t w = 0; w < walls_.size(); ++w) {
        const auto& n = walls_[w].normal;
        double farthest = 0;
        for (int k = 0; k < 3; ++k) farthest += n[k] * (n[k] > 0 ? home.upper[k] : home.lower[k]);
        if (walls_[w].offset - farthest - 2 * walls_[w].error < reach) near_walls_.push_back(w);
    }
}

template <class Isa>
bool StarWalk<Isa>::add_near_walls() {
    const double reach = longest_;
    bool oblique = false;
    for (const std::size_t w : near_walls_) {
        const Wall& wall = walls_[w];
        if (2 * distance_to(wall) * scale_ * (1 - margin) >= reach) continue;
        if (!add_candidate(wall.id)) return false;
        oblique = oblique || wall.plane.is_oblique();
    }
    near_walls_end_ = candidates_.count;
    return !oblique || !two_walls_coincide();
}

template <class Isa>
bool StarWalk<Isa>::add_walls() {
    have_walls_ = true;
    bool oblique = false;
    const std::int32_t *near = candidates_.id, *near_end = near + near_walls_end_;
    for (const Wall& wall : walls_) {
        if (std::find(near, near_end, wall.id) != near_end) continue;
        if (!add_candidate(wall.id)) return false;
        oblique = oblique || wall.plane.is_oblique();
    }
    return !oblique || !two_walls_coincide();
}

// Whether two walls may be one plane: the first then has the face, as the clipper decides, which takes them in order.
template <class Isa>
bool StarWalk<Isa>::two_walls_coincide() const {
    constexpr float nearly = 1e-5f;
    const CandidatePlanes& c = candidates_;
    for (int i = 0; i < c.count; ++i) {
        if (c.id[i] >= 0) continue;
        for (int j = 0; j < i; ++j) {
            if (c.id[j] >= 0) continue;
            const float apart = std::abs(c.nx[i] - c.nx[j]) + std::abs(c.ny[i] - c.ny[j]) + std::abs(c.nz[i] - c.nz[j]);
            if (apart <= nearly * (std::abs(c.nx[i]) + std::abs(c.ny[i]) + std::abs(c.nz[i]))) return true;
        }
    }
    return false;
}

template <class Isa>
void StarWalk<Isa>::wall_plane(std::int32_t id, Four& n, double& h) {
    Wall& wall = wall_of(id);
    if (wall.mirror_of != seed_) {
        wall.mirror_of = seed_;
        wall.n = {};
        wall.h = 0;
        if (!wall.plane.is_oblique()) {
            const int axis = (-1 - id) / 2;
            const double distance = wall.plane.wall - p_[static_cast<std::size_t>(axis)];
            wall.n.x[axis] = 2 * distance;
            wall.h = 2 * distance * distance;
        } else {  // moves are along walls
            const CellPlane plane = make_plane(base_.point, id, wall.plane);
            std::ranges::copy(mirror_image(plane), wall.n.x);
            if (plane.reliable && plane.h > 0) wall.h = 2 * plane.h / (plane.norm * plane.norm) * plane.h;
        }
    }
    wide(n) = wide(wall.n) * scale_;
    h = wall.h * scale_ * scale_;
}

}  // namespace votess::cpu
