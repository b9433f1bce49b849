// Volume, centroid and areas of a cell, as a sum of pyramids from the seed, with a running error bound. Needles and
// slabs, where vertices cancel, are computed again from exactly solved vertices, in double, quad, then WideFloat. So
// are vast cells (vast_cell.hpp), until each face has its digits.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "core/sum.hpp"
#include "polytope/cell.hpp"
#include "polytope/cell_polygons.hpp"
#include "polytope/cell_shape.hpp"
#include "polytope/vast_cell.hpp"
#include "polytope/vectors.hpp"

namespace votess::cpu {
namespace {

// The promise is 1e-10. The bound assumes the worst vertices; the rest is rounding of the sums.
constexpr double accepted_error = 5e-11;
constexpr double smallest_volume = 1e-140;  // below this volume times position might underflow
constexpr int ordinary_exponent = 100;      // of a size that needs no scaling
constexpr int largest_exponent = 1000;      // of units whose inverse is a number

template <class Real>
double square(const Vector<Real>& a) {
    return static_cast<double>(dot(a, a));
}
// A pyramid over a triangle with doubled area vector A, on the plane n.x = h, has volume A.n h / (6 |n|^2). For a
// bisector h = |n|^2 / 2.
template <class Real>
struct Sums {
    using Sum = AccurateSum<Real, roundoff<Real> == 0>;
    Sum volume;
    std::array<Sum, 3> moment;  // integral of x over the cell

    void add_pyramid(const Real& volume_of_it, const Vector<Real>& a, const Vector<Real>& b, const Vector<Real>& c) {
        volume += volume_of_it;
        for (int k = 0; k < 3; ++k) moment[k] += volume_of_it * (a[k] + b[k] + c[k]) * static_cast<Real>(0.25);
    }
    [[nodiscard]] CellGeometry geometry() const {
        CellGeometry g;
        const Real all = volume.value();
        g.volume = static_cast<double>(all);
        for (int k = 0; k < 3; ++k) g.centroid[k] = static_cast<double>(moment[k].value() / all);
        if constexpr (!std::is_same_v<Real, double>) {  // which has no room for needles of 1e-150 of their length
            constexpr double least = 1e-250;
            constexpr int step = 150, last = 450;
            for (int shift = step; shift <= last && !(g.volume > least); shift += step) {
                g.volume = static_cast<double>(ldexp(all, 3 * shift));
                g.exponent = -shift;
            }
            for (double& x : g.centroid) x = std::ldexp(x, -g.exponent);
        }
        return g;
    }
};

template <class Real>
struct Pyramids {  // over the faces on one plane: volume = factor * doubled area . n
    Vector<Real> n;
    Real factor;
};

template <class Real>
Vector<Real> wall_normal(const exact::Plane& wall) {
    Vector<Real> n;
    if (wall.kind == exact::Plane::Kind::wall || std::is_same_v<Real, double>) {
        const exact::Point& rounded = wall.kind == exact::Plane::Kind::wall ? wall.seed : wall.rounded_normal();
        for (int k = 0; k < 3; ++k) n[k] = static_cast<Real>(rounded[k]);
        return n;
    }
    Vector<Real> u, v;
    for (int k = 0; k < 3; ++k) {
        u[k] = static_cast<Real>(wall.wall * wall.lattice->vector[(wall.axis + 1) % 3][k].high);
        v[k] = static_cast<Real>(wall.lattice->vector[(wall.axis + 2) % 3][k].high);
    }
    return cross(u, v);
}

// A very small or large cell is measured in units of a power of two, so that no volume or square leaves the range of
// double.
template <class Real>
Pyramids<Real> pyramids(const CellPlane& plane, const exact::Point& seed, int exponent) {
    const exact::Plane& source = plane.source;
    Vector<Real> n;
    const auto per_unit = static_cast<Real>(std::ldexp(1.0, -exponent));
    if (source.is_bisector()) {
        n = per_unit * exact::difference<Real>(seed, source);
        if (!source.has_power()) return {n, static_cast<Real>(1) / 12};
        // Scales n to order one, because squares of a short normal lose digits.
        const double longest = std::max({std::abs(static_cast<double>(n[0])), std::abs(static_cast<double>(n[1])),
                                         std::abs(static_cast<double>(n[2]))});
        const int longer = std::clamp(-std::ilogb(longest), -largest_exponent, largest_exponent);
        n = static_cast<Real>(std::ldexp(1.0, longer)) * n;
        return {n, exact::height<Real>(seed, source, longer - 2 * exponent) / dot(n, n) / 6};
    } else if (source.is_oblique()) {
        n = wall_normal<Real>(source);
    } else {
        const int axis = source.axis;
        const Real offset = static_cast<Real>(source.wall) - static_cast<Real>(seed[axis]);
        return {{static_cast<Real>(plane.n[0]), static_cast<Real>(plane.n[1]), static_cast<Real>(plane.n[2])},
                static_cast<Real>(per_unit * offset * plane.n[axis] / 6)};
    }
    return {n, exact::height<Real>(seed, source, -exponent) / dot(n, n) / 6};
}

// Turns doubled area vectors on a plane into areas.
template <class Real>
struct AreaScale {
    Vector<Real> n;       // normal, scaled to order one, so that no product underflows
    double factor;        // area = factor * doubled area . n
    double error_factor;  // of a bound on the error of the doubled area

