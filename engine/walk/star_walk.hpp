// The walk of star.hpp. Vectors have four lanes; the last is free.
#pragma once

#include "walk/star_context.hpp"

namespace votess::cpu {

// Isa: the functions of StarKernels in one instruction set, for which the including file compiles the rest too.
template <class Isa>
class StarWalk final : public Star, private ExactCorners {
public:
    StarWalk(const SortedSeeds& seeds, const Hierarchy& hierarchy)
        : seeds_(seeds), hierarchy_(hierarchy), window_(seeds, hierarchy, kernels_of<Isa>) {
        static_assert(alignment % Window::home_seeds == 0);
    }

    void begin_job(const Domain& domain) override;
    void begin(std::size_t first, std::size_t last, Keep keep) override;
    bool build(std::size_t seed) override;
    void begin_probes(std::size_t group, Keep keep) override;
    void look_around(const Box& box, double lightest) override;
    bool build(const Probe& probe) override;
    [[nodiscard]] double typical_reach() const override { return std::sqrt(typical_reach_); }
    CellShape* shape(std::span<const std::uint32_t> ranks) override;
    [[nodiscard]] bool knows_vertices() const override;
    void polygons(std::span<const std::uint32_t> ranks, CellPolygons& out) const override;
    void normals(std::vector<std::array<double, 3>>& out) override;

private:
    static constexpr double unit = bounds::unit, margin = bounds::margin, quantum = bounds::quantum;
    static constexpr double worst_condition2 = bounds::worst_condition * bounds::worst_condition;
    static constexpr double smallest_square = 1e-90, largest_product = 1e90;  // no square of a product leaves the range
    static constexpr double longest_normal = 1e12;    // in window units: products of three stay floats
    static constexpr double longest_of_window = 3.5;  // the same, in extents of the window: its diagonal
    // The squared reach is a multiple of the typical squared security radius. It grows where vertices often lie a
    // little beyond, because a search costs more time than candidates.
    static constexpr double min_reach_margin = 1.7, max_reach_margin = 2.8, margin_step = 0.002,
                            max_weighted_margin = 4;  // cells may be long
    static constexpr double missed_share = 2.5;       // of the squared reach: a little beyond
    static constexpr double far_share = 16;           // of the squared reach: far beyond
    static constexpr double allowed_misses = 0.35;    // searches for a cell
    // The share of the reach, the bend of the weights, and how much longer cells are. Less is not worth the tests.
    static constexpr double min_turned = 0.15, min_steepest = 0.5, min_stretch = 2.5;
    static constexpr double max_stretch = 128;
    static constexpr int max_candidates = 160;  // at first
    // With weights a vertex beyond the candidates costs more time. Where heavy seeds are too many for a window, more
    // candidates spare no searches.
    static constexpr int max_weighted_candidates = 300, max_crowded_candidates = 220;
    static constexpr double shrink = 0.5, weighted_shrink = 0.7;  // of the squared reach where they are too many
    static constexpr int max_shrinks = 8, max_weighted_shrinks = 16;
    static constexpr int enough_candidates = 80;
    // More candidates leave too little room for a search.
    static constexpr int crowded = CandidatePlanes::capacity - 64;
    static constexpr double near_share = 0.6;         // of the squared reach
    static constexpr double closest_moved = 0x1p-40;  // of the largest coordinate: nearer seeds may cancel
    static constexpr int max_picks = 256;             // planes tried for one vertex
    static constexpr int max_starts = 8;
    static constexpr int max_owners = 64;        // of places of a cell beside its seed
    static constexpr int max_done_groups = 256;  // whose done seeds are tested for a place
    static constexpr float parallel = 0x1p-18f;  // a ray that is nearly parallel to a plane does not leave it
    static constexpr int max_new_seeds = 24;     // seeds added at once from beyond the window
    static constexpr int max_ties = 64;
    static constexpr int lane_step = 8;  // planes are read by so many at once
    static constexpr std::uint32_t no_group = ~0u;
    static constexpr int max_batch = 8;  // blocks tested at once
    static constexpr int max_found = max_batch * box_fan;
    static constexpr std::uint16_t no_slot = std::numeric_limits<std::uint16_t>::max();  // above all slots
    static constexpr std::int32_t no_plane = std::numeric_limits<std::int32_t>::min();

