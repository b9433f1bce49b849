// StarWalk: which planes are looked at.
#pragma once

#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

// A first guess that depends on nothing but the stretch: the answer, to the last bit, is the same for any number of
// threads. The seeds of a box of the tree take about its volume each.
template <class Isa>
void StarWalk<Isa>::guess_reach(std::size_t group) {
    const int level = std::min(1, hierarchy_.top_level());
    const std::size_t seeds = level == 1 ? group_size * box_fan : group_size, first = group * group_size;
    const Box box = hierarchy_.box(level, first / seeds);
    double longest = 0, volume = 1;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, box.upper[k] - box.lower[k]);
    for (int k = 0; k < 3; ++k) volume *= std::max(box.upper[k] - box.lower[k], 0.01 * longest);
    const double count = static_cast<double>(std::min(seeds, seeds_.size() - first / seeds * seeds));
    typical_reach_ = 5 * std::pow(volume / count, 2.0 / 3);
}

template <class Isa>
void StarWalk<Isa>::begin(std::size_t first, std::size_t last, Keep keep) {
    forget_planes();
    cells_.begin(seeds_, first, last, static_cast<std::int32_t>(wall_places_.size()), keep == Keep::places);
    make_room(cells_.locals());
    keep_ = keep;
    probing_ = false;
    own_images_ = std::numeric_limits<double>::infinity();
    any_moved_ = seeds_.images != nullptr && seeds_.images->any_moved();
    any_rough_ = seeds_.images != nullptr && seeds_.images->any_rough();
    low_ = {};
    moved_ = false;
    window_home_ = ~std::size_t{0};
    guess_reach(first / group_size);
}

template <class Isa>
void StarWalk<Isa>::begin_probes(std::size_t group, Keep keep) {
    begin(0, 0, keep);
    probing_ = true;
    if (seeds_.images != nullptr) own_images_ = nearest_translation(*domain_);
    guess_reach(group);
}

template <class Isa>
void StarWalk<Isa>::look_around(const Box& box, double lightest) {
    probes_box_ = box;
    lightest_probe_ = lightest;
    window_home_ = ~std::size_t{0};
}

template <class Isa>
void StarWalk<Isa>::open_window(std::size_t home, double reach2) {
    window_home_ = home;
    Box box = probing_ ? probes_box_ : window_.home_box(home);
    const double lightest = probing_ ? lightest_probe_ : least_weight(home);
    const double radius = std::sqrt(with_weights(reach2, lightest)) * 1.02;
    window_open_ = window_.open(home, box, radius, lightest, cells_);
    // A home may span far more than its surroundings, where the curve leaves a cluster.
    if (!window_open_) {
        box = {p_, p_};
        window_open_ = window_.open(home, box, radius, lightest, cells_);
        window_home_ = ~std::size_t{0};
    }
    if (!window_open_) return;
    collect_near_walls(box, window_.reach());
    for (std::size_t s = home * Window::home_seeds; s < seed_ && !probing_; ++s)
        if (cells_.holds(static_cast<std::int64_t>(s)) && cells_.done(s)) window_.hide(s);
}

// Whether a candidate may lie where the seed does: window integers are exact to half a unit each.
template <class Isa>
bool StarWalk<Isa>::may_coincide() const {
    constexpr float near = 2;
    const CandidatePlanes& c = candidates_;
    bool any = false;
    for (int i = near_walls_end_; i < c.count; ++i)
        any |= std::abs(c.nx[i]) <= near && std::abs(c.ny[i]) <= near && std::abs(c.nz[i]) <= near;
    return any;
}

template <class Isa>
bool StarWalk<Isa>::gather_candidates() {
    double reach2 = reach_margin * typical_reach_;
    const std::size_t home = probing_ ? Window::no_home : seed_ / Window::home_seeds;
    if (window_home_ != home) open_window(home, reach2);
    if (!window_open_ || !(probing_ || window_.holds(seed_))) return false;
    reach2 = std::min(with_weights(reach2, weight_), window_.reach() * window_.reach());
    const double scale = window_.scale();
    float weight = 0;
    if (weighted_) {
        more_ = std::max(0.0, domain_->most_more(weight_)) * scale * scale;
        weight = window_.weight(weight_);
        weight_span_ = window_.weight_span(weight);
    }
    const auto p = probing_ ? window_.position(p_) : window_.position(seed_);
    if (!probing_) window_.hide(seed_);
    have_candidates_ = true;
    own_x_ = p[0];
    scale_ = scale;
    unscale_ = 1 / scale;
    if (seeds_.images != nullptr) set_image_reach(seeds_.images->least_reach());
    planes_known_ = facings_known_ = 0;
    for (int tries = 0;; ++tries) {
        const double reach = std::sqrt(reach2) * scale;
        set_longest(reach * (1 + 0x1p-20) + quantum);
        candidates_.count = 0;
        if (!add_near_walls()) return false;
        const double square = reach2 * scale * scale, near_square = near_share * square;
        if (Isa::select(window_.seeds(), p.data(), weight, static_cast<float>(near_square), static_cast<float>(square),
                        candidates_) &&
            candidates_.count <= most_candidates) {
            covered_ = surely_covered(square);
            near_covered_ = surely_covered(near_square);
            break;
        }
        if (tries == 8) return false;
        reach2 *= 0.5;
    }
    extras_ = candidates_.count;
    return true;
}

