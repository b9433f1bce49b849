// The cell P of a probe, divided by the bisectors between its neighbors: how much of it each of them had before. Its
// volumes are Sibson's natural-neighbor coordinates, over the volume of P (A vector identity for the Dirichlet
// tessellation, Math. Proc. Camb. Phil. Soc. 87, 1980).
//
// The volume of a part is a sum over the edges of its faces: V x W, for an edge from V to W counterclockwise around a
// face, sums to twice the area vector A of the face, and A.R / 3 is the volume of the pyramid between it and the probe,
// with R anywhere on the plane of the face. Edges come in any order; lengths are relative to the probe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace votess::cpu {

class Division {
public:
    using Vector = std::array<double, 3>;
    static constexpr std::size_t most_neighbors = 32;

    void begin(bool moments) {
        count_ = 0;
        moments_ = moments;
    }
    // The bisector with a neighbor is n.x = h. Returns its number, the next one, or most_neighbors.
    std::size_t add_neighbor(std::int32_t seed, const Vector& n, double h);
    // An edge of P between the faces of neighbors a and b, counterclockwise around that of a.
    void add_rim(std::size_t a, std::size_t b, const Vector& v, const Vector& w);
    // An edge inside, as near to neighbors a, b and c: direction(a, b, c) points from v to w.
    void add_inner(std::size_t a, std::size_t b, std::size_t c, const Vector& v, const Vector& w);
    // False when the parts do not balance, which shows that an edge was wrong or missing: by Sibson's identity, the sum
    // of volume times neighbor is 0.
    [[nodiscard]] bool finish();

    [[nodiscard]] std::size_t size() const { return count_; }
    [[nodiscard]] std::int32_t seed(std::size_t a) const { return seeds_[a]; }
    [[nodiscard]] Vector normal(std::size_t a) const { return {nx_[a], ny_[a], nz_[a]}; }
    [[nodiscard]] double height(std::size_t a) const { return h_[a]; }
    // After finish().
    [[nodiscard]] double volume(std::size_t a) const { return volumes_[a]; }
    [[nodiscard]] const Vector& area(std::size_t a) const { return areas_[a]; }     // vector of the face of P
    [[nodiscard]] const Vector& moment(std::size_t a) const { return moment_[a]; }  // the integral of x over it

    // By number, padded with planes that nothing meets up to a multiple of four.
    static constexpr double never = 1e300;
    struct Planes {
        const double *nx, *ny, *nz, *h;
        std::size_t count;
    };
    [[nodiscard]] Planes planes();
    // Along the line of points as near to a, b and c.
    [[nodiscard]] Vector direction(std::size_t a, std::size_t b, std::size_t c) const;

private:
    void add_across(std::size_t a, std::size_t b, const Vector& across, double sign);

    std::size_t count_ = 0;
    bool moments_ = false;
    std::array<std::int32_t, most_neighbors> seeds_{};
    alignas(64) std::array<double, most_neighbors> nx_{}, ny_{}, nz_{}, h_{};
    std::array<Vector, most_neighbors> areas_{}, moment_{};
    std::array<double, most_neighbors> volumes_{};
    // Twice the area vector of the face between parts a < b, outward from a, by most_neighbors a + b.
    std::array<Vector, most_neighbors * most_neighbors> across_;
    std::array<std::uint32_t, most_neighbors> known_{};  // by a: bits of b
};

}  // namespace votess::cpu
