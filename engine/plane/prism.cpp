#include "plane/prism.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>

#include "core/at.hpp"
#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "input/option_name.hpp"
#include "solid/mesh_signs.hpp"

namespace votess {
namespace {

constexpr std::int32_t sides_of_edge = 2;

[[noreturn]] void refuse_mesh(const std::string& message) {
    refuse(option("mesh") + ": " + message);
}

void check_shapes(const TriangleMesh& rings) {
    const auto shape = [](const char* what, std::size_t size, const char* rows) {
        if (size % 2 != 0)
            refuse_mesh(std::string(what) + " hold " + std::to_string(size) +
                        " numbers, not a multiple of 2: the shape must be " + rows + " in two dimensions");
        if (size / 2 > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() / 4))
            refuse_mesh(std::to_string(size / 2) + " " + what + " are too many: give at most 536870911");
    };
    shape("vertices", rings.vertices.size(), "(V,2)");
    shape("edges", rings.triangles.size(), "(E,2)");
    if (rings.triangles.empty()) refuse_mesh("it has no edges: give closed rings, of at least 3");
    if (rings.tolerance != 0)
        refuse_mesh("a tolerance is for meshes in three dimensions: leave out " + option("mesh.tolerance"));
}

// Calls visit(ring) with the vertices of each ring. Throws unless edges are rings.
void for_rings(const std::vector<std::int32_t>& edges, const std::vector<double>& vertices, const auto& visit) {
    const std::size_t count = vertices.size() / 6;
    std::vector<std::size_t> first(count + 1);  // edges from each vertex, as offsets
    std::vector<std::int64_t> more(count);      // edges from it, less those to it
    for (std::size_t e = 0; e < edges.size(); e += 2)
        ++first[at(edges[e]) + 1], ++more[at(edges[e])], --more[at(edges[e + 1])];
    for (std::size_t v = 0; v < count; ++v)
        if (more[v] != 0)
            refuse_mesh("vertex " + std::to_string(v) + " (" + number(vertices[3 * v]) + ", " +
                        number(vertices[3 * v + 1]) + ") " + (more[v] > 0 ? "begins " : "ends ") +
                        std::to_string(std::abs(more[v])) + (std::abs(more[v]) == 1 ? " edge" : " edges") +
                        " more than it " + (more[v] > 0 ? "ends" : "begins") +
                        ": give closed rings, each in one direction");
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::int32_t> next(edges.size() / 2), ring;
    std::vector<std::size_t> fill(first.begin(), first.end() - 1);
    for (std::size_t e = 0; e < edges.size(); e += 2) next[fill[at(edges[e])]++] = edges[e + 1];
    fill.assign(first.begin(), first.end() - 1);
    for (std::int32_t start = 0; at(start) < count; ++start)
        while (fill[at(start)] < first[at(start) + 1]) {
            ring.clear();
            std::int32_t v = start;
            do {
                ring.push_back(v);
                v = next[fill[at(v)]++];
            } while (v != start);
            visit(ring);
        }
}

}  // namespace

Prism::Prism(const TriangleMesh& rings, double height) {
    check_shapes(rings);
    const std::size_t count = rings.vertices.size() / 2;
    vertices_.resize(6 * count);
    for (std::size_t v = 0; v < count; ++v) {
        for (std::size_t k = 0; k < 2; ++k) {
            const double x = vertices_[3 * v + k] = vertices_[3 * (count + v) + k] = rings.vertices[2 * v + k];
            if (!std::isfinite(x))
                refuse_mesh("vertex " + std::to_string(v) + ": " + axis_name[k] + " = " + number(x) + " is not finite");
        }
        vertices_[3 * v + 2] = -height;
        vertices_[3 * (count + v) + 2] = height;
    }
    edges_.assign(rings.triangles.begin(), rings.triangles.end());
    for (std::size_t e = 0; e < edges_.size(); ++e)
        if (edges_[e] < 0 || at(edges_[e]) >= count)
            refuse_mesh("edge " + std::to_string(e / 2) + " names vertex " + std::to_string(edges_[e]) +
                        ", but there are " + std::to_string(count) + ": give indices from 0 on");
    names_.resize(edges_.size() / 2);
    std::iota(names_.begin(), names_.end(), 0);
    for_rings(edges_, vertices_, [](const auto&) {});  // before vertices are merged, for its messages
    merge_vertices();
    split_edges();
    add_sides();
    add_caps();
}

