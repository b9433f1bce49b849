#include "plane/sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "input/default_box.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "result/drop_faces.hpp"

namespace votess {
namespace {

using detail::Result;

// Height over the mean distance of the points. Large ones slow dense clusters, small ones all cells: for 1e5 points
// uniform and in 50 clusters 2^-5 was best on the whole.
constexpr double relative_height = 0x1p-5;
// Height of the prism of a mesh over that of the sheet. Its caps then lie beyond most cells.
constexpr double relative_prism = 0x1p9;

// Returns the bounds of points of the plane, which may be any numbers.
Box bounds_of_plane(const Points& points) {
    Box bounds{{infinity, infinity, 0}, {-infinity, -infinity, 0}};
    for (std::size_t i = 0; i < points.coordinates() / 2; ++i)
        for (std::size_t k = 0; k < 2; ++k) {
            const double x = points[2 * i + k];
            if (!std::isfinite(x)) return {{0, 0, 0}, {1, 1, 0}};  // such points are refused later
            bounds.lower[k] = std::min(bounds.lower[k], x);
            bounds.upper[k] = std::max(bounds.upper[k], x);
        }
    return bounds;
}

// Widens bounds so that they hold the vertices of a mesh of the plane.
void include(const TriangleMesh& rings, Box& bounds) {
    for (std::size_t i = 0; i + 1 < rings.vertices.size(); i += 2)
        for (std::size_t k = 0; k < 2; ++k) {
            const double x = rings.vertices[i + k];
            if (!std::isfinite(x)) continue;  // Prism refuses it
            bounds.lower[k] = std::min(bounds.lower[k], x);
            bounds.upper[k] = std::max(bounds.upper[k], x);
        }
}

// Returns the box of `count` points of the plane.
Box box_of_plane(const Box& bounds, std::uint64_t count, const std::vector<Wall>& walls) {
    Box box = default_box(bounds, count, 2);
    if (!walls.empty()) check_box(box = bounds_of(walls, box));
    return box;
}

// Returns the two corners of the upper edge of a side of a prism, counterclockwise around the prism; -1 at infinity.
// polygon: the side, counterclockwise from outside, where that edge runs the other way. corner: -1 below.
std::array<std::int32_t, 2> upper_edge(std::span<const std::int32_t> polygon, std::span<const std::int32_t> corner) {
    if (polygon.empty()) return {-1, -1};  // infinity itself
    const auto is_above = [&](std::int32_t v) { return v < 0 || corner[at(v)] >= 0; };
    const auto name = [&](std::int32_t v) { return v < 0 ? -1 : corner[at(v)]; };
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const std::int32_t from = polygon[(k + 1) % polygon.size()], to = polygon[k];
        if (is_above(from) && is_above(to)) return {name(from), name(to)};
    }
    throw Error(ErrorCode::internal, "a side of a prism has no upper edge");
}

}  // namespace

// Corners come from the polygons above. Perimeters are sums of edges. The surface of the prism less the areas above and
// below would lose digits.
void add_sheet_wants(Want& want, bool& list_walls) {
    want.faces |= want.vertices;
    want.areas |= want.surfaces;
    list_walls |= want.surfaces;
}

Sheet::Sheet(Settled planar)
    : Sheet(bounds_of_plane(planar.points), planar.points.coordinates() / 2, std::move(planar)) {
    points_ = in_sheet(in_space_.points);
    in_space_.points = {points_, {}};
}

Sheet::Sheet(const Box& of_points, std::uint64_t count, Settled planar)
    : in_space_(std::move(planar)),
      wanted_(in_space_.want),
      list_walls_(in_space_.list_walls),
      min_face_(in_space_.min_face),
      min_area_(in_space_.min_area) {
    Region& region = in_space_.region;
    const bool endless = EndlessSides(region).any();
    Box bounds = of_points;
    if (region.mesh) include(*region.mesh, bounds), count = std::max<std::uint64_t>(count, 1);
    double width = 0, length = 0, height = 1;
    if (region.cell) {
        const auto &a = region.cell->a, &b = region.cell->b;
        width = std::hypot(a[0], a[1]);
        length = width == 0 ? 0 : std::abs(a[0] / width * b[1] - a[1] / width * b[0]);
    } else if (!region.box) {
        region.box = box_of_plane(bounds, count, region.walls);
        region.box->lower[2] = region.box->upper[2] = 0;
    }
    if (endless || !region.cell) {
        const Box box = endless ? box_of_plane(bounds, count, region.walls) : *region.box;
        width = box.upper[0] - box.lower[0];
        length = box.upper[1] - box.lower[1];
    }
    const double distance =
        std::sqrt(width) * std::sqrt(length) / std::sqrt(static_cast<double>(std::max<std::uint64_t>(count, 1)));
    if (distance > 0 && std::isfinite(distance)) height = std::ldexp(relative_height, std::ilogb(distance));
    region = in_sheet(std::move(region), height);
    if (region.mesh) region.mesh = prism_.emplace(*region.mesh, relative_prism * height).view();
    add_sheet_wants(in_space_.want, in_space_.list_walls);
    imply(in_space_);
    in_space_.min_face = in_space_.min_area = 0;  // surfaces have all edges
}

