// A tree of boxes over seeds, for searches near a place, and the seeds near each one.
//
// Seeds have numbers in the order of the tree, in which near ones follow each other.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
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
        std::uint32_t axis;        // along which they follow each other
    };

    // weights: may be empty. Of seeds at one place only that of the largest weight, or else of lowest index, is in the
    // tree: the others have no cells.
    SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights);

    [[nodiscard]] std::size_t size() const { return order_.size(); }
    // Returns a seed, by its number.
    [[nodiscard]] std::int32_t seed(std::uint32_t number) const { return order_[number]; }
    [[nodiscard]] const exact::Point& place(std::uint32_t number) const { return places_[number]; }
    [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
    // Returns the leaf of a number.
    [[nodiscard]] const Node& leaf(std::uint32_t number) const { return nodes_[leaf_of_[number]]; }

    // Calls visit(number) in the order of boxes by their distance from x. Passes over boxes with skip(node, square of
    // the distance).
    template <class Skip, class Visit>
    void visit_from(const exact::Point& x, Skip skip, Visit visit) const {
        std::array<std::pair<std::uint32_t, double>, max_depth> pending;
        pending[0] = {0, square_distance(nodes_[0], x)};
        for (std::size_t count = 1; count > 0;) {
            const auto [at, square] = pending[--count];
            const Node& node = nodes_[at];
            if (skip(node, square)) continue;
            if (node.child == 0) {
                for (std::uint32_t k = node.begin; k < node.end; ++k) visit(k);
                continue;
            }
            std::pair near{node.child, square_distance(nodes_[node.child], x)};
            std::pair far{node.child + 1, square_distance(nodes_[node.child + 1], x)};
            if (far.second < near.second) std::swap(near, far);
            pending[count++] = far;
            pending[count++] = near;
        }
    }
    // Calls visit(number) for all seeds whose distance from a box has a square of at most reach, those near its center
    // early. visit() may lower reach. Passes over boxes with skip(node).
    template <class Skip, class Visit>
    void visit_around(const exact::Point& lower, const exact::Point& upper, const exact::Point& center,
                      const double& reach, Skip skip, Visit visit) const {
        std::array<std::pair<std::uint32_t, double>, max_depth> pending;
        pending[0] = {0, 0};
        for (std::size_t count = 1; count > 0;) {
            const auto [at, square] = pending[--count];
            if (square > reach) continue;
            const Node& node = nodes_[at];
            if (skip(node)) continue;
            if (node.child == 0) {
                for (std::uint32_t k = node.begin; k < node.end; ++k)
                    if (square_between(places_[k], places_[k], lower, upper) <= reach) visit(k);
                continue;
            }
            const Node& low = nodes_[node.child];
            const Node& high = nodes_[node.child + 1];
            const std::uint32_t is_far = 2 * center[node.axis] < low.upper[node.axis] + high.lower[node.axis] ? 1 : 0;
            for (const std::uint32_t child : {node.child + is_far, node.child + 1 - is_far}) {
                const double gap = square_between(nodes_[child].lower, nodes_[child].upper, lower, upper);
                pending[count] = {child, gap};
                count += gap <= reach ? 1 : 0;
            }
        }
    }
    // Returns the square of the distance between two boxes.
    [[nodiscard]] static double square_between(const exact::Point& lower, const exact::Point& upper,
                                               const exact::Point& other_lower, const exact::Point& other_upper) {
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double below = other_lower[k] - upper[k], above = lower[k] - other_upper[k];
            const double twice = (below + std::abs(below)) + (above + std::abs(above));  // the gap, without branches
            square += twice * twice;
        }
        return square / 4;
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
    struct Item {
        exact::Point place;
        std::int32_t seed;
    };
    void split(std::uint32_t at, std::span<Item> items, std::span<const double> weights);

    std::vector<Node> nodes_;
    std::vector<std::int32_t> order_;
    std::vector<exact::Point> places_;    // in that order
    std::vector<std::uint32_t> leaf_of_;  // nodes, in that order
};

// The seeds near each one. They are found for all seeds of a leaf when one is asked for first, on any thread.
class NearSeeds {
public:
    // Around one seed, nearly ascending by distance: by squares in float. Complete up to the square of a distance.
    struct List {
        std::span<const std::uint32_t> numbers;
        double complete;
    };
    static constexpr double order_rounding = 1e-6;  // of squares

    explicit NearSeeds(const SeedTree& tree) : tree_(tree), of_leaf_(tree.nodes().size()) {}
    ~NearSeeds() {
        for (const auto& lists : of_leaf_) delete lists.load(std::memory_order_relaxed);
    }
    NearSeeds(const NearSeeds&) = delete;
    NearSeeds& operator=(const NearSeeds&) = delete;

    [[nodiscard]] List of(std::uint32_t number) const {
        const SeedTree::Node& leaf = tree_.leaf(number);
        const Lists& lists = of_leaf(leaf);
        const std::size_t k = number - leaf.begin;
        return {std::span(lists.numbers).subspan(lists.begin[k], lists.begin[k + 1] - lists.begin[k]), lists.complete};
    }

private:
    struct Lists {
        double complete = 0;
        std::vector<std::uint32_t> begin;  // by seed of the leaf, and the end
        std::vector<std::uint32_t> numbers;
    };
    [[nodiscard]] const Lists& of_leaf(const SeedTree::Node& leaf) const;
    [[nodiscard]] std::unique_ptr<Lists> make(const SeedTree::Node& leaf) const;
    // Lists the seeds around a leaf up to a distance, or max_listed and more of them.
    void collect(const SeedTree::Node& leaf, double distance, std::vector<std::uint32_t>& found) const;

    const SeedTree& tree_;
    mutable std::vector<std::atomic<const Lists*>> of_leaf_;  // by node
};

}  // namespace votess::surface
