// One cell, clipped by the surface of a mesh.
//
// The cell is convex, so the part of a triangle in it is a convex polygon. A list of its edges describes it: edges of
// the triangle, and planes of the cell. Clipping it by a plane needs the side of each corner, which MeshSigns decides.
// A corner on two planes is where an edge of the cell passes through the mesh. The winding number changes there by one.
// It starts from one vertex of the cell, where a ray counts the triangles above.
//
// Measures are sums of cones from a point in the cell. Their bases are the triangles' polygons, and the faces of the
// cell, weighted by the winding number. A face is a sum of triangles: over segments of its edges, weighted by the
// winding number beside them; and over the edges that polygons have on it.
//
// A triangle in the plane of a face bounds one of its two cells, and ties may put it into the other. Such a face is
// overlaid with its triangles, which gives the winding numbers on both sides of each place.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "domain/domain.hpp"
#include "polytope/cell.hpp"
#include "solid/closed_mesh.hpp"
#include "solid/layers.hpp"
#include "solid/mesh_signs.hpp"
#include "solid/sum.hpp"

namespace votess::solid {

// Measures of a cell's part in the mesh. Scaled; weighted by the winding number.
struct CutMeasures {
    bool meets_surface = false;           // else only `winding` is set
    int winding = 0;                      // of a vertex
    double volume = 0, volume_error = 0;  // after ties a bound on its rounding, else 0
    std::array<double, 3> centroid{};     // relative to the seed
    double surface = 0;                   // area of the mesh in the cell, with the triangles on its faces that bound it
    struct Face {
        std::int32_t id;
        exact::Shift shift;
        double area = 0;   // inside the mesh on both sides, not negative
        double error = 0;  // after ties a bound on its rounding, else 0
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
    // ties: the same for all cells whose measures must fit together.
    void begin(const exact::Point& seed, std::int32_t id, const exact::Shift& move, double weight,
               MeshSigns::Ties ties = MeshSigns::Ties::moved);
    // neighbor: its bisector, as seen from the seed where it was given. shift: of the neighbor in the row.
    // inward: twice the distance by which the plane moves inward, times the distance of the neighbor.
    void add(std::int32_t id, const exact::Plane& neighbor, const exact::Shift& shift, double weight,
             double inward = 0);
    // Whether the planes leave nothing.
    [[nodiscard]] bool empty() const { return cell_.empty(); }
    const CutMeasures& measure();
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
        double at;  // from 0 to 1 along the edge
        int jump;   // of the winding number
        std::int32_t next;
        std::int32_t polygon = -1;
    };
    // Edges of a polygon: -1 to -3 are those of the triangle, the others faces.
    using Side = std::int32_t;
    struct Corner {
        Side in, out;
    };
    struct Segment {
        std::int32_t face;
        Vector3 from, to;
        int weight = 1;
    };
    // A triangle in the plane of a face. Ties put it into this cell or into the neighbor.
    struct OnFace {
        std::int32_t face;
        std::int32_t given;  // the triangle's index
        std::array<Vector3, 3> corners;
        bool in_cell, faces_out;
    };

    void read_faces();
    void add_half(std::int32_t from, std::int32_t to, std::int32_t face);
    void find_candidates();
    [[nodiscard]] std::size_t see(std::int32_t vertex);
    void decide(std::size_t seen);
    [[nodiscard]] bool clip(const ClosedMesh::Triangle& triangle);
    [[nodiscard]] bool clip_by(std::size_t face);
    [[nodiscard]] bool beside(const ClosedMesh::Triangle& triangle) const;
    [[nodiscard]] int side(const Corner& corner, std::size_t face);
    [[nodiscard]] Vector3 position(const Corner& corner, const ClosedMesh::Triangle& triangle);
    void add_polygon(std::uint32_t t);
    void find_windings();
    [[nodiscard]] int winding_at(std::int32_t slot);
    void add_on_face(std::int32_t given);
    void add_faces();
    void share_face(std::int32_t face);
    void add_cone(const Vector3& a, const Vector3& b, const Vector3& c, double weight);
    [[nodiscard]] std::int32_t& edge_of(std::int32_t left, std::int32_t right) {
        return edge_between_[static_cast<std::size_t>(left) * faces_.size() + static_cast<std::size_t>(right)];
    }

    const ClosedMesh& mesh_;
    const Domain& domain_;
    bool centroids_;
    double weight_ = 0;
    MeshSigns::Ties ties_ = MeshSigns::Ties::moved;
    cpu::Cell cell_;
    exact::Plane image_;     // of the seed, where the cell is, as if it were a bisector's
    exact::Point origin_{};  // the same place, rounded
    cpu::CellFaces faces_;
    MeshSigns signs_, corner_signs_;  // of all bisectors; of those of one vertex
    CutMeasures out_;
    Vector3 apex_{};                    // of cones, relative to the seed
    std::vector<std::int32_t> plane_;   // by face: of signs_, -1 for walls
    std::vector<Vector3> base_, unit_;  // by face: a point on it, its outward unit normal
    std::vector<Vector3> at_;           // by slot, relative to the apex
    std::vector<int> winding_;          // by slot
    std::vector<std::uint8_t> known_;   // by slot
    std::vector<std::int32_t> slots_;   // of vertices
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
    };
    struct PolygonSide {
        Side side;
        std::int32_t crossing;  // at the corner; -1 off the edges of the cell
        Vector3 corner;
    };
    std::vector<Polygon> polygons_;
    std::vector<PolygonSide> polygon_sides_;
    std::vector<Vector3> corners_;  // of a polygon
    std::vector<OnFace> on_faces_;
    std::vector<std::uint8_t> has_triangles_;  // by face
    std::vector<Segment> outlines_;            // of the parts in the mesh, on faces with triangles
    Layers layers_;
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
    Sum sum_volume_, sum_surface_;
    double sum_area_ = 0;
    double place_error_ = 0;  // of any position
    std::array<Sum, 3> sum_moment_;

    // The current triangle.
    std::int32_t face_of_triangle_ = -1;  // whose plane holds it
    MeshSigns::Places places_;
    std::vector<MeshSigns::Values> values_;  // by face, of those that cut it or hold it
    std::vector<Side> sides_, clipped_;
    std::vector<int> outside_;
};

}  // namespace votess::solid
