#include "write/nearest_images.hpp"

#include <cmath>
#include <limits>

#include "domain.hpp"

namespace clvotess {
namespace {

Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

NearestImages::NearestImages(std::span<const double> points, const votess::Tessellation& cells)
    : points_(points), size_(size_of_vectors(cells)) {
    for (std::size_t k = 0; k < 3; ++k) {
        if (cells.periodic()[k]) side_[k] = cells.box().upper[k] - cells.box().lower[k];
    }
    if (!cells.cell()) return;
    triclinic_ = true;
    edges_ = {cells.cell()->a, cells.cell()->b, cells.cell()->c};
    if (cells.planar()) edges_[2] = {0, 0, 1};
    for (std::size_t k = 0; k < 3; ++k) {
        reach_[k] = cells.periodic()[k] ? 2 : 0;
        // An edge without period only helps to find coordinates along the others: use the normal of these.
        if (!cells.periodic()[k]) edges_[k] = cross(edges_[(k + 1) % 3], edges_[(k + 2) % 3]);
    }
    for (std::size_t k = 0; k < 3; ++k) {  // rows that map a vector to coordinates along the edges
        inverse_[k] = cross(edges_[(k + 1) % 3], edges_[(k + 2) % 3]);
        const double volume = dot(inverse_[k], edges_[k]);
        for (double& x : inverse_[k]) x /= volume;
    }
}

Point NearestImages::image(std::size_t i, const Point& inside) const {
    Point seed{};
    for (std::size_t k = 0; k < size_; ++k) seed[k] = points_[size_ * i + k];
    if (std::isnan(inside[0])) return seed;  // no cell
    if (triclinic_) return nearest_in_lattice(seed, inside);
    for (std::size_t k = 0; k < 3; ++k) {
        if (side_[k] > 0) seed[k] += std::round((inside[k] - seed[k]) / side_[k]) * side_[k];
    }
    return seed;
}

// Tries the images around the rounded coordinates along the edges, because in a skewed box rounding may miss the
// nearest.
Point NearestImages::nearest_in_lattice(Point seed, const Point& inside) const {
    const Point apart{inside[0] - seed[0], inside[1] - seed[1], inside[2] - seed[2]};
    Point rounded{};
    for (std::size_t k = 0; k < 3; ++k) rounded[k] = reach_[k] > 0 ? std::round(dot(inverse_[k], apart)) : 0;
    double least = std::numeric_limits<double>::infinity();
    Point best = seed;
    for (int i = -reach_[0]; i <= reach_[0]; ++i) {
        for (int j = -reach_[1]; j <= reach_[1]; ++j) {
            for (int l = -reach_[2]; l <= reach_[2]; ++l) {
                const Point steps{rounded[0] + i, rounded[1] + j, rounded[2] + l};
                Point image = seed, rest{};
                for (std::size_t k = 0; k < 3; ++k) {
                    for (std::size_t e = 0; e < 3; ++e) image[k] += steps[e] * edges_[e][k];
                    rest[k] = inside[k] - image[k];
                }
                if (dot(rest, rest) >= least) continue;
                least = dot(rest, rest);
                best = image;
            }
        }
    }
    return best;
}

}  // namespace clvotess
