// A tree of boxes over seeds, for searches near a place.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::surface {

class SeedTree {
public:
    struct Node {
        exact::Point lower, upper;
        double weight;             // the largest
        std::uint32_t begin, end;  // seeds
        std::uint32_t child;       // the first of two; 0 for a leaf
    };

    // weights: may be empty. Of seeds at one place only that of the largest weight, or else of lowest index, is in the
    // tree: the others have no cells.
    SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights);

    [[nodiscard]] std::size_t size() const { return order_.size(); }

    // The seeds, such that those of a box follow each other.
    [[nodiscard]] const std::vector<std::int32_t>& order() const { return order_; }
    // Calls visit(seed, its place) in the order of boxes by their distance from x. Passes over boxes with skip(node,
    // square of the distance).
    template <class Skip, class Visit>
    void visit_from(const exact::Point& x, Skip skip, Visit visit) const {
        std::array<std::pair<std::uint32_t, double>, max_depth> pending;
        pending[0] = {0, square_distance(nodes_[0], x)};
        for (std::size_t count = 1; count > 0;) {
            const auto [at, square] = pending[--count];
            const Node& node = nodes_[at];
            if (skip(node, square)) continue;
            if (node.child == 0) {
                for (std::uint32_t k = node.begin; k < node.end; ++k) visit(order_[k], places_[k]);
                continue;
            }
            std::pair near{node.child, square_distance(nodes_[node.child], x)};
            std::pair far{node.child + 1, square_distance(nodes_[node.child + 1], x)};
            if (far.second < near.second) std::swap(near, far);
            pending[count++] = far;
            pending[count++] = near;
        }
    }
    [[nodiscard]] static double square_distance(const Node& node, const exact::Point& x) {
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double gap = std::max({0.0, node.lower[k] - x[k], x[k] - node.upper[k]});
            square += gap * gap;
        }
        return square;
    }

private:
    static constexpr std::size_t max_depth = 80;
    void split(std::uint32_t at, std::span<const exact::Point> seeds, std::span<const double> weights);

    std::vector<Node> nodes_;
    std::vector<std::int32_t> order_;
    std::vector<exact::Point> places_;  // in that order
};

}  // namespace votess::surface
