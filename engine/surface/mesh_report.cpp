#include "surface/mesh_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "surface/nearest.hpp"
#include "surface/seed_tree.hpp"

namespace votess::surface {
namespace {

Vector3 place_at(const std::vector<double>& places, std::int32_t i) {
    const std::size_t k = 3 * at(i);
    return {places[k], places[k + 1], places[k + 2]};
}

struct Edge {
    std::int32_t low, high;
    std::size_t triangles;
};

// Returns the edges of triangles, each once.
std::vector<Edge> edges_of(const std::vector<std::int32_t>& triangles) {
    std::vector<std::pair<std::int32_t, std::int32_t>> sides;
    for (std::size_t k = 0; k < triangles.size(); ++k)
        sides.push_back(std::minmax({triangles[k], triangles[k % 3 == 2 ? k - 2 : k + 1]}));
    std::ranges::sort(sides);
    std::vector<Edge> edges;
    for (const auto& [low, high] : sides) {
        if (edges.empty() || edges.back().low != low || edges.back().high != high) edges.push_back({low, high, 0});
        ++edges.back().triangles;
    }
    return edges;
}

// Returns the connected part that is the first of each cell, and their number.
std::vector<std::int32_t> first_parts(const SurfaceCells& cells) {
    std::vector<std::int32_t> first{0};
    for (const std::int32_t pieces : cells.pieces) first.push_back(first.back() + pieces);
    return first;
}

// Lists of items by vertex.
class Lists {
public:
    // of_item(item): its vertices.
    template <class Vertices>
    Lists(std::size_t vertices, std::size_t items, const Vertices& of_item) : begin_(vertices + 1) {
        for (std::size_t i = 0; i < items; ++i)
            for (const std::int32_t v : of_item(i)) ++begin_[at(v) + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        items_.resize(begin_.back());
        std::vector<std::size_t> next = begin_;
        for (std::size_t i = 0; i < items; ++i)
            for (const std::int32_t v : of_item(i)) items_[next[at(v)]++] = i;
    }
    [[nodiscard]] std::span<const std::size_t> of(std::int32_t vertex) const {
        return {items_.data() + begin_[at(vertex)], begin_[at(vertex) + 1] - begin_[at(vertex)]};
    }

private:
    std::vector<std::size_t> begin_, items_;
};

// Distances between a mesh and the surface that its cells lie on. What is near a vertex is looked for around it and its
// neighbors.
class Distances {
public:
    explicit Distances(const Remesh& mesh)
        : mesh_(mesh),
          triangles_(mesh.vertices.size() / 3, mesh.triangles.size() / 3,
                     [&](std::size_t t) { return std::span(mesh.triangles).subspan(3 * t, 3); }),
          polygons_(mesh.vertices.size() / 3, mesh.cells.polygon_pieces.size(),
                    [&](std::size_t p) { return std::span(mesh.cells.polygon_pieces).subspan(p, 1); }) {}

    [[nodiscard]] double largest() {
        if (mesh_.triangles.empty()) return infinity;
        double largest = 0;
        for (std::int32_t v = 0; at(v) < mesh_.vertices.size() / 3; ++v) {
            check_stop();
            gather({v});
            if (near_.empty()) continue;
            const bool has_triangles = !triangles_.of(v).empty();
            for (const std::size_t p : polygons_.of(v))
                for (std::int64_t c = mesh_.cells.polygon_offsets[p]; c < mesh_.cells.polygon_offsets[p + 1]; ++c) {
                    const Vector3 x = place_at(mesh_.cells.vertices, mesh_.cells.corners[at(c)]);
                    if (!has_triangles) gather({nearest_vertex(x)});
                    largest = std::max(largest, to_mesh(x));
                }
        }
        for (std::size_t t = 0; t < mesh_.triangles.size() / 3; ++t) {
            check_stop();
            const std::int32_t* const corner = &mesh_.triangles[3 * t];
            gather({corner[0], corner[1], corner[2]});
            const Vector3 a = place_at(mesh_.vertices, corner[0]), b = place_at(mesh_.vertices, corner[1]),
                          c = place_at(mesh_.vertices, corner[2]);
            const auto middle = [](const Vector3& u, const Vector3& v) { return along(u, minus(v, u), 0.5); };
            for (const Vector3& x :
                 {middle(a, b), middle(b, c), middle(c, a), along(middle(a, b), minus(c, middle(a, b)), 1.0 / 3)})
                largest = std::max(largest, to_surface(x));
        }
        return largest;
    }

private:
    // Finds the neighbors of some vertices, and these.
    void gather(std::initializer_list<std::int32_t> around) {
        near_.assign(around);
        for (const std::int32_t v : around)
            for (const std::size_t t : triangles_.of(v))
                near_.insert(near_.end(), &mesh_.triangles[3 * t], &mesh_.triangles[3 * t] + 3);
        std::ranges::sort(near_);
        near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
        near_triangles_.clear();
        for (const std::int32_t v : near_)
            near_triangles_.insert(near_triangles_.end(), triangles_.of(v).begin(), triangles_.of(v).end());
        std::ranges::sort(near_triangles_);
        near_triangles_.erase(std::unique(near_triangles_.begin(), near_triangles_.end()), near_triangles_.end());
    }

