#include "surface/triangle_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/arithmetic.hpp"
#include "core/box.hpp"

namespace votess::surface {

TriangleCells::TriangleCells(const Surface& surface) : surface_(surface), kernels_(surface_kernels()) {
    functions_[0] = {0, 0, 1, 0, 0};
    functions_[1] = {-1, 1, 1, 0, 0};
    functions_[2] = {0, 1, 0, 0, 0};
    clear_corners(0, Envelope::room);
}

bool TriangleCells::make(std::int32_t triangle, ClippedTriangle& exact) {
    if (surface_.has_weights()) return false;
    const Surface::Triangle& of = surface_.triangles()[at(triangle)];
    for (std::size_t i = 0; i < 3; ++i) vertex_[i] = surface_.vertex(of.vertex[i]);
    for (std::size_t k = 0; k < 3; ++k) {
        const double a = vertex_[0][k], b = vertex_[1][k], c = vertex_[2][k];
        frame_.box.lower[k] = std::min(std::min(a, b), c);
        frame_.box.upper[k] = std::max(std::max(a, b), c);
        frame_.center[k] = (a + b + c) / 3;
        frame_.first[k] = a - frame_.center[k];
        frame_.way[0][k] = b - a;
        frame_.way[1][k] = c - a;
    }
    const auto& [first, way] = std::tie(frame_.first, frame_.way);
    frame_.length =
        std::sqrt(std::max(dot(first, first), std::max(dot(way[0], way[0]), dot(way[1], way[1])))) * (1 + 0x1p-40);
    end_ = edges;
    is_sure_ = true;
    envelope_.reach = std::numeric_limits<double>::max();
    const std::uint32_t near = hint_ == none ? none : hint_ - hint_ % group;
    if (near != none) add_group(near);
    const auto skip = [&](const SeedTree::Node& node) {
        return node.level > 0 && is_beyond_balls(surface_.tree().box(node));
    };
    surface_.tree().visit(frame_.box, envelope_.reach, skip, [&](std::uint32_t begin, std::uint32_t) {
        if (begin != near) add_group(begin);
    });
    if (!is_sure_) return false;
    settle(triangle, exact);
    std::fill_n(side_of_site_.begin(), end_, none);
    for (std::uint32_t c = 0; c < envelope_.count; ++c)
        for (std::uint32_t k = 0; k < 3; ++k) side_of_site_[corners_[c].site[k]] = turn(4 * c + k);
    part_count_ = 0;
    for (Site site = edges; site < end_; ++site)
        if (side_of_site_[site] != none) parts_[part_count_++] = {site, side_of_site_[site]};
    hint_ = functions_[parts_[0].first].number;
    return true;
}

void TriangleCells::add_group(std::uint32_t first) {
    unsigned pending = kernels_.near_seeds(surface_.tree().places(first).data(), frame_, envelope_.reach, group_);
    if (pending == 0) return;
    if (end_ == edges) {
        const auto k = static_cast<unsigned>(hint_ == none ? std::countr_zero(pending) : hint_ % group);
        pending &= ~(1U << k);
        begin(k, first + k);
    }
    const Site end = end_;
    for (;;) {
        const std::size_t k = kernels_.next_cutting(group_, pending, envelope_, marks_.data(), is_sure_);
        if (k == group) break;
        is_sure_ = is_sure_ && end_ < functions_.size();
        if (!is_sure_) {
            envelope_.reach = -1;
            return;
        }
        add(k, first + static_cast<std::uint32_t>(k));
    }
    if (end_ != end) find_reach();
}

// The cell of one seed is all of the triangle.
void TriangleCells::begin(std::size_t k, std::uint32_t number) {
    const Function own{group_.f[k], group_.du[k], group_.dv[k], group_.error[k], 1, number};
    functions_[end_++] = own;
    Envelope& e = envelope_;
    e.max_value_error = own.error;
    e.max_change = group_.change[k];
    e.max_error = 0;
    clear_corners(3, e.count);
    e.count = 3;
    for (std::uint32_t i = 0; i < 3; ++i) {
        corners_[i] = {{edges, (i + 2) % 3, i}, {4 * outside, 4 * ((i + 1) % 3) + 2, 4 * ((i + 2) % 3) + 1}};
        const Vector3 x = minus(vertex_[i], frame_.center);
        e.u[i] = i == 1 ? 1 : 0;
        e.v[i] = i == 2 ? 1 : 0;
        e.error[i] = 0;
        e.value[i] = own.f + (i == 1 ? own.du : i == 2 ? own.dv : 0);
        e.square[i] = e.value[i] + dot(x, x);
    }
    find_reach();
}

// Makes corners ones that no function changes.
void TriangleCells::clear_corners(std::size_t from, std::size_t end) {
    for (std::size_t c = from; c < end; ++c) {
        envelope_.u[c] = envelope_.v[c] = envelope_.square[c] = 0;
        envelope_.value[c] = -infinity;
    }
}

void TriangleCells::add(std::size_t k, std::uint32_t number) {
    removed_count_ = 0;
    for (std::uint32_t first = 0; first < envelope_.count; first += group)
        for (unsigned marks = marks_[first / group]; marks != 0; marks &= marks - 1)
            removed_[removed_count_++] = first + static_cast<std::uint32_t>(std::countr_zero(marks));
    Function& own = functions_[end_];
    own = {group_.f[k], group_.du[k], group_.dv[k], group_.error[k], 1, number};
    envelope_.max_value_error = std::max(envelope_.max_value_error, own.error);
    envelope_.max_change = std::max(envelope_.max_change, group_.change[k]);
    join(own, end_++);
}

// Returns a side of a removed corner that leads to one that is not.
std::uint32_t TriangleCells::find_border() const {
    for (std::size_t i = 0;; ++i)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (!is_removed(corners_[removed_[i]].twin[k] >> 2)) return 4 * removed_[i] + k;
}

// Fills the hole that removed corners leave with those of a new site.
void TriangleCells::join(const Function& own, Site site) {
    std::size_t count = 0;
    const std::uint32_t border = find_border();
    std::uint32_t side = border;
    do {  // along the border
        const Corner& of = corners_[side >> 2];
        const std::uint32_t twin = of.twin[side & 3], next = turn(side);
        const bool crosses = is_removed(twin >> 2);
        ring_sites_[count] = of.site[next & 3];
        beyond_[count] = twin;
        count += crosses ? 0 : 1;
        side = crosses ? turn(twin) : next;
    } while (side != border);
    for (std::size_t i = 0; i < count; ++i) set_row(i, own, functions_[ring_sites_[i]]);
    set_row(count, own, functions_[ring_sites_[0]]);
    ring_sites_[count] = ring_sites_[0];
    Envelope& e = envelope_;
    for (std::size_t i = 0; i < count; ++i)
        made_[i] = i < removed_count_ ? removed_[i] : static_cast<std::uint32_t>(e.count++);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t c = made_[i], next = made_[i + 1 == count ? 0 : i + 1],
                            previous = made_[i == 0 ? count - 1 : i - 1];
        corners_[c] = {{site, ring_sites_[i], ring_sites_[i + 1]}, {beyond_[i], 4 * next + 2, 4 * previous + 1}};
        corners_[beyond_[i] >> 2].twin[beyond_[i] & 3] = 4 * c;
    }
    ring_.count = count;
    kernels_.place_corners(ring_, frame_, own.f, own.du, own.dv);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t c = made_[i];
        e.u[c] = ring_.u[i], e.v[c] = ring_.v[i];
        e.value[c] = ring_.value[i], e.square[c] = ring_.square[i], e.error[c] = ring_.corner_error[i];
        e.max_error = std::max(e.max_error, e.error[c]);
    }
    if (count < removed_count_) remove_rest(count);
}

