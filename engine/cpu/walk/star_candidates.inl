// StarWalk: which planes are looked at.
#pragma once

#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

template <class Isa>
bool StarWalk<Isa>::gather_candidates() {
    double reach2 = reach_margin * typical_reach_;
    const std::size_t home = seed_ / Window::home_seeds;
    if (window_home_ != home) {
        window_home_ = home;
        window_open_ = window_.open(home, std::sqrt(reach2) * 1.02, cells_);
        if (window_open_)
            for (std::size_t s = home * Window::home_seeds; s < seed_; ++s)
                if (cells_.holds(static_cast<std::int64_t>(s)) && cells_.done(s)) window_.hide(s);
    }
    if (!window_open_) return false;
    reach2 = std::min(reach2, window_.reach() * window_.reach());
    const double scale = window_.scale();
    const auto p = window_.position(seed_);
    window_.hide(seed_);
    have_candidates_ = true;
    own_x_ = p[0];
    for (int tries = 0;; ++tries) {
        if (kernels_.select(window_.seeds(), p.data(), static_cast<float>(reach2 * scale * scale), candidates_) &&
            candidates_.count <= most_candidates)
            break;
        if (tries == 8) return false;
        reach2 *= 0.5;
    }
    scale_ = scale;
    unscale_ = 1 / scale;
    planes_known_ = 0;
    const double reach = std::sqrt(reach2) * scale;
    const double covered = reach * (1 - 0x1p-20) - quantum;
    covered_ = covered > 0 ? covered * covered : 0;
    longest_ = reach * (1 + 0x1p-20) + quantum;
    inverse_longest_ = 1 / longest_;
    extras_ = candidates_.count;
    if (domain_->has_cell_walls()) return !near_cell_wall();
    for (int wall = -1; wall >= -6; --wall) {
        if (!domain_->has_box_wall(-1 - wall)) continue;
        const int axis = (-1 - wall) / 2;
        const double distance = (-1 - wall) % 2 == 0 ? p_[axis] - box_.lower[axis] : box_.upper[axis] - p_[axis];
        if (2 * distance * scale < longest_) add_candidate(wall);
    }
    return true;
}

// Cells that a wall across no axis may cut are for the clipper.
template <class Isa>
bool StarWalk<Isa>::near_cell_wall() const {
    const Basis& edges = domain_->edges;
    const auto f = domain_->fraction(p_);
    double size = 0;
    for (int k = 0; k < 3; ++k) size = std::max({size, std::abs(p_[k]), std::abs(domain_->origin[k])});
    for (int j = 0; j < 3; ++j) {
        if (domain_->periodic[j]) continue;
        const double distance = (std::min(f[j], 1 - f[j]) - edges.fraction_error(j, size)) * edges.width[j];
        if (2 * distance * scale_ < longest_ * (1 + margin)) return true;
    }
    return false;
}

template <class Isa>
bool StarWalk<Isa>::add_candidate(std::int32_t id) {
    CandidatePlanes& c = candidates_;
    if (c.count == CandidatePlanes::capacity) return false;
    Four n;
    double h;
    plane_through(id, n, h);
    const double length = std::sqrt(2 * h);
    if (!(length < longest_normal)) return false;
    longest_ = std::max(longest_, length * (1 + 0x1p-20));
    inverse_longest_ = 1 / longest_;
    const int i = c.count++;
    c.nx[i] = static_cast<float>(n.x[0]);
    c.ny[i] = static_cast<float>(n.x[1]);
    c.nz[i] = static_cast<float>(n.x[2]);
    c.h[i] = static_cast<float>(h);
    c.id[i] = id;
    if (c.count % 16 == 1)
        for (int k = c.count; k < c.count + 15; ++k) {
            c.nx[k] = c.ny[k] = c.nz[k] = 0;
            c.h[k] = CandidatePlanes::never;
        }
    return true;
}

template <class Isa>
bool StarWalk<Isa>::is_extra(std::int32_t id) const {
    const std::int32_t* end = candidates_.id + candidates_.count;
    return std::find(candidates_.id + extras_, end, id) != end;
}

