// Promises of votess.hpp that are not about geometry.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "result/result.hpp"
#include "support/check.hpp"

namespace {

// The result of an engine with another precision, whose volumes are all larger by this factor.
votess::Tessellation with_error(const votess::Tessellation& t, votess::Precision precision, double factor) {
    const auto copy = [](auto& to, const auto& from) {
        to.resize_uninitialized(from.size());
        std::ranges::copy(from, to.begin());
    };
    auto result = std::make_shared<votess::detail::Result>();
    result->box = t.box();
    copy(result->indptr, t.indptr());
    copy(result->indices, t.indices());
    copy(result->status, t.status());
    copy(result->volumes, t.volumes());
    for (double& volume : result->volumes) volume *= factor;
    result->stats = t.stats();
    result->stats.volume_sum *= factor;
    result->stats.precision = precision;
    return votess::Tessellation(std::move(result));
}

}  // namespace

TEST_SUITE("api") {
    TEST_CASE("a Tessellator used again gives identical results") {
        votess::Tessellator tessellator;
        const std::vector<test::PointSet> sets{test::uniform(3000, 81), test::cubic(5),
                                               test::uniform(10, 82),   test::clustered(2000, 83),
                                               test::cospherical(101),  test::uniform(3000, 81)};
        for (int round = 0; round < 2; ++round)
            for (const test::PointSet& set : sets) {
                CAPTURE(set.name);
                const auto options = test::all_options(set.box);
                CHECK(test::check_identical(test::run(set), tessellator.tessellate(set.points, options)) == "");
            }
        votess::Tessellator moved = std::move(tessellator);
        CHECK(test::check_identical(test::run(sets[0]),
                                    moved.tessellate(sets[0].points, test::all_options(sets[0].box))) == "");
    }

    TEST_CASE("a Tessellator whose wants change gives what a new one gives") {
        const test::PointSet set = test::uniform(test::by_size(3000, 400), 85);
        votess::Tessellator tessellator;
        auto options = test::all_options(set.box);
        for (const unsigned bits : {1u, 16u, 0u, 31u, 2u, 8u, 17u, 4u, 31u}) {
            CAPTURE(bits);
            options.want = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, (bits & 16) != 0};
            CHECK(test::check_identical(votess::tessellate(set.points, options),
                                        tessellator.tessellate(set.points, options)) == "");
        }
    }

    TEST_CASE("a result outlives its Tessellator and its copies") {
        const test::PointSet set = test::uniform(500, 84);
        const auto expected = test::run(set);
        votess::Tessellation kept;
        {
            votess::Tessellator tessellator;
            const auto t = tessellator.tessellate(set.points, test::all_options(set.box));
            kept = t;
            const auto other = tessellator.tessellate(test::uniform(700, 85).points);
            CHECK(other.size() == 700);
        }
        CHECK(test::check_identical(expected, kept) == "");
    }

    TEST_CASE("a default-constructed Tessellation is empty") {
        const votess::Tessellation t;
        CHECK(t.size() == 0);
        CHECK(t.indices().empty());
        CHECK(t.volumes().empty());
        CHECK(t.status().empty());
        CHECK(t.stats().points == 0);
    }

    TEST_CASE("the default options give neighbors and volumes, without walls") {
        const test::PointSet set = test::uniform(200, 86);
        const auto t = votess::tessellate(set.points);
        CHECK(t.indptr().size() == 201);
        CHECK(t.volumes().size() == 200);
        CHECK(t.centroids().empty());
        CHECK(t.face_counts().empty());
        CHECK_FALSE(t.lists_walls());
        CHECK(t.stats().device != "");
        CHECK(t.stats().threads >= 1);
        CHECK(t.stats().seconds.total > 0);
        CHECK(test::check_invariants(t, set.points) == "");
    }

    TEST_CASE("stats") {
        const test::PointSet set = test::cubic(8);
        const auto t = test::run(set);
        CHECK(t.stats().points == 512);
        CHECK(t.stats().faces == 512 * 6);
        CHECK(t.stats().mean_faces == 6);
        CHECK(t.stats().box_volume == 512);
        CHECK(t.stats().exact_cells > 0);  // a lattice is all ties
        CHECK(test::run(test::uniform(500, 87)).stats().fallback_cells == 0);
    }

    TEST_CASE("progress grows from 0 to 1, false cancels") {
        const test::PointSet set = test::uniform(test::by_size(200000, 40000), 88);
        votess::Options options = test::all_options(set.box);
        std::vector<double> seen;
        options.progress = [&](double fraction) {
            seen.push_back(fraction);
            return true;
        };
        CHECK(votess::tessellate(set.points, options).size() == set.size());
        REQUIRE_FALSE(seen.empty());
        CHECK(std::is_sorted(seen.begin(), seen.end()));
        CHECK(seen.front() >= 0);
        CHECK(seen.back() <= 1);

        votess::Tessellator tessellator;
        options.progress = [](double) { return false; };
        try {
            const auto t = tessellator.tessellate(set.points, options);
            FAIL("was not cancelled");
        } catch (const votess::Error& error) {
            CHECK(error.code() == votess::ErrorCode::cancelled);
        }
        options.progress = {};
        const test::PointSet small = test::uniform(300, 89);
        CHECK(test::check_identical(test::run(small), tessellator.tessellate(small.points, options)) == "");
    }

    TEST_CASE("an exception of the caller's callback comes through") {
        const test::PointSet set = test::uniform(test::by_size(200000, 40000), 90);
        votess::Tessellator tessellator;
        votess::Options options = test::all_options(set.box);
        options.progress = [](double) -> bool { throw std::logic_error("mine"); };
        CHECK_THROWS_WITH_AS((void)tessellator.tessellate(set.points, options), "mine", std::logic_error);
        options.progress = {};
        const test::PointSet small = test::uniform(300, 91);
        CHECK(test::check_identical(test::run(small), tessellator.tessellate(small.points, options)) == "");
    }

    TEST_CASE("devices") {
        const auto all = votess::devices();
        REQUIRE_FALSE(all.empty());
        CHECK(std::any_of(all.begin(), all.end(), [](const auto& device) { return device.id == "cpu"; }));
        for (const auto& device : all) {
            CHECK(device.name != "");
            votess::Options options;
            options.device = device.id;
            CHECK(votess::tessellate(test::uniform(50, 92).points, options).size() == 50);
        }
    }

    TEST_CASE("verify passes a good result and fails on points that do not belong") {
        const test::PointSet set = test::uniform(400, 93), other = test::uniform(400, 94);
        const auto t = test::run(set);
        CHECK(votess::verify(t, set.points).passed);
        CHECK(votess::verify(t, set.points, {400, 7}).passed);
        const auto report = votess::verify(t, other.points);
        CHECK_FALSE(report.passed);
        CHECK(report.failure != "");
        CHECK(report.failure.find('\n') == std::string::npos);
        CHECK_THROWS_AS((void)votess::verify(t, std::span(set.points).first(3 * 399)), votess::Error);
        CHECK_THROWS_AS((void)votess::verify(t, std::span(set.points).first(3 * 400 - 1)), votess::Error);

        // One seed moved a little: only the sample can see it, and must when it takes every cell.
        test::Coordinates moved = set.points;
        moved[3 * 200] += moved[3 * 200] < 0.5 ? 0.05 : -0.05;
        CHECK_FALSE(votess::verify(t, moved, {400, 1}).passed);
    }

    TEST_CASE("verify allows the errors of the precision, no more") {
        const test::PointSet set = test::uniform(400, 96);
        votess::Options options;
        options.device = "cpu";
        options.box = set.box;
        const auto t = votess::tessellate(set.points, options);
        CHECK(t.stats().precision == votess::Precision::double_);
        const auto passes = [&](votess::Precision precision, double error, std::size_t sample) {
            return votess::verify(with_error(t, precision, 1 + error), set.points, {sample, 1}).passed;
        };
        using enum votess::Precision;
        for (const double sign : {1.0, -1.0}) {
            CHECK(passes(double_, sign * 1e-11, 400));
            CHECK_FALSE(passes(double_, sign * 5e-10, 400));  // cells
            CHECK(passes(double_, sign * 5e-10, 0));
            CHECK_FALSE(passes(double_, sign * 2e-9, 0));  // sum
            CHECK(passes(single, sign * 9e-6, 400));
            CHECK_FALSE(passes(single, sign * 2e-5, 400));
            CHECK(passes(single, sign * 9e-5, 0));
            CHECK_FALSE(passes(single, sign * 2e-4, 0));
        }
    }

    TEST_CASE("verify names what it skips") {
        const test::PointSet set = test::uniform(300, 95);
        votess::Options options;
        options.threads = 1;
        options.want = {false, false, false, false};
        const auto nothing = votess::verify(test::run(set, options), set.points);
        CHECK(nothing.passed);
        CHECK(nothing.skipped.size() == 4);
        options.want = {true, true, false, false};
        const auto usual = votess::verify(test::run(set, options), set.points);
        CHECK(usual.passed);
        CHECK(usual.skipped == std::vector<std::string>{"euler"});
    }
}
