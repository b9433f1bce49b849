// One Voronoi cell: a convex polytope around a seed, clipped plane by plane.
//
// The polytope is simple: every vertex lies on exactly three of its planes, every edge on two. A plane that only
// touches a vertex does not cut it off, as if later planes were pushed outward by an infinitesimal. So vertices may
// coincide. canonical_faces() merges those that are equal in exact arithmetic and drops faces of no area.
//
// Filter. With u = 2^-53 and planes rounded from exact ones (n relative error u, h 5u), Cramer's rule gives a vertex
//     |x - X| <= 62 u |X| |na||nb||nc| / |det(na,nb,nc)|
// (17u per numerator term, |perm| <= 1.16 |na||nb||nc| after Carlen, Lieb, Loss 2006), and the test of plane n, h
//     |n.x - h - exact| <= |n| (|x - X| + 6u |x|) + 12 u h .
// Vertices worse than `worst_condition` are solved exactly and rounded. exact::side_of_vertex decides signs inside the
// bound. A vertex that many bisectors almost touch (seeds near a sphere) is first solved once to 106 bits and tested in
// double-double arithmetic. Where a plane cuts edges in a vertex that it touches, the new vertices coincide with that
// one, and one exact test is that of all: so a cell whose n faces meet in one place takes n such tests, not n^2.
//
// A plane is compared with all vertices of a cell that has few. In a larger cell it climbs along edges to the vertex
// farthest outside, and spreads over those outside from there. So a cell of n faces takes n log n, not n^2, if planes
// come in an order in which successive ones are near each other and earlier ones are everywhere.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "domain/domain.hpp"
#include "exact/double_double.hpp"
#include "exact/predicate.hpp"
#include "polytope/cell_kernels.hpp"
#include "votess/votess.hpp"

namespace votess::cpu {

struct CellPlane {
    std::array<double, 3> n;  // q - p rounded, or the outward normal of a wall
    double h;                 // unit * n.x = h on the plane
    double norm;              // |n|
    std::int32_t id;          // as given to clip(); walls are -1..-6, then -7, -8, ...
    bool reliable;            // h has all its digits, and no product with unit * n underflows
    exact::Plane source;
    exact::Shift shift{};  // of the image q, between positions inside a periodic box
    double unit = 1;       // power of two that brings a very short n to order one
    double h_error = std::numeric_limits<double>::infinity();  // bound on that of h, where it is not reliable
};

// Returns the plane of a bisector or a wall as seen by a seed at p.
CellPlane make_plane(const exact::Point& p, std::int32_t id, const exact::Plane& source,
                     const exact::Shift& shift = {});

// Returns the vector from the seed to its mirror image in a wall; 0 if h is not reliable.
std::array<double, 3> mirror_image(const CellPlane& wall);

struct CellGeometry {
    int exponent = 0;  // as in CellMeasures, and of the centroid too
    double volume = 0;
    std::array<double, 3> centroid{};  // relative to the seed
    double farthest_squared = 0;       // from the seed to a vertex
};

// Faces of the canonical cell. Face f is the polygon of vertex slots corners[offsets[f]..offsets[f+1]),
// counterclockwise seen from outside.
struct CellFaces {
    std::vector<std::int32_t> planes;  // index into Cell::planes()
    std::vector<std::int32_t> offsets;
    std::vector<std::int32_t> corners;
    std::uint32_t vertex_count = 0, edge_count = 0;

    [[nodiscard]] std::size_t size() const { return planes.size(); }
};

// Returns a box as seen from `at`, moved outward by all rounding. rounding: by axis, of the positions.
Box seen_from(const exact::Point& at, const Box& box, const exact::Point& rounding = {});

// How a cell is seen if weights follow a paraboloid (index/lift.hpp): its vertices moved, and the factor of |n|^2.
struct LiftedView {
    std::array<double, 3> move{};
    double shrink = 1;
};

class Cell {
public:
    explicit Cell(const Kernels& kernels = best_kernels());