    [[nodiscard]] double to_mesh(const Vector3& x) const {
        double least = infinity;
        for (const std::size_t t : near_triangles_) {
            const std::int32_t* const corner = &mesh_.triangles[3 * t];
            least = std::min(least, distance(x, nearest_on_triangle(x, place_at(mesh_.vertices, corner[0]),
                                                                    place_at(mesh_.vertices, corner[1]),
                                                                    place_at(mesh_.vertices, corner[2]))));
        }
        return least;
    }

    [[nodiscard]] double to_surface(const Vector3& x) const {
        double least = infinity;
        for (const std::int32_t v : near_)
            for (const std::size_t p : polygons_.of(v)) {
                const auto corner = [&](std::int64_t c) {
                    return place_at(mesh_.cells.vertices, mesh_.cells.corners[at(c)]);
                };
                const std::int64_t begin = mesh_.cells.polygon_offsets[p], end = mesh_.cells.polygon_offsets[p + 1];
                for (std::int64_t c = begin + 1; c + 1 < end; ++c)
                    least =
                        std::min(least, distance(x, nearest_on_triangle(x, corner(begin), corner(c), corner(c + 1))));
            }
        return least;
    }

    // Returns the vertex of a triangle that is nearest to a place.
    [[nodiscard]] std::int32_t nearest_vertex(const Vector3& x) {
        if (!tree_) {
            std::vector<exact::Point> places;
            for (std::int32_t v = 0; at(v) < mesh_.vertices.size() / 3; ++v)
                if (!triangles_.of(v).empty()) used_.push_back(v), places.push_back(place_at(mesh_.vertices, v));
            tree_ = std::make_unique<SeedTree>(places, std::span<const double>());
        }
        double least = infinity;
        std::int32_t best = used_.front();
        tree_->visit_from(
            x, [&](const SeedTree::Node&, double square) { return square > least; },
            [&](std::uint32_t number) {
                const Vector3 d = minus(tree_->place(number), x);
                if (const double square = dot(d, d); square < least)
                    least = square, best = used_[at(tree_->seed(number))];
            });
        return best;
    }

