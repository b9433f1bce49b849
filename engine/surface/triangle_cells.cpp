#include "surface/triangle_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/arithmetic.hpp"

namespace votess::surface {
TriangleCells::TriangleCells(const Surface& surface) : surface_(surface), kernels_(surface_kernels()) {
    seeds_.reserve(max_seeds);
    removed_.reserve(max_corners);
    border_.reserve(max_corners);
    made_.reserve(max_corners);
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
    seeds_.clear();
    is_sure_ = true;
    envelope_.reach = std::numeric_limits<double>::max();
    const std::uint32_t near = hint_ == none ? none : hint_ - hint_ % group;
    if (near != none) add_group(near);
    const auto skip = [&](const SeedTree::Node& node) { return is_beyond_balls(surface_.tree().box(node)); };
    surface_.tree().visit(frame_.box, envelope_.reach, skip, [&](std::uint32_t begin, std::uint32_t) {
        if (begin != near) add_group(begin);
    });
    if (!is_sure_) return false;
    settle(triangle, exact);
    std::fill_n(corner_of_site_.begin(), edges + seeds_.size(), none);
    for (std::uint32_t c = 0; c < envelope_.count; ++c)
        for (const Site site : links_[c].site) corner_of_site_[site] = c;
    parts_.clear();
    sites_.clear();
    for (Site site = edges; site < edges + seeds_.size(); ++site) {
        if (corner_of_site_[site] == none) continue;
        parts_.push_back(corner_of_site_[site]);
        sites_.push_back(site);
    }
    hint_ = seeds_[sites_[0] - edges].number;
    return true;
}

void TriangleCells::add_group(std::uint32_t first) {
    unsigned pending = kernels_.near_seeds(surface_.tree().places(first).data(), frame_, envelope_.reach, functions_);
    if (pending == 0) return;
    if (seeds_.empty()) {
        const auto k = static_cast<unsigned>(hint_ == none ? std::countr_zero(pending) : hint_ % group);
        pending &= ~(1U << k);
        begin(k, first + k);
    }
    while (is_sure_) {
        const std::size_t k = kernels_.next_cutting(functions_, pending, envelope_, marks_.data());
        if (k == group) return;
        add(k, first + static_cast<std::uint32_t>(k));
    }
    envelope_.reach = -1;
}

// The cell of one seed is all of the triangle.
void TriangleCells::begin(std::size_t k, std::uint32_t number) {
    const Seed own{functions_.f[k], functions_.du[k], functions_.dv[k], functions_.error[k], number};
    seeds_.push_back(own);
    Envelope& e = envelope_;
    e.max_value_error = own.error;
    e.max_change = functions_.change[k];
    e.max_error = 0;
    clear_corners(3, e.count);
    e.count = 3;
    for (std::uint32_t i = 0; i < 3; ++i) {
        links_[i] = {{edges, (i + 2) % 3, i}, {none, (i + 1) % 3, (i + 2) % 3}};
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
    removed_.clear();
    is_sure_ = find_removed(k) && (removed_.empty() || seeds_.size() < max_seeds);
    if (!is_sure_) {
        for (const std::uint32_t c : removed_) is_removed_[c] = 0;
    } else if (!removed_.empty()) {
        const Seed own{functions_.f[k], functions_.du[k], functions_.dv[k], functions_.error[k], number};
        seeds_.push_back(own);
        envelope_.max_value_error = std::max(envelope_.max_value_error, own.error);
        envelope_.max_change = std::max(envelope_.max_change, functions_.change[k]);
        join(own, static_cast<Site>(edges + seeds_.size() - 1));
        find_reach();
    }
}

// Lists the marked corners that are nearer to a seed. Returns whether all signs were sure.
bool TriangleCells::find_removed(std::size_t k) {
    const Envelope& e = envelope_;
    const double slack = e.slack(functions_.error[k]), change = e.change(functions_.change[k]);
    for (std::size_t first = 0; first < e.count; first += group)
        for (unsigned marks = marks_[first / group]; marks != 0; marks &= marks - 1) {
            const std::size_t c = first + static_cast<std::size_t>(std::countr_zero(marks));
            const double difference =
                (functions_.f[k] + (e.u[c] * functions_.du[k] + e.v[c] * functions_.dv[k])) - e.value[c];
            if (!(std::abs(difference) > slack + e.error[c] * change)) return false;
            if (difference > 0) continue;
            removed_.push_back(static_cast<std::uint32_t>(c));
            is_removed_[c] = 1;
        }
    return true;
}

// Fills the hole that removed corners leave with those of a new site.
void TriangleCells::join(const Seed& own, Site site) {
    border_.clear();
    for (const std::uint32_t c : removed_) {
        const Links& of = links_[c];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t next = of.next[k];
            if (next != none && is_removed_[next] != 0) continue;
            std::size_t back = 0;
            if (next != none) back = links_[next].next[0] == c ? 0 : links_[next].next[1] == c ? 1 : 2;
            const Site from = of.site[k == 2 ? 0 : k + 1];
            change_from_[from] = static_cast<std::uint32_t>(border_.size());
            border_.push_back({from, of.site[k == 0 ? 2 : k - 1], next, back});
        }
    }
    for (const std::uint32_t c : removed_) is_removed_[c] = 0;
    made_.clear();
    std::size_t i = 0;
    do {
        const Change& change = border_[i];
        set_row(made_.size(), own, change.from);
        made_.push_back(made_.size() < removed_.size() ? removed_[made_.size()]
                                                       : static_cast<std::uint32_t>(envelope_.count++));
        const std::uint32_t c = made_.back();
        links_[c].site = {site, change.from, change.to};
        links_[c].next[0] = change.corner;
        if (change.corner != none) links_[change.corner].next[change.back] = c;
        i = change_from_[change.to];
    } while (i != 0 && made_.size() < border_.size());
    const std::size_t count = made_.size();
    is_sure_ = i == 0 && count == border_.size();
    if (!is_sure_) return;
    set_row(count, own, border_[0].from);
    ring_.count = count;
    kernels_.place_corners(ring_, frame_, own.f, own.du, own.dv);
    Envelope& e = envelope_;
    for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t c = made_[k];
        links_[c].next[1] = made_[k + 1 == count ? 0 : k + 1];
        links_[c].next[2] = made_[k == 0 ? count - 1 : k - 1];
        e.u[c] = ring_.u[k], e.v[c] = ring_.v[k];
        e.value[c] = ring_.value[k], e.square[c] = ring_.square[k], e.error[c] = ring_.corner_error[k];
        e.max_error = std::max(e.max_error, e.error[c]);
    }
    if (count < removed_.size()) remove_rest(count);
}

