// Images of seeds inside a periodic box. The input may place seeds outside, but cells lie inside.
#pragma once

#include <array>
#include <span>
#include <votess/votess.hpp>

namespace clvotess {

using Point = std::array<double, 3>;

class NearestImages {
public:
    // points: 3N, or 2N in the plane, where z is 0. Both arguments must outlive the object.
    NearestImages(std::span<const double> points, const votess::Tessellation& cells);

    // Returns the image of seed i that is nearest to `inside`, a place in its cell.
    [[nodiscard]] Point image(std::size_t i, const Point& inside) const;

private:
    [[nodiscard]] Point nearest_in_lattice(Point seed, const Point& inside) const;

    std::span<const double> points_;
    std::size_t size_;  // of a point
    Point side_{};      // 0 along an axis without period
    bool triclinic_ = false;
    std::array<int, 3> reach_{};  // steps tried along each edge
    std::array<Point, 3> edges_{}, inverse_{};
};

}  // namespace clvotess