    const Remesh& mesh_;
    Lists triangles_, polygons_;  // by vertex
    std::vector<std::int32_t> near_;
    std::vector<std::size_t> near_triangles_;
    std::unique_ptr<SeedTree> tree_;
    std::vector<std::int32_t> used_;  // vertices by their order in the tree
};

void measure_angles(Remesh& mesh) {
    const std::size_t count = mesh.triangles.size() / 3;
    mesh.min_angle = count > 0 ? 180 : 0;
    double sum = 0;
    for (std::size_t t = 0; t < count; ++t) {
        double least = 180;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector3 x = place_at(mesh.vertices, mesh.triangles[3 * t + k]);
            const Vector3 a = minus(place_at(mesh.vertices, mesh.triangles[3 * t + (k + 1) % 3]), x);
            const Vector3 b = minus(place_at(mesh.vertices, mesh.triangles[3 * t + (k + 2) % 3]), x);
            const Vector3 n = cross(a, b);
            least = std::min(least, std::atan2(length3(n[0], n[1], n[2]), dot(a, b)) * 180 / std::numbers::pi);
        }
        sum += least;
        mesh.min_angle = std::min(mesh.min_angle, least);
    }
    mesh.mean_min_angle = count > 0 ? sum / static_cast<double>(count) : 0;
}

// Marks parts without a triangle, and those with a common curve but no edge: a small component in two cells, or cells
// that follow each other along a ribbon. The mesh would lack them.
void mark_lone_parts(const SurfaceCells& cells, const std::vector<std::int32_t>& triangles,
                     const std::vector<std::int32_t>& first, std::vector<std::uint8_t>& bad) {
    std::vector<std::int32_t> cell_of(bad.size());
    for (std::size_t i = 0; i < cells.size(); ++i)
        std::fill(cell_of.begin() + first[i], cell_of.begin() + first[i + 1], static_cast<std::int32_t>(i));
    std::vector<std::pair<std::int32_t, std::int32_t>> joined;  // a part, and a cell that an edge leads to
    for (const auto& [low, high, count] : edges_of(triangles)) {
        joined.emplace_back(low, cell_of[at(high)]);
        joined.emplace_back(high, cell_of[at(low)]);
    }
    std::ranges::sort(joined);
    for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p)
        for (std::int64_t c = cells.polygon_offsets[p]; c < cells.polygon_offsets[p + 1]; ++c) {
            const std::pair side{cells.polygon_pieces[p], cells.beyond[at(c)]};
            if (side.second >= 0 && !std::ranges::binary_search(joined, side)) bad[at(side.first)] = 1;
        }
    std::vector<std::uint8_t> has_triangle(bad.size());
    for (const std::int32_t part : triangles) has_triangle[at(part)] = 1;
    for (std::size_t part = 0; part < bad.size(); ++part)
        if (has_triangle[part] == 0) bad[part] = 1;
}

}  // namespace

std::vector<std::uint8_t> faulty_parts(const SurfaceCells& cells, const std::vector<std::int32_t>& triangles,
                                       const Features& features) {
    const std::vector<std::int32_t> first = first_parts(cells);
    std::vector<std::uint8_t> bad(at(first.back())), at_border(bad.size()), is_crowded(bad.size());
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::int32_t piece = first[i]; piece < first[i + 1]; ++piece) {
            bad[at(piece)] = cells.euler[i] != cells.pieces[i] ? 1 : 0;
            at_border[at(piece)] = cells.borders[i] > 0 ? 1 : 0;
        }
    // Two cells of one part each with several common curves, as around an opening.
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::size_t k = at(cells.indptr[i]); k < at(cells.indptr[i + 1]); ++k)
            if (cells.pieces[i] == 1 && cells.pieces[at(cells.indices[k])] == 1 &&
                (cells.curves[k] != 1 || cells.loops[k] != 0))
                bad[at(first[i])] = 1;
    for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p)
        for (std::int64_t c = cells.polygon_offsets[p]; c < cells.polygon_offsets[p + 1]; ++c)
            if (const std::int32_t beyond = cells.beyond[at(c)];
                beyond < 0 && features.is_crowded(at(cells.polygon_triangles[p]), at(-1 - beyond)))
                is_crowded[at(cells.polygon_pieces[p])] = 1;
    for (std::size_t t = 0; t < cells.piece_dual_counts.size(); ++t)
        if (cells.piece_dual_counts[t] > 1) bad[at(cells.piece_dual[3 * t])] = 1;
    for (const auto& [low, high, count] : edges_of(triangles))
        if (count > 2 || (count == 1 && (at_border[at(low)] == 0 || at_border[at(high)] == 0)))
            bad[at(at_border[at(low)] == 0 ? low : high)] = 1;
    mark_lone_parts(cells, triangles, first, bad);
    for (std::size_t piece = 0; piece < bad.size(); ++piece)
        if (is_crowded[piece] != 0) bad[piece] = 0;
    return bad;
}

void report_on_mesh(Remesh& mesh, const Features& features) {
    measure_angles(mesh);
    for (const Edge& edge : edges_of(mesh.triangles)) {
        mesh.border_edges += edge.triangles == 1 ? 1 : 0;
        mesh.crowded_edges += edge.triangles > 2 ? 1 : 0;
    }
    const std::vector<std::uint8_t> bad = faulty_parts(mesh.cells, mesh.triangles, features);
    const std::vector<std::int32_t> first = first_parts(mesh.cells);
    for (std::size_t i = 0; i < mesh.cells.size(); ++i)
        if (std::any_of(bad.begin() + first[i], bad.begin() + first[i + 1], [](std::uint8_t b) { return b != 0; }))
            mesh.faults.push_back(static_cast<std::int32_t>(i));
    mesh.distance = Distances(mesh).largest();
}

}  // namespace votess::surface
