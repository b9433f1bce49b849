// How a star is found; see star.hpp for the method.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "cpu/hierarchy.hpp"
#include "cpu/neighborhood.hpp"
#include "cpu/star.hpp"
#include "cpu/star_kernels.hpp"
#include "cpu/window.hpp"
#include "exact/predicate.hpp"

namespace votess::cpu {

// Isa only tells the copies apart: each is compiled for another instruction set by the file that includes this one.
template <class Isa>
class StarWalk final : public Star {
public:
    StarWalk(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Box& box, const StarKernels& kernels)
        : seeds_(seeds), hierarchy_(hierarchy), box_(box), kernels_(kernels), window_(seeds, hierarchy, kernels) {}

    void begin(std::size_t first, std::size_t last, bool measure) override;
    bool build(std::size_t seed) override;
    bool measure(Geometry& out) override;

private:
    using Vector = std::array<double, 3>;

    static constexpr double unit = 0x1p-53;
    static constexpr double float_unit = 0x1p-24;
    static constexpr float quantum = 2;            // of window integers: more than q in star.hpp
    static constexpr double worst_condition2 = 1e12;  // (|na||nb||nc| / det)^2
    static constexpr double margin = 2e-8;  // more than the relative error of a vertex that is accepted
    static constexpr double solved_factor = 64 * unit;
    static constexpr double smallest_h = 1e-90, largest_h = 1e90;  // no square of a product leaves the range
    static constexpr double longest_normal = 1e12;                 // in window units: products of three stay floats
    static constexpr double reach_margin = 1.8;  // of the squared security radius that is typical
    static constexpr int most_candidates = 160;    // at first; room for others is left
    static constexpr int most_picks = 64;         // planes tried for one vertex
    static constexpr std::uint8_t no_slot = 255;
    static constexpr int tie = -2;
    static constexpr float parallel = 0x1p-18f;   // rays nearly along a plane do not leave it
    static constexpr int most_new = 24;           // seeds taken at once from beyond the window

    // The promise is 1e-10.
    static constexpr double accepted_error = 5e-11;
    static constexpr double smallest_volume = 1e-140;

    using Wide = double __attribute__((vector_size(32), aligned(8), may_alias));
    // A reference, for processors without such registers.
    [[gnu::always_inline]] static const Wide& as_wide(const Four& four) { return reinterpret_cast<const Wide&>(four); }
    [[gnu::always_inline]] static Wide& as_wide(Four& four) { return reinterpret_cast<Wide&>(four); }
    [[gnu::always_inline]] static double dot(const Vector& a, const Vector& b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
    [[gnu::always_inline]] static Vector cross(const Vector& a, const Vector& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }

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
    [[nodiscard]] double measure_error() const;
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

    std::uint64_t planes_known_ = 0;  // bit: id_, n_, h_ are set
    std::array<std::int32_t, most_planes> local_{};
    std::array<Vector, most_planes> n_{};
    std::array<double, most_planes> h_{};
    std::array<Links, most_planes> links_{};
    std::uint64_t active_ = 0;                        // planes with open edges
    std::vector<std::uint8_t> slot_;                  // by local id

    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::vector<Node> nodes_;
    // For measure().
    std::array<VertexPosition, most_vertices> position_{};
    std::array<std::array<std::uint8_t, 4>, most_vertices> corner_{};  // the three planes
    std::array<std::array<std::uint8_t, most_planes>, most_planes> from_vertex_{};  // corner with edge a -> b
};


// `planes` is planes_, in a register when it can be.
template <class Isa>
int StarWalk<Isa>::slot_of(std::int32_t local, int& planes) {
    const std::uint8_t known = slot_[local];
    const bool is_new = known == no_slot;
    const int slot = is_new ? planes : known;
    slot_[local] = static_cast<std::uint8_t>(slot);
    local_[planes] = local;  // beyond the last one it does no harm
    links_[planes] = {0, 0};
    planes += is_new ? 1 : 0;
    return slot;
}

template <class Isa>
void StarWalk<Isa>::plane_through(std::int32_t id, Vector& n, double& h) const {
    if (id >= 0) {
        n = {(seeds_.x[id] - p_[0]) * scale_, (seeds_.y[id] - p_[1]) * scale_, (seeds_.z[id] - p_[2]) * scale_};
        h = 0.5 * dot(n, n);
        return;
    }
    const int axis = (-1 - id) / 2;
    const double distance = ((-1 - id) % 2 == 0 ? box_.lower[axis] - p_[axis] : box_.upper[axis] - p_[axis]) * scale_;
    n = {};
    n[axis] = 2 * distance;
    h = 2 * distance * distance;
}

template <class Isa>
void StarWalk<Isa>::need_plane(int slot) {
    if ((planes_known_ >> slot) & 1) return;
    planes_known_ |= 1ull << slot;
    id_[slot] = cells_.id(local_[slot]);
    plane_through(id_[slot], n_[slot], h_[slot]);
}

template <class Isa>
void StarWalk<Isa>::need_all_planes() {
    for (int p = 0; p < planes_; ++p) need_plane(p);
}

// The corner's edges a -> b, b -> c, c -> a.
template <class Isa>
void StarWalk<Isa>::link_corner(int a, int b, int c, int vertex) {
    auto link = [this](int p, int to, int from) {
        links_[p].out |= 1ull << to;
        links_[p].in |= 1ull << from;
    };
    link(a, b, c);
    link(b, c, a);
    link(c, a, b);
    if (measure_) {
        from_vertex_[a][b] = from_vertex_[b][c] = from_vertex_[c][a] = static_cast<std::uint8_t>(vertex);
        corner_[vertex] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b), static_cast<std::uint8_t>(c), 0};
    }
}

