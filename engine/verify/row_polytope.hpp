// The polytope that some planes bound, with all of its corners, each proven.
//
// Gift wrapping: along an edge of a corner, the plane that is met first ends it at the next corner. Floating point
// guesses that plane. The corner counts if every other plane is certainly on its outer side, so no guess is trusted:
//   - A corner that passes is a corner of the polytope, by definition.
//   - Each of its edges has a second end among the corners. As the edges of a bounded polytope connect its corners,
//     these are all; and if each edge has two ends, the polytope is bounded.
// With three planes at each corner this needs sure signs only. Otherwise wrap_exactly() takes exact ones. A corner is
// then named by all planes through it, and its edges are the rays along two of them that leave none.
//
// Polytopes of many planes keep these in blocks of near normals. With c = d - |n|^2 / 2 a plane lies beyond x by
// 2 (d - n.x) = |x - n|^2 - |x|^2 + 2 c, so one distance from a box of normals settles most blocks. A corner then
// looks at few planes, instead of all.
//
// Filter. Cramer's rule gives a corner x = X / W, W = det(na, nb, nc). Let m = |na||nb||nc|, K = m / W and
// s = sum |d| / |n| over a, b, c, with sizes of d for |d|. All terms of X are at most 1.16 m s (Carlen, Lieb, Loss
// 2006), and those of n.X - d W at most 1.16 m (s |n| + |d|). Errors of the four planes add 8 u each, and rounding adds
// less than 20 u. So n.x - d has the sign of its exact value if it exceeds 2^-45 K (s |n| + |d|), which is 256 u.
//
// Errors of measures. Twice the area vector of a face is the sum of x_k cross x_k+1 around it, a volume the sum of
// areas times heights / 3, all from an origin in the polytope. Let R bound the distances of corners from it, and e_v
// the error of corner v. That moves the area vectors of its faces by at most e_v |x_k+1 - x_k-1| / 2 <= e_v R each, to
// first order, and heights by at most the largest e, over a surface below 4 pi R^2. So with E, the sum of e_v over the
// faces of all corners, areas err by R E and the volume by R^2 (E / 3 + 4.2 E / 3) at most; R E and R^2 E are doubled
// for other orders. Rounding: the edges of a face are a convex polygon in a ball, shorter than 2 pi R. So no sum of
// terms exceeds 6.3 R^2, and each of at most 6 planes (Euler) sides of edges adds less than 16 u R^2, and areas and
// heights 32 u of themselves. Together that is below 128 u R^2 and 128 u R^3 for each plane, u = 2^-53.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/vector3.hpp"
#include "verify/plane_loops.hpp"
#include "verify/seed_planes.hpp"

namespace votess {

class RowPolytope {
public:
    enum class Shape : std::uint8_t {
        solid,      // it has volume
        flat,       // it has none, and corners
        empty,      // no planes meet in a corner: it is empty if planes bound it, else it has no end
        open,       // unbounded
        repeated,   // two planes bound it in one face, see repeated()
        unsettled,  // too large for exact signs, or no corner was found
    };
    using Corner = PlaneCorner;
    using Edge = PlaneEdge;
    using Fan = PlaneFan;
    struct Name {
        std::int32_t id;
        exact::Shift shift;
        friend bool operator==(const Name&, const Name&) = default;
    };
    struct Measures {
        double volume = 0, surface = 0, diameter = 0, reach = 0;  // reach: of the farthest corner from the seed
        Vector3 centroid{};
        double error = 0, errors = 0;  // bounds on the rounding of corners: the largest, the sum over corners of faces
        double span = 0,
               rounding = 0;          // bound on lengths in the sums; relative rounding of these, times that of planes
        std::vector<double> areas;    // of the faces, by plane
        std::vector<int> anchors;     // a corner of each face
        std::vector<double> vectors;  // see PlaneLoops::add_areas

        // Return bounds on the errors of an area, of the surface and of the volume.
        [[nodiscard]] double doubt_of_area() const { return span * (2 * errors + rounding * span); }
        [[nodiscard]] double doubt_of_volume() const { return span * doubt_of_area(); }
    };

