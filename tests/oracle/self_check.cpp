// The oracle itself: what is known of a diagram without any program.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "oracle/brute_force.hpp"
#include "support/generators.hpp"

namespace {

std::vector<std::int32_t> faces(const test::PointSet& set, std::size_t i) {
    return test::brute_force(set.points, *set.box).cells[i].faces;
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("brute force: one seed has the six walls and the volume of the box") {
        const test::PointSet one{"one", {0.25, 0.5, 0.125}, votess::Box{{0, 0, 0}, {1, 2, 4}}};
        const auto diagram = test::brute_force(one.points, *one.box);
        CHECK(diagram.cells[0].faces == std::vector<std::int32_t>{-6, -5, -4, -3, -2, -1});
        CHECK(diagram.cells[0].volume == 8);
        CHECK(diagram.cells[0].centroid[0] == 0.5);
        CHECK(diagram.cells[0].centroid[1] == 1);
        CHECK(diagram.cells[0].centroid[2] == 2);
        CHECK(diagram.cells[0].edges == 12);
        CHECK(diagram.cells[0].vertices == 8);
        CHECK(diagram.cells[0].extent == std::array<double, 3>{1, 2, 4});
    }

    TEST_CASE("brute force: the middle of 3 x 3 x 3 has six neighbors") {
        CHECK(faces(test::cubic(3), 13) == std::vector<std::int32_t>{4, 10, 12, 14, 16, 22});
    }

    TEST_CASE("brute force: a corner that only touches is no neighbor, one step of nextafter makes it one") {
        // Four seeds of a square: the diagonal pairs touch in an edge.
        test::PointSet square{"square", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, test::cube(-1, 2)};
        CHECK(faces(square, 0) == std::vector<std::int32_t>{-6, -5, -3, -1, 1, 2});
        square.points[9] = std::nextafter(1.0, 0.0);
        CHECK(faces(square, 0) == std::vector<std::int32_t>{-6, -5, -3, -1, 1, 2, 3});
    }

    TEST_CASE("brute force: volumes fill the box, Euler, symmetry, and the local test agrees") {
        for (const test::PointSet& set : {test::uniform(20, 1), test::nested_clusters(20, 2), test::on_walls(20, 3),
                                          test::cospherical_and_center(5), test::with_duplicates(20, 4, 5)}) {
            CAPTURE(set.name);
            const auto diagram = test::brute_force(set.points, *set.box);
            mpf_class sum(0, test::precision);
            for (const auto& cell : diagram.cells) sum += cell.volume;
            const mpf_class box = test::exact_volume(*set.box);
            CHECK(abs(sum - box) < box * 1e-80);
            for (std::size_t i = 0; i < set.size(); ++i) {
                const auto& cell = diagram.cells[i];
                if (diagram.duplicate_of[i] >= 0) {
                    CHECK(cell.faces.empty());
                    continue;
                }
                CHECK(cell.vertices + cell.faces.size() == cell.edges + 2);
                for (std::int32_t j = -6; j < static_cast<std::int32_t>(set.size()); ++j) {
                    const bool lists = std::binary_search(cell.faces.begin(), cell.faces.end(), j);
                    if (j >= 0) {
                        const auto& other = diagram.cells[static_cast<std::size_t>(j)].faces;
                        CHECK(lists == std::binary_search(other.begin(), other.end(), static_cast<std::int32_t>(i)));
                        if (diagram.duplicate_of[static_cast<std::size_t>(j)] >= 0) continue;
                    }
                    if (j != static_cast<std::int32_t>(i)) CHECK(lists == test::exact_face(set.points, *set.box, i, j));
                }
            }
        }
    }
}
