#include "picture/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace votess::picture {

Vec3 crossing(const Vec3& a, const Vec3& b, const CutPlane& plane) {
    const double ha = plane.height(a), hb = plane.height(b);
    Vec3 p = a + (ha / (ha - hb)) * (b - a);
    p[static_cast<std::size_t>(plane.axis)] = plane.value;
    return p;
}

void clip(const Polygon& in, const CutPlane& plane, bool behind, bool line, Polygon& out) {
    out.clear();
    const std::size_t n = in.corners.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 &a = in.corners[i], &b = in.corners[(i + 1) % n];
        const bool a_in = (plane.height(a) > 0) != behind, b_in = (plane.height(b) > 0) != behind;
        if (a_in && b_in) {
            out.add(a, in.line[i]);
        } else if (a_in) {
            out.add(a, in.line[i]);
            out.add(crossing(a, b, plane), line);
        } else if (b_in) {
            out.add(crossing(a, b, plane), in.line[i]);
        }
    }
    if (out.corners.size() < 3) out.clear();
}

void section(const Mesh& mesh, std::size_t cell, const CutPlane& plane, Polygon& out) {
    out.clear();
    if (!mesh.corner_begin.empty()) {
        for (auto k = mesh.corner_begin[cell]; k < mesh.corner_begin[cell + 1]; ++k)
            out.add(mesh.vertex(mesh.corners[static_cast<std::size_t>(k)]), true);
        return;
    }
    // Each crossed edge once; both of its faces have it, unless one was dropped as too small.
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;
    std::vector<Vec3>& points = out.corners;
    for (std::size_t f = mesh.first_face(cell); f < mesh.end_face(cell); ++f) {
        const auto loop = mesh.polygon(f);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            // In one direction whatever the face and the cell, for the same rounding.
            const auto edge = std::minmax({loop[i], loop[i + 1 == loop.size() ? 0 : i + 1]});
            const Vec3 a = mesh.vertex(edge.first), b = mesh.vertex(edge.second);
            if ((plane.height(a) > 0) == (plane.height(b) > 0)) continue;
            if (std::find(edges.begin(), edges.end(), std::pair(edge)) != edges.end()) continue;
            edges.emplace_back(edge);
            points.push_back(crossing(a, b, plane));
        }
    }
    if (points.size() < 3) return out.clear();

    // Convex, so the order around the middle is the order along the boundary.
    Vec3 middle{};
    for (const Vec3& p : points) middle = middle + p;
    middle = (1.0 / static_cast<double>(points.size())) * middle;
    const auto u = static_cast<std::size_t>((plane.axis + 1) % 3), v = static_cast<std::size_t>((plane.axis + 2) % 3);
    std::vector<std::pair<double, Vec3>> around;
    around.reserve(points.size());
    for (const Vec3& p : points) {
        around.emplace_back(plane.side * std::atan2(p[v] - middle[v], p[u] - middle[u]), p);
    }
    std::sort(around.begin(), around.end());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = around[i].second;
    out.line.assign(points.size(), 1);
}

}  // namespace votess::picture
