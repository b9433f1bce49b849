#include "domain/hull.hpp"

#include <algorithm>
#include <cmath>

#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "exact/insphere.hpp"

namespace votess {
namespace {

using exact::Point;

double squared(const Vector3& x) {
    return dot(x, x);
}

// Orders places by their score, then by their coordinates.
struct Ranked {
    double score;
    Point place;
    friend auto operator<=>(const Ranked&, const Ranked&) = default;
};

}  // namespace

Hull::Hull(std::span<const Point> points) : points_(points) {
    if (!begin()) return;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        while (!triangles_[t].visible && triangles_[t].first != none) add_vertex(static_cast<std::int32_t>(t));
    }
}

// Returns the point with the highest score, as determined by coordinates alone.
template <class Score>
std::int32_t Hull::highest(Score score) const {
    std::int32_t best = 0;
    Ranked top{-1, {}};
    in_pieces(points_.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double s = score(points_[i]);
            if (s < top.score) continue;
            const Ranked found{s, points_[i]};
            if (found > top) top = found, best = static_cast<std::int32_t>(i);
        }
    });
    return best;
}

// Makes a tetrahedron of points far apart. Returns false if all points lie in one plane.
bool Hull::begin() {
    if (points_.empty()) return false;
    const auto at = [this](std::int32_t i) -> const Point& { return points_[static_cast<std::size_t>(i)]; };
    const std::int32_t a = highest([](const Point&) { return 0.0; });
    const std::int32_t b = highest([&](const Point& x) { return squared(minus(x, at(a))); });
    const Vector3 edge = minus(at(b), at(a));
    const auto is_beside = [&](const Point& x) { return exact::triangle_normal(at(a), at(b), x).n != Point{}; };
    std::int32_t c = highest([&](const Point& x) { return squared(cross(edge, minus(x, at(a)))); });
    if (!is_beside(at(c))) c = highest([&](const Point& x) { return is_beside(x) ? 1.0 : 0.0; });
    const Vector3 normal = exact::triangle_normal(at(a), at(b), at(c)).n;
    const auto is_above = [&](const Point& x) { return exact::orient(at(a), at(b), at(c), x) != 0; };
    std::int32_t d = highest([&](const Point& x) { return std::abs(dot(normal, minus(x, at(a)))); });
    if (!is_above(at(d))) d = highest([&](const Point& x) { return is_above(x) ? 1.0 : 0.0; });
    const int side = exact::orient(at(a), at(b), at(c), at(d));
    if (side == 0) return false;

    const auto [u, v] = side > 0 ? std::array{b, c} : std::array{c, b};
    triangles_ = {{{a, u, v}, {3, 2, 1}}, {{a, d, u}, {3, 0, 2}}, {{a, v, d}, {3, 1, 0}}, {{u, d, v}, {2, 0, 1}}};
    next_.assign(points_.size(), none);
    starting_at_.assign(points_.size(), none);
    for (std::size_t i = 0; i < points_.size(); ++i) assign(static_cast<std::int32_t>(i), 0);
    return true;
}

// Returns whether a point is strictly beyond a triangle.
bool Hull::sees(std::int32_t point, const Triangle& triangle) {
    constexpr std::size_t tests_per_check = 4096;
    if (++tests_ % tests_per_check == 0) check_stop();
    const auto at = [this](std::int32_t i) -> const Point& { return points_[static_cast<std::size_t>(i)]; };
    const auto& [a, b, c] = triangle.vertex;
    return exact::orient(at(a), at(b), at(c), at(point)) < 0;
}

// Puts a point into the list of the first triangle that it sees.
void Hull::assign(std::int32_t point, std::size_t first_triangle) {
    for (std::size_t t = first_triangle; t < triangles_.size(); ++t) {
        Triangle& triangle = triangles_[t];
        if (!sees(point, triangle)) continue;
        next_[static_cast<std::size_t>(point)] = triangle.first;
        triangle.first = point;
        return;
    }
}

// Removes the point farthest outside from the list of a triangle.
std::int32_t Hull::take_farthest(Triangle& triangle) {
    const auto at = [this](std::int32_t i) -> const Point& { return points_[static_cast<std::size_t>(i)]; };
    const auto& [a, b, c] = triangle.vertex;
    const Vector3 normal = cross(minus(at(b), at(a)), minus(at(c), at(a)));
    std::int32_t* best = &triangle.first;
    Ranked top{-1, {}};
    for (std::int32_t* link = &triangle.first; *link != none; link = &next_[static_cast<std::size_t>(*link)]) {
        const Ranked found{std::abs(dot(normal, minus(at(*link), at(a)))), at(*link)};
        if (found > top) top = found, best = link;
    }
    const std::int32_t point = *best;
    *best = next_[static_cast<std::size_t>(point)];
    return point;
}