template <class Isa>
void StarWalk<Isa>::begin(std::size_t first, std::size_t last, bool measure) {
    for (int p = 0; p < planes_; ++p) slot_[local_[p]] = no_slot;
    planes_ = 0;
    cells_.begin(seeds_, first, last, measure);
    measure_ = measure;
    window_group_ = ~std::size_t{0};
    if (typical_reach_ == 0) {
        const BoundingBox all = hierarchy_.box(hierarchy_.top_level(), 0);
        double volume = 1;
        for (int k = 0; k < 3; ++k) volume *= std::max(all.upper[k] - all.lower[k], 1e-9);
        typical_reach_ = 5 * std::pow(volume / static_cast<double>(seeds_.size()), 2.0 / 3);
    }
}

template <class Isa>
bool StarWalk<Isa>::build(std::size_t seed) {
    seed_ = seed;
    p_ = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    for (int p = 0; p < planes_; ++p) slot_[local_[p]] = no_slot;
    planes_ = vertices_ = 0;
    planes_known_ = active_ = 0;
    scale_ = 1;
    have_candidates_ = have_walls_ = used_exact_ = false;
    const bool complete = this->complete(seed);
    if (have_candidates_ && !complete) window_.show(seed, own_x_);
    if (complete) {
        cells_.set_done(seed);
        if (window_group_ == seed / group_size && window_open_) window_.hide(seed);
    }
    return complete;
}

template <class Isa>
bool StarWalk<Isa>::complete(std::size_t seed) {
    if (!take_known(seed)) return false;
    if (vertices_ == 0 && !begin_anywhere()) return false;
    if (active_ != 0 && !have_candidates_ && !gather_candidates(seed)) return false;
    reached_ = 0;
    while (active_ != 0) {
        // Two open edges at once, far from each other: their searches overlap in the processor. The second may have
        // been closed by the vertex of the first.
        const int a = std::countr_zero(active_), b = std::countr_zero(open(a));
        const int c = 63 - std::countl_zero(active_), d = 63 - std::countl_zero(open(c));
        OpenEdge edges[2];
        Ray rays[2];
        if (!aim(a, b, edges[0], rays[0]) || !aim(c, d, edges[1], rays[1])) return false;
        int hits[2];
        kernels_.first_hits(candidates_, rays, hits);
        if (!close(edges[0], rays[0], hits[0])) return false;
        if (((open(c) >> d) & 1) != 0 && !close(edges[1], rays[1], hits[1])) return false;
    }
    const double unscale = 1 / scale_;
    const double needed = reached_ * unscale * unscale;
    if (needed > 0) typical_reach_ += (std::min(needed, 4 * typical_reach_) - typical_reach_) / 16;
    int edges = 0;
    for (int p = 0; p < planes_; ++p) {
        id_[p] = cells_.id(local_[p]);
        edges += std::popcount(links_[p].out);
    }
    return edges == 3 * vertices_;  // no edge was found twice in the same direction
}