// Edges name the first of all vertices at a place.
void Prism::merge_vertices() {
    const std::size_t count = vertices_.size() / 6;
    std::vector<std::int32_t> order(count), first(count);
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](std::int32_t v) { return std::pair(vertices_[3 * at(v)], vertices_[3 * at(v) + 1]); };
    std::ranges::sort(order, {}, [&](std::int32_t v) { return std::pair(place(v), v); });
    for (std::size_t k = 0; k < count; ++k)
        first[at(order[k])] = k > 0 && place(order[k]) == place(order[k - 1]) ? first[at(order[k - 1])] : order[k];
    for (std::int32_t& v : edges_) v = first[at(v)];
}

// Finds vertices in a grid over the bounds. Signs are exact.
void Prism::split_edges() {
    std::vector<std::int32_t> used(edges_);
    std::ranges::sort(used);
    used.erase(std::ranges::unique(used).begin(), used.end());
    const auto place = [&](std::int32_t v) { return point_of(vertices_, at(v)); };
    Box bounds = empty_box;
    for (const std::int32_t v : used) include(bounds, place(v));
    const std::size_t side = static_cast<std::size_t>(std::sqrt(static_cast<double>(used.size()))) + 1;
    // Returns the column or row of a coordinate, which ascends with it.
    const auto cell_of = [&](double x, std::size_t k) {
        const double width = bounds.upper[k] - bounds.lower[k];
        const double along = width > 0 ? (x - bounds.lower[k]) / width * static_cast<double>(side) : 0;
        return static_cast<std::size_t>(std::clamp(along, 0.0, static_cast<double>(side - 1)));
    };
    std::vector<std::vector<std::int32_t>> cells(side * side);
    for (const std::int32_t v : used) cells[cell_of(place(v)[0], 0) * side + cell_of(place(v)[1], 1)].push_back(v);

    std::vector<std::int32_t> edges, names, on_edge;
    for (std::size_t e = 0; e < edges_.size(); e += 2) {
        check_stop();
        const std::int32_t u = edges_[e], w = edges_[e + 1];
        const Vector3 a = place(u), b = place(w);
        on_edge.clear();
        const std::size_t first = cell_of(std::min(a[0], b[0]), 0), last = cell_of(std::max(a[0], b[0]), 0);
        for (std::size_t column = first; column <= last; ++column) {
            // Rows that the edge passes in this column, and one more on either side for rounding.
            const auto y_at = [&](std::size_t c) {
                const double x = bounds.lower[0] + (bounds.upper[0] - bounds.lower[0]) * static_cast<double>(c) /
                                                       static_cast<double>(side);
                const double t = a[0] == b[0] ? 0 : std::clamp((x - a[0]) / (b[0] - a[0]), 0.0, 1.0);
                return a[1] + t * (b[1] - a[1]);
            };
            const bool upright = first == last || a[0] == b[0];
            const double y = upright ? a[1] : y_at(column), z = upright ? b[1] : y_at(column + 1);
            const std::size_t low = cell_of(std::min(y, z), 1), high = cell_of(std::max(y, z), 1);
            for (std::size_t row = low - (low > 0); row <= std::min(high + 1, side - 1); ++row)
                for (const std::int32_t v : cells[column * side + row]) {
                    const Vector3 x = place(v);
                    const bool within = std::min(a[0], b[0]) <= x[0] && x[0] <= std::max(a[0], b[0]) &&
                                        std::min(a[1], b[1]) <= x[1] && x[1] <= std::max(a[1], b[1]);
                    if (v != u && v != w && within &&
                        solid::cross_sign({a[0], a[1], 0}, {b[0], b[1], 0}, {x[0], x[1], 0}, 2) == 0)
                        on_edge.push_back(v);
                }
        }
        const std::size_t axis = std::abs(b[0] - a[0]) >= std::abs(b[1] - a[1]) ? 0 : 1;
        std::ranges::sort(on_edge, {}, [&](std::int32_t v) { return std::abs(place(v)[axis] - a[axis]); });
        std::int32_t from = u;
        on_edge.push_back(w);
        for (const std::int32_t to : on_edge) {
            edges.insert(edges.end(), {from, to});
            names.push_back(names_[e / 2]);
            from = to;
        }
    }
    edges_ = std::move(edges);
    names_ = std::move(names);
}

