// What cells share is proven once: a corner by the lowest of its seeds, an edge of the diagram by the lowest of its
// three. Polygons say which corners are the same.
//
// A cell is simple if its polygons close with three faces at each corner (RowPolytope::close_polygons()). Suppose all
// cells are, and
//   A. in each cell exactly one corner is on top in some direction e: e lies in the cone of its three normals. All
//      others certainly are not;
//   B. the sums of names() over all cells are 0. A corner is named by its vertex, its seeds and walls up to a shift,
//      and the turn of these. Of k cells, the one whose seed is the j-th adds the j-th of k random factors times that
//      name, which sum to 0. So if one cell has a corner of that name, all have it, equally often;
//   C. the lowest of the seeds has the normals of the corner turn as its polygons do: their determinant is positive;
//   D. an edge joins two corners that have two planes in common. The lowest of its seeds has one of these corners
//      inside of the third plane of the other;
//   E. a corner on a wall lies inside of all other walls, not on them;
//   F. where vertices have images, the lowest of the seeds names an original. A cell that sees this seed without a
//      shift may name it too: the corner is the same. An image that a cell names is compared with its corner.
// Then each cell is the polytope of its planes and of all walls, with these corners. Proof. The determinant of C has
// the same sign in all cells of a corner, by its turn. Consider the normals of a cell as points of a sphere. The
// corners are triangles there, which turn the right way and meet along their sides, as polygons close. So they cover
// each place the same number of times, which is 1 by A, and no polygon winds twice: the triangles triangulate the
// sphere. So two faces meet in at most one edge, and two corners at most have a pair of planes in common. By B the
// lowest of the three cells around an edge joins the same two corners, and D holds in all of them: edges have positive
// lengths. Follow edges from a corner while n of some face rises. This ends where no edge rises, where n lies in the
// closed cone of the normals: in that face. So all corners lie inside of the plane, and those of other faces strictly.
// A corner where three planes meet inside of all others is one of the polytope. The edges join them, which leaves no
// other. The cells around a corner without walls fill its surroundings. So the farthest place in the direction of a
// wall that any cell reaches is a corner on a wall, and by E cells do not leave the domain. B is condition 2 of
// certificate.hpp.
//
// In a domain that is periodic along all axes, condition 3 there is that volume() is that of the domain. The cells
// cover each place of it c times. Moved along straight lines, this covering becomes that by the tetrahedra of the seeds
// of all corners, which keeps c. Their volumes are the determinants of C, of which each is wrong by less than a tenth.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/scrambled.hpp"
#include "verify/row_polytope.hpp"

namespace votess {

// Odd numbers without a pattern, which make sums of different terms differ.
inline constexpr std::uint64_t factor_a = 0x8ebc6af09c88c6e3, factor_b = 0x589965cc75374cc3,
                               factor_c = 0x1d8e4e27c47d124f, factor_d = 0xd6e8feb86659fd93,
                               factor_e = 0xa0761d6478bd642f, factor_f = 0xe7037ed1a0b428db;

inline std::uint64_t random_of(std::int32_t id) {
    return scrambled(0x243f6a8885a308d3 + static_cast<std::uint32_t>(id));
}

// A normal of length 1 seen along a direction e: its components at right angles to e. The sign of det(e, f, g) is that
// of the turn from f to g about e.
struct SeenNormal {
    double across = 0, along = 0;
};
// direction: 0 or 1, two vectors each, at right angles to which is e. They need not be orthogonal: any linear map keeps
// or turns all signs. Nothing lies along them in a common lattice.
[[nodiscard]] inline SeenNormal seen_along(const PlaneArrays& p, std::size_t f, std::size_t direction) {
    constexpr std::array<Vector3, 4> vectors{Vector3{0.3651483716701107, -0.8164965809277260, 0.4472135954999579},
                                             Vector3{0.8428282480371107, 0.4985132179123381, 0.2030197431285120},
                                             Vector3{-0.7129384012837465, 0.2918374650192837, 0.6374829103847561},
                                             Vector3{0.2219384756102938, 0.9411029384756102, -0.2549182736450192}};
    const Vector3 &first = vectors[2 * direction], &second = vectors[2 * direction + 1];
    const double inverse = p.inverse[f];
    return {(p.nx[f] * first[0] + p.ny[f] * first[1] + p.nz[f] * first[2]) * inverse,
            (p.nx[f] * second[0] + p.ny[f] * second[1] + p.nz[f] * second[2]) * inverse};
}
// Whether a corner of three planes is on top, A below: 1 if certainly, 0 if certainly not, else 2. Bounds as in
// row_polytope.hpp.
[[nodiscard]] inline int top_of(const SeenNormal& a, const SeenNormal& b, const SeenNormal& c) {
    const double ab = a.across * b.along - a.along * b.across, bc = b.across * c.along - b.along * c.across,
                 ca = c.across * a.along - c.along * a.across, low = ab < bc ? ab : bc, least = low < ca ? low : ca;
    return 2 - 2 * static_cast<int>(least < -filter_bound) - static_cast<int>(least > filter_bound);
}

class SharedCorners {
public:
    // images: of vertices; empty if these have none.
    SharedCorners(const SeedPlanes& planes, std::span<const std::int32_t> images) : planes_(planes), images_(images) {}

    // Checks A and C to F of a cell whose polygons are closed, and adds to the sums. Returns false where one does not
    // hold or is not certain.
    [[nodiscard]] bool add(RowPolytope& polytope, std::size_t seed);
    // The corners whose places must be compared in the last cell: each vertex is among those of some cell.
    [[nodiscard]] std::span<const int> to_compare() const { return to_compare_; }
    // Whether the last cell has the place of a corner.
    [[nodiscard]] bool has_place(int corner) const { return placed_[static_cast<std::size_t>(corner)] != 0; }
    [[nodiscard]] std::uint64_t names() const { return names_; }
    [[nodiscard]] double volume() const { return volume_; }

private:
    struct Side : SeenNormal {  // of a plane
        std::uint64_t random = 0;
        std::uint32_t code = 0;  // 4 for a seed, and 1 for one before that of the cell
        // Of two planes, each edge is taken where that on its left is lower. None is less with a seed before the
        // cell's.
        std::int32_t as_left = 0, as_right = 0;
        std::uint64_t shift = 0, products = 0, squares = 0;
    };
    void look_along(const RowPolytope& polytope, std::size_t direction);
    [[nodiscard]] bool has_one_top(const RowPolytope& polytope);
    void name_sides(const RowPolytope& polytope, std::size_t seed);
    [[nodiscard]] bool has_first_in_place(const RowPolytope& polytope, std::array<int, 3> planes) const;
    template <bool with_images>
    [[nodiscard]] bool add_names(const RowPolytope& polytope, std::size_t seed);
    [[nodiscard]] bool check_edges(RowPolytope& polytope);
    [[nodiscard]] bool is_within_walls(const RowPolytope& polytope, std::size_t seed, int corner);

    const SeedPlanes& planes_;
    std::span<const std::int32_t> images_;
    std::vector<Side> sides_;
    std::vector<int> first_;            // corners of which the cell's seed is the lowest
    std::vector<int> edges_;            // likewise: four times the corner where it starts, and the place in its fan
    std::vector<std::uint8_t> placed_;  // by corner: whether the polytope has its place
    struct Wall {
        std::int32_t id;
        RoundedPlane plane;
    };
    std::vector<Wall> walls_;  // of the seed walls_of_
    std::size_t walls_of_ = static_cast<std::size_t>(-1);
    std::vector<int> to_compare_;
    std::uint64_t names_ = 0;
    double volume_ = 0;
};

}  // namespace votess
