#include "fit/fewer_seeds.hpp"

#include <array>
#include <vector>

#include "core/progress.hpp"

namespace votess::fit {
namespace {

// Among so few seeds around a place usually none lies between the others, where it would get no cell.
std::size_t group_of(const Problem& problem) {
    return static_cast<std::size_t>(problem.dimensions) + 1;
}

}  // namespace

Problem fewer_seeds(const Problem& all) {
    const std::size_t group = group_of(all), count = static_cast<std::size_t>(all.targets.size());
    const std::size_t groups = (count + group - 1) / group;
    Problem few;
    few.edges = all.edges;
    few.run = all.run;
    few.dimensions = all.dimensions;
    few.pool = all.pool;
    few.is_part = true;
    few.points.reserve(3 * groups);
    few.places.reserve(3 * groups);
    few.targets = few.start = Vector::Zero(static_cast<Eigen::Index>(groups));
    in_pieces(count, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto row = static_cast<Eigen::Index>(i / group);
            few.targets[row] += all.targets[static_cast<Eigen::Index>(i)];
            if (i % group != 0) continue;
            few.start[row] = all.start[static_cast<Eigen::Index>(i)];
            few.points.insert(few.points.end(), {all.points[3 * i], all.points[3 * i + 1], all.points[3 * i + 2]});
            few.places.insert(few.places.end(), {all.places[3 * i], all.places[3 * i + 1], all.places[3 * i + 2]});
        }
    });
    return few;
}

Vector spread(const Problem& all, const Weighted& few) {
    const std::size_t group = group_of(all);
    const Tessellation& cells = few.tessellation;
    const std::span<const double> centroids = cells.centroids();
    using Place = std::array<double, 3>;
    const auto square = [](const Place& a, std::span<const double> b, std::size_t i) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) sum += (a[k] - b[3 * i + k]) * (a[k] - b[3 * i + k]);
        return sum;
    };
    std::vector<double> seeds(3 * cells.size()), powers(cells.size());
    for (std::size_t g = 0; g < cells.size(); ++g) {
        for (std::size_t k = 0; k < 3; ++k) seeds[3 * g + k] = all.places[3 * group * g + k];
        const Place center{centroids[3 * g], centroids[3 * g + 1], centroids[3 * g + 2]};
        powers[g] = square(center, seeds, g) - few.weights[static_cast<Eigen::Index>(g)];
    }
    Vector weights(all.targets.size());
    in_pieces(static_cast<std::size_t>(weights.size()), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::size_t at = i / group;
            Place x{all.places[3 * i], all.places[3 * i + 1], all.places[3 * i + 2]};  // from the image at hand
            double least = square(x, centroids, at) - powers[at];
            for (bool moved = true; moved;) {
                moved = false;
                const std::size_t from = at;
                const Place place = x;
                const auto last = static_cast<std::size_t>(cells.indptr()[from + 1]);
                for (auto e = static_cast<std::size_t>(cells.indptr()[from]); e < last; ++e) {
                    if (cells.indices()[e] < 0) continue;
                    const auto next = static_cast<std::size_t>(cells.indices()[e]);
                    Place seen = place;
                    for (std::size_t j = 0; j < 3 && !cells.shifts().empty(); ++j)
                        for (std::size_t k = 0; k < 3; ++k) seen[k] -= cells.shifts()[3 * e + j] * all.edges[j][k];
                    const double weight = square(seen, centroids, next) - powers[next];
                    if (!(weight < least)) continue;
                    least = weight, at = next, x = seen;
                    moved = true;
                }
            }
            weights[static_cast<Eigen::Index>(i)] = least;
        }
    });
    return weights;
}

}  // namespace votess::fit
