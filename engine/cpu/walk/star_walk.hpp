// The walk of star.hpp. Vectors have four lanes, of which the last is free.
#pragma once

#include "cpu/walk/star_context.hpp"

namespace votess::cpu {

// Isa only tells the copies apart: each is compiled for another instruction set by the file that includes this one.
template <class Isa>
class StarWalk final : public Star {
public:
    StarWalk(const SortedSeeds& seeds, const Hierarchy& hierarchy, const StarKernels& kernels)
        : seeds_(seeds), hierarchy_(hierarchy), kernels_(kernels), window_(seeds, hierarchy, kernels) {
        static_assert(alignment % Window::home_seeds == 0);
    }

    void begin_job(const Domain& domain) override {
        domain_ = &domain;
        box_ = domain.box;
    }
    void begin(std::size_t first, std::size_t last, bool measure) override;
    bool build(std::size_t seed) override;
    bool measure(Geometry& out) override;
    void polygons(CellPolygons& out) const override;
    double farthest_squared() const override;
    void normals(std::vector<std::array<double, 3>>& out) override;

private:
    static constexpr double unit = 0x1p-53;
    static constexpr double float_unit = 0x1p-24;
    static constexpr double quantum = 2;                // of window integers: more than q in star.hpp
    static constexpr double worst_condition2 = 1e12;    // (|na||nb||nc| / det)^2
    static constexpr double margin = 2e-8;              // more than the relative error of a vertex that is accepted
    static constexpr double solved_factor = 80 * unit;  // Cell's 62 u, and 13 u for normals that are rounded twice
    static constexpr double smallest_h = 1e-90, largest_h = 1e90;  // no square of a product leaves the range
    static constexpr double longest_normal = 1e12;                 // in window units: products of three stay floats
    static constexpr double reach_margin = 1.9;                    // of the squared security radius that is typical
    static constexpr int most_candidates = 160;                    // at first; room for others is left
    static constexpr double least_image_vertex2 = 0x1p36;          // of squared window units, where images are rounded
    static constexpr int most_picks = 64;                          // planes tried for one vertex
    static constexpr double ray_scale = 0x1p-112;                  // (2^28 units)^-4
    static constexpr float parallel = 0x1p-18f;                    // rays nearly along a plane do not leave it
    static constexpr int most_new = 24;                            // seeds taken at once from beyond the window
    static constexpr int most_ties = 64;
    static constexpr std::uint16_t no_slot = 255;

    // Attributes stand behind the name: elsewhere Clang does not see a lesser alignment.
    using Wide __attribute__((vector_size(32), aligned(8), may_alias)) = double;
    static_assert(alignof(Wide) == 8);

    // By reference, for processors without such registers.
    [[gnu::always_inline]] static const Wide& wide(const Four& four) { return reinterpret_cast<const Wide&>(four); }
    [[gnu::always_inline]] static Wide& wide(Four& four) { return reinterpret_cast<Wide&>(four); }
    [[gnu::always_inline]] static double dot(const Wide& a, const Wide& b) {
        const Wide ab = a * b;
        return ab[0] + ab[1] + ab[2];
    }
    // y, z, x of an x, y, z; the last lane stays.
    [[gnu::always_inline]] static void turn(const Wide& a, Wide& out) {
        out = __builtin_shufflevector(a, a, 1, 2, 0, 3);
    }
    [[gnu::always_inline]] static void turn_twice(const Wide& a, Wide& out) {
        out = __builtin_shufflevector(a, a, 2, 0, 1, 3);
    }
    [[gnu::always_inline]] static void cross(const Wide& a, const Wide& b, Wide& out) {
        Wide turned_a, turned_b;
        turn(a, turned_a);
        turn(b, turned_b);
        turn(a * turned_b - turned_a * b, out);
    }

    [[gnu::always_inline]] static void narrow(const Wide& w, float* out) {
        using Floats __attribute__((vector_size(16), aligned(4), may_alias)) = float;
        static_assert(alignof(Floats) == 4);
        *reinterpret_cast<Floats*>(out) = __builtin_convertvector(w, Floats);
    }

    struct alignas(32) OpenEdge {
        Four ab;        // n_a x n_b
        Four e;         // h_a n_b - h_b n_a
        double norms2;  // |n_a|^2 |n_b|^2
        int a, b;       // slots of its planes
    };
    struct alignas(32) Third {  // the plane that ends an edge
        Four n;
        double h;
        double norms2, determinant2;  // |na|^2 |nb|^2 |nc|^2 and det(na, nb, nc)^2
        [[nodiscard]] double condition() const { return std::sqrt(norms2 / determinant2); }
    };

