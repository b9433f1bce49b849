// The pieces of a cell in a mesh, as closed surfaces.
//
// A piece is bounded by polygons: the parts of triangles in the cell, and parts of its faces. Each side of a polygon is
// glued to one side of another polygon:
//     along an edge of the mesh      the parts of its two triangles
//     where a triangle meets a face  the part of the triangle, and one of the face
//     along an edge of the cell      one part of each of the two faces, where the winding number is not 0
// Which sides these are follows from the corners that CutCell decided; no positions are compared. So surfaces are
// closed, whatever rounding does. Parts of faces are traced around their sides.
//
// An edge of the cell is walked along from one end. Where it meets triangles, strands of it begin or end, as many as
// the winding number changes by. MeshSigns decides in which order. Triangles at one place first end strands, so that
// solids that only touch remain two pieces. Edges of several pairs of triangles are glued the same way, around the
// edge.
//
// Positions decide only nesting: to which part of a face a hole belongs, and to which piece a cavity.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/measure_unit.hpp"
#include "solid/cut_cell.hpp"
#include "solid/ear_clipping.hpp"
#include "votess/pieces.hpp"

namespace votess::solid {

// One for each thread.
class CellPieces {
public:
    CellPieces(const ClosedMesh& mesh, const MeasureUnit& unit) : mesh_(mesh), unit_(unit) {}

    // Appends the pieces of a cell, the largest first. meets_surface: as measured; else the whole cell counts `winding`
    // times. Offsets begin at 0 in `out`.
    void add(CutCell& cut, bool meets_surface, int winding, Pieces& out);

private:
    using Id = std::int32_t;
    struct Side {
        Id polygon;        // -1 until a loop of a face has one
        Id next;           // around the polygon
        Id partner = -1;   // glued to it, in the opposite direction
        Id place = -1;     // where it begins, of the cut cell
        Vector3 corner{};  // the same, relative to the apex
        Id face = -1;      // of the cell; -1 in a triangle
        Id vertex = -1;
        Id mesh_vertex = -1;  // at the corner
    };
    struct Polygon {
        Id triangle;  // of the mesh; -1 for a part of a face
        Id face;      // -1 for a part of a triangle
        Id surface = -1;
        double outline = 0;  // the area in the outline of a part of a face, negative where it faces inward
    };
    struct MeshEdge {
        Id low, high;
        bool reversed;
        Id side;
        double angle = 0;  // around the edge

        friend auto operator<=>(const MeshEdge&, const MeshEdge&) = default;
    };
    // Both sides of an edge of the cell between two ends, one in each face. `forward` begins where the other ends.
    struct End {
        Id crossing = -1;
        Id slot = -1, copy = 0;  // a vertex of the cell, and which of the strands there
    };
    struct Strand {
        End from, to;  // along the edge
        int sign;
    };
    struct Triangle {
        std::array<Id, 3> vertex;
        Id polygon;
    };
    struct Surface {
        double volume = 0;
        Vector3 moment{};  // volume times centroid, relative to the apex
        double sum = 0;    // of volumes, with those of cavities
        std::vector<Id> triangles;
        Id outer = -1;  // the surface that this cavity lies in
        bool dropped = false;
    };

    void add_triangles();
    void glue_mesh_edges();
    void glue_around(std::size_t begin, std::size_t end);
    void add_strands();
    void add_strand(const CutCell::Edge& edge, const Strand& strand);
    [[nodiscard]] std::vector<Id> crossings_of(const CutCell::Edge& edge);
    void link_triangles();
    void link_vertices();
    void find_loops();
    void group_loops(std::size_t begin, std::size_t end);
    void number_vertices();
    void cut_polygons();
    void cut_face(std::span<const Id> loops);
    void find_surfaces();
    void find_cavities();
    void write(Pieces& out);
    [[nodiscard]] double winding_in(const Surface& outer, const Surface& inner) const;
    [[nodiscard]] FlatCorner flat(Id face, const Vector3& place, Id id) const;
    [[nodiscard]] Id on_surface(const Triangle& triangle) const;
    [[nodiscard]] int sheets_before(Id polygon, const Vector3& place) const;
    void glue(Id a, Id b);
    [[nodiscard]] Side& side(Id s) { return sides_[static_cast<std::size_t>(s)]; }
    [[nodiscard]] const Side& side(Id s) const { return sides_[static_cast<std::size_t>(s)]; }
    [[nodiscard]] int winding_at(Id slot) const;

    const ClosedMesh& mesh_;
    MeasureUnit unit_;
    CutCell* cut_ = nullptr;
    bool meets_surface_ = false;
    int plain_winding_ = 0;
    std::vector<Side> sides_;
    std::vector<Polygon> polygons_;
    std::vector<Id> previous_;  // by side of a triangle
    std::vector<MeshEdge> mesh_edges_;
    // By crossing: the side that begins there in one face, and the side that ends there in the other.
    std::vector<Id> begins_, ends_;
    // By corner of a face and copy: the side that leaves it, the side that arrives.
    std::vector<Id> first_copy_, leaves_, arrives_;
    struct Loop {
        Id face, first;
        std::vector<FlatCorner> corners;  // ids: sides
        double area;
    };
    std::vector<Loop> loops_;
    std::vector<std::vector<FlatCorner>> polygon_loops_;
    EarClipping ears_;
    std::vector<Triangle> triangles_;
    std::vector<Vector3> places_;  // by vertex
    std::vector<Id> cut_places_;   // by vertex: of the cut cell
    std::vector<CutCell::Cone> cones_;
    std::vector<Id> mesh_vertices_;  // by vertex
    std::vector<Surface> surfaces_;
    std::vector<Id> new_vertex_;  // by vertex, in the current piece
};

}  // namespace votess::solid
