// The density that is linear in Delaunay tetrahedra, in the plane triangles, which are the bodies. Bodies are cut in
// barycentric coordinates, so a flat one is cut like any other and its parts sum to it. The moments of a part are the
// integrals of the coordinates. Volumes come from exact differences between the corners.
//
// In the plane the bodies are prisms over triangles, as high as the sheet that stands for the plane, and the density
// does not depend on the height. A grid cell is as high too.
#include <cmath>
#include <limits>
#include <string>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "exact/wide_float.hpp"
#include "fields/methods.hpp"
#include "fields/overlay.hpp"
#include "mesh/dual.hpp"

namespace votess::fields {
namespace {

using Volume = exact::Quad;  // seeds 1e-323 apart span volumes of 1e-969

constexpr std::size_t of_task = 4096;  // seeds or tetrahedra

template <class Real>
using Vectors = std::array<std::array<Real, 3>, 3>;

template <class Real>
Real determinant(const Vectors<Real>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// Seeds, by where they begin in a list: the place and the density there are their means.
struct Corner {
    std::size_t begin, count;
};
using Corners = std::array<Corner, 4>;  // three in the plane

// The tetrahedra or triangles of the dual, and the parts of its polytopes or polygons. A polytope is cut from its
// center, and a facet with more than three corners from the center of the facet. So both sides agree, for any order of
// the seeds.
class Triangulation {
public:
    Triangulation(const Built& built, const Frame& frame, ThreadPool& pool)
        : job_(built.job), frame_(frame), dimensions_(dimensions_of(built.result)) {
        wraps_.resize(job_.domain->is_periodic() ? job_.points.count() : 0);
        for_tasks(pool, wraps_.size(),
                  [&](std::size_t i) { wraps_[i] = wrap(*job_.domain, point(i)).value_or(exact::Shift{}); });
        for (std::size_t i = 0; i < job_.beyond.size(); ++i) beyond_box_.push_back(job_.beyond[i] && !is_in_box(i));
        const Delaunay dual = delaunay(built.tessellation);
        whole_ = dual.tetrahedra.size() / (dimensions_ + 1);
        for (std::size_t k = 0; k < dual.tetrahedra.size(); ++k)
            members_.push_back({dual.tetrahedra[k], shift_in(dual.tetrahedra_shifts, k, 1, dimensions_)});
        if (planar())
            cut_polygons(dual);
        else
            cut_polytopes(dual, polytope_facets(built.result, dual));
        volumes_.resize(whole_ + parts_.size());
        for_tasks(pool, size(), [&](std::size_t number) { volumes_[number] = find_volume(corners(number)); });
    }

    [[nodiscard]] std::size_t size() const { return volumes_.size(); }
    [[nodiscard]] bool planar() const { return dimensions_ == 2; }
    // Of a body.
    [[nodiscard]] std::size_t corner_count() const { return dimensions_ + 1; }
    [[nodiscard]] Corners corners(std::size_t number) const {
        if (number >= whole_) return parts_[number - whole_];
        Corners corners{};
        for (std::size_t k = 0; k < corner_count(); ++k) corners[k] = {corner_count() * number + k, 1};
        return corners;
    }
    [[nodiscard]] std::size_t seed(std::size_t member) const { return at(members_[member].seed); }
    // Six times the volume, or twice the area, at the scale of the job. 0 where WideFloat underflows, in extreme
    // domains.
    [[nodiscard]] Volume volume(std::size_t number) const { return volumes_[number]; }

    // Whether a part of it may lie beyond the box.
    [[nodiscard]] bool may_leave_box(std::size_t number) const {
        if (beyond_box_.empty()) return false;
        return std::ranges::any_of(corners(number), [this](const Corner& corner) {
            const auto members = std::span(members_).subspan(corner.begin, corner.count);
            return std::ranges::any_of(members, [this](const Member& m) { return beyond_box_[at(m.seed)]; });
        });
    }

    // How barycentric coordinates 1 to 3 become those of the grid; in the plane 1, 2 and the height.
    [[nodiscard]] Place place(std::size_t number) const {
        const Corners four = corners(number);
        const Member& home = members_[four[0].begin];
        const Vector to_home = exact::difference<double>(frame_.origin(), image(home, {}));
        const Vector first = frame_.in_grid(to_home), mean = frame_.in_grid(mean_from<double>(home, four[0]));
        Place place;
        for (std::size_t axis = 0; axis < 3; ++axis) place.at[axis] = first[axis] + mean[axis];
        const Vectors<double> edges = edges_of<double>(four);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector edge = frame_.in_grid(edges[k]);
            for (std::size_t axis = 0; axis < 3; ++axis) place.along[axis][k] = edge[axis];
        }
        if (planar()) {
            place.at[2] = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) place.along[axis][2] = place.along[2][axis] = 0;
            place.along[2][2] = 1;
        }
        return place;
    }

private:
    template <class Visit>
    static void for_tasks(ThreadPool& pool, std::size_t count, const Visit& visit) {
        pool.run(ceil_div(count, of_task), [&](std::size_t task, unsigned) {
            for (std::size_t k = task * of_task; k < std::min(count, (task + 1) * of_task); ++k) visit(k);
        });
    }