// The function that is 0 along the side between a new cell and another site.
void TriangleCells::set_row(std::size_t i, const Function& own, const Function& other) {
    const double g = other.seed * own.f - other.f, gu = other.seed * own.du - other.du,
                 gv = other.seed * own.dv - other.dv;
    ring_.g[i] = g, ring_.gu[i] = gu, ring_.gv[i] = gv;
    ring_.error[i] = 1.25 * (other.seed * own.error + other.error);
    ring_.size[i] = std::max(std::abs(g), std::max(std::abs(gu), std::abs(gv)));
}

// Moves the last corners to places of removed ones, which are ascending.
void TriangleCells::remove_rest(std::size_t used) {
    Envelope& e = envelope_;
    const std::size_t end = e.count;
    for (std::size_t i = removed_count_; i-- > used;) {
        const std::uint32_t to = removed_[i];
        const auto from = static_cast<std::uint32_t>(--e.count);
        if (to == from) continue;
        for (double* const of : {e.u, e.v, e.value, e.square, e.error}) of[to] = of[from];
        corners_[to] = corners_[from];
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t twin = corners_[to].twin[k];
            corners_[twin >> 2].twin[twin & 3] = 4 * to + k;
        }
    }
    clear_corners(e.count, end);
}

// Finds how far seeds may be that cut.
void TriangleCells::find_reach() {
    const Envelope& e = envelope_;
    const double radius =
        std::sqrt(kernels_.largest_square(e) + 2 * Envelope::value_errors * e.max_value_error) * (1 + 0x1p-40) +
        4 * e.max_error * frame_.length;
    envelope_.reach = radius * radius * (1 + 0x1p-40);
}

