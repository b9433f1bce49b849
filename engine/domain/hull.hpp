// The convex hull of points, exact. Points on an edge or in a facet are not its vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "exact/predicate.hpp"

namespace votess {

// Quickhull (Barber, Dobkin, Huhdanpaa, ACM TOMS 22(4), 1996) with exact signs. A point counts as outside only if it is
// strictly beyond a triangle. So a new triangle is never flat, and coplanar ones are merged at the end. Each choice
// depends on coordinates alone, so the triangles do not depend on the order of the points.
class Hull {
public:
    // Counterclockwise from outside. neighbor: across the edge opposite to that vertex.
    struct Triangle {
        std::array<std::int32_t, 3> vertex, neighbor;
        std::int32_t first = none;  // of the points outside, a list in next_
        bool visible = false;       // by a later vertex: not in the hull
    };
    static constexpr std::int32_t none = -1;

    // The points must outlive this. Their coordinates are below 2^90.
    explicit Hull(std::span<const exact::Point> points);

    // No triangles: all points lie in one plane.
    [[nodiscard]] bool is_flat() const { return triangles_.empty(); }
    // Returns one triangle of each facet.
    [[nodiscard]] std::vector<Triangle> facets() const;
    // Returns the points at which three facets or more meet, ascending.
    [[nodiscard]] std::vector<std::int32_t> corners() const;

private:
    [[nodiscard]] std::vector<std::int32_t> facet_numbers() const;
    template <class Score>
    [[nodiscard]] std::int32_t highest(Score score) const;
    [[nodiscard]] bool begin();
    [[nodiscard]] bool sees(std::int32_t point, const Triangle& triangle);
    void assign(std::int32_t point, std::size_t first_triangle);
    [[nodiscard]] std::int32_t take_farthest(Triangle& triangle);
    void add_vertex(std::int32_t triangle);

    std::span<const exact::Point> points_;
    std::vector<Triangle> triangles_;
    std::vector<std::int32_t> next_;         // of each point, in the list of a triangle
    std::vector<std::int32_t> starting_at_;  // of each vertex of a horizon, the new triangle whose edge begins there
    std::size_t tests_ = 0;
};

}  // namespace votess