    void cut_polygons(const Delaunay& dual) {
        for (std::size_t p = 0; p < dual.polytope_centers.size(); ++p) {
            const auto begin = at(dual.polytope_indptr[p]), end = at(dual.polytope_indptr[p + 1]);
            const std::size_t first = members_.size(), count = end - begin;
            for (std::size_t k = begin; k < end; ++k)
                members_.push_back({dual.polytope_indices[k], shift_in(dual.polytope_shifts, k, 1, dimensions_)});
            for (std::size_t k = 0; k < count; ++k)
                parts_.push_back({Corner{first, count}, {first + k, 1}, {first + (k + 1) % count, 1}, {}});
        }
    }
    void cut_polytopes(const Delaunay& dual, const PolytopeFacets& facets) {
        for (std::size_t p = 0; p < dual.polytope_centers.size(); ++p) {
            const auto begin = at(dual.polytope_indptr[p]), end = at(dual.polytope_indptr[p + 1]);
            const Corner center{members_.size(), end - begin};
            for (std::size_t k = begin; k < end; ++k)
                members_.push_back({dual.polytope_indices[k], shift_in(dual.polytope_shifts, k, 1)});
            for (std::size_t f = facets.facet_begin[p]; f < facets.facet_begin[p + 1]; ++f) {
                const auto corners =
                    std::span(facets.corners)
                        .subspan(facets.corner_begin[f], facets.corner_begin[f + 1] - facets.corner_begin[f]);
                const std::size_t first = members_.size(), count = corners.size();
                members_.insert(members_.end(), corners.begin(), corners.end());
                if (count == 3) parts_.push_back({center, {first, 1}, {first + 1, 1}, {first + 2, 1}});
                for (std::size_t k = 0; k < count && count > 3; ++k)
                    parts_.push_back({center, {first, count}, {first + k, 1}, {first + (k + 1) % count, 1}});
            }
        }
    }

    [[nodiscard]] exact::Point point(std::size_t i) const { return point_of(job_.points, i, job_.scale); }
    [[nodiscard]] bool is_in_box(std::size_t i) const {
        if (job_.domain->triclinic) return inside_walls(*job_.domain, point(i));
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = job_.points[3 * i + k];
            if (!job_.domain->periodic[k] && !(x >= job_.box.lower[k] && x <= job_.box.upper[k])) return false;
        }
        return true;
    }
    // From the place of a seed as given to where it lies as a member.
    [[nodiscard]] exact::Shift shift_of(const Member& m) const {
        if (wraps_.empty()) return {};
        exact::Shift shift = wraps_[at(m.seed)];
        for (std::size_t k = 0; k < 3; ++k) shift[k] += m.shift[k];
        return shift;
    }
    // The member as seen from a place that is moved by the shift.
    [[nodiscard]] exact::Plane image(const Member& m, const exact::Shift& moved) const {
        exact::Shift shift = shift_of(m);
        for (std::size_t k = 0; k < 3; ++k) shift[k] -= moved[k];
        return exact::Plane::bisector(point(at(m.seed)), shift, job_.domain->lattice);
    }

