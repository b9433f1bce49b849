// A convex polyhedron in floating point, cut plane by plane, for the volumes of pieces. A sign that rounding decides
// changes a volume by no more than rounding.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/vector3.hpp"

namespace votess {

// The surface stays closed whatever rounding does to corners near a plane, because an edge has the same ends in both of
// its polygons. So the two sides of a cut add up to the whole.
class ConvexPiece {
public:
    using Vector = Vector3;

    void clear();
    // Adds a bounding polygon, counterclockwise seen from outside.
    void add_polygon(std::span<const Vector> corners);
    // Copies all but the scratch.
    void assign(const ConvexPiece& other) { surface_ = other.surface_; }
    [[nodiscard]] bool empty() const { return surface_.ends.empty(); }

    // Keeps the part where n.x <= h. Returns false if it is empty.
    bool cut(const Vector& n, double h);
    // Keeps the part where n.x >= h. `below` becomes the rest.
    void split(const Vector& n, double h, ConvexPiece& below);

    struct Measure {
        double volume = 0;
        Vector moment{};  // the integral of x
    };
    // Measures the surface of triangles around the given corner of each polygon. Polygons of rounded corners are not
    // planar; another corner shows how much that matters.
    [[nodiscard]] Measure measure(std::size_t corner = 0) const;
    [[nodiscard]] double volume(std::size_t corner = 0) const { return measure(corner).volume; }
    // Returns the smallest and the largest n.x. Not for an empty polyhedron.
    [[nodiscard]] std::pair<double, double> extent(const Vector& n) const;
    // A ball that holds all corners.
    struct Ball {
        Vector center{};
        double radius = 0;
    };
    [[nodiscard]] Ball ball() const;
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
    struct Sides {
        bool within = false, beyond = false;
    };
    [[nodiscard]] Sides sides() const;
    void clip_half(double side, Surface& half);
    void close_rim(Surface& half);

    Surface surface_;
    Surface kept_;                // scratch
    std::vector<double> beyond_;  // by corner: distance beyond the plane, times |n|
    std::vector<Edge> rim_;       // of the polygons that close a half
};

}  // namespace votess