    // star_edges.hpp
    bool complete();
    bool take_known();
    bool take_tie(const KnownVertex& known);
    bool collect_faces();
    bool aim(int a, int b, OpenEdge& edge, Ray& ray);
    [[nodiscard]] int first_hit(const Ray& ray) const;
    [[nodiscard]] bool solve(const OpenEdge& edge, Third& third, Four& x) const;
    // Finds the vertex at the other end of an edge; `lane` is the candidate to begin with, or -1.
    bool close(const OpenEdge& edge, const Ray& ray, int lane);
    int examine(const float* v, const std::int32_t* three, const Third& third, const Four& x, int lane);
    void keep_position(const Third& third, const Four& x);
    bool add_vertex(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x);
    bool add_tie(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x);
    bool link_polygon(std::span<const std::int32_t> cells, int vertex);
    [[gnu::always_inline]] inline int slot_of(std::int32_t local, int& planes);
    [[gnu::always_inline]] inline void link_corner(int a, int b, int c, int vertex);
    [[gnu::always_inline]] inline void need_plane(int slot);
    [[gnu::always_inline]] inline void plane_through(std::int32_t id, Four& n, double& h) const;
    [[nodiscard]] exact::Plane exact_plane(std::int32_t id) const;
    [[nodiscard]] float rounding_of(double x2) const;
    [[nodiscard]] bool images_known(double x2) const;
    [[nodiscard]] std::uint64_t open(int a) const { return out_[a] & ~in_[a]; }
    void update_active(int slot) {
        active_ = (active_ & ~(1ull << slot)) | static_cast<std::uint64_t>(open(slot) != 0) << slot;
    }
    void make_room(std::int32_t locals) {
        if (slot_.size() < static_cast<std::size_t>(locals) + most_planes)
            slot_.resize(2 * static_cast<std::size_t>(locals) + most_planes, no_slot);
    }
    int new_slot(std::int32_t id) {
        const std::int32_t local = cells_.local(id);
        make_room(local);
        return slot_of(local, planes_);
    }

    // star_candidates.hpp
    bool gather_candidates();
    bool begin_anywhere();
    bool add_candidate(std::int32_t id);
    bool add_walls();
    [[nodiscard]] bool near_cell_wall() const;
    [[nodiscard]] bool is_extra(std::int32_t id) const;
    bool add_inside(const OpenEdge& edge, Four x, const std::int32_t* three, int& added);

    // star_geometry.hpp
    [[nodiscard]] double measure_error() const;

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const Domain* domain_ = nullptr;
    Box box_;
    bool any_rough_ = false;   // images, see SeedImages
    double known_reach2_ = 0;  // squared distance within which all images of seeds are there
    const StarKernels& kernels_;
    Neighborhood cells_;
    Window window_;
    std::size_t window_home_ = ~std::size_t{0};
    bool window_open_ = false, measure_ = false;
    double typical_reach_ = 0;  // squared security radius that vertices of late needed

    std::size_t seed_ = 0;
    std::int32_t own_local_ = 0;
    exact::Point p_{};
    bool have_candidates_ = false, have_walls_ = false;
    std::int32_t own_x_ = 0;  // in the window
    CandidatePlanes candidates_;
    int extras_ = 0;      // candidates from here on are no seeds of the window
    double covered_ = 0;  // squared distance within which all seeds not done are candidates
    double longest_ = 0;  // at least the length of the longest candidate normal
    double inverse_longest_ = 0;
    double reached_ = 0;              // largest squared security radius of the vertices found
    double scale_ = 1, unscale_ = 1;  // planes and vertices times this: window units, or 1 without a window

    // The planes of the cell by slot. Bit b of out_[a]: some vertex of face a has the edge a -> b; the vertex at its
    // other end has b -> a, and sets bit b of in_[a].
    std::array<std::uint64_t, most_planes> out_{}, in_{};
    std::uint64_t active_ = 0;        // planes with open edges
    std::uint64_t planes_known_ = 0;  // planes with n_, h_, id_
    int ends_ = 0;                    // edges, counted at either end
    std::array<std::int32_t, most_planes> local_{}, id_{};
    int planes_ = 0;
    alignas(64) std::array<Four, most_planes> n_{};
    std::array<double, most_planes> h_{};
    std::vector<std::uint16_t> slot_;  // by local id

    std::vector<std::int32_t> tied_;  // ids of the planes that go through the vertex examined
    std::vector<std::int32_t> tied_cells_;
    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::vector<Node> nodes_;

    // For measure(): vertex v has the planes corners_[first_corner_[v]..first_corner_[v + 1]), counterclockwise.
    alignas(64) std::array<Four, most_vertices> position_{};
    std::array<std::uint16_t, most_vertices + 1> first_corner_{};
    std::array<std::uint8_t, 4 * most_vertices + most_ties> corners_{};
    std::array<std::array<std::uint8_t, most_planes>, most_planes> from_vertex_{};  // vertex that has the edge a -> b
};

}  // namespace votess::cpu

#include "cpu/walk/star_candidates.inl"
#include "cpu/walk/star_edges.inl"
#include "cpu/walk/star_geometry.inl"