    // From a member to a corner.
    template <class Real>
    [[nodiscard]] std::array<Real, 3> mean_from(const Member& home, const Corner& corner) const {
        const exact::Point from = point(at(home.seed));
        const exact::Shift moved = shift_of(home);
        std::array<Real, 3> mean{};
        for (std::size_t i = corner.begin; i < corner.begin + corner.count; ++i) {
            const std::array<Real, 3> d = exact::difference<Real>(from, image(members_[i], moved));
            for (std::size_t axis = 0; axis < 3; ++axis) mean[axis] = mean[axis] + d[axis];
        }
        if (corner.count > 1)
            for (Real& x : mean) x = x / static_cast<Real>(static_cast<double>(corner.count));
        return mean;
    }
    // From corner 0 to the others; in the plane the last one is the height, 1.
    template <class Real>
    [[nodiscard]] Vectors<Real> edges_of(const Corners& corners) const {
        const Member& home = members_[corners[0].begin];
        Vectors<Real> edges{};
        for (std::size_t k = 0; k < dimensions_; ++k) edges[k] = mean_from<Real>(home, corners[k + 1]);
        if (corners[0].count > 1) {
            const std::array<Real, 3> first = mean_from<Real>(home, corners[0]);
            for (std::size_t k = 0; k < dimensions_; ++k)
                for (std::size_t axis = 0; axis < 3; ++axis) edges[k][axis] = edges[k][axis] - first[axis];
        }
        if (planar()) edges[2] = {Real(0.0), Real(0.0), Real(1.0)};
        return edges;
    }

    // Returns six times the volume, to a relative 1e-12. Let m be the product over the axes of the largest difference
    // between members. A determinant of rounded edges errs by less than 64 u m. Where corners are means of n members,
    // edges are sums that may cancel, and the error is less than 300 (n + 3) u m. Larger relative errors need more
    // digits.
    [[nodiscard]] Volume find_volume(const Corners& corners) const {
        std::size_t most = 1;
        for (const Corner& corner : corners) most = std::max(most, corner.count);
        const double errors = most == 1 ? 64 : 300 * static_cast<double>(most + 3);
        const auto [x, y, z] = extents(corners);
        const double rounded = determinant(edges_of<double>(corners));
        if (rounded * 1e-12 > errors * 0x1p-53 * (x * y * z) && rounded > 0x1p-900) return rounded;
        const Volume m = Volume(x) * y * z, better = determinant(edges_of<exact::Quad>(corners));
        if (better * 1e-12 > errors * 0x1p-122 * m) return better;
        return std::max(Volume(0), static_cast<Volume>(determinant(edges_of<exact::WideFloat>(corners))));
    }
    // Along each axis, how far the members of the corners are from one of them at most.
    [[nodiscard]] Vector extents(const Corners& corners) const {
        const Member& home = members_[corners[0].begin];
        const exact::Point from = point(at(home.seed));
        const exact::Shift moved = shift_of(home);
        Vector extents{0, 0, planar() ? 1.0 : 0.0};
        for (const Corner& corner : corners)
            for (std::size_t i = corner.begin; i < corner.begin + corner.count; ++i) {
                const Vector d = exact::difference<double>(from, image(members_[i], moved));
                for (std::size_t axis = 0; axis < 3; ++axis) extents[axis] = std::max(extents[axis], std::abs(d[axis]));
            }
        return extents;
    }

    const Job& job_;
    const Frame& frame_;
    const std::size_t dimensions_;
    std::vector<exact::Shift> wraps_;  // by seed; in periodic domains
    std::vector<bool> beyond_box_;     // by seed; empty if all are inside
    std::size_t whole_ = 0;            // how many tetrahedra the dual has
    std::vector<Member> members_;
    std::vector<Corners> parts_;  // of polytopes
    std::vector<Volume> volumes_;
};

