// StarWalk: the planes of bisectors, in floats, doubles and exactly.
#pragma once

#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

template <class Isa>
void StarWalk<Isa>::plane_through(std::int32_t id, Four& n, double& h, double& square) {
    if (id < 0) {
        wall_plane(id, n, h);
        square = 2 * h;
        return;
    }
    const auto i = static_cast<std::size_t>(id);
    const Wide q{seeds_.x[i], seeds_.y[i], seeds_.z[i], 0}, p{p_[0], p_[1], p_[2], 0};
    wide(n) = q - p;
    if (!plain_ && seeds_.images != nullptr && (any_moved_ || seeds_.images->is_image(id))) add_low(id, n);
    wide(n) *= scale_;
    square = dot(wide(n), wide(n));
    h = 0.5 * square;
    if (!plain_ && weighted_) h = 0.5 * (square + (weight_ - weight_of(id)) * scale_ * scale_);
}

// Adds what the rounding of coordinates took.
template <class Isa>
void StarWalk<Isa>::add_low(std::int32_t id, Four& n) const {
    // Where places nearly cancel, what a third double holds would be missing, and so would be the rounding of this sum.
    if ((moved_ || any_rough_) && may_cancel(id, n)) {
        const auto [x, y, z] = exact::differences(base_.point, exact_plane(id)).x;
        wide(n) = Wide{x.high, y.high, z.high, 0};
        return;
    }
    const auto& low = seeds_.images->low(id);
    wide(n) += Wide{low[0], low[1], low[2], 0} - wide(low_);
}

template <class Isa>
bool StarWalk<Isa>::may_cancel(std::int32_t id, const Four& n) const {
    const double size = closest_moved * seeds_.images->largest_coordinate();
    return (moved_ && dot(wide(n), wide(n)) < size * size) || (any_rough_ && seeds_.images->is_rough(id));
}

template <class Isa>
void StarWalk<Isa>::need_plane(int slot) {
    if (((planes_known_ >> slot) & 1) != 0) return;
    planes_known_ |= 1ull << slot;
    id_[slot] = cells_.id(local_[slot]);
    plane_through(id_[slot], n_[slot], h_[slot], square_[slot]);
}

template <class Isa>
void StarWalk<Isa>::need_facing(int slot) {
    if (((facings_known_ >> slot) & 1) == 0) find_facing(slot);
}

template <class Isa>
void StarWalk<Isa>::find_facing(int slot) {
    facings_known_ |= 1ull << slot;
    need_plane(slot);
    face(slot);
}

template <class Isa>
void StarWalk<Isa>::face(int slot) {
    const double inverse = 1 / std::sqrt(square_[slot]);
    narrow(wide(n_[slot]) * inverse, facing_[slot].normal);
    facing_[slot].distance = static_cast<float>(h_[slot] * inverse);
}

template <class Isa>
exact::Plane StarWalk<Isa>::exact_plane(std::int32_t id) const {
    if (id < 0) return walls_[static_cast<std::size_t>(wall_places_[static_cast<std::size_t>(-1 - id)])].plane;
    if (seeds_.images != nullptr)
        return powered(seeds_.images->bisector(base_, seeds_.images->home(id), seeds_.images->shift(id)), id);
    const auto i = static_cast<std::size_t>(id);
    return powered(exact::Plane::bisector({seeds_.x[i], seeds_.y[i], seeds_.z[i]}), id);
}

template <class Isa>
exact::Plane StarWalk<Isa>::powered(exact::Plane plane, std::int32_t id) const {
    if (weighted_) plane.power = exact::two_sum(weight_, -weight_of(id));
    return plane;
}

// Whether two bisectors may be one plane: the farther seed then has the face, which the clipper decides.
template <class Isa>
bool StarWalk<Isa>::any_parallel(std::span<const std::int32_t> cells) {
    constexpr double nearly = 1e-20;
    std::array<Four, most_ties> normals;
    std::array<double, most_ties> squares;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        double h;
        plane_through(cells_.id(cells[i]), normals[i], h, squares[i]);
        for (std::size_t j = 0; j < i; ++j) {
            Wide across;
            cross(wide(normals[i]), wide(normals[j]), across);
            if (dot(across, across) <= nearly * squares[i] * squares[j] && dot(wide(normals[i]), wide(normals[j])) > 0)
                return true;
        }
    }
    return false;
}

}  // namespace votess::cpu