    explicit RowPolytope(const SeedPlanes& planes) : planes_(planes) {}

    // Returns a bound on the rounding of n.x - d of a plane, where x is the rounded difference of a place and the seed.
    // length: of x.
    [[nodiscard]] static double doubt_of(const RoundedPlane& plane, double length);

    // length: of a typical bisector. Extreme ones set unit().
    void begin(std::size_t seed, double length);
    // Lengths here are those of the job times this power of two.
    [[nodiscard]] double unit() const { return unit_; }
    [[nodiscard]] RoundedPlane seen(const Name& name) const;
    void add(const Name& name) { add(name, seen(name)); }
    void add(const Name& name, const RoundedPlane& plane);
    // Adds the bisectors with these seeds, unshifted. Returns false, and adds none, where some lie at the seed's place
    // or lengths are scaled.
    [[nodiscard]] bool add_seeds(std::span<const std::int32_t> ids);

    // Names the corners of polygons, one for each plane: polygon f has the vertices offsets[f] to offsets[f + 1], from
    // vertices[0] on. listed: all vertices, ascending; empty if there is no such list. Returns false unless there are
    // three polygons around each corner, and each edge belongs to two, in opposite directions.
    [[nodiscard]] bool close_polygons(std::span<const std::int64_t> offsets, std::span<const std::int32_t> vertices,
                                      std::span<const std::int32_t> listed);
    // Returns the fans of the last close_polygons() that returned true, by corner.
    [[nodiscard]] std::span<const Fan> fans() const { return fans_; }
    // Makes room for the corners of fans, without places.
    void begin_corners();
    // Finds the place of a corner. Returns false unless its normals certainly turn as its fan does.
    [[nodiscard]] bool place_corner(int corner) {
        const Fan& fan = fans_[at(corner)];
        return meet(p_, fan.plane(0), fan.plane(1), fan.plane(2), corners_[at(corner)]);
    }
    // Whether such a corner lies strictly inside of a plane, by exact signs.
    [[nodiscard]] bool is_inside(int corner, int plane) {
        const Corner& place = corners_[at(corner)];
        const double slack = p_.d[at(plane)] - dot(normal(plane), place.at),
                     bound =
                         place.slope * p_.length[at(plane)] + place.constant * p_.size[at(plane)] + filter_underflow;
        return slack > bound || (!(slack < -bound) && is_exactly_inside(corner, plane));
    }
    [[nodiscard]] bool is_surely_inside(int corner, const RoundedPlane& plane) const;
    // All planes have faces, and fans stand for the edges. Their corners have places.
    void take_fans();
    // Takes the corners from polygons, as above. Returns false unless sure signs show that these are the polygons of
    // the faces, with three faces at each corner: each runs once around its face, counterclockwise seen from outside.
    [[nodiscard]] bool wrap_polygons(std::span<const std::int64_t> offsets, std::span<const std::int32_t> vertices);
    // Returns the vertices of the last polygons, by corner.
    [[nodiscard]] std::span<const std::int32_t> vertices() const { return vertices_; }
    // Makes room for corners that are known: planes whose normals turn positively, a place, and a bound on its error.
    [[nodiscard]] std::span<Corner> begin_known(std::size_t count) {
        if (corners_.size() < count) corners_.resize(count);
        return std::span(corners_).first(count);
    }
    // Tries sure signs alone. Returns false where they do not settle it. The first corners may be known, and are taken
    // as they are; all others are proven to be corners of the polytope. Each edge of each corner has two ends. Those
    // between known corners come first.
    [[nodiscard]] bool wrap_surely(std::size_t known = 0);
    [[nodiscard]] std::span<const Edge> known_edges() const { return std::span(edges_).first(known_edges_); }
    // The last try met an edge without an end: planes are missing.
    [[nodiscard]] bool seems_open() const { return seems_open_; }
    [[nodiscard]] Shape wrap_exactly();
    [[nodiscard]] Shape wrap() { return wrap_surely() ? Shape::solid : wrap_exactly(); }

