// Divides the cell P of a probe by the bisectors between its neighbors. The part of a neighbor is the share of P that
// its own cell had before. Part volumes over the volume of P are Sibson's natural-neighbor coordinates (A vector
// identity for the Dirichlet tessellation, Math. Proc. Camb. Phil. Soc. 87, 1980).
//
// The volume of a part is a sum over the edges of its faces. For an edge from V to W, counterclockwise around a face,
// V x W sums to twice the area vector A of the face. A.R / 3 is the volume of the pyramid between face and probe, with
// R anywhere on the plane of the face. On the bisector of a and b, R may be the middle (a + b) / 2. The area vectors of
// a part sum to 0, so a drops out, and the volume is the sum of A.b / 6 over its faces. Without weights an edge between
// the faces of a, b and c adds to three parts, so no face needs to be known. Edges come in any order. Lengths are
// relative to the probe. A wall of P is a neighbor without a part.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "core/vector3.hpp"

namespace votess::cpu {

class Division {
public:
    using Vector = Vector3;
    static constexpr std::size_t max_neighbors = 32;

    void begin(bool weighted, bool moments) {
        count_ = neighbors_ = 0;
        weighted_ = weighted;
        moments_ = moments;
        for (std::size_t e = 0; e < 3 * corner_count_; ++e) ends_[edges_[e]] = 0;
        corner_count_ = 0;
        farthest_squared_ = 0;
        min_apart_squared_ = std::numeric_limits<double>::infinity();
    }
    // The bisector with a neighbor is n.x = h. Returns its number, the next one, or max_neighbors.
    std::size_t add_neighbor(std::int32_t seed, const Vector& n, double h);
    // The plane n.x = h of a wall, after all neighbors.
    std::size_t add_wall(const Vector& n, double h);
    // A vertex of P on the faces of a, b and c, not all of them walls: direction(a, b, c) leads out of P. Returns false
    // when there are too many. All must be on their planes.
    [[nodiscard]] bool add_corner(std::size_t a, std::size_t b, std::size_t c, const Vector& x);
    // Returns how far x lies within the plane of a, times the length of its normal.
    [[nodiscard]] double residual(std::size_t a, const Vector& x) const { return h_[a] - along(a, x); }
    // Adds the edges between all corners. Returns false when one has no end.
    [[nodiscard]] bool add_rims();
    // Adds an inner edge from v to w, along direction(a, b, c). It is equally near to a, b and c, or lies on walls
    // among them. Between two walls it is also an edge of P.
    void add_inner(std::size_t a, std::size_t b, std::size_t c, const Vector& v, const Vector& w) {
        const Vector across = cross(v, w);
        if (weighted_ || is_wall(a) || is_wall(b) || is_wall(c)) return add_general(a, b, c, across);
        const double of_a = along(a, across), of_b = along(b, across), of_c = along(c, across);
        volumes_[a] += of_b - of_c;
        volumes_[b] += of_c - of_a;
        volumes_[c] += of_a - of_b;
    }
    // Returns false when rounding may have changed a share by 1e-12, or may have made its sign.
    [[nodiscard]] bool finish();

    [[nodiscard]] std::size_t size() const { return neighbors_; }
    [[nodiscard]] bool is_wall(std::size_t a) const { return a >= neighbors_; }
    [[nodiscard]] std::int32_t seed(std::size_t a) const { return seeds_[a]; }
    [[nodiscard]] Vector normal(std::size_t a) const { return {nx_[a], ny_[a], nz_[a]}; }
    [[nodiscard]] double height(std::size_t a) const { return h_[a]; }
    // After finish().
    [[nodiscard]] double volume(std::size_t a) const { return volumes_[a]; }
    [[nodiscard]] const Vector& moment(std::size_t a) const { return moment_[a]; }  // integral of x over its face

    // Components of normals by number, walls too; readable up to max_neighbors.
    struct Normals {
        const double *x, *y, *z;
        std::size_t count;
    };
    [[nodiscard]] Normals normals() const { return {nx_.data(), ny_.data(), nz_.data(), count_}; }
    // Returns the direction of the points equally near to a, b and c, where a is not a wall.
    [[nodiscard]] Vector direction(std::size_t a, std::size_t b, std::size_t c) const;

private:
    [[nodiscard]] double along(std::size_t a, const Vector& across) const {
        return nx_[a] * across[0] + ny_[a] * across[1] + nz_[a] * across[2];
    }
    // Stands for the probe beside two of its neighbors.
    static constexpr std::size_t probe = max_neighbors;
    // The edge runs counterclockwise around the face of a.
    void add_rim(std::size_t a, std::size_t b, const Vector& v, const Vector& w) {
        const Vector across = cross(v, w);
        if (weighted_ || is_wall(a) || is_wall(b)) {
            add_general(b, a, probe, across);
        } else {
            volumes_[b] += along(a, across);
            volumes_[a] -= along(b, across);
        }
        if (moments_) add_moments(a, b, v, w);
    }
    // Adds an edge when there are weights or walls.
    void add_general(std::size_t a, std::size_t b, std::size_t c, const Vector& across);
    [[nodiscard]] double beyond(std::size_t a, std::size_t b, const Vector& across);
    void add_moments(std::size_t a, std::size_t b, const Vector& v, const Vector& w);

    std::size_t count_ = 0, neighbors_ = 0;
    bool weighted_ = false, moments_ = false;
    double farthest_squared_ = 0;   // to a corner of P
    double min_apart_squared_ = 0;  // of neighbors whose common face needed the difference of their bisectors
    std::array<std::int32_t, max_neighbors> seeds_{};
    alignas(64) std::array<double, max_neighbors> nx_{}, ny_{}, nz_{}, h_{};
    std::array<Vector, max_neighbors> moment_{};
    std::array<double, max_neighbors + 1> volumes_{};  // 12 times those until finish(); none of the probe
    static constexpr std::size_t max_corners = 2 * max_neighbors;
    std::array<Vector, max_corners> corners_;
    std::size_t corner_count_ = 0;
    // By max_neighbors a + b: 1 + the corner where the edge between their faces ends, counterclockwise around a.
    std::array<std::uint16_t, max_neighbors * max_neighbors> ends_{};
    std::array<std::uint16_t, 3 * max_corners> edges_;  // places of ends_ in use, three a corner
};

}  // namespace votess::cpu