// The values of seeds, each column times a power of two that brings its largest mass to order one.
struct ScaledMasses {
    std::size_t columns;
    std::vector<double> values;   // (N, m)
    std::vector<int> exponents;   // by column
    std::vector<bool> is_finite;  // by column: all that was given
};

class Simplices final : public Carrier {
public:
    Simplices(const Frame& frame, const Triangulation& triangulation, std::span<const Volume> around,
              const ScaledMasses& masses, std::span<double> grid)
        : frame_(frame), triangulation_(triangulation), around_(around), masses_(masses), grid_(grid) {
        constexpr Vector o{}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
        whole_.add_polygon(std::array{o, y, x});
        if (triangulation.planar()) {
            constexpr Vector x_up{1, 0, 1}, y_up{0, 1, 1};
            whole_.add_polygon(std::array{z, x_up, y_up});
            for (const std::array<Vector, 4>& side : {std::array{o, x, x_up, z}, {o, z, y_up, y}, {x, y, y_up, x_up}})
                whole_.add_polygon(side);
        } else {
            for (const std::array<Vector, 3>& face : {std::array{o, z, y}, {o, x, z}, {x, y, z}})
                whole_.add_polygon(face);
        }
    }

    bool load(std::size_t number, Body& body) override {
        if (triangulation_.volume(number) == 0) return false;
        body.place = triangulation_.place(number);
        body.piece.assign(whole_);
        double inside = 1;  // share of the volume
        if (triangulation_.may_leave_box(number)) {
            cut_to_box(body);
            if (body.piece.empty()) return false;
            inside = body.piece.volume() / whole_.volume();
            if (!(inside > 0)) return false;
        }
        // A corner has the mass of a quarter of the volume, or a third of the area, at the density of the corner.
        const std::size_t m = masses_.columns;
        at_corners_.assign(triangulation_.corner_count() * m, 0);
        const Corners corners = triangulation_.corners(number);
        for (std::size_t k = 0; k < triangulation_.corner_count(); ++k) {
            const auto& [begin, count] = corners[k];
            for (std::size_t i = begin; i < begin + count; ++i) {
                const std::size_t seed = triangulation_.seed(i);
                const double share =
                    inside * ratio(triangulation_.volume(number), around_[seed]) / static_cast<double>(count);
                for (std::size_t c = 0; c < m; ++c) at_corners_[k * m + c] += share * masses_.values[seed * m + c];
            }
        }
        return true;
    }

    void add(std::size_t cell, const ConvexPiece::Measure& part) override {
        const auto& [x, y, height] = part.moment;
        const double z = triangulation_.planar() ? 0 : height;
        const std::array<double, 4> integrals{part.volume - (x + y + z), x, y, z};
        const std::size_t m = masses_.columns, corners = triangulation_.corner_count();
        for (std::size_t k = 0; k < corners; ++k)
            for (std::size_t c = 0; c < m; ++c)
                grid_[cell * m + c] += static_cast<double>(corners) * integrals[k] * at_corners_[k * m + c];
    }

private:
    // Other bodies are not cut: rounding could take all of a flat one at a wall.
    void cut_to_box(Body& body) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (frame_.axis(k).periodic) continue;
            const auto& [x, y, z] = body.place.along[k];
            const double to_lower = -body.place.at[k];
            const double to_upper = static_cast<double>(frame_.axis(k).count) - body.place.at[k];
            if (!body.piece.cut({-x, -y, -z}, -to_lower) || !body.piece.cut({x, y, z}, to_upper)) return;
        }
    }

    const Frame& frame_;
    const Triangulation& triangulation_;
    std::span<const Volume> around_;
    const ScaledMasses& masses_;
    std::span<double> grid_;
    ConvexPiece whole_;
    std::vector<double> at_corners_;  // of the body loaded last: a row of m for each corner
};