// Without branches but the loop's: what is known of a cell follows no pattern.
template <class Isa>
bool StarWalk<Isa>::take_known(std::size_t seed) {
    // Even permutations of the four cells keep the orientation: the other three as seen from cell 1, 2, 3.
    static constexpr std::uint8_t others[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    const auto locals = static_cast<std::size_t>(cells_.locals());
    if (slot_.size() < locals + most_planes) slot_.resize(2 * locals + most_planes, no_slot);
    bool fits = true;
    const Wide own{p_[0], p_[1], p_[2], 0};
    int planes = 0, vertices = 0;
    cells_.for_each_known(seed, [&](KnownVertex known) {
        if (planes > most_planes - 4 || vertices > most_vertices - 4) {
            fits = false;
            return;
        }
        const SharedVertex& v = cells_.vertex(known.vertex());
        const std::uint8_t* order = others[known.corner()];
        const int a = slot_of(v.cells[order[0]], planes), b = slot_of(v.cells[order[1]], planes),
                  c = slot_of(v.cells[order[2]], planes);
        if (measure_) {
            as_wide(position_[vertices].at) =
                as_wide(cells_.position(known.vertex()).at) + (as_wide(cells_.seed(v.cells[0])) - own);
        }
        link_corner(a, b, c, vertices);
        ++vertices;
    });
    planes_ = planes;
    vertices_ = vertices;
    for (int p = 0; p < planes_; ++p) active_ |= static_cast<std::uint64_t>(open(p) != 0) << p;
    return fits;
}

template <class Isa>
exact::Plane StarWalk<Isa>::exact_plane(std::int32_t id) const {
    if (id >= 0) return exact::Plane::bisector({seeds_.x[id], seeds_.y[id], seeds_.z[id]});
    const int axis = (-1 - id) / 2;
    return (-1 - id) % 2 == 0 ? exact::Plane::lower(axis, box_.lower[axis])
                              : exact::Plane::upper(axis, box_.upper[axis]);
}

template <class Isa>
bool StarWalk<Isa>::gather_candidates(std::size_t seed) {
    const std::size_t group = seed / group_size;
    double reach2 = reach_margin * typical_reach_;
    if (window_group_ != group) {
        window_group_ = group;
        window_open_ = window_.open(group, std::sqrt(reach2) * 1.02, cells_);
        if (window_open_)
            for (std::size_t s = group * group_size; s < seed; ++s)
                if (cells_.holds(static_cast<std::int64_t>(s)) && cells_.done(s)) window_.hide(s);
    }
    if (!window_open_) return false;
    reach2 = std::min(reach2, window_.reach() * window_.reach());
    const double scale = window_.scale();
    const auto p = window_.position(seed);
    window_.hide(seed);
    for (int tries = 0;; ++tries) {
        if (kernels_.select(window_.seeds(), p.data(), static_cast<float>(reach2 * scale * scale), candidates_) &&
            candidates_.count <= most_candidates)
            break;
        if (tries == 8) {
            window_.show(seed, p[0]);
            return false;
        }
        reach2 *= 0.5;
    }
    have_candidates_ = true;
    own_x_ = p[0];
    scale_ = scale;
    const double reach = std::sqrt(reach2) * scale;
    const double covered = reach * (1 - 0x1p-20) - quantum;
    covered_ = covered > 0 ? covered * covered : 0;
    longest_ = reach * (1 + 0x1p-20) + quantum;
    inverse_longest_ = 1 / longest_;
    extras_ = candidates_.count;
    for (int wall = -1; wall >= -6; --wall) {
        Vector n;
        double h;
        plane_through(wall, n, h);
        if (2 * h < longest_ * longest_) add_candidate(wall);
    }
    return true;
}

template <class Isa>
bool StarWalk<Isa>::add_candidate(std::int32_t id) {
    CandidatePlanes& c = candidates_;
    if (c.count == CandidatePlanes::capacity) return false;
    Vector n;
    double h;
    plane_through(id, n, h);
    const double length = std::sqrt(2 * h);
    if (!(length < longest_normal)) return false;
    longest_ = std::max(longest_, length * (1 + 0x1p-20));
    inverse_longest_ = 1 / longest_;
    const int i = c.count++;
    c.nx[i] = static_cast<float>(n[0]);
    c.ny[i] = static_cast<float>(n[1]);
    c.nz[i] = static_cast<float>(n[2]);
    c.h[i] = static_cast<float>(h);
    c.id[i] = id;
    if (c.count % 16 == 1)
        for (int k = c.count; k < c.count + 15; ++k) {
            c.nx[k] = c.ny[k] = c.nz[k] = 0;
            c.h[k] = CandidatePlanes::never;
        }
    return true;
}

template <class Isa>
bool StarWalk<Isa>::is_extra(std::int32_t id) const {
    const std::int32_t* end = candidates_.id + candidates_.count;
    return std::find(candidates_.id + extras_, end, id) != end;
}

template <class Isa>
bool StarWalk<Isa>::add_walls() {
    have_walls_ = true;
    for (int wall = -1; wall >= -6; --wall) {
        if (!is_extra(wall) && !add_candidate(wall)) return false;
    }
    return true;
}

// The nearest seed is a neighbor, and the middle between the two lies inside their face. From there any way along the
// face leads to an edge.
template <class Isa>
bool StarWalk<Isa>::begin_anywhere() {
    if (!gather_candidates(seed_)) return false;
    if (candidates_.count == extras_ && !add_walls()) return false;
    const CandidatePlanes& c = candidates_;
    const auto nearest = static_cast<int>(std::min_element(c.h, c.h + c.count) - c.h);
    auto slot = [this](std::int32_t id) {
        const std::int32_t local = cells_.local(id);
        if (static_cast<std::size_t>(local) >= slot_.size()) slot_.resize(2 * slot_.size() + most_planes, no_slot);
        return slot_of(local, planes_);
    };
    const int a = slot(c.id[nearest]);
    need_plane(a);
    const Vector& n = n_[a];
    const Vector along =
        cross(n, {0.61803398875 * n[1], 0.7548776662 * n[2], 0.5698402910 * n[0] + std::sqrt(h_[a])});
    Ray ray;
    float size = 0;
    for (int k = 0; k < 3; ++k) {
        ray.o[k] = static_cast<float>(0.5 * n[k]);
        ray.d[k] = static_cast<float>(along[k]);
        size += std::abs(ray.d[k]);
    }
    ray.least = parallel * size * static_cast<float>(longest_);
    int hit = first_hit(ray);
    if (hit < 0 && !have_walls_) {
        if (!add_walls()) return false;
        hit = first_hit(ray);
    }
    if (hit < 0) return false;
    OpenEdge edge;
    return aim(a, slot(c.id[hit]), edge, ray) && close(edge, ray, -1);
}

template <class Isa>
bool StarWalk<Isa>::aim(int a, int b, OpenEdge& edge, Ray& ray) {
    need_plane(a);
    need_plane(b);
    const Vector &na = n_[a], &nb = n_[b];
    const double ha = h_[a], hb = h_[b];
    edge.a = a;
    edge.b = b;
    edge.ab = cross(na, nb);
    const double square = dot(edge.ab, edge.ab);
    edge.norms2 = 4 * ha * hb;
    if (!(ha > smallest_h && hb > smallest_h && edge.norms2 < largest_h && square * worst_condition2 > edge.norms2))
        return false;
    const Vector nb_ab = cross(nb, edge.ab), ab_na = cross(edge.ab, na);
    const double inverse = 1 / square;
    float size = 0;
    for (int k = 0; k < 3; ++k) {
        ray.o[k] = static_cast<float>((ha * nb_ab[k] + hb * ab_na[k]) * inverse);
        ray.d[k] = static_cast<float>(-edge.ab[k]);
        size += std::abs(ray.d[k]);
    }
    ray.least = parallel * size * static_cast<float>(longest_);
    return true;
}

// Cramer's rule. False when the planes are too near to parallel, or meet behind where the edge begins.
template <class Isa>
bool StarWalk<Isa>::solve(const OpenEdge& edge, Third& c, Vector& x) const {
    const Vector &na = n_[edge.a], &nb = n_[edge.b];
    const double ha = h_[edge.a], hb = h_[edge.b];
    const Vector bc = cross(nb, c.n), ca = cross(c.n, na);
    const double determinant = dot(c.n, edge.ab);
    c.norms2 = edge.norms2 * (2 * c.h);
    c.determinant2 = determinant * determinant;
    if (!(determinant < 0 && c.norms2 < worst_condition2 * c.determinant2 && c.h > smallest_h)) return false;
    const double over = 1 / determinant;
    for (int k = 0; k < 3; ++k) x[k] = (ha * bc[k] + hb * ca[k] + c.h * edge.ab[k]) * over;
    return true;
}

template <class Isa>
int StarWalk<Isa>::first_hit(const Ray& ray) const {
    const Ray rays[2] = {ray, ray};
    int hits[2];
    kernels_.first_hits(candidates_, rays, hits);
    return hits[0];
}

template <class Isa>
bool StarWalk<Isa>::close(const OpenEdge& edge, const Ray& ray, int lane) {
    for (int pick = 0; pick < most_picks; ++pick) {
        if (lane < 0) {
            lane = first_hit(ray);
            if (lane < 0 && !have_walls_) {
                if (!add_walls()) return false;
                lane = first_hit(ray);
            }
            if (lane < 0) return false;
        }
        const std::int32_t id = candidates_.id[lane];
        Third third;
        Vector x;
        plane_through(id, third.n, third.h);
        if (!solve(edge, third, x)) return false;
        const double x2 = dot(x, x);
        if (!(x2 < longest_normal * longest_normal)) {
            if (have_walls_ || !add_walls()) return false;
            lane = -1;
            continue;
        }
        const float v[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
        const std::int32_t three[3] = {id_[edge.a], id_[edge.b], id};
        const float rounding = rounding_of(x2);
        int touching = kernels_.touching(candidates_, v, rounding, three, 0);
        if (touching >= 0) {
            touching = cutting_plane({x, third.condition()}, v, rounding, three, touching);
            if (touching == tie) return false;
            if (touching >= 0) {
                lane = touching;
                continue;
            }
        }
        if (4 * x2 * (1 + margin) > covered_) {
            if (!have_walls_) {
                if (!add_walls()) return false;
                lane = -1;
                continue;
            }
            int added = 0;
            if (!add_inside(edge, x, three, added)) return false;
            if (added > 0) {
                lane = -1;
                continue;
            }
        }
        reached_ = std::max(reached_, 4 * x2);
        return add_vertex(edge, id, third, x);
    }
    return false;
}

template <class Isa>
bool StarWalk<Isa>::add_vertex(const OpenEdge& edge, std::int32_t id, const Third& third, const Vector& x) {
    if (planes_ > most_planes - 2 || vertices_ > most_vertices - 4) return false;
    const auto [a, b] = std::pair{edge.a, edge.b};
    const std::int32_t local = cells_.local(id);
    if (static_cast<std::size_t>(local) >= slot_.size()) slot_.resize(2 * slot_.size() + most_planes, no_slot);
    const int c = slot_of(local, planes_);
    planes_known_ |= 1ull << c;
    id_[c] = id;
    n_[c] = third.n;
    h_[c] = third.h;
    VertexPosition& position = position_[vertices_];
    if (measure_) {
        const double unscale = 1 / scale_;
        as_wide(position.at) = Wide{x[0], x[1], x[2], third.norms2 / third.determinant2 * dot(x, x) * unscale} * unscale;
    }
    cells_.add({{cells_.local(static_cast<std::int32_t>(seed_)), local_[b], local_[a], local}}, position);
    link_corner(b, a, c, vertices_++);
    for (const int p : {a, b, c})
        active_ = (active_ & ~(1ull << p)) | static_cast<std::uint64_t>(open(p) != 0) << p;
    return true;
}

// Of the planes that come too near to a vertex, from `lane` on, the first that cuts it off; -1 if none does, `tie` if
// one goes through it.
template <class Isa>
int StarWalk<Isa>::cutting_plane(const Solved& vertex, const float* v, float rounding, const std::int32_t* three, int lane) {
    while (lane >= 0) {
        const int side = side_of(vertex, three, candidates_.id[lane]);
        if (side > 0) return lane;
        if (side == 0) return tie;
        // The kernel goes by blocks; those of this block that are left are done one by one.
        int next = lane + 1;
        for (; next % 16 != 0 && next < candidates_.count; ++next) {
            const float gap = candidates_.h[next] - candidates_.nx[next] * v[0] - candidates_.ny[next] * v[1] -
                              candidates_.nz[next] * v[2];
            const std::int32_t id = candidates_.id[next];
            if (gap <= 1.1f * rounding && id != three[0] && id != three[1] && id != three[2]) break;
        }
        lane = next >= candidates_.count ? -1
               : next % 16 != 0          ? next
                                         : kernels_.touching(candidates_, v, rounding, three, next);
    }
    return -1;
}

// The margin derived in star.hpp, for a vertex of squared length x2: |X| <= X^2 / L + L / 4.
template <class Isa>
float StarWalk<Isa>::rounding_of(double x2) const {
    const double square = longest_ * longest_;
    return static_cast<float>(1.01 * (float_unit * (6.5 * (x2 + 0.25 * square) + 4.6 * square) +
                                      quantum * (x2 * inverse_longest_ + 1.25 * longest_)));
}

template <class Isa>
int StarWalk<Isa>::side_of(const Solved& vertex, const std::int32_t* three, std::int32_t id) {
    Vector n;
    double h;
    plane_through(id, n, h);
    const double excess = dot(n, vertex.x) - h;
    const double length2 = 2 * h * dot(vertex.x, vertex.x);
    const double bound = std::sqrt(length2) * unit * (64 * vertex.condition + 8) + 12 * unit * h;
    if (excess > bound) return 1;
    if (excess < -bound) return -1;
    used_exact_ = true;
    return exact::side_of_vertex(p_, exact_plane(three[0]), exact_plane(three[1]), exact_plane(three[2]),
                                 exact_plane(id));
}

// Seeds beyond the candidates that the sphere around the vertex may hold: not all of them, for each that is found moves
// the vertex along its edge, and the sphere shrinks.
template <class Isa>
bool StarWalk<Isa>::add_inside(const OpenEdge& edge, Vector x, const std::int32_t* three, int& added) {
    BoundingBox at;
    double reach2 = 0;
    GroupTest test{p_, scale_, {}, 0};
    auto look_around = [&] {
        double size = 0;
        for (int k = 0; k < 3; ++k) {
            const double offset = x[k] / scale_;
            at.lower[k] = at.upper[k] = p_[k] + offset;
            size = std::max(size, std::abs(p_[k]) + std::abs(offset));
        }
        const double x2 = dot(x, x);
        const double reach = std::sqrt(x2) / scale_ * (1 + margin) + 8 * unit * size;
        reach2 = reach * reach;
        test.v = x;
        test.slack = 2 * margin * x2;
    };
    look_around();
    nodes_.assign(1, {hierarchy_.top_level(), 0});
    while (!nodes_.empty()) {
        const Node node = nodes_.back();
        nodes_.pop_back();
        unsigned near = kernels_.near_boxes(hierarchy_.block(node.level, node.index), at, reach2);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = node.index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (node.level > 0) {
                nodes_.push_back({node.level - 1, child});
                continue;
            }
            if (cells_.group_done(child)) continue;
            const std::size_t begin = std::size_t{child} * group_size;
            unsigned inside =
                kernels_.inside_ball(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], test, covered_);
            for (; inside != 0; inside &= inside - 1) {
                const auto id = static_cast<std::int32_t>(begin) + std::countr_zero(inside);
                if (static_cast<std::size_t>(id) == seed_ || id == three[0] || id == three[1] || id == three[2] ||
                    is_extra(id))
                    continue;
                if (!add_candidate(id)) return false;
                if (++added == most_new) return true;
                Third third;
                Vector nearer;
                plane_through(id, third.n, third.h);
                if (dot(third.n, x) > third.h && solve(edge, third, nearer)) {
                    x = nearer;
                    look_around();
                    inside &= kernels_.inside_ball(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], test, covered_) |
                              1u << std::countr_zero(inside);
                }
            }
        }
    }
    return true;
}

