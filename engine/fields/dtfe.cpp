// The density that is linear in Delaunay tetrahedra, which are the bodies. The integral of a linear function over a
// part is that of its values at the corners, each times the integral of a barycentric coordinate.
#include <cmath>

#include "core/progress.hpp"
#include "fields/methods.hpp"
#include "fields/overlay.hpp"
#include "mesh/dual.hpp"

namespace votess::fields {
namespace {

// In a tetrahedron that fills less of its bounds the density is its mean: barycentric coordinates have no digits.
constexpr double least_filled = 1e-10;

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Seeds, by where they begin in a list: the place and the density there are their means.
struct Corner {
    std::size_t begin, count;
};

// In coordinates of the grid.
struct Tetrahedron {
    std::array<Corner, 4> corners{};
    Vector first{};                 // corner 0
    std::array<Vector, 3> edges{};  // from there to the others
    double determinant = 0;         // of the edges

    [[nodiscard]] double volume() const { return std::abs(determinant) / 6; }
};

// The tetrahedra of the dual, and the parts of its polytopes. These are cut from their center, and facets of more than
// three corners from theirs: in the same way from both sides, and whatever the order of the seeds.
class Triangulation {
public:
    Triangulation(const Built& built, const Frame& frame)
        : frame_(frame), places_(wrapped_points(built.tessellation, built.points)) {
        const Delaunay dual = delaunay(built.tessellation);
        whole_ = dual.tetrahedra.size() / 4;
        for (std::size_t k = 0; k < dual.tetrahedra.size(); ++k)
            members_.push_back({dual.tetrahedra[k], shift_in(dual.tetrahedra_shifts, k, 1)});
        cut_polytopes(dual, polytope_facets(built.result, dual));
    }

    [[nodiscard]] std::size_t size() const { return whole_ + parts_.size(); }
    [[nodiscard]] std::size_t seed(std::size_t member) const { return at(members_[member].seed); }

    [[nodiscard]] Tetrahedron operator[](std::size_t number) const {
        Tetrahedron t;
        if (number < whole_)
            for (std::size_t k = 0; k < 4; ++k) t.corners[k] = {4 * number + k, 1};
        else
            t.corners = parts_[number - whole_];
        const Member& home = members_[t.corners[0].begin];
        const double* place = &places_[3 * at(home.seed)];
        std::array<Vector, 4> from_home;
        for (std::size_t k = 0; k < 4; ++k) from_home[k] = mean_from(home, t.corners[k]);
        t.first = frame_.position(place);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            t.first[axis] += periods(home.shift[axis], axis) + from_home[0][axis];
            for (std::size_t k = 0; k < 3; ++k) t.edges[k][axis] = from_home[k + 1][axis] - from_home[0][axis];
        }
        t.determinant = dot(t.edges[0], cross(t.edges[1], t.edges[2]));
        return t;
    }

private:
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

    [[nodiscard]] double periods(int shift, std::size_t axis) const {
        return static_cast<double>(shift * frame_.axis(axis).count);
    }

    // From a seed to a corner.
    [[nodiscard]] Vector mean_from(const Member& home, const Corner& corner) const {
        Vector mean{};
        for (std::size_t i = corner.begin; i < corner.begin + corner.count; ++i) {
            const Member& m = members_[i];
            const Vector d = frame_.difference(&places_[3 * at(home.seed)], &places_[3 * at(m.seed)]);
            for (std::size_t axis = 0; axis < 3; ++axis)
                mean[axis] +=
                    (d[axis] + periods(m.shift[axis] - home.shift[axis], axis)) / static_cast<double>(corner.count);
        }
        return mean;
    }

    const Frame& frame_;
    std::vector<double> places_;
    std::size_t whole_ = 0;  // how many tetrahedra the dual has
    std::vector<Member> members_;
    std::vector<std::array<Corner, 4>> parts_;  // of polytopes
};

// (N, m), mass for a unit of volume in coordinates of the grid.
struct Densities {
    std::size_t columns;
    std::vector<double> values;
};

class Tetrahedra final : public Carrier {
public:
    Tetrahedra(const Triangulation& triangulation, const Densities& densities, std::span<double> grid)
        : triangulation_(triangulation), densities_(densities), grid_(grid) {}

