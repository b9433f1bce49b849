// The seeds along a Hilbert curve, with a hierarchy of their boxes for searches near a place, and the seeds near each
// one.
//
// Seeds have numbers in that order, in which near ones follow each other. Eight of them are a group.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/thread_pool.hpp"
#include "exact/predicate.hpp"
#include "index/hierarchy.hpp"
#include "surface/kernels.hpp"

namespace votess::surface {

class SeedTree {
public:
    struct Node {
        double square;  // of its distance
        int level;      // 0: a group
        std::uint32_t index;
    };

    // weights: may be empty. Of seeds at one place only that of the largest weight, or else of lowest index, is in the
    // tree: the others have no cells.
    SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights, ThreadPool& pool);

    [[nodiscard]] std::size_t size() const { return seeds_.size(); }
    [[nodiscard]] std::size_t groups() const { return hierarchy_.count(0); }
    // Returns a seed, by its number.
    [[nodiscard]] std::int32_t seed(std::uint32_t number) const { return seeds_.input[number]; }
    [[nodiscard]] exact::Point place(std::uint32_t number) const {
        return {seeds_.x[number], seeds_.y[number], seeds_.z[number]};
    }
    // Coordinates of all seeds, from a number on. Those that fill up the last group are infinite.
    [[nodiscard]] std::array<const double*, 3> places(std::uint32_t from) const {
        return {&seeds_.x[from], &seeds_.y[from], &seeds_.z[from]};
    }
    [[nodiscard]] Node root() const { return {0, hierarchy_.top_level(), 0}; }
    [[nodiscard]] Box box(const Node& node) const { return hierarchy_.box(node.level, node.index); }
    // Returns the largest weight of a seed.
    [[nodiscard]] double weight(const Node& node) const { return hierarchy_.largest_weight(node.level, node.index); }

    // Calls visit(first, end) with the numbers of groups whose distance from a box has a square of at most reach, near
    // ones early. visit() may lower reach. Passes over boxes with skip(node).
    template <class Skip, class Visit>
    void visit(const Box& home, const double& reach, Skip skip, Visit visit) const {
        std::array<Node, cpu::Hierarchy::max_nodes> pending;
        pending[0] = root();
        for (std::size_t count = 1; count > 0;) {
            const Node node = pending[--count];
            if (node.square > reach || skip(node)) continue;
            if (node.level == 0) {
                const auto first = static_cast<std::uint32_t>(group * node.index);
                visit(first, std::min(first + static_cast<std::uint32_t>(group), static_cast<std::uint32_t>(size())));
                continue;
            }
            std::array<double, group> squares;
            unsigned near = kernels_.near_boxes(hierarchy_.block(node.level - 1, node.index), home,
                                                std::min(reach, std::numeric_limits<double>::max()), squares.data());
            const std::size_t first = count;
            for (; near != 0; near &= near - 1) {
                const auto k = static_cast<std::uint32_t>(std::countr_zero(near));
                std::size_t to = count++;
                for (; to > first && pending[to - 1].square < squares[k]; --to) pending[to] = pending[to - 1];
                pending[to] = {squares[k], node.level - 1, static_cast<std::uint32_t>(group) * node.index + k};
            }
        }
    }
    // The same around a place, for each number.
    template <class Skip, class Visit>
    void visit_from(const exact::Point& x, const double& reach, Skip skip, Visit visit) const {
        this->visit({x, x}, reach, skip, [&](std::uint32_t k, std::uint32_t end) {
            for (; k < end; ++k) visit(k);
        });
    }

private:
    const SurfaceKernels& kernels_;
    cpu::SortedSeeds seeds_;
    cpu::Hierarchy hierarchy_;
};

// The seeds near each one. They are found for all seeds of a group when one is asked for first, on any thread.
class NearSeeds {
public:
    // Around one seed, nearly ascending by distance: by squares in float. Complete up to the square of a distance.
    struct List {
        std::span<const std::uint32_t> numbers;
        double complete;
    };
    static constexpr double order_rounding = 1e-6;  // of squares

    explicit NearSeeds(const SeedTree& tree) : tree_(tree), of_group_(tree.groups()) {}
    ~NearSeeds() {
        for (const auto& lists : of_group_) delete lists.load(std::memory_order_relaxed);
    }
    NearSeeds(const NearSeeds&) = delete;
    NearSeeds& operator=(const NearSeeds&) = delete;

    [[nodiscard]] List of(std::uint32_t number) const {
        const Lists& lists = of_group(number / group);
        const std::size_t k = number % group;
        return {std::span(lists.numbers).subspan(lists.begin[k], lists.begin[k + 1] - lists.begin[k]), lists.complete};
    }

private:
    struct Lists {
        double complete = 0;
        std::vector<std::uint32_t> begin;  // by seed of the group, and the end
        std::vector<std::uint32_t> numbers;
    };
    [[nodiscard]] const Lists& of_group(std::size_t index) const;
    [[nodiscard]] std::unique_ptr<Lists> make(std::size_t index) const;
    // Lists the seeds around a box up to a distance, or max_listed and more of them.
    void collect(const Box& box, double distance, std::vector<std::uint32_t>& found) const;

    const SeedTree& tree_;
    mutable std::vector<std::atomic<const Lists*>> of_group_;
};

}  // namespace votess::surface
