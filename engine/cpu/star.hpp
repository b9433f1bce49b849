// The star of a seed: the vertices, edges and faces of its Voronoi cell, found by walking along its edges.
//
// From a vertex on planes a, b, c an edge runs along a and b; its other end is where the first of all other bisectors
// meets it (gift wrapping, Chand and Kapur, J. ACM 17(1), 1970, in the dual). Which plane that is may be guessed in any
// precision, because every vertex is proven afterwards: it must lie strictly inside all other planes, with a margin
// larger than all rounding, or exact arithmetic decides; and all seeds within twice its distance (the security radius)
// must have been looked at. A closed surface of proven vertices is the cell.
//
// A neighbor that is done has handed over every vertex of their common face (Neighborhood), so an edge that is still
// open lies on no plane of a done seed, and the other end of it neither: done seeds need not be looked at again.
//
// Margin. With e = 2^-24, planes N rounded to floats from integers that are exact to q = 1.8 units, H = |N|^2/2, and a
// vertex X known to 62 u cond |X| < 0.2 e |X| (cond <= worst_condition), rounding changes H - N.X by at most
//     e (6.3 |N||X| + 9 H) + q (|X| + |N|),
// whether or not the compiler's target fuses a*b+c.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "cpu/hierarchy.hpp"
#include "cpu/neighborhood.hpp"
#include "cpu/star_kernels.hpp"
#include "cpu/window.hpp"
#include "exact/predicate.hpp"
#include "votess/votess.hpp"

namespace votess::cpu {

class Star {
public:
    static constexpr int most_planes = 64;
    static constexpr int most_vertices = 2 * most_planes;

    Star(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Box& box, const StarKernels& kernels);

    // Begins a stretch of seeds, aligned to groups but at the end; build() is then called for its seeds in order.
    void begin(std::size_t first, std::size_t last, bool measure);
    // False when the cell is beyond what this class handles: the caller clips it.
    bool build(std::size_t seed);

    // Of the last cell built. Faces in no particular order: sorted seeds, or walls -1..-6.
    [[nodiscard]] std::span<const std::int32_t> faces() const {
        return {id_.data(), static_cast<std::size_t>(planes_)};
    }
    [[nodiscard]] int vertex_count() const { return vertices_; }
    [[nodiscard]] int edge_count() const { return vertices_ / 2 * 3; }
    [[nodiscard]] bool used_exact() const { return used_exact_; }

    struct Geometry {
        double volume = 0;
        std::array<double, 3> centroid{};  // relative to the seed
        std::array<double, most_planes> areas{};
    };
    // After begin(.., measure = true). False when rounding might spoil the digits promised.
    bool measure(Geometry& out);

private:
    using Vector = std::array<double, 3>;
    struct OpenEdge {
        int a, b;       // slots of its planes
        Vector ab;      // n_a x n_b
        double norms2;  // |n_a|^2 |n_b|^2
    };
    struct Third {  // the plane that ends an edge
        Vector n;
        double h;
        double norms2, determinant2;  // |na|^2 |nb|^2 |nc|^2 and det(na, nb, nc)^2
        [[nodiscard]] double condition() const { return std::sqrt(norms2 / determinant2); }
    };
    struct Solved {
        Vector x;
        double condition;  // |na||nb||nc| / |det|
    };
    // Bit b of links[a].out: a corner of face a has the edge a -> b; the corner at its other end has b -> a and sets
    // bit b of links[a].in.
    struct Links {
        std::uint64_t out, in;
    };

    bool complete(std::size_t seed);
    bool take_known(std::size_t seed);
    bool gather_candidates(std::size_t seed);
    bool begin_anywhere();
    // The way along an open edge, out of the face corners known.
    bool aim(int a, int b, OpenEdge& edge, Ray& ray);
    [[nodiscard]] int first_hit(const Ray& ray) const;
    // Finds the vertex at the other end; `hit` is where to begin.
    bool close(const OpenEdge& edge, const Ray& ray, int hit);
    bool add_vertex(const OpenEdge& edge, std::int32_t id, const Third& third, const Vector& x);
    bool solve(const OpenEdge& edge, Third& third, Vector& x) const;
    int cutting_plane(const Solved& vertex, const float* v, float rounding, const std::int32_t* three, int lane);
    // As exact::side_of_vertex, of the plane with seed or wall id; the vertex solves those of `three`.
    int side_of(const Solved& vertex, const std::int32_t* three, std::int32_t id);
    bool add_candidate(std::int32_t id);
    [[nodiscard]] bool is_extra(std::int32_t id) const;
    bool add_walls();
    bool add_inside(const OpenEdge& edge, Vector x, const std::int32_t* three, int& added);

    [[gnu::always_inline]] inline int slot_of(std::int32_t local, int& planes);
    [[gnu::always_inline]] inline void need_plane(int slot);
    void need_all_planes();
    [[gnu::always_inline]] inline void plane_through(std::int32_t id, Vector& n, double& h) const;
    [[nodiscard]] exact::Plane exact_plane(std::int32_t id) const;
    [[gnu::always_inline]] inline void link_corner(int a, int b, int c, int vertex);
    [[nodiscard]] std::uint64_t open(int a) const { return links_[a].out & ~links_[a].in; }
    [[nodiscard]] float rounding_of(double x2) const;

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const Box box_;
    const StarKernels& kernels_;
    Neighborhood cells_;
    Window window_;
    std::size_t window_group_ = ~std::size_t{0};
    bool window_open_ = false;
    bool measure_ = false;
    double typical_reach_ = 0;  // squared security radius that vertices of late needed

    std::size_t seed_ = 0;
    exact::Point p_{};
    bool have_candidates_ = false;
    std::int32_t own_x_ = 0;
    bool have_walls_ = false;
    CandidatePlanes candidates_;
    double covered_ = 0;  // squared distance within which all seeds not done are candidates
    int extras_ = 0;      // candidates from here on are no seeds of the window
    double reached_ = 0;  // largest squared security radius of the vertices found
    double scale_ = 1;    // planes and vertices times this: window units, or 1 without a window
    double longest_ = 0;  // at least the length of the longest candidate normal, in window units
    double inverse_longest_ = 0;
    bool used_exact_ = false;

    int planes_ = 0, vertices_ = 0;
    std::uint64_t planes_known_ = 0;  // bit: id_, n_, h_ are set
    std::array<std::int32_t, most_planes> local_{}, id_{};
    std::array<Vector, most_planes> n_{};
    std::array<double, most_planes> h_{};
    std::array<Links, most_planes> links_{};
    std::uint64_t active_ = 0;                        // planes with open edges
    std::vector<std::uint32_t> slot_;                 // by local id: epoch * most_planes + slot
    std::uint32_t epoch_ = 0;

    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::vector<Node> nodes_;
    // For measure().
    std::array<Vector, most_vertices> position_{};
    std::array<double, most_vertices> error_{};
    std::array<std::array<std::uint8_t, most_planes>, most_planes> from_vertex_{};  // corner with edge a -> b
};

}  // namespace votess::cpu
