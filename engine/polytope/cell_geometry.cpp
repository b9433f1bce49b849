// Volume, centroid and areas of a cell, as a sum of pyramids from the seed, with a running error bound. Needles and
// slabs, where vertices cancel, are computed again from exactly solved vertices, in double, quad, then WideFloat.
#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "polytope/cell.hpp"
#include "polytope/cell_polygons.hpp"
#include "polytope/cell_shape.hpp"
#include "polytope/vectors.hpp"

namespace votess::cpu {
namespace {

// The promise is 1e-10. The bound assumes the worst vertices; the rest is rounding of the sums.
constexpr double accepted_error = 5e-11;
constexpr double smallest_volume = 1e-140;  // below this volume times position might underflow

template <class Real>
double square(const Vector<Real>& a) {
    return static_cast<double>(dot(a, a));
}
// A pyramid over a triangle with doubled area vector A, on the plane n.x = h, has volume A.n h / (6 |n|^2). For a
// bisector h = |n|^2 / 2.
template <class Real>
struct Sums {
    Real volume = 0;
    Vector<Real> moment{};  // integral of x over the cell

    void add_pyramid(const Real& volume_of_it, const Vector<Real>& a, const Vector<Real>& b, const Vector<Real>& c) {
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

template <class Real>
Pyramids<Real> pyramids(const CellPlane& plane, const exact::Point& seed) {
    const exact::Plane& source = plane.source;
    Vector<Real> n;
    if (source.is_bisector()) {
        n = exact::difference<Real>(seed, source);
        if (!source.has_power()) return {n, static_cast<Real>(1) / 12};
    } else if (source.is_oblique()) {
        n = wall_normal<Real>(source);
    } else {
        const int axis = source.axis;
        const Real offset = static_cast<Real>(source.wall) - static_cast<Real>(seed[axis]);
        return {{static_cast<Real>(plane.n[0]), static_cast<Real>(plane.n[1]), static_cast<Real>(plane.n[2])},
                static_cast<Real>(offset * plane.n[axis] / 6)};
    }
    return {n, exact::height<Real>(seed, source) / dot(n, n) / 6};
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
        factor = 0.5 / std::hypot(static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2]));
        error_factor = factor * length_bound(n);
    }
    [[nodiscard]] double area(const Vector<Real>& doubled) const {
        return std::max(0.0, static_cast<double>(dot(doubled, n)) * factor);
    }
};

// corner(slot) returns {position, bound on its error}. Returns nothing when the error bound is not met.
template <class Real, class Corners>
std::optional<CellGeometry> sum_pyramids(const Cell& cell, const CellFaces& faces, Corners&& corner,
                                         std::vector<double>* areas) {
    Sums<Real> sums;
    double error = 0, surface = 0, area_error = 0, farthest = 0;
    if (areas != nullptr) areas->clear();
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const CellPlane& plane = cell.planes()[faces.planes[f]];
        const auto [n, factor] = pyramids<Real>(plane, cell.seed());
        const double reach = std::abs(static_cast<double>(factor)) * length_bound(n);
        const auto* slots = &faces.corners[faces.offsets[f]];
        const int count = faces.offsets[f + 1] - faces.offsets[f];
        const auto [apex, apex_error] = corner(slots[0]);
        auto [last, last_error] = corner(slots[1]);
        farthest = std::max({farthest, square(apex), square(last)});
        Vector<Real> previous = last - apex;
        double spread = length_bound(previous);
        double worst = std::max(apex_error, last_error);
        double doubled_error = 0;
        Vector<Real> doubled{};  // area vector of the face
        for (int c = 2; c < count; ++c) {
            const auto [position, position_error] = corner(slots[c]);
            farthest = std::max(farthest, square(position));
            const auto current = position - apex;
            const double size = length_bound(current);
            worst = std::max(worst, position_error);
            // Moving a corner by t changes the doubled area by at most t times the opposite side.
            doubled_error += 3 * worst * (spread + size) + 8 * roundoff<Real> * spread * size;
            const Vector<Real> triangle = cross(previous, current);
            for (int k = 0; k < 3; ++k) doubled[k] += triangle[k];
            const Real volume = dot(triangle, n) * factor;
            sums.add_pyramid(volume, apex, last, position);
            previous = current;
            last = position;
            spread = size;
        }
        error += reach * doubled_error;
        if (areas != nullptr) {
            const AreaScale<Real> scale(n);
            areas->push_back(scale.area(doubled));
            surface += areas->back();
            area_error += scale.error_factor * doubled_error;
        }
    }
    if constexpr (roundoff < Real >> 0) {
        const auto volume = static_cast<double>(sums.volume);
        if (!(volume > smallest_volume && error <= accepted_error * volume)) return std::nullopt;
        if (!(area_error <= accepted_error * surface)) return std::nullopt;
    }
    CellGeometry geometry = sums.geometry();
    geometry.farthest_squared = farthest;
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
    if (const auto g = sum_pyramids<double>(*this, faces, corner, areas)) return *g;
    return solve(*this, faces, areas);
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
    out.volume = geometry.volume;
    out.centroid = geometry.centroid;
    out.farthest_squared = geometry.farthest_squared;
}

}  // namespace votess::cpu
