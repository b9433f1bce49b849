// The parts of one triangle in all cells, made together.
//
// On the triangle, the square of the distance from each seed, less that from one fixed place, is linear. The cells are
// the lower envelope of these functions. Each corner lies between three sites: seeds, or edges of the triangle. Corners
// and sides are the triangles and edges of a dual triangulation. A seed that is added removes the corners nearer to it,
// and gets a new one at each side that crosses the border of the hole (Bowyer, Watson 1981). So a side between two
// cells is made once. A seed can only cut if a corner is nearer to it, so the tree is searched up to their largest
// distance.
//
// Signs come from double, with bounds on the errors. Where a bound hides a sign, and for very many parts, make() gives
// up: ClippedTriangle decides then.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "surface/clipped_triangle.hpp"
#include "surface/kernels.hpp"
#include "surface/surface.hpp"

namespace votess::surface {

class TriangleCells {
public:
    explicit TriangleCells(const Surface& surface);

    // Begins with any triangle: what follows depends on none before.
    void restart() { hint_ = none; }
    // Returns whether it found all parts, sooner if the last triangle is near. exact: rounds corners whose bounds are
    // large.
    [[nodiscard]] bool make(std::int32_t triangle, ClippedTriangle& exact);
    [[nodiscard]] std::size_t parts() const { return part_count_; }
    [[nodiscard]] std::int32_t seed(std::size_t part) const {
        return surface_.tree().seed(functions_[parts_[part].first].number);
    }
    // Returns the area of a part.
    [[nodiscard]] double area(std::size_t part, double of_triangle) const;
    // Selects a part, for what follows.
    void select(std::size_t part);
    [[nodiscard]] std::int32_t seed() const { return surface_.tree().seed(number_); }
    [[nodiscard]] std::size_t size() const { return size_; }
    // As ClippedTriangle returns them.
    [[nodiscard]] Side side(std::size_t i) const { return sides_[i]; }
    [[nodiscard]] const std::array<double, 2>& weights(std::size_t i) const { return weights_[i]; }
    [[nodiscard]] Vector3 place(std::size_t i) const;
    [[nodiscard]] bool has_length(std::size_t) const { return true; }
    [[nodiscard]] bool has_area() const { return true; }

private:
    using Site = std::uint32_t;  // 0 to 2: edges of the triangle, each from its corner; then seeds
    static constexpr Site edges = 3;
    static constexpr std::uint32_t none = 0xffffffff;
    static constexpr std::size_t max_seeds = Envelope::max_seeds, max_corners = 2 * max_seeds + 2;
    // At weights (u, v) of the second and third vertex the value of a seed is f + u du + v dv. The function of an edge
    // is 0 along it.
    struct Function {
        double f, du, dv;
        double error;  // bound, of each
        double seed;   // 1 for a seed, 0 for an edge
        std::uint32_t number = none;
    };
    // A side at a corner has a number: 4 times the corner, and k if it lies between the other two sites than site k.
    struct Corner {
        std::array<Site, 4> site;           // three, around the corner as the triangle turns
        std::array<std::uint32_t, 4> twin;  // of side k: its number at the corner where it ends
    };
    // Returns the side of a corner that follows another.
    [[nodiscard]] static std::uint32_t turn(std::uint32_t side) { return side + ((side & 3) == 2 ? -2U : 1U); }
    // Returns the side that follows another along the cell of site k + 2.
    [[nodiscard]] std::uint32_t follow(std::uint32_t side) const {
        return turn(turn(corners_[side >> 2].twin[side & 3]));
    }
    static constexpr std::uint32_t outside = Envelope::room & ~std::uint32_t{group - 1};  // stands for no corner
    [[nodiscard]] bool is_removed(std::uint32_t corner) const {
        return (marks_[corner / group] >> (corner % group) & 1) != 0;
    }
    void add_group(std::uint32_t first);
    void begin(std::size_t k, std::uint32_t number);
    void add(std::size_t k, std::uint32_t number);
    [[nodiscard]] std::uint32_t find_border() const;
    void join(const Function& own, Site site);
    void set_row(std::size_t i, const Function& own, const Function& other);
    void remove_rest(std::size_t used);
    void clear_corners(std::size_t from, std::size_t end);
    void find_reach();
    [[nodiscard]] bool is_beyond_balls(const Box& box) const;
    void settle(std::int32_t triangle, ClippedTriangle& exact);

    const Surface& surface_;
    const SurfaceKernels& kernels_;
    std::array<exact::Point, 3> vertex_{};
    TriangleFrame frame_{};
    SeedFunctions group_{};
    std::array<Function, max_seeds + edges> functions_;  // by site
    Site end_ = edges;                                   // of the sites
    Envelope envelope_{};
    std::array<Corner, outside + 1> corners_;
    std::array<std::uint8_t, outside / group + 1> marks_{};  // bits of corners that a seed removes
    std::array<std::uint32_t, max_corners> removed_;
    std::size_t removed_count_ = 0;
    Ring ring_{};
    std::array<Site, Ring::room> ring_sites_;
    std::array<std::uint32_t, Ring::room> beyond_;  // by corner of the ring: the side that leads to it from outside
    std::array<std::uint32_t, Ring::room> made_;    // the same corners
    bool is_sure_ = true;
    std::uint32_t hint_ = none;  // a seed of the last triangle
    // Parts: the site, and a side along its cell.
    std::array<std::pair<Site, std::uint32_t>, max_seeds> parts_;
    std::size_t part_count_ = 0;
    std::array<std::uint32_t, max_seeds + edges> side_of_site_;

    std::uint32_t number_ = 0;
    std::size_t size_ = 0;
    std::array<Side, max_seeds + edges> sides_;
    std::array<std::array<double, 2>, max_seeds + edges> weights_;
    std::array<Vector3, 3> relative_{};
};

}  // namespace votess::surface
