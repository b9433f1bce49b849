// Volume and centroid of a cell as a sum of pyramids from the seed over its faces. Done in double with a running error
// bound; needles and slabs, where vertices cancel, are done again in quad from exactly solved vertices.
#include <cmath>

#include "cpu/cell.hpp"

namespace votess::cpu {
namespace {

constexpr double unit = 0x1p-53;
// The promise is 1e-10; the bound counts vertices at their worst, the rest is rounding of the sums.
constexpr double accepted_error = 5e-11;

template <class Real>
using Vector = std::array<Real, 3>;

template <class Real>
Vector<Real> cross(const Vector<Real>& a, const Vector<Real>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class Real>
Real dot(const Vector<Real>& a, const Vector<Real>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class Real>
Vector<Real> operator-(const Vector<Real>& a, const Vector<Real>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double length_bound(const Vector<double>& a) { return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]); }

// A pyramid over the triangle of doubled area vector A on the plane n.x = h has volume A.n h / (6 |n|^2): for a
// bisector, h = |n|^2 / 2.
template <class Real>
struct Sums {
    Real volume = 0;
    Vector<Real> moment{};  // integral of x over the cell

    void add_pyramid(Real volume_of_it, const Vector<Real>& a, const Vector<Real>& b, const Vector<Real>& c) {
        volume += volume_of_it;
        for (int k = 0; k < 3; ++k) moment[k] += volume_of_it * (a[k] + b[k] + c[k]) * static_cast<Real>(0.25);
    }
    [[nodiscard]] CellGeometry geometry() const {
        CellGeometry g;
        g.volume = static_cast<double>(volume);
        for (int k = 0; k < 3; ++k) g.centroid[k] = static_cast<double>(moment[k] / volume);
        return g;
    }
};

}  // namespace

CellGeometry Cell::measure(const CellFaces& faces) {
    Sums<double> sums;
    double error = 0;
    auto position = [this](int v) { return Vector<double>{x_[v], y_[v], z_[v]}; };
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const CellPlane& plane = planes_[faces.planes[f]];
        const bool wall = plane.id < 0;
        const double factor = wall ? plane.h / 6 : 1.0 / 12;
        const double reach = factor * plane.norm;
        const int begin = faces.offsets[f], end = faces.offsets[f + 1];
        const int apex_slot = faces.corners[begin];
        const auto apex = position(apex_slot);
        Vector<double> previous = position(faces.corners[begin + 1]) - apex;
        double spread = length_bound(previous);
        double worst = tolerance_[apex_slot] + tolerance_[faces.corners[begin + 1]];
        for (int c = begin + 2; c < end; ++c) {
            const int slot = faces.corners[c];
            const auto current = position(slot) - apex;
            const double size = length_bound(current);
            worst = std::max(worst, tolerance_[slot]);
            // Moving a corner by t changes the doubled area by at most t times the opposite side.
            error += reach * (3 * worst * (spread + size) + 8 * unit * spread * size);
            const auto area = cross(previous, current);
            const auto a = apex, b = position(faces.corners[c - 1]), d = position(slot);
            sums.add_pyramid(dot(area, plane.n) * factor, a, b, d);
            previous = current;
            spread = size;
        }
    }
    if (error <= accepted_error * sums.volume) return sums.geometry();

    using exact::Quad;
    Sums<Quad> precise;
    std::vector<Vector<Quad>> solved(slots_);
    std::vector<bool> known(slots_, false);
    auto corner_position = [&](int v) {
        if (!known[v]) {
            const auto& [a, b, c] = corners_[v].plane;
            solved[v] = exact::vertex_position_quad(seed_, planes_[a].source, planes_[b].source, planes_[c].source);
            known[v] = true;
        }
        return solved[v];
    };
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const CellPlane& plane = planes_[faces.planes[f]];
        Vector<Quad> n{plane.n[0], plane.n[1], plane.n[2]};
        Quad factor = static_cast<Quad>(1) / 12;
        if (plane.source.kind == exact::Plane::Kind::bisector) {
            n = exact::difference_quad(plane.source.seed, seed_);
        } else {
            const int axis = plane.source.axis;
            const Quad offset = static_cast<Quad>(plane.source.wall) - static_cast<Quad>(seed_[axis]);
            factor = (offset < 0 ? -offset : offset) / 6;
        }
        const auto apex = corner_position(faces.corners[faces.offsets[f]]);
        for (int c = faces.offsets[f] + 2; c < faces.offsets[f + 1]; ++c) {
            const auto b = corner_position(faces.corners[c - 1]), d = corner_position(faces.corners[c]);
            precise.add_pyramid(dot(cross(b - apex, d - apex), n) * factor, apex, b, d);
        }
    }
    return precise.geometry();
}

}  // namespace votess::cpu