// Returns whether no seed in a box cuts, if the box is small beside the distance of corners: none of the balls around
// them through their seeds meets it. For larger boxes that is rare.
bool TriangleCells::is_beyond_balls(const Box& box) const {
    const Envelope& e = envelope_;
    const Vector3 size = minus(box.upper, box.lower);
    if (end_ == edges || 16 * dot(size, size) > e.reach) return false;
    const Box relative{minus(box.lower, frame_.center), minus(box.upper, frame_.center)};
    for (std::size_t c = 0; c < e.count; ++c) {
        Vector3 x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = frame_.first[k] + (e.u[c] * frame_.way[0][k] + e.v[c] * frame_.way[1][k]);
        // (a + b)^2 is at most a^2 (1 + d) + b^2 (1 + 1 / d).
        const double error = 4 * (e.error[c] + 4 * solid::unit) * frame_.length;
        const double square =
            (e.square[c] + 2 * Envelope::value_errors * e.max_value_error) * (1 + 0x1p-40) + 0x1p41 * error * error;
        if (distance_squared(x, relative) <= square) return false;
    }
    return true;
}

void TriangleCells::settle(std::int32_t triangle, ClippedTriangle& exact) {
    Envelope& e = envelope_;
    if (ClippedTriangle::is_accurate(e.max_error, frame_.length, 0)) return;
    bool is_set = false;
    for (std::uint32_t c = 0; c < e.count; ++c) {
        if (ClippedTriangle::is_accurate(e.error[c], frame_.length, std::sqrt(std::max(e.square[c], 0.0)))) continue;
        const auto& site = corners_[c].site;
        const std::size_t k = site[0] >= edges ? 0 : site[1] >= edges ? 1 : 2;
        const auto side = [&](Site of) {
            return of < edges ? -1 - static_cast<Side>(of) : static_cast<Side>(functions_[of].number);
        };
        if (!is_set) exact.set_triangle(triangle);
        is_set = true;
        const auto w = exact.corner(functions_[site[k]].number, side(site[(k + 1) % 3]), side(site[(k + 2) % 3]));
        e.u[c] = w[0], e.v[c] = w[1];
    }
}

double TriangleCells::area(std::size_t part, double of_triangle) const {
    const Envelope& e = envelope_;
    const std::uint32_t first = parts_[part].second, origin = first >> 2;
    std::uint32_t side = follow(first);
    double area = 0, s = e.u[side >> 2] - e.u[origin], t = e.v[side >> 2] - e.v[origin];
    for (side = follow(side); side != first; side = follow(side)) {
        const double next_s = e.u[side >> 2] - e.u[origin], next_t = e.v[side >> 2] - e.v[origin];
        area += of_triangle * (s * next_t - t * next_s);
        s = next_s, t = next_t;
    }
    return std::max(area, 0.0);  // may be rounded to less
}

void TriangleCells::select(std::size_t part) {
    const auto [site, first] = parts_[part];
    number_ = functions_[site].number;
    size_ = 0;
    for (std::uint32_t side = first;;) {
        const std::uint32_t c = side >> 2;
        const Site beyond = corners_[c].site[turn(side) & 3];
        sides_[size_] =
            beyond < edges ? -1 - static_cast<Side>(beyond) : surface_.tree().seed(functions_[beyond].number);
        weights_[size_++] = {envelope_.u[c], envelope_.v[c]};
        side = follow(side);
        if (side == first) break;
    }
    for (std::size_t i = 0; i < 3; ++i) relative_[i] = minus(vertex_[i], surface_.tree().place(number_));
}

Vector3 TriangleCells::place(std::size_t i) const {
    const auto& [u, v] = weights_[i];
    const double w = 1 - u - v;
    Vector3 x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = w * relative_[0][k] + u * relative_[1][k] + v * relative_[2][k];
    return x;
}

}  // namespace votess::surface
