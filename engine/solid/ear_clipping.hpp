// Cuts a polygon with holes into triangles, ear by ear.
//
// A triangle of three successive corners is an ear if it is convex and holds no other corner. Without one the best of
// the others is cut off, as after rounding or where loops touch. So the triangles always have the loops as their
// boundary: each edge of a loop occurs once, each other edge once in each direction. Libraries that drop corners on a
// straight edge, or add some, would open the surface there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

namespace votess::solid {

struct FlatCorner {
    double x, y;
    std::int32_t id;
};

class EarClipping {
public:
    // loops: the first is the outline, counterclockwise or not; the others are holes, which run the other way. Each has
    // at least three corners. Returns triples of ids, in the order of the outline. Valid until the next call.
    const std::vector<std::array<std::int32_t, 3>>& cut(std::span<const std::vector<FlatCorner>> loops);

private:
    struct Node {
        double x, y;
        std::int32_t id, previous, next;
        bool reflex, gone;
    };
    // Demands on an ear, from strict to none.
    enum class Demand : std::uint8_t { thick, convex, flat, overlapping, any };

    [[nodiscard]] const Node& node(std::int32_t n) const { return nodes_[static_cast<std::size_t>(n)]; }
    [[nodiscard]] Node& node(std::int32_t n) { return nodes_[static_cast<std::size_t>(n)]; }
    [[nodiscard]] double turn(std::int32_t a, std::int32_t b, std::int32_t c) const;  // twice the area
    std::int32_t add_loop(const std::vector<FlatCorner>& loop, double mirror);
    void join(std::int32_t hole, std::int32_t outline);
    [[nodiscard]] std::int32_t find_bridge(std::int32_t hole, std::int32_t outline) const;
    [[nodiscard]] bool is_ear(std::int32_t n, Demand demand) const;
    void set_reflex(std::int32_t n);
    void clip(std::int32_t start);

    // At a corner: counterclockwise from one neighbor to another.
    struct Angle {
        std::int32_t from, to;
    };
    [[nodiscard]] bool overlap(std::int32_t corner, const Angle& one, const Angle& other) const;

    double unit_ = 1, slack_ = 0;  // of positions; of areas
    std::vector<Node> nodes_;
    std::vector<std::int32_t> by_x_, holes_;
    std::unordered_set<std::uint64_t> edges_;  // of the loops, the bridges and the ears
    std::vector<std::array<std::int32_t, 3>> triangles_;
};

// Returns twice the area, positive for a counterclockwise loop.
[[nodiscard]] double doubled_area(const std::vector<FlatCorner>& loop);

}  // namespace votess::solid
