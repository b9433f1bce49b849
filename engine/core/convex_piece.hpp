// A convex polyhedron in floating point, cut plane by plane: for volumes of pieces, where a sign that rounding decides
// changes a volume by no more than rounding.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/vector3.hpp"

namespace votess {

// Its surface stays closed whatever rounding does to corners near a plane: an edge has the same ends in both of its
// polygons, so the two sides of a cut add up to the whole.
class ConvexPiece {
public:
    using Vector = Vector3;

    void clear();
    // The polyhedron is bounded by polygons, counterclockwise seen from outside.
    void add_polygon(std::span<const Vector> corners);
    void add_box(const Vector& lower, const Vector& upper);
    // Becomes a copy of the polyhedron, without its scratch.
    void assign(const ConvexPiece& other) { surface_ = other.surface_; }
    [[nodiscard]] bool empty() const { return surface_.ends.empty(); }

    // Keeps what lies where n.x <= h. False when that is nothing.
    bool cut(const Vector& n, double h);
    // Keeps what lies where n.x >= h; `below` becomes the rest.
    void split(const Vector& n, double h, ConvexPiece& below);

    struct Measure {
        double volume = 0;
        Vector moment{};  // the integral of x
    };
    // The surface is that of triangles around one corner of each polygon, by its number: another corner shows how much
    // it matters that polygons of rounded corners are not planar.
    [[nodiscard]] Measure measure(std::size_t corner = 0) const;
    [[nodiscard]] double volume(std::size_t corner = 0) const { return measure(corner).volume; }
    // Returns the least and the largest n.x of a polyhedron that is not empty.
    [[nodiscard]] std::pair<double, double> extent(const Vector& n) const;
    // A ball that holds all corners.
    struct Ball {
        Vector center{};
        double radius = 0;
    };
    [[nodiscard]] Ball ball() const;
    // Polygon f, of polygons().
    [[nodiscard]] std::size_t polygons() const { return surface_.ends.size(); }
    [[nodiscard]] std::span<const Vector> polygon(std::size_t f) const {
        const std::size_t begin = f == 0 ? 0 : surface_.ends[f - 1];
        return std::span(surface_.corners).subspan(begin, surface_.ends[f] - begin);
    }

private:
    struct Surface {
        std::vector<Vector> corners;    // of all polygons, one after the other
        std::vector<std::size_t> ends;  // by polygon
        void clear();
        void end_polygon();
    };
    struct Edge {
        Vector from, to;
    };
    // Whether any corner lies strictly on a side.
    struct Sides {
        bool within = false, beyond = false;
    };
    [[nodiscard]] Sides sides() const;
    void clip_half(double side, Surface& half);
    void close_rim(Surface& half);

    Surface surface_;
    Surface kept_;                // scratch
    std::vector<double> beyond_;  // by corner: how far it lies beyond the plane
    std::vector<Edge> rim_;       // of the polygons that close a half
};

}  // namespace votess