// The function that is 0 along the side between a new cell and a site.
void TriangleCells::set_row(std::size_t i, const Seed& own, Site site) {
    double g, gu, gv, error, size;
    if (site < edges) {
        g = site == 1 ? -1 : 0;
        gu = site == 0 ? 0 : 1;
        gv = site == 2 ? 0 : 1;
        error = 0;
        size = 1;
    } else {
        const Seed& p = of(site);
        g = own.f - p.f, gu = own.du - p.du, gv = own.dv - p.dv;
        error = 1.25 * (own.error + p.error);
        size = std::max(std::abs(g), std::max(std::abs(gu), std::abs(gv)));
    }
    ring_.g[i] = g, ring_.gu[i] = gu, ring_.gv[i] = gv;
    ring_.error[i] = error, ring_.size[i] = size;
}

// Moves the last corners to places of removed ones, which are ascending.
void TriangleCells::remove_rest(std::size_t used) {
    Envelope& e = envelope_;
    const std::size_t end = e.count;
    for (std::size_t i = removed_.size(); i-- > used;) {
        const std::uint32_t to = removed_[i];
        const auto from = static_cast<std::uint32_t>(--e.count);
        if (to == from) continue;
        for (double* const of : {e.u, e.v, e.value, e.square, e.error}) of[to] = of[from];
        links_[to] = links_[from];
        for (const std::uint32_t next : links_[to].next)
            if (next != none) std::ranges::replace(links_[next].next, from, to);
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
    if (seeds_.empty() || 16 * dot(size, size) > e.reach) return false;
    const Box relative{minus(box.lower, frame_.center), minus(box.upper, frame_.center)};
    for (std::size_t c = 0; c < e.count; ++c) {
        Vector3 x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = frame_.first[k] + (e.u[c] * frame_.way[0][k] + e.v[c] * frame_.way[1][k]);
        // (a + b)^2 is at most a^2 (1 + d) + b^2 (1 + 1 / d).
        const double error = 4 * (e.error[c] + 4 * solid::unit) * frame_.length;
        const double square = (e.square[c] + 2 * Envelope::value_errors * e.max_value_error) * (1 + 0x1p-40) +
                              0x1p41 * error * error;
        if (SeedTree::square_distance(relative, x) <= square) return false;
    }
    return true;
}

void TriangleCells::settle(std::int32_t triangle, ClippedTriangle& exact) {
    Envelope& e = envelope_;
    if (ClippedTriangle::is_accurate(e.max_error, frame_.length, 0)) return;
    bool is_set = false;
    for (std::uint32_t c = 0; c < e.count; ++c) {
        if (ClippedTriangle::is_accurate(e.error[c], frame_.length, std::sqrt(std::max(e.square[c], 0.0)))) continue;
        const auto& site = links_[c].site;
        const std::size_t k = site[0] >= edges ? 0 : site[1] >= edges ? 1 : 2;
        const auto side = [&](Site of) {
            return of < edges ? -1 - static_cast<Side>(of) : static_cast<Side>(this->of(of).number);
        };
        if (!is_set) exact.set_triangle(triangle);
        is_set = true;
        const auto w = exact.corner(of(site[k]).number, side(site[(k + 1) % 3]), side(site[(k + 2) % 3]));
        e.u[c] = w[0], e.v[c] = w[1];
    }
}

double TriangleCells::area(std::size_t part, double of_triangle) const {
    const Envelope& e = envelope_;
    const Site site = sites_[part];
    const std::uint32_t first = parts_[part];
    std::uint32_t c = links_[first].after(site);
    double area = 0, s = e.u[c] - e.u[first], t = e.v[c] - e.v[first];
    for (c = links_[c].after(site); c != first; c = links_[c].after(site)) {
        const double next_s = e.u[c] - e.u[first], next_t = e.v[c] - e.v[first];
        area += of_triangle * (s * next_t - t * next_s);
        s = next_s, t = next_t;
    }
    return std::max(area, 0.0);  // may be rounded to less
}

void TriangleCells::select(std::size_t part) {
    const std::uint32_t first = parts_[part];
    const Site site = sites_[part];
    number_ = of(site).number;
    size_ = 0;
    for (std::uint32_t c = first;;) {
        const Links& links = links_[c];
        const std::size_t k = links.site[0] == site ? 0 : links.site[1] == site ? 1 : 2;
        const Site beyond = links.site[k == 0 ? 2 : k - 1];
        sides_[size_] = beyond < edges ? -1 - static_cast<Side>(beyond) : surface_.tree().seed(of(beyond).number);
        weights_[size_++] = {envelope_.u[c], envelope_.v[c]};
        c = links.after(site);
        if (c == first) break;
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