    // Resets the cell to the box, which contains the seed.
    void start(const exact::Point& seed, const Box& box);
    // Resets the cell to the domain's walls and, along periodic axes, the bisectors with the nearest images of the
    // seed. The seed is `id`.
    void start(const exact::Point& seed, const Domain& domain, std::int32_t id = 0);
    // Does the same without domain.walls. clip_walls() must follow, best when the cell is small.
    void start_without_walls(const exact::Point& seed, const Domain& domain, std::int32_t id);
    // Clips by those of domain.walls that may cut the cell. crowded: called once if these are many; it may clip.
    void clip_walls(const Domain& domain, const std::function<void()>& crowded = {});
    // Clips by the bisector with q, which must differ from the seed. Returns true if the cell changed.
    bool clip(std::int32_t id, const exact::Point& q);
    // Clips by a plane relative to seed(). A bisector with a seed at the same place needs power.
    bool clip(std::int32_t id, const exact::Plane& source, const exact::Shift& shift = {});

    // Returns an upper bound on the squared distance R^2 to the farthest vertex. No seed at 2 R or beyond cuts the
    // cell. The bound of a large cell may be that of some clips ago.
    [[nodiscard]] double radius_squared();
    // Returns a distance at or beyond which no seed cuts the cell, if its rest is larger by at most `more`, 0 or more.
    // view: always the same one after a start.
    [[nodiscard]] double lifted_reach(const LiftedView& view, double more);
    // Returns false only if no seed inside the box (relative to seed()) can cut the cell. more: bound on the excess of
    // their weight over the cell's.
    [[nodiscard]] bool in_reach(const Box& relative, double more = 0) const;
    // Slower, and sharp even if the box is much nearer than the vertices, like the images along the short edge of a
    // thin box, or seeds in a plane. After many calls it solves the vertices exactly. view: `more` is then the excess
    // of rests.
    [[nodiscard]] bool may_cut(const Box& relative, double more, const LiftedView& view = {});
    // Whether planes() includes this bisector, with a face or without.
    [[nodiscard]] bool has_plane(std::int32_t id, const exact::Shift& shift) const;
    // Returns the mean of the vertices.
    [[nodiscard]] std::array<double, 3> middle() const;
    // Makes the cell empty if all vertices lie on one plane of the first, so that it has no volume.
    void drop_if_flat();
    // True if nothing is left: in a power diagram other seeds may be nearer everywhere.
    [[nodiscard]] bool empty() const { return empty_; }

    [[nodiscard]] const exact::Point& seed() const { return seed_; }
    [[nodiscard]] std::span<const CellPlane> planes() const { return planes_; }
    // Slots below this hold vertices, if they are alive.
    [[nodiscard]] int slots() const { return slots_; }
    [[nodiscard]] bool alive(int slot) const { return (alive_[slot / word_slots] >> (slot % word_slots)) & 1; }
    [[nodiscard]] std::array<const CellPlane*, 3> corner_planes(int slot) const {
        const auto& [a, b, c] = corners_[slot].plane;
        return {&planes_[a], &planes_[b], &planes_[c]};
    }
    [[nodiscard]] std::array<double, 3> position(int slot) const { return {x_[slot], y_[slot], z_[slot]}; }
    // Returns a bound on the error of each coordinate of position().
    [[nodiscard]] double tolerance(int slot) const { return tolerance_[slot]; }
    [[nodiscard]] bool used_exact() const { return used_exact_; }
    // Whether a plane touched a vertex, so that faces of no area may remain.
    [[nodiscard]] bool met_tie() const { return met_tie_; }

