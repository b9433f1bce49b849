#include "surface/triangle_cells.hpp"

#include <algorithm>
#include <cmath>

#include "core/arithmetic.hpp"

namespace votess::surface {
namespace {

using solid::tiny;
using solid::unit;

// Errors of values at a corner, by those of the functions there: weights add up to less than 5, and sums are rounded.
constexpr double value_errors = 10;
// Bounds on the errors of a value in units of its terms, rounded up.
constexpr double function_rounding = 8 * unit;

}  // namespace

TriangleCells::TriangleCells(const Surface& surface) : surface_(surface) {
    seeds_.reserve(max_seeds);
    removed_.reserve(max_corners);
    border_.reserve(max_corners);
}

bool TriangleCells::make(std::int32_t triangle, ClippedTriangle& exact) {
    if (surface_.has_weights()) return false;
    const Surface::Triangle& of = surface_.triangles()[at(triangle)];
    for (std::size_t i = 0; i < 3; ++i) vertex_[i] = surface_.vertex(of.vertex[i]);
    for (std::size_t k = 0; k < 3; ++k) {
        const double a = vertex_[0][k], b = vertex_[1][k], c = vertex_[2][k];
        lower_[k] = std::min(std::min(a, b), c);
        upper_[k] = std::max(std::max(a, b), c);
        center_[k] = (a + b + c) / 3;
        first_[k] = a - center_[k];
        way_[0][k] = b - a;
        way_[1][k] = c - a;
    }
    length_ = std::sqrt(std::max(dot(first_, first_), std::max(dot(way_[0], way_[0]), dot(way_[1], way_[1])))) *
              (1 + 0x1p-40);
    seeds_.clear();
    is_sure_ = true;
    reach_ = infinity;
    const std::uint32_t first = hint_;
    if (first != none) begin(first);
    const auto skip = [&](const SeedTree::Node& node) { return is_beyond_balls(node); };
    surface_.tree().visit_around(lower_, upper_, center_, reach_, skip, [&](std::uint32_t number) {
        if (seeds_.empty())
            begin(number);
        else if (number != first)
            add(number);
    });
    if (!is_sure_) return false;
    settle(triangle, exact);
    std::fill_n(corner_of_site_.begin(), edges + seeds_.size(), none);
    for (std::uint32_t c = 0; c < count_; ++c)
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

// The cell of one seed is all of the triangle.
void TriangleCells::begin(std::uint32_t number) {
    seeds_.push_back(function_of(number));
    max_value_error_ = seeds_[0].error;
    max_change_ = seeds_[0].change;
    max_error_ = 0;
    count_ = 3;
    for (std::uint32_t i = 0; i < 3; ++i) {
        links_[i] = {{edges, (i + 2) % 3, i}, {none, (i + 1) % 3, (i + 2) % 3}};
        set_corner(i, edges, (i + 2) % 3, i);
    }
    find_reach();
}

TriangleCells::Seed TriangleCells::function_of(std::uint32_t number) const {
    const Vector3 s = minus(surface_.tree().place(number), center_);
    const double square = dot(s, s);
    Seed seed{square - 2 * dot(s, first_), {-2 * dot(s, way_[0]), -2 * dot(s, way_[1])}, 0, 0, number};
    seed.error = function_rounding * (square + 2 * std::sqrt(square) * length_) + tiny;
    seed.change = std::abs(seed.d[0]) + std::abs(seed.d[1]);
    return seed;
}

void TriangleCells::add(std::uint32_t number) {
    const Seed seed = function_of(number);
    removed_.clear();
    is_sure_ = find_removed(seed) && (removed_.empty() || seeds_.size() < max_seeds);
    if (!is_sure_) {
        for (const std::uint32_t c : removed_) is_removed_[c] = 0;
        reach_ = -1;
    } else if (!removed_.empty()) {
        seeds_.push_back(seed);
        max_value_error_ = std::max(max_value_error_, seed.error);
        max_change_ = std::max(max_change_, seed.change);
        join(static_cast<Site>(edges + seeds_.size() - 1));
        find_reach();
    }
}

// Lists the corners that are nearer to a seed. Returns whether all signs were sure.
bool TriangleCells::find_removed(const Seed& seed) {
    const double f = seed.f, du = seed.d[0], dv = seed.d[1];
    std::array<double, lanes> least;
    least.fill(infinity);
    const std::size_t end = padded();
    for (std::size_t c = 0; c < end; c += lanes) {
        std::array<double, lanes> difference;
        for (std::size_t j = 0; j < lanes; ++j) difference[j] = (f + (u_[c + j] * du + v_[c + j] * dv)) - value_[c + j];
        for (std::size_t j = 0; j < lanes; ++j) least[j] = difference[j] < least[j] ? difference[j] : least[j];
        for (std::size_t j = 0; j < lanes; ++j) difference_[c + j] = difference[j];
    }
    const double slack = value_errors * (seed.error + max_value_error_), change = 1.01 * (seed.change + max_change_);
    const double bound = slack + max_error_ * change;
    if (std::min(std::min(least[0], least[1]), std::min(least[2], least[3])) > bound) return true;
    for (std::uint32_t c = 0; c < count_; ++c) {
        if (difference_[c] > bound) continue;
        if (!(std::abs(difference_[c]) > slack + error_[c] * change)) return false;
        if (difference_[c] > 0) continue;
        removed_.push_back(c);
        is_removed_[c] = 1;
    }
    return true;
}

// Fills the hole that removed corners leave with those of a new site.
void TriangleCells::join(Site site) {
    border_.clear();
    for (const std::uint32_t c : removed_) {
        const Links& of = links_[c];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t next = of.next[k];
            if (next != none && is_removed_[next] != 0) continue;
            std::size_t back = 0;
            if (next != none) back = links_[next].next[0] == c ? 0 : links_[next].next[1] == c ? 1 : 2;
            border_.push_back({of.site[k == 2 ? 0 : k + 1], of.site[k == 0 ? 2 : k - 1], next, back});
        }
    }
    std::size_t used = 0;
    for (const Change& change : border_) {
        const auto c = used < removed_.size() ? removed_[used] : static_cast<std::uint32_t>(count_++);
        ++used;
        is_removed_[c] = 0;
        links_[c] = {{site, change.from, change.to}, {change.corner, 0, 0}};
        if (change.corner != none) links_[change.corner].next[change.back] = c;
        leading_[change.from] = c;
        following_[change.to] = c;
        set_corner(c, site, change.from, change.to);
    }
    for (const Change& change : border_) {
        Links& made = links_[leading_[change.from]];
        made.next[1] = leading_[change.to];
        made.next[2] = following_[change.from];
    }
    if (used < removed_.size()) remove_rest(used);
}

// Moves the last corners to places of removed ones, which are ascending.
void TriangleCells::remove_rest(std::size_t used) {
    for (std::size_t i = removed_.size(); i-- > used;) {
        const std::uint32_t to = removed_[i];
        const auto from = static_cast<std::uint32_t>(--count_);
        is_removed_[to] = 0;
        if (to == from) continue;
        u_[to] = u_[from], v_[to] = v_[from], value_[to] = value_[from];
        square_[to] = square_[from], error_[to] = error_[from];
        links_[to] = links_[from];
        for (const std::uint32_t next : links_[to].next)
            if (next != none) std::ranges::replace(links_[next].next, from, to);
    }
}

// Finds the largest distance of a corner.
void TriangleCells::find_reach() {
    const std::size_t end = padded();
    for (std::size_t c = count_; c < end; ++c) {
        u_[c] = v_[c] = square_[c] = 0;
        value_[c] = -infinity;
    }
    std::array<double, lanes> square{};
    for (std::size_t c = 0; c < end; c += lanes)
        for (std::size_t j = 0; j < lanes; ++j) square[j] = square_[c + j] > square[j] ? square_[c + j] : square[j];
    const double largest = std::max(std::max(square[0], square[1]), std::max(square[2], square[3]));
    const double radius =
        std::sqrt(largest + 2 * value_errors * max_value_error_) * (1 + 0x1p-40) + 4 * max_error_ * length_;
    reach_ = radius * radius * (1 + 0x1p-40);
}

// Returns whether no seed in a box cuts, if the box is small beside the distance of corners: none of the balls around
// them through their seeds meets it. For larger boxes that is rare.
bool TriangleCells::is_beyond_balls(const SeedTree::Node& node) const {
    const Vector3 size = minus(node.upper, node.lower);
    if (seeds_.empty() || 16 * dot(size, size) > reach_) return false;
    const Vector3 lower = minus(node.lower, center_), upper = minus(node.upper, center_);
    for (std::size_t c = 0; c < count_; ++c) {
        Vector3 x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = first_[k] + (u_[c] * way_[0][k] + v_[c] * way_[1][k]);
        // (a + b)^2 is at most a^2 (1 + d) + b^2 (1 + 1 / d).
        const double error = 4 * (error_[c] + 4 * unit) * length_;
        const double square =
            (square_[c] + 2 * value_errors * max_value_error_) * (1 + 0x1p-40) + 0x1p41 * error * error;
        if (SeedTree::square_between(lower, upper, x, x) <= square) return false;
    }
    return true;
}

// Places a corner of the cell of a site, which the others follow as the triangle turns.
void TriangleCells::set_corner(std::uint32_t corner, Site site, Site from, Site to) {
    const Seed& own = of(site);
    if (from < edges && to < edges) {  // a corner of the triangle
        set_weights(corner, to == 1 ? 1 : 0, to == 2 ? 1 : 0, 0);
    } else if (from < edges || to < edges) {
        const Site edge = std::min(from, to);
        const Seed& other = of(std::max(from, to));
        const double f = own.f - other.f, a = own.d[0] - other.d[0], b = own.d[1] - other.d[1];
        const double at_first = edge == 0 ? f : f + (edge == 1 ? a : b);
        const double at_second = edge == 2 ? f : f + (edge == 0 ? a : b);
        const double across = at_first - at_second, share = at_first / across;
        const double error = 6 * (own.error + other.error), sure = std::abs(across) - error;
        const double bound = sure > 0 ? 2 * error / sure + 4 * unit : infinity;
        set_weights(corner,
                    edge == 0   ? share
                    : edge == 1 ? 1 - share
                                : 0,
                    edge == 1   ? share
                    : edge == 2 ? 1 - share
                                : 0,
                    bound);
    } else {
        const Seed &p = of(from), &q = of(to);
        const double g = own.f - p.f, gu = own.d[0] - p.d[0], gv = own.d[1] - p.d[1];
        const double h = own.f - q.f, hu = own.d[0] - q.d[0], hv = own.d[1] - q.d[1];
        const double g_size = std::max(std::abs(g), std::max(std::abs(gu), std::abs(gv)));
        const double h_size = std::max(std::abs(h), std::max(std::abs(hu), std::abs(hv)));
        const double g_error = 1.25 * (own.error + p.error), h_error = 1.25 * (own.error + q.error);
        const double error = 2 * (g_size * h_error + h_size * g_error + g_error * h_error) + 4 * unit * g_size * h_size;
        const double across = gu * hv - gv * hu, inverse = 1 / across, sure = std::abs(across) - error;
        set_weights(corner, (gv * h - g * hv) * inverse, (g * hu - gu * h) * inverse,
                    sure > 0 ? 2.1 * error / sure + 8 * unit : infinity);
    }
    const double u = u_[corner], v = v_[corner];
    const double x = first_[0] + (u * way_[0][0] + v * way_[1][0]), y = first_[1] + (u * way_[0][1] + v * way_[1][1]),
                 z = first_[2] + (u * way_[0][2] + v * way_[1][2]);
    value_[corner] = own.f + (u * own.d[0] + v * own.d[1]);
    square_[corner] = value_[corner] + (x * x + y * y + z * z);
}

void TriangleCells::set_weights(std::uint32_t corner, double u, double v, double error) {
    if (!(error < 1)) u = v = 1.0 / 3, error = 1;  // somewhere in the triangle
    u_[corner] = u, v_[corner] = v, error_[corner] = error;
    max_error_ = std::max(max_error_, error);
}

void TriangleCells::settle(std::int32_t triangle, ClippedTriangle& exact) {
    bool is_set = false;
    for (std::uint32_t c = 0; c < count_; ++c) {
        if (ClippedTriangle::is_accurate(error_[c], length_, std::sqrt(std::max(square_[c], 0.0)))) continue;
        const auto& site = links_[c].site;
        const std::size_t k = site[0] >= edges ? 0 : site[1] >= edges ? 1 : 2;
        const auto side = [&](Site of) {
            return of < edges ? -1 - static_cast<Side>(of) : static_cast<Side>(this->of(of).number);
        };
        if (!is_set) exact.set_triangle(triangle);
        is_set = true;
        const auto w = exact.corner(of(site[k]).number, side(site[(k + 1) % 3]), side(site[(k + 2) % 3]));
        u_[c] = w[0], v_[c] = w[1];
    }
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
        weights_[size_++] = {u_[c], v_[c]};
        c = links.next[k == 2 ? 0 : k + 1];
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