    explicit AreaScale(const Vector<Real>& normal) {
        const double largest =
            std::max({std::abs(static_cast<double>(normal[0])), std::abs(static_cast<double>(normal[1])),
                      std::abs(static_cast<double>(normal[2]))});
        const auto scale = static_cast<Real>(std::ldexp(1.0, -std::max(std::ilogb(largest), -1000)));
        for (int k = 0; k < 3; ++k) n[k] = normal[k] * scale;
        factor = 0.5 / length3(static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2]));
        error_factor = factor * length_bound(n);
    }
    [[nodiscard]] double area(const Vector<Real>& doubled) const {
        return std::max(0.0, static_cast<double>(dot(doubled, n)) * factor);
    }
};

// Returns the exponent of the units for a cell, 0 for most.
int exponent_of(const Cell& cell, const CellFaces& faces) {
    double largest = 0;
    for (const std::int32_t slot : faces.corners)
        for (const double x : cell.position(slot)) largest = std::max(largest, std::abs(x));
    if (!(largest > 0 && std::isfinite(largest))) return 0;
    const int exponent = std::ilogb(largest);
    return std::abs(exponent) <= ordinary_exponent ? 0 : std::clamp(exponent, -largest_exponent, largest_exponent);
}

// How the volume and the surface change when one corner moves. In a sum over the faces around it most of this cancels,
// so a bound on all errors grows as the surface, not as the number of faces.
struct Gradient {
    Vector<double> volume{}, surface{};
    double volume_terms = 0, surface_terms = 0;  // sums of the sizes of the terms, which bound their rounding
    double error = 0;                            // of each coordinate of the corner

    [[nodiscard]] double volume_error() const { return error * (length_bound(volume) + rounding * volume_terms); }
    [[nodiscard]] double surface_error() const { return error * (length_bound(surface) + rounding * surface_terms); }

private:
    static constexpr double rounding = 0x1p-48;
};

template <class Real>
Vector<double> rounded(const Vector<Real>& a) {
    return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

// The doubled area vector of a triangle, from its two shorter edges.
template <class Real>
struct Triangle {
    Vector<Real> doubled;
    double size;  // product of bounds on the lengths of the edges

    Triangle(const Vector<Real>& a, const Vector<Real>& b, const Vector<Real>& c) {
        const Vector<Real> ab = b - a, ac = c - a, bc = c - b;
        const double lengths[3] = {length_bound(ab), length_bound(ac), length_bound(bc)};
        const double longest = std::max({lengths[0], lengths[1], lengths[2]});
        if (longest == lengths[2])
            doubled = cross(ab, ac), size = lengths[0] * lengths[1];
        else if (longest == lengths[1])
            doubled = cross(ab, bc), size = lengths[0] * lengths[2];
        else
            doubled = cross(ac, bc), size = lengths[1] * lengths[2];
    }
};

// Whether the areas of a vast cell have their digits, each by itself; of other cells their surface has. Faces that
// reach a distant wall count with the surface. errors: by face. per_unit: of the unit of areas.
bool are_exact(const Cell& cell, const CellFaces& faces, const std::vector<double>& areas,
               const std::vector<double>& errors, double per_unit) {
    const auto plane = [&](std::size_t f) -> const CellPlane& { return cell.planes()[faces.planes[f]]; };
    const auto squared = [&](double distance) { return per_unit * distance * (per_unit * distance); };
    const auto is_wall = [&](std::size_t f) { return !plane(f).source.is_bisector(); };
    const std::optional<double> beyond =
        vast_beyond(areas, is_wall, [&](std::size_t f) { return squared(plane(f).norm); });
    if (!beyond) return true;
    const auto corners = [&](std::size_t f) {
        return std::span(faces.corners).subspan(faces.offsets[f], faces.offsets[f + 1] - faces.offsets[f]);
    };
    std::vector<bool> at_end(static_cast<std::size_t>(cell.slots()));
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const CellPlane& p = plane(f);
        if (!is_wall(f) || !(squared(p.h / (p.unit * p.norm)) > *beyond)) continue;
        for (const std::int32_t slot : corners(f)) at_end[slot] = true;
    }
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (!(errors[f] <= accepted_error * areas[f]) &&
            std::ranges::none_of(corners(f), [&](std::int32_t slot) { return at_end[slot]; }))
            return false;
    return true;
}

