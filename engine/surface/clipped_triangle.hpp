// One triangle, clipped to one cell.
//
// The part is a convex polygon. A list of its sides describes it: edges of the triangle, and bisectors. Clipping it by
// a bisector needs the side of each corner. The place of the corner decides it where its error is small enough, else
// MeshSigns does. Ranks decide ties: see mesh_signs.hpp. So the parts are those of a power diagram in general position,
// and tile the triangle.
//
// A seed cuts the part only if a corner is nearer to it. So seeds are tried in the order of their distance, until the
// balls around all corners that touch the seed are searched. Their places need only be good enough for that.
//
// Places of corners are weights of the triangle's vertices, in double with a bound on the error. Where it exceeds
// `weight_rounding`, or that of the place `place_rounding`, weights are rounded from exact quotients.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"
#include "solid/mesh_signs.hpp"
#include "surface/surface.hpp"

namespace votess::surface {

// A seed beyond a bisector; or -1, -2, -3 for the triangle's edges, -1 - i from its corner i.
using Side = std::int32_t;

[[nodiscard]] inline std::size_t corner_of(Side edge) {
    return at(-1 - edge);
}

class ClippedTriangle {
public:
    ClippedTriangle(const Surface& surface, const NearSeeds& near)
        : surface_(surface), tree_(surface.tree()), near_(near) {}

    void set_triangle(std::int32_t triangle);
    // Clips it to the cell of a seed, which has a number in the tree. Returns whether there is a part.
    bool clip(std::uint32_t number);

    [[nodiscard]] std::int32_t seed() const { return seed_; }
    // Sides of the part: side i leads from corner i.
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] Side side(std::size_t i) const {
        const Side side = polygon_[i].out;
        return side < 0 ? side : bisectors_[at(side)].seed;
    }
    // The number of the seed beyond a bisector, or none for an edge.
    static constexpr std::uint32_t none = 0xffffffff;
    [[nodiscard]] std::uint32_t beyond(std::size_t i) const {
        const Side side = polygon_[i].out;
        return side < 0 ? none : bisectors_[at(side)].number;
    }
    // Rounds the places of corners well enough.
    void settle();
    // Returns whether bounds on the errors of weights are small enough, at a distance from the seed.
    [[nodiscard]] static bool is_accurate(double weight_error, double longest, double distance) {
        return weight_error <= weight_rounding && weight_error * longest <= place_rounding * (longest + distance);
    }
    // Returns the weights of the second and third vertex, rounded well enough, where a cell has a corner between two
    // sides. Sides are edges, or numbers of seeds.
    [[nodiscard]] std::array<double, 2> corner(std::uint32_t number, Side in, Side out);
    // Weights of the second and third vertex at corner i.
    [[nodiscard]] const std::array<double, 2>& weights(std::size_t i) const { return polygon_[i].weights; }
    // Its place relative to the seed.
    [[nodiscard]] const Vector3& place(std::size_t i) const { return polygon_[i].x; }
    // Finds which sides have no length, and whether the part has no area.
    void find_ties();
    [[nodiscard]] bool has_length(std::size_t i) const { return lengthless_.empty() || lengthless_[i] == 0; }
    [[nodiscard]] bool has_area() const { return has_area_; }

private:
    static constexpr double place_rounding = 0x1p-41;  // of the size of the triangle and the distance of its seed
    static constexpr double weight_rounding = 0x1p-36;
    struct Corner {
        Side out;                       // the side from it: a bisector's number here, or an edge
        Vector3 x;                      // relative to the seed
        double error;                   // bound on the distance
        std::array<double, 2> weights;  // of the second and third vertex
        double weight_error;            // bound, of each
    };
    struct Weights {
        std::array<double, 3> of;  // vertices of the triangle
        double error;              // bound, of each
    };
    struct Bisector {
        std::int32_t seed;  // beyond it
        std::uint32_t number;
        solid::MeshSigns::Values values;  // at the vertices
        double largest, error;            // of these
    };
    [[nodiscard]] bool try_seed(std::uint32_t number, const Vector3& q, double square);
    void set_seed(std::uint32_t number);
    void find_balls();
    [[nodiscard]] double radius_to(double radius, const SeedTree::Node& node) const;
    [[nodiscard]] bool in_reach(const SeedTree::Node& node) const;
    [[nodiscard]] bool search_tree();
    void add_bisector(std::uint32_t number, const Vector3& q, double square);
    void clip_by(Side b);
    void find_radius();
    [[nodiscard]] int sign_at(Side in, Side out, Side b);
    void set_signs(std::initializer_list<Side> bisectors);
    [[nodiscard]] Weights weights(Side in, Side out) const;
    [[nodiscard]] Weights exact_weights(Side in, Side out) const;
    [[nodiscard]] std::array<exact::BigInt, 3> exact_values(std::int32_t id, const exact::BitRange& range) const;
    void set_corner(Corner& corner, Side in, Side out) const;
    void set_weights(Corner& corner, const Weights& weights) const;
    [[nodiscard]] Side before(std::size_t i) const { return polygon_[i == 0 ? size_ - 1 : i - 1].out; }

    const Surface& surface_;
    const SeedTree& tree_;
    const NearSeeds& near_;
    const Surface::Triangle* triangle_ = nullptr;
    double longest_ = 0;  // a bound on the triangle's longest edge
    std::uint32_t number_ = 0;
    std::int32_t seed_ = 0;
    exact::Point origin_{};
    double rounding_ = 0;  // of places in the triangle
    solid::MeshSigns signs_;
    solid::MeshSigns::Places places_;
    std::vector<Bisector> bisectors_;
    std::vector<Corner> polygon_, next_;  // the first size_
    static constexpr std::size_t lanes = 4;
    std::vector<double> lanes_;   // places of so many corners: x, y, z; the first corner fills them up
    std::vector<double> values_;  // of a bisector at the corners
    struct Ball {                 // around a corner, through the seed
        exact::Point center;
        double radius, error;
    };
    std::vector<Ball> balls_;
    double farthest_ = 0;  // largest radius of these
    double reach_ = 0;     // square of the distance up to which seeds may be nearer to their centers
    std::size_t size_ = 0, clips_ = 0;
    double searched_ = 0;            // distance of a corner up to which all seeds were tried that may cut it off
    double radius_ = 0, error_ = 0;  // of corners: the largest distance, with its error, and the largest error
    std::vector<std::uint8_t> lengthless_;
    bool is_tied_ = false, has_area_ = true;
};

}  // namespace votess::surface
