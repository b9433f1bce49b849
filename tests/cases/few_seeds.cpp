// None, one, two, four: everything known by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/check.hpp"

using Row = std::vector<std::int32_t>;

TEST_SUITE("cases") {
    TEST_CASE("no seeds: an empty result") {
        const std::span<const double> none;
        for (const bool with_box : {false, true}) {
            const auto t =
                votess::tessellate(none, test::all_options(with_box ? std::optional(test::unit_box()) : std::nullopt));
            CHECK(t.size() == 0);
            REQUIRE(t.indptr().size() == 1);
            CHECK(t.indptr()[0] == 0);
            CHECK(t.indices().empty());
            CHECK(t.volumes().empty());
            CHECK(t.status().empty());
            CHECK(t.stats().points == 0);
            CHECK(t.stats().faces == 0);
            CHECK(votess::verify(t, none).passed);
        }
        CHECK(votess::Tessellation().size() == 0);
    }

    TEST_CASE("one seed: the box") {
        for (const auto& p : {std::array{0.5, 0.5, 0.5}, std::array{0.1, 0.9, 0.3}, std::array{0.0, 1.0, 0.0}}) {
            const auto t = votess::tessellate(p, test::all_options(test::unit_box()));
            CHECK(test::row_of(t, 0) == Row{-6, -5, -4, -3, -2, -1});
            CHECK(t.volumes()[0] == doctest::Approx(1).epsilon(1e-14));
            for (std::size_t a = 0; a < 3; ++a) CHECK(std::abs(t.centroids()[a] - 0.5) <= 1e-15);
            CHECK(t.vertex_counts()[0] == 8);
            CHECK(test::check_exact(t, p) == "");
        }
    }

    TEST_CASE("one seed, default box: half the largest coordinate around it, 0.5 around the origin") {
        const std::array origin{0.0, 0.0, 0.0};
        const auto at_origin = votess::tessellate(origin, test::all_options());
        CHECK(at_origin.box().lower == std::array{-0.5, -0.5, -0.5});
        CHECK(at_origin.box().upper == std::array{0.5, 0.5, 0.5});
        CHECK(at_origin.volumes()[0] == doctest::Approx(1).epsilon(1e-14));
        const std::array elsewhere{1.0, -4.0, 2.0};
        const auto t = votess::tessellate(elsewhere, test::all_options());
        CHECK(t.box().lower == std::array{-1.0, -6.0, 0.0});
        CHECK(t.box().upper == std::array{3.0, -2.0, 4.0});
        CHECK(t.volumes()[0] == doctest::Approx(64).epsilon(1e-14));
    }

    TEST_CASE("default box: bounds moved out by half of longest side over the cube root of N") {
        const std::array points{0.0, 0.0, 0.0, 8.0, 1.0, 2.0, 4.0, 0.5, 2.0, 4.0, 0.5, 1.0,
                                1.0, 0.5, 1.0, 2.0, 0.5, 1.0, 3.0, 0.5, 1.0, 5.0, 0.5, 1.0};
        const auto t = votess::tessellate(points, test::all_options());
        for (std::size_t a = 0; a < 3; ++a) {
            const double upper[] = {8, 1, 2};
            CHECK(std::abs(t.box().lower[a] + 2) <= 1e-12);
            CHECK(std::abs(t.box().upper[a] - upper[a] - 2) <= 1e-12);
        }
        CHECK(test::check_exact(t, points) == "");
    }

    TEST_CASE("two seeds share one face") {
        const std::array points{0.25, 0.5, 0.5, 0.5, 0.5, 0.5};
        const auto t = votess::tessellate(points, test::all_options(test::unit_box()));
        CHECK(test::row_of(t, 0) == Row{-6, -5, -4, -3, -1, 1});
        CHECK(test::row_of(t, 1) == Row{-6, -5, -4, -3, -2, 0});
        CHECK(t.volumes()[0] == doctest::Approx(0.375).epsilon(1e-14));
        CHECK(t.volumes()[1] == doctest::Approx(0.625).epsilon(1e-14));
        CHECK(test::check_exact(t, points) == "");
    }

    TEST_CASE("two seeds one step of nextafter apart") {
        for (const double x : {0.5, 0.3, 1e-5}) {
            const std::array points{x, 0.4, 0.6, std::nextafter(x, 1.0), 0.4, 0.6};
            const auto t = votess::tessellate(points, test::all_options(test::unit_box()));
            CHECK(test::row_of(t, 0) == Row{-6, -5, -4, -3, -1, 1});
            CHECK(test::check_exact(t, points) == "");
        }
    }

    TEST_CASE("two seeds in opposite corners: the bisector passes through corners of the box") {
        const std::array points{0.0, 0.0, 0.0, 1.0, 1.0, 1.0};  // a hexagon
        const auto t = votess::tessellate(points, test::all_options(test::unit_box()));
        CHECK(t.face_counts()[0] == 7);
        CHECK(t.volumes()[0] == doctest::Approx(0.5).epsilon(1e-14));
        CHECK(test::check_exact(t, points) == "");
        const std::array diagonal{0.0, 0.0, 0.5, 1.0, 1.0, 0.5};  // through two edges of the box: prisms
        const auto prisms = votess::tessellate(diagonal, test::all_options(test::unit_box()));
        CHECK(test::row_of(prisms, 0) == Row{-6, -5, -3, -1, 1});
        CHECK(prisms.vertex_counts()[0] == 6);
        CHECK(test::check_exact(prisms, diagonal) == "");
    }

    TEST_CASE("four seeds: square, tetrahedron") {
        const std::array square{0.25, 0.25, 0.5, 0.75, 0.25, 0.5, 0.25, 0.75, 0.5, 0.75, 0.75, 0.5};
        const auto t = votess::tessellate(square, test::all_options(test::unit_box()));
        CHECK(test::row_of(t, 0) == Row{-6, -5, -3, -1, 1, 2});
        CHECK(test::row_of(t, 3) == Row{-6, -5, -4, -2, 1, 2});
        CHECK(t.volumes()[2] == doctest::Approx(0.25).epsilon(1e-14));
        const std::array tetrahedron{0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75, 0.25, 0.75, 0.25, 0.75, 0.75};
        const auto u = votess::tessellate(tetrahedron, test::all_options(test::unit_box()));
        for (std::size_t i = 0; i < 4; ++i) {
            CHECK(u.volumes()[i] == doctest::Approx(0.25).epsilon(1e-14));
            CHECK(std::count_if(u.neighbors(i).begin(), u.neighbors(i).end(), [](auto j) { return j >= 0; }) == 3);
        }
        CHECK(test::check_exact(u, tetrahedron) == "");
    }

    TEST_CASE("seeds on every corner of the box") {
        test::PointSet set = test::cubic(2);
        set.box = test::unit_box();
        const auto t = test::run(set);
        for (std::size_t i = 0; i < 8; ++i) {
            CHECK(t.neighbors(i).size() == 6);
            CHECK(t.volumes()[i] == doctest::Approx(0.125).epsilon(1e-14));
        }
        CHECK(test::check_exact(t, set.points) == "");
    }
}
