// Small enough for the thread sanitizer.
#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <memory>
#include <thread>
#include <utility>
#include <vector>
#include <votess/diagram.hpp>

#include "support/check.hpp"

namespace {

votess::Options with_threads(unsigned threads) {
    votess::Options options = test::all_options();
    options.threads = threads;
    return options;
}

}  // namespace

TEST_SUITE("threads") {
    TEST_CASE("threads: 1, 2, 4 and 7 threads give identical results") {
        const std::size_t n = test::by_size(20000, 1500);
        for (const test::PointSet& set :
             {test::uniform(n, 61), test::clustered(n, 62), test::cubic(test::by_size(20, 8)),
              test::with_duplicates(n, n / 10, 63), test::cospherical_and_center(101), test::uniform(3, 64)}) {
            CAPTURE(set.name);
            const auto one = test::run(set, with_threads(1));
            CHECK(one.stats().threads == 1);
            CHECK(test::check_invariants(one, set.points) == "");
            for (const unsigned threads : {2u, 4u, 7u}) {
                CAPTURE(threads);
                CHECK(test::check_identical(one, test::run(set, with_threads(threads))) == "");
            }
            CHECK(test::check_identical(one, test::run(set, with_threads(0))) == "");
        }
    }

    TEST_CASE("threads: measures do not depend on where stretches begin, to the last digit") {
        const std::size_t n = test::by_size(20000, 2500);
        for (const test::PointSet& set :
             {test::uniform(n, 68), test::clustered(n, 69), test::fcc(8), test::bcc(9),
              test::jittered(test::by_size(20, 12), 1e-5, 70), test::on_sphere(test::by_size(5000, 1000), 71)}) {
            CAPTURE(set.name);
            auto options = with_threads(1);
            options.box = set.box;
            options.want = {.neighbors = true, .volumes = true, .centroids = true, .areas = true};
            options.want.surfaces = options.want.radii = options.want.normals = true;
            const auto few = votess::tessellate(set.points, options);
            options.threads = 64;  // shorter ones
            CHECK(test::check_identical(few, votess::tessellate(set.points, options)) == "");
            options.threads = 2;
            options.grid_resolution = 7;  // another order of the seeds
            CHECK(test::check_identical(few, votess::tessellate(set.points, options)) == "");
        }
    }

    TEST_CASE("threads: different Tessellators in different threads are independent") {
        const test::PointSet sets[] = {test::uniform(test::by_size(4000, 500), 66), test::cubic(test::by_size(12, 6)),
                                       test::clustered(test::by_size(4000, 500), 67)};
        std::atomic<int> wrong = 0;
        {
            std::vector<std::jthread> running;
            for (const test::PointSet& set : sets)
                running.emplace_back([&] {
                    votess::Tessellator tessellator;
                    auto options = with_threads(4);
                    options.box = set.box;
                    for (int repeat = 0; repeat < 3; ++repeat) try {
                            if (test::check_invariants(tessellator.tessellate(set.points, options), set.points) != "")
                                ++wrong;
                        } catch (...) {
                            ++wrong;
                        }
                });
        }
        CHECK(wrong == 0);
    }

    TEST_CASE("threads: a Tessellator at work refuses a second thread") {
        const test::PointSet set = test::uniform(test::by_size(5000, 800), 71);
        const auto expected = test::run(set);
        votess::Tessellator tessellator;
        auto options = with_threads(2);
        options.box = set.box;
        std::atomic<bool> at_work = false, go_on = false;
        std::string failure = "none";
        {
            std::jthread worker([&] {
                auto waiting = options;
                waiting.progress = [&](double) {
                    at_work = true;
                    at_work.notify_all();
                    go_on.wait(false);
                    return true;
                };
                failure = test::check_identical(expected, tessellator.tessellate(set.points, waiting));
            });
            at_work.wait(false);
            for (int repeat = 0; repeat < 3; ++repeat)
                CHECK(test::error_of([&] { (void)tessellator.tessellate(set.points, options); }) ==
                      votess::ErrorCode::invalid_use);
            const auto elsewhere = votess::Tessellator().tessellate(set.points, options);
            CHECK(test::check_identical(expected, elsewhere) == "");
            go_on = true;
            go_on.notify_all();
        }
        CHECK(failure == "");
        CHECK(test::check_identical(expected, tessellator.tessellate(set.points, options)) == "");
    }

    TEST_CASE("threads: many at one Tessellator get the right answer or the error") {
        const test::PointSet set = test::uniform(500, 72);
        const auto expected = test::run(set);
        votess::Tessellator tessellator;
        auto options = with_threads(2);
        options.box = set.box;
        std::atomic<int> right = 0, refused = 0, wrong = 0;
        {
            std::vector<std::jthread> running;
            for (int k = 0; k < 4; ++k)
                running.emplace_back([&] {
                    for (int repeat = 0; repeat < 50; ++repeat) try {
                            const auto t = tessellator.tessellate(set.points, options);
                            ++(test::check_identical(expected, t) == "" ? right : wrong);
                        } catch (const votess::Error& error) {
                            ++(error.code() == votess::ErrorCode::invalid_use ? refused : wrong);
                        }
                });
        }
        CHECK(wrong == 0);
        CHECK(right > 0);
        CHECK(right + refused == 200);
    }

    TEST_CASE("threads: a callback cannot use its Tessellator, but others, and may destroy it") {
        const test::PointSet set = test::uniform(test::by_size(5000, 800), 73);
        const auto expected = test::run(set);
        auto tessellator = std::make_unique<votess::Tessellator>();
        auto options = with_threads(2), plain = with_threads(2);
        options.box = plain.box = set.box;
        int calls = 0, good = 0;
        const auto try_all = [&] {
            ++calls;
            good += test::error_of([&] { (void)tessellator->tessellate(set.points, plain); }) ==
                        votess::ErrorCode::invalid_use &&
                    test::check_identical(expected, votess::tessellate(set.points, plain)) == "";
        };
        options.progress = [&](double) {
            try_all();
            return true;
        };
        options.log = [&](std::string_view) { try_all(); };
        CHECK(test::check_identical(expected, tessellator->tessellate(set.points, options)) == "");
        CHECK(calls >= 2);
        CHECK(good == calls);
        options.progress = [&](double) {
            tessellator.reset();
            return true;
        };
        options.log = {};
        CHECK(test::check_identical(expected, tessellator->tessellate(set.points, options)) == "");
        CHECK_FALSE(tessellator);
    }

    TEST_CASE("threads: a result is read from many threads") {
        const test::PointSet set = test::uniform(1000, 68);
        const auto t = test::run(set, with_threads(4));
        std::atomic<std::size_t> total = 0;
        {
            std::vector<std::jthread> readers;
            for (int k = 0; k < 4; ++k)
                readers.emplace_back([&total, t] {
                    for (std::size_t i = 0; i < t.size(); ++i) total += t.neighbors(i).size();
                });
        }
        CHECK(total == 4 * t.indices().size());
    }

    TEST_CASE("threads: a Diagram is asked from many at the same time, and has any number of its own") {
        const auto set = test::uniform(test::by_size(5000, 1000), 9);
        const auto queries = test::uniform(test::by_size(20000, 2000), 10).points;
        votess::Options options;
        options.box = test::unit_box();
        options.threads = 1;
        const votess::Diagram alone(set.points, options);
        const auto expected = alone.locate(queries);
        const auto cells = alone.probe(queries);
        const auto coordinates = alone.natural_neighbors(queries);
        options.threads = 3;
        const votess::Diagram diagram(set.points, options);
        struct Found {
            std::vector<std::int32_t> located;
            votess::Tessellation cells;
            votess::NaturalCoordinates coordinates;
        };
        std::array<Found, 4> found;
        std::vector<std::thread> threads;
        for (Found& one : found)
            threads.emplace_back([&, copy = diagram] {
                one.located = copy.locate(queries);
                one.cells = copy.probe(queries);
                one.coordinates = copy.natural_neighbors(queries);
            });
        for (std::thread& thread : threads) thread.join();
        for (const Found& one : found) {
            CHECK(one.located == expected);
            CHECK(std::ranges::equal(one.cells.indices(), cells.indices()));
            CHECK(one.coordinates.indptr == coordinates.indptr);
            CHECK(one.coordinates.indices == coordinates.indices);
        }
    }
}