    // Aligned as the compiler expects: Clang forgets a smaller alignment in parameters of templates.
    using Wide __attribute__((vector_size(32), may_alias)) = double;
    static_assert(sizeof(Wide) == sizeof(Four) && sizeof(Wide) <= alignof(Four));

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
    [[gnu::always_inline]] static void cross(const Wide& a, const Wide& b, Wide& out) {
        Wide turned_a, turned_b;
        turn(a, turned_a);
        turn(b, turned_b);
        turn(a * turned_b - turned_a * b, out);
    }

    using Floats __attribute__((vector_size(16))) = float;

    [[gnu::always_inline]] static void narrow(const Wide& w, float (&out)[4]) {
        const Floats v = __builtin_convertvector(w, Floats);
        std::memcpy(&out, &v, sizeof v);
    }

    // An edge on two planes, by their slots, with one known end: the vertex that has a -> b.
    struct OpenEdge {
        std::uint8_t a, b;
    };
    struct alignas(32) Line {  // of an edge
        Four ab;               // n_a x n_b
        Four e;                // h_a n_b - h_b n_a
        double square;         // |ab|^2
        double norms2;         // |n_a|^2 |n_b|^2
        double longest2;       // the larger of the two
    };
    struct Ball {  // around a vertex: a seed may cut it off if it is nearer than sqrt(radius^2 + excess) + off
        Box center;
        double radius = 0, off = 0;
    };
    struct alignas(32) Third {  // the plane that ends an edge
        Four n;
        double h, square;             // square = |n|^2
        double norms2, determinant2;  // |na|^2 |nb|^2 |nc|^2 and det(na, nb, nc)^2
        double length2;               // square of `length` in star_bounds.hpp, which scales the error of the vertex
        [[nodiscard]] double condition() const { return std::sqrt(norms2 / determinant2); }
    };

