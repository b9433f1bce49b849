// Cells of very many faces: a plane finds the vertices that it cuts by climbing along edges.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "exact/predicate.hpp"
#include "polytope/cell.hpp"
#include "support/cell_faces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using votess::cpu::Cell;
using votess::exact::Plane;
using votess::exact::Point;

// Clips the cell of 0 by the bisectors with these seeds.
void clip_by(Cell& cell, const std::vector<Point>& seeds, const std::vector<std::int32_t>& order) {
    cell.start({}, votess::Box{{-100, -100, -100}, {100, 100, 100}});
    for (const std::int32_t i : order) cell.clip(i, seeds[static_cast<std::size_t>(i)]);
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE(
        "large cell: bisectors with a shell of a lattice leave the same faces in any order, and no vertex outside") {
        // Many planes meet in a vertex, many touch one, and many cut nothing.
        const int nearest = test::reduced() ? 60 : 400, farthest = nearest + 12;
        std::vector<Point> seeds;
        for (int x = -21; x <= 21; ++x)
            for (int y = -21; y <= 21; ++y)
                for (int z = -21; z <= 21; ++z)
                    if (const int square = x * x + y * y + z * z; nearest <= square && square <= farthest)
                        seeds.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
        std::vector<std::int32_t> order(seeds.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
        Cell cell;
        clip_by(cell, seeds, order);
        const std::vector<std::int32_t> faces = test::faces_of(cell);
        REQUIRE(faces.size() > (test::reduced() ? 100 : 600));
        CHECK(faces.size() < seeds.size());
        for (int slot = 0; slot < cell.slots(); ++slot) {
            if (!cell.alive(slot)) continue;
            const auto [a, b, c] = cell.corner_planes(slot);
            for (const Point& q : seeds)
                REQUIRE(votess::exact::side_of_vertex({}, a->source, b->source, c->source, Plane::bisector(q)) <= 0);
        }
        test::Random random(4);
        for (int turn = 0; turn < 4; ++turn) {
            CAPTURE(turn);
            for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
            if (turn == 0)
                std::ranges::stable_sort(order, {}, [&](std::int32_t i) {
                    const auto& [x, y, z] = seeds[static_cast<std::size_t>(i)];
                    return x * x + y * y + z * z;
                });
            clip_by(cell, seeds, order);
            CHECK(test::faces_of(cell) == faces);
        }
    }

    TEST_CASE("large cell: 100,000 seeds around one on a spiral, each with a face") {
        const std::size_t count = test::by_size(100'000, 3000);
        std::vector<Point> seeds;
        std::vector<std::int32_t> order;
        for (const votess::Wall& wall : votess::sphere_walls({0, 0, 0}, 1, count)) {
            order.push_back(static_cast<std::int32_t>(seeds.size()));
            seeds.push_back(wall.normal);
        }
        Cell cell;
        clip_by(cell, seeds, order);
        CHECK(test::faces_of(cell).size() == count);
    }
}