// The squared security radius for vertices whose distance is half of sqrt(reach2).
template <class Isa>
double StarWalk<Isa>::with_weights(double reach2, double weight) const {
    if (!weighted_) return reach2;
    const double x2 = 0.25 * reach2, reach = std::sqrt(x2) + std::sqrt(x2 + std::max(0.0, domain_->most_more(weight)));
    return reach * reach;
}

template <class Isa>
double StarWalk<Isa>::least_weight(std::size_t home) const {
    if (!weighted_) return 0;
    const std::size_t begin = home * Window::home_seeds, end = std::min(begin + Window::home_seeds, seeds_.size());
    return *std::min_element(seeds_.weights.begin() + static_cast<std::ptrdiff_t>(begin),
                             seeds_.weights.begin() + static_cast<std::ptrdiff_t>(end));
}

// Sets the length and the margin that follows from it.
template <class Isa>
void StarWalk<Isa>::set_longest(double length) {
    longest_ = length;
    const bounds::FloatMargin m =
        weighted_ ? bounds::float_margin(longest_, more_, weight_span_) : bounds::float_margin(longest_);
    rounding_by_square_ = m.by_square;
    rounding_ = m.constant;
}

// The squared distance within which all seeds are candidates that were looked for within this one.
template <class Isa>
double StarWalk<Isa>::surely_covered(double square) const {
    const double covered = std::sqrt(square) * (1 - 0x1p-20) - quantum;
    return covered > 0 ? covered * covered : 0;
}

template <class Isa>
bool StarWalk<Isa>::add_candidate(std::int32_t id) {
    CandidatePlanes& c = candidates_;
    if (c.count == CandidatePlanes::capacity) return false;
    Four n;
    double h, square;
    plane_through(id, n, h, square);
    const double length = std::sqrt(square);
    if (!(length < longest_normal)) return false;
    if (length * (1 + 0x1p-20) > longest_) set_longest(length * (1 + 0x1p-20));
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

// The nearest seed is a neighbor, and the middle between the two lies inside their face. From there any way along the
// face leads to an edge.
template <class Isa>
bool StarWalk<Isa>::begin_anywhere() {
    if (!have_candidates_ && !gather_candidates()) return false;
    if (candidates_.count == 0 && !add_walls()) return false;
    const CandidatePlanes& c = candidates_;
    if (c.count == 0) return false;  // a periodic domain has no walls
    if (!weighted_) return begin_at_face(static_cast<int>(std::min_element(c.h, c.h + c.count) - c.h));
    for (int i = 0; i < c.count; ++i)
        distance_[i] = c.h[i] / std::sqrt(c.nx[i] * c.nx[i] + c.ny[i] * c.ny[i] + c.nz[i] * c.nz[i]);
    const auto nearest = std::min_element(distance_.begin(), distance_.begin() + c.count);
    if (*nearest < parallel * static_cast<float>(longest_)) return begin_outside();
    return begin_at_face(static_cast<int>(nearest - distance_.begin()));
}

// The seed lies outside of its cell, or nearly: the clipper finds an edge, or that the cell is empty. A few of the
// nearest planes are enough to leave nothing; the order of the others does not matter.
template <class Isa>
bool StarWalk<Isa>::begin_outside() {
    constexpr int nearest_first = 8;
    constexpr float taken = std::numeric_limits<float>::infinity();
    const std::int32_t own = own_id_;
    probe_.start(base_.point, *domain_, own);
    const auto begin = distance_.begin(), end = begin + candidates_.count;
    auto next = begin;
    for (int tries = 0; tries < nearest_first || next != end; ++tries) {
        const auto at = tries < nearest_first ? std::min_element(begin, end) : next++;
        const std::int32_t id = candidates_.id[at - begin];
        if (*at == taken || id < 0) continue;
        *at = taken;
        probe_.clip(id, exact_plane(id));
        if (probe_.empty()) {
            used_exact_ = probe_.used_exact();
            return empty_ = true;
        }
    }
    if (!have_walls_ && !add_walls()) return false;
    for (int slot = 0; slot < probe_.slots(); ++slot) {
        if (!probe_.alive(slot)) continue;
        const auto planes = probe_.corner_planes(slot);
        // In a periodic box it begins with images of the seed, which are no candidates.
        if (std::ranges::any_of(planes, [own](const CellPlane* plane) { return plane->id == own; })) continue;
        const int a = new_slot(planes[0]->id), b = new_slot(planes[1]->id);
        stack(a, b);
        return true;
    }
    return false;
}

template <class Isa>
bool StarWalk<Isa>::begin_at_face(int nearest) {
    const CandidatePlanes& c = candidates_;
    const int a = new_slot(c.id[nearest]);
    need_plane(a);
    const auto& n = n_[a].x;
    const double foot = h_[a] / square_[a];
    const double skew[3] = {0.61803398875 * n[1], 0.7548776662 * n[2],
                            0.5698402910 * n[0] + std::sqrt(0.5 * square_[a])};
    Ray ray;
    float size = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        ray.o[k] = static_cast<float>(foot * n[k]);
        ray.d[k] = static_cast<float>(n[i] * skew[j] - n[j] * skew[i]);
        size += std::abs(ray.d[k]);
    }
    ray.s = 1;
    ray.least = parallel * size * static_cast<float>(longest_);
    const int hit = first_hit(ray);
    if (hit < 0) return false;
    stack(a, new_slot(c.id[hit]));
    return true;
}

