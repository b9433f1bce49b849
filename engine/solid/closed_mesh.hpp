// A closed triangle mesh as a domain: its checks, and a tree of boxes over its triangles.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/measure_unit.hpp"
#include "core/vector3.hpp"
#include "exact/predicate.hpp"
#include "votess/votess.hpp"

namespace votess::solid {

// Checks a mesh and copies it. Throws invalid_argument for one that does not bound a volume.
class ClosedMesh {
public:
    explicit ClosedMesh(const TriangleMesh& given);
    // Reads a surface that need not be closed or oriented alike. name: for messages.
    static ClosedMesh any_surface(const TriangleMesh& given, const std::string& name) { return {given, name}; }

    // Multiplies coordinates by a power of two, and makes the tree. Throws invalid_argument if that loses bits.
    void scale_by(double scale);

    // As given. height: of a prism along z, a power of two, whose area is returned; or 0.
    [[nodiscard]] double volume(double height = 0) const { return MeasureUnit(unit_, height).volume(volume_); }
    [[nodiscard]] std::uint64_t moved_vertices() const { return moved_; }
    [[nodiscard]] double moved_distance() const { return distance_; }       // the largest, as given
    [[nodiscard]] const Box& bounds() const { return bounds_; }             // as given
    [[nodiscard]] const Box& placed() const { return nodes_.front().box; }  // bounds after scale_by()
    [[nodiscard]] const std::vector<std::array<std::int32_t, 3>>& given() const { return given_; }  // triangles
    [[nodiscard]] std::size_t vertices() const { return vertices_.size(); }
    [[nodiscard]] const exact::Point& vertex(std::int32_t v) const { return vertices_[static_cast<std::size_t>(v)]; }

    struct Triangle {
        std::array<std::int32_t, 3> vertex;
        std::int32_t given;  // its index as given
        std::int8_t upward;  // sign of the z component of the normal
        // normal.x = offset on its plane, to rounding; 0 if the triangle is too thin for that.
        Vector3 normal;
        double offset;
    };
    // Those of three vertices, in the order of the tree. Their edges pair up as those of all triangles do.
    [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

    // Visits triangles whose boxes meet `box`, until visit(t) returns false. Passes over boxes with skip(box).
    template <class Visit>
    void for_each_in(const Box& box, Visit visit) const {
        for_each_in(box, visit, [](const Box&) { return false; });
    }
    template <class Visit, class Skip>
    void for_each_in(const Box& box, Visit visit, Skip skip) const {
        std::array<std::uint32_t, max_depth> pending{0};
        for (std::size_t count = nodes_.empty() ? 0 : 1; count > 0;) {
            const Node& node = nodes_[pending[--count]];
            if (!overlap(node.box, box) || skip(node.box)) continue;
            if (node.count == 0) {
                pending[count++] = node.first;
                pending[count++] = node.first + 1;
                continue;
            }
            for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
                if (overlap(boxes_[t], box) && !skip(boxes_[t]) && !visit(t)) return;
        }
    }
    // Returns whether a triangle may come within `distance` of x. Never misses one.
    [[nodiscard]] bool any_near(const exact::Point& x, double distance) const;

private:
    // Checks and merges, without the demand that the mesh bounds a volume.
    ClosedMesh(const TriangleMesh& given, std::string name);
    [[noreturn]] void refuse(const std::string& message) const;
    static constexpr std::size_t max_depth = 96;
    struct Node {
        Box box;
        std::uint32_t first = 0, count = 0;  // triangles; count 0: the first of two children
    };
    [[nodiscard]] static bool overlap(const Box& a, const Box& b) {
        return a.lower[0] <= b.upper[0] && b.lower[0] <= a.upper[0] && a.lower[1] <= b.upper[1] &&
               b.lower[1] <= a.upper[1] && a.lower[2] <= b.upper[2] && b.lower[2] <= a.upper[2];
    }
    void merge_vertices(double tolerance);
    void find_bounds();
    [[nodiscard]] std::string between(std::int32_t a, std::int32_t b, const char* word) const;
    void check_closed() const;
    void find_volume();
    // Return the volume in units.
    [[nodiscard]] double long_volume() const;
    [[nodiscard]] double exact_volume() const;
    void make_tree();
    void split(std::uint32_t node, std::uint32_t begin, std::uint32_t end, std::vector<std::uint32_t>& order,
               const std::vector<Box>& boxes);

    std::string name_;
    std::vector<exact::Point> vertices_;
    std::vector<std::array<std::int32_t, 3>> given_;
    std::vector<Triangle> triangles_;
    std::vector<Box> boxes_;  // of triangles
    std::vector<Node> nodes_;
    Box bounds_;
    double volume_ = 0, unit_ = 1;  // in units of a power of two; its length
    bool merged_ = false;
    std::uint64_t moved_ = 0;
    double distance_ = 0;
};

// The arrays of a mesh, as given except that vertices may have been merged.
struct MeshArrays {
    MeshArrays(const ClosedMesh& mesh, double scale) {
        for (std::size_t v = 0; v < mesh.vertices(); ++v)
            for (const double x : mesh.vertex(static_cast<std::int32_t>(v))) vertices.push_back(x / scale);
        for (const auto& triangle : mesh.given()) triangles.insert(triangles.end(), triangle.begin(), triangle.end());
    }
    [[nodiscard]] TriangleMesh view() const { return {vertices, triangles}; }

    std::vector<double> vertices;
    std::vector<std::int32_t> triangles;
};

}  // namespace votess::solid
