// Small enough for the thread sanitizer.
#include <doctest/doctest.h>

#include <atomic>
#include <thread>

#include "../support/check.hpp"

namespace {

votess::Options with_threads(unsigned threads) {
    votess::Options options = test::all_options();
    options.threads = threads;
    return options;
}

}  // namespace

TEST_SUITE("threads") {
    TEST_CASE("1, 2, 4 and 7 threads give identical results") {
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

    TEST_CASE("one Tessellator, changing numbers of threads") {
        const test::PointSet set = test::uniform(test::by_size(5000, 800), 65);
        const auto expected = test::run(set);
        votess::Tessellator tessellator;
        for (const unsigned threads : {4u, 1u, 3u, 4u, 4u, 2u}) {
            auto options = with_threads(threads);
            options.box = set.box;
            CHECK(test::check_identical(expected, tessellator.tessellate(set.points, options)) == "");
        }
    }

    TEST_CASE("different Tessellators in different threads are independent") {
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

    TEST_CASE("a result is read from many threads") {
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

    TEST_CASE("cancelling with 4 threads leaves a usable Tessellator") {
        const test::PointSet set = test::uniform(test::by_size(300000, 60000), 69);
        votess::Tessellator tessellator;
        auto options = with_threads(4);
        options.box = set.box;
        options.progress = [](double) { return false; };
        try {
            const auto t = tessellator.tessellate(set.points, options);
            FAIL("was not cancelled");
        } catch (const votess::Error& error) {
            CHECK(error.code() == votess::ErrorCode::cancelled);
        }
        const test::PointSet small = test::uniform(500, 70);
        options.progress = {};
        CHECK(test::check_invariants(tessellator.tessellate(small.points, options), small.points) == "");
    }
}
