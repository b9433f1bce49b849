// One cell, clipped by the surface of a mesh.
//
// The cell is convex, so the part of a triangle in it is a convex polygon. A list of its edges describes it: edges of
// the triangle, and planes of the cell. Clipping it by a plane needs the side of each corner, which MeshSigns decides.
// A corner on two planes is where an edge of the cell passes through the mesh. The winding number changes there by one.
// It starts from one vertex of the cell, where a ray counts the triangles above.
//
// So signs alone decide which polygons there are. Ties shrink the cell, so that a triangle that only touches it has no
// polygon. A cell without polygons and winding number is empty. A triangle in the plane of a face bounds one of its two
// cells. Such a face is overlaid with its triangles, which gives the winding numbers on both sides of each place.
//
// Measures are sums of cones from an apex near a corner of the part. Their bases are the triangles' polygons, and the
// faces of the cell, weighted by the winding number. A face is a sum of triangles: over segments of its edges, weighted
// by the winding number beside them; and over the edges that polygons have on it.
//
// Positions. Each corner is computed in double with a bound on its error. Where that exceeds `place_rounding` of the
// part's extent, the corner is rounded from its exact value (ExactPlaces). Moving all corners by at most d changes a
// volume by at most d times the area of its surface. Where this bound exceeds `volume_rounding` of the volume, as in a
// sliver, the sum is done in 128 bits from exact corners, and then in fractions. A face that is smaller than the bound
// on its area is laid over without rounding (ExactLayers): it exists, or has no area.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/sum.hpp"
#include "domain/domain.hpp"
#include "polytope/cell.hpp"
#include "solid/closed_mesh.hpp"
#include "solid/exact_layers.hpp"
#include "solid/exact_places.hpp"
#include "solid/layers.hpp"
#include "solid/mesh_signs.hpp"

namespace votess::solid {

// Measures of a cell's part in the mesh. Scaled; weighted by the winding number.
struct CutMeasures {
    bool meets_surface = false;  // else only `winding` is set
    int winding = 0;             // of a vertex; 0 where the planes leave nothing
    bool empty = false;          // the part has no volume
    double volume = 0;
    std::array<double, 3> centroid{};  // relative to the seed
    double surface = 0;                // area of the mesh in the cell, with the triangles on its faces that bound it
    struct Face {
        std::int32_t id;
        exact::Shift shift;
        double area = 0;         // inside the mesh on both sides; 0 only if it does not exist
        bool is_unsure = false;  // may not exist; not if measured with `decide_faces`
    };
    std::vector<Face> faces;  // bisectors only
};

// One for each thread.
class CutCell {
public:
    // centroids: whether measure() finds them.
    CutCell(const ClosedMesh& mesh, const Domain& domain, bool centroids)
        : mesh_(mesh), domain_(domain), centroids_(centroids) {}

    // Begins the cell of a seed, moved by a shift; add() all its neighbors, then call measure().
    void begin(const exact::Point& seed, std::int32_t id, const exact::Shift& move, double weight);
    // neighbor: its bisector, as seen from the seed where it was given. shift: of the neighbor in the row.
    // inward: twice the distance by which the plane moves inward, times the distance of the neighbor.
    void add(std::int32_t id, const exact::Plane& neighbor, const exact::Shift& shift, double weight,
             double inward = 0);
    // Whether the planes leave nothing.
    [[nodiscard]] bool empty() const { return cell_.empty(); }
    // decide_faces: whether it finds out which faces exist at all; slower.
    const CutMeasures& measure(bool decide_faces = false);
    // Finds the faces without a measure, for a cell that no triangle passes through.
    void find_faces();

private:
    friend class CellPieces;

