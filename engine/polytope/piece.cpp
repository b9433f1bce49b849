#include "polytope/piece.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <type_traits>

#include "polytope/vectors.hpp"

namespace votess::cpu {
namespace {

template <class Real>
struct Corner {
    Vector<Real> x;
    double error;  // of the vector
};

template <class Real>
Corner<Real> corner_at(const Cell& cell, int slot) {
    if constexpr (std::is_same_v<Real, double>) {
        return {cell.position(slot), 3 * cell.tolerance(slot)};
    } else {
        const auto [a, b, c] = cell.corner_planes(slot);
        const auto x = exact::vertex_position<Real>(cell.seed(), a->source, b->source, c->source);
        return {x, 8 * roundoff<Real> * length_bound(x)};
    }
}

std::span<const std::int32_t> corners_of(const CellFaces& faces, std::size_t face) {
    const auto begin = static_cast<std::size_t>(faces.offsets[face]),
               end = static_cast<std::size_t>(faces.offsets[face + 1]);
    return std::span(faces.corners).subspan(begin, end - begin);
}

template <class Real>
Corner<Real> seen_from(const Corner<Real>& from, const Corner<Real>& corner) {
    const auto x = corner.x - from.x;
    return {x, corner.error + from.error + 2 * roundoff<Real> * length_bound(x)};
}

// An error of a corner changes a determinant by at most that error times the lengths of the two others.
template <class Real>
Measured volume_in(const Cell& cell, const CellFaces& faces) {
    std::vector<std::optional<Corner<Real>>> known(static_cast<std::size_t>(cell.slots()));
    const auto corner = [&](std::int32_t slot) -> const Corner<Real>& {
        auto& at = known[static_cast<std::size_t>(slot)];
        if (!at) at = corner_at<Real>(cell, slot);
        return *at;
    };
    const Corner<Real> apex = corner(faces.corners.front());
    Real sum = 0;
    double error = 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto slots = corners_of(faces, f);
        const Corner<Real> first = seen_from(apex, corner(slots[0]));
        Corner<Real> last = seen_from(apex, corner(slots[1]));
        const double p = length_bound(first.x);
        double q = length_bound(last.x);
        for (std::size_t c = 2; c < slots.size(); ++c) {
            const Corner<Real> next = seen_from(apex, corner(slots[c]));
            const double r = length_bound(next.x);
            sum += dot(first.x, cross(last.x, next.x));
            error += first.error * q * r + last.error * p * r + next.error * p * q + 8 * roundoff<Real> * p * q * r;
            last = next;
            q = r;
        }
    }
    return {static_cast<double>(sum) / 6, error / 6};
}

template <class Real>
FaceMeasure face_in(const Cell& cell, const CellFaces& faces, std::size_t face) {
    const auto slots = corners_of(faces, face);
    const Corner<Real> apex = corner_at<Real>(cell, slots[0]);
    Corner<Real> last = seen_from(apex, corner_at<Real>(cell, slots[1]));
    const std::array<double, 3>& given = cell.planes()[static_cast<std::size_t>(faces.planes[face])].n;
    const double longest = std::max({std::abs(given[0]), std::abs(given[1]), std::abs(given[2])});
    std::array<double, 3> n{};
    for (std::size_t k = 0; k < 3; ++k) n[k] = given[k] / longest;
    const double length = length3(n[0], n[1], n[2]);
    FaceMeasure sum;
    for (std::size_t c = 2; c < slots.size(); ++c) {
        const Corner<Real> next = seen_from(apex, corner_at<Real>(cell, slots[c]));
        const Vector<Real> doubled = cross(last.x, next.x);
        double area = 0;
        for (std::size_t k = 0; k < 3; ++k) area += static_cast<double>(doubled[k]) * n[k];
        area *= 0.5 / length;
        const double p = length_bound(last.x), q = length_bound(next.x);
        sum.area.value += area;
        sum.area.error += last.error * q + next.error * p + 8 * roundoff<Real> * p * q;
        for (std::size_t k = 0; k < 3; ++k)
            sum.moment[k] += area * (static_cast<double>(apex.x[k]) + static_cast<double>(last.x[k] + next.x[k]) / 3);
        last = next;
    }
    return sum;
}

template <class Measure>
auto measure_in(Precision precision, const Measure& in_precision) {
    if (precision == Precision::cell) return in_precision.template operator()<double>();
    if (precision == Precision::quad) return in_precision.template operator()<exact::Quad>();
    return in_precision.template operator()<exact::WideFloat>();
}

}  // namespace

Measured measure_volume(const Cell& cell, const CellFaces& faces, Precision precision) {
    return measure_in(precision, [&]<class Real>() { return volume_in<Real>(cell, faces); });
}

FaceMeasure measure_face(const Cell& cell, const CellFaces& faces, std::size_t face, Precision precision) {
    return measure_in(precision, [&]<class Real>() { return face_in<Real>(cell, faces, face); });
}

}  // namespace votess::cpu
