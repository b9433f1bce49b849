#include "fit/fewer_seeds.hpp"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "core/progress.hpp"

namespace votess::fit {
namespace {

using Place = Eigen::Vector3d;

// Added along each axis, as a share of all squared ways to neighbors: these may lie in a plane.
constexpr double least_part = 1e-6;

// Among so few seeds around a place usually none lies between the others, where it would get no cell.
std::size_t group_of(const Problem& problem) {
    return static_cast<std::size_t>(problem.dimensions) + 1;
}

// The weights around the seeds of a coarse diagram. Half of |p|^2 - weight is a convex function, whose gradient at a
// seed is the centroid of its cell. Around each seed it is a paraboloid, whose bend is fitted to the centroids of its
// neighbors (Renka 1988). Planes would put all seeds of a group at one centroid, where most have no cell.
class Surface {
public:
    Surface(const Problem& all, const Weighted& few) : all_(all), few_(few), group_(group_of(all)) {
        bends_.resize(cells().size());
        in_pieces(bends_.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) bends_[g] = bend_of(g);
        });
    }

    // Returns the weight of seed i.
    [[nodiscard]] double weight(std::size_t i) const {
        std::size_t at = i / group_;
        Place x = place(all_.places, i);  // from the image at hand
        double least = flat(at, x);
        for (bool moved = true; moved;) {
            moved = false;
            const Place from = x;
            for_neighbors(at, [&](std::size_t next, const Place& shift) {
                const double weight = flat(next, from - shift);
                if (!(weight < least)) return;
                least = weight, at = next, x = from - shift;
                moved = true;
            });
        }
        double sum = 0, shares = 0;
        const double near = (x - seed(at)).squaredNorm();
        const auto add = [&](std::size_t g, const Place& way) {
            const double ratio = near / way.squaredNorm(), share = ratio * ratio;
            sum += share * (flat(g, seed(g) + way) - way.dot(bends_[g] * way));
            shares += share;
        };
        if (near == 0) return least;
        add(at, x - seed(at));
        for_neighbors(at, [&](std::size_t next, const Place& shift) { add(next, x - shift - seed(next)); });
        const double weight = sum / shares;
        return std::isfinite(weight) ? weight : least;
    }

private:
    [[nodiscard]] const Tessellation& cells() const { return few_.tessellation; }
    [[nodiscard]] static Place place(std::span<const double> coordinates, std::size_t i) {
        return {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
    }
    [[nodiscard]] Place seed(std::size_t g) const { return place(all_.places, group_ * g); }
    [[nodiscard]] Place centroid(std::size_t g) const { return place(cells().centroids(), g); }
    // Calls visit(neighbor, shift of its image).
    template <class Visit>
    void for_neighbors(std::size_t g, const Visit& visit) const {
        const auto end = static_cast<std::size_t>(cells().indptr()[g + 1]);
        for (auto e = static_cast<std::size_t>(cells().indptr()[g]); e < end; ++e) {
            if (cells().indices()[e] < 0) continue;
            Place shift = Place::Zero();
            for (std::size_t j = 0; j < 3 && !cells().shifts().empty(); ++j)
                shift += cells().shifts()[3 * e + j] * Place(all_.edges[j].data());
            visit(static_cast<std::size_t>(cells().indices()[e]), shift);
        }
    }
    // Returns the weight with which the cell of a seed at x touches the centroid of that cell.
    [[nodiscard]] double flat(std::size_t g, const Place& x) const {
        const Place way = x - seed(g);
        return few_.weights[static_cast<Eigen::Index>(g)] + way.squaredNorm() - 2 * way.dot(centroid(g) - seed(g));
    }
    // Returns the derivative of centroids by the places of seeds, symmetric.
    [[nodiscard]] Eigen::Matrix3d bend_of(std::size_t g) const {
        Eigen::Matrix3d ways = Eigen::Matrix3d::Zero(), both = Eigen::Matrix3d::Zero();
        for_neighbors(g, [&](std::size_t next, const Place& shift) {
            const Place way = seed(next) + shift - seed(g);
            const Place moved = centroid(next) + shift - centroid(g);
            const double share = 1 / way.squaredNorm();
            ways += share * way * way.transpose();
            both += share * moved * way.transpose();
        });
        if (!(ways.trace() > 0)) return Eigen::Matrix3d::Zero();
        ways.diagonal().array() += least_part * ways.trace();
        const Eigen::Matrix3d bend = both * ways.inverse();  // not finite beside a seed whose distance underflows
        return 0.5 * (bend + bend.transpose());
    }

    const Problem& all_;
    const Weighted& few_;
    std::size_t group_;
    std::vector<Eigen::Matrix3d> bends_;
};

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
    const Surface surface(all, few);
    Vector weights(all.targets.size());
    in_pieces(static_cast<std::size_t>(weights.size()), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) weights[static_cast<Eigen::Index>(i)] = surface.weight(i);
    });
    return weights;
}

}  // namespace votess::fit