// Bits of those of eight seeds beyond the candidates that may cut off the vertex.
template <class Isa>
unsigned StarWalk<Isa>::find_inside(std::size_t begin, const GroupTest& test) const {
    if (weighted_) return find_inside_weighted(begin, test);
    return Isa::inside_ball(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], test, covered_);
}

template <class Isa>
unsigned StarWalk<Isa>::find_inside_weighted(std::size_t begin, const GroupTest& test) const {
    double more[box_fan] = {}, excess[box_fan], square[box_fan];
    const std::size_t count = seeds_.group_end(begin) - begin;
    for (std::size_t i = 0; i < count; ++i)
        more[i] = (weight_of(static_cast<std::int32_t>(begin + i)) - weight_) * scale_ * scale_;
    const double *x = &seeds_.x[begin], *y = &seeds_.y[begin], *z = &seeds_.z[begin];
    for (int i = 0; i < box_fan; ++i) {
        const double nx = (x[i] - p_[0]) * scale_, ny = (y[i] - p_[1]) * scale_, nz = (z[i] - p_[2]) * scale_;
        square[i] = nx * nx + ny * ny + nz * nz;
        const double slack = 8 * margin * (square[i] + std::abs(more[i]) + more_) + 4 * test.slack;
        excess[i] = nx * test.v[0] + ny * test.v[1] + nz * test.v[2] - 0.5 * (square[i] - more[i]) + slack;
    }
    unsigned inside = 0;
    // Not a number where the seed is padding, infinitely far away.
    for (int i = 0; i < box_fan; ++i) inside |= static_cast<unsigned>((excess[i] >= 0) & (square[i] >= covered_)) << i;
    return inside;
}

// In a power diagram done seeds matter to a cell that knows no vertex: if it is not empty none of them is its neighbor,
// and none cuts off its first vertex; if it is empty, some cut off all of space. True when that decides, or is left to
// the clipper.
template <class Isa>
bool StarWalk<Isa>::is_hidden(const std::int32_t* three, const Third& third, const Four& x) {
    Box at;
    double size = 0;
    for (int k = 0; k < 3; ++k) {
        const double offset = x.x[k] * unscale_;
        at.lower[k] = at.upper[k] = p_[k] + offset;
        size = std::max(size, std::abs(p_[k]) + std::abs(offset));
    }
    const double reach = in_places(bounds::widest_reach(dot(wide(x), wide(x)), more_), size);
    std::size_t nodes = 1;
    nodes_[0] = {hierarchy_.top_level(), 0};
    while (nodes > 0) {
        const auto [level, index] = nodes_[--nodes];
        unsigned near = Isa::near_boxes(hierarchy_.block(level, index), at, reach * reach);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            const std::size_t begin = Hierarchy::first_seed(level, child);
            const std::size_t end = Hierarchy::first_seed(level, child + 1);
            if (!cells_.overlaps(begin, end)) continue;
            if (level > 0) {
                nodes_[nodes++] = {level - 1, child};
                continue;
            }
            for (std::size_t i = begin; i < end; ++i) {
                if (!cells_.holds(static_cast<std::int64_t>(i)) || !cells_.done(i)) continue;
                const int side = side_of(static_cast<std::int32_t>(i), three, third, x);
                empty_ = side > 0;
                if (side >= 0) return true;
            }
        }
    }
    return false;
}

