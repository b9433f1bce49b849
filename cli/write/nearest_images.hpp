// In a periodic domain a cell lies where its seed is taken to, inside the box; the input may say it elsewhere.
#pragma once

#include <array>
#include <span>
#include <votess/votess.hpp>

namespace clvotess {

using Point = std::array<double, 3>;

class NearestImages {
public:
    // points: 3N, which with `cells` must outlive this.
    NearestImages(std::span<const double> points, const votess::Tessellation& cells);

    // The image of seed i whose cell holds `inside`: of all its images the nearest, as its own images cut a cell.
    [[nodiscard]] Point image(std::size_t i, const Point& inside) const;

private:
    [[nodiscard]] Point nearest_in_lattice(Point seed, const Point& inside) const;

    std::span<const double> points_;
    Point side_{};  // 0 along an axis that is not periodic
    bool triclinic_ = false;
    std::array<int, 3> reach_{};  // steps tried along each edge
    std::array<Point, 3> edges_{}, inverse_{};
};

}  // namespace clvotess