    bool load(std::size_t number, Body& body) override {
        t_ = triangulation_[number];
        if (t_.determinant == 0) return false;
        read_densities();
        const Vector o{};
        const auto& [a, b, c] = t_.edges;
        body.at = t_.first;
        body.piece.clear();
        for (std::array<Vector, 3> face : {std::array{o, b, a}, {o, c, b}, {o, a, c}, {a, b, c}}) {
            if (t_.determinant < 0) std::swap(face[1], face[2]);
            body.piece.add_polygon(face);
        }
        double bounds = 1;
        for (std::size_t k = 0; k < 3; ++k) bounds *= body.piece.extent(k).second - body.piece.extent(k).first;
        is_flat_ = t_.volume() < least_filled * bounds;
        slopes_ = {cross(b, c), cross(c, a), cross(a, b)};
        for (Vector& slope : slopes_)
            for (double& x : slope) x /= t_.determinant;
        return true;
    }

    void add(std::size_t cell, const ConvexPiece::Measure& part) override {
        std::array<double, 4> shares;
        shares.fill(part.volume / 4);
        if (!is_flat_) {
            shares[0] = part.volume;
            for (std::size_t k = 1; k < 4; ++k) {
                shares[k] = dot(slopes_[k - 1], part.moment);
                shares[0] -= shares[k];
            }
        }
        const std::size_t m = densities_.columns;
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t c = 0; c < m; ++c) grid_[cell * m + c] += t_.volume() * shares[k] * at_corners_[k * m + c];
    }

private:
    void read_densities() {
        const std::size_t m = densities_.columns;
        at_corners_.assign(4 * m, 0);
        for (std::size_t k = 0; k < 4; ++k) {
            const auto& [begin, count] = t_.corners[k];
            for (std::size_t i = begin; i < begin + count; ++i)
                for (std::size_t c = 0; c < m; ++c)
                    at_corners_[k * m + c] +=
                        densities_.values[triangulation_.seed(i) * m + c] / static_cast<double>(count);
        }
    }

    const Triangulation& triangulation_;
    const Densities& densities_;
    std::span<double> grid_;
    // The tetrahedron loaded last, and the gradients of the barycentric coordinates of corners 1 to 3.
    Tetrahedron t_;
    std::vector<double> at_corners_;  // densities
    std::array<Vector, 3> slopes_{};
    bool is_flat_ = false;
};

// The integral over space of what is 1 at a seed, 0 at the others, and linear in tetrahedra: a quarter of the volume of
// those around the seed.
std::vector<double> integrals(const Triangulation& triangulation, std::size_t seeds) {
    std::vector<double> integrals(seeds, 0);
    in_pieces(triangulation.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t number = first; number < last; ++number) {
            const Tetrahedron t = triangulation[number];
            for (const auto& [begin, count] : t.corners)
                for (std::size_t i = begin; i < begin + count; ++i)
                    integrals[triangulation.seed(i)] += t.volume() / 4 / static_cast<double>(count);
        }
    });
    return integrals;
}

}  // namespace

std::size_t add_dtfe(const Task& task, const Built& built, ThreadPool& pool) {
    const std::size_t n = built.tessellation.size(), m = task.columns;
    const Triangulation triangulation(built, task.frame);
    const std::vector<double> parts = integrals(triangulation, n);
    const std::span<const std::int32_t> duplicate_of = built.tessellation.duplicate_of();
    Densities densities{m, std::vector<double>(n * m, 0)};
    std::size_t without = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t to = duplicate_of.empty() || duplicate_of[i] < 0 ? i : at(duplicate_of[i]);
        without += parts[to] == 0;
        if (parts[to] == 0) continue;
        for (std::size_t c = 0; c < m; ++c) densities.values[to * m + c] += task.values[i * m + c] / parts[to];
    }
    overlay(task.frame, pool, triangulation.size(),
            [&] { return std::make_unique<Tetrahedra>(triangulation, densities, task.grid); });
    in_pieces(task.grid.size(), [&](std::size_t begin, std::size_t end) {
        for (double& x : task.grid.subspan(begin, end - begin)) x /= task.frame.cell_volume();
    });
    return without;
}

}  // namespace votess::fields