// corner_of(slot) returns {position, bound on its error}. Returns nothing when the error bound is not met.
//
// A polygon's doubled area vector is the sum of v_i x v_i+1. If corners move by d_i it changes by the sum of
// d_i x (v_i+1 - v_i-1) + d_i x d_i+1.
template <class Real, class Corners>
std::optional<CellGeometry> sum_pyramids(const Cell& cell, const CellFaces& faces, Corners&& corner_of,
                                         std::vector<double>* areas) {
    constexpr bool bounded = roundoff < Real >> 0;
    const int exponent = exponent_of(cell, faces);
    const double per_unit = std::ldexp(1.0, -exponent);
    Sums<Real> sums;
    std::vector<Gradient> gradients(bounded ? static_cast<std::size_t>(cell.slots()) : 0);
    std::vector<Vector<Real>> polygon;
    std::vector<double> area_errors;
    double error = 0, surface = 0, surface_error = 0, worst_area = 0, farthest = 0;
    if (areas != nullptr) areas->clear();
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto [n, factor] = pyramids<Real>(cell.planes()[faces.planes[f]], cell.seed(), exponent);
        const std::span slots =
            std::span(faces.corners)
                .subspan(static_cast<std::size_t>(faces.offsets[f]), faces.offsets[f + 1] - faces.offsets[f]);
        const std::size_t count = slots.size();
        polygon.clear();
        double worst = 0;
        for (const std::int32_t slot : slots) {
            const auto [position, corner_error] = corner_of(slot);
            polygon.push_back(exponent == 0 ? position : static_cast<Real>(per_unit) * position);
            farthest = std::max(farthest, square(polygon.back()));
            worst = std::max(worst, per_unit * corner_error);
            if constexpr (bounded) gradients[slot].error = per_unit * corner_error;
        }
        const Vector<Real>& apex = polygon[0];
        double doubled_error = 2 * static_cast<double>(count) * worst * worst;
        Vector<Real> doubled{};  // area vector of the face
        for (std::size_t c = 2; c < count; ++c) {
            const Triangle<Real> triangle(apex, polygon[c - 1], polygon[c]);
            doubled_error += 8 * roundoff<Real> * triangle.size;
            for (int k = 0; k < 3; ++k) doubled[k] += triangle.doubled[k];
            const Real volume = dot(triangle.doubled, n) * factor;
            sums.add_pyramid(volume, apex, polygon[c - 1], polygon[c]);
        }
        const AreaScale<Real> scale(n);
        if (areas != nullptr) {
            areas->push_back(scale.area(doubled));
            surface += areas->back();
        }
        if constexpr (bounded) {
            const double reach = std::abs(static_cast<double>(factor)) * length_bound(n);
            const Vector<double> height = rounded(factor * n), unit = scale.factor * rounded(scale.n);
            double area_error = scale.error_factor * doubled_error;
            error += reach * doubled_error;
            surface_error += area_error;
            for (std::size_t c = 0; c < count; ++c) {
                const Vector<double> across =
                    rounded(polygon[c + 1 == count ? 0 : c + 1] - polygon[c == 0 ? count - 1 : c - 1]);
                const Vector<double> volume = cross(across, height), area = cross(across, unit);
                Gradient& gradient = gradients[slots[c]];
                for (int k = 0; k < 3; ++k) gradient.volume[k] += volume[k], gradient.surface[k] += area[k];
                gradient.volume_terms += reach * length_bound(across);
                gradient.surface_terms += scale.error_factor * length_bound(across);
                area_error += gradient.error * length_bound(area);
            }
            worst_area = std::max(worst_area, area_error);
            if (areas != nullptr) area_errors.push_back(area_error);
        }
    }
    if constexpr (bounded) {
        for (const Gradient& gradient : gradients) {
            error += gradient.volume_error();
            surface_error += gradient.surface_error();
        }
        const auto volume = static_cast<double>(sums.volume.value());
        if (!(volume > smallest_volume && error <= accepted_error * volume)) return std::nullopt;
        if (areas != nullptr && !(std::max(worst_area, surface_error) <= accepted_error * surface &&
                                  are_exact(cell, faces, *areas, area_errors, per_unit)))
            return std::nullopt;
    }
    CellGeometry geometry = sums.geometry();
    geometry.farthest_squared = std::ldexp(farthest, -2 * geometry.exponent);
    if (areas != nullptr && geometry.exponent != 0)
        for (double& area : *areas) area = std::ldexp(area, -2 * geometry.exponent);
    geometry.exponent += exponent;
    return geometry;
}

