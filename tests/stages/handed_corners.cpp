// Corners that cells of a proof hand on.
#include "verify/handed_corners.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>
#include <votess/votess.hpp>

#include "core/at.hpp"
#include "input/settle.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using Corners = std::map<std::array<std::int32_t, 3>, votess::Vector3>;  // by the other seeds and walls

Corners corners_of(const votess::RowPolytope& polytope) {
    Corners corners;
    for (const votess::RowPolytope::Corner& corner : polytope.corners()) {
        std::array<std::int32_t, 3> names{};
        for (std::size_t k = 0; k < 3; ++k) names[k] = polytope.name(corner.planes[k]).id;
        std::ranges::sort(names);
        corners[names] = corner.at;
    }
    return corners;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("corners handed on are those that each cell finds") {
        test::Random random(20261130);
        test::Coordinates points;
        std::vector<double> weights;
        for (int k = 0; k < 600; ++k) points.push_back(random.uniform());
        for (int k = 0; k < 200; ++k) weights.push_back(random.uniform(0, 0.01));
        for (const bool weighted : {false, true})
            for (const std::size_t block : {1u, 7u, 60u, 200u}) {
                votess::Options options;
                options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
                options.list_walls = true;
                options.device = "cpu";
                if (weighted) options.weights = weights;
                const votess::Tessellation t = votess::tessellate(std::span<const double>(points), options);
                votess::Settled settled = votess::settle(options);
                settled.points.f64 = points;
                const votess::Job job = votess::make_job(std::move(settled));
                const votess::SeedPlanes planes(job);
                std::vector<std::int32_t> order, ranks(t.size(), -1);
                for (std::size_t i = 0; i < t.size(); ++i)
                    if (!t.neighbors(i).empty()) order.push_back(static_cast<std::int32_t>(i));
                for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
                for (std::size_t k = 0; k < order.size(); ++k) ranks[votess::at(order[k])] = static_cast<int>(k);
                votess::HandedCorners handed;
                votess::RowPolytope polytope(planes), alone(planes);
                const auto begin = [&](votess::RowPolytope& cell, std::size_t i, std::int32_t without) {
                    cell.begin(i, 0.1);
                    for (const std::int32_t id : t.neighbors(i))
                        if (id != without) cell.add({id, {}});
                };
                std::size_t taken = 0, named = 0, refused = 0, tried = 0;
                for (std::size_t k = 0; k < order.size(); ++k) {
                    const std::size_t i = votess::at(order[k]), listed = t.neighbors(i).size();
                    if (k % block == 0) handed.begin(order, ranks, k, std::min(order.size(), k + block));
                    begin(alone, i, static_cast<std::int32_t>(t.size()));
                    REQUIRE(alone.wrap_surely());
                    const Corners expected = corners_of(alone);
                    // Without a seed of a corner that was handed to it, a cell is not closed.
                    if (k + 1 == order.size()) {
                        for (const std::int32_t id : t.neighbors(i)) {
                            if (id < 0) continue;
                            begin(polytope, i, id);
                            tried += 1;
                            refused += handed.close(polytope, i, listed - 1) ? 0 : 1;
                        }
                    }
                    if (k % 11 == 5) {
                        handed.leave(i, [&](std::array<std::int32_t, 3> others) {
                            std::ranges::sort(others);
                            CHECK(expected.contains(others));
                        });
                        continue;
                    }
                    begin(polytope, i, static_cast<std::int32_t>(t.size()));
                    REQUIRE(handed.close(polytope, i, listed));
                    REQUIRE(handed.hand_on(polytope));
                    taken += polytope.known_edges().size();
                    named += handed.to_name().size();
                    const Corners found = corners_of(polytope);
                    REQUIRE(found.size() == expected.size());
                    CHECK(polytope.corners().size() == found.size());
                    CHECK(2 * polytope.edges().size() == 3 * found.size());
                    for (const auto& [names, place] : found) {
                        REQUIRE(expected.contains(names));
                        const votess::Vector3 off = votess::minus(place, expected.at(names));
                        CHECK(votess::dot(off, off) < 1e-20);
                    }
                }
                if (block == 1) CHECK(taken == 0);
                if (block == 200) {
                    CHECK(taken > 5 * order.size());
                    CHECK(named < 20 * order.size());  // those with walls and cells that were left
                    CHECK(tried > 0);
                    CHECK(refused == tried);
                }
            }
    }
}
