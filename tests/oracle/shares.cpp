#include "oracle/shares.hpp"

#include <algorithm>
#include <cmath>

#include "oracle/exact_polygons.hpp"

namespace test {
namespace {

double radius_of(std::span<const ExactPolygon> cell) {
    double radius = 0;
    for (const ExactPolygon& face : cell)
        for (const RationalVector& x : face.corners)
            radius = std::max(radius, std::hypot(x[0].get_d(), x[1].get_d(), x[2].get_d()));
    return radius;
}

// Returns the half-spaces of images but those that are farther than another from all of a ball around the query, with
// much room for rounding.
std::vector<HalfSpace> near_images(const std::vector<HalfSpace>& all, std::int32_t query, double radius) {
    // At x, the power of an image less that of the query is twice h - n.x.
    const auto least = [&](const HalfSpace& s, double sign) {
        return s.h.get_d() + sign * radius * std::sqrt(mpq_class(dot(s.n, s.n)).get_d());
    };
    double nearest = HUGE_VAL;
    for (const HalfSpace& s : all)
        if (s.bisector() && s.face.id != query) nearest = std::min(nearest, least(s, 1));
    const double room = 1e-6 * (std::abs(nearest) + radius * radius);
    std::vector<HalfSpace> near;
    std::ranges::copy_if(all, std::back_inserter(near), [&](const HalfSpace& s) {
        return s.bisector() && s.face.id != query && least(s, -1) <= nearest + room;
    });
    return near;
}

}  // namespace

Shares exact_shares(std::span<const double> points, std::span<const double> weights, const votess::Options& options,
                    const std::array<double, 3>& query, double weight) {
    // The query is the last seed.
    std::vector<double> places(points.begin(), points.end()), all_weights(weights.begin(), weights.end());
    const std::size_t last = points.size() / 3;
    const auto own = static_cast<std::int32_t>(last);
    places.insert(places.end(), query.begin(), query.end());
    if (!weights.empty()) all_weights.push_back(weight);
    votess::Options with_weights = options;
    with_weights.weights = all_weights;
    const std::vector<ExactPolygon> cell = exact_polygons(places, with_weights, last);
    Shares shares;
    shares.volume = volume_of(cell);
    for (const ExactPolygon& face : cell) {
        shares.meets_itself |= face.face.id == own;
        shares.at_wall |= !face.bisector();
        if (!face.bisector() || face.face.id == own) continue;
        Shares::Share& share = shares.of[face.face.id];
        // The area vector is n times `times`, which is the area over the distance.
        const mpq_class square = dot(face.n, face.n);
        mpq_class times = 0;
        for (std::size_t c = 1; c + 1 < face.corners.size(); ++c) {
            const RationalVector &x = face.corners[0], &y = face.corners[c], &z = face.corners[c + 1];
            const mpq_class part = dot(cross(minus(y, x), minus(z, x)), face.n) / square / 2;
            times += part;
            for (std::size_t k = 0; k < 3; ++k) share.gradient[k] += part * (x[k] + y[k] + z[k]) / 3;
        }
        share.area += times.get_d();
    }
    if (cell.empty()) return shares;

    // The part of an image: where no other one has less power.
    const double radius = radius_of(cell);
    const std::vector<HalfSpace> images = near_images(half_spaces(places, with_weights, last), own, radius);
    for (const HalfSpace& image : images) {
        std::vector<HalfSpace> part(cell.begin(), cell.end());
        for (const HalfSpace& other : images)
            if (&other != &image) part.push_back({other.face, minus(other.n, image.n), other.h - image.h});
        const mpq_class volume = volume_of(polytope(std::move(part), radius));
        if (volume > 0) shares.of[image.face.id].volume += volume;
    }
    return shares;
}

}  // namespace test