    // ---- From vertex to vertex along the edges ----
    template <bool Alone>
    bool build_cell();
    template <Star::Keep Kept, bool Alone>
    bool complete();
    template <Star::Keep Kept>
    [[gnu::noinline]] bool find_first();
    template <Star::Keep Kept>
    [[gnu::always_inline]] inline bool read_known();
    [[gnu::always_inline]] inline void read_position(const KnownVertex& known, int vertex);
    bool read_tie(const KnownVertex& known, int vertex);
    [[gnu::always_inline]] inline void find_open();
    [[gnu::noinline]] void adapt_reach(double needed);
    bool collect_faces();
    [[gnu::always_inline]] inline void draw_line(const OpenEdge& edge, Line& line) const;
    [[nodiscard, gnu::always_inline]] inline bool is_drawn(const OpenEdge& edge, const Line& line) const;
    [[gnu::always_inline]] inline void aim(const Line& line, Ray& ray) const;
    // Returns the candidate that the ray hits first, a guess, or -1.
    [[nodiscard, gnu::noinline]] int first_hit(const Ray& ray);
    // Returns how many candidates may come near a vertex of that squared security radius. Seeds that were added
    // later lie farther away than all seeds of the window.
    [[nodiscard]] int in_reach(double reach2) const {
        return reach2 < near_covered_ ? candidates_.near : candidates_.count;
    }
    // Returns an upper bound on the squared security radius of a vertex of squared length x2: of (2 |X|)^2.
    [[nodiscard]] double reach_squared(double x2, const Third& third) const {
        return plain_ || !weighted_ ? bounds::widest_reach_squared(x2) : 4 * bounds::max_square(x2, third.length2, 1);
    }
    // Returns the square of `length` in star_bounds.hpp, for a vertex of squared length x2.
    [[nodiscard]] double error_length2(const Line& line, const Third& third, double x2) const {
        if (plain_ || !weighted_) return x2;
        const double tilt = tilt_length_ * scale_;
        return bounds::weighted_length2(x2, std::max(line.longest2, third.square), tilt * tilt);
    }
    // Returns the square of the length of a vertex by the inverse of the metric of a bent window.
    [[nodiscard]] double bent_square(const Four& x) const {
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& row = bent_.inverse[k];
            square += x.x[k] * (row[0] * x.x[0] + row[1] * x.x[1] + row[2] * x.x[2]);
        }
        return square;
    }
    // The same as reach_squared(), by that length.
    [[nodiscard]] double bent_reach_squared(double square, const Third& third) const {
        return 4 * bounds::max_square(square, third.length2, bent_.longest_inverse * bent_.longest_inverse);
    }
    // Converts a distance in window units to one between places. size: their largest coordinate, which is rounded.
    [[nodiscard]] double in_places(double distance, double size) const {
        return distance * unscale_ * (1 + 4 * margin) + 8 * unit * size;
    }
    [[nodiscard]] double weight_of(std::int32_t id) const { return seeds_.weights[static_cast<std::size_t>(id)]; }
    // Scales the rounding of h.
    [[nodiscard]] static double size_of_h(double h, double square) { return 0.5 * (square + std::abs(2 * h - square)); }
    [[nodiscard]] bool solve(const Line& line, Third& third, Four& x) const;
    // Finds the vertex at the other end of an edge. id: the plane to begin with, or no_plane. guessed: it may miss the
    // edge.
    template <Star::Keep Kept>
    [[gnu::always_inline]] inline bool close(const OpenEdge& edge, const Line& line, std::int32_t id, bool guessed);
    [[gnu::noinline]] int examine(const float* v, const std::int32_t* three, const Third& third, const Four& x,
                                  int lane, int count);
    void begin_tie(const std::int32_t* three);
    [[nodiscard]] exact::Differences difference_to(std::int32_t id) const;
    [[nodiscard]] double relative_error(const Third& third) const;
    [[nodiscard]] int sure_side(std::int32_t id, const Third& third, double relative, const Four& x);
    [[gnu::always_inline]] inline void store_position(const Third& third, const Four& x);
    template <Star::Keep Kept>
    [[gnu::always_inline]] inline bool add_vertex(const OpenEdge& edge, std::int32_t id, const Third& third,
                                                  const Four& x);
    [[gnu::noinline]] bool add_tie(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x);
    [[nodiscard]] bool give_polygons(double power);
    bool link_polygon(std::span<const std::int32_t> cells, int vertex);
    bool link_ring(std::span<const std::int32_t> ring, int vertex);
    void clear_planes();
    [[gnu::always_inline]] inline int slot_of(std::int32_t local, int& planes);
    template <Star::Keep Kept>
    [[gnu::always_inline]] inline void link_corner(int a, int b, int c, int vertex);
    void set_longest(double length);
    void set_image_reach(double reach) {
        reach = std::min(reach, own_images_);
        images_within2_ = reach * reach * scale_ * scale_ * (1 - 4 * margin);
        images_beyond2_ = window_open_ ? bounds::min_image_vertex2 : -1;
    }
    [[nodiscard]] double power_within(double distance2, double length2) const;
    [[nodiscard]] double distance_squared(const Four& x) const {  // of a vertex from the seed
        const Wide from_seed = wide(x) - wide(move_);
        return dot(from_seed, from_seed);
    }
    [[nodiscard, gnu::noinline]] bool images_known(const Four& x, double x2, double reach2, double length2);
    [[nodiscard]] bool owners_present(const Four& x, double length2) const;
    [[nodiscard]] double sure_by_weights(const Box& home) const;
    void find_sure_images();
    // The largest distance of a vertex within the reach of the window from a seed of the home, moved by the home's
    // tilt.
    [[nodiscard]] double home_length() const {
        return is_bent_ ? 0.5 * window_.reach() * bent_.longest + bent_.max_turned : 0.5 * window_.reach();
    }
    [[nodiscard]] double sure_image_reach() const { return 2 * std::max(0.0, sure_images_ - turned_); }
    [[nodiscard, gnu::noinline]] double sure_without_images(const Box& home, double length);
    [[nodiscard]] bool any_missing_image(const Ball& ball, double length);
    template <class Visit>
    bool for_shifts_around(const Box& around, double distance, Visit visit) const;
    [[nodiscard]] std::array<double, 3> translation(const std::array<int, 3>& shift) const;
    [[nodiscard]] Box seen_from_images(const Box& box, const std::array<double, 3>& by) const;
    template <class Visit>
    void for_groups(const Box& around, const std::array<double, 3>& by, const HeavierTest& test, Visit visit);
    [[nodiscard]] double distance_to_seed(const Box& box, std::size_t seed) const;
    [[nodiscard]] double largest_residual(const WeightTilt& tilt, std::size_t seed) const;
    // Returns the edges a -> b whose other end is unknown.
    [[nodiscard]] std::uint64_t open_edges(int a) const { return out_[a] & ~in_[a]; }
    [[nodiscard]] bool is_open(const OpenEdge& edge) const { return ((in_[edge.a] >> edge.b) & 1) == 0; }
    [[nodiscard]] static OpenEdge edge_of(int a, int b) {
        return {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
    }
    // Returns the bit of a plane that has such an edge.
    [[nodiscard, gnu::always_inline]] std::uint64_t open_bit(int a) const {
        return static_cast<std::uint64_t>(open_edges(a) != 0) << a;
    }
    [[gnu::always_inline]] void make_room(std::int32_t locals) {
        if (slot_.size() < static_cast<std::size_t>(locals) + max_planes) grow_slots(locals);
    }
    [[gnu::noinline]] void grow_slots(std::int32_t locals) {
        slot_.resize(2 * static_cast<std::size_t>(locals) + max_planes, no_slot);
    }
    [[gnu::always_inline]] int new_slot(std::int32_t id) {
        const std::int32_t local = cells_.local(id);
        if (!cells_.is_own(local)) make_room(local);
        return slot_of(local, planes_);
    }

    // ---- Bisector planes in floats, in doubles and exactly ----
    [[gnu::always_inline]] inline void need_plane(int slot);
    [[gnu::always_inline]] inline void find_open_planes();
    [[gnu::always_inline]] inline void plane_through(std::int32_t id, Four& n, double& h, double& square);
    [[gnu::always_inline]] inline void add_low(std::int32_t id, Four& n) const;
    [[nodiscard, gnu::noinline]] bool may_cancel(std::int32_t id, const Four& n) const;
    [[nodiscard]] exact::Plane exact_plane(std::int32_t id) const;
    [[nodiscard]] exact::Plane with_power(exact::Plane plane, std::int32_t id) const;
    [[nodiscard]] bool any_parallel(std::span<const std::int32_t> cells);

    // ---- Which planes are candidates ----
    void guess_reach(std::size_t group);
    void open_window(std::size_t home, double reach2);
    [[nodiscard]] bool may_coincide() const;
    bool gather_candidates();
    [[nodiscard]] bool is_buried(const std::array<std::int32_t, 3>& p, SelectLimits limits);
    [[gnu::always_inline]] inline bool select(const std::array<std::int32_t, 3>& p, const SelectLimits& limits);
    bool begin_anywhere();
    bool begin_at_face(int candidate);
    bool begin_outside();
    [[nodiscard]] int nearest_vertex(std::array<double, 3>& place) const;
    [[nodiscard]] std::int32_t owner_of(const std::array<double, 3>& place,
                                        const std::array<const CellPlane*, 3>& skipped);
    [[nodiscard]] std::optional<std::int32_t> done_owner_of(const std::array<double, 3>& place);
    template <class Visit>
    bool for_done_seeds(const Ball& ball, Visit visit);
    [[gnu::noinline]] bool is_hidden(const std::int32_t* three, const Third& third, const Four& x);
    [[nodiscard]] int side_of(std::int32_t id, const std::int32_t* three, const Third& third, const Four& x);
    bool add_candidate(std::int32_t id);
    void forget_candidates();
    void pad_candidates();
    [[nodiscard]] double covered_by_search(double square) const;
    void find_tilt(std::size_t home, const Box& box);
    [[nodiscard]] double residual(double weight, const exact::Point& x) const;
    [[nodiscard]] double least_residual(const WeightTilt& tilt, double weight, const exact::Point& x) const;
    bool find_bend(std::size_t home);
    bool bound_bend();
    void lay_bend(std::size_t home);
    bool find_metric();
    [[nodiscard]] Four turn_at(const exact::Point& x) const;
    void tilt_alone();
    [[nodiscard]] static double along_tilt(const WeightTilt& tilt, const Four& n) {
        return 0.5 * (n.x[0] * tilt.slope[0] + n.x[1] * tilt.slope[1] + n.x[2] * tilt.slope[2]);
    }
    [[nodiscard]] static double length_of(const WeightTilt& tilt);
    [[nodiscard]] Ball ball_around(const Four& x, double length2) const;
    [[nodiscard, gnu::always_inline]] inline unsigned near_boxes(std::int32_t level, std::uint32_t index,
                                                                 const Ball& ball) const;
    [[nodiscard]] bool is_candidate(std::int32_t id) const;
    [[nodiscard, gnu::always_inline]] inline unsigned find_inside(std::size_t begin, const GroupTest& test) const;
    [[nodiscard, gnu::noinline]] unsigned find_inside_weighted(std::size_t begin, const GroupTest& test) const;
    struct Found {  // seeds of a group
        std::uint32_t group;
        unsigned inside;
    };
    [[nodiscard, gnu::always_inline]] inline int find_all_inside(std::span<const std::uint32_t> groups,
                                                                 const GroupTest& test, Found* found) const;
    [[nodiscard, gnu::always_inline]] inline int leave_out(const std::int32_t* three, int count, Found* found) const;
    template <class Test, class Visit>
    [[gnu::always_inline]] inline void search_groups(Test test, Visit visit);
    template <class Visit>
    [[gnu::always_inline]] inline void search_ball(const Ball& ball, Visit visit);
    [[nodiscard]] std::uint32_t group_near(const Four& x) const;
    [[gnu::noinline]] bool add_of_window(const Four& x, double x2, const std::int32_t* three, int& added);
    [[gnu::noinline]] bool add_inside(const Line& line, double length2, const Four& vertex, const std::int32_t* three,
                                      int& added);
    template <class Visit>
    bool step_along(const Wide& nearest, const Wide& along, Visit visit) const;
    [[nodiscard, gnu::noinline]] bool add_along(const Line& line, const OpenEdge& edge);

    // ---- Walls: the walk handles a wall as the bisector of the seed and its mirror image ----
    struct Wall {
        std::int32_t id;
        exact::Plane plane;
        Four normal;    // of length 1, outward
        double offset;  // normal.x = offset on it, rounded
        double error;   // of the distance of a seed
        // As seen by the seed mirror_of: the bisector with its mirror image. h = 0 if the distance is not reliable.
        std::size_t mirror_of;
        Four n;
        double h;
    };
    struct NearWall {
        std::size_t wall;
        double distance;  // of the seed, rounded down
    };
    void collect_near_walls(const Box& home, double reach);
    bool add_near_walls();
    const Wall* find_nearest_of_many(double within, double& next);
    // These return false if the clipper must decide.
    bool add_wall(const Wall& wall);
    [[gnu::noinline]] bool add_nearest_wall();
    [[gnu::noinline]] bool add_wall_before(const Four& x, double length2, bool near, const Wide& along, int& added);
    [[nodiscard]] double distance_to(const Wall& wall) const;
    void wall_plane(std::int32_t id, Four& n, double& h);
    [[nodiscard]] Wall& wall_of(std::int32_t id) {
        return walls_[static_cast<std::size_t>(wall_places_[static_cast<std::size_t>(-1 - id)])];
    }

    // ---- The finished cell: measures, polygons, normals ----
    [[nodiscard]] bool is_difference(std::int32_t id) const;
    [[nodiscard]] std::array<double, 3> corner(const std::array<unsigned, 3>& ranks) const override;
    template <bool Plain>
    void shape_planes(std::span<const std::uint32_t> ranks);

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const Domain* domain_ = nullptr;
    std::vector<Wall> walls_;
    std::vector<std::int32_t> wall_places_;  // by -1 - id: in walls_, or -1
    std::vector<NearWall> near_walls_;       // of the seeds of the window's home, without those of the tree
    std::vector<std::uint32_t> wall_nodes_;  // scratch
    double wall_error_ = 0;                  // the largest of all walls
    bool any_rough_ = false;                 // images, see SeedImages
    bool moved_ = false;                     // the seed has been shifted from its input place
    bool weighted_ = false;
    bool plain_ = false;  // no weights, no images
    // Squared. All images that matter to a vertex are present if its security radius is below images_within2_, and
    // their rounding does not matter beyond images_beyond2_.
    double images_beyond2_ = 0, images_within2_ = 0;
    bool any_wrapped_ = false;  // of all seeds
    Neighborhood cells_;
    Window window_;
    std::size_t window_home_ = ~std::size_t{0};
    bool window_open_ = false;
    Keep keep_ = Keep::nothing;
    double reach_margin_ = min_reach_margin;
    int near_misses_ = 0;       // searches of the cell a little beyond the reach
    double typical_reach_ = 0;  // squared security radius of recent vertices, averaged

    bool probing_ = false;
    Box probes_box_{};  // of the probes that share a window
    double lightest_probe_ = 0;
    double own_images_ =
        std::numeric_limits<double>::infinity();  // distance of the nearest own image, if images are not candidates

    std::size_t seed_ = 0;  // a unique number for each probe
    std::int32_t own_id_ = 0, own_local_ = 0;
    exact::Point p_{};         // the seed, rounded if it has been moved
    Four low_{};               // rounding error of p_
    SeedImages::Base base_{};  // for exact arithmetic
    double weight_ = 0;        // of the seed
    double lightest_ = 0;      // of the seeds of the home
    WeightTilt tilt_{};        // of the weights around the home, see star_bounds.hpp
    WeightTilt own_tilt_{};    // the same, for the seed alone
    bool is_bent_ = false;     // how the slope changes around the home is known
    Window::Bent bent_{};
    Four turn_{};             // slope of own_tilt_ less that of tilt_
    double turned_ = 0;       // half of its length
    Four move_{};             // a, in window units
    double tilt_length_ = 0;  // |a|
    double home_tilt_length_ = 0;
    double sure_images_ = 0;  // no missing image cuts off a vertex of the home that is nearer to its moved seed
    bool sure_images_known_ = false;
    Box sure_box_{};        // of the home, for which it is found when a vertex needs it
    float own_weight_ = 0;  // in the window
    bool empty_ = false;    // the cell
    bool have_candidates_ = false;
    bool start_failed_ = false;                // the starting edge has no end
    std::int32_t cut_by_ = no_plane;           // cuts off all of the starting edge
    std::array<std::int32_t, 3> own_place_{};  // in the window
    CandidatePlanes candidates_;
    int selected_ = 0;            // candidates up to here are walls and seeds of the window
    int near_walls_end_ = 0;      // candidates up to here are walls
    double walls_within2_ = 0;    // squared security radius of vertices that no other wall of many cuts off
    double covered_ = 0;          // squared security radius of vertices that only candidates cut off
    double near_covered_ = 0;     // and of those that only the near ones cut off
    double window_covered_ = 0;   // and with weights, of those that only seeds of the window cut off
    double longest_ = 0;          // bound on the length of candidate normals
    double weight_rounding_ = 0;  // of h, by the residuals of the window
    double rounding_ = 0,
           rounding_by_square_ = 0;  // margin of a vertex: rounding_by_square_ times its square, plus rounding_
    double reached_ = 0;             // largest squared security radius of the vertices found
    double largest_distance2_ = 0, largest_length2_ = 0;  // of theirs, in a power diagram
    double scale_ = 1, unscale_ = 1;  // planes and vertices times this: window units, or 1 without a window

    // The planes of the cell by slot. Bit b of out_[a]: some vertex of face a has the edge a -> b. The vertex at its
    // other end has b -> a, and sets bit b of in_[a].
    std::array<std::uint64_t, max_planes> out_{}, in_{};
    std::uint64_t open_ = 0;                                    // planes that have open edges
    OpenEdge start_{};                                          // of a cell that has no vertex
    std::uint64_t planes_known_ = 0;                            // planes with n_, h_, square_, id_
    int ends_ = 0;                                              // edges, counted at either end
    std::array<std::int32_t, max_planes + lane_step> local_{};  // one behind the last plane is written too
    std::array<std::int32_t, max_planes> id_{};
    int planes_ = 0;
    alignas(64) std::array<Four, max_planes> n_{};
    std::array<double, max_planes> h_{}, square_{};
    std::vector<std::uint16_t> slot_;  // by local id
    std::uint16_t none_ = no_slot;     // not a constant, which would take two instructions to store

    std::vector<std::int32_t> tied_;  // ids of the planes through the examined vertex
    std::vector<std::int32_t> tied_cells_;
    std::vector<std::int32_t> ring_;
    std::vector<exact::Plane> corner_planes_;  // of link_polygon()
    exact::TiedSeeds tied_seeds_;
    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::array<Node, Hierarchy::max_nodes> nodes_;
    struct Pending {  // blocks of a level
        int count;
        std::uint32_t at[max_found];
    };
    std::array<Pending, Hierarchy::max_levels> pending_;
    std::array<std::uint32_t, max_found> groups_;
    bool image_shifts_known_ = false;
    std::vector<std::array<int, 3>> image_shifts_;          // by which missing images come near to the home
    Cell probe_;                                            // clips for a seed outside of its cell
    std::array<float, CandidatePlanes::capacity> value_{};  // of the candidates of a power diagram

    // For shape(): the corners of vertices on three planes, by vertex.
    CellShape shape_;
    std::array<std::uint8_t, max_planes> face_slot_;
    struct Tie {
        int vertex;
        std::vector<std::uint8_t>::difference_type begin, end;  // in tie_slots_
    };
    std::vector<Tie> ties_;
    std::vector<std::uint8_t> tie_slots_;

    // For polygons().
    alignas(64) std::array<Four, max_vertices> position_{};
    std::array<std::uint32_t, max_vertices> numbers_{};                           // in the stretch
    std::array<std::array<std::uint8_t, max_planes>, max_planes> from_vertex_{};  // vertex that has the edge a -> b
};

}  // namespace votess::cpu

#include "walk/star_walk.inl"
