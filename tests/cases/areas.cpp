// Wanted areas and normals.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

std::span<const double> areas_of(const votess::Tessellation& t, std::size_t i) {
    return t.face_areas().subspan(static_cast<std::size_t>(t.indptr()[i]), t.neighbors(i).size());
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("areas: coordinates times a power of two") {
        const test::PointSet set = test::uniform(test::by_size(2000, 300), 31);
        const auto t = test::run(set);
        for (const double factor : {0x1p-300, 0x1p-30, 0x1p30, 0x1p300}) {
            const auto u = test::run(test::scaled(set, factor));
            for (std::size_t k = 0; k < t.face_areas().size(); ++k)
                REQUIRE(u.face_areas()[k] == t.face_areas()[k] * factor * factor);
        }
    }

    TEST_CASE("areas: digits of volumes and centroids are the same with and without them") {
        test::Random random(34);
        for (int set = 0; set < 100; ++set) {
            CAPTURE(set);
            test::Coordinates points;  // a cluster, whose cells are vast
            const double middle = random.uniform(0.2, 0.8);
            for (int k = 0; k < 15; ++k) points.push_back(middle + std::ldexp(random.uniform(), -20 - set % 20));
            votess::Options options = test::all_options(test::unit_box());
            options.want = {.volumes = true, .centroids = true};
            const auto t = votess::tessellate(std::span<const double>(points), options);
            options.want.areas = true;
            const auto with = votess::tessellate(std::span<const double>(points), options);
            CHECK(std::ranges::equal(t.volumes(), with.volumes()));
            CHECK(std::ranges::equal(t.centroids(), with.centroids()));
        }
    }

    TEST_CASE("areas: without walls in the rows there are none of walls; areas add neighbors") {
        const test::PointSet set = test::uniform(test::by_size(1000, 200), 32);
        const auto full = test::run(set);
        votess::Options options = test::all_options();
        options.list_walls = false;
        options.want = {.neighbors = false, .volumes = false, .areas = true};
        const auto t = test::run(set, options);
        CHECK(t.indptr().size() == set.size() + 1);
        CHECK(t.volumes().empty());
        REQUIRE(t.face_areas().size() == t.indices().size());
        for (std::size_t i = 0; i < set.size(); ++i) {
            const auto with = areas_of(full, i), without = areas_of(t, i);
            REQUIRE(std::ranges::equal(with.last(without.size()), without));  // walls come first
        }
        options.want.areas = false;
        CHECK(test::run(set, options).face_areas().empty());
    }

    TEST_CASE("areas and volumes beyond the largest double are infinite, not NaN") {
        for (const double factor : {0x1p341, 0x1p360, 0x1p600}) {
            const test::PointSet set = test::scaled(test::uniform(300, 33), factor);
            const auto t = test::run(set);
            CHECK_FALSE(std::isnan(t.stats().volume_sum));
            CHECK(t.stats().volume_sum == t.stats().box_volume);
            for (const double volume : t.volumes()) REQUIRE(volume > 0);
            for (const double area : t.face_areas()) REQUIRE(area >= 0);
            CHECK(votess::verify(t, set.points).failure == "");
        }
    }

    TEST_CASE("areas that fit into doubles are finite, also in a domain whose far ends are beyond their squares") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        constexpr int exponent = 400;
        const test::PointSet set = test::uniform(40, 34), large = test::scaled(set, std::ldexp(1.0, exponent));
        const votess::Options options = test::all_options(test::cube(-inf, inf));
        const auto one = votess::tessellate(std::span<const double>(set.points), options);
        const auto other = votess::tessellate(std::span<const double>(large.points), options);
        REQUIRE(std::ranges::equal(one.indices(), other.indices()));
        std::size_t finite = 0;
        for (std::size_t f = 0; f < one.indices().size(); ++f) {
            const double area = std::ldexp(one.face_areas()[f], 2 * exponent);
            finite += std::isfinite(area) ? 1 : 0;
            if (std::isfinite(area))
                CHECK(other.face_areas()[f] == doctest::Approx(area).epsilon(1e-12));
            else
                CHECK(other.face_areas()[f] == inf);
        }
        CHECK(finite > one.indices().size() / 2);
    }

    TEST_CASE("normals: unit vectors, also between the nearest of doubles") {
        const double least = 0x1p-1074;
        const std::vector<test::Coordinates> sets{{0, 0, 0, least, least, 0},
                                                  {0, 0, 0, least, least, least},
                                                  {0, 0, 0, 3 * least, -2 * least, least},
                                                  {0, 0, 0, 0x1p-600, 0x1p-601, 0},
                                                  {0.25, 0.25, 0.25, 0.25, 0.25, 0.5}};
        for (const test::Coordinates& points : sets) {
            votess::Options options = test::all_options(test::cube(-1, 1));
            options.want.normals = true;
            const auto t = votess::tessellate(points, options);
            const auto normals = t.face_normals();
            REQUIRE(normals.size() == 3 * t.indices().size());
            for (std::size_t f = 0; f < t.indices().size(); ++f)
                CHECK(std::hypot(normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]) ==
                      doctest::Approx(1).epsilon(4e-16));
            const double length =
                std::hypot(points[3] * 0x1p500 - points[0] * 0x1p500, points[4] * 0x1p500 - points[1] * 0x1p500,
                           points[5] * 0x1p500 - points[2] * 0x1p500);
            const std::size_t last = t.neighbors(0).size() - 1;  // the other seed, behind the walls
            REQUIRE(t.neighbors(0)[last] == 1);
            for (std::size_t k = 0; k < 3; ++k)
                CHECK(normals[3 * last + k] ==
                      doctest::Approx((points[3 + k] * 0x1p500 - points[k] * 0x1p500) / length).epsilon(4e-16));
        }
    }

    TEST_CASE("areas: verify finds a wrong one") {
        const test::PointSet set = test::uniform(200, 34);
        const auto t = test::run(set);
        test::PointSet moved = set;  // the same lists, other areas
        moved.points[0] += 1e-7;
        votess::Options options = test::all_options(set.box);
        options.want = {.volumes = false, .areas = true};
        const auto u = votess::tessellate(moved.points, options);
        REQUIRE(std::ranges::equal(t.indices(), u.indices()));
        CHECK(votess::verify(u, moved.points, {200, 1}).passed);
        CHECK(votess::verify(u, set.points, {200, 1}).failure.find("area") != std::string::npos);
    }
}
