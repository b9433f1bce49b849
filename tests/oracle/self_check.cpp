// The oracles themselves: the certificate refutes another diagram, and half-spaces agree with it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "oracle/certificate.hpp"
#include "oracle/half_spaces.hpp"
#include "support/arrays.hpp"
#include "support/check.hpp"
#include "support/scattered.hpp"

TEST_SUITE("oracle") {
    TEST_CASE("oracles: the certificate refutes the diagram of other seeds") {
        const test::PointSet set = test::uniform(20, 1);
        votess::Options options = test::all_options(set.box);
        options.want.normals = true;
        const auto t = votess::tessellate(set.points, options);
        CHECK(test::check_certificate(t, set.points, options) == "");
        CHECK(test::check_against_half_spaces(t, set.points, options) == "");
        // A new seed in a cell cuts it; a seed that moves far changes rows, one that moves little changes volumes.
        for (std::size_t i = 0; i < set.size(); ++i)
            for (const double distance : {0.2, 1e-6}) {
                test::PointSet moved = set;
                moved.points[3 * i] += moved.points[3 * i] < 0.5 ? distance : -distance;
                CHECK(test::check_certificate(t, moved.points, options) != "");
                CHECK(test::check_against_half_spaces(t, moved.points, options) != "");
            }
    }

    TEST_CASE("oracles: a corner that only touches is no neighbor, one step of nextafter makes it one") {
        // Four seeds of a square: the diagonal pairs touch in an edge.
        test::PointSet square{"square", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, test::cube(-1, 2)};
        const votess::Options options = test::all_options(square.box);
        const auto row = [&](std::size_t i) {
            std::vector<std::int32_t> ids;
            for (const test::ExactFace& face : test::exact_cell(square.points, options, i).faces)
                ids.push_back(face.id);
            return ids;
        };
        CHECK(row(0) == std::vector<std::int32_t>{-6, -5, -3, -1, 1, 2});
        const auto touching = test::run(square);
        square.points[9] = std::nextafter(1.0, 0.0);
        CHECK(row(0) == std::vector<std::int32_t>{-6, -5, -3, -1, 1, 2, 3});
        CHECK(test::check_certificate(touching, square.points, options) != "");
        CHECK(test::check_certificate(test::run(square), square.points, options) == "");
    }

    TEST_CASE("oracles: comparisons name the array that differs") {
        test::PointSet set = test::uniform(30, 2);
        set.points.insert(set.points.end(), set.points.begin(), set.points.begin() + 3);  // a duplicate
        votess::Options options = test::all_options(set.box);
        options.periodic = {true, true, true};
        options.want.normals = options.want.surfaces = options.want.radii = true;
        const auto t = test::run(set, options);
        votess::RowArrays<votess::detail::Vector> rows;
        test::copy_arrays(t, rows);
        CHECK(test::different_array(rows, t, test::same_bits) == "");
        CHECK(test::different_cell(rows, 0, t, 0) == "");
        votess::for_row_arrays([&](const auto& array, std::size_t) {
            auto& value = array.of(rows).at(0);
            const auto old = value;
            if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>)
                value = votess::CellStatus::empty;
            else
                ++value;
            CHECK(test::different_array(rows, t) == array.name);
            CHECK(test::different_cell(rows, 0, t, 0) == array.name);
            CHECK(test::different_cell(rows, 1, t, 1) == "");
            value = old;
        });
    }

    TEST_CASE("oracles: seeds far outside of an oblique cell have all images that touch") {
        test::Scattered s;
        for (std::uint64_t seed = 52; seed < 58; ++seed) {
            test::scatter(5, 12, 5, true, seed, s);
            for (std::size_t i = 0; i < 12; ++i) {
                CAPTURE(seed);
                CHECK(test::exact_cell(s.points, s.options, i).faces ==
                      test::exact_cell(s.points, s.options, i, 9).faces);
            }
        }
    }
}