    struct Edge {
        std::int32_t from, to;     // slots of vertices
        std::int32_t left, right;  // faces: counterclockwise around the left one
        std::int32_t first = -1;   // crossing
    };
    // A side of a face, which has no edge yet.
    struct Half {
        std::int32_t to, face;
        std::int32_t next;  // from the same vertex
    };
    struct Crossing {
        std::int32_t place;  // of the corner
        int jump;            // of the winding number
        std::int32_t next;
        std::int32_t polygon = -1;
    };
    // Edges of a polygon: -1 to -3 are those of the triangle, the others faces.
    using Side = std::int32_t;
    struct Corner {
        Side in, out;
    };
    // The place of a corner, and how it comes about.
    struct Place {
        enum class Kind : std::uint8_t { vertex, mesh_vertex, on_mesh_edge, on_edge };
        Kind kind;
        // vertex: its slot; mesh_vertex: its index; on_mesh_edge: a face and two vertices of the mesh;
        // on_edge: two faces and a triangle
        std::array<std::int32_t, 3> of;
        Vector3 x;             // relative to the seed in a first step, then to the apex
        double error;          // bound, of each coordinate
        bool is_used = false;  // by the part
    };
    struct Segment {
        std::int32_t face;
        std::int32_t from, to;  // places
        int weight = 1;
    };
    // A triangle in the plane of a face. Ties put it into this cell or into the neighbor.
    struct OnFace {
        std::int32_t face;
        std::int32_t given;                  // the triangle's index
        std::array<std::int32_t, 3> places;  // of its corners
        bool in_cell, faces_out;
    };
    void make_faces();
    void read_faces();
    void add_half(std::int32_t from, std::int32_t to, std::int32_t face);
    void find_candidates();
    [[nodiscard]] std::size_t see(std::int32_t vertex);
    void decide(std::size_t seen);
    [[nodiscard]] bool clip(const ClosedMesh::Triangle& triangle);
    [[nodiscard]] bool clip_by(std::size_t face);
    [[nodiscard]] bool beside(const ClosedMesh::Triangle& triangle) const;
    [[nodiscard]] int side(const Corner& corner, std::size_t face);
    [[nodiscard]] std::int32_t add_place(const Place& place) {
        place_.push_back(place);
        return static_cast<std::int32_t>(place_.size()) - 1;
    }
    [[nodiscard]] std::int32_t add_mesh_vertex(std::int32_t vertex, const Vector3& relative);
    [[nodiscard]] std::int32_t place_of(const Corner& corner, std::uint32_t t);
    [[nodiscard]] Place on_mesh_edge(std::size_t from, std::size_t to, std::size_t face,
                                     const ClosedMesh::Triangle& triangle) const;
    [[nodiscard]] Place on_edge(const Edge& edge, std::uint32_t t) const;
    [[nodiscard]] const Vector3& at(std::int32_t place) const { return place_[static_cast<std::size_t>(place)].x; }
    [[nodiscard]] double error_of(std::int32_t place) const { return place_[static_cast<std::size_t>(place)].error; }
    void find_places();
    void find_apex();
    void measure_places();
    void prepare_exact(const Vector3& origin);
    [[nodiscard]] Vector3 rounded(const ExactPlace& place) const;
    [[nodiscard]] ExactPlace exact_place(const Place& place) const;
    void add_polygon(std::uint32_t t);
    void find_windings();
    [[nodiscard]] int winding_at(std::int32_t slot);
    void add_on_face(const ClosedMesh::Triangle& triangle);
    void find_segments();
    void measure_faces(bool decide);
    struct Shared {
        double area = 0, surface = 0;
    };
    [[nodiscard]] Shared lay_over(std::int32_t face, bool exactly);
    // inside: beyond the triangles.
    enum class Outline : std::uint8_t { whole, inside, triangles, triangles_out };

    // Visits the edges of a face, of its parts in the mesh, and of triangles in its plane: two places, layer, weight.
    template <class Visit>
    void for_each_outline(std::int32_t face, Visit visit) const;
    // The base of a cone: three places. face: -1 for triangles of the mesh, absent for those in a face.
    struct Cone {
        std::int32_t a, b, c;
        int weight;
        std::int32_t face;
    };
    struct ConeSum {
        bool empty = false;
        double volume = 0;
        Vector3 centroid{};  // relative to the apex
    };
    void find_cones();
    // Sums cones: in double, from exact places in 128 bits, or in fractions, until 1e-10 of the volume is sure.
    [[nodiscard]] ConeSum sum(std::span<const Cone> cones);
    [[nodiscard]] ConeSum sum_exactly(std::span<const Cone> cones);
    [[nodiscard]] ConeSum sum_in_fractions(std::span<const Cone> cones) const;
    void find_quads();
    [[nodiscard]] double sure_area(std::int32_t face);
    void measure_areas();
    void measure_areas_in_quad();
    [[nodiscard]] std::int32_t& edge_of(std::int32_t left, std::int32_t right) {
        return edge_between_[static_cast<std::size_t>(left) * faces_.size() + static_cast<std::size_t>(right)];
    }

