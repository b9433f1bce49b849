#include "plane/prism.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>

#include "core/text.hpp"
#include "input/option_name.hpp"

namespace votess {
namespace {

constexpr std::int32_t sides_of_edge = 2;

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, option("mesh") + ": " + message);
}

std::size_t at(std::int32_t i) {
    return static_cast<std::size_t>(i);
}

void check_shapes(const TriangleMesh& rings) {
    const auto shape = [](const char* what, std::size_t size, const char* rows) {
        if (size % 2 != 0)
            refuse(std::string(what) + " hold " + std::to_string(size) +
                   " numbers, not a multiple of 2: the shape must be " + rows + " in two dimensions");
        if (size / 2 > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() / 4))
            refuse(std::to_string(size / 2) + " " + what + " are too many: give at most 536870911");
    };
    shape("vertices", rings.vertices.size(), "(V,2)");
    shape("edges", rings.triangles.size(), "(E,2)");
    if (rings.triangles.empty()) refuse("it has no edges: give closed rings, of at least 3");
    if (rings.tolerance != 0)
        refuse("a tolerance is for meshes in three dimensions: leave out " + option("mesh.tolerance"));
}

// Edges name the first of all vertices at a place.
void merge(const std::vector<double>& vertices, std::size_t count, std::vector<std::int32_t>& edges) {
    std::vector<std::int32_t> order(count), first(count);
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](std::int32_t v) { return std::pair(vertices[3 * at(v)], vertices[3 * at(v) + 1]); };
    std::ranges::sort(order, {}, [&](std::int32_t v) { return std::pair(place(v), v); });
    for (std::size_t k = 0; k < count; ++k)
        first[at(order[k])] = k > 0 && place(order[k]) == place(order[k - 1]) ? first[at(order[k - 1])] : order[k];
    for (std::int32_t& v : edges) v = first[at(v)];
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
            refuse("vertex " + std::to_string(v) + " (" + number(vertices[3 * v]) + ", " + number(vertices[3 * v + 1]) +
                   ") " + (more[v] > 0 ? "begins " : "ends ") + std::to_string(std::abs(more[v])) +
                   (std::abs(more[v]) == 1 ? " edge" : " edges") + " more than it " +
                   (more[v] > 0 ? "ends" : "begins") + ": give closed rings, each in one direction");
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
                refuse("vertex " + std::to_string(v) + ": " + axis_name[k] + " = " + number(x) + " is not finite");
        }
        vertices_[3 * v + 2] = -height;
        vertices_[3 * (count + v) + 2] = height;
    }
    edges_.assign(rings.triangles.begin(), rings.triangles.end());
    for (std::size_t e = 0; e < edges_.size(); ++e)
        if (edges_[e] < 0 || at(edges_[e]) >= count)
            refuse("edge " + std::to_string(e / 2) + " names vertex " + std::to_string(edges_[e]) + ", but there are " +
                   std::to_string(count) + ": give indices from 0 on");
    if (rings.merge) merge(vertices_, count, edges_);
    add_sides();
    add_caps();
}

void Prism::add_sides() {
    const auto count = static_cast<std::int32_t>(vertices_.size() / 6);
    triangles_.reserve(sides_of_edge * 3 * edges_.size() / 2);
    double area = 0, size = 0;
    const double* const origin = &vertices_[3 * at(edges_.front())];
    for (std::size_t e = 0; e < edges_.size(); e += 2) {
        const std::int32_t u = edges_[e], v = edges_[e + 1];
        triangles_.insert(triangles_.end(), {u, v, v + count, u, v + count, u + count});
        const double *a = &vertices_[3 * at(u)], *b = &vertices_[3 * at(v)];
        const double part = (a[0] - origin[0]) * (b[1] - origin[1]), other = (a[1] - origin[1]) * (b[0] - origin[0]);
        area += 0.5 * (part - other);
        size += std::abs(part) + std::abs(other);
    }
    constexpr double rounding = 1e-12;
    if (area < -rounding * size)
        refuse("its rings run clockwise, so that they enclose the area " + number(area) +
               ": reverse them; the domain is on the left of each edge");
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
