// A convex polyhedron in floating point, cut plane by plane: for volumes of pieces, where a sign that rounding decides
// changes a volume by no more than rounding.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vector3.hpp"

namespace votess {

class ConvexPiece {
public:
    using Vector = Vector3;

    void clear();
    // The polyhedron is bounded by polygons, counterclockwise seen from outside.
    void add_polygon(std::span<const Vector> corners);
    void add_box(const Vector& lower, const Vector& upper);
    [[nodiscard]] bool empty() const { return ends_.empty(); }

    // Keeps what lies where n.x <= h. False when that is nothing.
    bool cut(const Vector& n, double h);

    struct Measure {
        double volume = 0;
        Vector moment{};  // the integral of x
    };
    [[nodiscard]] Measure measure() const;
    [[nodiscard]] double volume() const { return measure().volume; }
    // Polygon f, of polygons().
    [[nodiscard]] std::size_t polygons() const { return ends_.size(); }
    [[nodiscard]] std::span<const Vector> polygon(std::size_t f) const {
        const std::size_t begin = f == 0 ? 0 : ends_[f - 1];
        return std::span(corners_).subspan(begin, ends_[f] - begin);
    }

private:
    void close(const Vector& n);

    std::vector<Vector> corners_;       // of all polygons, one after the other
    std::vector<std::size_t> ends_;     // by polygon
    std::vector<Vector> kept_corners_;  // scratch
    std::vector<std::size_t> kept_ends_;
    std::vector<double> outside_;  // by corner: n.x - h
    std::vector<Vector> rim_;      // where the plane cuts edges
    std::vector<std::pair<double, std::uint32_t>> angles_;
};

}  // namespace votess