    // Lists the planes that have a face. After a tie some of them may have no area.
    void face_planes(std::vector<std::int32_t>& out);
    void canonical_faces(CellFaces& out);
    // areas: if not null, receives the areas of the faces, each to an absolute error of 1e-10 of their sum.
    [[nodiscard]] CellGeometry measure(const CellFaces& faces, std::vector<double>* areas = nullptr) const;

private:
    struct Corner {  // a vertex: planes in positive orientation; edge k lies on planes k, k+1 and leads to next[k]
        std::array<std::int32_t, 3> plane;
        std::array<std::int32_t, 3> next;
    };
    struct Refined {  // gains precision with the number of uncertain tests
        int tests = 0;
        bool solved = false, split = false;
        std::array<exact::DoubleDouble, 3> position{};
        std::array<double, 3> at{}, error{};  // by axis, see by_axis()
        std::int32_t place = -1;              // in places_, after a tie
    };
    // Of vertices that coincide: the side of the last plane that was decided exactly.
    struct Place {
        std::uint64_t test;
        int side;
    };
    struct RefinedPlane {
        std::int32_t id;
        exact::Shift shift;
        std::array<exact::DoubleDouble, 3> n;
        exact::DoubleDouble minus_h;
        double size;  // of the terms of minus_h
    };
    bool clip(const CellPlane& plane);
    // Lists the vertices outside a plane in killed_. Returns false if there are none.
    [[nodiscard]] bool scan(const CellPlane& plane, const FilterPlane& filter);
    // Does the same for a large cell, or returns nothing when rounding or a tie hides the answer.
    [[nodiscard]] std::optional<bool> climb(const CellPlane& plane, const FilterPlane& filter);
    void spread(const CellPlane& plane, const FilterPlane& filter);
    [[nodiscard]] int best_of_sample(const FilterPlane& filter, int slot) const;
    [[nodiscard]] bool may_meet(const WallTree& walls, std::size_t node) const;
    [[nodiscard]] bool replace_equal_face(const CellPlane& plane, int slot);
    struct HorizonEdge {
        std::int32_t first, second;  // planes, as ordered in the vertex that is cut off
        std::int32_t survivor;       // vertex slot that stays
    };

    void reserve_slots(int slots);
    [[nodiscard]] VertexBlock block(int word) const;
    [[nodiscard]] int side_exact(int slot, const CellPlane& plane);
    // Returns the position of a vertex with an error by axis. A vertex at the end of a needle is as sharp across it as
    // the needle is thin, however long that is.
    const Refined& by_axis(int slot);
    // Returns the sign of the test by these errors, or 0 if that is uncertain.
    [[nodiscard]] int side_by_axis(int slot, const CellPlane& plane);
    // Returns the sign of the refined test, or 0 if that is uncertain too.
    [[nodiscard]] int refined_side(int slot, const CellPlane& plane);
    int allocate_slot();
    void place_vertex(int slot, std::int32_t a, std::int32_t b, std::int32_t c);
    void sharpen();
    void merge_equal_corners();
    [[nodiscard]] bool same_position(int v, int w, int shared_edge);
    template <class Visit>
    void for_each_alive(Visit visit) const {
        for (int w = 0; w * word_slots < slots_; ++w)
            for (std::uint64_t m = alive_[w]; m != 0; m &= m - 1) visit(w * word_slots + std::countr_zero(m));
    }

    const Kernels& kernels_;
    exact::Point seed_{};
    std::vector<CellPlane> planes_;

    int slots_ = 0;  // slots in use or free are below this
    std::vector<double> storage_;
    double *x_ = nullptr, *y_ = nullptr, *z_ = nullptr, *tolerance_ = nullptr, *radius_ = nullptr;
    int capacity_ = 0;
    std::vector<Corner> corners_;
    std::vector<Refined> refined_;
    RefinedPlane refined_plane_{};  // of the last plane tested
    std::vector<Place> places_;
    std::uint64_t test_ = 0;  // number of the plane that is tested
    std::vector<std::uint64_t> alive_;
    std::vector<std::int32_t> free_;     // slots
    std::vector<std::int32_t> killed_;   // slots outside the current plane
    std::vector<std::uint8_t> visited_;  // by slot: state in spread() and clip()
    std::vector<std::int32_t> spared_;   // slots that spread() found not outside
    std::vector<std::uint32_t> wall_queue_;
    std::int32_t last_ = 0;  // a vertex of the last cut

    std::vector<HorizonEdge> horizon_;
    std::vector<std::int32_t> ring_;    // plane -> new vertex that has it first
    std::vector<std::int32_t> merged_;  // slot -> representative of equal vertices
    std::vector<std::int32_t> start_;   // plane -> some vertex on it, or -1
    bool radius_known_ = false, moved_radius_known_ = false, used_exact_ = false, met_tie_ = false, empty_ = false;
    double radius_squared_ = 0, moved_radius_ = 0;
    int requests_ = 0;    // of the radius since it was known
    int passed_ = 0;      // boxes that may_cut() did not exclude
    bool sharp_ = false;  // vertices are rounded from exact ones
};

}  // namespace votess::cpu