// By seed: the volumes of the tetrahedra around it, of those where it is one of n at a corner the n-th part. 0 where it
// has none.
std::vector<Volume> volumes_around(const Triangulation& triangulation, std::size_t seeds) {
    std::vector<Volume> around(seeds, 0);
    in_pieces(triangulation.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t number = first; number < last; ++number) {
            const Volume volume = triangulation.volume(number);
            for (const auto& [begin, count] : triangulation.corners(number)) {
                const Volume share = count == 1 ? volume : volume / static_cast<double>(count);
                for (std::size_t i = begin; i < begin + count; ++i) around[triangulation.seed(i)] += share;
            }
        }
    });
    return around;
}

ScaledMasses scaled_masses(const Task& task, std::span<const std::int32_t> duplicate_of) {
    const std::size_t m = task.columns, seeds = task.values.size() / m;
    ScaledMasses masses{m, std::vector<double>(seeds * m, 0), std::vector<int>(m, 0), std::vector<bool>(m, true)};
    for (std::size_t c = 0; c < m; ++c) {
        double largest = 0;
        for (std::size_t i = 0; i < seeds; ++i) {
            const double mass = std::abs(task.values[i * m + c]);
            if (!std::isfinite(mass))
                masses.is_finite[c] = false;
            else
                largest = std::max(largest, mass);
        }
        if (largest > 0) masses.exponents[c] = std::ilogb(largest);
        for (std::size_t i = 0; i < seeds; ++i) {
            const std::size_t to = duplicate_of.empty() || duplicate_of[i] < 0 ? i : at(duplicate_of[i]);
            masses.values[to * m + c] += std::ldexp(task.values[i * m + c], -masses.exponents[c]);
        }
    }
    return masses;
}

[[noreturn]] void refuse_density(const Task& task, std::size_t element, double mass, const Size& size) {
    const double digits = std::log10(size.mantissa) + size.exponent * std::log10(2.0);
    refuse("to_grid(): element " + std::to_string(element / task.columns) + " of the grid has the mass " +
           number(mass) + " in 1e" + std::to_string(std::lround(digits)) +
           ", a density that float64 cannot hold: give coordinates or masses in other units");
}

// Turns masses into densities. Masses below the rounding error may underflow.
void divide(const Task& task, const ScaledMasses& masses) {
    constexpr double least = std::numeric_limits<double>::min(), rounding = 1e-14;
    const Size size = task.frame.cell_size(task.projected);
    const std::size_t m = task.columns;
    for (std::size_t c = 0; c < m; ++c) {
        const int exponent = masses.exponents[c] - size.exponent;
        double all = 0, lost = 0;
        std::size_t largest = c;
        for (std::size_t element = c; element < task.grid.size(); element += m) {
            double& x = task.grid[element];
            const double mass = x;
            all += std::abs(mass);
            x = std::ldexp(mass / size.mantissa, exponent);
            if (!std::isfinite(x) && masses.is_finite[c])
                refuse_density(task, element, std::ldexp(mass, masses.exponents[c]), size);
            if (std::abs(x) < least && mass != 0) lost += std::abs(mass - std::ldexp(x, -exponent) * size.mantissa);
            if (std::abs(x) > std::abs(task.grid[largest])) largest = element;
        }
        if (lost > rounding * all) refuse_density(task, largest, std::ldexp(all, masses.exponents[c]), size);
    }
}

}  // namespace

std::size_t add_dtfe(const Task& task, const Built& built, ThreadPool& pool) {
    const std::span<const std::int32_t> duplicate_of = built.tessellation.duplicate_of();
    const Triangulation triangulation(built, task.frame, pool);
    const std::vector<Volume> around = volumes_around(triangulation, built.tessellation.size());
    const ScaledMasses masses = scaled_masses(task, duplicate_of);
    overlay(task.frame, pool, triangulation.size(),
            [&] { return std::make_unique<Simplices>(task.frame, triangulation, around, masses, task.grid); });
    divide(task, masses);
    std::size_t without = 0;
    for (std::size_t i = 0; i < around.size(); ++i)
        without += around[duplicate_of.empty() || duplicate_of[i] < 0 ? i : at(duplicate_of[i])] == 0;
    return without;
}

}  // namespace votess::fields