template <class Isa>
bool StarWalk<Isa>::add_walls() {
    if (domain_->has_cell_walls()) return false;
    have_walls_ = true;
    for (int wall = -1; wall >= -6; --wall)
        if (domain_->has_box_wall(-1 - wall) && !is_extra(wall) && !add_candidate(wall)) return false;
    return true;
}

// The nearest seed is a neighbor, and the middle between the two lies inside their face. From there any way along the
// face leads to an edge.
template <class Isa>
bool StarWalk<Isa>::begin_anywhere() {
    if (!gather_candidates()) return false;
    if (candidates_.count == extras_ && !add_walls()) return false;
    const CandidatePlanes& c = candidates_;
    if (c.count == 0) return false;  // a periodic domain has no walls
    const auto nearest = static_cast<int>(std::min_element(c.h, c.h + c.count) - c.h);
    const int a = new_slot(c.id[nearest]);
    need_plane(a);
    const auto& n = n_[a].x;
    const double skew[3] = {0.61803398875 * n[1], 0.7548776662 * n[2], 0.5698402910 * n[0] + std::sqrt(h_[a])};
    Ray ray;
    float size = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        ray.o[k] = static_cast<float>(0.5 * n[k]);
        ray.d[k] = static_cast<float>(n[i] * skew[j] - n[j] * skew[i]);
        size += std::abs(ray.d[k]);
    }
    ray.s = 1;
    ray.least = parallel * size * static_cast<float>(longest_);
    int hit = first_hit(ray);
    if (hit < 0 && !have_walls_) {
        if (!add_walls()) return false;
        hit = first_hit(ray);
    }
    if (hit < 0) return false;
    OpenEdge edge;
    return aim(a, new_slot(c.id[hit]), edge, ray) && close(edge, ray, -1);
}

// Seeds beyond the candidates that the sphere around the vertex may hold: not all of them, for each that is found moves
// the vertex along its edge, and the sphere shrinks.
template <class Isa>
bool StarWalk<Isa>::add_inside(const OpenEdge& edge, Four x, const std::int32_t* three, int& added) {
    Box at;
    double reach2 = 0;
    GroupTest test{p_, scale_, {}, 0};
    auto look_around = [&] {
        double size = 0;
        for (int k = 0; k < 3; ++k) {
            const double offset = x.x[k] * unscale_;
            at.lower[k] = at.upper[k] = p_[k] + offset;
            size = std::max(size, std::abs(p_[k]) + std::abs(offset));
            test.v[k] = x.x[k];
        }
        const double x2 = dot(wide(x), wide(x));
        const double reach = std::sqrt(x2) * unscale_ * (1 + margin) + 8 * unit * size;
        reach2 = reach * reach;
        test.slack = 2 * margin * x2;
    };
    look_around();
    nodes_.assign(1, {hierarchy_.top_level(), 0});
    while (!nodes_.empty()) {
        const Node node = nodes_.back();
        nodes_.pop_back();
        unsigned near = kernels_.near_boxes(hierarchy_.block(node.level, node.index), at, reach2);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = node.index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (node.level > 0) {
                nodes_.push_back({node.level - 1, child});
                continue;
            }
            if (cells_.group_done(child)) continue;
            const std::size_t begin = std::size_t{child} * group_size;
            const double *px = &seeds_.x[begin], *py = &seeds_.y[begin], *pz = &seeds_.z[begin];
            unsigned inside = kernels_.inside_ball(px, py, pz, test, covered_);
            while (inside != 0) {
                const int k = std::countr_zero(inside);
                inside &= inside - 1;
                const auto id = static_cast<std::int32_t>(begin) + k;
                if (static_cast<std::size_t>(id) == seed_ || id == three[0] || id == three[1] || id == three[2] ||
                    is_extra(id))
                    continue;
                if (!add_candidate(id)) return false;
                if (++added == most_new) return true;
                Third third;
                Four nearer;
                plane_through(id, third.n, third.h);
                if (dot(wide(third.n), wide(x)) > third.h && solve(edge, third, nearer)) {
                    x = nearer;
                    look_around();
                    inside &= kernels_.inside_ball(px, py, pz, test, covered_);
                }
            }
        }
    }
    return true;
}

}  // namespace votess::cpu