// Solves each vertex exactly, from the planes of its first three faces, and rounds it to Real.
template <class Real>
std::optional<CellGeometry> sum_solved(const Cell& cell, const CellFaces& faces, std::vector<double>* areas) {
    struct Solved {
        int planes = 0;
        std::array<const exact::Plane*, 3> on{};
        std::optional<Vector<Real>> position;
        double error = 0;
    };
    std::vector<Solved> known(static_cast<std::size_t>(cell.slots()));
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::int32_t c = faces.offsets[f]; c < faces.offsets[f + 1]; ++c) {
            Solved& vertex = known[faces.corners[c]];
            if (vertex.planes < 3) vertex.on[vertex.planes++] = &cell.planes()[faces.planes[f]].source;
        }
    const auto corner = [&](int slot) {
        struct Corner {
            Vector<Real> position;
            double error;
        };
        Solved& vertex = known[slot];
        if (!vertex.position) {
            const auto& [a, b, c] = vertex.on;
            if constexpr (std::is_same_v<Real, double>)
                vertex.position = exact::near_vertex(cell.seed(), *a, *b, *c);
            else
                vertex.position = exact::vertex_position<Real>(cell.seed(), *a, *b, *c);
            vertex.error = 8 * roundoff<Real> * length_bound(*vertex.position);
        }
        return Corner{*vertex.position, vertex.error};
    };
    return sum_pyramids<Real>(cell, faces, corner, areas);
}

// Brings measures to units of one. Those of very small or large cells may leave the range of double.
CellGeometry in_units_of_one(CellGeometry geometry, std::vector<double>* areas) {
    const int exponent = std::exchange(geometry.exponent, 0);
    if (exponent == 0) return geometry;
    geometry.volume = std::ldexp(geometry.volume, 3 * exponent);
    for (double& x : geometry.centroid) x = std::ldexp(x, exponent);
    geometry.farthest_squared = std::ldexp(geometry.farthest_squared, 2 * exponent);
    if (areas != nullptr)
        for (double& area : *areas) area = std::ldexp(area, 2 * exponent);
    return geometry;
}

CellGeometry solve(const Cell& cell, const CellFaces& faces, std::vector<double>* areas) {
    if (const auto g = sum_solved<double>(cell, faces, areas)) return *g;
    if (const auto g = sum_solved<exact::Quad>(cell, faces, areas)) return *g;
    return *sum_solved<exact::WideFloat>(cell, faces, areas);
}

}  // namespace

CellGeometry Cell::measure(const CellFaces& faces, std::vector<double>* areas) const {
    struct Corner {
        Vector<double> position;
        double error;
    };
    const auto corner = [this](int slot) { return Corner{{x_[slot], y_[slot], z_[slot]}, tolerance_[slot]}; };
    const auto g = sum_pyramids<double>(*this, faces, corner, areas);
    return in_units_of_one(g ? *g : solve(*this, faces, areas), areas);
}

// Faces go by rank, and each polygon begins at the edge to the face of least rank, so that the sums do not depend on
// how the cell was found.
void measure_exactly(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, CellMeasures& out,
                     std::vector<double>& areas) {
    CellPolygons polygons;
    read_polygons(cell, faces, ranks, polygons);
    std::vector<std::size_t> order(ranks.size());
    for (std::size_t f = 0; f < ranks.size(); ++f) order[ranks[f]] = f;
    CellFaces sorted;
    sorted.offsets.push_back(0);
    for (const std::size_t f : order) {
        sorted.planes.push_back(faces.planes[f]);
        sorted.corners.insert(sorted.corners.end(), polygons.face(f).begin(), polygons.face(f).end());
        sorted.offsets.push_back(static_cast<std::int32_t>(sorted.corners.size()));
    }
    const CellGeometry geometry = solve(cell, sorted, &areas);
    out.exponent = geometry.exponent;
    out.volume = geometry.volume;
    for (std::size_t k = 0; k < 3; ++k) out.centroid[k] = std::ldexp(geometry.centroid[k], geometry.exponent);
    out.farthest_squared = geometry.farthest_squared;
}

}  // namespace votess::cpu