namespace {

// Drops the walls of the sheet, and all walls where the plane lists none. Keeps the corners above, which stand for
// those of the plane, and the upper edge of each side.
void flatten_rows(Result& r, const Want& wanted, bool list_walls) {
    std::vector<std::int32_t> corner(r.vertices.size() / 3, -1);
    std::int32_t corners = 0;
    for (std::size_t v = 0; v < corner.size(); ++v) {
        if (!(r.vertices[3 * v + 2] < 0)) corner[v] = corners++;
    }
    detail::keep_vertices(r, corner);
    const bool has_faces = !r.face_offsets.empty();
    std::vector<bool> stays(r.indices.size());
    std::vector<std::array<std::int32_t, 2>> edges;  // of the entries that stay
    std::int64_t polygons = 0;
    for (std::size_t i = 0; i + 1 < r.indptr.size(); ++i) {
        double perimeter = 0;
        for (std::size_t e = at(r.indptr[i]); e < at(r.indptr[i + 1]); ++e) {
            const std::int32_t id = r.indices[e];
            stays[e] = !Sheet::bounds(id) && (id >= 0 || list_walls);
            if (!Sheet::bounds(id) && !r.face_areas.empty()) perimeter += r.face_areas[e];
            if (!has_faces) continue;
            const auto polygon = std::span<const std::int32_t>(r.face_vertices)
                                     .subspan(at(r.face_offsets[e]), at(r.face_offsets[e + 1] - r.face_offsets[e]));
            if (id == Sheet::above)
                for (const std::int32_t v : polygon)
                    if (v >= 0) r.cell_vertex_indices[at(polygons++)] = corner[at(v)];
            if (stays[e]) edges.push_back(upper_edge(polygon, corner));
        }
        if (wanted.surfaces) r.surface_areas[i] = perimeter + (r.mesh_areas.empty() ? 0 : r.mesh_areas[i]);
        if (has_faces) r.cell_vertex_indptr[i + 1] = polygons;
    }
    r.cell_vertex_indices.resize_uninitialized(at(polygons));
    if (!r.indptr.empty()) detail::keep_entries(r, stays);
    r.lists_walls = list_walls;
    if (!has_faces) return;
    r.face_vertices.resize_uninitialized(2 * edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        r.face_offsets[e + 1] = std::int64_t{2} * static_cast<std::int64_t>(e + 1);
        for (std::size_t k = 0; k < 2; ++k) r.face_vertices[2 * e + k] = edges[e][k];
    }
}

}  // namespace

void flatten(Result& result, const Want& wanted, bool list_walls, double min_face, double min_area) {
    result.planar = true;
    const std::size_t count = result.status.size();
    flatten_rows(result, wanted, list_walls);
    const std::uint64_t dropped = min_face > 0 || min_area > 0 ? drop_small_faces(result, min_face, min_area) : 0;
    detail::drop_third_components(result);
    for (std::size_t i = 0; i < result.face_counts.size(); ++i) {
        if (result.face_counts[i] == 0) continue;
        result.face_counts[i] -= Sheet::more_faces;
        result.edge_counts[i] = result.vertex_counts[i] = result.face_counts[i];
    }
    const double height = std::exchange(result.thickness, 0) / 2;
    for (double& radius : result.security_radii)
        radius = 2 * std::sqrt(std::max(0.0, (radius / 2 - height) * (radius / 2 + height)));
    detail::keep_wanted(result, wanted, list_walls);

    const auto make_flat = [](std::array<double, 3>& x) { x[2] = 0; };
    make_flat(result.box.lower);
    make_flat(result.box.upper);
    if (result.cell) {
        make_flat(result.cell->origin);
        make_flat(result.cell->c);
    }
    Stats& stats = result.stats;
    const std::uint64_t cells = count - stats.empty_cells;
    if (!result.mesh_cells) stats.faces -= Sheet::more_faces * cells;
    stats.faces -= dropped;
    if (stats.tiny_faces) *stats.tiny_faces -= std::min(*stats.tiny_faces, dropped);  // the smallest faces went first
    stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
}

}  // namespace votess
