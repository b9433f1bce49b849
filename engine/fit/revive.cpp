#include "fit/revive.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/progress.hpp"

namespace votess::fit {
namespace {

using Place = Eigen::Vector3d;

Place place_of(std::span<const double> coordinates, std::size_t i) {
    return {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
}

class Search {
public:
    Search(const Revival& cells, const Vector& weights) : cells_(cells), weights_(weights) {}

    struct Touch {
        double weight = std::numeric_limits<double>::infinity();  // with which a cell touches the centroid of another
        double volume = 0;                                        // of the other
    };
    [[nodiscard]] Touch touch_of(std::size_t seed) const {
        Touch best;
        const Place place = place_of(cells_.places, seed);
        for_neighbors(cells_.before, seed, [&](std::size_t near, const Place& shift) {
            consider(near, shift, place, best);
            for_neighbors(cells_.after, near,
                          [&](std::size_t next, const Place& more) { consider(next, shift + more, place, best); });
        });
        return best;
    }
    [[nodiscard]] bool is_small(std::size_t i) const {
        const auto row = static_cast<Eigen::Index>(i);
        return !(cells_.volumes[row] >= cells_.least[row]);
    }

private:
    template <class Visit>
    void for_neighbors(const Tessellation& t, std::size_t i, const Visit& visit) const {
        const auto end = static_cast<std::size_t>(t.indptr()[i + 1]);
        for (auto at = static_cast<std::size_t>(t.indptr()[i]); at < end; ++at) {
            if (t.indices()[at] < 0) continue;
            Place shift = Place::Zero();
            for (std::size_t e = 0; e < 3 && !t.shifts().empty(); ++e)
                shift += t.shifts()[3 * at + e] * Place(cells_.edges[e].data());
            visit(static_cast<std::size_t>(t.indices()[at]), shift);
        }
    }
    void consider(std::size_t other, const Place& shift, const Place& place, Touch& best) const {
        if (is_small(other)) return;
        const Place centroid = place_of(cells_.centroids, other) + shift;
        const double power = (centroid - shift - place_of(cells_.places, other)).squaredNorm() -
                             weights_[static_cast<Eigen::Index>(other)];
        const double weight = (centroid - place).squaredNorm() - power;
        if (weight < best.weight) best = {weight, cells_.volumes[static_cast<Eigen::Index>(other)]};
    }

    const Revival& cells_;
    const Vector& weights_;
};

}  // namespace

void revive(const Revival& cells, int attempt, Vector& weights) {
    const Search search(cells, weights);
    Vector raised = weights;
    in_pieces(cells.after.size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) {
            if (!search.is_small(i)) continue;
            const Search::Touch touch = search.touch_of(i);
            if (!std::isfinite(touch.weight)) continue;
            // A volume is about the cube of the weight above that of an empty cell, an area the square.
            const auto row = static_cast<Eigen::Index>(i);
            const double size = std::pow(2 * cells.targets[row] / touch.volume, 1.0 / cells.dimensions);
            raised[row] += std::min(1.0, std::ldexp(size, 1 + 2 * attempt)) * (touch.weight - raised[row]);
        }
    });
    weights = std::move(raised);
}

}  // namespace votess::fit