// Replaces the triangles that the farthest point outside of one of them sees by triangles with this point.
void Hull::add_vertex(std::int32_t triangle) {
    const auto at = [this](std::int32_t t) -> Triangle& { return triangles_[static_cast<std::size_t>(t)]; };
    const std::int32_t point = take_farthest(at(triangle));
    const std::size_t first_new = triangles_.size();
    std::vector<std::int32_t> seen{triangle};
    at(triangle).visible = true;
    for (std::size_t s = 0; s < seen.size(); ++s) {
        const Triangle old = at(seen[s]);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t beyond = old.neighbor[k];
            if (at(beyond).visible) continue;
            if (sees(point, at(beyond))) {
                at(beyond).visible = true;
                seen.push_back(beyond);
                continue;
            }
            const std::int32_t from = old.vertex[(k + 1) % 3], to = old.vertex[(k + 2) % 3];
            const auto made = static_cast<std::int32_t>(triangles_.size());
            *std::ranges::find(at(beyond).neighbor, seen[s]) = made;
            starting_at_[static_cast<std::size_t>(from)] = made;
            triangles_.push_back({{from, to, point}, {none, none, beyond}});
        }
    }
    for (std::size_t t = first_new; t < triangles_.size(); ++t) {
        const std::int32_t after = starting_at_[static_cast<std::size_t>(triangles_[t].vertex[1])];
        triangles_[t].neighbor[0] = after;
        at(after).neighbor[1] = static_cast<std::int32_t>(t);
    }
    for (const std::int32_t s : seen)
        for (std::int32_t next, p = at(s).first; p != none; p = next) {
            next = next_[static_cast<std::size_t>(p)];
            assign(p, first_new);
        }
}

// Returns the facet of each triangle, numbered from 0 in the order of their first triangles; none: not in the hull.
std::vector<std::int32_t> Hull::facet_numbers() const {
    std::vector<std::int32_t> facet(triangles_.size(), none);
    std::int32_t count = 0;
    std::vector<std::size_t> coplanar;
    const auto at = [this](std::int32_t i) -> const Point& { return points_[static_cast<std::size_t>(i)]; };
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        if (triangles_[t].visible || facet[t] != none) continue;
        const auto& [a, b, c] = triangles_[t].vertex;
        facet[t] = count;
        coplanar.assign(1, t);
        while (!coplanar.empty()) {
            const Triangle& member = triangles_[coplanar.back()];
            coplanar.pop_back();
            for (const std::int32_t n : member.neighbor) {
                const auto other = static_cast<std::size_t>(n);
                const auto in_plane = [&](std::int32_t v) { return exact::orient(at(a), at(b), at(c), at(v)) == 0; };
                if (facet[other] != none || !std::ranges::all_of(triangles_[other].vertex, in_plane)) continue;
                facet[other] = count;
                coplanar.push_back(other);
            }
        }
        ++count;
    }
    return facet;
}

std::vector<Hull::Triangle> Hull::facets() const {
    const std::vector<std::int32_t> facet = facet_numbers();
    std::vector<Triangle> facets;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        if (facet[t] == static_cast<std::int32_t>(facets.size())) facets.push_back(triangles_[t]);
    return facets;
}

std::vector<std::int32_t> Hull::corners() const {
    const std::vector<std::int32_t> facet = facet_numbers();
    std::vector<std::array<std::int32_t, 2>> meetings;  // of a point and a facet
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (const std::int32_t v : triangles_[t].vertex)
            if (facet[t] != none) meetings.push_back({v, facet[t]});
    std::ranges::sort(meetings);
    meetings.erase(std::ranges::unique(meetings).begin(), meetings.end());
    std::vector<std::int32_t> corners;
    for (std::size_t k = 2; k < meetings.size(); ++k)
        if (const std::int32_t v = meetings[k][0]; v == meetings[k - 2][0] && (corners.empty() || corners.back() != v))
            corners.push_back(v);
    return corners;
}

}  // namespace votess