    [[nodiscard]] int planes() const { return static_cast<int>(names_.size()); }
    [[nodiscard]] const Name& name(int plane) const { return names_[at(plane)]; }
    [[nodiscard]] std::span<const Name> names() const { return names_; }
    [[nodiscard]] const PlaneArrays& arrays() const { return p_; }
    [[nodiscard]] std::span<const Corner> corners() const { return corners_; }
    // Empty if fans stand for them.
    [[nodiscard]] std::span<const Edge> edges() const { return edges_; }
    [[nodiscard]] std::size_t edge_count() const { return edges_.empty() ? 3 * fans_.size() / 2 : edges_.size(); }
    // Whether a face of the polytope lies in the plane.
    [[nodiscard]] bool has_face(int plane) const { return faces_[at(plane)] != 0; }
    // Returns all planes through a corner.
    [[nodiscard]] std::span<const int> through(int corner) const {
        return tight_.empty() ? std::span<const int>(corners_[at(corner)].planes) : tight_[at(corner)];
    }
    // Returns the outward normal of a plane, of length 1.
    [[nodiscard]] Vector3 unit_normal(int plane) const {
        const double inverse = p_.inverse[at(plane)];
        return {p_.nx[at(plane)] * inverse, p_.ny[at(plane)] * inverse, p_.nz[at(plane)] * inverse};
    }
    // The planes of Shape::repeated.
    [[nodiscard]] std::array<int, 2> repeated() const { return repeated_; }
    // Returns +1 if the corner lies strictly outside a plane, -1 if strictly inside, 0 if on it.
    [[nodiscard]] int side(int corner, const Name& name);
    struct Extent {  // of the corners: squared distances from the seed, the largest error
        double nearest = infinity, farthest = 0, error = 0;
        // Returns a bound on the distances.
        [[nodiscard]] double reach() const;
    };
    [[nodiscard]] Extent extent() const;
    // Returns twice the vector areas of all faces, seen from the seed: four numbers each, of which three count.
    [[nodiscard]] std::span<const double> vector_areas(std::vector<double>& room) const {
        room.assign(4 * names_.size(), 0);
        loops_.add_areas(edges_, corners_.data(), {}, room.data());
        return room;
    }
    // Whether a plane surely lies farther from the seed than that.
    [[nodiscard]] static bool is_out_of_reach(const RoundedPlane& plane, double reach) {
        const double most = plane.length * reach;
        return plane.d - most > 0x1p-40 * (most + plane.size);
    }
    // Whether a rounded place surely lies outside of a plane. length: of the place.
    [[nodiscard]] bool is_surely_outside(const Vector3& place, double length, int plane) const {
        const RoundedPlane p{normal(plane), p_.d[at(plane)], p_.length[at(plane)], p_.size[at(plane)]};
        return dot(p.n, place) - p.d > doubt_of(p, length);
    }
    // Whether all corners surely lie inside the plane and not on it. reach: as above.
    [[nodiscard]] bool is_beyond(const RoundedPlane& plane, double reach) const;

    static constexpr double sharp = 0x1p-36;
    // Makes places of corners exact to rounding, where they may err by more than this part of their distance.
    void sharpen(double relative_error);
    void sharpen_corner(int corner, double relative_error) { sharpen(corners_[at(corner)], relative_error); }
    void measure(Measures& out, bool centroid = true) const;
    // The same, to these parts of the volume and of the surface, with as many digits as that takes.
    void measure_within(Measures& out, double of_volume, double of_surface, bool centroid);
    static constexpr double rounding_of_sums = 0x1p-46;  // for each plane

private:
    static std::size_t at(int k) { return static_cast<std::size_t>(k); }
    [[nodiscard]] Vector3 normal(int f) const { return {p_.nx[at(f)], p_.ny[at(f)], p_.nz[at(f)]}; }
    [[nodiscard]] const exact::Plane& source(int f);
    [[nodiscard]] bool is_exactly_inside(int corner, int plane);
    [[nodiscard]] Hit first_hit(const Vector3& from, const Vector3& along, int a, int b);
    void make_blocks();
    template <class Visit>
    void for_planes_near(const Corner& corner, const Visit& visit) const;
    [[nodiscard]] int guess_end(const Vector3& from, const Vector3& along, int a, int b);
    [[nodiscard]] bool guess_start(std::array<int, 3>& planes);
    [[nodiscard]] bool guess_from(int a, std::array<int, 3>& planes);
    void sharpen(Corner& corner, double relative_error);
    void measure_corners(Measures& out) const;
    template <class Real>
    void measure_in(Measures& out, double roundoff);
    [[nodiscard]] int place(int a, int b, int c, Corner& corner, std::vector<int>& through);
    [[nodiscard]] bool start_at(const std::array<int, 3>& guess);
    [[nodiscard]] bool find_start();
    template <class Visit>
    void for_sides(const Visit& visit) const;
    [[nodiscard]] int orientation(int a, int b, int c);
    [[nodiscard]] int end_of_edge(int from, int a, int b, int sign);
    [[nodiscard]] Shape find_faces();
    int corner_of(const Corner& corner, const std::vector<int>& through);