    const ClosedMesh& mesh_;
    const Domain& domain_;
    bool centroids_;
    double weight_ = 0;
    cpu::Cell cell_;
    exact::Plane image_;     // of the seed, where the cell is, as if it were a bisector's
    exact::Point origin_{};  // the same place, rounded
    cpu::CellFaces faces_;
    MeshSigns signs_, corner_signs_;  // of all bisectors; of those of one vertex
    CutMeasures out_;
    Vector3 apex_{};                     // of cones, relative to the seed
    std::vector<std::int32_t> plane_;    // by face: of signs_, -1 for walls
    std::vector<Vector3> unit_;          // by face: its outward unit normal
    std::vector<std::int32_t> base_;     // by face: a place on it, where its triangles begin; -1 if it has none
    std::vector<Place> place_;           // of all corners
    std::vector<std::int32_t> at_slot_;  // by slot: its place
    std::vector<int> winding_;           // by slot
    std::vector<std::uint8_t> known_;    // by slot
    std::vector<std::int32_t> slots_;    // of vertices
    std::vector<Half> halves_;
    std::vector<std::int32_t> first_half_;  // by slot
    std::vector<Edge> edges_;
    std::vector<std::int32_t> pending_;       // edges
    std::vector<std::int32_t> edge_between_;  // by left and right face
    std::vector<Crossing> crossings_;
    std::vector<Segment> segments_;
    // The parts of triangles in the cell, one after the other. Side i leads from corner i.
    struct Polygon {
        std::uint32_t triangle;  // of mesh_
        std::int32_t begin;
        bool on_face;  // lies in a face
    };
    struct PolygonSide {
        Side side;
        std::int32_t crossing;  // at the corner; -1 off the edges of the cell
        std::int32_t place;     // of the corner
    };
    std::vector<Polygon> polygons_;
    std::vector<PolygonSide> polygon_sides_;
    std::vector<OnFace> on_faces_;
    std::vector<std::uint8_t> has_triangles_;  // by face
    Layers layers_;
    ExactLayers exact_layers_;
    ExactPlaces exact_;
    bool exact_is_ready_ = false;
    std::vector<std::uint32_t> candidates_;

    // A vertex of the mesh, seen from all faces. Its values are in vertex_values_. Its outside_bits_ are those of faces
    // that it lies outside of.
    struct SeenVertex {
        std::int32_t vertex;
        int unsure;         // faces whose sign is unknown
        bool tied = false;  // a value is 0
        MeshSigns::Place place;
    };
    std::vector<SeenVertex> seen_;
    std::vector<std::int32_t> seen_table_;         // a hash table of them, -1 where it is free
    std::vector<MeshSigns::Value> vertex_values_;  // may be longer
    std::vector<std::uint64_t> outside_bits_;
    std::size_t words_ = 0;  // of outside_bits_ for each vertex
    std::vector<Crossing> on_edge_;
    Sum sum_surface_;
    double whole_ = 0;  // about the surface of the part
    std::vector<Cone> cones_;
    std::vector<std::array<exact::Quad, 3>> quads_;  // by place: of those that are used
    double place_error_ = 0;                         // bound, of any position of the part
    double extent_ = 0;                              // of the part, from the apex
    std::vector<double> area_error_;                 // by face

    // The current triangle.
    std::int32_t face_of_triangle_ = -1;  // whose plane holds it
    MeshSigns::Places places_;
    std::vector<MeshSigns::Values> values_;  // by face, of those that cut it or hold it
    std::vector<Side> sides_, clipped_;
    std::vector<int> outside_;
};

}  // namespace votess::solid