void Prism::add_sides() {
    const auto count = static_cast<std::int32_t>(vertices_.size() / 6);
    triangles_.reserve(sides_of_edge * 3 * edges_.size() / 2);
    const double* const origin = &vertices_[3 * at(edges_.front())];
    double extent = 0;
    for (const std::int32_t v : edges_)
        for (std::size_t k = 0; k < 2; ++k) extent = std::max(extent, std::abs(vertices_[3 * at(v) + k] - origin[k]));
    const int exponent = extent > 0 ? std::ilogb(extent) : 0;  // products of very short or long sides are no numbers
    const auto from_origin = [&](std::int32_t v) {
        const double* const x = &vertices_[3 * at(v)];
        return std::array{std::scalbn(x[0] - origin[0], -exponent), std::scalbn(x[1] - origin[1], -exponent)};
    };
    double area = 0, size = 0;
    for (std::size_t e = 0; e < edges_.size(); e += 2) {
        const std::int32_t u = edges_[e], v = edges_[e + 1];
        triangles_.insert(triangles_.end(), {u, v, v + count, u, v + count, u + count});
        const auto a = from_origin(u), b = from_origin(v);
        const double part = a[0] * b[1], other = a[1] * b[0];
        area += 0.5 * (part - other);
        size += std::abs(part) + std::abs(other);
    }
    constexpr double rounding = 1e-12;
    if (area == 0) refuse_mesh("its rings enclose no area");
    if (area < -rounding * size)
        refuse_mesh("its rings run clockwise, so that they enclose the area " +
                    number(std::scalbn(area, 2 * exponent)) + ": reverse them; the domain is on the left of each edge");
}

void Prism::add_caps() {
    for_rings(edges_, vertices_, [&](std::vector<std::int32_t>& ring) {
        ring.push_back(ring.front());
        add_cap(ring, 0, ring.size() - 1);
    });
}

// Halves a ring, so that a place of the plane lies below few triangles. Some may lie outside of the ring: their turns
// then cancel.
void Prism::add_cap(const std::vector<std::int32_t>& ring, std::size_t begin, std::size_t end) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto count = static_cast<std::int32_t>(vertices_.size() / 6);
    const std::int32_t u = ring[begin], v = ring[middle], w = ring[end];
    if (u != v && v != w && w != u) triangles_.insert(triangles_.end(), {u + count, v + count, w + count, u, w, v});
    add_cap(ring, begin, middle);
    add_cap(ring, middle, end);
}

Rings::Rings(const TriangleMesh& prism) {
    const std::size_t count = prism.vertices.size() / 6;
    for (std::size_t v = 0; v < count; ++v)
        vertices.insert(vertices.end(), {prism.vertices[3 * v], prism.vertices[3 * v + 1]});
    // The sides are the first triangles: u v v' and u v' u'.
    const auto above = static_cast<std::int32_t>(count);
    for (std::size_t t = 0; t + 5 < prism.triangles.size(); t += 6) {
        const std::int32_t u = prism.triangles[t], v = prism.triangles[t + 1], next = prism.triangles[t + 2];
        if (u >= above || v >= above || next != v + above) break;
        edges.insert(edges.end(), {u, v});
    }
}

}  // namespace votess
