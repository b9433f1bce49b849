// The faces of all cells, each once, as solvers and meshers number them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "core/vector3.hpp"
#include "files/mesh.hpp"
#include "votess/votess.hpp"

namespace votess::files {

struct SharedFace {
    std::int32_t owner;     // a cell of SharedMesh
    std::int32_t neighbor;  // greater than the owner; -1 on the boundary
};

// Faces of the boundary that follow each other.
struct Patch {
    std::int32_t wall;                 // -1, -2, ...; 0 at a periodic boundary
    std::array<std::int8_t, 3> shift;  // of the cells behind it
    std::size_t first, count;          // faces
    std::size_t twin;                  // the patch with the same faces on the other side; itself at a wall

    // Returns xmin to zmax, wall7 and on, open for faces of cells that were left out, periodic_1_0_0, or one of
    // Mesh::patches.
    [[nodiscard]] std::string name(const Mesh& mesh) const;
};

struct SharedMesh {
    // Collapses edges below Mesh::min_edge, and calls Mesh::measure. Throws invalid_argument for cells that are not
    // closed, and for a face that the cell behind it lacks.
    explicit SharedMesh(const Mesh& mesh);

    [[nodiscard]] std::size_t cells() const { return rows.size(); }
    [[nodiscard]] std::size_t inner() const { return patches.empty() ? faces.size() : patches.front().first; }
    [[nodiscard]] std::span<const std::int32_t> polygon(std::size_t face) const {
        return std::span(corners).subspan(static_cast<std::size_t>(offsets[face]),
                                          static_cast<std::size_t>(offsets[face + 1] - offsets[face]));
    }
    [[nodiscard]] Vector3 vertex(std::int32_t v) const {
        const double* const x = &vertices[3 * static_cast<std::size_t>(v)];
        return {x[0], x[1], x[2]};
    }
    // Returns how far the cells behind a periodic boundary are from their places.
    [[nodiscard]] Vector3 separation(const Patch& patch) const;
    // Numbers the remaining vertices again.
    void drop_unused_vertices();

    std::vector<std::size_t> rows;     // of the cells: those with faces
    std::vector<double> vertices;      // 3 each: those of the cells
    std::vector<Vector3> normals;      // of the faces before edges were collapsed, of any length; else empty
    std::vector<std::uint8_t> moved;   // of the vertices: 1 for one that others joined
    std::uint64_t short_edges = 0;     // those below Mesh::min_edge that cannot be collapsed
    std::vector<std::int32_t> planes;  // of the faces: Mesh::planes, else the wall
    std::vector<SharedFace> faces;     // inner ones ascend by owner, then by neighbor; then patch by patch
    std::vector<std::int64_t> offsets{0};
    std::vector<std::int32_t> corners;  // of the faces, counterclockwise seen from outside of the owner
    std::vector<Patch> patches;         // walls from -1 on, then periodic boundaries in pairs
    std::array<double, 9> edges;        // vectors of the domain

private:
    void add_face(const Mesh& mesh, std::size_t entry, std::int32_t owner, std::int32_t neighbor);
    void turn_last_face(const Mesh& mesh, std::span<const std::int32_t> front, const Vector3& apart);
};

// The edges of all faces, each once.
struct SharedEdges {
    explicit SharedEdges(const SharedMesh& mesh);

    std::vector<std::array<std::int32_t, 2>> ends;  // the lower vertex first
    // Of each corner of SharedMesh: the edge to the next corner, from 1 on; negative if it leads to the lower vertex.
    std::vector<std::int32_t> of_corners;
};

// The faces of each cell, from 1 on; negative if the cell is not the owner.
class CellFaces {
public:
    explicit CellFaces(const SharedMesh& mesh);

    [[nodiscard]] std::span<const std::int32_t> of(std::size_t cell) const {
        return std::span(faces_).subspan(begins_[cell], begins_[cell + 1] - begins_[cell]);
    }

private:
    std::vector<std::size_t> begins_;
    std::vector<std::int32_t> faces_;
};

// Returns the corner of each face where a fan of triangles begins that cuts it well. Both sides of a periodic boundary
// have the same triangles.
[[nodiscard]] std::vector<std::size_t> apexes(const SharedMesh& mesh);

// Returns the least cosine between a direction and the normals of the triangles around a corner.
[[nodiscard]] double worst_cosine(const SharedMesh& mesh, std::span<const std::int32_t> polygon, std::size_t apex,
                                  const Vector3& direction);
inline constexpr double flat_fan = 0.5;  // cosine of 60 degrees: then no part folds onto another face

// Makes one vertex of the ends of each edge below this length, if all cells stay polyhedra and no volume changes by
// more than half. Returns the number of the edges that stay.
std::uint64_t collapse_edges(SharedMesh& mesh, double length);

// Measures of the mesh, as votess_mesh_quality.
struct MeshQuality {
    double max_non_orthogonality = 0, mean_non_orthogonality = 0;
    std::uint64_t severe_faces = 0;
    double max_skewness = 0;
    std::uint64_t skew_faces = 0;
    double min_area = 0, min_volume = 0, min_edge = 0;
    std::uint64_t wrong_faces = 0, wrong_cells = 0;
};
[[nodiscard]] MeshQuality measure(const SharedMesh& mesh);

// Sums over the triangles between a polygon's corners and their mean, as OpenFOAM measures faces.
struct FaceMeasure {
    Vector3 area{};  // along the normal
    Vector3 center{};
};
[[nodiscard]] FaceMeasure measure_face(const SharedMesh& mesh, std::size_t face);

}  // namespace votess::files