template <class Isa>
int StarWalk<Isa>::side_of(std::int32_t id, const std::int32_t* three, const Third& third, const Four& x) {
    if (const int sure = sure_side(id, third, relative_error(third), x); sure != 0) return sure;
    used_exact_ = true;
    return exact::side_of_vertex(base_.point, exact_plane(three[0]), exact_plane(three[1]), exact_plane(three[2]),
                                 exact_plane(id));
}

// Seeds beyond the candidates that the sphere around the vertex may hold: not all of them, for each that is found moves
// the vertex along its edge, and the sphere shrinks.
//
// The edge need not be searched again, unless there were most_new of them. It begins at a proven vertex, where
// n.x - h <= 0 for all seeds. Along the edge n.x - h is linear: if it is >= 0 at some vertex, it is so at all vertices
// behind, and the search around those has found the seed.
template <class Isa>
bool StarWalk<Isa>::add_inside(const Line& line, const Third& of_vertex, Four x, const std::int32_t* three,
                               int& added) {
    Box at;
    double x2 = 0, length = 0, size = 0, reach2 = 0;
    GroupTest test{p_, scale_, {}, 0};
    auto look_around = [&](double length2) {
        size = 0;
        for (int k = 0; k < 3; ++k) {
            const double offset = x.x[k] * unscale_;
            at.lower[k] = at.upper[k] = p_[k] + offset;
            size = std::max(size, std::abs(p_[k]) + std::abs(offset));
            test.v[k] = x.x[k];
        }
        x2 = dot(wide(x), wide(x));
        length = std::sqrt(length2);
        const double reach = in_places(bounds::widest_reach(x2, more_), size);
        reach2 = reach * reach;
        test.slack = 2 * margin * x2;
    };
    look_around(of_vertex.length2);
    // The same for seeds that are no heavier, 0 if there is none: the sphere shrinks to nothing for the lightest.
    auto reach_of = [&](double heaviest) {
        const double more = (heaviest - weight_) * scale_ * scale_;
        if (more >= more_) return reach2;
        const double rounding = 8 * unit * (std::abs(heaviest) + std::abs(weight_)) * scale_ * scale_;
        const double distance = bounds::reach_from_vertex(std::sqrt(x2), length, more + rounding);
        if (distance == 0) return 0.0;
        const double reach = in_places(distance, size);
        return reach * reach;
    };
    std::size_t nodes = 1;
    nodes_[0] = {hierarchy_.top_level(), 0};
    while (nodes > 0) {
        const auto [level, index] = nodes_[--nodes];
        unsigned near = Isa::near_boxes(hierarchy_.block(level, index), at,
                                        weighted_ ? reach_of(hierarchy_.largest_weight_below(level, index)) : reach2);
        if (level > 0) {
            for (; near != 0; near &= near - 1)
                nodes_[nodes++] = {level - 1, index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near))};
            continue;
        }
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (cells_.group_done(child)) continue;
            if (weighted_ && reach_of(hierarchy_.largest_weight(0, child)) == 0) continue;
            const std::size_t begin = std::size_t{child} * group_size;
            unsigned inside = find_inside(begin, test);
            while (inside != 0) {
                const int k = std::countr_zero(inside);
                inside &= inside - 1;
                const auto id = static_cast<std::int32_t>(begin) + k;
                if (id == own_id_ || id == three[0] || id == three[1] || id == three[2]) continue;
                Third third;
                Four nearer;
                plane_through(id, third.n, third.h, third.square);
                const double excess = dot(wide(third.n), wide(x)) - third.h;
                // No candidate is surely inside.
                if (!(excess > 4 * test.slack + 8 * margin * third.square) && is_extra(id)) continue;
                if (!add_candidate(id)) return false;
                if (++added == most_new) return true;
                if (excess > 0 && solve(line, third, nearer)) {
                    x = nearer;
                    look_around(error_length2(line, third, dot(wide(x), wide(x))));
                    inside &= find_inside(begin, test);
                }
            }
        }
    }
    return true;
}

}  // namespace votess::cpu
