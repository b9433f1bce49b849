// The mesh of --mesh: triangles from .off, .obj, .stl, .ply or .glb, polygons of the plane from .geojson
// and .geojsonl.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <votess/votess.hpp>

namespace clvotess {

struct Surface {
    std::vector<double> vertices;         // 3 each; of polygons 2
    std::vector<std::int32_t> triangles;  // 3 vertices each, from 0; of polygons edges, with the inside on their left
    bool merge = false;                   // vertices at equal places are one
    double tolerance = 0;                 // see votess::TriangleMesh::tolerance
    bool planar = false;                  // polygons

    [[nodiscard]] votess::TriangleMesh view() const { return {vertices, triangles, merge, tolerance}; }
};

// Takes the vertices and faces of a file, in any order.
class SurfaceBuilder {
public:
    // name: for messages. first: the number of the first vertex and face in the file.
    explicit SurfaceBuilder(std::string name, std::int64_t first = 0) : name_(std::move(name)), first_(first) {}

    void add_vertex(double x, double y, double z) { surface_.vertices.insert(surface_.vertices.end(), {x, y, z}); }
    void set_vertices(std::vector<double> vertices) { surface_.vertices = std::move(vertices); }
    [[nodiscard]] std::int64_t vertices() const { return static_cast<std::int64_t>(surface_.vertices.size() / 3); }
    // Adds a polygon. Corners are vertices from 0. Throws Failure.
    void add_face(std::span<const std::int64_t> corners);
    // Returns the mesh, with polygons cut into triangles. Throws Failure if a face names a vertex that was not added,
    // is not simple or not flat.
    [[nodiscard]] Surface finish();

private:
    [[nodiscard]] std::string face_text(std::int64_t face) const;

    std::string name_;
    std::int64_t first_;
    Surface surface_;
    std::vector<std::int32_t> corners_;  // of all faces
    std::vector<std::int64_t> offsets_{0};
    std::int64_t max_vertex_ = -1, face_of_max_ = 0;  // of all faces
};

// Returns whether the file holds polygons of the plane, by its extension. Throws Failure for an unknown one.
[[nodiscard]] bool holds_polygons(const std::string& option, const std::string& path);
// Returns the mesh of a file with one of these extensions. Throws Failure.
[[nodiscard]] Surface read_surface(const std::string& option, const std::string& path);

// The readers of the formats. Messages begin with `name:`, or `name:line:` where there are lines. They throw Failure.
[[nodiscard]] Surface parse_off(std::string_view text, const std::string& name);
[[nodiscard]] Surface parse_obj(std::string_view text, const std::string& name);
// The format has no indices, so each corner is a vertex, and those at equal places are to be one.
[[nodiscard]] Surface parse_stl(std::string_view bytes, const std::string& name);
[[nodiscard]] Surface parse_ply_surface(std::string_view bytes, const std::string& name);
// Corners with other normals or colors are other vertices, so those at equal places are to be one. z is up.
[[nodiscard]] Surface parse_glb(std::string_view bytes, const std::string& name);
// Polygons of geometries, features and collections. Outlines and holes may run in any direction.
[[nodiscard]] Surface parse_geojson(std::string_view text, const std::string& name);
// GeoJSON texts, each on a line, or each after the record separator of RFC 8142.
[[nodiscard]] Surface parse_geojson_sequence(std::string_view text, const std::string& name);

}  // namespace clvotess