    const SeedPlanes& planes_;
    std::size_t seed_ = 0;
    double unit_ = 1;
    std::vector<Name> names_;
    const PlaneLoops& loops_ = plane_loops();
    PlaneArrays p_;
    std::vector<double> inverses_;       // of the distances of all planes from each corner found, see PlaneLoops
    std::vector<exact::Plane> sources_;  // made when needed
    std::vector<Corner> corners_;
    std::vector<Edge> edges_;
    std::size_t known_edges_ = 0;
    std::vector<std::uint8_t> faces_;
    // By planes a, b: the turn and the corner whose polygon in a goes on to b. Those of other turns are free.
    std::vector<std::uint32_t> pairs_;
    std::uint32_t pairs_turn_ = 0;
    static constexpr std::uint32_t pair_step = 1 << 12;  // from turn to turn
    struct Half {
        int corner, a, b;
    };
    std::vector<Half> waiting_;
    [[nodiscard]] bool take_known(std::size_t known, std::size_t& waiting, std::size_t& edges);
    std::vector<Fan> fans_;
    std::vector<std::int32_t> vertices_;
    // A hash table of vertices: the vertex (32 bits), the turn (20), the corner (12). Those of other turns are free.
    static constexpr std::uint64_t turn_unit = 1 << 12;
    static constexpr unsigned table_bits = 11;
    std::vector<std::uint64_t> table_;
    std::uint64_t table_turn_ = 0;
    [[nodiscard]] bool number_vertices(std::span<const std::int32_t> vertices, std::size_t count);
    [[nodiscard]] bool find_vertices(std::span<const std::int32_t> vertices, std::span<const std::int32_t> listed);
    void begin_table();
    // Returns the first place to look for a vertex, and the one after a place.
    static std::size_t place_of(std::uint32_t id) { return id * 0x9e3779b1u >> (32 - table_bits); }
    static std::size_t place_after(std::size_t h) { return (h + 1) & ((1 << table_bits) - 1); }
    // Whether an entry is that of another vertex. off: of the entry from the wanted vertex and turn.
    static bool is_other(std::uint64_t off) { return static_cast<std::uint32_t>(off) < turn_unit && off >= turn_unit; }
    std::vector<std::uint16_t> slots_;     // corners by place in the polygons
    std::vector<std::uint16_t> sides_;     // by place: its polygon, and the corners before and after it there
    std::vector<std::uint16_t> used_;      // sides of each corner
    std::vector<std::vector<int>> tight_;  // planes through each corner, ascending; empty if these are three each
    std::vector<int> crowded_;             // corners of many planes, which exact signs find slowly
    std::map<std::vector<int>, int> corner_through_;  // the corner, by these planes
    struct Block {
        Vector3 lower, upper;    // of normals
        double least_c;          // as above
        double length, size;     // the largest of its planes
        double far;              // bound on |n|^2 + |c|
        std::size_t begin, end;  // of its planes, in blocks_order_
    };
    std::vector<Block> blocks_;      // empty if planes are few
    std::vector<int> blocks_order_;  // planes
    struct Ray {                     // an edge, by all planes that hold it
        int from, to;
        std::vector<int> planes;
    };
    std::vector<Ray> rays_;
    std::array<int, 2> repeated_{};
    bool seems_open_ = false;
};

}  // namespace votess