// Sums over the edges. With V, W the ends of an edge in counterclockwise order around a face of normal n (the difference
// of seeds, so that n.x = |n|^2/2 on it), V x W sums to twice the face's area vector A, and n.A/12 is the volume of the
// pyramid between seed and face. Its part over V, W and the foot n/2 of the plane has its centroid at (V + W + n/2)/4.
//
// What carries an index below is a vector of three components and one more lane; a cross product comes out as z, x, y,
// and what is multiplied with it is kept in that order.
template <class Isa>
bool StarWalk<Isa>::measure(Geometry& out) {
    using Lanes = std::int64_t __attribute__((vector_size(32)));
    constexpr Lanes turn{1, 2, 0, 3}, turn_twice{2, 0, 1, 3};
    need_all_planes();
    const double unscale = 1 / scale_;
    Wide normal[most_planes], area[most_planes];
    double longest = 0;
    for (int p = 0; p < planes_; ++p) {
        const Vector& n = n_[p];
        normal[p] = Wide{n[2], n[0], n[1], 0} * unscale;
        area[p] = Wide{};
        longest = std::max(longest, h_[p]);
    }
    Wide moment{}, farthest{}, error{};
    for (int v = 0; v < vertices_; ++v) {
        const Wide from = as_wide(position_[v].at);
        const Wide from_turned = __builtin_shuffle(from, turn);
        const auto& corner = corner_[v];
        for (int k = 0; k < 3; ++k) {
            // The edge along planes a, b is counterclockwise around b; its other end has it around a.
            const int a = corner[k], b = corner[k == 2 ? 0 : k + 1];
            const Wide to = as_wide(position_[from_vertex_[b][a]].at);
            const Wide across = from * __builtin_shuffle(to, turn) - from_turned * to;
            area[b] += across;
            Wide part = across * normal[b];
            part += __builtin_shuffle(part, turn) + __builtin_shuffle(part, turn_twice);
            moment += part * (from + to);
        }
        const Wide square = from * from;
        farthest = square > farthest ? square : farthest;
        error = from > error ? from : error;
    }
    double volume = 0;
    for (int p = 0; p < planes_; ++p) {
        const Wide parts = normal[p] * area[p];
        const double part = parts[0] + parts[1] + parts[2];
        volume += part;
        moment += 0.5 * part * Wide{normal[p][1], normal[p][2], normal[p][0], 0};
    }
    volume /= 12;
    const double reach = std::sqrt(farthest[0] + farthest[1] + farthest[2]);
    const double bound = edge_count() * 2 * std::sqrt(2 * longest) * unscale *
                         (2 * solved_factor * std::sqrt(error[3]) * reach + 32 * unit * reach * reach) / 12;
    if (!(volume > smallest_volume)) return false;
    if (!(bound <= accepted_error * volume) && !(measure_error() <= accepted_error * volume)) return false;
    out.volume = volume;
    for (int k = 0; k < 3; ++k) out.centroid[k] = moment[k] / (48 * volume);
    for (int p = 0; p < planes_; ++p) {
        const Wide square = area[p] * area[p];
        out.areas[p] = 0.5 * std::sqrt(square[0] + square[1] + square[2]);
    }
    return true;
}

// A bound on the error of the volume, edge by edge.
template <class Isa>
double StarWalk<Isa>::measure_error() const {
    double bound = 0;
    for (int v = 0; v < vertices_; ++v)
        for (int k = 0; k < 3; ++k) {
            const int a = corner_[v][k], b = corner_[v][k == 2 ? 0 : k + 1];
            const auto &from = position_[v].at.x, &to = position_[from_vertex_[b][a]].at.x;
            const double from_length = std::abs(from[0]) + std::abs(from[1]) + std::abs(from[2]);
            const double to_length = std::abs(to[0]) + std::abs(to[1]) + std::abs(to[2]);
            bound += std::sqrt(2 * h_[b]) / scale_ *
                     (solved_factor * (std::sqrt(from[3]) * to_length + std::sqrt(to[3]) * from_length) +
                      32 * unit * from_length * to_length);
        }
    return bound / 12;
}

}  // namespace votess::cpu
