// Seeds and the surface, scaled by a power of two to coordinates below 1, with the edges of triangles.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/at.hpp"
#include "core/vector3.hpp"
#include "surface/seed_tree.hpp"
#include "votess/surface.hpp"

namespace votess::surface {

class Surface {
public:
    // Throws invalid_argument.
    Surface(std::span<const double> points, const TriangleMesh& mesh, std::span<const double> weights,
            ThreadPool& pool);

    struct Triangle {
        std::array<std::int32_t, 3> vertex;
        std::array<std::int32_t, 3> edge;  // from each corner
        double area = 0;                   // 0: not part of the surface
        bool has_border = false;           // some edge has no other triangle
    };
    struct Edge {
        std::int32_t low, high;  // vertices
        std::int32_t first;      // triangle, the lowest
        std::int32_t triangles;  // their number
    };

    [[nodiscard]] std::size_t seeds() const { return seeds_.size(); }
    [[nodiscard]] const exact::Point& seed(std::int32_t i) const { return seeds_[at(i)]; }
    [[nodiscard]] bool has_weights() const { return !weights_.empty(); }
    [[nodiscard]] double weight(std::int32_t i) const { return weights_.empty() ? 0 : weights_[at(i)]; }
    // The bisector of two seeds, from the first.
    [[nodiscard]] exact::Plane bisector(std::int32_t i, std::int32_t k) const;
    [[nodiscard]] const SeedTree& tree() const { return *tree_; }
    [[nodiscard]] const std::vector<exact::Point>& vertices() const { return vertices_; }
    [[nodiscard]] const exact::Point& vertex(std::int32_t v) const { return vertices_[at(v)]; }
    [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
    [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
    [[nodiscard]] double scale() const { return scale_; }

private:
    void read_weights(std::span<const double> weights);
    void find_edges();

    double scale_ = 1;
    std::vector<exact::Point> seeds_, vertices_;
    std::vector<double> weights_;
    std::unique_ptr<SeedTree> tree_;
    std::vector<Triangle> triangles_;
    std::vector<Edge> edges_;
};

}  // namespace votess::surface
